//! The integral limit.

use super::steady_op::SteadyOp;
use super::{Compensator, Instant, IntegralAction, Method, Sent};
use crate::Number;
use crate::error::{Result, finite, non_negative, positive};

/// Integral action limited to a range around the steady OP: a reset limit, as some controllers have it.
///
/// # What it does
/// The integral cannot push beyond the range. If that is too little to break the stem away, the stem stays and the
/// cycle ends.
///
/// # Equations
/// ```text
/// steady OP - half_width <= OP without control error <= steady OP + half_width
/// signal = op
/// ```
/// The integral acts freely until the steady OP is known.
///
/// # Assumptions
/// The load stays within the range that the valve can balance.
///
/// # Limits
/// Once the stem rests, the remaining control error stays, and a change of set point or load beyond the range
/// leaves an error. The cost of the calm is an offset.
///
/// # Deviations from the paper
/// It is common practice without a paper. The steady OP is the mean OP over whole periods of the previous cycle,
/// two of which must agree within `agree`.
///
/// # References
/// None.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegralLimit {
    /// Half the width of the range, percent of span.
    pub half_width: f64,
    /// The steady OP, percent of span; `None` to estimate it.
    pub steady_op: Option<f64>,
    /// Largest difference between the means of two periods in an estimate, percent of span.
    pub agree: f64,
    /// Memory of large control errors for finding the periods, s.
    pub memory_s: f64,
}

impl Default for IntegralLimit {
    /// 1 % around an estimate accurate to 1 %, with a memory of 60 s.
    fn default() -> Self {
        Self { half_width: 1.0, steady_op: None, agree: 1.0, memory_s: 60.0 }
    }
}

impl IntegralLimit {
    /// A half-width without effect, percent of span.
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
        // At its limit, the OP no longer shows the steady value.
        if self.steady_op().is_none() {
            self.steady.take(now);
        }
        Sent::added(now.op)
    }
}
