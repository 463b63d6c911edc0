//! Whether the predicted effect of an action was reached.

use super::prospects::{Prospects, Remedy};
use crate::diagnose::Diagnosis;
use crate::fusion::Estimate;
use crate::series::{median, span};
use crate::spoken::rough;

/// The predicted and the recorded effect of an action.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Ring {
    /// The action.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub action: Remedy,
    /// Half of the PV's peak-to-peak value before, in its units.
    pub before: f64,
    /// The same after.
    pub after: f64,
    /// The prediction.
    pub predicted: Estimate,
    /// Whether the recorded swing is within the predicted interval, or better.
    pub as_predicted: bool,
    /// The same in words.
    pub sentence: String,
}

/// Compares the prediction for an action with a recording after it.
///
/// The swing after it is measured over the period before, so that a loop without a cycle is measured as well. It
/// includes noise, as the prediction does.
///
/// # Errors
/// In words: if there is no prediction for this action, or one of the recordings has no PV.
pub fn ring(
    prospects: &Prospects,
    action: Remedy,
    before: &Diagnosis,
    after: &Diagnosis,
) -> Result<Ring, String> {
    let row = prospects
        .actions
        .iter()
        .find(|row| row.action == action)
        .ok_or_else(|| format!("there is no prediction for \"{}\"", action.name()))?;
    let period = before
        .oscillation()
        .and_then(|(_, found)| found.period_s)
        .ok_or("the loop did not oscillate before, so no swing can fall")?;
    let swing = |of: &Diagnosis| -> Option<f64> {
        let segment = of.segment()?;
        let length = ((period / segment.sample_time).round() as usize).max(3);
        let swings = segment.pv.as_deref()?.chunks_exact(length).map(span);
        let swings: Vec<f64> = swings.collect();
        (!swings.is_empty()).then(|| 0.5 * median(&swings))
    };
    let missing = |which: &str| {
        format!(
            "the PV in the recording {which} is missing or shorter than a period of the loop before"
        )
    };
    let was = swing(before).ok_or_else(|| missing("before"))?;
    let is = swing(after).ok_or_else(|| missing("after"))?;
    let predicted = row.pv_swing;
    let as_predicted = is <= predicted.high;
    let sentence = format!(
        "PV swing before: ±{}. Predicted for \"{}\": ±{} to ±{}. After: ±{}, {}.",
        rough(was),
        action.name(),
        rough(predicted.low),
        rough(predicted.high),
        rough(is),
        match (as_predicted, is < predicted.low) {
            (true, true) => "better than predicted",
            (true, false) => "as predicted",
            (false, _) if is < 0.8 * was => "better than before, but worse than predicted",
            (false, _) =>
                "no better than before: something else causes the swing, or the action was not carried out",
        }
    );
    Ok(Ring { action, before: was, after: is, predicted, as_predicted, sentence })
}
