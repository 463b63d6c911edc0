//! One loop of the population: drawing, simulation, recording.

use super::design::Design;
use super::disturbance::Tapes;
use super::draw::Draw;
use super::families::DisturbanceKind;
use super::historian::Historian;
use super::plant::{Plant, Played};
use super::stem::Fitting;
use super::visibility::{NATS, Observed};
use super::{Facts, LoopKind, Simulated, Truth};
use stiction_diagnose::diagnose::HARMLESS;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::series::{span, std};
use stiction_model::bands::Bands;
use stiction_model::error::Result;
use stiction_model::valve::{AnyModel, Model, ValveSpec};

/// Loop number `index` of the population of `seed`: its kind is drawn by [`LoopKind::share`], then everything else. The
/// loop depends on these two numbers alone.
///
/// # Errors
/// As for [`LoopKind::simulate`]. No error is known.
pub fn member(seed: u64, index: u64) -> Result<Simulated> {
    let mut draw = Draw::of(&[seed, index, u64::from(super::VERSION)]);
    let kind = LoopKind::at(draw.unit());
    let mut simulated = kind.simulate(draw.seed())?;
    simulated.recording.name = format!("loop {index}");
    Ok(simulated)
}

/// A loop of this kind, if the draw shows the kind's pattern and nothing worse.
///
/// The valve and the cause have their own streams, so that the rest does not depend on the kind. A sticky valve has
/// the given S, percent, or the drawn one.
pub(super) fn simulate(
    kind: LoopKind,
    draw: &mut Draw,
    factor: f64,
    asked: Option<f64>,
    then: &mut dyn FnMut(&Scene<'_>, &Simulated) -> Result<()>,
) -> Result<Option<Simulated>> {
    let (mut of_valve, mut of_cause) = (draw.fork(), draw.fork());
    let mut design = Design::draw(kind, draw);
    design.record_for(factor);
    let tapes = Tapes::draw(kind, &design, draw)?;
    let mut plant = Plant::new(&design, &tapes, draw)?;
    let dead_band = if of_valve.chance(0.5) { of_valve.uniform(0.0, HARMLESS) } else { 0.0 };
    let healthy = [fitted(0, Model::Play.build(Bands::from_s_j(dead_band, 0.0)?)?)];
    let scale = (design.gain * design.activity).abs();
    match kind {
        LoopKind::DeadZoneElsewhere if of_cause.chance(0.55) => {
            plant.sensor_play = scale * of_cause.log(0.3, 2.0);
        }
        LoopKind::DeadZoneElsewhere => plant.gap = scale * of_cause.log(0.15, 1.0),
        LoopKind::QuantisedPv => {
            plant.quantum = std(&plant.play(&healthy)?.pv) * of_cause.uniform(0.6, 2.5);
        }
        _ => {}
    }

    let mut valve = Valve { model: None, s: dead_band, j: 0.0, share: 0.0, fittings: vec![] };
    let noise = std(&tapes.noise[design.warm_up..]);
    // Deviation of the PV from that of a healthy valve with the same OP.
    let (played, missing) = match kind {
        LoopKind::Sticky => {
            let s = design.s * beyond_what_happens(&mut of_valve.branch());
            let s = asked.unwrap_or(s.clamp(LEAST_S, MOST_S));
            valve = sticking(&design, s, &healthy[0], &mut of_valve)?;
            let run = plant.play(&valve.fittings)?;
            match moves(&run.stem) {
                true => (run, 0.0),
                // It is as good as stuck, and looks like it.
                false => {
                    let (run, beside) = plant.play_both(&valve.fittings, &healthy)?;
                    let missing = std(&differences(&beside, &run.pv));
                    (run, missing)
                }
            }
        }
        LoopKind::StickyBelow | LoopKind::Stuck => {
            valve = match kind {
                LoopKind::Stuck => stuck(&design, &healthy[0], &mut of_valve)?,
                _ => sticking(&design, design.s, &healthy[0], &mut of_valve)?,
            };
            let (run, beside) = plant.play_both(&valve.fittings, &healthy)?;
            let missing = std(&differences(&beside, &run.pv));
            (run, missing)
        }
        _ => (plant.play(&healthy)?, 0.0),
    };

    if !(missing.is_finite() && serves(kind, &design, &plant, &played)) {
        return Ok(None);
    }

    let seen = design.historian.pv(&played.pv, design.steps);
    // A swinging door may keep only one value.
    if span(&seen) == 0.0 {
        return Ok(None);
    }
    let slips = match kind {
        LoopKind::Sticky | LoopKind::StickyBelow => slips(&played.stem),
        _ => 0,
    };
    let gain = match kind {
        LoopKind::Sticky => Observed {
            recorded: &seen,
            pv: &played.pv,
            op: &played.op,
            stem: &played.vp,
            steps: design.steps,
            dead_time: design.dead_time / design.step(),
        }
        .gain(),
        _ => 0.0,
    };
    let moved = !kind.sticks() || moves(&played.stem);
    let visible = match kind {
        LoopKind::Sticky if moved => slips > 0 && gain >= NATS,
        LoopKind::StickyBelow => slips >= 2 && missing >= noise,
        LoopKind::Sticky | LoopKind::Stuck => {
            missing >= 3.0 * noise && missing >= 0.5 * std(&played.pv)
        }
        _ => false,
    };
    let facts = facts(&design, &plant, &played, tapes.kinds.clone(), valve.share);
    // Its actual bands, or those if it stuck.
    let band = if kind == LoopKind::Sticky { valve.s } else { design.s };
    let truth = Truth {
        kind,
        sticks: kind.sticks(),
        model: valve.model,
        s: valve.s,
        j: valve.j,
        visible,
        gain,
        swing: facts.op_travel / band,
        op_noise: design.op_noise() / band,
        slips,
        moves: moved,
        vp: last(&played.vp, design.steps),
        facts,
    };
    let simulated = Simulated { recording: recorded(&design, &design.historian, &played)?, truth };
    let fittings = if valve.fittings.is_empty() { &healthy } else { &valve.fittings[..] };
    then(&Scene { design: &design, plant: &plant, fittings }, &simulated)?;
    Ok(Some(simulated))
}

/// A simulated loop that can be simulated again.
pub(super) struct Scene<'a> {
    pub design: &'a Design,
    pub plant: &'a Plant<'a>,
    pub fittings: &'a [Fitting],
}

/// The recorded part of a run, in units of the plant.
pub(super) fn recorded(
    design: &Design,
    historian: &Historian,
    played: &Played,
) -> Result<Recording> {
    let (low, span) = design.pv_range;
    let in_units =
        |percent: &[f64]| -> Vec<f64> { percent.iter().map(|v| low + span / 100.0 * v).collect() };
    let op = historian.op(&played.op, design.steps);
    let pv = in_units(&historian.pv(&played.pv, design.steps));
    let sp = design.sp_recorded.then(|| in_units(&last(&played.sp, design.steps)));
    let mut recording = Recording::regular("", design.sample_time, &op, Some(&pv), sp.as_deref())?;
    recording.loop_type = design.loop_type;
    Ok(recording)
}

/// The value at the last step of each sample.
fn last(x: &[f64], steps: usize) -> Vec<f64> {
    x.chunks_exact(steps).map(|sample| sample[steps - 1]).collect()
}

/// Share of samples at a limit.
fn share_at(x: &[f64], (low, high): (f64, f64)) -> f64 {
    let at = |limit: f64| {
        x.iter().filter(|v| (**v - limit).abs() < 1e-9).count() as f64 / x.len() as f64
    };
    [low, high].map(at).iter().sum()
}

/// Whether a run shows the kind's pattern, and nothing worse.
fn serves(kind: LoopKind, design: &Design, plant: &Plant<'_>, played: &Played) -> bool {
    let (op_travel, at_limit) = (span(&played.op), share_at(&played.op, design.limits));
    let clipped = share_at(&played.pv, design.transmitter);
    let finite = played.pv.iter().chain(&played.op).all(|v| v.is_finite());
    let serves = match kind {
        LoopKind::Saturation => at_limit >= 0.02,
        LoopKind::Stuck => op_travel >= 2.0,
        LoopKind::StickingNeighbour if played.neighbour_slips < 4 => false,
        LoopKind::SwitchedNeighbour if played.switches < 2 => false,
        LoopKind::AggressiveTuning => op_travel > 0.0,
        LoopKind::QuantisedPv => {
            at_limit <= 0.4 && clipped <= 0.2 && span(&played.pv) >= plant.quantum
        }
        _ => op_travel > 0.0 && at_limit <= 0.4 && clipped <= 0.2,
    };
    // A loop that has run away to a limit and stays there shows nothing, for any kind.
    finite && serves && at_limit <= 0.9
}

/// Facts about a loop beside its truth.
fn facts(
    design: &Design,
    plant: &Plant<'_>,
    played: &Played,
    disturbances: Vec<DisturbanceKind>,
    faulty_share: f64,
) -> Facts {
    let historian = &design.historian;
    Facts {
        process: design.process,
        gain: design.gain,
        tau_s: design.tau,
        tau2_s: design.tau2,
        dead_time_s: design.dead_time,
        valve_lag_s: design.valve_lag,
        pv_filter_s: design.pv_filter,
        kc: design.kc,
        ti_s: if design.ti.is_finite() { design.ti } else { 0.0 },
        td_s: design.td,
        gain_margin: design.gain_margin,
        situation: design.situation,
        controller: design.controller,
        own_noise: design.own_noise,
        coupling: design.neighbour.as_ref().map_or(0.0, |one| one.there),
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
        op_compression: historian.doors[0],
        pv_compression: historian.doors[1],
        op_exception: historian.exceptions[0],
        pv_exception: historian.exceptions[1],
        historian: historian.kinds(design.steps),
        op_travel: span(&played.op),
        at_limit: share_at(&played.op, design.limits),
        disturbances,
        faulty_share,
        pv_span: design.pv_range.1,
        pv_low: design.pv_range.0,
        redrawn: 0,
    }
}

/// A faulty valve.
struct Valve {
    model: Option<Model>,
    s: f64,
    j: f64,
    /// Share of the record with the fault.
    share: f64,
    fittings: Vec<Fitting>,
}

pub(super) fn fitted(from: usize, model: AnyModel) -> Fitting {
    Fitting { from, model, position: None }
}

/// Bounds of a sticking valve's S, percent.
const LEAST_S: f64 = 0.5;
const MOST_S: f64 = 30.0;

/// Ratio of a sticking valve's S to the S that scales the activity. S is sometimes far larger than the OP's movement,
/// so that the valve often never slips, and sometimes smaller, so that the OP moves over many S.
fn beyond_what_happens(draw: &mut Draw) -> f64 {
    match draw.unit() {
        place if place < 0.06 => draw.log(1.5, 8.0),
        place if place < 0.18 => draw.log(0.3, 1.0),
        _ => 1.0,
    }
}

/// A valve that sticks by `s` percent; in one loop of eight only at times, or with a varying S.
fn sticking(design: &Design, s: f64, healthy: &Fitting, draw: &mut Draw) -> Result<Valve> {
    let model = draw.weighted([
        (Model::TwoPhase, 0.60),
        (Model::He, 0.25),
        (Model::Choudhury, 0.03),
        (Model::Kano, 0.03),
        (Model::HeWang, 0.03),
        (Model::Stenman, 0.03),
        (Model::Chen, 0.03),
    ]);
    let j = s * match draw.unit() {
        // It has only one band.
        _ if !model.describe().uses_s => 1.0,
        place if place < 0.6 => draw.uniform(0.03, 1.0),
        place if place < 0.85 => draw.log(0.01, 0.3),
        place if place < 0.92 => 1.0,
        _ => 0.0,
    };
    let overshoot = draw.uniform(1.0, 2.0);
    let build = |factor: f64| -> Result<AnyModel> {
        let bands = Bands::from_s_j(factor * s, factor * j)?;
        let overshoot = model.describe().uses_k.then_some(overshoot);
        let spec = ValveSpec { overshoot, ..ValveSpec::new(model, bands) };
        Ok(spec.build(None)?.model().clone())
    };
    let record = design.all_steps() - design.warm_up;
    let mut fittings = vec![fitted(0, build(1.0)?)];
    let mut share = 1.0;
    if draw.chance(0.12) {
        // One segment of the record, of up to two thirds, with a different valve.
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

/// A valve that does not move from some step on: seized, shut, or open.
fn stuck(design: &Design, healthy: &Fitting, draw: &mut Draw) -> Result<Valve> {
    /// Its static band is the whole span.
    const S: f64 = 200.0;
    // For any length of the later record.
    let record = (design.all_steps().min(design.drawn_steps)) - design.warm_up;
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

/// Number of slips of the stem.
fn slips(stem: &[f64]) -> usize {
    stem.windows(3).filter(|x| x[0] == x[1] && x[1] != x[2]).count()
}

/// Whether the stem moves during the record.
fn moves(stem: &[f64]) -> bool {
    stem.windows(2).any(|x| (x[1] - x[0]).abs() > 1e-9)
}

fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ControllerKind, ProcessKind, SetPointKind, Situation};
    use rayon::prelude::*;
    use stiction_diagnose::series::{max, min};

    fn members(n: u64) -> Vec<Simulated> {
        (0..n).into_par_iter().map(|k| member(5, k).unwrap()).collect()
    }

    fn of(kind: LoopKind, seeds: u64) -> Vec<Simulated> {
        (0..seeds).into_par_iter().map(|seed| kind.simulate(seed).unwrap()).collect()
    }

    #[test]
    fn a_member_depends_on_its_numbers_alone() {
        // Side by side and backwards against one after the other.
        let all = members(60);
        for (k, simulated) in all.iter().enumerate().rev() {
            assert_eq!(simulated, &member(5, k as u64).unwrap());
        }
        assert_ne!(all[0].recording.op, member(6, 0).unwrap().recording.op);
        for (k, one) in all.iter().enumerate() {
            for other in &all[..k] {
                assert_ne!(one.recording.op.values, other.recording.op.values);
                assert_ne!(one.recording.pv, other.recording.pv);
            }
        }
    }

    #[test]
    fn kinds_have_their_shares() {
        let all: f64 = LoopKind::ALL.iter().map(|kind| kind.share()).sum();
        assert!((all - 1.0).abs() < 1e-12);
        for kind in LoopKind::ALL {
            assert_eq!(LoopKind::by_name(kind.name()).unwrap(), kind);
            let n = 20_000;
            let hits =
                (0..n).filter(|k| LoopKind::at((*k as f64 + 0.5) / n as f64) == kind).count();
            assert!((hits as f64 / n as f64 - kind.share()).abs() < 2e-4, "{kind:?}");
        }
        let n = 600;
        let sticky = members(n).iter().filter(|m| m.truth.kind == LoopKind::Sticky).count();
        // Four standard deviations.
        assert!((sticky as f64 / n as f64 - 0.47).abs() < 4.0 * (0.47f64 * 0.53 / n as f64).sqrt());
    }

    #[test]
    fn recordings_are_those_of_plants() {
        let mut with_sp = 0;
        for Simulated { recording, truth } in members(300) {
            let (op, n) = (&recording.op.values, truth.vp.len());
            let name = &recording.name;
            assert!((300..=20_005).contains(&n) && op.len() == n, "{name}");
            let facts = &truth.facts;
            assert!(min(op) >= facts.op_low - 1e-9 && max(op) <= facts.op_high + 1e-9, "{name}");
            assert!(truth.vp.iter().all(|vp| (0.0..=100.0).contains(vp)), "{name}");
            let pv = &recording.pv.as_ref().unwrap().values;
            assert!(pv.len() == n && pv.iter().all(|v| v.is_finite()) && std(pv) > 0.0, "{name}");
            with_sp += usize::from(recording.sp.is_some());
            assert!(recording.vp.is_none());
            let numbers = [
                truth.s,
                truth.j,
                truth.gain,
                truth.swing,
                truth.op_noise,
                facts.kc,
                facts.op_travel,
            ];
            assert!(numbers.iter().all(|v| v.is_finite()), "{name}");
            assert_eq!(truth.sticks, truth.model.is_some());
            assert!(truth.sticks || (truth.s <= HARMLESS && truth.j == 0.0 && !truth.visible));
            let step = recording.op.time[1] - recording.op.time[0];
            assert_eq!(step, facts.sample_time_s);
        }
        assert!((150..210).contains(&with_sp), "{with_sp} of 300");
    }

    #[test]
    fn a_longer_record_is_the_same_loop_for_longer() {
        for kind in LoopKind::ALL {
            let mut seen = 0;
            for seed in 0..8 {
                let drawn = kind.simulate(seed).unwrap();
                assert_eq!(drawn, kind.simulate_for(seed, 1.0).unwrap());
                let long = kind.simulate_for(seed, 3.5).unwrap();
                let (n, m) = (drawn.truth.vp.len(), long.truth.vp.len());
                let (short, facts) = (&drawn.truth.facts, &long.truth.facts);
                if facts.redrawn != short.redrawn {
                    continue;
                }
                assert_eq!(m, (n as f64 * 3.5).round() as usize);
                assert_eq!(
                    (facts.kc, facts.ti_s, facts.noise),
                    (short.kc, short.ti_s, short.noise)
                );
                // It goes on: it does not begin anew.
                if short.faulty_share == facts.faulty_share && facts.faulty_share == 1.0
                    || !kind.sticks()
                {
                    let same = facts.transmitter_quantum == short.transmitter_quantum;
                    assert!(!same || long.truth.vp[..n] == drawn.truth.vp[..], "{kind:?} {seed}");
                    let pv = |one: &Simulated| one.recording.pv.clone().unwrap().values;
                    assert!(pv(&long)[n..2 * n] != pv(&drawn)[..], "{kind:?} {seed}");
                    seen += 1;
                }
            }
            assert!(seen > 0, "{kind:?}");
        }
        assert!(LoopKind::Normal.simulate_for(1, f64::NAN).is_err());
    }

    #[test]
    fn kinds_differ_in_valve_and_cause_alone() {
        let mut seen = 0;
        for seed in 0..60 {
            let sticky = LoopKind::Sticky.simulate(seed).unwrap();
            let normal = LoopKind::Normal.simulate(seed).unwrap();
            if sticky.truth.facts.redrawn != normal.truth.facts.redrawn {
                continue;
            }
            let mut facts = sticky.truth.facts.clone();
            let other = &normal.truth.facts;
            facts.faulty_share = 0.0;
            if facts.situation != other.situation {
                assert_eq!(other.situation, Situation::OuterLoop);
                continue;
            }
            seen += 1;
            (facts.op_travel, facts.at_limit) = (other.op_travel, other.at_limit);
            assert_eq!(&facts, other);
            assert_eq!(sticky.recording.loop_type, normal.recording.loop_type);
            if facts.set_point != SetPointKind::Cascade {
                assert_eq!(sticky.recording.sp, normal.recording.sp);
            }
        }
        assert!(seen > 35, "{seen}");
    }

    #[test]
    fn a_sticking_valve_stays_within_its_static_band() {
        let mut seen = 0;
        for Simulated { recording, truth } in of(LoopKind::Sticky, 800) {
            let facts = &truth.facts;
            let as_run = facts.steps_per_sample == 1
                && facts.valve_lag_s == 0.0
                && facts.op_quantum == 0.0
                && facts.op_compression == 0.0
                && facts.op_exception == 0.0
                && facts.situation != Situation::SlowActuator
                && facts.faulty_share == 1.0;
            if !as_run || truth.model != Some(Model::TwoPhase) {
                continue;
            }
            seen += 1;
            let fs = (truth.s + truth.j) / 2.0;
            let apart = differences(&recording.op.values, &truth.vp);
            let most = apart.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
            assert!(most <= fs + 1e-9, "{most} apart, fs {fs}: {facts:?}");
            if truth.visible && truth.slips > 0 {
                // It rests until the band is used up.
                assert!(apart.iter().any(|e| e.abs() > 0.5 * (truth.s - truth.j).max(0.0) - 1e-9));
            }
        }
        assert!(seen >= 8, "{seen}");
    }

    #[test]
    fn visible_stiction_makes_a_difference() {
        let sticky = of(LoopKind::Sticky, 200);
        let visible = sticky.iter().filter(|s| s.truth.visible).count();
        assert!((75..130).contains(&visible), "{visible} of 200");
        for (seed, Simulated { recording, truth }) in sticky.iter().enumerate() {
            assert!((LEAST_S..=MOST_S).contains(&truth.s) && truth.j <= truth.s);
            let twin = LoopKind::Normal.simulate(seed as u64).unwrap();
            if truth.visible && twin.truth.facts.redrawn == truth.facts.redrawn {
                assert_ne!(recording.op, twin.recording.op, "seed {seed}");
                assert_ne!(truth.vp, twin.truth.vp, "seed {seed}");
            }
        }
        let partly = sticky.iter().filter(|s| s.truth.facts.faulty_share < 1.0).count();
        assert!((8..50).contains(&partly), "{partly} of 200 come and go");
    }

    #[test]
    fn a_stuck_valve_does_not_move_while_the_op_does() {
        let stuck = of(LoopKind::Stuck, 60);
        for Simulated { recording, truth } in &stuck {
            let from = ((1.0 - truth.facts.faulty_share) * truth.vp.len() as f64).ceil() as usize;
            let last = truth.vp[truth.vp.len() - 1];
            // What its lag still brings.
            let settled =
                from + (20.0 * truth.facts.valve_lag_s / truth.facts.sample_time_s) as usize;
            let rest = truth.vp.get(settled + 2..).unwrap_or(&[]);
            assert!(rest.iter().all(|vp| (vp - last).abs() < 1e-4), "{}", recording.name);
            assert!(truth.facts.op_travel >= 2.0);
        }
        let visible = stuck.iter().filter(|s| s.truth.visible).count();
        assert!(visible >= 40, "{visible} of 60");
    }

    #[test]
    fn kinds_are_what_they_say() {
        for Simulated { recording, truth } in of(LoopKind::Saturation, 40) {
            assert!(truth.facts.at_limit >= 0.02, "{}", recording.name);
        }
        for Simulated { recording, truth } in of(LoopKind::QuantisedPv, 40) {
            let facts = &truth.facts;
            if facts.averaged || facts.pv_compression > 0.0 || facts.pv_quantum > 0.0 {
                continue;
            }
            let mut levels = recording.pv.unwrap().values;
            levels.sort_by(f64::total_cmp);
            levels.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * b.abs().max(1.0));
            assert!((2..60).contains(&levels.len()), "{}: {}", recording.name, levels.len());
        }
        for Simulated { truth, .. } in of(LoopKind::AggressiveTuning, 40) {
            assert!((0.85..1.25).contains(&truth.facts.gain_margin));
        }
        for Simulated { truth, .. } in of(LoopKind::DeadZoneElsewhere, 40) {
            assert!((truth.facts.sensor_play > 0.0) != (truth.facts.controller_gap > 0.0));
        }
        for Simulated { truth, .. } in of(LoopKind::SetPoint, 40) {
            assert_ne!(truth.facts.set_point, SetPointKind::Constant);
        }
    }

    #[test]
    fn what_enters_from_outside_makes_a_difference() {
        let causes = [
            LoopKind::Sine,
            LoopKind::Irregular,
            LoopKind::ExternalWave,
            LoopKind::ProcessNonlinearity,
            LoopKind::RampAndReset,
            LoopKind::SwitchedNeighbour,
            LoopKind::LongMemory,
            LoopKind::OneWay,
        ];
        for kind in causes {
            for (seed, Simulated { recording, truth }) in of(kind, 20).into_iter().enumerate() {
                let normal = LoopKind::Normal.simulate(seed as u64).unwrap();
                if normal.truth.facts.redrawn == truth.facts.redrawn {
                    assert_ne!(recording.pv, normal.recording.pv, "{}", recording.name);
                }
            }
        }
    }

    #[test]
    fn near_its_limit_a_band_excites_swings() {
        let sticky: Vec<_> = of(LoopKind::Sticky, 900)
            .into_iter()
            .filter(|each| each.truth.facts.situation == Situation::NearLimit)
            .collect();
        assert!((55..125).contains(&sticky.len()), "{} of 900", sticky.len());
        let swings = |each: &&Simulated| (3.0..30.0).contains(&each.truth.swing);
        let swinging = sticky.iter().filter(swings).count();
        assert!(swinging * 3 > sticky.len(), "{swinging} of {} swing", sticky.len());
        let visible = sticky.iter().filter(swings).filter(|each| each.truth.visible).count();
        assert!(visible * 5 > swinging * 2, "{visible} of {swinging} are visible");
        for Simulated { recording, truth } in &sticky {
            let facts = &truth.facts;
            let margin = facts.gain_margin;
            let held = facts.process == ProcessKind::Unstable && margin > 1.0;
            assert!(held || (1.02..=1.3).contains(&margin), "{}: {margin}", recording.name);
            assert!((truth.swing - facts.op_travel / truth.s).abs() < 1e-9);
        }
    }

    #[test]
    fn unstable_processes_are_held() {
        let mut seen = 0;
        for Simulated { recording, truth } in members(900) {
            if truth.facts.process != ProcessKind::Unstable {
                continue;
            }
            seen += 1;
            let facts = &truth.facts;
            assert!(facts.at_limit <= 0.9 && facts.gain_margin > 0.8, "{}", recording.name);
            assert!(recording.pv.unwrap().values.iter().all(|v| v.is_finite()));
        }
        assert!((20..70).contains(&seen), "{seen} of 900");
    }

    #[test]
    fn noisy_control_is_as_noisy_as_it_says() {
        let (mut seen, mut own, mut p_only, mut slow) = (0, 0, 0, 0);
        for Simulated { recording, truth } in of(LoopKind::Normal, 600) {
            let facts = &truth.facts;
            assert_eq!(facts.controller == ControllerKind::P, facts.ti_s == 0.0);
            if facts.situation != Situation::NoisyControl {
                continue;
            }
            seen += 1;
            own += usize::from(facts.own_noise > 0.0);
            p_only += usize::from(facts.controller == ControllerKind::P);
            let record = facts.sample_time_s * truth.vp.len() as f64;
            slow += usize::from(facts.ti_s > 0.3 * record);
            assert!((0.2 - 1e-9..4.0 + 1e-9).contains(&truth.op_noise), "{}", recording.name);
        }
        assert!((25..75).contains(&seen), "{seen} of 600");
        assert!(own * 7 > seen && own < seen && p_only * 2 > seen, "{own} {p_only} of {seen}");
        assert!(slow > 0 && slow * 4 < seen, "{slow} of {seen} wait as long as the record");
    }

    /// Healthy, sticking and stuck: the noise of the PV times the gain is nearly all that their OP does.
    #[test]
    fn noise_alone_moves_some_loops_of_every_kind() {
        for kind in [LoopKind::Normal, LoopKind::Sticky, LoopKind::Stuck] {
            let noisy: Vec<_> = of(kind, 600)
                .into_iter()
                .filter(|each| each.truth.facts.situation == Situation::NoisyControl)
                .collect();
            let alone = noisy.iter().filter(|each| {
                let (facts, op) = (&each.truth.facts, &each.recording.op.values);
                let sd = facts.noise_ratio * (facts.activity * facts.gain * facts.kc).abs();
                let whole =
                    facts.own_noise == 0.0 && !facts.averaged && facts.op_compression == 0.0;
                whole && (0.5..1.4).contains(&(std(op) / sd))
            });
            let alone = alone.count();
            assert!(alone * 10 > noisy.len(), "{alone} of {} {}", noisy.len(), kind.name());
        }
    }

    #[test]
    fn some_bands_are_beyond_what_the_op_does() {
        let sticky = of(LoopKind::Sticky, 800);
        let wide = sticky.iter().filter(|each| each.truth.s > 13.0).count();
        assert!((4..60).contains(&wide), "{wide} of 800");
        let still: Vec<_> = sticky.iter().filter(|each| !each.truth.moves).collect();
        assert!(still.len() > 16, "{} of 800 never move", still.len());
        // It shows as a stuck one does: by what a valve that moves would have made of the same OP.
        let shown = still.iter().filter(|each| each.truth.visible).count();
        assert!(shown > 0 && shown < still.len(), "{shown} of {} show", still.len());
        for Simulated { recording, truth } in still {
            assert!(truth.slips == 0 && truth.has_bands(), "{}", recording.name);
            assert!(truth.facts.op_travel > 0.0);
        }
    }

    #[test]
    fn what_moves_is_reported() {
        for Simulated { recording, truth } in of(LoopKind::Stuck, 80) {
            if truth.facts.faulty_share == 1.0 {
                assert!(!truth.moves, "{}", recording.name);
            }
        }
        for Simulated { recording, truth } in members(300) {
            assert!(truth.moves || (truth.sticks && truth.slips == 0), "{}", recording.name);
        }
    }

    #[test]
    fn switched_neighbours_jump() {
        let loops = of(LoopKind::SwitchedNeighbour, 60);
        assert!(loops.iter().all(|each| !each.truth.sticks && each.truth.moves));
        let draw = |kind: LoopKind, seed: u64| {
            let mut draw = Draw::of(&[seed, 0]);
            let _ = (draw.fork(), draw.fork());
            let design = Design::draw(kind, &mut draw);
            let tapes = Tapes::draw(kind, &design, &mut draw).unwrap();
            let plant = Plant::new(&design, &tapes, &mut draw).unwrap();
            let ideal = [fitted(0, Model::Ideal.build(Bands::NONE).unwrap())];
            plant.play(&ideal).unwrap().switches
        };
        let switches: Vec<_> = (0..60).map(|k| draw(LoopKind::SwitchedNeighbour, k)).collect();
        let many = switches.iter().filter(|n| **n >= 2).count();
        let often = switches.iter().filter(|n| **n > 30).count();
        assert!(many >= 50 && (10..55).contains(&often), "{many} {often} of 60");
        assert_eq!(draw(LoopKind::Normal, 1), 0);
    }

    #[test]
    fn some_outer_loops_are_near_their_limit() {
        let below = of(LoopKind::StickyBelow, 60);
        let near = below.iter().filter(|each| each.truth.facts.gain_margin <= 1.4).count();
        assert!((8..32).contains(&near), "{near} of 60");
    }

    #[test]
    fn what_a_door_kept_are_straight_lines() {
        let mut straight = 0;
        for Simulated { recording, truth } in of(LoopKind::SwingingDoor, 40) {
            let facts = &truth.facts;
            let doors = [facts.op_compression, facts.pv_compression];
            assert!(doors.iter().all(|d| *d == 0.0 || (0.1..=1.5).contains(d)), "{doors:?}");
            assert!(doors.iter().any(|d| *d > 0.0), "{}", recording.name);
            assert_eq!((facts.op_exception, facts.pv_exception), (0.0, 0.0));
            let pv = recording.pv.unwrap().values;
            if facts.pv_compression > 0.5 {
                let bends = pv
                    .windows(3)
                    .filter(|x| (x[0] - 2.0 * x[1] + x[2]).abs() > 1e-7 * (x[0].abs() + span(&pv)));
                straight += 1;
                assert!(bends.count() < pv.len() * 9 / 10, "{}", recording.name);
            }
        }
        assert!(straight > 2, "{straight}");
    }

    #[test]
    fn second_loops_are_where_kinds_need_them() {
        for Simulated { truth, .. } in of(LoopKind::StickingNeighbour, 30) {
            assert_eq!(truth.facts.situation, Situation::Coupled);
            assert!((0.15..0.9).contains(&truth.facts.coupling.abs()) && !truth.sticks);
        }
        let below = of(LoopKind::StickyBelow, 40);
        for Simulated { truth, .. } in &below {
            assert_eq!(truth.facts.situation, Situation::OuterLoop);
            assert!(truth.sticks && !truth.has_bands() && truth.gain == 0.0);
            assert!(!truth.visible || truth.slips >= 2);
        }
        let visible = below.iter().filter(|each| each.truth.visible).count();
        assert!((12..=38).contains(&visible), "{visible} of 40");
        for kind in [LoopKind::Sticky, LoopKind::Stuck] {
            let outer = |each: &Simulated| each.truth.facts.situation == Situation::OuterLoop;
            assert!(!of(kind, 30).iter().any(outer));
        }
    }

    #[test]
    fn one_way_is_one_way() {
        let loops = of(LoopKind::OneWay, 40);
        let far = loops.iter().filter(|each| {
            let op = &each.recording.op.values;
            let tenth = op.len() / 10;
            let apart = stiction_diagnose::series::mean(&op[op.len() - tenth..])
                - stiction_diagnose::series::mean(&op[..tenth]);
            apart.abs() > each.truth.facts.activity
        });
        let far = far.count();
        assert!(far >= 22, "{far} of 40");
    }

    #[test]
    fn every_family_is_there() {
        use crate::{DisturbanceKind, Family, HistorianKind, NoiseKind};
        let all: Vec<Family> = members(900).iter().flat_map(|m| m.truth.families()).collect();
        let there = |family: Family| {
            assert!(all.contains(&family), "{}: {}", family.axis(), family.name());
        };
        ProcessKind::ALL.iter().for_each(|kind| there(Family::Process(*kind)));
        ControllerKind::ALL.iter().for_each(|kind| there(Family::Controller(*kind)));
        NoiseKind::ALL.iter().for_each(|kind| there(Family::Noise(*kind)));
        SetPointKind::ALL.iter().for_each(|kind| there(Family::SetPoint(*kind)));
        DisturbanceKind::ALL.iter().for_each(|kind| there(Family::Disturbance(*kind)));
        HistorianKind::ALL.iter().for_each(|kind| there(Family::Historian(*kind)));
        Situation::ALL.iter().for_each(|situation| there(Family::Situation(*situation)));
        there(Family::Valve(Model::Chen));
    }

    /// With a little less gain than the ultimate one a loop settles, with a little more it does not.
    #[test]
    fn ultimate_gains_are_where_loops_begin_to_cycle() {
        let mut seen = 0;
        for seed in 0..500 {
            let mut design = Design::draw(LoopKind::AggressiveTuning, &mut Draw::of(&[seed]));
            let plain = matches!(design.situation, Situation::Ordinary | Situation::FewEvents)
                && design.controller == ControllerKind::Pi
                && matches!(design.process, ProcessKind::FirstOrder | ProcessKind::Integrating);
            if !plain {
                continue;
            }
            design.curve = super::super::design::Curve::Linear;
            design.pv_filter = 0.0;
            design.valve_lag = 0.0;
            let early_and_late = |margin: f64| {
                let mut design = design.clone();
                design.gain_margin = margin;
                design.tune();
                design.limits = (-1e6, 1e6);
                (design.samples, design.steps, design.warm_up) = (4000, 1, 0);
                design.sample_time = design.step();
                let n = design.all_steps();
                let mut load = vec![0.0; n];
                load[0] = 1e-3;
                let tapes = Tapes {
                    load,
                    output: vec![0.0; n],
                    noise: vec![0.0; n],
                    set_point: vec![design.pv_rest; n],
                    op: vec![],
                    selected: None,
                    spells: vec![],
                    switched: None,
                    kinds: vec![],
                };
                design.set_point = SetPointKind::Constant;
                let plant = Plant::new(&design, &tapes, &mut Draw::of(&[1])).unwrap();
                let run = plant.play(&[]).unwrap();
                (std(&run.op[..1000]), std(&run.op[2000..3000]), std(&run.op[3000..]))
            };
            // Slower ones need longer to show it.
            if design.steps != 1 || design.ti.max(design.tau) > 60.0 * design.sample_time {
                continue;
            }
            seen += 1;
            let (first, _, last) = early_and_late(1.1);
            assert!(last < first, "seed {seed}: from {first} to {last}");
            let (_, before, last) = early_and_late(0.9);
            // Or it has grown a thousandfold, to the ends of the transmitter.
            assert!(last > before || last > 1.0, "seed {seed}: from {before} to {last}");
        }
        assert!(seen > 20);
    }
}
