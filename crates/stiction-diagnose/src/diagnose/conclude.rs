//! The verdict: the checks in their order.

use super::belonging::Belonging;
use super::by_evidence::{Ruling, by_evidence};
use super::few_slips::{FewSlips, few_slips};
use super::measured::ByPosition;
use super::reasons::{alternatives, sayings};
use super::verdict::{Basis, Stiction, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use super::{no_response, quantify, tested};
use crate::finding::Abstention;
use crate::fusion::Cause;
use crate::recording::Segment;
use crate::recording::fitness::{Class, Fitness, MeasureId};
use crate::spoken::percent;
use crate::valve_test::TestReading;

/// Measures of fitness on which a loop of the population may fail too. If data are unfit only for these reasons,
/// their evidence has a meaning, but cannot show whether the valve sticks.
pub const SIMULATED: [MeasureId; 3] =
    [MeasureId::Cycles, MeasureId::SamplesPerCycle, MeasureId::OpAtLimit];

/// What was seen of a recording. The verdict follows from it.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    pub fitness: &'a Fitness,
    /// The results of the published methods decide nothing. They are counted.
    pub votes: Votes,
    /// The longest segment; `None` without a segment.
    pub segment: Option<&'a Segment>,
    /// The evidence of the segment's windows, or why it has none.
    pub weighing: Option<&'a Result<Weighing, Abstention>>,
    /// Whether the columns belong together and the PV responds.
    pub belonging: &'a Belonging<'a>,
    /// What the recorded position shows, or why it shows nothing.
    pub position: Option<&'a Result<ByPosition, Abstention>>,
    /// The valve test in the recording.
    pub test: Option<&'a TestReading>,
}

impl Seen<'_> {
    /// The evidence that was weighed.
    pub fn weighed(&self) -> Option<&Weighing> {
        self.weighing.and_then(|weighing| weighing.as_ref().ok())
    }

    /// Whether a PV is recorded in the segment.
    fn has_pv(&self) -> bool {
        self.segment.is_some_and(|segment| segment.pv.is_some())
    }
}

/// A check: the verdict, if the check gives one. A check may request the verdict of the later checks.
struct Check(fn(&Seen<'_>, rest: &[Check]) -> Option<Verdict>);

/// The checks in their order. The first one that gives a verdict decides.
const CHECKS: [Check; 7] = [
    Check(mistaken_columns),
    Check(valve_test),
    Check(valve_position),
    Check(response),
    Check(unfit_data),
    Check(op_alone),
    Check(evidence),
];

/// The verdict of the first of these checks that gives one. If none does, nothing was weighed.
fn first(seen: &Seen<'_>, checks: &[Check]) -> Verdict {
    match checks.split_first() {
        Some((Check(check), rest)) => check(seen, rest).unwrap_or_else(|| first(seen, rest)),
        None => not_weighed(seen),
    }
}

/// Columns that do not belong together end the judgement.
fn mistaken_columns(seen: &Seen<'_>, _: &[Check]) -> Option<Verdict> {
    let (mismatch, because) = seen.belonging.mistake()?;
    Some(Verdict {
        votes: seen.votes,
        reasons: vec![format!("{}: {because}", mismatch.name()), mismatch.remedy().to_owned()],
        ..Verdict::default()
    })
}

/// A valve test decides, except against a position that decides, because that shows the stem itself.
fn valve_test(seen: &Seen<'_>, rest: &[Check]) -> Option<Verdict> {
    let test = seen.test.filter(|_| seen.belonging.belong())?;
    let by_test = tested::by_test(test, seen.votes)?;
    let others = first(seen, rest);
    let is_open = others.basis != Basis::ValvePosition || others.class == VerdictClass::CannotTell;
    is_open.then_some(by_test)
}

/// A recorded position decides where it can be judged. The result from OP and PV is kept beside it.
fn valve_position(seen: &Seen<'_>, rest: &[Check]) -> Option<Verdict> {
    match seen.position? {
        Ok(position) => {
            // Without a PV of this loop, OP and PV decide nothing.
            let belong = seen.belonging.belong();
            let without = if belong { first(seen, rest) } else { Verdict::default() };
            Some(position.verdict(without, seen.weighed().map(|weighing| weighing.s)))
        }
        Err(Abstention(why)) if seen.fitness.class != Class::Unfit => {
            let mut verdict = first(seen, rest);
            let unused = format!("the recorded valve position cannot be used: {why}");
            verdict.contradictions.push(unused);
            Some(verdict)
        }
        Err(_) => None,
    }
}

/// A PV that does not respond is named before unfit data end the judgement.
fn response(seen: &Seen<'_>, _: &[Check]) -> Option<Verdict> {
    let segment = seen.segment.filter(|segment| segment.pv.is_some())?;
    let (rest, step) = (seen.belonging.rest.as_ref(), segment.sample_time);
    no_response::verdict(rest, step, seen.weighed(), seen.fitness, seen.votes)
}

/// Unfit data cannot answer. Evidence that has a meaning is stated without a conclusion.
fn unfit_data(seen: &Seen<'_>, _: &[Check]) -> Option<Verdict> {
    let weighing = seen.weighed().filter(|_| seen.fitness.class == Class::Unfit)?;
    let mut unfit = seen.fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    let has_meaning = unfit.all(|m| SIMULATED.contains(&m.id));
    let probability = has_meaning.then_some(weighing.probability);
    Some(Verdict { probability, ..not_weighed(seen) })
}

/// Without a PV there is no conclusion, only a probability from the shape of the OP.
fn op_alone(seen: &Seen<'_>, _: &[Check]) -> Option<Verdict> {
    let weighing = seen.weighed().filter(|_| !seen.has_pv())?;
    let probability = weighing.probability;
    let says = format!(
        "the pattern of the OP alone gives {}; the PV is needed for a verdict",
        percent(probability)
    );
    let said = sayings(weighing).into_iter().map(|saying| saying.sentence);
    Some(Verdict {
        basis: Basis::OpAlone,
        probability: Some(probability),
        votes: seen.votes,
        reasons: said.chain([says]).collect(),
        alternatives: alternatives(weighing, Some(Cause::StickingValve)),
        ..Verdict::default()
    })
}

/// The evidence in OP and PV decides, weighed by the [frozen model](crate::fusion).
fn evidence(seen: &Seen<'_>, _: &[Check]) -> Option<Verdict> {
    Some(by_evidence(seen.weighed()?, seen.votes))
}

/// Nothing can be weighed.
fn not_weighed(seen: &Seen<'_>) -> Verdict {
    let why = match seen.fitness.class {
        Class::Unfit => "the data cannot answer",
        _ => "the evidence cannot be measured",
    };
    let unfit = seen.fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    let reasons = std::iter::once(why.to_owned()).chain(unfit.map(|m| m.reason.clone())).collect();
    Verdict { votes: seen.votes, reasons, ..Verdict::default() }
}

/// A verdict together with its basis.
pub(super) struct Conclusion {
    pub verdict: Verdict,
    /// The amount of stiction, without its competing definitions.
    pub stiction: Stiction,
    /// The slips that the verdict lacks.
    pub few_slips: Option<FewSlips>,
}

/// The conclusion from the measurements, by the checks of [`CHECKS`].
pub(super) fn conclude(seen: &Seen<'_>) -> Conclusion {
    let verdict = first(seen, &CHECKS);
    let stiction = amount(seen, &verdict);
    let few_slips = missing_slips(seen, &verdict);
    let mut reasons = verdict.reasons;
    reasons.extend(few_slips.as_ref().map(|few| few.words.clone()));
    // A value with its interval replaces the limit.
    let s_below = verdict.s_below.filter(|_| stiction.s.is_none());
    Conclusion { verdict: Verdict { reasons, s_below, ..verdict }, stiction, few_slips }
}

/// The amount of stiction, from the basis of the verdict.
fn amount(seen: &Seen<'_>, verdict: &Verdict) -> Stiction {
    let not_known = |why: &str| Stiction { why_not: Some(why.to_owned()), ..Stiction::default() };
    if let Some((mismatch, _)) = seen.belonging.mistake() {
        return not_known(mismatch.name());
    }
    match (verdict.basis, seen.test, seen.position, seen.weighing) {
        (Basis::ValveTest, Some(test), ..) => tested::stiction(test),
        (Basis::ValvePosition, _, Some(Ok(position)), _) => position.stiction.clone(),
        (.., Some(Ok(weighing))) => quantify::estimated(weighing, verdict, !seen.has_pv()),
        (.., Some(Err(Abstention(why)))) => not_known(why),
        (.., None) => Stiction::default(),
    }
}

/// The slips that a verdict lacks. This applies if the evidence is undecided only because it is too little, or the data
/// are unfit only because of too few cycles.
fn missing_slips(seen: &Seen<'_>, verdict: &Verdict) -> Option<FewSlips> {
    let segment = seen.segment.filter(|_| seen.has_pv() && seen.belonging.mistake().is_none())?;
    let weighing = seen.weighed().filter(|_| verdict.class == VerdictClass::CannotTell)?;
    let too_little = match verdict.basis {
        Basis::Evidence => Ruling::of(weighing) == Ruling::Open,
        Basis::None => {
            let mut unfit = seen.fitness.measures.iter().filter(|m| m.class == Class::Unfit);
            seen.fitness.class == Class::Unfit && unfit.all(|m| m.id == MeasureId::Cycles)
        }
        _ => false,
    };
    // Of a valve that changed, the windows before are no record of its present state.
    let record_s = if weighing.changes.is_empty() { segment.duration() } else { 0.0 };
    few_slips(weighing, record_s.max(weighing.covered())).filter(|_| too_little)
}
