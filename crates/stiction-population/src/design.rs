//! What is drawn of a loop before anything happens to it: process, tuning, surroundings, historian.

use super::LoopKind;
use super::draw::Draw;
use super::families::{ControllerKind, NoiseKind, ProcessKind, SetPointKind, Situation};
use super::historian::Historian;
use super::neighbour::{Inner, Neighbour};
use super::plant::TRANSMITTER;
use realfft::num_complex::Complex;
use stiction_diagnose::recording::LoopType;

/// The static curve between valve position and process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Curve {
    Linear,
    /// The gain grows by the factor e over `1 / rate` percent.
    Exponential {
        rate: f64,
    },
    /// One gain below the operating point, another above.
    Kinked {
        below: f64,
        above: f64,
    },
    /// One valve up to `at`, from `gap` further on (or sooner, if negative) another of `ratio` the size.
    Split {
        at: f64,
        gap: f64,
        ratio: f64,
    },
}

impl Curve {
    /// What the process sees of `v`, percent from the operating point.
    #[inline]
    pub fn at(self, v: f64) -> f64 {
        match self {
            Self::Linear => v,
            // Beyond three e-folds it goes on as it left off.
            Self::Exponential { rate } => {
                let within = (rate * v).clamp(-3.0, 3.0);
                (within.exp_m1() + within.exp() * (rate * v - within)) / rate
            }
            Self::Kinked { below, above } => v * if v < 0.0 { below } else { above },
            Self::Split { at, gap, ratio } => v.min(at) + ratio * (v - at - gap).max(0.0),
        }
    }

    /// Its largest gain within `reach` percent of the operating point.
    fn steepest(self, reach: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Exponential { rate } => (rate.abs() * reach).min(3.0).exp(),
            Self::Kinked { below, above } => below.max(above),
            Self::Split { gap, ratio, .. } if gap < 0.0 => 1.0 + ratio,
            Self::Split { ratio, .. } => ratio.max(1.0),
        }
    }
}

/// A loop as it is drawn. PV and SP are in percent of the transmitter's span here; the units of a
/// plant come last.
#[derive(Debug, Clone)]
pub(super) struct Design {
    pub samples: usize,
    pub sample_time: f64,
    /// What an ordinary historian would take for its sample time, s: longer than that of an eager one.
    /// Times of the loop are drawn in it.
    pub pace: f64,
    /// Steps of controller and valve per recorded sample.
    pub steps: usize,
    /// Steps before the record begins.
    pub warm_up: usize,
    /// All steps of the record as it was drawn, those before it included; it may be recorded for longer.
    pub drawn_steps: usize,
    pub situation: Situation,

    pub process: ProcessKind,
    /// Percent of span per percent, or, of an integrator, after one `tau`.
    pub gain: f64,
    pub tau: f64,
    pub tau2: f64,
    pub dead_time: f64,
    pub valve_lag: f64,
    pub curve: Curve,
    pub pv_filter: f64,

    pub controller: ControllerKind,
    pub kc: f64,
    /// Infinite without integral action.
    pub ti: f64,
    pub td: f64,
    pub gain_margin: f64,
    pub velocity_form: bool,
    /// Of a gain that grows with the error: its share at no error, and the error in percent of span from which on it is whole.
    pub squared: Option<(f64, f64)>,
    /// Standard deviation of what noise of its own the controller adds to its OP, percent.
    pub own_noise: f64,
    /// Steps between two samples of the PV that the controller sees.
    pub analyser: usize,
    /// Most that the actuator moves, percent a second.
    pub stroke: f64,
    /// What the transmitter can say, percent of span.
    pub transmitter: (f64, f64),
    pub inner: Option<Inner>,
    pub neighbour: Option<Neighbour>,
    pub limits: (f64, f64),
    pub op_rest: f64,
    pub pv_rest: f64,

    /// How much happens, percent of OP: the scale of loads, set-point changes and noise.
    pub activity: f64,
    /// The S that the valve has if it sticks; it scales the activity whether it sticks or not.
    pub s: f64,
    pub noise: NoiseKind,
    /// Standard deviation of the noise over the activity's effect on the PV.
    pub noise_ratio: f64,
    /// How much of what happens to every loop happens to this, 0 to 1: little where noise alone moves the OP.
    pub happens: f64,
    pub non_stationary: bool,
    pub set_point: SetPointKind,

    pub historian: Historian,
    pub sp_recorded: bool,
    /// PV at 0 % and its span, in units of the plant.
    pub pv_range: (f64, f64),
    pub loop_type: LoopType,
}

impl Design {
    /// A loop of this kind.
    pub fn draw(kind: LoopKind, draw: &mut Draw) -> Self {
        let mut cause = draw.fork();
        // An eager historian records the same loops with more samples.
        let eager = if draw.chance(0.15) { draw.log(2.0, 10.0) } else { 1.0 };
        let samples = (draw.log(300.0, 2000.5) * eager) as usize;
        let sample_time = draw.one_of([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 60.0]);
        let pace = sample_time * eager;
        let slow_historian = if draw.chance(0.12) { 20 } else { draw.one_of([1, 1, 2, 5, 10]) };
        let steps = if eager > 1.0 { 1 } else { slow_historian };
        let situation = Self::situation(kind, draw);
        let few_events = situation == Situation::FewEvents;
        let near_limit = situation == Situation::NearLimit;
        let mut special = draw.fork();
        let duration = samples as f64 * sample_time;

        let integrating = draw.chance(0.3);
        // A loop that rings in a few samples would only be seen as noise.
        let fast = draw.chance(if near_limit { 0.15 } else { 0.6 }) && !integrating;
        let unstable = special.chance(if near_limit { 0.2 } else { 0.03 })
            && !matches!(situation, Situation::ManualSpells | Situation::Override);
        let integrating = integrating && !unstable;
        let fast = fast && !unstable;
        let second = draw.chance(0.4);
        let mut tau = pace * if fast { draw.log(0.04, 4.0) } else { draw.log(0.7, 50.0) };
        // What runs away cannot be held through a long dead time.
        let dead_time = tau * draw.log(0.05, 1.5) * if unstable { 0.25 } else { 1.0 };
        let tau2 = if second { tau * draw.uniform(0.1, 0.9) } else { 0.0 };
        // A large actuator can be slower than the flow that it controls.
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

        // Integral action against the lags it has to wait for.
        let step = sample_time / steps as f64;
        let waiting = dead_time + valve_lag + pv_filter + 1.5 * step;
        let slowness = draw.unit();
        let within = |from: f64, to: f64| from * (to / from).powf(slowness);
        let mut ti = match process {
            ProcessKind::Integrating => waiting * within(4.0, 30.0),
            ProcessKind::Unstable => (tau + waiting) * within(2.0, 15.0),
            _ => (tau + tau2 + waiting) * within(0.35, if fast { 15.0 } else { 2.5 }),
        };
        let long = duration * draw.log(0.04, 0.6);
        if few_events {
            ti = ti.max(long);
        }
        if integrating {
            // Then a valve that moves by a percent for as long as the controller waits is seen.
            tau = ti * draw.log(0.5, 2.0);
        }
        let controller = match draw.unit() {
            place if place < if noisy { 0.7 } else { 0.06 } => ControllerKind::P,
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

        let s = draw.log(0.5, 13.0);
        // In a calm loop little happens but what its valve does.
        let calm = draw.chance(if near_limit { 0.75 } else { 0.2 });
        let calm = draw.log(0.04, 0.5).powf(f64::from(u8::from(calm)));
        let activity = s * calm * draw.log(0.25, 1.6);
        let curve = match draw.unit() {
            place if place < 0.5 => Curve::Linear,
            place if place < 0.75 => {
                Curve::Exponential { rate: draw.sign() * draw.log(0.003, 0.02) }
            }
            _ => Curve::Kinked { below: draw.log(0.75, 1.33), above: draw.log(0.75, 1.33) },
        };
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
            tau2: if integrating || unstable { 0.0 } else { tau2 },
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
        if noisy {
            design.make_noisy(&mut special);
        }
        // Long enough to settle into a cycle, but no longer than half the record.
        let waits = if design.ti.is_finite() { design.ti } else { design.response_time() };
        let settled = (30.0 * waits / step).min((samples * steps / 2) as f64);
        design.warm_up = settled as usize + 40;
        design.drawn_steps = design.all_steps();
        design
    }

    /// What is special about a loop of this kind.
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
            // Seen from the loop above, these are loops of the kind `StickyBelow`.
            (LoopKind::Sticky | LoopKind::Stuck, Situation::OuterLoop) => Situation::Ordinary,
            _ => drawn,
        }
    }

    /// Draws what belongs to the situation, but for what happens in it.
    fn specialise(&mut self, draw: &mut Draw) {
        let scale = (self.gain * self.activity).abs();
        if self.controller == ControllerKind::ErrorSquared {
            self.squared = Some((draw.uniform(0.1, 0.6), scale * draw.log(0.3, 3.0)));
        }
        match self.situation {
            Situation::OuterLoop => {
                let inner = Inner::draw(self, draw);
                self.valve_lag = inner.lambda;
                self.inner = Some(inner);
                if draw.chance(0.3) {
                    self.gain_margin = draw.log(1.02, 1.4);
                }
            }
            Situation::Coupled => self.neighbour = Some(Neighbour::draw(self, draw)),
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

    /// Gives the OP its noise: up to four times the band, from the PV or of the controller's own. In two of five the
    /// noise of the PV is all that moves the OP: little else happens, and integral action is slow for the record.
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

    /// What noise the controller gives its OP, percent: that of the PV, filtered and times its gain, and its own.
    pub fn op_noise(&self) -> f64 {
        let keep = if self.pv_filter > 0.0 { (-self.step() / self.pv_filter).exp() } else { 0.0 };
        let of_pv = self.noise_ratio * self.activity * self.gain * self.kc;
        (of_pv.powi(2) * (1.0 - keep) / (1.0 + keep) + self.own_noise.powi(2)).sqrt()
    }

    /// Lags and waiting of the loop, s.
    fn response_time_untuned(&self) -> f64 {
        self.tau + self.tau2 + self.dead_time + self.valve_lag + self.step()
    }

    /// Time between steps of controller and valve, s.
    pub fn step(&self) -> f64 {
        self.sample_time / self.steps as f64
    }

    /// Records it `factor` times as long.
    pub fn record_for(&mut self, factor: f64) {
        self.samples = (self.samples as f64 * factor).round().max(2.0) as usize;
    }

    /// All steps, those before the record included.
    pub fn all_steps(&self) -> usize {
        self.warm_up + self.samples * self.steps
    }

    /// The time the loop takes to answer, s: what a change at the set point has to wait for.
    pub fn response_time(&self) -> f64 {
        let waiting = self.dead_time + self.valve_lag + self.pv_filter + self.held() + self.step();
        let loop_gain = (self.kc * self.gain).abs();
        waiting
            + match self.process {
                ProcessKind::Integrating => self.tau / loop_gain,
                _ if self.ti.is_finite() => (self.ti / loop_gain).max(self.tau + self.tau2),
                _ => self.tau + self.tau2,
            }
    }

    /// Duration of the record as it was drawn, s.
    pub fn drawn(&self) -> f64 {
        match self.drawn_steps {
            0 => self.samples as f64 * self.sample_time,
            steps => (steps - self.warm_up) as f64 * self.step(),
        }
    }

    /// How long the analyser's values are old on average, s.
    fn held(&self) -> f64 {
        0.5 * self.step() * (self.analyser - 1) as f64
    }

    /// Sets the controller gain: the ultimate one over the gain margin; of a process that runs away, which needs
    /// some gain, one between the least and the ultimate.
    pub fn tune(&mut self) {
        if self.process == ProcessKind::Unstable {
            return self.tune_unstable();
        }
        let steepest = self.curve.steepest(self.activity);
        let mut gain = self.ultimate_gain() / (self.gain_margin * steepest);
        if self.process == ProcessKind::Integrating && self.gain_margin >= 1.5 {
            // A double integrator rings when the controller waits too little for its low gain:
            // damping is half the root of gain times integral time.
            self.ti = self.ti.max(4.0 * 0.3 * 0.3 * self.tau / gain);
            gain = self.ultimate_gain() / (self.gain_margin * steepest);
        }
        self.kc = gain / self.gain;
    }

    /// The ultimate gain over the gain margin, or near the least that holds the process, whichever is more.
    fn tune_unstable(&mut self) {
        let highest = std::f64::consts::PI / self.step();
        let lowest = 1e-3 / (self.tau + self.dead_time);
        let at = |share: f64| lowest * (highest / lowest).powf(share);
        let beyond = |design: &Self, w: f64| design.phase_and_gain(w).0 + std::f64::consts::PI;
        for _ in 0..12 {
            // Between the two frequencies at which the phase is -180 degrees it is above.
            let best = (0..80)
                .map(|k| at(f64::from(k) / 80.0))
                .max_by(|a, b| beyond(self, *a).total_cmp(&beyond(self, *b)))
                .unwrap_or(lowest);
            let edge = |mut inside: f64, mut outside: f64| {
                for _ in 0..40 {
                    let w = (inside * outside).sqrt();
                    if beyond(self, w) > 0.0 { inside = w } else { outside = w }
                }
                1.0 / self.phase_and_gain(inside).1
            };
            if beyond(self, best) > 0.0 {
                let (least, most) = (edge(best, lowest), edge(best, highest));
                if most > 1.3 * least {
                    // The integral needs a little more than the least.
                    let gain = (most / self.gain_margin).max(least * (most / least).powf(0.25));
                    self.gain_margin = most / gain;
                    self.kc = gain / self.gain;
                    return;
                }
            }
            self.ti *= 2.0;
            self.dead_time *= 0.8;
        }
        // It cannot be held; the draw is given up for what it does.
        self.kc = 1.0 / self.gain;
    }

    /// The controller gain at which the loop would cycle with a process gain of 1: that of the frequency
    /// at which the phase is -180 degrees. (Exact but for a second lag, which is sampled by itself.)
    fn ultimate_gain(&self) -> f64 {
        let (mut low, mut high) = (0.0, std::f64::consts::PI / self.step());
        for _ in 0..40 {
            let w = 0.5 * (low + high);
            if self.phase_and_gain(w).0 > -std::f64::consts::PI { low = w } else { high = w }
        }
        1.0 / self.phase_and_gain(high).1
    }

    /// Phase, not wrapped, and gain of the sampled loop at the angular frequency `w`, for process and
    /// controller gains of 1.
    fn phase_and_gain(&self, w: f64) -> (f64, f64) {
        let step = self.step();
        let late = Complex::from_polar(1.0, -w * step);
        // The part of a step for which the process first still sees the older input.
        let whole = (self.dead_time / step).floor();
        let early = self.dead_time - whole * step;
        let (mut phase, mut gain) = (-w * ((whole + 1.0) * step + self.held()), 1.0);
        let mut times = |factor: Complex<f64>| {
            phase += factor.arg();
            gain *= factor.norm();
        };
        let keep_of = |tau: f64, time: f64| (-time / tau).exp();
        let lag = |tau: f64| (1.0 - keep_of(tau, step)) / (1.0 - keep_of(tau, step) * late);
        times(match self.process {
            ProcessKind::Integrating => ((step - early) + early * late) / self.tau / (1.0 - late),
            ProcessKind::Unstable => {
                let (grow, rest) = ((step / self.tau).exp(), ((step - early) / self.tau).exp());
                ((rest - 1.0) + (grow - rest) * late) / (1.0 - grow * late)
            }
            _ => {
                let (keep, rest) = (keep_of(self.tau, step), keep_of(self.tau, step - early));
                ((1.0 - rest) + (rest - keep) * late) / (1.0 - keep * late)
            }
        });
        // A loop below takes the place of the valve's lag.
        let valve_lag = if self.inner.is_some() { 0.0 } else { self.valve_lag };
        for tau in [self.tau2, valve_lag, self.pv_filter] {
            if tau > 0.0 {
                times(lag(tau));
            }
        }
        let mut controller = 1.0 + (step / self.ti) / (1.0 - late);
        if self.td > 0.0 {
            let filter = self.td / stiction_model::closed_loop::Controller::FILTER_FACTOR;
            let keep = filter / (filter + step);
            controller += self.td / (filter + step) * (1.0 - late) / (1.0 - keep * late);
        }
        times(controller);
        if valve_lag > 0.0 {
            phase -= w * step;
        }
        if let Some(inner) = &self.inner {
            let (late, passes) = inner.phase_and_gain(w, step);
            (phase, gain) = (phase + late, gain * passes);
        }
        (phase, gain)
    }
}
