//! `stiction fmu`: models for Simulink, OpenModelica, Dymola and other tools that import FMUs.

use crate::files::{In, Out};
use crate::{actions, output, progress};
use anyhow::{Context, Result, bail};
use clap::{Parser, ValueEnum};
use jiff::Timestamp;
use schemars::JsonSchema;
use serde::Serialize;
use stiction_fmu::{Fmi, Fmu, ModelEntry, Variable, models};
use stiction_fmu_export::{Library, PLATFORMS, Platform, of_scenario, write};

/// Export a sticking valve, a physical stem or a whole loop as a functional mock-up unit (FMU).
///
/// Simulink, OpenModelica, Dymola, FMPy and others import the FMU without a compiler. --variables lists the variables.
/// docs/fmu.md shows the import step by step and explains the communication step. The page documentation/index.html
/// inside the FMU shows a picture, the equations and an example. Valves and loops are for co-simulation, stems also for
/// model exchange. The same model and --date give the same bytes.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction fmu --model two-phase --S 5 --J 3 -o valve.fmu
  stiction fmu --stem lugre --set supply=150e3 -o stem.fmu
  stiction fmu paper/closed-loop -o loop.fmu --fmi 3
  stiction fmu --list")]
pub struct Args {
    /// List the models, and the platforms whose libraries an FMU contains
    #[arg(long)]
    list: bool,
    /// Closed loop: the name of a built-in scenario, or a TOML file
    #[arg(conflicts_with_all = ["model", "stem"])]
    scenario: Option<String>,
    /// Data-driven valve: the name of its model
    #[arg(long, value_name = "NAME", conflicts_with = "stem")]
    model: Option<String>,
    /// Physical stem: the name of its friction law or parameter set
    #[arg(long, value_name = "NAME")]
    stem: Option<String>,
    /// Stick band plus dead band, percent of span
    #[arg(long = "S", value_name = "PERCENT", allow_negative_numbers = true, conflicts_with_all = ["stem", "scenario"])]
    s: Option<f64>,
    /// Slip jump, percent of span
    #[arg(long = "J", value_name = "PERCENT", allow_negative_numbers = true, conflicts_with_all = ["stem", "scenario"])]
    j: Option<f64>,
    /// Start value of a variable, such as stem_lag=0.5, or a key of the scenario; may be given several times
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// FMI version
    #[arg(long, value_enum, default_value = "2")]
    fmi: Version,
    /// Time of generation in the model description [default: the time in SOURCE_DATE_EPOCH, in seconds, or now]
    #[arg(long, value_name = "2026-03-01T00:00:00Z")]
    date: Option<Timestamp>,
    /// Print the variables and their start values instead of writing an FMU
    #[arg(long)]
    variables: bool,
    /// With --list or --variables, print JSON
    #[arg(long)]
    json: bool,
    /// Add or replace the library of a platform, such as x86_64-windows=stiction_fmu.dll; may be given several times
    #[arg(long, value_name = "ARCH-OS=FILE")]
    library: Vec<String>,
    /// Write the FMU to this file
    #[arg(short, long, value_name = "FILE", required_unless_present_any = ["list", "variables"])]
    output: Option<Out>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Version {
    /// FMI 2.0
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
}

/// What `stiction fmu --list --json` prints.
#[derive(Serialize, JsonSchema)]
pub struct List {
    /// The models that can be exported.
    models: Vec<ModelEntry>,
    /// The platforms whose libraries an FMU contains.
    platforms: Vec<String>,
}

/// What `stiction fmu --variables --json` prints.
pub type Variables = Vec<Variable>;

pub fn run(args: Args) -> Result<()> {
    if args.list {
        return list(args.json);
    }
    let fmu = chosen(&args)?;
    if args.variables && args.json {
        return output::json(&fmu.variables());
    }
    if args.variables {
        return variables(&fmu);
    }
    if args.json {
        bail!("--json needs --list or --variables, because an exported FMU is a file");
    }
    let fmi = match args.fmi {
        Version::Two => Fmi::V2,
        Version::Three => Fmi::V3,
    };
    let further = args.library.iter().map(|given| library(given)).collect::<Result<_>>()?;
    let libraries = libraries(further)?;
    let path = args.output.context("no output")?;
    let bytes = write(&fmu, fmi, &libraries, Some(generated_s(args.date)?))?;
    output::write(Some(&path), &bytes)
}

/// The given libraries and the libraries of our own platforms, which a development build compiles first.
fn libraries(given: Vec<Library>) -> Result<Vec<Library>> {
    let wait = PLATFORMS.iter().any(Platform::is_compiled_at_export);
    let spinner = wait.then(|| {
        progress::spinner(
            "Compiling the library of FMUs. The first time this takes about a minute.",
        )
    });
    let libraries = Library::own_and(given);
    if let Some(spinner) = spinner {
        spinner.finish_and_clear();
    }
    Ok(libraries?)
}

/// The time of generation, in seconds since the beginning of 1970 in UTC.
fn generated_s(date: Option<Timestamp>) -> Result<u64> {
    if let Some(date) = date {
        return u64::try_from(date.as_second()).context("--date: must be after 1970");
    }
    match std::env::var("SOURCE_DATE_EPOCH") {
        Ok(epoch) => epoch.parse().with_context(|| {
            format!("SOURCE_DATE_EPOCH is {epoch}, but must be a whole number of seconds")
        }),
        Err(_) => Ok(std::time::SystemTime::UNIX_EPOCH.elapsed()?.as_secs()),
    }
}

/// Prints the models and the platforms of an FMU.
fn list(as_json: bool) -> Result<()> {
    let platforms: Vec<_> =
        PLATFORMS.iter().map(|own| format!("{}-{}", own.arch, own.os)).collect();
    if as_json {
        return output::json(&List { models: models(), platforms });
    }
    for entry in models() {
        output::line(format!("{:6} {:22} {}", entry.model, entry.law, entry.summary))?;
    }
    output::line(format!("\nAn FMU runs on {}.", platforms.join(", ")))
}

/// The requested model with its start values.
fn chosen(args: &Args) -> Result<Fmu> {
    let refuse = anyhow::Error::msg;
    if let Some(name) = &args.scenario {
        return Ok(of_scenario(&actions::scenario(name, &args.set)?)?);
    }
    let mut fmu = match (&args.model, &args.stem) {
        (_, Some(stem)) => Fmu::new("stem", stem).map_err(refuse)?,
        (model, None) => {
            Fmu::new("valve", model.as_deref().unwrap_or("two-phase")).map_err(refuse)?
        }
    };
    for (name, value) in [("S", args.s), ("J", args.j)] {
        if let Some(value) = value {
            fmu = fmu.with(name, value).map_err(refuse)?;
        }
    }
    for setting in &args.set {
        let Some((name, value)) = setting.split_once('=') else {
            bail!("--set {setting}: must be NAME=VALUE, such as stem_lag=0.5");
        };
        let value = match value.trim() {
            "true" => 1.0,
            "false" => 0.0,
            number => number.parse().with_context(|| {
                format!("--set {setting}: {number} is not a number, true or false")
            })?,
        };
        fmu = fmu
            .with(name.trim(), value)
            .map_err(|why| anyhow::anyhow!("--set {setting}: {why}"))?;
    }
    fmu.check().map_err(refuse)?;
    Ok(fmu)
}

fn library(given: &str) -> Result<Library> {
    let parts = given.split_once('=').and_then(|(name, file)| Some((name.split_once('-')?, file)));
    let Some(((arch, os), file)) = parts else {
        bail!("--library {given}: must be ARCH-OS=FILE, such as x86_64-windows=stiction_fmu.dll");
    };
    let file = In::also(file)?;
    let bytes = stiction_io::bytes::read(&file).with_context(|| format!("--library {given}"))?;
    Ok(Library { arch: arch.to_owned(), os: os.to_owned(), bytes: bytes.into(), given: true })
}

fn variables(fmu: &Fmu) -> Result<()> {
    for variable in fmu.variables() {
        output::line(
            format!(
                "{:16} {:9} {:>10} {:6} {}",
                variable.name,
                variable.role(),
                variable.start_text(),
                variable.unit,
                variable.description
            )
            .trim_end(),
        )?;
    }
    Ok(())
}
