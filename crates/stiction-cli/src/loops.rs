//! Reads and diagnoses the loops of some files, for several commands.

use crate::diagnose::joined::Found;
use crate::files::In;
use crate::reading_args::Reading;
use crate::{input, progress, together};
use anyhow::{Result, anyhow, bail};
use rayon::prelude::*;
use stiction::diagnose::{DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use stiction::recording::Recording;
use stiction_io::ReadOptions;
use stiction_plant::overrides::Overrides;
use stiction_report::document::{Loop, Source};

/// Number of samples of a file that are at least judged at a time, so that all threads have loops to judge.
const AT_A_TIME: usize = 1 << 20;

/// A loop with its diagnosis and its source.
pub struct Diagnosed {
    pub source: Source,
    pub diagnosis: Diagnosis,
}

impl Diagnosed {
    /// The class that counts for --fail-on: the conclusion of a person, else the computed verdict.
    pub fn class(&self) -> VerdictClass {
        let verdict = &self.diagnosis.verdict;
        verdict.overruled.as_ref().map_or(verdict.class, |said| said.verdict)
    }

    /// The diagnosis for documents, pages and tables.
    pub fn found(&self) -> Loop<'_> {
        Loop::new(&self.source, &self.diagnosis)
    }
}

/// The selected recordings of all files with their sources, each separate, and the errors of files that could not be
/// read.
#[allow(clippy::type_complexity)]
pub fn read_all(
    files: &[In],
    loops: &[String],
    reading: &Reading,
) -> Result<(Vec<(Source, Recording)>, Vec<anyhow::Error>)> {
    let (found, failures) = find_all(files, loops, reading)?;
    Ok((found.into_iter().map(|each| (each.source, each.recording)).collect(), failures))
}

/// The selected recordings of all files, each separate, and the errors of files that could not be read.
pub fn find_all(
    files: &[In],
    loops: &[String],
    reading: &Reading,
) -> Result<(Vec<Found>, Vec<anyhow::Error>)> {
    let options = options_of(files, reading)?;
    let progress = progress::bar("reading", files.len());
    let readings: Vec<Result<stiction_io::Reading>> =
        together::read(files, options, || progress.inc(1));
    progress.finish_and_clear();
    let (mut all, mut choice) = (vec![], Choice::of(loops));
    for reading in readings {
        let mut reading = match reading {
            Ok(reading) => reading,
            Err(error) => {
                choice.failures.push(error);
                continue;
            }
        };
        for mut recording in std::mem::take(&mut reading.recordings) {
            if !choice.takes(&recording.name) {
                continue;
            }
            recording.notes.splice(0..0, reading.notes.iter().cloned());
            let source = Source { file: reading.origin.clone(), sha256: reading.sha256.clone() };
            let is_tagged = !reading.untagged.contains(&recording.name);
            all.push(Found { source, recording, is_tagged });
        }
        choice.misses(reading);
    }
    Ok((all, choice.failures()?))
}

/// Diagnoses the selected loops of one file in batches, so that not all recordings need to be in memory. With the
/// errors of those that could not be diagnosed.
pub fn diagnose_file(
    file: &In,
    loops: &[String],
    reading: &Reading,
    options: &DiagnoseOptions,
) -> Result<(Vec<Diagnosed>, Vec<anyhow::Error>)> {
    let own = options_of(std::slice::from_ref(file), reading)?.remove(0);
    let mut choice = Choice::of(loops);
    let (mut waiting, mut results): (Vec<Recording>, Vec<_>) = (vec![], vec![]);
    let progress = progress::spinner("diagnosing");
    let mut judge = |waiting: &mut Vec<Recording>| {
        results.par_extend(std::mem::take(waiting).into_par_iter().map(|recording| {
            let mut result = diagnose(&recording, options);
            if let (Ok(diagnosis), false) = (&mut result, options.evidence) {
                release(diagnosis);
            }
            (recording.name, result)
        }));
    };
    let read = own.map_err(|error| anyhow!("{error:#}")).and_then(|own| {
        let read = input::visit(file, &own, &mut |recording, _| {
            if !choice.takes(&recording.name) {
                return;
            }
            waiting.push(recording);
            let samples: usize = waiting.iter().map(|each| each.op.time.len()).sum();
            if samples >= AT_A_TIME && waiting.len() >= rayon::current_num_threads() {
                judge(&mut waiting);
            }
        });
        Ok(read?)
    });
    judge(&mut waiting);
    progress.finish_and_clear();
    let mut diagnosed = vec![];
    let mut refused = vec![];
    match read {
        Err(error) => choice.failures.push(error),
        Ok(reading) => {
            let source = Source { file: reading.origin.clone(), sha256: reading.sha256.clone() };
            for (name, result) in results {
                match result {
                    Ok(mut diagnosis) => {
                        diagnosis.notes.splice(0..0, reading.notes.iter().cloned());
                        diagnosed.push(Diagnosed { source: source.clone(), diagnosis });
                    }
                    Err(error) => {
                        refused.push(anyhow!("{}, loop {name}: {error}", source.file));
                    }
                }
            }
            choice.misses(reading);
        }
    }
    let mut failures = choice.failures()?;
    failures.extend(refused);
    Ok((diagnosed, failures))
}

/// Releases samples that only a report draws. Of these signals it keeps only whether they were recorded.
fn release(diagnosis: &mut Diagnosis) {
    diagnosis.recent = None;
    for segment in &mut diagnosis.grid.segments {
        let signals = [&mut segment.pv, &mut segment.sp, &mut segment.vp];
        signals.into_iter().flatten().for_each(|samples| *samples = vec![]);
    }
}

/// The options of each file. The conclusions of people are read beside the files.
fn options_of(files: &[In], reading: &Reading) -> Result<Vec<Result<ReadOptions>>> {
    let options = reading.options_of(files)?;
    for file in files.iter().filter(|file| !file.is_standard()) {
        In::also(Overrides::path_for(file))?;
    }
    Ok(options)
}

/// The loops that the user selects, and their results.
struct Choice<'a> {
    loops: &'a [String],
    failures: Vec<anyhow::Error>,
    known: Vec<String>,
    /// Loops of the mapping that a file lacks.
    elsewhere: Vec<String>,
}

impl<'a> Choice<'a> {
    fn of(loops: &'a [String]) -> Self {
        Self { loops, failures: vec![], known: vec![], elsewhere: vec![] }
    }

    fn is_wanted(&self, name: &str) -> bool {
        self.loops.is_empty() || self.loops.iter().any(|tag| tag.eq_ignore_ascii_case(name))
    }

    /// Whether a loop of a file is selected.
    fn takes(&mut self, name: &str) -> bool {
        self.known.push(name.to_owned());
        self.is_wanted(name)
    }

    /// Takes the loops that a file lacks.
    fn misses(&mut self, reading: stiction_io::Reading) {
        for missing in reading.missing {
            if !self.is_wanted(&missing.name) {
                continue;
            }
            if missing.is_partly_here {
                let (file, name) = (&reading.origin, &missing.name);
                self.failures.push(anyhow!("{file}, loop {name}: the file {}", missing.reason));
                self.known.push(missing.name);
            } else {
                self.elsewhere.push(missing.name);
            }
        }
    }

    /// The failures, once all files are read.
    ///
    /// # Errors
    /// If there is no loop of a name that the user gives.
    fn failures(self) -> Result<Vec<anyhow::Error>> {
        let Self { loops, mut failures, known, mut elsewhere } = self;
        // A loop that one file lacks may be in another. A loop that no file has is misspelt or was forgotten.
        elsewhere.sort();
        elsewhere.dedup();
        elsewhere
            .retain(|name| !known.iter().any(|read| read.to_lowercase() == name.to_lowercase()));
        for name in elsewhere {
            failures.push(anyhow!(
            "loop {name}: the mapping names columns or tags of this loop, but no readable file has them"
        ));
        }
        for tag in loops {
            if failures.is_empty() && !known.iter().any(|name| name.eq_ignore_ascii_case(tag)) {
                bail!("--loop {tag}: no such loop; there are {}", known.join(", "));
            }
        }
        Ok(failures)
    }
}

/// The only one of some loops of a file.
///
/// # Errors
/// If the file has no loop, or more than one. The message lists their names.
pub fn only<T>(file: &In, mut all: Vec<T>, name: impl Fn(&T) -> &str) -> Result<T> {
    if all.len() != 1 {
        let tags = all.iter().map(name).collect::<Vec<_>>().join(", ");
        bail!("{} holds {} loops; choose one with --loop: {tags}", file.origin(), all.len());
    }
    Ok(all.swap_remove(0))
}

/// Diagnoses all recordings, in order.
pub fn diagnose_all(
    recordings: &[(Source, Recording)],
    options: &DiagnoseOptions,
) -> (Vec<Diagnosed>, Vec<anyhow::Error>) {
    let progress = progress::bar("diagnosing", recordings.len());
    let results: Vec<_> = recordings
        .par_iter()
        .map(|(source, recording)| {
            let result = diagnose(recording, options);
            progress.inc(1);
            (source, recording, result)
        })
        .collect();
    progress.finish_and_clear();
    let (mut loops, mut failures) = (vec![], vec![]);
    for (source, recording, result) in results {
        match result {
            Ok(diagnosis) => loops.push(Diagnosed { source: source.clone(), diagnosis }),
            Err(error) => {
                failures.push(anyhow::anyhow!("{}, loop {}: {error}", source.file, recording.name))
            }
        }
    }
    (loops, failures)
}
