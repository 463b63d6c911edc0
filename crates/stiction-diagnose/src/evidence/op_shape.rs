//! The shape of the OP's wave. Needs no PV.

use super::patterns::TURN;
use super::prepared::Prepared;
use super::regression::autoregression;
use super::turns::{spread, turns};
use super::waves::{HalfWaves, components, share_about, third_harmonic};
use super::{Feature, Line};
use crate::methods::bicoherence::Bicoherence;
use crate::oscillation::{Regularity, decay_ratio};
use crate::series::{
    autocorrelation, excess_kurtosis, mean, median, noise_std, skewness, variance,
};

const fn feature(name: &'static str, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::OpShape, monotone: 0 }
}

/// Features.
pub const FEATURES: [Feature; 31] = [
    feature("op_triangle", "He's index of half waves: 0 a sine, 1 a triangle"),
    feature("op_relay", "Rossi and Scali's index of half waves: 1 a triangle or relay's response"),
    feature("op_square", "Hägglund's index of half waves: -1 a sine, 1 a square wave"),
    feature("op_lateness", "half-wave area before the peak over area after the peak, logarithm"),
    feature("op_explained", "share of the variance that the best shape of half waves explains"),
    feature("op_peaked", "third harmonic: near 1 for peaked waves, -1 for flat waves"),
    feature("op_leaning", "third harmonic: 0 for waves as steep up as down, 1 for leaning waves"),
    feature(
        "op_chord",
        "share of the variance that straight lines between reversals do not explain",
    ),
    feature("op_leg_time_spread", "relative spread of the times between reversals"),
    feature("op_leg_height_spread", "relative spread of the travels between reversals"),
    feature("op_turns", "reversals per cycle"),
    feature("op_turn_energy", "innovation near reversals over innovation anywhere, logarithm"),
    feature("op_slope_flatness", "squared mean over mean square of the slopes: 1 a triangle"),
    feature("op_slope_kurtosis", "excess kurtosis of slopes: < 0 for triangles, large for jumps"),
    feature("op_near_ends", "share of the time in the outer tenths of the span"),
    feature("op_regularity", "regularity of the autocorrelation, r / (1 + r)"),
    feature("op_decay", "decay ratio of the autocorrelation"),
    feature("op_innovation", "share of the variance that an AR(4) does not predict, logarithm"),
    feature("op_innovation_kurtosis", "excess kurtosis of the error of an AR(4) prediction"),
    feature("op_kurtosis", "excess kurtosis of the OP without its slow part"),
    feature("op_skewness", "size of the OP's skewness"),
    feature("op_irreversible", "size of the third moment of steps over a 24th of a period"),
    feature(
        "op_irreversible_quarter",
        "size of the third moment of the OP's steps over a quarter of a period",
    ),
    feature("op_ngi", "non-Gaussianity index of the bicoherence"),
    feature("op_nli", "nonlinearity index of the bicoherence"),
    feature("op_cubic", "largest coupling of a frequency with its third harmonic"),
    feature("op_peak_share", "share of the power around the dominant frequency"),
    feature(
        "op_harmonic_2",
        "power around twice the dominant frequency over the power around the dominant frequency, logarithm",
    ),
    feature(
        "op_harmonic_3",
        "power around three times the dominant frequency over the power around the dominant frequency, logarithm",
    ),
    feature("op_noise", "noise of the OP over the OP's standard deviation, logarithm"),
    feature(
        "op_fine_kurtosis",
        "excess kurtosis of the error of an AR(4) prediction at three times the resolution",
    ),
];

/// Share of a period for a slope.
pub(super) const SLOPE: f64 = 1.0 / 12.0;

/// Number of samples in a segment of the bicoherence: less than three periods at its resolution, so that a few cycles
/// have enough segments.
const SEGMENT: usize = 32;

/// Smaller ratios count as zero.
const LEAST_RATIO: f64 = 1e-6;

/// Measures them.
pub fn measure(prepared: &Prepared<'_>, out: &mut Vec<f64>) {
    let (op, period) = (&prepared.op, prepared.period);
    let waves = HalfWaves::of(&op.high);
    let first = components(&op.high, period, 1.0);
    let third = third_harmonic(&first, &components(&op.high, period, 3.0));

    let legs = Legs::of(&op.values, TURN * op.span);
    let model = autoregression(&op.values);
    let turn_energy = model
        .as_ref()
        .filter(|m| !m.is_exact())
        .map_or(f64::NAN, |m| near_turns(&m.residuals, &legs.turns, prepared.lag(1.0 / 12.0)));
    let slopes = steps(&op.high, prepared.lag(SLOPE));
    let lags = autocorrelation(&op.high, op.high.len()).unwrap_or_default();
    let plane = Bicoherence { segment: SEGMENT, ..Bicoherence::default() }
        .plane(&op.high, Some(period))
        .ok();
    let frequency = 1.0 / (period * prepared.factor as f64);
    let at = |harmonic: f64| share_about(&prepared.op_spectrum, harmonic * frequency);
    let peak = at(1.0);
    let harmonic = |h: f64| {
        // Nothing can be measured beyond the Nyquist frequency.
        if h * frequency > 0.45 { f64::NAN } else { (at(h) / peak).max(LEAST_RATIO).ln() }
    };
    let values: [f64; FEATURES.len()] = [
        waves.triangle,
        waves.relay,
        waves.square,
        waves.lateness,
        waves.explained,
        third.re,
        third.im.abs(),
        legs.chord(&op.values),
        spread(&legs.times),
        spread(&legs.heights),
        legs.turns.len() as f64 / prepared.cycles(),
        turn_energy,
        flatness(&slopes),
        excess_kurtosis(&slopes),
        near_ends(&op.high, op.span),
        Regularity::of_autocorrelation(&lags).map_or(f64::NAN, |r| 1.0 / (1.0 + 1.0 / r.index)),
        decay_ratio::of_autocorrelation(&lags).map_or(f64::NAN, |r| r.clamp(-1.0, 2.0)),
        model.as_ref().map_or(f64::NAN, |m| m.ln_left()),
        model.as_ref().map_or(f64::NAN, |m| m.kurtosis()),
        excess_kurtosis(&op.high),
        skewness(&op.high).abs(),
        irreversibility(&op.high, prepared.lag(1.0 / 24.0)),
        irreversibility(&op.high, prepared.lag(1.0 / 4.0)),
        plane.as_ref().map_or(f64::NAN, |p| p.ngi),
        plane.as_ref().map_or(f64::NAN, |p| p.nli),
        plane.as_ref().and_then(|p| p.cubic).map_or(f64::NAN, |c| c.value),
        peak,
        harmonic(2.0),
        harmonic(3.0),
        noise_std(&op.values).max(LEAST_RATIO).ln(),
        autoregression(&prepared.fine_op).map_or(f64::NAN, |m| m.kurtosis()),
    ];
    out.extend(values);
}

/// A signal, divided at its turning points.
pub(super) struct Legs {
    pub turns: Vec<usize>,
    pub times: Vec<f64>,
    pub heights: Vec<f64>,
}

impl Legs {
    /// From a signal that turns if it reverses by more than `least`.
    pub fn of(x: &[f64], least: f64) -> Self {
        let turns = turns(x, least);
        let times: Vec<f64> = turns.windows(2).map(|t| (t[1] - t[0]) as f64).collect();
        let heights: Vec<f64> = turns.windows(2).map(|t| (x[t[1]] - x[t[0]]).abs()).collect();
        Self { turns, times, heights }
    }

    /// Share of the variance between the first turn and the last that straight lines from turn to turn do not
    /// explain; 0 for a triangle, `2 (5/6 - 8/pi^2)` for a sine.
    pub fn chord(&self, x: &[f64]) -> f64 {
        let (Some(&first), Some(&last)) = (self.turns.first(), self.turns.last()) else {
            return f64::NAN;
        };
        if self.turns.len() < 3 {
            return f64::NAN;
        }
        let mut squares = 0.0;
        for pair in self.turns.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let slope = (x[to] - x[from]) / (to - from) as f64;
            let miss = |k: usize| x[k] - x[from] - slope * (k - from) as f64;
            squares += (from..to).map(|k| miss(k).powi(2)).sum::<f64>();
        }
        squares / ((last - first) as f64 * variance(&x[first..last]))
    }
}

/// Differences over `lag` samples.
pub(super) fn steps(x: &[f64], lag: usize) -> Vec<f64> {
    x.iter().zip(x.iter().skip(lag)).map(|(a, b)| b - a).collect()
}

/// Squared mean over mean square of sizes: 1 if all are equal, 8/pi^2 for a sine's, 2/pi for noise.
pub(super) fn flatness(x: &[f64]) -> f64 {
    let squares: f64 = x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
    let sizes: f64 = x.iter().map(|v| v.abs()).sum::<f64>() / x.len() as f64;
    sizes * sizes / squares
}

/// Share of the samples in the outer tenths of the span about zero.
fn near_ends(x: &[f64], span: f64) -> f64 {
    let middle = median(x);
    x.iter().filter(|v| (*v - middle).abs() >= 0.4 * span).count() as f64 / x.len() as f64
}

/// Size of the third moment of the differences over `lag` samples, over the cube of their root mean
/// square: 0 for a series that looks the same backwards.
fn irreversibility(x: &[f64], lag: usize) -> f64 {
    let steps = steps(x, lag);
    let moment = |power: i32| steps.iter().map(|d| d.powi(power)).sum::<f64>() / steps.len() as f64;
    moment(3).abs() / moment(2).powf(1.5)
}

/// Logarithm of a ratio of mean energies: residuals within `reach` samples of turns over all residuals. The residuals
/// end with the signal.
fn near_turns(residuals: &[f64], turns: &[usize], reach: usize) -> f64 {
    let first = 4;
    let energy: Vec<f64> = residuals.iter().map(|r| r * r).collect();
    let (mut near, mut count, mut done) = (0.0, 0usize, 0usize);
    for turn in turns {
        let from = turn.saturating_sub(reach + first).max(done);
        let to = (turn + reach + 1).saturating_sub(first).min(energy.len());
        if from < to {
            near += energy[from..to].iter().sum::<f64>();
            count += to - from;
            done = to;
        }
    }
    (near / count as f64 / mean(&energy)).max(LEAST_RATIO).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn chords_and_slopes_of_sine_and_triangle() {
        let sine: Vec<f64> = (0..4000).map(|k| (TAU * f64::from(k) / 400.0).sin()).collect();
        let triangle: Vec<f64> =
            sine.iter().map(|v| v.clamp(-1.0, 1.0).asin() * 2.0 / PI).collect();
        let chord = |x: &[f64]| Legs::of(x, 0.7).chord(x);
        assert!((chord(&sine) - 2.0 * (5.0 / 6.0 - 8.0 / PI.powi(2))).abs() < 1e-3);
        assert!(chord(&triangle) < 1e-6);
        assert!((flatness(&steps(&sine, 1)) - 8.0 / PI.powi(2)).abs() < 1e-3);
        assert!((flatness(&steps(&triangle, 1)) - 1.0).abs() < 1e-2);
        // Nine whole periods of steps.
        assert!(irreversibility(&sine[..3650], 50) < 1e-9);
    }
}
