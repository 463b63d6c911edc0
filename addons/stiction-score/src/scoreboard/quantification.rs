//! Accuracy of the estimates of S and J.

use super::Share;
use stiction_diagnose::diagnose::Estimate;
use stiction_diagnose::series::quantile;

/// Estimates against the truth.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Quantification {
    /// Number of loops with an estimate.
    pub quantified: Share,
    /// Distance of the estimates from the truth, percent of span; `None` without estimates.
    pub absolute: Option<Errors>,
    /// Distance as a share of the truth, over loops with a truth above zero.
    pub relative: Option<Errors>,
    /// Number of intervals that contain the truth. An estimate whose interval is unknown (NaN) has none.
    pub covered: Share,
}

/// Quantiles of errors.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Errors {
    /// The median.
    pub median: f64,
    /// Lower end of the 95 % interval of the median, from the order of the errors.
    pub median_low: f64,
    /// Upper end of the 95 % interval of the median.
    pub median_high: f64,
    /// The 90 % quantile.
    pub p90: f64,
}

impl Quantification {
    /// From loops with known truth, in percent of span, and their estimates. A truth that is not finite is left
    /// out.
    pub fn of(loops: impl IntoIterator<Item = (f64, Option<Estimate>)>) -> Self {
        let (mut quantified, mut covered) = (Share::default(), Share::default());
        let (mut absolute, mut relative) = (vec![], vec![]);
        for (truth, estimate) in loops {
            if !truth.is_finite() {
                continue;
            }
            quantified.n += 1;
            let Some(Estimate { value, low, high }) = estimate.filter(|e| e.value.is_finite())
            else {
                continue;
            };
            quantified.k += 1;
            if !(low.is_nan() || high.is_nan()) {
                covered.n += 1;
                covered.k += usize::from((low..=high).contains(&truth));
            }
            absolute.push((value - truth).abs());
            if truth > 0.0 {
                relative.push((value - truth).abs() / truth);
            }
        }
        Self {
            quantified,
            absolute: Errors::of(&absolute),
            relative: Errors::of(&relative),
            covered,
        }
    }
}

impl Errors {
    /// Statistics of some errors, or of other numbers; `None` for an empty list.
    ///
    /// The interval of the median lies between the numbers of rank `n/2 - 0.98 sqrt n` and `n/2 + 0.98 sqrt n`: their
    /// count below the true median is binomial.
    pub fn of(errors: &[f64]) -> Option<Self> {
        let half = 0.98 / (errors.len() as f64).sqrt();
        (!errors.is_empty()).then(|| Self {
            median: quantile(errors, 0.5),
            median_low: quantile(errors, (0.5 - half).max(0.0)),
            median_high: quantile(errors, (0.5 + half).min(1.0)),
            p90: quantile(errors, 0.9),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_and_coverage_of_known_estimates() {
        let estimate = |value: f64| Some(Estimate { value, low: value - 0.5, high: value + 0.5 });
        // Eleven truths of 2, estimated 0 to 1 too high; and some that are not estimated.
        let estimated = (0..=10).map(|k| (2.0, estimate(2.0 + 0.1 * f64::from(k))));
        let found = Quantification::of(estimated.chain([(5.0, None), (f64::NAN, estimate(1.0))]));
        assert_eq!(found.quantified, Share { k: 11, n: 12 });
        // Those that are at most 0.5 off, rounding aside.
        assert!((5..=6).contains(&found.covered.k) && found.covered.n == 11);
        let (absolute, relative) = (found.absolute.unwrap(), found.relative.unwrap());
        assert!((absolute.median - 0.5).abs() < 1e-12 && (absolute.p90 - 0.9).abs() < 1e-12);
        assert!((relative.median - 0.25).abs() < 1e-12 && (relative.p90 - 0.45).abs() < 1e-12);
    }

    #[test]
    fn without_estimates_there_are_no_errors() {
        let found = Quantification::of([(2.0, None), (0.0, None)]);
        assert_eq!(found.quantified, Share { k: 0, n: 2 });
        assert_eq!((found.absolute, found.covered.value()), (None, None));
        // A truth of zero has no relative error.
        let zero = Estimate { value: 0.5, low: 0.0, high: 1.0 };
        let found = Quantification::of([(0.0, Some(zero))]);
        assert_eq!((found.relative, found.absolute.unwrap().median), (None, 0.5));
    }
}
