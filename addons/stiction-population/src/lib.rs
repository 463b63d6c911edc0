//! A population of simulated loops with known truth, to train and to measure a verdict on stiction.
//!
//! A [`member`] is one loop: its [`LoopKind`] is drawn by the kind's share, then everything else. The loops of all
//! kinds are drawn from the same distributions of process, tuning, noise, set point, load and historian. They
//! differ only in the valve and in the named cause, so that nothing else can be learned from them.
//! `docs/population.md` describes all distributions.
//!
//! ```text
//! Draw ──> Design ──> Tapes ──> Plant ──> recording without historian ──> historian ──> Recording
//!          (kind)     (noise,     └─────> the same with a healthy valve ──> visible? ──> Truth
//!                      load, SP)
//! ```
//!
//! Version 5. A change of the loops of a seed is a new version and is listed in the change log.

mod design;
mod disturbance;
mod draw;
mod families;
mod historian;
mod invented;
mod kind;
mod member;
mod mistaken;
mod neighbour;
pub mod network;
mod plant;
pub mod position;
mod repaired;
mod stem;
mod switched;
mod truth;
mod valve_trial;
mod visibility;

#[doc(hidden)]
pub use draw::Draw;
pub use families::{
    ControllerKind, DisturbanceKind, Family, HistorianKind, NoiseKind, ProcessKind, SetPointKind,
    Situation,
};
pub use historian::swinging_door;
pub use invented::{Invented, Invention, Unseen};
pub use kind::LoopKind;
pub use member::member;
pub use mistaken::{Mistake, mistaken};
pub use repaired::Repaired;
pub use truth::{Fact, Facts, Simulated, Truth};
pub use valve_trial::{Operator, OperatorActions, Tested, TestedValve, ToPlan, Trend};

/// Version of the population: it determines the loop of a seed.
pub const VERSION: u32 = 5;
