//! Least squares with a few columns, and features of its residuals.

use crate::series::{excess_kurtosis, std, variance};

/// Ridge that keeps rounding from separating nearly equal columns, as a share of their squares.
const RIDGE: f64 = 1e-9;

/// Share of a signal's standard deviation below which residuals are rounding.
const NOTHING: f64 = 1e-5;

/// A regression on P columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Regression<const P: usize> {
    pub coefficients: [f64; P],
    pub residuals: Vec<f64>,
    /// Unexplained share of the variance, from 0 to 1.
    pub left: f64,
}

impl<const P: usize> Regression<P> {
    /// Of `y(k)` on `row(k)` for all samples from `first` on; a constant needs a column of its own. `None` if there
    /// are fewer than four samples a column, or `y` does not move.
    pub fn of(y: &[f64], first: usize, row: impl Fn(usize) -> [f64; P]) -> Option<Self> {
        let target = y.get(first..)?;
        if target.len() < 4 * P {
            return None;
        }
        let total = variance(target);
        let (mut gram, mut joint) = ([[0.0; P]; P], [0.0; P]);
        for k in first..y.len() {
            let x = row(k);
            for i in 0..P {
                joint[i] += x[i] * y[k];
                for j in 0..P {
                    gram[i][j] += x[i] * x[j];
                }
            }
        }
        let coefficients = solve(gram, joint)?;
        let residual = |k: usize| {
            let model: f64 = row(k).iter().zip(&coefficients).map(|(x, c)| x * c).sum();
            y[k] - model
        };
        let residuals: Vec<f64> = (first..y.len()).map(residual).collect();
        let left = residuals.iter().map(|r| r * r).sum::<f64>() / (residuals.len() as f64 * total);
        left.is_finite().then(|| Self { coefficients, residuals, left: left.clamp(0.0, 1.0) })
    }

    /// Excess kurtosis of the residuals; NaN if they are rounding.
    pub fn kurtosis(&self) -> f64 {
        if self.is_exact() { f64::NAN } else { excess_kurtosis(&self.residuals) }
    }

    /// Whether only rounding remains.
    pub fn is_exact(&self) -> bool {
        !(self.left > NOTHING * NOTHING) || !(std(&self.residuals) > 0.0)
    }

    /// Logarithm of the unexplained share, not below the share of rounding.
    pub fn ln_left(&self) -> f64 {
        self.left.max(NOTHING * NOTHING).ln()
    }
}

/// The autoregressive model of order four with a constant, the usual whitener of features.
pub(super) fn autoregression(x: &[f64]) -> Option<Regression<5>> {
    Regression::of(x, 4, |k| [1.0, x[k - 1], x[k - 2], x[k - 3], x[k - 4]])
}

/// The solution of `(a + ridge) c = b` by Cholesky; `None` if `a` is not positive definite even then.
fn solve<const P: usize>(mut a: [[f64; P]; P], mut b: [f64; P]) -> Option<[f64; P]> {
    for i in 0..P {
        a[i][i] += RIDGE * a[i][i] + f64::MIN_POSITIVE;
        for j in 0..=i {
            let mut sum = a[i][j];
            for k in 0..j {
                sum -= a[i][k] * a[j][k];
            }
            if i == j {
                if !(sum > 0.0) {
                    return None;
                }
                a[i][i] = sum.sqrt();
            } else {
                a[i][j] = sum / a[j][j];
            }
        }
    }
    for i in 0..P {
        for k in 0..i {
            b[i] -= a[i][k] * b[k];
        }
        b[i] /= a[i][i];
    }
    for i in (0..P).rev() {
        for k in i + 1..P {
            b[i] -= a[k][i] * b[k];
        }
        b[i] /= a[i][i];
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_made_the_series_is_found_again() {
        let noise: Vec<f64> = (0..400).map(|k| f64::from(k * k % 37) - 18.0).collect();
        let mut y = vec![1.0, 2.0];
        for k in 2..400 {
            y.push(3.0 + 0.7 * y[k - 1] - 0.2 * y[k - 2] + 0.5 * noise[k - 1]);
        }
        let row = |k: usize| [1.0, y[k - 1], y[k - 2], noise[k - 1]];
        let found = Regression::of(&y, 2, row).unwrap();
        for (found, expected) in found.coefficients.iter().zip([3.0, 0.7, -0.2, 0.5]) {
            assert!((found - expected).abs() < 1e-6, "{found}");
        }
        assert!(found.is_exact() && found.kurtosis().is_nan());
        assert_eq!(found.residuals.len(), 398);
        // Without the noise that drove it, the noise is what is left.
        let alone = Regression::of(&y, 2, |k| [1.0, y[k - 1], y[k - 2]]).unwrap();
        assert!(!alone.is_exact() && alone.left > 0.1 && alone.left < 1.0);
        // Columns that are the same share the weight.
        let twice = Regression::of(&y, 2, |k| [1.0, y[k - 1], y[k - 1]]).unwrap();
        assert!((twice.coefficients[1] - twice.coefficients[2]).abs() < 1e-3);
        assert!(Regression::of(&y[..9], 2, |k| [1.0, y[k - 1]]).is_none());
        assert!(Regression::of(&[5.0; 50], 2, |_| [1.0]).is_none());
    }
}
