//! `stiction limit-cycle`: predicts the cycle of a loop instead of simulating it.

mod args;
mod csv;
mod text;

pub use args::Args;

use crate::actions::{self, Valve};
use crate::files::Out;
use crate::output;
use anyhow::{Context, Result, bail};
use schemars::JsonSchema;
use serde::Serialize;
use stiction::drawing::limit_cycle as pictures;
use stiction::drawing::nyquist::nyquist;
use stiction::limit_cycle::exact;
use stiction::limit_cycle::map::{Map, Sensitivity, sensitivities};
use stiction::limit_cycle::tuning::{self, Retuning, TuningGrid};
use stiction::limit_cycle::{ContinuousLoop, Cycle, Found, Method, attractor};
use stiction_io::scenario::System;

/// All results, as `stiction limit-cycle --json` prints them.
#[derive(Serialize, JsonSchema)]
pub struct Report {
    /// Name and version of the program.
    tool: &'static str,
    /// Name of the scenario, as given; null for a loop given by flags.
    scenario: Option<String>,
    /// Title.
    title: String,
    /// The loop.
    #[serde(rename = "loop")]
    continuous: Loop,
    /// The cycles found by all methods.
    cycles: Vec<Cycle>,
    /// The result of each method.
    #[serde(rename = "methods")]
    found: Vec<Found>,
    /// Change of the cycle in percent per percent of each parameter, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivities: Option<Vec<Sensitivity>>,
    /// The robust tuning with the smallest swing of the PV, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    retuning: Option<Retuning>,
    /// The cycles over two parameters, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<Map>,
}

/// A loop in continuous time.
#[derive(Serialize, JsonSchema)]
struct Loop {
    controller: Gains,
    process: TransferFunction,
    valve: Valve,
    /// Set point, PV units.
    set_point: f64,
    /// Load, percent, added to the valve position.
    load: f64,
}

/// The gains of a controller in parallel form.
#[derive(Serialize, JsonSchema)]
struct Gains {
    /// Proportional, percent per PV unit.
    kp: f64,
    /// Integral, percent per PV unit and second.
    ki: f64,
    /// Derivative, percent per PV unit per second.
    kd: f64,
    /// Time constant of the filter of the derivative, s.
    filter_s: f64,
}

/// A transfer function with dead time, as coefficients of falling powers of the Laplace variable.
#[derive(Serialize, JsonSchema)]
struct TransferFunction {
    num: Vec<f64>,
    den: Vec<f64>,
    dead_time_s: f64,
}

impl From<&ContinuousLoop> for Loop {
    fn from(l: &ContinuousLoop) -> Self {
        let (kp, ki, kd) = l.controller.gains();
        let (num, den) = l.process.coefficients();
        Self {
            controller: Gains { kp, ki, kd, filter_s: l.controller.filter_s() },
            process: TransferFunction { num, den, dead_time_s: l.process.dead_time() },
            valve: Valve::new(l.model, l.bands),
            set_point: l.set_point,
            load: l.load,
        }
    }
}

pub fn run(args: Args) -> Result<()> {
    let (title, continuous) = match &args.scenario {
        Some(name) => of_scenario(name, &args.set)?,
        None => ("Limit cycle".to_owned(), args.flags.continuous()?),
    };
    let (methods, axes) = (args.methods(), args.axes()?);
    let found = search(&continuous, &methods, args.all)?;
    let mut report = Report {
        tool: output::TOOL,
        scenario: args.scenario.clone(),
        title,
        continuous: Loop::from(&continuous),
        cycles: found.iter().flat_map(|found| &found.cycles).cloned().collect(),
        found,
        sensitivities: None,
        retuning: None,
        map: None,
    };
    if args.sensitivity {
        report.sensitivities = Some(sensitivities(&continuous).context("--sensitivity")?);
    }
    if args.retune {
        report.retuning = Some(retune(&continuous, methods[0], args.ms).context("--retune")?);
    }
    if let Some((x, y)) = axes {
        report.map = Some(Map::of(&continuous, x, y, methods[0]).context("--map")?);
    }
    write_files(&args, &report, &continuous)?;
    if args.json {
        output::json(&report)
    } else if args.csv.as_ref().is_some_and(Out::is_standard) {
        Ok(())
    } else {
        output::text(&report.text(&continuous, args.all))
    }
}

/// The result of each method. If all methods refuse the loop, this is an error.
fn search(l: &ContinuousLoop, methods: &[Method], all: bool) -> Result<Vec<Found>> {
    let results: Vec<_> = methods.iter().map(|m| (*m, Found::of(l, *m, all))).collect();
    if let (true, Some((_, Err(first)))) =
        (results.iter().all(|(_, found)| found.is_err()), results.first())
    {
        bail!("{first}");
    }
    let each = |(method, found): (Method, stiction::Result<Found>)| {
        let mut found = found.unwrap_or_else(|e| Found::refused(method, e.to_string()));
        if found.cycles.is_empty() && found.passed_over > 0 {
            found.notes.iter_mut().for_each(|note| *note += "; --all shows them");
        }
        found
    };
    Ok(results.into_iter().map(each).collect())
}

/// Title and loop of a scenario, with a note on settings that do not affect a limit cycle.
fn of_scenario(name: &str, settings: &[String]) -> Result<(String, ContinuousLoop)> {
    let scenario = actions::scenario(name, settings)?;
    let system = match &scenario.system {
        System::ClosedLoop(system) => system,
        System::OpenLoop(_) => bail!(
            "{name} is a valve on a test signal; a limit cycle needs a loop, with [controller] and [process]"
        ),
        System::Cascade(_) => bail!(
            "{name} is a cascade, but the limit cycle is predicted for a single loop; write the slave, without \
             [master], as a scenario of its own"
        ),
    };
    let (model, bands) = scenario.valve;
    let aside = scenario.no_part_in_cycles();
    if !aside.is_empty() {
        output::note(format!("these settings do not affect the prediction: {}", aside.join(", ")));
    }
    Ok((scenario.title, ContinuousLoop::of(system, model, bands)?))
}

/// The tuning with the smallest swing of the PV, searched around the present one.
fn retune(l: &ContinuousLoop, method: Method, ms: f64) -> Result<Retuning> {
    const FACTOR: f64 = 5.0;
    const POINTS: usize = 21;
    let grid = TuningGrid::about(&l.controller, FACTOR, POINTS)?;
    let cycle = |l: &ContinuousLoop| attractor(l, method).map(std::result::Result::ok);
    Ok(tuning::least_swing(l, &grid, ms, cycle)?)
}

fn write_files(args: &Args, report: &Report, l: &ContinuousLoop) -> Result<()> {
    /// Samples per period.
    const SAMPLES: usize = 1_000;
    if let Some(path) = &args.nyquist {
        let own = l.bands.j() / l.bands.s();
        let mut ratios = vec![0.2, 0.6, 1.0];
        if own.is_finite() && ratios.iter().all(|ratio: &f64| (ratio - own).abs() > 0.05) {
            ratios.push((own * 1e4).round() / 1e4);
        }
        ratios.sort_by(f64::total_cmp);
        output::figure(
            "--nyquist",
            path,
            &nyquist(&report.title, l, &ratios).context("--nyquist")?,
        )?;
    }
    if let Some(map) = &report.map {
        output::given(&args.csv, || csv::map(map))?;
        return output::plot(&args.plot, || {
            Ok(pictures::map(&report.title, map, l, args.show.quantity())?)
        });
    }
    if args.csv.is_none() && args.plot.is_none() {
        return Ok(());
    }
    let Some((cycle, orbit)) = exact::trajectory(l, SAMPLES)? else {
        output::note("there is no exact cycle to draw or to write");
        return Ok(());
    };
    output::given(&args.csv, || anyhow::Ok(csv::orbit(&orbit)))?;
    output::plot(&args.plot, || {
        let set_point = l.operating_point()?.pv;
        Ok(pictures::over_time(&report.title, &cycle, &orbit, set_point))
    })
}
