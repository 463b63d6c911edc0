//! Intervals with their nominal coverage.

use super::trees::Ensemble;
use crate::error::{Error, Result};
use crate::estimate::Estimate;

/// The share of intervals that should contain the truth.
pub const COVERAGE: f64 = 0.9;

/// Three regressions of quantiles, and the shift that gives the interval between the outer two its nominal
/// coverage.
///
/// Conformalised quantile regression: on loops left out of training, the error of the interval `[q_low, q_high]` is
/// `max(q_low - y, y - q_high)`. Its 90 % quantile c moves both ends, to `[q_low - c, q_high + c]`, which then covers
/// 90 % of similar loops. One c for all would hold overall, but not among the loops with a narrow interval. Only these
/// loops get a number. So c is found for each class of predicted width `q_high - q_low`.
///
/// Source: Y. Romano, E. Patterson, E. Candès, "Conformalized quantile regression", NeurIPS 32 (2019);
/// classes after V. Vovk, "Conditional validity of inductive conformal predictors", ACML 2012 (both
/// recalled, not read). Assumes loops like the simulated ones: under a wrong population coverage falls.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantiles {
    /// The 5 % quantile.
    pub low: Ensemble,
    /// The median.
    pub middle: Ensemble,
    /// The 95 % quantile.
    pub high: Ensemble,
    /// The largest predicted width of each class, ascending, and its c. Larger widths belong to the last class.
    pub shifts: Vec<(f64, f64)>,
    /// Factor that widens the moved interval around its middle, at least 1, so that it covers kinds of loops left
    /// out of training nearly as often.
    pub stretch: f64,
}

impl Quantiles {
    /// Accepts shifts that are finite and whose widths ascend.
    ///
    /// # Errors
    /// If the shifts are not finite, their widths do not ascend, or the list is empty.
    pub fn checked(self) -> Result<Self> {
        let sound = !self.shifts.is_empty()
            && self.shifts.iter().all(|(width, shift)| !width.is_nan() && shift.is_finite())
            && self.shifts.windows(2).all(|two| two[0].0 < two[1].0)
            && self.stretch.is_finite()
            && self.stretch >= 1.0;
        if sound { Ok(self) } else { Err(Error::Bundle("the widths do not ascend".into())) }
    }

    /// The quantiles before the shift, in order: low, median, high. Crossed ones are sorted.
    pub fn raw(&self, row: &[f32]) -> [f64; 3] {
        let mut quantiles = [&self.low, &self.middle, &self.high].map(|each| each.margin(row));
        quantiles.sort_by(f64::total_cmp);
        quantiles
    }

    /// The median and the moved interval, which always contains the median.
    pub fn estimate(&self, row: &[f32]) -> Estimate {
        let [low, value, high] = self.raw(row);
        let shift = self.shift(high - low);
        let more = (self.stretch - 1.0) * (0.5 * (high - low) + shift).max(0.0);
        let moved = shift + more;
        Estimate { value, low: (low - moved).min(value), high: (high + moved).max(value) }
    }

    /// The shift of an interval of that predicted width.
    fn shift(&self, width: f64) -> f64 {
        let class = self.shifts.partition_point(|(largest, _)| *largest < width);
        self.shifts.get(class).or(self.shifts.last()).map_or(0.0, |(_, shift)| *shift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::trees::Node;

    fn constant(value: f32) -> Ensemble {
        Ensemble::new(0.0, &[vec![Node::Leaf(value)]]).unwrap()
    }

    fn of(quantiles: [f32; 3], shifts: &[(f64, f64)]) -> Quantiles {
        let [low, middle, high] = quantiles.map(constant);
        Quantiles { low, middle, high, shifts: shifts.to_vec(), stretch: 1.0 }
    }

    #[test]
    fn the_class_of_the_width_moves_the_ends() {
        let shifts = [(1.0, 0.25), (2.0, 0.5), (f64::INFINITY, 1.0)];
        for (half, shift) in [(0.5_f32, 0.25), (0.75, 0.5), (1.0, 0.5), (4.0, 1.0)] {
            let estimate = of([-half, 0.0, half], &shifts).estimate(&[]);
            let end = f64::from(half) + shift;
            assert_eq!(estimate, Estimate { value: 0.0, low: -end, high: end });
        }
        assert_eq!(of([0.0, 1.0, 9.0], &shifts[..1]).estimate(&[]).high, 9.25);
    }

    #[test]
    fn a_stretch_widens_about_the_middle() {
        let stretched = Quantiles { stretch: 1.5, ..of([-1.0, 0.0, 2.0], &[(9.0, 0.5)]) };
        assert_eq!(stretched.estimate(&[]), Estimate { value: 0.0, low: -2.5, high: 3.5 });
        assert!(Quantiles { stretch: 0.9, ..stretched.clone() }.checked().is_err());
        assert!(Quantiles { stretch: f64::NAN, ..stretched }.checked().is_err());
    }

    #[test]
    fn the_median_stays_inside() {
        let estimate = of([0.0, 0.125, 1.0], &[(2.0, -0.5)]).estimate(&[]);
        assert_eq!(estimate, Estimate { value: 0.125, low: 0.125, high: 0.5 });
        assert_eq!(of([1.0, 0.0, 0.5], &[(2.0, 0.0)]).raw(&[]), [0.0, 0.5, 1.0]);
    }

    #[test]
    fn classes_must_ascend() {
        assert!(of([0.0; 3], &[]).checked().is_err());
        assert!(of([0.0; 3], &[(1.0, 0.0), (1.0, 0.0)]).checked().is_err());
        assert!(of([0.0; 3], &[(1.0, f64::NAN)]).checked().is_err());
        assert!(of([0.0; 3], &[(1.0, -0.1), (f64::INFINITY, 0.0)]).checked().is_ok());
    }
}
