//! The verdict on a valve, as data: conclusion, basis and reasons.

use super::grade::PROBABLY_FINE_UP_TO;
use crate::error::{Error, Result};
use crate::finding::{Decides, Decision, Family, Finding};
#[cfg(feature = "serde")]
use crate::fusion::LIMIT;
use crate::fusion::{Cause, Estimate};
use crate::methods::Counts;
use crate::valve_test::TestPlan;
use std::fmt;
use stiction_model::named;

named! {
    /// The conclusion about a valve.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub enum VerdictClass {
        /// It sticks.
        Sticks = "sticks",
        /// It does not stick.
        DoesNotStick = "does not stick",
        /// The OP travels and the flow does not: the valve is seized, shut off or unpowered, or the sensor is dead.
        DoesNotRespond = "does not respond",
        /// The data cannot answer, or the evidence is divided.
        #[default]
        CannotTell = "cannot tell",
    }
}

impl VerdictClass {
    /// The class of that name. Hyphens may replace blanks, as in `does-not-stick`.
    ///
    /// # Errors
    /// If no alternative has this name.
    pub fn by_name(name: &str) -> Result<Self> {
        let spoken = name.trim().replace(['-', '_'], " ").to_lowercase();
        Self::ALL.into_iter().find(|class| class.name() == spoken).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|class| class.name()).collect();
            Error::UnknownName { family: "verdict", name: name.to_owned(), known: known.join(", ") }
        })
    }
}

named! {
    /// The verdict in one graded word, the worst first.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    pub enum Grade {
        /// It sticks.
        Sticks = "sticks",
        /// It does not respond.
        DoesNotRespond = "does not respond",
        /// It probably sticks; a test would decide.
        ProbablySticks = "probably sticks",
        /// The evidence is divided or weak.
        Unclear = "unclear",
        /// It is probably fine, without proof in this recording.
        ProbablyFine = "probably fine",
        /// No stiction is visible, but the recording could mask an S that matters.
        NoneVisible = "no stiction visible",
        /// It sticks by no more than a healthy valve may.
        TooLittle = "too little to matter",
        /// It does not stick by more than a limit that matters.
        Fine = "fine",
        /// The data cannot answer.
        #[default]
        CannotAnswer = "data cannot answer",
    }
}

impl Grade {
    /// A probability of sticking is shown with this grade, except where the data cannot answer, or where the valve
    /// would stick by an S below the limit, which is no fault.
    pub fn shown(self, probability: Option<f64>) -> Option<f64> {
        let is_none = matches!(self, Self::CannotAnswer | Self::TooLittle);
        probability.filter(|p| !(is_none || self.spares() && *p > PROBABLY_FINE_UP_TO))
    }

    /// Whether it is, or probably is, no fault of the valve.
    pub fn spares(self) -> bool {
        matches!(self, Self::ProbablyFine | Self::NoneVisible | Self::TooLittle | Self::Fine)
    }

    /// Whether it is, or probably is, a fault of the valve.
    pub fn accuses(self) -> bool {
        matches!(self, Self::Sticks | Self::DoesNotRespond | Self::ProbablySticks)
    }
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

named! {
    /// The basis of a verdict.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Basis {
        /// The measured valve position.
        ValvePosition = "measured valve position",
        /// A valve test in the recording, and the operation before it.
        ValveTest = "valve test",
        /// The evidence in OP and PV, weighed by the model that was trained on simulated loops.
        Evidence = "evidence in OP and PV",
        /// The shape of the OP alone: it can be compatible with stiction, but never prove it.
        OpAlone = "shape of the OP alone",
        /// Nothing: the data cannot answer.
        #[default]
        None = "none",
    }
}

/// The numbers of families of methods by vote.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Votes {
    /// Number of families that find stiction.
    pub sticks: usize,
    /// Number of families that find no stiction.
    pub does_not_stick: usize,
    /// Number of families that apply, but are undecided or divided.
    pub undecided: usize,
    /// Number of families whose methods all abstain.
    pub abstains: usize,
}

impl Limit {
    /// A limit from the evidence: all of them have one confidence.
    #[cfg(feature = "serde")]
    pub(super) fn of_evidence<S: serde::Serializer>(
        limit: &Option<f64>,
        to: S,
    ) -> std::result::Result<S::Ok, S::Error> {
        let limit = limit.filter(|value| value.is_finite());
        serde::Serialize::serialize(&limit.map(|value| Self { value, confidence: LIMIT }), to)
    }
}

impl Votes {
    /// Counts one vote for each [`Family`]: the decision of the majority of its methods that decide on stiction.
    /// Methods that only test for linearity have no vote.
    pub fn of(findings: &[Finding]) -> Self {
        let mut votes = Self::default();
        for (_, decision) in Self::by_family(findings) {
            match decision {
                Decision::Sticks => votes.sticks += 1,
                Decision::DoesNotStick => votes.does_not_stick += 1,
                Decision::Abstains => votes.abstains += 1,
                _ => votes.undecided += 1,
            }
        }
        votes
    }

    /// The vote of each family that has a method deciding on stiction, in the order of [`Family::ALL`].
    pub fn by_family(findings: &[Finding]) -> Vec<(Family, Decision)> {
        let voice = |family: Family| {
            let mut counts = Counts::default();
            findings
                .iter()
                .filter(|f| f.method.family == family && f.method.decides == Decides::Stiction)
                .for_each(|f| counts.add(f.decision));
            (counts.all() > 0).then(|| (family, counts.majority()))
        };
        Family::ALL.into_iter().filter_map(voice).collect()
    }
}

/// The conclusion on a valve, with the basis and the reasons.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Verdict {
    /// The conclusion: `sticks`, `does not stick`, `does not respond` or `cannot tell`.
    pub class: VerdictClass,
    /// The grade of the verdict. The conclusion `cannot tell` has the grades `probably sticks`, `unclear`, `probably
    /// fine`, `too little to matter` and `data cannot answer`. The conclusion `does not stick` has the grades `fine`
    /// and `no stiction visible`. The grades `sticks` and `does not respond` are also conclusions.
    pub grade: Grade,
    /// The probability of stiction that the recording can show; `None` if no calibrated model gives a probability.
    pub probability: Option<f64>,
    /// The basis of the conclusion, such as `evidence in OP and PV`.
    pub basis: Basis,
    /// The detection limit of this recording: a larger S is ruled out with the given confidence. The limit is given if
    /// the valve is cleared or nothing is decided. `None` if the valve is at fault, or S has an interval. `None` also
    /// for mistaken columns, unfit data, a recording unlike the training loops, or an unknown limit.
    #[cfg_attr(feature = "serde", serde(rename = "S_below"))]
    pub s_below: Option<Limit>,
    /// The votes of the families of methods.
    pub votes: Votes,
    /// The reasons for the conclusion, in sentences.
    pub reasons: Vec<String>,
    /// Evidence against the conclusion, in sentences.
    pub contradictions: Vec<String>,
    /// Other possible causes, the likeliest first.
    pub alternatives: Vec<Alternative>,
    /// The manual test that would decide, as `stiction test plan` plans it. `None` if no test is needed, or `no_test`
    /// gives a reason.
    pub confirm: Option<TestPlan>,
    /// Why a needed test is not possible.
    pub no_test: Option<String>,
    /// The conclusion of a person on this recording, if there is one. It stands beside the computed results.
    #[cfg_attr(feature = "serde", serde(rename = "override"))]
    pub overruled: Option<Override>,
}

impl Verdict {
    /// The probability as pages and tables show it.
    pub fn shown_probability(&self) -> Option<f64> {
        self.grade.shown(self.probability)
    }
}

/// The conclusion of a person on a valve, beside the computed verdict.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Override {
    /// The conclusion.
    pub verdict: VerdictClass,
    /// The reason.
    pub reason: String,
    /// The person; `None` if it is not kept.
    pub by: Option<String>,
    /// The day of the entry, as in `2026-03-01`; `None` if it is not kept.
    pub entered: Option<String>,
    /// Scope, in words.
    pub scope: String,
    /// The file that contains the override.
    pub kept_in: String,
}

/// An upper limit of S with its confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Limit {
    /// The limit of S, percent of span.
    pub value: f64,
    /// Share of valves with a larger S that would have been detected.
    pub confidence: f64,
}

/// A possible cause other than the conclusion.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Alternative {
    /// The cause, such as `aggressive tuning`.
    pub cause: Cause,
    /// Probability of the cause. The probabilities of sticking and of all other causes add up to one.
    pub likelihood: f64,
    /// The evidence for the cause, and how to distinguish the cause from others, in a sentence.
    pub because: String,
}

/// The size of a valve's stiction.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Stiction {
    /// The source of the numbers: the valve model, or the measured position.
    pub model: Option<String>,
    /// Stick band plus dead band, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// The nominal coverage of the intervals, such as 0.9; `None` for intervals without a nominal coverage.
    pub coverage: Option<f64>,
    /// Why S or J is missing.
    pub why_not: Option<String>,
    /// The values by the competing definitions of "stiction in percent".
    pub definitions: Vec<Definition>,
}

/// One of the numbers that are called "stiction in percent".
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Definition {
    /// Name, such as `apparent stiction`.
    pub name: &'static str,
    /// Value; `None` if the data do not determine the value.
    pub value: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// Meaning and source of the definition.
    pub meaning: &'static str,
}

/// Probability of play or a dead zone elsewhere in the loop. Above it, a resting PV cannot give "does not respond",
/// because both keep the PV from responding.
pub const DEAD_ZONE_BELOW: f64 = 0.03;
/// S up to this many percent is no fault: healthy valves of the population have dead bands as wide.
pub const HARMLESS: f64 = 0.25;
