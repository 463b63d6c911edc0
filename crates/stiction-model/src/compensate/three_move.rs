//! The three-move method.

use super::moves::{Mover, Plan};
use super::{Compensator, Method, Moves};
use crate::error::Result;

/// Wang's three moves: to the far side of the steady position, to the near side, and to the steady position.
///
/// # What it does
/// As [`TwoMove`](super::TwoMove). The first move makes sure that the second finds the stem on the opposite side. One
/// of the two breaks the stem away from any position, and their pushes on the PV nearly cancel.
///
/// # Equations
/// As for [`Moves`], in three moves.
///
/// # Assumptions
/// As for the two moves.
///
/// # Limits
/// As for the two moves. The valve travels one more reach.
///
/// # Deviations from the paper
/// Only the name of the method in the paper is known to us. The form of the moves, the estimate of the steady OP
/// and the release are ours.
///
/// # References
/// Wang (2013).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreeMove {
    /// The moves.
    pub moves: Moves,
}

impl ThreeMove {
    /// Three moves with these parameters.
    ///
    /// # Errors
    /// If a parameter of the moves is out of range. The message names the parameter.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        let plan = Plan { method: Method::ThreeMove, moves: 3, correction: None, eager: false };
        Mover::start(self.moves, plan)
    }
}
