//! Unused columns and tags that may be a signal that a loop lacks. They are listed but not used.

use super::assigned::Assigned;
use super::content::Content;
use super::instrument::Instrument;
use super::plan::LoopPlan;
use crate::columns::role::{SEPARATORS, Signal};
use crate::names::list;
use crate::remedy::{Remedy, Wording};
use std::collections::{HashMap, HashSet};

/// The signals that a diagnosis needs most.
pub const WANTED: [Signal; 4] = [Signal::Pv, Signal::Sp, Signal::Vp, Signal::Mode];

/// The role by which the user gives `signal` of a loop.
fn role(each: &LoopPlan, signal: Signal, is_only: bool) -> String {
    let signal = signal.name().to_lowercase();
    match &each.name {
        Some(name) if !is_only => format!("{name}.{signal}"),
        _ => signal,
    }
}

/// A name that may be a signal of a loop with a different name.
struct Relative {
    name: usize,
    /// The signal by its name, and the loop that has it; none of unused names.
    of: Option<(Signal, usize)>,
    tag: Instrument,
}

impl Relative {
    fn may_be(&self, signal: Signal, controller: &Instrument) -> bool {
        match (signal, self.of.map(|(signal, _)| signal)) {
            (Signal::Pv, None | Some(Signal::Pv)) => self.tag.measures_for(controller),
            (Signal::Op, Some(Signal::Op)) => self.tag.is_driven_by(controller),
            // Another block of the controller may have the position.
            (Signal::Vp, Some(Signal::Vp)) => {
                self.tag == *controller
                    || self.tag.is_driven_by(controller)
                    || self.tag.is_position_for(controller)
            }
            (Signal::Vp, None | Some(Signal::Pv)) => self.tag.is_position_for(controller),
            _ => false,
        }
    }
}

/// Offers loops the signals that they lack and that may belong to them by their tags: the PV of a transmitter, the OP
/// and VP of a valve, or a measured position. They are `unused`, or of a loop without OP or without PV. Returns their
/// names.
pub fn offer_relatives(
    assigned: &mut Assigned,
    names: &[&str],
    unused: &[usize],
    wording: Wording,
) -> HashSet<usize> {
    let Assigned { loops, notes, .. } = assigned;
    let tag = |each: &LoopPlan| each.name.as_deref().and_then(Instrument::of);
    let incomplete = loops.iter().enumerate().flat_map(|(place, each)| {
        let signals = match (each.has_op(), each.signal(Signal::Pv)) {
            (true, Some(_)) => &[][..],
            (false, Some(_)) => &[Signal::Pv],
            (_, None) => &[Signal::Op, Signal::Vp],
        };
        signals.iter().filter_map(move |signal| {
            let of = Some((*signal, place));
            Some(Relative { name: each.signal(*signal)?, of, tag: tag(each)? })
        })
    });
    let unused = unused.iter().filter_map(|name| {
        Some(Relative { name: *name, of: None, tag: Instrument::of(names[*name])? })
    });
    let mut relatives: HashMap<_, Vec<Relative>> = HashMap::new();
    for each in incomplete.chain(unused) {
        relatives.entry(each.tag.place()).or_default().push(each);
    }
    let (mut offered, mut found) = (vec![], HashSet::new());
    for (place, each) in loops.iter().enumerate() {
        let Some((name, controller)) = each.name.as_ref().zip(tag(each)) else { continue };
        let wanted = match (each.has_op(), each.signal(Signal::Pv)) {
            (true, None) => &[Signal::Pv][..],
            (_, Some(_)) => &[Signal::Op, Signal::Vp],
            (false, None) => &[],
        };
        for signal in wanted.iter().filter(|signal| each.signal(**signal).is_none()) {
            let all = relatives.get(&controller.place()).into_iter().flatten();
            for relative in all.filter(|relative| relative.may_be(*signal, &controller)) {
                let candidate = names[relative.name];
                let note = format!(
                    "by its tag, \"{candidate}\" can be the {0} of {name}, which has no {0}; if this is right, give {1}",
                    signal.name(),
                    wording.of(Remedy::map(role(each, *signal, false), candidate))
                );
                let owner = relative.of.map(|(_, owner)| owner);
                let reader =
                    [Some(place), owner].into_iter().flatten().find(|place| loops[*place].has_op());
                offered.push((reader, note));
                // With the OP of the valve, the loop uses its own PV.
                found.extend([Some(relative.name), each.signal(Signal::Pv)].into_iter().flatten());
            }
        }
    }
    for (reader, note) in offered {
        reader.map_or(&mut *notes, |place| &mut loops[place].notes).push(note);
    }
    found
}

/// Notes for loops without `signal` on such signals of loops without OP, which are not used either. A name whose tag has
/// another number is not of the loop, unless it begins with the name of the loop.
pub fn note_lone(loops: &mut [LoopPlan], signal: Signal, lone: &[&str], wording: Wording) {
    let is_only = loops.len() == 1;
    let tags: Vec<Option<Instrument>> = lone.iter().map(|name| Instrument::of(name)).collect();
    for each in loops.iter_mut().filter(|each| each.signal(signal).is_none()) {
        let own = each.name.as_deref().and_then(Instrument::of);
        let may_be = |(name, tag): &(&&str, &Option<Instrument>)| match (tag, &own) {
            _ if each.name.as_ref().is_some_and(|of| begins(name, of)) => true,
            (Some(tag), Some(own)) => tag.loop_key() == own.loop_key(),
            (tag, _) => is_only && tag.is_none(),
        };
        let own: Vec<&str> = lone.iter().zip(&tags).filter(may_be).map(|(name, _)| *name).collect();
        let Some(first) = own.first() else { continue };
        let note = format!(
            "the loop has no {0}, while {1} {2} not used, because no OP has that name; if one of them is the {0} of the loop, give {3}",
            signal.name(),
            list(&own),
            if own.len() == 1 { "is" } else { "are" },
            wording.of(Remedy::map(role(each, signal, false), first))
        );
        each.notes.push(note);
    }
}

/// Whether `name` is `of`, a separator and more.
pub fn begins(name: &str, of: &str) -> bool {
    let start = name.get(..of.len()).filter(|_| !of.is_empty());
    start.is_some_and(|start| start.eq_ignore_ascii_case(of))
        && name[of.len()..].starts_with(SEPARATORS)
}

/// The place of the loop with whose name `name` begins, or of the first.
fn loop_of(loops: &[LoopPlan], name: &str) -> usize {
    let is_it = |each: &LoopPlan| each.name.as_ref().is_some_and(|of| begins(name, of));
    loops.iter().position(is_it).unwrap_or(0)
}

/// The role by which the user gives `name` as the quality of a signal; none without loops.
pub fn quality_role(loops: &[LoopPlan], name: &str) -> Option<String> {
    let each = loops.get(loop_of(loops, name))?;
    Some(role(each, Signal::Pv, loops.len() == 1) + "_quality")
}

/// The note on unused columns or tags of qualities.
pub fn note_qualities(unused: &[&str], role: String, wording: Wording) -> String {
    format!(
        "{} {} words of qualities, or true and false, and {} not used; if one of them is the quality of a signal, give {}",
        list(unused),
        if unused.len() == 1 { "holds" } else { "hold" },
        if unused.len() == 1 { "is" } else { "are" },
        wording.of(Remedy::map(role, unused[0]))
    )
}

/// Notes for loops without mode on unused columns or tags with words of modes. An unused column whose name begins with
/// the name of another loop belongs to that loop.
pub fn note_modes(loops: &mut [LoopPlan], unused: &[&str], wording: Wording) {
    let is_only = loops.len() == 1;
    for name in unused {
        let place = loop_of(loops, name);
        let Some(each) = loops.get_mut(place).filter(|each| each.signal(Signal::Mode).is_none())
        else {
            continue;
        };
        each.notes.push(format!(
            "\"{name}\" holds mode names and is not used, while the loop has no mode; if this is its mode, give {}",
            wording.of(Remedy::map(role(each, Signal::Mode, is_only), name))
        ));
    }
}

/// The note on unused numeric columns or tags. If such a column can be a missing signal by its numbers, the note shows
/// how to assign it.
pub fn note(
    loops: &[LoopPlan],
    unused: &[usize],
    names: &[&str],
    content: &Content<'_>,
    wording: Wording,
) -> Option<String> {
    let holds = match unused.len() {
        0 => return None,
        1 => "holds numbers and is not used",
        _ => "hold numbers and are not used",
    };
    let all = list(&unused.iter().map(|name| names[*name]).collect::<Vec<_>>());
    let poor = |signal: Signal| loops.iter().find(|each| each.signal(signal).is_none());
    let missing: Vec<(Signal, &LoopPlan)> =
        WANTED.into_iter().filter_map(|signal| Some((signal, poor(signal)?))).collect();
    let offer = missing.iter().find_map(|(signal, each)| {
        // A valve position is within 10 % of the values of the OP.
        let op = each.signal(Signal::Op).filter(|_| *signal == Signal::Vp);
        let near = op.map_or((f64::NEG_INFINITY, f64::INFINITY), |op| {
            let (low, high) = content.ends(op);
            (low - 10.0, high + 10.0)
        });
        let can_be = |name: &&usize| content.can_be(**name, *signal, near);
        Some((*signal, *each, names[*unused.iter().find(can_be)?]))
    });
    let Some((signal, poor, name)) = offer else { return Some(format!("{all} {holds}")) };
    let whose = match (loops.len(), &poor.name) {
        (1, None) => "the loop has".to_owned(),
        (1, Some(name)) => format!("loop {name} has"),
        (_, _) => "some loops have".to_owned(),
    };
    let missing: Vec<String> =
        missing.iter().map(|(signal, _)| format!("no {}", signal.name())).collect();
    Some(format!(
        "{all} {holds}, while {whose} {}; if one of them is a missing signal, assign the signal, as in {}",
        missing.join(", "),
        wording.of(Remedy::map(role(poor, signal, loops.len() == 1), name))
    ))
}
