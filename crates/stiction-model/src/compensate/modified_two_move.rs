//! The modified two-move method.

use super::moves::{Correction, Mover, Plan};
use super::{Compensator, Method, Moves};
use crate::error::Result;

/// Repeated two-move compensation after Farenzena and Trierweiler: the loop stays closed from one pair of moves to
/// the next.
///
/// # What it does
/// Each pair of moves brings the stem to a target, always from the same side. The PV gets time to settle, and the
/// remaining control error corrects the target. The friction then adds a constant to the signal. The correction removes
/// this constant, so S and J need not be known well. Changes of set point and load are followed. While the error is
/// within the zone nothing moves.
///
/// # Equations
/// As for [`Moves`], in two moves, and for [`Correction`], at the end of every interval.
///
/// # Assumptions
/// The reach breaks the stem away; the process gain is known to better than a factor of 2.
///
/// # Limits
/// Tested with the parameters of [`Method::automatic`] on the paper's loop (S = 5, J = 1, 3 and 5; two-phase and He
/// valve), with S, J and the process gain each wrong by 30 % either way, or J unknown. The standard deviation of
/// the PV falls to zero within 200 s, and the mean absolute error, which keeps a part due to the zone, to a sixth
/// or less (He with J = 1: to less than a third).
///
/// It acts once an interval, so more slowly than a controller with a healthy valve. An error within the zone stays.
/// Every correction costs two strokes of about the reach.
///
/// # Deviations from the paper
/// The paper is known to keep the performance of the closed loop between moves; its method is not known. The
/// correction of the target instead of the controller, and the approach always from the same side, are ours.
///
/// # References
/// M. Farenzena, J. O. Trierweiler (2010).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModifiedTwoMove {
    /// The moves.
    pub moves: Moves,
    /// The correction of the target by the error.
    pub correction: Correction,
}

impl ModifiedTwoMove {
    /// Repeated two moves with these parameters.
    ///
    /// # Errors
    /// If a parameter of the moves or of the correction is out of range. The message names the parameter.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        let correction = Some((self.correction, usize::MAX));
        let plan = Plan { method: Method::ModifiedTwoMove, moves: 2, correction, eager: true };
        Mover::start(self.moves, plan)
    }
}
