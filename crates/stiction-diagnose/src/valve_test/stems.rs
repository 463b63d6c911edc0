//! The candidate valves of a test, and how far each moves with the turns of the OP.

use crate::bands::Bands;
use crate::valve::{Direction, Model, Start, Valve};

/// A candidate valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stem {
    /// Stick band plus dead band, percent.
    pub s: f64,
    /// Slip jump, percent.
    pub j: f64,
}

/// J as a share of S.
pub(super) const SHARES: [f64; 6] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
/// Possible positions of the stem before the first turn: distance from the OP, as a share of the largest possible
/// distance.
pub(super) const PLACES: [f64; 5] = [0.0, -0.45, 0.45, -0.9, 0.9];
/// These positions for a stem with J = 0 that slid before.
pub(super) const SLID: [f64; 2] = [-1.0, 1.0];
/// The smallest S tried, percent, and the ratio of one S to the last.
const LEAST: f64 = 0.12;
const RATIO: f64 = 1.1;

impl Stem {
    /// The values of S to try, percent, from [`LEAST`] to `most`.
    pub fn bands(most: f64) -> Vec<f64> {
        let steps = (most / LEAST).ln() / RATIO.ln();
        (0..steps.max(0.0).ceil() as u32).map(|k| LEAST * RATIO.powi(k as i32)).collect()
    }

    /// The stem's travel with each turn to a value of `op`, percent, starting from `place`; `None` if a band is
    /// invalid.
    pub fn moves(&self, before: f64, op: &[f64], place: f64) -> Option<Vec<f64>> {
        let mut valve = Model::TwoPhase.build(Bands::from_s_j(self.s, self.j).ok()?).ok()?;
        let position = before + place * 0.5 * (self.s + self.j).min(2.0 * self.s);
        valve.restart(Start { position, op: before, direction: Direction::Up, moving: false });
        let mut at = valve.step(before);
        let step = |op: &f64| {
            let (last, now) = (at, valve.step(*op));
            // The stem comes to rest.
            valve.step(*op);
            at = now;
            now - last
        };
        Some(op.iter().map(step).collect())
    }
}
