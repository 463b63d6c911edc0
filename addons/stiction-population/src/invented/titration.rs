//! A titration.

use super::parts::Parts;
use super::sketch::Sketch;

/// Steep around the set point, flat away from it.
pub(super) struct Titration {
    width: f64,
}

impl Titration {
    pub fn of(sketch: &Sketch) -> Self {
        Self { width: 0.6 * sketch.gain.abs() * sketch.size }
    }
}

impl Parts for Titration {
    fn steepest(&self) -> f64 {
        3.0
    }

    fn pv(&mut self, lagged: f64) -> f64 {
        let width = self.width;
        width * (3.0 * (lagged / width).tanh() + 0.3 * lagged / width)
    }
}
