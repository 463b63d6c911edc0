//! Exact limit cycles: the flow of the loop from slip to slip, and its periodic orbits.
//!
//! # What it computes
//! Period, amplitudes, middles and Floquet multipliers of the limit cycles of a linear process of any order with
//! dead time under a P, PI or PID controller. The valve is a two-phase one (also Kano's, Choudhury's, the play) or
//! one that moves only in slips (He's, He and Wang's, Stenman's). If a loop has no cycle, the reason is given; if
//! none could be found, the result is "not known". [`cycle`] follows one motion and is fast, [`cycles`] follows
//! many, [`member`] follows a family.
//!
//! # Assumptions
//! As for [`ContinuousLoop`]. The process has no direct feedthrough, and a derivative without filter needs a process
//! whose numerator is two degrees below its denominator, so that the OP is continuous. The OP stays off its limits.
//!
//! # Equations
//! **The linear part.** Relative to the equilibrium without friction, where VP = OP, the set point, the load and
//! its weights drop out, and the loop is its own mirror image:
//! ```text
//! w' = A w + B x(t - theta)        u = C w
//! ```
//! `w` holds process, integral and filter of the derivative, `u` is the OP, `x` the VP. OP and VP count
//! in `fs`, time in the inverse of the largest eigenvalue of `A` and `A + B C`.
//!
//! **The valve.** Stuck, `x` is constant until `|u - x|` rises through `fs`. Then, with `d` the sign of
//! `u - x`,
//! ```text
//! two-phase:  x = u - d fd, until d du/dt falls through zero; then it is stuck
//! He:         x moves on by d J, and is stuck at once (He and Wang: by d K J)
//! ```
//! These are the sampled models as the sample time goes to 0: there the slip follows the crossing within a sample, and
//! the turn likewise. The OP turns smoothly, or by a jump of `du/dt` when an earlier slip reaches a process of first
//! order. At a jump the stem stops at that instant.
//!
//! **The flow.** The loop with a moving stem is a delay equation. Its input is the OP one dead time earlier. It is
//! solved segment by segment (method of steps). Over a segment the input is a power series, known from the past, and
//! the states are power series too,
//! ```text
//! w(k+1) = (A w(k) + B x(k)) / (k + 1)
//! ```
//! cut after the 20th power. A segment is at most 1 long in the unit of time above, so that the omitted terms are of
//! the order `1 / 21!`, which is below a double's rounding. It is longer where the last terms are below `1e-17` even
//! then, for example with only slow modes left. Segments also end with the piece of the past that the process sees.
//! Without dead time a moving stem closes the loop, `x(k) = u(k)` except for the offset. An event is where a power
//! series rises through zero. Segments are halved until the coefficients prove that a segment contains one event or
//! none. Newton's method then finds the event in its bracket. Extremes are found in the same way, in the derivative.
//!
//! **The event map.** Consider a slip before which the stem was stuck for a dead time. Then the process only receives
//! the position before the slip, which is `C w - d fs`, so `w` alone determines the future. The map `P` takes it from
//! one such slip to the slip `n` slips later. The result is multiplied by the sign of the slip, so that every slip is
//! upward. A cycle is a fixed point. If the last slip is downward, the fixed point is half of a symmetric cycle; else
//! it is all of one. Newton's method solves `P(w) = w`. The derivative of `P` comes from the same code in numbers with
//! derivatives: through the series, and through the times of events by the implicit function theorem, `dt = -dg / g'`
//! for the event `g = 0`. This includes the jumps of the variational equation (saltation).
//!
//! **Stability.** The eigenvalues of the derivative of `P` at the fixed point, squared if it is half a cycle, are the
//! Floquet multipliers over a period. The event removes the direction along the cycle, and the position removes the
//! second trivial direction. If all are within the unit circle, the cycle attracts. A stem that moves only in slips
//! keeps its position before a slip except for steps of J: one multiplier is 1, and cycles form a family with the
//! offset of the positions as parameter. Each can only attract towards the family. The same holds for a two-phase stem
//! if the OP turns at the slip itself. Along the family Newton's method uses a given position.
//!
//! **The closed form** for a controller that cancels the process, its derivation and its map `a(n+1) = J - (1 - q)
//! a(n)`: [`CancelledLoop`]. If it applies, the search starts there.
//!
//! # Verdicts
//! A motion is followed from slip to slip, with Newton's method from some of its states. It can end at a nearby
//! attracting cycle, at rest, with dead band alone in shrinking strokes, or in growth beyond the influence of
//! friction. Otherwise its end is not known. Along every motion `|u - x| <= fs`, so friction is a bounded disturbance of the
//! linear loop. A loop therefore diverges only if it is unstable without friction. It does so once its fastest
//! growing mode `z`, of rate `s` in `z' = s z - (u - x)`, exceeds the largest possible effect of `u - x`: `1 / re
//! s`, or less if it oscillates.
//!
//! # Limits
//! * [`cycle`] gives the end of one motion: a loop may have other ends. [`cycles`] starts some tens of motions of
//!   very different size; no finite number proves that there is nothing else. Unstable cycles are those met by
//!   Newton's method. In 19 of 60 random loops a cycle and a motion to rest both attract. Halving the interval
//!   between initial states with different ends 30 times met no orbit: they are separated by whether the OP ever
//!   turns, not by a repelling orbit.
//! * If the stem never rests for a dead time, the state at a slip is a function, not a vector. Then a cycle is found
//!   only by following the motion until it repeats to 1e-11. Slow motion is extrapolated. It attracts, and its
//!   multipliers are not known.
//! * A motion that slides to rest needs an OP that never turns. The smallest noise ends such a motion, and the loop
//!   then cycles.
//! * A sampled loop differs by the order of its sample time, and not smoothly.
//! * A process or filter far faster than the cycle costs steps; beyond 200,000 the motion is reported as not
//!   settled.
//!
//! # References
//! E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer, 1993, for the
//! method of steps, and Ya. Z. Tsypkin's relay theory for the family of He's valve (both recalled,
//! not read). The map of the two-phase valve and its closed form were derived for this project.
//!
//! ```
//! use stiction_model::Bands;
//! use stiction_model::closed_loop::{Controller, Process};
//! use stiction_model::limit_cycle::{ContinuousLoop, exact};
//! use stiction_model::valve::Model;
//!
//! let sticky = ContinuousLoop::new(
//!     Controller::pi(1.1, 2.5)?,
//!     Process::first_order(1.5, 5.93, 1.07)?,
//!     Model::TwoPhase,
//!     Bands::from_s_j(5.0, 3.0)?,
//! );
//! let outcome = exact::cycle(&sticky)?;
//! let cycle = outcome.attractor().expect("it cycles");
//! assert!((cycle.period_s - 18.04367).abs() < 1e-5);
//! assert!((cycle.half_pp.op - 3.108014).abs() < 1e-6);
//! # Ok::<(), stiction_model::Error>(())
//! ```

mod flow;
mod growth;
mod number;
mod orbit;
mod plant;
mod search;
mod series;

use super::{CancelledLoop, ContinuousLoop, Cycle};
use crate::bands::Bands;
use crate::error::{Error, Result, finite};
use crate::valve::{HeWang, Model};
use flow::Stem;
use orbit::{PATIENCE, Shooting};
use plant::Plant;
use search::{End, Search};
use std::fmt;

/// The result of the search for cycles of a loop.
#[derive(Debug, Clone, PartialEq)]
pub enum CycleOutcome {
    /// It cycles.
    Cycles {
        /// The cycles found: attracting ones first, each sort with growing OP amplitude.
        cycles: Vec<Cycle>,
        /// The ends of other motions that are not a cycle.
        beside: Vec<NoCycle>,
        /// Why a motion could not be followed to its end, if any.
        unsettled: Option<String>,
    },
    /// It does not cycle: every motion ended differently.
    None {
        /// The ends, each kind once.
        reasons: Vec<NoCycle>,
    },
    /// Whether it cycles is not known.
    NotFound {
        /// The failure.
        reason: String,
    },
}

impl CycleOutcome {
    /// The cycles found; empty if the loop has none.
    pub fn cycles(&self) -> &[Cycle] {
        match self {
            Self::Cycles { cycles, .. } => cycles,
            _ => &[],
        }
    }

    /// The attracting cycle, if exactly one was found.
    pub fn attractor(&self) -> Option<&Cycle> {
        let mut stable = self.cycles().iter().filter(|cycle| cycle.stable);
        stable.next().filter(|_| stable.next().is_none())
    }
}

/// Why a motion does not end in a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoCycle {
    /// The valve does not stick.
    NoFriction,
    /// A valve with dead band alone: strokes and OP amplitude shrink to zero.
    Decays {
        /// Ratio of a stroke to the previous stroke.
        ratio: f64,
    },
    /// It comes to rest.
    Rests {
        /// Whether the stem creeps to its last position, following an OP that never turns. Otherwise it is stuck,
        /// and the OP comes to rest within the static friction band.
        moving: bool,
    },
    /// It grows without bound: the loop is unstable even without friction.
    Diverges,
}

impl fmt::Display for NoCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFriction => f.write_str("the valve does not stick: the loop is linear"),
            Self::Decays { ratio } => write!(
                f,
                "decays: with dead band alone each stroke is {ratio:.3} of the stroke before"
            ),
            Self::Rests { moving: true } => f.write_str(
                "comes to rest: the OP approaches its final value without turning, so that the \
                 stem follows it and never sticks",
            ),
            Self::Rests { moving: false } => f.write_str(
                "comes to rest: the OP stays within the static friction band of the stuck stem",
            ),
            Self::Diverges => {
                f.write_str("diverges: the loop is unstable, with friction and without")
            }
        }
    }
}

/// A valve model for the flow: its stem, and the OP unit. `None` if it does not stick.
fn stem(model: Model, bands: Bands) -> Result<Option<(Stem, f64)>> {
    let (bands, factor) = match model {
        Model::TwoPhase | Model::Kano => (bands, 0.0),
        Model::Choudhury => (bands.without_overshoot()?, 0.0),
        Model::Play => (Bands::from_s_j(bands.s(), 0.0)?, 0.0),
        Model::He => (bands, 1.0),
        Model::HeWang => (bands.without_overshoot()?, HeWang::TYPICAL_OVERSHOOT),
        Model::Stenman => (Bands::from_s_j(bands.j(), bands.j())?, 1.0),
        Model::Ideal => return Ok(None),
        Model::Chen => {
            return Err(Error::Inconsistent(
                "Chen's model has no limit for a short sample time: its reversals are a sample late"
                    .to_owned(),
            ));
        }
    };
    let unit = bands.fs();
    if unit == 0.0 {
        return Ok(None);
    }
    // Steps of size zero are a slide.
    let stem = if factor == 0.0 || bands.j() == 0.0 {
        Stem::Follows { fd: bands.fd() / unit }
    } else {
        Stem::Jumps { jump: factor * bands.j() / unit }
    };
    Ok(Some((stem, unit)))
}

/// The final cycle of a loop that starts near its equilibrium.
///
/// # Errors
/// If the loop cannot be computed exactly; the message gives the reason.
pub fn cycle(l: &ContinuousLoop) -> Result<CycleOutcome> {
    let Some((stem, unit)) = stem(l.model, l.bands)? else {
        return Ok(CycleOutcome::None { reasons: vec![NoCycle::NoFriction] });
    };
    let plant = Plant::new(l, unit)?;
    let mut search = Search::new(&plant, stem, unit);
    let end = first_end(l, &mut search);
    Ok(search.only(end))
}

/// The end of the motion that starts near the equilibrium, or on the cycle if that is known.
fn first_end(l: &ContinuousLoop, search: &mut Search<'_>) -> End {
    let (mut state, mut position) = search.first();
    if let (Stem::Follows { .. }, Some(closed)) =
        (search.stem, CancelledLoop::of(l).and_then(|known| known.cycle(l.bands)))
    {
        position = -closed.vp / search.op_unit;
        state = search.plant.resting(position, position + 1.0);
    }
    search.follow(state, position)
}

/// One period of a motion.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    /// Times since a slip upward, s; where the VP jumps, the same time occurs twice.
    pub time_s: Vec<f64>,
    /// OP, percent.
    pub op: Vec<f64>,
    /// VP, percent.
    pub vp: Vec<f64>,
    /// PV, in its units.
    pub pv: Vec<f64>,
}

/// The final cycle of a loop, as [`cycle`] finds it, over one period: at `samples` equally spaced times, and at every
/// slip and every stop of the stem. `None` without a cycle.
///
/// The values come from the flow: exact at each time, not interpolated.
///
/// # Errors
/// If `samples` is 0, or as [`cycle`].
pub fn trajectory(l: &ContinuousLoop, samples: usize) -> Result<Option<(Cycle, Trajectory)>> {
    if samples == 0 {
        return Err(Error::Parameter {
            name: "samples of a period",
            value: 0.0,
            allowed: "at least 1".to_owned(),
        });
    }
    let Some((stem, unit)) = stem(l.model, l.bands)? else { return Ok(None) };
    let plant = Plant::new(l, unit)?;
    let mut search = Search::new(&plant, stem, unit);
    let End::Orbit(index) = first_end(l, &mut search) else { return Ok(None) };
    let found = &search.found[index];
    let trajectory = found.trajectory(samples, unit).ok_or_else(|| {
        Error::Inconsistent(
            "the cycle was found, but could not be followed over one period".to_owned(),
        )
    })?;
    Ok(Some((found.cycle.clone(), trajectory)))
}

/// All cycles met by motions from near the equilibrium to far outside the friction bands.
///
/// # Errors
/// As [`cycle`].
pub fn cycles(l: &ContinuousLoop) -> Result<CycleOutcome> {
    let Some((stem, unit)) = stem(l.model, l.bands)? else {
        return Ok(CycleOutcome::None { reasons: vec![NoCycle::NoFriction] });
    };
    let plant = Plant::new(l, unit)?;
    let mut search = Search::new(&plant, stem, unit);
    let mut ends: Vec<End> = vec![];
    let first = search.first();
    for (state, position) in std::iter::once(first).chain(search.starts()) {
        ends.push(search.follow(state, position));
    }
    Ok(search.outcome(ends))
}

/// A member of the family of cycles of a stem that jumps (He's, Stenman's). Its positions lie `offset` percent above
/// the positions of the symmetric member.
///
/// # Errors
/// If the valve model has no family, or as [`cycle`].
pub fn member(l: &ContinuousLoop, offset: f64) -> Result<CycleOutcome> {
    finite("offset", offset)?;
    let Some((stem, unit)) = stem(l.model, l.bands)? else {
        return Ok(CycleOutcome::None { reasons: vec![NoCycle::NoFriction] });
    };
    if !matches!(stem, Stem::Jumps { .. }) {
        return Err(Error::Inconsistent(
            "a stem that follows the OP has single cycles, not a family of them".to_owned(),
        ));
    }
    let plant = Plant::new(l, unit)?;
    let mut search = Search::new(&plant, stem, unit);
    let (state, position) = search.first();
    let end = search.follow(state, position);
    let symmetric = match end {
        End::Orbit(index) => search.found[index].orbit.clone(),
        _ => return Ok(search.outcome(vec![end])),
    };
    let nowhere = |reason: &str| Ok(CycleOutcome::NotFound { reason: reason.to_owned() });
    let Some(symmetric) = symmetric.filter(|orbit| orbit.map.direction < 0.0) else {
        return nowhere("the symmetric member of the family was not found");
    };
    // From member to member, in steps that are halved where one fails.
    let map = Shooting {
        slips: 2 * symmetric.map.slips,
        direction: 1.0,
        patience: PATIENCE,
        ..symmetric.map
    };
    let start = plant.op(&symmetric.state) - 1.0;
    let mut orbit = match map.orbit_at(&symmetric.state, Some(start)) {
        Some(orbit) => orbit,
        None => return nowhere("the symmetric member of the family does not repeat itself"),
    };
    let (mut done, mut stride) = (0.0, 1.0);
    while done < 1.0 {
        let next = f64::min(done + stride, 1.0);
        match map.orbit_at(&orbit.state, Some(start + next * offset / unit)) {
            Some(member) => {
                (orbit, done) = (member, next);
                stride *= 2.0;
            }
            None if stride < 1e-3 => {
                return Ok(CycleOutcome::NotFound {
                    reason: format!(
                        "the family could be followed to an offset of {} %, no further: beyond this offset, the stem slips \
                         more often, or rests for less than the dead time",
                        done * offset
                    ),
                });
            }
            None => stride *= 0.5,
        }
    }
    match orbit.cycle(unit) {
        Some(cycle) => {
            Ok(CycleOutcome::Cycles { cycles: vec![cycle], beside: vec![], unsettled: None })
        }
        None => nowhere("the member of the family could not be measured"),
    }
}
