//! Moves that bring the stem to a position and leave it there: the common part of the two-, three- and six-move
//! methods.

use super::steady_op::SteadyOp;
use super::{Compensator, Instant, Method, Sent};
use crate::Number;
use crate::bands::Bands;
use crate::error::{Error, Result, finite, non_negative, positive};

/// Moves of the stem.
///
/// # Equations
/// To bring the stem to `target` in two moves, from the side `d` (+1 from above):
/// ```text
/// signal = target + d reach    for hold_s      away, beyond the target
/// signal = target - d fd       from then on    back: a stem that moves trails its input by fd
/// ```
/// In three moves `target - d reach` comes first. The last move breaks the stem away if `reach > fs`; the move
/// before it does so from any position that a cycle can leave if `reach >= 2 fs = S + J`. From then on the position
/// of the stem does not depend on its history.
///
/// The target is the valve position that holds the set point: the steady OP. It is given, or estimated while the OP
/// still goes to the valve unchanged: the mean OP over whole periods of the cycle, once two consecutive periods
/// agree. Until then the compensator waits.
///
/// # Limits
/// While the signal is held the loop is open. The controller, which has followed the signal, takes over again if
/// the control error, averaged over the last quarter of each `settle_s`, exceeds `release`, or at any sample four
/// times as much. Then the steady OP is estimated again. If the error continues to correct the target, the loop is
/// closed and no release is needed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moves {
    /// Estimated stiction of the valve. Without friction nothing is moved.
    pub bands: Bands,
    /// The steady OP, percent of span; `None` to estimate it.
    pub steady_op: Option<f64>,
    /// Distance of a move beyond the target, percent of span; 0 for no moves at all.
    pub reach: f64,
    /// Hold time of each move except the last, s: the time that the stem needs.
    pub hold_s: f64,
    /// Time after the first move at which the PV has settled enough to be judged, s.
    pub settle_s: f64,
    /// Control error at which the controller takes over again, in PV units; `None` for half the largest error
    /// before the moves.
    pub release: Option<f64>,
    /// Largest difference between the means of two periods in an estimate of the steady OP, percent of span.
    pub agree: f64,
    /// Memory of large control errors for finding the periods, s.
    pub memory_s: f64,
}

impl Moves {
    /// Default reach over `S + J`: enough for bands estimated a third too small.
    pub const REACH: f64 = 1.5;

    /// Moves for a valve with these bands: a reach of 1.5 (S + J), held for 0.1 s, judged after 30 s, a steady OP
    /// accurate to S / 5, errors remembered for 60 s.
    pub fn new(bands: Bands) -> Self {
        Self {
            bands,
            steady_op: None,
            reach: Self::REACH * 2.0 * bands.fs(),
            hold_s: 0.1,
            settle_s: 30.0,
            release: None,
            agree: 0.2 * bands.s(),
            memory_s: 60.0,
        }
    }

    fn check(&self, moves: usize) -> Result<()> {
        if let Some(op) = self.steady_op {
            finite("steady OP", op)?;
        }
        if let Some(error) = self.release {
            positive("error at which the moves are given up", error)?;
        }
        non_negative("reach of the moves", self.reach)?;
        positive("time for which a move is held", self.hold_s)?;
        positive("time to settle after the moves", self.settle_s)?;
        non_negative("agreement of the steady OP", self.agree)?;
        positive("memory of the steady OP", self.memory_s)?;
        if !(self.settle_s > moves as f64 * self.hold_s) {
            return Err(Error::Inconsistent(format!(
                "{moves} moves of {} s take longer than the {} s after which they are judged",
                self.hold_s, self.settle_s
            )));
        }
        Ok(())
    }
}

/// The correction of the target by the PV.
///
/// # Equations
/// At the end of each interval `W = settle_s`, with the mean `pv` over its last quarter:
/// ```text
/// |sp - pv| > zone or memory |pv_before - pv| > zone:
///     target = target + (memory (pv_before - pv) + pace (sp - pv)) / gain
/// ```
/// This is an integral controller at the sample time `W` for a self-regulating process that settles within it
/// (`memory = 0`), and a PI controller for a slower one. `gain` is the response of the process to a unit
/// step after `W`. `memory` is the share of a deviation that remains one interval later, `(response after 2W) /
/// (response after W) - 1`, which is 1 for an integrator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// Response of the process to a unit step after one interval; PV units per percent.
    pub gain: f64,
    /// Share of a deviation that remains after one interval, 0 to 1.
    pub memory: f64,
    /// Share of the control error that one correction removes, above 0 and at most 1.
    pub pace: f64,
    /// Control error without correction, in PV units.
    pub zone: f64,
}

impl Correction {
    fn check(&self) -> Result<()> {
        finite("gain of the correction", self.gain)?;
        let (gain, memory, pace) = (self.gain, self.memory, self.pace);
        let refuse = |name, value, allowed: &str| {
            Err(Error::Parameter { name, value, allowed: allowed.to_owned() })
        };
        if gain == 0.0 {
            return refuse("gain of the correction", gain, "other than 0");
        }
        if !(0.0..=1.0).contains(&memory) {
            return refuse("memory of the correction", memory, "between 0 and 1");
        }
        if !(pace > 0.0 && pace <= 1.0) {
            return refuse("pace of the correction", pace, "above 0 and at most 1");
        }
        non_negative("zone of the correction", self.zone)?;
        Ok(())
    }
}

/// The difference between the methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plan {
    pub method: Method,
    /// 2 or 3.
    pub moves: usize,
    /// The correction of the target, and its largest number.
    pub correction: Option<(Correction, usize)>,
    /// Whether to begin at once with the present OP, without an estimate.
    pub eager: bool,
}

/// Moves the stem, holds the signal, corrects it, and releases it.
#[derive(Debug)]
pub(super) struct Mover {
    settings: Moves,
    plan: Plan,
    steady: SteadyOp,
    held: Option<Held>,
}

/// A held signal.
#[derive(Debug, Clone, Copy)]
struct Held {
    target: f64,
    /// Side of the approach: +1 from above.
    side: f64,
    /// Start of the moves, s.
    since: f64,
    /// Start of the interval at whose end the PV is judged, s.
    interval: f64,
    /// Sum and number of the PV in its last quarter.
    sum: f64,
    count: f64,
    /// Mean PV in the interval before.
    before: Option<f64>,
    corrections: usize,
    release: f64,
}

impl Mover {
    pub(super) fn start(settings: Moves, plan: Plan) -> Result<Box<dyn Compensator>> {
        settings.check(plan.moves)?;
        if let Some((correction, _)) = &plan.correction {
            correction.check()?;
        }
        let steady = SteadyOp::new(settings.agree, settings.memory_s);
        Ok(Box::new(Self { settings, plan, steady, held: None }))
    }

    /// The first held signal, if the target is known.
    fn begin(&self, now: &Instant) -> Option<Held> {
        let known = self.settings.steady_op.or(self.steady.value());
        let target = known.or(self.plan.eager.then_some(now.op))?;
        let peak = self.steady.peak();
        let half_the_peak = if peak > 0.0 { 0.5 * peak } else { f64::INFINITY };
        Some(Held {
            target,
            side: if now.op < target { -1.0 } else { 1.0 },
            since: now.time_s,
            interval: now.time_s,
            sum: 0.0,
            count: 0.0,
            before: None,
            corrections: self.plan.correction.map_or(0, |(_, times)| times),
            release: self.settings.release.unwrap_or(half_the_peak),
        })
    }

    /// Judges the PV at the end of an interval; `None` to release.
    fn judged(&self, mut held: Held, now: &Instant) -> Option<Held> {
        if !self.plan.eager && now.error().abs() > 4.0 * held.release {
            return None;
        }
        let passed = now.time_s - held.interval;
        if passed >= 0.75 * self.settings.settle_s {
            held.sum += now.pv;
            held.count += 1.0;
        }
        // Sums of sample times have rounding errors.
        if passed < self.settings.settle_s * (1.0 - 1e-9) {
            return Some(held);
        }
        let pv = held.sum / held.count;
        let error = now.sp - pv;
        match self.plan.correction {
            Some((correction, _)) if held.corrections > 0 => {
                let drift = correction.memory * (held.before.unwrap_or(pv) - pv);
                if error.abs().max(drift.abs()) > correction.zone {
                    held.target += (drift + correction.pace * error) / correction.gain;
                    held.corrections -= 1;
                    held.since = now.time_s;
                }
            }
            _ if error.abs() > held.release => return None,
            _ => {}
        }
        (held.before, held.interval, held.sum, held.count) = (Some(pv), now.time_s, 0.0, 0.0);
        Some(held)
    }

    fn signal(&self, held: &Held, now: &Instant) -> f64 {
        let Moves { bands, reach, hold_s, .. } = self.settings;
        let made = ((now.time_s - held.since) / hold_s + 1e-9).floor();
        let left = self.plan.moves as f64 - 1.0 - made;
        let beyond = match left {
            left if left <= 0.0 => -bands.fd(),
            left if left > 1.0 => -reach,
            _ => reach,
        };
        held.target + held.side * beyond
    }
}

impl Compensator for Mover {
    fn method(&self) -> Method {
        self.plan.method
    }

    fn parameters(&self) -> Vec<Number> {
        let Moves { bands, reach, hold_s, settle_s, .. } = self.settings;
        let mut parameters = vec![
            Number::new("S", bands.s(), "%"),
            Number::new("J", bands.j(), "%"),
            Number::new("reach", reach, "%"),
            Number::new("hold", hold_s, "s"),
            Number::new("settle", settle_s, "s"),
        ];
        let target = self.held.map(|held| held.target).or(self.settings.steady_op);
        parameters.extend(target.map(|op| Number::new("steady OP", op, "%")));
        if let Some((correction, _)) = self.plan.correction {
            parameters.extend([
                Number::new("gain", correction.gain, "PV/%"),
                Number::new("memory", correction.memory, ""),
                Number::new("pace", correction.pace, ""),
                Number::new("zone", correction.zone, "PV"),
            ]);
        }
        parameters
    }

    fn reset(&mut self) {
        self.steady.reset();
        self.held = None;
    }

    fn watch(&mut self, now: &Instant) {
        self.steady.take(now);
    }

    fn step(&mut self, now: &Instant) -> Sent {
        if self.settings.reach == 0.0 {
            return Sent::added(now.op);
        }
        self.held = match self.held {
            None => {
                self.steady.take(now);
                self.begin(now)
            }
            Some(held) => {
                let held = self.judged(held, now);
                if held.is_none() {
                    self.steady.reset();
                }
                held
            }
        };
        match &self.held {
            Some(held) => Sent::held(self.signal(held, now)),
            None => Sent::added(now.op),
        }
    }
}
