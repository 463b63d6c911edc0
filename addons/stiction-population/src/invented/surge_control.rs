//! A surge controller of a compressor.

use super::parts::{Parts, Pi};
use super::sketch::Sketch;

/// The recycle valve opens as fast as the controller requires and closes by a ramp. If the flow falls below a
/// second line, it is opened at once by a fixed step.
pub(super) struct SurgeControl {
    /// 1 if opening raises the PV, else -1.
    sign: f64,
    /// The largest closing per step, percent.
    closes: f64,
    /// Distance of the second line below the set point, percent of span, and the size of the opening step.
    line: f64,
    thrown: f64,
    /// Whether the opening step is armed: the flow has been at the set point since.
    armed: bool,
    /// Deficit of the flow, filtered.
    lack: f64,
    op: f64,
    /// Start of the record, number of its steps, and number of its steps with closing by the ramp.
    begins: usize,
    recorded: usize,
    ramping: usize,
}

impl SurgeControl {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        Self {
            sign: sketch.gain.signum(),
            closes: sketch.size / (sketch.waiting() * draw.log(5.0, 40.0)),
            line: sketch.gain.abs() * sketch.size * draw.log(0.2, 1.0),
            thrown: sketch.size * draw.uniform(0.5, 2.0),
            armed: true,
            lack: 0.0,
            op: sketch.rest,
            begins: sketch.warm_up(),
            recorded: sketch.recorded(),
            ramping: 0,
        }
    }
}

impl Parts for SurgeControl {
    fn op(&mut self, k: usize, pi: &mut Pi, error: f64) -> f64 {
        let before = self.lack;
        self.lack += 0.3 * (self.sign * error - self.lack);
        let moved = pi.kc.abs() * (self.lack - before + self.lack / pi.ti);
        self.op += moved.max(-self.closes);
        self.ramping += usize::from(moved < -self.closes && k >= self.begins);
        if self.armed && self.lack > self.line {
            self.op += self.thrown;
        }
        self.armed = self.lack < 0.0 || self.armed && self.lack <= self.line;
        self.op = self.op.clamp(0.0, 100.0);
        self.op
    }

    fn shows(&self) -> bool {
        self.ramping as f64 >= 0.05 * self.recorded as f64
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn it_opens_at_once_is_thrown_open_once_and_closes_by_a_ramp() {
        for (seed, sketch) in sketches(Invention::SurgeControl) {
            let mut parts = SurgeControl::of(&sketch);
            let mut pi = Pi::of(&sketch, parts.steepest());
            let line = parts.line;
            // From 40 % on, where there is room.
            parts.op = 40.0;
            let mut moves = |parts: &mut SurgeControl, lack: f64, n: usize| -> Vec<f64> {
                let mut before = parts.op;
                let mut one = |k| {
                    let op = parts.op(k, &mut pi, parts.sign * lack);
                    op - std::mem::replace(&mut before, op)
                };
                (0..n).map(&mut one).collect()
            };
            assert!(moves(&mut parts, 0.0, 20).iter().all(|by| *by == 0.0));
            let closing = moves(&mut parts, -line, 10);
            let ramp = -parts.closes - 1e-9;
            assert!(closing.iter().all(|by| (ramp..0.0).contains(by)), "{closing:?}");
            // A lack that stays throws it open once, beyond what the controller asks for.
            parts.op = 40.0;
            parts.thrown = 30.0;
            let opening = moves(&mut parts, 1.05 * line, 200);
            assert_eq!(opening.iter().filter(|by| **by > 29.0).count(), 1, "{seed}: {opening:?}");
            assert!(opening[20..].iter().all(|by| *by >= 0.0));
        }
    }
}
