//! Files as historians export them, of many kinds: each is read rightly, or refused with a remedy that works.
//!
//! * `cases`: files that were once read wrongly, with their right values;
//! * `kinds`: further files of the same kinds, made from one loop;
//! * `historians`: files in the styles of twelve systems;
//! * `mutations`, `sentinels`, `forms`: many files in process. `STICTION_LOOPS` and `STICTION_FILES` are their numbers.

mod cases;
mod forms;
mod historians;
mod in_process;
mod kinds;
mod mutations;
mod sentinels;

use super::{Done, folder, run, write};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::OnceLock;

const FIXTURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/reading");

/// The number that the environment variable `name` holds, or `usual`.
fn count(name: &str, usual: usize) -> usize {
    std::env::var(name).map_or(usual, |text| text.parse().expect("a number"))
}

/// The signals of a loop whose valve sticks, S = 4 % and J = 2 %, one sample a second.
struct Base {
    pv: Vec<f64>,
    sp: Vec<f64>,
    op: Vec<f64>,
}

/// Its first twenty minutes.
const N: usize = 1200;

fn base() -> &'static Base {
    static BASE: OnceLock<Base> = OnceLock::new();
    BASE.get_or_init(|| {
        let text = include_str!("../../../../samples/FIC101-sticky.csv");
        let column = |index: usize| {
            let cell = |line: &str| line.split(',').nth(index)?.parse().ok();
            text.lines().skip(1).take(N).map(|line| cell(line).expect("a number")).collect()
        };
        Base { sp: column(1), pv: column(2), op: column(3) }
    })
}

/// The numbers of sample `k`, in the order PV, SP, OP.
fn at(k: usize) -> [f64; 3] {
    let base = base();
    [base.pv[k], base.sp[k], base.op[k]]
}

/// The time of day, with its date, that many seconds after six in the morning of 14 March 2025.
fn clock(pattern: &str, seconds: f64) -> String {
    clock_from(jiff::civil::date(2025, 3, 14).at(6, 0, 0, 0), pattern, seconds)
}

fn clock_from(start: jiff::civil::DateTime, pattern: &str, seconds: f64) -> String {
    let span = jiff::SignedDuration::from_millis((seconds * 1000.0).round() as i64);
    start.checked_add(span).expect("a time").strftime(pattern).to_string()
}

/// A number with a decimal comma.
fn comma(value: f64, digits: usize) -> String {
    format!("{value:.digits$}").replace('.', ",")
}

/// A number with its thousands marked.
fn grouped(value: f64, digits: usize, group: &str, mark: &str) -> String {
    let text = format!("{value:.digits$}");
    let (whole, part) = text.split_once('.').unwrap_or((&text, ""));
    let mut marked = String::new();
    for (index, digit) in whole.chars().enumerate() {
        if index > 0 && (whole.len() - index) % 3 == 0 {
            marked += group;
        }
        marked.push(digit);
    }
    if part.is_empty() { marked } else { marked + mark + part }
}

/// The lines above, then one or more lines of every sample.
fn lines(above: &str, mut line: impl FnMut(usize) -> String) -> String {
    let mut text = above.to_owned();
    for k in 0..N {
        text += &line(k);
    }
    text
}

/// What the command made of the files.
#[derive(Debug, Clone, PartialEq)]
struct Seen {
    /// The verdict in one word.
    grade: String,
    class: String,
    probability: Option<f64>,
    /// S with its interval.
    s: Option<[f64; 3]>,
    /// Number of judged samples.
    judged: usize,
    /// The judged duration, s.
    duration_s: f64,
    /// Number of samples of each signal, good or not, of `inspect`; empty for several files.
    samples: Vec<(String, usize, usize)>,
    /// The least and the largest PV.
    pv: (f64, f64),
    /// All words beside the verdict and in `inspect`.
    said: String,
    /// The one line of `--brief`.
    brief: String,
}

/// Runs `diagnose` and `inspect` on the files, or gives the message of the refusal.
fn look(folder: &Path, files: &[&str], options: &[String]) -> Result<Seen, String> {
    let of = |command: &[&str]| -> Result<Done, String> {
        let options = options.iter().map(String::as_str);
        let arguments: Vec<&str> =
            command.iter().copied().chain(files.iter().copied()).chain(options).collect();
        let done = run(folder, &arguments);
        match done.code {
            0 => Ok(done),
            2 => Err(done.err),
            code => panic!("{files:?}: exit code {code}: {}", done.err),
        }
    };
    let diagnosed = of(&["diagnose", "--json"])?;
    let brief = of(&["diagnose", "--brief"])?;
    // Parts of a loop may be no recordings of their own.
    let inspected = match of(&["inspect", "--json"]) {
        Err(_) if files.len() > 1 => None,
        done => Some(done?),
    };
    let json = |done: &Done| serde_json::from_str::<Value>(&done.out).expect("JSON");
    let (document, summary) = (json(&diagnosed), inspected.as_ref().map(json));
    let loops = document["loops"].as_array().expect("loops");
    let [found] = &loops[..] else {
        let names: Vec<_> = loops.iter().map(|each| each["loop"].to_string()).collect();
        return Err(format!("read as {} loops: {}", loops.len(), names.join(", ")));
    };
    let s = &found["stiction"]["S"];
    let verdict = &found["verdict"];
    let mut said = String::new();
    for what in ["notes", "repairs", "masked"] {
        if !found[what].is_null() && found[what] != serde_json::json!([]) {
            let _ = writeln!(said, "{what}: {}", found[what]);
        }
    }
    let _ = writeln!(said, "fitness: {}", found["fitness"]["reasons"]);
    let (mut samples, mut pv) = (vec![], (f64::NAN, f64::NAN));
    for file in summary.iter().flat_map(|summary| summary["files"].as_array().expect("files")) {
        let _ = writeln!(said, "inspect: {}", file["notes"]);
        for each in file["loops"].as_array().expect("loops") {
            let _ = writeln!(said, "inspect: {}", each["notes"]);
            for (name, signal) in each["signals"].as_object().expect("signals") {
                let all = signal["samples"].as_u64().unwrap_or(0) as usize;
                let good = signal["quality"]["good"].as_u64().unwrap_or(0) as usize;
                samples.push((name.clone(), all, good));
                if signal["masked"].as_array().is_some_and(|masked| !masked.is_empty()) {
                    let _ = writeln!(said, "inspect: masked {}", signal["masked"]);
                }
                if name == "pv" {
                    let end = |end: &str| signal[end].as_f64().unwrap_or(f64::NAN);
                    pv = (pv.0.min(end("lowest")), pv.1.max(end("highest")));
                }
            }
        }
    }
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    Ok(Seen {
        grade: text(&verdict["grade"]),
        class: text(&verdict["class"]),
        probability: verdict["probability"].as_f64(),
        s: s["value"].as_f64().map(|value| {
            let end = |name: &str| s[name].as_f64().expect("an end");
            [value, end("low"), end("high")]
        }),
        judged: found["judged"]["samples"].as_u64().unwrap_or(0) as usize,
        duration_s: found["judged"]["duration_s"].as_f64().unwrap_or(0.0),
        samples,
        pv,
        said,
        brief: brief.out + &brief.err,
    })
}

impl std::fmt::Display for Seen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { grade, probability, s, judged, duration_s, samples, pv, .. } = self;
        let s = s.map_or("none".to_owned(), |[s, a, b]| format!("{s:.2} ({a:.2} to {b:.2})"));
        let p = probability.map_or("none".to_owned(), |p| format!("{:.0} %", 100.0 * p));
        write!(
            f,
            "{grade}, {p}, S {s}, {judged} samples judged, {duration_s} s; PV {pv:?}; {samples:?}\n{}",
            self.said
        )
    }
}

/// The right reading of files.
#[derive(Clone)]
struct Right {
    /// Verdicts, one of which is right.
    grades: &'static [&'static str],
    /// The least and the most probability.
    probability: (f64, f64),
    /// The number of judged samples, from and to.
    judged: (usize, usize),
    /// The time between samples, s.
    step: f64,
    /// Ends between which the interval of S must reach, and that hold its value; `None` if S is no matter.
    s: Option<(f64, f64)>,
    /// Words of which one must stand in the notes of `diagnose`, `inspect` or the line of `--brief`.
    said: &'static [&'static str],
    /// Ends between which the PV must be.
    pv: (f64, f64),
    /// Files with a range that is guessed: words beside S, or no S; its interval must hold this.
    holds: Option<f64>,
}

/// The base loop in any dress.
const STICKS: Right = Right {
    grades: &["sticks"],
    probability: (0.9, 1.0),
    judged: (N, N),
    step: 1.0,
    s: Some((3.3, 4.6)),
    said: &[],
    pv: (f64::NEG_INFINITY, f64::INFINITY),
    holds: None,
};

impl Right {
    /// What is wrong with a reading.
    fn faults(&self, seen: &Seen) -> Vec<String> {
        let mut faults = vec![];
        if !self.grades.contains(&&*seen.grade) {
            faults.push(format!(
                "the verdict is \"{}\", expected one of {:?}",
                seen.grade, self.grades
            ));
        }
        let (least, most) = self.probability;
        if !seen.probability.is_none_or(|p| (least..=most).contains(&p)) {
            faults.push(format!(
                "the probability is {:?}, expected {least} to {most}",
                seen.probability
            ));
        }
        let (from, to) = self.judged;
        if !(from..=to).contains(&seen.judged) {
            faults.push(format!("{} samples are judged, expected {from} to {to}", seen.judged));
        }
        let step = seen.duration_s / seen.judged.max(1) as f64;
        if (step - self.step).abs() > 0.02 * self.step {
            faults.push(format!("the sample time is {step}, expected {}", self.step));
        }
        match (self.s, self.holds, seen.s) {
            (Some((low, high)), None, Some([s, a, b]))
                if !(low..=high).contains(&s) || a > high || b < low =>
            {
                faults.push(format!("S is {s:.2} ({a:.2} to {b:.2}), expected {low} to {high}"));
            }
            (Some((low, high)), None, None) => {
                faults.push(format!("S is missing, expected {low} to {high}"));
            }
            (_, Some(truth), Some([s, a, b])) if !(a..=b).contains(&truth) => {
                faults.push(format!("S is {s:.2} ({a:.2} to {b:.2}), which does not hold {truth}"));
            }
            (_, Some(truth), Some([s, ..]))
                if (s - truth).abs() > 0.1 * truth && !seen.brief.contains("range") =>
            {
                faults.push(format!("S is {s:.2}, and --brief does not name the range"));
            }
            _ => {}
        }
        if seen.pv.0 < self.pv.0 || seen.pv.1 > self.pv.1 {
            faults.push(format!("the PV is {:?}, expected {:?}", seen.pv, self.pv));
        }
        let words = format!("{} {}", seen.said, seen.brief).to_lowercase();
        if !self.said.is_empty() && !self.said.iter().any(|word| words.contains(word)) {
            faults.push(format!("no note has a word of {:?}", self.said));
        }
        faults
    }
}

/// Files, how they are to be read, and what their user knows.
#[derive(Clone)]
struct Case {
    name: &'static str,
    files: Vec<(&'static str, Vec<u8>)>,
    options: &'static [&'static str],
    right: Right,
    /// Whether a refusal is right, too, provided that its advice works.
    may_refuse: bool,
    /// Whether a refusal must name an option that helps.
    advised: bool,
    /// What a message must contain if it is a refusal.
    message: &'static [&'static str],
    /// What the user would put for a placeholder: `op=COLUMN` is `op=OUT` here, `--op-range` is `--op-range=3,15`.
    known: &'static [&'static str],
}

/// A case of one file that is to be read as the base loop.
fn case(name: &'static str, file: &'static str, bytes: impl Into<Vec<u8>>) -> Case {
    Case {
        name,
        files: vec![(file, bytes.into())],
        options: &[],
        right: STICKS,
        may_refuse: false,
        advised: true,
        message: &[],
        known: &[],
    }
}

impl Case {
    fn right(mut self, change: impl FnOnce(&mut Right)) -> Self {
        change(&mut self.right);
        self
    }

    fn said(mut self, said: &'static [&'static str]) -> Self {
        self.right.said = said;
        self
    }

    fn or_refused(
        mut self,
        message: &'static [&'static str],
        known: &'static [&'static str],
    ) -> Self {
        self.may_refuse = true;
        self.message = message;
        self.known = known;
        self
    }

    /// A refusal need not name an option, because none can help.
    fn unadvised(mut self) -> Self {
        self.advised = false;
        self
    }

    fn file(mut self, name: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.push((name, bytes.into()));
        self
    }

    /// What is wrong with how the command treats the case, if anything.
    fn fault(&self, folder: &Path) -> Option<String> {
        for (name, bytes) in &self.files {
            write(folder, name, bytes);
        }
        let files: Vec<&str> = self.files.iter().map(|(name, _)| *name).collect();
        let options: Vec<String> = self.options.iter().map(|&option| option.to_owned()).collect();
        let judge = |seen: &Seen| match &self.right.faults(seen)[..] {
            [] => None,
            faults => Some(format!("{}\nread as: {seen}", faults.join("; "))),
        };
        let first = &self.files[0].1;
        let begin = String::from_utf8_lossy(&first[..first.len().min(200)]).into_owned();
        let fault = match look(folder, &files, &options) {
            Ok(seen) => judge(&seen)?,
            Err(message) => {
                let lacks: Vec<_> = self.message.iter().filter(|m| !message.contains(*m)).collect();
                let advice = advised(folder, &files, &options, &message, self.known, &judge);
                match (&lacks[..], advice) {
                    ([], advice) if self.may_refuse && (advice.is_ok() || !self.advised) => {
                        return None;
                    }
                    ([], advice) => {
                        let advice = match advice {
                            Ok(path) => format!("its advice works: {}", path.join(" ")),
                            Err(why) => format!("its advice does not work: {why}"),
                        };
                        format!("refused: {}; {advice}", message.trim())
                    }
                    (lacks, _) => format!("the message lacks {lacks:?}: {}", message.trim()),
                }
            }
        };
        Some(format!("== {} ({})\n{begin}...\n{fault}", self.name, files.join(", ")))
    }
}

/// All cases of a kind, in a folder each. All faults are reported together.
#[track_caller]
fn examine(kind: &str, cases: Vec<Case>) {
    let all = cases.len();
    let faults: Vec<String> = cases
        .iter()
        .enumerate()
        .filter_map(|(index, case)| case.fault(&folder(&format!("reading-{kind}-{index}"))))
        .collect();
    let wrong = faults.len();
    assert!(faults.is_empty(), "{kind}: {wrong} of {all} wrong\n{}\n", faults.join("\n"));
}

/// The options that a message proposes, each with its value; alternatives are options of their own.
fn proposed(message: &str) -> Vec<(String, String)> {
    let mut found = vec![];
    for part in message.split(" --").skip(1) {
        let end = part.find([' ', ',', ';', ':', ')']).unwrap_or(part.len());
        let option = part[..end].trim_end_matches(['.', '"', '`']);
        let mut rest = part[end..].strip_prefix(' ').unwrap_or_default();
        loop {
            let (value, after) = match rest.strip_prefix('"') {
                Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
                None => {
                    let end = rest.find([' ', ';', ')', '\n']).unwrap_or(rest.len());
                    (rest[..end].trim_end_matches([',', '.', '`', ':']), &rest[end..])
                }
            };
            found.push((format!("--{option}"), value.to_owned()));
            match after.trim_start_matches(',').strip_prefix(" or ") {
                Some(more) if !more.starts_with("give ") && !more.starts_with("name ") => {
                    rest = more
                }
                _ => break,
            }
        }
    }
    found
}

/// Follows the advice of a refusal to the letter until the files are read rightly. It gives the options that helped.
fn advised(
    folder: &Path,
    files: &[&str],
    options: &[String],
    message: &str,
    known: &[&str],
    judge: &dyn Fn(&Seen) -> Option<String>,
) -> Result<Vec<String>, String> {
    let mut seen = vec![];
    let mut tried = 0;
    let mut open = vec![(options.to_vec(), message.to_owned())];
    while let Some((options, message)) = open.pop() {
        for (option, value) in proposed(&message) {
            let is_open = value.ends_with("=COLUMN") || value.ends_with("=TAG");
            let role = value.split_once('=').filter(|_| is_open).map(|(role, _)| role);
            let of = |name: &str| {
                known.iter().find(|known| known.split_once('=').is_some_and(|(it, _)| it == name))
            };
            let value = match (of(&option), role.map(of)) {
                (Some(known), _) => known[option.len() + 1..].to_owned(),
                (None, Some(Some(known))) => (*known).to_owned(),
                (None, Some(None)) => continue,
                (None, None) => value,
            };
            let mut more = options.clone();
            more.push(option);
            if !value.is_empty() {
                more.push(value);
            }
            tried += 1;
            match look(folder, files, &more) {
                Ok(found) => match judge(&found) {
                    None => return Ok(more),
                    Some(fault) => seen.push(format!("{more:?}: {fault}")),
                },
                Err(again) if again == message => {
                    seen.push(format!("{more:?}: the same message again"));
                }
                Err(other) => {
                    seen.push(format!("{more:?}: {}", other.trim()));
                    if more.len() < 2 * 5 && tried < 30 && !other.contains("Usage:") {
                        open.push((more, other));
                    }
                }
            }
        }
    }
    Err(match seen.is_empty() {
        true => "the message proposes no option that can be followed".to_owned(),
        false => seen.join("\n"),
    })
}

#[test]
fn advice_is_found_in_messages() {
    let of = |message: &str| {
        let found = proposed(message);
        found.iter().map(|(o, v)| format!("{o}|{v}")).collect::<Vec<_>>().join(" ")
    };
    let message =
        "name it, as in --map time=COLUMN, or give the time between rows, as in --sample-time 1";
    assert_eq!(of(message), "--map|time=COLUMN --sample-time|1");
    assert_eq!(
        of("as in --time-format excel or seconds, or give the time"),
        "--time-format|excel --time-format|seconds"
    );
    assert_eq!(of("as in --map \"mode=Time 3\"; else"), "--map|mode=Time 3");
    assert_eq!(of("as in --time-format \"%d/%m %H\""), "--time-format|%d/%m %H");
}
