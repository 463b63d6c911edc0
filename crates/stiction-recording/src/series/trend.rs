//! Whether a few values rise or fall: a weighted line with its interval, and two checks that are robust to
//! outliers.

use super::statistics::median;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// A weighted least-squares line, with the uncertainty of its slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// Slope: y per unit of x.
    pub slope: f64,
    /// Lower end of the 95 % interval of the slope.
    pub low: f64,
    /// Upper end of the 95 % interval of the slope.
    pub high: f64,
    /// Probability of a slope at least as far from zero without a trend, two-sided.
    pub p_value: f64,
}

/// The weighted least-squares line through the points (`x`, `y`). Weights give the ratios of the variances; their
/// common size is estimated from the residuals, so that with `n` points `(b - beta)/se(b)` follows Student's t with
/// `n - 2` degrees of freedom.
///
/// `None` for fewer than three points of positive weight, or if they have only one `x`.
///
/// Source: any textbook, such as N. R. Draper, H. Smith, "Applied Regression Analysis", 3rd ed., Wiley,
/// 1998 (recalled, not read).
pub fn weighted_trend(x: &[f64], y: &[f64], weights: &[f64]) -> Option<Trend> {
    let points: Vec<[f64; 3]> = x
        .iter()
        .zip(y)
        .zip(weights)
        .map(|((x, y), w)| [*x, *y, *w])
        .filter(|[_, _, w]| *w > 0.0)
        .collect();
    let freedom = points.len().checked_sub(2).filter(|n| *n > 0)? as f64;
    let total: f64 = points.iter().map(|[_, _, w]| w).sum();
    let mean = |k: usize| points.iter().map(|p| p[2] * p[k]).sum::<f64>() / total;
    let (mx, my) = (mean(0), mean(1));
    let sxx: f64 = points.iter().map(|[x, _, w]| w * (x - mx) * (x - mx)).sum();
    let sxy: f64 = points.iter().map(|[x, y, w]| w * (x - mx) * (y - my)).sum();
    if !(sxx > 0.0) {
        return None;
    }
    let slope = sxy / sxx;
    let residual = |[x, y, w]: &[f64; 3]| w * (y - my - slope * (x - mx)).powi(2);
    let error = (points.iter().map(residual).sum::<f64>() / freedom / sxx).sqrt();
    let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
    let half = student.inverse_cdf(0.975) * error;
    let p_value = two_sided_t(slope, error, freedom)?;
    Some(Trend { slope, low: slope - half, high: slope + half, p_value })
}

/// Two-sided p-value of a difference with its standard error, by Student's t. Without scatter, p = 1 for no
/// difference and p = 0 for any other.
pub(super) fn two_sided_t(difference: f64, error: f64, freedom: f64) -> Option<f64> {
    if error == 0.0 {
        return Some(if difference == 0.0 { 1.0 } else { 0.0 });
    }
    let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
    Some((2.0 * student.cdf(-(difference / error).abs())).min(1.0))
}

/// The median of the slopes of all pairs of points; `None` if no two differ in `x`.
///
/// Source: P. K. Sen, "Estimates of the regression coefficient based on Kendall's tau", J. Am. Stat.
/// Assoc. 63 (1968) 1379-1389; after H. Theil, Proc. K. Ned. Akad. Wet. 53 (1950) (recalled, not read).
pub fn theil_sen(x: &[f64], y: &[f64]) -> Option<f64> {
    let n = x.len().min(y.len());
    let slopes: Vec<f64> = (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .filter(|(i, j)| x[*i] != x[*j])
        .map(|(i, j)| (y[j] - y[i]) / (x[j] - x[i]))
        .collect();
    (!slopes.is_empty()).then(|| median(&slopes))
}

/// The p-value, two-sided, of Mann and Kendall's test for a trend of values in order of time: the number of pairs
/// that rise less those that fall, by the normal approximation with its correction for continuity and for ties. 1
/// without data.
///
/// Source: H. B. Mann, "Nonparametric tests against trend", Econometrica 13 (1945) 245-259; M. G.
/// Kendall, "Rank Correlation Methods" (recalled, not read).
pub fn mann_kendall(y: &[f64]) -> f64 {
    let n = y.len();
    let mut rises = 0.0;
    for (i, early) in y.iter().enumerate() {
        for late in &y[i + 1..] {
            rises += f64::from(i8::from(late > early) - i8::from(late < early));
        }
    }
    let mut sorted = y.to_vec();
    sorted.sort_by(f64::total_cmp);
    let spread = |n: f64| n * (n - 1.0) * (2.0 * n + 5.0) / 18.0;
    let ties: f64 = sorted.chunk_by(|a, b| a == b).map(|tied| spread(tied.len() as f64)).sum();
    let variance = spread(n as f64) - ties;
    if !(variance > 0.0) {
        return 1.0;
    }
    let z = (rises.abs() - 1.0).max(0.0) / variance.sqrt();
    (2.0 * Normal::standard().cdf(-z)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weighted_line_agrees_with_reference_values() {
        // Four points of equal weight: b = 0.6 (sxy 3, sxx 5), residual sum 1.2, se = sqrt(0.6/5),
        // t = 1.7320508 = sqrt(3) with 2 degrees of freedom. For 2 degrees the distribution has a closed
        // form: P(|t| > a) = 1 - a/sqrt(2 + a^2), here 1 - sqrt(3/5).
        let (x, y) = ([0.0, 1.0, 2.0, 3.0], [1.0, 3.0, 2.0, 3.2]);
        let trend = weighted_trend(&x, &y, &[1.0; 4]).unwrap();
        let sxy: f64 = [-1.5, -0.5, 0.5, 1.5].iter().zip(&y).map(|(x, y)| x * (y - 2.3)).sum();
        assert!((trend.slope - sxy / 5.0).abs() < 1e-12);
        let rest: f64 =
            x.iter().zip(&y).map(|(x, y)| y - 2.3 - trend.slope * (x - 1.5)).map(|r| r * r).sum();
        let error = (rest / 2.0 / 5.0).sqrt();
        let t = trend.slope / error;
        assert!((trend.p_value - (1.0 - t / (2.0 + t * t).sqrt())).abs() < 1e-9);
        // The 97.5 % quantile of t with 2 degrees of freedom is 4.302653, as tabulated.
        assert!((trend.high - trend.slope - 4.302_653 * error).abs() < 1e-5);
        assert!((trend.low + trend.high - 2.0 * trend.slope).abs() < 1e-12);
    }

    #[test]
    fn a_point_of_weight_two_is_two_points_for_the_slope() {
        let once =
            weighted_trend(&[0.0, 1.0, 2.0, 4.0], &[1.0, 0.0, 5.0, 3.0], &[1.0, 1.0, 2.0, 1.0]);
        let twice =
            weighted_trend(&[0.0, 1.0, 2.0, 2.0, 4.0], &[1.0, 0.0, 5.0, 5.0, 3.0], &[1.0; 5]);
        assert!((once.unwrap().slope - twice.unwrap().slope).abs() < 1e-12);
        let doubled =
            weighted_trend(&[0.0, 1.0, 2.0, 4.0], &[1.0, 0.0, 5.0, 3.0], &[2.0, 2.0, 4.0, 2.0]);
        let (once, doubled) = (once.unwrap(), doubled.unwrap());
        assert!((once.p_value - doubled.p_value).abs() < 1e-12);
        assert!((once.high - doubled.high).abs() < 1e-12);
        assert_eq!(weighted_trend(&[1.0; 4], &[1.0, 2.0, 3.0, 4.0], &[1.0; 4]), None);
        assert_eq!(weighted_trend(&[1.0, 2.0], &[1.0, 2.0], &[1.0; 2]), None);
    }

    #[test]
    fn a_line_without_scatter_is_certain() {
        let trend = weighted_trend(&[0.0, 1.0, 2.0], &[0.0, 2.0, 4.0], &[1.0; 3]).unwrap();
        assert_eq!((trend.slope, trend.p_value), (2.0, 0.0));
        let flat = weighted_trend(&[0.0, 1.0, 2.0], &[3.0; 3], &[1.0; 3]).unwrap();
        assert_eq!((flat.slope, flat.p_value), (0.0, 1.0));
    }

    #[test]
    fn the_robust_slope_forgets_an_outlier() {
        let x: Vec<f64> = (0..9).map(f64::from).collect();
        let mut y: Vec<f64> = x.iter().map(|x| 1.0 + 0.5 * x).collect();
        y[4] = 100.0;
        assert_eq!(theil_sen(&x, &y), Some(0.5));
        assert_eq!(theil_sen(&[1.0, 1.0], &[1.0, 2.0]), None);
    }

    #[test]
    fn kendall_counts_pairs() {
        // Ten ascending values: S = 45, variance 125, z = 44/sqrt(125) = 3.93546, p = 8.303e-5.
        let rising: Vec<f64> = (0..10).map(f64::from).collect();
        assert!((mann_kendall(&rising) - 8.303e-5).abs() < 2e-8, "{}", mann_kendall(&rising));
        let falling: Vec<f64> = rising.iter().map(|y| -y).collect();
        assert_eq!(mann_kendall(&rising), mann_kendall(&falling));
        assert_eq!(mann_kendall(&[2.0; 7]), 1.0);
        assert_eq!(mann_kendall(&[]), 1.0);
        // 1 2 2 3: S = 5, variance (4 3 13 - 2 1 9)/18 = 138/18, z = 4/2.76887, p = 0.14856.
        assert!((mann_kendall(&[1.0, 2.0, 2.0, 3.0]) - 0.148_56).abs() < 1e-4);
    }
}
