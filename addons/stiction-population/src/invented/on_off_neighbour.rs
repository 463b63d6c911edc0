//! A neighbour that is switched by the PV.

use super::parts::Parts;
use super::sketch::Sketch;

/// It starts when the PV is low and stops when it is high.
pub(super) struct OnOffNeighbour {
    /// Distance of the PV that switches it, percent of span.
    band: f64,
    /// Effect while the neighbour runs, and effect while it stands.
    adds: f64,
    runs: bool,
}

impl OnOffNeighbour {
    pub fn of(sketch: &Sketch) -> Self {
        let band = 0.4 * sketch.gain.abs() * sketch.size;
        Self { band, adds: sketch.gain.signum() * sketch.size, runs: false }
    }
}

impl Parts for OnOffNeighbour {
    fn load(&mut self, pv: f64) -> f64 {
        if pv < -self.band {
            self.runs = true;
        } else if pv > self.band {
            self.runs = false;
        }
        if self.runs { self.adds } else { -self.adds }
    }
}
