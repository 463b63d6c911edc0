//! Reads and diagnoses the loops of some files, for several commands.

use crate::diagnose::joined::Found;
use crate::files::In;
use crate::reading_args::Reading;
use crate::{progress, together};
use anyhow::{Result, anyhow, bail};
use rayon::prelude::*;
use stiction::diagnose::{DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use stiction::recording::Recording;
use stiction_io::Overrides;
use stiction_report::document::{Loop, Source};

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

    /// The same for documents, pages and tables.
    pub fn found(&self) -> Loop<'_> {
        Loop { source: &self.source, diagnosis: &self.diagnosis }
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
    let options = reading.options_of(files)?;
    // The conclusions of people are read beside the files.
    for file in files.iter().filter(|file| !file.is_standard()) {
        In::also(Overrides::path_beside(file))?;
    }
    let progress = progress::bar("reading", files.len());
    let readings = together::recordings(files, options, || progress.inc(1));
    progress.finish_and_clear();
    let is_wanted =
        |name: &str| loops.is_empty() || loops.iter().any(|tag| tag.eq_ignore_ascii_case(name));
    let (mut all, mut failures) = (vec![], vec![]);
    let (mut known, mut elsewhere): (Vec<String>, Vec<String>) = (vec![], vec![]);
    for reading in readings {
        let reading = match reading {
            Ok(reading) => reading,
            Err(error) => {
                failures.push(error);
                continue;
            }
        };
        for mut recording in reading.recordings {
            known.push(recording.name.clone());
            if !is_wanted(&recording.name) {
                continue;
            }
            recording.notes.splice(0..0, reading.notes.iter().cloned());
            let source = Source { file: reading.origin.clone(), sha256: reading.sha256.clone() };
            let is_tagged = !reading.untagged.contains(&recording.name);
            all.push(Found { source, recording, is_tagged });
        }
        for missing in reading.missing.into_iter().filter(|each| is_wanted(&each.name)) {
            if missing.is_partly_here {
                let (file, name) = (&reading.origin, &missing.name);
                failures.push(anyhow!("{file}, loop {name}: the file {}", missing.reason));
                known.push(missing.name);
            } else {
                elsewhere.push(missing.name);
            }
        }
    }
    // A loop that one file lacks may be in another. A loop that no file has is misspelt or was forgotten.
    elsewhere.sort();
    elsewhere.dedup();
    elsewhere.retain(|name| !known.iter().any(|read| read.to_lowercase() == name.to_lowercase()));
    for name in elsewhere {
        failures.push(anyhow!(
            "loop {name}: the mapping names its columns or tags, but no file that could be read has them"
        ));
    }
    for tag in loops {
        if failures.is_empty() && !known.iter().any(|name| name.eq_ignore_ascii_case(tag)) {
            bail!("--loop {tag}: no such loop; there are {}", known.join(", "));
        }
    }
    Ok((all, failures))
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
