//! The verdict by the evidence in OP and PV.
//!
//! A probability near 0 or 1 alone decides nothing. What it says must be borne out:
//!
//! | what is seen | what is concluded |
//! |---|---|
//! | OP and PV that do not look like those of one loop | cannot tell |
//! | a recording unlike anything the model was trained on | cannot tell |
//! | lines of evidence that are sure of the opposite of each other | cannot tell |
//! | a fault at [`ACCUSED_FROM`] or more, and a dead zone elsewhere below [`DEAD_ZONE_BELOW`] | sticks, or does not respond |
//! | the same, but an S of [`HARMLESS`] or less | cannot tell: it would be no fault |
//! | the same, but no line of evidence alone gives it [`BORNE_OUT_FROM`] | cannot tell |
//! | [`CLEARED_UP_TO`] or less, but a sticking valve predicts the PV better by [`VETO`] standard errors | cannot tell |
//! | the same without that, and a limit of S that means something | does not stick, by more than that |
//! | the same without such a limit | cannot tell: what lies below could not be seen |
//! | what lies between | cannot tell |
//!
//! # Limits
//! The table is ours. Its constants were chosen on simulated loops; `docs/accuracy.md` tells what verdicts are worth.

use super::reasons::{Saying, alternatives, sayings};
use super::verdict::{Basis, Limit, Verdict, VerdictClass};
use super::weighing::Weighing;
use super::{ACCUSED_FROM, CLEARED_UP_TO, DEAD_ZONE_BELOW, HARMLESS};
use crate::evidence::Line;
use crate::fusion::{Cause, LIMIT};
use crate::spoken::{percent, rough};

/// Standard errors by which a sticking valve must predict the PV better to keep a valve from being cleared. It is
/// the best of some fifty valves: of healthy ones a quarter reach 2, and one in ten 3.
pub const VETO: f64 = 3.0;
/// Probabilities of two lines that contradict each other: one is below the first, another above the second.
pub const CONTRADICTORY: (f64, f64) = (0.05, 0.95);
/// A valve is accused only if one line of evidence alone gives it so much: a sum of hints that none of them bears out
/// convinces nobody who looks at them. Of accusations of simulated loops it takes one in fifteen, right and wrong ones
/// alike; it was prompted by a healthy valve of a plant.
pub const BORNE_OUT_FROM: f64 = 0.8;
/// A limit means something up to so many ranges of the OP: a valve that sticks by more than twice what its OP
/// travels does not move at all, wherever it stood at first.
pub const LARGEST_LIMIT: f64 = 2.0;

/// What is concluded of a window's worth of evidence or more; `preliminary` is what the published methods say.
pub(super) fn by_evidence(weighing: &Weighing, preliminary: Verdict) -> Verdict {
    let sayings = sayings(weighing);
    let ruling = Ruling::of_sayings(weighing, &sayings);
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

/// The row of the table that decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ruling {
    /// OP and PV are not those of one loop.
    Mistaken,
    /// The recording is unlike anything the model was trained on.
    Strange,
    /// A line that is sure that it sticks, and one that it does not.
    Contradicts(Line, Line),
    /// It sticks.
    Sticks,
    /// It does not respond.
    NoResponse,
    /// Accused, but for a dead zone elsewhere.
    DeadZone,
    /// Accused, but by so little that it is no fault.
    Harmless,
    /// Accused, but by no line of evidence alone.
    Unsupported,
    /// Cleared, but for a valve that predicts better.
    Vetoed,
    /// Cleared, but for a limit.
    Blind,
    /// It does not stick.
    Clears,
    /// The probability lies between.
    Open,
}

impl Ruling {
    /// What the table says of this evidence.
    pub fn of(weighing: &Weighing) -> Self {
        Self::of_sayings(weighing, &sayings(weighing))
    }

    fn of_sayings(weighing: &Weighing, sayings: &[Saying]) -> Self {
        let p = weighing.probability;
        if weighing.mismatch > 1.0 {
            return Self::Mistaken;
        }
        if weighing.distance > 1.0 {
            return Self::Strange;
        }
        let sure = |of: fn(f64) -> bool| sayings.iter().find(|saying| of(saying.probability));
        let (no, yes) = (sure(|p| p < CONTRADICTORY.0), sure(|p| p > CONTRADICTORY.1));
        match p {
            p if p >= ACCUSED_FROM || p <= CLEARED_UP_TO => {
                if let (Some(yes), Some(no)) = (yes, no) {
                    return Self::Contradicts(yes.line, no.line);
                }
            }
            _ => return Self::Open,
        }
        if p >= ACCUSED_FROM {
            if weighing.likelihood(Cause::DeadZoneElsewhere) >= DEAD_ZONE_BELOW {
                return Self::DeadZone;
            }
            let idle = weighing.likelihood(Cause::NoResponse);
            return match idle > weighing.likelihood(Cause::StickingValve) {
                true => Self::NoResponse,
                false if weighing.s.value <= HARMLESS => Self::Harmless,
                false if !sayings.iter().any(|s| s.probability >= BORNE_OUT_FROM) => {
                    Self::Unsupported
                }
                false => Self::Sticks,
            };
        }
        if weighing.z >= VETO {
            return Self::Vetoed;
        }
        match weighing.limit {
            Some(limit) if limit <= LARGEST_LIMIT * weighing.op_range => Self::Clears,
            _ => Self::Blind,
        }
    }

    /// The class that it gives.
    pub fn class(self) -> VerdictClass {
        match self {
            Self::Sticks => VerdictClass::Sticks,
            Self::NoResponse => VerdictClass::DoesNotRespond,
            Self::Clears => VerdictClass::DoesNotStick,
            Self::Mistaken
            | Self::Strange
            | Self::Contradicts(..)
            | Self::DeadZone
            | Self::Harmless
            | Self::Unsupported
            | Self::Vetoed
            | Self::Blind
            | Self::Open => VerdictClass::CannotTell,
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
            Self::Contradicts(yes, no) => format!(
                "the lines of evidence contradict each other: the {} are sure that it sticks, the {} that it \
                 does not",
                yes.name(),
                no.name()
            ),
            Self::DeadZone => format!(
                "play in the sensor or a dead zone in the controller would look the same and keeps {}",
                percent(weighing.likelihood(Cause::DeadZoneElsewhere))
            ),
            Self::Harmless => format!(
                "if it sticks, then by some {} %, which is no fault: valves in good order have dead bands of up \
                 to {HARMLESS} %",
                rough(weighing.s.value)
            ),
            Self::Unsupported => format!(
                "the lines of evidence hint at it together, but none of them alone makes it {} or more",
                percent(BORNE_OUT_FROM)
            ),
            Self::Vetoed => format!(
                "a valve that sticks predicts the PV better than one that follows by {:.1} standard errors, \
                 which forbids to clear it",
                weighing.z
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
    use crate::fusion::Estimate;

    fn weighing(probability: f64) -> Weighing {
        let interval = Estimate { value: 3.0, low: 2.0, high: 4.0 };
        Weighing {
            windows: vec![],
            evidence: vec![],
            weights: vec![],
            number: 1.0,
            probability,
            lines: vec![],
            causes: vec![
                (Cause::StickingValve, 0.9 * probability),
                (Cause::NoResponse, 0.1 * probability),
                (Cause::NormalOperation, 1.0 - probability),
            ],
            s: interval,
            j_over_s: interval,
            limit: Some(1.5),
            z: 0.0,
            op_range: 6.0,
            distance: 0.2,
            mismatch: 0.1,
            strangest: vec![],
        }
    }

    fn says(line: Line, probability: f64) -> Saying {
        Saying { line, probability, sentence: String::new() }
    }

    /// A line that bears out an accusation and is not sure.
    fn lines() -> [Saying; 1] {
        [says(Line::Model, 0.9)]
    }

    #[test]
    fn the_table_is_kept() {
        let of = |weighing: &Weighing| Ruling::of_sayings(weighing, &lines()).class();
        for (p, class) in [
            (0.01, VerdictClass::DoesNotStick),
            (CLEARED_UP_TO, VerdictClass::DoesNotStick),
            (0.5, VerdictClass::CannotTell),
            (ACCUSED_FROM, VerdictClass::Sticks),
            (0.999, VerdictClass::Sticks),
        ] {
            assert_eq!(of(&weighing(p)), class, "{p}");
            assert_eq!(of(&Weighing { distance: 1.1, ..weighing(p) }), VerdictClass::CannotTell);
        }
        // Mistaken columns end it, however strange they are.
        for p in [0.01, 0.5, 0.999] {
            let mistaken = Weighing { mismatch: 1.1, distance: 9.0, ..weighing(p) };
            assert_eq!(Ruling::of_sayings(&mistaken, &[]), Ruling::Mistaken);
            assert_eq!(of(&mistaken), VerdictClass::CannotTell);
            assert!(Ruling::Mistaken.sentence(&mistaken).unwrap().contains("which column"));
        }
        // What forbids to clear accuses nobody, and what forbids to accuse clears nobody.
        let cleared = weighing(0.01);
        for kept in [
            Weighing { z: VETO, ..cleared.clone() },
            Weighing { limit: None, ..cleared.clone() },
            Weighing { limit: Some(LARGEST_LIMIT * 6.0 + 0.1), ..cleared.clone() },
        ] {
            assert_eq!(of(&kept), VerdictClass::CannotTell);
        }
        assert_eq!(of(&Weighing { z: 9.0, limit: None, ..weighing(0.99) }), VerdictClass::Sticks);
        let hints = [says(Line::Model, 0.76), says(Line::Patterns, 0.67)];
        assert_eq!(Ruling::of_sayings(&weighing(0.95), &hints), Ruling::Unsupported);
        assert!(Ruling::Unsupported.sentence(&weighing(0.95)).unwrap().contains("80 %"));
        let least = Estimate { value: HARMLESS, low: 0.1, high: 0.9 };
        let harmless = Weighing { s: least, ..weighing(0.95) };
        assert_eq!(Ruling::of_sayings(&harmless, &lines()), Ruling::Harmless);
        assert!(Ruling::Harmless.sentence(&harmless).unwrap().contains("no fault"));
        let mut idle = weighing(0.95);
        (idle.causes[0].1, idle.causes[1].1) = (0.1, 0.85);
        assert_eq!(of(&idle), VerdictClass::DoesNotRespond);
        idle.causes[2] = (Cause::DeadZoneElsewhere, 0.05);
        assert_eq!(Ruling::of_sayings(&idle, &lines()), Ruling::DeadZone);
    }

    #[test]
    fn sure_opposites_are_named() {
        let lines = [says(Line::Model, 0.99), says(Line::Patterns, 0.5), says(Line::OpShape, 0.01)];
        for p in [0.02, 0.97] {
            let ruling = Ruling::of_sayings(&weighing(p), &lines);
            assert_eq!(ruling, Ruling::Contradicts(Line::Model, Line::OpShape));
            let said = ruling.sentence(&weighing(p)).unwrap();
            assert!(said.contains(Line::Model.name()) && said.contains(Line::OpShape.name()));
        }
        assert_eq!(Ruling::of_sayings(&weighing(0.97), &lines[..2]), Ruling::Sticks);
        assert_eq!(Ruling::of_sayings(&weighing(0.5), &lines), Ruling::Open);
    }
}
