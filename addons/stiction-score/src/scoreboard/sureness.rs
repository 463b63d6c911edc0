//! Accuracy of limits of S and of probabilities near 0 and 1: whether the verdict is ever sure and wrong.

use super::{Scored, Share};
use stiction_diagnose::diagnose::VerdictClass;
use stiction_diagnose::series::quantile;

/// Probabilities up to and from which a verdict is sure.
pub const SURE: (f64, f64) = (0.02, 0.98);

/// Limits and sure probabilities against the truth. Unlike in every other measure, invisible stiction counts here,
/// because a limit applies to it, too.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Sureness {
    /// Share of the sticking loops with a known S and a reported limit whose S exceeds the limit.
    #[serde(rename = "S_above_limit")]
    pub above: Share,
    /// Share of the cleared sticking loops with a known S whose S exceeds their limit, or which have no limit.
    #[serde(rename = "cleared_above_limit")]
    pub cleared_above: Share,
    /// Sticking loops that are cleared, with any limit.
    #[serde(rename = "sticking_cleared")]
    pub cleared: Share,
    /// Median of the limits of healthy loops that are cleared, percent of span.
    #[serde(rename = "median_limit_of_cleared_healthy")]
    pub limit: Option<f64>,
    /// Share of the visible and healthy loops with a sure probability in which this probability is wrong.
    #[serde(rename = "sure_and_wrong")]
    pub wrong: Share,
    /// Number of visible and healthy loops with a sure probability.
    pub sure: Share,
}

impl Sureness {
    /// Counts loops; `None` if no loop has a limit or a sure probability.
    pub fn of(loops: &[Scored]) -> Option<Self> {
        let mut limits = vec![];
        let [mut above, mut cleared_above, mut cleared, mut wrong, mut sure] =
            [Share::default(); 5];
        let count = |share: &mut Share, hit: bool| {
            share.n += 1;
            share.k += usize::from(hit);
        };
        for each in loops {
            let truth = &each.truth;
            let clears = each.verdict == VerdictClass::DoesNotStick;
            if truth.sticks {
                count(&mut cleared, clears);
                // A seized valve, or one in another loop, has no S to compare.
                if let Some(s) = truth.s {
                    each.s_below.inspect(|limit| count(&mut above, s > *limit));
                    if clears {
                        count(&mut cleared_above, each.s_below.is_none_or(|limit| s > limit));
                    }
                }
            } else if clears {
                limits.extend(each.s_below);
            }
            if truth.visible || !truth.sticks {
                let is_sure = each.probability.filter(|p| *p <= SURE.0 || *p >= SURE.1);
                count(&mut sure, is_sure.is_some());
                is_sure.inspect(|p| count(&mut wrong, (*p > 0.5) != truth.sticks));
            }
        }
        (above.n + sure.k > 0).then(|| Self {
            above,
            cleared_above,
            cleared,
            limit: (!limits.is_empty()).then(|| quantile(&limits, 0.5)),
            wrong,
            sure,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoreboard::Truth;
    use crate::scoreboard::scored::tests as blank;

    fn scored(s: Option<f64>, visible: bool, p: f64, limit: Option<f64>) -> Scored {
        let truth = Truth { sticks: s.is_some(), visible, s, ..blank::truth() };
        let verdict = match p {
            p if p >= 0.9 => VerdictClass::Sticks,
            p if p <= 0.2 => VerdictClass::DoesNotStick,
            _ => VerdictClass::CannotTell,
        };
        Scored { s_below: limit, ..blank::scored(truth, verdict, Some(p)) }
    }

    #[test]
    fn what_is_promised_is_counted() {
        let loops = [
            scored(Some(3.0), true, 0.99, None),
            scored(Some(3.0), true, 0.01, Some(4.0)),
            scored(Some(3.0), true, 0.01, Some(2.0)),
            scored(Some(3.0), false, 0.01, None),
            scored(Some(3.0), false, 0.5, Some(1.0)),
            scored(None, false, 0.01, Some(0.5)),
            scored(None, false, 0.1, Some(1.5)),
            scored(None, false, 0.99, None),
        ];
        let found = Sureness::of(&loops).unwrap();
        assert_eq!(found.above, Share { k: 2, n: 3 });
        assert_eq!(found.cleared_above, Share { k: 2, n: 3 });
        assert_eq!(found.cleared, Share { k: 3, n: 5 });
        assert_eq!(found.limit, Some(1.0));
        // Two cleared and one accused wrongly; the hidden ones do not count.
        assert_eq!((found.wrong, found.sure), (Share { k: 3, n: 5 }, Share { k: 5, n: 6 }));
        assert_eq!(Sureness::of(&[]), None);
    }
}
