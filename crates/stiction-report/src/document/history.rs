//! The history of valves as a document for programs.

use super::{Estimate, Source, VERSION, finite};
use schemars::JsonSchema;
use serde::Serialize;
use stiction_diagnose::diagnose;

/// The histories of some valves.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ValveHistory {
    /// The program that made it, with its version.
    pub tool: String,
    /// Version of this form.
    pub version: u32,
    /// The valves, in the order of their first appearance.
    pub valves: Vec<Valve>,
}

/// The history of one valve.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Valve {
    /// Tag of its loop.
    #[serde(rename = "loop")]
    pub name: String,
    /// The files it was recorded in.
    pub sources: Vec<Source>,
    /// Whether the times count from 1970-01-01 UTC; else they are those of the recording's clock.
    pub dated: bool,
    /// What each window said, in order of time.
    pub windows: Vec<Point>,
    /// What they say together.
    pub combined: Combined,
    /// Before and after a repair, if one was named.
    pub repair: Option<RepairTest>,
}

/// What one window said of a valve.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Point {
    /// The file it is from.
    pub file: String,
    /// Its beginning, s.
    pub from_s: f64,
    /// Its duration, s.
    pub duration_s: f64,
    /// The verdict on it.
    pub class: String,
    /// What that rests on.
    pub basis: String,
    /// The probability that the valve sticks.
    pub probability: Option<f64>,
    /// Whether its data can answer: `fit`, `caveats` or `unfit`.
    pub fitness: String,
    /// Stick band plus dead band, percent of span.
    #[serde(rename = "S")]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span.
    #[serde(rename = "J")]
    pub j: Option<Estimate>,
}

/// What the windows of a valve say together; of one that was repaired, those after the repair.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Combined {
    /// The conclusion.
    pub class: String,
    /// The combined probability that the valve sticks.
    pub probability: Option<f64>,
    /// How many windows they are.
    pub windows: usize,
    /// How many windows decided, or have a probability.
    pub decided: usize,
    /// The drift of S; null with too few windows.
    pub drift: Option<Drift>,
    /// What there is to say of it.
    pub trend: String,
}

/// The drift of S.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Drift {
    /// Growth of S as a share of itself, 1/day.
    pub per_day: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// p-value of the line of weighted least squares.
    pub p_value: f64,
    /// The median slope of all pairs, 1/day.
    pub robust_per_day: f64,
    /// p-value of Mann and Kendall's test.
    pub robust_p_value: f64,
    /// Whether all of them agree that there is a drift.
    pub significant: bool,
}

/// Before and after a repair.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RepairTest {
    /// When it was, s.
    pub time_s: f64,
    /// Windows before it.
    pub before: usize,
    /// Windows after it.
    pub after: usize,
    /// `worked`, `helped`, `no change`, `worse` or `cannot tell`.
    pub outcome: String,
    /// The probability that the valve sticks.
    pub probability: Option<Contrast>,
    /// S, percent of span.
    #[serde(rename = "S")]
    pub s: Option<Contrast>,
    /// The same in words.
    pub words: String,
}

/// A quantity before and after.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Contrast {
    /// Its typical value before.
    pub before: f64,
    /// Its typical value after.
    pub after: f64,
    /// Probability of as large a difference by chance.
    pub p_value: f64,
    /// Cliff's delta, from -1 (all fell) to 1 (all rose).
    pub delta: f64,
}

impl ValveHistory {
    /// A document of some valves.
    pub fn new(tool: impl Into<String>, valves: Vec<Valve>) -> Self {
        Self { tool: tool.into(), version: VERSION, valves }
    }

    /// The document as JSON text, indented.
    pub fn json(&self) -> String {
        // Types made of strings, finite numbers and lists always serialise.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

impl From<&diagnose::History> for Combined {
    fn from(history: &diagnose::History) -> Self {
        Self {
            class: history.class.name().into(),
            probability: history.probability,
            windows: history.observations,
            decided: history.decided,
            drift: history.drift.map(|drift| Drift {
                per_day: drift.per_day,
                low: drift.low,
                high: drift.high,
                p_value: drift.p_value,
                robust_per_day: drift.robust_per_day,
                robust_p_value: drift.robust_p_value,
                significant: drift.is_significant(),
            }),
            trend: history.trend.clone(),
        }
    }
}

impl From<&diagnose::Repair> for RepairTest {
    fn from(repair: &diagnose::Repair) -> Self {
        let contrast = |contrast: Option<diagnose::Contrast>| {
            contrast.map(|c| Contrast {
                before: c.before,
                after: c.after,
                p_value: c.p_value,
                delta: c.delta,
            })
        };
        Self {
            time_s: repair.time,
            before: repair.before,
            after: repair.after,
            outcome: repair.outcome.name().into(),
            probability: contrast(repair.probability),
            s: contrast(repair.s),
            words: repair.words.clone(),
        }
    }
}

impl Point {
    /// What a diagnosis of a window says, with its beginning in s on the valve's clock.
    pub fn new(diagnosis: &diagnose::Diagnosis, file: &str, from_s: f64, duration_s: f64) -> Self {
        let verdict = &diagnosis.verdict;
        Self {
            file: file.into(),
            from_s,
            duration_s,
            class: verdict.class.name().into(),
            basis: verdict.basis.name().into(),
            probability: verdict.probability.and_then(finite),
            fitness: diagnosis.fitness.class.name().into(),
            s: diagnosis.stiction.s.map(Estimate::from),
            j: diagnosis.stiction.j.map(Estimate::from),
        }
    }
}
