//! A controller with two sets of tuning.

use super::parts::{Parts, Pi};
use super::sketch::Sketch;

/// The gain of the valve is larger beyond an opening. There the controller uses a different set, whose gain more or
/// less compensates for the valve's gain. An OP near the border switches it, with some hysteresis.
pub(super) struct ScheduledTuning {
    /// The border, percent from rest, and half its hysteresis.
    border: f64,
    hysteresis: f64,
    /// Gain of the valve beyond the border, over that below it.
    steeper: f64,
    /// Controller gain beyond the border, relative to the gain below it.
    factor: f64,
    /// The integral is kept as a sum of errors, to which the new gain applies: the OP jumps.
    bumps: bool,
    beyond: bool,
    /// The last OP, percent from rest.
    last: f64,
    /// Start of the record, steps, and the number of switches since.
    begins: usize,
    switches: usize,
}

impl ScheduledTuning {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let steeper = draw.log(1.5, 4.0);
        Self {
            border: sketch.size * draw.uniform(-0.4, 0.4),
            hysteresis: sketch.size * draw.log(0.02, 0.2),
            steeper,
            factor: steeper.powf(-draw.uniform(0.0, 1.4)),
            bumps: draw.chance(0.5),
            beyond: false,
            last: 0.0,
            begins: sketch.warm_up(),
            switches: 0,
        }
    }
}

impl Parts for ScheduledTuning {
    fn steepest(&self) -> f64 {
        (self.steeper * self.factor).max(1.0)
    }

    fn op(&mut self, k: usize, pi: &mut Pi, error: f64) -> f64 {
        let past = self.border + if self.beyond { -self.hysteresis } else { self.hysteresis };
        if (self.last > past) != self.beyond {
            self.beyond = !self.beyond;
            self.switches += usize::from(k >= self.begins);
            let before = pi.kc;
            pi.kc = if self.beyond { before * self.factor } else { before / self.factor };
            match self.bumps {
                true => pi.integral *= pi.kc / before,
                false => pi.integral += (before - pi.kc) * error,
            }
        }
        let op = pi.step(error);
        self.last = op - pi.rest;
        op
    }

    fn flow(&mut self, _k: usize, stem: f64) -> f64 {
        stem + (self.steeper - 1.0) * (stem - self.border).max(0.0)
    }

    fn shows(&self) -> bool {
        self.switches >= 4
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn the_set_changes_the_gain_and_half_of_the_loops_bump() {
        let mut bumps = 0;
        for (seed, sketch) in sketches(Invention::ScheduledTuning) {
            let mut parts = ScheduledTuning::of(&sketch);
            (parts.border, parts.hysteresis, parts.factor) = (1.0, 0.2, 0.5);
            let mut pi = Pi::of(&sketch, parts.steepest());
            let kc = pi.kc;
            // The integral takes the OP beyond the border; there the error stays.
            pi.integral = 1.3;
            let error = 0.1 / kc;
            parts.op(0, &mut pi, error);
            assert_eq!((pi.kc, parts.beyond), (kc, false));
            let before = pi.rest + kc * error + pi.integral;
            let after = parts.op(parts.begins, &mut pi, error);
            assert!(parts.beyond && parts.switches == 1 && pi.kc == kc * parts.factor);
            let step = 2.0 * (kc * error / pi.ti).abs();
            // Without a bump the OP goes on by no more than the integral adds in a step.
            assert_eq!((after - before).abs() > step, parts.bumps, "{seed}");
            bumps += usize::from(parts.bumps);
            assert!(parts.flow(0, 2.0) > 2.4 && parts.flow(0, 0.5) == 0.5);
        }
        assert!((10..30).contains(&bumps), "{bumps} of 40");
    }
}
