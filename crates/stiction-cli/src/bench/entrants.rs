//! Detectors on the loops of a suite or on labelled recordings: a program, or our verdict and the published methods.

use super::program::{How, Program};
use super::{Form, labelled};
use crate::files::In;
use crate::{output, progress, text};
use anyhow::{Context, Result, anyhow, bail};
use rayon::prelude::*;
use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use stiction::diagnose::{Detectors, DiagnoseOptions, diagnose};
use stiction::recording::Recording;
use stiction::score::bench::exchange;
use stiction::score::bench::key::key;
use stiction::score::bench::leaderboard;
use stiction::score::bench::results::{Detector, Entrant, Label, Loops, Results};
use stiction::scoreboard::{Answer, KnownLoop, answers_of};
use stiction::suite::{Known, Suite};

/// The variable of the environment that holds the passphrase of a hidden half.
pub const PASSPHRASE: &str = "STICTION_BENCH_PASSPHRASE";

/// The answers of several detectors about one loop, with their names.
type Answers = Vec<(&'static str, Answer)>;

/// The loops of a measurement.
pub enum Source {
    Suite(Suite),
    Labels(Vec<labelled::Entry>),
}

impl Source {
    /// The loops of a suite, or of its hidden half.
    pub fn suite(name: &str, hidden: bool) -> Result<Self> {
        suite(name, hidden).map(Self::Suite)
    }

    /// Labelled recordings.
    pub fn labels(index: &In, allow_outside: bool) -> Result<Self> {
        Ok(Self::Labels(labelled::entries(index, allow_outside)?.0))
    }

    fn len(&self) -> usize {
        match self {
            Self::Suite(suite) => suite.len(),
            Self::Labels(entries) => entries.len(),
        }
    }

    /// The detectors' answers in the results.
    pub fn loops(&self) -> Loops {
        match self {
            Self::Suite(suite) => Loops::of(suite),
            Self::Labels(entries) => {
                Loops::labelled(entries.iter().map(labelled::Entry::label).collect())
            }
        }
    }

    fn known(&self, index: usize) -> Result<Known> {
        match self {
            Self::Suite(suite) => Ok(suite.known(index)?),
            Self::Labels(entries) => {
                let known = labelled::load(&entries[index])?;
                Ok(Known { recording: known.recording, asked: entries[index].label().known_loop() })
            }
        }
    }

    /// The truth about all of them.
    pub fn known_loops(&self) -> Result<Vec<KnownLoop>> {
        if let Self::Labels(entries) = self {
            return Ok(entries.iter().map(|entry| entry.label().known_loop()).collect());
        }
        let progress = progress::bar("simulating", self.len());
        let one = |k: usize| {
            let known = self.known(k);
            progress.inc(1);
            known.map(|known| known.asked)
        };
        let asked = (0..self.len()).into_par_iter().map(one).collect();
        progress.finish_and_clear();
        asked
    }
}

/// A suite, or its hidden half by the passphrase in the environment.
pub fn suite(name: &str, hidden: bool) -> Result<Suite> {
    let key = match hidden {
        false => None,
        true => {
            let passphrase = std::env::var(PASSPHRASE).with_context(|| {
                format!("{PASSPHRASE} must hold the passphrase of the hidden half")
            })?;
            Some(key(&passphrase).map_err(|e| anyhow!("{PASSPHRASE}: {e}"))?)
        }
    };
    Ok(Suite::by_name(name, key)?)
}

/// The answers of a program, run several times side by side.
pub fn program(
    source: &Source,
    how: &How,
    processes: Option<usize>,
) -> Result<(Vec<KnownLoop>, Vec<Answer>)> {
    let n = source.len();
    let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
    let next = AtomicUsize::new(0);
    let progress = progress::bar("asking", n);
    let all = Mutex::new(vec![]);
    std::thread::scope(|scope| {
        for _ in 0..processes.unwrap_or(cores).min(n) {
            scope.spawn(|| {
                let mut program = Program::new(how);
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    if k >= n {
                        break;
                    }
                    let one = source.known(k).map(|Known { recording, asked }| {
                        let answer = match line(&recording) {
                            Ok(line) => program.ask(&asked.id, line),
                            Err(reason) => Answer::none(reason, 0.0),
                        };
                        (asked, answer)
                    });
                    all.lock().unwrap_or_else(PoisonError::into_inner).push((k, one));
                    progress.inc(1);
                }
            });
        }
    });
    progress.finish_and_clear();
    let mut all = all.into_inner().unwrap_or_else(PoisonError::into_inner);
    all.sort_by_key(|(k, _)| *k);
    all.into_iter()
        .map(|(_, one)| one)
        .collect::<Result<Vec<_>>>()
        .map(|all| all.into_iter().unzip())
}

/// The line of a recording; of one that is not evenly sampled, of its longest segment on a grid.
fn line(recording: &Recording) -> std::result::Result<String, String> {
    exchange::line(recording).or_else(|_| {
        let even = labelled::even(recording).map_err(|e| e.to_string())?;
        exchange::line(&even)
    })
}

/// The answers of the verdict and of the methods that the options ask for.
pub fn own(source: &Source, options: &DiagnoseOptions) -> Result<(Vec<KnownLoop>, Vec<Entrant>)> {
    let progress = progress::bar("diagnosing", source.len());
    let one = |k: usize| -> Result<(KnownLoop, Answers)> {
        let Known { recording, asked } = source.known(k)?;
        let started = Instant::now();
        let diagnosis = diagnose(&recording, options).with_context(|| asked.id.clone())?;
        // The time of several together is that of none of them.
        let alone = options.detectors == Detectors::None;
        let time_s = if alone { started.elapsed().as_secs_f64() } else { f64::NAN };
        let answers = answers_of(&diagnosis, time_s);
        progress.inc(1);
        Ok((asked, answers))
    };
    let all: Result<Vec<_>> = (0..source.len()).into_par_iter().map(one).collect();
    progress.finish_and_clear();
    let (asked, answers): (Vec<KnownLoop>, Vec<Answers>) = all?.into_iter().unzip();
    let mut entries: Vec<Entrant> = vec![];
    for (k, each) in answers.into_iter().enumerate() {
        for (at, (name, answer)) in each.into_iter().enumerate() {
            if k == 0 {
                let command = match name {
                    stiction::scoreboard::VERDICT => "stiction bench answer".to_owned(),
                    method => format!("stiction bench answer --method {method}"),
                };
                let version = env!("CARGO_PKG_VERSION").to_owned();
                entries.push((Detector { name: name.to_owned(), version, command }, vec![]));
            }
            entries[at].1.push(answer);
        }
    }
    Ok((asked, entries))
}

/// Prints results as JSON, Markdown or text.
pub fn print(results: &Results, form: &Form) -> Result<()> {
    if form.json {
        return output::json_text(&results.json());
    }
    if form.markdown {
        return output::text(&leaderboard::markdown(results));
    }
    let tables: Vec<String> = leaderboard::summary(results).iter().map(text::plain).collect();
    output::text(&format!("{}\n\n{}", results.loops.title(), tables.join("\n")))
}

/// Refuses loops without both classes, of which nothing can be measured.
pub fn check(labels: &[Label]) -> Result<()> {
    match (labels.iter().any(|label| label.sticks), labels.iter().any(|label| !label.sticks)) {
        (true, true) => Ok(()),
        _ => bail!("the labels name loops of one class only; label both stiction and no stiction"),
    }
}
