//! Which files a plant has, and which loops and days are in them.

use crate::day;
use crate::error::{Result, file, store};
use crate::plant_file::Plant;
use crate::store::{Store, write_whole};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use stiction_io::reading;

/// Something that could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Problem {
    /// The file; none if it is about all of them.
    pub file: Option<String>,
    /// The loop; none if it is about the whole file.
    #[serde(rename = "loop")]
    pub name: Option<String>,
    /// What is wrong, and what would help.
    pub message: String,
}

impl Problem {
    /// It as a sentence.
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
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// The days of each loop: of the plant's calendar, since 1970-01-01.
    pub loops: BTreeMap<String, Vec<i64>>,
    /// What of it could not be read.
    pub problems: Vec<Problem>,
}

/// The files of a plant by their paths from its folder on.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Inputs {
    /// By what settings they were read.
    reading_hash: String,
    /// The files.
    pub files: BTreeMap<String, Input>,
}

const NAME: &str = "inputs.json";

impl Inputs {
    /// What the store knows of the files; nothing if that was lost, or other settings hold now.
    pub fn known(store: &Store, plant: &Plant) -> Self {
        let reading_hash = plant.reading_hash();
        let text = std::fs::read(store.path(NAME)).unwrap_or_default();
        let known: Option<Self> = serde_json::from_slice(&text).ok();
        known
            .filter(|known| known.reading_hash == reading_hash)
            .unwrap_or(Self { reading_hash, files: BTreeMap::new() })
    }

    /// Keeps it in the store.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn keep(&self, to: &Store) -> Result<()> {
        let path = to.path(NAME);
        let text = serde_json::to_vec_pretty(self).map_err(|e| store(&path, e))?;
        write_whole(&path, &text)
    }

    /// Brings it up to date with the files in `folder`: those that are gone are forgotten, new and changed ones are
    /// read, one at a time; `seen` hears of each file.
    ///
    /// # Errors
    /// If a folder cannot be listed. What is wrong with a file is among its problems.
    pub fn update(
        &mut self,
        folder: &Path,
        plant: &Plant,
        mut seen: impl FnMut(&str),
    ) -> Result<()> {
        let mut files = BTreeMap::new();
        for path in paths(folder, plant)? {
            let input = match sha256(&folder.join(&path)) {
                Ok(sha256) => match self.files.remove(&path) {
                    Some(known) if known.sha256 == sha256 => known,
                    _ => look(folder, &path, plant, sha256),
                },
                Err(e) => Input {
                    problems: vec![Problem {
                        message: format!("{path}: {e}"),
                        file: Some(path.clone()),
                        name: None,
                    }],
                    ..Input::default()
                },
            };
            seen(&path);
            files.insert(path, input);
        }
        self.files = files;
        Ok(())
    }

    /// The files of each loop by day.
    pub fn days(&self) -> BTreeMap<&str, BTreeMap<i64, Vec<&str>>> {
        let mut loops: BTreeMap<&str, BTreeMap<i64, Vec<&str>>> = BTreeMap::new();
        for (path, input) in &self.files {
            for (name, days) in &input.loops {
                let known = loops.entry(name).or_default();
                days.iter().for_each(|day| known.entry(*day).or_default().push(path));
            }
        }
        loops
    }

    /// Everything that could not be read, and the loops of the plant's file that no file holds.
    pub fn problems(&self, plant: &Plant) -> Vec<Problem> {
        let mut problems: Vec<Problem> =
            self.files.values().flat_map(|input| input.problems.iter().cloned()).collect();
        let here: BTreeSet<String> = self
            .files
            .values()
            .flat_map(|input| input.loops.keys())
            .map(|name| name.to_lowercase())
            .collect();
        for name in plant.file.loops.keys().filter(|name| !here.contains(&name.to_lowercase())) {
            problems.push(Problem {
                file: None,
                name: Some(name.clone()),
                message: "the plant's file names it, but no file that could be read holds it; correct its tags \
                          or its name, or leave it out"
                    .to_owned(),
            });
        }
        problems
    }
}

/// The files that the plant's patterns name, from `folder` on, in order.
///
/// # Errors
/// If a folder cannot be listed.
pub fn paths(folder: &Path, plant: &Plant) -> Result<Vec<String>> {
    let mut paths = BTreeSet::new();
    for pattern in &plant.file.data {
        let escaped = glob::Pattern::escape(&folder.display().to_string());
        let whole = Path::new(&escaped).join(pattern);
        let found = glob::glob(&whole.display().to_string());
        for path in found.into_iter().flatten() {
            let path = path.map_err(|e| {
                let at = e.path().to_owned();
                file(&at)(e.into())
            })?;
            if path.is_file() {
                let own = path.strip_prefix(folder).unwrap_or(&path);
                paths.insert(own.display().to_string());
            }
        }
    }
    Ok(paths.into_iter().collect())
}

fn sha256(path: &Path) -> std::io::Result<String> {
    let mut hasher = Sha256::new();
    std::io::copy(&mut std::fs::File::open(path)?, &mut hasher)?;
    Ok(format!("{:x}", hasher.finalize()))
}

/// What a file holds.
fn look(folder: &Path, path: &str, plant: &Plant, sha256: String) -> Input {
    let mut input = Input { sha256, ..Input::default() };
    let problem = |name: Option<String>, message: String| Problem {
        file: Some(path.to_owned()),
        name,
        message,
    };
    let reading = match reading::read(&folder.join(path), &plant.options) {
        Ok(reading) => reading,
        Err(e) => {
            input.problems.push(problem(None, e.to_string()));
            return input;
        }
    };
    for recording in &reading.recordings {
        let name = Some(recording.name.clone());
        let days = day::days(recording, &plant.zone);
        if recording.start.is_none() {
            let message =
                "tells no dates, so its days are not known; give a column of dates and times";
            input.problems.push(problem(name, message.to_owned()));
        } else if input.loops.insert(recording.name.clone(), days).is_some() {
            let message = "is in the file twice; give one of them another name";
            input.problems.push(problem(name, message.to_owned()));
        }
    }
    for missing in reading.missing.into_iter().filter(|missing| missing.is_partly_here) {
        input.problems.push(problem(Some(missing.name), format!("the file {}", missing.reason)));
    }
    input
}
