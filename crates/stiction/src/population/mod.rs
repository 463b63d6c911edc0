//! Simulated loops with known truth, to measure methods on.
//!
//! A [`Case`] is a family of loops: one whose valve sticks, and those with healthy valves that methods
//! mistake for it. Every seed is another loop of the family, the same on every machine and thread.
//!
//! Version 1. A change of what a seed gives is a new version and is named in the change log.

mod case;
mod historian;

pub use case::{Case, Simulated, Truth};
pub use historian::swinging_door;

/// Version of the families: which loop a seed gives.
pub const VERSION: u32 = 1;
