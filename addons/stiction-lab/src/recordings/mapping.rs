//! The corrections to a file by hand: the part of a mapping file that the page can change.

use crate::calls::{Answer, Wrong};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use stiction_io::ReadOptions;

/// The corrections to a file by hand, kept as a mapping file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// Zone of times without one, such as `Europe/Berlin`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<String>,
    /// How times are written, such as `day-first`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_format: Option<String>,
    /// Time between rows, s, instead of a time column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_time: Option<f64>,
    /// The role of a column, such as `op`, `FIC101.op` or `ignore`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
    /// The corrections to a loop.
    #[serde(default, rename = "loop", skip_serializing_if = "BTreeMap::is_empty")]
    pub loops: BTreeMap<String, OfLoop>,
}

/// The corrections to a loop by hand.
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
    /// Without empty loops.
    pub fn tidy(mut self) -> Self {
        self.loops.retain(|_, each| !each.is_empty());
        self
    }

    /// Whether there are no corrections.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The text of its file.
    pub fn text(&self) -> String {
        // Texts, numbers and tables of them can always be written.
        toml::to_string(self).unwrap_or_default()
    }

    /// The mapping as options of the reader.
    ///
    /// # Errors
    /// If a role, a zone or a similar word is not known. The message is the reader's, without a line number.
    pub fn options(&self) -> Answer<ReadOptions> {
        ReadOptions::parse(&self.text(), "these settings").map_err(|error| match error {
            stiction_io::Error::Mapping { message, .. } => Wrong::request(message),
            other => Wrong::request(other),
        })
    }
}

/// The text of a mapping file as corrections; `None` if it has more.
pub fn of_text(text: &str) -> Option<Mapping> {
    toml::from_str(text).ok()
}
