//! Counts of decisions, and shares of them with their intervals.

use stiction_diagnose::finding::Decision;
use stiction_diagnose::methods::Counts;

/// Decisions of a method, or of the verdict, on sticking and on healthy loops.
///
/// Abstaining and undecided is neither right nor wrong: it lowers recall, and raises no alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outcomes {
    /// On those that stick.
    pub sticky: Counts,
    /// On those that do not.
    pub healthy: Counts,
}

/// [`Outcomes`] in a document.
#[derive(serde::Serialize, schemars::JsonSchema)]
struct OutcomesDocument {
    /// On those that stick.
    sticky: Counts,
    /// On those that do not.
    healthy: Counts,
    /// The share of the sticking loops that are called sticking.
    recall: Share,
    /// The share of the healthy loops that are called sticking.
    false_alarms: Share,
    /// The share of true ones among the loops called sticking.
    precision: Share,
    /// The share of the loops on which there is no decision.
    without_decision: Share,
    /// The share of the decisions that are right.
    accuracy_of_decided: Share,
}

stiction_model::written_as!(Outcomes, OutcomesDocument);

impl From<&Outcomes> for OutcomesDocument {
    fn from(of: &Outcomes) -> Self {
        Self {
            sticky: of.sticky,
            healthy: of.healthy,
            recall: of.recall(),
            false_alarms: of.false_alarms(),
            precision: of.precision(),
            without_decision: of.without_decision(),
            accuracy_of_decided: of.accuracy(),
        }
    }
}

impl Outcomes {
    /// Counts one more decision.
    pub fn add(&mut self, sticks: bool, decision: Decision) {
        if sticks { self.sticky.add(decision) } else { self.healthy.add(decision) }
    }

    /// All loops.
    pub fn all(&self) -> usize {
        self.sticky.all() + self.healthy.all()
    }

    /// The share of the sticking loops that are called sticking.
    pub fn recall(&self) -> Share {
        Share { k: self.sticky.positive, n: self.sticky.all() }
    }

    /// The share of the healthy loops that are called sticking.
    pub fn false_alarms(&self) -> Share {
        Share { k: self.healthy.positive, n: self.healthy.all() }
    }

    /// The share of true ones among the loops called sticking. It depends on the number of sticking loops.
    pub fn precision(&self) -> Share {
        Share { k: self.sticky.positive, n: self.sticky.positive + self.healthy.positive }
    }

    /// The share of the loops on which there is no decision.
    pub fn without_decision(&self) -> Share {
        Share { k: self.all() - self.decided(), n: self.all() }
    }

    /// The share of the decisions that are right.
    pub fn accuracy(&self) -> Share {
        Share { k: self.sticky.positive + self.healthy.negative, n: self.decided() }
    }

    fn decided(&self) -> usize {
        let of = |counts: Counts| counts.positive + counts.negative;
        of(self.sticky) + of(self.healthy)
    }
}

/// `k` of `n`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// The count.
    pub k: usize,
    /// The total.
    pub n: usize,
}

/// A [`Share`] in a document.
#[derive(serde::Serialize, schemars::JsonSchema)]
struct ShareDocument {
    /// The count.
    k: usize,
    /// The total.
    n: usize,
    /// `k / n`; null for none.
    value: Option<f64>,
    /// Lower end of the 95 % interval.
    low: f64,
    /// Upper end of the 95 % interval.
    high: f64,
}

stiction_model::written_as!(Share, ShareDocument);

impl From<&Share> for ShareDocument {
    fn from(of: &Share) -> Self {
        let (low, high) = of.interval();
        Self { k: of.k, n: of.n, value: of.value(), low, high }
    }
}

impl Share {
    /// The share of `all` for which `is` is true.
    pub fn of<T>(all: &[T], is: impl Fn(&T) -> bool) -> Self {
        Self { k: all.iter().filter(|one| is(one)).count(), n: all.len() }
    }

    /// `k / n`; `None` for none.
    pub fn value(self) -> Option<f64> {
        (self.n > 0).then(|| self.k as f64 / self.n as f64)
    }

    /// 95 % interval of the share, see [`wilson`]. It assumes independent loops.
    pub fn interval(self) -> (f64, f64) {
        wilson(self.k, self.n)
    }
}

/// The 95 % interval of a share with `k` of `n` counted; 0 to 1 for none.
///
/// Source: E. B. Wilson, "Probable inference, the law of succession, and statistical inference",
/// J. Am. Stat. Assoc. 22 (1927) 209-212.
pub fn wilson(k: usize, n: usize) -> (f64, f64) {
    if n == 0 {
        return (0.0, 1.0);
    }
    /// The normal quantile below the top 2.5 %.
    const Z: f64 = 1.959_963_984_540_054;
    let (n, share) = (n as f64, k as f64 / n as f64);
    let z2 = Z * Z / n;
    let middle = share + z2 / 2.0;
    let half = Z * (share * (1.0 - share) / n + z2 / (4.0 * n)).sqrt();
    (((middle - half) / (1.0 + z2)).max(0.0), ((middle + half) / (1.0 + z2)).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_shares() {
        // Ten of a hundred: 5.5 % to 17.4 %, as tabulated everywhere.
        let (low, high) = wilson(10, 100);
        assert!((low - 0.0552).abs() < 1e-4 && (high - 0.1744).abs() < 1e-4, "{low} {high}");
        assert_eq!(wilson(0, 0), (0.0, 1.0));
        assert!(wilson(0, 50).0 < 1e-12);
        assert!(wilson(50, 50).1 == 1.0 && wilson(50, 50).0 > 0.92);
    }

    #[test]
    fn shares_of_outcomes() {
        use Decision::{Abstains, DoesNotStick, Sticks, Undecided};
        let mut outcomes = Outcomes::default();
        for (sticks, decision) in [
            (true, Sticks),
            (true, Sticks),
            (true, DoesNotStick),
            (true, Undecided),
            (false, Sticks),
            (false, DoesNotStick),
            (false, Abstains),
        ] {
            outcomes.add(sticks, decision);
        }
        let share = |k, n| Share { k, n };
        assert_eq!(outcomes.recall(), share(2, 4));
        assert_eq!(outcomes.false_alarms(), share(1, 3));
        assert_eq!(outcomes.precision(), share(2, 3));
        assert_eq!(outcomes.without_decision(), share(2, 7));
        assert_eq!(outcomes.accuracy(), share(3, 5));
        assert_eq!(outcomes.recall().value(), Some(0.5));
        assert_eq!(Outcomes::default().accuracy().value(), None);
    }

    #[test]
    fn majorities() {
        let of = |decisions: &[Decision]| {
            let mut counts = Counts::default();
            decisions.iter().for_each(|d| counts.add(*d));
            counts.majority()
        };
        use Decision::{Abstains, DoesNotStick, Sticks, Undecided};
        assert_eq!(of(&[Sticks, Sticks, DoesNotStick, Abstains]), Sticks);
        assert_eq!(of(&[Sticks, DoesNotStick]), Undecided);
        assert_eq!(of(&[Abstains, Abstains]), Abstains);
        assert_eq!(of(&[Abstains, Undecided]), Undecided);
        assert_eq!(of(&[]), Abstains);
    }
}
