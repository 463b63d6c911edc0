//! Two valves in one line.

use super::parts::Parts;
use super::sketch::Sketch;
use std::f64::consts::TAU;

/// The other valve moves manually, in steps, and swings with its own loop.
pub(super) struct ValvesInSeries {
    period: f64,
    share: f64,
    rest: f64,
    by_hand: f64,
}

impl ValvesInSeries {
    pub fn of(sketch: &Sketch) -> Self {
        let Sketch { period, share, rest, .. } = *sketch;
        Self { period, share, rest, by_hand: 0.0 }
    }
}

impl Parts for ValvesInSeries {
    fn flow(&mut self, k: usize, stem: f64) -> f64 {
        let place = TAU * k as f64 / self.period;
        if k.is_multiple_of((7.3 * self.period) as usize + 1) {
            self.by_hand = self.share * (3.7 * place).sin();
        }
        let other = 1.0 + self.by_hand + 0.2 * self.share * place.sin();
        (stem + self.rest) * other - self.rest
    }
}
