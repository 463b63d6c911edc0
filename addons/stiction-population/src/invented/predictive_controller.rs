//! A predictive controller.

use super::parts::{Parts, Pi};
use super::sketch::Sketch;

/// An inaccurate model of gain and lag predicts the PV; a move every few steps corrects a share of its deviation.
pub(super) struct PredictiveController {
    lag: f64,
    gain: f64,
    /// Steps between two moves, the largest move, percent, and the corrected share.
    every: usize,
    most: f64,
    share: f64,
    rest: f64,
    held: f64,
    predicted: f64,
}

impl PredictiveController {
    pub fn of(sketch: &Sketch) -> Self {
        Self {
            lag: sketch.lags[0] * sketch.wrong,
            gain: sketch.gain * sketch.wrong.sqrt(),
            every: sketch.every,
            most: 0.5 * sketch.s + 0.5,
            share: 1.0 / (1.0 + sketch.slowness),
            rest: sketch.rest,
            held: sketch.rest,
            predicted: 0.0,
        }
    }
}

impl Parts for PredictiveController {
    fn op(&mut self, k: usize, _pi: &mut Pi, error: f64) -> f64 {
        self.predicted += (self.gain * (self.held - self.rest) - self.predicted) / self.lag;
        if k.is_multiple_of(self.every) {
            let bias = -error - self.predicted;
            let wanted = self.rest - bias / self.gain;
            self.held += (self.share * (wanted - self.held)).clamp(-self.most, self.most);
        }
        self.held = self.held.clamp(0.0, 100.0);
        self.held
    }
}
