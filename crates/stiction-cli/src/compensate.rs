//! `stiction compensate`: the effect of one or all compensators on a loop.

use crate::actions::{self, Head, Settings, Valve};
use crate::files::Out;
use crate::{output, text};
use anyhow::{Context, Result, bail};
use clap::Parser;
use schemars::JsonSchema;
use serde::Serialize;
use stiction::Bands;
use stiction::compensate::{
    CompareOptions, Comparison, Knowledge, Method, Row, compare, run as play,
};
use stiction::what_if::{self, knowledge};

/// Put compensators between the controller and the sticking valve of a loop, and measure their effect.
///
/// The parameters of each method follow from S, J and the loop. Each method runs through a window without changes, a
/// set-point step and a load step. Each method is also tried with S and J 50 % too small or too large, and with noise.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction compensate paper/closed-loop
  stiction compensate paper/closed-loop --method knocker --S 4 --J 2 --plot knocker.png
  stiction compensate --list")]
pub struct Args {
    /// List the methods with descriptions and sources
    #[arg(long)]
    list: bool,
    /// Name of a built-in scenario, or a TOML file, with a single control loop
    #[arg(required_unless_present = "list")]
    scenario: Option<String>,
    /// Change a key of the scenario, such as valve.S=4; may be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Run only this method; may be given several times
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// S assumed for choosing parameters, percent of span [default: S of the valve]
    #[arg(long = "S", value_name = "PERCENT", allow_negative_numbers = true)]
    s: Option<f64>,
    /// J assumed for choosing parameters, percent of span [default: J of the valve]
    #[arg(long = "J", value_name = "PERCENT", allow_negative_numbers = true)]
    j: Option<f64>,
    /// Time at which the compensators are switched on, s [default: after ten cycles, or ten settling times of the process
    /// if that is longer]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    at: Option<f64>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Draw to this .svg or .png file: for one method, the run before and after; otherwise, error and travel of all methods
    #[arg(long, value_name = "FILE")]
    plot: Option<Out>,
    /// Write every method and case to this CSV file; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    csv: Option<Out>,
}

/// What `stiction compensate --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    #[serde(flatten)]
    head: Head,
    /// The valve of the loop.
    valve: Valve,
    /// The scenario, key by key.
    settings: Settings,
    /// S and J assumed for choosing parameters.
    assumed: Bands,
    /// The simulated test of each method.
    protocol: CompareOptions,
    /// The loop without a compensator, then the methods in order of their worst error.
    methods: Vec<Compensated>,
}

/// The effect of a method on the loop.
#[derive(Serialize, JsonSchema)]
struct Compensated {
    /// The method, or `as it is`.
    action: &'static str,
    #[serde(flatten)]
    row: Row,
    /// Factor by which the standard deviation of the PV falls; null if the standard deviation becomes 0.
    #[serde(with = "stiction::finite::Finite")]
    pv_std_divided_by: f64,
}

pub fn run(args: Args) -> Result<()> {
    if args.list {
        for method in Method::ALL {
            let method = method.describe();
            output::line(format!(
                "{:22} {}\n{:22} {}",
                method.name, method.summary, "", method.citation
            ))?;
        }
        return Ok(());
    }
    let name = args.scenario.as_deref().context("no scenario")?;
    let mut methods = vec![];
    for wanted in &args.method {
        let method = Method::by_name(wanted)?;
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    if methods.is_empty() {
        methods = Method::ALL.to_vec();
    }
    let scenario = actions::scenario(name, &args.set)?;
    let plant = actions::single_loop(name, &scenario)?;
    let (model, bands) = scenario.valve;
    let mut options = what_if::WhatIfOptions::suiting(plant, model, bands)?.protocol;
    if let Some(at) = args.at {
        options.from_s = at;
    }
    let assumed = Bands::from_s_j(args.s.unwrap_or(bands.s()), args.j.unwrap_or(bands.j()))?;
    let known: Knowledge = knowledge(plant, assumed);
    let mut found = compare(plant, &known, &methods, &options)?;
    if !found.rows[0].nominal().measures.iae_per_s.is_finite() {
        bail!(
            "the loop grows without bound; lower the gain of its controller, or limit its output"
        );
    }
    found.rows[1..].sort_by(|a, b| error(a).total_cmp(&error(b)));
    let mut rows: Vec<(&'static str, &Row)> =
        found.rows.iter().map(|row| (called(row), row)).collect();
    rows.sort_by(|a, b| error(a.1).total_cmp(&error(b.1)));
    output::plot(&args.plot, || {
        Ok(match methods[..] {
            [method] => {
                let mut plant = plant.clone();
                let until = options.from_s + 0.5 * options.settle_s;
                plant.samples = (until / plant.sample_time).ceil() as usize;
                let mut compensator = method.automatic(&known)?;
                let done = play(&plant, compensator.as_mut(), options.from_s)?;
                let title = format!("{}: {}", method.describe().name, scenario.title);
                let from = options.from_s - 0.4 * options.settle_s;
                stiction::drawing::run::compensated(&title, &done, options.from_s, from, until)
            }
            _ => {
                let title = format!("Compensators: {}", scenario.title);
                stiction::drawing::actions::actions(&title, &found.rows[0], &rows)
            }
        })
    })?;
    if output::given(&args.csv, || actions::csv(&rows))? {
        return Ok(());
    }
    if args.json {
        let (head, settings) = Head::of(name, &scenario)?;
        let methods = found.rows.iter().map(|row| Compensated {
            action: called(row),
            row: row.clone(),
            pv_std_divided_by: found.reduction(row),
        });
        return output::json(&Document {
            head,
            valve: Valve::new(model, bands),
            settings,
            assumed,
            protocol: options,
            methods: methods.collect(),
        });
    }
    output::text(&in_words(&scenario.title, &found, assumed))
}

fn error(row: &Row) -> f64 {
    row.worst_iae_per_s()
}

fn called(row: &Row) -> &'static str {
    row.method.map_or("as it is", |method| method.describe().name)
}

fn in_words(title: &str, found: &Comparison, assumed: Bands) -> String {
    let rows: Vec<(&str, &Row, String)> = found
        .rows
        .iter()
        .map(|row| {
            let factor = match found.reduction(row) {
                factor if factor <= 999.0 => actions::short(factor),
                _ => ">999".to_owned(),
            };
            (called(row), row, if row.method.is_some() { factor } else { String::new() })
        })
        .collect();
    let mut out = format!("{title}\n\n{}\n", actions::table(&rows, "std ÷"));
    let words = format!(
        "{} std ÷ is the factor by which the standard deviation of the PV falls; a constant offset does not count. Chosen \
         for S = {} %, J = {} %.",
        actions::LEGEND,
        actions::short(assumed.s()),
        actions::short(assumed.j())
    );
    out += &text::paragraph(&words);
    if let [_, row] = &found.rows[..] {
        out += "\nParameters\n";
        for n in &row.parameters {
            out += format!("  {:24}{} {}", n.name, actions::short(n.value), n.unit).trim_end();
            out.push('\n');
        }
    }
    out
}
