//! Tables as CSV for people.
//!
//! A spreadsheet interprets a cell that begins with `=`, `+`, `-`, `@`, a tab or a new line as a formula, and tags
//! come from foreign files. Such a text gets an apostrophe in front, but a number never does.

use std::borrow::Cow;
use std::io::{Error, ErrorKind, Result};

/// A table for people as CSV.
pub struct Sheet(csv::Writer<Vec<u8>>);

impl Sheet {
    /// A table with these columns.
    ///
    /// # Errors
    /// None is known, because the table is written to memory.
    pub fn new<T: AsRef<[u8]>>(columns: impl IntoIterator<Item = T>) -> Result<Self> {
        let mut writer = csv::Writer::from_writer(vec![]);
        writer.write_record(columns)?;
        Ok(Self(writer))
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If the row has more or fewer cells than the sheet has columns.
    pub fn row<T: AsRef<str>>(&mut self, cells: impl IntoIterator<Item = T>) -> Result<()> {
        for cell in cells {
            self.0.write_field(harmless(cell.as_ref()).as_bytes())?;
        }
        Ok(self.0.write_record(None::<&[u8]>)?)
    }

    /// The whole table as text.
    ///
    /// # Errors
    /// None is known, because the content is text.
    pub fn text(self) -> Result<String> {
        let bytes = self.0.into_inner().map_err(|e| e.into_error())?;
        String::from_utf8(bytes).map_err(|e| Error::new(ErrorKind::InvalidData, e))
    }
}

fn harmless(cell: &str) -> Cow<'_, str> {
    let is_formula = cell.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    if is_formula && cell.parse::<f64>().is_err() { format!("'{cell}").into() } else { cell.into() }
}

#[cfg(test)]
mod tests {
    use super::harmless;

    #[test]
    fn formulas_are_texts_and_numbers_stay() {
        for (cell, expected) in [
            ("=1+1", "'=1+1"),
            ("@SUM(A1)", "'@SUM(A1)"),
            ("-2+3", "'-2+3"),
            ("+FIC101", "'+FIC101"),
            ("\tx", "'\tx"),
            ("-2.5e-3", "-2.5e-3"),
            ("FIC101", "FIC101"),
            ("", ""),
        ] {
            assert_eq!(harmless(cell), expected);
        }
    }
}
