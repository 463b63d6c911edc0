//! The result of one recording of a valve, for combining several.

use super::verdict::{Grade, VerdictClass};
use crate::fusion::{Estimate, Pool};

/// The result of one recording or window of a valve.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Observation {
    /// Time, s on a clock that all observations share.
    #[cfg_attr(feature = "serde", serde(rename = "time_s"))]
    pub time: f64,
    /// The conclusion.
    pub class: VerdictClass,
    /// The verdict in one graded word; `None` for the word that follows from conclusion and probability.
    pub grade: Option<Grade>,
    /// The probability that the valve sticks, where there is one.
    pub probability: Option<f64>,
    /// Stick band plus dead band, percent of span, where it was quantified.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, where it was quantified.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// Weight among observations that decide by majority or have no pool, such as the number of cycles; 1 if all
    /// observations have the same weight. An observation of weight 0 does not count.
    pub weight: f64,
    /// Number of windows of a long recording in it, with overlaps counted once; 1 for a short recording.
    pub windows: f64,
    /// The combined evidence of these windows. It adds to the evidence of other observations as if all were one
    /// recording. It is `None` without a PV, or if the probability is not from the windows.
    #[cfg_attr(feature = "serde", schemars(with = "Option<String>"))]
    pub pool: Option<Pool>,
}
