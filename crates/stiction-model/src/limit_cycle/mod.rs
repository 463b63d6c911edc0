//! Limit cycles of a loop around a sticking valve, predicted without simulating it.
//!
//! ```text
//! ContinuousLoop ──> describing_function ──> harmonic_balance ──> Cycle   (approximate, any model)
//!       └──────────> exact ─────────────────────────────────────> Cycle   (exact, two-phase and He)
//! ```
//!
//! Both treat the loop in continuous time, at a constant set point and load, far from the limits of the OP. The cycle
//! of a sampled controller tends to this cycle as the sample time goes to 0.
//!
//! [`frequency_response`] is the loop without its valve, [`tuning`] finds the robust tuning with the smallest
//! swing, and [`map`] computes cycles over two parameters.

mod attractor;
mod cancelled;
mod continuous;
mod cycle;
pub mod describing_function;
pub mod exact;
mod found;
pub mod frequency_response;
pub mod harmonic_balance;
pub mod map;
pub mod tuning;

pub use attractor::attractor;
pub use cancelled::{CancelledCycle, CancelledLoop};
pub use continuous::ContinuousLoop;
pub use cycle::{Cycle, Method, Swing};
pub use describing_function::DescribingFunction;
pub use found::{Found, State};
pub use frequency_response::{FrequencyResponse, Margins, Stability};
pub use harmonic_balance::harmonic_balance;
