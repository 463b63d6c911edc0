//! `stiction what-if`.

use crate::{assert_near, column, folder, no_loop_is_refused, paper, read, refuses, rows, run};

#[test]
fn the_papers_loop_in_words() {
    let folder = folder("what-if");
    let out = run(&folder, &paper("what-if", &["--plot", "actions.svg"])).quiet_success();
    let table = "\
The paper's loop under strong stiction (Figures 13 to 15)

action                  error  worst  PV std  OP %/min  stem %/min  rev./h  SP s  load s  cycle s
modified-two-move       0.057  0.057       0         0           0       0  41.9    66.4        ?
valve repaired          0.061  0.061   0.068      1.95       0.684     229  8.70    8.20     29.0
";
    assert!(out.starts_with(table), "{out}");
    // The page shows the whole of it.
    let page = include_str!("../../../../docs/compensation.md");
    let whole = out.split("\n\n").nth(1).expect("the table");
    assert!(page.contains(whole), "docs/compensation.md must show: {whole}");
    for part in [
        "\nWhat to do\n- The present loop cycles every 18 s",
        "- Repair the valve to remove the cause.",
        "- Until then, leave the loop as it is. None of the simulated tunings",
        "\nTest in manual before the action\n",
        "- Part 1. Move the OP up to u0 + 0.2 %. The PV rises when the OP rises.",
        "\nAssumptions\n- The valve model is two-phase with S = 5 % and J = 3 %",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
    assert!(out.lines().all(|line| line.chars().count() <= 100), "{out}");
    let svg = read(&folder, "actions.svg");
    for part in ["valve repaired", "six-move", "stem travel"] {
        assert!(svg.contains(part), "{part}");
    }
}

/// The exact cycle would be followed for hours.
#[test]
fn times_that_no_sample_shows_are_refused_at_once() {
    let folder = folder("what-if-absurd");
    for (set, expected) in [
        ("process.tau=1e-300", "the shortest time constant of the process is 1e-300 s"),
        ("process.tau=1e-9", "the shortest time constant of the process is 1e-9 s"),
        ("process.delay=1e-300", "the dead time is 1e-300 s"),
        ("process.delay=1e-5", "the dead time is 1e-5 s"),
        ("controller.ti=1e12", "the integral time is "),
    ] {
        let began = std::time::Instant::now();
        let refused = run(&folder, &["what-if", "paper/closed-loop", "--set", set]).refusal();
        assert!(refused.contains(expected), "{refused}");
        assert!(
            refused.contains("times the sample time of 0.01 s, but must be between"),
            "{refused}"
        );
        assert!(refused.contains("change one of the two times"), "{refused}");
        assert!(began.elapsed().as_secs() < 10, "{set}");
    }
    run(&folder, &paper("what-if", &["--set", "process.delay=0"]));
}

#[test]
fn the_papers_loop_as_json_and_csv() {
    let folder = folder("what-if-json");
    let json = run(&folder, &paper("what-if", &["--json"])).json();
    assert_eq!(json["scenario"], "paper/closed-loop");
    assert_eq!(json["valve"]["model"], "two-phase");
    assert_eq!(json["interim"], serde_json::Value::Null);
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
    assert_near(&json["confirm"]["grow"][0]["op"], 0.2, 0.0);
    assert_eq!(json["confirm"]["rises"], true);

    let csv = run(&folder, &paper("what-if", &["--csv", "-"])).quiet_success();
    assert_eq!(rows(&csv).1.len(), 13 * 6);
    let errors = column(&csv, "iae_per_s");
    // A table has three digits.
    assert_near(&actions[0]["cases"][0]["iae_per_s"], errors[0], 1e-4);
}

#[test]
fn options_change_what_is_assumed() {
    let folder = folder("what-if-options");
    let options =
        ["--repaired-S", "2", "--repaired-J", "1", "--positioner-gain", "1", "--ms", "1.5"];
    let out = run(&folder, &paper("what-if", &options)).quiet_success();
    let words = out.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "A repaired valve has S = 2 % and J = 1 %. A retuned loop has Ms up to 1.5.",
        "The positioner is proportional, with a gain of 1, ",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(!words.contains("Do not rely on the positioner"), "1 x 3 is below 5");
    // Dead band alone does not cycle here.
    let out = run(&folder, &paper("what-if", &["--set", "valve.J=0"])).quiet_success();
    assert!(out.contains("The present loop has no limit cycle (decays"), "{out}");
    let out = run(&folder, &paper("what-if", &["--set", "valve.S=0", "--set", "valve.J=0"]));
    assert!(out.quiet_success().contains("- The valve does not stick"));
}

#[test]
fn invalid_requests_are_refused() {
    let folder = folder("what-if-refused");
    no_loop_is_refused(&folder, "what-if");
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
}
