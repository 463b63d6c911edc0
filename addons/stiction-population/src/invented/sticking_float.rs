//! A sensor that sticks.

use super::parts::Parts;
use super::sketch::Sketch;

/// A float that rubs in its guide, or a displacer, holds its reading while the PV moves, and slips. The controller
/// integrates the error of the reading, so even a loop with a healthy valve may cycle.
pub(super) struct StickingFloat {
    /// Distance between PV and reading at which it slips, and the distance that remains then, percent of span.
    holds: f64,
    leaves: f64,
    reads: f64,
    /// Start of the record, number of its steps, and number of its slips.
    begins: usize,
    recorded: usize,
    slips: usize,
}

impl StickingFloat {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let holds = sketch.gain.abs() * sketch.size * draw.log(0.05, 0.4);
        Self {
            holds,
            leaves: holds * draw.uniform(0.0, 0.9),
            reads: 0.0,
            begins: sketch.warm_up(),
            recorded: sketch.recorded(),
            slips: 0,
        }
    }
}

impl Parts for StickingFloat {
    fn sensed(&mut self, k: usize, pv: f64, noise: f64) -> f64 {
        let away = pv - self.reads;
        if away.abs() > self.holds {
            self.reads = pv - self.leaves * away.signum();
            self.slips += usize::from(k >= self.begins);
        }
        self.reads + noise
    }

    fn shows(&self) -> bool {
        self.slips >= 5 && self.slips <= self.recorded / 2
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn it_holds_its_reading_and_then_slips_almost_to_the_pv() {
        for (seed, sketch) in sketches(Invention::StickingFloat) {
            let mut parts = StickingFloat::of(&sketch);
            let (holds, leaves) = (parts.holds, parts.leaves);
            assert_eq!(parts.sensed(0, 0.99 * holds, 0.0), 0.0);
            assert_eq!(parts.sensed(0, -0.99 * holds, 0.1), 0.1);
            let slipped = parts.sensed(0, 1.01 * holds, 0.0);
            assert!((slipped - (1.01 * holds - leaves)).abs() < 1e-9 && slipped > 0.0);
            // The other way it first takes up what it left.
            assert_eq!(parts.sensed(0, slipped - 0.99 * holds, 0.0), slipped);
            let back = parts.sensed(0, slipped - 1.01 * holds, 0.0);
            assert!((back - (slipped - 1.01 * holds + leaves)).abs() < 1e-9, "{seed}");
        }
    }
}
