//! The common interface of the published models besides motion: a description, a constructor, and a memory.

use super::{Model, Start, Valve, ValveSpec};
use crate::error::{Error, Result};

/// The description of a published valve model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", schemars(rename = "ValveModel"))]
pub struct Description {
    /// Name in commands.
    pub name: &'static str,
    /// Other names.
    pub aliases: &'static [&'static str],
    /// Principle, in one line.
    pub summary: &'static str,
    /// Source of the model.
    pub citation: &'static str,
    /// Motion after a slip.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub motion: Motion,
    /// Whether the model uses `S`.
    pub uses_s: bool,
    /// Whether the model uses `J`.
    pub uses_j: bool,
    /// Whether the model uses the overshoot `K` of a slip.
    pub uses_k: bool,
    /// Whether the model uses a rest tolerance.
    pub uses_rest_tolerance: bool,
    /// Another model whose positions are the same for every `J` up to `S`.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub same_as: Option<Model>,
}

/// Motion of a stem while its input continues in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// It has no friction.
    Follows,
    /// It slides along with the input after a slip.
    Slides,
    /// It rests after every sample, and climbs a ramp in steps.
    Staircase,
}

/// The memory of a model; unused entries are 0.
pub(super) type Memory = [f64; 5];

/// A published model. By default its memory is its position.
pub(super) trait Published: Valve + Sized {
    /// Description.
    const DESCRIPTION: Description;

    /// Builds it from `spec`, stuck at 0, without limits and lag.
    fn build(spec: &ValveSpec, sample_time: Option<f64>) -> Result<Self>;

    /// The state from which [`Valve::restart`] continues the present motion; `None` if the model's memory is larger.
    fn state(&self) -> Option<Start> {
        Some(Start::at_rest(self.position()))
    }

    /// Everything that determines the next sample besides parameters and input.
    fn memory(&self) -> Memory {
        [self.position(), 0.0, 0.0, 0.0, 0.0]
    }

    /// Continues from the memory of a valve of the same model, with any parameters.
    fn recall(&mut self, memory: &Memory) {
        self.restart(Start::at_rest(memory[0]));
    }
}

/// A yes or no among numbers.
pub(super) fn flag(yes: bool) -> f64 {
    f64::from(u8::from(yes))
}

/// The sample time, needed by a setting of that name.
pub(super) fn needed_by(setting: &'static str, sample_time: Option<f64>) -> Result<f64> {
    sample_time.ok_or(Error::Missing { name: "sample time".to_owned(), needed_by: setting })
}
