//! `stiction inspect`: what a file of recordings holds, as it is understood.

use crate::output;
use crate::reading_args::Reading as ReadingArgs;
use anyhow::Result;
use clap::Parser;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;
use stiction::recording::{Channel, Mode, Modes, Quality, RangeSource, Recording};
use stiction_io::layout::Recognised;
use stiction_io::reading::{self, Format, Reading};
use stiction_io::timestamp::Clock;

/// Show what files of recordings hold: format, times, columns, loops, bad samples, ranges.
///
/// Every column is listed with what it is taken to be, and why. What is taken wrongly can be said with
/// the options, or for many files in a mapping file.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction inspect FIC101.csv
  stiction inspect export.csv --zone Europe/Berlin --map op=OUT --map vp=ZT
  stiction inspect week.csv --mapping plant.toml --json

A mapping file:
  zone = \"Europe/Berlin\"
  pattern = \"{loop}.{signal}\"       # how tags are built
  bad_text = [\"Kaputt\"]
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
    /// Files to show
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    reading: ReadingArgs,
}

pub fn run(args: Args) -> Result<()> {
    let options = args.reading.options()?;
    let mut shown = vec![];
    for file in &args.files {
        let reading = reading::read(file, &options)?;
        if args.json {
            shown.push(to_json(&reading));
        } else {
            let between = if file == &args.files[0] { "" } else { "\n" };
            output::write(None, format!("{between}{}", text(&reading)).as_bytes())?;
        }
    }
    if args.json {
        let tool = concat!("stiction ", env!("CARGO_PKG_VERSION"));
        let all = json!({ "tool": tool, "files": shown });
        output::line(serde_json::to_string_pretty(&all)?)?;
    }
    Ok(())
}

/// The signals of a recording that are numbers, by name.
fn channels(recording: &Recording) -> impl Iterator<Item = (&'static str, &Channel)> {
    [
        ("OP", Some(&recording.op)),
        ("PV", recording.pv.as_ref()),
        ("SP", recording.sp.as_ref()),
        ("VP", recording.vp.as_ref()),
    ]
    .into_iter()
    .filter_map(|(name, channel)| Some((name, channel?)))
}

/// The earliest and latest time of a recording's OP, s on its clock.
fn span(recording: &Recording) -> (f64, f64) {
    ends(&recording.op.time)
}

fn ends(values: &[f64]) -> (f64, f64) {
    let known = values.iter().filter(|value| value.is_finite());
    known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// How many samples are of each quality that occurs.
fn counts(channel: &Channel) -> Vec<(&'static str, usize)> {
    [
        ("good", Quality::Good),
        ("uncertain", Quality::Uncertain),
        ("bad", Quality::Bad),
        ("missing", Quality::Missing),
    ]
    .into_iter()
    .map(|(name, quality)| (name, channel.quality.iter().filter(|q| **q == quality).count()))
    .filter(|(_, count)| *count > 0)
    .collect()
}

fn mode_counts(modes: &Modes) -> Vec<(&'static str, usize)> {
    [
        ("automatic", Mode::Automatic),
        ("cascade", Mode::Cascade),
        ("manual", Mode::Manual),
        ("other", Mode::Other),
    ]
    .into_iter()
    .map(|(name, mode)| (name, modes.modes.iter().filter(|m| **m == mode).count()))
    .filter(|(_, count)| *count > 0)
    .collect()
}

fn source(source: RangeSource) -> &'static str {
    match source {
        RangeSource::Given => "given",
        RangeSource::Metadata => "from the file",
        RangeSource::Estimated => "estimated",
    }
}

fn clock(clock: &Clock) -> String {
    match clock {
        Clock::Utc => "UTC".to_owned(),
        Clock::Zone(zone) => zone.clone(),
        Clock::Local => "no zone".to_owned(),
        Clock::Elapsed => "from an unknown start".to_owned(),
    }
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

/// A number with as many digits as one wants to see; all of them are in the JSON.
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

fn text(reading: &Reading) -> String {
    let mut out = String::new();
    // Writing to a text cannot fail.
    let _ = write_text(reading, &mut out);
    out
}

fn write_text(reading: &Reading, out: &mut String) -> std::fmt::Result {
    writeln!(out, "{}", reading.origin)?;
    let format = match reading.format {
        Format::Csv(dialect) => format!(
            "CSV, {}, delimiter {}, decimal mark {}",
            dialect.encoding,
            delimiter(dialect.delimiter),
            dialect.decimal_mark.mark()
        ),
        other => other.name().to_owned(),
    };
    let time = &reading.time;
    let column =
        time.column.as_ref().map_or(String::new(), |column| format!("column \"{column}\", "));
    writeln!(out, "  format  {format}")?;
    writeln!(out, "  sha256  {}", reading.sha256)?;
    writeln!(out, "  times   {column}{}, {}", time.format, clock(&time.clock))?;
    writeln!(out, "  layout  {}", reading.layout.name())?;
    writeln!(out, "columns")?;
    let name = |each: &Recognised| match &*each.part {
        "" => each.column.clone(),
        part => format!("{part}.{}", each.column),
    };
    let role = |each: &Recognised| match &each.loop_name {
        Some(loop_name) => format!("{} of {loop_name}", each.role),
        None => each.role.to_string(),
    };
    let widest = |text: &dyn Fn(&Recognised) -> String| {
        reading.recognised.iter().map(|each| text(each).chars().count()).max().unwrap_or(0)
    };
    let (wide, wider) = (widest(&name), widest(&role));
    for each in &reading.recognised {
        writeln!(out, "  {:wide$}  {:wider$}  {}", name(each), role(each), each.why)?;
    }
    for recording in &reading.recordings {
        let (first, last) = span(recording);
        let show = |t| time.clock.show(recording.start, t);
        writeln!(out, "loop {}, {}", recording.name, recording.loop_type.name())?;
        writeln!(out, "  from {} to {}, {} s", show(first), show(last), last - first)?;
        for (name, channel) in channels(recording) {
            let (low, high) = ends(&channel.values);
            let values = if low <= high {
                format!(", {} to {}", short(low), short(high))
            } else {
                String::new()
            };
            let unit = channel.unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
            let range = channel.range.map_or(String::new(), |range| {
                format!(", range {} to {} ({})", range.low, range.high, source(range.source))
            });
            writeln!(out, "  {name:4}  {}{values}{unit}{range}", list(&counts(channel)))?;
        }
        if let Some(modes) = &recording.mode {
            writeln!(out, "  mode  {}", list(&mode_counts(modes)))?;
        }
        for note in &recording.notes {
            writeln!(out, "  note: {note}")?;
        }
    }
    for note in &reading.notes {
        writeln!(out, "note: {note}")?;
    }
    Ok(())
}

fn to_json(reading: &Reading) -> Value {
    let dialect = match reading.format {
        Format::Csv(dialect) => Some(dialect),
        _ => None,
    };
    let columns: Vec<Value> = reading
        .recognised
        .iter()
        .map(|each| {
            json!({
                "part": each.part,
                "column": each.column,
                "role": each.role.to_string(),
                "loop": each.loop_name,
                "why": each.why,
            })
        })
        .collect();
    let time = &reading.time;
    json!({
        "file": reading.origin,
        "sha256": reading.sha256,
        "format": reading.format.name(),
        "encoding": dialect.map(|d| d.encoding),
        "delimiter": dialect.map(|d| d.delimiter.to_string()),
        "decimal_mark": dialect.map(|d| d.decimal_mark.mark().to_string()),
        "layout": reading.layout.name(),
        "times": { "column": time.column, "format": time.format, "zone": clock(&time.clock) },
        "columns": columns,
        "loops": reading.recordings.iter().map(|r| loop_json(r, &time.clock)).collect::<Vec<_>>(),
        "notes": reading.notes,
    })
}

fn loop_json(recording: &Recording, clock: &Clock) -> Value {
    let counts_json = |counts: Vec<(&'static str, usize)>| {
        let entries = counts.into_iter().map(|(name, count)| (name.to_owned(), count.into()));
        Value::Object(entries.collect())
    };
    let signal = |channel: &Channel| {
        let (low, high) = ends(&channel.values);
        json!({
            "samples": channel.values.len(),
            "quality": counts_json(counts(channel)),
            "lowest": low.is_finite().then_some(low),
            "highest": high.is_finite().then_some(high),
            "unit": channel.unit,
            "range": channel.range.map(|range| json!({
                "low": range.low, "high": range.high, "source": source(range.source),
            })),
        })
    };
    let signals = channels(recording).map(|(name, c)| (name.to_lowercase(), signal(c))).collect();
    let (first, last) = span(recording);
    json!({
        "name": recording.name,
        "type": recording.loop_type.name(),
        "start_s": recording.start,
        "first": clock.show(recording.start, first),
        "last": clock.show(recording.start, last),
        "duration_s": last - first,
        "signals": Value::Object(signals),
        "modes": recording.mode.as_ref().map(|modes| counts_json(mode_counts(modes))),
        "notes": recording.notes,
    })
}
