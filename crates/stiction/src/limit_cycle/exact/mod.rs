//! DOC

mod flow;
mod number;
mod orbit;
mod plant;
mod search;
mod series;

use super::{ContinuousLoop, Cycle};
use crate::bands::Bands;
use crate::error::{Error, Result, finite};
use crate::valve::{HeWang, Model};
use flow::Stem;
use orbit::Shooting;
use plant::Plant;
use search::{End, Search};
use std::fmt;

/// What became of the search for cycles of a loop.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// It cycles.
    Cycles {
        /// The cycles that were found: those that attract first, each sort with growing OP amplitude.
        cycles: Vec<Cycle>,
        /// What other motions do that do not end in a cycle.
        beside: Vec<NoCycle>,
        /// Why another motion could not be followed to its end, if there was one.
        unsettled: Option<String>,
    },
    /// It does not: every motion that was followed ended otherwise.
    None {
        /// How they ended, each way once.
        reasons: Vec<NoCycle>,
    },
    /// Whether it cycles is not known.
    NotFound {
        /// What failed.
        reason: String,
    },
}

impl Outcome {
    /// The cycles that were found, none if there are none.
    pub fn cycles(&self) -> &[Cycle] {
        match self {
            Self::Cycles { cycles, .. } => cycles,
            _ => &[],
        }
    }

    /// The attracting cycle, if just one was found.
    pub fn attractor(&self) -> Option<&Cycle> {
        let mut stable = self.cycles().iter().filter(|cycle| cycle.stable);
        stable.next().filter(|_| stable.next().is_none())
    }
}

/// Why a motion ends in no cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoCycle {
    /// The valve does not stick.
    NoFriction,
    /// A valve with dead band alone: strokes and OP amplitude shrink to nothing.
    Decays {
        /// What is left of a stroke at the next.
        ratio: f64,
    },
    /// It comes to rest.
    Rests {
        /// Whether the stem creeps to its last position, following an OP that never turns; else it
        /// is stuck, and the OP comes to rest within the static friction band.
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
                "decays: with dead band alone each stroke is {ratio:.3} of the one before"
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

/// A valve model as the flow sees it: its stem, and how much OP is 1. `None` if it does not stick.
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
    // Steps of no size are a slide.
    let stem = if factor == 0.0 || bands.j() == 0.0 {
        Stem::Follows { fd: bands.fd() / unit }
    } else {
        Stem::Jumps { jump: factor * bands.j() / unit }
    };
    Ok(Some((stem, unit)))
}

const NO_FRICTION: NoCycle = NoCycle::NoFriction;

/// The cycle in which a loop ends from near its equilibrium.
///
/// # Errors
/// If the loop is not one that can be computed exactly; the message says why.
pub fn cycle(l: &ContinuousLoop) -> Result<Outcome> {
    let Some((stem, unit)) = stem(l.model, l.bands)? else {
        return Ok(Outcome::None { reasons: vec![NO_FRICTION] });
    };
    let plant = Plant::new(l, unit)?;
    let mut search = Search::new(&plant, stem, unit);
    let (state, position) = search.first();
    let end = search.follow(state, position);
    Ok(search.outcome(vec![end]))
}

/// All cycles that motions from near the equilibrium to far outside the friction bands meet.
///
/// # Errors
/// As [`cycle`].
pub fn cycles(l: &ContinuousLoop) -> Result<Outcome> {
    let Some((stem, unit)) = stem(l.model, l.bands)? else {
        return Ok(Outcome::None { reasons: vec![NO_FRICTION] });
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

/// The member of the family of cycles of a stem that jumps (He's, Stenman's) whose positions lie
/// `offset` percent above those of the symmetric member.
///
/// # Errors
/// If the valve model has no family, or as [`cycle`].
pub fn member(l: &ContinuousLoop, offset: f64) -> Result<Outcome> {
    finite("offset", offset)?;
    let Some((stem, unit)) = stem(l.model, l.bands)? else {
        return Ok(Outcome::None { reasons: vec![NO_FRICTION] });
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
    let nowhere = |reason: &str| Ok(Outcome::NotFound { reason: reason.to_owned() });
    let Some(symmetric) = symmetric.filter(|orbit| orbit.map.direction < 0.0) else {
        return nowhere("the symmetric member of the family was not found");
    };
    // From member to member, in strides that are halved where one fails.
    let map = Shooting { slips: 2 * symmetric.map.slips, direction: 1.0, ..symmetric.map };
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
                return Ok(Outcome::NotFound {
                    reason: format!(
                        "the family could be followed to an offset of {} %, no further: beyond, \
                         the stem slips more often, or rests for less than the dead time",
                        done * offset
                    ),
                });
            }
            None => stride *= 0.5,
        }
    }
    match orbit.cycle(unit) {
        Some(cycle) => Ok(Outcome::Cycles { cycles: vec![cycle], beside: vec![], unsettled: None }),
        None => nowhere("the member of the family could not be measured"),
    }
}
