//! S where the range of the OP is not known, on every output; and remedies for numbers, modes and qualities, followed.

use crate::{command, folder, run, write};
use std::path::Path;

/// A recording of a sticky loop whose OP is written in another unit: `(value at 0 %, value at 100 %)`.
fn recording(folder: &Path, name: &str, unit: &str, (low, high): (f64, f64)) {
    let arguments = ["simulate", "samples/sticky-flow", "--columns", "t,sp,pv,op", "-o", "-"];
    let table = run(folder, &arguments).quiet_success();
    let mut lines = table.lines();
    let mut text = lines.next().expect("a header").to_owned() + "\n";
    if !unit.is_empty() {
        text += &format!("s,m3/h,m3/h,{unit}\n");
    }
    for line in lines {
        let (before, op) = line.rsplit_once(',').expect("an OP");
        let op: f64 = op.parse().expect("a number");
        text += &format!("{before},{}\n", low + op / 100.0 * (high - low));
    }
    write(folder, name, text);
}

/// S with its interval, from the JSON of a diagnosis.
fn s(folder: &Path, arguments: &[&str]) -> [f64; 3] {
    let json = run(folder, &[&["diagnose", "--json"], arguments].concat()).json();
    let found = json.pointer("/loops/0/stiction/S").or(json.pointer("/stiction/S"));
    let found = found.expect("an S").clone();
    ["value", "low", "high"].map(|end| found[end].as_f64().expect("a number"))
}

#[test]
fn a_guessed_range_is_with_s_on_every_output_and_its_interval_holds_the_truth() {
    let folder = folder("guessed-range");
    recording(&folder, "percent.csv", "%", (0.0, 100.0));
    let [truth, ..] = s(&folder, &["percent.csv"]);
    for (k, (unit, ends, value)) in [
        ("", (0.0, 27_648.0), Some(truth)),
        ("", (0.0, 1_000.0), Some(truth)),
        ("psi", (3.0, 15.0), Some(truth)),
        ("V", (1.0, 5.0), Some(truth)),
        ("", (4.0, 20.0), None),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("{k}.csv");
        recording(&folder, &name, unit, ends);
        let [found, low, high] = s(&folder, &[&name]);
        assert!(low <= truth && truth <= high, "{ends:?}: {found} ({low} to {high}) for {truth}");
        if let Some(value) = value {
            assert!((found - value).abs() < 0.02 * value, "{ends:?}: {found} for {value}");
        }
        let out = |more: &[&str]| {
            let done = command(&folder).arg("diagnose").args(more).arg(&name).output();
            String::from_utf8(done.expect("the command ends").stdout).expect("UTF-8")
        };
        for more in [&[][..], &["--brief"], &["--csv", "-"]] {
            assert!(out(more).contains("OP range ("), "{ends:?} {more:?}: {}", out(more));
        }
        let given = format!("{},{}", ends.0, ends.1);
        let [found, low, high] = s(&folder, &["--op-range", &given, &name]);
        assert!((found - truth).abs() < 0.02 * truth && high - low < truth, "{ends:?}: {found}");
        let brief = run(&folder, &["diagnose", "--brief", "--op-range", &given, &name]);
        assert!(!brief.out.contains("OP range"), "{}", brief.out);
    }
}

#[test]
fn remedies_for_marks_modes_and_qualities_work_as_they_are_printed() {
    let folder = folder("remedies-for-numbers");
    let table = |header: &str, cells: &[&str]| {
        let rows = (0..60).map(|k| format!("{k};{}\n", cells[k % cells.len()]));
        format!("t;{header}\n{}", rows.collect::<String>())
    };
    for (name, text, remedies) in [
        (
            "marks.csv",
            table("F.PV;F.OP", &["30;45", "1.000;46"]),
            &["--decimal-mark point", "--decimal-mark comma"][..],
        ),
        ("modes.csv", table("F.PV;F.OP;F.MODE", &["30,5;45;16"]), &["--mode \"16=auto\""]),
        (
            "qualities.csv",
            table("F.PV;F.OP;F.PV.Status", &["30,5;45;0"]),
            &["--quality \"0=good\"", "--quality \"0=bad\""],
        ),
    ] {
        write(&folder, name, text);
        let message = run(&folder, &["inspect", name]).refusal();
        for remedy in remedies {
            assert!(message.contains(remedy), "{remedy}: {message}");
            let (option, value) = remedy.split_once(' ').expect("an option and its value");
            let done = run(&folder, &["inspect", option, value.trim_matches('"'), name]);
            assert_eq!(done.code, 0, "{remedy}: {}", done.err);
        }
    }
}
