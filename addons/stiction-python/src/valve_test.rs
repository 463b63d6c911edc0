//! Plans and judges the test of a valve.

use crate::dict::plain;
use crate::errors::refused;
use crate::long::long;
use crate::recordings::Recording;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::Serialize;
use stiction::diagnose::{Detectors, DiagnoseOptions, diagnose};
use stiction::finding::Abstention;
use stiction::recording::GridOptions;
use stiction::recording::{ByHand, KnownBy, Set};
use stiction::valve_test::{
    self, Comparison, PlanOptions, ReadOptions, Signature, TestPlan, TestReading, before_test,
};

fn because(name: &str, why: &Abstention) -> PyErr {
    PyValueError::new_err(format!("loop {name}: {}", why.0))
}

/// The planned test of a loop, as a document.
#[pyfunction]
pub fn test_planned(
    py: Python<'_>,
    recording: Recording,
    done: Done,
    rises: Option<bool>,
    pv_allowed: Option<[f64; 2]>,
    time_s: Option<f64>,
) -> PyResult<Bound<'_, PyAny>> {
    let name = recording.recording.name.clone();
    let plan = long(py, None, move |_| {
        let recording = &recording.recording;
        let by_hand = sheet(done).or_else(|| ByHand::of(recording).filter(ByHand::is_test));
        let asked = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
        let diagnosis = diagnose(&before_test(recording, by_hand.as_ref()), &asked)?;
        let first = valve_test::plan(&diagnosis, &PlanOptions { rises, pv_allowed, time_s });
        Ok::<_, stiction::Error>(
            first.map(|first| first.again(recording, by_hand).unwrap_or(first)),
        )
    })?
    .map_err(refused)?;
    plain(py, &plan.map_err(|why| because(&name, &why))?)
}

/// The result of a test, as a document. `done` has the time of each OP setting, s, and the OP; `None` marks the return
/// to automatic.
#[pyfunction]
pub fn test_read(
    py: Python<'_>,
    recording: Recording,
    done: Done,
    plan: Planned,
    rises: Option<bool>,
) -> PyResult<Bound<'_, PyAny>> {
    let read = read(py, recording, done, plan, rises)?;
    plain(py, &read)
}

/// Time of each OP setting, s, and the OP.
type Done = Option<Vec<(f64, Option<f64>)>>;

/// A plan as JSON.
type Planned = Option<String>;

/// The manual actions in the form of the Rust library.
fn sheet(done: Done) -> Option<ByHand> {
    let sets = done?.into_iter().map(|(at_s, op)| Set { at_s, op }).collect();
    Some(ByHand { sets, known_by: KnownBy::Sheet })
}

fn read(
    py: Python<'_>,
    recording: Recording,
    done: Done,
    plan: Planned,
    rises: Option<bool>,
) -> PyResult<TestReading> {
    let name = recording.recording.name.clone();
    let plan: Option<TestPlan> = plan
        .map(|plan| serde_json::from_str(&plan))
        .transpose()
        .map_err(|why| PyValueError::new_err(format!("the plan cannot be read: {why}")))?;
    if let Some(why) = plan.as_ref().and_then(TestPlan::fault) {
        return Err(PyValueError::new_err(format!("the plan cannot be carried out: {why}")));
    }
    let options = ReadOptions { by_hand: sheet(done), plan, rises, ..ReadOptions::default() };
    let read = long(py, None, move |_| valve_test::read(&recording.recording, &options))?;
    read.map_err(|why| because(&name, &why))
}

/// Two results and their comparison.
#[derive(Serialize)]
struct Compared<T> {
    #[serde(flatten)]
    comparison: Comparison,
    before: T,
    after: T,
}

/// The comparison of two tests, before and after a repair, as a document.
#[pyfunction]
pub fn test_compared<'py>(
    py: Python<'py>,
    recordings: [Recording; 2],
    done: [Done; 2],
    plans: [Planned; 2],
    rises: Option<bool>,
) -> PyResult<Bound<'py, PyAny>> {
    let ([before, after], [before_done, after_done], [old, new]) = (recordings, done, plans);
    let before = read(py, before, before_done, old, rises)?;
    let after = read(py, after, after_done, new, rises)?;
    let comparison = valve_test::compare(&before, &after);
    plain(py, &Compared { comparison, before, after })
}

/// The planned signature of a valve, as a document.
#[pyfunction]
pub fn signature_planned(py: Python<'_>, name: &str, op: [f64; 2]) -> PyResult<Py<PyAny>> {
    let plan = valve_test::signature_plan(name, op).map_err(|why| because(name, &why))?;
    Ok(plain(py, &plan)?.unbind())
}

fn signed(py: Python<'_>, recording: Recording) -> PyResult<Signature> {
    let name = recording.recording.name.clone();
    let found = long(py, None, move |_| {
        valve_test::signature(&recording.recording, &GridOptions::default())
    })?;
    found.map_err(|why| because(&name, &why))
}

/// The result of a signature, as a document.
#[pyfunction]
pub fn signature_read(py: Python<'_>, recording: Recording) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &signed(py, recording)?)
}

/// The comparison of two signatures, as a document.
#[pyfunction]
pub fn signatures_compared(
    py: Python<'_>,
    before: Recording,
    after: Recording,
) -> PyResult<Bound<'_, PyAny>> {
    let (before, after) = (signed(py, before)?, signed(py, after)?);
    let comparison = valve_test::compare(&before, &after);
    plain(py, &Compared { comparison, before, after })
}
