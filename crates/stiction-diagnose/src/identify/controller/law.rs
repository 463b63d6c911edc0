//! The fit of the control law of one structure: least squares with heavy-tailed, correlated innovations.

use super::record::{Record, Shape};
use crate::series::{mean, span};
use nalgebra::{DMatrix, DVector};

/// Blocks of the record over which scores are summed for the standard errors.
const BLOCKS: usize = 24;

/// The fit of a structure.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub shape: Shape,
    pub rho: f64,
    pub coefficients: Vec<f64>,
    pub covariance: DMatrix<f64>,
    /// Nats.
    pub likelihood: f64,
    /// Scale of the innovations, percent.
    pub scale: f64,
    /// Share of the OP's innovations that it explains.
    pub explained: f64,
    /// Share of the samples at least six scales away.
    pub outliers: f64,
}

/// OP and columns for the innovations.
struct Whitened {
    /// One row after the other.
    rows: Vec<f64>,
    target: Vec<f64>,
    /// Divisor of each column.
    sizes: Vec<f64>,
}

/// Where the iterated least squares end.
struct Settled {
    coefficients: DVector<f64>,
    variance: f64,
    normal: DMatrix<f64>,
    left: Vec<f64>,
    weights: Vec<f64>,
}

/// The weight of a residual under Student's t distribution with four degrees of freedom.
fn weight(residual: f64, variance: f64) -> f64 {
    5.0 / (4.0 + residual * residual / variance)
}

/// Subtracts the means of all columns and of the target.
fn centre(rows: &mut [f64], target: &mut [f64]) {
    let (n, p) = (target.len(), rows.len() / target.len().max(1));
    for c in 0..p {
        let mean = (0..n).map(|i| rows[i * p + c]).sum::<f64>() / n as f64;
        (0..n).for_each(|i| rows[i * p + c] -= mean);
    }
    let mean = mean(target);
    target.iter_mut().for_each(|v| *v -= mean);
}

impl Whitened {
    /// The covariance of the coefficients, from the scores' sums over blocks of the record.
    fn covariance(
        &self,
        normal: DMatrix<f64>,
        left: &[f64],
        weights: &[f64],
    ) -> Option<DMatrix<f64>> {
        let (p, n) = (self.sizes.len(), left.len());
        let inverse = normal.try_inverse()?;
        let length = n.div_ceil(BLOCKS).max(1);
        let mut scores: DMatrix<f64> = DMatrix::zeros(p, p);
        for block in 0..n.div_ceil(length) {
            let mut score: DVector<f64> = DVector::zeros(p);
            for i in block * length..((block + 1) * length).min(n) {
                for c in 0..p {
                    score[c] += weights[i] * left[i] * self.rows[i * p + c];
                }
            }
            scores += &score * score.transpose();
        }
        Some(&inverse * scores * &inverse)
    }
}

/// The coefficients of a fit.
pub(super) struct Settings {
    pub kp: f64,
    pub of_sp: Option<f64>,
    pub ki: f64,
    pub slope: Option<f64>,
    pub kd: f64,
}

impl Record<'_> {
    /// The likeliest fit of a structure, with `rho` among these.
    pub(super) fn fitted(&self, shape: Shape, rhos: &[f64]) -> Option<Fit> {
        let columns = self.columns(shape);
        let mut best: Option<Fit> = None;
        for rho in rhos {
            let fit = self.with_rho(shape, &columns, *rho, false);
            if let Some(fit) = fit
                && best.as_ref().is_none_or(|best| fit.likelihood > best.likelihood)
            {
                best = Some(fit);
            }
        }
        best
    }

    /// The fit of a structure with this `rho`, with standard errors if requested.
    pub(super) fn with_rho(
        &self,
        shape: Shape,
        columns: &[Vec<f64>],
        rho: f64,
        errors: bool,
    ) -> Option<Fit> {
        let white = self.whitened(shape, columns, rho)?;
        let Settled { mut coefficients, variance, normal, left, weights } =
            self.settled(&white, rho)?;
        let n = left.len();
        let likelihood = left
            .iter()
            .map(|r| -0.5 * variance.ln() - 2.5 * (r * r / (4.0 * variance)).ln_1p())
            .sum::<f64>();
        if !likelihood.is_finite() || !coefficients.iter().all(|c| c.is_finite()) {
            return None;
        }
        let outliers =
            left.iter().filter(|r| **r * **r > 36.0 * variance).count() as f64 / n as f64;
        // Outliers count for neither side.
        let sums =
            weights.iter().zip(&left).zip(&white.target).fold((0.0, 0.0), |(a, b), ((w, r), t)| {
                let w = w.min(1.0);
                (a + w * r * r, b + w * t * t)
            });
        let explained = 1.0 - sums.0 / sums.1.max(f64::MIN_POSITIVE);
        let mut covariance = match errors {
            true => white.covariance(normal, &left, &weights)?,
            false => DMatrix::zeros(white.sizes.len(), white.sizes.len()),
        };
        for (a, of_a) in white.sizes.iter().enumerate() {
            coefficients[a] /= of_a;
            for (b, of_b) in white.sizes.iter().enumerate() {
                covariance[(a, b)] /= of_a * of_b;
            }
        }
        Some(Fit {
            shape,
            rho,
            coefficients: coefficients.iter().copied().collect(),
            covariance,
            likelihood,
            scale: variance.sqrt(),
            explained,
            outliers,
        })
    }

    /// OP and columns less `rho` times their last value, less their levels, the columns scaled to a variance of
    /// one; `None` if one does not move.
    fn whitened(&self, shape: Shape, columns: &[Vec<f64>], rho: f64) -> Option<Whitened> {
        let p = columns.len();
        let n: usize = self.runs.iter().map(|run| run.len() - 1).sum();
        let (mut rows, mut target) = (vec![0.0; n * p], vec![0.0; n]);
        let whiten = |x: &[f64], k: usize| x[k] - rho * x[k - 1];
        let mut at = 0;
        for run in &self.runs {
            let first = at;
            for k in run.start + 1..run.end {
                target[at] = whiten(self.op, k);
                for (c, column) in columns.iter().enumerate() {
                    rows[at * p + c] = whiten(column, k);
                }
                at += 1;
            }
            // The level of a P controller is one; those of the others depend on the integral.
            if rho < 1.0 && shape.integral {
                centre(&mut rows[first * p..at * p], &mut target[first..at]);
            }
        }
        if rho < 1.0 && !shape.integral {
            centre(&mut rows, &mut target);
        }
        let sizes: Vec<f64> = (0..p)
            .map(|c| ((0..n).map(|i| rows[i * p + c].powi(2)).sum::<f64>() / n as f64).sqrt())
            .collect();
        if !sizes.iter().all(|size| *size > 0.0 && size.is_finite()) {
            return None;
        }
        for row in rows.chunks_exact_mut(p) {
            row.iter_mut().zip(&sizes).for_each(|(v, size)| *v /= size);
        }
        Some(Whitened { rows, target, sizes })
    }

    /// Least squares, reweighted iteratively for innovations with Student's t distribution.
    fn settled(&self, white: &Whitened, rho: f64) -> Option<Settled> {
        let Whitened { rows, target, sizes } = white;
        let (p, n) = (sizes.len(), target.len());
        // The controller does not see the squares that rounding of the PV adds to the proportional column.
        let rounding =
            self.pv_quantum * self.pv_quantum / 12.0 * (1.0 + rho * rho) / sizes[0].powi(2);
        let total = target.iter().map(|v| v * v).sum::<f64>() / n as f64;
        let floor = (1e-9 * span(self.op)).powi(2).max(0.02 * self.quantum * self.quantum / 12.0);
        let mut settled = Settled {
            coefficients: DVector::zeros(p),
            variance: total.max(floor),
            normal: DMatrix::zeros(p, p),
            left: vec![0.0; n],
            weights: vec![1.0; n],
        };
        let Settled { coefficients, variance, normal, left, weights } = &mut settled;
        for round in 0..6 {
            let mut gram = DMatrix::zeros(p, p);
            let mut with = DVector::zeros(p);
            for i in 0..n {
                let row = &rows[i * p..(i + 1) * p];
                for a in 0..p {
                    let weighted = weights[i] * row[a];
                    with[a] += weighted * target[i];
                    for b in 0..=a {
                        gram[(a, b)] += weighted * row[b];
                    }
                }
            }
            for a in 0..p {
                gram[(a, a)] *= 1.0 + 1e-12;
                for b in a + 1..p {
                    gram[(a, b)] = gram[(b, a)];
                }
            }
            // Only if the fit is not exact: a controller with a rounding transmitter sees the recorded values.
            let sum: f64 = weights.iter().sum();
            if round > 0 && *variance > self.quantum * self.quantum && rounding < 0.3 {
                gram[(0, 0)] -= rounding * sum;
            }
            *coefficients = gram.clone().lu().solve(&with)?;
            *normal = gram;
            for ((r, row), t) in left.iter_mut().zip(rows.chunks_exact(p)).zip(target) {
                *r = t - row.iter().zip(coefficients.iter()).map(|(a, b)| a * b).sum::<f64>();
            }
            if round == 0 {
                let mut sizes: Vec<f64> = left.iter().map(|r| r.abs()).collect();
                sizes.sort_unstable_by(f64::total_cmp);
                let typical = 1.5 * sizes[n * 6 / 10];
                *variance = typical.powi(2).max(floor);
            }
            for _ in 0..2 {
                let sum: f64 = left.iter().map(|r| weight(*r, *variance) * r * r).sum();
                *variance = (sum / n as f64).max(floor);
            }
            for (w, r) in weights.iter_mut().zip(&*left) {
                *w = weight(*r, *variance);
            }
        }
        Some(settled)
    }

    /// The likelier of two, if the second is likelier by this much.
    pub(super) fn better(&self, now: Fit, other: Option<Fit>, by: f64) -> Fit {
        match other {
            Some(other) if other.likelihood > now.likelihood + by && self.sound(&other) => other,
            _ => now,
        }
    }

    /// Whether integral and derivative act the same way as the proportional part.
    pub(super) fn sound(&self, fit: &Fit) -> bool {
        let Settings { kp, ki, kd, .. } = self.settings(fit);
        kp * ki >= 0.0 && kp * kd >= 0.0
    }

    pub(super) fn settings(&self, fit: &Fit) -> Settings {
        let mut rest = fit.coefficients.iter().copied();
        let mut next = || rest.next().unwrap_or(0.0);
        let kp = next();
        let of_sp = if fit.shape.weighted { Some(next()) } else { None };
        let ki = if fit.shape.integral { next() } else { 0.0 };
        let slope = if fit.shape.integral && self.sp.is_none() { Some(next()) } else { None };
        let kd = if fit.shape.derivative.is_some() { next() } else { 0.0 };
        Settings { kp, of_sp, ki, slope, kd }
    }
}
