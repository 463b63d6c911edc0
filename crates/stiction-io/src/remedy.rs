//! Remedies for a reader that cannot recognise something by itself.

use crate::cells::number::DecimalMark;
use std::fmt;

/// A request of the reader, with an example if possible. Every front end has its own wording, see [`Wording`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Remedy {
    /// Give the role of a column ([`ReadOptions::map`](crate::ReadOptions::map)).
    Map {
        /// The role, such as `op`, or `FIC101.op` of one loop of several.
        role: String,
        /// The column; `None` if only the user knows it.
        column: Option<String>,
    },
    /// Give the time between rows, in s, such as this one.
    SampleTime(f64),
    /// Give the format of times, such as one of these; any if empty.
    TimeFormat(Vec<String>),
    /// Give the day of the first row, such as this one.
    Date(Option<String>),
    /// Give the zone of local times, such as this one.
    Zone(Option<String>),
    /// Read only this sheet of the workbook, or this part of the file.
    Part(String),
    /// Declare this word as a bad value.
    BadText(String),
    /// Give the decimal mark.
    DecimalMark(DecimalMark),
    /// Give the mode that this word or code means, such as one of these.
    Mode {
        /// The word or code.
        word: String,
        /// The possible modes.
        modes: Vec<&'static str>,
    },
    /// Give the quality that this word or code means, such as one of these.
    Quality {
        /// The word or code.
        word: String,
        /// The possible qualities.
        qualities: Vec<&'static str>,
    },
    /// Give the values of a signal at 0 % and 100 %.
    Range {
        /// The signal, `OP` or `VP`.
        signal: &'static str,
        /// The likely values, if known.
        ends: Option<(f64, f64)>,
    },
}

impl Remedy {
    /// A role for a column with this name.
    pub(crate) fn map(role: impl Into<String>, column: &str) -> Self {
        Self::Map { role: role.into(), column: Some(column.to_owned()) }
    }

    /// A role for a column that only the user knows.
    pub(crate) fn map_some(role: &str) -> Self {
        Self::Map { role: role.to_owned(), column: None }
    }

    /// The field of [`ReadOptions`](crate::ReadOptions), or of its loops' settings, for this remedy.
    pub fn option(&self) -> &'static str {
        match self {
            Self::Map { .. } => "map",
            Self::SampleTime(_) => "sample_time",
            Self::TimeFormat(_) => "time_format",
            Self::Date(_) => "date",
            Self::Zone(_) => "zone",
            Self::Part(_) => "part",
            Self::BadText(_) => "bad_text",
            Self::DecimalMark(_) => "decimal_mark",
            Self::Mode { .. } => "mode",
            Self::Quality { .. } => "quality",
            Self::Range { signal: "VP", .. } => "vp_range",
            Self::Range { .. } => "op_range",
        }
    }

    /// The value to give, as the command line writes it; empty without an example.
    pub fn value(&self) -> String {
        match self {
            Self::Map { role, column } => {
                format!("{role}={}", column.as_deref().unwrap_or("COLUMN"))
            }
            Self::SampleTime(seconds) => seconds.to_string(),
            Self::TimeFormat(ways) => ways.join(" or "),
            Self::Date(text) | Self::Zone(text) => text.clone().unwrap_or_default(),
            Self::Part(word) | Self::BadText(word) => word.clone(),
            Self::DecimalMark(mark) => mark.name().to_owned(),
            Self::Mode { word, modes: meanings } | Self::Quality { word, qualities: meanings } => {
                format!("{word}={}", meanings.join(" or "))
            }
            Self::Range { ends: Some((low, high)), .. } => format!("{low},{high}"),
            Self::Range { ends: None, .. } => "LOW,HIGH".to_owned(),
        }
    }
}

/// The option of this library and the value, such as `map op=COLUMN`.
impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.option())?;
        match self.value() {
            value if value.is_empty() => Ok(()),
            value => write!(f, " {value}"),
        }
    }
}

/// The wording of remedies in messages and notes, by default with the names of this library's options. A front end
/// whose options have other names provides its own.
#[derive(Clone, Copy)]
pub struct Wording(pub fn(&Remedy) -> String);

impl Wording {
    pub(crate) fn of(self, remedy: Remedy) -> String {
        (self.0)(&remedy)
    }
}

impl Default for Wording {
    fn default() -> Self {
        Self(Remedy::to_string)
    }
}

impl fmt::Debug for Wording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Wording")
    }
}

/// Wordings do not affect reading, so all are equal.
impl PartialEq for Wording {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
