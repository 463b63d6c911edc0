//! The diagnosis of one loop.

use super::by_evidence::Ruling;
use super::few_slips::FewSlips;
use super::kpis::Kpis;
use super::no_response::{NoResponse, Silence};
use super::observation::Observation;
use super::oscillations::Oscillations;
#[cfg(feature = "serde")]
use super::oscillations::{Dominant, dominant};
#[cfg(feature = "serde")]
use super::relation::Mistake;
use super::relation::{Mismatch, Relation};
use super::verdict::{Basis, Grade, Stiction, Verdict, VerdictClass, Votes};
use super::weighing::Weighing;
use super::window::Window;
use crate::bands::Bands;
#[cfg(feature = "figure")]
use crate::drawing::Context;
use crate::finding::Finding;
use crate::fusion::Pool;
use crate::identify::slips::Motion;
use crate::methods::Subject;
use crate::oscillation::Oscillation;
use crate::recording::fitness::Fitness;
use crate::recording::{Grid, LoopType, Masked, Modes, PlantTime, Range, Segment, Understood};
use crate::valve::{Start, Valve};
use crate::valve_test::TestReading;

/// The diagnosis of one loop.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Diagnosis {
    /// Tag of the loop.
    #[cfg_attr(feature = "serde", serde(rename = "loop"))]
    pub name: String,
    /// The controlled quantity.
    #[cfg_attr(feature = "serde", serde(rename = "type"))]
    pub loop_type: LoopType,
    /// The judged segment, which is the longest segment; `None` without a segment.
    pub judged: Option<Judged>,
    /// Time zero of the recording's clock as seconds since 1970-01-01 UTC, if it is known.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub start: Option<f64>,
    /// The clock of the plant, in which all times are shown.
    pub plant_time: PlantTime,
    /// The recording on a regular grid, with its repairs.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "repairs", serialize_with = "repairs"),
        schemars(with = "Vec<crate::recording::GridRepair>", description = "Repairs of the data.")
    )]
    pub grid: Grid,
    /// How the recording was interpreted.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub understood: Understood,
    /// Values that are no measurements and count as missing, in the whole recording.
    pub masked: Vec<Masked>,
    /// The controller's mode over time, where it is recorded.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub mode: Option<Modes>,
    /// The values of the OP at 0 % and 100 %, with all plausible spans; null if the OP is in percent.
    pub op_range: Option<Range>,
    /// Unit of the PV, where the file names one.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub pv_unit: Option<String>,
    /// Fitness of the data.
    pub fitness: Fitness,
    /// The oscillations, with times on the recording's clock.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "oscillation", serialize_with = "dominant"),
        schemars(
            with = "Option<Dominant<'static>>",
            description = "The dominant oscillation of the loop, with times on the recording's clock; null without \
                           a segment to judge."
        )
    )]
    pub oscillations: Oscillations,
    /// The result of each method that was run.
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
            description = "The likely mistake in the columns; null if OP and PV seem to belong together."
        )
    )]
    pub relation: Option<Relation>,
    /// The behaviour of a PV that does not respond; `None` if the PV seems to respond.
    pub no_response: Option<NoResponse>,
    /// The conclusion.
    pub verdict: Verdict,
    /// Size of the stiction.
    pub stiction: Stiction,
    /// Observed and needed slips of a valve that looks stuck but slips too rarely to decide; `None` for other valves.
    pub few_slips: Option<FewSlips>,
    /// The evidence of all windows together; `None` where none could be weighed.
    pub evidence: Option<Weighing>,
    /// The results of the windows of the judged segment, in order of time.
    pub windows: Vec<Window>,
    /// The valve test in the recording; `None` without one that can be read.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub test: Option<TestReading>,
    /// Notes for the user on the file or the diagnosis.
    pub notes: Vec<String>,
    /// The part of a very long segment that the published methods and the oscillation read.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub recent: Option<Segment>,
}

/// The part of a recording that was judged.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Judged {
    /// Index of the segment in the grid.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub segment: usize,
    /// Time of the first sample of the segment, s on the recording's clock.
    pub from_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of missing samples that were bridged.
    pub bridged: usize,
    /// Number of segments of the recording.
    pub segments: usize,
    /// The recorded signals.
    pub signals: Vec<&'static str>,
}

impl Judged {
    /// The longest segment of a grid; `None` without a segment.
    pub(super) fn of(grid: &Grid) -> Option<Self> {
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

#[cfg(feature = "serde")]
fn repairs<S: serde::Serializer>(grid: &Grid, to: S) -> std::result::Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&grid.repairs, to)
}

impl Diagnosis {
    /// Number of values that are no measurements.
    pub fn masked_count(&self) -> usize {
        self.masked.iter().map(|masked| masked.count).sum()
    }

    /// These values in words, such as `1 value of the PV (-9999)`; `None` if no value is masked.
    pub fn masked_words(&self) -> Option<String> {
        Masked::words(&self.masked)
    }

    /// The valve test on which the verdict rests; `None` if it does not rest on a test.
    pub fn deciding_test(&self) -> Option<&TestReading> {
        self.test.as_ref().filter(|_| self.verdict.basis == Basis::ValveTest)
    }

    /// The segment that was judged.
    pub fn segment(&self) -> Option<&Segment> {
        self.grid.segments.get(self.judged.as_ref()?.segment)
    }

    /// Duration of the data that gave the verdict, s. It is the duration of all weighed windows, with overlaps counted
    /// once, or else of the longest segment. `None` if no segment was judged.
    pub fn judged_s(&self) -> Option<f64> {
        let longest = self.segment()?.duration();
        let weighed = match (self.verdict.basis, &self.evidence) {
            (Basis::Evidence | Basis::OpAlone, Some(weighing)) => weighing.covered(),
            _ => 0.0,
        };
        Some(longest.max(weighed))
    }

    /// The dominant oscillation and its signal. The error has precedence if it oscillates, then the OP if it
    /// oscillates, then the error, if recorded.
    pub fn oscillation(&self) -> Option<(&'static str, &Oscillation)> {
        self.oscillations.dominant()
    }

    /// Position of the loop in a ranked list, the worst lowest. Loops are ordered by class, then by the probability
    /// that the valve sticks or, without one, by the share of the votes.
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

    /// The mistake in the columns that ended the judgement, if there was one.
    pub fn mistaken(&self) -> Option<Mismatch> {
        let measured = self.verdict.basis == Basis::ValvePosition;
        self.relation.as_ref()?.ends(measured)
    }

    /// Why the evidence in OP and PV decided nothing; `None` if it decided, or something else did.
    pub fn undecided_by(&self) -> Option<Ruling> {
        let verdict = &self.verdict;
        let open = verdict.class == VerdictClass::CannotTell && verdict.basis == Basis::Evidence;
        self.evidence.as_ref().filter(|_| open).map(Ruling::of)
    }

    /// The behaviour of the PV, if OP and PV give the verdict that it does not respond.
    pub fn silence(&self) -> Option<Silence> {
        silent(&self.verdict)
            .then(|| self.no_response.as_ref().map_or(Silence::Unmoved, |told| told.silence))
    }

    /// Samples of the judged segment at which a valve that probably sticks begins to move, according to the model
    /// that best predicts its PV. `None` for a valve without suspicion, with a recorded position, and without a model.
    pub fn slips(&self) -> Option<Vec<usize>> {
        let (segment, weighing) = (self.segment()?, self.evidence.as_ref()?);
        let is_suspected = matches!(self.verdict.grade, Grade::Sticks | Grade::ProbablySticks);
        if !is_suspected || segment.vp.is_some() {
            return None;
        }
        let evidence = weighing.typical();
        let best = evidence.dense.as_ref().or(evidence.model.as_ref())?.best();
        let s = self.stiction.s.map_or(best.s_over_span * evidence.op_span, |s| s.value);
        let mut valve = best.model.build(Bands::from_s_j(s, best.j_over_s * s).ok()?).ok()?;
        valve.restart(Start::at_rest(*segment.op.first()?));
        let mut vp = vec![0.0; segment.len()];
        valve.run(&segment.op, &mut vp).ok()?;
        Some(Motion::of(&vp).slips)
    }

    /// The observation of the valve in the middle of the judged segment, with `origin` the time of zero of its
    /// clock; `None` if no segment was judged.
    pub fn observation(&self, origin: f64) -> Option<Observation> {
        let segment = self.segment()?;
        Some(Observation {
            time: origin + segment.from + segment.duration() / 2.0,
            class: self.verdict.class,
            grade: Some(self.verdict.grade),
            probability: self.verdict.probability,
            s: self.stiction.s,
            j: self.stiction.j,
            weight: 1.0,
            windows: self.evidence.as_ref().map_or(1.0, Weighing::number),
            pool: self.pool().cloned(),
        })
    }

    /// What the windows say together, if it gave the probability, or would have without a test.
    pub fn pool(&self) -> Option<&Pool> {
        let weighing = self.evidence.as_ref()?;
        let by_test = self.verdict.basis == Basis::ValveTest;
        let gave = self.verdict.probability == Some(weighing.probability);
        weighing.pool.as_ref().filter(|_| by_test || gave)
    }

    /// Data of the detectors for plots of their evidence.
    pub fn subject(&self) -> Option<Subject<'_>> {
        let segment = self.recent.as_ref().or(self.segment())?;
        Some(Subject::new(segment, self.loop_type, self.oscillations.period(segment)))
    }
}

#[cfg(feature = "figure")]
impl<'a> Context<'a> {
    /// Context of a diagnosis for its figures.
    pub fn of(diagnosis: &'a Diagnosis) -> Self {
        Self {
            start: diagnosis.start,
            plant_time: Some(&diagnosis.plant_time),
            pv_unit: diagnosis.pv_unit.as_deref(),
            modes: diagnosis.mode.as_ref(),
            period_s: diagnosis.oscillation().and_then(|(_, found)| found.period_s),
        }
    }
}

/// Whether OP and PV give the verdict that the valve does not respond.
pub(super) fn silent(verdict: &Verdict) -> bool {
    verdict.class == VerdictClass::DoesNotRespond && verdict.basis == Basis::Evidence
}
