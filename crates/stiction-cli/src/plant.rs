//! `stiction plant`: all loops of a plant, day by day.

use crate::files::Out;
use crate::{output, progress};
use anyhow::{Context, Result, anyhow, bail};
use clap::{Parser, Subcommand};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;
use stiction_plant::inputs::{Inputs, Problem};
use stiction_plant::plant_file::{self, Plant};
use stiction_plant::scan::{Manifest, Progress};
use stiction_plant::{ScanOptions, Store, day, demo, propose, scan};

/// Judge all loops of a plant, day by day, and keep what was found.
///
/// A plant is a folder with plant.toml, which names its data. Every loop is judged for every day, and the
/// results are kept in .stiction beside it as Parquet, so that the next scan judges only what is new.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction plant demo --loops 8 --days 2 -o north
  stiction plant -C north check
  stiction plant -C north scan
  stiction plant -C north status
  stiction plant -C refinery init export")]
pub struct Args {
    /// The folder of the plant; all paths are from there on
    #[arg(short = 'C', long = "folder", value_name = "PLANT", default_value = ".", global = true)]
    // Read and written, within what the store guards: no file of a run.
    folder: String,
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Propose plant.toml for files or folders of data, with doubts as comments
    Init(Init),
    /// Read plant.toml and all data: which loops and days are there, and what is wrong; judges nothing
    Check {
        /// Print the results as JSON
        #[arg(long)]
        json: bool,
    },
    /// Judge what is new: days that were not there, files that have changed. It may be ended at any time
    Scan(Scan),
    /// Tell what was judged so far
    Status {
        /// Print the results as JSON
        #[arg(long)]
        json: bool,
    },
    /// Write a plant with known truth, to try all this on: plant.toml, data, truth.csv
    Demo(Demo),
}

#[derive(Parser)]
struct Init {
    /// Files, or folders of files: CSV, Parquet, MATLAB
    #[arg(required = true, value_name = "DATA")]
    data: Vec<String>,
    /// Write over a plant.toml that is there
    #[arg(long)]
    force: bool,
}

#[derive(Parser)]
struct Scan {
    /// Judge windows from this day on, such as 2026-03-01
    #[arg(long, value_name = "DAY", value_parser = day::parse)]
    since: Option<i64>,
    /// Judge loops whose names fit this pattern, such as "FIC*"
    #[arg(long, value_name = "GLOB")]
    loops: Option<String>,
    /// Threads to use [default: as many as the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Memory to use, such as 500MB or 2GB; files other than Parquet are read whole all the same
    #[arg(long, value_name = "SIZE", value_parser = size, default_value = "500MB")]
    memory: u64,
    /// Judge all again, not only what is new
    #[arg(long)]
    again: bool,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Parser)]
struct Demo {
    /// Number of loops
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    loops: u32,
    /// Number of days
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=400))]
    days: u32,
    /// Seed of the plant
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: Out,
    /// Write to a folder that is not empty
    #[arg(long)]
    force: bool,
}

/// What a plant's data hold.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Checked {
    /// Name of the plant.
    plant: String,
    /// Files that the plant's file names.
    files: usize,
    /// Loops in them.
    loops: Vec<LoopThere>,
    /// What is wrong.
    problems: Vec<Problem>,
}

/// A loop that the data hold.
#[derive(Debug, Serialize, JsonSchema)]
struct LoopThere {
    /// Its tag.
    #[serde(rename = "loop")]
    name: String,
    /// Days with samples.
    days: usize,
    /// The first of them.
    first_day: Option<String>,
    /// The last of them.
    last_day: Option<String>,
    /// Whether the plant's file knows it.
    in_plant_file: bool,
}

/// What was judged so far.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Status {
    /// Name of the plant.
    plant: String,
    /// Loops with a window.
    loops: usize,
    /// Days of the plant with a window.
    days: usize,
    /// The first of them.
    first_day: Option<String>,
    /// The last of them.
    last_day: Option<String>,
    /// Windows that count.
    windows: usize,
    /// Of these, windows that could not be judged.
    errors: usize,
    /// Windows by grade, the worst first.
    grades: Vec<Graded>,
    /// Runs, and of these those that did not come to their end.
    runs: usize,
    /// Runs that were cut short.
    cut_short: usize,
}

/// How many windows have a grade.
#[derive(Debug, Serialize, JsonSchema)]
struct Graded {
    /// The grade.
    grade: &'static str,
    /// Windows.
    windows: usize,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let folder = Path::new(&args.folder);
    match args.task {
        Task::Init(of) => init(folder, &of).map(|()| ExitCode::SUCCESS),
        Task::Check { json } => check(folder, json),
        Task::Scan(of) => scanned(folder, &of),
        Task::Status { json } => status(folder, json).map(|()| ExitCode::SUCCESS),
        Task::Demo(of) => demonstrate(folder, &of).map(|()| ExitCode::SUCCESS),
    }
}

fn init(folder: &Path, of: &Init) -> Result<()> {
    let path = folder.join(plant_file::NAME);
    if path.exists() && !of.force {
        bail!("{} is there already; --force writes over it", path.display());
    }
    let whole = std::fs::canonicalize(folder).with_context(|| folder.display().to_string())?;
    let name =
        whole.file_name().map_or("plant".to_owned(), |name| name.to_string_lossy().into_owned());
    let found = propose::propose(folder, &name, &of.data)?;
    output::write(Some(&Out::also(&path)?), found.text.as_bytes())?;
    let (loops, files, doubts) = (found.loops, found.files, found.doubts.len());
    output::line(format!("{loops} loops in {files} files, {doubts} doubts; see {}", path.display()))
}

fn check(folder: &Path, json: bool) -> Result<ExitCode> {
    let plant = Plant::read(folder)?;
    // What the store knows of the files is used, and left as it is.
    let mut inputs = Inputs::known(&Store::of(folder), &plant);
    let files = stiction_plant::inputs::paths(folder, &plant)?.len();
    let bar = progress::bar("reading", files);
    inputs.update(folder, &plant, |_| bar.inc(1))?;
    bar.finish_and_clear();
    let loops = inputs.days();
    let there = loops.iter().map(|(name, days)| LoopThere {
        name: (*name).to_owned(),
        days: days.len(),
        first_day: days.keys().next().map(|day| day::date(*day)),
        last_day: days.keys().last().map(|day| day::date(*day)),
        in_plant_file: plant.facts(name).is_some(),
    });
    let checked = Checked {
        plant: plant.file.name.clone(),
        files,
        loops: there.collect(),
        problems: inputs.problems(&plant),
    };
    if json {
        output::json(&checked)?;
    } else {
        let mut text = String::new();
        for each in &checked.loops {
            let span = |day: &Option<String>| day.clone().unwrap_or("-".to_owned());
            let known = if each.in_plant_file { "" } else { "  not in plant.toml" };
            text += &format!(
                "{}  {} days, {} to {}{known}\n",
                each.name,
                each.days,
                span(&each.first_day),
                span(&each.last_day)
            );
        }
        text += &format!("{} loops in {files} files\n", checked.loops.len());
        output::write(None, text.as_bytes())?;
    }
    ended(files, &checked.problems)
}

/// Tells the problems; without a file, or with a problem, what was asked could not all be done.
fn ended(files: usize, problems: &[Problem]) -> Result<ExitCode> {
    if files == 0 {
        bail!("no file is there that data in {} names", plant_file::NAME);
    }
    for problem in problems {
        let _ = writeln!(std::io::stderr(), "stiction: {}", problem.words());
    }
    Ok(if problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(2) })
}

/// Bytes, from such as `500MB` or `2GB`.
fn size(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic() || c == ' ');
    let unit: u64 = match text[digits.len()..].trim().to_ascii_uppercase().as_str() {
        "MB" => 1 << 20,
        "GB" => 1 << 30,
        _ => return Err("give it in MB or GB, such as 500MB".to_owned()),
    };
    let number: f64 = digits.parse().map_err(|_| format!("\"{digits}\" is no number"))?;
    let bytes = number * unit as f64;
    if !(64.0 * 1048576.0..=1e15).contains(&bytes) {
        return Err("must be 64MB at least".to_owned());
    }
    Ok(bytes as u64)
}

fn scanned(folder: &Path, of: &Scan) -> Result<ExitCode> {
    let plant = Plant::read(folder)?;
    let options = ScanOptions {
        since: of.since,
        loops: of.loops.clone(),
        threads: of.threads.map(usize::from),
        memory: Some(of.memory),
        again: of.again,
    };
    let mut bar = progress::bar("reading", stiction_plant::inputs::paths(folder, &plant)?.len());
    let mut judging = false;
    let done: Manifest = scan(folder, &plant, &options, |now| {
        match now {
            Progress::Looked(_) => bar.inc(1),
            Progress::Written { done, of } => {
                if !judging {
                    bar.finish_and_clear();
                    bar = progress::bar("judging", of);
                    judging = true;
                }
                bar.set_position(done as u64);
            }
        }
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    if of.json {
        output::json(&done)?;
    } else {
        let run =
            done.run.as_ref().map_or("nothing was new".to_owned(), |run| format!("run {run}"));
        output::line(format!(
            "{} windows judged, {} of them with an error; {} loops in {} files; {run}",
            done.windows, done.errors, done.loops, done.files
        ))?;
    }
    ended(done.files, &done.problems)
}

fn status(folder: &Path, json: bool) -> Result<()> {
    let plant = Plant::read(folder)?;
    let store = Store::of(folder);
    let rows = store.rows()?;
    let runs = store.run_names()?;
    let cut_short = runs.iter().map(|run| store.manifest(run)).collect::<Result<Vec<_>, _>>()?;
    let loops: BTreeSet<&str> = rows.iter().map(|row| &*row.name).collect();
    let days: BTreeSet<i64> =
        rows.iter().map(|row| day::of(row.window_start as f64, &plant.zone)).collect();
    let graded = |grade: stiction::diagnose::Grade| Graded {
        grade: grade.name(),
        windows: rows.iter().filter(|row| row.grade.as_deref() == Some(grade.name())).count(),
    };
    let status = Status {
        plant: plant.file.name.clone(),
        loops: loops.len(),
        days: days.len(),
        first_day: days.first().map(|day| day::date(*day)),
        last_day: days.last().map(|day| day::date(*day)),
        windows: rows.len(),
        errors: rows.iter().filter(|row| row.error.is_some()).count(),
        grades: stiction::diagnose::Grade::ALL.map(graded).into_iter().collect(),
        runs: runs.len(),
        cut_short: cut_short.iter().filter(|manifest| manifest.is_none()).count(),
    };
    if json {
        return output::json(&status);
    }
    let span = match (&status.first_day, &status.last_day) {
        (Some(first), Some(last)) => format!(", {first} to {last}"),
        _ => String::new(),
    };
    let mut text = format!(
        "{}: {} loops, {} days{span}, {} windows, {} with an error, {} runs\n",
        status.plant, status.loops, status.days, status.windows, status.errors, status.runs
    );
    for each in status.grades.iter().filter(|each| each.windows > 0) {
        text += &format!("{:7} {}\n", each.windows, each.grade);
    }
    if status.cut_short > 0 {
        text += &format!(
            "{} runs did not come to their end; scan again judges what they left\n",
            status.cut_short
        );
    }
    output::write(None, text.as_bytes())
}

fn demonstrate(folder: &Path, of: &Demo) -> Result<()> {
    let folder = folder.join(&*of.output);
    let named = || folder.display().to_string();
    std::fs::create_dir_all(&folder).with_context(named)?;
    if !of.force && std::fs::read_dir(&folder).with_context(named)?.next().is_some() {
        return Err(anyhow!("{} is not empty; --force writes to it", named()));
    }
    let bar = progress::bar("simulating", of.loops as usize);
    demo::write(&folder, of.loops as usize, of.days as usize, of.seed, || bar.inc(1))?;
    bar.finish_and_clear();
    output::line(format!("{} loops, {} days; see {}", of.loops, of.days, named()))
}
