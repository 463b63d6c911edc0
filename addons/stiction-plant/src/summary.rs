//! Summaries of the data of a plant, and of the windows judged so far.

use crate::day;
use crate::error::Result;
use crate::plant_file::Plant;
use crate::propose::{head, tags};
use crate::scan::inputs::{Changes, Inputs, Problem};
use crate::scan::judge::TOO_LONG;
use crate::store::Store;
use crate::store::window::WindowRow;
use crate::unknown::{self, Unknown};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use stiction_diagnose::diagnose::Grade;
use stiction_diagnose::recording::{Mode, Recording};
use stiction_io::reading::Reading;

/// The files and loops of a plant, and the problems in both.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Checked {
    /// Name of the plant.
    pub plant: String,
    /// Number of files that the plant's file names.
    pub files: usize,
    /// The loops in the files.
    pub loops: Vec<LoopThere>,
    /// Files and loops that could not be read.
    pub problems: Vec<Problem>,
    /// Files and loops that could not be read, loops without a PV, and tags without a partner.
    pub unknown: Vec<Unknown>,
    /// Files that are no recordings because they have no OP, with a sentence on each.
    pub no_recordings: Vec<String>,
}

/// A loop in the data of a plant.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, schemars::JsonSchema)]
pub struct LoopThere {
    /// Tag of the loop.
    #[serde(rename = "loop")]
    pub name: String,
    /// Number of days with samples.
    pub days: usize,
    /// The first day with samples.
    pub first_day: Option<String>,
    /// The last day with samples.
    pub last_day: Option<String>,
    /// Whether the loop is in the plant's file.
    pub in_plant_file: bool,
    /// Tags of the signals in the last file of the loop, such as `op = "FIC101.OP"`.
    pub tags: Vec<String>,
    /// The values of the OP at 0 % and 100 %.
    pub op_range: Option<[f64; 2]>,
    /// The recorded modes: `auto`, `cascade`, `manual`, `other`; empty without a record of the mode.
    pub modes: Vec<&'static str>,
    /// Assumptions about the loop, and points to confirm.
    pub notes: Vec<String>,
}

/// The results of a plant so far.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Status {
    /// Name of the plant.
    pub plant: String,
    /// Number of loops with a window.
    pub loops: usize,
    /// Number of days with a window.
    pub days: usize,
    /// The first day with a window.
    pub first_day: Option<String>,
    /// The last day with a window.
    pub last_day: Option<String>,
    /// Number of valid windows.
    pub windows: usize,
    /// Number of windows that could not be judged.
    pub errors: usize,
    /// Number of windows that reached the time limit of their scan.
    pub time_limited: usize,
    /// Number of windows by grade, the worst grade first.
    pub grades: Vec<Graded>,
    /// Number of runs.
    pub runs: usize,
    /// Number of incomplete runs since the last complete scan of all loops and days.
    pub cut_short: usize,
    /// Damaged files of the store, with a sentence on each.
    pub damaged: Vec<String>,
    /// Data files that differ from the last scan.
    pub changes: Changes,
    /// Data that the last scan did not read, and all windows that could not be judged.
    pub unknown: Vec<Unknown>,
}

/// The number of windows with a grade.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Graded {
    /// The grade.
    pub grade: &'static str,
    /// Number of windows with this grade.
    pub windows: usize,
}

/// Reads all data of the plant in `folder` without judging; `seen` is called for each file. Folders that cannot be listed and
/// faults of single files are among the problems.
pub fn check(folder: &Path, plant: &Plant, seen: impl FnMut(&str)) -> Checked {
    // The index of files in the store is used, but not changed.
    let mut inputs = Inputs::known(&Store::of(folder), plant);
    inputs.update(folder, plant, seen);
    let mut heads = heads(folder, plant, &inputs);
    let there = |(name, days): (&str, BTreeMap<i64, Vec<&str>>)| LoopThere {
        name: name.to_owned(),
        days: days.len(),
        first_day: days.keys().next().map(|day| day::date(*day)),
        last_day: days.keys().last().map(|day| day::date(*day)),
        in_plant_file: plant.facts(name).is_some(),
        ..heads.remove(name).unwrap_or_default()
    };
    Checked {
        plant: plant.file.name.clone(),
        files: inputs.files.len(),
        loops: inputs.days().into_iter().map(there).collect(),
        unknown: unknown::of_inputs(&inputs, plant),
        problems: inputs.problems(plant),
        no_recordings: inputs.no_recordings(),
    }
}

/// The content of the last file of each loop. An unreadable file is among the problems already.
fn heads(folder: &Path, plant: &Plant, inputs: &Inputs) -> BTreeMap<String, LoopThere> {
    let mut last: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let days = inputs.days();
    for (name, days) in &days {
        let path = days.values().next_back().and_then(|files| files.last());
        last.entry(path.copied().unwrap_or_default()).or_default().insert(name);
    }
    let mut heads = BTreeMap::new();
    for (path, names) in last {
        let _ = head(&folder.join(path), &plant.options, |reading| {
            for recording in reading.recordings.iter().filter(|own| names.contains(&*own.name)) {
                heads.insert(recording.name.clone(), described(&reading, recording));
            }
        });
    }
    heads
}

fn described(reading: &Reading, recording: &Recording) -> LoopThere {
    let word = |mode: &Mode| match mode {
        Mode::Automatic => "auto",
        Mode::Cascade => "cascade",
        Mode::Manual => "manual",
        Mode::Other => "other",
    };
    let modes: BTreeSet<&str> =
        recording.mode.iter().flat_map(|modes| &modes.modes).map(word).collect();
    LoopThere {
        tags: tags(reading, &recording.name),
        op_range: recording.op.range.map(|range| [range.low, range.high]),
        modes: modes.into_iter().collect(),
        notes: recording.notes.clone(),
        ..LoopThere::default()
    }
}

/// Summarises the windows judged of the plant in `folder`.
///
/// # Errors
/// If its store cannot be read.
pub fn status(folder: &Path, plant: &Plant) -> Result<Status> {
    let store = Store::of(folder);
    let rows = store.rows()?;
    let loops: BTreeSet<&str> = rows.iter().map(|row| &*row.name).collect();
    let days: BTreeSet<i64> =
        rows.iter().map(|row| day::of(row.window_start as f64, &plant.zone)).collect();
    let is_limited =
        |row: &&WindowRow| row.error.as_deref().is_some_and(|e| e.starts_with(TOO_LONG));
    let graded = |grade: Grade| Graded {
        grade: grade.name(),
        windows: rows.iter().filter(|row| row.grade.as_deref() == Some(grade.name())).count(),
    };
    let mut inputs = Inputs::known(&store, plant);
    let changes = inputs.compared(folder, plant);
    let mut unknown = unknown::of_inputs(&inputs, plant);
    unknown.extend(unknown::of_windows(&rows, plant));
    Ok(Status {
        plant: plant.file.name.clone(),
        loops: loops.len(),
        days: days.len(),
        first_day: days.first().map(|day| day::date(*day)),
        last_day: days.last().map(|day| day::date(*day)),
        windows: rows.len(),
        errors: rows.iter().filter(|row| row.error.is_some()).count(),
        time_limited: rows.iter().filter(is_limited).count(),
        grades: Grade::ALL.map(graded).into_iter().collect(),
        runs: store.run_names()?.len(),
        cut_short: store.cut_short()?,
        damaged: store.damaged(),
        changes,
        unknown,
    })
}
