//! Learn the test: a valve with hidden S and J, turned by hand.

use super::{Open, open};
use serde_json::{Value, json};
use stiction_lab::Options;

/// The first seed whose valve sticks, or does not, with its truth.
fn valve(lab: &Open, sticks: bool) -> (u32, Value) {
    (1..)
        .map(|seed| (seed, lab.good("exercise/reveal", &exercise(seed, vec![], 0.0))))
        .find(|(_, truth)| truth["sticks"] == sticks)
        .unwrap()
}

fn exercise(seed: u32, sets: Vec<Value>, until_s: f64) -> Value {
    json!({ "seed": seed, "sets": sets, "until_s": until_s })
}

/// Turns about the last OP in operation that grow from 0.4 % to 9 % and shrink again, each held for 12 s; with the time
/// after the last.
fn turns(lab: &Open, seed: u32) -> (Vec<Value>, f64) {
    let look = json!({ "exercise": exercise(seed, vec![], 300.0), "from": 1499 });
    let rest = lab.good("exercise/trend", &look)["op"][0].as_f64().unwrap();
    let growing = (0..16).map(|k| 0.2 * 1.23f64.powi(k));
    let shrinking = (0..16).rev().map(|k| 0.21 * 1.23f64.powi(k));
    let mut sets = vec![];
    for (k, half) in growing.chain(shrinking).enumerate() {
        let op = rest + if k % 2 == 0 { half } else { -half };
        sets.push(json!({ "at_s": 300.0 + 12.0 * k as f64, "op": op }));
    }
    let end = 300.0 + 12.0 * sets.len() as f64;
    sets.push(json!({ "at_s": end, "op": null }));
    (sets, end + 30.0)
}

#[test]
fn the_same_seed_and_sets_give_the_same_bytes_and_never_the_truth() {
    let lab = open(&Options::new("test"));
    let (sets, until_s) = turns(&lab, 7);
    let asked = exercise(7, sets, until_s);
    let look = json!({ "exercise": asked, "from": 0 });
    let whole = lab.good("exercise/trend", &look);
    assert_eq!(lab.good("exercise/trend", &look).to_string(), whole.to_string());
    let said = whole.as_object().unwrap();
    assert_eq!(
        said.keys().map(String::as_str).collect::<Vec<_>>(),
        ["sample_time_s", "from", "op", "pv"]
    );
    let pv = whole["pv"].as_array().unwrap();
    assert_eq!(pv.len() as f64, (until_s / 0.2).round());
    // What was done later changes nothing before, and a part is a part.
    let before = json!({ "exercise": exercise(7, vec![], 300.0), "from": 1000 });
    let before = lab.good("exercise/trend", &before);
    assert_eq!(before["pv"].as_array().unwrap()[..], pv[1000..1500]);
    // Another seed is another loop.
    let other = json!({ "exercise": exercise(8, vec![], 300.0), "from": 1000 });
    assert_ne!(lab.good("exercise/trend", &other)["pv"], before["pv"]);
}

#[test]
fn a_sequence_of_turns_finds_s_and_clears_a_healthy_valve() {
    let lab = open(&Options::new("test"));
    let (seed, truth) = valve(&lab, true);
    let (sets, until_s) = turns(&lab, seed);
    let read = lab.good("exercise/read", &exercise(seed, sets, until_s));
    assert_eq!(read["test"]["class"], "sticks", "{seed} {truth}: {}", read["test"]["reasons"]);
    let (found, true_s) = (read["test"]["S"]["value"].as_f64(), truth["S"].as_f64().unwrap());
    assert!((found.unwrap() / true_s - 1.0).abs() < 0.15, "{seed}: {found:?}, {true_s}");
    assert!(read["S"].as_str().unwrap().contains(" to ") && read["svg"].is_string(), "{read}");
    let (seed, truth) = valve(&lab, false);
    let (sets, until_s) = turns(&lab, seed);
    let read = lab.good("exercise/read", &exercise(seed, sets, until_s));
    assert_eq!(read["test"]["class"], "does not stick", "{seed} {truth}: {}", read["test"]);
}

#[test]
fn the_lab_carries_out_the_plan_and_finds_what_is_true() {
    let lab = open(&Options::new("test"));
    for sticks in [true, false] {
        let (seed, truth) = valve(&lab, sticks);
        let begun = lab.good("exercise/begin", &json!({ "seed": seed }));
        assert!(begun["plan"]["instructions"].as_array().unwrap().len() >= 5, "{begun}");
        let done = lab.good("exercise/carry-out", &json!({ "seed": seed }));
        let (sets, until_s) = (done["sets"].as_array().unwrap(), done["until_s"].as_f64().unwrap());
        let asked = exercise(seed, sets.clone(), until_s);
        // It did no more than somebody can who has the buttons.
        let look = json!({ "exercise": asked, "from": 0 });
        assert_eq!(lab.good("exercise/trend", &look), done["recorded"]);
        let class = if sticks { "sticks" } else { "does not stick" };
        let read = lab.good("exercise/read", &asked);
        assert_eq!(read["test"]["class"], class, "{seed} {truth}: {}", read["test"]["reasons"]);
    }
}

#[test]
fn about_one_valve_of_three_is_healthy() {
    let lab = open(&Options::new("test"));
    let healthy =
        |seed: &u32| lab.good("exercise/reveal", &exercise(*seed, vec![], 0.0))["sticks"] == false;
    let count = (0..90).filter(healthy).count();
    assert!((18..=42).contains(&count), "{count} of 90");
}

#[test]
fn what_cannot_be_is_refused_in_a_sentence() {
    let lab = open(&Options::new("test"));
    let set = |at_s: f64, op: f64| json!({ "at_s": at_s, "op": op });
    for (sets, until_s, word) in [
        (vec![set(310.0, 120.0)], 400.0, "0 to 100 %"),
        (vec![set(310.0, -1.0)], 400.0, "0 to 100 %"),
        (vec![set(20.0, 50.0)], 400.0, "in automatic until 300 s"),
        (vec![set(320.0, 50.0), set(310.0, 40.0)], 400.0, "after the previous setting"),
        (vec![set(500.0, 50.0)], 400.0, "before the end at 400 s"),
        (vec![set(310.0, 50.0); 501], 400.0, "at most 500 OP settings"),
        (vec![], 1e9, "0 to 7200 s"),
        (vec![], -1.0, "0 to 7200 s"),
        (vec![set(310.0, 50.0)], 400.0, "needs two turns or more"),
        (vec![], 400.0, "needs two turns or more"),
    ] {
        let (status, said) = lab.call("exercise/read", &exercise(3, sets, until_s));
        assert_eq!(status, 400, "{word}: {said}");
        assert!(said["error"].as_str().unwrap().contains(word), "{word}: {said}");
    }
}
