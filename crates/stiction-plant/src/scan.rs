//! Judging what is new.
//!
//! # Windows
//! A window of a loop is a day of the plant on which its OP has a sample. If ten periods of the oscillation of that day
//! take longer, it is as many days as these take, [`MOST_DAYS`] at most, and the next window begins after it.
//! So a window depends on the samples of its own days, and on values held from the [day before](crate::day::HELD_FROM),
//! and not on the files in which they lie, nor on what is scanned with it.
//!
//! # What is new
//! A window is done if the store has its row, made of the same files by the same settings. Files are told apart by their
//! bytes, not by names or dates.
//!
//! # Memory
//! Loops are judged in batches of about [`BATCH`] days of loops, written as they end. Each batch reads its files again,
//! one at a time: memory is that of the largest file and a batch, whatever the number of loops and days.

use crate::day;
use crate::error::{Error, Result, store};
use crate::inputs::{Inputs, Problem};
use crate::plant_file::{self, Plant};
use crate::store::Store;
use crate::window::{ENGINE_VERSION, WindowRow, model_version};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::ControlFlow;
use std::path::Path;
use stiction_diagnose::diagnose::{DiagnoseOptions, diagnose};
use stiction_diagnose::recording::Recording;
use stiction_io::{join, reading};

/// Periods that a window has at least, as far as [`MOST_DAYS`] allow.
pub const PERIODS: f64 = 10.0;
/// The most days of a window.
pub const MOST_DAYS: i64 = 7;
/// Days of loops that are judged before they are written.
pub const BATCH: usize = 256;

/// What is scanned, and how.
#[derive(Debug, Clone, Default)]
pub struct ScanOptions {
    /// Windows that begin on this day or later, days since 1970-01-01 on the plant's calendar; all without it.
    pub since: Option<i64>,
    /// Loops whose names fit this pattern, such as `FIC*`, in any case; all without it.
    pub loops: Option<String>,
    /// Threads; as many as the machine has without it. The rows are the same for any number.
    pub threads: Option<usize>,
}

/// How far a scan is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<'a> {
    /// A file was looked at.
    Looked(&'a str),
    /// A batch is on the disk: days of loops that are done in this run, of all that were new.
    Written {
        /// Done.
        done: usize,
        /// Of so many.
        of: usize,
    },
}

/// What a scan did.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Manifest {
    /// Name of the plant.
    pub plant: String,
    /// Name of the run; none if nothing was new.
    pub run: Option<String>,
    /// Version of the program.
    pub engine_version: String,
    /// What the verdict was trained on.
    pub model_version: String,
    /// Files that were looked at.
    pub files: usize,
    /// Loops in them.
    pub loops: usize,
    /// Windows that were judged in this run.
    pub windows: usize,
    /// Of these, windows that could not be judged.
    pub errors: usize,
    /// Parts in which they are kept.
    pub parts: usize,
    /// What could not be read.
    pub problems: Vec<Problem>,
}

/// Days of a loop that are judged together.
struct Piece<'a> {
    name: &'a str,
    days: &'a BTreeMap<i64, Vec<&'a str>>,
    settings: String,
    /// Windows begin on `from` or later, and before `until`.
    from: i64,
    until: i64,
    /// What each file holds of it.
    parts: Vec<(&'a str, Recording)>,
    /// Why a file could not be read again.
    failed: Vec<String>,
}

/// Judges what is new of the plant in `folder` and keeps it in its store. `watch` hears how far it is, and may end the
/// scan after a batch; what is written stays.
///
/// # Errors
/// If the plant's folder cannot be listed, the store not be read or written, an option cannot be, or somebody else is
/// scanning. A file, loop or window that cannot be judged is a problem or a row with an error, and stops no other.
pub fn scan(
    folder: &Path,
    plant: &Plant,
    options: &ScanOptions,
    mut watch: impl FnMut(Progress<'_>) -> ControlFlow<()>,
) -> Result<Manifest> {
    let wanted = options.loops.as_deref().map(glob::Pattern::new).transpose();
    let wanted = wanted.map_err(|e| Error::Option(format!("the pattern of loops: {e}")))?;
    let any_case = glob::MatchOptions { case_sensitive: false, ..glob::MatchOptions::new() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads.unwrap_or(0)).build();
    let pool = pool.map_err(|e| Error::Option(format!("the threads: {e}")))?;

    let store_of = Store::of(folder);
    let mut run = store_of.begin()?;
    let mut inputs = Inputs::known(&store_of, plant);
    inputs.update(folder, plant, |path| {
        // Only a batch can be the last thing that is done.
        let _ = watch(Progress::Looked(path));
    })?;
    inputs.keep(&store_of)?;

    let done: HashMap<(String, i64), WindowRow> = store_of
        .rows()?
        .into_iter()
        .map(|row| ((row.name.clone(), row.window_start), row))
        .collect();
    let scan = Scan { plant, inputs: &inputs, done };
    let mut loops = inputs.days();
    let loops_there = loops.len();
    loops.retain(|name, _| wanted.as_ref().is_none_or(|w| w.matches_with(name, any_case)));

    let since = options.since.unwrap_or(i64::MIN);
    let mut cursors: BTreeMap<&str, i64> = loops.keys().map(|name| (*name, since)).collect();
    let open: usize = loops.iter().map(|(name, days)| scan.open_days(name, days, since)).sum();
    let length = (BATCH / loops.len().max(1)).clamp(MOST_DAYS as usize + 1, 64) as i64;
    let (mut windows, mut errors, mut days_done) = (0, 0, 0);
    loop {
        let mut pieces: Vec<Piece<'_>> = vec![];
        let mut size = 0;
        for (name, days) in &loops {
            if size >= BATCH {
                break;
            }
            let Some(cursor) = cursors.get_mut(name) else { continue };
            match scan.next_open(name, days, *cursor) {
                None => *cursor = i64::MAX,
                Some(from) => {
                    let until = from + length;
                    size += days.range(from..until).count();
                    pieces.push(Piece {
                        name,
                        days,
                        settings: plant.settings_hash(name),
                        from,
                        until,
                        parts: vec![],
                        failed: vec![],
                    });
                }
            }
        }
        if pieces.is_empty() {
            break;
        }
        scan.read(folder, &mut pieces);
        let judged: Vec<(Vec<WindowRow>, i64)> =
            pool.install(|| pieces.par_iter().map(|piece| scan.judge(piece)).collect());
        let mut rows = vec![];
        for (piece, (own, next)) in pieces.iter().zip(judged) {
            cursors.insert(piece.name, next);
            days_done += piece.days.range(piece.from..next).count();
            rows.extend(own);
        }
        windows += rows.len();
        errors += rows.iter().filter(|row| row.error.is_some()).count();
        run.write(&rows)?;
        let done = days_done.min(open);
        if watch(Progress::Written { done, of: open }).is_break() {
            break;
        }
    }
    let manifest = Manifest {
        plant: plant.file.name.clone(),
        run: (run.parts() > 0).then(|| run.name.clone()),
        engine_version: ENGINE_VERSION.to_owned(),
        model_version: model_version(),
        files: inputs.files.len(),
        loops: loops_there,
        windows,
        errors,
        parts: run.parts(),
        problems: inputs.problems(plant),
    };
    let text =
        serde_json::to_string_pretty(&manifest).map_err(|e| store(&store_of.path("runs"), e))?;
    run.end(&text)?;
    Ok(manifest)
}

/// The recordings of windows that were judged, read again from the plant's files: one each, in their order, or why there
/// is none.
///
/// # Errors
/// If the plant's folder cannot be listed.
pub fn recordings_of(
    folder: &Path,
    plant: &Plant,
    rows: &[&WindowRow],
) -> Result<Vec<std::result::Result<Recording, String>>> {
    let mut inputs = Inputs::known(&Store::of(folder), plant);
    if inputs.files.is_empty() {
        inputs.update(folder, plant, |_| {})?;
    }
    let scan = Scan { plant, inputs: &inputs, done: HashMap::new() };
    let (loops, none) = (inputs.days(), BTreeMap::new());
    let mut pieces: Vec<Piece<'_>> = rows
        .iter()
        .map(|row| {
            let from = day::of(row.window_start as f64, &plant.zone);
            Piece {
                name: &row.name,
                days: loops.get(&*row.name).unwrap_or(&none),
                settings: String::new(),
                from,
                until: from + 1,
                parts: vec![],
                failed: vec![],
            }
        })
        .collect();
    scan.read(folder, &mut pieces);
    let recording = |(piece, row): (&Piece<'_>, &&WindowRow)| {
        let end = (row.window_start + row.window_s) as f64 - 1.0;
        scan.recording(piece, piece.from, day::of(end, &plant.zone) + 1 - piece.from)
    };
    Ok(pieces.iter().zip(rows).map(recording).collect())
}

/// What holds throughout a scan.
struct Scan<'a> {
    plant: &'a Plant,
    inputs: &'a Inputs,
    /// The rows that count.
    done: HashMap<(String, i64), WindowRow>,
}

impl Scan<'_> {
    /// SHA-256 of the files that a window of `count` days from `day` on is made of.
    fn fingerprint(&self, days: &BTreeMap<i64, Vec<&str>>, day: i64, count: i64) -> String {
        let files: BTreeSet<&str> =
            days.range(day - 1..day + count).flat_map(|(_, files)| files.iter().copied()).collect();
        let each: BTreeSet<&str> =
            files.iter().filter_map(|path| Some(&*self.inputs.files.get(*path)?.sha256)).collect();
        plant_file::hash(&each.into_iter().collect::<Vec<_>>().join("\n"))
    }

    /// How many days the window that begins on `day` has, if it is done.
    fn done(
        &self,
        name: &str,
        settings: &str,
        days: &BTreeMap<i64, Vec<&str>>,
        day: i64,
    ) -> Option<i64> {
        let zone = &self.plant.zone;
        let start = day::begin(day, zone);
        let row = self.done.get(&(name.to_owned(), start as i64))?;
        let count = day::of(start + row.window_s as f64 - 1.0, zone) + 1 - day;
        let same = row.settings_hash == settings
            && row.input_fingerprint == self.fingerprint(days, day, count);
        same.then_some(count)
    }

    /// The first day, from `cursor` on, of a window that is not done.
    fn next_open(&self, name: &str, days: &BTreeMap<i64, Vec<&str>>, cursor: i64) -> Option<i64> {
        let settings = self.plant.settings_hash(name);
        let mut cursor = cursor;
        loop {
            let (day, _) = days.range(cursor..).next()?;
            match self.done(name, &settings, days, *day) {
                Some(count) => cursor = day + count,
                None => return Some(*day),
            }
        }
    }

    /// About how many days are to be judged.
    fn open_days(&self, name: &str, days: &BTreeMap<i64, Vec<&str>>, since: i64) -> usize {
        let settings = self.plant.settings_hash(name);
        let mut open = 0;
        let mut cursor = since;
        while let Some((day, _)) = days.range(cursor..).next() {
            let count = self.done(name, &settings, days, *day);
            open += usize::from(count.is_none());
            cursor = day + count.unwrap_or(1);
        }
        open
    }

    /// Reads what the pieces need, one file after the other.
    fn read<'p>(&self, folder: &Path, pieces: &mut [Piece<'p>]) {
        let mut files: BTreeMap<&'p str, Vec<usize>> = BTreeMap::new();
        for (k, piece) in pieces.iter().enumerate() {
            let days = piece.days.range(piece.from - 1..piece.until + MOST_DAYS - 1);
            for path in days.flat_map(|(_, files)| files.iter().copied()) {
                let of = files.entry(path).or_default();
                if of.last() != Some(&k) {
                    of.push(k);
                }
            }
        }
        let zone = &self.plant.zone;
        for (path, of) in files {
            let reading = match reading::read(&folder.join(path), &self.plant.options) {
                Ok(reading) => reading,
                Err(e) => {
                    of.iter().for_each(|k| pieces[*k].failed.push(e.to_string()));
                    continue;
                }
            };
            for k in of {
                let piece = &mut pieces[k];
                let Some(whole) = reading.recordings.iter().find(|r| r.name == piece.name) else {
                    continue;
                };
                let from = day::begin(piece.from - 1, zone);
                let to = day::begin(piece.until + MOST_DAYS - 1, zone);
                piece.parts.extend(day::slice(whole, from, to).map(|part| (path, part)));
            }
        }
    }

    /// The rows of a piece, and the day after its last window.
    fn judge(&self, piece: &Piece<'_>) -> (Vec<WindowRow>, i64) {
        let mut rows = vec![];
        let mut cursor = piece.from;
        // The last window may end after the piece does.
        while let Some((day, _)) = piece.days.range(cursor..piece.until.max(cursor)).next() {
            if let Some(count) = self.done(piece.name, &piece.settings, piece.days, *day) {
                cursor = day + count;
                continue;
            }
            let (row, count) = self.window(piece, *day);
            rows.push(row);
            cursor = day + count;
        }
        (rows, cursor)
    }

    /// The row of the window that begins on `day`, and how many days it has.
    fn window(&self, piece: &Piece<'_>, day: i64) -> (WindowRow, i64) {
        let facts = self.plant.facts(piece.name);
        let identity = |count: i64| {
            let (start, end) =
                (day::begin(day, &self.plant.zone), day::begin(day + count, &self.plant.zone));
            WindowRow {
                name: piece.name.to_owned(),
                area: facts.and_then(|facts| facts.area.clone()),
                unit: facts.and_then(|facts| facts.unit.clone()),
                loop_type: facts.and_then(|f| f.loop_type.clone()).unwrap_or("unknown".to_owned()),
                window_start: start as i64,
                window_s: (end - start) as i64,
                engine_version: ENGINE_VERSION.to_owned(),
                model_version: model_version(),
                settings_hash: piece.settings.clone(),
                input_fingerprint: self.fingerprint(piece.days, day, count),
                ..WindowRow::default()
            }
        };
        let found = |count: i64| {
            let recording = self.recording(piece, day, count)?;
            diagnose(&recording, &DiagnoseOptions::default()).map_err(|e| e.to_string())
        };
        let judged = |count: i64| match found(count) {
            Ok(found) => {
                let period =
                    found.oscillation().filter(|(_, o)| o.found).and_then(|(_, o)| o.period_s);
                (identity(count).judged(&found), period)
            }
            Err(error) => (WindowRow { error: Some(error), ..identity(count) }, None),
        };
        let (row, period) = judged(1);
        let wanted = period.map_or(1, |period| (PERIODS * period / 86_400.0).ceil() as i64);
        match wanted.clamp(1, MOST_DAYS) {
            1 => (row, 1),
            count => (judged(count).0, count),
        }
    }

    /// The recording of a window, from all files that hold some of it.
    fn recording(
        &self,
        piece: &Piece<'_>,
        day: i64,
        count: i64,
    ) -> std::result::Result<Recording, String> {
        if let Some(failed) = piece.failed.first() {
            return Err(failed.clone());
        }
        let begin = |day: i64| day::begin(day, &self.plant.zone);
        let (before, from, to) = (begin(day - 1), begin(day), begin(day + count));
        let joined = |from: f64| {
            let parts: Vec<(&str, Recording)> = piece
                .parts
                .iter()
                .filter_map(|(path, part)| Some((*path, day::slice(part, from, to)?)))
                .collect();
            join::join(&parts.iter().map(|(path, part)| (*path, part)).collect::<Vec<_>>())
        };
        // What does not fit together with the day before is judged without it.
        let whole = joined(before).or_else(|_| joined(from)).map_err(|e| e.to_string())?;
        day::cut(&whole, from, to).ok_or_else(|| "has no sample of the OP".to_owned())
    }
}
