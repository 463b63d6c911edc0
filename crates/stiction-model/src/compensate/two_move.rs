//! The two-move method.

use super::moves::{Mover, Plan};
use super::{Compensator, Method, Moves};
use crate::error::Result;

/// Srinivasan and Rengaswamy's two moves: away from the stuck position, then to the steady one, and hold.
///
/// # What it does
/// It ends the cycle instead of shortening it. The stem moves to the position that holds the PV at its set point, and
/// stays there.
///
/// # Equations
/// As for [`Moves`], in two moves. The first move goes to the side of the steady OP on which the OP is.
///
/// # Assumptions
/// The steady OP is known or can be estimated from a cycle; set point and load do not change.
///
/// # Limits
/// From the second move on the loop is open until the error has grown to `release`. An error in the steady OP or in
/// fd remains as an offset of the process gain times that error. An integrating process drifts away from any
/// offset, so moves and cycles alternate.
///
/// # Deviations from the paper
/// Its idea is recalled, not read: a first move that drives the stem away, a second that brings it to the steady
/// position. In the paper the second move sets the signal to the steady OP itself. The allowance for fd, the
/// estimate of the steady OP, the reach, and the release are ours.
///
/// # References
/// R. Srinivasan, R. Rengaswamy, Comput. Chem. Eng. (2008).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoMove {
    /// The moves.
    pub moves: Moves,
}

impl TwoMove {
    /// Two moves with these parameters.
    ///
    /// # Errors
    /// If a parameter of the moves is out of range. The message names the parameter.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        let plan = Plan { method: Method::TwoMove, moves: 2, correction: None, eager: false };
        Mover::start(self.moves, plan)
    }
}
