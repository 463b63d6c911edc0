//! Two detectors on the same loops.

use super::Ranked;
use super::auc::Interval;
use statrs::function::erf::erfc;
use stiction_diagnose::finding::Decision;
use stiction_diagnose::methods::Counts;

/// The difference of the AUCs of two detectors on the same loops.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct AucDifference {
    /// AUC of the first over all loops; a pair with a loop without a score counts half.
    pub first: Interval,
    /// AUC of the second over all loops.
    pub second: Interval,
    /// First less second.
    pub difference: Interval,
    /// Probability of a difference at least as large, of either sign, if both ranked equally well.
    pub p_value: f64,
}

/// Discordant decisions of two detectors.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Discordant {
    /// Loops that only the first calls sticking.
    pub only_first: usize,
    /// Loops that only the second calls sticking.
    pub only_second: usize,
    /// Probability of counts at least as unequal, if both called equally many.
    pub p_value: f64,
}

/// Normal quantile below the top 2.5 %.
const Z: f64 = 1.959_963_984_540_054;

/// Compares the AUCs of two detectors on the same loops, in the same order; `None` with fewer than two loops of a
/// class.
///
/// With `psi = 1` if the sticking loop has the larger score, 1/2 for a tie or a loop without a score, 0 else:
///
/// ```text
/// AUC = mean of psi(i, j),  V10(i) = mean over j of psi(i, j),  V01(j) = mean over i of psi(i, j)
/// var(A - B) = var(V10_A - V10_B) / P + var(V01_A - V01_B) / Q
/// ```
///
/// It assumes independent loops.
///
/// Source: E. R. DeLong, D. M. DeLong, D. L. Clarke-Pearson, Biometrics 44 (1988) 837-845 (recalled, not read).
pub fn compare_auc(first: &[Ranked], second: &[Ranked]) -> Option<AucDifference> {
    if first.len() != second.len() {
        return None;
    }
    let (a, b) = (Placements::of(first)?, Placements::of(second)?);
    let less = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let both =
        Placements { sticky: less(&a.sticky, &b.sticky), healthy: less(&a.healthy, &b.healthy) };
    let difference = a.area() - b.area();
    let deviation = both.deviation();
    let p_value = match deviation > 0.0 {
        true => erfc(difference.abs() / deviation / std::f64::consts::SQRT_2),
        // Equal rankings differ by nothing, and a difference without any spread is certain.
        false => f64::from(u8::from(difference == 0.0)),
    };
    Some(AucDifference {
        first: a.interval(),
        second: b.interval(),
        difference: Interval {
            value: difference,
            low: difference - Z * deviation,
            high: difference + Z * deviation,
        },
        p_value,
    })
}

/// The AUC over all loops, with the interval of [`compare_auc`]; `None` unless there are two loops of each class.
pub fn auc_of_all(loops: &[Ranked]) -> Option<Interval> {
    Placements::of(loops).map(|placements| placements.interval())
}

/// The mean of `psi` of each loop over the other class.
struct Placements {
    sticky: Vec<f64>,
    healthy: Vec<f64>,
}

impl Placements {
    fn of(loops: &[Ranked]) -> Option<Self> {
        let class = |sticks: bool| -> Vec<Option<f64>> {
            let of = loops.iter().filter(|each| each.sticks == sticks);
            of.map(|each| each.score.filter(|score| !score.is_nan())).collect()
        };
        let (sticky, healthy) = (class(true), class(false));
        let sorted = |class: &[Option<f64>]| {
            let mut scores: Vec<f64> = class.iter().copied().flatten().collect();
            scores.sort_by(f64::total_cmp);
            scores
        };
        // Mean of psi over the others: below count one, ties and those without a score a half.
        let placed = |each: &Option<f64>, others: &[f64], all: usize, above: bool| -> f64 {
            let Some(score) = each else { return 0.5 };
            let below = others.partition_point(|other| other < score);
            let until = others.partition_point(|other| other <= score);
            let won = if above { below } else { others.len() - until };
            let half = (until - below) + (all - others.len());
            (won as f64 + 0.5 * half as f64) / all as f64
        };
        let (low, high) = (sorted(&healthy), sorted(&sticky));
        (sticky.len() >= 2 && healthy.len() >= 2).then(|| Self {
            sticky: sticky.iter().map(|each| placed(each, &low, healthy.len(), true)).collect(),
            healthy: healthy.iter().map(|each| placed(each, &high, sticky.len(), false)).collect(),
        })
    }

    fn area(&self) -> f64 {
        self.sticky.iter().sum::<f64>() / self.sticky.len() as f64
    }

    fn deviation(&self) -> f64 {
        let part = |x: &[f64]| {
            let n = x.len() as f64;
            let mean = x.iter().sum::<f64>() / n;
            x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n
        };
        (part(&self.sticky) + part(&self.healthy)).sqrt()
    }

    fn interval(&self) -> Interval {
        let (value, half) = (self.area(), Z * self.deviation());
        Interval { value, low: (value - half).max(0.0), high: (value + half).min(1.0) }
    }
}

/// Compares the decisions of two detectors on the same loops: McNemar's exact test of the loops that only one calls
/// sticking.
///
/// ```text
/// p = min(1, 2 sum over k <= min(b, c) of binomial(b + c, k) / 2^(b + c))
/// ```
///
/// Source: Q. McNemar, Psychometrika 12 (1947) 153-157 (recalled, not read).
pub fn compare_decisions(pairs: impl IntoIterator<Item = (Decision, Decision)>) -> Discordant {
    let (mut only_first, mut only_second) = (0, 0);
    for (a, b) in pairs {
        match (is_called(a), is_called(b)) {
            (true, false) => only_first += 1,
            (false, true) => only_second += 1,
            _ => {}
        }
    }
    let n = only_first + only_second;
    // From the logarithm of the first term, so that many loops do not underflow early.
    let mut term = -(n as f64) * std::f64::consts::LN_2;
    let mut tail = term.exp();
    for k in 0..only_first.min(only_second) {
        term += ((n - k) as f64).ln() - ((k + 1) as f64).ln();
        tail += term.exp();
    }
    Discordant { only_first, only_second, p_value: (2.0 * tail).min(1.0) }
}

/// Whether a decision counts as an accusation, as in [`Counts`].
pub(super) fn is_called(decision: Decision) -> bool {
    let mut counts = Counts::default();
    counts.add(decision);
    counts.positive > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranked(sticky: &[Option<f64>], healthy: &[Option<f64>]) -> Vec<Ranked> {
        let class = |sticks: bool, scores: &[Option<f64>]| -> Vec<Ranked> {
            scores.iter().map(|score| Ranked { sticks, score: *score, valve: 0 }).collect()
        };
        [class(true, sticky), class(false, healthy)].concat()
    }

    fn some(scores: &[f64]) -> Vec<Option<f64>> {
        scores.iter().copied().map(Some).collect()
    }

    #[test]
    fn placements_are_means_over_pairs() {
        let (sticky, healthy) = ([Some(3.0), Some(1.0), None], [Some(2.0), Some(1.0)]);
        let found = Placements::of(&ranked(&sticky, &healthy)).unwrap();
        assert_eq!(found.sticky, [1.0, 0.25, 0.5]);
        let want = [(1.0 + 0.0 + 0.5) / 3.0, (1.0 + 0.5 + 0.5) / 3.0];
        assert!(found.healthy.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-15));
        // Both means are the area.
        let other = found.healthy.iter().sum::<f64>() / 2.0;
        assert!((found.area() - other).abs() < 1e-15);
    }

    #[test]
    fn the_variance_is_that_of_the_definition() {
        // By hand: V10 = (1, 1/2), V01 = (1/2, 1); both variances are 1/8, over two loops each.
        let found = auc_of_all(&ranked(&some(&[3.0, 1.0]), &some(&[2.0, 0.0]))).unwrap();
        let half = Z * (0.125f64 / 2.0 + 0.125 / 2.0).sqrt();
        assert!((found.value - 0.75).abs() < 1e-15);
        assert!((found.low - (0.75 - half)).abs() < 1e-12 && found.high == 1.0);
    }

    #[test]
    fn a_detector_equals_itself_and_beats_its_opposite() {
        let scores: Vec<f64> = (0..40).map(|k| f64::from((k * 17) % 40)).collect();
        let up = ranked(&some(&scores[20..]), &some(&scores[..20]));
        let same = compare_auc(&up, &up).unwrap();
        assert_eq!((same.difference.value, same.p_value), (0.0, 1.0));
        let apart = ranked(&some(&[8.0, 9.0, 5.5, 7.0]), &some(&[1.0, 2.0, 6.0, 3.0]));
        let turned: Vec<Ranked> =
            apart.iter().map(|each| Ranked { score: each.score.map(|s| -s), ..*each }).collect();
        let found = compare_auc(&apart, &turned).unwrap();
        assert!((found.first.value + found.second.value - 1.0).abs() < 1e-15);
        assert!(found.p_value < 1e-3 && found.difference.low > 0.0, "{found:?}");
        // The other way round the sign changes, and nothing else.
        let back = compare_auc(&turned, &apart).unwrap();
        assert_eq!(back.p_value, found.p_value);
        assert_eq!(back.difference.value, -found.difference.value);
        assert_eq!(compare_auc(&apart, &turned[1..]), None);
    }

    #[test]
    fn p_values_of_pure_chance_are_even() {
        // Two noisy views of one signal, of the same quality: p below 0.1 in a tenth of the trials.
        use stiction_model::closed_loop::NormalStream;
        let mut noise = NormalStream::new(5);
        let mut small = 0;
        for _ in 0..400 {
            let mut views = [vec![], vec![]];
            for k in 0..60 {
                let sticks = k % 2 == 0;
                let signal = f64::from(u8::from(sticks)) + noise.draw();
                for view in &mut views {
                    let score = Some(signal + noise.draw());
                    view.push(Ranked { sticks, score, valve: k });
                }
            }
            small += usize::from(compare_auc(&views[0], &views[1]).unwrap().p_value < 0.1);
        }
        assert!((20..62).contains(&small), "{small} of 400");
    }

    #[test]
    fn discordant_decisions_are_binomial() {
        use Decision::{Abstains, DoesNotStick, Sticks};
        let pairs = |b: usize, c: usize| {
            let only_first = std::iter::repeat_n((Sticks, Abstains), b);
            only_first
                .chain(std::iter::repeat_n((DoesNotStick, Sticks), c))
                .chain([(Sticks, Sticks)])
        };
        // 1 of 10: 2 (1 + 10) / 1024.
        let found = compare_decisions(pairs(9, 1));
        assert_eq!((found.only_first, found.only_second), (9, 1));
        assert!((found.p_value - 22.0 / 1024.0).abs() < 1e-12, "{}", found.p_value);
        assert_eq!(compare_decisions(pairs(0, 0)).p_value, 1.0);
        assert_eq!(compare_decisions(pairs(5, 5)).p_value, 1.0);
        assert!(compare_decisions(pairs(3000, 1000)).p_value < 1e-100);
    }
}
