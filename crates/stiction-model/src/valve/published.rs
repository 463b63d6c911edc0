//! What every published model has besides its motion: a description, a way to be built, and a memory.

use super::{Model, Start, Valve, ValveSpec};
use crate::error::{Error, Result};

/// What a [`Model`] is, in words and in properties.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Description {
    /// The name by which the model is asked for.
    pub name: &'static str,
    /// Other names it answers to.
    pub aliases: &'static [&'static str],
    /// What it does, in one line.
    pub summary: &'static str,
    /// Where it comes from.
    pub citation: &'static str,
    /// How it goes on after a slip.
    pub motion: Motion,
    /// Whether `S` makes a difference.
    pub uses_s: bool,
    /// Whether `J` makes a difference.
    pub uses_j: bool,
    /// Whether the overshoot `K` of a slip makes a difference.
    pub uses_k: bool,
    /// Whether a rest tolerance makes a difference.
    pub uses_rest_tolerance: bool,
    /// Another model whose positions are the same for every `J` up to `S`.
    pub same_as: Option<Model>,
}

/// How a stem moves while its input goes on in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// It has no friction.
    Follows,
    /// It slides along with the input after a slip.
    Slides,
    /// It rests after every sample, and climbs a ramp in steps.
    Staircase,
}

/// What a model remembers; unused places are 0.
pub(super) type Memory = [f64; 5];

/// A published model. What it remembers is where it is, unless it says otherwise.
pub(super) trait Published: Valve + Sized {
    /// What it is.
    const DESCRIPTION: Description;

    /// As `spec` has it, stuck at 0; limits and lag are not its concern.
    fn build(spec: &ValveSpec, sample_time: Option<f64>) -> Result<Self>;

    /// The state from which [`Valve::restart`] makes it go on as it does now; `None` if it remembers more.
    fn state(&self) -> Option<Start> {
        Some(Start::at_rest(self.position()))
    }

    /// Everything that the next sample depends on besides parameters and input.
    fn memory(&self) -> Memory {
        [self.position(), 0.0, 0.0, 0.0, 0.0]
    }

    /// Goes on from what a valve of the same model remembered, with any parameters.
    fn recall(&mut self, memory: &Memory) {
        self.restart(Start::at_rest(memory[0]));
    }
}

/// A yes or no among numbers.
pub(super) fn flag(yes: bool) -> f64 {
    f64::from(u8::from(yes))
}

/// The sample time, which a setting of that name needs.
pub(super) fn needed_by(setting: &'static str, sample_time: Option<f64>) -> Result<f64> {
    sample_time.ok_or(Error::Missing { name: "sample time".to_owned(), needed_by: setting })
}
