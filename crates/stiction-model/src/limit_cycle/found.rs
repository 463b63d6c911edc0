//! The cycles of a loop by either method, in one form.

use super::exact::{self, CycleOutcome};
use super::harmonic_balance::{Balance, harmonic_balance};
use super::{ContinuousLoop, Cycle, Method};
use crate::error::Result;

/// The result of a search for cycles.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Found {
    /// The method.
    pub method: Method,
    /// Whether there is a cycle.
    pub state: State,
    /// Why there is no cycle, why that is not known, or the ends of other motions.
    pub notes: Vec<String>,
    /// The cycles. In a document, the cycles of all methods are together.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub cycles: Vec<Cycle>,
    /// Number of cycles that do not attract and were not requested.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub passed_over: usize,
}

crate::named! {
    /// Whether a loop cycles.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum State {
        /// It does.
        Cycle = "cycle",
        /// It does not.
        NoCycle = "no cycle",
        /// It is not known.
        Unknown = "not known",
    }
}

crate::written_by_name!(State);

impl Found {
    /// The final cycle of a loop or, with `all`, every cycle found, also those that do not attract.
    ///
    /// # Errors
    /// If the method cannot treat such a loop.
    pub fn of(l: &ContinuousLoop, method: Method, all: bool) -> Result<Self> {
        match method {
            Method::Exact => Ok(if all { exact::cycles(l) } else { exact::cycle(l) }?.into()),
            Method::DescribingFunction => Ok(Self::of_balance(harmonic_balance(l)?, all)),
        }
    }

    fn of_balance(balance: Balance, all: bool) -> Self {
        let (cycles, reason) = match balance {
            Balance::Cycles(cycles) => (cycles, None),
            Balance::None(reason) => (vec![], Some(reason.to_string())),
        };
        let known = cycles.len();
        let cycles: Vec<Cycle> = match all {
            true => cycles,
            false => cycles.into_iter().filter(|cycle| cycle.stable).take(1).collect(),
        };
        let none = || cycles.is_empty().then(|| "its cycles do not attract".to_owned());
        Self {
            method: Method::DescribingFunction,
            state: if cycles.is_empty() { State::NoCycle } else { State::Cycle },
            notes: reason.or_else(none).into_iter().collect(),
            passed_over: known - cycles.len(),
            cycles,
        }
    }

    /// An empty result, because the method cannot treat such a loop.
    pub fn refused(method: Method, reason: String) -> Self {
        Self { method, state: State::Unknown, notes: vec![reason], cycles: vec![], passed_over: 0 }
    }
}

impl From<CycleOutcome> for Found {
    fn from(outcome: CycleOutcome) -> Self {
        let (state, cycles, notes) = match outcome {
            CycleOutcome::Cycles { cycles, beside, unsettled } => {
                let beside = beside.iter().map(ToString::to_string);
                (State::Cycle, cycles, beside.chain(unsettled).collect())
            }
            CycleOutcome::None { reasons } => {
                (State::NoCycle, vec![], reasons.iter().map(ToString::to_string).collect())
            }
            CycleOutcome::NotFound { reason } => (State::Unknown, vec![], vec![reason]),
        };
        Self { method: Method::Exact, state, notes, cycles, passed_over: 0 }
    }
}
