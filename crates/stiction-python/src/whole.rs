//! Files written whole or not at all.

use pyo3::prelude::*;
use std::path::PathBuf;

/// Writes a file whole or not at all.
#[pyfunction]
fn write_whole(path: PathBuf, bytes: &[u8]) -> PyResult<()> {
    Ok(stiction_io::whole::write(&path, bytes)?)
}

pub fn register(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(write_whole, m)?)
}
