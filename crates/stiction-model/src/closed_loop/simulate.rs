//! Simulation of a loop, and its result.

use super::bank::{Recorder, Sample, play_one, play_one_between};
use super::between::Between;
use super::cycle;
use super::description::ClosedLoop;
use super::manual::ByHand;
use crate::error::Result;

impl ClosedLoop {
    /// Simulates the loop and keeps every sample.
    ///
    /// # Errors
    /// If a setting is out of range. The message names the setting.
    pub fn run(&self) -> Result<Run> {
        if self.manual.is_empty() {
            return Ok(play_one(&self.prepare()?, self.empty_run()));
        }
        self.check_manual()?;
        let mut by_hand = ByHand::new(self)?;
        let run = play_one_between(&self.prepare_automatic()?, &mut by_hand, self.empty_run());
        Ok(Run { op: by_hand.op, ..run })
    }

    /// Simulates the loop with an element between its controller and its valve. [`Run::op`] is then the controller
    /// output, not the signal for the valve.
    pub(crate) fn run_between(&self, between: &mut dyn Between) -> Result<Run> {
        Ok(play_one_between(&self.prepare()?, between, self.empty_run()))
    }

    /// A run with storage for all samples.
    pub(super) fn empty_run(&self) -> Run {
        let column = || Vec::with_capacity(self.samples);
        Run {
            sample_time: self.sample_time,
            noise_band: self.noise_band(),
            sp: column(),
            pv: column(),
            op: column(),
            vp: column(),
        }
    }
}

/// The result of a simulated loop, sample by sample; sample `k` is at time `k sample_time`.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Time between samples, s.
    pub sample_time: f64,
    /// Noise amplitude of the PV, including quantisation, in its units.
    pub noise_band: f64,
    /// Set point.
    pub sp: Vec<f64>,
    /// Measured process value.
    pub pv: Vec<f64>,
    /// Controller output, percent; in manual the OP that the valve receives.
    pub op: Vec<f64>,
    /// Valve position, percent.
    pub vp: Vec<f64>,
}

impl Recorder<1> for Run {
    fn take(&mut self, _: usize, samples: &[Sample<1>]) {
        self.sp.extend(samples.iter().map(|s| s.sp[0]));
        self.pv.extend(samples.iter().map(|s| s.pv[0]));
        self.op.extend(samples.iter().map(|s| s.op[0]));
        self.vp.extend(samples.iter().map(|s| s.vp[0]));
    }
}

impl Run {
    /// Index at which the last half begins.
    fn half(&self) -> usize {
        self.pv.len() / 2
    }

    /// Period of the PV over the last half of the run, s: the mean time between its upward
    /// crossings of the middle of its range. `None` if there are fewer than three.
    pub fn period_s(&self) -> Option<f64> {
        cycle::period(&self.pv[self.half()..], self.sample_time, self.noise_band).ok().flatten()
    }

    /// Half the peak-to-peak value of `signal` (one of this run's) over the last half of the run;
    /// NaN if the loop overflowed.
    pub fn half_pp(&self, signal: &[f64]) -> f64 {
        cycle::half_pp_of_last_half(signal)
    }

    /// Ratio of the peak-to-peak value of the PV in the last quarter of the run to its value in the quarter before: 1
    /// for a sustained cycle, less for a decaying one. `None` if the PV does not move.
    pub fn growth(&self) -> Option<f64> {
        let n = self.pv.len();
        let width = |from: usize, to: usize| {
            let (low, high) = cycle::range(&self.pv[from..to]);
            high - low
        };
        let before = width(n / 2, n / 2 + n / 4);
        (before > 0.0).then(|| width(n - n / 4, n) / before)
    }
}
