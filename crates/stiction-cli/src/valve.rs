//! `stiction valve`: applies a valve model to a column of a table.

use crate::files::{In, Out};
use crate::{input, output};
use anyhow::{Context, Result};
use clap::Parser;
use stiction::Bands;
use stiction::valve::{Model, Start, Valve, ValveSpec};

/// Drive a valve model with a signal from a CSV file.
///
/// Writes the same rows with an added column vp, the valve position. S, J and both signals are in percent of span.
#[derive(Parser)]
#[command(
    after_help = "Example:\n  stiction valve --model two-phase --S 5 --J 2 in.csv -o out.csv"
)]
pub struct Args {
    /// List the models with descriptions and sources
    #[arg(long)]
    list: bool,
    /// Name of the model
    #[arg(long, default_value = "two-phase", value_name = "NAME")]
    model: String,
    /// Stick band plus dead band, percent of span
    #[arg(long = "S", value_name = "PERCENT", allow_negative_numbers = true)]
    s: Option<f64>,
    /// Slip jump, percent of span
    #[arg(long = "J", value_name = "PERCENT", allow_negative_numbers = true)]
    j: Option<f64>,
    /// Overshoot of a slip, for he-wang: 1 (none) to 2 (no damping)
    #[arg(long = "K", value_name = "FACTOR", allow_negative_numbers = true)]
    k: Option<f64>,
    /// Position and input before the first sample [default: first value of the column]
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    start: Option<f64>,
    /// Column with the valve's input
    #[arg(long, default_value = "u", value_name = "NAME")]
    column: String,
    /// CSV file with a header row; - is standard input
    #[arg(required_unless_present = "list")]
    input: Option<In>,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<Out>,
}

pub fn run(args: Args) -> Result<()> {
    if args.list {
        for model in Model::ALL {
            let model = model.describe();
            output::line(format!(
                "{:10} {}\n{:10} {}",
                model.name, model.summary, "", model.citation
            ))?;
        }
        return Ok(());
    }
    let model = Model::by_name(&args.model)?;
    let bands = bands(model, args.s, args.j)?;
    let spec = ValveSpec { overshoot: args.k, ..ValveSpec::new(model, bands) };
    let mut valve = spec.build(None).map_err(worded)?;

    let table = input::table(&args.input.context("no input file")?)?;
    let op = table.column(&args.column)?;
    let start = args.start.unwrap_or(op[0]);
    anyhow::ensure!(start.is_finite(), "--start is {start}, but must be a finite number");
    valve.restart(Start::at_rest(start));
    let mut vp = vec![0.0; op.len()];
    valve.run(&op, &mut vp)?;
    output::write(args.output.as_ref(), table.with_column("vp", &vp)?.as_bytes())
}

/// The bands of a model from the given S and J, which must match the parameters of the model.
pub fn bands(model: Model, s: Option<f64>, j: Option<f64>) -> Result<Bands> {
    for name in model.unused(s, j) {
        output::note(format!("model {} does not use --{name}", model.describe().name));
    }
    model.bands(s, j).map_err(worded)
}

/// The library's refusal of a valve, with the options of this command.
fn worded(refused: stiction::Error) -> anyhow::Error {
    match refused {
        stiction::Error::Missing { name, needed_by } => {
            anyhow::anyhow!("model {needed_by} needs --{name}, in percent of span")
        }
        error @ stiction::Error::NotOfModel { .. } => anyhow::anyhow!("--{error}"),
        error => error.into(),
    }
}
