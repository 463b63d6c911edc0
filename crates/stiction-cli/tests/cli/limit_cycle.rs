//! `stiction limit-cycle`.

use crate::{column, folder, read, refuses, rows, run, write};

/// The paper's loop by flags.
const PAPER: [&str; 15] = [
    "limit-cycle",
    "--gain",
    "1.5",
    "--tau",
    "5.93",
    "--dead-time",
    "1.07",
    "--kc",
    "1.1",
    "--ti",
    "2.5",
    "--S",
    "5",
    "--J",
    "3",
];

#[test]
fn the_cycle_of_the_papers_loop_reads_like_this() {
    let folder = folder("limit-cycle");
    let expected = "\
The paper's loop under strong stiction (Figures 13 to 15)
process 1.5 exp(-1.07 s) / (5.93 s + 1); controller Kc 1.1, Ti 2.5 s; valve two-phase, S 5 %, J 3 %

                                        exact  describing function    error
period                              18.0437 s            19.2292 s   +6.6 %
half peak-to-peak OP                3.10801 %            2.97979 %   -4.1 %
half peak-to-peak VP                2.10801 %            2.49118 %  +18.2 %
half peak-to-peak PV                  1.99386              1.71374  -14.0 %
stable                                    yes                  yes
slips per period                            2                    2
deviation remaining after a period     0.1173                    -

percent per percent of  value           period      OP      VP      PV
S                       5 %             +0.560  +0.897  +0.137  +0.537
J                       3 %             -0.560  +0.103  +0.863  +0.463
Kc                      1.1 %/PV unit   -0.786  +0.183  +0.269  -0.317
Ti                      2.5 s           +0.377  -0.287  -0.424  -0.119
Kp                      1.5 PV units/%  -0.786  +0.183  +0.269  +0.683
theta                   1.07 s          -0.055  +0.285  +0.420  +0.340
tau                     5.93 s          +0.678  +0.003  +0.004  -0.221
";
    let arguments = ["limit-cycle", "paper/closed-loop", "--sensitivity"];
    assert_eq!(run(&folder, &arguments).quiet_success(), expected);
}

#[test]
fn no_cycle_is_a_result_with_its_reason() {
    let folder = folder("limit-cycle-none");
    let arguments = ["limit-cycle", "paper/closed-loop", "--set", "valve.J=0"];
    let text = run(&folder, &arguments).quiet_success();
    assert!(text.contains("No cycle (exact): decays: with dead band alone"), "{text}");
    assert!(text.contains("No cycle (describing function): a swing of any size decays"), "{text}");
    let json = run(&folder, &[&arguments[..], &["--json"]].concat()).json();
    assert_eq!(json["cycles"], serde_json::json!([]));
    assert_eq!(json["methods"][0]["state"], "no cycle");
    let done = run(&folder, &[&arguments[..], &["--plot", "none.svg"]].concat());
    assert_eq!(
        (done.code, done.err.as_str()),
        (0, "note: there is no exact cycle to draw or to write\n")
    );
}

#[test]
fn a_cycle_that_the_describing_function_misses_is_reported() {
    let folder = folder("limit-cycle-missed");
    let mut arguments = PAPER;
    (arguments[8], arguments[10]) = ("1.3", "10.5");
    let text = run(&folder, &arguments).quiet_success();
    assert!(text.contains("period                              21.3529 s"), "{text}");
    assert!(text.contains("misses this cycle"), "{text}");
}

#[test]
fn flags_and_scenario_are_the_same_loop() {
    let folder = folder("limit-cycle-json");
    let of = |arguments: &[&str]| run(&folder, &[arguments, &["--json"]].concat()).json();
    let (a, b) = (of(&PAPER), of(&["limit-cycle", "paper/closed-loop"]));
    assert_eq!(a["cycles"].as_array().map(Vec::len), Some(2));
    for (a, b) in a["cycles"].as_array().unwrap().iter().zip(b["cycles"].as_array().unwrap()) {
        for key in ["method", "period_s", "stable", "slips", "half_pp", "multipliers"] {
            assert_eq!(a[key], b[key], "{key}");
        }
    }
    assert_eq!(a["cycles"][0]["method"], "exact");
    assert!((a["cycles"][0]["half_pp"]["pv"].as_f64().unwrap() / 5.0 - 0.398771).abs() < 1e-5);
    let one = of(&[&PAPER[..], &["--describing-function"]].concat());
    assert_eq!(one["cycles"].as_array().map(Vec::len), Some(1));
    let integrating = "limit-cycle --gain 1 --integrating --kc 0.4 --ti 2 --S 5 --J 2";
    let period =
        of(&integrating.split(' ').collect::<Vec<_>>())["cycles"][0]["period_s"].as_f64().unwrap();
    assert!((period - 16.1491).abs() < 1e-3, "{period}");
}

#[test]
fn a_cycle_is_written_and_drawn() {
    let folder = folder("limit-cycle-files");
    let files = ["--csv", "c.csv", "--plot", "c.svg", "--nyquist", "n.svg"];
    run(&folder, &[&PAPER[..], &files].concat()).quiet_success();
    let csv = read(&folder, "c.csv");
    let (t, op, vp) = (column(&csv, "t"), column(&csv, "op"), column(&csv, "vp"));
    assert!(t.is_sorted() && (t[t.len() - 1] - 18.04367).abs() < 1e-5);
    let half = |values: &[f64]| {
        let fold = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        0.5 * (fold.1 - fold.0)
    };
    assert!((half(&op) - 3.10801).abs() < 1e-4 && (half(&vp) - 2.10801).abs() < 1e-5);
    // It closes, but for the slip that is due.
    assert!((op[0] - op[op.len() - 1]).abs() < 1e-9 && (vp[0] - vp[vp.len() - 1]).abs() < 1e-9);
    for (name, wanted) in [("c.svg", "set point SP"), ("n.svg", "T = 19.229 s")] {
        assert!(read(&folder, name).contains(wanted), "{name}");
    }
}

#[test]
fn a_map_has_every_point() {
    let folder = folder("limit-cycle-map");
    let map =
        ["--map", "S=1:9:5", "J=0:6:4", "--show", "period", "--csv", "m.csv", "--plot", "m.svg"];
    let text = run(&folder, &[&PAPER[..], &map].concat()).quiet_success();
    assert!(text.contains("15 points with a cycle, 5 without, 0 unknown"), "{text}");
    let csv = read(&folder, "m.csv");
    let (header, rows) = rows(&csv);
    assert_eq!(header[..4], ["S", "J", "state", "period_s"]);
    assert_eq!((rows.len(), rows[0][2], rows[5][2]), (20, "no cycle", "cycle"));
    let svg = read(&folder, "m.svg");
    for wanted in ["S (%)", "J (%)", "period (s)", "no cycle"] {
        assert!(svg.contains(wanted), "{wanted}");
    }
    let json = run(&folder, &[&PAPER[..], &map[..3], &["--json"]].concat()).json();
    assert_eq!(json["map"]["state"].as_array().map(Vec::len), Some(20));
    assert_eq!(json["map"]["boundary"].as_array().map(Vec::len), Some(5));
    assert!(json["map"]["period_s"][0].is_null());
}

#[test]
fn a_tuning_with_less_swing_has_its_price() {
    let folder = folder("limit-cycle-retune");
    let json =
        run(&folder, &[&PAPER[..], &["--retune", "--ms", "2", "--exact", "--json"]].concat())
            .json();
    let found = &json["retuning"];
    assert!(found["best"]["ms"].as_f64().unwrap() <= 2.0);
    assert!(found["pv_ratio"].as_f64().unwrap() < 0.8);
    assert!(found["iae_ratio"].as_f64().unwrap() > 1.0);
    let text = run(&folder, &[&PAPER[..], &["--retune", "--describing-function"]].concat())
        .quiet_success();
    assert!(text.contains("IAE of a load step of 1 %"), "{text}");
}

#[test]
fn what_is_no_loop_is_refused() {
    let folder = folder("limit-cycle-malformed");
    write(&folder, "bad.toml", "sample_time = 1\n");
    let flags = |changed: &[&'static str]| [&PAPER[..], changed].concat();
    let without = |name: &str| {
        let at = PAPER.iter().position(|part| *part == name).unwrap();
        [&PAPER[..at], &PAPER[at + 2..]].concat()
    };
    let cases: Vec<(Vec<&str>, &str)> = vec![
        (vec!["limit-cycle"], "<SCENARIO>"),
        (vec!["limit-cycle", "paper/flow-cascade"], "is a cascade"),
        (vec!["limit-cycle", "paper/open-loop-linear"], "is a valve on a test signal"),
        (vec!["limit-cycle", "no-such"], "no scenario file or built-in"),
        (vec!["limit-cycle", "bad.toml"], "bad.toml, line"),
        (vec!["limit-cycle", "paper/closed-loop", "--kc", "1"], "cannot be used with"),
        (without("--gain"), "lacks --gain"),
        (without("--kc"), "lacks --kc"),
        (without("--tau"), "lacks --tau"),
        (without("--S"), "needs --S"),
        (without("--J"), "needs --J"),
        (flags(&["--tau2", "-1"]), "-1"),
        (flags(&["--model", "sticky"]), "no valve model named \"sticky\""),
        (flags(&["--model", "chen", "--exact"]), "Chen"),
        (flags(&["--map", "S=1:9", "S=1:9"]), "vary the same quantity"),
        (flags(&["--map", "S=1:9", "J/K=1:9"]), "parameter of a loop"),
        (flags(&["--map", "S=1", "J=1:9"]), "write NAME=FROM:TO:POINTS"),
        (flags(&["--map", "S", "J=1:9"]), "write NAME=FROM:TO:POINTS"),
        (flags(&["--map", "S=1:x", "J=1:9"]), "write NAME=FROM:TO:POINTS"),
        (flags(&["--map", "S=1:9:1", "J=1:9"]), "1 points, but must be 2 to 2000"),
        (flags(&["--map", "S=1:9:-3", "J=1:9"]), "write NAME=FROM:TO:POINTS"),
        (flags(&["--map", "S=1:nan", "J=1:9"]), "must be"),
        (flags(&["--map", "S=2:2", "J=1:9"]), "the range is empty"),
        (flags(&["--map", "S=1:9"]), "2 values required"),
        (flags(&["--show", "op"]), "--map"),
        (flags(&["--ms", "2"]), "--retune"),
        (flags(&["--retune", "--ms", "1"]), "above 1"),
        (flags(&["--plot", "c.gif"]), "--plot c.gif: the file must end in .svg or .png"),
        (flags(&["--nyquist", "c.gif"]), "--nyquist c.gif"),
    ];
    for (arguments, expected) in cases {
        refuses(&folder, &arguments, expected);
    }
}
