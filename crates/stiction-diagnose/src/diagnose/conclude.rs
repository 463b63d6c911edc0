//! The verdict: what is asked, in which order.

use super::belonging::Belonging;
use super::by_evidence::{by_evidence, thresholds};
use super::reasons::{alternatives, sayings};
use super::verdict::{Basis, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use crate::finding::{Decides, Decision, Finding};
use crate::fusion::Cause;
use crate::recording::fitness::{Class, Fitness, MeasureId};
use crate::spoken::percent;

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
/// 2. each [`Family`](crate::finding::Family) of methods has one vote, that of most of its methods which decide: five
///    tests of the same windows are not five witnesses. With at least [`FEWEST_VOTES`] families that
///    decide, and more than half of them agreeing, they win; anything else is `cannot tell`;
/// 3. but no valve is accused on data that make healthy loops look sticky ([`MIMICS`]): that is
///    `cannot tell`; and none is cleared by a loop that does not cycle, where sticking need not show.
///
/// Methods that tell the cause of an oscillation abstain where none was found (see
/// [`methods::judge`](crate::methods::judge)). The votes are not independent, so their share is no
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
