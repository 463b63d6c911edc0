//! The open files, and which recordings are in memory.

use super::Stretch;
use super::mapping::{self, Mapping};
use super::reports::Reports;
use crate::calls::{Answer, Wrong};
use crate::lab::locked;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{HashMap, HashSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;
use stiction_diagnose::recording::{Channel, Recording};
use stiction_io::reading::Format;
use stiction_io::{ReadOptions, Reading, Remedy, Wording, bytes, reading, whole};
use stiction_report::report::Folds;

/// The largest file that is read, bytes.
const FILE: u64 = 1 << 30;
/// Number of bytes of all dropped files together.
const DROPPED: usize = 1 << 29;
/// Dropped files that are open at a time.
const DROPS: usize = 200;
/// Number of bytes of recordings in memory. Beyond this limit the least recently used ones are dropped, and read again
/// when needed.
const KEPT: usize = 1 << 30;
/// Number of files of all open folders; more are left out.
const FILES: usize = 5_000;
/// Levels of folders that are searched.
const DEPTH: usize = 8;
/// Reports of stretches in memory, for further requests.
const FOLDS: usize = 3;

/// The open files.
#[derive(Debug, Default)]
pub(crate) struct Room {
    /// The files and folders of the command.
    roots: Vec<PathBuf>,
    /// The options for all files without a mapping of their own.
    options: ReadOptions,
    state: Mutex<State>,
    folds: Mutex<VecDeque<(Of, Arc<Folds>)>>,
    /// Reports that were opened as pages.
    pub(super) reports: Reports,
}

/// The subject of a report: a stretch, the SHA-256 of its file, and the bytes of the overrides beside it.
pub(super) type Of = (Stretch, String, Vec<u8>);

#[derive(Debug, Default)]
struct State {
    files: Vec<Arc<File>>,
    /// How many files were dropped since the beginning.
    drops: usize,
    /// Counts requests.
    asked: u64,
}

/// A file that is open.
#[derive(Debug)]
pub(crate) struct File {
    /// Identifier.
    pub id: String,
    /// Name in messages, and the name of a loop without one.
    origin: String,
    place: Place,
    held: Mutex<Held>,
    /// How it is read. Separate from the recordings, so that it is available while they are read.
    own: Mutex<Option<Own>>,
}

#[derive(Debug)]
enum Place {
    Path(PathBuf),
    Dropped(Vec<u8>),
}

/// A file as it was read.
#[derive(Debug, Default)]
struct Held {
    reading: Option<Arc<Reading>>,
    /// Approximate memory, bytes.
    bytes: usize,
    stamp: Option<Stamp>,
    /// Why it could not be read.
    failure: Option<String>,
    /// When it was last used.
    asked: u64,
}

/// What changes when a file changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    bytes: u64,
    changed: Option<SystemTime>,
}

/// The corrections to a file by hand.
#[derive(Debug, Clone, Default)]
pub(crate) struct Own {
    pub mapping: Mapping,
    /// The corrections as options of the reader; `None` without corrections.
    options: Option<ReadOptions>,
    /// Whether it equals the mapping file; a missing file is empty.
    pub is_saved: bool,
    /// Why the page cannot change the corrections.
    pub fixed: Option<String>,
}

impl Own {
    /// Whether there are no corrections.
    pub fn is_empty(&self) -> bool {
        self.options.is_none()
    }

    /// The text of the mapping file; empty without corrections.
    pub fn text(&self) -> String {
        if self.is_empty() { String::new() } else { self.mapping.text() }
    }
}

/// An entry in the list of open files.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Entry {
    /// Identifier.
    id: String,
    /// Name.
    name: String,
    /// Folder; empty for a dropped file.
    folder: String,
    /// Whether it was dropped on the page.
    dropped: bool,
    /// Loops; null before it is opened.
    loops: Option<Vec<String>>,
    /// Why it could not be read.
    failure: Option<String>,
}

/// Remedies as the page words them.
const ON_THE_PAGE: Wording = Wording(|remedy| match remedy {
    Remedy::Map { role, column: Some(column) } => format!("role {role} for \"{column}\", below"),
    Remedy::Map { role, column: None } => format!("role {role} for its column, below"),
    other => format!("{} {}", other.option().replace('_', " "), other.value()),
});

impl File {
    fn new(id: String, origin: String, place: Place) -> Self {
        Self { id, origin, place, held: Mutex::default(), own: Mutex::default() }
    }

    /// Path of the file; `None` if it was dropped.
    pub fn path(&self) -> Option<&Path> {
        match &self.place {
            Place::Path(path) => Some(path),
            Place::Dropped(_) => None,
        }
    }

    /// The path of its own mapping file, existing or not; `None` if it was dropped.
    pub fn mapping_path(&self) -> Option<PathBuf> {
        self.path().map(ReadOptions::mapping_path)
    }

    /// Entry in the list.
    pub fn entry(&self) -> Entry {
        let (name, folder) = match self.path() {
            Some(path) => (
                path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                path.parent().map(|folder| folder.display().to_string()).unwrap_or_default(),
            ),
            None => (self.origin.clone(), String::new()),
        };
        // Does not wait for a file that is being read.
        let held = self.held.try_lock().ok();
        let (loops, failure) = match held.as_deref() {
            Some(held) => {
                let names = |reading: &Arc<Reading>| {
                    reading.recordings.iter().map(|each| each.name.clone()).collect()
                };
                (held.reading.as_ref().map(names), held.failure.clone())
            }
            None => (None, None),
        };
        let dropped = self.path().is_none();
        Entry { id: self.id.clone(), name, folder, dropped, loops, failure }
    }

    /// The manual corrections; initially those of the mapping file.
    pub fn own(&self) -> Own {
        locked(&self.own).get_or_insert_with(|| self.kept()).clone()
    }

    /// The content of its mapping file.
    fn kept(&self) -> Own {
        let Some(path) = self.mapping_path().filter(|path| path.exists()) else {
            return Own { is_saved: true, ..Own::default() };
        };
        let shown = path.display().to_string();
        let wrong = |why: String| Own { fixed: Some(why), ..Own::default() };
        let text = match bytes::read(&path).and_then(|read| bytes::text(read, &shown)) {
            Ok(text) => text,
            Err(error) => {
                return wrong(format!("{error}; the lab now recognises the columns automatically"));
            }
        };
        match (ReadOptions::parse(&text, &shown), mapping::of_text(&text)) {
            (Ok(options), Some(mapping)) => {
                let options = Some(options).filter(|_| !mapping.is_empty());
                Own { mapping, options, is_saved: true, fixed: None }
            }
            (Ok(options), None) => Own {
                options: Some(options),
                is_saved: true,
                fixed: Some(format!(
                    "{shown} has entries that the lab cannot change; edit it in a text editor"
                )),
                ..Own::default()
            },
            (Err(error), _) => wrong(format!(
                "{error}; until the file is corrected, the lab recognises the columns automatically"
            )),
        }
    }

    fn stamp(&self) -> Answer<Option<Stamp>> {
        let Some(path) = self.path() else { return Ok(None) };
        let about = std::fs::metadata(path)
            .map_err(|error| Wrong::gone(format!("{}: {error}", path.display())))?;
        if about.len() > FILE {
            return Err(Wrong::request(format!(
                "{} is larger than {} MiB; open a part of it",
                path.display(),
                FILE >> 20
            )));
        }
        Ok(Some(Stamp { bytes: about.len(), changed: about.modified().ok() }))
    }

    /// The names of its columns.
    pub fn columns(&self) -> Answer<Vec<String>> {
        Ok(match &self.place {
            Place::Path(path) => reading::columns(&bytes::read(path)?, &self.origin)?,
            Place::Dropped(bytes) => reading::columns(bytes, &self.origin)?,
        })
    }

    fn parse(&self, options: &ReadOptions) -> Answer<Reading> {
        let options = ReadOptions { wording: ON_THE_PAGE, ..options.clone() };
        Ok(match &self.place {
            Place::Path(path) => reading::parse(&bytes::read(path)?, &self.origin, &options)?,
            Place::Dropped(bytes) => reading::parse(bytes, &self.origin, &options)?,
        })
    }
}

/// Approximate memory of the recordings of a file, bytes.
fn weight(reading: &Reading) -> usize {
    let of = |channel: &Channel| channel.values.len() * 17;
    let each = |recording: &Recording| {
        let others = [&recording.pv, &recording.sp, &recording.vp];
        of(&recording.op) + others.into_iter().flatten().map(of).sum::<usize>()
    };
    4096 + reading.recordings.iter().map(each).sum::<usize>()
}

impl Room {
    /// A room with these files and folders.
    pub fn new(roots: &[PathBuf], options: &ReadOptions) -> Self {
        Self { roots: roots.to_vec(), options: options.clone(), ..Self::default() }
    }

    /// All open files. Folders are searched again, without following links.
    pub fn files(&self) -> Vec<Arc<File>> {
        let mut paths = vec![];
        for root in &self.roots {
            if root.is_dir() { walk(root, DEPTH, &mut paths) } else { paths.push(root.clone()) }
        }
        paths.truncate(FILES);
        let mut state = locked(&self.state);
        let known: HashMap<&str, &Arc<File>> =
            state.files.iter().map(|file| (&*file.id, file)).collect();
        let mut seen = HashSet::new();
        let mut files: Vec<Arc<File>> = vec![];
        for path in paths {
            let id = path.display().to_string();
            if !seen.insert(id.clone()) {
                continue;
            }
            files.push(match known.get(&*id) {
                Some(file) => Arc::clone(file),
                None => Arc::new(File::new(id.clone(), id, Place::Path(path))),
            });
        }
        files.extend(state.files.iter().filter(|file| file.path().is_none()).cloned());
        state.files.clone_from(&files);
        files
    }

    /// The file of that name.
    pub fn file(&self, id: &str) -> Answer<Arc<File>> {
        let find = || locked(&self.state).files.iter().find(|file| file.id == id).cloned();
        let found = find().or_else(|| {
            self.files();
            find()
        });
        found.ok_or_else(|| {
            Wrong::gone(format!(
                "\"{id}\" is not open in this lab; drop the file here, or name the file or its folder in the command `stiction lab`"
            ))
        })
    }

    /// Opens a dropped file.
    pub fn take(&self, name: &str, bytes: Vec<u8>) -> Answer<Arc<File>> {
        let mut state = locked(&self.state);
        let dropped = |file: &&Arc<File>| file.path().is_none();
        let held = |file: &Arc<File>| match &file.place {
            Place::Dropped(bytes) => bytes.len(),
            Place::Path(_) => 0,
        };
        let sum: usize = state.files.iter().map(held).sum();
        if sum + bytes.len() > DROPPED || state.files.iter().filter(dropped).count() >= DROPS {
            return Err(Wrong::request(format!(
                "the lab keeps at most {DROPS} dropped files, of {} MiB in all; close some, or name the file in the command \
                 `stiction lab`",
                DROPPED >> 20
            )));
        }
        state.drops += 1;
        let name = name.rsplit(['/', '\\']).next().unwrap_or_default();
        let name: String = name.chars().filter(|c| !c.is_control()).take(200).collect();
        let name = if name.is_empty() { "dropped".to_owned() } else { name };
        let id = format!("dropped-{}:{name}", state.drops);
        let file = Arc::new(File::new(id, name, Place::Dropped(bytes)));
        state.files.push(Arc::clone(&file));
        Ok(file)
    }

    /// Closes a dropped file.
    pub fn close(&self, id: &str) -> Answer<()> {
        let mut state = locked(&self.state);
        let before = state.files.len();
        state.files.retain(|file| file.id != id || file.path().is_some());
        match state.files.len() < before {
            true => Ok(()),
            false => Err(Wrong::gone(format!("\"{id}\" was not dropped here, or is closed"))),
        }
    }

    /// The recordings of a file, read if it is new or has changed.
    pub fn read(&self, file: &Arc<File>) -> Answer<Arc<Reading>> {
        let asked = self.now();
        let own = file.own();
        let mut held = locked(&file.held);
        held.asked = asked;
        let stamp = file.stamp()?;
        if let Some(reading) = held.reading.as_ref().filter(|_| held.stamp == stamp) {
            return Ok(Arc::clone(reading));
        }
        let read = file.parse(own.options.as_ref().unwrap_or(&self.options));
        held.reading = None;
        held.stamp = stamp;
        held.failure = read.as_ref().err().map(|wrong| wrong.error.clone());
        let reading = self.hold(&mut held, read?);
        drop(held);
        self.make_room(file);
        Ok(reading)
    }

    /// Reads a file with these corrections, and stores the corrections. If it cannot be read with them, nothing
    /// changes.
    pub fn say(&self, file: &Arc<File>, mapping: Mapping, save: bool) -> Answer<Arc<Reading>> {
        let mapping = mapping.tidy();
        let options = match mapping.is_empty() {
            true => None,
            false => Some(mapping.options()?),
        };
        let before = file.own();
        if save && let Some(why) = &before.fixed {
            return Err(Wrong::request(why));
        }
        let asked = self.now();
        let mut held = locked(&file.held);
        let stamp = file.stamp()?;
        let read = file.parse(options.as_ref().unwrap_or(&self.options))?;
        let kept = file.kept();
        let is_saved = kept.is_saved && kept.fixed.is_none() && kept.mapping == mapping;
        let mut own = Own { mapping, options, is_saved, fixed: before.fixed };
        if save {
            let path = file.mapping_path().ok_or_else(|| {
                Wrong::request(
                    "a dropped file has no folder for a mapping file; save the mapping as a download",
                )
            })?;
            write(&path, &own)?;
            own.is_saved = true;
        }
        *locked(&file.own) = Some(own);
        (held.asked, held.stamp, held.failure) = (asked, stamp, None);
        let reading = self.hold(&mut held, read);
        drop(held);
        locked(&self.folds).retain(|((stretch, ..), _)| stretch.file != file.id);
        self.make_room(file);
        Ok(reading)
    }

    fn now(&self) -> u64 {
        let mut state = locked(&self.state);
        state.asked += 1;
        state.asked
    }

    fn hold(&self, held: &mut Held, reading: Reading) -> Arc<Reading> {
        let reading = Arc::new(reading);
        held.bytes = weight(&reading);
        held.reading = Some(Arc::clone(&reading));
        reading
    }

    /// Drops the least recently used recordings, except those of one file, until the rest fits.
    fn make_room(&self, but: &Arc<File>) {
        let files = locked(&self.state).files.clone();
        let own = locked(&but.held).bytes;
        // What is in use stays.
        let mut all: Vec<_> = files
            .iter()
            .filter(|file| !Arc::ptr_eq(file, but))
            .filter_map(|file| file.held.try_lock().ok())
            .filter(|held| held.reading.is_some())
            .collect();
        all.sort_by_key(|held| held.asked);
        let mut sum = own + all.iter().map(|held| held.bytes).sum::<usize>();
        for held in &mut all {
            if sum <= KEPT {
                break;
            }
            sum -= held.bytes;
            (held.reading, held.bytes) = (None, 0);
        }
    }

    /// The report of a stretch, if it is still in memory.
    pub fn folds(&self, of: &Of) -> Option<Arc<Folds>> {
        let kept = locked(&self.folds);
        kept.iter().find(|(known, _)| known == of).map(|(_, folds)| Arc::clone(folds))
    }

    /// Keeps the report of a stretch.
    pub fn keep_folds(&self, of: Of, folds: Arc<Folds>) {
        let mut kept = locked(&self.folds);
        kept.push_back((of, folds));
        while kept.len() > FOLDS {
            kept.pop_front();
        }
    }
}

/// Writes the mapping file, or removes it if there are no corrections.
fn write(path: &Path, own: &Own) -> Answer<()> {
    let about = std::fs::symlink_metadata(path).ok();
    if about.as_ref().is_some_and(|about| !about.is_file()) {
        return Err(Wrong::request(format!(
            "{} is not a regular file; move it away",
            path.display()
        )));
    }
    let failed = |error| Wrong::own(format!("{}: {error}", path.display()));
    match own.is_empty() {
        true if about.is_some() => std::fs::remove_file(path).map_err(failed),
        true => Ok(()),
        false => whole::write(path, own.text().as_bytes()).map_err(failed),
    }
}

/// The recordings in a folder and its subfolders, in the order of their names.
fn walk(folder: &Path, depth: usize, to: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut entries: Vec<_> = entries.flatten().collect();
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        if to.len() >= FILES {
            return;
        }
        let path = entry.path();
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        match entry.file_type() {
            Ok(kind) if kind.is_dir() && depth > 0 && !hidden => walk(&path, depth - 1, to),
            Ok(kind) if kind.is_file() && !hidden && Format::is_named_like_one(&path) => {
                to.push(path)
            }
            _ => {}
        }
    }
}
