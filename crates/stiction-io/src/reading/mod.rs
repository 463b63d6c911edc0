//! Recordings from files of any format.

mod builder;
mod doubts;
pub mod file_per_tag;
mod format;
pub mod join;
mod naming;
mod notation;
#[cfg(feature = "parquet")]
pub mod parted;
mod parts;
mod runs;
pub mod summary;
mod times;
mod written;

pub use format::Format;
pub use written::{mapping_of, same};

use crate::cells::number;
use crate::columns::layout::{self, Layout, MissingLoop, Plan, Recognised, side_by_side};
use crate::columns::options::ReadOptions;
use crate::csv::Dialect;
use crate::error::{Error, Result};
use crate::names::list;
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Column, Sheet};
use crate::timestamp::{Clock, Times};
use builder::{Builder, no_op};
use format::{File, sheets};
use naming::{Names, common_start};
use std::collections::HashSet;
use std::path::Path;
use stiction_recording::recording::Recording;

/// The notation of times in a part of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeColumn {
    /// Name of the column; none if rows are evenly spaced.
    pub column: Option<String>,
    /// Notation, in words.
    pub format: String,
    /// The kind of its clock.
    pub clock: Clock,
}

impl TimeColumn {
    /// The notation of the `times` of a sheet.
    fn of(sheet: &Sheet, plan: &Plan, options: &ReadOptions, times: &Times) -> Self {
        let used = plan.time.filter(|_| options.sample_time.is_none());
        Self {
            column: used.map(|column| sheet.columns[column].name.clone()),
            format: times.format.clone(),
            clock: times.clock.clone(),
        }
    }
}

/// The content of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The name of the file in messages.
    pub origin: String,
    /// SHA-256 of its bytes, in hexadecimal; empty for a table in memory.
    pub sha256: String,
    /// Format.
    pub format: Format,
    /// The arrangement of its loops; with several parts, in the first that has a loop.
    pub layout: Layout,
    /// The notation of its times; with several parts, in the first that has a loop.
    pub time: TimeColumn,
    /// The loops, in the order of the file.
    pub recordings: Vec<Recording>,
    /// The recognised role of every column and tag.
    pub recognised: Vec<Recognised>,
    /// The loops that are not among the recordings, because the file lacks a column or tag that the mapping names, or
    /// because one of their signals could not become a column. The notes list loops with other signals in the file.
    pub missing: Vec<MissingLoop>,
    /// Names of recordings that are named after the file, because nothing in it names them.
    pub untagged: Vec<String>,
    /// Notes for the user on the whole file. Each recording has its own notes.
    pub notes: Vec<String>,
}

/// Reads the recordings in the file at `path`.
///
/// # Errors
/// If the file cannot be read, or as for [`parse`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Reading> {
    let origin = path.display().to_string();
    collected(File::open(path, &origin)?, &origin, options)
}

/// Passes the recordings in the file at `path` to `visit` one by one, each with the clock of the file. So not all of
/// them need to be in memory. The reading has none.
///
/// # Errors
/// As for [`read`], also after some of the recordings.
pub fn visit(
    path: &Path,
    options: &ReadOptions,
    visit: &mut dyn FnMut(Recording, &Clock),
) -> Result<Reading> {
    let origin = path.display().to_string();
    build(File::open(path, &origin)?, &origin, options, visit)
}

/// Reads recordings from `bytes`, whose format is detected from their beginning. `origin` is the name of the bytes in
/// errors, and the name of a loop without a name.
///
/// # Errors
/// If the bytes are of no known format, or no column is known as a controller output; if a cell does not fit its
/// column and is not a known word; or if the times cannot be read.
pub fn parse(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<Reading> {
    collected(File::of(bytes, origin)?, origin, options)
}

/// The names of all columns in `bytes`, so that a user can assign those that [`parse`] does not recognise.
///
/// # Errors
/// If the bytes are of no known format.
pub fn columns(bytes: &[u8], origin: &str) -> Result<Vec<String>> {
    let (_, sheets, _) = sheets(bytes, origin)?;
    let columns = sheets.into_iter().flat_map(|sheet| sheet.columns);
    Ok(columns.map(|column| column.name).collect())
}

/// Reads recordings from a table in memory. `origin` of the sheet is its name in errors, and the name of a loop without a
/// name.
///
/// # Errors
/// As for [`parse`], except for the format.
pub fn of_sheet(sheet: Sheet, options: &ReadOptions) -> Result<Reading> {
    let origin = sheet.origin.clone();
    let (format, sheets, sha256) = (Format::Memory, vec![sheet], String::new());
    collected(File { format, sheets, notes: vec![], sha256 }, &origin, options)
}

/// Reads the recordings of a file.
fn collected(file: File, origin: &str, options: &ReadOptions) -> Result<Reading> {
    let mut recordings = vec![];
    let reading = build(file, origin, options, &mut |recording, _| recordings.push(recording))?;
    Ok(Reading { recordings, ..reading })
}

/// Reads the recordings of a file, and passes each to `visit`.
fn build(
    file: File,
    origin: &str,
    options: &ReadOptions,
    visit: &mut dyn FnMut(Recording, &Clock),
) -> Result<Reading> {
    let File { mut format, sheets, mut notes, sha256 } = file;
    let sheets = &parts::chosen(sheets, origin, options)?[..];
    let mut names = Names { origin, parts: common_start(sheets), several: sheets.len() > 1 };
    let understood;
    let sheets = match format {
        Format::Workbook if sheets.len() > 1 => {
            understood = parts::holding_loops(sheets, options, &mut notes)?;
            names.several = understood.len() > 1;
            &understood[..]
        }
        Format::Matlab if sheets.len() > 1 && !options.map.is_empty() => {
            understood = parts::understood(sheets, options, &mut notes)?;
            &understood[..]
        }
        _ => sheets,
    };
    let mut first: Option<(Layout, TimeColumn)> = None;
    let (mut seen, mut recognised): (HashSet<String>, _) = (HashSet::new(), vec![]);
    let (mut missing, mut untagged): (Vec<MissingLoop>, _) = (vec![], vec![]);
    let mut without_op: Vec<&str> = vec![];
    for original in sheets {
        let unfolded = side_by_side::unfold(original, options);
        let (sheet, options) = match &unfolded {
            Some(unfolded) => (&unfolded.sheet, &unfolded.options),
            None => (original, options),
        };
        let mut plan = layout::recognise(sheet, options)?;
        if let Some(unfolded) = &unfolded {
            unfolded.describe(&mut plan);
        }
        recognised.extend(plan.recognised.iter().cloned());
        missing.extend(plan.missing.iter().cloned());
        let about = |note: &String| match &*sheet.part {
            "" => note.clone(),
            part => format!("{part}: {note}"),
        };
        notes.extend(sheet.notes.iter().chain(&plan.notes).map(about));
        if plan.loops.is_empty() {
            without_op.push(&*original.part);
            continue;
        }
        for each in &plan.loops {
            if let Some(reason) = &each.unread {
                let (name, _) = names.of(each, sheet);
                notes.push(format!("loop {name} is not read: the file {reason}"));
                let reason = reason.clone();
                missing.push(MissingLoop { name, reason, is_partly_here: true });
            }
        }
        if plan.loops.iter().all(|each| each.unread.is_some()) {
            continue;
        }
        let found = match format {
            Format::Csv(Dialect { decimal_mark: mark, mark_is_sure: is_sure, .. }) => {
                number::Found { mark, is_sure }
            }
            _ => number::decimal_mark(&sheet.columns),
        };
        let (mark, said) = notation::settle(sheet, &plan, options, found)?;
        notes.extend(said.iter().map(about));
        if let Format::Csv(dialect) = &mut format {
            dialect.decimal_mark = mark;
        }
        let builder = Builder::new(sheet, &plan, options, mark)?;
        notes.extend(builder.times.notes.iter().map(about));
        let time = || TimeColumn::of(sheet, &plan, options, &builder.times);
        let (_, time) = first.get_or_insert_with(|| (plan.layout, time()));
        for each in plan.loops.iter().filter(|each| each.unread.is_none()) {
            let (name, tells) = names.of(each, sheet);
            if !tells {
                untagged.push(name.clone());
            }
            seen.insert(name.to_lowercase());
            let recording = builder.recording(each, name)?;
            // Cells that could not be fetched are no samples.
            if let Some(message) = original.failure() {
                return Err(Error::Table { origin: origin.to_owned(), message });
            }
            visit(recording, &time.clock);
        }
    }
    let Some((layout, time)) = first else {
        let lacking = missing.iter().max_by_key(|each| each.is_partly_here);
        let Some(lacking) = lacking else {
            let unnamed = without_header(format, sheets, options.wording);
            return Err(unnamed
                .filter(|_| options.map.is_empty())
                .unwrap_or_else(|| no_op(origin, &recognised, options.wording)));
        };
        let (origin, message) = (origin.to_owned(), lacking.reason.clone());
        return Err(match lacking.is_partly_here {
            true => Error::Table { origin, message },
            false => Error::NoOp { origin, message, has_times: builder::has_times(&recognised) },
        });
    };
    match &without_op[..] {
        [] => {}
        [part] => notes.push(format!("{part} has no column known as OP and is not read")),
        parts => {
            let parts = list(parts);
            notes.push(format!("{parts} have no column known as OP and are not read"));
        }
    }
    // Another part of the file may have what one part lacks.
    missing.sort_by_key(|each| !each.is_partly_here);
    missing.retain(|each| seen.insert(each.name.to_lowercase()));
    let elsewhere: Vec<&str> =
        missing.iter().filter(|each| !each.is_partly_here).map(|each| &*each.name).collect();
    if !elsewhere.is_empty() {
        notes.push(format!("the file lacks these loops of the mapping: {}", list(&elsewhere)));
    }
    Ok(Reading {
        origin: origin.to_owned(),
        sha256,
        format,
        layout,
        time,
        recordings: vec![],
        recognised,
        missing,
        untagged,
        notes,
    })
}

/// The error for a text without a header, whose columns are named by their places.
fn without_header(format: Format, sheets: &[Sheet], wording: Wording) -> Option<Error> {
    let (Format::Csv(dialect), [sheet]) = (format, sheets) else { return None };
    let place = |(i, column): (usize, &Column)| column.name == format!("column {}", i + 1);
    if !sheet.columns.iter().enumerate().all(place) {
        return None;
    }
    let cells = sheet.columns.iter().map(|column| match &column.cells {
        Cells::Text(cells) => cells.view().first().unwrap_or("").to_owned(),
        _ => String::new(),
    });
    let row = cells.collect::<Vec<_>>().join(&dialect.delimiter.to_string());
    let of = |role: &str, place: usize| wording.of(Remedy::map(role, &format!("column {place}")));
    Some(Error::Table {
        origin: sheet.origin.clone(),
        message: format!(
            "row {} must name the columns, but reads \"{}\"; add a header such as {}, or name columns by their places, \
             as in {} and {}",
            sheet.row(0),
            number::shown(&row),
            ["\"time", "pv", "op\""].join(&dialect.delimiter.to_string()),
            of("time", 1),
            of("op", sheet.columns.len()),
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_recording::recording::{LoopType, Quality};

    fn sheet(part: &str, columns: Vec<(&str, Cells)>) -> Sheet {
        let column =
            |(name, cells): (&str, Cells)| Column { name: name.to_owned(), unit: None, cells };
        Sheet {
            origin: "f.mat".to_owned(),
            part: part.to_owned(),
            columns: columns.into_iter().map(column).collect(),
            ..Sheet::default()
        }
    }

    fn built(sheets: &[Sheet], options: &ReadOptions) -> Result<Reading> {
        let (sheets, sha256) = (sheets.to_vec(), String::new());
        let file = File { format: Format::Matlab, sheets, notes: vec![], sha256 };
        collected(file, "f.mat", options)
    }

    #[test]
    fn parts_of_a_file_are_loops() {
        let loops = |part: &str, kind: &str| {
            let numbers = |from: f64| Cells::Numbers(vec![from, f64::NAN, from + 1.0]);
            let mut sheet = sheet(part, vec![("OP", numbers(50.0)), ("PV", numbers(1.0))]);
            sheet.sample_time = Some(2.0);
            sheet.attributes = vec![("type".to_owned(), kind.to_owned())];
            sheet
        };
        let nothing = sheet("cdata.info", vec![("x", Cells::Numbers(vec![1.0]))]);
        let sheets = [loops("cdata.chemicals.loop2", "0"), nothing, loops("cdata.pulp.loop2", "1")];
        let reading = built(&sheets, &ReadOptions::default()).unwrap();
        let told: Vec<_> = reading.recordings.iter().map(|r| (&*r.name, r.loop_type)).collect();
        let expected = [
            ("chemicals.loop2", LoopType::OtherSelfRegulating),
            ("pulp.loop2", LoopType::OtherIntegrating),
        ];
        assert_eq!(told, expected);
        let op = &reading.recordings[0].op;
        assert_eq!(op.time, [0.0, 2.0, 4.0]);
        assert_eq!(op.quality, [Quality::Good, Quality::Missing, Quality::Good]);
        assert!(
            reading.notes.iter().any(|note| note.contains("cdata.info has no column known as OP"))
        );
    }

    #[test]
    fn times_of_the_format_are_local_unless_utc() {
        let times = |utc| Cells::Times { seconds: vec![1_704_067_200.0, 1_704_067_201.0], utc };
        let of = |utc, zone: Option<&str>| {
            let op = Cells::Numbers(vec![50.0, 51.0]);
            let sheets = [sheet("", vec![("time", times(utc)), ("op", op)])];
            let zone = zone.map(|zone| zone.parse().unwrap());
            let options = ReadOptions { zone, ..ReadOptions::default() };
            built(&sheets, &options).unwrap().recordings[0].start
        };
        assert_eq!(of(true, None), Some(1_704_067_200.0));
        assert_eq!(of(false, None), Some(1_704_067_200.0));
        assert_eq!(of(false, Some("Europe/Berlin")), Some(1_704_063_600.0));
    }

    /// A loop of 60 samples, in which sample 30 of the OP and of the PV have these texts.
    fn with(op: &str, pv: &str) -> String {
        let row = |k: usize| {
            let wave = (k as f64 * 0.4).sin();
            let at = |text: &str, value: f64| match k {
                30 => text.to_owned(),
                _ => format!("{value:.3}"),
            };
            format!("{k},{},{}\n", at(op, 45.0 + 3.0 * wave), at(pv, 60.0 - 2.0 * wave))
        };
        format!("t,op,pv\n{}", (0..60).map(row).collect::<String>())
    }

    fn masked(text: &str, options: &ReadOptions) -> Vec<(&'static str, f64)> {
        let [one] = &parse(text.as_bytes(), "a.csv", options).unwrap().recordings[..] else {
            panic!("one loop")
        };
        assert!(one.op.range.is_none() && one.notes.is_empty(), "{:?}", one.notes);
        one.masked_values().iter().map(|m| (m.signal, m.value)).collect()
    }

    #[test]
    fn values_that_are_no_measurements_are_masked_before_the_range_is_estimated() {
        let found = masked(&with("-9999", "1e38"), &ReadOptions::default());
        assert_eq!(found, [("OP", -9999.0), ("PV", 1e38)]);
        assert_eq!(masked(&with("46", "61"), &ReadOptions::default()), []);
    }

    #[test]
    fn numbers_that_the_user_names_are_masked() {
        let value = ReadOptions { bad_value: vec![61.0], ..ReadOptions::default() };
        let text = ReadOptions { bad_text: vec!["61.0".to_owned()], ..ReadOptions::default() };
        for options in [value, text] {
            assert_eq!(masked(&with("46", "61"), &options), [("PV", 61.0)]);
        }
    }

    #[test]
    fn joined_files_are_masked_as_one() {
        // The first file alone shows nothing of the loop.
        let outage = "t,op,pv\n-3,-9999,-9999\n-2,-9999,-9999\n-1,-9999,-9999\n0,45.000,60.000\n";
        let read = |text: &str, name: &str| {
            let options = ReadOptions { bad_value: vec![61.0], ..ReadOptions::default() };
            parse(text.as_bytes(), name, &options).unwrap().recordings.remove(0)
        };
        let (first, second) = (read(outage, "a.csv"), read(&with("46", "61"), "b.csv"));
        assert_eq!(first.pv.as_ref().unwrap().masked, []);
        let whole = join::join(&[("a.csv", &first), ("b.csv", &second)]).unwrap();
        let counts: Vec<_> =
            whole.masked_values().iter().map(|m| (m.signal, m.value, m.count)).collect();
        assert_eq!(counts, [("OP", -9999.0, 3), ("PV", -9999.0, 3), ("PV", 61.0, 1)]);
    }

    #[test]
    fn numbers_that_cannot_be_are_refused() {
        let op = Cells::Numbers(vec![50.0, f64::INFINITY]);
        let mut infinite = sheet("", vec![("op", op)]);
        infinite.sample_time = Some(1.0);
        let message = built(&[infinite], &ReadOptions::default()).unwrap_err().to_string();
        assert!(
            message.contains("f.mat, row 2, column \"op\": inf is not a finite number"),
            "{message}"
        );
    }
}
