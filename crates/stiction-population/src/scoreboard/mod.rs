//! How often methods, and the verdict, are right, on loops whose truth is known.
//!
//! ```text
//! Diagnosis + Truth ──> Scored ──┬──> Outcomes   recall, false alarms, precision, abstention
//!                                ├──> Auc        how well a statistic ranks
//!                                ├──> Calibration  what a probability is worth
//!                                ├──> Quantification  what S and J are worth
//!                                ├──> Sureness       what limits and sure probabilities are worth
//!                                ├──> Found          how many sticking valves are found, by how plainly they show
//!                                └──> Undecided      what holds decisions back
//! ```
//!
//! A [`Scored`] keeps of a diagnosis what is counted, so that populations of any size can be scored; a
//! [`Board`] is all that is counted of them. Nothing is fitted: thresholds are those of the methods.
//!
//! Loops whose valve sticks without the recording being able to show it ([`Truth::visible`]) belong to
//! neither class; they are left out of every measure and counted apart.

mod auc;
mod band;
mod board;
mod calibration;
#[cfg(feature = "serde")]
mod document;
mod found;
mod outcomes;
mod quantification;
mod scored;
mod sureness;
mod undecided;

pub use auc::{Auc, DRAWS, Ranked, auc, by_valve, logit, roc};
pub use band::Band;
pub use board::{Board, KindRow, MethodRow, VERDICT};
pub use calibration::{Bin, Calibration};
pub use found::{Found, FoundBand};
pub use outcomes::{Outcomes, Share, wilson};
pub use quantification::{Errors, Quantification};
pub use scored::{Member, Said, Scored, Truth};
pub use stiction_diagnose::methods::Counts;
pub use sureness::{SURE, Sureness};
pub use undecided::{HeldBack, Undecided};
