//! Whether the valve that was fitted makes the swing that was recorded.
//!
//! # What it computes
//! Two answers, each over all loops drawn; one of them is enough:
//! * The exact limit cycle: the loop would swing so by itself, without any disturbance. Noise and loads make a stem slip
//!   sooner, and a recorded swing may be faster than that.
//! * What the PV would have done behind a valve that follows ([`without`](super::without)): if a
//!   good part of the swing were gone, the valve makes it, whatever else moves the loop.

use super::Draw;
use super::valve::quantiles;
use super::without::left;
use crate::diagnose::Diagnosis;
use crate::fusion::Estimate;
use crate::limit_cycle::exact;
use crate::parallel::*;
use crate::recording::Segment;
use crate::spoken::{rough, time};
use crate::valve::Model;

/// By what factor the recorded period may lie above the interval of the predicted ones, and below it: noise and loads
/// make a stem slip sooner than it would by itself.
pub const PERIOD_WITHIN: [f64; 2] = [1.15, 1.6];
/// The same for the OP's swing, which noise, loads and a varying S change more.
pub const SWING_WITHIN: f64 = 1.5;
/// Share of the loops drawn that must cycle for the recording's swing to be explained by its valve.
pub const LEAST_CYCLING: f64 = 0.5;

/// The most of the swing that may be left by a valve that follows, in the median of the draws; in hardly a draw may it
/// grow.
pub const MOST_LEFT: f64 = 0.7;

/// A swing of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Swing {
    /// Its period, s.
    pub period_s: f64,
    /// Half of the OP's typical peak-to-peak value, percent.
    pub op: f64,
    /// The same of the PV, in its units.
    pub pv: f64,
}

/// What the fitted loop does by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Predicted {
    /// Period of its limit cycle, s.
    pub period_s: Estimate,
    /// Half of the OP's peak-to-peak value, percent.
    pub op: Estimate,
    /// The same of the PV, in its units.
    pub pv: Estimate,
}

/// The limit cycle of the fitted loop beside what was recorded.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Cycle {
    /// What was recorded; `None` where nothing oscillates.
    pub recorded: Option<Swing>,
    /// What was predicted; `None` where hardly a loop drawn cycles.
    pub predicted: Option<Predicted>,
    /// Share of the loops drawn that cycle at all.
    pub cycling: f64,
    /// Share of the PV's swing that would be left, had the valve followed its OP; `None` where nothing oscillates, and
    /// where it could not be computed.
    pub pv_swing_left: Option<Estimate>,
    /// Whether the valve explains the swing: the fitted loop cycles as the recording does, or at most
    /// [`MOST_LEFT`] of the swing would be left without it. `None` where nothing oscillates.
    pub explained: Option<bool>,
    /// The same in words.
    pub sentence: String,
    /// Of the loops drawn that cycle by themselves, and whose S, J and gain lie within their intervals, the one whose
    /// period and OP are nearest to the recorded ones.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub nearest: Option<Draw>,
}

/// Tests the explanation; `typical` are draws within the intervals of S, J and gain.
pub(super) fn tested(
    diagnosis: &Diagnosis,
    segment: &Segment,
    draws: &[Draw],
    typical: impl Fn(&Draw) -> bool,
) -> Result<Cycle, String> {
    if draws.is_empty() {
        return Err("no loop could be drawn from what was identified".to_owned());
    }
    let recorded = recorded(diagnosis, segment);
    let follow = |draw: &Draw| -> Option<Option<Swing>> {
        if draw.model == Model::Ideal {
            return Some(None);
        }
        match exact::cycle(&draw.continuous()) {
            Ok(exact::CycleOutcome::Cycles { cycles, .. }) => {
                let cycle = cycles.into_iter().find(|cycle| cycle.stable);
                Some(cycle.map(|c| Swing {
                    period_s: c.period_s,
                    op: c.half_pp.op,
                    pv: c.half_pp.pv,
                }))
            }
            Ok(exact::CycleOutcome::None { .. }) => Some(None),
            _ => None,
        }
    };
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
        return Err("what the fitted loop does by itself could not be computed".to_owned());
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

/// The oscillation that was found, as numbers.
fn recorded(diagnosis: &Diagnosis, segment: &Segment) -> Option<Swing> {
    let (_, oscillation) = diagnosis.oscillation().filter(|(_, found)| found.found)?;
    let period_s = oscillation.period_s?;
    let swing = |x: &[f64]| swing_of(x, period_s, segment.sample_time);
    Some(Swing { period_s, op: swing(&segment.op)?, pv: swing(segment.pv.as_deref()?)? })
}

/// Half of a signal's typical peak-to-peak value over a period: the median over its periods, smoothed over a tenth of
/// one so that noise adds little. `None` if it lasts for less than one.
fn swing_of(x: &[f64], period_s: f64, sample_time: f64) -> Option<f64> {
    let length = ((period_s / sample_time).round() as usize).max(3);
    let x: Vec<f64> = x.windows((length / 10).max(1)).map(crate::series::mean).collect();
    let swings: Vec<f64> = x.chunks_exact(length).map(crate::series::span).collect();
    (!swings.is_empty()).then(|| 0.5 * crate::series::median(&swings))
}

fn sentence(cycle: &Cycle) -> String {
    let said = match (&cycle.predicted, cycle.cycling) {
        (Some(p), c) if c >= LEAST_CYCLING => format!(
            "the loop so fitted cycles by itself every {} to {}, its OP by ±{} to ±{} %",
            time(p.period_s.low),
            time(p.period_s.high),
            rough(p.op.low),
            rough(p.op.high)
        ),
        (_, c) if c > 0.0 => {
            format!(
                "the loop so fitted would cycle by itself in {:.0} % of what is possible",
                100.0 * c
            )
        }
        _ => "the loop so fitted does not cycle by itself".to_owned(),
    };
    let Some(recorded) = cycle.recorded else {
        return format!("Nothing oscillates in the recording; {said}.");
    };
    let left = cycle.pv_swing_left.map_or(String::new(), |left| {
        let [low, high] = [left.low, left.high].map(|share| format!("{:.0}", 100.0 * share));
        let range = if low == high { low } else { format!("{low} to {high}") };
        format!(", and had the valve followed its OP, {range} % of the PV's swing would be left")
    });
    let so = match cycle.explained {
        Some(true) => "its valve explains the swing",
        _ => "its valve does not explain the swing",
    };
    format!(
        "Recorded: every {}, OP by ±{} %; {said}{left}: {so}.",
        time(recorded.period_s),
        rough(recorded.op)
    )
}
