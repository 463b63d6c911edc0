//! Whether the PV does not respond: the OP travels far without effect on the PV.
//!
//! A loop that compensates a drifting load also has an OP that travels and a PV that rests, but at its set point. So a
//! resting PV counts only if it rests *away* from its set point while the OP moves in one direction, as integral action
//! on a constant error must. A PV that moves without relation to the OP is left to the evidence, which was trained on
//! simulated stuck valves.

use super::reasons::{alternatives, sayings};
use super::verdict::{Basis, DEAD_ZONE_BELOW, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use crate::fusion::Cause;
use crate::recording::Segment;
use crate::recording::fitness::{Class, Fitness, MeasureId, levels};
use crate::series::{mean, noise_std, span, std};
use crate::spoken::{percent, rough};
use stiction_model::named;

named! {
    /// The behaviour of a PV that does not respond.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Silence {
        /// It rests at its lowest value, below its set point.
        AtItsLowEnd = "PV at its low end",
        /// It rests at its highest value, above its set point.
        AtItsHighEnd = "PV at its high end",
        /// It is frozen exactly at a value between.
        Frozen = "PV frozen",
        /// It moves, but not with the OP.
        Unmoved = "PV moves without the OP",
    }
}

named! {
    /// Why a PV may not respond.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Fault {
        /// The valve is shut fast, seized, or has no power.
        ValveShutOrSeized = "valve shut fast or seized",
        /// A block valve in the line is shut, or the unit is out of service.
        LineIsolated = "line isolated",
        /// The positioner has lost its air or its signal.
        AirOrSignalLost = "air or signal lost",
        /// The transmitter is dead or frozen, or its impulse line is plugged.
        SensorDead = "sensor dead or frozen",
        /// The historian has stopped, or its compression removes the movement of the PV.
        HistorianStopped = "historian stopped",
        /// The flow goes through a bypass, or the valve is on its hand wheel.
        BypassOrHandwheel = "bypass open or hand wheel engaged",
    }
}

impl Fault {
    /// How to distinguish this fault from the others.
    pub fn check(self) -> &'static str {
        match self {
            Self::ValveShutOrSeized => "the stem does not move although the actuator pressure does",
            Self::LineIsolated => "the stem moves without any flow; check block valves and pumps",
            Self::AirOrSignalLost => {
                "neither stem nor actuator pressure moves; measure air supply and current at the positioner"
            }
            Self::SensorDead => {
                "the stem moves and other measurements of the line respond, but the transmitter's own display does \
                 not"
            }
            Self::HistorianStopped => "the control room's display moves while the record does not",
            Self::BypassOrHandwheel => {
                "the stem moves, or is held by hand, and the flow stays constant; check the bypass and the hand \
                 wheel"
            }
        }
    }

    /// The possible faults, the likeliest first. The order is ours, by the effect of each fault on a signal.
    pub fn behind(silence: Silence) -> &'static [Self] {
        use Fault::*;
        match silence {
            Silence::AtItsLowEnd => &[ValveShutOrSeized, LineIsolated, AirOrSignalLost, SensorDead],
            Silence::AtItsHighEnd => {
                &[SensorDead, ValveShutOrSeized, AirOrSignalLost, BypassOrHandwheel]
            }
            Silence::Frozen => &[SensorDead, HistorianStopped],
            Silence::Unmoved => {
                &[ValveShutOrSeized, AirOrSignalLost, BypassOrHandwheel, LineIsolated]
            }
        }
    }
}

/// The behaviour of a PV that does not respond to the OP.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct NoResponse {
    /// The behaviour of the PV: `PV at its low end`, `PV at its high end`, `PV frozen` or `PV moves without the
    /// OP`.
    pub silence: Silence,
    /// Whether the verdict is based on this behaviour.
    pub decides: bool,
    /// The time in which the PV rests and the OP travels farthest; `None` if the PV moves.
    pub rest: Option<Rest>,
    /// Possible faults, the likeliest first.
    #[cfg_attr(feature = "serde", serde(serialize_with = "documents"))]
    #[cfg_attr(feature = "serde", schemars(with = "Vec<FaultDocument>"))]
    pub faults: &'static [Fault],
}

impl NoResponse {
    /// Combines a rest, if any, with the verdict "does not respond"; `None` with neither.
    pub(super) fn of(rest: Option<Rest>, decides: bool) -> Option<Self> {
        let silence = match rest {
            Some(rest) => rest.silence,
            None if decides => Silence::Unmoved,
            None => return None,
        };
        Some(Self { silence, decides, rest, faults: Fault::behind(silence) })
    }
}

/// A possible fault that explains why the PV does not respond.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
#[schemars(rename = "Fault")]
struct FaultDocument {
    /// Name, such as `line isolated`.
    name: &'static str,
    /// How to distinguish this fault from the others.
    told_by: &'static str,
}

#[cfg(feature = "serde")]
fn documents<S: serde::Serializer>(faults: &[Fault], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(
        faults.iter().map(|fault| FaultDocument { name: fault.name(), told_by: fault.check() }),
    )
}

/// A time in which the PV rests, away from its set point, while the OP travels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Rest {
    /// The behaviour of the PV.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub silence: Silence,
    /// Beginning, s on the recording's clock.
    pub from_s: f64,
    /// End, s on the recording's clock.
    pub to_s: f64,
    /// Samples.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub samples: usize,
    /// OP travel in this time, percent.
    pub op_travel: f64,
    /// Mean of SP less PV in this time, in units of the PV.
    pub error: f64,
    /// Whether this time alone is enough to name the fault.
    pub overwhelming: bool,
}

/// Smallest share of the segment in which the PV rests.
const RESTS: f64 = 0.2;
/// Smallest OP travel, percent: a tenth of span. The load of a calm loop seldom needs so much in one rest.
const FAR: f64 = 10.0;
/// Smallest OP travel in multiples of its noise.
const NOISES: f64 = 20.0;
/// Smallest share of that travel in one direction: the OP winds up and does not swing.
const ONE_WAY: f64 = 0.8;
/// Smallest distance of the PV from its set point, in its smallest steps or standard deviations of its noise.
const AWAY: f64 = 10.0;
/// Share of the OP's span above which no loop can hold its PV to the last digit. Such a rest is enough to name the
/// fault.
const OVERWHELMING: f64 = 20.0;
/// Probability from which the evidence alone gives "does not respond"; our own choice. `docs/accuracy.md` reports how
/// often that is right.
pub const NAMED_FROM: f64 = 0.7;
/// Probability from which the evidence gives it if the PV is constant.
const SUPPORTED_FROM: f64 = 0.2;
/// The evidence alone gives it only if saturation is less probable than this.
const SATURATION_BELOW: f64 = 0.2;
/// Reasons for unfit data that a PV that does not respond causes by itself.
const BY_ITSELF: [MeasureId; 8] = [
    MeasureId::Cycles,
    MeasureId::SamplesPerCycle,
    MeasureId::OpAtLimit,
    MeasureId::PvLevels,
    MeasureId::LongestFrozenPv,
    MeasureId::ClippedPv,
    MeasureId::PvMoves,
    MeasureId::PvUpdatesPerCycle,
];

impl Rest {
    /// Finds the rest of the PV in which the OP travels farthest. The result is `None` without a rest, or without a set
    /// point to compare the PV with.
    pub fn of(segment: &Segment) -> Option<Self> {
        let (op, pv, sp) = (&segment.op, segment.pv.as_ref()?, segment.sp.as_ref()?);
        let n = op.len().min(pv.len()).min(sp.len());
        let (op, pv, sp) = (&op[..n], &pv[..n], &sp[..n]);
        let (low, high) =
            pv.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        if !(span(op) >= FAR && low.is_finite() && high.is_finite()) {
            return None;
        }
        // If the PV never moves, its smallest step is unknown, and any distance beyond rounding counts.
        let quantum = match levels(pv) {
            Some(levels) => (high - low) / (levels - 1.0).max(1.0),
            None => 1e-6 * low.abs().max(sp.iter().fold(0.0, |m: f64, v| m.max(v.abs()))) / AWAY,
        };
        let noise = noise_std(op);
        let at = |sample: usize| segment.from + sample as f64 * segment.sample_time;
        let mut best: Option<Self> = None;
        let mut first = 0;
        for run in pv.chunk_by(|a, b| (a - b).abs() <= 1e-9 * (high - low)) {
            let part = first..first + run.len();
            first = part.end;
            if (run.len() as f64) < RESTS * n as f64 {
                continue;
            }
            let (u, r) = (&op[part.clone()], &sp[part.clone()]);
            let (travel, net) = (span(u), (u[u.len() - 1] - u[0]).abs());
            let errors: Vec<f64> = r.iter().map(|r| r - run[0]).collect();
            let error = mean(&errors);
            let one_sided = errors.iter().all(|e| e.signum() == error.signum());
            let away = error.abs() > AWAY * quantum + std(&errors);
            if travel < FAR.max(NOISES * noise) || net < ONE_WAY * travel || !one_sided || !away {
                continue;
            }
            let silence = match () {
                () if run[0] <= low && error > 0.0 => Silence::AtItsLowEnd,
                () if run[0] >= high && error < 0.0 => Silence::AtItsHighEnd,
                () => Silence::Frozen,
            };
            if best.is_none_or(|best| travel > best.op_travel) {
                best = Some(Self {
                    silence,
                    from_s: at(part.start),
                    to_s: at(part.end),
                    samples: part.len(),
                    op_travel: travel,
                    error,
                    overwhelming: travel >= OVERWHELMING,
                });
            }
        }
        best
    }

    fn sentence(&self, sample_time: f64) -> String {
        format!(
            "the OP travels {:.0} % in {:.0} s while the PV rests {} away from its set point: the controller winds \
             up without a response",
            self.op_travel,
            self.samples as f64 * sample_time,
            rough(self.error.abs())
        )
    }
}

/// The verdict that the valve does not respond; `None` if it does not apply. Data may be unfit for reasons that
/// such a loop causes by itself.
///
/// The verdict is given in three cases: a rest alone is overwhelming, the evidence gives a probability of
/// [`NAMED_FROM`] or more, or the PV rests and the evidence gives a probability of a fifth. The evidence alone counts
/// only if the PV moves, and OP and PV look like signals of one loop and like the training loops. Play elsewhere and
/// saturation must be unlikely.
pub(super) fn verdict(
    rest: Option<&Rest>,
    sample_time: f64,
    weighing: Option<&Weighing>,
    fitness: &Fitness,
    votes: Votes,
) -> Option<Verdict> {
    let mut unfit = fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    if !unfit.all(|m| BY_ITSELF.contains(&m.id)) {
        return None;
    }
    let likelihood = weighing.map_or(0.0, |weighing| weighing.likelihood(Cause::NoResponse));
    // Exchanged columns and signals of two loops do not respond to each other either.
    let belong = weighing.is_none_or(|of| of.mismatch <= 1.0 && of.distance <= 1.0);
    // A dead zone elsewhere and an OP at its limit also keep the PV from responding.
    let alone = weighing.is_some_and(|of| {
        of.likelihood(Cause::DeadZoneElsewhere) < DEAD_ZONE_BELOW
            && of.likelihood(Cause::Saturation) < SATURATION_BELOW
    });
    // An integrating controller winds up if its PV never moves. If it does not wind up, it sees a different PV from
    // the recorded one, and nothing is known of its valve.
    let still =
        fitness.measures.iter().any(|m| m.id == MeasureId::PvMoves && m.class == Class::Unfit);
    let named = match rest {
        Some(rest) => rest.overwhelming || (belong && likelihood >= SUPPORTED_FROM),
        None => !still && belong && alone && likelihood >= NAMED_FROM,
    };
    if !named {
        return None;
    }
    let silence = rest.map_or(Silence::Unmoved, |rest| rest.silence);
    let mut reasons = vec![match rest {
        Some(rest) => rest.sentence(sample_time),
        None => format!(
            "the OP travels, but the PV moves without relation to the OP (no response: {})",
            percent(likelihood)
        ),
    }];
    let faults: Vec<&str> = Fault::behind(silence).iter().map(|fault| fault.name()).collect();
    reasons.push(format!(
        "{}: likely faults, in this order, are {}",
        silence.name(),
        faults.join("; ")
    ));
    if let Some(weighing) = weighing {
        reasons.extend(sayings(weighing).into_iter().map(|saying| saying.sentence));
    }
    Some(Verdict {
        class: VerdictClass::DoesNotRespond,
        basis: Basis::Evidence,
        probability: weighing.map(|weighing| weighing.probability),
        votes,
        reasons,
        alternatives: weighing
            .map_or(vec![], |weighing| alternatives(weighing, Some(Cause::NoResponse))),
        ..Verdict::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{DiagnoseOptions, diagnose};
    use crate::recording::{Grid, GridOptions, Recording};

    fn segment(op: &[f64], pv: &[f64], sp: &[f64]) -> Segment {
        let recording = Recording::regular("", 10.0, op, Some(pv), Some(sp)).unwrap();
        Grid::of(&recording, &GridOptions::default()).unwrap().longest().unwrap().clone()
    }

    fn ramp(from: f64, to: f64) -> Vec<f64> {
        (0..720).map(|k| from + (to - from) * f64::from(k) / 719.0).collect()
    }

    #[test]
    fn a_pv_that_rests_at_zero_below_its_set_point_does_not_respond() {
        let (op, pv, sp) = (ramp(5.0, 80.0), vec![0.0; 720], vec![40.0; 720]);
        let rest = Rest::of(&segment(&op, &pv, &sp)).unwrap();
        assert_eq!(rest.silence, Silence::AtItsLowEnd);
        assert!(rest.overwhelming && rest.op_travel > 70.0 && rest.error == 40.0);
        let recording = Recording::regular("", 10.0, &op, Some(&pv), Some(&sp)).unwrap();
        let diagnosis = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
        assert_eq!(diagnosis.verdict.class, VerdictClass::DoesNotRespond);
        assert!(diagnosis.verdict.reasons.iter().any(|reason| reason.contains("shut")));
    }

    #[test]
    fn units_and_sign_do_not_matter() {
        let (op, sp) = (ramp(60.0, 20.0), vec![40.0; 720]);
        let pv: Vec<f64> =
            (0..720).map(|k| if k < 60 { 39.0 + 0.1 * f64::from(k % 3) } else { 35.0 }).collect();
        let one = Rest::of(&segment(&op, &pv, &sp)).unwrap();
        let other = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| 1000.0 - 8.0 * v).collect() };
        let two = Rest::of(&segment(&op, &other(&pv), &other(&sp))).unwrap();
        assert_eq!((one.silence, two.silence), (Silence::AtItsLowEnd, Silence::AtItsHighEnd));
        assert_eq!((one.from_s, one.to_s, one.op_travel), (two.from_s, two.to_s, two.op_travel));
    }

    #[test]
    fn a_pv_held_flat_at_its_set_point_is_normal() {
        let op = ramp(20.0, 80.0);
        assert_eq!(Rest::of(&segment(&op, &[50.0; 720], &[50.0; 720])), None);
        // Nor is one that rests within its resolution of it.
        let pv: Vec<f64> = (0..720).map(|k| if k % 350 == 349 { 49.5 } else { 50.0 }).collect();
        assert_eq!(Rest::of(&segment(&op, &pv, &[50.3; 720])), None);
        // Nor an OP that swings, or hardly moves.
        let swing: Vec<f64> = (0..720).map(|k| 50.0 + 20.0 * (f64::from(k) * 0.1).sin()).collect();
        assert_eq!(Rest::of(&segment(&swing, &[0.0; 720], &[50.0; 720])), None);
        assert_eq!(Rest::of(&segment(&ramp(50.0, 55.0), &[0.0; 720], &[50.0; 720])), None);
    }

    #[test]
    fn every_silence_has_its_faults() {
        for silence in
            [Silence::AtItsLowEnd, Silence::AtItsHighEnd, Silence::Frozen, Silence::Unmoved]
        {
            assert!(!Fault::behind(silence).is_empty() && !silence.name().is_empty());
        }
        for fault in Fault::ALL {
            assert!(!fault.name().is_empty() && !fault.check().is_empty());
        }
    }
}
