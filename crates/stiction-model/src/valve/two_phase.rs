//! The two-phase model: stuck, or moving.

use super::published::{Memory, Published, needed_by};
use super::{Description, Direction, Motion, Start, Valve, ValveSpec};
use crate::bands::Bands;
use crate::error::{Result, non_negative, positive};

/// The paper's data-driven model with two parameters.
///
/// # Model
/// A stem is either *stuck* or *moving*. A moving stem trails the input by the dynamic friction band, and stops
/// when the input pauses or reverses. A stuck stem stays until the net spring force exceeds the static friction
/// band, and then jumps.
///
/// # Equations
/// With `du = u(k) - u(k-1)`, `e = u(k) - x(k-1)` and `d = +1` or `-1` the direction of motion:
/// ```text
/// moving and du d > 0:   x = u - d fd                                   keeps moving
/// otherwise, |e| > fs:   d = sgn(e), x = u - d fd                       slips
/// otherwise:             x stays                                        stuck
/// ```
///
/// # Parameters
/// [`Bands`] in percent of span; `J > S` is allowed and makes each slip overshoot the input. The
/// rest tolerance (default 0 %/s) is the input speed at and below which a moving stem comes to rest.
///
/// # Assumptions and limits
/// The stem itself has no dynamics: add a [`StemLag`](super::StemLag) where they matter. A reversal of `u` as small
/// as measurement noise stops the stem, so a noisy ramp becomes stick-slip.
///
/// # References
/// "Modelling and Dynamic Analysis of Pneumatic Control Valve with Stiction", section 5, interpreted as a state
/// machine. For `J <= S` it equals [`Kano`](super::Kano) and [`Choudhury`](super::Choudhury) sample for sample
/// (property-tested).
#[derive(Debug, Clone, PartialEq)]
pub struct TwoPhase {
    bands: Bands,
    /// Change of input per sample at and below which a moving stem comes to rest.
    rest: f64,
    position: f64,
    op: f64,
    /// Direction of motion, `+1` or `-1`; `0` while stuck. (The last direction does not matter.)
    motion: f64,
}

impl TwoPhase {
    /// A valve with these friction bands, stuck at 0.
    pub fn new(bands: Bands) -> Self {
        Self { bands, rest: 0.0, position: 0.0, op: 0.0, motion: 0.0 }
    }

    /// Treats an input slower than `speed` (percent of span per second), sampled every `sample_time` seconds, as a
    /// pause: a moving stem comes to rest.
    ///
    /// # Errors
    /// If `speed` is negative or `sample_time` is not positive, or either is not finite.
    pub fn with_rest_tolerance(mut self, speed: f64, sample_time: f64) -> Result<Self> {
        self.rest = non_negative("rest tolerance", speed)? * positive("sample time", sample_time)?;
        Ok(self)
    }

    /// The friction bands.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// Whether [`lanes`](super::lanes) can replace it: they have no rest tolerance.
    pub(crate) fn is_laned(&self) -> bool {
        self.rest == 0.0
    }
}

impl Valve for TwoPhase {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let du = op - self.op;
        self.op = op;
        if self.motion * du > self.rest {
            self.position = op - self.motion * self.bands.fd();
        } else {
            let e = op - self.position;
            if self.bands.breaks(e) {
                self.motion = 1f64.copysign(e);
                self.position = op - self.motion * self.bands.fd();
            } else {
                self.motion = 0.0;
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

impl Published for TwoPhase {
    const DESCRIPTION: Description = Description {
        name: "two-phase",
        aliases: &["twophase", "two_phase"],
        summary: "stuck or moving; slides after a slip until the input pauses or reverses",
        citation: "Modelling and Dynamic Analysis of Pneumatic Control Valve with Stiction",
        motion: Motion::Slides,
        uses_s: true,
        uses_j: true,
        uses_k: false,
        uses_rest_tolerance: true,
        same_as: None,
    };

    fn build(spec: &ValveSpec, sample_time: Option<f64>) -> Result<Self> {
        let valve = Self::new(spec.bands);
        let Some(speed) = spec.rest_tolerance else { return Ok(valve) };
        valve.with_rest_tolerance(speed, needed_by("rest tolerance", sample_time)?)
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
