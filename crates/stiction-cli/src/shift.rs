//! `stiction shift`: the difference between recordings and the simulated loops of the verdict's training.

use crate::files::{In, Out};
use crate::output::Sheet;
use crate::reading_args::Reading;
use crate::{input, output, progress, text};
use anyhow::{Result, bail};
use clap::Parser;
use rayon::prelude::*;
use stiction::evidence::Evidence;
use stiction::fusion;
use stiction::fusion::shift::{Shift, shifts};
use stiction::recording::{Grid, GridOptions, Recording};
use stiction::spoken;

/// Compare recordings, without labels, with the simulated loops on which the verdict was trained.
///
/// For every feature of the evidence, the table shows the rank of the recorded values among the simulated values. A rank
/// of 0.5 means no difference. At ranks near 0 or 1 the recordings are unlike all simulated loops, and verdicts on them
/// are less reliable than stated. The largest differences come first.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction shift plant/*.csv
  stiction shift export.parquet --csv shift.csv")]
pub struct Args {
    /// CSV, Parquet, Excel or MATLAB files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<In>,
    /// Show only this many features
    #[arg(long, value_name = "K")]
    top: Option<usize>,
    /// Write all features to this CSV file; - is standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<Out>,
    // Must be last, because its heading applies to all that follows.
    #[command(flatten)]
    reading: Reading,
}

pub fn run(args: Args) -> Result<()> {
    let options = args.reading.options_of(&args.files)?;
    let mut recordings = vec![];
    let progress = progress::bar("reading", args.files.len());
    for (file, options) in args.files.iter().zip(options) {
        recordings.extend(input::recordings(file, &options?)?.recordings);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let recorded: Vec<Evidence> = recordings.par_iter().filter_map(evidence).collect();
    if recorded.is_empty() {
        bail!("none of the {} recordings has a segment in automatic to measure", recordings.len());
    }
    let bundle = fusion::shipped()?;
    let Some(simulated) = &bundle.full.reference else {
        bail!("the model of the verdict has no data on the training loops; train the model again");
    };
    let found = shifts(simulated, &recorded);
    if output::given(&args.csv, || csv(&found))? {
        return Ok(());
    }
    let distance = |each: &&Evidence| simulated.distance(&fusion::row(&each.values)) > 1.0;
    let unlike = recorded.iter().filter(distance).count();
    let far = found.iter().filter(|shift| shift.distance() > 0.5).count();
    let rows = std::iter::once(["feature", "place", "simulated", "recorded"].map(str::to_owned))
        .chain(found.iter().take(args.top.unwrap_or(usize::MAX)).map(|shift| {
            let range = |[low, middle, high]: [f64; 3]| match middle.is_finite() {
                true => format!("{middle:.2} ({low:.2} to {high:.2})"),
                false => "-".to_owned(),
            };
            let place = shift.place.map_or("-".to_owned(), |place| format!("{place:.2}"));
            [shift.feature.name.to_owned(), place, range(shift.simulated), range(shift.recorded)]
        }));
    let rows: Vec<Vec<String>> = rows.map(|row| row.to_vec()).collect();
    output::text(&format!(
        "{} recordings against the {} simulated loops of the training (population {}, seed {}). {far} of {} features \
         differ by more than 0.5. {unlike} recordings are unlike all training loops.\n\
         Cells give the median and, in brackets, the range of the middle 90 %.\n\n{}",
        recorded.len(),
        bundle.provenance.trained,
        bundle.provenance.population,
        bundle.provenance.seed,
        found.len(),
        text::columns(&rows, &[false, true, false, false])
    ))
}

/// The evidence in the longest segment of a recording.
fn evidence(recording: &Recording) -> Option<Evidence> {
    let grid = Grid::of(recording, &GridOptions::default()).ok()?;
    Evidence::of(grid.longest()?).ok()
}

fn csv(found: &[Shift]) -> Result<String> {
    let columns = "feature,meaning,place,simulated_5,simulated_50,simulated_95,simulated_missing,\
        recorded_5,recorded_50,recorded_95,recorded_missing";
    let mut sheet = Sheet::new(columns.split(','))?;
    for shift in found {
        let number =
            |value: f64| if value.is_finite() { spoken::cell(value) } else { String::new() };
        let mut row = vec![
            shift.feature.name.to_owned(),
            shift.feature.meaning.to_owned(),
            shift.place.map_or(String::new(), number),
        ];
        let sides = [(shift.simulated, shift.missing[0]), (shift.recorded, shift.missing[1])];
        for (quantiles, missing) in sides {
            row.extend(quantiles.map(number));
            row.push(number(missing));
        }
        sheet.row(&row)?;
    }
    Ok(sheet.text()?)
}
