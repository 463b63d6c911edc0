//! The six-move method.

use super::moves::{Correction, Mover, Plan};
use super::{Compensator, Method, Moves};
use crate::error::Result;

/// Six moves after Wang and Arifin: three, a look at where the PV settles, and three more.
///
/// # What it does
/// The first three moves put the stem where it should be as far as known. The offset at which the PV
/// then settles tells by how much that was wrong (an error in the steady OP, or in fd), and three more
/// moves, which land from the same side, put it right.
///
/// # Equations
/// Those of [`Moves`], in three moves, and of [`Correction`], applied once.
///
/// # Assumptions
/// As for the two moves; and the process settles within `settle_s`, with a gain known well enough.
///
/// # Limits
/// As for the two moves, but for what the correction takes away: an offset is left of the share by which
/// the gain is wrong. Of an integrating process the correction sees the error but not yet its growth:
/// there, with wrong bands, the method can make a worse cycle than the one it ends.
///
/// # Deviations from the paper
/// Of the paper only the name of the method is known to us; that moves are followed by an estimate of
/// the steady position is known of the family. The form is ours.
///
/// # References
/// Wang (2013); Arifin (2018).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SixMove {
    /// The moves.
    pub moves: Moves,
    /// The correction between the third and the fourth.
    pub correction: Correction,
}

impl SixMove {
    /// Six moves with these parameters.
    ///
    /// # Errors
    /// If a parameter of the moves or the correction is out of its range; the message names it.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        let correction = Some((self.correction, 1));
        let plan = Plan { method: Method::SixMove, moves: 3, correction, eager: false };
        Mover::start(self.moves, plan)
    }
}
