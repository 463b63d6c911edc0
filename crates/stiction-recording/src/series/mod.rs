//! Common functions of sample series: moments, correlation, crossings, spectra, lines, trends.
//!
//! Lags and positions are in samples. Slices are used unchanged: the caller removes the mean, unless a function
//! states that it does.

mod butterworth;
mod compare;
mod correlation;
mod crossings;
mod fit;
mod plans;
mod resample;
mod spectrum;
mod statistics;
mod transform;
mod trend;

pub use butterworth::low_passed;
pub use compare::{cliffs_delta, difference_of_means, welch};
pub use correlation::{CrossCorrelation, autocorrelation, correlation, cross_correlation};
pub use crossings::{Direction, HalfWave, ZeroCrossing, half_waves, zero_crossings};
pub use fit::{Line, line};
pub use resample::decimated;
pub use spectrum::{Periodogram, Spectrum, fft_length, periodogram};
pub use statistics::{
    centred, detrended, excess_kurtosis, median, median_absolute_deviation, noise_std, quantile,
    running_sums, sample_std, skewness, standardised,
};
pub use stiction_model::numeric::summary::{max, mean, min, reversals, span, std, variance};
pub use transform::{Transform, band_passed};
pub use trend::{Trend, mann_kendall, theil_sen, weighted_trend};
