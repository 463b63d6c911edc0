//! A controller that knocks.

use super::parts::{Parts, Pi};
use super::sketch::Sketch;

/// Somebody who assumed a sticking valve has switched a knocker on. It sends short pulses in the direction in which the
/// OP moves, like [`Knocker`](stiction_model::compensate::Knocker). They stay in the OP, even if the valve is in order.
/// A historian that is slower than the controller records some of them.
pub(super) struct Knocker {
    /// Height of a pulse, percent; duration of a pulse, and distance to the next, steps.
    height: f64,
    width: usize,
    every: usize,
    /// The present pulse, percent, and the OP without pulses at the last one.
    pulse: f64,
    before: f64,
}

impl Knocker {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let width = draw.count(1, 3);
        Self {
            height: sketch.size * draw.log(0.1, 0.6),
            width,
            every: width * draw.count(2, 6),
            pulse: 0.0,
            before: sketch.rest,
        }
    }
}

impl Parts for Knocker {
    fn op(&mut self, k: usize, pi: &mut Pi, error: f64) -> f64 {
        let op = pi.step(error);
        let place = k % self.every;
        if place == 0 {
            let moved = op - self.before;
            self.pulse = if moved == 0.0 { 0.0 } else { self.height * moved.signum() };
            self.before = op;
        }
        if place < self.width { (op + self.pulse).clamp(0.0, 100.0) } else { op }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn every_pulse_is_in_the_direction_of_the_movement() {
        for (seed, mut sketch) in sketches(Invention::Knocker) {
            sketch.proportional_only = false;
            for way in [1.0, -1.0] {
                let mut parts = Knocker::of(&sketch);
                let (mut knocks, mut plain) = (Pi::of(&sketch, 1.0), Pi::of(&sketch, 1.0));
                let error = 1e-3 * way / plain.kc;
                for k in 0..5 * parts.every {
                    let pulse = parts.op(k, &mut knocks, error) - plain.step(error);
                    let pulses = k % parts.every < parts.width;
                    let wanted = if pulses { way * parts.height } else { 0.0 };
                    assert!((pulse - wanted).abs() < 1e-9, "{seed} {k}: {pulse} for {wanted}");
                }
            }
        }
    }
}
