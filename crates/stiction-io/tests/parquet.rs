//! Parquet files of another program are read as what they mean.

use crate::{fixture, said};
use stiction_io::ReadOptions;
use stiction_io::parquet::parquet_sheets;
use stiction_io::reading::parse;
use stiction_io::sheet::{Cells, Sheet};
use stiction_recording::recording::Quality;

/// The fixtures' loop, as `fixtures/make_fixtures.py` writes it.
const ROWS: usize = 40;
const START: f64 = 1_700_000_000.0;

fn read(name: &str) -> Sheet {
    let mut sheets = parquet_sheets(&fixture(name), name).expect("a well-formed file");
    assert_eq!(sheets.len(), 1);
    sheets.remove(0)
}

fn cells<'s>(sheet: &'s Sheet, name: &str) -> &'s Cells {
    &sheet.columns.iter().find(|column| column.name == name).expect("the column").cells
}

/// What each row should hold.
fn numbers(value: impl Fn(f64) -> f64) -> Cells {
    Cells::Numbers((0..ROWS).map(|k| value(k as f64)).collect())
}

fn times(utc: bool, value: impl Fn(f64) -> f64) -> Cells {
    Cells::Times { seconds: (0..ROWS).map(|k| value(k as f64)).collect(), utc }
}

fn text(value: impl Fn(usize) -> &'static str) -> Cells {
    Cells::Text((0..ROWS).map(value).collect())
}

/// NaN does not equal itself, so cells are compared as they are shown.
fn assert_cells(sheet: &Sheet, name: &str, expected: &Cells) {
    assert_eq!(format!("{:?}", cells(sheet, name)), format!("{expected:?}"), "{name}");
}

fn op(k: f64) -> f64 {
    50.0 + 0.5 * k
}

fn pv(k: f64) -> f64 {
    if k == 3.0 { f64::NAN } else { 2.0 * op(k) + 0.25 }
}

#[test]
fn every_type_in_every_compression() {
    for codec in ["none", "snappy", "gzip", "brotli", "zstd", "lz4"] {
        let sheet = read(&format!("loop_{codec}.parquet"));
        assert_eq!((sheet.len(), sheet.columns.len()), (ROWS, 20), "{codec}");
        for (name, expected) in [
            ("time", times(true, |k| START + k + 0.25)),
            ("local_s", times(false, |k| START + k)),
            ("local_us", times(false, |k| START + k + 5e-6)),
            ("utc_ns", times(true, |k| START + k)),
            ("date", times(false, |k| (19_000.0 + k) * 86_400.0)),
            ("OP", numbers(op)),
            ("PV", numbers(pv)),
            ("i8", numbers(|k| k - 20.0)),
            ("u8", numbers(|k| 200.0 + k)),
            ("i16", numbers(|k| k - 3000.0)),
            ("u32", numbers(|k| 4_294_967_295.0 - k)),
            ("i64", numbers(|k| -1_099_511_627_776.0 - k)),
            ("u64", numbers(|k| 9_223_372_036_854_775_808.0 + 2048.0 * k)),
            ("half", numbers(|k| k / 4.0 - 2.0)),
            ("small", numbers(|k| k * 1.25 - 5.0)),
            ("auto", numbers(|k| f64::from(k % 3.0 == 0.0))),
            (
                "mode",
                text(|k| {
                    if k == 5 {
                        ""
                    } else if k < 10 {
                        "MAN"
                    } else {
                        "AUTO"
                    }
                }),
            ),
            ("mode_dict", text(|k| if k < 10 { "MAN" } else { "AÜTO" })),
            ("lag", numbers(|k| 1.5 * k)),
            ("clock", numbers(|k| 1.5 * k)),
        ] {
            assert_cells(&sheet, name, &expected);
        }
    }
}

#[test]
fn units_and_attributes_are_arrow_s() {
    let sheet = read("loop_snappy.parquet");
    let units: Vec<_> =
        sheet.columns.iter().filter_map(|c| Some((&*c.name, c.unit.as_deref()?))).collect();
    assert_eq!(units, [("OP", "%"), ("PV", "degC"), ("lag", "s"), ("clock", "s")]);
    assert_eq!(sheet.attributes, [("site".to_owned(), "mill 3".to_owned())]);
    assert_eq!((&*sheet.origin, &*sheet.part), ("loop_snappy.parquet", ""));
}

/// Several row groups, pages of version 2, and every encoding that is not plain.
#[test]
fn other_encodings() {
    let sheet = read("loop_v2.parquet");
    assert_cells(&sheet, "OP", &numbers(op));
    assert_cells(&sheet, "PV", &numbers(pv));
    assert_cells(&sheet, "i64", &numbers(|k| -1_099_511_627_776.0 - k));
    assert_cells(&sheet, "auto", &numbers(|k| f64::from(k % 3.0 == 0.0)));
    let mode = text(|k| {
        if k == 5 {
            ""
        } else if k < 10 {
            "MAN"
        } else {
            "AUTO"
        }
    });
    assert_cells(&sheet, "mode", &mode);
}

#[test]
fn old_timestamps() {
    let sheet = read("loop_int96.parquet");
    assert_cells(&sheet, "local_us", &times(false, |k| START + k + 5e-6));
}

#[test]
fn frames_of_pandas() {
    let sheet = read("pandas.parquet");
    let names: Vec<_> = sheet.columns.iter().map(|c| &*c.name).collect();
    assert_eq!(names, ["OP", "PV", "__index_level_0__"]);
    assert!(sheet.attributes.is_empty());
}

/// True is good in a column of qualities, and 1 in any other.
#[test]
fn true_is_a_quality() {
    let reading =
        parse(&fixture("flags.parquet"), "flags.parquet", &ReadOptions::default()).unwrap();
    let quality = &reading.recordings[0].pv.as_ref().unwrap().quality;
    assert_eq!(quality[2..6], [Quality::Good, Quality::Bad, Quality::Good, Quality::Missing]);
    let note = "\"PV.Quality\" are interpreted as 1 or true for good";
    assert!(said(&reading).contains(note), "{}", said(&reading));
    assert_eq!(*cells(&read("flags.parquet"), "Pump"), numbers(|_| 1.0));
}

/// A column of a million equal cells is read, for all its file is small.
#[test]
fn a_constant_is_not_mistaken_for_damage() {
    let sheet = read("constant.parquet");
    assert_eq!(*cells(&sheet, "OP"), Cells::Numbers(vec![1.5; 1_000_000]));
}
