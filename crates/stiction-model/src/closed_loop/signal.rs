//! Signals over time: set points, disturbances, noise, test inputs.

use super::random::NormalStream;
use crate::error::{Error, Result, all_finite, finite, non_negative, positive};

/// A periodic waveform between -1 and 1 that starts at 0 and rises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wave {
    /// A sine.
    Sine,
    /// The periodic ramp: straight up, straight down.
    Ramp,
    /// A square wave; at its start already high.
    Square,
}

impl Wave {
    /// The value at `phase`, counted in periods.
    fn at(self, mut phase: f64) -> f64 {
        if self == Self::Square {
            // An edge at a whole number of samples must not shift by rounding.
            phase += phase.abs() * 1e-12;
        }
        let p = phase - phase.floor();
        match self {
            Self::Sine => (std::f64::consts::TAU * p).sin(),
            Self::Ramp if p < 0.25 => 4.0 * p,
            Self::Ramp if p < 0.75 => 2.0 - 4.0 * p,
            Self::Ramp => 4.0 * p - 4.0,
            Self::Square if p < 0.5 => 1.0,
            Self::Square => -1.0,
        }
    }
}

/// A signal over time. Values are in the units of the driven quantity.
#[derive(Debug, Clone, PartialEq)]
pub enum Signal {
    /// Always the same value.
    Constant(f64),
    /// `mean + amplitude * wave`, with the waveform shifted ahead by `phase` periods.
    Periodic {
        /// Shape of one period.
        wave: Wave,
        /// Mean value.
        mean: f64,
        /// Half its peak-to-peak value.
        amplitude: f64,
        /// Duration of one period, s.
        period_s: f64,
        /// Where in its period it starts, as a fraction of the period.
        phase: f64,
    },
    /// Each value holds from its time on. Before the first time, the first value holds. Times in s, ascending.
    Steps(Vec<(f64, f64)>),
    /// `start + slope (t - from)` from the time `from` on; `start` before.
    Line {
        /// Value at the beginning.
        start: f64,
        /// Change per second.
        slope_per_s: f64,
        /// Time at which it begins to move, s.
        from_s: f64,
    },
    /// `steps` equal stairs up, the same stairs down, over and over.
    Staircase {
        /// Lowest value.
        start: f64,
        /// Height of a stair.
        step: f64,
        /// Time spent on each stair, s.
        dwell_s: f64,
        /// Number of stairs up.
        steps: u32,
    },
    /// Gaussian noise around zero: white, or of the first order.
    Noise {
        /// Standard deviation.
        sd: f64,
        /// Correlation time, s: autocorrelation `exp(-lag/tau)`. 0 is white.
        tau_s: f64,
        /// Seed of its stream.
        seed: u64,
    },
    /// A Gaussian random walk from zero.
    RandomWalk {
        /// Standard deviation after one second. It grows with the square root of time.
        sd_per_sqrt_s: f64,
        /// Seed of its stream.
        seed: u64,
    },
    /// One value a sample, as read from a file.
    Samples(Vec<f64>),
}

impl Signal {
    /// A step from `before` to `after` at time `at_s`.
    pub fn step(before: f64, after: f64, at_s: f64) -> Self {
        Self::Steps(vec![(f64::MIN, before), (at_s, after)])
    }

    /// The signal's first `n` samples, one every `sample_time` seconds, beginning at time 0.
    ///
    /// # Errors
    /// As [`Signal::source`]; also if a [`Signal::Samples`] is shorter than `n`.
    pub fn sample(&self, sample_time: f64, n: usize) -> Result<Vec<f64>> {
        let mut samples = vec![0.0; n];
        self.source(sample_time, n)?.add_to(&mut samples, |sample| sample);
        Ok(samples)
    }

    /// The signal as a stream of samples, one every `sample_time` seconds, for `n` of them.
    ///
    /// # Errors
    /// If a number is not finite, a duration or a standard deviation is negative, a period or a
    /// dwell time is zero, the times of [`Signal::Steps`] do not ascend, or there are fewer than
    /// `n` [`Signal::Samples`].
    pub fn source(&self, sample_time: f64, n: usize) -> Result<SignalSource> {
        positive("sample time", sample_time)?;
        let mut state = State::None;
        match self {
            Self::Constant(value) => {
                finite("signal value", *value)?;
            }
            Self::Periodic { mean, amplitude, period_s, phase, .. } => {
                finite("signal mean", *mean)?;
                finite("signal amplitude", *amplitude)?;
                positive("signal period", *period_s)?;
                finite("signal phase", *phase)?;
            }
            Self::Steps(steps) => {
                if steps.is_empty() {
                    return Err(Error::Inconsistent(
                        "a signal made of steps needs at least one (time, value) pair".to_owned(),
                    ));
                }
                for (time, value) in steps {
                    finite("time of a step", *time)?;
                    finite("value of a step", *value)?;
                }
                if let Some(pair) = steps.windows(2).find(|pair| !(pair[0].0 < pair[1].0)) {
                    return Err(Error::Inconsistent(format!(
                        "the times of a signal's steps must ascend, but {} s follows {} s",
                        pair[1].0, pair[0].0
                    )));
                }
                state = State::Next(1);
            }
            Self::Line { start, slope_per_s, from_s } => {
                finite("signal start", *start)?;
                finite("signal slope", *slope_per_s)?;
                finite("time at which the signal starts to move", *from_s)?;
            }
            Self::Staircase { start, step, dwell_s, steps } => {
                finite("staircase start", *start)?;
                finite("staircase step", *step)?;
                positive("staircase dwell time", *dwell_s)?;
                positive("number of stairs", f64::from(*steps))?;
            }
            Self::Noise { sd, tau_s, seed } => {
                non_negative("noise standard deviation", *sd)?;
                let ratio = sample_time / non_negative("noise correlation time", *tau_s)?;
                let keep = (-ratio).exp();
                let mut stream = NormalStream::new(*seed);
                // Begin in the stationary state.
                let value = sd * stream.draw();
                let fresh = sd * (1.0 - keep * keep).sqrt();
                state = State::Noise { keep, fresh, value, stream };
            }
            Self::RandomWalk { sd_per_sqrt_s, seed } => {
                let sd = non_negative("random walk standard deviation", *sd_per_sqrt_s)?;
                let stream = NormalStream::new(*seed);
                let fresh = sd * sample_time.sqrt();
                state = State::Noise { keep: 1.0, fresh, value: 0.0, stream };
            }
            Self::Samples(samples) => {
                all_finite("signal", samples)?;
                if samples.len() < n {
                    return Err(Error::Length {
                        name: "signal",
                        found: samples.len(),
                        expected: n,
                    });
                }
            }
        }
        Ok(SignalSource { signal: self.clone(), sample_time, index: 0, state })
    }
}

#[derive(Debug, Clone, PartialEq)]
enum State {
    None,
    /// The next step.
    Next(usize),
    /// The present value of a first-order noise: `value = keep value + fresh N(0, 1)`.
    Noise {
        keep: f64,
        fresh: f64,
        value: f64,
        stream: NormalStream,
    },
}

/// A [`Signal`] during sampling.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalSource {
    signal: Signal,
    sample_time: f64,
    index: usize,
    state: State,
}

/// Whether the time of a step has come; a step at a whole number of samples must not shift by rounding.
fn reached(steps: &[(f64, f64)], step: usize, time: f64) -> bool {
    steps.get(step).is_some_and(|(at, _)| *at <= time * (1.0 + 1e-12))
}

impl SignalSource {
    /// Adds its next samples to a part of each of these.
    pub(super) fn add_to<T>(&mut self, all: &mut [T], part: impl Fn(&mut T) -> &mut f64) {
        let end = self.index + all.len();
        let last = end.saturating_sub(1) as f64 * self.sample_time;
        match (&self.signal, &self.state) {
            (Signal::Samples(samples), _) if samples.len() >= end => {
                let samples = &samples[self.index..end];
                all.iter_mut().zip(samples).for_each(|(to, sample)| *part(to) += sample);
                self.index = end;
            }
            (Signal::Constant(value), _) => {
                all.iter_mut().for_each(|to| *part(to) += value);
                self.index = end;
            }
            (Signal::Steps(steps), State::Next(next @ 1..)) if !reached(steps, *next, last) => {
                let value = steps[next - 1].1;
                all.iter_mut().for_each(|to| *part(to) += value);
                self.index = end;
            }
            _ => all.iter_mut().for_each(|to| *part(to) += self.draw()),
        }
    }

    /// The next sample. (Past the end of [`Signal::Samples`], their last.)
    #[inline]
    pub fn draw(&mut self) -> f64 {
        let k = self.index;
        let t = k as f64 * self.sample_time;
        self.index += 1;
        match (&self.signal, &mut self.state) {
            (Signal::Noise { .. } | Signal::RandomWalk { .. }, state) => {
                let State::Noise { keep, fresh, value, stream } = state else { return 0.0 };
                let present = *value;
                *value = *keep * present + *fresh * stream.draw();
                present
            }
            (Signal::Constant(value), _) => *value,
            (Signal::Periodic { wave, mean, amplitude, period_s, phase }, _) => {
                mean + amplitude * wave.at(t / period_s + phase)
            }
            (Signal::Steps(steps), state) => {
                let State::Next(next) = state else { return 0.0 };
                while reached(steps, *next, t) {
                    *next += 1;
                }
                steps[*next - 1].1
            }
            (Signal::Line { start, slope_per_s, from_s }, _) => {
                start + slope_per_s * (t - from_s).max(0.0)
            }
            (Signal::Staircase { start, step, dwell_s, steps }, _) => {
                let count = f64::from(*steps);
                let stair = (t / dwell_s * (1.0 + 1e-12)).floor() % (2.0 * count);
                start + step * (count - (count - stair).abs())
            }
            (Signal::Samples(samples), _) => {
                samples.get(k).or(samples.last()).copied().unwrap_or(0.0)
            }
        }
    }
}
