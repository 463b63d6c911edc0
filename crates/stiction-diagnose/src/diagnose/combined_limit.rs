//! The detection limit of several windows together.

/// Rank, as a share of the windows, of the limit for all of them.
const LIMIT_RANK: f64 = 0.4;

/// The detection limit of a record from the limits of its windows, percent of span. An S above it would have been
/// detected with the confidence of each window's limit. A window without a limit counts as a window without
/// information.
///
/// It is the 40 % quantile, the rank rounded up. Each limit `L_i` is wrong for one sticking valve in twenty, whose S is
/// above it. The smallest of many limits would fail far more often, because low outliers are selected. The largest
/// would never fail more often, but one calm window makes it useless. Even if failures depend on each other, more than
/// half of the limits fail together for at most one valve in ten (Markov). Assume that the `ln(S/L_i)` have the same
/// Gaussian distribution and any correlation `rho` from 0 to 1. Then the limit of rank `r` of K fails with
/// `Phi((-1.645 + sqrt(1 - rho) z_r)/sd)`, with `sd` below one because the windows' own errors average out. At 40 % this
/// never exceeds 5 %, at the lower quartile it reaches 6 %. If limits deviate from these assumptions, calibrate on long
/// records.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

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
