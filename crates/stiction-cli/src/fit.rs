//! `stiction fit`: identifies the loop of a recording.

use crate::diagnose::ended;
use crate::files::{In, Out};
use crate::loops::{Diagnosed, diagnose_all, read_all};
use crate::reading_args::Reading;
use crate::{output, progress, text};
use anyhow::{Result, bail};
use clap::Parser;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use stiction::diagnose::{Detectors, DiagnoseOptions};
use stiction::fit::{Fit, FitOptions, fit};
use stiction::recording::LoopType;
use stiction_io::scenario::{Scenario, System};
use stiction_report::document::Source;
use stiction_report::report::{Fact, fitted};

/// Identify controller, process and valve from a recording, with intervals, and test whether the valve explains the
/// recorded swing.
///
/// Compares the recorded swing with the limit cycle of the fitted loop, and with the swing that would remain with a
/// valve that follows its OP. If the cycle agrees, or little swing would remain, a sticking valve explains the swing.
/// Otherwise something else makes the loop swing. Parts that cannot be identified are listed with the reason. -o writes
/// the loop as a scenario for simulate, limit-cycle, compensate, what-if and fmu.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction fit samples/FIC101-sticky.csv
  stiction fit samples/FIC101-sticky.csv -o loop.toml --plot fit.svg
  stiction fit export.csv --loop FIC101 --json")]
pub struct Args {
    /// CSV, Parquet, Excel or MATLAB files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<In>,
    /// Fit only this loop; may be given several times
    #[arg(long = "loop", value_name = "TAG")]
    loops: Vec<String>,
    /// Write the loop as a scenario to this TOML file; - is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<Out>,
    /// Draw the recording and the fitted loop to this .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<Out>,
    /// Number of loops to draw at random from the possible loops
    #[arg(long, default_value_t = FitOptions::default().draws, value_name = "N")]
    draws: usize,
    /// Seed of the random draw
    #[arg(long, default_value_t = FitOptions::default().seed, value_name = "N")]
    seed: u64,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    reading: Reading,
}

/// What `stiction fit --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// Name and version of the program.
    tool: &'static str,
    /// The loops, in the order of the files.
    loops: Vec<Row>,
}

/// A loop.
#[derive(Serialize, JsonSchema)]
struct Row {
    /// Tag of the loop.
    #[serde(rename = "loop")]
    name: String,
    /// Type of the loop.
    #[serde(rename = "type")]
    loop_type: LoopType,
    /// The file of the recording.
    source: Source,
    /// The fitted loop; null if nothing could be fitted.
    fit: Option<Fit>,
    /// Why nothing could be fitted; null if the fit succeeded.
    why_not: Option<String>,
}

/// A recorded loop with its fit.
pub struct Fitted {
    pub diagnosed: Diagnosed,
    pub fit: std::result::Result<Fit, String>,
}

/// The fits of all selected loops in some files, and the errors of files that could not be read or diagnosed.
pub fn fit_all(
    files: &[In],
    loops: &[String],
    reading: &Reading,
    options: &FitOptions,
) -> Result<(Vec<Fitted>, Vec<anyhow::Error>)> {
    let (recordings, mut failures) = read_all(files, loops, reading)?;
    // Published methods are not needed.
    let asked = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let (diagnosed, refused) = diagnose_all(&recordings, &asked);
    failures.extend(refused);
    let bar = progress::bar("fitting", diagnosed.len());
    let all = diagnosed.into_par_iter().map(|diagnosed| {
        let fit = fit(&diagnosed.diagnosis, options);
        bar.inc(1);
        Fitted { diagnosed, fit }
    });
    let all = all.collect();
    bar.finish_and_clear();
    Ok((all, failures))
}

pub fn run(args: Args) -> Result<()> {
    if args.draws == 0 || args.draws > 10_000 {
        bail!("--draws is {}, but must be between 1 and 10000", args.draws);
    }
    let options = FitOptions { draws: args.draws, seed: args.seed };
    let (all, failures) = fit_all(&args.files, &args.loops, &args.reading, &options)?;
    if (args.output.is_some() || args.plot.is_some()) && all.len() > 1 {
        let tags: Vec<&str> = all.iter().map(|each| &*each.diagnosed.diagnosis.name).collect();
        bail!(
            "--output and --plot need one loop, but there are {}; choose it with --loop",
            tags.join(", ")
        );
    }
    if let [one] = &all[..]
        && (args.output.is_some() || args.plot.is_some())
    {
        let scenario = scenario(one)?;
        if let Some(path) = &args.plot {
            plot(path, one, &scenario)?;
        }
        if let Some(path) = &args.output {
            output::write(Some(path), scenario.as_bytes())?;
            if path.is_standard() {
                return ended(failures);
            }
        }
    }
    if args.json {
        let row = |each: Fitted| {
            let Diagnosed { source, diagnosis } = each.diagnosed;
            let (fit, why_not) = match each.fit {
                Ok(fit) => (Some(fit), None),
                Err(why) => (None, Some(why)),
            };
            Row { name: diagnosis.name, loop_type: diagnosis.loop_type, source, fit, why_not }
        };
        let loops = all.into_iter().map(row).collect();
        output::json(&Document { tool: output::TOOL, loops })?;
    } else {
        let texts: Vec<String> = all.iter().map(in_words).collect();
        output::text(&texts.join("\n"))?;
        if let Some(path) = &args.output {
            output::note(format!("the loop is in {}", path.display()));
        }
    }
    ended(failures)
}

/// The scenario of a fitted loop.
pub fn scenario(each: &Fitted) -> Result<String> {
    let name = &each.diagnosed.diagnosis.name;
    let fit = each.fit.as_ref().map_err(|why| anyhow::anyhow!("{name}: {why}"))?;
    let duration = each.diagnosed.diagnosis.segment().map_or(0.0, |segment| segment.duration());
    stiction_report::fitted_scenario::scenario(name, fit, duration).map_err(anyhow::Error::msg)
}

fn plot(path: &Out, each: &Fitted, scenario: &str) -> Result<()> {
    let diagnosis = &each.diagnosed.diagnosis;
    let parsed = Scenario::parse(scenario, &diagnosis.name, None)?;
    let (System::ClosedLoop(plant), Some(segment)) = (&parsed.system, diagnosis.segment()) else {
        bail!("{}: there is nothing to draw", diagnosis.name);
    };
    let pv = segment.pv.as_deref().unwrap_or_default();
    let run = plant.run()?;
    let title = format!("{}: the recording, and the loop fitted to it", diagnosis.name);
    let figure =
        stiction::drawing::fitted::fitted(&title, &segment.op, pv, segment.sample_time, &run);
    output::figure("--plot", path, &figure)
}

fn in_words(each: &Fitted) -> String {
    let diagnosis = &each.diagnosed.diagnosis;
    let rows = match &each.fit {
        Ok(fit) => {
            let mut rows = fitted::parts(fit, diagnosis.pv_unit.as_deref());
            rows.push(Fact::new("explained?", fitted::explained(fit), ""));
            rows
        }
        Err(why) => vec![Fact::new("not fitted", why, "")],
    };
    format!("{}\n{}", output::name(&diagnosis.name), text::facts(&rows))
}
