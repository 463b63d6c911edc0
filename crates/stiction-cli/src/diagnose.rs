//! `stiction diagnose`: recordings of real loops.

pub mod joined;
mod methods;
mod summary;

use crate::files::{self, In, Out};
use crate::loops::{Diagnosed, diagnose_all, diagnose_file, find_all};
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
use stiction_report::report::{self, Fitted};

/// Diagnose recorded loops: check the data, look for a limit cycle, and judge whether the valve sticks.
///
/// Reads SP, PV, OP and, where recorded, valve position and mode from CSV, Parquet, Excel or MATLAB files. `stiction
/// inspect` shows how the files are interpreted. All segments in automatic of each loop are judged together. The
/// probability covers only sticking that the recording can show. An S below the detection limit may go undetected. Dated
/// recordings of one tag are joined across files. A person's verdict, entered with `stiction override`, is shown beside
/// the computed verdict.
///
/// Exit code 0: all files were diagnosed. Exit code 1: all files were diagnosed, and a loop is of a class that
/// --fail-on names. Exit code 2: some files could not be diagnosed, and the messages say why.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction diagnose samples/FIC101-sticky.csv --report report.html
  stiction diagnose plant/*.csv --report plant-report --csv ranking.csv
  stiction diagnose FIC101-monday.csv FIC101-tuesday.csv --join
  stiction diagnose export.csv --loop FIC101 --type flow --json
  stiction diagnose plant/*.csv --brief
  stiction diagnose plant/*.csv --fail-on sticks,does-not-respond")]
pub struct Args {
    /// CSV, Parquet, Excel or MATLAB files, or folders of them; - is standard input
    #[arg(required_unless_present_any = ["schema", "methods"], value_name = "FILE")]
    files: Vec<In>,
    /// Diagnose only this loop; may be given several times
    #[arg(long = "loop", value_name = "TAG")]
    loops: Vec<String>,
    /// Treat all files as recordings of one loop, one after the other; gaps between them remain gaps
    #[arg(long)]
    join: bool,
    /// Resample the recording to this step, in s, instead of its most frequent step
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    grid: Option<f64>,
    /// Dead time of the loop, in s, for the Harris index
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true)]
    dead_time: Option<f64>,
    /// Write the report to this .html file, one self-contained page. Any other name is a folder, for a page per loop
    /// and index.html with a table to sort and search
    #[arg(long, value_name = "OUT.html|FOLDER")]
    report: Option<Out>,
    /// Open the report in the browser
    #[arg(long, requires = "report")]
    open: bool,
    /// Print the results as JSON
    #[arg(long, conflicts_with = "schema")]
    json: bool,
    /// Write a table with one row per loop to this CSV file; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with_all = ["json", "schema"])]
    csv: Option<Out>,
    /// End with exit code 1 if a loop is of this class: sticks, does-not-stick, does-not-respond or cannot-tell;
    /// separate several classes with commas or give the option several times. Overrides take precedence over the verdict
    #[arg(long, value_name = "CLASS", value_delimiter = ',', value_parser = VerdictClass::by_name)]
    fail_on: Vec<VerdictClass>,
    /// Print only one line per loop
    #[arg(long, conflicts_with_all = ["json", "schema", "csv"])]
    brief: bool,
    /// Print the JSON schema of what --json prints
    #[arg(long)]
    schema: bool,
    /// List the methods with rules, parameters and sources, in Markdown
    #[arg(long, conflicts_with_all = ["json", "schema", "csv"])]
    methods: bool,
    // Must be last, because its heading applies to all that follows.
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
        // A table of CSV has none.
        plan: args.csv.is_none() || args.json || args.report.is_some(),
        ..DiagnoseOptions::default()
    };
    let files = files::with_folders(&args.files)?;
    let (mut loops, failures) = match &files[..] {
        // Recordings of one file are never joined.
        [file] if !args.join => diagnose_file(file, &args.loops, &args.reading, &options)?,
        files => {
            let (found, mut failures) = find_all(files, &args.loops, &args.reading)?;
            failures.retain(|error| found.is_empty() || !files::is_skipped(error, &args.files));
            let recordings = if args.join { joined::all(found)? } else { joined::by_tag(found) };
            let (loops, refused) = diagnose_all(&recordings, &options);
            failures.extend(refused);
            (loops, failures)
        }
    };
    overrule::apply(&mut loops)?;
    let found: Vec<Loop<'_>> = loops.iter().map(Diagnosed::found).collect();

    if let Some(path) = &args.report {
        reported(path, &found)?;
    }
    let done = || -> Result<()> {
        output::given(&args.csv, || summary::csv(&found))?;
        if args.json {
            return output::json_text(&Document::new(output::TOOL, found.clone()).json());
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
            if args.open && open::that(&page).is_err() {
                output::note("no browser could be opened; open the report yourself");
            }
        }
        Ok(())
    };
    if !loops.is_empty() {
        done()?;
    }
    ended(failures)?;
    Ok(if fails(&loops, &args.fail_on) { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

/// Whether a report goes to a folder, and not to a page or standard output.
fn is_folder(path: &Out) -> bool {
    let page =
        |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm");
    !path.is_standard() && !path.extension().is_some_and(page)
}

/// Writes the report: a page, or a folder of pages.
fn reported(path: &Out, loops: &[Loop<'_>]) -> Result<()> {
    let fits: Vec<_> = loops.par_iter().map(|each| Fitted::of_accused(each.diagnosis)).collect();
    let found: Vec<Loop<'_>> =
        loops.iter().zip(&fits).map(|(each, fit)| each.with_fit(fit)).collect();
    if !is_folder(path) {
        return output::write(Some(path), report::html(output::TOOL, &found)?.as_bytes());
    }
    let folder = report::Folder::new(output::TOOL, &found);
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

/// Returns the last of some failures, after printing a message for each earlier one.
pub fn ended(mut failures: Vec<anyhow::Error>) -> Result<()> {
    let Some(last) = failures.pop() else { return Ok(()) };
    for failure in failures {
        output::complain(&failure);
    }
    Err(last)
}

/// Whether the class of a loop is among the `classes`. The user is notified if an override decides.
fn fails(loops: &[Diagnosed], classes: &[VerdictClass]) -> bool {
    for each in loops {
        let computed = each.diagnosis.verdict.class;
        if classes.contains(&computed) != classes.contains(&each.class()) {
            output::note(format!(
                "--fail-on counts {} as \"{}\" because of an override; the computed verdict is \"{}\"",
                each.diagnosis.name,
                each.class().name(),
                computed.name()
            ));
        }
    }
    loops.iter().any(|each| classes.contains(&each.class()))
}
