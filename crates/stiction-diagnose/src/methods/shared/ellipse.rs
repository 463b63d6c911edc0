//! Ellipses through points: of OP and PV, or OP and control error.
//!
//! The direct fit of Fitzgibbon, Pilu and Fisher, in the stable form of Halíř and Flusser. Among all conics `a x² + b x
//! y + c y² + d x + e y + f = 0` with `4 a c - b² = 1`, which are ellipses, the fit has the least squares of the
//! left-hand side (both recalled, not read; the equations were derived again). It is affine invariant: scaling an axis
//! scales the ellipse. It prefers small ellipses if points cover only part of one. Without a solution, the result is
//! the ellipse of the points' covariance, on which evenly spread points have this covariance.
//!
//! References: Fitzgibbon, Pilu, Fisher, IEEE Trans. Pattern Anal. Mach. Intell. 21 (1999) 476-480;
//! Halíř, Flusser, WSCG 1998.

use crate::series::{mean, std};
use nalgebra::{Matrix3, Vector3};

/// The method of an ellipse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EllipseSource {
    /// By the direct fit.
    DirectFit,
    /// From the covariance of the points.
    Covariance,
}

/// An ellipse: the points `p` with `q(p - centre) = 1`, `q(x, y) = xx x² + 2 xy x y + yy y²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Centre, in the units of the two axes.
    pub centre: [f64; 2],
    /// The coefficients `xx`, `xy`, `yy` of its form.
    pub form: [f64; 3],
    /// Root mean square distance of the points from the ellipse along the ray from its centre, as a share of the
    /// ellipse's radius there.
    pub residual: f64,
    /// Method.
    pub source: EllipseSource,
}

impl Ellipse {
    /// The ellipse that fits the points (`x`, `y`) best; `None` if the points are fewer than six or lie on a line, or a
    /// number is not finite.
    pub fn fit(x: &[f64], y: &[f64]) -> Option<Self> {
        let n = x.len().min(y.len());
        let (x, y) = (&x[..n], &y[..n]);
        let (mx, my, sx, sy) = (mean(x), mean(y), std(x), std(y));
        let usable = |v: f64| v.is_finite() && v > 0.0;
        if n < 6 || !usable(sx) || !usable(sy) {
            return None;
        }
        // In standard deviations, in which all sums have similar sizes.
        let points: Vec<[f64; 2]> =
            x.iter().zip(y).map(|(x, y)| [(x - mx) / sx, (y - my) / sy]).collect();
        let direct = direct_fit(&points).and_then(|(c, q)| Some((c, q, residual(&points, c, q)?)));
        let covariance = || {
            let q = covariance_form(&points)?;
            Some(([0.0; 2], q, residual(&points, [0.0; 2], q)?))
        };
        let (source, (c, q, residual)) = match direct {
            Some(found) => (EllipseSource::DirectFit, found),
            None => (EllipseSource::Covariance, covariance()?),
        };
        let ellipse = Self {
            centre: [mx + sx * c[0], my + sy * c[1]],
            form: [q[0] / (sx * sx), q[1] / (sx * sy), q[2] / (sy * sy)],
            residual,
            source,
        };
        ellipse.form.iter().all(|v| v.is_finite()).then_some(ellipse)
    }

    /// Form at the point (`x`, `y`): below 1 inside, above 1 outside.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.centre[0], y - self.centre[1]);
        let [xx, xy, yy] = self.form;
        xx * x * x + 2.0 * xy * x * y + yy * y * y
    }

    /// The chord through the centre along the first axis. With OP on it, it is the apparent stiction of Choudhury,
    /// Shah and Thornhill, `2 m n / sqrt(m² sin² alpha + n² cos² alpha)` for the semi-axes `m`, `n` and the angle
    /// `alpha` of `m`.
    pub fn op_width(&self) -> f64 {
        2.0 / self.form[0].sqrt()
    }

    /// Semi-axes, the longer first, in units that are meaningful only if both axes have the same.
    pub fn semi_axes(&self) -> [f64; 2] {
        let [xx, xy, yy] = self.form;
        let (middle, reach) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
        // The smaller root from the product of both, without cancellation.
        let (large, determinant) = (middle + reach, xx * yy - xy * xy);
        [(large / determinant).sqrt(), (1.0 / large).sqrt()]
    }

    /// The angle of the longer semi-axis from the first axis, rad, between -pi/2 and pi/2.
    pub fn angle(&self) -> f64 {
        let [xx, xy, yy] = self.form;
        0.5 * (-2.0 * xy).atan2(yy - xx)
    }

    /// `n` points along the ellipse, for drawing. The last point precedes the first.
    pub fn outline(&self, n: usize) -> Vec<[f64; 2]> {
        let ([m, n_axis], (sin, cos)) = (self.semi_axes(), self.angle().sin_cos());
        let point = |k: usize| {
            let (s, c) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
            let (u, v) = (m * c, n_axis * s);
            [self.centre[0] + u * cos - v * sin, self.centre[1] + u * sin + v * cos]
        };
        (0..n).map(point).collect()
    }

    /// The ellipse as a closed line: `x` and `y` of its points.
    pub fn closed_outline(&self) -> (Vec<f64>, Vec<f64>) {
        let points = self.outline(180);
        points.iter().chain(points.first()).map(|[x, y]| (*x, *y)).unzip()
    }

    /// The point (`x`, `y`) in coordinates in which the ellipse is the unit circle around the origin.
    pub fn to_circle(self, x: f64, y: f64) -> [f64; 2] {
        let (x, y) = (x - self.centre[0], y - self.centre[1]);
        let [xx, xy, yy] = self.form;
        // Cholesky factor of the form, upper triangle.
        let u = xx.sqrt();
        let w = xy / u;
        [u * x + w * y, (yy - w * w).max(0.0).sqrt() * y]
    }
}

/// Root mean square of `sqrt(q) - 1`; `None` unless the form is an ellipse.
fn residual(points: &[[f64; 2]], c: [f64; 2], [xx, xy, yy]: [f64; 3]) -> Option<f64> {
    if !(xx > 0.0 && xx * yy - xy * xy > 1e-12 * xx * yy) {
        return None;
    }
    let sum: f64 = points
        .iter()
        .map(|[x, y]| {
            let (x, y) = (x - c[0], y - c[1]);
            ((xx * x * x + 2.0 * xy * x * y + yy * y * y).max(0.0).sqrt() - 1.0).powi(2)
        })
        .sum();
    Some((sum / points.len() as f64).sqrt())
}

/// The form of the ellipse whose evenly spread points have the points' covariance.
fn covariance_form(points: &[[f64; 2]]) -> Option<[f64; 3]> {
    let n = points.len() as f64;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for [x, y] in points {
        xx += x * x / n;
        xy += x * y / n;
        yy += y * y / n;
    }
    let determinant = 2.0 * (xx * yy - xy * xy);
    (determinant > 0.0).then(|| [yy / determinant, -xy / determinant, xx / determinant])
}

/// Centre and form of the direct fit.
fn direct_fit(points: &[[f64; 2]]) -> Option<([f64; 2], [f64; 3])> {
    let (mut s1, mut s2, mut s3) = (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
    for [x, y] in points {
        let quadratic = Vector3::new(x * x, x * y, y * y);
        let linear = Vector3::new(*x, *y, 1.0);
        s1 += quadratic * quadratic.transpose();
        s2 += quadratic * linear.transpose();
        s3 += linear * linear.transpose();
    }
    let n = points.len() as f64;
    let (s1, s2, s3) = (s1 / n, s2 / n, s3 / n);
    // The best linear part for a quadratic part a is t a.
    let t = -s3.try_inverse()? * s2.transpose();
    let m: Matrix3<f64> = s1 + s2 * t;
    // The inverse of the constraint's matrix ((0, 0, 2), (0, -1, 0), (2, 0, 0)).
    let m = Matrix3::from_rows(&[m.row(2) * 0.5, -m.row(1), m.row(0) * 0.5]);
    let quadratic = eigenvectors(&m)
        .into_iter()
        .filter(|v| v.iter().all(|x| x.is_finite()))
        .max_by(|a, b| constraint(a).total_cmp(&constraint(b)))
        .filter(|v| constraint(v) > 0.0)?;
    let linear = t * quadratic;
    let ([a, b, c], [d, e, f]) = (<[f64; 3]>::from(quadratic), <[f64; 3]>::from(linear));
    let determinant = 4.0 * a * c - b * b;
    let centre = [(b * e - 2.0 * c * d) / determinant, (b * d - 2.0 * a * e) / determinant];
    let level = -(f + 0.5 * (d * centre[0] + e * centre[1]));
    let form = [a / level, 0.5 * b / level, c / level];
    (form[0] > 0.0 && form.iter().chain(&centre).all(|v| v.is_finite())).then_some((centre, form))
}

/// `4 a c - b²` of a unit quadratic part.
fn constraint(v: &Vector3<f64>) -> f64 {
    4.0 * v[0] * v[2] - v[1] * v[1]
}

/// Unit eigenvectors of a matrix with three real eigenvalues, from its cubic in trigonometric form.
fn eigenvectors(m: &Matrix3<f64>) -> [Vector3<f64>; 3] {
    let mean = m.trace() / 3.0;
    let shifted = m - Matrix3::identity() * mean;
    // Of x³ - 3 p x - 2 q, with x = eigenvalue - mean.
    let p = (shifted * shifted).trace() / 6.0;
    let q = shifted.determinant() / 2.0;
    let root = p.max(0.0).sqrt();
    let phi = (q / root.powi(3)).clamp(-1.0, 1.0).acos() / 3.0;
    std::array::from_fn(|i| {
        let x = 2.0 * root * (phi + std::f64::consts::TAU * i as f64 / 3.0).cos();
        let rest = shifted - Matrix3::identity() * x;
        let rows = [0, 1, 2].map(|r| rest.row(r).transpose());
        // Orthogonal to all rows: the longest of their cross products.
        let crosses = [rows[0].cross(&rows[1]), rows[1].cross(&rows[2]), rows[2].cross(&rows[0])];
        let [a, b, c] = crosses;
        let longer = |a: Vector3<f64>, b: Vector3<f64>| {
            if b.norm_squared() > a.norm_squared() { b } else { a }
        };
        let v = longer(longer(a, b), c);
        v / v.norm()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of an ellipse with the semi-axes 3 and 1 at the angle 0.5.
    fn points(n: usize, share: f64) -> (Vec<f64>, Vec<f64>) {
        (0..n)
            .map(|k| {
                let (s, c) = (share * std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
                let (u, v) = (3.0 * c, s);
                let (sin, cos) = 0.5f64.sin_cos();
                (50.0 + u * cos - v * sin, -7.0 + u * sin + v * cos)
            })
            .unzip()
    }

    #[test]
    fn an_ellipse_is_found_again_from_all_or_part_of_it() {
        for share in [1.0, 0.6] {
            let (x, y) = points(100, share);
            let e = Ellipse::fit(&x, &y).unwrap();
            assert_eq!(e.source, EllipseSource::DirectFit);
            assert!((e.centre[0] - 50.0).abs() < 1e-6 && (e.centre[1] + 7.0).abs() < 1e-6, "{e:?}");
            let [m, n] = e.semi_axes();
            assert!((m - 3.0).abs() < 1e-6 && (n - 1.0).abs() < 1e-6, "{m} {n}");
            assert!((e.angle() - 0.5).abs() < 1e-6 && e.residual < 1e-6);
            // The recalled formula.
            let (sin, cos) = 0.5f64.sin_cos();
            let width = 2.0 * 3.0 / (9.0 * sin * sin + cos * cos).sqrt();
            assert!((e.op_width() - width).abs() < 1e-6);
            for [x, y] in e.outline(12) {
                assert!((e.at(x, y) - 1.0).abs() < 1e-6);
                let [u, v] = e.to_circle(x, y);
                assert!((u.hypot(v) - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn scaling_an_axis_scales_the_ellipse() {
        let (x, y) = points(60, 1.0);
        let noisy: Vec<f64> =
            y.iter().enumerate().map(|(k, y)| y + 0.2 * ((k * k) as f64).sin()).collect();
        let e = Ellipse::fit(&x, &noisy).unwrap();
        let x2: Vec<f64> = x.iter().map(|x| -1e3 * x + 4.0).collect();
        let e2 = Ellipse::fit(&x2, &noisy).unwrap();
        assert!((e2.op_width() / e.op_width() - 1e3).abs() < 1e-6);
        assert!((e.residual - e2.residual).abs() < 1e-9);
    }

    #[test]
    fn lines_and_little_have_no_ellipse() {
        let x: Vec<f64> = (0..10).map(f64::from).collect();
        assert_eq!(Ellipse::fit(&x, &x), None);
        assert_eq!(Ellipse::fit(&x, &[1.0; 10]), None);
        assert_eq!(Ellipse::fit(&x[..5], &[1.0, 3.0, 2.0, 5.0, 4.0]), None);
        assert_eq!(Ellipse::fit(&[f64::NAN; 9], &x), None);
    }
}
