//! Compensators, one on a loop or all side by side.

use crate::closed_loop::{Scenario, run_dict};
use crate::dict::{dict, plain};
use crate::errors::refused;
use crate::long::long;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::compensate::{
    self, CompareOptions, CompensatedRun, CompensatorOutcome, Knowledge, Measures, Method,
};
use stiction::what_if::{self, knowledge};

/// Names and descriptions of the compensators.
#[pyfunction]
pub fn compensators(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &Method::ALL.map(Method::describe))
}

/// The protocol for the loop, with the user's changes and the assumed knowledge of the loop.
fn suiting(
    py: Python<'_>,
    scenario: &Scenario,
    bands: (Option<f64>, Option<f64>),
    times: [Option<f64>; 3],
) -> PyResult<(CompareOptions, Knowledge)> {
    let plant = scenario.closed_loop()?;
    let (model, own) = scenario.0.valve;
    let mut options =
        py.detach(|| what_if::WhatIfOptions::suiting(plant, model, own)).map_err(refused)?.protocol;
    let fields = [&mut options.from_s, &mut options.settle_s, &mut options.window_s];
    for (field, given) in fields.into_iter().zip(times) {
        *field = given.unwrap_or(*field);
    }
    let assumed = stiction::Bands::from_s_j(bands.0.unwrap_or(own.s()), bands.1.unwrap_or(own.j()));
    Ok((options, knowledge(plant, assumed.map_err(refused)?)))
}

fn measures_dict<'py>(py: Python<'py>, m: &Measures) -> PyResult<Bound<'py, PyDict>> {
    Ok(dict!(py,
        "iae_per_s": m.iae_per_s,
        "pv_std": m.pv_std,
        "op_travel_per_s": m.op_travel_per_s,
        "vp_travel_per_s": m.vp_travel_per_s,
        "reversals_per_h": m.reversals_per_h,
        "half_pp_op": m.op_half_pp,
        "half_pp_vp": m.vp_half_pp,
        "half_pp_pv": m.pv_half_pp,
    ))
}

/// A compensator on a loop, and the loop without it.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of one function")]
pub fn compensate_loop<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    method: &str,
    parameters: Vec<(String, f64)>,
    s: Option<f64>,
    j: Option<f64>,
    at_s: Option<f64>,
    settle_s: Option<f64>,
    window_s: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let method = Method::by_name(method).map_err(refused)?;
    let (options, known) = suiting(py, scenario, (s, j), [at_s, settle_s, window_s])?;
    let mut plant = scenario.closed_loop()?.clone();
    let [from, to, ..] = options.times();
    let samples = (to / plant.sample_time - 1e-9).ceil();
    if !(1.0..=1e8).contains(&samples) {
        return Err(PyValueError::new_err(format!(
            "a run of {to} s is {samples} samples, but must be 1 to 100 million"
        )));
    }
    plant.samples = samples as usize;
    let given: Vec<(&str, f64)> = parameters.iter().map(|(name, v)| (&name[..], *v)).collect();
    let mut compensator = method.with(&known, &given).map_err(refused)?;
    let parameters = compensator.parameters();
    let at_s = options.from_s;
    let mut play = move || -> stiction::Result<[(CompensatedRun, Measures); 2]> {
        let mut run = |from_s: f64| {
            let played = compensate::run(&plant, compensator.as_mut(), from_s)?;
            let measures = Measures::of(&played, from, to)?;
            Ok((played, measures))
        };
        Ok([run(at_s)?, run(f64::INFINITY)?])
    };
    let [(with, measures), (without, measures_without)] =
        long(py, None, move |_| play())?.map_err(refused)?;
    Ok(dict!(py,
        "method": method.describe().name,
        "parameters": plain(py, &parameters)?,
        "at_s": at_s,
        "settle_s": options.settle_s,
        "window_s": options.window_s,
        "run": run_dict(py, with.run)?,
        "signal": PyArray1::from_vec(py, with.signal),
        "without": run_dict(py, without.run)?,
        "measures": measures_dict(py, &measures)?,
        "measures_without": measures_dict(py, &measures_without)?,
    ))
}

fn outcome_dict<'py>(
    py: Python<'py>,
    outcome: &CompensatorOutcome,
) -> PyResult<Bound<'py, PyDict>> {
    Ok(dict!(py,
        "s_factor": outcome.case.s_factor,
        "j_factor": outcome.case.j_factor,
        "noise": outcome.case.noise,
        "measures": measures_dict(py, &outcome.measures)?,
        "set_point_iae_per_s": outcome.set_point_iae_per_s,
        "load_iae_per_s": outcome.load_iae_per_s,
        "set_point_settling_s": outcome.set_point_settling_s,
        "load_settling_s": outcome.load_settling_s,
    ))
}

/// An action with all its cases.
pub fn row_dict<'py>(
    py: Python<'py>,
    action: &str,
    row: &compensate::Row,
) -> PyResult<Bound<'py, PyDict>> {
    let outcomes = row.outcomes.iter().map(|outcome| outcome_dict(py, outcome));
    Ok(dict!(py,
        "action": action,
        "parameters": plain(py, &row.parameters)?,
        "error": row.nominal().measures.iae_per_s,
        "worst_error": row.worst_iae_per_s(),
        "outcomes": outcomes.collect::<PyResult<Vec<_>>>()?,
    ))
}

/// The protocol of all actions.
pub fn protocol_dict<'py>(
    py: Python<'py>,
    options: &CompareOptions,
) -> PyResult<Bound<'py, PyDict>> {
    Ok(dict!(py,
        "at_s": options.from_s,
        "settle_s": options.settle_s,
        "window_s": options.window_s,
        "step_s": options.step_s,
        "set_point_step": options.set_point_step,
        "load_step": options.load_step,
        "settling_band": options.settling_band,
        "error": options.error,
        "noise_sd": options.noise_sd,
        "seed": options.seed,
    ))
}

/// Methods by name, without repetition; all methods if no names are given.
pub fn methods_of(names: &[String]) -> PyResult<Vec<Method>> {
    let mut methods = vec![];
    for name in names {
        let method = Method::by_name(name).map_err(refused)?;
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    Ok(methods)
}

/// Compensators side by side.
#[pyfunction]
pub fn compare_compensators<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    methods: Option<Vec<String>>,
    s: Option<f64>,
    j: Option<f64>,
    at_s: Option<f64>,
    told: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let methods = methods.map_or(Ok(Method::ALL.to_vec()), |names| methods_of(&names))?;
    let (options, known) = suiting(py, scenario, (s, j), [at_s, None, None])?;
    let plant = scenario.closed_loop()?.clone();
    let found = long(py, told, move |progress| {
        compensate::compare_with_progress(&plant, &known, &methods, &options, || progress.goes_on())
    })?
    .map_err(refused)?;
    if !found.rows[0].nominal().measures.iae_per_s.is_finite() {
        return Err(PyValueError::new_err(
            "the loop grows without bound; lower the gain of its controller, or limit its output",
        ));
    }
    let mut rows: Vec<&compensate::Row> = found.rows.iter().collect();
    rows.sort_by(|a, b| a.worst_iae_per_s().total_cmp(&b.worst_iae_per_s()));
    let rows = rows.into_iter().map(|row| {
        let action = row.method.map_or("as it is", |method| method.describe().name);
        let dict = row_dict(py, action, row)?;
        dict.set_item("reduction", found.reduction(row))?;
        Ok(dict)
    });
    Ok(dict!(py,
        "rows": rows.collect::<PyResult<Vec<_>>>()?,
        "protocol": protocol_dict(py, &options)?,
    ))
}
