//! Several oscillations at once, separated by frequency.

use super::decay_ratio;
use super::regularity::Regularity;
use super::spectral_peak::{APART, FEWEST_PERIODS, SpectralPeak, significant_peaks};
use crate::series::{Spectrum, fft_length};

/// The smallest share of the variance in the band of a separate oscillation.
pub const LEAST_SHARE: f64 = 0.01;

/// An oscillation of a signal: a significant peak of the spectrum, and the band around the peak.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Peak {
    /// Period, s: from the autocorrelation of the band, or from the peak if the autocorrelation has too few zero
    /// crossings.
    pub period_s: f64,
    /// Amplitude of a sine with the power of the band, in the signal's units.
    pub amplitude: f64,
    /// Share of the band in the variance of the signal without drift. Everything with fewer than three periods in the
    /// signal is drift.
    pub share: f64,
    /// Regularity r of the band. A band-pass makes noise look regular, so r counts only together with the peak's
    /// significance.
    pub regularity: Option<f64>,
    /// Decay ratio R of the band; in a band with only noise, R is below 0.5.
    pub decay_ratio: Option<f64>,
    /// Probability that noise has such a peak at any frequency.
    pub chance: f64,
    /// Power of the peak relative to the power of the background.
    pub over_background: f64,
    /// Number of the harmonic, if the oscillation is a harmonic of a stronger oscillation; else `None`.
    pub harmonic: Option<usize>,
    /// Lower and upper end of the band, cycles per sample.
    #[cfg_attr(feature = "serde", schemars(with = "[f64; 2]"))]
    pub band: (f64, f64),
    /// Whether the oscillation is separate: r exceeds 1, R exceeds 0.5, the share is at least 0.1 (our choice), and the
    /// oscillation is no harmonic.
    pub is_oscillation: bool,
}

/// The oscillations of `x`, which has zero mean, by power; empty without significant peaks.
///
/// The band of each peak extends from its frequency over the square root of two to its frequency times that, or to
/// the geometric mean with a nearer neighbour. Other frequencies are set to zero in the transform of the series,
/// padded to twice its length (Thornhill, Huang & Zhang 2003, J. Process Control 13, 91-100, filter in the
/// frequency domain; their widths were not read).
pub fn separate(x: &[f64], sample_time: f64) -> Vec<Peak> {
    let spectrum = Spectrum::of(x, fft_length(2 * x.len()));
    separate_spectrum(x, &spectrum, sample_time)
}

pub(super) fn separate_spectrum(x: &[f64], spectrum: &Spectrum, sample_time: f64) -> Vec<Peak> {
    let found = significant_peaks(x);
    let slowest = FEWEST_PERIODS / x.len().max(1) as f64;
    let total: f64 =
        spectrum.bins[bins(spectrum, (slowest, 0.5))].iter().map(|bin| bin.norm_sqr()).sum();
    let mut peaks: Vec<Peak> = vec![];
    for (i, peak) in found.iter().enumerate() {
        let band = band_of(&found, i);
        let power: f64 = spectrum.bins[bins(spectrum, band)].iter().map(|bin| bin.norm_sqr()).sum();
        let share = power / total;
        if !(share >= LEAST_SHARE) {
            continue;
        }
        let lags = band_autocorrelation(spectrum, band, x.len());
        let regularity = Regularity::of_autocorrelation(&lags);
        let period = regularity.as_ref().map_or(1.0 / peak.frequency, |r| r.period);
        let mean_square = 2.0 * power / (spectrum.length as f64 * x.len() as f64);
        let regularity = regularity.map(|r| r.index);
        let decay_ratio = decay_ratio::of_autocorrelation(&lags);
        let harmonic = harmonic(&found[..i], peak.frequency, x.len());
        peaks.push(Peak {
            period_s: period * sample_time,
            amplitude: (2.0 * mean_square).sqrt(),
            share,
            regularity,
            decay_ratio,
            chance: peak.chance,
            over_background: peak.over_background,
            harmonic,
            band,
            is_oscillation: regularity.is_some_and(|r| r > 1.0)
                && decay_ratio.is_some_and(|ratio| ratio > decay_ratio::OSCILLATES)
                && share >= 0.1
                && harmonic.is_none(),
        });
    }
    peaks.sort_by(|a, b| b.share.total_cmp(&a.share));
    peaks
}

/// The series in a band, of the length of the series.
pub(super) fn band_passed(spectrum: &Spectrum, band: (f64, f64), n: usize) -> Vec<f64> {
    let mut within = only(spectrum, band).inverse();
    within.truncate(n);
    within
}

fn band_autocorrelation(spectrum: &Spectrum, band: (f64, f64), n: usize) -> Vec<f64> {
    let mut within = only(spectrum, band);
    within.bins.iter_mut().for_each(|bin| *bin = bin.norm_sqr().into());
    let mut lags = within.inverse();
    lags.truncate(n);
    lags
}

fn only(spectrum: &Spectrum, band: (f64, f64)) -> Spectrum {
    let mut within = spectrum.clone();
    let range = bins(spectrum, band);
    within.bins[..range.start].fill(0.0.into());
    within.bins[range.end..].fill(0.0.into());
    within
}

fn bins(spectrum: &Spectrum, band: (f64, f64)) -> std::ops::Range<usize> {
    let length = spectrum.length as f64;
    let to = ((band.1 * length).floor() as usize + 1).min(spectrum.bins.len());
    ((band.0 * length).ceil() as usize).clamp(1, to)..to
}

fn band_of(peaks: &[SpectralPeak], i: usize) -> (f64, f64) {
    let own = peaks[i].frequency;
    let (mut low, mut high) = (own / APART, own * APART);
    for (k, other) in peaks.iter().enumerate() {
        let border = (own * other.frequency).sqrt();
        if k != i && other.frequency < own {
            low = low.max(border);
        } else if k != i {
            high = high.min(border);
        }
    }
    (low, high)
}

/// The multiple of a stronger peak's frequency, if it is one within the resolution of the data.
fn harmonic(stronger: &[SpectralPeak], frequency: f64, n: usize) -> Option<usize> {
    stronger.iter().find_map(|peak| {
        let multiple = frequency / peak.frequency;
        let whole = multiple.round();
        let resolution = 2.0 / (n as f64 * peak.frequency);
        let near = (multiple - whole).abs() <= resolution.max(0.02 * whole).min(0.25);
        (whole >= 2.0 && near).then_some(whole as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oscillation::test_signals::{noise, sine};

    #[test]
    fn two_sines_are_distinguished() {
        let x: Vec<f64> = sine(4000, 130.0)
            .iter()
            .zip(sine(4000, 31.0))
            .zip(noise(4000, 3))
            .map(|((a, b), e)| 2.0 * a + b + 0.2 * e)
            .collect();
        let peaks = separate(&x, 0.5);
        assert_eq!(peaks.len(), 2, "{peaks:#?}");
        for (peak, (period, amplitude, share)) in
            peaks.iter().zip([(65.0, 2.0, 4.0 / 5.08), (15.5, 1.0, 1.0 / 5.08)])
        {
            assert!((peak.period_s / period - 1.0).abs() < 0.01, "{peak:?}");
            assert!((peak.amplitude / amplitude - 1.0).abs() < 0.03, "{peak:?}");
            assert!((peak.share - share).abs() < 0.03, "{peak:?}");
            assert!(peak.is_oscillation && peak.harmonic.is_none());
        }
    }

    #[test]
    fn harmonics_of_a_square_wave_are_named() {
        let x: Vec<f64> = sine(4000, 100.3)
            .iter()
            .map(|v| v.signum())
            .zip(noise(4000, 1))
            .map(|(a, b)| a + 0.1 * b)
            .collect();
        let peaks = separate(&x, 1.0);
        assert_eq!(peaks[0].harmonic, None);
        assert_eq!(peaks[1].harmonic, Some(3));
        assert!((peaks[0].amplitude - 4.0 / std::f64::consts::PI).abs() < 0.02);
    }
}
