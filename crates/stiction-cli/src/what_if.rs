//! `stiction what-if`: the effects of repair, retuning, a compensator or a positioner on a loop.

use crate::actions::{self, Head, Settings, Valve};
use crate::diagnose::ended;
use crate::files::{In, Out};
use crate::fit::{Fitted, fit_all};
use crate::loops::only;
use crate::reading_args::Reading;
use crate::{output, text};
use anyhow::{Result, bail};
use clap::Parser;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use stiction::Bands;
use stiction::compensate;
use stiction::fit::prospects::Remedy;
use stiction::fit::ring::{Ring, ring};
use stiction::fit::{Fit, FitOptions, Prospects, prospects};
use stiction::what_if::{Prediction, Row, WhatIf, WhatIfOptions, what_if};
use stiction_report::document::Source;
use stiction_report::report::{Block, fitted};

/// Compare actions for a loop whose valve sticks: repair, retuning, a compensator, or a positioner.
///
/// Every action is simulated, with correct and wrong S and J, and ranked by the mean control error in the worst case.
/// The output also has a recommendation, its assumptions, and the manual test that first confirms stiction.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction what-if paper/closed-loop --plot actions.png
  stiction what-if my-loop.toml --set valve.S=3 --ms 1.6 --json
  stiction what-if samples/FIC101-sticky.csv
  stiction what-if before.csv --after after.csv --action repair")]
pub struct Args {
    /// Name of a built-in scenario, a TOML file, or a recording (CSV, Parquet, Excel, MATLAB) of a single control loop
    #[arg(value_name = "SCENARIO|FILE")]
    scenario: String,
    /// The loop to use, if the recording has several
    #[arg(long = "loop", value_name = "TAG")]
    of_loop: Option<String>,
    /// Recording of the same loop after an action; SCENARIO|FILE must be a recording, too
    #[arg(long, value_name = "FILE")]
    after: Option<In>,
    /// The action before the recording of --after. Possible actions are nothing, repair, retune, repair-and-retune, positioner,
    /// and the names of compensators [default: repair]
    #[arg(long, value_name = "ACTION", requires = "after", value_parser = Remedy::by_name)]
    action: Option<Remedy>,
    /// Change a key of the scenario, such as valve.S=4; may be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// S of a repaired valve, percent of span [default: 0.4, or S of the valve if below 0.4]
    #[arg(long = "repaired-S", value_name = "PERCENT", allow_negative_numbers = true)]
    repaired_s: Option<f64>,
    /// J of a repaired valve, percent of span [default: 0.1, or J of the valve if below 0.1]
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
    /// Draw control error and stem travel of every action to this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<Out>,
    /// Write every action and case to this CSV file; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    csv: Option<Out>,
    // Last, because its heading covers all options that follow.
    #[command(flatten)]
    reading: Reading,
}

/// The output of `stiction what-if --json` for a recording.
#[derive(Serialize, JsonSchema)]
pub struct FromRecording {
    /// The program and its version.
    tool: &'static str,
    /// Tag of the loop.
    #[serde(rename = "loop")]
    name: String,
    /// The file of the recording.
    source: Source,
    /// The fitted loop.
    fit: Fit,
    /// The actions and their predicted effects.
    prospects: Prospects,
    /// The actual effect, if a recording after the action was given.
    after: Option<Ring>,
}

/// The output of `stiction what-if --json` for a scenario.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    #[serde(flatten)]
    head: Head,
    /// The valve of the loop.
    valve: Valve,
    /// The settings of the scenario by key.
    settings: Settings,
    /// The protocol of the simulations.
    protocol: compensate::CompareOptions,
    #[serde(flatten)]
    found: WhatIf,
}

/// Whether an argument is a file of recordings instead of a scenario.
fn is_recording(name: &str) -> bool {
    let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or("");
    stiction_io::scenario::built_in_text(name).is_none()
        && !extension.is_empty()
        && !extension.eq_ignore_ascii_case("toml")
}

/// The actions for a recorded loop.
fn of_recording(args: &Args) -> Result<()> {
    let given = [
        ("--set", !args.set.is_empty()),
        ("--repaired-S", args.repaired_s.is_some()),
        ("--repaired-J", args.repaired_j.is_some()),
        ("--positioner-gain", args.positioner_gain.is_some()),
        ("--ms", args.ms.is_some()),
        ("--plot", args.plot.is_some()),
        ("--csv", args.csv.is_some()),
    ];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
        bail!(
            "{option} is for a scenario, but {} is a recording; write its loop with `stiction fit {} -o loop.toml` and use \
             that file",
            args.scenario,
            args.scenario
        );
    }
    let one = |file: &In| -> Result<Fitted> {
        let loops: Vec<String> = args.of_loop.iter().cloned().collect();
        let (all, failures) =
            fit_all(std::slice::from_ref(file), &loops, &args.reading, &FitOptions::default())?;
        ended(failures)?;
        only(file, all, |each| &each.diagnosed.diagnosis.name)
    };
    let before = one(&In::also(&args.scenario)?)?;
    let name = before.diagnosed.diagnosis.name;
    let fit = before
        .fit
        .map_err(|why| anyhow::anyhow!("loop {name} has no prediction for an action: {why}"))?;
    let prospects = prospects(&fit)
        .map_err(|why| anyhow::anyhow!("loop {name} has no prediction for an action: {why}"))?;
    let after = match &args.after {
        None => None,
        Some(path) => {
            let after = one(path)?.diagnosed.diagnosis;
            let what = args.action.unwrap_or(Remedy::Repair);
            let found = match after.segment() {
                Some(segment) => ring(&prospects, what, &fit, segment),
                None => Err("no segment in automatic is long enough".to_owned()),
            };
            Some(found.map_err(|why| anyhow::anyhow!("{}: {why}", path.display()))?)
        }
    };
    if args.json {
        let source = before.diagnosed.source;
        let tool = output::TOOL;
        return output::json(&FromRecording { tool, name, source, fit, prospects, after });
    }
    let mut blocks = fitted::effects(&prospects);
    if let Some(ring) = after {
        blocks.push(Block::Heading("Effect of the action".to_owned()));
        blocks.push(Block::Paragraph(ring.sentence));
    }
    output::text(&format!("{}\n{}", output::name(&name), text::blocks(&blocks)))
}

pub fn run(args: Args) -> Result<()> {
    if is_recording(&args.scenario) {
        return of_recording(&args);
    }
    if args.of_loop.is_some() || args.after.is_some() {
        bail!("--loop and --after are for a recording, but {} is a scenario", args.scenario);
    }
    let scenario = actions::scenario(&args.scenario, &args.set)?;
    let plant = actions::single_loop(&args.scenario, &scenario)?;
    let (model, bands) = scenario.valve;
    let mut options = WhatIfOptions::suiting(plant, model, bands)?;
    if args.repaired_s.is_some() || args.repaired_j.is_some() {
        let usual = options.repaired;
        let (s, j) = (args.repaired_s.unwrap_or(usual.s()), args.repaired_j.unwrap_or(usual.j()));
        options.repaired = Bands::from_s_j(s, j)?;
    }
    options.positioner_gain = args.positioner_gain.unwrap_or(options.positioner_gain);
    options.most_sensitive = args.ms.unwrap_or(options.most_sensitive);
    // A bound that no loop can meet is an error, so that retuning is not left out silently.
    if !(options.most_sensitive > 1.0 && options.most_sensitive.is_finite()) {
        anyhow::bail!("--ms is {}, but must be a finite number above 1", options.most_sensitive);
    }
    let found = what_if(plant, model, bands, &options)?;
    let rows: Vec<(&'static str, &compensate::Row)> =
        found.rows.iter().map(|row| (row.action.name(), &row.played)).collect();
    if let (Some(path), Some(present)) = (&args.plot, found.as_it_is()) {
        let title = format!("Actions: {}", scenario.title);
        let figure = stiction::drawing::actions::actions(&title, &present.played, &rows);
        output::figure("--plot", path, &figure)?;
    }
    if output::given(&args.csv, || actions::csv(&rows))? {
        return Ok(());
    }
    if args.json {
        let (head, settings) = Head::of(&args.scenario, &scenario)?;
        let (valve, protocol) = (Valve::new(model, bands), options.protocol);
        return output::json(&Document { head, valve, settings, protocol, found });
    }
    output::text(&in_words(&scenario.title, &found))
}

fn in_words(title: &str, found: &WhatIf) -> String {
    let rows: Vec<(&str, &compensate::Row, String)> =
        found.rows.iter().map(|row| (row.action.name(), &row.played, predicted(row))).collect();
    let mut out = format!("{title}\n\n{}\n", actions::table(&rows, "cycle s"));
    out += &text::paragraph(&format!(
        "{} Cycle s is the period of the exact limit cycle after the action, in s (none if the loop does not cycle).",
        actions::LEGEND
    ));
    let item = |sentence: &String| text::hanging("- ", sentence, 94);
    let spoken: Vec<&Row> = found.rows.iter().filter(|row| !row.against.is_empty()).collect();
    if !spoken.is_empty() {
        out += "\nEvidence against each action, compared with the present loop\n";
        for row in spoken {
            let head = format!("  {:24}", row.action.name());
            out += &text::hanging(&head, &row.against.join("; "), 70);
        }
    }
    out += "\nWhat to do\n";
    out.extend(found.recommendation.iter().map(item));
    if let Some(test) = &found.confirm {
        out += "\nTest in manual before the action\n";
        out.extend(test.instructions.iter().map(item));
    }
    out += "\nAssumptions\n";
    out.extend(found.assumptions.iter().map(item));
    if let Err(reason) = &found.retuning {
        out += &item(&format!("No tuning can be recommended: {reason}."));
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
