//! Judging new windows.
//!
//! # Windows
//! A window of a loop is a day of the plant on which its OP has a sample. If ten periods of the oscillation of that day
//! take longer, the window has as many days as these take, [`MOST_DAYS`] at most, and the next window begins after it.
//! So a window depends on the samples of its own days and on values held from the [day before](crate::day::HELD_FROM), but not on
//! the files in which they are stored, or on the other windows of the scan.
//!
//! # New windows
//! A window is done if the store has its row, made from the same files with the same settings. Files are identified by their
//! bytes, not by names or dates.
//!
//! # Time
//! A window that takes longer than the time limit is a row with an error, so a scan always ends. Only this row depends
//! on the speed of the machine. It is not repeated until its files change or a scan has a different limit. What runs
//! too long is not stopped: its thread computes until the program ends, and its result is ignored.
//!
//! # Memory
//! Windows are judged in [segments](SEGMENT) of days, in batches of loops that take a share of the allowed memory. Of
//! Parquet a batch reads only its own part. A long table whose row groups mix all tags is sorted on disk first. Other
//! files are read whole. Memory contains the largest of them and a batch, for any number of loops and days.

mod files;
pub mod inputs;
pub mod judge;
pub mod samples;
mod spill;
pub mod take;

use crate::day;
use crate::error::{Error, Result, file, store};
use crate::plant_file::{self, Plant};
use crate::store::trace::Trace;
use crate::store::window::{ENGINE_VERSION, WindowRow, model_version};
use crate::store::{Done, Run, Store};
use crate::unknown::{self, Unknown};
use files::{Files, Loops};
use inputs::{Changes, Inputs, Problem};
pub use judge::TIME_LIMIT_S;
use judge::{Judge, Judged, MOST_DAYS, Parts};
use rayon::ThreadPool;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::{ControlFlow, Range};
use std::path::Path;
use stiction_diagnose::recording::Recording;

/// Days that are judged together, so that each file is read about once for them. No window is longer.
pub const SEGMENT: i64 = MOST_DAYS + 1;
/// Number of rows of windows that are written together.
pub const PART: usize = 64;
/// Memory of a scan by default, bytes.
pub const MEMORY: u64 = 500 << 20;
/// Memory of a row of a long table while it is read and judged, two batches at a time, bytes.
const ROW: u64 = 320;

/// Options of a scan.
#[derive(Debug, Clone, Default)]
pub struct ScanOptions {
    /// Windows that begin on this day or later, days since 1970-01-01 on the plant's calendar; all without it.
    pub since: Option<i64>,
    /// Loops whose names fit this pattern, such as `FIC*`, in any case; all without it.
    pub loops: Option<String>,
    /// Threads; as many as the machine has without it. The rows are the same for any number.
    pub threads: Option<usize>,
    /// Memory, bytes; [`MEMORY`] by default. Less memory makes smaller batches, and the same rows.
    pub memory: Option<u64>,
    /// Whether windows that are done are judged again.
    pub again: bool,
    /// The longest time for a window, s; by default the limit in the plant's file, or else [`TIME_LIMIT_S`].
    pub time_limit_s: Option<u32>,
}

/// The progress of a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'a> {
    /// A file was examined.
    Looked(&'a str),
    /// A batch was written: days of loops that are done in this run, of all new ones.
    Written {
        /// Done.
        done: usize,
        /// Of all.
        of: usize,
    },
}

/// The result of a scan of a plant.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Manifest {
    /// Name of the plant.
    pub plant: String,
    /// Name of the run; `None` if nothing was new.
    pub run: Option<String>,
    /// Version of the program.
    pub engine_version: String,
    /// Version of the trained model of the verdict.
    pub model_version: String,
    /// Number of files that were examined.
    pub files: usize,
    /// Number of loops in these files.
    pub loops: usize,
    /// Number of windows that were judged in this run.
    pub windows: usize,
    /// Number of windows of this run that could not be judged.
    pub errors: usize,
    /// Number of files of the store that hold the rows of this run.
    pub parts: usize,
    /// Files and loops that could not be read.
    pub problems: Vec<Problem>,
    /// Files and loops that could not be read, loops without a PV, tags without a partner, and the windows of this run
    /// that were not judged.
    pub unknown: Vec<Unknown>,
    /// Files that are no recordings because they have no OP, with a sentence on each.
    pub no_recordings: Vec<String>,
    /// Files of earlier runs that were found damaged, with a sentence on each.
    pub damaged: Vec<String>,
    /// Data files that differ from the previous scan.
    pub changes: Changes,
}

/// A loop of the plant, and the progress of its windows.
struct Loop<'a> {
    name: &'a str,
    days: BTreeMap<i64, Vec<&'a str>>,
    judge: Judge<'a>,
    /// Windows that begin before this day are done.
    cursor: i64,
}

/// Days of a loop that are judged together.
struct Piece<'a, 's> {
    /// The place of the loop.
    place: usize,
    of: &'s Loop<'a>,
    /// Windows begin on `from` or later, and end before `until`.
    from: i64,
    until: i64,
    /// Recordings by file.
    parts: Vec<(&'a str, Recording)>,
    /// The files that could not be read for the window, and why.
    failed: Vec<(&'a str, String)>,
}

impl Piece<'_, '_> {
    /// The recordings for the window of `count` days from `day` on. Files without samples of these days do not matter.
    fn parts(&self, day: i64, count: i64) -> Parts<'_> {
        let own = |path: &str| {
            self.of.days.range(day..day + count).any(|(_, files)| files.contains(&path))
        };
        let failed = self.failed.iter().find(|(path, _)| own(path));
        failed.map_or(Ok(&*self.parts), |(_, why)| Err(&**why))
    }
}

/// Judges the new windows of the plant in `folder` and keeps them in its store. `watch` is called with the progress, and may end
/// the scan after a batch. The written rows stay.
///
/// # Errors
/// If the store cannot be read or written, an option is invalid, or another scan is running. A
/// file, loop or window that cannot be judged is a problem or a row with an error, and does not stop the others.
pub fn scan(
    folder: &Path,
    plant: &Plant,
    options: &ScanOptions,
    mut watch: impl FnMut(Progress<'_>) -> ControlFlow<()>,
) -> Result<Manifest> {
    let wanted = options.loops.as_deref().map(glob::Pattern::new).transpose();
    let wanted = wanted.map_err(|e| Error::Option(format!("invalid pattern of loops: {e}")))?;
    let any_case = glob::MatchOptions { case_sensitive: false, ..glob::MatchOptions::new() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads.unwrap_or(0)).build();
    let pool = pool.map_err(|e| Error::Option(format!("the threads: {e}")))?;

    let store_of = Store::of(folder);
    let run = store_of.begin()?;
    let mut inputs = Inputs::known(&store_of, plant);
    let changes = inputs.update(folder, plant, |path| {
        // Only a batch can be the last thing that is done.
        let _ = watch(Progress::Looked(path));
    });
    inputs.keep(&store_of)?;

    let mut scan = Scan { plant, inputs: &inputs, done: HashMap::new() };
    if !options.again {
        scan.done = store_of.done()?;
    }
    let mut loops: Vec<Loop<'_>> = inputs
        .days()
        .into_iter()
        .map(|(name, days)| {
            let judge = Judge::of(plant, name).within(options.time_limit_s);
            Loop { name, days, judge, cursor: options.since.unwrap_or(i64::MIN) }
        })
        .collect();
    let loops_there = loops.len();
    loops.retain(|each| wanted.as_ref().is_none_or(|w| w.matches_with(each.name, any_case)));

    let memory = options.memory.unwrap_or(MEMORY);
    let mut files = Files::of(folder, plant, (memory / 4) as usize);
    let sorted = store_of.path("sorted");
    let open: usize = loops.iter().map(|each| scan.open_days(each)).sum();
    let mut kept =
        Kept { run, rows: vec![], traces: vec![], windows: 0, errors: 0, days: 0, unknown: vec![] };
    let mut is_whole = options.since.is_none() && options.loops.is_none();
    while let Some(from) = scan.next_segment(&mut loops) {
        let until = from + SEGMENT;
        let batches = batches(&loops, until, &files, (memory / ROW).max(1) as usize);
        // Remains of an interrupted scan.
        remove(&sorted)?;
        sort(&mut files, &loops, &batches, from..until, &sorted)?;
        let segment = Segment { scan: &scan, loops: &loops, batches, until, files: &files };
        let judged = segment.judge(&pool, &mut kept, |days| {
            watch(Progress::Written { done: days.min(open), of: open })
        })?;
        files.forget_sorted();
        let ControlFlow::Continue(cursors) = judged else {
            is_whole = false;
            break;
        };
        for (place, cursor) in cursors {
            loops[place].cursor = cursor;
        }
    }
    remove(&sorted)?;
    let mut unknown = unknown::of_inputs(&inputs, plant);
    unknown.append(&mut kept.unknown);
    let manifest = Manifest {
        plant: plant.file.name.clone(),
        run: (kept.run.parts() > 0).then(|| kept.run.name.clone()),
        engine_version: ENGINE_VERSION.to_owned(),
        model_version: model_version(),
        files: inputs.files.len(),
        loops: loops_there,
        windows: kept.windows,
        errors: kept.errors,
        parts: kept.run.parts(),
        problems: inputs.problems(plant),
        unknown,
        no_recordings: inputs.no_recordings(),
        damaged: store_of.damaged(),
        changes,
    };
    if is_whole {
        kept.run.mark_whole()?;
    }
    let text =
        serde_json::to_string_pretty(&manifest).map_err(|e| store(&store_of.path("runs"), e))?;
    kept.run.end(&text)?;
    Ok(manifest)
}

/// The recordings of judged windows, read again from the plant's files. Each window has one recording in order, or the
/// reason why it has none.
pub fn recordings_of(
    folder: &Path,
    plant: &Plant,
    rows: &[&WindowRow],
) -> Vec<Result<Recording, String>> {
    let mut inputs = Inputs::known(&Store::of(folder), plant);
    if inputs.files.is_empty() {
        inputs.update(folder, plant, |_| {});
    }
    let scan = Scan { plant, inputs: &inputs, done: HashMap::new() };
    let days = inputs.days();
    let of = |row: &&WindowRow| day::of(row.window_start as f64, &plant.zone);
    let after =
        |row: &&WindowRow| day::of((row.window_start + row.window_s) as f64 - 1.0, &plant.zone) + 1;
    let known = |row: &&WindowRow| days.get(&*row.name).cloned().unwrap_or_default();
    let loops: Vec<Loop<'_>> = rows
        .iter()
        .map(|row| Loop {
            name: &row.name,
            days: known(row),
            judge: Judge::of(plant, &row.name),
            cursor: of(row),
        })
        .collect();
    let each = loops.iter().zip(rows).enumerate();
    let mut pieces: Vec<Piece<'_, '_>> = each
        .map(|(place, (one, row))| Piece {
            place,
            of: one,
            from: of(row),
            until: after(row),
            parts: vec![],
            failed: vec![],
        })
        .collect();
    scan.read(&Files::of(folder, plant, (MEMORY / 4) as usize), &mut pieces, 0);
    let recording = |piece: &Piece<'_, '_>| {
        let (judge, count) = (&piece.of.judge, piece.until - piece.from);
        let found = judge.recording(piece.parts(piece.from, count)?, piece.from, count)?;
        found.ok_or_else(|| "the data files no longer have samples of this window".to_owned())
    };
    pieces.iter().map(recording).collect()
}

/// Removes a folder, if it exists.
fn remove(folder: &Path) -> Result<()> {
    match std::fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(file(folder)(e)),
        _ => Ok(()),
    }
}

/// The loops with windows to be judged before `until`, by their positions, in batches of this many rows.
fn batches(loops: &[Loop<'_>], until: i64, files: &Files<'_>, rows: usize) -> Vec<Vec<usize>> {
    let mut known: HashMap<&str, usize> = HashMap::new();
    let mut batches: Vec<Vec<usize>> = vec![];
    let mut size = usize::MAX;
    for (place, each) in loops.iter().enumerate().filter(|(_, each)| each.cursor < until) {
        let days = each.days.range(each.cursor - 1..until);
        let paths: BTreeSet<&str> = days.flat_map(|(_, paths)| paths.iter().copied()).collect();
        let own: usize =
            paths.iter().map(|path| *known.entry(path).or_insert_with(|| files.rows(path))).sum();
        size = size.saturating_add(own);
        match batches.last_mut().filter(|_| size <= rows) {
            Some(batch) => batch.push(place),
            None => {
                batches.push(vec![place]);
                size = own;
            }
        }
    }
    batches
}

/// Sorts to `folder` the rows of the files of some days that batches would have to decode more than once.
fn sort(
    files: &mut Files<'_>,
    loops: &[Loop<'_>],
    batches: &[Vec<usize>],
    days: Range<i64>,
    folder: &Path,
) -> Result<()> {
    let names = |batch: &Vec<usize>| batch.iter().map(|place| loops[*place].name).collect();
    let named: Vec<Vec<&str>> = batches.iter().map(names).collect();
    let days = loops.iter().flat_map(|each| each.days.range(days.start - 1..days.end));
    let paths: BTreeSet<&str> = days.flat_map(|(_, files)| files.iter().copied()).collect();
    for (k, path) in paths.iter().enumerate() {
        files.sort(path, &named, &folder.join(k.to_string()))?;
    }
    Ok(())
}

/// The stored part of a window: its row, and its trace if available.
type Window = (WindowRow, Option<Trace>);

/// Judged windows on their way to the store.
struct Kept {
    run: Run,
    rows: Vec<WindowRow>,
    traces: Vec<Trace>,
    /// Number of written windows, and number of windows that could not be judged.
    windows: usize,
    errors: usize,
    /// Days of loops that are done.
    days: usize,
    unknown: Vec<Unknown>,
}

impl Kept {
    fn write(&mut self, plant: &Plant) -> Result<()> {
        if self.rows.is_empty() {
            return Ok(());
        }
        self.run.write_traces(&self.traces)?;
        self.run.write(&self.rows)?;
        self.windows += self.rows.len();
        self.unknown.extend(unknown::of_windows(&self.rows, plant));
        self.errors += self.rows.iter().filter(|row| row.error.is_some()).count();
        self.rows.clear();
        self.traces.clear();
        Ok(())
    }
}

/// Days that are judged together, in batches of loops.
struct Segment<'s, 'a> {
    scan: &'s Scan<'a>,
    loops: &'s [Loop<'a>],
    batches: Vec<Vec<usize>>,
    until: i64,
    files: &'s Files<'a>,
}

impl<'s, 'a> Segment<'s, 'a> {
    /// The data of a batch; `None` after the last.
    fn read(&self, batch: usize) -> Option<Vec<Piece<'a, 's>>> {
        let piece = |place: &usize| {
            let of = &self.loops[*place];
            let (parts, failed) = (vec![], vec![]);
            Piece { place: *place, of, from: of.cursor, until: self.until, parts, failed }
        };
        let mut pieces: Vec<_> = self.batches.get(batch)?.iter().map(piece).collect();
        self.scan.read(self.files, &mut pieces, batch);
        Some(pieces)
    }

    /// Judges it while the next batch is read. Returns the days from which its loops are to be judged next. `written` is called with
    /// the number of days that are done, and may end the scan.
    fn judge(
        &self,
        pool: &ThreadPool,
        kept: &mut Kept,
        mut written: impl FnMut(usize) -> ControlFlow<()>,
    ) -> Result<ControlFlow<(), Vec<(usize, i64)>>> {
        let mut cursors = vec![];
        let mut next = pool.install(|| self.read(0));
        let mut k = 0;
        while let Some(pieces) = next {
            let judge = || pieces.par_iter().map(|piece| self.scan.judge(piece)).collect();
            let (judged, following): (Vec<(Vec<Window>, i64)>, _) =
                pool.install(|| rayon::join(judge, || self.read(k + 1)));
            (next, k) = (following, k + 1);
            for (piece, (own, cursor)) in pieces.iter().zip(judged) {
                kept.days += piece.of.days.range(piece.from..cursor).count();
                cursors.push((piece.place, cursor));
                for (row, trace) in own {
                    kept.rows.push(row);
                    kept.traces.extend(trace);
                }
            }
            if kept.rows.len() >= PART || next.is_none() {
                kept.write(self.scan.plant)?;
                if written(kept.days).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
        Ok(ControlFlow::Continue(cursors))
    }
}

/// The constants of a scan.
struct Scan<'a> {
    plant: &'a Plant,
    inputs: &'a Inputs,
    /// The judged windows.
    done: HashMap<(String, i64), Done>,
}

impl Scan<'_> {
    /// SHA-256 of the files of a window of `count` days from `day` on.
    fn fingerprint(&self, of: &Loop<'_>, day: i64, count: i64) -> String {
        let files: BTreeSet<&str> = of
            .days
            .range(day - 1..day + count)
            .flat_map(|(_, files)| files.iter().copied())
            .collect();
        let each: BTreeSet<&str> = files
            .iter()
            .filter_map(|path| Some(self.inputs.files.get(*path)?.fingerprint(of.name)))
            .collect();
        plant_file::hash(&each.into_iter().collect::<Vec<_>>().join("\n"))
    }

    /// The number of days of the window that begins on `day`, if it is done.
    fn done(&self, of: &Loop<'_>, day: i64) -> Option<i64> {
        let zone = &self.plant.zone;
        let start = day::begin(day, zone);
        let done = self.done.get(&(of.name.to_owned(), start as i64))?;
        let count = day::of(start + done.window_s as f64 - 1.0, zone) + 1 - day;
        let files = self.fingerprint(of, day, count);
        let is_now = |settings: &str| *done == Done::of(done.window_s, settings, &files);
        (is_now(&of.judge.settings) || is_now(&of.judge.limited_settings())).then_some(count)
    }

    /// The first day, from `cursor` on, of a window that is not done.
    fn next_open(&self, of: &Loop<'_>, cursor: i64) -> Option<i64> {
        let mut cursor = cursor;
        loop {
            let (day, _) = of.days.range(cursor..).next()?;
            match self.done(of, *day) {
                Some(count) => cursor = day + count,
                None => return Some(*day),
            }
        }
    }

    /// The first day without a done window of a loop. Each loop proceeds to its own day.
    fn next_segment(&self, loops: &mut [Loop<'_>]) -> Option<i64> {
        for each in &mut *loops {
            each.cursor = self.next_open(each, each.cursor).unwrap_or(i64::MAX);
        }
        loops.iter().map(|each| each.cursor).min().filter(|day| *day < i64::MAX)
    }

    /// The approximate number of days to judge.
    fn open_days(&self, of: &Loop<'_>) -> usize {
        let mut open = 0;
        let mut cursor = of.cursor;
        while let Some((day, _)) = of.days.range(cursor..).next() {
            let count = self.done(of, *day);
            open += usize::from(count.is_none());
            cursor = day + count.unwrap_or(1);
        }
        open
    }

    /// Reads the data of a batch, several files at a time.
    fn read<'a>(&self, files: &Files<'_>, pieces: &mut [Piece<'a, '_>], batch: usize) {
        let mut wanted: BTreeMap<&'a str, Vec<usize>> = BTreeMap::new();
        for (k, piece) in pieces.iter().enumerate() {
            let days = piece.of.days.range(piece.from - 1..piece.until);
            for path in days.flat_map(|(_, files)| files.iter().copied()) {
                let of = wanted.entry(path).or_default();
                if of.last() != Some(&k) {
                    of.push(k);
                }
            }
        }
        let wanted: Vec<(&'a str, Vec<usize>)> = wanted.into_iter().collect();
        let zone = &self.plant.zone;
        let shared = &*pieces;
        let read = |(path, of): &(&'a str, Vec<usize>)| -> Vec<(usize, Result<Recording, String>)> {
            let names: Vec<&str> = of.iter().map(|k| shared[*k].of.name).collect();
            let part = |(k, recordings): (&usize, Loops)| {
                let piece = &shared[*k];
                let recordings = match recordings {
                    Ok(recordings) => recordings,
                    Err(e) => return Some((*k, Err(e))),
                };
                let whole = recordings.iter().find(|r| r.name == piece.of.name)?;
                let (from, to) = (day::begin(piece.from - 1, zone), day::begin(piece.until, zone));
                day::slice(whole, from, to).map(|part| (*k, Ok(part)))
            };
            of.iter().zip(files.read(path, &names, batch)).filter_map(part).collect()
        };
        let found: Vec<_> = wanted.par_iter().map(read).collect();
        for ((path, _), parts) in wanted.iter().zip(found) {
            for (k, part) in parts {
                match part {
                    Ok(part) => pieces[k].parts.push((path, part)),
                    Err(e) => pieces[k].failed.push((path, e)),
                }
            }
        }
    }

    /// The rows of a piece, and the day from which it is to be judged next.
    fn judge(&self, piece: &Piece<'_, '_>) -> (Vec<Window>, i64) {
        let mut rows = vec![];
        let mut cursor = piece.from;
        while let Some((day, _)) = piece.of.days.range(cursor..piece.until.max(cursor)).next() {
            if let Some(count) = self.done(piece.of, *day) {
                cursor = day + count;
                continue;
            }
            let (row, count) = self.window(piece, *day);
            // The rest was not read. The window begins the next segment.
            if piece.of.days.range(piece.until..(day + count).max(piece.until)).next().is_some() {
                return (rows, *day);
            }
            rows.extend(row);
            cursor = day + count;
        }
        (rows, cursor)
    }

    /// The window that begins on `day`, and its number of days. None without a sample of the OP, or if the window ends after the
    /// data that were read.
    fn window(&self, piece: &Piece<'_, '_>, day: i64) -> (Option<Window>, i64) {
        let of_files = |judged: Judged, count: i64| {
            let input_fingerprint = self.fingerprint(piece.of, day, count);
            judged.row.map(|row| (WindowRow { input_fingerprint, ..row }, judged.trace))
        };
        let judged = piece.of.judge.window(piece.parts(day, 1), day, 1);
        match judged.days {
            1 => (of_files(judged, 1), 1),
            count
                if day + count > piece.until
                    && piece.of.days.range(piece.until..day + count).next().is_some() =>
            {
                (None, count)
            }
            count => {
                let judged = piece.of.judge.window(piece.parts(day, count), day, count);
                (of_files(judged, count), count)
            }
        }
    }
}
