//! A loop with custom parts: any valve, controller or process.

use super::bank::{AHEAD, Feeds, quantised, with_order};
use super::controller::{Engaged, PidBank};
use super::process::{DelayLine, ProcessBank};
use super::{ClosedLoop, Controller, Run, SampledProcess};
use crate::error::{Error, Result};
use crate::simd::Lane;
use crate::valve::{Start, Valve};

/// A custom controller.
pub trait OwnController {
    /// Starts at output `op`, set point `sp` and `pv`, with `sample_time` seconds between executions.
    fn restart(&mut self, sample_time: f64, op: f64, sp: f64, pv: f64);

    /// The controller output (OP), percent of span, for the present set point and PV.
    fn step(&mut self, sp: f64, pv: f64) -> f64;
}

/// A custom process, around its operating point.
pub trait OwnProcess {
    /// Starts at rest. Each step then advances by `sample_time` seconds.
    fn restart(&mut self, sample_time: f64);

    /// The PV, before the input of the present sample acts.
    fn output(&self) -> f64;

    /// Advances to the next sample with `input` held: valve position and load, percent of span.
    fn advance(&mut self, input: f64);
}

/// Custom parts for a [`ClosedLoop`]; `None` keeps the loop's own part.
///
/// They are stepped one sample at a time, in the order and with the arithmetic of the loop's own parts. A part that
/// repeats one of this library gives the same bits, but slower. A custom valve is any [`Valve`]; a physical one is
/// [`StemValve`](crate::stem::StemValve).
///
/// ```
/// use stiction_model::closed_loop::{ClosedLoop, Controller, Own, Process};
/// use stiction_model::valve::{Assembly, Ideal, Start, Valve};
///
/// /// Moves by at most 0.1 % a sample.
/// struct Slow(f64);
/// impl Valve for Slow {
///     fn step(&mut self, op: f64) -> f64 {
///         self.0 += (op - self.0).clamp(-0.1, 0.1);
///         self.0
///     }
///     fn position(&self) -> f64 {
///         self.0
///     }
///     fn restart(&mut self, start: Start) {
///         self.0 = start.position;
///     }
/// }
///
/// let ideal = Assembly::new(Ideal::new().into());
/// let mut plant = ClosedLoop::new(Controller::pi(1.1, 2.5)?, ideal, Process::first_order(1.5, 5.93, 1.07)?);
/// plant.set_point = 5.0.into();
/// let run = plant.run_with(Own { valve: Some(&mut Slow(0.0)), ..Own::default() })?;
/// assert!(run.vp.windows(2).all(|moved| (moved[1] - moved[0]).abs() < 0.1 + 1e-12));
/// # Ok::<(), stiction_model::Error>(())
/// ```
#[derive(Default)]
pub struct Own<'a> {
    /// Instead of the controller.
    pub controller: Option<&'a mut dyn OwnController>,
    /// Instead of the valve. It is restarted at rest at [`ClosedLoop::op_rest`].
    pub valve: Option<&'a mut dyn Valve>,
    /// Instead of the process with its dead time.
    pub process: Option<&'a mut dyn OwnProcess>,
}

/// The loop's own controller, alone.
struct BuiltIn {
    settings: Controller,
    bank: Option<PidBank<1>>,
}

impl OwnController for BuiltIn {
    fn restart(&mut self, sample_time: f64, op: f64, sp: f64, pv: f64) {
        let engaged = Engaged::new(&self.settings, sample_time, op, sp, pv);
        self.bank = Some(PidBank::new(&[engaged]));
    }

    fn step(&mut self, sp: f64, pv: f64) -> f64 {
        self.bank.as_mut().map_or(f64::NAN, |bank| bank.step(0, sp, pv))
    }
}

/// The loop's own process, alone.
struct Sampled<const M: usize> {
    process: SampledProcess,
    bank: ProcessBank<1, M>,
    line: DelayLine<1>,
}

impl<const M: usize> Sampled<M> {
    fn new(process: SampledProcess) -> Self {
        let line = DelayLine::new([process.delay()]);
        Self { bank: ProcessBank::new([&process]), line, process }
    }
}

impl<const M: usize> OwnProcess for Sampled<M> {
    fn restart(&mut self, _: f64) {
        *self = Self::new(self.process.clone());
    }

    fn output(&self) -> f64 {
        self.bank.output(0)
    }

    fn advance(&mut self, input: f64) {
        self.bank.advance(self.line.push::<true>(Lane([input])));
    }
}

impl ClosedLoop {
    /// Simulates the loop with the custom parts in `own`, and keeps every sample.
    ///
    /// # Errors
    /// As [`ClosedLoop::run`]; also for the settings of a replaced part.
    pub fn run_with(&self, own: Own<'_>) -> Result<Run> {
        self.run_with_progress(own, || true)
    }

    /// As [`ClosedLoop::run_with`], calling `goes_on` every few samples.
    ///
    /// # Errors
    /// As [`ClosedLoop::run_with`], and [`Error::Cancelled`].
    pub fn run_with_progress(
        &self,
        own: Own<'_>,
        mut goes_on: impl FnMut() -> bool,
    ) -> Result<Run> {
        let prepared = self.prepare()?;
        let mut built_in = BuiltIn { settings: self.controller.clone(), bank: None };
        let mut assembly = self.valve.clone();
        let mut sampled: Box<dyn OwnProcess> = with_order!(prepared.process.order(), M => {
            Box::new(Sampled::<M>::new(prepared.process.clone()))
        });
        let controller: &mut dyn OwnController = match own.controller {
            Some(own) => own,
            None => &mut built_in,
        };
        let valve: &mut dyn Valve = match own.valve {
            Some(own) => own,
            None => &mut assembly,
        };
        let process: &mut dyn OwnProcess = match own.process {
            Some(own) => own,
            None => &mut *sampled,
        };
        controller.restart(self.sample_time, self.op_rest, prepared.first_sp, self.pv_rest);
        valve.restart(Start::at_rest(self.op_rest));
        process.restart(self.sample_time);

        let mut feeds = Feeds::new([&prepared]);
        let mut run = self.empty_run();
        for from in (0..self.samples).step_by(AHEAD) {
            if !goes_on() {
                return Err(Error::Cancelled);
            }
            let [sp, load, measurement] = feeds.draw(AHEAD.min(self.samples - from));
            for ((sp, load), measurement) in sp.iter().zip(load).zip(measurement) {
                // As in `LoopState::step` of the bank.
                let pv = (process.output() + self.pv_rest) + measurement[0];
                let pv = quantised(pv, self.pv_quantum);
                let op = quantised(controller.step(sp[0], pv), self.op_quantum);
                let vp = valve.step(op);
                process.advance((vp - self.op_rest) + load[0]);
                run.sp.push(sp[0]);
                run.pv.push(pv);
                run.op.push(op);
                run.vp.push(vp);
            }
        }
        Ok(run)
    }
}
