//! `stiction stem`: moves the physical valve with a signal.

use crate::files::{In, Out};
use crate::{input, output};
use anyhow::{Context, Result, bail};
use clap::{Parser, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use stiction::closed_loop::{Signal, Wave};
use stiction::stem::friction::LAWS;
use stiction::stem::{
    Equivalent, FrictionLaw, ParameterSet, PressureSignal, Response, SETS, Stem, StemParameters,
    StemStart,
};
use stiction_io::table;

/// Simulate a physical valve with mass, spring, air pressure and friction.
///
/// The signal is the controller output in percent, interpolated linearly, and sets the air pressure. Writes CSV with
/// the columns t, op, pressure_pa, vp (percent of stroke), position_m, velocity_m_per_s and friction_n.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction stem --parameters cts-stribeck --period 200 --duration 400 -o stem.csv --events slips.csv
  stiction stem --parameters usp --friction lugre --set coulomb_n=650 -o lugre.csv
  stiction stem --parameters cts --input op.csv --column u -o out.csv")]
pub struct Args {
    /// List the parameter sets and the friction laws
    #[arg(long)]
    list: bool,
    /// Name of a parameter set
    #[arg(long, default_value = "cts", value_name = "NAME")]
    parameters: String,
    /// Friction law [default: the law of the set]
    #[arg(long, value_name = "LAW")]
    friction: Option<String>,
    /// Change a parameter of stem or friction, such as coulomb_n=900; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    changes: Vec<String>,
    /// Read the signal from this CSV file, which needs a column t, instead of generating it
    #[arg(long, value_name = "FILE")]
    input: Option<In>,
    /// Column of --input with the controller output
    #[arg(long, default_value = "u", value_name = "NAME", requires = "input")]
    column: String,
    /// Shape of the signal
    #[arg(long, value_enum, default_value = "ramp", conflicts_with = "input")]
    signal: Shape,
    /// Mean of the signal, percent
    #[arg(long, default_value_t = 50.0, value_name = "PERCENT", allow_negative_numbers = true)]
    mean: f64,
    /// Half the peak-to-peak value of the signal, percent
    #[arg(long, default_value_t = 50.0, value_name = "PERCENT", allow_negative_numbers = true)]
    amplitude: f64,
    /// Period of the signal, s; the signal begins at its lowest point
    #[arg(long, default_value_t = 200.0, value_name = "S", allow_negative_numbers = true)]
    period: f64,
    /// Duration of the signal, s [default: two periods]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Time between samples, s
    #[arg(long, default_value_t = 0.1, value_name = "S", allow_negative_numbers = true)]
    sample_time: f64,
    /// Initial position, percent of stroke [default: balance of spring and pressure]
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    start: Option<f64>,
    /// File to write [default: standard output, unless --json]
    #[arg(short, long, value_name = "FILE")]
    output: Option<Out>,
    /// Write slips and stops, with their exact times, to this CSV file
    #[arg(long, value_name = "FILE")]
    events: Option<Out>,
    /// Print the equivalent S, J and overshoot, and the number of slips, as JSON
    #[arg(long)]
    json: bool,
}

/// What `stiction stem --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// Name and version of the program.
    tool: &'static str,
    /// The initial set of parameters.
    set: String,
    /// The stem.
    stem: StemParameters,
    /// Friction.
    friction: FrictionLaw,
    /// The stem in the terms of the data-driven models.
    equivalent: Equivalent,
    /// Number of slips.
    slips: usize,
    /// Number of stops.
    stops: usize,
}

#[derive(Clone, Copy, ValueEnum)]
enum Shape {
    /// Straight up and straight down
    Ramp,
    Sine,
}

pub fn run(args: Args) -> Result<()> {
    if args.list {
        return list();
    }
    let stem = build(&args)?;
    let (times, op) = signal(&args)?;
    let parameters = stem.parameters();
    let points = times.iter().zip(&op).map(|(t, op)| (*t, parameters.pressure_pa(*op)));
    let pressure = PressureSignal::from_points(points.collect())?;
    let start = match args.start {
        Some(percent) => parameters.position_m(percent),
        None => parameters.balance_m(pressure.first_pa()),
    };
    let response = stem.simulate(&pressure, StemStart::at_rest(start), &times)?;

    if let Some(path) = &args.events {
        write_events(path, parameters, &response)?;
    }
    if args.output.is_some() || !args.json {
        let column = |get: fn(&stiction::stem::Sample) -> f64| -> Vec<f64> {
            response.samples.iter().map(get).collect()
        };
        let position = column(|s| s.position_m);
        let vp: Vec<f64> = position.iter().map(|x| parameters.percent(*x)).collect();
        let csv = table::write(&[
            ("t", Some(&times)),
            ("op", Some(&op)),
            ("pressure_pa", Some(&column(|s| s.pressure_pa))),
            ("vp", Some(&vp)),
            ("position_m", Some(&position)),
            ("velocity_m_per_s", Some(&column(|s| s.velocity_m_per_s))),
            ("friction_n", Some(&column(|s| s.friction_n))),
        ]);
        output::write(args.output.as_ref(), csv.as_bytes())?;
    }
    if args.json {
        output::json(&Document {
            tool: output::TOOL,
            set: args.parameters,
            stem: *parameters,
            friction: *stem.friction(),
            equivalent: stem.equivalent()?,
            slips: response.slips().count(),
            stops: response.stops().count(),
        })?;
    }
    Ok(())
}

fn list() -> Result<()> {
    output::line("parameter sets")?;
    for name in SETS {
        let set = ParameterSet::named(name)?;
        output::line(format!("  {name:21} {}\n  {:21} {}", set.summary, "", set.source))?;
    }
    output::line("friction laws")?;
    for law in LAWS {
        output::line(format!("  {:21} {}\n  {:21} {}", law.name, law.summary, "", law.source))?;
        output::line(format!("  {:21} parameters: {}", "", law.parameters.join(", ")))?;
    }
    Ok(())
}

/// The named set with the requested friction law and changes.
fn build(args: &Args) -> Result<Stem> {
    let set = ParameterSet::named(&args.parameters)?;
    let changes = args.changes.iter().map(|c| parse(c)).collect::<Result<Vec<_>>>()?;
    set.stem_with(args.friction.as_deref(), &changes).map_err(|error| match error {
        stiction::Error::Missing { name, needed_by } => anyhow::anyhow!(
            "friction law {needed_by} needs {name}, which set {} lacks; give each as --set NAME=VALUE",
            set.name
        ),
        error => error.into(),
    })
}

/// `NAME=VALUE`.
fn parse(change: &str) -> Result<(String, f64)> {
    let form = || format!("--set {change}: write NAME=VALUE, such as coulomb_n=900");
    let (name, value) = change.split_once('=').with_context(form)?;
    Ok((name.trim().to_owned(), value.trim().parse().with_context(form)?))
}

/// Times and controller output.
fn signal(args: &Args) -> Result<(Vec<f64>, Vec<f64>)> {
    if let Some(path) = &args.input {
        let table = input::table(path)?;
        return Ok((table.column("t")?, table.column(&args.column)?));
    }
    let duration = args.duration.unwrap_or(2.0 * args.period);
    let samples = (duration / args.sample_time).round() + 1.0;
    if !(2.0..=1e8).contains(&samples) {
        bail!(
            "--duration {duration} at --sample-time {} makes {samples} samples, but between 2 and 100 million are \
             allowed",
            args.sample_time
        );
    }
    let wave = match args.signal {
        Shape::Ramp => Wave::Ramp,
        Shape::Sine => Wave::Sine,
    };
    let signal = Signal::Periodic {
        wave,
        mean: args.mean,
        amplitude: args.amplitude,
        period_s: args.period,
        phase: -0.25,
    };
    let op = signal.sample(args.sample_time, samples as usize)?;
    Ok(((0..op.len()).map(|k| k as f64 * args.sample_time).collect(), op))
}

fn write_events(path: &Out, parameters: &StemParameters, response: &Response) -> Result<()> {
    let mut text = "t,event,direction,vp,position_m\n".to_owned();
    for event in &response.events {
        let kind = event.kind.name();
        let percent = parameters.percent(event.position_m);
        let direction = event.direction.sign();
        text += &format!("{},{kind},{direction},{percent},{}\n", event.time_s, event.position_m);
    }
    output::write(Some(path), text.as_bytes())
}
