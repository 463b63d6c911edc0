//! Whether OP and PV belong to one loop.

use super::trees::Ensemble;

/// Distinguishes recordings whose columns belong together from mistaken ones: exchanged columns, signals of two
/// loops, noise instead of a signal (`Mistake` of the population).
///
/// A logistic regression by boosted trees on the evidence. It separates simulated loops of all kinds, including
/// stuck valves, from such loops with a mistake in their columns. The threshold is the margin that only a few true
/// loops left out of its training exceed; the model card lists them by kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Mismatch {
    /// The margin of a mistake.
    pub trees: Ensemble,
    /// The margin from which it is named.
    pub threshold: f64,
}

impl Mismatch {
    /// The odds of a mistake relative to the odds of the threshold, `exp(margin - threshold)`. Above 1 the columns look
    /// mistaken.
    pub fn odds(&self, row: &[f32]) -> f64 {
        (self.trees.margin(row) - self.threshold).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::Node;

    #[test]
    fn odds_are_one_at_the_threshold() {
        let of = |margin: f32| {
            let trees = Ensemble::new(0.0, &[vec![Node::Leaf(margin)]]).unwrap();
            Mismatch { trees, threshold: 1.5 }.odds(&[])
        };
        assert_eq!(of(1.5), 1.0);
        assert!(of(1.25) < 1.0 && (of(2.5) - 1f64.exp()).abs() < 1e-12);
    }
}
