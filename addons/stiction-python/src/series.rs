//! Crossings and trends of series.

use crate::dict::dict;
use crate::errors::refused;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::closed_loop::period;
use stiction::population;
use stiction::series::{self, Direction};
use stiction::{Error, Result};

type In<'py> = PyReadonlyArray1<'py, f64>;
type Out<'py> = PyResult<Bound<'py, PyArray1<f64>>>;

/// The samples of a series, checked to exist and to be finite.
pub fn finite<'a>(signal: &'static str, x: &'a In<'_>) -> PyResult<&'a [f64]> {
    let x = x.as_slice()?;
    let checked = || -> Result<()> {
        if x.is_empty() {
            return Err(Error::Length { name: signal, found: 0, expected: 1 });
        }
        match x.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(index) => Err(Error::NonFinite { signal, index, value: x[index] }),
        }
    };
    checked().map(|()| x).map_err(refused)
}

#[pyfunction]
pub fn zero_crossings<'py>(py: Python<'py>, x: In<'py>) -> PyResult<Bound<'py, PyDict>> {
    let found = series::zero_crossings(finite("x", &x)?);
    Ok(dict!(py,
        "place": PyArray1::from_iter(py, found.iter().map(|c| c.place)),
        "next": PyArray1::from_iter(py, found.iter().map(|c| c.next as i64)),
        "upward": PyArray1::from_iter(py, found.iter().map(|c| c.direction == Direction::Up)),
    ))
}

#[pyfunction]
pub fn half_waves<'py>(py: Python<'py>, x: In<'py>) -> PyResult<Bound<'py, PyDict>> {
    let found = series::half_waves(finite("x", &x)?);
    Ok(dict!(py,
        "begin": PyArray1::from_iter(py, found.iter().map(|w| w.from)),
        "end": PyArray1::from_iter(py, found.iter().map(|w| w.to)),
        "length": PyArray1::from_iter(py, found.iter().map(|w| w.length())),
        "first": PyArray1::from_iter(py, found.iter().map(|w| w.first as i64)),
        "stop": PyArray1::from_iter(py, found.iter().map(|w| w.end as i64)),
        "above": PyArray1::from_iter(py, found.iter().map(|w| w.above)),
    ))
}

#[pyfunction]
pub fn reversals(x: In<'_>, band: f64) -> PyResult<usize> {
    Ok(series::reversals(finite("x", &x)?, band))
}

#[pyfunction]
pub fn cycle_period(x: In<'_>, sample_time: f64, noise_band: f64) -> PyResult<Option<f64>> {
    period(finite("x", &x)?, sample_time, noise_band).map_err(refused)
}

#[pyfunction]
pub fn swinging_door<'py>(py: Python<'py>, x: In<'py>, deviation: f64) -> Out<'py> {
    Ok(PyArray1::from_vec(py, population::swinging_door(finite("x", &x)?, deviation)))
}

#[pyfunction]
pub fn mann_kendall(py: Python<'_>, y: In<'_>) -> PyResult<f64> {
    let y = finite("y", &y)?;
    Ok(py.detach(|| series::mann_kendall(y)))
}

#[pyfunction]
pub fn difference_of_means(py: Python<'_>, a: In<'_>, b: In<'_>) -> PyResult<Option<f64>> {
    let (a, b) = (finite("a", &a)?, finite("b", &b)?);
    Ok(py.detach(|| series::difference_of_means(a, b)))
}
