//! Diagnoses: from a recording to a verdict, and what several diagnoses of one valve say together.

use crate::detectors::{evidence_dict, finding_dict, methods};
use crate::dict::dict;
use crate::errors::refused;
use crate::long::long;
use crate::oscillation::oscillation_dict;
use crate::recordings::{Recording, stretch_dict};
use crate::table::{Table, counts, flags, numbers, texts};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::sync::Arc;
use stiction::diagnose::{
    self, Contrast, Detectors, Estimate, KpiOptions, Observation, Options, VerdictClass,
};
use stiction::evidence::features;
use stiction::recording::{GridOptions, LoopType};
use stiction_report::document::{self, Document, Source};
use stiction_report::report;

/// The program with its version, as documents name it.
const TOOL: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// A part of a document as JSON.
pub fn json<T>(part: &T) -> PyResult<String>
where
    T: serde::Serialize,
{
    serde_json::to_string(part).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

/// A diagnosis, kept for its report and its plots.
#[pyclass(frozen, module = "stiction._core", from_py_object)]
#[derive(Debug, Clone)]
pub struct Diagnosed {
    diagnosis: Arc<diagnose::Diagnosis>,
    source: Source,
}

impl Diagnosed {
    fn document(&self) -> document::Loop {
        document::Loop::new(&self.diagnosis, self.source.clone(), None)
    }
}

#[pymethods]
impl Diagnosed {
    /// Its part of the document as JSON, and, out of that, what each method says: by far the most of it.
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<(String, Vec<Bound<'py, PyDict>>)> {
        let mut document = self.document();
        let findings = std::mem::take(&mut document.detectors).into_iter();
        let findings = findings.map(|found| finding_dict(py, found)).collect::<PyResult<_>>()?;
        Ok((json(&document)?, findings))
    }

    /// The signals that were judged.
    fn stretch<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.diagnosis.stretch().map(|stretch| stretch_dict(py, stretch)).transpose()
    }

    /// The oscillation that speaks for the loop, with its signal.
    fn oscillation<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(&'static str, Bound<'py, PyDict>)>> {
        let from = self.diagnosis.stretch().map_or(0.0, |stretch| stretch.from);
        let dict = |(signal, found)| Ok((signal, oscillation_dict(py, found, from)?));
        self.diagnosis.oscillation().map(dict).transpose()
    }

    /// The evidence that was weighed.
    fn weighing<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(weighing) = &self.diagnosis.evidence else { return Ok(None) };
        let names = || features().map(|feature| feature.name);
        let lines: Vec<_> = weighing.lines.iter().map(|(l, p)| (l.name(), *p)).collect();
        let causes: Vec<_> = weighing.causes.iter().map(|(c, p)| (c.name(), *p)).collect();
        let typical: Vec<_> = names().zip(weighing.typical().values.iter().copied()).collect();
        Ok(Some(dict!(py,
            "probability": weighing.probability,
            "lines": lines,
            "causes": causes,
            "s": triple(Some(weighing.s)),
            "j_over_s": triple(Some(weighing.j_over_s)),
            "limit": weighing.limit,
            "z": weighing.z,
            "op_range": weighing.op_range,
            "distance": weighing.distance,
            "strangest": weighing.strangest.clone(),
            "features": typical,
        )))
    }

    /// What a method looked at.
    fn method_evidence<'py>(
        &self,
        py: Python<'py>,
        method: &str,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let diagnosis = Arc::clone(&self.diagnosis);
        evidence_dict(py, method, move |look| look(&diagnosis.subject()?))
    }

    /// Where the loop stands in a ranked list, the worst lowest.
    fn rank(&self) -> f64 {
        self.diagnosis.rank()
    }

    /// What it says of the valve at a time.
    fn observation(&self) -> Option<Seen> {
        let seen = self.diagnosis.observation(self.diagnosis.start.unwrap_or(0.0))?;
        let (s, j) = (triple(seen.s), triple(seen.j));
        let class = seen.class.name().to_owned();
        Some((seen.time, class, seen.probability, s, j, seen.weight, seen.windows))
    }
}

/// A value with the ends of its interval.
type Triple = (f64, f64, f64);
/// An observation: time, class, probability, S, J, weight, windows.
type Seen = (f64, String, Option<f64>, Option<Triple>, Option<Triple>, f64, f64);

fn triple(estimate: Option<Estimate>) -> Option<Triple> {
    estimate.map(|e| (e.value, e.low, e.high))
}

/// What may be told about loops before they are diagnosed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Told {
    loop_type: Option<String>,
    /// None is all.
    detectors: Option<Vec<String>>,
    sample_time: Option<f64>,
    dead_time: Option<f64>,
}

impl Told {
    fn options(self) -> PyResult<Options> {
        let loop_type = self.loop_type.map(|name| LoopType::by_name(&name)).transpose();
        let detectors = match self.detectors {
            None => Detectors::All,
            Some(names) if names.is_empty() => Detectors::None,
            Some(names) => Detectors::Only(methods(&names)?),
        };
        Ok(Options {
            loop_type: loop_type.map_err(refused)?,
            grid: GridOptions { sample_time: self.sample_time },
            kpis: KpiOptions { dead_time: self.dead_time },
            detectors,
            evidence: false,
        })
    }
}

/// Diagnoses recordings, in their order.
#[pyfunction]
fn diagnose_recordings(
    py: Python<'_>,
    recordings: Vec<Recording>,
    told: Told,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<Diagnosed>> {
    let options = told.options()?;
    let sources: Vec<(String, Source)> =
        recordings.iter().map(|each| (each.recording.name.clone(), each.source.clone())).collect();
    let results = long(py, progress, move |progress| {
        let one = |each: &Recording| {
            let result =
                (!progress.is_given_up()).then(|| diagnose::diagnose(&each.recording, &options));
            progress.one();
            result
        };
        recordings.par_iter().filter_map(one).collect::<Vec<_>>()
    })?;
    let mut all = vec![];
    for (result, (name, source)) in results.into_iter().zip(sources) {
        let diagnosis =
            result.map_err(|error| PyValueError::new_err(format!("loop {name}: {error}")))?;
        all.push(Diagnosed { diagnosis: Arc::new(diagnosis), source });
    }
    Ok(all)
}

/// The document of diagnoses as JSON.
#[pyfunction]
fn diagnoses_json(py: Python<'_>, diagnoses: Vec<Diagnosed>) -> PyResult<String> {
    py.detach(|| {
        let loops = diagnoses.iter().map(Diagnosed::document).collect();
        json(&Document::new(TOOL, loops))
    })
}

/// The report on diagnoses as HTML.
#[pyfunction]
fn diagnoses_html(py: Python<'_>, diagnoses: Vec<Diagnosed>) -> PyResult<String> {
    let html = long(py, None, move |_| {
        let cases: Vec<_> = diagnoses
            .iter()
            .map(|Diagnosed { diagnosis, source }| report::Case {
                diagnosis,
                source,
                overruled: None,
            })
            .collect();
        report::html(TOOL, &cases)
    })?;
    html.map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Diagnoses as a table, one row a loop.
#[pyfunction]
fn diagnoses_table(diagnoses: Vec<Diagnosed>) -> PyResult<Table> {
    let all: Vec<&diagnose::Diagnosis> = diagnoses.iter().map(|each| &*each.diagnosis).collect();
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    let number = |name, of: &dyn Fn(&diagnose::Diagnosis) -> Option<f64>| {
        numbers(name, all.iter().map(|each| finite(of(each))))
    };
    let text = |name, of: &dyn Fn(&diagnose::Diagnosis) -> Option<String>| {
        texts(name, all.iter().map(|each| of(each)))
    };
    let oscillation =
        |each: &diagnose::Diagnosis| each.oscillation().map(|(_, found)| found.clone());
    let votes = |of: fn(diagnose::Votes) -> usize| {
        all.iter().map(move |each| i64::try_from(of(each.verdict.votes)).ok()).collect::<Vec<_>>()
    };
    Table::of(vec![
        text("loop", &|d| Some(d.name.clone())),
        texts("file", diagnoses.iter().map(|each| Some(&each.source.file))),
        text("type", &|d| Some(d.loop_type.name().to_owned())),
        text("fitness", &|d| Some(d.fitness.class.name().to_owned())),
        counts("samples", all.iter().map(|d| d.stretch().and_then(|s| s.len().try_into().ok()))),
        number("sample_time_s", &|d| d.stretch().map(|s| s.sample_time)),
        flags("oscillates", all.iter().map(|d| d.oscillation().map(|(_, found)| found.found))),
        number("period_s", &|d| oscillation(d)?.period_s),
        number("regularity", &|d| oscillation(d)?.regularity),
        number("amplitude", &|d| oscillation(d)?.amplitude),
        text("verdict", &|d| Some(d.verdict.class.name().to_owned())),
        number("probability", &|d| d.verdict.probability),
        text("basis", &|d| Some(d.verdict.basis.name().to_owned())),
        counts("votes_sticks", votes(|votes| votes.sticks)),
        counts("votes_does_not_stick", votes(|votes| votes.does_not_stick)),
        number("S", &|d| d.stiction.s.map(|s| s.value)),
        number("S_low", &|d| d.stiction.s.map(|s| s.low)),
        number("S_high", &|d| d.stiction.s.map(|s| s.high)),
        number("J", &|d| d.stiction.j.map(|j| j.value)),
        number("J_low", &|d| d.stiction.j.map(|j| j.low)),
        number("J_high", &|d| d.stiction.j.map(|j| j.high)),
        number("S_below", &|d| d.verdict.s_below.map(|limit| limit.value)),
        text("alternative", &|d| Some(d.verdict.alternatives.first()?.cause.name().to_owned())),
        number("alternative_likelihood", &|d| Some(d.verdict.alternatives.first()?.likelihood)),
    ])
}

fn observations(seen: Vec<Seen>) -> PyResult<Vec<Observation>> {
    let estimate = |(value, low, high)| Estimate { value, low, high };
    let observation = |(time, class, probability, s, j, weight, windows): Seen| {
        let class = VerdictClass::by_name(&class).map_err(refused)?;
        let (s, j) = (s.map(estimate), j.map(estimate));
        Ok(Observation { time, class, probability, s, j, weight, windows })
    };
    seen.into_iter().map(observation).collect()
}

/// What observations of one valve say together.
#[pyfunction]
fn observations_combined(py: Python<'_>, seen: Vec<Seen>) -> PyResult<Bound<'_, PyDict>> {
    let history = diagnose::combine(&observations(seen)?).map_err(refused)?;
    let drift = history.drift.map(|drift| {
        Ok::<_, PyErr>(dict!(py,
            "per_day": drift.per_day,
            "low": drift.low,
            "high": drift.high,
            "p_value": drift.p_value,
            "robust_per_day": drift.robust_per_day,
            "robust_p_value": drift.robust_p_value,
            "significant": drift.is_significant(),
        ))
    });
    Ok(dict!(py,
        "observations": history.observations,
        "decided": history.decided,
        "class_": history.class.name(),
        "probability": history.probability,
        "drift": drift.transpose()?,
        "trend": history.trend,
    ))
}

/// Observations of one valve before and after a repair.
#[pyfunction]
fn observations_repair(py: Python<'_>, seen: Vec<Seen>, time: f64) -> PyResult<Bound<'_, PyDict>> {
    let repair = diagnose::repair(&observations(seen)?, time).map_err(refused)?;
    let contrast = |contrast: Option<Contrast>| {
        let dict = |c: Contrast| {
            Ok::<_, PyErr>(dict!(py,
                "before_count": c.before_count,
                "after_count": c.after_count,
                "before": c.before,
                "after": c.after,
                "p_value": c.p_value,
                "delta": c.delta,
                "significant": c.is_significant(),
            ))
        };
        contrast.map(dict).transpose()
    };
    Ok(dict!(py,
        "time_s": repair.time,
        "before": repair.before,
        "after": repair.after,
        "outcome": repair.outcome.name(),
        "words": repair.words.clone(),
        "probability": contrast(repair.probability)?,
        "S": contrast(repair.s)?,
    ))
}

pub fn register(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add_class::<Diagnosed>()?;
    m.add_function(wrap_pyfunction!(diagnose_recordings, m)?)?;
    m.add_function(wrap_pyfunction!(diagnoses_json, m)?)?;
    m.add_function(wrap_pyfunction!(diagnoses_html, m)?)?;
    m.add_function(wrap_pyfunction!(diagnoses_table, m)?)?;
    m.add_function(wrap_pyfunction!(observations_combined, m)?)?;
    m.add_function(wrap_pyfunction!(observations_repair, m)?)
}
