//! Two controllers of one PV.

use super::parts::{Parts, Pi};
use super::sketch::Sketch;
use stiction_model::closed_loop::NormalStream;

/// A second valve acts on the same PV. Its PI controller has its own transmitter, which reads slightly more or less
/// than the transmitter of this loop. The two integrals move in opposite directions: the OP travels far, and the PV
/// hardly moves. The second valve has less travel and may be at its end.
pub(super) struct TwoControllers {
    /// Gain and integral time of the second controller. The gain is relative to the gain of this controller.
    kc: f64,
    ti: f64,
    ratio: f64,
    /// The difference between the transmitters, percent of span: its deviation, the share that remains from step to
    /// step, and its present value.
    size: f64,
    keep: f64,
    differs: f64,
    noise: NormalStream,
    /// Travel of the second valve to either side, percent, and its integral part.
    travel: f64,
    integral: f64,
    /// Present step, start of the record, and the range of the second valve since.
    k: usize,
    begins: usize,
    range: (f64, f64),
}

impl TwoControllers {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let ratio = draw.log(0.2, 0.8);
        let own = Pi::of(sketch, 1.0 + ratio);
        let (kc, ti) = (ratio * own.kc, own.ti * draw.log(0.5, 2.0));
        let travel = (sketch.size * draw.log(0.3, 1.5)).min(20.0);
        // Steps in which such a difference moves the second valve through its travel.
        let lasts = sketch.period * draw.log(1.0, 8.0);
        Self {
            kc,
            ti,
            ratio,
            size: travel * ti / (kc.abs() * lasts),
            keep: 1.0 - 0.5 / lasts,
            differs: 0.0,
            noise: NormalStream::new(draw.seed()),
            travel,
            integral: 0.0,
            k: 0,
            begins: sketch.warm_up(),
            range: (f64::INFINITY, f64::NEG_INFINITY),
        }
    }
}

impl Parts for TwoControllers {
    fn steepest(&self) -> f64 {
        1.0 + self.ratio
    }

    fn load(&mut self, pv: f64) -> f64 {
        let push = (1.0 - self.keep * self.keep).sqrt() * self.size * self.noise.draw();
        self.differs = self.keep * self.differs + push;
        let error = self.differs - pv;
        let ends = |position: f64| position.clamp(-self.travel, self.travel);
        self.integral = ends(self.integral + self.kc * error / self.ti);
        let position = ends(self.kc * error + self.integral);
        if self.k >= self.begins {
            self.range = (self.range.0.min(position), self.range.1.max(position));
        }
        self.k += 1;
        position
    }

    fn shows(&self) -> bool {
        self.range.1 - self.range.0 > 0.5 * self.travel
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn a_small_difference_moves_the_two_valves_apart_and_hardly_the_pv() {
        for (seed, mut sketch) in sketches(Invention::TwoControllers) {
            sketch.proportional_only = false;
            let mut parts = TwoControllers::of(&sketch);
            // A difference that stays, at a process without lags.
            (parts.keep, parts.differs) = (1.0, parts.size);
            let mut pi = Pi::of(&sketch, parts.steepest());
            let (mut pv, mut op) = (0.0, 0.0);
            let mut other = 0.0;
            for _ in 0..200_000 {
                op = pi.step(-pv) - pi.rest;
                other = parts.load(pv);
                pv += (sketch.gain * (op + other) - pv) / (4.0 * sketch.lags[0]);
            }
            // The second valve is at its end, and this loop alone then holds its set point.
            assert!((other.abs() - parts.travel).abs() < 1e-6, "{seed}: {other}");
            assert!((op + other).abs() < 1e-3 && pv.abs() < 1e-3, "{seed}: {op} {other} {pv}");
        }
    }
}
