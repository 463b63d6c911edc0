//! Files written whole or not at all.

use pyo3::prelude::*;
use std::path::PathBuf;

/// Writes a file whole or not at all.
#[pyfunction]
pub fn write_whole(path: PathBuf, bytes: &[u8]) -> PyResult<()> {
    Ok(stiction_io::whole::write(&path, bytes)?)
}
