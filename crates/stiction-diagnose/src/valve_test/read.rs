//! Judges a valve from the recording of a test.

use super::curve::{Curve, unsettled};
use super::cut::cut;
use super::explain::Seen;
use super::frozen::frozen;
use super::latest::latest;
use super::plan::{TestPlan, rises};
use super::plan_comparison::{self, PlanComparison, same_loop};
use super::position::{PositionReading, position};
use super::probability::{joined, log_odds, of_test};
use super::weigh::{Manual, SMALL, Weighed, weigh};
use crate::diagnose::{
    Detectors, DiagnoseOptions, Diagnosis, Grade, PROBABLY_FINE_UP_TO, PROBABLY_FROM, VerdictClass,
    diagnose,
};
use crate::estimate::Estimate;
use crate::finding::Abstention;
use crate::recording::{ByHand, Grid, GridOptions, KnownBy, Recording, Segment};
use crate::series::{max, median, min, noise_std, quantile, span, std};
use crate::spoken::{counted, percent, rough, time, times};
use stiction_model::named;

/// Inputs to the reading of a test in addition to the recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// The manual settings, if noted on a sheet. By default they are found in the recording.
    pub by_hand: Option<ByHand>,
    /// The plan of the test.
    pub plan: Option<TestPlan>,
    /// Whether the PV rises when the OP rises. By default it follows from the controller action, or else from the test.
    pub rises: Option<bool>,
    /// How the recording is resampled to a regular grid.
    pub grid: GridOptions,
}

/// A turn of the OP in a test, and the response of the PV.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Step {
    /// Time of the OP setting, s on the recording's clock.
    pub at_s: f64,
    /// The OP after the turn, percent.
    pub op: f64,
    /// The change of the OP, percent. `None` for the first turn of a time in manual, because the stem position before
    /// the turn is unknown, and for a turn without a change of the OP.
    pub travel: Option<f64>,
    /// The PV change, in PV units, until the next turn. If the process needs longer to respond, the PV change until the
    /// process has responded.
    pub answer: Option<f64>,
    /// Standard deviation of the PV change, in PV units.
    pub error: Option<f64>,
    /// Whether the PV moved in the expected direction by more than 2.5 standard deviations.
    pub answered: bool,
}

/// The result of a valve test.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct TestReading {
    /// The conclusion from the test and the operation before the test: `sticks`, `does not stick`, `does not respond`
    /// or `cannot tell`.
    pub class: VerdictClass,
    /// Probability that the valve sticks, from the test and the operation before the test.
    pub probability: f64,
    /// Probability that the valve sticks, from the test alone.
    pub by_test: f64,
    /// Probability that the valve sticks, from the operation before the test; `None` if the operation gives no
    /// probability.
    pub by_operation: Option<f64>,
    /// The log-odds of the test before calibration.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub log_odds: f64,
    /// Probability of a dead band downstream of the valve, in the process, a linkage or the transmitter.
    pub dead_band_elsewhere: f64,
    /// Stick band plus dead band, percent of span, with its 90 % interval, if the valve sticks.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, with its 90 % interval, if the valve sticks.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// Upper limit of S with 95 % confidence, percent of span; `None` if the test gives no limit.
    #[cfg_attr(feature = "serde", serde(rename = "S_below"))]
    pub s_below: Option<f64>,
    /// Sum of dead time and lags between OP and PV, s; `None` if no turn had a response, or the test was shorter than
    /// this sum.
    pub response_s: Option<f64>,
    /// The source of the manual settings: `sheet`, `mode` or `output`.
    pub known_by: KnownBy,
    /// Start of the test, s on the recording's clock.
    pub from_s: f64,
    /// End of the test, s on the recording's clock.
    pub to_s: f64,
    /// Number of times that the controller took over during the test.
    pub stops: usize,
    /// Whether the responses are read from the recorded valve position instead of the PV.
    pub by_position: bool,
    /// Results from the valve position; `None` without a recorded valve position.
    pub position: Option<PositionReading>,
    /// The turns of the test, in order.
    pub steps: Vec<Step>,
    /// Number of turns. The OP at which a time in manual begins is none if it was the same before.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub turned: usize,
    /// The reasons, in sentences.
    pub reasons: Vec<String>,
    /// How to repeat an inconclusive test.
    pub advice: Option<String>,
    /// The comparison with the plan; `None` if no plan was given.
    pub plan: Option<PlanComparison>,
    /// The recording of the test, with a tenth of its duration before and after it.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub recorded: Vec<Segment>,
}

named! {
    /// How to repeat an inconclusive test.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Repetition {
        /// The OP never reversed.
        ThereAndBack = "The OP went in one direction only, which shows no dead band. Repeat the test, and then go back in the \
                        same steps.",
        /// The PV was still moving when the holds ended.
        LongerHolds = "The holds were too short: the PV was still moving at the end of the holds. Repeat the test, and hold each step \
                       until the PV has settled.",
        /// The dead band may be downstream of the valve.
        WithPosition = "Watch the stem during the test, or record its position. If the stem follows the OP, check the \
                        transmitter and the linkage.",
        /// Not even very large turns were answered.
        NoAnswer = "Larger turns would not help. Check whether the stem moves when the OP is turned. If the stem rests, inspect the valve, \
                    the positioner and their air supply. If the stem moves, check the transmitter and the line.",
        /// Hardly a turn was answered.
        LargerTurns = "Too few turns were answered. Make larger turns, hold each longer, and record OP and PV without \
                       compression. If the PV still does not answer, inspect the valve.",
        /// No turn was too small to be answered.
        SmallerTurns = "All turns were answered. Repeat the test with smaller turns until the PV no longer answers.",
        /// Disturbances were as large as the answers.
        CalmerTime = "Repeat the test at a calmer time, because disturbances moved the PV about as far as the turns did. Make \
                      more turns of the answered sizes, and hold them longer.",
    }
}

impl TestReading {
    /// The class in words. A valve that may stick below its limit does not stick by more. Without a decision it is the
    /// grade of a clear probability. A dead band that seems to be downstream of the valve has its own grade.
    pub fn word(&self) -> &'static str {
        match self.probability {
            p if self.class == VerdictClass::DoesNotStick && p > PROBABLY_FINE_UP_TO => {
                "does not stick by more than the limit"
            }
            _ if self.class != VerdictClass::CannotTell => self.class.name(),
            _ if self.is_elsewhere() => "dead band elsewhere",
            p if p >= PROBABLY_FROM => Grade::ProbablySticks.name(),
            p if p <= PROBABLY_FINE_UP_TO => Grade::ProbablyFine.name(),
            _ => self.class.name(),
        }
    }

    /// Whether a dead band downstream of the valve explains the responses better than a dead band in the valve.
    pub fn is_elsewhere(&self) -> bool {
        self.class == VerdictClass::CannotTell && self.dead_band_elsewhere > 0.5
    }

    /// The signal with the answers: `PV` or `stem`.
    pub fn who(&self) -> &'static str {
        who(self.by_position)
    }

    /// The unit of the answers, given the unit of the PV. A position is in percent.
    pub fn unit<'a>(&self, pv_unit: Option<&'a str>) -> &'a str {
        if self.by_position { "%" } else { pv_unit.unwrap_or("its units") }
    }
}

/// Lowest probability for `sticks`, as in operation, and for `does not respond`.
const STICKS: f64 = 0.9;
const DEAD: f64 = 0.8;
/// `does not stick` requires a lower probability. The limit of S is the promise, and S below it may not be 0.
const CLEARS: f64 = 0.5;
/// `does not stick` requires a lower probability that the PV answers no turn.
const NO_ANSWER: f64 = 0.05;
/// Required agreement of the PV with a valve that follows: correlation, and length of the expected answers in standard deviations.
const FITS_HEALTHY: f64 = 0.5;
const STRONG: f64 = 5.0;
/// This limit for `does not stick`. Of a stem that never moves, a process can be found with expected responses as long
/// as 7.
const STRONGER: f64 = 8.0;
/// Clear answers required for `sticks`.
const CLEAR: usize = 2;
/// The PV does not respond if it moves less than this share of its movement in operation with the same OP range. The
/// second value is for turns that are as large as this, percent, which is larger than nearly every S.
const SILENT: (f64, f64) = (0.06, 0.3);
pub(super) const LARGE: f64 = 24.0;
/// `does not respond` requires a PV that moves in operation by at least this multiple of its noise.
const MOVES: f64 = 3.0;
/// A stem that moves less than this per percent of OP does not respond.
const STILL: f64 = 0.1;
/// `does not stick` requires a limit of S below this share of the OP range in operation, within bounds in percent.
const LIMIT: f64 = 0.25;
const LIMITS: (f64, f64) = (2.0, 5.0);
/// Larger limits are not reported, because they exceed the turns of a test, percent.
const TOLD_UP_TO: f64 = 25.0;
/// Largest number of settings that are read. The time grows with their square, and a test of an hour has fewer.
const MOST_TURNS: usize = 120;
/// Smallest number of samples of operation that are used.
pub(super) const FEWEST: usize = 100;
/// Smallest standard deviation of the errors, as a share of the range of the signal.
const EXACT: f64 = 1e-4;
/// Standard deviations of the smallest answer.
const SEEN: f64 = 2.5;

/// Results from the operation before the test. They are for the valve position instead of the PV if the test is read
/// from it.
struct Operation {
    rises: Option<bool>,
    pv_std: f64,
    op_range: f64,
    noise: f64,
    probability: Option<f64>,
    /// Whether the PV does not respond in operation.
    silent: bool,
}

/// Reads the test in a recording. If the valve seems to have changed between two times in manual, only the later ones count.
///
/// # Errors
/// If the recording contains no test, or too little of one. The message names the fault and the remedy.
pub fn read(recording: &Recording, options: &ReadOptions) -> Result<TestReading, Abstention> {
    let recording = &*recording.masked();
    let by_hand = match &options.by_hand {
        Some(by_hand) => by_hand.clone(),
        None => ByHand::of(recording).ok_or_else(|| Abstention(NO_TEST.to_owned()))?,
    };
    check(&by_hand)?;
    let whole = read_as_one(recording, by_hand.clone(), true, options)?;
    let later = latest(&whole, &by_hand, |later| read_as_one(recording, later, false, options));
    Ok(later.unwrap_or(whole))
}

/// Reads all settings as settings of one valve. `same_valve` states whether the valve is the same as in the earlier
/// operation.
fn read_as_one(
    recording: &Recording,
    by_hand: ByHand,
    same_valve: bool,
    options: &ReadOptions,
) -> Result<TestReading, Abstention> {
    let (all_turns, part) = (by_hand.turns(), by_hand.most_varied(MOST_TURNS));
    let is_part = part.is_some();
    let by_hand = part.unwrap_or(by_hand);
    if recording.pv.is_none() && recording.vp.is_none() {
        return Err(Abstention(
            "without a PV or a valve position the test has no answers; give a recording with one of them".to_owned(),
        ));
    }
    if let Some(why) = options.plan.as_ref().and_then(TestPlan::fault) {
        return Err(Abstention(format!(
            "the plan cannot be followed: {why}; give a plan from stiction test plan"
        )));
    }
    if let Some(plan) = &options.plan
        && !same_loop(&plan.name, &recording.name)
    {
        return Err(Abstention(format!(
            "the plan is for loop {}, but the recording is of {}; give the plan of this loop",
            plan.name, recording.name
        )));
    }
    // The OP is set by hand in a test, so the mode must not cut the recording.
    let whole = Recording { mode: None, ..recording.clone() };
    let grid = Grid::of(&whole, &options.grid).map_err(|error| Abstention(error.to_string()))?;
    let (from_s, to_s) = by_hand.span_s();
    let of_position = spells(&by_hand, &grid, |segment| segment.vp.as_deref());
    // A constant position with an answering PV means a failed position transmitter.
    let by_position = recording.pv.is_none() || moves(&of_position);
    let at_rest = recording.pv.is_some() && !of_position.is_empty() && !moves(&of_position);
    let of_pv = spells(&by_hand, &grid, |segment| segment.pv.as_deref());
    let spells = if by_position { of_position } else { of_pv.clone() };
    let mut operation = Operation::before(recording, from_s, options, by_position)?;
    operation.probability = operation.probability.filter(|_| same_valve);
    operation.silent &= same_valve;
    if spells.is_empty() {
        return Err(Abstention(
            "the test is outside the recording or in a gap of the recording; give a recording that contains the test"
                .to_owned(),
        ));
    }
    let in_manual: Vec<&Manual> = spells.iter().map(|(_, manual)| manual).collect();
    let curve = Curve::of(&in_manual);
    // A position is straight.
    let straighten = curve.as_ref().filter(|_| !by_position);
    let straight = |manual: &Manual| match straighten {
        Some(curve) => curve.straightened(manual),
        None => manual.clone(),
    };
    let manual: Vec<Manual> = spells.iter().map(|(_, manual)| straight(manual)).collect();
    let values: Vec<f64> = manual.iter().flat_map(|spell| spell.pv.iter().copied()).collect();
    if !moves(&spells) {
        return Err(Abstention(format!(
            "the {} has the same value throughout the test, so it is at the end of its range, frozen, or not \
             archived; repeat the test with a signal that moves",
            who(by_position)
        )));
    }
    if let Some(frozen) = frozen(&manual) {
        return Err(Abstention(format!(
            "the {} is exactly the same for {} within the test in spite of its noise, so it was frozen or not \
             archived; repeat the test with a signal that is recorded throughout",
            who(by_position),
            time(frozen as f64 * grid.sample_time)
        )));
    }
    let dead = longest_dead(&manual);
    let own = by_position || curve.is_some();
    if curve.is_some() {
        // A PV with a characteristic answers.
        operation.pv_std = 0.0;
    }
    let noise = if own { noise_std(&values) } else { operation.noise };
    let floor = (0.4 * noise).max(drawn(&manual, by_position)).max(EXACT * span(&values));
    let known = options.rises.or(options.plan.as_ref().and_then(|plan| plan.rises));
    // The position rises with the OP.
    let rises = if own { Some(true) } else { known.or(operation.rises) };
    let signs: &[f64] = match rises {
        Some(true) => &[1.0],
        Some(false) => &[-1.0],
        None => &[1.0, -1.0],
    };
    let weighed = signs
        .iter()
        .filter_map(|sign| weigh(&manual, *sign, dead, floor, !by_position, curve.as_ref()))
        .max_by(|a, b| a.log.total_cmp(&b.log));
    let weighed = weighed.ok_or_else(|| Abstention(TOO_FEW.to_owned()))?;
    let mut reading = TestReading {
        known_by: by_hand.known_by,
        from_s,
        to_s,
        stops: spells.len() - 1,
        position: by_position.then(|| position(&manual, grid.sample_time)).flatten(),
        steps: steps(&spells, &weighed, straighten),
        turned: manual.iter().map(turned).sum(),
        recorded: around(&grid, from_s, to_s),
        ..conclude(&weighed, &operation, &manual, by_position, at_rest)
    };
    let step_s = grid.sample_time * weighed.response.1 as f64;
    let process = weighed.response.0;
    let lags = if process.tau.is_finite() { process.tau } else { 0.0 } + process.tau2;
    let responds = reading.class != VerdictClass::DoesNotRespond;
    // A test shows no response that lasts longer.
    reading.response_s = (responds && reading.steps.iter().any(|step| step.answered))
        .then_some((process.dead as f64 + lags) * step_s)
        .filter(|response| *response < to_s - from_s);
    if !responds {
        reading.steps.iter_mut().for_each(|step| step.answered = false);
    }
    reading.reasons = reasons(&reading, &weighed, at_rest);
    reading.reasons.extend(curve.as_ref().map(|curve| {
        format!(
            "the rising and the falling branch of the settled {} lie {} % of OP apart, which is S - J if each step exceeds S{}",
            who(by_position),
            rough(curve.apart),
            if by_position { "" } else { "; the curve of the PV over the OP was straightened" }
        )
    }));
    if is_part {
        reading.reasons.push(format!(
            "the OP was set by hand {all_turns} times; the result is from the {MOST_TURNS} consecutive settings whose \
             sizes differ most"
        ));
    }
    reading.reasons.extend(cut(&spells));
    let used: usize = spells.iter().map(|(times, _)| times.len()).sum();
    if used < by_hand.turns() {
        reading.reasons.push(format!(
            "the result leaves out {} of the OP, each in a gap of the recording or alone in a period in manual",
            counted(by_hand.turns() - used, "setting")
        ));
    }
    let hasty = weighed.response.0.tau.is_finite() && unsettled(&in_manual);
    reading.advice = advice(&reading, hasty).map(|how| how.name().to_owned());
    let plan = options.plan.as_ref();
    // The limits of a plan apply to the PV.
    let compared = plan.filter(|_| !of_pv.is_empty());
    reading.plan = compared
        .map(|plan| plan_comparison::compared(plan, &of_pv, &reading.steps, grid.sample_time));
    if plan.is_some() && compared.is_none() {
        reading.reasons.push(
            "the test cannot be compared with the plan, because the recording has no PV".to_owned(),
        );
    }
    Ok(reading)
}

/// Checks the manual settings: times ascend, and an OP is a percentage.
fn check(by_hand: &ByHand) -> Result<(), Abstention> {
    let refuse = |why: String| Err(Abstention(why));
    for set in &by_hand.sets {
        if !set.at_s.is_finite() {
            return refuse(format!(
                "the OP was set at {} s, which is not a time; correct the sheet",
                set.at_s
            ));
        }
        if let Some(op) = set.op
            && !OP.contains(&op)
        {
            return refuse(format!(
                "the OP was set to {op} %, which is not an OP in percent of span; correct the sheet"
            ));
        }
    }
    match by_hand.sets.windows(2).find(|two| two[1].at_s < two[0].at_s) {
        Some(two) => refuse(format!(
            "the OP setting at {} s follows the setting at {} s; sort the settings by time",
            two[1].at_s, two[0].at_s
        )),
        None => Ok(()),
    }
}

/// The segments of a grid, from a tenth of the test's duration before the test to a tenth after it.
pub(super) fn around(grid: &Grid, from_s: f64, to_s: f64) -> Vec<Segment> {
    let margin = 0.1 * (to_s - from_s);
    let part = |segment: &Segment| {
        let at = |t: f64| ((t - segment.from) / segment.sample_time).ceil().max(0.0) as usize;
        let from = at(from_s - margin);
        segment.part(from, at(to_s + margin).saturating_sub(from))
    };
    grid.segments.iter().map(part).filter(|segment| !segment.is_empty()).collect()
}

/// Valid range of an OP, percent.
const OP: std::ops::RangeInclusive<f64> = -10.0..=110.0;

const NO_TEST: &str = "the recording has no test. With a mode, the OP must be set twice in manual; without a mode, the \
                       OP must alternate between held levels, or go up and down in equal steps. Give the completed sheet, or a recording with the mode";
const TOO_FEW: &str = "the test is too short, because it needs two turns in one time in manual and twelve samples \
                       of a moving PV; make more turns, or record more often";

impl Operation {
    fn before(
        recording: &Recording,
        from_s: f64,
        options: &ReadOptions,
        by_position: bool,
    ) -> Result<Self, Abstention> {
        let none = Self {
            rises: None,
            pv_std: 0.0,
            op_range: 0.0,
            noise: 0.0,
            probability: None,
            silent: false,
        };
        let Some(before) = recording.part(f64::NEG_INFINITY, from_s, f64::INFINITY) else {
            return Ok(none);
        };
        let asked = DiagnoseOptions {
            detectors: Detectors::None,
            grid: options.grid,
            plan: false,
            ..DiagnoseOptions::default()
        };
        let Ok(diagnosis) = diagnose(&before, &asked) else { return Ok(none) };
        let longest = diagnosis.grid.longest().filter(|segment| segment.len() >= FEWEST);
        let read = |s: &'_ Segment| if by_position { s.vp.clone() } else { s.pv.clone() };
        let Some((segment, pv)) = longest.and_then(|s| Some((s, read(s)?))) else {
            return Ok(none);
        };
        Ok(Self {
            rises: rises(segment),
            pv_std: std(&pv),
            op_range: quantile(&segment.op, 0.98) - quantile(&segment.op, 0.02),
            noise: noise_std(&pv),
            probability: probability(&diagnosis),
            silent: diagnosis.verdict.class == VerdictClass::DoesNotRespond,
        })
    }
}

/// Probability that the valve sticks, from operation.
fn probability(diagnosis: &Diagnosis) -> Option<f64> {
    diagnosis.verdict.probability.map(|p| p.clamp(0.02, 0.98))
}

/// The signal with the answers.
fn who(by_position: bool) -> &'static str {
    if by_position { "stem" } else { "PV" }
}

/// The recorded times in manual, with the times of their turns. `read` gives the PV or the valve position, which
/// depends only on the valve.
fn spells(
    by_hand: &ByHand,
    grid: &Grid,
    read: impl Fn(&Segment) -> Option<&[f64]>,
) -> Vec<(Vec<f64>, Manual)> {
    let mut all = vec![];
    for sets in by_hand.sets.split_inclusive(|set| set.op.is_none()) {
        let turns: Vec<(f64, f64)> =
            sets.iter().filter_map(|set| Some((set.at_s, set.op?))).collect();
        let (Some((from, _)), Some(last)) = (turns.first(), sets.last()) else { continue };
        let of =
            |segment: &&Segment| segment.from <= *from && *from < segment.from + segment.duration();
        let Some(segment) = grid.segments.iter().find(of) else { continue };
        let Some(pv) = read(segment) else { continue };
        let at =
            |t: f64| ((t - segment.from) / segment.sample_time - 1e-6).ceil().max(0.0) as usize;
        let to = if last.op.is_none() { at(last.at_s).min(pv.len()) } else { pv.len() };
        let first = at(*from).min(to);
        let inside = turns.iter().filter(|(t, _)| at(*t) < to);
        let (times, turns) = inside.map(|(t, op)| (*t, (at(*t) - first, *op))).unzip();
        let before = segment.op[first.saturating_sub(1).min(segment.op.len() - 1)];
        all.push((times, Manual { pv: pv[first..to].to_vec(), before, turns }));
    }
    all.retain(|(_, manual): &(Vec<f64>, Manual)| manual.turns.len() >= 2);
    all
}

/// Number of turns, without a level that was the same before.
fn turned(manual: &Manual) -> usize {
    manual.turns.len() - usize::from((manual.turns[0].1 - manual.before).abs() < 1e-6)
}

/// Whether the signal changes in these segments.
fn moves(spells: &[(Vec<f64>, Manual)]) -> bool {
    let values: Vec<f64> = spells.iter().flat_map(|(_, of)| of.pv.iter().copied()).collect();
    span(&values) > 0.0
}

/// The longest dead time if the turns were answered, samples: nearly the shortest hold, and less than the usual one.
fn longest_dead(spells: &[Manual]) -> usize {
    let holds =
        spells.iter().flat_map(|spell| spell.turns.windows(2).map(|two| two[1].0 - two[0].0));
    let mut holds: Vec<usize> = holds.collect();
    holds.sort_unstable();
    let at = |k: usize| holds.get(k).copied().unwrap_or(0);
    at(holds.len() / 12).min(at(holds.len() / 2).saturating_sub(1))
}

/// The uncertainty from a historian that interpolates between archived samples; 0 if it archives all.
fn drawn(spells: &[Manual], by_position: bool) -> f64 {
    let (mut pv, mut turns) = (vec![], vec![]);
    for spell in spells {
        turns.extend(spell.turns.iter().map(|(at, _)| pv.len() + at));
        pv.extend_from_slice(&spell.pv);
    }
    let scale = 1e-7 * span(&pv);
    let bends = |k: &usize| (pv[k - 1] - 2.0 * pv[*k] + pv[k + 1]).abs() > scale;
    // A fast position bends with each turn.
    let turnless = |k: &usize| !by_position || turns.iter().all(|at| at.abs_diff(*k) > 1);
    let kept: Vec<usize> = (1..pv.len().saturating_sub(1)).filter(bends).filter(turnless).collect();
    if 2 * kept.len() > pv.len() || kept.len() < 3 {
        return 0.0;
    }
    let off = kept.windows(3).map(|at| {
        let share = (at[1] - at[0]) as f64 / (at[2] - at[0]) as f64;
        (pv[at[0]] + share * (pv[at[2]] - pv[at[0]]) - pv[at[1]]).abs()
    });
    0.5 * median(&off.collect::<Vec<_>>())
}

/// The verdict from test and operation together. It never accuses or clears the valve if the test alone contradicts
/// this.
fn conclude(
    weighed: &Weighed,
    operation: &Operation,
    spells: &[Manual],
    by_position: bool,
    at_rest: bool,
) -> TestReading {
    let log_odds = log_odds(weighed);
    let (by_test, probability) = (of_test(log_odds), joined(log_odds, operation.probability));
    let (sticking, following) = (weighed.sticking_seen, weighed.following_seen);
    let turns = || spells.iter().flat_map(|spell| spell.turns.windows(2));
    let travel = turns().map(|two| (two[1].1 - two[0].1).abs()).fold(0.0, f64::max);
    let steps = || spells.iter().flat_map(|spell| spell.pv.windows(2));
    let moves = 10 * steps().filter(|two| two[0] != two[1]).count() > steps().count();
    let op = spells.iter().flat_map(|spell| spell.turns.iter().map(|turn| turn.1));
    // A stem that follows moves as far as the OP.
    let still = (at_rest || by_position && weighed.per_percent < STILL)
        && sticking.clear < CLEAR
        && following.clear == 0
        && span(&op.collect::<Vec<_>>()) >= LIMITS.1;
    let quiet = !by_position
        && sticking.clear < CLEAR
        && following.clear == 0
        && following.fits < 0.5 * FITS_HEALTHY
        && moves;
    let share = if travel >= LARGE { SILENT.1 } else { SILENT.0 };
    let silent = quiet
        && operation.pv_std > MOVES * operation.noise
        && weighed.per_percent * operation.op_range < share * operation.pv_std
        && travel > 0.5 * operation.op_range
        && probability >= DEAD;
    // Without operation nothing asks for a smaller limit.
    let limit = match operation.op_range > 0.0 {
        true => (LIMIT * operation.op_range).clamp(LIMITS.0, LIMITS.1),
        false => LIMITS.1,
    };
    let class = match () {
        () if silent || still => VerdictClass::DoesNotRespond,
        // Operation does not decide against the test, which is the better witness.
        () if probability >= STICKS && by_test > 0.5 && is_clear(sticking) => VerdictClass::Sticks,
        () if probability < CLEARS
            && by_test < CLEARS
            && weighed.elsewhere < 0.1
            && weighed.silent < NO_ANSWER
            && weighed.s_below.is_some_and(|below| below < limit)
            && following.strength > STRONGER
            && following.fits > FITS_HEALTHY =>
        {
            VerdictClass::DoesNotStick
        }
        () if quiet && operation.silent => VerdictClass::DoesNotRespond,
        () => VerdictClass::CannotTell,
    };
    let at = |share| weighed.s_quantile(share);
    // The sizes of the turns limit the accuracy of S.
    let s = Estimate { value: at(0.5), low: at(0.05) / WIDER, high: at(0.95) * WIDER };
    // J is tried in steps of a fifth of S.
    let of = |share, by: f64| (weighed.share_quantile(share) + by).clamp(0.0, 1.0);
    let j = Estimate {
        value: of(0.5, 0.0) * s.value,
        low: of(0.05, -0.1) * s.low,
        high: of(0.95, 0.1) * s.high,
    };
    let sticks = class == VerdictClass::Sticks;
    TestReading {
        class,
        probability,
        by_test,
        log_odds,
        by_operation: operation.probability,
        dead_band_elsewhere: weighed.elsewhere,
        s: (sticks && !weighed.open).then_some(s),
        j: (sticks && !weighed.open).then_some(j),
        // A limit would contradict a valve that probably sticks.
        s_below: weighed
            .s_below
            .filter(|below| *below < TOLD_UP_TO && probability < CLEARS && !still)
            .map(|below| below.max(SMALL)),
        by_position,
        ..TestReading::default()
    }
}

/// Whether at least two answers are clear.
fn is_clear(seen: Seen) -> bool {
    seen.clear >= CLEAR && seen.strength > STRONG
}

/// Factor that widens the interval of S from the likelihoods.
const WIDER: f64 = 1.06;

fn steps(spells: &[(Vec<f64>, Manual)], weighed: &Weighed, curve: Option<&Curve>) -> Vec<Step> {
    let answered =
        |turn: f64, answer: f64, error: f64| weighed.sign * turn.signum() * answer > SEEN * error;
    // An answer of a straightened PV is in percent.
    let in_pv = |manual: &Manual, at: usize, (answer, error): (f64, f64)| match curve {
        Some(curve) => {
            let from = curve.position(manual.pv[at.saturating_sub(1)]);
            let to = |by: f64| curve.pv(from + by);
            (to(answer) - to(0.0), 0.5 * (to(answer + error) - to(answer - error)).abs())
        }
        None => (answer, error),
    };
    let mut all = vec![];
    for (s, (times, manual)) in spells.iter().enumerate() {
        for (i, (at_s, (_, op))) in times.iter().zip(&manual.turns).enumerate() {
            let seen = weighed.turns.iter().find(|(of, turn, ..)| (*of, *turn) == (s, i));
            let turn = (i > 0).then(|| op - manual.turns[i - 1].1).filter(|turn| *turn != 0.0);
            let shown = seen.map(|(.., answer, error)| {
                in_pv(manual, manual.turns[i].0.min(manual.pv.len() - 1), (*answer, *error))
            });
            all.push(Step {
                at_s: *at_s,
                op: *op,
                travel: turn.map(f64::abs),
                answer: shown.map(|(answer, _)| answer),
                error: shown.map(|(_, error)| error),
                answered: turn
                    .zip(seen)
                    .is_some_and(|(turn, (_, _, answer, error))| answered(turn, *answer, *error)),
            });
        }
    }
    all
}

fn reasons(reading: &TestReading, weighed: &Weighed, at_rest: bool) -> Vec<String> {
    let turns: Vec<&Step> = reading.steps.iter().filter(|step| step.travel.is_some()).collect();
    let seen: Vec<f64> =
        turns.iter().filter(|step| step.answered).filter_map(|step| step.travel).collect();
    let unseen: Vec<f64> =
        turns.iter().filter(|step| !step.answered).filter_map(|step| step.travel).collect();
    let sizes: Vec<f64> = turns.iter().filter_map(|step| step.travel).collect();
    let (least, most) = (rough(min(&sizes)), rough(max(&sizes)));
    let sizes = if least == most { most } else { format!("{least} to {most}") };
    let mut all = vec![format!(
        "the OP was turned {} within {}, by {sizes} %, and the {} answered {} of these turns",
        times(reading.turned),
        time(reading.to_s - reading.from_s),
        reading.who(),
        seen.len(),
    )];
    if !seen.is_empty() {
        all.push(format!("the smallest turn with an answer was {} %", rough(min(&seen))));
    }
    if !unseen.is_empty() {
        all.push(format!("the largest turn without an answer was {} %", rough(max(&unseen))));
    }
    match reading.class {
        VerdictClass::Sticks => all.push(match reading.s {
            Some(s) => format!(
                "a valve with S {} % ({} to {}) explains which turns were answered and by how much; a valve without \
                 stiction does not",
                rough(s.value),
                rough(s.low),
                rough(s.high)
            ),
            None => format!(
                "S is at least {} %: no turn was large enough for an upper limit",
                rough(weighed.s_quantile(0.05) / WIDER)
            ),
        }),
        VerdictClass::CannotTell if !seen.is_empty() => {}
        VerdictClass::DoesNotStick | VerdictClass::CannotTell => all.extend(reading.s_below.map(|limit| {
            format!(
                "the {} moved as expected of a valve with S below {} %{}",
                reading.who(),
                rough(limit),
                match unseen.is_empty() {
                    true => "",
                    false => " in all turns together, even if no single answer exceeds the measurement error",
                }
            )
        })),
        VerdictClass::DoesNotRespond => all.push(
            match reading.by_position || at_rest {
                true => {
                    "the stem did not follow the OP, or its position is measured wrongly".to_owned()
                }
                false => {
                    "the PV did not follow the OP, although the PV moved in operation".to_owned()
                }
            },
        ),
    }
    all.extend(reading.position.iter().flat_map(PositionReading::reasons));
    // A dead band of the transmitter makes no jumps.
    let sticks = reading.class == VerdictClass::Sticks;
    let alike =
        weighed.alike || !reading.by_position && reading.j.is_none_or(|jump| jump.low == 0.0);
    if weighed.elsewhere > 0.1 {
        all.push(format!(
            "a dead band downstream of the valve, as in the transmitter or a linkage, may explain the answers too ({})",
            percent(weighed.elsewhere)
        ));
    } else if alike && sticks {
        all.push(
            "a dead band of the transmitter could give the same answers; only the stem position can distinguish it \
             from stiction"
                .to_owned(),
        );
    }
    let against = reading.by_operation.filter(|p| *p <= PROBABLY_FINE_UP_TO);
    if let Some(p) = against.filter(|_| sticks && (alike || weighed.elsewhere > 0.1)) {
        all.push(format!(
            "from operation alone this probability is only {}, so check the transmitter before work on the valve",
            percent(p)
        ));
    }
    if let Some(before) = reading.by_operation {
        all.push(format!(
            "the probability that the valve sticks is {} from the test, {} from operation before it, and {} from both",
            percent(reading.by_test),
            percent(before),
            percent(reading.probability)
        ));
    }
    all
}

/// How to repeat an inconclusive test.
fn advice(reading: &TestReading, hasty: bool) -> Option<Repetition> {
    if reading.class != VerdictClass::CannotTell {
        return None;
    }
    let turns = reading.steps.iter().filter(|step| step.travel.is_some());
    let (seen, unseen): (Vec<&Step>, Vec<&Step>) = turns.partition(|step| step.answered);
    let most = unseen.iter().filter_map(|step| step.travel).fold(0.0, f64::max);
    let turned = || reading.steps.windows(2).filter(|two| two[1].travel.is_some());
    let reverses =
        turned().any(|two| two[1].op > two[0].op) && turned().any(|two| two[1].op < two[0].op);
    Some(match () {
        () if !reverses => Repetition::ThereAndBack,
        () if hasty => Repetition::LongerHolds,
        () if reading.dead_band_elsewhere > 0.3 => Repetition::WithPosition,
        () if seen.is_empty() && most >= LARGE => Repetition::NoAnswer,
        // With a limit of S the PV followed all turns together.
        () if seen.len() < CLEAR && reading.s_below.is_none() => Repetition::LargerTurns,
        () if unseen.is_empty() => Repetition::SmallerTurns,
        () => Repetition::CalmerTime,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bands::Bands;
    use crate::closed_loop::NormalStream;
    use crate::recording::{Channel, Mode, Modes, Quality, Set};
    use crate::valve::{Model, Start, Valve};

    const DT: f64 = 2.0;
    const OPERATION: usize = 300;

    /// A loop in automatic, then a test of turns from 0.4 % to 9 % and back to 0.4 %, each held for 12 samples, then
    /// automatic again.
    fn tested(s: f64, j: f64, integrates: bool, seed: u64) -> Recording {
        let mut noise = NormalStream::new(seed);
        let mut op: Vec<f64> = (0..OPERATION)
            .map(|k| 45.0 + 1.5 * (0.02 * k as f64).sin() + 0.7 * (0.047 * k as f64).sin())
            .collect();
        let rest = op[OPERATION - 1];
        let mut modes = Modes { time: vec![0.0], modes: vec![Mode::Automatic] };
        modes.time.push(DT * op.len() as f64);
        modes.modes.push(Mode::Manual);
        let growing = (0..16).map(|k| 0.2 * 1.23f64.powi(k));
        let shrinking = (0..16).rev().map(|k| 0.21 * 1.23f64.powi(k));
        for (k, half) in growing.chain(shrinking).enumerate() {
            op.extend([rest + if k % 2 == 0 { half } else { -half }; 12]);
        }
        modes.time.push(DT * op.len() as f64);
        modes.modes.push(Mode::Automatic);
        op.extend((0..60).map(|k| rest + 0.5 * (0.05 * f64::from(k)).sin()));
        let mut valve = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
        valve.restart(Start::at_rest(op[0]));
        let (mut z, mut load) = (0.0, 0.0);
        let pv: Vec<f64> = op
            .iter()
            .map(|u| {
                let x = valve.step(*u) - 45.0;
                load = 0.995 * load + 0.004 * noise.draw();
                z += if integrates { 0.02 * (x + load) } else { 0.35 * (1.8 * (x + load) - z) };
                70.0 + z + 0.02 * noise.draw()
            })
            .collect();
        let mut recording = Recording::regular("FIC1", DT, &op, Some(&pv), None).unwrap();
        recording.mode = Some(modes);
        recording
    }

    /// One recording of two, the second after the first.
    fn joined(first: &Recording, second: &Recording) -> Recording {
        let both = |of: fn(&Recording) -> &Channel| {
            [of(first), of(second)].map(|c| &c.values[..]).concat()
        };
        let pv = both(|r| r.pv.as_ref().unwrap());
        let mut joined = Recording::regular("FIC1", DT, &both(|r| &r.op), Some(&pv), None).unwrap();
        let [mut modes, later] = [first, second].map(|r| r.mode.clone().unwrap());
        let shift = DT * first.op.values.len() as f64;
        modes.time.extend(later.time.iter().map(|t| t + shift));
        modes.modes.extend(later.modes);
        joined.mode = Some(modes);
        joined
    }

    #[test]
    fn a_valve_that_changed_between_two_tests_is_judged_by_the_later_one() {
        let [sticky, good] = [tested(4.0, 1.0, false, 3), tested(0.0, 0.0, false, 4)];
        let of = |recording: &Recording| read(recording, &ReadOptions::default()).unwrap();
        let repaired = of(&joined(&sticky, &good));
        assert!(repaired.class == VerdictClass::DoesNotStick, "{:?}", repaired.reasons);
        let worse = of(&joined(&good, &sticky));
        assert!(worse.class != VerdictClass::DoesNotStick, "{:?}", worse.reasons);
        let same = of(&joined(&sticky, &tested(4.0, 1.0, false, 5)));
        assert!(same.class == VerdictClass::Sticks && same.stops == 1, "{:?}", same.reasons);

        // Whatever all turns together say.
        let later = of(&sticky);
        let sets = ByHand::of(&joined(&good, &sticky)).unwrap();
        let with = |whole: TestReading| latest(&whole, &sets, |_| Ok(later.clone()));
        let whole = TestReading { stops: 1, ..later.clone() };
        let cleared =
            with(TestReading { class: VerdictClass::DoesNotStick, s: None, ..whole.clone() });
        assert!(cleared.is_some_and(|of| of.reasons[0].contains("seems to have changed")));
        let s = Some(Estimate { value: 1.2, low: 1.0, high: 1.5 });
        assert!(with(TestReading { s, ..whole.clone() }).is_some());
        assert!(with(whole.clone()).is_none());
        assert!(with(TestReading { class: VerdictClass::CannotTell, ..whole }).is_none());
    }

    /// With a dead time of a hold each answer would be that to the next turn.
    #[test]
    fn a_dead_time_is_shorter_than_equal_holds() {
        let of = |holds: &[usize]| {
            let starts = holds.iter().scan(0, |at, hold| {
                *at += hold;
                Some((*at, 0.0))
            });
            longest_dead(&[Manual { pv: vec![], before: 0.0, turns: starts.collect() }])
        };
        assert_eq!((of(&[]), of(&[40; 20])), (0, 39));
        assert_eq!(of(&[40, 3, 40, 40, 40, 40, 40]), 3);
    }

    #[test]
    fn settings_in_a_gap_are_counted() {
        let mut recording = tested(4.0, 1.0, false, 3);
        let pv = recording.pv.as_mut().unwrap();
        pv.quality[OPERATION + 200..OPERATION + 300].fill(Quality::Bad);
        let reading = read(&recording, &ReadOptions::default()).unwrap();
        let why = reading.reasons.iter().find(|why| why.contains("in a gap of the recording"));
        assert!(
            why.is_some_and(|why| why.starts_with("the result leaves out 1")),
            "{:?}",
            reading.reasons
        );
    }

    /// The same with the valve position, and a load that masks it in the PV.
    fn with_position(s: f64, j: f64) -> Recording {
        let mut recording = tested(s, j, false, 7);
        let mut valve = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
        valve.restart(Start::at_rest(recording.op.values[0]));
        let mut noise = NormalStream::new(3);
        let stem =
            recording.op.values.iter().map(|u| valve.step(*u) + 0.02 * noise.draw()).collect();
        recording.vp = Some(Channel::new("VP", recording.op.time.clone(), stem).unwrap());
        let pv = recording.pv.as_mut().unwrap();
        let mut load = 0.0;
        for v in &mut pv.values {
            load += noise.draw();
            *v += load;
        }
        recording
    }

    #[test]
    fn a_position_settles_what_the_pv_hides() {
        let blind = Recording { vp: None, ..with_position(2.0, 0.8) };
        assert_eq!(read(&blind, &asked()).unwrap().class, VerdictClass::CannotTell);
        let reading = read(&with_position(2.0, 0.8), &asked()).unwrap();
        assert_eq!(reading.class, VerdictClass::Sticks, "{reading:?}");
        assert!((reading.s.unwrap().value / 2.0 - 1.0).abs() < 0.1 && reading.by_position);
        let band = reading.position.unwrap().dead_band.unwrap();
        assert!(band.above < 2.0 && 2.0 < band.up_to.unwrap() + 0.1, "{band:?}");
        assert!(reading.reasons.iter().any(|r| r.starts_with("the dead band of the stem is")));
        let free = read(&with_position(0.0, 0.0), &asked()).unwrap();
        assert_eq!(free.class, VerdictClass::DoesNotStick, "{free:?}");
        // A stem at rest does not respond. With a constant position the PV is read instead.
        let mut noise = NormalStream::new(4);
        let mut still = with_position(2.0, 0.8);
        still.vp.as_mut().unwrap().values.iter_mut().for_each(|v| *v = 50.0 + 0.02 * noise.draw());
        assert_eq!(read(&still, &asked()).unwrap().class, VerdictClass::DoesNotRespond);
        let mut failed = tested(3.0, 1.5, false, 7);
        let n = failed.op.time.len();
        failed.vp = Some(Channel::new("VP", failed.op.time.clone(), vec![50.0; n]).unwrap());
        let by_pv = read(&failed, &asked()).unwrap();
        assert_eq!((by_pv.class, by_pv.by_position), (VerdictClass::Sticks, false));
        // Without a PV, too.
        let alone = Recording { pv: None, ..with_position(2.0, 0.8) };
        assert_eq!(read(&alone, &asked()).unwrap().class, VerdictClass::Sticks);
    }

    fn asked() -> ReadOptions {
        ReadOptions { rises: Some(true), ..ReadOptions::default() }
    }

    #[test]
    fn a_test_finds_a_valve_that_sticks_and_how_much() {
        for (s, j, integrates) in
            [(3.0, 1.5, false), (1.2, 1.2, false), (4.0, 2.0, true), (2.0, 0.6, true)]
        {
            let reading = read(&tested(s, j, integrates, 7), &asked()).unwrap();
            assert_eq!(reading.class, VerdictClass::Sticks, "{s} {j}: {reading:?}");
            let found = reading.s.unwrap();
            assert!((found.value / s - 1.0).abs() < 0.15, "{s}: {found:?}");
            assert!(found.low < s && s < found.high, "{s}: {found:?}");
            assert!(reading.by_test > 0.95 && reading.steps.len() == 32 && reading.stops == 0);
        }
    }

    #[test]
    fn a_test_clears_a_valve_that_follows() {
        for integrates in [false, true] {
            let reading = read(&tested(0.0, 0.0, integrates, 3), &asked()).unwrap();
            assert_eq!(reading.class, VerdictClass::DoesNotStick, "{reading:?}");
            assert!(reading.s_below.unwrap() < 2.0 && reading.s.is_none());
            assert_eq!(reading.word(), "does not stick");
            let doubtful = TestReading { probability: 0.4, ..reading };
            assert_eq!(doubtful.word(), "does not stick by more than the limit");
        }
    }

    /// A valve that never moves, in turns up to 9 % or `by` times that, with a PV that the load moves.
    fn seized(by: f64) -> Recording {
        let mut recording = tested(0.0, 0.0, false, 1);
        let (rest, mut noise) = (recording.op.values[OPERATION - 1], NormalStream::new(9));
        for (k, op) in recording.op.values.iter_mut().enumerate() {
            *op = if k < OPERATION { *op } else { rest + by * (*op - rest) };
        }
        for (k, pv) in recording.pv.as_mut().unwrap().values.iter_mut().enumerate() {
            *pv = 70.0 + (0.008 * k as f64).sin() + 0.02 * noise.draw();
        }
        recording
    }

    #[test]
    fn a_seized_valve_needs_no_larger_turns() {
        let large = read(&seized(5.0), &asked()).unwrap();
        let told = large.advice.as_deref().is_some_and(|how| how == Repetition::NoAnswer.name());
        assert!(large.class == VerdictClass::DoesNotRespond || told, "{large:?}");
        assert!(large.steps.iter().all(|step| !step.answered));
        let small = read(&seized(0.3), &asked()).unwrap();
        assert_eq!(small.class, VerdictClass::CannotTell, "{small:?}");
        assert_ne!(small.advice.as_deref(), Some(Repetition::NoAnswer.name()));
    }

    #[test]
    fn an_accusation_names_the_transmitter_unless_the_stem_is_recorded() {
        let says = |recording: &Recording| {
            let reading = read(recording, &asked()).unwrap();
            let accused = reading.class == VerdictClass::Sticks;
            (accused, reading.reasons.iter().any(|why| why.contains("of the transmitter could")))
        };
        // A valve without a jump moves the PV as a dead band of the transmitter does.
        assert_eq!(says(&tested(4.0, 0.0, false, 3)), (true, true));
        assert_eq!(says(&with_position(2.0, 0.8)), (true, false));
    }

    #[test]
    fn a_short_turn_has_the_answer_that_follows_it() {
        let (mut op, mut recording) = (vec![45.0; 30], tested(0.0, 0.0, false, 3));
        op.extend((0..16).flat_map(|k| [if k % 2 == 0 { 49.0 } else { 41.0 }; 3]));
        op.extend([45.0; 20]);
        let (mut z, mut noise) = (45.0, NormalStream::new(2));
        let lagged = |k: usize| {
            z += 0.5 * (op[k.saturating_sub(2)] - z);
            z + 0.05 * noise.draw()
        };
        let pv: Vec<f64> = (0..op.len()).map(lagged).collect();
        recording = Recording {
            mode: Some(Modes { time: vec![0.0, 59.0], modes: vec![Mode::Automatic, Mode::Manual] }),
            ..Recording::regular(&recording.name, DT, &op, Some(&pv), None).unwrap()
        };
        let reading = read(&recording, &asked()).unwrap();
        let turns: Vec<&Step> = reading.steps.iter().filter(|s| s.travel.is_some()).collect();
        assert!(turns.iter().all(|step| step.error.unwrap() > 0.0), "{turns:?}");
        assert!(turns.iter().filter(|step| step.answered).count() >= 14, "{turns:?}");
        // An OP that is set to the same value is no turn.
        let sets = [45.0, 49.0, 49.0, 41.0, 49.0].into_iter().enumerate();
        let set = |(k, op)| Set { at_s: 60.0 + 6.0 * k as f64, op: Some(op) };
        let by_hand = ByHand { sets: sets.map(set).collect(), known_by: KnownBy::Sheet };
        let options = ReadOptions { by_hand: Some(by_hand), ..asked() };
        let steps = read(&recording, &options).unwrap().steps;
        assert!(steps[2].travel.is_none() && !steps[2].answered, "{steps:?}");
    }

    #[test]
    fn what_goes_against_a_turn_is_no_answer() {
        let reading = read(&tested(3.0, 1.5, false, 7), &asked()).unwrap();
        let moved = |two: &[Step]| two[1].answer.unwrap() * (two[1].op - two[0].op);
        for two in reading.steps.windows(2).filter(|two| two[1].answered) {
            assert!(moved(two) > 0.0, "{two:?}");
        }
    }

    #[test]
    fn units_and_sign_do_not_matter() {
        let recording = tested(3.0, 1.5, false, 7);
        let one = read(&recording, &asked()).unwrap();
        let mut other = recording;
        let pv = other.pv.as_mut().unwrap();
        pv.values.iter_mut().for_each(|v| *v = 12.0 - 8.0 * *v);
        let other = read(&other, &ReadOptions { rises: Some(false), ..asked() }).unwrap();
        assert_eq!(one.class, other.class);
        let (a, b) = (one.s.unwrap(), other.s.unwrap());
        assert!((a.value / b.value - 1.0).abs() < 1e-6, "{a:?} {b:?}");
    }

    #[test]
    fn sheet_mode_and_output_tell_the_same() {
        let recording = tested(3.0, 1.5, false, 7);
        let by_mode = read(&recording, &asked()).unwrap();
        let unmarked = Recording { mode: None, ..recording.clone() };
        let by_output = read(&unmarked, &asked()).unwrap();
        let sheet = ByHand { known_by: KnownBy::Sheet, ..ByHand::of(&recording).unwrap() };
        let by_sheet = read(&unmarked, &ReadOptions { by_hand: Some(sheet), ..asked() }).unwrap();
        assert_eq!(by_mode.known_by, KnownBy::Mode);
        assert_eq!(by_output.known_by, KnownBy::Output);
        assert_eq!(by_sheet.known_by, KnownBy::Sheet);
        assert_eq!(by_mode.class, by_output.class);
        assert_eq!(by_mode.s, by_sheet.s);
    }

    #[test]
    fn what_cannot_be_read_is_reported() {
        let recording = tested(3.0, 1.5, false, 7);
        let refused = |recording: &Recording, options: &ReadOptions| -> String {
            read(recording, options).unwrap_err().0
        };
        let plain = Recording { mode: None, ..recording.part(0.0, 500.0, 0.0).unwrap() };
        assert!(refused(&plain, &asked()).starts_with("the recording has no test"));
        let sheet = |sets: Vec<Set>| ReadOptions {
            by_hand: Some(ByHand { sets, known_by: KnownBy::Sheet }),
            ..asked()
        };
        let early = vec![Set { at_s: 700.0, op: Some(40.0) }, Set { at_s: 650.0, op: Some(41.0) }];
        assert!(refused(&recording, &sheet(early)).contains("sort the settings by time"));
        for (at_s, op) in [(f64::NAN, 40.0), (700.0, f64::NAN), (700.0, 1e300)] {
            let wrong = vec![Set { at_s: 600.0, op: Some(40.0) }, Set { at_s, op: Some(op) }];
            assert!(refused(&recording, &sheet(wrong)).contains("which is no"));
        }
        let far: Vec<Set> = (0..9)
            .map(|k| Set { at_s: 1e6 + f64::from(k), op: Some(40.0 + f64::from(k % 2)) })
            .collect();
        assert!(refused(&recording, &sheet(far)).contains("outside the recording"));
        let blind = Recording { pv: None, ..recording.clone() };
        assert!(refused(&blind, &asked()).starts_with("without a PV or a valve position"));
        let mut frozen = recording.clone();
        let (time, n) = (recording.op.time.clone(), recording.op.time.len());
        frozen.pv = Some(Channel::new("PV", time, vec![99.0; n]).unwrap());
        assert!(refused(&frozen, &asked()).contains("the same value throughout the test"));
    }

    #[test]
    fn settings_too_fast_to_answer_are_refused_however_many() {
        let recording = tested(3.0, 1.5, false, 7);
        // A logger wrote the OP ten times a second, and it alternates.
        let sets: Vec<Set> = (0..200_000)
            .map(|k| Set {
                at_s: 600.0 + 0.1 * f64::from(k),
                op: Some(45.0 + 0.001 * f64::from(k % 900) * f64::from(1 - 2 * (k % 2))),
            })
            .collect();
        let by_hand = Some(ByHand { sets, known_by: KnownBy::Sheet });
        let refused = read(&recording, &ReadOptions { by_hand, ..asked() }).unwrap_err();
        assert_eq!(refused.0, TOO_FEW);
    }

    #[test]
    fn a_pv_of_noise_says_nothing_and_what_to_do() {
        let mut recording = tested(0.0, 0.0, false, 1);
        let mut noise = NormalStream::new(9);
        recording.pv.as_mut().unwrap().values.iter_mut().for_each(|v| *v = noise.draw());
        let reading = read(&recording, &asked()).unwrap();
        assert_eq!(reading.class, VerdictClass::CannotTell, "{reading:?}");
        assert!(reading.advice.is_some() && reading.s.is_none());
    }
}
