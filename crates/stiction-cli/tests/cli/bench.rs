//! `stiction bench`.

use crate::diagnose::with_samples;
use crate::{command, folder, read, refuses, rows, run, write};
use std::path::Path;

const INDEX: &str = "loop,label,tag,file,loop_type\n\
    FIC101,stiction,V1,FIC101-sticky.csv,flow\n\
    FIC105-cascade,stiction,V5,,\n\
    FIC102-disturbed,no stiction,V2,,flow\n\
    FIC103-aggressive,no stiction,V2,,flow\n\
    LIC104-quantised,,V4,,level\n";

#[test]
fn labelled_recordings_are_scored_by_recording_and_by_valve() {
    let folder = with_samples("bench-labels");
    write(&folder, "index.csv", INDEX);
    let arguments = ["bench", "labels", "index.csv", "--csv", "details.csv", "--method", "horch"];
    let text = run(&folder, &arguments).quiet_success();
    assert!(
        text.starts_with(
            "4 labelled recordings. Index: index.csv. Loops skipped for lack of a label: 1."
        ),
        "{text}"
    );
    assert!(text.contains("2 sticking and 2 healthy recordings."), "{text}");
    assert!(text.contains("2 sticking and 1 healthy valves"), "{text}");
    // The same table, twice: of recordings, and of valves.
    let verdicts: Vec<&str> = text.lines().filter(|line| line.starts_with("verdict ")).collect();
    assert_eq!(verdicts.len(), 3, "decisions on both, and the ranking: {text}");
    assert!(text.lines().all(|line| line.chars().count() <= 130), "{text}");

    let details = read(&folder, "details.csv");
    let (header, rows) = rows(&details);
    assert_eq!(header[..4], ["loop", "valve", "kind", "sticks"]);
    // The verdict, the methods that read a valve position, and the one that was asked.
    let of = |name: &str| -> Vec<&str> {
        rows.iter().filter(|row| row[0] == name).map(|row| row[7]).collect()
    };
    assert_eq!(of("FIC101"), ["verdict", "direct", "yamashita-vp", "horch"]);
    assert_eq!((rows.len(), of("LIC104-quantised").len()), (16, 0));
    assert!(rows.iter().all(|row| row.len() == header.len()));
    let truth = |name: &str| rows.iter().find(|row| row[0] == name).map(|row| (row[1], row[3]));
    assert_eq!(truth("FIC101"), Some(("V1", "true")));
    assert_eq!(truth("FIC103-aggressive"), Some(("V2", "false")));
}

#[test]
fn an_index_has_one_row_or_more_and_stays_in_its_folder() {
    let folder = with_samples("bench-outside");
    std::fs::create_dir(folder.join("plant")).expect("a folder");
    std::fs::rename(folder.join("FIC102-disturbed.csv"), folder.join("plant/in.csv"))
        .expect("moved");
    let absolute = folder.join("FIC101-sticky.csv").display().to_string();
    let measured = |file: &str, more: &[&str]| {
        write(&folder, "plant/index.csv", format!("loop,label,file\nA,stiction,{file}\n"));
        run(
            &folder,
            &[&["bench", "labels", "plant/index.csv", "--only", "verdict"][..], more].concat(),
        )
    };
    assert!(measured("in.csv", &[]).quiet_success().starts_with("1 labelled recordings"));
    let inside = folder.join("plant/in.csv").display().to_string();
    measured(&inside, &[]).quiet_success();
    let mut outside = vec!["../FIC101-sticky.csv", &absolute, "../no.csv", "/etc/passwd"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&absolute, folder.join("plant/link.csv")).expect("a link");
        outside.push("link.csv");
    }
    for file in outside {
        let refused = measured(file, &[]).refusal();
        let named = "plant/index.csv, row 2: the recording of A";
        assert!(refused.contains(named) && refused.contains("give --allow-outside"), "{refused}");
    }
    assert!(measured(&absolute, &["--allow-outside"]).quiet_success().starts_with("1 labelled"));
    write(&folder, "plant/index.csv", "loop,label\n../FIC101-sticky,stiction\n");
    refuses(&folder, &["bench", "labels", "plant/index.csv"], "give --allow-outside");
}

#[test]
fn what_is_counted_can_be_counted_again_from_the_table_of_all_loops() {
    let folder = folder("bench-again");
    let arguments = "bench simulated 40 --per-kind 2 --method yamashita --json --csv details.csv";
    let json = run(&folder, &arguments.split(' ').collect::<Vec<_>>()).json();
    let details = read(&folder, "details.csv");
    let (header, rows) = rows(&details);
    let at = |name: &str| header.iter().position(|each| *each == name).expect("a column");
    let [sticks, visible, method] = ["sticks", "visible", "method"].map(at);
    let [statistic, decision] = ["statistic", "decision"].map(at);
    let of: Vec<&Vec<&str>> = rows
        .iter()
        .filter(|row| row[method] == "yamashita")
        .filter(|row| row[sticks] == "false" || row[visible] == "true")
        .collect();
    let found = &json["methods"].as_array().expect("methods")[3];
    assert_eq!(found["name"], "yamashita");
    for (class, name) in [("true", "recall"), ("false", "false_alarms")] {
        let class: Vec<_> = of.iter().filter(|row| row[sticks] == class).collect();
        let called = class.iter().filter(|row| row[decision] == "sticks").count();
        let share = &found["recordings"][name];
        assert_eq!((&share["k"], &share["n"]), (&called.into(), &class.len().into()), "{name}");
    }
    // The AUC, pair by pair.
    let scores = |class: &str| -> Vec<f64> {
        let speaking = of.iter().filter(|row| row[sticks] == class && row[decision] != "abstains");
        speaking.map(|row| row[statistic].parse().expect("a number")).collect()
    };
    let (high, low) = (scores("true"), scores("false"));
    let won = |s: f64| -> f64 {
        low.iter()
            .map(|h| {
                if s > *h {
                    1.0
                } else if s == *h {
                    0.5
                } else {
                    0.0
                }
            })
            .sum()
    };
    let want = high.iter().map(|s| won(*s)).sum::<f64>() / (high.len() * low.len()) as f64;
    let auc = found["auc"]["value"].as_f64().expect("an AUC");
    assert!((auc - want).abs() < 1e-12, "{auc} {want}");
    assert_eq!(found["auc"]["sticky"], high.len());
    // There are two of each kind at least, unless they stick invisibly.
    let kinds = json["kinds"].as_array().expect("kinds");
    assert!(kinds.len() >= 11, "{kinds:?}");
    let healthy = kinds.iter().filter(|kind| kind["sticks"] == false);
    assert!(healthy.map(|kind| kind["loops"].as_u64()).all(|n| n >= Some(2)), "{kinds:?}");
    let hidden = rows
        .iter()
        .filter(|row| row[method] == "verdict" && row[sticks] == "true" && row[visible] == "false");
    assert_eq!(json["hidden"], hidden.count());
}

/// What the command prints and writes on so many threads.
fn board(folder: &Path, threads: &str) -> Vec<String> {
    let html = format!("{threads}.html");
    let csv = format!("{threads}.csv");
    let output = command(folder)
        .env("RAYON_NUM_THREADS", threads)
        .args(
            "bench simulated 12 --per-kind 1 --seed 5 --method horch --method curve-fit".split(' '),
        )
        .args(["--report", &html, "--csv", &csv])
        .output()
        .expect("the command starts");
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && err.is_empty(), "{err}");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    vec![text, read(folder, &html), read(folder, &csv)]
}

#[test]
fn the_same_on_any_number_of_threads_and_another_with_another_seed() {
    let folder = folder("bench-threads");
    let once = board(&folder, "1");
    assert!(once == board(&folder, "2"));
    let other = run(&folder, &["bench", "simulated", "12", "--only", "verdict", "--seed", "6"]);
    assert_ne!(once[0], other.quiet_success());
}

#[test]
fn loops_with_a_recorded_position_are_scored() {
    let folder = folder("bench-positions");
    let found = run(&folder, &["bench", "positions", "12", "--only", "verdict", "--json"]).json();
    assert!(
        found["title"].as_str().is_some_and(|t| t.contains("recorded valve position")),
        "{found}"
    );
    let text = run(&folder, &["bench", "positions", "12", "--only", "verdict"]).quiet_success();
    assert!(text.contains("every move recorded"), "{text}");
}

#[test]
fn every_form_of_the_results_has_its_parts() {
    let folder = folder("bench-forms");
    let base = ["bench", "simulated", "20", "--per-kind", "0", "--only", "verdict"];
    let with = |more: &[&str]| run(&folder, &[&base[..], more].concat());

    let text = with(&[]).quiet_success();
    assert!(text.starts_with("20 simulated loops. 20 members of the mixed population"), "{text}");
    assert!(!text.contains('|') && text.contains("\nverdict "), "{text}");

    let markdown = with(&["--markdown"]).quiet_success();
    let tables = markdown.lines().filter(|line| line.starts_with("|---|")).count();
    assert!(tables >= 4, "{markdown}");
    assert!(markdown.contains("| Verdict |"), "{markdown}");

    assert!(!text.contains("whole diagnosis"));
    let timed = with(&["--time", "--json"]).json();
    let times = timed["times"].as_array().expect("times");
    assert_eq!((times.len(), &times[0]["name"]), (3, &"whole diagnosis".into()));
    assert!(times[0]["median_us"].as_f64() > Some(0.0));
    // Members that stick invisibly are hidden; all others are asked whether they are decided.
    let hidden = timed["hidden"].as_u64().expect("a count");
    assert_eq!(timed["undecided"]["all"]["n"], 20 - hidden);
    assert!(text.contains("Undecided loops, "), "{text}");
    // Without the times, nothing differs.
    let mut plain = with(&["--json"]).json();
    assert_eq!(plain["times"], serde_json::json!([]));
    plain["times"] = timed["times"].clone();
    assert_eq!(plain, timed);
}

#[test]
fn the_page_leads_to_every_report() {
    let folder = with_samples("bench-page");
    write(&folder, "index.csv", INDEX);
    std::fs::create_dir(folder.join("pages")).expect("a folder");
    let arguments =
        "bench labels index.csv --only verdict --report pages/board.html --reports all/reports";
    run(&folder, &arguments.split(' ').collect::<Vec<_>>()).quiet_success();
    let page = read(&folder, "pages/board.html");
    // Pictures name their language by an address, which no one opens.
    let page = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!page.contains("http://") && !page.contains("https://"), "nothing from elsewhere");
    assert!(page.contains("<table data-sortable>"));
    let links: Vec<&str> =
        page.split("<a href=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert_eq!(links.len(), 4, "{links:?}");
    for link in &links {
        assert!(link.starts_with("./../all/reports/0000"), "{link}");
        let report = read(&folder.join("pages"), link);
        assert!(report.starts_with("<!DOCTYPE html>") && report.contains("Diagnosis of"), "{link}");
    }
    assert!(read(&folder, "all/reports/00001-FIC101.html").contains("Diagnosis of FIC101"));
}

#[test]
fn what_cannot_be_measured_is_refused_with_the_row_and_the_remedy() {
    let folder = with_samples("bench-refused");
    let labels = |index: &str| {
        write(&folder, "index.csv", index);
        run(&folder, &["bench", "labels", "index.csv"]).refusal()
    };
    let sound = "FIC101-sticky,stiction\n";
    for (index, wanted) in [
        (format!("loop,truth\n{sound}{sound}"), "has no column \"label\"; its columns are"),
        (
            format!("loop,label\n{sound}FIC102-disturbed,maybe\n"),
            "index.csv, row 3: the label of FIC102-disturbed is \"maybe\", but must be stiction or no",
        ),
        (
            format!("loop,label\n{sound}FIC999,stiction\n"),
            "index.csv, row 3: the recording of FIC999 cannot be read; put LOOP.csv beside the index, or name the file",
        ),
        (format!("loop,label\n{sound},stiction\n"), "index.csv, row 3: the loop has no name"),
        ("loop,label\na,\nb,\n".to_owned(), "no loop has a label"),
        (format!("loop,label,loop_type\n{}", "a,stiction,flux\n".repeat(2)), "index.csv, row 2"),
    ] {
        let refused = labels(&index);
        assert!(refused.contains(wanted), "{index}: {refused}");
    }
    for (arguments, wanted) in [
        ("bench", "stiction bench simulated 1000"),
        ("bench simulated 0", "1..=1000000"),
        ("bench simulated 2 --method nonesuch", "horch"),
        ("bench simulated 2 --only horch", "verdict"),
        ("bench simulated 2 --set first", "--set"),
        ("bench invented 2 --set fourth", "second"),
        ("bench labels none.csv", "none.csv"),
        ("bench labels none.csv --seed 2", "--seed"),
    ] {
        refuses(&folder, &arguments.split(' ').collect::<Vec<_>>(), wanted);
    }
}
