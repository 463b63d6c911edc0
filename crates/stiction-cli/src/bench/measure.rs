//! Diagnoses many loops one by one, and keeps only the counted parts.

use crate::files::Out;
use crate::{output, progress};
use anyhow::{Context, Result};
use rayon::prelude::*;
use std::time::Instant;
use stiction::diagnose::{DiagnoseOptions, Diagnosis};
use stiction::methods::{self, Detector, Subject};
use stiction::recording::Recording;
use stiction::scoreboard::{Scored, Truth};
use stiction::series::median;
use stiction_report::document::{Loop, Source};
use stiction_report::report::{self, Fitted};

/// A loop with its truth.
pub struct Known {
    pub recording: Recording,
    pub source: Source,
    pub truth: Truth,
}

/// Settings of a measurement.
pub struct Plan<'a> {
    pub options: DiagnoseOptions,
    /// Whether to time the diagnosis and the methods.
    pub time: bool,
    /// Folder of the reports.
    pub reports: Option<&'a Out>,
}

/// The results, with lists in the order of the loops.
#[derive(Default)]
pub struct Measured {
    pub loops: Vec<Scored>,
    /// Names of the files of the reports; empty without reports.
    pub reports: Vec<String>,
    /// Median times in microseconds; empty unless they were requested.
    pub times: Vec<(String, f64)>,
    /// Times of each loop: first of the diagnosis, then of each method.
    each: Vec<Vec<f64>>,
}

/// The result of one loop.
struct One {
    scored: Scored,
    report: Option<String>,
    times: Vec<f64>,
}

impl Measured {
    /// Measures more loops. `load` makes each loop when its turn comes, so that few are in memory at a time.
    pub fn add<J: Sync>(
        &mut self,
        jobs: &[J],
        load: impl Fn(&J) -> Result<Known> + Sync,
        plan: &Plan<'_>,
    ) -> Result<()> {
        let progress = progress::bar("diagnosing", jobs.len());
        let first = self.loops.len();
        let results: Vec<Result<One>> = jobs
            .par_iter()
            .enumerate()
            .map(|(k, job)| {
                let one = load(job).and_then(|known| one(known, first + k, plan));
                progress.inc(1);
                one
            })
            .collect();
        progress.finish_and_clear();
        for result in results {
            let One { scored, report, times } = result?;
            self.loops.push(scored);
            self.reports.extend(report);
            self.each.push(times);
        }
        Ok(())
    }

    /// Computes the median times.
    pub fn finish(mut self, plan: &Plan<'_>) -> Result<Self> {
        if plan.time {
            let detectors = plan.options.detectors.selected();
            let names = detectors.iter().map(|detector| detector.method().name.to_owned());
            let names = std::iter::once("whole diagnosis".to_owned()).chain(names);
            self.times = names
                .enumerate()
                .map(|(k, name)| {
                    let times: Vec<f64> =
                        self.each.iter().filter_map(|times| times.get(k).copied()).collect();
                    (name, median(&times))
                })
                .collect();
        }
        Ok(self)
    }
}

fn one(known: Known, place: usize, plan: &Plan<'_>) -> Result<One> {
    let Known { recording, source, truth } = known;
    let started = Instant::now();
    let diagnosis = stiction::diagnose::diagnose(&recording, &plan.options)
        .with_context(|| format!("{}, loop {}", source.file, recording.name))?;
    let mut times = vec![];
    if plan.time {
        times.push(microseconds(started));
        times.extend(times_of_methods(&diagnosis, &plan.options.detectors.selected()));
    }
    let report = match plan.reports {
        Some(folder) => {
            let name = report::folder::file_name(place, &diagnosis.name);
            let fitted = Fitted::of_accused(&diagnosis);
            let one = Loop::new(&source, &diagnosis).with_fit(&fitted);
            let html = report::html(output::TOOL, &[one])?;
            output::write(Some(&folder.inside(&name)?), html.as_bytes())?;
            Some(name)
        }
        None => None,
    };
    Ok(One { scored: Scored::new(&diagnosis, truth), report, times })
}

/// The time that each method takes, 0 for a method without data.
fn times_of_methods(diagnosis: &Diagnosis, detectors: &[Box<dyn Detector>]) -> Vec<f64> {
    let Some(seen) = diagnosis.subject() else { return vec![] };
    let time = |detector: &dyn Detector| {
        let started = Instant::now();
        // Each method computes everything itself, so that none profits from the work of another.
        let subject = Subject::new(seen.segment, seen.loop_type, seen.period);
        std::hint::black_box(methods::judge(detector, &subject));
        microseconds(started)
    };
    detectors.iter().map(|detector| time(&**detector)).collect()
}

fn microseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e6
}
