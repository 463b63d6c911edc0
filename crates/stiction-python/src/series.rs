//! Moments, correlation, spectra, crossings and trends of series.

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

/// The samples of a series, if there is one and all are finite.
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

/// The samples of a series that goes with one of `expected` samples.
fn paired<'a>(signal: &'static str, x: &'a In<'_>, expected: usize) -> PyResult<&'a [f64]> {
    let x = finite(signal, x)?;
    if x.len() == expected {
        return Ok(x);
    }
    Err(refused(Error::Length { name: signal, found: x.len(), expected }))
}

#[pyfunction]
fn moments<'py>(py: Python<'py>, x: In<'py>) -> PyResult<Bound<'py, PyDict>> {
    let x = finite("x", &x)?;
    Ok(dict!(py,
        "mean": series::mean(x),
        "variance": series::variance(x),
        "std": series::std(x),
        "skewness": series::skewness(x),
        "excess_kurtosis": series::excess_kurtosis(x),
        "median": series::median(x),
        "median_absolute_deviation": series::median_absolute_deviation(x),
        "noise_std": series::noise_std(x),
        "span": series::span(x),
    ))
}

#[pyfunction]
fn autocorrelation<'py>(
    py: Python<'py>,
    x: In<'py>,
    max_lag: usize,
) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
    let x = finite("x", &x)?;
    Ok(py.detach(|| series::autocorrelation(x, max_lag)).map(|r| PyArray1::from_vec(py, r)))
}

#[pyfunction]
fn correlation(x: In<'_>, y: In<'_>) -> PyResult<Option<f64>> {
    let x = finite("x", &x)?;
    Ok(series::correlation(x, paired("y", &y, x.len())?))
}

#[pyfunction]
fn cross_correlation<'py>(
    py: Python<'py>,
    u: In<'py>,
    y: In<'py>,
    max_lag: usize,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let u = finite("u", &u)?;
    let y = paired("y", &y, u.len())?;
    let Some(found) = py.detach(|| series::cross_correlation(u, y, max_lag)) else {
        return Ok(None);
    };
    Ok(Some(dict!(py,
        "values": PyArray1::from_vec(py, found.values),
        "max_lag": found.max_lag,
    )))
}

#[pyfunction]
fn periodogram<'py>(py: Python<'py>, x: In<'py>) -> PyResult<Bound<'py, PyDict>> {
    let x = finite("x", &x)?;
    let found = py.detach(|| series::periodogram(x));
    Ok(dict!(py,
        "frequency": PyArray1::from_vec(py, found.frequency),
        "power": PyArray1::from_vec(py, found.power),
    ))
}

#[pyfunction]
fn zero_crossings<'py>(py: Python<'py>, x: In<'py>) -> PyResult<Bound<'py, PyDict>> {
    let found = series::zero_crossings(finite("x", &x)?);
    Ok(dict!(py,
        "place": PyArray1::from_iter(py, found.iter().map(|c| c.place)),
        "next": PyArray1::from_iter(py, found.iter().map(|c| c.next as i64)),
        "upward": PyArray1::from_iter(py, found.iter().map(|c| c.direction == Direction::Up)),
    ))
}

#[pyfunction]
fn half_waves<'py>(py: Python<'py>, x: In<'py>) -> PyResult<Bound<'py, PyDict>> {
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
fn reversals(x: In<'_>, band: f64) -> PyResult<usize> {
    Ok(series::reversals(finite("x", &x)?, band))
}

#[pyfunction]
fn cycle_period(x: In<'_>, sample_time: f64, noise_band: f64) -> PyResult<Option<f64>> {
    period(finite("x", &x)?, sample_time, noise_band).map_err(refused)
}

#[pyfunction]
fn decimated<'py>(py: Python<'py>, x: In<'py>, factor: usize) -> Out<'py> {
    Ok(PyArray1::from_vec(py, series::decimated(finite("x", &x)?, factor)))
}

#[pyfunction]
fn detrended<'py>(py: Python<'py>, x: In<'py>) -> Out<'py> {
    Ok(PyArray1::from_vec(py, series::detrended(finite("x", &x)?)))
}

#[pyfunction]
fn low_passed<'py>(py: Python<'py>, x: In<'py>, cutoff: f64) -> Out<'py> {
    let x = finite("x", &x)?;
    Ok(PyArray1::from_vec(py, py.detach(|| series::low_passed(x, cutoff))))
}

#[pyfunction]
fn band_passed<'py>(py: Python<'py>, x: In<'py>, low: f64, high: f64) -> Out<'py> {
    let x = finite("x", &x)?;
    Ok(PyArray1::from_vec(py, py.detach(|| series::band_passed(x, low, high))))
}

#[pyfunction]
fn swinging_door<'py>(py: Python<'py>, x: In<'py>, deviation: f64) -> Out<'py> {
    Ok(PyArray1::from_vec(py, population::swinging_door(finite("x", &x)?, deviation)))
}

#[pyfunction]
fn theil_sen(py: Python<'_>, x: In<'_>, y: In<'_>) -> PyResult<Option<f64>> {
    let x = finite("x", &x)?;
    let y = paired("y", &y, x.len())?;
    Ok(py.detach(|| series::theil_sen(x, y)))
}

#[pyfunction]
fn mann_kendall(py: Python<'_>, y: In<'_>) -> PyResult<f64> {
    let y = finite("y", &y)?;
    Ok(py.detach(|| series::mann_kendall(y)))
}

#[pyfunction]
fn weighted_trend<'py>(
    py: Python<'py>,
    x: In<'py>,
    y: In<'py>,
    weights: In<'py>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let x = finite("x", &x)?;
    let (y, weights) = (paired("y", &y, x.len())?, paired("weights", &weights, x.len())?);
    let Some(found) = series::weighted_trend(x, y, weights) else { return Ok(None) };
    Ok(Some(dict!(py,
        "slope": found.slope,
        "low": found.low,
        "high": found.high,
        "p_value": found.p_value,
    )))
}

#[pyfunction]
fn difference_of_means(py: Python<'_>, a: In<'_>, b: In<'_>) -> PyResult<Option<f64>> {
    let (a, b) = (finite("a", &a)?, finite("b", &b)?);
    Ok(py.detach(|| series::difference_of_means(a, b)))
}

#[pyfunction]
fn welch(a: In<'_>, b: In<'_>) -> PyResult<Option<f64>> {
    Ok(series::welch(finite("a", &a)?, finite("b", &b)?))
}

#[pyfunction]
fn cliffs_delta(py: Python<'_>, a: In<'_>, b: In<'_>) -> PyResult<f64> {
    let (a, b) = (finite("a", &a)?, finite("b", &b)?);
    Ok(py.detach(|| series::cliffs_delta(a, b)))
}

pub fn register(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_function(wrap_pyfunction!(moments, m)?)?;
    m.add_function(wrap_pyfunction!(autocorrelation, m)?)?;
    m.add_function(wrap_pyfunction!(correlation, m)?)?;
    m.add_function(wrap_pyfunction!(cross_correlation, m)?)?;
    m.add_function(wrap_pyfunction!(periodogram, m)?)?;
    m.add_function(wrap_pyfunction!(zero_crossings, m)?)?;
    m.add_function(wrap_pyfunction!(half_waves, m)?)?;
    m.add_function(wrap_pyfunction!(reversals, m)?)?;
    m.add_function(wrap_pyfunction!(cycle_period, m)?)?;
    m.add_function(wrap_pyfunction!(decimated, m)?)?;
    m.add_function(wrap_pyfunction!(detrended, m)?)?;
    m.add_function(wrap_pyfunction!(low_passed, m)?)?;
    m.add_function(wrap_pyfunction!(band_passed, m)?)?;
    m.add_function(wrap_pyfunction!(swinging_door, m)?)?;
    m.add_function(wrap_pyfunction!(theil_sen, m)?)?;
    m.add_function(wrap_pyfunction!(mann_kendall, m)?)?;
    m.add_function(wrap_pyfunction!(weighted_trend, m)?)?;
    m.add_function(wrap_pyfunction!(difference_of_means, m)?)?;
    m.add_function(wrap_pyfunction!(welch, m)?)?;
    m.add_function(wrap_pyfunction!(cliffs_delta, m)?)
}
