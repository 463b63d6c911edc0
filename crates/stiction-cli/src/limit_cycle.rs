//! `stiction limit-cycle`: the cycle of a loop, predicted instead of simulated.

use crate::{actions, output, text, valve};
use anyhow::{Context, Result, bail, ensure};
use clap::{Parser, ValueEnum};
use serde_json::{Value, json};
use std::path::PathBuf;
use stiction::Bands;
use stiction::closed_loop::{Controller, Process};
use stiction::limit_cycle::exact::{self, Outcome};
use stiction::limit_cycle::harmonic_balance::{Balance, harmonic_balance};
use stiction::limit_cycle::map::{Axis, Map, Parameter, Point, Sensitivity, sensitivities};
use stiction::limit_cycle::tuning::{self, Assessment, Grid, Retuning};
use stiction::limit_cycle::{ContinuousLoop, Cycle, Method, Swing, attractor};
use stiction::valve::Model;
use stiction_figure::limit_cycle::{self as pictures, Quantity};
use stiction_figure::nyquist::nyquist;
use stiction_io::scenario::System;
use stiction_io::table;

/// Predict the limit cycle of a loop with a sticking valve, exactly and by describing function.
///
/// The loop is a scenario or given by flags. It is looked at in continuous time, at its last set point and
/// load, without noise and far from the limits of the OP. That it does not cycle is a result, with its
/// reason. docs/limit-cycles.md says what the numbers mean.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction limit-cycle paper/closed-loop --set valve.J=2 --plot cycle.svg
  stiction limit-cycle --gain 1.5 --tau 5.93 --dead-time 1.07 --kc 1.1 --ti 2.5 --S 5 --J 3 --retune
  stiction limit-cycle paper/closed-loop --map S=1:10:200 J=0:6:200 --show period --plot map.png
  stiction limit-cycle choudhury/level --all --sensitivity --json")]
pub struct Args {
    /// Name of a built-in scenario, or a TOML file
    #[arg(required_unless_present_any = ["gain", "kc"])]
    scenario: Option<String>,
    /// Change a key of the scenario, such as valve.S=4; may be given several times
    #[arg(long, value_name = "KEY=VALUE", requires = "scenario")]
    set: Vec<String>,
    #[command(flatten)]
    flags: Flags,
    /// Only the exact method
    #[arg(long)]
    exact: bool,
    /// Only the describing function; with --exact, both, as without either
    #[arg(long)]
    describing_function: bool,
    /// Every cycle that is found, also those that do not attract, and other ends of the loop
    #[arg(long)]
    all: bool,
    /// Map the cycles over two of S, J, J/S, Kc, Ti, Kp, theta, tau, theta/tau, each as
    /// NAME=FROM:TO or NAME=FROM:TO:POINTS
    #[arg(long, num_args = 2, value_names = ["X", "Y"])]
    map: Option<Vec<String>>,
    /// What the picture of the map shows
    #[arg(long, value_enum, default_value = "pv", requires = "map")]
    show: Show,
    /// Write the map, or the exact cycle over one period, to this CSV file; - is standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the map, or the exact cycle over time, to this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Draw the loop's frequency response and -1/N(X) of its valve to this file, .svg or .png
    #[arg(long, value_name = "FILE")]
    nyquist: Option<PathBuf>,
    /// By how many percent the cycle changes with a percent of each parameter
    #[arg(long)]
    sensitivity: bool,
    /// Find the robust PI tuning with which the PV swings least, and what it costs
    #[arg(long)]
    retune: bool,
    /// Largest peak of the sensitivity function that --retune allows
    #[arg(long, default_value_t = tuning::PEAK_SENSITIVITY, requires = "retune")]
    ms: f64,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

/// A loop by flags.
#[derive(clap::Args)]
#[group(id = "loop", multiple = true, conflicts_with = "scenario")]
struct Flags {
    /// Gain of the process, PV units per percent; of an integrating one, per percent and second
    #[arg(long, value_name = "GAIN", allow_negative_numbers = true)]
    gain: Option<f64>,
    /// Time constant of the process, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    tau: Option<f64>,
    /// Second time constant, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    tau2: Option<f64>,
    /// The process integrates
    #[arg(long, conflicts_with = "tau2")]
    integrating: bool,
    /// Dead time of the process, s [default: 0]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dead_time: Option<f64>,
    /// Gain of the controller, percent per PV unit
    #[arg(long, value_name = "GAIN", allow_negative_numbers = true)]
    kc: Option<f64>,
    /// Integral time, s [default: no integral action]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    ti: Option<f64>,
    /// Derivative time, s; it is filtered with a tenth of it
    #[arg(long, value_name = "S", requires = "ti", allow_negative_numbers = true)]
    td: Option<f64>,
    /// Name of the valve model [default: two-phase]
    #[arg(long, value_name = "NAME")]
    model: Option<String>,
    /// Stick band plus dead band, percent of span
    #[arg(long = "S", value_name = "PERCENT", allow_negative_numbers = true)]
    s: Option<f64>,
    /// Slip jump, percent of span
    #[arg(long = "J", value_name = "PERCENT", allow_negative_numbers = true)]
    j: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Show {
    Period,
    Op,
    Vp,
    Pv,
}

impl Show {
    fn quantity(self) -> Quantity {
        match self {
            Self::Period => Quantity::Period,
            Self::Op => Quantity::Op,
            Self::Vp => Quantity::Vp,
            Self::Pv => Quantity::Pv,
        }
    }
}

pub fn run(args: Args) -> Result<()> {
    let (title, continuous) = match &args.scenario {
        Some(name) => of_scenario(name, &args.set)?,
        None => ("Limit cycle".to_owned(), args.flags.continuous()?),
    };
    let methods = match (args.exact, args.describing_function) {
        (true, false) => vec![Method::Exact],
        (false, true) => vec![Method::DescribingFunction],
        _ => vec![Method::Exact, Method::DescribingFunction],
    };
    let axes = args
        .map
        .as_deref()
        .map(|texts| Ok::<_, anyhow::Error>((axis(&texts[0])?, axis(&texts[1])?)));
    let axes = axes.transpose()?;

    let ends: Vec<End> =
        methods.iter().map(|method| End::of(&continuous, *method, args.all)).collect();
    if let Some(first) = ends.iter().find(|_| ends.iter().all(|end| end.refused)) {
        bail!("{}", first.notes.join("; "));
    }
    let mut report = Report { title, ends, ..Report::of(&continuous) };
    if args.sensitivity {
        report.sensitivities = Some(sensitivities(&continuous).context("--sensitivity")?);
    }
    if args.retune {
        report.retuning =
            Some((retune(&continuous, methods[0], args.ms).context("--retune")?, args.ms));
    }
    if let Some((x, y)) = axes {
        report.map = Some(Map::of(&continuous, x, y, methods[0]).context("--map")?);
    }
    write_files(&args, &report, &continuous)?;
    if args.json {
        output::line(serde_json::to_string_pretty(&report.json(&args, &continuous))?)
    } else if args.csv.as_ref().is_some_and(|path| path.as_os_str() == "-") {
        Ok(())
    } else {
        output::write(None, report.text(&continuous, args.all).as_bytes())
    }
}

/// Title and loop of a scenario, and a word on what of it has no part in a limit cycle.
fn of_scenario(name: &str, settings: &[String]) -> Result<(String, ContinuousLoop)> {
    let scenario = actions::scenario(name, settings)?;
    let system = match &scenario.system {
        System::ClosedLoop(system) => system,
        System::OpenLoop(_) => bail!(
            "{name} is a valve on a test signal; a limit cycle needs a loop, with [controller] and [process]"
        ),
        System::Cascade(_) => bail!(
            "{name} is a cascade; the limit cycle is predicted of a single loop: write the slave, without \
             [master], as a scenario of its own"
        ),
    };
    let (model, bands) = scenario.valve;
    let aside = scenario.no_part_in_cycles();
    if !aside.is_empty() {
        output::note(format!("these have no part in the prediction: {}", aside.join(", ")));
    }
    Ok((scenario.title, ContinuousLoop::of(system, model, bands)?))
}

impl Flags {
    fn continuous(&self) -> Result<ContinuousLoop> {
        let gain = self.gain.context("the loop lacks --gain, that of the process")?;
        let kc = self.kc.context("the loop lacks --kc, the gain of the controller")?;
        let dead_time = self.dead_time.unwrap_or(0.0);
        let process = match (self.integrating, self.tau, self.tau2) {
            (false, None, _) => bail!("the loop lacks --tau, the time constant, or --integrating"),
            (false, Some(tau), None) => Process::first_order(gain, tau, dead_time),
            (false, Some(tau), Some(tau2)) => Process::second_order(gain, tau, tau2, dead_time),
            (true, None, _) => Process::integrator(gain, dead_time),
            (true, Some(tau), _) => {
                ensure!(tau > 0.0, "--tau is {tau}, but must be above 0");
                Process::transfer_function(&[gain], &[tau, 1.0, 0.0], dead_time)
            }
        }?;
        let controller = match self.ti {
            None => Controller::p(kc),
            Some(ti) => Controller::pid(kc, ti, self.td.unwrap_or(0.0)),
        }?;
        let model = Model::by_name(self.model.as_deref().unwrap_or("two-phase"))?;
        let bands: Bands = valve::bands(model, self.s, self.j)?;
        model.build(bands)?;
        Ok(ContinuousLoop::new(controller, process, model, bands))
    }
}

/// The axis of a map from `NAME=FROM:TO` or `NAME=FROM:TO:POINTS`.
fn axis(text: &str) -> Result<Axis> {
    const POINTS: usize = 100;
    const MOST: usize = 2_000;
    let wrong = || format!("--map {text}: write NAME=FROM:TO:POINTS, such as S=1:10:200");
    let (name, range) = text.split_once('=').with_context(wrong)?;
    let parameter = Parameter::by_name(name).with_context(|| format!("--map {text}"))?;
    let parts: Vec<&str> = range.split(':').collect();
    let (from, to, points) = match parts[..] {
        [from, to] => (from, to, None),
        [from, to, points] => (from, to, Some(points)),
        _ => bail!(wrong()),
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().with_context(wrong);
    let points =
        points.map_or(Some(POINTS), |text| text.trim().parse().ok()).with_context(wrong)?;
    let (from, to) = (number(from)?, number(to)?);
    ensure!(from != to, "--map {text}: the range is empty");
    ensure!((2..=MOST).contains(&points), "--map {text}: {points} points, but must be 2 to {MOST}");
    Axis::even(parameter, from, to, points).with_context(|| format!("--map {text}"))
}

/// What a method found.
struct End {
    method: Method,
    /// Whether the method cannot say.
    unknown: bool,
    /// Whether the method cannot treat such a loop.
    refused: bool,
    cycles: Vec<Cycle>,
    /// Why there is no cycle, or what other motions do.
    notes: Vec<String>,
}

impl End {
    fn of(l: &ContinuousLoop, method: Method, all: bool) -> Self {
        let mut end =
            Self { method, unknown: false, refused: false, cycles: vec![], notes: vec![] };
        let found = match method {
            Method::Exact => end.exact(l, all),
            Method::DescribingFunction => end.describing_function(l, all),
        };
        if let Err(error) = found {
            (end.unknown, end.refused) = (true, true);
            end.notes.push(error.to_string());
        }
        end
    }

    fn exact(&mut self, l: &ContinuousLoop, all: bool) -> stiction::Result<()> {
        match if all { exact::cycles(l) } else { exact::cycle(l) }? {
            Outcome::Cycles { cycles, beside, unsettled } => {
                self.cycles = cycles;
                self.notes = beside.iter().map(ToString::to_string).collect();
                self.notes.extend(unsettled);
            }
            Outcome::None { reasons } => {
                self.notes = reasons.iter().map(ToString::to_string).collect();
            }
            Outcome::NotFound { reason } => {
                self.unknown = true;
                self.notes.push(reason);
            }
        }
        Ok(())
    }

    fn describing_function(&mut self, l: &ContinuousLoop, all: bool) -> stiction::Result<()> {
        match harmonic_balance(l)? {
            Balance::Cycles(cycles) if all => self.cycles = cycles,
            balance @ Balance::Cycles(_) => match balance.attracting() {
                Some(cycle) => self.cycles.push(cycle.clone()),
                None => self.notes.push("its cycles do not attract; --all shows them".to_owned()),
            },
            Balance::None(reason) => self.notes.push(reason.to_string()),
        }
        Ok(())
    }

    fn word(&self) -> &'static str {
        match (self.unknown, self.cycles.is_empty()) {
            (true, _) => "not known",
            (_, true) => "no cycle",
            (_, false) => "cycle",
        }
    }
}

/// The tuning with the least swing of the PV about the present one.
fn retune(l: &ContinuousLoop, method: Method, ms: f64) -> Result<(Retuning, Grid)> {
    const FACTOR: f64 = 5.0;
    const POINTS: usize = 21;
    let grid = Grid::about(&l.controller, FACTOR, POINTS)?;
    let cycle = |l: &ContinuousLoop| attractor(l, method).map(std::result::Result::ok);
    Ok((tuning::least_swing(l, &grid, ms, cycle)?, grid))
}

/// All there is to tell.
struct Report {
    title: String,
    ends: Vec<End>,
    sensitivities: Option<Vec<Sensitivity>>,
    /// With the bound on Ms.
    retuning: Option<((Retuning, Grid), f64)>,
    map: Option<Map>,
    /// The process and the rest of the loop, in words.
    description: String,
}

fn write_files(args: &Args, report: &Report, l: &ContinuousLoop) -> Result<()> {
    /// Of a period.
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
        if let Some(path) = &args.csv {
            output::write(Some(path), map_csv(map)?.as_bytes())?;
        }
        if let Some(path) = &args.plot {
            let figure = pictures::map(&report.title, map, args.show.quantity())?;
            output::figure("--plot", path, &figure)?;
        }
        return Ok(());
    }
    if args.csv.is_none() && args.plot.is_none() {
        return Ok(());
    }
    let Some((cycle, orbit)) = exact::trajectory(l, SAMPLES)? else {
        output::note("there is no exact cycle to draw or to write");
        return Ok(());
    };
    if let Some(path) = &args.csv {
        let columns =
            [("t", &orbit.time_s), ("op", &orbit.op), ("vp", &orbit.vp), ("pv", &orbit.pv)];
        let columns = columns.map(|(name, values)| (name, Some(&values[..])));
        output::write(Some(path), table::write(&columns).as_bytes())?;
    }
    if let Some(path) = &args.plot {
        let set_point = l.operating_point()?.pv;
        output::figure(
            "--plot",
            path,
            &pictures::over_time(&report.title, &cycle, &orbit, set_point),
        )?;
    }
    Ok(())
}

/// A row for each point of a map.
fn map_csv(map: &Map) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    let names = [map.x.parameter.name(), map.y.parameter.name()];
    let head = ["state", "period_s", "half_pp_op", "half_pp_vp", "half_pp_pv", "slips", "reason"];
    writer.write_record(names.iter().chain(&head))?;
    for (row, y) in map.y.values.iter().enumerate() {
        for (column, x) in map.x.values.iter().enumerate() {
            let Some(point) = map.at(column, row) else { continue };
            let mut record = vec![x.to_string(), y.to_string(), state(point).to_owned()];
            match point {
                Point::Cycle { period_s, half_pp, slips } => {
                    let numbers = [*period_s, half_pp.op, half_pp.vp, half_pp.pv];
                    record.extend(numbers.map(|value| value.to_string()));
                    record.extend([slips.to_string(), String::new()]);
                }
                Point::NoCycle { reason } | Point::Unknown { reason } => {
                    record.extend(std::iter::repeat_n(String::new(), 5));
                    record.push(reason.clone());
                }
            }
            writer.write_record(&record)?;
        }
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

fn state(point: &Point) -> &'static str {
    match point {
        Point::Cycle { .. } => "cycle",
        Point::NoCycle { .. } => "no cycle",
        Point::Unknown { .. } => "not known",
    }
}

/// Kc, Ti (none without integral action) and Td.
fn tuning_of(controller: &Controller) -> (f64, Option<f64>, f64) {
    let (kp, ki, kd) = controller.gains();
    (kp, (ki != 0.0).then(|| kp / ki), if kd == 0.0 { 0.0 } else { kd / kp })
}

impl Report {
    fn of(l: &ContinuousLoop) -> Self {
        let (kc, ti, td) = tuning_of(&l.controller);
        let ti = ti.map_or(String::new(), |ti| format!(", Ti {} s", text::number(ti)));
        let td = if td == 0.0 { String::new() } else { format!(", Td {} s", text::number(td)) };
        let description = format!(
            "process {}; controller Kc {}{ti}{td}; valve {}, S {} %, J {} %",
            process(&l.process),
            text::number(kc),
            l.model.describe().name,
            text::number(l.bands.s()),
            text::number(l.bands.j()),
        );
        Self {
            title: String::new(),
            ends: vec![],
            sensitivities: None,
            retuning: None,
            map: None,
            description,
        }
    }

    fn text(&self, l: &ContinuousLoop, all: bool) -> String {
        let mut out = format!("{}\n{}\n\n", self.title, self.description);
        out += &if all { every(&self.ends) } else { side_by_side(&self.ends) };
        for end in &self.ends {
            let notes = end.notes.join("; ");
            let name = end.method.name();
            out += &match end.word() {
                "cycle" if notes.is_empty() => String::new(),
                "cycle" => paragraph(&format!("Other motions ({name}): {notes}.")),
                "no cycle" => paragraph(&format!("No cycle ({name}): {notes}.")),
                _ => paragraph(&format!("Not known ({name}): {notes}.")),
            };
        }
        out += &missed(&self.ends);
        if let Some(found) = &self.sensitivities {
            out += &sensitivity_text(found);
        }
        if let Some(((retuning, grid), ms)) = &self.retuning {
            out += &retuning_text(retuning, grid, *ms, l);
        }
        if let Some(map) = &self.map {
            out += &map_text(map);
        }
        out
    }

    fn json(&self, args: &Args, l: &ContinuousLoop) -> Value {
        let (num, den) = l.process.coefficients();
        let (kp, ki, kd) = l.controller.gains();
        let mut value = json!({
            "tool": concat!("stiction ", env!("CARGO_PKG_VERSION")),
            "scenario": args.scenario,
            "title": self.title,
            "loop": {
                "controller": { "kp": kp, "ki": ki, "kd": kd, "filter_s": l.controller.filter_s() },
                "process": { "num": num, "den": den, "dead_time_s": l.process.dead_time() },
                "valve": { "model": l.model.describe().name, "S": l.bands.s(), "J": l.bands.j() },
                "set_point": l.set_point,
                "load": l.load,
            },
            "cycles": self.ends.iter().flat_map(|end| &end.cycles).map(cycle_json).collect::<Vec<_>>(),
            "methods": self.ends.iter().map(|end| json!({
                "method": end.method.name(),
                "state": end.word(),
                "notes": end.notes,
            })).collect::<Vec<_>>(),
        });
        if let Some(found) = &self.sensitivities {
            value["sensitivities"] = found
                .iter()
                .map(|each| {
                    json!({
                        "parameter": each.parameter.name(),
                        "unit": each.parameter.unit(),
                        "value": each.value,
                        "period": each.period,
                        "half_pp": swing_json(each.half_pp),
                    })
                })
                .collect();
        }
        if let Some(((retuning, grid), ms)) = &self.retuning {
            value["retuning"] = json!({
                "ms_bound": ms,
                "present": assessment_json(&retuning.present),
                "best": assessment_json(&retuning.best),
                "pv_ratio": retuning.swing_ratio(),
                "iae_ratio": retuning.iae_ratio(),
                "robust_tunings": retuning.robust,
                "unjudged_tunings": retuning.unjudged,
                "at_edge": tuning::at_edge(&retuning.best.controller, grid),
            });
        }
        if let Some(map) = &self.map {
            value["map"] = map_json(map);
        }
        value
    }
}

/// A transfer function in the Laplace variable s.
fn process(process: &Process) -> String {
    let (num, den) = process.coefficients();
    let polynomial = |coefficients: &[f64]| {
        let degree = coefficients.len() - 1;
        let mut sum = String::new();
        for (k, c) in coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            let power = match degree - k {
                0 => String::new(),
                1 => " s".to_owned(),
                n => format!(" s^{n}"),
            };
            let size = text::number(c.abs());
            let term = if size == "1" && !power.is_empty() {
                power.trim_start().to_owned()
            } else {
                size + &power
            };
            sum += match (sum.is_empty(), *c < 0.0) {
                (true, true) => "-",
                (true, false) => "",
                (false, true) => " - ",
                (false, false) => " + ",
            };
            sum += &term;
        }
        let several = coefficients.iter().filter(|c| **c != 0.0).count() > 1;
        if several { format!("({sum})") } else { sum }
    };
    let delay = match process.dead_time() {
        0.0 => String::new(),
        theta => format!(" exp(-{} s)", text::number(theta)),
    };
    format!("{}{delay} / {}", polynomial(&num), polynomial(&den))
}

fn paragraph(text: &str) -> String {
    text::wrapped(text, 96).into_iter().map(|line| line + "\n").collect()
}

/// Six digits.
fn digits(value: f64) -> String {
    if value == 0.0 || !(1e-4..1e7).contains(&value.abs()) {
        return text::number(value);
    }
    let decimals = (5.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

fn yes_no(value: bool) -> String {
    if value { "yes" } else { "no" }.to_owned()
}

/// The size of the largest multiplier beside that of a family, which is 1.
fn left_after_a_period(cycle: &Cycle) -> String {
    let mut multipliers = cycle.multipliers.iter().map(|m| m.norm());
    let is_family = |m: &f64| cycle.stable && (m - 1.0).abs() < 1e-7;
    multipliers.find(|m| !is_family(m)).map_or("-".to_owned(), |m| format!("{m:.4}"))
}

/// Quantity, unit, value.
type Line = (&'static str, &'static str, fn(&Cycle) -> f64);

const LINES: [Line; 4] = [
    ("period", " s", |c| c.period_s),
    ("half peak-to-peak OP", " %", |c| c.half_pp.op),
    ("half peak-to-peak VP", " %", |c| c.half_pp.vp),
    ("half peak-to-peak PV", "", |c| c.half_pp.pv),
];

/// The cycle by each method, and the error of the describing function.
fn side_by_side(ends: &[End]) -> String {
    let found: Vec<(&End, &Cycle)> =
        ends.iter().filter_map(|end| Some((end, end.cycles.first()?))).collect();
    if found.is_empty() {
        return String::new();
    }
    let both = found.len() == 2;
    let mut rows: Vec<Vec<String>> = vec![vec![String::new()]];
    rows[0].extend(found.iter().map(|(end, _)| end.method.name().to_owned()));
    if both {
        rows[0].push("error".to_owned());
    }
    for (name, unit, of) in LINES {
        let mut row = vec![name.to_owned()];
        row.extend(found.iter().map(|(_, cycle)| digits(of(cycle)) + unit));
        if let [(_, exact), (_, approximate)] = found[..] {
            row.push(format!("{:+.1} %", 100.0 * (of(approximate) / of(exact) - 1.0)));
        }
        rows.push(row);
    }
    let mut more = |name: &str, of: &dyn Fn(&Cycle) -> String| {
        let mut row = vec![name.to_owned()];
        row.extend(found.iter().map(|(_, cycle)| of(cycle)));
        row.resize(rows[0].len(), String::new());
        rows.push(row);
    };
    more("attracts", &|cycle| yes_no(cycle.stable));
    more("slips a period", &|cycle| cycle.slips.to_string());
    more("left of a deviation after a period", &left_after_a_period);
    let mut right = vec![true; rows[0].len()];
    right[0] = false;
    text::columns(&rows, &right)
}

/// A row for every cycle.
fn every(ends: &[End]) -> String {
    let head = [
        "method",
        "period (s)",
        "OP (%)",
        "VP (%)",
        "PV",
        "attracts",
        "slips",
        "left",
        "VP about (%)",
    ];
    let mut rows = vec![head.map(str::to_owned)];
    for end in ends {
        for cycle in &end.cycles {
            rows.push([
                end.method.name().to_owned(),
                digits(cycle.period_s),
                digits(cycle.half_pp.op),
                digits(cycle.half_pp.vp),
                digits(cycle.half_pp.pv),
                yes_no(cycle.stable),
                cycle.slips.to_string(),
                left_after_a_period(cycle),
                digits(cycle.middle.vp),
            ]);
        }
    }
    if rows.len() == 1 {
        return String::new();
    }
    text::columns(&rows, &[false, true, true, true, true, true, true, true, true])
        + "Half peak-to-peak values; left: of a deviation after a period.\n"
}

/// A word of warning where the describing function sees no cycle and there is one.
fn missed(ends: &[End]) -> String {
    let of = |method| ends.iter().find(|end| end.method == method);
    match (of(Method::Exact), of(Method::DescribingFunction)) {
        (Some(exact), Some(approximate))
            if exact.word() == "cycle" && approximate.word() == "no cycle" =>
        {
            paragraph(
                "The describing function misses this cycle: it is far from a sine. The exact one is what a \
                 simulation shows.",
            )
        }
        _ => String::new(),
    }
}

fn sensitivity_text(found: &[Sensitivity]) -> String {
    if found.is_empty() {
        return "\nNo cycle, hence no sensitivities.\n".to_owned();
    }
    let head = ["percent per percent of", "value", "period", "OP", "VP", "PV"];
    let mut rows = vec![head.map(str::to_owned)];
    // Not -0.000.
    let slope = |value: f64| format!("{:+.3}", (value * 1e3).round() / 1e3 + 0.0);
    for each in found {
        let Swing { op, vp, pv } = each.half_pp;
        rows.push([
            each.parameter.name().to_owned(),
            format!("{} {}", text::number(each.value), each.parameter.unit()),
            slope(each.period),
            slope(op),
            slope(vp),
            slope(pv),
        ]);
    }
    format!("\n{}", text::columns(&rows, &[false, false, true, true, true, true]))
}

fn retuning_text(found: &Retuning, grid: &Grid, ms: f64, l: &ContinuousLoop) -> String {
    let number = |value: Option<f64>, unit: &str| {
        value.map_or("none".to_owned(), |value| text::number(value) + unit)
    };
    let mut rows = vec![["", "present", "retuned"].map(str::to_owned)];
    let mut row = |name: &str, of: &dyn Fn(&Assessment) -> String| {
        rows.push([name.to_owned(), of(&found.present), of(&found.best)]);
    };
    row("Kc", &|a| text::number(tuning_of(&a.controller).0));
    row("Ti", &|a| number(tuning_of(&a.controller).1, " s"));
    row("Ms", &|a| {
        if a.peak_sensitivity.is_finite() {
            text::number(a.peak_sensitivity)
        } else {
            "unstable".to_owned()
        }
    });
    row("period", &|a| number(a.cycle.as_ref().map(|c| c.period_s), " s"));
    row("half peak-to-peak OP", &|a| number(a.cycle.as_ref().map(|c| c.half_pp.op), " %"));
    row("half peak-to-peak PV", &|a| number(a.cycle.as_ref().map(|c| c.half_pp.pv), ""));
    row("IAE of a load step of 1 %", &|a| number(a.load_iae, " s"));
    let mut out = format!(
        "\nPI tuning with the least swing of the PV, Ms at most {}:\n{}",
        text::number(ms),
        text::columns(&rows, &[false, true, true])
    );
    let mut said = match (&found.best.cycle, found.swing_ratio()) {
        (None, Some(_)) => "Retuned, the loop does not cycle".to_owned(),
        (_, Some(ratio)) => format!("Retuned, the PV swings {} times as far", text::number(ratio)),
        (_, None) => "The loop does not cycle as it is".to_owned(),
    };
    if let Some(ratio) = found.iae_ratio() {
        said += &format!("; the IAE of a load step is {} times that of today", text::number(ratio));
    }
    said += &format!(". {} tunings were within the bound", found.robust);
    if found.unjudged > 0 {
        said += &format!("; of {} the cycle could not be determined", found.unjudged);
    }
    said.push('.');
    if tuning::at_edge(&found.best.controller, grid) {
        said += " The best lies at the end of what was searched, a fifth to five times the present Kc and Ti; \
                 beyond it there may be a better one.";
    }
    if l.controller.gains().2 != 0.0 {
        said += " The derivative action was given up.";
    }
    out += &paragraph(&said);
    out
}

fn map_text(map: &Map) -> String {
    let count = |wanted: &str| map.points.iter().filter(|point| state(point) == wanted).count();
    let mut out = paragraph(&format!(
        "Map over {} and {} ({}): {} points with a cycle, {} without, {} not known.",
        map.x.parameter.name(),
        map.y.parameter.name(),
        map.method.name(),
        count("cycle"),
        count("no cycle"),
        count("not known")
    ));
    let cycles: Vec<(f64, Swing)> = map.points.iter().filter_map(Point::cycle).collect();
    if cycles.is_empty() {
        return format!("\n{out}");
    }
    let row = |name: &str, unit: &str, of: &dyn Fn(&(f64, Swing)) -> f64| {
        let low = cycles.iter().map(of).fold(f64::INFINITY, f64::min);
        let high = cycles.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        [name.to_owned(), format!("{} to {}{unit}", digits(low), digits(high))]
    };
    let rows = [
        row("period", " s", &|c| c.0),
        row("half peak-to-peak OP", " %", &|c| c.1.op),
        row("half peak-to-peak VP", " %", &|c| c.1.vp),
        row("half peak-to-peak PV", "", &|c| c.1.pv),
    ];
    out += &text::columns(&rows, &[false, false]);
    format!("\n{out}")
}

fn swing_json(swing: Swing) -> Value {
    json!({ "op": swing.op, "vp": swing.vp, "pv": swing.pv })
}

fn cycle_json(cycle: &Cycle) -> Value {
    json!({
        "method": cycle.method.name(),
        "period_s": cycle.period_s,
        "half_pp": swing_json(cycle.half_pp),
        "middle": swing_json(cycle.middle),
        "stable": cycle.stable,
        "multipliers": cycle.multipliers.iter().map(|m| [m.re, m.im]).collect::<Vec<_>>(),
        "slips": cycle.slips,
    })
}

fn assessment_json(found: &Assessment) -> Value {
    let (kc, ti, td) = tuning_of(&found.controller);
    json!({
        "kc": kc,
        "ti": ti,
        "td": td,
        "ms": found.peak_sensitivity.is_finite().then_some(found.peak_sensitivity),
        "load_iae": found.load_iae,
        "cycle": found.cycle.as_ref().map(cycle_json),
    })
}

fn map_json(map: &Map) -> Value {
    let axis = |axis: &Axis| {
        json!({
            "parameter": axis.parameter.name(),
            "unit": axis.parameter.unit(),
            "values": axis.values,
        })
    };
    let column = |of: fn((f64, Swing)) -> f64| -> Vec<Option<f64>> {
        map.points.iter().map(|point| point.cycle().map(of)).collect()
    };
    json!({
        "x": axis(&map.x),
        "y": axis(&map.y),
        "method": map.method.name(),
        "order": "row by row, that of the first y first",
        "state": map.points.iter().map(state).collect::<Vec<_>>(),
        "period_s": column(|c| c.0),
        "half_pp": {
            "op": column(|c| c.1.op),
            "vp": column(|c| c.1.vp),
            "pv": column(|c| c.1.pv),
        },
        "boundary": map.boundary().iter().map(|side| side.map(|(x, y)| [x, y])).collect::<Vec<_>>(),
    })
}
