//! All steps in a row, from a recording to its diagnosis.

use super::belonging::Belonging;
use super::by_evidence::Ruling;
use super::conclude::conclude;
use super::definitions::definitions;
use super::diagnosis::{Diagnosis, Judged, silent};
use super::few_slips::{FewSlips, few_slips};
use super::fit_windows::fit_windows;
use super::kpis::{KpiOptions, Kpis};
use super::measured::{ByPosition, by_position};
use super::no_response::NoResponse;
use super::oscillations::Oscillations;
use super::quantify;
use super::relation::Relation;
use super::verdict::{Basis, Grade, Stiction, Verdict, VerdictClass};
use super::weighing::Weighing;
use crate::error::{Result, non_negative};
use crate::finding::{Abstention, Family, Finding};
use crate::methods::{self, Detector, MethodId, Subject};
use crate::recording::fitness::{self, Class, Fitness, Measure, MeasureId};
use crate::recording::{ByHand, Grid, GridOptions, LoopType, Recording, Segment};
use crate::spoken::time;
use crate::valve_test::{self, PlanOptions};

/// What may be told about a loop before it is diagnosed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DiagnoseOptions {
    /// What the loop controls, if the recording does not know.
    pub loop_type: Option<LoopType>,
    /// How the recording is brought onto a grid.
    pub grid: GridOptions,
    /// What the key figures need to know.
    pub kpis: KpiOptions,
    /// Which published methods are asked.
    pub detectors: Detectors,
    /// Whether findings keep what they [looked at](Finding::looked_at), for a report that draws it. It is about
    /// twice what the recording itself takes.
    pub evidence: bool,
}

/// Which of the published methods are asked for a diagnosis. They cost most of its time, so whoever
/// needs no more than the verdict, or than some of them, can leave the others out.
///
/// Those that read the measured valve position ([`Family::Measured`]) are always asked, because the
/// verdict follows them. A verdict that rests on a majority counts the votes of those that are asked only.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Detectors {
    /// All of the registry.
    #[default]
    All,
    /// None.
    None,
    /// These.
    Only(Vec<MethodId>),
}

impl Detectors {
    /// The detectors that are asked, in the order of the registry.
    pub fn asked(&self) -> Vec<Box<dyn Detector>> {
        let mut detectors = methods::all();
        detectors.retain(|detector| {
            let method = detector.method();
            let chosen = match self {
                Self::All => true,
                Self::None => false,
                Self::Only(methods) => methods.iter().any(|id| id.method() == method),
            };
            chosen || method.family == Family::Measured
        });
        detectors
    }
}

/// A segment as a diagnosis shows it to the detectors: with the period of the oscillation that speaks for the
/// loop, if one is found.
pub fn subject(segment: &Segment, loop_type: LoopType) -> Subject<'_> {
    Subject::new(segment, loop_type, Oscillations::of(segment).period(segment))
}

/// Whether a recording can answer, by the segment that a diagnosis would judge.
///
/// # Errors
/// As for [`Grid::of`].
pub fn fitness(recording: &Recording, options: &GridOptions) -> Result<Fitness> {
    let grid = Grid::of(recording, options)?;
    let period = grid.longest().and_then(|s| subject(s, recording.loop_type).period);
    Ok(assessed(recording, &grid, period).1)
}

/// The windows that are judged, and whether they can answer.
fn assessed(recording: &Recording, grid: &Grid, period: Option<f64>) -> (Vec<Segment>, Fitness) {
    match grid.longest() {
        Some(segment) => {
            let whole = fitness::assess(recording, grid, segment, period);
            fit_windows(recording, grid, segment, whole)
        }
        None => (vec![], Fitness::of(vec![no_segment(grid)])),
    }
}

/// Diagnoses a recording.
///
/// # Errors
/// If the recording cannot be brought onto a grid, as when its times make no sense, or an option is out of
/// its range. Whatever else is wrong with the data is a result: the diagnosis says that it cannot tell, and why.
pub fn diagnose(recording: &Recording, options: &DiagnoseOptions) -> Result<Diagnosis> {
    if let Some(dead_time) = options.kpis.dead_time {
        non_negative("the dead time", dead_time)?;
    }
    let grid = Grid::of(recording, &options.grid)?;
    let loop_type = options.loop_type.unwrap_or(recording.loop_type);
    let segment = grid.longest();
    let oscillations = segment.map_or_else(Oscillations::default, Oscillations::of);
    let period = segment.and_then(|segment| oscillations.period(segment));

    let (fit, fitness) = assessed(recording, &grid, period);
    let subject = segment.map(|segment| Subject::new(segment, loop_type, period));
    let mut findings = findings(&options.detectors, subject.as_ref());
    let kpis = segment
        .map_or_else(Kpis::default, |segment| Kpis::of(recording, &grid, segment, &options.kpis));
    let oscillates = oscillations.dominant().is_some_and(|(_, o)| o.found);
    let weighing = segment.map(|_| Weighing::of_windows(&fit));
    let op_only = segment.is_some_and(|segment| segment.pv.is_none());
    let weighed = weighing.as_ref().and_then(|weighing| weighing.as_ref().ok());
    let by_position = subject.as_ref().and_then(|subject| by_position(subject, &fitness));
    let measured = matches!(by_position, Some(Ok(_)));
    let belonging = segment.map_or_else(Belonging::default, |s| Belonging::of(s, measured));
    let mut verdict = conclude(&fitness, oscillates, &findings, weighed, op_only, &belonging);
    let mistaken = belonging.ends();
    match &by_position {
        _ if mistaken.is_some() => {}
        Some(Ok(said)) => verdict = said.verdict(verdict),
        Some(Err(Abstention(why))) if fitness.class != Class::Unfit => {
            verdict
                .contradictions
                .push(format!("the valve position that is recorded is of no use: {why}"));
        }
        _ => {}
    }
    let by_position = by_position.and_then(std::result::Result::ok);
    let few_slips = segment
        .zip(weighed.filter(|_| mistaken.is_none()))
        .and_then(|(segment, weighing)| missing_slips(segment, weighing, &verdict, &fitness));
    verdict.reasons.extend(few_slips.as_ref().map(|few| few.words.clone()));
    let mut stiction = match mistaken {
        Some(mistake) => not_known(mistake),
        None => how_much(by_position.as_ref(), weighing.as_ref(), &verdict, op_only),
    };
    let mut test_due = false;
    if let Some(subject) = &subject {
        // A number with its interval says more than a limit.
        verdict.s_below = verdict.s_below.filter(|_| stiction.s.is_none());
        // Where it does not stick, no number is called stiction.
        let answers =
            mistaken.is_none() && (by_position.is_some() || fitness.class != Class::Unfit);
        if verdict.class != VerdictClass::DoesNotStick && answers {
            stiction.definitions = definitions(subject, &findings, stiction.s.map(|s| s.value));
            test_due = verdict.basis != Basis::ValvePosition;
        }
    }
    if !options.evidence {
        findings.iter_mut().for_each(|finding| finding.looked_at = None);
    }
    let windows = weighed.map_or(vec![], |weighing| weighing.windows.clone());
    let mut notes = recording.notes.clone();
    notes.extend(segment.and_then(|segment| cut(&grid, segment)));
    notes.extend(ByHand::of(recording).and_then(|by_hand| test_beside(&by_hand)));
    let relation = belonging.relation.as_ref();
    let followed = by_position.is_some() && mistaken.is_none();
    notes.extend(relation.filter(|_| followed).and_then(mistake_beside));
    let mut diagnosis = Diagnosis {
        name: recording.name.clone(),
        loop_type,
        start: recording.start,
        plant_time: recording.plant_time.clone(),
        mode: recording.mode.clone(),
        pv_unit: recording.pv.as_ref().and_then(|pv| pv.unit.clone()),
        judged: Judged::of(&grid),
        fitness,
        oscillations,
        findings,
        kpis,
        relation: belonging.relation,
        no_response: NoResponse::of(belonging.rest, silent(&verdict)),
        few_slips,
        verdict,
        stiction,
        windows,
        evidence: weighing.and_then(std::result::Result::ok),
        notes,
        grid,
    };
    diagnosis.verdict.grade = Grade::of(&diagnosis);
    if test_due {
        match valve_test::plan(&diagnosis, &PlanOptions::default()) {
            Ok(plan) => diagnosis.verdict.confirm = Some(plan),
            Err(Abstention(why)) => diagnosis.verdict.no_test = Some(why),
        }
    }
    Ok(diagnosis)
}

/// What the methods that are asked say; without a subject, that there is none.
fn findings(asked: &Detectors, subject: Option<&Subject<'_>>) -> Vec<Finding> {
    let said = |detector: &dyn Detector| match subject {
        Some(subject) => methods::judge(detector, subject),
        None => {
            let why = "there is no segment in automatic to look at".to_owned();
            let finding = Finding::abstains(detector.method(), Abstention(why));
            Finding { parameters: detector.parameters(), ..finding }
        }
    };
    asked.asked().iter().map(|detector| said(&**detector)).collect()
}

/// How much it sticks: by the measured position, else by the evidence.
fn how_much(
    by_position: Option<&ByPosition>,
    weighing: Option<&std::result::Result<Weighing, Abstention>>,
    verdict: &Verdict,
    op_only: bool,
) -> Stiction {
    match (by_position, weighing) {
        (Some(said), _) => said.stiction.clone(),
        (None, Some(Ok(weighing))) => quantify::estimated(weighing, verdict, op_only),
        (None, Some(Err(Abstention(why)))) => not_known(why),
        (None, None) => Stiction::default(),
    }
}

fn not_known(why: &str) -> Stiction {
    Stiction { why_not: Some(why.to_owned()), ..Stiction::default() }
}

/// That a segment is not all that was recorded.
fn cut(grid: &Grid, segment: &Segment) -> Option<String> {
    let count = grid.segments.len();
    let share = 100.0 * segment.duration() / (grid.duration + grid.sample_time);
    (count > 1).then(|| {
        format!("the recording is cut into {count} segments; the longest, {share:.0} % of its duration, is judged")
    })
}

/// That a test of the valve is in the recording, which the verdict does not use.
fn test_beside(by_hand: &ByHand) -> Option<String> {
    let (turns, (from, to)) = (by_hand.turns(), by_hand.span_s());
    by_hand.is_test().then(|| {
        format!(
            "a test of the valve is in this recording, {turns} turns of the OP by hand within {}; `stiction test read` \
             judges it",
            time(to - from)
        )
    })
}

/// The mistake in the columns that does not matter, because the verdict follows the measured position.
fn mistake_beside(relation: &Relation) -> Option<String> {
    let (mismatch, because) = (relation.mismatch?.name(), &relation.because);
    Some(format!(
        "{mismatch}: {because}; the verdict follows the measured valve position, which needs no PV"
    ))
}

/// The slips that a verdict lacks: where the evidence is undecided for no other reason than that it is too little, or
/// data are unfit for no other than too few cycles.
fn missing_slips(
    segment: &Segment,
    weighing: &Weighing,
    verdict: &Verdict,
    fitness: &Fitness,
) -> Option<FewSlips> {
    if segment.pv.is_none() || verdict.class != VerdictClass::CannotTell {
        return None;
    }
    let too_little = match verdict.basis {
        Basis::Evidence => Ruling::of(weighing) == Ruling::Open,
        Basis::None => {
            let mut unfit = fitness.measures.iter().filter(|m| m.class == Class::Unfit);
            fitness.class == Class::Unfit && unfit.all(|m| m.id == MeasureId::Cycles)
        }
        _ => false,
    };
    few_slips(weighing, segment.duration()).filter(|_| too_little)
}

/// Why there is nothing to judge.
fn no_segment(grid: &Grid) -> Measure {
    Measure {
        id: MeasureId::AutomaticSegment,
        value: Some(100.0 * grid.closed_share),
        unit: "%",
        caveat_at: None,
        unfit_at: Some(0.0),
        class: Class::Unfit,
        reason: if grid.closed_share == 0.0 {
            "the loop never was in automatic, so the valve was not driven by its controller"
                .to_owned()
        } else {
            "no segment in automatic has enough good samples in a row".to_owned()
        },
    }
}
