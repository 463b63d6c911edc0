//! Whether the predicted effect of an action was reached.

use super::prospects::{Prospects, Remedy, recorded_cycle};
use super::{Fit, Swing};
use crate::fusion::Estimate;
use crate::oscillation::swing;
use crate::recording::Segment;
use crate::spoken::rough;

/// The predicted and the recorded effect of an action.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Ring {
    /// The action.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub action: Remedy,
    /// The [`swing()`] of the PV before, in its units.
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

/// Compares the prediction for an action on a fitted loop with a segment recorded after it.
///
/// Both swings are measured over the period before, so that a loop without a cycle is measured as well.
///
/// # Errors
/// In words: if there is no prediction for this action, nothing oscillated before, or the PV is missing or shorter
/// than a period.
pub fn ring(
    prospects: &Prospects,
    action: Remedy,
    fit: &Fit,
    after: &Segment,
) -> Result<Ring, String> {
    let row = prospects
        .actions
        .iter()
        .find(|row| row.action == action)
        .ok_or_else(|| format!("there is no prediction for \"{}\"", action.name()))?;
    let Swing { period_s, pv: was, .. } = recorded_cycle(fit)
        .ok_or("the loop did not oscillate before, so there is no swing to compare")?;
    let is = after.deviation().and_then(|pv| swing(&pv, period_s / after.sample_time)).ok_or(
        "the PV after the action is missing or shorter than one period of the earlier swing",
    )?;
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
                "no better than before, so something else causes the swing, or the action was not carried out",
        }
    );
    Ok(Ring { action, before: was, after: is, predicted, as_predicted, sentence })
}
