//! From a recording to a verdict with its evidence.
//!
//! ```text
//! Recording ──> Grid ──> the longest stretch ──> Fitness, Oscillation ──> Findings ──> Verdict
//! ```

mod kpis;
mod verdict;

pub use kpis::{Kpi, KpiOptions, Kpis, harris_index};
pub use verdict::{Basis, Estimate, Stiction, Verdict, VerdictClass, Votes, preliminary};
