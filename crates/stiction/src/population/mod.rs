//! A population of simulated loops with known truth, to train and to measure a verdict on stiction.
//!
//! A [`member`] is one loop: its [`Kind`] is drawn by the kind's share, everything else after it. The
//! loops of all kinds are drawn from the same distributions of process, tuning, noise, set point,
//! load and historian; they differ in the valve and in the named cause, and in nothing else, so that
//! nothing else can be learned from them. `docs/population.md` tells what is drawn, and from what.
//!
//! ```text
//! Draw ──> Design ──> Tapes ──> Plant ──> what a plant would have seen ──> historian ──> Recording
//!          (kind)     (noise,     └─────> the same with a healthy valve ──> visible? ──> Truth
//!                      load, SP)
//! ```
//!
//! Version 3. A change of what a seed gives is a new version and is named in the change log.

mod design;
mod disturbance;
mod draw;
mod historian;
mod kind;
mod member;
mod plant;
mod truth;

pub use design::{NoiseKind, ProcessKind, SetPointKind};
pub use historian::swinging_door;
pub use kind::Kind;
pub use member::member;
pub use truth::{Facts, Simulated, Truth};

/// Version of the population: which loop a seed gives.
pub const VERSION: u32 = 3;
