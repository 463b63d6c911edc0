//! Scenarios to simulate, also used for the cycles, compensators and actions of a loop.

use crate::bands::Bands;
use crate::dict::dict;
use crate::errors::{refused, unread};
use crate::long::long;
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyMapping, PyString};
use stiction::closed_loop::{self, ClosedLoop, Run, Statistics};
use stiction_io::scenario::{self, System};

/// A loop, a cascade, or a valve on a test signal, to simulate. Made by `stiction.scenario`.
#[pyclass(frozen, eq, module = "stiction.closed_loop", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario(pub stiction_io::Scenario);

#[pymethods]
impl Scenario {
    /// Title, one line.
    #[getter]
    fn title(&self) -> &str {
        &self.0.title
    }

    /// TOML text with all settings.
    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    /// Settings without effect, in sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    /// ``"closed loop"``, ``"cascade"`` or ``"open loop"``.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.0.system {
            System::OpenLoop(_) => "open loop",
            System::ClosedLoop(_) => "closed loop",
            System::Cascade(_) => "cascade",
        }
    }

    /// The name of its valve model.
    #[getter]
    fn model(&self) -> &'static str {
        self.0.valve.0.describe().name
    }

    /// S and J of its valve.
    #[getter]
    fn bands(&self) -> Bands {
        Bands(self.0.valve.1)
    }

    fn __repr__(&self) -> String {
        format!("<Scenario \"{}\" ({})>", self.0.title, self.kind())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (&str,))> {
        let parse = py.import("stiction._core")?.getattr("scenario_parse")?;
        Ok((parse, (&self.0.text,)))
    }
}

impl Scenario {
    /// Control loop.
    pub fn closed_loop(&self) -> PyResult<&ClosedLoop> {
        match &self.0.system {
            System::ClosedLoop(plant) => Ok(plant),
            _ => Err(PyValueError::new_err(format!(
                "scenario \"{}\" is {} {}, but must be a closed loop",
                self.0.title,
                if self.kind() == "open loop" { "an" } else { "a" },
                self.kind()
            ))),
        }
    }
}

/// The scenario in TOML text, or in its tables as a mapping, with settings by dotted key.
#[pyfunction]
#[pyo3(signature = (source, settings = None))]
pub fn scenario_parse(
    source: &Bound<'_, PyAny>,
    settings: Option<&Bound<'_, PyMapping>>,
) -> PyResult<Scenario> {
    let text = match source.cast::<PyString>() {
        Ok(text) => text.to_string(),
        Err(_) => toml::to_string(&toml_value("the scenario", source)?)
            .map_err(|e| PyValueError::new_err(e.to_string()))?,
    };
    let settings = assignments(settings)?;
    stiction_io::Scenario::parse_with(&text, "scenario", None, &settings)
        .map(Scenario)
        .map_err(unread)
}

/// The built-in scenario of that name, or the scenario in that file, with settings by dotted key.
#[pyfunction]
#[pyo3(signature = (name, settings = None))]
pub fn scenario_open(name: &str, settings: Option<&Bound<'_, PyMapping>>) -> PyResult<Scenario> {
    stiction_io::Scenario::open(name, &assignments(settings)?).map(Scenario).map_err(unread)
}

/// Settings in the form of the command line.
fn assignments(settings: Option<&Bound<'_, PyMapping>>) -> PyResult<Vec<String>> {
    let Some(settings) = settings else { return Ok(vec![]) };
    let mut all = vec![];
    for pair in settings.items()?.iter() {
        let (key, value): (String, Bound<'_, PyAny>) = pair.extract()?;
        all.push(format!("{key}={}", toml_value(&key, &value)?));
    }
    Ok(all)
}

/// A Python value as TOML. `key` is its name in errors.
fn toml_value(key: &str, value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if let Ok(table) = value.cast::<PyMapping>() {
        let mut all = toml::Table::new();
        for pair in table.items()?.iter() {
            let (name, value): (String, Bound<'_, PyAny>) = pair.extract()?;
            let value = toml_value(&format!("{key}.{name}"), &value)?;
            all.insert(name, value);
        }
        return Ok(all.into());
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_string().into());
    }
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(truth.is_true().into());
    }
    if let Ok(number) = value.extract::<i64>() {
        return Ok(number.into());
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(number.into());
    }
    let Ok(items) = value.try_iter() else {
        return Err(PyTypeError::new_err(format!(
            "{key} is a {}, but must be a number, text, truth value, sequence or mapping",
            value.get_type().name()?
        )));
    };
    items.map(|item| toml_value(key, &item?)).collect::<PyResult<Vec<_>>>().map(Into::into)
}

/// Names and titles of the built-in scenarios.
#[pyfunction]
pub fn scenario_names() -> Vec<(&'static str, String)> {
    scenario::built_in().collect()
}

/// The signals and measures of a run.
pub fn run_dict<'py>(py: Python<'py>, run: Run) -> PyResult<Bound<'py, PyDict>> {
    let (period_s, growth) = (run.period_s(), run.growth());
    let half_pp = [&run.op, &run.vp, &run.pv].map(|signal| run.half_pp(signal));
    Ok(dict!(py,
        "sample_time": run.sample_time,
        "sp": PyArray1::from_vec(py, run.sp),
        "pv": PyArray1::from_vec(py, run.pv),
        "op": PyArray1::from_vec(py, run.op),
        "vp": PyArray1::from_vec(py, run.vp),
        "period_s": period_s,
        "half_pp_op": half_pp[0],
        "half_pp_vp": half_pp[1],
        "half_pp_pv": half_pp[2],
        "growth": growth,
    ))
}

/// Simulates a scenario of any kind.
#[pyfunction]
pub fn simulate<'py>(py: Python<'py>, scenario: &Scenario) -> PyResult<Bound<'py, PyDict>> {
    match scenario.0.system.clone() {
        System::ClosedLoop(plant) => {
            let run = long(py, None, move |_| plant.run())?.map_err(refused)?;
            run_dict(py, run)
        }
        System::Cascade(plant) => {
            let run = long(py, None, move |_| plant.run())?.map_err(refused)?;
            Ok(dict!(py,
                "slave": run_dict(py, run.slave)?,
                "sp": PyArray1::from_vec(py, run.sp),
                "pv": PyArray1::from_vec(py, run.pv),
            ))
        }
        System::OpenLoop(valve) => {
            let run = long(py, None, move |_| valve.run())?.map_err(refused)?;
            let period_s = run.period_s();
            let half_pp = [&run.op, &run.vp].map(|signal| run.half_pp(signal));
            Ok(dict!(py,
                "sample_time": run.sample_time,
                "op": PyArray1::from_vec(py, run.op),
                "vp": PyArray1::from_vec(py, run.vp),
                "period_s": period_s,
                "half_pp_op": half_pp[0],
                "half_pp_vp": half_pp[1],
            ))
        }
    }
}

/// Loops simulated between two checks for an interrupt.
const CHUNK: usize = 256;

/// Statistics of many closed loops. Successive loops with the same number of samples are swept together.
#[pyfunction]
pub fn sweep<'py>(
    py: Python<'py>,
    scenarios: Vec<Scenario>,
    told: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let loops: Vec<ClosedLoop> =
        scenarios.iter().map(|s| s.closed_loop().cloned()).collect::<PyResult<_>>()?;
    let all = long(py, told, move |progress| {
        let mut all = Vec::with_capacity(loops.len());
        for alike in loops.chunk_by(|a, b| a.samples == b.samples) {
            for chunk in alike.chunks(CHUNK) {
                if progress.is_cancelled() {
                    return Ok(all);
                }
                all.extend(closed_loop::sweep(chunk)?);
                chunk.iter().for_each(|_| progress.one());
            }
        }
        Ok(all)
    })?
    .map_err(refused)?;
    let column =
        |of: fn(&Statistics) -> f64| PyArray1::from_vec(py, all.iter().map(of).collect::<Vec<_>>());
    let band = |of: fn(&stiction::Bands) -> f64| {
        PyArray1::from_vec(py, scenarios.iter().map(|s| of(&s.0.valve.1)).collect::<Vec<_>>())
    };
    Ok(dict!(py,
        "S": band(stiction::Bands::s),
        "J": band(stiction::Bands::j),
        "period_s": column(|s| s.period_s.unwrap_or(f64::NAN)),
        "half_pp_op": column(|s| s.op_half_pp),
        "half_pp_vp": column(|s| s.vp_half_pp),
        "half_pp_pv": column(|s| s.pv_half_pp),
        "error_mean": column(|s| s.error_mean),
        "error_rms": column(|s| s.error_rms),
        "error_abs": column(|s| s.error_abs),
        "travel_per_s": column(|s| s.travel_per_s),
    ))
}

/// Samples of a signal given in the form of a scenario's table.
#[pyfunction]
pub fn signal<'py>(
    py: Python<'py>,
    table: &Bound<'py, PyMapping>,
    sample_time: f64,
    duration: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let ideal = toml::Table::from_iter([("model".to_owned(), "ideal".into())]);
    let whole = toml::Table::from_iter([
        ("sample_time".to_owned(), sample_time.into()),
        ("duration".to_owned(), duration.into()),
        ("input".to_owned(), toml_value("table", table)?),
        ("valve".to_owned(), ideal.into()),
    ]);
    let scenario = stiction_io::Scenario::parse(&whole.to_string(), "signal", None);
    let System::OpenLoop(valve) = scenario.map_err(unread)?.system else {
        return Err(PyValueError::new_err("the table does not describe a signal"));
    };
    let sample = move |_: &_| valve.input.sample(valve.sample_time, valve.samples);
    Ok(PyArray1::from_vec(py, long(py, None, sample)?.map_err(refused)?))
}
