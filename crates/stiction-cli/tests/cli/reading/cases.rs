//! Files that were once read wrongly, each with its right value or the refusal that is right as well.

use super::{Case, FIXTURES, Right, STICKS, case, examine};

/// A file of the fixtures.
fn kept(name: &'static str) -> Case {
    let bytes = std::fs::read(format!("{FIXTURES}/{name}")).expect("a fixture");
    let stem = name.split('.').next().unwrap_or(name);
    case(stem, name, bytes)
}

/// The loop of the fixtures, with this many samples.
fn sticks(samples: usize, s: (f64, f64)) -> Right {
    Right { judged: (samples, samples), s: Some(s), ..STICKS }
}

#[test]
fn c01_a_clock_that_begins_again() {
    let case = kept("c01-restart-offset.csv")
        .right(|right| *right = sticks(1500, (3.6, 4.4)))
        .said(&["restart", "again", "went back", "goes back", "fell back", "falls back"]);
    examine("c01", vec![case.or_refused(&[], &[])]);
    let folder = super::folder("reading-c01-inspect");
    super::write(&folder, "c01.csv", kept("c01-restart-offset.csv").files.remove(0).1);
    let shown = super::run(&folder, &["inspect", "c01.csv"]);
    let notes: Vec<&str> = shown.out.lines().filter(|line| line.contains("note:")).collect();
    // Rows 502 and 1002 are the first of the second and the third run.
    let named = notes.iter().any(|note| note.contains("502") && note.contains("1002"));
    assert!(named, "c01: inspect names no restarts: {notes:?} {}", shown.err);
}

#[test]
fn c03_status_codes_in_words() {
    let right = Right {
        grades: &["probably fine"],
        probability: (0.0, 0.2),
        s: None,
        ..sticks(260, (0.0, 0.0))
    };
    examine("c03", vec![kept("c03-opcua-status-text.csv").right(|to| *to = right)]);
}

#[test]
fn c04_annotated_tables() {
    let right =
        Right { grades: &["unclear"], probability: (0.3, 0.6), s: None, ..sticks(140, (0.0, 0.0)) };
    examine("c04", vec![kept("c04-influx-annotated.csv").right(|to| *to = right)]);
}

#[test]
fn c05_tags_at_other_times() {
    let right = Right { judged: (898, 901), ..sticks(900, (3.5, 4.5)) };
    examine("c05", vec![kept("c05-wide-tags-at-other-times.csv").right(|to| *to = right)]);
}

#[test]
fn c07_thousands_across_1000() {
    let case = kept("c07-thousands-across-1000.csv")
        .right(|to| *to = Right { pv: (972.0, 1040.0), ..sticks(1199, (3.0, 4.8)) })
        .or_refused(&["1.001"], &[]);
    examine("c07", vec![case]);
}

#[test]
fn c08_a_clock_for_each_channel() {
    let right = Right { judged: (1255, 1272), ..sticks(1263, (3.6, 4.4)) };
    let case = kept("c08-clock-per-channel.csv").right(|to| *to = right);
    examine("c08", vec![case.or_refused(&["Time", "Time2", "Time3"], &[])]);
}

#[test]
fn c10_a_file_for_each_tag() {
    let read = |name: &str| {
        std::fs::read(format!("{FIXTURES}/c10-file-per-tag/{name}")).expect("a fixture")
    };
    let case = case("c10", "FIC101.PV.csv", read("FIC101.PV.csv"))
        .file("FIC101.SP.csv", read("FIC101.SP.csv"))
        .file("FIC101.OP.csv", read("FIC101.OP.csv"))
        .right(|to| *to = Right { judged: (600, 600), ..sticks(0, (3.3, 4.5)) });
    examine("c10", vec![case]);
}

#[test]
fn c11_structure_with_time() {
    let right = Right { judged: (500, 2400), ..sticks(0, (3.3, 4.4)) };
    examine("c11", vec![kept("c11-simulink-structure-with-time.mat").right(|to| *to = right)]);
}

#[test]
fn c12_an_op_in_psi() {
    let case = kept("c12-op-in-psi.csv").right(|to| *to = sticks(1300, (3.5, 4.3)));
    examine("c12", vec![case.or_refused(&["psi"], &["--op-range=3,15"])]);
}

#[test]
fn c13_an_op_in_counts() {
    let guessed = Right { holds: Some(4.0), ..sticks(1300, (0.0, 100.0)) };
    let mut given = kept("c13-op-in-counts.csv").right(|to| *to = sticks(1300, (3.5, 4.3)));
    given.options = &["--op-range", "0,27648"];
    examine("c13", vec![kept("c13-op-in-counts.csv").right(|to| *to = guessed), given]);
}

#[test]
fn c16_units_and_descriptions() {
    let case = kept("c16-units-and-descriptions.csv").right(|to| *to = sticks(600, (3.3, 4.4)));
    examine(
        "c16",
        vec![case.or_refused(&["day-first or month-first"], &["--time-format=month-first"])],
    );
}

#[test]
fn c18_time_of_day_over_midnight() {
    let case = kept("c18-time-of-day-over-midnight.csv").right(|to| *to = sticks(501, (3.0, 4.4)));
    examine("c18", vec![case.or_refused(&["--sample-time 1"], &[])]);
}

#[test]
fn c21_t_stamp() {
    examine(
        "c21",
        vec![kept("c21-ignition-t_stamp.csv").right(|to| *to = sticks(900, (3.5, 4.2)))],
    );
}

#[test]
fn c22_stored_on_change() {
    examine(
        "c22",
        vec![kept("c22-stored-on-change.csv").right(|to| *to = sticks(800, (3.3, 4.5)))],
    );
}

#[test]
fn c23_the_swing_of_a_triangle() {
    let folder = super::folder("reading-c23");
    let bytes = std::fs::read(format!("{FIXTURES}/c23-triangle-swing.csv")).expect("a fixture");
    super::write(&folder, "c23.csv", bytes);
    super::run(&folder, &["diagnose", "c23.csv", "--report", "c23.html"]);
    let page = super::super::read(&folder, "c23.html");
    let (_, after) = page.split_once("PV swings</dt><dd>±").expect("the swing of the PV");
    let end = after.find(' ').expect("a unit");
    let swing: f64 = after[..end].parse().expect("a number");
    assert!((2.95..=3.05).contains(&swing), "c23: PV swing ±{swing}, expected ±2.96 to ±3.0");
}
