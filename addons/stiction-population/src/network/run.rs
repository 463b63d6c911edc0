//! Simulation of a network, step by step.

use super::{Cause, Course, LinkKind, Network, NetworkLoop, Outside, ProcessKind, STEP_S};
use crate::design::TRANSMITTER;
use crate::draw::Draw;
use crate::neighbour::pi;
use crate::stem::{Fitting, Stem};
use stiction_diagnose::recording::{Mode, Modes, Recording};
use stiction_model::bands::Bands;
use stiction_model::closed_loop::{
    DeadTime, DelayLine, Engaged, PidBank, Process, ProcessBank, SignalSource, quantised,
};
use stiction_model::error::Result;
use stiction_model::simd::Lane;
use stiction_model::valve::{AnyModel, Model};

/// Simulated time of a network before its record begins, s.
const WARM_UP_S: f64 = 14_400.0;
/// Time between changes of a valve with growing stiction, s.
const GROWS_EVERY_S: f64 = 21_600.0;
/// Largest external movement of a load, percent: flows are bounded.
const FARTHEST: f64 = 50.0;
const DAY_S: f64 = 86_400.0;

/// A simulated network. It continues from its state, so memory does not grow with the length of the record.
pub struct NetworkRun<'a> {
    network: &'a Network,
    nodes: Vec<Node>,
    links: Vec<Coupling>,
    outside: Vec<(SignalSource, bool)>,
    /// Steps since the run began, including those before the record.
    k: usize,
}

/// The record of a loop; OP in percent, PV and SP in its units.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    /// Time of the first, s from the first step of the record on.
    pub from_s: f64,
    /// Time between two, s.
    pub step_s: f64,
    /// Set point.
    pub sp: Vec<f64>,
    /// Process value.
    pub pv: Vec<f64>,
    /// Controller output.
    pub op: Vec<f64>,
    /// Whether the controller had the OP.
    pub auto: Vec<bool>,
    /// Position of the valve, percent. For a master loop, the PV of its slave loop.
    pub vp: Vec<f64>,
}

struct Node {
    controller: PidBank<1>,
    process: ProcessBank<1, 2>,
    line: DelayLine<1>,
    stem: Stem,
    load: SignalSource,
    noise: SignalSource,
    moves: Draw,
    sp: f64,
    op: f64,
    /// Deviations of its valve, and of its PV over the gain, from rest, percent.
    valve: f64,
    flow: f64,
    arriving: f64,
    every: usize,
    low: f64,
    span: f64,
}

struct Coupling {
    line: DelayLine<1>,
    keep: f64,
    gain: f64,
    state: f64,
}

impl Network {
    /// The simulated network, `without` one of its causes: the valve is then healthy, or the wave absent.
    ///
    /// # Errors
    /// If the settings of a part are invalid. No such case is known.
    pub fn run(&self, without: Option<Cause>) -> Result<NetworkRun<'_>> {
        let node =
            |(k, each): (usize, &NetworkLoop)| Node::new(each, without == Some(Cause::Valve(k)));
        let coupling = |link: &super::Link| Coupling {
            line: DelayLine::new([(link.dead_s / STEP_S).round() as usize]),
            keep: (-STEP_S / link.lag_s).exp(),
            gain: link.gain,
            state: 0.0,
        };
        let wave = |(k, each): (usize, &Outside)| {
            let there = without != Some(Cause::Outside(k));
            Ok((each.wave.source(STEP_S, usize::MAX)?, there))
        };
        let mut run = NetworkRun {
            network: self,
            nodes: self.loops.iter().enumerate().map(node).collect::<Result<_>>()?,
            links: self.links.iter().map(coupling).collect(),
            outside: self.outside.iter().enumerate().map(wave).collect::<Result<_>>()?,
            k: 0,
        };
        run.play((WARM_UP_S / STEP_S) as usize, |_| {})?;
        Ok(run)
    }
}

impl NetworkLoop {
    /// The valves, one per loop.
    fn fittings(&self, healed: bool) -> Result<Vec<Fitting>> {
        let from = |at_s: f64| ((WARM_UP_S + at_s) / STEP_S).round() as usize;
        let healthy = Model::Play.build(Bands::from_s_j(self.design.dead_band, 0.0)?)?;
        let sticking = |factor: f64| -> Result<AnyModel> {
            self.model.build(Bands::from_s_j(factor * self.s, factor * self.j)?)
        };
        let fitted = |from: usize, model: AnyModel| Fitting { from, model, position: None };
        Ok(match self.course {
            _ if healed => vec![fitted(0, healthy)],
            Course::Healthy => vec![fitted(0, healthy)],
            Course::Sticks => vec![fitted(0, sticking(1.0)?)],
            Course::Repaired { at_s } => {
                vec![fitted(0, sticking(1.0)?), fitted(from(at_s), healthy)]
            }
            Course::Begins { at_s } => {
                vec![fitted(0, healthy), fitted(from(at_s), sticking(1.0)?)]
            }
            Course::Grows { factor, within_s } => {
                let times = (within_s / GROWS_EVERY_S).ceil() as usize;
                let mut fittings = vec![fitted(0, sticking(1.0)?)];
                for k in 1..=times {
                    let grown = 1.0 + (factor - 1.0) * k as f64 / times as f64;
                    fittings.push(fitted(from(k as f64 * GROWS_EVERY_S), sticking(grown)?));
                }
                fittings
            }
        })
    }
}

impl Node {
    fn new(each: &NetworkLoop, healed: bool) -> Result<Self> {
        let d = &each.design;
        let process = match each.process {
            ProcessKind::Integrating => Process::integrator(d.gain / d.tau, d.dead_time)?,
            ProcessKind::SecondOrder => Process::second_order(d.gain, d.tau, d.tau2, d.dead_time)?,
            _ => Process::first_order(d.gain, d.tau, d.dead_time)?,
        };
        let process = process.sampled(STEP_S, DeadTime::Exact)?;
        let settings = pi(d.kc, d.ti)?;
        let engaged = Engaged::new(&settings, STEP_S, d.op_rest, d.pv_rest, d.pv_rest);
        Ok(Self {
            controller: PidBank::new(&[engaged]),
            line: DelayLine::new([process.delay()]),
            process: ProcessBank::new([&process]),
            stem: Stem::new(&each.fittings(healed)?, 0.0, f64::INFINITY, STEP_S, d.op_rest)?,
            load: d.load.source(STEP_S, usize::MAX)?,
            noise: d.noise.source(STEP_S, usize::MAX)?,
            moves: Draw::of(&[d.seed]),
            sp: d.pv_rest,
            op: d.op_rest,
            valve: 0.0,
            flow: 0.0,
            arriving: 0.0,
            every: (each.sample_time_s / STEP_S).round() as usize,
            low: d.pv_range.0,
            span: d.pv_range.1,
        })
    }
}

/// The signals of a loop in one step.
struct Shown {
    number: usize,
    sp: f64,
    pv: f64,
    auto: bool,
}

impl NetworkRun<'_> {
    /// The record of the next `duration_s`, of each loop.
    ///
    /// # Errors
    /// If the settings of a part are invalid. No such case is known.
    pub fn record(&mut self, duration_s: f64) -> Result<Vec<Samples>> {
        let steps = (duration_s / STEP_S).round() as usize;
        let first = self.k - (WARM_UP_S / STEP_S) as usize;
        let mut samples: Vec<Samples> = self
            .nodes
            .iter()
            .map(|node| {
                let room = || Vec::with_capacity(steps / node.every + 1);
                Samples {
                    from_s: first.next_multiple_of(node.every) as f64 * STEP_S,
                    step_s: node.every as f64 * STEP_S,
                    sp: room(),
                    pv: room(),
                    op: room(),
                    auto: Vec::with_capacity(steps / node.every + 1),
                    vp: room(),
                }
            })
            .collect();
        let mut k = first;
        let mut seen = 0;
        let n = self.nodes.len();
        self.play(steps, |(node, design, shown)| {
            if k.is_multiple_of(node.every) {
                let units = |percent: f64| {
                    node.low + node.span / 100.0 * quantised(percent, design.design.pv_quantum)
                };
                let own = &mut samples[shown.number];
                own.sp.push(units(shown.sp));
                own.pv.push(units(shown.pv));
                own.op.push(quantised(node.op, design.design.op_quantum));
                own.auto.push(shown.auto);
                own.vp.push(node.valve + design.design.op_rest);
            }
            seen += 1;
            if seen == n {
                (k, seen) = (k + 1, 0);
            }
        })?;
        Ok(samples)
    }

    /// Simulates this many steps. In each step, `see` is called for each loop.
    fn play(
        &mut self,
        steps: usize,
        mut see: impl FnMut((&Node, &NetworkLoop, Shown)),
    ) -> Result<()> {
        let loops = &self.network.loops;
        let warm_up = (WARM_UP_S / STEP_S) as usize;
        for _ in 0..steps {
            for (link, coupling) in self.network.links.iter().zip(&mut self.links) {
                let from = &self.nodes[link.from];
                let lets_out = loops[link.from].process == ProcessKind::Integrating;
                let acting = match link.kind {
                    LinkKind::Header => from.valve,
                    LinkKind::MassBalance | LinkKind::Recycle if lets_out => from.valve,
                    LinkKind::MassBalance | LinkKind::Recycle => from.flow,
                };
                let late = coupling.line.push::<true>(Lane([acting]))[0];
                coupling.state += (1.0 - coupling.keep) * (late - coupling.state);
                self.nodes[link.to].arriving += coupling.gain * coupling.state;
            }
            for (wave, (source, there)) in self.network.outside.iter().zip(&mut self.outside) {
                let value = source.draw();
                for (to, gain) in wave.into.iter().filter(|_| *there) {
                    self.nodes[*to].arriving += gain * value;
                }
            }
            let since_midnight = (self.k.saturating_sub(warm_up) as f64 * STEP_S).rem_euclid(DAY_S);
            for k in 0..self.nodes.len() {
                let each = &loops[k];
                let d = &each.design;
                let node = &mut self.nodes[k];
                let value = node.process.output(0) + d.pv_rest;
                let pv = (value + node.noise.draw()).clamp(TRANSMITTER.0, TRANSMITTER.1);
                if let Some((every, far)) = d.moves
                    && node.moves.chance(STEP_S / every)
                {
                    let by = far * node.moves.uniform(-1.0, 1.0);
                    node.sp = (node.sp + by).clamp(d.pv_rest - 2.0 * far, d.pv_rest + 2.0 * far);
                }
                let before = node.op;
                let auto = self.k < warm_up
                    || each.manual.is_none_or(|(from, to)| !(from..to).contains(&since_midnight));
                node.op = node.controller.step(0, node.sp, pv);
                if !auto {
                    node.controller.track(0, before);
                    node.op = before;
                }
                let load = node.load.draw() + node.arriving.clamp(-FARTHEST, FARTHEST);
                node.arriving = 0.0;
                let (own_sp, op) = (node.sp, node.op);
                let vp = match each.below {
                    // The loop below comes later in this step, and responds in the next.
                    Some(below) => {
                        self.nodes[below].sp = op;
                        self.nodes[below].process.output(0) + d.op_rest
                    }
                    None => node.stem.step(self.k, before, op)?.1,
                };
                let node = &mut self.nodes[k];
                node.valve = vp - d.op_rest;
                node.flow = (value - d.pv_rest) / d.gain;
                let input = node.line.push::<true>(Lane([d.curve.at(node.valve + load)]));
                node.process.advance(input);
                see((node, each, Shown { number: k, sp: own_sp, pv, auto }));
            }
            self.k += 1;
        }
        Ok(())
    }
}

impl Samples {
    /// The recording of a loop: times in s from the first step of the record on.
    ///
    /// # Errors
    /// If there is no sample.
    pub fn recording(&self, name: &str, each: &NetworkLoop) -> Result<Recording> {
        let mut recording =
            Recording::regular(name, self.step_s, &self.op, Some(&self.pv), Some(&self.sp))?;
        recording.loop_type = each.loop_type;
        if each.manual.is_some() {
            let mode = |auto: bool| if auto { Mode::Automatic } else { Mode::Manual };
            recording.mode = Some(Modes {
                time: (0..self.auto.len()).map(|k| k as f64 * self.step_s).collect(),
                modes: self.auto.iter().map(|auto| mode(*auto)).collect(),
            });
        }
        Ok(recording)
    }
}
