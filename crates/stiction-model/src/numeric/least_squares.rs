//! Small least-squares problems, with their residuals.

use crate::simd::{Kernel, Width};

/// Ridge for squares of columns of variance one.
pub const RIDGE: f64 = 1e-9;

/// The fit of a target by a combination of columns.
pub struct Solution {
    /// The factor of each column.
    pub coefficients: Vec<f64>,
    /// Target less the combination.
    pub residual: Vec<f64>,
    /// Sum of the residual's squares.
    pub sse: f64,
}

/// The combination of `columns` nearest to `target`, by Cholesky with a ridge for series of variance one. `None` if
/// it is not finite.
pub fn least_squares(columns: &[&[f64]], target: &[f64]) -> Option<Solution> {
    Width::widest().run(Problem { columns, target })
}

struct Problem<'a> {
    columns: &'a [&'a [f64]],
    target: &'a [f64],
}

impl Kernel for Problem<'_> {
    type Output = Option<Solution>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { columns, target } = self;
        let p = columns.len();
        let mut factor = vec![vec![0.0; p]; p];
        let mut coefficients = vec![0.0; p];
        for i in 0..p {
            for j in 0..=i {
                let mut sum = dot(columns[i], columns[j]);
                if i == j {
                    sum += RIDGE * target.len() as f64;
                }
                for m in 0..j {
                    sum -= factor[i][m] * factor[j][m];
                }
                factor[i][j] = if i == j { sum.sqrt() } else { sum / factor[j][j] };
            }
            let mut sum = dot(columns[i], target);
            for m in 0..i {
                sum -= factor[i][m] * coefficients[m];
            }
            coefficients[i] = sum / factor[i][i];
        }
        for i in (0..p).rev() {
            let mut sum = coefficients[i];
            for m in i + 1..p {
                sum -= factor[m][i] * coefficients[m];
            }
            coefficients[i] = sum / factor[i][i];
        }
        let mut residual = target.to_vec();
        for (column, c) in columns.iter().zip(&coefficients) {
            for (r, v) in residual.iter_mut().zip(*column) {
                *r -= c * v;
            }
        }
        let sse = dot(&residual, &residual);
        sse.is_finite().then_some(Solution { coefficients, residual, sse })
    }
}

/// The product of two series, in eight sums that vectors can hold.
#[inline(always)]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (heads, others) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = heads.remainder().iter().zip(others.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in heads.zip(others) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_combination_leaves_what_is_orthogonal_to_it() {
        // Over whole periods of 7 x 9 x 11 samples the columns do not know each other.
        let wave = |period: u32| -> Vec<f64> {
            (0..693).map(|k| f64::from(k % period) - f64::from(period - 1) / 2.0).collect()
        };
        let (a, b, c) = (wave(7), wave(9), wave(11));
        let y: Vec<f64> = (0..693).map(|k| 2.0 * a[k] - 0.5 * b[k] + c[k]).collect();
        let solution = least_squares(&[&a, &b], &y).unwrap();
        assert!(solution.residual.iter().zip(&c).all(|(r, c)| (r - c).abs() < 1e-6));
        assert!((solution.sse / dot(&c, &c) - 1.0).abs() < 1e-6);
        assert_eq!(dot(&a[..13], &b[..13]), (0..13).map(|k| a[k] * b[k]).sum::<f64>());
    }
}
