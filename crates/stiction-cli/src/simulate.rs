//! `stiction simulate`: runs scenarios.

use crate::actions::{self, Head, Settings};
use crate::files::Out;
use crate::output;
use anyhow::{Context, Result, bail};
use clap::Parser;
use schemars::JsonSchema;
use serde::Serialize;
use stiction::closed_loop::Run;
use stiction::drawing::run;
use stiction_figure::Figure;
use stiction_io::scenario::{self, Scenario, System};
use stiction_io::table::{self, Cells};

/// Simulate a scenario: a valve on a test signal, a control loop, or a cascade.
///
/// The CSV has the columns t, sp, pv, op, vp, and mode if the scenario has periods in manual. Columns of signals that
/// the scenario lacks are empty. Without an output option, a summary is printed.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction simulate paper/closed-loop --set valve.S=4 -o run.csv --plot run.svg
  stiction simulate paper/closed-loop --print > my-loop.toml
  stiction simulate my-loop.toml --json")]
pub struct Args {
    /// List the built-in scenarios
    #[arg(long)]
    list: bool,
    /// Name of a built-in scenario, or a TOML file
    #[arg(required_unless_present = "list")]
    scenario: Option<String>,
    /// Change a key of the scenario, such as valve.S=4; may be given several times
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print the scenario as TOML, with all changes, instead of simulating it
    #[arg(long)]
    print: bool,
    /// Write every sample to this CSV file; - is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<Out>,
    /// Write only these columns, such as t,sp,pv,op as in a plant that does not record the valve position
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "output")]
    columns: Vec<String>,
    /// Draw the run to this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<Out>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

/// The results of a run.
struct Report {
    period_s: Option<f64>,
    /// Half peak-to-peak values of OP, VP and PV over the last half.
    half_pp: [Option<f64>; 3],
    growth: Option<f64>,
    csv: Option<String>,
    figure: Option<Figure>,
}

/// The requested parts of a report. For a long run, text and figure take most of the time and memory.
#[derive(Clone, Copy)]
struct Wanted<'a> {
    csv: bool,
    /// The columns of the CSV; all if empty.
    columns: &'a [String],
    figure: bool,
}

pub fn run(args: Args) -> Result<()> {
    if args.list {
        for (name, title) in scenario::built_in() {
            output::line(format!("{name:26} {title}"))?;
        }
        return Ok(());
    }
    let name = args.scenario.context("no scenario")?;
    let scenario = actions::scenario(&name, &args.set)?;
    if args.print {
        return output::write(None, scenario.text.as_bytes());
    }
    let wanted =
        Wanted { csv: args.output.is_some(), columns: &args.columns, figure: args.plot.is_some() };
    let report = simulate(&scenario, wanted)?;
    if let (Some(path), Some(figure)) = (&args.plot, &report.figure) {
        output::figure("--plot", path, figure)?;
    }
    if let (Some(path), Some(csv)) = (&args.output, &report.csv) {
        output::write(Some(path), csv.as_bytes())?;
    }
    if args.json {
        output::json(&document(&name, &scenario, &report)?)?;
    } else if args.output.is_none() && args.plot.is_none() {
        summarise(&scenario, &report)?;
    }
    Ok(())
}

/// The CSV of a scenario with these columns, as `stiction simulate` writes it.
pub fn recorded(scenario: &Scenario, columns: &[String]) -> Result<String> {
    let report = simulate(scenario, Wanted { csv: true, columns, figure: false })?;
    report.csv.context("a run without samples")
}

fn simulate(scenario: &Scenario, wanted: Wanted<'_>) -> Result<Report> {
    let title = &scenario.title;
    Ok(match &scenario.system {
        System::OpenLoop(system) => {
            let done = system.run()?;
            check_finite(done.sample_time, &[("OP", &done.op), ("VP", &done.vp)])?;
            Report {
                period_s: done.period_s(),
                half_pp: [Some(done.half_pp(&done.op)), Some(done.half_pp(&done.vp)), None],
                growth: None,
                csv: wanted.csv(
                    done.sample_time,
                    [None, None, Some(&done.op), Some(&done.vp)],
                    &[],
                )?,
                figure: wanted.figure.then(|| run::open_loop(title, &done)),
            }
        }
        System::ClosedLoop(system) => {
            let done = system.run()?;
            let mode = |k| if system.in_manual(k) { "MAN" } else { "AUTO" };
            let modes: Vec<&str> = match system.manual.len() {
                0 => vec![],
                _ => (0..done.op.len()).map(mode).collect(),
            };
            let more = [("mode", Cells::Words(&modes))];
            closed_loop_report(
                &done,
                wanted.figure.then(|| run::closed_loop(title, &done)),
                wanted,
                if modes.is_empty() { &[] } else { &more },
            )?
        }
        System::Cascade(system) => {
            let done = system.run()?;
            let master =
                [("master_sp", Cells::Numbers(&done.sp)), ("master_pv", Cells::Numbers(&done.pv))];
            check_finite(done.slave.sample_time, &[("the master's PV", &done.pv)])?;
            closed_loop_report(
                &done.slave,
                wanted.figure.then(|| run::cascade(title, &done)),
                wanted,
                &master,
            )?
        }
    })
}

fn closed_loop_report(
    done: &Run,
    figure: Option<Figure>,
    wanted: Wanted<'_>,
    more: &[(&str, Cells<'_>)],
) -> Result<Report> {
    let signals = [("PV", &done.pv[..]), ("OP", &done.op), ("VP", &done.vp)];
    check_finite(done.sample_time, &signals)?;
    let columns = [Some(&done.sp), Some(&done.pv), Some(&done.op), Some(&done.vp)];
    Ok(Report {
        period_s: done.period_s(),
        half_pp: [&done.op, &done.vp, &done.pv].map(|signal| Some(done.half_pp(signal))),
        growth: done.growth(),
        csv: wanted.csv(done.sample_time, columns, more)?,
        figure,
    })
}

/// Checks that every sample is finite, because samples after an overflow are meaningless.
fn check_finite(sample_time: f64, signals: &[(&str, &[f64])]) -> Result<()> {
    for (name, signal) in signals {
        if let Some(k) = signal.iter().position(|value| !value.is_finite()) {
            bail!(
                "{name} overflows at t = {} s: the system is unstable, or a number in the scenario \
                 is far too large; lower the controller's gain, or shorten the duration",
                k as f64 * sample_time
            );
        }
    }
    Ok(())
}

impl Wanted<'_> {
    /// The requested columns as CSV, if requested.
    fn csv(
        &self,
        sample_time: f64,
        columns: [Option<&Vec<f64>>; 4],
        more: &[(&str, Cells<'_>)],
    ) -> Result<Option<String>> {
        if !self.csv {
            return Ok(None);
        }
        let samples = columns.iter().flatten().map(|c| c.len()).max().unwrap_or(0);
        let times = table::times(sample_time, samples);
        let [sp, pv, op, vp] =
            columns.map(|column| column.map_or(Cells::Empty, |c| Cells::Numbers(c)));
        let mut all =
            vec![("t", Cells::Numbers(&times)), ("sp", sp), ("pv", pv), ("op", op), ("vp", vp)];
        all.extend(more);
        if !self.columns.is_empty() {
            let known = all.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
            let chosen = self.columns.iter().map(|wanted| {
                all.iter().find(|(name, _)| name == wanted).copied().with_context(|| {
                    format!("--columns: no column \"{wanted}\"; there are {known}")
                })
            });
            all = chosen.collect::<Result<_>>()?;
        }
        Ok(Some(table::write_cells(&all)))
    }
}

/// What `stiction simulate --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    #[serde(flatten)]
    head: Head,
    /// The period, s; null if none is found.
    period_s: Option<f64>,
    /// Half of the peak-to-peak values.
    half_pp: HalfPp,
    /// Ratio of the PV swing in the last quarter to the swing in the quarter before; null without a PV.
    growth: Option<f64>,
    /// The part of the run that was analysed.
    window: &'static str,
    /// The scenario, key by key.
    settings: Settings,
}

/// Half of the peak-to-peak values; null for signals that the scenario lacks.
#[derive(Serialize, JsonSchema)]
struct HalfPp {
    /// Of the OP, percent of span.
    op: Option<f64>,
    /// Of the VP, percent of span.
    vp: Option<f64>,
    /// Of the PV, in its units.
    pv: Option<f64>,
}

fn document(name: &str, scenario: &Scenario, report: &Report) -> Result<Document> {
    let (head, settings) = Head::of(name, scenario)?;
    let [op, vp, pv] = report.half_pp;
    Ok(Document {
        head,
        period_s: report.period_s,
        half_pp: HalfPp { op, vp, pv },
        growth: report.growth,
        window: "last half of the run",
        settings,
    })
}

fn summarise(scenario: &Scenario, report: &Report) -> Result<()> {
    output::line(&scenario.title)?;
    let period = report.period_s.map_or("none found".to_owned(), |t| format!("{t:.4} s"));
    output::line(format!("period                {period}"))?;
    for (name, value) in ["OP", "VP", "PV"].iter().zip(report.half_pp) {
        if let Some(value) = value {
            let unit = if *name == "PV" { "" } else { " %" };
            output::line(format!("half peak-to-peak {name}  {value:.5}{unit}"))?;
        }
    }
    if let Some(growth) = report.growth {
        let word = if growth < 0.95 {
            "dies out"
        } else if growth > 1.05 {
            "grows"
        } else {
            "persists"
        };
        output::line(format!("PV swing, last over previous quarter: {growth:.3} ({word})"))?;
    }
    output::line("(over the last half of the run)")
}
