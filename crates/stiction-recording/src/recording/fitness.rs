//! Whether a recording can answer.
//!
//! [`assess`] measures the quality of the data. A measure makes the data unfit only if no method is reliable; a
//! weakness of some methods is a caveat. The thresholds are ours unless a source is named; each rule gives its
//! reason.

use super::{Channel, Grid, Masked, Quality, Recording, Segment};
use crate::series::{max, mean, min, quantile, span, variance};
use crate::spoken::{counted, set, times};
use stiction_model::named;

named! {
    /// Fitness of a recording, or of one measure of it.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Class {
        /// No objection.
        Fit = "fit",
        /// Results need a caveat.
        Caveats = "caveats",
        /// The data cannot answer.
        Unfit = "unfit",
    }
}

macro_rules! measures {
    ($($id:ident = $name:literal,)*) => {
        /// The measured quantity.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum MeasureId {
            $(#[doc = concat!("Called `", $name, "`.")] $id,)*
        }

        impl MeasureId {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$id,)*];

            /// Name, such as `samples per cycle`.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$id => $name,)*
                }
            }
        }
    };
}

measures! {
    GoodValues = "good values",
    MaskedValues = "masked values",
    BridgedSamples = "bridged samples",
    DoubtfulSamples = "doubtful samples",
    InCommand = "in command",
    AutomaticSegment = "automatic segment",
    Samples = "samples",
    Cycles = "cycles",
    SamplesPerCycle = "samples per cycle",
    OpMoves = "OP moves",
    OpLevels = "OP levels",
    OpAtLimit = "OP at a limit",
    PvMoves = "PV moves",
    PvLevels = "PV levels",
    LongestFrozenPv = "longest frozen PV",
    ClippedPv = "clipped PV",
    CompressionFactor = "compression factor",
    PvUpdatesPerCycle = "PV updates per cycle",
    SetPoint = "PV explained by the set point",
    FitWindows = "fit windows",
}

/// A measure of the fitness of the data.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Measure {
    /// A short name, such as `samples per cycle`.
    #[cfg_attr(feature = "serde", serde(rename = "name"))]
    pub id: MeasureId,
    /// Value; `None` if the data do not determine the value.
    pub value: Option<f64>,
    /// Unit of value and thresholds; empty for a ratio.
    pub unit: &'static str,
    /// Limit beyond which the data have a caveat: an upper or a lower limit, depending on the measure.
    pub caveat_at: Option<f64>,
    /// Limit beyond which the data are unfit.
    pub unfit_at: Option<f64>,
    /// Class of the data by this measure.
    pub class: Class,
    /// The result of the measure in a sentence with numbers.
    pub reason: String,
}

/// Whether a recording is fit for a diagnosis, and why.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Fitness {
    /// The worst class among all measures.
    pub class: Class,
    /// Why the recording is not fit: a sentence for each bad measure, the worst first.
    pub reasons: Vec<String>,
    /// All measures of the data.
    pub measures: Vec<Measure>,
}

impl Fitness {
    /// The combined fitness of some measures.
    pub fn of(measures: Vec<Measure>) -> Self {
        let class = measures.iter().map(|m| m.class).max().unwrap_or(Class::Unfit);
        let mut worse: Vec<&Measure> = measures.iter().filter(|m| m.class != Class::Fit).collect();
        worse.sort_by_key(|m| std::cmp::Reverse(m.class));
        let reasons = worse.iter().map(|m| m.reason.clone()).collect();
        Self { class, reasons, measures }
    }
}

/// The direction in which a measure gets worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Worse {
    Less,
    More,
}

/// Unit and thresholds of a measure.
#[derive(Debug, Clone, Copy)]
struct Rule {
    id: MeasureId,
    unit: &'static str,
    worse: Worse,
    caveat: Option<f64>,
    unfit: Option<f64>,
}

impl Rule {
    const fn less(id: MeasureId, caveat: f64, unfit: Option<f64>) -> Self {
        Self { id, unit: "", worse: Worse::Less, caveat: Some(caveat), unfit }
    }

    const fn more(id: MeasureId, caveat: f64, unfit: Option<f64>) -> Self {
        Self { id, unit: "", worse: Worse::More, caveat: Some(caveat), unfit }
    }

    const fn percent(mut self) -> Self {
        self.unit = "%";
        self
    }

    /// The measure with its class by the thresholds; a caveat if it could not be measured.
    fn measure(&self, value: Option<f64>, reason: String) -> Measure {
        let beyond = |limit: Option<f64>| {
            limit.zip(value).is_some_and(|(limit, value)| match self.worse {
                Worse::Less => value < limit,
                Worse::More => value > limit,
            })
        };
        let class = if beyond(self.unfit) {
            Class::Unfit
        } else if beyond(self.caveat) || value.is_none() {
            Class::Caveats
        } else {
            Class::Fit
        };
        Measure {
            id: self.id,
            value,
            unit: self.unit,
            caveat_at: self.caveat,
            unfit_at: self.unfit,
            class,
            reason,
        }
    }
}

/// Usable samples: fewer than nine in ten may hide the pattern. The rest may still be good, so they never make the
/// data unfit.
const GOOD: Rule = Rule::less(MeasureId::GoodValues, 90.0, None).percent();
/// Values that are no measurements: from one in fifty on, as for bridged samples.
const MASKED: Rule = Rule::more(MeasureId::MaskedValues, 2.0, None).percent();
/// Bridged samples: one in fifty does not shape waves; with one in five the recording is half invented.
const BRIDGED: Rule = Rule::more(MeasureId::BridgedSamples, 2.0, Some(20.0)).percent();
/// Doubtful samples: one in twenty, by the historian itself.
const DOUBTFUL: Rule = Rule::more(MeasureId::DoubtfulSamples, 5.0, None).percent();
/// Below 200 samples, statistics of third and fourth order scatter too much; 30 are not three cycles of ten
/// samples.
const SAMPLES: Rule = Rule::less(MeasureId::Samples, 200.0, Some(30.0));
/// Thornhill, Huang & Zhang 2003 require ten cycles (recalled, not read). Fewer than three cycles may be chance.
const CYCLES: Rule = Rule::less(MeasureId::Cycles, 10.0, Some(3.0));
/// Eight samples show whether a wave is round or has corners. Below four its shape is lost, and frequencies may be
/// aliases.
const SAMPLES_PER_CYCLE: Rule = Rule::less(MeasureId::SamplesPerCycle, 8.0, Some(4.0));
/// If the PV changes less than eight times a cycle, more samples add nothing. A PV that follows a square wave does
/// that, so it never makes data unfit.
const UPDATES_PER_CYCLE: Rule = Rule::less(MeasureId::PvUpdatesPerCycle, 8.0, None);
/// With fewer than ten levels the shape has stairs; with two there is no shape.
const PV_LEVELS: Rule = Rule::less(MeasureId::PvLevels, 10.0, Some(3.0));
/// As for the PV; an OP that switches between two values still shows when it switches.
const OP_LEVELS: Rule = Rule::less(MeasureId::OpLevels, 10.0, None);
/// From a compression factor of 3, shapes and indices suffer: Thornhill, Choudhury & Shah 2004, J. Process Control
/// 14, 389-398 (recalled, not read).
const COMPRESSION: Rule = Rule::more(MeasureId::CompressionFactor, 3.0, None);
/// A PV of fewer straight lines than this shows only the interpolation of its historian.
const FEWEST_LINES: f64 = 4.0;
/// A PV that is constant for a tenth of the time may be a frozen signal. A PV that is constant for more than half of
/// the time is one.
const FROZEN: Rule = Rule::more(MeasureId::LongestFrozenPv, 10.0, Some(50.0)).percent();
/// A twentieth of the time at a limit bends the waves; with half of the time the loop is open.
const SATURATED: Rule = Rule::more(MeasureId::OpAtLimit, 5.0, Some(50.0)).percent();
/// As for the OP: a transmitter at its limit does not measure.
const CLIPPED: Rule = Rule::more(MeasureId::ClippedPv, 5.0, Some(50.0)).percent();
/// A third of the PV's variance explained by the set point: most methods assume a constant set point.
const SET_POINT: Rule = Rule::more(MeasureId::SetPoint, 33.0, None).percent();
/// Less than half of the time in automatic: the recording may be untypical of the loop.
const CLOSED: Rule = Rule::less(MeasureId::InCommand, 50.0, None).percent();
/// A signal that never moves contains no information.
const MOVES: f64 = 0.0;

/// Assesses a segment of a recording. `period` is the dominant period in samples, if the loop oscillates.
pub fn assess(
    recording: &Recording,
    grid: &Grid,
    segment: &Segment,
    period: Option<f64>,
) -> Fitness {
    let n = segment.len();
    let period = period.filter(|period| *period > 0.0);
    let mut measures = vec![
        good(recording),
        of_masked(recording),
        bridged(segment),
        doubtful(recording),
        closed(grid),
    ];
    measures.push(
        SAMPLES.measure(
            Some(n as f64),
            format!("the segment has {n} samples, {} s", segment.duration()),
        ),
    );
    measures.extend(cycles(n, period));
    measures.push(moves(MeasureId::OpMoves, "OP", &segment.op));
    if let Some(levels) = levels(&segment.op) {
        measures.push(OP_LEVELS.measure(
            Some(levels),
            format!("the OP's smallest step divides its range into {levels:.0} levels"),
        ));
    }
    measures.push(saturated(&segment.op));
    if let Some(pv) = &segment.pv {
        measures.extend(of_pv(pv, period));
        if let Some(sp) = &segment.sp {
            measures.push(set_point(pv, sp));
        }
    }
    Fitness::of(measures)
}

fn good(recording: &Recording) -> Measure {
    let share = |channel: &Channel| 100.0 * channel.usable_share();
    let op = share(&recording.op);
    match &recording.pv {
        Some(pv) => GOOD.measure(
            Some(op.min(share(pv))),
            format!("{op:.1} % of the OP's samples and {:.1} % of the PV's are usable", share(pv)),
        ),
        None => GOOD.measure(Some(op), format!("{op:.1} % of the OP's samples are usable")),
    }
}

fn of_masked(recording: &Recording) -> Measure {
    let channels = [Some(&recording.op), recording.pv.as_ref()].into_iter().flatten();
    let share = |of: &Channel| 100.0 * of.masked.len() as f64 / of.values.len().max(1) as f64;
    let value = channels.map(share).fold(0.0, f64::max);
    let reason = match Masked::words(&recording.masked_values()) {
        Some(words) => format!("values that are not measurements count as missing: {words}"),
        None => "every value may be a measurement".to_owned(),
    };
    MASKED.measure(Some(value), reason)
}

fn bridged(segment: &Segment) -> Measure {
    let share = 100.0 * segment.bridged as f64 / segment.len().max(1) as f64;
    BRIDGED.measure(
        Some(share),
        format!("{} samples ({share:.1} %) were missing and are bridged", segment.bridged),
    )
}

fn doubtful(recording: &Recording) -> Measure {
    let share = [Some(&recording.op), recording.pv.as_ref()]
        .into_iter()
        .flatten()
        .map(|channel| {
            let doubtful = channel.quality.iter().filter(|q| **q == Quality::Uncertain).count();
            100.0 * doubtful as f64 / channel.quality.len().max(1) as f64
        })
        .fold(0.0, f64::max);
    DOUBTFUL.measure(
        Some(share),
        format!("the historian marks up to {share:.1} % of a signal's samples as doubtful"),
    )
}

fn closed(grid: &Grid) -> Measure {
    let (share, parts) = (100.0 * grid.closed_share, grid.segments.len());
    CLOSED.measure(
        Some(share),
        match parts {
            1 => format!(
                "the controller was in command {share:.1} % of the time, in one usable segment"
            ),
            _ => format!(
                "the controller was in command {share:.1} % of the time, in {parts} usable segments"
            ),
        },
    )
}

fn cycles(n: usize, period: Option<f64>) -> [Measure; 2] {
    let Some(period) = period else {
        return [
            CYCLES.measure(
                None,
                "no regular cycle was found, so methods that need cycles cannot judge".to_owned(),
            ),
            // Irrelevant without cycles.
            Measure {
                class: Class::Fit,
                ..SAMPLES_PER_CYCLE.measure(None, "no regular cycle was found".to_owned())
            },
        ];
    };
    let cycles = n as f64 / period;
    [
        CYCLES.measure(Some(cycles), format!("the segment has {cycles:.1} cycles")),
        SAMPLES_PER_CYCLE.measure(Some(period), format!("a cycle has {period:.1} samples")),
    ]
}

fn moves(id: MeasureId, signal: &str, x: &[f64]) -> Measure {
    let moved = span(x);
    let rule = Rule { id, unit: "", worse: Worse::More, caveat: None, unfit: None };
    let still = !(moved > MOVES);
    let reason = if still {
        format!("the {signal} never moves")
    } else {
        format!("the {signal} moves over a range of {}", set(moved))
    };
    let class = if still { Class::Unfit } else { Class::Fit };
    Measure { class, unfit_at: Some(MOVES), ..rule.measure(Some(moved), reason) }
}

/// Number of levels: the range over the smallest step; `None` for a signal that does not move.
///
/// The smallest step is the 5 % quantile of the steps, so a few interpolated samples do not mask the resolution of the
/// signal.
pub fn levels(x: &[f64]) -> Option<f64> {
    let range = span(x);
    // Rounding of a constant signal is not a step.
    let steps: Vec<f64> =
        x.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 1e-9 * range).collect();
    (range > 0.0 && !steps.is_empty()).then(|| range / quantile(&steps, 0.05) + 1.0)
}

fn saturated(op: &[f64]) -> Measure {
    let at_limit = 100.0 * share_at_limit(op);
    SATURATED.measure(
        Some(at_limit),
        format!("the OP rests at 0 %, at 100 %, or at its extremes {at_limit:.1} % of the time"),
    )
}

/// Share of the samples in which the OP rests at a limit: runs of three or more samples at 0 %, at 100 %, or at the
/// highest or lowest value.
///
/// A value beyond 0 or 100 is not enough: some systems allow it, and some recordings contain deviations from a
/// mean.
pub fn share_at_limit(op: &[f64]) -> f64 {
    let at_end: usize = op
        .chunk_by(|a, b| a == b)
        .filter(|run| run.len() >= 3 && (run[0] == 0.0 || run[0] == 100.0))
        .map(<[f64]>::len)
        .sum();
    at_end.max(resting(op)) as f64 / op.len().max(1) as f64
}

/// Samples in runs of three or more at the largest or at the smallest value; none if the signal has so few levels that
/// such runs are common.
fn resting(x: &[f64]) -> usize {
    if levels(x).is_none_or(|levels| levels < 10.0) {
        return 0;
    }
    let (low, high) = (min(x), max(x));
    x.chunk_by(|a, b| a == b)
        .filter(|run| run.len() >= 3 && (run[0] == low || run[0] == high))
        .map(<[f64]>::len)
        .sum()
}

fn of_pv(pv: &[f64], period: Option<f64>) -> Vec<Measure> {
    let n = pv.len().max(1) as f64;
    let mut measures = vec![moves(MeasureId::PvMoves, "PV", pv)];
    if let Some(levels) = levels(pv) {
        measures.push(PV_LEVELS.measure(
            Some(levels),
            format!("the PV's smallest step divides its range into {levels:.0} levels"),
        ));
    }
    let run = pv.chunk_by(|a, b| a == b).map(<[f64]>::len).max().unwrap_or(0);
    let frozen = 100.0 * run as f64 / n;
    let in_cycles = period.map_or(String::new(), |p| format!(", {:.1} cycles", run as f64 / p));
    measures.push(FROZEN.measure(
        Some(frozen),
        format!(
            "the PV does not change for up to {}{in_cycles}, {frozen:.1} % of the segment",
            counted(run, "sample")
        ),
    ));
    let clipped = 100.0 * resting(pv) as f64 / n;
    measures.push(CLIPPED.measure(
        Some(clipped),
        format!("the PV rests at its highest or lowest value {clipped:.1} % of the time"),
    ));
    if let Some(factor) = compression_factor(pv) {
        let lines = Rule { unfit: Some(n / FEWEST_LINES), ..COMPRESSION };
        measures.push(lines.measure(
            Some(factor),
            format!("on average {factor:.1} samples lie on one straight line while the PV moves"),
        ));
    }
    if let Some(period) = period {
        let changes = pv.windows(2).filter(|w| w[0] != w[1]).count();
        let updates = changes as f64 / n * period;
        measures.push(
            UPDATES_PER_CYCLE
                .measure(Some(updates), format!("the PV changes {updates:.1} times a cycle")),
        );
    }
    measures
}

/// Samples per straight line while the signal moves: 1 for measured data, more after a historian's interpolation.
/// `None` if it hardly moves.
///
/// A sample lies on a line with its neighbours if the second difference there is below 1e-9 of the range. Samples
/// within a constant part are left out; they are stairs.
pub fn compression_factor(x: &[f64]) -> Option<f64> {
    let flat = 1e-9 * span(x);
    let (mut moving, mut bent) = (0usize, 0usize);
    for w in x.windows(3) {
        let (before, after) = (w[1] - w[0], w[2] - w[1]);
        if before.abs() > flat || after.abs() > flat {
            moving += 1;
            bent += usize::from((after - before).abs() > flat);
        }
    }
    (moving >= 10).then(|| moving as f64 / bent.max(1) as f64)
}

/// Squared correlation of PV and SP, and number of changes of the SP.
fn set_point(pv: &[f64], sp: &[f64]) -> Measure {
    let changes = sp.windows(2).filter(|w| w[0] != w[1]).count();
    let (of_pv, of_sp) = (mean(pv), mean(sp));
    let joint = pv.iter().zip(sp).map(|(p, s)| (p - of_pv) * (s - of_sp)).sum::<f64>();
    let scale = variance(pv) * variance(sp) * (pv.len() as f64).powi(2);
    let share = if changes > 0 && scale > 0.0 { 100.0 * joint * joint / scale } else { 0.0 };
    SET_POINT.measure(
        Some(share),
        format!("the set point changes {} and explains {share:.1} % of the PV", times(changes)),
    )
}

#[cfg(test)]
mod tests {
    use super::super::{GridOptions, Mode, Modes};
    use super::*;
    use crate::oscillation::test_signals::{noise, sine};

    const N: usize = 1000;

    fn op() -> Vec<f64> {
        sine(N, 40.0).iter().zip(noise(N, 1)).map(|(s, e)| 50.0 + 5.0 * s + 0.2 * e).collect()
    }

    fn pv() -> Vec<f64> {
        sine(N + 7, 40.0)[7..]
            .iter()
            .zip(noise(N, 2))
            .map(|(s, e)| 20.0 + 2.0 * s + 0.1 * e)
            .collect()
    }

    fn judged(recording: &Recording, period: Option<f64>) -> Fitness {
        let grid = Grid::of(recording, &GridOptions::default()).unwrap();
        assess(recording, &grid, grid.longest().unwrap(), period)
    }

    fn of(op: &[f64], pv: &[f64], sp: Option<&[f64]>, period: Option<f64>) -> Fitness {
        judged(&Recording::regular("loop", 1.0, op, Some(pv), sp).unwrap(), period)
    }

    /// The measures that are not fit.
    fn worse(fitness: &Fitness) -> Vec<(MeasureId, Class)> {
        let worse = fitness.measures.iter().filter(|m| m.class != Class::Fit);
        worse.map(|m| (m.id, m.class)).collect()
    }

    #[test]
    fn sound_data_are_fit() {
        let fitness = of(&op(), &pv(), Some(&[20.0; N]), Some(40.0));
        assert_eq!(worse(&fitness), []);
        assert_eq!((fitness.class, fitness.measures.len()), (Class::Fit, 18));
        assert!(fitness.reasons.is_empty());
    }

    #[test]
    fn each_measure_has_its_signal() {
        let (op, pv) = (op(), pv());
        let map = |x: &[f64], f: &dyn Fn(usize, f64) -> f64| -> Vec<f64> {
            x.iter().enumerate().map(|(k, v)| f(k, *v)).collect()
        };
        let period = Some(40.0);
        use Class::{Caveats, Unfit};
        let frozen = |from: usize| map(&pv, &|k, v| if k >= from { pv[from] } else { v });
        let interpolated = map(&pv, &|k, _| {
            let (from, share) = (k / 5 * 5, (k % 5) as f64 / 5.0);
            let to = (from + 5).min(N - 1);
            pv[from] + share * (pv[to] - pv[from])
        });
        let steps = map(&pv, &|k, _| f64::from(k / 50 % 2 == 0));
        let shifted = map(&pv, &|k, v| v + 5.0 * steps[k]);
        let cases: Vec<(Vec<(MeasureId, Class)>, Fitness)> = vec![
            (vec![(MeasureId::Cycles, Caveats)], of(&op, &pv, None, None)),
            (vec![(MeasureId::Cycles, Caveats)], of(&op, &pv, None, Some(120.0))),
            (vec![(MeasureId::Cycles, Unfit)], of(&op, &pv, None, Some(400.0))),
            (
                vec![
                    (MeasureId::SamplesPerCycle, Caveats),
                    (MeasureId::PvUpdatesPerCycle, Caveats),
                ],
                of(&op, &pv, None, Some(7.0)),
            ),
            (
                vec![(MeasureId::SamplesPerCycle, Unfit), (MeasureId::PvUpdatesPerCycle, Caveats)],
                of(&op, &pv, None, Some(3.0)),
            ),
            (
                vec![(MeasureId::Samples, Caveats), (MeasureId::Cycles, Caveats)],
                of(&op[..100], &pv[..100], None, Some(20.0)),
            ),
            (vec![(MeasureId::OpMoves, Unfit)], of(&[7.0; N], &pv, None, period)),
            (
                vec![
                    (MeasureId::PvMoves, Unfit),
                    (MeasureId::LongestFrozenPv, Unfit),
                    (MeasureId::PvUpdatesPerCycle, Caveats),
                ],
                of(&op, &[7.0; N], None, period),
            ),
            (
                vec![(MeasureId::OpLevels, Caveats)],
                of(&map(&op, &|_, v| (v / 3.0).round() * 3.0), &pv, None, period),
            ),
            (
                vec![(MeasureId::PvLevels, Caveats)],
                of(&op, &map(&pv, &|_, v| (v / 0.9).round() * 0.9), None, Some(60.0)),
            ),
            (
                vec![(MeasureId::OpAtLimit, Caveats)],
                of(&map(&op, &|_, v| v.min(54.0)), &pv, None, period),
            ),
            (
                vec![(MeasureId::OpAtLimit, Unfit)],
                of(&map(&op, &|_, v| (v - 51.0).max(0.0)), &pv, None, period),
            ),
            (
                vec![(MeasureId::ClippedPv, Caveats)],
                of(&op, &map(&pv, &|_, v| v.max(18.6)), None, period),
            ),
            (vec![(MeasureId::LongestFrozenPv, Caveats)], of(&op, &frozen(850), None, period)),
            (vec![(MeasureId::LongestFrozenPv, Unfit)], of(&op, &frozen(400), None, Some(80.0))),
            (vec![(MeasureId::CompressionFactor, Caveats)], of(&op, &interpolated, None, period)),
            (
                vec![(MeasureId::PvUpdatesPerCycle, Caveats)],
                of(&op, &map(&pv, &|k, _| pv[k / 8 * 8]), None, period),
            ),
            (vec![(MeasureId::SetPoint, Caveats)], of(&op, &shifted, Some(&steps), period)),
        ];
        for (expected, found) in cases {
            assert_eq!(worse(&found), expected, "{:?}", found.reasons);
            assert_eq!(found.reasons.len(), expected.len());
        }
    }

    #[test]
    fn a_pv_of_two_straight_lines_is_unfit() {
        let op: Vec<f64> = (0..800).map(|k| 50.0 + 3.0 * (k as f64 / 9.0).sin()).collect();
        let class = |lines: usize| {
            let length = 800 / lines;
            let pv: Vec<f64> = (0..800)
                .map(|k| (k % length).abs_diff(length / 2) as f64 + (k / length) as f64)
                .collect();
            let found = of(&op, &pv, None, None);
            found.measures.iter().find(|m| m.id == MeasureId::CompressionFactor).map(|m| m.class)
        };
        assert_eq!((class(1), class(20)), (Some(Class::Unfit), Some(Class::Caveats)));
    }

    #[test]
    fn what_is_missing_doubtful_or_open_is_reported() {
        let mut holes = pv();
        (0..N).step_by(8).for_each(|k| holes[k] = f64::NAN);
        let fitness = of(&op(), &holes, None, Some(40.0));
        assert_eq!(
            worse(&fitness),
            [(MeasureId::GoodValues, Class::Caveats), (MeasureId::BridgedSamples, Class::Caveats)]
        );
        let mut recording = Recording::regular("loop", 1.0, &op(), Some(&pv()), None).unwrap();
        recording.op.quality[..100].fill(Quality::Uncertain);
        assert_eq!(
            worse(&judged(&recording, Some(40.0))),
            [(MeasureId::DoubtfulSamples, Class::Caveats)]
        );
        recording.op.quality.fill(Quality::Good);
        recording.mode =
            Some(Modes { time: vec![0.0, 450.0], modes: vec![Mode::Automatic, Mode::Manual] });
        assert_eq!(
            worse(&judged(&recording, Some(40.0))),
            [(MeasureId::InCommand, Class::Caveats)]
        );
    }

    #[test]
    fn op_alone_can_be_fit() {
        let recording = Recording::regular("loop", 1.0, &op(), None, None).unwrap();
        assert_eq!(judged(&recording, Some(40.0)).class, Class::Fit);
    }
}
