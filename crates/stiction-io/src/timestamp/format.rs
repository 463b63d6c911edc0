//! How times can be written.

use std::str::FromStr;

/// The order in which a date is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DateOrder {
    /// As in 2024-12-31.
    YearFirst,
    /// As in 31/12/2024.
    DayFirst,
    /// As in 12/31/2024.
    MonthFirst,
}

impl DateOrder {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::YearFirst => "year first",
            Self::DayFirst => "day first",
            Self::MonthFirst => "month first",
        }
    }
}

/// How the times of a file are written, where the user says so.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeFormat {
    /// Dates in this order, with times of day.
    Date(DateOrder),
    /// Time since 1970-01-01 UTC in units of so many seconds.
    Epoch(f64),
    /// Days as spreadsheets count them, 1 being 1900-01-01.
    Spreadsheet,
    /// Days as MATLAB's `datenum` counts them, 1 being 0000-01-01.
    Datenum,
    /// Time since any start in units of so many seconds.
    Elapsed(f64),
    /// A pattern as of `strptime`, such as `%d.%m.%Y %H:%M:%S`.
    Pattern(String),
}

impl TimeFormat {
    /// The formats that have a name.
    const NAMES: [(&'static str, Self); 16] = [
        ("year-first", Self::Date(DateOrder::YearFirst)),
        ("day-first", Self::Date(DateOrder::DayFirst)),
        ("month-first", Self::Date(DateOrder::MonthFirst)),
        ("epoch-s", Self::Epoch(1.0)),
        ("epoch-ms", Self::Epoch(1e-3)),
        ("epoch-us", Self::Epoch(1e-6)),
        ("epoch-ns", Self::Epoch(1e-9)),
        ("excel", Self::Spreadsheet),
        ("datenum", Self::Datenum),
        ("seconds", Self::Elapsed(1.0)),
        ("milliseconds", Self::Elapsed(1e-3)),
        ("microseconds", Self::Elapsed(1e-6)),
        ("nanoseconds", Self::Elapsed(1e-9)),
        ("minutes", Self::Elapsed(60.0)),
        ("hours", Self::Elapsed(3600.0)),
        ("days", Self::Elapsed(86_400.0)),
    ];

    /// The word by which a user gives it; a pattern is its own.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Pattern(pattern) => pattern,
            _ => Self::NAMES.iter().find(|(_, each)| each == self).map_or("", |(name, _)| name),
        }
    }

    /// A word or two for it.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Date(order) => format!("date and time, {}", order.name()),
            Self::Epoch(unit) => format!("{} since 1970", unit_name(*unit)),
            Self::Spreadsheet => "spreadsheet days since 1900".to_owned(),
            Self::Datenum => "days of MATLAB's datenum".to_owned(),
            Self::Elapsed(unit) => unit_name(*unit).to_owned(),
            Self::Pattern(pattern) => pattern.clone(),
        }
    }
}

/// The units of time that columns are in, in s, and what they are called.
const UNITS: [(f64, &str, &[&str]); 7] = [
    (1.0, "seconds", &["s", "sec", "secs", "second", "seconds"]),
    (1e-3, "milliseconds", &["ms", "msec", "millis", "millisecond", "milliseconds"]),
    (1e-6, "microseconds", &["us", "µs", "microseconds"]),
    (1e-9, "nanoseconds", &["ns", "nanoseconds"]),
    (60.0, "minutes", &["min", "mins", "minute", "minutes"]),
    (3600.0, "hours", &["h", "hr", "hrs", "hour", "hours"]),
    (86_400.0, "days", &["d", "day", "days"]),
];

pub(super) fn unit_name(unit: f64) -> &'static str {
    UNITS.iter().find(|(each, _, _)| *each == unit).map_or("units", |(_, name, _)| name)
}

/// The unit of time, in s, that a word names.
pub(super) fn unit_of(word: &str) -> Option<f64> {
    UNITS.iter().find(|(_, _, words)| words.contains(&word)).map(|(unit, _, _)| *unit)
}

/// Whether a column of this name holds times of which it tells neither unit nor form.
pub(super) fn is_plain_name(name: &str) -> bool {
    matches!(&*name.to_lowercase(), "t" | "time" | "elapsed")
}

impl FromStr for TimeFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains('%') {
            return Ok(Self::Pattern(text.to_owned()));
        }
        let named = Self::NAMES.into_iter().find(|(name, _)| *name == text);
        named.map(|(_, format)| format).ok_or_else(|| {
            format!(
                "\"{text}\" is no time format; give a pattern such as \"%d/%m/%Y %H:%M:%S\", or one \
                 of {}",
                Self::NAMES.map(|(name, _)| name).join(", ")
            )
        })
    }
}
