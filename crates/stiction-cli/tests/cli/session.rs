//! What is the same for all commands: help, exit codes, pipes.

use crate::diagnose::sample;
use crate::{command, folder, read, run};
use std::io::Read;
use std::process::Stdio;

/// The subcommands, as the help lists them.
pub fn commands(help: &str) -> Vec<&str> {
    let list = help.split("Commands:\n").nth(1).and_then(|rest| rest.split("\n\n").next());
    let names = list.expect("a list").lines().filter(|line| !line.starts_with("   "));
    names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect()
}

#[test]
fn every_command_has_help_with_an_example_and_stands_in_the_readme() {
    let folder = folder("help");
    let top = run(&folder, &["-h"]).quiet_success();
    let names = commands(&top);
    assert!(names.len() >= 16, "{top}");
    let readme = include_str!("../../../../README.md");
    let row = readme.lines().find(|line| line.starts_with("| Command |")).expect("a row");
    for name in names {
        assert!(
            row.contains(&format!("`{name}`")) || row.contains(&format!("`stiction {name}`")),
            "README.md lacks {name}"
        );
        for flag in ["--help", "-h"] {
            let help = run(&folder, &[name, flag]).quiet_success();
            let example = help.split_once("Example").expect("an example").1;
            assert!(example.contains(&format!("stiction {name} ")), "{help}");
        }
    }
    assert!(run(&folder, &["--help"]).quiet_success().contains("Exit code 0"));
}

#[test]
fn help_is_printed_for_nothing_and_names_the_version() {
    let folder = folder("version");
    let version = run(&folder, &["--version"]).quiet_success();
    assert!(version.starts_with(concat!("stiction ", env!("CARGO_PKG_VERSION"))), "{version}");
    assert!(run(&folder, &[]).refusal().contains("Usage: stiction [OPTIONS] <COMMAND>"));
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

#[test]
fn shells_complete_and_man_pages_are_written() {
    let folder = folder("shell");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = run(&folder, &["completions", shell]).quiet_success();
        assert!(script.contains("what-if") && script.contains("fail-on"), "{shell}: {script}");
    }
    let refused = run(&folder, &["completions", "dos"]);
    assert!(refused.code == 2 && refused.err.contains("bash"), "{}", refused.err);
    run(&folder, &["man", "pages"]).quiet_success();
    let page = read(&folder, "pages/stiction-diagnose.1");
    assert!(
        page.contains(".TH") && page.contains("fail\\-on") && page.contains("Examples"),
        "{page}"
    );
    assert!(read(&folder, "pages/stiction.1").contains("stiction\\-diagnose"));
}

#[test]
fn a_line_a_loop() {
    let folder = folder("brief");
    let (sticky, healthy) = (sample("FIC101-sticky.csv"), sample("FIC102-disturbed.csv"));
    let lines = run(&folder, &["diagnose", &healthy, &sticky, "--brief"]).quiet_success();
    let lines: Vec<&str> = lines.lines().collect();
    assert!(
        lines.len() == 2 && lines[0].starts_with("FIC101-sticky: sticks (99 %); S "),
        "{lines:?}"
    );
    assert!(
        lines[1].starts_with("FIC102-disturbed: fine (")
            && lines[1].ends_with(" % would have been detected"),
        "{lines:?}"
    );
    // At the end of a long text, too.
    let text = run(&folder, &["diagnose", &sticky]).quiet_success();
    assert!(text.trim_end().ends_with(lines[0]), "{text}");
}
