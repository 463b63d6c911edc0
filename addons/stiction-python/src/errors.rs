//! Converts errors of the library to Python's.

use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyValueError};
use std::io::ErrorKind;
use stiction_io::{Remedy, Wording};

/// A refusal of the library, as `ValueError`.
pub fn refused(error: stiction::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// An error of reading, as `FileNotFoundError` or `OSError` if the file is the cause, else as `ValueError`.
pub fn unread(error: stiction_io::Error) -> PyErr {
    let words = error.to_string();
    match error {
        stiction_io::Error::File { source, .. } if source.kind() == ErrorKind::NotFound => {
            PyFileNotFoundError::new_err(words)
        }
        stiction_io::Error::File { .. } => PyOSError::new_err(words),
        _ => PyValueError::new_err(words),
    }
}

/// A keyword with the meaning of a word, once for each possible meaning.
fn spoken(keyword: &str, word: &str, meanings: &[&str]) -> String {
    let each = meanings.iter().map(|meaning| format!("{keyword}={{{word:?}: {meaning:?}}}"));
    each.collect::<Vec<_>>().join(" or ")
}

/// Remedies as keywords of the package's functions, such as `columns={"op": "COLUMN"}`.
pub const KEYWORDS: Wording = Wording(|remedy| {
    let value = remedy.value();
    match remedy {
        Remedy::Map { role, column } => {
            let column = column.as_deref().unwrap_or("COLUMN");
            format!("columns={{{role:?}: {column:?}}}")
        }
        Remedy::BadText(words) => format!("bad_text={words:?}"),
        Remedy::Part(name) => format!("part={name:?}"),
        Remedy::DecimalMark(_) => format!("decimal_mark={value:?}"),
        Remedy::Mode { word, modes: meanings } => spoken("modes", word, meanings),
        Remedy::Quality { word, qualities: meanings } => spoken("qualities", word, meanings),
        Remedy::SampleTime(_) => format!("sample_time={value}"),
        Remedy::Range { .. } => format!("{}=({})", remedy.option(), value.replace(',', ", ")),
        Remedy::TimeFormat(ways) if !ways.is_empty() => {
            let written: Vec<_> = ways.iter().map(|way| format!("{way:?}")).collect();
            let between = if ways.len() == 1 { '=' } else { ' ' };
            format!("time_format{between}{}", written.join(" or "))
        }
        Remedy::Zone(Some(zone)) => format!("zone={zone:?}"),
        Remedy::Date(Some(day)) => format!("date={day:?}"),
        _ => remedy.option().to_owned(),
    }
});
