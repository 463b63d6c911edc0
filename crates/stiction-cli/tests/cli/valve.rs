//! `stiction valve`.

use crate::{column, folder, read, rows, run, write};
use std::io::Read;

/// Every model and pair of S and J of an independent reference, on each of its inputs, through
/// files and the command line.
#[test]
fn valve_reproduces_the_reference() {
    let packed = include_bytes!("../../../stiction-model/tests/fixtures/open_loop_models.csv.gz");
    let mut text = String::new();
    flate2::read::GzDecoder::new(&packed[..]).read_to_string(&mut text).expect("a gzip file");
    let (header, rows) = rows(&text);

    // One file an input, with the column u the valves are driven with.
    let folder = folder("reference");
    let mut inputs: Vec<(&str, Vec<&Vec<&str>>)> = vec![];
    for row in &rows {
        match inputs.last_mut() {
            Some((name, rows)) if *name == row[0] => rows.push(row),
            _ => inputs.push((row[0], vec![row])),
        }
    }
    assert_eq!(inputs.len(), 6);
    for (name, rows) in &inputs {
        let lines: Vec<_> = rows.iter().map(|row| format!("{},{}", row[1], row[2])).collect();
        write(&folder, &format!("{name}.csv"), format!("k,u\n{}\n", lines.join("\n")));
    }

    let mut compared = 0;
    let mut worst = 0.0f64;
    for (index, case) in header.iter().enumerate().skip(3) {
        let parts: Vec<_> = case.split('_').collect();
        let (model, s, j) = (parts[0], &parts[1][1..], &parts[2][1..]);
        for (name, rows) in &inputs {
            let file = format!("{name}.csv");
            let done = run(
                &folder,
                &["valve", "--model", model, "--S", s, "--J", j, "--start", "0", "--column", "u"]
                    .into_iter()
                    .chain([file.as_str(), "-o", "out.csv"])
                    .collect::<Vec<_>>(),
            );
            assert_eq!((done.code, done.out.as_str()), (0, ""), "{case} on {name}: {}", done.err);
            let vp = column(&read(&folder, "out.csv"), "vp");
            assert_eq!(vp.len(), rows.len());
            for (row, vp) in rows.iter().zip(vp) {
                let expected: f64 = row[index].parse().expect("a number");
                let difference = (vp - expected).abs();
                assert!(difference <= 1e-12, "{case} on {name} at {}: {vp}, {expected}", row[1]);
                worst = worst.max(difference);
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 7 * 6 * 6 * 1200, "largest difference {worst}");
}

#[test]
fn valve_adds_a_column_and_leaves_the_rest() {
    let folder = folder("valve-rows");
    let input = "time;note;u\n0;\"a; b\";50\n0.5;;53\n1.0;\"he said \"\"hm\"\"\";56\n1.5;-0;58\n";
    write(&folder, "in.csv", input);
    let arguments = ["valve", "--S", "5", "--J", "2", "in.csv"];
    let out = run(&folder, &arguments).quiet_success();
    // fs = 3.5, fd = 1.5: 53 does not break away, 56 does, 58 slides on.
    let expected = "time;note;u;vp\n0;\"a; b\";50;50\n0.5;;53;50\n1.0;\"he said \"\"hm\"\"\";56;54.5\n\
                    1.5;-0;58;56.5\n";
    assert_eq!(out, expected);
    run(&folder, &[&arguments[..], &["-o", "out.csv"]].concat()).quiet_success();
    assert_eq!(read(&folder, "out.csv"), expected);
    assert_eq!(run(&folder, &[&arguments[..], &["-o", "-"]].concat()).quiet_success(), expected);
}

#[test]
fn valve_takes_windows_files() {
    let folder = folder("valve-windows");
    write(&folder, "in.csv", "\u{feff}t,u\r\n0,0\r\n1,4\r\n");
    let out = run(&folder, &["valve", "--S", "5", "--J", "2", "in.csv"]).quiet_success();
    assert_eq!(out, "t,u,vp\n0,0,0\n1,4,2.5\n");
}

#[test]
fn valve_starts_at_the_given_position() {
    let folder = folder("valve-start");
    write(&folder, "in.csv", "op\n10\n12\n");
    let vp = |more: &[&str]| {
        let arguments = ["valve", "--S", "5", "--J", "2", "--column", "op", "in.csv"];
        column(&run(&folder, &[&arguments[..], more].concat()).quiet_success(), "vp")
    };
    assert_eq!(vp(&[]), [10.0, 10.0]);
    assert_eq!(vp(&["--start", "0"]), [8.5, 10.5]);
    assert_eq!(vp(&["--start", "-20"]), [8.5, 10.5]);
    assert_eq!(vp(&["--start", "9"]), [9.0, 9.0]);
}

#[test]
fn valve_overshoots_by_k() {
    let folder = folder("valve-k");
    write(&folder, "in.csv", "u\n0\n10\n");
    let run = |k: &str| {
        run(&folder, &["valve", "--model", "he-wang", "--S", "5", "--J", "2", "--K", k, "in.csv"])
    };
    // A slip of 10 - fd = 8.5 times K.
    assert_eq!(column(&run("1").quiet_success(), "vp")[1], 8.5);
    assert_eq!(column(&run("1.5").quiet_success(), "vp")[1], 12.75);
    assert!(run("2.5").refusal().contains("K is 2.5, but must be between 1"));
}

#[test]
fn valve_tells_what_has_no_effect() {
    let folder = folder("valve-note");
    write(&folder, "in.csv", "u\n0\n10\n");
    let done = run(&folder, &["valve", "--model", "play", "--S", "4", "--J", "2", "in.csv"]);
    assert_eq!((done.code, done.err.as_str()), (0, "note: model play does not use --J\n"));
    assert_eq!(column(&done.out, "vp"), [0.0, 8.0]);
}

#[test]
fn valve_lists_its_models() {
    let folder = folder("valve-list");
    let list = run(&folder, &["valve", "--list"]).quiet_success();
    let names: Vec<_> = list
        .lines()
        .filter(|line| !line.starts_with(' '))
        .map(|line| line.split(' ').next().unwrap_or(""))
        .collect();
    assert_eq!(names.len(), 9);
    write(&folder, "in.csv", "u\n0\n10\n");
    for name in names {
        let done = run(&folder, &["valve", "--model", name, "--S", "4", "--J", "2", "in.csv"]);
        assert_eq!(done.code, 0, "{name}: {}", done.err);
    }
}
