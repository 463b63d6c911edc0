//! Statistics of series of samples.

/// Arithmetic mean; NaN for an empty list.
pub fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Mean square deviation from the mean (divisor n); NaN for none.
pub fn variance(x: &[f64]) -> f64 {
    let m = mean(x);
    x.iter().map(|v| (v - m) * (v - m)).sum::<f64>() / x.len() as f64
}

/// Root of [`variance`] (divisor n).
pub fn std(x: &[f64]) -> f64 {
    variance(x).sqrt()
}

/// The smallest sample; infinite for an empty list.
pub fn min(x: &[f64]) -> f64 {
    x.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The largest sample; minus infinite for none.
pub fn max(x: &[f64]) -> f64 {
    x.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Largest less smallest sample; 0 for none.
pub fn span(x: &[f64]) -> f64 {
    if x.is_empty() { 0.0 } else { max(x) - min(x) }
}

/// Reversals of a series by more than `band`.
pub fn reversals(x: &[f64], band: f64) -> usize {
    let Some(&first) = x.first() else { return 0 };
    let (mut low, mut high, mut turns) = (first, first, 0);
    // The direction of the last move that was larger than the band.
    let mut rising: Option<bool> = None;
    for &v in x {
        (low, high) = (low.min(v), high.max(v));
        if rising != Some(true) && v > low + band {
            turns += usize::from(rising == Some(false));
            (rising, high) = (Some(true), v);
        } else if rising != Some(false) && v < high - band {
            turns += usize::from(rising == Some(true));
            (rising, low) = (Some(false), v);
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversals_ignore_noise() {
        assert_eq!(reversals(&[0.0, 5.0, 4.9, 5.1, 0.0, 3.0], 1.0), 2);
        assert_eq!(reversals(&[0.0, 5.0, 4.0, 6.0, 0.0], 0.0), 3);
        assert_eq!(reversals(&[], 1.0), 0);
    }
}
