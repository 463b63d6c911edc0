//! The verdict on a valve whose position is recorded: class, S, J and words from one judgement.

use super::verdict::{Basis, Limit, Stiction, Verdict, VerdictClass};
use crate::finding::Abstention;
use crate::fusion::{COVERAGE, Estimate, LIMIT};
use crate::identify::lagged_position::{Behaviour, Interval, Judgement, Moves};
use crate::methods::Subject;
use crate::recording::fitness::{Class, Fitness, MeasureId};

/// Measures of fitness without which a position says nothing either. All others are about the PV, or about cycles,
/// which a position does not need.
const NEEDED: [MeasureId; 4] = [
    MeasureId::AutomaticSegment,
    MeasureId::BridgedSamples,
    MeasureId::Samples,
    MeasureId::OpMoves,
];

/// What a recorded position says of the valve. Class, S, J, limit and reasons come from the same judgement:
///
/// | judgement | class | S and J | limit of S |
/// |---|---|---|---|
/// | sticks | sticks | those of the fit | none |
/// | follows | does not stick | none | below 1 % |
/// | does not move | does not respond | none | none |
/// | open | cannot tell | none | what the recording leaves possible |
#[derive(Debug, Clone, PartialEq)]
pub struct ByPosition {
    /// The conclusion.
    pub class: VerdictClass,
    /// Why, in sentences.
    pub reasons: Vec<String>,
    /// How much it sticks, where it does.
    pub stiction: Stiction,
    /// With 95 % confidence S is below this, percent; `None` where it sticks or does not respond, or where nothing
    /// bounds it.
    pub s_limit: Option<f64>,
}

/// What the position says, or why it says nothing; `None` if none is recorded.
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
            "it is seized, shut off, without air, in manual override, or its transmitter is dead{}",
            match judged.op_travel {
                travel if travel < 20.0 => "; or it sticks by more than the OP travels",
                _ => "",
            }
        )),
        Behaviour::Open => {
            let wanted = match judged.moves {
                Moves::MayBeMissed => {
                    "a record at the rate at which the controller acts would tell, or steps of the OP in manual"
                }
                Moves::Recorded => "a longer record would tell, or steps of the OP in manual",
            };
            Some(wanted.to_owned())
        }
        Behaviour::Sticks | Behaviour::Follows => None,
    });
    let estimate = |Interval { value, low, high }: Interval| Estimate { value, low, high };
    let sticks = class == VerdictClass::Sticks;
    let why_not = match judged.behaviour {
        Behaviour::Sticks => None,
        Behaviour::Follows => Some("the valve does not stick by its measured position"),
        Behaviour::DoesNotMove => Some("a valve that does not respond never slips"),
        Behaviour::Open => Some("the measured position leaves open whether the valve sticks"),
    };
    let bounded = matches!(judged.behaviour, Behaviour::Follows | Behaviour::Open);
    ByPosition {
        class,
        reasons,
        stiction: Stiction {
            model: sticks.then(|| {
                format!(
                    "a valve with a lag fitted to the measured position, of which it explains {:.1} %",
                    100.0 * judged.explained
                )
            }),
            s: sticks.then(|| estimate(judged.s)),
            j: sticks.then(|| estimate(judged.j)),
            coverage: sticks.then_some(COVERAGE),
            why_not: why_not.map(str::to_owned),
            definitions: vec![],
        },
        s_limit: (bounded && judged.s_limit.is_finite()).then_some(judged.s_limit),
    }
}

impl ByPosition {
    /// The verdict in place of what OP and PV alone would give: the stem has been seen.
    pub fn verdict(&self, without: Verdict) -> Verdict {
        Verdict {
            class: self.class,
            basis: Basis::ValvePosition,
            probability: None,
            s_below: self.s_limit.map(|value| Limit { value, confidence: LIMIT }),
            reasons: self.reasons.clone(),
            contradictions: vec![],
            alternatives: vec![],
            ..without
        }
    }
}
