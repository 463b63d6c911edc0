//! Whether OP and control error of a segment oscillate.

use crate::methods::Subject;
use crate::oscillation::{self, Oscillation};
use crate::recording::{LoopType, Segment};

/// The oscillations of a loop.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Oscillations {
    /// That of the control error, or of the PV where there is no set point; `None` without a PV.
    pub error: Option<Oscillation>,
    /// That of the OP; `None` without a segment.
    pub op: Option<Oscillation>,
}

impl Oscillations {
    /// Those of a segment.
    pub(super) fn of(segment: &Segment) -> Self {
        let error =
            Subject::new(segment, LoopType::Unknown, None).error().map(|e| e.values.clone());
        let analyse =
            |signal: &[f64]| oscillation::analyse(signal, segment.sample_time).since(segment.from);
        Self { error: error.as_deref().map(analyse), op: Some(analyse(&segment.op)) }
    }

    /// The dominant oscillation and its signal. The error has precedence if it oscillates, then the OP if it
    /// oscillates, then the error, if recorded.
    pub fn dominant(&self) -> Option<(&'static str, &Oscillation)> {
        let error = self.error.as_ref().map(|found| ("error", found));
        let op = self.op.as_ref().map(|found| ("OP", found));
        [error, op].into_iter().flatten().find(|(_, o)| o.found).or(error).or(op)
    }

    /// The period of the dominant one if it was found, in samples.
    pub(super) fn period(&self, segment: &Segment) -> Option<f64> {
        let (_, oscillation) = self.dominant().filter(|(_, oscillation)| oscillation.found)?;
        Some(oscillation.period_s? / segment.sample_time)
    }
}

/// Whether and how a signal oscillates. Times are in s from the first sample, or in a diagnosis in s on the recording's
/// clock.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
#[schemars(rename = "Oscillation")]
pub(super) struct Dominant<'a> {
    /// The signal it was found in: `error` or `OP`.
    signal: &'static str,
    #[serde(flatten)]
    found: &'a Oscillation,
}

#[cfg(feature = "serde")]
pub(super) fn dominant<S: serde::Serializer>(
    oscillations: &Oscillations,
    to: S,
) -> std::result::Result<S::Ok, S::Error> {
    let dominant = oscillations.dominant().map(|(signal, found)| Dominant { signal, found });
    serde::Serialize::serialize(&dominant, to)
}
