//! The recommendation and the assumptions, in sentences.

use super::{Action, Prediction, Row, STEM_SPEED, WEARING, WORTH, WhatIfOptions};
use crate::bands::Bands;
use crate::closed_loop::ClosedLoop;
use crate::limit_cycle::tuning::Retuning;
use crate::spoken::{factor, set};
use crate::valve::{Model, Motion};

/// Adds the evidence against each action to its row.
///
/// Repair and positioner are left out, because their costs are unknown.
pub(super) fn object(rows: &mut [Row], window_s: f64, unstable: bool) {
    let Some(present) = as_it_is(rows).cloned() else { return };
    for row in rows.iter_mut().filter(|row| stopgap(row)) {
        row.against = against(row, &present);
        if let Some(cycle) = row.cycle.cycle().filter(|cycle| 3.0 * cycle.period_s > window_s) {
            row.against.push(format!(
                "cycles every {} s, which is too slow for a simulation window of {} s",
                set(cycle.period_s),
                set(window_s)
            ));
        }
        if unstable && matches!(row.action, Action::Compensate(_)) {
            row.against.insert(0, "the loop is unstable without friction".to_owned());
        }
    }
}

/// Whether the action is possible from the control room.
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
        said.push("larger error than now if S and J are wrong".to_owned());
    } else if worst * WORTH > now {
        said.push("little gain if S and J are wrong".to_owned());
    }
    if let (Some(noisy), Some(now)) = (row.played.noisy(), present.played.noisy())
        && worst * WORTH <= present.error()
        && noisy.measures.iae_per_s * WORTH > now.measures.iae_per_s
    {
        said.push("little gain with noise".to_owned());
    }
    let both =
        |row: &Row| row.played.worst(|outcome| outcome.measures.iae_per_s + outcome.load_iae_per_s);
    if worst * WORTH <= now && both(row) * WORTH > both(present) {
        said.push("a load step cancels the benefit".to_owned());
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
            "moves the stem {} % within {} s, faster than a pneumatic actuator can ({STEM_SPEED} %/s)",
            set(reach),
            set(hold)
        ));
    }
    let worn = travel(row, present);
    if worn > WEARING {
        said.push(format!("{} times the stem travel if S and J are wrong", factor(worn)));
    }
    said
}

/// Ratio of the stem travel in the worst case to the stem travel of the present loop.
fn travel(row: &Row, present: &Row) -> f64 {
    let now = present.nominal().measures.vp_travel_per_s;
    let then = row.played.worst(|outcome| outcome.measures.vp_travel_per_s);
    if then > 0.0 { then / now } else { 0.0 }
}

/// The action until a repair: the best tuning or compensator without evidence against it.
pub(super) fn interim(rows: &[Row]) -> Option<&Row> {
    let present = as_it_is(rows)?;
    // A stem at rest needs only a repair.
    if present.nominal().measures.vp_travel_per_s == 0.0 {
        return None;
    }
    rows.iter().find(|row| stopgap(row) && row.against.is_empty())
}

/// The shortest time between load steps, s, at which an action still helps; `None` if its response to a load step is no
/// worse than the response of the present loop.
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
    if unstable {
        let tuning = retuning.as_ref().ok().map(|retuning| {
            format!(
                ", for instance to {} (Ms up to {})",
                tuning(retuning),
                set(options.most_sensitive)
            )
        });
        said.push(format!(
            "The loop is unstable even with a valve that does not stick. First slow down the controller{}, before any \
             action on the valve.",
            tuning.unwrap_or_default()
        ));
    }
    if bands == Bands::NONE {
        said.push(
            "The valve does not stick, so neither a repair nor a compensator can improve the loop."
                .to_owned(),
        );
        return said;
    }
    let state = match &present.cycle {
        _ if unstable => "The present loop swings until a limit stops it".to_owned(),
        Prediction::Cycle(cycle) => format!(
            "The present loop cycles every {} s with a PV swing of ±{} (exact prediction)",
            set(cycle.period_s),
            set(cycle.half_pp.pv)
        ),
        Prediction::NoCycle(reason) => {
            format!("The present loop has no limit cycle ({reason})")
        }
        Prediction::Unknown(reason) => {
            format!("The limit cycle of the present loop could not be predicted ({reason})")
        }
    };
    said.push(format!("{state}. The simulated mean error is {}.", set(present.error())));
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
            _ => format!("{:.0} % of the PV swing", 100.0 * swing),
        };
        said.push(format!(
            "Retuning alone ({}) leaves {left}. With a valve that does not stick, the IAE of a load step would be {} times \
             the IAE with the present tuning.",
            tuning(retuning),
            factor(iae)
        ));
    }
    let gain = options.positioner_gain;
    if bands.s() > 0.0 && gain * bands.j() > bands.s() {
        said.push(format!(
            "Do not rely on the positioner, because the simulated positioner is faster than a slip. A slower positioner \
             with a gain of {} does not reduce the slip jump and hunts with this valve, because {} x J exceeds S.",
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
            "No repair is needed. A repaired valve has {with}, and the present valve does not exceed these values."
        );
    }
    if less(present.error(), repaired.error()) {
        format!(
            "Repair the valve to remove the cause. With {with} after the repair, the mean error falls from {} to {}, and \
             after a load step from {} to {}.",
            set(present.error()),
            set(repaired.error()),
            set(load(present)),
            set(load(repaired))
        )
    } else if less(load(present), load(repaired)) {
        format!(
            "Repair the valve at the next opportunity. With {with} after the repair, the mean error falls only after a \
             load step, from {} to {}.",
            set(load(present)),
            set(load(repaired))
        )
    } else {
        format!(
            "A repair would change little. With {with} after the repair, the mean error changes from {} to {}.",
            set(present.error()),
            set(repaired.error())
        )
    }
}

/// Actions until the repair, recommended or not.
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
                format!(", and a load step settles after {} s", set(s))
            });
            let moves = match travel(row, present) {
                still if still < 0.01 => "the stem then rests".to_owned(),
                times => format!("the stem travel is at most {} times the present travel", factor(times)),
            };
            said.push(format!(
                "Until then, {what} ({name} with {}). The mean error falls from {} to {}, or to {} in the worst case if S \
                 and J are wrong by {:.0} %; {moves}{settled}.",
                numbers.join(", "),
                set(present.error()),
                set(row.error()),
                set(row.worst_error()),
                100.0 * options.protocol.error,
            ));
            let number = |name| row.played.parameters.iter().find(|n| n.name == name);
            if let (Some(reach), Some(hold)) = (number("reach"), number("hold")) {
                said.push(format!(
                    "Each correction moves the stem {} % past its target and back within {} s. The OP needs this range, \
                     and the process must tolerate these moves.",
                    set(reach.value),
                    set(hold.value)
                ));
            }
            if let Some(apart) = loads_apart_s(row, present, options.protocol.step_s) {
                said.push(format!(
                    "This action slows the response to loads. The action is worthwhile only if load steps of {} % come \
                     less often than every {} s.",
                    set(options.protocol.load_step),
                    set(apart)
                ));
            }
        }
        None if present.nominal().measures.vp_travel_per_s == 0.0 => {
            said.push(
                "Until then, leave the loop as it is. The stem is at rest, so there is no swing to compensate."
                    .to_owned(),
            );
            return said;
        }
        None => said.push(
            "Until then, leave the loop as it is. None of the simulated tunings and compensators is recommended."
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
        said.push(format!("Smaller error, but not recommended: {}.", above.join("; ")));
    }
    let worse: Vec<&str> = rows
        .iter()
        .filter(tried)
        .filter(|row| row.worst_error() > present.error())
        .map(|row| row.action.name())
        .collect();
    if !worse.is_empty() {
        said.push(format!("Worse than no action if S and J are wrong: {}.", worse.join(", ")));
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
            "The valve model is {} with S = {} % and J = {} % as seen from the OP. Process and controller are as given.",
            model.describe().name,
            set(bands.s()),
            set(bands.j())
        ),
        format!(
            "Errors are means over {} s, after a settling time of {} s. Then the set point steps by {} and the load by {} \
             %, each for {} s. The settling band is ±{}.",
            set(protocol.window_s),
            set(protocol.settle_s),
            set(protocol.set_point_step),
            set(protocol.load_step),
            set(protocol.step_s),
            set(protocol.settling_band)
        ),
        format!(
            "Compensators and tuning were also chosen for all combinations of S and J {:.0} % too small and too \
             large. In the case with noise, the standard deviation of the noise is {}.",
            100.0 * protocol.error,
            set(protocol.noise_sd)
        ),
        format!(
            "A repaired valve has S = {} % and J = {} %. A retuned loop has Ms up to {}.",
            set(repaired.s()),
            set(repaired.j()),
            set(options.most_sensitive)
        ),
        format!(
            "The positioner is proportional, with a gain of {}, and faster than a slip. If the valve already has a positioner, \
             S and J include its effect, and the row of the positioner does not apply.",
            set(options.positioner_gain)
        ),
    ];
    if model.describe().motion == Motion::Staircase {
        said.push(
            "This valve model has a family of limit cycles. The predicted cycle is near the equilibrium, but the \
             initial state of the loop decides which cycle occurs."
                .to_owned(),
        );
    }
    if !plain || plant.valve.bare_model().is_none() {
        said.push(
            "The simulated valve has settings besides its model, S and J (limits, lag, overshoot). The predicted cycle \
             does not include these settings."
                .to_owned(),
        );
    }
    said
}
