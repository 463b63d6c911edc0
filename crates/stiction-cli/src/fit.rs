//! `stiction fit`: identifies the loop of a recording.

use crate::diagnose::ended;
use crate::files::{In, Out};
use crate::loops::{Diagnosed, diagnose_all, read_all};
use crate::reading_args::Reading;
use crate::text::number;
use crate::{output, progress, text};
use anyhow::{Result, bail};
use clap::Parser;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use stiction::diagnose::{Detectors, DiagnoseOptions};
use stiction::fit::{Fit, FitOptions, Prospect, Prospects, fit};
use stiction::fusion::Estimate;
use stiction::recording::LoopType;
use stiction::spoken::{rough, set};
use stiction_io::scenario::{Scenario, System};
use stiction_report::document::Source;

/// Identify controller, process and valve from a recording, with intervals, and test whether the valve explains the
/// recorded swing.
///
/// Compares the recorded swing with the limit cycle of the fitted loop, and with the swing that would remain with a
/// valve that follows. If the cycle agrees, or little swing would remain, a sticking valve explains the swing.
/// Otherwise something else makes the loop swing. Parts that cannot be identified are listed with the reason. -o
/// writes the loop as a scenario for simulate, limit-cycle, compensate, what-if and fmu.
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
    /// Number of loops to draw from the possible ones
    #[arg(long, default_value_t = FitOptions::default().draws, value_name = "N")]
    draws: usize,
    /// Seed of the drawn loops
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
    /// The file it comes from.
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

fn interval(of: &Estimate, unit: &str) -> String {
    format!("{} {unit} ({} to {})", set(of.value), set(of.low), set(of.high))
}

fn in_words(each: &Fitted) -> String {
    let diagnosis = &each.diagnosed.diagnosis;
    let mut out = format!("{}\n", output::name(&diagnosis.name));
    let mut row = |name: &str, words: String| {
        out += &text::hanging(&format!("  {name:12}"), &words, 82);
    };
    let fit = match &each.fit {
        Ok(fit) => fit,
        Err(why) => {
            row("not fitted", why.clone());
            return out;
        }
    };
    let unit = diagnosis.pv_unit.clone().unwrap_or_else(|| "PV".to_owned());
    match fit.controller.known() {
        None => row("controller", not(fit.controller.why_not())),
        Some(c) => {
            let mut words =
                format!("{}, Kc {}", c.structure.name(), interval(&c.kc, &format!("%/{unit}")));
            if let Some(ti) = &c.ti_s {
                words += &format!(", Ti {}", interval(ti, "s"));
            }
            if let Some(td) = &c.td_s {
                words += &format!(", Td {}", interval(td, "s"));
            }
            words += &match c.execution_s {
                Some(every) => format!("; executes every {} s", number(every)),
                None => "; the execution interval cannot be determined".to_owned(),
            };
            if let Some(sp) = &c.set_point {
                words += &format!("; SP not recorded, assumed constant at {}", interval(sp, &unit));
            }
            if c.gap > 0.0 {
                words += &format!("; gap of ±{} {unit}", number(c.gap));
            }
            let limits: Vec<String> =
                [c.low, c.high].iter().flatten().map(|v| number(*v)).collect();
            if !limits.is_empty() {
                words += &format!("; saturates at {} %", limits.join(" and "));
            }
            // Rounded down, because 1 would claim too much.
            let r2 = (c.explained * 1e5).floor() / 1e5;
            words += &format!("; fits the OP increments with R² = {r2}");
            row("controller", words);
        }
    }
    match fit.valve.known() {
        None => row("valve", not(fit.valve.why_not())),
        Some(valve) if valve.follows > 0.5 => row(
            "valve",
            format!(
                "probably follows its OP ({:.0} % of the fitted loops); if it sticks, S {}",
                100.0 * valve.follows,
                interval(&valve.s, "%")
            ),
        ),
        Some(valve) => row(
            "valve",
            format!(
                "{}, S {}, J {}, by {}",
                valve.model.as_deref().unwrap_or("as measured"),
                interval(&valve.s, "%"),
                interval(&valve.j, "%"),
                valve.from
            ),
        ),
    }
    match fit.process.known() {
        None => row("process", not(fit.process.why_not())),
        Some(p) => {
            let mut words = p.kind.name().to_owned();
            match (&p.gain, &p.lag_s) {
                (None, None) => {
                    words += &format!(
                        ", initial slope {}",
                        interval(&p.slope, &format!("{unit}/s per %"))
                    );
                }
                (gain, lag) => {
                    if let Some(gain) = gain {
                        words += &format!(", gain {}", interval(gain, &format!("{unit}/%")));
                    }
                    if let Some(lag) = lag {
                        words += &format!(", lag {}", interval(lag, "s"));
                    }
                }
            }
            words += &format!(", dead time {}", interval(&p.dead_time_s, "s"));
            if let Some(jointly) = &p.jointly {
                words += &format!("; {jointly}");
            }
            row("process", words);
        }
    }
    match fit.cycle.known() {
        None => row("explained?", not(fit.cycle.why_not())),
        Some(cycle) => row("explained?", cycle.sentence.clone()),
    }
    out
}

fn not(why: Option<&str>) -> String {
    format!("not identified: {}", why.unwrap_or("reason unknown"))
}

/// The effects of actions, as text.
pub fn prospects_in_words(name: &str, found: &Prospects) -> String {
    let head = [
        "action",
        "PV swing ±",
        "x present",
        "error",
        "x present",
        "travel %/h",
        "load s",
        "benefit",
    ];
    let mut rows: Vec<Vec<String>> = vec![head.map(str::to_owned).to_vec()];
    let range = |of: &Estimate| format!("{} to {}", rough(of.low), rough(of.high));
    for row in &found.actions {
        rows.push(vec![
            row.action.name().to_owned(),
            Prospect::range(&row.pv_swing, &row.pv_swing_ratio),
            Prospect::range(&row.pv_swing_ratio, &row.pv_swing_ratio),
            Prospect::range(&row.error, &row.error_ratio),
            Prospect::range(&row.error_ratio, &row.error_ratio),
            range(&row.travel),
            row.settling_s.as_ref().map_or("-".to_owned(), range),
            row.benefit().to_owned(),
        ]);
    }
    let mut out = format!(
        "{}: effects of actions, on {} loops that agree with the recording\n\n{}\n",
        output::name(name),
        found.loops,
        text::columns(&rows, &[false, true, true, true, true, true, true, false])
    );
    let words = "Ranges are 5 to 95 % points. Rows are ranked by the upper end of the control error and, if two are about \
        equal, by effort: a setting, a compensator, a repair, a new part. PV swing is half of its \
        peak-to-peak value in a period, without noise. \"x present\" is the ratio to the loop as it is. Error is the \
        mean absolute control error. Load s is the settling time after a load step, - if the loop does not settle. \
        The benefit is certain if PV swing falls by more than 20 % with a probability of at least 95 %, and \
        probable above 50 %. Below that it is not certain.";
    out += &text::paragraph(words);
    if !found.advice.is_empty() {
        out += "\nActions\n";
    }
    for sentence in &found.advice {
        out += &text::hanging("- ", sentence, 94);
    }
    out
}
