//! Batches of one recipe.

use super::parts::{Parts, Pi};
use super::sketch::Sketch;

/// Two to seven batches in the record. In each the set point moves by steps and ramps from hold to hold. Before it,
/// while the vessel is charged, the OP is preset, and the controller then continues from it without a bump.
pub(super) struct Recipe {
    /// Steps of a batch, and of its charging.
    batch: usize,
    charging: usize,
    /// The OP while charging, percent from rest.
    preset: f64,
    phases: Vec<Phase>,
}

/// A part of a batch.
struct Phase {
    /// Its start, steps from the start of the batch, and the duration of its ramp before it holds.
    begins: usize,
    ramps: f64,
    /// Its target, percent of span from rest.
    level: f64,
}

impl Recipe {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let batch = (sketch.recorded() as f64 / draw.uniform(2.0, 7.0)) as usize;
        let charging = (batch as f64 * draw.uniform(0.05, 0.15)) as usize;
        let reach = (sketch.size * draw.log(1.0, 4.0)).min(25.0);
        let count = draw.count(2, 5);
        let length = (batch - charging) as f64 / count as f64;
        let phases = (0..count)
            .map(|k| Phase {
                begins: charging + (k as f64 * length) as usize,
                ramps: if draw.chance(0.5) { length * draw.uniform(0.2, 0.8) } else { 0.0 },
                level: sketch.gain * reach * draw.uniform(-1.0, 1.0),
            })
            .collect();
        Self { batch, charging, preset: reach * draw.uniform(-1.0, 1.0), phases }
    }
}

impl Parts for Recipe {
    fn set_point(&mut self, k: usize) -> f64 {
        let place = k % self.batch;
        // During charging it stays at the end value of the batch before.
        let mut level = self.phases.last().map_or(0.0, |phase| phase.level);
        for phase in self.phases.iter().take_while(|phase| phase.begins <= place) {
            let gone = (place - phase.begins) as f64;
            let share = if gone < phase.ramps { gone / phase.ramps } else { 1.0 };
            level = (1.0 - share) * level + share * phase.level;
        }
        level
    }

    fn op(&mut self, k: usize, pi: &mut Pi, error: f64) -> f64 {
        if k % self.batch < self.charging {
            let op = (pi.rest + self.preset).clamp(0.0, 100.0);
            pi.track(op, error);
            return op;
        }
        pi.step(error)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn every_batch_is_like_the_one_before_and_begins_with_an_op_that_rests() {
        for (seed, sketch) in sketches(Invention::Recipe) {
            let mut parts = Recipe::of(&sketch);
            let batches = sketch.recorded() as f64 / parts.batch as f64;
            assert!((2.0..7.2).contains(&batches), "{batches}");
            let once: Vec<f64> = (0..parts.batch).map(|k| parts.set_point(k)).collect();
            let again: Vec<f64> =
                (0..parts.batch).map(|k| parts.set_point(k + parts.batch)).collect();
            assert_eq!(once, again);
            assert_eq!(*once.last().unwrap(), parts.phases.last().unwrap().level);
            // A ramp is no step: it takes a fifth of its phase.
            let levels =
                once.iter().filter(|v| parts.phases.iter().any(|p| p.level == **v)).count();
            assert!(levels > parts.batch / 5, "{levels} of {}", parts.batch);

            let mut pi = Pi::of(&sketch, 1.0);
            let op: Vec<f64> = (0..parts.charging + 1).map(|k| parts.op(k, &mut pi, 1.0)).collect();
            assert!(op[..parts.charging].iter().all(|u| *u == op[0]));
            let step = (pi.kc / pi.ti).abs();
            assert!((op[parts.charging] - op[0]).abs() <= step + 1e-9, "a bump at {seed}");
        }
    }
}
