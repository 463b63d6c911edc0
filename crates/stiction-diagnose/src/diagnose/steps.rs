//! All steps from a recording to its diagnosis.

use super::belonging::Belonging;
use super::conclude::{Conclusion, Seen, conclude};
use super::definitions::definitions;
use super::diagnosis::{Diagnosis, Judged, silent};
use super::fit_windows::fit_windows;
use super::grade::FINE_UP_TO;
use super::kpis::{KpiOptions, Kpis};
use super::measured::by_position;
use super::no_response::NoResponse;
use super::oscillations::Oscillations;
use super::relation::Relation;
use super::tested;
use super::verdict::{Basis, Grade, VerdictClass, Votes};
use super::weighing::Weighing;
use crate::error::{Error, Result, non_negative};
use crate::finding::{Abstention, Family, Finding};
use crate::methods::{self, Detector, MethodId, Subject};
use crate::recording::fitness::{self, Class, Fitness, Measure, MeasureId};
use crate::recording::{Doubt, Grid, GridOptions, LoopType, Recording, Segment, Understood};
use crate::spoken::time;
use crate::valve_test::{self, PlanOptions};
use std::sync::atomic::{AtomicBool, Ordering};

/// Inputs to a diagnosis in addition to the recording.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnoseOptions {
    /// The loop type, if it is not in the recording.
    pub loop_type: Option<LoopType>,
    /// How the recording is resampled to a regular grid.
    pub grid: GridOptions,
    /// Inputs to the key figures.
    pub kpis: KpiOptions,
    /// The published methods to run.
    pub detectors: Detectors,
    /// Whether findings keep the [data](Finding::looked_at) that a report draws. They need about twice the memory of
    /// the recording.
    pub evidence: bool,
    /// Whether the verdict gets [the plan of a test](super::Verdict::confirm), which takes a tenth of the time.
    pub plan: bool,
    /// The largest detection limit, percent of span, up to which a cleared valve is [fine](super::Grade::Fine).
    pub fine_up_to: f64,
}

impl Default for DiagnoseOptions {
    fn default() -> Self {
        Self {
            loop_type: None,
            grid: GridOptions::default(),
            kpis: KpiOptions::default(),
            detectors: Detectors::default(),
            evidence: false,
            plan: true,
            fine_up_to: FINE_UP_TO,
        }
    }
}

/// The published methods that a diagnosis runs. Their results decide nothing, so leave out those that you do not need.
///
/// Methods that read the measured valve position ([`Family::Measured`]) always run. Only the methods that run are
/// counted in the votes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Detectors {
    /// All methods of the registry.
    #[default]
    All,
    /// None.
    None,
    /// These.
    Only(Vec<MethodId>),
}

impl Detectors {
    /// The detectors to run, in the order of the registry.
    pub fn selected(&self) -> Vec<Box<dyn Detector>> {
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

/// Largest number of samples of a segment that the methods, the oscillation, the check of the columns and a recorded
/// position use: three days at 1 s. They are for records of thousands of samples, and their cost grows with the length.
pub const READ_BY_METHODS: usize = 1 << 18;

/// The last [`READ_BY_METHODS`] samples of a longer segment.
fn recent(segment: &Segment) -> Option<Segment> {
    let before = segment.len().checked_sub(READ_BY_METHODS).filter(|before| *before > 0)?;
    Some(segment.part(before, READ_BY_METHODS))
}

/// A segment as input to the detectors, with the period of the dominant oscillation if there is one.
pub fn subject(segment: &Segment, loop_type: LoopType) -> Subject<'_> {
    Subject::new(segment, loop_type, Oscillations::of(segment).period(segment))
}

/// Whether a recording is fit for a diagnosis, by the segment that would be judged.
///
/// # Errors
/// As for [`Grid::of`].
pub fn fitness(recording: &Recording, options: &GridOptions) -> Result<Fitness> {
    let recording = &*recording.masked();
    let grid = Grid::of(recording, options)?;
    let period = grid.longest().and_then(|segment| {
        let recent = recent(segment);
        subject(recent.as_ref().unwrap_or(segment), recording.loop_type).period
    });
    Ok(assessed(recording, &grid, period, &|| false).1)
}

/// The judged windows and their fitness.
fn assessed(
    recording: &Recording,
    grid: &Grid,
    period: Option<f64>,
    stops: Stops<'_>,
) -> (Vec<Segment>, Fitness) {
    match grid.longest() {
        Some(segment) => {
            let whole = fitness::assess(recording, grid, segment, period);
            fit_windows(recording, grid, segment, whole, stops)
        }
        None => (vec![], Fitness::of(vec![no_segment(grid)])),
    }
}

/// Diagnoses a recording.
///
/// # Errors
/// If the recording cannot be resampled, for instance because of invalid times, or if an option is out of range. Other
/// faults of the data are results: the diagnosis is "cannot tell", with the reason.
pub fn diagnose(recording: &Recording, options: &DiagnoseOptions) -> Result<Diagnosis> {
    diagnose_with_progress(recording, options, || true)
}

/// Whether the steps that remain are to be skipped, because their result would be thrown away.
pub(super) type Stops<'a> = &'a (dyn Fn() -> bool + Sync);

/// [`diagnose`], watched: `goes_on` is asked before every step, method and window, and ends the diagnosis by `false`.
///
/// # Errors
/// As [`diagnose`]; and [`Error::Cancelled`].
pub fn diagnose_with_progress(
    recording: &Recording,
    options: &DiagnoseOptions,
    goes_on: impl Fn() -> bool + Sync,
) -> Result<Diagnosis> {
    let stopped = AtomicBool::new(false);
    // Once stopped, always stopped: a step may have been skipped.
    let stops = || {
        stopped.fetch_or(!goes_on(), Ordering::Relaxed);
        stopped.load(Ordering::Relaxed)
    };
    let check = || if stops() { Err(Error::Cancelled) } else { Ok(()) };
    check()?;
    if let Some(dead_time) = options.kpis.dead_time {
        non_negative("the dead time", dead_time)?;
    }
    let recording = &*recording.masked();
    let grid = Grid::of(recording, &options.grid)?;
    let loop_type = options.loop_type.unwrap_or(recording.loop_type);
    let segment = grid.longest();
    let recent = segment.and_then(recent);
    let read = recent.as_ref().or(segment);
    let mut oscillations = read.map_or_else(Oscillations::default, Oscillations::of);
    let period = read.and_then(|segment| oscillations.period(segment));

    let (fit, fitness) = assessed(recording, &grid, period, &stops);
    let subject = read.map(|segment| Subject::new(segment, loop_type, period));
    let doubt = Doubt::of(recording.op.range);
    let weigh = |_| Weighing::of_windows(&fit, &stops).map(|weighing| weighing.in_doubt(doubt));
    let (mut findings, weighing) = crate::parallel::join(
        || findings(&options.detectors, subject.as_ref(), &stops),
        || segment.map(weigh),
    );
    check()?;
    let kpis = segment
        .map_or_else(Kpis::default, |segment| Kpis::of(recording, &grid, segment, &options.kpis));
    let doubt = doubt.and(Doubt::of(recording.vp.as_ref().and_then(|vp| vp.range)));
    let position = subject.as_ref().and_then(|subject| by_position(subject, &fitness));
    let position = position.map(|position| position.map(|position| position.in_doubt(doubt)));
    let measured = matches!(position, Some(Ok(_)));
    let belonging = read.map_or_else(Belonging::default, |s| Belonging::of(s, measured));
    let weighed = weighing.as_ref().and_then(|weighing| weighing.as_ref().ok());
    let now = read.zip(weighed).and_then(|(segment, weighed)| weighed.since_change(segment));
    if let Some(now) = now.filter(|now| now.len() > 1) {
        oscillations = Oscillations::of(&now);
    }
    let test = tested::tested(recording, options.grid, weighed);
    let seen = Seen {
        fitness: &fitness,
        votes: Votes::of(&findings),
        segment,
        weighing: weighing.as_ref(),
        belonging: &belonging,
        position: position.as_ref(),
        test: test.as_ref(),
    };
    let Conclusion { verdict, mut stiction, few_slips } = conclude(&seen);
    let by_test = verdict.basis == Basis::ValveTest;
    let by_position = verdict.basis == Basis::ValvePosition;
    let mistaken = belonging.mistake().is_some();
    // A valve that does not stick has no values of stiction, and a test has its own.
    let is_open = verdict.class != VerdictClass::DoesNotStick
        && !(by_test || mistaken)
        && (by_position || fitness.class != Class::Unfit);
    if let Some(subject) = subject.as_ref().filter(|_| is_open) {
        stiction.definitions = definitions(subject, &findings, stiction.s.map(|s| s.value));
    }
    let test_due = options.plan && subject.is_some() && is_open && !by_position;
    // Beside a test the windows count only if they would give the verdict without it.
    let operation = || conclude(&Seen { test: None, ..seen }).verdict.probability;
    let pool_counts = !by_test || weighed.is_some_and(|of| operation() == Some(of.probability));
    if !options.evidence {
        findings.iter_mut().for_each(|finding| finding.looked_at = None);
    }
    let windows = weighed.map_or(vec![], |weighing| weighing.windows.clone());
    let mut notes = recording.notes.clone();
    let by_windows = matches!(verdict.basis, Basis::Evidence | Basis::OpAlone);
    let gave = weighed.filter(|_| by_windows);
    let of_operation = segment.filter(|_| !by_test);
    notes.extend(of_operation.and_then(|segment| cut(&grid, segment, gave)));
    notes.extend(recent.as_ref().map(read_in_part));
    notes.extend(test.as_ref().map(|test| tested::note(test, verdict.basis)));
    let relation = belonging.relation.as_ref();
    notes.extend(relation.filter(|_| by_position && !mistaken).and_then(note_on_mistake));
    let mut diagnosis = Diagnosis {
        name: recording.name.clone(),
        loop_type,
        start: recording.start,
        plant_time: recording.plant_time.clone(),
        understood: Understood::of(recording, Some(&grid)),
        mode: recording.mode.clone(),
        op_range: recording.op.range,
        pv_unit: recording.pv.as_ref().and_then(|pv| pv.unit.clone()),
        judged: Judged::of(&grid),
        masked: recording.masked_values(),
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
        test,
        notes,
        recent,
        grid,
    };
    if !pool_counts && let Some(weighing) = &mut diagnosis.evidence {
        weighing.pool = None;
    }
    diagnosis.verdict.grade = Grade::of(&diagnosis, options.fine_up_to);
    if test_due {
        match valve_test::plan(&diagnosis, &PlanOptions::default()) {
            Ok(plan) => diagnosis.verdict.confirm = Some(plan),
            Err(Abstention(why)) => diagnosis.verdict.no_test = Some(why),
        }
    }
    Ok(diagnosis)
}

/// The findings of the methods; without a subject, all abstain.
fn findings(asked: &Detectors, subject: Option<&Subject<'_>>, stops: Stops<'_>) -> Vec<Finding> {
    let said = |detector: &dyn Detector| match subject {
        Some(subject) => methods::judge(detector, subject),
        None => {
            let why = "no segment in automatic has enough good samples in a row".to_owned();
            let finding = Finding::abstains(detector.method(), Abstention(why));
            Finding { parameters: detector.parameters(), ..finding }
        }
    };
    let asked = asked.selected();
    asked.iter().take_while(|_| !stops()).map(|detector| said(&**detector)).collect()
}

/// The note on the judged segments, if there are several: the segments of the windows that gave the verdict, or else
/// the longest.
fn cut(grid: &Grid, longest: &Segment, windows: Option<&Weighing>) -> Option<String> {
    let count = grid.segments.len();
    let share = |duration: f64| 100.0 * duration / (grid.duration + grid.sample_time);
    if count < 2 {
        return None;
    }
    let Some(weighing) = windows else {
        return Some(format!(
            "the recording has {count} segments; only the longest is judged, {:.0} % of the duration",
            share(longest.duration())
        ));
    };
    let counts = |segment: &&Segment| {
        let until = segment.from + segment.duration();
        weighing.present().any(|(window, _)| (segment.from..until).contains(&window.from))
    };
    Some(format!(
        "the recording has {count} segments; the verdict uses {} of them, {:.0} % of the duration, and the methods \
         use the longest",
        grid.segments.iter().filter(counts).count(),
        share(weighing.covered())
    ))
}

/// The note on a segment of which some steps read the last part.
fn read_in_part(recent: &Segment) -> String {
    format!(
        "the methods and the checks of oscillation, columns and valve position use only the last {} of the segment",
        time(recent.duration())
    )
}

/// The note on a mistake in the columns that does not affect a verdict from the measured position.
fn note_on_mistake(relation: &Relation) -> Option<String> {
    let (mismatch, because) = (relation.mismatch?.name(), &relation.because);
    Some(format!(
        "{mismatch}: {because}; the verdict follows the measured valve position, which needs no PV"
    ))
}

/// The reason without a segment to judge.
fn no_segment(grid: &Grid) -> Measure {
    Measure {
        id: MeasureId::AutomaticSegment,
        value: Some(100.0 * grid.closed_share),
        unit: "%",
        caveat_at: None,
        unfit_at: Some(0.0),
        class: Class::Unfit,
        reason: if grid.closed_share == 0.0 {
            "the loop was never in automatic, so its controller did not move the valve".to_owned()
        } else {
            "no segment in automatic has enough good samples in a row".to_owned()
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fusion::Pool;
    use crate::test_signals::sine;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn a_diagnosis_stops_on_request() {
        let op: Vec<f64> = sine(24_000, 40.0).iter().map(|s| 50.0 + s).collect();
        let recording = Recording::regular("A", 1.0, &op, Some(&op), None).unwrap();
        let options = DiagnoseOptions::default();
        let until = |most: usize| {
            let asked = AtomicUsize::new(0);
            let goes_on = || asked.fetch_add(1, Ordering::Relaxed) < most;
            let said = diagnose_with_progress(&recording, &options, goes_on);
            (said, asked.into_inner())
        };
        let (whole, all) = until(usize::MAX);
        // As text, because a number that is not known equals nothing.
        let text = |of: Diagnosis| format!("{of:?}");
        assert_eq!(text(whole.unwrap()), text(diagnose(&recording, &options).unwrap()));
        // Six windows, twice, and every method.
        assert!(all > 12 + methods::all().len(), "{all}");
        for most in (0..all).step_by(7) {
            assert!(matches!(until(most).0, Err(Error::Cancelled)), "{most} of {all}");
        }
    }

    #[test]
    fn of_a_very_long_segment_the_methods_read_the_last_part() {
        let n = READ_BY_METHODS + 20_000;
        // It oscillates only in the first 20,000 samples.
        let noise = crate::test_signals::noise(n, 3);
        let swing = |k: usize| if k < 20_000 { 5.0 } else { 0.0 };
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / 40.0).sin();
        let op: Vec<f64> = (0..n).map(|k| 50.0 + swing(k) * wave(k) + noise[k]).collect();
        let of = |op: &[f64]| {
            let recording = Recording::regular("A", 1.0, op, None, None).unwrap();
            let only = Detectors::Only(vec![methods::MethodId::ALL[0]]);
            let options = DiagnoseOptions { detectors: only, ..DiagnoseOptions::default() };
            diagnose(&recording, &options).unwrap()
        };
        let (whole, last) = (of(&op), of(&op[20_000..]));
        assert_eq!(whole.subject().unwrap().segment.from, 20_000.0);
        assert_eq!(whole.segment().unwrap().len(), n);
        assert!(whole.recent.is_some() && last.recent.is_none());
        assert!(!whole.oscillation().unwrap().1.found);
        assert_eq!(whole.findings, last.findings);
        let note = "the methods and the checks of oscillation, columns and valve position use only the last 3 d";
        assert!(whole.notes.iter().any(|said| said.starts_with(note)), "{:?}", whole.notes);
        assert!(whole.windows.iter().any(|window| window.from == 0.0));
    }

    #[test]
    fn a_gap_costs_only_what_is_missing() {
        let n = 9_000;
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / 40.0).sin();
        let noise = crate::test_signals::noise(n, 3);
        let of = |from: usize, to: usize| -> Recording {
            let mut op: Vec<f64> = (0..n).map(|k| 50.0 + 5.0 * wave(k) + 0.2 * noise[k]).collect();
            let pv: Vec<f64> =
                (0..n).map(|k| 30.0 + wave(k + 30) + 0.1 * noise[n - 1 - k]).collect();
            op[from..to].fill(f64::NAN);
            Recording::regular("A", 1.0, &op, Some(&pv), None).unwrap()
        };
        let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
        let from_of = |diagnosis: &Diagnosis| -> Vec<f64> {
            diagnosis.windows.iter().map(|window| window.from).collect()
        };
        // The shorter segment counts beside the longest.
        let diagnosis = diagnose(&of(2_000, 2_060), &options).unwrap();
        assert_eq!(from_of(&diagnosis), [0.0, 2_060.0, 3_420.0, 4_780.0, 6_140.0, 7_500.0]);
        assert_eq!(diagnosis.judged_s(), Some(8_940.0));
        assert_eq!(diagnosis.judged.as_ref().map(|judged| judged.from_s), Some(2_060.0));
        let note = "the recording has 2 segments; the verdict uses 2 of them, 99 % of the duration";
        assert!(diagnosis.notes.iter().any(|said| said.starts_with(note)), "{:?}", diagnosis.notes);
        // As two recordings, in any order, the segments give the same.
        let whole = of(2_000, 2_060);
        let part = |from, to| {
            diagnose(&whole.part(from, to, f64::INFINITY).unwrap(), &options)
                .unwrap()
                .evidence
                .unwrap()
                .pool
                .unwrap()
        };
        let together = Pool::merged(&[part(2_060.0, f64::INFINITY), part(0.0, 2_000.0)]);
        assert_eq!(together, diagnosis.evidence.as_ref().unwrap().pool);
        // A stretch shorter than any training loop is left out.
        let short = diagnose(&of(100, 160), &options).unwrap();
        assert!(from_of(&short).iter().all(|from| *from >= 160.0), "{:?}", from_of(&short));
        let note = "the recording has 2 segments; the verdict uses 1 of them";
        assert!(short.notes.iter().any(|said| said.starts_with(note)), "{:?}", short.notes);
    }
}
