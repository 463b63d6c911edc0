//! Peaks of the spectrum above its background.

use crate::series::{median, periodogram};
use std::f64::consts::{LN_2, SQRT_2};

/// Largest chance of a false peak anywhere in a spectrum of noise.
pub const SIGNIFICANT: f64 = 1e-3;

/// The fewest periods of a peak in the data; slower ones cannot be distinguished from drift.
pub const FEWEST_PERIODS: f64 = 3.0;

/// The most peaks.
pub const MOST_PEAKS: usize = 5;

/// Smallest frequency ratio of two separate peaks.
pub const APART: f64 = SQRT_2;

/// A peak of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralPeak {
    /// Frequency, cycles per sample.
    pub frequency: f64,
    /// Power of the peak relative to the power of the background.
    pub over_background: f64,
    /// The chance that noise with this background has such a peak anywhere: at most [`SIGNIFICANT`].
    pub chance: f64,
}

/// The significant peaks of a series less its mean, strongest first.
///
/// The background at a frequency is the median of the periodogram (Hann window) from half to twice that frequency, over
/// ln 2. For pure noise this is its mean, because the power of noise is distributed exponentially around the
/// background. With z the ratio of a peak to the background, and N = n / 2 independent frequencies, the chance of a
/// false peak is `1 - (1 - exp(-z))^N`, as in Fisher's test (Fisher 1929, Proc. Royal Society A 125, 54-59), but
/// against a coloured background. The robust background by a running median was proposed by Mann & Lees 1996, Climatic
/// Change 33, 409-445 (both recalled, not read). From the strongest on, each significant peak covers those within a
/// factor of [`APART`] in frequency.
pub fn significant_peaks(x: &[f64]) -> Vec<SpectralPeak> {
    let n = x.len() as f64;
    if x.len() < 8 {
        return vec![];
    }
    let spectrum = periodogram(x);
    let bins = (spectrum.power.len() - 1) as f64;
    // Bin of a frequency; the last bin is the Nyquist frequency.
    let bin = |frequency: f64| frequency * 2.0 * bins;
    let first = bin(FEWEST_PERIODS / n).ceil() as usize;
    if first + 2 >= spectrum.power.len() {
        return vec![];
    }
    // Background at every half octave, down from the Nyquist frequency.
    let mut background: Vec<f64> = vec![];
    let mut centre = 0.5;
    loop {
        let from = (bin(centre / 2.0).floor() as usize).max(1);
        let to = (bin(centre * 2.0).ceil() as usize).min(spectrum.power.len() - 1);
        background.push((median(&spectrum.power[from..=to]) / LN_2).max(f64::MIN_POSITIVE));
        if bin(centre) <= first as f64 {
            break;
        }
        centre /= SQRT_2;
    }
    let level = |i: usize| {
        let place = (2.0 * (bins / i as f64).log2()).clamp(0.0, (background.len() - 1) as f64);
        let (below, share) = (place.floor() as usize, place.fract());
        let next = background[(below + 1).min(background.len() - 1)];
        background[below].powf(1.0 - share) * next.powf(share)
    };
    let last = spectrum.power.len() - 1;
    let lowest = background.iter().fold(f64::INFINITY, |m: f64, b| m.min(*b));
    // A ratio must exceed ln(N / chance) for the chance to be that small.
    let ratio = (n / 2.0 / SIGNIFICANT).ln();
    let power = |i: usize| spectrum.power[i];
    let mut candidates: Vec<usize> = (first..=last)
        .filter(|&i| {
            power(i) > ratio * lowest
                && power(i) >= power(i - 1)
                && (i == last || power(i) > power(i + 1))
                && power(i) > ratio * level(i)
        })
        .collect();
    candidates.sort_by(|a, b| power(*b).total_cmp(&power(*a)).then(a.cmp(b)));
    let mut peaks: Vec<SpectralPeak> = vec![];
    for i in candidates {
        let frequency = refined(&spectrum.power, i) / (2.0 * bins);
        let covered = |p: &SpectralPeak| (1.0 / APART..=APART).contains(&(frequency / p.frequency));
        if peaks.iter().any(covered) {
            continue;
        }
        let over_background = power(i) / level(i);
        // 1 - (1 - e)^N without cancellation.
        let chance = -(n / 2.0 * (-(-over_background).exp()).ln_1p()).exp_m1();
        peaks.push(SpectralPeak { frequency, over_background, chance });
        if peaks.len() == MOST_PEAKS {
            break;
        }
    }
    peaks
}

/// The position of a maximum between the bins, by a parabola through the logarithms beside it.
fn refined(power: &[f64], i: usize) -> f64 {
    let at = |i: usize| power.get(i).map_or(f64::NAN, |p| p.ln());
    let (a, b, c) = (at(i.wrapping_sub(1)), at(i), at(i + 1));
    let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
    i as f64 + if shift.is_finite() { shift.clamp(-0.5, 0.5) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oscillation::test_signals::{noise, sine};

    #[test]
    fn a_sine_in_noise_is_found_at_its_frequency() {
        let mut x = noise(2000, 5);
        for (v, s) in x.iter_mut().zip(sine(2000, 43.0)) {
            *v += 0.5 * s;
        }
        let peaks = significant_peaks(&x);
        assert_eq!(peaks.len(), 1, "{peaks:?}");
        assert!((1.0 / peaks[0].frequency - 43.0).abs() < 0.5);
        assert!(peaks[0].chance < 1e-6);
    }

    #[test]
    fn noise_white_or_red_seldom_has_a_peak() {
        let mut false_peaks = 0;
        for seed in 0..200 {
            let white = noise(1000, seed);
            let red: Vec<f64> = white
                .iter()
                .scan(0.0, |y, e| {
                    *y = 0.95 * *y + e;
                    Some(*y)
                })
                .collect();
            for x in [white, red] {
                false_peaks += usize::from(!significant_peaks(&x).is_empty());
            }
        }
        // The background itself is estimated, from few bins at low frequencies.
        assert!(false_peaks <= 8, "{false_peaks} of 400");
    }

    #[test]
    fn short_or_still_has_none() {
        for x in [&[][..], &[1.0, 2.0, 1.0], &[0.1; 100]] {
            assert!(significant_peaks(x).is_empty());
        }
    }
}
