//! Pulsating flow, sampled about as fast as it pulsates.

use super::parts::Parts;
use super::sketch::Sketch;
use std::f64::consts::TAU;

/// Pulsation at the transmitter.
pub(super) struct Aliasing {
    size: f64,
    /// Steps a pulse.
    period: f64,
}

impl Aliasing {
    pub fn of(sketch: &Sketch) -> Self {
        let size = sketch.gain.abs() * sketch.size * 0.6;
        Self { size, period: sketch.steps as f64 * sketch.period }
    }
}

impl Parts for Aliasing {
    fn sensed(&mut self, k: usize, pv: f64, noise: f64) -> f64 {
        pv + noise + self.size * (TAU * (k as f64 / self.period)).sin()
    }
}
