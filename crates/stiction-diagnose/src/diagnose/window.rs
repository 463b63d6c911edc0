//! What one window of a segment says.

#[cfg(feature = "serde")]
use super::verdict::Limit;
use crate::fusion::Estimate;

/// What one window of a segment says.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Window {
    /// Time of its first sample, s on the recording's clock.
    #[cfg_attr(feature = "serde", serde(rename = "from_s"))]
    pub from: f64,
    /// Its duration, s.
    #[cfg_attr(feature = "serde", serde(rename = "duration_s"))]
    pub duration: f64,
    /// The probability that the valve sticks.
    pub probability: f64,
    /// Stick band plus dead band, percent of span, where it could be quantified.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, where it could be quantified.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// Had the valve stuck by more, percent of span, this window would have shown it, with 95 %.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "S_below", serialize_with = "Limit::of_evidence"),
        schemars(with = "Option<Limit>")
    )]
    pub limit: Option<f64>,
}
