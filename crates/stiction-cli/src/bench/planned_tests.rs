//! Planned tests, to count decisions and correct decisions.

use super::{Form, shared as row, shares};
use crate::{output, progress};
use anyhow::Result;
use schemars::JsonSchema;
use serde::Serialize;
use stiction::population::{Operator, Trend};
use stiction::score::{BANDS, TestTrial, TestTrialOptions, TestedLoops};
use stiction_report::report::Table;
use stiction_report::words;

/// Version of the document. A change that breaks its readers gets a new one.
const VERSION: u32 = 1;

/// What `stiction bench --tests --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// Name and version of the program.
    tool: &'static str,
    /// Version of this form.
    version: u32,
    /// Seed of the loops.
    seed: u64,
    /// Number of loops.
    loops: u64,
    #[serde(flatten)]
    trial: TestTrial,
}

/// Tests the first `n` loops of `seed`, and prints the counts.
pub fn run(seed: u64, n: u64, options: TestTrialOptions, form: &Form) -> Result<()> {
    let progress = progress::bar("testing", n as usize);
    let trial = TestTrial::run(seed, n, options, || progress.inc(1))?;
    progress.finish_and_clear();
    let table = table(seed, n, options, &trial);
    let document = Document { tool: output::TOOL, version: VERSION, seed, loops: n, trial };
    form.print(&document, "", &[table])
}

fn table(seed: u64, n: u64, options: TestTrialOptions, trial: &TestTrial) -> Table {
    let loops = match options.loops {
        TestedLoops::Population => "simulated loops",
        TestedLoops::Invented => "loops of invented kinds",
        TestedLoops::PhysicalStems => "loops with physical stems",
    };
    let operator = match options.operator {
        Operator::Careful => "a careful operator",
        Operator::Careless => "a careless operator",
    };
    let trend = match options.trend {
        Trend::AsPlanned => "recorded without compression",
        Trend::Historian => "recorded by each loop's own historian",
    };
    let table = shares(format!("Planned tests: {n} {loops}, seed {seed}, {operator}, {trend}"));
    let table = row(table, "loops", "with a plan", trial.planned);
    let table = row(table, "plans", "whose test began", trial.began);
    let table = row(table, "tests", "that decide whether the valve sticks", trial.decided);
    let table = row(table, "these", "that are right", trial.right);
    let table =
        row(table, "tests of loops undecided in normal operation", "that decide", trial.undecided);
    let table = row(table, "these", "that are right", trial.undecided_right);
    let table = row(table, "tests that were never stopped", "that decide", trial.calm);
    let table = row(table, "tests of faulty valves", "that find the fault", trial.found);
    let table = row(table, "tests of healthy valves", "that accuse the valve", trial.accused);
    let table = row(table, "values of S", "within 15 % of the true S", trial.s_within);
    let table = row(table, "90 % intervals of S", "that contain the true S", trial.s_covered);
    let table = row(table, "90 % intervals of J", "that contain the true J", trial.j_covered);
    let table = row(table, "tests", "followed by a second or third test", trial.repeated);
    let table = row(table, "tests", "stopped at least once", trial.stopped);
    let table = row(table, "tests", "given up", trial.given_up);
    let table = row(table, "these", "that still decide", trial.given_up_decided);
    let table = row(table, "these", "that are right", trial.given_up_right);
    let table = row(table, "tests", "in which the PV left the tolerated range", trial.beyond);
    let table =
        row(table, "the same loops", "out of range also without a test", trial.beyond_anyway);
    let table = row(table, "tests", "found without sheet and mode", trial.noticed);
    let table = row(table, "recordings of operation", "mistaken for a test", trial.imagined);
    let bands = trial.sticking_by_probability.iter().zip(BANDS.windows(2));
    let table = bands.fold(table, |table, (share, ends)| {
        let [from, to] = [ends[0], ends[1]].map(|p| words::rough(100.0 * p));
        row(
            table,
            &format!("tests with p(sticks) from {from} to {to} %"),
            "whose valve sticks",
            *share,
        )
    });
    let number = |value: Option<f64>, unit: &str| {
        value.map_or("-".to_owned(), |value| format!("{}{unit}", words::rough(value)))
    };
    let one = |table: Table, of: &str, value: String| {
        table.row([of.to_owned(), "median".to_owned(), String::new(), value])
    };
    let table = one(table, "error of S", number(trial.s_error.map(|e| 100.0 * e), " %"));
    let table = one(table, "limit of S of valves that do not stick", number(trial.s_below, " %"));
    let table = one(table, "turns", number(trial.turns, ""));
    let two = |table: Table, of: &str, [half, most]: [f64; 2], say: &dyn Fn(f64) -> String| {
        let value = format!("{}, {}", say(half), say(most));
        table.row([of.to_owned(), "median, 90th percentile".to_owned(), String::new(), value])
    };
    let Some(expected) = trial.expected_s else { return table };
    let table = two(table, "time in manual, expected by the first plan", expected, &words::spoken);
    let table = match trial.expected_fast_s {
        Some(fast) => {
            two(table, "time in manual, if 40 responses fit in 15 min", fast, &words::spoken)
        }
        None => table,
    };
    let times = [trial.manual_s, trial.manual_of_all_s, trial.responses];
    let [Some(first), Some(all), Some(responses)] = times else { return table };
    let table = two(table, "time in manual of the first test", first, &words::spoken);
    let table = two(table, "first test, in process response times", responses, &words::rough);
    two(table, "time in manual of all tests of a loop", all, &words::spoken)
}
