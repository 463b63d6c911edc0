//! Circumstances of the loop: set point, limits, resolution, record length, controller.

use super::prepared::{Prepared, dominant_period};
use super::regression::Regression;
use super::turns::spread;
use super::{Feature, Line};
use crate::recording::fitness::{compression_factor, share_at_limit};
use crate::series::{correlation, max, min, std, variance};

const fn feature(name: &'static str, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::Circumstances, monotone: 0 }
}

/// Features that need the OP only.
pub const OF_OP: [Feature; 9] = [
    feature("cycles", "periods in the window, logarithm"),
    feature("samples_per_period", "recorded samples per period, logarithm"),
    feature("samples", "recorded samples, logarithm"),
    feature("op_at_limit", "share of the time in which the OP rests at a limit"),
    feature("op_levels", "number of OP values, log scale: 0 for one, 1 for as many as samples"),
    feature("op_still", "share of the samples at which the OP does not move"),
    feature("op_lines", "samples per straight line of the OP, logarithm; 0 without compression"),
    feature("op_unsteady", "relative spread of the OP's standard deviation from period to period"),
    feature("op_slow", "share of the OP's variance that is slower than two periods"),
];

/// Features that need more signals.
pub const OF_LOOP: [Feature; 10] = [
    feature("pv_levels", "number of PV values, log scale: 0 for one, 1 for as many as samples"),
    feature("pv_still", "share of the samples at which the PV does not move"),
    feature("pv_lines", "samples per straight line of the PV, logarithm; 0 without compression"),
    feature("period_mismatch", "longer over shorter period of OP and control error, logarithm"),
    feature("sp_known", "1 if the SP is recorded"),
    feature("sp_moves", "share of the samples at which the SP moves"),
    feature("sp_explains", "share of the PV's variance that the SP explains"),
    feature(
        "controller_misfit",
        "share of the OP's moves that no PI law of the error explains, logarithm",
    ),
    feature("controller_kurtosis", "excess kurtosis of what the best PI law does not explain"),
    feature("controller_action", "best PI law: 0 only integral action, 1 only proportional action"),
];

/// Measures the features that need the OP only.
pub fn measure_op(prepared: &Prepared<'_>, out: &mut Vec<f64>) {
    let op = &prepared.segment.op;
    let values: [f64; OF_OP.len()] = [
        prepared.cycles().ln(),
        (prepared.period * prepared.factor as f64).ln(),
        (op.len() as f64).ln(),
        share_at_limit(op),
        levels(op),
        still(op),
        lines(op),
        unsteadiness(&prepared.op.high, prepared.lag(1.0)),
        (1.0 - variance(&prepared.op.high)).max(0.0),
    ];
    out.extend(values);
}

/// Measures the features that need more signals.
pub fn measure_loop(prepared: &Prepared<'_>, out: &mut Vec<f64>) {
    let segment = prepared.segment;
    let Some(pv) = &segment.pv else {
        out.extend([f64::NAN; OF_LOOP.len()]);
        return;
    };
    let n = segment.len();
    let mismatch = prepared.error_spectrum.as_ref().and_then(|error| {
        let (of_op, of_error) =
            (dominant_period(n, &[&prepared.op_spectrum])?, dominant_period(n, &[error])?);
        Some((of_op / of_error).ln().abs())
    });
    let sp = segment.sp.as_deref();
    let sp_explains = sp.and_then(|sp| correlation(sp, pv)).map_or(0.0, |r| r * r);
    let controller = Controller::of(prepared);
    let values: [f64; OF_LOOP.len()] = [
        levels(pv),
        still(pv),
        lines(pv),
        mismatch.unwrap_or(f64::NAN),
        f64::from(sp.is_some()),
        sp.map_or(f64::NAN, |sp| 1.0 - still(sp)),
        if sp.is_some() { sp_explains } else { f64::NAN },
        controller.misfit,
        controller.kurtosis,
        controller.action,
    ];
    out.extend(values);
}

/// Logarithm of the ratio of the number of different values to the number of samples.
fn levels(x: &[f64]) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    // Differences by rounding count as one level.
    let least = 1e-9 * (max(x) - min(x));
    let levels = 1 + sorted.windows(2).filter(|pair| pair[1] - pair[0] > least).count();
    (levels as f64).ln() / (x.len() as f64).ln()
}

/// Share of the steps without a change.
fn still(x: &[f64]) -> f64 {
    x.windows(2).filter(|pair| pair[0] == pair[1]).count() as f64 / (x.len() - 1) as f64
}

/// Logarithm of the samples on one straight line.
fn lines(x: &[f64]) -> f64 {
    compression_factor(x).map_or(f64::NAN, f64::ln)
}

/// Relative spread of the standard deviations of blocks.
fn unsteadiness(x: &[f64], block: usize) -> f64 {
    spread(&x.chunks_exact(block).map(std).collect::<Vec<_>>())
}

/// The PI law that explains the OP best: `dOP = a de + b e + c`. In closed loop it holds for any cause of an
/// oscillation. Dead zones, limits and unrecorded set points break it.
struct Controller {
    misfit: f64,
    kurtosis: f64,
    action: f64,
}

impl Controller {
    fn of(prepared: &Prepared<'_>) -> Self {
        let none = Self { misfit: f64::NAN, kurtosis: f64::NAN, action: f64::NAN };
        let Some(error) = &prepared.error else { return none };
        let (u, e) = (&prepared.op.values, &error.values);
        let moves: Vec<f64> = u.windows(2).map(|w| w[1] - w[0]).collect();
        let of_error = |k: usize| [1.0, e[k + 1] - e[k], 0.5 * (e[k + 1] + e[k])];
        let Some(law) = Regression::of(&moves, 0, of_error) else { return none };
        let typical =
            |i: usize| std(&(0..moves.len()).map(|k| of_error(k)[i]).collect::<Vec<f64>>());
        // The valve raises the PV of this error, so both actions lower the OP.
        let (proportional, integral) =
            (-law.coefficients[1] * typical(1), -law.coefficients[2] * typical(2));
        Self {
            misfit: law.ln_left(),
            kurtosis: law.kurtosis(),
            action: proportional.atan2(integral) / std::f64::consts::FRAC_PI_2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resolution_in_closed_form() {
        let stairs: Vec<f64> = (0..100).map(|k| f64::from(k / 10)).collect();
        assert!((levels(&stairs) - 0.5).abs() < 1e-12);
        assert_eq!(still(&stairs), 90.0 / 99.0);
        assert!(unsteadiness(&[1.0; 100], 10).is_nan());
        let wave: Vec<f64> = (0..100).map(|k| f64::from(k % 2)).collect();
        assert_eq!(unsteadiness(&wave, 10), 0.0);
    }
}
