//! Limit cycles of a loop, predicted instead of simulated, and their dependence on parameters.

use crate::bands::Bands;
use crate::closed_loop::Scenario;
use crate::dict::{dict, plain};
use crate::errors::refused;
use crate::long::long;
use numpy::{Complex64, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::f64::consts::TAU;
use stiction::closed_loop::Controller;
use stiction::limit_cycle::exact;
use stiction::limit_cycle::harmonic_balance::harmonic_balance;
use stiction::limit_cycle::map::{self, Axis, Map, Parameter, Point};
use stiction::limit_cycle::tuning::{self, Assessment, Retuning, Tuning, TuningGrid};
use stiction::limit_cycle::{
    ContinuousLoop, Cycle, DescribingFunction, Found, FrequencyResponse, Method, Stability,
    attractor,
};
use stiction::valve::Model;

/// The scenario's loop in continuous time.
fn continuous(scenario: &Scenario) -> PyResult<ContinuousLoop> {
    let (model, bands) = scenario.0.valve;
    ContinuousLoop::of(scenario.closed_loop()?, model, bands).map_err(refused)
}

fn method_of(name: &str) -> Method {
    if name == "exact" { Method::Exact } else { Method::DescribingFunction }
}

fn name_of(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::DescribingFunction => "describing-function",
    }
}

/// A cycle.
pub fn cycle_dict<'py>(py: Python<'py>, cycle: &Cycle) -> PyResult<Bound<'py, PyDict>> {
    Ok(dict!(py,
        "method": name_of(cycle.method),
        "period_s": cycle.period_s,
        "half_pp_op": cycle.half_pp.op,
        "half_pp_vp": cycle.half_pp.vp,
        "half_pp_pv": cycle.half_pp.pv,
        "middle_op": cycle.middle.op,
        "middle_vp": cycle.middle.vp,
        "middle_pv": cycle.middle.pv,
        "stable": cycle.stable,
        "multipliers": PyArray1::from_vec(py, cycle.multipliers.clone()),
        "slips": cycle.slips,
    ))
}

/// The result of a search.
fn found_dict<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    found: Found,
) -> PyResult<Bound<'py, PyDict>> {
    let cycles = found.cycles.iter().map(|cycle| cycle_dict(py, cycle));
    Ok(dict!(py,
        "method": name_of(found.method),
        "state": found.state.name(),
        "cycles": cycles.collect::<PyResult<Vec<_>>>()?,
        "reasons": found.notes,
        "no_part": scenario.0.no_part_in_cycles(),
    ))
}

/// The final cycle of a loop, or all cycles found.
#[pyfunction]
pub fn limit_cycle<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    method: &str,
    all: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (l, method) = (continuous(scenario)?, method_of(method));
    let found = long(py, None, move |_| Found::of(&l, method, all))?.map_err(refused)?;
    found_dict(py, scenario, found)
}

/// The member of a family of cycles.
#[pyfunction]
pub fn limit_cycle_member<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    offset: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let l = continuous(scenario)?;
    let found = long(py, None, move |_| exact::member(&l, offset))?.map_err(refused)?;
    found_dict(py, scenario, Found::from(found))
}

/// The exact cycle over one period.
#[pyfunction]
pub fn limit_cycle_trajectory<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    samples: usize,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let l = continuous(scenario)?;
    let set_point = l.operating_point().map_err(refused)?.pv;
    let found = long(py, None, move |_| exact::trajectory(&l, samples))?.map_err(refused)?;
    let Some((cycle, orbit)) = found else { return Ok(None) };
    Ok(Some(dict!(py,
        "cycle": cycle_dict(py, &cycle)?,
        "time_s": PyArray1::from_vec(py, orbit.time_s),
        "op": PyArray1::from_vec(py, orbit.op),
        "vp": PyArray1::from_vec(py, orbit.vp),
        "pv": PyArray1::from_vec(py, orbit.pv),
        "set_point": set_point,
    )))
}

fn valve_of(model: &str, s: f64, j: f64) -> PyResult<DescribingFunction> {
    let bands = stiction::Bands::from_s_j(s, j).map_err(refused)?;
    let model = Model::by_name(model).map_err(refused)?;
    DescribingFunction::new(model, bands).map_err(refused)
}

/// N(X); 0 if the valve stays stuck. The response has this number of slips per stroke, or by default the smallest
/// possible number.
#[pyfunction]
pub fn describing_function<'py>(
    py: Python<'py>,
    amplitude: PyReadonlyArray1<'py, f64>,
    s: f64,
    j: f64,
    model: &str,
    slips: Option<usize>,
) -> PyResult<Bound<'py, PyArray1<Complex64>>> {
    let valve = valve_of(model, s, j)?;
    let amplitude = amplitude.as_slice()?;
    let gain = |x: &f64| match slips {
        Some(slips) => valve.with_slips(slips, *x),
        None => Ok(valve.at(*x)?.gain().unwrap_or_default()),
    };
    let gains: stiction::Result<Vec<_>> = py.detach(|| amplitude.iter().map(gain).collect());
    Ok(PyArray1::from_vec(py, gains.map_err(refused)?))
}

/// The range of amplitudes in which a valve slips this often per stroke.
#[pyfunction]
pub fn describing_function_branch(
    s: f64,
    j: f64,
    model: &str,
    slips: usize,
) -> PyResult<Option<(f64, f64)>> {
    Ok(valve_of(model, s, j)?.branch(slips).map(|branch| (branch.from, branch.to)))
}

/// The amplitude above which a motion sustains itself.
#[pyfunction]
pub fn least_amplitude(s: f64, j: f64, model: &str) -> PyResult<f64> {
    Ok(valve_of(model, s, j)?.least_amplitude())
}

/// Frequencies over the relevant range of L.
fn usual_frequencies(response: &FrequencyResponse) -> stiction::Result<Vec<f64>> {
    const POINTS: i32 = 1_000;
    const LARGE: f64 = 50.0;
    let at = |gain: f64| response.crossovers(gain);
    let low = at(LARGE)?.first().copied().unwrap_or(1e-3);
    let high = at(1.0 / LARGE)?.last().copied().unwrap_or(1e3 * low).max(10.0 * low);
    Ok((0..POINTS).map(|k| low * (high / low).powf(f64::from(k) / f64::from(POINTS - 1))).collect())
}

/// The loop without its valve over frequency.
#[pyfunction]
pub fn frequency_response<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    omega: Option<PyReadonlyArray1<'py, f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let l = continuous(scenario)?;
    let response = FrequencyResponse::of(&l).map_err(refused)?;
    let omega = match omega {
        Some(omega) => omega.as_slice()?.to_vec(),
        None => usual_frequencies(&response).map_err(refused)?,
    };
    let (margins, stability) = py.detach(|| (response.margins(), response.stability()));
    // Without an answer of harmonic balance there are no crossings.
    let balance = py.detach(|| harmonic_balance(&l));
    let cycles: Vec<&Cycle> = balance.iter().flat_map(|balance| balance.cycles()).collect();
    let crossings: Vec<f64> = cycles.iter().map(|cycle| TAU / cycle.period_s).collect();
    let over = |of: &dyn Fn(f64) -> Complex64, omega: &[f64]| {
        PyArray1::from_vec(py, omega.iter().map(|w| of(*w)).collect())
    };
    Ok(dict!(py,
        "loop_gain": over(&|w| response.at(w), &omega),
        "process_gain": over(&|w| response.process_at(w), &omega),
        "crossings": over(&|w| response.at(w), &crossings),
        "crossing_omega": PyArray1::from_vec(py, crossings),
        "crossing_slips": cycles.iter().map(|cycle| cycle.slips / 2).collect::<Vec<_>>(),
        "omega": PyArray1::from_vec(py, omega),
        "stability": match stability {
            Stability::Stable => "stable",
            Stability::Marginal => "marginal",
            Stability::Unstable => "unstable",
        },
        "gain_crossover": margins.gain_crossover,
        "phase_margin": margins.phase_margin,
        "ultimate_frequency": margins.ultimate_frequency,
        "gain_margin": margins.gain_margin,
        "peak_sensitivity": margins.peak_sensitivity,
        "peak_frequency": margins.peak_frequency,
        "model": l.model.describe().name,
        "bands": Bands(l.bands),
    ))
}

/// Names and units of the parameters that a map can vary.
#[pyfunction]
pub fn loop_parameters() -> Vec<(&'static str, &'static str)> {
    Parameter::ALL.iter().map(|each| (each.name(), each.unit())).collect()
}

/// The cycles over two parameters. `told` receives the number of finished points.
#[pyfunction]
pub fn limit_cycle_map<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    x: (String, Vec<f64>),
    y: (String, Vec<f64>),
    method: &str,
    told: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (l, method) = (continuous(scenario)?, method_of(method));
    let axis = |(name, values): (String, Vec<f64>)| -> PyResult<Axis> {
        Ok(Axis { parameter: Parameter::by_name(&name).map_err(refused)?, values })
    };
    let (x, y): (Axis, Axis) = (axis(x)?, axis(y)?);
    let map = long(py, told, move |progress| {
        Map::of_with_progress(&l, x, y, method, || progress.goes_on())
    })?
    .map_err(refused)?;
    let column =
        |of: fn(&Point) -> f64| PyArray1::from_vec(py, map.points.iter().map(of).collect());
    let half_pp = |of: fn(&Point) -> Option<f64>| {
        PyArray1::from_vec(py, map.points.iter().map(|p| of(p).unwrap_or(f64::NAN)).collect())
    };
    let boundary = map.boundary();
    let ends = boundary.iter().flatten().flat_map(|(x, y)| [*x, *y]).collect();
    Ok(dict!(py,
        "x_name": map.x.parameter.name(),
        "x_unit": map.x.parameter.unit(),
        "x": PyArray1::from_slice(py, &map.x.values),
        "y_name": map.y.parameter.name(),
        "y_unit": map.y.parameter.unit(),
        "y": PyArray1::from_slice(py, &map.y.values),
        "method": name_of(map.method),
        "state": map.points.iter().map(|point| point.state().name()).collect::<Vec<_>>(),
        "reason": map.points.iter().map(Point::reason).collect::<Vec<_>>(),
        "period_s": half_pp(|p| Some(p.cycle()?.0)),
        "half_pp_op": half_pp(|p| Some(p.cycle()?.1.op)),
        "half_pp_vp": half_pp(|p| Some(p.cycle()?.1.vp)),
        "half_pp_pv": half_pp(|p| Some(p.cycle()?.1.pv)),
        "slips": column(|p| if let Point::Cycle { slips, .. } = p { *slips as f64 } else { f64::NAN }),
        "boundary": PyArray1::from_vec(py, ends),
    ))
}

/// Change of the exact cycle in percent per percent of each parameter.
#[pyfunction]
pub fn sensitivities<'py>(
    py: Python<'py>,
    scenario: &Scenario,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let l = continuous(scenario)?;
    let found = long(py, None, move |_| map::sensitivities(&l))?.map_err(refused)?;
    let each = |each: map::Sensitivity| {
        Ok(dict!(py,
            "parameter": each.parameter.name(),
            "unit": each.parameter.unit(),
            "value": each.value,
            "period": each.period,
            "half_pp_op": each.half_pp.op,
            "half_pp_vp": each.half_pp.vp,
            "half_pp_pv": each.half_pp.pv,
        ))
    };
    found.into_iter().map(each).collect()
}

fn tuning_of<'py>(py: Python<'py>, controller: &Controller) -> PyResult<Bound<'py, PyAny>> {
    plain(py, &Tuning::of(controller))
}

/// Skogestad's tuning of the process of a scenario.
#[pyfunction]
pub fn simc<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    tc: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let process = &scenario.closed_loop()?.process;
    let tc = tc.unwrap_or(process.dead_time());
    tuning_of(py, &tuning::simc(process, tc).map_err(refused)?)
}

/// The lambda tuning of the process of a scenario.
#[pyfunction]
pub fn lambda_tuning<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    time_constant_s: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let process = &scenario.closed_loop()?.process;
    tuning_of(py, &tuning::lambda(process, time_constant_s).map_err(refused)?)
}

/// IAE after a step of the load by 1 percent, without friction.
#[pyfunction]
pub fn load_step_iae(py: Python<'_>, scenario: &Scenario) -> PyResult<f64> {
    let l = continuous(scenario)?;
    long(py, None, move |_| tuning::load_step_iae(&l))?.map_err(refused)
}

fn assessment_dict<'py>(py: Python<'py>, found: &Assessment) -> PyResult<Bound<'py, PyDict>> {
    let cycle = found.cycle.as_ref().map(|cycle| cycle_dict(py, cycle)).transpose()?;
    Ok(dict!(py,
        "tuning": plain(py, &found.tuning)?,
        "ms": found.peak_sensitivity,
        "load_iae": found.load_iae,
        "cycle": cycle,
    ))
}

/// The result of a search for another tuning.
pub fn retuning_dict<'py>(py: Python<'py>, found: &Retuning) -> PyResult<Bound<'py, PyDict>> {
    Ok(dict!(py,
        "present": assessment_dict(py, &found.present)?,
        "best": assessment_dict(py, &found.best)?,
        "ms_bound": found.ms_bound,
        "pv_ratio": found.pv_ratio,
        "iae_ratio": found.iae_ratio,
        "robust_tunings": found.robust_tunings,
        "unjudged_tunings": found.unjudged_tunings,
        "at_edge": found.at_edge,
    ))
}

/// The robust tuning with the smallest swing of the PV. `told` receives the number of judged tunings.
#[pyfunction]
pub fn retune<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    ms: f64,
    method: &str,
    within: f64,
    points: usize,
    told: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (l, method) = (continuous(scenario)?, method_of(method));
    let grid = TuningGrid::about(&l.controller, within, points).map_err(refused)?;
    let found = long(py, told, move |progress| {
        let cycle = |l: &ContinuousLoop| {
            if progress.is_cancelled() {
                return Err(stiction::Error::Cancelled);
            }
            let cycle = attractor(l, method).map(Result::ok);
            progress.one();
            cycle
        };
        tuning::least_swing(&l, &grid, ms, cycle)
    })?
    .map_err(refused)?;
    retuning_dict(py, &found)
}
