//! The probability from which a valve is accused, and the probability up to which it is cleared.

use crate::error::{Error, Result};

/// The two thresholds of the verdict.
///
/// The training chooses them on loops that were not used for learning, as close to each other as few wrong
/// decisions allow: see `stiction-train`, `decide.rs`, for the constraints and the order of the tried thresholds.
/// The [model card](https://github.com/stiction/stiction) lists their values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The probability of a fault from which a valve is accused.
    pub accuse: f64,
    /// The probability of a fault up to which a valve is cleared.
    pub clear: f64,
}

impl Decision {
    /// For models without thresholds.
    pub const CAUTIOUS: Self = Self { accuse: 0.95, clear: 0.05 };

    /// Accepts thresholds with a gap between them.
    ///
    /// # Errors
    /// If a threshold is not a probability, the threshold to accuse is not above 0.5, or the threshold to clear is not
    /// below 0.5.
    pub fn checked(self) -> Result<Self> {
        match (0.0..0.5).contains(&self.clear) && self.accuse > 0.5 && self.accuse <= 1.0 {
            true => Ok(self),
            false => Err(Error::Bundle("its thresholds must lie on both sides of 0.5".into())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_leave_room_between_them() {
        assert!(Decision::CAUTIOUS.checked().is_ok());
        for (accuse, clear) in [(0.5, 0.1), (0.9, 0.5), (f64::NAN, 0.1), (0.9, -0.1), (1.1, 0.1)] {
            assert!(Decision { accuse, clear }.checked().is_err(), "{accuse} {clear}");
        }
    }
}
