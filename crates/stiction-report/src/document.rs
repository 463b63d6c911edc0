//! Documents for programs, as printed by `stiction diagnose --json` and `stiction history --json`.
//!
//! The results are serialised by the types of `stiction-diagnose`. Here is the envelope around them. The JSON schema
//! is generated from the same types ([`schema`]). Within one [`VERSION`], fields are added but never renamed or
//! removed.

use crate::report::fitted::Fitted;
use schemars::JsonSchema;
use serde::Serialize;
use std::cmp::Ordering;
use stiction_diagnose::diagnose::Diagnosis;

mod history;

pub use history::{Point, Valve, ValveHistory};

/// Version of the document's form.
pub const VERSION: u32 = 1;

/// The diagnoses of some loops.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Document<'a> {
    /// Name and version of the program.
    pub tool: String,
    /// Version of this form.
    pub version: u32,
    /// The loops in the order of the files, and within a file in the order of first appearance.
    pub loops: Vec<Loop<'a>>,
}

/// The diagnosis of one loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Loop<'a> {
    /// Source of the recording.
    pub source: &'a Source,
    /// The diagnosis.
    #[serde(flatten)]
    pub diagnosis: &'a Diagnosis,
    /// The fitted loop, which only reports show.
    #[serde(skip)]
    pub fitted: Option<&'a Fitted>,
}

/// The source of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Source {
    /// Name of the file, as given.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

impl<'a> Loop<'a> {
    /// A diagnosis without a fitted loop.
    pub fn new(source: &'a Source, diagnosis: &'a Diagnosis) -> Self {
        Self { source, diagnosis, fitted: None }
    }

    /// The diagnosis with its fitted loop.
    #[must_use]
    pub fn with_fit(self, fitted: &'a Option<Fitted>) -> Self {
        Self { fitted: fitted.as_ref(), ..self }
    }

    /// The order in which loops are listed: by [`Diagnosis::rank`], worst first, then by name and file.
    pub fn in_rank(&self, other: &Self) -> Ordering {
        let (a, b) = (self.diagnosis, other.diagnosis);
        a.rank()
            .total_cmp(&b.rank())
            .then_with(|| (&a.name, &self.source.file).cmp(&(&b.name, &other.source.file)))
    }
}

impl<'a> Document<'a> {
    /// A document of some loops.
    pub fn new(tool: impl Into<String>, loops: Vec<Loop<'a>>) -> Self {
        Self { tool: tool.into(), version: VERSION, loops }
    }

    /// The document as JSON text, indented.
    pub fn json(&self) -> String {
        json(self)
    }
}

/// A document as JSON text, indented.
pub fn json(document: &impl Serialize) -> String {
    // Types made of strings, numbers and lists always serialise.
    serde_json::to_string_pretty(document).unwrap_or_default()
}

/// The JSON schema of a [`Document`], indented.
pub fn schema() -> String {
    schema_of::<Document<'_>>()
}

/// The JSON schema of a [`ValveHistory`], indented.
pub fn history_schema() -> String {
    schema_of::<ValveHistory>()
}

/// The JSON schema of a document, indented.
pub fn schema_of<T: JsonSchema>() -> String {
    // Rust documentation mentions `None` and has links with brackets.
    json(&schemars::schema_for!(T)).replace("`None`", "null").replace("[`", "`").replace("`]", "`")
}
