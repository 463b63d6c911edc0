//! Accuracy of a planned test: the loops of the population, tested by a simulated operator.

use crate::scoreboard::Share;
use rayon::prelude::*;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Estimate, VerdictClass, diagnose};
use stiction_diagnose::recording::Recording;
use stiction_diagnose::series::quantile;
use stiction_diagnose::valve_test::{PlanOptions, ReadOptions, TestPlan, TestReading, plan, read};
use stiction_model::error::Result;
use stiction_population::{Draw, Invention, LoopKind, Operator, Tested, ToPlan, Trend, Unseen};

/// Accuracy and cost of a test.
///
/// Loops whose OP is not the valve's input ([`LoopKind::StickyBelow`]), and loops whose valve changes during the
/// record, are left out.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct TestTrial {
    /// Loops with a plan, of all.
    pub planned: Share,
    /// Tests that began, of those that were planned. In the other loops the PV was never calm with the OP off its
    /// limits.
    pub began: Share,
    /// Tests that were never stopped and decide whether the valve sticks.
    pub calm: Share,
    /// Tests in which the controller was put back in automatic at least once.
    pub stopped: Share,
    /// Tests in which the PV exceeded the tolerance of the process.
    pub beyond: Share,
    /// Loops whose PV exceeds it in the same time without a test.
    pub beyond_anyway: Share,
    /// Tests that were given up.
    pub given_up: Share,
    /// Tests that began and decide whether the valve sticks.
    pub decided: Share,
    /// Of these, the correct ones: a limit of S below the true S is wrong.
    pub right: Share,
    /// The accuracy for loops that operation left undecided.
    pub undecided: Share,
    /// Share of correct conclusions among these.
    pub undecided_right: Share,
    /// Tests of sticking valves that detected the sticking.
    pub found: Share,
    /// Tests of healthy valves that wrongly accused the valve.
    pub accused: Share,
    /// Estimates of S within 15 % of the true one.
    pub s_within: Share,
    /// 90 % intervals of S that contain the true one.
    pub s_covered: Share,
    /// 90 % intervals of J that contain the true one.
    pub j_covered: Share,
    /// Tests that were given up and still decide whether the valve sticks.
    pub given_up_decided: Share,
    /// Share of correct conclusions among these.
    pub given_up_right: Share,
    /// Median error of S, share of the true one; `None` without an estimate.
    pub s_error: Option<f64>,
    /// Median limit of S if the valve does not stick, percent.
    pub s_below: Option<f64>,
    /// Share of the tests followed by another test because they were inconclusive.
    pub repeated: Share,
    /// Median number of turns.
    pub turns: Option<f64>,
    /// Time in manual of the first test of a loop, s: the median, and the time that nine of ten tests do not exceed.
    pub manual_s: Option<[f64; 2]>,
    /// Time in manual of the first test, in response times of the process.
    pub responses: Option<[f64; 2]>,
    /// Time in manual of all tests of a loop, s.
    pub manual_of_all_s: Option<[f64; 2]>,
    /// Time in manual that the plan expects of the first test, s.
    pub expected_s: Option<[f64; 2]>,
    /// This time for loops whose 40 response times of the process last 15 min at most.
    pub expected_fast_s: Option<[f64; 2]>,
    /// Tests that are found without a sheet and without a mode.
    pub noticed: Share,
    /// Recordings of operation in which a test is found by mistake.
    pub imagined: Share,
    /// Valves that stick, by the probability of the test: between two of [`BANDS`], from the lowest.
    pub sticking_by_probability: Vec<Share>,
}

/// The ends of the bands of probability of [`TestTrial::sticking_by_probability`].
pub const BANDS: [f64; 9] = [0.0, 0.02, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 1.0];

/// A quarter of an hour, s, and the response times of the process that a test takes.
const QUARTER_S: f64 = 900.0;
const RESPONSES: f64 = 40.0;

/// The loops of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestedLoops {
    /// Those of the population.
    Population,
    /// The kinds that the verdict was not trained on, half of them with a sticking valve.
    Invented,
    /// Ordinary loops whose valve is a physical stem, half of them with friction.
    PhysicalStems,
}

/// Settings of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TestTrialOptions {
    /// The loops.
    pub loops: TestedLoops,
    /// Behaviour of the operator.
    pub operator: Operator,
    /// Recording of the test.
    pub trend: Trend,
}

/// One loop of the trial.
enum One {
    LeftOut,
    NoPlan,
    Tested { undecided: bool, tested: Box<Tested>, read: Option<Box<TestReading>> },
}

/// Length of the recording, in records, that leaves room for a test.
const ROOM: f64 = 12.0;

impl TestTrial {
    /// Tests the first `n` loops of `seed`; runs on all threads, with the same result on any number of them. Calls
    /// `done` after each.
    ///
    /// # Errors
    /// None is known.
    pub fn run(
        seed: u64,
        n: u64,
        options: TestTrialOptions,
        done: impl Fn() + Sync,
    ) -> Result<Self> {
        Ok(Self::of(&Self::all(seed, n, options, done)?))
    }

    /// The reading of each test that began, and whether its valve sticks.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn readings(
        seed: u64,
        n: u64,
        options: TestTrialOptions,
        done: impl Fn() + Sync,
    ) -> Result<Vec<(bool, TestReading)>> {
        let read = |one| match one {
            One::Tested { tested, read, .. } if tested.carried.turns > 0 => {
                read.map(|read| (tested.valve.sticks, *read))
            }
            _ => None,
        };
        Ok(Self::all(seed, n, options, done)?.into_iter().filter_map(read).collect())
    }

    fn all(
        seed: u64,
        n: u64,
        options: TestTrialOptions,
        done: impl Fn() + Sync,
    ) -> Result<Vec<One>> {
        let one = |index: u64| -> Result<One> {
            let mut draw = Draw::of(&[seed, index, 35]);
            let one = match options.loops {
                TestedLoops::Population => {
                    let kind = LoopKind::at(draw.unit());
                    one(kind, draw.seed(), options)
                }
                TestedLoops::Invented => {
                    let kinds = Invention::FIRST.into_iter().chain(Invention::SECOND);
                    let kinds: Vec<Invention> = kinds.collect();
                    let kind = kinds[index as usize % kinds.len()];
                    unseen(Unseen::Invented(kind), draw.seed(), draw.chance(0.5), options)
                }
                TestedLoops::PhysicalStems => {
                    unseen(Unseen::PhysicalStem, draw.seed(), draw.chance(0.5), options)
                }
            };
            done();
            one
        };
        (0..n).into_par_iter().map(one).collect()
    }

    fn of(all: &[One]) -> Self {
        let asked = all.iter().filter(|one| !matches!(one, One::LeftOut));
        let tested: Vec<(bool, &Tested, Option<&TestReading>)> = all
            .iter()
            .filter_map(|one| match one {
                One::Tested { undecided, tested, read } => {
                    Some((*undecided, &**tested, read.as_deref()))
                }
                _ => None,
            })
            .collect();
        let began: Vec<(bool, &Tested, Option<&TestReading>)> =
            tested.iter().copied().filter(|(_, tested, _)| tested.carried.turns > 0).collect();
        let share = |of: &dyn Fn(&Tested) -> bool| Share::of(&began, |(_, tested, _)| of(tested));
        let class = |read: Option<&TestReading>| read.map_or(VerdictClass::CannotTell, |r| r.class);
        let never_stopped: Vec<_> =
            began.iter().filter(|(_, tested, _)| tested.carried.stopped == 0).collect();
        let decisions = |only: &dyn Fn(bool, &Tested) -> bool| -> (Share, Share) {
            let of: Vec<_> = began.iter().filter(|(open, one, _)| only(*open, one)).collect();
            let made: Vec<_> =
                of.iter().filter(|(.., read)| class(*read) != VerdictClass::CannotTell).collect();
            let right = Share::of(&made, |(_, tested, read)| right(tested, *read));
            (Share { k: made.len(), n: of.len() }, right)
        };
        let (decided, of_decided) = decisions(&|_, _| true);
        let (undecided, undecided_right) = decisions(&|open, _| open);
        let (given_up_decided, given_up_right) = decisions(&|_, tested| tested.carried.given_up);
        let bad = |read: Option<&TestReading>| {
            matches!(class(read), VerdictClass::Sticks | VerdictClass::DoesNotRespond)
        };
        let called = |sticks: bool| {
            let of: Vec<_> = began.iter().filter(|(_, t, _)| t.valve.sticks == sticks).collect();
            Share::of(&of, |(.., read)| bad(*read))
        };
        let told: Vec<((f64, f64), Estimate, Estimate)> = began
            .iter()
            .filter_map(|(_, tested, read)| Some((tested.valve.bands?, (*read)?)))
            .filter_map(|(truth, read)| Some((truth, read.s?, read.j?)))
            .collect();
        let errors: Vec<f64> =
            told.iter().map(|((s, _), of, _)| (of.value / s - 1.0).abs()).collect();
        let holds = |of: &Estimate, truth: f64| of.low <= truth && truth <= of.high;
        let limits: Vec<f64> = began
            .iter()
            .filter(|(.., read)| class(*read) == VerdictClass::DoesNotStick)
            .filter_map(|(.., read)| (*read)?.s_below)
            .collect();
        let turns: Vec<f64> = began.iter().map(|(_, t, _)| t.carried.turns as f64).collect();
        let median = |x: &[f64]| (!x.is_empty()).then(|| quantile(x, 0.5));
        let two_of = |only: &dyn Fn(&Tested) -> bool, of: &dyn Fn(&Tested) -> f64| {
            let tests = began.iter().map(|(_, tested, _)| *tested);
            let all: Vec<f64> = tests.filter(|tested| only(tested)).map(of).collect();
            (!all.is_empty()).then(|| [0.5, 0.9].map(|share| quantile(&all, share)))
        };
        let two = |of: &dyn Fn(&Tested) -> f64| two_of(&|_| true, of);
        let fast = |tested: &Tested| RESPONSES * tested.valve.response_s <= QUARTER_S;
        let manual = |tested: &Tested| tested.carried.manual_s[0];
        let within = |ends: &[f64]| {
            let inside = |p: f64| ends[0] <= p && (p < ends[1] || ends[1] == 1.0);
            let of = began.iter().filter(|(.., read)| read.is_some_and(|r| inside(r.probability)));
            Share::of(&of.collect::<Vec<_>>(), |(_, tested, _)| tested.valve.sticks)
        };
        Self {
            planned: Share { k: tested.len(), n: asked.count() },
            began: Share { k: began.len(), n: tested.len() },
            calm: Share::of(&never_stopped, |one| class(one.2) != VerdictClass::CannotTell),
            stopped: share(&|tested| tested.carried.stopped > 0),
            beyond: share(&|tested| tested.carried.beyond),
            beyond_anyway: share(&|tested| tested.carried.beyond_anyway),
            given_up: share(&|tested| tested.carried.given_up),
            decided,
            right: of_decided,
            undecided,
            undecided_right,
            found: called(true),
            accused: called(false),
            s_within: Share::of(&errors, |error| *error <= 0.15),
            s_covered: Share::of(&told, |((s, _), of, _)| holds(of, *s)),
            j_covered: Share::of(&told, |((_, j), _, of)| holds(of, *j)),
            given_up_decided,
            given_up_right,
            s_error: median(&errors),
            s_below: median(&limits),
            repeated: share(&|tested| tested.carried.began > 1),
            turns: median(&turns),
            manual_s: two(&manual),
            responses: two(&|tested| manual(tested) / tested.valve.response_s),
            manual_of_all_s: two(&|tested| tested.carried.manual_s.iter().sum()),
            expected_s: two(&|tested| tested.plan.expected_s),
            expected_fast_s: two_of(&fast, &|tested| tested.plan.expected_s),
            noticed: share(&|tested| tested.noticed),
            imagined: Share::of(&tested, |(_, tested, _)| tested.imagined),
            sticking_by_probability: BANDS.windows(2).map(within).collect(),
        }
    }
}

fn one(kind: LoopKind, seed: u64, options: TestTrialOptions) -> Result<One> {
    if kind == LoopKind::StickyBelow {
        return Ok(One::LeftOut);
    }
    planned(&mut |plan| kind.tested(seed, ROOM, options.operator, options.trend, plan))
}

fn unseen(of: Unseen, seed: u64, sticks: bool, options: TestTrialOptions) -> Result<One> {
    planned(&mut |plan| of.tested(seed, sticks, ROOM, options.operator, plan))
}

type Plan<'a> = &'a mut dyn FnMut(&Recording, ToPlan) -> Option<TestPlan>;

/// Plans a test from the diagnosis of operation, and reads it.
fn planned(test: &mut dyn FnMut(Plan<'_>) -> Result<Option<Tested>>) -> Result<One> {
    let mut undecided = false;
    let tested = test(&mut |before, of| {
        let detectors = Detectors::None;
        let asked = DiagnoseOptions { detectors, plan: false, ..DiagnoseOptions::default() };
        let diagnosis = diagnose(before, &asked).ok()?;
        undecided = diagnosis.verdict.class == VerdictClass::CannotTell;
        let options = PlanOptions {
            rises: Some(of.rises),
            pv_allowed: Some(of.pv_allowed),
            ..PlanOptions::default()
        };
        plan(&diagnosis, &options).ok()
    })?;
    let Some(tested) = tested else { return Ok(One::NoPlan) };
    if tested.valve.partly {
        return Ok(One::LeftOut);
    }
    let asked = ReadOptions {
        by_hand: Some(tested.carried.sheet.clone()),
        rises: Some(tested.valve.rises),
        ..ReadOptions::default()
    };
    let read = read(&tested.whole, &asked).ok().map(Box::new);
    Ok(One::Tested { undecided, tested: Box::new(tested), read })
}

/// Whether a decision is right.
fn right(tested: &Tested, read: Option<&TestReading>) -> bool {
    let valve = tested.valve;
    read.is_some_and(|read| match read.class {
        VerdictClass::Sticks | VerdictClass::DoesNotRespond => valve.sticks,
        VerdictClass::DoesNotStick => {
            let below = |(s, _): (f64, f64)| read.s_below.is_some_and(|limit| s <= limit);
            !valve.sticks || valve.bands.is_some_and(below)
        }
        VerdictClass::CannotTell => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_decides_and_is_right() {
        let options = TestTrialOptions {
            loops: TestedLoops::Population,
            operator: Operator::Careful,
            trend: Trend::AsPlanned,
        };
        let trial = TestTrial::run(5, 60, options, || ()).unwrap();
        assert!(trial.began.n > 40 && 10 * trial.began.k >= 9 * trial.began.n, "{trial:?}");
        assert!(10 * trial.right.k >= 9 * trial.right.n && trial.decided.k > 15, "{trial:?}");
        assert!(trial.s_error.is_some_and(|error| error < 0.15), "{trial:?}");
        assert!(trial.imagined.k <= 1, "{trial:?}");
        // The same on any number of threads.
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(alone.install(|| TestTrial::run(5, 12, options, || ())).unwrap(), {
            TestTrial::run(5, 12, options, || ()).unwrap()
        });
    }

    #[test]
    fn tests_decide_on_loops_that_are_not_in_the_population() {
        for loops in [TestedLoops::Invented, TestedLoops::PhysicalStems] {
            let options =
                TestTrialOptions { loops, operator: Operator::Careful, trend: Trend::AsPlanned };
            let trial = TestTrial::run(5, 32, options, || ()).unwrap();
            assert!(trial.began.k > 16 && trial.decided.k > 6, "{trial:?}");
            assert!(10 * trial.right.k >= 8 * trial.right.n, "{trial:?}");
        }
    }
}
