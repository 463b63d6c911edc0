//! A neighbour that is switched by the PV.

use super::parts::Parts;
use super::sketch::Sketch;

/// It comes on where the PV is low and goes off where it is high.
pub(super) struct OnOffNeighbour {
    /// How far the PV goes before it is switched, percent of span.
    band: f64,
    /// What it adds while it runs, and takes while it does not.
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
