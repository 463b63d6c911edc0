//! Work orders: what a week asks to be done at valves, one a loop that is to be repaired.

use crate::report::action::Action;
use crate::report::ranking::{LoopRow, Ranking};
use crate::store::table::{columns, named_cell, written_by_name};
use stiction_diagnose::diagnose::{Grade, VerdictClass};
use stiction_diagnose::spoken::{counted, percent, rough, time};

/// What a test of the valve made of an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Status {
    /// No test says anything of it.
    #[default]
    Open,
    /// A test says that the valve sticks, or does not respond.
    Confirmed,
    /// A test says that the valve does not stick.
    Closed,
}

named_cell!(Status);
written_by_name!(Status);

impl Status {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Open, Self::Confirmed, Self::Closed];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Confirmed => "confirmed",
            Self::Closed => "closed",
        }
    }
}

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
    /// What a test made of it: open, confirmed or closed.
    "status" [""] status: Status;
    /// What is wrong.
    "finding" [""] finding: String;
    /// What says so.
    "evidence" [""] evidence: String;
    /// The test that is due, or when it was made.
    "test" [""] test: String;
    /// The last repair, order or note.
    "note" [""] note: Option<String>;
    /// Page of the loop, from the folder of the report on.
    "page" [""] page: Option<String>;
    /// Sheet of the test, from the folder of the report on.
    "sheet" [""] sheet: Option<String>;
}

/// The orders of a week, the most important first, and those that a test closed at the end. What is snoozed has none.
pub fn orders(ranking: &Ranking<'_>) -> Vec<Order> {
    let rows = ranking.loops.iter().map(|ranked| &ranked.row);
    let rows: Vec<&LoopRow> = rows.filter(|row| !row.is_snoozed()).collect();
    let due = rows.iter().filter(|row| row.action == Action::Repair);
    due.chain(rows.iter().filter(|row| row.is_cleared())).map(|row| order(row)).collect()
}

/// How many of them are still to be done.
pub fn to_do(orders: &[Order]) -> usize {
    orders.iter().filter(|order| order.status != Status::Closed).count()
}

fn status(row: &LoopRow) -> Status {
    match () {
        () if row.is_cleared() => Status::Closed,
        () if row.is_confirmed() && row.overruled.is_none() => Status::Confirmed,
        () => Status::Open,
    }
}

fn order(row: &LoopRow) -> Order {
    Order {
        name: row.name.clone(),
        area: row.area.clone(),
        unit: row.unit.clone(),
        priority: row.priority,
        status: status(row),
        finding: finding(row),
        evidence: evidence(row),
        test: test(row),
        note: row.note.clone(),
        page: row.page.clone(),
        sheet: row.sheet.clone(),
    }
}

fn finding(row: &LoopRow) -> String {
    let by_test = row.test_in_words().unwrap_or_default();
    match status(row) {
        Status::Closed => return format!("the valve does not stick, by {by_test}"),
        Status::Confirmed => {
            let what = match row.test {
                Some(VerdictClass::DoesNotRespond) => "the valve does not respond",
                _ => "the valve sticks",
            };
            return format!("{what}, confirmed by {by_test}");
        }
        Status::Open => {}
    }
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

/// The test that is due, or that was made.
fn test(row: &LoopRow) -> String {
    match (status(row), &row.plan) {
        (Status::Closed | Status::Confirmed, _) => {
            format!("made on {}", row.test_day.as_deref().unwrap_or("a day that is not known"))
        }
        (Status::Open, Some(plan)) => plan.clone(),
        (Status::Open, None) => UNSIZED.to_owned(),
    }
}

/// The test of a loop whose page was not made.
const UNSIZED: &str = "in manual, turns of the OP to and fro that grow until the PV answers, then shrink; the report has the \
                       sheet where it has a page of the loop, and `stiction test plan` sizes it for any other";
