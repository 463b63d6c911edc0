//! Detected sticking valves by how clearly their records show them.

use super::band::Band;
use super::{Member, Scored, Share};
use stiction_diagnose::finding::Decision;

/// Lower ends of the bands of the gain, nats.
const GAINS: [f64; 6] = [15.0, 25.0, 50.0, 100.0, 200.0, 400.0];
/// Lower ends of the bands of the number of slips.
const SLIPS: [f64; 6] = [1.0, 3.0, 6.0, 11.0, 21.0, 51.0];

/// Detected sticking valves among the members of a mixed population whose records show them: visible loops whose own
/// valve slips. Valves that never move, and valves of a slave loop, have no gain and are left out.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Found {
    /// By the [gain](Member::gain) of an observer who knows the stem, nats.
    pub by_gain: Vec<FoundBand>,
    /// By the number of [slips](Member::slips).
    pub by_slips: Vec<FoundBand>,
}

/// Counts of the loops of one band.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct FoundBand {
    /// The band.
    #[serde(flatten)]
    pub band: Band,
    /// Accused loops: they stick, or do not respond.
    pub called: Share,
    /// Cleared loops.
    pub cleared: Share,
    /// Loops with a probability of 0.9 or more, with any verdict.
    pub p90: Share,
    /// Loops with a probability of 0.8 or more, with any verdict.
    pub p80: Share,
}

impl Found {
    /// Counts loops; `None` if no member shows its stiction.
    pub fn of(loops: &[Scored]) -> Option<Self> {
        let shown: Vec<(&Scored, Member)> = loops
            .iter()
            .filter(|each| each.truth.sticks && each.truth.visible)
            .filter_map(|each| Some((each, each.truth.member?)))
            .filter(|(_, member)| member.slips > 0 && member.gain >= GAINS[0])
            .collect();
        let by = |ends: &[f64], of: fn(&Member) -> f64| {
            let count = |band| FoundBand::of(band, &shown, of);
            Band::beginning_at(ends).into_iter().map(count).collect()
        };
        (!shown.is_empty()).then(|| Self {
            by_gain: by(&GAINS, |member| member.gain),
            by_slips: by(&SLIPS, |member| member.slips as f64),
        })
    }
}

impl FoundBand {
    fn of(band: Band, shown: &[(&Scored, Member)], of: fn(&Member) -> f64) -> Self {
        let within: Vec<&Scored> = shown
            .iter()
            .filter(|(_, member)| band.holds(of(member)))
            .map(|(each, _)| *each)
            .collect();
        let share = |is: &dyn Fn(&Scored) -> bool| Share::of(&within, |each| is(each));
        let likely = |from: f64| share(&|each| each.probability.is_some_and(|p| p >= from));
        Self {
            band,
            called: share(&|each| each.decision() == Decision::Sticks),
            cleared: share(&|each| each.decision() == Decision::DoesNotStick),
            p90: likely(0.9),
            p80: likely(0.8),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scoreboard::scored::tests::{scored, truth};
    use stiction_diagnose::diagnose::VerdictClass::{self, *};

    fn sticking(gain: f64, slips: usize, class: VerdictClass, p: Option<f64>) -> Scored {
        let member = Some(Member { gain, slips });
        scored(
            crate::scoreboard::Truth { sticks: true, visible: true, member, ..truth() },
            class,
            p,
        )
    }

    #[test]
    fn what_shows_is_counted_by_gain_and_by_slips() {
        let mut hidden = sticking(20.0, 4, Sticks, Some(0.99));
        hidden.truth.visible = false;
        let mut added = sticking(20.0, 4, Sticks, Some(0.99));
        added.truth.member = None;
        let loops = [
            sticking(15.6, 1, CannotTell, Some(0.85)),
            sticking(24.9, 2, DoesNotStick, Some(0.01)),
            sticking(25.0, 3, Sticks, Some(0.95)),
            sticking(900.0, 60, DoesNotRespond, Some(0.8)),
            sticking(16.0, 51, CannotTell, None),
            // Neither of these shows that its own valve slips.
            sticking(0.0, 5, Sticks, Some(0.99)),
            sticking(40.0, 0, Sticks, Some(0.99)),
            hidden,
            added,
        ];
        let found = Found::of(&loops).unwrap();
        let counts = |bands: &[FoundBand]| -> Vec<[usize; 5]> {
            let of = |b: &FoundBand| [b.called.n, b.called.k, b.cleared.k, b.p90.k, b.p80.k];
            bands.iter().map(of).collect()
        };
        let none = [0; 5];
        assert_eq!(
            counts(&found.by_gain),
            [[3, 0, 1, 0, 1], [1, 1, 0, 1, 1], none, none, none, [1, 1, 0, 0, 1]]
        );
        assert_eq!(
            counts(&found.by_slips),
            [[2, 0, 1, 0, 1], [1, 1, 0, 1, 1], none, none, none, [2, 1, 0, 0, 1]]
        );
        assert_eq!(Found::of(&loops[5..]), None);
    }
}
