//! Learn the test: a valve with unknown S and J, which the user tests by hand.
//!
//! A seed draws the valve, the load and the noise. The server keeps no state: each call simulates the loop from its start,
//! with all sets by hand. So the same seed and the same sets give the same samples, and the truth stays on the server
//! until the user asks for it.

mod operator;

use crate::calls::{Answer, Wrong};
use crate::guess::{mixed, share};
use crate::lab::Lab;
use crate::live::{Live, Samples};
use crate::loops::LoopRequest;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, diagnose};
use stiction_diagnose::recording::{ByHand, KnownBy, Recording, Set};
use stiction_diagnose::valve_test::{
    PlanOptions, ReadOptions, TestPlan, TestReading, plan as plan_of, read as read_test,
};
use stiction_report::{valve_test_figure, words};

/// How long the loop is in automatic before its OP can be set, s. This part sizes the plan.
const OPERATION_S: f64 = 300.0;
/// The longest exercise, s.
const LONGEST_S: f64 = 7200.0;
/// Sets of one exercise.
const SETS: usize = 500;
/// S of a healthy valve, percent of span. About one valve in three is healthy.
const HEALTHY: (f64, f64) = (0.1, 0.3);
/// S of a sticking valve, percent of span.
const STICKS: (f64, f64) = (1.5, 6.0);
/// J of a sticking valve as a share of S.
const JUMP: (f64, f64) = (0.3, 0.9);
/// The load: standard deviation, percent of span, and correlation time, s.
const LOAD: (f64, f64) = (0.3, 600.0);

/// The valve.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Which {
    /// The seed of valve, load and noise.
    seed: u32,
}

/// An exercise as far as it was done.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Exercise {
    /// The seed of valve, load and noise.
    seed: u32,
    /// The sets by hand, in order of time.
    sets: Vec<Hand>,
    /// The end of the run, s.
    until_s: f64,
}

/// One set: an OP by hand, or the controller back in automatic.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hand {
    /// The time, s.
    at_s: f64,
    /// The OP, percent of span; null if the controller was put in automatic.
    op: Option<f64>,
}

/// The requested samples of an exercise.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// The exercise.
    exercise: Exercise,
    /// The number of the first requested sample.
    from: usize,
}

/// The recording of the loop.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Recorded {
    /// Time between samples, s.
    sample_time_s: f64,
    /// The number of the first sample here.
    from: usize,
    /// Controller output, percent of span.
    op: Vec<f64>,
    /// Process value, percent.
    pv: Vec<f64>,
}

/// The loop before the test.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Before {
    /// How long it was in automatic, s.
    until_s: f64,
    /// The longest exercise, s.
    longest_s: f64,
    /// Sets that one exercise may have.
    most_sets: usize,
    /// The test plan.
    plan: TestPlan,
}

/// The test that the lab carried out.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CompletedTest {
    /// Sets.
    sets: Vec<Hand>,
    /// The end of the run, s.
    until_s: f64,
    /// The recording.
    recorded: Recorded,
}

/// The result of the test, in words and complete.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Reading {
    /// The probability that the valve sticks.
    probability: String,
    /// S with its interval, where it is known.
    #[serde(rename = "S")]
    s: Option<String>,
    /// J with its interval, where it is known.
    #[serde(rename = "J")]
    j: Option<String>,
    /// The limit of S, if the valve does not stick.
    #[serde(rename = "S_below")]
    s_below: Option<String>,
    /// The figure of PV responses over OP turns.
    svg: String,
    /// The whole reading, as `stiction test read --json` prints it.
    test: TestReading,
}

/// The truth about the valve.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Truth {
    /// Whether it sticks.
    sticks: bool,
    /// Stick band plus dead band, percent of span.
    #[serde(rename = "S")]
    s: f64,
    /// Slip jump, percent of span.
    #[serde(rename = "J")]
    j: f64,
    /// The valve position at each sample, percent of span.
    vp: Vec<f64>,
}

/// A drawn valve.
#[derive(Debug, Clone, Copy)]
struct Drawn {
    sticks: bool,
    s: f64,
    j: f64,
}

/// Whether the valve of a seed sticks, and its S.
pub(crate) fn truth(seed: u32) -> (bool, f64) {
    let Drawn { sticks, s, .. } = Which { seed }.valve();
    (sticks, s)
}

impl Which {
    fn valve(self) -> Drawn {
        let own = mixed(u64::from(self.seed) ^ 0x7e57);
        let between = |(low, high): (f64, f64), k: u64| low + (high - low) * share(mixed(own ^ k));
        let tenth = |x: f64| (10.0 * x).round() / 10.0;
        let sticks = !own.is_multiple_of(3);
        let s = tenth(between(if sticks { STICKS } else { HEALTHY }, 1));
        Drawn { sticks, s, j: tenth(s * between(JUMP, 2)) }
    }

    /// The loop of the exercise: the flow loop of the first room, with a wandering load.
    fn loop_request(self) -> LoopRequest {
        let Drawn { s, j, .. } = self.valve();
        let (sd, tau) = LOAD;
        let seed = u64::from(self.seed);
        let set = [
            format!("valve.S={s}"),
            format!("valve.J={j}"),
            format!("duration={LONGEST_S}"),
            format!("noise.seed={}", 2 * seed + 1),
            "load.1.signal=noise".to_owned(),
            format!("load.1.sd={sd}"),
            format!("load.1.tau={tau}"),
            format!("load.1.seed={}", 2 * seed + 2),
        ];
        LoopRequest::new("lab/flow", set)
    }
}

/// A running loop with its samples so far.
struct Run {
    live: Live,
    done: Samples,
}

impl Run {
    fn new(which: Which) -> Answer<Self> {
        Ok(Self { live: Live::of(which.loop_request())?, done: Samples::default() })
    }

    /// An exercise, simulated from the start.
    fn of(exercise: &Exercise) -> Answer<Self> {
        exercise.check()?;
        let mut run = Self::new(Which { seed: exercise.seed })?;
        for set in &exercise.sets {
            run.go_to(set.at_s)?;
            run.live.by_hand(set.op);
        }
        run.go_to(exercise.until_s)?;
        Ok(run)
    }

    /// Goes on to a time, s.
    fn go_to(&mut self, time_s: f64) -> Answer<()> {
        let until = (time_s / self.live.sample_time() - 1e-6).ceil() as usize;
        let samples = self.live.go(until.saturating_sub(self.done.len()))?;
        self.done.append(samples);
        Ok(())
    }

    fn time_s(&self) -> f64 {
        self.done.len() as f64 * self.live.sample_time()
    }

    fn recorded(&self, from: usize) -> Recorded {
        let tail = |of: &[f64]| of.get(from..).unwrap_or_default().to_vec();
        Recorded {
            sample_time_s: self.live.sample_time(),
            from,
            op: tail(&self.done.op),
            pv: tail(&self.done.pv),
        }
    }

    fn recording(&self) -> Answer<Recording> {
        let Samples { sp, pv, op, .. } = &self.done;
        let step = self.live.sample_time();
        let mut recording = Recording::regular("exercise", step, op, Some(pv), Some(sp))?;
        if let Some(pv) = &mut recording.pv {
            pv.unit = Some("%".to_owned());
        }
        Ok(recording)
    }
}

impl Exercise {
    fn check(&self) -> Answer<()> {
        let refuse = |why: String| Err(Wrong::request(why));
        if !(0.0..=LONGEST_S).contains(&self.until_s) {
            return refuse(format!("an exercise runs for 0 to {LONGEST_S} s; restart it"));
        }
        if self.sets.len() > SETS {
            return refuse(format!("an exercise has at most {SETS} OP settings; restart it"));
        }
        let mut last = OPERATION_S;
        for Hand { at_s, op } in self.sets.iter().copied() {
            if at_s < OPERATION_S {
                return refuse(format!(
                    "the OP was set at {at_s} s, but the loop is in automatic until {OPERATION_S} s; set the OP later"
                ));
            }
            if !(last..=self.until_s).contains(&at_s) {
                return refuse(format!(
                    "the OP was set at {at_s} s; each setting must be after the previous setting and before the end at {} s",
                    self.until_s
                ));
            }
            if let Some(op) = op
                && !(0.0..=100.0).contains(&op)
            {
                return refuse(format!(
                    "the OP was set to {op} %, but must be from 0 to 100 % of span"
                ));
            }
            last = at_s;
        }
        Ok(())
    }

    /// The sets as the sheet of a test.
    fn sheet(&self) -> ByHand {
        let set = |hand: &Hand| Set { at_s: hand.at_s, op: hand.op };
        let mut sets: Vec<Set> = self.sets.iter().map(set).collect();
        // The test ends with the recording if the controller is in manual still.
        if sets.last().is_some_and(|last| last.op.is_some()) {
            sets.push(Set { at_s: self.until_s, op: None });
        }
        ByHand { sets, known_by: KnownBy::Sheet }
    }
}

/// The test plan for the loop from its operation, as from `stiction test plan --rises`.
fn planned(run: &Run) -> Answer<TestPlan> {
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let diagnosis = diagnose(&run.recording()?, &options)?;
    let options = PlanOptions { rises: Some(true), ..PlanOptions::default() };
    plan_of(&diagnosis, &options).map_err(|why| Wrong::own(why.0))
}

/// The loop before the test, with its plan.
///
/// # Errors
/// If no plan exists for the loop.
pub fn begin(_: &Lab, which: Which) -> Answer<Before> {
    let mut run = Run::new(which)?;
    run.go_to(OPERATION_S)?;
    Ok(Before { until_s: OPERATION_S, longest_s: LONGEST_S, most_sets: SETS, plan: planned(&run)? })
}

/// The recording.
///
/// # Errors
/// If the sets are not in order, or out of range.
pub fn trend(_: &Lab, look: Look) -> Answer<Recorded> {
    Ok(Run::of(&look.exercise)?.recorded(look.from))
}

/// The lab carries out the plan by itself.
///
/// # Errors
/// If there is no plan.
pub fn carry_out(_: &Lab, which: Which) -> Answer<CompletedTest> {
    let mut run = Run::new(which)?;
    run.go_to(OPERATION_S)?;
    let plan = planned(&run)?;
    let (run, sets) = operator::carry_out(run, &plan)?;
    Ok(CompletedTest { sets, until_s: run.time_s(), recorded: run.recorded(0) })
}

/// The result of the test, as from `stiction test read --done --rises`.
///
/// # Errors
/// If the test cannot be read. The sentence names what is missing.
pub fn read(_: &Lab, exercise: Exercise) -> Answer<Reading> {
    let recording = Run::of(&exercise)?.recording()?;
    if exercise.sets.iter().filter(|set| set.op.is_some()).count() < 2 {
        return Err(Wrong::request(
            "a test needs two turns or more; put the controller in manual and turn the OP up and down",
        ));
    }
    let options = ReadOptions {
        by_hand: Some(exercise.sheet()),
        rises: Some(true),
        ..ReadOptions::default()
    };
    let test = read_test(&recording, &options).map_err(|why| Wrong::request(why.0))?;
    Ok(Reading {
        probability: words::percent(test.probability),
        s: test.s.map(words::interval),
        j: test.j.map(words::interval),
        s_below: test.s_below.map(|limit| format!("{} %", words::rough(limit))),
        svg: valve_test_figure::figure("exercise", Some("%"), &test).svg().map_err(Wrong::own)?,
        test,
    })
}

/// The truth about the valve.
///
/// # Errors
/// As of [`trend`].
pub fn reveal(_: &Lab, exercise: Exercise) -> Answer<Truth> {
    let run = Run::of(&exercise)?;
    let Drawn { sticks, s, j } = Which { seed: exercise.seed }.valve();
    Ok(Truth { sticks, s, j, vp: run.done.vp })
}
