//! What a detector says.

use super::{LookedAt, Method, Subject};
use crate::Number;
use std::borrow::Cow;
use std::fmt;

/// What a detector decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// The valve sticks.
    Sticks,
    /// The valve does not stick.
    DoesNotStick,
    /// Something in the loop is not linear.
    Nonlinear,
    /// Nothing speaks against a linear loop.
    Linear,
    /// The method applies, and its statistic lies between its thresholds.
    Undecided,
    /// The method does not apply, or the data do not suffice.
    Abstains,
}

impl Decision {
    /// Its name, as in `does not stick`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sticks => "sticks",
            Self::DoesNotStick => "does not stick",
            Self::Nonlinear => "nonlinear",
            Self::Linear => "linear",
            Self::Undecided => "undecided",
            Self::Abstains => "abstains",
        }
    }
}

/// Why a method does not judge, a sentence that names the remedy where there is one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Abstention(pub String);

impl fmt::Display for Abstention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Abstention {}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What a detector says of one segment.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Finding {
    /// Which.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub method: &'static Method,
    /// What it decides.
    pub decision: Decision,
    /// The number the decision rests on.
    pub statistic: Option<f64>,
    /// The value of the statistic from which the decision is positive.
    pub threshold: Option<f64>,
    /// A sentence: what the numbers say, or why the method abstains.
    pub reason: String,
    /// All numbers of the method.
    pub numbers: Vec<Number>,
    /// What to keep in mind when reading it, such as an assumption that could not be checked.
    pub caveats: Vec<String>,
    /// The parameters of the method as they were set.
    pub parameters: Vec<Number>,
    /// The typed result that it rests on, from which its figure is drawn. [`diagnose`](crate::diagnose::diagnose) keeps
    /// it where [`DiagnoseOptions::evidence`](crate::diagnose::DiagnoseOptions::evidence) asks for it, for it holds whole signals.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub looked_at: Option<LookedAt>,
}

impl Finding {
    /// A finding of a method that judged.
    pub fn new(
        method: &'static Method,
        decision: Decision,
        statistic: f64,
        threshold: f64,
        reason: String,
        numbers: Vec<Number>,
    ) -> Self {
        Self {
            method,
            decision,
            statistic: Some(statistic),
            threshold: Some(threshold),
            reason,
            numbers,
            caveats: vec![],
            parameters: vec![],
            looked_at: None,
        }
    }

    /// A finding of a method that does not judge.
    pub fn abstains(method: &'static Method, why: Abstention) -> Self {
        Self {
            method,
            decision: Decision::Abstains,
            statistic: None,
            threshold: None,
            reason: why.0,
            numbers: vec![],
            caveats: vec![],
            parameters: vec![],
            looked_at: None,
        }
    }

    /// What the method looked at in `subject`, of which this is the finding. Where it was not kept, the method of the
    /// registry looks again; `None` if it cannot, or this is the finding of one with other parameters.
    pub fn evidence(&self, subject: &Subject<'_>) -> Option<Cow<'_, LookedAt>> {
        if let Some(kept) = &self.looked_at {
            return Some(Cow::Borrowed(kept));
        }
        let detector = self.method.id.detector();
        let same = detector.parameters() == self.parameters;
        same.then(|| detector.judge(subject).looked_at).flatten().map(Cow::Owned)
    }
}
