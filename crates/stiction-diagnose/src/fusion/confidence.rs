//! Limits the reported confidence to that confirmed on kinds of loops left out of training.

use crate::error::{Error, Result};

/// Probabilities between this and 1 less this are reported as calibrated.
const FREE: f64 = 0.1;

/// A decision beyond this probability, or below 1 less this, is a sure one.
pub const SURE: f64 = 0.98;

/// The reported log-odds for calibrated ones.
///
/// Calibration holds on loops like the training loops. On loops of a kind that was left out, a calibrated 0.98 is wrong
/// more often than once in fifty. Leaving out each kind in turn shows how much more often. So log-odds l are reported
/// unchanged between probabilities of 0.1 and 0.9, and compressed by a straight line beyond, on either side:
///
/// ```text
/// reported = ln 9 + (|l| - ln 9) (ln 49 - ln 9) / (reached - ln 9)      |l| > ln 9
/// ```
///
/// So 0.98 (or 0.02) is reported at `reached`, from where decisions on left-out kinds are right. Without such a value,
/// nothing beyond `most` is reported. The order of loops is kept, except for those beyond `most`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Confidence {
    /// Below 0.1: against a fault.
    pub clearing: Side,
    /// Above 0.9: for one.
    pub accusing: Side,
}

/// One side of a [`Confidence`], as absolute values of log-odds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// The calibrated log-odds that are reported as 0.98; at least the log-odds of 0.98.
    pub reached: f64,
    /// The largest reported log-odds; infinite without a bound.
    pub most: f64,
}

impl Side {
    /// Reports calibrated values unchanged.
    pub const IDENTITY: Self = Self { reached: 3.891_820_298_110_627, most: f64::INFINITY };

    /// Reaches 0.98 at these log-odds, or at its own if that is more.
    pub fn reaching(log_odds: f64) -> Self {
        Self { reached: log_odds.max(Self::IDENTITY.reached), most: f64::INFINITY }
    }

    /// Never reports more than a probability, reached at these log-odds at the earliest.
    pub fn bounded(log_odds: f64, most: f64) -> Self {
        Self { most: logit(most), ..Self::reaching(log_odds) }
    }

    fn bounded_size(self, size: f64) -> f64 {
        let (free, sure) = (logit(1.0 - FREE), logit(SURE));
        if size <= free {
            return size;
        }
        let slope = (sure - free) / (self.reached - free);
        (free + (size - free) * slope).min(self.most)
    }

    fn is_sound(self) -> bool {
        let sure = logit(SURE);
        self.reached >= sure - 1e-9 && self.reached.is_finite() && self.most > logit(1.0 - FREE)
    }
}

impl Confidence {
    /// Reports calibrated values unchanged.
    pub const IDENTITY: Self = Self { clearing: Side::IDENTITY, accusing: Side::IDENTITY };

    /// Accepts a map that never exceeds the calibrated values.
    ///
    /// # Errors
    /// If the map exceeds the calibrated values, or is not finite.
    pub fn checked(self) -> Result<Self> {
        match self.clearing.is_sound() && self.accusing.is_sound() {
            true => Ok(self),
            false => Err(Error::Bundle("a confidence exceeds the calibrated value".into())),
        }
    }

    /// The reported probability for a calibrated one.
    pub fn reported(&self, probability: f64) -> f64 {
        if (FREE..=1.0 - FREE).contains(&probability) {
            return probability;
        }
        let log_odds = logit(probability);
        let side = if log_odds < 0.0 { self.clearing } else { self.accusing };
        super::sigmoid(side.bounded_size(log_odds.abs()).copysign(log_odds))
    }
}

/// `ln(p / (1 - p))`.
pub fn logit(p: f64) -> f64 {
    (p / (1.0 - p)).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn identity_changes_nothing() {
        assert!((Side::IDENTITY.reached - logit(SURE)).abs() < 1e-12);
        for p in [0.0, 1e-6, 0.02, 0.1, 0.5, 0.93, 0.999, 1.0] {
            assert!((Confidence::IDENTITY.reported(p) - p).abs() < 1e-12, "{p}");
        }
    }

    #[test]
    fn sure_is_reported_where_it_is_reached() {
        let map = Confidence { clearing: Side::reaching(6.0), accusing: Side::reaching(5.0) };
        let map = map.checked().unwrap();
        assert!((map.reported(crate::fusion::sigmoid(-6.0)) - 0.02).abs() < 1e-9);
        assert!((map.reported(crate::fusion::sigmoid(5.0)) - 0.98).abs() < 1e-9);
        assert_eq!((map.reported(0.1), map.reported(0.3), map.reported(0.9)), (0.1, 0.3, 0.9));
        let never = Confidence { clearing: Side::bounded(6.0, 0.97), ..map };
        assert!((never.reported(1e-12) - 0.03).abs() < 1e-9 && never.reported(0.999) > 0.98);
    }

    #[test]
    fn more_than_calibrated_is_refused() {
        let of = |reached, most| Confidence {
            clearing: Side { reached, most },
            accusing: Side::IDENTITY,
        };
        assert!(of(3.0, f64::INFINITY).checked().is_err());
        assert!(of(f64::NAN, f64::INFINITY).checked().is_err());
        assert!(of(f64::INFINITY, f64::INFINITY).checked().is_err());
        assert!(of(5.0, 1.0).checked().is_err() && of(5.0, f64::NAN).checked().is_err());
        assert!(of(5.0, 3.0).checked().is_ok());
    }

    proptest! {
        /// Told probabilities keep their order and never lie further out.
        #[test]
        fn order_is_kept(a in 0.0..=1.0f64, b in 0.0..=1.0f64, low in 3.9..9.0f64, high in 3.9..9.0f64) {
            let map = Confidence { clearing: Side::reaching(low), accusing: Side::bounded(high, 0.97) };
            let (small, large) = (map.reported(a.min(b)), map.reported(a.max(b)));
            prop_assert!((0.0..=1.0).contains(&small) && small <= large + 1e-12);
            for p in [a, b] {
                prop_assert!((map.reported(p) - 0.5).abs() <= (p - 0.5).abs() + 1e-12);
            }
        }
    }
}
