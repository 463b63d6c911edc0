//! The verdict from the evidence in OP and PV.
//!
//! The probability of a fault decides. The training chose both thresholds of the [`Decision`] by their risk. A few
//! rules stand beside it, because the card of the model shows that each prevents more errors than it causes:
//!
//! | Evidence | Conclusion |
//! |---|---|
//! | OP and PV do not look like signals of one loop | cannot tell |
//! | The recording is unlike the training loops | cannot tell |
//! | The probability is above the threshold for a fault | sticks, or does not respond |
//! | The same, but S is [`HARMLESS`] or less | cannot tell: it would be no fault |
//! | The probability is below the threshold of a healthy valve, with a meaningful limit of S | does not stick by more than the limit |
//! | The same without such a limit | cannot tell: stiction would be masked |
//! | The probability is between the thresholds | cannot tell |
//!
//! # Limits
//! The thresholds hold for loops like the simulated ones; `docs/accuracy.md` reports how accurate verdicts are.

use super::reasons::{alternatives, sayings};
use super::verdict::{Basis, HARMLESS, Limit, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use crate::fusion::{self, Cause, Decision, LIMIT, Valves};
use crate::spoken::rough;

/// A limit is meaningful up to this many ranges of the OP. A valve that sticks by more than twice the OP range does
/// not move at all, from any initial position.
pub const LARGEST_LIMIT: f64 = 2.0;

/// The verdict from the evidence of one or more windows, beside the votes of the methods.
pub(super) fn by_evidence(weighing: &Weighing, votes: Votes) -> Verdict {
    let sayings = sayings(weighing);
    let ruling = Ruling::of(weighing);
    let class = ruling.class();
    let (mut reasons, mut contradictions) = (vec![], vec![]);
    for saying in sayings {
        let agrees = match class {
            VerdictClass::Sticks | VerdictClass::DoesNotRespond => saying.probability >= 0.5,
            VerdictClass::DoesNotStick => saying.probability < 0.5,
            VerdictClass::CannotTell => true,
        };
        if agrees { reasons.push(saying.sentence) } else { contradictions.push(saying.sentence) }
    }
    reasons.extend(ruling.sentence(weighing));
    if reasons.is_empty() {
        reasons.push("the lines of evidence are decisive only together".to_owned());
    }
    let concluded = match class {
        VerdictClass::DoesNotStick => None,
        VerdictClass::DoesNotRespond => Some(Cause::NoResponse),
        _ => Some(Cause::StickingValve),
    };
    let tells_limit = matches!(ruling, Ruling::Clears | Ruling::Blind | Ruling::Open);
    Verdict {
        class,
        basis: Basis::Evidence,
        probability: Some(weighing.probability),
        s_below: weighing
            .limit
            .filter(|_| tells_limit)
            .map(|value| Limit { value, confidence: LIMIT }),
        reasons,
        contradictions,
        alternatives: alternatives(weighing, concluded),
        votes,
        ..Verdict::default()
    }
}

/// The inputs of a decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signs {
    /// The probability of a fault.
    pub probability: f64,
    /// Distance of the recording from the training loops; above 1 it is unlike all of them.
    pub distance: f64,
    /// Whether OP and PV look like signals of one loop; above 1 they do not.
    pub mismatch: f64,
    /// Whether no response is likelier than sticking.
    pub idle: bool,
    /// S if the valve sticks, percent of the narrowest plausible span.
    pub s: f64,
    /// The detection limit, percent of the narrowest plausible span.
    pub limit: Option<f64>,
    /// Range of the OP, percent of the narrowest plausible span.
    pub op_range: f64,
}

impl Signs {
    fn of(weighing: &Weighing) -> Self {
        Self {
            probability: weighing.probability,
            distance: weighing.distance,
            mismatch: weighing.mismatch,
            idle: weighing.likelihood(Cause::NoResponse)
                > weighing.likelihood(Cause::StickingValve),
            s: weighing.s.value * weighing.doubt.most,
            limit: weighing.limit,
            op_range: weighing.op_range * weighing.doubt.most,
        }
    }
}

/// The thresholds of the model of a window in the library.
pub fn thresholds() -> Decision {
    fusion::shipped().map_or(Decision::CAUTIOUS, |bundle| bundle.decision)
}

/// The thresholds of the model of valves in the library, which weighs several windows together.
pub fn thresholds_of_several() -> Decision {
    Valves::shipped().map_or(Decision::CAUTIOUS, |valves| valves.decision)
}

/// The row of the table that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ruling {
    /// OP and PV do not belong to one loop.
    Mistaken,
    /// The recording is unlike the training loops.
    Strange,
    /// It sticks.
    Sticks,
    /// It does not respond.
    NoResponse,
    /// A fault by its probability, but S is too small to be one.
    Harmless,
    /// The limit is not meaningful.
    Blind,
    /// It does not stick.
    Clears,
    /// The probability is between the thresholds.
    Open,
}

impl Ruling {
    /// All rows, in the order of the table.
    pub const ALL: [Self; 8] = [
        Self::Mistaken,
        Self::Strange,
        Self::NoResponse,
        Self::Harmless,
        Self::Sticks,
        Self::Clears,
        Self::Blind,
        Self::Open,
    ];

    /// Name, as in `unlike the training`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mistaken => "mistaken columns",
            Self::Strange => "unlike the training",
            Self::NoResponse => "no response",
            Self::Harmless => "too little to be a fault",
            Self::Sticks => "sticks",
            Self::Clears => "does not stick",
            Self::Blind => "no meaningful limit",
            Self::Open => "probability between",
        }
    }

    /// The row for this evidence.
    pub fn of(weighing: &Weighing) -> Self {
        Self::of_signs(&Signs::of(weighing), &weighing.thresholds())
    }

    /// The row for these inputs.
    pub fn of_signs(signs: &Signs, decision: &Decision) -> Self {
        if signs.mismatch > 1.0 {
            return Self::Mistaken;
        }
        if signs.distance > 1.0 {
            return Self::Strange;
        }
        match signs.probability {
            p if p >= decision.accuse => match () {
                () if signs.idle => Self::NoResponse,
                () if signs.s <= HARMLESS => Self::Harmless,
                () => Self::Sticks,
            },
            p if p <= decision.clear => match signs.limit {
                Some(limit) if limit <= LARGEST_LIMIT * signs.op_range => Self::Clears,
                _ => Self::Blind,
            },
            _ => Self::Open,
        }
    }

    /// The class of this row.
    pub fn class(self) -> VerdictClass {
        match self {
            Self::Sticks => VerdictClass::Sticks,
            Self::NoResponse => VerdictClass::DoesNotRespond,
            Self::Clears => VerdictClass::DoesNotStick,
            Self::Mistaken | Self::Strange | Self::Harmless | Self::Blind | Self::Open => {
                VerdictClass::CannotTell
            }
        }
    }

    /// The sentence beside the lines of evidence.
    fn sentence(self, weighing: &Weighing) -> Option<String> {
        let limit = weighing.limit.map(rough);
        Some(match self {
            Self::Sticks | Self::NoResponse => return None,
            Self::Clears => format!(
                "S above {} % would have been detected ({:.0} % confidence)",
                limit?,
                100.0 * LIMIT
            ),
            Self::Mistaken => {
                "OP and PV do not look like signals of one loop, so check the columns".to_owned()
            }
            Self::Strange => match &weighing.strangest[..] {
                [] => {
                    "the recording is unlike the training loops in the combination of its features"
                        .to_owned()
                }
                some => format!("the recording is unlike the training loops ({})", some.join("; ")),
            },
            Self::Harmless => format!(
                "if the valve sticks, S is about {} %, which is no fault: healthy valves have dead bands of up to \
                 {HARMLESS} %",
                rough(weighing.s.value)
            ),
            Self::Blind => {
                match limit.filter(|_| weighing.limit < Some(100.0 * weighing.doubt.most)) {
                    Some(limit) => format!(
                        "S below {limit} % cannot be detected here, because the OP spans only {} %. Step the OP in \
                         manual",
                        rough(weighing.op_range)
                    ),
                    None => format!(
                        "stiction of any size would be masked here, because disturbances move the PV more than the \
                         OP range of {} % does. Record faster, or step the OP in manual",
                        rough(weighing.op_range)
                    ),
                }
            }
            Self::Open => "no line of evidence is strong enough".to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DECISION: Decision = Decision { accuse: 0.85, clear: 0.15 };

    fn signs(probability: f64) -> Signs {
        Signs {
            probability,
            distance: 0.2,
            mismatch: 0.1,
            idle: false,
            s: 3.0,
            limit: Some(1.5),
            op_range: 6.0,
        }
    }

    fn of(signs: Signs) -> Ruling {
        Ruling::of_signs(&signs, &DECISION)
    }

    #[test]
    fn the_thresholds_decide() {
        for (p, ruling) in [
            (0.01, Ruling::Clears),
            (DECISION.clear, Ruling::Clears),
            (DECISION.clear + 1e-9, Ruling::Open),
            (0.5, Ruling::Open),
            (DECISION.accuse - 1e-9, Ruling::Open),
            (DECISION.accuse, Ruling::Sticks),
            (0.999, Ruling::Sticks),
        ] {
            assert_eq!(of(signs(p)), ruling, "{p}");
        }
    }

    #[test]
    fn mistaken_and_strange_recordings_end_it() {
        for p in [0.01, 0.5, 0.999] {
            // Mistaken columns end it, however strange they are.
            let mistaken = Signs { mismatch: 1.1, distance: 9.0, ..signs(p) };
            assert_eq!(of(mistaken), Ruling::Mistaken);
            assert_eq!(of(Signs { distance: 1.1, ..signs(p) }), Ruling::Strange);
        }
        assert_eq!(Ruling::Mistaken.class(), VerdictClass::CannotTell);
    }

    #[test]
    fn what_forbids_to_accuse_clears_nobody_and_the_reverse() {
        let accused = signs(0.95);
        assert_eq!(of(Signs { idle: true, ..accused }), Ruling::NoResponse);
        assert_eq!(of(Signs { s: HARMLESS, ..accused }), Ruling::Harmless);
        assert_eq!(of(Signs { limit: None, ..accused }), Ruling::Sticks);
        let cleared = signs(0.01);
        assert_eq!(of(Signs { limit: None, ..cleared }), Ruling::Blind);
        let large = Some(LARGEST_LIMIT * 6.0 + 0.1);
        assert_eq!(of(Signs { limit: large, ..cleared }), Ruling::Blind);
        assert_eq!(of(Signs { s: 0.1, ..cleared }), Ruling::Clears);
    }

    #[test]
    fn the_shipped_thresholds_leave_room() {
        assert!(thresholds().checked().is_ok());
    }
}
