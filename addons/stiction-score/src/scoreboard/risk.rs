//! Errors that a user meets who accepts the most certain answers first.

use super::Ranked;
use super::auc::{Interval, bootstrap};

/// Parts into which valves are divided to calibrate scores on loops of other valves.
const FOLDS: usize = 5;
/// Largest number of points of a curve in a document.
const POINTS: usize = 100;

/// Risk against coverage.
///
/// A score becomes a probability by the monotone curve that fits the loops of other valves best: isotonic regression,
/// with valves in five parts, each judged by the curve of the other four. Only the order of the scores matters. Loops
/// are then accepted by `max(p, 1 - p)`, the most certain first. The risk is the share of wrong decisions among the
/// accepted, and the coverage is the share of accepted decisions among all. Loops without a score are never accepted.
///
/// Sources: R. E. Barlow et al., "Statistical Inference under Order Restrictions", 1972; R. El-Yaniv, Y. Wiener,
/// J. Mach. Learn. Res. 11 (2010) 1605-1641 (both recalled, not read).
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct RiskCoverage {
    /// Mean risk over all coverages from 0 to 1. Loops without a score are counted as accepted last, by tossing a coin.
    pub area: Interval,
    /// Coverage and risk, from the most certain loop on.
    pub points: Vec<[f64; 2]>,
}

/// A loop with a calibrated score.
struct Certain {
    certainty: f64,
    wrong: bool,
    /// Place among the loops.
    place: usize,
}

impl RiskCoverage {
    /// Of the scores of some loops; `None` if none has a score.
    pub fn of(loops: &[Ranked], seed: u64) -> Option<Self> {
        let mut certain = calibrated(loops);
        if certain.is_empty() {
            return None;
        }
        certain.sort_by(|a, b| b.certainty.total_cmp(&a.certainty));
        // One draw has as many loops as there are, whatever their class.
        let classes = [(0..loops.len()).collect::<Vec<_>>()];
        let value = area(&certain, &vec![1; loops.len()])?;
        let (low, high) = bootstrap(&classes, seed, |weights| area(&certain, weights));
        let mut points = vec![];
        walk(&certain, &vec![1; loops.len()], |coverage, risk| points.push([coverage, risk]));
        let every = points.len().div_ceil(POINTS).max(1);
        let last = points.len() - 1;
        let kept = points.iter().enumerate().filter(|(k, _)| k % every == 0 || *k == last);
        let points = kept.map(|(_, point)| *point).collect();
        Some(Self { area: Interval { value, low, high }, points })
    }
}

/// Calls `each` with coverage and risk after every group of equally certain loops. Returns the share of the loops that
/// have a score.
fn walk(certain: &[Certain], weights: &[u32], mut each: impl FnMut(f64, f64)) -> Option<f64> {
    let all: u64 = weights.iter().map(|weight| u64::from(*weight)).sum();
    let (mut accepted, mut wrong) = (0u64, 0u64);
    for (k, one) in certain.iter().enumerate() {
        let weight = u64::from(weights[one.place]);
        accepted += weight;
        wrong += if one.wrong { weight } else { 0 };
        let tied = certain.get(k + 1).is_some_and(|next| next.certainty == one.certainty);
        if !tied && accepted > 0 {
            each(accepted as f64 / all as f64, wrong as f64 / accepted as f64);
        }
    }
    (all > 0).then(|| accepted as f64 / all as f64)
}

/// The integral of the risk over the coverage.
fn area(certain: &[Certain], weights: &[u32]) -> Option<f64> {
    let (mut sum, mut from) = (0.0, 0.0);
    let mut before = None;
    let covered = walk(certain, weights, |coverage, risk| {
        sum += (coverage - from) * 0.5 * (risk + before.unwrap_or(risk));
        (from, before) = (coverage, Some(risk));
    })?;
    // The loops that follow are wrong in one half, so the risk rises towards that.
    let end = before.unwrap_or(0.5) * covered + 0.5 * (1.0 - covered);
    Some(sum + (1.0 - covered) * 0.5 * (before.unwrap_or(0.5) + end))
}

/// The loops with a score, with their certainty.
fn calibrated(loops: &[Ranked]) -> Vec<Certain> {
    let scored: Vec<(usize, f64, &Ranked)> = loops
        .iter()
        .enumerate()
        .filter_map(|(k, each)| Some((k, each.score.filter(|s| !s.is_nan())?, each)))
        .collect();
    let mut found = vec![];
    for fold in 0..FOLDS {
        let (inside, others): (Vec<_>, Vec<_>) =
            scored.iter().partition(|(_, _, each)| each.valve % FOLDS == fold);
        let curve = Isotonic::of(others.iter().map(|(_, score, each)| (*score, each.sticks)));
        found.extend(inside.into_iter().map(|(place, score, each)| {
            let p = curve.at(score);
            let certainty = p.max(1.0 - p);
            Certain { certainty, wrong: (p > 0.5) != each.sticks, place }
        }));
    }
    // Equally certain loops are accepted together, so their order does not matter.
    found.sort_by_key(|one| one.place);
    found
}

/// A rising curve of steps: pool adjacent violators.
struct Isotonic {
    /// The least score of each block, and its share of sticking loops.
    blocks: Vec<(f64, f64)>,
}

impl Isotonic {
    fn of(scores: impl Iterator<Item = (f64, bool)>) -> Self {
        let mut scores: Vec<(f64, bool)> = scores.collect();
        scores.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Least score, sticking loops, all loops.
        let mut blocks: Vec<(f64, f64, f64)> = vec![];
        let mut before = f64::NAN;
        for (score, sticks) in scores {
            let one = f64::from(u8::from(sticks));
            match blocks.last_mut() {
                Some(last) if score == before => {
                    last.1 += one;
                    last.2 += 1.0;
                }
                _ => {
                    pool(&mut blocks);
                    blocks.push((score, one, 1.0));
                }
            }
            before = score;
        }
        pool(&mut blocks);
        Self { blocks: blocks.into_iter().map(|(from, k, n)| (from, k / n)).collect() }
    }

    /// The share of the block of a score; one half without blocks.
    fn at(&self, score: f64) -> f64 {
        let until = self.blocks.partition_point(|(from, _)| *from <= score);
        self.blocks.get(until.saturating_sub(1)).map_or(0.5, |(_, share)| *share)
    }
}

/// Joins the last blocks until their shares rise.
fn pool(blocks: &mut Vec<(f64, f64, f64)>) {
    while let [.., a, b] = blocks[..]
        && a.1 / a.2 >= b.1 / b.2
    {
        blocks.truncate(blocks.len() - 2);
        blocks.push((a.0, a.1 + b.1, a.2 + b.2));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loops(score: impl Fn(usize) -> Option<f64>, sticks: impl Fn(usize) -> bool) -> Vec<Ranked> {
        (0..200).map(|k| Ranked { sticks: sticks(k), score: score(k), valve: k }).collect()
    }

    #[test]
    fn blocks_rise_and_keep_the_mean() {
        let scores =
            [(1.0, true), (2.0, false), (3.0, false), (4.0, true), (4.0, false), (5.0, true)];
        let curve = Isotonic::of(scores.into_iter());
        assert_eq!(curve.blocks, [(1.0, 1.0 / 3.0), (4.0, 0.5), (5.0, 1.0)]);
        assert_eq!([0.0, 2.5, 4.0, 9.0].map(|s| curve.at(s)), [1.0 / 3.0, 1.0 / 3.0, 0.5, 1.0]);
        assert_eq!(Isotonic::of(std::iter::empty()).at(1.0), 0.5);
    }

    #[test]
    fn perfect_scores_have_no_risk_and_no_scores_toss_a_coin() {
        let perfect = loops(|k| Some(k as f64), |k| k >= 100);
        let found = RiskCoverage::of(&perfect, 1).unwrap();
        assert!(found.area.value < 0.01, "{found:?}");
        assert_eq!(found.points.last().map(|point| point[0]), Some(1.0));
        // A monotone scale changes nothing.
        let cubed = loops(|k| Some((k as f64 - 50.0).powi(3)), |k| k >= 100);
        assert_eq!(RiskCoverage::of(&cubed, 1), Some(found));
        assert_eq!(RiskCoverage::of(&loops(|_| None, |k| k % 2 == 0), 1), None);
        // With half of the scores, the other half is tossed: from no risk to a quarter.
        let half = RiskCoverage::of(&loops(|k| (k % 2 == 0).then_some(k as f64), |k| k >= 100), 1);
        let half = half.unwrap().area;
        assert!((half.value - 0.0625).abs() < 0.01, "{half:?}");
        assert!(half.low <= half.value && half.value <= half.high);
    }

    #[test]
    fn scores_without_information_err_in_half_of_the_loops() {
        let blind = loops(|k| Some(((k * 37) % 101) as f64), |k| (k / 3) % 2 == 0);
        let found = RiskCoverage::of(&blind, 1).unwrap().area.value;
        assert!((0.35..0.65).contains(&found), "{found}");
    }
}
