//! The history of valves as a document for programs.

use super::{Source, VERSION, json};
use schemars::JsonSchema;
use serde::Serialize;
use stiction_diagnose::diagnose::{
    Basis, Diagnosis, Estimate, Grade, History, Repair, VerdictClass,
};
use stiction_diagnose::recording::PlantTime;
use stiction_diagnose::recording::fitness::Class;
use stiction_figure::figure::instant;

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
    /// The clock of the plant, in which its times are shown.
    pub plant_time: PlantTime,
    /// What each window said, in order of time.
    pub windows: Vec<Point>,
    /// What they say together; of a valve that was repaired, those after the repair.
    pub combined: History,
    /// Before and after a repair, if one was named.
    pub repair: Option<Repair>,
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
    pub class: VerdictClass,
    /// The same in one graded word.
    pub grade: Grade,
    /// What that rests on.
    pub basis: Basis,
    /// The probability that the valve sticks.
    pub probability: Option<f64>,
    /// Whether its data can answer: `fit`, `caveats` or `unfit`.
    pub fitness: Class,
    /// Stick band plus dead band, percent of span.
    #[serde(rename = "S")]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span.
    #[serde(rename = "J")]
    pub j: Option<Estimate>,
}

impl ValveHistory {
    /// A document of some valves.
    pub fn new(tool: impl Into<String>, valves: Vec<Valve>) -> Self {
        Self { tool: tool.into(), version: VERSION, valves }
    }

    /// The document as JSON text, indented.
    pub fn json(&self) -> String {
        json(self)
    }
}

impl Valve {
    /// The date and time on the clock of the plant at a time of this history; `None` of recordings without dates.
    pub fn date(&self, at: f64) -> Option<String> {
        self.dated.then(|| instant(self.plant_time.shows(at), &self.plant_time.name))?
    }
}

impl Point {
    /// What a diagnosis of a window says, with its beginning in s on the valve's clock.
    pub fn new(diagnosis: &Diagnosis, file: &str, from_s: f64, duration_s: f64) -> Self {
        let Diagnosis { verdict, stiction, fitness, .. } = diagnosis;
        Self {
            file: file.into(),
            from_s,
            duration_s,
            class: verdict.class,
            grade: verdict.grade,
            basis: verdict.basis,
            probability: verdict.probability,
            fitness: fitness.class,
            s: stiction.s,
            j: stiction.j,
        }
    }
}
