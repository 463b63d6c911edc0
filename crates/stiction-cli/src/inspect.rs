//! `stiction inspect`: shows how a file of recordings is interpreted.

use crate::files::{self, In, Out};
use crate::input;
use crate::output::{self, name as shown};
use crate::reading_args::Reading as ReadingArgs;
use crate::replaced;
use crate::together;
use anyhow::{Result, bail};
use clap::Parser;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use stiction::recording::understood::Row;
use stiction_io::summary::{Column, Loop, Summary};
use stiction_io::{ReadOptions, Reading};

/// Show how files of recordings are interpreted: columns, units, ranges, zone, samples, repairs.
///
/// A table for each loop shows its columns as signals, with unit, values and range, and the data left out or repaired.
/// A second table lists the reason for the role of every column. Correct mistakes with options, or for many files with
/// a mapping file. --write-map writes a mapping file with everything that was recognised.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction inspect FIC101.csv
  stiction inspect export.csv --zone Europe/Berlin --map op=OUT --map vp=ZT
  stiction inspect export.csv --map op_range=4,20 --map FIC101.type=level --map modes.16=auto
  stiction inspect export.csv --write-map export.toml
  stiction inspect week.csv --mapping plant.toml --json

Example of a mapping file; each line can also be an option, as in --map zone=Europe/Berlin --map FIC101.pv_range=0,120:
  zone = \"Europe/Berlin\"
  pattern = \"{loop}.{signal}\"       # how tags are built
  bad_text = [\"Kaputt\"]
  bad_value = [-1, 4095]           # more numbers that are no measurements
  [columns]                        # a column's role, as of --map
  \"10FC102.OP\" = \"FIC102.op\"
  spare = \"ignore\"
  [signals]
  pv = [\"PV\", \"MEAS\"]
  [modes]
  \"3\" = \"auto\"                     # auto, cascade, manual or other
  [quality]
  \"7\" = \"bad\"                      # good, uncertain or bad
  [loop.FIC101]
  pv = \"10FT101.DACA\"
  op = \"10FC101.OP\"
  type = \"flow\"
  pv_range = [0, 120]")]
pub struct Args {
    /// Files to show, or folders of them; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<In>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Write a mapping file that states how FILE was interpreted; correct it, and give it to --mapping
    #[arg(long, value_name = "TOML")]
    write_map: Option<Out>,
    #[command(flatten)]
    reading: ReadingArgs,
}

/// What `stiction inspect --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// The program that wrote the document, with its version.
    tool: &'static str,
    /// The files, in the given order.
    files: Vec<Summary>,
}

pub fn run(args: Args) -> Result<()> {
    let files = files::with_folders(&args.files)?;
    let mut options = args.reading.options_of(&files)?;
    let mut shown = vec![];
    let summaries: Vec<Result<Summary>> = match (&args.write_map, &files[..], &mut options[..]) {
        (None, ..) => together::read(&files, options, || ()),
        (Some(path), [file], [own]) => {
            let own = std::mem::replace(own, Ok(ReadOptions::default()))?;
            vec![Ok(Summary::from(&written(file, &own, path)?))]
        }
        (Some(_), ..) => bail!("--write-map writes the mapping of one file; name only one"),
    };
    if args.write_map.as_ref().is_some_and(Out::is_standard) {
        return Ok(());
    }
    let (any, mut between) = (summaries.iter().any(Result::is_ok), "");
    for summary in summaries {
        let summary = match summary {
            Err(error) if any && files::is_skipped(&error, &args.files) => continue,
            summary => summary?,
        };
        if args.json {
            shown.push(summary);
        } else {
            output::text(&format!("{between}{}", text(&summary)))?;
            between = "\n";
        }
    }
    if args.json {
        output::json(&Document { tool: output::TOOL, files: shown })?;
    }
    Ok(())
}

/// Reads a file, and writes its mapping.
fn written(file: &In, options: &ReadOptions, path: &Out) -> Result<Reading> {
    if !path.is_standard() {
        replaced::check_absent(path)?;
    }
    let (reading, mapping) = input::with_mapping(file, options)?;
    output::write(Some(path), mapping.as_bytes())?;
    if !path.is_standard() {
        output::note(format!("wrote {}; give this file to --mapping", path.display()));
    }
    Ok(reading)
}

fn delimiter(delimiter: char) -> String {
    match delimiter {
        '\t' => "tab".to_owned(),
        ',' => "comma".to_owned(),
        ';' => "semicolon".to_owned(),
        other => other.to_string(),
    }
}

fn text(summary: &Summary) -> String {
    let mut out = String::new();
    // Writing to a text cannot fail.
    let _ = write_text(summary, &mut out);
    out
}

fn write_text(summary: &Summary, out: &mut String) -> std::fmt::Result {
    writeln!(out, "{}", shown(&summary.file))?;
    let format = match (summary.encoding, summary.delimiter, summary.decimal_mark) {
        (Some(encoding), Some(between), Some(mark)) => {
            format!("CSV, {encoding}, delimiter {}, decimal mark {mark}", delimiter(between))
        }
        _ => summary.format.to_owned(),
    };
    writeln!(out, "  format  {format}")?;
    writeln!(out, "  sha256  {}", summary.sha256)?;
    writeln!(out, "  layout  {}", summary.layout)?;
    for each in &summary.loops {
        write_loop(each, out)?;
    }
    writeln!(out, "columns")?;
    let name = |each: &Column| match &*each.part {
        "" => shown(&each.column).into_owned(),
        part => shown(&format!("{part}.{}", each.column)).into_owned(),
    };
    let role = |each: &Column| match &each.loop_name {
        Some(loop_name) => format!("{} of {}", each.role, shown(loop_name)),
        None => each.role.clone(),
    };
    let widest = |text: &dyn Fn(&Column) -> String| {
        summary.columns.iter().map(|each| text(each).chars().count()).max().unwrap_or(0)
    };
    let (wide, wider) = (widest(&name), widest(&role));
    for each in &summary.columns {
        writeln!(out, "  {:wide$}  {:wider$}  {}", name(each), role(each), shown(&each.why))?;
    }
    for note in &summary.notes {
        writeln!(out, "note: {}", shown(note))?;
    }
    Ok(())
}

/// The table of a loop. The times have their own line, because their cells are long.
fn write_loop(each: &Loop, out: &mut String) -> std::fmt::Result {
    writeln!(out, "loop {}, {}", shown(&each.name), each.loop_type)?;
    let (times, signals): (Vec<&Row>, Vec<&Row>) =
        each.understood.iter().partition(|row| row.signal == "time");
    for row in times {
        let column = match &*row.column {
            "" => String::new(),
            name => format!("\"{name}\""),
        };
        let cells = [&column, &row.unit, &row.range, &row.values, &row.samples];
        let cells: Vec<&str> =
            cells.into_iter().map(|cell| &**cell).filter(|cell| !cell.is_empty()).collect();
        writeln!(out, "  times   {}", shown(&cells.join(", ")))?;
        for change in &row.changes {
            writeln!(out, "          {change}")?;
        }
    }
    let [titles @ .., _] = Row::TITLES;
    let cells = signals.iter().map(|row| {
        let [cells @ .., _] = row.cells();
        cells.map(|cell| shown(&cell).into_owned())
    });
    let lines: Vec<[String; 6]> =
        std::iter::once(titles.map(|title| title.replace(" or zone", ""))).chain(cells).collect();
    let wide = |k: usize| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; 6] = std::array::from_fn(wide);
    for (k, line) in lines.iter().enumerate() {
        let padded = line.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        writeln!(out, "  {}", padded.collect::<Vec<_>>().join("  ").trim_end())?;
        // The first line has the titles.
        let changes: &[String] = if k == 0 { &[] } else { &signals[k - 1].changes };
        for change in changes {
            writeln!(out, "  {:indent$}  {}", "", shown(change), indent = widths[0])?;
        }
    }
    for note in &each.notes {
        writeln!(out, "  note: {}", shown(note))?;
    }
    Ok(())
}
