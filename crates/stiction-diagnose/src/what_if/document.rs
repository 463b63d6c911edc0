//! The actions in a document.

use super::{Prediction, Retuning, Row, WhatIf};
use crate::compensate;
use crate::valve_test::TestPlan;
use schemars::JsonSchema;
use serde::Serialize;

/// A [`WhatIf`] in a document.
#[derive(Serialize, JsonSchema)]
pub(super) struct WhatIfDocument {
    /// All actions, the best first.
    actions: Vec<RowDocument>,
    /// The recommended action until the valve is repaired; null without a recommendation.
    interim: Option<&'static str>,
    /// Effects and cost of retuning, or why there is no other tuning.
    retuning: RetuningDocument,
    /// The recommendation, in sentences.
    recommendation: Vec<String>,
    /// The assumptions, in sentences.
    assumptions: Vec<String>,
    /// The test in manual that confirms stiction; null for a valve without friction, or if no test is possible.
    confirm: Option<TestPlan>,
}

/// The effects of an action on the loop.
#[derive(Serialize, JsonSchema)]
struct RowDocument {
    /// The action.
    action: &'static str,
    #[serde(flatten)]
    played: compensate::Row,
    /// Rank, 1 for the best.
    rank: usize,
    /// Evidence against the action, each in a few words.
    against: Vec<String>,
    /// The exact cycle of the loop after the action.
    cycle: Prediction,
}

/// Effects and cost of retuning.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum RetuningDocument {
    /// There is another tuning.
    Best {
        /// Gain, percent per PV unit.
        kc: f64,
        /// Integral time, s.
        ti_s: Option<f64>,
        /// Its `Ms`.
        ms: f64,
        /// `Ms` of the present tuning; null if the loop is not stable without friction.
        #[serde(with = "stiction_model::finite::Finite")]
        present_ms: f64,
        /// Ratio of the PV swing to the one with the present tuning; null if the latter is 0.
        swing_ratio: Option<f64>,
        /// Ratio of the IAE of a load step to the IAE with the present tuning; null if one of them has no IAE.
        load_iae_ratio: Option<f64>,
    },
    /// No other tuning exists.
    None {
        /// Why.
        none: String,
    },
}

impl From<&WhatIf> for WhatIfDocument {
    fn from(found: &WhatIf) -> Self {
        let action = |(k, row): (usize, &Row)| RowDocument {
            action: row.action.name(),
            played: row.played.clone(),
            rank: k + 1,
            against: row.against.clone(),
            cycle: row.cycle.clone(),
        };
        Self {
            actions: found.rows.iter().enumerate().map(action).collect(),
            interim: found.interim().map(|row| row.action.name()),
            retuning: RetuningDocument::from(&found.retuning),
            recommendation: found.recommendation.clone(),
            assumptions: found.assumptions.clone(),
            confirm: found.confirm.clone(),
        }
    }
}

impl From<&Result<Retuning, String>> for RetuningDocument {
    fn from(found: &Result<Retuning, String>) -> Self {
        match found {
            Ok(found) => Self::Best {
                kc: found.best.tuning.kc,
                ti_s: found.best.tuning.ti,
                ms: found.best.peak_sensitivity,
                present_ms: found.present.peak_sensitivity,
                swing_ratio: found.pv_ratio,
                load_iae_ratio: found.iae_ratio,
            },
            Err(reason) => Self::None { none: reason.clone() },
        }
    }
}
