//! The one-parameter model of Stenman, Gustafsson and Forsman.

use super::published::Published;
use super::{Description, Motion, Start, Valve, ValveSpec};
use crate::error::{Result, non_negative};

/// Stenman, Gustafsson and Forsman's one-parameter model.
///
/// # Equations
/// ```text
/// |u(k) - x(k-1)| > d:   x = u
/// otherwise:             x stays
/// ```
/// It equals [`He`](super::He) with `S = J = d`.
///
/// # Parameters
/// `d`, percent of span. It is the slip jump `J`. The model has no dead band.
///
/// # Limits
/// Without offset between input and position it fails a dead-band test.
///
/// # References
/// A. Stenman, F. Gustafsson, K. Forsman, "A segmentation-based method for detection of stiction in
/// control valves", Int. J. Adapt. Control Signal Process. 17 (2003).
#[derive(Debug, Clone, PartialEq)]
pub struct Stenman {
    band: f64,
    position: f64,
}

impl Stenman {
    /// A valve that jumps when `d` is exceeded, at 0.
    ///
    /// # Errors
    /// If `d` is negative, NaN or infinite.
    pub fn new(d: f64) -> Result<Self> {
        Ok(Self { band: non_negative("d", d)?, position: 0.0 })
    }
}

impl Valve for Stenman {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        if (op - self.position).abs() > self.band {
            self.position = op;
        }
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        self.position = start.position;
    }
}

impl Published for Stenman {
    const DESCRIPTION: Description = Description {
        name: "stenman",
        aliases: &[],
        summary: "one parameter: jumps to the input once it is J away",
        citation: "Stenman, Gustafsson, Forsman, Int. J. Adapt. Control Signal Process. 17 (2003)",
        motion: Motion::Staircase,
        uses_s: false,
        uses_j: true,
        uses_k: false,
        uses_rest_tolerance: false,
        same_as: None,
    };

    fn build(spec: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Self::new(spec.bands.j())
    }
}
