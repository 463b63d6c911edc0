//! The signature of a valve: a slow ramp of the OP over the stroke and back, with the recorded position.
//!
//! It applies where the turns of [`plan()`](super::plan()) do not: at a stop of the plant, in a loop that is too slow
//! for turns, and where the friction differs along the stroke.
//!
//! # The ramp
//! The OP rises from one end to the other and falls back, twice. It pauses every tenth of the way. The second time
//! takes twice as long, so the lag of the stem can be distinguished from a dead band.
//!
//! # The reading
//! Valves with many S and J and several lags are simulated under the recorded OP
//! ([`TwoPhase`](crate::valve::TwoPhase)). The likeliest valve has the least sum of squares E of the recorded position
//! about the line `a + b x`, where x is the simulated stem. So an error of the calibration is no friction. `S - J` is
//! the distance between rising and falling ramps, and J shows in the slips. Each is varied alone to find its 90 %
//! interval, which contains all values with
//!
//! ```text
//! (n / 20) ln(E(value) / E) < 2.71
//! ```
//!
//! Twenty of the n samples count as one, because the errors of neighbours are alike. The interval of S follows from the
//! sum of both squares. Each tenth of the stroke has its own S with the common J/S, from the sum of squares in that
//! tenth.
//!
//! The simulated stem slides on after a slip. A stem that rests again and moves in steps leaves a saw-tooth of height J
//! with the variance `J²/12`, and the distance between the ramps is S. J then follows from the variance that is left.
//!
//! # Limits
//! The position must be recorded, by a transmitter that is fixed to the stem. The recording must have several samples
//! per percent of OP. With one ramp rate and no pauses, a lag of the stem and a dead band look alike.
//!
//! # Sources
//! Ours. The ramp is the valve signature of positioner vendors (recalled).

use crate::bands::Bands;
use crate::diagnose::VerdictClass;
use crate::estimate::Estimate;
use crate::finding::Abstention;
use crate::recording::{ByHand, Grid, GridOptions, KnownBy, Mode, Recording, Segment, Set};
use crate::series::{line, max, mean, median, min, noise_std, quantile};
use crate::spoken::{rough, time};
use crate::valve::{Model, Start, Valve};
use std::ops::Range;

use super::probability::BORNE_OUT;
use super::ramps::{self, Characteristic};
use super::read::{TestReading, around};
use super::weigh::SMALL;

/// A ramp of the OP in the plan of a signature.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct Ramp {
    /// The OP at the end of the ramp, percent.
    pub to_op: f64,
    /// Duration of the ramp, s.
    pub duration_s: f64,
    /// Duration of the hold at the end of the ramp, s.
    pub hold_s: f64,
}

/// The plan of a signature: slow ramps of the OP over the stroke.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct SignaturePlan {
    /// Tag of the loop.
    pub name: String,
    /// The OP at the start, percent.
    pub from_op: f64,
    /// The ramps, in order.
    pub ramps: Vec<Ramp>,
    /// The longest permitted sample interval of OP and VP, s, without compression.
    pub record_every_s: f64,
    /// Duration of all ramps and holds, s.
    pub total_s: f64,
    /// A summary of the signature.
    pub summary: String,
    /// The instructions, in order.
    pub instructions: Vec<String>,
}

/// A part of the stroke with its S.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Place {
    /// The stem position at the lower end of the part, percent.
    pub from: f64,
    /// The stem position at the upper end of the part, percent.
    pub to: f64,
    /// Stick band plus dead band in this part, percent of span, with its 90 % interval.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Estimate,
}

/// The result of a signature.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Signature {
    /// The conclusion: `sticks`, `does not stick`, `does not respond` or `cannot tell`.
    pub class: VerdictClass,
    /// Stick band plus dead band, percent of span, with its 90 % interval, outside the part of the stroke that binds.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, with its 90 % interval; `None` without S.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// The OP range of the ramps, percent.
    pub op: [f64; 2],
    /// The range of the valve position, percent. Without a recorded valve position, the range of the PV as a position.
    pub vp: [f64; 2],
    /// What makes the PV a position; `None` if the position was recorded.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub characteristic: Option<Characteristic>,
    /// The calibration error: the mean of the simulated stem position minus VP, percent.
    pub offset: f64,
    /// The parts of the stroke, from the lowest part on.
    pub places: Vec<Place>,
    /// The part of the stroke where the stem binds, which means that S is clearly larger there; `None` without such a
    /// part.
    pub binds: Option<[f64; 2]>,
    /// Number of ramps.
    pub ramps: usize,
    /// Start of the ramps, s on the recording's clock.
    pub from_s: f64,
    /// End of the ramps, s on the recording's clock.
    pub to_s: f64,
    /// The reasons, in sentences.
    pub reasons: Vec<String>,
    /// Whether the mode shows that the ramps were made by hand, as far as [`by_ramps`] found them.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub known_by: KnownBy,
    /// The recording of the ramps, with a tenth of their duration before and after them.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub recorded: Vec<Segment>,
}

/// Duration of the first ramp over the whole stroke, s, and its ratio to the second.
const STROKE_S: f64 = 400.0;
const SLOWER: f64 = 2.0;
/// Parts of a ramp, and the pause after each, s.
const PARTS: usize = 10;
const PAUSE_S: f64 = 10.0;
/// Samples per percent of OP that the plan asks for.
const PER_PERCENT: f64 = 8.0;
/// Smallest OP range of a ramp, percent.
pub const LEAST_TRAVEL: f64 = 10.0;
/// Smallest number of samples of a ramp.
const FEWEST: usize = 60;
/// Largest step of the OP in a ramp, as a share of its travel.
const STEP: f64 = 0.04;
/// An OP that moves back by this much ends a ramp, percent.
const BACK: f64 = 1.0;
/// Largest ratio of the spans of two ramps in a series: with a position, and with the PV alone, where the ends may differ.
const ALIKE_RAMPS: (f64, f64) = (1.3, 2.5);
/// Parts of the stroke.
const PLACES: usize = 10;
/// A stem that moves less than this per percent of OP does not respond.
const STILL: f64 = 0.1;
/// Smallest number of samples in a part of the stroke.
const IN_PLACE: usize = 40;
/// The stem binds where its S is larger than elsewhere by this factor, and by this much, percent.
const BINDS: (f64, f64) = (1.5, 0.8);
/// The smallest S - J and J tried, percent, the largest as a share of the OP range, and the ratio of each value to the
/// previous one.
const FROM: f64 = 0.1;
const UP_TO: f64 = 0.6;
const RATIO: f64 = 1.25;
/// The ratio of one S to the last in a part of the stroke, and the largest change of S there.
const FINE: f64 = 1.04;
const MOST: f64 = 8.0;
/// Lags of the stem that are tried, s.
const LAGS: [f64; 6] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0];
/// Rounds of refinement, the first range of each value as a share of it, and the steps on either side.
const ROUNDS: i32 = 10;
const FIRST_STEP: f64 = 0.4;
const AROUND: i32 = 6;
/// Samples that count as one, and the largest difference of twice the log-likelihood in a 90 % interval.
const ALIKE: f64 = 20.0;
const NINETY: f64 = 2.71;
/// Most samples of the first search, and of later searches. Of more, every second, third, … is used.
const SEARCHED: usize = 1500;
const MOST_SAMPLES: usize = 8000;
/// No model is exact: the least distances of S and J from the ends of their intervals, as shares of S.
const LEAST_WIDE: (f64, f64) = (0.05, 0.08);
/// Limits for a stem that moves in steps. The first number is the distance for S as a share of S. The others are J and
/// the two ends of its interval, as multiples of the height of the saw-tooth, which the lag of the stem lowers. Below,
/// the smallest step, percent.
const STEPS_WIDE: (f64, f64, f64, f64) = (0.1, 1.2, 0.75, 1.6);
const LEAST_STEP: f64 = 0.2;
/// S of a sticking valve is at least this many of the smallest changes of the recorded position.
const RESOLVED: f64 = 3.0;
/// Nine in ten steps of an archive are at most this many times the smallest steps.
const LIKE_STEPS: f64 = 1.15;
/// Smallest standard deviation of the errors, percent.
const FLOOR: f64 = 0.02;

/// Plans the signature of a valve between two OP, percent.
///
/// # Errors
/// If the range is not within 0 to 100 % or is too narrow.
pub fn signature_plan(name: &str, [low, high]: [f64; 2]) -> Result<SignaturePlan, Abstention> {
    if !(low >= 0.0 && high <= 100.0 && high - low >= LEAST_TRAVEL) {
        return Err(Abstention(format!(
            "a signature needs an OP range of at least {LEAST_TRAVEL} % within 0 to 100 %"
        )));
    }
    let first = STROKE_S * (high - low) / 100.0;
    let ramp = |k: usize| {
        let (from, to) = if k.is_multiple_of(2) { (low, high) } else { (high, low) };
        let duration = if k < 2 { first } else { SLOWER * first };
        (1..=PARTS).map(move |part| Ramp {
            to_op: from + (to - from) * part as f64 / PARTS as f64,
            duration_s: duration / PARTS as f64,
            hold_s: PAUSE_S,
        })
    };
    let ramps: Vec<Ramp> = (0..4).flat_map(ramp).collect();
    let total_s = ramps.iter().map(|ramp| ramp.duration_s + ramp.hold_s).sum();
    let record_every_s = (first / (high - low) / PER_PERCENT).min(1.0);
    let over = format!("from {} to {} %", rough(low), rough(high));
    Ok(SignaturePlan {
        name: name.to_owned(),
        from_op: low,
        record_every_s,
        total_s,
        summary: format!("in manual, two slow ramps of the OP {over} and back with pauses, in {}", time(total_s)),
        instructions: vec![
            format!(
                "Make the test when the process tolerates the whole range {over}, for example at a stop with the block \
                 valves closed. Agree on the test with the operator and the shift lead."
            ),
            format!(
                "Open a trend of OP and valve position (VP) with a sample every {} or faster, without compression.",
                time(record_every_s)
            ),
            format!("Put the controller in manual and the OP at {} %. Wait until the stem rests.", rough(low)),
            "Ramp the OP as in the table, in steps of 0.2 % or smaller. Do not reverse the OP within a ramp.".to_owned(),
            "Stop if the process nears an alarm, or if the stem does not move although the OP has moved by half of the \
             range."
                .to_owned(),
            "Read the recording with stiction test read.".to_owned(),
        ],
        ramps,
    })
}

/// A ramp in the recording.
struct Run {
    rising: bool,
    /// OP range, percent.
    span: f64,
    /// Samples in the segment.
    from: usize,
    to: usize,
}

/// Reads the signature in a recording.
///
/// # Errors
/// If the recording has neither a position nor a PV, or no ramp up and down. The message names the remedy.
pub fn signature(recording: &Recording, grid: &GridOptions) -> Result<Signature, Abstention> {
    let of_pv = recording.vp.is_none();
    if of_pv && recording.pv.is_none() {
        return Err(Abstention(
            "a signature needs the valve position or the PV; record one of them".to_owned(),
        ));
    }
    // The OP is ramped by hand, so the mode must not cut the recording.
    let whole = Recording { mode: None, ..recording.masked().into_owned() };
    let grid = Grid::of(&whole, grid).map_err(|error| Abstention(error.to_string()))?;
    let parts = |segment: &Segment| match of_pv {
        true => in_manual(recording, segment),
        false => std::iter::once(0..segment.op.len()).collect(),
    };
    let parts = grid.segments.iter().flat_map(|of| parts(of).into_iter().map(move |k| (of, k)));
    let runs: Vec<(&Segment, Vec<Run>)> =
        parts.map(|(segment, part)| (segment, runs(&segment.op, part))).collect();
    if of_pv && runs.is_empty() {
        return Err(Abstention(
            "without a valve position a ramp of the OP is read only in manual, because a controller ramps the OP, too; record \
             the mode"
                .to_owned(),
        ));
    }
    let alike = if of_pv { ALIKE_RAMPS.1 } else { ALIKE_RAMPS.0 };
    let found = runs.iter().map(|(segment, runs)| (*segment, pairs(runs, alike)));
    let Some((segment, ramps)) = found.rev().max_by_key(|(_, ramps)| ramps.len()) else {
        return Err(none());
    };
    let answer = if of_pv { &segment.pv } else { &segment.vp };
    let (Some(first), Some(last), Some(vp)) = (ramps.first(), ramps.last(), answer) else {
        return Err(none());
    };
    let part = |x: &[f64]| x[first.from..last.to].to_vec();
    let ramped = Ramped { op: part(&segment.op), vp: part(vp), dt: segment.sample_time };
    let at = |k: usize| segment.from + k as f64 * segment.sample_time;
    let (from_s, to_s) = (at(first.from), at(last.to));
    let mut found = Signature {
        class: VerdictClass::CannotTell,
        s: None,
        j: None,
        op: [min(&ramped.op), max(&ramped.op)],
        vp: [min(&ramped.vp), max(&ramped.vp)],
        characteristic: None,
        offset: 0.0,
        places: vec![],
        binds: None,
        ramps: ramps.len(),
        from_s,
        to_s,
        reasons: vec![],
        known_by: KnownBy::default(),
        recorded: around(&grid, from_s, to_s),
    };
    if of_pv {
        ramps::measure(&ramped.op, &ramped.vp, ramped.dt, &mut found);
        found.reasons = [reasons(&found), found.reasons].concat();
        return Ok(found);
    }
    let ramped = ramped.thinned(MOST_SAMPLES);
    if found.vp[1] - found.vp[0] < STILL * (found.op[1] - found.op[0]) {
        found.class = VerdictClass::DoesNotRespond;
    } else if ramped.separates_lag() {
        ramped.measure(&mut found);
    }
    found.reasons = reasons(&found);
    Ok(found)
}

/// The signature that is the test of a recording; `None` if it has a test with turns, or no slow ramps.
pub fn by_ramps(recording: &Recording, grid: &GridOptions) -> Option<Signature> {
    let mut found = signature(recording, grid).ok()?;
    let of_pv = found.characteristic.is_some();
    let by_hand = ByHand::of(recording);
    let is_ramped = by_hand.as_ref().is_some_and(|by_hand| is_ramped(by_hand, &found));
    let is_test =
        |by_hand: &ByHand| by_hand.is_test() && !by_hand.is_staircase() && !(of_pv && is_ramped);
    if by_hand.as_ref().is_some_and(is_test) {
        return None;
    }
    // Ramps of the PV are found by the mode only.
    if of_pv || is_ramped && by_hand.is_some_and(|of| of.known_by == KnownBy::Mode) {
        found.known_by = KnownBy::Mode;
    }
    Some(found)
}

/// Whether most of the OP's travel by hand is in the ramps. A turn begins a little before its ramp is recognised.
fn is_ramped(by_hand: &ByHand, ramps: &Signature) -> bool {
    let before = ramps.from_s - 0.1 * (ramps.to_s - ramps.from_s);
    let travel = |two: &[Set]| Some((two[1].at_s, (two[1].op? - two[0].op?).abs()));
    let moves: Vec<(f64, f64)> = by_hand.sets.windows(2).filter_map(travel).collect();
    let inside = moves.iter().filter(|(at_s, _)| (before..=ramps.to_s).contains(at_s));
    2.0 * inside.map(|(_, travel)| travel).sum::<f64>()
        >= moves.iter().map(|(_, travel)| travel).sum::<f64>()
}

impl From<Signature> for TestReading {
    /// The signature as the result of a test without turns. Ramps that decided were right in all simulated tests.
    fn from(found: Signature) -> Self {
        let (clear, [low, high]) = (found.class == VerdictClass::DoesNotStick, BORNE_OUT);
        let probability = match found.class {
            VerdictClass::CannotTell => 0.5,
            _ if clear => low,
            _ => high,
        };
        Self {
            class: found.class,
            probability,
            by_test: probability,
            s: found.s.filter(|_| !clear),
            j: found.j.filter(|_| !clear),
            s_below: found.s.filter(|_| clear).map(|s| s.high),
            known_by: found.known_by,
            by_position: found.characteristic.is_none(),
            from_s: found.from_s,
            to_s: found.to_s,
            turned: found.ramps,
            reasons: found.reasons,
            recorded: found.recorded,
            ..Self::default()
        }
    }
}

/// The samples of a segment in manual, by the mode of its recording: each time in manual by itself.
fn in_manual(recording: &Recording, segment: &Segment) -> Vec<Range<usize>> {
    let Some(modes) = &recording.mode else { return vec![] };
    let is_manual = |t: f64| {
        let last = modes.time.partition_point(|time| *time <= t).checked_sub(1);
        last.is_some_and(|last| modes.modes[last] == Mode::Manual)
    };
    let manual: Vec<bool> = segment.times().into_iter().map(is_manual).collect();
    let mut from = 0;
    let parts = manual.chunk_by(|a, b| a == b).filter_map(|part| {
        let range = from..from + part.len();
        from = range.end;
        part[0].then_some(range)
    });
    parts.collect()
}

fn none() -> Abstention {
    Abstention(format!(
        "the recording has no slow ramp of the OP up and down over {LEAST_TRAVEL} % or more; give the recording of a ramp, \
         with several samples per percent"
    ))
}

/// Ramps in a part of an OP.
fn runs(op: &[f64], part: Range<usize>) -> Vec<Run> {
    let (begin, op) = (part.start, &op[part]);
    let mut ends = vec![];
    let (mut extreme, mut direction) = (0, 0.0f64);
    for k in 1..op.len() {
        let away = op[k] - op[extreme];
        if direction == 0.0 && away.abs() > BACK {
            ends.push(extreme);
            (direction, extreme) = (away.signum(), k);
        } else if direction != 0.0 && away * direction > 0.0 {
            extreme = k;
        } else if direction != 0.0 && -away * direction > BACK {
            ends.push(extreme);
            (direction, extreme) = (-direction, k);
        }
    }
    ends.push(extreme);
    let run = |two: &[usize]| {
        let (a, b) = (two[0], two[1]);
        let travel = op[b] - op[a];
        // Without the holds at its ends.
        let leaves = |k: &usize| (op[*k] - op[a]) / travel > 0.01;
        let from = (a..=b).find(leaves)?.saturating_sub(1);
        let reaches = |k: &usize| (op[*k] - op[a]) / travel > 0.99;
        let to = (from..=b).find(reaches)? + 1;
        let steps = op[from..to].windows(2).map(|two| (two[1] - two[0]).abs());
        let slow = steps.fold(0.0, f64::max) <= STEP * travel.abs() && to - from >= FEWEST;
        let span = travel.abs();
        let (from, to) = (begin + from, begin + to);
        (slow && span >= LEAST_TRAVEL).then_some(Run { rising: travel > 0.0, span, from, to })
    };
    ends.windows(2).filter_map(run).collect()
}

/// The longest series of ramps that alternate, each with a span `alike` to the last; empty without two.
fn pairs(runs: &[Run], alike: f64) -> &[Run] {
    let next = |a: &Run, b: &Run| {
        let ratio = a.span / b.span;
        a.rising != b.rising && (1.0 / alike..alike).contains(&ratio)
    };
    let series = runs.chunk_by(next).filter(|series| series.len() > 1);
    series.rev().max_by_key(|series| series.len()).unwrap_or_default()
}

/// OP and VP of the ramps.
struct Ramped {
    op: Vec<f64>,
    vp: Vec<f64>,
    dt: f64,
}

/// A valve with its lag, s, and its bands, percent.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// S - J.
    width: f64,
    j: f64,
    lag: f64,
}

/// The errors of a valve.
struct Errors {
    /// Mean of the simulated stem minus VP.
    offset: f64,
    /// Sums of squares in each part of the stroke.
    places: Vec<f64>,
}

impl Errors {
    fn all(&self) -> f64 {
        self.places.iter().sum()
    }
}

impl Candidate {
    fn s(self) -> f64 {
        self.width + self.j
    }

    fn scaled(self, by: f64) -> Self {
        Self { width: by * self.width, j: by * self.j, ..self }
    }
}

impl Ramped {
    fn thinned(&self, most: usize) -> Self {
        let every = self.op.len().div_ceil(most).max(1);
        let some = |x: &[f64]| x.iter().step_by(every).copied().collect();
        Self { op: some(&self.op), vp: some(&self.vp), dt: self.dt * every as f64 }
    }

    /// The part of the stroke of each sample after the stem has begun to move, while it is off its ends.
    fn places(&self, [low, high]: [f64; 2]) -> Vec<Option<usize>> {
        let clear = (4.0 * noise_std(&self.vp)).max(0.1);
        let moved = |vp: &f64| (vp - self.vp[0]).abs() > clear;
        let begins = self.vp.iter().position(moved).unwrap_or(self.vp.len());
        let place = |(k, vp): (usize, &f64)| {
            let inside = k >= begins && low + clear < *vp && *vp < high - clear;
            let place = (PLACES as f64 * (vp - low) / (high - low)) as usize;
            inside.then_some(place.min(PLACES - 1))
        };
        self.vp.iter().enumerate().map(place).collect()
    }

    /// The errors of a valve in these parts of the stroke; `None` if its bands are invalid.
    fn errors(&self, of: Candidate, places: &[Option<usize>]) -> Option<Errors> {
        let mut valve = Model::TwoPhase.build(Bands::from_s_j(of.s(), of.j).ok()?).ok()?;
        valve.restart(Start::at_rest(self.op[0]));
        let keep = if of.lag > 0.0 { (-self.dt / of.lag).exp() } else { 0.0 };
        let mut late = self.op[0];
        let stem: Vec<f64> = self
            .op
            .iter()
            .map(|op| {
                late = keep * late + (1.0 - keep) * valve.step(*op);
                late
            })
            .collect();
        let used = || {
            stem.iter().zip(&self.vp).zip(places).filter_map(|(at, place)| Some((at, (*place)?)))
        };
        let (x, y): (Vec<f64>, Vec<f64>) = used().map(|((x, vp), _)| (*x, *vp)).unzip();
        let of = line(&x, &y);
        let mut each = vec![0.0; PLACES];
        for ((x, vp), place) in used() {
            each[place] += (vp - of.at(*x)).powi(2);
        }
        Some(Errors { offset: mean(&x) - mean(&y), places: each })
    }

    /// The likeliest valve of a coarse grid.
    fn searched(&self, ends: [f64; 2]) -> Option<Candidate> {
        let places = self.places(ends);
        let most = UP_TO * (max(&self.op) - min(&self.op));
        let steps = ((most / FROM).ln() / RATIO.ln()).ceil().max(0.0) as i32;
        let bands: Vec<f64> =
            [0.0].into_iter().chain((0..steps).map(|k| FROM * RATIO.powi(k))).collect();
        let mut best: Option<(f64, Candidate)> = None;
        for width in &bands {
            for j in &bands {
                for lag in LAGS {
                    let of = Candidate { width: *width, j: *j, lag };
                    let Some(errors) = self.errors(of, &places) else { continue };
                    if best.is_none_or(|(least, _)| errors.all() < least) {
                        best = Some((errors.all(), of));
                    }
                }
            }
        }
        Some(best?.1)
    }

    /// The likeliest valve near a given valve.
    fn refined(&self, near: Candidate, places: &[Option<usize>]) -> Candidate {
        let all = |of: Candidate| self.errors(of, places).map_or(f64::INFINITY, |of| of.all());
        let (mut best, mut least) = (near, all(near));
        for round in 0..ROUNDS {
            let step = FIRST_STEP * 0.75f64.powi(round) / f64::from(AROUND);
            let set: [fn(Candidate, f64) -> Candidate; 3] = [
                |of, by| Candidate { width: (of.width + by * of.width.max(FROM)).max(0.0), ..of },
                |of, by| Candidate { j: (of.j + by * of.j.max(FROM)).max(0.0), ..of },
                |of, by| Candidate { lag: (of.lag + by * of.lag.max(0.5)).max(0.0), ..of },
            ];
            for moved in set {
                let centre = best;
                for k in -AROUND..=AROUND {
                    let next = moved(centre, f64::from(k) * step);
                    let sum = all(next);
                    if sum < least {
                        (best, least) = (next, sum);
                    }
                }
            }
        }
        best
    }

    fn measure(&self, found: &mut Signature) {
        let Some(near) = self.thinned(SEARCHED).searched(found.vp) else { return };
        let places = self.places(found.vp);
        let best = self.refined(near, &places);
        found.places = self.along(best, &places, found.vp);
        found.binds = binds(&found.places);
        match found.binds {
            // The stroke on either side of it shows the usual S and J.
            Some([from, to]) => {
                let step = (found.vp[1] - found.vp[0]) / PLACES as f64;
                let usual = |k: usize| {
                    let middle = found.vp[0] + step * (k as f64 + 0.5);
                    !(from..to).contains(&middle)
                };
                let others: Vec<Option<usize>> =
                    places.iter().map(|place| place.filter(|k| usual(*k))).collect();
                let best = self.refined(best, &others);
                found.places = self.along(best, &places, found.vp);
                self.size(found, best, &others);
            }
            None => self.size(found, best, &places),
        }
        found.class = match found.s {
            // Steps of the archive look like those of a stem.
            Some(s) if s.high > SMALL && s.value < RESOLVED * self.resolution() => {
                VerdictClass::CannotTell
            }
            Some(s) if s.low > SMALL || found.binds.is_some() => VerdictClass::Sticks,
            Some(s) if s.high < 2.0 * SMALL => VerdictClass::DoesNotStick,
            _ => VerdictClass::CannotTell,
        };
    }

    /// Whether the OP pauses on its way or has several rates. On a single steady ramp a late stem looks like a dead band.
    fn separates_lag(&self) -> bool {
        let (low, high) = (min(&self.op), max(&self.op));
        let edge = 0.05 * (high - low);
        let inside = |op: f64| low + edge < op && op < high - edge;
        let ways = self.op.windows(2).filter(|two| inside(two[0]));
        let steps: Vec<f64> = ways.map(|two| (two[1] - two[0]).abs()).collect();
        // An OP that is rounded, or made by hand, rests and steps in turn.
        quantile(&steps, 0.9) > 1.5 * quantile(&steps, 0.05)
    }

    /// The resolution of the recorded position, percent: its smallest change, large if it is archived in steps, or on change
    /// only. Such steps are alike, but for the travel of the OP in a sample; the jumps of a stem are not.
    fn resolution(&self) -> f64 {
        let change = |of: &[f64]| -> Vec<f64> {
            of.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|step| *step > 1e-9).collect()
        };
        let steps = change(&self.vp);
        let (least, most) = (quantile(&steps, 0.1), quantile(&steps, 0.9));
        let alike = LIKE_STEPS * least + 2.0 * quantile(&change(&self.op), 0.9);
        if most <= alike { least } else { 0.0 }
    }

    /// S in each part of the stroke, with the J over S of this valve.
    fn along(&self, of: Candidate, places: &[Option<usize>], [low, high]: [f64; 2]) -> Vec<Place> {
        let base = if of.s() > FROM { of } else { Candidate { width: FROM, j: 0.0, ..of } };
        let most = (MOST.ln() / FINE.ln()).ceil() as i32;
        let scaled: Vec<(f64, Errors)> = (-most..=most)
            .map(|k| base.scaled(FINE.powi(k)))
            .chain([base.scaled(0.0)])
            .filter_map(|of| Some((of.s(), self.errors(of, places)?)))
            .collect();
        let step = (high - low) / PLACES as f64;
        let place = |k: usize| {
            let n = places.iter().filter(|place| **place == Some(k)).count();
            let of = |tried: &&(f64, Errors)| tried.1.places[k];
            let least = scaled.iter().min_by(|a, b| of(a).total_cmp(&of(b)))?;
            let near = scaled.iter().filter(|tried| likely(n, of(tried), of(&least)));
            let values: Vec<f64> = near.map(|(s, _)| *s).collect();
            let s =
                Estimate { value: least.0, low: min(&values) / FINE, high: max(&values) * FINE };
            let from = low + step * k as f64;
            (n >= IN_PLACE).then_some(Place { from, to: from + step, s })
        };
        (0..PLACES).filter_map(place).collect()
    }

    /// S and J with their intervals, and the calibration error.
    fn size(&self, found: &mut Signature, best: Candidate, places: &[Option<usize>]) {
        let Some(errors) = self.errors(best, places) else { return };
        let used = places.iter().flatten().count();
        // The last value that is likely, in steps of a size that grows.
        let end = |sign: f64, of: &dyn Fn(f64) -> Candidate| -> f64 {
            let mut last = 0.0;
            for k in 0..60 {
                let away = sign * 0.02 * 1.15f64.powi(k);
                let sum = self.errors(of(away), places).map(|of| of.all());
                if !sum.is_some_and(|sum| likely(used, sum, errors.all())) {
                    break;
                }
                last = away;
            }
            last + sign * 0.02
        };
        let width = |away: f64| Candidate { width: best.width + away, ..best };
        let jump = |away: f64| Candidate { j: best.j + away, ..best };
        let (w, j) = ([end(-1.0, &width), end(1.0, &width)], [end(-1.0, &jump), end(1.0, &jump)]);
        let around = |value: f64, low: f64, high: f64, least: f64| Estimate {
            value,
            low: (value - low.max(least * best.s())).max(0.0),
            high: value + high.max(least * best.s()),
        };
        found.s = Some(around(best.s(), w[0].hypot(j[0]), w[1].hypot(j[1]), LEAST_WIDE.0));
        found.j = Some(around(best.j, j[0].abs(), j[1], LEAST_WIDE.1));
        let noise = noise_std(&self.vp);
        let steps = (12.0 * (errors.all() / used.max(1) as f64 - noise * noise).max(0.0)).sqrt();
        if steps > (4.0 * noise).max(LEAST_STEP) && steps > best.j {
            let share = STEPS_WIDE;
            found.s = Some(around(best.s(), w[0].hypot(j[0]), w[1].hypot(j[1]), share.0));
            found.j = Some(Estimate {
                value: (share.1 * steps).min(best.s()),
                low: (share.2 * steps).min(best.s()),
                high: share.3 * steps,
            });
        }
        found.offset = errors.offset;
    }
}

/// Whether a sum of squares of n samples is in the 90 % interval about the least one.
fn likely(n: usize, sum: f64, least: f64) -> bool {
    let floor = n as f64 * FLOOR * FLOOR;
    n as f64 / ALIKE * ((sum + floor) / (least + floor)).ln() < NINETY
}

/// Neighbouring parts whose S is clearly larger than elsewhere.
fn binds(places: &[Place]) -> Option<[f64; 2]> {
    let all: Vec<f64> = places.iter().map(|place| place.s.value).collect();
    let usual = median(&all);
    let clear = |place: &&Place| place.s.low > BINDS.0 * usual && place.s.low - usual > BINDS.1;
    let of: Vec<&Place> = places.iter().filter(clear).collect();
    let (first, last) = (of.first()?, of.last()?);
    Some([first.from, last.to])
}

fn interval(of: Estimate) -> String {
    format!("{} % ({} to {})", rough(of.value), rough(of.low), rough(of.high))
}

fn reasons(found: &Signature) -> Vec<String> {
    let stem = match found.characteristic {
        Some(_) => "the PV as a position",
        None => "the stem",
    };
    let mut all = vec![format!(
        "the OP was ramped {} times between {} and {} %, and {stem} moved between {} and {} %",
        found.ramps,
        rough(found.op[0]),
        rough(found.op[1]),
        rough(found.vp[0]),
        rough(found.vp[1])
    )];
    if let Some(s) = found.s {
        all.push(format!(
            "the OP travels {} between a stop of the stem and its next move in the other direction, which is S",
            interval(s)
        ));
    }
    if let Some(j) = found.j {
        all.push(match j.low > 0.0 {
            true => format!("the stem moves in jumps of {}", interval(j)),
            false => "no jumps of the stem can be distinguished".to_owned(),
        });
    }
    let binding = found.binds.and_then(|[from, to]| {
        let inside = found.places.iter().filter(|place| place.from >= from && place.to <= to);
        let s = inside.map(|place| place.s).max_by(|a, b| a.value.total_cmp(&b.value))?;
        Some((from, to, s))
    });
    if let Some((from, to, s)) = binding {
        all.push(format!(
            "the stem binds between {} and {} % of its stroke, where S is up to {}",
            rough(from),
            rough(to),
            interval(s)
        ));
    }
    if found.offset.abs() > 1.0 {
        let side = if found.offset > 0.0 { "below" } else { "above" };
        all.push(format!(
            "the stem stands {} % {side} the OP on average, so its calibration is wrong or the signal is offset",
            rough(found.offset.abs())
        ));
    }
    if found.class == VerdictClass::CannotTell && found.characteristic.is_none() {
        all.push(
            match found.s {
                None => {
                    "S cannot be distinguished from a lag of the stem on this ramp; pause on the way, as in the plan of stiction test plan \
                     --signature, and record more samples"
                }
                Some(_) => {
                    "the recording does not resolve S; record the position with finer steps and without compression, and \
                     repeat the ramp"
                }
            }
            .to_owned(),
        );
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channel;
    use stiction_model::closed_loop::NormalStream;

    /// The planned ramps over a valve with this S at each stem position, J half of it, this lag and noise.
    fn ramped(s: impl Fn(f64) -> f64, lag: f64, noise: f64, offset: f64) -> Recording {
        made(Model::TwoPhase, s, 0.5, lag, noise, offset)
    }

    /// The same with a valve model, and J as a share of S.
    fn made(
        kind: Model,
        s: impl Fn(f64) -> f64,
        share: f64,
        lag: f64,
        noise: f64,
        offset: f64,
    ) -> Recording {
        let plan = signature_plan("XV1", [0.0, 100.0]).unwrap();
        let dt = 0.5;
        let (mut op, mut at) = (vec![], plan.from_op);
        for ramp in &plan.ramps {
            let n = (ramp.duration_s / dt) as usize;
            op.extend((1..=n).map(|k| at + (ramp.to_op - at) * k as f64 / n as f64));
            op.extend(vec![ramp.to_op; (ramp.hold_s / dt) as usize]);
            at = ramp.to_op;
        }
        let build = |s: f64| kind.build(Bands::from_s_j(s, share * s).unwrap()).unwrap();
        let (mut stem, mut vp, mut draws) = (50.0, vec![], NormalStream::new(3));
        let mut of = s(50.0);
        let mut valve = build(of);
        valve.restart(Start::at_rest(stem));
        let mut lagged = stem;
        for (k, op) in op.iter().enumerate() {
            if s(stem) != of {
                of = s(stem);
                valve = build(of);
                let before: f64 = if k > 0 { vp[k - 1] } else { *op };
                valve.restart(Start { op: before.max(0.0).min(*op), ..Start::at_rest(stem) });
            }
            stem = valve.step(*op).clamp(0.0, 100.0);
            lagged += (stem - lagged) * (1.0 - (-dt / lag.max(1e-6)).exp());
            vp.push(lagged - offset + noise * draws.draw());
        }
        let mut recording = Recording::regular("XV1", dt, &op, None, None).unwrap();
        recording.vp = Some(Channel::new("VP", recording.op.time.clone(), vp).unwrap());
        recording
    }

    fn found(recording: &Recording) -> Signature {
        signature(recording, &GridOptions::default()).unwrap()
    }

    #[test]
    fn s_and_j_are_those_of_the_valve() {
        for (s, lag, noise, offset) in [
            (4.0, 0.0, 0.0, 0.0),
            (4.0, 1.5, 0.05, 2.0),
            (1.5, 1.0, 0.02, 0.0),
            (9.0, 0.5, 0.1, -3.0),
        ] {
            let found = found(&ramped(|_| s, lag, noise, offset));
            assert_eq!(found.class, VerdictClass::Sticks, "{found:?}");
            let (of_s, of_j) = (found.s.unwrap(), found.j.unwrap_or_else(|| panic!("{found:?}")));
            assert!((of_s.value / s - 1.0).abs() < 0.06, "S {s}: {of_s:?}");
            assert!(of_s.low < s && s < of_s.high, "S {s}: {of_s:?}");
            assert!((of_j.value / (0.5 * s) - 1.0).abs() < 0.15, "J {}: {of_j:?}", 0.5 * s);
            assert!((found.offset - offset).abs() < 0.3, "{}", found.offset);
            assert_eq!((found.ramps, found.binds), (4, None));
        }
    }

    /// Stems that rest again after a slip, and stems that slide on, with random friction, lag, noise and calibration.
    #[test]
    fn intervals_hold_the_true_s_and_j() {
        let (mut held, n) = ([0, 0], 12);
        for seed in 0..n {
            let mut draws = NormalStream::new(100 + seed);
            let mut uniform = |low: f64, high: f64| {
                low + (high - low) * (0.5 + 0.28 * draws.draw()).clamp(0.0, 1.0)
            };
            let s = uniform(0.0, 1.0).exp2() * 1.5 + uniform(0.0, 3.0);
            let (share, lag, noise) = (uniform(0.1, 1.0), uniform(0.0, 3.0), uniform(0.0, 0.1));
            let kind = if seed % 2 == 0 { Model::TwoPhase } else { Model::He };
            let found = found(&made(kind, |_| s, share, lag, noise, 1.0));
            let (of_s, of_j) = (found.s.unwrap(), found.j.unwrap());
            held[0] += usize::from(of_s.low <= s && s <= of_s.high);
            held[1] += usize::from(of_j.low <= share * s && share * s <= of_j.high);
            assert!(
                (of_s.value / s - 1.0).abs() < 0.15,
                "{kind:?} {s} {share} {lag} {noise}: {found:?}"
            );
        }
        assert!(held.iter().all(|held| *held >= 9), "{held:?} of {n}");
    }

    #[test]
    fn a_stem_that_follows_late_does_not_stick() {
        for lag in [0.0, 1.0, 3.0] {
            let found = found(&ramped(|_| 0.0, lag, 0.05, 0.5));
            assert_eq!(found.class, VerdictClass::DoesNotStick, "{found:?}");
            assert!(found.s.unwrap().value < 0.1, "{found:?}");
        }
    }

    #[test]
    fn packing_that_binds_at_one_place_is_found_there() {
        let s = |stem: f64| if (55.0..75.0).contains(&stem) { 6.0 } else { 1.5 };
        let found = found(&ramped(s, 0.5, 0.05, 0.0));
        let [from, to] = found.binds.unwrap();
        assert!((45.0..66.0).contains(&from) && (65.0..86.0).contains(&to), "{found:?}");
        assert_eq!(found.class, VerdictClass::Sticks);
    }

    #[test]
    fn a_stuck_stem_does_not_respond() {
        let mut stuck = ramped(|_| 0.0, 0.0, 0.05, 0.0);
        stuck.vp.as_mut().unwrap().values.iter_mut().for_each(|v| *v = 40.0 + 0.01 * *v);
        assert_eq!(found(&stuck).class, VerdictClass::DoesNotRespond);
    }

    #[test]
    fn one_rate_is_enough_with_pauses() {
        let both = ramped(|_| 3.0, 2.0, 0.02, 0.0);
        let first = both.part(0.0, 1005.0, 0.0).unwrap();
        let one = found(&first).s.unwrap();
        assert!(one.low < 3.0 && 3.0 < one.high, "{one:?}");
        // On one steady ramp without pauses a lag has the same effect as a dead band.
        let up = |k: usize| if k < 800 { k } else { 1600 - k } as f64;
        let op: Vec<f64> = (0..1600).map(|k| 10.0 + 0.1 * up(k)).collect();
        let mut valve = Model::TwoPhase.build(Bands::from_s_j(4.0, 2.0).unwrap()).unwrap();
        valve.restart(Start::at_rest(op[0]));
        let vp: Vec<f64> = op.iter().map(|op| valve.step(*op)).collect();
        let mut steady = Recording::regular("XV1", 1.0, &op, None, None).unwrap();
        steady.vp = Some(Channel::new("VP", steady.op.time.clone(), vp).unwrap());
        assert_eq!(found(&steady).class, VerdictClass::CannotTell, "{:?}", found(&steady));
    }

    /// A healthy valve whose position is archived when it has changed by a deadband, held in between.
    #[test]
    fn steps_of_an_archive_accuse_no_valve() {
        for deadband in [0.3, 0.5, 1.0, 2.0] {
            let mut healthy = ramped(|_| 0.0, 1.0, 0.02, 0.0);
            let mut kept = f64::NAN;
            for vp in &mut healthy.vp.as_mut().unwrap().values {
                if (*vp - kept).abs() < deadband {
                    *vp = kept;
                }
                kept = *vp;
            }
            let found = found(&healthy);
            assert_ne!(found.class, VerdictClass::Sticks, "{deadband}: {found:?}");
        }
        // A clean position that moves in jumps, which are not alike, is that of a stem.
        let jumps = made(Model::He, |vp| 3.0 + (vp / 4.0).sin().round(), 0.5, 0.0, 0.0, 0.0);
        assert_eq!(found(&jumps).class, VerdictClass::Sticks, "{:?}", found(&jumps));
        // Rounded, a valve that sticks by more than the steps still does.
        let mut rounded = ramped(|_| 5.0, 1.0, 0.02, 0.0);
        rounded.vp.as_mut().unwrap().values.iter_mut().for_each(|vp| *vp = vp.round());
        assert_eq!(found(&rounded).class, VerdictClass::Sticks, "{:?}", found(&rounded));
    }

    #[test]
    fn what_is_no_ramp_is_refused() {
        let refused = |of: &Recording| signature(of, &GridOptions::default()).unwrap_err().0;
        let good = ramped(|_| 3.0, 0.0, 0.0, 0.0);
        let blind = Recording { vp: None, ..good.clone() };
        assert!(refused(&blind).contains("needs the valve position or the PV"));
        let mut steps = good.clone();
        steps.op.values.iter_mut().for_each(|op| *op = 25.0 * (*op / 25.0).round());
        assert!(refused(&steps).contains("no slow ramp"));
        assert!(refused(&good.part(0.0, 500.0, 0.0).unwrap()).contains("no slow ramp"));
        assert!(
            signature_plan("XV1", [40.0, 45.0]).is_err()
                && signature_plan("XV1", [f64::NAN, 45.0]).is_err()
        );
    }
}
