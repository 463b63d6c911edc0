//! The result of one recording of a valve, for combining several.

use super::verdict::{Grade, VerdictClass};
use crate::fusion::Estimate;

/// The result of one recording or window of a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Observation {
    /// Time, s on a clock that all observations share.
    #[cfg_attr(feature = "serde", serde(rename = "time_s"))]
    pub time: f64,
    /// The conclusion.
    pub class: VerdictClass,
    /// The verdict in one graded word; `None` for that of the conclusion and the probability.
    pub grade: Option<Grade>,
    /// The probability that the valve sticks, where there is one.
    pub probability: Option<f64>,
    /// Stick band plus dead band, percent of span, where it was quantified.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, where it was quantified.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// Weight in the combination, such as its number of cycles; 1 if all are alike.
    pub weight: f64,
    /// Number of windows of a long recording in it, what overlaps counted once; 1 for a short one.
    pub windows: f64,
    /// Mean over these windows of the log-odds of sticking above 0, with which they are combined as if they were of one
    /// recording; `None` for windows that are taken to be alike.
    #[cfg_attr(feature = "serde", serde(rename = "log_odds_above"))]
    pub above: Option<f64>,
}
