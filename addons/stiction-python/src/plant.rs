//! Plants of many loops: folders of files, and tables of other engines.

use crate::dict::plain;
use crate::long::long;
use crate::plant_table;
use crate::recordings::sheet_of;
use crate::table::ArrowTable;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3_arrow::PySchema;
use pyo3_arrow::input::AnyRecordBatch;
use rayon::ThreadPoolBuilder;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction_io::layout;
use stiction_plant::groups::pairs::{self, Pair};
use stiction_plant::groups::{GroupOptions, LoopOfWeek};
use stiction_plant::ranking::LoopRow;
use stiction_plant::report::Known;
use stiction_plant::scan::Progress;
use stiction_plant::table::Row;
use stiction_plant::trace::Trace;
use stiction_plant::{
    Error, ScanOptions, Store, WindowRow, day, demo, plant_file, propose, samples, scan, summary,
    take, window,
};

/// A refusal of the library: `OSError` if the operating system or another writer is the cause, else `ValueError`.
fn refused(error: Error) -> PyErr {
    let words = error.to_string();
    match error {
        Error::File { .. } | Error::Locked { .. } => PyOSError::new_err(words),
        _ => PyValueError::new_err(words),
    }
}

fn day_of(text: &str) -> PyResult<i64> {
    day::parse(text).map_err(PyValueError::new_err)
}

/// Computes on this number of threads.
fn on<T: Send>(threads: Option<usize>, compute: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    let pool =
        pool.map_err(|e| PyRuntimeError::new_err(format!("no thread could be started: {e}")))?;
    Ok(pool.install(compute))
}

/// The content of a plant's file.
#[pyclass(frozen, module = "stiction._core")]
#[derive(Debug)]
pub struct Plant {
    text: String,
    origin: String,
    plant: Arc<plant_file::Plant>,
}

#[pymethods]
impl Plant {
    #[new]
    fn new(text: String, origin: String) -> PyResult<Self> {
        let plant = plant_file::Plant::parse(&text, &origin).map_err(refused)?;
        Ok(Self { text, origin, plant: Arc::new(plant) })
    }

    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    #[getter]
    fn zone(&self) -> &str {
        &self.plant.file.zone
    }

    #[getter]
    fn data(&self) -> Vec<String> {
        self.plant.file.data.clone()
    }

    /// The beginning of a day, s since 1970-01-01 UTC.
    fn begin(&self, day: i64) -> i64 {
        day::begin(day, &self.plant.zone) as i64
    }

    /// The day at an instant, s since 1970-01-01 UTC.
    fn day(&self, instant: f64) -> i64 {
        day::of(instant, &self.plant.zone)
    }

    fn settings_hash(&self, name: &str) -> String {
        self.plant.settings_hash(name)
    }

    /// The positions of the columns of times, tags and values, and of all columns about rows; None if their names do
    /// not show them. A wide table has neither tags nor values.
    #[allow(clippy::type_complexity)]
    fn shape(&self, columns: Vec<String>) -> Option<(usize, Option<(usize, usize)>, Vec<usize>)> {
        let columns: Vec<&str> = columns.iter().map(|name| &**name).collect();
        let found = layout::shape(&columns, &self.plant.options)?;
        Some((found.time, found.long, found.about_rows))
    }

    /// The loops among tags, or among all columns except those about rows. Each has its name, the positions of columns
    /// read with it, and the position of its OP.
    fn loops(
        &self,
        names: Vec<String>,
        about_rows: Vec<usize>,
    ) -> Vec<(String, Vec<usize>, usize)> {
        let names: Vec<&str> = names.iter().map(|name| &**name).collect();
        let found = samples::loops(&names, &about_rows, &self.plant).into_iter();
        found.map(|each| (each.name, each.tags, each.op)).collect()
    }

    /// The rows of all windows in a table.
    fn rows(
        &self,
        py: Python<'_>,
        table: AnyRecordBatch,
        threads: Option<usize>,
    ) -> PyResult<ArrowTable> {
        let (sheet, plant) = (sheet_of(samples::ORIGIN, table)?, Arc::clone(&self.plant));
        plant_table::arrow(&long(py, None, move |_| on(threads, || samples::rows(sheet, &plant)))??)
    }

    /// The row of one window, its trace, and its nominal number of days.
    fn window(
        &self,
        py: Python<'_>,
        table: AnyRecordBatch,
        name: String,
        day: i64,
        count: i64,
    ) -> PyResult<(ArrowTable, ArrowTable, i64)> {
        let (sheet, plant) = (sheet_of(samples::ORIGIN, table)?, Arc::clone(&self.plant));
        let judge = move |_: &_| on(Some(1), || samples::window(sheet, &plant, &name, day, count));
        let judged = long(py, None, judge)??;
        let row = plant_table::arrow(judged.row.as_slice())?;
        Ok((row, plant_table::arrow(judged.trace.as_slice())?, judged.days))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        Ok((py.get_type::<Self>().into_any(), (self.text.clone(), self.origin.clone())))
    }
}

/// Judges new data of a plant.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn plant_scan<'py>(
    py: Python<'py>,
    folder: PathBuf,
    since: Option<String>,
    loops: Option<String>,
    threads: Option<usize>,
    memory: Option<u64>,
    again: bool,
    time_limit_s: Option<u32>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let since = since.as_deref().map(day_of).transpose()?;
    let options = ScanOptions { since, loops, threads, memory, again, time_limit_s };
    let done = long(py, progress.as_ref(), move |progress| {
        let plant = plant_file::Plant::read(&folder)?;
        scan(&folder, &plant, &options, |now| {
            if let Progress::Written { done, .. } = now {
                progress.reached(done);
            }
            if progress.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    })?;
    plain(py, &done.map_err(refused)?)
}

/// The contents of a plant's data.
#[pyfunction]
pub fn plant_check<'py>(py: Python<'py>, folder: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let checked = long(py, None, move |_| {
        let plant = plant_file::Plant::read(&folder)?;
        Ok(summary::check(&folder, &plant, |_| {}))
    })?;
    plain(py, &checked.map_err(refused)?)
}

/// The results of a plant so far.
#[pyfunction]
pub fn plant_status<'py>(py: Python<'py>, folder: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let status = long(py, None, move |_| {
        let plant = plant_file::Plant::read(&folder)?;
        summary::status(&folder, &plant)
    })?;
    plain(py, &status.map_err(refused)?)
}

/// The valid rows of windows that begin between two days, the first included.
#[pyfunction]
pub fn plant_windows(
    py: Python<'_>,
    folder: PathBuf,
    since: Option<String>,
    until: Option<String>,
) -> PyResult<ArrowTable> {
    let since = since.as_deref().map(day_of).transpose()?;
    let until = until.as_deref().map(day_of).transpose()?;
    let rows = long(py, None, move |_| {
        let plant = plant_file::Plant::read(&folder)?;
        let begin = |day: i64| day::begin(day, &plant.zone) as i64;
        let (from, to) = (since.map_or(i64::MIN, begin), until.map_or(i64::MAX, begin));
        Store::of(&folder).rows_between(from, to)
    })?;
    plant_table::arrow(&rows.map_err(refused)?)
}

/// Writes rows judged elsewhere, with their traces, to the store of a plant, as a run.
#[pyfunction]
pub fn plant_take<'py>(
    py: Python<'py>,
    folder: PathBuf,
    table: AnyRecordBatch,
    traces: Option<AnyRecordBatch>,
) -> PyResult<Bound<'py, PyAny>> {
    let kept: Vec<Trace> = match traces {
        Some(traces) => plant_table::rows(traces, "traces")?,
        None => vec![],
    };
    let rows: Vec<WindowRow> = plant_table::rows(table, "windows")?;
    let done = long(py, None, move |_| {
        let plant = plant_file::Plant::read(&folder)?;
        take(&folder, &plant, &rows, &kept)
    })?;
    plain(py, &done.map_err(refused)?)
}

/// The parameters for finding pairs of loops of a week: the week, its beginning and end, and the period of each loop
/// that oscillates.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn plant_week(
    py: Python<'_>,
    folder: PathBuf,
    week: Option<String>,
) -> PyResult<(String, i64, i64, Vec<(String, Option<f64>)>)> {
    let found = long(py, None, move |_| {
        let (plant, known) = known(&folder, week)?;
        let (begin, end) = known.span(&plant);
        let loops = known.loops_of_week(&plant).into_iter().map(|own| (own.name, own.period_s));
        Ok((known.week().to_string(), begin, end, loops.collect()))
    })?;
    found.map_err(refused)
}

fn known(folder: &Path, week: Option<String>) -> Result<(plant_file::Plant, Known), Error> {
    let week = week.map(|text| text.parse().map_err(Error::Option)).transpose()?;
    let plant = plant_file::Plant::read(folder)?;
    let known = Known::without_groups(folder, &plant, week)?;
    Ok((plant, known))
}

/// The pairs of loops among some traces that may swing in step: all pairs, or the pairs of a loop in `block` with a
/// loop outside.
#[pyfunction]
pub fn plant_pairs(
    py: Python<'_>,
    traces: AnyRecordBatch,
    periods: Vec<(String, Option<f64>)>,
    span: (i64, i64),
    block: Option<BTreeSet<String>>,
) -> PyResult<ArrowTable> {
    let traces: Vec<Trace> = plant_table::rows(traces, "traces")?;
    let of = |(name, period_s)| LoopOfWeek { name, period_s, probability: None };
    let loops: Vec<LoopOfWeek> = periods.into_iter().map(of).collect();
    let find = move |_: &_| {
        on(Some(1), || pairs::pairs(&traces, &loops, &(span.0..span.1), block.as_ref()))
    };
    plant_table::arrow(&long(py, None, find)??)
}

/// The largest probability that may count, if `count` pairs of this many loops are as improbable as the last accepted
/// one.
#[pyfunction]
pub fn plant_most_that_counts(count: usize, loops: usize) -> f64 {
    pairs::most_that_counts(count, loops, &GroupOptions::default())
}

/// Keeps the pairs of a week for its report. `compared` lists their traces.
#[pyfunction]
pub fn plant_keep_pairs(
    py: Python<'_>,
    folder: PathBuf,
    week: String,
    table: AnyRecordBatch,
    compared: Vec<(String, i64, f64, String)>,
) -> PyResult<()> {
    let pairs: Vec<Pair> = plant_table::rows(table, "pairs")?;
    let of = |(name, start, unit, digest): (String, i64, f64, String)| {
        (name, start, unit.to_bits(), digest)
    };
    let compared = compared.into_iter().map(of).collect();
    let done = long(py, None, move |_| {
        let (plant, known) = known(&folder, Some(week))?;
        known.keep_pairs(&folder, &plant, &pairs, &compared)
    })?;
    done.map_err(refused)
}

/// The groups of loops that swing together in a week.
#[pyfunction]
pub fn plant_groups<'py>(
    py: Python<'py>,
    folder: PathBuf,
    week: Option<String>,
) -> PyResult<Bound<'py, PyAny>> {
    let found = long(py, None, move |_| {
        let (plant, known) = known(&folder, week)?;
        known.find_groups(&folder, &plant, &known.loops_of_week(&plant))
    })?;
    plain(py, &found.map_err(refused)?)
}

/// The ranking of a week, without groups.
#[pyfunction]
pub fn plant_ranking(
    py: Python<'_>,
    folder: PathBuf,
    week: Option<String>,
) -> PyResult<ArrowTable> {
    let rows = long(py, None, move |_| {
        let (plant, known) = known(&folder, week)?;
        let loops = known.ranking(&plant).loops.into_iter();
        Ok(loops.map(|ranked| ranked.row).collect::<Vec<LoopRow>>())
    })?;
    plant_table::arrow(&rows.map_err(refused)?)
}

/// A proposed plant file for files and folders of data.
#[pyfunction]
pub fn plant_propose(
    py: Python<'_>,
    folder: PathBuf,
    name: String,
    data: Vec<String>,
) -> PyResult<(String, usize, Vec<String>)> {
    let found = long(py, None, move |_| propose::propose(&folder, &name, &data))?;
    found.map(|own| (own.text, own.loops, own.doubts)).map_err(refused)
}

/// The schema of a table of pairs.
#[pyfunction]
pub fn plant_pairs_schema() -> PySchema {
    PySchema::new(plant_table::schema::<Pair>())
}

/// The columns of a table of pairs, as declared in Spark.
#[pyfunction]
pub fn plant_pairs_ddl() -> String {
    Pair::ddl()
}

/// Writes a plant with known truth.
#[pyfunction]
pub fn plant_demo(
    py: Python<'_>,
    folder: PathBuf,
    loops: usize,
    days: usize,
    seed: u64,
) -> PyResult<()> {
    long(py, None, move |_| demo::write(&folder, loops, days, seed, || {}))?.map_err(refused)
}

/// The schema of rows.
#[pyfunction]
pub fn plant_schema() -> PySchema {
    PySchema::new(plant_table::schema::<WindowRow>())
}

/// The schema of rows, as declared in Spark.
#[pyfunction]
pub fn plant_ddl() -> String {
    WindowRow::ddl()
}

/// The version of the verdict's training.
#[pyfunction]
pub fn model_version() -> String {
    window::model_version()
}
