//! `stiction inspect`: shows how a file of recordings is interpreted.

use crate::files::In;
use crate::output::{self, name as shown};
use crate::reading_args::Reading as ReadingArgs;
use crate::together;
use anyhow::Result;
use clap::Parser;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use stiction_io::summary::{Column, Summary};

/// Show how files of recordings are interpreted: format, times, columns, loops, bad samples, ranges.
///
/// Every column is listed with its role and the reason. Correct wrong roles with options, or for many files with a
/// mapping file.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction inspect FIC101.csv
  stiction inspect export.csv --zone Europe/Berlin --map op=OUT --map vp=ZT
  stiction inspect week.csv --mapping plant.toml --json

A mapping file:
  zone = \"Europe/Berlin\"
  pattern = \"{loop}.{signal}\"       # how tags are built
  bad_text = [\"Kaputt\"]
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
    /// Files to show; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<In>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    reading: ReadingArgs,
}

/// What `stiction inspect --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// The program that made it, with its version.
    tool: &'static str,
    /// The files, in the given order.
    files: Vec<Summary>,
}

pub fn run(args: Args) -> Result<()> {
    let options = args.reading.options_of(&args.files)?;
    let mut shown = vec![];
    for (k, reading) in together::recordings(&args.files, options, || ()).into_iter().enumerate() {
        let summary = Summary::from(&reading?);
        if args.json {
            shown.push(summary);
        } else {
            let between = if k == 0 { "" } else { "\n" };
            output::text(&format!("{between}{}", text(&summary)))?;
        }
    }
    if args.json {
        output::json(&Document { tool: output::TOOL, files: shown })?;
    }
    Ok(())
}

fn list(counts: &[(&str, usize)]) -> String {
    counts.iter().map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", ")
}

fn delimiter(delimiter: char) -> String {
    match delimiter {
        '\t' => "tab".to_owned(),
        ',' => "comma".to_owned(),
        ';' => "semicolon".to_owned(),
        other => other.to_string(),
    }
}

/// A number with at most six digits. The JSON has all digits.
fn short(number: f64) -> String {
    let decade = number.abs().log10().floor();
    match decade {
        -4.0..9.0 => {
            let unit = 10f64.powi(5 - decade as i32);
            ((number * unit).round() / unit).to_string()
        }
        _ if number == 0.0 => "0".to_owned(),
        _ => format!("{number:.5e}"),
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
    let times = &summary.times;
    let column = times
        .column
        .as_ref()
        .map_or(String::new(), |column| format!("column \"{}\", ", shown(column)));
    writeln!(out, "  format  {format}")?;
    writeln!(out, "  sha256  {}", summary.sha256)?;
    writeln!(out, "  times   {column}{}, {}", times.format, times.zone)?;
    writeln!(out, "  layout  {}", summary.layout)?;
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
    for each in &summary.loops {
        writeln!(out, "loop {}, {}", shown(&each.name), each.loop_type)?;
        writeln!(out, "  from {} to {}, {} s", each.first, each.last, each.duration_s)?;
        for (name, signal) in &each.signals {
            let values = match (signal.lowest, signal.highest) {
                (Some(low), Some(high)) => format!(", {} to {}", short(low), short(high)),
                _ => String::new(),
            };
            let unit =
                signal.unit.as_ref().map_or(String::new(), |unit| format!(" {}", shown(unit)));
            let range = signal.range.map_or(String::new(), |range| {
                format!(", range {} to {} ({})", range.low, range.high, range.source)
            });
            let name = name.to_uppercase();
            writeln!(out, "  {name:4}  {}{values}{unit}{range}", list(&signal.quality))?;
        }
        if let Some(modes) = &each.modes {
            writeln!(out, "  mode  {}", list(modes))?;
        }
        for note in &each.notes {
            writeln!(out, "  note: {}", shown(note))?;
        }
    }
    for note in &summary.notes {
        writeln!(out, "note: {}", shown(note))?;
    }
    Ok(())
}
