//! From a recording to a verdict with its evidence.
//!
//! ```text
//! Recording ──> Grid ──> the longest segment ──> Fitness, Oscillation ──> Findings ──> Verdict
//! several of one valve ──> History, Repair
//! ```

mod belonging;
pub mod by_evidence;
pub mod change;
mod combined_limit;
mod conclude;
mod definitions;
mod diagnosis;
mod display;
pub mod few_slips;
mod fit_windows;
mod grade;
pub mod history;
mod kpis;
mod measured;
mod no_response;
mod observation;
mod oscillations;
mod quantify;
mod reasons;
mod relation;
pub mod repair;
mod steps;
mod tested;
mod verdict;
mod weighing;
mod window;

pub use crate::fusion::{Cause, Estimate};
pub use by_evidence::{LARGEST_LIMIT, Ruling, Signs, thresholds, thresholds_of_several};
pub use diagnosis::{Diagnosis, Judged};
pub use few_slips::{FewSlips, few_slips};
pub use grade::{FINE_UP_TO, PROBABLY_FINE_UP_TO, PROBABLY_FROM};
pub use history::{Drift, History, combine, together};
pub use kpis::{Kpi, KpiOptions, Kpis, harris_index};
pub use measured::{ByPosition, by_position};
pub use no_response::{Fault, NAMED_FROM, NoResponse, Rest, Silence};
pub use observation::Observation;
pub use oscillations::Oscillations;
pub use relation::{Mismatch, Relation};
pub use repair::{Contrast, Repair, RepairOutcome, repair};
pub use steps::{Detectors, DiagnoseOptions, diagnose, diagnose_with_progress, fitness, subject};
pub use verdict::{
    Alternative, Basis, DEAD_ZONE_BELOW, Definition, Grade, HARMLESS, Limit, Override, Stiction,
    Verdict, VerdictClass, Votes,
};
pub use weighing::{WIDEST, WIDEST_J, Weighing, own_shares};
pub use window::Window;
