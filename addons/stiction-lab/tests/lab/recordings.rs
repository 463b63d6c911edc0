//! The room of recordings as its page asks it: over HTTP, with recordings of our own.

use super::{Open, agent};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use stiction_diagnose::diagnose::{DiagnoseOptions, Diagnosis, diagnose};
use stiction_io::{ReadOptions, reading};
use stiction_lab::Options;

/// A lab with these files and folders.
fn open(files: &[PathBuf]) -> Open {
    super::open(&Options { files: files.to_vec(), ..Options::new("test 1.0") })
}

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples")
}

fn sample(name: &str) -> PathBuf {
    samples().join(name)
}

/// A folder of this test's own, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recordings").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

impl Open {
    fn refused(&self, name: &str, ask: &Value) -> (u16, String) {
        let (status, answer) = self.post(name, ask.to_string().as_bytes());
        (status, answer["error"].as_str().unwrap_or_else(|| panic!("{answer}")).to_owned())
    }

    fn get(&self, path: &str) -> (u16, Vec<u8>) {
        let mut answer = agent()
            .get(format!("http://{}/api/{path}", self.at))
            .header("authorization", format!("Bearer {}", self.token))
            .call()
            .unwrap();
        let bytes = answer.body_mut().with_config().limit(1 << 28).read_to_vec().unwrap();
        (answer.status().as_u16(), bytes)
    }
}

/// What the command would say of a file, or of a stretch of it.
fn said(path: &Path, stretch: Option<(f64, f64)>) -> Diagnosis {
    let mut read = reading::read(path, &ReadOptions::default()).unwrap();
    let mut recording = read.recordings.remove(0);
    if let Some((from, to)) = stretch {
        recording = recording.part(from, to, f64::INFINITY).unwrap();
    }
    recording.notes.splice(0..0, read.notes);
    diagnose(&recording, &DiagnoseOptions::default()).unwrap()
}

fn encoded(text: &str) -> String {
    text.bytes().map(|byte| format!("%{byte:02X}")).collect()
}

#[test]
fn the_verdict_on_a_recording_and_on_a_stretch_is_that_of_diagnose_to_the_last_digit() {
    let lab = open(&[samples()]);
    for name in ["FIC101-sticky", "FIC102-disturbed", "FIC103-aggressive", "LIC104-quantised"] {
        let path = sample(&format!("{name}.csv"));
        let file = path.display().to_string();
        for stretch in [None, Some((300.0, 1500.0))] {
            let mut ask = json!({ "file": file, "loop": name });
            if let Some((from, to)) = stretch {
                (ask["from"], ask["to"]) = (from.into(), to.into());
            }
            let answer = lab.good("recordings/diagnose", &ask);
            let expected = serde_json::to_value(said(&path, stretch)).unwrap();
            assert_eq!(answer["diagnosis"], expected, "{name} {stretch:?}");
            assert_eq!(answer["source"]["sha256"].as_str().unwrap().len(), 64);
            assert!(!answer["first_screen"]["headline"].as_str().unwrap().is_empty());
        }
    }
}

#[test]
fn a_stretch_is_judged_as_a_file_that_holds_its_rows_alone() {
    let folder = folder("rows");
    let text = std::fs::read_to_string(sample("FIC101-sticky.csv")).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap();
    let rows: Vec<&str> = lines.skip(400).take(1200).collect();
    let time = |row: &str| row.split(',').next().unwrap().parse::<f64>().unwrap();
    let (from, to) = (time(rows[0]), time(rows[1199]) + 0.5);
    let alone = folder.join("alone.csv");
    std::fs::write(&alone, format!("{head}\n{}\n", rows.join("\n"))).unwrap();
    let lab = open(&[sample("FIC101-sticky.csv"), alone.clone()]);
    let file = sample("FIC101-sticky.csv").display().to_string();
    let part = lab.good(
        "recordings/diagnose",
        &json!({ "file": file, "loop": "FIC101-sticky", "from": from, "to": to }),
    );
    let own = said(&alone, None);
    let expected = serde_json::to_value(&own).unwrap();
    for key in ["verdict", "stiction", "judged"] {
        let (mut a, mut b) = (part["diagnosis"][key].clone(), expected[key].clone());
        if key == "judged" {
            a["from_s"].take();
            b["from_s"].take();
        }
        // The loops have different names, and so do their tests.
        a["confirm"]["name"].take();
        b["confirm"]["name"].take();
        assert_eq!(a, b, "{key}");
    }
}

#[test]
fn folders_are_looked_through_and_files_read_when_requested_for() {
    let lab = open(&[samples()]);
    let list = lab.good("recordings", &json!({}));
    let files = list["files"].as_array().unwrap();
    assert_eq!(files.len(), 10);
    assert!(files.iter().all(|file| file["loops"].is_null()));
    let id = sample("FIC105-cascade.csv").display().to_string();
    let opened = lab.good("recordings/open", &json!({ "file": id }));
    let loops = opened["summary"]["loops"].as_array().unwrap();
    assert!(
        !loops.is_empty() && opened["command"].as_str().unwrap().starts_with("stiction diagnose")
    );
    assert_eq!(
        opened["roles"].as_array().unwrap().len(),
        opened["columns"].as_array().unwrap().len()
    );
    let list = lab.good("recordings", &json!({}));
    let entry = list["files"].as_array().unwrap().iter().find(|file| file["id"] == *id).unwrap();
    assert_eq!(entry["loops"].as_array().unwrap().len(), loops.len());
}

#[test]
fn samples_come_as_bytes_in_one_go() {
    let path = sample("FIC101-sticky.csv");
    let lab = open(std::slice::from_ref(&path));
    let file = encoded(&path.display().to_string());
    let (status, bytes) = lab.get(&format!("recordings/trend?file={file}&loop=FIC101-sticky"));
    assert_eq!(status, 200);
    let read = reading::read(&path, &ReadOptions::default()).unwrap();
    let op = &read.recordings[0].op;
    assert_eq!(bytes[..8], [&(op.values.len() as u32).to_le_bytes()[..], &[7, 0, 0, 0]].concat());
    let numbers: Vec<f64> =
        bytes[8..].chunks(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap())).collect();
    let n = op.values.len();
    assert_eq!(numbers.len(), 4 * n);
    assert_eq!((&numbers[..n], &numbers[3 * n..]), (&op.time[..], &op.values[..]));
}

#[test]
fn what_was_not_opened_cannot_be_requested() {
    let lab = open(&[sample("FIC101-sticky.csv")]);
    let other = sample("FIC102-disturbed.csv").display().to_string();
    for file in [other.as_str(), "/etc/passwd", "../samples/truth.csv", "", "dropped-1:x.csv"] {
        let ask = json!({ "file": file, "loop": "FIC102-disturbed" });
        let (status, error) = lab.refused("recordings/diagnose", &ask);
        assert!(status == 404 && error.contains("is not open in this lab"), "{file}: {error}");
        let path = format!("recordings/trend?file={}&loop=x", encoded(file));
        assert_eq!(lab.get(&path).0, 404);
    }
    let own = sample("FIC101-sticky.csv").display().to_string();
    let (status, error) = lab.refused("recordings/diagnose", &json!({ "file": own, "loop": "x" }));
    assert!(status == 404 && error.contains("its loops are FIC101-sticky"), "{error}");
    let ask = json!({ "file": own, "loop": "FIC101-sticky", "from": 1e9, "to": 2e9 });
    let (status, error) = lab.refused("recordings/diagnose", &ask);
    assert!(status == 400 && error.contains("select a longer stretch"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_link_in_a_folder_leads_nowhere() {
    let folder = folder("link");
    std::os::unix::fs::symlink(sample("FIC101-sticky.csv"), folder.join("link.csv")).unwrap();
    std::os::unix::fs::symlink(samples(), folder.join("more")).unwrap();
    let list = open(&[folder]).good("recordings", &json!({}));
    assert_eq!(list["files"], json!([]));
}

#[test]
fn what_is_dropped_is_read_and_closed_again() {
    let lab = open(&[]);
    let bytes = std::fs::read(sample("FIC101-sticky.csv")).unwrap();
    let (status, entry) = lab.post("recordings/upload?name=..%2F..%2FFIC101-sticky.csv", &bytes);
    assert_eq!((status, &entry["name"]), (200, &json!("FIC101-sticky.csv")));
    let file = &entry["id"];
    let ask = json!({ "file": file, "loop": "FIC101-sticky" });
    let answer = lab.good("recordings/diagnose", &ask);
    let expected = serde_json::to_value(said(&sample("FIC101-sticky.csv"), None)).unwrap();
    assert_eq!(answer["diagnosis"], expected);
    // It has no folder for corrections.
    let conclude =
        json!({ "file": file, "loop": "FIC101-sticky", "verdict": "sticks", "reason": "seen" });
    assert!(lab.refused("recordings/override", &conclude).1.contains("dropped file"));
    let list = lab.good("recordings/close", &json!({ "file": file }));
    assert_eq!(list["files"], json!([]));
    assert_eq!(lab.refused("recordings/diagnose", &ask).0, 404);
}

#[test]
fn what_is_no_recording_is_reported_and_what_is_too_large_refused() {
    let lab = open(&[]);
    for (bytes, word) in [
        (&b"PK\x03\x04"[..], "workbook"),
        (b"", ""),
        (b"\x00\x01\x02\x03\xff\xfe", ""),
        (b"PAR1 but no more", ""),
        (b"MATLAB 5.0 but no more", ""),
        (b"op\n1\n\"", ""),
    ] {
        let (status, entry) = lab.post("recordings/upload?name=x.csv", bytes);
        assert_eq!(status, 200, "{entry}");
        let (status, answer) =
            lab.post("recordings/open", json!({ "file": entry["id"] }).to_string().as_bytes());
        let why = answer["error"].as_str().or(answer["failure"].as_str()).unwrap_or_default();
        assert!(matches!(status, 200 | 400) && !why.is_empty() && why.contains(word), "{answer}");
    }
    // A question of the other kind has a limit of its own.
    let long = vec![b' '; (1 << 20) + 1];
    let large = vec![b'1'; (256 << 20) + 1];
    for (path, body) in [("recordings/open", &long), ("recordings/upload?name=large.csv", &large)] {
        let request = agent()
            .post(format!("http://{}/api/{path}", lab.at))
            .header("authorization", format!("Bearer {}", lab.token));
        // It is refused before it is read: who goes on sending finds the connection closed.
        match request.send(&body[..]) {
            Ok(answer) => assert_eq!(answer.status().as_u16(), 413),
            Err(ureq::Error::Io(_)) => {}
            Err(e) => panic!("{path}: {e}"),
        }
    }
}

#[test]
fn a_mapping_is_tried_saved_and_read_again() {
    let folder = folder("mapping");
    let path = folder.join("strange.csv");
    let text = std::fs::read_to_string(sample("FIC101-sticky.csv")).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let names: Vec<&str> = head.split(',').collect();
    std::fs::write(&path, format!("time,a,b,c\n{rows}")).unwrap();
    let file = path.display().to_string();
    let lab = open(std::slice::from_ref(&folder));
    let opened = lab.good("recordings/open", &json!({ "file": file }));
    assert_eq!(opened["columns"], json!(["time", "a", "b", "c"]));
    assert!(opened["summary"].is_null());
    assert!(
        opened["failure"].as_str().unwrap().contains("role op for its column, below"),
        "{opened}"
    );

    let wrong = json!({ "file": file, "mapping": { "columns": { "a": "open" } } });
    let (status, error) = lab.refused("recordings/mapping", &wrong);
    assert!(status == 400 && error.contains("is not a role; roles are"), "{error}");

    let columns = json!({ "a": names[1], "b": names[2], "c": names[3] });
    let mapping = json!({ "columns": columns, "loop": { "strange": { "type": "flow" } } });
    let mut say = json!({ "file": file, "mapping": mapping });
    let tried = lab.good("recordings/mapping", &say);
    let beside = folder.join("strange.csv.mapping.toml");
    assert!(tried["is_saved"] == false && !beside.exists());
    let verdict = lab.good("recordings/diagnose", &json!({ "file": file, "loop": "strange" }));
    say["save"] = true.into();
    let saved = lab.good("recordings/mapping", &say);
    assert_eq!(saved["is_saved"], true);
    assert_eq!(saved["mapping_file"], beside.display().to_string());
    assert_eq!(saved["command"], format!("stiction diagnose {}", path.display()));

    // The command reads it so, and so does the next lab.
    let read = reading::read(&path, &ReadOptions::read(&beside).unwrap()).unwrap();
    let own = diagnose(&read.recordings[0], &DiagnoseOptions::default()).unwrap();
    assert_eq!(serde_json::to_value(own.verdict).unwrap(), verdict["diagnosis"]["verdict"]);
    assert_eq!(verdict["diagnosis"]["type"], "flow");
    let next = open(std::slice::from_ref(&folder));
    let opened = next.good("recordings/open", &json!({ "file": file }));
    assert_eq!(opened["mapping"], mapping);
    assert_eq!(
        next.good("recordings/diagnose", &json!({ "file": file, "loop": "strange" })),
        verdict
    );

    // One that says more is read, and left alone.
    std::fs::write(
        &beside,
        format!("bad_text = [\"Kaputt\"]\n{}", saved["mapping_toml"].as_str().unwrap()),
    )
    .unwrap();
    let third = open(std::slice::from_ref(&folder));
    let opened = third.good("recordings/open", &json!({ "file": file }));
    assert!(opened["fixed"].as_str().unwrap().contains("in a text editor"), "{opened}");
    assert!(third.refused("recordings/mapping", &say).1.contains("in a text editor"));
}

#[test]
fn a_mapping_is_saved_again_or_taken_back() {
    let folder = folder("mapping-back");
    let path = folder.join("FIC101.csv");
    std::fs::copy(sample("FIC101-sticky.csv"), &path).unwrap();
    let lab = open(std::slice::from_ref(&folder));
    let file = path.display().to_string();
    let beside = folder.join("FIC101.csv.mapping.toml");
    let say = |mapping: &Value, save: bool| {
        let ask = json!({ "file": file, "mapping": mapping, "save": save });
        lab.good("recordings/mapping", &ask)["is_saved"] == true
    };
    let level = json!({ "loop": { "FIC101": { "type": "level" } } });
    let nothing = json!({});

    assert_eq!(lab.good("recordings/open", &json!({ "file": file }))["is_saved"], true);
    assert!(!say(&level, false) && !beside.exists());
    assert!(say(&nothing, false));
    assert!(say(&level, true) && beside.exists());
    assert!(!say(&nothing, false) && beside.exists());
    assert!(say(&level, false));
    assert!(say(&nothing, true) && !beside.exists());
}

#[test]
fn an_override_is_kept_where_the_command_keeps_it() {
    let folder = folder("override");
    let path = folder.join("FIC101.csv");
    std::fs::copy(sample("FIC101-sticky.csv"), &path).unwrap();
    let lab = open(std::slice::from_ref(&folder));
    let file = path.display().to_string();
    let mut ask =
        json!({ "file": file, "loop": "FIC101", "verdict": "does not stick", "reason": " " });
    assert!(lab.refused("recordings/override", &ask).1.contains("needs a reason"));
    ask["reason"] = "new packing".into();
    ask["by"] = "J. Miller".into();
    ask["all_recordings"] = true.into();
    assert!(lab.refused("recordings/override", &ask).1.contains("needs a last day"));
    ask["all_recordings"] = false.into();
    lab.good("recordings/override", &ask);
    let kept = std::fs::read_to_string(folder.join("stiction-overrides.toml")).unwrap();
    assert!(kept.contains("new packing") && kept.contains("test 1.0"), "{kept}");
    let judged = lab.good("recordings/diagnose", &json!({ "file": file, "loop": "FIC101" }));
    assert_eq!(judged["diagnosis"]["verdict"]["override"]["by"], "J. Miller");
    assert!(judged["first_screen"]["overruled"].as_str().unwrap().contains("new packing"));
    lab.good("recordings/override", &json!({ "file": file, "loop": "FIC101" }));
    let judged = lab.good("recordings/diagnose", &json!({ "file": file, "loop": "FIC101" }));
    assert!(judged["diagnosis"]["verdict"]["override"].is_null());
}

#[test]
fn a_report_and_its_parts_come_on_demand() {
    let path = sample("FIC101-sticky.csv");
    let lab = open(std::slice::from_ref(&path));
    let file = path.display().to_string();
    let of = json!({ "file": file, "loop": "FIC101-sticky" });
    let folds = lab.good("recordings/details", &json!({ "of": of }));
    let names: Vec<&str> =
        folds["folds"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    let methods = names.iter().position(|name| name.starts_with("Every method")).unwrap();
    let told = lab.good("recordings/details", &json!({ "of": of, "fold": methods }));
    assert!(told["pieces"].to_string().contains("<svg"));
    assert_eq!(lab.refused("recordings/details", &json!({ "of": of, "fold": 99 })).0, 404);
    // A browser opens the report by its address alone; the page cannot reach the lab.
    let kept = lab.good("recordings/report", &of)["address"].as_str().unwrap().to_owned();
    let page = |address: &str| {
        let mut page = agent().get(format!("http://{}{address}", lab.at)).call().unwrap();
        let header = |name: &str| page.headers()[name].to_str().unwrap().to_owned();
        let (policy, how) =
            (header("content-security-policy"), page.headers().get("content-disposition").cloned());
        let status = page.status().as_u16();
        (status, policy, how, page.body_mut().read_to_string().unwrap())
    };
    let (status, policy, how, html) = page(&kept);
    assert!(html.contains("Diagnosis of FIC101-sticky") && html.contains("test 1.0"), "{status}");
    assert!(policy.contains("sandbox") && !policy.contains("allow-same-origin"), "{policy}");
    assert!(how.unwrap().to_str().unwrap().starts_with("inline"));
    let (.., how, _) = page(&format!("{kept}?save=true"));
    assert_eq!(how.unwrap(), "attachment; filename=\"FIC101-sticky.html\"");
    let guessed = format!("/report/{}", "0".repeat(32));
    assert_eq!((page(&guessed).0, page("/report/..%2flab.js").0), (404, 404));
}
