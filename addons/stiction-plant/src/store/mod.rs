//! The store of judged windows, beside the plant's file.
//!
//! ```text
//! .stiction/lock                               held by the writer of runs
//! .stiction/log.lock                           held by the writer of log.toml
//! .stiction/inputs.json                        index of the data files; remade if lost
//! .stiction/runs/0001/windows-0001-SHA.parquet rows, written as they end
//! .stiction/runs/0001/traces-0001-SHA.parquet  their traces, written before them
//! .stiction/runs/0001/manifest.json            result of the run; missing if the run was interrupted
//! .stiction/whole                              the last run when a scan of all loops and days was complete
//! .stiction/damaged/                           damaged files of runs, which no longer count
//! .stiction/index/02931.parquet                the valid rows of a week, made from the runs
//! .stiction/index/through                      the last run that is in it
//! .stiction/pairs/2026-W10-SHA256.parquet      pairs of loops of a week, found elsewhere, and what they were made of
//! ```
//!
//! Every file is written under a temporary name and renamed, so it exists whole or not at all. Rows count even if their
//! run was interrupted. Only these files show which windows are done.
//!
//! SHA is the beginning of the SHA-256 of the file. A damaged file of a run is skipped. The next scan moves
//! it to `damaged` and judges its windows again. An unreadable index is remade from the runs.

pub mod pair;
pub mod parquet_file;
pub mod table;
pub mod trace;
pub mod window;

use crate::error::{Error, Result, file, store};
use crate::week::Week;
use pair::Pair;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::statistics::Statistics;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::{self, File, TryLockError};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;
use table::{Row, Table};
use trace::Trace;
use window::WindowRow;

/// The folder of the store, inside the plant's folder.
pub(crate) const STORE: &str = ".stiction";

/// The store of a plant.
#[derive(Debug, Clone)]
pub struct Store {
    folder: PathBuf,
    /// Damaged files, in sentences.
    damaged: Arc<Mutex<BTreeSet<String>>>,
}

/// The identity of a judged window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Done {
    /// Duration, s.
    pub window_s: i64,
    /// The beginning of a SHA-256 of its settings and its input.
    made_of: [u8; 16],
}

impl Done {
    /// Of a window of this duration, judged with these settings from this input.
    pub fn of(window_s: i64, settings_hash: &str, input_fingerprint: &str) -> Self {
        let digest = Sha256::digest(format!("{settings_hash}\n{input_fingerprint}"));
        let mut made_of = [0; 16];
        made_of.copy_from_slice(&digest[..16]);
        Self { window_s, made_of }
    }
}

/// A run that is being written. While it lives no other process writes to the store.
#[derive(Debug)]
pub struct Run {
    /// Name: a number, one above the last.
    pub name: String,
    folder: PathBuf,
    store: Store,
    parts: usize,
    _lock: File,
}

impl Store {
    /// The store of the plant in `folder`, which need not exist.
    pub fn of(folder: &Path) -> Self {
        Self { folder: folder.join(STORE), damaged: Arc::default() }
    }

    /// The files that were found damaged since this was made, a sentence each.
    pub fn damaged(&self) -> Vec<String> {
        self.damaged.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
    }

    fn found_damaged(&self, sentence: String) {
        self.damaged.lock().unwrap_or_else(PoisonError::into_inner).insert(sentence);
    }

    /// File of that name.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn runs(&self) -> PathBuf {
        self.folder.join("runs")
    }

    /// Begins a run.
    ///
    /// # Errors
    /// If another process writes, or the folder cannot be created.
    pub fn begin(&self) -> Result<Run> {
        fs::create_dir_all(self.runs()).map_err(file(&self.folder))?;
        let path = self.path("lock");
        let lock = File::create(&path).map_err(file(&path))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Error::Locked { path: path.display().to_string() });
            }
            Err(TryLockError::Error(e)) => return Err(file(&path)(e)),
        }
        self.remove_left_over()?;
        self.set_damaged_apart()?;
        self.index_again_if_damaged()?;
        let last = self.run_names()?.iter().map(|name| number(name)).max();
        let name = format!("{:04}", last.unwrap_or(0) + 1);
        let folder = self.runs().join(&name);
        Ok(Run { name, folder, store: self.clone(), parts: 0, _lock: lock })
    }

    /// Removes the remains of killed scans from the folders of runs.
    fn remove_left_over(&self) -> Result<()> {
        for run in self.run_names()? {
            stiction_io::whole::remove_left_over(&self.runs().join(run));
        }
        Ok(())
    }

    /// Moves damaged files out of their runs. Their rows in the index stay.
    fn set_damaged_apart(&self) -> Result<()> {
        let through = self.path("index").join("through");
        let indexed = fs::metadata(through).and_then(|there| there.modified()).ok();
        for run in self.run_names()? {
            let folder = self.runs().join(&run);
            for part in names(&folder, |name| is_part(name, WINDOWS) || is_part(name, TRACES))? {
                let path = folder.join(&part);
                if looks_whole(&path, indexed)? {
                    continue;
                }
                let apart = self.path("damaged");
                fs::create_dir_all(&apart).map_err(file(&apart))?;
                let to = apart.join(format!("{run}-{part}"));
                fs::rename(&path, &to).map_err(file(&path))?;
                self.found_damaged(format!(
                    "{} is damaged, and was moved to {}; {}",
                    path.display(),
                    to.display(),
                    consequence(&part)
                ));
            }
        }
        Ok(())
    }

    /// Updates the index, and remakes it if it cannot be read.
    fn index_again_if_damaged(&self) -> Result<()> {
        let readable =
            || self.weeks()?.into_iter().try_for_each(|week| read_done(&self.week(week)).map(drop));
        match readable().and_then(|()| self.index()) {
            Err(Error::Store { origin, .. }) => {
                self.found_damaged(format!("{origin} could not be read; the index was rebuilt"));
                self.forget_index()?;
                self.index()
            }
            done => done,
        }
    }

    /// Asks with the last run in the index, or from the runs alone if the index cannot be read.
    fn indexed<T>(&self, ask: impl Fn(&str) -> Result<T>) -> Result<T> {
        match ask(&self.through()) {
            Err(Error::Store { origin, .. }) => {
                self.found_damaged(format!("{origin} cannot be read; the next scan rebuilds it"));
                ask("")
            }
            done => done,
        }
    }

    /// Waits until no other process writes the log, and locks it while the file lives.
    ///
    /// It is a separate lock, so that a note need not wait for the end of a scan.
    ///
    /// # Errors
    /// If the folder cannot be created, or the file cannot be locked.
    pub(crate) fn lock_log(&self) -> Result<File> {
        fs::create_dir_all(&self.folder).map_err(file(&self.folder))?;
        let path = self.path("log.lock");
        let lock = File::create(&path).map_err(file(&path))?;
        lock.lock().map_err(file(&path))?;
        Ok(lock)
    }

    /// The names of all runs, in their order.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn run_names(&self) -> Result<Vec<String>> {
        names(&self.runs(), |name| name.bytes().all(|b| b.is_ascii_digit()))
    }

    /// The valid rows, by loop and time. If windows of a loop overlap, the window judged last is valid.
    ///
    /// # Errors
    /// If a file cannot be read or was changed.
    pub fn rows(&self) -> Result<Vec<WindowRow>> {
        self.rows_between(i64::MIN, i64::MAX)
    }

    /// The [valid rows](Self::rows) of windows that begin from `from` on and before `to`, s since 1970.
    ///
    /// # Errors
    /// As for [`Store::rows`].
    pub fn rows_between(&self, from: i64, to: i64) -> Result<Vec<WindowRow>> {
        // One that begins before may be replaced by one that begins within.
        let longest = 8 * DAY;
        let near = |row: &WindowRow| {
            (from.saturating_sub(longest)..to.saturating_add(longest)).contains(&row.window_start)
        };
        let all = self.indexed(|through| {
            let mut all = vec![];
            for week in self.weeks_in(through)? {
                let begin = (7 * week - 3) * DAY;
                if begin.saturating_add(16 * DAY) >= from && begin.saturating_sub(8 * DAY) <= to {
                    all.extend(read(&self.week(week))?);
                }
            }
            for run in self.runs_after(through)? {
                all.extend(self.rows_of(&run)?.into_iter().filter(near));
            }
            Ok(all)
        })?;
        let mut rows = those_that_count(all);
        rows.retain(|row| (from..to).contains(&row.window_start));
        Ok(rows)
    }

    /// When the last window begins, s since 1970; `None` without a window.
    ///
    /// # Errors
    /// As for [`Store::rows`].
    pub fn last(&self) -> Result<Option<i64>> {
        self.indexed(|through| {
            let mut last = None;
            if let Some(week) = self.weeks_in(through)?.into_iter().max() {
                last = read_done(&self.week(week))?.into_iter().map(|((_, begin), _)| begin).max();
            }
            for run in self.runs_after(through)? {
                last = last.max(self.rows_of(&run)?.iter().map(|row| row.window_start).max());
            }
            Ok(last)
        })
    }

    /// The weeks in which windows begin, in their order.
    ///
    /// # Errors
    /// As for [`Store::rows`].
    pub fn weeks_judged(&self) -> Result<Vec<Week>> {
        let mut weeks: BTreeSet<i64> = self.weeks()?.into_iter().collect();
        for run in self.runs_after(&self.through())? {
            weeks.extend(self.rows_of(&run)?.iter().map(week_of));
        }
        Ok(weeks.into_iter().map(|week| Week::of(7 * week - 3)).collect())
    }

    /// A text that changes whenever the rows change.
    ///
    /// # Errors
    /// If a folder cannot be read.
    pub fn stamp(&self) -> Result<String> {
        let through = self.through();
        let Some(last) = self.run_names()?.into_iter().max_by_key(|run| number(run)) else {
            return Ok(through);
        };
        let parts = names(&self.runs().join(&last), |name| is_part(name, WINDOWS))?.len();
        Ok(format!("{through}/{last}/{parts}"))
    }

    /// What was judged, by loop and begin.
    ///
    /// # Errors
    /// As for [`Store::rows`].
    pub fn done(&self) -> Result<HashMap<(String, i64), Done>> {
        self.indexed(|through| {
            if !self.runs_after(through)?.is_empty() {
                let keyed = |row: WindowRow| {
                    let of = Done::of(row.window_s, &row.settings_hash, &row.input_fingerprint);
                    ((row.name, row.window_start), of)
                };
                return Ok(self.rows()?.into_iter().map(keyed).collect());
            }
            let mut done = HashMap::new();
            for week in self.weeks_in(through)? {
                done.extend(read_done(&self.week(week))?);
            }
            Ok(done)
        })
    }

    /// Brings the index up to date with the runs. Only the holder of a run may.
    fn index(&self) -> Result<()> {
        let runs = self.runs_after(&self.through())?;
        let Some(last) = runs.last() else { return Ok(()) };
        let mut touched: BTreeSet<i64> = BTreeSet::new();
        for run in &runs {
            touched.extend(self.rows_of(run)?.iter().map(week_of));
        }
        let near: BTreeSet<i64> = touched.iter().flat_map(|week| week - 1..=week + 1).collect();
        let there: BTreeSet<i64> = self.weeks()?.into_iter().collect();
        for week in near.into_iter().filter(|week| touched.contains(week) || there.contains(week)) {
            let mut all = vec![];
            for week in (week - 1..=week + 1).filter(|week| there.contains(week)) {
                all.extend(read(&self.week(week))?);
            }
            for run in &runs {
                let rows = self.rows_of(run)?.into_iter();
                all.extend(rows.filter(|row| (week - 1..=week + 1).contains(&week_of(row))));
            }
            let mut rows = those_that_count(all);
            rows.retain(|row| week_of(row) == week);
            let path = self.week(week);
            write(&path, &rows)?;
        }
        write_whole(&self.path("index").join("through"), last.as_bytes())
    }

    /// Removes the index. The next run writes the index again.
    ///
    /// # Errors
    /// If the index cannot be removed.
    pub fn forget_index(&self) -> Result<()> {
        let path = self.path("index");
        match fs::remove_dir_all(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(file(&path)(e)),
            _ => Ok(()),
        }
    }

    /// The last run that is in the index; empty if there is no index.
    fn through(&self) -> String {
        fs::read_to_string(self.path("index").join("through")).unwrap_or_default()
    }

    fn runs_after(&self, through: &str) -> Result<Vec<String>> {
        let after = |run: &String| number(run) > number(through);
        let mut runs = self.run_names()?;
        runs.retain(after);
        runs.sort_by_key(|run| number(run));
        Ok(runs)
    }

    fn week(&self, week: i64) -> PathBuf {
        self.path("index").join(format!("{week:05}.parquet"))
    }

    /// The weeks in the index, counted from the week of 1970-01-01 on.
    fn weeks(&self) -> Result<Vec<i64>> {
        self.weeks_in(&self.through())
    }

    /// The weeks in an index that includes this run.
    fn weeks_in(&self, through: &str) -> Result<Vec<i64>> {
        // Without this file the index is incomplete, and the runs are read.
        if through.is_empty() {
            return Ok(vec![]);
        }
        let files = names(&self.path("index"), |name| name.ends_with(".parquet"))?;
        Ok(files.iter().filter_map(|name| name.split('.').next()?.parse().ok()).collect())
    }

    /// The rows of a run, as they were written.
    fn rows_of(&self, run: &str) -> Result<Vec<WindowRow>> {
        let mut rows = vec![];
        for path in self.whole_parts(run)? {
            rows.extend(read(&path)?);
        }
        Ok(rows)
    }

    /// The files of rows of a run, without those that are damaged.
    fn whole_parts(&self, run: &str) -> Result<Vec<PathBuf>> {
        let folder = self.runs().join(run);
        let mut parts = vec![];
        for part in names(&folder, |name| is_part(name, WINDOWS))? {
            let path = folder.join(part);
            match is_whole(&path)? {
                true => parts.push(path),
                false => self.left_out(&path),
            }
        }
        Ok(parts)
    }

    fn left_out(&self, path: &Path) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        self.found_damaged(format!(
            "{} is damaged, and is left out; {}",
            path.display(),
            consequence(&name)
        ));
    }

    /// The traces of windows that begin from `from` on and before `to`, s since 1970-01-01 UTC, by loop and time. If
    /// traces of a loop begin at the same time, only the trace written last is returned. Of files without such traces,
    /// only the footers are read.
    ///
    /// # Errors
    /// If a file cannot be read or was changed.
    pub fn traces(&self, from: i64, to: i64) -> Result<Vec<Trace>> {
        let mut newest: BTreeMap<(String, i64), Trace> = BTreeMap::new();
        let mut runs = self.run_names()?;
        runs.sort_by_key(|run| number(run));
        for run in runs {
            let folder = self.runs().join(&run);
            for part in names(&folder, |name| is_part(name, TRACES))? {
                let path = folder.join(part);
                // They are large, so only wanted files are checked.
                let within = |footer: &ParquetMetaData| {
                    let wanted = may_begin(footer, from, to);
                    let whole = wanted && is_whole(&path).unwrap_or(false);
                    if wanted && !whole {
                        self.left_out(&path);
                    }
                    whole
                };
                let read = tables(&path, None, within, |table| {
                    let found = Trace::rows(table)?.into_iter();
                    let wanted = found.filter(|trace| (from..to).contains(&trace.start));
                    newest.extend(wanted.map(|trace| ((trace.name.clone(), trace.start), trace)));
                    Ok(())
                });
                match read {
                    Err(Error::Store { .. }) => self.left_out(&path),
                    read => read?,
                }
            }
        }
        Ok(newest.into_values().collect())
    }

    fn pairs_path(&self, week: Week, made_of: &str) -> PathBuf {
        self.path("pairs").join(format!("{week}-{made_of}.parquet"))
    }

    /// The pairs of loops of a week that were found elsewhere from the input `made_of`; `None` if there are none.
    ///
    /// # Errors
    /// If a file cannot be read or was changed.
    pub fn pairs(&self, week: Week, made_of: impl FnOnce() -> String) -> Result<Option<Vec<Pair>>> {
        // Their expected input takes long to compute.
        if self.pairs_of(week)?.is_empty() {
            return Ok(None);
        }
        let path = self.pairs_path(week, &made_of());
        if !path.exists() {
            return Ok(None);
        }
        Ok(Some(read(&path)?))
    }

    /// The files of pairs of a week.
    fn pairs_of(&self, week: Week) -> Result<Vec<String>> {
        names(&self.path("pairs"), |name| name.starts_with(&format!("{week}-")))
    }

    /// Keeps the pairs of a week, and removes earlier ones.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn keep_pairs(&self, week: Week, made_of: &str, pairs: &[Pair]) -> Result<()> {
        let path = self.pairs_path(week, made_of);
        let before = self.pairs_of(week)?;
        write(&path, pairs)?;
        for other in before.iter().map(|name| self.path("pairs").join(name)) {
            if other != path {
                fs::remove_file(&other).map_err(file(&other))?;
            }
        }
        Ok(())
    }

    /// The number of incomplete runs since the last complete scan of all loops and days.
    ///
    /// # Errors
    /// If a folder cannot be read.
    pub fn cut_short(&self) -> Result<usize> {
        let whole = fs::read_to_string(self.path("whole")).unwrap_or_default();
        let mut cut = 0;
        for run in self.runs_after(&whole)? {
            cut += usize::from(self.manifest(&run)?.is_none());
        }
        Ok(cut)
    }

    /// The manifest of a run; `None` if the run was interrupted.
    ///
    /// # Errors
    /// If the manifest cannot be read.
    pub fn manifest(&self, run: &str) -> Result<Option<String>> {
        let path = self.runs().join(run).join("manifest.json");
        match fs::read_to_string(&path) {
            Ok(text) => Ok(Some(text)),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(file(&path)(e)),
        }
    }
}

impl Run {
    /// Writes rows as the next part.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&mut self, rows: &[WindowRow]) -> Result<()> {
        self.parts += 1;
        self.write_part(WINDOWS, self.parts, rows)
    }

    /// Writes the traces of the rows that are written next. Traces without rows have no effect. Rows mark windows as
    /// done.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_traces(&mut self, traces: &[Trace]) -> Result<()> {
        self.write_part(TRACES, self.parts + 1, traces)
    }

    fn write_part<R: Row>(&self, kind: &str, number: usize, rows: &[R]) -> Result<()> {
        let bytes = parquet_file::bytes(rows).map_err(|e| store(&self.folder, e))?;
        let name =
            format!("{kind}{number:04}-{}.parquet", beginning(Sha256::digest(&bytes).as_slice()));
        write_whole(&self.folder.join(name), &bytes)
    }

    /// How many parts were written.
    pub fn parts(&self) -> usize {
        self.parts
    }

    /// Records that this was a complete scan of all loops and days. Earlier interrupted runs then need not be finished.
    ///
    /// # Errors
    /// If the run cannot be written.
    pub fn mark_whole(&self) -> Result<()> {
        let last = self.store.run_names()?.into_iter().max_by_key(|run| number(run));
        last.map_or(Ok(()), |last| write_whole(&self.store.path("whole"), last.as_bytes()))
    }

    /// Ends the run with its manifest, and updates the index. A run without a part leaves nothing behind.
    ///
    /// # Errors
    /// If the manifest cannot be written.
    pub fn end(self, manifest: &str) -> Result<()> {
        match self.parts {
            0 => Ok(()),
            _ => {
                write_whole(&self.folder.join("manifest.json"), manifest.as_bytes())?;
                self.store.index()
            }
        }
    }
}

/// Writes a file whole or not at all, and makes its folder.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(file(folder))?;
    }
    stiction_io::whole::write(path, bytes).map_err(file(path))
}

const DAY: i64 = 86_400;

/// Prefix of the names of files of rows.
const WINDOWS: &str = "windows-";
/// Prefix of the names of files of traces.
const TRACES: &str = "traces-";

fn is_part(name: &str, kind: &str) -> bool {
    name.starts_with(kind) && name.ends_with(".parquet")
}

/// The consequence of a damaged part.
fn consequence(name: &str) -> &'static str {
    match is_part(name, TRACES) {
        true => "groups of loops lack the windows of this file until `scan --again`",
        false => "the next scan judges again the windows that only this file had",
    }
}

/// Whether a file of a run is unchanged, by the checksum in its name. A file of an earlier version only needs to be readable.
fn is_whole(path: &Path) -> Result<bool> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut input = File::open(path).map_err(file(path))?;
    match stem.splitn(3, '-').nth(2) {
        Some(sum) => {
            let mut hasher = Sha256::new();
            std::io::copy(&mut input, &mut hasher).map_err(file(path))?;
            Ok(beginning(hasher.finalize().as_slice()) == sum)
        }
        None => Ok(parquet_file::read(input, None, |_| true, |_| Ok(())).is_ok()),
    }
}

/// Whether a file is complete. Of a file that has not changed since `seen`, only the end is read, because all runs
/// together may be large.
fn looks_whole(path: &Path, seen: Option<SystemTime>) -> Result<bool> {
    let there = fs::metadata(path).map_err(file(path))?;
    match there.modified() {
        Ok(changed) if seen.is_some_and(|seen| changed < seen) => {
            let mut end = [0; 8];
            let mut input = File::open(path).map_err(file(path))?;
            let read = input.seek(SeekFrom::End(-8)).and_then(|_| input.read_exact(&mut end));
            let [a, b, c, d, magic @ ..] = end;
            let footer = u64::from(u32::from_le_bytes([a, b, c, d]));
            Ok(read.is_ok() && &magic == b"PAR1" && footer + 12 <= there.len())
        }
        _ => is_whole(path),
    }
}

/// The beginning of a checksum, in hexadecimal.
fn beginning(sum: &[u8]) -> String {
    sum.iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

/// The number of a run; 0 if it is not a run.
fn number(run: &str) -> u32 {
    run.trim().parse().unwrap_or(0)
}

/// The week in which a window begins, from Monday. Windows begin near midnight of some clock.
fn week_of(row: &WindowRow) -> i64 {
    let day = row.window_start.saturating_add(DAY / 2).div_euclid(DAY);
    (day + 3).div_euclid(7)
}

/// The valid rows among rows in the order in which they were judged, by loop and time.
fn those_that_count(mut all: Vec<WindowRow>) -> Vec<WindowRow> {
    let mut newest: Vec<WindowRow> = vec![];
    all.reverse();
    // Stable: within a loop the newest stay first.
    all.sort_by(|a, b| a.name.cmp(&b.name));
    let mut begin = 0;
    for row in all {
        if newest.get(begin).is_some_and(|first| first.name != row.name) {
            begin = newest.len();
        }
        let (from, to) = (row.window_start, row.window_start + row.window_s);
        let overlaps = |other: &WindowRow| {
            other.window_start < to && from < other.window_start + other.window_s
        };
        if !newest[begin..].iter().any(overlaps) {
            newest.push(row);
        }
    }
    newest.sort_by(|a, b| (&a.name, a.window_start).cmp(&(&b.name, b.window_start)));
    newest
}

/// The entries of a folder with wanted names, in order; none if the folder does not exist.
fn names(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<String>> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(vec![]),
        Err(e) => return Err(file(folder)(e)),
    };
    let mut names = vec![];
    for entry in entries {
        let name = entry.map_err(file(folder))?.file_name().to_string_lossy().into_owned();
        if wanted(&name) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

fn write<R: Row>(path: &Path, rows: &[R]) -> Result<()> {
    write_whole(path, &parquet_file::bytes(rows).map_err(|e| store(path, e))?)
}

/// Passes the tables of a file with a wanted footer to `take`, with all columns or these.
fn tables(
    path: &Path,
    columns: Option<&[&str]>,
    wanted: impl FnOnce(&ParquetMetaData) -> bool,
    take: impl FnMut(&Table) -> std::result::Result<(), String>,
) -> Result<()> {
    let input = File::open(path).map_err(file(path))?;
    parquet_file::read(input, columns, wanted, take)
        .map_err(|what| store(path, format!("{what}; remove the file, and scan again")))
}

/// Whether a file of traces may hold one that begins from `from` on and before `to`.
fn may_begin(footer: &ParquetMetaData, from: i64, to: i64) -> bool {
    footer.row_groups().iter().any(|group| {
        let starts = group.columns().iter().find(|column| column.column_path().string() == "start");
        match starts.and_then(|column| column.statistics()) {
            Some(Statistics::Int64(of)) => {
                of.min_opt().is_none_or(|min| *min < to)
                    && of.max_opt().is_none_or(|max| *max >= from)
            }
            _ => true,
        }
    })
}

fn read<R: Row>(path: &Path) -> Result<Vec<R>> {
    let mut rows = vec![];
    let take = |table: &Table| {
        rows.extend(R::rows(table)?);
        Ok(())
    };
    tables(path, None, |_| true, take)?;
    Ok(rows)
}

fn read_done(path: &Path) -> Result<Vec<((String, i64), Done)>> {
    let columns = ["loop", "window_start", "window_s", "settings_hash", "input_fingerprint"];
    let mut done = vec![];
    let take = |table: &Table| {
        let [names, settings, inputs] =
            ["loop", "settings_hash", "input_fingerprint"].map(|name| table.column::<String>(name));
        let [starts, seconds] = ["window_start", "window_s"].map(|name| table.column::<i64>(name));
        let made_of = seconds?.into_iter().zip(settings?).zip(inputs?);
        let made_of =
            made_of.map(|((seconds, settings), input)| Done::of(seconds, &settings, &input));
        done.extend(names?.into_iter().zip(starts?).zip(made_of));
        Ok(())
    };
    tables(path, Some(&columns), |_| true, take)?;
    Ok(done)
}
