//! The information of a window about S, as numbers: see [`crate::identify::information`].

use super::{Feature, Line};
use crate::identify::information::{At, Information, STEPS, information};

/// A feature of this line.
const fn feature(name: &'static str, monotone: i8, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::Model, monotone }
}

/// The scalars of a whole window.
const OF_ALL: usize = 9;

/// The scalars of stems beside the OP.
const BESIDE: usize = 20;

/// The features of this line, in the order of [`measure`]. The features of the whole window come first, then one of
/// each sort for every S of the grid.
pub const FEATURES: [Feature; OF_ALL + 5 * STEPS + BESIDE] = [
    feature(
        "info_z",
        1,
        "largest advantage of a sticking valve in predicting the PV, standard errors",
    ),
    feature("info_z_s", 0, "S of the largest advantage, share of the OP's range, ln"),
    feature("info_gain", 1, "largest gain in log-likelihood by a sticking valve, nats, ln(1 + x)"),
    feature("info_gain_s", 0, "S of the largest gain, share of the OP's span, ln"),
    feature("info_power", 0, "expected gain if the valve sticks with this S, nats, ln(1 + x)"),
    feature("info_range", 0, "range of the OP over the span of the OP, ln"),
    feature("info_independent", 0, "independent samples, ln"),
    feature(
        "info_autocorrelation",
        0,
        "correlation of successive prediction errors if the valve follows the OP",
    ),
    feature(
        "info_unexplained",
        0,
        "share of the PV, given its past, that the OP does not explain, ln",
    ),
    feature("info_z_1", 0, "standard errors in favour of an S of 0.015 of the OP's range"),
    feature("info_z_2", 0, "standard errors in favour of an S of 0.027 of the OP's range"),
    feature("info_z_3", 0, "standard errors in favour of an S of 0.05 of the OP's range"),
    feature("info_z_4", 0, "standard errors in favour of an S of 0.09 of the OP's range"),
    feature("info_z_5", 0, "standard errors in favour of an S of 0.16 of the OP's range"),
    feature("info_z_6", 0, "standard errors in favour of an S of 0.3 of the OP's range"),
    feature("info_z_7", 0, "standard errors in favour of an S of 0.54 of the OP's range"),
    feature("info_z_8", 0, "standard errors in favour of an S of 0.99 of the OP's range"),
    feature("info_z_9", 0, "standard errors in favour of an S of 1.8 of the OP's range"),
    feature(
        "info_gain_1",
        0,
        "nats in favour of an S of 0.015 of the OP's range, signed ln(1 + x)",
    ),
    feature("info_gain_2", 0, "nats in favour of an S of 0.027 of the OP's range"),
    feature("info_gain_3", 0, "nats in favour of an S of 0.05 of the OP's range"),
    feature("info_gain_4", 0, "nats in favour of an S of 0.09 of the OP's range"),
    feature("info_gain_5", 0, "nats in favour of an S of 0.16 of the OP's range"),
    feature("info_gain_6", 0, "nats in favour of an S of 0.3 of the OP's range"),
    feature("info_gain_7", 0, "nats in favour of an S of 0.54 of the OP's range"),
    feature("info_gain_8", 0, "nats in favour of an S of 0.99 of the OP's range"),
    feature("info_gain_9", 0, "nats in favour of an S of 1.8 of the OP's range"),
    feature("info_power_1", 0, "expected gain if S is 0.015 of the OP's range, nats, ln(1 + x)"),
    feature("info_power_2", 0, "expected gain if S is 0.027 of the OP's range"),
    feature("info_power_3", 0, "expected gain if S is 0.05 of the OP's range"),
    feature("info_power_4", 0, "expected gain if S is 0.09 of the OP's range"),
    feature("info_power_5", 0, "expected gain if S is 0.16 of the OP's range"),
    feature("info_power_6", 0, "expected gain if S is 0.3 of the OP's range"),
    feature("info_power_7", 0, "expected gain if S is 0.54 of the OP's range"),
    feature("info_power_8", 0, "expected gain if S is 0.99 of the OP's range"),
    feature("info_power_9", 0, "expected gain if S is 1.8 of the OP's range"),
    feature("stem_gain", 1, "nats that the best stem adds to the OP, ln(1 + x)"),
    feature("stem_robust", 1, "nats that the best stem adds, outliers limited, signed ln(1 + x)"),
    feature("stem_z", 1, "standard errors of the gain by the best stem"),
    feature("stem_s", 0, "S of the best-fitting stem over the OP range without slow changes, ln"),
    feature("stem_j", 0, "J of the best stem, share of S"),
    feature("stem_slips", 0, "slips of the best stem, ln(1 + x)"),
    feature("stem_share", 0, "share of the PV's lasting response that comes from the best stem"),
    feature(
        "stem_evidence",
        1,
        "log marginal likelihood of a stem beside the OP, signed ln(1 + x)",
    ),
    feature("stem_placebo", 0, "nats that the best stem in reversed time adds, ln(1 + x)"),
    feature(
        "stem_over_placebo",
        1,
        "nats that the best stem adds beyond the best stem in reversed time, signed ln(1 + x)",
    ),
    feature("stem_curve", 0, "nats that the squared OP adds to the OP, ln(1 + x)"),
    feature(
        "stem_beyond_curve",
        1,
        "nats that the best stem adds beside the squared OP, ln(1 + x)",
    ),
    feature(
        "stem_over_rival",
        1,
        "smaller of the best stem's gains over reversed time and over the squared OP, signed ln(1 + x)",
    ),
    feature("stem_gain_share", 0, "nats per sample that the best stem adds, ln"),
    feature("stem_lacks", 0, "nats that the OP adds to the best stem, ln(1 + x)"),
    feature(
        "stem_s_mean",
        0,
        "mean of ln S by the likelihood of all stems, S as a share of the OP's span",
    ),
    feature("stem_s_spread", 0, "standard deviation of ln S by the likelihood of all stems"),
    feature("stem_j_mean", 0, "mean of J over S by the likelihood of all stems"),
    feature("stem_j_spread", 0, "standard deviation of J over S by the likelihood of all stems"),
    feature(
        "stem_least_half",
        1,
        "nats that the best stem adds in the half of the record with the smaller gain, outliers limited, signed ln(1 + x)",
    ),
    feature("stem_gain_1", 0, "nats that a stem with S of 0.015 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_2", 0, "nats that a stem with S of 0.027 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_3", 0, "nats that a stem with S of 0.05 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_4", 0, "nats that a stem with S of 0.09 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_5", 0, "nats that a stem with S of 0.16 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_6", 0, "nats that a stem with S of 0.3 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_7", 0, "nats that a stem with S of 0.54 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_8", 0, "nats that a stem with S of 0.99 of the OP's range adds, ln(1 + x)"),
    feature("stem_gain_9", 0, "nats that a stem with S of 1.8 of the OP's range adds, ln(1 + x)"),
    feature(
        "stem_refuted_1",
        0,
        "nats that the OP adds to any stem with S of 0.015 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_2",
        0,
        "nats that the OP adds to any stem with S of 0.027 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_3",
        0,
        "nats that the OP adds to any stem with S of 0.05 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_4",
        0,
        "nats that the OP adds to any stem with S of 0.09 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_5",
        0,
        "nats that the OP adds to any stem with S of 0.16 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_6",
        0,
        "nats that the OP adds to any stem with S of 0.3 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_7",
        0,
        "nats that the OP adds to any stem with S of 0.54 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_8",
        0,
        "nats that the OP adds to any stem with S of 0.99 of the OP's range, ln(1 + x)",
    ),
    feature(
        "stem_refuted_9",
        0,
        "nats that the OP adds to any stem with S of 1.8 of the OP's range, ln(1 + x)",
    ),
];

/// The information of a window of OP and PV; `None` if there is too little.
pub(super) fn of(op: &[f64], pv: &[f64], period: f64) -> Option<Information> {
    information(op, pv, Some(period)).ok()
}

/// Appends one value for each of [`FEATURES`]; NaN where the value is missing. `op_span` is the span of the OP,
/// percent.
pub fn measure(information: Option<&Information>, op_span: f64, out: &mut Vec<f64>) {
    let Some(told) = information else {
        out.extend(FEATURES.iter().map(|_| f64::NAN));
        return;
    };
    let signed = |nats: f64| nats.signum() * nats.abs().ln_1p();
    let At { s, gain, power, .. } = told.refined;
    let range = (told.op_range / op_span).ln();
    out.extend([
        told.z(),
        told.best_at().s.ln(),
        signed(gain),
        s.ln() + range,
        signed(power),
        range,
        told.independent.ln(),
        told.autocorrelation,
        told.unexplained.max(1e-9).ln(),
    ]);
    out.extend(told.profile.iter().map(|at| at.z));
    out.extend(told.profile.iter().map(|at| signed(at.gain)));
    out.extend(told.profile.iter().map(|at| signed(at.power)));
    let stem = &told.added_stem;
    let (_, s, j, slips) = stem.best;
    out.extend([
        signed(stem.gain),
        signed(stem.robust),
        stem.z,
        s.ln() + range,
        j,
        (slips as f64).ln_1p(),
        stem.share,
        signed(stem.evidence),
        signed(stem.placebo),
        signed(stem.gain - stem.placebo),
        signed(stem.curve),
        signed(stem.beyond_curve),
        signed((stem.gain - stem.placebo).min(stem.beyond_curve)),
        ((stem.gain + 0.1) / told.independent).ln(),
        signed(stem.lacks),
        stem.ln_s[0] + range,
        stem.ln_s[1].max(1e-3).ln(),
        stem.j_over_s[0],
        stem.j_over_s[1],
        signed(stem.least_half),
    ]);
    out.extend(stem.profile.iter().map(|gain| signed(*gain)));
    out.extend(stem.refuted.iter().map(|nats| signed(*nats)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_a_feature() {
        let mut values = vec![];
        measure(None, 1.0, &mut values);
        assert!(values.len() == FEATURES.len() && values.iter().all(|v| v.is_nan()));
        let op: Vec<f64> = (0..400).map(|k| 50.0 + (0.14 * f64::from(k)).sin()).collect();
        let pv: Vec<f64> = op.iter().map(|u| (u - 50.0).signum()).collect();
        let told = of(&op, &pv, 45.0).unwrap();
        let mut values = vec![];
        measure(Some(&told), 2.0, &mut values);
        assert!(values.len() == FEATURES.len() && values.iter().all(|v| v.is_finite()));
        // The grid that the names tell of.
        let grid = crate::identify::information::grid().map(|s| format!("{s:.2}"));
        assert_eq!(grid[1..].join(" "), "0.03 0.05 0.09 0.16 0.30 0.54 0.99 1.80");
    }
}
