//! Diagnoses as text: one screen for a single loop, one line per loop for several, or a table of all loops.

use super::Diagnosed;
use crate::output::{Sheet, name};
use crate::text::{self, coloured, columns, field, number};
use anyhow::Result;
use std::fmt::Write;
use stiction::diagnose::{Basis, Diagnosis, Fault, Grade, Votes};
use stiction::finding::{Decision, Finding};
use stiction::spoken;
use stiction_report::document::Loop;
use stiction_report::report::first_screen;
use stiction_report::table::{COLUMNS, Cells};
use stiction_report::words;

/// Number of texts of each kind on a screen.
const REASONS: usize = 3;

/// Mark of an S whose range of the OP is guessed.
const GUESSED: &str = "*";

/// One loop as one screen of text.
pub fn one(loop_: &Diagnosed) -> String {
    let Diagnosed { source, diagnosis } = loop_;
    let screen = first_screen(&loop_.found());
    let mut out = format!(
        "{} ({})  {}\n",
        name(&diagnosis.name),
        diagnosis.loop_type.name(),
        name(&source.file)
    );
    let grade = coloured(diagnosis.verdict.grade, &screen.badge.word.to_uppercase());
    let basis = match diagnosis.verdict.basis {
        Basis::None => String::new(),
        basis => format!(" Basis: {}.", basis.name()),
    };
    out += &field("verdict", &format!("{grade}: {}{basis}", screen.headline));
    if let Some(overruled) = &screen.overruled {
        out += &field("override", overruled);
    }
    if lacks_pv(diagnosis) {
        let signals = match diagnosis.verdict.basis {
            Basis::ValvePosition => "the OP and the valve position",
            _ => "the OP alone",
        };
        out += &field("", &format!("The verdict rests on {signals}, because no PV was read."));
    }
    for side in &screen.sides {
        out += &field("", &side.heading);
        out += &listed("", &side.reasons);
    }
    if let Some(silence) = diagnosis.silence() {
        let check = |fault: &Fault| format!("{}: {}", fault.name(), fault.check());
        out += &listed("may be", &Fault::behind(silence).iter().map(check).collect::<Vec<_>>());
    }
    let causes: Vec<String> =
        screen.causes.iter().map(|each| format!("{} ({})", each.cause, each.likelihood)).collect();
    if !causes.is_empty() {
        out += &field("causes", &causes.join(", "));
    }
    out += &listed("actions", &screen.actions);
    if let Some(advice) = words::what_would_answer(diagnosis)
        && !screen.actions.contains(&advice)
    {
        out += &field("needed", &advice);
    }
    out += &field("data", &data(diagnosis));
    out += &listed("", &screen.remarks);
    for note in &diagnosis.notes {
        out += &field("note", note);
    }
    out += &text::facts(&screen.facts);
    out += "\n";
    out += &methods(&diagnosis.findings);
    out += "\n";
    out += &key_figures(diagnosis);
    // The beginning has scrolled off the screen.
    out + &format!("\n{}\n", line(diagnosis))
}

/// The first of some texts, as a list.
fn listed(name: &str, texts: &[String]) -> String {
    let first = texts.iter().take(REASONS).enumerate();
    let more = texts.len().saturating_sub(REASONS);
    let more = (more > 0).then(|| field("", &format!("- and {more} more, in the report")));
    first
        .map(|(k, text)| field(if k == 0 { name } else { "" }, &format!("- {text}")))
        .chain(more)
        .collect()
}

/// One line per loop, worst first.
pub fn brief(loops: &[Diagnosed]) -> String {
    ranked(loops).into_iter().map(|each| format!("{}\n", line(&each.diagnosis))).collect()
}

/// Name, verdict, probability and S in one line.
fn line(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let grade = coloured(verdict.grade, verdict.grade.name());
    let mut out = format!("{}: {grade}", name(&diagnosis.name));
    // Writing to a string cannot fail.
    let _ = match verdict.shown_probability() {
        Some(p) => write!(out, " ({})", words::percent(p)),
        None => Ok(()),
    };
    let of = words::guessed_range(diagnosis).map_or(String::new(), |of| format!(" {of}"));
    let _ = match (diagnosis.stiction.s, verdict.s_below) {
        (Some(s), _) => write!(out, "; S {}{of}", words::interval(s)),
        (None, Some(limit)) => {
            let limit = words::rough(limit.value);
            match verdict.grade {
                Grade::Fine => write!(out, "; S above {limit} %{of} would have been detected"),
                _ => write!(out, "; could mask an S of up to {limit} %{of}"),
            }
        }
        (None, None) => Ok(()),
    };
    if lacks_pv(diagnosis) {
        out += "; judged without a PV";
    }
    if let Some(masked) = diagnosis.masked_words() {
        let _ = write!(out, "; masked {masked}");
    }
    if let Some(said) = &verdict.overruled {
        let _ = write!(out, "; override: {}", said.verdict);
    }
    out
}

/// Whether the recording has no PV, so that the verdict rests on the OP alone.
fn lacks_pv(diagnosis: &Diagnosis) -> bool {
    diagnosis.segment().is_some_and(|segment| segment.pv.is_none())
}

/// The loops, worst first.
fn ranked(loops: &[Diagnosed]) -> Vec<&Diagnosed> {
    let mut ranked: Vec<&Diagnosed> = loops.iter().collect();
    ranked.sort_by(|a, b| a.found().in_rank(&b.found()));
    ranked
}

fn data(diagnosis: &Diagnosis) -> String {
    let Some(segment) = diagnosis.segment() else { return "no segment to analyse".to_owned() };
    format!(
        "{} samples of {}, {}{}",
        segment.len(),
        spoken::time(segment.sample_time),
        spoken::time(segment.duration()),
        match diagnosis.grid.segments.len() {
            1 => " in all".to_owned(),
            n => format!(", the longest of {n} segments"),
        }
    )
}

fn methods(findings: &[Finding]) -> String {
    let mut rows = vec![["method", "statistic", "threshold", "decision"].map(str::to_owned)];
    let mut abstaining = vec![];
    for finding in findings {
        if finding.decision == Decision::Abstains {
            abstaining.push(finding);
            continue;
        }
        let say = |value: Option<f64>| value.map_or("-".to_owned(), number);
        rows.push([
            finding.method.title.to_owned(),
            say(finding.statistic),
            say(finding.threshold),
            finding.decision.name().to_owned(),
        ]);
    }
    let mut out = columns(&rows, &[false, true, true, false]);
    // Methods that abstain for the same reason share a line.
    let mut reasons: Vec<(&str, Vec<&str>)> = vec![];
    for finding in abstaining {
        match reasons.iter_mut().find(|(reason, _)| *reason == finding.reason) {
            Some((_, methods)) => methods.push(finding.method.name),
            None => reasons.push((&finding.reason, vec![finding.method.name])),
        }
    }
    for (reason, methods) in reasons {
        out += &field("abstain", &format!("{}: {reason}", methods.join(", ")));
    }
    out
}

fn key_figures(diagnosis: &Diagnosis) -> String {
    let cells: Vec<[String; 2]> = diagnosis
        .kpis
        .numbers
        .iter()
        .filter_map(|kpi| {
            let value = kpi.value.filter(|v| v.is_finite())?;
            Some([kpi.name.to_owned(), format!("{} {}", number(value), kpi.unit).trim().to_owned()])
        })
        .collect();
    let half = cells.len().div_ceil(2);
    let rows: Vec<[String; 4]> = (0..half)
        .map(|k| {
            let [name, value] = cells[k].clone();
            let [other, second] = cells.get(k + half).cloned().unwrap_or_default();
            [name, value, other, second]
        })
        .collect();
    columns(&rows, &[false; 4])
}

/// Several loops, worst first.
pub fn several(loops: &[Diagnosed]) -> String {
    let header = [
        "loop",
        "type",
        "verdict",
        "p(sticks)",
        "votes",
        "S",
        "data",
        "period",
        "regularity",
        "why",
    ];
    let mut rows = vec![header.map(str::to_owned)];
    for Diagnosed { diagnosis, .. } in ranked(loops) {
        let oscillation = diagnosis.oscillation().map(|(_, oscillation)| oscillation);
        let Votes { sticks, does_not_stick, .. } = diagnosis.verdict.votes;
        rows.push([
            diagnosis.name.clone(),
            diagnosis.loop_type.name().to_owned(),
            coloured(diagnosis.verdict.grade, diagnosis.verdict.grade.name()),
            diagnosis.verdict.shown_probability().map_or("-".to_owned(), words::percent),
            format!("{sticks}:{does_not_stick}"),
            band(diagnosis),
            diagnosis.fitness.class.name().to_owned(),
            oscillation.and_then(|o| o.period_s).map_or("-".to_owned(), spoken::time),
            oscillation
                .and_then(|o| o.regularity)
                .filter(|r| r.is_finite())
                .map_or("-".to_owned(), number),
            match &diagnosis.verdict.overruled {
                Some(said) => format!("overruled: {}, {}", said.verdict, said.reason),
                None => why(diagnosis),
            },
        ]);
    }
    let right = [false, false, false, true, true, true, false, true, true, false];
    let mut out = columns(&rows, &right);
    let count = |grade| loops.iter().filter(|l| l.diagnosis.verdict.grade == grade).count();
    let counted = Grade::ALL.into_iter().map(|grade| (count(grade), grade));
    let mut parts: Vec<String> = counted
        .filter(|(count, _)| *count > 0)
        .map(|(count, grade)| format!("{count} {grade}"))
        .collect();
    let overruled = loops.iter().filter(|each| each.diagnosis.verdict.overruled.is_some()).count();
    if overruled > 0 {
        parts.push(format!("{overruled} overruled by people"));
    }
    let _ = writeln!(
        out,
        "\n{} loops: {}. Votes are families of methods for and against sticking.",
        loops.len(),
        parts.join(", ")
    );
    if rows.iter().any(|row| row[5].ends_with(GUESSED)) {
        out += "* The OP range is estimated or assumed, so the true S may differ from the printed S. The diagnosis of each loop shows the \
                range.\n";
    }
    out
}

/// S, or its detection limit.
fn band(diagnosis: &Diagnosis) -> String {
    let mark = if words::guessed_range(diagnosis).is_some() { GUESSED } else { "" };
    match (diagnosis.stiction.s, diagnosis.verdict.s_below) {
        (Some(s), _) => format!("{}{mark}", words::rough(s.value)),
        (None, Some(limit)) => format!("<{}{mark}", words::rough(limit.value)),
        (None, None) => "-".to_owned(),
    }
}

/// The most important reason, shortened.
fn why(diagnosis: &Diagnosis) -> String {
    let text = match diagnosis.silence() {
        Some(silence) => silence.name().to_owned(),
        None => words::why(diagnosis),
    };
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}

/// One row per loop with the columns of all tables, then the statistic and decision of every method.
pub fn csv(loops: &[Loop<'_>]) -> Result<String> {
    let methods = stiction::methods::MethodId::ALL;
    let mut header: Vec<String> = COLUMNS.iter().map(|column| column.name.to_owned()).collect();
    for method in methods {
        header.extend([method.to_string(), format!("{method} decision")]);
    }
    let mut sheet = Sheet::new(&header)?;
    for found in loops {
        let mut row: Vec<String> = COLUMNS.iter().map(|column| column.cells.text(found)).collect();
        for id in methods {
            let finding = found.diagnosis.findings.iter().find(|f| f.method == id.method());
            let statistic = Cells::number(finding.and_then(|f| f.statistic));
            row.push(statistic.map_or(String::new(), spoken::cell));
            row.push(finding.map_or(String::new(), |f| f.decision.name().to_owned()));
        }
        sheet.row(&row)?;
    }
    Ok(sheet.text()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::diagnose::{
        Alternative, Cause, DiagnoseOptions, Override, Verdict, VerdictClass, diagnose,
    };
    use stiction::recording::Recording;
    use stiction::valve_test::{PlanOptions, plan};
    use stiction_report::document::Source;
    use stiction_report::report;

    /// By what something is seen, or why it is not.
    type Seen = Result<&'static str, &'static str>;

    /// By what a field of the verdict is seen, in the text on one loop and on the page.
    const SHOWN: [(&str, Seen, Seen); 12] = [
        ("class", Err("is what the grade says where it decides"), Err("is so, too")),
        ("grade", Ok("DOES NOT RESPOND"), Ok("does not respond")),
        (
            "probability",
            Err("is in the words, where it means something"),
            Ok("probability of sticking"),
        ),
        ("basis", Ok("Basis: evidence in OP and PV"), Ok("evidence in OP and PV")),
        ("S_below", Err("is in the words on a cleared valve"), Err("is in the words, too")),
        ("votes", Err("every method has a line"), Ok("families of methods that find stiction")),
        ("reasons", Ok("Evidence for no response - Spoken for."), Ok("Spoken for.")),
        ("contradictions", Ok("against no response - Spoken against."), Ok("Spoken against.")),
        ("alternatives", Ok("causes saturation"), Ok("Looks saturated.")),
        ("confirm", Err("is one of the actions"), Ok("Put the controller in manual.")),
        ("no_test", Err("stands in the place of a test"), Err("the same")),
        ("override", Ok("override Overruled by a person"), Ok("Overruled by a person")),
    ];

    fn verdict() -> Verdict {
        Verdict {
            class: VerdictClass::DoesNotRespond,
            grade: Grade::DoesNotRespond,
            probability: Some(0.7),
            basis: Basis::Evidence,
            reasons: vec!["spoken for".to_owned()],
            contradictions: vec!["spoken against".to_owned()],
            alternatives: vec![Alternative {
                cause: Cause::Saturation,
                likelihood: 0.2,
                because: "looks saturated".to_owned(),
            }],
            overruled: Some(Override {
                verdict: VerdictClass::Sticks,
                reason: "it was seen".to_owned(),
                by: None,
                entered: None,
                scope: "this recording".to_owned(),
                kept_in: "a file".to_owned(),
            }),
            ..Verdict::default()
        }
    }

    #[test]
    fn text_and_page_show_every_field_of_the_verdict_or_say_why_not() {
        let op: Vec<f64> = (0..300).map(|k| 50.0 + 2.0 * (f64::from(k) * 0.1).sin()).collect();
        let recording = Recording::regular("FIC101", 1.0, &op, Some(&op), None).unwrap();
        let mut diagnosis = diagnose(&recording, &DiagnoseOptions::default()).unwrap();
        let confirm = plan(&diagnosis, &PlanOptions::default()).ok();
        (diagnosis.relation, diagnosis.verdict) = (None, Verdict { confirm, ..verdict() });
        let found = serde_json::to_value(&diagnosis.verdict).unwrap();
        let fields: Vec<&String> = found.as_object().unwrap().keys().collect();
        assert_eq!(
            fields,
            SHOWN.map(|(field, ..)| field),
            "a field is shown, or it is said why not"
        );
        let source = Source { file: "FIC101.csv".to_owned(), sha256: String::new() };
        let diagnosed = Diagnosed { source, diagnosis };
        let page = report::html("tool", &[diagnosed.found()]).unwrap();
        // However its lines are broken.
        let text = one(&diagnosed).split_whitespace().collect::<Vec<_>>().join(" ");
        for (field, in_text, on_page) in SHOWN {
            for (shown, place) in [(in_text, &text), (on_page, &page)] {
                match shown {
                    Ok(wanted) => {
                        assert!(place.contains(wanted), "{field}: no \"{wanted}\": {text}")
                    }
                    Err(why) => assert!(!why.is_empty()),
                }
            }
        }
    }
}
