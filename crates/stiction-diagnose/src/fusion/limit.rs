//! The detection limit of a recording.

use super::trees::Ensemble;
use crate::error::{Error, Result};

/// The share of sticking valves whose S lies at or below the limit.
pub const LIMIT: f64 = 0.95;

/// Beyond this many spans of the OP there is no limit.
const LARGEST: f64 = 3.0;

/// The smallest and the largest distinguishable S, in spans of the OP.
const RANGE: (f64, f64) = (0.005, 20.0);

/// An upper limit on S: a larger S would have shown in this recording.
///
/// A regression of the 95 % quantile of `z = ln(clip(S / OP span, 0.005, 20))` on the evidence. The loops have healthy
/// valves (S = 0), sticking valves, visible or masked, and stuck valves (no OP moves them). A conformal shift c is
/// added: the 95 % quantile of `z - q` over faulty valves left out of its training. Healthy valves, half of all valves,
/// are left out of the calculation because they would raise the coverage. Where a fault is unlikely, q is the quantile
/// of healthy valves, so c is found for each class of the probability. It is large enough that the coverage also holds
/// for those faulty valves that the limit clears. So among faulty valves like the simulated ones, in at most 5 % of
/// each class S lies above
///
/// ```text
/// limit = span exp(q + c(p))
/// ```
///
/// Source of the shift: Y. Romano, E. Patterson, E. Candès, NeurIPS 32 (2019); classes after V. Vovk, "Conditional
/// validity of inductive conformal predictors", ACML 2012 (both recalled, not read).
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// The 95 % quantile of z.
    pub trees: Ensemble,
    /// The largest probability of a fault of each class, ascending, and its c, found on loops left out of training.
    /// Higher probabilities belong to the last class.
    pub shifts: Vec<(f64, f64)>,
}

impl Limit {
    /// `z` of a valve of this S, percent of span; 0 for a healthy one.
    pub fn target(s: f64, op_span: f64) -> f64 {
        (s / op_span).clamp(RANGE.0, RANGE.1).ln()
    }

    /// Accepts shifts that are finite and whose probabilities ascend.
    ///
    /// # Errors
    /// If the shifts are not finite, their probabilities do not ascend, or the list is empty.
    pub fn checked(self) -> Result<Self> {
        let sound = !self.shifts.is_empty()
            && self.shifts.iter().all(|(up_to, shift)| !up_to.is_nan() && shift.is_finite())
            && self.shifts.windows(2).all(|two| two[0].0 < two[1].0);
        match sound {
            true => Ok(self),
            false => Err(Error::Bundle("the shifts of the limit are invalid".into())),
        }
    }

    /// The limit in spans of the OP, for a loop with that probability of a fault; `None` if the limit exceeds three
    /// spans.
    pub fn spans(&self, row: &[f32], probability: f64) -> Option<f64> {
        let class = self.shifts.iter().find(|(up_to, _)| probability <= *up_to);
        let shift = class.or(self.shifts.last()).map_or(0.0, |(_, shift)| *shift);
        let spans = (self.trees.margin(row) + shift).exp();
        (spans <= LARGEST).then_some(spans)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::Node;

    #[test]
    fn a_limit_is_moved_by_its_class_and_ends_at_three_spans() {
        let of = |q: f32, shifts: &[(f64, f64)]| Limit {
            trees: Ensemble::new(0.0, &[vec![Node::Leaf(q)]]).unwrap(),
            shifts: shifts.to_vec(),
        };
        let limit = of(-1.0, &[(0.1, 0.5), (1.0, 0.2)]).checked().unwrap();
        for (p, moved) in [(0.05, -0.5f64), (0.1, -0.5), (0.11, -0.8), (1.0, -0.8)] {
            let found = limit.spans(&[], p).unwrap();
            assert!((found - moved.exp()).abs() < 1e-12, "{found}");
        }
        let ends = |shift| of(1.0, &[(1.0, shift)]).spans(&[], 0.3);
        assert!(ends(0.09).is_some() && ends(0.1).is_none());
        for wrong in [&[][..], &[(0.5, f64::NAN)], &[(0.5, 0.0), (0.5, 0.0)]] {
            assert!(of(0.0, wrong).checked().is_err());
        }
    }

    #[test]
    fn targets_are_bounded() {
        assert_eq!(Limit::target(0.0, 5.0), 0.005f64.ln());
        assert_eq!(Limit::target(200.0, 5.0), 20f64.ln());
        assert_eq!(Limit::target(5.0, 5.0), 0.0);
    }
}
