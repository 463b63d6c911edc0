//! What a method says of the cycles of a loop, in one form for both.

use super::exact::{self, Outcome};
use super::harmonic_balance::{Balance, harmonic_balance};
use super::{ContinuousLoop, Cycle, Method};
use crate::error::Result;

/// What a search for cycles has found.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Found {
    /// How it was searched.
    pub method: Method,
    /// Whether there is a cycle.
    pub state: State,
    /// Why there is no cycle, why that is not known, or what other motions do.
    pub notes: Vec<String>,
    /// The cycles; those of all methods stand together in a document.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub cycles: Vec<Cycle>,
}

/// Whether a loop cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It does.
    Cycle,
    /// It does not.
    NoCycle,
    /// It is not known.
    Unknown,
}

crate::written_by_name!(State);

impl State {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cycle => "cycle",
            Self::NoCycle => "no cycle",
            Self::Unknown => "not known",
        }
    }
}

impl Found {
    /// The cycle in which a loop ends, or, of `all`, every one that is found, also those that do not attract.
    ///
    /// # Errors
    /// If the method cannot treat such a loop.
    pub fn of(l: &ContinuousLoop, method: Method, all: bool) -> Result<Self> {
        Ok(match method {
            Method::Exact => if all { exact::cycles(l) } else { exact::cycle(l) }?.into(),
            Method::DescribingFunction => {
                let (cycles, note) = match harmonic_balance(l)? {
                    Balance::Cycles(cycles) if all => (cycles, None),
                    Balance::Cycles(cycles) => match cycles.into_iter().find(|c| c.stable) {
                        Some(cycle) => (vec![cycle], None),
                        None => (vec![], Some("its cycles do not attract".to_owned())),
                    },
                    Balance::None(reason) => (vec![], Some(reason.to_string())),
                };
                let state = if cycles.is_empty() { State::NoCycle } else { State::Cycle };
                Self { method, state, notes: note.into_iter().collect(), cycles }
            }
        })
    }

    /// Nothing, because the method cannot treat such a loop.
    pub fn refused(method: Method, reason: String) -> Self {
        Self { method, state: State::Unknown, notes: vec![reason], cycles: vec![] }
    }
}

impl From<Outcome> for Found {
    fn from(outcome: Outcome) -> Self {
        let (state, cycles, notes) = match outcome {
            Outcome::Cycles { cycles, beside, unsettled } => {
                let beside = beside.iter().map(ToString::to_string);
                (State::Cycle, cycles, beside.chain(unsettled).collect())
            }
            Outcome::None { reasons } => {
                (State::NoCycle, vec![], reasons.iter().map(ToString::to_string).collect())
            }
            Outcome::NotFound { reason } => (State::Unknown, vec![], vec![reason]),
        };
        Self { method: Method::Exact, state, notes, cycles }
    }
}
