//! What one recording says of a valve, for what is put together of several.

use super::verdict::VerdictClass;
use crate::fusion::Estimate;

/// What one recording, or one window, said of a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Observation {
    /// When, s on a clock that all observations share.
    #[cfg_attr(feature = "serde", serde(rename = "time_s"))]
    pub time: f64,
    /// The conclusion.
    pub class: VerdictClass,
    /// The probability that the valve sticks, where there is one.
    pub probability: Option<f64>,
    /// Stick band plus dead band, percent of span, where it was quantified.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, where it was quantified.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// How much it counts in the combination, such as its number of cycles; 1 for all alike.
    pub weight: f64,
    /// How many windows of a long recording it combines, by their effective number; 1 for a short one.
    pub windows: f64,
}
