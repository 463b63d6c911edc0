//! Diagnoses as text: one screen for one loop, one line each for several, a table of all.

use super::Diagnosed;
use crate::text::{columns, number, seconds, wrapped};
use anyhow::Result;
use std::fmt::Write;
use stiction::detect::{Decision, Finding};
use stiction::diagnose::{Basis, Diagnosis, Estimate, Fault, VerdictClass, Votes};
use stiction::recording::fitness::Class;
use stiction_report::document::Loop;
use stiction_report::table::{COLUMNS, Cells};
use stiction_report::words;

/// How many reasons of each kind a screen has room for.
const REASONS: usize = 3;

/// One loop on one screen.
pub fn one(loop_: &Diagnosed) -> String {
    let Diagnosed { source, diagnosis } = loop_;
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{} ({})  {}", diagnosis.name, diagnosis.loop_type.name(), source.file);
    out += &field("verdict", &verdict(diagnosis));
    if let Some(said) = &diagnosis.verdict.overruled {
        out += &field("override", &words::overruled(said));
    }
    out += &weighed(diagnosis);
    out += &field("data", &data(diagnosis));
    for reason in diagnosis.fitness.reasons.iter().take(REASONS) {
        out += &field("", &format!("- {reason}"));
    }
    let more = diagnosis.fitness.reasons.len().saturating_sub(REASONS);
    if more > 0 {
        out += &field("", &format!("- and {more} more, in the report"));
    }
    out += &field("cycle", &cycle(diagnosis));
    if let Some(stiction) = stiction(diagnosis) {
        out += &field("stiction", &stiction);
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
        Basis::None => String::new(),
        basis => format!(" Rests on: {}.", basis.name()),
    };
    let class = verdict.class.name().to_uppercase();
    format!("{class}: {}{basis}", words::verdict(diagnosis))
}

/// What speaks for the verdict and against it, what else it could be, and how to find out.
fn weighed(diagnosis: &Diagnosis) -> String {
    let verdict = &diagnosis.verdict;
    let mut out = String::new();
    let mut list = |name: &str, texts: &[String]| {
        for (k, text) in texts.iter().take(REASONS).enumerate() {
            out += &field(if k == 0 { name } else { "" }, &format!("- {text}"));
        }
        if texts.len() > REASONS {
            out += &field("", &format!("- and {} more, in the report", texts.len() - REASONS));
        }
    };
    match verdict.basis {
        // Those of a majority are the methods' own, which stand in the table.
        Basis::Majority => {}
        // The mistake stands in the verdict, what to do about it in what is needed.
        _ if diagnosis.mistaken().is_some() => {}
        _ if verdict.class == VerdictClass::CannotTell => list("why", &verdict.reasons),
        _ => list("for it", &verdict.reasons),
    }
    list("against", &verdict.contradictions);
    if let Some(silence) = diagnosis.silence() {
        for (k, fault) in Fault::behind(silence).iter().enumerate() {
            let text = format!("- {}: {}", fault.name(), fault.told_by());
            out += &field(if k == 0 { "may be" } else { "" }, &text);
        }
    }
    let others: Vec<String> = verdict
        .alternatives
        .iter()
        .take(REASONS)
        .map(|other| format!("{} ({})", other.cause.name(), words::percent(other.likelihood)))
        .collect();
    if !others.is_empty() {
        out += &field("or else", &others.join(", "));
    }
    if let Some(test) = &verdict.confirm {
        let change = test.pv_change.map_or(String::new(), |change| {
            let unit = diagnosis.pv_unit.as_deref().unwrap_or("PV units");
            format!("; the PV should change by {} {unit} with each", words::rough(change))
        });
        let test = format!(
            "in manual, {} steps of {} % {} and back, {} apart{change}",
            test.steps,
            words::rough(test.step),
            if test.up_first { "up" } else { "down" },
            seconds(test.wait_s)
        );
        out += &field("confirm", &test);
    }
    if let Some(advice) = words::what_would_answer(diagnosis) {
        out += &field("needed", &advice);
    }
    out
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

fn stiction(diagnosis: &Diagnosis) -> Option<String> {
    let stiction = &diagnosis.stiction;
    let say = |name: &str, estimate: Option<Estimate>| {
        estimate.map(|e| format!("{name} = {}", words::interval(e)))
    };
    let parts: Vec<String> =
        [say("S", stiction.s), say("J", stiction.j)].into_iter().flatten().collect();
    let by = stiction.model.as_ref().map_or(String::new(), |model| format!(", by {model}"));
    (!parts.is_empty()).then(|| format!("{}{by}", parts.join(", ")))
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
    for Diagnosed { diagnosis, .. } in ranked {
        let oscillation = diagnosis.oscillation().map(|(_, oscillation)| oscillation);
        let Votes { sticks, does_not_stick, .. } = diagnosis.verdict.votes;
        rows.push([
            diagnosis.name.clone(),
            diagnosis.loop_type.name().to_owned(),
            diagnosis.verdict.class.name().to_owned(),
            diagnosis.verdict.probability.map_or("-".to_owned(), words::percent),
            format!("{sticks}:{does_not_stick}"),
            band(diagnosis),
            diagnosis.fitness.class.name().to_owned(),
            oscillation.and_then(|o| o.period_s).map_or("-".to_owned(), seconds),
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
    let count = |class| loops.iter().filter(|l| l.diagnosis.verdict.class == class).count();
    let mut parts = vec![
        format!("{} stick", count(VerdictClass::Sticks)),
        format!("{} do not", count(VerdictClass::DoesNotStick)),
        format!("{} cannot be told", count(VerdictClass::CannotTell)),
    ];
    if count(VerdictClass::DoesNotRespond) > 0 {
        parts.insert(1, format!("{} do not respond", count(VerdictClass::DoesNotRespond)));
    }
    let overruled = loops.iter().filter(|each| each.diagnosis.verdict.overruled.is_some()).count();
    if overruled > 0 {
        parts.push(format!("{overruled} overruled by people"));
    }
    let _ = writeln!(
        out,
        "\n{} loops: {}. Votes are families of methods for and against.",
        loops.len(),
        parts.join(", ")
    );
    out
}

/// S, or what it is below.
fn band(diagnosis: &Diagnosis) -> String {
    match (diagnosis.stiction.s, diagnosis.verdict.s_below) {
        (Some(s), _) => words::rough(s.value),
        (None, Some(limit)) => format!("<{}", words::rough(limit.value)),
        (None, None) => "-".to_owned(),
    }
}

/// The most important thing to know, short.
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

/// One row a loop: the columns of all tables, then every method's statistic and decision.
pub fn csv(loops: &[Loop<'_>]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(vec![]);
    let methods: Vec<&str> =
        stiction::detect::all().iter().map(|detector| detector.method().name).collect();
    let mut header: Vec<String> = COLUMNS.iter().map(|column| column.name.to_owned()).collect();
    for method in &methods {
        header.extend([(*method).to_owned(), format!("{method} decision")]);
    }
    writer.write_record(&header)?;
    for found in loops {
        let mut row: Vec<String> = COLUMNS.iter().map(|column| column.cells.text(found)).collect();
        for method in &methods {
            let finding = found.diagnosis.findings.iter().find(|f| f.method.name == *method);
            let statistic = Cells::number(finding.and_then(|f| f.statistic));
            row.push(statistic.map_or(String::new(), |v| v.to_string()));
            row.push(finding.map_or(String::new(), |f| f.decision.name().to_owned()));
        }
        writer.write_record(&row)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::diagnose::{Options, Override, diagnose};
    use stiction::recording::Recording;
    use stiction_report::document::Source;

    /// Where the text on one loop shows a field of the verdict; of one that it does not show, why.
    const IN_THE_TEXT: [(&str, Result<&str, &str>); 10] = [
        ("class", Ok("DOES NOT RESPOND")),
        ("probability", Err("part of the sentence where it means something")),
        ("basis", Ok("Rests on: evidence in OP and PV")),
        ("S_below", Err("part of the sentence on a valve that is cleared")),
        ("votes", Err("the methods stand below one by one, and several loops have a column")),
        ("reasons", Ok("for it    - the OP travels")),
        ("contradictions", Ok("against   - spoken against")),
        ("alternatives", Ok("or else   ")),
        ("confirm", Ok("confirm   ")),
        ("override", Ok("override  Overruled by a person: the valve sticks")),
    ];

    #[test]
    fn the_text_shows_every_field_of_the_verdict_or_says_why_not() {
        let op: Vec<f64> = (0..720).map(|k| 5.0 + 75.0 * f64::from(k) / 719.0).collect();
        let (pv, sp) = ([0.0; 720], [40.0; 720]);
        let recording = Recording::regular("FIC101", 10.0, &op, Some(&pv), Some(&sp)).unwrap();
        let mut diagnosis = diagnose(&recording, &Options::default()).unwrap();
        diagnosis.verdict.contradictions.push("spoken against".to_owned());
        diagnosis.verdict.overruled = Some(Override {
            verdict: VerdictClass::Sticks,
            reason: "it was seen".to_owned(),
            by: None,
            entered: None,
            scope: "this recording".to_owned(),
            kept_in: "a file".to_owned(),
        });
        let found = serde_json::to_value(&diagnosis.verdict).unwrap();
        let fields: Vec<&String> = found.as_object().unwrap().keys().collect();
        assert_eq!(fields, IN_THE_TEXT.map(|(field, _)| field));
        let source = Source { file: "FIC101.csv".to_owned(), sha256: String::new() };
        let text = one(&Diagnosed { source, diagnosis });
        for (field, shown) in IN_THE_TEXT {
            match shown {
                Ok(wanted) => assert!(text.contains(wanted), "{field}: no \"{wanted}\" in {text}"),
                Err(why) => assert!(!why.is_empty()),
            }
        }
    }
}
