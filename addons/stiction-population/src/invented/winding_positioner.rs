//! A positioner with integral action.

use super::parts::{Friction, Parts};
use super::sketch::Sketch;

/// It integrates the stem's deviation once the deviation exceeds its dead band, and adds the integral to the OP. If the
/// valve sticks, it winds up until the stem slips, even at a constant OP. A healthy valve has no deviation.
pub(super) struct WindingPositioner {
    /// Its integral time, steps.
    time: f64,
    band: f64,
    /// Its present addition, percent.
    adds: f64,
}

impl WindingPositioner {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        Self {
            time: sketch.waiting() * draw.log(0.5, 8.0),
            band: sketch.s * draw.log(0.03, 0.4),
            adds: 0.0,
        }
    }
}

impl Parts for WindingPositioner {
    fn stem(&mut self, valve: &mut Friction, op: f64) -> f64 {
        let stem = valve.step(op + self.adds);
        let lack = op - stem;
        if lack.abs() > self.band {
            self.adds += lack / self.time;
        }
        stem
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn the_stem_moves_though_the_op_rests_and_without_friction_at_once() {
        for (seed, sketch) in sketches(Invention::WindingPositioner) {
            let (top, back) = (sketch.rest + 3.0 * sketch.s, sketch.rest + 2.1 * sketch.s);
            let first_move = |sticks: bool| {
                let mut parts = WindingPositioner::of(&sketch);
                let mut valve = Friction::of(&sketch, sticks).unwrap();
                (0..=100).for_each(|k| {
                    valve.step(sketch.rest + f64::from(k) / 100.0 * (top - sketch.rest));
                });
                // It moved up; within S it does not go back by itself.
                let (n, from) = ((20.0 * parts.time) as usize, valve.stem);
                (0..n).find(|_| parts.stem(&mut valve, back) < from)
            };
            assert_eq!(first_move(false), Some(0));
            assert!(first_move(true) > Some(0), "{seed}: {:?}", first_move(true));
        }
    }
}
