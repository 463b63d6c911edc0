//! What a call costs beside the library itself; with `--release -- --ignored --nocapture`.

mod common;

use std::hint::black_box;
use std::time::Instant;

use common::{Client, Unpacked, wandering};
use stiction::Bands;
use stiction::valve::{Model, Start, Valve};
use stiction_fmu::{Fmi, Fmu};

/// 1,000 valves, 10,000 steps each: set OP, step, get VP.
#[test]
#[ignore = "measures time"]
fn a_thousand_instances() {
    let (instances, steps) = (1_000, 10_000);
    let op = wandering(steps, 1);
    let bands = Bands::from_s_j(5.0, 2.0).unwrap();
    let mut valves = vec![Model::TwoPhase.build(bands).unwrap(); instances];
    valves.iter_mut().for_each(|valve| valve.restart(Start::at_rest(0.0)));
    let began = Instant::now();
    let mut library = 0.0;
    for op in &op {
        for valve in &mut valves {
            library += black_box(valve.step(black_box(*op)));
        }
    }
    let direct = began.elapsed().as_secs_f64();

    let unpacked = Unpacked::new(&Fmu::new("valve", "two-phase").unwrap());
    for version in [Fmi::V2, Fmi::V3] {
        let clients: Vec<Client> =
            (0..instances).map(|_| Client::instantiate(version, &unpacked, false)).collect();
        clients.iter().for_each(Client::start);
        let began = Instant::now();
        let mut sum = 0.0;
        for (k, op) in op.iter().enumerate() {
            for client in &clients {
                client.set(1, black_box(*op));
                client.step(k as f64, 1.0);
                sum += client.get(2).unwrap();
            }
        }
        let seconds = began.elapsed().as_secs_f64();
        assert_eq!(sum, library);
        let each = 1e9 / (instances * steps) as f64;
        println!(
            "{version:?}: {:.1} ns a step, the library {:.1} ns: {:.2} times",
            seconds * each,
            direct * each,
            seconds / direct
        );
    }
}
