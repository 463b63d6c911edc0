//! The known valve and loop, and the quantities derived from them for every method.

use crate::bands::Bands;
use crate::closed_loop::{Controller, Process};
use crate::error::{Result, non_negative, positive};

/// The known valve and loop for the choice of a compensator. It may be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Knowledge {
    /// Estimate of S, percent of span.
    pub s: f64,
    /// Estimate of J, percent of span; `None` without an estimate. Then J = S / 2 is used, the middle of its range
    /// without overshoot.
    pub j: Option<f64>,
    /// The controller.
    pub controller: Controller,
    /// The process, if it is known.
    pub process: Option<Process>,
    /// Time between samples, s.
    pub sample_time: f64,
    /// Standard deviation of the noise on the PV, in its units.
    pub noise_sd: f64,
}

impl Knowledge {
    /// S and J, a controller and its sample time, without a process and without noise.
    pub fn new(s: f64, j: Option<f64>, controller: Controller, sample_time: f64) -> Self {
        Self { s, j, controller, process: None, sample_time, noise_sd: 0.0 }
    }
}

/// The quantities in the rules of all methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// S and J.
    pub bands: Bands,
    /// Time between samples, s.
    pub sample_time: f64,
    /// Standard deviation of the noise, PV units.
    pub noise_sd: f64,
    /// Dead time, s.
    pub dead_time_s: f64,
    /// Time constant: the mean residence time of a self-regulating process without its dead time. Otherwise the
    /// integral time of the controller, which is tuned to the process.
    pub lag_s: f64,
    /// Dead time plus three time constants, which is 95 % of a first-order response. If the process never settles, it
    /// is dead time plus one time constant, because an error only grows.
    pub settle_s: f64,
    /// Response of the process to a unit step after `settle_s`; PV units per percent.
    pub gain: f64,
    /// Share of a deviation that remains after another `settle_s`.
    pub memory: f64,
}

impl Figures {
    /// Time constant of a controller without integral action, in sample times.
    const SAMPLES_WITHOUT_INTEGRAL: f64 = 50.0;

    /// From the known valve and loop.
    ///
    /// # Errors
    /// If a number of the valve or loop is invalid.
    pub fn of(known: &Knowledge) -> Result<Self> {
        let sample_time = positive("sample time", known.sample_time)?;
        let noise_sd = non_negative("standard deviation of the noise", known.noise_sd)?;
        let bands = Bands::from_s_j(known.s, known.j.unwrap_or(0.5 * known.s))?;
        let (kp, ki, _) = known.controller.gains();
        let reset_s = if ki != 0.0 && kp != 0.0 {
            (kp / ki).abs()
        } else {
            Self::SAMPLES_WITHOUT_INTEGRAL * sample_time
        };
        let dead_time_s = known.process.as_ref().map_or(0.0, Process::dead_time);
        let residence = known.process.as_ref().and_then(residence_s);
        let lag_s = residence.unwrap_or(reset_s).max(sample_time);
        let settles = known.process.is_none() || residence.is_some();
        let lags = if settles { 3.0 } else { 1.0 };
        let settle_s = (dead_time_s + lags * lag_s).max(10.0 * sample_time);
        // Unknown process: the gains of process and controller multiply to about 1 in a tuned loop.
        let tuned = if kp != 0.0 { 1.0 / kp } else { 1.0 };
        let (gain, memory) = match &known.process {
            Some(process) => {
                let gain = process.step_response(settle_s)?;
                let later = process.step_response(2.0 * settle_s)?;
                (gain, later / gain - 1.0)
            }
            None => (tuned, 0.0),
        };
        let usable = gain.is_finite() && gain != 0.0 && memory.is_finite();
        let (gain, memory) = if usable { (gain, memory.clamp(0.0, 1.0)) } else { (tuned, 0.0) };
        Ok(Self { bands, sample_time, noise_sd, dead_time_s, lag_s, settle_s, gain, memory })
    }

    /// Noise of the mean PV over a quarter of `settle_s`: three standard deviations.
    pub(super) fn noise_of_mean(&self) -> f64 {
        3.0 * self.noise_sd / (0.25 * self.settle_s / self.sample_time).sqrt().max(1.0)
    }
}

/// Mean residence time of a self-regulating process without its dead time, s: `d1/d0 - n1/n0` of
/// `(n1 s + n0) / (d1 s + d0)`.
fn residence_s(process: &Process) -> Option<f64> {
    let (num, den) = process.coefficients();
    let tail = |c: &[f64], i: usize| c.len().checked_sub(1 + i).map_or(0.0, |at| c[at]);
    let (n0, d0) = (tail(&num, 0), tail(&den, 0));
    let time = tail(&den, 1) / d0 - tail(&num, 1) / n0;
    (n0 != 0.0 && d0 != 0.0 && time > 0.0).then_some(time)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(process: Option<Process>) -> Figures {
        let controller = Controller::pi(1.1, 2.5).unwrap();
        Figures::of(&Knowledge { process, ..Knowledge::new(5.0, None, controller, 0.1) }).unwrap()
    }

    #[test]
    fn figures_of_known_processes() {
        let first = figures(Some(Process::first_order(1.5, 5.93, 1.07).unwrap()));
        assert!((first.lag_s - 5.93).abs() < 1e-12 && first.bands.j() == 2.5);
        assert!((first.gain - 1.5 * (1.0 - (-3f64).exp())).abs() < 1e-12);
        let second = figures(Some(Process::second_order(2.0, 3.0, 4.0, 0.0).unwrap()));
        assert!((second.lag_s - 7.0).abs() < 1e-12);
        let level = figures(Some(Process::integrator(0.2, 0.0).unwrap()));
        assert_eq!((level.lag_s, level.settle_s), (2.5, 2.5));
        assert!((level.gain - 0.5).abs() < 1e-12 && (level.memory - 1.0).abs() < 1e-12);
        let unknown = figures(None);
        assert_eq!((unknown.lag_s, unknown.gain), (2.5, 1.0 / 1.1));
    }
}
