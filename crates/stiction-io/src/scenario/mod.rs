//! Scenarios describe a simulation in TOML.
//!
//! ```toml
//! title = "The paper's loop"
//! sample_time = 0.01          # s
//! duration = 600              # s
//! [set_point]
//! value = 5
//! [controller]
//! kc = 1.1
//! ti = 2.5                    # s
//! [valve]
//! model = "two-phase"
//! S = 5                       # percent of span
//! J = 3
//! [process]
//! gain = 1.5
//! tau = 5.93                  # s
//! delay = 1.07                # s
//! ```
//! With `[controller]` and `[process]` it is a closed loop, and with `[master]` in addition a cascade. With `[input]`
//! instead it is a valve on a test signal. The project's `docs/scenarios.md` lists every key of every table.

mod builder;
mod built_in;
mod clock;
mod control;
mod keys;
mod settings;
mod signal;
mod system;

pub use system::System;

use crate::bytes;
use crate::error::{Error, Result};
use crate::fields::{Fields, Wrong, line_of};
use builder::Builder;
use built_in::SCENARIOS;
use signal::Signals;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use stiction_model::Bands;
use stiction_model::valve::Model;
use toml::de::DeTable;

/// A scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Title, one line.
    pub title: String,
    /// The simulated system.
    pub system: System,
    /// The valve's model and bands.
    pub valve: (Model, Bands),
    /// The TOML text, with all settings in it.
    pub text: String,
    /// Settings without effect, in sentences.
    pub notes: Vec<String>,
    /// The files that its signals were read from.
    pub files: Vec<PathBuf>,
}

/// Names and titles of the built-in scenarios.
pub fn built_in() -> impl Iterator<Item = (&'static str, String)> {
    SCENARIOS.iter().map(|(name, text)| {
        let title = Scenario::parse(text, name, None).map(|scenario| scenario.title);
        (*name, title.unwrap_or_default())
    })
}

/// The TOML text of the built-in scenario of that name, if it exists.
pub fn built_in_text(name: &str) -> Option<&'static str> {
    SCENARIOS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

impl Scenario {
    /// The built-in scenario `name`, or else the scenario in the file of that path, with `settings` such as
    /// `valve.S=4` applied.
    ///
    /// # Errors
    /// If no such scenario exists, the scenario is not well-formed, or a setting does not fit the scenario.
    pub fn open(name: &str, settings: &[String]) -> Result<Self> {
        let (text, folder) = match built_in_text(name) {
            Some(text) => (text.to_owned(), None),
            None => {
                let path = Path::new(name);
                let text = bytes::read(path).map_err(|error| match error {
                    Error::File { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                        let known: Vec<_> = SCENARIOS.iter().map(|(name, _)| *name).collect();
                        Error::UnknownScenario { name: name.to_owned(), known: known.join(", ") }
                    }
                    other => other,
                })?;
                let text = String::from_utf8(text).map_err(|e| Error::Scenario {
                    origin: name.to_owned(),
                    line: line_of(e.as_bytes(), e.utf8_error().valid_up_to()),
                    message: "is not UTF-8 text; save the file in UTF-8".to_owned(),
                })?;
                (text, Some(path.parent().unwrap_or(Path::new("."))))
            }
        };
        Self::parse_with(&text, name, folder, settings)
    }

    /// Like [`parse`](Self::parse), with `settings` such as `valve.S=4` applied.
    ///
    /// # Errors
    /// If the scenario is not well-formed, or a setting does not fit the scenario.
    pub fn parse_with(
        text: &str,
        origin: &str,
        folder: Option<&Path>,
        settings: &[String],
    ) -> Result<Self> {
        let plain = Self::parse(text, origin, folder)?;
        if settings.is_empty() {
            return Ok(plain);
        }
        let changed = settings::apply(text, settings)?;
        // The text was well formed before, so the fault comes from the settings.
        Self::parse(&changed, origin, folder).map_err(|e| match e {
            Error::Scenario { message, .. } => {
                Error::Setting { settings: settings.to_vec(), message }
            }
            other => other,
        })
    }

    /// Reads a scenario from `text`. `origin` is its name in errors. Signals are read from files in `folder`, or
    /// refused without a folder.
    ///
    /// # Errors
    /// If the text is not well-formed. The error gives the line.
    pub fn parse(text: &str, origin: &str, folder: Option<&Path>) -> Result<Self> {
        let at = |wrong: Wrong| Error::Scenario {
            origin: origin.to_owned(),
            line: line_of(text.as_bytes(), wrong.span.start),
            message: wrong.message,
        };
        let document = DeTable::parse(text).map_err(|e| at(e.into()))?;
        let signals = Signals { folder, files: RefCell::default() };
        let mut builder = Builder { signals, valve: (Model::Ideal, Bands::NONE), notes: vec![] };
        let (title, system) = Fields::document(&document, keys::SCENARIO)
            .and_then(|top| builder.scenario(top))
            .map_err(at)?;
        let Builder { valve, notes, signals } = builder;
        let files = signals.files.into_inner();
        Ok(Self { title, system, valve, text: text.to_owned(), notes, files })
    }

    /// Every setting, with its dotted key, its value as TOML, and its unit, if any.
    pub fn settings(&self) -> Vec<(String, String, &'static str)> {
        settings::listed(&self.text)
    }

    /// Keys of settings that do not affect a predicted limit cycle, which is in continuous time, without noise and
    /// far from the limits.
    pub fn no_part_in_cycles(&self) -> Vec<String> {
        const KEYS: [&str; 5] =
            ["valve.K", "valve.lag", "valve.limits", "valve.rest_tolerance", "controller.limits"];
        const TABLES: [&str; 4] = ["noise", "manual", "measurement", "resolution"];
        let keys = self.settings().into_iter().map(|(key, ..)| key);
        keys.filter(|key| {
            let table = key.split('.').next().unwrap_or_default();
            KEYS.contains(&key.as_str()) || TABLES.contains(&table)
        })
        .collect()
    }
}
