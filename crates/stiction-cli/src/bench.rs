//! `stiction bench`: accuracy of the verdict and of every method on loops with known truth.

mod entrants;
mod labelled;
mod measure;
mod networks;
mod planned_tests;
mod positions;
mod program;
mod results;
mod simulated;
mod tasks;

use crate::files::{In, Out};
use crate::{output, text};
pub use networks::Document as NetworksDocument;
pub use planned_tests::Document as TestsDocument;
pub use results::Document;
pub use stiction::score::bench::results::Results as ComparedDocument;

use anyhow::{Context, Result, anyhow};
use clap::{Parser, ValueEnum};
use entrants::Source;
use measure::{Measured, Plan};
use program::How;
use std::path::Path;
use std::time::Duration;
use stiction::diagnose::{Detectors, DiagnoseOptions};
use stiction::population::{Invention, Operator, Trend};
use stiction::score::bench::leaderboard;
use stiction::score::bench::results::{Detector, Results};
use stiction::score::page::{self, Scoreboard};
use stiction::score::{TestTrialOptions, TestedLoops};
use stiction::scoreboard::{Board, MethodRow};
use stiction_report::report::Table;
use tasks::Task;

/// Measure the accuracy of the verdict and of every method on simulated or labelled loops.
///
/// Prints recall, false alarms, the ranking by each statistic, and the quality of probabilities and estimates, with
/// 95 % intervals. No threshold is ever fitted. The same command prints the same bytes on any number of threads,
/// except for the times of --time.
///
/// An index of labelled recordings is a CSV with the columns loop and label. The label is stiction, no stiction, or
/// empty for loops to skip. Optional columns are loop_type, tag (the valve), file, columns, source and licence. Without
/// file, the recording of a loop is LOOP.csv beside the index. The column columns maps signals to columns of the file, such
/// as "op=CV; pv=FLOW". Recordings must lie in the folder of the index, unless --allow-outside is given.
///
/// With --detector, a program of your own is measured. It reads a recording as JSON in each line of its standard input,
/// and writes an answer as JSON in a line. Without any answer the exit code is 2. With --suite alone, the verdict and the
/// methods answer the same loops.
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "Examples:
  stiction bench --detector 'python3 mine.py' --suite v1-trial
  stiction bench --detector 'python3 mine.py' --suite v1 --json > mine.json
  stiction bench --simulated 1000
  stiction bench --simulated 10000 --only verdict --report board.html
  stiction bench --invented 300 --only verdict
  stiction bench --invented 300 --invented-set first --only verdict
  stiction bench --positions 1000 --only verdict
  stiction bench --networks 300
  stiction bench --tests 500 --careless
  stiction bench --tests 500 --loops physical-stems
  stiction bench --labels plant/index.csv --report board.html --reports reports --csv details.csv")]
pub struct Args {
    #[command(subcommand)]
    task: Option<Task>,
    /// Measure this program, a command for the shell [default: the verdict and the methods]
    #[arg(long, value_name = "COMMAND",
          conflicts_with_all = ["simulated", "invented", "positions", "networks", "tests", "methods", "only", "time",
                                "csv", "reports"])]
    detector: Option<String>,
    /// Measure on the suite v1, v1-trial or v1-training [default with --detector: v1]
    #[arg(long, value_name = "SUITE",
          conflicts_with_all = ["labels", "simulated", "invented", "positions", "networks", "tests", "time", "csv",
                                "reports"])]
    suite: Option<String>,
    /// Measure on the hidden half of the suite, by the passphrase in STICTION_BENCH_PASSPHRASE
    #[arg(long, requires = "suite")]
    hidden: bool,
    /// Name of the detector in results [default: its command]
    #[arg(long, value_name = "NAME", requires = "detector")]
    name: Option<String>,
    /// Version of the detector in results
    #[arg(long, value_name = "VERSION", requires = "detector")]
    detector_version: Option<String>,
    /// Time for an answer, s
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = seconds, requires = "detector")]
    limit: f64,
    /// Additional time for the first answer after a start, s
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds, requires = "detector")]
    startup: f64,
    /// Run the program so many times side by side [default: one for each core]
    #[arg(long, value_name = "N", requires = "detector",
          value_parser = clap::value_parser!(u32).range(1..=1024))]
    processes: Option<u32>,
    /// Index of labelled recordings
    #[arg(long, value_name = "INDEX.csv",
          required_unless_present_any = ["simulated", "invented", "positions", "networks", "tests", "detector",
                                         "suite"])]
    labels: Option<In>,
    /// Let the index name recordings outside its folder
    #[arg(long, requires = "labels")]
    allow_outside: bool,
    /// Simulate this many members of the mixed population
    #[arg(long, value_name = "N", conflicts_with = "labels",
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    simulated: Option<u64>,
    /// Simulate this many loops of each kind that the verdict was not trained on, half of them healthy
    #[arg(long, value_name = "N", conflicts_with_all = ["labels", "simulated"],
          value_parser = clap::value_parser!(u64).range(2..=100_000))]
    invented: Option<u64>,
    /// Choose the set of these kinds; the first belongs to an earlier training [default: second]
    #[arg(long, value_name = "SET", requires = "invented",
          conflicts_with_all = ["labels", "simulated", "positions", "networks"])]
    invented_set: Option<InventedSet>,
    /// Simulate this many loops with a recorded valve position and any process lag
    #[arg(long, value_name = "N", conflicts_with_all = ["labels", "simulated", "invented"],
          value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    positions: Option<u64>,
    /// Simulate this many networks of coupled loops, to measure how often groups and sources are found
    #[arg(long, value_name = "N",
          conflicts_with_all = ["labels", "simulated", "invented", "positions", "methods", "only", "time", "csv",
                                "report", "reports"],
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    networks: Option<u64>,
    /// Simulate this many loops with a planned test, to measure how often the test is right
    #[arg(long, value_name = "N",
          conflicts_with_all = ["labels", "simulated", "invented", "positions", "networks", "methods", "only", "time",
                                "csv", "report", "reports"],
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    tests: Option<u64>,
    /// With --tests, the loops to test
    #[arg(long, value_enum, requires = "tests", default_value = "population")]
    loops: Loops,
    /// With --tests, vary the holds from 50 to 150 % of their length, and skip or resize one of five reversals
    #[arg(long, requires = "tests")]
    careless: bool,
    /// With --tests, record the test with the loop's own historian and its compression
    #[arg(long, requires = "tests")]
    historian: bool,
    /// Days recorded of each network [default: 3]
    #[arg(long, value_name = "DAYS", requires = "networks",
          value_parser = clap::value_parser!(u32).range(1..=31))]
    days: Option<u32>,
    /// Add loops until there are this many of each kind [default: one for twenty members]
    #[arg(long, value_name = "M", requires = "simulated",
          value_parser = clap::value_parser!(u64).range(0..=100_000))]
    per_kind: Option<u64>,
    /// Seed of the simulated loops; on seed 1, which it was trained on, the verdict is better than on fresh loops
    #[arg(long, default_value_t = 101, value_name = "SEED")]
    seed: u64,
    /// Run only this method beside the verdict; may be given several times
    #[arg(long = "method", value_name = "NAME", conflicts_with = "only")]
    methods: Vec<String>,
    /// Compute only the verdict, without any published method
    #[arg(long)]
    only: Option<Only>,
    /// Also time the diagnosis and each method
    #[arg(long)]
    time: bool,
    /// Print the tables in Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Write statistics, decisions and truth of every loop to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<Out>,
    /// Write a self-contained HTML page with tables, figures and all loops to this file
    #[arg(long, value_name = "FILE")]
    report: Option<Out>,
    /// Write the report of every loop to this folder; the page of --report links to them
    #[arg(long, value_name = "DIR")]
    reports: Option<Out>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Only {
    Verdict,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum InventedSet {
    First,
    #[default]
    Second,
    Third,
}

impl InventedSet {
    fn kinds(self) -> [Invention; 8] {
        match self {
            Self::First => Invention::FIRST,
            Self::Second => Invention::SECOND,
            Self::Third => Invention::THIRD,
        }
    }
}

/// The loops whose valves are tested.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Loops {
    /// Those of the simulated population
    Population,
    /// The kinds that the verdict was not trained on
    Invented,
    /// Ordinary loops whose valve is a physical stem
    PhysicalStems,
}

impl From<Loops> for TestedLoops {
    fn from(of: Loops) -> Self {
        match of {
            Loops::Population => Self::Population,
            Loops::Invented => Self::Invented,
            Loops::PhysicalStems => Self::PhysicalStems,
        }
    }
}

/// A time of an argument, s.
fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 86_400.0 => Ok(value),
        _ => Err("must be a number of seconds above 0, at most 86400".to_owned()),
    }
}

pub fn run(mut args: Args) -> Result<()> {
    if let Some(task) = args.task.take() {
        return tasks::run(task);
    }
    if let Some(n) = args.networks {
        return networks::run(args.seed, n, args.days.unwrap_or(3), args.json, args.markdown);
    }
    if let Some(n) = args.tests {
        let options = TestTrialOptions {
            loops: args.loops.into(),
            operator: if args.careless { Operator::Careless } else { Operator::Careful },
            trend: if args.historian { Trend::Historian } else { Trend::AsAsked },
        };
        return planned_tests::run(args.seed, n, options, args.json, args.markdown);
    }
    let detectors = match (args.only, &args.methods[..]) {
        (Some(Only::Verdict), _) => Detectors::None,
        (None, []) => Detectors::All,
        (None, names) => {
            Detectors::Only(names.iter().map(|name| name.parse()).collect::<stiction::Result<_>>()?)
        }
    };
    if args.detector.is_some() || args.suite.is_some() {
        return compared(&args, detectors);
    }
    if let Some(folder) = &args.reports {
        folder.make_folder()?;
    }
    let plan = Plan {
        options: DiagnoseOptions {
            detectors,
            evidence: args.reports.is_some(),
            ..DiagnoseOptions::default()
        },
        time: args.time,
        reports: args.reports.as_ref(),
    };
    let (about, measured) = match (&args.labels, args.invented, args.positions) {
        (Some(index), ..) => labelled::measure(index, args.allow_outside, &plan)?,
        (None, Some(n), _) => {
            let kinds = args.invented_set.unwrap_or_default().kinds();
            simulated::invented(kinds, args.seed, n, &plan)?
        }
        (None, None, Some(n)) => positions::measure(args.seed, n, &plan)?,
        (None, None, None) => {
            simulated::measure(args.seed, args.simulated.unwrap_or(1), args.per_kind, &plan)?
        }
    };
    let board = Board::of(&measured.loops);
    if let Some(path) = &args.csv {
        output::write(Some(path), results::csv(&measured.loops)?.as_bytes())?;
    }
    if let Some(path) = &args.report {
        output::write(Some(path), page(path, &args, &about, &board, &measured)?.as_bytes())?;
    }
    if args.json {
        return output::json(&results::document(about, board, &measured));
    }
    let print = if args.markdown { text::markdown } else { text::plain };
    let head = format!("{}. {}", about.title, about.origin);
    let width = if args.markdown { usize::MAX } else { 96 };
    let mut out: String = text::wrapped(&head, width).into_iter().map(|line| line + "\n").collect();
    for table in tables(&board, &measured, args.markdown) {
        out.push('\n');
        out += &print(&table);
    }
    output::text(&out)
}

/// Measures a program, or the verdict and methods, on a suite or on labelled recordings.
fn compared(args: &Args, detectors: Detectors) -> Result<()> {
    let source = match &args.labels {
        Some(index) => Source::labels(index, args.allow_outside)?,
        None => Source::suite(args.suite.as_deref().unwrap_or("v1"), args.hidden)?,
    };
    let loops = source.loops();
    if loops.suite.is_none() {
        entrants::check(&loops.labels)?;
    }
    // Why a program answered nothing.
    let mut silent = None;
    let (asked, entries) = match &args.detector {
        Some(command) => {
            let how = How {
                command: command.clone(),
                limit: Duration::from_secs_f64(args.limit),
                startup: Duration::from_secs_f64(args.startup),
            };
            let processes = args.processes.map(|n| n as usize);
            let (asked, answers) = entrants::program(&source, &how, processes)?;
            let detector = Detector {
                name: args.name.clone().unwrap_or_else(|| command.clone()),
                version: args.detector_version.clone().unwrap_or_default(),
                command: command.clone(),
            };
            let failures = answers.iter().map(|answer| answer.failure.clone());
            silent = failures.collect::<Option<Vec<_>>>().and_then(|all| all.into_iter().next());
            (asked, vec![(detector, answers)])
        }
        None => {
            let options =
                DiagnoseOptions { detectors, evidence: false, ..DiagnoseOptions::default() };
            entrants::own(&source, &options)?
        }
    };
    let results = Results::of(output::TOOL, loops, &asked, entries);
    if let Some(path) = &args.report {
        output::write(Some(path), leaderboard::html(&results, &asked)?.as_bytes())?;
    }
    entrants::print(&results, args.json, args.markdown)?;
    match silent {
        Some(why) => Err(anyhow!("the detector answered none of {} loops: {why}", asked.len())),
        None => Ok(()),
    }
}

/// Title and origin of the measured loops.
pub struct About {
    /// Such as `59 labelled recordings`.
    pub title: String,
    /// Where the loops come from, in sentences.
    pub origin: String,
}

/// All tables, in the order in which they are printed.
fn tables(board: &Board, measured: &Measured, markdown: bool) -> Vec<Table> {
    // Titles are long, and a terminal is narrow.
    let names = if markdown { MethodRow::title } else { MethodRow::name };
    let mut tables = vec![page::decisions(board, names)];
    if page::has_valves(board) {
        tables.push(page::decisions_on_valves(board, names));
    }
    let mut ranking = page::ranking(board, names);
    ranking.caption =
        "Ranking by each statistic (AUC), over recordings on which the method does not abstain. In the column \"of \
         all\", a pair with an unscored recording counts half."
            .to_owned();
    tables.push(ranking);
    tables.extend(page::by_kind(board));
    if markdown {
        tables.extend(page::methods_by_kind(board, names));
    }
    tables.extend(page::calibration(board));
    tables.extend(page::quantification(board));
    tables.extend(page::sureness(board));
    tables.extend(page::found(board));
    tables.extend(page::undecided(board));
    if !measured.times.is_empty() {
        tables.push(page::times(&measured.times));
    }
    tables
}

fn page(
    path: &Path,
    args: &Args,
    about: &About,
    board: &Board,
    measured: &Measured,
) -> Result<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let links = match &args.reports {
        Some(reports) => {
            let way = relative(folder.unwrap_or(Path::new(".")), reports)?;
            measured.reports.iter().map(|file| format!("{way}{file}")).collect()
        }
        None => vec![],
    };
    let page = Scoreboard {
        title: &about.title,
        introduction: &about.origin,
        board,
        loops: &measured.loops,
        reports: &links,
        times: &measured.times,
        tool: output::TOOL,
    };
    Ok(page::html(&page)?)
}

/// The relative path from one existing folder to another, with `/` between folders and at the end.
fn relative(from: &Path, to: &Path) -> Result<String> {
    let full = |path: &Path| path.canonicalize().with_context(|| path.display().to_string());
    let (from, to) = (full(from)?, full(to)?);
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let mut way = "../".repeat(from.components().count() - shared);
    for folder in to.components().skip(shared) {
        way += &folder.as_os_str().to_string_lossy();
        way.push('/');
    }
    Ok(way)
}

#[cfg(test)]
mod tests {
    use super::relative;
    use std::path::Path;

    #[test]
    fn ways_between_folders() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for (from, to, want) in [
            ("src", "src", ""),
            ("src", "src/bench", "bench/"),
            ("src/bench", "src", "../"),
            ("src/bench", "tests/cli", "../../tests/cli/"),
        ] {
            assert_eq!(relative(&root.join(from), &root.join(to)).unwrap(), want);
        }
        assert!(relative(root, &root.join("nonesuch")).is_err());
    }
}
