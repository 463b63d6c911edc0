//! The loop itself, step by step.

use super::design::Design;
use super::disturbance::{Spell, Tapes};
use super::draw::Draw;
use super::families::{ControllerKind, ProcessKind, SetPointKind};
use super::neighbour::{InnerRun, NeighbourRun};
use super::stem::{Fitting, Stem};
use super::switched::SwitchedRun;
use std::iter::Peekable;
use std::slice::Iter;
use stiction_model::closed_loop::{
    AntiWindup, Controller, DeadTime, DelayLine, Engaged, Form, Handover, PidBank, Process,
    ProcessBank, SampledProcess, Signal, quantised,
};
use stiction_model::error::Result;
use stiction_model::simd::Lane;
use stiction_model::valve::{Play, Start, Valve};

/// A loop with all its external signals, but without its valve.
pub(super) struct Plant<'a> {
    design: &'a Design,
    tapes: &'a Tapes,
    controller: Controller,
    process: SampledProcess,
    master: Option<Master>,
    /// Width of the play in the transmitter, percent of span.
    pub sensor_play: f64,
    /// Half the width of the gap in which the controller treats the error as zero, percent of span.
    pub gap: f64,
    /// Resolution of the transmitter, percent of span. The controller receives the rounded PV.
    pub quantum: f64,
}

/// A controller above, which writes the set point.
struct Master {
    /// Process between the PV and the controlled variable of the master.
    keep: f64,
    kc: f64,
    /// Integral gain a step of the master.
    ki: f64,
    /// Largest movement of the set point, percent of span.
    reach: f64,
    /// Target of its controlled variable, less its disturbance.
    wanted: Vec<f64>,
}

/// The result of a simulated loop, step by step.
#[derive(Default)]
pub(super) struct Played {
    pub sp: Vec<f64>,
    pub pv: Vec<f64>,
    pub op: Vec<f64>,
    /// Stem position of the valve model, before its lag.
    pub stem: Vec<f64>,
    pub vp: Vec<f64>,
    /// Number of slips of a neighbour's stem, including the steps before the record.
    pub neighbour_slips: usize,
    /// Number of level changes of a switched neighbour during the record.
    pub switches: usize,
}

/// A manual source of the OP.
pub(super) trait Hand {
    /// The OP at step `k`, percent, after `op`, if it is set manually; PV and SP in percent of span.
    fn op(&mut self, k: usize, pv: f64, sp: f64, op: f64) -> Option<f64>;
}

/// None.
pub(super) struct Nobody;

impl Hand for Nobody {
    fn op(&mut self, _: usize, _: f64, _: f64, _: f64) -> Option<f64> {
        None
    }
}

/// The drive of the process: a valve, or a loop below.
#[expect(clippy::large_enum_variant, reason = "one actuator per loop, never moved")]
enum Actuator<'a> {
    Valve(Stem),
    Loop(InnerRun<'a>),
}

impl Played {
    /// Without the steps before the record.
    fn since(mut self, warm_up: usize) -> Self {
        for signal in [&mut self.sp, &mut self.pv, &mut self.op, &mut self.stem, &mut self.vp] {
            signal.drain(..warm_up);
        }
        self
    }
}

impl<'a> Plant<'a> {
    /// The drawn loop.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn new(design: &'a Design, tapes: &'a Tapes, draw: &mut Draw) -> Result<Self> {
        let Design { gain, tau, tau2, dead_time, .. } = *design;
        let process = match design.process {
            ProcessKind::FirstOrder => Process::first_order(gain, tau, dead_time)?,
            ProcessKind::SecondOrder => Process::second_order(gain, tau, tau2, dead_time)?,
            ProcessKind::Integrating => Process::integrator(gain / tau, dead_time)?,
            ProcessKind::Unstable => Process::transfer_function(&[gain], &[tau, -1.0], dead_time)?,
        };
        let (low, high) = design.limits;
        let form = if design.velocity_form { Form::Velocity } else { Form::Positional };
        let controller = match design.controller {
            ControllerKind::P => Controller::p(design.kc)?,
            _ => Controller::pid(design.kc, design.ti, design.td)?,
        };
        let controller = controller
            .with_limits(low, high, AntiWindup::Clamping)?
            .with_form(form)
            .with_handover(Handover::Bumpless);
        let master = match design.set_point {
            SetPointKind::Cascade => Some(Master::draw(design, draw)?),
            _ => None,
        };
        let process = process.sampled(design.step(), DeadTime::Exact)?;
        let (sensor_play, gap, quantum) = (0.0, 0.0, 0.0);
        Ok(Self { design, tapes, controller, process, master, sensor_play, gap, quantum })
    }

    /// Simulates the loop with this valve, from the beginning of the record on.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn play(&self, valve: &[Fitting]) -> Result<Played> {
        Ok(self.steps(valve, None, &mut Nobody)?.since(self.design.warm_up))
    }

    /// Simulates the loop with this valve and a manual source of the OP, from the beginning of the record on.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn play_with(&self, valve: &[Fitting], hand: &mut dyn Hand) -> Result<Played> {
        Ok(self.steps(valve, None, hand)?.since(self.design.warm_up))
    }

    /// Simulates the loop with `valve`, and the PV if `other` followed the same OP; from the beginning of the
    /// record on.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn play_both(&self, valve: &[Fitting], other: &[Fitting]) -> Result<(Played, Vec<f64>)> {
        let played = self.steps(valve, None, &mut Nobody)?;
        let beside = self.steps(other, Some(&played.op), &mut Nobody)?;
        let warm_up = self.design.warm_up;
        Ok((played.since(warm_up), beside.since(warm_up).pv))
    }

    /// All steps, with the controller in the loop or with a given OP.
    fn steps(
        &self,
        fittings: &[Fitting],
        given: Option<&[f64]>,
        hand: &mut dyn Hand,
    ) -> Result<Played> {
        let (design, tapes) = (self.design, self.tapes);
        let (lowest, highest) = design.transmitter;
        let (step, n) = (design.step(), design.all_steps());
        let first_sp = tapes.set_point[0];
        let (op_rest, pv_rest) = (design.op_rest, design.pv_rest);
        let engaged = Engaged::new(&self.controller, step, op_rest, first_sp, pv_rest);
        let mut controller = PidBank::new(&[engaged]);
        let mut process = ProcessBank::<1, 2>::new([&self.process]);
        let mut line = DelayLine::<1>::new([self.process.delay()]);
        let mut actuator = match &design.inner {
            Some(inner) => {
                let duration = design.drawn_steps as f64 * step;
                Actuator::Loop(InnerRun::new(inner, fittings, op_rest, step, n, duration)?)
            }
            None => {
                let (lag, stroke) = (design.valve_lag, design.stroke);
                Actuator::Valve(Stem::new(fittings, lag, stroke, step, op_rest)?)
            }
        };
        let beside = design.neighbour.as_ref().map(|one| one.fitting()).transpose()?;
        let mut neighbour = match (&design.neighbour, &beside) {
            (Some(one), Some(fitting)) => {
                Some(NeighbourRun::new(one, fitting, step, n, design.drawn())?)
            }
            _ => None,
        };
        let mut switched = tapes.switched.as_ref().map(SwitchedRun::new);
        let mut pushed = [0.0; 2];
        let mut spells = tapes.spells.iter().peekable();
        let mut play = Play::new(self.sensor_play)?;
        play.restart(Start::at_rest(pv_rest));
        let keep = if design.pv_filter > 0.0 { (-step / design.pv_filter).exp() } else { 0.0 };
        let mut filtered = pv_rest;
        let mut master = self.master.as_ref().map(MasterRun::new);
        let (mut last_pv, mut last_op, mut arriving) = (pv_rest, op_rest, 0.0);

        let room = || Vec::with_capacity(n);
        let mut played = Played {
            sp: room(),
            pv: room(),
            op: room(),
            stem: room(),
            vp: room(),
            neighbour_slips: 0,
            switches: 0,
        };
        for k in 0..n {
            let value = process.output(0) + pv_rest + tapes.output[k] + pushed[1];
            let sensed = if self.sensor_play > 0.0 { play.step(value) } else { value };
            let sensed = (sensed + tapes.noise[k]).clamp(lowest, highest);
            filtered = keep * filtered + (1.0 - keep) * sensed;
            let pv = match k % design.analyser {
                0 => quantised(filtered, self.quantum),
                _ => last_pv,
            };
            last_pv = pv;

            let asks = k % design.steps == 0;
            let asked = master.as_mut().map_or(0.0, |one| one.step(k, value - pv_rest, asks));
            let sp = (tapes.set_point[k] + asked).clamp(3.0, 97.0);
            let op = match given {
                Some(given) => given[k],
                None => self.answer(&mut controller, &mut spells, hand, k, (sp, pv), last_op),
            };
            let load = tapes.load[k] + arriving + pushed[0];
            let (stem, vp, acting) = match &mut actuator {
                Actuator::Valve(valve) => {
                    let (stem, vp) = valve.step(k, last_op, op)?;
                    (stem, vp, vp)
                }
                Actuator::Loop(below) => below.step(k, op, load)?,
            };
            last_op = op;
            let away = (value - pv_rest) / design.gain;
            if let Some(neighbour) = &mut neighbour {
                arriving = neighbour.step(k, acting - op_rest, away)?;
            }
            if let Some(switched) = &mut switched {
                pushed = switched.step(k, acting - op_rest, away);
            }
            let v = design.curve.at((acting - op_rest) + load);
            process.advance(line.push::<true>(Lane([v])));

            played.sp.push(sp);
            played.pv.push(pv);
            played.op.push(op);
            played.stem.push(stem);
            played.vp.push(vp);
        }
        played.switches = switched.map_or(0, |one| one.switches);
        played.neighbour_slips = neighbour.map_or(0, |one| one.slips);
        Ok(played)
    }
}

impl Plant<'_> {
    /// The OP at step `k`, after `last_op`. It is the controller's output, unless an operator or another controller
    /// takes over.
    fn answer(
        &self,
        controller: &mut PidBank<1>,
        spells: &mut Peekable<Iter<'_, Spell>>,
        hand: &mut dyn Hand,
        k: usize,
        (sp, pv): (f64, f64),
        last_op: f64,
    ) -> f64 {
        let (design, tapes) = (self.design, self.tapes);
        let error = sp - pv;
        let mut beyond = error - error.clamp(-self.gap, self.gap);
        if let Some((least, whole)) = design.squared {
            beyond *= least + (1.0 - least) * (beyond.abs() / whole).min(1.0);
        }
        let shaped = self.gap > 0.0 || design.squared.is_some();
        let own = controller.step(0, sp, if shaped { sp - beyond } else { pv });
        let op = own + tapes.op.get(k).copied().unwrap_or(0.0);
        while spells.next_if(|spell| spell.until <= k).is_some() {}
        let taken = match (hand.op(k, pv, sp, last_op), spells.peek(), &tapes.selected) {
            (Some(held), ..) => held,
            (_, Some(spell), _) if spell.from <= k => spell.op(k, last_op),
            (_, _, Some(selected)) => selected.of(k, op),
            _ => op,
        };
        if taken != op {
            controller.track(0, taken);
        }
        let (low, high) = design.limits;
        taken.clamp(low, high)
    }
}

/// A simulated master.
struct MasterRun<'a> {
    design: &'a Master,
    /// Controlled variable.
    above: f64,
    integral: f64,
    asked: f64,
}

impl<'a> MasterRun<'a> {
    fn new(design: &'a Master) -> Self {
        Self { design, above: 0.0, integral: 0.0, asked: 0.0 }
    }

    /// Movement of the set point at step `k`, with this deviation of the PV from rest; it `asks` again or holds.
    fn step(&mut self, k: usize, away: f64, asks: bool) -> f64 {
        let Master { keep, kc, ki, reach, ref wanted } = *self.design;
        self.above = keep * self.above + (1.0 - keep) * away;
        if asks {
            let error = wanted[k] - self.above;
            self.integral += ki * error;
            self.integral = self.integral.clamp(-reach, reach);
            self.asked = (kc * error + self.integral).clamp(-reach, reach);
        }
        self.asked
    }
}

impl Master {
    /// A master that waits for its slave, under a wandering disturbance.
    fn draw(design: &Design, draw: &mut Draw) -> Result<Self> {
        let step = design.step();
        let tau = design.response_time() * draw.log(3.0, 20.0);
        // A third of them hardly damp their controlled variable.
        let hasty = if draw.chance(0.35) { draw.log(2.0, 8.0) } else { 1.0 };
        let kc = draw.log(0.3, 1.5) * hasty;
        let ti = tau * draw.uniform(0.5, 1.5);
        let size = (design.gain * design.activity * design.happens).abs();
        let sd = size * draw.log(0.2, 1.5) / hasty;
        let wanders = Signal::Noise { sd, tau_s: tau * draw.log(0.5, 5.0), seed: draw.seed() };
        Ok(Self {
            keep: (-step / tau).exp(),
            kc,
            ki: kc * design.sample_time / ti,
            reach: 3.0 * size,
            wanted: wanders.sample(step, design.all_steps())?,
        })
    }
}
