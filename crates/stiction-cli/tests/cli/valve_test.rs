//! `stiction test`.

use crate::{folder, read, refuses, run, write};
use std::path::Path;

/// A path of the project, from the folder of a test.
pub fn sample(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples").join(name).display().to_string()
}

#[test]
fn a_test_is_planned_and_read() {
    let folder = folder("test-plan-read");
    let tested = sample("test/FIC106-tested.csv");
    // A week's file would hold operation and test; here operation alone is what the plan is made of.
    let whole = std::fs::read_to_string(&tested).unwrap();
    let operation: String = whole.lines().take(700).map(|line| format!("{line}\n")).collect();
    write(&folder, "FIC106-tested.csv", operation);
    let plan = ["test", "plan", "FIC106-tested.csv", "--sheet", "sheet.html"];
    let words = run(&folder, &plan).quiet_success();
    for part in ["Put the controller in manual", "The PV rises when the OP rises", "+0.2, -0.2"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(words.lines().all(|line| line.chars().count() <= 100), "{words}");
    let sheet = read(&folder, "sheet.html");
    assert!(sheet.contains("<h1>Valve test of FIC106-tested</h1>") && !sheet.contains("http"));
    let json = run(&folder, &["test", "plan", "FIC106-tested.csv", "--json"]).quiet_success();
    write(&folder, "plan.json", &json);
    let csv = run(&folder, &["test", "plan", "FIC106-tested.csv", "--csv", "-"]).quiet_success();
    assert!(csv.starts_with("turn,op_from_u0_percent,hold_at_most_s,time,op\n1,"), "{csv}");

    let read_it = ["test", "read", &*tested, "--plan", "plan.json", "--json"];
    let found = run(&folder, &read_it).json();
    let test = &found["loops"][0]["test"];
    assert_eq!((&test["class"], &test["known_by"]), (&"sticks".into(), &"mode".into()));
    let of = |what: &str| test["S"][what].as_f64().unwrap();
    assert!(of("low") < 3.24 && 3.24 < of("high"), "{test}");
    assert!(test["steps"].as_array().unwrap().len() > 20);

    let words = run(&folder, &["test", "read", &tested, "--plot", "answers.svg", "--fail"]);
    assert_eq!((words.code, &*words.err), (1, ""));
    let page = include_str!("../../../../docs/test.md");
    assert!(page.contains(&words.out), "docs/test.md must show: {}", words.out);
    assert!(read(&folder, "answers.svg").contains("turn of the OP"));
}

/// Plans a test from the operation of a built-in scenario, lets `stiction simulate` carry it out, and reads it. Turns
/// grow beyond `largest` and shrink to half of it, as the plan says.
fn simulated(folder: &Path, scenario: &str, largest: f64) -> serde_json::Value {
    let columns = ["--columns", "t,sp,pv,op,mode", "--force"];
    run(folder, &["simulate", scenario, "-o", "loop.csv", "--columns", "t,sp,pv,op", "--force"])
        .quiet_success();
    let plan = run(folder, &["test", "plan", "loop.csv", "--json"]).json();
    write(folder, "plan.json", plan.to_string());
    let plan = &plan["plan"];
    let number = |of: &serde_json::Value| of.as_f64().unwrap();
    let printed = run(folder, &["simulate", scenario, "--print"]).quiet_success();
    // The test is of the valve's own loop, so its master is set aside.
    let text = printed.split("[master").next().unwrap();
    let duration = text.lines().find(|line| line.starts_with("duration")).unwrap();
    let from: f64 = duration.split(['=', '#']).nth(1).unwrap().trim().parse().unwrap();

    let (mut at, mut steps) = (from, vec![]);
    let mut turn = |op: f64, hold: f64| {
        steps.push(format!("[{at}, {op}]"));
        at += hold;
    };
    let grow = plan["grow"].as_array().unwrap();
    let sizes = grow.chunks(plan["each"].as_u64().unwrap() as usize);
    let mut last = (0.0, 0.0);
    for pair in sizes {
        pair.iter().for_each(|each| turn(number(&each["op"]), number(&each["hold_s"])));
        last = (number(&pair[0]["op"]), number(&pair[0]["hold_s"]));
        if 2.0 * last.0.abs() > largest {
            pair.iter().for_each(|each| turn(number(&each["op"]), number(&each["hold_s"])));
            break;
        }
    }
    let (mut op, hold) = last;
    while 2.0 * op.abs() > 0.5 * largest {
        op *= number(&plan["shrink_by"]);
        turn(op, hold);
        turn(-op, hold);
    }
    let steps = steps.join(", ");
    write(
        folder,
        "tested.toml",
        format!(
            "{}\n[[manual]]\nfrom = {from}\nuntil = {at}\n\
             change = {{ signal = \"steps\", steps = [{steps}] }}\n",
            text.replace(duration, &format!("duration = {}", at + 10.0 * hold)),
        ),
    );
    let carried_out = ["simulate", "tested.toml", "-o", "loop.csv"];
    run(folder, &[&carried_out[..], &columns].concat()).quiet_success();
    let read = ["test", "read", "loop.csv", "--plan", "plan.json", "--json"];
    run(folder, &read).json()["loops"][0]["test"].clone()
}

#[test]
fn a_planned_test_is_simulated_and_read_on_loops_of_every_type() {
    let folder = folder("test-simulated");
    // Turns must be larger than S + J, because a stem that never moved may stand in the middle of its band.
    for (scenario, s, largest) in [
        ("samples/sticky-flow", 4.0, 7.0),
        ("samples/cascade-slave", 5.0, 9.0),
        ("lab/flow", 5.0, 8.0),
        ("lab/level", 5.0, 8.0),
        ("lab/temperature", 5.0, 8.0),
    ] {
        let test = simulated(&folder, scenario, largest);
        assert_eq!(test["class"], "sticks", "{scenario}: {test}");
        let of = |what: &str| test["S"][what].as_f64().unwrap();
        assert!(of("low") < s && s < of("high"), "{scenario}: {test}");
        assert!((of("value") / s - 1.0).abs() < 0.15, "{scenario}: {test}");
    }
    for healthy in ["samples/disturbed-flow", "samples/aggressive-flow", "samples/quantised-level"]
    {
        let test = simulated(&folder, healthy, 4.0);
        assert_eq!(test["class"], "does not stick", "{healthy}: {test}");
        // The steps from size to size are larger where the loop is slow.
        let least = if healthy.ends_with("level") { 3.0 } else { 1.5 };
        assert!(test["S_below"].as_f64().unwrap() < least, "{healthy}: {test}");
    }
}

#[test]
fn a_sheet_stands_for_a_mode() {
    let folder = folder("test-sheet");
    let tested = sample("test/FIC106-tested.csv");
    let whole = std::fs::read_to_string(&tested).unwrap();
    let mut done = String::from("turn,time,op\n");
    let mut last = "";
    let mut without = String::new();
    for line in whole.lines() {
        let cells: Vec<&str> = line.split(',').collect();
        without += &format!("{}\n", cells[..4].join(","));
        let now = if cells[4] == "MAN" { cells[1] } else { "" };
        if now != last && cells[4] != "mode" {
            done += &format!("1,{},{now}\n", cells[0]);
        }
        last = now;
    }
    write(&folder, "FIC106-tested.csv", without);
    write(&folder, "done.csv", &done);
    let by_sheet = ["test", "read", "FIC106-tested.csv", "--done", "done.csv", "--json"];
    let by_sheet = run(&folder, &by_sheet).json();
    let by_mode = run(&folder, &["test", "read", &tested, "--json"]).json();
    let s = |of: &serde_json::Value| of["loops"][0]["test"]["S"].clone();
    assert_eq!(s(&by_sheet), s(&by_mode));
    assert_eq!(by_sheet["loops"][0]["test"]["known_by"], "sheet");
    // Without either the turns are found by what the OP does.
    let by_output = run(&folder, &["test", "read", "FIC106-tested.csv", "--json"]).json();
    assert_eq!(by_output["loops"][0]["test"]["class"], "sticks");

    for (sheet, expected) in [
        ("turn,op\n1,40\n", "done.csv: the column \"time\" is missing"),
        ("time,op\nten,40\n", "done.csv, row 2, column time: \"ten\" is not a number of seconds"),
        ("time,op\n10,140\n", "done.csv, row 2, column op: \"140\" is not an OP in percent"),
        ("time,op\n10,40\n9,41\n", "done.csv, row 3, column time: \"9\" is before the row above"),
        ("time,op\n,40\n", "done.csv, row 2, column time: \"\" is not a time"),
        ("time,op\n", "done.csv: no row has a time"),
        ("time,op\n900000,40\n900010,41\n900020,\n", "the test is outside the recording"),
    ] {
        write(&folder, "done.csv", sheet);
        refuses(&folder, &["test", "read", "FIC106-tested.csv", "--done", "done.csv"], expected);
    }
}

#[test]
fn what_cannot_be_planned_or_read_is_reported() {
    let folder = folder("test-refused");
    refuses(&folder, &["test", "read", &sample("FIC101-sticky.csv")], "the recording has no test");
    let still: String = (0..400).map(|k| format!("{k},50,{}\n", k % 3)).collect();
    write(&folder, "FIC1.csv", format!("t,op,pv\n{still}"));
    refuses(&folder, &["test", "plan", "FIC1.csv"], "the OP or the PV does not move");
    let plan = run(&folder, &["test", "plan", &sample("FIC101-sticky.csv"), "--json"]);
    write(&folder, "plan.json", plan.quiet_success());
    let tested = sample("test/FIC106-tested.csv");
    let refused = run(&folder, &["test", "read", &tested, "--plan", "plan.json"]).refusal();
    assert!(refused.contains("the plan is for loop FIC101-sticky"), "{refused}");
    let plan = read(&folder, "plan.json");
    for (key, value, says) in [
        ("hold_s", "-1.0", "the hold of turn 1 is -1 s, but must be above 0"),
        ("hold_s", "0.0", "the hold of turn 1 is 0 s"),
        ("op", "0.0", "the size of turn 1 is 0 %"),
        ("answer", "-1.0", "the answer is -1, but must be above 0"),
    ] {
        let (before, rest) = plan.split_once(&format!("\"{key}\": ")).unwrap();
        let end = rest.find([',', '\n']).unwrap();
        write(&folder, "wrong.json", format!("{before}\"{key}\": {value}{}", &rest[end..]));
        refuses(&folder, &["test", "read", &tested, "--plan", "wrong.json"], says);
    }
    write(&folder, "plan.json", "{}");
    let refused = run(&folder, &["test", "read", &tested, "--plan", "plan.json"]).refusal();
    assert!(refused.contains("the key \"plan\" is missing"), "{refused}");
    let limits = ["test", "plan", &sample("FIC101-sticky.csv"), "--pv-low", "9", "--pv-high", "3"];
    refuses(&folder, &limits, "the lower limit of the PV is not below");
    // The test in a recording gives its verdict.
    let found = run(&folder, &["diagnose", &tested, "--json"]).json()["loops"][0].clone();
    let verdict = &found["verdict"];
    assert_eq!((&verdict["class"], &verdict["basis"]), (&"sticks".into(), &"valve test".into()));
    let s = |end: &str| found["stiction"]["S"][end].as_f64().unwrap();
    assert!(s("low") < 3.24 && 3.24 < s("high") && verdict["confirm"].is_null(), "{verdict}");
    let notes = found["notes"].to_string();
    assert!(notes.contains("the verdict is from the valve test in this recording"), "{notes}");
    // Without the mode a controller may have moved the OP, so the test is only noted.
    let whole = std::fs::read_to_string(&tested).unwrap();
    let rows = whole.lines().map(|row| format!("{}\n", row.rsplit_once(',').unwrap().0));
    write(&folder, "no-mode.csv", rows.collect::<String>());
    let found = run(&folder, &["diagnose", "no-mode.csv", "--json"]).json()["loops"][0].clone();
    assert_ne!(found["verdict"]["basis"], "valve test");
    let notes = found["notes"].to_string();
    assert!(notes.contains("seems to contain a valve test"), "{notes}");
    let words = run(&folder, &["diagnose", &tested, "--report", "report.html"]);
    assert!(words.code == 0, "{}", words.err);
    let page = read(&folder, "report.html");
    assert!(page.contains("The valve test in this recording shows that the valve sticks"));
    assert!(!page.contains("Test the valve in manual"));
}

/// The recorded ramps of the plan in `plan.json`, as a CSV file with the columns time_s and OP, a sample a second.
fn ramped(folder: &Path, plan: &serde_json::Value) -> String {
    let mut text = "time_s,OP\n".to_owned();
    let (mut at, mut k) = (plan["from_op"].as_f64().unwrap(), 0);
    let mut row = |op: f64| {
        text += &format!("{k},{op:.3}\n");
        k += 1;
    };
    for ramp in plan["ramps"].as_array().unwrap() {
        let of = |what: &str| ramp[what].as_f64().unwrap();
        let (to, n) = (of("to_op"), of("duration_s") as usize);
        (1..=n).for_each(|k| row(at + (to - at) * k as f64 / n as f64));
        (0..of("hold_s") as usize).for_each(|_| row(to));
        at = to;
    }
    write(folder, "op.csv", &text);
    text
}

#[test]
fn a_signature_is_planned_performed_and_read() {
    let folder = folder("test-signature");
    let plan = ["test", "plan", &sample("LIC104-quantised.csv"), "--signature"];
    let words = run(&folder, &[&plan[..], &["--sheet", "sheet.html"]].concat()).quiet_success();
    assert!(words.contains("Ramp the OP as in the table") && words.contains("to 100 %"), "{words}");
    assert!(words.lines().all(|line| line.chars().count() <= 100), "{words}");
    let sheet = read(&folder, "sheet.html");
    assert!(sheet.contains("<h1>Valve signature of LIC104-quantised</h1>"), "{sheet}");
    let csv = run(&folder, &[&plan[..], &["--csv", "-"]].concat()).quiet_success();
    assert!(
        csv.starts_with("ramp,op_from_percent,op_to_percent,duration_s,hold_s\n1,0,10,40,10\n")
    );
    let json = run(&folder, &[&plan[..], &["--json"]].concat()).json();
    ramped(&folder, &json["signature"]);

    // Carried out on a valve, before and after its repair.
    let made = |name: &str, s: &str, j: &str| {
        let valve = ["valve", "op.csv", "--column", "OP", "--S", s, "--J", j, "-o", name];
        run(&folder, &valve).quiet_success();
        run(&folder, &["test", "read", name, "--json"]).json()["loops"][0]["signature"].clone()
    };
    let (old, new) = (made("LV104-before.csv", "4", "2"), made("LV104-after.csv", "0.1", "0"));
    assert_eq!((&old["class"], &new["class"]), (&"sticks".into(), &"does not stick".into()));
    for (what, truth) in [("S", 4.0), ("J", 2.0)] {
        let of = |end: &str| old[what][end].as_f64().unwrap();
        assert!(of("low") < truth && truth < of("high"), "{old}");
    }
    assert_eq!(old["places"].as_array().unwrap().len(), 10);
    let both = ["test", "read", "LV104-after.csv", "--before", "LV104-before.csv"];
    let more = ["--report", "repair.html", "--plot", "both.svg", "--fail"];
    let words = run(&folder, &[&both[..], &more].concat()).quiet_success();
    assert!(words.contains("The repair lowered S from 4 %"), "{words}");
    assert!(read(&folder, "repair.html").contains("The two signatures, side by side."));
    assert!(read(&folder, "both.svg").contains("stem position"));
    let alone = ["test", "read", "LV104-before.csv", "--report", "s.html", "--fail"];
    let alone = run(&folder, &alone);
    assert!(alone.code == 1 && alone.out.contains(": sticks\n  The valve sticks"), "{}", alone.out);
    assert!(read(&folder, "s.html").contains("Valve signature of LV104-before"));

    // The sample binds in the middle, and the page shows what is printed.
    let bound = sample("test/LV104-signature.csv");
    let words = run(&folder, &["test", "read", &bound]).quiet_success();
    let page = include_str!("../../../../docs/test.md");
    assert!(page.contains(&words), "docs/test.md must show: {words}");

    // Its plan is not that of turns.
    write(&folder, "signature.json", json.to_string());
    let planned = ["test", "read", "LV104-before.csv", "--plan", "signature.json"];
    refuses(&folder, &planned, "the plan of a signature");

    // A test with turns and a signature are not compared.
    let turns = sample("test/FIC107-tested.csv");
    let refused = run(&folder, &["test", "read", "LV104-after.csv", "--before", &turns]).refusal();
    assert!(refused.contains("compare two tests of the same kind"), "{refused}");
    let narrow = [&plan[..], &["--op-low", "40", "--op-high", "45"]].concat();
    refuses(&folder, &narrow, "an OP range of at least 10 %");
}

/// A recording of operation, then in manual of slow ramps up, down and back, of a valve with S and J under a process with a
/// lag of 8 s. The valve's position is not recorded.
fn ramps_in_manual(folder: &Path, name: &str, s: &str, j: &str) {
    let wandering = |k: i32| 50.0 + 3.0 * (f64::from(k) / 40.0).sin() + (f64::from(k) / 13.0).sin();
    let mut op: Vec<f64> = (0..600).map(wandering).collect();
    for (from, to) in [(50.0f64, 62.0), (62.0, 38.0), (38.0, 50.0)] {
        let n = (25.0 * (to - from).abs()) as i32;
        op.extend((1..=n).map(|k| from + (to - from) * f64::from(k) / f64::from(n)));
        op.extend([to; 60]);
    }
    let rows: String = op.iter().enumerate().map(|(k, op)| format!("{k},{op:.3}\n")).collect();
    write(folder, "op.csv", format!("t,OP\n{rows}"));
    let valve =
        ["valve", "op.csv", "--column", "OP", "--S", s, "--J", j, "-o", "vp.csv", "--force"];
    run(folder, &valve).quiet_success();
    let position = read(folder, "vp.csv");
    let stem = position.lines().skip(1).map(|row| row.rsplit(',').next().unwrap().parse().unwrap());
    let (mut text, mut pv) = ("t,FIC1.SP,FIC1.PV,FIC1.OP,FIC1.MODE\n".to_owned(), 75.0);
    for (k, (op, vp)) in op.iter().zip(stem).enumerate() {
        let vp: f64 = vp;
        pv += (1.0 - (-1.0f64 / 8.0).exp()) * (1.5 * vp - pv);
        let noise = 0.1 * (12.9898 * k as f64).sin();
        let mode = if k < 600 { "AUTO" } else { "MAN" };
        text += &format!("{k},75,{:.3},{op:.3},{mode}\n", pv + noise);
    }
    write(folder, name, text);
}

#[test]
fn ramps_in_manual_are_read_from_the_pv() {
    let folder = folder("test-ramps");
    ramps_in_manual(&folder, "sticky.csv", "3", "1");
    ramps_in_manual(&folder, "healthy.csv", "0", "0");
    let sticky = ["test", "read", "sticky.csv", "--json"];
    let found = run(&folder, &sticky).json()["loops"][0]["signature"].clone();
    assert_eq!(found["class"], "sticks", "{found}");
    let of = |end: &str| found["S"][end].as_f64().unwrap();
    assert!(of("low") < 3.0 && 3.0 < of("high") && (2.4..3.6).contains(&of("value")), "{found}");
    let pages = ["--report", "ramps.html", "--plot", "ramps.svg", "--fail"];
    let words = run(&folder, &[&sticky[..3], &pages].concat());
    assert!(words.code == 1 && words.out.contains(", 10 min to "), "{}", words.out);
    assert!(read(&folder, "ramps.svg").contains("PV as a position"));
    let healthy = run(&folder, &["test", "read", "healthy.csv"]).quiet_success();
    assert!(healthy.contains(": does not stick\n"), "{healthy}");
}

/// The stem of a physical valve, with the S and J of its friction.
#[test]
fn a_signature_finds_the_friction_of_a_physical_stem() {
    let folder = folder("test-signature-stem");
    let plan = ["test", "plan", &sample("LIC104-quantised.csv"), "--signature", "--json"];
    let json = run(&folder, &plan).json();
    let op = ramped(&folder, &json["signature"]).replace("time_s,OP", "t,u");
    write(&folder, "u.csv", op);
    for set in ["cts", "cts-stribeck"] {
        let friction = ["--set", "static_n=170", "--set", "coulomb_n=140"];
        let stem = ["stem", "--parameters", set, "--input", "u.csv", "-o", "stem.csv", "--json"];
        let stem = run(&folder, &[&stem[..], &friction].concat()).json();
        let found = run(&folder, &["test", "read", "stem.csv", "--json"]).json();
        let found = &found["loops"][0]["signature"];
        let truth = stem["equivalent"]["S_percent_of_signal"].as_f64().unwrap();
        let s = found["S"]["value"].as_f64().unwrap();
        assert!((s / truth - 1.0).abs() < 0.15, "{set}: {truth} {found}");
    }
}

/// A sample on the given day of March 2026, from 06:00 on.
pub fn dated(path: &str, day: u32) -> String {
    let whole = std::fs::read_to_string(path).unwrap();
    let line = |line: &str| match line.split_once(',') {
        Some((t, rest)) if !matches!(t, "time_s" | "t") => {
            let t: f64 = t.parse().unwrap();
            let (h, m, s) = (6.0 + (t / 3600.0).floor(), (t / 60.0).floor() % 60.0, t % 60.0);
            format!("2026-03-{day:02}T{h:02}:{m:02}:{s:04.1}Z,{rest}\n")
        }
        _ => format!("{}\n", line.replace("time_s", "time").replace("t,sp", "time,sp")),
    };
    whole.lines().map(line).collect()
}

/// A recording whose first `operation` samples wander, then the OP goes to and fro about 50 % by `sizes`, each for twelve
/// samples of 2 s in manual; `pv` gets the OP and returns the PV, sample by sample.
fn by_hand(operation: usize, sizes: &[f64], middle: f64, pv: &dyn Fn(usize, f64) -> f64) -> String {
    let mut text = "time_s,OP,PV,mode\n".to_owned();
    let mut row = |k: usize, op: f64, mode: &str| {
        text += &format!("{},{op:.3},{:.4},{mode}\n", 2 * k, pv(k, op));
    };
    for k in 0..operation {
        row(k, middle + (k as f64 / 9.0).sin(), "AUTO");
    }
    for (turn, size) in sizes.iter().enumerate() {
        let op = middle + if turn % 2 == 0 { 0.5 * size } else { -0.5 * size };
        for k in 0..12 {
            row(operation + 12 * turn + k, op.clamp(0.0, 100.0), "MAN");
        }
    }
    for k in 0..20 {
        row(operation + 12 * sizes.len() + k, middle, "AUTO");
    }
    text
}

fn grow_and_shrink() -> Vec<f64> {
    (0..16).chain((0..16).rev()).map(|k| 0.4 * 1.23f64.powi(k)).collect()
}

#[test]
fn a_repair_is_shown_by_two_tests() {
    let folder = folder("test-before-after");
    let (before, after) = (sample("test/FIC107-tested.csv"), sample("test/FIC107-repaired.csv"));
    let words = run(&folder, &["test", "read", &after, "--before", &before]).quiet_success();
    let page = include_str!("../../../../docs/test.md");
    assert!(page.contains(&words), "docs/test.md must show: {words}");
    assert!(words.lines().all(|line| line.chars().count() <= 100), "{words}");
    let asked = ["test", "read", &*after, "--before", &*before];
    let json = run(&folder, &[&asked[..], &["--json"]].concat()).json();
    let of = |what: &str| &json["comparison"][what];
    assert_eq!(of("effect"), "lowered", "{json}");
    let s = json["before"]["test"]["S"]["low"].as_f64().unwrap();
    let below = json["after"]["test"]["S_below"].as_f64().unwrap();
    assert!((of("difference")["high"].as_f64().unwrap() - (below - s)).abs() < 1e-9, "{json}");
    assert!(of("difference")["value"].is_null());

    let more = ["--report", "repair.html", "--plot", "both.svg", "--fail"];
    run(&folder, &[&asked[..], &more].concat()).quiet_success();
    let html = read(&folder, "repair.html");
    for part in [
        "before and after a repair</h1>",
        "The repair lowered S from",
        "difference of S, with its 90 % interval",
        "The two tests, side by side.",
        "Both tests with the same axes.",
        "<h3>Before the repair</h3>",
        "<h3>After the repair</h3>",
        "signature",
        "prefers-color-scheme: dark",
        "size: A4 portrait",
    ] {
        assert!(html.contains(part), "{part}");
    }
    let fetched = ["src=\"", "href=\"http", "url(http", "@import"].map(|part| html.contains(part));
    assert!(!fetched.contains(&true), "the page needs no network");
    assert!(read(&folder, "both.svg").contains("before"));

    // The other way round S rises, and a valve that sticks fails.
    let back = run(&folder, &["test", "read", &before, "--before", &after, "--fail"]);
    assert!(back.code == 1 && back.out.contains("S rose by at least"), "{}", back.out);
    // With itself nothing changes.
    let same = run(&folder, &["test", "read", &before, "--before", &before]).quiet_success();
    assert!(same.contains("S did not change."), "{same}");

    // A test that was made later is not the one before.
    write(&folder, "FIC107.csv", dated(&before, 2));
    write(&folder, "FIC107-after.csv", dated(&after, 9));
    let right =
        ["test", "read", "FIC107-after.csv", "--before", "FIC107.csv", "--report", "r.html"];
    let words = run(&folder, &right).quiet_success();
    assert!(words.contains("2026-03-02") && words.contains("2026-03-09"), "{words}");
    assert!(read(&folder, "r.html").contains("before, 2026-03-02"));
    let wrong = ["test", "read", "FIC107.csv", "--before", "FIC107-after.csv"];
    refuses(&folder, &wrong, "exchange the two files");
    // Tags that differ are said.
    std::fs::copy(folder.join("FIC107.csv"), folder.join("FIC108.csv")).unwrap();
    let other = ["test", "read", "FIC107-after.csv", "--before", "FIC108.csv"];
    let words = run(&folder, &other).quiet_success();
    let tags = words.find("The recordings have different tags, FIC108 and FIC107-after.");
    let effect = words.find("The repair lowered S");
    assert!(tags.is_some() && tags < effect, "{words}");
}

#[test]
fn a_plan_stands_with_what_was_performed() {
    let folder = folder("test-carried");
    let tested = sample("test/FIC106-tested.csv");
    let whole = std::fs::read_to_string(&tested).unwrap();
    let operation: String = whole.lines().take(700).map(|line| format!("{line}\n")).collect();
    write(&folder, "FIC106.csv", operation);
    let plan = run(&folder, &["test", "plan", "FIC106.csv", "--json"]).quiet_success();
    write(&folder, "plan.json", plan);
    // The tag of the plan goes on with a word in the file's name.
    let asked = ["test", "read", &*tested, "--plan", "plan.json"];
    let words = run(&folder, &[&asked[..], &["--report", "test.html"]].concat()).quiet_success();
    assert!(words.contains("the test has 28 turns, and the plan has "), "{words}");
    assert!(words.contains("- The controller was in automatic once between turns.\n"), "{words}");
    let html = read(&folder, "test.html");
    for part in ["Test and plan: the test has 28 turns", "planned", "The turns, with", "its units"]
    {
        assert!(html.contains(part), "{part}");
    }
    let json = run(&folder, &[&asked[..], &["--json"]].concat()).json();
    let carried = &json["loops"][0]["test"]["plan"];
    assert_eq!(carried["turns"], 28);
    assert!(carried["sizes"].as_array().unwrap().iter().any(|size| size["part"] == 2));
    let none = run(&folder, &["test", "read", &tested, "--json"]).json();
    assert!(none["loops"][0]["test"]["plan"].is_null());
}

#[test]
fn what_spoils_a_test_is_reported() {
    let folder = folder("test-spoiled");
    let read_it = |name: &str| run(&folder, &["test", "read", name, "--rises"]);
    // A transmitter that never leaves its dead band.
    write(
        &folder,
        "FIC1.csv",
        by_hand(300, &grow_and_shrink(), 50.0, &|k, op| match k {
            0..300 => op,
            _ => 49.0,
        }),
    );
    let refused = read_it("FIC1.csv").refusal();
    assert!(
        refused.contains("FIC1.csv, loop FIC1: the PV has the same value throughout"),
        "{refused}"
    );
    // An OP that is cut at the end of its range.
    let noise = |k: usize| 0.05 * ((k * k * 7919) % 1000) as f64 / 1000.0;
    write(&folder, "FIC2.csv", by_hand(300, &grow_and_shrink(), 1.0, &|k, op| op + noise(k)));
    let words = read_it("FIC2.csv").quiet_success();
    assert!(words.contains("The OP was at 0 or 100 % in "), "{words}");
    // A PV without units breaks nothing.
    let page = ["test", "read", "FIC2.csv", "--rises", "--report", "page.html"];
    run(&folder, &page).quiet_success();
    assert!(read(&folder, "page.html").contains("(its units)"));
}
