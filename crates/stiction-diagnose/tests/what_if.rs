//! What-if on one loop: the positioner's equivalence, rows that agree with plain simulations, the ranking, and
//! recommendations that a plant engineer could follow.

use crate::common;

use common::valve;
use std::sync::atomic::{AtomicUsize, Ordering};
use stiction_diagnose::what_if::{
    Action, Prediction, Row, WEARING, WORTH, WhatIf, WhatIfOptions, positioned, what_if,
    what_if_with_progress,
};
use stiction_model::closed_loop::{AntiWindup, ClosedLoop, Controller, NormalStream, Process};
use stiction_model::compensate::Method;
use stiction_model::valve::{Model, Start, TwoPhase, Valve};
use stiction_model::{Bands, Error};

fn bands(s: f64, j: f64) -> Bands {
    Bands::from_s_j(s, j).unwrap()
}

fn looped(controller: Controller, process: Process, model: Model, b: Bands) -> ClosedLoop {
    let mut plant = ClosedLoop::new(controller, valve(model, b.s(), b.j()), process);
    plant.set_point = 5.0.into();
    plant
}

/// The paper's loop.
fn paper(model: Model, b: Bands) -> ClosedLoop {
    let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
    looped(Controller::pi(1.1, 2.5).unwrap(), process, model, b)
}

fn asked(plant: &ClosedLoop, model: Model, b: Bands) -> WhatIf {
    what_if(plant, model, b, &WhatIfOptions::suiting(plant, model, b).unwrap()).unwrap()
}

fn row(found: &WhatIf, wanted: impl Fn(&Action) -> bool) -> &Row {
    found.rows.iter().find(|row| wanted(&row.action)).unwrap()
}

fn said(found: &WhatIf, words: &str) -> bool {
    found.recommendation.iter().any(|sentence| sentence.contains(words))
}

/// A two-phase stem behind `p = op + g (op - vp)`, in its own terms: it knows `p`, `fs` and `fd` alone. The loop of
/// stem and positioner is solved at every sample, as by a positioner that is faster than a slip.
struct Positioned {
    bands: Bands,
    gain: f64,
    x: f64,
    /// Signal of the positioner at the last sample.
    p: f64,
    /// 0 while stuck.
    moving: f64,
}

impl Positioned {
    fn step(&mut self, op: f64) -> f64 {
        let (g, fs, fd) = (self.gain, self.bands.fs(), self.bands.fd());
        // A moving stem trails p by fd, and p depends on where it is.
        let trailing = |d: f64| ((1.0 + g) * op - d * fd) / (1.0 + g);
        let signal = |x: f64| op + g * (op - x);
        let going = trailing(self.moving);
        if !(self.moving != 0.0 && (signal(going) - self.p) * self.moving > 0.0) {
            let force = signal(self.x) - self.x;
            self.moving = if force.abs() > fs { force.signum() } else { 0.0 };
        }
        if self.moving != 0.0 {
            self.x = trailing(self.moving);
        }
        self.p = signal(self.x);
        self.x
    }
}

/// Sample by sample to rounding: one part in 10^12 of the span, over random walks with stops, for every gain.
#[test]
fn a_fast_positioner_divides_both_bands() {
    let mut random = NormalStream::new(7);
    for (s, j) in [(5.0, 3.0), (5.0, 0.0), (4.0, 4.0), (3.0, 5.0)] {
        for gain in [0.0, 0.3, 1.0, 10.0] {
            let b = bands(s, j);
            let mut inner = Positioned { bands: b, gain, x: 0.0, p: 0.0, moving: 0.0 };
            let mut outer = TwoPhase::new(positioned(b, gain).unwrap());
            outer.restart(Start::at_rest(0.0));
            let (mut op, mut moved) = (0.0, 0);
            for k in 0..20_000 {
                // Now and then it stands still, which sticks a stem.
                op += if k % 7 == 0 { 0.0 } else { 0.4 * random.draw() };
                let before = outer.position();
                let (found, expected) = (inner.step(op), outer.step(op));
                assert!((found - expected).abs() < 1e-10, "{s} {j} {gain} {k}: {found} {expected}");
                moved += usize::from(expected != before);
            }
            assert!(moved > 100);
        }
    }
    assert!(positioned(bands(5.0, 3.0), -0.1).is_err());
}

/// The limit of that: a positioner that answers only after the slip hunts at a constant OP if `g J > S`, and is
/// quiet below.
#[test]
fn a_slow_positioner_hunts_where_g_j_exceeds_s() {
    let hunts = |s: f64, j: f64, gain: f64| {
        let mut stem = TwoPhase::new(bands(s, j));
        stem.restart(Start::at_rest(0.0));
        let (op, mut moves) = (20.0, 0);
        for k in 0..400 {
            let x = stem.position();
            // One step to move the stem, one to let the pressure follow.
            let vp = stem.step(op + gain * (op - x));
            moves += usize::from(k >= 200 && vp != x);
        }
        moves > 0
    };
    assert!(hunts(5.0, 3.0, 10.0) && hunts(5.0, 3.0, 2.0));
    assert!(!hunts(5.0, 0.2, 0.9) && !hunts(5.0, 1.0, 0.5));
}

/// The row of the loop as it is comes from the plain simulation, bit for bit.
#[test]
fn as_it_is_is_the_plain_simulation() {
    let b = bands(5.0, 3.0);
    let plant = paper(Model::TwoPhase, b);
    let options = WhatIfOptions {
        methods: vec![],
        ..WhatIfOptions::suiting(&plant, Model::TwoPhase, b).unwrap()
    };
    let found = what_if(&plant, Model::TwoPhase, b, &options).unwrap();
    let [from, to, ..] = options.protocol.times();
    let index = |t: f64| (t / plant.sample_time - 1e-9).ceil() as usize;
    let run = ClosedLoop { samples: index(to), ..plant }.run().unwrap();
    let window = index(from)..index(to);
    let row = found.as_it_is().unwrap();
    let error = |k: usize| (run.sp[k] - run.pv[k]).abs();
    let mean = window.clone().map(error).sum::<f64>() / window.len() as f64;
    assert_eq!(row.error(), mean);
    assert_eq!(row.nominal().measures.pv_std, stiction_diagnose::series::std(&run.pv[window]));
    assert_eq!(row.worst_error(), row.error());
}

#[test]
fn the_papers_loop() {
    let b = bands(5.0, 3.0);
    let mut plant = paper(Model::TwoPhase, b);
    // Sampled faster, no throw of it could be followed by a stem.
    let faster = asked(&plant, Model::TwoPhase, b);
    let throws = row(&faster, |action| *action == Action::Compensate(Method::ModifiedTwoMove));
    assert!(throws.against.iter().any(|said| said.contains("faster than a pneumatic actuator")));
    plant.sample_time = 0.25;
    let found = asked(&plant, Model::TwoPhase, b);
    assert!(found.rows.windows(2).all(|w| w[0].worst_error() <= w[1].worst_error()));
    assert_eq!(found.rows.len(), 4 + Method::ALL.len());

    let now = found.as_it_is().unwrap();
    let cycle = now.cycle.cycle().unwrap();
    assert!((cycle.period_s - 18.04367).abs() < 1e-4);
    let repaired = row(&found, |action| *action == Action::Repair);
    assert!(repaired.nominal().measures.pv_std < 0.1 * now.nominal().measures.pv_std);
    let positioner = row(&found, |action| matches!(action, Action::Positioner(_)));
    // S and J are divided by 11, J over S stays: so does the period.
    assert!((positioner.cycle.cycle().unwrap().period_s - cycle.period_s).abs() < 1e-6);

    // What is recommended must be harmless, whatever S and J are.
    let best = found.interim().unwrap();
    assert!(best.against.is_empty() && WORTH * best.worst_error() <= now.error());
    let travel = |row: &Row| row.played.worst(|outcome| outcome.measures.vp_travel_per_s);
    assert!(travel(best) <= WEARING * travel(now));
    assert!(best.played.quiet().all(|outcome| outcome.load_settling_s.is_some()));
    assert_eq!(best.action, Action::Compensate(Method::ModifiedTwoMove));
    for worse in [Method::TwoMove, Method::ThreeMove, Method::IntegralDeadZone] {
        let row = row(&found, |action| *action == Action::Compensate(worse));
        assert!(row.worst_error() > now.error());
        assert!(row.against[0].contains("larger error than now"), "{:?}", row.against);
    }
    assert!(said(&found, "Repair the valve to remove the cause"));
    assert!(said(&found, "compensate it (modified-two-move"));
    assert!(said(&found, "worthwhile only if load steps of 5 % come less often than"));
    assert!(said(&found, "Do not rely on the positioner"));
    assert!(!said(&found, "NaN") && !said(&found, "inf"));

    let test = found.confirm.unwrap();
    assert_eq!((test.rises, test.grow[0].op > 0.0), (Some(true), true));
    // Long enough for the process to settle: dead time and three time constants are 18.9 s.
    assert!(test.grow[0].hold_s >= 18.0 && test.op_high - test.op_low >= 10.0, "{test:?}");
}

/// The tuning's predicted cycle is what its simulation tends to as the sample time goes to 0.
#[test]
fn a_retuned_loop_cycles_as_predicted() {
    let b = bands(5.0, 3.0);
    let mut plant = paper(Model::TwoPhase, b);
    plant.sample_time = 0.01;
    let options = WhatIfOptions {
        methods: vec![],
        ..WhatIfOptions::suiting(&plant, Model::TwoPhase, b).unwrap()
    };
    let found = what_if(&plant, Model::TwoPhase, b, &options).unwrap();
    let retuned = row(&found, |action| matches!(action, Action::Retune(_)));
    let cycle = retuned.cycle.cycle().unwrap();
    let simulated = retuned.nominal().measures;
    assert!((simulated.pv_half_pp / cycle.half_pp.pv - 1.0).abs() < 0.02);
    assert!((simulated.vp_half_pp / cycle.half_pp.vp - 1.0).abs() < 0.02);
    // Two reversals a period.
    let period = 7200.0 / simulated.reversals_per_h;
    assert!((period / cycle.period_s - 1.0).abs() < 0.05, "{period}");
    let retuning = found.retuning.as_ref().unwrap();
    assert!(retuning.pv_ratio.unwrap() < 0.7);
    assert!(retuning.best.peak_sensitivity <= options.most_sensitive);
    // With S and J wrong another tuning is chosen, and cannot be better.
    assert!(retuned.worst_error() >= retuned.error());
}

/// Dead band alone does not cycle in a self-regulating loop, nor does anything without integral action.
#[test]
fn loops_without_a_cycle() {
    let b = bands(5.0, 0.0);
    let found = asked(&paper(Model::TwoPhase, b), Model::TwoPhase, b);
    assert!(matches!(found.as_it_is().unwrap().cycle, Prediction::NoCycle(_)));
    assert!(said(&found, "has no limit cycle (decays"));
    assert!(said(&found, "Repair the valve"));
    assert!(found.interim().is_none() && said(&found, "leave the loop as it is"));
    assert!(found.retuning.unwrap_err().contains("no limit cycle to remove by tuning"));

    let b = bands(5.0, 3.0);
    let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
    let plant = looped(Controller::p(1.0).unwrap(), process, Model::TwoPhase, b);
    let found = asked(&plant, Model::TwoPhase, b);
    assert!(said(&found, "The stem is at rest"));
    // Nothing moves from which a test could be sized.
    let why =
        |text: &String| text.starts_with("No test of the valve can be planned, because the OP");
    assert!(found.confirm.is_none() && found.assumptions.iter().any(why));

    let found = asked(&paper(Model::Ideal, Bands::NONE), Model::Ideal, Bands::NONE);
    assert_eq!(found.recommendation.len(), 1);
    assert!(said(&found, "does not stick") && found.confirm.is_none());
}

#[test]
fn an_integrating_level_loop() {
    let b = bands(5.0, 2.0);
    let process = Process::integrator(1.0, 0.0).unwrap();
    let mut plant = looped(Controller::pi(0.4, 2.0).unwrap(), process, Model::TwoPhase, b);
    plant.sample_time = 0.05;
    let found = asked(&plant, Model::TwoPhase, b);
    let cycle = found.as_it_is().unwrap().cycle.cycle().unwrap();
    assert!((cycle.period_s - 16.1491).abs() < 1e-3);
    assert!(said(&found, "Repair the valve to remove the cause"));
    if let Some(best) = found.interim() {
        assert!(best.against.is_empty());
    }
}

#[test]
fn a_he_valve_has_a_family_of_cycles() {
    let b = bands(5.0, 3.0);
    let found = asked(&paper(Model::He, b), Model::He, b);
    let cycle = found.as_it_is().unwrap().cycle.cycle().unwrap();
    assert!((cycle.period_s - 24.36791).abs() < 1e-4);
    assert!(found.assumptions.iter().any(|sentence| sentence.contains("family of limit cycles")));
    assert!(said(&found, "Repair the valve"));
}

/// A loop that is unstable by itself is not helped by its valve, and no compensator is recommended.
#[test]
fn an_unstable_loop_is_retuned_first() {
    let b = bands(5.0, 3.0);
    let controller = Controller::pi(6.0, 2.5).unwrap();
    let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
    let limited = controller.clone().with_limits(0.0, 100.0, AntiWindup::Clamping).unwrap();
    let mut plant = looped(limited, process.clone(), Model::TwoPhase, b);
    plant.set_point = 50.0.into();
    let found = asked(&plant, Model::TwoPhase, b);
    assert!(found.recommendation[0].starts_with("The loop is unstable"));
    assert!(found.interim().is_none() && said(&found, "A repair would change little"));
    // Without limits it grows beyond all numbers.
    let plant = looped(controller, process, Model::TwoPhase, b);
    let mut options = WhatIfOptions::suiting(&plant, Model::TwoPhase, b).unwrap();
    options.protocol.from_s = 1e5;
    let refused = what_if(&plant, Model::TwoPhase, b, &options).unwrap_err().to_string();
    assert!(refused.contains("grows without bound"), "{refused}");
}

#[test]
fn the_same_on_any_number_of_threads() {
    let b = bands(5.0, 3.0);
    let plant = paper(Model::TwoPhase, b);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        format!("{:?}", pool.install(|| asked(&plant, Model::TwoPhase, b)))
    };
    assert_eq!(on(1), on(3));
}

/// Whoever watches can give up at any time, also while tunings are tried.
#[test]
fn what_is_watched_can_be_cancelled() {
    let b = bands(5.0, 3.0);
    let plant = paper(Model::TwoPhase, b);
    let options = WhatIfOptions {
        methods: vec![Method::Knocker],
        ..WhatIfOptions::suiting(&plant, Model::TwoPhase, b).unwrap()
    };
    let count = AtomicUsize::new(0);
    let upto = |most: usize| {
        count.store(0, Ordering::Relaxed);
        let done = || count.fetch_add(1, Ordering::Relaxed) + 1 < most;
        what_if_with_progress(&plant, Model::TwoPhase, b, &options, done)
    };
    assert!(upto(usize::MAX).unwrap().as_it_is().is_some());
    let all = count.load(Ordering::Relaxed);
    for most in [1, 10, all / 2, all] {
        assert_eq!(upto(most), Err(Error::Cancelled), "{most} of {all}");
    }
}

/// A run of more samples than memory has is refused.
#[test]
fn too_long_a_protocol_is_refused() {
    let b = bands(5.0, 3.0);
    let plant = paper(Model::TwoPhase, b);
    let mut options = WhatIfOptions::suiting(&plant, Model::TwoPhase, b).unwrap();
    options.protocol.step_s = 1e9;
    let refused = what_if(&plant, Model::TwoPhase, b, &options).unwrap_err().to_string();
    assert!(refused.contains("samples"), "{refused}");
}
