//! Undecided loops, by the rule that prevents the decision.

use super::band::Band;
use super::{Scored, Share};
use stiction_diagnose::diagnose::{Ruling, VerdictClass};

/// Lower ends of the bands of the probability.
const PROBABILITIES: [f64; 5] = [0.0, 0.2, 0.5, 0.8, 0.9];

/// The undecided members of a mixed population; those with an invisible fault are left out.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Undecided {
    /// Their share of the members.
    pub all: Share,
    /// By rule and probability; rows without loops are left out.
    pub rows: Vec<HeldBack>,
}

/// Undecided loops with the same rule and a similar probability.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct HeldBack {
    /// The rule; `None` if the evidence is not the reason, for example without a probability.
    pub ruling: Option<Ruling>,
    /// The probability of a fault; `None` without a probability.
    pub probability: Option<Band>,
    /// Their share of the members.
    pub loops: Share,
    /// Number of faulty valves among them.
    pub at_fault: Share,
}

impl Undecided {
    /// Counts loops; `None` without a member.
    pub fn of(loops: &[Scored]) -> Option<Self> {
        let members: Vec<&Scored> = loops
            .iter()
            .filter(|each| each.truth.member.is_some())
            .filter(|each| each.truth.visible || !each.truth.sticks)
            .collect();
        let undecided: Vec<&Scored> = members
            .iter()
            .copied()
            .filter(|each| each.verdict == VerdictClass::CannotTell)
            .collect();
        let bands: Vec<_> =
            Band::beginning_at(&PROBABILITIES).into_iter().map(Some).chain([None]).collect();
        let mut rows = vec![];
        for ruling in Ruling::ALL.into_iter().map(Some).chain([None]) {
            for probability in &bands {
                let (mut loops, mut at_fault) = (0, 0);
                for each in &undecided {
                    let within = match (probability, each.probability) {
                        (Some(band), Some(p)) => band.holds(p),
                        (None, None) => true,
                        _ => false,
                    };
                    if within && each.undecided_by == ruling {
                        loops += 1;
                        at_fault += usize::from(each.truth.sticks);
                    }
                }
                if loops > 0 {
                    rows.push(HeldBack {
                        ruling,
                        probability: *probability,
                        loops: Share { k: loops, n: members.len() },
                        at_fault: Share { k: at_fault, n: loops },
                    });
                }
            }
        }
        let all = Share { k: undecided.len(), n: members.len() };
        (!members.is_empty()).then_some(Self { all, rows })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoreboard::scored::tests::{scored, truth};
    use crate::scoreboard::{Member, Truth};

    fn open(sticks: bool, ruling: Option<Ruling>, p: Option<f64>) -> Scored {
        let member = Some(Member { gain: 0.0, slips: 0 });
        let truth = Truth { sticks, visible: sticks, member, ..truth() };
        Scored { undecided_by: ruling, ..scored(truth, VerdictClass::CannotTell, p) }
    }

    #[test]
    fn every_undecided_member_is_in_one_row() {
        let mut decided = open(true, None, Some(0.99));
        decided.verdict = VerdictClass::Sticks;
        let mut hidden = open(true, Some(Ruling::Open), Some(0.6));
        hidden.truth.visible = false;
        let mut added = open(true, Some(Ruling::Open), Some(0.6));
        added.truth.member = None;
        let loops = [
            open(true, Some(Ruling::Open), Some(0.5)),
            open(false, Some(Ruling::Open), Some(0.79)),
            open(false, Some(Ruling::Open), Some(0.2)),
            open(false, Some(Ruling::Blind), Some(0.01)),
            open(true, None, None),
            open(true, Some(Ruling::Harmless), Some(1.0)),
            decided,
            hidden,
            added,
        ];
        let found = Undecided::of(&loops).unwrap();
        assert_eq!(found.all, Share { k: 6, n: 7 });
        let row = |held: &HeldBack| {
            let from = held.probability.map(|band| band.from);
            (held.ruling, from, held.loops.k, held.at_fault.k)
        };
        assert_eq!(
            found.rows.iter().map(row).collect::<Vec<_>>(),
            [
                (Some(Ruling::Harmless), Some(0.9), 1, 1),
                (Some(Ruling::Blind), Some(0.0), 1, 0),
                (Some(Ruling::Open), Some(0.2), 1, 0),
                (Some(Ruling::Open), Some(0.5), 2, 1),
                (None, None, 1, 1),
            ]
        );
        assert_eq!(found.rows.iter().map(|held| held.loops.k).sum::<usize>(), found.all.k);
        assert!(found.rows.iter().all(|held| held.loops.n == 7 && held.at_fault.n == held.loops.k));
        assert_eq!(Undecided::of(&loops[8..]), None);
        assert_eq!(Undecided::of(&loops[6..7]).unwrap().rows, []);
    }
}
