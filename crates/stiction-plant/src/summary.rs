//! What a plant's data hold, and what was judged of them so far.

use crate::day;
use crate::error::Result;
use crate::inputs::{self, Inputs, Problem};
use crate::plant_file::Plant;
use crate::store::Store;
use std::collections::BTreeSet;
use std::path::Path;
use stiction_diagnose::diagnose::Grade;

/// What a plant's data hold.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Checked {
    /// Name of the plant.
    pub plant: String,
    /// Files that the plant's file names.
    pub files: usize,
    /// Loops in them.
    pub loops: Vec<LoopThere>,
    /// What is wrong.
    pub problems: Vec<Problem>,
}

/// A loop that the data hold.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct LoopThere {
    /// Its tag.
    #[serde(rename = "loop")]
    pub name: String,
    /// Days with samples.
    pub days: usize,
    /// The first of them.
    pub first_day: Option<String>,
    /// The last of them.
    pub last_day: Option<String>,
    /// Whether the plant's file knows it.
    pub in_plant_file: bool,
}

/// What was judged so far.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Status {
    /// Name of the plant.
    pub plant: String,
    /// Loops with a window.
    pub loops: usize,
    /// Days of the plant with a window.
    pub days: usize,
    /// The first of them.
    pub first_day: Option<String>,
    /// The last of them.
    pub last_day: Option<String>,
    /// Windows that count.
    pub windows: usize,
    /// Of these, windows that could not be judged.
    pub errors: usize,
    /// Windows by grade, the worst first.
    pub grades: Vec<Graded>,
    /// Runs, and of these those that did not come to their end.
    pub runs: usize,
    /// Runs that were cut short.
    pub cut_short: usize,
}

/// How many windows have a grade.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Graded {
    /// The grade.
    pub grade: &'static str,
    /// Windows.
    pub windows: usize,
}

/// Reads all data of the plant in `folder` and judges nothing; `seen` hears of each file.
///
/// # Errors
/// If a folder of data cannot be listed. What is wrong with a file is among the problems.
pub fn check(folder: &Path, plant: &Plant, seen: impl FnMut(&str)) -> Result<Checked> {
    // What the store knows of the files is used, and left as it is.
    let mut inputs = Inputs::known(&Store::of(folder), plant);
    let files = inputs::paths(folder, plant)?.len();
    inputs.update(folder, plant, seen)?;
    let there = |(name, days): (&str, std::collections::BTreeMap<i64, Vec<&str>>)| LoopThere {
        name: name.to_owned(),
        days: days.len(),
        first_day: days.keys().next().map(|day| day::date(*day)),
        last_day: days.keys().last().map(|day| day::date(*day)),
        in_plant_file: plant.facts(name).is_some(),
    };
    Ok(Checked {
        plant: plant.file.name.clone(),
        files,
        loops: inputs.days().into_iter().map(there).collect(),
        problems: inputs.problems(plant),
    })
}

/// Tells what was judged of the plant in `folder`.
///
/// # Errors
/// If its store cannot be read.
pub fn status(folder: &Path, plant: &Plant) -> Result<Status> {
    let store = Store::of(folder);
    let rows = store.rows()?;
    let runs = store.run_names()?;
    let manifests = runs.iter().map(|run| store.manifest(run)).collect::<Result<Vec<_>>>()?;
    let loops: BTreeSet<&str> = rows.iter().map(|row| &*row.name).collect();
    let days: BTreeSet<i64> =
        rows.iter().map(|row| day::of(row.window_start as f64, &plant.zone)).collect();
    let graded = |grade: Grade| Graded {
        grade: grade.name(),
        windows: rows.iter().filter(|row| row.grade.as_deref() == Some(grade.name())).count(),
    };
    Ok(Status {
        plant: plant.file.name.clone(),
        loops: loops.len(),
        days: days.len(),
        first_day: days.first().map(|day| day::date(*day)),
        last_day: days.last().map(|day| day::date(*day)),
        windows: rows.len(),
        errors: rows.iter().filter(|row| row.error.is_some()).count(),
        grades: Grade::ALL.map(graded).into_iter().collect(),
        runs: runs.len(),
        cut_short: manifests.iter().filter(|manifest| manifest.is_none()).count(),
    })
}
