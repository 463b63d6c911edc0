//! Closed loops with user parts written in Python.

use crate::arguments::number;
use crate::closed_loop::{Scenario, run_dict};
use crate::errors::refused;
use crate::long::long;
use crate::stem::Stem;
use crate::valve::Valve;
use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::cell::RefCell;
use stiction::closed_loop::{Own, OwnController, OwnProcess};
use stiction::stem::StemValve;
use stiction::valve::{self, Start};

/// A part of a loop that is a Python object. Its first exception ends the calls, and its output is then NaN.
struct Theirs<'a, 'py> {
    part: &'a Bound<'py, PyAny>,
    failed: &'a RefCell<Option<PyErr>>,
    position: f64,
}

impl<'py> Theirs<'_, 'py> {
    fn call<T>(
        &self,
        method: &str,
        arguments: impl PyCallArgs<'py>,
        take: impl FnOnce(Bound<'py, PyAny>) -> PyResult<T>,
    ) -> Option<T> {
        if self.failed.borrow().is_some() {
            return None;
        }
        let given = self.part.call_method1(method, arguments).and_then(take);
        given.map_err(|error| *self.failed.borrow_mut() = Some(error)).ok()
    }

    fn begin(&self, arguments: impl PyCallArgs<'py>) {
        _ = self.call("restart", arguments, |_| Ok(()));
    }

    fn value(&self, method: &str, arguments: impl PyCallArgs<'py>) -> f64 {
        let take = |value: Bound<'py, PyAny>| {
            value.extract().or_else(|_| number(&format!("the result of `{method}`"), &value))
        };
        self.call(method, arguments, take).unwrap_or(f64::NAN)
    }
}

impl valve::Valve for Theirs<'_, '_> {
    fn step(&mut self, op: f64) -> f64 {
        self.position = self.value("step", (op,));
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        self.position = start.position;
        self.begin((start.position,));
    }
}

impl OwnController for Theirs<'_, '_> {
    fn restart(&mut self, sample_time: f64, op: f64, sp: f64, pv: f64) {
        self.begin((sample_time, op, sp, pv));
    }

    fn step(&mut self, sp: f64, pv: f64) -> f64 {
        self.value("step", (sp, pv))
    }
}

impl OwnProcess for Theirs<'_, '_> {
    fn restart(&mut self, sample_time: f64) {
        self.begin((sample_time,));
    }

    fn output(&self) -> f64 {
        self.value("output", ())
    }

    fn advance(&mut self, input: f64) {
        _ = self.call("advance", (input,), |_| Ok(()));
    }
}

/// Simulates a closed loop in which user parts replace its own.
#[pyfunction]
pub fn simulate_own<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    controller: Option<Bound<'py, PyAny>>,
    valve: Option<Bound<'py, PyAny>>,
    process: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut plant = scenario.closed_loop()?.clone();
    let mut stem = None;
    let mut theirs = None;
    if let Some(valve) = &valve {
        if let Ok(known) = valve.cast::<Valve>() {
            plant.valve = known.borrow().assembly().clone();
        } else if let Ok(physical) = valve.cast::<Stem>() {
            let physical = *physical.get().stem();
            stem = Some(StemValve::new(physical, plant.sample_time).map_err(refused)?);
        } else {
            theirs = Some(valve);
        }
    }
    if controller.is_none() && theirs.is_none() && process.is_none() {
        let (run, fault) = long(py, None, move |progress| {
            let valve = stem.as_mut().map(|stem| stem as &mut dyn valve::Valve);
            let own = Own { valve, ..Own::default() };
            let run = plant.run_with_progress(own, || !progress.is_cancelled());
            (run, stem.and_then(|stem| stem.fault().cloned()))
        })?;
        return match fault {
            Some(fault) => Err(refused(fault)),
            None => run_dict(py, run.map_err(refused)?),
        };
    }
    let failed = RefCell::new(None);
    let theirs_of = |part| Theirs { part, failed: &failed, position: 0.0 };
    let [mut controller, mut theirs, mut process] =
        [controller.as_ref(), theirs, process.as_ref()].map(|part| part.map(theirs_of));
    let own = Own {
        controller: controller.as_mut().map(|part| part as &mut dyn OwnController),
        valve: match (&mut stem, &mut theirs) {
            (Some(stem), _) => Some(stem),
            (None, Some(theirs)) => Some(theirs),
            (None, None) => None,
        },
        process: process.as_mut().map(|part| part as &mut dyn OwnProcess),
    };
    let run = plant.run_with_progress(own, || {
        if let Err(error) = py.check_signals() {
            failed.borrow_mut().get_or_insert(error);
        }
        failed.borrow().is_none()
    });
    match (failed.take(), stem.as_ref().and_then(StemValve::fault)) {
        (Some(error), _) => Err(error),
        (None, Some(fault)) => Err(refused(fault.clone())),
        (None, None) => run_dict(py, run.map_err(refused)?),
    }
}
