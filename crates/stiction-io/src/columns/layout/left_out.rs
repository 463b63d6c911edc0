//! Data that could not become a column.

use super::candidate::candidate;
use super::given::Given;
use super::plan::{LoopPlan, Plan, Recognised};
use crate::columns::role::{Role, Signal};
use crate::names::list;
use crate::remedy::Remedy;
use crate::sheet::{LeftOut, Sheet};
use std::collections::{BTreeMap, HashMap};

/// Number of reasons with a separate note. The list of columns has all reasons.
const MOST_REASONS: usize = 20;

/// Names the data that could not become a column. A loop with such a signal is not read, unless another column
/// replaces the signal. Modes, and empty or single values, do not count as such signals.
pub fn name_left_out(sheet: &Sheet, given: &Given<'_>, plan: &mut Plan) {
    let lower = |name: &Option<String>| name.as_ref().map(|name| name.to_lowercase());
    let mut places: HashMap<Option<String>, usize> =
        plan.loops.iter().enumerate().map(|(place, each)| (lower(&each.name), place)).collect();
    let mut by_reason: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for LeftOut { name, why, holds_samples } in &sheet.left_out {
        let found = candidate(name, given);
        let role = found.as_ref().map_or(Role::Ignored, |found| found.role);
        let is_given = found.as_ref().is_some_and(|found| found.given);
        let loop_name = found.and_then(|found| found.loop_name);
        plan.recognised.push(Recognised {
            part: String::new(),
            column: name.clone(),
            role: Role::Ignored,
            loop_name: loop_name.clone(),
            why: format!("it {why}"),
        });
        if is_given && role == Role::Ignored {
            continue;
        }
        if let Role::Signal(signal) = role
            && signal != Signal::Mode
            && (*holds_samples || is_given)
        {
            let only = plan.loops.first().filter(|_| plan.loops.len() == 1);
            // Data without a loop name belong to the only loop.
            let is_only = only.is_some_and(|only| only.name.is_none() || loop_name.is_none());
            let place = match places.get(&lower(&loop_name)) {
                Some(place) => *place,
                None if is_only => 0,
                None => {
                    plan.loops.push(LoopPlan { name: loop_name.clone(), ..LoopPlan::default() });
                    places.insert(lower(&loop_name), plan.loops.len() - 1);
                    plan.loops.len() - 1
                }
            };
            if plan.loops[place].signal(signal).is_none() {
                plan.loops[place].unread.get_or_insert(format!(
                    "has \"{name}\", which is the {} by its name, but it {why}; correct the column, or leave it out with {}",
                    signal.name(),
                    given.options.wording.of(Remedy::map("ignore", name))
                ));
                continue;
            }
        }
        by_reason.entry(why).or_default().push(name);
    }
    let more: Vec<&str> = by_reason.values().skip(MOST_REASONS).flatten().copied().collect();
    for (why, names) in by_reason.iter().take(MOST_REASONS) {
        plan.notes.push(match &names[..] {
            [name] => format!("\"{name}\" {why} and is not used"),
            names => format!("{} are not used, because each {why}", list(names)),
        });
    }
    if !more.is_empty() {
        plan.notes.push(format!("{} are not used, for other reasons", list(&more)));
    }
}
