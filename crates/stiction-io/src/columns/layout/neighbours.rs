//! Columns and tags that are recognised only by their neighbours.

use super::candidate::Candidate;
use super::content::Content;
use crate::columns::role::{self, Role, SEPARATORS, Signal};
use crate::remedy::{Remedy, Wording};
use std::collections::HashSet;
use stiction_recording::recording::Mode;

/// Columns of 0 and 1, or of words, that show automatic or manual mode of a loop without another mode. MAN takes precedence over
/// AUTO. AUTO is not used beside CAS, because a loop in cascade may be in neither.
pub fn take_switches(candidates: &mut [Option<Candidate>], names: &[&str], content: &Content<'_>) {
    let mut found: Vec<(usize, role::Split, Mode)> = (0..names.len())
        .filter(|i| candidates[*i].is_none())
        .filter_map(|i| role::split_switch(names[i]).map(|(split, mode)| (i, split, mode)))
        .filter(|(i, ..)| content.is_switch(*i) || content.is_modes(*i))
        .collect();
    found.sort_by_key(|(_, _, mode)| *mode != Mode::Manual);
    let key = |split: &role::Split| split.loop_name.as_ref().map(|name| name.to_lowercase());
    let cascades: Vec<Option<String>> = found
        .iter()
        .filter(|(_, _, mode)| *mode == Mode::Cascade)
        .map(|(_, split, _)| key(split))
        .collect();
    let modes = candidates.iter().flatten().filter(|c| c.role == Role::Signal(Signal::Mode));
    let mut told: HashSet<Option<String>> =
        modes.map(|c| c.loop_name.as_ref().map(|name| name.to_lowercase())).collect();
    for (i, split, mode) in found {
        let key = key(&split);
        if mode == Mode::Cascade || (mode == Mode::Automatic && cascades.contains(&key)) {
            continue;
        }
        // A mode without a loop name may belong to any loop.
        let told = told.contains(&None) || !told.insert(key);
        let (role, why) = match (told, mode) {
            (true, _) => (Role::Ignored, "another column gives the mode"),
            (false, _) if content.is_modes(i) => (split.role, "its words are mode names"),
            (false, Mode::Manual) => (split.role, "its 0 and 1 show whether the loop is in manual"),
            (false, _) => (split.role, "its 0 and 1 show whether the loop is in automatic"),
        };
        candidates[i] = Some(Candidate::recognised(split.loop_name, role, why));
    }
}

/// Several quality columns of one name, such as `Conf`, belong to the signals on their left. They belong to the signals
/// on their right if each has a signal there, and the first has none on its left.
pub fn take_qualities(
    candidates: &mut [Option<Candidate>],
    names: &[&str],
    wording: Wording,
    notes: &mut Vec<String>,
) {
    let is_one =
        |i: &usize| role::of_rows(role::without_number(names[*i])) == Some(Role::Quality(None));
    let several: Vec<usize> = (0..names.len())
        .filter(is_one)
        .filter(|i| candidates[*i].as_ref().is_none_or(|candidate| !candidate.given))
        .collect();
    if several.len() < 2 {
        return;
    }
    let is_signal = |i: Option<usize>| {
        let of = i.and_then(|i| candidates.get(i)).and_then(Option::as_ref);
        of.is_some_and(|of| matches!(of.role, Role::Signal(_)))
    };
    let left = |i: usize| (0..i).rev().find(|left| !is_one(left));
    let is_front = !is_signal(left(several[0])) && several.iter().all(|i| is_signal(Some(i + 1)));
    let side = if is_front { "right" } else { "left" };
    let (first, last) = (names[several[0]], names[several[several.len() - 1]]);
    if is_front {
        notes.push(format!(
            "\"{first}\" to \"{last}\" are interpreted as the qualities of the signals on their right, because the first column \
             has no signal on its left; if they are not qualities, give {}",
            wording.of(Remedy::map("pv_quality", first))
        ));
    }
    for i in several {
        let of = if is_front { Some(i + 1) } else { left(i) };
        let name = of.map_or("", |of| names[of]);
        let of = of.and_then(|of| candidates[of].as_ref());
        let (loop_name, role) = match of.map(|of| (&of.loop_name, of.role)) {
            Some((loop_name, Role::Signal(signal))) => {
                (loop_name.clone(), Role::Quality(Some(signal)))
            }
            _ => (None, Role::Ignored),
        };
        if role == Role::Ignored {
            notes.push(format!(
                "\"{0}\" is not used, because \"{name}\" on its left is not a signal; if \"{0}\" is the quality of a signal, give {1}",
                names[i],
                wording.of(Remedy::map("pv_quality", names[i]))
            ));
        }
        let why = format!("it is the quality of \"{name}\" on its {side}");
        candidates[i] = Some(Candidate::recognised(loop_name, role, why));
    }
}

/// A flow, level, pressure or temperature is the PV if it is the only remaining quantity, there is only one loop, and
/// no other column is the PV.
pub fn take_quantity(
    candidates: &mut [Option<Candidate>],
    names: &[&str],
    content: &Content<'_>,
    wording: Wording,
    notes: &mut Vec<String>,
) {
    let of = |signal: Signal| {
        candidates.iter().flatten().filter(move |c| c.role == Role::Signal(signal))
    };
    let is_quantity = |i: &usize| {
        candidates[*i].is_none() && role::has_quantity(names[*i]) && content.is_numeric(*i)
    };
    let quantities: Vec<usize> = (0..names.len()).filter(is_quantity).collect();
    let ops: Vec<&Candidate> = of(Signal::Op).collect();
    let ([quantity], [op], None) = (&quantities[..], &ops[..], of(Signal::Pv).next()) else {
        return;
    };
    let (name, loop_name) = (names[*quantity], op.loop_name.clone());
    if !role::is_quantity(name) {
        return;
    }
    notes.push(format!(
        "\"{name}\" is interpreted as the PV, because no other column can be the PV; if it is not, give {}",
        wording.of(Remedy::map("ignore", name))
    ));
    let why = "it is the only measured quantity";
    candidates[*quantity] = Some(Candidate::recognised(loop_name, Role::Signal(Signal::Pv), why));
}

/// Tag and signal of each name that ends with W, X or Y after a separator, the letters of German control engineering
/// for SP, PV and OP. The result is `None` unless all three names of the tag exist.
pub fn by_letter<'a>(names: &[&'a str]) -> Vec<Option<(&'a str, Signal)>> {
    const LETTERS: [(&str, Signal); 3] = [("W", Signal::Sp), ("X", Signal::Pv), ("Y", Signal::Op)];
    let split = |name: &&'a str| {
        let (tag, last) = name.rsplit_once(SEPARATORS)?;
        let signal = LETTERS.iter().find(|(letter, _)| last.eq_ignore_ascii_case(letter))?.1;
        Some((tag, signal))
    };
    let all: Vec<Option<(&str, Signal)>> = names.iter().map(split).collect();
    let there: HashSet<(&str, Signal)> = all.iter().flatten().copied().collect();
    let is_whole =
        |(tag, _): &(&str, Signal)| LETTERS.iter().all(|of| there.contains(&(tag, of.1)));
    all.iter().map(|each| each.filter(is_whole)).collect()
}

/// Takes the names of [`by_letter`].
pub fn take_letters(candidates: &mut [Option<Candidate>], names: &[&str]) {
    for (candidate, letter) in candidates.iter_mut().zip(by_letter(names)) {
        if let Some((tag, signal)) = letter
            && candidate.as_ref().is_none_or(|candidate| !candidate.given)
        {
            let why =
                format!("W, X and Y of one tag are SP, PV and OP, so it is the {}", signal.name());
            let tag = (!tag.is_empty()).then(|| tag.to_owned());
            *candidate = Some(Candidate::recognised(tag, Role::Signal(signal), why));
        }
    }
}

/// CO without a tag is carbon monoxide beside a different OP. Alone, it is the OP, with a note unless the loop has a PV or
/// an SP.
pub fn settle_co(
    candidates: &mut [Option<Candidate>],
    names: &[&str],
    wording: Wording,
) -> Vec<String> {
    let key = |candidate: &Candidate| candidate.loop_name.as_ref().map(|name| name.to_lowercase());
    let all = || candidates.iter().flatten();
    let is = |c: &Candidate, signal: Signal| c.role == Role::Signal(signal);
    let keys = |is: &dyn Fn(&Candidate) -> bool| -> HashSet<Option<String>> {
        all().filter(|c| is(c)).map(key).collect()
    };
    let ops = keys(&|c| is(c, Signal::Op) && !c.is_co);
    let loops = keys(&|c| is(c, Signal::Pv) || is(c, Signal::Sp));
    let mut notes = vec![];
    for (candidate, name) in candidates.iter_mut().zip(names) {
        let is_open = |key| ops.contains(&key) || !loops.contains(&key);
        if !candidate.as_ref().is_some_and(|c| c.is_co && is_open(key(c))) {
            continue;
        }
        if !ops.is_empty() {
            *candidate = None;
        } else {
            notes.push(format!(
                "\"{name}\" is interpreted as the controller output (OP); if it is carbon monoxide, give {}",
                wording.of(Remedy::map("ignore", name))
            ));
        }
    }
    notes
}

/// The SP in effect goes before SP_INT, the SP of the operator, which PCS 7 does not use in cascade.
pub fn settle_sp(candidates: &mut [Option<Candidate>], names: &[&str]) {
    let key = |c: &Candidate| c.loop_name.as_ref().map(|name| name.to_lowercase());
    let is_internal = |name: &str| role::plain(role::without_unit(name).0).ends_with("spint");
    let is_sp = |c: &Candidate| c.role == Role::Signal(Signal::Sp);
    let effective: HashSet<Option<String>> = (0..names.len())
        .filter(|i| !is_internal(names[*i]))
        .filter_map(|i| candidates[i].as_ref().filter(|c| is_sp(c)).map(key))
        .collect();
    for (candidate, name) in candidates.iter_mut().zip(names) {
        if let Some(c) = candidate
            && is_sp(c)
            && !c.given
            && is_internal(name)
            && effective.contains(&key(c))
        {
            c.role = Role::Ignored;
            "another column is the SP in effect".clone_into(&mut c.why);
        }
    }
}

/// MV is the manipulated variable, which is the OP. Beside another OP it is the measured valve position. Adds a note
/// for each.
pub fn settle_mv(
    candidates: &mut [Option<Candidate>],
    names: &[&str],
    wording: Wording,
) -> Vec<(usize, String)> {
    let key = |candidate: &Candidate| candidate.loop_name.as_ref().map(|name| name.to_lowercase());
    let loops_with = |signal: Signal| -> HashSet<Option<String>> {
        let is_it = |c: &&Candidate| !c.is_mv && c.role == Role::Signal(signal);
        candidates.iter().flatten().filter(is_it).map(key).collect()
    };
    let (with_op, with_vp) = (loops_with(Signal::Op), loops_with(Signal::Vp));
    // A signal without a loop name may belong to any loop.
    let has = |loops: &HashSet<Option<String>>, of: &Candidate| {
        loops.contains(&None) || loops.contains(&key(of))
    };
    let mut notes = vec![];
    for i in 0..candidates.len() {
        let Some(candidate) = candidates[i].as_ref().filter(|candidate| candidate.is_mv) else {
            continue;
        };
        let (has_op, has_vp) = (has(&with_op, candidate), has(&with_vp, candidate));
        let name = names[i];
        let (role, note) = if has_op && !has_vp {
            let note = format!(
                "\"{name}\" is beside an OP and is interpreted as the measured valve position (VP); if it is not, \
                 give {}",
                wording.of(Remedy::map("ignore", name))
            );
            (Role::Signal(Signal::Vp), note)
        } else {
            let note = format!(
                "\"{name}\" is interpreted as the manipulated variable, the OP; if it is the measured valve \
                 position, give {}",
                wording.of(Remedy::map("vp", name))
            );
            (Role::Signal(Signal::Op), note)
        };
        if let Some(candidate) = &mut candidates[i] {
            candidate.role = role;
            candidate.why = if role == Role::Signal(Signal::Vp) {
                "MV beside an OP is the measured valve position".to_owned()
            } else {
                "MV is the manipulated variable".to_owned()
            };
        }
        notes.push((i, note));
    }
    notes
}
