//! A positioner that rings.

use super::parts::Parts;
use super::sketch::Sketch;
use std::f64::consts::TAU;

/// The flow follows the stem through a resonance.
pub(super) struct RingingPositioner {
    /// Angular frequency, radians a step, and damping.
    w: f64,
    damping: f64,
    place: f64,
    speed: f64,
}

impl RingingPositioner {
    pub fn of(sketch: &Sketch) -> Self {
        Self { w: TAU / sketch.period, damping: sketch.share, place: 0.0, speed: 0.0 }
    }
}

impl Parts for RingingPositioner {
    fn steepest(&self) -> f64 {
        2.0
    }

    fn flow(&mut self, _k: usize, stem: f64) -> f64 {
        // Semi-implicit Euler keeps the resonance frequency.
        let w = self.w;
        self.speed += w * w * (stem - self.place) - 2.0 * self.damping * w * self.speed;
        self.place += self.speed;
        self.place
    }
}
