//! The integral limit.

use super::steady_op::SteadyOp;
use super::{Compensator, Instant, IntegralAction, Method, Sent};
use crate::Number;
use crate::error::{Result, finite, non_negative, positive};

/// Integral action limited to a range about the steady OP: a reset limit as some controllers offer it.
///
/// # What it does
/// The integral may not push further than the range. If that is less than what breaks the stem away,
/// the stem stays, and with it the cycle.
///
/// # Equations
/// ```text
/// steady OP - half_width <= OP without control error <= steady OP + half_width
/// signal = op
/// ```
/// While the steady OP is not known, the integral acts freely.
///
/// # Assumptions
/// The load stays within what the range can balance.
///
/// # Limits
/// Once the stem rests, the control error that is there stays; a change of set point or load beyond the
/// range is not followed to the end. It buys quiet with an offset.
///
/// # Deviations from the paper
/// It is practice without a paper. The steady OP is the mean OP over whole periods of the cycle seen
/// before, two of which must agree within `agree`.
///
/// # References
/// None.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegralLimit {
    /// Half the width of the range, percent of span.
    pub half_width: f64,
    /// The steady OP, percent of span; `None` to estimate it.
    pub steady_op: Option<f64>,
    /// How far the means of two periods may differ in an estimate, percent of span.
    pub agree: f64,
    /// How long a large control error is remembered in finding the periods, s.
    pub memory_s: f64,
}

impl Default for IntegralLimit {
    /// 1 % about an estimate good to 1 %, with a memory of 60 s.
    fn default() -> Self {
        Self { half_width: 1.0, steady_op: None, agree: 1.0, memory_s: 60.0 }
    }
}

impl IntegralLimit {
    /// A half-width that limits nothing, percent of span.
    pub const SPAN: f64 = 100.0;

    /// An integral limit with these parameters.
    ///
    /// # Errors
    /// If the half-width or `agree` is negative, the memory not positive, or any not finite.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        non_negative("half-width of the integral limit", self.half_width)?;
        if let Some(op) = self.steady_op {
            finite("steady OP", op)?;
        }
        non_negative("agreement of the steady OP", self.agree)?;
        positive("memory of the steady OP", self.memory_s)?;
        let steady = SteadyOp::new(self.agree, self.memory_s);
        Ok(Box::new(Limiting { settings: self, steady }))
    }
}

#[derive(Debug)]
struct Limiting {
    settings: IntegralLimit,
    steady: SteadyOp,
}

impl Limiting {
    fn steady_op(&self) -> Option<f64> {
        self.settings.steady_op.or(self.steady.value())
    }
}

impl Compensator for Limiting {
    fn method(&self) -> Method {
        Method::IntegralLimit
    }

    fn parameters(&self) -> Vec<Number> {
        let mut parameters = vec![Number::new("half-width", self.settings.half_width, "%")];
        parameters.extend(self.steady_op().map(|op| Number::new("steady OP", op, "%")));
        parameters
    }

    fn reset(&mut self) {
        self.steady.reset();
    }

    fn watch(&mut self, now: &Instant) {
        self.steady.take(now);
    }

    fn integral(&mut self, _: f64) -> IntegralAction {
        let half = self.settings.half_width;
        self.steady_op().map_or(IntegralAction::Acts, |op| IntegralAction::Within {
            low: op - half,
            high: op + half,
        })
    }

    fn step(&mut self, now: &Instant) -> Sent {
        // Once it limits, the OP says nothing about where it would like to be.
        if self.steady_op().is_none() {
            self.steady.take(now);
        }
        Sent::added(now.op)
    }
}
