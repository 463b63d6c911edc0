//! What a test says that was carried out.

use super::carried::{Carried, carried, same_loop};
use super::cut::cut;
use super::explain::Seen;
use super::plan::{TestPlan, rises};
use super::position::{PositionReading, position};
use super::weigh::{Manual, SMALL, Weighed, weigh};
use crate::diagnose::{Detectors, DiagnoseOptions, Diagnosis, VerdictClass, diagnose};
use crate::estimate::Estimate;
use crate::finding::Abstention;
use crate::fusion::{logit, sigmoid};
use crate::recording::{ByHand, Grid, GridOptions, KnownBy, Recording, Segment};
use crate::series::{max, median, min, noise_std, quantile, span, std};
use crate::spoken::{percent, rough, time};

/// What is known of a test before it is read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// What was set by hand, where somebody wrote it down; without it it is looked for in the recording.
    pub by_hand: Option<ByHand>,
    /// The plan that was followed.
    pub plan: Option<TestPlan>,
    /// Whether the PV rises when the OP rises; by default the action of the controller shows it, or else the test.
    pub rises: Option<bool>,
    /// How the recording is brought onto a grid.
    pub grid: GridOptions,
}

/// A turn of the OP, and what came of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Step {
    /// When the OP was set, s on the recording's clock.
    pub at_s: f64,
    /// To what, percent.
    pub op: f64,
    /// How far that was from the OP before, percent; `None` for the first of a time in manual, before which the stem may
    /// have been anywhere.
    pub travel: Option<f64>,
    /// How far the PV went with it until the next, in its units.
    pub answer: Option<f64>,
    /// Standard deviation of that.
    pub error: Option<f64>,
    /// Whether that is an answer: it goes with the turn, by more than 2.5 standard deviations.
    pub answered: bool,
}

/// What a test says of a valve.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct TestReading {
    /// `sticks`, `does not stick`, `does not respond` or `cannot tell`, by the test and by the operation before it.
    pub class: VerdictClass,
    /// That the valve sticks, by both.
    pub probability: f64,
    /// That it sticks, by the test alone.
    pub by_test: f64,
    /// That it sticks, by the recording before the test; `None` where that says nothing.
    pub by_operation: Option<f64>,
    /// Of what the test holds likely, the share of a dead band behind the valve: in the process, a linkage or the transmitter.
    pub dead_band_elsewhere: f64,
    /// Stick band plus dead band, percent of span, with its 90 % interval, if the valve sticks.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    pub s: Option<Estimate>,
    /// Slip jump, percent of span, with its 90 % interval, if the valve sticks.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    pub j: Option<Estimate>,
    /// S is below this with 95 % confidence, percent; `None` where the test sets no limit.
    #[cfg_attr(feature = "serde", serde(rename = "S_below"))]
    pub s_below: Option<f64>,
    /// Dead time and lags between OP and PV, s; `None` where no turn was answered.
    pub response_s: Option<f64>,
    /// How it is known what was set by hand: `sheet`, `mode` or `output`.
    pub known_by: KnownBy,
    /// When the test began, s on the recording's clock.
    pub from_s: f64,
    /// When it ended.
    pub to_s: f64,
    /// How often the controller took over in between.
    pub stops: usize,
    /// Whether the answers are those of the stem, whose position is recorded, and not of the PV.
    pub by_position: bool,
    /// What the position shows; `None` where it is not recorded.
    pub position: Option<PositionReading>,
    /// The turns, in order.
    pub steps: Vec<Step>,
    /// Why, in sentences.
    pub reasons: Vec<String>,
    /// What to do differently, where the test does not tell.
    pub advice: Option<String>,
    /// What was carried out of the plan, where one was given.
    pub plan: Option<Carried>,
}

impl TestReading {
    /// Whose answers are read: `PV` or `stem`.
    pub fn who(&self) -> &'static str {
        who(self.by_position)
    }

    /// The unit of the answers, where that of the PV is this: a position is in percent.
    pub fn unit<'a>(&self, pv_unit: Option<&'a str>) -> &'a str {
        if self.by_position { "%" } else { pv_unit.unwrap_or("its units") }
    }
}

/// Probability from which a valve sticks.
const SURE: f64 = 0.95;
/// How well the PV must go with a valve: correlation, and length of what it answers in standard deviations.
const FITS: f64 = 0.65;
const FITS_HEALTHY: f64 = 0.5;
const STRONG: f64 = 5.0;
/// Turns that a valve that sticks must follow, and the PV with it.
const CLEAR: usize = 2;
/// A PV that goes less than this share of what it does in operation, with an OP that goes as far, does not answer.
const SILENT: f64 = 0.06;
/// A PV that goes less than this in operation, over its noise, is never said not to answer.
const MOVES: f64 = 3.0;
/// A stem that moves by less than this with a percent of the OP does not respond.
const STILL: f64 = 0.1;
/// A valve follows if the test limits S to this share of the OP's range in operation, within bounds in percent.
const LIMIT: f64 = 0.25;
const LIMITS: (f64, f64) = (2.0, 5.0);
/// The largest limit that is told: further than a test goes, percent.
const TOLD_UP_TO: f64 = 25.0;
/// Samples of operation below which nothing is asked of it.
pub(super) const FEWEST: usize = 100;
/// Standard deviations by which an answer is seen.
const SEEN: f64 = 2.5;

/// What is known of the loop from its operation before the test; of the position in place of the PV where that is read.
struct Operation {
    rises: Option<bool>,
    pv_std: f64,
    op_range: f64,
    noise: f64,
    probability: Option<f64>,
}

/// Reads the test in a recording.
///
/// # Errors
/// If there is no test in it, or too little of it to be judged: the sentence says what is missing and what to do.
pub fn read(recording: &Recording, options: &ReadOptions) -> Result<TestReading, Abstention> {
    let by_hand = match &options.by_hand {
        Some(by_hand) => by_hand.clone(),
        None => ByHand::of(recording).ok_or_else(|| Abstention(NO_TEST.to_owned()))?,
    };
    check(&by_hand)?;
    if recording.pv.is_none() && recording.vp.is_none() {
        return Err(Abstention(
            "without a PV or a position the turns of the OP have no answer to read".to_owned(),
        ));
    }
    if let Some(plan) = &options.plan {
        plan.check()?;
    }
    if let Some(plan) = &options.plan
        && !same_loop(&plan.name, &recording.name)
    {
        return Err(Abstention(format!(
            "the plan is for loop {}, and the recording is of {}; give the plan of this loop",
            plan.name, recording.name
        )));
    }
    // Somebody else than the controller has the OP here: all is taken as it is.
    let whole = Recording { mode: None, ..recording.clone() };
    let grid = Grid::of(&whole, &options.grid).map_err(|error| Abstention(error.to_string()))?;
    let (from_s, to_s) = by_hand.span_s();
    let of_position = spells(&by_hand, &grid, |segment| segment.vp.as_deref());
    // A position that holds one value is that of a transmitter that has failed, if the PV answers.
    let by_position = recording.pv.is_none() || moves(&of_position);
    let of_pv = spells(&by_hand, &grid, |segment| segment.pv.as_deref());
    let spells = if by_position { of_position } else { of_pv.clone() };
    let operation = Operation::before(recording, from_s, options, by_position)?;
    if spells.is_empty() {
        return Err(Abstention(
            "the test lies outside the samples of the recording, or in a gap of it; give a recording that holds it"
                .to_owned(),
        ));
    }
    let manual: Vec<Manual> = spells.iter().map(|(_, manual)| manual.clone()).collect();
    let values: Vec<f64> = manual.iter().flat_map(|spell| spell.pv.iter().copied()).collect();
    if !moves(&spells) {
        return Err(Abstention(format!(
            "the {} holds one value throughout the test: it is at the end of its range or frozen, or the historian \
                 did not keep it",
            who(by_position)
        )));
    }
    let dead = shortest_hold(&manual);
    let noise = if by_position { noise_std(&values) } else { operation.noise };
    let floor = (0.4 * noise).max(drawn(&values));
    let known = options.rises.or(options.plan.as_ref().and_then(|plan| plan.rises));
    // A position rises with the OP.
    let rises = if by_position { Some(true) } else { known.or(operation.rises) };
    let signs: &[f64] = match rises {
        Some(true) => &[1.0],
        Some(false) => &[-1.0],
        None => &[1.0, -1.0],
    };
    let weighed = signs
        .iter()
        .filter_map(|sign| weigh(&manual, *sign, dead, floor, !by_position))
        .max_by(|a, b| a.log.total_cmp(&b.log));
    let weighed = weighed.ok_or_else(|| Abstention(TOO_FEW.to_owned()))?;
    let mut reading = TestReading {
        known_by: by_hand.known_by,
        from_s,
        to_s,
        stops: spells.len() - 1,
        position: by_position.then(|| position(&manual, grid.sample_time)).flatten(),
        steps: steps(&spells, &weighed),
        ..conclude(&weighed, &operation, &manual, by_position)
    };
    let step_s = grid.sample_time * weighed.response.1 as f64;
    let process = weighed.response.0;
    let lags = if process.tau.is_finite() { process.tau } else { 0.0 } + process.tau2;
    reading.response_s = (reading.steps.iter().any(|step| step.answered))
        .then_some((process.dead as f64 + lags) * step_s);
    reading.reasons = reasons(&reading, &weighed);
    reading.reasons.extend(cut(&spells));
    reading.advice = advice(&reading);
    let plan = options.plan.as_ref();
    // The limits of a plan are those of the PV.
    let compared = plan.filter(|_| !of_pv.is_empty());
    reading.plan = compared.map(|plan| carried(plan, &of_pv, &reading.steps, grid.sample_time));
    if plan.is_some() && compared.is_none() {
        reading.reasons.push(
            "the plan is not compared with what was carried out, because the recording has no PV"
                .to_owned(),
        );
    }
    Ok(reading)
}

/// That what was set by hand makes sense: times ascend, and an OP is a percentage.
fn check(by_hand: &ByHand) -> Result<(), Abstention> {
    let refuse = |why: String| Err(Abstention(why));
    for set in &by_hand.sets {
        if !set.at_s.is_finite() {
            return refuse(format!("the OP was set at {} s, which is no time", set.at_s));
        }
        if let Some(op) = set.op
            && !OP.contains(&op)
        {
            return refuse(format!("the OP was set to {op} %, which is no OP in percent of span"));
        }
    }
    match by_hand.sets.windows(2).find(|two| two[1].at_s < two[0].at_s) {
        Some(two) => refuse(format!(
            "what was set by hand at {} s comes after what was set at {} s; put it in order of time",
            two[1].at_s, two[0].at_s
        )),
        None => Ok(()),
    }
}

/// What an OP may be, percent.
const OP: std::ops::RangeInclusive<f64> = -10.0..=110.0;

const NO_TEST: &str = "there is no test in the recording: its mode shows no time in manual in which the OP was set \
                       twice, or, without a mode, the OP never goes to and fro in turns that are held; give the sheet \
                       with what was done, or a recording with the mode";
const TOO_FEW: &str = "the test cannot be judged: it needs at least two turns in one time in manual, with twelve samples of \
                       the PV that are not all alike; make more turns, or record more often";

impl Operation {
    fn before(
        recording: &Recording,
        from_s: f64,
        options: &ReadOptions,
        by_position: bool,
    ) -> Result<Self, Abstention> {
        let silent =
            Self { rises: None, pv_std: 0.0, op_range: 0.0, noise: 0.0, probability: None };
        let Some(before) = recording.part(f64::NEG_INFINITY, from_s, f64::INFINITY) else {
            return Ok(silent);
        };
        let asked = DiagnoseOptions {
            detectors: Detectors::None,
            grid: options.grid,
            ..DiagnoseOptions::default()
        };
        let Ok(diagnosis) = diagnose(&before, &asked) else { return Ok(silent) };
        let longest = diagnosis.grid.longest().filter(|segment| segment.len() >= FEWEST);
        let read = |s: &'_ Segment| if by_position { s.vp.clone() } else { s.pv.clone() };
        let Some((segment, pv)) = longest.and_then(|s| Some((s, read(s)?))) else {
            return Ok(silent);
        };
        Ok(Self {
            rises: rises(segment),
            pv_std: std(&pv),
            op_range: quantile(&segment.op, 0.98) - quantile(&segment.op, 0.02),
            noise: noise_std(&pv),
            probability: probability(&diagnosis),
        })
    }
}

/// That it sticks, by operation.
fn probability(diagnosis: &Diagnosis) -> Option<f64> {
    diagnosis.verdict.probability.map(|p| p.clamp(0.02, 0.98))
}

/// Whose answers are read.
fn who(by_position: bool) -> &'static str {
    if by_position { "stem" } else { "PV" }
}

/// The times in manual whose samples are there, with the times of their turns. Where the position is recorded, it stands in
/// the place of the PV: it answers to the valve alone.
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

/// Whether what was read in them is not one value.
fn moves(spells: &[(Vec<f64>, Manual)]) -> bool {
    let values: Vec<f64> = spells.iter().flat_map(|(_, of)| of.pv.iter().copied()).collect();
    span(&values) > 0.0
}

/// Nearly the shortest time that a turn is held, samples: no dead time is longer that was answered.
fn shortest_hold(spells: &[Manual]) -> usize {
    let holds =
        spells.iter().flat_map(|spell| spell.turns.windows(2).map(|two| two[1].0 - two[0].0));
    let mut holds: Vec<usize> = holds.collect();
    holds.sort_unstable();
    holds.get(holds.len() / 12).copied().unwrap_or(0)
}

/// What a historian that draws lines between the samples it keeps leaves uncertain; 0 of one that keeps all.
fn drawn(pv: &[f64]) -> f64 {
    let scale = 1e-7 * span(pv);
    let bends = |k: &usize| (pv[k - 1] - 2.0 * pv[*k] + pv[k + 1]).abs() > scale;
    let kept: Vec<usize> = (1..pv.len().saturating_sub(1)).filter(bends).collect();
    if 2 * kept.len() > pv.len() || kept.len() < 3 {
        return 0.0;
    }
    let off = kept.windows(3).map(|at| {
        let share = (at[1] - at[0]) as f64 / (at[2] - at[0]) as f64;
        (pv[at[0]] + share * (pv[at[2]] - pv[at[0]]) - pv[at[1]]).abs()
    });
    0.5 * median(&off.collect::<Vec<_>>())
}

/// Log-odds of a probability, short of certainty.
fn odds(p: f64) -> f64 {
    logit(p.clamp(1e-6, 1.0 - 1e-6))
}

/// The verdict of test and operation; evidence adds.
fn conclude(
    weighed: &Weighed,
    operation: &Operation,
    spells: &[Manual],
    by_position: bool,
) -> TestReading {
    let probability = sigmoid(odds(weighed.sticks) + operation.probability.map_or(0.0, odds));
    let (sticking, following) = (weighed.sticking_seen, weighed.following_seen);
    let turns = || spells.iter().flat_map(|spell| spell.turns.windows(2));
    let travel = turns().map(|two| (two[1].1 - two[0].1).abs()).fold(0.0, f64::max);
    let steps = || spells.iter().flat_map(|spell| spell.pv.windows(2));
    let moves = 10 * steps().filter(|two| two[0] != two[1]).count() > steps().count();
    // A stem that follows moves by what the OP does.
    let still = by_position
        && weighed.per_percent < STILL
        && sticking.clear < CLEAR
        && following.clear == 0
        && travel > LIMITS.1
        && moves;
    let went = operation.pv_std > MOVES * operation.noise;
    let silent = went
        && weighed.per_percent * operation.op_range < SILENT * operation.pv_std
        && sticking.clear < CLEAR
        && following.clear == 0
        && following.fits < 0.5 * FITS_HEALTHY
        && travel > 0.5 * operation.op_range
        && probability > 0.3
        && moves;
    let limit = (LIMIT * operation.op_range).clamp(LIMITS.0, LIMITS.1);
    let class = match () {
        () if silent && !by_position || still => VerdictClass::DoesNotRespond,
        () if probability >= SURE && explains(sticking) => VerdictClass::Sticks,
        () if probability < 0.5
            && weighed.elsewhere < 0.1
            && weighed.silent < 1.0 - SURE
            && weighed.s_below < limit
            && following.strength > STRONG
            && following.fits > FITS_HEALTHY =>
        {
            VerdictClass::DoesNotStick
        }
        () => VerdictClass::CannotTell,
    };
    let at = |share| weighed.s_quantile(share);
    // What lies between two turns is known no better than that.
    let s = Estimate { value: at(0.5), low: at(0.05) / WIDER, high: at(0.95) * WIDER };
    // Shares of J are tried in steps of a fifth.
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
        by_test: weighed.sticks,
        by_operation: operation.probability,
        dead_band_elsewhere: weighed.elsewhere,
        s: sticks.then_some(s),
        j: sticks.then_some(j),
        s_below: (weighed.s_below < TOLD_UP_TO && !sticks).then_some(weighed.s_below.max(SMALL)),
        response_s: None,
        known_by: KnownBy::Output,
        from_s: 0.0,
        to_s: 0.0,
        stops: 0,
        position: None,
        by_position,
        steps: vec![],
        reasons: vec![],
        advice: None,
        plan: None,
    }
}

/// Whether the PV goes with a valve that sticks, in more than one turn that it follows.
fn explains(seen: Seen) -> bool {
    seen.clear >= CLEAR && seen.fits > FITS && seen.strength > STRONG
}

/// By this the interval of S is wider than what the likelihoods say.
const WIDER: f64 = 1.06;

fn steps(spells: &[(Vec<f64>, Manual)], weighed: &Weighed) -> Vec<Step> {
    let answered =
        |turn: f64, answer: f64, error: f64| weighed.sign * turn.signum() * answer > SEEN * error;
    let mut all = vec![];
    for (s, (times, manual)) in spells.iter().enumerate() {
        for (i, (at_s, (_, op))) in times.iter().zip(&manual.turns).enumerate() {
            let seen = weighed.turns.iter().find(|(of, turn, ..)| (*of, *turn) == (s, i));
            let turn = (i > 0).then(|| op - manual.turns[i - 1].1);
            all.push(Step {
                at_s: *at_s,
                op: *op,
                travel: turn.map(f64::abs),
                answer: seen.map(|(_, _, answer, _)| *answer),
                error: seen.map(|(_, _, _, error)| *error),
                answered: turn
                    .zip(seen)
                    .is_some_and(|(turn, (_, _, answer, error))| answered(turn, *answer, *error)),
            });
        }
    }
    all
}

fn reasons(reading: &TestReading, weighed: &Weighed) -> Vec<String> {
    let turns: Vec<&Step> = reading.steps.iter().filter(|step| step.travel.is_some()).collect();
    let seen: Vec<f64> =
        turns.iter().filter(|step| step.answered).filter_map(|step| step.travel).collect();
    let unseen: Vec<f64> =
        turns.iter().filter(|step| !step.answered).filter_map(|step| step.travel).collect();
    let mut all = vec![format!(
        "the OP was turned {} times in {}, by {} to {} %; the {} answered {} of these turns",
        reading.steps.len(),
        time(reading.to_s - reading.from_s),
        rough(min(&turns.iter().filter_map(|step| step.travel).collect::<Vec<_>>())),
        rough(max(&turns.iter().filter_map(|step| step.travel).collect::<Vec<_>>())),
        reading.who(),
        seen.len(),
    )];
    if !seen.is_empty() {
        all.push(format!("the smallest turn that it answered was {} %", rough(min(&seen))));
    }
    if !unseen.is_empty() {
        all.push(format!("the largest turn that it did not answer was {} %", rough(max(&unseen))));
    }
    match reading.class {
        VerdictClass::Sticks => all.extend(reading.s.map(|s| {
            format!(
                "a valve with S {} % ({} to {}) explains which turns were answered, and how far; no valve that follows does",
                rough(s.value),
                rough(s.low),
                rough(s.high)
            )
        })),
        VerdictClass::DoesNotStick => all.extend(reading.s_below.map(|limit| {
            format!(
                "the {} went as far as a valve with S below {} % would move it",
                reading.who(),
                rough(limit)
            )
        })),
        VerdictClass::DoesNotRespond => all.push(
            match reading.by_position {
                true => {
                    "the stem did not go with the OP at all, unless its position is measured wrongly".to_owned()
                }
                false => {
                    "the PV did not go with the OP at all, although it moved in operation".to_owned()
                }
            },
        ),
        VerdictClass::CannotTell => {}
    }
    all.extend(reading.position.iter().flat_map(PositionReading::reasons));
    if weighed.elsewhere > 0.1 {
        all.push(format!(
            "a dead band behind the valve, as in the transmitter or a linkage, explains the answers as well: {}",
            percent(weighed.elsewhere)
        ));
    }
    if let Some(before) = reading.by_operation {
        all.push(format!(
            "probability that it sticks: {} by the test, {} by operation before it, {} by both",
            percent(reading.by_test),
            percent(before),
            percent(reading.probability)
        ));
    }
    all
}

fn advice(reading: &TestReading) -> Option<String> {
    if reading.class != VerdictClass::CannotTell {
        return None;
    }
    let turns = reading.steps.iter().filter(|step| step.travel.is_some());
    let (seen, unseen): (Vec<&Step>, Vec<&Step>) = turns.partition(|step| step.answered);
    let advice = match () {
        () if reading.dead_band_elsewhere > 0.3 => {
            "Watch the stem during the test, or record its position: a stem that follows points to the transmitter or the \
             linkage."
        }
        () if seen.is_empty() => {
            "No turn was answered. Hold each turn longer, turn further, and record OP and PV without compression; if the \
             PV still does not answer, look at the valve."
        }
        () if unseen.is_empty() => {
            "All turns were answered. Repeat the test with smaller turns, down to those that the PV does not answer."
        }
        () => {
            "Repeat the test at a calmer time, for what answered moved by itself about as far as with the turns. Make more \
             turns of the sizes that were answered, and hold them longer."
        }
    };
    Some(advice.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bands::Bands;
    use crate::closed_loop::NormalStream;
    use crate::recording::{Channel, Mode, Modes, Set};
    use crate::valve::{Model, Start, Valve};

    const DT: f64 = 2.0;
    const OPERATION: usize = 300;

    /// A loop whose OP wanders by its controller, then a test of turns from 0.4 % to 9 % and back to 0.4 %, each held for
    /// 12 samples; then automatic again.
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

    /// The same with the position of the stem, and a PV that a load hides it behind.
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
        // A stem that stands still does not respond, and a position of one value gives way to the PV.
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
        }
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
    fn what_cannot_be_read_is_said() {
        let recording = tested(3.0, 1.5, false, 7);
        let refused = |recording: &Recording, options: &ReadOptions| -> String {
            read(recording, options).unwrap_err().0
        };
        let plain = Recording { mode: None, ..recording.part(0.0, 500.0, 0.0).unwrap() };
        assert!(refused(&plain, &asked()).starts_with("there is no test in the recording"));
        let sheet = |sets: Vec<Set>| ReadOptions {
            by_hand: Some(ByHand { sets, known_by: KnownBy::Sheet }),
            ..asked()
        };
        let early = vec![Set { at_s: 700.0, op: Some(40.0) }, Set { at_s: 650.0, op: Some(41.0) }];
        assert!(refused(&recording, &sheet(early)).contains("in order of time"));
        for (at_s, op) in [(f64::NAN, 40.0), (700.0, f64::NAN), (700.0, 1e300)] {
            let wrong = vec![Set { at_s: 600.0, op: Some(40.0) }, Set { at_s, op: Some(op) }];
            assert!(refused(&recording, &sheet(wrong)).contains("which is no"));
        }
        let far: Vec<Set> = (0..9)
            .map(|k| Set { at_s: 1e6 + f64::from(k), op: Some(40.0 + f64::from(k % 2)) })
            .collect();
        assert!(refused(&recording, &sheet(far)).contains("outside the samples"));
        let blind = Recording { pv: None, ..recording.clone() };
        assert!(refused(&blind, &asked()).starts_with("without a PV or a position"));
        let mut frozen = recording.clone();
        let (time, n) = (recording.op.time.clone(), recording.op.time.len());
        frozen.pv = Some(Channel::new("PV", time, vec![99.0; n]).unwrap());
        assert!(refused(&frozen, &asked()).contains("one value throughout the test"));
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
