//! Accuracy of a bundle on unseen loops.

use crate::dataset::{Dataset, Truth};
use crate::learn::fault;
use anyhow::Result;
use rayon::prelude::*;
use std::ops::Range;
use stiction_diagnose::fusion::{Bundle, Cause, Estimate, Weighed};
use stiction_score::scoreboard::wilson;

/// S is a number, and not only a bound, if its interval extends on average at most this share of S to either side.
pub const QUANTIFIED: f64 = stiction_diagnose::diagnose::WIDEST;

/// Output of a bundle for every row.
pub fn judge(bundle: &Bundle, data: &Dataset, op_only: bool) -> Result<Vec<Weighed>> {
    let weigh = |row: usize| bundle.weigh(&data.row(row), data.truth[row].op_span, op_only);
    Ok((0..data.truth.len()).into_par_iter().map(weigh).collect::<stiction_model::Result<_>>()?)
}

/// The probability that a loop with a fault has a higher score than one without; ties count half.
///
/// Source: H. B. Mann, D. R. Whitney, Ann. Math. Stat. 18 (1947) 50-60 (recalled, not read).
pub fn auc(scored: &[(f64, bool)]) -> f64 {
    let mut sorted = scored.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut pairs, mut negatives, mut positives) = (0.0, 0.0, 0.0);
    for tied in sorted.chunk_by(|a, b| a.0 == b.0) {
        let hits = tied.iter().filter(|(_, hit)| *hit).count() as f64;
        let misses = tied.len() as f64 - hits;
        pairs += hits * (negatives + 0.5 * misses);
        negatives += misses;
        positives += hits;
    }
    pairs / (positives * negatives)
}

/// A count of a total.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    pub k: usize,
    pub n: usize,
}

impl Share {
    pub fn of(outcomes: impl IntoIterator<Item = bool>) -> Self {
        outcomes.into_iter().fold(Self::default(), |share, hit| Self {
            k: share.k + usize::from(hit),
            n: share.n + 1,
        })
    }

    pub fn value(self) -> f64 {
        self.k as f64 / self.n as f64
    }
}

impl std::fmt::Display for Share {
    /// The share, its 95 % interval (Wilson) and its n.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.n == 0 {
            return f.write_str("none");
        }
        let (low, high) = wilson(self.k, self.n);
        write!(f, "{:.3} [{low:.3}, {high:.3}] of {}", self.value(), self.n)
    }
}

/// Accuracy of fault detection.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    pub auc: f64,
    /// The mean square of probability less truth.
    pub brier: f64,
    pub log_loss: f64,
    /// Tenths of probability: predicted on average, and observed.
    pub deciles: Vec<(Range<f64>, f64, Share)>,
    /// Share of loops with a probability of at most 0.2 or at least 0.8.
    pub decided: Share,
    /// Share of right decisions among these.
    pub right: Share,
    /// Share of the visible faults with a probability of at least 0.8.
    pub recall: Share,
    /// Share of faults among the loops with a probability of at least 0.8.
    pub precision: Share,
    /// Share of the invisible faults with a probability of at least 0.8.
    pub hidden_called: Share,
    /// For each kind, the shares of loops with a probability of at least 0.8, 0.85 and 0.9, without invisible faults.
    pub called: Vec<(String, [Share; 3])>,
    /// Share of the loops without a fault whose likeliest cause, apart from faults, is the true cause.
    pub causes: Share,
}

/// The thresholds of [`Detection::called`].
pub const THRESHOLDS: [f64; 3] = [0.8, 0.85, 0.9];

pub fn detection(truth: &[Truth], weighed: &[Weighed]) -> Detection {
    let known: Vec<(&Truth, &Weighed, bool)> = truth
        .iter()
        .zip(weighed)
        .filter_map(|(truth, weighed)| Some((truth, weighed, fault(truth)?)))
        .collect();
    let scored: Vec<(f64, bool)> =
        known.iter().map(|(_, weighed, hit)| (weighed.probability, *hit)).collect();
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        let sum: f64 = scored.iter().map(|(p, hit)| of(*p, f64::from(*hit))).sum();
        sum / scored.len() as f64
    };
    let is_decided = |p: f64| p <= 0.2 || p >= 0.8;
    let decile = |k: usize| {
        let (from, to) = (k as f64 / 10.0, (k + 1) as f64 / 10.0);
        let part: Vec<_> =
            scored.iter().filter(|(p, _)| *p >= from && (*p < to || k == 9)).collect();
        let predicted = part.iter().map(|(p, _)| p).sum::<f64>() / part.len() as f64;
        (from..to, predicted, Share::of(part.iter().map(|(_, hit)| *hit)))
    };
    let mut kinds: Vec<&str> = truth.iter().map(|truth| &truth.kind[..]).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let called = |kind: &str| {
        let of = |threshold: f64| {
            let kind = known.iter().filter(|(truth, ..)| truth.kind == kind);
            Share::of(kind.map(|(_, weighed, _)| weighed.probability >= threshold))
        };
        (kind.to_owned(), THRESHOLDS.map(of))
    };
    let hidden = truth.iter().zip(weighed).filter(|(truth, _)| fault(truth).is_none());
    let likeliest = |weighed: &Weighed| {
        let others = weighed.causes.iter().filter(|(cause, _)| !cause.is_fault());
        others.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(cause, _)| *cause)
    };
    let healthy = known.iter().filter(|(.., hit)| !hit);
    Detection {
        auc: auc(&scored),
        brier: mean(&|p, hit| (p - hit) * (p - hit)),
        log_loss: mean(&|p, hit| -(1.0 - (p - hit).abs()).max(1e-12).ln()),
        deciles: (0..10).map(decile).collect(),
        decided: Share::of(scored.iter().map(|(p, _)| is_decided(*p))),
        right: Share::of(
            scored.iter().filter(|(p, _)| is_decided(*p)).map(|(p, hit)| (*p >= 0.8) == *hit),
        ),
        recall: Share::of(scored.iter().filter(|(_, hit)| *hit).map(|(p, _)| *p >= 0.8)),
        precision: Share::of(scored.iter().filter(|(p, _)| *p >= 0.8).map(|(_, hit)| *hit)),
        hidden_called: Share::of(hidden.map(|(_, weighed)| weighed.probability >= 0.8)),
        called: kinds.into_iter().map(called).collect(),
        causes: Share::of(
            healthy.map(|(truth, weighed, _)| likeliest(weighed) == Some(truth.cause)),
        ),
    }
}

/// Errors of estimates, and whether their intervals contain the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimation {
    /// Median and 90 % quantile of the error.
    pub error: (f64, f64),
    pub coverage: Share,
    /// Median of the interval's width.
    pub width: f64,
}

/// From estimates and truths: errors and widths over the truth if `relative`.
pub fn estimation(estimates: &[(Estimate, f64)], relative: bool) -> Estimation {
    let scale = |truth: f64| if relative { truth } else { 1.0 };
    let of = |each: &dyn Fn(&Estimate, f64) -> f64, share: f64| {
        let values = estimates.iter().map(|(found, truth)| each(found, *truth) / scale(*truth));
        quantile(values.collect(), share)
    };
    let error = |found: &Estimate, truth: f64| (found.value - truth).abs();
    Estimation {
        error: (of(&error, 0.5), of(&error, 0.9)),
        coverage: Share::of(
            estimates.iter().map(|(found, truth)| (found.low..=found.high).contains(truth)),
        ),
        width: of(&|found, _| found.high - found.low, 0.5),
    }
}

/// Whether an S has an interval narrow enough to be a number.
pub fn is_quantified(s: &Estimate) -> bool {
    s.high - s.low <= 2.0 * QUANTIFIED * s.value
}

/// The smallest value with this share of the values at or below it; NaN without values.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (share * (values.len().max(1) - 1) as f64).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}

/// The estimates of visibly sticking valves that pass a test, with the truth from `known`.
pub fn estimates<'a>(
    truth: &'a [Truth],
    weighed: &'a [Weighed],
    known: impl Fn(&Truth) -> Option<f64> + 'a,
    of: impl Fn(&Weighed) -> Estimate + 'a,
) -> Vec<(Estimate, f64, &'a Weighed)> {
    let sticking =
        truth.iter().zip(weighed).filter(|(truth, _)| truth.cause == Cause::StickingValve);
    sticking.filter_map(|(truth, weighed)| Some((of(weighed), known(truth)?, weighed))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_under_curves() {
        assert_eq!(auc(&[(0.1, false), (0.9, true)]), 1.0);
        assert_eq!(auc(&[(0.9, false), (0.1, true)]), 0.0);
        assert_eq!(auc(&[(0.5, false), (0.5, true), (0.5, true)]), 0.5);
        // Of six pairs four are in order and one is tied.
        let scored = [(1.0, false), (2.0, false), (3.0, false), (3.0, true), (1.5, true)];
        assert_eq!(auc(&scored), 3.5 / 6.0);
    }

    #[test]
    fn errors_and_coverage() {
        let of = |value: f64, truth: f64| {
            (Estimate { value, low: value - 1.0, high: value + 1.0 }, truth)
        };
        let found = estimation(&[of(2.0, 2.0), of(3.0, 2.0), of(6.0, 4.0)], true);
        assert_eq!(found.error, (0.5, 0.5));
        assert_eq!(found.coverage, Share { k: 2, n: 3 });
        assert_eq!(found.width, 1.0);
        assert!(is_quantified(&Estimate { value: 10.0, low: 8.0, high: 14.9 }));
        assert!(!is_quantified(&Estimate { value: 10.0, low: 8.0, high: 15.1 }));
    }
}
