//! `stiction history`.

use crate::diagnose::{violations, with_samples};
use crate::{folder, read, refuses, run, write};

/// A loop whose recorded valve position sticks with S = 4 % and then, repaired, with S = 0.5 %: hours of
/// 600 samples every 6 s from 2026-03-01 00:00 UTC.
fn repaired() -> String {
    let mut text = "timestamp,op,pv,vp\n".to_owned();
    let (mut op, mut vp, mut up) = (40.0_f64, 40.0_f64, true);
    for k in 0..12 * 600_u32 {
        let s = if k < 6 * 600 { 4.0 } else { 1.5 };
        op += if up { 0.4 } else { -0.4 };
        if (op - 50.0).abs() > 12.0 {
            up = op < 50.0;
        }
        let slip = op - vp;
        if slip.abs() > s / 2.0 {
            vp = op - slip.signum() * s / 2.0;
        }
        let second = k * 6;
        let (h, m, s) = (second / 3600, second / 60 % 60, second % 60);
        text += &format!("2026-03-01 {h:02}:{m:02}:{s:02},{op:.2},{:.2},{vp:.3}\n", 2.0 * vp);
    }
    text
}

#[test]
fn a_repair_is_seen_in_the_measured_position() {
    let folder = folder("history-repair");
    write(&folder, "FIC7.csv", repaired());
    let arguments = ["history", "FIC7.csv", "--window", "1h", "--repair", "2026-03-01T06:00"];
    let text = run(&folder, &arguments).quiet_success();
    assert!(text.starts_with("FIC7  FIC7.csv, 12 windows\n"), "{text}");
    assert!(text.contains("2026-03-01 06:00:00"), "{text}");
    assert!(
        text.contains("S fell from 3.9 to 1.5 %") && text.contains("6 of 6 windows since"),
        "{text}"
    );
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    let json = run(&folder, &[&arguments[..], &["--json"]].concat()).json();
    let valve = &json["valves"][0];
    assert_eq!(valve["windows"].as_array().map(Vec::len), Some(12));
    assert_eq!((&valve["repair"]["before"], &valve["repair"]["after"]), (&6.into(), &6.into()));
    let p = valve["repair"]["S"]["p_value"].as_f64().expect("a p-value");
    // Of C(12, 6) = 924 ways two are as extreme.
    assert!((p - 2.0 / 924.0).abs() < 1e-9, "{p}");
    // At another time there are too few before.
    let late = ["history", "FIC7.csv", "--window", "1h", "--repair", "2026-03-01T03:00"];
    let text = run(&folder, &[&late[..], &["--zone", "UTC"]].concat()).quiet_success();
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("there are 3 before and 9 after"), "{text}");
}

#[test]
fn files_that_overlap_with_different_values_are_noted() {
    let folder = folder("history-overlap");
    let text = repaired().replacen("op,pv,vp", "FIC7.OP,FIC7.PV,FIC7.VP", 1);
    let rows: Vec<&str> = text.lines().collect();
    let part = |from: usize, to: usize| [&rows[..1], &rows[from..to]].concat().join("\n") + "\n";
    write(&folder, "a.csv", part(1, 4000));
    write(&folder, "b.csv", part(3000, 7000));
    let other = rows[3602].replace("06:00:06", "06:00:00");
    write(&folder, "c.csv", part(3000, 7000).replace(rows[3601], &other));
    let arguments = |other| ["history", "a.csv", other, "--window", "1h"];
    assert_eq!(run(&folder, &arguments("b.csv")).err, "");
    let found = run(&folder, &arguments("c.csv"));
    assert_eq!(found.code, 0, "{}", found.err);
    let expected = "not parts of one recording: c.csv: overlaps a.csv";
    assert!(
        found.err.contains(expected) && found.err.contains("leave one file out"),
        "{}",
        found.err
    );
}

#[test]
fn json_is_as_the_schema_says() {
    let folder = with_samples("history-schema");
    let schema = run(&folder, &["schema", "history"]).json();
    let asked = ["history", "FIC101-sticky.csv", "--window", "5min", "--repair", "1200", "--json"];
    let json = run(&folder, &asked).json();
    assert!(!json["valves"][0]["repair"].is_null());
    assert_eq!(violations(&json, &schema, &schema, "history"), Vec::<String>::new());
}

#[test]
fn tables_and_reports_have_every_window() {
    let folder = with_samples("history-files");
    let arguments = ["history", "FIC101-sticky.csv", "FIC102-disturbed.csv", "--window", "10min"];
    let csv = run(&folder, &[&arguments[..], &["--csv", "-"]].concat()).quiet_success();
    assert_eq!(csv.lines().count(), 1 + 4 + 4, "{csv}");
    let done = run(&folder, &[&arguments[..], &["--report", "h.html"]].concat());
    assert_eq!(done.code, 0, "{}", done.err);
    assert!(read(&folder, "h.html").contains("History of 2 valves"));
    // Without --window a short recording stays whole.
    let text = run(&folder, &["history", "FIC101-sticky.csv"]).quiet_success();
    assert!(text.contains("1 window") && text.contains("together  STICKS"), "{text}");
}

#[test]
fn invalid_requests_are_refused() {
    let folder = with_samples("history-refused");
    std::fs::create_dir_all(folder.join("later")).expect("a folder");
    std::fs::copy(folder.join("FIC101-sticky.csv"), folder.join("later/FIC101-sticky.csv"))
        .expect("a copy");
    for (arguments, expected) in [
        (&["history"][..], "required"),
        (&["history", "missing.csv"], "missing.csv"),
        (&["history", "FIC101-sticky.csv", "--window", "often"], "such as 8h"),
        (&["history", "FIC101-sticky.csv", "--window", "0"], "such as 8h"),
        (&["history", "FIC101-sticky.csv", "--repair", "noon"], "has no dates; give the time in s"),
        (&["history", "FIC101-sticky.csv", "--loop", "X"], "no such loop"),
        (
            &["history", "FIC101-sticky.csv", "later/FIC101-sticky.csv"],
            "is in 2 files, and some of the files have no dates",
        ),
    ] {
        refuses(&folder, arguments, expected);
    }
    write(&folder, "FIC7.csv", repaired());
    let refused = run(&folder, &["history", "FIC7.csv", "--repair", "noon"]).refusal();
    assert!(refused.contains("--repair: \"noon\" is not a date and time such as"), "{refused}");
}

#[test]
fn a_valve_that_changed_is_judged_by_what_came_after() {
    let folder = folder("history-change");
    let columns = ["--columns", "t,sp,pv,op", "--set", "duration=14000"];
    let simulate = |more: &[&str]| {
        let scenario = ["simulate", "samples/sticky-flow"];
        run(&folder, &[&scenario[..], &columns, more].concat()).quiet_success();
    };
    simulate(&["-o", "sticks.csv"]);
    let repaired = ["--set", "valve.S=0.4", "--set", "valve.J=0.1", "--set", "noise.seed=3"];
    simulate(&[&repaired[..], &["-o", "repaired.csv"]].concat());
    for (files, change, sticks) in [
        (["sticks.csv", "repaired.csv"], "gone", false),
        (["repaired.csv", "sticks.csv"], "new", true),
    ] {
        let asked = [&["diagnose"], &files[..], &["--join", "--json"]].concat();
        let found = run(&folder, &asked).json()["loops"][0].clone();
        assert_eq!(found["verdict"]["class"] == "sticks", sticks, "{found}");
        let changes = found["evidence"]["changes"].as_array().unwrap();
        assert!(changes.len() == 1 && changes[0]["change"] == change, "{changes:?}");
        // A window has 1,500 s.
        let off = changes[0]["time_s"].as_f64().unwrap() - 14_000.0;
        assert!(off.abs() <= 1500.0, "{changes:?}");
        let text = run(&folder, &[&["diagnose"], &files[..], &["--join"]].concat());
        let text = text.quiet_success().split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("Only the windows since then count."), "{text}");
        let asked = [&["history"], &files[..], &["--join", "--window", "25min"]].concat();
        let text = run(&folder, &asked).quiet_success();
        assert!(text.contains("windows since the change count"), "{text}");
        assert!(text.contains("\nchange    The valve "), "{text}");
    }
}
