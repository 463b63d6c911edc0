//! The room of a plant, over HTTP, on a small plant of which all is known.

use super::Open;
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use stiction_lab::Options;
use stiction_plant::log::{Kind, Log};
use stiction_plant::orders::orders;
use stiction_plant::plant_file::Plant;
use stiction_plant::report::Known;
use stiction_plant::{ScanOptions, Store, WindowRow, demo, scan};

fn open(plant: Option<&Path>) -> Open {
    super::open(&Options { plant: plant.map(Path::to_path_buf), ..Options::new("test") })
}

impl Open {
    /// Waits until no scan runs, and gives how it ended, and how far it was seen to be.
    fn scanned(&self) -> (Value, Vec<u64>) {
        let end = Instant::now() + Duration::from_secs(120);
        let mut seen = vec![];
        loop {
            let scan = self.good("plant/status", &json!({}))["scan"].clone();
            seen.extend(scan["done"].as_u64());
            if scan["running"] == false {
                return (scan, seen);
            }
            assert!(Instant::now() < end, "{scan}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// A plant of six loops and two days, not scanned.
fn plant(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("lab-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    demo::write(&folder, 6, 2, 1, || {}).unwrap();
    folder
}

/// The demo plant, its windows judged, and their rows.
fn scanned(name: &str) -> (PathBuf, Vec<WindowRow>) {
    let folder = plant(name);
    let of = Plant::read(&folder).unwrap();
    scan(&folder, &of, &ScanOptions::default(), |_| ControlFlow::Continue(())).unwrap();
    let rows = Store::of(&folder).rows().unwrap();
    (folder, rows)
}

#[test]
fn without_a_plant_the_room_says_so() {
    let lab = open(None);
    let now = lab.good("plant/status", &json!({}));
    assert_eq!((&now["folder"], &now["weeks"]), (&Value::Null, &json!([])));
    let (status, answer) = lab.call("plant/page", &json!({}));
    assert_eq!(status, 404);
    assert!(answer["error"].as_str().unwrap().contains("stiction lab --plant DIR"), "{answer}");
}

#[test]
fn the_last_events_of_a_watch_are_shown_the_newest_first() {
    let folder = plant("events");
    let lab = open(Some(&folder));
    assert_eq!(lab.good("plant/status", &json!({}))["events"], json!([]));
    let line = |k: usize| {
        let text = format!("L{k}: the valve sticks");
        json!({ "event": "new sticking", "loop": format!("L{k}"), "at": "2026-03-04T05:10:00+00:00", "text": text, "more": k })
    };
    let mut lines: String = (0..2000).map(|k| format!("{}\n", line(k))).collect();
    lines += "{\"event\": \"cut in the mid";
    std::fs::create_dir_all(folder.join(".stiction")).unwrap();
    std::fs::write(folder.join(".stiction/events.jsonl"), lines).unwrap();
    let events = lab.good("plant/status", &json!({}))["events"].clone();
    let names: Vec<&str> =
        events.as_array().unwrap().iter().map(|event| event["loop"].as_str().unwrap()).collect();
    assert_eq!((names.len(), names[0], names[19]), (20, "L1999", "L1980"));
}

#[test]
fn a_week_is_what_the_report_of_it_says() {
    let (folder, _) = scanned("week");
    let lab = open(Some(&folder));
    let now = lab.good("plant/status", &json!({}));
    assert_eq!(now["weeks"], json!(["2026-W10"]));
    let of = Plant::read(&folder).unwrap();
    let known = Known::of(&folder, &of, None).unwrap();
    let ranking = known.ranking(&of);
    let page = {
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            let page = lab.good("plant/page", &json!({}));
            if !page["groups"].is_null() {
                break page;
            }
            assert!(Instant::now() < end, "groups are not found");
        }
    };
    assert_eq!(page["groups"], serde_json::to_value(&known.groups).unwrap());
    assert_eq!(page["orders"], serde_json::to_value(orders(&ranking)).unwrap());
    let rows: Vec<Value> =
        ranking.loops.iter().map(|ranked| serde_json::to_value(&ranked.row).unwrap()).collect();
    assert_eq!(page["loops"], Value::Array(rows));
    let tiles: usize = page["maps"][0]["areas"]
        .as_array()
        .unwrap()
        .iter()
        .map(|area| area["loops"].as_array().unwrap().len())
        .sum();
    assert_eq!(tiles, ranking.loops.len());
    assert_eq!(lab.good("plant/page", &json!({ "week": "2026-W10" })), page);
    let (status, answer) = lab.call("plant/page", &json!({ "week": "2020-W01" }));
    assert_eq!(status, 400, "{answer}");

    // A loop over time: the rows of the store.
    for ranked in &ranking.loops {
        let own = lab.good("plant/loop", &json!({ "loop": ranked.row.name.to_lowercase() }));
        let kept: Vec<Value> =
            ranked.windows.iter().map(|row| serde_json::to_value(row).unwrap()).collect();
        let told: Vec<Value> =
            own["windows"].as_array().unwrap().iter().map(|w| w["row"].clone()).collect();
        assert_eq!(told, kept);
    }
}

#[test]
fn the_trend_and_the_verdict_of_a_day_are_those_of_its_files() {
    let (folder, rows) = scanned("trend");
    let lab = open(Some(&folder));
    let row = rows.iter().find(|row| row.probability.is_some()).unwrap();
    let of = Plant::read(&folder).unwrap();
    let recording =
        stiction_plant::scan::recordings_of(&folder, &of, &[row]).pop().unwrap().unwrap();
    let ask = json!({ "loop": row.name, "day": "2026-03-02", "days": 1 });
    let trend = lab.good("plant/trend", &ask);
    let (pv, all) = (&trend["pv"], recording.pv.as_ref().unwrap());
    assert_eq!(pv["samples"], all.values.len());
    let shown: Vec<f64> =
        pv["value"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    assert!(shown.len() <= 4002 && trend.to_string().len() < 400_000);
    let most = |of: &[f64]| of.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!((most(&shown) - most(&all.values)).abs() < 1e-4 * most(&all.values).abs());
    // A part of it, sample by sample.
    let part =
        json!({ "loop": row.name, "day": "2026-03-02", "days": 1, "from_s": 3600, "to_s": 7200 });
    let part = lab.good("plant/trend", &part);
    let within = all.time.iter().filter(|t| (3600.0..=7200.0).contains(*t)).count();
    assert_eq!(
        (part["pv"]["samples"].as_u64(), &part["pv"]["thinned"]),
        (Some(within as u64), &json!(false))
    );

    let found = lab.good("plant/diagnose", &ask);
    assert_eq!(found["judgement"]["diagnosis"]["verdict"]["grade"], row.grade.clone().unwrap());
    assert_eq!(found["judgement"]["diagnosis"]["verdict"]["probability"].as_f64(), row.probability);
    assert!(!found["judgement"]["sentence"].as_str().unwrap().is_empty());
    for (wrong, expected) in [
        (json!({ "loop": "nobody", "day": "2026-03-02", "days": 1 }), 404),
        (json!({ "loop": row.name, "day": "2031-03-02", "days": 1 }), 404),
        (json!({ "loop": row.name, "day": "2026-03-02", "days": 400 }), 400),
        (json!({ "loop": row.name, "day": "2026-03-02", "days": 1, "from_s": 9, "to_s": 3 }), 400),
    ] {
        let (status, answer) = lab.call("plant/trend", &wrong);
        assert_eq!(status, expected, "{wrong}: {answer}");
    }
}

#[test]
fn what_is_entered_is_written_as_the_command_writes_it() {
    let (folder, rows) = scanned("entered");
    let lab = open(Some(&folder));
    let name = &rows[0].name;
    let by_hand = "# By hand.\n";
    std::fs::write(folder.join("log.toml"), by_hand).unwrap();
    let repair = json!({ "loop": name.to_lowercase(), "kind": "repair", "text": "new \"packing\"", "by": "J. Miller", "day": "2026-03-03" });
    let said = lab.good("plant/note", &repair);
    assert_eq!(said["words"], "repaired: new \"packing\" (J. Miller, 2026-03-03)");
    lab.good("plant/snooze", &json!({ "loop": name, "until": "2099-01-01", "text": "WO 4711" }));
    let conclusion = json!({ "loop": name, "verdict": "does not stick", "reason": "stroked" });
    lab.good("plant/override", &conclusion);
    let text = std::fs::read_to_string(folder.join("log.toml")).unwrap();
    assert!(text.starts_with(by_hand), "{text}");
    let expected = format!(
        "[[entry]]\nkind = \"repair\"\nloop = \"{name}\"\nday = 2026-03-03\nby = \"J. Miller\"\ntext = 'new \"packing\"'\n"
    );
    assert!(text.contains(&expected), "{text}");
    let log = Log::read(&folder).unwrap();
    let kinds: Vec<Kind> = log.entries.iter().map(|entry| entry.kind).collect();
    assert_eq!(kinds, [Kind::Repair, Kind::Snooze, Kind::Override]);
    // The next question sees it.
    let page = lab.good("plant/page", &json!({}));
    let own = page["loops"].as_array().unwrap().iter().find(|row| row["loop"] == **name).unwrap();
    assert_eq!(own["snoozed_until"], "2099-01-01");
    assert_eq!(own["override"], "does not stick");
    for (call, wrong) in [
        ("plant/note", json!({ "loop": name, "kind": "note", "text": " " })),
        ("plant/note", json!({ "loop": name, "kind": "snooze", "text": "x" })),
        ("plant/note", json!({ "loop": name, "kind": "note", "text": "x".repeat(5000) })),
        ("plant/snooze", json!({ "loop": name, "until": "1999-01-01" })),
        ("plant/snooze", json!({ "loop": name, "until": "soon" })),
        ("plant/override", json!({ "loop": name, "verdict": "wobbles", "reason": "x" })),
        ("plant/override", json!({ "loop": "nobody", "verdict": "sticks", "reason": "x" })),
    ] {
        let (status, answer) = lab.call(call, &wrong);
        assert_eq!(status, 400, "{call} {wrong}: {answer}");
    }
    assert_eq!(Log::read(&folder).unwrap(), log, "what was refused is not kept");
}

#[test]
fn two_windows_and_the_command_at_once_lose_nothing() {
    let (folder, rows) = scanned("at-once");
    let (one, two) = (open(Some(&folder)), open(Some(&folder)));
    let name = rows[0].name.clone();
    std::thread::scope(|threads| {
        for (who, lab) in [("a", &one), ("b", &one), ("c", &two)] {
            let name = &name;
            threads.spawn(move || {
                for k in 0..20 {
                    let text = format!("{who} {k}");
                    lab.good("plant/note", &json!({ "loop": name, "kind": "note", "text": text }));
                }
            });
        }
        for k in 0..20 {
            let entry = stiction_plant::log::Entry {
                kind: Kind::Note,
                name: name.clone(),
                day: demo::FIRST_DAY,
                by: None,
                until: None,
                verdict: None,
                text: format!("command {k}"),
            };
            stiction_plant::log::enter(&folder, &entry).unwrap();
        }
    });
    let mut texts: Vec<String> =
        Log::read(&folder).unwrap().entries.into_iter().map(|entry| entry.text).collect();
    let mut expected: Vec<String> = ["a", "b", "c", "command"]
        .iter()
        .flat_map(|who| (0..20).map(move |k| format!("{who} {k}")))
        .collect();
    texts.sort();
    expected.sort();
    assert_eq!(texts, expected);
}

#[test]
fn a_scan_of_the_lab_ends_with_the_rows_of_the_command() {
    let (folder, (_, by_command)) = (plant("scan"), scanned("scanned"));
    let lab = open(Some(&folder));
    assert_eq!(lab.good("plant/status", &json!({}))["weeks"], json!([]));
    let (status, answer) = lab.call("plant/page", &json!({}));
    assert_eq!(status, 400, "{answer}");
    lab.good("plant/scan", &json!({}));
    let (status, answer) = lab.call("plant/scan", &json!({}));
    assert_eq!(status, 400, "one at a time: {answer}");
    let (scan, seen) = lab.scanned();
    assert_eq!(scan["failed"], Value::Null);
    assert_eq!(scan["ended"]["windows"], 12);
    assert!(seen.is_sorted(), "{seen:?}");
    let told = |rows: &[WindowRow]| serde_json::to_value(rows).unwrap();
    assert_eq!(told(&Store::of(&folder).rows().unwrap()), told(&by_command));
    assert_eq!(lab.good("plant/page", &json!({}))["loops"].as_array().unwrap().len(), 6);
    // Nothing is new then.
    lab.good("plant/scan", &json!({}));
    assert_eq!(lab.scanned().0["ended"]["windows"], 0);
    // Another scan of the plant is respected, and told.
    let run = Store::of(&folder).begin().unwrap();
    lab.good("plant/scan", &json!({ "again": true }));
    let failed = lab.scanned().0["failed"].clone();
    assert!(failed.as_str().unwrap().contains("another scan"), "{failed}");
    drop(run);
    // One that is told to stop does, and what it left is judged by the next.
    lab.good("plant/scan", &json!({ "again": true }));
    lab.good("plant/stop", &json!({}));
    lab.scanned();
    assert_eq!(told(&Store::of(&folder).rows().unwrap()), told(&by_command));
}
