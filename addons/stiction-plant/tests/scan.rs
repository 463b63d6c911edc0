//! Scans of a small plant, from the data to the rows.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use stiction_plant::plant_file::Plant;
use stiction_plant::report::{self, ReportOptions};
use stiction_plant::scan::{Manifest, Progress};
use stiction_plant::unknown::Unknown;
use stiction_plant::{ScanOptions, Store, WindowRow, day, demo, log, propose, scan, summary};
use stiction_population::LoopKind;

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("scan-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn go(folder: &Path) -> Manifest {
    let plant = Plant::read(folder).unwrap();
    scan(folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(())).unwrap()
}

fn rows(folder: &Path) -> Vec<WindowRow> {
    Store::of(folder).rows().unwrap()
}

/// A CSV of two loops from row `from` up to row `to`, a sample in 60 s from 2026-03-02T12:00 UTC on.
fn csv(from: usize, to: usize) -> String {
    let of = |kind: LoopKind| kind.simulate(5).unwrap().recording;
    let (a, b) = (of(LoopKind::Sticky), of(LoopKind::Normal));
    let (pv_a, pv_b) = (a.pv.unwrap().values, b.pv.unwrap().values);
    let mut text = "time,FIC1.PV,FIC1.OP,FIC2.PV,FIC2.OP\n".to_owned();
    for k in from..to {
        let at = day::begin(20_514, &"UTC".parse().unwrap()) + 43_200.0 + 60.0 * k as f64;
        let i = k % pv_a.len().min(pv_b.len());
        text += &format!("{at},{},{},{},{}\n", pv_a[i], a.op.values[i], pv_b[i], b.op.values[i]);
    }
    text
}

fn plant_of(folder: &Path, files: &[(&str, String)]) {
    fs::write(
        folder.join("plant.toml"),
        "name = \"N\"\nzone = \"Europe/Berlin\"\ndata = [\"*.csv\"]\n",
    )
    .unwrap();
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
}

#[test]
fn windows_do_not_depend_on_files() {
    let (one, several) = (folder("one"), folder("several"));
    plant_of(&one, &[("all.csv", csv(0, 3000))]);
    // Not cut at midnight, neither here nor there.
    plant_of(
        &several,
        &[("a.csv", csv(0, 900)), ("b.csv", csv(900, 2100)), ("c.csv", csv(2100, 3000))],
    );
    let done = go(&one);
    assert_eq!((done.loops, done.windows, done.errors), (2, 6, 0));
    go(&several);
    let bare = |folder: &Path| -> Vec<WindowRow> {
        rows(folder)
            .into_iter()
            .map(|row| WindowRow { input_fingerprint: String::new(), ..row })
            .collect()
    };
    assert_eq!(bare(&one), bare(&several));
    assert_eq!(
        bare(&one)[0].window_start as f64,
        day::begin(20_514, &"Europe/Berlin".parse().unwrap())
    );
    assert!(bare(&one).iter().any(|row| row.samples == Some(1440)), "a whole day");
}

#[test]
fn only_what_is_new_or_changed_is_judged() {
    let folder = folder("new");
    plant_of(&folder, &[("a.csv", csv(0, 660)), ("b.csv", csv(660, 2100))]);
    assert_eq!(go(&folder).windows, 4);
    let before = rows(&folder);
    let again = go(&folder);
    assert_eq!((again.windows, again.run), (0, None));
    // A new day, and of the old ones the two that held on to what has changed.
    fs::write(folder.join("c.csv"), csv(2100, 2700)).unwrap();
    assert_eq!(go(&folder).windows, 2);
    let changed = csv(0, 660).replacen(".", ".1", 1);
    fs::write(folder.join("a.csv"), changed).unwrap();
    assert_eq!(go(&folder).windows, 4, "the changed day and the day after it, of both loops");
    assert_eq!(rows(&folder).len(), 6);
    assert_eq!(rows(&folder)[0].window_start, before[0].window_start);
    // What the store remembers of the files can be lost.
    fs::remove_file(folder.join(".stiction/inputs.json")).unwrap();
    assert_eq!(go(&folder).windows, 0);
}

#[test]
fn a_bad_file_or_loop_stops_no_other() {
    let folder = folder("bad");
    let broken = csv(660, 2100).replacen("\n", "\nyesterday,1,2,3,4\n", 1);
    // Of the third file one loop has the OP in another unit.
    let unit = csv(660, 2100).replacen("FIC2.OP", "FIC2.OP [mA]", 1);
    plant_of(&folder, &[("a.csv", csv(0, 660)), ("b.csv", broken), ("c.csv", unit)]);
    let done = go(&folder);
    assert_eq!(done.problems.len(), 1, "{:?}", done.problems);
    assert!(done.problems[0].words().contains("b.csv"), "{:?}", done.problems);
    assert!(done.windows >= 4 && rows(&folder).iter().any(|row| row.error.is_none()));
    assert!(Plant::read(&folder.join("none")).is_err());
}

#[test]
fn a_table_without_op_is_no_recording_and_no_problem() {
    let folder = folder("no-op");
    let truth = "loop,sticks,S,J\nFIC1,yes,5,2\nFIC2,no,0,0\n".to_owned();
    let tags = "tag,description\nFIC1.PV,feed\nFIC1.OP,feed valve\n".to_owned();
    let one = "tag,description,unit\nFIC1.PV,feed,t/h\n".to_owned();
    let files =
        [("a.csv", csv(0, 660)), ("one.csv", one), ("truth.csv", truth), ("tags.csv", tags)];
    plant_of(&folder, &files);
    let done = go(&folder);
    assert!(done.problems.is_empty() && done.windows == 2, "{done:?}");
    assert_eq!(done.no_recordings.len(), 3, "{done:?}");
    assert!(done.no_recordings[2].contains("truth.csv"), "{done:?}");
    let proposed = propose::propose(&folder, "N", &[".".to_owned()]).unwrap();
    assert_eq!(proposed.text.matches("# no recording: ").count(), 3, "{}", proposed.text);
    assert!(!proposed.doubts.iter().any(|doubt| doubt.contains("truth.csv")), "{proposed:?}");
}

#[test]
fn a_long_file_sorted_by_tag_is_proposed_whole() {
    let folder = folder("long");
    // The OP begins behind the part that is read of a wide file.
    let rows = |tag: &'static str| {
        (0..9000).map(move |k| format!("{tag},{},{}\n", 1_741_932_000 + k, 40 + k * 7919 % 13))
    };
    let wide = csv(0, 9000).replace("FIC", "TIC");
    for (name, text) in [
        ("long", rows("FIC1.SP").chain(rows("FIC1.PV")).chain(rows("FIC1.OP")).collect()),
        ("wide", wide),
    ] {
        let text: String =
            if name == "long" { format!("Tag,Timestamp,Value\n{text}") } else { text };
        assert!(text.len() as u64 > 5 * propose::HEAD / 4);
        fs::write(folder.join(format!("{name}.csv")), text).unwrap();
    }
    let proposed = propose::propose(&folder, "N", &[".".to_owned()]).unwrap();
    assert_eq!((proposed.loops, proposed.files), (3, 2), "{proposed:?}");
    assert!(!proposed.text.contains("no recording"), "{}", proposed.text);
    assert!(
        proposed.text.contains("# op = \"FIC1.OP\"")
            && proposed.text.contains("# pv = \"FIC1.PV\"")
    );
}

#[test]
fn files_of_one_tag_each_are_not_joined_and_the_remedy_is_one_file() {
    let folder = folder("apart");
    let rows = |name: &str, place: usize| -> String {
        let all = csv(0, 660);
        let cells = all.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>());
        let rows =
            cells.map(|cells| format!("{},{}\n", cells[0], cells[place])).collect::<String>();
        format!("time,{name}\n{rows}")
    };
    plant_of(&folder, &[("FIC1.PV.csv", rows("FIC1.PV", 1)), ("FIC1.OP.csv", rows("FIC1.OP", 2))]);
    let remedy = "export all tags of a loop to one file, because a plant does not join files";
    let done = go(&folder);
    assert!(done.problems.len() == 1 && done.problems[0].message.ends_with(remedy), "{done:?}");
    let no_pv = done.unknown.iter().find(|each| each.name == "FIC1").unwrap();
    assert!(
        no_pv.reason.starts_with("no file with its OP has a PV") && no_pv.reason.ends_with(remedy),
        "{no_pv:?}"
    );
    let proposed = propose::propose(&folder, "N", &[".".to_owned()]).unwrap();
    assert_eq!(proposed.text.matches(remedy).count(), 2, "{}", proposed.text);
    // The remedy helps.
    fs::remove_file(folder.join("FIC1.PV.csv")).unwrap();
    fs::remove_file(folder.join("FIC1.OP.csv")).unwrap();
    plant_of(&folder, &[("all.csv", csv(0, 660))]);
    let done = go(&folder);
    assert!(done.problems.is_empty() && done.unknown.is_empty(), "{done:?}");
}

#[test]
fn what_was_not_read_or_judged_is_counted_and_listed() {
    let folder = folder("unknown");
    let broken = csv(0, 60).replacen("\n", "\nyesterday,1,2,3,4\n", 1);
    // A recording without an OP, a loop without a PV beside a PV without an OP, and a loop in two units at a time.
    let no_op = csv(0, 60).replace("OP", "PV").replacen(
        "FIC1.PV,FIC1.PV,FIC2.PV,FIC2.PV",
        "A.PV,B.PV,C.PV,D.PV",
        1,
    );
    let no_pv = csv(0, 600).replacen(
        "FIC1.PV,FIC1.OP,FIC2.PV,FIC2.OP",
        "TIC8.PV,FIC3.OP,PIC4.PV,PIC4.OP",
        1,
    );
    let unit = csv(0, 660).replacen("FIC2.OP", "FIC2.OP [mA]", 1);
    let files = [
        ("a.csv", csv(0, 660)),
        ("b.csv", broken),
        ("c.csv", no_op),
        ("d.csv", no_pv),
        ("e.csv", unit),
    ];
    plant_of(&folder, &files);
    let done = go(&folder);
    let kinds = |all: &[Unknown]| -> Vec<(&'static str, String)> {
        all.iter().map(|each| (each.kind.name(), each.name.clone())).collect()
    };
    let expected = [
        ("file not read", "b.csv"),
        ("file not read", "c.csv"),
        ("loop without a PV", "FIC3"),
        ("tag without a partner", "TIC8.PV"),
        ("window not judged", "FIC2"),
    ];
    let expected = expected.map(|(kind, name)| (kind, name.to_owned()));
    assert_eq!(kinds(&done.unknown), expected, "{:#?}", done.unknown);
    assert!(done.unknown.iter().all(|each| each.reason.len() > 20 && each.count == 1));
    assert_eq!(done.problems.len(), 2, "{:?}", done.problems);
    let plant = Plant::read(&folder).unwrap();
    assert_eq!(kinds(&summary::status(&folder, &plant).unwrap().unknown), expected);
    let told = report::write(&folder, &plant, &ReportOptions::default(), || ()).unwrap();
    assert_eq!(kinds(&told.unknown), expected);
    let page = fs::read_to_string(folder.join(&told.folder).join("index.html")).unwrap();
    let (first, list) = page.split_once("id=\"orders\"").unwrap();
    let counted =
        "2 files not read, 1 loop without a PV, 1 tag without a partner, 1 window not judged";
    assert!(first.contains(counted), "{first}");
    for (_, name) in &expected {
        assert!(list.contains(name.as_str()), "{name}");
    }
    // Nothing is unknown of a plant without faults.
    for name in ["b.csv", "c.csv", "d.csv", "e.csv"] {
        fs::remove_file(folder.join(name)).unwrap();
    }
    assert_eq!(kinds(&go(&folder).unknown), []);
}

/// The first file of rows of a plant.
fn first_part(folder: &Path) -> PathBuf {
    let pattern = format!("{}/.stiction/runs/0001/windows-*", folder.display());
    glob::glob(&pattern).unwrap().next().unwrap().unwrap()
}

/// What disks and people do to files: emptied, cut, a bit flipped.
const DAMAGES: [fn(&mut Vec<u8>); 3] = [
    |bytes| bytes.clear(),
    |bytes| bytes.truncate(bytes.len() / 2),
    |bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
    },
];

#[test]
fn damaged_rows_block_nothing_and_are_judged_again() {
    let whole = folder("damage-none");
    plant_of(&whole, &[("a.csv", csv(0, 660))]);
    go(&whole);
    let expected = rows(&whole);
    for (k, damage) in DAMAGES.into_iter().enumerate() {
        let folder = folder(&format!("damage-{k}"));
        plant_of(&folder, &[("a.csv", csv(0, 660))]);
        go(&folder);
        let plant = Plant::read(&folder).unwrap();
        let part = first_part(&folder);
        let mut bytes = fs::read(&part).unwrap();
        damage(&mut bytes);
        // While the index is whole, it has the rows; the damage is seen by a scan all the same.
        fs::write(&part, &bytes).unwrap();
        assert_eq!(rows(&folder), expected);
        let done = go(&folder);
        assert_eq!((done.windows, done.damaged.len()), (0, 1), "{done:?}");
        assert!(done.damaged[0].contains("is damaged"), "{done:?}");
        assert!(!part.exists() && folder.join(".stiction/damaged").is_dir());
        // Without the index they are gone, and everything goes on.
        fs::write(&part, &bytes).unwrap();
        fs::remove_dir_all(folder.join(".stiction/index")).unwrap();
        let status = summary::status(&folder, &plant).unwrap();
        assert_eq!((status.windows, status.damaged.len()), (0, 1), "{status:?}");
        assert_eq!(log::known_loop(&folder, &plant, "fic1").unwrap(), "FIC1");
        let done = go(&folder);
        assert_eq!((done.windows, done.damaged.len()), (2, 1), "{done:?}");
        assert_eq!(rows(&folder), expected);
        assert!(go(&folder).damaged.is_empty());
    }
}

/// Of files that have not changed since the index was made only the end is looked at; a page asks the sum of traces it wants.
#[test]
fn damage_that_has_no_new_date_is_seen_where_it_matters() {
    let folder = folder("damage-old");
    plant_of(&folder, &[("a.csv", csv(0, 660))]);
    go(&folder);
    let long_ago = SystemTime::now() - Duration::from_secs(1000);
    let damage = |path: &Path, bytes: &[u8]| {
        fs::write(path, bytes).unwrap();
        fs::File::options().write(true).open(path).unwrap().set_modified(long_ago).unwrap();
    };
    let part = first_part(&folder);
    damage(&part, &fs::read(&part).unwrap()[..100]);
    assert_eq!(go(&folder).damaged.len(), 1);
    let pattern = format!("{}/.stiction/runs/0001/traces-*", folder.display());
    let traces = glob::glob(&pattern).unwrap().next().unwrap().unwrap();
    let mut bytes = fs::read(&traces).unwrap();
    bytes[10] ^= 1;
    damage(&traces, &bytes);
    let store = Store::of(&folder);
    assert!(store.traces(i64::MIN, i64::MAX).unwrap().is_empty());
    assert_eq!(store.damaged().len(), 1);
    damage(&traces, b"");
    let store = Store::of(&folder);
    assert!(store.traces(i64::MIN, i64::MAX).unwrap().is_empty());
    assert_eq!((store.damaged().len(), go(&folder).damaged.len()), (1, 1));
}

#[test]
fn an_index_that_cannot_be_read_is_made_again() {
    let folder = folder("index-damaged");
    plant_of(&folder, &[("a.csv", csv(0, 660))]);
    go(&folder);
    let expected = rows(&folder);
    let pattern = format!("{}/.stiction/index/*.parquet", folder.display());
    let week = glob::glob(&pattern).unwrap().next().unwrap().unwrap();
    let bytes = fs::read(&week).unwrap();
    fs::write(&week, b"").unwrap();
    let store = Store::of(&folder);
    assert_eq!(store.rows().unwrap(), expected);
    assert_eq!(store.damaged().len(), 1);
    let done = go(&folder);
    assert_eq!((done.windows, done.damaged.len()), (0, 1), "{done:?}");
    assert!(fs::read(&week).unwrap() == bytes && rows(&folder) == expected);
}

#[test]
fn a_run_that_was_cut_short_is_forgotten_after_a_whole_scan() {
    let folder = folder("cut-forgotten");
    plant_of(&folder, &[("a.csv", csv(0, 660))]);
    let plant = Plant::read(&folder).unwrap();
    go(&folder);
    // As if it had been killed between its last rows and its end.
    fs::remove_file(folder.join(".stiction/runs/0001/manifest.json")).unwrap();
    fs::remove_file(folder.join(".stiction/whole")).unwrap();
    let cut = || summary::status(&folder, &plant).unwrap().cut_short;
    assert_eq!(cut(), 1);
    let some = ScanOptions { loops: Some("FIC1".to_owned()), ..ScanOptions::default() };
    scan(&folder, &plant, &some, |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(cut(), 1, "a scan of some loops is no whole one");
    assert_eq!(go(&folder).run, None);
    assert_eq!(cut(), 0);
}

#[test]
fn what_does_not_fit_together_is_a_row_with_an_error() {
    let folder = folder("overlap");
    // Another PV of FIC1 in the first row.
    let text = csv(0, 660);
    let (header, body) = text.split_once('\n').unwrap();
    let other = format!("{header}\n{}", body.replacen(',', ",9", 1));
    plant_of(&folder, &[("a.csv", csv(0, 660)), ("b.csv", other)]);
    let done = go(&folder);
    assert_eq!((done.windows, done.errors > 0), (2, true));
    assert_eq!(done.errors, 1);
    let told = rows(&folder).into_iter().filter_map(|row| row.error).next().unwrap();
    assert!(told.contains("b.csv: overlaps a.csv with different values of the PV"), "{told}");
    assert_eq!(go(&folder).windows, 0, "an error is judged again when something changes");
}

#[test]
fn a_window_beyond_the_time_limit_is_a_row_until_the_limit_or_the_data_change() {
    let folder = folder("limit");
    plant_of(&folder, &[("a.csv", csv(0, 660))]);
    let plant = Plant::read(&folder).unwrap();
    let limited = |limit: u32| {
        let options = ScanOptions { time_limit_s: Some(limit), ..ScanOptions::default() };
        let done = scan(&folder, &plant, &options, |_| ControlFlow::Continue(())).unwrap();
        let status = summary::status(&folder, &plant).unwrap();
        (done.windows, done.errors, status.time_limited)
    };
    // No window is judged in no time.
    assert_eq!(limited(0), (2, 2, 2));
    let told = rows(&folder)[0].error.clone().unwrap();
    assert!(told.starts_with("took longer than the time limit of 0 s"), "{told}");
    assert_eq!(limited(0), (0, 0, 2));
    assert_eq!(limited(3600), (2, 0, 0));
    assert_eq!((limited(0), go(&folder).windows), ((0, 0, 0), 0), "what was judged stays");
}

/// All files of rows of a plant, with their names.
fn parts(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = glob::glob(&format!("{}/.stiction/runs/*/*", folder.display()))
        .unwrap()
        .map(|path| path.unwrap())
        .map(|path| {
            (path.strip_prefix(folder).unwrap().display().to_string(), fs::read(&path).unwrap())
        })
        .collect();
    files.sort();
    files
}

#[test]
fn threads_change_no_byte_and_a_scan_that_was_cut_short_goes_on() {
    let (one, two, cut) = (folder("one-thread"), folder("two-threads"), folder("cut-short"));
    let scan_with = |folder: &Path, threads: usize, most: usize| {
        let options = ScanOptions { threads: Some(threads), ..ScanOptions::default() };
        let mut written = 0;
        scan(folder, &Plant::read(folder).unwrap(), &options, |progress| {
            written += usize::from(matches!(progress, Progress::Written { .. }));
            if written == most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap()
    };
    for folder in [&one, &two, &cut] {
        // More days than a batch holds of one loop.
        let text = csv(0, 70 * 96).replace("FIC", "LIC");
        let mut lines: Vec<String> = vec![];
        for (k, line) in text.lines().enumerate() {
            // A sample in 15 minutes, so that 70 days are few samples.
            let (time, rest) = line.split_once(',').unwrap();
            let time = match time.parse::<f64>() {
                Ok(_) => (1_772_452_800 + 900 * (k as i64 - 1)).to_string(),
                Err(_) => time.to_owned(),
            };
            lines.push(format!("{time},{rest}"));
        }
        plant_of(folder, &[("a.csv", lines.join("\n") + "\n")]);
    }
    let whole = scan_with(&one, 1, usize::MAX);
    assert!(whole.parts > 1 && whole.errors == 0, "{whole:?}");
    scan_with(&two, 2, usize::MAX);
    assert_eq!(parts(&one), parts(&two));

    scan_with(&cut, 2, 1);
    // As after a loss of power: the run has no manifest, and half a part lies about.
    let run = cut.join(".stiction/runs/0001");
    fs::remove_file(run.join("manifest.json")).unwrap();
    fs::write(run.join("windows-0002.parquet.part"), b"PAR1").unwrap();
    assert!(rows(&cut).len() < rows(&one).len());
    let rest = scan_with(&cut, 2, usize::MAX);
    assert_eq!(rows(&cut), rows(&one));
    assert!(rest.windows < whole.windows);
}

#[test]
fn two_do_not_write_at_once() {
    let folder = folder("lock");
    plant_of(&folder, &[("a.csv", csv(0, 660))]);
    let run = Store::of(&folder).begin().unwrap();
    let refused = scan(&folder, &Plant::read(&folder).unwrap(), &ScanOptions::default(), |_| {
        ControlFlow::Continue(())
    });
    assert!(refused.unwrap_err().to_string().contains("another scan of this plant is running"));
    drop(run);
    assert_eq!(go(&folder).windows, 2);
}

#[test]
fn a_demo_has_its_stories() {
    let folder = folder("demo");
    demo::write(&folder, 4, 2, 1, || {}).unwrap();
    let again = self::folder("demo-again");
    demo::write(&again, 4, 2, 1, || {}).unwrap();
    for name in ["plant.toml", "truth.csv", "data/2026-03-02.parquet", "data/2026-03-03.parquet"] {
        assert_eq!(
            fs::read(folder.join(name)).unwrap(),
            fs::read(again.join(name)).unwrap(),
            "{name}"
        );
    }
    let done = go(&folder);
    assert_eq!(
        (done.loops, done.windows, done.errors, done.problems.len()),
        (4, 8, 0, 0),
        "{done:?}"
    );
    let rows = rows(&folder);
    let manual = rows.iter().find(|row| row.name.ends_with("1004")).unwrap();
    assert!((manual.auto_share.unwrap() - 87.5).abs() < 1.0, "{:?}", manual.auto_share);
    assert_eq!(manual.area.as_deref(), Some("South"));
}

#[test]
fn ten_slow_periods_are_one_window_of_several_days() {
    let folder = folder("slow");
    let mut text = "time,FIC1.PV,FIC1.OP\n".to_owned();
    for k in 0..70 * 96 {
        let swing = (std::f64::consts::TAU * f64::from(k) / 20.0).sin();
        text += &format!(
            "{},{},{}\n",
            1_772_452_800 + 900 * i64::from(k),
            20.0 + swing,
            50.0 - 2.0 * swing
        );
    }
    plant_of(&folder, &[("a.csv", text)]);
    let done = go(&folder);
    assert_eq!(done.errors, 0);
    let rows = rows(&folder);
    // Ten periods of 5 h are three days; where the clock changes to summer time, one day less an hour.
    let long = rows.iter().filter(|row| row.window_s >= 3 * 86_400 - 3600).count();
    assert!(
        long > 10,
        "{:?}",
        rows.iter().map(|row| (row.window_s, row.period_s)).collect::<Vec<_>>()
    );
    for pair in rows.windows(2) {
        assert_eq!(
            pair[0].window_start + pair[0].window_s,
            pair[1].window_start,
            "none twice, none left out"
        );
    }
    assert_eq!(go(&folder).windows, 0);
}

fn status(folder: &Path) -> summary::Status {
    summary::status(folder, &Plant::read(folder).unwrap()).unwrap()
}

fn reported(folder: &Path) -> report::Reported {
    let plant = Plant::read(folder).unwrap();
    report::write(folder, &plant, &ReportOptions { week: None, pages: 10 }, || {}).unwrap()
}

/// A table with another last digit.
fn touched(text: &str) -> String {
    let at = text.rfind(|c: char| c.is_ascii_digit()).unwrap();
    let digit = if text[at..].starts_with('1') { '2' } else { '1' };
    format!("{}{digit}{}", &text[..at], &text[at + 1..])
}

/// Files that are changed, grow, shrink, come and go between a scan and what is asked of it.
#[test]
fn what_changed_since_the_scan_is_reported_and_judged_again() {
    let folder = folder("changed");
    let files = [("a.csv", csv(0, 660)), ("b.csv", csv(660, 2100)), ("c.csv", csv(2100, 3000))];
    plant_of(&folder, &files);
    assert_eq!(go(&folder).changes, Default::default(), "there was no scan before");
    assert_eq!(status(&folder).changes, Default::default());
    let (before, whole) = (rows(&folder), reported(&folder));
    assert!(whole.problems.is_empty() && whole.pages == 2, "{:?}", whole.problems);

    let long_ago = SystemTime::now() - Duration::from_secs(5000);
    let write = |name: &str, text: String| {
        fs::write(folder.join(name), text).unwrap();
        fs::File::options()
            .write(true)
            .open(folder.join(name))
            .unwrap()
            .set_modified(long_ago)
            .unwrap();
    };
    // Changed bytes of the same size; shrunk; new; missing.
    write("a.csv", touched(&csv(0, 660)));
    write("c.csv", csv(2100, 2400));
    write("d.csv", csv(3000, 3600));
    fs::remove_file(folder.join("b.csv")).unwrap();
    let seen = status(&folder);
    let names = |all: &[String]| all.join(" ");
    assert_eq!(names(&seen.changes.changed), "a.csv c.csv");
    assert_eq!((&*names(&seen.changes.new), &*names(&seen.changes.missing)), ("d.csv", "b.csv"));
    let words = seen.changes.words();
    assert_eq!(words.len(), 3);
    assert_eq!(
        words[2],
        "1 data file missing since the last scan, b.csv; the plant keeps the results of its windows"
    );
    assert_eq!(seen.windows, before.len(), "nothing is forgotten");
    // A page of other data than the ranking shows is not made.
    let report = reported(&folder);
    let refused = report.problems.iter().filter(|why| why.contains("page of FIC")).count();
    assert!(refused >= 1 && report.pages + refused == 2, "{:?}", report.problems);
    assert_eq!(report.problems.len(), refused + 3, "{:?}", report.problems);

    let done = go(&folder);
    assert_eq!(names(&done.changes.changed), "a.csv c.csv");
    assert!(done.windows > 0 && done.problems.is_empty(), "{done:?}");
    // The windows of the file that is gone stay, as they were judged.
    let starts = |rows: &[WindowRow]| rows.iter().map(|row| row.window_start).collect::<Vec<_>>();
    assert!(starts(&before).iter().all(|start| starts(&rows(&folder)).contains(start)));
    assert_eq!(status(&folder).changes, Default::default());
    assert_eq!(go(&folder).windows, 0);
    // It grows.
    write("c.csv", csv(2100, 3000));
    assert_eq!(names(&go(&folder).changes.changed), "c.csv");
}

#[test]
fn one_unreadable_file_among_many_costs_one_line() {
    let folder = folder("unreadable");
    plant_of(&folder, &[("good.csv", csv(0, 660))]);
    let plant = "name = \"N\"\nzone = \"Europe/Berlin\"\ndata = [\"**/*.csv\", \"*.parquet\"]\n";
    fs::write(folder.join("plant.toml"), plant).unwrap();
    for k in 0..50 {
        let renamed = csv(0, 60).replace("FIC", &format!("L{k}_"));
        fs::write(folder.join(format!("m{k}.csv")), renamed).unwrap();
    }
    fs::write(folder.join("cut.parquet"), b"PAR1\x00\x01PAR").unwrap();
    fs::create_dir(folder.join("folder.csv")).unwrap();
    fs::create_dir(folder.join("read.csv")).unwrap();
    fs::write(folder.join("read.csv/inside.csv"), csv(660, 720)).unwrap();
    let mut unreadable = 1;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::os::unix::fs::symlink("nowhere.csv", folder.join("link.csv")).unwrap();
        unreadable += 1;
        let (closed, locked) = (folder.join("closed.csv"), folder.join("locked"));
        fs::write(&closed, csv(0, 60)).unwrap();
        fs::create_dir(&locked).unwrap();
        for path in [&closed, &locked] {
            fs::set_permissions(path, fs::Permissions::from_mode(0o000)).unwrap();
        }
        // The superuser reads everything.
        if fs::read(&closed).is_err() {
            unreadable += 2;
        }
    }
    let done = go(&folder);
    assert_eq!(done.problems.len(), unreadable, "{:?}", done.problems);
    assert!(done.problems.iter().all(|problem| !problem.words().contains('\n')));
    assert_eq!(done.no_recordings.len(), 1, "{:?}", done.no_recordings);
    assert!(
        done.no_recordings[0].starts_with("folder.csv is a folder"),
        "{:?}",
        done.no_recordings
    );
    assert!(done.loops >= 102 && done.windows >= 102, "{} loops", done.loops);
    assert_eq!(go(&folder).windows, 0);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(folder.join("locked"), fs::Permissions::from_mode(0o755)).unwrap();
    }
}

/// A clock that was set back between scans, and a loop whose historian is years ahead.
#[test]
fn clocks_that_jump_change_no_order() {
    let folder = folder("clocks");
    plant_of(&folder, &[("a.csv", csv(0, 2100))]);
    let set = |name: &str, at: SystemTime| {
        fs::File::options().write(true).open(folder.join(name)).unwrap().set_modified(at).unwrap();
    };
    // Written when the clock was a day ahead.
    set("a.csv", SystemTime::now() + Duration::from_secs(86_400));
    assert_eq!(go(&folder).windows, 4);
    let expected = rows(&folder);
    assert_eq!((go(&folder).windows, status(&folder).changes), (0, Default::default()));
    // Changed after the clock was set back, with an older date and the same size.
    let changed = touched(&csv(0, 2100));
    fs::write(folder.join("a.csv"), changed).unwrap();
    set("a.csv", SystemTime::now() - Duration::from_secs(400 * 86_400));
    assert_eq!(status(&folder).changes.changed, ["a.csv"]);
    let done = go(&folder);
    assert!(done.windows > 0 && done.changes.changed == ["a.csv"], "{done:?}");
    assert_eq!(rows(&folder).len(), expected.len());

    // Among many loops, one has samples of the year 2099.
    let (late, others) = (4_070_908_800_i64, (0..8).map(|k| (k, csv(0, 700))));
    for (k, text) in others {
        fs::write(folder.join(format!("o{k}.csv")), text.replace("FIC", &format!("O{k}_")))
            .unwrap();
    }
    let ahead = csv(0, 300).lines().enumerate().fold(String::new(), |text, (k, line)| {
        let rest = line.split_once(',').unwrap().1.replace("FIC", "LATE");
        let time = if k == 0 {
            "time".to_owned()
        } else {
            jiff::Timestamp::from_second(late + 60 * k as i64).unwrap().to_string()
        };
        text + &format!("{time},{rest}\n")
    });
    fs::write(folder.join("late.csv"), ahead).unwrap();
    let done = go(&folder);
    assert!(done.problems.is_empty(), "{:?}", done.problems);
    let all = rows(&folder);
    assert!(all.is_sorted_by(|a, b| (&a.name, a.window_start) <= (&b.name, b.window_start)));
    assert_eq!(status(&folder).last_day.as_deref(), Some("2099-01-01"));
    let report = reported(&folder);
    assert_eq!(report.week, "2026-W10", "not that of one loop");
    assert!(
        report.problems.iter().any(|why| why.contains("windows up to 2099-W01")),
        "{:?}",
        report.problems
    );
}

/// Local times of the nights in which clocks are put forward and back.
#[test]
fn summer_time_makes_no_gap_and_no_overlap() {
    for (name, first, hours) in [("spring", "2026-03-29", 23), ("autumn", "2026-10-25", 25)] {
        let folder = folder(name);
        let berlin = "Europe/Berlin".parse().unwrap();
        let begin = day::begin(day::parse(first).unwrap(), &berlin);
        let mut text = "time,FIC1.PV,FIC1.OP\n".to_owned();
        let of = LoopKind::Sticky.simulate(5).unwrap().recording;
        let (pv, op) = (of.pv.unwrap().values, of.op.values);
        for k in 0..hours * 60 {
            let second = begin as i64 + 60 * k as i64;
            let zoned = jiff::Timestamp::from_second(second).unwrap();
            let local = zoned.in_tz("Europe/Berlin").unwrap().strftime("%Y-%m-%d %H:%M:%S");
            text += &format!("{local},{},{}\n", pv[k % pv.len()], op[k % op.len()]);
        }
        plant_of(&folder, &[("a.csv", text)]);
        let done = go(&folder);
        assert!(done.problems.is_empty() && done.errors == 0, "{name}: {done:?}");
        let rows = rows(&folder);
        assert_eq!(rows.len(), 1, "{name}: {rows:?}");
        assert_eq!(rows[0].window_start as f64, begin, "{name}");
        assert_eq!(rows[0].window_s, 3600 * hours as i64, "{name}");
        assert_eq!(rows[0].samples, Some(60 * hours as i64), "{name}");
    }
}
