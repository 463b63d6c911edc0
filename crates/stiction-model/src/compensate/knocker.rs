//! The knocker.

use super::{Compensator, Instant, Method, Sent, sign};
use crate::Number;
use crate::error::{Error, Result, non_negative};

/// Hägglund's knocker: short pulses added to the OP, in the direction of its movement.
///
/// # What it does
/// Every pulse knocks on the stem. When the OP is close enough to the breakaway, a pulse moves the stem, and slips
/// occur earlier and more often than with integral action alone.
///
/// # Equations
/// Pulses begin at samples `t_0, t_0 + h, t_0 + 2h, ...`, where `t_0` is the sample at which the knocker
/// is switched on. With the OP `u_c`, for the `w` samples from the onset `t_p` of each pulse:
/// ```text
/// signal = u_c + a sgn(u_c(t_p) - u_c(t_p - h))        sgn(0) = 0
/// ```
/// The sign is computed once, at the onset, and kept for the pulse. The first pulse has no onset before it, so `u_c(t_0
/// - h) = 0`, and the pulse has the sign of the OP.
///
/// # Assumptions
/// The stem follows within the width of a pulse.
///
/// # Limits
/// It knocks for ever, even if the loop is in order, and the stem travels more than without it. See
/// [`Supervised`](super::Supervised).
///
/// # Deviations from the paper
/// The form is recalled, not read; of the patent, the claims (pulse train, sign of the derivative of the OP) were
/// read. Amplitudes of 1 to 4 %, widths of 1 to 2 samples and periods of 2 to 5 widths are recalled as the
/// published ranges. Using the sign at the onset is ours; for widths of one or two samples it makes no difference.
///
/// # References
/// T. Hägglund, "A friction compensator for pneumatic control valves", J. Process Control 12 (2002) 507
/// (title recalled); US patent 6,285,913, WO 97/11297.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knocker {
    /// Height of a pulse `a`, percent of span.
    pub amplitude: f64,
    /// Width of a pulse `w`, samples.
    pub width: usize,
    /// Time between the onsets of two pulses `h`, samples.
    pub period: usize,
}

impl Default for Knocker {
    /// 2 % for 2 samples every 5 samples: within the published ranges.
    fn default() -> Self {
        Self { amplitude: 2.0, width: 2, period: 5 }
    }
}

impl Knocker {
    /// A knocker with these parameters.
    ///
    /// # Errors
    /// If the amplitude is negative or not finite, or the width is not between 1 and the period.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        non_negative("knocker amplitude", self.amplitude)?;
        if self.width == 0 || self.width > self.period {
            return Err(Error::Parameter {
                name: "width of the knocker's pulses",
                value: self.width as f64,
                allowed: format!("between 1 sample and the period of {} samples", self.period),
            });
        }
        Ok(Box::new(Knocking { settings: self, phase: 0, onset: 0.0, push: 0.0 }))
    }
}

#[derive(Debug)]
struct Knocking {
    settings: Knocker,
    /// Samples since the onset of the present pulse.
    phase: usize,
    /// OP at the last onset.
    onset: f64,
    push: f64,
}

impl Compensator for Knocking {
    fn method(&self) -> Method {
        Method::Knocker
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("amplitude", self.settings.amplitude, "%"),
            Number::new("width", self.settings.width as f64, "samples"),
            Number::new("period", self.settings.period as f64, "samples"),
        ]
    }

    fn reset(&mut self) {
        (self.phase, self.onset, self.push) = (0, 0.0, 0.0);
    }

    fn step(&mut self, now: &Instant) -> Sent {
        if self.phase == 0 {
            self.push = self.settings.amplitude * sign(now.op - self.onset);
            self.onset = now.op;
        }
        let push = if self.phase < self.settings.width { self.push } else { 0.0 };
        self.phase = (self.phase + 1) % self.settings.period;
        Sent::added(now.op + push)
    }
}
