//! The model of Kano and co-workers.

use super::published::{Memory, Published, flag};
use super::{Description, Model, Motion, Start, Valve, ValveSpec};
use crate::bands::Bands;
use crate::error::Result;

/// Kano, Maruta, Kugemoto and Shimizu's two-parameter model.
///
/// # Equations
/// With `du = u(k) - u(k-1)`, `d` the direction of motion and `us` the input at which it stopped:
/// ```text
/// moving and du du_prev <= 0:   stops, us = u(k-1)
/// moving:                       x = u - d fd
/// stuck, -d (u - us) > S:       d = -d, x = u - d fd      breaks away, reversing
/// stuck,  d (u - us) > J:       x = u - d fd              breaks away, resuming
/// ```
/// A stem that stopped rests at `x = us - d fd`, so both tests are equal to `|u - x| > fs`. They have this form
/// here, so that rounding cannot make this model differ from the others at a threshold.
///
/// # Parameters
/// [`Bands`] in percent of span; `J > S` is allowed.
///
/// # References
/// M. Kano, H. Maruta, H. Kugemoto, K. Shimizu, "Practical model and detection algorithm for valve
/// stiction", IFAC DYCOPS, 2004. Algorithm as two independent public programs state it.
#[derive(Debug, Clone, PartialEq)]
pub struct Kano {
    bands: Bands,
    position: f64,
    op: f64,
    du: f64,
    direction: f64,
    moving: bool,
}

impl Kano {
    /// A valve with these friction bands, stuck at 0.
    pub fn new(bands: Bands) -> Self {
        Self { bands, position: 0.0, op: 0.0, du: 0.0, direction: 1.0, moving: false }
    }
}

impl Valve for Kano {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let du = op - self.op;
        // The signs' product, because the product of two tiny changes can underflow to zero.
        if self.moving && !((du > 0.0 && self.du > 0.0) || (du < 0.0 && self.du < 0.0)) {
            self.moving = false;
        }
        if !self.moving {
            let e = op - self.position;
            if self.bands.breaks(e) {
                self.direction = 1f64.copysign(e);
                self.moving = true;
            }
        }
        if self.moving {
            self.position = op - self.direction * self.bands.fd();
        }
        self.op = op;
        self.du = du;
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        let direction = start.direction.sign();
        *self = Self {
            bands: self.bands,
            position: start.position,
            op: start.op,
            du: if start.moving { direction } else { 0.0 },
            direction,
            moving: start.moving,
        };
    }
}

impl Published for Kano {
    const DESCRIPTION: Description = Description {
        name: "kano",
        aliases: &[],
        summary: "equals two-phase",
        citation: "Kano, Maruta, Kugemoto, Shimizu, IFAC DYCOPS (2004)",
        motion: Motion::Slides,
        uses_s: true,
        uses_j: true,
        uses_k: false,
        uses_rest_tolerance: false,
        same_as: Some(Model::TwoPhase),
    };

    fn build(spec: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Ok(Self::new(spec.bands))
    }

    fn state(&self) -> Option<Start> {
        None
    }

    fn memory(&self) -> Memory {
        [self.position, self.op, self.du, self.direction, flag(self.moving)]
    }

    fn recall(&mut self, memory: &Memory) {
        let moving;
        [self.position, self.op, self.du, self.direction, moving] = *memory;
        self.moving = moving != 0.0;
    }
}
