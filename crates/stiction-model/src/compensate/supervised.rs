//! Supervision by the control error.

use super::{Compensator, Instant, IntegralAction, Method, Sent};
use crate::Number;
use crate::error::{Error, Result, non_negative, positive};

/// Supervision after Cuadros: another compensator works while the control error is large. Once the error has been
/// small for a while, compensator and integral action are frozen.
///
/// # What it does
/// A knocker alone never stops. Under supervision it knocks until the stem has stopped where the PV is near its set
/// point; then nothing moves the stem until the error has grown.
///
/// # Equations
/// With the control error `e` filtered by `filter_s` (first order):
/// ```text
/// at work:   |e| <= quiet for dwell_s      -> rests
/// resting:   |e| >  wake                   -> at work
/// resting:   signal = op, the integral is frozen
/// ```
///
/// # Assumptions
/// The inner compensator sometimes brings the stem to a position with the PV within `quiet`.
///
/// # Limits
/// A control error up to `wake` stays. An integrating process does not stay, so it wakes again and again.
///
/// # Deviations from the paper
/// In the paper, the PV error is known to trigger the compensator. The filter, the two thresholds, the dwell and
/// the frozen integral are ours.
///
/// # References
/// M. A. D. S. L. Cuadros et al. (2012).
#[derive(Debug)]
pub struct Supervised {
    /// The supervised compensator.
    pub inner: Box<dyn Compensator>,
    /// Control error above which the compensator starts, in PV units.
    pub wake: f64,
    /// Control error below which the compensator may rest, in PV units; at most `wake`.
    pub quiet: f64,
    /// Time for which the error must be small, s.
    pub dwell_s: f64,
    /// Time constant of the filter of the error, s; 0 for none.
    pub filter_s: f64,
}

impl Supervised {
    /// This supervision.
    ///
    /// # Errors
    /// If `wake` is not positive, `quiet`, the dwell or the filter time is negative, any is not finite,
    /// or `quiet` exceeds `wake`.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        positive("error at which the compensator starts", self.wake)?;
        non_negative("error at which the compensator may stop", self.quiet)?;
        non_negative("dwell of the supervision", self.dwell_s)?;
        non_negative("filter time of the supervision", self.filter_s)?;
        if self.quiet > self.wake {
            return Err(Error::Inconsistent(format!(
                "the error at which the compensator stops, {}, must not exceed the error at which it starts, {}",
                self.quiet, self.wake
            )));
        }
        Ok(Box::new(Supervising {
            settings: self,
            resting: false,
            error: None,
            time_s: 0.0,
            small_since: None,
        }))
    }
}

#[derive(Debug)]
struct Supervising {
    settings: Supervised,
    resting: bool,
    /// The filtered error, once there was a sample.
    error: Option<f64>,
    /// Time of the last sample, s.
    time_s: f64,
    /// Start of the small error, s.
    small_since: Option<f64>,
}

impl Supervising {
    /// Filters the error and returns its present size.
    fn filtered(&mut self, now: &Instant) -> f64 {
        let passed = now.time_s - self.time_s;
        let keep = if self.settings.filter_s > 0.0 {
            (-passed / self.settings.filter_s).exp()
        } else {
            0.0
        };
        let error = self.error.map_or(now.error(), |e| keep * e + (1.0 - keep) * now.error());
        (self.error, self.time_s) = (Some(error), now.time_s);
        error.abs()
    }
}

impl Compensator for Supervising {
    fn method(&self) -> Method {
        Method::Supervised
    }

    fn parameters(&self) -> Vec<Number> {
        let mut parameters = self.settings.inner.parameters();
        parameters.extend([
            Number::new("wake", self.settings.wake, "PV"),
            Number::new("quiet", self.settings.quiet, "PV"),
            Number::new("dwell", self.settings.dwell_s, "s"),
            Number::new("filter", self.settings.filter_s, "s"),
        ]);
        parameters
    }

    fn reset(&mut self) {
        self.settings.inner.reset();
        (self.resting, self.error, self.time_s, self.small_since) = (false, None, 0.0, None);
    }

    fn watch(&mut self, now: &Instant) {
        self.filtered(now);
        self.settings.inner.watch(now);
    }

    fn integral(&mut self, error: f64) -> IntegralAction {
        if self.resting { IntegralAction::Stops } else { self.settings.inner.integral(error) }
    }

    fn step(&mut self, now: &Instant) -> Sent {
        let error = self.filtered(now);
        if self.resting && error > self.settings.wake {
            (self.resting, self.small_since) = (false, None);
        }
        if error > self.settings.quiet {
            self.small_since = None;
        } else {
            let since = *self.small_since.get_or_insert(now.time_s);
            self.resting |= now.time_s - since >= self.settings.dwell_s;
        }
        if self.resting {
            self.settings.inner.watch(now);
            Sent::added(now.op)
        } else {
            self.settings.inner.step(now)
        }
    }
}
