//! What is said of a file by hand: as much of a mapping file as the page can change.

use crate::calls::{Answer, Wrong};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use stiction_io::ReadOptions;

/// What is said of a file by hand. It is a mapping file, and is kept as one.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// Zone of times without one, such as `Europe/Berlin`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<String>,
    /// How times are written, such as `day-first`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_format: Option<String>,
    /// Time between rows, s, in place of a column of times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_time: Option<f64>,
    /// The role of a column, such as `op`, `FIC101.op` or `ignore`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
    /// What is said of a loop.
    #[serde(default, rename = "loop", skip_serializing_if = "BTreeMap::is_empty")]
    pub loops: BTreeMap<String, OfLoop>,
}

/// What is said of a loop by hand.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfLoop {
    /// What it controls.
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub loop_type: Option<String>,
    /// The values of OP that are 0 % and 100 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub op_range: Option<(f64, f64)>,
    /// The values of PV that are 0 % and 100 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pv_range: Option<(f64, f64)>,
    /// The values of VP that are 0 % and 100 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vp_range: Option<(f64, f64)>,
}

impl OfLoop {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl Mapping {
    /// Without loops of which nothing is said.
    pub fn tidy(mut self) -> Self {
        self.loops.retain(|_, each| !each.is_empty());
        self
    }

    /// Whether nothing is said.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The text of its file.
    pub fn text(&self) -> String {
        // Texts, numbers and tables of them can always be written.
        toml::to_string(self).unwrap_or_default()
    }

    /// What the reader takes it for.
    ///
    /// # Errors
    /// If a role, a zone or another word is not known; the message is the reader's, without a line of a text that nobody
    /// has written.
    pub fn options(&self) -> Answer<ReadOptions> {
        ReadOptions::parse(&self.text(), "what was said").map_err(|error| match error {
            stiction_io::Error::Mapping { message, .. } => Wrong::asked(message),
            other => Wrong::asked(other),
        })
    }
}

/// A mapping file's text as what can be changed here; `None` if it says more.
pub fn of_text(text: &str) -> Option<Mapping> {
    toml::from_str(text).ok()
}
