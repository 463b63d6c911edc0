//! A master loop that sets the set point of a slave loop with a sticking valve.

use super::bank::{Each, LoopBank, Recorder, with_order};
use super::controller::{Engaged, PidBank};
use super::description::{Prepared, total};
use super::process::{DelayLine, ProcessBank};
use super::{ClosedLoop, Controller, Process, Run, SampledProcess, Signal};
use crate::error::{Error, Result, finite};
use crate::simd::Lane;
use crate::valve::{Assembly, Start, Valve};

/// A slave loop under a master, such as a flow loop under a temperature loop.
///
/// ```text
/// master sp ──> master ──(+)── slave sp ──> slave loop ── slave PV ──> master process ──> master PV
///                 ^    slave.set_point                                                  │
///                 └─────────────────────────────────────────────────────────────────────┘
/// ```
/// The master's output is in units of the slave's PV. It adds to [`ClosedLoop::set_point`] of the slave, which is
/// then the set point at the operating point. Both loops start at rest there.
#[derive(Debug, Clone, PartialEq)]
pub struct Cascade {
    /// The slave loop. Its sample time and number of samples apply to the whole cascade.
    pub slave: ClosedLoop,
    /// The master's controller: slave PV units per master PV unit.
    pub controller: Controller,
    /// From the slave's PV to the master's, around the operating point. The slave's PV is held over each sample.
    pub process: Process,
    /// Set point of the master, in its PV units.
    pub set_point: Signal,
    /// Measurement noise and output disturbances of the master's PV. Their sum is added to the PV.
    pub measurement: Vec<Signal>,
    /// The master's PV at the operating point.
    pub pv_rest: f64,
    /// Samples of the slave per sample of the master.
    pub every: usize,
}

/// The result of a simulated cascade, sample by sample of the slave.
#[derive(Debug, Clone, PartialEq)]
pub struct CascadeRun {
    /// The slave loop; its set point is the output of the master.
    pub slave: Run,
    /// Set point of the master.
    pub sp: Vec<f64>,
    /// Measured PV of the master.
    pub pv: Vec<f64>,
}

impl Cascade {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// If not; the message names the setting.
    pub fn check(&self) -> Result<()> {
        self.prepare().map(|_| ())
    }

    /// The slave with its settings checked, and the master's process sampled.
    fn prepare(&self) -> Result<(Prepared<'_>, SampledProcess)> {
        if self.every == 0 {
            return Err(Error::Parameter {
                name: "samples of the slave per sample of the master",
                value: 0.0,
                allowed: "at least 1".to_owned(),
            });
        }
        finite("operating point of the master's PV", self.pv_rest)?;
        let ts = self.slave.sample_time;
        self.set_point.source(ts, self.slave.samples)?;
        let slave = self.slave.prepare()?;
        Ok((slave, self.process.sampled(ts, self.slave.dead_time)?))
    }

    /// Simulates both loops.
    ///
    /// # Errors
    /// If a setting is out of range. The message names the setting.
    pub fn run(&self) -> Result<CascadeRun> {
        let (slave, process) = self.prepare()?;
        with_order!(slave.process.order().max(process.order()), M => {
            self.play::<M>(&slave, &process)
        })
    }

    fn play<const M: usize>(
        &self,
        slave: &Prepared<'_>,
        process: &SampledProcess,
    ) -> Result<CascadeRun> {
        let (ts, n) = (self.slave.sample_time, self.slave.samples);
        let trim = self.slave.set_point.sample(ts, n)?;
        let load = total(&self.slave.load, ts, n)?;
        let noise = total(&self.slave.measurement, ts, n)?;
        let master_sp = self.set_point.sample(ts, n)?;
        let master_noise = total(&self.measurement, ts, n)?;

        let mut valve = self.slave.valve.clone();
        valve.restart(Start::at_rest(self.slave.op_rest));
        let mut bank = LoopBank::<Each<Assembly, 1>, 1, M>::new([slave], Each([valve]));
        let mut master_process = ProcessBank::<1, M>::new([process]);
        let mut master_line = DelayLine::new([process.delay()]);
        let first_sp = master_sp.first().copied().unwrap_or(self.pv_rest);
        let period = ts * self.every as f64;
        let engaged = Engaged::new(&self.controller, period, 0.0, first_sp, self.pv_rest);
        let mut master = PidBank::new(&[engaged]);

        let mut run =
            CascadeRun { slave: self.slave.empty_run(), sp: master_sp, pv: Vec::with_capacity(n) };
        let mut output = 0.0;
        for k in 0..n {
            let pv = master_process.output(0) + self.pv_rest + master_noise[k];
            if k % self.every == 0 {
                output = master.step(0, run.sp[k], pv);
            }
            let flow = bank.process_value(0);
            let sample = bank.step(&Lane([trim[k] + output]), &Lane([load[k]]), &Lane([noise[k]]));
            master_process.advance(master_line.push::<true>(Lane([flow - self.slave.pv_rest])));
            run.pv.push(pv);
            run.slave.take(k, &[sample]);
        }
        Ok(run)
    }
}
