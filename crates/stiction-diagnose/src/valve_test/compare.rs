//! Effect of a repair, from a test before the repair and a test after it.
//!
//! # Equations
//! b and a are S before and after, each with its 90 % interval (b_l to b_u, a_l to a_u). The tests are independent, so
//! the 90 % interval of the difference d = a - b follows from the two intervals alone:
//!
//! ```text
//! d_l = a - b - sqrt((a - a_l)^2 + (b_u - b)^2)
//! d_u = a - b + sqrt((a_u - a)^2 + (b - b_l)^2)
//! ```
//!
//! A test that finds no S gives only a limit: S lies between 0 and A with 95 % confidence. Then d has no best
//! estimate. Its ends are the extremes that the two results allow:
//!
//! ```text
//! a < A:           d_l = -b_u,  d_u = A - b_l
//! b < B:           d_l = a_l - B,  d_u = a_u
//! a < A and b < B: d_l = -B,  d_u = A
//! ```
//!
//! Each limit and each end of an interval is wrong in 5 of 100 tests, so each end of d is wrong in at most 10 of 100.
//!
//! S changed if the interval d_l to d_u excludes 0. It did not change if neither end is farther from 0 than a quarter
//! of the larger S or than 0.5 %, the finest difference that tests resolve. Otherwise the tests cannot show a change.
//!
//! # Limits
//! The tests do not show which repair was made between them. It is called the repair here. Both tests must be of the
//! same valve.
//!
//! # Sources
//! G. Y. Zou and A. Donner, "Construction of confidence intervals about effect measures: a general approach", Statistics in
//! Medicine 27 (2008) 1693 (recalled, not read). The limits and the criterion for no change are ours.

use super::read::TestReading;
use super::signature::Signature;
use crate::diagnose::VerdictClass;
use crate::estimate::Estimate;
use crate::spoken::rough;
use stiction_model::named;

named! {
    /// The change of S.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Effect {
        /// S is smaller than before.
        Lowered = "lowered",
        /// S is larger than before.
        Raised = "raised",
        /// S did not change.
        Unchanged = "unchanged",
        /// The tests cannot show a change.
        CannotTell = "cannot tell",
    }
}

/// S after a repair minus S before the repair.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Difference {
    /// The best value, percent of span; `None` if a test gives only a limit of S.
    pub value: Option<f64>,
    /// Lower end of the 90 % interval of the difference, percent of span.
    pub low: f64,
    /// Upper end of the 90 % interval of the difference, percent of span.
    pub high: f64,
}

/// The effect of a repair, from two tests.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Comparison {
    /// The change of S: `lowered`, `raised`, `unchanged` or `cannot tell`.
    pub effect: Effect,
    /// S after minus S before; `None` if a test gives neither S nor a limit.
    pub difference: Option<Difference>,
    /// The result in sentences.
    pub sentences: Vec<String>,
}

/// A smaller difference is no change: percent of span, and share of the larger S.
const NONE: f64 = 0.5;
const NONE_OF_S: f64 = 0.25;

/// The part of a result that is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    class: VerdictClass,
    s: Option<Estimate>,
    s_below: Option<f64>,
    /// Whether the PV or the stem moved with the OP.
    moved: bool,
}

impl From<&TestReading> for Outcome {
    fn from(of: &TestReading) -> Self {
        let moved = of.steps.iter().any(|step| step.answered);
        Self { class: of.class, s: of.s, s_below: of.s_below, moved }
    }
}

impl From<&Signature> for Outcome {
    fn from(of: &Signature) -> Self {
        let moved = of.class != VerdictClass::DoesNotRespond;
        Self { class: of.class, s: of.s, s_below: None, moved }
    }
}

/// Compares the tests before and after a repair.
pub fn compare(before: impl Into<Outcome>, after: impl Into<Outcome>) -> Comparison {
    let (before, after) = (before.into(), after.into());
    let (old, new) = (Known::of(before), Known::of(after));
    let difference = old.zip(new).map(|(old, new)| Difference::of(old, new));
    let effect = match (difference, old, new) {
        (Some(d), ..) if d.high < 0.0 => Effect::Lowered,
        (Some(d), ..) if d.low > 0.0 => Effect::Raised,
        (Some(d), Some(old), Some(new)) => {
            let nothing = NONE.max(NONE_OF_S * old.most().max(new.most()));
            match d.low >= -nothing && d.high <= nothing {
                true => Effect::Unchanged,
                false => Effect::CannotTell,
            }
        }
        _ => Effect::CannotTell,
    };
    let sentences = sentences(before, after, effect, difference);
    Comparison { effect, difference, sentences }
}

/// The result of a test for S, percent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Known {
    /// A value of S.
    Found(Estimate),
    /// An upper limit of S.
    Below(f64),
}

impl Known {
    fn of(reading: Outcome) -> Option<Self> {
        reading.s.map(Self::Found).or(reading.s_below.map(Self::Below))
    }

    /// S, or its limit.
    fn most(self) -> f64 {
        match self {
            Self::Found(s) => s.value,
            Self::Below(limit) => limit,
        }
    }

    /// The interval of S.
    fn ends(self) -> (f64, f64) {
        match self {
            Self::Found(s) => (s.low, s.high),
            Self::Below(limit) => (0.0, limit),
        }
    }

    fn words(self) -> String {
        match self {
            Self::Found(s) => {
                format!("{} % ({} to {})", rough(s.value), rough(s.low), rough(s.high))
            }
            Self::Below(limit) => format!("below {} %", rough(limit)),
        }
    }
}

impl Difference {
    fn of(before: Known, after: Known) -> Self {
        if let (Known::Found(b), Known::Found(a)) = (before, after) {
            let value = a.value - b.value;
            return Self {
                value: Some(value),
                low: value - (a.value - a.low).hypot(b.high - b.value),
                high: value + (a.high - a.value).hypot(b.value - b.low),
            };
        }
        let ((b_low, b_high), (a_low, a_high)) = (before.ends(), after.ends());
        Self { value: None, low: a_low - b_high, high: a_high - b_low }
    }

    /// The difference in words, with signs: `-2.1 % (-2.5 to -1.7)`, `-3.4 to -2.4 %`.
    pub fn words(&self) -> String {
        let signed = |x: f64| format!("{}{}", if x > 0.0 { "+" } else { "" }, rough(x));
        let (low, high) = (signed(self.low), signed(self.high));
        match self.value {
            Some(value) => format!("{} % ({low} to {high})", signed(value)),
            None => format!("{low} to {high} %"),
        }
    }
}

fn sentences(
    before: Outcome,
    after: Outcome,
    effect: Effect,
    difference: Option<Difference>,
) -> Vec<String> {
    let words = |of: Outcome| Known::of(of).map_or("not known".to_owned(), Known::words);
    let (old, new) = (words(before), words(after));
    let mut all = vec![match effect {
        Effect::Lowered => format!("The repair lowered S from {old} to {new}."),
        Effect::Raised => format!("S rose from {old} to {new}."),
        Effect::Unchanged => {
            format!("S did not change. S was {old} before the repair and is {new} now.")
        }
        Effect::CannotTell => {
            format!(
                "The tests cannot show a change of S. S was {old} before the repair and is {new} now."
            )
        }
    }];
    if let Some(d) = difference {
        all.push(match d.value {
            Some(_) => format!("The change of S is {} of span.", d.words()),
            None if effect == Effect::Lowered => {
                format!("S fell by at least {} % of span.", rough(-d.high))
            }
            None if effect == Effect::Raised => {
                format!("S rose by at least {} % of span.", rough(d.low))
            }
            None => format!("The change of S is between {} of span.", between(&d)),
        });
    }
    let after_it = match (before.class, after.class) {
        (VerdictClass::Sticks, VerdictClass::Sticks) => Some("The valve still sticks."),
        (VerdictClass::Sticks, VerdictClass::DoesNotStick) => Some("The valve no longer sticks."),
        (VerdictClass::DoesNotRespond, VerdictClass::DoesNotRespond) => {
            Some("The valve still does not respond.")
        }
        (VerdictClass::DoesNotRespond, _) => {
            Some("The valve did not respond before the repair, and responds now.")
                .filter(|_| after.moved)
        }
        (_, VerdictClass::DoesNotRespond) => Some("The valve does not respond after the repair."),
        (_, VerdictClass::Sticks) => Some("The valve sticks after the repair."),
        _ => None,
    };
    all.extend(after_it.map(str::to_owned));
    all
}

fn between(d: &Difference) -> String {
    format!("{} and {} %", rough(d.low), rough(d.high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::KnownBy;

    fn reading(s: Option<(f64, f64, f64)>, s_below: Option<f64>) -> TestReading {
        let s = s.map(|(value, low, high)| Estimate { value, low, high });
        let class = match (s, s_below) {
            (Some(_), _) => VerdictClass::Sticks,
            (None, Some(limit)) if limit < 2.0 => VerdictClass::DoesNotStick,
            _ => VerdictClass::CannotTell,
        };
        TestReading {
            class,
            probability: 0.5,
            by_test: 0.5,
            log_odds: 0.0,
            by_operation: None,
            dead_band_elsewhere: 0.0,
            s,
            j: s,
            s_below,
            response_s: None,
            known_by: KnownBy::Mode,
            from_s: 0.0,
            to_s: 1.0,
            stops: 0,
            by_position: false,
            position: None,
            steps: vec![],
            turned: 0,
            reasons: vec![],
            advice: None,
            plan: None,
            recorded: vec![],
        }
    }

    /// By the equations on paper: 3 and 4 make 5.
    #[test]
    fn two_intervals_make_one() {
        let before = reading(Some((10.0, 9.6, 10.4)), None);
        let after = reading(Some((5.0, 4.7, 5.3)), None);
        let found = compare(&before, &after);
        let d = found.difference.unwrap();
        assert!(
            (d.low + 5.5).abs() < 1e-12 && (d.high + 4.5).abs() < 1e-12 && d.value == Some(-5.0)
        );
        assert_eq!(found.effect, Effect::Lowered);
        assert_eq!(
            found.sentences,
            [
                "The repair lowered S from 10 % (9.6 to 10) to 5 % (4.7 to 5.3).",
                "The change of S is -5 % (-5.5 to -4.5) of span.",
                "The valve still sticks."
            ]
        );
        // Exchanging the tests changes only the sign.
        let back = compare(&after, &before);
        let other = back.difference.unwrap();
        assert_eq!((other.low, other.high), (-d.high, -d.low));
        assert_eq!(back.effect, Effect::Raised);
    }

    #[test]
    fn a_limit_bounds_the_difference() {
        let before = reading(Some((3.2, 3.0, 3.5)), None);
        let cleared = reading(None, Some(0.6));
        let found = compare(&before, &cleared);
        let d = found.difference.unwrap();
        assert!((d.low + 3.5).abs() < 1e-12 && (d.high + 2.4).abs() < 1e-12 && d.value.is_none());
        assert_eq!(
            found.sentences,
            [
                "The repair lowered S from 3.2 % (3 to 3.5) to below 0.6 %.",
                "S fell by at least 2.4 % of span.",
                "The valve no longer sticks."
            ]
        );
        assert_eq!(compare(&cleared, &before).effect, Effect::Raised);
        // A limit above S shows no change.
        let vague = reading(None, Some(4.0));
        let found = compare(&before, &vague);
        assert_eq!(found.effect, Effect::CannotTell);
        assert!(found.sentences[0].starts_with("The tests cannot show a change of S."));
        assert!(found.sentences[1].contains("between -3.5 and 1 %"), "{found:?}");
        let none = compare(&before, &reading(None, None));
        assert_eq!((none.effect, none.difference), (Effect::CannotTell, None));
        assert!(none.sentences[0].ends_with("is not known now."), "{none:?}");
    }

    #[test]
    fn what_is_nearly_the_same_did_not_change() {
        let before = reading(Some((3.2, 3.0, 3.5)), None);
        let found = compare(&before, &reading(Some((3.1, 2.9, 3.4)), None));
        assert_eq!(found.effect, Effect::Unchanged);
        assert!(found.sentences[0].starts_with("S did not change."));
        // Wide intervals cannot show it.
        let wide = compare(&before, &reading(Some((3.1, 1.9, 4.4)), None));
        assert_eq!(wide.effect, Effect::CannotTell);
        let fine = reading(None, Some(0.5));
        assert_eq!(compare(&fine, &fine).effect, Effect::Unchanged);
        let coarse = reading(None, Some(1.5));
        assert_eq!(compare(&coarse, &coarse).effect, Effect::CannotTell);
    }

    /// 20,000 pairs of normal S with their intervals: the interval of the difference holds the true one in 90 of 100.
    #[test]
    fn the_interval_holds_as_often_as_it_says() {
        let mut noise = crate::closed_loop::NormalStream::new(5);
        let (old, new, sd) = (4.0, 1.5, (0.3, 0.2));
        let wide = |value: f64, sd: f64| {
            Known::Found(Estimate { value, low: value - 1.645 * sd, high: value + 1.645 * sd })
        };
        let mut held = 0;
        for _ in 0..20_000 {
            let (b, a) = (old + sd.0 * noise.draw(), new + sd.1 * noise.draw());
            let d = Difference::of(wide(b, sd.0), wide(a, sd.1));
            held += usize::from(d.low < new - old && new - old < d.high);
        }
        let share = held as f64 / 20_000.0;
        assert!((share - 0.9).abs() < 0.01, "{share}");
    }
}
