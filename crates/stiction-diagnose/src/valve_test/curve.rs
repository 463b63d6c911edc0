//! The characteristic of a process with its valve, from a staircase: the settled PV over the OP, rising and falling.
//!
//! # Equations
//! A stem that trails the OP by b in the direction of motion leads to settled values of a characteristic f
//!
//! ```text
//! y = f(u - b) rising,    y = f(u + b) falling    =>    f^-1(y) = (u_rising(y) + u_falling(y)) / 2
//! ```
//! The distance of the branches corresponds to a candidate stem: 2 b = S - J if its steps are larger than J.
//!
//! Both branches are fitted by monotone regression (Ayer, Brunk, Ewing, Reid and Silverman 1955, recalled, not read). The
//! PV becomes f^-1(PV), the position of a stem on a straight line, so that a nonlinear valve
//! characteristic does not matter.
//!
//! What the PV lacks at the end of a hold is a share of its answer. That share follows from the sums of all holds, whose
//! thirds approach the end geometrically, and completes each settled value.
//!
//! # Limits
//! In a hold the PV must come near its end. A PV that still moves by more than half as much from the second third to
//! the last as from the first to the second has no characteristic. Each direction must have at least three settled
//! levels. The first level after a reversal does not count, because it may lie within the stick band.

use super::stems::Stem;
use super::weigh::Manual;
use crate::series::{correlation, median, noise_std};

/// Fewest settled levels in one direction, and fewest samples of a hold.
const FEWEST: usize = 3;
const HELD: usize = 6;
/// Share of turns that continue in one direction.
const IN_RUNS: f64 = 0.5;
/// Largest ratio of the moves from third to third of a hold.
const STILL: f64 = 0.5;
/// A PV moves from the second third to the last of a hold by more than this, in standard deviations and as a share of
/// its answer.
const MOVES: (f64, f64) = (3.0, 0.1);
/// Levels of the PV at which the branches are compared.
const LEVELS: usize = 48;
/// Additional error of the distance of the branches besides the error of its median, percent and as a share of the
/// distance: no process repeats exactly.
const INEXACT: (f64, f64) = (0.1, 0.05);
/// Degrees of freedom of Student's t for that distance.
const FREEDOM: f64 = 6.0;
/// The stem is within these positions, percent.
const STROKE: (f64, f64) = (-10.0, 110.0);
/// Least correlation of settled PV and OP.
const RELATED: f64 = 0.8;

/// The characteristic of a process: the PV over the position of the stem.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    /// Positions, percent, and PV; both ascend, the PV times `sign`.
    points: Vec<(f64, f64)>,
    sign: f64,
    /// Distance of the falling branch from the rising one, percent of OP.
    pub apart: f64,
    /// Standard deviation.
    error: f64,
}

/// The turns of a time in manual that follow one in the same direction, with that direction.
fn kept(turns: &[(usize, f64)]) -> impl Iterator<Item = (usize, f64)> {
    turns.windows(3).enumerate().filter_map(|(k, three)| {
        let (last, this) = (three[1].1 - three[0].1, three[2].1 - three[1].1);
        (last * this > 0.0).then_some((k + 2, this.signum()))
    })
}

/// The PV before a turn, and the medians of it in each third of the hold; `None` if the hold is too short.
fn reached(spell: &Manual, k: usize) -> Option<[f64; 4]> {
    let from = spell.turns[k].0;
    let until = spell.turns.get(k + 1).map_or(spell.pv.len(), |next| next.0);
    let held = spell.pv.get(from..until).filter(|held| from > 0 && held.len() >= HELD)?;
    let third = |i: usize| median(&held[i * held.len() / 3..(i + 1) * held.len() / 3]);
    Some([spell.pv[from - 1], third(0), third(1), third(2)])
}

/// Whether the holds of a staircase ended while the PV still moved, by more than its noise.
pub(super) fn unsettled(spells: &[&Manual]) -> bool {
    let (mut thirds, mut turns) = ([0.0; 4], 0);
    let mut count = 0;
    for spell in spells {
        turns += spell.turns.len().saturating_sub(1);
        for (k, direction) in kept(&spell.turns) {
            for (sum, pv) in thirds.iter_mut().zip(reached(spell, k).unwrap_or_default()) {
                *sum += direction * pv;
            }
            count += 1;
        }
    }
    let values: Vec<f64> = spells.iter().flat_map(|spell| spell.pv.iter().copied()).collect();
    let still_moves = (thirds[3] - thirds[2]).abs();
    f64::from(count) >= IN_RUNS * turns as f64
        && still_moves > MOVES.0 * noise_std(&values) * f64::from(count).sqrt()
        && still_moves > MOVES.1 * (thirds[3] - thirds[0]).abs()
        && lacking(thirds).is_none()
}

/// A settled value.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Settled {
    op: f64,
    /// The PV, times the sign of the gain.
    pv: f64,
    /// Time, samples.
    at: f64,
}

impl Curve {
    /// The characteristic by which a staircase moved the PV; `None` if the times in manual are no staircase, or too few
    /// levels are settled.
    pub fn of(spells: &[&Manual]) -> Option<Self> {
        let (mut rising, mut falling) = (vec![], vec![]);
        let mut thirds = [0.0; 4];
        let (mut before, mut turns) = (0, 0);
        for spell in spells {
            turns += spell.turns.len().saturating_sub(1);
            for (k, direction) in kept(&spell.turns) {
                if let Some(reached) = reached(spell, k) {
                    thirds.iter_mut().zip(reached).for_each(|(sum, pv)| *sum += direction * pv);
                    let branch = if direction > 0.0 { &mut rising } else { &mut falling };
                    let until = spell.turns.get(k + 1).map_or(spell.pv.len(), |next| next.0);
                    let (op, at) = (spell.turns[k].1, (before + until) as f64);
                    branch.push((Settled { op, pv: reached[3], at }, reached[3] - reached[0]));
                }
            }
            before += spell.pv.len();
        }
        if ((rising.len() + falling.len()) as f64) < IN_RUNS * turns as f64 {
            return None;
        }
        let lacking = lacking(thirds)?;
        let [mut rising, mut falling] = [rising, falling].map(|branch| -> Vec<Settled> {
            let complete =
                |(of, answer): (Settled, f64)| Settled { pv: of.pv + lacking * answer, ..of };
            branch.into_iter().map(complete).collect()
        });
        if rising.len() < FEWEST || falling.len() < FEWEST {
            return None;
        }
        let all = rising.iter().chain(&falling);
        let (op, pv): (Vec<f64>, Vec<f64>) = all.map(|of| (of.op, of.pv)).unzip();
        let related = correlation(&op, &pv)?;
        if related.abs() < RELATED {
            return None;
        }
        let sign = related.signum();
        rising.iter_mut().chain(&mut falling).for_each(|of| of.pv *= sign);
        let [up, down] = [&rising, &falling].map(|branch| monotone(branch));
        let (low, high) =
            (up[0].pv.max(down[0].pv), up[up.len() - 1].pv.min(down[down.len() - 1].pv));
        if low >= high {
            return None;
        }
        // Of each settled value its distance from the other branch, and how much later the falling one is.
        let beside = |of: &[Settled], other: &[Settled], way: f64| -> Vec<(f64, f64)> {
            let inside = of.iter().filter(|of| low <= of.pv && of.pv <= high);
            inside
                .map(|of| {
                    let (op, at) = at(other, of.pv);
                    (way * (at - of.at), way * (of.op - op))
                })
                .collect()
        };
        let mut distances = beside(&rising, &down, 1.0);
        distances.extend(beside(&falling, &up, -1.0));
        let (apart, error) = without_drift(&distances)?;
        let mut points: Vec<(f64, f64)> = vec![];
        for k in 0..=LEVELS {
            let level = low + (high - low) * k as f64 / LEVELS as f64;
            let position = 0.5 * (at(&up, level).0 + at(&down, level).0);
            if points.last().is_none_or(|last| position > last.0) {
                points.push((position, level));
            }
        }
        (points.len() >= FEWEST).then_some(Self { points, sign, apart, error })
    }

    /// Log-likelihood of the distance of the branches for a stem; without one, the valve follows.
    pub fn likelihood(&self, spells: &[Manual], stem: Option<Stem>) -> f64 {
        let expected = stem.map_or(0.0, |stem| trailing(spells, stem));
        let error = self.error.hypot(INEXACT.0).hypot(INEXACT.1 * expected);
        let z = (self.apart - expected) / error;
        -0.5 * (FREEDOM + 1.0) * (z * z / FREEDOM).ln_1p() - error.ln()
    }

    /// The position at a value of the PV, on straight lines beyond the ends.
    pub fn position(&self, pv: f64) -> f64 {
        let swapped = |k: usize| (self.points[k].1, self.points[k].0);
        interpolated(self.points.len(), &swapped, self.sign * pv).clamp(STROKE.0, STROKE.1)
    }

    /// The PV at a position.
    pub fn pv(&self, position: f64) -> f64 {
        self.sign * interpolated(self.points.len(), &|k| self.points[k], position)
    }

    /// A time in manual with the position instead of its PV.
    pub fn straightened(&self, of: &Manual) -> Manual {
        Manual { pv: of.pv.iter().map(|pv| self.position(*pv)).collect(), ..of.clone() }
    }
}

/// The distance of the branches for a stem, percent of OP.
fn trailing(spells: &[Manual], stem: Stem) -> f64 {
    let (mut rising, mut falling) = (vec![], vec![]);
    for spell in spells {
        let op: Vec<f64> = spell.turns.iter().map(|(_, op)| *op).collect();
        let Some(moves) = stem.moves(spell.before, &op, 0.0) else { continue };
        let mut position = spell.before;
        let behind: Vec<f64> = op
            .iter()
            .zip(moves)
            .map(|(op, by)| {
                position += by;
                op - position
            })
            .collect();
        for (k, direction) in kept(&spell.turns) {
            let branch = if direction > 0.0 { &mut rising } else { &mut falling };
            branch.push(behind[k]);
        }
    }
    median(&rising) - median(&falling)
}

/// The value at `x` on the lines through ascending points, continued at both ends.
fn interpolated(n: usize, point: &dyn Fn(usize) -> (f64, f64), x: f64) -> f64 {
    let mut k = 1;
    while k + 1 < n && point(k).0 < x {
        k += 1;
    }
    let ((x0, y0), (x1, y1)) = (point(k - 1), point(k));
    y0 + (y1 - y0) * (x - x0) / (x1 - x0).max(f64::MIN_POSITIVE)
}

/// The part of the PV's response that is missing at the end of its holds, as a share of the response so far; `None` if
/// the response is not nearly complete. From the sums over all holds of the PV before, and in each third.
fn lacking([before, first, second, third]: [f64; 4]) -> Option<f64> {
    let (answer, early, late) = (third - before, second - first, third - second);
    if answer == 0.0 {
        return None;
    }
    // A move of less than a hundredth is noise.
    let (early, late) = (early / answer, late / answer);
    let ratio = late / early.max(0.01);
    (ratio <= STILL).then(|| late.max(0.0) * ratio.max(0.0) / (1.0 - ratio.max(0.0)))
}

/// The distance of the branches at no difference of time, and its standard deviation, by least squares. A load that
/// drifts adds to a distance in proportion to the time between both values. Half of the distances repeat the other
/// half.
fn without_drift(distances: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = distances.len() as f64;
    if distances.len() < 2 * FEWEST {
        return None;
    }
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| distances.iter().map(of).sum::<f64>() / n;
    let (later, apart) = (mean(&|d| d.0), mean(&|d| d.1));
    let spread = mean(&|d| (d.0 - later).powi(2));
    let drift = match spread > 0.0 {
        true => mean(&|d| (d.0 - later) * (d.1 - apart)) / spread,
        false => 0.0,
    };
    let left = mean(&|d| (d.1 - apart - drift * (d.0 - later)).powi(2)) * n / (n - 2.0);
    let reach = if spread > 0.0 { later * later / spread } else { 0.0 };
    Some((apart - drift * later, (left * (1.0 + reach) * 2.0 / n).sqrt()))
}

/// Values over ascending OP with the ascending PV that is nearest by least squares: neighbours that descend are
/// replaced by their mean.
fn monotone(of: &[Settled]) -> Vec<Settled> {
    let mut of = of.to_vec();
    of.sort_by(|a, b| a.op.total_cmp(&b.op));
    // Blocks with their numbers of values.
    let mut blocks: Vec<(Settled, f64)> = vec![];
    for one in of {
        blocks.push((one, 1.0));
        while let [.., (a, m), (b, n)] = blocks[..] {
            if a.op != b.op && a.pv < b.pv {
                break;
            }
            let mean = |x: f64, y: f64| (m * x + n * y) / (m + n);
            let both = Settled { op: mean(a.op, b.op), pv: mean(a.pv, b.pv), at: mean(a.at, b.at) };
            blocks.truncate(blocks.len() - 2);
            blocks.push((both, m + n));
        }
    }
    blocks.into_iter().map(|(block, _)| block).collect()
}

/// The OP and the time of a branch at a level of the PV.
fn at(branch: &[Settled], level: f64) -> (f64, f64) {
    match branch {
        [one] => (one.op, one.at),
        _ => (
            interpolated(branch.len(), &|k| (branch[k].pv, branch[k].op), level),
            interpolated(branch.len(), &|k| (branch[k].pv, branch[k].at), level),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A staircase of a valve that trails by `b` before a characteristic, settled at once.
    fn staircase(b: f64, of: impl Fn(f64) -> f64) -> Manual {
        let up = (0..=10).map(|k| 20.0 + 6.0 * f64::from(k));
        let op: Vec<f64> = up.clone().chain(up.rev().skip(1)).collect();
        let mut stem = op[0];
        let mut pv = vec![];
        for u in &op {
            stem = stem.clamp(u - b, u + b);
            pv.extend([of(stem); 8]);
        }
        let turns = op.iter().enumerate().map(|(k, u)| (8 * k, *u)).collect();
        Manual { pv, before: op[0], turns }
    }

    #[test]
    fn curved_characteristics_are_straightened() {
        let square = |x: f64| 0.01 * x * x;
        let equal = |x: f64| 50f64.powf(x / 100.0 - 1.0) * 100.0;
        let falls = |x: f64| 90.0 - 0.01 * x * x;
        let curves: [&dyn Fn(f64) -> f64; 3] = [&square, &equal, &falls];
        for (b, of) in curves.into_iter().flat_map(|of| [(0.0, of), (1.5, of)]) {
            let manual = staircase(b, of);
            let curve = Curve::of(&[&manual]).unwrap();
            assert!((curve.apart - 2.0 * b).abs() < 0.3, "{b}: {}", curve.apart);
            for x in [35.0, 50.0, 65.0] {
                assert!((curve.position(of(x)) - x).abs() < 0.6, "{x}: {}", curve.position(of(x)));
                assert!((curve.pv(curve.position(of(x))) - of(x)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_drift_is_no_distance() {
        let mut manual = staircase(1.0, |x| x);
        for (k, pv) in manual.pv.iter_mut().enumerate() {
            *pv += 0.02 * k as f64;
        }
        let curve = Curve::of(&[&manual]).unwrap();
        assert!((curve.apart - 2.0).abs() < 0.3, "{}", curve.apart);
    }

    #[test]
    fn turns_to_and_fro_have_no_characteristic() {
        let turns = (0..12).map(|k| (8 * k, if k % 2 == 0 { 48.0 } else { 52.0 })).collect();
        let manual = Manual { pv: vec![1.0; 96], before: 50.0, turns };
        assert_eq!(Curve::of(&[&manual]), None);
    }
}
