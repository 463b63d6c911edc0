//! `stiction test`: plans and judges the test of a valve.

pub mod signature;

use crate::diagnose::ended;
use crate::files::{In, Out};
use crate::history::a_duration;
use crate::loops::{diagnose_all, find_all, only};
use crate::reading_args::Reading;
use crate::{output, text};
use anyhow::{Context, Result, anyhow, bail};
use clap::{Parser, Subcommand};
use schemars::JsonSchema;
use serde::Serialize;
use signature::Signed;
use std::process::ExitCode;
use stiction::diagnose::{Detectors, DiagnoseOptions, VerdictClass};
use stiction::recording::{ByHand, GridOptions, KnownBy, Recording, Set};
use stiction::valve_test::{
    Comparison, PlanOptions, ReadOptions, TestPlan, TestReading, before_test, compare, plan, read,
};
use stiction_io::timestamp::instant;
use stiction_report::document::Source;
use stiction_report::{report, valve_test_figure, valve_test_page, valve_test_sheet};

/// Plan a test that shows whether a valve sticks, and evaluate it.
///
/// In normal operation, stiction and a drifting load can look alike. In a test the operator moves the OP by hand, and
/// a healthy valve follows. `plan` sizes the test for the loop and prints the sheet. `read` finds the test in a
/// recording and judges the valve.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction test plan samples/LIC104-quantised.csv
  stiction test plan FIC101.csv --pv-low 40 --pv-high 60 --sheet sheet.html \\
    --json > FIC101.plan.json
  stiction test read samples/test/FIC106-tested.csv
  stiction test read FIC101-test.csv --plan FIC101.plan.json --done done.csv --json
  stiction test read FIC101-after.csv --before FIC101-before.csv --report repair.html")]
pub struct Args {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Size a test for a loop from a recording of its operation
    ///
    /// The sheet shows how far to turn the OP, how long to hold it, which PV change is an answer, and when to stop.
    /// Without limits for the PV, the test stays within the recorded PV range, widened by a quarter on either side. If
    /// the recording contains an inconclusive test, the plan is for the next test. The next test begins at 0.6 times the
    /// size that the PV answered, and has more turns of each size. With --signature, the plan is a slow ramp of the OP
    /// over the stroke and back. The ramp needs a recorded valve position (VP) and a process that tolerates the ramp.
    #[command(after_help = "Examples:
  stiction test plan FIC101.csv --sheet sheet.html
  stiction test plan FIC101.csv --signature --op-low 20 --op-high 80 --sheet sheet.html
  stiction test plan plant.parquet --loop FIC101 --pv-low 40 --pv-high 60 --csv steps.csv")]
    Plan(Plan),
    /// Find the test in a recording and judge the valve
    ///
    /// The turns come from the completed sheet, or else from the mode column, or else from an OP that alternates between
    /// held levels. The recording before the test is also evaluated. A recording with a valve position and slow ramps of
    /// the OP, up and down, is read as a signature. With --before, the test is compared with a test before a repair.
    #[command(after_help = "Examples:
  stiction test read FIC101-test.csv
  stiction test read FIC101-test.csv --done done.csv --plot answers.svg
  stiction test read FIC101-after.csv --before FIC101-before.csv --report repair.html

A completed sheet is a CSV file with the columns time and op. Each row has the time of an OP setting,
on the clock of the recording, and the new OP in percent. A row without op marks the return to
automatic. Other columns are ignored.")]
    Read(Read),
}

/// The loop and the sign of its gain.
#[derive(clap::Args)]
struct Of {
    /// A CSV, Parquet, Excel or MATLAB file; - is standard input
    #[arg(value_name = "FILE")]
    file: In,
    /// Tag of the loop, if the file has several
    #[arg(long = "loop", value_name = "TAG")]
    of_loop: Option<String>,
    /// The PV rises when the OP rises [default: from the controller action]
    #[arg(long)]
    rises: bool,
    /// The PV falls when the OP rises
    #[arg(long, conflicts_with = "rises")]
    falls: bool,
}

impl Of {
    fn rises(&self) -> Option<bool> {
        (self.rises || self.falls).then_some(self.rises)
    }

    /// The recording of the loop.
    fn recording(&self, reading: &Reading) -> Result<(Source, Recording)> {
        one_loop(&self.file, self.of_loop.as_ref(), reading)
    }
}

/// The recording of one loop.
fn one_loop(file: &In, of_loop: Option<&String>, reading: &Reading) -> Result<(Source, Recording)> {
    let loops: Vec<String> = of_loop.into_iter().cloned().collect();
    let (found, failures) = find_all(std::slice::from_ref(file), &loops, reading)?;
    ended(failures)?;
    let one = only(file, found, |each| &each.recording.name)?;
    Ok((one.source, one.recording))
}

#[derive(clap::Args)]
struct Plan {
    #[command(flatten)]
    of: Of,
    /// The lowest PV that the process tolerates, in PV units; the test stops 15 % of the tolerated range above it
    #[arg(long, value_name = "PV", requires = "pv_high", allow_negative_numbers = true)]
    pv_low: Option<f64>,
    /// The highest PV that the process tolerates, in PV units; the test stops 15 % of the tolerated range below it
    #[arg(long, value_name = "PV", requires = "pv_low", allow_negative_numbers = true)]
    pv_high: Option<f64>,
    /// The longest time in manual, such as 15min [default: 20min, or 40 holds of the first turn if that is longer, and at
    /// most 8h]
    #[arg(long, value_name = "DURATION", value_parser = a_duration)]
    time: Option<f64>,
    /// The completed sheet of an inconclusive test in the recording: a CSV file with the columns time and op
    #[arg(long, value_name = "DONE.csv")]
    done: Option<In>,
    /// Plan a signature instead: a slow ramp of the OP over the stroke and back, with recorded valve position
    #[arg(long, conflicts_with_all = ["pv_low", "pv_high", "time", "done", "rises", "falls"])]
    signature: bool,
    /// The lowest OP of a signature, percent
    #[arg(long, value_name = "OP", requires = "signature", default_value_t = 0.0)]
    op_low: f64,
    /// The highest OP of a signature, percent
    #[arg(long, value_name = "OP", requires = "signature", default_value_t = 100.0)]
    op_high: f64,
    /// Print the plan as JSON, for an automatic sequence or for `stiction test read --plan`
    #[arg(long)]
    json: bool,
    /// Write the turns to this CSV file, with columns to complete; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    csv: Option<Out>,
    /// Write the printable sheet to this file, one page of HTML
    #[arg(long, value_name = "OUT.html")]
    sheet: Option<Out>,
    #[command(flatten)]
    reading: Reading,
}

#[derive(clap::Args)]
struct Read {
    #[command(flatten)]
    of: Of,
    /// The plan of the test, from `stiction test plan --json`
    #[arg(long, value_name = "PLAN.json")]
    plan: Option<In>,
    /// The completed sheet: a CSV file with the columns time and op
    #[arg(long, value_name = "DONE.csv")]
    done: Option<In>,
    /// The recording of the test before the repair, for a comparison
    #[arg(long, value_name = "BEFORE")]
    before: Option<In>,
    /// The plan of the test before the repair
    #[arg(long, value_name = "PLAN.json", requires = "before")]
    before_plan: Option<In>,
    /// The completed sheet of the test before the repair
    #[arg(long, value_name = "DONE.csv", requires = "before")]
    before_done: Option<In>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Plot the PV answers against the OP turns in this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<Out>,
    /// Write a page for your records to this file, in HTML
    #[arg(long, value_name = "OUT.html")]
    report: Option<Out>,
    /// End with exit code 1 if the valve sticks or does not respond
    #[arg(long)]
    fail: bool,
    #[command(flatten)]
    reading: Reading,
}

/// The output of `stiction test plan --json`.
#[derive(Serialize, JsonSchema)]
pub struct PlanDocument {
    /// The program that wrote the document, with its version.
    tool: &'static str,
    /// The file of the recording.
    source: Source,
    /// The test.
    plan: TestPlan,
}

/// A loop with its test.
#[derive(Serialize, JsonSchema)]
struct Tested {
    /// Tag of the loop.
    name: String,
    /// The file of the recording.
    source: Source,
    /// The result of the test.
    test: TestReading,
}

/// The output of `stiction test read --json`.
#[derive(Serialize, JsonSchema)]
pub struct ReadDocument {
    /// The program that wrote the document, with its version.
    tool: &'static str,
    /// The loop with its test.
    loops: [Tested; 1],
}

/// The output of `stiction test read --before --json`.
#[derive(Serialize, JsonSchema)]
pub struct CompareDocument {
    /// The program that wrote the document, with its version.
    tool: &'static str,
    /// The test before the repair.
    before: Tested,
    /// The test after the repair.
    after: Tested,
    /// The comparison of both tests.
    comparison: Comparison,
}

pub fn run(args: Args) -> Result<ExitCode> {
    match args.task {
        Task::Plan(args) => planned(&args).map(|()| ExitCode::SUCCESS),
        Task::Read(args) => was_read(&args),
    }
}

fn planned(args: &Plan) -> Result<()> {
    let (source, recording) = args.of.recording(&args.reading)?;
    if args.signature {
        return signature::planned(args, source, &recording);
    }
    let name = recording.name.clone();
    let done = args.done.as_ref().map(|done| sheet_of(done, &recording, &args.reading));
    let by_hand = done.transpose()?.or_else(|| ByHand::of(&recording).filter(ByHand::is_test));
    let operation = before_test(&recording, by_hand.as_ref());
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let (mut diagnosed, failures) = diagnose_all(&[(source, operation)], &options);
    ended(failures)?;
    let Some(one) = diagnosed.pop() else { bail!("loop {name}: there is no diagnosis") };
    let options = PlanOptions {
        rises: args.of.rises(),
        pv_allowed: args.pv_low.zip(args.pv_high).map(|(low, high)| [low, high]),
        time_s: args.time,
    };
    let first = plan(&one.diagnosis, &options)
        .map_err(|why| anyhow!("{}, loop {name}: {}", args.of.file.origin(), why.0))?;
    let tested = by_hand.is_some();
    let next = first.again(&recording, by_hand);
    let head = match next {
        Some(_) => "next test of the valve, because the recorded test is inconclusive",
        None if tested => {
            "new test of the valve; the recorded test is conclusive, see stiction test read"
        }
        None => "test of the valve",
    };
    let plan = next.unwrap_or(first);
    output::given(&args.sheet, || anyhow::Ok(valve_test_sheet::html(&plan, output::TOOL)))?;
    if args.json {
        return output::json(&PlanDocument { tool: output::TOOL, source: one.source, plan });
    }
    if output::given(&args.csv, || valve_test_sheet::csv(&plan))? {
        return Ok(());
    }
    output::text(&format!("{}: {head}\n{}", plan.name, text::blocks(&report::plan(&plan))))
}

/// A recording with its test.
struct Found {
    source: Source,
    recording: Recording,
    test: TestReading,
}

impl Found {
    /// The test in the recording from `file`, with its plan and completed sheet.
    fn of(
        args: &Read,
        file: &In,
        (source, recording): (Source, Recording),
        plan: Option<&In>,
        done: Option<&In>,
    ) -> Result<Self> {
        let plan = plan.map(plan_of).transpose()?;
        let by_hand = done.map(|done| sheet_of(done, &recording, &args.reading)).transpose()?;
        let options =
            ReadOptions { by_hand, plan, rises: args.of.rises(), grid: GridOptions::default() };
        let test = read(&recording, &options)
            .map_err(|why| anyhow!("{}, loop {}: {}", file.origin(), recording.name, why.0))?;
        Ok(Self { source, recording, test })
    }

    fn page(&self) -> valve_test_page::Tested<'_> {
        let Self { source, recording, test } = self;
        valve_test_page::Tested { source, recording, test }
    }

    fn document(self) -> Tested {
        Tested { name: self.recording.name, source: self.source, test: self.test }
    }

    fn unit(&self) -> Option<&str> {
        self.recording.pv.as_ref().and_then(|pv| pv.unit.as_deref())
    }
}

fn was_read(args: &Read) -> Result<ExitCode> {
    let file = &args.of.file;
    let (source, recording) = args.of.recording(&args.reading)?;
    if args.plan.is_none()
        && args.done.is_none()
        && let Some(found) = Signed::of(&source, &recording)
    {
        return signature::was_read(args, found);
    }
    let (plan, done) = (args.plan.as_ref(), args.done.as_ref());
    let found = Found::of(args, file, (source, recording), plan, done)?;
    let bad = matches!(found.test.class, VerdictClass::Sticks | VerdictClass::DoesNotRespond);
    match &args.before {
        Some(file) => {
            let (plan, done) = (args.before_plan.as_ref(), args.before_done.as_ref());
            let of = one_loop(file, args.of.of_loop.as_ref(), &args.reading)?;
            was_compared(args, Found::of(args, file, of, plan, done)?, found)?;
        }
        None => was_read_alone(args, found)?,
    }
    Ok(if bad && args.fail { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

fn was_read_alone(args: &Read, found: Found) -> Result<()> {
    let name = &found.recording.name;
    output::plot(&args.plot, || Ok(valve_test_figure::figure(name, found.unit(), &found.test)))?;
    output::given(&args.report, || valve_test_page::reading(output::TOOL, found.page()))?;
    if args.json {
        let loops = [found.document()];
        return output::json(&ReadDocument { tool: output::TOOL, loops });
    }
    let section = valve_test_page::in_brief(found.page());
    output::text(&text::section(&valve_test_page::carried(section, &found.test)))
}

/// Refuses a test before the repair that began after the test after the repair. Each recording has the
/// start of its test, s on the recording's clock.
fn in_order(before: (&Recording, f64), after: (&Recording, f64)) -> Result<()> {
    let dated = |(of, at): (&Recording, f64)| of.start.map(|start| start + at);
    if let (Some(old), Some(new)) = (dated(before), dated(after))
        && new <= old
    {
        bail!(
            "the test of --before began on {}, but the other test began no later, on {}; exchange the two files",
            valve_test_page::moment(before.0, before.1),
            valve_test_page::moment(after.0, after.1)
        );
    }
    Ok(())
}

fn was_compared(args: &Read, before: Found, after: Found) -> Result<()> {
    in_order((&before.recording, before.test.from_s), (&after.recording, after.test.from_s))?;
    let comparison = compare(&before.test, &after.test);
    let tests = [("before", &before.test), ("after", &after.test)];
    output::plot(&args.plot, || Ok(valve_test_figure::before_and_after(tests, after.unit())))?;
    output::given(&args.report, || {
        valve_test_page::comparison(output::TOOL, before.page(), after.page(), &comparison)
    })?;
    if args.json {
        valve_test_page::caution(before.page(), after.page()).iter().for_each(output::note);
        let (before, after) = (before.document(), after.document());
        return output::json(&CompareDocument { tool: output::TOOL, before, after, comparison });
    }
    let mut section = valve_test_page::compared(before.page(), after.page(), &comparison);
    for (word, test) in [("Before the repair", &before.test), ("After the repair", &after.test)] {
        if test.plan.is_some() {
            section = valve_test_page::carried(section.heading(word), test);
        }
    }
    output::text(&text::section(&section))
}

/// A plan from `stiction test plan --json`.
fn plan_of(file: &In) -> Result<TestPlan> {
    let text = if file.is_standard() {
        std::io::read_to_string(std::io::stdin())
    } else {
        std::fs::read_to_string(&**file)
    };
    let text = text.with_context(|| file.origin())?;
    let mut json: serde_json::Value =
        serde_json::from_str(&text).with_context(|| format!("--plan {}", file.origin()))?;
    if json.get("signature").is_some() {
        bail!(
            "--plan {}: this is the plan of a signature; leave out --plan to read a signature",
            file.origin()
        );
    }
    let plan = json.get_mut("plan").map(serde_json::Value::take).ok_or_else(|| {
        anyhow!(
            "--plan {}: the key \"plan\" is missing; give the output of `stiction test plan --json`",
            file.origin()
        )
    })?;
    let plan: TestPlan =
        serde_json::from_value(plan).with_context(|| format!("--plan {}", file.origin()))?;
    match plan.fault() {
        Some(why) => bail!("--plan {}: {why}; plan the test again, or correct it", file.origin()),
        None => Ok(plan),
    }
}

/// The manual settings from a completed sheet.
fn sheet_of(file: &In, recording: &Recording, reading: &Reading) -> Result<ByHand> {
    let zone = reading.zone()?;
    let from: Box<dyn std::io::Read> = match file.is_standard() {
        true => Box::new(std::io::stdin()),
        false => Box::new(std::fs::File::open(&**file).with_context(|| file.origin())?),
    };
    let mut rows = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(from);
    let columns = rows.headers().with_context(|| file.origin())?.clone();
    let column = |name: &str| {
        columns.iter().position(|c| c.eq_ignore_ascii_case(name)).ok_or_else(|| {
            anyhow!(
                "{}: the column \"{name}\" is missing; a sheet has the columns time and op",
                file.origin()
            )
        })
    };
    let (of_time, of_op) = (column("time")?, column("op")?);
    let mut sets = vec![];
    for (k, row) in rows.records().enumerate() {
        let row = row.with_context(|| file.origin())?;
        let cell = |column: usize| row.get(column).unwrap_or("");
        let wrong = |what: &str, remedy: &str| {
            anyhow!(
                "{}, row {}, column {what}: \"{}\" {remedy}",
                file.origin(),
                k + 2,
                cell(if what == "op" { of_op } else { of_time })
            )
        };
        if cell(of_time).is_empty() {
            if !cell(of_op).is_empty() {
                return Err(wrong("time", "is not a time; write when the OP was set"));
            }
            // A planned turn that was left out.
            continue;
        }
        let at_s = match recording.start {
            Some(start) => {
                instant(cell(of_time), zone.as_ref())
                    .map_err(|e| wrong("time", &format!("is not a time: {e}")))?
                    - start
            }
            None => {
                cell(of_time).parse::<f64>().ok().filter(|t| t.is_finite()).ok_or_else(|| {
                    wrong(
                        "time",
                        "is not a number of seconds, which a recording without dates needs",
                    )
                })?
            }
        };
        let op = match cell(of_op) {
            "" => None,
            text => Some(
                text.parse::<f64>()
                    .ok()
                    .filter(|op| (-10.0..=110.0).contains(op))
                    .ok_or_else(|| wrong("op", "is not an OP in percent"))?,
            ),
        };
        if sets.last().is_some_and(|last: &Set| at_s < last.at_s) {
            return Err(wrong("time", "is before the row above; put the rows in order of time"));
        }
        sets.push(Set { at_s, op });
    }
    if sets.is_empty() {
        bail!("{}: no row has a time; write when each OP was set", file.origin());
    }
    Ok(ByHand { sets, known_by: KnownBy::Sheet })
}
