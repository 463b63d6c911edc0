//! Records that look stuck with too few slips for a sure verdict: by how much to step the OP.
//!
//! Waiting for more slips does not help. Of 156 such records of the population, 29 (19 %) were decided by the record in which
//! eight slips would occur at the same rate (2026-11-28), and of 41 others 14 by eight times the record (example
//! `record_longer` of the population). Steps of one size hardly help more: of eleven loops (sticky, from seed 500 on) they
//! decided three, the planned test all (2026-11-29). So the advice is the test.

use super::weighing::Weighing;
use crate::evidence::Evidence;
use crate::spoken::{counted, rough};

/// Slips that a record needs; more make the verdict hardly surer.
///
/// Of 1,787 sticking loops of the population (version 3, seeds from 9,000), consider those that can show stiction
/// and look stuck, with a probability of at least one half. They are accused depending on the number of slips of
/// the best valve model: 31 % of 49 with one, 50 % of 342 with two to seven, 63 % of 115 with eight to thirteen, 62
/// % of 78 with fourteen to nineteen, 69 % of 425 with more. From eight slips the share hardly rises.
pub const NEEDED: usize = 8;
/// The probability from which a record looks stuck.
pub const LOOKS_STUCK_FROM: f64 = 0.5;
/// A step must exceed S by this share to move the valve for sure.
const BEYOND: f64 = 1.5;

/// The number of slips of a valve that looks stuck but slips too rarely to decide.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct FewSlips {
    /// Number of slips of the best valve model in all windows, scaled to the whole record.
    pub seen: usize,
    /// Number of slips that a decision needs.
    pub needed: usize,
    /// Size of OP steps that would make the valve slip, percent of span: 1.5 times the estimated S.
    pub step: f64,
    /// Numbers of slips and size of the OP steps, in a sentence.
    pub words: String,
}

/// The lack of slips in a record of `duration_s`; `None` if the record does not look stuck, has enough slips, or the
/// slips cannot be counted.
pub fn few_slips(weighing: &Weighing, duration_s: f64) -> Option<FewSlips> {
    if weighing.probability < LOOKS_STUCK_FROM || weighing.mismatch > 1.0 {
        return None;
    }
    let (seen, time) = weighing.present().fold((0.0, 0.0), |(seen, time), (window, evidence)| {
        match slips(evidence) {
            Some(slips) => (seen + slips, time + window.duration),
            None => (seen, time),
        }
    });
    // Spread windows: the valve slips as often between them. Overlapping windows: fewer slips were seen.
    let seen = (seen * duration_s / time).round();
    if !seen.is_finite() || !(duration_s > 0.0) {
        return None;
    }
    of(seen as usize, weighing.s.value)
}

/// The lack of slips in a record with this many slips of a valve of this S.
fn of(seen: usize, s: f64) -> Option<FewSlips> {
    if seen >= NEEDED {
        return None;
    }
    let step = BEYOND * s;
    let words = format!(
        "looks stuck, with {} of the {NEEDED} needed; OP steps of {} % up and down should cause the missing slips",
        counted(seen, "slip"),
        rough(step)
    );
    Some(FewSlips { seen, needed: NEEDED, step, words })
}

/// Slips of the best valve model in a window.
fn slips(evidence: &Evidence) -> Option<f64> {
    let value = |name: &str| evidence.get(name).filter(|v| v.is_finite());
    Some(value("slip_rate")? * value("cycles")?.exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_reported() {
        let few = of(2, 3.0).unwrap();
        assert_eq!((few.seen, few.needed, few.step), (2, 8, 4.5));
        assert_eq!(
            few.words,
            "looks stuck, with 2 slips of the 8 needed; OP steps of 4.5 % up and down should cause the missing slips"
        );
        assert!(of(1, 1.0).unwrap().words.contains("with 1 slip of"));
        assert_eq!(of(NEEDED, 2.0), None);
    }
}
