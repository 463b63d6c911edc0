//! A population of simulated loops with known truth, to train and to measure a verdict on stiction.
//!
//! A [`member`] is one loop: its [`LoopKind`] is drawn by the kind's share, everything else after it. The
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
//! Version 5. A change of what a seed gives is a new version and is named in the change log.

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
pub mod scoreboard;
mod stem;
mod switched;
mod test_trial;
mod tested;
mod truth;
mod visibility;

pub(crate) use draw::Draw;
pub use families::{
    ControllerKind, DisturbanceKind, Family, HistorianKind, NoiseKind, ProcessKind, SetPointKind,
    Situation,
};
pub use historian::swinging_door;
pub use invented::{Invented, Invention};
pub use kind::LoopKind;
pub use member::member;
pub use mistaken::{Mistake, mistaken};
pub use test_trial::{TestTrial, TestTrialOptions};
pub use tested::{Carried, Operator, Tested, ToPlan, Trend};
pub use truth::{Facts, Simulated, Truth};

/// Version of the population: which loop a seed gives.
pub const VERSION: u32 = 5;
