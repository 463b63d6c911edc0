//! Networks of loops, to measure how often groups and sources are found.

use super::{Form, shared as row, shares};
use crate::{output, progress};
use anyhow::Result;
use schemars::JsonSchema;
use serde::Serialize;
use stiction_plant::trial::Trial;
use stiction_report::report::Table;

/// Version of the document. A change that breaks its readers gets a new one.
const VERSION: u32 = 1;

/// What `stiction bench networks --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// Name and version of the program.
    tool: &'static str,
    /// Version of this form.
    version: u32,
    /// Seed of the networks.
    seed: u64,
    /// Days of each network.
    days: u32,
    #[serde(flatten)]
    trial: Trial,
}

/// Measures groups on the first `n` networks of `seed`, and prints the counts.
pub fn run(seed: u64, n: u64, days: u32, form: &Form) -> Result<()> {
    let progress = progress::bar("simulating", n as usize);
    let trial = Trial::run(seed, n, days, || progress.inc(1))?;
    progress.finish_and_clear();
    let table = table(seed, days, &trial);
    let document = Document { tool: output::TOOL, version: VERSION, seed, days, trial };
    form.print(&document, "", &[table])
}

fn table(seed: u64, days: u32, trial: &Trial) -> Table {
    let Trial { networks, loops, .. } = trial;
    let table = shares(format!(
        "Loops that swing together: {networks} simulated networks of {loops} loops, seed {seed}, {days} days each. \
         Pairs of one network are not independent, so their intervals are too narrow."
    ));
    let pairs = "pairs of a sticking valve's loop and a loop that it makes swing";
    let table = row(table, pairs, "in a group", trial.recall);
    let table = row(table, "pairs in a group", "without a common cause", trial.false_pairs);
    let sources = "sticking valves that make another loop swing";
    let table = row(table, sources, "in a group with that loop", trial.sources);
    let table = row(table, "these", "that are the first candidate", trial.first);
    let table = row(table, "these", "among the first three", trial.first_three);
    let unknown = "whose source is reported as not recorded";
    let table = row(table, "groups without a sticking valve", unknown, trial.not_recorded);
    let table = row(table, "groups with a source", unknown, trial.wrongly_not_recorded);
    row(table, "networks of unrelated loops", "with any group", trial.unrelated)
}
