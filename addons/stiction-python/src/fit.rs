//! The fitted loop of a recording, its scenario, the effects of actions, and their comparison with a later recording.

use crate::closed_loop::Scenario;
use crate::diagnosis::LoopOptions;
use crate::dict::plain;
use crate::errors::{refused, unread};
use crate::long::long;
use crate::recordings::{Recording, segment_dict};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, OnceLock};
use stiction::diagnose::{Diagnosis, diagnose};
use stiction::fit::prospects::Remedy;
use stiction::fit::{self, Fit, FitOptions, Prospects};

/// A fit, kept for its scenario, its plot and the effects of actions.
#[pyclass(frozen, module = "stiction._core")]
#[derive(Debug)]
pub struct Fitted {
    diagnosis: Arc<Diagnosis>,
    fit: Arc<Fit>,
    /// Simulated when first requested.
    prospects: Arc<OnceLock<Result<Prospects, String>>>,
}

impl Fitted {
    /// A refusal, with the tag of the loop.
    fn because(&self, why: &str) -> PyErr {
        PyValueError::new_err(format!("loop {}: {why}", self.diagnosis.name))
    }

    fn foreseen(&self, py: Python<'_>) -> PyResult<&Prospects> {
        if self.prospects.get().is_none() {
            let (fit, kept) = (Arc::clone(&self.fit), Arc::clone(&self.prospects));
            long(py, None, move |_| _ = kept.set(fit::prospects(&fit)))?;
        }
        match self.prospects.get() {
            Some(Ok(found)) => Ok(found),
            Some(Err(why)) => Err(self.because(why)),
            None => Err(self.because("the effects of actions are unknown")),
        }
    }
}

#[pymethods]
impl Fitted {
    /// The fit as a document.
    fn document<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &*self.fit)
    }

    /// The signals of the fit.
    fn segment<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let segment = self.diagnosis.segment();
        segment_dict(py, segment.ok_or_else(|| self.because("there is no segment"))?)
    }

    /// The loop, to be simulated.
    fn scenario(&self) -> PyResult<Scenario> {
        let name = &self.diagnosis.name;
        let duration = self.diagnosis.segment().map_or(0.0, |segment| segment.duration());
        let text = stiction_report::fitted_scenario::scenario(name, &self.fit, duration)
            .map_err(|why| PyValueError::new_err(format!("loop {why}")))?;
        stiction_io::Scenario::parse(&text, name, None).map(Scenario).map_err(unread)
    }

    /// The effects of actions.
    fn prospects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, self.foreseen(py)?)
    }

    /// The result of an action, from a recording after it.
    fn ring<'py>(
        &self,
        py: Python<'py>,
        after: Recording,
        told: LoopOptions,
        action: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let action = Remedy::by_name(action).map_err(refused)?;
        let after = diagnosed(py, &after, told)?;
        let segment = after
            .segment()
            .ok_or_else(|| self.because("no later segment in automatic is long enough"))?;
        let found = fit::ring::ring(self.foreseen(py)?, action, &self.fit, segment)
            .map_err(|why| self.because(&why))?;
        let said = plain(py, &found)?;
        said.set_item("action", found.action.name())?;
        Ok(said)
    }
}

fn diagnosed(py: Python<'_>, recording: &Recording, told: LoopOptions) -> PyResult<Diagnosis> {
    let options = told.options()?;
    let (name, recording) = (recording.recording.name.clone(), Arc::clone(&recording.recording));
    long(py, None, move |_| diagnose(&recording, &options))?
        .map_err(|error| PyValueError::new_err(format!("loop {name}: {error}")))
}

/// Fits the loop of a recording.
#[pyfunction]
pub fn fit_recording(
    py: Python<'_>,
    recording: Recording,
    told: LoopOptions,
    draws: usize,
    seed: u64,
) -> PyResult<Fitted> {
    let name = recording.recording.name.clone();
    let diagnosis = Arc::new(diagnosed(py, &recording, told)?);
    let options = FitOptions { draws, seed };
    let theirs = Arc::clone(&diagnosis);
    let fit = long(py, None, move |_| fit::fit(&theirs, &options))?
        .map_err(|why| PyValueError::new_err(format!("loop {name}: {why}")))?;
    Ok(Fitted { diagnosis, fit: Arc::new(fit), prospects: Arc::default() })
}
