//! The six-move method.

use super::moves::{Correction, Mover, Plan};
use super::{Compensator, Method, Moves};
use crate::error::Result;

/// Six moves after Wang and Arifin: three, a check of the settled PV, and three more.
///
/// # What it does
/// The first three moves bring the stem to the estimated target. The offset of the settled PV shows the error of the
/// estimate (in the steady OP, or in fd). Three more moves approach from the same side and correct this error.
///
/// # Equations
/// As for [`Moves`], in three moves, and for [`Correction`], applied once.
///
/// # Assumptions
/// As for the two moves. The process settles within `settle_s`, with a gain known well enough.
///
/// # Limits
/// As for the two moves, but the correction reduces the offset to the share by which the gain is wrong. For an
/// integrating process the correction uses the present error but not its growth. With wrong bands, the method can then
/// cause a worse cycle than the original one.
///
/// # Deviations from the paper
/// Only the name of the method in the paper is known to us. Methods of this family are known to estimate the steady
/// position after the moves. The form is ours.
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
    /// If a parameter of the moves or of the correction is out of range. The message names the parameter.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        let correction = Some((self.correction, 1));
        let plan = Plan { method: Method::SixMove, moves: 3, correction, eager: false };
        Mover::start(self.moves, plan)
    }
}
