//! Fewer samples.

/// The means of every `factor` neighbouring samples; the rest at the end is dropped. A factor of 0 or 1 keeps the
/// series. Averaging is a low pass: it damps frequencies above the new Nyquist frequency before they become
/// aliases.
pub fn decimated(x: &[f64], factor: usize) -> Vec<f64> {
    if factor <= 1 {
        return x.to_vec();
    }
    let share = 1.0 / factor as f64;
    x.chunks_exact(factor).map(|block| block.iter().sum::<f64>() * share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_become_their_means() {
        assert_eq!(decimated(&[1.0, 3.0, 5.0, 7.0, 9.0], 2), [2.0, 6.0]);
        assert_eq!(decimated(&[1.0, 3.0], 0), [1.0, 3.0]);
        assert!(decimated(&[1.0], 2).is_empty());
    }
}
