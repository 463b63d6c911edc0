//! What is drawn of a loop before anything happens to it: process, tuning, surroundings, historian.

use super::Kind;
use super::draw::Draw;
use super::historian::Historian;
use crate::recording::LoopType;
use realfft::num_complex::Complex;

/// What a simulated process is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ProcessKind {
    /// First order plus dead time.
    FirstOrder,
    /// Second order, without oscillation, plus dead time.
    SecondOrder,
    /// An integrator plus dead time.
    Integrating,
}

impl ProcessKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstOrder => "first order",
            Self::SecondOrder => "second order",
            Self::Integrating => "integrating",
        }
    }
}

/// What the noise of a simulated PV is like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NoiseKind {
    /// White and Gaussian.
    White,
    /// Gaussian, of the first order.
    Correlated,
    /// White, of Student's t distribution with 2.5 to 5 degrees of freedom.
    HeavyTailed,
    /// White and Gaussian, 3 to 10 times larger in bursts.
    Bursts,
    /// White and Gaussian, with single outliers of 4 to 15 standard deviations.
    Spikes,
}

impl NoiseKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Correlated => "correlated",
            Self::HeavyTailed => "heavy-tailed",
            Self::Bursts => "bursts",
            Self::Spikes => "spikes",
        }
    }
}

/// What a simulated set point does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SetPointKind {
    /// It stays.
    Constant,
    /// It steps.
    Steps,
    /// It goes from value to value in ramps.
    Ramps,
    /// It wanders, as a controller above writes it.
    Wandering,
    /// A simulated controller above writes it.
    Cascade,
}

impl SetPointKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Steps => "steps",
            Self::Ramps => "ramps",
            Self::Wandering => "wandering",
            Self::Cascade => "cascade",
        }
    }
}

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
        }
    }

    /// Its largest gain within `reach` percent of the operating point.
    fn steepest(self, reach: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Exponential { rate } => (rate.abs() * reach).min(3.0).exp(),
            Self::Kinked { below, above } => below.max(above),
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
    pub few_events: bool,

    pub process: ProcessKind,
    /// Percent of span per percent, or, of an integrator, after one `tau`.
    pub gain: f64,
    pub tau: f64,
    pub tau2: f64,
    pub dead_time: f64,
    pub valve_lag: f64,
    pub curve: Curve,
    pub pv_filter: f64,

    pub kc: f64,
    pub ti: f64,
    pub td: f64,
    pub gain_margin: f64,
    pub velocity_form: bool,
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
    pub fn draw(kind: Kind, draw: &mut Draw) -> Self {
        let mut cause = draw.fork();
        // An eager historian records the same loops with more samples.
        let eager = if draw.chance(0.15) { draw.log(2.0, 10.0) } else { 1.0 };
        let samples = (draw.log(300.0, 2000.5) * eager) as usize;
        let sample_time = draw.one_of([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 60.0]);
        let pace = sample_time * eager;
        let slow_historian = if draw.chance(0.12) { 20 } else { draw.one_of([1, 1, 2, 5, 10]) };
        let steps = if eager > 1.0 { 1 } else { slow_historian };
        let few_events = draw.chance(0.25);
        let duration = samples as f64 * sample_time;

        let integrating = draw.chance(0.3);
        let fast = draw.chance(0.6) && !integrating;
        let second = draw.chance(0.4);
        let mut tau = pace * if fast { draw.log(0.04, 4.0) } else { draw.log(0.7, 50.0) };
        let dead_time = tau * draw.log(0.05, 1.5);
        let tau2 = if second { tau * draw.uniform(0.1, 0.9) } else { 0.0 };
        // A large actuator can be slower than the flow that it controls.
        let valve_lag = tau
            * match draw.unit() {
                place if place < 0.2 => draw.log(0.3, 3.0),
                place if place < 0.75 => draw.uniform(0.0, 0.3),
                _ => 0.0,
            };
        let pv_filter = if draw.chance(0.35) { tau * draw.log(0.05, 1.5) } else { 0.0 };
        let process = match (integrating, second) {
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
        let td = if draw.chance(0.12) { waiting * draw.uniform(0.2, 0.5) } else { 0.0 };
        let gain_margin = draw.log(1.5, if few_events { 40.0 } else { 12.0 });

        let s = draw.log(0.5, 13.0);
        // In a calm loop little happens but what its valve does.
        let calm = if draw.chance(0.2) { draw.log(0.04, 0.5) } else { 1.0 };
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
            few_events,
            process,
            gain: draw.log(0.4, 2.5) * draw.sign(),
            tau,
            tau2: if integrating { 0.0 } else { tau2 },
            dead_time,
            valve_lag,
            curve,
            pv_filter,
            kc: 0.0,
            ti,
            td,
            gain_margin,
            velocity_form: draw.chance(0.2),
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
            noise_ratio: draw.log(0.003, 0.5),
            non_stationary: draw.chance(0.2),
            set_point: if moves { set_point } else { SetPointKind::Constant },
            historian: Historian::draw(draw),
            sp_recorded: draw.chance(0.6),
            pv_range: (low, span),
            loop_type: if typed { loop_type } else { LoopType::Unknown },
        };
        match kind {
            Kind::AggressiveTuning => design.gain_margin = cause.log(0.85, 1.25),
            Kind::SetPoint => design.set_point = set_point,
            Kind::ProcessNonlinearity => {
                let rate = cause.uniform(0.5, 1.5) / design.activity.max(5.0);
                design.curve = Curve::Exponential { rate: rate * cause.sign() };
            }
            _ => {}
        }
        design.tune();
        // Long enough to settle into a cycle, but no longer than half the record.
        let settled = (30.0 * design.ti / step).min((samples * steps / 2) as f64);
        design.warm_up = settled as usize + 40;
        design
    }

    /// Time between steps of controller and valve, s.
    pub fn step(&self) -> f64 {
        self.sample_time / self.steps as f64
    }

    /// All steps, those before the record included.
    pub fn all_steps(&self) -> usize {
        self.warm_up + self.samples * self.steps
    }

    /// The time the loop takes to answer, s: what a change at the set point has to wait for.
    pub fn response_time(&self) -> f64 {
        let waiting = self.dead_time + self.valve_lag + self.pv_filter + self.step();
        let loop_gain = (self.kc * self.gain).abs();
        waiting
            + match self.process {
                ProcessKind::Integrating => self.tau / loop_gain,
                _ => (self.ti / loop_gain).max(self.tau + self.tau2),
            }
    }

    /// Sets the controller gain: the ultimate one over the gain margin.
    pub fn tune(&mut self) {
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
        let (mut phase, mut gain) = (-w * (whole + 1.0) * step, 1.0);
        let mut times = |factor: Complex<f64>| {
            phase += factor.arg();
            gain *= factor.norm();
        };
        let keep_of = |tau: f64, time: f64| (-time / tau).exp();
        let lag = |tau: f64| (1.0 - keep_of(tau, step)) / (1.0 - keep_of(tau, step) * late);
        times(match self.process {
            ProcessKind::Integrating => ((step - early) + early * late) / self.tau / (1.0 - late),
            _ => {
                let (keep, rest) = (keep_of(self.tau, step), keep_of(self.tau, step - early));
                ((1.0 - rest) + (rest - keep) * late) / (1.0 - keep * late)
            }
        });
        for tau in [self.tau2, self.valve_lag, self.pv_filter] {
            if tau > 0.0 {
                times(lag(tau));
            }
        }
        let mut controller = 1.0 + (step / self.ti) / (1.0 - late);
        if self.td > 0.0 {
            let filter = self.td / crate::closed_loop::Controller::FILTER_FACTOR;
            let keep = filter / (filter + step);
            controller += self.td / (filter + step) * (1.0 - late) / (1.0 - keep * late);
        }
        times(controller);
        if self.valve_lag > 0.0 {
            phase -= w * step;
        }
        (phase, gain)
    }
}
