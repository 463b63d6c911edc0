//! The FMU gives what the library gives, in either version of FMI.

use crate::common;

use common::{Client, Unpacked, reference, wandering};
use stiction_fmu::{Fmi, Fmu};
use stiction_model::Bands;
use stiction_model::closed_loop::{ClosedLoop, Controller, Process, Signal};
use stiction_model::stem::{PressureSignal, SETS, Stem, StemStart};
use stiction_model::valve::{AnyModel, Assembly, HeWang, Model, Start, StemLag, Valve};

const VERSIONS: [Fmi; 2] = [Fmi::V2, Fmi::V3];

/// The values of these outputs after each step, with the OP (value reference 1) held over it.
fn simulated(fmu: &Fmu, version: Fmi, op: &[f64], step: f64, outputs: &[&str]) -> Vec<Vec<f64>> {
    let client = Client::instantiate(version, &Unpacked::new(fmu), false);
    client.good(client.set(1, op[0]));
    client.start();
    let references: Vec<u32> = outputs.iter().map(|name| reference(fmu, name)).collect();
    op.iter()
        .enumerate()
        .map(|(k, op)| {
            client.good(client.set(1, *op));
            client.good(client.step(k as f64 * step, step));
            references.iter().map(|r| client.get(*r).unwrap()).collect()
        })
        .collect()
}

#[test]
fn every_valve_is_the_library_bit_for_bit() {
    for model in Model::ALL {
        let law = model.describe().name;
        for (s, j, limits, lag) in
            [(5.0, 2.0, false, 0.0), (3.0, 3.0, true, 0.4), (1.0, 0.0, false, 0.25)]
        {
            let fmu = Fmu::new("valve", law).unwrap();
            let set = [
                ("S", s),
                ("J", j),
                ("VP_start", 50.0),
                ("limited", f64::from(u8::from(limits))),
                ("low", 45.0),
                ("high", 55.0),
                ("stem_lag", lag),
            ];
            let fmu = set.iter().fold(fmu, |fmu, (name, value)| fmu.with(name, *value).unwrap());

            let mut valve = Assembly::new(model.build(Bands::from_s_j(s, j).unwrap()).unwrap());
            if limits {
                valve = valve.with_limits(45.0, 55.0).unwrap();
            }
            if lag > 0.0 {
                valve = valve.with_lag(StemLag::new(lag, 0.1).unwrap());
            }
            valve.restart(Start::at_rest(50.0));
            let op = wandering(3_000, 7);
            let mut vp = vec![0.0; op.len()];
            valve.run(&op, &mut vp).unwrap();
            for version in VERSIONS {
                let found = simulated(&fmu, version, &op, 0.1, &["VP"]);
                for k in 0..vp.len() {
                    assert_eq!(found[k][0], vp[k], "{law} {version:?} sample {k}");
                }
            }
        }
    }
}

/// Stiction that grows: S and J are set while the simulation runs, and the valve stays where it is.
#[test]
fn stiction_can_grow() {
    let op = wandering(2_000, 3);
    for version in VERSIONS {
        let fmu = Fmu::new("valve", "he-wang").unwrap().with("VP_start", 0.0).unwrap();
        let client = Client::instantiate(version, &Unpacked::new(&fmu), false);
        client.start();
        let mut position = 0.0;
        for (k, op) in op.iter().enumerate() {
            let s = 1.0 + k as f64 / 500.0;
            // J first: for a moment it is above S, which this law does not allow.
            client.good(client.set(reference(&fmu, "J"), 0.9 * s));
            client.good(client.set(reference(&fmu, "S"), s));
            client.good(client.set(1, *op));
            client.good(client.step(k as f64, 1.0));

            let bands = Bands::from_s_j(s, 0.9 * s).unwrap();
            let law = HeWang::new(bands, HeWang::TYPICAL_OVERSHOOT).unwrap();
            let mut valve = AnyModel::HeWang(law);
            valve.restart(Start::at_rest(position));
            position = valve.step(*op);
            assert_eq!(client.get(2), Ok(position), "sample {k}");
        }
    }
}

#[test]
fn slips_are_counted() {
    let fmu = Fmu::new("valve", "two-phase").unwrap().with("VP_start", 0.0).unwrap();
    let client = Client::instantiate(Fmi::V3, &Unpacked::new(&fmu), false);
    client.start();
    // fs = 3.5: it slips at 4, moves with 5, rests, and slips back.
    for (k, (op, stuck, slips)) in
        [(3.0, true, 0), (4.0, false, 1), (5.0, false, 1), (5.0, true, 1), (-1.0, false, 2)]
            .into_iter()
            .enumerate()
    {
        client.good(client.set(1, op));
        client.good(client.step(k as f64, 1.0));
        assert_eq!((client.boolean(3), client.integer(4)), (stuck, slips), "after {op}");
    }
}

#[test]
fn a_loop_is_the_library_bit_for_bit() {
    for (law, sample_time, step, noise) in [
        (Model::TwoPhase, 0.1, 0.1, 0.0),
        (Model::TwoPhase, 0.1, 0.73, 0.3),
        (Model::He, 0.01, 0.25, 0.0),
        (Model::Choudhury, 0.5, 0.1, 0.1),
    ] {
        let fmu = Fmu::new("loop", law.describe().name)
            .and_then(|fmu| fmu.with("sample_time", sample_time))
            .and_then(|fmu| fmu.with("noise_sd", noise))
            .and_then(|fmu| fmu.with("seed", 11.0))
            .unwrap();
        let bands = Bands::from_s_j(5.0, 2.0).unwrap();
        let sticky = ClosedLoop {
            set_point: 5.0.into(),
            sample_time,
            samples: 2_000,
            measurement: vec![Signal::Noise { sd: noise, tau_s: 0.0, seed: 11 }],
            ..ClosedLoop::new(
                Controller::pi(1.1, 2.5).unwrap(),
                Assembly::new(law.build(bands).unwrap()),
                Process::first_order(1.5, 5.93, 1.07).unwrap(),
            )
        };
        let run = sticky.run().unwrap();
        for version in VERSIONS {
            let client = Client::instantiate(version, &Unpacked::new(&fmu), false);
            client.start();
            for n in 0.. {
                let time = n as f64 * step;
                client.good(client.step(time, step));
                // The last sample before the end of the step.
                let k = ((time + step) / sample_time - 1e-6).ceil() as usize - 1;
                if k >= run.pv.len() {
                    break;
                }
                let found = [3, 4, 5].map(|r| client.get(r).unwrap());
                assert_eq!(found, [run.pv[k], run.op[k], run.vp[k]], "{law:?} sample {k}");
            }
        }
    }
}

#[test]
fn a_stem_is_the_library() {
    for set in SETS.into_iter().chain(["dahl", "armstrong"]) {
        let fmu = Fmu::new("stem", set).unwrap().with("supply", 1e6).unwrap();
        let step = 0.5;
        // Wide enough for the 59 % of the set cts.
        let op: Vec<f64> = wandering(200, 5).iter().map(|op| 50.0 + 8.0 * (op - 50.0)).collect();
        let expected = match Stem::named(set) {
            Ok(stem) => {
                let parameters = stem.parameters();
                let pressure = PressureSignal::held_op(&op, step, parameters).unwrap();
                let times: Vec<f64> = (1..=op.len()).map(|k| k as f64 * step).collect();
                let start = StemStart::at_rest(parameters.position_m(50.0));
                let response = stem.simulate(&pressure, start, &times).unwrap();
                Some(response.samples)
            }
            Err(_) => None,
        };
        let outputs = ["position", "velocity", "friction", "pressure", "VP"];
        let v2 = simulated(&fmu, Fmi::V2, &op, step, &outputs);
        assert_eq!(v2, simulated(&fmu, Fmi::V3, &op, step, &outputs), "{set}");
        let mut worst: f64 = 0.0;
        for (found, expected) in v2.iter().zip(expected.unwrap_or_default()) {
            worst = worst.max((found[0] - expected.position_m).abs() / expected.position_m.abs());
        }
        assert!(worst <= 1e-9, "{set}: {worst}");
        assert!(v2.iter().any(|row| row[0] != v2[0][0]), "{set} moves");
    }
}
