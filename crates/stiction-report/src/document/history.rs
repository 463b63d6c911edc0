//! The history of valves, as a document for programs.

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
    /// Name and version of the program.
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
    /// The files of its recordings.
    pub sources: Vec<Source>,
    /// Whether times count from 1970-01-01 UTC. Otherwise they follow the recording's clock.
    pub dated: bool,
    /// The clock of the plant, for the display of times.
    pub plant_time: PlantTime,
    /// The results of each window, in order of time.
    pub windows: Vec<Point>,
    /// The combined result of all windows. After a repair, or if the valve began or ceased to stick, only later windows
    /// count.
    pub combined: History,
    /// Comparison before and after a repair, if one was given.
    pub repair: Option<Repair>,
}

/// The results of one window.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Point {
    /// File.
    pub file: String,
    /// Beginning, s.
    pub from_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Verdict.
    pub class: VerdictClass,
    /// The verdict as one graded word.
    pub grade: Grade,
    /// Basis of the verdict.
    pub basis: Basis,
    /// The probability that the valve sticks; null where the data cannot answer.
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
    /// Which windows count, as a text after their number: all, or the windows since the last change or the repair.
    pub fn since(&self) -> &'static str {
        match (self.combined.since(), &self.repair) {
            (Some(_), _) => " since the change",
            (None, Some(_)) => " since the repair",
            (None, None) => "",
        }
    }

    /// The date and time of this history on the clock of the plant; `None` for recordings without dates.
    pub fn date(&self, at: f64) -> Option<String> {
        self.dated.then(|| instant(self.plant_time.shows(at), &self.plant_time.name))?
    }
}

impl Point {
    /// The results of a window from its diagnosis, with its beginning in s on the valve's clock.
    pub fn new(diagnosis: &Diagnosis, file: &str, from_s: f64, duration_s: f64) -> Self {
        let Diagnosis { verdict, stiction, fitness, .. } = diagnosis;
        Self {
            file: file.into(),
            from_s,
            duration_s,
            class: verdict.class,
            grade: verdict.grade,
            basis: verdict.basis,
            probability: verdict.shown_probability(),
            fitness: fitness.class,
            s: stiction.s,
            j: stiction.j,
        }
    }
}
