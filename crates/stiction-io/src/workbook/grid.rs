//! The cells of a sheet, as text for the reader of tables and as numbers and times.

use crate::budget::Budget;
use crate::sheet::{Cells, Column, Sheet};
use calamine::{CellErrorType, Data};
use jiff::civil::DateTime;
use std::fmt::Write;
use std::sync::Arc;

const DAY: f64 = 86_400.0;

/// Serial numbers of 1970-01-01 by the two ways to count days.
const SINCE_1900: f64 = 25_569.0;
const SINCE_1904: f64 = 24_107.0;

/// A serial number below a year is a time of day or a duration, and no date.
const NO_DATE: f64 = 366.0;

/// Number of rows that a sheet can have.
const MOST_ROWS: u32 = 1 << 20;

/// A cell.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) enum Cell {
    #[default]
    Empty,
    Number(f64),
    Text(Arc<str>),
    /// A date and time in s since 1970-01-01, local.
    Stamp(f64),
    /// A time of day or a duration, s.
    Clock(f64),
    /// A time that can only be a duration, s.
    Duration(f64),
}

impl Cell {
    fn of(value: Data, is_1904: bool) -> Self {
        match value {
            Data::Empty => Self::Empty,
            Data::Int(number) => Self::Number(number as f64),
            Data::Float(number) => Self::Number(number),
            Data::Bool(true) => Self::Text("TRUE".into()),
            Data::Bool(false) => Self::Text("FALSE".into()),
            Data::String(text) => Self::text(&text),
            Data::DateTime(serial) => {
                let zero = if is_1904 { SINCE_1904 } else { SINCE_1900 };
                let days = serial.as_f64();
                match serial.is_duration() {
                    true => Self::Duration(rounded(days * DAY)),
                    false if (0.0..NO_DATE).contains(&days) => Self::Clock(rounded(days * DAY)),
                    false => Self::Stamp(rounded((days - zero) * DAY)),
                }
            }
            Data::DateTimeIso(text) => match text.parse::<DateTime>() {
                Ok(time) => {
                    let since = time.duration_since(DateTime::constant(1970, 1, 1, 0, 0, 0, 0));
                    Self::Stamp(rounded(since.as_secs_f64()))
                }
                Err(_) => Self::text(&text),
            },
            Data::DurationIso(text) => match text.parse::<jiff::SignedDuration>() {
                Ok(duration) => Self::Clock(rounded(duration.as_secs_f64())),
                Err(_) => Self::text(&text),
            },
            Data::Error(CellErrorType::Div0) => Self::Text("#DIV/0!".into()),
            Data::Error(CellErrorType::Num) => Self::Text("#NUM!".into()),
            Data::Error(CellErrorType::NA | CellErrorType::GettingData) => {
                Self::Text("#N/A".into())
            }
            Data::Error(_) => Self::Text("#VALUE!".into()),
        }
    }

    /// Text on one line.
    fn text(text: &str) -> Self {
        let line = text.replace(|c: char| c.is_control(), " ");
        match line.trim() {
            "" => Self::Empty,
            line => Self::Text(line.into()),
        }
    }

    /// The cell in a CSV file, with all its digits.
    fn written(&self) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Text(text) => text.to_string(),
            Self::Number(number) => {
                let mut written = number.to_string();
                // A point before exactly three digits could be a mark of thousands.
                if written.split_once('.').is_some_and(|(_, decimals)| decimals.len() == 3) {
                    written.push('0');
                }
                written
            }
            Self::Stamp(seconds) => {
                let (days, time) = (seconds.div_euclid(DAY), seconds.rem_euclid(DAY));
                let day = jiff::Timestamp::from_second((days * DAY) as i64)
                    .map(|midnight| midnight.to_zoned(jiff::tz::TimeZone::UTC).date().to_string());
                let Ok(day) = day else { return seconds.to_string() };
                match time {
                    0.0 => day,
                    time => format!("{day} {}", clock(time)),
                }
            }
            Self::Clock(seconds) | Self::Duration(seconds) => clock(*seconds),
        }
    }
}

/// Days in floating point cannot hold every second, so times are rounded to milliseconds.
fn rounded(seconds: f64) -> f64 {
    (seconds * 1000.0).round() / 1000.0
}

/// Hours, minutes and seconds.
fn clock(seconds: f64) -> String {
    let milliseconds = (seconds.abs() * 1000.0).round() as u64;
    let (whole, rest) = (milliseconds / 1000, milliseconds % 1000);
    let sign = if seconds < 0.0 { "-" } else { "" };
    let mut written = format!("{sign}{:02}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
    if rest > 0 {
        write!(written, ".{rest:03}").expect("text grows");
    }
    written
}

/// The cells of a sheet by row and column, from 0. The rows end at their last cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub rows: Vec<Vec<Cell>>,
    is_1904: bool,
}

impl Grid {
    pub fn new(is_1904: bool) -> Self {
        Self { rows: vec![], is_1904 }
    }

    /// Whether it has no cells.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The cell at a place.
    pub fn get(&self, row: usize, column: usize) -> &Cell {
        self.rows.get(row).and_then(|row| row.get(column)).unwrap_or(&Cell::Empty)
    }

    /// Sets a cell.
    ///
    /// # Errors
    /// If that would take too much memory.
    pub fn set(
        &mut self,
        (row, column): (u32, u32),
        value: Data,
        budget: &mut Budget,
    ) -> Result<(), String> {
        let cell = Cell::of(value, self.is_1904);
        if cell == Cell::Empty {
            return Ok(());
        }
        if row >= MOST_ROWS {
            return Err(super::unread(format_args!("it has a cell in row {row}")));
        }
        let (row, column) = (row as usize, column as usize);
        let more_rows = (row + 1).saturating_sub(self.rows.len());
        let length = self.rows.get(row).map_or(0, Vec::len);
        let more_cells = (column + 1).saturating_sub(length);
        let text = if let Cell::Text(text) = &cell { text.len() } else { 0 };
        // A cell is kept once as it is, and once as text.
        let bytes = more_rows * size_of::<Vec<Cell>>() + more_cells * 2 * size_of::<Cell>();
        budget.spend(bytes + 2 * text).map_err(|message| format!("row {} {message}", row + 1))?;
        self.place(row, column, cell);
        Ok(())
    }

    /// Sets a cell, whatever memory it takes.
    pub fn place(&mut self, row: usize, column: usize, cell: Cell) {
        if self.rows.len() <= row {
            self.rows.resize(row + 1, vec![]);
        }
        let cells = &mut self.rows[row];
        if cells.len() <= column {
            cells.resize(column + 1, Cell::Empty);
        }
        cells[column] = cell;
    }

    /// The sheet as CSV with tabs. The line of a row is its number. All rows but empty ones have the same number of
    /// tabs, so that no other delimiter is found.
    pub fn text(&self) -> String {
        let width = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let mut text = String::new();
        for row in &self.rows {
            if row.iter().any(|cell| *cell != Cell::Empty) {
                for column in 0..width {
                    let cell = row.get(column).unwrap_or(&Cell::Empty).written();
                    match cell.contains('"') {
                        true => write!(text, "\"{}\"", cell.replace('"', "\"\"")),
                        false => write!(text, "{cell}"),
                    }
                    .expect("text grows");
                    text.push('\t');
                }
            }
            text.push('\n');
        }
        text
    }

    /// Replaces the text of numbers and times in a table read from [`Grid::text`] by numbers and times. Notes name the
    /// columns without values.
    pub fn restore(&self, sheet: &mut Sheet) -> Vec<String> {
        let width = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let (mut notes, mut next) = (vec![], 0);
        let rows: Vec<usize> = sheet.rows.iter().map(|line| line.saturating_sub(1)).collect();
        for column in &mut sheet.columns {
            let Cells::Text(texts) = &column.cells else { continue };
            let texts = texts.view();
            let is_same = |place: &usize| {
                let mut both = rows.iter().zip(texts.iter());
                both.all(|(row, text)| *self.get(*row, *place).written() == *text)
            };
            // Columns without names and cells are no part of the table.
            let Some(place) = (next..width).find(is_same) else { continue };
            next = place + 1;
            if texts.iter().all(str::is_empty) {
                notes.push(format!(
                    "\"{}\" has no values; if it has formulas, calculate and save them in a spreadsheet program",
                    column.name
                ));
                continue;
            }
            let cells: Vec<&Cell> = rows.iter().map(|row| self.get(*row, place)).collect();
            if let Some(exact) = exact(&cells, column) {
                column.cells = exact;
            }
        }
        notes
    }
}

/// The cells of a column as numbers or times, if all are.
fn exact(cells: &[&Cell], column: &mut Column) -> Option<Cells> {
    let present = || cells.iter().filter(|cell| ***cell != Cell::Empty);
    let values = || {
        let value = |cell: &&Cell| match **cell {
            Cell::Number(value)
            | Cell::Stamp(value)
            | Cell::Clock(value)
            | Cell::Duration(value) => value,
            Cell::Empty | Cell::Text(_) => f64::NAN,
        };
        cells.iter().map(value).collect::<Vec<f64>>()
    };
    if present().all(|cell| matches!(cell, Cell::Number(_))) {
        return Some(Cells::Numbers(values()));
    }
    if present().all(|cell| matches!(cell, Cell::Stamp(_))) {
        // Days alone may have their times of day in another column.
        let is_day = |cell: &&&Cell| matches!(***cell, Cell::Stamp(time) if time % DAY == 0.0);
        return (!present().all(|cell| is_day(&cell)))
            .then(|| Cells::Times { seconds: values(), utc: false });
    }
    let is_elapsed = present().all(|cell| matches!(cell, Cell::Clock(_) | Cell::Duration(_)))
        && present().any(|cell| match **cell {
            Cell::Duration(_) => true,
            Cell::Clock(seconds) => seconds >= DAY,
            _ => false,
        });
    is_elapsed.then(|| {
        column.unit = Some("s".to_owned());
        Cells::Numbers(values())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use calamine::{ExcelDateTime, ExcelDateTimeType};

    fn serial(days: f64, is_1904: bool) -> Cell {
        let value = ExcelDateTime::new(days, ExcelDateTimeType::DateTime, is_1904);
        Cell::of(Data::DateTime(value), is_1904)
    }

    #[test]
    fn days_count_from_either_year() {
        let time = 1_741_932_001.0;
        assert_eq!(serial(45_730.0 + 6.0 / 24.0 + 1.0 / DAY, false), Cell::Stamp(time));
        assert_eq!(serial(45_730.0 - 1462.0 + 6.0 / 24.0 + 1.0 / DAY, true), Cell::Stamp(time));
        assert_eq!(
            Cell::of(Data::DateTimeIso("2025-03-14T06:00:01".to_owned()), false),
            Cell::Stamp(time)
        );
        assert_eq!(Cell::Stamp(time).written(), "2025-03-14 06:00:01");
        assert_eq!(Cell::Stamp(time + 0.25).written(), "2025-03-14 06:00:01.250");
        assert_eq!(serial(45_730.0, false).written(), "2025-03-14");
        assert_eq!(serial(0.25, false).written(), "06:00:00");
        assert_eq!(
            Cell::of(Data::DurationIso("PT30H00M01.5S".to_owned()), false),
            Cell::Clock(108_001.5)
        );
    }

    #[test]
    fn numbers_keep_their_bits_and_have_no_mark_of_thousands() {
        for number in [0.1 + 0.2, 1e-9, -60.0625, 1.001, 999.0, 12.345, f64::MIN_POSITIVE] {
            let written = Cell::Number(number).written();
            assert_eq!(written.parse::<f64>().unwrap().to_bits(), number.to_bits(), "{written}");
            assert_ne!(written.split_once('.').map_or(0, |(_, decimals)| decimals.len()), 3);
        }
    }

    #[test]
    fn a_cell_far_away_is_refused() {
        let mut grid = Grid::new(false);
        let mut budget = Budget::new(1 << 20);
        grid.set((0, 0), Data::Float(1.0), &mut budget).unwrap();
        let message = grid.set((900_000, 0), Data::Float(1.0), &mut budget).unwrap_err();
        assert!(message.starts_with("row 900001 would take more than 1 MiB"), "{message}");
        assert!(grid.set((u32::MAX, 0), Data::Float(1.0), &mut budget).is_err());
    }
}
