//! Moments and order statistics.

use super::fit::line;
use super::{mean, std, variance};

/// Standard deviation of a sample (divisor n - 1); NaN for fewer than two.
pub fn sample_std(x: &[f64]) -> f64 {
    (variance(x) * x.len() as f64 / (x.len() as f64 - 1.0)).sqrt()
}

/// Third central moment over the cube of the standard deviation; NaN if all samples are equal.
pub fn skewness(x: &[f64]) -> f64 {
    let (m, s) = (mean(x), std(x));
    x.iter().map(|v| ((v - m) / s).powi(3)).sum::<f64>() / x.len() as f64
}

/// Fourth central moment over the squared variance, less the 3 of a Gaussian; NaN if all samples
/// are equal.
pub fn excess_kurtosis(x: &[f64]) -> f64 {
    let (m, s2) = (mean(x), variance(x));
    x.iter().map(|v| (v - m).powi(4)).sum::<f64>() / (x.len() as f64 * s2 * s2) - 3.0
}

/// The value above the share `p` of the samples, interpolated between neighbours in order (type 7 of Hyndman &
/// Fan); NaN for none.
pub fn quantile(x: &[f64], p: f64) -> f64 {
    if x.is_empty() {
        return f64::NAN;
    }
    let mut x = x.to_vec();
    let place = p.clamp(0.0, 1.0) * (x.len() - 1) as f64;
    let below = place.floor() as usize;
    let (_, &mut low, above) = x.select_nth_unstable_by(below, f64::total_cmp);
    let high = above.iter().copied().fold(f64::INFINITY, f64::min);
    let share = place - below as f64;
    if share == 0.0 { low } else { low + share * (high - low) }
}

/// The median; NaN for an empty list.
pub fn median(x: &[f64]) -> f64 {
    quantile(x, 0.5)
}

/// Median distance from the median, times 1.4826, which estimates the standard deviation of Gaussian samples; NaN for
/// an empty list.
pub fn median_absolute_deviation(x: &[f64]) -> f64 {
    let middle = median(x);
    let distances: Vec<f64> = x.iter().map(|v| (v - middle).abs()).collect();
    1.4826 * median(&distances)
}

/// Standard deviation of the noise on a slower signal, by `1.4826 median |d| / sqrt(6)` of the second differences d. A
/// signal of many samples a period has hardly any second differences, and white noise has them with six times its
/// variance. 0 for fewer than three samples.
pub fn noise_std(x: &[f64]) -> f64 {
    let second: Vec<f64> = x.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    if second.is_empty() { 0.0 } else { 1.4826 * median(&second) / 6f64.sqrt() }
}

/// The sums of the first 0, 1, ... samples, one more than there are samples.
pub fn running_sums(x: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    std::iter::once(0.0)
        .chain(x.iter().map(|v| {
            sum += v;
            sum
        }))
        .collect()
}

/// The samples less their mean.
pub fn centred(x: &[f64]) -> Vec<f64> {
    let m = mean(x);
    x.iter().map(|v| v - m).collect()
}

/// The samples less their least-squares line.
pub fn detrended(x: &[f64]) -> Vec<f64> {
    let k: Vec<f64> = (0..x.len()).map(|k| k as f64).collect();
    let trend = line(&k, x);
    k.iter().zip(x).map(|(k, v)| v - trend.at(*k)).collect()
}

/// The samples less their mean, over their standard deviation (divisor n); `None` if all are equal.
pub fn standardised(x: &[f64]) -> Option<Vec<f64>> {
    let (m, s) = (mean(x), std(x));
    (s > 0.0).then(|| x.iter().map(|v| (v - m) / s).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_between_neighbours() {
        let x = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(quantile(&x, 0.0), 1.0);
        assert_eq!(quantile(&x, 1.0), 4.0);
        assert_eq!(median(&x), 2.5);
        assert_eq!(quantile(&x, 0.25), 1.75);
        assert!(median(&[]).is_nan());
    }

    #[test]
    fn moments_of_two_points_and_a_line() {
        let x = [-1.0, 1.0];
        assert_eq!(
            (mean(&x), variance(&x), skewness(&x), excess_kurtosis(&x)),
            (0.0, 1.0, 0.0, -2.0)
        );
        assert_eq!(sample_std(&x), 2f64.sqrt());
        assert!(detrended(&[1.0, 3.0, 5.0]).iter().all(|v| v.abs() < 1e-12));
        assert_eq!(standardised(&[2.0, 2.0]), None);
    }
}
