//! The two-layer binary tree of Chen, Tan and Huang.

use super::published::{Memory, Published};
use super::{Description, Direction, Motion, Start, Valve, ValveSpec};
use crate::bands::Bands;
use crate::error::Result;

/// Chen, Tan and Huang's two-layer binary tree model, as recalled: its chart was not at hand.
///
/// # Equations
/// Layer 1 checks whether the stem moves, layer 2 whether it breaks away. With `e = u(k) - x(k-1)`, `du = u(k) -
/// u(k-1)` and `d` the direction of motion:
/// ```text
/// moving, du d > 0:     x = u - d fd
/// moving, otherwise:    x stays, and the stem is stuck from the next sample on
/// stuck, |e| > fs:      d = sgn(e), x = u - d fd
/// stuck, otherwise:     x stays
/// ```
/// Unlike [`TwoPhase`](super::TwoPhase), the model does not check for breakaway at the sample at which the stem stops.
/// So a reversal larger than `S` within one sample takes effect one sample late. The revision by Li, Chen, Teo, Tan and
/// Lee (Ind. Eng. Chem. Res., 2014) removes this weakness.
///
/// # Parameters
/// [`Bands`] in percent of span; `J > S` is allowed.
///
/// # References
/// S.-L. Chen, K. K. Tan, S. Huang, "Two-layer binary tree data-driven model for valve stiction",
/// Ind. Eng. Chem. Res. 47 (2008) 2842-2848. Recalled, not read.
#[derive(Debug, Clone, PartialEq)]
pub struct Chen {
    bands: Bands,
    position: f64,
    op: f64,
    /// Direction of motion, `+1` or `-1`; `0` while stuck.
    motion: f64,
}

impl Chen {
    /// A valve with these friction bands, stuck at 0.
    pub fn new(bands: Bands) -> Self {
        Self { bands, position: 0.0, op: 0.0, motion: 0.0 }
    }
}

impl Valve for Chen {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let du = op - self.op;
        self.op = op;
        if self.motion != 0.0 {
            if self.motion * du > 0.0 {
                self.position = op - self.motion * self.bands.fd();
            } else {
                self.motion = 0.0;
            }
        } else {
            let e = op - self.position;
            if self.bands.breaks(e) {
                self.motion = 1f64.copysign(e);
                self.position = op - self.motion * self.bands.fd();
            }
        }
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        self.position = start.position;
        self.op = start.op;
        self.motion = if start.moving { start.direction.sign() } else { 0.0 };
    }
}

impl Published for Chen {
    const DESCRIPTION: Description = Description {
        name: "chen",
        aliases: &["xch"],
        summary: "two-layer binary tree; each reversal is one sample late (recalled)",
        citation: "Chen, Tan, Huang, Ind. Eng. Chem. Res. 47 (2008) 2842-2848",
        motion: Motion::Slides,
        uses_s: true,
        uses_j: true,
        uses_k: false,
        uses_rest_tolerance: false,
        same_as: None,
    };

    fn build(spec: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Ok(Self::new(spec.bands))
    }

    fn state(&self) -> Option<Start> {
        let direction = if self.motion < 0.0 { Direction::Down } else { Direction::Up };
        let moving = self.motion != 0.0;
        Some(Start { position: self.position, op: self.op, direction, moving })
    }

    fn memory(&self) -> Memory {
        [self.position, self.op, self.motion, 0.0, 0.0]
    }

    fn recall(&mut self, memory: &Memory) {
        [self.position, self.op, self.motion, ..] = *memory;
    }
}
