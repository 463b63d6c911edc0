//! The verdict by the evidence in OP and PV.
//!
//! The probability of a fault decides, by the two thresholds of the [`Decision`], which the training chose by the risk
//! that they run. Few rules stand beside it, each because the card of the model shows that it prevents more than it
//! costs:
//!
//! | what is seen | what is concluded |
//! |---|---|
//! | OP and PV that do not look like those of one loop | cannot tell |
//! | a recording unlike anything the model was trained on | cannot tell |
//! | a fault as likely as is needed to accuse | sticks, or does not respond |
//! | the same, but an S of [`HARMLESS`] or less | cannot tell: it would be no fault |
//! | a fault as unlikely as is needed to clear, and a limit of S that means something | does not stick, by more than that |
//! | the same without such a limit | cannot tell: what lies below could not be seen |
//! | what lies between | cannot tell |
//!
//! # Limits
//! The thresholds hold for loops like the simulated ones; `docs/accuracy.md` tells what verdicts are worth.

use super::reasons::{alternatives, sayings};
use super::verdict::{Basis, HARMLESS, Limit, Verdict, VerdictClass};
use super::weighing::Weighing;
use crate::fusion::{self, Cause, Decision, LIMIT};
use crate::spoken::rough;

/// A limit means something up to so many ranges of the OP: a valve that sticks by more than twice what its OP
/// travels does not move at all, wherever it stood at first.
pub const LARGEST_LIMIT: f64 = 2.0;

/// What is concluded of a window's worth of evidence or more; `preliminary` is what the published methods say.
pub(super) fn by_evidence(weighing: &Weighing, preliminary: Verdict) -> Verdict {
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
        ..preliminary
    }
}

/// What a decision looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signs {
    /// The probability of a fault.
    pub probability: f64,
    /// How far the recording is from the loops of training; above 1 it is unlike all of them.
    pub distance: f64,
    /// Whether OP and PV look like those of one loop; above 1 they do not.
    pub mismatch: f64,
    /// Whether no response is likelier than sticking.
    pub idle: bool,
    /// S if the valve sticks, percent of span.
    pub s: f64,
    /// The detection limit, percent of span.
    pub limit: Option<f64>,
    /// Range of the OP, percent of span.
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
            s: weighing.s.value,
            limit: weighing.limit,
            op_range: weighing.op_range,
        }
    }
}

/// The thresholds of the model that comes with the library.
pub fn thresholds() -> Decision {
    fusion::shipped().map_or(Decision::CAUTIOUS, |bundle| bundle.decision)
}

/// The row of the table that decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ruling {
    /// OP and PV are not those of one loop.
    Mistaken,
    /// The recording is unlike anything the model was trained on.
    Strange,
    /// It sticks.
    Sticks,
    /// It does not respond.
    NoResponse,
    /// Accused, but by so little that it is no fault.
    Harmless,
    /// Cleared, but for a limit.
    Blind,
    /// It does not stick.
    Clears,
    /// The probability lies between.
    Open,
}

impl Ruling {
    /// All of them, in the order in which the table asks.
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

    /// Its name, as in `unlike the training`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mistaken => "mistaken columns",
            Self::Strange => "unlike the training",
            Self::NoResponse => "no response",
            Self::Harmless => "too little to be a fault",
            Self::Sticks => "sticks",
            Self::Clears => "does not stick",
            Self::Blind => "no limit that means something",
            Self::Open => "probability between",
        }
    }

    /// What the table says of this evidence.
    pub fn of(weighing: &Weighing) -> Self {
        Self::of_signs(&Signs::of(weighing), &thresholds())
    }

    /// What the table says of these signs.
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

    /// The class that it gives.
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

    /// What is to be said beside the lines of evidence.
    fn sentence(self, weighing: &Weighing) -> Option<String> {
        let limit = weighing.limit.map(rough);
        Some(match self {
            Self::Sticks | Self::NoResponse => return None,
            Self::Clears => format!(
                "had it stuck by more than {} %, this recording would have shown it ({:.0} %)",
                limit?,
                100.0 * LIMIT
            ),
            Self::Mistaken => {
                "OP and PV do not look like those of one loop: check which column is which"
                    .to_owned()
            }
            Self::Strange => match &weighing.strangest[..] {
                [] => "the recording is unlike anything the model was trained on: no number of it is, but they \
                       do not go together"
                    .to_owned(),
                some => format!(
                    "the recording is unlike anything the model was trained on ({})",
                    some.join("; ")
                ),
            },
            Self::Harmless => format!(
                "if it sticks, then by some {} %, which is no fault: valves in good order have dead bands of up \
                 to {HARMLESS} %",
                rough(weighing.s.value)
            ),
            Self::Blind => match limit.filter(|_| weighing.limit < Some(100.0)) {
                Some(limit) => format!(
                    "sticking by less than {limit} % could not be seen here, because the OP travels only {} %: \
                     record longer, or step the OP in manual",
                    rough(weighing.op_range)
                ),
                None => format!(
                    "no sticking could be seen here, however large: what the OP does ({} % of travel) is lost \
                     in what else moves the PV; record longer, faster, or step the OP in manual",
                    rough(weighing.op_range)
                ),
            },
            Self::Open => "no line of evidence is clear enough".to_owned(),
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
