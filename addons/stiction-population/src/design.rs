//! The random draw of a loop before its simulation: process, tuning, surroundings, historian.

mod drawn;

use super::families::{ControllerKind, NoiseKind, ProcessKind, SetPointKind, Situation};
use super::historian::Historian;
use super::neighbour::{Inner, Neighbour};
use realfft::num_complex::Complex;
use stiction_diagnose::recording::LoopType;

/// Range of a transmitter, percent of span (NAMUR NE 43: 3.8 to 20.5 mA).
pub(super) const TRANSMITTER: (f64, f64) = (-1.25, 103.125);

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
    /// One valve up to `at`; from `gap` further on (or sooner, if negative) another with `ratio` times the size.
    Split {
        at: f64,
        gap: f64,
        ratio: f64,
    },
}

impl Curve {
    /// The input of the process for `v`, percent from the operating point.
    #[inline]
    pub fn at(self, v: f64) -> f64 {
        match self {
            Self::Linear => v,
            // Beyond three e-folds it continues linearly.
            Self::Exponential { rate } => {
                let within = (rate * v).clamp(-3.0, 3.0);
                (within.exp_m1() + within.exp() * (rate * v - within)) / rate
            }
            Self::Kinked { below, above } => v * if v < 0.0 { below } else { above },
            Self::Split { at, gap, ratio } => v.min(at) + ratio * (v - at - gap).max(0.0),
        }
    }

    /// Largest gain within `reach` percent of the operating point.
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

/// A drawn loop. PV and SP are in percent of the transmitter's span here; the units of a plant are applied last.
#[derive(Debug, Clone)]
pub(super) struct Design {
    pub samples: usize,
    pub sample_time: f64,
    /// Sample time of an ordinary historian, s. It is longer than the sample time of an eager historian. Times of the
    /// loop are drawn in units of this time.
    pub pace: f64,
    /// Steps of controller and valve per recorded sample.
    pub steps: usize,
    /// Steps before the record begins.
    pub warm_up: usize,
    /// All steps of the drawn record, including the steps before it. The recording may be longer.
    pub drawn_steps: usize,
    pub situation: Situation,

    pub process: ProcessKind,
    /// Percent of span per percent; for an integrator, after one `tau`.
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
    /// For a gain that grows with the error: its share at zero error, and the error in percent of span from which the
    /// gain is full.
    pub squared: Option<(f64, f64)>,
    /// Standard deviation of the controller's own noise on its OP, percent.
    pub own_noise: f64,
    /// Steps between two samples of the PV in the controller.
    pub analyser: usize,
    /// Largest speed of the actuator, percent a second.
    pub stroke: f64,
    /// Range of the transmitter, percent of span.
    pub transmitter: (f64, f64),
    pub inner: Option<Inner>,
    pub neighbour: Option<Neighbour>,
    pub limits: (f64, f64),
    pub op_rest: f64,
    pub pv_rest: f64,

    /// Activity, percent of OP: the scale of loads, set-point changes and noise.
    pub activity: f64,
    /// The S of the valve if it sticks. It scales the activity in any case.
    pub s: f64,
    pub noise: NoiseKind,
    /// Standard deviation of the noise over the activity's effect on the PV.
    pub noise_ratio: f64,
    /// Share of the usual events in this loop, 0 to 1: small if noise alone moves the OP.
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
    /// Noise of the OP, percent: the noise of the PV, filtered and times the gain, plus the controller's own noise.
    pub fn op_noise(&self) -> f64 {
        let keep = if self.pv_filter > 0.0 { (-self.step() / self.pv_filter).exp() } else { 0.0 };
        let of_pv = self.noise_ratio * self.activity * self.gain * self.kc;
        (of_pv.powi(2) * (1.0 - keep) / (1.0 + keep) + self.own_noise.powi(2)).sqrt()
    }

    /// Sum of the lags, the dead time and the sample time of the loop, s.
    pub fn response_time_untuned(&self) -> f64 {
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

    /// All steps, including those before the record.
    pub fn all_steps(&self) -> usize {
        self.warm_up + self.samples * self.steps
    }

    /// Response time of the loop, s: the waiting time after a change of the set point.
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

    /// Duration of the drawn record, s.
    pub fn drawn(&self) -> f64 {
        match self.drawn_steps {
            0 => self.samples as f64 * self.sample_time,
            steps => (steps - self.warm_up) as f64 * self.step(),
        }
    }

    /// Mean age of the analyser's values, s.
    fn held(&self) -> f64 {
        0.5 * self.step() * (self.analyser - 1) as f64
    }

    /// Sets the controller gain to the ultimate one over the gain margin. A process that runs away needs some gain:
    /// it gets one between the smallest and the ultimate.
    pub fn tune(&mut self) {
        if self.process == ProcessKind::Unstable {
            return self.tune_unstable();
        }
        let steepest = self.curve.steepest(self.activity);
        let mut gain = self.ultimate_gain() / (self.gain_margin * steepest);
        if self.process == ProcessKind::Integrating && self.gain_margin >= 1.5 {
            // A double integrator rings when the controller waits too little for its low gain: the damping is half
            // the root of gain times integral time.
            self.ti = self.ti.max(4.0 * 0.3 * 0.3 * self.tau / gain);
            gain = self.ultimate_gain() / (self.gain_margin * steepest);
        }
        self.kc = gain / self.gain;
    }

    /// The ultimate gain over the gain margin, or near the smallest that holds the process, whichever is larger.
    fn tune_unstable(&mut self) {
        let highest = std::f64::consts::PI / self.step();
        let lowest = 1e-3 / (self.tau + self.dead_time);
        let at = |share: f64| lowest * (highest / lowest).powf(share);
        let beyond = |design: &Self, w: f64| design.phase_and_gain(w).0 + std::f64::consts::PI;
        for _ in 0..12 {
            // The phase is above -180 degrees between the two frequencies at which it equals it.
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
                    // The integral needs a little more than the smallest gain.
                    let gain = (most / self.gain_margin).max(least * (most / least).powf(0.25));
                    self.gain_margin = most / gain;
                    self.kc = gain / self.gain;
                    return;
                }
            }
            self.ti *= 2.0;
            self.dead_time *= 0.8;
        }
        // It cannot be controlled; the draw is rejected for its behaviour.
        self.kc = 1.0 / self.gain;
    }

    /// The controller gain of a limit cycle with a process gain of 1, at the frequency of a phase of -180 degrees.
    /// (Exact except for a second lag, which is sampled by itself.)
    fn ultimate_gain(&self) -> f64 {
        let (mut low, mut high) = (0.0, std::f64::consts::PI / self.step());
        for _ in 0..40 {
            let w = 0.5 * (low + high);
            if self.phase_and_gain(w).0 > -std::f64::consts::PI { low = w } else { high = w }
        }
        1.0 / self.phase_and_gain(high).1
    }

    /// Phase, not wrapped, and gain of the sampled loop at the angular frequency `w`, for process and controller
    /// gains of 1.
    fn phase_and_gain(&self, w: f64) -> (f64, f64) {
        let step = self.step();
        let late = Complex::from_polar(1.0, -w * step);
        // The part of a step in which the process still sees the older input.
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
        // A loop below replaces the valve's lag.
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
