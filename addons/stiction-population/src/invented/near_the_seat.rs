//! A valve that sticks only near its seat.

use super::parts::{Friction, Parts};

/// It sticks below 15 %.
pub(super) struct NearTheSeat;

impl Parts for NearTheSeat {
    fn stem(&mut self, valve: &mut Friction, op: f64) -> f64 {
        if op.min(valve.stem) < 15.0 { valve.step(op) } else { valve.slide(op) }
    }
}
