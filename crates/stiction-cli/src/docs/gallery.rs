//! The gallery, in which each case is simulated, read like a file of a plant, diagnosed, and compared with the truth.

use super::cases::{Case, Made};
use crate::{output, population, simulate};
use anyhow::{Context as _, Result};
use maud::{Markup, PreEscaped, html};
use std::fmt::Write as _;
use stiction::diagnose::{Basis, DiagnoseOptions, Diagnosis, Grade, diagnose};
use stiction::population::LoopKind;
use stiction::recording::LoopType;
use stiction_docs::{File, Page, contents};
use stiction_figure::Figure;
use stiction_io::ReadOptions;
use stiction_io::reading::parse;
use stiction_io::scenario::Scenario;
use stiction_report::document::{Loop, Source};
use stiction_report::report::views::{head_map, trends};
use stiction_report::report::{self, Badge, Context, Fitted, Small, small_trend};
use stiction_report::words::{interval, percent, rough, verdict};

/// Width of the trends on a card, px.
const CARD: f64 = 260.0;
/// Number of periods in the enlarged trend.
const SHOWN: f64 = 4.0;

/// A case with its results.
pub struct Shown {
    pub case: &'static Case,
    csv: String,
    source: Source,
    diagnosis: Diagnosis,
    truth: Truth,
}

/// The truth about a valve.
struct Truth {
    sticks: bool,
    responds: bool,
    s: f64,
    j: f64,
}

/// The quality of a verdict, given the truth.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Worth {
    Right,
    /// The verdict cleared the valve, and its true S is below the detection limit.
    WithinLimit,
    Open,
    Wrong,
}

impl Shown {
    /// Simulates a case, and diagnoses the recording that a plant would have stored.
    pub fn of(case: &'static Case) -> Result<Self> {
        let (csv, truth, kind) = match case.made {
            Made::Scenario { name, set, columns } => {
                let set: Vec<String> = set.iter().map(|&each| each.to_owned()).collect();
                let columns: Vec<String> = columns.split(',').map(str::to_owned).collect();
                let scenario = Scenario::open(name, &set)?;
                let csv = simulate::recorded(&scenario, &columns)?;
                (csv, Truth::of_scenario(&scenario)?, LoopType::by_name(case.loop_type)?)
            }
            Made::Population { kind, seed } => {
                let simulated = LoopKind::by_name(kind)?.simulate(seed)?;
                let truth = &simulated.truth;
                let truth = Truth {
                    sticks: truth.sticks,
                    responds: truth.kind != LoopKind::Stuck,
                    s: truth.s,
                    j: truth.j,
                };
                let csv = population::recorded(&simulated, false);
                (csv, truth, LoopType::by_name(case.loop_type)?)
            }
        };
        let mut options = ReadOptions::default();
        options.all.loop_type = Some(kind);
        let reading = parse(csv.as_bytes(), &format!("{}.csv", case.tag), &options)?;
        let recording = reading.recordings.first().context("the file has no loop")?;
        let source = Source { file: reading.origin.clone(), sha256: reading.sha256.clone() };
        let wanted = DiagnoseOptions { evidence: true, ..DiagnoseOptions::default() };
        let diagnosis = diagnose(recording, &wanted)?;
        Ok(Self { case, csv, source, diagnosis, truth })
    }

    /// The diagnosis for tables and reports.
    pub fn found(&self) -> Loop<'_> {
        Loop::new(&self.source, &self.diagnosis)
    }

    fn badge(&self) -> Markup {
        PreEscaped(Badge::from(self.diagnosis.verdict.grade).html())
    }

    fn worth(&self) -> Worth {
        let (verdict, truth) = (&self.diagnosis.verdict, &self.truth);
        let right = match verdict.grade {
            Grade::Sticks | Grade::ProbablySticks => truth.sticks && truth.responds,
            Grade::DoesNotRespond => !truth.responds,
            Grade::Fine | Grade::TooLittle | Grade::NoneVisible | Grade::ProbablyFine => {
                let hidden = verdict.s_below.is_some_and(|limit| truth.s < limit.value);
                if truth.sticks && hidden {
                    return Worth::WithinLimit;
                }
                !truth.sticks
            }
            Grade::Unclear | Grade::CannotAnswer => return Worth::Open,
        };
        if right { Worth::Right } else { Worth::Wrong }
    }

    /// S as reported, with its interval or its detection limit.
    fn s(&self) -> String {
        match (self.diagnosis.stiction.s, self.diagnosis.verdict.s_below) {
            (Some(s), _) => interval(s),
            (None, Some(limit)) => format!(
                "detection limit {} % ({:.0} %)",
                rough(limit.value),
                100.0 * limit.confidence
            ),
            (None, None) => "not reported".to_owned(),
        }
    }

    /// The probability that the valve sticks, in words.
    fn probability(&self) -> String {
        let verdict = &self.diagnosis.verdict;
        match (verdict.basis, verdict.probability.map(percent)) {
            (Basis::ValvePosition, _) => "none, because the position was measured".to_owned(),
            (_, None) => "not reported".to_owned(),
            (Basis::OpAlone, Some(told)) => format!("{told}, from the pattern of the OP alone"),
            (_, Some(told)) => told,
        }
    }

    /// Whether the true S lies in the reported interval.
    fn caught(&self) -> Option<bool> {
        let told =
            self.diagnosis.stiction.s.filter(|_| self.truth.sticks && self.truth.responds)?;
        Some((told.low..=told.high).contains(&self.truth.s))
    }

    fn card(&self) -> Markup {
        let [page, _, _] = self.names();
        html! {
            a.case href=(page) {
                h2 { (self.case.title) }
                @for signal in [Small::Pv, Small::Op] {
                    @if let Some(svg) = small_trend(&self.diagnosis, signal, CARD) { (PreEscaped(svg)) }
                }
                p { (self.badge()) " " (self.probability()) }
                p { "S: " (self.s()) "." }
                p.soft { "True: " (self.truth.words()) "." }
                p.soft { "The verdict is " (self.worth().word()) "." }
            }
        }
    }

    /// Names of the case's page, data file and report.
    fn names(&self) -> [String; 3] {
        let tag = self.case.tag;
        [
            format!("gallery/{tag}.html"),
            format!("gallery/{tag}.csv"),
            format!("gallery/{tag}-report.html"),
        ]
    }

    /// Page.
    pub fn page(&self) -> Result<Page> {
        let case = self.case;
        let verdict_told = verdict(&self.diagnosis);
        let facts = html! {
            dl.facts {
                div { dt { "Verdict" } dd { (self.badge()) } }
                div { dt { "Probability of sticking" } dd { (self.probability()) } }
                div { dt { "S (stick band plus dead band)" } dd { (self.s()) } }
                div { dt { "True" } dd { (self.truth.words()) } }
                div { dt { "Verdict is" } dd { (self.worth().word()) @if let Some(caught) = self.caught() {
                    @if caught { ", and the true S lies in the interval" } @else { ", but the true S lies outside the interval" }
                } } }
            }
        };
        let mut text = format!("# {}\n\n{}\n\n{}\n\n", case.title, case.look, facts.into_string());
        let tag = case.tag;
        for (name, figure) in self.figures() {
            let caption = &figure.caption;
            let image = html! {
                figure {
                    div.wide tabindex="0" { img src={ (tag) "-" (name) ".svg" } alt={ (tag) ": " (caption) }; }
                    figcaption { (caption) }
                }
            };
            let _ = writeln!(text, "{}\n", image.into_string());
        }
        let _ = write!(
            text,
            "> {verdict_told}\n\n## What this loop shows\n\n{}\n\n## Do it yourself\n\n```sh\n{}\n```\n\n\
             The [recording]({tag}.csv) and the [whole report]({tag}-report.html) are in this folder.\n",
            case.learn,
            self.commands(),
        );
        let [page, ..] = self.names();
        Ok(Page::new(page, case.title, text).under(contents::GALLERY))
    }

    /// The commands that make the recording and the report.
    fn commands(&self) -> String {
        let Case { tag, loop_type, .. } = self.case;
        let (make, file) = match self.case.made {
            Made::Scenario { name, set, columns } => {
                let set: Vec<String> =
                    set.iter().map(|each| format!(" --set {}", quoted(each))).collect();
                let set = set.concat();
                (
                    format!("stiction simulate {name}{set} --columns {columns} -o {tag}.csv"),
                    format!("{tag}.csv"),
                )
            }
            Made::Population { kind, seed } => (
                format!("stiction population --n 1 --seed {seed} --kind \"{kind}\" -o {tag}"),
                format!("{tag}/loop-0.csv"),
            ),
        };
        format!("{make}\nstiction diagnose {file} --type {loop_type} --report {tag}-report.html")
    }

    /// The whole record, its last periods, and PV over OP, each with the name of its file.
    fn figures(&self) -> Vec<(&'static str, Figure)> {
        let context = Context::of(&self.diagnosis);
        let judged = self.diagnosis.judged.as_ref().map_or(0, |judged| judged.segment);
        let mut figures = vec![];
        if let Some(trend) = trends(&self.diagnosis.grid.segments, judged, &context) {
            figures.push(("trend", trend));
        }
        let Some(segment) = self.diagnosis.segment() else { return figures };
        let samples = context.period_s.map(|p| (SHOWN * p / segment.sample_time).ceil() as usize);
        // For a record that is hardly longer, this would be the same figure again.
        if let Some(samples) = samples.filter(|samples| 2 * samples < segment.len()) {
            let last = segment.part(segment.len() - samples, samples);
            if let Some(mut close) = trends(&[last], 0, &context) {
                close.caption = format!("The last {SHOWN} periods.");
                figures.push(("close", close));
            }
        }
        let s = self.diagnosis.stiction.s.map(|s| s.value);
        if let Some(map) = head_map(segment, s, &context) {
            figures.push(("map", map));
        }
        figures
    }

    /// Data, its report and its figures.
    pub fn files(&self) -> Result<Vec<File>> {
        let [_, data, page] = self.names();
        let fitted = Fitted::of_accused(&self.diagnosis);
        let report = report::html(output::TOOL, &[self.found().with_fit(&fitted)])?;
        let mut files = vec![File::new(data, &*self.csv), File::new(page, report)];
        for (name, figure) in self.figures() {
            files.push(File::new(format!("gallery/{}-{name}.svg", self.case.tag), figure.svg()?));
        }
        Ok(files)
    }
}

impl Truth {
    /// The truth about the valve of a scenario.
    fn of_scenario(scenario: &Scenario) -> Result<Self> {
        let settings = scenario.settings();
        let value = |key: &str| {
            settings.iter().find(|(name, ..)| name == key).map(|(_, value, _)| &**value)
        };
        let number = |key: &str| -> Result<f64> {
            let text = value(key).with_context(|| format!("the scenario has no {key}"))?;
            text.trim().parse().with_context(|| format!("{key} = {text}"))
        };
        match value("valve.model").map(|name| name.trim_matches(['"', ' '])) {
            Some("ideal") => Ok(Self { sticks: false, responds: true, s: 0.0, j: 0.0 }),
            _ => Ok(Self {
                sticks: true,
                responds: true,
                s: number("valve.S")?,
                j: number("valve.J")?,
            }),
        }
    }

    fn words(&self) -> String {
        match self {
            Self { responds: false, .. } => "the valve does not move".to_owned(),
            Self { sticks: true, s, j, .. } => {
                format!(
                    "the valve sticks, S\u{a0}{}\u{a0}% and J\u{a0}{}\u{a0}%",
                    rough(*s),
                    rough(*j)
                )
            }
            Self { s, .. } if *s > 0.0 => {
                format!("the valve is healthy, with a dead band of {}\u{a0}%", rough(*s))
            }
            _ => "the valve is healthy".to_owned(),
        }
    }
}

impl Worth {
    fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::WithinLimit => "right, because the true S is below the detection limit",
            Self::Open => "left open",
            Self::Wrong => "wrong",
        }
    }
}

/// A word quoted for a shell.
fn quoted(word: &str) -> String {
    if word.contains(['"', ' ', '[']) { format!("'{word}'") } else { word.to_owned() }
}

/// The page of all cases.
pub fn page(shown: &[Shown]) -> Page {
    let count = |worth: Worth| shown.iter().filter(|each| each.worth() == worth).count();
    let parts: Vec<String> = [
        (Worth::Right, "is right", "are right"),
        (
            Worth::WithinLimit,
            "clears a valve whose true S is below the detection limit",
            "clear valves whose true S is below the detection limit",
        ),
        (Worth::Open, "leaves the answer open", "leave the answer open"),
        (Worth::Wrong, "is wrong", "are wrong"),
    ]
    .into_iter()
    .filter_map(|(worth, one, many)| match count(worth) {
        0 => None,
        1 => Some(format!("1 {one}")),
        some => Some(format!("{some} {many}")),
    })
    .collect();
    let counts = match parts.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => parts.concat(),
    };
    let cards = html! { div.cases { @for each in shown { (each.card()) } } };
    let text = format!(
        "# Twelve loops\n\n\
         Some of these valves stick, and other loops only look like loops with a sticking valve. Each loop was simulated, so the \
         truth is known. Its data were written to a file as in a plant, and diagnosed from this file. Of these {} \
         verdicts, {counts}. The loops were chosen to show easy and difficult cases. The page \
         [accuracy](accuracy.html) counts correct verdicts on thousands of loops.\n\n\
         A card shows the last six periods, PV in green and OP in blue. The percentage on the card is the probability \
         that the valve sticks.\n\n{}\n",
        shown.len(),
        cards.into_string(),
    );
    Page::new(contents::GALLERY, "Twelve loops", text)
}
