//! Compensators: elements between a controller and a sticking valve until the valve is repaired.
//!
//! ```text
//! sp ──> controller ── op ──> compensator ── signal ──> valve ── vp ──> process ──> pv
//!            ^  ^                  │                                             │
//!            │  └── tracks, stops ─┘                                             │
//!            └───────────────────────────────────────────────────────────────────┘
//! ```
//! At every sample a [`Compensator`] gets set point, PV and OP and gives the signal for the valve. Some add to the OP,
//! some take over and let the controller follow, some only freeze its integral action. One compensator is one file.
//! [`Method`] lists them all and chooses their parameters from the known valve and loop ([`Knowledge`]). [`run`] puts a
//! compensator into a simulated loop, [`Measures`] quantify its effect, and [`compare`] compares all compensators.
//!
//! Compensation treats a symptom. It mostly reduces the swing of the PV at the cost of stem travel, and so of wear.
//! Only maintenance repairs the valve.

mod compare;
mod constant_reinforcement;
mod integral_dead_zone;
mod integral_limit;
mod knocker;
mod measures;
mod modified_two_move;
mod moves;
mod registry;
mod run;
mod six_move;
mod steady_op;
mod supervised;
mod three_move;
mod tuning;
mod two_move;

pub use crate::closed_loop::{IntegralAction, Sent};
pub use compare::{
    Case, CompareOptions, Comparison, CompensatorOutcome, Row, compare, compare_with_progress,
    nominal,
};
pub use constant_reinforcement::ConstantReinforcement;
pub use integral_dead_zone::IntegralDeadZone;
pub use integral_limit::IntegralLimit;
pub use knocker::Knocker;
pub use measures::{Measures, settling_s};
pub use modified_two_move::ModifiedTwoMove;
pub use moves::{Correction, Moves};
pub use registry::{Description, Method};
pub use run::{At, CompensatedRun, run};
pub use six_move::SixMove;
pub use supervised::Supervised;
pub use three_move::ThreeMove;
pub use tuning::Figures;
pub use tuning::Knowledge;
pub use two_move::TwoMove;

use crate::Number;

/// The input of a compensator at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Time, s.
    pub time_s: f64,
    /// Set point, in PV units.
    pub sp: f64,
    /// Measured PV.
    pub pv: f64,
    /// Controller output, percent of span.
    pub op: f64,
}

impl Instant {
    /// The control error, `sp - pv`.
    pub fn error(&self) -> f64 {
        self.sp - self.pv
    }
}

/// Computes the valve's signal, sample by sample.
///
/// Instants must be finite and in order of time.
pub trait Compensator: std::fmt::Debug + Send {
    /// Method.
    fn method(&self) -> Method;

    /// Parameters.
    fn parameters(&self) -> Vec<Number>;

    /// Resets its memory.
    fn reset(&mut self);

    /// Processes a sample while the compensator is off and the OP goes to the valve unchanged.
    fn watch(&mut self, _now: &Instant) {}

    /// Permission of the controller's integral action at this sample. Called before the controller computes its
    /// output; `error` is `sp - pv`.
    fn integral(&mut self, _error: f64) -> IntegralAction {
        IntegralAction::Acts
    }

    /// The signal for the valve.
    fn step(&mut self, now: &Instant) -> Sent;
}

/// Sign of a number: -1, 0 or 1.
fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { 1f64.copysign(value) }
}
