//! A valve that sticks more, the longer it rests.

use super::parts::{Friction, Parts};
use super::sketch::Sketch;

/// Soft packing and seats creep into contact: static friction grows with the logarithm of the time at rest, from
/// sliding friction up to a largest value. A stem that moves often slides with a dead band, and one that rested for
/// long jumps. S and J hold after a long rest.
pub(super) struct AgeingFriction {
    /// Sliding friction, and the largest static friction, percent.
    slides: f64,
    holds: f64,
    /// Steps at rest after which it has grown by some, and to the largest.
    soon: f64,
    long: f64,
    rests: f64,
}

impl AgeingFriction {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let long = sketch.period * draw.log(0.5, 5.0);
        Self {
            slides: 0.5 * (sketch.s - sketch.j),
            holds: 0.5 * (sketch.s + sketch.j),
            soon: long / draw.log(10.0, 100.0),
            long,
            rests: long,
        }
    }

    /// The present friction against a stem that rests.
    fn against(&self) -> f64 {
        let age = (self.rests / self.soon).ln_1p() / (self.long / self.soon).ln_1p();
        self.slides + age.min(1.0) * (self.holds - self.slides)
    }
}

impl Parts for AgeingFriction {
    fn stem(&mut self, valve: &mut Friction, op: f64) -> f64 {
        if !valve.sticks() {
            return valve.step(op);
        }
        let push = op - valve.stem;
        if push.abs() > self.against() {
            valve.stem = op - self.slides * push.signum();
            self.rests = 0.0;
        } else {
            self.rests += 1.0;
        }
        valve.stem
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    /// The jump of the first move after this many steps at rest, with the OP that moves it then.
    fn jump(sketch: &Sketch, rests: impl Fn(&AgeingFriction) -> f64) -> f64 {
        let mut parts = AgeingFriction::of(sketch);
        let mut valve = Friction::of(sketch, true).unwrap();
        // A slow move up, which ends with the stem sliding.
        for k in 0..=1000 {
            parts.stem(&mut valve, sketch.rest + 2e-3 * f64::from(k) * sketch.s);
        }
        let (top, at) = (sketch.rest + 2.0 * sketch.s, valve.stem);
        assert!((top - parts.slides - at).abs() < 1e-9);
        parts.rests = rests(&parts);
        let push = parts.against() + 1e-9;
        parts.stem(&mut valve, at + push) - at
    }

    #[test]
    fn it_jumps_by_j_after_a_long_rest_and_slides_after_none() {
        for (seed, sketch) in sketches(Invention::AgeingFriction) {
            let long = jump(&sketch, |parts| parts.long);
            assert!((long - sketch.j).abs() < 1e-6, "{seed}: {long} for {}", sketch.j);
            assert!(jump(&sketch, |parts| 10.0 * parts.long) < long + 1e-6);
            let soon = jump(&sketch, |parts| parts.soon) / sketch.j;
            assert!((0.1..0.4).contains(&soon), "{seed}: {soon}");
            assert!(jump(&sketch, |_| 0.0).abs() < 1e-6);
        }
    }
}
