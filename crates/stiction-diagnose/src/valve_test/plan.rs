//! The test of a loop, sized from its recording.
//!
//! # The test
//! With the controller in manual, the OP alternates around its value before the test.
//!
//! 1. **Grow.** Two turns of each size, each size 1.6 times the last or more, until the PV follows four turns of one size. A
//!    turn ends when the PV has answered, but not before [`LEAST_HELD`] of the hold, and at the latest after the hold. The hold grows with each size, by half if no
//!    period of the loop is known, because the speed of the process is unknown then. If operation gives S as a number, the
//!    first size is a third of it.
//! 2. **Shrink.** From there, two turns of each size follow. Each size is 0.85 times the last, and each turn is held
//!    twice as long as the PV took to respond. This part ends when the PV has not answered three sizes in a row.
//!
//! The test ends after [`TIME`] in manual or after [`HOLDS`] first holds, whichever is longer, after a [`SHIFT`] at the
//! latest, or after the time that the user gives. If time is short, the sizes grow in larger steps, and if that does
//! not suffice, the first size is larger, so that the first part fits into this time.
//!
//! If the PV moves far with a turn, the next turn follows at once. If the PV drifts away although the OP should bring it back,
//! the operator moves the OP further in the same direction. The centre of the turns moves by the same amount. An inconclusive test is followed by another ([`TestPlan::again`]).
//! It begins at 0.6 times the size that the PV answered and makes more turns of each size.
//!
//! A sticking valve does not follow a turn smaller than S. So S lies between the last answered turn and the first one
//! without an answer. The alternation cancels a drifting load and keeps an integrating process near its start.
//!
//! ```text
//! u(i) = u0 + (-1)^i t(i) / 2
//! ```
//!
//! # Limits
//! The PV range that the process tolerates is unknown. Unless the user gives limits, the PV stays within the recorded
//! range, widened by a quarter of it on either side. The OP must drive this valve, so test the inner loop of a cascade.
//!
//! # Sources
//! Ours. The alternation resembles the relay test of K. J. Astrom and T. Hagglund, "Automatic tuning of simple
//! regulators with specifications on phase and amplitude margins", Automatica 20 (1984) 645 (recalled, not read).

use super::read::{FEWEST, LARGE, ReadOptions, TestReading, read};
use super::short::holds;
use crate::diagnose::{Diagnosis, Estimate, VerdictClass};
use crate::finding::Abstention;
use crate::identify::controller::{self, FittedController};
use crate::recording::{ByHand, Recording, Segment};
use crate::series::{max, mean, min, noise_std, quantile, span};
use crate::spoken::{counted, range, rough, time};

/// Inputs to a plan in addition to the recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlanOptions {
    /// Whether the PV rises when the OP rises. By default it follows from the controller action.
    pub rises: Option<bool>,
    /// The allowed range of the PV, in its units.
    pub pv_allowed: Option<[f64; 2]>,
    /// The longest time in manual, s. By default it is 20 min, or 40 first holds if that is longer, but 8 h at most.
    pub time_s: Option<f64>,
}

/// A turn of the OP in the plan of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct Turn {
    /// The OP relative to the OP before the test, percent of span.
    pub op: f64,
    /// The longest hold after the turn, s.
    pub hold_s: f64,
}

/// The plan of a valve test, with sizes for one loop.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct TestPlan {
    /// Tag of the loop.
    pub name: String,
    /// Unit of the PV, if known.
    pub pv_unit: Option<String>,
    /// Number of turns of each size.
    pub each: usize,
    /// The turns of the first part, in order. The first part ends when the PV responds.
    pub grow: Vec<Turn>,
    /// Factor from one size of the second part to the next size.
    pub shrink_by: f64,
    /// Number of consecutive sizes without a response after which the second part ends.
    pub ends_after: usize,
    /// The PV change that counts as a response, in PV units.
    pub answer: f64,
    /// Whether the PV rises when the OP rises; `None` if the recording does not show the direction.
    pub rises: Option<bool>,
    /// PV below which the controller goes back to automatic, in PV units.
    pub pv_low: f64,
    /// PV above which the controller goes back to automatic, in PV units.
    pub pv_high: f64,
    /// The lowest OP of the test, percent.
    pub op_low: f64,
    /// The highest OP of the test, percent.
    pub op_high: f64,
    /// The longest permitted sample interval of OP and PV, s, without compression.
    pub record_every_s: f64,
    /// The longest time in manual, s, after which the test ends.
    pub total_s: f64,
    /// The expected time in manual, s.
    #[cfg_attr(feature = "serde", serde(default))]
    pub expected_s: f64,
    /// A summary of the test.
    pub summary: String,
    /// The instructions, in order.
    pub instructions: Vec<String>,
}

impl TestPlan {
    /// The first number that no plan can have, in words; `None` if all can be. For plans that were read from a file.
    pub fn fault(&self) -> Option<String> {
        let positive = |of: f64| of.is_finite() && of > 0.0;
        let ordered = |low: f64, high: f64| low.is_finite() && high.is_finite() && low < high;
        let of_turns = (1..).zip(&self.grow).find_map(|(k, turn)| match turn {
            Turn { hold_s, .. } if !positive(*hold_s) => {
                Some(format!("the hold of turn {k} is {hold_s} s, but must be above 0"))
            }
            Turn { op, .. } if !positive(op.abs()) => {
                Some(format!("the size of turn {k} is {op} %, but must not be 0"))
            }
            _ => None,
        });
        let Self { each, ends_after, answer, shrink_by, record_every_s, .. } = self;
        of_turns.or_else(|| match () {
            () if self.grow.is_empty() => Some("it has no turns".to_owned()),
            () if *each == 0 => Some("it has 0 turns of each size".to_owned()),
            () if *ends_after == 0 => Some("it ends after 0 sizes without an answer".to_owned()),
            () if !positive(*answer) => {
                Some(format!("the answer is {answer}, but must be above 0"))
            }
            () if !(positive(*shrink_by) && *shrink_by < 1.0) => Some(format!(
                "the sizes shrink by a factor of {shrink_by}, which must be between 0 and 1"
            )),
            () if !positive(*record_every_s) => {
                Some(format!("the sample interval is {record_every_s} s, but must be above 0"))
            }
            () if !ordered(self.pv_low, self.pv_high) || !ordered(self.op_low, self.op_high) => {
                Some("a lower limit is not below its upper limit".to_owned())
            }
            () => None,
        })
    }
}

/// Turns of each size, in the first test and in a later one.
const EACH: usize = 2;
const EACH_AGAIN: usize = 4;
/// Ratio of one size to the last, in the first and in the second part.
const GROWTH: f64 = 1.6;
const SHRINK_BY: f64 = 0.85;
/// The second part ends after this many sizes without an answer.
const ENDS_AFTER: usize = 3;
/// The largest ratio, and the largest first size as a share of the largest, to which a lack of time leads.
const MOST_GROWTH: f64 = 2.6;
const MOST_FIRST: f64 = 0.2;
/// Ratio of one hold of the first part to the last, without and with a known period or response time.
const PATIENCE: f64 = 1.5;
const KNOWN_PATIENCE: f64 = 1.2;
/// The longest time in manual by default, s: a test that an operator has time for.
const TIME: f64 = 1200.0;
/// The least time for a test, in first holds: on simulated loops (seed 900) 30 decide 58 %, 40 decide 64 %, and so do all.
const HOLDS: f64 = 40.0;
/// The longest time in manual that is planned without being asked for, s.
const SHIFT: f64 = 28_800.0;
/// Ratio of the longest hold to the first.
const MOST_PATIENCE: f64 = 16.0;
/// The first turn, as a share of an S that is known.
const OF_S: f64 = 1.0 / 3.0;
/// The smallest turn, the least largest turn with and without a known S, and the largest turn, percent.
const SHORTEST: f64 = 0.4;
const LEAST_OF_KNOWN: f64 = 4.0;
const LEAST_LONGEST: f64 = LARGE;
const MOST_LONGEST: f64 = 48.0;
/// Ratio of the largest turn to the largest likely S, and to the OP range in operation.
const OVER_S: f64 = 2.8;
const OVER_RANGE: f64 = 3.0;
/// A PV change of this many standard deviations of the noise is an answer.
const ANSWERED: f64 = 4.0;
/// The least time of a turn, as a share of its hold, unless the PV goes far, and the number of samples of the test in
/// that time.
pub const LEAST_HELD: f64 = 0.3;
const LEAST_SAMPLES: f64 = 4.0;
/// The shortest hold: samples of the recording, and periods of the loop.
const SAMPLES: f64 = 8.0;
pub(crate) const PERIODS: f64 = 0.4;
/// The longest period of a loop, in integral times of its controller; a slower oscillation is that of a disturbance.
const MOST_OF_TI: f64 = 40.0;
/// The period in samples, if the loop's period is unknown.
const NO_PERIOD: f64 = 40.0;

/// The longest hold of the first turn, s. In a slower loop too few turns fit into a shift.
const LONGEST_HOLD: f64 = 1800.0;

/// Plans the test of a diagnosed loop.
///
/// # Errors
/// If the recording has no segment in automatic or no PV, if the OP or PV does not move, or if the loop is too slow.
pub fn plan(diagnosis: &Diagnosis, options: &PlanOptions) -> Result<TestPlan, Abstention> {
    let Some(segment) = diagnosis.grid.longest() else {
        let why = "the recording has no segment in automatic to size a test from";
        return Err(Abstention(why.to_owned()));
    };
    let likely = diagnosis.stiction.s.or(diagnosis.evidence.as_ref().map(|weighing| weighing.s));
    let oscillation = diagnosis.oscillation();
    let known = KnownLoop {
        name: &diagnosis.name,
        pv_unit: diagnosis.pv_unit.as_deref(),
        segment,
        s: diagnosis.stiction.s,
        likely_s: likely,
        period_s: oscillation.and_then(|(_, oscillation)| oscillation.period_s),
    };
    let mut plan = size(&known, options)?;
    let guess = diagnosis.op_range.filter(|range| range.source.is_guess());
    let note = diagnosis.notes.iter().find(|note| note.starts_with("OP is"));
    plan.instructions.extend(guess.zip(note).map(|(range, note)| {
        format!(
            "Every OP here is in percent: 0 % is {} in the recording, and 100 % is {}. Compare both values with the faceplate before the \
             test, because {note}.",
            range.low, range.high
        )
    }));
    Ok(plan)
}

/// The data that size a test.
pub(crate) struct KnownLoop<'a> {
    pub(crate) name: &'a str,
    pub(crate) pv_unit: Option<&'a str>,
    /// The loop in automatic.
    pub(crate) segment: &'a Segment,
    /// S where operation gives it as a number, percent.
    pub(crate) s: Option<Estimate>,
    /// The likely S if the valve sticks, percent.
    pub(crate) likely_s: Option<Estimate>,
    /// The period of its oscillation, s.
    pub(crate) period_s: Option<f64>,
}

/// Sizes the test of a loop; errors as [`plan()`].
pub(crate) fn size(known: &KnownLoop<'_>, options: &PlanOptions) -> Result<TestPlan, Abstention> {
    let refuse = |why: &str| Err(Abstention(why.to_owned()));
    let segment = known.segment;
    let Some(pv) = segment.pv.as_deref() else {
        return refuse("the turns of a test are sized by the PV, which must be recorded");
    };
    let (op, dt) = (&segment.op, segment.sample_time);
    let travel = quantile(op, 0.95) - quantile(op, 0.05);
    if !(span(op) > 0.0 && span(pv) > 0.0) {
        return refuse("the OP or the PV does not move");
    }
    if let Some([low, high]) = options.pv_allowed
        && !(low < high && low.is_finite() && high.is_finite())
    {
        return refuse("the lower limit of the PV is not below its upper limit");
    }
    let noise = noise_std(pv).max(0.5 * quantum(pv)).max(1e-4 * span(pv));
    if let Some(time_s) = options.time_s
        && !(time_s > 0.0 && time_s.is_finite())
    {
        return refuse("the longest time in manual is not above 0");
    }
    let longest = known.likely_s.map_or(OVER_RANGE * travel, |s| OVER_S * s.high);
    let least = if known.s.is_some() { LEAST_OF_KNOWN } else { LEAST_LONGEST };
    let longest = longest.clamp(least, MOST_LONGEST);
    let shortest = known.s.map_or(SHORTEST, |s| (OF_S * s.low).clamp(SHORTEST, longest));
    let room = (0.5 * span(pv)).max(16.0 * noise);
    let answer = (ANSWERED * noise).min(0.4 * room);
    let controller = fitted(segment);
    let most_s = controller.as_ref().and_then(|fitted| fitted.ti_s).map(|ti| MOST_OF_TI * ti.high);
    let period_s = known.period_s.map(|period| most_s.map_or(period, |most| period.min(most)));
    let hold_s = (PERIODS * period_s.unwrap_or(NO_PERIOD * dt)).max(SAMPLES * dt);
    let (long, too_long) = match period_s {
        Some(period) if PERIODS * period >= SAMPLES * dt => {
            ("The loop is slow", "the loop is too slow")
        }
        Some(_) => ("The loop was recorded slowly", "the loop was recorded too slowly"),
        None => ("The period of the loop is not known", "the loop was recorded too slowly"),
    };
    if hold_s > LONGEST_HOLD {
        return refuse(&format!(
            "{too_long} for a test within a shift, because each turn would last {} or longer. Record the valve position, \
             or make a signature of the valve at the next stop",
            time(hold_s)
        ));
    }
    let patience = if period_s.is_some() { KNOWN_PATIENCE } else { PATIENCE };
    let total_s = options.time_s.unwrap_or_else(|| TIME.max(HOLDS * hold_s).min(SHIFT));
    let mut growing = Growing {
        first: shortest,
        longest,
        growth: GROWTH,
        up_first: mean(op) < 50.0,
        hold_s,
        patience,
        each: EACH,
    };
    let fits = |growing: &Growing| growing.turns().iter().map(|turn| turn.hold_s).sum::<f64>();
    while fits(&growing) > total_s && growing.growth < MOST_GROWTH {
        growing.growth *= 1.15;
    }
    while fits(&growing) > total_s && growing.first < MOST_FIRST * longest {
        growing.first *= 1.2;
    }
    // The controller needs some of the allowed range to bring the PV back.
    let [low, high] = options.pv_allowed.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
    let (pv_low, pv_high) = match options.pv_allowed {
        Some(_) => (low + BACK * (high - low), high - BACK * (high - low)),
        None => (min(pv) - 0.5 * room, max(pv) + 0.5 * room),
    };
    let mut plan = TestPlan {
        name: known.name.to_owned(),
        pv_unit: known.pv_unit.map(str::to_owned),
        each: EACH,
        shrink_by: SHRINK_BY,
        ends_after: ENDS_AFTER,
        answer,
        rises: options.rises.or_else(|| rises_by(&controller?)),
        pv_low,
        pv_high,
        op_low: (quantile(op, 0.05) - 0.5 * longest).max(0.0),
        op_high: (quantile(op, 0.95) + 0.5 * longest).min(100.0),
        record_every_s: LEAST_HELD * hold_s / LEAST_SAMPLES,
        total_s,
        expected_s: 0.0,
        grow: growing.turns(),
        summary: String::new(),
        instructions: vec![],
    };
    plan.expect(known.likely_s.map_or(0.5 * travel, |s| s.value));
    plan.word(long);
    Ok(plan)
}

/// The recording before a test, for the plan. It is the whole recording if that part is too short or there is no test.
pub fn before_test(recording: &Recording, by_hand: Option<&ByHand>) -> Recording {
    let before =
        by_hand.and_then(|of| recording.part(f64::NEG_INFINITY, of.span_s().0, f64::INFINITY));
    before.filter(|part| part.op.time.len() >= FEWEST).unwrap_or_else(|| recording.clone())
}

impl TestPlan {
    /// The next test, if this one was carried out and is inconclusive. It begins at 0.6 times the size that the PV answered,
    /// holds each turn twice as long as the PV took, and makes more turns of each size. `None` if the recording has no
    /// test or a conclusive one.
    pub fn again(&self, recording: &Recording, by_hand: Option<ByHand>) -> Option<Self> {
        let by_hand = by_hand.or_else(|| ByHand::of(recording).filter(ByHand::is_test))?;
        let asked =
            ReadOptions { by_hand: Some(by_hand), rises: self.rises, ..ReadOptions::default() };
        match read(recording, &asked) {
            Ok(reading) if reading.class != VerdictClass::CannotTell => None,
            Ok(reading) => Some(self.after(Some(&reading))),
            Err(_) => Some(self.after(None)),
        }
    }

    /// Sets the expected time with a valve of this S: a turn that the PV answers lasts half of its hold.
    fn expect(&mut self, s: f64) {
        let each = self.each as f64;
        let size = |turn: &Turn| 2.0 * turn.op.abs();
        let answered = self.grow.iter().step_by(self.each).find(|turn| size(turn) > 1.2 * s);
        let answered = answered.unwrap_or(&self.grow[self.grow.len() - 1]);
        let before = self.grow.iter().filter(|turn| size(turn) < size(answered));
        let sizes = (size(answered) / s.max(SHORTEST)).ln() / -self.shrink_by.ln();
        let shrinking = each * (0.5 * sizes.max(0.0) + self.ends_after as f64) * answered.hold_s;
        let holds: f64 = before.map(|turn| turn.hold_s).sum();
        self.expected_s = (holds + each * answered.hold_s + shrinking).min(self.total_s);
    }

    /// Writes summary and instructions; `long` is why the holds may be long.
    fn word(&mut self, long: &str) {
        let size = |turn: &Turn| rough(2.0 * turn.op.abs());
        self.summary = format!(
            "in manual, turns of the OP up and down by {} to {} %, each held until the PV answers (at most {}), in \
             at most {}",
            size(&self.grow[0]),
            size(&self.grow[self.grow.len() - 1]),
            holds(self),
            time(self.total_s)
        );
        self.instructions = instructions(self, long);
    }

    fn after(&self, last: Option<&TestReading>) -> Self {
        let of = |seen: bool| {
            let steps = last.iter().flat_map(|last| &last.steps);
            let of = steps.filter(move |step| step.answered == seen && step.answer.is_some());
            of.filter_map(|step| step.travel).filter(|travel| *travel > 0.0)
        };
        let least = of(true).fold(f64::INFINITY, f64::min);
        let most = of(false).fold(0.0, f64::max);
        let from = if least.is_finite() { LESS * least } else { FURTHER * most };
        let longest = self.grow.iter().map(|turn| 2.0 * turn.op.abs()).fold(0.0, f64::max);
        // Without any answer S is larger than it was thought to be.
        let longest = match least.is_finite() {
            true => longest.max(2.0 * least),
            false => (2.5 * longest).min(MOST_LONGEST),
        };
        let from = from.clamp(SHORTEST, (AT_MOST * longest).max(SHORTEST));
        let first = self.grow[0];
        let (hold_s, patience) = match last.and_then(|last| last.response_s) {
            Some(response) => ((2.0 * response).max(LEAST_HOLD * first.hold_s), KNOWN_PATIENCE),
            None => (first.hold_s, PATIENCE),
        };
        let growing = Growing {
            first: from,
            longest,
            growth: GROWTH,
            up_first: first.op > 0.0,
            hold_s,
            patience,
            each: EACH_AGAIN,
        };
        let mut next = Self {
            each: EACH_AGAIN,
            grow: growing.turns(),
            record_every_s: LEAST_HELD * hold_s / LEAST_SAMPLES,
            ..self.clone()
        };
        next.expect(from / LESS);
        next.word("The holds are long");
        // What does not depend on the turns.
        next.instructions.extend(self.instructions.iter().skip(next.instructions.len()).cloned());
        next
    }

    /// The centre of turns of this size, percent: `u0`, shifted until the turns stay within the OP limits.
    pub fn centre(&self, u0: f64, size: f64) -> f64 {
        let away = 0.5 * size.min(self.op_high - self.op_low);
        u0.max(self.op_low + away).min(self.op_high - away)
    }

    /// The PV range in which the turns need no shift.
    pub fn inner(&self) -> [f64; 2] {
        let (middle, half) =
            (0.5 * (self.pv_low + self.pv_high), 0.5 * (self.pv_high - self.pv_low));
        [middle - INNER * half, middle + INNER * half]
    }
}

/// The first size of a later test, as a share of the smallest answered turn, of the largest turn without an answer, and
/// at most of the largest turn.
const LESS: f64 = 0.6;
const FURTHER: f64 = 0.8;
const AT_MOST: f64 = 0.3;
/// Smallest ratio of the hold in a later test to the hold in the first.
const LEAST_HOLD: f64 = 0.3;
/// The turns are shifted beyond this share of the limits. On simulated loops (seed 900) fewer tests are stopped than with a half.
const INNER: f64 = 0.35;

/// Share of the allowed range reserved at each end.
const BACK: f64 = 0.15;

/// The last but one size, as a share of the largest, is less than this.
const NEARLY: f64 = 0.87;

/// The first part: turns of each size from the first to the largest.
struct Growing {
    first: f64,
    longest: f64,
    /// Ratio of one size to the last, and of one hold to the last.
    growth: f64,
    patience: f64,
    up_first: bool,
    hold_s: f64,
    /// Turns of each size.
    each: usize,
}

impl Growing {
    fn turns(&self) -> Vec<Turn> {
        // The last size is not nearly the one before.
        let steps = ((NEARLY * self.longest / self.first).ln() / self.growth.ln()).ceil().max(0.0);
        let steps = steps as i32;
        let mut turns = vec![];
        for k in 0..=steps {
            let size = if k < steps { self.first * self.growth.powi(k) } else { self.longest };
            let half = two_digits(0.5 * size);
            let hold_s = two_digits(self.hold_s * self.patience.powi(k).min(MOST_PATIENCE));
            for turn in 0..self.each {
                let up = (turn % 2 == 0) == self.up_first;
                turns.push(Turn { op: if up { half } else { -half }, hold_s });
            }
        }
        turns
    }
}

/// Rounded to two digits, for entry by hand.
fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

/// Samples from the middle of the recording that show the sign of the gain. More would only slow a diagnosis.
const ENOUGH_FOR_SIGN: usize = 800;

/// Whether the PV rises with the OP, from the controller action. If the controller raises the OP when the PV is too
/// low, the PV rises with the OP.
pub(super) fn rises(segment: &Segment) -> Option<bool> {
    rises_by(&fitted(segment)?)
}

fn rises_by(FittedController { kc, .. }: &FittedController) -> Option<bool> {
    (kc.low * kc.high > 0.0).then_some(kc.value > 0.0)
}

fn fitted(segment: &Segment) -> Option<FittedController> {
    let length = segment.len().min(ENOUGH_FOR_SIGN);
    controller::fit(&segment.part((segment.len() - length) / 2, length)).ok()
}

/// The smallest recorded step of a signal.
fn quantum(x: &[f64]) -> f64 {
    let steps = x.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0);
    steps.fold(f64::INFINITY, f64::min).min(span(x))
}

fn instructions(plan: &TestPlan, long: &str) -> Vec<String> {
    let [low, high] = plan.inner();
    let unit = plan.pv_unit.as_deref().map_or(String::new(), |unit| format!(" {unit}"));
    let first = plan.grow[0];
    let (up, down) = if first.op > 0.0 { ("up", "down") } else { ("down", "up") };
    let size = rough(first.op.abs());
    let with = match plan.rises {
        Some(true) => "The PV rises when the OP rises.",
        Some(false) => "The PV falls when the OP rises.",
        None => {
            "The recording does not show whether the PV rises or falls when the OP rises. Note it here."
        }
    };
    vec![
        format!(
            "Agree on the test with the operator and the shift lead. Open a trend of OP and PV with a sample every {} or \
             faster, without compression. Note each OP and its time.",
            time(plan.record_every_s)
        ),
        "Wait until the PV is steady near its set point. Put the controller in manual. Note the OP (u0) and the PV."
            .to_owned(),
        format!(
            "Part 1. Move the OP {up} to u0 {} {size} %. {with} Hold it until the PV has moved by {}{unit}, but for {} at \
             least and {} at most. Then move it {down} to u0 {} {size} % and hold this OP in the same way. The size of a turn is the whole change, here {} %.",
            if first.op > 0.0 { "+" } else { "−" },
            rough(plan.answer),
            time(LEAST_HELD * first.hold_s),
            time(first.hold_s),
            if first.op > 0.0 { "−" } else { "+" },
            rough(2.0 * first.op.abs()),
        ),
        format!(
            "Make {} of each size in the table. Hold each turn for at least {:.0} % of its longest hold. If the valve is healthy, the PV follows as soon as the answers exceed the noise. \
             If the valve sticks, the PV rests until the turns are larger than S. If the PV answers all turns of a size, make as many \
             more of that size, and note them in the empty rows. If the PV also follows these turns, note the time of the slowest answer and go to part 2.",
            counted(plan.each, "turn"),
            100.0 * LEAST_HELD
        ),
        format!(
            "Part 2. Make {} of each size again, each size {:.0} % smaller than the last. Hold each turn until the PV has \
             answered, but for {} of the noted time at least and twice that time at most. Stop when the PV has not answered {} sizes in a row.",
            counted(plan.each, "turn"),
            100.0 * (1.0 - plan.shrink_by),
            rough(2.0 * LEAST_HELD),
            plan.ends_after
        ),
        format!(
            "Keep the OP within {} %. If a turn would leave this range, shift u0 first.",
            range(plan.op_low, plan.op_high)
        ),
        format!(
            "If the PV leaves {}{unit} in the direction of a turn, make the next turn at once. If the PV leaves this range although \
             the OP should bring the PV back, move the OP further in the same direction. Begin with half a turn (in part 2, half of \
             the first turn of part 2), and double it after each hold. Shift u0 by the same amount.",
            range(low, high)
        ),
        format!(
            "Put the controller in automatic if the PV leaves {}{unit} or nears an alarm. Wait until the PV is steady, \
             then continue with the next size. After six such stops, end the test.",
            range(plan.pv_low, plan.pv_high)
        ),
        format!(
            "{}After {} in manual, end the test in any case, and put the controller in automatic. {}Read the recording with \
             stiction test read. If the test is inconclusive, plan the next test from the same recording with stiction test plan.",
            match plan.expected_s < 0.9 * plan.total_s {
                true => format!("The test takes about {}. ", roughly(plan.expected_s)),
                false => String::new(),
            },
            time(plan.total_s),
            short_of_time(plan, long)
        ),
    ]
}

/// A time in whole minutes from two minutes on.
pub(super) fn roughly(seconds: f64) -> String {
    time(if seconds < 120.0 { seconds } else { 60.0 * (seconds / 60.0).round() })
}

/// A sentence on a test that needs more than the usual time, or more than the available time; empty for other tests.
fn short_of_time(plan: &TestPlan, long: &str) -> String {
    let needed = HOLDS * plan.grow[0].hold_s;
    match () {
        () if needed > 1.1 * plan.total_s => format!(
            "In this time the loop answers about {:.0} turns, which are seldom conclusive. A test of {} would be conclusive more often than this test. ",
            plan.total_s / plan.grow[0].hold_s,
            time(needed)
        ),
        () if plan.total_s > 1.1 * TIME && plan.total_s < 1.1 * needed => {
            format!("{long}, so this test is longer than the usual {}. ", time(TIME))
        }
        () => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;
    use crate::diagnose::{Detectors, DiagnoseOptions, diagnose};
    use crate::recording::{Range, RangeSource, Recording};

    fn diagnosed(gain: f64) -> Diagnosis {
        let wave = |k: usize, phase: f64| (std::f64::consts::TAU * k as f64 / 60.0 + phase).sin();
        let op: Vec<f64> = (0..900).map(|k| 40.0 + 2.0 * wave(k, 0.0)).collect();
        let pv: Vec<f64> = (0..900).map(|k| 7.0 + gain * wave(k, 0.4)).collect();
        let recording = Recording::regular("FIC1", 2.0, &op, Some(&pv), None).unwrap();
        let options = DiagnoseOptions { detectors: Detectors::None, ..Default::default() };
        diagnose(&recording, &options).unwrap()
    }

    #[test]
    fn turns_grow_about_where_the_op_was() {
        let plan = plan(&diagnosed(1.0), &PlanOptions { rises: Some(true), ..Default::default() });
        let plan = plan.unwrap();
        let first = plan.grow[0];
        assert_eq!((first.op, plan.grow[1].op), (0.2, -0.2));
        // 0.4 of a period of 120 s.
        assert!((first.hold_s - 48.0).abs() < 3.0, "{first:?}");
        for two in plan.grow.chunks_exact(2) {
            assert!(two[0].op > 0.0 && two[1].op == -two[0].op && two[0].hold_s == two[1].hold_s);
        }
        let sizes: Vec<f64> = plan.grow.iter().step_by(2).map(|turn| 2.0 * turn.op).collect();
        // The last is cut to the longest. The steps are larger than without a time limit.
        let growth = sizes[1] / sizes[0];
        assert!((GROWTH..MOST_GROWTH).contains(&growth), "{growth}");
        assert!(
            sizes[..sizes.len() - 1].windows(2).all(|two| (two[1] / two[0] - growth).abs() < 0.1),
            "{sizes:?}"
        );
        assert!(sizes.last().unwrap() >= &LEAST_LONGEST);
        assert!(plan.op_low >= 0.0 && plan.op_high <= 100.0);
        assert_eq!(plan.instructions.len(), 9);
    }

    #[test]
    fn the_first_part_fits_into_the_time() {
        let of = |time_s: Option<f64>| {
            plan(&diagnosed(1.0), &PlanOptions { time_s, ..Default::default() }).unwrap()
        };
        let turns = |plan: &TestPlan| plan.grow.iter().map(|turn| turn.hold_s).sum::<f64>();
        let usual = of(None);
        // 40 holds of 48 s are more than 20 min.
        assert!((usual.total_s - HOLDS * usual.grow[0].hold_s).abs() < 40.0, "{}", usual.total_s);
        assert!(
            usual.instructions[8]
                .contains("The loop is slow, so this test is longer than the usual 20 min")
        );
        let (short, long) = (of(Some(900.0)), of(Some(7200.0)));
        for plan in [&usual, &short, &long] {
            assert!(turns(plan) <= plan.total_s && plan.expected_s <= plan.total_s, "{plan:?}");
        }
        assert!(short.grow.len() < usual.grow.len() && usual.grow.len() < long.grow.len());
        assert!(short.instructions[8].contains("seldom conclusive"), "{:?}", short.instructions[8]);
        // A short time does not make the loop slow.
        for plan in [&short, &long] {
            assert!(!plan.instructions[8].contains("slow"), "{:?}", plan.instructions[8]);
        }
        let held = "%, each held until the PV answers (at most ";
        assert!(usual.summary.contains(held), "{}", usual.summary);
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let options = PlanOptions { time_s: Some(wrong), ..Default::default() };
            assert!(plan(&diagnosed(1.0), &options).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_turn_that_the_sheet_allows_can_be_read() {
        let plan = plan(&diagnosed(1.0), &PlanOptions::default()).unwrap();
        let least_s = LEAST_HELD * plan.grow[0].hold_s;
        assert!(plan.instructions[2].contains(&format!("but for {} at least", time(least_s))));
        assert!(4.0 * plan.record_every_s < 1.05 * least_s, "{plan:?}");
        let reading = TestReading { response_s: Some(100.0), ..TestReading::default() };
        let slower = plan.after(Some(&reading));
        assert!(slower.record_every_s > plan.record_every_s, "{slower:?}");
    }

    #[test]
    fn a_guessed_range_of_the_op_is_on_the_sheet() {
        let mut diagnosis = diagnosed(1.0);
        let source = RangeSource::Estimated;
        diagnosis.op_range = Some(Range::new(0.0, 27648.0, source).unwrap());
        diagnosis.notes.push("OP is not in percent; give --op-range".to_owned());
        let of = |diagnosis: &Diagnosis| plan(diagnosis, &PlanOptions::default()).unwrap();
        for plan in [of(&diagnosis), of(&diagnosis).after(None)] {
            let last = &plan.instructions[9];
            assert!(last.contains("100 % is 27648") && last.contains("--op-range"), "{last}");
        }
        diagnosis.op_range.as_mut().unwrap().source = RangeSource::Given;
        assert_eq!(of(&diagnosis).instructions.len(), 9);
    }

    #[test]
    fn a_known_s_needs_neither_tiny_nor_huge_turns() {
        let diagnosis = diagnosed(1.0);
        let s = Estimate { value: 4.0, low: 3.6, high: 4.4 };
        let known = KnownLoop {
            name: "FIC1",
            pv_unit: None,
            segment: diagnosis.grid.longest().unwrap(),
            s: Some(s),
            likely_s: Some(s),
            period_s: Some(120.0),
        };
        let plan = size(&known, &PlanOptions::default()).unwrap();
        let sizes: Vec<f64> = plan.grow.iter().map(|turn| 2.0 * turn.op.abs()).collect();
        assert!((min(&sizes) - 1.2).abs() < 0.05 && (max(&sizes) - 12.0).abs() < 0.5, "{sizes:?}");
    }

    /// With Ti = 10 s an oscillation of more than 400 s is that of a disturbance.
    #[test]
    fn a_slow_disturbance_makes_no_slow_test() {
        let mut draw = NormalStream::new(4);
        let slow = |k: usize| (0.003 * k as f64).sin();
        let pv: Vec<f64> = (0..900).map(|k| 7.0 + slow(k) + 0.1 * draw.draw()).collect();
        let mut op = vec![40.0];
        for two in pv.windows(2) {
            let by = 0.5 * (two[0] - two[1]) + 0.5 * 2.0 / 10.0 * (7.0 - two[1]);
            op.push(op[op.len() - 1] + by);
        }
        let sp = vec![7.0; 900];
        let recording = Recording::regular("FIC1", 2.0, &op, Some(&pv), Some(&sp)).unwrap();
        let options = DiagnoseOptions { detectors: Detectors::None, ..Default::default() };
        let diagnosis = diagnose(&recording, &options).unwrap();
        let hold_s = |period_s: f64| {
            let segment = diagnosis.grid.longest().unwrap();
            let period_s = Some(period_s);
            let (name, pv_unit, s, likely_s) = ("FIC1", None, None, None);
            let known = KnownLoop { name, pv_unit, segment, s, likely_s, period_s };
            size(&known, &PlanOptions::default()).unwrap().grow[0].hold_s
        };
        assert!((hold_s(4000.0) / 160.0 - 1.0).abs() < 0.2, "{}", hold_s(4000.0));
        assert!((hold_s(200.0) / 80.0 - 1.0).abs() < 0.05, "{}", hold_s(200.0));
    }

    #[test]
    fn each_size_is_clearly_larger_than_the_one_before() {
        for low in [1.3, 1.7, 2.2, 2.9, 3.6, 5.0] {
            let growing = Growing {
                first: 0.4,
                longest: 2.8 * low,
                growth: GROWTH,
                patience: 1.2,
                up_first: true,
                hold_s: 30.0,
                each: EACH,
            };
            let sizes: Vec<f64> =
                growing.turns().iter().step_by(EACH).map(|turn| turn.op).collect();
            assert!(
                sizes.windows(2).all(|two| (1.14..1.9).contains(&(two[1] / two[0]))),
                "{sizes:?}"
            );
        }
    }

    #[test]
    fn turns_about_any_recorded_op_stay_within_its_limits_and_are_not_shortened() {
        let plan = plan(&diagnosed(1.0), &PlanOptions::default()).unwrap();
        let largest = plan.grow.iter().map(|turn| 2.0 * turn.op.abs()).fold(0.0, f64::max);
        for u0 in [0.0, 38.0, 40.0, 42.0, 100.0] {
            for size in [0.4, 5.0, largest] {
                let centre = plan.centre(u0, size);
                assert!(centre - 0.5 * size >= plan.op_low - 1e-9, "{u0} {size}");
                assert!(centre + 0.5 * size <= plan.op_high + 1e-9, "{u0} {size}");
            }
        }
        // The recorded OP needs no shift.
        assert_eq!(plan.centre(41.0, largest), 41.0);
    }

    #[test]
    fn limits_are_those_that_are_given() {
        let options = PlanOptions { pv_allowed: Some([4.0, 14.0]), ..Default::default() };
        let plan = plan(&diagnosed(1.0), &options).unwrap();
        assert_eq!((plan.pv_low, plan.pv_high), (5.5, 12.5));
        let wrong = PlanOptions { pv_allowed: Some([4.0, 4.0]), ..Default::default() };
        assert!(super::plan(&diagnosed(1.0), &wrong).is_err());
    }

    #[test]
    fn a_plan_that_can_be_none_is_refused() {
        let good = plan(&diagnosed(1.0), &PlanOptions::default()).unwrap();
        assert_eq!(good.fault(), None);
        for wrong in [
            TestPlan { grow: vec![], ..good.clone() },
            TestPlan { each: 0, ..good.clone() },
            TestPlan { ends_after: 0, ..good.clone() },
            TestPlan { record_every_s: -1.0, ..good.clone() },
            TestPlan { shrink_by: 1.0, ..good.clone() },
            TestPlan { shrink_by: f64::NAN, ..good.clone() },
            TestPlan { pv_low: good.pv_high, ..good.clone() },
            TestPlan { grow: vec![Turn { op: f64::NAN, hold_s: 1.0 }], ..good.clone() },
        ] {
            assert!(wrong.fault().is_some(), "{wrong:?}");
        }
    }

    #[test]
    fn what_does_not_move_has_no_test() {
        let error = plan(&diagnosed(0.0), &PlanOptions::default()).unwrap_err();
        assert!(error.0.contains("does not move"), "{error:?}");
    }
}
