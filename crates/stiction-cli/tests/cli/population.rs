//! `stiction population`.

use crate::{column, folder, read, refuses, rows, run};

#[test]
fn a_population_is_files_that_bench_reads() {
    let folder = folder("population");
    let arguments = ["population", "--n", "12", "--seed", "7", "-o", "loops"];
    let out = run(&folder, &arguments).quiet_success();
    assert!(out.starts_with("12 loops, "), "{out}");

    let truth = read(&folder, "loops/truth.csv");
    let (header, truths) = rows(&truth);
    assert_eq!(header[..5], ["file", "kind", "sticks", "visible", "model"]);
    assert_eq!(truths.len(), 12);
    let sample_times = column(&truth, "sample_time_s");
    for (truth, sample_time) in truths.iter().zip(sample_times) {
        let recording = read(&folder, &format!("loops/{}", truth[0]));
        let t = column(&recording, "t");
        assert_eq!((t[0], t[3]), (0.0, (3.0 * sample_time * 1e6).round() / 1e6));
        assert!(column(&recording, "op").iter().all(|op| (0.0..=100.0).contains(op)));
        assert_eq!(column(&recording, "pv").len(), t.len());
        assert!(!rows(&recording).0.contains(&"vp"));
    }
    let index = read(&folder, "loops/index.csv");
    for (truth, entry) in truths.iter().zip(rows(&index).1) {
        assert_eq!(truth[0], format!("{}.csv", entry[0]));
        assert_eq!(entry[1] == "stiction", truth[2] == "true");
    }
    let table = run(&folder, &["bench", "labels", "loops/index.csv"]).quiet_success();
    let sticky = truths.iter().filter(|truth| truth[2] == "true").count();
    let counts = format!("{sticky} sticking and {} healthy recordings", 12 - sticky);
    assert!(table.contains(&counts), "{counts}: {table}");

    // The same again, but not over what is there.
    refuses(&folder, &arguments, "loops is not empty; --force");
    let again = ["population", "--n", "12", "--seed", "7", "-o", "again"];
    run(&folder, &again).quiet_success();
    assert_eq!(read(&folder, "again/truth.csv"), truth);
    assert_eq!(read(&folder, "again/loop-05.csv"), read(&folder, "loops/loop-05.csv"));
    run(&folder, &[&again[..], &["--force"]].concat()).quiet_success();
}

#[test]
fn a_population_may_be_of_one_kind_and_show_its_valves() {
    let folder = folder("population-kind");
    let arguments = ["population", "--n", "3", "--kind", "Sticky valve", "--vp", "-o", "sticky"];
    run(&folder, &arguments).quiet_success();
    let truth = read(&folder, "sticky/truth.csv");
    assert!(rows(&truth).1.iter().all(|row| row[1] == "sticky valve" && row[2] == "true"));
    assert!(column(&truth, "S").iter().all(|s| (0.5..=13.0).contains(s)));
    let vp = column(&read(&folder, "sticky/loop-0.csv"), "vp");
    assert!(vp.iter().all(|vp| (0.0..=100.0).contains(vp)));
    let message = run(&folder, &["population", "--kind", "odd", "-o", "odd"]).refusal();
    assert!(message.contains("no kind of loop named \"odd\"; known are sticky valve"), "{message}");
}
