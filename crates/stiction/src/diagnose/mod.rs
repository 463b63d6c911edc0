//! From a recording to a verdict with its evidence.
//!
//! ```text
//! Recording ──> Grid ──> the longest stretch ──> Fitness, Oscillation ──> Findings ──> Verdict
//! ```

mod diagnosis;
mod kpis;
pub mod scoreboard;
mod verdict;

pub use crate::fusion::{Cause, Estimate};
pub use diagnosis::{Detectors, Diagnosis, Options, Window, diagnose};
pub use kpis::{Kpi, KpiOptions, Kpis, harris_index};
pub use verdict::{
    Alternative, Basis, ConfirmingTest, Definition, FEWEST_VOTES, MIMICS, Stiction, Verdict,
    VerdictClass, Votes, preliminary,
};
