//! `stiction._core`: what the Python package needs of the library, one file a part of it.
//!
//! Classes are those that hold a state or a handle; functions return dictionaries of plain values and
//! NumPy arrays, of which `python/stiction` makes typed results. Nothing is computed here.

mod arguments;
mod arrays;
mod bands;
mod detectors;
mod diagnosis;
mod dict;
mod errors;
mod identification;
mod long;
mod oscillation;
mod recordings;
mod scenario;
mod table;
mod valve;

use pyo3::prelude::*;

/// The compiled part of the package `stiction`; use the package.
#[pymodule(name = "_core")]
fn core(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    arrays::register(m)?;
    bands::register(m)?;
    detectors::register(m)?;
    diagnosis::register(m)?;
    identification::register(m)?;
    oscillation::register(m)?;
    recordings::register(m)?;
    scenario::register(m)?;
    table::register(m)?;
    valve::register(m)?;
    // The package says what is public.
    m.delattr("__all__")
}
