//! One loop of the population, from its draw to its recording.

use super::design::Design;
use super::disturbance::Tapes;
use super::draw::Draw;
use super::plant::{Fitting, Plant, Played, TRANSMITTER};
use super::{Facts, Kind, Simulated, Truth};
use crate::bands::Bands;
use crate::error::Result;
use crate::recording::Recording;
use crate::series::{span, std};
use crate::valve::{AnyModel, HeWang, Model};

/// Loop number `index` of the population of `seed`: its kind is drawn by [`Kind::share`], then
/// everything else. It depends on these two numbers alone.
///
/// # Errors
/// As [`Kind::simulate`]: none is known.
pub fn member(seed: u64, index: u64) -> Result<Simulated> {
    let mut draw = Draw::of(&[seed, index, u64::from(super::VERSION)]);
    let kind = Kind::at(draw.unit());
    let mut simulated = kind.simulate(draw.seed())?;
    simulated.recording.name = format!("loop {index}");
    Ok(simulated)
}

/// A loop of this kind, if the draw shows what the kind is about and nothing worse.
///
/// What belongs to the valve and to the cause comes from streams of its own, so that the rest does not
/// depend on the kind.
pub(super) fn simulate(kind: Kind, draw: &mut Draw) -> Result<Option<Simulated>> {
    let (mut of_valve, mut of_cause) = (draw.fork(), draw.fork());
    let design = Design::draw(kind, draw);
    let tapes = Tapes::draw(kind, &design, draw)?;
    let mut plant = Plant::new(&design, &tapes, draw)?;
    let dead_band = if of_valve.chance(0.5) { of_valve.uniform(0.0, 0.25) } else { 0.0 };
    let healthy = [fitted(0, Model::Play.build(Bands::from_s_j(dead_band, 0.0)?)?)];
    let scale = (design.gain * design.activity).abs();
    match kind {
        Kind::DeadZoneElsewhere if of_cause.chance(0.55) => {
            plant.sensor_play = scale * of_cause.log(0.3, 2.0);
        }
        Kind::DeadZoneElsewhere => plant.gap = scale * of_cause.log(0.15, 1.0),
        Kind::QuantisedPv => {
            plant.quantum = std(&plant.play(&healthy)?.pv) * of_cause.uniform(0.6, 2.5);
        }
        _ => {}
    }

    let mut valve = Valve { model: None, s: dead_band, j: 0.0, share: 0.0, fittings: vec![] };
    let (played, visible, twin_ratio);
    match kind {
        Kind::Sticky => {
            valve = sticking(&design, &healthy[0], &mut of_valve)?;
            played = plant.play(&valve.fittings)?;
            let twin = plant.play(&healthy)?;
            let error = |run: &Played| std(&differences(&run.pv, &run.sp));
            twin_ratio = error(&played) / error(&twin);
            visible = is_visible(&played, valve.s, twin_ratio);
        }
        Kind::Stuck => {
            valve = stuck(&design, &healthy[0], &mut of_valve)?;
            let (run, beside) = plant.play_beside(&valve.fittings, &healthy)?;
            let missing = std(&differences(&beside, &run.pv));
            let noise = std(&tapes.noise[design.warm_up..]);
            visible = missing >= 3.0 * noise && missing >= 0.5 * std(&run.pv);
            (played, twin_ratio) = (run, 1.0);
        }
        _ => (played, visible, twin_ratio) = (plant.play(&healthy)?, false, 1.0),
    }

    let at = |limit: f64| move |op: &&f64| (**op - limit).abs() < 1e-9;
    let share_at =
        |x: &[f64], limit: f64| x.iter().filter(at(limit)).count() as f64 / x.len() as f64;
    let at_limit: f64 =
        [design.limits.0, design.limits.1].map(|l| share_at(&played.op, l)).iter().sum();
    let clipped: f64 = [TRANSMITTER.0, TRANSMITTER.1].map(|l| share_at(&played.pv, l)).iter().sum();
    let op_travel = span(&played.op);
    let finite = played.pv.iter().chain(&played.op).all(|v| v.is_finite());
    let serves = match kind {
        Kind::Saturation => at_limit >= 0.02,
        // A loop that has gone to its end before the record begins shows nothing.
        Kind::Stuck => op_travel >= 2.0 && at_limit <= 0.9,
        Kind::AggressiveTuning => op_travel > 0.0,
        Kind::QuantisedPv => at_limit <= 0.4 && clipped <= 0.2 && span(&played.pv) >= plant.quantum,
        _ => op_travel > 0.0 && at_limit <= 0.4 && clipped <= 0.2,
    };
    if !(finite && serves && twin_ratio.is_finite()) {
        return Ok(None);
    }

    let historian = &design.historian;
    let op = historian.op(&played.op, design.steps);
    let (low, span) = design.pv_range;
    let in_units =
        |percent: &[f64]| -> Vec<f64> { percent.iter().map(|v| low + span / 100.0 * v).collect() };
    let pv = in_units(&historian.pv(&played.pv, design.steps));
    let last = |x: &[f64]| -> Vec<f64> {
        x.chunks_exact(design.steps).map(|sample| sample[design.steps - 1]).collect()
    };
    let sp = design.sp_recorded.then(|| in_units(&last(&played.sp)));
    let mut recording = Recording::regular("", design.sample_time, &op, Some(&pv), sp.as_deref())?;
    recording.loop_type = design.loop_type;
    let facts = Facts {
        process: design.process,
        gain: design.gain,
        tau_s: design.tau,
        tau2_s: design.tau2,
        dead_time_s: design.dead_time,
        valve_lag_s: design.valve_lag,
        pv_filter_s: design.pv_filter,
        kc: design.kc,
        ti_s: design.ti,
        td_s: design.td,
        gain_margin: design.gain_margin,
        few_events: design.few_events,
        op_low: design.limits.0,
        op_high: design.limits.1,
        sample_time_s: design.sample_time,
        steps_per_sample: design.steps,
        activity: design.activity,
        noise: design.noise,
        noise_ratio: design.noise_ratio,
        non_stationary: design.non_stationary,
        set_point: design.set_point,
        sensor_play: plant.sensor_play,
        controller_gap: plant.gap,
        transmitter_quantum: plant.quantum,
        averaged: historian.averaged,
        held_samples: historian.hold,
        op_quantum: historian.op_quantum,
        pv_quantum: historian.pv_quantum,
        compression: historian.deviation,
        faulty_share: valve.share,
        op_travel,
        at_limit,
        twin_ratio,
        redrawn: 0,
    };
    let truth = Truth {
        kind,
        sticks: kind.sticks(),
        model: valve.model,
        s: valve.s,
        j: valve.j,
        visible,
        slips: if kind.sticks() { slips(&played.stem) } else { 0 },
        vp: last(&played.vp),
        facts,
    };
    Ok(Some(Simulated { recording, truth }))
}

/// A valve at fault.
struct Valve {
    model: Option<Model>,
    s: f64,
    j: f64,
    /// Share of the record in which it is so.
    share: f64,
    fittings: Vec<Fitting>,
}

fn fitted(from: usize, model: AnyModel) -> Fitting {
    Fitting { from, model, position: None }
}

/// A valve that sticks, for one loop in eight not all the time, or not all the time as much.
fn sticking(design: &Design, healthy: &Fitting, draw: &mut Draw) -> Result<Valve> {
    let model = draw.weighted([
        (Model::TwoPhase, 0.60),
        (Model::He, 0.25),
        (Model::Choudhury, 0.03),
        (Model::Kano, 0.03),
        (Model::HeWang, 0.03),
        (Model::Stenman, 0.03),
        (Model::Chen, 0.03),
    ]);
    let s = design.s;
    let j = s * match draw.unit() {
        // One band is all it knows.
        _ if model == Model::Stenman => 1.0,
        place if place < 0.85 => draw.uniform(0.03, 1.0),
        place if place < 0.92 => 1.0,
        _ => 0.0,
    };
    let overshoot = draw.uniform(1.0, 2.0);
    let build = |factor: f64| -> Result<AnyModel> {
        let bands = Bands::from_s_j(factor * s, factor * j)?;
        Ok(match model {
            Model::HeWang => AnyModel::HeWang(HeWang::new(bands, overshoot)?),
            _ => model.build(bands)?,
        })
    };
    let record = design.all_steps() - design.warm_up;
    let mut fittings = vec![fitted(0, build(1.0)?)];
    let mut share = 1.0;
    if draw.chance(0.12) {
        // One stretch of the record, of up to two thirds, in which it is another valve.
        let from = draw.uniform(0.0, 0.95);
        let until = (from + draw.uniform(0.15, 0.65)).min(1.0);
        let at = |place: f64| design.warm_up + (place * record as f64) as usize;
        let other = match draw.chance(0.5) {
            true => healthy.model.clone(),
            false => build(draw.uniform(0.2, 2.0))?,
        };
        fittings.push(fitted(at(from), other));
        if until < 1.0 {
            fittings.push(fitted(at(until), build(1.0)?));
        }
        share = 1.0 - (until - from);
    }
    Ok(Valve { model: Some(model), s, j, share, fittings })
}

/// A valve that from some step on does not move: seized, shut, or open.
fn stuck(design: &Design, healthy: &Fitting, draw: &mut Draw) -> Result<Valve> {
    /// Its static band is the whole span.
    const S: f64 = 200.0;
    let record = design.all_steps() - design.warm_up;
    let (from, share) = match draw.chance(0.6) {
        true => (design.warm_up - (0.1 * draw.unit() * design.warm_up as f64) as usize, 1.0),
        false => {
            let place = draw.uniform(0.0, 0.3);
            (design.warm_up + (place * record as f64) as usize, 1.0 - place)
        }
    };
    let position = draw.weighted([(None, 0.6), (Some(0.0), 0.25), (Some(100.0), 0.15)]);
    let model = Model::TwoPhase;
    let seized = Fitting { from, model: model.build(Bands::from_s_j(S, 0.0)?)?, position };
    let before = fitted(0, healthy.model.clone());
    Ok(Valve { model: Some(model), s: S, j: 0.0, share, fittings: vec![before, seized] })
}

/// Whether a record can show that the valve sticks; see [`Truth::visible`].
fn is_visible(played: &Played, s: f64, twin_ratio: f64) -> bool {
    let travel = span(&played.op);
    let follows = std(&differences(&played.op, &played.stem)) < 0.35 * std(&played.op);
    let harmless = travel < s && twin_ratio <= 1.05;
    let rests = travel < s / 2.0 && slips(&played.stem) == 0;
    !(follows || harmless || rests)
}

/// How often the stem begins to move.
fn slips(stem: &[f64]) -> usize {
    stem.windows(3).filter(|x| x[0] == x[1] && x[1] != x[2]).count()
}

fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
