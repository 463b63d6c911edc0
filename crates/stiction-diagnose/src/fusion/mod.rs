//! The frozen model from evidence to probabilities and intervals.
//!
//! A [`Bundle`] contains sums of trees that were trained on simulated loops by the crate `stiction-train`; its
//! model card lists the loops and the accuracy. It also contains their [calibration](Calibration) and the
//! [shifts](Quantiles) of their intervals. [`shipped`] is the bundle in the library. [`Bundle::weigh`] applies it:
//!
//! ```text
//! features ──> fault (boosted trees, monotone) ──> calibration ──> confidence ──> P(fault)
//!          ├─> no response, given a fault       ──> P(sticks), P(no response)
//!          ├─> other causes, given none         ──> softmax ──> their probabilities
//!          ├─> quantiles of ln(S / OP span), of J/S, given that it sticks ──> 90 % intervals
//!          ├─> 95 % quantile of ln(S / OP span), of all valves ──> detection limit
//!          ├─> reference ──> distance from the training loops
//!          └─> mismatch ──> whether OP and PV are those of one loop
//! ```
//!
//! Its results hold on loops like the simulated ones. The [confidence](Confidence) is limited to that confirmed on
//! kinds of loops left out of training. Training used no real recording.

mod bundle;
mod bytes;
mod calibration;
mod confidence;
mod decision;
mod limit;
mod mismatch;
mod packed;
mod pool;
mod quantiles;
mod reference;
pub mod shift;
mod trees;
mod valves;

pub use crate::cause::Cause;
pub use crate::estimate::Estimate;
pub use bundle::{Bundle, Deferred, Provenance, TrainedModel};
pub use calibration::{Calibration, sigmoid, softplus};
pub use confidence::{Confidence, SURE, Side, logit};
pub use decision::Decision;
pub use limit::{LIMIT, Limit};
pub use mismatch::Mismatch;
pub use pool::{Pool, SUMMARY};
pub use quantiles::{COVERAGE, Quantiles};
pub use reference::{QUANTILES, Reference, Spread, Unlike, level};
pub use trees::{Ensemble, MOST_FEATURES, Node, row};
pub use valves::{Together, Valves};

use crate::error::{Error, Result};
use crate::evidence::{Line, features};
use std::sync::OnceLock;

/// The result of a bundle for evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighed {
    /// The probability of a fault of the valve: that it sticks, or does not respond.
    pub probability: f64,
    /// The probability of a fault from each line of evidence alone.
    pub lines: Vec<(Line, f64)>,
    /// The probability of every cause, in the order of [`Cause::ALL`]. All probabilities add up to one. The
    /// probabilities of [`Cause::StickingValve`] and [`Cause::NoResponse`] add up to `probability`.
    pub causes: [(Cause, f64); Cause::ALL.len()],
    /// Stick band plus dead band if the valve sticks, percent of span, and its 90 % interval.
    pub s: Estimate,
    /// Slip jump over S if the valve sticks, and its 90 % interval.
    pub j_over_s: Estimate,
    /// The detection limit, percent of span: of valves at fault at most 5 % have a larger S. `None` if it is more
    /// than three spans of the OP, or for the OP alone.
    pub limit: Option<f64>,
    /// Distance of the recording from the training loops. Above 1 the recording is unlike all training loops, and the
    /// other results are unreliable. 0 for a model without this measure.
    pub distance: f64,
    /// Whether OP and PV look like signals of one loop: above 1 they do not, see [`Mismatch::odds`]. 0 for a model
    /// without this measure.
    pub mismatch: f64,
}

impl Weighed {
    /// The probability of a cause.
    pub fn of(&self, cause: Cause) -> f64 {
        self.causes.iter().find(|(each, _)| *each == cause).map_or(0.0, |(_, p)| *p)
    }
}

/// The bundle in the library, read once.
///
/// # Errors
/// If the bundle was trained on different [`features`], for example after a change of the evidence and before the next
/// training.
pub fn shipped() -> Result<&'static Bundle> {
    static SHIPPED: OnceLock<Result<Bundle>> = OnceLock::new();
    let read = || {
        let bundle = Bundle::from_bytes(include_bytes!("../../model/verdict.bin"))?;
        bundle.check(features().map(|feature| feature.name))?;
        Ok(bundle)
    };
    SHIPPED.get_or_init(read).as_ref().map_err(Clone::clone)
}

impl Bundle {
    /// Applies the bundle to the values of the features, NaN where one could not be measured; `op_span` is the
    /// [span of the OP](crate::evidence::Evidence::op_span), percent.
    ///
    /// With `op_only`, the model of the OP alone is used, which has no feature of the PV. It was trained on
    /// recordings without PV and SP, and needs the evidence of such a recording.
    ///
    /// # Errors
    /// If there are fewer values than features, the span is not a finite number above 0, or the model of the OP alone
    /// is damaged.
    pub fn weigh(&self, values: &[f64], op_span: f64, op_only: bool) -> Result<Weighed> {
        if values.len() < self.features.len() {
            return Err(Error::Length {
                name: "the evidence",
                found: values.len(),
                expected: self.features.len(),
            });
        }
        crate::error::positive("the span of the OP", op_span)?;
        let model = if op_only { self.op_only.get()? } else { &self.full };
        let row = row(values);
        let calibrated = model.calibration.probability(model.fault.margin(&row));
        let probability = model.confidence.reported(calibrated);
        let lines = model
            .lines
            .iter()
            .map(|(line, trees, calibration)| (*line, calibration.probability(trees.margin(&row))));
        let lines = lines.collect();
        let no_response = sigmoid(model.no_response.margin(&row));
        let margins: Vec<f64> = model.causes.iter().map(|(_, trees)| trees.margin(&row)).collect();
        let largest = margins.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total: f64 = margins.iter().map(|margin| (margin - largest).exp()).sum();
        let share = |cause: Cause| match cause {
            Cause::StickingValve => probability * (1.0 - no_response),
            Cause::NoResponse => probability * no_response,
            // A model without other causes only knows that it is none of the faults.
            Cause::NormalOperation if margins.is_empty() => 1.0 - probability,
            _ => {
                let same =
                    model.causes.iter().zip(&margins).filter(|((each, _), _)| *each == cause);
                let weight: f64 = same.map(|(_, margin)| (margin - largest).exp()).sum();
                if weight > 0.0 { (1.0 - probability) * weight / total } else { 0.0 }
            }
        };
        let percent = |ln_ratio: f64| op_span * ln_ratio.exp();
        let ln_s = model.s.estimate(&row);
        let j_over_s = model.j_over_s.estimate(&row);
        Ok(Weighed {
            probability,
            lines,
            causes: Cause::ALL.map(|cause| (cause, share(cause))),
            s: ln_s.map(percent),
            j_over_s: j_over_s.map(|ratio| ratio.max(0.0)),
            limit: model
                .limit
                .as_ref()
                .and_then(|limit| limit.spans(&row, probability))
                .map(|spans| op_span * spans),
            distance: model.reference.as_ref().map_or(0.0, |known| known.distance(&row)),
            mismatch: model.mismatch.as_ref().map_or(0.0, |known| known.odds(&row)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bundle::tests::bundle;

    #[test]
    fn causes_add_up_to_one() {
        for values in [[-1.0, -1.0], [1.0, 1.0], [f64::NAN, 0.5], [0.5, f64::NAN]] {
            for op_only in [false, true] {
                let weighed = bundle().weigh(&values, 10.0, op_only).unwrap();
                let total: f64 = weighed.causes.iter().map(|(_, p)| p).sum();
                assert!((total - 1.0).abs() < 1e-12, "{total}");
                let faults = weighed.of(Cause::StickingValve) + weighed.of(Cause::NoResponse);
                assert!((faults - weighed.probability).abs() < 1e-12);
                assert!(weighed.causes.iter().all(|(_, p)| (0.0..=1.0).contains(p)));
            }
        }
    }

    #[test]
    fn values_become_percent_of_span() {
        let weighed = bundle().weigh(&[1.0, 1.0], 10.0, false).unwrap();
        // Median ln(S / span) -0.25, ends half a unit away: just as wide as the first class reaches.
        let expected = [-0.25, -0.75, 0.25].map(|x: f64| 10.0 * x.exp());
        for (found, expected) in
            [weighed.s.value, weighed.s.low, weighed.s.high].iter().zip(expected)
        {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        // The same in another unit of the OP.
        let doubled = bundle().weigh(&[1.0, 1.0], 20.0, false).unwrap();
        assert!((doubled.s.value - 2.0 * weighed.s.value).abs() < 1e-12);
        assert_eq!(doubled.j_over_s, weighed.j_over_s);
    }

    /// Fails after a change of the evidence, until the model is trained again.
    #[test]
    fn the_shipped_bundle_is_of_todays_features() {
        let bundle = shipped().unwrap();
        assert!(bundle.features.len() <= features().count());
        let weighed = bundle.weigh(&vec![f64::NAN; bundle.features.len()], 10.0, true).unwrap();
        assert!(weighed.probability > 0.0 && weighed.probability < 1.0);
        assert!(weighed.s.low > 0.0 && weighed.s.low <= weighed.s.value);
        assert!(weighed.s.value <= weighed.s.high && weighed.s.high.is_finite());
    }

    #[test]
    fn limits_and_distances_are_reported() {
        let of = |values: [f64; 2], op_only| bundle().weigh(&values, 10.0, op_only).unwrap();
        let small = of([1.0, 0.0], false);
        assert!((small.limit.unwrap() - 10.0 * (-0.25f64).exp()).abs() < 1e-12);
        assert!(small.distance < 1.0 && of([1.0, -60.0], false).distance > 1.0);
        // Beyond three spans of the OP, and with the OP alone, there is no limit.
        assert_eq!((of([-1.0, 0.0], false).limit, of([1.0, 0.0], true).limit), (None, None));
    }

    #[test]
    fn mistakes_are_reported_of_op_and_pv_only() {
        let of =
            |second: f64, op_only| bundle().weigh(&[0.5, second], 10.0, op_only).unwrap().mismatch;
        assert!(of(-1.0, false) < 1.0 && of(1.0, false) > 1.0);
        assert_eq!(of(1.0, true), 0.0);
    }

    #[test]
    fn what_cannot_be_weighed_is_refused() {
        assert!(bundle().weigh(&[1.0], 10.0, false).is_err());
        assert!(bundle().weigh(&[1.0, 1.0], 0.0, false).is_err());
        assert!(bundle().weigh(&[1.0, 1.0], f64::NAN, false).is_err());
    }
}
