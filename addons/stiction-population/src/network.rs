//! Plants of coupled loops: which valves stick, and which loops their swing reaches.
//!
//! ```text
//! Network (drawn) ──> NetworkRun, step by step on one clock ──> Samples of each loop ──> Recording
//!                └──> the same without one cause at a time  ──> NetworkTruth: loops it reaches
//! ```
//! A loop has a valve of the population's models, a PI controller, a process with dead time, a wandering load, noise,
//! and a historian that takes a sample every few steps. A [`Link`] couples two loops. The output of one loop acts on
//! the load of the other after a dead time and a lag. The upper loop of a cascade writes the set point of the loop
//! [below](NetworkLoop::below) it. A signal from [`Outside`] enters several loops at once.

mod drawn;
mod run;
mod truth;

pub use run::{NetworkRun, Samples};
pub use truth::{Cause, NetworkTruth, Reach};

use super::ProcessKind;
use stiction_diagnose::recording::LoopType;
use stiction_model::closed_loop::Signal;
use stiction_model::error::{Error, Result};
use stiction_model::valve::Model;

/// Time between two steps of the common clock, s.
pub const STEP_S: f64 = 5.0;
/// The most loops of a network.
pub const MOST_LOOPS: usize = 100;

/// A network of coupled loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// The loops. A loop writes only the set point of later loops.
    pub loops: Vec<NetworkLoop>,
    /// The couplings.
    pub links: Vec<Link>,
    /// The signals from outside.
    pub outside: Vec<Outside>,
}

/// Settings of a drawn network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetworkPlan {
    /// Number of loops.
    pub loops: usize,
    /// The loops with sticking valves.
    pub sticking: Vec<usize>,
    /// Number of waves from outside.
    pub outside: usize,
    /// Whether the loops act on each other, and waves reach several loops. Uncoupled loops may still swing, each by
    /// itself.
    pub coupled: bool,
}

/// A loop of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkLoop {
    /// The controlled quantity.
    pub loop_type: LoopType,
    /// Process: first order, second order, or an integrator, with a dead time.
    pub process: ProcessKind,
    /// Time between recorded samples, s: a multiple of [`STEP_S`].
    pub sample_time_s: f64,
    /// The model of its valve while it sticks.
    pub model: Model,
    /// Stick band plus dead band of its valve while it sticks, percent of span.
    pub s: f64,
    /// Slip jump of its valve while it sticks, percent of span.
    pub j: f64,
    /// When its valve sticks.
    pub course: Course,
    /// Times in each day in which the loop is in manual and the OP rests, s from the begin of the day.
    pub manual: Option<(f64, f64)>,
    /// The loop whose set point this loop writes, instead of having a valve.
    pub below: Option<usize>,
    /// Settings for its simulation only.
    design: Design,
}

/// Times in which a valve sticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// Never.
    Healthy,
    /// Always, with constant S.
    Sticks,
    /// Until this time, s from the first step of the record on.
    Repaired {
        /// Time of the repair.
        at_s: f64,
    },
    /// From this time on.
    Begins {
        /// Time of the beginning.
        at_s: f64,
    },
    /// Always and increasingly: S and J grow evenly, from their values at the first step.
    Grows {
        /// By this total factor.
        factor: f64,
        /// Within this time, s.
        within_s: f64,
    },
}

impl Course {
    /// Whether the valve sticks `at` this time, s from the first step of the record on.
    pub fn sticks(self, at: f64) -> bool {
        match self {
            Self::Healthy => false,
            Self::Sticks | Self::Grows { .. } => true,
            Self::Repaired { at_s } => at < at_s,
            Self::Begins { at_s } => at >= at_s,
        }
    }

    /// Whether it ever sticks.
    pub fn ever(self) -> bool {
        self != Self::Healthy
    }
}

/// The effect of a loop on the load of another.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// The acting loop.
    pub from: usize,
    /// The affected loop.
    pub to: usize,
    /// The kind of coupling.
    pub kind: LinkKind,
    /// Percent of load for one percent of valve, or of PV over the gain of its process.
    pub gain: f64,
    /// Dead time, s.
    pub dead_s: f64,
    /// Lag of the first order, s.
    pub lag_s: f64,
}

/// The kind of coupling of two loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LinkKind {
    /// The outflow of one unit enters the next. It is the flow out of a level, or else the PV.
    MassBalance,
    /// The outflow of a later unit returns, late and smoothed.
    Recycle,
    /// One header feeds both units. If one valve opens, the other unit gets less.
    Header,
}

/// A wave from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Outside {
    /// Signal, around zero.
    pub wave: Signal,
    /// Period, s.
    pub period_s: f64,
    /// The loops with this wave in their load, and its size: percent of load.
    pub into: Vec<(usize, f64)>,
}

/// Drawn parts of a loop for its simulation only.
#[derive(Debug, Clone, PartialEq)]
struct Design {
    /// Percent of span per percent; for an integrator, after one `tau`.
    gain: f64,
    tau: f64,
    tau2: f64,
    dead_time: f64,
    curve: super::design::Curve,
    kc: f64,
    ti: f64,
    /// Width of the play of the healthy valve, percent.
    dead_band: f64,
    op_rest: f64,
    pv_rest: f64,
    /// Added to the load, percent, and to the PV in the transmitter, percent of span.
    load: Signal,
    noise: Signal,
    /// Time between moves of the set point, s, and their size, percent of span.
    moves: Option<(f64, f64)>,
    op_quantum: f64,
    pv_quantum: f64,
    /// PV at 0 % and its span, in units of the plant.
    pv_range: (f64, f64),
    seed: u64,
}

impl Network {
    /// The network of this seed: 5 to 50 loops, 0 to 3 sticking valves, 0 to 2 waves from outside. One network in four
    /// has uncoupled loops.
    ///
    /// # Errors
    /// None is known.
    pub fn draw(seed: u64) -> Result<Self> {
        Self::planned(seed, &drawn::plan(seed))
    }

    /// The network of this seed and plan.
    ///
    /// # Errors
    /// If the plan has no loop, more than [`MOST_LOOPS`] loops, or a sticking loop with a higher number than the last
    /// loop.
    pub fn planned(seed: u64, plan: &NetworkPlan) -> Result<Self> {
        let n = plan.loops;
        if n == 0 || n > MOST_LOOPS || plan.sticking.iter().any(|k| *k >= n) {
            let rule = format!(
                "a network has 1 to {MOST_LOOPS} loops, and the sticking loops must be among them"
            );
            return Err(Error::Inconsistent(rule));
        }
        Ok(drawn::network(seed, plan))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_diagnose::series::span;

    fn plan(loops: usize, sticking: Vec<usize>, coupled: bool) -> NetworkPlan {
        NetworkPlan { loops, sticking, outside: 1, coupled }
    }

    #[test]
    fn a_record_in_two_parts_is_that_in_one_and_no_signal_runs_away() {
        for seed in 0..4 {
            let network = Network::planned(seed, &plan(12, vec![2, 5], true)).unwrap();
            let whole = network.run(None).unwrap().record(7200.0).unwrap();
            let mut run = network.run(None).unwrap();
            let (first, second) = (run.record(3605.0).unwrap(), run.record(3595.0).unwrap());
            for ((whole, first), second) in whole.iter().zip(&first).zip(&second) {
                assert_eq!(whole.pv, [&first.pv[..], &second.pv].concat());
                assert_eq!(whole.op, [&first.op[..], &second.op].concat());
                assert_eq!(second.from_s, first.pv.len() as f64 * first.step_s);
                assert!(whole.pv.iter().all(|v| v.is_finite()));
            }
        }
        assert!(Network::planned(1, &plan(3, vec![3], true)).is_err());
        assert_eq!(Network::draw(3).unwrap(), Network::draw(3).unwrap());
    }

    #[test]
    fn without_links_a_valve_reaches_its_own_loop_only() {
        let network = Network::planned(4, &plan(8, vec![1, 6], false)).unwrap();
        assert!(network.links.is_empty() && network.loops.iter().all(|own| own.below.is_none()));
        let samples = network.run(None).unwrap().record(86_400.0).unwrap();
        let truth = network.truth(&samples).unwrap();
        assert_eq!(truth.causes.len(), 3);
        for reach in &truth.causes[..2] {
            let Cause::Valve(valve) = reach.cause else { panic!("{reach:?}") };
            for k in (0..8).filter(|k| *k != valve) {
                assert!(reach.vanishes[k].abs() < 1e-9 && !reach.swings[k], "{reach:?}");
                assert!(truth.apart(valve, k));
            }
        }
    }

    #[test]
    fn what_a_valve_does_to_its_neighbour_vanishes_with_it() {
        // Some seed whose valve cycles and feeds the next loop.
        let reached = (0..40).any(|seed| {
            let network = Network::planned(seed, &plan(2, vec![0], true)).unwrap();
            let fed = network.links.iter().any(|link| (link.from, link.to) == (0, 1));
            let samples = network.run(None).unwrap().record(43_200.0).unwrap();
            let truth = network.truth(&samples).unwrap();
            let swings = &truth.causes[0].swings;
            assert!(fed || !swings[1] || !network.outside.is_empty(), "seed {seed}");
            fed && swings[0] && swings[1] && !truth.apart(0, 1)
        });
        assert!(reached);
    }

    #[test]
    fn a_repaired_valve_sticks_no_more_and_by_hand_the_op_rests() {
        let mut network = Network::planned(7, &plan(1, vec![0], false)).unwrap();
        network.outside.clear();
        network.loops[0].manual = Some((3600.0, 7200.0));
        let sticking = network.run(None).unwrap().record(36_000.0).unwrap();
        network.loops[0].course = Course::Repaired { at_s: 18_000.0 };
        let repaired = network.run(None).unwrap().record(36_000.0).unwrap();
        let n = (18_000.0 / sticking[0].step_s) as usize;
        assert_eq!(sticking[0].vp[..n], repaired[0].vp[..n]);
        assert_ne!(sticking[0].vp[n + 10..], repaired[0].vp[n + 10..]);
        let at = |t: f64| (t / sticking[0].step_s) as usize;
        let (from, to) = (at(3600.0) + 1, at(7200.0));
        assert!(span(&sticking[0].op[from..to]) == 0.0 && !sticking[0].auto[from]);
        assert!(span(&sticking[0].pv[from..to]) > 0.0 && sticking[0].auto[to + 1]);
    }
}
