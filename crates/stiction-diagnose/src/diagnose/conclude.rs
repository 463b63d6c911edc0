//! The verdict: the order of the checks.

use super::belonging::Belonging;
use super::by_evidence::by_evidence;
use super::reasons::{alternatives, sayings};
use super::verdict::{Basis, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use crate::finding::Finding;
use crate::fusion::Cause;
use crate::recording::fitness::{Class, Fitness, MeasureId};
use crate::spoken::percent;

/// Measures of fitness on which a loop of the population may fail too. If data are unfit only for these reasons,
/// their evidence has a meaning, but cannot show whether the valve sticks.
pub const SIMULATED: [MeasureId; 3] =
    [MeasureId::Cycles, MeasureId::SamplesPerCycle, MeasureId::OpAtLimit];

/// The verdict.
///
/// 0. Columns that do not belong together end the judgement. A PV that does not respond is named before fitness can
///    end it: [`Belonging`].
/// 1. Unfit data give `cannot tell`, with a probability if they are unfit by no more than [`SIMULATED`].
/// 2. A recorded valve position decides where it can be judged: [`by_position`](super::by_position). The following
///    steps are then skipped.
/// 3. Without a PV there is no conclusion, only a probability from the shape of the OP.
/// 4. Otherwise the evidence in OP and PV, weighed by the [frozen model](crate::fusion), decides: [`by_evidence`].
///
/// The results of the published methods decide nothing. They are kept beside it and counted in [`Votes`].
pub(super) fn conclude(
    fitness: &Fitness,
    findings: &[Finding],
    weighing: Option<&Weighing>,
    op_only: bool,
    belongs: &Belonging<'_>,
) -> Verdict {
    let not_weighed = not_weighed(fitness, findings);
    if let Some(verdict) = belongs.verdict(weighing, fitness, &not_weighed) {
        return verdict;
    }
    match weighing {
        None => not_weighed,
        Some(weighing) if fitness.class == Class::Unfit => of_unfit(fitness, weighing, not_weighed),
        Some(weighing) if op_only => of_op_alone(weighing, not_weighed),
        Some(weighing) => by_evidence(weighing, not_weighed),
    }
}

/// The verdict on unfit data. Evidence that has a meaning is stated without a conclusion.
fn of_unfit(fitness: &Fitness, weighing: &Weighing, not_weighed: Verdict) -> Verdict {
    let mut unfit = fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    let has_meaning = unfit.all(|m| SIMULATED.contains(&m.id));
    Verdict { probability: has_meaning.then_some(weighing.probability), ..not_weighed }
}

/// The verdict from the OP alone: only the probability from its shape.
fn of_op_alone(weighing: &Weighing, not_weighed: Verdict) -> Verdict {
    let probability = weighing.probability;
    let says = format!(
        "the pattern of the OP alone gives {}; the PV is needed for a verdict",
        percent(probability)
    );
    let said = sayings(weighing).into_iter().map(|saying| saying.sentence);
    Verdict {
        class: VerdictClass::CannotTell,
        basis: Basis::OpAlone,
        probability: Some(probability),
        reasons: said.chain([says]).collect(),
        alternatives: alternatives(weighing, Some(Cause::StickingValve)),
        ..not_weighed
    }
}

/// The verdict where nothing can be weighed: `cannot tell`, with the reasons.
fn not_weighed(fitness: &Fitness, findings: &[Finding]) -> Verdict {
    let unfit = fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    let why = match fitness.class {
        Class::Unfit => "the data cannot answer",
        _ => "the evidence cannot be measured",
    };
    let reasons = std::iter::once(why.to_owned()).chain(unfit.map(|m| m.reason.clone())).collect();
    Verdict { votes: Votes::of(findings), reasons, ..Verdict::default() }
}
