//! An operator who carries out a test plan exactly as written.
//!
//! # Limits
//! It does not watch the limits of the PV: the process of the exercise tolerates every turn of its plan.

use super::{Hand, LONGEST_S, Run, SETS};
use crate::calls::Answer;
use stiction_diagnose::series::mean;
use stiction_diagnose::valve_test::TestPlan;

/// The part of the operation that gives the OP about which the turns go, s.
const REST_S: f64 = 60.0;
/// Number of samples of the PV that are averaged, as it is noisy.
const SEEN: usize = 5;
/// The smallest turn of the second part, percent of span.
const SMALLEST: f64 = 0.2;
/// The least number of answered turns in the second part, if the PV answers the turns and not the load.
const ENOUGH: usize = 2;
/// The loop is recorded in automatic after the test, s.
const AFTER_S: f64 = 30.0;

struct Operator<'a> {
    run: Run,
    plan: &'a TestPlan,
    /// OP about which it turns, percent of span.
    rest: f64,
    up: bool,
    sets: Vec<Hand>,
}

/// A turn that was held.
struct Held {
    /// Whether the PV moved by the answer of the plan.
    answered: bool,
    /// Whether the PV moved in the direction of the turn.
    went_along: bool,
    time_s: f64,
}

/// Continues a run by its plan; returns the sets.
pub(super) fn carry_out(run: Run, plan: &TestPlan) -> Answer<(Run, Vec<Hand>)> {
    let samples = (REST_S / run.live.sample_time()) as usize;
    let op = &run.done.op;
    let rest = (10.0 * mean(&op[op.len().saturating_sub(samples)..])).round() / 10.0;
    let up = plan.grow.first().is_none_or(|turn| turn.op > 0.0);
    let mut operator = Operator { run, plan, rest, up, sets: vec![] };
    let mut from = 0;
    while let Some((at, soon_s)) = operator.grow(from)? {
        if operator.shrink(2.0 * plan.grow[at].op.abs(), soon_s)? >= ENOUGH {
            break;
        }
        // What looked like answers was the load.
        from = at + plan.each;
    }
    operator.set(None);
    let end = operator.run.time_s() + AFTER_S;
    operator.run.go_to(end.min(LONGEST_S))?;
    Ok((operator.run, operator.sets))
}

impl Operator<'_> {
    fn set(&mut self, op: Option<f64>) {
        self.sets.push(Hand { at_s: self.run.time_s(), op });
        self.run.live.by_hand(op);
    }

    /// The averaged PV.
    fn pv(&self) -> f64 {
        let pv = &self.run.done.pv;
        mean(&pv[pv.len().saturating_sub(SEEN)..])
    }

    /// Turns of a size; fewer if the exercise is over. Each turn is held until the PV responds, and at least as long as
    /// the first turn of the plan, so that the whole response is recorded.
    fn turns(&mut self, count: usize, size: f64, hold_s: f64) -> Answer<Vec<Held>> {
        let mut all = vec![];
        let least_s = self.plan.grow.first().map_or(0.0, |turn| turn.hold_s);
        let room = |at: &Self| at.run.time_s() + hold_s + AFTER_S <= LONGEST_S;
        while all.len() < count && room(self) && self.sets.len() + 1 < SETS {
            let sign = if self.up { 1.0 } else { -1.0 };
            let op = self.plan.centre(self.rest, size) + 0.5 * sign * size;
            let before = self.pv();
            let op = op.clamp(self.plan.op_low, self.plan.op_high);
            self.set(Some((100.0 * op).round() / 100.0));
            self.up = !self.up;
            let from_s = self.run.time_s();
            let (mut moved, mut time_s) = (0.0, 0.0);
            while time_s < hold_s && (moved < self.plan.answer || time_s < least_s) {
                self.run.go_to(self.run.time_s() + self.run.live.sample_time())?;
                (moved, time_s) = (sign * (self.pv() - before), self.run.time_s() - from_s);
            }
            let (answered, went_along) = (moved >= self.plan.answer, moved > 0.0);
            all.push(Held { answered, went_along, time_s });
        }
        Ok(all)
    }

    /// Part 1, from this turn of the plan on. Returns the turn at which the PV follows all turns, and the time of the
    /// slowest response, s.
    fn grow(&mut self, from: usize) -> Answer<Option<(usize, f64)>> {
        let each = self.plan.each;
        for at in (from..self.plan.grow.len()).step_by(each) {
            let first = self.plan.grow[at];
            let (size, hold_s) = (2.0 * first.op.abs(), first.hold_s);
            let mut held = self.turns(each, size, hold_s)?;
            if held.len() < each || !held.iter().all(|turn| turn.answered) {
                continue;
            }
            held.extend(self.turns(each, size, hold_s)?);
            let answers = held.iter().filter(|turn| turn.answered).map(|turn| turn.time_s);
            let soon_s = answers.clone().fold(0.0, f64::max);
            let all = held.len() == 2 * each && held.iter().all(|turn| turn.went_along);
            if all && answers.count() > each {
                return Ok(Some((at, soon_s)));
            }
        }
        Ok(None)
    }

    /// Part 2: turns that shrink until some sizes in a row are not answered; how many were answered.
    fn shrink(&mut self, from: f64, soon_s: f64) -> Answer<usize> {
        let (mut size, mut silent, mut seen) = (self.plan.shrink_by * from, 0, 0);
        while silent < self.plan.ends_after && size > SMALLEST {
            let held = self.turns(self.plan.each, size, 2.0 * soon_s)?;
            if held.is_empty() {
                break;
            }
            let answered = held.iter().filter(|turn| turn.answered).count();
            seen += answered;
            silent = if answered > 0 { 0 } else { silent + 1 };
            size *= self.plan.shrink_by;
        }
        Ok(seen)
    }
}
