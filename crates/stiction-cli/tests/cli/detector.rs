//! `stiction bench` on suites: any program, results, reports.

use crate::{command, folder, read, refuses, run, write};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/detectors");
const PASSPHRASE: &str = "STICTION_BENCH_PASSPHRASE";

/// Whether a program can be run here; says so if not.
fn is_there(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    if !found {
        println!("not tested: {program} is not installed");
    }
    found
}

/// The results of a detector on the trial suite.
fn measured(folder: &Path, detector: &str, more: &[&str]) -> Value {
    let base = ["bench", "detector", detector, "--suite", "v1-trial", "--json"];
    run(folder, &[&base[..], more].concat()).json()
}

/// What does not depend on time.
fn timeless(mut results: Value) -> Value {
    for entry in results["entries"].as_array_mut().expect("entries") {
        entry["time"] = Value::Null;
        entry["answers"].as_array_mut().expect("answers").iter_mut().for_each(|answer| {
            answer.as_object_mut().expect("an answer").remove("time_s");
        });
    }
    results
}

#[test]
fn a_suite_has_the_same_bytes_on_any_number_of_threads_and_no_truth_in_the_recordings() {
    let folder = folder("suite-bytes");
    for threads in ["1", "2"] {
        let suite = ["bench", "suite", "v1-trial", "-o", threads];
        let done = command(&folder).env("RAYON_NUM_THREADS", threads).args(suite).output();
        assert!(done.expect("the command starts").status.success());
    }
    for name in ["recordings.jsonl", "truth/truth.csv", "DATASHEET.md", "SHA256SUMS"] {
        let [one, two] = ["1", "2"].map(|threads| read(&folder.join(threads), name));
        assert!(one == two, "{name}");
    }
    let sums = read(&folder.join("1"), "SHA256SUMS");
    // The suite is frozen: other bytes are another suite, and need another name.
    let frozen =
        "96a822dd709b2f03077ed34813010e9cf50933f4ba0ca2f635fca08d4e1fe489  recordings.jsonl";
    assert!(sums.lines().any(|line| line == frozen), "{sums}");
    assert_eq!(sums.lines().count(), 3);
    let recordings = read(&folder.join("1"), "recordings.jsonl");
    assert_eq!(recordings.lines().count(), 120);
    for line in recordings.lines() {
        let recording: Value = serde_json::from_str(line).expect("JSON");
        let keys: Vec<&str> =
            recording.as_object().expect("an object").keys().map(String::as_str).collect();
        let known = ["id", "type", "sample_time_s", "op", "pv", "sp", "vp"];
        assert!(keys.iter().all(|key| known.contains(key)), "{keys:?}");
    }
    let datasheet = read(&folder.join("1"), "DATASHEET.md");
    assert!(datasheet.contains("| external wave | healthy |"), "{datasheet}");
    refuses(&folder, &["bench", "suite", "v1-trial", "-o", "1"], "1 is not empty");
    refuses(&folder, &["bench", "suite", "v0", "-o", "other"], "v1-trial");
}

#[test]
fn the_hidden_half_needs_its_passphrase() {
    let folder = folder("suite-hidden");
    let write_half = |passphrase: Option<&str>, output: &str| {
        let mut command = command(&folder);
        command.args(["bench", "suite", "v1-trial", "--hidden", "-o", output]);
        match passphrase {
            Some(words) => command.env(PASSPHRASE, words),
            None => command.env_remove(PASSPHRASE),
        };
        let done = command.output().expect("the command starts");
        (done.status.success(), String::from_utf8_lossy(&done.stderr).into_owned())
    };
    let (done, err) = write_half(None, "none");
    assert!(!done && err.contains(PASSPHRASE), "{err}");
    let (done, err) = write_half(Some("too short"), "short");
    assert!(!done && err.contains("16 characters") && !err.contains("too short"), "{err}");
    assert!(write_half(Some("the first passphrase"), "one").0);
    assert!(write_half(Some("another passphrase"), "two").0);
    let [one, two] = ["one", "two"].map(|half| read(&folder.join(half), "recordings.jsonl"));
    assert!(one.starts_with(r#"{"id":"v1-trial-hidden-00000""#) && one != two);

    // A detector does not learn it.
    let curious =
        format!("test -z \"${PASSPHRASE}\" && \"{}\" bench answer", env!("CARGO_BIN_EXE_stiction"));
    let mut command = command(&folder);
    command.env(PASSPHRASE, "the first passphrase").args(["bench", "detector", &curious]);
    let done = command.args(["--suite", "v1-trial", "--hidden", "--json"]).output();
    let results: Value =
        serde_json::from_slice(&done.expect("the command starts").stdout).expect("JSON");
    assert_eq!(results["loops"]["hidden"], true);
    assert_eq!(results["entries"][0]["measures"]["answered"]["k"], 120);
}

#[test]
fn our_verdict_and_methods_give_the_same_by_each_door() {
    let folder = folder("detector-doors");
    let own = [
        "bench", "detector", "--suite", "v1-trial", "--method", "horch", "--method", "kano",
        "--json",
    ];
    let own = timeless(run(&folder, &own).json());
    let names: Vec<&str> = own["entries"]
        .as_array()
        .expect("entries")
        .iter()
        .map(|entry| entry["detector"]["name"].as_str().expect("a name"))
        .collect();
    assert_eq!(names[0], "verdict");
    for (name, more) in [("verdict", ""), ("horch", " --method horch"), ("kano", " --method kano")]
    {
        let program = format!("\"{}\" bench answer{more}", env!("CARGO_BIN_EXE_stiction"));
        let found = timeless(measured(&folder, &program, &["--name", name]));
        let at = names.iter().position(|known| *known == name).expect("an entry");
        for part in ["sha256", "measures", "answers"] {
            assert!(found["entries"][0][part] == own["entries"][at][part], "{name}: {part}");
        }
    }
}

#[test]
fn examples_in_three_languages_agree() {
    let folder = folder("detector-languages");
    let programs = [
        ("python3", format!("python3 {EXAMPLES}/detector.py")),
        ("Rscript", format!("Rscript {EXAMPLES}/detector.R")),
        ("octave-cli", format!("octave-cli --quiet {EXAMPLES}/detector.m")),
    ];
    let mut found: Vec<(&str, Vec<f64>)> = vec![];
    for (program, detector) in programs.iter().filter(|(program, _)| is_there(program)) {
        let results = measured(&folder, detector, &["--name", program]);
        let entry = &results["entries"][0];
        assert_eq!(entry["measures"]["failures"], Value::Array(vec![]), "{program}");
        let answers = entry["answers"].as_array().expect("answers");
        let scores = answers.iter().filter_map(|answer| answer["score"].as_f64()).collect();
        found.push((program, scores));
    }
    for (program, scores) in &found {
        let (first, other) = (&found[0].1, scores);
        assert!(first.len() == other.len() && first.len() > 100, "{program}");
        assert!(first.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-9), "{program}");
    }
}

/// A detector that misbehaves on some loops.
const WILD: &str = r#"
import json, os, sys, time
print("loading a model")
for line in sys.stdin:
    name = json.loads(line)["id"]
    k = int(name[-5:])
    print("working on", name)
    if k == 10:
        os._exit(7)
    if k == 20:
        sys.exit("no such matrix")
    if k == 30:
        print("hanging", flush=True)
        time.sleep(600)
    if k == 40:
        print('{"id": "%s", "score": NaN}' % name, flush=True)
    elif k == 50:
        print('{"id": "%s", "score": ' % name, flush=True)
    elif k == 60:
        print("{" + "x" * 3000000, flush=True)
    elif k == 70:
        print(json.dumps({"id": name, "score": "large"}), flush=True)
    else:
        print(json.dumps({"id": name, "score": k % 7, "decision": "abstain"}), flush=True)
        print("done with", name, flush=True)
"#;

#[test]
fn a_detector_that_misbehaves_does_not_end_the_run() {
    if !is_there("python3") {
        return;
    }
    let folder = folder("detector-wild");
    write(&folder, "wild.py", WILD);
    let limits = ["--limit", "1.5", "--startup", "2"];
    let results = measured(&folder, "python3 wild.py", &limits);
    let entry = &results["entries"][0];
    let answers = entry["answers"].as_array().expect("answers");
    let missing: Vec<(&str, &str)> = answers
        .iter()
        .filter_map(|answer| Some((answer["id"].as_str()?, answer["no_answer"].as_str()?)))
        .collect();
    let wanted = [
        ("10", "exit code 7"),
        ("20", "exit code 1: no such matrix"),
        ("30", "no answer within"),
        ("40", "NaN"),
        ("50", "not JSON"),
        ("60", "not JSON"),
        ("70", "wrong type"),
    ];
    assert_eq!(missing.len(), wanted.len(), "{missing:?}");
    for ((id, reason), (number, words)) in missing.iter().zip(wanted) {
        assert!(id.ends_with(number) && reason.contains(words), "{id}: {reason}");
    }
    assert!(missing[2].1.contains("its last line is \"hanging\""), "{}", missing[2].1);
    assert_eq!(entry["measures"]["answered"]["k"], 113);

    // What never answers is given up soon, and a command that does not exist is named.
    for (detector, words) in [("exit 3", "exit code 3"), ("no-such-detector", "not found")] {
        let asked = ["bench", "detector", detector, "--suite", "v1-trial", "--json"];
        let done = run(&folder, &[&asked[..], &["--processes", "2"]].concat());
        let why = "the detector answered none of 120 loops";
        assert!(done.code == 2 && done.err.contains(why), "{} {}", done.code, done.err);
        let results: Value = serde_json::from_str(&done.out).expect("valid JSON");
        let failures =
            results["entries"][0]["measures"]["failures"].as_array().expect("failures").clone();
        let reasons: Vec<&str> =
            failures.iter().filter_map(|each| each["reason"].as_str()).collect();
        assert!(reasons.iter().any(|reason| reason.contains(words)), "{reasons:?}");
        assert!(
            reasons.iter().any(|reason| reason.contains("10 starts without an answer")),
            "{reasons:?}"
        );
        let missing: u64 = failures.iter().filter_map(|each| each["loops"].as_u64()).sum();
        assert_eq!(missing, 120);
    }
}

#[test]
fn results_are_reported_and_verified() {
    let folder = folder("detector-results");
    let method =
        |name: &str| format!("\"{}\" bench answer --method {name}", env!("CARGO_BIN_EXE_stiction"));
    for name in ["horch", "kano"] {
        let base =
            ["bench", "detector", &method(name), "--suite", "v1-trial", "--json", "--name", name];
        write(&folder, &format!("{name}.json"), run(&folder, &base).quiet_success());
    }
    let verified = run(&folder, &["bench", "verify", "horch.json", "kano.json"]).quiet_success();
    assert_eq!(verified.lines().count(), 2, "{verified}");
    assert!(
        verified.starts_with("horch.json: horch is verified. Suite v1-trial, 120 loops"),
        "{verified}"
    );
    let report = ["bench", "report", "horch.json", "kano.json", "-o", "page.html"];
    assert_eq!(run(&folder, &report).quiet_success(), "");
    let page = read(&folder, "page.html").replace("http://www.w3.org/2000/svg", "");
    for wanted in ["Leaderboard", "Differences", "Recall by evidence", "Loops to look at", "kano"] {
        assert!(page.contains(wanted), "{wanted}");
    }
    assert!(!page.contains("http://") && !page.contains("https://"), "nothing from elsewhere");
    let markdown = ["bench", "report", "horch.json", "kano.json", "--markdown"];
    let markdown = run(&folder, &markdown).quiet_success();
    assert!(markdown.contains("| horch | kano |"), "{markdown}");
    // Joined results hold both, and are verified again.
    let joined =
        run(&folder, &["bench", "report", "horch.json", "kano.json", "--json"]).quiet_success();
    write(&folder, "both.json", &joined);
    assert_eq!(run(&folder, &["bench", "verify", "both.json"]).quiet_success().lines().count(), 2);

    let horch = read(&folder, "horch.json");
    let better = horch.replacen("\"of_all\": 0.", "\"of_all\": 1.", 1);
    assert_ne!(better, horch);
    write(&folder, "better.json", better);
    let refused = run(&folder, &["bench", "verify", "better.json"]).refusal();
    assert!(
        refused.contains("horch: measures.auc.of_all does not follow from the answers"),
        "{refused}"
    );
    write(&folder, "none.json", "{}");
    let refused = run(&folder, &["bench", "report", "none.json", "-o", "none.html"]).refusal();
    assert!(refused.contains("none.json holds no results"), "{refused}");
}

#[test]
fn a_detector_is_measured_on_labelled_recordings() {
    let folder = crate::diagnose::with_samples("detector-labels");
    let index = "loop,label,tag,file,loop_type,source,licence,columns\n\
        FIC101,stiction,V1,renamed.csv,flow,simulated,CC0,op=valve demand; pv=x\n\
        FIC102-disturbed,no stiction,V2,,flow,,,\n";
    write(&folder, "index.csv", index);
    let sticky = read(&folder, "FIC101-sticky.csv");
    let (header, rest) = sticky.split_once('\n').expect("a header");
    let header: Vec<&str> = header
        .split(',')
        .map(|name| match name.trim().to_lowercase() {
            name if name.contains("op") => "valve demand",
            name if name.contains("pv") => "x",
            _ => name,
        })
        .collect();
    write(&folder, "renamed.csv", format!("{}\n{rest}", header.join(",")));
    let program = format!("\"{}\" bench answer", env!("CARGO_BIN_EXE_stiction"));
    let base = ["bench", "detector", &program, "--labels", "index.csv", "--json"];
    let results = run(&folder, &base).json();
    assert_eq!(results["loops"]["suite"], Value::Null);
    assert_eq!(results["loops"]["labels"][0]["licence"], "CC0");
    let answers = &results["entries"][0]["answers"];
    assert_eq!((&answers[0]["id"], &answers[0]["decision"]), (&"FIC101".into(), &"sticks".into()));
    write(&folder, "mine.json", results.to_string());
    run(&folder, &["bench", "verify", "mine.json"]).quiet_success();

    write(&folder, "index.csv", "loop,label\nFIC102-disturbed,no stiction\n");
    refuses(&folder, &base, "one class only");
    for (arguments, wanted) in [
        ("bench detector x --per-kind 3", "--per-kind"),
        ("bench detector x --method horch", "cannot be used with"),
        ("bench detector --suite v1-trial --labels index.csv", "cannot be used with"),
        ("bench detector --hidden --labels index.csv", "cannot be used with"),
        ("bench detector --limit 3 --suite v1-trial", "COMMAND"),
        ("bench detector x --limit 0", "above 0"),
        ("bench detector x --suite v9", "v1-trial"),
        ("bench verify", "required"),
    ] {
        refuses(&folder, &arguments.split(' ').collect::<Vec<_>>(), wanted);
    }
}

#[test]
fn an_answer_program_names_the_line_that_it_cannot_read() {
    let folder = folder("detector-answer");
    let mut command = command(&folder);
    write(&folder, "in.jsonl", "{\"id\":\"a\"}\n");
    let from = std::fs::File::open(folder.join("in.jsonl")).expect("a file");
    let done = command.args(["bench", "answer"]).stdin(from).output().expect("the command starts");
    let err = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_eq!(done.status.code(), Some(2));
    assert!(err.contains("standard input, line 1: not a recording as JSON"), "{err}");
}
