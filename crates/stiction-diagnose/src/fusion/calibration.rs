//! From a margin to a probability.

use crate::error::{Error, Result};

/// A monotone map from the margin of a classifier to a probability, found on loops that the classifier
/// was not trained on.
#[derive(Debug, Clone, PartialEq)]
pub enum Calibration {
    /// Beta calibration: `logit p = a ln q - b ln(1 - q) + c` with `q = 1 / (1 + exp(-margin))` and
    /// a, b >= 0. Platt's logistic calibration is the case a = b.
    ///
    /// Source: M. Kull, T. M. Silva Filho, P. Flach, "Beta calibration: a well-founded and easily
    /// implemented improvement on logistic calibration for binary classifiers", AISTATS 2017
    /// (recalled, not read).
    Beta {
        /// Slope at low probabilities.
        a: f64,
        /// Slope at high probabilities.
        b: f64,
        /// Shift.
        c: f64,
    },
    /// Straight lines between points (margin, probability), constant beyond the ends: isotonic
    /// regression, joined.
    Isotonic(Vec<(f64, f64)>),
}

/// Largest slope, shift and margin: a larger value comes from a damaged file.
const LARGEST: f64 = 1e6;

impl Calibration {
    /// Returns `1 / (1 + exp(-margin))` unchanged.
    pub const IDENTITY: Self = Self::Beta { a: 1.0, b: 1.0, c: 0.0 };

    /// Accepts a map that is monotone and finite.
    ///
    /// # Errors
    /// If the map is not monotone or not finite.
    pub fn checked(self) -> Result<Self> {
        let sound = match &self {
            Self::Beta { a, b, c } => {
                [a, b, c].iter().all(|v| v.abs() <= LARGEST) && *a >= 0.0 && *b >= 0.0
            }
            Self::Isotonic(points) => {
                !points.is_empty()
                    && points.iter().all(|(m, p)| m.abs() <= LARGEST && (0.0..=1.0).contains(p))
                    && points.windows(2).all(|two| two[0].0 < two[1].0 && two[0].1 <= two[1].1)
            }
        };
        if sound { Ok(self) } else { Err(Error::Bundle("the calibration is not monotone".into())) }
    }

    /// The probability at a margin.
    pub fn probability(&self, margin: f64) -> f64 {
        match self {
            Self::Beta { a, b, c } => sigmoid(c + b * softplus(margin) - a * softplus(-margin)),
            Self::Isotonic(points) => {
                let above = points.partition_point(|(m, _)| *m < margin);
                match (above.checked_sub(1).map(|k| points[k]), points.get(above)) {
                    (Some((m0, p0)), Some((m1, p1))) => p0 + (p1 - p0) * (margin - m0) / (m1 - m0),
                    (Some((_, p)), None) => p,
                    (None, Some((_, p))) => *p,
                    (None, None) => 0.5,
                }
            }
        }
    }
}

/// `1 / (1 + exp(-x))`.
pub fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// `ln(1 + exp(x))`, without overflow.
pub fn softplus(x: f64) -> f64 {
    x.max(0.0) + (-x.abs()).exp().ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beta_of_one_one_nought_changes_nothing() {
        for margin in [-40.0, -2.0, 0.0, 0.3, 40.0] {
            let p = Calibration::IDENTITY.probability(margin);
            assert!((p - sigmoid(margin)).abs() < 1e-15, "{margin}: {p}");
        }
    }

    #[test]
    fn equal_slopes_are_platt() {
        let (slope, shift) = (0.7, -0.4);
        let beta = Calibration::Beta { a: slope, b: slope, c: shift };
        for margin in [-3.0, 0.0, 5.0] {
            let platt = sigmoid(slope * margin + shift);
            assert!((beta.probability(margin) - platt).abs() < 1e-15);
        }
    }

    #[test]
    fn points_are_joined() {
        let map = Calibration::Isotonic(vec![(-1.0, 0.1), (1.0, 0.5), (2.0, 0.5)]);
        let map = map.checked().unwrap();
        for (margin, p) in [(-9.0, 0.1), (-1.0, 0.1), (0.0, 0.3), (1.5, 0.5), (9.0, 0.5)] {
            assert!((map.probability(margin) - p).abs() < 1e-15, "{margin}");
        }
    }

    #[test]
    fn what_falls_is_refused() {
        let isotonic = |points: &[(f64, f64)]| Calibration::Isotonic(points.to_vec()).checked();
        assert!(isotonic(&[(0.0, 0.5), (1.0, 0.4)]).is_err());
        assert!(isotonic(&[(0.0, 0.5), (0.0, 0.6)]).is_err());
        assert!(isotonic(&[(0.0, 1.5)]).is_err());
        assert!(isotonic(&[]).is_err());
        assert!(Calibration::Beta { a: -1.0, b: 1.0, c: 0.0 }.checked().is_err());
    }
}
