//! Unknown facts about a plant: unread data, and windows that were not judged.

use crate::day;
use crate::plant_file::Plant;
use crate::report::ranking::Ranking;
use crate::scan::inputs::Inputs;
use crate::store::window::WindowRow;
use std::collections::BTreeMap;
use stiction_diagnose::spoken::counted;
use stiction_model::{always_written_by_name, named};

named! {
    /// What something unknown is.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Kind {
        /// A file that was refused, or a folder that cannot be listed.
        File = "file not read",
        /// A loop that was refused, or that no file holds.
        Loop = "loop not read",
        /// A loop without a PV, which is judged by its OP only.
        NoPv = "loop without a PV",
        /// A tag of a loop without an OP, which nothing uses.
        Tag = "tag without a partner",
        /// Windows that could not be judged.
        Window = "window not judged",
    }
}

always_written_by_name!(Kind);

impl Kind {
    /// This number of unknown things, in words.
    pub fn counted(self, count: usize) -> String {
        let (first, rest) = self.name().split_once(' ').unwrap_or((self.name(), ""));
        format!("{} {rest}", counted(count, first))
    }
}

/// A file, loop, tag or window that could not be used, with the reason.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct Unknown {
    /// Kind: `file not read`, `loop not read`, `loop without a PV`, `tag without a partner` or `window not judged`.
    pub kind: Kind,
    /// Name of the file, loop or tag.
    pub name: String,
    /// Number of windows of a loop that were not judged; 1 for all other kinds.
    pub count: usize,
    /// The reason, with a remedy.
    pub reason: String,
}

impl Unknown {
    /// One of a kind.
    pub fn new(kind: Kind, name: &str, reason: impl Into<String>) -> Self {
        Self { kind, name: name.to_owned(), count: 1, reason: reason.into() }
    }

    /// It as a sentence.
    pub fn words(&self) -> String {
        // The message about a file names it, after the folder of the plant.
        let reason = match self.reason.split_once(&format!("{}: ", self.name)) {
            Some((folder, reason)) if !folder.contains(": ") => reason,
            _ => &self.reason,
        };
        format!("{}: {reason}", self.name)
    }
}

/// What was not read of the data.
pub fn of_inputs(inputs: &Inputs, plant: &Plant) -> Vec<Unknown> {
    let of_problem = |problem: crate::scan::inputs::Problem| {
        let kind = if problem.name.is_some() { Kind::Loop } else { Kind::File };
        let named = problem.name.or(problem.file.clone()).unwrap_or_default();
        let reason = match (kind, problem.file) {
            (Kind::Loop, Some(file)) => format!("{file}: {}", problem.message),
            _ => problem.message,
        };
        Unknown::new(kind, &named, reason)
    };
    let mut all: Vec<Unknown> = inputs.problems(plant).into_iter().map(of_problem).collect();
    all.extend(inputs.without_pv());
    all.extend(inputs.without_op());
    all
}

/// The windows that were not judged, by loop.
pub fn of_windows<'a>(
    rows: impl IntoIterator<Item = &'a WindowRow>,
    plant: &Plant,
) -> Vec<Unknown> {
    let mut of_loop: BTreeMap<&str, Vec<&WindowRow>> = BTreeMap::new();
    for row in rows.into_iter().filter(|row| !row.is_judged()) {
        of_loop.entry(&row.name).or_default().push(row);
    }
    let told = |(name, rows): (&str, Vec<&WindowRow>)| {
        let last = rows.iter().max_by_key(|row| row.window_start)?;
        let date = day::date(day::of(last.window_start as f64, &plant.zone));
        let why = last.error.as_ref().or(last.unfit_reasons.as_ref());
        let why = why.map_or("no part of the recording can be judged", String::as_str);
        let reason = match rows.len() {
            1 => format!("{date}: {why}"),
            count => format!("{count} windows, the last on {date}: {why}"),
        };
        Some(Unknown { count: rows.len(), ..Unknown::new(Kind::Window, name, reason) })
    };
    of_loop.into_iter().filter_map(told).collect()
}

/// All unknown things of a week: unread data, and windows of the week that were not judged.
pub fn of_week(inputs: &Inputs, plant: &Plant, ranking: &Ranking<'_>) -> Vec<Unknown> {
    let mut all = of_inputs(inputs, plant);
    let rows = ranking.loops.iter().flat_map(|ranked| ranked.of_week.iter().copied());
    all.extend(of_windows(rows, plant));
    all
}

/// How much of each kind there is.
pub fn counts(all: &[Unknown]) -> Vec<(Kind, usize)> {
    let of = |kind: Kind| all.iter().filter(|each| each.kind == kind).map(|each| each.count).sum();
    Kind::ALL.into_iter().map(|kind| (kind, of(kind))).filter(|(_, count)| *count > 0).collect()
}

/// The counts in words, such as `8 files not read, 2 windows not judged`; empty if all is known.
pub fn counted_words(all: &[Unknown]) -> String {
    let each = counts(all).into_iter().map(|(kind, count)| kind.counted(count));
    each.collect::<Vec<_>>().join(", ")
}
