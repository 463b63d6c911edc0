//! A valve driven by a signal, without a loop around it.

use super::{Signal, cycle};
use crate::error::{Result, finite};
use crate::valve::{Assembly, Start, Valve};

/// A valve on a test signal.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenLoop {
    /// The valve.
    pub valve: Assembly,
    /// Controller output, percent of span.
    pub input: Signal,
    /// Initial position of the valve at rest, percent of span; by default the first value of the input.
    pub start: Option<f64>,
    /// Time between samples, s.
    pub sample_time: f64,
    /// Number of samples.
    pub samples: usize,
}

/// The result of an [`OpenLoop`], sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenLoopRun {
    /// Time between samples, s.
    pub sample_time: f64,
    /// Controller output, percent.
    pub op: Vec<f64>,
    /// Valve position, percent.
    pub vp: Vec<f64>,
}

impl OpenLoop {
    /// Drives the valve with the signal.
    ///
    /// # Errors
    /// If a setting is out of range. The message names the setting.
    pub fn run(&self) -> Result<OpenLoopRun> {
        let op = self.input.sample(self.sample_time, self.samples)?;
        let start = match self.start {
            Some(start) => finite("start position", start)?,
            None => op.first().copied().unwrap_or(0.0),
        };
        let mut valve = self.valve.clone();
        valve.restart(Start::at_rest(start));
        let mut vp = vec![0.0; op.len()];
        valve.run(&op, &mut vp)?;
        Ok(OpenLoopRun { sample_time: self.sample_time, op, vp })
    }
}

impl OpenLoopRun {
    /// Period of the valve position over the last half of the run, s: the mean time between its
    /// upward crossings of the middle of its range. `None` if there are fewer than three.
    pub fn period_s(&self) -> Option<f64> {
        cycle::period(&self.vp[self.vp.len() / 2..], self.sample_time, 0.0).ok().flatten()
    }

    /// Half the peak-to-peak value of `signal`, a signal of this run, over the last half of the run.
    pub fn half_pp(&self, signal: &[f64]) -> f64 {
        cycle::half_pp_of_last_half(signal)
    }
}
