//! The ideal valve.

use super::published::Published;
use super::{Description, Motion, Start, Valve, ValveSpec};
use crate::error::Result;

/// A valve without friction: `x = u`. The reference for all others.
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

impl Published for Ideal {
    const DESCRIPTION: Description = Description {
        name: "ideal",
        aliases: &["linear"],
        summary: "no friction: position equals input",
        citation: "identity",
        motion: Motion::Follows,
        uses_s: false,
        uses_j: false,
        uses_k: false,
        uses_rest_tolerance: false,
        same_as: None,
    };

    fn build(_: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Ok(Self::new())
    }
}
