//! Rows of windows from tables in the memory of other programs: a long or wide table of samples, of one loop or
//! several.
//!
//! A distributed engine judges one [window] at a time, from the samples of its loop on its days and the day before.
//! [`loops`] finds the tags that belong together.

use crate::day;
use crate::plant_file::Plant;
use crate::scan::judge::{Judge, Judged};
use crate::store::window::WindowRow;
use rayon::prelude::*;
use stiction_diagnose::recording::Recording;
use stiction_io::layout;
use stiction_io::reading;
use stiction_io::role::Signal;
use stiction_io::sheet::{Cells, Column, Sheet};

/// The name of a table in messages.
pub const ORIGIN: &str = "the table";

/// The rows of all windows in a table. An unreadable part is a row with an error, without a window if none is known.
pub fn rows(sheet: Sheet, plant: &Plant) -> Vec<WindowRow> {
    let refused = |name: String, error: String| {
        vec![WindowRow {
            name,
            loop_type: "unknown".to_owned(),
            error: Some(error),
            ..WindowRow::default()
        }]
    };
    let reading = match reading::of_sheet(sheet, &plant.options) {
        Ok(reading) => reading,
        Err(e) => return refused(String::new(), e.to_string()),
    };
    let lost = reading.missing.into_iter().filter(|missing| missing.is_partly_here);
    let lost = lost.flat_map(|lost| refused(lost.name, format!("{ORIGIN} {}", lost.reason)));
    let lost: Vec<WindowRow> = lost.collect();
    let of_loop = |recording: Recording| {
        let name = recording.name.clone();
        if recording.start.is_none() {
            let message = "has no dates, so its days are unknown; add a column of dates and times";
            return refused(name, message.to_owned());
        }
        let judge = Judge::of(plant, &name);
        let days = day::days(&recording, &plant.zone);
        let parts = [(ORIGIN, recording)];
        let mut own = vec![];
        let mut cursor = i64::MIN;
        for day in days {
            if day < cursor {
                continue;
            }
            let mut judged = judge.window(Ok(&parts), day, 1);
            let count = judged.days;
            if count > 1 {
                judged = judge.window(Ok(&parts), day, count);
            }
            own.extend(judged.row);
            cursor = day + count;
        }
        own
    };
    let judged: Vec<Vec<WindowRow>> = reading.recordings.into_par_iter().map(of_loop).collect();
    judged.into_iter().flatten().chain(lost).collect()
}

/// One window of the loop `name`, of `count` days from `day` on. Rows of other loops are ignored.
pub fn window(sheet: Sheet, plant: &Plant, name: &str, day: i64, count: i64) -> Judged {
    let judge = Judge::of(plant, name);
    let lower = name.to_lowercase();
    let options = plant.options.of_loops(&[lower.clone()].into());
    let reading = match reading::of_sheet(sheet, &options) {
        Ok(reading) => reading,
        Err(e) => return judge.refused(day, count, e.to_string()),
    };
    let own = reading.recordings.into_iter().find(|own| own.name.to_lowercase() == lower);
    match (own, reading.missing.into_iter().find(|lost| lost.name.to_lowercase() == lower)) {
        (Some(own), _) => judge.window(Ok(&[(ORIGIN, own)]), day, count),
        (None, Some(lost)) => judge.refused(day, count, format!("{ORIGIN} {}", lost.reason)),
        (None, None) => Judged { row: None, trace: None, days: 1 },
    }
}

/// A loop with its tags.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tags {
    /// The loop.
    pub name: String,
    /// The tags or columns that are read with it, as indices.
    pub tags: Vec<usize>,
    /// The index of its OP.
    pub op: usize,
}

/// The loops among the tags of a long table, or among the columns of a wide one except those about `rows`. None if the plant's
/// file and the names show none.
pub fn loops(names: &[&str], rows: &[usize], plant: &Plant) -> Vec<Tags> {
    if let Some(bundles) = layout::bundles(names, rows, &plant.options) {
        let of = |bundle: layout::Bundle| {
            let layout::Bundle { loops, names, .. } = bundle;
            loops.into_iter().map(move |(name, op)| Tags { name, tags: names.clone(), op })
        };
        return bundles.into_iter().flat_map(of).collect();
    }
    // All are recognised together, from a table with a row for each.
    let tags: Vec<usize> = (0..names.len()).filter(|k| !rows.contains(k)).collect();
    let column = |name: &str, cells: Cells| Column { name: name.to_owned(), unit: None, cells };
    let sheet = Sheet {
        origin: ORIGIN.to_owned(),
        columns: vec![
            column("time", Cells::Times { seconds: vec![0.0; tags.len()], utc: true }),
            column("tag", Cells::Text(tags.iter().map(|k| names[*k]).collect())),
            column("value", Cells::Numbers(vec![0.0; tags.len()])),
        ],
        ..Sheet::default()
    };
    let Ok(plan) = layout::recognise(&sheet, &plant.options) else { return vec![] };
    let known = |each: layout::LoopPlan| {
        let op = *tags.get(each.signal(Signal::Op)?)?;
        Some(Tags { name: each.name?, tags: tags.clone(), op })
    };
    plan.loops.into_iter().filter_map(known).collect()
}
