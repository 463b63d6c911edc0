//! States are copied, stored, and restored; instances do not know of each other.

use crate::common;

use common::{Client, Unpacked, wandering};
use stiction_fmu::{Fmi, Fmu, models};

/// All reals after each of some steps.
fn follow(client: &Client, fmu: &Fmu, op: &[f64], from: usize) -> Vec<f64> {
    let mut values = vec![];
    for (k, op) in op.iter().enumerate().skip(from) {
        client.good(client.set(1, *op));
        client.good(client.step(k as f64 * 0.2, 0.2));
        for (r, v) in fmu.variables().iter().enumerate() {
            match v.kind {
                stiction_fmu::VariableKind::Float64 => values.push(client.get(r as u32).unwrap()),
                stiction_fmu::VariableKind::Int32 => {
                    values.push(f64::from(client.integer(r as u32)))
                }
                stiction_fmu::VariableKind::Boolean => {
                    values.push(f64::from(u8::from(client.boolean(r as u32))));
                }
            }
        }
    }
    values
}

#[test]
fn a_restored_state_goes_on_identically() {
    let op = wandering(120, 9);
    for entry in models() {
        for version in [Fmi::V2, Fmi::V3] {
            let mut fmu = Fmu::new(entry.model, entry.law).unwrap();
            if entry.model == "loop" {
                fmu = fmu.with("noise_sd", 0.2).unwrap().with("Td", 0.3).unwrap();
            }
            if entry.model == "valve" {
                fmu = fmu.with("stem_lag", 0.3).unwrap();
            }
            let unpacked = Unpacked::new(&fmu);
            let client = Client::instantiate(version, &unpacked, false);
            client.good(client.set(1, op[0]));
            client.start();
            follow(&client, &fmu, &op[..60], 0);

            let state = client.state();
            let bytes = client.serialise(state);
            let expected = follow(&client, &fmu, &op, 60);
            client.good(client.set_state(state));
            assert_eq!(follow(&client, &fmu, &op, 60), expected, "{entry:?} copied");

            // Another instance, which has only the bytes.
            let other = Client::instantiate(version, &unpacked, false);
            let restored =
                other.deserialise(&bytes).unwrap_or_else(|_| panic!("{:?}", other.logged()));
            other.good(other.set_state(restored));
            assert_eq!(other.serialise(restored), bytes, "{entry:?}");
            assert_eq!(follow(&other, &fmu, &op, 60), expected, "{entry:?} serialised");
            other.free_state(restored);
            client.free_state(state);

            // And from the beginning.
            client.good(client.reset());
            client.good(client.set(1, op[0]));
            client.start();
            assert_eq!(follow(&client, &fmu, &op[..60], 0).len(), 60 * fmu.variables().len());
            assert_eq!(follow(&client, &fmu, &op, 60), expected, "{entry:?} reset");
        }
    }
}

#[test]
fn a_foreign_or_damaged_state_is_refused() {
    let fmus = [("valve", "two-phase"), ("valve", "kano"), ("loop", "two-phase")]
        .map(|(model, law)| Fmu::new(model, law).unwrap());
    let unpacked = fmus.each_ref().map(Unpacked::new);
    let [a, b, c] = unpacked.each_ref().map(|u| Client::instantiate(Fmi::V3, u, false));
    let state = a.state();
    let bytes = a.serialise(state);
    for other in [&b, &c] {
        assert_eq!(other.set_state(state), 3);
        assert!(other.logged()[0].contains("belongs to another model"));
        assert_eq!(other.deserialise(&bytes), Err(3));
    }
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 4;
        assert_eq!(a.deserialise(&damaged), Err(3), "byte {at}");
        assert_eq!(a.deserialise(&bytes[..at]), Err(3), "{at} bytes");
    }
    a.free_state(state);
}

#[test]
fn instances_run_in_parallel() {
    let op = wandering(300, 4);
    let run = |entry: usize| {
        let entry = &models()[entry];
        let fmu = Fmu::new(entry.model, entry.law).unwrap();
        let client = Client::instantiate(Fmi::V2, &Unpacked::new(&fmu), false);
        client.start();
        follow(&client, &fmu, &op, 0)
    };
    let alone: Vec<_> = (0..8).map(run).collect();
    std::thread::scope(|scope| {
        for (entry, expected) in alone.iter().enumerate() {
            scope.spawn(move || assert_eq!(&run(entry), expected));
            scope.spawn(move || assert_eq!(&run(entry), expected));
        }
    });
}
