//! Whether a loop cycles, its regularity, period and amplitude, and the times of oscillation.
//!
//! Each published method is one file. [`analyse`] runs them all.

pub mod decay_ratio;
pub mod episodes;
pub mod iae;
pub mod regularity;
pub mod separate;
pub mod spectral_peak;
pub mod swing;

pub use episodes::Episode;
pub use regularity::Regularity;
pub use separate::Peak;
pub use swing::swing;

use crate::series::{Spectrum, detrended, fft_length, max, min, noise_std, span, std};
use crate::spoken::time;
use iae::{Supervised, Supervision};
use std::f64::consts::SQRT_2;

/// The fewest intervals between zero crossings of the autocorrelation for `r > 1` to count. Five span three
/// periods; the spread of fewer is often small by chance.
pub const FEWEST_INTERVALS: usize = 5;

/// The method that found an oscillation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OscillationBasis {
    /// The autocorrelation of the signal crosses zero regularly.
    Autocorrelation,
    /// A significant peak of the spectrum, whose band oscillates regularly and lastingly.
    SpectralPeak,
}

impl OscillationBasis {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Autocorrelation => "autocorrelation",
            Self::SpectralPeak => "spectral peak",
        }
    }
}

/// The oscillation of one signal.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Oscillation {
    /// Whether the signal oscillates.
    pub found: bool,
    /// The method that found the oscillation.
    pub basis: Option<OscillationBasis>,
    /// Period of the dominant oscillation, s; `None` without an oscillation.
    pub period_s: Option<f64>,
    /// The median over the periods of half of the peak-to-peak value, without noise, in the signal's units.
    pub amplitude: Option<f64>,
    /// Number of periods in the signal.
    pub cycles: Option<f64>,
    /// Regularity r of the zero crossings of the autocorrelation (Thornhill, Huang and Zhang, 2003); above 1, the
    /// oscillation is regular.
    pub regularity: Option<f64>,
    /// Number of intervals between zero crossings from which r is calculated; 0 without r.
    pub intervals: usize,
    /// Decay ratio R of the autocorrelation (Miao and Seborg, 1999); above 0.5, the signal is oscillatory.
    pub decay_ratio: Option<f64>,
    /// The result of the supervision of half waves (Hägglund, 1995). The ultimate period is the detected period, and
    /// the amplitude is three standard deviations of the noise. `None` without an oscillation, or with fewer than 8
    /// samples per period, because noise then looks like signal.
    #[cfg_attr(feature = "serde", serde(rename = "supervision"))]
    pub supervised: Option<Supervised>,
    /// All significant oscillations in the spectrum, the largest share of the variance first.
    pub peaks: Vec<Peak>,
    /// Time spans of the dominant oscillation.
    pub episodes: Vec<Episode>,
    /// The reasons for the result, in sentences with numbers.
    pub reasons: Vec<String>,
}

impl Oscillation {
    /// The oscillation with times from another origin: the first sample is at `from_s`.
    pub fn since(mut self, from_s: f64) -> Self {
        for episode in &mut self.episodes {
            episode.from_s += from_s;
            episode.to_s += from_s;
        }
        if let Some(supervised) = &mut self.supervised {
            supervised.alarm_s = supervised.alarm_s.map(|alarm| from_s + alarm);
        }
        self
    }
}

/// Analyses the oscillation of `signal`; its mean and straight trend are removed first. Samples are `sample_time` s
/// apart.
///
/// An oscillation is found if one of these holds:
/// * The autocorrelation crosses zero regularly: r > 1 (Thornhill, Huang & Zhang 2003) over at least
///   [`FEWEST_INTERVALS`] intervals.
/// * A peak of the spectrum exceeds the background so far that the chance of noise is at most one in a thousand. It has
///   a tenth of the variance, and its band has r > 1 and a decay ratio above 0.5 (Miao & Seborg 1999). This finds an
///   oscillation under drift or beside others.
///
/// If the signal has fewer than 8 samples, or a sample that is not finite, no oscillation is returned.
pub fn analyse(signal: &[f64], sample_time: f64) -> Oscillation {
    let nothing = |reason: String| Oscillation { reasons: vec![reason], ..Oscillation::default() };
    let n = signal.len();
    if n < 8 {
        return nothing(format!("{n} samples are too few for an oscillation"));
    }
    if signal.iter().any(|v| !v.is_finite()) || !(sample_time > 0.0 && sample_time.is_finite()) {
        return nothing("a sample or the sample time is not a number".to_owned());
    }
    // Scaled so that squares neither overflow nor vanish.
    let largest = signal.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let range = span(&signal.iter().map(|v| v / 2.0).collect::<Vec<_>>()) * 2.0;
    if !(range > 1e-12 * largest) || !range.is_finite() {
        return nothing("the signal does not move".to_owned());
    }
    let middle = 0.5 * min(signal) + 0.5 * max(signal);
    let scaled: Vec<f64> = signal.iter().map(|v| (v - middle) / range).collect();
    let x = detrended(&scaled);
    if !(std(&x) > 1e-9) {
        return nothing("the signal follows a straight line".to_owned());
    }
    let spectrum = Spectrum::of(&x, fft_length(2 * n));
    let lags = autocorrelation(&spectrum, n);
    let regularity = Regularity::of_autocorrelation(&lags);
    let mut peaks = separate::separate_spectrum(&x, &spectrum, sample_time);
    let mut found = Oscillation {
        regularity: regularity.as_ref().map(|r| r.index),
        intervals: regularity.as_ref().map_or(0, Regularity::intervals),
        decay_ratio: decay_ratio::of_autocorrelation(&lags),
        ..Oscillation::default()
    };
    let regular = regularity.filter(|r| r.index > 1.0 && r.intervals() >= FEWEST_INTERVALS);
    let peak = peaks.iter().find(|peak| peak.is_oscillation);
    let dominant = match (&regular, peak) {
        (Some(regular), _) => {
            found.reasons.push(format!(
                "the autocorrelation crosses zero regularly: r = {:.2} over {} intervals (above 1 is \
                 regular)",
                regular.index,
                regular.intervals()
            ));
            Some((OscillationBasis::Autocorrelation, regular.period))
        }
        (None, Some(peak)) => {
            found.reasons.push(format!(
                "a peak of the spectrum at a period of {} is {:.0} times above the background and has {:.0} % of the \
                 variance; in its band r = {:.2}",
                time(peak.period_s),
                peak.over_background,
                100.0 * peak.share,
                peak.regularity.unwrap_or(f64::NAN)
            ));
            Some((OscillationBasis::SpectralPeak, peak.period_s / sample_time))
        }
        (None, None) => {
            found.reasons.push(match found.regularity {
                Some(r) => format!(
                    "the autocorrelation does not cross zero regularly (r = {r:.2} over {} \
                     intervals), and no peak of the spectrum is both significant and regular",
                    found.intervals
                ),
                None => {
                    "the autocorrelation crosses zero fewer than four times, and no peak of the \
                         spectrum is both significant and regular"
                        .to_owned()
                }
            });
            None
        }
    };
    if let Some((basis, period)) = dominant {
        let band = (1.0 / (period * SQRT_2), (SQRT_2 / period).min(0.5));
        let within = separate::band_passed(&spectrum, band, n);
        found.found = true;
        found.basis = Some(basis);
        found.period_s = Some(period * sample_time);
        found.cycles = Some(n as f64 / period);
        found.amplitude = swing(&x, period).map(|swing| range * swing);
        found.episodes = episodes::episodes(&within, period, sample_time);
        found.episodes.iter_mut().for_each(|episode| episode.amplitude *= range);
        if period >= 8.0 {
            let supervision = Supervision::new(3.0 * noise_std(&x), period * sample_time);
            let mut supervised = iae::supervise(&x, sample_time, &supervision);
            supervised.threshold *= range;
            found.supervised = Some(supervised);
        } else if period < 4.0 {
            found.reasons.push(format!(
                "a period has {period:.1} samples: the oscillation may be an alias of a faster oscillation"
            ));
        }
    }
    peaks.iter_mut().for_each(|peak| peak.amplitude *= range);
    found.peaks = peaks;
    found
}

/// Autocorrelation at the lags 0 to n - 1, of the transform of a series padded to twice its length.
fn autocorrelation(spectrum: &Spectrum, n: usize) -> Vec<f64> {
    let mut power = spectrum.clone();
    power.bins.iter_mut().for_each(|bin| *bin = bin.norm_sqr().into());
    let mut lags = power.inverse();
    lags.truncate(n);
    lags
}

#[cfg(test)]
pub(crate) mod test_signals;

#[cfg(test)]
mod tests {
    use super::test_signals::{noise, sine};
    use super::*;

    fn noisy(period: f64, amplitude: f64, seed: u64) -> Vec<f64> {
        sine(2000, period)
            .iter()
            .zip(noise(2000, seed))
            .map(|(s, e)| 50.0 + amplitude * s + e)
            .collect()
    }

    #[test]
    fn a_noisy_sine_is_found_with_its_numbers() {
        let found = analyse(&noisy(80.0, 5.0, 1), 3.0);
        assert!(found.found);
        assert!((found.period_s.unwrap() - 240.0).abs() < 2.0);
        assert!((found.amplitude.unwrap() - 5.0).abs() < 0.8, "{found:?}");
        assert!((found.cycles.unwrap() - 25.0).abs() < 0.3);
        assert!(found.decay_ratio.unwrap() > 0.8);
        assert!(found.supervised.unwrap().oscillates);
        assert_eq!(found.episodes.len(), 1);
        assert!((found.peaks[0].share - 12.5 / 13.5).abs() < 0.05);
    }

    #[test]
    fn drift_does_not_hide_an_oscillation() {
        let mut x = noisy(60.0, 3.0, 2);
        for (k, v) in x.iter_mut().enumerate() {
            *v += 20.0 * (k as f64 / 900.0).sin() + 0.01 * k as f64;
        }
        let found = analyse(&x, 1.0);
        assert_eq!(found.basis, Some(OscillationBasis::SpectralPeak));
        assert!((found.period_s.unwrap() - 60.0).abs() < 1.0);
        assert!(found.peaks.iter().any(|p| (p.period_s - 60.0).abs() < 1.0), "{found:#?}");
    }

    #[test]
    fn noise_seldom_oscillates() {
        let mut hits = 0;
        for seed in 0..200 {
            let white = noise(1000, seed);
            let mut walk = 0.0;
            let red: Vec<f64> = white
                .iter()
                .map(|e| {
                    walk = 0.9 * walk + e;
                    walk
                })
                .collect();
            hits += usize::from(analyse(&white, 1.0).found);
            hits += usize::from(analyse(&red, 1.0).found);
        }
        assert!(hits <= 20, "{hits} of 400");
    }

    #[test]
    fn scale_offset_and_time_unit_change_nothing_else() {
        let x = noisy(45.0, 2.0, 7);
        let moved: Vec<f64> = x.iter().map(|v| 1000.0 - 3.0 * v).collect();
        let (a, b, c) = (analyse(&x, 2.0), analyse(&moved, 2.0), analyse(&x, 120.0));
        let same = |x: Option<f64>, y: Option<f64>, factor: f64| {
            (x.unwrap() * factor / y.unwrap() - 1.0).abs() < 1e-8
        };
        for (other, units, time) in [(&b, 3.0, 1.0), (&c, 1.0, 60.0)] {
            assert!(same(a.period_s, other.period_s, time));
            assert!(same(a.amplitude, other.amplitude, units));
            assert!(same(a.regularity, other.regularity, 1.0));
            assert!(same(a.decay_ratio, other.decay_ratio, 1.0));
            assert_eq!(a.episodes.len(), other.episodes.len());
            assert_eq!(a.basis, other.basis);
            assert_eq!(a.supervised.unwrap().disturbances, other.supervised.unwrap().disturbances);
        }
    }

    #[test]
    fn nothing_makes_it_panic() {
        let alternating: Vec<f64> = (0..100).map(|k| f64::from(k % 2)).collect();
        assert!((analyse(&alternating, 1.0).period_s.unwrap() - 2.0).abs() < 1e-2);
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        for x in [
            &[][..],
            &[1.0, 2.0, 3.0],
            &[0.1; 50],
            &ramp,
            &[f64::NAN; 20],
            &[f64::MAX, -f64::MAX].repeat(10),
            &[5e-324, 0.0].repeat(10),
        ] {
            assert!(!analyse(x, 1.0).found || x.len() == 20, "{x:?}");
        }
        assert!(!analyse(&alternating, 0.0).found);
    }

    #[test]
    fn a_burst_has_its_time() {
        let mut x = noise(3000, 9);
        for (k, s) in sine(3000, 50.0).iter().enumerate() {
            x[k] += if (1000..2200).contains(&k) { 4.0 * s } else { 0.0 };
        }
        let found = analyse(&x, 1.0);
        assert!(found.found);
        assert_eq!(found.episodes.len(), 1, "{:?}", found.episodes);
        assert!((found.episodes[0].from_s - 1000.0).abs() < 100.0);
        assert!((found.episodes[0].to_s - 2200.0).abs() < 100.0);
    }
}
