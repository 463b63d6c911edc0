//! The head of a loop's page: verdict of the week, action and size. One window of the loop follows.

use crate::report::action::Action;
use crate::report::health::Health;
use crate::report::orders;
use crate::report::ranking::LoopRow;
use crate::week::Week;
use stiction_diagnose::diagnose::{Estimate, Grade, Verdict, VerdictClass};
use stiction_diagnose::spoken::{counted, percent};
use stiction_report::report::Heading;

/// The head of the page of a loop that shows a window of `day`, with the verdict on that day alone.
pub fn heading(row: &LoopRow, week: Week, day: &str, alone: &Verdict) -> Heading {
    let grade = row.grade.unwrap_or(Grade::CannotAnswer);
    let triple = |value: Option<f64>, low: Option<f64>, high: Option<f64>| {
        Some(Estimate { value: value?, low: low?, high: high? })
    };
    let own = alone.shown_probability().map_or(String::new(), |p| format!(" ({})", percent(p)));
    let continues = row.is_to_test() && alone.grade.accuses();
    Heading {
        grade,
        verdict: verdict(row, grade),
        probability: row.probability,
        s: triple(row.s, row.s_low, row.s_high),
        j: triple(row.j, row.j_low, row.j_high),
        actions: if continues { vec![] } else { vec![action(row)] },
        continues,
        shows: format!(
            "This is the verdict of week {week}. Trend, swing, causes and evidence are from {day}, whose verdict is: {}{own}.",
            alone.grade
        ),
        sheet: None,
    }
}

/// The verdict of the week, a sentence or two.
fn verdict(row: &LoopRow, grade: Grade) -> String {
    let p = grade.shown(row.probability).map(percent);
    let with = |words: &str, p: Option<String>| match p {
        Some(p) => format!("{words} ({p})"),
        None => words.to_owned(),
    };
    let says = match grade {
        Grade::Sticks => with("The valve most likely sticks", p),
        Grade::ProbablySticks => with("The valve probably sticks", p),
        Grade::DoesNotRespond => "The valve, or its transmitter, does not respond".to_owned(),
        Grade::Unclear => with("Whether the valve sticks is unclear", p),
        Grade::ProbablyFine => {
            with("The valve is probably fine", p.map(|p| format!("probability of sticking {p}")))
        }
        Grade::NoneVisible => {
            with("No stiction is visible", p.map(|p| format!("probability of sticking {p}")))
        }
        Grade::TooLittle => "The valve sticks too little to matter".to_owned(),
        Grade::Fine => with("The valve is fine", p.map(|p| format!("probability of sticking {p}"))),
        Grade::CannotAnswer => "The data cannot answer".to_owned(),
    };
    let windows = counted(row.windows_used as usize, "window");
    let mut said = match (&row.since, &row.until) {
        (Some(since), Some(until)) if since != until => {
            format!("{says}, by {windows} of {since} to {until}.")
        }
        (Some(day), _) => format!("{says}, by {windows} of {day}."),
        _ => format!("{says}."),
    };
    if let Some(other) = row.overruled {
        let reason = row.override_reason.as_deref().unwrap_or("no reason");
        said += &format!(" A person's override decides: {other} ({reason}).");
    } else if let Some((class, test)) = row.test.zip(row.test_in_words())
        && class != VerdictClass::CannotTell
    {
        said += &format!(" {} decides: {class}.", orders::capital(&test));
    }
    if row.action == Action::CheckData && row.health != Health::Good && grade != Grade::CannotAnswer
    {
        said += " The newest data do not show whether the valve sticks.";
    }
    said
}

/// What to do, as in the list and on the map.
fn action(row: &LoopRow) -> String {
    let cause = |words: &str| match (row.alternative, row.alternative_likelihood) {
        (Some(cause), Some(p)) => format!("{words}: {}, {}.", cause.name(), percent(p)),
        _ => format!("{words}."),
    };
    match row.action {
        Action::Repair => format!("{}.", orders::action(row)),
        Action::Retune => cause("Retune the controller"),
        Action::LookUpstream => match row.group {
            Some(group) => format!("Look upstream, in group {group} of loops that swing together."),
            None => cause("Look upstream"),
        },
        Action::CheckData if row.health == Health::Good => cause("Check the data"),
        Action::CheckData => format!("Check the data: {}.", row.health.name()),
        Action::Leave if row.grade == Some(Grade::Unclear) && !row.is_decided() => match row.plan {
            Some(_) => "No work order this week.".to_owned(),
            None => "No work order this week. A valve test may decide.".to_owned(),
        },
        Action::Leave => "Leave the valve as it is.".to_owned(),
    }
}
