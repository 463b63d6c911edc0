//! The verdict on a valve.

use super::belonging::Belonging;
use super::by_evidence::{by_evidence, thresholds};
use super::grade::Grade;
use super::reasons::{alternatives, sayings};
use super::weighing::Weighing;
use crate::detect::Counts;
use crate::detect::{Decides, Decision, Family, Finding};
use crate::error::{Error, Result};
#[cfg(feature = "serde")]
use crate::fusion::LIMIT;
use crate::fusion::{Cause, Estimate};
use crate::recording::fitness::{Class, Fitness, MeasureId};
use crate::spoken::percent;

/// What is concluded about a valve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum VerdictClass {
    /// It sticks.
    Sticks,
    /// It does not stick.
    DoesNotStick,
    /// The output travels and the flow does not: the valve is stuck fast, shut off or unpowered, or the
    /// sensor is dead.
    DoesNotRespond,
    /// The data cannot answer, or the evidence is divided.
    #[default]
    CannotTell,
}

impl VerdictClass {
    /// All of them.
    pub const ALL: [Self; 4] =
        [Self::Sticks, Self::DoesNotStick, Self::DoesNotRespond, Self::CannotTell];

    /// The class of that name, in which hyphens may stand for blanks, as in `does-not-stick`.
    ///
    /// # Errors
    /// If there is none.
    pub fn by_name(name: &str) -> Result<Self> {
        let spoken = name.trim().replace(['-', '_'], " ").to_lowercase();
        Self::ALL.into_iter().find(|class| class.name() == spoken).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|class| class.name()).collect();
            Error::UnknownName { family: "verdict", name: name.to_owned(), known: known.join(", ") }
        })
    }

    /// Its name, as in `does not stick`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sticks => "sticks",
            Self::DoesNotStick => "does not stick",
            Self::DoesNotRespond => "does not respond",
            Self::CannotTell => "cannot tell",
        }
    }
}

/// What a verdict rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Basis {
    /// The measured valve position.
    ValvePosition,
    /// The evidence in OP and PV, weighed by the model that was trained on simulated loops.
    Evidence,
    /// The shape of the OP alone: it can be compatible with stiction, but never prove it.
    OpAlone,
    /// The majority of the families of published methods that apply.
    Majority,
    /// Nothing: the data cannot answer.
    #[default]
    None,
}

impl Basis {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::ValvePosition => "measured valve position",
            Self::Evidence => "evidence in OP and PV",
            Self::OpAlone => "shape of the OP alone",
            Self::Majority => "majority of the families of methods that apply",
            Self::None => "none",
        }
    }
}

/// How the families of methods voted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Votes {
    /// Families that say the valve sticks.
    pub sticks: usize,
    /// Families that say it does not.
    pub does_not_stick: usize,
    /// Families that apply and are undecided, or divided.
    pub undecided: usize,
    /// Families all of whose methods abstain.
    pub abstains: usize,
}

impl Limit {
    /// A limit by the evidence: all of them have one confidence.
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
    /// Counts one vote for each [`Family`]: what most of its methods that decide on stiction say.
    /// Methods that test for linearity only have no say.
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

    /// What each family says that has a method deciding on stiction, in the order of [`Family::ALL`].
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

/// What is concluded, on what, and why.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Verdict {
    /// The conclusion: `sticks`, `does not stick`, `does not respond` or `cannot tell`.
    pub class: VerdictClass,
    /// The same in one graded word, which tells `probably sticks` from `unclear` and `probably fine` where the class cannot
    /// tell. The others are `sticks`, `fine`, `does not respond` and `data cannot answer`.
    pub grade: Grade,
    /// The probability that the valve sticks, where a calibrated model gives one. A majority has none.
    pub probability: Option<f64>,
    /// What it rests on, such as `evidence in OP and PV`.
    pub basis: Basis,
    /// What this very recording would have shown: an S above this is ruled out with this confidence. Told where
    /// the valve is cleared, and where nothing is decided; `None` where the valve is at fault, where S is a number with
    /// an interval, where what is wrong lies deeper (mistaken columns, unfit data, a recording unlike the
    /// training), or where no such number is known.
    #[cfg_attr(feature = "serde", serde(rename = "S_below"))]
    pub s_below: Option<Limit>,
    /// How the families of published methods voted.
    pub votes: Votes,
    /// Why, in sentences.
    pub reasons: Vec<String>,
    /// Evidence that speaks against the conclusion, in sentences.
    pub contradictions: Vec<String>,
    /// What else it could be, the likeliest first.
    pub alternatives: Vec<Alternative>,
    /// The manual test that would settle it; `None` if none can be sized.
    pub confirm: Option<ConfirmingTest>,
    /// What a person concluded of this recording, if somebody did. It stands beside the rest, which is what was
    /// computed.
    #[cfg_attr(feature = "serde", serde(rename = "override"))]
    pub overruled: Option<Override>,
}

/// What a person concluded of a valve, beside the computed verdict.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Override {
    /// The conclusion.
    pub verdict: VerdictClass,
    /// Why.
    pub reason: String,
    /// Who says so; `None` where that is not kept.
    pub by: Option<String>,
    /// The day on which it was entered, as in `2026-03-01`; `None` where that is not kept.
    pub entered: Option<String>,
    /// What it holds for, in words.
    pub scope: String,
    /// The file it is kept in.
    pub kept_in: String,
}

/// An upper limit of S.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Limit {
    /// Stick band plus dead band, percent of span.
    pub value: f64,
    /// Of valves that stick by more, the share that would have been seen.
    pub confidence: f64,
}

/// A cause other than the concluded one, and how likely it is.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Alternative {
    /// The cause, such as `aggressive tuning`.
    pub cause: Cause,
    /// Its probability; together with that of sticking they add up to one.
    pub likelihood: f64,
    /// What the data show of it, and how to tell it apart: a sentence.
    pub because: String,
}

/// How a test is carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestKind {
    /// Steps of the output in manual, one way and back.
    Steps,
    /// Pulses of the output in manual, each higher than the last.
    Pulses,
    /// Bumps of the set point in automatic.
    SetPointBumps,
    /// There is none in normal operation.
    NoneInOperation,
}

impl TestKind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Steps => "steps in manual",
            Self::Pulses => "pulses in manual",
            Self::SetPointBumps => "set-point bumps in automatic",
            Self::NoneInOperation => "none in operation",
        }
    }
}

/// A test with the controller in manual that settles whether the valve sticks, sized from the data.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct ConfirmingTest {
    /// How it is carried out: `steps in manual`, `pulses in manual`, `set-point bumps in automatic` or
    /// `none in operation`.
    pub kind: TestKind,
    /// Size of each step of the OP, percent of span.
    pub step: f64,
    /// How many steps in one direction before they turn.
    pub steps: usize,
    /// Whether the first steps go up.
    pub up_first: bool,
    /// How long to wait after each step, pulse or bump, s.
    pub wait_s: f64,
    /// How long all of it takes, s; 0 where there is no test in operation.
    pub total_s: f64,
    /// By how much the PV should change with one step if the valve follows, in its units, where the data tell.
    pub pv_change: Option<f64>,
    /// The PV below which the test is stopped, in its units; `None` without a PV.
    pub pv_low: Option<f64>,
    /// The PV above which it is stopped.
    pub pv_high: Option<f64>,
    /// What to do and what to look for, in sentences, in order.
    pub instructions: Vec<String>,
}

/// How much a valve sticks.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Stiction {
    /// What it was found with: the valve model, or the measured position.
    pub model: Option<String>,
    /// Stick band plus dead band, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// The nominal coverage of the intervals, such as 0.9; `None` where they are not of that kind.
    pub coverage: Option<f64>,
    /// Why a number is missing.
    pub why_not: Option<String>,
    /// The competing definitions of "stiction in percent", side by side.
    pub definitions: Vec<Definition>,
}

/// One of the numbers that are called "stiction in percent".
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Definition {
    /// Its name, such as `apparent stiction`.
    pub name: &'static str,
    /// Its value; `None` where it cannot be measured.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: &'static str,
    /// What it is, and by whom.
    pub meaning: &'static str,
}

/// How many families must decide, at least, before a majority counts.
pub const FEWEST_VOTES: usize = 3;

/// Measures of fitness whose caveats are reasons for the very patterns that methods take for stiction: a
/// signal that rests while the other moves, a wave with corners.
pub const MIMICS: [MeasureId; 6] = [
    MeasureId::CompressionFactor,
    MeasureId::PvLevels,
    MeasureId::LongestFrozenPv,
    MeasureId::OpAtLimit,
    MeasureId::ClippedPv,
    MeasureId::SetPoint,
];

/// The probability that play or a dead zone elsewhere in the loop must stay below for a valve to be named as one that
/// does not respond because of how its PV rests: both keep the PV from answering.
pub const DEAD_ZONE_BELOW: f64 = 0.03;
/// S up to this many percent is no fault: healthy valves of the population have dead bands as
/// wide.
pub const HARMLESS: f64 = 0.25;

/// Measures of fitness on which a loop of the population may fail too. If data are unfit for no other
/// reason, what their evidence says has a meaning, but it cannot tell whether the valve sticks.
pub const SIMULATED: [MeasureId; 3] =
    [MeasureId::Cycles, MeasureId::SamplesPerCycle, MeasureId::OpAtLimit];

/// The verdict.
///
/// 0. Columns that do not belong together end the judgement, and a PV that does not respond is named
///    before fitness can end it: [`Belonging`].
/// 1. Data that are unfit give `cannot tell`; unless they are unfit by no more than [`SIMULATED`] and the valve
///    does not respond, which needs no cycle to be seen.
/// 2. A recorded valve position is followed where it can be judged: [`by_position`](super::by_position), in place
///    of all that follows here.
/// 3. Without a PV nothing is concluded: the shape of the OP alone gives a probability, and that is all that
///    is said of it.
/// 4. Else the evidence in OP and PV, weighed by the [frozen model](crate::fusion), decides:
///    [`by_evidence`].
/// 5. Where nothing could be weighed, the published methods vote: [`preliminary`].
///
/// What the published methods say stays beside it and is counted in [`Votes`].
pub(super) fn conclude(
    fitness: &Fitness,
    oscillates: bool,
    findings: &[Finding],
    weighing: Option<&Weighing>,
    op_only: bool,
    belongs: &Belonging<'_>,
) -> Verdict {
    let preliminary = preliminary(fitness, oscillates, findings);
    if let Some(verdict) = belongs.verdict(weighing, fitness, &preliminary) {
        return verdict;
    }
    match weighing {
        None => preliminary,
        Some(weighing) if fitness.class == Class::Unfit => {
            of_unfit(fitness, weighing, op_only, preliminary)
        }
        Some(weighing) if op_only => of_op_alone(weighing, preliminary),
        Some(weighing) => by_evidence(weighing, preliminary),
    }
}

/// The verdict on data that are unfit.
fn of_unfit(
    fitness: &Fitness,
    weighing: &Weighing,
    op_only: bool,
    preliminary: Verdict,
) -> Verdict {
    let mut unfit = fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    if !unfit.all(|m| SIMULATED.contains(&m.id)) {
        return preliminary;
    }
    let weighed = Verdict { probability: Some(weighing.probability), ..preliminary };
    let idle = weighing.probability >= thresholds().accuse
        && weighing.mismatch <= 1.0
        && weighing.likelihood(Cause::NoResponse) > weighing.likelihood(Cause::StickingValve);
    if op_only || !idle {
        return weighed;
    }
    // A valve that does not respond makes no cycles, and winds its controller up.
    let said = sayings(weighing).into_iter().map(|saying| saying.sentence);
    Verdict {
        class: VerdictClass::DoesNotRespond,
        basis: Basis::Evidence,
        reasons: said.chain(weighed.reasons.into_iter().skip(1)).collect(),
        alternatives: alternatives(weighing, Some(Cause::NoResponse)),
        ..weighed
    }
}

/// What the OP alone says: no more than how probable its shape makes it.
fn of_op_alone(weighing: &Weighing, preliminary: Verdict) -> Verdict {
    let probability = weighing.probability;
    let says = format!(
        "the pattern of the OP alone makes it {}; without the PV nothing more can be said",
        percent(probability)
    );
    let said = sayings(weighing).into_iter().map(|saying| saying.sentence);
    Verdict {
        class: VerdictClass::CannotTell,
        basis: Basis::OpAlone,
        probability: Some(probability),
        reasons: said.chain([says]).collect(),
        alternatives: alternatives(weighing, Some(Cause::StickingValve)),
        ..preliminary
    }
}

/// The verdict of the majority of the published methods.
///
/// The rule, which is ours and has not been fitted to anything:
///
/// 1. data that are unfit give `cannot tell`;
/// 2. each [`Family`] of methods has one vote, that of most of its methods which decide: five
///    tests of the same windows are not five witnesses. With at least [`FEWEST_VOTES`] families that
///    decide, and more than half of them agreeing, they win; anything else is `cannot tell`;
/// 3. but no valve is accused on data that make healthy loops look sticky ([`MIMICS`]): that is
///    `cannot tell`; and none is cleared by a loop that does not cycle, where sticking need not show.
///
/// Methods that tell the cause of an oscillation abstain where none was found (see
/// [`detect::judge`](crate::detect::judge)). The votes are not independent, so their share is no
/// probability.
pub fn preliminary(fitness: &Fitness, oscillates: bool, findings: &[Finding]) -> Verdict {
    let votes = Votes::of(findings);
    let (class, basis, reasons) = match majority(fitness, oscillates, votes) {
        Ok((class, tally)) => {
            let reasons = [tally].into_iter().chain(agreeing(findings, class)).collect();
            (class, Basis::Majority, reasons)
        }
        Err(why) => (VerdictClass::CannotTell, Basis::None, why),
    };
    Verdict { class, basis, votes, reasons, ..Verdict::default() }
}

/// What the majority says, with the tally; or why nothing is concluded, in sentences.
fn majority(
    fitness: &Fitness,
    oscillates: bool,
    votes: Votes,
) -> std::result::Result<(VerdictClass, String), Vec<String>> {
    if fitness.class == Class::Unfit {
        let unfit = fitness.measures.iter().filter(|m| m.class == Class::Unfit);
        let reasons = unfit.map(|m| m.reason.clone());
        return Err(["the data cannot answer".to_owned()].into_iter().chain(reasons).collect());
    }
    let decided = votes.sticks + votes.does_not_stick;
    let tally = match decided {
        0 => format!(
            "no method decides: {} families are undecided, {} abstain",
            votes.undecided, votes.abstains
        ),
        _ => format!(
            "{} of the {decided} families of methods that decide say it sticks; {} undecided, {} \
             abstaining",
            votes.sticks, votes.undecided, votes.abstains
        ),
    };
    if decided < FEWEST_VOTES {
        let few = format!("fewer than {FEWEST_VOTES} families decide, too few for a majority");
        return Err(vec![tally, few]);
    }
    let class = match (2 * votes.sticks).cmp(&decided) {
        std::cmp::Ordering::Greater => VerdictClass::Sticks,
        std::cmp::Ordering::Less => VerdictClass::DoesNotStick,
        std::cmp::Ordering::Equal => {
            return Err(vec![tally, "the families are evenly divided".to_owned()]);
        }
    };
    let mimics =
        fitness.measures.iter().filter(|m| m.class != Class::Fit && MIMICS.contains(&m.id));
    let mimics: Vec<&str> = mimics.map(|m| m.reason.as_str()).collect();
    if class == VerdictClass::Sticks && !mimics.is_empty() {
        let mimics = mimics.join("; ");
        return Err(vec![
            tally,
            format!("but data like these make healthy loops look sticky: {mimics}"),
        ]);
    }
    if class == VerdictClass::DoesNotStick && !oscillates {
        return Err(vec![
            tally,
            "but the loop does not cycle, and a valve that sticks need not show it then".to_owned(),
        ]);
    }
    Ok((class, tally))
}

/// What the methods of each family say that agrees with the majority, a sentence a family.
fn agreeing(findings: &[Finding], class: VerdictClass) -> impl Iterator<Item = String> {
    let families = Votes::by_family(findings).into_iter();
    families.filter(move |(_, said)| class_of(*said) == Some(class)).map(move |(family, _)| {
        let agree = findings.iter().filter(|f| {
            f.method.family == family
                && f.method.decides == Decides::Stiction
                && class_of(f.decision) == Some(class)
        });
        let methods: Vec<String> =
            agree.map(|f| format!("{}: {}", f.method.title, f.reason)).collect();
        format!("{}: {}", family.name(), methods.join("; "))
    })
}

fn class_of(decision: Decision) -> Option<VerdictClass> {
    match decision {
        Decision::Sticks => Some(VerdictClass::Sticks),
        Decision::DoesNotStick => Some(VerdictClass::DoesNotStick),
        _ => None,
    }
}
