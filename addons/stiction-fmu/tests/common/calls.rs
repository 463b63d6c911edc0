//! Any sequence of calls, drawn from bytes: none may crash, and each returns a status of the standard.

use std::ffi::{c_int, c_void};
use std::ptr::null_mut;

use super::{Client, Unpacked};
use stiction_fmu::{Fmi, Fmu, fmi2, fmi3};

/// The models that are called.
pub const MODELS: [(&str, &str); 6] = [
    ("valve", "two-phase"),
    ("valve", "he-wang"),
    ("loop", "choudhury"),
    ("stem", "cts-stribeck"),
    ("stem", "usp-lugre"),
    ("stem", "armstrong"),
];

/// Numbers that importers should not send, and some that they may.
const NUMBERS: [f64; 16] = [
    0.0,
    1.0,
    -1.0,
    0.1,
    5.0,
    50.0,
    100.0,
    1e3,
    1e-9,
    1e9,
    1e300,
    -1e300,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MIN_POSITIVE,
];

struct Bytes<'a>(std::slice::Iter<'a, u8>);

impl Bytes<'_> {
    fn next(&mut self) -> Option<usize> {
        self.0.next().map(|byte| usize::from(*byte))
    }

    fn number(&mut self) -> f64 {
        NUMBERS[self.next().unwrap_or(0) % NUMBERS.len()]
    }

    fn reference(&mut self) -> u32 {
        self.next().unwrap_or(0) as u32 % 50
    }
}

/// Makes the calls that the bytes spell, with the models unpacked in the order of [`MODELS`].
pub fn play(bytes: &[u8], unpacked: &[Unpacked]) {
    let mut bytes = Bytes(bytes.iter());
    let Some(first) = bytes.next() else { return };
    let version = if first & 1 == 0 { Fmi::V2 } else { Fmi::V3 };
    let exchange = first & 2 != 0;
    let model = (first >> 2) % MODELS.len();
    let client = Client::instantiate(version, &unpacked[model], exchange);
    if first & 128 != 0 {
        let _ = client.enter();
        let _ = client.exit();
    }
    let mut states: Vec<*mut c_void> = vec![];
    let mut time = 0.0;
    while let Some(call) = bytes.next() {
        let status = one(&client, call, &mut bytes, &mut states, &mut time);
        assert!((0..=3).contains(&status), "{status} after call {call}");
        let logged = client.logged();
        assert!(!logged.iter().any(|entry| entry.contains("defect")), "{logged:?}");
        assert!(
            client.instance.is_null() || (status == 0) == logged.is_empty(),
            "{status} with {logged:?}"
        );
    }
    if !client.instance.is_null() {
        states.into_iter().for_each(|state| client.free_state(state));
    }
}

fn one(
    client: &Client,
    call: usize,
    bytes: &mut Bytes<'_>,
    states: &mut Vec<*mut c_void>,
    time: &mut f64,
) -> c_int {
    let c = client.instance;
    let kept = states.get(call / 32 % states.len().max(1)).copied().unwrap_or(null_mut());
    let mut numbers = [0.5; 8];
    // SAFETY: instance and states are alive or null, arrays as long as announced.
    unsafe {
        match (call % 24, client.version) {
            (0, _) => client.enter(),
            (1, _) => client.exit(),
            (2 | 3, _) => client.set(bytes.reference(), bytes.number()),
            (4, _) => client.get(bytes.reference()).err().unwrap_or(0),
            (5..=8, _) => {
                // Mostly steps that fit.
                let step = if call & 64 == 0 { 0.1 } else { bytes.number().min(1e3) };
                let at = if call & 128 == 0 { *time } else { bytes.number() };
                let status = client.step(at, step);
                if status == 0 {
                    *time = at + step;
                }
                status
            }
            (9, _) => {
                *time = 0.0;
                if call & 64 == 0 { client.reset() } else { client.terminate() }
            }
            (10, _) if !c.is_null() && states.len() < 8 => {
                states.push(client.state());
                0
            }
            (11, _) => client.set_state(kept),
            (12, _) if !c.is_null() && !kept.is_null() => {
                let mut serialised = client.serialise(kept);
                let damage = bytes.next().unwrap_or(0);
                if damage > 128 {
                    let at = damage * 7 % serialised.len();
                    serialised[at] ^= 1 << (damage % 8);
                }
                match client.deserialise(&serialised) {
                    Ok(state) => {
                        states.push(state);
                        0
                    }
                    Err(status) => status,
                }
            }
            (13, _) => client.enter_event_mode(),
            (14, _) => client.update(),
            (15, _) => client.enter_continuous_time_mode(),
            (16, _) => client.set_time(bytes.number()),
            (17, _) => {
                numbers.fill_with(|| bytes.number());
                client.set_states(&numbers[..(2 + call / 32).min(8)])
            }
            (18, _) => client.rates(&mut numbers[..2 + call / 64]),
            (19, _) => client.indicators(&mut numbers[..6]),
            (20, _) => client.nominals(&mut numbers[..2 + call / 64]),
            (21, Fmi::V2) => {
                let value = c_int::from(call & 32 != 0);
                fmi2::fmi2SetBoolean(c, &bytes.reference(), 1, &value)
            }
            (21, Fmi::V3) => {
                let value = (call / 32) as u8;
                fmi3::fmi3SetBoolean(c, &bytes.reference(), 1, &value, 1)
            }
            (22, Fmi::V2) => fmi2::fmi2SetInteger(c, &bytes.reference(), 1, &(call as c_int - 99)),
            (22, Fmi::V3) => fmi3::fmi3SetInt32(c, &bytes.reference(), 1, &(call as i32 - 99), 1),
            (23, Fmi::V2) => fmi2::fmi2GetReal(c, std::ptr::null(), call / 24, null_mut()),
            (23, Fmi::V3) => fmi3::fmi3GetFloat64(c, std::ptr::null(), call / 24, null_mut(), 1),
            _ => client.set(1, bytes.number()),
        }
    }
}

/// The models of [`MODELS`], unpacked.
pub fn unpacked() -> Vec<Unpacked> {
    MODELS.iter().map(|(model, law)| Unpacked::new(&Fmu::new(model, law).unwrap())).collect()
}
