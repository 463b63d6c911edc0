//! Slow ramps of the OP in manual, up and down, with the PV instead of a position.
//!
//! # Equations
//! A process with a characteristic f and a lag that is short beside the ramp has the PV f(x) of a late stem x. A
//! polynomial of the PV, fitted to the OP by least squares, is f^-1 between the branches. The PV becomes f^-1(PV),
//! percent of OP, and is judged like a [recorded position that lags](crate::identify::lagged_position), with the lag of
//! the process as the lag of the stem.
//!
//! # Assumptions
//! The controller is in manual during all ramps, the process settles by itself, and its lag is below an eighth of a ramp. A
//! load that drifts moves the branches apart or together; two runs up and down distinguish it from a dead band.
//!
//! # References
//! Ours.

use super::signature::Signature;
use crate::diagnose::VerdictClass;
use crate::estimate::Estimate;
use crate::identify::lagged_position::{Behaviour, Interval, Moves, judge};
use crate::numeric::least_squares::least_squares;
use crate::series::{max, min};
use crate::spoken::{rough, time};

/// Largest number of samples that are judged: of more, every second, third, … is used.
const MOST_SAMPLES: usize = 1200;
/// Degrees of a characteristic that are tried.
const DEGREES: [i32; 3] = [5, 3, 1];
/// Largest limit of S that clears a valve, percent, and largest t of one that follows, as in the judgement of a position.
const CLEARS: (f64, f64) = (2.0, 2.5);

/// The OP, percent, at which a valve that follows gives a PV: a polynomial of `(PV - middle) / half`.
#[derive(Debug, Clone, PartialEq)]
pub struct Characteristic {
    middle: f64,
    half: f64,
    factors: Vec<f64>,
}

impl Characteristic {
    /// That of OP and PV, of the highest degree that is monotone. `None` if the PV does not move.
    fn of(op: &[f64], pv: &[f64]) -> Option<Self> {
        let (low, high) = (min(pv), max(pv));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let fitted = |degree: i32| {
            let power = |n: i32| -> Vec<f64> {
                pv.iter().map(|pv| ((pv - middle) / half).powi(n)).collect()
            };
            let columns: Vec<Vec<f64>> = (0..=degree).map(power).collect();
            let columns: Vec<&[f64]> = columns.iter().map(|column| &column[..]).collect();
            Some(Self { middle, half, factors: least_squares(&columns, op)?.coefficients })
        };
        let monotone = |of: &Self| {
            let at = |k: i32| of.position(low + 0.05 * f64::from(k) * (high - low));
            let steps: Vec<f64> = (0..20).map(|k| at(k + 1) - at(k)).collect();
            min(&steps) * max(&steps) > 0.0
        };
        DEGREES.into_iter().filter(|_| half > 0.0).filter_map(fitted).find(monotone)
    }

    /// The valve position that corresponds to this PV, percent of OP.
    pub fn position(&self, pv: f64) -> f64 {
        let z = (pv - self.middle) / self.half;
        self.factors.iter().rev().fold(0.0, |sum, factor| sum * z + factor)
    }
}

/// Reads S and J from OP and PV of the ramps, sampled every `dt` seconds.
pub(super) fn measure(op: &[f64], pv: &[f64], dt: f64, found: &mut Signature) {
    let every = op.len().div_ceil(MOST_SAMPLES);
    let thinned = |x: &[f64]| -> Vec<f64> { x.iter().step_by(every).copied().collect() };
    let (op, pv) = (thinned(op), thinned(pv));
    let Some(characteristic) = Characteristic::of(&op, &pv) else {
        found.class = VerdictClass::DoesNotRespond;
        found.reasons.push("the PV does not move".to_owned());
        return;
    };
    let seen: Vec<f64> = pv.iter().map(|pv| characteristic.position(*pv)).collect();
    found.vp = [min(&seen), max(&seen)];
    found.characteristic = Some(characteristic);
    let judged = match judge(&op, &seen, Moves::Recorded) {
        Ok(judged) => judged,
        Err(why) => return found.reasons.push(why.0),
    };
    let lag = (judged.lag + judged.second_lag + judged.delay) * dt * every as f64;
    let estimate =
        |of: Interval| Estimate { value: of.value, low: of.low, high: of.high.max(of.value) };
    found.reasons.push(match judged.behaviour {
        Behaviour::Sticks => {
            found.class = VerdictClass::Sticks;
            (found.s, found.j) = (Some(estimate(judged.s)), Some(estimate(judged.j)));
            format!("no valve that follows the OP explains the PV, which lags by {}", time(lag))
        }
        Behaviour::Follows | Behaviour::Open
            if judged.t <= CLEARS.1 && judged.s_limit <= CLEARS.0 =>
        {
            found.class = VerdictClass::DoesNotStick;
            let s = Interval { high: judged.s_limit, ..judged.s };
            found.s = Some(estimate(s));
            format!("the PV follows the OP with a lag of {}", time(lag))
        }
        Behaviour::DoesNotMove => {
            found.class = VerdictClass::DoesNotRespond;
            "the PV does not follow the OP".to_owned()
        }
        Behaviour::Follows | Behaviour::Open => format!(
            "S may be up to {} %; ramp up and down twice, more slowly and at a calmer time",
            rough(judged.s_limit)
        ),
    });
}
