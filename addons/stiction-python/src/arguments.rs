//! Checks the arguments of classes, by name. Arguments of functions are checked by `stiction._arguments`.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// A real number.
pub fn number(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    value.extract().map_err(|_| mismatch(name, value, "a number"))
}

/// A finite number.
pub fn finite(name: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let number = number(name, value)?;
    if number.is_finite() {
        return Ok(number);
    }
    Err(PyValueError::new_err(format!("{name} is {number}, but must be a finite number")))
}

/// An error that `name` is not `what` it must be.
pub fn mismatch(name: &str, value: &Bound<'_, PyAny>, what: &str) -> PyErr {
    match value.get_type().name() {
        Ok(found) => {
            PyTypeError::new_err(format!("{name} must be {what}, but its type is {found}"))
        }
        Err(error) => error,
    }
}
