//! What is tried against the lab's server: no crash, nothing read outside, memory bounded, and its user still served.
//!
//! The long one is ignored; `STICTION_FUZZ_S=600 cargo test -p stiction-lab --test lab -- --ignored --nocapture` mutates
//! valid questions of all calls for ten minutes, from the seed in `STICTION_FUZZ_SEED`.

use super::{Open, open};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use stiction_lab::turns::Cost;
use stiction_lab::{Options, calls};
use stiction_plant::demo;

impl Open {
    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.at).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream.set_write_timeout(Some(Duration::from_secs(60))).unwrap();
        stream
    }

    /// The head of a question with the token, which is the only one on its connection.
    fn head(&self, call: &str, more: &str) -> String {
        format!(
            "POST /api/{call} HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {}\r\nConnection: close\r\n{more}\r\n",
            self.at, self.token
        )
    }

    /// Sends bytes, and gives what comes back: its status, and all of it.
    fn raw(&self, bytes: &[u8]) -> (u16, String) {
        let mut stream = self.connect();
        // One that is refused early may be closed while it is written.
        let _ = stream.write_all(bytes);
        answer(&mut stream)
    }

    fn ask(&self, call: &str, body: &[u8]) -> (u16, String) {
        let mut bytes =
            self.head(call, &format!("Content-Length: {}\r\n", body.len())).into_bytes();
        bytes.extend(body);
        self.raw(&bytes)
    }

    /// That its user is served, and how long that took.
    fn serves(&self) -> Duration {
        let began = Instant::now();
        let (status, text) = self.ask("plant/status", b"{}");
        assert_eq!(status, 200, "{text}");
        began.elapsed()
    }
}

fn answer(stream: &mut TcpStream) -> (u16, String) {
    let mut bytes = vec![];
    let _ = stream.read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let status = text.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
    (status, text)
}

/// What the process took at most so far, kB; 0 where that is not told.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok()).unwrap_or(0)
}

/// A plant of two loops and a day, not scanned, in a folder of its own; beside it something that nobody may read.
fn plant(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("attacks-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    let plant = folder.join("plant");
    demo::write(&plant, 2, 1, 1, || {}).unwrap();
    std::fs::write(folder.join("secret.txt"), "the secret of others").unwrap();
    plant
}

fn with_plant(name: &str) -> (Open, PathBuf) {
    let folder = plant(name);
    (open(&Options { plant: Some(folder.clone()), ..Options::new("test") }), folder)
}

#[test]
fn paths_lead_nowhere() {
    let (lab, folder) = with_plant("paths");
    for path in [
        "/../secret.txt",
        "/..%2fsecret.txt",
        "/%2e%2e/secret.txt",
        "/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
        "/..\\..\\secret.txt",
        "//etc/passwd",
        "/lab.js/../../secret.txt",
        "/api/../plant/plant.toml",
        "/api/plant%2fstatus%00",
        "/plant.toml",
        "/web/dist/index.html",
        "http://127.0.0.1/etc/passwd",
    ] {
        let head = format!(
            "GET {path} HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {}\r\nConnection: close\r\n\r\n",
            lab.at, lab.token
        );
        let (status, text) = lab.raw(head.as_bytes());
        assert!((400..500).contains(&status), "{path}: {text}");
        assert!(!text.contains("secret of") && !text.contains("root:"), "{path}: {text}");
    }
    let escapes = [
        "../secret.txt",
        "/etc/passwd",
        "..\\secret.txt",
        "%2e%2e/secret.txt",
        "a\0b",
        "",
        "*",
        "../../..",
    ];
    for name in escapes {
        for (call, ask) in [
            ("plant/loop", json!({ "loop": name })),
            ("plant/trend", json!({ "loop": name, "day": "2026-03-02", "days": 1 })),
            ("plant/diagnose", json!({ "loop": name, "day": "2026-03-02", "days": 1 })),
            ("plant/note", json!({ "loop": name, "kind": "note", "text": "x" })),
            ("plant/snooze", json!({ "loop": name, "until": "2099-01-01" })),
            ("plant/override", json!({ "loop": name, "verdict": "sticks", "reason": "x" })),
            ("plant/page", json!({ "week": name })),
            ("cycle", json!({ "scenario": name })),
            ("verdict", json!({ "scenario": name })),
        ] {
            let (status, text) = lab.ask(call, ask.to_string().as_bytes());
            assert!((400..500).contains(&status), "{call} {name}: {text}");
            assert!(
                !text.contains("secret of") && !text.contains("root:"),
                "{call} {name}: {text}"
            );
        }
    }
    assert!(!folder.join("log.toml").exists(), "nothing was entered");
}

#[test]
fn what_is_too_long_is_refused_and_not_read() {
    let (lab, _) = with_plant("long");
    let before = peak();
    // Announced: the answer comes before the first byte of it.
    for length in ["10737418240", "18446744073709551615"] {
        let mut stream = lab.connect();
        let head = lab.head("plant/status", &format!("Content-Length: {length}\r\n"));
        stream.write_all(head.as_bytes()).unwrap();
        let (status, text) = answer(&mut stream);
        assert!(matches!(status, 400 | 413 | 431), "{length}: {text}");
    }
    // Without a length: it ends as soon as it is too long, whatever is sent.
    let mut stream = lab.connect();
    stream
        .write_all(lab.head("plant/status", "Transfer-Encoding: chunked\r\n").as_bytes())
        .unwrap();
    let mut chunk = b"100000\r\n".to_vec();
    chunk.resize(chunk.len() + 0x10_0000, b' ');
    chunk.extend(b"\r\n");
    let mut sent = 0_u64;
    let cut = loop {
        match stream.write_all(&chunk) {
            Ok(()) if sent < 10 << 30 => sent += chunk.len() as u64,
            Ok(()) => break false,
            Err(_) => break true,
        }
    };
    assert!(cut && sent < 64 << 20, "{sent} bytes were taken");
    // Without the token nothing of it is read at all; a head may not be long either.
    let head = format!(
        "POST /api/plant/status HTTP/1.1\r\nHost: {}\r\nContent-Length: 10737418240\r\n\r\n",
        lab.at
    );
    let mut stream = lab.connect();
    stream.write_all(head.as_bytes()).unwrap();
    assert_eq!(answer(&mut stream).0, 401);
    let head = format!("GET / HTTP/1.1\r\nHost: {}\r\nX: {}\r\n\r\n", lab.at, "x".repeat(4 << 20));
    let status = lab.raw(head.as_bytes()).0;
    assert!(matches!(status, 0 | 400..=499), "{status}");
    let many: String = (0..10_000).map(|k| format!("X-{k}: 1\r\n")).collect();
    let status = lab.raw(format!("GET / HTTP/1.1\r\nHost: {}\r\n{many}\r\n", lab.at).as_bytes()).0;
    assert!(matches!(status, 0 | 400..=499), "{status}");
    assert!(peak() < before + 256 * 1024, "{} kB, {before} before", peak());
    lab.serves();
}

#[test]
fn a_thousand_connections_keep_nobody_out() {
    let (lab, _) = with_plant("many");
    let mut held = vec![];
    for k in 0..1000 {
        // Where the machine gives no more, those that there are will do.
        let Ok(mut stream) = TcpStream::connect(lab.at) else { break };
        // Some say nothing, some begin a question, some ask for what they may not have.
        let said = match k % 3 {
            0 => String::new(),
            1 => format!("GET / HTTP/1.1\r\nHost: {}\r\nX: ", lab.at),
            _ => format!("GET /lab.js HTTP/1.1\r\nHost: {}\r\n\r\n", lab.at),
        };
        let _ = stream.write_all(said.as_bytes());
        held.push(stream);
    }
    assert!(held.len() > 300, "{}", held.len());
    let took = lab.serves();
    assert!(took < Duration::from_secs(2), "{took:?} with {} connections", held.len());
    // Those that are held go on being held, and none of them is served for ever.
    std::thread::sleep(Duration::from_secs(6));
    let mut byte = [0; 65536];
    let closed = |stream: &mut TcpStream| {
        stream.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
        loop {
            match stream.read(&mut byte) {
                Ok(0) => break true,
                Ok(_) => {}
                Err(e) => break e.kind() == std::io::ErrorKind::ConnectionReset,
            }
        }
    };
    let open = held.iter_mut().map(closed).filter(|closed| !closed).count();
    assert_eq!(open, 0, "of {} connections of strangers", held.len());
    lab.serves();
}

#[test]
fn who_is_known_keeps_the_connection_while_others_come() {
    let (lab, _) = with_plant("known");
    let head = format!(
        "POST /api/plant/status HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {}\r\nContent-Length: 2\r\n\r\n{{}}",
        lab.at, lab.token
    );
    let mut own = lab.connect();
    let mut ask = || {
        own.write_all(head.as_bytes()).unwrap();
        let mut some = [0; 65536];
        let count = own.read(&mut some).unwrap();
        assert!(
            some[..count].starts_with(b"HTTP/1.1 200"),
            "{:?}",
            String::from_utf8_lossy(&some[..count])
        );
    };
    ask();
    let others: Vec<TcpStream> = (0..300).filter_map(|_| TcpStream::connect(lab.at).ok()).collect();
    std::thread::sleep(Duration::from_secs(6));
    ask();
    drop(others);
}

#[test]
fn who_is_slow_is_let_go() {
    let (lab, _) = with_plant("slow");
    // A head that comes byte by byte, without the token.
    let mut head = lab.connect();
    let began = Instant::now();
    let text = format!("GET / HTTP/1.1\r\nHost: {}\r\nX: {}", lab.at, "x".repeat(1000));
    for byte in text.bytes() {
        if head.write_all(&[byte]).is_err() {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
        assert!(began.elapsed() < Duration::from_secs(15), "a slow head is read for ever");
    }
    assert!(began.elapsed() < Duration::from_secs(15));
    // A body that stands still, with the token: it is told so.
    let mut body = lab.connect();
    let began = Instant::now();
    body.write_all(lab.head("plant/status", "Content-Length: 10\r\n").as_bytes()).unwrap();
    body.write_all(b"{").unwrap();
    let (status, text) = answer(&mut body);
    assert_eq!(status, 408, "{text}");
    assert!(began.elapsed() < Duration::from_secs(16), "{:?}", began.elapsed());
    // One that goes on too slowly ends, too.
    let mut body = lab.connect();
    let began = Instant::now();
    body.write_all(lab.head("plant/status", "Content-Length: 100000\r\n").as_bytes()).unwrap();
    while began.elapsed() < Duration::from_secs(20) && body.write_all(b" ").is_ok() {
        std::thread::sleep(Duration::from_millis(500));
    }
    assert!(began.elapsed() < Duration::from_secs(20), "a slow body is read for ever");
    // Half a question, and gone.
    let mut half = lab.connect();
    half.write_all(lab.head("plant/status", "Content-Length: 10\r\n").as_bytes()).unwrap();
    half.shutdown(Shutdown::Both).unwrap();
    lab.serves();
}

#[test]
fn slow_uploads_delay_no_other() {
    let (lab, _) = with_plant("uploads");
    let begin = |_| {
        let mut stream = lab.connect();
        let head = lab.head("recordings/upload?name=slow.csv", "Content-Length: 100000\r\n");
        stream.write_all(format!("{head}t,op\n0,1\n").as_bytes()).unwrap();
        stream
    };
    let slow: Vec<TcpStream> = (0..20).map(begin).collect();
    let began = Instant::now();
    let (status, text) = lab.ask("recordings/upload?name=quick.csv", b"t,op\n0,1\n1,2\n");
    assert_eq!(status, 200, "{text}");
    // The slow ones are given 10 s.
    assert!(began.elapsed() < Duration::from_secs(5), "{:?}", began.elapsed());
    assert!(slow.iter().all(is_silent));
}

/// A map that takes minutes.
fn costly() -> Vec<u8> {
    let axis = |name: &str| json!({ "parameter": name, "from": 1, "to": 1e9, "points": 100 });
    let plant = json!({ "scenario": "lab/flow", "set": ["valve.S=4"] });
    json!({ "loop": plant, "x": axis("theta"), "y": axis("tau") }).to_string().into_bytes()
}

impl Open {
    /// Sends a question of some length, or the beginning of it, and does not wait for the answer.
    fn send(&self, call: &str, length: usize, body: &[u8]) -> TcpStream {
        let mut stream = self.connect();
        let head = self.head(call, &format!("Content-Length: {length}\r\n"));
        stream.write_all(&[head.as_bytes(), body].concat()).unwrap();
        stream
    }

    /// Holds open more questions than there are places.
    fn crowd(&self, call: &str, length: usize, body: &[u8]) -> Vec<TcpStream> {
        let one = |_| {
            // So slowly that hardly any is displaced before it has shown the token.
            std::thread::sleep(Duration::from_millis(5));
            self.send(call, length, body)
        };
        let held: Vec<TcpStream> = (0..160).map(one).collect();
        // Of 128 places; so the others are closed once all have been received, which takes longer on a busy machine.
        let end = Instant::now() + Duration::from_secs(60);
        while held.iter().filter(|stream| !is_silent(stream)).count() < 32 {
            assert!(Instant::now() < end, "{call}: not all were received");
            std::thread::sleep(Duration::from_millis(20));
        }
        held
    }

    /// That calls of a low and of a medium cost are answered.
    fn serves_and_judges(&self) {
        self.serves();
        let (status, text) = self.ask("verdict", br#"{ "loop": { "scenario": "lab/flow" } }"#);
        assert_eq!(status, 200, "{text}");
    }

    /// Waits until no map is worked on.
    fn rests(&self) {
        let end = Instant::now() + Duration::from_secs(60);
        while self.turns.free(Cost::High) < Cost::High.at_once() {
            assert!(Instant::now() < end, "abandoned maps are worked on");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Whether a connection is open, and nothing was answered on it.
fn is_silent(stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    matches!(stream.peek(&mut [0]), Err(e) if e.kind() == std::io::ErrorKind::WouldBlock)
}

#[test]
fn maps_delay_no_other_call_and_end_when_nobody_waits() {
    let (lab, _) = with_plant("maps");
    let held: Vec<_> = (0..40).map(|_| lab.send("map", costly().len(), &costly())).collect();
    while lab.turns.begun(Cost::High) < Cost::High.at_once() {
        std::thread::sleep(Duration::from_millis(5));
    }
    lab.serves_and_judges();
    // All that while the maps were waiting, and no more of them was begun.
    assert!(held.iter().all(is_silent));
    assert_eq!((lab.turns.begun(Cost::High), lab.turns.free(Cost::High)), (2, 0));
    drop(held);
    lab.rests();
    // Abandoned as soon as they were asked.
    for _ in 0..200 {
        drop(lab.send("map", costly().len(), &costly()));
    }
    lab.serves_and_judges();
    lab.rests();
    let axis = |name: &str| json!({ "parameter": name, "from": 1, "to": 4, "points": 3 });
    let small = json!({ "loop": { "scenario": "lab/flow" }, "x": axis("S"), "y": axis("J") });
    lab.good("map", &small);
}

#[test]
fn more_questions_than_places_keep_nobody_out() {
    let (lab, _) = with_plant("places");
    // Half-sent ones first, then whole ones that wait for their turn; all with the token.
    for (call, length, body) in
        [("plant/status", 10, b"{".to_vec()), ("map", costly().len(), costly())]
    {
        let held = lab.crowd(call, length, &body);
        lab.serves_and_judges();
        // While they were held: none of them was refused as too slow, or answered.
        assert!(held.iter().filter(|stream| is_silent(stream)).count() > 64, "{call}");
    }
    lab.rests();
}

/// All calls, with their schemas of what is asked.
fn asks() -> (Vec<(String, Value)>, Value) {
    let schema = calls::schema();
    let calls = schema["properties"].as_object().unwrap();
    let asks = calls.iter().map(|(name, call)| (name.clone(), call["properties"]["ask"].clone()));
    (asks.collect(), schema["$defs"].clone())
}

/// A question that fits a schema, as far as types go.
fn fitting(schema: &Value, definitions: &Value, field: &str) -> Value {
    if let Some(name) = schema["$ref"].as_str() {
        let own = name.rsplit('/').next().unwrap();
        return fitting(&definitions[own], definitions, field);
    }
    if let Some(options) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
        return fitting(&options[0], definitions, field);
    }
    if let Some(one) = schema.get("const").or_else(|| schema["enum"].get(0)) {
        return one.clone();
    }
    let kind = match &schema["type"] {
        Value::Array(kinds) => kinds[0].as_str().unwrap_or("null").to_owned(),
        kind => kind.as_str().unwrap_or("null").to_owned(),
    };
    match &*kind {
        "object" => {
            let empty = serde_json::Map::new();
            let fields = schema["properties"].as_object().unwrap_or(&empty);
            let each = fields.iter().map(|(key, of)| (key.clone(), fitting(of, definitions, key)));
            Value::Object(each.collect())
        }
        "array" => json!([fitting(&schema["items"], definitions, field)]),
        "string" => match field {
            "scenario" => "lab/flow".into(),
            "set" => "valve.S=4".into(),
            "parameter" => "S".into(),
            "loop" => "FIC1001".into(),
            "day" => "2026-03-02".into(),
            "until" => "2099-01-01".into(),
            "week" => "2026-W10".into(),
            "verdict" => "sticks".into(),
            _ => "text".into(),
        },
        "integer" => 1.into(),
        "number" => 2.5.into(),
        "boolean" => false.into(),
        _ => Value::Null,
    }
}

#[test]
fn what_is_malformed_is_refused_in_words() {
    let (lab, _) = with_plant("malformed");
    let (asks, definitions) = asks();
    let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    let nested = format!("{}1{}", "{\"loop\":".repeat(50_000), "}".repeat(50_000));
    for (name, schema) in &asks {
        for body in [
            &b""[..],
            b"{",
            b"nul",
            b"null",
            b"\"x\"",
            b"1e999",
            b"{\"loop\":NaN}",
            b"{\"loop\":Infinity}",
            b"{\"no such field\":1}",
            b"\xff\xfe{}",
            b"{} {}",
            deep.as_bytes(),
            nested.as_bytes(),
        ] {
            let (status, text) = lab.ask(name, body);
            let shown = String::from_utf8_lossy(&body[..body.len().min(40)]);
            // An answer in words, as JSON; some calls ask for nothing that must be there.
            assert!((400..500).contains(&status), "{name} {shown}: {text}");
            let said = text.split("\r\n\r\n").nth(1).unwrap_or_default();
            let said: Value = serde_json::from_str(said).unwrap();
            assert!(!said["error"].as_str().unwrap().is_empty(), "{name} {shown}");
        }
        // Each field of another type, or a number that cannot be.
        let valid = fitting(schema, &definitions, "");
        for key in valid.as_object().unwrap().keys() {
            for wrong in [
                json!({ "a": [[]] }),
                json!(-1e308),
                json!(18446744073709551615_u64),
                json!([null]),
            ] {
                let mut ask = valid.clone();
                ask[key] = wrong;
                let (status, text) = lab.ask(name, ask.to_string().as_bytes());
                assert!(status == 200 || (400..500).contains(&status), "{name} {ask}: {text}");
            }
        }
    }
    lab.serves();
}

#[test]
fn what_is_no_question_at_all_harms_nobody() {
    let (lab, _) = with_plant("noise");
    for bytes in [
        &b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"[..],
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        b"GET / HTTP/1.1\r\n\r\n",
        b"GET / HTTP/9.9\r\nHost: x\r\n\r\n",
        b"\0\0\0\0\0\0\0\0\r\n\r\n",
        b"TRACE / HTTP/1.1\r\nHost: x\r\n\r\n",
        b"CONNECT example.com:443 HTTP/1.1\r\nHost: example.com:443\r\n\r\n",
        b"POST /api/plant/status HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\n",
        b"POST /api/plant/status HTTP/1.1\r\nHost: x\r\nContent-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
        b"POST /api/plant/status HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffffff\r\n",
    ] {
        let mut stream = lab.connect();
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(Shutdown::Write);
        let (status, text) = answer(&mut stream);
        assert!(status == 0 || (400..600).contains(&status), "{text}");
        assert!(!text.contains("200 OK"), "{text}");
    }
    // Two hosts, or two tokens of which one is wrong, get nothing that one alone would not.
    let twice = format!(
        "POST /api/plant/status HTTP/1.1\r\nHost: example.com\r\nHost: {}\r\nAuthorization: Bearer {}\r\nConnection: close\r\n\
         Content-Length: 2\r\n\r\n{{}}",
        lab.at, lab.token
    );
    assert!((400..500).contains(&lab.raw(twice.as_bytes()).0));
    lab.serves();
}

/// A generator of numbers: any will do, as long as they differ (Knuth).
struct Chance(u64);

impl Chance {
    fn below(&mut self, n: usize) -> usize {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// Values that programs stumble over.
fn awkward(chance: &mut Chance) -> Value {
    let all = [
        json!(null),
        json!(true),
        json!(0),
        json!(-1),
        json!(1e308),
        json!(-1e-308),
        json!(18446744073709551615_u64),
        json!(i64::MIN),
        json!(1e15),
        json!(""),
        json!("NaN"),
        json!("../../etc/passwd"),
        json!("valve.S=1e300"),
        json!("run.duration=1e12"),
        json!("9999-12-31"),
        json!("-9999-01-01"),
        json!("2026-W99"),
        json!("x".repeat(5000)),
        json!("\u{0}\u{202e}<script>"),
        json!([]),
        json!({}),
        json!(vec![1; 3000]),
        json!("valve.J=nan"),
        json!("controller.Kc=-1e9"),
        json!("lab/level"),
        json!("theta/tau"),
        json!("FIC1002"),
    ];
    all[chance.below(all.len())].clone()
}

/// Changes something somewhere in a question.
fn mutate(of: &mut Value, chance: &mut Chance) {
    match of {
        Value::Object(map) if !map.is_empty() && chance.below(5) > 0 => {
            let place = chance.below(map.len());
            let key = map.keys().nth(place).cloned().unwrap();
            match chance.below(12) {
                0 => drop(map.remove(&key)),
                1 => drop(map.insert("more".to_owned(), awkward(chance))),
                _ => mutate(map.get_mut(&key).unwrap(), chance),
            }
        }
        Value::Array(list) if !list.is_empty() && chance.below(3) > 0 => {
            let place = chance.below(list.len());
            match chance.below(6) {
                0 => list.extend_from_within(..),
                _ => mutate(&mut list[place], chance),
            }
        }
        Value::Number(number) if chance.below(2) == 0 => {
            let factor = [-1.0, 0.0, 0.5, 2.0, 10.0, 1000.0, 1e6, 1e12][chance.below(8)];
            *of = json!(number.as_f64().unwrap_or(1.0) * factor);
        }
        Value::String(text) if chance.below(3) == 0 => {
            let mut bytes: Vec<char> = text.chars().collect();
            let place = chance.below(bytes.len().max(1));
            bytes.insert(
                place.min(bytes.len()),
                ['\0', '=', '9', '-', '"', 'é', '.'][chance.below(7)],
            );
            *of = bytes.into_iter().collect::<String>().into();
        }
        of => *of = awkward(chance),
    }
}

#[test]
#[ignore = "takes as long as it is told, see the head of this file"]
fn mutated_questions_of_all_calls_find_no_fault() {
    let number = |name: &str, otherwise: u64| {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
    };
    let (lasts, seed) = (number("STICTION_FUZZ_S", 20), number("STICTION_FUZZ_SEED", 1));
    let (lab, folder) = with_plant("fuzz");
    let of = stiction_plant::plant_file::Plant::read(&folder).unwrap();
    let all = stiction_plant::ScanOptions::default();
    stiction_plant::scan(&folder, &of, &all, |_| std::ops::ControlFlow::Continue(())).unwrap();
    let before = peak();
    let (asks, definitions) = asks();
    let valid: Vec<(String, Value)> =
        asks.iter().map(|(name, of)| (name.clone(), fitting(of, &definitions, ""))).collect();
    let end = Instant::now() + Duration::from_secs(lasts);
    let (asked, answered, refused, longest) =
        (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    let is_over = AtomicBool::new(false);
    std::thread::scope(|threads| {
        for worker in 0..6_u64 {
            let (lab, folder, valid, is_over) = (&lab, &folder, &valid, &is_over);
            let (asked, answered, refused, longest) = (&asked, &answered, &refused, &longest);
            threads.spawn(move || {
                let mut chance = Chance(seed.wrapping_mul(1000) + worker);
                while Instant::now() < end && !is_over.load(Ordering::Relaxed) {
                    let (name, ask) = &valid[chance.below(valid.len())];
                    let mut ask = ask.clone();
                    for _ in 0..chance.below(3) {
                        mutate(&mut ask, &mut chance);
                    }
                    // What may be entered would make the log longer and longer.
                    if chance.below(500) == 0 {
                        let _ = std::fs::remove_file(folder.join("log.toml"));
                    }
                    let mut body = ask.to_string().into_bytes();
                    // Some are not even JSON any more.
                    if chance.below(10) == 0 && !body.is_empty() {
                        let place = chance.below(body.len());
                        match chance.below(3) {
                            0 => body.truncate(place),
                            1 => body[place] = chance.below(256) as u8,
                            _ => drop(body.remove(place)),
                        }
                    }
                    let began = Instant::now();
                    let (status, text) = lab.ask(name, &body);
                    longest.fetch_max(began.elapsed().as_millis() as u64, Ordering::Relaxed);
                    asked.fetch_add(1, Ordering::Relaxed);
                    let counted = match status {
                        200 => answered,
                        400..=499 => refused,
                        _ => {
                            is_over.store(true, Ordering::Relaxed);
                            let body = String::from_utf8_lossy(&body).into_owned();
                            panic!("{name} {body}: {status} after {:?}: {text}", began.elapsed());
                        }
                    };
                    counted.fetch_add(1, Ordering::Relaxed);
                    assert!(!text.contains("the secret of others"), "{name} {ask}");
                }
            });
        }
    });
    lab.serves();
    eprintln!(
        "{} questions in {lasts} s, seed {seed}: {} answered, {} refused; the longest {} ms; at most {} MB, {} MB before",
        asked.load(Ordering::Relaxed),
        answered.load(Ordering::Relaxed),
        refused.load(Ordering::Relaxed),
        longest.load(Ordering::Relaxed),
        peak() / 1024,
        before / 1024
    );
    assert!(peak() < 1024 * 1024, "{} kB", peak());
}
