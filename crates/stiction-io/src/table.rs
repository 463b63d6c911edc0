//! Tables of signals in CSV.

use crate::bytes;
use crate::error::{Error, Result};
use std::path::Path;

/// A CSV file with a header row, and its cells as written.
///
/// Columns are separated by commas, semicolons or tabs, by the most frequent of these in the header. The decimal mark
/// is the point. A byte order mark is skipped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    origin: String,
    delimiter: u8,
    header: Vec<String>,
    rows: Vec<csv::StringRecord>,
    /// The line of the file on which each row begins, from 1.
    lines: Vec<usize>,
}

/// Names of columns of times.
const TIME_COLUMNS: [&str; 4] = ["t", "time", "t_s", "time_s"];

impl Table {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// If the file cannot be read, or is not a table with a header and at least one row.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&bytes::read(path)?, &path.display().to_string())
    }

    /// Reads a table from `bytes`; `origin` is its name in errors.
    ///
    /// # Errors
    /// If the bytes are not UTF-8 text, the header's names are not distinct, no row follows, a row has more or fewer
    /// cells than the header, or the times do not ascend.
    pub fn parse(bytes: &[u8], origin: &str) -> Result<Self> {
        let wrong = |message: String| Error::Table { origin: origin.to_owned(), message };
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
            wrong(format!("line {line} is not UTF-8 text; save the file as CSV in UTF-8"))
        })?;
        // The CSV reader skips a byte order mark by itself.
        let shown = text.strip_prefix('\u{feff}').unwrap_or(text);
        let first = shown.lines().find(|line| !line.is_empty()).unwrap_or("");
        if first.trim().is_empty() {
            return Err(wrong(
                "is empty; a header row and at least two rows are needed".to_owned(),
            ));
        }
        let delimiter = delimiter(first);
        let mut reader =
            csv::ReaderBuilder::new().delimiter(delimiter).from_reader(text.as_bytes());
        let header: Vec<String> = reader
            .headers()
            .map_err(|e| wrong(e.to_string()))?
            .iter()
            .map(|name| name.trim().to_owned())
            .collect();
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
        let mut records = RecordLines { text: text.as_bytes(), at: 0, line: 1 };
        let (mut rows, mut lines) = (vec![], vec![]);
        for row in reader.records() {
            let row = row.map_err(|e| match e.kind() {
                csv::ErrorKind::UnequalLengths { pos, expected_len, len } => wrong(format!(
                    "row {} has {len} cells, but the header has {expected_len} columns; give every \
                     row the same number of cells",
                    records.line(pos.as_ref())
                )),
                _ => wrong(e.to_string()),
            })?;
            lines.push(records.line(row.position()));
            rows.push(row);
        }
        if rows.is_empty() {
            return Err(wrong(
                "has no row below its header; add at least two rows (one for an index)".to_owned(),
            ));
        }
        let table = Self { origin: origin.to_owned(), delimiter, header, rows, lines };
        table.check_times()?;
        Ok(table)
    }

    /// Checks that the times, if any, are ascending numbers.
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

    /// An error on the cell in data row `index`, counted from 0.
    fn cell(&self, index: usize, column: &str, message: String) -> Error {
        let row = self.lines[index];
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

    /// Whether there are no rows. A table that was read always has rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The numbers in the column called `name`.
    ///
    /// # Errors
    /// If there is no such column, a cell is empty, not a number, NaN or infinite, or there are less than two.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        let index = self.index(name)?;
        if self.rows.len() < 2 {
            let message = "has one row below its header; add at least one row".to_owned();
            return Err(Error::Table { origin: self.origin.clone(), message });
        }
        let number = |(i, row): (usize, &csv::StringRecord)| {
            let cell = row.get(index).unwrap_or("").trim();
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ if cell.is_empty() => {
                    Err(self.cell(i, name, "is empty; a number is needed".to_owned()))
                }
                _ => {
                    let example = "write numbers like 1.5 or 2e-3";
                    Err(self.cell(i, name, format!("\"{cell}\" is not a finite number; {example}")))
                }
            }
        };
        self.rows.iter().enumerate().map(number).collect()
    }

    /// The cells of the column called `name` as written, without surrounding blanks.
    ///
    /// # Errors
    /// If there is no such column.
    pub fn texts(&self, name: &str) -> Result<Vec<String>> {
        let index = self.index(name)?;
        Ok(self.rows.iter().map(|row| row.get(index).unwrap_or("").trim().to_owned()).collect())
    }

    /// The line of the file with the data row `index`, counted from 0; 0 if there is none.
    pub fn line(&self, index: usize) -> usize {
        self.lines.get(index).copied().unwrap_or(0)
    }

    /// The place of the column called `name`.
    fn index(&self, name: &str) -> Result<usize> {
        self.header.iter().position(|n| n == name).ok_or_else(|| Error::Table {
            origin: self.origin.clone(),
            message: format!(
                "has no column \"{name}\"; its columns are {}",
                self.header.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ")
            ),
        })
    }

    /// The table with one more column, as CSV text. Numbers are written so that reading gives the same values.
    ///
    /// # Errors
    /// If a column of this name exists, or `values` does not have one number per row.
    pub fn with_column(&self, name: &str, values: &[f64]) -> Result<String> {
        let wrong = |message: String| Error::Table { origin: self.origin.clone(), message };
        if self.header.iter().any(|n| n == name) {
            return Err(wrong(format!("has a column \"{name}\" already; rename it")));
        }
        if values.len() != self.rows.len() {
            let (rows, values) = (self.rows.len(), values.len());
            let message = format!("has {rows} rows, but {values} values; give one value per row");
            return Err(wrong(message));
        }
        let separator = char::from(self.delimiter).to_string();
        let header = self.header.iter().map(String::as_str).chain([name]).map(quoted);
        let header = header.collect::<Vec<_>>().join(&separator) + "\n";
        let mut writer =
            csv::WriterBuilder::new().delimiter(self.delimiter).from_writer(header.into_bytes());
        let io = |e: csv::Error| wrong(e.to_string());
        for (row, value) in self.rows.iter().zip(values) {
            let value = value.to_string();
            writer.write_record(row.iter().chain([value.as_str()])).map_err(io)?;
        }
        finish(writer).map_err(wrong)
    }
}

/// Finds the lines on which records of a text begin. The reader's own count stops before line breaks and blank lines
/// that precede a record.
struct RecordLines<'t> {
    text: &'t [u8],
    at: usize,
    line: usize,
}

impl RecordLines<'_> {
    /// The line, from 1, of the record at `position`. Records must be in order.
    fn line(&mut self, position: Option<&csv::Position>) -> usize {
        let start = position.map_or(self.at, |position| position.byte() as usize);
        let ends = self.text[start..].iter().take_while(|b| matches!(**b, b'\r' | b'\n')).count();
        let passed = &self.text[self.at..start + ends];
        self.line += passed.iter().filter(|b| **b == b'\n').count();
        self.at = start + ends;
        self.line
    }
}

/// The delimiter of a `header`: the most frequent of comma, semicolon and tab outside quotes; the comma if there is
/// none.
fn delimiter(header: &str) -> u8 {
    let bare = || header.split('"').step_by(2).flat_map(str::bytes);
    // max_by_key keeps the last of equals.
    [b'\t', b';', b',']
        .into_iter()
        .max_by_key(|d| bare().filter(|b| b == d).count())
        .unwrap_or(b',')
}

/// `name` in quotes if, without them, it could be mistaken for several columns or a byte order mark.
fn quoted(name: &str) -> std::borrow::Cow<'_, str> {
    if name.contains([',', ';', '\t', '"', '\r', '\n', '\u{feff}']) {
        format!("\"{}\"", name.replace('"', "\"\"")).into()
    } else {
        name.into()
    }
}

/// Whether a column of this name holds times.
fn is_time(name: &str) -> bool {
    TIME_COLUMNS.iter().any(|known| name.eq_ignore_ascii_case(known))
}

/// The times of samples, rounded to a millionth of a sample, so that 0.3 is not 0.30000000000000004.
pub fn times(sample_time: f64, samples: usize) -> Vec<f64> {
    let digits = (6.0 - sample_time.log10()).ceil().max(0.0);
    // Beyond these digits the rounding of floating-point numbers is finer.
    let unit = (digits <= 15.0).then(|| 10f64.powf(digits));
    let time = |k| {
        let t = k as f64 * sample_time;
        unit.map_or(t, |unit| (t * unit).round() / unit)
    };
    (0..samples).map(time).collect()
}

/// Columns of equal length as CSV text. A column without values stays empty. Numbers are written so that reading
/// gives the same values.
pub fn write(columns: &[(&str, Option<&[f64]>)]) -> String {
    let columns: Vec<_> = columns
        .iter()
        .map(|(name, values)| (*name, values.map_or(Cells::Empty, Cells::Numbers)))
        .collect();
    write_cells(&columns)
}

/// The cells of a column, from the first row on.
#[derive(Debug, Clone, Copy)]
pub enum Cells<'a> {
    /// None.
    Empty,
    /// Numbers.
    Numbers(&'a [f64]),
    /// Words without commas, quotes or line ends.
    Words(&'a [&'a str]),
}

impl Cells<'_> {
    fn len(self) -> usize {
        match self {
            Self::Empty => 0,
            Self::Numbers(values) => values.len(),
            Self::Words(words) => words.len(),
        }
    }

    fn push_onto(self, text: &mut String, row: usize) {
        match self {
            Self::Empty => {}
            Self::Numbers(values) => {
                if let Some(value) = values.get(row) {
                    text.push_str(&value.to_string());
                }
            }
            Self::Words(words) => text.push_str(words.get(row).copied().unwrap_or_default()),
        }
    }
}

/// Like [`write()`], with columns of numbers or words.
pub fn write_cells(columns: &[(&str, Cells<'_>)]) -> String {
    let rows = columns.iter().map(|(_, cells)| cells.len()).max().unwrap_or(0);
    let mut text = columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",");
    text.push('\n');
    for row in 0..rows {
        for (i, (_, cells)) in columns.iter().enumerate() {
            if i > 0 {
                text.push(',');
            }
            cells.push_onto(&mut text, row);
        }
        text.push('\n');
    }
    text
}

/// The output of `writer` as text.
fn finish(writer: csv::Writer<Vec<u8>>) -> std::result::Result<String, String> {
    let bytes = writer.into_inner().map_err(|e| e.to_string())?;
    String::from_utf8(bytes).map_err(|e| e.to_string())
}
