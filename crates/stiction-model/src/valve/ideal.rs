//! The ideal valve.

use super::memory::{Memory, Remember};
use super::{Start, Valve};

/// A valve without friction: `x = u`. The yardstick for all others.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ideal {
    position: f64,
}

impl Ideal {
    /// A valve at 0.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Valve for Ideal {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        self.position = op;
        op
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        self.position = start.position;
    }
}

impl Remember for Ideal {
    fn memory(&self) -> Memory {
        [self.position, 0.0, 0.0, 0.0, 0.0]
    }

    fn recall(&mut self, memory: &Memory) {
        self.position = memory[0];
    }
}
