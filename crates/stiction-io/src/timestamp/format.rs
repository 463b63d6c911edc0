//! Formats of times.

use std::str::FromStr;

/// The order of a date.
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

/// The format of a file's times, if the user gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeFormat {
    /// Dates in this order, with times of day.
    Date(DateOrder),
    /// Time since 1970-01-01 UTC in units of this many seconds.
    Epoch(f64),
    /// Ticks of .NET, which are 100 ns, since 0001-01-01 UTC.
    Ticks,
    /// Time of Windows files in units of 100 ns, since 1601-01-01 UTC.
    FileTime,
    /// Seconds since 1904-01-01 UTC, as of LabVIEW.
    LabView,
    /// Seconds of GPS since 1980-01-06, treated as 18 s ahead of UTC, which is right since 2017 and up to 18 s late
    /// before.
    Gps,
    /// Days counted as in spreadsheets, where 1 is 1900-01-01.
    Spreadsheet,
    /// Days counted as in old Macintosh spreadsheets, where 0 is 1904-01-01.
    Spreadsheet1904,
    /// Days counted as by MATLAB's `datenum`, where 1 is 0000-01-01.
    Datenum,
    /// Time since any start in units of this many seconds.
    Elapsed(f64),
    /// A pattern as in `strptime`, such as `%d.%m.%Y %H:%M:%S`.
    Pattern(String),
}

impl TimeFormat {
    /// The formats with a name.
    const NAMES: [(&'static str, Self); 21] = [
        ("year-first", Self::Date(DateOrder::YearFirst)),
        ("day-first", Self::Date(DateOrder::DayFirst)),
        ("month-first", Self::Date(DateOrder::MonthFirst)),
        ("epoch-s", Self::Epoch(1.0)),
        ("epoch-ms", Self::Epoch(1e-3)),
        ("epoch-us", Self::Epoch(1e-6)),
        ("epoch-ns", Self::Epoch(1e-9)),
        ("dotnet-ticks", Self::Ticks),
        ("filetime", Self::FileTime),
        ("labview", Self::LabView),
        ("gps", Self::Gps),
        ("excel", Self::Spreadsheet),
        ("excel-1904", Self::Spreadsheet1904),
        ("datenum", Self::Datenum),
        ("seconds", Self::Elapsed(1.0)),
        ("milliseconds", Self::Elapsed(1e-3)),
        ("microseconds", Self::Elapsed(1e-6)),
        ("nanoseconds", Self::Elapsed(1e-9)),
        ("minutes", Self::Elapsed(60.0)),
        ("hours", Self::Elapsed(3600.0)),
        ("days", Self::Elapsed(86_400.0)),
    ];

    /// Formats that give a date as a number.
    pub(super) const DATED: [Self; 11] = [
        Self::Epoch(1.0),
        Self::Epoch(1e-3),
        Self::Epoch(1e-6),
        Self::Epoch(1e-9),
        Self::Ticks,
        Self::FileTime,
        Self::LabView,
        Self::Spreadsheet,
        Self::Datenum,
        // The magnitude of these numbers is like that of formats above, so it decides for neither.
        Self::Gps,
        Self::Spreadsheet1904,
    ];

    /// Duration of a step of 1, in seconds.
    pub(super) fn unit(&self) -> f64 {
        match self {
            Self::Epoch(unit) | Self::Elapsed(unit) => *unit,
            Self::Ticks | Self::FileTime => 1e-7,
            Self::Spreadsheet | Self::Spreadsheet1904 | Self::Datenum => 86_400.0,
            Self::LabView | Self::Gps | Self::Date(_) | Self::Pattern(_) => 1.0,
        }
    }

    /// The zero of a format that gives a date as a number, s since 1970.
    pub(super) fn zero(&self) -> Option<f64> {
        match self {
            Self::Epoch(_) => Some(0.0),
            Self::Ticks => Some(-62_135_596_800.0),
            Self::FileTime => Some(-11_644_473_600.0),
            Self::LabView => Some(-2_082_844_800.0),
            Self::Gps => Some(315_964_800.0 - 18.0),
            // They count a 29 February 1900 that did not exist, so this holds from March 1900 on.
            Self::Spreadsheet => Some(-25_569.0 * 86_400.0),
            Self::Spreadsheet1904 => Some(-24_107.0 * 86_400.0),
            // The first day of the year 0 is 1.
            Self::Datenum => Some(-719_529.0 * 86_400.0),
            Self::Elapsed(_) | Self::Date(_) | Self::Pattern(_) => None,
        }
    }

    /// Whether it counts days on the clock of the plant instead of UTC.
    pub(super) fn is_local(&self) -> bool {
        matches!(self, Self::Spreadsheet | Self::Spreadsheet1904 | Self::Datenum)
    }

    /// The name for users. A pattern is its own name.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Pattern(pattern) => pattern,
            _ => Self::NAMES.iter().find(|(_, each)| each == self).map_or("", |(name, _)| name),
        }
    }

    /// The name of the format with this description, if it has one.
    pub(crate) fn name_of(description: &str) -> Option<&'static str> {
        let found = Self::NAMES.into_iter().find(|(_, format)| format.describe() == description);
        found.map(|(name, _)| name)
    }

    /// A short description.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Date(order) => format!("date and time, {}", order.name()),
            Self::Epoch(unit) => format!("{} since 1970", unit_name(*unit)),
            Self::Ticks => "ticks of .NET".to_owned(),
            Self::FileTime => "file time of Windows".to_owned(),
            Self::LabView => "seconds since 1904".to_owned(),
            Self::Gps => "seconds of GPS".to_owned(),
            Self::Spreadsheet => "spreadsheet days since 1900".to_owned(),
            Self::Spreadsheet1904 => "spreadsheet days since 1904".to_owned(),
            Self::Datenum => "days of MATLAB's datenum".to_owned(),
            Self::Elapsed(unit) => unit_name(*unit).to_owned(),
            Self::Pattern(pattern) => pattern.clone(),
        }
    }
}

/// The units of time of columns, in s, with their names.
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

/// The unit of time, in s, of a word.
pub(super) fn unit_of(word: &str) -> Option<f64> {
    UNITS.iter().find(|(_, _, words)| words.contains(&word)).map(|(unit, _, _)| *unit)
}

/// Whether a column of this name holds times without giving unit or format.
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
                "\"{text}\" is not a time format; give a pattern such as \"%d/%m/%Y %H:%M:%S\", or one of {}",
                Self::NAMES.map(|(name, _)| name).join(", ")
            )
        })
    }
}
