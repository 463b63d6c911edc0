//! Tables of signals in CSV.

use crate::error::{Error, Result};
use std::path::Path;

/// A CSV file with a header row, its cells kept as they were written.
///
/// Columns are separated by commas, semicolons or tabs, whichever the header has most of; decimals
/// use the point. A byte order mark is skipped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    origin: String,
    delimiter: u8,
    header: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

/// Names by which a column of times is known.
const TIME_COLUMNS: [&str; 4] = ["t", "time", "t_s", "time_s"];

impl Table {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// If it cannot be read or is not a table of at least two rows below a header.
    pub fn read(path: &Path) -> Result<Self> {
        let origin = path.display().to_string();
        match std::fs::read(path) {
            Ok(bytes) => Self::parse(&bytes, &origin),
            Err(source) => Err(Error::File { path: origin, source }),
        }
    }

    /// Reads a table from `bytes`; `origin` names it in errors.
    ///
    /// # Errors
    /// If it is not UTF-8 text with a header of distinct names and at least two rows of as many
    /// cells, or its times, where it has them, do not ascend.
    pub fn parse(bytes: &[u8], origin: &str) -> Result<Self> {
        let wrong = |message: String| Error::Table { origin: origin.to_owned(), message };
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
            wrong(format!("line {line} is not UTF-8 text; save the file as CSV in UTF-8"))
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let first = text.lines().next().unwrap_or("");
        if first.trim().is_empty() {
            return Err(wrong(
                "is empty; a header row and at least two rows are needed".to_owned(),
            ));
        }
        let count = |d: &u8| first.bytes().filter(|b| b == d).count();
        // The comma where there is no other: max_by_key keeps the last of equals.
        let delimiter = [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',');
        let mut reader =
            csv::ReaderBuilder::new().delimiter(delimiter).from_reader(text.as_bytes());
        let ragged = |e: csv::Error| match e.kind() {
            csv::ErrorKind::UnequalLengths { pos, expected_len, len } => wrong(format!(
                "row {} has {len} cells, but the header has {expected_len} columns",
                pos.as_ref().map_or(0, csv::Position::line)
            )),
            _ => wrong(e.to_string()),
        };
        let header: Vec<String> =
            reader.headers().map_err(&ragged)?.iter().map(|name| name.trim().to_owned()).collect();
        for (i, name) in header.iter().enumerate() {
            if header[..i].contains(name) {
                return Err(wrong(format!("has two columns named \"{name}\"; rename one")));
            }
        }
        if header.iter().all(|name| name.parse::<f64>().is_ok()) {
            return Err(wrong(format!(
                "row 1 must name the columns, but reads \"{first}\"; add a header such as \"t,u\""
            )));
        }
        let rows = reader.records().collect::<std::result::Result<Vec<_>, _>>().map_err(ragged)?;
        if rows.len() < 2 {
            return Err(wrong(format!(
                "has {} below its header; a signal needs at least two",
                if rows.is_empty() { "no row" } else { "one row" }
            )));
        }
        let table = Self { origin: origin.to_owned(), delimiter, header, rows };
        table.check_times()?;
        Ok(table)
    }

    /// The times must ascend, where there are numeric ones.
    fn check_times(&self) -> Result<()> {
        let Some(name) = self.header.iter().find(|name| is_time(name)) else { return Ok(()) };
        let times = self.column(name)?;
        match times.windows(2).position(|pair| !(pair[0] < pair[1])) {
            None => Ok(()),
            Some(i) => Err(self.cell(
                i + 1,
                name,
                format!(
                    "the time {} does not come after {}; sort the rows and remove duplicates",
                    times[i + 1],
                    times[i]
                ),
            )),
        }
    }

    /// An error about the cell in data row `index`, counted from 0.
    fn cell(&self, index: usize, column: &str, message: String) -> Error {
        let row = self.rows[index].position().map_or(index + 2, |p| p.line() as usize);
        Error::Cell { origin: self.origin.clone(), row, column: column.to_owned(), message }
    }

    /// Names of the columns.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Number of rows below the header.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no rows; never so for a table that was read.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The numbers in the column called `name`.
    ///
    /// # Errors
    /// If there is no such column, or a cell is empty, not a number, NaN or infinite.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        let Some(index) = self.header.iter().position(|n| n == name) else {
            return Err(Error::Table {
                origin: self.origin.clone(),
                message: format!(
                    "has no column \"{name}\"; its columns are {}",
                    self.header.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ")
                ),
            });
        };
        let number = |(i, row): (usize, &csv::StringRecord)| {
            let cell = row.get(index).unwrap_or("").trim();
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ if cell.is_empty() => {
                    Err(self.cell(i, name, "is empty, but a number is needed".to_owned()))
                }
                _ => Err(self.cell(i, name, format!("\"{cell}\" is not a finite number"))),
            }
        };
        self.rows.iter().enumerate().map(number).collect()
    }

    /// The table with one more column, as CSV text. Numbers are written so that they read back the
    /// same.
    ///
    /// # Errors
    /// If there is a column of that name already, or `values` has not one number a row.
    pub fn with_column(&self, name: &str, values: &[f64]) -> Result<String> {
        let wrong = |message: String| Error::Table { origin: self.origin.clone(), message };
        if self.header.iter().any(|n| n == name) {
            return Err(wrong(format!("has a column \"{name}\" already; rename it")));
        }
        if values.len() != self.rows.len() {
            let message = format!("has {} rows, but {} values", self.rows.len(), values.len());
            return Err(wrong(message));
        }
        let mut writer = csv::WriterBuilder::new().delimiter(self.delimiter).from_writer(vec![]);
        let io = |e: csv::Error| wrong(e.to_string());
        writer.write_record(self.header.iter().map(String::as_str).chain([name])).map_err(io)?;
        for (row, value) in self.rows.iter().zip(values) {
            let value = value.to_string();
            writer.write_record(row.iter().chain([value.as_str()])).map_err(io)?;
        }
        finish(writer).map_err(wrong)
    }
}

/// Whether a column of this name holds times.
fn is_time(name: &str) -> bool {
    TIME_COLUMNS.iter().any(|known| name.eq_ignore_ascii_case(known))
}

/// Columns of equal length as CSV text; a column without values stays empty. Numbers are written
/// so that they read back the same.
pub fn write(columns: &[(&str, Option<&[f64]>)]) -> String {
    let rows = columns.iter().filter_map(|(_, c)| c.map(<[f64]>::len)).max().unwrap_or(0);
    let mut text = columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",");
    text.push('\n');
    for row in 0..rows {
        for (i, (_, column)) in columns.iter().enumerate() {
            if i > 0 {
                text.push(',');
            }
            if let Some(value) = column.and_then(|c| c.get(row)) {
                text.push_str(&value.to_string());
            }
        }
        text.push('\n');
    }
    text
}

/// What `writer` wrote, as text.
fn finish(writer: csv::Writer<Vec<u8>>) -> std::result::Result<String, String> {
    let bytes = writer.into_inner().map_err(|e| e.to_string())?;
    String::from_utf8(bytes).map_err(|e| e.to_string())
}
