//! From a recording to a verdict with its evidence.
//!
//! ```text
//! Recording ──> Grid ──> the longest stretch ──> Fitness, Oscillation ──> Findings ──> Verdict
//! several of one valve ──> History, Repair
//! ```

mod diagnosis;
pub mod history;
mod kpis;
pub mod repair;
pub mod scoreboard;
mod verdict;

pub use crate::fusion::{Cause, Estimate};
pub use diagnosis::{Detectors, Diagnosis, Options, Window, diagnose};
pub use history::{Drift, History, Observation, combine};
pub use kpis::{Kpi, KpiOptions, Kpis, harris_index};
pub use repair::{Contrast, Outcome, Repair, repair};
pub use verdict::{
    Alternative, Basis, ConfirmingTest, Definition, FEWEST_VOTES, MIMICS, Stiction, Verdict,
    VerdictClass, Votes, preliminary,
};
