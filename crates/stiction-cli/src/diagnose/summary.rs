//! Diagnoses as text: one screen for one loop, one line each for several, a table of all.

use super::Diagnosed;
use crate::text::{columns, number, seconds, wrapped};
use anyhow::Result;
use std::fmt::Write;
use stiction::detect::{Decision, Finding};
use stiction::diagnose::{Basis, Diagnosis, Estimate, VerdictClass, Votes};
use stiction::recording::fitness::Class;

/// How many reasons of each kind a screen has room for.
const REASONS: usize = 3;

/// One loop on one screen.
pub fn one(loop_: &Diagnosed) -> String {
    let Diagnosed { source, diagnosis } = loop_;
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{} ({})  {}", diagnosis.name, diagnosis.loop_type.name(), source.file);
    out += &field("verdict", &verdict(diagnosis));
    out += &field("data", &data(diagnosis));
    for reason in diagnosis.fitness.reasons().iter().take(REASONS) {
        out += &field("", &format!("- {reason}"));
    }
    let more = diagnosis.fitness.reasons().len().saturating_sub(REASONS);
    if more > 0 {
        out += &field("", &format!("- and {more} more, in the report"));
    }
    out += &field("cycle", &cycle(diagnosis));
    if let Some(measured) = measured(diagnosis) {
        out += &field("measured", &measured);
    }
    for note in &diagnosis.notes {
        out += &field("note", note);
    }
    out += "\n";
    out += &methods(&diagnosis.findings);
    out += "\n";
    out += &key_figures(diagnosis);
    out
}

fn field(name: &str, text: &str) -> String {
    let mut out = String::new();
    for (k, line) in wrapped(text, 88).into_iter().enumerate() {
        let _ = writeln!(out, "{:10}{line}", if k == 0 { name } else { "" });
    }
    out
}

fn verdict(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let basis = match verdict.basis {
        Basis::None => "preliminary".to_owned(),
        basis => format!("preliminary, by the {}", basis.name()),
    };
    let reasons = match verdict.basis {
        // Those of a majority are the methods' own, which stand in the table.
        Basis::Majority => &verdict.reasons[..verdict.reasons.len().min(1)],
        _ => &verdict.reasons[..],
    };
    format!("{} ({basis}): {}", verdict.class.name().to_uppercase(), reasons.join("; "))
}

fn data(diagnosis: &Diagnosis) -> String {
    let class = match diagnosis.fitness.class {
        Class::Fit => "fit",
        Class::Caveats => "fit with caveats",
        Class::Unfit => "unfit",
    };
    let Some(stretch) = diagnosis.stretch() else { return class.to_owned() };
    format!(
        "{class}; {} samples of {}, {} in all{}",
        stretch.len(),
        seconds(stretch.sample_time),
        seconds(stretch.duration()),
        match diagnosis.grid.stretches.len() {
            1 => String::new(),
            n => format!(", the longest of {n} stretches"),
        }
    )
}

fn cycle(diagnosis: &Diagnosis) -> String {
    let Some((signal, oscillation)) = diagnosis.oscillation() else {
        return "there is nothing to look at".to_owned();
    };
    let mut parts = vec![];
    match oscillation.period_s {
        Some(period) => parts.push(format!("period {}", seconds(period))),
        None => parts.push("no period".to_owned()),
    }
    let mut say = |name: &str, value: Option<f64>| {
        if let Some(value) = value.filter(|v| v.is_finite()) {
            parts.push(format!("{name} {}", number(value)));
        }
    };
    say("amplitude", oscillation.amplitude);
    say("regularity", oscillation.regularity);
    say("decay ratio", oscillation.decay_ratio);
    say("cycles", oscillation.cycles);
    let found = if oscillation.found { "oscillates" } else { "does not oscillate clearly" };
    format!("the {signal} {found}: {}", parts.join(", "))
}

fn measured(diagnosis: &Diagnosis) -> Option<String> {
    let stiction = &diagnosis.stiction;
    let say = |name: &str, estimate: Option<Estimate>| {
        estimate.map(|e| {
            format!("{name} = {} % ({} to {})", number(e.value), number(e.low), number(e.high))
        })
    };
    let parts: Vec<String> =
        [say("S", stiction.s), say("J", stiction.j)].into_iter().flatten().collect();
    (!parts.is_empty())
        .then(|| format!("{}, by {}", parts.join(", "), stiction.model.as_deref().unwrap_or("")))
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

/// Several loops, the worst first.
pub fn several(loops: &[Diagnosed]) -> String {
    let mut ranked: Vec<&Diagnosed> = loops.iter().collect();
    ranked.sort_by(|a, b| {
        a.diagnosis.rank().total_cmp(&b.diagnosis.rank()).then_with(|| {
            (&a.diagnosis.name, &a.source.file).cmp(&(&b.diagnosis.name, &b.source.file))
        })
    });
    let header = ["loop", "type", "verdict", "votes", "data", "period", "regularity", "why"];
    let mut rows = vec![header.map(str::to_owned)];
    for Diagnosed { diagnosis, .. } in ranked {
        let oscillation = diagnosis.oscillation().map(|(_, oscillation)| oscillation);
        let Votes { sticks, does_not_stick, .. } = diagnosis.verdict.votes;
        rows.push([
            diagnosis.name.clone(),
            diagnosis.loop_type.name().to_owned(),
            diagnosis.verdict.class.name().to_owned(),
            format!("{sticks}:{does_not_stick}"),
            diagnosis.fitness.class.name().to_owned(),
            oscillation.and_then(|o| o.period_s).map_or("-".to_owned(), seconds),
            oscillation
                .and_then(|o| o.regularity)
                .filter(|r| r.is_finite())
                .map_or("-".to_owned(), number),
            why(diagnosis),
        ]);
    }
    let mut out = columns(&rows, &[false, false, false, true, false, true, true, false]);
    let count = |class| loops.iter().filter(|l| l.diagnosis.verdict.class == class).count();
    let _ = writeln!(
        out,
        "\n{} loops: {} stick, {} do not, {} cannot be told. Votes are families of methods for and against; the \
         verdict is a preliminary one.",
        loops.len(),
        count(VerdictClass::Sticks),
        count(VerdictClass::DoesNotStick),
        count(VerdictClass::CannotTell),
    );
    out
}

/// The most important thing to know, short.
fn why(diagnosis: &Diagnosis) -> String {
    let reasons = diagnosis.fitness.reasons();
    let text = match (diagnosis.fitness.class, reasons.first()) {
        (Class::Unfit, Some(reason)) => reason,
        _ => match diagnosis.verdict.class {
            VerdictClass::CannotTell => diagnosis.verdict.reasons.last().map_or("", String::as_str),
            _ => "",
        },
    };
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}

/// One row a loop, with every method's statistic and decision.
pub fn csv(loops: &[Diagnosed]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    let methods: Vec<&str> =
        stiction::detect::all().iter().map(|detector| detector.method().name).collect();
    let fixed = [
        "loop",
        "file",
        "type",
        "fitness",
        "samples",
        "sample_time_s",
        "oscillates",
        "period_s",
        "regularity",
        "amplitude",
        "verdict",
        "votes_sticks",
        "votes_does_not_stick",
        "S",
        "J",
    ];
    let mut header: Vec<String> = fixed.map(str::to_owned).to_vec();
    for method in &methods {
        header.extend([(*method).to_owned(), format!("{method} decision")]);
    }
    writer.write_record(&header)?;
    for Diagnosed { source, diagnosis } in loops {
        let stretch = diagnosis.stretch();
        let oscillation = diagnosis.oscillation().map(|(_, oscillation)| oscillation);
        let say = |value: Option<f64>| {
            value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string())
        };
        let votes = diagnosis.verdict.votes;
        let mut row = vec![
            diagnosis.name.clone(),
            source.file.clone(),
            diagnosis.loop_type.name().to_owned(),
            diagnosis.fitness.class.name().to_owned(),
            stretch.map_or(0, |s| s.len()).to_string(),
            say(stretch.map(|s| s.sample_time)),
            oscillation.is_some_and(|o| o.found).to_string(),
            say(oscillation.and_then(|o| o.period_s)),
            say(oscillation.and_then(|o| o.regularity)),
            say(oscillation.and_then(|o| o.amplitude)),
            diagnosis.verdict.class.name().to_owned(),
            votes.sticks.to_string(),
            votes.does_not_stick.to_string(),
            say(diagnosis.stiction.s.map(|s| s.value)),
            say(diagnosis.stiction.j.map(|j| j.value)),
        ];
        for method in &methods {
            let finding = diagnosis.findings.iter().find(|f| f.method.name == *method);
            row.push(say(finding.and_then(|f| f.statistic)));
            row.push(finding.map_or(String::new(), |f| f.decision.name().to_owned()));
        }
        writer.write_record(&row)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}
