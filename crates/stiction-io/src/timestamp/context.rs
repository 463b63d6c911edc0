//! Times, and the information on a column of times beside its cells.

use super::clock::Clock;
use super::day::Day;
use super::format::TimeFormat;
use super::zone::Zone;
use crate::cells::number::DecimalMark;
use crate::error::Error;
use crate::remedy::Wording;
use crate::sheet::{Column, Sheet};

/// The times of a sheet's rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    /// Time zero as seconds since 1970-01-01 UTC, if known.
    pub start: Option<f64>,
    /// The times, s since `start`; without a start, as in the file.
    pub seconds: Vec<f64>,
    /// Their notation, in words.
    pub format: String,
    /// The kind of clock.
    pub clock: Clock,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// The information on a column of times beside its cells.
pub struct Context<'a> {
    pub sheet: &'a Sheet,
    pub mark: DecimalMark,
    pub format: Option<&'a TimeFormat>,
    pub zone: Option<&'a Zone>,
    /// The day of the first row, for times of day without a date.
    pub date: Option<Day>,
    /// The series of each row. The rows of a series are in order of time or in reverse order.
    pub series: &'a [usize],
    /// Whether rows belong to several tags.
    pub is_long: bool,
    pub wording: Wording,
}

impl Context<'_> {
    /// An error on the cell of `column` at `index`.
    pub fn wrong(&self, column: &Column, index: usize, message: String) -> Error {
        Error::Cell {
            origin: self.sheet.origin.clone(),
            row: self.sheet.row(index),
            column: column.name.clone(),
            message,
        }
    }

    pub fn wrong_column(&self, column: &Column, message: String) -> Error {
        Error::Column { origin: self.sheet.origin.clone(), column: column.name.clone(), message }
    }

    /// The rows of each series in the order of the file.
    pub fn rows_of_series(&self) -> Vec<Vec<usize>> {
        let count = self.series.iter().max().map_or(0, |last| last + 1);
        let mut rows = vec![vec![]; count];
        for (row, series) in self.series.iter().enumerate() {
            rows[*series].push(row);
        }
        rows
    }
}

/// Seconds since 1970 that a recording of a plant can have: 1980 to 2100.
pub const PLAUSIBLE: std::ops::Range<f64> = 315_532_800.0..4_102_444_800.0;
