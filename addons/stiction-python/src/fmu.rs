//! Functional mock-up units: the list of models, and the bytes of one.

use crate::closed_loop::Scenario;
use crate::dict::plain;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use stiction_fmu::Fmi;
use stiction_fmu_export::{Error, Library};

/// A model with its start values, to be exported.
#[pyclass(frozen, module = "stiction._core")]
pub struct Fmu(stiction_fmu::Fmu);

fn refused(error: Error) -> PyErr {
    match error {
        Error::Zip(_) | Error::Io(_) | Error::Compiler(_) => {
            PyRuntimeError::new_err(error.to_string())
        }
        _ => PyValueError::new_err(error.to_string()),
    }
}

#[pymethods]
impl Fmu {
    /// A `valve` or a `stem` with a law, or else the loop of a scenario, then start values by name.
    #[new]
    #[pyo3(signature = (kind, law, start, scenario = None))]
    fn new(
        kind: &str,
        law: &str,
        start: Vec<(String, f64)>,
        scenario: Option<&Scenario>,
    ) -> PyResult<Self> {
        let mut fmu = match scenario {
            Some(scenario) => stiction_fmu_export::of_scenario(&scenario.0).map_err(refused)?,
            None => stiction_fmu::Fmu::new(kind, law).map_err(PyValueError::new_err)?,
        };
        for (name, value) in start {
            fmu = fmu.with(&name, value).map_err(PyValueError::new_err)?;
        }
        fmu.check().map_err(PyValueError::new_err)?;
        Ok(Self(fmu))
    }

    /// The table of its variables.
    fn variables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.0.variables())
    }

    /// The bytes of the file, for version 2 or 3 of FMI, with additional libraries (processor, system, bytes) and the
    /// time of generation, in seconds after the beginning of 1970.
    fn bytes<'py>(
        &self,
        py: Python<'py>,
        fmi: u8,
        libraries: Vec<(String, String, Vec<u8>)>,
        generated_s: u64,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let fmi = match fmi {
            2 => Fmi::V2,
            3 => Fmi::V3,
            _ => return Err(PyValueError::new_err(format!("fmi is {fmi}, but must be 2 or 3"))),
        };
        let further = libraries
            .into_iter()
            .map(|(arch, os, bytes)| Library { arch, os, bytes: bytes.into(), given: true })
            .collect();
        let write = || {
            let all = Library::own_and(further)?;
            stiction_fmu_export::write(&self.0, fmi, &all, Some(generated_s))
        };
        let bytes = py.detach(write).map_err(refused)?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// Every model that can be exported.
#[pyfunction]
pub fn fmu_models(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &stiction_fmu::models())
}
