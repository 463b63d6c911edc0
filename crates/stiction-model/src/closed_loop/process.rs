//! Linear processes with dead time, sampled exactly.

use crate::error::{Error, Result, all_finite, finite, non_negative, positive};
use crate::simd::Lane;
use nalgebra::DMatrix;

/// A linear process with dead time: valve position in, PV out.
///
/// `G(s) = num(s) / den(s) exp(-theta s)`, in PV units per percent of span.
#[derive(Debug, Clone, PartialEq)]
pub struct Process {
    dynamics: Dynamics,
    dead_time: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Dynamics {
    FirstOrder {
        gain: f64,
        tau: f64,
    },
    Integrator {
        gain: f64,
    },
    /// Coefficients, highest power of `s` first; monic denominator, numerator padded to its length.
    TransferFunction {
        num: Vec<f64>,
        den: Vec<f64>,
    },
}

/// Treatment of a dead time that is not a whole number of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DeadTime {
    /// Sample it exactly: within a sample the process first still sees the older input.
    #[default]
    Exact,
    /// Round it to the nearest whole number of samples.
    Nearest,
}

impl Process {
    /// The highest order of a process. Above it a transfer function no longer determines its dynamics in floating
    /// point.
    pub const MAX_ORDER: usize = 8;

    /// First order plus dead time: `gain exp(-dead_time s) / (tau s + 1)`; times in s.
    ///
    /// # Errors
    /// If `gain` is not finite, `tau` not positive, or `dead_time` negative.
    pub fn first_order(gain: f64, tau: f64, dead_time: f64) -> Result<Self> {
        let gain = finite("process gain", gain)?;
        let tau = positive("process time constant", tau)?;
        Self::with_dead_time(Dynamics::FirstOrder { gain, tau }, dead_time)
    }

    /// Second order plus dead time: `gain exp(-dead_time s) / ((tau1 s + 1)(tau2 s + 1))`.
    ///
    /// # Errors
    /// If `gain` is not finite, a time constant not positive, or `dead_time` negative.
    pub fn second_order(gain: f64, tau1: f64, tau2: f64, dead_time: f64) -> Result<Self> {
        finite("process gain", gain)?;
        positive("process time constant", tau1)?;
        positive("second process time constant", tau2)?;
        Self::transfer_function(&[gain], &[tau1 * tau2, tau1 + tau2, 1.0], dead_time)
    }

    /// Integrator plus dead time: `gain exp(-dead_time s) / s`; gain in PV units per percent and
    /// second.
    ///
    /// # Errors
    /// If `gain` is not finite or `dead_time` negative.
    pub fn integrator(gain: f64, dead_time: f64) -> Result<Self> {
        let gain = finite("process gain", gain)?;
        Self::with_dead_time(Dynamics::Integrator { gain }, dead_time)
    }

    /// Any proper transfer function with dead time; coefficients with the highest power first.
    ///
    /// # Errors
    /// If a coefficient is not finite, a polynomial is empty, the denominator starts with zero or
    /// is of higher degree than [`Process::MAX_ORDER`], the numerator is of higher degree than the
    /// denominator, or `dead_time` is negative.
    pub fn transfer_function(num: &[f64], den: &[f64], dead_time: f64) -> Result<Self> {
        all_finite("process numerator", num)?;
        all_finite("process denominator", den)?;
        let leading = den.first().copied().unwrap_or(0.0);
        if leading == 0.0 {
            return Err(Error::Inconsistent(
                "the process denominator needs a leading coefficient other than 0".to_owned(),
            ));
        }
        if den.len() > Self::MAX_ORDER + 1 {
            return Err(Error::Inconsistent(format!(
                "the process is of order {}, but at most {} can be simulated",
                den.len() - 1,
                Self::MAX_ORDER
            )));
        }
        if num.is_empty() || num.len() > den.len() {
            return Err(Error::Inconsistent(format!(
                "the process numerator has {} coefficients, but must have between 1 and {}, as \
                 many as the denominator: the process must be proper",
                num.len(),
                den.len()
            )));
        }
        let missing = den.len() - num.len();
        let num = std::iter::repeat_n(&0.0, missing).chain(num).map(|c| c / leading).collect();
        let den = den.iter().map(|c| c / leading).collect();
        Self::with_dead_time(Dynamics::TransferFunction { num, den }, dead_time)
    }

    fn with_dead_time(dynamics: Dynamics, dead_time: f64) -> Result<Self> {
        Ok(Self { dynamics, dead_time: non_negative("process dead time", dead_time)? })
    }

    /// The process with additional dead time, s. Values of 0 or below add none.
    #[must_use]
    pub fn delayed(mut self, by: f64) -> Self {
        self.dead_time += by.max(0.0);
        self
    }

    /// Dead time, s.
    pub fn dead_time(&self) -> f64 {
        self.dead_time
    }

    /// Coefficients of numerator and denominator, highest power first, without the dead time.
    pub fn coefficients(&self) -> (Vec<f64>, Vec<f64>) {
        match &self.dynamics {
            Dynamics::FirstOrder { gain, tau } => (vec![*gain], vec![*tau, 1.0]),
            Dynamics::Integrator { gain } => (vec![*gain], vec![1.0, 0.0]),
            Dynamics::TransferFunction { num, den } => (num.clone(), den.clone()),
        }
    }

    /// The response to a unit step, `time_s` seconds after the step; PV units per percent.
    ///
    /// # Errors
    /// If `time_s` is not finite.
    pub fn step_response(&self, time_s: f64) -> Result<f64> {
        let since = finite("time after the step", time_s)? - self.dead_time;
        if since < 0.0 {
            return Ok(0.0);
        }
        Ok(self.flow(since).1.first().copied().unwrap_or(0.0) + self.through())
    }

    /// The process sampled every `sample_time` seconds, its input held over each sample.
    ///
    /// Exact for any `sample_time`: the matrix exponential of the process over the sample. With a dead time of `(n +
    /// phi) Ts`, the process receives `v(k-n-1)` for the first `phi Ts` of a sample and `v(k-n)` for the rest.
    ///
    /// # Errors
    /// If `sample_time` is not positive, the dead time exceeds 10 million samples, or the process
    /// is too unstable to be represented at this sample time.
    pub fn sampled(&self, sample_time: f64, dead_time: DeadTime) -> Result<SampledProcess> {
        positive("sample time", sample_time)?;
        let samples = self.dead_time / sample_time;
        if !(samples <= 1e7) {
            return Err(Error::Inconsistent(format!(
                "a dead time of {} s is more than 10 million samples of {sample_time} s",
                self.dead_time
            )));
        }
        let nearest = samples.round();
        // A quotient such as 1.07 / 0.01 is a whole number except for rounding.
        let whole = dead_time == DeadTime::Nearest || (samples - nearest).abs() < 1e-9;
        let delay = if whole { nearest } else { samples.floor() };
        let (a, newer, older) = if whole {
            let (a, held) = self.flow(sample_time);
            let none = vec![0.0; held.len()];
            (a, held, none)
        } else {
            let early = (samples - delay) * sample_time;
            let (late_a, newer) = self.flow(sample_time - early);
            let (_, held) = self.flow(early);
            let older = late_a.iter().map(|row| row.iter().zip(&held).map(|(a, b)| a * b).sum());
            let older = older.collect();
            (self.flow(sample_time).0, newer, older)
        };
        if !a.iter().flatten().chain(&newer).chain(&older).all(|c| c.is_finite()) {
            return Err(Error::Inconsistent(format!(
                "the process cannot be sampled every {sample_time} s: it overflows"
            )));
        }
        let through = self.through();
        Ok(SampledProcess { a, newer, older, through, delay: delay as usize })
    }

    /// Direct feedthrough from input to output, apart from the dead time.
    fn through(&self) -> f64 {
        match &self.dynamics {
            Dynamics::TransferFunction { num, .. } => num[0],
            _ => 0.0,
        }
    }

    /// Rows of the state transition over `duration`, and the response to a unit input held as long, both in the
    /// observable form: the output is the first state.
    fn flow(&self, duration: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
        match &self.dynamics {
            Dynamics::FirstOrder { gain, tau } => {
                let decay = (-duration / tau).exp();
                (vec![vec![decay]], vec![gain * (1.0 - decay)])
            }
            Dynamics::Integrator { gain } => (vec![vec![1.0]], vec![gain * duration]),
            Dynamics::TransferFunction { num, den } => {
                // exp([A B; 0 0] t) holds exp(A t), and beside it the integral of exp(A s) B.
                let n = den.len() - 1;
                let mut generator = DMatrix::zeros(n + 1, n + 1);
                for i in 0..n {
                    generator[(i, 0)] = -den[i + 1] * duration;
                    generator[(i, n)] = (num[i + 1] - num[0] * den[i + 1]) * duration;
                    if i + 1 < n {
                        generator[(i, i + 1)] = duration;
                    }
                }
                let flow = generator.exp();
                let row = |i: usize| (0..n).map(|j| flow[(i, j)]).collect();
                ((0..n).map(row).collect(), (0..n).map(|i| flow[(i, n)]).collect())
            }
        }
    }
}

/// A process in discrete time:
/// `z(k+1) = A z(k) + newer v(k-n) + older v(k-n-1)`, `y(k) = z_1(k) + through v(k-n-1)`.
///
/// The output is that just before the sample's own input acts, so a loop around it is never
/// algebraic.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledProcess {
    /// Rows of `A`.
    a: Vec<Vec<f64>>,
    newer: Vec<f64>,
    older: Vec<f64>,
    through: f64,
    /// `n`, samples.
    delay: usize,
}

impl SampledProcess {
    /// Number of states.
    pub fn order(&self) -> usize {
        self.newer.len()
    }

    /// Whole samples of dead time.
    pub fn delay(&self) -> usize {
        self.delay
    }

    /// Response to an input, sample by sample, from rest at zero on.
    pub fn answer(&self, input: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut process = ProcessBank::<1, { Process::MAX_ORDER }>::new([self]);
        let mut late = DelayLine::new([self.delay]);
        input
            .into_iter()
            .map(|v| {
                let output = process.output(0);
                process.advance(late.push::<true>(Lane([v])));
                output
            })
            .collect()
    }
}

/// `N` sampled processes of at most `M` states side by side.
#[derive(Debug, Clone)]
pub struct ProcessBank<const N: usize, const M: usize> {
    a: [[Lane<N>; M]; M],
    newer: [Lane<N>; M],
    older: [Lane<N>; M],
    through: Lane<N>,
    state: [Lane<N>; M],
    /// The delayed inputs of the last sample, `v(k-n-1)`.
    input: Lane<N>,
}

impl<const N: usize, const M: usize> ProcessBank<N, M> {
    /// Processes at rest at zero. Missing states stay zero.
    pub fn new(processes: [&SampledProcess; N]) -> Self {
        use std::array::from_fn;
        let entry = |column: &[f64], i: usize| column.get(i).copied().unwrap_or(0.0);
        Self {
            a: from_fn(|i| {
                from_fn(|j| {
                    Lane::from_fn(|l| processes[l].a.get(i).map_or(0.0, |row| entry(row, j)))
                })
            }),
            newer: from_fn(|i| Lane::from_fn(|l| entry(&processes[l].newer, i))),
            older: from_fn(|i| Lane::from_fn(|l| entry(&processes[l].older, i))),
            through: Lane(processes.map(|p| p.through)),
            state: [Lane::splat(0.0); M],
            input: Lane::splat(0.0),
        }
    }

    /// The present output in lane `l`.
    #[inline(always)]
    pub fn output(&self, l: usize) -> f64 {
        self.state[0][l] + self.through[l] * self.input[l]
    }

    /// The part that changes from sample to sample.
    pub(super) fn states(&self) -> impl Iterator<Item = &Lane<N>> {
        self.state.iter().chain([&self.input])
    }

    pub(super) fn states_mut(&mut self) -> impl Iterator<Item = &mut Lane<N>> {
        self.state.iter_mut().chain([&mut self.input])
    }

    /// Advances by one sample with the delayed inputs `v(k-n)`.
    #[inline(always)]
    pub fn advance(&mut self, input: Lane<N>) {
        for l in 0..N {
            let mut state = [0.0; M];
            for j in 0..M {
                state[j] = self.state[j][l];
            }
            for i in 0..M {
                let mut sum = self.a[i][0][l] * state[0];
                for j in 1..M {
                    sum += self.a[i][j][l] * state[j];
                }
                let held = self.newer[i][l] * input[l] + self.older[i][l] * self.input[l];
                self.state[i][l] = sum + held;
            }
            self.input[l] = input[l];
        }
    }
}

/// The last inputs of `N` processes, each delayed by its own number of samples.
#[derive(Debug, Clone)]
pub struct DelayLine<const N: usize> {
    /// A ring; its length is a power of two.
    ring: Vec<Lane<N>>,
    delay: [usize; N],
    head: usize,
}

impl<const N: usize> DelayLine<N> {
    /// A delay of this many samples in each lane.
    pub fn new(delay: [usize; N]) -> Self {
        let longest = delay.iter().copied().max().unwrap_or(0);
        let ring = vec![Lane::splat(0.0); (longest + 1).next_power_of_two()];
        Self { ring, delay, head: 0 }
    }

    /// Whether the delay is the same in all lanes.
    pub fn is_common(&self) -> bool {
        self.delay.iter().all(|delay| *delay == self.delay[0])
    }

    /// The last inputs, the newest first.
    pub(super) fn newest_first(&self) -> impl Iterator<Item = &Lane<N>> {
        let mask = self.ring.len() - 1;
        (1..=self.ring.len()).map(move |age| &self.ring[self.head.wrapping_sub(age) & mask])
    }

    /// Replaces the inputs, the newest first.
    pub(super) fn refill(&mut self, mut input: impl FnMut() -> Lane<N>) {
        self.head = 0;
        self.ring.iter_mut().rev().for_each(|v| *v = input());
    }

    /// Takes `v(k)`, gives `v(k-n)`. `COMMON` claims that the delay is the same in all lanes.
    #[inline(always)]
    pub fn push<const COMMON: bool>(&mut self, v: Lane<N>) -> Lane<N> {
        let mask = self.ring.len() - 1;
        let head = self.head;
        self.head = head.wrapping_add(1);
        // The arrays alone: a single lane would copy its padding, too.
        self.ring[head & mask].0 = v.0;
        let row = |delay: usize| head.wrapping_sub(delay) & mask;
        if COMMON {
            Lane(self.ring[row(self.delay[0])].0)
        } else {
            Lane::from_fn(|l| self.ring[row(self.delay[l])][l])
        }
    }
}
