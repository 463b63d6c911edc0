//! `stiction test`.

use crate::{folder, read, run, write};
use std::path::Path;

/// A path of the project, from the folder of a test.
fn sample(name: &str) -> String {
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
    for part in ["Put the controller in manual", "The PV rises when the OP rises", "u0 + 0.2"] {
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
        ("turn,op\n1,40\n", "done.csv: there is no column \"time\""),
        ("time,op\nten,40\n", "done.csv, row 2, column time: \"ten\" is no number of seconds"),
        ("time,op\n10,140\n", "done.csv, row 2, column op: \"140\" is no OP in percent"),
        ("time,op\n10,40\n9,41\n", "done.csv, row 3, column time: \"9\" is before the row above"),
        ("time,op\n,40\n", "done.csv, row 2, column time: \"\" is no time"),
        ("time,op\n", "done.csv: no row has a time"),
        ("time,op\n900000,40\n900010,41\n900020,\n", "the test lies outside the samples"),
    ] {
        write(&folder, "done.csv", sheet);
        let refused =
            run(&folder, &["test", "read", "FIC106-tested.csv", "--done", "done.csv"]).refusal();
        assert!(refused.contains(expected), "{expected}: {refused}");
    }
}

#[test]
fn what_cannot_be_planned_or_read_is_said() {
    let folder = folder("test-refused");
    let refused = run(&folder, &["test", "read", &sample("FIC101-sticky.csv")]).refusal();
    assert!(refused.contains("there is no test in the recording"), "{refused}");
    let still: String = (0..400).map(|k| format!("{k},50,{}\n", k % 3)).collect();
    write(&folder, "FIC1.csv", format!("t,op,pv\n{still}"));
    let refused = run(&folder, &["test", "plan", "FIC1.csv"]).refusal();
    assert!(refused.contains("the OP or the PV does not move"), "{refused}");
    let plan = run(&folder, &["test", "plan", &sample("FIC101-sticky.csv"), "--json"]);
    write(&folder, "plan.json", plan.quiet_success());
    let tested = sample("test/FIC106-tested.csv");
    let refused = run(&folder, &["test", "read", &tested, "--plan", "plan.json"]).refusal();
    assert!(refused.contains("the plan is for loop FIC101-sticky"), "{refused}");
    write(&folder, "plan.json", "{}");
    let refused = run(&folder, &["test", "read", &tested, "--plan", "plan.json"]).refusal();
    assert!(refused.contains("there is no key \"plan\""), "{refused}");
    let limits = ["test", "plan", &sample("FIC101-sticky.csv"), "--pv-low", "9", "--pv-high", "3"];
    let refused = run(&folder, &limits).refusal();
    assert!(refused.contains("lower limit is not below"), "{refused}");
    // A recording that holds a test says so.
    let words = run(&folder, &["diagnose", &tested, "--json"]).json();
    let notes = words["loops"][0]["notes"].to_string();
    assert!(notes.contains("a test of the valve is in this recording"), "{notes}");
}
