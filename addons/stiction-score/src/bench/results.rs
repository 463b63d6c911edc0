//! The measures of one or several detectors on the same loops, as a document.

use super::exchange::AnswerLine;
use crate::scoreboard::{Answer, Comparison, Errors, KnownLoop, Measures, Truth, times};
use crate::suite::Suite;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use stiction_report::document::json;

/// Version of the document. A change that breaks its readers gets a new one.
pub const VERSION: u32 = 1;
/// Up to this number, each detector is compared with each other one. Beyond it, only the first detector is compared
/// with each other one.
const EACH: usize = 6;

/// A detector with its answers, in the order of the loops.
pub type Entrant = (Detector, Vec<Answer>);

/// The measures of detectors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Results {
    /// Name and version of the program that measured.
    pub tool: String,
    /// Version of this form.
    pub version: u32,
    /// The loops.
    pub loops: Loops,
    /// The detectors.
    pub entries: Vec<Entry>,
    /// Comparisons of two detectors.
    pub comparisons: Vec<Compared>,
}

/// The loops of a measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Loops {
    /// Name of the suite; null for labelled recordings.
    pub suite: Option<String>,
    /// Whether they are the hidden half of the suite.
    pub hidden: bool,
    /// Version of the population behind the suite.
    pub population: u32,
    /// Number of loops.
    pub number: usize,
    /// The labels of recordings; empty for a suite, whose truth follows from its seeds.
    pub labels: Vec<Label>,
}

/// A labelled recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Label {
    /// The recording.
    pub id: String,
    /// Valve.
    pub valve: String,
    /// Whether the valve sticks, by its label.
    pub sticks: bool,
    /// Source of the recording.
    pub source: String,
    /// Licence.
    pub licence: String,
}

/// The name of a detector.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Detector {
    /// Name.
    pub name: String,
    /// Version of the detector, if given.
    pub version: String,
    /// The command, or the function, that was measured.
    pub command: String,
}

/// A detector with its answers and their measures.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Entry {
    /// The detector.
    pub detector: Detector,
    /// SHA-256 of the answers, hexadecimal: of their lines without times.
    pub sha256: String,
    /// Times for an answer, s.
    pub time: Option<Errors>,
    /// The measures.
    pub measures: Measures,
    /// The answers, in the order of the loops.
    pub answers: Vec<AnswerLine>,
}

/// The comparison of two detectors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Compared {
    /// Name of the first.
    pub first: String,
    /// Name of the second.
    pub second: String,
    /// The comparison.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Results as they are read: measures are computed again.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Submitted {
    /// Name and version of the program that measured.
    pub tool: String,
    version: u32,
    /// The loops.
    pub loops: Loops,
    /// The detectors.
    pub entries: Vec<SubmittedEntry>,
}

/// A detector as it is read.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct SubmittedEntry {
    /// The detector.
    pub detector: Detector,
    sha256: String,
    measures: serde_json::Value,
    /// The answers.
    pub answers: Vec<AnswerLine>,
}

impl Loops {
    /// Those of a suite.
    pub fn of(suite: &Suite) -> Self {
        Self {
            suite: Some(suite.name().to_owned()),
            hidden: suite.is_hidden(),
            population: stiction_population::VERSION,
            number: suite.len(),
            labels: vec![],
        }
    }

    /// Labelled recordings.
    pub fn labelled(labels: Vec<Label>) -> Self {
        Self { suite: None, hidden: false, population: 0, number: labels.len(), labels }
    }

    /// In words.
    pub fn title(&self) -> String {
        match &self.suite {
            Some(name) if self.hidden => {
                format!("Hidden half of suite {name}, {} loops", self.number)
            }
            Some(name) => format!("Suite {name}, {} loops", self.number),
            None => format!("{} labelled recordings", self.number),
        }
    }
}

impl Label {
    /// The truth by the label. Stiction by the label counts as visible.
    pub fn known_loop(&self) -> KnownLoop {
        let truth = Truth {
            valve: self.valve.clone(),
            kind: String::new(),
            sticks: self.sticks,
            visible: self.sticks,
            s: None,
            j: None,
            member: None,
        };
        KnownLoop { id: self.id.clone(), truth, groups: vec![] }
    }
}

impl Results {
    /// Measures detectors by their answers to the same loops, in the same order.
    pub fn of(tool: &str, loops: Loops, asked: &[KnownLoop], entries: Vec<Entrant>) -> Self {
        let answers: Vec<Vec<&Answer>> =
            entries.iter().map(|(_, answers)| answers.iter().collect()).collect();
        let all: Vec<&KnownLoop> = asked.iter().collect();
        let n = entries.len();
        let pairs: Vec<(usize, usize)> = (0..n)
            .flat_map(|a| (a + 1..n).map(move |b| (a, b)))
            .filter(|(a, _)| n <= EACH || *a == 0)
            .collect();
        let comparisons = pairs
            .par_iter()
            .map(|(a, b)| Compared {
                first: entries[*a].0.name.clone(),
                second: entries[*b].0.name.clone(),
                comparison: Comparison::of(&all, &answers[*a], &answers[*b]),
            })
            .collect();
        let entries = entries
            .par_iter()
            .map(|(detector, answers)| {
                let pairs: Vec<_> = asked.iter().zip(answers).collect();
                let said: Vec<AnswerLine> =
                    pairs.iter().map(|(asked, answer)| AnswerLine::of(&asked.id, answer)).collect();
                Entry {
                    detector: detector.clone(),
                    sha256: sha256(&said),
                    time: times(answers),
                    measures: Measures::of(&pairs),
                    answers: said,
                }
            })
            .collect();
        Self { tool: tool.to_owned(), version: VERSION, loops, entries, comparisons }
    }

    /// As JSON text, indented.
    pub fn json(&self) -> String {
        json(self)
    }
}

impl Submitted {
    /// The results in a text.
    ///
    /// # Errors
    /// If the text does not contain results of this version. The error is a sentence.
    pub fn read(text: &str) -> Result<Self, String> {
        let version: Option<u64> = serde_json::from_str::<serde_json::Value>(text)
            .map_err(|e| format!("is not JSON: {e}"))?
            .get("version")
            .and_then(serde_json::Value::as_u64);
        match version {
            Some(known) if known == u64::from(VERSION) => {}
            Some(other) => {
                return Err(format!("has results of version {other}, but {VERSION} is needed"));
            }
            None => return Err("holds no results of stiction bench".to_owned()),
        }
        let found: Self = serde_json::from_str(text)
            .map_err(|e| format!("holds no results of stiction bench detector: {e}"))?;
        match found.entries.is_empty() {
            true => Err("holds no detector".to_owned()),
            false => Ok(found),
        }
    }

    /// The detectors with their answers, for measuring them again.
    ///
    /// # Errors
    /// If the answers of a detector do not belong to these loops. The error is a sentence.
    pub fn answers(&self, asked: &[KnownLoop]) -> Result<Vec<Entrant>, String> {
        let of = |entry: &SubmittedEntry| {
            let name = &entry.detector.name;
            if entry.answers.len() != asked.len() {
                let (found, wanted) = (entry.answers.len(), asked.len());
                return Err(format!("{name} has {found} answers, but there are {wanted} loops"));
            }
            let wrong = entry.answers.iter().zip(asked).find(|(said, asked)| said.id != asked.id);
            if let Some((said, asked)) = wrong {
                return Err(format!(
                    "{name}: the answer {} is where {} belongs",
                    said.id, asked.id
                ));
            }
            Ok((entry.detector.clone(), entry.answers.iter().map(AnswerLine::answer).collect()))
        };
        self.entries.iter().map(of).collect()
    }

    /// Differences from the same answers measured again; empty without differences.
    pub fn faults(&self, again: &Results) -> Vec<String> {
        let mut faults = vec![];
        if self.loops.population != again.loops.population {
            faults.push(format!(
                "the loops are of population {}, but this program has {}",
                self.loops.population, again.loops.population
            ));
        }
        for (entry, measured) in self.entries.iter().zip(&again.entries) {
            let name = &entry.detector.name;
            if entry.sha256 != sha256(&entry.answers) {
                faults.push(format!("{name}: the SHA-256 is not that of the answers"));
            }
            if entry.detector.command.is_empty() {
                faults.push(format!("{name}: the command is missing"));
            }
            let wanted = serde_json::to_value(&measured.measures).unwrap_or_default();
            if let Some(at) = difference(&entry.measures, &wanted, "measures") {
                faults.push(format!("{name}: {at} does not follow from the answers"));
            }
        }
        faults
    }
}

/// The loops that several results, each with its origin, are about.
///
/// # Errors
/// If the results are about different loops, or no results are given. The error is a sentence.
pub fn same_loops(submitted: &[(String, Submitted)]) -> Result<&Loops, String> {
    let Some((origin, first)) = submitted.first() else {
        return Err("there are no results".to_owned());
    };
    match submitted.iter().find(|(_, each)| each.loops != first.loops) {
        Some((other, each)) => Err(format!(
            "{other} is about other loops ({}) than {origin} ({}); compare results about the same loops",
            each.loops.title(),
            first.loops.title()
        )),
        None => Ok(&first.loops),
    }
}

/// Several results about the same loops, measured again together. Equal names of detectors get their origins.
///
/// # Errors
/// As [`Submitted::answers`].
pub fn joined(
    tool: &str,
    submitted: &[(String, Submitted)],
    loops: Loops,
    asked: &[KnownLoop],
) -> Result<Results, String> {
    let mut entries: Vec<Entrant> = vec![];
    for (origin, each) in submitted {
        let answers = each.answers(asked).map_err(|e| format!("{origin}: {e}"))?;
        for (mut detector, answers) in answers {
            if submitted.len() > 1 && entries.iter().any(|(known, _)| known.name == detector.name) {
                detector.name = format!("{} ({origin})", detector.name);
            }
            entries.push((detector, answers));
        }
    }
    Ok(Results::of(tool, loops, asked, entries))
}

/// The place of the first difference.
fn difference(a: &serde_json::Value, b: &serde_json::Value, at: &str) -> Option<String> {
    use serde_json::Value;
    match (a, b) {
        (Value::Object(a), Value::Object(b)) if a.len() == b.len() => {
            b.iter().find_map(|(key, b)| {
                difference(a.get(key).unwrap_or(&Value::Null), b, &format!("{at}.{key}"))
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let mut pairs = a.iter().zip(b).enumerate();
            pairs.find_map(|(k, (a, b))| difference(a, b, &format!("{at}[{k}]")))
        }
        _ => (a != b).then(|| at.to_owned()),
    }
}

/// SHA-256 of the lines of answers, without times.
fn sha256(answers: &[AnswerLine]) -> String {
    let mut hash = Sha256::new();
    for said in answers {
        hash.update(said.line());
        hash.update("\n");
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_diagnose::finding::Decision;

    fn measured() -> (Vec<KnownLoop>, Results) {
        let suite = Suite::by_name("v1-trial", None).unwrap();
        let asked: Vec<KnownLoop> =
            (0..suite.len()).map(|k| suite.known(k).unwrap().asked).collect();
        let answers = |shift: usize| -> Vec<Answer> {
            let of = |k: usize| match k % 9 {
                8 => Answer::none("too short", 0.25),
                _ => Answer {
                    score: Some(((k + shift) * 31 % 17) as f64),
                    decision: Decision::Sticks,
                    failure: None,
                    ..Answer::none("", 0.5)
                },
            };
            (0..asked.len()).map(of).collect()
        };
        let named = |name: &str| Detector {
            name: name.to_owned(),
            version: String::new(),
            command: "a command".to_owned(),
        };
        let entries = vec![(named("one"), answers(0)), (named("two"), answers(5))];
        let results = Results::of("stiction", Loops::of(&suite), &asked, entries);
        (asked, results)
    }

    #[test]
    fn results_are_verified_and_changes_are_noticed() {
        let (asked, results) = measured();
        assert_eq!((results.entries.len(), results.comparisons.len()), (2, 1));
        let text = results.json();
        let read = Submitted::read(&text).unwrap();
        let again = |read: &Submitted| {
            let answers = read.answers(&asked).unwrap();
            Results::of("stiction", results.loops.clone(), &asked, answers)
        };
        assert_eq!(read.faults(&again(&read)), Vec::<String>::new());
        assert_eq!(again(&read), results);

        let faults = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            let read = Submitted::read(&text.replacen(from, to, 1)).unwrap();
            let again = again(&read);
            read.faults(&again).join("; ")
        };
        let sticky = format!("\"sticky\": {}", results.entries[0].measures.sticky);
        assert!(faults(&sticky, "\"sticky\": 999").contains("one: measures.sticky"));
        assert!(faults("\"score\": 14.0", "\"score\": 15.0").contains("SHA-256"));
        assert!(faults("\"a command\"", "\"\"").contains("the command is missing"));
        assert!(faults("\"population\": 5", "\"population\": 4").contains("are of population 4"));

        let mut fewer = read.clone();
        fewer.entries[1].answers.pop();
        assert!(fewer.answers(&asked).unwrap_err().contains("two has 119 answers"));
        fewer.entries[1].answers.push(read.entries[1].answers[0].clone());
        assert!(fewer.answers(&asked).unwrap_err().contains("is where v1-trial-00119 belongs"));
        for (text, wanted) in [
            ("[", "is not JSON"),
            ("{}", "no results"),
            (r#"{"version": 7}"#, "version 7"),
            (r#"{"version": 1, "loops": 3}"#, "no results"),
        ] {
            assert!(Submitted::read(text).unwrap_err().contains(wanted), "{text}");
        }
    }

    #[test]
    fn labels_are_truth_that_shows() {
        let label = |sticks| Label {
            id: "a".to_owned(),
            valve: "v".to_owned(),
            sticks,
            source: String::new(),
            licence: String::new(),
        };
        let sticking = label(true).known_loop();
        assert!(sticking.counts() && sticking.truth.visible);
        assert!(label(false).known_loop().counts());
        assert_eq!(Loops::labelled(vec![label(true)]).title(), "1 labelled recordings");
    }
}
