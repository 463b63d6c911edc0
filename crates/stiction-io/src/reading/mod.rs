//! Recordings from files of any format.

mod builder;
mod format;
pub mod join;
mod naming;
#[cfg(feature = "parquet")]
pub mod parted;
pub mod summary;
mod times;
mod written;

pub use format::Format;
pub use written::{mapping_of, same};

use crate::bytes;
use crate::cells::number::DecimalMark;
use crate::columns::layout::{self, Layout, MissingLoop, Plan, Recognised};
use crate::columns::options::ReadOptions;
use crate::error::{Error, Result};
use crate::names::list;
use crate::sheet::Sheet;
use crate::timestamp::{Clock, Times};
use builder::{Builder, no_op};
use format::sheets;
use naming::{Names, common_start};
use sha2::{Digest, Sha256};
use std::collections::HashSet;
use std::path::Path;
use stiction_diagnose::recording::Recording;

/// The notation of times in a part of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeColumn {
    /// Name of the column; none if rows are evenly spaced.
    pub column: Option<String>,
    /// Its notation, in words.
    pub format: String,
    /// The kind of its clock.
    pub clock: Clock,
}

impl TimeColumn {
    /// The notation of the `times` of a sheet.
    fn of(sheet: &Sheet, plan: &Plan, options: &ReadOptions, times: Times) -> Self {
        let used = plan.time.filter(|_| options.sample_time.is_none());
        Self {
            column: used.map(|column| sheet.columns[column].name.clone()),
            format: times.format,
            clock: times.clock,
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
    /// Its format.
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
    /// because one of their signals could not become a column. The notes list those with other signals in the file.
    pub missing: Vec<MissingLoop>,
    /// Names of recordings that are named after the file, because nothing in it names them.
    pub untagged: Vec<String>,
    /// Notes for the user on the whole file. Each recording has its own notes.
    pub notes: Vec<String>,
}

/// Reads the recordings in the file at `path`.
///
/// # Errors
/// If it cannot be read, or as for [`parse`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Reading> {
    parse(&bytes::read(path)?, &path.display().to_string(), options)
}

/// Reads recordings from `bytes`, whose format is detected from their beginning. `origin` is their name in errors,
/// and the name of a loop without another one.
///
/// # Errors
/// If the bytes are of no known format, or no column is known as a controller output; if a cell does not fit its
/// column and is not a known word; or if the times cannot be read.
pub fn parse(bytes: &[u8], origin: &str, options: &ReadOptions) -> Result<Reading> {
    let (format, sheets, notes) = sheets(bytes, origin)?;
    let sha256 = format!("{:x}", Sha256::digest(bytes));
    build(format, &sheets, notes, sha256, origin, options)
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

/// Reads recordings from a table in memory. Its origin is its name in errors, and the name of a loop without another
/// one.
///
/// # Errors
/// As for [`parse`], except for the format.
pub fn of_sheet(sheet: Sheet, options: &ReadOptions) -> Result<Reading> {
    let origin = sheet.origin.clone();
    build(Format::Memory, &[sheet], vec![], String::new(), &origin, options)
}

/// Reads recordings from the sheets of a file.
fn build(
    format: Format,
    sheets: &[Sheet],
    mut notes: Vec<String>,
    sha256: String,
    origin: &str,
    options: &ReadOptions,
) -> Result<Reading> {
    let mark = match format {
        Format::Csv(dialect) => dialect.decimal_mark,
        Format::Parquet | Format::Matlab | Format::Memory => DecimalMark::Point,
    };
    let names = Names { origin, parts: common_start(sheets), several: sheets.len() > 1 };
    let (mut recordings, mut recognised, mut first) = (vec![], vec![], None);
    let (mut missing, mut untagged): (Vec<MissingLoop>, _) = (vec![], vec![]);
    let mut without_op: Vec<&str> = vec![];
    for sheet in sheets {
        let plan = layout::recognise(sheet, options)?;
        recognised.extend(plan.recognised.iter().cloned());
        missing.extend(plan.missing.iter().cloned());
        let about = |note: &String| match &*sheet.part {
            "" => note.clone(),
            part => format!("{part}: {note}"),
        };
        notes.extend(sheet.notes.iter().chain(&plan.notes).map(about));
        if plan.loops.is_empty() {
            without_op.push(&*sheet.part);
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
        let builder = Builder::new(sheet, &plan, options, mark)?;
        notes.extend(builder.times.notes.iter().map(about));
        for each in plan.loops.iter().filter(|each| each.unread.is_none()) {
            let (name, tells) = names.of(each, sheet);
            if !tells {
                untagged.push(name.clone());
            }
            recordings.push(builder.recording(each, name)?);
        }
        first.get_or_insert((plan.layout, TimeColumn::of(sheet, &plan, options, builder.times)));
    }
    let Some((layout, time)) = first else {
        let lacking = missing.iter().max_by_key(|each| each.is_partly_here);
        let Some(lacking) = lacking else {
            return Err(no_op(origin, &recognised, options.wording));
        };
        let (origin, message) = (origin.to_owned(), lacking.reason.clone());
        return Err(match lacking.is_partly_here {
            true => Error::Table { origin, message },
            false => Error::NoOp { origin, message },
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
    let mut seen: HashSet<String> =
        recordings.iter().map(|read: &Recording| read.name.to_lowercase()).collect();
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
        recordings,
        recognised,
        missing,
        untagged,
        notes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sheet::{Cells, Column};
    use stiction_diagnose::recording::{LoopType, Quality};

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
        build(Format::Matlab, sheets, vec![], String::new(), "f.mat", options)
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
