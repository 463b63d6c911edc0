//! What a recording would have shown: the detection limit.

use super::trees::Ensemble;

/// The share of sticking valves whose S lies at or below the limit.
pub const LIMIT: f64 = 0.95;

/// Beyond so many spans of the OP there is no limit.
const LARGEST: f64 = 3.0;

/// The least and the largest S that is told apart, in spans of the OP.
const RANGE: (f64, f64) = (0.005, 20.0);

/// An upper limit on S: had the valve stuck by more, this recording would have shown it.
///
/// A regression of the 95 % quantile of `z = ln(clip(S / OP span, 0.005, 20))` on the evidence, over
/// healthy valves (S = 0), sticking ones, visible or hidden, and stuck ones (no OP moves them). It is
/// moved by a conformal shift c, the 95 % quantile of `z - q` over valves at fault that were left out of
/// its training (only those: healthy ones, half of all, would buy the coverage). So among valves at
/// fault like the simulated ones, in at most 5 % S lies above
///
/// ```text
/// limit = span exp(q + c)
/// ```
///
/// Source of the shift: Y. Romano, E. Patterson, E. Candès, NeurIPS 32 (2019) (recalled, not read).
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// The 95 % quantile of z.
    pub trees: Ensemble,
    /// c, found on loops left out of training.
    pub shift: f64,
}

impl Limit {
    /// `z` of a valve of this S, percent of span; 0 of a healthy one.
    pub fn target(s: f64, op_span: f64) -> f64 {
        (s / op_span).clamp(RANGE.0, RANGE.1).ln()
    }

    /// The limit in spans of the OP; `None` if it is beyond three of them.
    pub fn spans(&self, row: &[f32]) -> Option<f64> {
        let spans = (self.trees.margin(row) + self.shift).exp();
        (spans <= LARGEST).then_some(spans)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::Node;

    #[test]
    fn a_limit_is_moved_and_ends_at_three_spans() {
        let of = |q: f32, shift| Limit {
            trees: Ensemble::new(0.0, &[vec![Node::Leaf(q)]]).unwrap(),
            shift,
        };
        let found = of(-1.0, 0.5).spans(&[]).unwrap();
        assert!((found - (-0.5f64).exp()).abs() < 1e-12, "{found}");
        assert!(of(1.0, 0.09).spans(&[]).is_some() && of(1.0, 0.1).spans(&[]).is_none());
    }

    #[test]
    fn targets_are_bounded() {
        assert_eq!(Limit::target(0.0, 5.0), 0.005f64.ln());
        assert_eq!(Limit::target(200.0, 5.0), 20f64.ln());
        assert_eq!(Limit::target(5.0, 5.0), 0.0);
    }
}
