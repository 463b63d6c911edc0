//! A transmitter with more damping at small changes.

use super::parts::Parts;
use super::sketch::Sketch;

/// Its time constant is long if the PV is near its output, and zero if the PV differs by a width or more. Noise is
/// damped, a step is not, and the controller sees hardly any small changes.
pub(super) struct AdaptiveDamping {
    /// The share of a small difference that the output follows in a step, and the difference from which it follows at
    /// once, percent of span.
    least: f64,
    width: f64,
    says: f64,
}

impl AdaptiveDamping {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        Self {
            least: 1.0 / (sketch.waiting() * draw.log(1.0, 10.0)),
            width: sketch.gain.abs() * sketch.s * draw.log(0.2, 1.0),
            says: 0.0,
        }
    }
}

impl Parts for AdaptiveDamping {
    fn sensed(&mut self, _k: usize, pv: f64, noise: f64) -> f64 {
        let away = pv + noise - self.says;
        self.says += away * (self.least + (away / self.width).powi(2)).min(1.0);
        self.says
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn it_follows_a_large_step_at_once_and_a_small_one_late() {
        for (seed, sketch) in sketches(Invention::AdaptiveDamping) {
            let follow = |step: f64, n: usize| {
                let mut parts = AdaptiveDamping::of(&sketch);
                let step = step * parts.width;
                (0..n).map(|k| parts.sensed(k, step, 0.0)).last().unwrap() / step
            };
            assert_eq!(follow(-1.0, 1), 1.0);
            // By its least share, as long as the square of a hundredth is less than that.
            let small = follow(0.01, 1);
            let least = AdaptiveDamping::of(&sketch).least;
            assert!((small - least - 1e-4).abs() < 1e-9 && least < 0.5, "{small} {least}");
            let waits = (1.0 / least) as usize;
            assert!((0.5..0.8).contains(&follow(0.01, waits)), "{seed}");
        }
    }
}
