//! Dead band, resolution and response times from the recorded valve position in a test.
//!
//! # Definitions
//! These follow ANSI/ISA-75.25.01, "Test procedure for control valve response measurement from step inputs" (recalled,
//! the edition was not read):
//!
//! * Dead band is the OP change after a reversal before the stem moves (S of this project).
//! * Resolution is the OP change in the same direction before the stem moves again (J).
//! * Dead time Td is the time until the stem begins to move. T63 and T86 are the times until it has covered 63.2 and
//!   86.5 % of its travel, including Td.
//!
//! OP changes are measured from the OP at which the stem last moved. The stem has moved with a turn if its mean over
//! the last third of the hold has changed. The change must exceed four standard deviations of the noise and 0.05 % of
//! span.
//!
//! # Limits
//! A turn shows only whether an OP change moves the stem. So both lie between the largest change that did not and the
//! smallest that did. Times are from turns that moved the stem by 2 % or more, with an accuracy of one sample.

use super::weigh::Manual;
use crate::series::{mean, median, noise_std};
use crate::spoken::{counted, rough, time};

/// The OP change that moves the stem, percent, as an interval between two turns.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Between {
    /// The largest change that did not move the stem; 0 if every change moved it.
    pub above: f64,
    /// The smallest change that moved the stem; `None` if none did.
    pub up_to: Option<f64>,
}

/// Results from the valve position.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct PositionReading {
    /// The OP change after a reversal at which the stem begins to move, percent; `None` without a reversal.
    pub dead_band: Option<Between>,
    /// The OP change in one direction at which the stem moves again, percent; `None` if each turn is a reversal.
    pub resolution: Option<Between>,
    /// Median time until the stem begins to move, s; `None` if no turn moved the stem by 2 % or more.
    pub dead_time_s: Option<f64>,
    /// Median time until the stem has covered 63.2 % of the travel, s.
    pub t63_s: Option<f64>,
    /// Median time until the stem has covered 86.5 % of the travel, s.
    pub t86_s: Option<f64>,
    /// Number of turns in the medians of the times.
    pub timed: usize,
}

impl PositionReading {
    /// The results in sentences.
    pub(super) fn reasons(&self) -> Vec<String> {
        let of = |what: &str, between: Option<Between>| {
            between.map(|between| match between {
                Between { above, up_to: Some(up_to) } => {
                    format!(
                        "the {what} of the stem is between {} and {} %",
                        rough(above),
                        rough(up_to)
                    )
                }
                Between { above, up_to: None } => {
                    format!("the {what} of the stem is above {} %", rough(above))
                }
            })
        };
        let mut all: Vec<String> =
            [of("dead band", self.dead_band), of("resolution", self.resolution)]
                .into_iter()
                .flatten()
                .collect();
        if let (Some(dead), Some(t63), Some(t86)) = (self.dead_time_s, self.t63_s, self.t86_s) {
            all.push(format!(
                "in {} the stem began to move after {} and covered 63 % of its travel after {} and 86 % after {} (medians)",
                counted(self.timed, "turn"),
                time(dead),
                time(t63),
                time(t86)
            ));
        }
        all
    }
}

/// Smallest stem travel that counts as a move, percent, and in standard deviations of the noise.
const LEAST: f64 = 0.05;
const SURE: f64 = 4.0;
/// Smallest stem travel of a timed turn, percent, and in standard deviations of the noise.
const TIMED: f64 = 2.0;
const CLEAR: f64 = 10.0;
/// Share of the travel at which the stem begins to move.
const BEGINS: f64 = 0.05;
const T63: f64 = 0.632;
const T86: f64 = 0.865;

/// Effects of the turns on the stem.
#[derive(Default)]
struct Found {
    reversals: Vec<(f64, bool)>,
    onward: Vec<(f64, bool)>,
    times: Vec<[f64; 3]>,
}

/// Results from the valve position in the times in manual, with a sample every `dt` s; `None` without two turns.
pub(super) fn position(spells: &[Manual], dt: f64) -> Option<PositionReading> {
    let mut found = Found::default();
    let all: Vec<f64> = spells.iter().flat_map(|spell| spell.pv.iter().copied()).collect();
    let noise = noise_std(&all);
    for spell in spells {
        found.see(spell, noise, dt);
    }
    if found.reversals.is_empty() && found.onward.is_empty() {
        return None;
    }
    let of = |k: usize| -> Option<f64> {
        let times: Vec<f64> = found.times.iter().map(|times| times[k]).collect();
        (!times.is_empty()).then(|| median(&times))
    };
    Some(PositionReading {
        dead_band: between(&found.reversals),
        resolution: between(&found.onward),
        dead_time_s: of(0),
        t63_s: of(1),
        t86_s: of(2),
        timed: found.times.len(),
    })
}

impl Found {
    fn see(&mut self, spell: &Manual, noise: f64, dt: f64) {
        // The OP when the stem last moved, and the direction.
        let mut last: Option<(f64, f64)> = None;
        let ends = spell.turns.iter().skip(1).map(|turn| turn.0).chain([spell.pv.len()]);
        let mut rest: Option<f64> = None;
        for ((from, op), to) in spell.turns.iter().zip(ends) {
            let held = &spell.pv[*from..to.max(*from)];
            if held.len() < 3 {
                continue;
            }
            let now = mean(&held[held.len() - held.len().div_ceil(3)..]);
            let way = now - rest.unwrap_or(held[0]);
            let moved = way.abs() > (SURE * noise).max(LEAST);
            if let (Some((at, up)), Some(_)) = (last, rest) {
                let distance = op - at;
                let of = if distance * up < 0.0 { &mut self.reversals } else { &mut self.onward };
                if distance != 0.0 {
                    of.push((distance.abs(), moved));
                }
                if moved && way.abs() > TIMED.max(CLEAR * noise) {
                    let start = rest.unwrap_or(held[0]);
                    let at = |share: f64| crossed(held, start, way, share) * dt;
                    self.times.push([at(BEGINS), at(T63), at(T86)]);
                }
            }
            if moved {
                last = Some((*op, way.signum()));
            }
            rest = Some(now);
        }
    }
}

/// Number of samples until the stem has covered this share of its travel.
fn crossed(held: &[f64], start: f64, way: f64, share: f64) -> f64 {
    let gone = |x: f64| (x - start) / way;
    let k = held.iter().position(|x| gone(*x) >= share).unwrap_or(held.len());
    let Some(before) = k.checked_sub(1) else { return 0.0 };
    match held.get(k) {
        Some(x) if gone(*x) > gone(held[before]) => {
            before as f64 + (share - gone(held[before])) / (gone(*x) - gone(held[before]))
        }
        _ => k as f64,
    }
}

/// The interval in which the stem begins to move: from the largest change without a move to the smallest with one.
fn between(of: &[(f64, bool)]) -> Option<Between> {
    let moved = of.iter().filter(|(_, moved)| *moved).map(|(distance, _)| *distance);
    let up_to = moved.fold(f64::INFINITY, f64::min);
    let still = of.iter().filter(|(distance, moved)| !moved && *distance < up_to);
    let above = still.map(|(distance, _)| *distance).fold(0.0, f64::max);
    let up_to = up_to.is_finite().then_some(up_to);
    (!of.is_empty()).then_some(Between { above, up_to })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bands::Bands;
    use crate::valve::{Model, Start, Valve};

    /// Turns of a valve with this S and J, each held for 20 samples; the stem follows with this lag, samples.
    fn stroked(op: &[f64], s: f64, j: f64, lag: f64) -> Manual {
        let mut valve = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
        valve.restart(Start::at_rest(50.0));
        let mut stem = 50.0;
        let mut pv = vec![];
        for op in op {
            for _ in 0..20 {
                stem += (valve.step(*op) - stem) * (1.0 - (-1.0 / lag).exp());
                pv.push(stem);
            }
        }
        let turns = op.iter().enumerate().map(|(k, op)| (20 * k, *op)).collect();
        Manual { pv, before: 50.0, turns }
    }

    #[test]
    fn dead_band_and_resolution_lie_between_turns() {
        // Shrinking turns, then small steps in one direction.
        let half = |k: u32| 3.0 - 0.125 * f64::from(k);
        let mut op: Vec<f64> =
            (0..22).map(|k| 60.0 + if k % 2 == 1 { -half(k) } else { half(k) }).collect();
        op.extend((1..20).map(|k| 70.0 + 0.3 * f64::from(k)));
        let found = position(&[stroked(&op, 3.0, 1.0, 0.5)], 2.0).unwrap();
        let band = found.dead_band.unwrap();
        assert!(band.above < 3.0 && 3.0 <= band.up_to.unwrap(), "{band:?}");
        assert!(band.up_to.unwrap() - band.above < 0.6, "{band:?}");
        let on = found.resolution.unwrap();
        assert!(on.above < 1.0 && 1.0 <= on.up_to.unwrap() + 1e-9, "{on:?}");
    }

    #[test]
    fn times_are_those_of_a_lag() {
        let op: Vec<f64> = (0..10).map(|k| if k % 2 == 0 { 60.0 } else { 50.0 }).collect();
        let found = position(&[stroked(&op, 0.0, 0.0, 4.0)], 1.0).unwrap();
        // The first sample of a turn is already one step later.
        assert!((found.t63_s.unwrap() - 3.0).abs() < 0.3, "{found:?}");
        assert!((found.t86_s.unwrap() - 7.0).abs() < 0.4, "{found:?}");
        assert!(found.dead_time_s.unwrap() < 1.0 && found.timed == 9);
    }

    #[test]
    fn a_stem_that_never_moves_has_a_limit_only() {
        let op: Vec<f64> = (0..10).map(|k| if k % 2 == 0 { 53.0 } else { 47.0 }).collect();
        assert_eq!(position(&[stroked(&op, 40.0, 0.0, 1.0)], 1.0), None);
    }
}
