//! The statistical detectors against independent reference values, public counts, and properties.

use serde_json::Value;
use std::path::Path;
use stiction_diagnose::finding::Decision;
use stiction_diagnose::methods::{
    Detector, Ellipse, Subject,
    bicoherence::Bicoherence,
    bicoherence_op::BicoherenceOp,
    butterfly::Butterfly,
    damarla_regression::DamarlaRegression,
    damarla_sigmoid::DamarlaSigmoid,
    damarla_steadiness::{DamarlaTest, SteadinessTest},
    sharp_corner::SharpCorner,
    surrogates::Surrogates,
};
use stiction_diagnose::recording::{LoopType, Segment};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal, Wave};
use stiction_model::valve::{Assembly, Model};

const TESTS: [SteadinessTest; 4] = [
    SteadinessTest::FTest,
    SteadinessTest::TTest,
    SteadinessTest::Hotelling,
    SteadinessTest::ReverseArrangements,
];

fn segment(op: Vec<f64>, pv: Vec<f64>, sample_time: f64) -> Segment {
    Segment { from: 0.0, sample_time, op, pv: Some(pv), sp: None, vp: None, bridged: 0 }
}

fn judge(detector: &dyn Detector, segment: &Segment, period: f64) -> (Decision, Option<f64>) {
    let finding = detector.judge(&Subject::new(segment, LoopType::Flow, Some(period)));
    (finding.decision, finding.statistic)
}

/// The reference values; `oracles/detect_oracle.py` made them.
fn fixture() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/detect/statistics.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// PV and OP of the oracle, by the same formulas.
fn signals(n: u32) -> (Vec<f64>, Vec<f64>) {
    (0..n)
        .map(|k| {
            let k = f64::from(k);
            let pv =
                (0.31 * k).sin() + 0.4 * (0.62 * k + 0.4).sin() + 0.3 * (0.37 * k * k).sin() + 20.0;
            (pv, 3.0 * (0.31 * k + 0.2).cos() + 0.5 * (0.29 * k * k).sin() + 50.0)
        })
        .unzip()
}

fn close(ours: f64, reference: &Value, tolerance: f64) {
    let reference = reference.as_f64().unwrap();
    assert!(
        (ours - reference).abs() <= tolerance * reference.abs().max(1e-3),
        "{ours} against {reference}"
    );
}

#[test]
fn bicoherence_as_by_numpy() {
    let (pv, op) = signals(2000);
    let s = segment(op, pv, 1.0);
    let reference = &fixture()["bicoherence"];
    let plane = Bicoherence::default().run(&Subject::new(&s, LoopType::Flow, None)).unwrap().plane;
    assert_eq!(plane.segments as u64, reference["segments"].as_u64().unwrap());
    assert_eq!(plane.bins.len() as u64, reference["bins"].as_u64().unwrap());
    close(plane.critical, &reference["critical"], 1e-12);
    close(plane.ngi, &reference["ngi"], 1e-8);
    close(plane.nli, &reference["nli"], 1e-8);
    let peak = plane.peak.unwrap();
    assert_eq!(peak.i as u64, reference["peak"][0].as_u64().unwrap());
    assert_eq!(peak.j as u64, reference["peak"][1].as_u64().unwrap());
    close(peak.value, &reference["peak"][2], 1e-8);
    let cubic = plane.cubic.unwrap();
    assert_eq!(cubic.i as u64, reference["cubic"][0].as_u64().unwrap());
    close(cubic.value, &reference["cubic"][1], 1e-8);
    assert!(plane.nonlinear);
}

#[test]
fn the_ellipse_as_by_the_generalised_eigenvalue_problem() {
    let (pv, op) = signals(2000);
    let reference = &fixture()["ellipse"];
    let ellipse = Ellipse::fit(&op, &pv).unwrap();
    for i in 0..2 {
        close(ellipse.centre[i], &reference["centre"][i], 1e-8);
    }
    for i in 0..3 {
        close(ellipse.form[i], &reference["form"][i], 1e-8);
    }
    close(ellipse.op_width(), &reference["op_width"], 1e-8);
}

#[test]
fn surrogates_as_by_brute_force() {
    let reference = &fixture()["surrogates"];
    let x: Vec<f64> =
        reference["x"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let s = segment(x.clone(), x.iter().map(|v| -v).collect(), 1.0);
    let result = Surrogates::default().run(&Subject::new(&s, LoopType::Flow, Some(24.0))).unwrap();
    close(result.period, &reference["period"], 1e-12);
    close(result.gamma, &reference["gamma"], 1e-8);
    // Other random numbers, other surrogates: the oracle's own seeds differ by 0.06.
    assert!((result.n - reference["n"].as_f64().unwrap()).abs() < 0.25, "{}", result.n);
    assert_eq!(result.decision, Decision::Nonlinear);
}

#[test]
fn tests_of_windows_as_by_scipy() {
    let (pv, op) = signals(2000);
    let s = segment(op, pv, 1.0);
    let reference = fixture();
    let run = |test: DamarlaTest| test.run(&Subject::new(&s, LoopType::Flow, None)).unwrap();
    let hotelling = run(DamarlaTest::new(SteadinessTest::Hotelling));
    for (name, ours) in [("hotelling_pv", &hotelling.pv), ("hotelling_op", &hotelling.op)] {
        for (ours, reference) in ours.iter().zip(reference[name].as_array().unwrap()) {
            close(ours.statistic, &reference[0], 1e-9);
            close(ours.high, &reference[1], 1e-7);
        }
    }
    close(run(DamarlaTest::new(TESTS[0])).pv[0].high, &reference["f_critical"], 1e-8);
    close(run(DamarlaTest::new(TESTS[1])).pv[0].high, &reference["t_critical"], 1e-8);
    let arrangements = run(DamarlaTest { window: 6, ..DamarlaTest::new(TESTS[3]) });
    let expected = reference["arrangements_pv"].as_array().unwrap();
    for (ours, reference) in arrangements.pv.iter().zip(expected) {
        close(ours.statistic, reference, 0.0);
    }
}

/// A real recording, which is not part of the project.
fn recording(name: &str) -> Option<Segment> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/isdb")
        .join(format!("{name}.csv"));
    let Ok(mut reader) = csv::Reader::from_path(path) else {
        println!("skipped: no recording {name}");
        return None;
    };
    let (mut op, mut pv) = (vec![], vec![]);
    for row in reader.records().map(Result::unwrap) {
        pv.push(row[1].parse().unwrap());
        op.push(row[2].parse().unwrap());
    }
    Some(segment(op, pv, 1.0))
}

#[test]
fn counts_of_the_public_implementation() {
    let count = |name: &str, test: &DamarlaRegression| {
        recording(name).map(|s| {
            let result = test.run(&Subject::new(&s, LoopType::Flow, None)).unwrap();
            (result.count, result.sticky.len())
        })
    };
    let published = DamarlaRegression { as_recorded: true, ..Default::default() };
    for (name, expected) in [("CHEM2", (5, 166)), ("CHEM10", (2, 166)), ("CHEM13", (0, 250))] {
        if let Some(count) = count(name, &published) {
            assert_eq!(count, expected, "{name}");
        }
    }
    if let Some(s) = recording("CHEM2") {
        for (test, expected) in TESTS.into_iter().zip([(13, 125), (22, 125), (22, 125), (114, 333)])
        {
            let result =
                DamarlaTest::new(test).run(&Subject::new(&s, LoopType::Flow, None)).unwrap();
            assert_eq!((result.count, result.marked.len()), expected, "{test:?}");
        }
    }
}

#[test]
fn correlations_stored_by_the_public_implementation() {
    // Of a slightly other fit, so only nearly.
    let stored = [
        ("CHEM2", 0.26),
        ("CHEM10", 0.45),
        ("CHEM11", 0.19),
        ("CHEM12", 0.16),
        ("CHEM23", 0.27),
        ("CHEM29", 0.60),
    ];
    for (name, r) in stored {
        if let Some(s) = recording(name) {
            let ours = judge(&DamarlaSigmoid::default(), &s, 100.0).1.unwrap();
            assert!((ours - r).abs() < 0.04, "{name}: {ours}");
        }
    }
}

/// A loop with a valve of `model`, 1,000 s at 1 s after the start.
fn simulated(model: Model, s: f64, j: f64, change: impl Fn(&mut ClosedLoop)) -> (Segment, f64) {
    let valve = Assembly::new(model.build(Bands::from_s_j(s, j).unwrap()).unwrap());
    let mut plant = ClosedLoop::new(
        Controller::pi(1.1, 2.5).unwrap(),
        valve,
        Process::first_order(1.5, 5.93, 1.07).unwrap(),
    );
    plant.set_point = 5.0.into();
    plant.samples = 12_000;
    change(&mut plant);
    let run = plant.run().unwrap();
    let period = run.period_s().unwrap_or(20.0) / plant.sample_time;
    (segment(run.op[2000..].to_vec(), run.pv[2000..].to_vec(), plant.sample_time), period)
}

fn noise(sd: f64, tau_s: f64, seed: u64) -> Signal {
    Signal::Noise { sd, tau_s, seed }
}

/// The paper's loop, sticking.
fn sticky(sd: f64, seed: u64) -> (Segment, f64) {
    simulated(Model::TwoPhase, 5.0, 3.0, |plant| plant.measurement = vec![noise(sd, 0.0, seed)])
}

/// A quick flow loop, sticking, under a load that wanders.
fn quick(model: Model, seed: u64) -> (Segment, f64) {
    let (s, j) = if model == Model::Ideal { (0.0, 0.0) } else { (5.0, 3.0) };
    simulated(model, s, j, |plant| {
        plant.controller = Controller::pi(0.3, 1.5).unwrap();
        plant.process = Process::first_order(1.0, 1.0, 0.3).unwrap();
        plant.set_point = 7.3.into();
        plant.load = vec![noise(0.3, 5.0, seed)];
    })
}

/// The paper's loop without stiction, under Gaussian noise and a sine.
fn linear(seed: u64) -> (Segment, f64) {
    let (segment, _) = simulated(Model::Ideal, 0.0, 0.0, |plant| {
        let wave = Wave::Sine;
        let sine = Signal::Periodic { wave, mean: 0.0, amplitude: 1.0, period_s: 20.3, phase: 0.0 };
        plant.measurement = vec![noise(0.2, 0.0, seed), sine];
    });
    (segment, 203.0)
}

#[test]
fn a_sticky_loop_is_nonlinear_and_a_linear_one_is_not() {
    for seed in 1..=6 {
        let (s, period) = sticky(0.02, seed);
        let (decision, apparent) = judge(&Bicoherence::default(), &s, period);
        assert_eq!(decision, Decision::Sticks);
        // The OP swings by 0.6216 S to either side.
        assert!((3.5..6.3).contains(&apparent.unwrap()), "{apparent:?}");
        assert_eq!(judge(&BicoherenceOp::default(), &s, period).0, Decision::Nonlinear);
        let (s, period) = linear(seed);
        assert_eq!(judge(&Bicoherence::default(), &s, period).0, Decision::DoesNotStick);
        assert_eq!(judge(&BicoherenceOp::default(), &s, period).0, Decision::Linear);
        assert_eq!(judge(&Surrogates::default(), &s, period).0, Decision::Linear);
    }
    // N is small where cycles repeat exactly, so the surrogates are asked about a loop whose do not,
    // on the average over loads.
    let mean_n = |model| {
        let n = (101..=106).map(|seed| {
            let (s, period) = quick(model, seed);
            judge(&Surrogates::default(), &s, period).1.unwrap()
        });
        n.sum::<f64>() / 6.0
    };
    let (sticking, ideal) = (mean_n(Model::TwoPhase), mean_n(Model::Ideal));
    assert!(sticking > 0.7 && ideal < 0.35, "{sticking} {ideal}");
    let (s, period) = quick(Model::TwoPhase, 101);
    assert_eq!(judge(&Surrogates::default(), &s, period).0, Decision::Nonlinear);
}

/// All detectors of this file.
fn detectors() -> Vec<Box<dyn Detector>> {
    let mut all: Vec<Box<dyn Detector>> = vec![
        Box::new(Bicoherence::default()),
        Box::new(BicoherenceOp::default()),
        Box::new(Butterfly::default()),
        Box::new(DamarlaRegression::default()),
        Box::new(DamarlaSigmoid::default()),
        Box::new(SharpCorner::default()),
        Box::new(Surrogates::default()),
    ];
    all.extend(TESTS.map(|test| Box::new(DamarlaTest::new(test)) as Box<dyn Detector>));
    all
}

#[test]
fn units_change_no_decision() {
    let loops = [sticky(0.02, 1), quick(Model::TwoPhase, 2), linear(3)];
    for (s, period) in &loops {
        for detector in detectors() {
            let name = detector.method().name;
            let before = judge(&*detector, s, *period);
            for (op_scale, pv_scale, dt) in [(0.25, 1700.0, 60.0), (3.0, 1e-3, 0.01)] {
                let pv = s.pv.as_ref().unwrap();
                let other = segment(
                    s.op.iter().map(|v| op_scale * v + 11.0).collect(),
                    pv.iter().map(|v| pv_scale * (v + 3.0)).collect(),
                    dt,
                );
                let after = judge(&*detector, &other, *period);
                assert_eq!(before.0, after.0, "{name}");
                // Apparent stiction is in percent of the OP.
                let scale = if name == "bicoherence" { op_scale } else { 1.0 };
                let (a, b) = (scale * before.1.unwrap(), after.1.unwrap());
                assert!((a - b).abs() <= 1e-6 * (1.0 + a.abs()), "{name}: {a} {b}");
            }
            // The other sign of the gain.
            let other = segment(s.op.clone(), s.pv.iter().flatten().map(|v| -v).collect(), 1.0);
            let after = judge(&*detector, &other, *period);
            if name != "butterfly" {
                assert_eq!(before.0, after.0, "{name}");
            }
        }
    }
}

/// OP a triangle, PV what `pv` makes of the phase, in periods; 40 samples a period.
fn shape(pv: impl Fn(f64) -> f64) -> Segment {
    let phase = |k: i32| f64::from(k).mul_add(1.0 / 40.0, 0.003).fract();
    let triangle = |p: f64| 1.0 - 4.0 * (p - 0.5).abs();
    segment(
        (0..2000).map(|k| triangle(phase(k))).collect(),
        (0..2000).map(|k| pv(phase(k))).collect(),
        1.0,
    )
}

#[test]
fn canonical_shapes() {
    use std::f64::consts::TAU;
    // A valve that rests while the OP runs, then slips: the PV is square.
    let square = shape(|p| if p < 0.5 { 1.0 } else { -1.0 });
    let (decision, emptiness) = judge(&Butterfly::default(), &square, 40.0);
    assert_eq!((decision, emptiness), (Decision::Sticks, Some(1.0)));
    assert_eq!(judge(&SharpCorner::default(), &square, 40.0).0, Decision::Sticks);
    assert_eq!(judge(&DamarlaRegression::default(), &square, 40.0).0, Decision::Sticks);
    assert_eq!(judge(&DamarlaTest::new(SteadinessTest::TTest), &square, 40.0).0, Decision::Sticks);
    assert_eq!(judge(&Bicoherence::default(), &square, 40.0).0, Decision::Sticks);

    // A sine against a sine is an ellipse without corners, at any lag.
    for lag in [0.05, 0.125, 0.25, 0.4] {
        let pv = shape(|p| (TAU * (p - lag)).sin());
        let op = shape(|p| (TAU * p).sin()).pv.unwrap();
        let ellipse = Segment { op, ..pv };
        let (decision, share) = judge(&SharpCorner::default(), &ellipse, 40.0);
        assert_eq!((decision, share), (Decision::DoesNotStick, Some(0.0)));
        let (decision, emptiness) = judge(&Butterfly::default(), &ellipse, 40.0);
        assert_eq!(decision, Decision::Undecided);
        assert!(emptiness.unwrap().abs() < 0.1, "{emptiness:?}");
        assert_eq!(judge(&Bicoherence::default(), &ellipse, 40.0).0, Decision::DoesNotStick);
    }
    // A triangle: -0.2548 by closed form.
    let triangle = shape(|p| 1.0 - 4.0 * ((p + 0.25).fract() - 0.5).abs());
    let emptiness = judge(&Butterfly::default(), &triangle, 40.0).1.unwrap();
    assert!((emptiness + 0.2548).abs() < 0.08, "{emptiness}");
    // Sigmoid: a PV whose increments are the sign of the OP's side.
    let sided = segment(square.pv.clone().unwrap(), square.op.clone(), 1.0);
    let (decision, r) = judge(&DamarlaSigmoid::default(), &sided, 40.0);
    assert_eq!(decision, Decision::Sticks);
    assert!(r.unwrap() > 0.9, "{r:?}");
}

#[test]
fn apparent_stiction_is_the_width_of_the_ellipse() {
    // OP and PV a quarter of a period apart: the ellipse is as wide as the OP swings.
    use std::f64::consts::TAU;
    let wave =
        |p: f64, phase: f64| (TAU * (p - phase)).sin() + 0.2 * (2.0 * TAU * (p - phase)).sin();
    let s = Segment { op: shape(|p| 3.0 * wave(p, 0.25)).pv.unwrap(), ..shape(|p| wave(p, 0.0)) };
    let result = Bicoherence::default().run(&Subject::new(&s, LoopType::Flow, Some(40.0))).unwrap();
    assert_eq!(result.decision, Decision::Sticks);
    assert!((result.apparent - 6.0).abs() < 0.4, "{}", result.apparent);
}
