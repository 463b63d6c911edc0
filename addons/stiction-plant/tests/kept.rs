//! Files that an earlier version wrote are read, and what is written now has columns of the same types.
//!
//! `fixtures/store` was written by 0.1.0 at 415ad2e47e, through Arrow; what is expected here was read from it by pyarrow.

use parquet::file::reader::{FileReader, SerializedFileReader};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use stiction_plant::trace::TraceSignal;
use stiction_plant::{Store, parquet_file};

const FILES: [&str; 2] = ["windows-0001.parquet", "traces-0001.parquet"];

/// A store with the files of the earlier version as its first run.
fn store(name: &str) -> (PathBuf, Store) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("kept-{name}"));
    let _ = fs::remove_dir_all(&folder);
    let run = folder.join(".stiction/runs/0001");
    fs::create_dir_all(&run).unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/store");
    for file in FILES {
        fs::copy(from.join(file), run.join(file)).unwrap();
    }
    let store = Store::of(&folder);
    (folder, store)
}

#[test]
fn what_was_written_through_arrow_is_read() {
    let (folder, store) = store("read");
    let rows = store.rows().unwrap();
    let told: Vec<_> =
        rows.iter().map(|r| (&*r.name, r.window_start, r.samples, r.grade.as_deref())).collect();
    assert!(rows.iter().all(|row| row.pv_moves == Some(true) && row.error.is_none()));
    assert_eq!((rows[0].s, rows[1].s), (Some(8.368_881_073_272_366), None));
    assert_eq!(
        told,
        [
            ("FIC1001", 1_772_409_600, Some(8640), Some("sticks")),
            ("PIC1002", 1_772_409_600, Some(2880), Some("fine"))
        ]
    );
    let traces = store.traces(i64::MIN, i64::MAX).unwrap();
    let told = traces.iter().map(|t| (&*t.name, t.start, t.signal, t.unit, t.digest()));
    let want = [
        (
            "FIC1001",
            0.002_647_350_326_093_677,
            "1211231e096b1d15b36ca751023063ad27009abb65d338ed5a8c3d8b11eb70c0",
        ),
        (
            "PIC1002",
            0.000_165_879_467_659_432_84,
            "9f1d77f4738ffe6b8c0fd5836370e3e0c7d94feb4690134c4d479429f3ca5d63",
        ),
    ];
    let want = want.map(|(name, unit, digest)| {
        (name, 1_772_409_600, TraceSignal::Error, unit, digest.to_owned())
    });
    assert!(told.eq(want), "{traces:?}");
    // Two values of the day are missing.
    assert!(traces[1].values().skip(8637).map(f64::is_nan).eq([false, true, true]));
    assert!(store.traces(1_772_409_601, i64::MAX).unwrap().is_empty());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_is_written_now_has_all_columns_of_before_and_comes_back() {
    let (folder, store) = store("written");
    let (rows, traces) = (store.rows().unwrap(), store.traces(i64::MIN, i64::MAX).unwrap());
    let mut run = store.begin().unwrap();
    run.write_traces(&traces).unwrap();
    run.write(&rows).unwrap();
    run.end("{}").unwrap();
    let file = |run: &str, file: &str| {
        let path = folder.join(".stiction/runs").join(run).join(file);
        SerializedFileReader::new(File::open(path).unwrap()).unwrap()
    };
    // Names have the sum of the file at their end now.
    let now: Vec<String> = fs::read_dir(folder.join(".stiction/runs/0002"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    for name in FILES {
        let begins = name.trim_end_matches(".parquet");
        let written = now.iter().find(|own| own.starts_with(begins)).unwrap();
        let (before, now) = (file("0001", name), file("0002", written));
        let [before, now] =
            [&before, &now].map(|file| file.metadata().file_metadata().schema_descr_ptr());
        // Columns may come, but none may go or become another.
        for column in before.columns() {
            assert!(now.columns().contains(column), "{name}: {column:?}");
        }
    }
    assert_eq!(store.rows().unwrap(), rows);
    fs::remove_dir_all(folder.join(".stiction/runs/0001")).unwrap();
    store.forget_index().unwrap();
    assert_eq!(store.rows().unwrap(), rows);
    assert_eq!(store.traces(i64::MIN, i64::MAX).unwrap(), traces);
    assert_eq!(parquet_file::bytes(&rows).unwrap(), parquet_file::bytes(&rows).unwrap());
    fs::remove_dir_all(folder).unwrap();
}
