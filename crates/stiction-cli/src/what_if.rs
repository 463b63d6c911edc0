//! `stiction what-if`: what repair, retuning, a compensator or a positioner would make of a loop.

use crate::actions::{self, Head, Settings, Valve};
use crate::{output, text};
use anyhow::Result;
use clap::Parser;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use stiction::Bands;
use stiction::compensate;
use stiction::what_if::{Options, Prediction, Row, WhatIf, what_if};

/// Ask what to do about a loop whose valve sticks: repair, retune, compensate, or put a positioner on it.
///
/// Every action is simulated, with S and J right and wrong, and ranked by the mean control error in the worst
/// case; then follow what is recommended, what that rests on, and the manual test that confirms it first.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction what-if paper/closed-loop --plot actions.png
  stiction what-if my-loop.toml --set valve.S=3 --ms 1.6 --json")]
pub struct Args {
    /// Name of a built-in scenario, or a TOML file; a single control loop
    scenario: String,
    /// Change a key of the scenario, such as valve.S=4; may be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// S of a repaired valve, percent of span [default: 0.4, or that of the valve if it is less]
    #[arg(long = "repaired-S", value_name = "PERCENT", allow_negative_numbers = true)]
    repaired_s: Option<f64>,
    /// J of a repaired valve, percent of span [default: 0.1, or that of the valve if it is less]
    #[arg(long = "repaired-J", value_name = "PERCENT", allow_negative_numbers = true)]
    repaired_j: Option<f64>,
    /// Gain of a positioner [default: 10]
    #[arg(long, value_name = "GAIN", allow_negative_numbers = true)]
    positioner_gain: Option<f64>,
    /// Bound on the maximum sensitivity Ms of a retuned loop [default: 2]
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    ms: Option<f64>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Draw error and travel of every action to this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write every action and case to this CSV file; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    csv: Option<PathBuf>,
}

/// What `stiction what-if --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    #[serde(flatten)]
    head: Head,
    /// The valve of the loop.
    valve: Valve,
    /// The scenario, key by key.
    settings: Settings,
    /// What every action went through.
    protocol: compensate::Options,
    #[serde(flatten)]
    found: WhatIf,
}

pub fn run(args: Args) -> Result<()> {
    let scenario = actions::scenario(&args.scenario, &args.set)?;
    let plant = actions::single_loop(&args.scenario, &scenario)?;
    let (model, bands) = scenario.valve;
    let mut options = Options::suiting(plant, model, bands)?;
    if args.repaired_s.is_some() || args.repaired_j.is_some() {
        let usual = options.repaired;
        let (s, j) = (args.repaired_s.unwrap_or(usual.s()), args.repaired_j.unwrap_or(usual.j()));
        options.repaired = Bands::from_s_j(s, j)?;
    }
    options.positioner_gain = args.positioner_gain.unwrap_or(options.positioner_gain);
    options.most_sensitive = args.ms.unwrap_or(options.most_sensitive);
    // A bound that no loop can meet is an error, not a reason to leave retuning out.
    if !(options.most_sensitive > 1.0 && options.most_sensitive.is_finite()) {
        anyhow::bail!("--ms is {}, but must be a finite number above 1", options.most_sensitive);
    }
    let found = what_if(plant, model, bands, &options)?;
    let rows: Vec<(&'static str, &compensate::Row)> =
        found.rows.iter().map(|row| (row.action.name(), &row.played)).collect();
    if let (Some(path), Some(present)) = (&args.plot, found.as_it_is()) {
        let title = format!("What could be done: {}", scenario.title);
        let figure = stiction_figure::actions::actions(&title, &present.played, &rows);
        output::figure("--plot", path, &figure)?;
    }
    if let Some(path) = &args.csv {
        let named: Vec<(&str, &compensate::Row)> = rows;
        output::write(Some(path), actions::csv(&named)?.as_bytes())?;
        if path.as_os_str() == "-" {
            return Ok(());
        }
    }
    if args.json {
        let (head, settings) = Head::of(&args.scenario, &scenario)?;
        let (valve, protocol) = (Valve::new(model, bands), options.protocol);
        return output::json(&Document { head, valve, settings, protocol, found });
    }
    output::write(None, in_words(&scenario.title, &found).as_bytes())
}

fn in_words(title: &str, found: &WhatIf) -> String {
    let rows: Vec<(&str, &compensate::Row, String)> =
        found.rows.iter().map(|row| (row.action.name(), &row.played, predicted(row))).collect();
    let mut out = format!("{title}\n\n{}\n", actions::table(&rows, "cycle s"));
    let mut paragraph = |lead: &str, words: &str, hang: usize| {
        for (k, line) in text::wrapped(words, 96 - hang).iter().enumerate() {
            let before = if k == 0 { lead.to_owned() } else { " ".repeat(hang) };
            out += &format!("{before}{line}\n");
        }
    };
    let words = format!(
        "{} cycle: exact limit cycle of what is left, none if there is none.",
        actions::LEGEND
    );
    paragraph("", &words, 0);
    let spoken: Vec<&Row> = found.rows.iter().filter(|row| !row.against.is_empty()).collect();
    if !spoken.is_empty() {
        paragraph("\n", "Against, in place of the loop as it is", 0);
        for row in spoken {
            paragraph(&format!("  {:24}", row.action.name()), &row.against.join("; "), 26);
        }
    }
    paragraph("\n", "What to do", 0);
    found.recommendation.iter().for_each(|sentence| paragraph("- ", sentence, 2));
    if let Some(test) = &found.confirm {
        paragraph("\n", "The test in manual that confirms it first", 0);
        test.instructions.iter().for_each(|sentence| paragraph("- ", sentence, 2));
    }
    paragraph("\n", "What this rests on", 0);
    found.assumptions.iter().for_each(|sentence| paragraph("- ", sentence, 2));
    if let Err(reason) = &found.retuning {
        paragraph("- ", &format!("No other tuning was looked for or found: {reason}."), 2);
    }
    out
}

/// The predicted period, in a cell.
fn predicted(row: &Row) -> String {
    match &row.cycle {
        Prediction::Cycle(cycle) => actions::short(cycle.period_s),
        Prediction::NoCycle(_) => "none".to_owned(),
        Prediction::Unknown(_) => "?".to_owned(),
    }
}
