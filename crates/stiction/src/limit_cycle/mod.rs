//! Limit cycles of a loop around a sticking valve, predicted without simulating it.
//!
//! ```text
//! ContinuousLoop ──> describing_function ──> harmonic_balance ──> Cycle   (approximate, any model)
//!       └──────────> exact ─────────────────────────────────────> Cycle   (exact, two-phase and He)
//! ```
//!
//! Both look at the loop in continuous time, at a constant set point and load, far from the limits of
//! the OP; what a sampled controller does tends to it as the sample time goes to 0.

mod cancelled;
mod continuous;
mod cycle;
pub mod exact;

pub use cancelled::{CancelledCycle, CancelledLoop};
pub use continuous::ContinuousLoop;
pub use cycle::{Cycle, Method, Swing};
