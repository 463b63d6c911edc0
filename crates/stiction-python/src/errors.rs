//! Errors of the library as Python's own.

use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyValueError};
use std::io::ErrorKind;

/// What the library refused, as `ValueError`.
pub fn refused(error: stiction::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// What reading refused: `FileNotFoundError` and `OSError` where the file is to blame, else `ValueError`.
pub fn unread(error: stiction_io::Error) -> PyErr {
    let words = match &error {
        stiction_io::Error::Setting { setting, message } => {
            format!("settings {}: {message}", setting.replace(" --set ", ", "))
        }
        _ => keywords(&error.to_string()),
    };
    match error {
        stiction_io::Error::File { source, .. } if source.kind() == ErrorKind::NotFound => {
            PyFileNotFoundError::new_err(words)
        }
        stiction_io::Error::File { .. } => PyOSError::new_err(words),
        _ => PyValueError::new_err(words),
    }
}

/// Options of the command, as the readers' messages name them, and the keywords that are meant in Python.
const KEYWORDS: [(&str, &str); 6] = [
    ("--bad-text", "bad_text"),
    ("--map", "columns"),
    ("--sample-time", "sample_time"),
    ("--time-format", "time_format"),
    ("--type", "loop_type"),
    ("--zone", "zone"),
];

/// A message that names options of the command, naming keywords instead, with the values that it gives as
/// examples: `as in --map op=COLUMN` becomes `as in columns={"op": "COLUMN"}`.
pub fn keywords(message: &str) -> String {
    let (mut out, mut rest) = (String::new(), message);
    while let Some(at) = rest.find("--") {
        let (before, from) = rest.split_at(at);
        out.push_str(before);
        let named = KEYWORDS.iter().find_map(|(option, keyword)| {
            let after = from.strip_prefix(option)?;
            let ends = !after.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '-');
            ends.then_some((*keyword, after))
        });
        let Some((keyword, after)) = named else {
            out.push_str("--");
            rest = &from[2..];
            continue;
        };
        out.push_str(keyword);
        rest = after;
        if let Some((value, after)) = example(after, before.ends_with("as in ")) {
            out.push('=');
            out.push_str(&literal(keyword, value));
            rest = after;
        }
    }
    out + rest
}

/// The example behind an option and what follows it: a quoted one, or one word if `as_in` introduces it.
fn example(after: &str, as_in: bool) -> Option<(&str, &str)> {
    let after = after.strip_prefix(' ')?;
    match after.strip_prefix('"') {
        Some(quoted) => quoted.split_once('"'),
        None if as_in => {
            let end = after.find([' ', ',', ';', ')']).unwrap_or(after.len());
            Some(after.split_at(end))
        }
        None => None,
    }
}

/// The value of a keyword as Python writes it.
fn literal(keyword: &str, value: &str) -> String {
    match (keyword, value.split_once('=')) {
        ("columns", Some((role, column))) => format!("{{\"{role}\": \"{column}\"}}"),
        ("bad_text", _) => format!("[\"{value}\"]"),
        ("sample_time", _) => value.to_owned(),
        _ => format!("\"{value}\""),
    }
}
