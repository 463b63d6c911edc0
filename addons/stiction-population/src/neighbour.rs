//! A second loop: the inner loop of a cascade, or an interacting neighbour.

use super::draw::Draw;
use super::stem::{Fitting, Stem};
use realfft::num_complex::Complex;
use stiction_model::bands::Bands;
use stiction_model::closed_loop::{
    AntiWindup, Controller, DeadTime, DelayLine, Engaged, Handover, NormalStream, PidBank, Process,
    ProcessBank, Signal, SignalSource,
};
use stiction_model::error::Result;
use stiction_model::simd::Lane;
use stiction_model::valve::Model;

/// OP of a second loop at rest, percent.
const REST: f64 = 50.0;

/// The drawn loop below: a PI controller around a first-order process. Its PV in percent of its span is the output
/// of the loop above and the input of its process.
#[derive(Debug, Clone)]
pub(super) struct Inner {
    /// Time constant of the process, and of the closed loop, s.
    tau: f64,
    pub lambda: f64,
    gain: f64,
    valve_lag: f64,
    /// Standard deviation of its noise, percent.
    noise: f64,
    /// Shares of the load of the loop above, and of its own load, that act before its process.
    load: f64,
    drift: f64,
    seed: u64,
}

impl Inner {
    /// One that is faster than the loop above, which responds in `slower` s and moves by `activity` percent.
    pub fn draw(step: f64, slower: f64, activity: f64, draw: &mut Draw) -> Self {
        let lambda = (slower * draw.log(0.05, 0.5)).max(3.0 * step);
        let tau = lambda * draw.log(0.7, 5.0);
        Self {
            tau,
            lambda,
            gain: draw.log(0.5, 2.0),
            valve_lag: lambda * draw.uniform(0.0, 0.2),
            noise: activity * draw.log(0.003, 0.2),
            load: draw.uniform(-0.5, 0.5),
            drift: activity * draw.log(0.2, 3.0),
            seed: draw.seed(),
        }
    }

    /// Phase, not wrapped, and gain from its set point to its PV at the angular frequency `w`, sampled every `step` s.
    pub fn phase_and_gain(&self, w: f64, step: f64) -> (f64, f64) {
        let late = Complex::from_polar(1.0, -w * step);
        let lag = |tau: f64| {
            let keep = (-step / tau).exp();
            (1.0 - keep) / (1.0 - keep * late)
        };
        // A lag of the stem acts one step late, as the process does.
        let (valve, steps) = match self.valve_lag > 0.0 {
            true => (lag(self.valve_lag), 2.0),
            false => (Complex::new(1.0, 0.0), 1.0),
        };
        let controller = (1.0 + (step / self.tau) / (1.0 - late)) * self.tau / self.lambda;
        let parts = [controller, valve, lag(self.tau)];
        let around = parts.iter().product::<Complex<f64>>() * late.powf(steps);
        let back = 1.0 + around;
        let phase = parts.iter().map(|part| part.arg()).sum::<f64>() - steps * w * step;
        (phase - back.arg(), around.norm() / back.norm())
    }
}

/// The simulated loop below.
pub(super) struct InnerRun<'a> {
    keep: f64,
    design: &'a Inner,
    controller: PidBank<1>,
    valve: Stem,
    noise: NormalStream,
    drift: SignalSource,
    rest: f64,
    pv: f64,
    op: f64,
}

impl<'a> InnerRun<'a> {
    /// At rest at the set point `rest`, for `n` steps with a total duration of `duration` s.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn new(
        inner: &'a Inner,
        fittings: &[Fitting],
        rest: f64,
        step: f64,
        n: usize,
        duration: f64,
    ) -> Result<Self> {
        let kc = inner.tau / (inner.lambda * inner.gain);
        let settings = pi(kc, inner.tau)?;
        let engaged = Engaged::new(&settings, step, REST, rest, rest);
        let drift = Signal::Noise { sd: inner.drift, tau_s: 0.3 * duration, seed: inner.seed };
        Ok(Self {
            keep: (-step / inner.tau).exp(),
            design: inner,
            controller: PidBank::new(&[engaged]),
            valve: Stem::new(fittings, inner.valve_lag, f64::INFINITY, step, REST)?,
            noise: NormalStream::new(inner.seed ^ 1),
            drift: drift.source(step, n)?,
            rest,
            pv: rest,
            op: REST,
        })
    }

    /// The stem, the position of the valve, and its own PV, with this set point and load of the loop above.
    pub fn step(&mut self, k: usize, asked: f64, load: f64) -> Result<(f64, f64, f64)> {
        let seen = self.pv + self.design.noise * self.noise.draw();
        let before = self.op;
        self.op = self.controller.step(0, asked, seen);
        let (stem, vp) = self.valve.step(k, before, self.op)?;
        let pv = self.pv;
        let pressed = vp - REST + self.design.load * load + self.drift.draw();
        self.pv = self.keep * pv + (1.0 - self.keep) * (self.rest + self.design.gain * pressed);
        Ok((stem, vp, pv))
    }
}

/// A drawn neighbour: first order plus dead time with a gain of one, and a PI controller.
#[derive(Debug, Clone)]
pub(super) struct Neighbour {
    tau: f64,
    dead_time: f64,
    kc: f64,
    ti: f64,
    /// Coupling of its valve, or of its PV, to this loop's load, and in the other direction.
    pub there: f64,
    back: f64,
    /// Whether the PVs act, as through a recycle, with this lag, s; else the valves act at once.
    recycle: Option<f64>,
    noise: f64,
    drift: f64,
    /// S and J of its valve.
    s: f64,
    j: f64,
    he: bool,
    seed: u64,
}

impl Neighbour {
    /// A neighbour that is a few times slower or faster than this loop, which responds in `lags` s and moves by
    /// `activity` percent.
    pub fn draw(step: f64, lags: f64, activity: f64, draw: &mut Draw) -> Self {
        let tau = (lags * draw.log(0.3, 3.0)).max(2.0 * step);
        let dead_time = (tau * draw.log(0.05, 0.8)).max(step);
        let lambda = (dead_time + step) * draw.log(0.6, 4.0);
        let waits = lambda + dead_time + step;
        let ti = tau.min(4.0 * waits) * draw.log(0.5, 1.5);
        Self {
            tau,
            dead_time,
            kc: tau / waits,
            ti,
            there: draw.sign() * draw.log(0.15, 0.9),
            back: draw.sign() * draw.log(0.05, 0.5),
            recycle: draw.chance(0.5).then(|| lags * draw.log(0.3, 5.0)),
            noise: activity * draw.log(0.003, 0.2),
            drift: activity * draw.log(0.2, 3.0),
            s: 0.0,
            j: 0.0,
            he: draw.chance(0.3),
            seed: draw.seed(),
        }
    }

    /// Makes the valve of the neighbour stick, so that the effect has the size of this loop's activity.
    pub fn sticks(&mut self, activity: f64, draw: &mut Draw) {
        let arrives = self.there.abs();
        self.s = (activity * draw.log(0.7, 4.0) / arrives).min(25.0);
        self.j = self.s * draw.uniform(0.1, 1.0);
        // Something must make it cycle.
        self.drift = self.drift.max(0.5 * self.s);
    }

    /// Whether it sticks.
    pub fn is_sticking(&self) -> bool {
        self.s > 0.0
    }

    /// Its valve.
    ///
    /// # Errors
    /// If the bands are invalid.
    pub fn fitting(&self) -> Result<[Fitting; 1]> {
        let model = match (self.is_sticking(), self.he) {
            (false, _) => Model::Ideal,
            (_, true) => Model::He,
            _ => Model::TwoPhase,
        };
        let bands = Bands::from_s_j(self.s, self.j)?;
        Ok([Fitting { from: 0, model: model.build(bands)?, position: None }])
    }
}

/// The simulated neighbour.
pub(super) struct NeighbourRun<'a> {
    design: &'a Neighbour,
    controller: PidBank<1>,
    process: ProcessBank<1, 2>,
    line: DelayLine<1>,
    valve: Stem,
    noise: NormalStream,
    drift: SignalSource,
    /// The lag between the PVs, and its outputs in both directions.
    keep: f64,
    arrived: [f64; 2],
    /// Number of slips of its stem.
    pub slips: usize,
    stems: [f64; 2],
}

impl<'a> NeighbourRun<'a> {
    /// At rest, for `n` steps; the drawn record has `drawn` s.
    ///
    /// # Errors
    /// If the settings of a part are invalid.
    pub fn new(
        beside: &'a Neighbour,
        fittings: &[Fitting],
        step: f64,
        n: usize,
        drawn: f64,
    ) -> Result<Self> {
        let settings = pi(beside.kc, beside.ti)?;
        let engaged = Engaged::new(&settings, step, REST, REST, REST);
        let process = Process::first_order(1.0, beside.tau, beside.dead_time)?;
        let process = process.sampled(step, DeadTime::Nearest)?;
        let tau_s = 0.2 * drawn;
        let drift = Signal::Noise { sd: beside.drift, tau_s, seed: beside.seed };
        Ok(Self {
            design: beside,
            controller: PidBank::new(&[engaged]),
            line: DelayLine::new([process.delay()]),
            process: ProcessBank::new([&process]),
            valve: Stem::new(fittings, 0.0, f64::INFINITY, step, REST)?,
            noise: NormalStream::new(beside.seed ^ 1),
            drift: drift.source(step, n)?,
            keep: beside.recycle.map_or(0.0, |lag| (-step / lag).exp()),
            arrived: [0.0; 2],
            slips: 0,
            stems: [REST; 2],
        })
    }

    /// Addition to this loop's load at step `k`. `before` was its OP; `valve` and `pv` are the deviations of this
    /// loop's valve and PV from rest, the PV in percent of OP.
    pub fn step(&mut self, k: usize, valve: f64, pv: f64) -> Result<f64> {
        let own = self.process.output(0);
        let op = self.controller.step(0, REST, REST + own + self.design.noise * self.noise.draw());
        let (stem, vp) = self.valve.step(k, op, op)?;
        self.slips += usize::from(self.stems[0] == self.stems[1] && stem != self.stems[1]);
        self.stems = [self.stems[1], stem];
        let acting = match self.design.recycle {
            Some(_) => [own, pv],
            None => [vp - REST, valve],
        };
        for (arrived, acting) in self.arrived.iter_mut().zip(acting) {
            *arrived = self.keep * *arrived + (1.0 - self.keep) * acting;
        }
        // Its effect is bounded, as all flows are.
        let back = (self.design.back * self.arrived[1]).clamp(-REST, REST);
        let input = vp - REST + self.drift.draw() + back;
        self.process.advance(self.line.push::<true>(Lane([input])));
        Ok(self.design.there * self.arrived[0])
    }
}

/// A PI controller with bumpless transfer.
pub(super) fn pi(kc: f64, ti: f64) -> Result<Controller> {
    Ok(Controller::pi(kc, ti)?
        .with_limits(0.0, 100.0, AntiWindup::Clamping)?
        .with_handover(Handover::Bumpless))
}
