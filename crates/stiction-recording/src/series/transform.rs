//! Many Fourier transforms of one length.

use super::plans;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealToComplex};
use std::sync::Arc;

/// The plan of a real transform and of its inverse, with the buffers they need.
pub struct Transform {
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    scratch: Vec<Complex<f64>>,
    samples: Vec<f64>,
}

impl Transform {
    /// A plan for series of `length` samples, of which there is at least one.
    pub fn new(length: usize) -> Self {
        let (forward, inverse) = (plans::forward(length.max(1)), plans::inverse(length.max(1)));
        let scratch = forward.get_scratch_len().max(inverse.get_scratch_len());
        Self {
            samples: forward.make_input_vec(),
            scratch: vec![Complex::default(); scratch],
            forward,
            inverse,
        }
    }

    /// Number of samples of a series.
    pub fn length(&self) -> usize {
        self.samples.len()
    }

    /// Number of bins of a transform, from zero to the Nyquist frequency.
    pub fn bins(&self) -> usize {
        self.length() / 2 + 1
    }

    /// Transforms `x`, of the planned length, into `bins`.
    pub fn forward(&mut self, x: &[f64], bins: &mut [Complex<f64>]) {
        self.samples.copy_from_slice(x);
        // Buffers have the planned lengths, the only possible error.
        let done = self.forward.process_with_scratch(&mut self.samples, bins, &mut self.scratch);
        debug_assert!(done.is_ok());
    }

    /// The series with the transform `bins`, into `x`; `bins` are overwritten.
    pub fn inverse(&mut self, bins: &mut [Complex<f64>], x: &mut [f64]) {
        bins[0].im = 0.0;
        if self.length().is_multiple_of(2)
            && let Some(last) = bins.last_mut()
        {
            last.im = 0.0;
        }
        let done = self.inverse.process_with_scratch(bins, x, &mut self.scratch);
        debug_assert!(done.is_ok());
        let scale = 1.0 / self.length() as f64;
        x.iter_mut().for_each(|v| *v *= scale);
    }
}

/// The part of `x` between the frequencies `low` and `high`, in cycles per sample, without its mean: all other bins
/// of its transform are set to zero.
pub fn band_passed(x: &[f64], low: f64, high: f64) -> Vec<f64> {
    if x.is_empty() {
        return vec![];
    }
    let mut transform = Transform::new(x.len());
    let mut bins = vec![Complex::default(); transform.bins()];
    transform.forward(x, &mut bins);
    for (i, bin) in bins.iter_mut().enumerate() {
        let frequency = i as f64 / x.len() as f64;
        if i == 0 || !(low..=high).contains(&frequency) {
            *bin = Complex::default();
        }
    }
    let mut passed = vec![0.0; x.len()];
    transform.inverse(&mut bins, &mut passed);
    passed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_keeps_its_sine_and_no_other() {
        let wave = |period: f64| -> Vec<f64> {
            (0..400).map(|k| (std::f64::consts::TAU * f64::from(k) / period).sin()).collect()
        };
        let (slow, fast) = (wave(40.0), wave(8.0));
        let sum: Vec<f64> = slow.iter().zip(&fast).map(|(a, b)| 3.0 + a + b).collect();
        let kept = band_passed(&sum, 1.0 / 60.0, 1.0 / 20.0);
        assert!(kept.iter().zip(&slow).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(band_passed(&[], 0.0, 0.5).is_empty());
        assert_eq!(band_passed(&[7.0], 0.0, 0.5), [0.0]);
    }
}
