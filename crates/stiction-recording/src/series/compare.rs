//! Whether two groups of values differ.

use super::trend::two_sided_t;
use super::{mean, variance};

/// The largest number of values for which all partitions are tried.
const MOST_TO_PERMUTE: usize = 20;

/// The p-value, two-sided, of a difference of the means of two groups; `None` if one has fewer than two.
///
/// For up to 20 values, all partitions into groups of these sizes are counted. Then p is the share of the divisions
/// whose means differ at least as much (Fisher's exact permutation test, which only assumes that the values could have
/// come in any order). For more values, p comes from [`welch`].
pub fn difference_of_means(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.len() < 2 || b.len() < 2 {
        return None;
    }
    if a.len() + b.len() > MOST_TO_PERMUTE { welch(a, b) } else { Some(permutation(a, b)) }
}

fn permutation(a: &[f64], b: &[f64]) -> f64 {
    let all = [a, b].concat();
    let middle = mean(&all);
    // The difference of the means grows with the distance of one group's sum from its expected value.
    let distance = |chosen: u32| {
        let parts = all.iter().enumerate().filter(|(k, _)| chosen >> k & 1 == 1);
        parts.map(|(_, v)| v - middle).sum::<f64>().abs()
    };
    let first = (1u32 << a.len()) - 1;
    let size: f64 = all.iter().map(|v| (v - middle).abs()).sum();
    // Sums of the same values in another order differ by rounding.
    let seen = distance(first) - 1e-9 * size;
    let (mut chosen, mut ways, mut as_far) = (first, 0u32, 0u32);
    while chosen < 1 << all.len() {
        ways += 1;
        as_far += u32::from(distance(chosen) >= seen);
        // The next number with as many ones (Gosper; recalled from Knuth, TAOCP 4A).
        let lowest = chosen & chosen.wrapping_neg();
        let ripple = chosen + lowest;
        chosen = ((chosen ^ ripple) / lowest) >> 2 | ripple;
    }
    f64::from(as_far) / f64::from(ways)
}

/// The p-value, two-sided, of Welch's t-test: the variances may differ. `None` if a group has fewer than
/// two values.
///
/// Source: B. L. Welch, "The generalization of 'Student's' problem when several different population
/// variances are involved", Biometrika 34 (1947) 28-35 (recalled, not read).
pub fn welch(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.len() < 2 || b.len() < 2 {
        return None;
    }
    // Squared standard errors of the means.
    let error = |x: &[f64]| variance(x) / (x.len() as f64 - 1.0);
    let (ea, eb) = (error(a), error(b));
    let parts = ea * ea / (a.len() as f64 - 1.0) + eb * eb / (b.len() as f64 - 1.0);
    let freedom = if parts > 0.0 { (ea + eb).powi(2) / parts } else { 1.0 };
    two_sided_t(mean(b) - mean(a), (ea + eb).sqrt(), freedom)
}

/// Cliff's delta: the share of pairs in which the value of `b` exceeds the value of `a`, less the share in which it is
/// smaller. It ranges from -1 (all fell) to 1 (all rose), and is 0 without pairs.
///
/// Source: N. Cliff, "Dominance statistics: ordinal analyses to answer ordinal questions", Psychol. Bull.
/// 114 (1993) 494-509 (recalled, not read).
pub fn cliffs_delta(a: &[f64], b: &[f64]) -> f64 {
    let pairs = (a.len() * b.len()).max(1) as f64;
    let signs = a.iter().flat_map(|a| b.iter().map(move |b| i8::from(b > a) - i8::from(b < a)));
    signs.map(f64::from).sum::<f64>() / pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_ways_to_part_are_counted() {
        // Apart: of C(10, 5) = 252 ways the seen one and its mirror image are the farthest.
        let (a, b) = ([1.0, 2.0, 3.0, 4.0, 5.0], [11.0, 12.0, 13.0, 14.0, 15.0]);
        assert_eq!(difference_of_means(&a, &b), Some(2.0 / 252.0));
        assert_eq!(difference_of_means(&b, &a), Some(2.0 / 252.0));
        // Unequal sizes have no mirror image.
        assert_eq!(difference_of_means(&[1.0, 2.0], &[7.0, 8.0, 9.0]), Some(1.0 / 10.0));
        assert_eq!(difference_of_means(&[3.0; 4], &[3.0; 5]), Some(1.0));
        assert_eq!(difference_of_means(&[1.0], &[2.0, 3.0]), None);
        // 0, 1 against 2, 3: sums from the mean 1.5 are -2 -1 0 0 1 2; two of six are as far.
        assert_eq!(difference_of_means(&[0.0, 1.0], &[2.0, 3.0]), Some(2.0 / 6.0));
    }

    #[test]
    fn welch_agrees_with_closed_forms() {
        // Two pairs of equal spread: t with 2 degrees of freedom, p = 1 - t/sqrt(2 + t^2).
        let (a, b) = ([0.0, 2.0], [3.0, 5.0]);
        let t = 3.0 / 2f64.sqrt();
        assert!((welch(&a, &b).unwrap() - (1.0 - t / (2.0 + t * t).sqrt())).abs() < 1e-9);
        // One group without scatter: t with one degree of freedom, p = 1 - 2/pi atan(t).
        let (a, b) = ([0.0, 2.0], [4.0, 4.0]);
        let p = 1.0 - 2.0 / std::f64::consts::PI * 3f64.atan();
        assert!((welch(&a, &b).unwrap() - p).abs() < 1e-9);
    }

    #[test]
    fn many_values_take_the_way_of_welch_and_both_ways_agree() {
        let a: Vec<f64> = (0..10).map(|k| f64::from(k * 7 % 10)).collect();
        let b: Vec<f64> = (0..10).map(|k| f64::from(k * 3 % 10) + 2.5).collect();
        let (exact, t) = (difference_of_means(&a, &b).unwrap(), welch(&a, &b).unwrap());
        assert!((exact - t).abs() < 0.01, "{exact} {t}");
        let longer = [&b[..], &[4.0]].concat();
        assert_eq!(difference_of_means(&a, &longer), welch(&a, &longer));
    }

    #[test]
    fn delta_is_one_where_all_rose() {
        assert_eq!(cliffs_delta(&[1.0, 2.0], &[3.0, 4.0]), 1.0);
        assert_eq!(cliffs_delta(&[3.0, 4.0], &[1.0, 2.0]), -1.0);
        assert_eq!(cliffs_delta(&[1.0, 3.0], &[2.0]), 0.0);
        assert_eq!(cliffs_delta(&[], &[2.0]), 0.0);
    }
}
