//! What one page says must not contradict itself: rules over all words of the reports on loops of the population, and on
//! real recordings where they are at hand; the same for pages of histories and of valve tests.
//!
//! Rules that hold for the words of the command and of Python, too, are in `contradictions.json`, which their tests read.

use rayon::prelude::*;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;
use stiction_diagnose::diagnose::{
    DiagnoseOptions, Diagnosis, Grade, VerdictClass, combine, diagnose,
};
use stiction_diagnose::recording::{GridOptions, PlantTime, Recording};
use stiction_diagnose::spoken::{self, percent, range};
use stiction_diagnose::valve_test;
use stiction_io::ReadOptions;
use stiction_io::reading::read;
use stiction_population::member;
use stiction_report::document::{Loop, Point, Source, Valve, ValveHistory};
use stiction_report::report::{Fitted, history_html, html};
use stiction_report::valve_test_page::{self, Signed, Tested};

/// Rules that are shared with other tests.
#[derive(Deserialize)]
struct Shared {
    /// Slips of the pen.
    never: Vec<String>,
    /// Words that never follow the number one.
    plural: Vec<String>,
    /// The grades for which an action begins so.
    actions: BTreeMap<String, Vec<String>>,
    /// The least and the largest probability of a grade, percent.
    probability: BTreeMap<String, [f64; 2]>,
    /// No ratio to the present loop is larger.
    largest_factor: f64,
}

static SHARED: LazyLock<Shared> =
    LazyLock::new(|| serde_json::from_str(include_str!("contradictions.json")).unwrap());

impl Shared {
    fn is_slip(&self, text: &str) -> bool {
        let words: Vec<&str> = text.split_whitespace().collect();
        let one = words.windows(2).any(|w| w[0] == "1" && self.plural.iter().any(|p| p == w[1]));
        one || self.never.iter().any(|never| text.contains(never.as_str()))
    }

    /// Whether a grade and a probability in words do not agree.
    fn disagree(&self, grade: &str, probability: &str) -> bool {
        let number = |text: &str| text.split(' ').find_map(|word| word.parse::<f64>().ok());
        match (self.probability.get(grade), number(probability)) {
            (Some([low, high]), Some(p)) => !(*low..=*high).contains(&p),
            _ => false,
        }
    }
}

/// Loops on which no word was chosen.
const SEED: u64 = 20_261_226;

/// A loop, and the words of its page.
struct Page {
    name: String,
    diagnosis: Diagnosis,
    /// Texts of the page between two tags, in order; figures left out but for their labels.
    texts: Vec<String>,
}

impl Page {
    fn of(name: String, diagnosis: Diagnosis) -> Self {
        let source = Source { file: format!("{name}.csv"), sha256: String::new() };
        let fitted = Fitted::of_accused(&diagnosis);
        let page = html("tool", &[Loop::new(&source, &diagnosis).with_fit(&fitted)]).unwrap();
        let texts = texts(&page);
        Self { name, diagnosis, texts }
    }
}

/// The texts of a page between its tags, without those of figures, scripts and styles.
fn texts(page: &str) -> Vec<String> {
    let mut texts = vec![];
    let mut skipped: Option<&str> = None;
    for piece in page.split('<') {
        let (tag, text) = piece.split_once('>').unwrap_or((piece, ""));
        let name = tag.split_whitespace().next().unwrap_or("");
        match skipped {
            Some(until) if name.strip_prefix('/') == Some(until) => skipped = None,
            Some(_) => continue,
            None => {
                skipped = ["svg", "script", "style"].into_iter().find(|each| *each == name);
                if skipped.is_some() {
                    continue;
                }
            }
        }
        let text = text
            .replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&amp;", "&")
            .replace("&quot;", "\"");
        let text = text.replace('\u{a0}', " ");
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if !text.is_empty() {
            texts.push(text);
        }
    }
    texts
}

fn of_population(loops: std::ops::Range<u64>) -> impl ParallelIterator<Item = Page> {
    loops.into_par_iter().map(|k| {
        let simulated = member(SEED, k).unwrap();
        let diagnosis = diagnose(&simulated.recording, &DiagnoseOptions::default()).unwrap();
        Page::of(format!("{}-{k}", simulated.truth.kind.name()), diagnosis)
    })
}

/// What a page may not say, and of which pages it is asked: a name, and what is wrong with a page, if anything is.
type Rule = (&'static str, fn(&Page) -> Option<String>);

const RULES: [Rule; 19] = [
    ("slips of the pen", |page| page.find(|text| SHARED.is_slip(text))),
    ("no factor is absurd", |page| {
        // After the action of a row come its two factors, then other ranges.
        let from = page.texts.iter().position(|text| text == "benefit")? + 1;
        let mut place = 0;
        page.texts[from..].iter().take_while(|text| text.len() < 40).find_map(|text| {
            place = if text.contains(" to ") { place + 1 } else { 0 };
            let mut numbers = text.split(' ').filter_map(|word| word.parse::<f64>().ok());
            let is_absurd = numbers.any(|number| number > SHARED.largest_factor);
            ((1..=2).contains(&place) && is_absurd).then(|| text.clone())
        })
    }),
    ("no size of stiction is larger than the span", |page| {
        let mut rows = page.texts.windows(2);
        rows.find_map(|row| {
            let mut numbers = row[1].split([' ', '(', ')']).filter_map(|w| w.parse::<f64>().ok());
            (row[0] == "valve" && numbers.any(|number| number > 100.0)).then(|| row.join(" "))
        })
    }),
    ("a grade and the sentence on it agree", |page| {
        let verdict = &page.diagnosis.verdict;
        let wanted: &[&str] = match verdict.grade {
            Grade::Sticks => &["The valve most likely sticks", "shows that the valve sticks"],
            Grade::ProbablySticks => &["The valve probably sticks", "indicate a sticking valve"],
            Grade::Unclear => &[
                "is unclear",
                "leaves open whether the valve sticks",
                "compatible",
                "does not look like",
            ],
            Grade::ProbablyFine => &["probably fine", "indicate that the valve does not stick"],
            Grade::NoneVisible => &["No stiction is visible"],
            Grade::TooLittle => &["sticks too little to matter"],
            Grade::Fine => &["most likely does not stick", "follows the controller"],
            Grade::DoesNotRespond => &["does not respond"],
            Grade::CannotAnswer => &["cannot answer", "are probably wrong", "is unclear"],
        };
        let all = [
            "The valve most likely sticks",
            "The valve probably sticks",
            "is probably fine",
            "No stiction is visible",
            "sticks too little to matter",
            "most likely does not stick",
        ];
        let wrong =
            all.iter().find(|said| !wanted.iter().any(|w| said.contains(w)) && page.says(said));
        match wanted.iter().any(|said| page.says(said)) {
            true => wrong.map(|said| format!("{}, and: {said}", verdict.grade)),
            false => Some(format!("{}: none of {wanted:?}", verdict.grade)),
        }
    }),
    ("one probability", |page| {
        let p = percent(page.diagnosis.verdict.probability?);
        let said = page.texts.iter().find_map(|text| text.strip_prefix("sticks: "))?;
        (said != p).then(|| format!("{said} and {p}"))
    }),
    ("a probability is shown on the page as in the table", |page| {
        let shown = page.texts.iter().any(|text| text.starts_with("sticks: "));
        let wanted = page.diagnosis.verdict.shown_probability().is_some();
        (shown != wanted).then(|| format!("shown {shown}, in the table {wanted}"))
    }),
    ("data that cannot answer are not called fit", |page| {
        (page.diagnosis.verdict.grade == Grade::CannotAnswer && page.starts("Data: fit"))
            .then(|| page.find(|text| text == "Data: fit"))?
    }),
    ("evidence agrees with its probability", |page| {
        page.find(|text| {
            let Some((_, rest)) = text.split_once(" alone: ") else { return false };
            let Some((p, because)) = rest.split_once(" % (") else { return false };
            let Ok(p) = p.trim_start_matches(|c: char| !c.is_ascii_digit()).parse::<f64>() else {
                return false;
            };
            let agrees = because.split("although").next().unwrap_or(because);
            (p >= 55.0 && agrees.contains("closer to sines"))
                || (p <= 45.0 && agrees.contains("closer to triangles"))
        })
    }),
    ("a cause that is ruled out first is likely", |page| {
        let first = page.diagnosis.verdict.alternatives.first()?;
        (first.likelihood < 0.2).then(|| page.find(|text| text.starts_with("First rule out")))?
    }),
    ("what is to be done fits the grade", |page| {
        let grade = page.diagnosis.verdict.grade.name();
        let mut wrong = SHARED.actions.iter().filter(|(_, of)| !of.iter().any(|g| g == grade));
        wrong.find(|(said, _)| page.starts(said)).map(|(said, _)| format!("{grade}: {said}"))
    }),
    ("a repair is told with what the fit says", |page| {
        let not = page.find(|text| text.contains("valve does not explain the swing"))?;
        let repair = page.starts("If confirmed,") && !page.starts("Look upstream, too");
        repair.then_some(not)
    }),
    ("who is cleared is not explained by the valve", |page| {
        page.diagnosis
            .verdict
            .grade
            .spares()
            .then(|| page.find(|text| text.contains("valve explains the swing")))?
    }),
    ("ten cycles are not asked of who has them", |page| {
        let (_, found) = page.diagnosis.oscillation()?;
        (found.found && found.cycles? >= 10.0)
            .then(|| page.find(|text| text.contains("at least ten cycles")))?
    }),
    ("a cycle that is not found is not told", |page| {
        page.find(|text| text.contains("no regular cycle was found"))?;
        page.starts("±").then(|| "a swing, and no cycle".to_owned())
    }),
    ("a recorded position is not asked for", |page| {
        page.diagnosis.segment()?.vp.as_ref()?;
        page.find(|text| {
            text.contains("a recorded valve position") || text.contains("ecord the valve position")
        })
    }),
    ("a set point that is not recorded says nothing", |page| {
        page.diagnosis
            .segment()?
            .sp
            .is_none()
            .then(|| page.find(|text| text.contains("set point moves in")))?
    }),
    ("a limit is one number, and none beside an S", |page| {
        let verdict = &page.diagnosis.verdict;
        if let (Some(_), Some(limit)) = (page.diagnosis.stiction.s, verdict.s_below) {
            return Some(format!("S, and a limit of {}", limit.value));
        }
        let mut said: Vec<&str> = page
            .texts
            .iter()
            .filter_map(|text| {
                text.split_once("Stiction with S above ")?
                    .1
                    .split_once(" %")
                    .map(|(limit, _)| limit)
            })
            .collect();
        said.dedup();
        (said.len() > 1).then(|| format!("{said:?}"))
    }),
    ("the test is one test", |page| {
        let test = page.diagnosis.verdict.confirm.as_ref()?;
        let (whole, limits) = (spoken::time(test.total_s), range(test.pv_low, test.pv_high));
        page.find(|text| text.starts_with("Test the valve in manual,") && !text.contains(&whole))
            .or_else(|| {
                page.find(|text| text.contains("for part 1, or less") && !text.contains(&whole))
            })
            .or_else(|| {
                page.find(|text| {
                    text.contains("in automatic if the PV leaves") && !text.contains(&limits)
                })
            })
    }),
    ("a test that cannot be made is not asked for", |page| {
        page.diagnosis.verdict.no_test.as_ref()?;
        page.starts("Test the valve in manual,")
            .then(|| "a test, and none can be planned".to_owned())
    }),
];

impl Page {
    fn find(&self, wrong: impl Fn(&str) -> bool) -> Option<String> {
        self.texts.iter().find(|text| wrong(text)).cloned()
    }

    fn says(&self, wanted: &str) -> bool {
        self.texts.iter().any(|text| text.contains(wanted))
    }

    fn starts(&self, wanted: &str) -> bool {
        self.texts.iter().any(|text| text.starts_with(wanted))
    }

    /// What is wrong with it, by the rules.
    fn contradictions(&self) -> impl Iterator<Item = String> {
        RULES.iter().filter_map(|(name, wrong)| {
            wrong(self).map(|what| format!("{}: {name}: {what}", self.name))
        })
    }
}

fn walk(pages: impl ParallelIterator<Item = Page>) {
    let found: Vec<String> =
        pages.flat_map_iter(|page| page.contradictions().collect::<Vec<_>>()).collect();
    assert!(found.is_empty(), "{} contradictions:\n{}", found.len(), found.join("\n"));
}

#[test]
fn pages_do_not_contradict_themselves() {
    walk(of_population(0..120));
}

#[test]
#[ignore = "5,000 loops, minutes"]
fn no_page_of_the_population_contradicts_itself() {
    walk(of_population(120..5_120));
}

#[test]
fn no_page_of_a_real_recording_contradicts_itself() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let mut files = vec![];
    for folder in ["isdb", "plant", "damadics", "week"] {
        let Ok(entries) = std::fs::read_dir(data.join(folder)) else {
            println!("skipped: there are no real recordings beside the project");
            return;
        };
        files.extend(entries.filter_map(|entry| Some(entry.ok()?.path())));
    }
    files.retain(|path| {
        path.extension().is_some_and(|e| e == "csv")
            && path.file_stem().is_some_and(|s| s != "index")
    });
    walk(files.into_par_iter().flat_map_iter(|path| {
        let reading = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        reading.recordings.into_iter().map(|recording| {
            let diagnosis = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
            Page::of(recording.name.clone(), diagnosis)
        })
    }));
}

/// The contradictions of the history of a recording in three windows.
fn of_history(recording: &Recording) -> Vec<String> {
    let end = recording.op.time.last().copied().unwrap_or(0.0);
    let part = |k: usize| {
        let (from, to) = (end * k as f64 / 3.0, end * (k + 1) as f64 / 3.0);
        let part = recording.part(from, to, f64::INFINITY)?;
        Some((from, diagnose(&part, &DiagnoseOptions::default()).ok()?))
    };
    let windows: Vec<(f64, Diagnosis)> = (0..3).filter_map(part).collect();
    let seen: Vec<_> = windows.iter().filter_map(|(from, of)| of.observation(*from)).collect();
    let Ok(combined) = combine(&seen) else { return vec![] };
    let points = windows.iter().map(|(from, of)| Point::new(of, "a.csv", *from, end / 3.0));
    let valve = Valve {
        name: recording.name.clone(),
        sources: vec![],
        dated: false,
        plant_time: PlantTime::default(),
        windows: points.collect(),
        combined: combined.clone(),
        repair: None,
    };
    let texts = texts(&history_html(&ValveHistory::new("tool", vec![valve])).unwrap());
    let mut wrong: Vec<String> =
        texts.iter().filter(|text| SHARED.is_slip(text)).cloned().collect();
    // Duration, verdict and probability stand side by side in the table.
    for row in texts.windows(2) {
        let grade = row[0].split_once('\u{a0}').map_or("", |(_, grade)| grade);
        let grade = grade.replace('\u{a0}', " ");
        let grade =
            if grade.is_empty() { row[0].split_once(' ').map_or("", |w| w.1) } else { &grade };
        if row[1].ends_with('%') && SHARED.disagree(grade, &row[1]) {
            wrong.push(format!("a window: {}", row.join(", ")));
        }
        if grade == Grade::CannotAnswer.name() && row[1].ends_with('%') {
            wrong.push(format!("a probability that the report hides: {}", row.join(", ")));
        }
    }
    if let Some(p) = combined.probability {
        let p = percent(p);
        if SHARED.disagree(combined.grade.name(), &p) {
            wrong.push(format!("together {} and {p}", combined.grade));
        }
        if !texts.iter().any(|text| text.ends_with(&format!("probability of sticking of {p}."))) {
            wrong.push(format!("the headline does not say {p}"));
        }
    }
    wrong
}

#[test]
fn no_history_contradicts_itself() {
    let found: Vec<String> = (200..260_u64)
        .into_par_iter()
        .flat_map_iter(|k| {
            let simulated = member(SEED, k).unwrap();
            let name = format!("{}-{k}", simulated.truth.kind.name());
            of_history(&simulated.recording).into_iter().map(move |what| format!("{name}: {what}"))
        })
        .collect();
    assert!(found.is_empty(), "{} contradictions:\n{}", found.len(), found.join("\n"));
}

#[test]
fn no_page_of_a_valve_test_contradicts_itself() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/test");
    let mut pages = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "csv") {
            continue;
        }
        let reading = read(&path, &ReadOptions::default()).unwrap();
        let recording = &reading.recordings[0];
        let source = Source { file: "a.csv".to_owned(), sha256: String::new() };
        if let Ok(signature) = valve_test::signature(recording, &GridOptions::default()) {
            let signed = Signed { source: &source, recording, signature: &signature };
            let texts = texts(&valve_test_page::signature("tool", signed).unwrap());
            let slips: Vec<&String> = texts.iter().filter(|text| SHARED.is_slip(text)).collect();
            assert!(slips.is_empty(), "{}: {slips:?}", path.display());
            let sticks = texts.iter().any(|text| text.contains("The valve sticks"));
            assert_eq!(sticks, signature.class == VerdictClass::Sticks, "{}", path.display());
            continue;
        }
        let test = valve_test::read(recording, &valve_test::ReadOptions::default()).unwrap();
        let tested = Tested { source: &source, recording, test: &test };
        let texts = texts(&valve_test_page::reading("tool", tested).unwrap());
        let says = |wanted: &str| texts.iter().any(|text| text.contains(wanted));
        let slips: Vec<&String> = texts.iter().filter(|text| SHARED.is_slip(text)).collect();
        assert!(slips.is_empty(), "{}: {slips:?}", path.display());
        let headlines = [
            (VerdictClass::Sticks, "The valve sticks."),
            (VerdictClass::DoesNotStick, "The valve does not stick."),
            (VerdictClass::DoesNotRespond, "The valve does not respond"),
            (VerdictClass::CannotTell, "The test is inconclusive."),
        ];
        for (class, headline) in headlines {
            assert_eq!(says(headline), class == test.class, "{}: {headline}", path.display());
        }
        let p = percent(test.probability);
        assert!(says(&p), "{}: {p}", path.display());
        let agrees = match test.class {
            VerdictClass::Sticks => test.probability > 0.5 && test.s_below.is_none(),
            VerdictClass::DoesNotStick => test.probability < 0.5,
            _ => true,
        };
        assert!(agrees, "{}: {} and {p}", path.display(), test.class);
        let answered = test.steps.iter().filter(|step| step.answered).count();
        let cells = texts.iter().filter(|text| *text == "yes").count();
        assert_eq!(cells, answered, "{}: turns answered", path.display());
        pages += 1;
    }
    assert!(pages >= 3, "{pages}");
}
