//! Advice to test a valve or to act on its loop, followed on simulated loops.

use super::record::judged;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, VerdictClass, diagnose};
use stiction_diagnose::fit::prospects::{Prospect, Remedy};
use stiction_diagnose::fit::{FitOptions, fit, prospects};
use stiction_diagnose::recording::{ByHand, Channel, KnownBy, Recording, Set};
use stiction_diagnose::valve_test::{
    PlanOptions, ReadOptions, Repetition, TestReading, plan, read,
};
use stiction_diagnose::what_if::{WhatIfOptions, knowledge, positioned};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, NormalStream, Process, Signal};
use stiction_model::compensate::nominal;
use stiction_model::valve::{Model, Start, Valve};
use stiction_population::{LoopKind, Operator, ToPlan, Trend};
use stiction_report::words::what_would_answer;
use stiction_score::{TestTrial, TestTrialOptions, TestedLoops};

/// `confirm`, and "a test of the valve" among what is needed: the operator carries out the plan.
#[test]
fn a_planned_test_decides_most_open_loops() {
    let options = TestTrialOptions {
        loops: TestedLoops::Population,
        operator: Operator::Careful,
        trend: Trend::AsPlanned,
    };
    let found = TestTrial::run(351, 30, options, || ()).unwrap();
    let [open, right] = [found.undecided, found.undecided_right];
    assert!(2 * open.k >= open.n && 10 * right.k >= 9 * right.n, "{open:?} {right:?}");
}

/// Steps of one size seldom decide, which the advice says, so the operator carries out the plan.
#[test]
fn a_test_decides_a_valve_with_few_slips() {
    let mut classes = vec![];
    for seed in 550..600 {
        let mut advised = |before: &Recording, known: ToPlan| {
            let found = judged(before);
            found.few_slips.as_ref()?;
            let advice = what_would_answer(&found)?;
            let is_honest = advice.contains("may decide") && advice.contains("seldom conclusive");
            assert!(is_honest && advice.starts_with("A test of the valve"), "{advice}");
            let (rises, pv_allowed) = (Some(known.rises), Some(known.pv_allowed));
            plan(&found, &PlanOptions { rises, pv_allowed, ..PlanOptions::default() }).ok()
        };
        let tested =
            LoopKind::Sticky.tested(seed, 3.0, Operator::Careful, Trend::AsPlanned, &mut advised);
        let Some(tested) = tested.unwrap().filter(|tested| tested.carried.turns > 0) else {
            continue;
        };
        let by_hand = Some(tested.carried.sheet);
        let reading = read(&tested.whole, &ReadOptions { by_hand, ..ReadOptions::default() });
        classes.push(reading.map_or(VerdictClass::CannotTell, |reading| reading.class));
    }
    let found = classes.iter().filter(|class| **class == VerdictClass::Sticks).count();
    assert!(found > 0 && 4 * found >= 3 * classes.len(), "{classes:?}");
}

/// A test by hand of a loop.
#[derive(Clone)]
struct Hand {
    /// The OP of each hold from that in operation, percent.
    offsets: Vec<f64>,
    /// Samples of a hold.
    hold: usize,
    /// S and J of the valve.
    bands: (f64, f64),
    /// Dead band of the transmitter, percent.
    behind: f64,
    /// Time constant of the process, samples, and the noise of the PV.
    tau: f64,
    noise: f64,
    with_position: bool,
}

/// Turns up and down by each of these sizes.
fn turns(sizes: impl IntoIterator<Item = f64>) -> Vec<f64> {
    sizes.into_iter().flat_map(|size| [0.5 * size, -0.5 * size]).collect()
}

/// Turns from 0.4 to 9 % and back, as in a plan.
fn varied() -> Vec<f64> {
    let up = (0..14).map(|k| 0.4 * 1.27f64.powi(k));
    turns(up.clone().chain(up.rev()))
}

impl Hand {
    fn read(&self, seed: u64) -> TestReading {
        let wander = |k: f64| 45.0 + 1.5 * (0.02 * k).sin() + 0.7 * (0.047 * k).sin();
        let mut op: Vec<f64> = (0..400).map(|k| wander(f64::from(k))).collect();
        let rest = op[op.len() - 1];
        let mut sets = vec![];
        for offset in &self.offsets {
            sets.push(Set { at_s: op.len() as f64, op: Some(rest + offset) });
            op.extend(std::iter::repeat_n(rest + offset, self.hold));
        }
        sets.push(Set { at_s: op.len() as f64, op: None });
        op.extend([rest; 60]);
        let stem = |s: f64, j: f64| {
            let mut stem = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
            stem.restart(Start::at_rest(op[0]));
            stem
        };
        let (mut valve, mut behind) = (stem(self.bands.0, self.bands.1), stem(self.behind, 0.0));
        let (mut flow, mut noise) = (op[0], NormalStream::new(seed));
        let vp: Vec<f64> = op.iter().map(|op| valve.step(*op)).collect();
        let measured = |vp: &f64| {
            flow += (vp - flow) / self.tau;
            behind.step(flow) + self.noise * noise.draw()
        };
        let pv: Vec<f64> = vp.iter().map(measured).collect();
        let mut recording = Recording::regular("FIC1", 1.0, &op, Some(&pv), None).unwrap();
        if self.with_position {
            recording.vp = Some(Channel::new("VP", recording.op.time.clone(), vp).unwrap());
        }
        let by_hand = Some(ByHand { sets, known_by: KnownBy::Sheet });
        read(&recording, &ReadOptions { by_hand, ..ReadOptions::default() }).unwrap()
    }
}

/// A test for which the advice is given, and the same repeated as advised.
fn repeated(as_advised: Repetition) -> (Hand, Hand) {
    let plain = Hand {
        offsets: varied(),
        hold: 25,
        bands: (4.0, 1.0),
        behind: 0.0,
        tau: 4.0,
        noise: 0.05,
        with_position: false,
    };
    let first = |change: &dyn Fn(&mut Hand)| {
        let mut first = plain.clone();
        change(&mut first);
        first
    };
    match as_advised {
        Repetition::ThereAndBack => {
            let up: Vec<f64> = (1..7).map(|k| 3.0 * f64::from(k)).collect();
            let back = up.iter().rev().skip(1).copied();
            let there_and_back = up.iter().copied().chain(back).collect();
            (
                first(&|of| of.offsets = up.clone()),
                Hand { offsets: there_and_back, ..plain.clone() },
            )
        }
        Repetition::LongerHolds => {
            let stairs: Vec<f64> = [0.0, 5.0, 10.0, 15.0, 20.0, 15.0, 10.0, 5.0, 0.0].to_vec();
            let slow =
                first(&|of| (of.offsets, of.tau, of.bands) = (stairs.clone(), 90.0, (4.0, 1.0)));
            (slow.clone(), Hand { hold: 500, ..slow })
        }
        Repetition::WithPosition => {
            let play = first(&|of| {
                (of.bands, of.behind, of.tau, of.hold) = ((0.0, 0.0), 4.0, 25.0, 60);
            });
            (play.clone(), Hand { with_position: true, ..play })
        }
        Repetition::NoAnswer => {
            let seized = first(&|of| {
                of.offsets.iter_mut().for_each(|offset| *offset *= 3.0);
                of.bands = (300.0, 0.0);
            });
            (seized.clone(), Hand { with_position: true, ..seized })
        }
        Repetition::LargerTurns => {
            (first(&|of| of.offsets = turns([1.0, 1.5, 2.0, 2.5, 2.0, 1.5])), plain.clone())
        }
        Repetition::SmallerTurns => {
            (first(&|of| of.offsets = turns([7.0, 8.0, 9.0, 8.0])), plain.clone())
        }
        Repetition::CalmerTime => (first(&|of| of.noise = 7.0), plain.clone()),
    }
}

#[test]
fn an_inconclusive_test_decides_once_it_is_repeated() {
    for how in Repetition::ALL {
        let (first, again) = repeated(how);
        let seed = (0..4).find(|seed| first.read(*seed).advice.as_deref() == Some(how.name()));
        let reading = again.read(seed.unwrap_or_else(|| panic!("{how:?} is not advised")));
        let truth = match again.bands.0 {
            s if s > 100.0 => VerdictClass::DoesNotRespond,
            s if s > 0.0 => VerdictClass::Sticks,
            _ => VerdictClass::DoesNotStick,
        };
        assert_eq!(reading.class, truth, "{how:?}: {reading:?}");
    }
}

/// Actions on a fitted loop, taken on the loop itself.
#[test]
fn a_certain_benefit_comes_when_the_action_is_taken() {
    let bands = Bands::from_s_j(4.0, 2.0).unwrap();
    let of = |bands: Bands, controller: Controller| {
        let process = Process::first_order(1.5, 12.0, 3.0).unwrap();
        let mut plant =
            ClosedLoop::new(controller, Model::TwoPhase.build(bands).unwrap().into(), process);
        (plant.samples, plant.op_rest, plant.pv_rest) = (3000, 50.0, 60.0);
        plant.set_point = 61.0.into();
        plant.measurement = vec![Signal::Noise { sd: 0.05, tau_s: 0.0, seed: 3 }];
        plant
    };
    let present = || Controller::pi(1.2, 12.0).unwrap();
    let plant = of(bands, present());
    let run = plant.run().unwrap();
    let recording =
        Recording::regular("FIC1", run.sample_time, &run.op, Some(&run.pv), Some(&run.sp)).unwrap();
    let options = DiagnoseOptions { detectors: Detectors::None, ..DiagnoseOptions::default() };
    let fitted = fit(&diagnose(&recording, &options).unwrap(), &FitOptions::default()).unwrap();
    let found = prospects(&fitted).unwrap();
    let protocol = WhatIfOptions::suiting(&plant, Model::TwoPhase, bands).unwrap().protocol;
    let swing = |row: &Prospect| {
        let retuned = || row.tuning.map(|new| Controller::pi(new.kc, new.ti).unwrap());
        let healthy = Bands::from_s_j(0.4, 0.1).unwrap();
        let (plant, method) = match row.action {
            Remedy::AsItIs => (of(bands, present()), None),
            Remedy::Repair => (of(healthy, present()), None),
            Remedy::Retune => (of(bands, retuned().unwrap()), None),
            Remedy::RepairAndRetune => (of(healthy, retuned().unwrap()), None),
            Remedy::Positioner => (of(positioned(bands, 10.0).unwrap(), present()), None),
            Remedy::Compensate(method) => (of(bands, present()), Some(method)),
        };
        let (outcome, _) = nominal(&plant, &knowledge(&plant, bands), method, &protocol).unwrap();
        outcome.measures.pv_std
    };
    let before = found.actions.iter().find(|row| row.action == Remedy::AsItIs).map(swing).unwrap();
    for row in &found.actions {
        if row.certain() {
            assert!(swing(row) < 0.8 * before, "{:?}", row.action);
        }
    }
    let certain = found.actions.iter().filter(|row| row.certain()).count();
    assert!(certain >= 2, "{:?}", found.actions);
    // A setting without an expected benefit is not advised.
    let retuned = found.actions.iter().find(|row| row.action == Remedy::Retune).unwrap();
    let is_advised = found.advice.iter().any(|advice| advice.contains("Retune to"));
    assert!(!is_advised && !retuned.probable(), "{:?}", found.advice);
}
