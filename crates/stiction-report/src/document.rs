//! A diagnosis as a document for programs: what `stiction diagnose --json` prints; and a history, what
//! `stiction history --json` prints.
//!
//! What was found out is declared where it is found out, in `stiction-diagnose`: those types serialise as they are,
//! and here is the envelope around them. The JSON schema is generated from the same types ([`schema`]). Fields are added,
//! never renamed or removed, within one [`VERSION`].

use schemars::JsonSchema;
use serde::Serialize;
use std::cmp::Ordering;
use stiction_diagnose::diagnose::Diagnosis;

mod history;

pub use history::{Point, Valve, ValveHistory};

/// Version of the document's form.
pub const VERSION: u32 = 1;

/// What was found out about some loops.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Document<'a> {
    /// The program that made it, with its version.
    pub tool: String,
    /// Version of this form.
    pub version: u32,
    /// The loops in the order of the files, and in them in the order of first appearance.
    pub loops: Vec<Loop<'a>>,
}

/// What was found out about one loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Loop<'a> {
    /// Where the recording comes from.
    pub source: &'a Source,
    /// What was found out.
    #[serde(flatten)]
    pub diagnosis: &'a Diagnosis,
}

/// Where a recording comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Source {
    /// The file as it was named.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

impl Loop<'_> {
    /// The order in which loops are looked at: that of [`Diagnosis::rank`], the worst first; then by name and file.
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
    // What is documented for Rust speaks of `None`, and links with brackets.
    json(&schemars::schema_for!(T)).replace("`None`", "null").replace("[`", "`").replace("`]", "`")
}
