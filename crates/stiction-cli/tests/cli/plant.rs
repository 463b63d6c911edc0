//! `stiction plant`.

use crate::{folder, read, rows, run};

#[test]
fn a_plant_is_made_proposed_scanned_and_told() {
    let folder = folder("plant");
    let demo = ["plant", "demo", "--loops", "3", "--days", "2", "-o", "north"];
    let out = run(&folder, &demo).quiet_success();
    assert!(out.starts_with("3 loops, 2 days; see "), "{out}");
    assert!(run(&folder, &demo).refusal().contains("is not empty; --force"));
    let truth = read(&folder, "north/truth.csv");
    assert_eq!(rows(&truth).1.len(), 3);

    let refused = run(&folder, &["plant", "-C", "north", "init", "data"]).refusal();
    assert!(refused.contains("plant.toml is there already; --force"), "{refused}");
    let out = run(&folder, &["plant", "-C", "north", "init", "data", "--force"]).quiet_success();
    assert!(out.starts_with("3 loops in 2 files, "), "{out}");
    let proposed = read(&folder, "north/plant.toml");
    assert!(proposed.contains("data = [\"data/**/*.parquet\"]"), "{proposed}");
    for truth in rows(&truth).1 {
        assert!(proposed.contains(&format!("[loop.\"{}\"]", truth[0])), "{proposed}");
        assert!(proposed.contains(&format!("# op = \"{}.OP\"", truth[0])), "{proposed}");
    }

    let checked = run(&folder, &["plant", "-C", "north", "check"]).quiet_success();
    assert!(checked.contains("2 days, 2026-03-02 to 2026-03-03\n"), "{checked}");
    assert!(!folder.join("north/.stiction").exists(), "check writes nothing");

    let some =
        ["plant", "-C", "north", "scan", "--since", "2026-03-03", "--threads", "1", "--json"];
    let done = run(&folder, &some).json();
    assert_eq!((&done["windows"], &done["run"]), (&3.into(), &"0001".into()));
    let out = run(&folder, &["plant", "-C", "north", "scan"]).quiet_success();
    assert_eq!(out, "3 windows judged, 0 of them with an error; 3 loops in 2 files; run 0002\n");
    let out = run(&folder, &["plant", "-C", "north", "scan"]).quiet_success();
    assert!(out.ends_with("nothing was new\n"), "{out}");
    let told = run(&folder, &["plant", "-C", "north", "status"]).quiet_success();
    let head =
        "north: 3 loops, 2 days, 2026-03-02 to 2026-03-03, 6 windows, 0 with an error, 2 runs\n";
    assert!(told.starts_with(head), "{told}");
    let json = run(&folder, &["plant", "-C", "north", "status", "--json"]).json();
    let grades: i64 =
        json["grades"].as_array().unwrap().iter().map(|g| g["windows"].as_i64().unwrap()).sum();
    assert_eq!(grades, 6);
}

#[test]
fn what_is_wrong_is_told_and_the_rest_judged() {
    let folder = folder("plant-wrong");
    let missing = run(&folder, &["plant", "scan"]).refusal();
    assert!(missing.contains("plant.toml"), "{missing}");
    std::fs::write(
        folder.join("plant.toml"),
        "name = \"N\"\nzone = \"Berlin\"\ndata = []\nweigth = 1\n",
    )
    .unwrap();
    let refused = run(&folder, &["plant", "scan"]).refusal();
    assert!(refused.contains("plant.toml, line 4: unknown field `weigth`"), "{refused}");

    let demo = ["plant", "demo", "--loops", "1", "--days", "1", "-o", "north"];
    run(&folder, &demo).quiet_success();
    std::fs::write(folder.join("north/data/bad.parquet"), b"PAR1 and no more").unwrap();
    let done = run(&folder, &["plant", "-C", "north", "scan"]);
    assert_eq!(done.code, 2);
    assert!(done.out.starts_with("1 windows judged, 0 of them with an error"), "{}", done.out);
    assert!(done.err.contains("bad.parquet"), "{}", done.err);
    let wrong = run(&folder, &["plant", "-C", "north", "scan", "--since", "3.3.2026"]).refusal();
    assert!(wrong.contains("is no day; write it as in 2026-03-01"), "{wrong}");
}
