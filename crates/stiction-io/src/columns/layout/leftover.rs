//! Unused columns and tags that may be a signal that a loop lacks. They are listed but not used.

use super::instrument::Instrument;
use super::plan::LoopPlan;
use crate::columns::role::{SEPARATORS, Signal};
use crate::names::list;
use crate::remedy::{Remedy, Wording};
use std::collections::HashMap;

/// The signals that a diagnosis needs most.
const WANTED: [Signal; 3] = [Signal::Pv, Signal::Sp, Signal::Mode];

/// The role by which the user gives `signal` of a loop.
fn role(each: &LoopPlan, signal: Signal, is_only: bool) -> String {
    let signal = signal.name().to_lowercase();
    match &each.name {
        Some(name) if !is_only => format!("{name}.{signal}"),
        _ => signal,
    }
}

/// For loops without PV, suggests the transmitters among `candidates` with the same loop number, and returns their
/// places.
pub fn offer_pairs(loops: &mut [LoopPlan], candidates: &[&str], wording: Wording) -> Vec<usize> {
    let mut offered = vec![];
    let tags: Vec<Option<Instrument>> =
        candidates.iter().map(|name| Instrument::of(name)).collect();
    let mut of_loop: HashMap<_, Vec<(usize, &Instrument)>> = HashMap::new();
    for (place, tag) in tags.iter().enumerate() {
        let Some(tag) = tag else { continue };
        of_loop.entry(tag.loop_key()).or_default().push((place, tag));
    }
    for each in loops.iter_mut().filter(|each| each.signal(Signal::Pv).is_none()) {
        let Some(name) = each.name.clone() else { continue };
        let Some(controller) = Instrument::of(&name) else { continue };
        for (place, tag) in of_loop.get(&controller.loop_key()).into_iter().flatten() {
            if tag.measures_for(&controller) {
                let candidate = candidates[*place];
                let note = format!(
                    "\"{candidate}\" is not used, but by its number it can be the PV of {name}, which has none; if \
                     it is, give {}",
                    wording.of(Remedy::map(role(each, Signal::Pv, false), candidate))
                );
                each.notes.push(note);
                offered.push(*place);
            }
        }
    }
    offered
}

/// Notes for loops without PV on PVs of loops without OP, which are not used either. A PV whose tag has another number
/// is not of the loop.
pub fn note_lone(loops: &mut [LoopPlan], lone: &[&str], wording: Wording) {
    let is_only = loops.len() == 1;
    let tags: Vec<Option<Instrument>> = lone.iter().map(|name| Instrument::of(name)).collect();
    for each in loops.iter_mut().filter(|each| each.signal(Signal::Pv).is_none()) {
        let own = each.name.as_deref().and_then(Instrument::of);
        let may_be = |tag: &Option<Instrument>| match (tag, &own) {
            (Some(tag), Some(own)) => tag.loop_key() == own.loop_key(),
            (tag, _) => is_only && tag.is_none(),
        };
        let own: Vec<&str> =
            lone.iter().zip(&tags).filter(|(_, tag)| may_be(tag)).map(|(name, _)| *name).collect();
        let Some(first) = own.first() else { continue };
        let note = format!(
            "the loop has no PV, while {} {} not used, because no OP has that name; if one is its PV, give {}",
            list(&own),
            if own.len() == 1 { "is" } else { "are" },
            wording.of(Remedy::map(role(each, Signal::Pv, is_only), first))
        );
        each.notes.push(note);
    }
}

/// Notes for loops without mode on unused columns or tags with words of modes. One whose name begins with that of
/// another loop belongs to that loop.
pub fn note_modes(loops: &mut [LoopPlan], unused: &[&str], wording: Wording) {
    let is_only = loops.len() == 1;
    let begins = |name: &str, each: &LoopPlan| {
        let of = each.name.as_ref().map(|of| of.to_lowercase());
        let name = name.to_lowercase();
        of.and_then(|of| name.strip_prefix(&of)).is_some_and(|rest| rest.starts_with(SEPARATORS))
    };
    for name in unused {
        let place = loops.iter().position(|each| begins(name, each)).unwrap_or(0);
        let Some(each) = loops.get_mut(place).filter(|each| each.signal(Signal::Mode).is_none())
        else {
            continue;
        };
        each.notes.push(format!(
            "\"{name}\" holds words of modes and is not used, while the loop has no mode; if it is its mode, give {}",
            wording.of(Remedy::map(role(each, Signal::Mode, is_only), name))
        ));
    }
}

/// The note on unused numeric columns or tags. If a loop lacks a signal that they could be, it shows how to assign
/// them.
pub fn note(loops: &[LoopPlan], unused: &[&str], wording: Wording) -> Option<String> {
    let first = unused.first()?;
    let lacks = |each: &LoopPlan, signal: Signal| each.signal(signal).is_none();
    let missing: Vec<Signal> =
        WANTED.into_iter().filter(|signal| loops.iter().any(|each| lacks(each, *signal))).collect();
    let holds = match unused.len() {
        1 => "holds numbers and is not used",
        _ => "hold numbers and are not used",
    };
    let poor = missing.first().and_then(|signal| loops.iter().find(|each| lacks(each, *signal)));
    let (Some(signal), Some(poor)) = (missing.first(), poor) else {
        return Some(format!("{} {holds}", list(unused)));
    };
    let whose = match (loops.len(), &poor.name) {
        (1, None) => "the loop has".to_owned(),
        (1, Some(name)) => format!("loop {name} has"),
        (_, _) => "some loops have".to_owned(),
    };
    let missing: Vec<String> =
        missing.iter().map(|signal| format!("no {}", signal.name())).collect();
    Some(format!(
        "{} {holds}, while {whose} {}; if one is such a signal, assign it, as in {}",
        list(unused),
        missing.join(", "),
        wording.of(Remedy::map(role(poor, *signal, loops.len() == 1), first))
    ))
}
