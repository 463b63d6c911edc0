//! First order plus dead time, from OP and PV in closed loop.
//!
//! # What it measures
//! Gain, time constant and dead time of the process between an input (OP or valve position) and PV, with standard
//! errors; for an integrating process, gain and dead time.
//!
//! # Assumptions
//! A linear process, with its input held between samples. The dead time is at least the one sample of a sampled
//! controller. Otherwise the fit could find the inverse of the controller. Something besides the PV's own noise moves
//! the loop: a set point, a sticking valve, or a slow or small disturbance.
//!
//! # Equations
//! ```text
//! z(k) = a z(k-1) + (1 - a) x(k-1),  a = exp(-Ts/tau)          self-regulating
//! z(k) = z(k-1) + Ts x(k-1)                                    integrating
//! y(k) = c + K z(k-d) + w a^k + e(k)     (integrating: w k, which balances the mean of x)
//! ```
//! with `x` less its mean. The fit minimises the output error `e`: c, K and w by least squares for each `d` and tau,
//! tau over a geometric grid and then by golden sections, d over all delays up to the longest. `dead time = d Ts - Ts`,
//! because `z` already contains the hold. Standard errors come from the model linearised in K, ln tau and d, with the
//! residual's variance multiplied by `(1 + r)/(1 - r)` with its correlation r at lag 1.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `longest_delay` | samples | 40 | ours |
//! | `process` | | self-regulating | ours |
//!
//! # Limits
//! In closed loop, output errors that the PV's past could predict enter the input and bias the fit towards the inverse
//! of the controller, especially if the PV is noisy. The dead time has a resolution of one sample. A time constant far
//! beyond the recording looks like an integrator. A time constant below a third of a sample cannot be distinguished
//! from zero.
//!
//! # Deviations from the paper
//! The model is common; the fit is ours.
//!
//! # References
//! L. Ljung, System Identification: Theory for the User, 2nd ed., Prentice Hall (1999), for output error
//! and variances (recalled, not read).

use crate::error::positive;
use crate::finding::Abstention;
use crate::numeric::golden::golden;
use crate::numeric::least_squares::{dot, least_squares};
use crate::series::{autocorrelation, centred, std};
use nalgebra::Matrix3;

/// Smallest number of samples for a fit.
pub const FEWEST_SAMPLES: usize = 40;
/// Time constants of the grid, and their range, samples.
const GRID: usize = 14;
const SHORTEST: f64 = 0.3;
/// Smallest share of the variance that a valid fit explains.
const LEAST_SHARE: f64 = 0.05;

/// The behaviour of the process under a constant input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ProcessKind {
    /// It settles.
    #[default]
    SelfRegulating,
    /// It continues at a constant rate.
    Integrating,
}

impl ProcessKind {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::SelfRegulating => "self-regulating",
            Self::Integrating => "integrating",
        }
    }
}

/// Settings of the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FopdtOptions {
    /// The behaviour of the process.
    pub kind: ProcessKind,
    /// The longest delay to try, samples.
    pub longest_delay: usize,
}

impl Default for FopdtOptions {
    fn default() -> Self {
        Self { kind: ProcessKind::SelfRegulating, longest_delay: 40 }
    }
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// A process of first order with dead time.
#[derive(Debug, Clone, PartialEq)]
pub struct Fopdt {
    /// Units of PV per percent of the input; for an integrating process, per percent and second.
    pub gain: Estimated,
    /// Time constant, s; `None` for an integrating process.
    pub time_constant_s: Option<Estimated>,
    /// Dead time, s.
    pub dead_time_s: Estimated,
    /// Samples from input to PV, at least 1.
    pub delay: usize,
    /// Share of the variance of PV that is explained.
    pub fit: f64,
    /// The PV of the model, in its units.
    pub pv: Vec<f64>,
}

/// Fits the process between `op` and `pv`, sampled every `sample_time` seconds.
///
/// # Errors
/// If the series are shorter than [`FEWEST_SAMPLES`] or three times the longest delay, a sample is not finite, a series
/// is constant, or the process is not identifiable. It is not identifiable if the fit explains nothing, or its errors
/// exceed the values.
pub fn fit(
    op: &[f64],
    pv: &[f64],
    sample_time: f64,
    options: &FopdtOptions,
) -> Result<Fopdt, Abstention> {
    let n = op.len();
    let longest = options.longest_delay.max(1);
    if n != pv.len() || n < FEWEST_SAMPLES.max(longest.saturating_mul(3)) {
        return Err(Abstention(format!(
            "a process fit needs at least {} samples of both OP and PV; there are {n} and {}",
            FEWEST_SAMPLES.max(longest.saturating_mul(3)),
            pv.len()
        )));
    }
    let ts = positive("sample time", sample_time).map_err(|e| Abstention(e.to_string()))?;
    if op.iter().chain(pv).any(|v| !v.is_finite()) {
        return Err(Abstention("a sample is not finite".to_owned()));
    }
    let (scale_x, scale_y) = (std(op), std(pv));
    let sound = |v: f64| v > 0.0 && v.is_finite();
    if !(sound(scale_x) && sound(scale_y)) {
        return Err(Abstention("not identifiable: the OP or the PV does not move".to_owned()));
    }
    let scaled = |x: &[f64], by: f64| -> Vec<f64> { centred(x).iter().map(|v| v / by).collect() };
    let (x, y) = (scaled(op, scale_x), scaled(pv, scale_y));
    let data = Data { x: &x, y: &y, kind: options.kind, longest };
    let (delay, ln_tau) = data.search().ok_or_else(|| {
        Abstention("not identifiable: no delay and time constant explain the PV".to_owned())
    })?;
    let unexplained = || Abstention("not identifiable: the OP hardly affects the PV".to_owned());
    let best = data.fit(delay, ln_tau).ok_or_else(unexplained)?;
    let total = dot(&y[longest..], &y[longest..]);
    let share = 1.0 - best.sse / total;
    if !(share > LEAST_SHARE) {
        return Err(unexplained());
    }
    let errors = data.errors(delay, ln_tau, &best).ok_or_else(unexplained)?;
    let gain = best.coefficients[1];
    if !(errors[0] < gain.abs()) {
        return Err(unexplained());
    }
    let tau = ln_tau.exp() * ts;
    let unit = match options.kind {
        ProcessKind::SelfRegulating => scale_y / scale_x,
        ProcessKind::Integrating => scale_y / scale_x / ts,
    };
    let level = pv.iter().sum::<f64>() / n as f64;
    let modelled = data.columns(delay, ln_tau);
    let pv = (0..n).map(|k| {
        let of = modelled.iter().zip(&best.coefficients).map(|(column, c)| column[k] * c);
        level + scale_y * of.sum::<f64>()
    });
    Ok(Fopdt {
        gain: Estimated { value: gain * unit, error: errors[0] * unit.abs() },
        time_constant_s: (options.kind == ProcessKind::SelfRegulating)
            .then_some(Estimated { value: tau, error: errors[1] * tau }),
        dead_time_s: Estimated { value: (delay - 1) as f64 * ts, error: errors[2] * ts },
        delay,
        fit: share,
        pv: pv.collect(),
    })
}

/// Input and output, both of mean 0 and variance 1.
struct Data<'a> {
    x: &'a [f64],
    y: &'a [f64],
    kind: ProcessKind,
    longest: usize,
}

struct Fit {
    /// For constant, response and initial state.
    coefficients: Vec<f64>,
    residual: Vec<f64>,
    sse: f64,
}

impl Data<'_> {
    fn decay(&self, ln_tau: f64) -> f64 {
        match self.kind {
            ProcessKind::SelfRegulating => (-(-ln_tau).exp()).exp(),
            ProcessKind::Integrating => 1.0,
        }
    }

    /// Constant, response after `delay` samples, and the rest of the initial state.
    fn columns(&self, delay: usize, ln_tau: f64) -> [Vec<f64>; 3] {
        let n = self.x.len();
        let a = self.decay(ln_tau);
        let take = if self.kind == ProcessKind::Integrating { 1.0 } else { 1.0 - a };
        let mut z = 0.0;
        let mut response = vec![0.0; n];
        for k in delay..n {
            z = a * z + take * self.x[k - delay];
            response[k] = z;
        }
        let mut left = 1.0;
        let beginning = (0..n)
            .map(|k| match self.kind {
                ProcessKind::SelfRegulating => {
                    left *= a;
                    left
                }
                ProcessKind::Integrating => k as f64 / n as f64,
            })
            .collect();
        [vec![1.0; n], response, beginning]
    }

    /// Counted from the longest delay on, so that delays are comparable.
    fn fit(&self, delay: usize, ln_tau: f64) -> Option<Fit> {
        let columns = self.columns(delay, ln_tau);
        let seen = [0, 1, 2].map(|i| &columns[i][self.longest..]);
        let found = least_squares(&seen, &self.y[self.longest..])?;
        Some(Fit { coefficients: found.coefficients, residual: found.residual, sse: found.sse })
    }

    fn left(&self, delay: usize, ln_tau: f64) -> f64 {
        self.fit(delay, ln_tau).map_or(f64::INFINITY, |fit| fit.sse)
    }

    /// Delay and logarithm of the time constant in samples with the smallest error.
    fn search(&self) -> Option<(usize, f64)> {
        if self.kind == ProcessKind::Integrating {
            let delays = (1..=self.longest).map(|d| (self.left(d, 0.0), d, 0.0));
            return delays
                .filter(|t| t.0.is_finite())
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|t| (t.1, t.2));
        }
        let (low, high) = (SHORTEST.ln(), (0.5 * self.x.len() as f64).ln());
        let step = (high - low) / (GRID - 1) as f64;
        let at_delay = |d: usize| {
            let grid = (0..GRID).map(|i| low + step * i as f64);
            let tried = grid.map(|ln_tau| (self.left(d, ln_tau), d, ln_tau));
            tried.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let mut found: Vec<_> = (1..=self.longest).filter_map(at_delay).collect();
        found.retain(|t| t.0.is_finite());
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let refined = found.iter().take(5).map(|&(_, d, ln_tau)| {
            let ln_tau = golden(|t| self.left(d, t), ln_tau - step, ln_tau + step);
            (self.left(d, ln_tau), d, ln_tau)
        });
        refined.min_by(|a, b| a.0.total_cmp(&b.0)).map(|t| (t.1, t.2))
    }

    /// Standard errors of gain, logarithm of the time constant, and delay.
    fn errors(&self, delay: usize, ln_tau: f64, best: &Fit) -> Option<[f64; 3]> {
        let gain = best.coefficients[1];
        let of = |delay: usize, ln_tau: f64| {
            let [_, mut response, beginning] = self.columns(delay, ln_tau);
            for (r, b) in response.iter_mut().zip(beginning) {
                *r = gain * *r + best.coefficients[2] * b;
            }
            response.split_off(self.longest)
        };
        let slope = |a: Vec<f64>, b: Vec<f64>, step: f64| -> Vec<f64> {
            centred(&a.iter().zip(b).map(|(a, b)| (a - b) / step).collect::<Vec<_>>())
        };
        let by_gain: Vec<f64> = centred(&self.columns(delay, ln_tau)[1][self.longest..]);
        let by_tau = match self.kind {
            ProcessKind::SelfRegulating => {
                slope(of(delay, ln_tau + 0.01), of(delay, ln_tau - 0.01), 0.02)
            }
            ProcessKind::Integrating => vec![],
        };
        let before = (delay - 1).max(1);
        let by_delay =
            slope(of(delay + 1, ln_tau), of(before, ln_tau), (delay + 1 - before) as f64);
        let columns = [&by_gain, &by_tau, &by_delay];
        let mut information = Matrix3::identity();
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                if !a.is_empty() && !b.is_empty() {
                    information[(i, j)] = dot(a, b);
                }
            }
        }
        let inverse = information.try_inverse()?;
        let m = best.residual.len();
        let r = autocorrelation(&best.residual, 1).map_or(0.0, |r| r[1]).clamp(0.0, 0.99);
        let variance = best.sse / (m - 6) as f64 * (1.0 + r) / (1.0 - r);
        let errors = [0, 1, 2].map(|i| (inverse[(i, i)] * variance).sqrt());
        errors.iter().all(|e| e.is_finite()).then_some(errors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bands;
    use crate::closed_loop::{ClosedLoop, Controller, Process, Run, Signal};
    use crate::valve::{Assembly, Model};

    fn sticky_loop(process: Process, controller: Controller, noise: f64) -> Run {
        let valve = Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0).unwrap()).unwrap();
        let mut plant = ClosedLoop::new(controller, Assembly::new(valve), process);
        plant.set_point = 5.0.into();
        (plant.sample_time, plant.samples) = (0.2, 1500);
        plant.measurement = vec![Signal::Noise { sd: noise, tau_s: 0.0, seed: 3 }];
        plant.run().unwrap()
    }

    #[test]
    fn the_process_behind_a_known_position_is_recovered() {
        for noise in [0.0, 0.1] {
            let run = sticky_loop(
                Process::first_order(1.5, 5.93, 1.0).unwrap(),
                Controller::pi(1.1, 2.5).unwrap(),
                noise,
            );
            let found = fit(&run.vp, &run.pv, 0.2, &FopdtOptions::default()).unwrap();
            let tau = found.time_constant_s.unwrap();
            assert!((found.gain.value - 1.5).abs() < 0.03, "{:?}", found.gain);
            assert!((tau.value - 5.93).abs() < 0.3, "{tau:?}");
            assert!((found.dead_time_s.value - 1.0).abs() < 0.21, "{:?}", found.dead_time_s);
            assert!(found.fit > 0.98 && tau.error < 0.2 && found.gain.error < 0.05);
        }
    }

    #[test]
    fn one_that_integrates_too() {
        let run = sticky_loop(
            Process::integrator(0.5, 0.6).unwrap(),
            Controller::pi(0.4, 8.0).unwrap(),
            0.05,
        );
        let options = FopdtOptions { kind: ProcessKind::Integrating, ..FopdtOptions::default() };
        let found = fit(&run.vp, &run.pv, 0.2, &options).unwrap();
        assert!((found.gain.value - 0.5).abs() < 0.02, "{:?}", found.gain);
        assert!((found.dead_time_s.value - 0.6).abs() < 0.21, "{:?}", found.dead_time_s);
        assert!(found.time_constant_s.is_none() && found.fit > 0.95);
    }

    #[test]
    fn units_only_scale() {
        let run = sticky_loop(
            Process::first_order(1.5, 5.93, 1.0).unwrap(),
            Controller::pi(1.1, 2.5).unwrap(),
            0.1,
        );
        let found = fit(&run.vp, &run.pv, 0.2, &FopdtOptions::default()).unwrap();
        let kelvin: Vec<f64> = run.pv.iter().map(|v| 273.0 - 4.0 * v).collect();
        let other = fit(&run.vp, &kelvin, 0.2, &FopdtOptions::default()).unwrap();
        assert!((other.gain.value / found.gain.value + 4.0).abs() < 1e-6);
        assert_eq!(other.delay, found.delay);
    }

    #[test]
    fn without_excitation_there_is_nothing_to_find() {
        let wave: Vec<f64> = (0..500).map(|k| (0.1 * f64::from(k)).sin()).collect();
        assert!(fit(&[50.0; 500], &wave, 1.0, &FopdtOptions::default()).is_err());
        assert!(fit(&wave, &[1.0; 500], 1.0, &FopdtOptions::default()).is_err());
        assert!(fit(&wave, &wave[..499], 1.0, &FopdtOptions::default()).is_err());
        assert!(fit(&wave, &wave, 0.0, &FopdtOptions::default()).is_err());
        let mut noise = crate::closed_loop::NormalStream::new(1);
        let mut other = crate::closed_loop::NormalStream::new(2);
        let a: Vec<f64> = (0..500).map(|_| noise.draw()).collect();
        let b: Vec<f64> = (0..500).map(|_| other.draw()).collect();
        assert!(fit(&a, &b, 1.0, &FopdtOptions::default()).is_err());
    }
}
