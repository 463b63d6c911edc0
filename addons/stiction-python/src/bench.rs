//! The benchmark of detectors.

use crate::errors::refused;
use crate::long::long;
use crate::recordings::Recording;
use crate::table::{self, ArrowTable};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use stiction::methods::MethodId;
use stiction::score::bench::exchange::{AnswerLine, ParsedLine, parsed_line};
use stiction::score::bench::key::key;
use stiction::score::bench::leaderboard;
use stiction::score::bench::results::{
    Detector, Label, Loops, Results, Submitted, joined, same_loops,
};
use stiction::scoreboard::{Answer, Errors, Interval, KnownLoop, Share, answer_of};
use stiction::suite::{Known, Suite};
use stiction_report::document;

/// Name and version of the program, as documents show them.
const TOOL: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// A suite of loops, or labelled recordings.
#[pyclass(frozen, module = "stiction._core")]
#[derive(Debug)]
pub struct BenchSuite(Source);

#[derive(Debug, Clone)]
enum Source {
    Suite(Suite),
    Labelled(Vec<(Recording, Label)>),
}

/// A loop of a suite.
#[pyclass(frozen, module = "stiction._core")]
#[derive(Debug, Clone)]
pub struct BenchLoop {
    recording: Recording,
    asked: KnownLoop,
}

/// Name, version and command of a detector, and the line and time of each answer.
type Entry = (String, String, String, Vec<(String, f64)>);

/// The measures of detectors.
#[pyclass(frozen, module = "stiction._core")]
#[derive(Debug)]
pub struct BenchResults {
    results: Results,
    asked: Vec<KnownLoop>,
}

#[pymethods]
impl BenchLoop {
    #[getter]
    fn recording(&self) -> Recording {
        self.recording.clone()
    }

    #[getter]
    fn valve(&self) -> &str {
        &self.asked.truth.valve
    }

    /// Whether the valve sticks; None if the stiction is masked.
    #[getter]
    fn sticks(&self) -> Option<bool> {
        self.asked.counts().then_some(self.asked.truth.sticks)
    }
}

#[pymethods]
impl BenchSuite {
    fn __len__(&self) -> usize {
        match &self.0 {
            Source::Suite(suite) => suite.len(),
            Source::Labelled(all) => all.len(),
        }
    }

    /// Loops from `first` to below `until`.
    fn loops(&self, py: Python<'_>, first: usize, until: usize) -> PyResult<Vec<BenchLoop>> {
        let suite = match &self.0 {
            Source::Suite(suite) => suite.clone(),
            Source::Labelled(all) => {
                let of = |(recording, label): &(Recording, Label)| BenchLoop {
                    recording: recording.clone(),
                    asked: label.known_loop(),
                };
                return Ok(all[first..until].iter().map(of).collect());
            }
        };
        long(py, None, move |_| {
            let one = |k| {
                let Known { recording, asked } = suite.known(k)?;
                let source = document::Source { file: String::new(), sha256: String::new() };
                Ok(BenchLoop { recording: Recording::new(recording, source), asked })
            };
            (first..until).into_par_iter().map(one).collect::<stiction::Result<_>>()
        })?
        .map_err(refused)
    }

    /// The measures of detectors on these loops.
    fn results(
        &self,
        py: Python<'_>,
        loops: Vec<PyRef<'_, BenchLoop>>,
        entries: Vec<Entry>,
    ) -> PyResult<BenchResults> {
        let asked: Vec<KnownLoop> = loops.iter().map(|each| each.asked.clone()).collect();
        let known = match &self.0 {
            Source::Suite(suite) => Loops::of(suite),
            Source::Labelled(all) => {
                Loops::labelled(all.iter().map(|(_, label)| label.clone()).collect())
            }
        };
        let entries = entries
            .into_iter()
            .map(|(name, version, command, lines)| {
                let answers = lines.iter().zip(&asked).map(|((line, time_s), asked)| {
                    let answer = match parsed_line(line, &asked.id) {
                        ParsedLine::Answer(answer) => answer,
                        ParsedLine::Other => Answer::none("the answer is about another loop", 0.0),
                    };
                    Answer { time_s: *time_s, ..answer }
                });
                (Detector { name, version, command }, answers.collect())
            })
            .collect();
        measured(py, move || Ok((Results::of(TOOL, known, &asked, entries), asked)))
    }
}

#[pymethods]
impl BenchResults {
    /// As JSON.
    fn json(&self) -> String {
        self.results.json()
    }

    /// The tables in Markdown.
    fn markdown(&self) -> String {
        leaderboard::markdown(&self.results)
    }

    /// The page.
    fn html(&self) -> PyResult<String> {
        leaderboard::html(&self.results, &self.asked)
            .map_err(|e| PyValueError::new_err(e.to_string()))
    }

    /// The main measures, one row per detector.
    fn table(&self) -> PyResult<ArrowTable> {
        let entries = &self.results.entries;
        let mut columns =
            vec![table::texts("detector", entries.iter().map(|each| Some(&each.detector.name)))];
        /// Columns of numbers of the measures `m` or the time of an entry.
        macro_rules! numbers {
            ($($name:literal: |$entry:ident| $value:expr),* $(,)?) => {
                $(columns.push(table::numbers($name, entries.iter().map(|$entry| $value)));)*
            };
        }
        let low = |share: Share| (share.n > 0).then(|| share.interval().0);
        let high = |share: Share| (share.n > 0).then(|| share.interval().1);
        let at = |interval: Option<Interval>, part: fn(Interval) -> f64| interval.map(part);
        let time = |errors: Option<Errors>, part: fn(Errors) -> f64| errors.map(part);
        numbers!(
            "auc": |e| e.measures.auc.map(|auc| auc.value),
            "auc_low": |e| e.measures.auc.map(|auc| auc.low),
            "auc_high": |e| e.measures.auc.map(|auc| auc.high),
            "auc_of_all": |e| e.measures.auc.map(|auc| auc.of_all),
            "recall_at_1_percent": |e| at(e.measures.recall_at_1_percent, |i| i.value),
            "recall_at_1_percent_low": |e| at(e.measures.recall_at_1_percent, |i| i.low),
            "recall_at_1_percent_high": |e| at(e.measures.recall_at_1_percent, |i| i.high),
            "recall": |e| e.measures.decisions.recall().value(),
            "recall_low": |e| low(e.measures.decisions.recall()),
            "recall_high": |e| high(e.measures.decisions.recall()),
            "false_alarms": |e| e.measures.decisions.false_alarms().value(),
            "false_alarms_low": |e| low(e.measures.decisions.false_alarms()),
            "false_alarms_high": |e| high(e.measures.decisions.false_alarms()),
            "without_decision": |e| e.measures.decisions.without_decision().value(),
            "mean_risk": |e| e.measures.risk.as_ref().map(|risk| risk.area.value),
            "mean_risk_low": |e| e.measures.risk.as_ref().map(|risk| risk.area.low),
            "mean_risk_high": |e| e.measures.risk.as_ref().map(|risk| risk.area.high),
            "median_time_s": |e| time(e.time, |t| t.median),
            "answered": |e| e.measures.answered.value(),
        );
        ArrowTable::of(columns)
    }

    /// Detector, loop and reason of each missing answer.
    fn failures(&self) -> Vec<(String, String, String)> {
        let of = |name: &str, said: &AnswerLine| {
            let reason = said.no_answer.clone()?;
            Some((name.to_owned(), said.id.clone(), reason))
        };
        let entries = self.results.entries.iter();
        entries
            .flat_map(|e| e.answers.iter().filter_map(|said| of(&e.detector.name, said)))
            .collect()
    }
}

fn measured(
    py: Python<'_>,
    measure: impl FnOnce() -> Result<(Results, Vec<KnownLoop>), String> + Send + 'static,
) -> PyResult<BenchResults> {
    let (results, asked) = long(py, None, move |_| measure())?.map_err(PyValueError::new_err)?;
    Ok(BenchResults { results, asked })
}

fn suite(name: &str, passphrase: Option<&str>) -> Result<Suite, String> {
    let key = passphrase.map(key).transpose()?;
    Suite::by_name(name, key).map_err(|e| e.to_string())
}

/// The suite of this name, or its hidden half.
#[pyfunction]
pub fn bench_suite(name: &str, passphrase: Option<&str>) -> PyResult<BenchSuite> {
    let found = suite(name, passphrase).map_err(PyValueError::new_err)?;
    Ok(BenchSuite(Source::Suite(found)))
}

/// Labelled recordings: each with its name, valve, label, source and licence.
#[pyfunction]
pub fn bench_labelled(
    recordings: Vec<Recording>,
    labels: Vec<(String, String, bool, String, String)>,
) -> BenchSuite {
    let label = |(id, valve, sticks, source, licence)| Label { id, valve, sticks, source, licence };
    BenchSuite(Source::Labelled(
        recordings.into_iter().zip(labels.into_iter().map(label)).collect(),
    ))
}

/// Names of the suites, with their descriptions.
#[pyfunction]
pub fn bench_suites() -> Vec<(&'static str, &'static str)> {
    Suite::all().collect()
}

/// The line of the answer of the verdict, or of a method.
#[pyfunction]
pub fn bench_answer(
    py: Python<'_>,
    recording: &Recording,
    method: Option<&str>,
) -> PyResult<String> {
    let method = method.map(str::parse::<MethodId>).transpose().map_err(refused)?;
    let recording = recording.recording.clone();
    let name = recording.name.clone();
    let answer = py.detach(move || answer_of(&recording, method)).map_err(refused)?;
    Ok(AnswerLine::of(&name, &answer).line())
}

/// Results in texts, each with its origin, measured again together.
#[pyfunction]
pub fn bench_read(
    py: Python<'_>,
    texts: Vec<(String, String)>,
    passphrase: Option<String>,
) -> PyResult<BenchResults> {
    measured(py, move || {
        let mut submitted = vec![];
        for (origin, text) in texts {
            let found = Submitted::read(&text).map_err(|e| format!("{origin} {e}"))?;
            submitted.push((origin, found));
        }
        let loops = same_loops(&submitted)?;
        let (loops, asked) = match &loops.suite {
            Some(_) if loops.hidden && passphrase.is_none() => {
                return Err("the results are about a hidden half; give its passphrase".to_owned());
            }
            Some(name) => {
                let suite = suite(name, passphrase.as_deref().filter(|_| loops.hidden))?;
                let asked = |k| suite.known(k).map(|known| known.asked);
                let all: stiction::Result<Vec<KnownLoop>> =
                    (0..suite.len()).into_par_iter().map(asked).collect();
                (Loops::of(&suite), all.map_err(|e| e.to_string())?)
            }
            None => (loops.clone(), loops.labels.iter().map(Label::known_loop).collect()),
        };
        Ok((joined(TOOL, &submitted, loops, &asked)?, asked))
    })
}
