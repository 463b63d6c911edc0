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
use clap::{Parser, Subcommand, ValueEnum};
use entrants::Source;
use measure::{Measured, Plan};
use program::How;
use serde::Serialize;
use std::path::Path;
use std::time::Duration;
use stiction::diagnose::{Detectors, DiagnoseOptions};
use stiction::population::{Invention, Operator, Trend};
use stiction::score::bench::leaderboard;
use stiction::score::bench::results::{Detector, Results};
use stiction::score::page::{self, Scoreboard};
use stiction::score::{TestTrialOptions, TestedLoops};
use stiction::scoreboard::{Board, MethodRow, Share};
use stiction_report::report::Table;

/// Measure the accuracy of the verdict and of every method on simulated or labelled loops.
///
/// Prints recall, false alarms, the ranking by each statistic, and the quality of probabilities and estimates, with
/// 95 % intervals. No threshold is ever fitted. The same command prints the same bytes on any number of threads,
/// except for the times of --time.
#[derive(Parser)]
#[command(
    subcommand_required = true,
    after_help = "Examples:
  stiction bench simulated 1000
  stiction bench simulated 10000 --only verdict --report board.html
  stiction bench invented 300 --only verdict
  stiction bench labels plant/index.csv --report board.html --reports reports --csv details.csv
  stiction bench tests 500 --careless
  stiction bench detector 'python3 mine.py' --suite v1-trial"
)]
pub struct Args {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Measure the accuracy on simulated loops of the mixed population
    #[command(after_help = "Examples:
  stiction bench simulated 1000
  stiction bench simulated 1000 --method horch --method kano")]
    Simulated {
        /// Number of members
        #[arg(value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        loops: u64,
        /// Add loops until each kind has this many [default: a twentieth of N]
        #[arg(long, value_name = "M", value_parser = clap::value_parser!(u64).range(0..=100_000))]
        per_kind: Option<u64>,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        measuring: Measuring,
    },
    /// Measure on kinds of loops on which the verdict was not trained, half of them healthy
    #[command(after_help = "Examples:
  stiction bench invented 300 --only verdict
  stiction bench invented 300 --set first --only verdict")]
    Invented {
        /// Number of loops of each kind
        #[arg(value_name = "N", value_parser = clap::value_parser!(u64).range(2..=100_000))]
        loops: u64,
        /// The set of kinds; the training has a kind like one of the first set, and the third set is newer than the training
        #[arg(long, value_enum, value_name = "SET", default_value = "second")]
        set: InventedSet,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        measuring: Measuring,
    },
    /// Measure on loops with a recorded valve position and any process lag
    #[command(after_help = "Examples:
  stiction bench positions 1000 --only verdict")]
    Positions {
        /// Number of loops
        #[arg(value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        loops: u64,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        measuring: Measuring,
    },
    /// Measure on labelled recordings
    ///
    /// The index is a CSV with the columns loop and label. The label is stiction, no stiction, or empty for loops to skip.
    /// Optional columns are loop_type, tag (the valve), file, columns, source and licence. Without file, the recording of
    /// a loop is LOOP.csv beside the index. The column named columns maps signals to columns of the file, such as "op=CV;
    /// pv=FLOW". Recordings must lie in the folder of the index, unless --allow-outside is given.
    #[command(after_help = "Examples:
  stiction bench labels plant/index.csv --report board.html --reports reports --csv details.csv")]
    Labels {
        /// Index of the recordings
        #[arg(value_name = "INDEX.csv")]
        index: In,
        /// Allow recordings outside the folder of the index
        #[arg(long)]
        allow_outside: bool,
        #[command(flatten)]
        measuring: Measuring,
    },
    /// Measure how often groups of loops that swing together, and their sources, are found
    #[command(after_help = "Examples:
  stiction bench networks 300")]
    Networks {
        /// Number of networks of coupled loops
        #[arg(value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
        networks: u64,
        /// Number of recorded days of each network
        #[arg(long, value_name = "DAYS", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=31))]
        days: u32,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        form: Form,
    },
    /// Measure how often a planned valve test is right
    #[command(after_help = "Examples:
  stiction bench tests 500 --careless
  stiction bench tests 500 --loops physical-stems")]
    Tests {
        /// Number of loops with a planned test
        #[arg(value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
        tests: u64,
        /// The loops to test
        #[arg(long, value_enum, default_value = "population")]
        loops: Loops,
        /// Vary the holds from 50 to 150 % of their length, and skip or resize one reversal in five
        #[arg(long)]
        careless: bool,
        /// Record the test with the loop's own historian and its compression
        #[arg(long)]
        historian: bool,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        form: Form,
    },
    /// Measure a program of your own, or the verdict and the methods, on a suite or on labelled recordings
    ///
    /// The program reads one recording as JSON from each line of standard input, and answers with one line of JSON.
    /// If no loop is answered, the exit code is 2. Without a program, the verdict and the methods answer the same loops.
    #[command(after_help = "Examples:
  stiction bench detector 'python3 mine.py' --suite v1-trial
  stiction bench detector 'python3 mine.py' --suite v1 --json > mine.json
  stiction bench detector --suite v1 --json > ours.json")]
    Detector(DetectorArgs),
    #[command(flatten)]
    Exchange(tasks::Task),
}

/// The methods beside the verdict.
#[derive(clap::Args)]
struct Methods {
    /// Run only this method beside the verdict; may be given several times
    #[arg(long = "method", value_name = "NAME", conflicts_with = "only")]
    methods: Vec<String>,
    /// Compute only the verdict, without any method
    #[arg(long)]
    only: Option<Only>,
}

impl Methods {
    fn detectors(&self) -> Result<Detectors> {
        Ok(match (self.only, &self.methods[..]) {
            (Some(Only::Verdict), _) => Detectors::None,
            (None, []) => Detectors::All,
            (None, names) => {
                let named = names.iter().map(|name| name.parse()).collect::<stiction::Result<_>>();
                Detectors::Only(named?)
            }
        })
    }
}

/// The form of what is printed.
#[derive(clap::Args)]
pub(crate) struct Form {
    /// Print the tables in Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

impl Form {
    /// Prints a document as JSON, or tables below a text.
    fn print(&self, document: &impl Serialize, head: &str, tables: &[Table]) -> Result<()> {
        if self.json {
            return output::json(document);
        }
        let of = |table: &Table| if self.markdown { table.markdown() } else { text::plain(table) };
        let tables: Vec<String> = tables.iter().map(of).collect();
        output::text(&(head.to_owned() + &tables.join("\n")))
    }
}

/// A table of counts and shares.
fn shares(caption: String) -> Table {
    Table::new(caption).words("of").words("those").numbers("number", "").numbers("share", "")
}

/// A row of counts and shares.
fn shared(table: Table, of: &str, those: &str, is: Share) -> Table {
    table.row([of.to_owned(), those.to_owned(), is.n.to_string(), page::share(is)])
}

#[derive(clap::Args)]
struct Seed {
    /// Seed of the simulated loops; the verdict was trained on seed 1, so it is more accurate on seed 1 than on new loops
    #[arg(long, default_value_t = 101, value_name = "SEED")]
    seed: u64,
}

/// What is computed for each loop, and written.
#[derive(clap::Args)]
struct Measuring {
    #[command(flatten)]
    methods: Methods,
    /// Also time the diagnosis and each method
    #[arg(long)]
    time: bool,
    #[command(flatten)]
    form: Form,
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

#[derive(Parser)]
struct DetectorArgs {
    /// The program, a command for the shell [default: the verdict and the methods]
    #[arg(value_name = "COMMAND", conflicts_with_all = ["methods", "only"])]
    command: Option<String>,
    /// The suite: v1, v1-trial or v1-training
    #[arg(long, value_name = "SUITE", default_value = "v1", conflicts_with = "labels")]
    suite: String,
    /// Measure on the hidden half of the suite, with the passphrase in STICTION_BENCH_PASSPHRASE
    #[arg(long, conflicts_with = "labels")]
    hidden: bool,
    /// Index of labelled recordings, as for `stiction bench labels`
    #[arg(long, value_name = "INDEX.csv")]
    labels: Option<In>,
    /// Allow recordings outside the folder of the index
    #[arg(long, requires = "labels")]
    allow_outside: bool,
    /// Name of your detector, shown in the results [default: its command]
    #[arg(long, value_name = "NAME", requires = "command")]
    name: Option<String>,
    /// Version of your detector, shown in the results
    #[arg(long, value_name = "VERSION", requires = "command")]
    detector_version: Option<String>,
    /// Time for an answer, s
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = seconds, requires = "command")]
    limit: f64,
    /// Additional time for the first answer after a start, s
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds, requires = "command")]
    startup: f64,
    /// Number of copies of the program that run in parallel [default: one for each core]
    #[arg(long, value_name = "N", requires = "command", value_parser = clap::value_parser!(u32).range(1..=1024))]
    processes: Option<u32>,
    #[command(flatten)]
    methods: Methods,
    #[command(flatten)]
    form: Form,
    /// Write the results as a self-contained HTML page to this file
    #[arg(long, value_name = "FILE")]
    report: Option<Out>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Only {
    Verdict,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum InventedSet {
    First,
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
    /// Loops of the simulated population
    Population,
    /// The kinds on which the verdict was not trained
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

/// A time in an argument, s.
fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 86_400.0 => Ok(value),
        _ => Err("must be a number of seconds above 0, at most 86400".to_owned()),
    }
}

pub fn run(args: Args) -> Result<()> {
    match args.task {
        Task::Exchange(task) => tasks::run(task),
        Task::Detector(args) => compared(&args),
        Task::Networks { networks, days, seed, form } => {
            networks::run(seed.seed, networks, days, &form)
        }
        Task::Tests { tests, loops, careless, historian, seed, form } => {
            let options = TestTrialOptions {
                loops: loops.into(),
                operator: if careless { Operator::Careless } else { Operator::Careful },
                trend: if historian { Trend::Historian } else { Trend::AsPlanned },
            };
            planned_tests::run(seed.seed, tests, options, &form)
        }
        Task::Simulated { loops, per_kind, seed, measuring } => {
            measured(&measuring, |plan| simulated::measure(seed.seed, loops, per_kind, plan))
        }
        Task::Invented { loops, set, seed, measuring } => {
            measured(&measuring, |plan| simulated::invented(set.kinds(), seed.seed, loops, plan))
        }
        Task::Positions { loops, seed, measuring } => {
            measured(&measuring, |plan| positions::measure(seed.seed, loops, plan))
        }
        Task::Labels { index, allow_outside, measuring } => {
            measured(&measuring, |plan| labelled::measure(&index, allow_outside, plan))
        }
    }
}

/// Measures the verdict and the methods, and writes the requested output.
fn measured(
    args: &Measuring,
    measure: impl FnOnce(&Plan<'_>) -> Result<(About, Measured)>,
) -> Result<()> {
    let detectors = args.methods.detectors()?;
    if let Some(folder) = &args.reports {
        folder.make_folder()?;
    }
    let plan = Plan {
        options: DiagnoseOptions {
            detectors,
            evidence: args.reports.is_some(),
            plan: args.reports.is_some(),
            ..DiagnoseOptions::default()
        },
        time: args.time,
        reports: args.reports.as_ref(),
    };
    let (about, measured) = measure(&plan)?;
    let board = Board::of(&measured.loops);
    output::given(&args.csv, || results::csv(&measured.loops))?;
    output::given(&args.report, || page(args, &about, &board, &measured))?;
    let width = if args.form.markdown { usize::MAX } else { 96 };
    let head = text::hanging("", &format!("{}. {}", about.title, about.origin), width) + "\n";
    let tables = tables(&board, &measured, args.form.markdown);
    args.form.print(&results::document(about, board, &measured), &head, &tables)
}

/// Measures a program, or the verdict and methods, on a suite or on labelled recordings.
fn compared(args: &DetectorArgs) -> Result<()> {
    let source = match &args.labels {
        Some(index) => Source::labels(index, args.allow_outside)?,
        None => Source::suite(&args.suite, args.hidden)?,
    };
    let loops = source.loops();
    if loops.suite.is_none() {
        entrants::check(&loops.labels)?;
    }
    // Why a program answered nothing.
    let mut silent = None;
    let (asked, entries) = match &args.command {
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
            let detectors = args.methods.detectors()?;
            let options = DiagnoseOptions { detectors, plan: false, ..DiagnoseOptions::default() };
            entrants::own(&source, &options)?
        }
    };
    let results = Results::of(output::TOOL, loops, &asked, entries);
    output::given(&args.report, || leaderboard::html(&results, &asked))?;
    entrants::print(&results, &args.form)?;
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

fn page(args: &Measuring, about: &About, board: &Board, measured: &Measured) -> Result<String> {
    let folder = args.report.as_ref().and_then(|path| path.parent());
    let folder = folder.filter(|folder| !folder.as_os_str().is_empty());
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
