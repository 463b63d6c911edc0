//! Work orders: what a week asks to be done at valves, one a loop that is to be repaired.

use crate::report::action::Action;
use crate::report::ranking::{LoopRow, Ranking};
use crate::store::table::columns;
use stiction_diagnose::diagnose::{Grade, VerdictClass};
use stiction_diagnose::recording::LoopType;
use stiction_diagnose::spoken::{counted, percent, rough, time};

/// The smallest and the largest step that a test asks for, percent of span.
const STEPS: (f64, f64) = (0.25, 5.0);
/// Steps a stick band is divided into.
const STEPS_IN_BAND: f64 = 3.0;
/// The step where S is not known, percent of span.
const STEP: f64 = 0.5;

columns! {
    /// A work order that a week proposes.
    pub struct Order;
    /// Tag of the loop.
    "loop" [""] name: String;
    /// Area of the plant.
    "area" [""] area: Option<String>;
    /// Unit of the plant.
    "unit" [""] unit: Option<String>;
    /// Weight times severity times probability.
    "priority" [""] priority: f64;
    /// What is wrong.
    "finding" [""] finding: String;
    /// What says so.
    "evidence" [""] evidence: String;
    /// The test that would confirm it.
    "test" [""] test: String;
    /// The last repair, order or note.
    "note" [""] note: Option<String>;
    /// Page of the loop, from the folder of the report on.
    "page" [""] page: Option<String>;
}

/// The orders of a week, the most important first. What is snoozed has none.
pub fn orders(ranking: &Ranking<'_>) -> Vec<Order> {
    let rows = ranking.loops.iter().map(|ranked| &ranked.row);
    rows.filter(|row| row.action == Action::Repair && !row.is_snoozed()).map(order).collect()
}

fn order(row: &LoopRow) -> Order {
    Order {
        name: row.name.clone(),
        area: row.area.clone(),
        unit: row.unit.clone(),
        priority: row.priority,
        finding: finding(row),
        evidence: evidence(row),
        test: test(row),
        note: row.note.clone(),
        page: row.page.clone(),
    }
}

fn finding(row: &LoopRow) -> String {
    let found = match (row.overruled, row.grade) {
        (Some(VerdictClass::DoesNotRespond), _) | (None, Some(Grade::DoesNotRespond)) => {
            "the valve, or its transmitter, does not respond"
        }
        (Some(_), _) | (None, Some(Grade::Sticks)) => "the valve sticks",
        (None, _) => "the valve probably sticks; test it first",
    };
    match &row.override_reason {
        Some(reason) if row.overruled.is_some() => {
            format!("{found}, as a person concluded: {reason}")
        }
        _ => found.to_owned(),
    }
}

/// What says so, in a sentence.
fn evidence(row: &LoopRow) -> String {
    let range = |low: Option<f64>, high: Option<f64>| match low.zip(high) {
        Some((low, high)) => format!(" ({} to {})", rough(low), rough(high)),
        None => String::new(),
    };
    let mut parts = vec![];
    if let Some(p) = row.probability {
        let windows = counted(row.windows_judged as usize, "window");
        parts.push(format!("probability {} by {windows}", percent(p)));
    }
    if let Some(s) = row.s {
        parts.push(format!("S {} %{}", rough(s), range(row.s_low, row.s_high)));
    }
    if let Some(j) = row.j {
        parts.push(format!("J {} %{}", rough(j), range(row.j_low, row.j_high)));
    }
    if let Some(period) = row.period_s {
        parts.push(format!("swings every {}", time(period)));
    }
    if let Some(day) = &row.change_day {
        parts.push(format!("{} since {day}", row.change.name()));
    }
    parts.join("; ")
}

/// The test that would confirm it, sized as far as the row tells; the page of the loop has it in full.
fn test(row: &LoopRow) -> String {
    let step = row.s.map_or(STEP, |s| (s / STEPS_IN_BAND).clamp(STEPS.0, STEPS.1));
    let wait = row.period_s.map_or(String::new(), |p| format!(", {} each", time(p / 2.0)));
    let integrates = [LoopType::Level, LoopType::OtherIntegrating].map(LoopType::name);
    match integrates.contains(&&*row.loop_type) {
        true => format!(
            "in manual, pulses of the output of {} %, {} % and so on, away and back{wait}: a valve that sticks \
             answers none until they exceed its stick band",
            rough(step),
            rough(2.0 * step)
        ),
        false => format!(
            "in manual, steps of the output by {} % up, and the same down{wait}: a valve that sticks does nothing \
             for two or three of them, then jumps",
            rough(step)
        ),
    }
}
