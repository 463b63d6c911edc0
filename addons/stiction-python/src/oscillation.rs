//! Detects cycling signals.

use crate::dict::plain;
use crate::errors::refused;
use crate::long::long;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use stiction::oscillation;

/// Refuses a sample that is not finite.
pub fn all_finite(signal: &'static str, values: &[f64]) -> PyResult<()> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => {
            Err(refused(stiction::Error::NonFinite { signal, index, value: values[index] }))
        }
    }
}

/// Whether a signal oscillates.
#[pyfunction]
pub fn oscillation_of<'py>(
    py: Python<'py>,
    signal: PyReadonlyArray1<'py, f64>,
    sample_time: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let signal = signal.as_slice()?.to_vec();
    all_finite("signal", &signal)?;
    let found = long(py, None, move |_| oscillation::analyse(&signal, sample_time))?;
    plain(py, &found)
}
