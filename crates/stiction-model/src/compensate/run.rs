//! A closed loop with a compensator in it.

use super::{Compensator, Instant, IntegralAction, Sent};
use crate::closed_loop::{Between, ClosedLoop, Run};
use crate::error::{Error, Result};

/// The result of a compensated loop.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensatedRun {
    /// The loop; [`Run::op`] is the controller output.
    pub run: Run,
    /// The signal for the valve, percent of span, sample by sample.
    pub signal: Vec<f64>,
}

/// Simulates `plant` with `compensator` between its controller and its valve, switched on at the first sample at or
/// after `from_s` (infinite for never). The compensator is reset.
///
/// The signal is not limited to the range of the OP; a valve with end stops limits it by itself
/// ([`Assembly::with_limits`](crate::valve::Assembly::with_limits)).
///
/// ```
/// use stiction_model::closed_loop::{ClosedLoop, Controller, Process};
/// use stiction_model::compensate::{self, Knocker};
/// use stiction_model::numeric::summary::std;
/// use stiction_model::{Bands, valve::{Assembly, Model}};
///
/// let mut sticky = ClosedLoop::new(
///     Controller::pi(1.1, 2.5)?,
///     Assembly::new(Model::Kano.build(Bands::from_s_j(5.0, 3.0)?)?),
///     Process::first_order(1.5, 5.93, 1.07)?,
/// );
/// sticky.set_point = 5.0.into();
/// let mut knocker = Knocker { amplitude: 2.5, ..Knocker::default() }.start()?;
/// let knocked = compensate::run(&sticky, knocker.as_mut(), 200.0)?;
/// let spread = |from: usize| std(&knocked.run.pv[from..from + 1000]);
/// assert!(spread(1000) / spread(5000) > 4.0);
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If the loop has a setting out of range, or `from_s` is NaN.
pub fn run(
    plant: &ClosedLoop,
    compensator: &mut dyn Compensator,
    from_s: f64,
) -> Result<CompensatedRun> {
    if from_s.is_nan() {
        return Err(Error::Parameter {
            name: "time at which the compensator is switched on",
            value: from_s,
            allowed: "a time in s, or infinite for never".to_owned(),
        });
    }
    compensator.reset();
    let signal = Vec::with_capacity(plant.samples);
    // A time at a whole number of samples must not shift by rounding.
    let from = (from_s / plant.sample_time - 1e-9).ceil();
    let mut switched = Switched { compensator, sample_time: plant.sample_time, from, signal };
    let run = plant.run_between(&mut switched)?;
    Ok(CompensatedRun { run, signal: switched.signal })
}

/// A compensator in a loop that is driven sample by sample, at one of them.
///
/// It acts as in [`run`] when it is switched on from the beginning.
pub struct At<'a> {
    /// The compensator.
    pub compensator: &'a mut dyn Compensator,
    /// The time, s.
    pub time_s: f64,
}

impl Between for At<'_> {
    fn integral(&mut self, sp: f64, pv: f64) -> IntegralAction {
        self.compensator.integral(sp - pv)
    }

    fn send(&mut self, sp: f64, pv: f64, op: f64) -> Sent {
        self.compensator.step(&Instant { time_s: self.time_s, sp, pv, op })
    }
}

/// A compensator that is switched on at a given sample.
struct Switched<'a> {
    compensator: &'a mut dyn Compensator,
    sample_time: f64,
    /// The sample at which it is switched on.
    from: f64,
    signal: Vec<f64>,
}

impl Switched<'_> {
    /// The number of the present sample.
    fn now(&self) -> f64 {
        self.signal.len() as f64
    }
}

impl Between for Switched<'_> {
    fn integral(&mut self, sp: f64, pv: f64) -> IntegralAction {
        if self.now() < self.from {
            IntegralAction::Acts
        } else {
            self.compensator.integral(sp - pv)
        }
    }

    fn send(&mut self, sp: f64, pv: f64, op: f64) -> Sent {
        let now = Instant { time_s: self.now() * self.sample_time, sp, pv, op };
        let sent = if self.now() < self.from {
            self.compensator.watch(&now);
            Sent::added(op)
        } else {
            self.compensator.step(&now)
        };
        self.signal.push(sent.signal);
        sent
    }
}
