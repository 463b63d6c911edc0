//! `stiction simulate`.

use crate::{BUILT_IN, column, command, folder, read, rows, run, write};
use serde_json::Value;
use std::path::Path;

fn number(json: &Value, path: &str) -> f64 {
    json.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {json}"))
}

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found}, but expected {expected}");
}

/// An open-loop scenario whose valve is described by `valve`.
fn open_loop(valve: &str) -> String {
    format!(
        "sample_time = 1\nduration = 4\n[input]\nsignal = \"steps\"\n\
         steps = [[0, 0], [1, 10], [2, 200], [3, -50]]\n[valve]\n{valve}\n"
    )
}

#[test]
fn every_built_in_fills_the_columns_it_has() {
    let folder = folder("built-in");
    for name in BUILT_IN {
        // A cascade has other columns than the run before.
        let simulate = ["simulate", name, "--json", "-o", "run.csv", "--force"];
        let json = run(&folder, &simulate).json();
        assert_eq!(json["scenario"], name);
        assert_eq!(json["title"], json["settings"]["title"]);

        let csv = read(&folder, "run.csv");
        let (header, rows) = rows(&csv);
        assert_eq!(header[..5], ["t", "sp", "pv", "op", "vp"], "{name}");
        let samples = number(&json, "/settings/duration") / number(&json, "/settings/sample_time");
        assert_eq!(rows.len(), samples.round() as usize, "{name}");
        let times = column(&csv, "t");
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{name}");
        assert!(rows.iter().all(|row| !row[3].is_empty() && !row[4].is_empty()), "{name}");

        // The signals an open loop lacks stay empty; a cascade has two more.
        let is_loop = !name.contains("open-loop") && !name.contains("step-");
        assert!(
            rows.iter().all(|row| (!row[1].is_empty() && !row[2].is_empty()) == is_loop),
            "{name}"
        );
        let more: &[&str] =
            if name.contains("cascade") { &["master_sp", "master_pv"] } else { &[] };
        assert_eq!(header[5..], *more, "{name}");
    }
}

/// On a slow ramp the position trails by `fd = (S - J) / 2`, so its half peak-to-peak value is that
/// much less than the ramp's 15 %.
#[test]
fn a_sliding_valve_trails_its_input() {
    let folder = folder("open-loop");
    for (name, s, j) in [("linear", 0.0002, 0.0), ("deadband", 5.0, 0.0), ("stiction", 5.0, 2.0)] {
        let json = run(&folder, &["simulate", &format!("paper/open-loop-{name}"), "--json"]).json();
        assert_near(number(&json, "/half_pp/op"), 15.0, 1e-9);
        assert_near(number(&json, "/half_pp/vp"), 15.0 - (s - j) / 2.0, 1e-9);
        assert!(json["half_pp"]["pv"].is_null());
    }
}

/// An independent simulation of the same recursion gives these numbers.
#[test]
fn the_papers_loop_cycles_as_the_reference_does() {
    let folder = folder("closed-loop");
    let arguments =
        ["simulate", "paper/closed-loop", "--set", "valve.S=5", "--set", "valve.J=1", "--json"];
    let json = run(&folder, &arguments).json();
    assert_eq!(number(&json, "/settings/duration"), 600.0);
    assert_near(number(&json, "/period_s"), 32.62354456759, 1e-11 * 32.0);
    assert_near(number(&json, "/half_pp/op"), 2.84347, 5e-6);
    assert_near(number(&json, "/half_pp/vp"), 0.84347, 5e-6);
    assert_near(number(&json, "/half_pp/pv"), 1.10469, 5e-6);
}

#[test]
fn the_summary_reads_like_this() {
    let folder = folder("summary");
    let arguments = ["simulate", "paper/closed-loop", "--set", "valve.J=1", "--set", "title=Mine"];
    let expected = "Mine\n\
                    period                32.6235 s\n\
                    half peak-to-peak OP  2.84347 %\n\
                    half peak-to-peak VP  0.84347 %\n\
                    half peak-to-peak PV  1.10469\n\
                    PV swing, last over previous quarter: 0.999 (persists)\n\
                    (over the last half of the run)\n";
    assert_eq!(run(&folder, &arguments).quiet_success(), expected);
}

#[test]
fn a_printed_scenario_is_the_same_scenario() {
    let folder = folder("round-trip");
    let settings = ["--set", "title=changed", "--set", "sample_time=0.5"];
    for name in BUILT_IN {
        let printed = run(&folder, &[&["simulate", name, "--print"][..], &settings].concat());
        write(&folder, "mine.toml", printed.quiet_success());
        let results = |scenario: &str, settings: &[&str]| {
            let arguments =
                [&["simulate", scenario, "--json", "-o", "run.csv", "--force"][..], settings];
            let mut json = run(&folder, &arguments.concat()).json();
            assert_eq!(json["title"], "changed");
            json["scenario"].take();
            (json, read(&folder, "run.csv"))
        };
        assert!(results(name, &settings) == results("mine.toml", &[]), "{name}");
    }
}

#[test]
fn a_built_in_is_printed_as_it_is() {
    let folder = folder("print");
    let printed = run(&folder, &["simulate", "paper/closed-loop", "--print"]).quiet_success();
    assert_eq!(
        printed,
        include_str!("../../../stiction-io/scenarios/paper/closed-loop.toml"),
        "comments and all"
    );
}

#[test]
fn set_changes_and_adds_any_key() {
    let folder = folder("set");
    write(
        &folder,
        "mine.toml",
        open_loop("S = 5 # percent\nJ = 2").replace("[input]", "start = 1\n[input]"),
    );
    // Setting, where it then is in the JSON, and what is there.
    let cases = [
        ("valve.S=4.5", "/valve/S", "4.5"),
        ("valve.model=kano", "/valve/model", "\"kano\""),
        ("valve.model=\"kano\"", "/valve/model", "\"kano\""),
        ("valve.limits=[0, 90]", "/valve/limits", "[0,90]"),
        (" duration = 3 ", "/duration", "3"),
        ("start=-2e1", "/start", "-20.0"),
        ("title=two words", "/title", "\"two words\""),
        ("input.steps=[[0, 1], [3, 2]]", "/input/steps", "[[0,1],[3,2]]"),
    ];
    for (setting, path, expected) in cases {
        let json = run(&folder, &["simulate", "mine.toml", "--set", setting, "--json"]).json();
        let found = json["settings"].pointer(path).map(Value::to_string);
        assert_eq!(found.as_deref(), Some(expected), "{setting}");
    }
    // The comment, which tells the unit, stays.
    let printed = run(&folder, &["simulate", "mine.toml", "--set", "valve.S=4", "--print"]);
    assert!(printed.quiet_success().contains("\nS = 4 # percent\n"));
}

#[test]
fn set_reaches_into_tables_in_tables_and_lists_of_tables() {
    let folder = folder("set-nested");
    let settings = |arguments: &[&str]| {
        let mut all = vec!["simulate", "paper/flow-cascade", "--json"];
        all.extend(arguments.iter().flat_map(|setting| ["--set", *setting]));
        run(&folder, &all).json()["settings"].take()
    };
    let changed = settings(&["master.process.tau=30", "master.noise.sd=0.01"]);
    assert_eq!(changed["master"]["process"]["tau"], 30);
    assert_eq!(changed["master"]["noise"]["sd"], 0.01);
    // Lists of tables: added to, and changed.
    let changed = settings(&["load.0.value=1", "load.1.value=2", "load.0.value=3"]);
    assert_eq!(changed["load"].to_string(), r#"[{"value":3},{"value":2}]"#);

    // Written inline, a list of tables is as good.
    let text = run(&folder, &["simulate", "paper/closed-loop", "--print"]).quiet_success();
    write(&folder, "inline.toml", format!("load = [{{ value = 1 }}, {{ value = 2 }}]\n{text}"));
    let json = run(&folder, &["simulate", "inline.toml", "--set", "load.1.value=5", "--json"]);
    assert_eq!(json.json()["settings"]["load"].to_string(), r#"[{"value":1},{"value":5}]"#);
}

#[test]
fn the_valves_surroundings_do_what_they_say() {
    let folder = folder("surroundings");
    let vp = |valve: &str| {
        write(&folder, "mine.toml", open_loop(valve));
        column(&run(&folder, &["simulate", "mine.toml", "-o", "-"]).quiet_success(), "vp")
    };
    assert_eq!(vp("S = 5\nJ = 2"), [0.0, 8.5, 198.5, -48.5]);
    // The same by static and dynamic friction band.
    assert_eq!(vp("fs = 3.5\nfd = 1.5"), [0.0, 8.5, 198.5, -48.5]);
    // Clipped input, and a stem that trails it by fd.
    assert_eq!(vp("S = 5\nJ = 2\nlimits = [0, 100]"), [0.0, 8.5, 98.5, 1.5]);
    // A slip of K (10 - fd).
    assert_eq!(vp("model = \"he-wang\"\nS = 5\nJ = 2\nK = 1.5")[1], 12.75);
    // The lag sees its input a sample later, then closes in by 1 - exp(-Ts/tau).
    let lagged = vp("S = 5\nJ = 2\nlag = 2");
    let part = 1.0 - (-0.5f64).exp();
    assert_eq!(lagged[..2], [0.0, 0.0]);
    assert_near(lagged[2], 8.5 * part, 1e-12);
    assert_near(lagged[3], 8.5 * part + (198.5 - 8.5 * part) * part, 1e-12);
}

#[test]
fn signals_come_from_files_with_the_scenario() {
    let folder = folder("file-signal");
    std::fs::create_dir(folder.join("sub")).expect("a folder");
    write(&folder, "sub/op.csv", "t,u\n0,0\n1,10\n2,20\n3,0\n");
    let scenario = "sample_time = 1\nduration = 4\n[input]\nsignal = \"file\"\nfile = \"op.csv\"\n\
                    column = \"u\"\n[valve]\nS = 5\nJ = 2\n";
    write(&folder, "sub/mine.toml", scenario);
    let csv = run(&folder, &["simulate", "sub/mine.toml", "-o", "-"]).quiet_success();
    assert_eq!(column(&csv, "op"), [0.0, 10.0, 20.0, 0.0]);
    assert_eq!(column(&csv, "vp"), [0.0, 8.5, 18.5, 1.5]);
}

#[test]
fn notes_tell_what_has_no_effect() {
    let folder = folder("notes");
    write(&folder, "mine.toml", open_loop("model = \"play\"\nS = 4\nJ = 2"));
    let done = run(&folder, &["simulate", "mine.toml", "--json"]);
    let expected = "note: valve.J has no effect: play does not use it\n";
    assert_eq!((done.code, done.err.as_str()), (0, expected));
}

#[test]
fn list_names_the_built_in_scenarios() {
    let list = run(&folder("list"), &["simulate", "--list"]).quiet_success();
    let names: Vec<_> = list.lines().filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(names, BUILT_IN);
    let titled = |line: &str| line.split_once(' ').is_some_and(|(_, title)| title.trim().len() > 9);
    assert!(list.lines().all(titled), "{list}");
}

#[test]
fn times_are_written_without_rounding_dust() {
    let folder = folder("times");
    let times = |sample_time: &str, duration: &str| {
        let text = open_loop("S = 5\nJ = 2")
            .replace("time = 1", &format!("time = {sample_time}"))
            .replace("duration = 4", &format!("duration = {duration}"));
        write(&folder, "mine.toml", text);
        let csv = run(&folder, &["simulate", "mine.toml", "-o", "-"]).quiet_success();
        rows(&csv).1.iter().map(|row| row[0].to_owned()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(times("0.1", "0.7"), "0 0.1 0.2 0.3 0.4 0.5 0.6");
    assert_eq!(times("1e9", "3e9"), "0 1000000000 2000000000");
    assert_eq!(times("2e-12", "6e-12"), "0 0.000000000002 0.000000000004");
}

#[test]
fn plots_are_pictures() {
    let folder = folder("plots");
    for name in ["paper/open-loop-stiction", "paper/closed-loop", "paper/flow-cascade"] {
        run(&folder, &["simulate", name, "--plot", "a.svg"]).quiet_success();
        assert!(read(&folder, "a.svg").starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
        assert!(read(&folder, "a.svg").trim_end().ends_with("</svg>"));
        run(&folder, &["simulate", name, "--plot", "a.PNG"]).quiet_success();
        let png = std::fs::read(folder.join("a.PNG")).expect("a picture");
        assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    }
}

#[test]
fn the_number_of_threads_makes_no_difference() {
    let folder = folder("threads");
    let outputs = |threads: &str| {
        BUILT_IN.map(|name| {
            let output = command(&folder)
                .env("RAYON_NUM_THREADS", threads)
                .args(["simulate", name, "-o", "-", "--json", "--plot", "a.svg"])
                .output()
                .expect("the command starts");
            assert!(output.status.success());
            (output.stdout, read(&folder, "a.svg"))
        })
    };
    assert!(outputs("1") == outputs("2"));
}

#[test]
fn the_sample_recordings_come_out_of_their_scenarios() {
    let here = folder("sample-recordings");
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples");
    let truth = std::fs::read_to_string(samples.join("truth.csv")).unwrap();
    assert_eq!(truth.lines().count(), 6);
    for row in truth.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let (file, scenario) = (cells[0], cells[6]);
        let made = run(&here, &["simulate", scenario, "--columns", "t,sp,pv,op", "-o", "-"]);
        let kept = std::fs::read_to_string(samples.join(file)).unwrap();
        assert!(made.quiet_success() == kept, "{file} differs from {scenario}");
        // The truth is that of the scenario.
        let settings = run(&here, &["simulate", scenario, "--json"]).json();
        let valve = &settings["settings"]["valve"];
        assert_eq!(valve["model"], cells[2]);
        for (key, cell) in [("S", cells[3]), ("J", cells[4])] {
            assert_eq!(valve[key].as_f64().unwrap_or(0.0), cell.parse::<f64>().unwrap(), "{file}");
        }
    }
}

#[test]
fn columns_are_chosen_by_name() {
    let here = folder("chosen-columns");
    let csv = run(&here, &["simulate", "paper/step-linear", "--columns", "vp,t", "-o", "-"])
        .quiet_success();
    assert_eq!(csv.lines().next(), Some("vp,t"));
    let refused =
        run(&here, &["simulate", "paper/step-linear", "--columns", "t,mv", "-o", "-"]).refusal();
    assert!(refused.contains("no column \"mv\"; there are t, sp, pv, op, vp"), "{refused}");
}
