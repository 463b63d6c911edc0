//! All steps in a row.

use super::belonging::Belonging;
use super::by_evidence::Ruling;
use super::confirm::confirming_test;
use super::definitions::definitions;
use super::few_slips::{FewSlips, few_slips};
use super::fit_windows::fit_windows;
use super::grade::Grade;
use super::history::Observation;
use super::measured::{ByPosition, by_position};
use super::no_response::{NoResponse, Silence};
use super::quantify;
use super::relation::{Mismatch, Relation};
use super::verdict::{Basis, Stiction, Verdict, VerdictClass, Votes, conclude};
use super::weighing::Weighing;
use super::{KpiOptions, Kpis};
#[cfg(feature = "serde")]
use super::{relation::Mistake, verdict::Limit};
use crate::bands::Bands;
use crate::detect::{self, Abstention, Detector, Family, Finding, MethodId, Subject};
use crate::error::{Result, non_negative};
use crate::fusion::Estimate;
use crate::identify::slips::Motion;
use crate::oscillation::{self, Oscillation};
use crate::recording::fitness::{self, Class, Fitness, Measure, MeasureId};
use crate::recording::{Grid, GridOptions, LoopType, Modes, PlantTime, Recording, Segment};
use crate::valve::{Start, Valve};

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
        let mut detectors = detect::all();
        detectors.retain(|detector| {
            let method = detector.method();
            let chosen = match self {
                Self::All => true,
                Self::None => false,
                Self::Only(methods) => methods.contains(&method.id),
            };
            chosen || method.family == Family::Measured
        });
        detectors
    }
}

/// Everything that was found out about one loop.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Diagnosis {
    /// Tag of the loop.
    #[cfg_attr(feature = "serde", serde(rename = "loop"))]
    pub name: String,
    /// What it controls.
    #[cfg_attr(feature = "serde", serde(rename = "type"))]
    pub loop_type: LoopType,
    /// The segment that was judged, the longest of the grid; `None` if there is none.
    pub judged: Option<Judged>,
    /// Time zero of the recording's clock as seconds since 1970-01-01 UTC, if it is known.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub start: Option<f64>,
    /// The clock of the plant, by which its times are told.
    pub plant_time: PlantTime,
    /// The recording on a regular grid, with what was mended.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "repairs", serialize_with = "repairs"),
        schemars(
            with = "Vec<crate::recording::GridRepair>",
            description = "What had to be mended in the data."
        )
    )]
    pub grid: Grid,
    /// The controller's mode over time, where it is recorded.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub mode: Option<Modes>,
    /// Unit of the PV, where the file names one.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub pv_unit: Option<String>,
    /// Whether the data can answer.
    pub fitness: Fitness,
    /// The oscillations, with times on the recording's clock.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "oscillation", serialize_with = "dominant"),
        schemars(
            with = "Option<Dominant<'static>>",
            description = "The oscillation that speaks for the loop, with times on the recording's clock; null without a segment to judge."
        )
    )]
    pub oscillations: Oscillations,
    /// What each method that was asked says, in the order of the registry.
    #[cfg_attr(feature = "serde", serde(rename = "detectors"))]
    pub findings: Vec<Finding>,
    /// Key figures of the loop.
    pub kpis: Kpis,
    /// Whether OP and PV belong together; `None` without a segment.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "Mistake::of"),
        schemars(
            with = "Option<Mistake<'static>>",
            description = "The likely mistake in the columns; null where OP and PV belong together, as far as can be told."
        )
    )]
    pub relation: Option<Relation>,
    /// What the PV does that does not respond; `None` where it responds, as far as can be told.
    pub no_response: Option<NoResponse>,
    /// The conclusion.
    pub verdict: Verdict,
    /// How much the valve sticks.
    pub stiction: Stiction,
    /// Slips that a record lacks which looks stuck; `None` where it does not, or has enough.
    pub few_slips: Option<FewSlips>,
    /// The evidence that was weighed, all windows together; `None` where nothing could be.
    pub evidence: Option<Weighing>,
    /// The windows of the judged segment that were weighed one by one, in order of time.
    pub windows: Vec<Window>,
    /// What the reader of the file, or a step on the way, wants the user to know.
    pub notes: Vec<String>,
}

/// The part of a recording that was judged.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Judged {
    /// Which of the grid's segments it is.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub segment: usize,
    /// Time of its first sample, s on the recording's clock.
    pub from_s: f64,
    /// Its duration, s.
    pub duration_s: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// How many of them were bridged.
    pub bridged: usize,
    /// Out of how many segments it was taken.
    pub segments: usize,
    /// The signals it has.
    pub signals: Vec<&'static str>,
}

impl Judged {
    /// The longest segment of a grid; `None` if it has none.
    fn of(grid: &Grid) -> Option<Self> {
        let longest = grid.longest()?;
        let segment = grid.segments.iter().position(|each| std::ptr::eq(each, longest))?;
        let recorded = [
            ("OP", true),
            ("PV", longest.pv.is_some()),
            ("SP", longest.sp.is_some()),
            ("VP", longest.vp.is_some()),
        ];
        Some(Self {
            segment,
            from_s: longest.from,
            duration_s: longest.duration(),
            sample_time_s: longest.sample_time,
            samples: longest.len(),
            bridged: longest.bridged,
            segments: grid.segments.len(),
            signals: recorded.iter().filter(|(_, there)| *there).map(|(name, _)| *name).collect(),
        })
    }
}

/// The oscillations of a loop.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Oscillations {
    /// That of the control error, or of the PV where there is no set point; `None` without a PV.
    pub error: Option<Oscillation>,
    /// That of the OP; `None` without a segment.
    pub op: Option<Oscillation>,
}

impl Oscillations {
    /// Those of a segment.
    pub(super) fn of(segment: &Segment) -> Self {
        let error =
            Subject::new(segment, LoopType::Unknown, None).error().map(|e| e.values.clone());
        let analyse =
            |signal: &[f64]| oscillation::analyse(signal, segment.sample_time).since(segment.from);
        Self { error: error.as_deref().map(analyse), op: Some(analyse(&segment.op)) }
    }

    /// The oscillation that speaks for the loop, and its signal: that of the error if it oscillates,
    /// else that of the OP if that does, else that of the error, where there is one.
    pub fn dominant(&self) -> Option<(&'static str, &Oscillation)> {
        let error = self.error.as_ref().map(|found| ("error", found));
        let op = self.op.as_ref().map(|found| ("OP", found));
        [error, op].into_iter().flatten().find(|(_, o)| o.found).or(error).or(op)
    }

    /// The period of the dominant one if it was found, in samples.
    pub(super) fn period(&self, segment: &Segment) -> Option<f64> {
        let (_, oscillation) = self.dominant().filter(|(_, oscillation)| oscillation.found)?;
        Some(oscillation.period_s? / segment.sample_time)
    }
}

/// The oscillation that speaks for the loop, as documents tell it.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
#[schemars(rename = "Oscillation")]
struct Dominant<'a> {
    /// The signal it was found in: `error` or `OP`.
    signal: &'static str,
    #[serde(flatten)]
    found: &'a Oscillation,
}

#[cfg(feature = "serde")]
fn dominant<S: serde::Serializer>(
    oscillations: &Oscillations,
    to: S,
) -> std::result::Result<S::Ok, S::Error> {
    let dominant = oscillations.dominant().map(|(signal, found)| Dominant { signal, found });
    serde::Serialize::serialize(&dominant, to)
}

#[cfg(feature = "serde")]
fn repairs<S: serde::Serializer>(grid: &Grid, to: S) -> std::result::Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&grid.repairs, to)
}

/// What one window of a segment says.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Window {
    /// Time of its first sample, s on the recording's clock.
    #[cfg_attr(feature = "serde", serde(rename = "from_s"))]
    pub from: f64,
    /// Its duration, s.
    #[cfg_attr(feature = "serde", serde(rename = "duration_s"))]
    pub duration: f64,
    /// The probability that the valve sticks.
    pub probability: f64,
    /// Stick band plus dead band, percent of span, where it could be quantified.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, where it could be quantified.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// Had the valve stuck by more, percent of span, this window would have shown it, with 95 %.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "S_below", serialize_with = "Limit::of_evidence"),
        schemars(with = "Option<Limit>")
    )]
    pub limit: Option<f64>,
}

impl Diagnosis {
    /// The segment that was judged.
    pub fn segment(&self) -> Option<&Segment> {
        self.grid.segments.get(self.judged.as_ref()?.segment)
    }

    /// The oscillation that speaks for the loop, and its signal: that of the error if it oscillates,
    /// else that of the OP if that does, else that of the error, where there is one.
    pub fn oscillation(&self) -> Option<(&'static str, &Oscillation)> {
        self.oscillations.dominant()
    }

    /// Where the loop stands in a ranked list, the worst lowest: by class, in it by the probability that
    /// its valve sticks or, where there is none, by the share of the votes.
    pub fn rank(&self) -> f64 {
        let Votes { sticks, does_not_stick, .. } = self.verdict.votes;
        let share = sticks as f64 / (sticks + does_not_stick).max(1) as f64;
        let class = match self.verdict.class {
            VerdictClass::Sticks => 0.0,
            VerdictClass::DoesNotRespond => 1.0,
            VerdictClass::CannotTell => 2.0,
            VerdictClass::DoesNotStick => 3.0,
        };
        class - 0.999 * self.verdict.probability.unwrap_or(share)
    }

    /// The mistake in the columns that ended the judgement, if one did.
    pub fn mistaken(&self) -> Option<Mismatch> {
        let measured = self.verdict.basis == Basis::ValvePosition;
        self.relation.as_ref()?.ends(measured)
    }

    /// Why the evidence in OP and PV decided nothing; `None` where something else, or it, decided.
    pub fn undecided_by(&self) -> Option<Ruling> {
        let verdict = &self.verdict;
        let open = verdict.class == VerdictClass::CannotTell && verdict.basis == Basis::Evidence;
        self.evidence.as_ref().filter(|_| open).map(Ruling::of)
    }

    /// What the PV does, where the verdict is by OP and PV that it does not respond.
    pub fn silence(&self) -> Option<Silence> {
        silent(&self.verdict)
            .then(|| self.no_response.as_ref().map_or(Silence::Unmoved, |told| told.silence))
    }

    /// Samples of the judged segment at which a valve that probably sticks begins to move, by the model that predicts its
    /// PV best; `None` of a valve that nobody suspects, and without a model.
    pub fn slips(&self) -> Option<Vec<usize>> {
        if !matches!(self.verdict.grade, Grade::Sticks | Grade::ProbablySticks) {
            return None;
        }
        let (segment, weighing) = (self.segment()?, self.evidence.as_ref()?);
        let evidence = weighing.typical();
        let best = evidence.dense.as_ref().or(evidence.model.as_ref())?.best();
        let s = self.stiction.s.map_or(best.s_over_span * evidence.op_span, |s| s.value);
        let mut valve = best.model.build(Bands::from_s_j(s, best.j_over_s * s).ok()?).ok()?;
        valve.restart(Start::at_rest(*segment.op.first()?));
        let mut vp = vec![0.0; segment.len()];
        valve.run(&segment.op, &mut vp).ok()?;
        Some(Motion::of(&vp).slips)
    }

    /// What it says of its valve in the middle of the judged segment, with `origin` the time of zero of its clock;
    /// `None` if no segment was judged.
    pub fn observation(&self, origin: f64) -> Option<Observation> {
        let segment = self.segment()?;
        Some(Observation {
            time: origin + segment.from + segment.duration() / 2.0,
            class: self.verdict.class,
            probability: self.verdict.probability,
            s: self.stiction.s,
            j: self.stiction.j,
            weight: 1.0,
            windows: self.evidence.as_ref().map_or(1.0, |weighing| weighing.number),
        })
    }

    /// What the detectors looked at, for plots of their evidence.
    pub fn subject(&self) -> Option<Subject<'_>> {
        let segment = self.segment()?;
        Some(Subject::new(segment, self.loop_type, self.oscillations.period(segment)))
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
    if let Some(subject) = &subject {
        // A number with its interval says more than a limit.
        verdict.s_below = verdict.s_below.filter(|_| stiction.s.is_none());
        // Where it does not stick, no number is called stiction.
        let answers =
            mistaken.is_none() && (by_position.is_some() || fitness.class != Class::Unfit);
        if verdict.class != VerdictClass::DoesNotStick && answers {
            let limit = by_position.as_ref().and_then(|said| said.s_limit);
            let weighed = weighed.map(|weighing| weighing.s.value);
            let s = stiction.s.map(|s| s.value).or(limit).or(weighed);
            stiction.definitions = definitions(subject, &findings, stiction.s.map(|s| s.value));
            verdict.confirm = confirming_test(subject, s);
        }
    }
    if !options.evidence {
        findings.iter_mut().for_each(|finding| finding.looked_at = None);
    }
    let windows = weighed.map_or(vec![], |weighing| weighing.windows.clone());
    let mut notes = recording.notes.clone();
    notes.extend(segment.and_then(|segment| cut(&grid, segment)));
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
    Ok(diagnosis)
}

/// What the methods that are asked say; without a subject, that there is none.
fn findings(asked: &Detectors, subject: Option<&Subject<'_>>) -> Vec<Finding> {
    let said = |detector: &dyn Detector| match subject {
        Some(subject) => detect::judge(detector, subject),
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

/// The mistake in the columns that does not matter, because the verdict follows the measured position.
fn mistake_beside(relation: &Relation) -> Option<String> {
    let (mismatch, because) = (relation.mismatch?.name(), &relation.because);
    Some(format!(
        "{mismatch}: {because}; the verdict follows the measured valve position, which needs no PV"
    ))
}

/// Whether a verdict is by OP and PV that nothing responds.
fn silent(verdict: &Verdict) -> bool {
    verdict.class == VerdictClass::DoesNotRespond && verdict.basis == Basis::Evidence
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
