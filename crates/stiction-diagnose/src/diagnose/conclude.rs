//! The verdict: the order of the checks.

use super::belonging::Belonging;
use super::by_evidence::by_evidence;
use super::reasons::{alternatives, sayings};
use super::verdict::{Basis, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use crate::finding::{Decides, Decision, Finding};
use crate::fusion::Cause;
use crate::recording::fitness::{Class, Fitness, MeasureId};
use crate::spoken::percent;

/// Fewest families that must decide before a majority counts.
pub const FEWEST_VOTES: usize = 3;

/// Measures of fitness whose caveats explain the patterns that methods interpret as stiction: a signal that rests
/// while the other moves, a wave with corners.
pub const MIMICS: [MeasureId; 6] = [
    MeasureId::CompressionFactor,
    MeasureId::PvLevels,
    MeasureId::LongestFrozenPv,
    MeasureId::OpAtLimit,
    MeasureId::ClippedPv,
    MeasureId::SetPoint,
];

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
/// 5. If nothing could be weighed, the published methods vote: [`preliminary`].
///
/// The results of the published methods are kept beside it and counted in [`Votes`].
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
        Some(weighing) if fitness.class == Class::Unfit => of_unfit(fitness, weighing, preliminary),
        Some(weighing) if op_only => of_op_alone(weighing, preliminary),
        Some(weighing) => by_evidence(weighing, preliminary),
    }
}

/// The verdict on unfit data. Evidence that has a meaning is stated without a conclusion.
fn of_unfit(fitness: &Fitness, weighing: &Weighing, preliminary: Verdict) -> Verdict {
    let mut unfit = fitness.measures.iter().filter(|m| m.class == Class::Unfit);
    let has_meaning = unfit.all(|m| SIMULATED.contains(&m.id));
    Verdict { probability: has_meaning.then_some(weighing.probability), ..preliminary }
}

/// The verdict from the OP alone: only the probability from its shape.
fn of_op_alone(weighing: &Weighing, preliminary: Verdict) -> Verdict {
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
        ..preliminary
    }
}

/// The verdict of the majority of the published methods.
///
/// The rule is ours and has not been fitted to any data:
///
/// 1. Unfit data give `cannot tell`.
/// 2. Each [`Family`](crate::finding::Family) of methods has one vote, that of the majority of its methods that
///    decide: five tests of the same windows are not independent. A class wins if at least [`FEWEST_VOTES`]
///    families decide and more than half of them agree; otherwise the result is `cannot tell`.
/// 3. No valve is accused on data that make healthy loops look sticky ([`MIMICS`]): that is `cannot tell`. No valve
///    is cleared if its loop does not cycle, because stiction may be invisible then.
///
/// Methods that explain an oscillation abstain where none was found (see
/// [`methods::judge`](crate::methods::judge)). The votes are not independent, so their share is not a probability.
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

/// The verdict of the majority with the tally, or the reasons for no verdict, in sentences.
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
            "{} of the {decided} families of methods that decide find stiction; {} undecided, {} abstaining",
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
            format!("data like these make healthy loops look sticky ({mimics})"),
        ]);
    }
    if class == VerdictClass::DoesNotStick && !oscillates {
        return Err(vec![
            tally,
            "the loop does not cycle, so stiction may be invisible".to_owned(),
        ]);
    }
    Ok((class, tally))
}

/// The findings of each family that agree with the majority, a sentence a family.
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
