//! The lab as its page and others ask it: over HTTP.

use serde_json::{Value, json};
use std::net::SocketAddr;
use stiction_io::scenario::{Scenario, System};
use stiction_lab::{Options, bind};

/// A lab that runs, and what its page knows.
struct Open {
    at: SocketAddr,
    token: String,
}

/// Opens a lab that is there until the tests end.
fn open(options: &Options) -> Open {
    let server = bind(options).unwrap();
    let open = Open { at: server.listens(), token: server.token().to_owned() };
    std::thread::spawn(|| server.serve(std::future::pending()).unwrap());
    open
}

/// Who asks without a name of its own.
fn agent() -> ureq::Agent {
    ureq::Agent::config_builder().http_status_as_error(false).max_redirects(0).build().into()
}

impl Open {
    fn call(&self, name: &str, ask: &Value) -> (u16, Value) {
        let mut answer = agent()
            .post(format!("http://{}/api/{name}", self.at))
            .header("authorization", format!("Bearer {}", self.token))
            .send(ask.to_string())
            .unwrap();
        let text = answer.body_mut().read_to_string().unwrap();
        (answer.status().as_u16(), serde_json::from_str(&text).unwrap_or(Value::String(text)))
    }
}

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
fn the_token_of_the_address_becomes_a_cookie_and_leaves_the_address() {
    let lab = open(&Options::new("test"));
    let get = |path: &str, cookie: &str| {
        agent().get(format!("http://{}{path}", lab.at)).header("cookie", cookie).call().unwrap()
    };
    let first = get(&format!("/?token={}", lab.token), "");
    assert_eq!(
        (first.status().as_u16(), &first.headers()["location"]),
        (303, &"/".parse().unwrap())
    );
    let cookie = first.headers()["set-cookie"].to_str().unwrap().to_owned();
    assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"), "{cookie}");
    let page = get("/", cookie.split(';').next().unwrap());
    assert_eq!(page.status().as_u16(), 200);
    let policy = page.headers()["content-security-policy"].to_str().unwrap();
    assert!(policy.contains("default-src 'none'") && !policy.contains("unsafe"), "{policy}");
    assert_eq!(get("/", "").status().as_u16(), 401);
    assert_eq!(get("/?token=00", "").status().as_u16(), 401);
    assert_eq!(get("/lab.js", "").status().as_u16(), 401);
}
