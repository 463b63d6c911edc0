//! S and J, fs and fd.

use crate::arguments::number;
use crate::errors::refused;
use pyo3::prelude::*;

/// The size of stiction, in percent of span.
///
/// Two equivalent pairs describe it, with ``fs = (S + J) / 2`` and ``fd = (S - J) / 2``. A stem at rest breaks away
/// when ``|OP - VP|`` exceeds `fs`. A moving stem lags the OP by `fd`.
///
/// Parameters
/// ----------
/// S : float
///     Stick band plus dead band, percent of span, not negative.
/// J : float
///     Slip jump, percent of span, not negative.
///
/// Raises
/// ------
/// ValueError
///     If either is negative or not finite.
///
/// Examples
/// --------
/// >>> import stiction
/// >>> stiction.valves.Bands(S=5, J=3)
/// Bands(S=5.0, J=3.0)
/// >>> stiction.valves.Bands(S=5, J=3).fs
/// 4.0
#[pyclass(frozen, eq, module = "stiction.valves", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub struct Bands(pub stiction::Bands);

#[pymethods]
impl Bands {
    #[new]
    #[expect(non_snake_case, reason = "the field's names")]
    fn new(S: &Bound<'_, PyAny>, J: &Bound<'_, PyAny>) -> PyResult<Self> {
        stiction::Bands::from_s_j(number("S", S)?, number("J", J)?).map(Self).map_err(refused)
    }

    /// The bands of a static and a dynamic friction band.
    ///
    /// Parameters
    /// ----------
    /// fs : float
    ///     Static friction band, percent of span.
    /// fd : float
    ///     Dynamic friction band, percent of span, between ``-fs`` and ``fs``.
    ///
    /// Returns
    /// -------
    /// Bands
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If they are out of range.
    #[staticmethod]
    fn from_fs_fd(fs: &Bound<'_, PyAny>, fd: &Bound<'_, PyAny>) -> PyResult<Self> {
        stiction::Bands::from_fs_fd(number("fs", fs)?, number("fd", fd)?).map(Self).map_err(refused)
    }

    /// Stick band plus dead band, percent of span.
    #[getter(S)]
    fn s(&self) -> f64 {
        self.0.s()
    }

    /// Slip jump, percent of span.
    #[getter(J)]
    fn j(&self) -> f64 {
        self.0.j()
    }

    /// Static friction band ``(S + J) / 2``, percent of span.
    #[getter]
    fn fs(&self) -> f64 {
        self.0.fs()
    }

    /// Dynamic friction band ``(S - J) / 2``, percent of span.
    #[getter]
    fn fd(&self) -> f64 {
        self.0.fd()
    }

    fn __repr__(&self) -> String {
        format!("Bands(S={:?}, J={:?})", self.0.s(), self.0.j())
    }

    fn __getnewargs__(&self) -> (f64, f64) {
        (self.0.s(), self.0.j())
    }
}
