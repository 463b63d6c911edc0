//! `stiction what-if` and `stiction compensate`.

use crate::{column, folder, read, rows, run, write};
use std::path::Path;

/// The paper's loop at a sample time of 0.1 s.
fn paper<'a>(command: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[command, "paper/closed-loop", "--set", "sample_time=0.1"], more].concat()
}

#[track_caller]
fn assert_near(found: &serde_json::Value, expected: f64, tolerance: f64) {
    let found = found.as_f64().expect("a number");
    assert!((found - expected).abs() <= tolerance, "{found}, but expected {expected}");
}

#[test]
fn the_papers_loop_in_words() {
    let folder = folder("what-if");
    let out = run(&folder, &paper("what-if", &["--plot", "actions.svg"])).quiet_success();
    let table = "\
The paper's loop under strong stiction (Figures 13 to 15)

action                  error  worst  PV std  OP %/min  stem %/min  turns/h  SP s  load s  cycle s
modified-two-move       0.057  0.057       0         0           0        0  41.9    66.4        ?
valve repaired          0.061  0.061   0.068      1.95       0.684      229  8.70    8.20     29.0
";
    assert!(out.starts_with(table), "{out}");
    // The page shows the whole of it.
    let page = include_str!("../../../../docs/compensation.md");
    let whole = out.split("\n\n").nth(1).expect("the table");
    assert!(page.contains(whole), "docs/compensation.md must show: {whole}");
    for part in [
        "\nWhat to do\n- As it is, the loop cycles every 18 s",
        "- Repair the valve: that removes the cause.",
        "- Until then, compensate it (modified-two-move:",
        "\nThe test in manual that confirms it first\n",
        "- Move the output up in 6 steps of 1.5 %, waiting 20 s after each.",
        "\nWhat this rests on\n- The valve is two-phase with S = 5 % and J = 3 %",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
    assert!(out.lines().all(|line| line.chars().count() <= 100), "{out}");
    let svg = read(&folder, "actions.svg");
    for part in ["valve repaired", "six-move", "stem travel"] {
        assert!(svg.contains(part), "{part}");
    }
}

#[test]
fn the_papers_loop_as_json_and_csv() {
    let folder = folder("what-if-json");
    let json = run(&folder, &paper("what-if", &["--json"])).json();
    assert_eq!(json["scenario"], "paper/closed-loop");
    assert_eq!(json["valve"]["model"], "two-phase");
    assert_eq!(json["interim"], "modified-two-move");
    let actions = json["actions"].as_array().expect("a list");
    assert_eq!(actions.len(), 13);
    let worst = |k: usize| actions[k]["worst_iae_per_s"].as_f64().expect("a number");
    for (k, action) in actions.iter().enumerate() {
        assert_eq!(action["rank"], k + 1);
        assert_eq!(action["cases"].as_array().expect("a list").len(), 6);
        assert!(k == 0 || worst(k - 1) <= worst(k));
    }
    let now = actions.iter().find(|action| action["action"] == "as it is").expect("it");
    assert_near(&now["cycle"]["period_s"], 18.04367, 1e-5);
    assert_near(&now["cycle"]["half_pp"]["op"], 3.108014, 1e-6);
    assert_near(&json["confirm"]["step"], 1.5, 0.0);
    assert_eq!(json["confirm"]["direction"], "up");

    let csv = run(&folder, &paper("what-if", &["--csv", "-"])).quiet_success();
    assert_eq!(rows(&csv).1.len(), 13 * 6);
    let errors = column(&csv, "iae_per_s");
    assert_near(&actions[0]["cases"][0]["iae_per_s"], errors[0], 0.0);
}

#[test]
fn options_change_what_is_assumed() {
    let folder = folder("what-if-options");
    let options =
        ["--repaired-S", "2", "--repaired-J", "1", "--positioner-gain", "1", "--ms", "1.5"];
    let out = run(&folder, &paper("what-if", &options)).quiet_success();
    let words = out.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "A repaired valve keeps S = 2 % and J = 1 %; a retuned loop keeps Ms within 1.5.",
        "The positioner is proportional with a gain of 1 ",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(!words.contains("Do not count on the positioner"), "1 x 3 is below 5");
    // Dead band alone does not cycle here.
    let out = run(&folder, &paper("what-if", &["--set", "valve.J=0"])).quiet_success();
    assert!(out.contains("the loop has no limit cycle of its own (decays"), "{out}");
    let out = run(&folder, &paper("what-if", &["--set", "valve.S=0", "--set", "valve.J=0"]));
    assert!(out.quiet_success().contains("- The valve does not stick"));
}

#[test]
fn all_compensators_or_one() {
    let folder = folder("compensate");
    let list = run(&folder, &["compensate", "--list"]).quiet_success();
    assert_eq!(list.lines().count(), 18);
    let all = run(&folder, &paper("compensate", &["--plot", "all.svg"])).quiet_success();
    assert!(all.contains("\nas it is                 1.10   1.10    1.25"), "{all}");
    assert_eq!(all.lines().skip(3).take_while(|line| !line.is_empty()).count(), 10);
    assert!(!read(&folder, "all.svg").contains("valve repaired"));

    let one = ["--method", "knocker", "--S", "4", "--J", "2", "--at", "100", "--plot", "one.svg"];
    let out = run(&folder, &paper("compensate", &one)).quiet_success();
    assert!(out.contains("\nknocker ") && out.contains("Chosen for S = 4.00 %, J"), "{out}");
    assert!(out.contains("\nParameters\n  amplitude "), "{out}");
    let svg = read(&folder, "one.svg");
    assert!(svg.contains("compensator on") && svg.contains("what the valve receives"));

    let mut json = one.to_vec();
    json.truncate(8);
    json.push("--json");
    let json = run(&folder, &paper("compensate", &json)).json();
    assert_near(&json["assumed"]["S"], 4.0, 0.0);
    assert_near(&json["protocol"]["on_s"], 100.0, 0.0);
    assert_eq!(json["methods"].as_array().expect("a list").len(), 2);
    let csv = run(&folder, &paper("compensate", &["--method", "two-move", "--csv", "-"]));
    assert_eq!(rows(&csv.quiet_success()).1.len(), 2 * 6);
}

/// Runs the command, which must refuse with a message that contains `expected`.
#[track_caller]
fn refuses(folder: &Path, arguments: &[&str], expected: &str) {
    let err = run(folder, arguments).refusal();
    assert!(err.contains(expected), "{arguments:?} must say \"{expected}\", but says: {err}");
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let folder = folder("what-if-refused");
    write(&folder, "bad.toml", "sample_time = 0.1\nduration = 10\n[valve]\nS = -5\nJ = 3\n");
    for command in ["what-if", "compensate"] {
        for (scenario, expected) in [
            ("paper/flow-cascade", "is a cascade, and this command asks about a single loop"),
            ("paper/step-linear", "is a valve on a test signal"),
            ("no-such", "no-such"),
            ("bad.toml", "bad.toml"),
        ] {
            refuses(&folder, &[command, scenario], expected);
        }
        refuses(&folder, &paper(command, &["--set", "valve.S=-1"]), "S");
        refuses(&folder, &paper(command, &["--set", "controller.kc=60"]), "grow");
        refuses(&folder, &paper(command, &["--plot", "a.pdf"]), ".svg or .png");
        refuses(&folder, &paper(command, &["--json", "--csv", "-"]), "cannot be used with");
        refuses(&folder, &[command], "required");
    }
    for (option, value, expected) in [
        ("--ms", "1", "--ms is 1, but must be a finite number above 1"),
        ("--ms", "nan", "--ms is NaN"),
        ("--repaired-S", "-1", "S"),
        ("--repaired-J", "inf", "J"),
        ("--positioner-gain", "-2", "gain of the positioner"),
        ("--positioner-gain", "much", "invalid value"),
    ] {
        refuses(&folder, &paper("what-if", &[option, value]), expected);
    }
    for (option, value, expected) in [
        ("--method", "nonesuch", "there is no compensator named \"nonesuch\"; known are knocker"),
        ("--S", "-1", "S"),
        ("--J", "nan", "J"),
        ("--at", "-5", "time before the compensator is on"),
        ("--at", "1e12", "samples"),
    ] {
        refuses(&folder, &paper("compensate", &[option, value]), expected);
    }
}
