//! The `stiction` command, run as a user runs it.

mod bench;
mod compensate;
mod contradictions;
mod detector;
mod diagnose;
mod docs;
mod figures;
mod fit;
mod fmu;
#[cfg(unix)]
mod followed;
mod history;
mod inspect;
mod join;
mod kept;
#[cfg(unix)]
mod killed;
mod lab_ends;
mod limit_cycle;
mod malformed;
mod nothing_lost;
mod numbers;
mod outputs;
mod overrule;
mod plant;
mod population;
mod reading;
mod schema;
mod screens;
mod session;
mod settings;
mod shift;
mod simulate;
#[cfg(unix)]
mod standard_output;
mod stem;
mod valve;
mod valve_test;
#[cfg(unix)]
mod watch;
mod what_if;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The names of the built-in scenarios.
const BUILT_IN: [&str; 18] = [
    "paper/open-loop-linear",
    "paper/open-loop-deadband",
    "paper/open-loop-stiction",
    "paper/open-loop-high",
    "paper/step-linear",
    "paper/step-stiction",
    "paper/closed-loop",
    "paper/flow-cascade",
    "choudhury/concentration",
    "choudhury/level",
    "samples/sticky-flow",
    "samples/disturbed-flow",
    "samples/aggressive-flow",
    "samples/quantised-level",
    "samples/cascade-slave",
    "lab/flow",
    "lab/level",
    "lab/temperature",
];

/// What a run of the command left behind.
struct Done {
    code: i32,
    out: String,
    err: String,
}

impl Done {
    /// The standard output of a run that succeeded without a word beside it.
    #[track_caller]
    fn quiet_success(self) -> String {
        assert_eq!((self.code, self.err.as_str()), (0, ""), "exit code and standard error");
        self.out
    }

    /// The JSON that a quiet success printed.
    #[track_caller]
    fn json(self) -> serde_json::Value {
        serde_json::from_str(&self.quiet_success()).expect("valid JSON")
    }

    /// The message of a run that was refused: exit code 2, nothing on standard output.
    #[track_caller]
    fn refusal(self) -> String {
        assert_eq!((self.code, self.out.as_str()), (2, ""), "exit code and output: {}", self.err);
        self.err
    }
}

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
    command.current_dir(folder).stdin(Stdio::null());
    command
}

/// Runs the command in `folder`.
fn run(folder: &Path, arguments: &[&str]) -> Done {
    let output = command(folder).args(arguments).output().expect("the command starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    let code = output.status.code().expect("the command ends by itself");
    Done { code, out: text(output.stdout), err: text(output.stderr) }
}

/// An empty folder for the test called `name`.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) {
    let mut file = std::fs::File::create(folder.join(name)).expect("a file for the test");
    file.write_all(text.as_ref()).expect("the file is written");
}

fn read(folder: &Path, name: &str) -> String {
    let path = folder.join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Header and rows of a CSV without quotes.
fn rows(csv: &str) -> (Vec<&str>, Vec<Vec<&str>>) {
    let mut lines = csv.lines().map(|line| line.split(',').collect());
    (lines.next().expect("a header"), lines.collect())
}

/// The column called `name` of a CSV without quotes.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let (header, rows) = rows(csv);
    let index = header.iter().position(|n| *n == name).expect("the column is there");
    rows.iter().map(|row| row[index].parse().expect("a number")).collect()
}

/// The paper's loop at a sample time of 0.1 s.
fn paper<'a>(command: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[command, "paper/closed-loop", "--set", "sample_time=0.1"], more].concat()
}

#[track_caller]
fn assert_near(found: &serde_json::Value, expected: f64, tolerance: f64) {
    let found = found.as_f64().expect("a number");
    assert!((found - expected).abs() <= tolerance, "{found}, but expected {expected}");
}

/// Runs the command, which must refuse with a message that contains `expected`.
#[track_caller]
fn refuses(folder: &Path, arguments: &[&str], expected: &str) {
    let err = run(folder, arguments).refusal();
    assert!(err.contains(expected), "{arguments:?} must say \"{expected}\", but says: {err}");
}

/// That a command on a loop refuses what is none, and what cannot be drawn or printed.
fn no_loop_is_refused(folder: &Path, command: &str) {
    write(folder, "bad.toml", "sample_time = 0.1\nduration = 10\n[valve]\nS = -5\nJ = 3\n");
    for (scenario, expected) in [
        ("paper/flow-cascade", "is a cascade, and this command needs a single loop"),
        ("paper/step-linear", "is a valve on a test signal"),
        ("no-such", "no-such"),
        ("bad.toml", "bad.toml"),
    ] {
        refuses(folder, &[command, scenario], expected);
    }
    refuses(folder, &paper(command, &["--set", "valve.S=-1"]), "S");
    refuses(folder, &paper(command, &["--set", "controller.kc=60"]), "grow");
    refuses(folder, &paper(command, &["--plot", "a.pdf"]), ".svg or .png");
    refuses(folder, &paper(command, &["--json", "--csv", "-"]), "cannot be used with");
    refuses(folder, &[command], "required");
}
