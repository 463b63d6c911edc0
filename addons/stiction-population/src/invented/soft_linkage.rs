//! A soft linkage between stem and plug.

use super::parts::Parts;
use super::sketch::Sketch;

/// The flow follows the stem after some play, and softly.
pub(super) struct SoftLinkage {
    play: f64,
    plug: f64,
}

impl SoftLinkage {
    pub fn of(sketch: &Sketch) -> Self {
        Self { play: 0.08 * sketch.size, plug: 0.0 }
    }
}

impl Parts for SoftLinkage {
    fn flow(&mut self, _k: usize, stem: f64) -> f64 {
        let slack = (stem - self.plug).abs() - self.play;
        if slack > 0.0 {
            self.plug += 0.5 * slack * (stem - self.plug).signum();
        }
        self.plug
    }
}
