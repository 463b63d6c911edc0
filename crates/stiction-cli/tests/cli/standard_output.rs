//! Standard output that is a null device or full.

use crate::diagnose::with_samples;
use crate::session::commands;
use crate::{command, read, run};
use std::fs::OpenOptions;

/// A line of every command and of every task of a plant, in an order in which each has what it reads, and its exit code.
const LINES: &[(&str, i32)] = &[
    ("diagnose FIC101-sticky.csv", 0),
    ("diagnose FIC101-sticky.csv --json", 0),
    ("diagnose FIC101-sticky.csv --brief", 0),
    ("diagnose FIC101-sticky.csv --csv -", 0),
    ("diagnose FIC101-sticky.csv --csv o.csv", 0),
    ("diagnose FIC101-sticky.csv --report r.html", 0),
    ("diagnose FIC101-sticky.csv --fail-on sticks", 1),
    ("history FIC101-sticky.csv", 0),
    ("plant demo --loops 12 --days 2 -o p", 0),
    ("plant init FIC101-sticky.csv", 0),
    ("plant -C p check", 0),
    ("plant -C p scan", 0),
    ("plant -C p status", 0),
    ("plant -C p report", 0),
    ("plant -C p report --fail-on new-sticking", 0),
    ("plant -C p orders", 0),
    ("plant -C p note LIC1001 stroked", 0),
    ("plant -C p override LIC1001 sticks --reason stroked", 0),
    ("plant -C p snooze LIC1001 --until 2030-01-01", 0),
    ("override FIC101-sticky.csv --verdict sticks --reason stroked", 0),
    ("inspect FIC101-sticky.csv", 0),
    ("fit FIC101-sticky.csv --draws 20", 0),
    ("bench simulated 2 --only verdict", 0),
    ("valve --S 1 --J 1 in.csv", 0),
    ("stem", 0),
    ("simulate paper/closed-loop", 0),
    ("compensate paper/closed-loop", 0),
    ("what-if paper/closed-loop", 0),
    ("test plan FIC101-sticky.csv", 0),
    ("limit-cycle paper/closed-loop", 0),
    ("population --n 2 -o population", 0),
    ("fmu --list", 0),
    ("shift FIC101-sticky.csv", 0),
    ("figures -o drawn", 0),
    ("docs -o site", 0),
    ("schema diagnosis", 0),
    ("completions bash", 0),
    ("man pages", 0),
];

/// What never ends.
const NOT_RUN: [&str; 2] = ["lab", "watch"];

fn prepared(name: &str) -> std::path::PathBuf {
    let folder = with_samples(name);
    crate::write(&folder, "in.csv", "t,u\n0,1\n1,2\n2,3\n");
    folder
}

/// `subprocess.DEVNULL` of Python, Node's `ignore`, and `daemon(3)` open it so.
#[test]
fn every_command_runs_into_a_null_device() {
    let folder = prepared("null-device");
    let tried = |name: &str| LINES.iter().any(|(line, _)| line.split(' ').next() == Some(name));
    let help = run(&folder, &["-h"]).quiet_success();
    for name in commands(&help) {
        assert!(tried(name) || NOT_RUN.contains(&name), "{name} has no line here");
    }
    for (line, expected) in LINES {
        let null = OpenOptions::new().read(true).write(true).open("/dev/null").expect("a device");
        let arguments = line.split(' ');
        let done = command(&folder).args(arguments).stdout(null).output().expect("it starts");
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(*expected), "{line}: {said}");
    }
    let log = read(&folder.join("p"), "log.toml");
    assert_eq!(log.matches("stroked").count(), 2, "{log}");
}

/// An entry is made before its line is printed, so the failure says so, and who repeats the command enters nothing twice.
#[cfg(target_os = "linux")]
#[test]
fn an_entry_whose_line_cannot_be_printed_is_reported_and_not_made_twice() {
    let folder = prepared("full-output");
    run(&folder, &["plant", "demo", "--loops", "12", "--days", "1", "-o", "p"]).quiet_success();
    run(&folder, &["plant", "-C", "p", "scan"]).quiet_success();
    for (line, kept) in [
        ("plant -C p note LIC1001 stroked", "p/log.toml"),
        ("override FIC101-sticky.csv --verdict sticks --reason stroked", "stiction-overrides.toml"),
    ] {
        for _ in 0..2 {
            let full = OpenOptions::new().write(true).open("/dev/full").expect("a device");
            let done =
                command(&folder).args(line.split(' ')).stdout(full).output().expect("it starts");
            let said = String::from_utf8_lossy(&done.stderr).into_owned();
            assert_eq!(done.status.code(), Some(2), "{line}: {said}");
            assert!(said.contains("kept in") && said.contains("standard output failed"), "{said}");
        }
        assert_eq!(read(&folder, kept).matches("stroked").count(), 1, "{line}");
    }
}
