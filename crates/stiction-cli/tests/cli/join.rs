//! Recordings of one loop in several files.

use crate::{Done, folder, refuses, rows, run, write};
use std::path::Path;

/// A day, or less, of a loop whose valve follows, sampled every 10 s from second `from` of 2026-03-01.
fn recorded(header: &str, from: u32, count: u32, dated: bool) -> String {
    let mut text = format!("{header}\n");
    for k in 0..count {
        let second = from + k * 10;
        let op = 50.0 + 8.0 * (f64::from(second) / 300.0).sin();
        let time = if dated {
            let (day, of_day) = (1 + second / 86_400, second % 86_400);
            let (h, m, s) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
            format!("2026-03-{day:02} {h:02}:{m:02}:{s:02}")
        } else {
            second.to_string()
        };
        text += &format!("{time},{:.3},{op:.3},50\n", 2.0 * op + 1.0);
    }
    text
}

const TAGGED: &str = "Time,FIC101.PV,FIC101.OP,FIC101.SP";
const PLAIN: &str = "t,pv,op,sp";

/// The table of loops, and what was said beside it.
fn table(folder: &Path, arguments: &[&str]) -> (Vec<String>, String) {
    let Done { code, out, err } = run(folder, &[&["diagnose", "--csv", "-"], arguments].concat());
    assert_eq!(code, 0, "{err}");
    let (header, rows) = rows(&out);
    let place = |name| header.iter().position(|each| *each == name).expect("a column");
    let (tag, file) = (place("loop"), place("file"));
    (rows.iter().map(|row| format!("{} in {}", row[tag], row[file])).collect(), err)
}

#[test]
fn files_of_one_tag_are_one_row() {
    let folder = folder("join-tags");
    let names: Vec<String> = (1..=7).map(|day| format!("day{day}.csv")).collect();
    for (name, k) in names.iter().zip(0..) {
        write(&folder, name, recorded(TAGGED, k * 3600, 360, true));
    }
    let files: Vec<&str> = names.iter().map(String::as_str).collect();
    let (found, err) = table(&folder, &files);
    assert_eq!((found, err.as_str()), (vec!["FIC101 in day1.csv and 6 more".to_owned()], ""));
    let text = run(&folder, &[&["diagnose"], &files[..]].concat()).quiet_success();
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("joined from 7 files, \"day1.csv\", \"day2.csv\""), "{text}");
    // The order in which they are given does not matter, nor does a file that is given twice.
    let turned: Vec<&str> = files.iter().rev().copied().chain(["day3.csv"]).collect();
    let json = |files: &[&str]| run(&folder, &[&["diagnose", "--json"], files].concat()).json();
    let (whole, again) = (json(&files), json(&turned));
    let judged = |json: &serde_json::Value| json["loops"][0]["judged"].clone();
    assert_eq!(judged(&whole)["samples"], 7 * 360);
    assert_eq!(judged(&whole), judged(&again));
    // What a person said of one file is not said of all, and not lost.
    let said = ["override", "day2.csv", "--loop", "FIC101", "--verdict", "sticks", "--reason", "x"];
    run(&folder, &said).quiet_success();
    let notes = json(&files)["loops"][0]["notes"].to_string();
    assert!(notes.contains("states that the valve sticks, but only for day2.csv"), "{notes}");
    // Without the third file there is a gap.
    let gap: Vec<&str> = files.iter().filter(|file| **file != "day3.csv").copied().collect();
    assert_eq!(judged(&json(&gap))["segments"], 2);
}

#[test]
fn files_of_one_tag_that_contradict_stay_apart() {
    let folder = folder("join-apart");
    write(&folder, "a.csv", recorded(TAGGED, 0, 360, true));
    let other = recorded(TAGGED, 1800, 360, true).replace(",50\n", ",51\n");
    write(&folder, "b.csv", other);
    let (found, err) = table(&folder, &["a.csv", "b.csv"]);
    assert_eq!(found.len(), 2, "{found:?}");
    let expected = "FIC101 is in 2 files and judged in each separately: b.csv: overlaps a.csv with different values \
                    of the SP";
    assert!(err.contains(expected), "{err}");
    write(&folder, "c.csv", recorded(TAGGED, 0, 360, false));
    write(&folder, "d.csv", recorded(TAGGED, 0, 360, false));
    let (found, err) = table(&folder, &["c.csv", "d.csv"]);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        err.contains("the files have no dates; if they follow each other in time, give --join"),
        "{err}"
    );
}

#[test]
fn files_without_tags_are_joined_where_the_user_says_so() {
    let folder = folder("join-plain");
    write(&folder, "FIC101-january.csv", recorded(PLAIN, 0, 600, false));
    write(&folder, "FIC101-february.csv", recorded(PLAIN, 0, 600, false));
    let files = ["FIC101-january.csv", "FIC101-february.csv"];
    let apart = run(&folder, &[&["history"], &files[..]].concat());
    assert_eq!(apart.out.matches(".csv, 1 window\n").count(), 2, "{}", apart.out);
    assert_eq!(
        apart.err,
        "note: FIC101-january.csv, FIC101-february.csv have no tag and count as 2 valves; if they are \
         successive recordings of FIC101, give --join\n"
    );
    let joined = run(&folder, &[&["history", "--join", "--window", "50min"], &files[..]].concat());
    let text = joined.quiet_success();
    assert!(text.starts_with("FIC101  FIC101-january.csv and 1 more, 4 windows\n"), "{text}");
    let (found, err) = table(&folder, &["--join", files[0], files[1]]);
    let expected = vec!["FIC101 in FIC101-january.csv and 1 more".to_owned()];
    assert_eq!((found, err.as_str()), (expected, ""));
}

#[test]
fn what_cannot_be_joined_is_refused() {
    let folder = folder("join-refused");
    write(&folder, "a.csv", recorded(PLAIN, 0, 360, true));
    write(&folder, "b.csv", recorded(PLAIN, 1800, 360, true).replace(",50\n", ",51\n"));
    write(&folder, "c.csv", recorded(PLAIN, 0, 360, false));
    write(&folder, "FIC101.csv", recorded(TAGGED, 0, 360, true));
    write(&folder, "FIC102.csv", recorded("Time,FIC102.PV,FIC102.OP,FIC102.SP", 7200, 360, true));
    write(&folder, "two.csv", recorded("Time,FIC1.PV,FIC1.OP,FIC2.OP", 0, 360, true));
    for (files, expected) in [
        (["a.csv", "b.csv"], "b.csv: overlaps a.csv with different values of the SP"),
        (["a.csv", "c.csv"], "c.csv: has no dates, but a.csv has"),
        (["FIC101.csv", "FIC102.csv"], "FIC101.csv is of FIC101, but FIC102.csv of FIC102"),
        (["a.csv", "two.csv"], "two.csv holds 2 loops, FIC1, FIC2; choose one with --loop"),
    ] {
        for command in ["history", "diagnose"] {
            refuses(&folder, &[&[command, "--join"], &files[..]].concat(), expected);
        }
    }
}

#[test]
fn a_mapping_concerns_the_loops_that_it_names() {
    let folder = folder("join-mapping");
    write(&folder, "whole.csv", recorded("Time,x1,y1,z1", 0, 360, true));
    write(&folder, "half.csv", recorded("Time,FIC9.PV,FIC9.OP,y2", 0, 360, true));
    let mapping = "[loop.A]\npv = \"x1\"\nop = \"y1\"\nsp = \"z1\"\n[loop.B]\npv = \"x2\"\nop = \"y2\"\n\
                   [loop.C]\nop = \"y3\"\n";
    write(&folder, "map.toml", mapping);
    let both = ["diagnose", "--csv", "-", "--mapping", "map.toml", "whole.csv", "half.csv"];
    let done = run(&folder, &both);
    assert_eq!(done.code, 2, "{}", done.err);
    let (_, found) = rows(&done.out);
    assert_eq!(found.len(), 2, "{}", done.out);
    let b = "half.csv, loop B: the file has no column \"x2\", which is given as PV (in map.toml); its columns are";
    let c = "loop C: the mapping names columns or tags of this loop, but no readable file has them";
    assert!(done.err.contains(b) && done.err.contains(c), "{}", done.err);
    // What is not asked for is not missed.
    let (found, err) = table(&folder, &["--mapping", "map.toml", "--loop", "A", "whole.csv"]);
    assert_eq!((found, err.as_str()), (vec!["A in whole.csv".to_owned()], ""));
}
