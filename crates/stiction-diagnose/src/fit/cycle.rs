//! Whether the fitted valve causes the recorded swing.
//!
//! # Method
//! Two comparisons, each over all drawn loops. One of them is enough:
//! * The exact limit cycle: the loop would oscillate like this without any disturbance. Noise and loads make a stem
//!   slip sooner, so a recorded oscillation may be faster.
//! * The PV with a valve that follows ([`without`](super::without)): if much of the swing disappears, the valve causes
//!   it, together with any other disturbance.

use super::Draw;
use super::draw;
use super::valve::{Weighed, quantiles};
use super::without::left;
use crate::diagnose::Diagnosis;
use crate::fusion::Estimate;
use crate::identify::controller::FittedController;
use crate::limit_cycle::exact;
use crate::oscillation::swing;
use crate::parallel::*;
use crate::recording::Segment;
use crate::spoken::{rough, time};
use crate::valve::Model;

/// Factor by which the recorded period may lie outside the interval of the predicted periods. Noise and loads make a
/// stem slip sooner than it would without them.
pub const PERIOD_WITHIN: [f64; 2] = [1.15, 1.6];
/// This factor for the OP's swing, which noise, loads and a varying S change more.
pub const SWING_WITHIN: f64 = 1.5;
/// Share of the drawn loops that must cycle for the valve to explain the recorded swing.
pub const LEAST_CYCLING: f64 = 0.5;

/// Largest share of the swing that may remain with a valve that follows, in the median of the draws. The swing may grow
/// in hardly any draw.
pub const MOST_LEFT: f64 = 0.7;

/// Largest factor between period or OP swing of a fitted loop and the recorded ones for its valve to be preferred, and the
/// weight of the other valves.
const ALIKE: f64 = 2.0;
const UNLIKE: f64 = 0.05;

/// The recorded oscillation of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Swing {
    /// Period, s.
    pub period_s: f64,
    /// Amplitude of the OP, percent of span, as defined for `Oscillation`.
    pub op: f64,
    /// Amplitude of the PV about the set point, in PV units, as defined for `Oscillation`.
    pub pv: f64,
}

/// The limit cycle of the fitted loop without disturbances.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Predicted {
    /// Period of the limit cycle, s.
    pub period_s: Estimate,
    /// Half of the OP's peak-to-peak value, percent of span.
    pub op: Estimate,
    /// Half of the PV's peak-to-peak value, in PV units.
    pub pv: Estimate,
}

/// The recorded swing, the limit cycle of the fitted loop, and the swing if the valve followed the OP.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Cycle {
    /// The recorded oscillation; `None` if nothing oscillates.
    pub recorded: Option<Swing>,
    /// The predicted oscillation; `None` if hardly any drawn loop has a limit cycle.
    pub predicted: Option<Predicted>,
    /// Share of the drawn loops that have a limit cycle.
    pub cycling: f64,
    /// Share of the PV's amplitude near the period that would remain if the valve followed the OP. `None` if nothing
    /// oscillates, or the share could not be computed.
    pub pv_swing_left: Option<Estimate>,
    /// Whether the valve explains the swing: the fitted loop has the recorded cycle, or most of the swing would vanish
    /// if the valve followed the OP. `None` if nothing oscillates.
    pub explained: Option<bool>,
    /// Whether and why the valve explains the swing, in a sentence.
    pub sentence: String,
    /// Of the drawn loops that cycle by themselves and whose S, J and gain are within their intervals, the loop with
    /// period and OP nearest to the recorded ones.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub nearest: Option<Draw>,
}

/// The limit cycle of a loop; `None` if it cannot be computed, and an inner `None` if the loop does not cycle.
fn follow(draw: &Draw) -> Option<Option<Swing>> {
    if draw.model == Model::Ideal {
        return Some(None);
    }
    match exact::cycle(&draw.continuous()) {
        Ok(exact::CycleOutcome::Cycles { cycles, .. }) => {
            let cycle = cycles.into_iter().find(|cycle| cycle.stable);
            Some(cycle.map(|c| Swing { period_s: c.period_s, op: c.half_pp.op, pv: c.half_pp.pv }))
        }
        Ok(exact::CycleOutcome::None { .. }) => Some(None),
        _ => None,
    }
}

/// The valves, with preference for valves whose loop cycles about as recorded. A PV in steps gives only the product of
/// J and gain, and with too small a J the loop would not cycle. The weight of the valves that follow stays.
pub(super) fn alike(
    mut valves: Vec<Weighed>,
    controller: &FittedController,
    step: f64,
    recorded: Swing,
) -> Vec<Weighed> {
    let near = |a: f64, b: f64| (a / b).ln().abs() < ALIKE.ln();
    let cycles = |process: &Weighed| {
        let loop_ = draw::made(controller, process, step, [0.0; 8]);
        let cycle = loop_.and_then(|loop_| follow(&loop_)).flatten();
        cycle.is_some_and(|c| near(c.period_s, recorded.period_s) && near(c.op, recorded.op))
    };
    let sticks = |all: &[Weighed]| -> f64 {
        all.iter().filter(|one| one.model != Model::Ideal).map(|one| one.weight).sum()
    };
    let before = sticks(&valves);
    let of_one = |a: &Weighed, b: &Weighed| a.model == b.model && a.bands == b.bands;
    let mut groups: Vec<&mut [Weighed]> = valves.chunk_by_mut(of_one).collect();
    groups.par_iter_mut().for_each(|group| {
        let likeliest = group.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        let unlike = likeliest.is_some_and(|one| one.model != Model::Ideal && !cycles(one));
        group.iter_mut().filter(|_| unlike).for_each(|one| one.weight *= UNLIKE);
    });
    let after = sticks(&valves);
    let all = valves.iter_mut().filter(|one| one.model != Model::Ideal);
    all.for_each(|one| one.weight *= before / after);
    valves
}

/// Tests the explanation; `typical` are draws within the intervals of S, J and gain.
pub(super) fn tested(
    recorded: Option<Swing>,
    segment: &Segment,
    draws: &[Draw],
    typical: impl Fn(&Draw) -> bool,
) -> Result<Cycle, String> {
    if draws.is_empty() {
        return Err("no loop could be drawn from the identified parts".to_owned());
    }
    let followed: Vec<(&Draw, Option<Swing>)> =
        draws.par_iter().filter_map(|draw| Some((draw, follow(draw)?))).collect();
    let nearest = recorded.and_then(|recorded| {
        let apart = |cycle: Swing| {
            (cycle.period_s / recorded.period_s).ln().abs() + (cycle.op / recorded.op).ln().abs()
        };
        let cycling = followed
            .iter()
            .filter(|(draw, _)| typical(draw))
            .filter_map(|(draw, cycle)| Some((*draw, apart((*cycle)?))));
        cycling.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(draw, _)| draw.clone())
    });
    let all: Vec<Option<Swing>> = followed.into_iter().map(|(_, cycle)| cycle).collect();
    if 2 * all.len() < draws.len() {
        return Err("the behaviour of the fitted loop could not be computed".to_owned());
    }
    let cycles: Vec<Swing> = all.iter().copied().flatten().collect();
    let cycling = cycles.len() as f64 / all.len() as f64;
    let of = |what: fn(&Swing) -> f64| {
        quantiles(&mut cycles.iter().map(|cycle| (what(cycle), 1.0)).collect::<Vec<_>>())
    };
    let predicted = (cycling >= 0.1).then(|| Predicted {
        period_s: of(|c| c.period_s),
        op: of(|c| c.op),
        pv: of(|c| c.pv),
    });
    let pv_swing_left = recorded.and_then(|recorded| left(draws, segment, recorded.period_s));
    let explained = recorded.map(|recorded| {
        let near = |value: f64, of: Estimate, [above, below]: [f64; 2]| {
            of.low / below <= value && value <= of.high * above
        };
        let as_predicted = predicted.is_some_and(|predicted| {
            near(recorded.period_s, predicted.period_s, PERIOD_WITHIN)
                && near(recorded.op, predicted.op, [SWING_WITHIN; 2])
        });
        (cycling >= LEAST_CYCLING && as_predicted)
            || pv_swing_left.is_some_and(|left| left.value < MOST_LEFT && left.high < 1.0)
    });
    let sentence = String::new();
    let mut cycle =
        Cycle { recorded, predicted, cycling, pv_swing_left, explained, sentence, nearest };
    cycle.sentence = self::sentence(&cycle);
    Ok(cycle)
}

/// The detected oscillation as numbers.
pub(super) fn recorded(diagnosis: &Diagnosis, segment: &Segment) -> Option<Swing> {
    let (_, oscillation) = diagnosis.oscillation().filter(|(_, found)| found.found)?;
    let period_s = oscillation.period_s?;
    let of = |x: &[f64]| swing(x, period_s / segment.sample_time);
    Some(Swing { period_s, op: of(&segment.op)?, pv: of(&segment.deviation()?)? })
}

fn sentence(cycle: &Cycle) -> String {
    let fitted = match (&cycle.predicted, cycle.cycling) {
        (Some(p), c) if c >= LEAST_CYCLING => format!(
            "limit cycle with a period of {} to {} and OP ±{} to ±{} %",
            time(p.period_s.low),
            time(p.period_s.high),
            rough(p.op.low),
            rough(p.op.high)
        ),
        (_, c) if c > 0.0 => format!("{:.0} % of the fitted loops limit-cycle", 100.0 * c),
        _ => "no limit cycle".to_owned(),
    };
    let Some(recorded) = cycle.recorded else {
        return format!("The recording has no oscillation. Fitted: {fitted}.");
    };
    // The amount is that of a repair, among the prospects.
    let left = cycle.pv_swing_left.map_or(String::new(), |left| {
        let so = match (left.high < 0.995, left.low < 0.995) {
            (true, _) => "would be smaller than recorded",
            (false, true) => "may or may not be smaller than recorded",
            (false, false) => "would not be smaller than recorded",
        };
        format!("; with a valve that follows its OP, the PV swing {so}")
    });
    let so = match cycle.explained {
        Some(true) => "The valve explains the swing",
        _ => "The valve does not explain the swing",
    };
    format!(
        "Recorded: period {}, OP ±{} %. Fitted: {fitted}{left}. {so}.",
        time(recorded.period_s),
        rough(recorded.op)
    )
}
