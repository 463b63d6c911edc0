//! What to do, in sentences.

use super::{Action, Prediction, Row, STEM_SPEED, WEARING, WORTH, WhatIfOptions};
use crate::bands::Bands;
use crate::closed_loop::ClosedLoop;
use crate::limit_cycle::tuning::Retuning;
use crate::spoken::set;
use crate::valve::{Model, Motion};

/// Notes in every row what speaks against the action.
///
/// Repair and positioner are no stopgaps: what they cost is not known here.
pub(super) fn object(rows: &mut [Row], window_s: f64, unstable: bool) {
    let Some(present) = as_it_is(rows).cloned() else { return };
    for row in rows.iter_mut().filter(|row| stopgap(row)) {
        row.against = against(row, &present);
        if let Some(cycle) = row.cycle.cycle().filter(|cycle| 3.0 * cycle.period_s > window_s) {
            row.against.push(format!(
                "cycles every {} s, too slowly for what was measured in {} s",
                set(cycle.period_s),
                set(window_s)
            ));
        }
        if unstable && matches!(row.action, Action::Compensate(_)) {
            row.against.insert(0, "the loop is unstable without friction".to_owned());
        }
    }
}

/// Whether it can be done from the control room.
fn stopgap(row: &Row) -> bool {
    matches!(row.action, Action::Compensate(_) | Action::Retune(_))
}

fn as_it_is(rows: &[Row]) -> Option<&Row> {
    rows.iter().find(|row| row.action == Action::AsItIs)
}

fn against(row: &Row, present: &Row) -> Vec<String> {
    let mut said = vec![];
    let (now, worst) = (present.error(), row.worst_error());
    if worst > now {
        said.push("more error than now if S and J are wrong".to_owned());
    } else if worst * WORTH > now {
        said.push("gains little if S and J are wrong".to_owned());
    }
    if let (Some(noisy), Some(now)) = (row.played.noisy(), present.played.noisy())
        && worst * WORTH <= present.error()
        && noisy.measures.iae_per_s * WORTH > now.measures.iae_per_s
    {
        said.push("gains little under noise".to_owned());
    }
    let both =
        |row: &Row| row.played.worst(|outcome| outcome.measures.iae_per_s + outcome.load_iae_per_s);
    if worst * WORTH <= now && both(row) * WORTH > both(present) {
        said.push("loses by a load step what it gains before".to_owned());
    }
    let settles = |after: fn(&crate::compensate::CompensatorOutcome) -> Option<f64>| {
        row.played.quiet().all(|outcome| after(outcome).is_some())
    };
    let lost: Vec<&str> = [
        ("set-point", settles(|outcome| outcome.set_point_settling_s)),
        ("load", settles(|outcome| outcome.load_settling_s)),
    ]
    .into_iter()
    .filter_map(|(step, settles)| (!settles).then_some(step))
    .collect();
    if !lost.is_empty() {
        said.push(format!("does not always settle after a {} step", lost.join(" or ")));
    }
    let number = |name| row.played.parameters.iter().find(|n| n.name == name).map(|n| n.value);
    if let (Some(reach), Some(hold)) = (number("reach"), number("hold"))
        && reach > STEM_SPEED * hold
    {
        said.push(format!(
            "throws the stem {} % within {} s, faster than a pneumatic one moves ({STEM_SPEED} %/s)",
            set(reach),
            set(hold)
        ));
    }
    let worn = travel(row, present);
    if worn > WEARING {
        said.push(format!("{} times the stem's travel", ratio(worn)));
    }
    said
}

/// The travel of the stem, at worst, over that of the loop as it is.
fn travel(row: &Row, present: &Row) -> f64 {
    let now = present.nominal().measures.vp_travel_per_s;
    let then = row.played.worst(|outcome| outcome.measures.vp_travel_per_s);
    if then > 0.0 { then / now } else { 0.0 }
}

/// What to do until a repair: of the tunings and compensators against which nothing speaks, the one that
/// ranks first.
pub(super) fn interim(rows: &[Row]) -> Option<&Row> {
    let present = as_it_is(rows)?;
    // What does not move needs nothing but a repair.
    if present.nominal().measures.vp_travel_per_s == 0.0 {
        return None;
    }
    rows.iter().find(|row| stopgap(row) && row.against.is_empty())
}

/// The time between load steps, s, below which an action loses by them what it gains in between; `None` if it
/// answers a load step no worse than the loop as it is.
fn loads_apart_s(row: &Row, present: &Row, step_s: f64) -> Option<f64> {
    let cost =
        |row: &Row| row.played.worst(|outcome| outcome.load_iae_per_s - outcome.measures.iae_per_s);
    let more = (cost(row) - cost(present)) * step_s;
    let gained = present.error() - row.worst_error();
    (more > 0.0 && gained > 0.0).then(|| more / gained)
}

pub(super) fn recommendation(
    rows: &[Row],
    retuning: &std::result::Result<Retuning, String>,
    options: &WhatIfOptions,
    bands: Bands,
    unstable: bool,
) -> Vec<String> {
    let Some(present) = as_it_is(rows) else { return vec![] };
    let mut said = vec![];
    let swings = present.nominal().measures;
    if unstable {
        let tuning = retuning.as_ref().ok().map(|retuning| {
            format!(
                ", for instance {}, which keeps Ms within {}",
                tuning(retuning),
                set(options.most_sensitive)
            )
        });
        said.push(format!(
            "The loop is not stable even with a valve that does not stick: make its controller slower first{}. \
             Whatever is done to the valve comes after.",
            tuning.unwrap_or_default()
        ));
    }
    if bands == Bands::NONE {
        said.push(
            "The valve does not stick: no repair and no compensator can change anything."
                .to_owned(),
        );
        return said;
    }
    let state = match &present.cycle {
        _ if unstable => "As it is, the loop swings until something limits it".to_owned(),
        Prediction::Cycle(cycle) => format!(
            "As it is, the loop cycles every {} s and the PV swings by {} to either side (predicted exactly)",
            set(cycle.period_s),
            set(cycle.half_pp.pv)
        ),
        Prediction::NoCycle(reason) => {
            format!("As it is, the loop has no limit cycle of its own ({reason})")
        }
        Prediction::Unknown(reason) => {
            format!("The limit cycle of the loop as it is could not be predicted ({reason})")
        }
    };
    said.push(format!(
        "{state}; simulated, the PV swings by {} and is {} off its set point on the mean.",
        set(swings.pv_half_pp),
        set(present.error())
    ));
    said.push(repair(rows, present, options, bands));
    if unstable {
        return said;
    }
    said.extend(until_then(rows, present, options));
    if let Ok(retuning) = retuning
        && let (Some(swing), Some(iae)) = (retuning.pv_ratio, retuning.iae_ratio)
    {
        let left = match retuning.best.pv_swing() {
            0.0 => "no limit cycle".to_owned(),
            _ => format!("{:.0} % of the swing of the PV", 100.0 * swing),
        };
        said.push(format!(
            "Retuning alone ({}) leaves {left}, and around a valve that does not stick a load step would cost {} \
             times the integral of the error that it costs with the present tuning.",
            tuning(retuning),
            ratio(iae)
        ));
    }
    let gain = options.positioner_gain;
    if bands.s() > 0.0 && gain * bands.j() > bands.s() {
        said.push(format!(
            "Do not count on the positioner: the figures hold for one that is faster than a slip. A slower one \
             of gain {} leaves the slip jump whole and hunts around this valve, because {} x J exceeds S.",
            set(gain),
            set(gain)
        ));
    }
    said
}

/// The best tuning in words.
fn tuning(retuning: &Retuning) -> String {
    let (kp, ki, _) = retuning.best.controller.gains();
    format!("Kc = {}, Ti = {} s", set(kp), set(kp / ki))
}

/// Whether a repair pays.
fn repair(rows: &[Row], present: &Row, options: &WhatIfOptions, bands: Bands) -> String {
    let Some(repaired) = rows.iter().find(|row| row.action == Action::Repair) else {
        return String::new();
    };
    let load = |row: &Row| row.nominal().load_iae_per_s;
    let less = |now: f64, then: f64| now > WORTH * then;
    let kept = options.repaired;
    let with = format!("S = {} % and J = {} %", set(kept.s()), set(kept.j()));
    if bands.s() <= kept.s() && bands.j() <= kept.j() {
        return format!(
            "There is nothing to repair: a valve fresh from repair keeps {with}, and this one has no more."
        );
    }
    if less(present.error(), repaired.error()) {
        format!(
            "Repair the valve: that removes the cause. With {with} left, the mean error falls from {} to {}, and \
             after a load step from {} to {}.",
            set(present.error()),
            set(repaired.error()),
            set(load(present)),
            set(load(repaired))
        )
    } else if less(load(present), load(repaired)) {
        format!(
            "Repair the valve when there is an occasion: left alone the loop gains nothing by it, but after a load \
             step the mean error falls from {} to {}, with {with} left.",
            set(load(present)),
            set(load(repaired))
        )
    } else {
        format!(
            "A repair would change little: with {with} left, the mean error goes from {} to {}.",
            set(present.error()),
            set(repaired.error())
        )
    }
}

/// What to do until the repair, and what not.
fn until_then(rows: &[Row], present: &Row, options: &WhatIfOptions) -> Vec<String> {
    let tried = |row: &&Row| stopgap(row);
    if rows.iter().filter(tried).count() == 0 {
        return vec![];
    }
    let mut said = vec![];
    let interim = interim(rows);
    match interim {
        Some(row) => {
            let numbers: Vec<String> = row
                .played
                .parameters
                .iter()
                .map(|n| format!("{} = {} {}", n.name, set(n.value), n.unit).trim().to_owned())
                .collect();
            let what = match &row.action {
                Action::Retune(_) => "retune it",
                _ => "compensate it",
            };
            let name = row.action.name();
            let settled = row.nominal().load_settling_s.map_or(String::new(), |s| {
                format!(", and a load step is back within bounds after {} s", set(s))
            });
            let moves = match travel(row, present) {
                still if still < 0.01 => "the stem then stands still".to_owned(),
                times => format!("the stem travels {} times as far at most", ratio(times)),
            };
            said.push(format!(
                "Until then, {what} ({name}: {}): the mean error falls from {} to {}, to {} in the worst case of S and J \
                 being wrong by {:.0} %; {moves}{settled}.",
                numbers.join(", "),
                set(present.error()),
                set(row.error()),
                set(row.worst_error()),
                100.0 * options.protocol.error,
            ));
            let number = |name| row.played.parameters.iter().find(|n| n.name == name);
            if let (Some(reach), Some(hold)) = (number("reach"), number("hold")) {
                said.push(format!(
                    "Mind that every correction of it throws the stem {} % past its place and back within {} s: the \
                     OP needs that room, and the process must bear it.",
                    set(reach.value),
                    set(hold.value)
                ));
            }
            if let Some(apart) = loads_apart_s(row, present, options.protocol.step_s) {
                said.push(format!(
                    "It answers loads slower than the loop does now: it pays where loads of {} % come less often \
                     than every {} s.",
                    set(options.protocol.load_step),
                    set(apart)
                ));
            }
        }
        None if present.nominal().measures.vp_travel_per_s == 0.0 => {
            said.push(
                "Until then, leave the loop as it is: its stem is at rest, there is no swing to compensate."
                    .to_owned(),
            );
            return said;
        }
        None => said.push(
            "Until then, leave the loop as it is: something speaks against every tuning and compensator tried."
                .to_owned(),
        ),
    }
    let above = rows
        .iter()
        .take_while(|row| interim.is_none_or(|interim| row.action != interim.action))
        .filter(tried)
        .filter(|row| row.worst_error() * WORTH <= present.error() && !row.against.is_empty());
    let above: Vec<String> =
        above.map(|row| format!("{} ({})", row.action.name(), row.against.join(", "))).collect();
    if !above.is_empty() {
        said.push(format!("Less error, but not recommended: {}.", above.join("; ")));
    }
    let worse: Vec<&str> = rows
        .iter()
        .filter(tried)
        .filter(|row| row.worst_error() > present.error())
        .map(|row| row.action.name())
        .collect();
    if !worse.is_empty() {
        said.push(format!("Worse than doing nothing if S and J are wrong: {}.", worse.join(", ")));
    }
    said
}

pub(super) fn assumptions(
    plant: &ClosedLoop,
    model: Model,
    bands: Bands,
    options: &WhatIfOptions,
    plain: bool,
) -> Vec<String> {
    let repaired = options.repaired;
    let protocol = &options.protocol;
    let mut said = vec![
        format!(
            "The valve is {} with S = {} % and J = {} % as seen from the OP; process and controller are those given.",
            model.describe().name,
            set(bands.s()),
            set(bands.j())
        ),
        format!(
            "Errors are means over {} s, after {} s to settle; the set point then steps by {}, the load by {} %, \
             each for {} s; settled is within {}.",
            set(protocol.window_s),
            set(protocol.settle_s),
            set(protocol.set_point_step),
            set(protocol.load_step),
            set(protocol.step_s),
            set(protocol.settling_band)
        ),
        format!(
            "Compensators and the tuning were also chosen for S and J {:.0} % too small and too large, each with \
             each; in the case with noise its standard deviation is {}.",
            100.0 * protocol.error,
            set(protocol.noise_sd)
        ),
        format!(
            "A repaired valve keeps S = {} % and J = {} %; a retuned loop keeps Ms within {}.",
            set(repaired.s()),
            set(repaired.j()),
            set(options.most_sensitive)
        ),
        format!(
            "The positioner is proportional with a gain of {} and faster than a slip; if the valve has one \
             already, S and J are those behind it and its row does not apply.",
            set(options.positioner_gain)
        ),
    ];
    if model.describe().motion == Motion::Staircase {
        said.push(
            "This valve model has a family of limit cycles: the predicted one is the member near the equilibrium; in \
             which the loop ends depends on how it started."
                .to_owned(),
        );
    }
    if !plain || plant.valve.bare_model().is_none() {
        said.push(
            "The simulated valve has settings beyond its model, S and J (limits, a lag, an overshoot of its own): \
             the predicted cycle knows nothing of them."
                .to_owned(),
        );
    }
    said
}

/// A ratio, told to two digits; one beyond all measure is told as such.
fn ratio(x: f64) -> String {
    match x {
        x if !(x <= 999.0) => "more than 1000".to_owned(),
        x if x >= 9.95 => format!("{x:.0}"),
        x => format!("{x:.1}"),
    }
}
