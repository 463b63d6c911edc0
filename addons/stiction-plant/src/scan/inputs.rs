//! The files of a plant, with their loops and days.

use crate::day;
use crate::error::{Result, store};
use crate::plant_file::{self, Plant};
use crate::propose::quoted;
use crate::store::{STORE, Store, write_whole};
use crate::unknown::{Kind, Unknown};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::UNIX_EPOCH;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::spoken::counted;
use stiction_io::parted::{PartedFile, Stamp};
use stiction_io::reading::{self, Format};
use stiction_io::role::Role;
use stiction_io::timestamp::Zone;

/// A file or loop that could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Problem {
    /// The file; `None` if the problem concerns all files.
    pub file: Option<String>,
    /// The loop; `None` if the problem concerns the whole file.
    #[serde(rename = "loop")]
    pub name: Option<String>,
    /// The fault and the remedy.
    pub message: String,
}

impl Problem {
    /// The problem as a sentence.
    pub fn words(&self) -> String {
        // The message about a whole file names it.
        match (&self.file, &self.name) {
            (Some(file), Some(name)) => format!("{file}, loop {name}: {}", self.message),
            (None, Some(name)) => format!("loop {name}: {}", self.message),
            _ => self.message.clone(),
        }
    }
}

/// A file of the plant.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Input {
    /// Size in bytes, and the time of its last change, ns since 1970. A file with the same two is not read again.
    pub stamp: (u64, u128),
    /// SHA-256 of its bytes, or of the part that was examined.
    pub sha256: String,
    /// Loops.
    pub loops: BTreeMap<String, LoopIn>,
    /// Problems.
    pub problems: Vec<Problem>,
    /// The reason why it is no recording, if it is a table without an OP, such as a list of tags.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_recording: Option<String>,
    /// Tags of loops without an OP in the file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without_op: Vec<String>,
}

/// A loop in a file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LoopIn {
    /// The days on which it has samples of the OP: of the plant's calendar, since 1970-01-01.
    pub days: Vec<i64>,
    /// SHA-256 of the loop's part of the file, if the loop has a part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// Why the loop has no PV in the file, if so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_pv: Option<String>,
}

impl Input {
    /// SHA-256 of the part that holds a loop.
    pub fn fingerprint(&self, name: &str) -> &str {
        let own = self.loops.get(name).and_then(|own| own.sha256.as_deref());
        own.unwrap_or(&self.sha256)
    }
}

/// The files of a plant by their paths relative to its folder.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Inputs {
    /// The settings with which they were read.
    reading_hash: String,
    /// The files.
    pub files: BTreeMap<String, Input>,
    /// Places that match a pattern and hold no file that can be read.
    #[serde(default, skip_serializing_if = "Places::is_empty")]
    places: Places,
    /// When this was written, ns since 1970 by the clock of its disk. A file changed at this time may have changed again unnoticed.
    #[serde(skip)]
    written: u128,
}

/// Places in the plant's folder that hold no readable file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
struct Places {
    /// Folders that cannot be listed.
    problems: Vec<Problem>,
    /// Folders that are named like recordings, a sentence each.
    folders: Vec<String>,
}

impl Places {
    fn is_empty(&self) -> bool {
        self.problems.is_empty() && self.folders.is_empty()
    }
}

/// Data files that differ from the last scan.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, schemars::JsonSchema)]
pub struct Changes {
    /// Files that no scan has read.
    pub new: Vec<String>,
    /// Files with different content. A different size or date counts as different content until a scan reads the file.
    pub changed: Vec<String>,
    /// Files that no longer exist. The verdicts from these files stay.
    pub missing: Vec<String>,
}

impl Changes {
    /// Each kind in a sentence, if there are any.
    pub fn words(&self) -> Vec<String> {
        let kinds = [
            (&self.new, "new", "the next scan judges"),
            (&self.changed, "changed", "the next scan judges"),
            (&self.missing, "missing", "the plant keeps the results of"),
        ];
        let said = |(files, what, then): (&Vec<String>, &str, &str)| {
            let such = if files.len() > 1 { "such as " } else { "" };
            let first = files.first()?;
            let (count, their) =
                (counted(files.len(), "data file"), if files.len() > 1 { "their" } else { "its" });
            Some(format!(
                "{count} {what} since the last scan, {such}{first}; {then} {their} windows"
            ))
        };
        kinds.into_iter().filter_map(said).collect()
    }
}

const NAME: &str = "inputs.json";
/// The form of the list. Files are examined again if their form is different.
const FORM: &str = "2-";

impl Inputs {
    /// The files according to the store; empty if the list was lost or the settings have changed.
    pub fn known(store: &Store, plant: &Plant) -> Self {
        let reading_hash = format!("{FORM}{}", plant.reading_hash());
        let path = store.path(NAME);
        let text = std::fs::read(&path).unwrap_or_default();
        let known: Option<Self> = serde_json::from_slice(&text).ok();
        let written = stamp(&path).map_or(0, |(_, changed)| changed);
        known.filter(|known| known.reading_hash == reading_hash).map_or_else(
            || Self { reading_hash, written, ..Self::default() },
            |known| Self { written, ..known },
        )
    }

    /// Keeps it in the store.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn keep(&self, to: &Store) -> Result<()> {
        let path = to.path(NAME);
        let text = serde_json::to_vec(self).map_err(|e| store(&path, e))?;
        write_whole(&path, &text)
    }

    /// Updates the list from the files in `folder`: it removes missing files, and examines new and changed ones,
    /// several at a time. `seen` is called for each file. Returns the differences; empty without a list.
    pub fn update(&mut self, folder: &Path, plant: &Plant, mut seen: impl FnMut(&str)) -> Changes {
        let mut files = BTreeMap::new();
        let (paths, places) = listed(folder, plant);
        for some in paths.chunks(rayon::current_num_threads().max(1)) {
            let known = |path: &String| self.files.get(path);
            let looked: Vec<Input> = some
                .par_iter()
                .map(|path| self.current(folder, path, known(path), plant))
                .collect();
            for (path, input) in some.iter().zip(looked) {
                seen(path);
                files.insert(path.clone(), input);
            }
        }
        let changes = self.changes_to(&files, |known, now| known.sha256 != now.sha256);
        (self.files, self.places) = (files, places);
        changes
    }

    /// How the files in `folder` differ from this list, by size and date.
    pub fn changes(&self, folder: &Path, plant: &Plant) -> Changes {
        let (paths, _) = listed(folder, plant);
        let now = paths.into_iter().map(|path| {
            let stamp = stamp(&folder.join(&path)).unwrap_or_default();
            (path, Input { stamp, ..Input::default() })
        });
        self.changes_to(&now.collect(), |known, now| known.stamp != now.stamp)
    }

    /// Returns how the files in `folder` differ from this list, and removes missing files from the list.
    pub fn compared(&mut self, folder: &Path, plant: &Plant) -> Changes {
        let changes = self.changes(folder, plant);
        self.files.retain(|path, _| !changes.missing.contains(path));
        changes
    }

    fn changes_to(
        &self,
        now: &BTreeMap<String, Input>,
        differ: impl Fn(&Input, &Input) -> bool,
    ) -> Changes {
        if self.files.is_empty() {
            return Changes::default();
        }
        let mut changes = Changes::default();
        for (path, input) in now {
            match self.files.get(path) {
                None => changes.new.push(path.clone()),
                Some(known) if differ(known, input) => changes.changed.push(path.clone()),
                Some(_) => {}
            }
        }
        changes.missing =
            self.files.keys().filter(|path| !now.contains_key(*path)).cloned().collect();
        changes
    }

    /// The current content of a file.
    fn current(&self, folder: &Path, path: &str, known: Option<&Input>, plant: &Plant) -> Input {
        let whole = folder.join(path);
        let refused = |message: String| Input {
            problems: vec![Problem { message, file: Some(path.to_owned()), name: None }],
            ..Input::default()
        };
        let stamp = match stamp(&whole) {
            Ok(stamp) => stamp,
            Err(e) => return refused(format!("{path}: {e}")),
        };
        if let Some(known) = known.filter(|known| known.stamp == stamp && stamp.1 < self.written) {
            return known.clone();
        }
        let parted = match PartedFile::open(&whole, &plant.options) {
            Ok(parted) => parted,
            Err(e) => return refused(e.to_string()),
        };
        let looked = match parted {
            Some(parted) => of_parts(&parted, &whole, &plant.zone).map_err(|e| e.to_string()),
            None => match sha256(&whole) {
                Ok(sha256) => Ok(match known {
                    Some(known) if known.sha256 == sha256 => known.clone(),
                    _ => look(folder, path, plant, sha256),
                }),
                Err(e) => Err(format!("{path}: {e}")),
            },
        };
        looked.map_or_else(refused, |input| Input { stamp, ..input })
    }

    /// The files of each loop by day.
    pub fn days(&self) -> BTreeMap<&str, BTreeMap<i64, Vec<&str>>> {
        let mut loops: BTreeMap<&str, BTreeMap<i64, Vec<&str>>> = BTreeMap::new();
        for (path, input) in &self.files {
            for (name, own) in &input.loops {
                let known = loops.entry(name).or_default();
                own.days.iter().for_each(|day| known.entry(*day).or_default().push(path));
            }
        }
        loops
    }

    /// The files that are no recordings, a sentence each.
    pub fn no_recordings(&self) -> Vec<String> {
        let tables = self.files.values().filter_map(|input| input.no_recording.as_ref());
        tables.chain(&self.places.folders).cloned().collect()
    }

    /// Loops that have a PV in no file.
    pub fn without_pv(&self) -> Vec<Unknown> {
        let mut loops: BTreeMap<&str, Option<&str>> = BTreeMap::new();
        for (name, own) in self.files.values().flat_map(|input| &input.loops) {
            let known = loops.entry(name).or_insert(own.no_pv.as_deref());
            *known = known.and(own.no_pv.as_deref());
        }
        let told = |(name, why): (&str, Option<&str>)| Some(Unknown::new(Kind::NoPv, name, why?));
        loops.into_iter().filter_map(told).collect()
    }

    /// Tags that no loop uses, because none with an OP has their name.
    pub fn without_op(&self) -> Vec<Unknown> {
        let mut tags: BTreeMap<&str, &str> = BTreeMap::new();
        for (path, input) in &self.files {
            tags.extend(input.without_op.iter().map(|tag| (&**tag, &**path)));
        }
        let told = |(tag, path): (&str, &str)| {
            let reason = format!(
                "{path} has no OP with its name, so no loop uses it; if it belongs to a loop, name it in plant.toml, as in \
                 [loop.NAME] pv = {}",
                quoted(tag)
            );
            Unknown::new(Kind::Tag, tag, reason)
        };
        tags.into_iter().map(told).collect()
    }

    /// All problems, including loops of the plant's file that are in no data file. A loop that was refused has one.
    pub fn problems(&self, plant: &Plant) -> Vec<Problem> {
        let of_files = self.files.values().flat_map(|input| &input.problems);
        let mut problems: Vec<Problem> =
            self.places.problems.iter().chain(of_files).cloned().collect();
        let here: BTreeSet<String> = self
            .files
            .values()
            .flat_map(|input| input.loops.keys())
            .map(|name| name.to_lowercase())
            .collect();
        let refused: BTreeSet<String> = problems
            .iter()
            .filter_map(|problem| problem.name.as_ref())
            .map(|name| name.to_lowercase())
            .collect();
        let is_absent = |name: &&String| {
            let name = name.to_lowercase();
            !here.contains(&name) && !refused.contains(&name)
        };
        for name in plant.file.loops.keys().filter(is_absent) {
            problems.push(Problem {
                file: None,
                name: Some(name.clone()),
                message: "it is in plant.toml, but in no readable data file; correct its tags \
                          or its name, or leave it out"
                    .to_owned(),
            });
        }
        problems
    }
}

/// The files that match the plant's patterns, relative to `folder`, in order.
pub fn paths(folder: &Path, plant: &Plant) -> Vec<String> {
    listed(folder, plant).0
}

/// The paths of the data files, and the places without a readable file.
fn listed(folder: &Path, plant: &Plant) -> (Vec<String>, Places) {
    let (mut paths, mut folders) = (BTreeSet::new(), BTreeSet::new());
    let mut problems: BTreeMap<String, Problem> = BTreeMap::new();
    for pattern in &plant.file.data {
        let escaped = glob::Pattern::escape(&folder.display().to_string());
        let whole = Path::new(&escaped).join(pattern);
        let found = glob::glob(&whole.display().to_string());
        for path in found.into_iter().flatten() {
            let own = |path: &Path| path.strip_prefix(folder).unwrap_or(path).display().to_string();
            let path = match path {
                Ok(path) => path,
                Err(e) => {
                    let at = own(e.path());
                    let message = format!("{at}: {}; its files were skipped", e.error());
                    problems.insert(at.clone(), Problem { file: Some(at), name: None, message });
                    continue;
                }
            };
            // The store is no data.
            if path.components().any(|part| part.as_os_str() == STORE) {
                continue;
            }
            if !path.is_dir() {
                paths.insert(own(&path));
            } else if Format::is_named_like_one(&path) {
                folders.insert(own(&path));
            }
        }
    }
    // A folder whose files match, too, is read.
    folders.retain(|own| !paths.iter().any(|path| Path::new(path).starts_with(own)));
    let folders = folders.into_iter().map(|own| {
        format!(
            "{own} is a folder, not a recording; to read the files in the folder, add \"{own}/*\" to data"
        )
    });
    let places = Places { problems: problems.into_values().collect(), folders: folders.collect() };
    (paths.into_iter().collect(), places)
}

fn sha256(path: &Path) -> std::io::Result<String> {
    let mut hasher = Sha256::new();
    std::io::copy(&mut std::fs::File::open(path)?, &mut hasher)?;
    Ok(format!("{:x}", hasher.finalize()))
}

/// Size and time of the last change, ns since 1970.
fn stamp(path: &Path) -> std::io::Result<(u64, u128)> {
    let known = std::fs::metadata(path)?;
    let changed = known.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
    Ok((known.len(), changed.as_nanos()))
}

/// The content of a file that can be read loop by loop, of which a small part is enough.
fn of_parts(file: &PartedFile, path: &Path, zone: &Zone) -> stiction_io::Result<Input> {
    let mut days: BTreeMap<String, BTreeSet<i64>> = BTreeMap::new();
    // Clocks are read once a day, not once a sample.
    let known = Cell::new((f64::INFINITY, f64::NEG_INFINITY, 0));
    let day = |stamp: Stamp| match stamp {
        Stamp::Local(at) => (at / 86_400.0).floor() as i64,
        Stamp::Utc(at) => {
            let (from, to, day) = known.get();
            if at >= from && at < to {
                return day;
            }
            let day = day::of(at, zone);
            known.set((day::begin(day, zone), day::begin(day + 1, zone), day));
            day
        }
    };
    let mut last: BTreeMap<String, i64> = BTreeMap::new();
    file.stretches(
        |from, to| day(from) == day(to),
        |name, from, _| {
            let day = day(from);
            if last.get(name) != Some(&day) {
                days.entry(name.to_owned()).or_default().insert(day);
                last.insert(name.to_owned(), day);
            }
        },
    )?;
    let own = file.fingerprints()?;
    let sha256 = if days.keys().all(|name| own.contains_key(&**name)) {
        let each: Vec<&str> = days.keys().map(|name| &*own[&**name]).collect();
        plant_file::hash(&each.join("\n"))
    } else {
        let origin = path.display().to_string();
        sha256(path).map_err(|source| stiction_io::Error::File { path: origin, source })?
    };
    let loops = days.into_iter().map(|(name, days)| {
        let sha256 = own.get(&*name).cloned();
        let no_pv = (!file.has_pv(&name)).then(without_pv);
        (name, LoopIn { days: days.into_iter().collect(), sha256, no_pv })
    });
    let without_op = file.without_op().map(str::to_owned).collect();
    Ok(Input { sha256, loops: loops.collect(), without_op, ..Input::default() })
}

/// The additional remedy for a loop whose tags are in files with one tag each.
pub(crate) const APART: &str = "or, if each tag has a file of its own, export all tags of a loop to one file, because a plant does not join files";

/// The remedy for a loop without a PV.
fn without_pv() -> String {
    format!(
        "no file with its OP has a PV of the loop's name, so the loop is judged by its OP alone; name any PV of such a file in \
         plant.toml, as in pv = \"TAG\", {APART}"
    )
}

/// Why a recording has no PV, if it has none: the remark of the reader, or the usual remedy.
fn no_pv(recording: &Recording) -> Option<String> {
    let found = recording.notes.iter().find(|note| note.contains("PV"));
    recording.pv.is_none().then(|| found.cloned().unwrap_or_else(without_pv))
}

/// The content of a file that must be read whole.
fn look(folder: &Path, path: &str, plant: &Plant, sha256: String) -> Input {
    let mut input = Input { sha256, ..Input::default() };
    let problem = |name: Option<String>, message: String| Problem {
        file: Some(path.to_owned()),
        name,
        message,
    };
    let reading = match reading::read(&folder.join(path), &plant.options) {
        Ok(reading) => reading,
        Err(e @ stiction_io::Error::NoOp { has_times: false, .. }) => {
            input.no_recording = Some(e.to_string());
            return input;
        }
        Err(e) => {
            let is_apart = matches!(e, stiction_io::Error::NoOp { .. });
            let more = if is_apart { format!(", {APART}") } else { String::new() };
            input.problems.push(problem(None, format!("{e}{more}")));
            return input;
        }
    };
    for recording in &reading.recordings {
        let name = Some(recording.name.clone());
        let days = day::days(recording, &plant.zone);
        if recording.start.is_none() {
            let message = "has no dates, so its days are unknown; add a column of dates and times";
            input.problems.push(problem(name, message.to_owned()));
        } else if input
            .loops
            .insert(recording.name.clone(), LoopIn { days, sha256: None, no_pv: no_pv(recording) })
            .is_some()
        {
            let message = "is in the file twice; rename one of them";
            input.problems.push(problem(name, message.to_owned()));
        }
    }
    let here = |name: &str| {
        let missing = reading.missing.iter().map(|missing| &missing.name);
        let read = reading.recordings.iter().map(|recording| &recording.name);
        read.chain(missing).any(|known| known.to_lowercase() == name.to_lowercase())
    };
    let lone = reading.recognised.iter().filter(|each| {
        matches!(each.role, Role::Signal(_)) && each.loop_name.as_deref().is_some_and(|l| !here(l))
    });
    input.without_op = lone.map(|each| each.column.clone()).collect();
    for missing in reading.missing.into_iter().filter(|missing| missing.is_partly_here) {
        input.problems.push(problem(Some(missing.name), format!("the file {}", missing.reason)));
    }
    input
}
