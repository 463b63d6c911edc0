//! Where a signal turns, and the legs between.

/// The samples at which `x` turns: extremes between which it moves by more than `least`. The ends of `x` are not
/// turns, and the part after the last turn has none.
pub(super) fn turns(x: &[f64], least: f64) -> Vec<usize> {
    let mut turns = vec![];
    let (mut low, mut high) = (0, 0);
    let mut rising: Option<bool> = None;
    for k in 0..x.len() {
        if x[k] > x[high] {
            high = k;
        }
        if x[k] < x[low] {
            low = k;
        }
        if rising != Some(true) && x[k] - x[low] > least {
            turns.push(low);
            (rising, high) = (Some(true), k);
        } else if rising != Some(false) && x[high] - x[k] > least {
            turns.push(high);
            (rising, low) = (Some(false), k);
        }
    }
    // A signal that starts moving at its first sample has not turned there.
    if turns.first() == Some(&0) {
        turns.remove(0);
    }
    turns
}

/// Standard deviation over mean of sizes, all positive; NaN for fewer than three.
pub(super) fn spread(sizes: &[f64]) -> f64 {
    if sizes.len() < 3 {
        return f64::NAN;
    }
    crate::series::sample_std(sizes) / crate::series::mean(sizes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_the_extremes_of_legs_that_are_long_enough() {
        let x = [0.0, 1.0, 3.0, 2.8, 4.0, 1.0, 1.2, -1.0, 0.0, 5.0, 4.0];
        assert_eq!(turns(&x, 0.5), [4, 7, 9]);
        let mirrored: Vec<f64> = x.iter().map(|v| 7.0 - v).collect();
        assert_eq!(turns(&mirrored, 0.5), [4, 7, 9]);
        assert!(turns(&[1.0; 5], 0.5).is_empty());
        assert!(spread(&[1.0, 2.0]).is_nan());
        assert_eq!(spread(&[3.0; 4]), 0.0);
    }
}
