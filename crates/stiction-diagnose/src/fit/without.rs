//! The PV behind a valve that follows its OP, and the disturbance of the PV.
//!
//! # Equations
//! The difference `w = OP - VP` adds to the output of a valve that follows. The PV with such a valve differs from
//! the recorded PV by the loop's response to `w`, with any disturbance:
//! ```text
//! PV' - PV = P (C (PV' - PV) + w)
//! ```
//! So the disturbance need not be known. Under a strong controller the process hardly matters: the PV moves by
//! `w / C`.
//!
//! # Assumptions
//! A linear controller away from its limits, a linear process, and a stem that moved as the model says.

use super::Draw;
use super::valve::{path, quantiles};
use crate::bands::Bands;
use crate::closed_loop::{ClosedLoop, DeadTime, Signal};
use crate::fusion::Estimate;
use crate::parallel::*;
use crate::recording::Segment;
use crate::series::{detrended, mean, periodogram};
use crate::valve::{Assembly, Model};

/// Number of draws to follow.
const FOLLOWED: usize = 30;
/// The swing consists of these multiples of its frequency.
const BAND: [f64; 2] = [0.7, 1.4];
/// If the swing is this multiple of the recorded swing, or more, the loop is unstable.
const RUNS_AWAY: f64 = 10.0;
/// Most executions of the controller between two samples that are followed one by one.
const MOST_EXECUTIONS: f64 = 20.0;

/// Share of the PV's swing of this period that would remain: median, 5 and 95 % points over the draws. `None` if it
/// cannot be computed.
pub fn left(draws: &[Draw], segment: &Segment, period_s: f64) -> Option<Estimate> {
    let pv = segment.pv.as_deref()?;
    let swing = |pv: &[f64]| swing_at(pv, segment.sample_time / period_s);
    let recorded = swing(pv);
    let every = draws.len().div_ceil(FOLLOWED).max(1);
    let one = |draw: &&Draw| -> Option<f64> {
        let without = without(draw, segment)?;
        let share = swing(&without) / recorded;
        // A loop that runs away as soon as its valve follows is hardly the recorded one, and explains nothing.
        Some(if share < RUNS_AWAY { share } else { RUNS_AWAY })
    };
    let followed: Vec<&Draw> = draws.iter().step_by(every).collect();
    let mut shares: Vec<(f64, f64)> =
        followed.par_iter().filter_map(one).map(|share| (share, 1.0)).collect();
    (!shares.is_empty() && 2 * shares.len() >= followed.len()).then(|| quantiles(&mut shares))
}

/// The PV of a drawn loop if its valve had followed.
fn without(draw: &Draw, segment: &Segment) -> Option<Vec<f64>> {
    let (op, pv) = (&segment.op, segment.pv.as_deref()?);
    if draw.model == Model::Ideal {
        return Some(pv.to_vec());
    }
    let failed: Vec<f64> = op.iter().zip(stem(draw, segment)?).map(|(op, vp)| op - vp).collect();
    let usual = mean(&failed);
    let step = segment.sample_time;
    let executions = (step / draw.execution_s).round().clamp(1.0, MOST_EXECUTIONS) as usize;
    let held = failed.iter().flat_map(|w| std::iter::repeat_n(w - usual, executions));
    let follows = Assembly::new(Model::Ideal.build(Bands::NONE).ok()?);
    let mut difference = ClosedLoop::new(draw.controller.clone(), follows, draw.process.clone());
    difference.sample_time = step / executions as f64;
    difference.samples = op.len() * executions;
    difference.load = vec![Signal::Samples(held.collect())];
    let run = difference.run().ok()?;
    Some(run.pv.iter().step_by(executions).zip(pv).map(|(more, pv)| pv + more).collect())
}

/// The disturbance of the PV during the recording, for a drawn loop: the part that its valve and process do not
/// explain, less its mean and slope.
pub(super) fn disturbance(draw: &Draw, segment: &Segment) -> Option<Vec<f64>> {
    let (pv, vp) = (segment.pv.as_deref()?, stem(draw, segment)?);
    let process = draw.process.sampled(segment.sample_time, DeadTime::default()).ok()?;
    let usual = mean(&vp);
    let made = process.answer(vp.iter().map(|vp| vp - usual));
    let left: Vec<f64> = pv.iter().zip(made).map(|(pv, made)| pv - made).collect();
    left.iter().all(|v| v.is_finite()).then(|| detrended(&left))
}

/// The stem position, for a drawn valve.
fn stem(draw: &Draw, segment: &Segment) -> Option<Vec<f64>> {
    match &segment.vp {
        Some(vp) => Some(vp.clone()),
        None => path(draw.model, draw.bands, &segment.op),
    }
}

/// Root of the power around a frequency, cycles per sample.
fn swing_at(x: &[f64], frequency: f64) -> f64 {
    let found = periodogram(x);
    let near = |f: &f64| BAND[0] * frequency <= *f && *f <= BAND[1] * frequency;
    let power = found.frequency.iter().zip(&found.power).filter(|(f, _)| near(f)).map(|(_, p)| p);
    power.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{Controller, Process, Wave};
    use crate::series::{max, min};

    const PERIOD_S: f64 = 40.0;

    /// A loop that is known, and 4,000 samples of it.
    fn recorded(model: Model, wave: f64) -> (Draw, Segment) {
        let draw = Draw {
            controller: Controller::pid(1.0, 8.0, 0.0).unwrap(),
            process: Process::first_order(1.0, 10.0, 2.0).unwrap(),
            model,
            bands: Bands::from_s_j(3.0, 1.0).unwrap(),
            execution_s: 0.5,
        };
        let valve = Assembly::new(draw.model.build(draw.bands).unwrap());
        let mut plant = ClosedLoop::new(draw.controller.clone(), valve, draw.process.clone());
        (plant.sample_time, plant.samples) = (0.5, 4_000);
        plant.set_point = Signal::step(0.0, 5.0, 1.0);
        plant.measurement = vec![Signal::Periodic {
            wave: Wave::Sine,
            mean: 0.0,
            amplitude: wave,
            period_s: PERIOD_S,
            phase: 0.0,
        }];
        let run = plant.run().unwrap();
        let cut = |x: &[f64]| x[1_000..].to_vec();
        let segment = Segment {
            from: 0.0,
            sample_time: 0.5,
            op: cut(&run.op),
            pv: Some(cut(&run.pv)),
            sp: None,
            vp: None,
            bridged: 0,
        };
        (draw, segment)
    }

    #[test]
    fn nothing_is_left_of_a_swing_that_the_valve_makes() {
        let (draw, segment) = recorded(Model::TwoPhase, 0.0);
        let pv = without(&draw, &segment).unwrap();
        let late = &pv[1_000..];
        let now = segment.pv.as_ref().unwrap();
        assert!(max(now) - min(now) > 1.0);
        assert!(max(late) - min(late) < 0.01, "{} to {}", min(late), max(late));
        let draws = vec![draw; 3];
        let period = 60.0;
        let left = left(&draws, &segment, period).unwrap();
        assert!(left.high < 0.2, "{left:?}");
    }

    #[test]
    fn all_is_left_behind_a_valve_that_follows() {
        let (draw, segment) = recorded(Model::Ideal, 0.5);
        assert_eq!(without(&draw, &segment), segment.pv);
        assert_eq!(left(&[draw], &segment, PERIOD_S).unwrap().value, 1.0);
    }

    #[test]
    fn a_wave_from_outside_is_left() {
        // The same wave behind a valve that sticks: what is left is what a valve that follows would have shown.
        let (draw, segment) = recorded(Model::TwoPhase, 2.0);
        let (_, healthy) = recorded(Model::Ideal, 2.0);
        let pv = without(&draw, &segment).unwrap();
        let off = |k: usize| (pv[k] - healthy.pv.as_ref().unwrap()[k]).abs();
        assert!((1_000..3_000).all(|k| off(k) < 0.01));
    }

    #[test]
    fn the_disturbance_is_found() {
        let (draw, segment) = recorded(Model::TwoPhase, 2.0);
        let found = disturbance(&draw, &segment).unwrap();
        let late = &found[1_000..];
        assert!((0.5 * (max(late) - min(late)) - 2.0).abs() < 0.1);
    }
}
