//! The fit of the control law of one structure: least squares with heavy-tailed, correlated innovations.

use super::record::{Record, Shape};
use crate::series::{mean, span};
use crate::simd::{Kernel, Width};
use nalgebra::{DMatrix, DVector};

/// Blocks of the record over which scores are summed for the standard errors.
const BLOCKS: usize = 24;
/// Places of a row for the columns of a controller, and for more columns beside them; those left over are zero.
const FEW: usize = 4;
const MANY: usize = 12;

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

/// Target and columns of the regression for the innovations.
struct Whitened<const P: usize> {
    rows: Vec<[f64; P]>,
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
#[inline(always)]
fn weight(residual: f64, variance: f64) -> f64 {
    5.0 / (4.0 + residual * residual / variance)
}

/// Subtracts the means of all columns and of the target.
fn centre<const P: usize>(rows: &mut [[f64; P]], target: &mut [f64]) {
    let mut sums = [0.0; P];
    for row in &*rows {
        (0..P).for_each(|c| sums[c] += row[c]);
    }
    let means = sums.map(|sum| sum / rows.len() as f64);
    for row in rows {
        (0..P).for_each(|c| row[c] -= means[c]);
    }
    let mean = mean(target);
    target.iter_mut().for_each(|v| *v -= mean);
}

impl<const P: usize> Whitened<P> {
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
                    score[c] += weights[i] * left[i] * self.rows[i][c];
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
        match columns.len() <= FEW {
            true => self.with_places::<FEW>(shape, columns, rho, errors),
            false => self.with_places::<MANY>(shape, columns, rho, errors),
        }
    }

    fn with_places<const P: usize>(
        &self,
        shape: Shape,
        columns: &[Vec<f64>],
        rho: f64,
        errors: bool,
    ) -> Option<Fit> {
        let white = self.whitened::<P>(shape, columns, rho)?;
        let Settled { mut coefficients, variance, normal, left, weights } =
            Width::widest().run(Settling { record: self, white: &white, rho })?;
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

    /// OP and columns less `rho` times their last value, less their levels. The columns are scaled to a variance of
    /// one. It is `None` if a column does not move.
    fn whitened<const P: usize>(
        &self,
        shape: Shape,
        columns: &[Vec<f64>],
        rho: f64,
    ) -> Option<Whitened<P>> {
        let n: usize = self.runs.iter().map(|run| run.len() - 1).sum();
        let (mut rows, mut target) = (vec![[0.0; P]; n], vec![0.0; n]);
        let whiten = |x: &[f64], k: usize| x[k] - rho * x[k - 1];
        let mut at = 0;
        for run in &self.runs {
            let first = at;
            for k in run.start + 1..run.end {
                target[at] = whiten(self.op, k);
                for (v, column) in rows[at].iter_mut().zip(columns) {
                    *v = whiten(column, k);
                }
                at += 1;
            }
            // The level of a P controller is one; those of the others depend on the integral.
            if rho < 1.0 && shape.integral {
                centre(&mut rows[first..at], &mut target[first..at]);
            }
        }
        if rho < 1.0 && !shape.integral {
            centre(&mut rows, &mut target);
        }
        let mut squares = [0.0; P];
        for row in &rows {
            (0..P).for_each(|c| squares[c] += row[c] * row[c]);
        }
        let sizes: Vec<f64> =
            squares[..columns.len()].iter().map(|sum| (sum / n as f64).sqrt()).collect();
        if !sizes.iter().all(|size| *size > 0.0 && size.is_finite()) {
            return None;
        }
        for row in &mut rows {
            row.iter_mut().zip(&sizes).for_each(|(v, size)| *v /= size);
        }
        Some(Whitened { rows, target, sizes })
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

/// Least squares, reweighted iteratively for innovations with Student's t distribution.
struct Settling<'a, const P: usize> {
    record: &'a Record<'a>,
    white: &'a Whitened<P>,
    rho: f64,
}

impl<const P: usize> Kernel for Settling<'_, P> {
    type Output = Option<Settled>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { record, white: Whitened { rows, target, sizes }, rho } = self;
        let (p, n) = (sizes.len(), target.len());
        // The controller does not see the squares that rounding of the PV adds to the proportional column.
        let rounding =
            record.pv_quantum * record.pv_quantum / 12.0 * (1.0 + rho * rho) / sizes[0].powi(2);
        let total = target.iter().map(|v| v * v).sum::<f64>() / n as f64;
        let floor =
            (1e-9 * span(record.op)).powi(2).max(0.02 * record.quantum * record.quantum / 12.0);
        let (mut left, mut weights) = (vec![0.0; n], vec![1.0; n]);
        let (mut variance, mut found) = (total.max(floor), None);
        for round in 0..6 {
            let (mut gram, mut with) = ([[0.0; P]; P], [0.0; P]);
            for ((row, w), t) in rows.iter().zip(&weights).zip(target) {
                for a in 0..P {
                    let weighted = w * row[a];
                    with[a] += weighted * t;
                    for b in 0..P {
                        gram[a][b] += weighted * row[b];
                    }
                }
            }
            let mut normal = DMatrix::from_fn(p, p, |a, b| gram[a.max(b)][a.min(b)]);
            (0..p).for_each(|a| normal[(a, a)] *= 1.0 + 1e-12);
            // Only if the fit is not exact: a controller with a rounding transmitter sees the recorded values.
            let sum: f64 = weights.iter().sum();
            if round > 0 && variance > record.quantum * record.quantum && rounding < 0.3 {
                normal[(0, 0)] -= rounding * sum;
            }
            let solution = normal.clone().lu().solve(&DVector::from_column_slice(&with[..p]))?;
            let mut coefficients = [0.0; P];
            coefficients[..p].copy_from_slice(solution.as_slice());
            found = Some((solution, normal));
            for ((r, row), t) in left.iter_mut().zip(rows).zip(target) {
                *r = t - (0..P).map(|c| row[c] * coefficients[c]).sum::<f64>();
            }
            if round == 0 {
                let mut sizes: Vec<f64> = left.iter().map(|r| r.abs()).collect();
                let (_, typical, _) = sizes.select_nth_unstable_by(n * 6 / 10, f64::total_cmp);
                variance = (1.5 * *typical).powi(2).max(floor);
            }
            for _ in 0..2 {
                let squares = left.iter().map(|r| weight(*r, variance) * r * r);
                weights.iter_mut().zip(squares).for_each(|(of, square)| *of = square);
                variance = (weights.iter().sum::<f64>() / n as f64).max(floor);
            }
            for (w, r) in weights.iter_mut().zip(&left) {
                *w = weight(*r, variance);
            }
        }
        let (coefficients, normal) = found?;
        Some(Settled { coefficients, variance, normal, left, weights })
    }
}
