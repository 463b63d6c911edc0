//! What was judged, kept beside the plant's file.
//!
//! ```text
//! .stiction/lock                               held by the one who writes
//! .stiction/log.lock                           held by the one who enters something in log.toml
//! .stiction/inputs.json                        what was seen of the data; made anew where it is lost
//! .stiction/runs/0001/windows-0001.parquet     rows, written as they end
//! .stiction/runs/0001/manifest.json            how the run ended; none if it was cut short
//! ```
//!
//! Every file is written beside its place and renamed into it, so it is there whole or not at all. Rows count
//! whether or not their run came to its end; which windows are done is asked of them alone.

use crate::error::{Error, Result, file, store};
use crate::table::parquet;
use crate::window::WindowRow;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// The store of a plant.
#[derive(Debug, Clone)]
pub struct Store {
    folder: PathBuf,
}

/// A run that is being written; while it lives nobody else writes to the store.
#[derive(Debug)]
pub struct Run {
    /// Its name: a number, one above the last.
    pub name: String,
    folder: PathBuf,
    parts: usize,
    _lock: File,
}

impl Store {
    /// The store of the plant in `folder`, which may not be there yet.
    pub fn of(folder: &Path) -> Self {
        Self { folder: folder.join(".stiction") }
    }

    /// Its file of that name.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn runs(&self) -> PathBuf {
        self.folder.join("runs")
    }

    /// Begins a run.
    ///
    /// # Errors
    /// If somebody else writes, or the folder cannot be made.
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
        let last = self.run_names()?.iter().filter_map(|name| name.parse::<u32>().ok()).max();
        let name = format!("{:04}", last.unwrap_or(0) + 1);
        let folder = self.runs().join(&name);
        Ok(Run { name, folder, parts: 0, _lock: lock })
    }

    /// Waits until nobody else changes what people say of the plant, and keeps others from it while the file lives.
    ///
    /// A lock of its own: a note need not wait for the end of a scan.
    ///
    /// # Errors
    /// If the folder cannot be made, or the file not be locked.
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

    /// All rows that were ever written, in the order of runs and parts, each with the name of its run.
    ///
    /// # Errors
    /// If a file cannot be read or is not what the store wrote.
    pub fn all_rows(&self) -> Result<Vec<(String, WindowRow)>> {
        let mut rows = vec![];
        for run in self.run_names()? {
            let folder = self.runs().join(&run);
            for part in
                names(&folder, |name| name.starts_with("windows-") && name.ends_with(".parquet"))?
            {
                rows.extend(read(&folder.join(part))?.into_iter().map(|row| (run.clone(), row)));
            }
        }
        Ok(rows)
    }

    /// The rows that count, by loop and time: of windows of a loop that overlap, the one judged last.
    ///
    /// # Errors
    /// As for [`Store::all_rows`].
    pub fn rows(&self) -> Result<Vec<WindowRow>> {
        let mut newest: Vec<WindowRow> = vec![];
        let mut all: Vec<WindowRow> =
            self.all_rows()?.into_iter().map(|(_, row)| row).rev().collect();
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
        Ok(newest)
    }

    /// The manifest of a run, as it was written; `None` if the run did not come to its end.
    ///
    /// # Errors
    /// If it cannot be read.
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
        let path = self.folder.join(format!("windows-{:04}.parquet", self.parts));
        let bytes = bytes(rows).map_err(|e| store(&path, e))?;
        write_whole(&path, &bytes)
    }

    /// How many parts were written.
    pub fn parts(&self) -> usize {
        self.parts
    }

    /// Ends the run with its manifest; one without a part leaves nothing behind.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn end(self, manifest: &str) -> Result<()> {
        match self.parts {
            0 => Ok(()),
            _ => write_whole(&self.folder.join("manifest.json"), manifest.as_bytes()),
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

/// The entries of a folder whose names are wanted, in order; none of a folder that is not there.
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

fn bytes(rows: &[WindowRow]) -> parquet::errors::Result<Vec<u8>> {
    parquet(&WindowRow::batch(rows)?)
}

fn read(path: &Path) -> Result<Vec<WindowRow>> {
    let damaged = |what: String| store(path, format!("{what}; remove the file, and scan again"));
    let file = File::open(path).map_err(file(path))?;
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).and_then(|builder| builder.build());
    let mut rows = vec![];
    for batch in reader.map_err(|e| damaged(e.to_string()))? {
        let batch = batch.map_err(|e| damaged(e.to_string()))?;
        rows.extend(WindowRow::rows(&batch).map_err(damaged)?);
    }
    Ok(rows)
}
