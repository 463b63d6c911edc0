//! `stiction plant`.

use crate::valve_test::{dated, sample};
use crate::{folder, read, refuses, rows, run, write};

#[test]
fn a_plant_is_made_proposed_scanned_and_reported() {
    let folder = folder("plant");
    let demo = ["plant", "demo", "--loops", "3", "--days", "2", "-o", "north"];
    let out = run(&folder, &demo).quiet_success();
    assert!(out.starts_with("3 loops, 2 days; see "), "{out}");
    assert!(run(&folder, &demo).refusal().contains("is not empty; --force"));
    let truth = read(&folder, "north/truth.csv");
    assert_eq!(rows(&truth).1.len(), 3);

    let refused = run(&folder, &["plant", "-C", "north", "init", "data"]).refusal();
    assert!(refused.contains("plant.toml exists already; --force"), "{refused}");
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
    assert!(out.ends_with("nothing new\n"), "{out}");
    let told = run(&folder, &["plant", "-C", "north", "status"]).quiet_success();
    let head =
        "north: 3 loops, 2 days, 2026-03-02 to 2026-03-03, 6 windows, 0 with an error, 2 runs\n";
    assert!(told.starts_with(head), "{told}");
    let json = run(&folder, &["plant", "-C", "north", "status", "--json"]).json();
    let grades: i64 =
        json["grades"].as_array().unwrap().iter().map(|g| g["windows"].as_i64().unwrap()).sum();
    assert_eq!(grades, 6);
}

/// One file of many, a list of tags, and rows that are damaged: the scan goes on, and what a person says is kept.
#[test]
fn one_bad_file_ends_no_scan_and_damaged_rows_no_note() {
    let folder = folder("plant-bad-file");
    let demo = ["plant", "demo", "--loops", "2", "--days", "2", "-o", "north"];
    run(&folder, &demo).quiet_success();
    run(&folder, &["plant", "-C", "north", "init", "data", "--force"]).quiet_success();
    let bad = folder.join("north/data/broken.csv");
    std::fs::create_dir_all(bad.parent().unwrap()).unwrap();
    let north = |arguments: &[&str]| run(&folder, &[&["plant", "-C", "north"], arguments].concat());
    let toml = read(&folder.join("north"), "plant.toml");
    let with_csv = toml.replacen("data = [", "data = [\"data/*.csv\", ", 1);
    write(&folder, "north/plant.toml", with_csv);
    write(&folder, "north/data/tags.csv", "tag,description\nFIC1001.OP,feed\n");
    let done = north(&["scan"]);
    assert_eq!(done.code, 0, "{}", done.err);
    assert!(done.err.starts_with("note: ") && done.err.contains("tags.csv"), "{}", done.err);
    write(&folder, "north/data/broken.csv", "time,op,pv\nyesterday,1,2\n");
    let done = north(&["scan", "--again"]);
    assert_eq!(done.code, 2, "{}", done.err);
    assert!(done.err.contains("broken.csv, row 2"), "{}", done.err);
    assert!(done.out.starts_with("4 windows judged"), "{}", done.out);
    assert!(north(&["scan", "--help"]).quiet_success().contains("Exit codes:"));
    std::fs::remove_file(&bad).unwrap();

    for name in std::fs::read_dir(folder.join("north/.stiction/runs/0002")).unwrap().flatten() {
        if name.file_name().to_string_lossy().starts_with("windows-") {
            std::fs::write(name.path(), b"").unwrap();
        }
    }
    std::fs::remove_dir_all(folder.join("north/.stiction/index")).unwrap();
    for arguments in
        [&["status"][..], &["note", "FIC1001", "stroked"], &["report"], &["scan"], &["report"]]
    {
        let done = north(arguments);
        assert_eq!(done.code, 0, "{arguments:?}: {}", done.err);
    }
    assert!(read(&folder.join("north"), "log.toml").contains("stroked"));
    let told = north(&["status"]).quiet_success();
    assert!(told.contains("4 windows, ") && !told.contains("did not come"), "{told}");
    let grades: Vec<&str> = told.lines().skip(1).collect();
    assert!(!grades.is_empty() && grades.iter().all(|line| line.contains(" window")), "{told}");
}

#[test]
fn what_is_wrong_is_reported_and_the_rest_judged() {
    let folder = folder("plant-wrong");
    refuses(&folder, &["plant", "scan"], "plant.toml");
    std::fs::write(
        folder.join("plant.toml"),
        "name = \"N\"\nzone = \"Berlin\"\ndata = []\nweigth = 1\n",
    )
    .unwrap();
    refuses(&folder, &["plant", "scan"], "plant.toml, line 4: unknown field `weigth`");

    let demo = ["plant", "demo", "--loops", "1", "--days", "1", "-o", "north"];
    run(&folder, &demo).quiet_success();
    std::fs::write(folder.join("north/data/bad.parquet"), b"PAR1 and no more").unwrap();
    let done = run(&folder, &["plant", "-C", "north", "scan"]);
    assert_eq!(done.code, 2);
    assert!(done.out.starts_with("1 window judged, 0 of them with an error"), "{}", done.out);
    assert!(done.out.contains("\nnot known: 1 file not read\n"), "{}", done.out);
    assert!(done.err.contains("bad.parquet"), "{}", done.err);
    let told = run(&folder, &["plant", "-C", "north", "status"]);
    assert_eq!(told.code, 2, "{}", told.err);
    assert!(
        told.out.contains("not known: 1 file not read\n  file not read: data/bad.parquet: "),
        "{}",
        told.out
    );
    let past = ["snooze", "FIC1001", "--until", "2026-03-03", "--day", "2026-03-04"];
    let refused = run(&folder, &[&["plant", "-C", "north"], &past[..]].concat()).refusal();
    assert!(
        refused.contains("--until 2026-03-03 is before 2026-03-04, the day of the entry"),
        "{refused}"
    );
    let wrong = run(&folder, &["plant", "-C", "north", "scan", "--since", "3.3.2026"]).refusal();
    assert!(wrong.contains("is not a day; write it like 2026-03-01"), "{wrong}");
}

#[test]
fn a_week_is_reported_and_what_people_say_is_kept() {
    let folder = folder("plant-week");
    let demo = ["plant", "demo", "--loops", "4", "--days", "8", "-o", "north"];
    run(&folder, &demo).quiet_success();
    let plant = |more: &[&str]| run(&folder, &[&["plant", "-C", "north"], more].concat());
    assert!(plant(&["report"]).refusal().contains("no window was judged so far; scan first"));
    plant(&["scan"]).quiet_success();
    let refused = plant(&["report", "--week", "2026-W08"]).refusal();
    assert!(
        refused.contains("no window was judged in or before 2026-W08; the last week is 2026-W11"),
        "{refused}"
    );
    assert!(
        plant(&["report", "--week", "March"])
            .refusal()
            .contains("is not a week; write it like 2026-W10")
    );

    let out = plant(&["report", "--week", "2026-W10", "--pages", "1"]).quiet_success();
    assert!(out.starts_with("Demo, week 2026-W10: 4 loops, 4 judged\n"), "{out}");
    let truth = read(&folder, "north/truth.csv");
    let names = rows(&truth).1;
    let (repaired, worse) = (&names[0][0], &names[1][0]);
    let week = folder.join("north/reports/2026-W10");
    let all = || -> Vec<Vec<u8>> {
        let names = [
            "index.html",
            "ranking.csv",
            "ranking.json",
            "ranking.parquet",
            "orders.csv",
            "orders.json",
            "work-orders.csv",
            "groups.parquet",
        ];
        names.map(|name| std::fs::read(week.join(name)).expect(name)).into()
    };
    let before = all();
    plant(&["report", "--week", "2026-W10", "--pages", "1", "--json"]).json();
    assert!(before == all(), "the same again");
    let cmms = read(&folder, "north/reports/2026-W10/work-orders.csv");
    assert!(cmms.starts_with("tag,description,priority,action,opened,status,"), "{cmms}");
    let table = read(&folder, "north/reports/2026-W10/ranking.csv");
    let (header, ranking) = rows(&table);
    assert_eq!((header[0], ranking.len()), ("loop", 4));
    let page = header.iter().position(|name| *name == "page").unwrap();
    assert!(
        ranking[0][page].starts_with("loops/") && week.join(ranking[0][page]).exists(),
        "{:?}",
        ranking[0]
    );
    let own = std::fs::read_to_string(week.join(ranking[0][page])).unwrap();
    assert!(own.contains("href=\"./../index.html\"") && own.contains(ranking[0][0]));

    assert!(plant(&["note", "XIC1", "none"]).refusal().contains("there is no loop \"XIC1\""));
    let by = ["--by", "J. Miller", "--day", "2026-03-09"];
    let told =
        plant(&[&["override", worse, "sticks", "--reason", "seen at the stem"], &by[..]].concat())
            .quiet_success();
    assert!(told.contains("sticks: seen at the stem (J. Miller, 2026-03-09); kept in "), "{told}");
    let mut log = read(&folder, "north/log.toml") + "# by hand\n";
    std::fs::write(folder.join("north/log.toml"), &log).unwrap();
    let lower = repaired.to_lowercase();
    plant(&[&["note", &lower, "new packing", "--repair"], &by[..]].concat()).quiet_success();
    log += "\n[[entry]]\nkind = \"repair\"\n";
    assert!(read(&folder, "north/log.toml").starts_with(&log), "what was written by hand survives");
    let orders = plant(&["orders", "--week", "2026-W10", "--json"]).json();
    let ordered = |orders: &serde_json::Value| {
        orders["orders"].as_array().unwrap().iter().any(|o| o["loop"] == *worse)
    };
    assert!(ordered(&orders), "{orders}");
    assert!(plant(&["snooze", worse, "--until", "9.3.2026"]).refusal().contains("is not a day"));
    plant(&[&["snooze", worse, "--until", "2026-03-23", "WO 4711"], &by[..]].concat())
        .quiet_success();
    assert!(!ordered(&plant(&["orders", "--week", "2026-W10", "--json"]).json()));
    plant(&["report", "--week", "2026-W10", "--pages", "0"]).quiet_success();
    let page = read(&folder, "north/reports/2026-W10/index.html");
    assert!(page.contains("override: sticks") && page.contains("snoozed: WO 4711"));

    std::fs::write(folder.join("north/log.toml"), "[[entry]]\nkind = \"repair\"\nlop = 1\n")
        .unwrap();
    assert!(plant(&["report"]).refusal().contains("log.toml, line 3: unknown field `lop`"));
}

#[test]
fn a_test_confirms_an_order_and_closes_one() {
    let folder = folder("plant-tested");
    let demo = ["plant", "demo", "--loops", "10", "--days", "3", "-o", "north"];
    run(&folder, &demo).quiet_success();
    let plant = |more: &[&str]| run(&folder, &[&["plant", "-C", "north"], more].concat());
    std::fs::create_dir(folder.join("north/tests")).unwrap();
    write(&folder, "north/tests/FIC107.csv", dated(&sample("test/FIC107-tested.csv"), 4));
    write(&folder, "north/tests/FIC207.csv", dated(&sample("test/FIC107-repaired.csv"), 4));
    let own = read(&folder, "north/plant.toml");
    let both = own.replace("\"data/*.parquet\"", "\"data/*.parquet\", \"tests/*.csv\"");
    assert_ne!(own, both, "{own}");
    write(&folder, "north/plant.toml", both);
    plant(&["scan"]).quiet_success();
    let order =
        ["note", "FIC207", "WO 4711", "--order", "--day", "2026-03-02", "--by", "J. Miller"];
    plant(&order).quiet_success();
    let out = plant(&["report", "--week", "2026-W10"]).quiet_success();
    assert!(out.contains(" work orders, 1 closed by a test; see "), "{out}");

    assert!(
        read(&folder, "north/reports/2026-W10/orders.csv")
            .contains(",status,opened,finding,action,")
    );
    let orders: serde_json::Value =
        serde_json::from_str(&read(&folder, "north/reports/2026-W10/orders.json")).unwrap();
    let all = orders.as_array().unwrap();
    let of = |key: &str, value: &str| {
        all.iter().find(|order| order[key] == value).unwrap_or_else(|| panic!("{orders}"))
    };
    let (confirmed, closed) = (of("loop", "FIC107"), of("loop", "FIC207"));
    assert_eq!((&confirmed["status"], &confirmed["sheet"]), (&"confirmed".into(), &().into()));
    let starts = |order: &serde_json::Value, key: &str, with: &str| {
        assert!(order[key].as_str().unwrap().starts_with(with), "{order}");
    };
    starts(confirmed, "finding", "the valve sticks, confirmed by a test on 2026-03-04, S 2.");
    assert_eq!(closed["status"], "closed");
    starts(closed, "finding", "the valve does not stick, by a test on 2026-03-04, S below 0.");
    assert_eq!(all.last().unwrap()["loop"], "FIC207", "what is closed stands at the end");
    // Open orders have the plan in short, with its time, and the sheet beside the page has the same time.
    let sized: Vec<_> = all.iter().filter(|order| order["sheet"].is_string()).collect();
    assert!(!sized.is_empty(), "{orders}");
    for order in &sized {
        let test = order["test"].as_str().unwrap();
        let (lasts, rest) = test
            .strip_prefix("in manual for ")
            .and_then(|rest| rest.split_once(" at most, turn the OP up and down by "))
            .unwrap();
        let some = lasts.strip_prefix("some ").and_then(|both| both.split_once(", "));
        let (expected, most) = some.unwrap_or((lasts, lasts));
        assert!(rest.contains(" turns each, held until the PV answers or for "), "{test}");
        let sheet = format!("north/reports/2026-W10/{}", order["sheet"].as_str().unwrap());
        let sheet = read(&folder, &sheet);
        let heading = format!("<h1>Valve test of {}</h1>", order["loop"].as_str().unwrap());
        assert!(sheet.contains(&heading));
        assert!(sheet.contains(&format!("The test ends after {most} in manual.")), "{test}");
        let takes = format!("The test takes about {expected}.");
        assert!(sheet.contains(&takes) || expected == most, "{test}");
    }
    let open = sized[0];

    let page = read(&folder, "north/reports/2026-W10/index.html");
    for part in ["1 closed by a test", ": does not stick</small>", "-test.html\">Test sheet</a>"] {
        assert!(page.contains(part), "{part}");
    }
    let words = plant(&["orders", "--week", "2026-W10"]).quiet_success();
    assert!(words.contains("FIC207, closed: the valve does not stick, by a test on"), "{words}");
    // The same sized test as on the page.
    assert!(words.contains(&format!("\n  test: {}\n", open["test"].as_str().unwrap())), "{words}");
    // A repair after the test ends what the test said.
    let repair = ["note", "FIC107", "new packing", "--repair", "--day", "2026-03-05"];
    plant(&repair).quiet_success();
    let json = plant(&["orders", "--week", "2026-W10", "--json"]).json();
    let confirmed = json["orders"].as_array().unwrap().iter().any(|o| o["status"] == "confirmed");
    assert!(!confirmed, "{json}");
}
