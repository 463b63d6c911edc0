//! How well a statistic ranks sticking valves above healthy ones.

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::BTreeMap;
use stiction_diagnose::series::quantile;

/// Number of draws of the bootstrap.
pub const DRAWS: usize = 2000;

/// A recording, or a valve, with its score from a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranked {
    /// Whether it sticks.
    pub sticks: bool,
    /// Larger values indicate sticking; `None` if the method abstains.
    pub score: Option<f64>,
    /// Valve of the recording. Recordings of one valve are not independent.
    pub valve: usize,
}

/// Area under the receiver operating characteristic.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Auc {
    /// Share of the pairs of a sticking and a healthy recording in which the sticking one has the larger
    /// score; ties count half. Recordings without a score are left out.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end of the 95 % interval.
    pub high: f64,
    /// Sticking recordings with a score.
    pub sticky: usize,
    /// Healthy recordings with a score.
    pub healthy: usize,
    /// Share over all recordings. A pair counts half if one of its recordings has no score, like a random guess.
    pub of_all: f64,
}

/// The area under the receiver operating characteristic of some scores, with a bootstrap interval;
/// `None` unless sticking and healthy recordings have scores.
///
/// ```text
/// AUC = (1 / (P Q)) sum over pairs of  1 if s_i > h_j,  1/2 if s_i = h_j,  0 else
/// ```
///
/// The interval is between the quantiles 0.025 and 0.975 of [`DRAWS`] draws. Each draws valves with replacement, within
/// each class, and includes all recordings of a valve. With few valves in a class the interval is too narrow. For
/// perfectly separated classes its width is zero, although nothing is certain. Equal input and `seed` give equal bits.
///
/// Scores must not be NaN; a NaN counts as no score.
///
/// Sources: H. B. Mann, D. R. Whitney, Ann. Math. Stat. 18 (1947) 50-60; J. A. Hanley, B. J. McNeil,
/// Radiology 143 (1982) 29-36; B. Efron, Ann. Stat. 7 (1979) 1-26 (all recalled, not read).
pub fn auc(loops: &[Ranked], seed: u64) -> Option<Auc> {
    let ranks = Ranks::of(loops);
    let value = ranks.area(&ranks.once())?;
    // Every cluster has a score, so every draw has both classes.
    let (low, high) = ranks.interval(seed, |weights| ranks.area(weights));
    let count = |sticks: bool| ranks.order.iter().filter(|each| each.sticks == sticks).count();
    let all = |sticks: bool| loops.iter().filter(|each| each.sticks == sticks).count();
    let (sticky, healthy) = (count(true), count(false));
    let scored = (sticky * healthy) as f64 / (all(true) * all(false)) as f64;
    Some(Auc { value, low, high, sticky, healthy, of_all: 0.5 + scored * (value - 0.5) })
}

/// The receiver operating characteristic: false-alarm rate and recall at every threshold, from (0, 0) to (1, 1).
/// Recordings without a score are left out. The result is empty unless both classes have scores.
pub fn roc(loops: &[Ranked]) -> Vec<(f64, f64)> {
    let ranks = Ranks::of(loops);
    let of = |sticks: bool| ranks.order.iter().filter(|each| each.sticks == sticks).count();
    let (sticky, healthy) = (of(true), of(false));
    if sticky == 0 || healthy == 0 {
        return vec![];
    }
    let (mut found, mut alarms) = (0, 0);
    let mut points = vec![(0.0, 0.0)];
    for (k, each) in ranks.order.iter().enumerate().rev() {
        if each.sticks {
            found += 1
        } else {
            alarms += 1
        }
        // Tied scores are called together.
        if k == 0 || ranks.order[k - 1].tie != each.tie {
            points.push((alarms as f64 / healthy as f64, found as f64 / sticky as f64));
        }
    }
    points
}

/// Recordings by valve. The score of a valve is the mean score of its recordings, and the valve sticks if one recording
/// does. For probabilities, the scores should be their [`logit`]s.
pub fn by_valve(loops: &[Ranked]) -> Vec<Ranked> {
    let mut valves: BTreeMap<usize, (bool, f64, usize)> = BTreeMap::new();
    for each in loops {
        let (sticks, sum, count) = valves.entry(each.valve).or_default();
        *sticks |= each.sticks;
        if let Some(score) = each.score {
            *sum += score;
            *count += 1;
        }
    }
    let ranked = |(valve, (sticks, sum, count)): (usize, (bool, f64, usize))| Ranked {
        sticks,
        score: (count > 0).then(|| sum / count as f64),
        valve,
    };
    valves.into_iter().map(ranked).collect()
}

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Interval {
    /// The value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end of the 95 % interval.
    pub high: f64,
}

/// The largest share of the sticking loops above a threshold that at most the share `alarms` of the healthy loops
/// exceeds. The bootstrap interval is as for [`auc`]. It is `None` unless both classes occur. Loops without a score lie
/// below every threshold, so abstaining costs recall.
pub fn recall_at(loops: &[Ranked], alarms: f64, seed: u64) -> Option<Interval> {
    let ranks = Ranks::of_all(loops);
    let value = ranks.recall_at(&ranks.once(), alarms)?;
    let (low, high) = ranks.interval(seed, |weights| ranks.recall_at(weights, alarms));
    Some(Interval { value, low, high })
}

/// The threshold of [`recall_at`]: loops from this score on are above it; `None` if no score may be called.
pub fn threshold_at(loops: &[Ranked], alarms: f64) -> Option<f64> {
    let ranks = Ranks::of_all(loops);
    let (_, from) = ranks.called_at(&ranks.once(), alarms)?;
    Some(ranks.order.get(from?)?.score)
}

/// Quantiles 0.025 and 0.975 of what `of` computes from the weights of [`DRAWS`] draws with replacement, within each
/// class; `classes` lists the places of its members. Draws without a value are left out.
pub(super) fn bootstrap(
    classes: &[Vec<usize>],
    seed: u64,
    of: impl Fn(&[u32]) -> Option<f64>,
) -> (f64, f64) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut weights = vec![0u32; classes.iter().map(Vec::len).sum()];
    let mut values = Vec::with_capacity(DRAWS);
    for _ in 0..DRAWS {
        weights.fill(0);
        for class in classes {
            for _ in 0..class.len() {
                // The upper half of the product is a whole number below the length.
                let at = (u128::from(random.next_u64()) * class.len() as u128) >> 64;
                weights[class[at as usize]] += 1;
            }
        }
        values.extend(of(&weights));
    }
    (quantile(&values, 0.025), quantile(&values, 0.975))
}

/// `ln(p / (1 - p))` of a probability, limited to one in a million from 0 and 1.
pub fn logit(probability: f64) -> f64 {
    let p = probability.clamp(1e-6, 1.0 - 1e-6);
    (p / (1.0 - p)).ln()
}

/// Recordings with scores, in the order of the scores.
struct Ranks {
    order: Vec<Rank>,
    /// Valve and class: the unit of a draw.
    clusters: Vec<(usize, bool)>,
}

struct Rank {
    sticks: bool,
    score: f64,
    cluster: usize,
    /// Equal for equal scores.
    tie: usize,
}

impl Ranks {
    fn of(loops: &[Ranked]) -> Self {
        let mut scored: Vec<(f64, &Ranked)> = loops
            .iter()
            .filter_map(|each| Some((each.score.filter(|score| !score.is_nan())?, each)))
            .collect();
        // The sort is stable, so equal input gives equal order.
        scored.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut clusters: Vec<(usize, bool)> =
            scored.iter().map(|(_, each)| (each.valve, each.sticks)).collect();
        clusters.sort_unstable();
        clusters.dedup();
        let mut tie = 0;
        let order = (0..scored.len())
            .map(|k| {
                let (score, each) = scored[k];
                // By value, so that 0 and -0 are tied.
                tie += usize::from(k > 0 && scored[k - 1].0 != score);
                let cluster = clusters.partition_point(|c| *c < (each.valve, each.sticks));
                Rank { sticks: each.sticks, score: scored[k].0, cluster, tie }
            })
            .collect();
        Self { order, clusters }
    }

    /// All loops. Loops without a score rank below all others.
    fn of_all(loops: &[Ranked]) -> Self {
        let lowest = |each: &Ranked| {
            let score = each.score.filter(|score| !score.is_nan());
            Ranked { score: Some(score.unwrap_or(f64::NEG_INFINITY)), ..*each }
        };
        Self::of(&loops.iter().map(lowest).collect::<Vec<_>>())
    }

    /// Each cluster once.
    fn once(&self) -> Vec<u32> {
        vec![1; self.clusters.len()]
    }

    fn interval(&self, seed: u64, of: impl Fn(&[u32]) -> Option<f64>) -> (f64, f64) {
        let classes = [false, true].map(|sticks| {
            (0..self.clusters.len()).filter(|c| self.clusters[*c].1 == sticks).collect()
        });
        bootstrap(&classes, seed, of)
    }

    fn recall_at(&self, weights: &[u32], alarms: f64) -> Option<f64> {
        self.called_at(weights, alarms).map(|(recall, _)| recall)
    }

    /// The recall, and the place in the order from which on loops are called sticking; `None` unless both classes
    /// occur.
    fn called_at(&self, weights: &[u32], alarms: f64) -> Option<(f64, Option<usize>)> {
        let mut all = [0u64; 2];
        for each in &self.order {
            all[usize::from(each.sticks)] += u64::from(weights[each.cluster]);
        }
        let [healthy, sticky] = all;
        if healthy == 0 || sticky == 0 {
            return None;
        }
        let (mut called, mut best, mut from) = ([0u64; 2], 0, None);
        for (k, each) in self.order.iter().enumerate().rev() {
            if each.score == f64::NEG_INFINITY {
                break;
            }
            called[usize::from(each.sticks)] += u64::from(weights[each.cluster]);
            // Tied scores are called together.
            if k == 0 || self.order[k - 1].tie != each.tie {
                if called[0] as f64 > alarms * healthy as f64 {
                    break;
                }
                (best, from) = (called[1], Some(k));
            }
        }
        Some((best as f64 / sticky as f64, from))
    }

    /// The area, with each cluster counted as often as its weight; `None` without pairs.
    fn area(&self, weights: &[u32]) -> Option<f64> {
        let (mut below, mut sticky, mut won) = (0u64, 0u64, 0.0);
        let (mut tied_sticky, mut tied_healthy, mut tie) = (0u64, 0u64, 0);
        let mut close = |tied_sticky: &mut u64, tied_healthy: &mut u64| {
            won += *tied_sticky as f64 * (below as f64 + 0.5 * *tied_healthy as f64);
            (below, sticky) = (below + *tied_healthy, sticky + *tied_sticky);
            (*tied_sticky, *tied_healthy) = (0, 0);
        };
        for each in &self.order {
            if each.tie != tie {
                close(&mut tied_sticky, &mut tied_healthy);
                tie = each.tie;
            }
            let weight = u64::from(weights[each.cluster]);
            if each.sticks { tied_sticky += weight } else { tied_healthy += weight }
        }
        close(&mut tied_sticky, &mut tied_healthy);
        let pairs = sticky as f64 * below as f64;
        (pairs > 0.0).then(|| won / pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranked(sticky: &[f64], healthy: &[f64]) -> Vec<Ranked> {
        let class = |sticks: bool, scores: &[f64]| -> Vec<(bool, f64)> {
            scores.iter().map(|score| (sticks, *score)).collect()
        };
        [class(true, sticky), class(false, healthy)]
            .concat()
            .into_iter()
            .enumerate()
            .map(|(valve, (sticks, score))| Ranked { sticks, score: Some(score), valve })
            .collect()
    }

    /// The definition, pair by pair.
    fn by_pairs(sticky: &[f64], healthy: &[f64]) -> f64 {
        let won = |s: f64| -> f64 {
            healthy
                .iter()
                .map(|h| {
                    if s > *h {
                        1.0
                    } else if s == *h {
                        0.5
                    } else {
                        0.0
                    }
                })
                .sum()
        };
        sticky.iter().map(|s| won(*s)).sum::<f64>() / (sticky.len() * healthy.len()) as f64
    }

    /// Normal deviates without a table: sums of twelve uniform ones.
    fn normal(count: usize, mean: f64, seed: u64) -> Vec<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut uniform = move || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        (0..count).map(|_| mean - 6.0 + (0..12).map(|_| uniform()).sum::<f64>()).collect()
    }

    #[test]
    fn it_is_the_share_of_pairs_in_order_and_ties_count_half() {
        let (sticky, healthy) = ([3.0, 1.0, 1.0, 0.0, -0.0], [1.0, 0.0, -2.0, 3.0]);
        let found = auc(&ranked(&sticky, &healthy), 1).unwrap();
        assert!((found.value - by_pairs(&sticky, &healthy)).abs() < 1e-15, "{}", found.value);
        assert_eq!((found.sticky, found.healthy, found.of_all), (5, 4, found.value));
        // The other way round it is the complement.
        let other = auc(&ranked(&healthy, &sticky), 1).unwrap();
        assert!((found.value + other.value - 1.0).abs() < 1e-15);
        // A monotone scale changes nothing, not even the interval.
        let cubed = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| v.powi(3)).collect() };
        assert_eq!(Some(found), auc(&ranked(&cubed(&sticky), &cubed(&healthy)), 1));
    }

    #[test]
    fn perfect_separation_equal_scores_and_none() {
        let perfect = auc(&ranked(&[2.0, 3.0], &[0.0, 1.0]), 1).unwrap();
        assert_eq!((perfect.value, perfect.low, perfect.high), (1.0, 1.0, 1.0));
        let equal = auc(&ranked(&[1.0; 7], &[1.0; 5]), 1).unwrap();
        assert_eq!((equal.value, equal.low, equal.high), (0.5, 0.5, 0.5));
        assert_eq!(auc(&ranked(&[1.0], &[]), 1), None);
        assert_eq!(auc(&ranked(&[f64::NAN], &[1.0]), 1), None);
        assert_eq!(auc(&[], 1), None);
    }

    #[test]
    fn what_has_no_score_is_left_out_or_tosses_a_coin() {
        let mut loops = ranked(&[3.0, 0.0, 1.5], &[1.0, 2.0]);
        let scored = auc(&loops, 1).unwrap();
        loops.push(Ranked { sticks: true, score: None, valve: 90 });
        loops.push(Ranked { sticks: false, score: None, valve: 91 });
        let found = auc(&loops, 1).unwrap();
        assert_eq!((found.value, found.low, found.high), (scored.value, scored.low, scored.high));
        // 6 of 4 x 3 pairs are scored, the others count half.
        let want = (6.0 * scored.value + 0.5 * 6.0) / 12.0;
        assert!((found.of_all - want).abs() < 1e-15, "{} {want}", found.of_all);
    }

    #[test]
    fn the_interval_is_as_wide_as_hanley_and_mcneil_say() {
        let (m, n) = (150, 200);
        let (sticky, healthy) = (normal(m, 1.0, 5), normal(n, 0.0, 6));
        let found = auc(&ranked(&sticky, &healthy), 7).unwrap();
        let a = found.value;
        let (q1, q2) = (a / (2.0 - a), 2.0 * a * a / (1.0 + a));
        let (m, n) = (m as f64, n as f64);
        let variance =
            (a * (1.0 - a) + (m - 1.0) * (q1 - a * a) + (n - 1.0) * (q2 - a * a)) / (m * n);
        let want = 2.0 * 1.96 * variance.sqrt();
        let width = found.high - found.low;
        assert!((width / want - 1.0).abs() < 0.15, "{width} for {want}");
        assert!(found.low < a && a < found.high);
        // That of normal scores one standard deviation apart is Phi(1 / sqrt 2) = 0.760.
        assert!((a - 0.760).abs() < 0.05, "{a}");
    }

    #[test]
    fn recordings_of_one_valve_are_drawn_together() {
        let once = ranked(&normal(20, 1.0, 1), &normal(20, 0.0, 2));
        let copied: Vec<Ranked> = once.iter().flat_map(|each| [*each; 5]).collect();
        let (single, copies) = (auc(&once, 3).unwrap(), auc(&copied, 3).unwrap());
        assert_eq!(single.value, copies.value);
        assert_eq!((single.low, single.high), (copies.low, copies.high));
        let apart: Vec<Ranked> =
            copied.iter().enumerate().map(|(valve, each)| Ranked { valve, ..*each }).collect();
        let apart = auc(&apart, 3).unwrap();
        assert!(apart.high - apart.low < 0.6 * (single.high - single.low));
        // And the valves of the copies are those of the loops.
        assert_eq!(by_valve(&once).len(), 40);
        assert_eq!(auc(&by_valve(&copied), 3).unwrap().sticky, 20);
    }

    #[test]
    fn a_valve_has_the_mean_of_its_scores_and_sticks_if_one_recording_does() {
        let of = |sticks, score, valve| Ranked { sticks, score, valve };
        let loops = [
            of(false, Some(1.0), 4),
            of(true, Some(4.0), 4),
            of(false, None, 4),
            of(false, None, 2),
        ];
        assert_eq!(by_valve(&loops), [of(false, None, 2), of(true, Some(2.5), 4)]);
    }

    #[test]
    fn the_curve_encloses_the_area() {
        let (sticky, healthy) = (normal(40, 0.7, 8), normal(30, 0.0, 9));
        // Rounded, so that there are ties.
        let rounded = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| (3.0 * v).round()).collect() };
        let loops = ranked(&rounded(&sticky), &rounded(&healthy));
        let curve = roc(&loops);
        assert_eq!((curve[0], curve[curve.len() - 1]), ((0.0, 0.0), (1.0, 1.0)));
        let trapezia = curve.windows(2).map(|w| 0.5 * (w[1].1 + w[0].1) * (w[1].0 - w[0].0));
        let area: f64 = trapezia.sum();
        assert!((area - auc(&loops, 1).unwrap().value).abs() < 1e-12);
        assert!(roc(&ranked(&[1.0], &[])).is_empty());
    }

    #[test]
    fn recall_at_few_alarms_calls_no_more_healthy_loops() {
        // One of four healthy loops may be called: from 2.0 on, where three of five stick; the tie at 1.0 has two.
        let mut loops = ranked(&[5.0, 4.0, 2.0, 1.0], &[3.0, 1.0, 0.0]);
        loops.push(Ranked { sticks: false, score: None, valve: 90 });
        loops.push(Ranked { sticks: true, score: None, valve: 91 });
        let at = |alarms: f64| recall_at(&loops, alarms, 1).unwrap();
        assert_eq!(at(0.25).value, 0.6);
        assert_eq!(threshold_at(&loops, 0.25), Some(2.0));
        assert_eq!(at(0.5).value, 0.8);
        // What has no score is never called, however many alarms are permitted.
        assert_eq!(at(1.0).value, 0.8);
        assert_eq!((at(0.0).value, threshold_at(&loops, 0.0)), (0.4, Some(4.0)));
        assert!(at(0.25).low <= 0.6 && at(0.25).high >= 0.6);
        assert_eq!(recall_at(&ranked(&[1.0], &[]), 0.01, 1), None);
        assert_eq!(threshold_at(&ranked(&[0.0], &[1.0]), 0.0), None);
    }

    #[test]
    fn logits_are_odd_and_finite() {
        assert_eq!(logit(0.5), 0.0);
        assert!((logit(0.9) + logit(0.1)).abs() < 1e-12);
        assert!((logit(0.9) - 9f64.ln()).abs() < 1e-12);
        assert!(logit(0.0).is_finite() && logit(1.0).is_finite());
    }
}
