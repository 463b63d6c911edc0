//! What one page says must not contradict itself: rules over all words of the reports on loops of the population, and on
//! real recordings where they are at hand.

use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use stiction_diagnose::diagnose::{DiagnoseOptions, Diagnosis, Grade, diagnose};
use stiction_diagnose::spoken::{self, percent, range};
use stiction_io::ReadOptions;
use stiction_io::reading::read;
use stiction_population::member;
use stiction_report::document::{Loop, Source};
use stiction_report::report::html;

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
        let page = html("tool", &[Loop { source: &source, diagnosis: &diagnosis }]).unwrap();
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

const RULES: [Rule; 18] = [
    ("slips of the pen", |page| {
        const NEVER: [&str; 10] = [
            "unknown share",
            "NaN",
            "inf ",
            "-0 %",
            "\u{2212}0 %",
            " a analysis",
            "..",
            "  ",
            "cannot be told: what",
            "nothing cycles",
        ];
        let one = |text: &str| {
            let words: Vec<&str> = text.split_whitespace().collect();
            words.windows(2).any(|w| w[0] == "1" && ["samples", "slips", "steps"].contains(&w[1]))
        };
        page.find(|text| one(text) || NEVER.iter().any(|never| text.contains(never)))
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
            Grade::Fine => &["most likely does not stick", "follows the controller"],
            Grade::DoesNotRespond => &["does not respond"],
            Grade::CannotAnswer => &["cannot answer", "are probably wrong", "is unclear"],
        };
        let all = [
            "The valve most likely sticks",
            "The valve probably sticks",
            "is probably fine",
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
        use Grade::*;
        let grade = page.diagnosis.verdict.grade;
        let only = [
            ("Leave the valve alone", &[Fine, ProbablyFine][..]),
            ("Test the valve", &[Sticks, ProbablySticks, Unclear]),
            ("If confirmed,", &[Sticks, ProbablySticks]),
            ("Check the possible faults", &[DoesNotRespond]),
        ];
        let wrong = only.iter().find(|(said, of)| !of.contains(&grade) && page.starts(said));
        wrong.map(|(said, _)| format!("{grade}: {said}"))
    }),
    ("a repair is told with what the fit says", |page| {
        let not = page.find(|text| text.contains("valve does not explain the swing"))?;
        let repair = page.starts("If confirmed,") && !page.starts("Look upstream, too");
        repair.then_some(not)
    }),
    ("who is cleared is not explained by the valve", |page| {
        matches!(page.diagnosis.verdict.grade, Grade::Fine | Grade::ProbablyFine)
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
        page.find(|text| text.starts_with("Test the valve:") && !text.contains(&test.summary))
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
        page.starts("Test the valve:").then(|| "a test, and none can be planned".to_owned())
    }),
    ("a missing length is one length", |page| {
        let few = page.diagnosis.few_slips.as_ref()?;
        let time = spoken::time(few.record_for_s?);
        page.find(|text| {
            text.contains("A recording ")
                && text.contains(" longer, OP steps")
                && !text.contains(&time)
        })
        .or_else(|| page.find(|text| text.contains("looks stuck") && !text.contains(&time)))
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

/// A text without its numbers.
fn form(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '0'..='9' => {
                if !out.ends_with('#') {
                    out.push('#');
                }
            }
            '.' if out.ends_with('#') => {}
            _ => out.push(c),
        }
    }
    out
}

#[test]
#[ignore = "prints, minutes"]
fn table_of_sentences() {
    let number = std::env::var("LOOPS").ok().and_then(|n| n.parse().ok()).unwrap_or(500);
    let pages: Vec<Page> = of_population(0..number).collect();
    let mut forms: BTreeMap<String, (usize, String, String)> = BTreeMap::new();
    for page in &pages {
        for text in &page.texts {
            for sentence in text.split(". ") {
                let entry = forms.entry(form(sentence)).or_insert((
                    0,
                    page.name.clone(),
                    sentence.to_owned(),
                ));
                entry.0 += 1;
            }
        }
    }
    for (number, name, text) in forms.values() {
        println!("{number:6} {name}: {text}");
    }
}
