//! Spectra by the fast Fourier transform.

use super::statistics::centred;
use super::{mean, plans};
use realfft::num_complex::Complex;

/// The Fourier transform of a real series: bin `i` is the frequency `i / length` per sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Bins from zero to the Nyquist frequency.
    pub bins: Vec<Complex<f64>>,
    /// Length of the transformed series, after padding.
    pub length: usize,
}

/// A fast transform length, at least `n`.
pub fn fft_length(n: usize) -> usize {
    n.max(1).next_power_of_two()
}

impl Spectrum {
    /// Transforms `x`, followed by zeros up to `length`.
    pub fn of(x: &[f64], length: usize) -> Self {
        let length = length.max(x.len()).max(1);
        let transform = plans::forward(length);
        let mut padded = x.to_vec();
        padded.resize(length, 0.0);
        let mut bins = transform.make_output_vec();
        // Buffers have the planned lengths, the only possible error.
        let done = transform.process(&mut padded, &mut bins);
        debug_assert!(done.is_ok());
        Self { bins, length }
    }

    /// The real series with this transform, all of its `length` samples.
    pub fn inverse(mut self) -> Vec<f64> {
        let transform = plans::inverse(self.length);
        let mut x = transform.make_output_vec();
        // An imaginary part at zero and Nyquist cannot come from a real series.
        if let Some(first) = self.bins.first_mut() {
            first.im = 0.0;
        }
        if self.length.is_multiple_of(2)
            && let Some(last) = self.bins.last_mut()
        {
            last.im = 0.0;
        }
        let done = transform.process(&mut self.bins, &mut x);
        debug_assert!(done.is_ok());
        let scale = 1.0 / self.length as f64;
        x.iter_mut().for_each(|v| *v *= scale);
        x
    }
}

/// Power over frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Periodogram {
    /// Frequencies, cycles per sample, from zero to a half.
    pub frequency: Vec<f64>,
    /// Power of each, in squared units of the series; the sum is the series' windowed variance.
    pub power: Vec<f64>,
}

/// The periodogram of `x` less its mean under a Hann window, padded to a fast length.
pub fn periodogram(x: &[f64]) -> Periodogram {
    let n = x.len();
    let mut y = centred(x);
    let mut weight = 0.0;
    for (k, v) in y.iter_mut().enumerate() {
        let w = 0.5 - 0.5 * (std::f64::consts::TAU * (k as f64 + 0.5) / n as f64).cos();
        *v *= w;
        weight += w * w;
    }
    // The window restores part of the mean.
    let rest = mean(&y);
    y.iter_mut().for_each(|v| *v -= rest);
    let spectrum = Spectrum::of(&y, fft_length(n));
    let length = spectrum.length as f64;
    let last = spectrum.bins.len() - 1;
    let power = spectrum.bins.iter().enumerate().map(|(i, bin)| {
        let twice = if i == 0 || i == last { 1.0 } else { 2.0 };
        twice * bin.norm_sqr() / (weight * length)
    });
    Periodogram {
        power: power.collect(),
        frequency: (0..=last).map(|i| i as f64 / length).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::variance;
    use super::*;

    #[test]
    fn there_and_back() {
        let x: Vec<f64> = (0..37).map(|k| f64::from(k * k % 11)).collect();
        for length in [37, 64] {
            let back = Spectrum::of(&x, length).inverse();
            assert!(x.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }

    #[test]
    fn power_adds_up_to_the_variance() {
        let x: Vec<f64> = (0..1000).map(|k| 3.0 * (0.37 * f64::from(k)).sin() + 20.0).collect();
        let all: f64 = periodogram(&x).power.iter().sum();
        assert!((all / variance(&x) - 1.0).abs() < 0.01, "{all}");
    }
}
