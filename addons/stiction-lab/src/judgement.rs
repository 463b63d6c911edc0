//! A diagnosis with its texts for the page.

use schemars::JsonSchema;
use serde::Serialize;
use stiction_diagnose::diagnose::Diagnosis;
use stiction_report::words;

/// A diagnosis, in words and complete.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Judgement {
    /// The verdict, a sentence.
    sentence: String,
    /// Why.
    why: String,
    /// The data that it rests on.
    data: String,
    /// The probability that the valve sticks, where there is one.
    probability: Option<String>,
    /// S with its interval, where it is known.
    #[serde(rename = "S")]
    s: Option<String>,
    /// J with its interval, where it is known.
    #[serde(rename = "J")]
    j: Option<String>,
    /// The detection limit of S, where it is known.
    #[serde(rename = "S_below")]
    s_below: Option<String>,
    /// The whole diagnosis, as `stiction diagnose --json` prints it.
    diagnosis: Diagnosis,
}

impl Judgement {
    /// The words for a diagnosis.
    pub fn new(diagnosis: Diagnosis) -> Self {
        let stiction = &diagnosis.stiction;
        Self {
            sentence: words::verdict(&diagnosis),
            why: words::why(&diagnosis),
            data: data(&diagnosis),
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

/// The data that a diagnosis rests on: how long, how many samples, how far apart.
fn data(diagnosis: &Diagnosis) -> String {
    let Some(segment) = diagnosis.segment() else { return "The data cannot answer".to_owned() };
    format!(
        "Judged from {} of data: {} samples, {} s apart",
        words::spoken(segment.duration()),
        segment.len(),
        words::rough(segment.sample_time)
    )
}
