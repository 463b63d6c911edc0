//! The shape of the PV's and the control error's wave.

use super::op_shape::{Legs, SLOPE, flatness, steps};
use super::patterns::TURN;
use super::prepared::{Prepared, of_pair};
use super::regression::autoregression;
use super::waves::{HalfWaves, components, third_harmonic};
use super::{Feature, Line};
use crate::methods::{Subject, yamashita_level::YamashitaLevel};
use crate::oscillation::Regularity;
use crate::recording::LoopType;
use crate::series::{autocorrelation, excess_kurtosis};

const fn feature(name: &'static str, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::PvShape, monotone: 0 }
}

/// Features.
pub const FEATURES: [Feature; 16] = [
    feature("error_triangle", "He's index of the error's half waves: 0 a sine, 1 a triangle"),
    feature("error_square", "Hägglund's index of the error's half waves: 1 a square wave"),
    feature("error_lateness", "error's half-wave area before over after the peak, logarithm"),
    feature("pv_relay", "Rossi and Scali's index of the PV's half waves: 1 a relay's response"),
    feature("pv_peaked", "third harmonic of the PV: near 1 for peaked waves, -1 for flat waves"),
    feature("pv_chord", "share of the PV's variance that lines between reversals do not explain"),
    feature("pv_slope_flatness", "squared mean over mean square of the PV's slopes"),
    feature("pv_plateau", "share of the PV's slopes below a tenth of their root mean square"),
    feature("pv_jump", "share of the PV's travel in the fastest tenth of the time"),
    feature("pv_kurtosis", "excess kurtosis of the PV without its slow part"),
    feature("pv_step_kurtosis", "excess kurtosis of the PV's steps"),
    feature(
        "pv_bend_kurtosis",
        "excess kurtosis of the PV's second differences, Yamashita's index for levels",
    ),
    feature("pv_innovation", "share of the variance that an AR(4) does not predict, logarithm"),
    feature("pv_innovation_kurtosis", "excess kurtosis of the error of an AR(4) prediction"),
    feature(
        "pv_fine_kurtosis",
        "excess kurtosis of the error of an AR(4) prediction at three times the resolution",
    ),
    feature("error_regularity", "regularity of the error's autocorrelation, r / (1 + r)"),
];

/// Measures them.
pub fn measure(prepared: &Prepared<'_>, out: &mut Vec<f64>) {
    let (Some(pv), Some(error)) = (&prepared.pv, &prepared.error) else {
        out.extend([f64::NAN; FEATURES.len()]);
        return;
    };
    let period = prepared.period;
    let of_error = HalfWaves::of(&error.high);
    // If the SP is constant, both are the same.
    let of_pv = if pv.high == error.high { of_error } else { HalfWaves::of(&pv.high) };
    let first = components(&pv.high, period, 1.0);
    let third = third_harmonic(&first, &components(&pv.high, period, 3.0));
    let legs = Legs::of(&pv.values, TURN * pv.span);
    let slopes = steps(&pv.high, prepared.lag(SLOPE));
    let single = steps(&pv.values, 1);
    let model = autoregression(&pv.values);
    let fine = autoregression(prepared.fine_pv.as_deref().unwrap_or_default());
    let lags = autocorrelation(&error.high, error.high.len()).unwrap_or_default();
    let values: [f64; FEATURES.len()] = [
        of_error.triangle,
        of_error.square,
        of_error.lateness,
        of_pv.relay,
        third.re,
        legs.chord(&pv.values),
        flatness(&slopes),
        plateau(&slopes),
        jump(&single),
        excess_kurtosis(&pv.high),
        excess_kurtosis(&single),
        bend_kurtosis(&pv.values, period),
        model.as_ref().map_or(f64::NAN, |m| m.ln_left()),
        model.as_ref().map_or(f64::NAN, |m| m.kurtosis()),
        fine.map_or(f64::NAN, |m| m.kurtosis()),
        Regularity::of_autocorrelation(&lags).map_or(f64::NAN, |r| 1.0 / (1.0 + 1.0 / r.index)),
    ];
    out.extend(values);
}

/// Share of the slopes below a tenth of their root mean square.
fn plateau(slopes: &[f64]) -> f64 {
    let n = slopes.len() as f64;
    let least = 0.1 * (slopes.iter().map(|s| s * s).sum::<f64>() / n).sqrt();
    slopes.iter().filter(|s| s.abs() <= least).count() as f64 / n
}

/// Share of the travel in the largest tenth of the steps.
fn jump(steps: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = steps.iter().map(|s| s.abs()).collect();
    let tenth = sizes.len() / 10;
    if tenth == 0 {
        return f64::NAN;
    }
    let all: f64 = sizes.iter().sum();
    sizes.select_nth_unstable_by(tenth - 1, |a, b| b.total_cmp(a));
    sizes[..tenth].iter().sum::<f64>() / all
}

/// Yamashita's index for levels.
fn bend_kurtosis(pv: &[f64], period: f64) -> f64 {
    let segment = of_pair(pv, pv);
    let subject = Subject::new(&segment, LoopType::Level, Some(period));
    YamashitaLevel::default().run(&subject).map_or(f64::NAN, |r| r.statistic)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plateaus_and_jumps_of_a_square_wave() {
        let square: Vec<f64> = (0..400).map(|k| f64::from(k / 20 % 2)).collect();
        let single = steps(&square, 1);
        // 19 steps of 399 move.
        assert!((plateau(&single) - 380.0 / 399.0).abs() < 1e-12);
        assert_eq!(jump(&single), 1.0);
        let ramp: Vec<f64> = (0..401).map(f64::from).collect();
        assert!((jump(&steps(&ramp, 1)) - 0.1).abs() < 1e-12);
    }
}
