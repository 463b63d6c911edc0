//! Times, and what is known of a column of them beside its cells.

use super::clock::Clock;
use super::format::TimeFormat;
use super::zone::Zone;
use crate::cells::number::DecimalMark;
use crate::error::Error;
use crate::remedy::Wording;
use crate::sheet::{Column, Sheet};

/// The times of a sheet's rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    /// Time zero as seconds since 1970-01-01 UTC, if it is known.
    pub start: Option<f64>,
    /// The times, s since `start`; without one, as the file has them.
    pub seconds: Vec<f64>,
    /// How they are written, in words.
    pub format: String,
    /// What the clock shows.
    pub clock: Clock,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// What is known of a column of times beside its cells.
pub struct Context<'a> {
    pub sheet: &'a Sheet,
    pub mark: DecimalMark,
    pub format: Option<&'a TimeFormat>,
    pub zone: Option<&'a Zone>,
    /// Which series each row belongs to; the rows of a series are in order of time, or its reverse.
    pub series: &'a [usize],
    /// Whether rows are of several tags.
    pub is_long: bool,
    pub wording: Wording,
}

impl Context<'_> {
    /// An error about the cell of `column` at `index`.
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
