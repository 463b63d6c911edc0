//! The figures of the paper, as the command draws them.

use crate::calls::{Answer, Wrong};
use crate::lab::Lab;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// A figure of the paper.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PaperFigure {
    /// Heading.
    pub heading: String,
    /// What it shows.
    pub caption: String,
    /// The figure.
    pub svg: String,
    /// Name, value and unit of every parameter.
    pub parameters: Vec<[String; 3]>,
    /// A command that simulates the same.
    pub command: String,
    /// The query of the address that opens the same loop live.
    pub state: String,
}

/// Draws figures by their number, from 0. The program that opens the lab provides it.
#[derive(Clone)]
pub struct Paper(pub Arc<dyn Fn(usize) -> Option<Result<PaperFigure, String>> + Send + Sync>);

impl Default for Paper {
    fn default() -> Self {
        Self(Arc::new(|_| None))
    }
}

impl fmt::Debug for Paper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Paper")
    }
}

/// The requested figure.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Which {
    /// Number, from 0.
    number: usize,
}

/// A figure, or null past the last.
///
/// # Errors
/// If the figure cannot be drawn.
pub fn figure(lab: &Lab, which: Which) -> Answer<Option<PaperFigure>> {
    (lab.paper.0)(which.number).transpose().map_err(Wrong::own)
}
