//! What is the same for all commands: help, exit codes, pipes.

use crate::{command, folder, run};
use std::io::Read;
use std::process::Stdio;

const COMMANDS: [&str; 13] = [
    "valve",
    "stem",
    "simulate",
    "limit-cycle",
    "compensate",
    "what-if",
    "fmu",
    "population",
    "shift",
    "figures",
    "inspect",
    "history",
    "override",
];

#[test]
fn every_command_has_help_with_an_example() {
    let folder = folder("help");
    let top = run(&folder, &["--help"]).quiet_success();
    assert!(top.contains("Exit codes: 0"), "{top}");
    for name in COMMANDS {
        assert!(top.contains(&format!("\n  {name} ")), "{name} is listed: {top}");
        for flag in ["--help", "-h"] {
            let help = run(&folder, &[name, flag]).quiet_success();
            let example = help.split_once("Example").expect("an example").1;
            assert!(example.contains(&format!("stiction {name} ")), "{help}");
        }
    }
}

#[test]
fn help_is_printed_for_nothing_and_names_the_version() {
    let folder = folder("version");
    let version = run(&folder, &["--version"]).quiet_success();
    assert_eq!(version, concat!("stiction ", env!("CARGO_PKG_VERSION"), "\n"));
    assert!(run(&folder, &[]).refusal().contains("Usage: stiction <COMMAND>"));
}

/// A reader that stops early, as `head` does, is a success without a word.
#[test]
fn a_broken_pipe_is_a_quiet_success() {
    let folder = folder("pipe");
    let cases: [&[&str]; 3] = [
        &["simulate", "paper/closed-loop", "-o", "-"],
        &["simulate", "paper/closed-loop", "-o", "-", "--json"],
        &["stem", "--period", "400"],
    ];
    for arguments in cases {
        let mut child = command(&folder)
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let mut out = child.stdout.take().expect("a pipe");
        out.read_exact(&mut [0; 8]).expect("it writes something");
        // More than a pipe holds is still to come.
        drop(out);
        let done = child.wait_with_output().expect("the command ends");
        assert!(done.status.success(), "{arguments:?}: {:?}", done.status);
        assert!(done.stderr.is_empty(), "{}", String::from_utf8_lossy(&done.stderr));
    }
}

/// Where no one can read the message, the exit code still tells.
#[test]
fn a_closed_standard_error_is_no_panic() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let status = command(&folder("stderr"))
        .args(["simulate", "no-such-scenario"])
        .stderr(writer)
        .status()
        .expect("the command starts");
    assert_eq!(status.code(), Some(2));
}
