//! A test that shows whether a valve sticks. [`plan()`] sizes it from a recording in operation, an operator carries it
//! out, and [`read()`] judges the valve from its recording.
//!
//! A test is an experiment with a known input. In operation, stiction and a wandering load often look alike, because
//! the controller makes the OP depend on the PV. In a test the operator sets the OP: each turn reverses the last one
//! and does not depend on the PV.
//!
//! * `answer` estimates how far each turn moved the PV, without a valve model.
//! * `stems` calculates how far each valve would move with each turn.
//! * `explain` calculates how well a valve explains the answers. `weigh` finds the likely valves.
//! * `frozen` finds a PV that stood still in the recording. `latest` finds a valve that changed between two tests.
//! * `curve` straightens the characteristic that a staircase shows.
//! * `probability` combines the evidence of a test with the evidence of operation, and calibrates it.
//! * `carried` compares the test with its plan. `compare` shows the effect of a repair.
//! * `behind` decides whether a dead band is in the valve or downstream of the process.
//! * [`signature()`] reads a slow ramp of the OP over the stroke, where the position is recorded.
//!
//! # Limits
//! The test is for one valve and one process that is roughly linear in the range of the test. The OP must drive this
//! valve, so test the inner loop of a cascade. If the process is fast, only the valve position distinguishes a dead
//! band in the valve from one in the transmitter.

mod answer;
mod behind;
mod compare;
mod curve;
mod cut;
mod explain;
mod frozen;
mod latest;
mod plan;
mod plan_comparison;
mod position;
mod probability;
mod ramps;
mod read;
mod short;
mod signature;
mod stems;
mod weigh;

pub use compare::{Comparison, Difference, Effect, Outcome, compare};
pub(crate) use plan::{KnownLoop, PERIODS, size};
pub use plan::{LEAST_HELD, PlanOptions, TestPlan, Turn, before_test, plan};
pub use plan_comparison::{PlanComparison, SizeComparison, same_loop};
pub use position::{Between, PositionReading};
pub use read::{ReadOptions, Repetition, Step, TestReading, read};
pub use short::short;
pub use signature::{Place, Ramp, Signature, SignaturePlan, by_ramps, signature, signature_plan};
