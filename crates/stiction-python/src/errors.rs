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
    let words = error.to_string();
    match error {
        stiction_io::Error::File { source, .. } if source.kind() == ErrorKind::NotFound => {
            PyFileNotFoundError::new_err(words)
        }
        stiction_io::Error::File { .. } => PyOSError::new_err(words),
        _ => PyValueError::new_err(words),
    }
}
