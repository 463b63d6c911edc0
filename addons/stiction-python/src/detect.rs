//! The published detectors.

use crate::dict::{dict, plain};
use crate::errors::refused;
use crate::long::long;
use crate::oscillation::all_finite;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use rayon::prelude::*;
use stiction::Error;
use stiction::finding::{Applies, Decides, Needs};
use stiction::methods::{self, Detector, MethodId, Subject};
use stiction::recording::{LoopType, Segment};
use stiction_figure::{Figure, Panel, Series, Style};
use stiction_report::report::{Context, evidence};

/// Signals from Python.
pub type Signal<'py> = PyReadonlyArray1<'py, f64>;

/// All detectors.
#[pyfunction]
pub fn detector_methods(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let of = |detector: &dyn Detector| {
        let method = detector.method();
        let parameters = detector.parameters();
        let parameters = parameters.iter().map(|p| (p.name, (p.value, p.unit)));
        Ok(dict!(py,
            "name": method.name,
            "title": method.title,
            "source": method.source,
            "statistic": method.statistic,
            "rule": method.rule,
            "family": method.family.name(),
            "applies": match method.applies {
                Applies::AnyLoop => "any loop",
                Applies::SelfRegulating => "self-regulating loops",
                Applies::Integrating => "integrating loops",
            },
            "decides": match method.decides {
                Decides::Stiction => "stiction",
                Decides::Nonlinearity => "nonlinearity",
            },
            "needs": match method.needs {
                Needs::Op => "OP",
                Needs::OpAndPv => "OP and PV",
                Needs::Error => "PV",
                Needs::OpAndVp => "OP and VP",
            },
            "explains_oscillation": method.explains_oscillation,
            "parameters": parameters.into_py_dict(py)?,
        ))
    };
    methods::all().iter().map(|detector| of(&**detector)).collect()
}

/// A segment of signals of equal length, all finite.
pub fn segment(
    op: &Signal<'_>,
    pv: Option<Signal<'_>>,
    sp: Option<Signal<'_>>,
    vp: Option<Signal<'_>>,
    sample_time: f64,
) -> PyResult<Segment> {
    let op = op.as_slice()?.to_vec();
    all_finite("op", &op)?;
    let other = |name: &'static str, signal: Option<Signal<'_>>| -> PyResult<Option<Vec<f64>>> {
        let Some(signal) = signal else { return Ok(None) };
        let signal = signal.as_slice()?.to_vec();
        if signal.len() != op.len() {
            let (found, expected) = (signal.len(), op.len());
            return Err(refused(Error::Length { name, found, expected }));
        }
        all_finite(name, &signal)?;
        Ok(Some(signal))
    };
    let (pv, sp, vp) = (other("pv", pv)?, other("sp", sp)?, other("vp", vp)?);
    Ok(Segment { from: 0.0, sample_time, op, pv, sp, vp, bridged: 0 })
}

/// OP, PV, SP, VP, time between samples, period, and type of the loop.
#[derive(FromPyObject)]
pub struct Signals<'py>(
    Signal<'py>,
    Option<Signal<'py>>,
    Option<Signal<'py>>,
    Option<Signal<'py>>,
    f64,
    Option<f64>,
    String,
);

impl Signals<'_> {
    /// The segment, its loop type, and the given period.
    fn checked(self) -> PyResult<(Segment, LoopType, Option<f64>)> {
        let Self(op, pv, sp, vp, sample_time, period_s, loop_type) = self;
        let loop_type = LoopType::by_name(&loop_type).map_err(refused)?;
        Ok((segment(&op, pv, sp, vp, sample_time)?, loop_type, period_s))
    }
}

/// The given period in samples, or the period of the dominant oscillation.
fn period(segment: &Segment, loop_type: LoopType, told_s: Option<f64>) -> Option<f64> {
    match told_s {
        Some(period) => Some(period / segment.sample_time),
        None => stiction::diagnose::subject(segment, loop_type).period,
    }
}

/// The methods of these names.
pub fn methods(names: &[String]) -> PyResult<Vec<MethodId>> {
    names.iter().map(|name| name.parse().map_err(refused)).collect()
}

/// Runs detectors on a segment; without names, all of them. Without a period, the period of the dominant oscillation
/// is used.
#[pyfunction]
pub fn detect_stiction<'py>(
    py: Python<'py>,
    methods: Option<Vec<String>>,
    signals: Signals<'_>,
) -> PyResult<Bound<'py, PyAny>> {
    let detectors: Vec<_> = match methods {
        None => methods::all(),
        Some(names) => self::methods(&names)?.into_iter().map(MethodId::detector).collect(),
    };
    let (segment, loop_type, period_s) = signals.checked()?;
    let findings = long(py, None, move |progress| {
        let period = period(&segment, loop_type, period_s);
        let judge = |detector: &dyn Detector| {
            let subject = Subject::new(&segment, loop_type, period);
            (!progress.is_cancelled()).then(|| methods::judge(detector, &subject))
        };
        detectors.par_iter().filter_map(|detector| judge(&**detector)).collect::<Vec<_>>()
    })?;
    plain(py, &findings)
}

/// The evidence of a method in the subject of `with_subject`, as the report draws it: panels with named series;
/// `None` if there is nothing to draw.
pub fn evidence_dict<'py>(
    py: Python<'py>,
    method: &str,
    with_subject: impl FnOnce(&dyn Fn(&Subject<'_>) -> Option<Figure>) -> Option<Figure>
    + Send
    + 'static,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let method: MethodId = method.parse().map_err(refused)?;
    let figure = long(py, None, move |_| {
        with_subject(&|subject| {
            let period_s = subject.period.map(|period| period * subject.segment.sample_time);
            let context = Context { period_s, ..Context::default() };
            evidence::figure(&method.detector().judge(subject), subject, &context)
        })
    })?;
    let Some(figure) = figure else { return Ok(None) };
    let panel = |panel: Panel| {
        let each = |series: Series| {
            let style = match series.style {
                Style::Dashed => "dashed",
                Style::Dotted => "dotted",
                Style::Steps => "steps",
                Style::Points => "points",
                Style::Bars => "bars",
                _ => "line",
            };
            let [x, y] = [series.x, series.y].map(|values| PyArray1::from_vec(py, values));
            (series.label, x, y, style)
        };
        let series: Vec<_> = panel.series.into_iter().map(each).collect();
        Ok(dict!(py, "x_label": panel.x_label, "y_label": panel.y_label, "series": series))
    };
    Ok(Some(dict!(py,
        "method": method.name(),
        "caption": figure.caption,
        "panels": figure.panels.into_iter().map(panel).collect::<PyResult<Vec<_>>>()?,
    )))
}

/// The evidence of a method in signals. Without a period, the period of the dominant oscillation is used.
#[pyfunction]
pub fn method_evidence<'py>(
    py: Python<'py>,
    method: &str,
    signals: Signals<'_>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let (segment, loop_type, period_s) = signals.checked()?;
    evidence_dict(py, method, move |look| {
        look(&Subject::new(&segment, loop_type, period(&segment, loop_type, period_s)))
    })
}
