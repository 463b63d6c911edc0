//! `stiction diagnose`: recordings of real loops.

pub mod joined;
mod methods;
mod summary;

use crate::files::{self, In, Out};
use crate::loops::{Diagnosed, diagnose_all, find_all};
use crate::output;
use crate::overrule;
use crate::reading_args::Reading;
use anyhow::{Result, bail};
use clap::Parser;
use rayon::prelude::*;
use std::process::ExitCode;
use stiction::diagnose::{DiagnoseOptions, KpiOptions, VerdictClass};
use stiction::recording::GridOptions;
use stiction_report::document::{self, Document, Loop};
use stiction_report::report;

/// Diagnose recordings: do the data suffice, does the loop cycle, what does every published method say?
///
/// Reads SP, PV, OP (and, where they are recorded, valve position and mode) from CSV, Parquet or MATLAB
/// files; `stiction inspect` shows what is recognised in them. Of each loop the longest segment in
/// automatic is judged. Recordings of one tag with dates are one, in whatever files they are. What a
/// person concluded, kept by `stiction override`, is shown beside the computed verdict.
///
/// Exit codes: 0, all files were diagnosed; 1, they were, and a loop is of a class that --fail-on names;
/// 2, some could not be, and the messages say why.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction diagnose samples/FIC101-sticky.csv --report report.html
  stiction diagnose plant/*.csv --report plant-report --csv ranking.csv
  stiction diagnose FIC101-monday.csv FIC101-tuesday.csv --join
  stiction diagnose export.csv --loop FIC101 --type flow --json
  stiction diagnose plant/*.csv --brief
  stiction diagnose plant/*.csv --fail-on sticks,does-not-respond")]
pub struct Args {
    /// CSV, Parquet or MATLAB files; - is standard input
    #[arg(required_unless_present_any = ["schema", "methods"], value_name = "FILE")]
    files: Vec<In>,
    /// Diagnose this loop only; may be given several times
    #[arg(long = "loop", value_name = "TAG")]
    loops: Vec<String>,
    /// Take all files as recordings of one loop, one after the other; a gap between them stays a gap
    #[arg(long)]
    join: bool,
    /// Bring the recording onto a grid of this step, in s, in place of its own commonest one
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    grid: Option<f64>,
    /// Dead time of the loop, in s, for the Harris index
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    dead_time: Option<f64>,
    /// Write a report to this file, one self-contained HTML page; or, if it does not end in .html, to this
    /// folder: a page for each loop, and index.html, a table of all that can be sorted and searched
    #[arg(long, value_name = "OUT.html|FOLDER")]
    report: Option<Out>,
    /// Print the results as JSON
    #[arg(long, conflicts_with = "schema")]
    json: bool,
    /// Write a table with one row a loop to this CSV file; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with_all = ["json", "schema"])]
    csv: Option<Out>,
    /// End with exit code 1 if a loop is of this class: sticks, does-not-stick, does-not-respond or
    /// cannot-tell; several with commas or given several times. An override goes before the verdict
    #[arg(long, value_name = "CLASS", value_delimiter = ',', value_parser = VerdictClass::by_name)]
    fail_on: Vec<VerdictClass>,
    /// Print a line a loop, and nothing else
    #[arg(long, conflicts_with_all = ["json", "schema", "csv"])]
    brief: bool,
    /// Print the JSON schema of what --json prints
    #[arg(long)]
    schema: bool,
    /// List the methods with their rules, parameters and sources, in Markdown
    #[arg(long, conflicts_with_all = ["json", "schema", "csv"])]
    methods: bool,
    // Last, because its heading stands above all that follows.
    #[command(flatten)]
    reading: Reading,
}

pub fn run(args: Args) -> Result<ExitCode> {
    if args.schema {
        return output::line(document::schema()).map(|()| ExitCode::SUCCESS);
    }
    if args.methods {
        return output::text(&methods::table()).map(|()| ExitCode::SUCCESS);
    }
    let options = DiagnoseOptions {
        loop_type: None,
        grid: GridOptions { sample_time: args.grid },
        kpis: KpiOptions { dead_time: args.dead_time },
        evidence: args.report.is_some(),
        ..DiagnoseOptions::default()
    };
    let (found, mut failures) = find_all(&args.files, &args.loops, &args.reading)?;
    let recordings = if args.join { joined::all(found)? } else { joined::by_tag(found) };
    let (mut loops, refused) = diagnose_all(&recordings, &options);
    failures.extend(refused);
    overrule::apply(&mut loops)?;
    let found: Vec<Loop<'_>> = loops.iter().map(Diagnosed::found).collect();

    if let Some(path) = &args.report {
        reported(path, &found)?;
    }
    let done = || -> Result<()> {
        if let Some(path) = &args.csv {
            output::write(Some(path), summary::csv(&found)?.as_bytes())?;
        }
        if args.json {
            return output::json_text(&Document::new(tool(), found.clone()).json());
        }
        if args.csv.is_none() {
            match &loops[..] {
                [] => {}
                several if args.brief => output::text(&summary::brief(several))?,
                [one] => output::text(&summary::one(one))?,
                several => output::text(&summary::several(several))?,
            }
        }
        if let Some(path) = &args.report
            && !path.is_standard()
            && !args.csv.as_ref().is_some_and(Out::is_standard)
        {
            let page = match is_folder(path) {
                true => path.join(report::folder::INDEX),
                false => path.to_path_buf(),
            };
            output::note(format!("the report is in {}", page.display()));
        }
        Ok(())
    };
    if !loops.is_empty() {
        done()?;
    }
    ended(failures)?;
    Ok(if fails(&loops, &args.fail_on) { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

/// Whether a report goes to a folder: no page, nor standard output.
fn is_folder(path: &Out) -> bool {
    let page =
        |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm");
    !path.is_standard() && !path.extension().is_some_and(page)
}

/// Writes the report: a page, or a folder of pages.
fn reported(path: &Out, found: &[Loop<'_>]) -> Result<()> {
    if !is_folder(path) {
        return output::write(Some(path), report::html(&tool(), found)?.as_bytes());
    }
    let folder = report::Folder::new(tool(), found);
    if path.is_file() {
        bail!(
            "--report {} is a file; name a page, which ends in .html, or a folder",
            path.display()
        );
    }
    files::make_folder(&path.join("loops"))?;
    (0..folder.len()).into_par_iter().try_for_each(|place| {
        output::write(Some(&path.inside(folder.path(place))?), folder.page(place)?.as_bytes())
    })?;
    output::write(Some(&path.inside(report::folder::INDEX)?), folder.index().as_bytes())
}

/// The last of some failures, after a message for each of the others.
pub fn ended(mut failures: Vec<anyhow::Error>) -> Result<()> {
    let Some(last) = failures.pop() else { return Ok(()) };
    for failure in failures {
        output::complain(&failure);
    }
    Err(last)
}

/// Whether a loop is of one of the `classes`; where an override decides on that, the user is told.
fn fails(loops: &[Diagnosed], classes: &[VerdictClass]) -> bool {
    for each in loops {
        let computed = each.diagnosis.verdict.class;
        if classes.contains(&computed) != classes.contains(&each.class()) {
            output::note(format!(
                "--fail-on counts {} as \"{}\", by override; computed is \"{}\"",
                each.diagnosis.name,
                each.class().name(),
                computed.name()
            ));
        }
    }
    loops.iter().any(|each| classes.contains(&each.class()))
}

/// The program with its version.
pub fn tool() -> String {
    concat!("stiction ", env!("CARGO_PKG_VERSION")).to_owned()
}
