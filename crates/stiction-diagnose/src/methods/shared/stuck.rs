//! Rests of a recorded stem while its OP moves.

use crate::series::{median, median_absolute_deviation, span};

/// Standard deviations of the noise within which a stem counts as resting. Ours: two consecutive samples beyond it
/// occur by chance once in 10^8.
const NOISE_WIDTH: f64 = 4.0;

/// Smallest OP travel of a rest, in tolerances. Ours: a stem that follows the OP stays within the tolerance of its
/// mean for at most two of them.
const LEAST_TRAVEL: f64 = 3.0;

/// Number of samples of a rest for the estimate of noise. Ours.
const NOISE_SAMPLES: usize = 8;

/// Largest step that counts as resolution of the sensor, percent. Ours: coarser ones count as slips of the stem.
const LARGEST_QUANTUM: f64 = 1.0;

/// Rounding of the samples, as a share of the largest.
const ROUNDING: f64 = 1e-9;

/// A time in which the OP travels and the stem rests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckSpan {
    /// First sample at rest.
    pub first: usize,
    /// One past the last sample at rest.
    pub end: usize,
    /// Where the stem rests, percent.
    pub level: f64,
}

/// Resolution of a stem's samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Rests {
    pub spans: Vec<StuckSpan>,
    /// Distance from its level within which a stem counts as resting.
    pub tolerance: f64,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// Common divisor of all steps; 0 for none.
    pub quantum: f64,
}

/// The common divisor of all steps of `x`, except for one in a hundred; 0 without a common divisor, or with one larger
/// than a sensor's resolution.
fn quantum(x: &[f64]) -> f64 {
    let steps: Vec<f64> = x.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let moves = || steps.iter().filter(|step| **step > 0.0);
    let least = moves().copied().fold(f64::INFINITY, f64::min);
    let odd = moves().filter(|step| {
        let multiple = **step / least;
        (multiple - multiple.round()).abs() > 0.01
    });
    if least <= LARGEST_QUANTUM && 100 * odd.count() <= moves().count() { least } else { 0.0 }
}

/// Cuts `x` where two consecutive samples leave the tolerance around the mean of the samples before, and keeps the
/// pieces during which `u` travels.
fn rests(u: &[f64], x: &[f64], tolerance: f64, least_travel: f64) -> Vec<StuckSpan> {
    let mut spans = vec![];
    let mut first = 0;
    let (mut mean, mut count) = (x.first().copied().unwrap_or(0.0), 0.0);
    for k in 0..x.len() {
        let inside = |k: usize| x.get(k).is_none_or(|v| (v - mean).abs() <= tolerance);
        if inside(k) {
            count += 1.0;
            mean += (x[k] - mean) / count;
        } else if !inside(k + 1) {
            if span(&u[first..k]) > least_travel {
                spans.push(StuckSpan { first, end: k, level: median(&x[first..k]) });
            }
            (first, mean, count) = (k, x[k], 1.0);
        }
    }
    if span(&u[first..]) > least_travel {
        spans.push(StuckSpan { first, end: x.len(), level: median(&x[first..]) });
    }
    spans
}

/// The rests of the stem `x` under the OP `u`, in which the OP travels at least by `least_travel`. The
/// noise is estimated twice: from second differences, then from the rests.
pub fn find_rests(u: &[f64], x: &[f64], least_travel: f64) -> Rests {
    let n = u.len().min(x.len());
    let (u, x) = (&u[..n], &x[..n]);
    let seconds: Vec<f64> = x.windows(3).map(|w| w[2] - 2.0 * w[1] + w[0]).collect();
    let first_guess = median_absolute_deviation(&seconds) / 6f64.sqrt();
    let quantum = quantum(x);
    let floor = ROUNDING * x.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let with = |noise: f64| {
        let tolerance = (NOISE_WIDTH * noise).max(quantum * (1.0 + ROUNDING)).max(floor);
        let spans = rests(u, x, tolerance, least_travel.max(LEAST_TRAVEL * tolerance));
        Rests { spans, tolerance, noise, quantum }
    };
    let once = with(if first_guess.is_finite() { first_guess } else { 0.0 });
    let mut left = vec![];
    for span in once.spans.iter().filter(|span| span.end - span.first >= NOISE_SAMPLES) {
        left.extend(x[span.first..span.end].iter().map(|v| v - span.level));
    }
    if left.is_empty() {
        return once;
    }
    with(median_absolute_deviation(&left))
}
