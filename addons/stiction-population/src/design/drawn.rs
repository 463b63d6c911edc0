//! Random draw of a loop. The stream defines the order of draws, which is part of the population's version.

use super::{Curve, Design, TRANSMITTER};
use crate::LoopKind;
use crate::draw::Draw;
use crate::families::{ControllerKind, NoiseKind, ProcessKind, SetPointKind, Situation};
use crate::historian::Historian;
use crate::neighbour::{Inner, Neighbour};
use stiction_diagnose::recording::LoopType;

impl Design {
    /// A loop of this kind.
    pub fn draw(kind: LoopKind, draw: &mut Draw) -> Self {
        let mut cause = draw.fork();
        let record = Record::draw(draw);
        let Record { samples, sample_time, pace, steps } = record;
        let situation = Self::situation(kind, draw);
        let near_limit = situation == Situation::NearLimit;
        let mut special = draw.fork();
        let mut lags = Lags::draw(&record, situation, &mut special, draw);
        let tuning = Tuning::draw(&record, situation, &mut lags, draw);
        let Lags { process, tau, tau2, dead_time, valve_lag, pv_filter, fast } = lags;
        let Tuning { controller, ti, td, gain_margin } = tuning;
        let integrating = process == ProcessKind::Integrating;

        let s = draw.log(0.5, 13.0);
        // In a calm loop hardly anything happens except for its valve.
        let calm = draw.chance(if near_limit { 0.75 } else { 0.2 });
        let calm = draw.log(0.04, 0.5).powf(f64::from(u8::from(calm)));
        let activity = s * calm * draw.log(0.25, 1.6);
        let curve = Curve::draw(draw);
        let noise = draw.weighted([
            (NoiseKind::White, 0.42),
            (NoiseKind::Correlated, 0.25),
            (NoiseKind::HeavyTailed, 0.13),
            (NoiseKind::Bursts, 0.09),
            (NoiseKind::Spikes, 0.11),
        ]);
        let set_point = draw.weighted([
            (SetPointKind::Steps, 0.45),
            (SetPointKind::Ramps, 0.15),
            (SetPointKind::Wandering, 0.2),
            (SetPointKind::Cascade, 0.2),
        ]);
        let moves = draw.chance(0.27);
        let span = 10f64.powf(draw.uniform(-1.0, 3.5));
        let low = if draw.chance(0.6) { 0.0 } else { span * draw.uniform(-0.5, 3.0) };
        let typed = draw.chance(0.5);
        let loop_type = match () {
            () if integrating => {
                draw.one_of([LoopType::Level, LoopType::Level, LoopType::OtherIntegrating])
            }
            () if fast => draw.one_of([LoopType::Flow, LoopType::Flow, LoopType::Pressure]),
            () => draw.one_of([
                LoopType::Temperature,
                LoopType::Analysis,
                LoopType::Pressure,
                LoopType::OtherSelfRegulating,
            ]),
        };
        let mut design = Self {
            samples,
            sample_time,
            pace,
            steps,
            warm_up: 0,
            drawn_steps: 0,
            situation,
            process,
            gain: draw.log(0.4, 2.5) * draw.sign(),
            tau,
            tau2,
            dead_time,
            valve_lag,
            curve,
            pv_filter,
            controller,
            kc: 0.0,
            ti,
            td,
            gain_margin,
            velocity_form: draw.chance(0.2) && controller != ControllerKind::P,
            squared: None,
            own_noise: 0.0,
            analyser: 1,
            stroke: f64::INFINITY,
            transmitter: TRANSMITTER,
            inner: None,
            neighbour: None,
            limits: if draw.chance(0.08) {
                draw.one_of([(5.0, 95.0), (10.0, 90.0), (0.0, 80.0)])
            } else {
                (0.0, 100.0)
            },
            op_rest: draw.uniform(20.0, 75.0),
            pv_rest: draw.uniform(25.0, 75.0),
            activity,
            s,
            noise,
            noise_ratio: draw.log(0.003, 0.5).powf(if near_limit { 1.5 } else { 1.0 }),
            happens: 1.0,
            non_stationary: draw.chance(0.2),
            set_point: if moves { set_point } else { SetPointKind::Constant },
            historian: Historian::draw(near_limit, draw),
            sp_recorded: draw.chance(0.6),
            pv_range: (low, span),
            loop_type: if typed { loop_type } else { LoopType::Unknown },
        };
        design.specialise(&mut special);
        match kind {
            LoopKind::AggressiveTuning => design.gain_margin = cause.log(0.85, 1.25),
            LoopKind::SetPoint => design.set_point = set_point,
            LoopKind::ProcessNonlinearity => {
                let rate = cause.uniform(0.5, 1.5) / design.activity.max(5.0);
                design.curve = Curve::Exponential { rate: rate * cause.sign() };
            }
            LoopKind::SwingingDoor => design.historian.compress(&mut cause),
            LoopKind::StickingNeighbour => {
                let activity = design.activity;
                if let Some(neighbour) = &mut design.neighbour {
                    neighbour.sticks(activity, &mut cause);
                }
            }
            _ => {}
        }
        design.tune();
        if situation == Situation::NoisyControl {
            design.make_noisy(&mut special);
        }
        // Long enough to settle into a cycle, but at most half the record.
        let waits = if design.ti.is_finite() { design.ti } else { design.response_time() };
        let settled = (30.0 * waits / design.step()).min((samples * steps / 2) as f64);
        design.warm_up = settled as usize + 40;
        design.drawn_steps = design.all_steps();
        design
    }

    /// The situation of a loop of this kind.
    fn situation(kind: LoopKind, draw: &mut Draw) -> Situation {
        let drawn = draw.weighted([
            (Situation::Ordinary, 0.40),
            (Situation::FewEvents, 0.20),
            (Situation::NearLimit, 0.10),
            (Situation::NoisyControl, 0.08),
            (Situation::OuterLoop, 0.05),
            (Situation::Coupled, 0.05),
            (Situation::Feedforward, 0.02),
            (Situation::Override, 0.02),
            (Situation::ManualSpells, 0.02),
            (Situation::SlowActuator, 0.02),
            (Situation::Analyser, 0.02),
            (Situation::NarrowTransmitter, 0.01),
            (Situation::SplitRange, 0.01),
        ]);
        match (kind, drawn) {
            (LoopKind::StickyBelow, _) => Situation::OuterLoop,
            (LoopKind::StickingNeighbour, _) => Situation::Coupled,
            // For the loop above, these are loops of the kind `StickyBelow`.
            (LoopKind::Sticky | LoopKind::Stuck, Situation::OuterLoop) => Situation::Ordinary,
            _ => drawn,
        }
    }

    /// Draws the parts of the situation, except for its events.
    fn specialise(&mut self, draw: &mut Draw) {
        let scale = (self.gain * self.activity).abs();
        if self.controller == ControllerKind::ErrorSquared {
            self.squared = Some((draw.uniform(0.1, 0.6), scale * draw.log(0.3, 3.0)));
        }
        match self.situation {
            Situation::OuterLoop => {
                let slower = match self.process {
                    ProcessKind::Integrating => self.dead_time + self.step(),
                    _ => self.tau.min(self.ti) + self.dead_time,
                };
                let inner = Inner::draw(self.step(), slower, self.activity, draw);
                self.valve_lag = inner.lambda;
                self.inner = Some(inner);
                if draw.chance(0.3) {
                    self.gain_margin = draw.log(1.02, 1.4);
                }
            }
            Situation::Coupled => {
                let step = self.step();
                let lags = self.tau.min(0.05 * self.drawn()) + self.dead_time;
                let lags = lags.max(3.0 * step);
                self.neighbour = Some(Neighbour::draw(step, lags, self.activity, draw));
            }
            Situation::SlowActuator => {
                let most = self.response_time_untuned() * draw.log(0.1, 1.5);
                self.stroke = self.activity / most;
            }
            Situation::Analyser => {
                let every = (self.tau + self.dead_time).max(2.0 * self.pace) * draw.log(0.1, 1.0);
                self.analyser = ((every / self.step()) as usize).clamp(2, 200 * self.steps);
            }
            Situation::NarrowTransmitter => {
                let room = scale * draw.uniform(0.7, 3.0);
                match draw.chance(0.5) {
                    true => self.transmitter.1 = self.transmitter.1.min(self.pv_rest + room),
                    false => self.transmitter.0 = self.transmitter.0.max(self.pv_rest - room),
                }
            }
            Situation::SplitRange => {
                self.curve = Curve::Split {
                    at: self.activity * draw.uniform(-1.0, 1.0),
                    gap: draw.uniform(-2.0, 3.0),
                    ratio: draw.log(0.5, 2.0),
                };
            }
            _ => {}
        }
        if self.process == ProcessKind::Unstable {
            self.curve = Curve::Linear;
        }
    }

    /// Sets the noise of the OP: up to four times the band, from the PV or the controller. In two of five cases only
    /// the noise of the PV moves the OP. Hardly anything else happens, and integral action is slow compared with the
    /// record.
    fn make_noisy(&mut self, draw: &mut Draw) {
        let sd = self.s * draw.log(0.2, 4.0);
        let by_pv = if draw.chance(0.5) { draw.unit() } else { 1.0 };
        let (alone, little) = (draw.chance(0.4), draw.log(0.02, 0.3));
        let long = self.drawn() * draw.log(0.3, 3.0);
        let by_pv = if alone { 1.0 } else { by_pv };
        if alone {
            self.happens = (little * sd / self.activity).min(1.0);
            self.ti = self.ti.max(long);
        }
        self.own_noise = sd * (1.0 - by_pv * by_pv).sqrt();
        self.noise_ratio = by_pv * sd / (self.kc * self.gain * self.activity).abs();
    }
}

/// The recorded signals.
struct Record {
    samples: usize,
    sample_time: f64,
    pace: f64,
    steps: usize,
}

impl Record {
    fn draw(draw: &mut Draw) -> Self {
        // An eager historian records the same loops with more samples.
        let eager = if draw.chance(0.15) { draw.log(2.0, 10.0) } else { 1.0 };
        let samples = (draw.log(300.0, 2000.5) * eager) as usize;
        let sample_time = draw.one_of([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 60.0]);
        let pace = sample_time * eager;
        let slow_historian = if draw.chance(0.12) { 20 } else { draw.one_of([1, 1, 2, 5, 10]) };
        let steps = if eager > 1.0 { 1 } else { slow_historian };
        Self { samples, sample_time, pace, steps }
    }

    fn step(&self) -> f64 {
        self.sample_time / self.steps as f64
    }

    fn duration(&self) -> f64 {
        self.samples as f64 * self.sample_time
    }
}

/// The process with all its delays.
struct Lags {
    process: ProcessKind,
    tau: f64,
    tau2: f64,
    dead_time: f64,
    valve_lag: f64,
    pv_filter: f64,
    fast: bool,
}

impl Lags {
    fn draw(record: &Record, situation: Situation, special: &mut Draw, draw: &mut Draw) -> Self {
        let near_limit = situation == Situation::NearLimit;
        let integrating = draw.chance(0.3);
        // A loop that rings within a few samples would look like noise.
        let fast = draw.chance(if near_limit { 0.15 } else { 0.6 }) && !integrating;
        let unstable = special.chance(if near_limit { 0.2 } else { 0.03 })
            && !matches!(situation, Situation::ManualSpells | Situation::Override);
        let integrating = integrating && !unstable;
        let fast = fast && !unstable;
        let second = draw.chance(0.4);
        let tau = record.pace * if fast { draw.log(0.04, 4.0) } else { draw.log(0.7, 50.0) };
        // A process that runs away cannot be controlled through a long dead time.
        let dead_time = tau * draw.log(0.05, 1.5) * if unstable { 0.25 } else { 1.0 };
        let tau2 = if second { tau * draw.uniform(0.1, 0.9) } else { 0.0 };
        // A large actuator can be slower than its flow.
        let valve_lag =
            tau * match draw.unit() {
                place if place < 0.2 => draw.log(0.3, 3.0),
                place if place < 0.75 => draw.uniform(0.0, 0.3),
                _ => 0.0,
            } * if unstable { 0.1 } else { 1.0 };
        let filtered = draw.chance(0.35);
        let pv_filter = tau * draw.log(0.05, 1.5);
        let noisy = situation == Situation::NoisyControl;
        let pv_filter = if filtered && !noisy && !unstable { pv_filter } else { 0.0 };
        let process = match (integrating, second) {
            _ if unstable => ProcessKind::Unstable,
            (true, _) => ProcessKind::Integrating,
            (_, true) => ProcessKind::SecondOrder,
            _ => ProcessKind::FirstOrder,
        };
        let tau2 = if integrating || unstable { 0.0 } else { tau2 };
        Self { process, tau, tau2, dead_time, valve_lag, pv_filter, fast }
    }
}

/// The controller except for its gain, which follows from the margin.
struct Tuning {
    controller: ControllerKind,
    ti: f64,
    td: f64,
    gain_margin: f64,
}

impl Tuning {
    /// Draws a process. The time of an integrator is then the time constant of its controller.
    fn draw(record: &Record, situation: Situation, lags: &mut Lags, draw: &mut Draw) -> Self {
        // Integral action relative to the lags of the loop.
        let step = record.step();
        let waiting = lags.dead_time + lags.valve_lag + lags.pv_filter + 1.5 * step;
        let slowness = draw.unit();
        let within = |from: f64, to: f64| from * (to / from).powf(slowness);
        let mut ti = match lags.process {
            ProcessKind::Integrating => waiting * within(4.0, 30.0),
            ProcessKind::Unstable => (lags.tau + waiting) * within(2.0, 15.0),
            _ => {
                (lags.tau + lags.tau2 + waiting) * within(0.35, if lags.fast { 15.0 } else { 2.5 })
            }
        };
        let long = record.duration() * draw.log(0.04, 0.6);
        if situation == Situation::FewEvents {
            ti = ti.max(long);
        }
        if lags.process == ProcessKind::Integrating {
            // A valve movement of one percent during the waiting time of the controller is then visible.
            lags.tau = ti * draw.log(0.5, 2.0);
        }
        let controller = match draw.unit() {
            place if place < if situation == Situation::NoisyControl { 0.7 } else { 0.06 } => {
                ControllerKind::P
            }
            place if place < 0.12 => ControllerKind::ErrorSquared,
            place if place < 0.24 => ControllerKind::Pid,
            _ => ControllerKind::Pi,
        };
        let derivative = waiting * draw.uniform(0.2, 0.5);
        let td = if controller == ControllerKind::Pid { derivative } else { 0.0 };
        if controller == ControllerKind::P {
            ti = f64::INFINITY;
        }
        let place = draw.unit();
        let between = |from: f64, to: f64| from * (to / from).powf(place);
        let gain_margin = match situation {
            Situation::FewEvents => between(1.5, 40.0),
            Situation::NearLimit => between(1.02, 1.3),
            Situation::NoisyControl => between(2.0, 30.0),
            _ => between(1.5, 12.0),
        };
        Self { controller, ti, td, gain_margin }
    }
}

impl Curve {
    fn draw(draw: &mut Draw) -> Self {
        match draw.unit() {
            place if place < 0.5 => Curve::Linear,
            place if place < 0.75 => {
                Curve::Exponential { rate: draw.sign() * draw.log(0.003, 0.02) }
            }
            _ => Curve::Kinked { below: draw.log(0.75, 1.33), above: draw.log(0.75, 1.33) },
        }
    }
}
