//! A verdict in one graded word: what an engineer reads first.
//!
//! # Rule
//! | grade | where |
//! |---|---|
//! | sticks | the verdict accuses the valve |
//! | probably sticks | the evidence makes it [likely](PROBABLY_FROM), but does not accuse; or families of published methods say so |
//! | unclear | the probability lies between, or the recording is unlike the training |
//! | probably fine | the evidence makes sticking [unlikely](PROBABLY_FINE_UP_TO), but does not clear; or what sticks is too little to be a fault |
//! | fine | the verdict clears the valve |
//! | does not respond | the output travels, the flow or the stem does not |
//! | data cannot answer | the data are unfit, or their columns look mistaken |
//!
//! # Limits
//! "Probably" is no verdict: [`VerdictClass`] stays "cannot tell" there, and a test is the next step. How often each
//! grade is right on simulated loops stands in `docs/accuracy.md`.

use super::by_evidence::Ruling;
use super::diagnosis::Diagnosis;
use super::verdict::{Basis, Grade, VerdictClass};
use crate::recording::fitness::Class;

/// The probability from which a valve that is not accused probably sticks.
pub const PROBABLY_FROM: f64 = 0.8;
/// The probability up to which a valve that is not cleared is probably fine.
pub const PROBABLY_FINE_UP_TO: f64 = 0.2;

impl Grade {
    /// What is said of several recordings of a valve together: by their conclusion, else by their probability.
    pub(super) fn of_several(class: VerdictClass, probability: Option<f64>) -> Self {
        match (class, probability) {
            (VerdictClass::Sticks, _) => Self::Sticks,
            (VerdictClass::DoesNotStick, _) => Self::Fine,
            (VerdictClass::DoesNotRespond, _) => Self::DoesNotRespond,
            (VerdictClass::CannotTell, None) => Self::CannotAnswer,
            (VerdictClass::CannotTell, Some(p)) => Self::undecided(p),
        }
    }

    /// What is said of a probability that decides nothing.
    fn undecided(probability: f64) -> Self {
        match probability {
            p if p >= PROBABLY_FROM => Self::ProbablySticks,
            p if p <= PROBABLY_FINE_UP_TO => Self::ProbablyFine,
            _ => Self::Unclear,
        }
    }

    /// What is said of a loop; see the [rule](self).
    pub(super) fn of(diagnosis: &Diagnosis) -> Self {
        let verdict = &diagnosis.verdict;
        match (verdict.class, verdict.basis) {
            (VerdictClass::DoesNotRespond, _) => Self::DoesNotRespond,
            (VerdictClass::Sticks, Basis::Majority) => Self::ProbablySticks,
            (VerdictClass::Sticks, _) => Self::Sticks,
            (VerdictClass::DoesNotStick, Basis::Majority) => Self::ProbablyFine,
            (VerdictClass::DoesNotStick, _) => Self::Fine,
            _ if diagnosis.mistaken().is_some() || diagnosis.segment().is_none() => {
                Self::CannotAnswer
            }
            (_, Basis::ValvePosition) => Self::Unclear,
            _ if diagnosis.fitness.class == Class::Unfit => Self::CannotAnswer,
            _ => match diagnosis.undecided_by() {
                Some(Ruling::Mistaken) => Self::CannotAnswer,
                // What would stick is too little to be a fault.
                Some(Ruling::Harmless) => Self::ProbablyFine,
                Some(Ruling::Strange) => Self::Unclear,
                _ => verdict.probability.map_or(Self::Unclear, Self::undecided),
            },
        }
    }
}
