//! `stiction schema`.

use super::diagnose::{samples, violations, with_samples};
use super::{folder, paper, run};

/// Documents, each with a command that prints it.
fn printed() -> Vec<(&'static str, Vec<&'static str>)> {
    let file = "FIC101-sticky.csv";
    let map = ["--json", "--map", "S=1:9:3", "J=0:4:3", "--sensitivity", "--retune"];
    vec![
        ("diagnosis", vec!["diagnose", file, "--json"]),
        ("history", vec!["history", file, "--window", "5min", "--repair", "1200", "--json"]),
        ("fit", vec!["fit", file, "--json"]),
        ("inspect", vec!["inspect", file, "--json"]),
        ("bench", vec!["bench", "simulated", "4", "--only", "verdict", "--time", "--json"]),
        (
            "bench-results",
            vec![
                "bench", "detector", "--suite", "v1-trial", "--method", "horch", "--method",
                "kano", "--json",
            ],
        ),
        ("bench-networks", vec!["bench", "networks", "1", "--days", "1", "--json"]),
        ("bench-tests", vec!["bench", "tests", "3", "--json"]),
        ("test-plan", vec!["test", "plan", file, "--json"]),
        ("test-read", vec!["test", "read", "FIC106-tested.csv", "--json"]),
        (
            "test-compare",
            vec!["test", "read", "FIC106-tested.csv", "--before", "FIC106-tested.csv", "--json"],
        ),
        ("signature-plan", vec!["test", "plan", file, "--signature", "--json"]),
        ("signature-read", vec!["test", "read", "ramped.csv", "--json"]),
        (
            "signature-compare",
            vec!["test", "read", "ramped.csv", "--before", "ramped.csv", "--json"],
        ),
        ("plant-check", vec!["plant", "-C", "north", "check", "--json"]),
        ("plant-scan", vec!["plant", "-C", "north", "scan", "--json"]),
        ("plant-report", vec!["plant", "-C", "north", "report", "--json"]),
        ("plant-orders", vec!["plant", "-C", "north", "orders", "--json"]),
        ("plant-status", vec!["plant", "-C", "north", "status", "--json"]),
        ("stem", vec!["stem", "--json"]),
        ("simulate", vec!["simulate", "paper/closed-loop", "--json"]),
        ("simulate", vec!["simulate", "paper/step-linear", "--json"]),
        ("compensate", paper("compensate", &["--method", "knocker", "--json"])),
        ("what-if", paper("what-if", &["--json"])),
        ("limit-cycle", paper("limit-cycle", &["--json"])),
        ("limit-cycle", paper("limit-cycle", &map)),
        ("fmu-models", vec!["fmu", "--list", "--json"]),
        ("prospects", vec!["what-if", file, "--json"]),
        ("fmu-variables", vec!["fmu", "--variables", "--json"]),
    ]
}

#[test]
fn what_is_printed_is_as_its_schema_says() {
    let folder = with_samples("schema-printed");
    let tested = samples().join("test/FIC106-tested.csv");
    std::fs::copy(tested, folder.join("FIC106-tested.csv")).expect("a copy");
    let ramp = |k: i32| f64::from(50 - (k % 400 - 200).abs() / 4);
    let rows = (0..800).map(|k| format!("{k},{},{}\n", ramp(k), ramp(k - 4)));
    std::fs::write(
        folder.join("ramped.csv"),
        format!("time_s,OP,VP\n{}", rows.collect::<String>()),
    )
    .expect("a recording with ramps");
    run(&folder, &["plant", "demo", "--loops", "1", "--days", "1", "-o", "north"]).quiet_success();
    let printed = printed();
    for (document, arguments) in &printed {
        let schema = run(&folder, &["schema", document]).json();
        let json = run(&folder, arguments).json();
        assert_eq!(violations(&json, &schema, &schema, document), Vec::<String>::new());
    }
    // None is left out: a refusal lists those that there are.
    let refused = run(&folder, &["schema", "none-such"]).refusal();
    let known = refused.split_once("[possible values: ").and_then(|(_, rest)| rest.split_once(']'));
    for name in known.expect("a list").0.split(", ") {
        assert!(printed.iter().any(|(document, _)| *document == name), "{name} is not tested");
    }
}

#[test]
fn a_schema_has_a_name() {
    let folder = folder("schema-names");
    let diagnosis = run(&folder, &["schema", "diagnosis"]).quiet_success();
    assert!(diagnosis == run(&folder, &["diagnose", "--schema"]).quiet_success());
    let refused = run(&folder, &["schema", "verdict"]).refusal();
    assert!(refused.contains("diagnosis") && refused.contains("history"), "{refused}");
}
