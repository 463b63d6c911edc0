//! A verdict in one graded word, for a first look.
//!
//! # Rule
//! | Grade | Condition |
//! |---|---|
//! | sticks | The verdict accuses the valve |
//! | probably sticks | Evidence makes it [likely](PROBABLY_FROM), but does not accuse |
//! | unclear | The probability is between the limits, or the recording is unlike the training |
//! | probably fine | Evidence makes sticking [unlikely](PROBABLY_FINE_UP_TO), but does not clear the valve |
//! | no stiction visible | The verdict clears the valve, but the recording could mask an S above [`FINE_UP_TO`] |
//! | too little to matter | The valve sticks by its probability, but S is too small to be a fault |
//! | fine | The verdict clears the valve, and the detection limit is at most [`FINE_UP_TO`] |
//! | does not respond | The OP travels, the flow or the stem does not |
//! | data cannot answer | The data are unfit, or their columns look mistaken |
//! # Limits
//! "Probably" is not a verdict: [`VerdictClass`] stays "cannot tell", and a test is the next step.
//! `docs/accuracy.md` reports how often each grade is right on simulated loops.

use super::by_evidence::Ruling;
use super::diagnosis::Diagnosis;
use super::verdict::{Basis, Grade, VerdictClass};
use crate::recording::fitness::Class;

/// Probability from which a valve that is not accused probably sticks.
pub const PROBABLY_FROM: f64 = 0.8;
/// Probability up to which a valve that is not cleared is probably fine.
pub const PROBABLY_FINE_UP_TO: f64 = 0.2;
/// Detection limit up to which a cleared valve is fine, percent of span; ours.
pub const FINE_UP_TO: f64 = 3.0;

impl Grade {
    /// The grade of several recordings of a valve together: by their conclusion, else by their probability.
    pub(super) fn of_several(class: VerdictClass, probability: Option<f64>) -> Self {
        match (class, probability) {
            (VerdictClass::Sticks, _) => Self::Sticks,
            (VerdictClass::DoesNotStick, _) => Self::Fine,
            (VerdictClass::DoesNotRespond, _) => Self::DoesNotRespond,
            (VerdictClass::CannotTell, None) => Self::CannotAnswer,
            (VerdictClass::CannotTell, Some(p)) => Self::undecided(p),
        }
    }

    /// The grade of a probability that decides nothing.
    fn undecided(probability: f64) -> Self {
        match probability {
            p if p >= PROBABLY_FROM => Self::ProbablySticks,
            p if p <= PROBABLY_FINE_UP_TO => Self::ProbablyFine,
            _ => Self::Unclear,
        }
    }

    /// The grade of a loop whose S matters from `fine_up_to` percent on; see the [rule](self).
    pub(super) fn of(diagnosis: &Diagnosis, fine_up_to: f64) -> Self {
        let verdict = &diagnosis.verdict;
        match (verdict.class, verdict.basis) {
            (VerdictClass::DoesNotRespond, _) => Self::DoesNotRespond,
            (VerdictClass::Sticks, _) => Self::Sticks,
            (VerdictClass::DoesNotStick, Basis::ValvePosition) => Self::Fine,
            (VerdictClass::DoesNotStick, _) => match verdict.s_below {
                Some(limit) if limit.value <= fine_up_to => Self::Fine,
                _ => Self::NoneVisible,
            },
            _ if diagnosis.mistaken().is_some() || diagnosis.segment().is_none() => {
                Self::CannotAnswer
            }
            (_, Basis::ValvePosition) => Self::Unclear,
            _ if diagnosis.fitness.class == Class::Unfit => Self::CannotAnswer,
            _ => match diagnosis.undecided_by() {
                Some(Ruling::Mistaken) => Self::CannotAnswer,
                Some(Ruling::Harmless) => Self::TooLittle,
                Some(Ruling::Strange) => Self::Unclear,
                _ => verdict.probability.map_or(Self::Unclear, Self::undecided),
            },
        }
    }
}
