//! The stem as a valve in a loop: controller output in, position out, sample by sample.

use super::body::Recorder;
use super::pressure::Segment;
use super::response::{Event, StemStart};
use super::simulate::{Run, Stem};
use crate::error::{Error, Result, positive};
use crate::valve::{Start, Valve};

/// A physical stem driven by controller output samples, each held for one sample time.
///
/// [`Valve::step`] returns the position at the *end* of the interval over which `op` acted, that is, one sample
/// time after `op` was set. The data-driven models respond at once; to compare, shift the stem by one sample or use
/// a short sample time.
///
/// The controller output is not limited: below 0 % and above 100 % the pressure continues linearly.
///
/// A step cannot return an error. If the solver cannot continue, or `op` is not finite, the position becomes NaN
/// until [`Valve::restart`], and [`StemValve::fault`] gives the reason.
#[derive(Debug, Clone)]
pub struct StemValve {
    stem: Stem,
    sample_time_s: f64,
    run: Option<Run>,
    samples: u64,
    position: f64,
    recorder: Recorder<'static>,
    fault: Option<Error>,
}

impl StemValve {
    /// At rest at 0 % under 0 % controller output.
    ///
    /// # Errors
    /// If the sample time is not above 0.
    pub fn new(stem: Stem, sample_time_s: f64) -> Result<Self> {
        positive("sample time", sample_time_s)?;
        let mut valve = Self {
            stem,
            sample_time_s,
            run: None,
            samples: 0,
            position: 0.0,
            recorder: Recorder::default(),
            fault: None,
        };
        valve.restart(Start::default());
        Ok(valve)
    }

    /// The stem.
    pub fn stem(&self) -> &Stem {
        &self.stem
    }

    /// Sample time, s.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// Why the position is NaN, if it is.
    pub fn fault(&self) -> Option<&Error> {
        self.fault.as_ref()
    }

    /// The events of the last step, with times from the last restart.
    pub fn events(&self) -> &[Event] {
        &self.recorder.events
    }

    fn try_step(&mut self, op: f64) -> Result<f64> {
        let Some(run) = &mut self.run else { return Ok(f64::NAN) };
        let start_s = self.samples as f64 * self.sample_time_s;
        let end_s = (self.samples + 1) as f64 * self.sample_time_s;
        let segment = Segment::held(start_s, end_s, self.stem.parameters().pressure_pa(op))?;
        run.advance(&segment, &mut self.recorder)?;
        self.samples += 1;
        Ok(self.stem.parameters().percent(run.position_m()))
    }

    fn fail(&mut self, error: Error) {
        self.fault = Some(error);
        self.run = None;
        self.position = f64::NAN;
    }
}

impl Valve for StemValve {
    fn step(&mut self, op: f64) -> f64 {
        self.recorder.events.clear();
        match self.try_step(op) {
            Ok(position) => self.position = position,
            Err(error) => self.fail(error),
        }
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    /// Starts at rest at `start.position` with the air pressure settled at `start.op`. Friction carries the net force
    /// up to the breakaway force. `start.direction` and `start.moving` are unused, because a moving stem would need a
    /// velocity. A position beyond an end stop is a fault.
    fn restart(&mut self, start: Start) {
        self.recorder.events.clear();
        self.samples = 0;
        self.fault = None;
        self.position = start.position;
        let parameters = self.stem.parameters();
        let pressure_pa = parameters.pressure_pa(start.op);
        let at_rest = StemStart {
            pressure_pa: Some(pressure_pa),
            ..StemStart::at_rest(parameters.position_m(start.position))
        };
        let run = start.checked().and_then(|_| Run::new(&self.stem, at_rest, pressure_pa));
        match run {
            Ok(run) => self.run = Some(run),
            Err(error) => self.fail(error),
        }
    }
}
