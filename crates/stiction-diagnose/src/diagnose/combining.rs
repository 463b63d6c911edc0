//! How the windows or recordings of one valve are combined. The same rule serves a long record and a history of
//! many.
//!
//! # Evidence for sticking adds up, evidence against it does not
//!
//! Windows of one valve are not independent: they share the valve, the loop and the model's errors about both. With
//! log-odds `l_i`, none beyond those of [`SUREST`], and the share `d_i` of each window that overlaps none before it,
//!
//! ```text
//! l = n_e sum(d_i max(l_i, 0))/n + sum(d_i min(l_i, 0))/n
//! n = sum(d_i),   n_e = n/(1 + (n - 1) rho)
//! ```
//!
//! where `rho` is the correlation of their errors ([`CORRELATION`]). One window keeps its probability. Any number of
//! windows that agree that the valve sticks count as at most `1/rho` independent ones. Evidence against sticking
//! counts by its mean only. A valve that sticks too little to be seen in one window, that rests, or that is unknown
//! to the model, stays unseen in the next window, so repetition must not clear it. So longer records neither accuse
//! more healthy valves nor clear more sticking ones, and no window decides alone.
//!
//! `n` and both sums are added, so the result does not depend on the order of the windows, nor on how they are
//! grouped into recordings, files and days ([`Sum`]).
//!
//! The rule is ours. `rho` was chosen on simulated loops recorded 16 times as long. With 0.5, recall rises above
//! that of one window without more false accusations; with a third, they increase. All windows weigh the same: a
//! smaller weight for those in which the OP moves little was tried and gave nothing. The number of independent windows
//! follows L. Kish, "Survey Sampling", Wiley, 1965 (recalled, not read).

use crate::series::quantile;
use std::ops::{Add, Mul};

/// Assumed correlation of the errors of two windows of one valve; ours.
pub const CORRELATION: f64 = 0.5;
/// The highest probability that a window may have among others; ours.
pub const SUREST: f64 = 0.99;

/// What windows of one valve say together.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sum {
    /// Number of windows, what overlaps counted once.
    pub windows: f64,
    /// Sum of the log-odds above 0.
    pub above: f64,
    /// Sum of the log-odds below 0.
    pub below: f64,
}

impl Sum {
    /// One window, of which this share overlaps none before it.
    pub fn window(probability: f64, share: f64) -> Self {
        let l = log_odds(probability);
        Self { windows: 1.0, above: l.max(0.0), below: l.min(0.0) } * share
    }

    /// A recording of `windows` windows with this probability together, and `above`, the mean of their log-odds above
    /// 0. Without it they are taken to be alike.
    pub fn recording(probability: f64, windows: f64, above: Option<f64>) -> Self {
        let n = windows.max(1.0);
        let p = probability.clamp(1e-12, 1.0 - 1e-12);
        let together = (p / (1.0 - p)).ln();
        let above = limited(above.unwrap_or(together.max(0.0) / effective(n)).max(0.0));
        let below = limited((together - effective(n) * above).min(0.0));
        Self { windows: 1.0, above, below } * n
    }

    /// The mean of the log-odds above 0.
    pub fn mean_above(&self) -> f64 {
        self.above / self.windows
    }

    /// The probability that the valve sticks; `None` without a window.
    pub fn probability(&self) -> Option<f64> {
        let l = effective(self.windows) * self.mean_above() + self.below / self.windows;
        (self.windows > 0.0).then(|| 1.0 / (1.0 + (-l).exp()))
    }
}

impl Add for Sum {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            windows: self.windows + other.windows,
            above: self.above + other.above,
            below: self.below + other.below,
        }
    }
}

impl Mul<f64> for Sum {
    type Output = Self;

    fn mul(self, weight: f64) -> Self {
        Self {
            windows: weight * self.windows,
            above: weight * self.above,
            below: weight * self.below,
        }
    }
}

impl std::iter::Sum for Sum {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}

/// Log-odds, limited to those of [`SUREST`].
pub(super) fn log_odds(probability: f64) -> f64 {
    let p = probability.clamp(1.0 - SUREST, SUREST);
    (p / (1.0 - p)).ln()
}

fn limited(log_odds: f64) -> f64 {
    let most = (SUREST / (1.0 - SUREST)).ln();
    log_odds.clamp(-most, most)
}

/// The number of independent windows that `n` windows of one valve count as; at least 1.
fn effective(n: f64) -> f64 {
    let n = n.max(1.0);
    n / (1.0 + (n - 1.0) * CORRELATION)
}

/// The probability of windows `(probability, share)` together; `None` for none. A single one is returned bit for bit.
pub(super) fn together(windows: &[(f64, f64)]) -> Option<f64> {
    match windows {
        [(only, _)] => Some(*only),
        _ => windows.iter().map(|(p, share)| Sum::window(*p, *share)).sum::<Sum>().probability(),
    }
}

/// Rank, as a share of the windows, of the limit for all of them.
const LIMIT_RANK: f64 = 0.4;

/// The detection limit of a record from those of its windows, percent of span. An S above it would have been
/// detected with the confidence of each window's limit. A window without a limit counts as one without any
/// information.
///
/// It is the 40 % quantile, the rank rounded up. Each limit `L_i` fails for one sticking valve in twenty: S is
/// above it. The smallest of many limits would fail far more often, because low outliers are selected. The largest
/// would never fail more often, but one calm window makes it useless. For any dependence between failures, more
/// than half of the limits can fail together in at most one valve of ten (Markov). Assume that the `ln(S/L_i)` have
/// the same Gaussian distribution and any correlation `rho` from 0 to 1. Then the limit of rank `r` of K fails with
/// `Phi((-1.645 + sqrt(1 - rho) z_r)/sd)`, with `sd` below one because the windows' own errors average out. At 40 %
/// this never exceeds 5 %, at the lower quartile it reaches 6 %. If limits deviate from these assumptions,
/// calibrate on long records.
pub fn combined_limit(limits: &[Option<f64>]) -> Option<f64> {
    let mut sorted: Vec<f64> = limits
        .iter()
        .map(|limit| limit.filter(|l| l.is_finite()).unwrap_or(f64::INFINITY))
        .collect();
    sorted.sort_by(f64::total_cmp);
    // The order statistic whose expected normal score is that of the rank (Blom).
    let rank = (LIMIT_RANK * (sorted.len() as f64 + 0.25) + 0.375).ceil() as usize;
    let limit = *sorted.get(rank.clamp(1, sorted.len().max(1)) - 1)?;
    limit.is_finite().then_some(limit)
}

/// The typical value of positive numbers with equal weights: the median of their logarithms.
pub(super) fn typical(values: impl Iterator<Item = f64>) -> f64 {
    quantile(&values.map(f64::ln).collect::<Vec<_>>(), 0.5).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;
    use proptest::prelude::*;

    fn of(probabilities: &[f64]) -> f64 {
        together(&probabilities.iter().map(|p| (*p, 1.0)).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn one_keeps_its_probability_and_many_do_not_run_away() {
        for p in [0.0, 0.3, 0.999_999, 1.0] {
            assert_eq!(of(&[p]), p);
            assert_eq!(together(&[(p, 0.2)]), Some(p));
        }
        // Two of 0.8 count as 2/(1 + 0.5) = 4/3: odds 4^(4/3).
        let odds = 4f64.powf(4.0 / 3.0);
        assert!((of(&[0.8, 0.8]) - odds / (1.0 + odds)).abs() < 1e-12);
        // However many: no more than two independent ones, odds 16.
        let many = of(&[0.8; 500]);
        assert!(many < 16.0 / 17.0 && many > 15.5 / 16.5, "{many}");
        assert_eq!((together(&[]), Sum::default().probability()), (None, None));
    }

    #[test]
    fn what_speaks_against_does_not_add_up() {
        assert!((of(&[0.2; 2]) - 0.2).abs() < 1e-12);
        assert!((of(&[0.2; 500]) - 0.2).abs() < 1e-12);
        // Half of the windows see it: that is worth more than that the others do not.
        assert!(of(&[0.9, 0.1, 0.9, 0.1]) > 0.5);
    }

    #[test]
    fn more_of_the_same_never_speaks_less_for_sticking() {
        let some = [0.97, 0.4, 0.15, 0.8, 0.03];
        let mut last = 0.0;
        for times in 1..40 {
            let p = of(&some.repeat(times));
            assert!(p >= last, "{times}: {p} after {last}");
            last = p;
        }
    }

    #[test]
    fn a_few_bad_windows_do_not_decide() {
        let mut windows = vec![0.08; 40];
        windows[..3].fill(1.0);
        assert!(of(&windows) < 0.2);
        windows.fill(0.95);
        windows[..3].fill(0.0);
        assert!(of(&windows) > 0.95);
    }

    #[test]
    fn a_window_that_overlaps_counts_by_its_own_share() {
        let half = together(&[(0.8, 1.0), (0.8, 0.5)]).unwrap();
        assert!(half > 0.8 && half < of(&[0.8, 0.8]));
        assert!((together(&[(0.8, 1.0), (0.3, 0.0)]).unwrap() - 0.8).abs() < 1e-12);
    }

    proptest! {
        /// As recordings, of which only probability, number of windows and the mean above 0 are kept.
        #[test]
        fn windows_give_the_same_however_they_are_grouped(
            windows in prop::collection::vec(0.0..=1.0f64, 2..80),
            cuts in prop::collection::vec(any::<bool>(), 80),
            turn in 0..80usize,
        ) {
            let at_once = of(&windows);
            let mut groups: Vec<Vec<f64>> = vec![vec![]];
            for (p, cut) in windows.iter().zip(cuts) {
                if cut && !groups.last().unwrap().is_empty() {
                    groups.push(vec![]);
                }
                groups.last_mut().unwrap().push(*p);
            }
            let middle = turn % groups.len();
            groups.rotate_left(middle);
            let recording = |group: &Vec<f64>| {
                let sum: Sum = group.iter().map(|p| Sum::window(*p, 1.0)).sum();
                Sum::recording(of(group), sum.windows, Some(sum.mean_above()))
            };
            let merged: Sum = groups.iter().map(recording).sum();
            prop_assert!((merged.probability().unwrap() - at_once).abs() < 1e-9);
        }
    }

    #[test]
    fn limits_of_few_and_of_none() {
        assert_eq!(combined_limit(&[]), None);
        assert_eq!(combined_limit(&[Some(2.0)]), Some(2.0));
        assert_eq!(combined_limit(&[Some(2.0), Some(5.0)]), Some(5.0));
        assert_eq!(combined_limit(&[Some(3.0), Some(9.0), Some(2.0)]), Some(3.0));
        // One window in three that shows nothing costs little, half of them cost the limit.
        assert_eq!(combined_limit(&[Some(1.0), Some(2.0), None]), Some(2.0));
        assert_eq!(combined_limit(&[Some(1.0), None, Some(f64::NAN), None]), None);
    }

    /// Windows whose limits fail in one of twenty, with any correlation.
    #[test]
    fn the_combined_limit_fails_no_more_often_than_each() {
        let mut stream = NormalStream::new(5);
        let trials = 8_000;
        for rho in [0.0, 0.3, 0.6, 0.8, 0.95, 1.0] {
            for windows in [2, 5, 10, 60] {
                let mut failed = 0;
                for _ in 0..trials {
                    let shared = f64::sqrt(rho) * stream.draw();
                    let limits: Vec<Option<f64>> = (0..windows)
                        .map(|_| {
                            let own = f64::sqrt(1.0 - rho) * stream.draw();
                            // ln L for S of 1.
                            Some((1.6449 + shared + own).exp())
                        })
                        .collect();
                    failed += usize::from(combined_limit(&limits).unwrap() < 1.0);
                }
                // 5 % and three standard deviations.
                let share = failed as f64 / trials as f64;
                assert!(share < 0.05 + 3.0 * 0.0025, "{share} at {rho} of {windows}");
            }
        }
    }
}
