//! The effects of repair, retuning, a compensator or a positioner on a loop.

use crate::closed_loop::Scenario;
use crate::compensate::{methods_of, protocol_dict, row_dict};
use crate::dict::{dict, plain};
use crate::errors::refused;
use crate::limit_cycle::{cycle_dict, retuning_dict};
use crate::long::long;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::Bands;
use stiction::what_if::{self, Prediction, Row, WhatIfOptions};

/// All actions, ranked.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keywords of one function")]
pub fn what_if_loop<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    repaired_s: Option<f64>,
    repaired_j: Option<f64>,
    positioner_gain: Option<f64>,
    ms: Option<f64>,
    methods: Option<Vec<String>>,
    told: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let plant = scenario.closed_loop()?.clone();
    let (model, bands) = scenario.0.valve;
    let mut options =
        py.detach(|| WhatIfOptions::suiting(&plant, model, bands)).map_err(refused)?;
    let usual = options.repaired;
    let (s, j) = (repaired_s.unwrap_or(usual.s()), repaired_j.unwrap_or(usual.j()));
    options.repaired = Bands::from_s_j(s, j).map_err(refused)?;
    options.positioner_gain = positioner_gain.unwrap_or(options.positioner_gain);
    options.most_sensitive = ms.unwrap_or(options.most_sensitive);
    if let Some(names) = methods {
        options.methods = methods_of(&names)?;
    }
    let asked = options.clone();
    let found = long(py, told, move |progress| {
        what_if::what_if_with_progress(&plant, model, bands, &asked, || progress.goes_on())
    })?
    .map_err(refused)?;
    let rows = found.rows.iter().map(|row| action_dict(py, row)).collect::<PyResult<Vec<_>>>()?;
    let retuning =
        found.retuning.as_ref().ok().map(|found| retuning_dict(py, found)).transpose()?;
    Ok(dict!(py,
        "rows": rows,
        "interim": found.interim().map(|row| row.action.name()),
        "recommendation": &found.recommendation,
        "assumptions": &found.assumptions,
        "manual_test": found.confirm.as_ref().map(|plan| plain(py, plan)).transpose()?,
        "retuning": retuning,
        "no_retuning": found.retuning.as_ref().err(),
        "protocol": protocol_dict(py, &options.protocol)?,
    ))
}

fn action_dict<'py>(py: Python<'py>, row: &Row) -> PyResult<Bound<'py, PyDict>> {
    let dict = row_dict(py, row.action.name(), &row.played)?;
    let (state, reason) = match &row.cycle {
        Prediction::Cycle(_) => ("cycle", ""),
        Prediction::NoCycle(reason) => ("no cycle", &reason[..]),
        Prediction::Unknown(reason) => ("not known", &reason[..]),
    };
    dict.set_item("against", &row.against)?;
    dict.set_item("state", state)?;
    dict.set_item("reason", reason)?;
    dict.set_item("cycle", row.cycle.cycle().map(|cycle| cycle_dict(py, cycle)).transpose()?)?;
    Ok(dict)
}
