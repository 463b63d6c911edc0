//! Recordings from files of any format.

use crate::bytes;
use crate::content::Content;
use crate::csv_sheet::{self, Dialect};
use crate::error::{Error, Result};
use crate::layout::{self, Layout, LoopPlan, MissingLoop, Place, Plan, Recognised};
use crate::number::{self, DecimalMark};
use crate::options::{ReadOptions, SettingsByName};
use crate::range;
use crate::remedy::{Remedy, Wording};
use crate::role::{self, Signal};
use crate::sheet::{Cells, Column, Sheet};
use crate::timestamp::{self, Clock, Times, Told};
use crate::{mode, quality};
use sha2::{Digest, Sha256};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use stiction_diagnose::recording::{
    Channel, LoopType, Mode, Modes, PlantTime, Quality, Range, RangeSource, Recording,
};

/// The format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text with a delimiter.
    Csv(Dialect),
    /// Apache Parquet.
    Parquet,
    /// MATLAB, in any of its versions.
    Matlab,
    /// No file, but a table in memory.
    Memory,
}

impl Format {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv(_) => "CSV",
            Self::Parquet => "Parquet",
            Self::Matlab => "MATLAB",
            Self::Memory => "table in memory",
        }
    }
}

/// How the times of a part of a file are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeColumn {
    /// Name of the column; none if rows are evenly spaced by a sample time.
    pub column: Option<String>,
    /// How it is written, in words.
    pub format: String,
    /// What the clock shows.
    pub clock: Clock,
}

/// What was read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The file, as it is named in messages.
    pub origin: String,
    /// SHA-256 of its bytes, in hexadecimal; empty for a table in memory.
    pub sha256: String,
    /// Its format.
    pub format: Format,
    /// How its loops lie in it; of several parts, in the first that has a loop.
    pub layout: Layout,
    /// How its times are written; of several parts, in the first that has a loop.
    pub time: TimeColumn,
    /// The loops, in the order of the file.
    pub recordings: Vec<Recording>,
    /// What every column and tag was recognised as.
    pub recognised: Vec<Recognised>,
    /// The loops that are not among the recordings, because the file lacks a column or tag that the mapping names,
    /// or a signal of theirs could not be made a column; the notes name those of which it has others.
    pub missing: Vec<MissingLoop>,
    /// Names of recordings that nothing in the file names, so that the file's own name stands in.
    pub untagged: Vec<String>,
    /// What the user should know of the file as a whole; each recording has notes of its own.
    pub notes: Vec<String>,
}

/// Reads the recordings in the file at `path`.
///
/// # Errors
/// If it cannot be read, or as for [`parse`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Reading> {
    parse(&bytes::read(path)?, &path.display().to_string(), options)
}

/// Reads recordings from `bytes`, whose format their beginning tells; `origin` names them in errors,
/// and a loop that has no other name.
///
/// # Errors
/// If the bytes are of no known format, or no column is known as a controller output; if a cell is
/// neither what its column holds nor a known word; if the times cannot be told.
pub fn parse(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<Reading> {
    let (format, sheets, notes) = sheets(bytes, origin)?;
    let sha256 = format!("{:x}", Sha256::digest(bytes));
    build(format, &sheets, notes, sha256, origin, options)
}

/// The names of all columns in `bytes`, whatever they hold: to say what they are where [`parse`] cannot tell.
///
/// # Errors
/// If the bytes are of no known format.
pub fn columns(bytes: &[u8], origin: &str) -> Result<Vec<String>> {
    let (_, sheets, _) = sheets(bytes, origin)?;
    let columns = sheets.into_iter().flat_map(|sheet| sheet.columns);
    Ok(columns.map(|column| column.name).collect())
}

/// Reads recordings from a table in memory, whose origin names it in errors, and a loop that has no other name.
///
/// # Errors
/// As for [`parse`], but for the format.
pub fn of_sheet(sheet: Sheet, options: &ReadOptions) -> Result<Reading> {
    let origin = sheet.origin.clone();
    build(Format::Memory, &[sheet], vec![], String::new(), &origin, options)
}

/// Reads recordings from the sheets of a file.
fn build(
    format: Format,
    sheets: &[Sheet],
    mut notes: Vec<String>,
    sha256: String,
    origin: &str,
    options: &ReadOptions,
) -> Result<Reading> {
    let mark = match format {
        Format::Csv(dialect) => dialect.decimal_mark,
        Format::Parquet | Format::Matlab | Format::Memory => DecimalMark::Point,
    };
    let names = Names { origin, parts: common_start(sheets), several: sheets.len() > 1 };
    let (mut recordings, mut recognised, mut first) = (vec![], vec![], None);
    let (mut missing, mut untagged): (Vec<MissingLoop>, _) = (vec![], vec![]);
    let mut without_op: Vec<&str> = vec![];
    for sheet in sheets {
        let plan = layout::recognise(sheet, options)?;
        recognised.extend(plan.recognised.iter().cloned());
        missing.extend(plan.missing.iter().cloned());
        let about = |note: &String| match &*sheet.part {
            "" => note.clone(),
            part => format!("{part}: {note}"),
        };
        notes.extend(sheet.notes.iter().chain(&plan.notes).map(about));
        if plan.loops.is_empty() {
            without_op.push(&*sheet.part);
            continue;
        }
        for each in &plan.loops {
            if let Some(reason) = &each.unread {
                let (name, _) = names.of(each, sheet);
                notes.push(format!("loop {name} is not read: the file {reason}"));
                let reason = reason.clone();
                missing.push(MissingLoop { name, reason, is_partly_here: true });
            }
        }
        if plan.loops.iter().all(|each| each.unread.is_some()) {
            continue;
        }
        let builder = Builder::new(sheet, &plan, options, mark)?;
        notes.extend(builder.times.notes.iter().map(about));
        for each in plan.loops.iter().filter(|each| each.unread.is_none()) {
            let (name, tells) = names.of(each, sheet);
            if !tells {
                untagged.push(name.clone());
            }
            recordings.push(builder.recording(each, name)?);
        }
        first.get_or_insert((plan.layout, builder.time_column()));
    }
    let Some((layout, time)) = first else {
        let lacking = missing.iter().max_by_key(|each| each.is_partly_here);
        let Some(lacking) = lacking else {
            return Err(no_op(origin, &recognised, options.wording));
        };
        return Err(Error::Table { origin: origin.to_owned(), message: lacking.reason.clone() });
    };
    match &without_op[..] {
        [] => {}
        [part] => notes.push(format!("{part} has no column known as OP and is not read")),
        parts => {
            let parts = layout::list(parts);
            notes.push(format!("{parts} have no column known as OP and are not read"));
        }
    }
    // What one part of the file lacks another may have.
    let mut seen: HashSet<String> =
        recordings.iter().map(|read: &Recording| read.name.to_lowercase()).collect();
    missing.sort_by_key(|each| !each.is_partly_here);
    missing.retain(|each| seen.insert(each.name.to_lowercase()));
    let elsewhere: Vec<&str> =
        missing.iter().filter(|each| !each.is_partly_here).map(|each| &*each.name).collect();
    if !elsewhere.is_empty() {
        notes.push(format!("of the mapping, this file does not hold {}", layout::list(&elsewhere)));
    }
    Ok(Reading {
        origin: origin.to_owned(),
        sha256,
        format,
        layout,
        time,
        recordings,
        recognised,
        missing,
        untagged,
        notes,
    })
}

/// The refusal of a format that this library was built without.
#[cfg(not(all(feature = "parquet", feature = "matlab")))]
fn not_built_in(origin: &str, what: &str, feature: &str) -> Error {
    Error::Table {
        origin: origin.to_owned(),
        message: format!(
            "is {what}, which this was built without (feature \"{feature}\"); save it as CSV"
        ),
    }
}

/// The sheets in `bytes`, by the signature they begin with; what has none is text.
fn sheets(bytes: &[u8], origin: &str) -> Result<(Format, Vec<Sheet>, Vec<String>)> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    if bytes.starts_with(b"PAR1") {
        #[cfg(feature = "parquet")]
        return Ok((Format::Parquet, crate::parquet_file::parquet_sheets(bytes, origin)?, vec![]));
        #[cfg(not(feature = "parquet"))]
        return Err(not_built_in(origin, "a Parquet file", "parquet"));
    }
    if bytes.starts_with(b"MATLAB 5.0")
        || bytes.starts_with(b"MATLAB 7.3")
        || bytes.starts_with(HDF5)
    {
        #[cfg(feature = "matlab")]
        return Ok((Format::Matlab, crate::matlab_file::matlab_sheets(bytes, origin)?, vec![]));
        #[cfg(not(feature = "matlab"))]
        return Err(not_built_in(origin, "a MATLAB file", "matlab"));
    }
    for (signature, message) in [
        (&b"PK\x03\x04"[..], "is a spreadsheet or ZIP archive; save the sheet as CSV"),
        (b"\xd0\xcf\x11\xe0", "is an old Excel or Office file; save the sheet as CSV"),
        (b"\x1f\x8b", "is compressed with gzip; unpack it"),
    ] {
        if bytes.starts_with(signature) {
            return Err(Error::Table { origin: origin.to_owned(), message: message.to_owned() });
        }
    }
    let csv = csv_sheet::read(bytes, origin)?;
    Ok((Format::Csv(csv.dialect), vec![csv.sheet], csv.notes))
}

fn no_op(origin: &str, recognised: &[Recognised], wording: Wording) -> Error {
    let names: Vec<&str> = recognised.iter().map(|each| &*each.column).collect();
    Error::Table {
        origin: origin.to_owned(),
        message: format!(
            "has no column known as the controller output (OP); its columns are {}; say which it is, \
             as in {}",
            layout::list(&names),
            wording.of(Remedy::map_some("op"))
        ),
    }
}

/// The beginning, up to a dot, that the parts of all sheets share.
fn common_start(sheets: &[Sheet]) -> usize {
    let Some((first, others)) = sheets.split_first() else { return 0 };
    let ends = first.part.match_indices('.').map(|(at, _)| at + 1);
    ends.rev()
        .find(|end| others.iter().all(|sheet| sheet.part.starts_with(&first.part[..*end])))
        .unwrap_or(0)
}

/// What loops are called that no column names.
struct Names<'a> {
    origin: &'a str,
    /// How much the parts of the file have in common.
    parts: usize,
    several: bool,
}

impl Names<'_> {
    /// The name of a loop, and whether the file tells it.
    fn of(&self, plan: &LoopPlan, sheet: &Sheet) -> (String, bool) {
        let part = sheet.part.get(self.parts..).unwrap_or("");
        let name = match (&plan.name, part) {
            (Some(name), part) if part.is_empty() || !self.several => name.clone(),
            (Some(name), part) => format!("{part}.{name}"),
            (None, part) if !part.is_empty() && self.several => part.to_owned(),
            (None, _) => match told(sheet, &["tag", "loop", "name"]) {
                Some(told) => told.to_owned(),
                None => {
                    let stem = Path::new(self.origin).file_stem();
                    let stem = stem.map(|stem| stem.to_string_lossy().into_owned());
                    return (stem.unwrap_or(self.origin.to_owned()), false);
                }
            },
        };
        (name, true)
    }
}

/// What the file says beside its columns under one of the `keys`.
fn told<'s>(sheet: &'s Sheet, keys: &[&str]) -> Option<&'s str> {
    let same = |key: &str| keys.contains(&&*key.to_lowercase().replace([' ', '-'], "_"));
    sheet.attributes.iter().find(|(key, _)| same(key)).map(|(_, value)| &**value)
}

/// Makes recordings of a sheet.
struct Builder<'a> {
    sheet: &'a Sheet,
    plan: &'a Plan,
    options: &'a ReadOptions,
    settings: SettingsByName<'a>,
    mark: DecimalMark,
    times: Times,
}

/// The cells of one signal: a column, and which of its rows.
struct Source<'a> {
    column: &'a Column,
    /// What it is called: the column, or the tag.
    name: &'a str,
    rows: Vec<usize>,
}

impl<'a> Builder<'a> {
    fn new(
        sheet: &'a Sheet,
        plan: &'a Plan,
        options: &'a ReadOptions,
        mark: DecimalMark,
    ) -> Result<Self> {
        let (settings, times) = (SettingsByName::of(options), evenly(sheet.len(), 1.0));
        let mut builder = Self { sheet, plan, options, settings, mark, times };
        builder.times = builder.read_times()?;
        Ok(builder)
    }

    fn read_times(&self) -> Result<Times> {
        let wrong = |message: String| Error::Table { origin: self.sheet.origin.clone(), message };
        let check_told = |seconds: f64, told: Told| {
            timestamp::check_told(seconds, told, &self.sheet.origin, self.options.wording)
        };
        let by_rows = matches!(self.plan.place, Place::Rows { .. });
        if let Some(sample_time) = self.options.sample_time {
            if by_rows {
                let message = "holds a row a sample, so a sample time cannot stand for its times";
                return Err(wrong(message.to_owned()));
            }
            check_told(sample_time, Told::ByUser)?;
            let mut times = evenly(self.sheet.len(), sample_time);
            if let Some(column) = self.plan.time {
                let name = &self.sheet.columns[column].name;
                times.notes.push(format!("\"{name}\" is not used, because a sample time is given"));
            }
            return Ok(times);
        }
        let Some(time) = self.plan.time else {
            return match self.sheet.sample_time {
                Some(sample_time) if sample_time > 0.0 && sample_time.is_finite() && !by_rows => {
                    check_told(sample_time, Told::ByFile)?;
                    Ok(evenly(self.sheet.len(), sample_time))
                }
                _ => Err(wrong(format!(
                    "has no column of times; its columns are {}; say which it is, as in {}, or tell \
                     the time between rows, as in {}",
                    layout::list(&self.sheet.columns.iter().map(|c| &*c.name).collect::<Vec<_>>()),
                    self.options.wording.of(Remedy::map_some("time")),
                    self.options.wording.of(Remedy::SampleTime(1.0))
                ))),
            };
        };
        let mut series = vec![0; self.sheet.len()];
        if let Place::Rows { tags, .. } = &self.plan.place {
            for (place, tag) in tags.iter().enumerate() {
                for row in &tag.rows {
                    series[*row] = place;
                }
            }
        }
        let context = timestamp::Context {
            sheet: self.sheet,
            mark: self.mark,
            format: self.options.time_format.as_ref(),
            zone: self.options.zone.as_ref(),
            series: &series,
            is_long: by_rows,
            wording: self.options.wording,
        };
        let column = &self.sheet.columns[time];
        let Some(date) = self.plan.date else { return timestamp::read(column, &context) };
        let is_full = match &column.cells {
            Cells::Text(cells) => cells.first().is_some_and(|cell| timestamp::looks_like(cell)),
            _ => true,
        };
        if !is_full {
            return timestamp::read(&self.joined(date, column)?, &context);
        }
        let mut times = timestamp::read(column, &context)?;
        times.notes.push(format!(
            "\"{}\" is not used, because \"{}\" tells the day too",
            self.sheet.columns[date].name, column.name
        ));
        Ok(times)
    }

    /// A column of days and one of times of day as one.
    fn joined(&self, date: usize, time: &Column) -> Result<Column> {
        let date = &self.sheet.columns[date];
        let (Cells::Text(dates), Cells::Text(times)) = (&date.cells, &time.cells) else {
            return Err(Error::Table {
                origin: self.sheet.origin.clone(),
                message: format!(
                    "\"{}\" and \"{}\" are both times; say which, as in {}",
                    date.name,
                    time.name,
                    self.options.wording.of(Remedy::map("ignore", &date.name))
                ),
            });
        };
        let join = |(date, time): (&Arc<str>, &Arc<str>)| match (date.is_empty(), time.is_empty()) {
            (false, false) => format!("{date} {time}").into(),
            _ => "".into(),
        };
        Ok(Column {
            name: format!("{} {}", date.name, time.name),
            unit: None,
            cells: Cells::Text(dates.iter().zip(times).map(join).collect()),
        })
    }

    fn time_column(&self) -> TimeColumn {
        let used = self.plan.time.filter(|_| self.options.sample_time.is_none());
        TimeColumn {
            column: used.map(|column| self.sheet.columns[column].name.clone()),
            format: self.times.format.clone(),
            clock: self.times.clock.clone(),
        }
    }

    /// The cells of the signal or quality that the plan's `name` stands for.
    fn source(&self, name: usize) -> Source<'a> {
        match &self.plan.place {
            Place::Columns => {
                let column = &self.sheet.columns[name];
                Source { column, name: &column.name, rows: (0..self.sheet.len()).collect() }
            }
            Place::Rows { tags, value, .. } => {
                let tag = &tags[name];
                let column = &self.sheet.columns[*value];
                Source { column, name: &tag.name, rows: tag.rows.clone() }
            }
        }
    }

    fn wrong(&self, source: &Source<'_>, row: usize, message: String) -> Error {
        let column = if source.name == source.column.name {
            source.name.to_owned()
        } else {
            format!("{}\" of \"{}", source.column.name, source.name)
        };
        Error::Cell { origin: self.sheet.origin.clone(), row: self.sheet.row(row), column, message }
    }

    fn recording(&self, plan: &LoopPlan, name: String) -> Result<Recording> {
        let settings = self.settings.of_loop(plan.name.as_deref().unwrap_or(&name));
        let refused = |e: stiction_model::Error| Error::Table {
            origin: self.sheet.origin.clone(),
            message: format!("loop {name}: {e}"),
        };
        let mut notes = plan.notes.clone();
        let mut channel = |signal: Signal| {
            plan.signal(signal)
                .map(|place| self.channel(plan, signal, place, &mut notes))
                .transpose()
        };
        let op = channel(Signal::Op)?;
        let (mut pv, sp, mut vp) =
            (channel(Signal::Pv)?, channel(Signal::Sp)?, channel(Signal::Vp)?);
        let Some(mut op) = op else {
            let recognised = &self.plan.recognised;
            return Err(no_op(&self.sheet.origin, recognised, self.options.wording));
        };
        let mode = plan.signal(Signal::Mode).map(|place| self.modes(plan, place, &mut notes));
        let mode = mode.transpose()?;

        let told_range = |key: &str| told(self.sheet, &[key]).and_then(range::of_text);
        let (op_range, op_note) = range::of_valve_signal(
            "OP",
            &op,
            settings.op_range,
            told_range("op_range"),
            self.options.wording,
        )
        .map_err(refused)?;
        op.range = op_range;
        notes.extend(op_note);
        if let Some(vp) = &mut vp {
            let (vp_range, vp_note) = range::of_valve_signal(
                "VP",
                vp,
                settings.vp_range,
                told_range("vp_range"),
                self.options.wording,
            )
            .map_err(refused)?;
            vp.range = vp_range;
            notes.extend(vp_note);
        }
        if let Some(pv) = &mut pv {
            let given = settings.pv_range.map(|ends| (ends, RangeSource::Given));
            let told = told_range("pv_range").map(|ends| (ends, RangeSource::Metadata));
            let range = given.or(told).map(|((low, high), source)| Range::new(low, high, source));
            pv.range = range.transpose().map_err(refused)?;
        }
        let loop_type = match settings.loop_type {
            Some(given) => given,
            None => self.told_type(&mut notes).unwrap_or_else(|| role::loop_type(&name)),
        };
        let plant_time = match (&self.options.zone, self.times.start, &self.times.clock) {
            (Some(zone), Some(start), _) => zone.plant_time(start),
            (None, _, Clock::Local) => PlantTime::unnamed(),
            _ => PlantTime::default(),
        };
        Ok(Recording {
            name,
            loop_type,
            start: self.times.start,
            plant_time,
            op,
            pv,
            sp,
            vp,
            mode,
            notes,
        })
    }

    /// The type that the file tells, as a name or as whether the loop integrates.
    fn told_type(&self, notes: &mut Vec<String>) -> Option<LoopType> {
        let told = told(self.sheet, &["type", "loop_type"])?;
        let integrating = number::parse(told, DecimalMark::Point);
        let found = match integrating {
            Some(0.0) => Some(LoopType::OtherSelfRegulating),
            Some(1.0) => Some(LoopType::OtherIntegrating),
            _ => LoopType::by_name(told).ok(),
        };
        if found.is_none() {
            notes.push(format!(
                "the file says the loop's type is \"{told}\", which is no known type"
            ));
        }
        found
    }

    fn channel(
        &self,
        plan: &LoopPlan,
        signal: Signal,
        place: usize,
        notes: &mut Vec<String>,
    ) -> Result<Channel> {
        let source = self.source(place);
        let said = self.qualities(plan, signal, &source, notes)?;
        let mut values = Vec::with_capacity(source.rows.len());
        let mut qualities = Vec::with_capacity(source.rows.len());
        for (k, row) in source.rows.iter().enumerate() {
            let said = said.as_ref().map_or(Quality::Good, |said| said[k]);
            let (value, quality) = match &source.column.cells {
                Cells::Text(cells) => self.sample(&source, *row, &cells[*row], said)?,
                Cells::Numbers(numbers) => match numbers[*row] {
                    value if value.is_nan() => (value, Quality::Missing),
                    value if value.is_infinite() && said.is_usable() => {
                        let message = format!("{value} is not a finite number; correct it");
                        return Err(self.wrong(&source, *row, message));
                    }
                    value => (value, Quality::Good),
                },
                Cells::Times { .. } => {
                    let message = format!("holds a time, but is taken as {}", signal.name());
                    return Err(self.wrong(&source, *row, message));
                }
            };
            values.push(value);
            qualities.push(if quality.is_usable() { said } else { quality });
        }
        let time = source.rows.iter().map(|row| self.times.seconds[*row]).collect();
        let channel = Channel::with_quality(signal.name(), time, values, qualities);
        let mut channel = channel.map_err(|e| Error::Table {
            origin: self.sheet.origin.clone(),
            message: format!("\"{}\": {e}", source.name),
        })?;
        let in_name = || role::without_unit(source.name).1.map(str::to_owned);
        channel.unit = source.column.unit.clone().or_else(in_name);
        Ok(channel)
    }

    /// The value and quality of a cell whose quality is `said` elsewhere.
    fn sample(
        &self,
        source: &Source<'_>,
        row: usize,
        cell: &str,
        said: Quality,
    ) -> Result<(f64, Quality)> {
        if let Some(value) = number::parse(cell, self.mark) {
            return Ok((value, Quality::Good));
        }
        if let Some(quality) = number::word(cell) {
            return Ok((f64::NAN, quality));
        }
        let is_bad = |word: &String| word.trim().eq_ignore_ascii_case(cell);
        if !said.is_usable() || self.options.bad_text.iter().any(is_bad) {
            return Ok((f64::NAN, Quality::Bad));
        }
        Err(self.wrong(source, row, number::refusal(cell, self.mark, self.options.wording)))
    }

    /// What is said of the quality of the samples of `signal`, if anything is.
    fn qualities(
        &self,
        plan: &LoopPlan,
        signal: Signal,
        of: &Source<'_>,
        notes: &mut Vec<String>,
    ) -> Result<Option<Vec<Quality>>> {
        let place = match &self.plan.place {
            Place::Columns => plan.quality(signal),
            Place::Rows { quality, .. } => *quality,
        };
        let Some(place) = place else { return Ok(None) };
        let column = &self.sheet.columns[place];
        let read = quality::read(
            &column.name,
            &column.cells,
            &of.rows,
            &self.options.qualities,
            self.mark,
            self.options.wording,
        );
        let read = read.map_err(|(row, message)| Error::Cell {
            origin: self.sheet.origin.clone(),
            row: self.sheet.row(row),
            column: column.name.clone(),
            message,
        })?;
        if let Some(code) = read.code {
            let note = format!("the numbers in \"{}\" are read as {}", column.name, code.name());
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
        Ok(Some(read.qualities))
    }

    /// The mode that a column of modes turns on, if its name and all its cells say that it is a switch and
    /// the user does not say what its cells mean.
    fn switch(&self, place: usize, source: &Source<'_>, notes: &mut Vec<String>) -> Option<Mode> {
        let (_, mode) = role::split_switch(source.name)?;
        let content = Content { sheet: self.sheet, place: &self.plan.place };
        if !self.options.modes.is_empty() || !content.is_switch(place) {
            return None;
        }
        let (on, off) = match mode {
            Mode::Manual => ("manual", "automatic"),
            Mode::Automatic => ("automatic", "manual"),
            // What is not in cascade may be in either of the others.
            _ => return None,
        };
        notes.push(format!(
            "\"{}\" is read as the mode: 1 {on}, 0 {off}; if it is something else, give {}",
            source.name,
            self.options.wording.of(Remedy::map("ignore", source.name))
        ));
        Some(mode)
    }

    fn modes(&self, plan: &LoopPlan, place: usize, notes: &mut Vec<String>) -> Result<Modes> {
        let source = self.source(place);
        let said = self.qualities(plan, Signal::Mode, &source, notes)?;
        let switch = self.switch(place, &source, notes);
        let (mut modes, mut codes, mut nothing) = (Vec::with_capacity(source.rows.len()), false, 0);
        for (k, row) in source.rows.iter().enumerate() {
            if said.as_ref().is_some_and(|said| !said[k].is_usable()) {
                nothing += 1;
                modes.push(Mode::Other);
                continue;
            }
            let number;
            let (cell, mark) = match &source.column.cells {
                Cells::Text(cells) => (&*cells[*row], self.mark),
                Cells::Numbers(numbers) | Cells::Times { seconds: numbers, .. } => {
                    number = numbers[*row].to_string();
                    (&*number, DecimalMark::Point)
                }
            };
            if let Some((mode, is_on)) = switch.zip(mode::is_on(cell)) {
                modes.push(if is_on { mode } else { mode::switched_off(mode) });
                continue;
            }
            modes.push(match mode::of_cell(cell, &self.options.modes, mark) {
                Some(mode::Said::Mode(mode)) => mode,
                Some(mode::Said::Code(mode)) => {
                    codes = true;
                    mode
                }
                Some(mode::Said::Nothing) => {
                    nothing += 1;
                    Mode::Other
                }
                None => {
                    let cell = number::shown(cell);
                    let message = format!(
                        "\"{cell}\" is no known mode; say what it means in a mapping file, as in \
                         [modes] \"{cell}\" = \"auto\", or leave it out, as in {}",
                        self.options.wording.of(Remedy::map("ignore", source.name))
                    );
                    return Err(self.wrong(&source, *row, message));
                }
            });
        }
        if codes {
            notes.push(
                "mode codes are read as 0 manual, 1 automatic, 2 cascade; if they mean something else, \
                 say so under [modes] in a mapping file"
                    .to_owned(),
            );
        }
        if nothing > 0 {
            notes.push(format!("{nothing} of {} modes are not recorded", modes.len()));
        }
        let time = source.rows.iter().map(|row| self.times.seconds[*row]).collect();
        Ok(Modes { time, modes })
    }
}

/// Times at a fixed distance.
fn evenly(rows: usize, sample_time: f64) -> Times {
    Times {
        start: None,
        seconds: (0..rows).map(|k| k as f64 * sample_time).collect(),
        format: format!("every {sample_time} s"),
        clock: Clock::Elapsed,
        notes: vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(part: &str, columns: Vec<(&str, Cells)>) -> Sheet {
        let column =
            |(name, cells): (&str, Cells)| Column { name: name.to_owned(), unit: None, cells };
        Sheet {
            origin: "f.mat".to_owned(),
            part: part.to_owned(),
            columns: columns.into_iter().map(column).collect(),
            ..Sheet::default()
        }
    }

    fn built(sheets: &[Sheet], options: &ReadOptions) -> Result<Reading> {
        build(Format::Matlab, sheets, vec![], String::new(), "f.mat", options)
    }

    #[test]
    fn parts_of_a_file_are_loops() {
        let loops = |part: &str, kind: &str| {
            let numbers = |from: f64| Cells::Numbers(vec![from, f64::NAN, from + 1.0]);
            let mut sheet = sheet(part, vec![("OP", numbers(50.0)), ("PV", numbers(1.0))]);
            sheet.sample_time = Some(2.0);
            sheet.attributes = vec![("type".to_owned(), kind.to_owned())];
            sheet
        };
        let nothing = sheet("cdata.info", vec![("x", Cells::Numbers(vec![1.0]))]);
        let sheets = [loops("cdata.chemicals.loop2", "0"), nothing, loops("cdata.pulp.loop2", "1")];
        let reading = built(&sheets, &ReadOptions::default()).unwrap();
        let told: Vec<_> = reading.recordings.iter().map(|r| (&*r.name, r.loop_type)).collect();
        let expected = [
            ("chemicals.loop2", LoopType::OtherSelfRegulating),
            ("pulp.loop2", LoopType::OtherIntegrating),
        ];
        assert_eq!(told, expected);
        let op = &reading.recordings[0].op;
        assert_eq!(op.time, [0.0, 2.0, 4.0]);
        assert_eq!(op.quality, [Quality::Good, Quality::Missing, Quality::Good]);
        assert!(
            reading.notes.iter().any(|note| note.contains("cdata.info has no column known as OP"))
        );
    }

    #[test]
    fn times_of_the_format_are_local_unless_utc() {
        let times = |utc| Cells::Times { seconds: vec![1_704_067_200.0, 1_704_067_201.0], utc };
        let of = |utc, zone: Option<&str>| {
            let op = Cells::Numbers(vec![50.0, 51.0]);
            let sheets = [sheet("", vec![("time", times(utc)), ("op", op)])];
            let zone = zone.map(|zone| zone.parse().unwrap());
            let options = ReadOptions { zone, ..ReadOptions::default() };
            built(&sheets, &options).unwrap().recordings[0].start
        };
        assert_eq!(of(true, None), Some(1_704_067_200.0));
        assert_eq!(of(false, None), Some(1_704_067_200.0));
        assert_eq!(of(false, Some("Europe/Berlin")), Some(1_704_063_600.0));
    }

    #[test]
    fn numbers_that_cannot_be_are_refused() {
        let op = Cells::Numbers(vec![50.0, f64::INFINITY]);
        let mut infinite = sheet("", vec![("op", op)]);
        infinite.sample_time = Some(1.0);
        let message = built(&[infinite], &ReadOptions::default()).unwrap_err().to_string();
        assert!(
            message.contains("f.mat, row 2, column \"op\": inf is not a finite number"),
            "{message}"
        );
    }
}
