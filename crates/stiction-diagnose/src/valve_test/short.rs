//! A plan in one sentence, for a work list.

use super::plan::TestPlan;
use crate::spoken::{rough, time};

/// The sizes and holds of a plan.
pub fn short(plan: &TestPlan) -> String {
    let sizes: Vec<String> =
        plan.grow.iter().step_by(plan.each).map(|turn| rough(2.0 * turn.op.abs())).collect();
    let holds = plan.grow.iter().map(|turn| turn.hold_s);
    let (least, most) = holds.fold((f64::INFINITY, 0.0f64), |(a, b), h| (a.min(h), b.max(h)));
    format!(
        "in manual, turn the OP up and down by {} %, {} turns each, until the PV answers; hold each for {} to {} at most; \
         then make each size {:.0} % smaller",
        sizes.join(", "),
        plan.each,
        time(least),
        time(most),
        100.0 * (1.0 - plan.shrink_by)
    )
}
