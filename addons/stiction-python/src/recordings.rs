//! Recordings of loops from files, tables and arrays.

use crate::arrays::{as_numbers, numbers};
use crate::errors::{KEYWORDS, refused, unread};
use crate::long::long;
use arrow_array::cast::AsArray;
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_cast::cast;
use arrow_schema::{ArrowError, DataType, TimeUnit};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3_arrow::PyTable;
use pyo3_arrow::input::AnyRecordBatch;
use std::path::PathBuf;
use std::sync::Arc;
use stiction::recording::{
    self, Channel, Columns, GridOptions, LoopType, MaskedKind, MaskedSample, Mode, Modes,
    PlantTime, Quality, Range, RangeSource,
};
use stiction_io::sheet::{Cells, Column};
use stiction_io::{ReadOptions, Reading, Sheet};
use stiction_report::document::Source;

/// A loop as a plant recorded it, with OP and, where known, PV, SP, VP and mode.
///
/// Made by `stiction.read`, `stiction.recording` and `stiction.recording_from`. Every signal has its own times,
/// because historians that store only changes give each tag its own times.
#[pyclass(frozen, eq, module = "stiction.recordings", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    pub recording: Arc<recording::Recording>,
    pub source: Source,
}

type Values<'py> = Bound<'py, PyArray1<f64>>;

fn values<'py>(py: Python<'py>, channel: &Channel) -> Values<'py> {
    PyArray1::from_slice(py, &channel.values)
}

#[pymethods]
impl Recording {
    /// Tag of the loop.
    #[getter]
    fn name(&self) -> &str {
        &self.recording.name
    }

    /// Type of the loop, one of `stiction.recordings.loop_types`.
    #[getter]
    fn loop_type(&self) -> &'static str {
        self.recording.loop_type.name()
    }

    /// Time zero of the recording's clock, seconds since 1970-01-01 UTC; None if unknown.
    #[getter]
    fn start(&self) -> Option<f64> {
        self.recording.start
    }

    /// Time zero of its clock as a `datetime` in UTC; None if unknown.
    #[getter]
    fn start_time<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let moment = py.import("stiction._dates")?.getattr("moment")?;
        self.recording.start.map(|start| moment.call1((start,))).transpose()
    }

    /// Name of the recording's file, as given.
    #[getter]
    fn file(&self) -> &str {
        &self.source.file
    }

    /// SHA-256 of the bytes of that file; empty without a file.
    #[getter]
    fn sha256(&self) -> &str {
        &self.source.sha256
    }

    /// Unit of the PV, if the file gives it.
    #[getter]
    fn pv_unit(&self) -> Option<&str> {
        self.recording.pv.as_ref()?.unit.as_deref()
    }

    /// Times of the samples of OP, s on the recording's clock.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Values<'py> {
        PyArray1::from_slice(py, &self.recording.op.time)
    }

    /// Recorded controller output, percent of span unless it has another range; NaN is missing.
    #[getter]
    fn op<'py>(&self, py: Python<'py>) -> Values<'py> {
        values(py, &self.recording.op)
    }

    /// Process value in its units, or None; NaN is missing.
    #[getter]
    fn pv<'py>(&self, py: Python<'py>) -> Option<Values<'py>> {
        self.recording.pv.as_ref().map(|channel| values(py, channel))
    }

    /// Set point in units of the PV, or None; NaN is missing.
    #[getter]
    fn sp<'py>(&self, py: Python<'py>) -> Option<Values<'py>> {
        self.recording.sp.as_ref().map(|channel| values(py, channel))
    }

    /// Measured valve position, percent of span unless it has another range, or None; NaN is missing.
    #[getter]
    fn vp<'py>(&self, py: Python<'py>) -> Option<Values<'py>> {
        self.recording.vp.as_ref().map(|channel| values(py, channel))
    }

    /// Notes of the reader for the user, in sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.recording.notes.clone()
    }

    /// Return the sample times of one signal.
    ///
    /// Parameters
    /// ----------
    /// signal : {"op", "pv", "sp", "vp"}
    ///     The signal.
    ///
    /// Returns
    /// -------
    /// ndarray or None
    ///     Times of the samples, s on the recording's clock; None if the signal was not recorded.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If there is no such signal.
    fn times<'py>(&self, py: Python<'py>, signal: &str) -> PyResult<Option<Values<'py>>> {
        let recording = &*self.recording;
        let channel = match signal {
            "op" => Some(&recording.op),
            "pv" => recording.pv.as_ref(),
            "sp" => recording.sp.as_ref(),
            "vp" => recording.vp.as_ref(),
            other => {
                let words = format!("signal is \"{other}\", but must be op, pv, sp or vp");
                return Err(PyValueError::new_err(words));
            }
        };
        Ok(channel.map(|channel| PyArray1::from_slice(py, &channel.time)))
    }

    /// Cut a long recording into windows.
    ///
    /// Parameters
    /// ----------
    /// window_s : float
    ///     Length of a window, s; the last includes the rest, at least half a window.
    ///
    /// Returns
    /// -------
    /// list of Recording
    ///     In order of time, with the clock of the recording.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If the window is not above 0.
    fn split(&self, window_s: &Bound<'_, PyAny>) -> PyResult<Vec<Self>> {
        let window = crate::arguments::number("window_s", window_s)?;
        let parts = self.recording.split(window).map_err(refused)?;
        Ok(parts.into_iter().map(|part| Self::new(part, self.source.clone())).collect())
    }

    fn __repr__(&self) -> String {
        let recording = &*self.recording;
        let signals: Vec<&str> = [
            ("OP", true),
            ("PV", recording.pv.is_some()),
            ("SP", recording.sp.is_some()),
            ("VP", recording.vp.is_some()),
            ("mode", recording.mode.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect();
        format!(
            "<Recording \"{}\" ({}) of {} samples: {}>",
            recording.name,
            self.loop_type(),
            recording.op.values.len(),
            signals.join(", ")
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Kept)> {
        Ok((py.import("stiction._core")?.getattr("recording_kept")?, self.keep()))
    }
}

/// A masked sample: time, value, quality before, kind.
type KeptMasked = (f64, f64, u8, u8);
/// A channel as plain values: times, values, qualities, unit, range, masked samples.
type KeptChannel =
    (Vec<f64>, Vec<f64>, Vec<u8>, Option<String>, Option<KeptRange>, Vec<KeptMasked>);
/// A range as plain values: ends, source, narrowest and widest span.
type KeptRange = (f64, f64, u8, [f64; 2]);
/// Notation and zone of the times, and the names of the columns of time, OP, PV, SP, VP and mode.
type KeptColumns = (String, String, [Option<String>; 6]);
/// Name, type, start, clock of the plant, columns, notes, file and its hash.
type KeptAbout =
    (String, String, Option<f64>, (String, i32), KeptColumns, Vec<String>, String, String);
/// A recording as plain values.
type Kept = (KeptAbout, Vec<Option<KeptChannel>>, Option<(Vec<f64>, Vec<u8>)>);

const QUALITIES: [Quality; 4] = [Quality::Good, Quality::Uncertain, Quality::Bad, Quality::Missing];
const MODES: [Mode; 4] = [Mode::Automatic, Mode::Cascade, Mode::Manual, Mode::Other];

/// The index of `item` in `all`, which contains all values.
fn place<T: PartialEq>(all: &[T], item: &T) -> u8 {
    all.iter().position(|each| each == item).unwrap_or(0) as u8
}

fn keep_channel(channel: &Channel) -> KeptChannel {
    (
        channel.time.clone(),
        channel.values.clone(),
        channel.quality.iter().map(|quality| place(&QUALITIES, quality)).collect(),
        channel.unit.clone(),
        channel.range.map(|range| {
            (range.low, range.high, place(&RangeSource::ALL, &range.source), range.spans)
        }),
        channel
            .masked
            .iter()
            .map(|m| {
                (m.time, m.value, place(&QUALITIES, &m.quality), place(&MaskedKind::ALL, &m.kind))
            })
            .collect(),
    )
}

fn kept_channel(name: &'static str, kept: KeptChannel) -> stiction::Result<Channel> {
    let (time, values, quality, unit, range, masked) = kept;
    let quality = quality.into_iter().map(|place| QUALITIES[usize::from(place) % 4]).collect();
    let mut channel = Channel::with_quality(name, time, values, quality)?;
    channel.unit = unit;
    let range = range.map(|(low, high, place, spans)| {
        Range::among(low, high, RangeSource::ALL[usize::from(place) % 4], (spans[0], spans[1]))
    });
    channel.range = range.transpose()?;
    let masked = masked.into_iter().map(|(time, value, quality, kind)| MaskedSample {
        time,
        value,
        quality: QUALITIES[usize::from(quality) % 4],
        kind: MaskedKind::ALL[usize::from(kind) % 5],
    });
    channel.masked = masked.collect();
    Ok(channel)
}

fn keep_columns(columns: &Columns) -> KeptColumns {
    let Columns { time, time_format, zone, op, pv, sp, vp, mode } = columns.clone();
    (time_format, zone, [time, op, pv, sp, vp, mode])
}

impl Recording {
    pub fn new(recording: recording::Recording, source: Source) -> Self {
        Self { recording: Arc::new(recording), source }
    }

    fn keep(&self) -> Kept {
        let recording = &*self.recording;
        let channels = [
            Some(&recording.op),
            recording.pv.as_ref(),
            recording.sp.as_ref(),
            recording.vp.as_ref(),
        ];
        let modes = recording.mode.as_ref().map(|modes| {
            (modes.time.clone(), modes.modes.iter().map(|mode| place(&MODES, mode)).collect())
        });
        (
            (
                recording.name.clone(),
                recording.loop_type.name().to_owned(),
                recording.start,
                (recording.plant_time.name.clone(), recording.plant_time.offset_s),
                keep_columns(&recording.columns),
                recording.notes.clone(),
                self.source.file.clone(),
                self.source.sha256.clone(),
            ),
            channels.into_iter().map(|channel| channel.map(keep_channel)).collect(),
            modes,
        )
    }
}

/// A pickled recording.
#[pyfunction]
pub fn recording_kept(
    about: KeptAbout,
    channels: Vec<Option<KeptChannel>>,
    mode: Option<(Vec<f64>, Vec<u8>)>,
) -> PyResult<Recording> {
    let (name, loop_type, start, plant_time, columns, notes, file, sha256) = about;
    let (time_format, zone, [time, op, pv, sp, vp, mode_column]) = columns;
    let columns = Columns { time, time_format, zone, op, pv, sp, vp, mode: mode_column };
    let mut channels = channels.into_iter();
    let mut next = |name: &'static str| {
        channels.next().flatten().map(|kept| kept_channel(name, kept)).transpose().map_err(refused)
    };
    let op = next("OP")?.ok_or_else(|| PyValueError::new_err("there is no OP"))?;
    let recording = recording::Recording {
        name,
        loop_type: LoopType::by_name(&loop_type).map_err(refused)?,
        start,
        plant_time: PlantTime { name: plant_time.0, offset_s: plant_time.1 },
        columns,
        op,
        pv: next("PV")?,
        sp: next("SP")?,
        vp: next("VP")?,
        mode: mode.map(|(time, modes)| Modes {
            time,
            modes: modes.into_iter().map(|place| MODES[usize::from(place) % 4]).collect(),
        }),
        notes,
    };
    Ok(Recording::new(recording, Source { file, sha256 }))
}

/// The user's information on a file or table.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ReadingOptions {
    mapping: Option<PathBuf>,
    /// `ROLE=COLUMN`.
    columns: Vec<String>,
    zone: Option<String>,
    time_format: Option<String>,
    date: Option<String>,
    sample_time: Option<f64>,
    op_range: Option<(f64, f64)>,
    pv_range: Option<(f64, f64)>,
    vp_range: Option<(f64, f64)>,
    loop_type: Option<String>,
    bad_text: Vec<String>,
    part: Option<String>,
    decimal_mark: Option<String>,
    /// `WORD=MODE`.
    modes: Vec<String>,
    /// `WORD=QUALITY`.
    qualities: Vec<String>,
    bad_value: Vec<f64>,
}

impl ReadingOptions {
    /// The options, where this information takes precedence over the mapping file.
    fn options(self) -> PyResult<ReadOptions> {
        let wrong = |name: &str, words: String| PyValueError::new_err(format!("{name}: {words}"));
        let mut options = match &self.mapping {
            Some(path) => ReadOptions::read(path).map_err(unread)?,
            None => ReadOptions::default(),
        };
        for column in &self.columns {
            options.map.push(column.parse().map_err(|words| wrong("columns", words))?);
        }
        if let Some(zone) = &self.zone {
            options.zone = Some(zone.parse().map_err(|words| wrong("zone", words))?);
        }
        if let Some(format) = &self.time_format {
            options.time_format =
                Some(format.parse().map_err(|words| wrong("time_format", words))?);
        }
        if let Some(mark) = &self.decimal_mark {
            options.decimal_mark =
                Some(mark.parse().map_err(|words| wrong("decimal_mark", words))?);
        }
        // The first meaning of a word counts.
        for word in self.modes.iter().rev() {
            let meaning =
                stiction_io::mode::of_option(word).map_err(|words| wrong("modes", words))?;
            options.modes.insert(0, meaning);
        }
        for word in self.qualities.iter().rev() {
            let meaning =
                stiction_io::quality::of_option(word).map_err(|words| wrong("qualities", words))?;
            options.qualities.insert(0, meaning);
        }
        if let Some(day) = &self.date {
            options.date = Some(day.parse().map_err(|words| wrong("date", words))?);
        }
        if let Some(name) = &self.loop_type {
            options.all.loop_type = Some(LoopType::by_name(name).map_err(refused)?);
        }
        options.wording = KEYWORDS;
        options.bad_text.extend(self.bad_text);
        options.part = self.part.or(options.part);
        options.bad_value.extend(self.bad_value);
        options.sample_time = self.sample_time.or(options.sample_time);
        options.all.op_range = self.op_range.or(options.all.op_range);
        options.all.pv_range = self.pv_range.or(options.all.pv_range);
        options.all.vp_range = self.vp_range.or(options.all.vp_range);
        Ok(options)
    }
}

/// The recordings of a reading, each with the notes on all.
fn recordings(reading: Reading) -> Vec<Recording> {
    let Reading { origin, sha256, recordings, notes, .. } = reading;
    let source = Source { file: origin, sha256 };
    let all = recordings.into_iter().map(|mut recording| {
        recording.notes.splice(0..0, notes.iter().cloned());
        Recording::new(recording, source.clone())
    });
    all.collect()
}

/// The recordings in a file.
#[pyfunction]
pub fn read_recordings(
    py: Python<'_>,
    path: PathBuf,
    told: ReadingOptions,
) -> PyResult<Vec<Recording>> {
    let options = told.options()?;
    long(py, None, move |_| stiction_io::reading::read(&path, &options))?
        .map(recordings)
        .map_err(unread)
}

/// The recordings in a table.
fn of_sheet(py: Python<'_>, sheet: Sheet, told: ReadingOptions) -> PyResult<Vec<Recording>> {
    let options = told.options()?;
    long(py, None, move |_| stiction_io::reading::of_sheet(sheet, &options))?
        .map(recordings)
        .map_err(unread)
}

/// A table of these columns.
fn of_columns(origin: &str, columns: Vec<Column>) -> Sheet {
    Sheet { origin: origin.to_owned(), columns, ..Sheet::default() }
}

/// A column of numbers, of texts, or of times with a flag that they are UTC.
#[derive(FromPyObject)]
pub enum Given<'py> {
    Numbers(PyReadonlyArray1<'py, f64>),
    Times(PyReadonlyArray1<'py, f64>, bool),
    Text(Vec<String>),
}

/// The recordings in named columns of equal length.
#[pyfunction]
pub fn recordings_of_columns(
    py: Python<'_>,
    origin: &str,
    columns: Vec<(String, Given<'_>)>,
    told: ReadingOptions,
) -> PyResult<Vec<Recording>> {
    let column = |(name, given): (String, Given<'_>)| -> PyResult<Column> {
        let cells = match given {
            Given::Numbers(numbers) => Cells::Numbers(numbers.as_slice()?.to_vec()),
            Given::Times(seconds, utc) => {
                Cells::Times { seconds: seconds.as_slice()?.to_vec(), utc }
            }
            Given::Text(texts) => Cells::Text(texts.iter().map(|text| &**text).collect()),
        };
        Ok(Column { name, unit: None, cells })
    };
    let columns = columns.into_iter().map(column).collect::<PyResult<Vec<_>>>()?;
    if let Some(odd) = columns.iter().find(|each| each.cells.len() != columns[0].cells.len()) {
        return Err(PyValueError::new_err(format!(
            "{} has {} values, but {} has {}",
            odd.name,
            odd.cells.len(),
            columns[0].name,
            columns[0].cells.len()
        )));
    }
    of_sheet(py, of_columns(origin, columns), told)
}

/// The recordings in a table with the Arrow capsule interface.
#[pyfunction]
pub fn recordings_of_arrow(
    py: Python<'_>,
    origin: &str,
    table: AnyRecordBatch,
    told: ReadingOptions,
) -> PyResult<Vec<Recording>> {
    of_sheet(py, sheet_of(origin, table)?, told)
}

/// A table with the Arrow capsule interface.
pub fn sheet_of(origin: &str, table: AnyRecordBatch) -> PyResult<Sheet> {
    let (batches, schema) = PyTable::into_inner(table.into_table()?);
    let column = |(place, field): (usize, &Arc<arrow_schema::Field>)| -> PyResult<Column> {
        let name = field.name().trim().to_owned();
        let mut cells = cells(&arrow_array::new_empty_array(field.data_type()), &name)?;
        for batch in &batches {
            let more = self::cells(RecordBatch::column(batch, place), &name)?;
            match (&mut cells, more) {
                (Cells::Numbers(all), Cells::Numbers(more)) => all.extend(more),
                (Cells::Text(all), Cells::Text(more)) => all.append(more),
                (Cells::Times { seconds, .. }, Cells::Times { seconds: more, .. }) => {
                    seconds.extend(more);
                }
                // All batches are of one type.
                _ => {}
            }
        }
        Ok(Column { name, unit: field.metadata().get("unit").cloned(), cells })
    };
    let columns = schema.fields().iter().enumerate().map(column).collect::<PyResult<Vec<_>>>()?;
    Ok(of_columns(origin, columns))
}

/// Seconds of whole numbers in a unit of time, NaN for null.
fn seconds(array: &ArrayRef, unit: TimeUnit) -> Vec<f64> {
    let per_second = match unit {
        TimeUnit::Second => 1.0,
        TimeUnit::Millisecond => 1e3,
        TimeUnit::Microsecond => 1e6,
        TimeUnit::Nanosecond => 1e9,
    };
    let data = array.to_data();
    let whole: &[i64] = &data.buffers()[0].typed_data()[data.offset()..][..data.len()];
    let second = |(i, value): (usize, &i64)| match array.is_null(i) {
        true => f64::NAN,
        false => *value as f64 / per_second,
    };
    whole.iter().enumerate().map(second).collect()
}

/// An Arrow array as the cells of a column. Null text is empty.
fn cells(array: &ArrayRef, name: &str) -> PyResult<Cells> {
    let broken = |error: ArrowError| PyTypeError::new_err(format!("column \"{name}\": {error}"));
    Ok(match array.data_type() {
        DataType::Timestamp(unit, zone) => {
            Cells::Times { seconds: seconds(array, *unit), utc: zone.is_some() }
        }
        DataType::Duration(unit) => Cells::Numbers(seconds(array, *unit)),
        DataType::Date32 => {
            let moments = cast(array, &DataType::Timestamp(TimeUnit::Second, None));
            cells(&moments.map_err(broken)?, name)?
        }
        DataType::Dictionary(_, kind) => cells(&cast(array, kind).map_err(broken)?, name)?,
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => {
            let texts = cast(array, &DataType::Utf8).map_err(broken)?;
            let texts = texts.as_string::<i32>().iter();
            Cells::Text(texts.map(|text| text.unwrap_or_default().trim()).collect())
        }
        DataType::Boolean | DataType::Decimal128(..) => {
            Cells::Numbers(as_numbers(array).map_err(broken)?)
        }
        other => Cells::Numbers(numbers(array).ok_or_else(|| {
            PyTypeError::new_err(format!(
                "column \"{name}\" holds {other}, but must hold numbers, text or times; leave it out"
            ))
        })?),
    })
}

/// The recording with another name and another start of its clock.
#[pyfunction]
pub fn recording_renamed(
    recording: &Recording,
    name: Option<String>,
    start: Option<f64>,
    of_tag: bool,
) -> Recording {
    let mut renamed = (*recording.recording).clone();
    renamed.start = start.or(renamed.start);
    if let Some(name) = name {
        if of_tag {
            renamed.loop_type = LoopType::of_tag(&name);
        }
        renamed.name = name;
    }
    Recording::new(renamed, recording.source.clone())
}

/// The fitness of a recording for a diagnosis.
#[pyfunction]
pub fn recording_fitness<'py>(
    py: Python<'py>,
    recording: &Recording,
    sample_time: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let recording = Arc::clone(&recording.recording);
    let options = GridOptions { sample_time };
    let fitness = long(py, None, move |_| stiction::diagnose::fitness(&recording, &options))?;
    crate::dict::plain(py, &fitness.map_err(refused)?)
}

/// The segments of a recording on a regular grid.
#[pyfunction]
pub fn recording_segments<'py>(
    py: Python<'py>,
    recording: &Recording,
    sample_time: Option<f64>,
) -> PyResult<Vec<Bound<'py, pyo3::types::PyDict>>> {
    let recording = Arc::clone(&recording.recording);
    let options = GridOptions { sample_time };
    let grid = long(py, None, move |_| recording::Grid::of(&recording, &options))?;
    let segments = grid.map_err(refused)?.segments;
    segments.iter().map(|segment| segment_dict(py, segment)).collect()
}

/// The signals of a segment.
pub fn segment_dict<'py>(
    py: Python<'py>,
    segment: &recording::Segment,
) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
    let array = |values: &Option<Vec<f64>>| values.as_ref().map(|v| PyArray1::from_slice(py, v));
    Ok(crate::dict::dict!(py,
        "time_s": PyArray1::from_vec(py, segment.times()),
        "sample_time": segment.sample_time,
        "op": PyArray1::from_slice(py, &segment.op),
        "pv": array(&segment.pv),
        "sp": array(&segment.sp),
        "vp": array(&segment.vp),
        "bridged": segment.bridged,
    ))
}

/// Names of the types of loops.
#[pyfunction]
pub fn loop_types() -> Vec<&'static str> {
    LoopType::NAMES.map(|(name, _)| name).to_vec()
}
