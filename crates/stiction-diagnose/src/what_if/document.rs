//! What could be done, in a document.

use super::{Prediction, Retuning, Row, WhatIf};
use crate::compensate;
use crate::valve_test::TestPlan;
use schemars::JsonSchema;
use serde::Serialize;

/// A [`WhatIf`] in a document.
#[derive(Serialize, JsonSchema)]
pub(super) struct WhatIfDocument {
    /// Everything that could be done, the best first.
    actions: Vec<RowDocument>,
    /// What is recommended until the valve is repaired; null for nothing.
    interim: Option<&'static str>,
    /// What retuning costs, or why there is no other tuning.
    retuning: RetuningDocument,
    /// What to do, in sentences.
    recommendation: Vec<String>,
    /// What this rests on, in sentences.
    assumptions: Vec<String>,
    /// The test in manual that confirms it; null for a valve without friction, and where none can be made.
    confirm: Option<TestPlan>,
}

/// What becomes of the loop by an action.
#[derive(Serialize, JsonSchema)]
struct RowDocument {
    /// The action.
    action: &'static str,
    #[serde(flatten)]
    played: compensate::Row,
    /// Its rank, 1 for the best.
    rank: usize,
    /// What speaks against it, each in a few words.
    against: Vec<String>,
    /// The exact cycle of the loop that it leaves.
    cycle: Prediction,
}

/// What retuning costs.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum RetuningDocument {
    /// There is another tuning.
    Best {
        /// Its gain, percent per PV unit.
        kc: f64,
        /// Its integral time, s.
        ti_s: Option<f64>,
        /// Its `Ms`.
        ms: f64,
        /// `Ms` of the present tuning; null if the loop is not stable without friction.
        #[serde(with = "stiction_model::finite::Finite")]
        present_ms: f64,
        /// The swing of the PV over that with the present tuning; null if the latter is 0.
        swing_ratio: Option<f64>,
        /// The IAE of a load step over that with the present tuning; null if either has none.
        load_iae_ratio: Option<f64>,
    },
    /// There is none.
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
