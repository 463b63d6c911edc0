//! A diagnosis with the words for it, which the page shows as they are.

use schemars::JsonSchema;
use serde::Serialize;
use stiction_diagnose::diagnose::Diagnosis;
use stiction_report::words;

/// A diagnosis, in words and whole.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Judgement {
    /// The verdict, a sentence.
    sentence: String,
    /// Why.
    why: String,
    /// The probability that the valve sticks, where there is one.
    probability: Option<String>,
    /// S with its interval, where it is known.
    #[serde(rename = "S")]
    s: Option<String>,
    /// J with its interval, where it is known.
    #[serde(rename = "J")]
    j: Option<String>,
    /// What would have been seen: an S above this, where that is known.
    #[serde(rename = "S_below")]
    s_below: Option<String>,
    /// All of it, as `stiction diagnose --json` tells it.
    diagnosis: Diagnosis,
}

impl Judgement {
    /// The words for a diagnosis.
    pub fn new(diagnosis: Diagnosis) -> Self {
        let stiction = &diagnosis.stiction;
        Self {
            sentence: words::verdict(&diagnosis),
            why: words::why(&diagnosis),
            probability: diagnosis.verdict.shown_probability().map(words::percent),
            s: stiction.s.map(words::interval),
            j: stiction.j.map(words::interval),
            s_below: diagnosis
                .verdict
                .s_below
                .map(|limit| format!("{} %", words::rough(limit.value))),
            diagnosis,
        }
    }
}
