//! Play (backlash): a pure dead band.

use super::published::Published;
use super::{Description, Motion, Start, Valve, ValveSpec};
use crate::error::{Result, non_negative};

/// Play, or backlash: a pure dead band `S`.
///
/// # Equations
/// ```text
/// x = clamp(x(k-1), u - S/2, u + S/2)
/// ```
/// For `J = 0` every two-parameter model here equals it.
///
/// # Parameters
/// `S`, the whole width of the dead band, percent of span. There is no slip jump.
///
/// # References
/// The play operator of hysteresis theory (M. A. Krasnosel'skii, A. V. Pokrovskii, 1989).
#[derive(Debug, Clone, PartialEq)]
pub struct Play {
    half_width: f64,
    position: f64,
}

impl Play {
    /// A valve with dead band `s`, at 0.
    ///
    /// # Errors
    /// If `s` is negative, NaN or infinite.
    pub fn new(s: f64) -> Result<Self> {
        Ok(Self { half_width: non_negative("S", s)? / 2.0, position: 0.0 })
    }
}

impl Valve for Play {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let (low, high) = (op - self.half_width, op + self.half_width);
        if self.position < low {
            self.position = low;
        } else if self.position > high {
            self.position = high;
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

impl Published for Play {
    const DESCRIPTION: Description = Description {
        name: "play",
        aliases: &["backlash", "deadband"],
        summary: "pure dead band S, no slip jump",
        citation: "play operator, Krasnosel'skii and Pokrovskii (1989)",
        motion: Motion::Slides,
        uses_s: true,
        uses_j: false,
        uses_k: false,
        uses_rest_tolerance: false,
        same_as: None,
    };

    fn build(spec: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Self::new(spec.bands.s())
    }
}
