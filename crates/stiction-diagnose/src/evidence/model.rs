//! How much better a sticking valve explains the PV than one that follows, as numbers.

use super::{Dense, Feature, Line};
use crate::identify::hammerstein::{self, ModelEvidence};

/// A feature of this line.
const fn feature(name: &'static str, monotone: i8, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::Model, monotone }
}

/// The features of this line, in the order of [`measure`].
pub const FEATURES: &[Feature] = &[
    feature(
        "arx_gain",
        1,
        "part of the prediction error that the best sticking valve explains, ln",
    ),
    feature("arx_gain_two_phase", 1, "part that the best two-phase valve explains, ln"),
    feature("arx_gain_he", 1, "part that the best valve by He explains, ln"),
    feature(
        "arx_information",
        1,
        "the gain of the best valve less the penalty of Schwarz's criterion, ln(1 + x)",
    ),
    feature("arx_walk_gain", 1, "the gain under a disturbance that is a random walk"),
    feature("arx_jump_gain", 0, "part that the slip jump explains, ln"),
    feature("arx_s", 0, "S of the best-fitting valve over the OP range without slow changes"),
    feature("arx_j", 0, "J of the best valve, share of S"),
    feature("arx_width", 0, "largest over smallest S with a nearly best prediction, ln"),
    feature("arx_unexplained", 0, "share of the PV that the linear process does not explain, ln"),
    feature("arx_forward", 1, "the gain less the gain in reversed time"),
    feature(
        "arx_over_placebo",
        0,
        "error of valves driven by another OP over the error of the best valve, ln",
    ),
    feature(
        "arx_over_load",
        0,
        "error with a load that jumps at the slips over the error with the best valve, ln",
    ),
    feature("oe_gain", 1, "part of the output error that the best sticking valve explains, ln"),
    feature("oe_unexplained", 0, "share of the PV that the best valve leaves as output error"),
    feature("oe_over_sensor", 0, "error with sensor play over error with the best valve, ln"),
    feature("oe_agreement", 0, "larger over smaller of S by output error and S by prediction, ln"),
    feature("error_kurtosis", 0, "kurtosis of the linear process's prediction error, ln"),
    feature("error_kurtosis_left", 0, "kurtosis of the error with the best valve, ln"),
    feature("slip_rate", 0, "slips per period"),
    feature("slip_concentration", 0, "squared linear error at slips over its mean, ln"),
    feature("slip_removed", 1, "share of the error at slips that the best valve explains"),
    feature("slip_travel_variation", -1, "relative spread of the OP travel before jumps of the PV"),
    feature(
        "slip_travel_over_time",
        1,
        "how much steadier the OP's travel before jumps is than the time between jumps, ln",
    ),
    feature("slip_jitter", -1, "scatter of the PV's jumps around the slips, periods"),
];

/// Appends one value for each of [`FEATURES`]; NaN where the value is missing.
pub fn measure(evidence: Option<&ModelEvidence>, out: &mut Vec<f64>) {
    let Some(evidence) = evidence else {
        out.extend(FEATURES.iter().map(|_| f64::NAN));
        return;
    };
    let (best, slips, output) = (evidence.best(), &evidence.slips, &evidence.output_error);
    let steadiness = |of: fn(&crate::identify::hammerstein::Steadiness) -> f64| {
        slips.steadiness.as_ref().map_or(f64::NAN, of)
    };
    // At least 1, the kurtosis of two values, so that the logarithm is finite.
    let kurtosis = |excess: f64| (excess + 3.0).max(1.0).ln();
    out.extend([
        best.gain,
        evidence.two_phase.gain,
        evidence.he.gain,
        best.information,
        evidence.walk_gain,
        best.jump_gain,
        best.s_over_span,
        best.j_over_s,
        best.width,
        evidence.linear.mse.max(1e-9).ln(),
        evidence.forward_gain - evidence.reversed_gain,
        evidence.over_placebo,
        evidence.over_load,
        output.gain(),
        output.sticky,
        output.over_sensor(),
        (output.s_over_span / best.s_over_span).ln().abs(),
        kurtosis(evidence.linear.kurtosis),
        kurtosis(evidence.kurtosis),
        slips.rate,
        slips.concentration,
        slips.removed,
        steadiness(|s| s.travel),
        steadiness(|s| s.of_travel_over_time()),
        steadiness(|s| s.jitter),
    ]);
}

/// Delays to try at the dense resolution beside one and two samples. They are short: the target is a fast process
/// in a slow record.
const DENSE_DELAYS: [f64; 4] = [3.0, 5.0, 8.0, 12.0];

/// The features at the dense resolution, in the order of [`measure_dense`]. If this resolution is not much denser, the
/// features at the resolution of the period are repeated.
pub const DENSE: &[Feature] = &[
    feature(
        "dense_arx_gain",
        1,
        "part of the sample-by-sample prediction error that the best sticking valve explains, ln",
    ),
    feature(
        "dense_arx_information",
        1,
        "the dense gain less the penalty of Schwarz's criterion, ln(1 + x)",
    ),
    feature("dense_arx_walk_gain", 1, "the dense gain under a disturbance that is a random walk"),
    feature("dense_arx_jump_gain", 0, "part of the dense gain that the slip jump explains, ln"),
    feature("dense_arx_s", 0, "S of the best valve by the dense fit, share of the OP's span"),
    feature("dense_arx_j", 0, "J of the best valve by the dense fit, share of S"),
    feature("dense_arx_width", 0, "largest over smallest S with a nearly best prediction, ln"),
    feature(
        "dense_arx_unexplained",
        0,
        "share of the PV that the linear process does not explain, ln",
    ),
    feature("dense_arx_forward", 1, "the dense gain less the dense gain in reversed time"),
    feature(
        "dense_arx_over_placebo",
        0,
        "error of valves driven by another OP over the error of the best valve, ln",
    ),
    feature(
        "dense_arx_over_load",
        0,
        "error with a load that jumps at the slips over the error with the best valve, ln",
    ),
    feature(
        "dense_oe_gain",
        1,
        "part of the output error that the best sticking valve explains, ln",
    ),
    feature("dense_oe_over_sensor", 0, "error with sensor play over error with the best valve, ln"),
    feature("dense_error_kurtosis", 0, "kurtosis of the linear process's prediction error, ln"),
    feature("dense_error_kurtosis_left", 0, "kurtosis of the error with the best valve, ln"),
    feature("dense_slip_rate", 0, "slips per period"),
    feature("dense_slip_concentration", 0, "squared dense error at slips over its mean, ln"),
    feature("dense_slip_removed", 1, "share of the error at slips that the best valve explains"),
    feature(
        "dense_slip_travel_variation",
        -1,
        "relative spread of the OP travel before jumps of the PV",
    ),
    feature(
        "dense_slip_travel_over_time",
        1,
        "how much steadier the OP's travel before jumps is than the time between jumps, ln",
    ),
];

/// Fits valves at the dense resolution.
pub(super) fn weigh_dense(dense: &Dense) -> Option<ModelEvidence> {
    let delays = DENSE_DELAYS.iter().map(|delay| (delay / dense.period).min(1.0)).collect();
    let options =
        hammerstein::HammersteinOptions { delays, ..hammerstein::HammersteinOptions::default() };
    hammerstein::weigh(&dense.op, &dense.pv, dense.period, &options).ok()
}

/// Appends one value for each of [`DENSE`]; NaN where the value is missing.
pub fn measure_dense(evidence: Option<&ModelEvidence>, out: &mut Vec<f64>) {
    let mut all = vec![];
    measure(evidence, &mut all);
    out.extend(DENSE.iter().map(|dense| {
        let name = dense.name.trim_start_matches("dense_");
        let at = FEATURES.iter().position(|feature| feature.name == name);
        at.map_or(f64::NAN, |at| all[at])
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_a_feature() {
        let mut values = vec![1.0];
        measure(None, &mut values);
        assert_eq!(values.len(), 1 + FEATURES.len());
        assert!(values[1..].iter().all(|v| v.is_nan()));
        for (i, feature) in FEATURES.iter().enumerate() {
            assert!(FEATURES[..i].iter().all(|other| other.name != feature.name));
        }
    }

    #[test]
    fn every_feature_has_its_value() {
        use crate::identify::hammerstein::{HammersteinOptions, weigh};
        let op: Vec<f64> = (0..400).map(|k| 1.4 * (0.14 * f64::from(k)).sin()).collect();
        let pv: Vec<f64> = op.iter().map(|u| u.signum()).collect();
        let mut values = vec![];
        measure(Some(&weigh(&op, &pv, 45.0, &HammersteinOptions::default()).unwrap()), &mut values);
        assert_eq!(values.len(), FEATURES.len());
    }
}
