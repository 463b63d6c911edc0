//! What could not be made a column.

use super::candidate::candidate;
use super::given::Given;
use super::plan::{LoopPlan, Plan, Recognised};
use crate::columns::role::{Role, Signal};
use crate::names::list;
use crate::remedy::Remedy;
use crate::sheet::{LeftOut, Sheet};
use std::collections::{BTreeMap, HashMap};

/// How many reasons why something is no column have a note of their own; the list of columns has them all.
const MOST_REASONS: usize = 20;

/// Names what could not be made a column. A loop is not judged on half of its signals: where one of them is left out,
/// and nothing stands for it, the loop is not read. A mode is no such signal, and neither is what is empty or single.
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
            // What tells no loop belongs to the only one.
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
                    "has \"{name}\", by its name the {}, but it {why}; mend it, or leave it out with {}",
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
            names => format!("{} are not used: each {why}", list(names)),
        });
    }
    if !more.is_empty() {
        plan.notes.push(format!("{} are not used, for other reasons", list(&more)));
    }
}
