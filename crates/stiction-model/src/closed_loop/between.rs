//! What may stand between controller and valve.

/// What the integral action of the controller may do at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum IntegralAction {
    /// It acts as usual.
    Acts,
    /// It stands still.
    Stops,
    /// It acts, but the output that the controller would give without a control error stays within
    /// these limits, percent of span.
    Within {
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
}

/// What goes to the valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sent {
    /// The signal that the valve receives, percent of span.
    pub signal: f64,
    /// Whether the controller follows it, as one in manual mode does: its next output starts from the
    /// signal. A controller without integral action has nothing to follow with and goes on as it is.
    pub tracked: bool,
}

impl Sent {
    /// `signal`, with the controller unaware of it.
    pub fn added(signal: f64) -> Self {
        Self { signal, tracked: false }
    }

    /// `signal`, with the controller following it.
    pub fn held(signal: f64) -> Self {
        Self { signal, tracked: true }
    }
}

/// Stands between the controller and the valve of a loop.
pub trait Between {
    /// What the integral action may do at this sample. Asked before the controller answers.
    fn integral(&mut self, sp: f64, pv: f64) -> IntegralAction;

    /// What goes to the valve now that the controller has answered `op`.
    fn send(&mut self, sp: f64, pv: f64, op: f64) -> Sent;
}

/// Nothing at all: the controller output is what the valve receives.
pub(super) struct Wire;

impl Between for Wire {
    #[inline(always)]
    fn integral(&mut self, _: f64, _: f64) -> IntegralAction {
        IntegralAction::Acts
    }

    #[inline(always)]
    fn send(&mut self, _: f64, _: f64, op: f64) -> Sent {
        Sent::added(op)
    }
}
