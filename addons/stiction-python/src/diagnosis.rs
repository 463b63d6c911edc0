//! Diagnoses of recordings, and their combination for one valve.

use crate::detect::{evidence_dict, methods};
use crate::dict::{dict, plain};
use crate::errors::refused;
use crate::long::long;
use crate::recordings::{Recording, segment_dict};
use crate::table::{ArrowTable, counts, flags, numbers, texts};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use rayon::prelude::*;
use std::sync::Arc;
use stiction::diagnose::{
    self, Detectors, DiagnoseOptions, Estimate, Grade, KpiOptions, Observation, VerdictClass,
};
use stiction::evidence::features;
use stiction::recording::{GridOptions, LoopType};
use stiction_report::document::{Document, Loop, Source};
use stiction_report::report::{self, Fitted};
use stiction_report::table::{COLUMNS, Cells};

/// Name and version of the program, as documents show them.
const TOOL: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// A diagnosis, kept for its report and its plots.
#[pyclass(frozen, module = "stiction._core", from_py_object)]
#[derive(Debug, Clone)]
pub struct Diagnosed {
    diagnosis: Arc<diagnose::Diagnosis>,
    source: Source,
}

impl Diagnosed {
    fn found(&self) -> Loop<'_> {
        Loop::new(&self.source, &self.diagnosis)
    }
}

#[pymethods]
impl Diagnosed {
    /// The diagnosis as a document.
    fn document<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &*self.diagnosis)
    }

    /// The judged signals.
    fn segment<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.diagnosis.segment().map(|segment| segment_dict(py, segment)).transpose()
    }

    /// The weighed evidence.
    fn weighing<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(weighing) = &self.diagnosis.evidence else { return Ok(None) };
        let names = features().map(|feature| feature.name);
        let lines = weighing.lines.iter().map(|(line, p)| (line.name(), *p));
        let causes = weighing.causes.iter().map(|(cause, p)| (cause.name(), *p));
        Ok(Some(dict!(py,
            "probability": weighing.probability,
            "lines": lines.into_py_dict(py)?,
            "causes": causes.into_py_dict(py)?,
            "S": plain(py, &weighing.s)?,
            "J_over_S": plain(py, &weighing.j_over_s)?,
            "limit": weighing.limit,
            "z": weighing.z,
            "op_range": weighing.op_range,
            "distance": weighing.distance,
            "strangest": weighing.strangest.clone(),
            "changes": plain(py, &weighing.changes)?,
            "features": names.zip(weighing.typical().values.iter().copied()).into_py_dict(py)?,
        )))
    }

    /// The evidence of a method.
    fn method_evidence<'py>(
        &self,
        py: Python<'py>,
        method: &str,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let diagnosis = Arc::clone(&self.diagnosis);
        evidence_dict(py, method, move |look| look(&diagnosis.subject()?))
    }

    /// The rank of the loop in a list, the worst lowest.
    fn rank(&self) -> f64 {
        self.diagnosis.rank()
    }

    /// The observation of the valve at a time.
    fn observation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.diagnosis.observation(self.diagnosis.start.unwrap_or(0.0)))
    }
}

/// A value with the ends of its interval.
type Triple = (f64, f64, f64);
/// An observation: time, class, grade, probability, S, J, weight, windows.
type Seen = (
    f64,
    String,
    Option<String>,
    Option<f64>,
    Option<Triple>,
    Option<Triple>,
    f64,
    f64,
    Option<String>,
);

/// Information on loops for their diagnosis.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct LoopOptions {
    loop_type: Option<String>,
    /// None means all.
    detectors: Option<Vec<String>>,
    sample_time: Option<f64>,
    dead_time: Option<f64>,
}

impl LoopOptions {
    /// The options with this information.
    pub fn options(self) -> PyResult<DiagnoseOptions> {
        let loop_type = self.loop_type.map(|name| LoopType::by_name(&name)).transpose();
        let detectors = match self.detectors {
            None => Detectors::All,
            Some(names) if names.is_empty() => Detectors::None,
            Some(names) => Detectors::Only(methods(&names)?),
        };
        Ok(DiagnoseOptions {
            loop_type: loop_type.map_err(refused)?,
            grid: GridOptions { sample_time: self.sample_time },
            kpis: KpiOptions { dead_time: self.dead_time },
            detectors,
            ..DiagnoseOptions::default()
        })
    }
}

/// Diagnoses recordings, in their order.
#[pyfunction]
pub fn diagnose_recordings(
    py: Python<'_>,
    recordings: Vec<Recording>,
    told: LoopOptions,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<Diagnosed>> {
    let options = told.options()?;
    let sources: Vec<(String, Source)> =
        recordings.iter().map(|each| (each.recording.name.clone(), each.source.clone())).collect();
    let results = long(py, progress, move |progress| {
        let one = |each: &Recording| {
            let result =
                (!progress.is_cancelled()).then(|| diagnose::diagnose(&each.recording, &options));
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

/// The document of diagnoses.
#[pyfunction]
pub fn diagnoses_document(py: Python<'_>, diagnoses: Vec<Diagnosed>) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &Document::new(TOOL, diagnoses.iter().map(Diagnosed::found).collect()))
}

/// The report on diagnoses as HTML.
#[pyfunction]
pub fn diagnoses_html(py: Python<'_>, diagnoses: Vec<Diagnosed>) -> PyResult<String> {
    let html = long(py, None, move |_| {
        let fit = |each: &Diagnosed| Fitted::of_accused(&each.diagnosis);
        let fits: Vec<_> = diagnoses.iter().map(fit).collect();
        let fitted = diagnoses.iter().zip(&fits).map(|(each, fit)| each.found().with_fit(fit));
        report::html(TOOL, &fitted.collect::<Vec<_>>())
    })?;
    html.map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Diagnoses as a table with one row per loop.
#[pyfunction]
pub fn diagnoses_table(diagnoses: Vec<Diagnosed>) -> PyResult<ArrowTable> {
    let all: Vec<Loop<'_>> = diagnoses.iter().map(Diagnosed::found).collect();
    let columns = COLUMNS.iter().map(|column| match column.cells {
        Cells::Texts(cell) => texts(column.name, all.iter().map(cell)),
        Cells::Numbers(cell) => numbers(column.name, all.iter().map(|l| Cells::number(cell(l)))),
        Cells::Counts(cell) => {
            counts(column.name, all.iter().map(|l| i64::try_from(cell(l)?).ok()))
        }
        Cells::Flags(cell) => flags(column.name, all.iter().map(cell)),
    });
    ArrowTable::of(columns.collect())
}

fn observations(seen: Vec<Seen>) -> PyResult<Vec<Observation>> {
    let estimate = |(value, low, high)| Estimate { value, low, high };
    let observation = |(time, class, grade, probability, s, j, weight, windows, pool): Seen| {
        let class = VerdictClass::by_name(&class).map_err(refused)?;
        let unknown = |word: &String| PyValueError::new_err(format!("\"{word}\" is no grade"));
        let known = |word: String| {
            Grade::ALL.into_iter().find(|grade| grade.name() == word).ok_or_else(|| unknown(&word))
        };
        let grade = grade.map(known).transpose()?;
        let (s, j) = (s.map(estimate), j.map(estimate));
        let pool = pool.map(|pool| pool.parse().map_err(refused)).transpose()?;
        Ok(Observation { time, class, grade, probability, s, j, weight, windows, pool })
    };
    seen.into_iter().map(observation).collect()
}

/// The combination of observations of one valve.
#[pyfunction]
pub fn observations_combined(py: Python<'_>, seen: Vec<Seen>) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &diagnose::combine(&observations(seen)?).map_err(refused)?)
}

/// Observations of one valve before and after a repair.
#[pyfunction]
pub fn observations_repair(
    py: Python<'_>,
    seen: Vec<Seen>,
    time: f64,
) -> PyResult<Bound<'_, PyAny>> {
    plain(py, &diagnose::repair(&observations(seen)?, time).map_err(refused)?)
}
