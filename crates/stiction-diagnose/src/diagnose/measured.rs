//! The verdict on a valve with a recorded position: class, S, J and sentences from one judgement.
//!
//! Where the position leaves open whether the valve sticks, OP and PV may still accuse it ([`ByPosition::verdict`]). A
//! position that is sampled more slowly than the controller acts may show less than OP and PV. They do not clear it,
//! because the limit from the position is usually the smaller one.

use super::verdict::{Basis, Limit, Stiction, Verdict, VerdictClass};
use crate::finding::Abstention;
use crate::fusion::{COVERAGE, Estimate, LIMIT};
use crate::identify::lagged_position::{Behaviour, Interval, Judgement, Moves};
use crate::methods::Subject;
use crate::recording::Doubt;
use crate::recording::fitness::{Class, Fitness, MeasureId};
use crate::spoken::rough;

/// Measures of fitness that a position needs, too. All others concern the PV, or cycles, which a position does not
/// need.
const NEEDED: [MeasureId; 4] = [
    MeasureId::AutomaticSegment,
    MeasureId::BridgedSamples,
    MeasureId::Samples,
    MeasureId::OpMoves,
];

/// Largest width of the interval of S, as a share of S, at which S is a number although moves of the OP between samples
/// are missed; ours. Of 71 simulated valves with wider intervals, S was wrong by more than 15 % in 33. Of 58 valves
/// with narrower intervals, it was wrong in 3.
pub const WIDEST_MISSED: f64 = 0.5;

/// The verdict from a recorded position. Class, S, J, limit and reasons come from the same judgement:
///
/// | Judgement | Class | S and J | Limit of S |
/// |---|---|---|---|
/// | sticks | sticks | those of the fit, if moves are missed only up to half of S wide | none |
/// | follows | does not stick | none | below 1 % |
/// | does not move | does not respond | none | none |
/// | open | cannot tell | none | the largest S that the recording allows |
#[derive(Debug, Clone, PartialEq)]
pub struct ByPosition {
    /// The conclusion.
    pub class: VerdictClass,
    /// Why, in sentences.
    pub reasons: Vec<String>,
    /// Size of the stiction, if it sticks.
    pub stiction: Stiction,
    /// With 95 % confidence S is below this, percent; `None` if it sticks, does not respond, or has no bound.
    pub s_limit: Option<f64>,
}

impl ByPosition {
    /// The result for signals whose spans are in doubt. Limit and amounts then hold for every plausible span.
    pub(super) fn in_doubt(mut self, doubt: Doubt) -> Self {
        self.s_limit = self.s_limit.map(|limit| limit * doubt.most);
        self.stiction.s = self.stiction.s.map(|s| doubt.widen(s));
        self.stiction.j = self.stiction.j.map(|j| doubt.widen(j));
        self
    }
}

/// The verdict from the position, or why there is none; `None` if no position is recorded.
pub fn by_position(
    subject: &Subject<'_>,
    fitness: &Fitness,
) -> Option<Result<ByPosition, Abstention>> {
    subject.segment.vp.as_ref()?;
    let unfit = fitness.measures.iter().find(|m| m.class == Class::Unfit && NEEDED.contains(&m.id));
    Some(match unfit {
        Some(measure) => Err(Abstention(measure.reason.clone())),
        None => subject.position().map(|judged| concluded(judged, subject.segment.sample_time)),
    })
}

/// From judgement to verdict.
pub(super) fn concluded(judged: &Judgement, sample_time: f64) -> ByPosition {
    let class = match judged.behaviour {
        Behaviour::Sticks => VerdictClass::Sticks,
        Behaviour::Follows => VerdictClass::DoesNotStick,
        Behaviour::DoesNotMove => VerdictClass::DoesNotRespond,
        Behaviour::Open => VerdictClass::CannotTell,
    };
    let mut reasons = vec![judged.sentence(sample_time)];
    reasons.extend(match judged.behaviour {
        Behaviour::DoesNotMove => Some(format!(
            "possible causes: seized, shut off, no air, manual override, or a dead position transmitter{}",
            match judged.op_travel {
                travel if travel < 20.0 => "; or S is larger than the OP travel",
                _ => "",
            }
        )),
        Behaviour::Open => {
            let wanted = match judged.moves {
                Moves::MayBeMissed => {
                    "a record at the rate of the controller, or steps of the OP in manual, may decide"
                }
                Moves::Recorded => "a longer record, or steps of the OP in manual, may decide",
            };
            Some(wanted.to_owned())
        }
        Behaviour::Sticks | Behaviour::Follows => None,
    });
    let estimate = |Interval { value, low, high }: Interval| Estimate { value, low, high };
    let is_wide = judged.moves == Moves::MayBeMissed
        && judged.s.high - judged.s.low > WIDEST_MISSED * judged.s.value;
    let sticks = class == VerdictClass::Sticks && !is_wide;
    let why_not = match judged.behaviour {
        Behaviour::Sticks if is_wide => Some(format!(
            "S is between {} and {} % ({:.0} % interval), too wide for a number, because the controller may have \
             acted between two samples; record at the controller's rate",
            rough(judged.s.low),
            rough(judged.s.high),
            100.0 * COVERAGE
        )),
        Behaviour::Sticks => None,
        Behaviour::Follows => Some("by its measured position, the valve does not stick".to_owned()),
        Behaviour::DoesNotMove => Some("a valve that does not respond never slips".to_owned()),
        Behaviour::Open => {
            Some("the measured position cannot show whether the valve sticks".to_owned())
        }
    };
    let bounded = matches!(judged.behaviour, Behaviour::Follows | Behaviour::Open);
    ByPosition {
        class,
        reasons,
        stiction: Stiction {
            model: sticks.then(|| {
                format!(
                    "a valve with a lag, fitted to the measured position (R² {:.1} %)",
                    100.0 * judged.explained
                )
            }),
            s: sticks.then(|| estimate(judged.s)),
            j: sticks.then(|| estimate(judged.j)),
            coverage: sticks.then_some(COVERAGE),
            why_not,
            definitions: vec![],
        },
        s_limit: (bounded && judged.s_limit.is_finite()).then_some(judged.s_limit),
    }
}

impl ByPosition {
    /// The verdict from the position, which replaces the verdict from OP and PV because the position shows the stem
    /// itself. If it leaves open whether the valve sticks, OP and PV may accuse the valve, unless their `S` is above
    /// the position's limit. If it does not move, but OP and PV show a stem that slips, its transmitter has failed. A
    /// stem that follows stands against their accusation.
    pub fn verdict(&self, without: Verdict, s: Option<Estimate>) -> Verdict {
        let accuse = without.basis == Basis::Evidence && without.class == VerdictClass::Sticks;
        let agree = s.zip(self.s_limit).is_none_or(|(s, limit)| s.low <= limit);
        let first = self.reasons.first().cloned();
        match self.class {
            VerdictClass::CannotTell if accuse && agree => {
                let mut verdict = without;
                verdict.reasons.extend(first);
                return verdict;
            }
            VerdictClass::DoesNotRespond if accuse => {
                let mut verdict = without;
                let failed = |first| format!("{first}, so its transmitter seems to have failed");
                verdict.contradictions.extend(first.map(failed));
                return verdict;
            }
            _ => {}
        }
        let against = self.class == VerdictClass::DoesNotStick && accuse;
        let probability = without.probability.filter(|_| against);
        let contradictions = probability.map(|p| {
            format!(
                "by OP and PV alone the valve sticks ({}); check that the position is that of this stem",
                crate::spoken::percent(p)
            )
        });
        Verdict {
            class: self.class,
            basis: Basis::ValvePosition,
            probability: None,
            s_below: self.s_limit.map(|value| Limit { value, confidence: LIMIT }),
            reasons: self.reasons.clone(),
            contradictions: contradictions.into_iter().collect(),
            alternatives: vec![],
            ..without
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn op_and_pv_accuse_where_the_position_leaves_it_open() {
        let open = ByPosition {
            class: VerdictClass::CannotTell,
            reasons: vec!["by the measured position, S may be up to 4 %".to_owned()],
            stiction: Stiction::default(),
            s_limit: Some(4.0),
        };
        let found = |class| Verdict {
            class,
            basis: Basis::Evidence,
            probability: Some(0.95),
            ..Verdict::default()
        };
        let s = |low: f64| Some(Estimate { value: low + 1.0, low, high: low + 2.0 });
        let verdict = open.verdict(found(VerdictClass::Sticks), s(2.0));
        assert_eq!((verdict.class, verdict.basis), (VerdictClass::Sticks, Basis::Evidence));
        assert_eq!(verdict.reasons, open.reasons);
        // The position excludes that S.
        let verdict = open.verdict(found(VerdictClass::Sticks), s(5.0));
        assert_eq!(
            (verdict.class, verdict.basis),
            (VerdictClass::CannotTell, Basis::ValvePosition)
        );
        // They do not clear it, and not against a position that decides.
        let verdict = open.verdict(found(VerdictClass::DoesNotStick), None);
        assert_eq!(verdict.class, VerdictClass::CannotTell);
        let follows = ByPosition { class: VerdictClass::DoesNotStick, ..open };
        let verdict = follows.verdict(found(VerdictClass::Sticks), s(2.0));
        assert_eq!(verdict.class, VerdictClass::DoesNotStick);
    }
}
