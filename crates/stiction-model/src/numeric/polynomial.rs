//! Polynomials with real coefficients, the highest power first.

use super::roots::bracketed;
use nalgebra::Complex;
use nalgebra::DMatrix;

/// Without the zeros before the first coefficient.
pub fn trimmed(p: &[f64]) -> Vec<f64> {
    p.iter().copied().skip_while(|c| *c == 0.0).collect()
}

pub fn product(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; (p.len() + q.len()).saturating_sub(1)];
    for (i, a) in p.iter().enumerate() {
        for (j, b) in q.iter().enumerate() {
            out[i + j] += a * b;
        }
    }
    out
}

/// `p + scale q`.
pub fn sum(p: &[f64], scale: f64, q: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; p.len().max(q.len())];
    let n = out.len();
    p.iter().enumerate().for_each(|(i, c)| out[n - p.len() + i] += c);
    q.iter().enumerate().for_each(|(i, c)| out[n - q.len() + i] += scale * c);
    out
}

pub fn derivative(p: &[f64]) -> Vec<f64> {
    let n = p.len();
    p.iter().take(n.saturating_sub(1)).enumerate().map(|(i, c)| c * (n - 1 - i) as f64).collect()
}

pub fn real(p: &[f64], x: f64) -> f64 {
    p.iter().fold(0.0, |value, c| value * x + c)
}

/// The value at `j w`.
pub fn at_frequency(p: &[f64], w: f64) -> Complex<f64> {
    p.iter().fold(Complex::new(0.0, 0.0), |value, c| Complex::new(c - value.im * w, value.re * w))
}

/// `|p(jw)|^2` as a polynomial in `w^2`.
pub fn squared_magnitude(p: &[f64]) -> Vec<f64> {
    let n = p.len();
    let mirrored: Vec<f64> =
        p.iter().enumerate().map(|(i, c)| if (n - 1 - i) % 2 == 1 { -c } else { *c }).collect();
    let even = product(p, &mirrored);
    // Powers of s come as 2 (n-1), .., 0; the odd ones vanish, and s^2 = -w^2.
    even.iter()
        .step_by(2)
        .enumerate()
        .map(|(i, c)| if (n - 1 - i) % 2 == 1 { -c } else { *c })
        .collect()
}

/// The positions at which `p` changes its sign on `(0, inf)`, ascending. Between two roots of the derivative there
/// is at most one.
pub fn sign_changes(p: &[f64]) -> Vec<f64> {
    let mut p = trimmed(p);
    while p.last() == Some(&0.0) {
        p.pop();
    }
    if p.len() < 2 {
        return vec![];
    }
    // Cauchy's bound on the size of a root.
    let bound = 1.0 + p[1..].iter().fold(0.0_f64, |largest, c| largest.max((c / p[0]).abs()));
    let mut nodes = vec![0.0];
    nodes.extend(sign_changes(&derivative(&p)).into_iter().filter(|x| *x < bound));
    nodes.push(bound);
    let f = |x: f64| real(&p, x);
    nodes
        .windows(2)
        .filter(|ends| f(ends[0]) * f(ends[1]) < 0.0)
        .map(|ends| bracketed(f, ends[0], ends[1]))
        .collect()
}

/// All roots, as the eigenvalues of the companion matrix.
pub fn roots(p: &[f64]) -> Vec<Complex<f64>> {
    let mut p = trimmed(p);
    let mut out = vec![];
    while p.last() == Some(&0.0) {
        p.pop();
        out.push(Complex::new(0.0, 0.0));
    }
    let n = p.len().saturating_sub(1);
    if n == 0 {
        return out;
    }
    // In units of the geometric mean of the roots, so that fast and slow ones are similar.
    let unit = (p[n] / p[0]).abs().powf(1.0 / n as f64);
    let mut companion = DMatrix::zeros(n, n);
    for i in 0..n {
        companion[(0, i)] = -p[i + 1] / p[0] / unit.powi(i as i32 + 1);
        if i > 0 {
            companion[(i, i - 1)] = 1.0;
        }
    }
    out.extend(
        companion.complex_eigenvalues().iter().map(|root| Complex::new(root.re, root.im) * unit),
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_squared_magnitude_is_that_of_the_value() {
        let p = [0.3, -2.0, 1.5, 4.0];
        for w in [0.0, 0.2, 1.7, 30.0] {
            let value = at_frequency(&p, w).norm_sqr();
            assert!((real(&squared_magnitude(&p), w * w) - value).abs() <= 1e-12 * value);
        }
    }

    #[test]
    fn sign_changes_and_roots_are_those_of_the_factors() {
        let factors = [[1.0, -1e-3], [1.0, -2.0], [1.0, -500.0], [1.0, 7.0]];
        let p = factors.iter().fold(vec![1.0], |p, factor| product(&p, factor));
        let found = sign_changes(&p);
        assert_eq!(found.len(), 3);
        for (found, wanted) in found.iter().zip([1e-3, 2.0, 500.0]) {
            assert!((found / wanted - 1.0).abs() < 1e-9, "{found} for {wanted}");
        }
        let roots = roots(&product(&p, &[1.0, 0.0]));
        for wanted in [0.0, 1e-3, 2.0, 500.0, -7.0] {
            assert!(roots.iter().any(|root| (root - wanted).norm() < 1e-9 * (1.0 + wanted.abs())));
        }
    }
}
