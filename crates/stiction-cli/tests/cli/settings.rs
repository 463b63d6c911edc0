//! Settings of a folder, plant time, quiet, colours.

use crate::diagnose::with_samples;
use crate::{run, write};

#[test]
fn times_are_those_of_the_plant() {
    let folder = with_samples("plant-time");
    let mut text = "time,pv,op,sp\n".to_owned();
    for k in 0..600 {
        let wave = 5.0 * (f64::from(k) * 0.1).sin();
        text += &format!(
            "2026-03-01 {:02}:{:02}:{:02},{},{},50\n",
            10 + k / 3600,
            k / 60 % 60,
            k % 60,
            50.0 + wave,
            40.0 - wave
        );
    }
    write(&folder, "FIC1.csv", &text);
    let page = |options: &[&str]| {
        let done =
            run(&folder, &[&["diagnose", "FIC1.csv", "--report", "a.html"], options].concat());
        assert_eq!(done.code, 0, "{}", done.err);
        std::fs::read_to_string(folder.join("a.html")).unwrap()
    };
    let berlin = page(&["--zone", "Europe/Berlin"]);
    assert!(
        berlin.contains("2026-03-01 10:00:00 CET") && berlin.contains("time (CET)"),
        "no plant time"
    );
    assert!(!berlin.contains(" UTC") && !berlin.contains("(UTC)"));
    // A clock that nobody named is not UTC.
    let unnamed = page(&[]);
    assert!(unnamed.contains("2026-03-01 10:00:00 to") && !unnamed.contains("10:00:00 UTC"));
    let history = ["history", "FIC1.csv", "--window", "150", "--zone", "Europe/Berlin"];
    let text = run(&folder, &[&history[..], &["--repair", "2026-03-01T10:05"]].concat()).out;
    assert!(
        text.contains("2026-03-01 10:02:30 CET") && text.contains("at 2026-03-01 10:05:00 CET"),
        "{text}"
    );
}

#[test]
fn settings_of_a_folder_hold_unless_they_are_left_out() {
    let folder = with_samples("settings");
    write(&folder, "stiction.toml", "sample_time = 2.0\n");
    write(&folder, "a.csv", format!("pv,op\n{}", "50,40\n51,41\n52,40\n".repeat(40)));
    let told = run(&folder, &["inspect", "a.csv"]);
    assert!(told.err.contains("using settings of stiction.toml"), "{}", told.err);
    assert!(told.out.contains("2 s"));
    let quiet = run(&folder, &["--quiet", "inspect", "a.csv"]).quiet_success();
    assert!(quiet.contains("2 s"));
    let left = run(&folder, &["inspect", "a.csv", "--no-config"]);
    assert!(!left.err.contains("settings of"));
}

#[test]
fn colours_go_where_they_are_wanted() {
    let folder = with_samples("colours");
    let plain = run(&folder, &["diagnose", "FIC101-sticky.csv", "--brief"]).quiet_success();
    assert!(plain.contains(": sticks ") && !plain.contains('\u{1b}'), "{plain}");
    let colour = run(&folder, &["diagnose", "FIC101-sticky.csv", "--brief", "--color", "always"]);
    let colour = colour.quiet_success();
    assert!(colour.contains("\u{1b}[1m\u{1b}[31msticks\u{1b}[0m"), "{colour:?}");
}

#[test]
fn the_version_names_the_commit_in_a_clone() {
    let folder = with_samples("version");
    let text = run(&folder, &["--version"]).quiet_success();
    assert!(text.starts_with(concat!("stiction ", env!("CARGO_PKG_VERSION"))), "{text}");
    let is_clone = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.git").exists();
    assert_eq!(text.contains(" (commit "), is_clone, "{text}");
}
