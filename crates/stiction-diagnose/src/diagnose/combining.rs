//! How the windows or recordings of one valve are combined. The same rule serves a long record and a history of
//! many.
//!
//! # Evidence for sticking adds up, evidence against it does not
//!
//! Windows of one valve are not independent: they share the valve, the loop and the model's errors about both. With
//! log-odds `l_i` of weights `w_i`, none beyond those of [`SUREST`],
//!
//! ```text
//! l = n_e sum(w_i max(l_i, 0))/sum(w_i) + sum(w_i min(l_i, 0))/sum(w_i)
//! n_e = n/(1 + (n - 1) rho),   n = (sum w_i)^2/sum(w_i^2)
//! ```
//!
//! where `n` is Kish's effective number of windows and `rho` the correlation of their errors ([`CORRELATION`]). One
//! window keeps its probability. Any number of windows that agree that the valve sticks count as at most `1/rho`
//! independent ones. Evidence against sticking counts by its mean only. A valve that sticks too little to be seen
//! in one window, that rests, or that is unknown to the model, stays unseen in the next window, so repetition must
//! not clear it. So longer records neither accuse more healthy valves nor clear more sticking ones, and no window
//! decides alone.
//!
//! The rule is ours. `rho` was chosen on simulated loops recorded 16 times as long. With 0.5, recall rises above
//! that of one window without more false accusations; with a third, they increase. Effective sizes are from L.
//! Kish, "Survey Sampling", Wiley, 1965 (recalled, not read).
//!
//! # Weights
//!
//! A window in which the OP moves less than half its typical distance has a smaller weight ([`weights`]): a valve
//! that is hardly asked to move cannot show that it sticks.

use crate::series::{median, quantile};

/// Assumed correlation of the errors of two windows of one valve; ours.
pub const CORRELATION: f64 = 0.5;
/// The highest probability that a window may have among others; ours.
pub const SUREST: f64 = 0.99;
/// Share of the typical span of the OP from which a window has its full weight; ours.
const MOVES: f64 = 0.5;

/// The evidence of one recording or window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Witness {
    /// The probability that the valve sticks.
    pub probability: f64,
    /// Its weight.
    pub weight: f64,
    /// Effective number of windows in it; 1 for one.
    pub windows: f64,
}

/// Log-odds, limited to those of [`SUREST`].
pub(super) fn log_odds(probability: f64) -> f64 {
    let p = probability.clamp(1.0 - SUREST, SUREST);
    (p / (1.0 - p)).ln()
}

/// The number of independent windows that `n` windows of one valve count as; at least 1.
pub fn effective(n: f64) -> f64 {
    let n = n.max(1.0);
    n / (1.0 + (n - 1.0) * CORRELATION)
}

/// Kish's effective number of windows of these weights, `(sum w)^2/sum(w^2)`; 0 for none.
pub fn effective_number(weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    if squares > 0.0 { total * total / squares } else { 0.0 }
}

/// The weights of windows with these spans of the OP without its slow part, percent.
pub fn weights(spans: &[f64]) -> Vec<f64> {
    let full = MOVES * median(spans);
    spans.iter().map(|span| if full > 0.0 { (span / full).min(1.0) } else { 1.0 }).collect()
}

/// The combined probability of one valve's recordings; `None` if none has a weight. A single probability is
/// returned bit for bit.
pub fn probability(witnesses: &[Witness]) -> Option<f64> {
    let heard: Vec<&Witness> = witnesses.iter().filter(|w| w.weight > 0.0).collect();
    if let [only] = heard[..] {
        return Some(only.probability);
    }
    // n windows that were combined before count as n windows here.
    let parts: Vec<(f64, f64)> = heard
        .iter()
        .map(|w| {
            let of_all = log_odds_of_many(w.probability);
            let each = if of_all > 0.0 { of_all / effective(w.windows) } else { of_all };
            (limited(each), w.weight * w.windows.max(1.0))
        })
        .collect();
    let total: f64 = parts.iter().map(|(_, w)| w).sum();
    let squares: f64 = heard.iter().map(|w| w.weight * w.weight * w.windows.max(1.0)).sum();
    (total > 0.0 && squares > 0.0).then(|| of_parts(&parts, total * total / squares))
}

/// The probability of windows `(probability, weight)` that hold as much data as `n` of them; `None` for none. A
/// single probability is returned bit for bit.
pub(super) fn of_windows(windows: &[(f64, f64)], n: f64) -> Option<f64> {
    match windows {
        [] => None,
        [(only, _)] => Some(*only),
        _ => {
            let parts: Vec<(f64, f64)> = windows.iter().map(|(p, w)| (log_odds(*p), *w)).collect();
            Some(of_parts(&parts, n))
        }
    }
}

/// The rule: log-odds and weights of windows, and their effective number.
fn of_parts(parts: &[(f64, f64)], n: f64) -> f64 {
    let total: f64 = parts.iter().map(|(_, w)| w).sum();
    let mean = |of: fn(f64) -> f64| parts.iter().map(|(l, w)| w * of(*l)).sum::<f64>() / total;
    let sum = effective(n) * mean(|l| l.max(0.0)) + mean(|l| l.min(0.0));
    1.0 / (1.0 + (-sum).exp())
}

fn limited(log_odds: f64) -> f64 {
    let most = (SUREST / (1.0 - SUREST)).ln();
    log_odds.clamp(-most, most)
}

/// The largest log-odds that many windows may have together.
fn log_odds_of_many(probability: f64) -> f64 {
    let p = probability.clamp(1e-12, 1.0 - 1e-12);
    (p / (1.0 - p)).ln()
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

    fn one(probability: f64) -> Witness {
        Witness { probability, weight: 1.0, windows: 1.0 }
    }

    fn of(probabilities: &[f64]) -> f64 {
        probability(&probabilities.iter().map(|p| one(*p)).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn one_keeps_its_probability_and_many_do_not_run_away() {
        for p in [0.0, 0.3, 0.999_999, 1.0] {
            assert_eq!(of(&[p]), p);
            assert_eq!(of_windows(&[(p, 0.2)], 1.0), Some(p));
        }
        // Two of 0.8 count as 2/(1 + 0.5) = 4/3: odds 4^(4/3).
        let odds = 4f64.powf(4.0 / 3.0);
        assert!((of(&[0.8, 0.8]) - odds / (1.0 + odds)).abs() < 1e-12);
        // However many: no more than two independent ones, odds 16.
        let many = of(&[0.8; 500]);
        assert!(many < 16.0 / 17.0 && many > 15.5 / 16.5, "{many}");
        assert_eq!(probability(&[]), None);
        assert_eq!(probability(&[Witness { weight: 0.0, ..one(0.5) }]), None);
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
    fn parts_put_together_first_say_the_same() {
        let days = [[0.9, 0.7, 0.95, 0.6], [0.8, 0.85, 0.7, 0.99]];
        let at_once = of(&days.concat());
        let by_day: Vec<Witness> =
            days.iter().map(|day| Witness { windows: 4.0, ..one(of(day)) }).collect();
        assert!((probability(&by_day).unwrap() - at_once).abs() < 1e-12);
    }

    #[test]
    fn windows_in_which_little_moves_count_little() {
        assert_eq!(weights(&[10.0, 8.0, 12.0, 1.0]), [1.0, 1.0, 1.0, 1.0 / 4.5]);
        assert_eq!(weights(&[5.0]), [1.0]);
        assert!((effective_number(&[1.0, 1.0, 0.0]) - 2.0).abs() < 1e-12);
        assert_eq!(effective_number(&[]), 0.0);
        let calm = |weight| Witness { weight, ..one(0.05) };
        let both = |weight| probability(&[one(0.9), calm(weight)]).unwrap();
        assert!(both(0.05) > both(0.5) && both(0.5) > both(1.0));
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
