//! Files that an earlier version wrote, or that people wrote for it, are read.
//!
//! `kept` has files of 0.1.0. They never change. A version that cannot read one of them breaks the promise of docs/release.md.
//! Stores are tested in the crate of plants.

use crate::valve_test::{dated, sample};
use crate::{folder, read, run, write};
use std::path::{Path, PathBuf};

/// A folder with the kept files.
fn kept(name: &str) -> PathBuf {
    let folder = folder(name);
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/kept");
    for entry in std::fs::read_dir(from).expect("the kept files") {
        let path = entry.expect("a file").path();
        std::fs::copy(&path, folder.join(path.file_name().expect("a name"))).expect("a copy");
    }
    folder
}

#[test]
fn settings_mappings_scenarios_and_plans_are_read() {
    let folder = kept("kept-files");
    write(&folder, "a.csv", format!("pv,op\n{}", "50,40\n51,41\n52,40\n".repeat(40)));
    let told = run(&folder, &["inspect", "a.csv"]);
    assert!(told.out.contains("2 s") && told.err.contains("stiction.toml"), "{}", told.err);

    let odd = "zeit,y,ist,stellung\n05/06/2024 00:00,5,weg,4\n05/06/2024 00:01,6,2,5\n";
    write(&folder, "odd.csv", odd);
    let inspected = run(&folder, &["inspect", "odd.csv"]);
    for part in ["loop FIC9, flow", "1 of 2\n            1 bad", "stellung  VP"] {
        assert!(inspected.out.contains(part), "{part}: {} {}", inspected.out, inspected.err);
    }

    let run_of = run(&folder, &["simulate", "scenario.toml", "-o", "run.csv", "--no-config"]);
    assert_eq!(run_of.code, 0, "{}", run_of.err);
    assert_eq!(read(&folder, "run.csv").lines().count(), 6001);

    let tested = sample("test/FIC106-tested.csv");
    let with_plan = ["test", "read", &tested, "--plan", "plan.json", "--json", "--no-config"];
    let json = run(&folder, &with_plan).json();
    assert_eq!(json["loops"][0]["test"]["class"], "sticks");
    assert!(json["loops"][0]["test"]["plan"].is_object(), "{json}");
}

#[test]
fn a_plant_and_its_log_are_read() {
    let folder = kept("kept-plant");
    std::fs::remove_file(folder.join("stiction.toml")).expect("a file");
    std::fs::create_dir(folder.join("data")).expect("a folder");
    for tag in ["FIC102-disturbed", "LIC104-quantised"] {
        write(&folder, &format!("data/{tag}.csv"), dated(&sample(&format!("{tag}.csv")), 2));
    }
    run(&folder, &["plant", "scan"]).quiet_success();
    let report = run(&folder, &["plant", "report", "--json"]).json();
    assert_eq!(report["judged"], 2, "{report}");
    let week = folder.join(report["folder"].as_str().unwrap());
    let files = |of: &Path| std::fs::read_dir(of).unwrap().map(|file| file.unwrap().path());
    let pages: String = files(&week)
        .chain(files(&week.join("loops")))
        .filter_map(|page| std::fs::read_to_string(page).ok())
        .collect();
    for said in ["seen at the stem", "WO 4711"] {
        assert!(pages.contains(said), "{said}");
    }
}
