//! What reaches terminals and spreadsheets, and what comes from standard input.

use crate::diagnose::{samples, with_samples};
use crate::{Done, command, folder, read, refuses, run, write};
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

const FILE: &str = "FIC101-sticky.csv";

/// Runs the command with `input` as its standard input.
fn fed(folder: &Path, arguments: &[&str], input: impl AsRef<[u8]>) -> Done {
    let mut child = command(folder)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut pipe = child.stdin.take().expect("a pipe");
    let input = input.as_ref().to_vec();
    // Who refuses its arguments does not read to the end.
    let writer = std::thread::spawn(move || pipe.write_all(&input).is_ok());
    let output = child.wait_with_output().expect("it ends");
    let _ = writer.join();
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    let code = output.status.code().expect("it ends by itself");
    Done { code, out: text(output.stdout), err: text(output.stderr) }
}

/// The sticky sample under another tag.
fn tagged(tag: &str) -> String {
    let quoted = tag.replace('"', "\"\"");
    let head = format!("t,\"{quoted}.SP\",\"{quoted}.PV\",\"{quoted}.OP\"\n");
    head + read(&samples(), FILE).split_once('\n').expect("a header").1
}

#[test]
fn a_tag_that_is_a_formula_is_text_in_tables() {
    let folder = folder("formulas");
    for tag in ["=HYPERLINK(1)", "+FIC1", "-FIC1", "@FIC1"] {
        write(&folder, "x.csv", tagged(tag));
        for arguments in
            [["diagnose", "x.csv", "--csv", "o.csv"], ["history", "x.csv", "--csv", "h.csv"]]
        {
            assert_eq!(run(&folder, &arguments).code, 0);
            let table = read(&folder, arguments[3]);
            let row = table.lines().nth(1).expect("a row");
            assert!(row.starts_with(&format!("'{tag},")), "{row}");
            assert!(!row.contains(",'"), "numbers and all other texts stay: {row}");
        }
        // Documents for programs are what they were.
        let found = run(&folder, &["diagnose", "x.csv", "--json"]).json();
        assert_eq!(found["loops"][0]["loop"], tag);
    }
}

#[test]
fn nothing_steers_the_terminal() {
    let folder = folder("steering");
    let evil = "FIC\u{202e}1\u{1b}[2J\u{200f}\u{2067}\u{9b}";
    let file = "a\n\u{1b}]0;x\u{7}.csv";
    write(&folder, file, tagged(evil));
    write(&folder, "x.csv", tagged(evil));
    let is_bad = |c: char| {
        (c.is_control() && c != '\n')
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    for arguments in [
        &["diagnose", file][..],
        &["diagnose", file, "x.csv"],
        &["diagnose", file, "--brief"],
        &["diagnose", file, "--json"],
        &["diagnose", file, "--loop", evil],
        &["diagnose", file, "--loop", "\u{1b}"],
        &["diagnose", "\u{1b}[2J\n"],
        &["diagnose", file, "--grid", "\u{202e}"],
        &["history", file],
        &["inspect", file],
        &["fit", file, "--draws", "20"],
        &["what-if", file],
        &["shift", file, "--top", "1"],
        &["override", file, "--verdict", "sticks", "--reason", "\u{202e}a\u{1b}[2Jb"],
        &["override", ".", "--list"],
        &["simulate", "\u{1b}[2J\u{202e}"],
        &["diagnose", file],
    ] {
        let Done { out, err, .. } = run(&folder, arguments);
        let bad = out.chars().chain(err.chars()).find(|c| is_bad(*c));
        assert_eq!(bad, None, "{arguments:?}: {out:?} {err:?}");
        assert!(!out.contains("a\n\\u"), "a name stays on its line: {out}");
    }
    let text = run(&folder, &["diagnose", file]).out;
    assert!(text.contains("FIC\\u{202e}1\\u{1b}[2J"), "{text}");
    let found = run(&folder, &["diagnose", file, "--json"]).json();
    assert_eq!(found["loops"][0]["loop"], evil, "JSON says the same in its own way");
}

#[test]
fn a_dash_is_standard_input() {
    let folder = with_samples("standard-input");
    let csv = read(&samples(), FILE);
    for (arguments, expected) in [
        (&["diagnose", "-", "--brief"][..], "standard input: sticks"),
        (&["inspect", "-"], "standard input\n  format  CSV"),
        (&["history", "-"], "standard input  standard input, 1 window"),
        (&["fit", "-", "--draws", "20"], "standard input\n"),
        (&["shift", "-", "--top", "1"], "1 recordings against"),
    ] {
        let out = fed(&folder, arguments, &csv).quiet_success();
        assert!(out.contains(expected), "{arguments:?}: {out}");
    }
    let out = fed(&folder, &["valve", "--S", "1", "--J", "1", "-"], "t,u\n0,1\n1,9\n");
    assert!(out.quiet_success().starts_with("t,u,vp\n0,1,1"));
    let refused = fed(&folder, &["diagnose", "-"], "a,b\n1\n").refusal();
    assert!(refused.starts_with("stiction: standard input"), "{refused}");
    let refused = fed(&folder, &["diagnose", "-", "-"], &csv).refusal();
    assert!(refused.contains("standard input can be read only once"), "{refused}");
    let arguments = ["override", "-", "--verdict", "sticks", "--reason", "x"];
    let refused = fed(&folder, &arguments, &csv).refusal();
    assert!(refused.contains("standard input cannot have an override; name the file"), "{refused}");
    #[cfg(unix)]
    {
        let done = command(&folder)
            .args(["diagnose", "-", "--csv", FILE])
            .stdin(std::fs::File::open(folder.join(FILE)).expect("a file"))
            .output()
            .expect("it starts");
        assert_eq!(done.status.code(), Some(2));
        assert_eq!(read(&folder, FILE), csv);
    }
}

#[cfg(unix)]
#[test]
fn what_never_ends_is_refused() {
    refuses(&folder("endless"), &["inspect", "/dev/zero"], "may never end; write its output");
}

#[test]
fn times_that_tell_nothing_are_named_with_their_row() {
    let folder = folder("odd-times");
    let with = |time: &dyn Fn(usize, &str) -> String| -> String {
        let sample = read(&samples(), FILE);
        let (head, rows) = sample.split_once('\n').expect("a header");
        let rows = rows.lines().enumerate().map(|(k, row)| {
            let (t, rest) = row.split_once(',').expect("cells");
            format!("{},{rest}\n", time(k, t))
        });
        format!("{head}\n{}", rows.collect::<String>())
    };
    let same = "row 3, column \"t\": has the same time";
    for (text, expected) in [
        (with(&|_, _| "5".to_owned()), same),
        (
            with(&|k, _| format!("12345678901234567890123456789012345{k:05}")),
            "row 2, column \"t\": \"1234567",
        ),
        (with(&|_, _| "9999-12-31".to_owned()), "column \"t\": "),
        (
            with(&|k, t| if k == 500 { "1e308".to_owned() } else { t.to_owned() }),
            "row 502, column \"t\": \"1e308\", interpreted as seconds, is not a time of a recording",
        ),
    ] {
        write(&folder, "x.csv", text);
        refuses(&folder, &["diagnose", "x.csv"], expected);
    }
}

#[test]
fn a_message_says_things_once() {
    let folder = folder("once");
    write(&folder, "index.csv", "loop,label\nA,stiction\n");
    for arguments in [
        &["diagnose", "no.csv"][..],
        &["bench", "labels", "no.csv"],
        &["bench", "labels", "index.csv"],
        &["valve", "--S", "1", "--J", "1", "no.csv"],
        &["fmu", "--library", "a-b=no.so", "-o", "x.fmu"],
        &["simulate", "paper/closed-loop", "-o", "no/x.csv"],
        &["diagnose", "no.csv", "--mapping", "no.toml"],
        &["override", "no.csv", "--verdict", "sticks", "--reason", "x"],
    ] {
        let said = run(&folder, arguments).refusal();
        assert_eq!(said.matches("No such file").count(), 1, "{arguments:?}: {said}");
    }
}
