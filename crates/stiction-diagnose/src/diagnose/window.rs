//! The result of one window of a segment.

use super::by_evidence::thresholds;
use super::observation::Observation;
#[cfg(feature = "serde")]
use super::verdict::Limit;
use super::verdict::VerdictClass;
use crate::fusion::Estimate;

/// The result of one window of a segment.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Window {
    /// Time of the first sample of the window, s on the recording's clock.
    #[cfg_attr(feature = "serde", serde(rename = "from_s"))]
    pub from: f64,
    /// Duration, s.
    #[cfg_attr(feature = "serde", serde(rename = "duration_s"))]
    pub duration: f64,
    /// The probability that the valve sticks.
    pub probability: f64,
    /// Stick band plus dead band, percent of span; `None` if S could not be quantified.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span; `None` if J could not be quantified.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// The detection limit (95 %), percent of span: a larger S would have been visible in this window.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "S_below", serialize_with = "Limit::of_evidence"),
        schemars(with = "Option<Limit>")
    )]
    pub limit: Option<f64>,
}

impl Window {
    /// The observation as a separate recording, without a pool.
    pub(super) fn observation(&self) -> Observation {
        let limits = thresholds();
        let class = match self.probability {
            p if p >= limits.accuse => VerdictClass::Sticks,
            p if p <= limits.clear => VerdictClass::DoesNotStick,
            _ => VerdictClass::CannotTell,
        };
        Observation {
            time: self.from,
            class,
            grade: None,
            probability: Some(self.probability),
            s: self.s,
            j: self.j,
            weight: 1.0,
            windows: 1.0,
            pool: None,
        }
    }
}
