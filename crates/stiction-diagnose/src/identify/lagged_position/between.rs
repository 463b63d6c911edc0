//! He's valve in continuous motion between two samples, behind a lag.

use crate::bands::Bands;
use crate::simd::{LANES, Lane};
use crate::valve::Start;
use crate::valve::lanes::LaneValve;
use std::hint::select_unpredictable as select;

/// He's valve under an input that moves straight from sample to sample, as after a lag. It slips by J whenever the
/// distance exceeds fs, not only once a sample.
///
/// ```text
/// e = u - x;   |e| > fs:  x += sign(e) J m,   m = ceil((|e| - fs) / J)
/// ```
/// Ours. J = 0 would be a play, as in [`TwoPhase`](crate::valve::TwoPhase); it is replaced by 1e-6 of fs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HeBetweenLanes {
    fs: Lane,
    j: Lane,
    per_j: Lane,
    position: Lane,
}

impl LaneValve for HeBetweenLanes {
    fn starting(bands: &[Bands; LANES], starts: [Start; LANES]) -> Self {
        let j = Lane(bands.map(|b| b.j().max(1e-6 * b.fs()).max(1e-9)));
        Self {
            fs: Lane(bands.map(|b| b.fs())),
            j,
            per_j: Lane(j.0.map(|j| 1.0 / j)),
            position: Lane(starts.map(|s| s.position)),
        }
    }

    #[inline(always)]
    fn step(&mut self, l: usize, op: f64) -> f64 {
        let e = op - self.position[l];
        let beyond = e.abs() - self.fs[l];
        let moved = self.position[l] + (self.j[l] * (beyond * self.per_j[l]).ceil()).copysign(e);
        self.position[l] = select(beyond > 0.0, moved, self.position[l]);
        self.position[l]
    }
}
