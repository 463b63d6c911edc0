//! Stiction measured on simulated valves, whose S and J are known.

use stiction_diagnose::finding::Decision;
use stiction_diagnose::methods::{
    Subject,
    valve_position::{MeasuredValve, ValvePosition},
};
use stiction_diagnose::recording::{LoopType, Segment};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, NormalStream, Process, Signal};
use stiction_model::valve::{Assembly, Model, Valve};

/// What is measured on this OP and valve position.
fn measure(sample_time: f64, op: &[f64], vp: &[f64]) -> MeasuredValve {
    let segment = Segment {
        from: 0.0,
        sample_time,
        op: op.to_vec(),
        pv: None,
        sp: None,
        vp: Some(vp.to_vec()),
        bridged: 0,
    };
    ValvePosition::default().run(&Subject::new(&segment, LoopType::Flow, None)).unwrap()
}

/// OP and position of a valve on a slow sine of half peak-to-peak value 10 about 50, with a smaller one.
fn driven(model: Model, s: f64, j: f64) -> (Vec<f64>, Vec<f64>) {
    let op: Vec<f64> = (0..20_000)
        .map(|k| {
            let t = f64::from(k) * 0.1;
            50.0 + 10.0 * (t * 0.063).sin() + 2.0 * (t * 0.0117).sin()
        })
        .collect();
    let mut valve: Assembly = model.build(Bands::from_s_j(s, j).unwrap()).unwrap().into();
    let mut vp = vec![0.0; op.len()];
    valve.run(&op, &mut vp).unwrap();
    (op, vp)
}

fn noisy(vp: &[f64], sd: f64, quantum: f64) -> Vec<f64> {
    let mut stream = NormalStream::new(7);
    let measured = vp.iter().map(|v| v + sd * stream.draw());
    measured.map(|v| if quantum > 0.0 { (v / quantum).round() * quantum } else { v }).collect()
}

fn show(what: &str, m: &MeasuredValve) {
    let number = |q: &stiction_diagnose::methods::valve_position::Measured| match q {
        Ok(q) => format!(
            "{:.3} ({:.3}..{:.3}, {})",
            q.median, q.lower_quartile, q.upper_quartile, q.count
        ),
        Err(why) => why.0.clone(),
    };
    println!(
        "{what}: S {} J {} band {} offset {} resolution {:.4} noise {:.4} travel {:.0}/h {:.1} turns/h",
        number(&m.s),
        number(&m.j),
        number(&m.dead_band),
        number(&m.offset),
        m.resolution,
        m.noise,
        m.travel_per_hour,
        m.reversals_per_hour
    );
}

const CASES: [(Model, f64, f64); 9] = [
    (Model::TwoPhase, 5.0, 3.0),
    (Model::TwoPhase, 2.0, 0.5),
    (Model::TwoPhase, 8.0, 8.0),
    (Model::TwoPhase, 3.0, 1.0),
    (Model::He, 5.0, 3.0),
    (Model::He, 2.0, 0.5),
    (Model::He, 6.0, 1.0),
    (Model::Play, 3.0, 0.0),
    (Model::Play, 1.0, 0.0),
];

#[test]
fn clean_positions_give_s_and_j() {
    for (model, s, j) in CASES {
        let (op, vp) = driven(model, s, j);
        let m = measure(0.1, &op, &vp);
        show(&format!("{model:?} {s} {j}"), &m);
        let (found_s, found_j) = (m.s.unwrap().median, m.j.unwrap().median);
        assert!((found_s - s).abs() < 0.02 * s, "{model:?} {s} {j}: S {found_s}");
        assert!((found_j - j).abs() < 0.02 * s, "{model:?} {s} {j}: J {found_j}");
        assert_eq!(m.decision, Decision::Sticks);
        assert!(m.offset.unwrap().median.abs() < 0.02 * s);
    }
}

#[test]
fn noise_and_quantum_blur_little() {
    for (sd, quantum) in [(0.02, 0.0), (0.05, 0.0), (0.0, 0.1), (0.02, 0.1)] {
        for (model, s, j) in CASES {
            let (op, vp) = driven(model, s, j);
            let m = measure(0.1, &op, &noisy(&vp, sd, quantum));
            show(&format!("{model:?} {s} {j} noise {sd} quantum {quantum}"), &m);
            let bound = 0.03 * s + 2.0 * sd + quantum;
            let (found_s, found_j) = (m.s.unwrap().median, m.j.unwrap().median);
            assert!((found_s - s).abs() < bound, "{model:?} {s} {j} {sd} {quantum}: S {found_s}");
            assert!(
                (found_j - j).abs() < bound + 0.1,
                "{model:?} {s} {j} {sd} {quantum}: J {found_j}"
            );
        }
    }
}

#[test]
fn a_healthy_valve_has_none() {
    // Without noise and steps the position would be a copy of the OP, which is no measurement.
    for (sd, quantum) in [(0.05, 0.0), (0.0, 0.1), (0.05, 0.1)] {
        let (op, vp) = driven(Model::Ideal, 0.0, 0.0);
        let m = measure(0.1, &op, &noisy(&vp, sd, quantum));
        show(&format!("healthy {sd} {quantum}"), &m);
        assert!(m.s.as_ref().unwrap().median < 0.1, "{sd} {quantum}");
        assert_eq!(m.decision, Decision::DoesNotStick);
        assert!(m.stuck_share < 0.05);
    }
}

/// A valve without friction that lags by seconds has no dead band.
#[test]
fn a_lag_is_no_stiction() {
    let (op, _) = driven(Model::Ideal, 0.0, 0.0);
    for (lag, sd) in [(0.3, 0.0), (3.0, 0.0), (3.0, 0.05)] {
        let (mut vp, mut x) = (vec![], op[0]);
        for u in &op {
            x += (u - x) * (1.0 - f64::exp(-0.1 / lag));
            vp.push(x);
        }
        let m = measure(0.1, &op, &noisy(&vp, sd, 0.0));
        show(&format!("lag of {lag} s, noise {sd}"), &m);
        assert_eq!(m.decision, Decision::DoesNotStick);
        assert!(m.s.unwrap().median < m.resolution.max(0.1));
    }
}

/// Travel and reversals: four turns of a sine of 20 % peak to peak in an hour.
#[test]
fn travel_and_offset() {
    let op: Vec<f64> = (0..3600)
        .map(|k| 50.0 + 10.0 * (f64::from(k) * std::f64::consts::TAU / 1800.0).sin())
        .collect();
    let vp: Vec<f64> = op.iter().map(|u| u - 1.5).collect();
    for vp in [noisy(&vp, 0.0, 0.0), noisy(&vp, 0.05, 0.0)] {
        let m = measure(1.0, &op, &vp);
        show("travel", &m);
        assert!((m.travel_per_hour - 80.0).abs() < 1.5);
        assert_eq!(m.reversals_per_hour, 4.0);
        assert!((m.offset.unwrap().median - 1.5).abs() < 0.02);
    }
}

#[test]
fn in_a_loop_with_noise() {
    for (s, j) in [(5.0, 3.0), (3.0, 1.0), (2.0, 2.0), (4.0, 0.0)] {
        for noise in [0.0, 0.02, 0.1] {
            let model = Model::TwoPhase.build(Bands::from_s_j(s, j).unwrap()).unwrap();
            let mut flow = ClosedLoop::new(
                Controller::pi(1.1, 2.5).unwrap(),
                Assembly::new(model),
                Process::first_order(1.5, 5.93, 1.07).unwrap(),
            );
            // Where a dead band alone does not cycle, the load does.
            flow.load = vec![Signal::Periodic {
                wave: stiction_model::closed_loop::Wave::Sine,
                mean: 0.0,
                amplitude: if j == 0.0 { 6.0 } else { 0.0 },
                period_s: 60.0,
                phase: 0.0,
            }];
            flow.set_point = 5.0.into();
            flow.measurement = vec![Signal::Noise { sd: noise, tau_s: 0.0, seed: 3 }];
            let run = flow.run().unwrap();
            let m = measure(0.1, &run.op, &noisy(&run.vp, 0.01, 0.0));
            show(&format!("loop {s} {j} noise {noise}"), &m);
            let (found_s, found_j) = (m.s.unwrap().median, m.j.unwrap().median);
            assert!((found_s - s).abs() < 0.1 * s, "{s} {j} {noise}: S {found_s}");
            assert!((found_j - j).abs() < 0.1 * s, "{s} {j} {noise}: J {found_j}");
        }
    }
}

#[test]
fn what_cannot_be_seen_is_not_reported() {
    let op: Vec<f64> = (0..1000).map(|k| 50.0 + (f64::from(k) * 0.05).sin()).collect();
    let stuck = measure(1.0, &op, &[40.0; 1000]);
    assert!(stuck.s.is_err() && stuck.j.is_err() && stuck.dead_band.is_err());
    assert_eq!((stuck.decision, stuck.stuck_share), (Decision::Undecided, 1.0));
    assert_eq!((stuck.travel_per_hour, stuck.reversals_per_hour), (0.0, 0.0));
    let ramp: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.05).collect();
    let mut valve: Assembly = Model::He.build(Bands::from_s_j(4.0, 1.5).unwrap()).unwrap().into();
    let mut vp = vec![0.0; 1000];
    valve.run(&ramp, &mut vp).unwrap();
    let upwards = measure(1.0, &ramp, &vp);
    show("staircase", &upwards);
    assert!(upwards.s.is_err());
    assert!((upwards.j.unwrap().median - 1.5).abs() < 0.06);
}

/// A recording that is not part of the project; without it there is nothing to measure.
#[test]
fn a_recorded_healthy_valve() {
    let folder: std::path::PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "../../../shared/data/damadics"].iter().collect();
    let Ok(entries) = std::fs::read_dir(folder) else {
        println!("skipped: there is no recording");
        return;
    };
    let files = entries.map(|entry| entry.unwrap().path());
    for path in files.filter(|path| path.extension().is_some_and(|e| e == "csv")) {
        let mut reader = csv::Reader::from_path(&path).unwrap();
        let headers = reader.headers().unwrap().clone();
        let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let column = |name: &str| -> Option<Vec<f64>> {
            let at = headers.iter().position(|h| h == name)?;
            records.iter().map(|r| r[at].parse().ok()).collect()
        };
        let Some((op, vp)) = column("op").zip(column("mv")) else { continue };
        let m = measure(1.0, &op, &vp);
        show(&format!("{:?}", path.file_name().unwrap()), &m);
        assert!(m.decision != Decision::Sticks);
    }
}
