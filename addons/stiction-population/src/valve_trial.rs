//! A loop of the population in which an operator carries out a planned test.

use super::LoopKind;
use super::draw::Draw;
use super::member::{self, Scene};
use super::plant::Hand;
use super::truth::Simulated;
use stiction_diagnose::recording::{ByHand, KnownBy, Recording, Set};
use stiction_diagnose::series::{max, min};
use stiction_diagnose::valve_test::{LEAST_HELD, TestPlan};
use stiction_model::error::{Error, Result};

/// Behaviour of an operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    /// Exactly as planned.
    Careful,
    /// Holds are 50 to 150 % as long, and of five turns one is left out or has a different size.
    Careless,
}

/// Recording of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trend {
    /// As the plan requires: without compression.
    AsPlanned,
    /// By the historian of the loop.
    Historian,
}

/// Known facts about a loop before a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToPlan {
    /// Whether the PV rises with the OP.
    pub rises: bool,
    /// Tolerance of the process, PV in its units: 5 % of its span around its rest value, and the recorded range
    /// plus half as much again.
    pub pv_allowed: [f64; 2],
}

/// The actions of the operator.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatorActions {
    /// Number of tests that began.
    pub began: usize,
    /// Number of turns.
    pub turns: usize,
    /// Number of returns to automatic because the PV went too far.
    pub stopped: usize,
    /// Whether the test was given up.
    pub given_up: bool,
    /// Whether it was completed.
    pub ended: bool,
    /// Whether the PV exceeded the tolerance, during a hold or after a stop until it was calm.
    pub beyond: bool,
    /// Whether the PV of the same loop exceeds it in the same time without a test.
    pub beyond_anyway: bool,
    /// Begin, s on the recording's clock.
    pub from_s: f64,
    /// End.
    pub to_s: f64,
    /// How long the controller was in manual in each test, s.
    pub manual_s: Vec<f64>,
    /// The completed sheet.
    pub sheet: ByHand,
}

/// The truth about a tested valve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestedValve {
    /// Whether it is faulty: it sticks or is stuck.
    pub sticks: bool,
    /// S and J, percent of span, of a valve that sticks and slips throughout.
    pub bands: Option<(f64, f64)>,
    /// Whether it sticks only part of the time or of the stroke.
    pub partly: bool,
    /// Whether the PV rises with the OP.
    pub rises: bool,
    /// Time between the samples of the recording, s.
    pub sample_time_s: f64,
    /// Response time of the process with its valve, s: the sum of its lags and dead time.
    pub response_s: f64,
}

/// A loop before a test, and with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    /// The recording before the plan was made.
    pub before: Recording,
    /// The whole recording, to the end of the test and some more.
    pub whole: Recording,
    /// The valve.
    pub valve: TestedValve,
    /// The plan.
    pub plan: TestPlan,
    /// The result of the test.
    pub carried: OperatorActions,
    /// Whether most of the test is found in the recording, without a sheet or a mode.
    pub noticed: bool,
    /// Whether a test is found in the recording before it.
    pub imagined: bool,
}

impl LoopKind {
    /// The loop of this kind and seed, recorded in operation, then tested by the plan from that recording; `None`
    /// without a plan or loop. There is room for a test of `longest` records.
    ///
    /// # Errors
    /// As [`simulate_for`](Self::simulate_for).
    pub fn tested(
        self,
        seed: u64,
        longest: f64,
        operator: Operator,
        trend: Trend,
        plan: &mut dyn FnMut(&Recording, ToPlan) -> Option<TestPlan>,
    ) -> Result<Option<Tested>> {
        let factor = 1.0 + longest;
        for redrawn in 0..100 {
            let draw = &mut Draw::of(&[seed, redrawn]);
            let mut tested = None;
            let mut then = |scene: &Scene<'_>, simulated: &Simulated| -> Result<()> {
                let design = scene.design;
                let samples = (design.samples as f64 / factor) as usize;
                let at_s = samples as f64 * design.sample_time;
                let share = simulated.truth.facts.faulty_share;
                let truth = &simulated.truth;
                let site = Site {
                    valve: TestedValve {
                        sticks: truth.sticks,
                        bands: truth.has_bands().then_some((truth.s, truth.j)),
                        partly: truth.has_bands() && share > 0.0 && share < 1.0,
                        rises: design.gain > 0.0,
                        sample_time_s: design.sample_time,
                        response_s: design.response_time_untuned(),
                    },
                    first: design.warm_up + samples * design.steps,
                    warm_up: design.warm_up,
                    step: design.step(),
                    pv_range: design.pv_range,
                    pv_rest: design.pv_rest,
                    limits: design.limits,
                };
                let historian = match trend {
                    Trend::AsPlanned => design.historian.trend(),
                    Trend::Historian => design.historian.clone(),
                };
                let mut play = |hand: &mut dyn Hand| {
                    let played = scene.plant.play_with(scene.fittings, hand)?;
                    member::recorded(design, &historian, &played)
                };
                let of = [seed, redrawn, 77];
                let untested = &simulated.recording;
                tested = site.tested(untested, at_s, operator, of, plan, &mut play)?;
                Ok(())
            };
            if member::simulate(self, draw, factor, None, &mut then)?.is_some() {
                return Ok(tested);
            }
        }
        Err(Error::Inconsistent(format!("{} {seed}: no draw is valid", self.name())))
    }
}

/// A loop at which a test is made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    pub valve: TestedValve,
    /// The step at which the operator begins, and the steps before the recording.
    pub first: usize,
    pub warm_up: usize,
    /// Duration of a step, s.
    pub step: f64,
    /// Lowest PV and span of the transmitter, units, and the PV at rest, percent of the span.
    pub pv_range: (f64, f64),
    pub pv_rest: f64,
    /// Range of the OP, percent.
    pub limits: (f64, f64),
}

impl Site {
    /// Tests the loop after `at_s`; `None` without a plan. `untested` is its recording without a test, `play` records it
    /// with an operator, and `of` is the seed of the operator.
    ///
    /// # Errors
    /// As for `play`.
    pub fn tested(
        self,
        untested: &Recording,
        at_s: f64,
        operator: Operator,
        of: [u64; 3],
        plan: &mut dyn FnMut(&Recording, ToPlan) -> Option<TestPlan>,
        play: &mut dyn FnMut(&mut dyn Hand) -> Result<Recording>,
    ) -> Result<Option<Tested>> {
        let Some(before) = untested.part(0.0, at_s, 0.0) else { return Ok(None) };
        let Some(pv) = &before.pv else { return Ok(None) };
        let (low, span) = self.pv_range;
        let rest = low + span / 100.0 * self.pv_rest;
        let half = 0.5 * (max(&pv.values) - min(&pv.values));
        let allowed = [
            (rest - ALLOWED * span).min(min(&pv.values) - half),
            (rest + ALLOWED * span).max(max(&pv.values) + half),
        ];
        let to_plan = ToPlan { rises: self.valve.rises, pv_allowed: allowed };
        let Some(plan) = plan(&before, to_plan) else { return Ok(None) };
        let mut plans = vec![plan];
        let (whole, mut carried) = loop {
            let mut hand = AtWork::new(self, &plans, operator, allowed, Draw::of(&of));
            let whole = play(&mut hand)?;
            let carried = hand.actions();
            let last = &plans[plans.len() - 1];
            let more = plans.len() < MOST_TESTS && carried.began == plans.len();
            let next = more.then(|| last.again(&whole, Some(carried.sheet.clone())));
            match next.flatten() {
                Some(next) => plans.push(next),
                None => break (whole, carried),
            }
        };
        let plan = plans.swap_remove(0);
        let after = carried.to_s + 10.0 * plan.grow[0].hold_s;
        let whole = whole.part(0.0, after, 0.0).unwrap_or(whole);
        let imagined = ByHand::of(&before).is_some();
        let (from, to) = (carried.from_s, carried.to_s);
        let noticed = ByHand::of(&whole).is_some_and(|found| {
            let inside = |set: &&Set| set.op.is_some() && from <= set.at_s && set.at_s < to;
            2 * found.sets.iter().filter(inside).count() >= carried.turns
        });
        // The effect of the load without a test.
        let went = untested.part(from, to, f64::INFINITY);
        let calm = went
            .and_then(|part| part.pv)
            .is_none_or(|pv| pv.values.iter().all(|v| (allowed[0]..=allowed[1]).contains(v)));
        carried.beyond_anyway = !calm;
        let valve = self.valve;
        Ok(Some(Tested { before, whole, valve, plan, carried, noticed, imagined }))
    }
}

/// State of an operator.
#[derive(Debug, Clone, Copy, PartialEq)]
enum At {
    /// In automatic, since a step; waits until the PV is calm.
    Waits(usize),
    /// Holds a turn, since a step.
    Holds(usize),
    Done,
}

/// Part of the test: the size of the turns, percent, and their number.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    /// Size of this number, until the PV responds.
    Grows(usize),
    /// This size in percent, until this number of consecutive turns had no response.
    Shrinks(f64, usize),
}

/// A simulated operator.
struct AtWork<'a> {
    plan: &'a TestPlan,
    /// The following tests.
    plans: &'a [TestPlan],
    site: Site,
    of: Draw,
    careless: bool,
    at: At,
    stage: Stage,
    up: bool,
    allowed: [f64; 2],
    /// Central OP of the turns, and the PV there, units.
    rest: (f64, f64),
    /// Turns of this size, and the number with a response.
    done: usize,
    answered: usize,
    /// Whether that is known.
    known: bool,
    /// PV movement with each, and the longest hold.
    moved: Vec<f64>,
    longest: f64,
    /// Turns with a response since the size of this number was reached.
    seen: usize,
    grown: usize,
    /// Response time of the PV, s.
    soon: f64,
    /// Longest hold of a turn, s.
    hold: f64,
    held_op: f64,
    last_op: f64,
    /// The PV at the turn of the OP.
    turned_at: f64,
    op_mean: f64,
    wander: Wander,
    calm: f64,
    /// Noise of the PV, units.
    noise: Noise,
    carried: OperatorActions,
    last: usize,
    /// Consecutive moves of the OP because the PV drifted.
    nudged: u32,
    /// Stops of this test.
    stops: usize,
}

/// The noise of the PV for the operator: the mean size of its second differences.
#[derive(Default)]
struct Noise {
    last: [f64; 2],
    seen: usize,
    square: f64,
}

impl Noise {
    fn see(&mut self, pv: f64) {
        let second = pv - 2.0 * self.last[0] + self.last[1];
        if self.seen >= 2 {
            let keep = 1.0 - 1.0 / (self.seen.min(200) as f64);
            self.square = keep * self.square + (1.0 - keep) * second * second / 6.0;
        }
        self.last = [pv, self.last[0]];
        self.seen += 1;
    }
}

/// Movement of a PV by itself in automatic during a hold.
#[derive(Default)]
struct Wander {
    from: f64,
    since: usize,
    seen: usize,
    square: f64,
}

impl Wander {
    fn see(&mut self, pv: f64, k: usize, steps: usize) {
        if k >= self.since + steps.max(1) {
            if self.since > 0 {
                self.seen += 1;
                let keep = 1.0 - 1.0 / (self.seen.min(30) as f64);
                self.square = keep * self.square + (1.0 - keep) * (pv - self.from).powi(2);
            }
            (self.from, self.since) = (pv, k);
        }
    }
}

/// Largest deviation of the PV from its rest value, as a share of its span.
const ALLOWED: f64 = 0.05;
/// Maximum number of successive tests of one loop.
const MOST_TESTS: usize = 3;
/// Number of stops after which the test is given up.
const MOST_STOPS: usize = 6;

impl<'a> AtWork<'a> {
    fn new(
        site: Site,
        plans: &'a [TestPlan],
        operator: Operator,
        allowed: [f64; 2],
        of: Draw,
    ) -> Self {
        let plan = &plans[0];
        Self {
            plan,
            plans: &plans[1..],
            site,
            of,
            careless: operator == Operator::Careless,
            at: At::Waits(site.first),
            stage: Stage::Grows(0),
            done: 0,
            known: false,
            moved: vec![],
            longest: 0.0,
            seen: 0,
            grown: 0,
            up: plan.grow[0].op > 0.0,
            allowed,
            rest: (0.0, 0.0),
            answered: 0,
            soon: plan.grow[0].hold_s,
            hold: 0.0,
            held_op: f64::NAN,
            last_op: 0.0,
            turned_at: 0.0,
            wander: Wander::default(),
            op_mean: f64::NAN,
            calm: 0.0,
            noise: Noise::default(),
            carried: OperatorActions {
                turns: 0,
                stopped: 0,
                began: 1,
                given_up: false,
                ended: false,
                beyond: false,
                beyond_anyway: false,
                from_s: 0.0,
                to_s: 0.0,
                manual_s: vec![0.0],
                sheet: ByHand { sets: vec![], known_by: KnownBy::Sheet },
            },
            last: 0,
            nudged: 0,
            stops: 0,
        }
    }

    /// Whether the PV rises with the OP.
    fn rises(&self) -> bool {
        self.site.valve.rises
    }

    fn at(&self, k: usize) -> f64 {
        k.saturating_sub(self.site.warm_up) as f64 * self.site.step
    }

    fn actions(&self) -> OperatorActions {
        OperatorActions {
            from_s: self.at(self.site.first),
            to_s: self.at(self.last),
            ..self.carried.clone()
        }
    }

    fn wrote(&mut self, k: usize, op: Option<f64>) {
        let set = Set { at_s: self.at(k), op };
        self.carried.sheet.sets.push(set);
    }

    fn automatic(&mut self, k: usize) -> Option<f64> {
        self.wrote(k, None);
        None
    }

    /// Ends this test and begins the next.
    fn over(&mut self, k: usize, ended: bool) {
        self.carried.ended = ended;
        self.carried.given_up = !ended;
        self.at = At::Done;
        if let Some((next, others)) = self.plans.split_first() {
            (self.plan, self.plans) = (next, others);
            self.carried.began += 1;
            self.carried.manual_s.push(0.0);
            (self.stage, self.at, self.known) = (Stage::Grows(0), At::Waits(k), false);
            (self.done, self.answered, self.longest, self.seen, self.grown) = (0, 0, 0.0, 0, 0);
            (self.calm, self.stops) = (0.0, 0);
            self.moved.clear();
            self.soon = next.grow[0].hold_s;
        }
    }

    /// The size of the turns, percent.
    fn size(&self) -> Option<f64> {
        match self.stage {
            Stage::Grows(number) => {
                self.plan.grow.get(self.plan.each * number).map(|turn| 2.0 * turn.op.abs())
            }
            Stage::Shrinks(size, silent) => {
                (silent < self.plan.ends_after && size > 0.2).then_some(size)
            }
        }
    }

    /// The next turn, or the end.
    fn turn(&mut self, k: usize, pv: f64) {
        let (low, high) = (self.plan.op_low, self.plan.op_high);
        if self.careless && self.of.chance(0.1) {
            self.done += 1;
            self.after();
        }
        let Some(size) = self.size() else { return self.over(k, true) };
        let hold = match self.stage {
            Stage::Grows(number) if !self.known => self.plan.grow[self.plan.each * number].hold_s,
            _ => 2.0 * self.soon,
        };
        let away = 0.5 * size;
        let (mut size, mut late) = (1.0, 1.0);
        if self.careless {
            late = self.of.uniform(0.5, 1.5);
            if self.of.chance(0.1) {
                size = self.of.uniform(0.5, 1.5);
            }
        }
        let sign = if self.up { 1.0 } else { -1.0 };
        self.up = !self.up;
        self.nudged = 0;
        self.last_op = if self.held_op.is_nan() { self.rest.0 } else { self.held_op };
        self.rest.0 = self.plan.centre(self.rest.0, 2.0 * away);
        self.held_op = (self.rest.0 + sign * size * away).clamp(low, high);
        self.hold = late * hold;
        self.turned_at = pv;
        self.at = At::Holds(k);
        self.carried.turns += 1;
        self.wrote(k, Some(self.held_op));
    }

    /// PV movement that counts as a response.
    fn answer(&self) -> f64 {
        let (least, most) = (self.plan.pv_low, self.plan.pv_high);
        let wanders = (2.0 * self.wander.square.sqrt()).min(0.15 * (most - least));
        self.plan.answer.max(5.0 * self.noise.square.sqrt()).max(wanders)
    }

    /// Whether the PV has responded to the present turn.
    fn passed(&self, pv: f64) -> bool {
        let up = (self.held_op > self.last_op) == self.rises();
        let moved = pv - self.turned_at;
        if up { moved >= self.answer() } else { -moved >= self.answer() }
    }

    /// Whether the PV drifts away, although the OP should bring it back.
    fn strays(&self, pv: f64) -> bool {
        let [low, high] = self.plan.inner();
        let up = (self.held_op > self.last_op) == self.rises();
        pv > high && !up && pv > self.turned_at || pv < low && up && pv < self.turned_at
    }

    /// Whether the PV has gone far with the turn.
    fn is_far(&self, pv: f64) -> bool {
        let [low, high] = self.plan.inner();
        let up = (self.held_op > self.last_op) == self.rises();
        if up { pv > high } else { pv < low }
    }

    /// Moves the OP further in the same direction, by twice as much each time. In the second part it begins with the size to which
    /// the PV responded, because a smaller move may not move the stem.
    fn nudge(&mut self, k: usize, pv: f64) {
        let (low, high) = (self.plan.op_low, self.plan.op_high);
        let size = match self.stage {
            Stage::Grows(_) => self.size(),
            Stage::Shrinks(..) => Some(2.0 * self.plan.grow[self.plan.each * self.grown].op.abs()),
        };
        let Some(size) = size else { return };
        let sign = if self.held_op > self.last_op { 1.0 } else { -1.0 };
        let by = 0.5 * size * f64::from(1u32 << self.nudged.min(8));
        self.nudged += 1;
        let op = (self.held_op + sign * by).clamp(low, high);
        self.rest.0 += op - self.held_op;
        self.last_op = self.held_op;
        self.held_op = op;
        self.turned_at = pv;
        self.at = At::Holds(k);
        (self.done, self.answered, self.longest) = (0, 0, 0.0);
        self.moved.clear();
        self.carried.turns += 1;
        self.wrote(k, Some(op));
    }

    /// The next action after a hold of this length.
    fn next(&mut self, pv: f64, held: f64) {
        self.done += 1;
        let up = (self.held_op > self.last_op) == self.rises();
        let moved = if up { pv - self.turned_at } else { self.turned_at - pv };
        self.moved.push(moved);
        if moved >= self.answer() {
            self.answered += 1;
            self.longest = self.longest.max(held);
        }
        self.after();
    }

    /// Whether the PV reversed with all turns of this size, and further than its scatter.
    fn together(&self) -> bool {
        let n = self.moved.len() as f64;
        let mean = self.moved.iter().sum::<f64>() / n;
        let spread = (self.moved.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / n).sqrt();
        self.moved.len() >= 3
            && self.moved.iter().all(|m| *m > 0.0)
            && mean >= self.answer()
            && mean > 1.5 * spread
    }

    /// Two turns of each size, and four if the first two had a response.
    fn after(&mut self) {
        if self.done < self.plan.each {
            return;
        }
        match self.stage {
            Stage::Grows(_)
                if self.answered >= self.plan.each && self.done < 2 * self.plan.each =>
            {
                return;
            }
            Stage::Grows(number) if self.done >= 2 * self.plan.each && self.together() => {
                self.soon = self.longest;
                self.known = true;
                self.seen = self.answered;
                self.grown = number;
                self.stage =
                    Stage::Shrinks(2.0 * self.plan.grow[self.plan.each * number].op.abs(), 0);
            }
            Stage::Grows(number) => self.stage = Stage::Grows(number + 1),
            Stage::Shrinks(size, silent) => {
                self.seen += self.answered;
                let silent = if self.answered > 0 { 0 } else { silent + 1 };
                self.stage = match silent {
                    // It was chance.
                    n if n == self.plan.ends_after && self.seen < 6 => Stage::Grows(self.grown + 1),
                    _ => Stage::Shrinks(self.plan.shrink_by * size, silent),
                };
            }
        }
        (self.done, self.answered, self.longest) = (0, 0, 0.0);
        self.moved.clear();
    }
}

impl Hand for AtWork<'_> {
    fn op(&mut self, k: usize, pv: f64, sp: f64, op: f64) -> Option<f64> {
        let step = self.site.step;
        let (low, span) = self.site.pv_range;
        let (pv, sp) = (low + span / 100.0 * pv, low + span / 100.0 * sp);
        self.noise.see(pv);
        if self.at != At::Done {
            self.last = k;
        }
        // After a stop the controller may let the PV go further before it brings it back.
        let back = matches!(self.at, At::Waits(_)) && self.carried.stopped > 0;
        if matches!(self.at, At::Holds(_)) || back {
            let out = pv < self.allowed[0] || pv > self.allowed[1];
            self.carried.beyond |= out;
        }
        let holds = matches!(self.at, At::Holds(_));
        if let (true, Some(manual)) = (holds, self.carried.manual_s.last_mut()) {
            *manual += step;
        }
        let (least, most) = (self.plan.pv_low, self.plan.pv_high);
        match self.at {
            At::Done => None,
            At::Waits(since) => {
                let keep = (-step / (2.0 * self.soon)).exp();
                self.op_mean = match self.op_mean.is_nan() {
                    true => op,
                    false => keep * self.op_mean + (1.0 - keep) * op,
                };
                self.wander.see(pv, k, (self.soon / step) as usize);
                let waited = k.saturating_sub(since) as f64 * step;
                if waited > 100.0 * self.soon {
                    self.over(k, false);
                    return None;
                }
                if k < self.site.first || waited < 4.0 * self.soon {
                    return None;
                }
                let inside =
                    |share: f64| (pv - 0.5 * (least + most)).abs() < share * 0.5 * (most - least);
                let near = (pv - sp).abs() < self.answer() && inside(0.6);
                self.calm = if near { self.calm + step } else { 0.0 };
                let calm = self.calm > 2.0 * self.soon;
                let (low, high) = self.site.limits;
                if op < low + 1.0 || op > high - 1.0 {
                    return None;
                }
                let patience = waited > 20.0 * self.soon && inside(0.8);
                if calm || patience {
                    self.rest = (self.op_mean, pv);
                    self.held_op = f64::NAN;
                    self.turn(k, pv);
                }
                matches!(self.at, At::Holds(_)).then_some(self.held_op)
            }
            At::Holds(since) => {
                if pv < least || pv > most {
                    self.carried.stopped += 1;
                    // A size too small to hold the PV is not tried again.
                    if let Stage::Grows(number) = self.stage {
                        self.stage = Stage::Grows(number + 1);
                    }
                    (self.done, self.answered) = (0, 0);
                    self.moved.clear();
                    self.calm = 0.0;
                    self.at = At::Waits(k);
                    self.stops += 1;
                    if self.stops >= MOST_STOPS {
                        self.over(k, false);
                    }
                    return self.automatic(k);
                }
                let held = (k - since) as f64 * step;
                let room = self.plan.op_low < self.held_op && self.held_op < self.plan.op_high;
                if self.strays(pv) && held >= self.soon && room {
                    self.nudge(k, pv);
                    return Some(self.held_op);
                }
                let least = if self.is_far(pv) { 0.0 } else { LEAST_HELD * self.hold };
                let passed =
                    self.passed(pv) && held >= least.max(2.0 * self.site.valve.sample_time_s);
                if passed || held >= self.hold {
                    self.next(pv, held);
                    let manual = self.carried.manual_s.last().copied().unwrap_or(0.0);
                    match manual < self.plan.total_s {
                        true => self.turn(k, pv),
                        false => self.over(k, true),
                    }
                    if !matches!(self.at, At::Holds(_)) {
                        return self.automatic(k);
                    }
                }
                Some(self.held_op)
            }
        }
    }
}
