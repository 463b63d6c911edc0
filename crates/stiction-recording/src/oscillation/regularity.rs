//! The regularity of an oscillation, by the zero crossings of its autocorrelation.

use crate::series::{autocorrelation, mean, sample_std, zero_crossings};

/// The most crossings in use; later ones of a decaying autocorrelation are noise.
const MOST_CROSSINGS: usize = 11;

/// The fewest crossings for a regularity: three intervals, because fewer have no meaningful spread.
const FEWEST_CROSSINGS: usize = 4;

/// The regularity of an oscillation.
#[derive(Debug, Clone, PartialEq)]
pub struct Regularity {
    /// `r = mean(T) / (3 s(T))` of the intervals T between zero crossings of the autocorrelation, s with
    /// divisor n - 1; above 1 the oscillation counts as regular. Infinite if all intervals are equal.
    pub index: f64,
    /// Period, in samples: twice the mean interval.
    pub period: f64,
    /// The lags of the crossings used, in samples.
    pub crossings: Vec<f64>,
}

impl Regularity {
    /// The regularity of a series, its mean removed, by the autocorrelation with divisor n over all
    /// lags; `None` if the series is constant or its autocorrelation crosses zero fewer than four
    /// times.
    ///
    /// Thornhill, Huang & Zhang 2003, J. Process Control 13, 91-100 (recalled, not read). The first 11
    /// crossings are used, from the first one on; the lag from zero to the first is not an interval.
    pub fn of(x: &[f64]) -> Option<Self> {
        Self::of_autocorrelation(&autocorrelation(x, x.len().saturating_sub(1))?)
    }

    /// The regularity of an autocorrelation from lag zero on.
    pub fn of_autocorrelation(lags: &[f64]) -> Option<Self> {
        let crossings: Vec<f64> =
            zero_crossings(lags).iter().take(MOST_CROSSINGS).map(|c| c.place).collect();
        if crossings.len() < FEWEST_CROSSINGS {
            return None;
        }
        let intervals: Vec<f64> = crossings.windows(2).map(|c| c[1] - c[0]).collect();
        let (mean, spread) = (mean(&intervals), sample_std(&intervals));
        let index = if spread > 0.0 { mean / (3.0 * spread) } else { f64::INFINITY };
        Some(Self { index, period: 2.0 * mean, crossings })
    }

    /// Number of intervals of the index.
    pub fn intervals(&self) -> usize {
        self.crossings.len().saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_sine_is_regular_and_noise_is_not() {
        let sine: Vec<f64> = (0..3000).map(|k| (TAU * f64::from(k) / 37.0).sin()).collect();
        let of_sine = Regularity::of(&sine).unwrap();
        assert!(of_sine.index > 100.0);
        assert!((of_sine.period - 37.0).abs() < 0.02);
        assert_eq!(of_sine.intervals(), 10);
        let noise = crate::oscillation::test_signals::noise(3000, 1);
        assert!(Regularity::of(&noise).unwrap().index < 1.0);
    }

    #[test]
    fn intervals_by_hand() {
        // Crossings at 0.5, 2.5, 4.5 and 7.5: intervals 2, 2 and 3.
        let lags = [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, -1.0, 1.0];
        let found = Regularity::of_autocorrelation(&lags).unwrap();
        assert_eq!(found.crossings, [0.5, 2.5, 4.5, 7.5]);
        assert!((found.period - 14.0 / 3.0).abs() < 1e-12);
        assert!((found.index - 7.0 / 3.0 / (3.0 * (1f64 / 3.0).sqrt())).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_crossings_has_none() {
        for x in [&[][..], &[1.0], &[1.0, 2.0, 3.0], &[4.2; 100]] {
            assert_eq!(Regularity::of(x), None);
        }
    }
}
