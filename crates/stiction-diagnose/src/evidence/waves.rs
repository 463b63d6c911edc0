//! The shape of a signal's waves: the published fits of half waves, and the third harmonic.

use super::prepared::of_pair;
use crate::methods::{
    Subject, area_ratio::AreaRatio, curve_fit::CurveFit, relay_fit::RelayFit,
    square_wave::SquareWave,
};
use crate::recording::LoopType;
use crate::series::{Periodogram, variance};
use realfft::num_complex::Complex;

/// The published half-wave indices of a signal; NaN where they abstain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HalfWaves {
    /// He's index: 0 a sine, 1 a triangle.
    pub triangle: f64,
    /// Rossi and Scali's index: -1 a sine, 1 a relay's response or a triangle.
    pub relay: f64,
    /// Hägglund's index: -1 a sine, 1 a square wave.
    pub square: f64,
    /// Logarithm of Singhal and Salsbury's ratio of areas, median: 0 peaks in the middle.
    pub lateness: f64,
    /// Share of the variance that the best of sine, triangle and relay response explains.
    pub explained: f64,
}

impl HalfWaves {
    /// For a signal around its mean.
    pub fn of(x: &[f64]) -> Self {
        let segment = of_pair(x, x);
        let subject = Subject::new(&segment, LoopType::Unknown, None);
        let relay = RelayFit::default().run(&subject).ok();
        let explained = relay.as_ref().map(|r| {
            let least = r.mse.iter().copied().fold(f64::INFINITY, f64::min);
            1.0 - least / variance(x)
        });
        let triangle = CurveFit::default().run(&subject).map(|r| r.statistic);
        let square = SquareWave::default().run(&subject).map(|r| r.statistic);
        let lateness = AreaRatio::default().run(&subject).map(|r| r.median.ln());
        Self {
            triangle: triangle.unwrap_or(f64::NAN),
            relay: relay.map_or(f64::NAN, |r| r.statistic),
            square: square.unwrap_or(f64::NAN),
            lateness: lateness.unwrap_or(f64::NAN),
            explained: explained.unwrap_or(f64::NAN),
        }
    }
}

/// Fewest half-overlapping windows of two periods for a meaningful average.
const FEWEST_WINDOWS: usize = 3;

/// The component of a signal at `harmonic` times the frequency of `period`, in Hann windows of two periods, each
/// half over the next. Its phase refers to the first sample of the window.
pub(super) fn components(x: &[f64], period: f64, harmonic: f64) -> Vec<Complex<f64>> {
    let length = (2.0 * period).round() as usize;
    if length < 8 || 2.0 * harmonic > period {
        return vec![];
    }
    let weights: Vec<Complex<f64>> = (0..length)
        .map(|k| {
            let place = (k as f64 + 0.5) / length as f64;
            let hann = 0.5 - 0.5 * (std::f64::consts::TAU * place).cos();
            Complex::from_polar(hann, -std::f64::consts::TAU * harmonic * k as f64 / period)
        })
        .collect();
    let windows = x.windows(length).step_by((length / 2).max(1));
    windows.map(|window| window.iter().zip(&weights).map(|(x, w)| w * x).sum()).collect()
}

/// Position of the third harmonic on the fundamental, windows weighted by their power: the coherence of the third
/// component with the cube of the first. Its real part is near 1 for peaked waves such as triangles, and -1 for flat
/// ones such as squares. The imaginary part shows leaning waves. NaN for fewer than three windows.
pub(super) fn third_harmonic(first: &[Complex<f64>], third: &[Complex<f64>]) -> Complex<f64> {
    let (mut joint, mut cubes, mut thirds) = (Complex::default(), 0.0, 0.0);
    if first.len().min(third.len()) < FEWEST_WINDOWS {
        return Complex::new(f64::NAN, f64::NAN);
    }
    for (a, c) in first.iter().zip(third) {
        let cube = a * a * a;
        joint += c * cube.conj();
        cubes += cube.norm_sqr();
        thirds += c.norm_sqr();
    }
    joint / (cubes * thirds).sqrt()
}

/// The coherence of two signals by their components: its size squared is the share that a linear
/// relation explains, its angle the phase of `b` after `a`. NaN for fewer than three windows.
pub(super) fn coherence(a: &[Complex<f64>], b: &[Complex<f64>]) -> Complex<f64> {
    if a.len().min(b.len()) < FEWEST_WINDOWS {
        return Complex::new(f64::NAN, f64::NAN);
    }
    let power = |x: &[Complex<f64>]| x.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let joint: Complex<f64> = a.iter().zip(b).map(|(a, b)| b * a.conj()).sum();
    joint / (power(a) * power(b)).sqrt()
}

/// Share of the power of a spectrum that lies within a fifth of `frequency`, per sample.
pub(super) fn share_about(spectrum: &Periodogram, frequency: f64) -> f64 {
    let total: f64 = spectrum.power.iter().sum();
    let about = |f: f64| (f / frequency - 1.0).abs() <= 0.2;
    let near = spectrum.frequency.iter().zip(&spectrum.power).filter(|(f, _)| about(**f));
    near.map(|(_, p)| p).sum::<f64>() / total
}
