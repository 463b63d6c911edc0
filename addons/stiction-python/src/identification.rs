//! Models of process and valve fitted to signals, and evidence as numbers.

use crate::bands::Bands;
use crate::detect::{Signal, segment};
use crate::dict::dict;
use crate::errors::refused;
use crate::long::long;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use std::collections::HashSet;
use stiction::evidence::{Evidence, features, op_only};
use stiction::finding::Abstention;
use stiction::fusion::{Estimate, shipped};
use stiction::identify::cycle_closed_form::{self, CancelledLoop};
use stiction::identify::hammerstein::{self, ModelEvidence, ValveFit};
use stiction::identify::position::PositionFit;
use stiction::identify::{arx, fopdt, physical, position};
use stiction::methods::model_fit::published::HammersteinFit;
use stiction::methods::model_fit::{earx, jelali, karra_karim, lee, srinivasan};
use stiction::recording::LoopType;
use stiction::series::standardised;

/// The reason why nothing was fitted, as `ValueError`.
fn unfit(Abstention(why): Abstention) -> PyErr {
    PyValueError::new_err(why)
}

/// A process of first order with dead time.
#[pyfunction]
pub fn fit_fopdt<'py>(
    py: Python<'py>,
    op: Signal<'py>,
    pv: Signal<'py>,
    sample_time: f64,
    integrating: bool,
    longest_delay: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (op, pv) = (op.as_slice()?.to_vec(), pv.as_slice()?.to_vec());
    let kind = if integrating {
        fopdt::ProcessKind::Integrating
    } else {
        fopdt::ProcessKind::SelfRegulating
    };
    let options = fopdt::FopdtOptions { kind, longest_delay };
    let found = long(py, None, move |_| fopdt::fit(&op, &pv, sample_time, &options))?;
    let found = found.map_err(unfit)?;
    Ok(dict!(py,
        "gain": found.gain.value,
        "gain_error": found.gain.error,
        "time_constant_s": found.time_constant_s.map(|e| e.value),
        "time_constant_error_s": found.time_constant_s.map(|e| e.error),
        "dead_time_s": found.dead_time_s.value,
        "dead_time_error_s": found.dead_time_s.error,
        "delay": found.delay,
        "explained": found.fit,
        "pv": PyArray1::from_vec(py, found.pv),
    ))
}

/// An ARX model.
#[pyfunction]
pub fn fit_arx<'py>(
    py: Python<'py>,
    op: Signal<'py>,
    pv: Signal<'py>,
    longest_delay: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (op, pv) = (op.as_slice()?.to_vec(), pv.as_slice()?.to_vec());
    let found = long(py, None, move |_| arx::fit(&op, &pv, longest_delay))?.map_err(unfit)?;
    Ok(dict!(py,
        "gain": found.gain(),
        "delay": found.delay,
        "constant": found.constant,
        "past": found.past,
        "taps": found.taps,
        "residual_std": found.residual_std,
        "explained": found.fit,
        "predicted": PyArray1::from_vec(py, found.predicted),
    ))
}

/// An ARX model with a drifting disturbance; `None` if nothing can be fitted.
#[pyfunction]
pub fn fit_earx<'py>(
    py: Python<'py>,
    input: Signal<'py>,
    output: Signal<'py>,
    delay: usize,
    walk: f64,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let (input, output) = (input.as_slice()?.to_vec(), output.as_slice()?.to_vec());
    let found = long(py, None, move |_| earx::fit(&input, &output, delay, walk))?;
    let dict = |found: earx::Earx| {
        Ok(dict!(py,
            "past": found.past,
            "taps": found.taps,
            "error": found.error,
            "variance": found.variance,
            "log_likelihood": found.log_likelihood,
            "samples": found.samples,
            "process": PyArray1::from_vec(py, found.process),
            "disturbance": PyArray1::from_vec(py, found.disturbance),
            "predicted": PyArray1::from_vec(py, found.predicted),
        ))
    };
    found.map(dict).transpose()
}

/// A valve model before a linear process, by one of the published methods.
#[pyfunction]
pub fn fit_hammerstein<'py>(
    py: Python<'py>,
    method: &str,
    op: Signal<'py>,
    pv: Signal<'py>,
    sample_time: f64,
    period_s: Option<f64>,
    threshold: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    type Method = fn(
        &[f64],
        &[f64],
        Option<f64>,
        f64,
    ) -> Result<(HammersteinFit, Option<karra_karim::KarraKarim>), Abstention>;
    let (fit, least): (Method, f64) = match method {
        "srinivasan" => (
            |op, pv, period, least| Ok((srinivasan::fit(op, pv, period, least)?, None)),
            srinivasan::LEAST,
        ),
        "lee" => (|op, pv, period, least| Ok((lee::fit(op, pv, period, least)?, None)), lee::LEAST),
        "jelali" => {
            (|op, pv, period, least| Ok((jelali::fit(op, pv, period, least)?, None)), jelali::LEAST)
        }
        _ => (
            |op, pv, period, least| {
                let found = karra_karim::fit(op, pv, period, least)?;
                Ok((found.fit.clone(), Some(found)))
            },
            karra_karim::LEAST,
        ),
    };
    let segment = segment(&op, Some(pv), None, None, sample_time)?;
    let least = threshold.unwrap_or(least);
    let (fit, kinds) = long(py, None, move |_| {
        let period = match period_s {
            Some(period) => Some(period / sample_time),
            None => stiction::diagnose::subject(&segment, LoopType::Unknown).period,
        };
        fit(&segment.op, segment.pv.as_deref().unwrap_or_default(), period, least)
    })?
    .map_err(unfit)?;
    let (s, gain): (Vec<f64>, Vec<f64>) = fit.profile.iter().copied().unzip();
    Ok(dict!(py,
        "method": method,
        "model": fit.model.describe().name,
        "S": fit.s,
        "J": fit.j,
        "sticks": fit.sticks,
        "gain": fit.gain,
        "threshold": fit.threshold,
        "delay": fit.delay,
        "profile_S": PyArray1::from_vec(py, s),
        "profile_gain": PyArray1::from_vec(py, gain),
        "factor": fit.factor,
        "first": fit.from,
        "op": PyArray1::from_vec(py, fit.op),
        "vp": PyArray1::from_vec(py, fit.vp),
        "pv": PyArray1::from_vec(py, fit.pv),
        "fitted": PyArray1::from_vec(py, fit.fitted),
        "cause": kinds.as_ref().map(|found| found.cause.name()),
        "disturbance_share": kinds.as_ref().map(|found| found.disturbance_share),
        "disturbance": kinds.map(|found| PyArray1::from_vec(py, found.disturbance)),
    ))
}

fn valve_fit<'py>(py: Python<'py>, fit: &ValveFit) -> PyResult<Bound<'py, PyDict>> {
    let (s, mse): (Vec<f64>, Vec<f64>) = fit.profile.iter().copied().unzip();
    Ok(dict!(py,
        "model": fit.model.describe().name,
        "s_over_span": fit.s_over_span,
        "j_over_s": fit.j_over_s,
        "delay": fit.delay,
        "mse": fit.mse,
        "gain": fit.gain,
        "information": fit.information,
        "jump_gain": fit.jump_gain,
        "width": fit.width,
        "profile_s": PyArray1::from_vec(py, s),
        "profile_mse": PyArray1::from_vec(py, mse),
    ))
}

/// Compares a sticking valve with a valve that follows the OP.
#[pyfunction]
pub fn weigh_hammerstein<'py>(
    py: Python<'py>,
    op: Signal<'py>,
    pv: Signal<'py>,
    sample_time: f64,
    period_s: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let segment = segment(&op, Some(pv), None, None, sample_time)?;
    let evidence = long(py, None, move |_| -> Result<ModelEvidence, Abstention> {
        let period = match period_s {
            Some(period) => Some(period / sample_time),
            None => stiction::diagnose::subject(&segment, LoopType::Unknown).period,
        };
        let none = || Abstention("no period was found; give period_s".to_owned());
        let flat = || Abstention("the OP or the PV does not move".to_owned());
        let op = standardised(&segment.op).ok_or_else(flat)?;
        let pv = standardised(segment.pv.as_deref().unwrap_or_default()).ok_or_else(flat)?;
        hammerstein::weigh(
            &op,
            &pv,
            period.ok_or_else(none)?,
            &hammerstein::HammersteinOptions::default(),
        )
    })?
    .map_err(unfit)?;
    let slips = evidence.slips;
    Ok(dict!(py,
        "samples": evidence.samples,
        "op_span": evidence.op_span,
        "linear_mse": evidence.linear.mse,
        "two_phase": valve_fit(py, &evidence.two_phase)?,
        "he": valve_fit(py, &evidence.he)?,
        "best": evidence.best().model.describe().name,
        "kurtosis": evidence.kurtosis,
        "forward_gain": evidence.forward_gain,
        "reversed_gain": evidence.reversed_gain,
        "walk_gain": evidence.walk_gain,
        "over_load": evidence.over_load,
        "over_placebo": evidence.over_placebo,
        "output_error_gain": evidence.output_error.gain(),
        "over_sensor": evidence.output_error.over_sensor(),
        "slip_rate": slips.rate,
        "slip_concentration": slips.concentration,
        "slip_removed": slips.removed,
    ))
}

fn position_fit<'py>(py: Python<'py>, fit: PositionFit) -> PyResult<Bound<'py, PyDict>> {
    Ok(dict!(py,
        "model": fit.model.describe().name,
        "bands": Bands(fit.bands),
        "gain": fit.gain,
        "offset": fit.offset,
        "delay": fit.delay,
        "rmse": fit.rmse,
        "explained": fit.explained,
        "information": fit.information,
        "slips": fit.slips,
        "vp": PyArray1::from_vec(py, fit.vp),
    ))
}

/// All valve models fitted to a recorded position.
#[pyfunction]
pub fn fit_valve_position<'py>(
    py: Python<'py>,
    op: Signal<'py>,
    vp: Signal<'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let (op, vp) = (op.as_slice()?.to_vec(), vp.as_slice()?.to_vec());
    let fits = long(py, None, move |_| position::fit(&op, &vp))?.map_err(unfit)?;
    let interval = |of: position::Interval| (of.value, of.low, of.high);
    let (s, j) = (interval(fits.s), interval(fits.j));
    let ranked = fits.ranked.into_iter().map(|fit| position_fit(py, fit));
    Ok(dict!(py, "S": s, "J": j, "ranked": ranked.collect::<PyResult<Vec<_>>>()?))
}

/// A stem with friction fitted to a recorded position.
#[pyfunction]
pub fn fit_valve_stem<'py>(
    py: Python<'py>,
    op: Signal<'py>,
    vp: Signal<'py>,
    sample_time: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let (op, vp) = (op.as_slice()?.to_vec(), vp.as_slice()?.to_vec());
    let fit = long(py, None, move |_| physical::fit(&op, &vp, sample_time))?.map_err(unfit)?;
    let explains_better = fit.explains_better();
    let pair = |of: physical::StemEstimate| (of.value, of.deviation);
    Ok(dict!(py,
        "static_band": pair(fit.static_band),
        "coulomb_band": pair(fit.coulomb_band),
        "lag_s": pair(fit.lag_s),
        "bands": Bands(fit.bands),
        "gain": fit.gain,
        "offset": fit.offset,
        "rmse": fit.rmse,
        "explained": fit.explained,
        "information": fit.information,
        "slips": fit.slips,
        "vp": PyArray1::from_vec(py, fit.vp),
        "data_driven": position_fit(py, fit.data_driven)?,
        "explains_better": explains_better,
        "unidentified": fit.unidentified,
    ))
}

/// S and J of a cycle in closed form.
#[pyfunction]
pub fn cycle_bands(
    period_s: f64,
    op_amplitude: f64,
    process_gain: f64,
    controller_gain: f64,
    time_constant_s: f64,
    dead_time_s: f64,
) -> PyResult<Bands> {
    let known = CancelledLoop { process_gain, controller_gain, time_constant_s, dead_time_s };
    cycle_closed_form::bands(&known, period_s, op_amplitude).map(Bands).map_err(unfit)
}

/// All features of evidence.
#[pyfunction]
pub fn evidence_features(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let op_only: HashSet<usize> = op_only().collect();
    let of = |(place, feature): (usize, &stiction::evidence::Feature)| {
        Ok(dict!(py,
            "name": feature.name,
            "meaning": feature.meaning,
            "line": feature.line.name(),
            "monotone": feature.monotone,
            "op_only": op_only.contains(&place),
        ))
    };
    features().enumerate().map(of).collect()
}

/// The evidence in a segment.
#[pyfunction]
pub fn evidence_of<'py>(
    py: Python<'py>,
    op: Signal<'py>,
    pv: Option<Signal<'py>>,
    sp: Option<Signal<'py>>,
    sample_time: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let segment = segment(&op, pv, sp, None, sample_time)?;
    let op_only = segment.pv.is_none();
    let evidence = long(py, None, move |_| Evidence::of(&segment))?.map_err(unfit)?;
    let z = evidence.information.as_ref().map_or(0.0, |told| told.z());
    let named = features().map(|f| f.name).zip(evidence.values);
    Ok(dict!(py,
        "values": named.into_py_dict(py)?,
        "op_span": evidence.op_span,
        "period_s": evidence.period_s,
        "op_only": op_only,
        "z": z,
    ))
}

/// The result of the frozen model for the evidence.
#[pyfunction]
pub fn weigh_evidence<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    op_span: f64,
    op_only: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let bundle = shipped().map_err(refused)?;
    let says = bundle.weigh(&values, op_span, op_only).map_err(refused)?;
    let triple = |e: Estimate| (e.value, e.low, e.high);
    let lines = says.lines.iter().map(|(line, p)| (line.name(), *p));
    let causes = says.causes.iter().map(|(cause, p)| (cause.name(), *p));
    Ok(dict!(py,
        "probability": says.probability,
        "lines": lines.into_py_dict(py)?,
        "causes": causes.into_py_dict(py)?,
        "S": triple(says.s),
        "J_over_S": triple(says.j_over_s),
        "limit": says.limit,
        "distance": says.distance,
    ))
}

/// The provenance of the frozen model.
#[pyfunction]
pub fn verdict_provenance(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let bundle = shipped().map_err(refused)?;
    let from = &bundle.provenance;
    Ok(dict!(py,
        "command": &from.command,
        "population": from.population,
        "seed": from.seed,
        "trained": from.trained,
        "calibrated": from.calibrated,
        "features": bundle.features.clone(),
        "coverage": stiction::fusion::COVERAGE,
    ))
}
