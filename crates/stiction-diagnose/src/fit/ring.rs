//! Whether what was predicted of an action came.

use super::prospects::{Prospects, Remedy};
use crate::diagnose::Diagnosis;
use crate::fusion::Estimate;
use crate::series::{median, span};
use crate::spoken::rough;

/// What was predicted of an action, and what came.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Ring {
    /// The action that was predicted.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub action: Remedy,
    /// Half of the PV's peak-to-peak value before, in its units.
    pub before: f64,
    /// The same after.
    pub after: f64,
    /// What was predicted of it.
    pub predicted: Estimate,
    /// Whether it came within the predicted interval, or better.
    pub as_predicted: bool,
    /// The same in words.
    pub sentence: String,
}

/// Sets what was predicted of an action beside what was recorded after it.
///
/// The swing after is measured over the period before, so that what no longer cycles is measured as well; noise is part
/// of it, as of what was predicted.
///
/// # Errors
/// In words: if nothing was predicted of this action, or one of the recordings has no PV.
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
        .ok_or_else(|| format!("nothing was predicted of \"{}\"", action.name()))?;
    let period = before
        .oscillation()
        .and_then(|(_, found)| found.period_s)
        .ok_or("the loop did not oscillate before, so there is no swing to be less")?;
    let swing = |of: &Diagnosis| -> Option<f64> {
        let segment = of.segment()?;
        let length = ((period / segment.sample_time).round() as usize).max(3);
        let swings = segment.pv.as_deref()?.chunks_exact(length).map(span);
        let swings: Vec<f64> = swings.collect();
        (!swings.is_empty()).then(|| 0.5 * median(&swings))
    };
    let missing = |which: &str| {
        format!("the recording {which} has no PV that lasts for a period of the loop before")
    };
    let was = swing(before).ok_or_else(|| missing("before"))?;
    let is = swing(after).ok_or_else(|| missing("after"))?;
    let predicted = row.pv_swing;
    let as_predicted = is <= predicted.high;
    let sentence = format!(
        "Before: the PV swung by ±{}. Predicted for \"{}\": ±{} to ±{}. After: ±{}, {}.",
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
                "no better than before: something else swings the loop, or it was not done",
        }
    );
    Ok(Ring { action, before: was, after: is, predicted, as_predicted, sentence })
}
