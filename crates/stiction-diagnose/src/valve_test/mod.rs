//! A test that settles whether a valve sticks: [`plan()`] sizes it from a recording in operation, somebody carries it
//! out, and [`read()`] judges the valve by the recording of it.
//!
//! A test is an experiment whose input is known. Operation often cannot tell a valve that sticks from a load that
//! wanders, because the controller ties the OP to the PV; turns that a person makes are tied to nothing.
//!
//! * `answer`: how far each turn moved the PV, whatever the valve did;
//! * `stems`: how far each valve would move with each turn;
//! * `explain`: how well a valve explains the answers; `weigh`: which valve is likely;
//! * `carried`: what was done of the plan; `compare`: what a repair changed;
//! * `behind`: whether a dead band lies in the valve or behind the process.
//!
//! # Limits
//! Of one valve before one process that is about linear in the range of the test. The valve must be that which the OP
//! moves: of a cascade the inner loop is tested. A dead band behind a fast process cannot be told from one in the valve
//! without its position.

mod answer;
mod behind;
mod carried;
mod compare;
mod cut;
mod explain;
mod plan;
mod position;
mod read;
mod short;
mod stems;
mod weigh;

pub use carried::{Carried, CarriedSize, same_loop};
pub use compare::{Comparison, Difference, Effect, compare};
pub(crate) use plan::{KnownLoop, size};
pub use plan::{PlanOptions, TestPlan, Turn, before_test, plan};
pub use position::{Between, PositionReading};
pub use read::{ReadOptions, Step, TestReading, read};
pub use short::short;
