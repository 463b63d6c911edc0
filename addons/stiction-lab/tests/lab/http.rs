//! The lab as its page and others ask it: over HTTP.

use super::{agent, open};
use serde_json::{Value, json};
use stiction_io::scenario::{Scenario, System};
use stiction_lab::Options;

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn a_loop_that_runs_gives_the_samples_of_simulate_to_the_last_bit() {
    let lab = open(&Options::new("test"));
    for (scenario, set) in [
        ("lab/flow", vec!["valve.S=6", "valve.J=3"]),
        ("lab/level", vec![]),
        ("lab/temperature", vec!["valve.model=kano"]),
        ("samples/sticky-flow", vec![]),
    ] {
        let texts: Vec<String> = set.iter().map(ToString::to_string).collect();
        let System::ClosedLoop(plant) = Scenario::open(scenario, &texts).unwrap().system else {
            panic!("{scenario}")
        };
        let run = plant.run().unwrap();
        let knobs = json!({ "loop": { "scenario": scenario, "set": set } });
        let (status, begun) = lab.call("live/begin", &knobs);
        assert_eq!(status, 200, "{begun}");
        let mut from = 0;
        for samples in [1, 7, 500, 1000] {
            let ask =
                json!({ "id": begun["id"], "from": from, "samples": samples, "knobs": knobs });
            let (status, first) = lab.call("live/go", &ask);
            assert_eq!(status, 200, "{first}");
            // An answer that was lost is given again.
            assert_eq!(lab.call("live/go", &ask), (200, first.clone()));
            for (name, signal) in
                [("sp", &run.sp), ("pv", &run.pv), ("op", &run.op), ("vp", &run.vp)]
            {
                assert_eq!(
                    numbers(&first[name]),
                    signal[from..from + samples],
                    "{scenario} {name}"
                );
            }
            from += samples;
        }
    }
}

#[test]
fn who_has_no_token_another_host_or_another_origin_is_not_answered() {
    let lab = open(&Options::new("test"));
    let url = format!("http://{}/api/scenarios", lab.at);
    let bearer = format!("Bearer {}", lab.token);
    let status = |headers: &[(&str, &str)]| {
        let mut request = agent().post(&url);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        request.send("{}").unwrap().status().as_u16()
    };
    let own = format!("http://{}", lab.at);
    assert_eq!(status(&[("authorization", &bearer)]), 200);
    assert_eq!(status(&[("authorization", &bearer), ("origin", &own)]), 200);
    assert_eq!(status(&[]), 401);
    assert_eq!(status(&[("authorization", "Bearer 00000000000000000000000000000000")]), 401);
    assert_eq!(status(&[("authorization", &bearer), ("origin", "http://example.com")]), 403);
    assert_eq!(status(&[("authorization", &bearer), ("origin", "null")]), 403);
    assert_eq!(status(&[("authorization", &bearer), ("sec-fetch-site", "cross-site")]), 403);
    assert_eq!(status(&[("authorization", &bearer), ("host", "example.com")]), 421);
    let rebound = format!("example.com:{}", lab.at.port());
    assert_eq!(status(&[("authorization", &bearer), ("host", &rebound)]), 421);
}

#[test]
fn the_page_is_open_and_every_question_needs_the_token_in_a_header() {
    let lab = open(&Options::new("test"));
    let get = |path: &str, header: (&str, &str)| {
        agent().get(format!("http://{}{path}", lab.at)).header(header.0, header.1).call().unwrap()
    };
    let none = ("x-nothing", "");
    for path in ["/", "/lab.js", "/lab.css"] {
        let page = get(path, none);
        assert_eq!(page.status().as_u16(), 200, "{path}");
        // What a browser would send to every port of this machine.
        assert!(page.headers().get("set-cookie").is_none(), "{path}");
        let policy = page.headers()["content-security-policy"].to_str().unwrap();
        assert!(policy.contains("default-src 'none'") && !policy.contains("unsafe"), "{policy}");
    }
    let cookies = format!("stiction_lab_{}={}", lab.at.port(), lab.token);
    let basic = format!("Basic {}", lab.token);
    for path in [
        "/api/recordings/trend?file=a&loop=b".to_owned(),
        format!("/api/recordings/trend?file=a&loop=b&token={}", lab.token),
        format!("/api/recordings?token={}", lab.token),
        "/api/none".to_owned(),
        "/none".to_owned(),
        "/report".to_owned(),
    ] {
        for header in [none, ("cookie", &cookies), ("authorization", &basic)] {
            assert_eq!(get(&path, header).status().as_u16(), 401, "{path} {header:?}");
        }
    }
    for (name, _) in stiction_lab::calls::schema()["properties"].as_object().unwrap() {
        let url = format!("http://{}/api/{name}", lab.at);
        let status = agent().post(&url).header("cookie", &cookies).send("{}").unwrap().status();
        assert_eq!(status.as_u16(), 401, "{name}");
    }
}

/// What `stiction diagnose` says of the CSV that `stiction simulate` writes.
#[test]
fn the_verdict_of_a_loop_is_that_of_its_csv() {
    use stiction_io::{options::ReadOptions, reading, table};
    let lab = open(&Options::new("test"));
    let System::ClosedLoop(plant) =
        Scenario::open("lab/flow", &["valve.S=3".to_owned()]).unwrap().system
    else {
        panic!()
    };
    let run = plant.run().unwrap();
    let times = table::times(run.sample_time, run.op.len());
    let columns = [("t", &times), ("sp", &run.sp), ("pv", &run.pv), ("op", &run.op)];
    let csv = table::write(&columns.map(|(name, values)| (name, Some(&values[..]))));
    let read = reading::parse(csv.as_bytes(), "flow.csv", &ReadOptions::default()).unwrap();
    let expected =
        stiction_diagnose::diagnose::diagnose(&read.recordings[0], &Default::default()).unwrap();
    let (status, said) =
        lab.call("verdict", &json!({ "loop": { "scenario": "lab/flow", "set": ["valve.S=3"] } }));
    assert_eq!(status, 200, "{said}");
    assert_eq!(said["diagnosis"], serde_json::to_value(&expected).unwrap());
}

#[test]
fn cycles_and_maps_are_those_of_the_library() {
    use stiction_model::limit_cycle::map::{Axis, Map, Parameter};
    use stiction_model::limit_cycle::{ContinuousLoop, Found, Method};
    let lab = open(&Options::new("test"));
    let scenario = Scenario::open("paper/closed-loop", &[]).unwrap();
    let System::ClosedLoop(plant) = &scenario.system else { panic!() };
    let l = ContinuousLoop::of(plant, scenario.valve.0, scenario.valve.1).unwrap();
    let asked = json!({ "scenario": "paper/closed-loop" });
    let (status, said) = lab.call("cycle", &asked);
    assert_eq!(status, 200, "{said}");
    let found =
        [Method::Exact, Method::DescribingFunction].map(|m| Found::of(&l, m, false).unwrap());
    let cycles: Vec<_> = found.iter().flat_map(|found| &found.cycles).collect();
    assert!(!cycles.is_empty());
    assert_eq!(said["cycles"], serde_json::to_value(&cycles).unwrap());
    let axis =
        |name: &str, to: f64| json!({ "parameter": name, "from": 1.0, "to": to, "points": 5 });
    let (status, said) =
        lab.call("map", &json!({ "loop": asked, "x": axis("S", 9.0), "y": axis("J", 4.0) }));
    assert_eq!(status, 200, "{said}");
    let even = |parameter, to| Axis::even(parameter, 1.0, to, 5).unwrap();
    let map = Map::of(&l, even(Parameter::S, 9.0), even(Parameter::J, 4.0), Method::Exact).unwrap();
    assert_eq!(said, serde_json::to_value(&map).unwrap());
}

#[test]
fn settings_turn_a_loop_without_a_jump() {
    let lab = open(&Options::new("test"));
    let knobs = |set: Value| json!({ "loop": { "scenario": "lab/flow", "set": set } });
    let mut at = 0;
    let (_, begun) = lab.call("live/begin", &knobs(json!([])));
    let mut go = |knobs: Value| {
        let ask = json!({ "id": begun["id"], "from": at, "samples": 400, "knobs": knobs });
        let (status, said) = lab.call("live/go", &ask);
        assert_eq!(status, 200, "{said}");
        at += 400;
        said
    };
    let mut before = go(knobs(json!([])));
    let by_hand = json!({ "loop": { "scenario": "lab/flow" }, "manual": 48.0 });
    let stem = json!({ "loop": { "scenario": "lab/flow" }, "stem": true });
    let knocker = json!({ "loop": { "scenario": "lab/flow" }, "compensator": "knocker" });
    for next in [
        knobs(json!(["valve.S=8", "valve.J=4"])),
        knobs(json!(["controller.kc=0.3", "controller.ti=5"])),
        knobs(json!(["valve.model=kano"])),
        knobs(json!(["process.delay=1.2"])),
        stem,
        knocker,
        by_hand,
    ] {
        let after = go(next.clone());
        assert_eq!(after["went_on"], true, "{next}");
        let (vp, pv) = (numbers(&after["vp"]), numbers(&after["pv"]));
        // A stem may slip, by S and J at most; the PV cannot.
        assert!((vp[0] - numbers(&before["vp"])[399]).abs() < 9.0, "{next}");
        assert!((pv[0] - numbers(&before["pv"])[399]).abs() < 1.0, "{next}");
        before = after;
    }
    assert_eq!(numbers(&before["signal"])[399], 48.0);
    // What is not the lab's is told.
    let ask = json!({ "id": 999, "from": 0, "samples": 1, "knobs": knobs(json!([])) });
    assert_eq!(lab.call("live/go", &ask).0, 404);
    for (name, ask) in [
        ("cycle", json!({ "scenario": "/etc/passwd" })),
        ("cycle", json!({ "scenario": "paper/flow-cascade" })),
        (
            "cycle",
            json!({ "scenario": "lab/flow", "set": ["set_point.signal=samples", "set_point.file=/etc/passwd"] }),
        ),
        ("live/begin", json!({ "loop": { "scenario": "lab/flow", "set": ["duration=1e7"] } })),
        (
            "map",
            json!({ "loop": { "scenario": "lab/flow" }, "x": { "parameter": "S", "from": 0, "to": 1, "points": 100000 }, "y": { "parameter": "J", "from": 0, "to": 1, "points": 100000 } }),
        ),
    ] {
        let (status, said) = lab.call(name, &ask);
        assert!(
            (400..500).contains(&status) && said["error"].is_string(),
            "{name} {ask}: {status} {said}"
        );
    }
}

#[test]
fn a_seed_gives_the_same_loops_and_no_truth_before_it_is_requested() {
    let lab = open(&Options::new("test"));
    for number in 0..4 {
        let which = json!({ "seed": 11, "number": number });
        let (status, trends) = lab.call("guess/trends", &which);
        assert_eq!(status, 200, "{trends}");
        assert_eq!(lab.call("guess/trends", &which).1, trends);
        assert!(trends["signals"].as_array().unwrap().iter().all(|each| each["name"] != "VP"));
        let (status, truth) = lab.call("guess/reveal", &which);
        assert_eq!(status, 200, "{truth}");
        assert!(trends["kinds"].as_array().unwrap().contains(&truth["kind"]));
    }
}
