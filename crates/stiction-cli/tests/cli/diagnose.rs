//! `stiction diagnose`.

use crate::{folder, read, refuses, run, write};
use serde_json::Value;
use std::path::{Path, PathBuf};

pub fn sample(name: &str) -> String {
    samples().join(name).display().to_string()
}

pub fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples")
}

/// The five sample recordings, copied beside each other.
pub fn with_samples(name: &str) -> PathBuf {
    let folder = folder(name);
    for entry in std::fs::read_dir(samples()).expect("the samples") {
        let path = entry.expect("a file").path();
        let name = path.file_name().expect("a name").to_owned();
        if path.is_file() {
            std::fs::copy(&path, folder.join(name)).expect("a copy");
        }
    }
    folder
}

const LOOPS: [&str; 5] = [
    "FIC101-sticky.csv",
    "FIC102-disturbed.csv",
    "FIC103-aggressive.csv",
    "LIC104-quantised.csv",
    "FIC105-cascade.csv",
];

#[test]
fn one_loop_fits_one_screen() {
    let folder = with_samples("diagnose-one");
    let text = run(&folder, &["diagnose", "FIC101-sticky.csv"]).quiet_success();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "FIC101-sticky (flow)  FIC101-sticky.csv");
    assert!(
        lines[1].starts_with("verdict   STICKS: The valve most likely sticks (99 %)."),
        "{text}"
    );
    for wanted in [
        "data      2400 samples of 1 s, 40 min in all\n          - Data: fit",
        "  PV swings                     ±1.4 PV units every 74 s",
        "method  ",
        "Horch's cross-correlation ",
        "undecided",
        "abstain   direct, yamashita-vp: needs the valve position, which is not recorded",
        "service factor",
        "Harris index",
    ] {
        assert!(text.contains(wanted), "\"{wanted}\" is missing in:\n{text}");
    }
    assert!(lines.len() <= 66, "{} lines", lines.len());
    assert!(lines.iter().all(|line| line.chars().count() <= 100), "{text}");
}

#[test]
fn several_loops_are_ranked_the_worst_first() {
    let folder = with_samples("diagnose-several");
    let one_order = run(&folder, &[&["diagnose"][..], &LOOPS].concat()).quiet_success();
    let mut backwards = LOOPS;
    backwards.reverse();
    assert_eq!(one_order, run(&folder, &[&["diagnose"][..], &backwards].concat()).quiet_success());
    let rows: Vec<Vec<&str>> =
        one_order.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(rows[0][..4], ["loop", "type", "verdict", "p(sticks)"]);
    for sticky in &rows[1..3] {
        assert!(["FIC101-sticky", "FIC105-cascade"].contains(&sticky[0]), "{one_order}");
        assert_eq!(sticky[2], "sticks");
    }
    assert!(one_order.contains("5 loops: 2 sticks, "), "{one_order}");
}

#[test]
fn truth_and_verdicts_of_the_samples() {
    let folder = with_samples("diagnose-truth");
    let truth = read(&folder, "truth.csv");
    for row in truth.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        let json = run(&folder, &["diagnose", cells[0], "--json"]).json();
        let class = &json["loops"][0]["verdict"]["class"];
        // No healthy valve is accused, and no sticking one cleared.
        let wrong = if cells[1] == "stiction" { "does not stick" } else { "sticks" };
        assert_ne!(class, wrong, "{row}");
    }
}

#[test]
fn a_table_of_a_folder_that_is_no_recording_is_skipped() {
    let folder = with_samples("diagnose-skipped");
    for command in [&["diagnose", "--brief"][..], &["inspect"]] {
        let all = run(&folder, &[command, &["."]].concat());
        assert_eq!(all.code, 0, "{}", all.err);
        assert!(all.err.contains("truth.csv is not a recording and is skipped"), "{}", all.err);
        assert!(all.out.contains("FIC101-sticky"), "{}", all.out);
        let named = run(&folder, &[command, &["FIC101-sticky.csv", "truth.csv"]].concat());
        assert!(named.code == 2 && named.err.contains("truth.csv: has no column"), "{}", named.err);
    }
}

#[test]
fn json_says_what_the_issue_promised() {
    let folder = with_samples("diagnose-json");
    let json = run(&folder, &["diagnose", "FIC101-sticky.csv", "--json"]).json();
    let found = &json["loops"][0];
    assert_eq!(found["loop"], "FIC101-sticky");
    assert_eq!(found["type"], "flow");
    assert_eq!(found["fitness"]["class"], "fit");
    assert!(found["fitness"]["reasons"].as_array().is_some());
    let period = found["oscillation"]["period_s"].as_f64().expect("a period");
    assert!((70.0..80.0).contains(&period));
    assert!(found["oscillation"]["regularity"].as_f64().is_some_and(|r| r > 1.0));
    let detectors = found["detectors"].as_array().expect("detectors");
    assert!(detectors.len() >= 20);
    for detector in detectors {
        let abstains = detector["decision"] == "abstains";
        assert!(detector["name"].is_string() && detector["reason"].is_string());
        assert!(abstains || detector["statistic"].is_number(), "{detector}");
        assert!(!detector["reason"].as_str().expect("a reason").is_empty());
    }
    assert_eq!(found["verdict"]["class"], "sticks");
    assert!(found["verdict"]["probability"].as_f64().is_some_and(|p| p > 0.9));
    assert!(!found["verdict"]["reasons"].as_array().expect("reasons").is_empty());
    // The first turn is a third of the lower end of S.
    assert_eq!(found["verdict"]["confirm"]["grow"][0]["op"], 0.56);
    // S is 4 %, J 2 %: see truth.csv.
    let s = &found["stiction"]["S"];
    let [low, value, high] =
        ["low", "value", "high"].map(|name| s[name].as_f64().expect("a number"));
    assert!(low <= 4.0 && 4.0 <= high && (value - 4.0).abs() < 0.5, "{s}");
    assert!(found["stiction"]["J"].is_object() || found["stiction"]["why_not"].is_string());
    assert_eq!(found["source"]["sha256"].as_str().map(str::len), Some(64));
}

/// What is wrong with `value` by `schema`: enough of JSON Schema for ours.
pub fn violations(value: &Value, schema: &Value, root: &Value, place: &str) -> Vec<String> {
    if let Some(reference) = schema["$ref"].as_str() {
        let name = reference.trim_start_matches("#/$defs/");
        return violations(value, &root["$defs"][name], root, place);
    }
    if let Some(options) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
        let fits = options.iter().any(|option| violations(value, option, root, place).is_empty());
        return if fits { vec![] } else { vec![format!("{place} fits none of its forms")] };
    }
    let kinds: Vec<&str> = match &schema["type"] {
        Value::String(kind) => vec![kind],
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
        _ => return vec![format!("{place} has no type in the schema")],
    };
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(n) if n.is_u64() && kinds.contains(&"integer") => "integer",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    if !kinds.contains(&kind) {
        return vec![format!("{place} is of type {kind}, not {kinds:?}")];
    }
    let mut wrong = vec![];
    if let Value::Array(items) = value {
        for (k, item) in items.iter().enumerate() {
            wrong.extend(violations(item, &schema["items"], root, &format!("{place}[{k}]")));
        }
    }
    if let Value::Object(fields) = value {
        for required in schema["required"].as_array().into_iter().flatten() {
            if !fields.contains_key(required.as_str().expect("a name")) {
                wrong.push(format!("{place} lacks {required}"));
            }
        }
        for (name, field) in fields {
            match schema["properties"].get(name) {
                Some(schema) => {
                    wrong.extend(violations(field, schema, root, &format!("{place}.{name}")));
                }
                None => match &schema["additionalProperties"] {
                    Value::Bool(true) => {}
                    each if each.is_object() => {
                        wrong.extend(violations(field, each, root, &format!("{place}.{name}")));
                    }
                    _ => wrong.push(format!("{place}.{name} is not in the schema")),
                },
            }
        }
    }
    wrong
}

#[test]
fn json_is_as_the_schema_says() {
    let folder = with_samples("diagnose-schema");
    let schema = run(&folder, &["diagnose", "--schema"]).json();
    let mut arguments = [&["diagnose"][..], &LOOPS, &["--json"]].concat();
    let json = run(&folder, &arguments).json();
    assert_eq!(violations(&json, &schema, &schema, "document"), Vec::<String>::new());
    // Without PV, and with a valve position: the forms that samples do not have.
    let op: String = (0..200).map(|k| format!("{k},{}\n", 50 + k % 7)).collect();
    write(&folder, "op-only.csv", format!("t,op\n{op}"));
    let vp: String = (0..400)
        .map(|k| {
            let op = 50.0 + 10.0 * (f64::from(k) * 0.1).sin();
            format!("{k},{op},{},{}\n", op * 2.0, 50.0 + 8.0 * (f64::from(k) * 0.1 - 0.2).sin())
        })
        .collect();
    write(&folder, "with-vp.csv", format!("t,op,pv,vp\n{vp}"));
    arguments = vec!["diagnose", "op-only.csv", "with-vp.csv", "--json"];
    let json = run(&folder, &arguments).json();
    assert_eq!(violations(&json, &schema, &schema, "document"), Vec::<String>::new());
    assert!(json["loops"][1]["judged"]["signals"].as_array().is_some_and(|s| s.len() == 3));
}

#[test]
fn schema_and_list_of_methods_are_checked_in() {
    let folder = folder("diagnose-documents");
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    for (flag, file) in [("--schema", "diagnosis.schema.json"), ("--methods", "methods.md")] {
        let made = run(&folder, &["diagnose", flag]).quiet_success();
        let kept = std::fs::read_to_string(docs.join(file)).expect("the document");
        assert!(made == kept, "docs/{file} is stale: stiction diagnose {flag} > docs/{file}");
    }
}

#[test]
fn one_bad_file_does_not_hide_the_others() {
    let folder = with_samples("diagnose-bad-file");
    write(&folder, "broken.csv", "t,op\n0,1\n1,Schrott\n");
    let done = run(&folder, &["diagnose", "FIC101-sticky.csv", "broken.csv", "missing.csv"]);
    assert_eq!(done.code, 2);
    assert!(done.out.starts_with("FIC101-sticky (flow)"), "{}", done.out);
    assert!(done.err.contains("broken.csv, row 3, column \"op\""), "{}", done.err);
    assert!(done.err.contains("missing.csv"), "{}", done.err);
    let done = run(&folder, &["diagnose", "missing.csv"]);
    assert_eq!((done.code, done.out.as_str()), (2, ""));
}

#[test]
fn loops_are_chosen_by_their_tags() {
    let folder = folder("diagnose-loop");
    let rows: String =
        (0..300).map(|k| format!("{k},{},{},{},{}\n", k % 9, k % 7, k % 5, k % 11)).collect();
    let header = "t,FIC1.PV,FIC1.OP,LIC2.PV,LIC2.OP\n";
    write(&folder, "wide.csv", format!("{header}{rows}"));
    let json = run(&folder, &["diagnose", "wide.csv", "--loop", "lic2", "--json"]).json();
    let loops = json["loops"].as_array().expect("loops");
    assert_eq!(
        (loops.len(), &loops[0]["loop"], &loops[0]["type"]),
        (1, &"LIC2".into(), &"level".into())
    );
    let refused = run(&folder, &["diagnose", "wide.csv", "--loop", "FIC9"]).refusal();
    assert!(refused.contains("--loop FIC9: no such loop; there are FIC1, LIC2"), "{refused}");
    let json = run(&folder, &["diagnose", "wide.csv", "--type", "pressure", "--json"]).json();
    assert_eq!(json["loops"][1]["type"], "pressure");
    refuses(&folder, &["diagnose", "wide.csv", "--type", "wet"], "flow, level, pressure");
}

#[test]
fn a_table_has_one_row_a_loop() {
    let folder = with_samples("diagnose-csv");
    let csv = run(&folder, &[&["diagnose"][..], &LOOPS, &["--csv", "-"]].concat()).quiet_success();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header = reader.headers().expect("a header").clone();
    for wanted in [
        "loop",
        "file",
        "verdict",
        "probability",
        "period_s",
        "horch",
        "horch decision",
        "S",
        "S_low",
        "S_high",
        "J",
        "alternative",
        "override",
    ] {
        assert!(header.iter().any(|name| name == wanted), "{wanted} in {header:?}");
    }
    let rows: Vec<_> = reader.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 5);
    assert_eq!(&rows[0][0], "FIC101-sticky");
    // Without a segment to judge there is nothing to count: the cells are empty, and not 0 or false.
    let manual: String = (0..200).map(|k| format!("{k},{},50,MAN\n", 50 + k % 7)).collect();
    write(&folder, "manual.csv", format!("t,op,pv,mode\n{manual}"));
    let csv = run(&folder, &["diagnose", "manual.csv", "--csv", "-"]).quiet_success();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let row = reader.records().next().expect("a row").expect("a row");
    for empty in ["samples", "oscillates", "override", "override_reason"] {
        let at = header.iter().position(|name| name == empty).expect("a column");
        assert_eq!(&row[at], "", "{empty}");
    }
}

#[test]
fn a_report_is_one_self_contained_page() {
    let folder = with_samples("diagnose-report");
    let arguments = [&["diagnose"][..], &LOOPS, &["--report", "report.html", "--csv", "table.csv"]];
    let done = run(&folder, &arguments.concat());
    assert_eq!((done.code, done.out.as_str()), (0, ""));
    assert!(done.err.contains("the report is in report.html"), "{}", done.err);
    let html = read(&folder, "report.html");
    for name in LOOPS {
        assert!(html.contains(name.trim_end_matches(".csv")), "{name}");
    }
    for outside in ["src=\"http", "href=\"http", "url(http", "@import", "<link"] {
        assert!(!html.contains(outside), "{outside}");
    }
    // The same input gives the same bytes.
    run(&folder, &arguments.concat());
    assert!(html == read(&folder, "report.html"));
}

#[test]
fn invalid_requests_are_refused() {
    let folder = folder("diagnose-refused");
    for (arguments, expected) in [
        (vec!["diagnose"], "required"),
        (vec!["diagnose", "a.csv", "--grid", "many"], "--grid"),
        (vec!["diagnose", "a.csv", "--json", "--csv", "x.csv"], "cannot be used with"),
    ] {
        refuses(&folder, &arguments, expected);
    }
    let file = sample("FIC101-sticky.csv");
    refuses(&folder, &["diagnose", &file, "--grid", "-1"], "above 0");
    refuses(&folder, &["diagnose", &file, "--dead-time", "-1"], "the dead time is -1, but must be");
}

/// Every real recording beside the checkout, if there are any.
#[test]
fn real_recordings_get_a_diagnosis_without_an_error() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if !data.is_dir() {
        eprintln!("skipped: there are no real recordings at ../shared/data");
        return;
    }
    let mut files = vec![];
    for entry in std::fs::read_dir(&data).expect("the folder") {
        let folder = entry.expect("an entry").path();
        for file in std::fs::read_dir(&folder).into_iter().flatten() {
            let path = file.expect("a file").path();
            if path.extension().is_some_and(|e| e == "csv")
                && path.file_stem() != Some("index".as_ref())
            {
                files.push(path.display().to_string());
            }
        }
    }
    files.sort();
    let folder = folder("diagnose-real");
    let mut arguments = vec!["diagnose", "--json"];
    arguments.extend(files.iter().map(String::as_str));
    let json = run(&folder, &arguments).json();
    assert_eq!(json["loops"].as_array().map(Vec::len), Some(files.len()));
    // And a report of some of each kind.
    let some: Vec<&str> = files.iter().step_by(9).map(String::as_str).collect();
    let done =
        run(&folder, &[&["diagnose", "--csv", "t.csv", "--report", "r.html"][..], &some].concat());
    assert_eq!(done.code, 0, "{}", done.err);
    assert!(read(&folder, "r.html").len() > 100_000);
}

#[test]
fn a_recorded_valve_position_is_measured() {
    let folder = folder("diagnose-vp");
    let found = |scenario: &str| {
        let name = format!("samples/{scenario}");
        run(&folder, &["simulate", &name, "-o", "FIC1.csv", "--force"]).quiet_success();
        run(&folder, &["diagnose", "FIC1.csv", "--json"]).json()["loops"][0].take()
    };
    for (scenario, s, j) in [("sticky-flow", 4.0, 2.0), ("cascade-slave", 5.0, 2.5)] {
        let found = found(scenario);
        assert_eq!(found["verdict"]["class"], "sticks", "{scenario}");
        assert_eq!(found["verdict"]["basis"], "measured valve position");
        let value = |key: &str| found["stiction"][key]["value"].as_f64().unwrap_or(0.0);
        // J is what a stem that may lag leaves least sure.
        assert!((value("S") - s).abs() < 0.05 && (value("J") - j).abs() < 1.0, "{scenario}");
    }
    // The position of an ideal valve without a transmitter is the OP.
    let found = found("aggressive-flow");
    assert_eq!(found["verdict"]["basis"], "evidence in OP and PV");
    let why = &found["verdict"]["contradictions"][0];
    assert!(why.as_str().unwrap().contains("is a copy and not a measurement"), "{why}");
}

/// Reports are kept and mailed by the hundred.
#[test]
fn the_report_of_a_sample_is_at_most_410_kb() {
    let folder = with_samples("report-size");
    for name in LOOPS {
        run(&folder, &["diagnose", name, "--report", "r.html"]);
        let size = std::fs::metadata(folder.join("r.html")).expect("the report").len();
        assert!((100_000..=410_000).contains(&size), "{name}: {size} bytes");
    }
}
