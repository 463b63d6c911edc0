//! `stiction._core` provides the library's functions to the Python package, one file per part.
//!
//! Classes hold a state or a handle. Functions return dictionaries of plain values and NumPy arrays, which
//! `python/stiction` turns into typed results. Nothing is computed here.

mod arguments;
mod arrays;
mod bands;
mod bench;
mod closed_loop;
mod compensate;
mod detect;
mod diagnosis;
mod dict;
mod errors;
mod fit;
mod fmu;
mod identification;
mod limit_cycle;
mod long;
mod oscillation;
mod own;
mod plant;
mod plant_table;
mod pool;
mod population;
mod recordings;
mod series;
mod stem;
mod table;
mod valve;
mod valve_test;
mod what_if;
mod whole;

use pyo3::prelude::*;

/// The compiled part of the package `stiction`; use the package.
#[pymodule(name = "_core")]
fn core(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    arrays::register(m)?;
    bands::register(m)?;
    bench::register(m)?;
    population::register(m)?;
    compensate::register(m)?;
    limit_cycle::register(m)?;
    detect::register(m)?;
    diagnosis::register(m)?;
    fit::register(m)?;
    fmu::register(m)?;
    identification::register(m)?;
    oscillation::register(m)?;
    own::register(m)?;
    plant::register(m)?;
    recordings::register(m)?;
    closed_loop::register(m)?;
    series::register(m)?;
    stem::register(m)?;
    table::register(m)?;
    valve::register(m)?;
    valve_test::register(m)?;
    what_if::register(m)?;
    whole::register(m)?;
    // The package defines what is public.
    m.delattr("__all__")
}
