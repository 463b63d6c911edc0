//! From controller output to valve position, sample by sample: one model, one file.

mod assembly;
mod chen;
mod choudhury;
mod he;
mod ideal;
mod kano;
pub mod lanes;
mod model;
mod play;
mod published;
mod spec;
mod stem_lag;
mod stenman;
mod two_phase;

pub use assembly::Assembly;
pub use chen::Chen;
pub use choudhury::Choudhury;
pub use he::{He, HeWang};
pub use ideal::Ideal;
pub use kano::Kano;
pub use model::{AnyModel, Model};
pub use play::Play;
pub use published::{Description, Motion};
pub use spec::ValveSpec;
pub use stem_lag::StemLag;
pub use stenman::Stenman;
pub use two_phase::TwoPhase;

use crate::error::{Error, Result, all_finite, finite};

/// A direction of stem travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// Towards larger positions.
    #[default]
    Up,
    /// Towards smaller positions.
    Down,
}

impl Direction {
    /// `+1.0` for up, `-1.0` for down.
    pub fn sign(self) -> f64 {
        match self {
            Self::Up => 1.0,
            Self::Down => -1.0,
        }
    }
}

/// The initial state of a valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Valve position, percent of span.
    pub position: f64,
    /// Controller output before the first sample, percent of span.
    pub op: f64,
    /// Direction of the last motion.
    pub direction: Direction,
    /// Whether the stem is moving in that direction; otherwise it is stuck.
    pub moving: bool,
}

impl Start {
    /// Stuck at `position`, with the controller output resting there too, last moved up.
    pub fn at_rest(position: f64) -> Self {
        Self { position, op: position, direction: Direction::Up, moving: false }
    }
}

impl Default for Start {
    fn default() -> Self {
        Self::at_rest(0.0)
    }
}

/// A valve: controller output (OP) in, valve position (VP) out, both in percent of span.
pub trait Valve {
    /// The valve position once the controller output has become `op`.
    ///
    /// `op` must be finite; [`Valve::run`] checks, this does not.
    fn step(&mut self, op: f64) -> f64;

    /// The present valve position.
    fn position(&self) -> f64;

    /// Restarts from `start`.
    fn restart(&mut self, start: Start);

    /// Processes the whole of `op`, writing the position after each sample to `vp`. Nothing is allocated.
    ///
    /// # Errors
    /// If the slices differ in length, or a sample of `op` is NaN or infinite; the valve has then not moved.
    fn run(&mut self, op: &[f64], vp: &mut [f64]) -> Result<()> {
        follow(self, op, vp)
    }
}

/// Processes the whole of `op` step by step: [`Valve::run`] by default.
fn follow<V: Valve + ?Sized>(valve: &mut V, op: &[f64], vp: &mut [f64]) -> Result<()> {
    if op.len() != vp.len() {
        return Err(Error::Length { name: "vp", found: vp.len(), expected: op.len() });
    }
    all_finite("op", op)?;
    for (u, x) in op.iter().zip(vp) {
        *x = valve.step(*u);
    }
    Ok(())
}

impl Start {
    /// This start, if its numbers are finite.
    pub(crate) fn checked(self) -> Result<Self> {
        finite("start position", self.position)?;
        finite("start OP", self.op)?;
        Ok(self)
    }
}
