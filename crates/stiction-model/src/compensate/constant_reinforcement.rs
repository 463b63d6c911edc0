//! Constant reinforcement.

use super::{Compensator, Instant, Method, Sent, sign};
use crate::Number;
use crate::error::{Result, non_negative};

/// Ivan and Lakshminarayanan's constant reinforcement: a constant added to the OP, in the direction of its
/// movement.
///
/// # What it does
/// At every reversal of the OP the signal jumps across part of the band, so the stem waits less.
///
/// # Equations
/// With the OP `u_c`:
/// ```text
/// signal = u_c + a sgn(u_c(t) - u_c(t - 1))        sgn(0) = 0
/// ```
/// The sample before the first one is the last at which the OP went to the valve unchanged.
///
/// # Assumptions
/// The OP is free of noise, or its noise is smaller than its movement from sample to sample.
///
/// # Limits
/// With noise the added constant changes sign at almost every sample, a step of `2 a`. The stem then travels several times as far as without
/// compensation, even without stiction.
///
/// # Deviations from the paper
/// The form is recalled, not read. The dependence of `a` on the estimated band is theirs, the factor in
/// [`Method::automatic`] is ours.
///
/// # References
/// L. Z. X. Ivan, S. Lakshminarayanan (2009).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantReinforcement {
    /// The added constant `a`, percent of span.
    pub amplitude: f64,
}

impl Default for ConstantReinforcement {
    /// 2 %.
    fn default() -> Self {
        Self { amplitude: 2.0 }
    }
}

impl ConstantReinforcement {
    /// Constant reinforcement with this parameter.
    ///
    /// # Errors
    /// If the amplitude is negative or not finite.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        non_negative("amplitude of the constant reinforcement", self.amplitude)?;
        Ok(Box::new(Reinforcing { settings: self, before: None }))
    }
}

#[derive(Debug)]
struct Reinforcing {
    settings: ConstantReinforcement,
    /// The OP one sample ago.
    before: Option<f64>,
}

impl Compensator for Reinforcing {
    fn method(&self) -> Method {
        Method::ConstantReinforcement
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("amplitude", self.settings.amplitude, "%")]
    }

    fn reset(&mut self) {
        self.before = None;
    }

    fn watch(&mut self, now: &Instant) {
        self.before = Some(now.op);
    }

    fn step(&mut self, now: &Instant) -> Sent {
        let change = self.before.map_or(0.0, |before| now.op - before);
        self.before = Some(now.op);
        Sent::added(now.op + self.settings.amplitude * sign(change))
    }
}
