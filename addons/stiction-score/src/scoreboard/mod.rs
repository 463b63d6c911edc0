//! Accuracy of methods, and of the verdict, on loops with known truth.
//!
//! ```text
//! Diagnosis + Truth ──> Scored ──┬──> Outcomes   recall, false alarms, precision, abstention
//!                                ├──> Auc        how well a statistic ranks
//!                                ├──> Calibration  accuracy of a probability
//!                                ├──> Quantification  accuracy of S and J
//!                                ├──> Sureness       accuracy of limits and sure probabilities
//!                                ├──> Found          detected sticking valves by how clearly they show
//!                                └──> Undecided      reasons for undecided loops
//! ```
//!
//! Any detector is measured by its [`Answer`]s:
//!
//! ```text
//! Answer + Asked ──┬──> Measures     all of the above, risk against coverage, recall at 1 % false alarms
//!                  └──> Comparison   two detectors on the same loops, with p-values
//! ```
//!
//! A [`Scored`] keeps the counted parts of a diagnosis, so that populations of any size can be scored; a [`Board`]
//! contains all counts. Nothing is fitted. Thresholds are the thresholds of the methods.
//!
//! Loops with a sticking valve that the recording cannot show ([`Truth::visible`]) belong to neither class. They
//! are left out of every measure and counted separately.

mod answer;
mod auc;
mod band;
mod board;
mod calibration;
mod found;
mod outcomes;
mod paired;
mod quantification;
mod risk;
mod scored;
mod sureness;
mod undecided;

pub use answer::{
    Answer, Comparison, FEW_ALARMS, Failure, Group, GroupMeasure, KindMeasure, KnownLoop, Measures,
    NatsMeasure, Sure, answer_of, answers_of, times,
};
pub use auc::{Auc, DRAWS, Interval, Ranked, auc, by_valve, logit, recall_at, roc, threshold_at};
pub use band::Band;
pub use board::{Board, KindRow, MethodRow, VERDICT};
pub use calibration::{Bin, Calibration};
pub use found::{Found, FoundBand};
pub use outcomes::{Outcomes, Share, wilson};
pub use paired::{AucDifference, Discordant, auc_of_all, compare_auc, compare_decisions};
pub use quantification::{Errors, Quantification};
pub use risk::RiskCoverage;
pub use scored::{Member, MethodResult, Scored, Truth};
pub use stiction_diagnose::methods::Counts;
pub use sureness::{SURE, Sureness};
pub use undecided::{HeldBack, Undecided};
