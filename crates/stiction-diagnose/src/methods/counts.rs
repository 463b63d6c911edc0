//! Counts of decisions.

use crate::finding::Decision;

/// Decisions of a method, or of verdicts, on some loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Counts {
    /// The valve sticks, or the loop is not linear.
    pub positive: usize,
    /// The valve does not stick, or the loop is linear.
    pub negative: usize,
    /// Undecided, although applicable.
    pub undecided: usize,
    /// Abstained.
    pub abstains: usize,
}

impl Counts {
    /// Counts one more decision.
    pub fn add(&mut self, decision: Decision) {
        match decision {
            Decision::Sticks | Decision::Nonlinear => self.positive += 1,
            Decision::DoesNotStick | Decision::Linear => self.negative += 1,
            Decision::Undecided => self.undecided += 1,
            Decision::Abstains => self.abstains += 1,
        }
    }

    /// All loops.
    pub fn all(&self) -> usize {
        self.positive + self.negative + self.undecided + self.abstains
    }

    /// The majority of some decisions, as for the windows of one valve. It is undecided if positive and negative
    /// decisions are equally many, and abstains if all abstain.
    pub fn majority(&self) -> Decision {
        match self.positive.cmp(&self.negative) {
            std::cmp::Ordering::Greater => Decision::Sticks,
            std::cmp::Ordering::Less => Decision::DoesNotStick,
            _ if self.abstains == self.all() => Decision::Abstains,
            _ => Decision::Undecided,
        }
    }
}
