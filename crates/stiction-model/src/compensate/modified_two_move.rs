//! The modified two-move method.

use super::moves::{Correction, Mover, Plan};
use super::{Compensator, Method, Moves};
use crate::error::Result;

/// Two moves over and over, after Farenzena and Trierweiler: the loop stays closed from one pair to the
/// next.
///
/// # What it does
/// Each pair of moves puts the stem to a target, from the same side every time; the PV is given time to
/// answer, and what is left of the control error corrects the target. The friction then adds a constant
/// to the signal, and a constant is what a correction takes away: neither S nor J need be known well.
/// Changes of set point and load are followed. While the error is within the zone nothing moves.
///
/// # Equations
/// Those of [`Moves`], in two moves, and of [`Correction`], at the end of every interval.
///
/// # Assumptions
/// The reach breaks the stem away; the gain of the process is known to better than a factor of 2.
///
/// # Limits
/// With the parameters of [`Method::automatic`] on the paper's loop (S = 5, J = 1, 3 and 5; two-phase and
/// He valve), S, J and the gain of the process each wrong by 30 % either way, or J unknown, the standard
/// deviation of the PV falls to nothing within 200 s, and the mean absolute error, of which the zone
/// leaves a part, to a sixth or less (He with J = 1: to less than a third).
///
/// It answers once an interval, so more slowly than a controller whose valve is in order. An error
/// within the zone stays. Every correction costs two strokes of about the reach.
///
/// # Deviations from the paper
/// That the performance of the closed loop is kept between moves is known of the paper; how is not. The
/// correction of the target in place of the controller, and landing always from the same side, are ours.
///
/// # References
/// M. Farenzena, J. O. Trierweiler (2010).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModifiedTwoMove {
    /// The moves.
    pub moves: Moves,
    /// How the error corrects the target.
    pub correction: Correction,
}

impl ModifiedTwoMove {
    /// Two moves over and over with these parameters.
    ///
    /// # Errors
    /// If a parameter of the moves or the correction is out of its range; the message names it.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        let correction = Some((self.correction, usize::MAX));
        let plan = Plan { method: Method::ModifiedTwoMove, moves: 2, correction, eager: true };
        Mover::start(self.moves, plan)
    }
}
