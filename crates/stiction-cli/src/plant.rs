//! `stiction plant`: all loops of a plant, day by day.

use crate::files::{self, Out};
use crate::{output, progress, replaced, watch};
use anyhow::{Context, Result, anyhow, bail};
use clap::{Parser, Subcommand};
use schemars::JsonSchema;
use serde::Serialize;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;
use stiction::diagnose::VerdictClass;
use stiction::spoken::counted;
use stiction_plant::inputs::{self, Changes, Problem};
use stiction_plant::log::{self, Entry, Kind};
use stiction_plant::orders::{Order, orders, to_do};
use stiction_plant::overrides;
use stiction_plant::plant_file::{self, Plant};
use stiction_plant::report::{self, Known, ReportOptions, Reported};
use stiction_plant::scan::{Manifest, Progress};
use stiction_plant::unknown::{self, Unknown};
use stiction_plant::week::Week;
use stiction_plant::{ScanOptions, day, demo, propose, scan, summary};

/// Judge all loops of a plant, day by day, and keep the results.
///
/// A plant is a folder with plant.toml, which names its data. Each day of a loop gets its own verdict. The results are kept
/// as Parquet in .stiction beside plant.toml, so that the next scan judges only new data.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction plant demo --loops 8 --days 2 -o north
  stiction plant -C north check
  stiction plant -C north scan
  stiction plant -C north status
  stiction plant -C north report --week 2026-W10
  stiction plant -C north note FIC1001 \"new packing\" --repair --day 2026-03-04
  stiction plant -C north override FIC1003 \"does not stick\" --reason \"stroked on the bench\"
  stiction plant -C refinery init export
  stiction plant -C refinery init opc.tcp://server:4840")]
pub struct Args {
    /// The folder of the plant; all paths are relative to this folder
    #[arg(short = 'C', long = "folder", value_name = "PLANT", default_value = ".", global = true)]
    // Read and written under the guard of the store, so not a file of a run.
    folder: String,
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Propose plant.toml for files or folders of data, with open questions as comments
    Init(Init),
    /// Read plant.toml and all data without judging them, and list loops, days and problems
    #[command(after_help = EXIT_CODES)]
    Check {
        /// Print the results as JSON
        #[arg(long)]
        json: bool,
    },
    /// Judge new days and changed files. May be interrupted at any time
    Scan(Scan),
    /// Summarise the results so far, and list what was not read or judged
    #[command(after_help = STATUS_CODES)]
    Status {
        /// Print the results as JSON
        #[arg(long)]
        json: bool,
    },
    /// Write the page and the tables of a week: actions, changes and work orders
    Report(Report),
    /// Print the work orders of a week
    Orders(Orders),
    /// Enter a person's verdict on a valve, which is shown beside the computed verdict and decides the action
    Override(Override),
    /// Enter a note about a loop, a repair of its valve, or a placed work order
    Note(Note),
    /// Remove a loop from the work list until a day
    Snooze(Snooze),
    /// Write a simulated plant with known truth, for a trial: plant.toml, data, truth.csv
    Demo(Demo),
}

#[derive(Parser)]
#[command(after_help = "Examples:
  stiction plant -C north report
  stiction plant -C north report --week 2026-W10 --pages 50
  stiction plant -C north report --fail-on new-sticking  # exit code 1 if a valve newly sticks")]
struct Report {
    /// The week, such as 2026-W10 [default: the last one with windows]
    #[arg(long, value_name = "WEEK")]
    week: Option<Week>,
    /// Write a page for this many of the worst loops, besides the loops that changed, are watched or need a valve test
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pages: u32,
    /// End with exit code 1 in this case
    #[arg(long, value_name = "WHAT")]
    fail_on: Option<FailOn>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

/// Conditions on which a report can fail.
#[derive(Clone, Copy, clap::ValueEnum)]
enum FailOn {
    /// A valve sticks now and did not stick before, and its loop is not snoozed
    NewSticking,
}

#[derive(Parser)]
struct Orders {
    /// The week, such as 2026-W10 [default: the last one with windows]
    #[arg(long, value_name = "WEEK")]
    week: Option<Week>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Parser)]
#[command(after_help = "Examples:
  stiction plant override FIC101 \"does not stick\" --reason \"stroked on the bench\" --by \"J. Miller\"
  stiction plant override FIC102 sticks --reason \"seen at the stem\" --until 2026-06-30")]
struct Override {
    /// The loop
    #[arg(value_name = "TAG")]
    tag: String,
    /// The verdict: sticks, does not stick, does not respond, or cannot tell; cannot tell removes an override
    #[arg(value_parser = VerdictClass::by_name)]
    verdict: VerdictClass,
    /// The reason, in words
    #[arg(long)]
    reason: String,
    /// The last day on which the override holds
    #[arg(long, value_name = "DAY", value_parser = day::parse)]
    until: Option<i64>,
    #[command(flatten)]
    by: By,
}

#[derive(Parser)]
#[command(after_help = "Examples:
  stiction plant note FIC101 \"hunts since the turnaround\"
  stiction plant note FIC101 \"new packing\" --repair --day 2026-03-04
  stiction plant note FIC101 \"WO 4711\" --order")]
struct Note {
    /// The loop
    #[arg(value_name = "TAG")]
    tag: String,
    /// The text of the note
    text: String,
    /// The valve was repaired on the day of the entry, so earlier data no longer count
    #[arg(long)]
    repair: bool,
    /// A work order was placed
    #[arg(long, conflicts_with = "repair")]
    order: bool,
    #[command(flatten)]
    by: By,
}

#[derive(Parser)]
#[command(after_help = "Examples:
  stiction plant snooze FIC101 --until 2026-03-23 \"ordered, WO 4711\"")]
struct Snooze {
    /// The loop
    #[arg(value_name = "TAG")]
    tag: String,
    /// The day on which the loop returns to the list
    #[arg(long, value_name = "DAY", value_parser = day::parse)]
    until: i64,
    /// The reason
    #[arg(default_value = "", hide_default_value = true)]
    text: String,
    #[command(flatten)]
    by: By,
}

/// Author and day of an entry.
#[derive(Parser)]
struct By {
    /// The name of the person [default: the user of this system]
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
    /// The day of the event, instead of today
    #[arg(long, value_name = "DAY", value_parser = day::parse)]
    day: Option<i64>,
}

#[derive(Parser)]
struct Init {
    /// CSV, Parquet, Excel or MATLAB files, folders of them, or the address of a server or database
    #[arg(required = true, value_name = "DATA")]
    data: Vec<String>,
    /// Options for an address, which "python -m stiction.live init --help" lists
    #[arg(last = true, value_name = "OPTION")]
    options: Vec<String>,
}

/// Exit codes of a scan and of a check.
const EXIT_CODES: &str = "Exit codes:
  0  all recordings were read, and a scan has judged everything new
  2  some files or loops could not be read, each with a message, and a scan has judged the others;
     or nothing could be done, and a single message says why

A table without an OP and without times, such as a list of tags, is not a recording. A note lists it.";

/// Exit codes of a status.
const STATUS_CODES: &str = "Exit codes:
  0  all files and loops were read, with a PV each, and no window has an error
  2  a file or loop was not read, a loop has no PV, or a window has an error, each listed with the
     reason; or nothing could be done, and a single message says why";

#[derive(Parser)]
#[command(after_help = EXIT_CODES)]
struct Scan {
    /// Fetch new rows from this database first, such as postgres://reader@host/plant?table=samples
    #[arg(value_name = "ADDRESS")]
    from: Option<String>,
    /// Judge windows from this day on, such as 2026-03-01
    #[arg(long, value_name = "DAY", value_parser = day::parse)]
    since: Option<i64>,
    /// Judge only loops whose names match this pattern, such as "FIC*"
    #[arg(long, value_name = "GLOB")]
    loops: Option<String>,
    /// Threads to use [default: as many as the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Memory to use, such as 500MB or 2GB; files other than Parquet are always read whole
    #[arg(long, value_name = "SIZE", value_parser = size, default_value = "500MB")]
    memory: u64,
    /// Judge everything again, not only new data
    #[arg(long)]
    again: bool,
    /// Longest time to judge a window. If a window takes longer, its row has an error
    /// [default: time_limit_s in plant.toml, or 300]
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(1..))]
    time_limit: Option<u32>,
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
    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR")]
    output: Out,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let folder = Path::new(&args.folder);
    match args.task {
        Task::Init(of) => init(folder, &of),
        Task::Check { json } => check(folder, json),
        Task::Scan(of) => scanned(folder, &of),
        Task::Status { json } => status(folder, json),
        Task::Report(of) => reported(folder, &of),
        Task::Orders(of) => ordered(folder, &of).map(|()| ExitCode::SUCCESS),
        Task::Override(of) => {
            let entry = (Kind::Override, Some(of.verdict), of.until, of.reason);
            enter(folder, &of.tag, entry, of.by).map(|()| ExitCode::SUCCESS)
        }
        Task::Note(of) => {
            let kind = match (of.repair, of.order) {
                (true, _) => Kind::Repair,
                (_, true) => Kind::Order,
                _ => Kind::Note,
            };
            enter(folder, &of.tag, (kind, None, None, of.text), of.by).map(|()| ExitCode::SUCCESS)
        }
        Task::Snooze(of) => {
            let entry = (Kind::Snooze, None, Some(of.until), of.text);
            enter(folder, &of.tag, entry, of.by).map(|()| ExitCode::SUCCESS)
        }
        Task::Demo(of) => demonstrate(folder, &of).map(|()| ExitCode::SUCCESS),
    }
}

fn init(folder: &Path, of: &Init) -> Result<ExitCode> {
    if of.data.iter().any(|data| watch::is_address(data)) {
        let mut collector = watch::collector("init")?;
        let force = replaced::is_forced().then_some("--force");
        return watch::ended(
            collector.arg("-C").arg(folder).args(force).args(&of.options).args(&of.data),
        );
    }
    let path = folder.join(plant_file::NAME);
    replaced::check_absent(&path)?;
    let whole = std::fs::canonicalize(folder).with_context(|| folder.display().to_string())?;
    let name =
        whole.file_name().map_or("plant".to_owned(), |name| name.to_string_lossy().into_owned());
    let found = propose::propose(folder, &name, &of.data)?;
    output::write(Some(&Out::also(&path)?), found.text.as_bytes())?;
    let (loops, files, doubts) = (found.loops, found.files, found.doubts.len());
    output::line(format!(
        "{} in {}, {}; see {}",
        counted(loops, "loop"),
        counted(files, "file"),
        counted(doubts, "doubt"),
        path.display()
    ))?;
    Ok(ExitCode::SUCCESS)
}

fn check(folder: &Path, json: bool) -> Result<ExitCode> {
    let plant = Plant::read(folder)?;
    let bar = progress::bar("reading", inputs::paths(folder, &plant).len());
    let checked = summary::check(folder, &plant, |_| bar.inc(1));
    bar.finish_and_clear();
    checked.no_recordings.iter().for_each(output::note);
    if json {
        output::json(&checked)?;
    } else {
        let mut text = String::new();
        for each in &checked.loops {
            let span = |day: &Option<String>| day.clone().unwrap_or("-".to_owned());
            let known = if each.in_plant_file { "" } else { "  not in plant.toml" };
            text += &format!(
                "{}  {} days, {} to {}{known}\n",
                output::name(&each.name),
                each.days,
                span(&each.first_day),
                span(&each.last_day)
            );
            let range = each.op_range.map(|[low, high]| format!("OP {low} to {high}"));
            let modes =
                (!each.modes.is_empty()).then(|| format!("modes {}", each.modes.join(", ")));
            let said = each.tags.iter().cloned().chain(range).chain(modes).collect::<Vec<_>>();
            if !said.is_empty() {
                text += &output::name(&format!("  {}", said.join("; ")));
                text += "\n";
            }
            for note in &each.notes {
                text += &output::name(&format!("  ? {note}"));
                text += "\n";
            }
        }
        text += &format!("{} loops in {} files\n", checked.loops.len(), checked.files);
        output::write(None, text.as_bytes())?;
    }
    ended(checked.files, &checked.problems)
}

/// Prints the problems, which make the exit code 2. A plant without data files is an error.
fn ended(files: usize, problems: &[Problem]) -> Result<ExitCode> {
    if files == 0 {
        bail!("no file matches data in {}", plant_file::NAME);
    }
    for problem in problems {
        let _ = writeln!(std::io::stderr(), "stiction: {}", problem.words());
    }
    Ok(if problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(2) })
}

/// The numbers of new, changed and missing data files since the last scan, in brackets.
fn different(changes: &Changes) -> String {
    let kinds =
        [(&changes.new, "new"), (&changes.changed, "changed"), (&changes.missing, "missing")];
    let said = kinds.into_iter().filter(|(files, _)| !files.is_empty());
    let said: Vec<String> = said.map(|(files, what)| format!("{} {what}", files.len())).collect();
    if said.is_empty() { String::new() } else { format!(" ({})", said.join(", ")) }
}

/// Bytes, from text such as `500MB` or `2GB`.
fn size(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic() || c == ' ');
    let unit: u64 = match text[digits.len()..].trim().to_ascii_uppercase().as_str() {
        "MB" => 1 << 20,
        "GB" => 1 << 30,
        _ => return Err("give it in MB or GB, such as 500MB".to_owned()),
    };
    let number: f64 = digits.parse().map_err(|_| format!("\"{digits}\" is not a number"))?;
    let bytes = number * unit as f64;
    if !(64.0 * 1048576.0..=1e15).contains(&bytes) {
        return Err("must be at least 64MB".to_owned());
    }
    Ok(bytes as u64)
}

fn scanned(folder: &Path, of: &Scan) -> Result<ExitCode> {
    if let Some(address) = &of.from {
        let mut collector = watch::collector("fetch")?;
        let fetched = watch::ended(collector.arg("-C").arg(folder).arg(address))?;
        if fetched != ExitCode::SUCCESS {
            return Ok(fetched);
        }
    }
    let plant = Plant::read(folder)?;
    let options = ScanOptions {
        since: of.since,
        loops: of.loops.clone(),
        threads: of.threads.map(usize::from),
        memory: Some(of.memory),
        again: of.again,
        time_limit_s: of.time_limit,
    };
    let mut bar = progress::bar("reading", inputs::paths(folder, &plant).len());
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
    done.damaged.iter().chain(&done.no_recordings).for_each(output::note);
    if of.json {
        output::json(&done)?;
    } else {
        let run = done.run.as_ref().map_or("nothing new".to_owned(), |run| format!("run {run}"));
        output::line(format!(
            "{} judged, {} of them with an error; {} loops in {} files{}; {run}",
            counted(done.windows, "window"),
            done.errors,
            done.loops,
            done.files,
            different(&done.changes)
        ))?;
        let not_known = not_known(&done.unknown);
        output::write(None, not_known.as_bytes())?;
    }
    ended(done.files, &done.problems)
}

fn status(folder: &Path, json: bool) -> Result<ExitCode> {
    let plant = Plant::read(folder)?;
    let status = summary::status(folder, &plant)?;
    status.damaged.iter().for_each(output::note);
    if let Some(last) = &status.last_day
        && *last > overrides::today().to_string()
    {
        output::note(format!(
            "the last day, {last}, lies in the future; check the clocks of the data and of this computer"
        ));
    }
    // A tag may belong to no loop, and a loop in manual has nothing to judge.
    let is_fault =
        |each: &Unknown| !matches!(each.kind, unknown::Kind::Tag | unknown::Kind::Window);
    let code = match status.errors > 0 || status.unknown.iter().any(is_fault) {
        true => ExitCode::from(2),
        false => ExitCode::SUCCESS,
    };
    if json {
        return output::json(&status).map(|()| code);
    }
    let span = match (&status.first_day, &status.last_day) {
        (Some(first), Some(last)) => format!(", {first} to {last}"),
        _ => String::new(),
    };
    let mut text = format!(
        "{}: {}, {}{span}, {}, {} with an error, {}\n",
        status.plant,
        counted(status.loops, "loop"),
        counted(status.days, "day"),
        counted(status.windows, "window"),
        status.errors,
        counted(status.runs, "run")
    );
    for each in status.grades.iter().filter(|each| each.windows > 0) {
        text += &format!("{:>15}: {}\n", counted(each.windows, "window"), each.grade);
    }
    if status.time_limited > 0 {
        text += &format!(
            "{} reached the time limit; scan again with a longer --time-limit\n",
            counted(status.time_limited, "window")
        );
    }
    if status.cut_short > 0 {
        text += &format!(
            "{} did not finish; scan again to judge the rest\n",
            counted(status.cut_short, "run")
        );
    }
    for sentence in status.changes.words() {
        text += &format!("{}\n", output::name(&sentence));
    }
    text += &not_known(&status.unknown);
    for each in &status.unknown {
        text += &format!("  {}: {}\n", each.kind.name(), output::name(&each.words()));
    }
    output::write(None, text.as_bytes())?;
    Ok(code)
}

/// A line with the counts of what is not known; empty if all is known.
fn not_known(all: &[Unknown]) -> String {
    match unknown::counted_words(all) {
        words if words.is_empty() => words,
        words => format!("not known: {words}\n"),
    }
}

fn reported(folder: &Path, of: &Report) -> Result<ExitCode> {
    let plant = Plant::read(folder)?;
    let options = ReportOptions { week: of.week, pages: of.pages as usize };
    let bar = progress::bar("writing pages", options.pages);
    let done: Reported = report::write(folder, &plant, &options, || bar.inc(1))?;
    bar.finish_and_clear();
    if of.json {
        output::json(&done)?;
    } else {
        let mut text = format!(
            "{}, week {}: {} loops, {} judged\n",
            done.plant, done.week, done.loops, done.judged
        );
        for each in done.actions.iter().filter(|each| each.loops > 0) {
            text += &format!("{:7} {}\n", each.loops, each.action.name());
        }
        for each in &done.changes {
            let mut said = each
                .day
                .as_ref()
                .map_or(each.change.name().to_owned(), |day| each.change.since(day));
            if let (Some(from), Some(to)) = (&each.from, &each.to)
                && from != to
            {
                said += &format!(" ({from} to {to})");
            }
            text += &format!("{}: {said}\n", output::name(&each.name));
        }
        let page = folder.join(&done.folder).join(stiction_plant::page::INDEX);
        let mut orders = counted(done.orders, "work order");
        if done.orders_closed > 0 {
            orders += &format!(", {} closed by a test", done.orders_closed);
        }
        text += &not_known(&done.unknown);
        text += &format!("{orders}; see {}\n", page.display());
        output::text(&text)?;
    }
    done.problems.iter().for_each(output::note);
    Ok(match of.fail_on {
        Some(FailOn::NewSticking) if done.new_sticking > 0 => ExitCode::from(1),
        _ => ExitCode::SUCCESS,
    })
}

/// The work orders of a week, as the JSON of a command.
#[derive(Debug, Serialize, JsonSchema)]
pub struct OrdersOfWeek {
    /// Name of the plant.
    plant: String,
    /// The week, such as `2026-W10`.
    week: String,
    /// The orders, the most important first.
    orders: Vec<Order>,
}

fn ordered(folder: &Path, of: &Orders) -> Result<()> {
    let plant = Plant::read(folder)?;
    let known = Known::of(folder, &plant, of.week)?;
    let mut ranking = known.ranking(&plant);
    report::size_tests(folder, &plant, &mut ranking).iter().for_each(output::note);
    let document = OrdersOfWeek {
        plant: ranking.plant.clone(),
        week: ranking.week.to_string(),
        orders: orders(&ranking),
    };
    if of.json {
        return output::json(&document);
    }
    let mut text = String::new();
    for each in &document.orders {
        text += &format!(
            "{}, {}: {}\n  {}\n  test: {}\n",
            output::name(&each.name),
            each.status.name(),
            each.finding,
            each.evidence,
            each.test
        );
        if let Some(note) = &each.note {
            text += &format!("  {}\n", output::name(note));
        }
    }
    let orders = counted(to_do(&document.orders), "order");
    output::text(&format!("{text}{orders}, {}, week {}\n", document.plant, document.week))
}

/// The content of an entry: kind, verdict, last day, and text.
type EntryContent = (Kind, Option<VerdictClass>, Option<i64>, String);

fn enter(
    folder: &Path,
    tag: &str,
    (kind, verdict, until, text): EntryContent,
    by: By,
) -> Result<()> {
    let plant = Plant::read(folder)?;
    let name = log::known_loop(folder, &plant, tag)?;
    let day = match by.day {
        Some(day) => day,
        None => day::parse(&overrides::today().to_string()).map_err(|e| anyhow!(e))?,
    };
    if let Some(until) = until.filter(|until| *until < day) {
        bail!(
            "--until {} is before {}, the day of the entry; give a later day, or with --day the day of the entry",
            day::date(until),
            day::date(day)
        );
    }
    let entry = Entry {
        kind,
        name: name.clone(),
        day,
        by: by.by.or_else(|| whoami::username().ok()),
        until,
        verdict,
        text,
    };
    log::enter(folder, &entry)?;
    let kept = folder.join(log::NAME);
    output::entered(output::name(&format!("{name}: {}; kept in {}", entry.words(), kept.display())))
}

fn demonstrate(folder: &Path, of: &Demo) -> Result<()> {
    let folder = folder.join(&*of.output);
    files::make_empty_folder(&folder)?;
    let bar = progress::bar("simulating", of.loops as usize);
    demo::write(&folder, of.loops as usize, of.days as usize, of.seed, || bar.inc(1))?;
    bar.finish_and_clear();
    output::line(format!("{} loops, {} days; see {}", of.loops, of.days, folder.display()))
}
