//! Assigns names to signals of loops.

use super::assigned::{
    Assigned, join_acquisition, join_by_instrument, join_the_nameless, join_the_rest,
    keep_those_with_op, leave_out_missing,
};
use super::candidate::{Candidate, candidate};
use super::content::Content;
use super::given::{Given, conflict, cv_beside_mv};
use super::leftover;
use super::neighbours::{
    settle_co, settle_mv, settle_sp, take_letters, take_qualities, take_quantity, take_switches,
};
use super::plan::{LoopPlan, MissingLoop, Recognised};
use crate::columns::role::{Role, Signal};
use crate::error::Result;
use std::collections::{HashMap, HashSet};

/// Assigns each of the `names`, except the columns about `rows`, to a signal of a loop.
pub fn assign(
    content: &Content<'_>,
    names: &[&str],
    rows: &[usize],
    missing: Vec<MissingLoop>,
    given: &Given<'_>,
) -> Result<Assigned> {
    let options = given.options;
    let mut candidates: Vec<Option<Candidate>> =
        names.iter().map(|name| candidate(name, given)).collect();
    take_letters(&mut candidates, names);
    let mut notes = settle_co(&mut candidates, names, options.wording);
    settle_sp(&mut candidates, names);
    let settled = settle_mv(&mut candidates, names, options.wording);
    take_qualities(&mut candidates, names, options.wording, &mut notes);
    take_switches(&mut candidates, names, content);
    take_quantity(&mut candidates, names, content, options.wording, &mut notes);
    let rest = || (0..names.len()).filter(|i| candidates[*i].is_none() && !rows.contains(i));
    let is_unused = |i: &usize| content.is_numeric(*i) && !content.is_about_rows(*i);
    let unused: Vec<usize> = rest().filter(is_unused).collect();
    // A quality of a name without signals, such as that of FIC101.Controller Status, may be a mode.
    let key = |c: &Candidate| c.loop_name.as_ref().map(|name| name.to_lowercase());
    let is_signal = |c: &&Candidate| matches!(c.role, Role::Signal(_));
    let with_signals: HashSet<_> = candidates.iter().flatten().filter(is_signal).map(key).collect();
    let is_lone = |i: &usize| {
        candidates[*i].as_ref().is_some_and(|c| {
            c.role == Role::Quality(None)
                && c.loop_name.is_some()
                && !with_signals.contains(&key(c))
        })
    };
    let lone = (0..names.len()).filter(is_lone);
    let modes = rest().chain(lone).filter(|i| content.is_modes(*i));
    let modes: Vec<&str> = modes.map(|i| names[i]).collect();
    let qualities: Vec<&str> =
        rest().filter(|i| content.is_qualities(*i, names[*i])).map(|i| names[i]).collect();

    let is_ambiguous = |i: &usize| candidates[*i].as_ref().is_some_and(|c| c.is_cv || c.is_mv);
    let ambiguous: HashSet<usize> = (0..names.len()).filter(is_ambiguous).collect();
    let loops = loops(&mut candidates, settled, names, content, given)?;
    let recognised = names.iter().zip(candidates).map(|(name, candidate)| match candidate {
        Some(candidate) => Recognised {
            part: String::new(),
            column: (*name).to_owned(),
            role: candidate.role,
            loop_name: candidate.loop_name,
            why: candidate.why,
        },
        None => Recognised {
            part: String::new(),
            column: (*name).to_owned(),
            role: Role::Ignored,
            loop_name: None,
            why: "it is not the name of a signal of a loop".to_owned(),
        },
    });
    let mut assigned = Assigned { loops, recognised: recognised.collect(), missing, notes };
    join_by_instrument(&mut assigned);
    join_the_nameless(&mut assigned);
    join_acquisition(&mut assigned, names);
    join_the_rest(&mut assigned, names, given);
    for each in assigned.loops.iter().filter(|each| each.signal(Signal::Pv).is_none()) {
        if let (Some(op), Some(vp)) = (each.signal(Signal::Op), each.signal(Signal::Vp))
            && ambiguous.contains(&op)
            && ambiguous.contains(&vp)
        {
            return Err(cv_beside_mv(content.sheet, names[op], names[vp], options.wording));
        }
    }
    leave_out_missing(&mut assigned);
    let offered = leftover::offer_relatives(&mut assigned, names, &unused, options.wording);
    let lone = keep_those_with_op(&mut assigned);
    let is_offered = |i: &usize| offered.contains(i);
    for signal in leftover::WANTED {
        let lone = lone.iter().filter(|(of, i)| *of == signal && !is_offered(i));
        let lone: Vec<&str> = lone.map(|(_, i)| names[*i]).collect();
        leftover::note_lone(&mut assigned.loops, signal, &lone, options.wording);
    }
    leftover::note_modes(&mut assigned.loops, &modes, options.wording);
    let first = qualities.first();
    if let Some(role) = first.and_then(|name| leftover::quality_role(&assigned.loops, name)) {
        assigned.notes.push(leftover::note_qualities(&qualities, role, options.wording));
    }
    let unused: Vec<usize> = unused.into_iter().filter(|i| !is_offered(i)).collect();
    let note = leftover::note(&assigned.loops, &unused, names, content, options.wording);
    assigned.notes.extend(note);
    Ok(assigned)
}

/// The loops of the candidates, each at the place of its role, with the decisions as notes. A candidate is ignored if
/// its place is already given.
fn loops(
    candidates: &mut [Option<Candidate>],
    settled: Vec<(usize, String)>,
    names: &[&str],
    content: &Content<'_>,
    given: &Given<'_>,
) -> Result<Vec<LoopPlan>> {
    let mut loops: Vec<LoopPlan> = vec![];
    let mut places: HashMap<Option<String>, usize> = HashMap::new();
    for candidate in candidates.iter().flatten() {
        let mut plan = LoopPlan { name: candidate.loop_name.clone(), ..LoopPlan::default() };
        if plan.place(candidate.role).is_some() {
            places
                .entry(candidate.loop_name.as_ref().map(|name| name.to_lowercase()))
                .or_insert_with(|| {
                    loops.push(plan);
                    loops.len() - 1
                });
        }
    }
    for (i, note) in settled {
        let of = candidates[i].as_ref().and_then(|candidate| candidate.loop_name.as_ref());
        if let Some(place) = places.get(&of.map(|name| name.to_lowercase())) {
            loops[*place].notes.push(note);
        }
    }
    // Given roles come first. Names recognised for their places are then not used.
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|i| candidates[*i].as_ref().is_some_and(|c| !c.given));
    for i in order {
        let Some(candidate) = &mut candidates[i] else { continue };
        let key = candidate.loop_name.as_ref().map(|name| name.to_lowercase());
        let Some(plan) = places.get(&key).map(|place| &mut loops[*place]) else { continue };
        let name = plan.name.clone();
        let Some(place) = plan.place(candidate.role) else { continue };
        match *place {
            None => *place = Some(i),
            Some(other) if given.mapped(names[other]).is_some() && !candidate.given => {
                candidate.why = format!("\"{}\" is given as the {}", names[other], candidate.role);
                candidate.role = Role::Ignored;
            }
            Some(other) => {
                let (a, b) = (names[other.min(i)], names[other.max(i)]);
                let role = candidate.role;
                return Err(conflict(
                    content.sheet,
                    &role.to_string(),
                    name.as_deref(),
                    a,
                    b,
                    role.option_name(),
                    given.options.wording,
                ));
            }
        }
    }
    Ok(loops)
}
