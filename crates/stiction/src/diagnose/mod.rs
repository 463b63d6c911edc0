//! From a recording to a verdict with its evidence.
//!
//! ```text
//! Recording ──> Grid ──> the longest stretch ──> Fitness, Oscillation ──> Findings ──> Verdict
//! several of one valve ──> History, Repair
//! ```

mod confirm;
mod definitions;
mod diagnosis;
pub mod history;
mod kpis;
mod quantify;
mod reasons;
pub mod repair;
pub mod scoreboard;
mod verdict;
mod weighing;

pub use crate::fusion::{Cause, Estimate};
pub use confirm::confirming_test;
pub use diagnosis::{Detectors, Diagnosis, Options, Window, diagnose, fitness, subject};
pub use history::{Drift, History, Observation, combine};
pub use kpis::{Kpi, KpiOptions, Kpis, harris_index};
pub use repair::{Contrast, Outcome, Repair, repair};
pub use verdict::{
    ACCUSED_FROM, Alternative, Basis, CLEARED_UP_TO, ConfirmingTest, DEAD_ZONE_BELOW, Definition,
    FEWEST_VOTES, MIMICS, Stiction, Verdict, VerdictClass, Votes, preliminary,
};
pub use weighing::{WIDEST, WIDEST_J, Weighing};
