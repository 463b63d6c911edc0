//! Work orders of a week: one for each loop whose valve is to be repaired.

use crate::report::action::Action;
use crate::report::last_test::size_in_words;
use crate::report::ranking::{LoopRow, Ranking};
use crate::store::table::columns;
use stiction_diagnose::diagnose::change::Change;
use stiction_diagnose::diagnose::{Grade, VerdictClass};
use stiction_diagnose::spoken::{counted, percent, time};
use stiction_model::{always_written_by_name, named};

named! {
    /// The state of an order after the last test of the valve.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Status {
        /// No test has decided about the valve.
        #[default]
        Open = "open",
        /// By a test the valve sticks or does not respond.
        Confirmed = "confirmed",
        /// By a test the valve does not stick.
        Closed = "closed",
    }
}

always_written_by_name!(Status);

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
    /// Open, or confirmed or closed by a test.
    "status" [""] status: Status;
    /// Day of the order in the log, or else the first day of the windows on which the verdict rests.
    "opened" [""] opened: Option<String>;
    /// What is wrong, with the day.
    "finding" [""] finding: String;
    /// What to do at the valve.
    "action" [""] action: String;
    /// Evidence for the finding.
    "evidence" [""] evidence: String;
    /// The test that is due, or the day on which it was made.
    "test" [""] test: String;
    /// The last repair, order or note.
    "note" [""] note: Option<String>;
    /// Page of the loop, from the folder of the report on.
    "page" [""] page: Option<String>;
    /// Sheet of the test, from the folder of the report on.
    "sheet" [""] sheet: Option<String>;
}

columns! {
    /// A work order as a maintenance system (CMMS) imports it.
    pub struct WorkOrder;
    /// Tag of the loop.
    "tag" [""] tag: String;
    /// What is wrong, with the day.
    "description" [""] description: String;
    /// 1 (highest) to 4, by the priority of the order: from 1, from 0.3, from 0.1, and below.
    "priority" [""] priority: i64;
    /// What to do at the valve.
    "action" [""] action: String;
    /// The day of the order.
    "opened" [""] opened: Option<String>;
    /// Open, confirmed or closed.
    "status" [""] status: Status;
    /// Area of the plant.
    "area" [""] area: Option<String>;
    /// Unit of the plant.
    "unit" [""] unit: Option<String>;
    /// Evidence and test.
    "details" [""] details: String;
}

/// The least priority of an order in each class but the last.
const CLASSES: [f64; 3] = [1.0, 0.3, 0.1];

impl From<&Order> for WorkOrder {
    fn from(order: &Order) -> Self {
        Self {
            tag: order.name.clone(),
            description: capital(&order.finding),
            priority: 1 + CLASSES.iter().filter(|least| order.priority < **least).count() as i64,
            action: order.action.clone(),
            opened: order.opened.clone(),
            status: order.status,
            area: order.area.clone(),
            unit: order.unit.clone(),
            details: format!("Evidence: {}. Test: {}.", order.evidence, order.test),
        }
    }
}

/// A text with a capital at its beginning.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// The orders of a week, the most important first, and those that a test closed at the end. A snoozed loop has none.
pub fn orders(ranking: &Ranking<'_>) -> Vec<Order> {
    let rows = ranking.loops.iter().map(|ranked| &ranked.row);
    let rows: Vec<&LoopRow> = rows.filter(|row| !row.is_snoozed()).collect();
    let due = rows.iter().filter(|row| row.action == Action::Repair);
    due.chain(rows.iter().filter(|row| row.is_cleared())).map(|row| order(row)).collect()
}

/// Number of unclosed orders.
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
        opened: row.ordered.clone().or_else(|| row.since.clone()),
        finding: finding(row),
        action: action(row).to_owned(),
        evidence: evidence(row),
        test: test(row),
        note: row.note.clone(),
        page: row.page.clone(),
        sheet: row.sheet.clone(),
    }
}

/// What is wrong, with the day.
fn finding(row: &LoopRow) -> String {
    let by_test = row.test_in_words().unwrap_or_default();
    match status(row) {
        Status::Closed => return format!("the valve does not stick, by {by_test}"),
        Status::Confirmed => return format!("the valve {}, confirmed by {by_test}", verb(row)),
        Status::Open => {}
    }
    let found = match verb(row) {
        "sticks" => format!("the valve sticks{}", days(row)),
        "probably sticks" => format!("the valve probably sticks{}", days(row)),
        verb => format!("the valve, or its transmitter, {verb}{}", days(row)),
    };
    match &row.override_reason {
        Some(reason) if row.overruled.is_some() => {
            format!("{found}, as a person concluded: {reason}")
        }
        _ => found,
    }
}

/// What a valve does that is to be repaired.
fn verb(row: &LoopRow) -> &'static str {
    let confirmed = row.test.filter(|_| row.is_confirmed());
    match (row.overruled.or(confirmed), row.grade) {
        (Some(VerdictClass::DoesNotRespond), _) | (None, Some(Grade::DoesNotRespond)) => {
            "does not respond"
        }
        (Some(_), _) | (None, Some(Grade::Sticks)) => "sticks",
        (None, _) => "probably sticks",
    }
}

/// The days of a finding.
fn days(row: &LoopRow) -> String {
    match (row.change, &row.change_day, &row.since, &row.until) {
        (Change::New, Some(day), ..) => format!(", new since {day}"),
        (Change::Returned, Some(day), ..) => format!(", again since {day}"),
        (Change::StillSticks, Some(day), ..) => format!(", still after the repair of {day}"),
        (Change::Worse, Some(day), ..) => format!(", more since {day}"),
        (_, _, Some(since), Some(until)) if since != until => format!(", {since} to {until}"),
        (_, _, Some(day), _) => format!(", {day}"),
        _ => String::new(),
    }
}

/// What to do at the valve.
pub fn action(row: &LoopRow) -> &'static str {
    match (status(row), verb(row)) {
        (Status::Closed, _) => "None: a test cleared the valve",
        (_, "does not respond") => "Check air supply, positioner, actuator and transmitter",
        (Status::Confirmed, _) => "Repair the valve",
        (Status::Open, _) if row.overruled.is_some() => "Repair the valve",
        (Status::Open, _) if row.plan.as_ref().is_some_and(|plan| plan.starts_with(NONE)) => {
            "Make a signature of the valve at the next stop or record its position, and repair the valve if it sticks"
        }
        (Status::Open, _) => "Test the valve, and repair it if the test confirms stiction",
    }
}

/// The evidence, in a sentence.
fn evidence(row: &LoopRow) -> String {
    let mut parts = vec![];
    if let Some(p) = row.probability {
        let windows = counted(row.windows_used as usize, "window");
        parts.push(format!("probability {} from {windows}", percent(p)));
    }
    parts.extend(size_in_words("S", row.s, row.s_low, row.s_high));
    parts.extend(size_in_words("J", row.j, row.j_low, row.j_high));
    parts.extend(row.period_s.map(|period| format!("period {}", time(period))));
    parts.extend(row.change_in_words());
    parts.join("; ")
}

/// The test that is due, or the day of the last test.
fn test(row: &LoopRow) -> String {
    match (status(row), &row.plan) {
        (Status::Closed | Status::Confirmed, _) => {
            format!("made on {}", row.test_day.as_deref().unwrap_or("an unknown day"))
        }
        (Status::Open, Some(plan)) => plan.clone(),
        (Status::Open, None) => UNSIZED.to_owned(),
    }
}

const NONE: &str = "none possible: ";

/// The test of a loop that cannot have one.
pub fn impossible(why: &str) -> String {
    format!("{NONE}{why}")
}

/// The test of a loop whose data could not be read again.
const UNSIZED: &str = "in manual, turn the OP up and down by growing amounts until the PV responds, then by shrinking amounts \
                       (stiction test plan sizes the turns)";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_asks_for_no_test_that_cannot_be_made() {
        let row = LoopRow { action: Action::Repair, ..LoopRow::default() };
        assert!(action(&row).starts_with("Test the valve") && test(&row) == UNSIZED);
        let why = impossible("the loop is too slow");
        let slow = LoopRow { plan: Some(why.clone()), ..row.clone() };
        assert!(action(&slow).starts_with("Make a signature of the valve") && test(&slow) == why);
        let planned = LoopRow { plan: Some("10 sizes".to_owned()), ..slow };
        assert!(action(&planned).starts_with("Test the valve"));
    }
}
