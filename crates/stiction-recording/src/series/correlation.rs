//! Correlation; auto- and cross-correlation by the fast Fourier transform.

use super::spectrum::{Spectrum, fft_length};
use super::statistics::centred;
use super::{mean, span, variance};

/// Autocorrelation of `x` less its mean at the lags 0 to `max_lag`, biased (divisor n) and 1 at lag
/// zero; `None` if all samples are equal.
pub fn autocorrelation(x: &[f64], max_lag: usize) -> Option<Vec<f64>> {
    let max_lag = max_lag.min(x.len().checked_sub(1)?);
    let mut spectrum = Spectrum::of(&centred(x), fft_length(x.len() + max_lag + 1));
    for bin in &mut spectrum.bins {
        *bin = bin.norm_sqr().into();
    }
    let mut lags = spectrum.inverse();
    lags.truncate(max_lag + 1);
    // Rounding gives a constant series some power.
    let scale = x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let power = lags[0];
    if !(power > x.len() as f64 * (1e-14 * scale).powi(2)) {
        return None;
    }
    lags.iter_mut().for_each(|v| *v /= power);
    Some(lags)
}

/// Correlation of two series; `None` if either does not move.
pub fn correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    let scale = (variance(x) * variance(y)).sqrt();
    if !(scale > 0.0) || span(x) == 0.0 || span(y) == 0.0 {
        return None;
    }
    let (mx, my) = (mean(x), mean(y));
    let joint = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / x.len() as f64;
    Some((joint / scale).clamp(-1.0, 1.0))
}

/// The correlation of two series over lags of both signs.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossCorrelation {
    /// Coefficients at the lags `-max_lag` to `max_lag`.
    pub values: Vec<f64>,
    /// The largest lag, in samples.
    pub max_lag: usize,
}

impl CrossCorrelation {
    /// The coefficient at `lag`, which lies within `max_lag`.
    pub fn at(&self, lag: isize) -> f64 {
        self.values[(self.max_lag as isize + lag) as usize]
    }
}

/// Correlation `r(lag) = sum_k u(k) y(k + lag) / (n sd(u) sd(y))` of two series of one length, less
/// their means: where it peaks at a positive lag, `y` follows `u`. `None` if either is constant.
pub fn cross_correlation(u: &[f64], y: &[f64], max_lag: usize) -> Option<CrossCorrelation> {
    let n = u.len().min(y.len());
    let max_lag = max_lag.min(n.checked_sub(1)?);
    let (u, y) = (centred(&u[..n]), centred(&y[..n]));
    let power = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
    let scale = (power(&u) * power(&y)).sqrt();
    if !(scale > 0.0) {
        return None;
    }
    let length = fft_length(n + max_lag + 1);
    let (of_u, mut of_y) = (Spectrum::of(&u, length), Spectrum::of(&y, length));
    for (y, u) in of_y.bins.iter_mut().zip(&of_u.bins) {
        *y *= u.conj();
    }
    let lags = of_y.inverse();
    let values = (0..=2 * max_lag).map(|i| lags[(length + i - max_lag) % length] / scale).collect();
    Some(CrossCorrelation { values, max_lag })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lags_as_by_the_definition() {
        let u: Vec<f64> = (0..50).map(|k| f64::from(k * k % 13)).collect();
        let y: Vec<f64> = (0..50).map(|k| f64::from(k * k * k % 17)).collect();
        let fast = cross_correlation(&u, &y, 20).unwrap();
        let (u, y) = (centred(&u), centred(&y));
        let scale =
            (u.iter().map(|v| v * v).sum::<f64>() * y.iter().map(|v| v * v).sum::<f64>()).sqrt();
        for lag in -20..=20isize {
            let slow: f64 = (0..50isize)
                .filter(|k| (0..50).contains(&(k + lag)))
                .map(|k| u[k as usize] * y[(k + lag) as usize])
                .sum();
            assert!((fast.at(lag) - slow / scale).abs() < 1e-12);
        }
        let same = cross_correlation(&u, &u, 20).unwrap();
        let auto = autocorrelation(&u, 20).unwrap();
        assert!((0..=20).all(|lag| (same.at(lag) - auto[lag as usize]).abs() < 1e-12));
    }

    #[test]
    fn a_constant_correlates_with_nothing() {
        assert_eq!(autocorrelation(&[0.1; 100], 10), None);
        assert_eq!(cross_correlation(&[0.0; 9], &[1.0; 9], 3), None);
        assert_eq!(autocorrelation(&[], 10), None);
    }
}
