//! The sections on the verdict: evidence for and against it, other possible causes, the confirming test, the size of
//! stiction, and its course over time.

use super::layout::{Block, Fact, Section, Table, number};
use super::over_time::{self, Point};
use crate::words::{self, percent, rough, sentence, spoken};
use stiction_diagnose::diagnose::{Basis, Cause, Diagnosis, Fault, VerdictClass, Weighing};
use stiction_diagnose::drawing::WIDTH;
use stiction_diagnose::valve_test::TestPlan;
use stiction_figure::figure::{Figure, Panel, Scale, Series, colour};

/// Names of the rows in the figure of S and J. The definitions follow, by letters.
const ROWS: &[&str] = &["", "J", "S", "a", "b", "c", "d", "e", "f", "g", "h", ""];
/// Index of the first definition in [`ROWS`].
const DEFINITIONS: usize = 3;

/// Adds the reasons of the verdict and other possible causes.
pub(super) fn why(section: Section, diagnosis: &Diagnosis) -> Section {
    let advice = words::what_would_answer(diagnosis).map(Block::Paragraph);
    let section = faults(section.with_all(advice), diagnosis);
    alternatives(evidence(section, diagnosis), diagnosis)
}

/// Possible faults of a loop that does not respond, with a check for each.
fn faults(section: Section, diagnosis: &Diagnosis) -> Section {
    let Some(silence) = diagnosis.silence() else { return section };
    let caption = format!(
        "{}, with the most likely fault first.",
        sentence(silence.name()).trim_end_matches('.')
    );
    let table = Table::new(caption).words("fault").words("how to check");
    let table = Fault::behind(silence)
        .iter()
        .fold(table, |table, fault| table.row([fault.name().to_owned(), sentence(fault.check())]));
    section.heading("Possible faults").with(table)
}

/// Evidence for and against the verdict, with headings.
pub(super) fn sides(diagnosis: &Diagnosis) -> Vec<(&'static str, &[String])> {
    let verdict = &diagnosis.verdict;
    let mut sides: Vec<(&'static str, &[String])> = vec![];
    if !verdict.reasons.is_empty() {
        let heading = match verdict.class {
            VerdictClass::Sticks => "Evidence for sticking",
            VerdictClass::DoesNotStick => "Evidence against sticking",
            VerdictClass::DoesNotRespond => "Evidence for no response",
            VerdictClass::CannotTell => "Reasons for the open answer",
        };
        sides.push((heading, &verdict.reasons));
    }
    if !verdict.contradictions.is_empty() {
        let heading = match verdict.class {
            VerdictClass::DoesNotStick => "Evidence for sticking",
            VerdictClass::DoesNotRespond => "Evidence against no response",
            VerdictClass::Sticks | VerdictClass::CannotTell => "Evidence against sticking",
        };
        sides.push((heading, &verdict.contradictions));
    }
    sides
}

fn evidence(mut section: Section, diagnosis: &Diagnosis) -> Section {
    let verdict = &diagnosis.verdict;
    for (heading, reasons) in sides(diagnosis) {
        let items = reasons.iter().map(|text| sentence(text)).collect();
        section = section.heading(heading).list(items);
    }
    match &diagnosis.evidence {
        Some(weighing) if verdict.basis == Basis::Evidence => {
            section.paragraph(words::PROBABILITY).with(measured(weighing, verdict.class))
        }
        _ => section,
    }
}

/// Quantities that support a probability or not.
fn measured(weighing: &Weighing, class: VerdictClass) -> Block {
    let mut facts = vec![
        Fact::new(
            "advantage of a sticking valve in predicting the PV, standard errors",
            number((10.0 * weighing.z).round() / 10.0),
            "",
        ),
        Fact::new(
            "distance from the training loops (not judged above 1)",
            words::rough(weighing.distance),
            "",
        ),
        Fact::new("OP range, 0.5 to 99.5 % quantile", words::rough(weighing.op_range), "%"),
    ];
    // If an S was found, its detection limit does not matter.
    if !matches!(class, VerdictClass::Sticks | VerdictClass::DoesNotRespond) {
        let limit = weighing.limit.map_or_else(|| "none".to_owned(), words::rough);
        let unit = if weighing.limit.is_some() { "%" } else { "" };
        facts.push(Fact::new("detection limit of S (95 %)", limit, unit));
    }
    Block::Facts(facts)
}

fn alternatives(section: Section, diagnosis: &Diagnosis) -> Section {
    let verdict = &diagnosis.verdict;
    if verdict.alternatives.is_empty() {
        return section;
    }
    let mut rows: Vec<(Cause, f64, String)> = verdict
        .alternatives
        .iter()
        .map(|each| (each.cause, each.likelihood, sentence(&each.because)))
        .collect();
    let listed = |cause| rows.iter().any(|(other, _, _)| *other == cause);
    if let Some(probability) = verdict.probability.filter(|_| !listed(Cause::StickingValve)) {
        rows.push((Cause::StickingValve, probability, String::new()));
    }
    rows.sort_by(|a, b| b.1.total_cmp(&a.1));
    let table = Table::new("").words("cause").words("likelihood").words("evidence in the data");
    let table = rows.into_iter().fold(table, |table, (cause, likelihood, because)| {
        table.row([cause.name().to_owned(), bar(likelihood), because])
    });
    section.heading("Other possible causes").with(table)
}

/// A share of one as a bar of text, with its percentage.
fn bar(share: f64) -> String {
    let blocks = (10.0 * share.clamp(0.0, 1.0)).round() as usize;
    let bar = format!("{}{}", "█".repeat(blocks), "░".repeat(10 - blocks));
    format!("{bar}\u{a0}{}", percent(share).replace(' ', "\u{a0}"))
}

/// The confirming test, or the reason why there is none, else general advice.
pub(super) fn confirm(section: Section, diagnosis: &Diagnosis) -> Section {
    if let Some(plan) = &diagnosis.verdict.confirm {
        return section.with_all(self::plan(plan)).paragraph(
            "stiction test plan prints the sheet, and stiction test read evaluates the test.",
        );
    }
    if let Some(why) = &diagnosis.verdict.no_test {
        return section.paragraph(sentence(&format!("no test can be planned: {why}")));
    }
    match diagnosis.verdict.class {
        VerdictClass::Sticks
            if !matches!(diagnosis.verdict.basis, Basis::ValvePosition | Basis::ValveTest) =>
        {
            let items = [
                "Put the controller in manual and hold the OP. An oscillation caused by the valve dies out.",
                "Step the OP by small amounts up, then down, and watch the flow or the stem. A valve that sticks \
                 does not follow the first steps after each reversal.",
            ];
            let items = items.map(str::to_owned).to_vec();
            section.with(Block::List { ordered: true, items })
        }
        VerdictClass::DoesNotStick if diagnosis.verdict.alternatives.is_empty() => section.paragraph(
            "If the loop oscillates, first check its tuning, and other loops with the same period.",
        ),
        _ => section,
    }
}

/// The sheet of a test, without the fields for handwriting.
pub fn plan(plan: &TestPlan) -> Vec<Block> {
    let table = Table::new("The turns of part 1, relative to u0.")
        .columns("#turns | #OP from u0 [%] | #longest hold");
    let sizes = (1..).step_by(plan.each.max(1)).zip(plan.grow.chunks(plan.each.max(1)));
    let table = sizes.fold(table, |table, (first, same)| {
        let signed =
            |op: f64| format!("{}{}", if op < 0.0 { '\u{2212}' } else { '+' }, rough(op.abs()));
        let of: Vec<String> = same.iter().map(|turn| signed(turn.op)).collect();
        let last = first + same.len() - 1;
        let turns = if last > first { format!("{first} to {last}") } else { first.to_string() };
        table.row([turns, of.join(", "), spoken(same[0].hold_s)])
    });
    vec![Block::List { ordered: true, items: plan.instructions.clone() }, table.into()]
}

/// S and J with their intervals, beside competing definitions.
pub(super) fn size(section: Section, diagnosis: &Diagnosis) -> Section {
    let stiction = &diagnosis.stiction;
    if stiction.s.is_none() && stiction.j.is_none() && stiction.definitions.is_empty() {
        return section;
    }
    let coverage = stiction.coverage.map_or(String::new(), |share| {
        format!(" The intervals have a nominal coverage of {:.0} %.", 100.0 * share)
    });
    let model = stiction.model.as_ref().map(|model| format!("Estimated with {model}.{coverage}"));
    let why = stiction.why_not.as_ref().map(|why| sentence(why));
    let section = section
        .with_all(model.into_iter().chain(why).map(Block::Paragraph))
        .with_all(size_figure(diagnosis));
    if stiction.definitions.is_empty() {
        return section;
    }
    let table = Table::new("Competing definitions of \"stiction in percent\".")
        .columns("| definition | #value | meaning");
    section.with(stiction.definitions.iter().enumerate().fold(table, |table, (k, each)| {
        let value =
            each.value.map_or("–".to_owned(), |v| format!("{}\u{a0}{}", rough(v), each.unit));
        table.row([letter(k).to_owned(), each.name.to_owned(), value, sentence(each.meaning)])
    }))
}

/// The letter of a definition; empty if the figure has no row for it.
fn letter(definition: usize) -> &'static str {
    ROWS.get(DEFINITIONS + definition).copied().unwrap_or_default()
}

fn size_figure(diagnosis: &Diagnosis) -> Option<Figure> {
    let stiction = &diagnosis.stiction;
    let intervals: Vec<_> = [(2.0, stiction.s), (1.0, stiction.j)]
        .into_iter()
        .filter_map(|(row, estimate)| Some((row, estimate?)))
        .collect();
    let definitions: Vec<(f64, f64)> = stiction
        .definitions
        .iter()
        .enumerate()
        .filter(|(k, each)| each.unit.starts_with('%') && !letter(*k).is_empty())
        .filter_map(|(k, each)| Some((each.value?, (DEFINITIONS + k) as f64)))
        .collect();
    let rows = intervals.iter().map(|(row, _)| *row).chain(definitions.iter().map(|(_, row)| *row));
    let top = rows.fold(f64::NAN, f64::max);
    if intervals.is_empty() {
        return None;
    }
    let (mut x, mut y) = (vec![], vec![]);
    for (row, estimate) in &intervals {
        x.extend([estimate.low, estimate.high]);
        y.extend([*row; 2]);
    }
    let largest = x.iter().copied().chain(definitions.iter().map(|(v, _)| *v)).fold(0.0, f64::max);
    let values: Vec<f64> = intervals.iter().map(|(_, e)| e.value).collect();
    let places: Vec<f64> = intervals.iter().map(|(row, _)| *row).collect();
    let mut panel = Panel::new("% of span", "")
        .y_scale(Scale::Names(ROWS))
        .y_range(0.4, top + 0.6)
        .height(34.0 + 22.0 * top)
        .with(over_time::runs("interval", x, y))
        .with(Series::points("S and J", values, places).colour(colour::VERMILION));
    if largest > 0.0 {
        panel = panel.x_range(0.0, 1.08 * largest);
    }
    let mut caption = "Points show S and J, and lines their intervals".to_owned();
    if !definitions.is_empty() {
        let (values, places): (Vec<f64>, Vec<f64>) = definitions.into_iter().unzip();
        panel =
            panel.with(Series::points("other definitions", values, places).colour(colour::BLACK));
        caption += "; the points above them are the other definitions in the table";
    }
    let figure = Figure::new("").caption(format!("{caption}.")).width(WIDTH).with(panel);
    Some(figure).filter(|figure| figure.check().is_ok())
}

pub(super) fn windows(section: Section, diagnosis: &Diagnosis) -> Section {
    // A single window is the whole recording, which is already covered.
    if diagnosis.windows.len() < 2 {
        return section;
    }
    let points: Vec<Point> = diagnosis
        .windows
        .iter()
        .map(|w| Point {
            from: w.from,
            duration: w.duration,
            probability: Some(w.probability),
            s: w.s,
        })
        .collect();
    let changes = diagnosis.evidence.iter().flat_map(|evidence| &evidence.changes);
    let marks: Vec<(f64, &str)> = changes.map(|event| (event.time, event.change.name())).collect();
    let figure = over_time::figure(&points, diagnosis.start, &diagnosis.plant_time, &marks);
    let table = Table::new("")
        .columns("from | duration | #probability | #S | #J | #detection limit of S [%]");
    let table = diagnosis.windows.iter().fold(table, |table, w| {
        let estimate = |e: Option<_>| e.map_or("–".to_owned(), words::interval);
        table.row([
            super::moment::moment(diagnosis, w.from),
            spoken(w.duration),
            percent(w.probability),
            estimate(w.s),
            estimate(w.j),
            w.limit.map_or("–".to_owned(), words::rough),
        ])
    });
    let summary = format!("Numbers of all {} windows", diagnosis.windows.len());
    section.with_all(figure).with(Block::details(summary, table))
}

/// The probability as a fact; `None` without a probability.
pub(super) fn probability(diagnosis: &Diagnosis) -> Option<Fact> {
    let p = diagnosis.verdict.shown_probability()?;
    Some(Fact::new("probability of sticking", percent(p), ""))
}
