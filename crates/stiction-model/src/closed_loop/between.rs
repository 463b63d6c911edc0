//! An element between controller and valve.

/// Permission of the controller's integral action at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum IntegralAction {
    /// It acts as usual.
    Acts,
    /// It is frozen.
    Stops,
    /// It acts, but the controller output at zero control error stays within these limits, percent of span.
    Within {
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
}

/// The signal for the valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sent {
    /// The signal that the valve receives, percent of span.
    pub signal: f64,
    /// Whether the controller follows it, as in manual mode: its next output then starts from the signal. A
    /// controller without integral action cannot follow and continues unchanged.
    pub tracked: bool,
}

impl Sent {
    /// `signal`, without the controller following.
    pub fn added(signal: f64) -> Self {
        Self { signal, tracked: false }
    }

    /// `signal`, with the controller following.
    pub fn held(signal: f64) -> Self {
        Self { signal, tracked: true }
    }
}

/// An element between the controller and the valve of a loop.
pub trait Between {
    /// Permission of the integral action at this sample. Called before the controller computes its output.
    fn integral(&mut self, sp: f64, pv: f64) -> IntegralAction;

    /// The signal for the valve after the controller output `op`.
    fn send(&mut self, sp: f64, pv: f64, op: f64) -> Sent;
}

/// No element: the valve receives the controller output.
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
