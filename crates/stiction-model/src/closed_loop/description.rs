//! The description of a loop, before it runs.

use super::{Controller, DeadTime, Manual, Process, SampledProcess, Signal, SignalSource};
use crate::error::{Error, Result, finite, non_negative};
use crate::valve::Assembly;

/// A control loop with its signals. The structure contains only data. [`ClosedLoop::run`] simulates it.
///
/// ```
/// use stiction_model::closed_loop::{ClosedLoop, Controller, Process};
/// use stiction_model::{Bands, valve::{Assembly, Model}};
///
/// // The paper's loop under strong stiction, its set point stepping to 5 at the beginning.
/// let mut sticky = ClosedLoop::new(
///     Controller::pi(1.1, 2.5)?,
///     Assembly::new(Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0)?)?),
///     Process::first_order(1.5, 5.93, 1.07)?,
/// );
/// sticky.set_point = 5.0.into();
/// sticky.sample_time = 0.01;
/// sticky.samples = 60_000;
/// let run = sticky.run()?;
/// let period = run.period_s().unwrap();
/// assert!((period - 18.024).abs() < 1e-3);
/// # Ok::<(), stiction_model::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedLoop {
    /// The controller.
    pub controller: Controller,
    /// The valve; it starts at rest at [`ClosedLoop::op_rest`].
    pub valve: Assembly,
    /// The process, around its operating point.
    pub process: Process,
    /// Treatment of a dead time that is not a whole number of samples.
    pub dead_time: DeadTime,
    /// Time between samples, s.
    pub sample_time: f64,
    /// Number of samples.
    pub samples: usize,
    /// Controller output and valve position at the operating point, where the loop starts at rest;
    /// percent of span.
    pub op_rest: f64,
    /// PV at the operating point.
    pub pv_rest: f64,
    /// Set point, in PV units.
    pub set_point: Signal,
    /// Load disturbances: their sum adds to the valve position before the process, percent.
    pub load: Vec<Signal>,
    /// Measurement noise and output disturbances: their sum adds to the PV, in its units.
    pub measurement: Vec<Signal>,
    /// Resolution of the controller output, percent; 0 for none.
    pub op_quantum: f64,
    /// Resolution of the measured PV, in its units; 0 for none.
    pub pv_quantum: f64,
    /// Times in manual, in order. Only [`ClosedLoop::run`] simulates them.
    pub manual: Vec<Manual>,
}

impl From<f64> for Signal {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

/// Constant part and moving parts of a sum of signals.
pub(super) type Sources = (f64, Vec<SignalSource>);

/// A loop with its settings checked and its process sampled.
pub(super) struct Prepared<'a> {
    pub settings: &'a ClosedLoop,
    pub process: SampledProcess,
    pub sp: Sources,
    pub load: Sources,
    pub measurement: Sources,
    pub first_sp: f64,
}

impl ClosedLoop {
    /// A loop at rest at the origin, 6,000 samples of 0.1 s, without disturbances.
    pub fn new(controller: Controller, valve: Assembly, process: Process) -> Self {
        Self {
            controller,
            valve,
            process,
            dead_time: DeadTime::default(),
            sample_time: 0.1,
            samples: 6_000,
            op_rest: 0.0,
            pv_rest: 0.0,
            set_point: Signal::Constant(0.0),
            load: vec![],
            measurement: vec![],
            op_quantum: 0.0,
            pv_quantum: 0.0,
            manual: vec![],
        }
    }

    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// If not; the message names the setting.
    pub fn check(&self) -> Result<()> {
        self.check_manual()?;
        self.prepare_automatic().map(|_| ())
    }

    /// A loop that is always in automatic.
    pub(super) fn prepare(&self) -> Result<Prepared<'_>> {
        match self.manual.len() {
            0 => self.prepare_automatic(),
            spells => Err(Error::Parameter {
                name: "number of periods in manual",
                value: spells as f64,
                allowed: "0 here; only the simulation of a single loop has periods in manual"
                    .to_owned(),
            }),
        }
    }

    /// A loop, its spells in manual aside.
    pub(super) fn prepare_automatic(&self) -> Result<Prepared<'_>> {
        finite("operating point of the OP", self.op_rest)?;
        finite("operating point of the PV", self.pv_rest)?;
        non_negative("OP quantum", self.op_quantum)?;
        non_negative("PV quantum", self.pv_quantum)?;
        let sources = |signals: &[Signal]| -> Result<Sources> {
            let mut sum = (0.0, vec![]);
            for signal in signals {
                let source = signal.source(self.sample_time, self.samples)?;
                match signal {
                    Signal::Constant(value) => sum.0 += value,
                    _ => sum.1.push(source),
                }
            }
            Ok(sum)
        };
        let process = self.process.sampled(self.sample_time, self.dead_time)?;
        let sp = sources(std::slice::from_ref(&self.set_point))?;
        let first_sp = sp.0 + sp.1.first().map_or(0.0, |source| source.clone().draw());
        Ok(Prepared {
            settings: self,
            process,
            load: sources(&self.load)?,
            measurement: sources(&self.measurement)?,
            sp,
            first_sp,
        })
    }

    /// Standard deviation of the measurement noise of the PV, in its units.
    pub fn noise_sd(&self) -> f64 {
        let variance: f64 = self
            .measurement
            .iter()
            .map(|signal| if let Signal::Noise { sd, .. } = signal { sd * sd } else { 0.0 })
            .sum();
        variance.sqrt()
    }

    /// Noise amplitude of the PV: three standard deviations of the measurement noise, and half a PV quantum.
    pub(super) fn noise_band(&self) -> f64 {
        3.0 * self.noise_sd() + self.pv_quantum / 2.0
    }
}

/// The sum of `signals`, sample by sample.
pub(super) fn total(signals: &[Signal], sample_time: f64, n: usize) -> Result<Vec<f64>> {
    let mut sum = vec![0.0; n];
    for signal in signals {
        let samples = signal.sample(sample_time, n)?;
        sum.iter_mut().zip(samples).for_each(|(sum, value)| *sum += value);
    }
    Ok(sum)
}
