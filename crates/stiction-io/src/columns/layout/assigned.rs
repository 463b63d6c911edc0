//! Combines loops whose signals are assigned, and decides which loops are read.

use super::candidate::has_number;
use super::given::Given;
use super::instrument::Instrument;
use super::leftover::{WANTED, begins};
use super::plan::{LoopPlan, MissingLoop, Recognised};
use crate::columns::role::{Role, SEPARATORS, Signal};
use crate::names::list;
use crate::remedy::Remedy;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Loops, with the role recognised for every name.
pub struct Assigned {
    pub loops: Vec<LoopPlan>,
    pub recognised: Vec<Recognised>,
    pub missing: Vec<MissingLoop>,
    pub notes: Vec<String>,
}

/// Signals without a loop name belong to the only loop.
pub fn join_the_nameless(assigned: &mut Assigned) {
    let Some(nameless) = assigned.loops.iter().position(|each| each.name.is_none()) else { return };
    if assigned.loops.len() != 2 {
        return;
    }
    let (a, b) = (&assigned.loops[nameless], &assigned.loops[1 - nameless]);
    let clash = a.signals.iter().zip(&b.signals).any(|(a, b)| a.is_some() && b.is_some())
        || a.qualities.iter().zip(&b.qualities).any(|(a, b)| a.is_some() && b.is_some())
        || (a.quality.is_some() && b.quality.is_some());
    if clash {
        return;
    }
    let nameless = assigned.loops.remove(nameless);
    let one = &mut assigned.loops[0];
    for name in nameless.names() {
        assigned.recognised[name].loop_name.clone_from(&one.name);
        assigned.recognised[name].why += "; there is only one loop";
    }
    for k in 0..5 {
        one.signals[k] = one.signals[k].or(nameless.signals[k]);
        one.qualities[k] = one.qualities[k].or(nameless.qualities[k]);
    }
    one.quality = one.quality.or(nameless.quality);
    one.notes.extend(nameless.notes);
}

/// The PV of a data acquisition block, `FC101.DACA`, becomes the PV of the control block of the same point,
/// `FC101.PIDA`, if that has none.
pub fn join_acquisition(assigned: &mut Assigned, names: &[&str]) {
    let point = |each: &LoopPlan| {
        let (point, block) = each.name.as_ref()?.rsplit_once(SEPARATORS)?;
        Some((point.to_lowercase(), block.to_lowercase()))
    };
    let mut of_point: HashMap<String, Vec<usize>> = HashMap::new();
    for (place, each) in assigned.loops.iter().enumerate().filter(|(_, each)| each.has_op()) {
        let whole = each.name.as_ref().map(|name| name.to_lowercase());
        for key in point(each).map(|(point, _)| point).into_iter().chain(whole) {
            of_point.entry(key).or_default().push(place);
        }
    }
    for k in 0..assigned.loops.len() {
        let Some((of, _)) = point(&assigned.loops[k]).filter(|(_, block)| block == "daca") else {
            continue;
        };
        let pv = Signal::Pv as usize;
        let (Some(column), false) = (assigned.loops[k].signals[pv], assigned.loops[k].has_op())
        else {
            continue;
        };
        let lacks_pv = |place: &&usize| assigned.loops[**place].signals[pv].is_none();
        let mut controllers = of_point.get(&of).into_iter().flatten().filter(lacks_pv);
        let (Some(controller), None) = (controllers.next(), controllers.next()) else { continue };
        let quality = assigned.loops[k].quality(Signal::Pv);
        let controller = &mut assigned.loops[*controller];
        controller.signals[pv] = Some(column);
        controller.qualities[pv] = controller.qualities[pv].or(quality);
        let name = controller.name.clone();
        controller.notes.push(format!(
            "\"{}\" is interpreted as the PV, because it belongs to the same point as the controller",
            names[column]
        ));
        for moved in [Some(column), quality].into_iter().flatten() {
            assigned.recognised[moved].loop_name.clone_from(&name);
            assigned.recognised[moved].why += "; the controller of that point has no PV";
        }
        let acquisition = &mut assigned.loops[k];
        (acquisition.signals[pv], acquisition.qualities[pv]) = (None, None);
        acquisition.quality = acquisition.quality.filter(|own| Some(*own) != quality);
    }
    assigned.loops.retain(|each| each.names().next().is_some());
}

/// A signal that the only loop with an OP lacks is taken from another name under three conditions. A single name has
/// the signal, no user gives it to another loop, and the names do not show two loops: one is plain words, or begins
/// with the other.
pub fn join_the_rest(assigned: &mut Assigned, names: &[&str], given: &Given<'_>) {
    let with_op = |each: &&LoopPlan| each.has_op();
    let mut ops = assigned.loops.iter().filter(with_op);
    let (Some(own), None) = (ops.next(), ops.next()) else { return };
    let tag = own.name.clone().unwrap_or_default();
    let is_plain = |name: &str| !has_number(name);
    let is_single = assigned.loops.len() == 2;
    let may_join = |each: &LoopPlan| {
        let of = each.name.as_deref().unwrap_or_default();
        let clash = each.signals.iter().zip(&own.signals).any(|(a, b)| a.is_some() && b.is_some());
        let is_given =
            each.names().any(|i| given.mapped(names[i]).is_some_and(|of| of.loop_name.is_some()));
        let is_related =
            is_plain(of) || (is_plain(&tag) && is_single) || begins(of, &tag) || begins(&tag, of);
        is_related && !clash && !is_given
    };
    let others = || assigned.loops.iter().filter(|each| !each.has_op());
    let mut found = vec![];
    for signal in WANTED.into_iter().filter(|signal| own.signal(*signal).is_none()) {
        let mut with = others().filter(|each| each.signal(signal).is_some());
        if let (Some(one), None) = (with.next(), with.next())
            && may_join(one)
        {
            found.extend(one.signal(signal).map(|name| (signal, name, one.quality(signal))));
        }
    }
    let moved = found.iter().flat_map(|(_, name, quality)| [Some(*name), *quality]);
    let moved: Vec<usize> = moved.flatten().collect();
    for each in &mut assigned.loops {
        if !each.has_op() {
            let signals = each.signals.iter_mut().chain(&mut each.qualities);
            for place in signals.chain([&mut each.quality]) {
                *place = place.filter(|name| !moved.contains(name));
            }
            continue;
        }
        for name in &moved {
            assigned.recognised[*name].loop_name.clone_from(&each.name);
            assigned.recognised[*name].why += "; only one loop has an OP";
        }
        for (signal, name, quality) in &found {
            let place = *signal as usize;
            (each.signals[place], each.qualities[place]) = (Some(*name), *quality);
            each.notes.push(format!(
                "\"{}\" is interpreted as the {}, because only one loop has an OP; if it is not, give {}",
                names[*name],
                signal.name(),
                given.options.wording.of(Remedy::map("ignore", names[*name]))
            ));
        }
    }
    assigned.loops.retain(|each| each.names().next().is_some());
}

/// Joins loops that are named after one instrument with different words, such as `FIC2106 Flow` and `FIC2106`. Only one
/// of them may have an OP, and they may have no signal in common.
pub fn join_by_instrument(assigned: &mut Assigned) {
    let mut of_tag: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (place, each) in assigned.loops.iter().enumerate() {
        let tag = each.name.as_deref().and_then(Instrument::before_words);
        of_tag.entry(tag.unwrap_or_default().to_lowercase()).or_default().push(place);
    }
    of_tag.remove("");
    let mut gone = HashSet::new();
    for places in of_tag.into_values().filter(|places| places.len() > 1) {
        let parts: Vec<&LoopPlan> = places.iter().map(|place| &assigned.loops[*place]).collect();
        let with_op: Vec<usize> =
            places.iter().copied().filter(|place| assigned.loops[*place].has_op()).collect();
        let once = |of: &dyn Fn(&LoopPlan) -> Option<usize>| {
            parts.iter().filter(|part| of(part).is_some()).count() <= 1
        };
        let is_disjoint = once(&|part| part.quality)
            && (0..5).all(|k| once(&|part| part.signals[k]) && once(&|part| part.qualities[k]));
        let ([whole], true) = (&with_op[..], is_disjoint) else { continue };
        let name =
            parts.iter().find_map(|part| part.name.as_deref().and_then(Instrument::before_words));
        let name = name.map(str::to_owned);
        for place in places.iter().filter(|place| *place != whole) {
            let part = std::mem::take(&mut assigned.loops[*place]);
            let joined = &mut assigned.loops[*whole];
            for k in 0..5 {
                joined.signals[k] = joined.signals[k].or(part.signals[k]);
                joined.qualities[k] = joined.qualities[k].or(part.qualities[k]);
            }
            joined.quality = joined.quality.or(part.quality);
            joined.notes.extend(part.notes);
            gone.insert(*place);
        }
        assigned.loops[*whole].name.clone_from(&name);
        let names: Vec<usize> = assigned.loops[*whole].names().collect();
        for each in names {
            let recognised = &mut assigned.recognised[each];
            if recognised.loop_name != name {
                recognised.loop_name.clone_from(&name);
                recognised.why += "; its tag is that of the loop";
            }
        }
    }
    let mut place = 0;
    assigned.loops.retain(|_| {
        place += 1;
        !gone.contains(&(place - 1))
    });
}

/// Loops of the mapping that lack a column or tag are not read incompletely.
pub fn leave_out_missing(assigned: &mut Assigned) {
    let loops = assigned.recognised.iter().filter_map(|each| each.loop_name.as_ref());
    let here: HashSet<String> = loops.map(|name| name.to_lowercase()).collect();
    for missing in &mut assigned.missing {
        missing.is_partly_here = here.contains(&missing.name.to_lowercase());
    }
    let partly = assigned.missing.iter().filter(|each| each.is_partly_here);
    let partly: HashSet<String> = partly.map(|each| each.name.to_lowercase()).collect();
    let is_it = |name: &Option<String>| {
        name.as_ref().is_some_and(|name| partly.contains(&name.to_lowercase()))
    };
    assigned.loops.retain(|each| !is_it(&each.name));
    for each in assigned.recognised.iter_mut().filter(|each| is_it(&each.loop_name)) {
        each.role = Role::Ignored;
        "another column or tag of its loop is missing".clone_into(&mut each.why);
    }
    for missing in assigned.missing.iter().filter(|each| each.is_partly_here) {
        assigned
            .notes
            .push(format!("loop {} is not read: the file {}", missing.name, missing.reason));
    }
}

/// Loops without an OP are not read. Returns their signals.
pub fn keep_those_with_op(assigned: &mut Assigned) -> Vec<(Signal, usize)> {
    let lone = assigned.loops.iter().filter(|each| !each.has_op());
    let of = |each: &LoopPlan| WANTED.map(|signal| each.signal(signal).map(|name| (signal, name)));
    let lone = lone.flat_map(of).flatten().collect();
    let without: Vec<&LoopPlan> = assigned.loops.iter().filter(|each| !each.has_op()).collect();
    if without.len() < assigned.loops.len() {
        let named: Vec<&str> = without.iter().filter_map(|each| each.name.as_deref()).collect();
        assigned.notes.extend(match &named[..] {
            [] => None,
            [name] => Some(format!("loop {name} has no OP and is not read")),
            _ => Some(format!("the loops {} have no OP and are not read", list(&named))),
        });
        if named.len() < without.len() {
            let note = "the columns without a loop name include no OP and are not read";
            assigned.notes.push(note.to_owned());
        }
        assigned.loops.retain(LoopPlan::has_op);
    } else {
        assigned.loops.clear();
    }
    lone
}
