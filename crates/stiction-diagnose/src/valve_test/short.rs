//! A plan in one sentence, for a work list.

use super::plan::{TestPlan, roughly};
use crate::spoken::{rough, time};

/// The sizes and holds of a plan.
pub fn short(plan: &TestPlan) -> String {
    let sizes: Vec<String> =
        plan.grow.iter().step_by(plan.each).map(|turn| rough(2.0 * turn.op.abs())).collect();
    let (expected, most) = (roughly(plan.expected_s), time(plan.total_s));
    let lasts = match expected == most {
        true => format!("{most} at most"),
        false => format!("some {expected}, {most} at most"),
    };
    format!(
        "in manual for {lasts}, turn the OP up and down by {} %, {} turns each, held until the PV \
         answers or for {} at most; then repeat with each size {:.0} % smaller",
        sizes.join(", "),
        plan.each,
        holds(plan),
        100.0 * (1.0 - plan.shrink_by)
    )
}

/// The longest holds of the first part, such as `30 s to 74 s`.
pub(super) fn holds(plan: &TestPlan) -> String {
    let holds = plan.grow.iter().map(|turn| turn.hold_s);
    let (least, most) = holds.fold((f64::INFINITY, 0.0f64), |(a, b), h| (a.min(h), b.max(h)));
    match (time(least), time(most)) {
        (one, other) if one == other => one,
        (least, most) => format!("{least} to {most}"),
    }
}
