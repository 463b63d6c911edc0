//! Wrong use: each is refused with a status and a sentence, and the instance goes on.
#![allow(unsafe_code)]

use crate::common;

use common::{Client, Unpacked, reference};
use stiction_fmu::{Fmi, Fmu, fmi2, fmi3};

const VERSIONS: [Fmi; 2] = [Fmi::V2, Fmi::V3];

fn valve() -> Fmu {
    Fmu::new("valve", "two-phase").unwrap()
}

/// A client in the mode of this name.
fn in_mode(version: Fmi, fmu: &Fmu, mode: &str) -> Client {
    let client = Client::instantiate(version, &Unpacked::new(fmu), false);
    if mode != "instantiated" {
        client.good(client.enter());
        if mode != "initialization" {
            client.good(client.exit());
            if mode == "terminated" {
                client.good(client.terminate());
            }
        }
    }
    client
}

#[track_caller]
fn refused(client: &Client, status: i32, says: &[&str]) {
    let logged = client.logged();
    assert_eq!((status, logged.len()), (3, 1), "{logged:?}");
    for part in says {
        assert!(logged[0].contains(part), "{part:?} is not in: {}", logged[0]);
    }
}

#[test]
fn calls_out_of_order_name_the_permitted_modes() {
    type Call = fn(&Client) -> i32;
    let step: Call = |c| c.step(0.0, 0.1);
    let get: Call = |c| c.get(2).err().unwrap_or(0);
    let set_s: Call = |c| c.set(5, 1.0);
    let set_fixed: Call = |c| c.set(9, 1.0);
    let set_op: Call = |c| c.set(1, 1.0);
    let enter: Call = Client::enter;
    let exit: Call = Client::exit;
    let terminate: Call = Client::terminate;
    for (mode, call, says) in [
        ("instantiated", step, ["DoStep", "modes: step mode", "the instance is instantiated"]),
        (
            "initialization",
            step,
            ["DoStep", "modes: step mode", "the instance is initialization mode"],
        ),
        ("terminated", step, ["DoStep", "modes: step mode", "the instance is terminated"]),
        ("instantiated", get, ["Get", "modes: initialization mode, step mode", "instantiated"]),
        ("instantiated", exit, ["ExitInitializationMode", "modes: initialization mode", "instant"]),
        ("step", exit, ["ExitInitializationMode", "modes: initialization mode", "step mode"]),
        ("step", enter, ["", "modes: instantiated", "step mode"]),
        ("step", set_fixed, ["setting stem_lag", "instantiated, initialization mode", "step mode"]),
        ("terminated", set_s, ["Set", "modes: instantiated, initialization mode", "terminated"]),
        ("terminated", set_op, ["Set", "modes: instantiated, initialization mode", "terminated"]),
        ("initialization", terminate, ["Terminate", "modes: step mode", "initialization mode"]),
    ] {
        for version in VERSIONS {
            let client = in_mode(version, &valve(), mode);
            refused(&client, call(&client), &says);
            client.good(client.reset());
            client.start();
            client.good(client.step(0.0, 0.1));
        }
    }
}

#[test]
fn unknown_and_unfit_variables_are_named() {
    for version in VERSIONS {
        let client = in_mode(version, &valve(), "step");
        let says = ["no variable with the value reference 99", "the range is 0 to 13"];
        refused(&client, client.get(99).unwrap_err(), &says);
        refused(&client, client.set(u32::MAX, 0.0), &["value reference 4294967295"]);
        refused(&client, client.get(3).unwrap_err(), &["variable stuck", "type Boolean"]);
        refused(&client, client.set(4, 1.0), &["variable slips", "type Int32"]);
        refused(&client, client.set(2, 1.0), &["VP is computed and cannot be set"]);
        refused(&client, client.set(0, 1.0), &["time is computed and cannot be set"]);
        client.good(client.step(0.0, 0.1));
    }
}

#[test]
fn numbers_that_are_none_are_refused_and_change_nothing() {
    for version in VERSIONS {
        let client = in_mode(version, &valve(), "step");
        client.good(client.set(1, 10.0));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            refused(&client, client.set(1, bad), &["OP is", "must be a finite number"]);
            refused(&client, client.set(5, bad), &["S is", "must be a finite number"]);
            refused(&client, client.step(bad, 0.1), &["the step of 0.1 s from"]);
            refused(&client, client.step(0.0, bad), &["finite and above 0"]);
        }
        for bad in [0.0, -0.1] {
            refused(&client, client.step(0.0, bad), &["finite and above 0"]);
        }
        refused(&client, client.step(5.0, 0.1), &["at the end of the last step, at 0 s"]);
        client.good(client.step(0.0, 0.1));
        // From 50 % down to fd above the OP.
        assert_eq!(client.get(2), Ok(11.5));
    }
}

#[test]
fn parameters_that_do_not_fit_are_named_and_can_be_mended() {
    let cases = [
        ("valve", "two-phase", "S", -1.0, "S is -1, but must be a finite number of at least 0"),
        ("valve", "he-wang", "J", 9.0, "J is 9, but must be at most S = 5"),
        ("valve", "he-wang", "K", 3.0, "K is 3, but must be between 1"),
        ("valve", "kano", "stem_lag", -1.0, "stem lag is -1"),
        ("stem", "cts", "mass_kg", 0.0, "mass is 0"),
        ("stem", "cts", "coulomb_n", 1e9, "Coulomb friction is 1000000000"),
        ("stem", "cts", "VP_start", -5.0, "start position is"),
        ("stem", "usp-gms", "share_1", 0.1, "share"),
        ("stem", "armstrong", "memory_s", -1.0, "frictional memory is -1"),
        ("loop", "two-phase", "Ti", 0.0, "Ti is 0"),
        ("loop", "two-phase", "sample_time", 0.0, "sample time is 0"),
        ("loop", "two-phase", "dead_time", -1.0, "dead time is -1"),
        ("loop", "two-phase", "noise_sd", -1.0, "noise standard deviation is -1"),
    ];
    for (model, law, name, value, says) in cases {
        let fmu = Fmu::new(model, law).unwrap();
        let at = reference(&fmu, name);
        let usual = fmu.variables()[at as usize].start.unwrap();
        let bad = fmu.clone().with(name, value).unwrap();
        assert!(bad.check().unwrap_err().contains(says), "{:?}", bad.check());
        for version in VERSIONS {
            // Set, or written in the resources.
            let client = in_mode(version, &fmu, "initialization");
            client.good(client.set(at, value));
            refused(&client, client.exit(), &["ExitInitializationMode", says]);
            refused(&client, client.get(2).unwrap_err(), &[says]);
            client.good(client.set(at, usual));
            client.good(client.exit());
            client.good(client.step(0.0, 0.1));
            let client = in_mode(version, &bad, "initialization");
            refused(&client, client.exit(), &[says]);
        }
    }
    // Tuned while running.
    for version in VERSIONS {
        let client = in_mode(version, &valve(), "step");
        client.good(client.set(5, -1.0));
        refused(&client, client.step(0.0, 0.1), &["DoStep", "S is -1"]);
        client.good(client.set(5, 1.0));
        client.good(client.step(0.0, 0.1));
    }
}

#[test]
fn resources_that_are_missing_or_damaged_are_refused() {
    let token = valve().token();
    let json = valve().json();
    for version in VERSIONS {
        let missing = Unpacked::empty(token.clone());
        let client = Client::instantiate(version, &missing, false);
        assert!(client.instance.is_null());
        assert!(client.logged()[0].contains("stiction.json cannot be used"));
        for (text, says) in [
            ("", "expected '{'"),
            ("{}", "\"model\" is missing; it must be one of valve, stem, loop"),
            ("{\"model\": 1}", "\"model\" must be a text"),
            (
                "{\"model\": \"pump\", \"law\": \"x\"}",
                "no model named \"pump\"; known are valve, stem",
            ),
            (
                "{\"model\": \"valve\", \"law\": \"x\"}",
                "no valve model named \"x\"; known are two-phase",
            ),
            ("{\"model\": \"stem\", \"law\": \"x\"}", "named \"x\"; known are classical, karnopp"),
            (
                "{\"model\": \"valve\", \"law\": \"he\", \"Q\": 1}",
                "Q is not a parameter of the model",
            ),
            ("{\"model\": \"valve\", \"law\": \"he\", \"VP\": 1}", "VP is computed"),
            ("{\"model\": \"valve\", \"law\": \"he\", \"S\": \"5\"}", "\"S\" must be a number"),
            ("{\"model\": \"valve\", \"law\": \"he\", \"S\": true}", "\"S\" must be a number"),
            ("{\"model\": \"valve\", \"law\": \"he\", \"limited\": 1}", "must be true or false"),
            ("{\"model\": \"loop\", \"law\": \"he\", \"seed\": 1.5}", "a whole number"),
            (&json[..json.len() / 2], "cannot be used"),
            (&json.replace("two-phase", "kano"), "belongs to another model"),
        ] {
            let client =
                Client::instantiate(version, &Unpacked::with_text(text, token.clone()), false);
            assert!(client.instance.is_null(), "{text}");
            let logged = client.logged();
            assert!(logged.len() == 1 && logged[0].contains(says), "{text}: {logged:?}");
        }
        let unpacked = Unpacked::new(&valve());
        std::fs::write(unpacked.directory.join("stiction.json"), [0xff, 0xfe, 0]).unwrap();
        let client = Client::instantiate(version, &unpacked, false);
        assert!(client.instance.is_null() && client.logged()[0].contains("cannot be used"));
        std::fs::write(unpacked.directory.join("stiction.json"), vec![b' '; 2 << 20]).unwrap();
        let client = Client::instantiate(version, &unpacked, false);
        assert!(client.instance.is_null() && client.logged()[0].contains("more than"));
        let client = Client::at(version, "http://example.org/", &token, false);
        assert!(client.instance.is_null() && client.logged().len() == 1);
        let unpacked = Unpacked::with_text(&json, "{0}".to_owned());
        let client = Client::instantiate(version, &unpacked, false);
        assert!(client.instance.is_null() && client.logged()[0].contains("its token is {0}"));
    }
}

#[test]
fn model_exchange_is_for_stems() {
    for version in VERSIONS {
        for (model, law) in [("valve", "two-phase"), ("loop", "he"), ("stem", "armstrong")] {
            let fmu = Fmu::new(model, law).unwrap();
            let client = Client::instantiate(version, &Unpacked::new(&fmu), true);
            assert!(client.instance.is_null());
            assert!(client.logged()[0].contains("for co-simulation only"));
            assert!(!fmu.xml(version, None).contains("<ModelExchange"));
        }
        let fmu = Fmu::new("stem", "cts").unwrap();
        assert!(fmu.xml(version, None).contains("<ModelExchange"));
        let client = Client::instantiate(version, &Unpacked::new(&fmu), true);
        client.good(client.enter());
        client.good(client.set(reference(&fmu, "air_lag_s"), 1.0));
        refused(&client, client.exit(), &["air_lag_s cannot change between 0 and other values"]);
        client.good(client.set(reference(&fmu, "air_lag_s"), 0.0));
        client.good(client.exit());
        refused(&client, client.step(0.0, 0.1), &["DoStep is for co-simulation"]);
        let mut numbers = [f64::NAN; 6];
        let status = client.set_states(&numbers[..2]);
        refused(&client, status, &["modes: continuous-time mode", "event mode"]);
        client.good(client.enter_continuous_time_mode());
        refused(&client, client.set_states(&numbers[..2]), &["continuous state 0 is NaN"]);
        let status = client.rates(&mut numbers[..3]);
        refused(&client, status, &["3 continuous states were requested, but there are 2"]);
        refused(&client, client.set_time(f64::NAN), &["the time is NaN"]);
        client.good(client.indicators(&mut numbers));
    }
}

/// FMI 3.0 asks how many numbers there are.
#[test]
fn states_and_indicators_are_counted() {
    let client = |exchange| {
        let unpacked = Unpacked::new(&Fmu::new("stem", "usp-gms").unwrap());
        Client::instantiate(Fmi::V3, &unpacked, exchange)
    };
    let (three, other) = (client(true), client(false));
    let (mut states, mut indicators) = (0, 0);
    // SAFETY: the instances are alive.
    unsafe {
        three.good(fmi3::fmi3GetNumberOfContinuousStates(three.instance, &mut states));
        three.good(fmi3::fmi3GetNumberOfEventIndicators(three.instance, &mut indicators));
        let status = fmi3::fmi3GetNumberOfContinuousStates(other.instance, &mut states);
        refused(&other, status, &["is for model exchange"]);
    }
    assert_eq!((states, indicators), (5, 6));
}

#[test]
fn null_pointers_and_wrong_lengths_are_refused() {
    use std::ptr::{null, null_mut};
    let two = in_mode(Fmi::V2, &valve(), "step");
    let three = in_mode(Fmi::V3, &valve(), "step");
    let mut value = 0.0;
    // SAFETY: the instances are alive; what else is wrong must be refused.
    unsafe {
        assert_eq!(fmi2::fmi2DoStep(null_mut(), 0.0, 1.0, 0), 3);
        assert_eq!(fmi3::fmi3Reset(null_mut()), 3);
        fmi2::fmi2FreeInstance(null_mut());
        fmi3::fmi3FreeInstance(null_mut());
        two.good(fmi2::fmi2GetReal(two.instance, null(), 0, null_mut()));
        two.good(fmi2::fmi2GetString(two.instance, null(), 0, null_mut()));
        let none = ["an array of 1 values was announced, but is null, misaligned or too long"];
        refused(&two, fmi2::fmi2GetReal(two.instance, null(), 1, &mut value), &none);
        let none = ["room for 1 values was announced, but is null, misaligned or too long"];
        refused(&two, fmi2::fmi2GetReal(two.instance, &1, 1, null_mut()), &none);
        refused(&two, fmi2::fmi2GetString(two.instance, &1, 1, null_mut()), &["variable OP"]);
        refused(&two, fmi2::fmi2SetFMUstate(two.instance, null_mut()), &["the state is missing"]);
        refused(&two, fmi2::fmi2GetFMUstate(two.instance, null_mut()), &["no room"]);
        let status = fmi3::fmi3GetFloat64(three.instance, &1, 1, &mut value, 2);
        refused(&three, status, &["2 values for 1 variables"]);
        refused(&three, fmi3::fmi3GetInt8(three.instance, &1, 1, null_mut(), 1), &["variable OP"]);
        refused(&three, fmi3::fmi3EnterEventMode(three.instance), &["for model exchange"]);
        refused(&three, fmi3::fmi3SetTime(three.instance, 1.0), &["for model exchange"]);
        let made = fmi2::fmi2Instantiate(null(), 1, null(), null(), null(), 0, 0);
        assert!(made.is_null());
        assert_eq!(fmi2::fmi2GetStatus(two.instance, 0, null_mut()), 2);
        two.logged();
        two.good(fmi2::fmi2GetRealStatus(two.instance, 2, &mut value));
    }
}

/// What cannot go on, does not: the instance can be read, reset and freed.
#[test]
fn a_failed_step_ends_in_error() {
    for version in VERSIONS {
        let fmu = Fmu::new("loop", "ideal").unwrap().with("Kc", 1e30).unwrap();
        let client = in_mode(version, &fmu, "step");
        refused(&client, client.step(0.0, 1000.0), &["DoStep at 0 s: the loop is unstable"]);
        refused(&client, client.step(0.0, 1.0), &["the instance is in error"]);
        assert!(client.get(3).is_ok());
        client.good(client.reset());
        let client = in_mode(version, &Fmu::new("loop", "ideal").unwrap(), "step");
        refused(&client, client.step(0.0, 1e9), &["has more than 10000000 samples of 0.1 s"]);
    }
}
