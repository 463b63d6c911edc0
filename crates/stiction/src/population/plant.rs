//! The loop itself, step by step.

use super::design::{Design, ProcessKind, SetPointKind};
use super::disturbance::Tapes;
use super::draw::Draw;
use crate::closed_loop::{
    AntiWindup, Controller, DeadTime, DelayLine, Engaged, Form, Handover, PidBank, Process,
    ProcessBank, SampledProcess, Signal, quantised,
};
use crate::error::Result;
use crate::simd::Lane;
use crate::valve::{AnyModel, Assembly, Play, Start, StemLag, Valve};

/// What a transmitter can say, percent of span (NAMUR NE 43: 3.8 to 20.5 mA).
pub(super) const TRANSMITTER: (f64, f64) = (-1.25, 103.125);

/// A loop with all that happens to it, but for its valve.
pub(super) struct Plant<'a> {
    design: &'a Design,
    tapes: &'a Tapes,
    controller: Controller,
    process: SampledProcess,
    master: Option<Master>,
    /// Width of the play in the transmitter, percent of span.
    pub sensor_play: f64,
    /// Half the width of the gap in which the controller takes the error for zero, percent of span.
    pub gap: f64,
    /// Resolution of the transmitter, percent of span; the controller sees it.
    pub quantum: f64,
}

/// A controller above, which writes the set point.
struct Master {
    /// Of the process between the PV and what the master controls.
    keep: f64,
    kc: f64,
    /// Integral gain a step of the master.
    ki: f64,
    /// The farthest it moves the set point, percent of span.
    reach: f64,
    /// What its controlled variable should be, less what disturbs it.
    wanted: Vec<f64>,
}

/// A valve model, and the step from which it is in the loop.
pub(super) struct Fitting {
    pub from: usize,
    pub model: AnyModel,
    /// Where it is put; where the stem is, if not given.
    pub position: Option<f64>,
}

/// What a loop did, step by step.
#[derive(Default)]
pub(super) struct Played {
    pub sp: Vec<f64>,
    pub pv: Vec<f64>,
    pub op: Vec<f64>,
    /// Where the valve model has the stem, before its lag.
    pub stem: Vec<f64>,
    pub vp: Vec<f64>,
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
    /// The loop as it is drawn.
    ///
    /// # Errors
    /// If a part refuses its settings.
    pub fn new(design: &'a Design, tapes: &'a Tapes, draw: &mut Draw) -> Result<Self> {
        let Design { gain, tau, tau2, dead_time, .. } = *design;
        let process = match design.process {
            ProcessKind::FirstOrder => Process::first_order(gain, tau, dead_time)?,
            ProcessKind::SecondOrder => Process::second_order(gain, tau, tau2, dead_time)?,
            ProcessKind::Integrating => Process::integrator(gain / tau, dead_time)?,
        };
        let (low, high) = design.limits;
        let form = if design.velocity_form { Form::Velocity } else { Form::Positional };
        let controller = Controller::pid(design.kc, design.ti, design.td)?
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

    /// What the loop does with this valve, from the beginning of the record on.
    ///
    /// # Errors
    /// If a part refuses its settings.
    pub fn play(&self, valve: &[Fitting]) -> Result<Played> {
        Ok(self.steps(valve, None)?.since(self.design.warm_up))
    }

    /// What the loop does with `valve`, and what the PV would do if `other` followed the same OP; from
    /// the beginning of the record on.
    ///
    /// # Errors
    /// If a part refuses its settings.
    pub fn play_beside(&self, valve: &[Fitting], other: &[Fitting]) -> Result<(Played, Vec<f64>)> {
        let played = self.steps(valve, None)?;
        let beside = self.steps(other, Some(&played.op))?;
        let warm_up = self.design.warm_up;
        Ok((played.since(warm_up), beside.since(warm_up).pv))
    }

    /// All steps, with the controller in the loop or with an OP that is given.
    fn steps(&self, fittings: &[Fitting], given: Option<&[f64]>) -> Result<Played> {
        let (design, tapes) = (self.design, self.tapes);
        let (step, n) = (design.step(), design.all_steps());
        let first_sp = tapes.set_point[0];
        let (op_rest, pv_rest) = (design.op_rest, design.pv_rest);
        let engaged = Engaged::new(&self.controller, step, op_rest, first_sp, pv_rest);
        let mut controller = PidBank::new(&[engaged]);
        let mut process = ProcessBank::<1, 2>::new([&self.process]);
        let mut line = DelayLine::<1>::new([self.process.delay()]);
        let mut lag = StemLag::new(design.valve_lag, step)?;
        lag.restart(op_rest);
        let mut play = Play::new(self.sensor_play)?;
        play.restart(Start::at_rest(pv_rest));
        let mut valve = Assembly::new(crate::valve::Model::Ideal.build(crate::Bands::NONE)?);
        valve.restart(Start::at_rest(op_rest));
        let mut fittings = fittings.iter().peekable();
        let keep = if design.pv_filter > 0.0 { (-step / design.pv_filter).exp() } else { 0.0 };
        let mut filtered = pv_rest;
        let (mut above, mut above_integral, mut asked) = (0.0, 0.0, 0.0);
        let mut stem = op_rest;

        let room = || Vec::with_capacity(n);
        let mut played = Played { sp: room(), pv: room(), op: room(), stem: room(), vp: room() };
        for k in 0..n {
            let value = process.output(0) + pv_rest + tapes.output[k];
            let sensed = if self.sensor_play > 0.0 { play.step(value) } else { value };
            let sensed = (sensed + tapes.noise[k]).clamp(TRANSMITTER.0, TRANSMITTER.1);
            filtered = keep * filtered + (1.0 - keep) * sensed;
            let pv = quantised(filtered, self.quantum);

            if let Some(master) = &self.master {
                above = master.keep * above + (1.0 - master.keep) * (value - pv_rest);
                if k % design.steps == 0 {
                    let error = master.wanted[k] - above;
                    above_integral += master.ki * error;
                    above_integral = above_integral.clamp(-master.reach, master.reach);
                    asked = (master.kc * error + above_integral).clamp(-master.reach, master.reach);
                }
            }
            let sp = (tapes.set_point[k] + asked).clamp(3.0, 97.0);
            let op = match given {
                Some(given) => given[k],
                None => {
                    let error = sp - pv;
                    let beyond = error - error.clamp(-self.gap, self.gap);
                    controller.step(0, sp, if self.gap > 0.0 { sp - beyond } else { pv })
                }
            };
            while let Some(next) = fittings.next_if(|next| next.from <= k) {
                let before = played.op.last().copied().unwrap_or(op_rest);
                let start = Start { op: before, ..Start::at_rest(next.position.unwrap_or(stem)) };
                valve = Assembly::new(next.model.clone()).with_limits(0.0, 100.0)?;
                valve.restart(start);
            }
            stem = valve.step(op);
            let vp = lag.step(stem);
            let v = design.curve.at((vp - op_rest) + tapes.load[k]);
            process.advance(line.push::<true>(Lane([v])));

            played.sp.push(sp);
            played.pv.push(pv);
            played.op.push(op);
            played.stem.push(stem);
            played.vp.push(vp);
        }
        Ok(played)
    }
}

impl Master {
    /// A master that waits for its slave, under a disturbance that wanders.
    fn draw(design: &Design, draw: &mut Draw) -> Result<Self> {
        let step = design.step();
        let tau = design.response_time() * draw.log(3.0, 20.0);
        let kc = draw.log(0.3, 1.5);
        let ti = tau * draw.uniform(0.5, 1.5);
        let size = (design.gain * design.activity).abs();
        let sd = size * draw.log(0.2, 1.5);
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
