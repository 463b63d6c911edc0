//! The result of one recording of a valve, for combining several.

use super::verdict::{Grade, VerdictClass};
use crate::fusion::{Estimate, Pool};

/// The result of one recording or one window of a valve.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Observation {
    /// Time, s on a clock that all observations share.
    #[cfg_attr(feature = "serde", serde(rename = "time_s"))]
    pub time: f64,
    /// The conclusion.
    pub class: VerdictClass,
    /// The grade of the verdict; `None` for the grade that follows from conclusion and probability.
    pub grade: Option<Grade>,
    /// The probability that the valve sticks; `None` if unknown.
    pub probability: Option<f64>,
    /// Stick band plus dead band, percent of span; `None` if unknown.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span; `None` if unknown.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// Weight of an observation, such as the number of cycles, if the majority decides or no observation has a pool. An
    /// observation of weight 0 does not count.
    pub weight: f64,
    /// Number of windows in the observation, with overlaps counted once; 1 for a short recording.
    pub windows: f64,
    /// The combined evidence of the windows, which adds to the evidence of other observations as if all were one
    /// recording. `None` without a PV, or if the probability is not from the windows.
    #[cfg_attr(feature = "serde", schemars(with = "Option<String>"))]
    pub pool: Option<Pool>,
}
