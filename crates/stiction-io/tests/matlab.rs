//! MATLAB files are read as what they mean, whatever their version and byte order.

mod level5;

use level5::Writer;
use stiction_io::matlab_file::matlab_sheets;
use stiction_io::sheet::{Cells, Sheet};

/// The fixtures' loop, as `fixtures/make_fixtures.py` writes it.
const ROWS: usize = 40;

fn read(name: &str) -> Vec<Sheet> {
    let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    matlab_sheets(&std::fs::read(path).expect("a fixture"), name).expect("a well-formed file")
}

fn parts(sheets: &[Sheet]) -> Vec<&str> {
    sheets.iter().map(|sheet| &*sheet.part).collect()
}

fn names(sheet: &Sheet) -> Vec<&str> {
    sheet.columns.iter().map(|column| &*column.name).collect()
}

fn numbers<'s>(sheet: &'s Sheet, name: &str) -> &'s [f64] {
    let column = sheet.columns.iter().find(|column| column.name == name).expect("the column");
    match &column.cells {
        Cells::Numbers(numbers) => numbers,
        other => panic!("{name} holds {other:?}"),
    }
}

fn attributes(sheet: &Sheet) -> Vec<(&str, &str)> {
    sheet.attributes.iter().map(|(key, value)| (&**key, &**value)).collect()
}

/// What each row should hold.
fn each(value: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..ROWS).map(|k| value(k as f64)).collect()
}

fn op(k: f64) -> f64 {
    50.0 + 0.5 * k
}

fn pv(k: f64) -> f64 {
    2.0 * op(k) + 0.25
}

/// The stiction data base: plain with columns, compressed with rows.
#[test]
fn structs_of_structs() {
    for name in ["isdb_plain.mat", "isdb_zip.mat"] {
        let sheets = read(name);
        assert_eq!(
            parts(&sheets),
            ["cdata.chemicals.loop1", "cdata.chemicals.loop2", "cdata.mining.loop1"]
        );
        let [first, second, third] = &sheets[..] else { panic!("three sheets") };
        for sheet in &sheets {
            assert_eq!((sheet.len(), &*sheet.origin), (ROWS, name));
            assert_eq!(names(sheet), ["t", "SP", "PV", "OP"]);
            assert_eq!(numbers(sheet, "OP"), each(op));
            assert_eq!(numbers(sheet, "PV"), each(pv));
        }
        assert_eq!(first.sample_time, Some(2.5));
        assert_eq!(numbers(first, "t"), each(|k| 2.5 * k));
        assert_eq!(
            attributes(first),
            [("comments", "Flow loop, sticky"), ("type", "0"), ("Kc", "0.5")]
        );
        assert_eq!(second.sample_time, Some(60.0));
        assert_eq!(numbers(second, "SP"), vec![100.0; ROWS]);
        assert_eq!(
            attributes(second),
            [
                ("type", "1"),
                ("SP", "100"),
                ("note", "SP is a single number, held"),
                ("note", "raw has 7 values where most have 40; left out"),
                ("note", "limits has 2 values where most have 40; left out"),
            ]
        );
        assert_eq!(numbers(third, "SP"), each(|k| pv(k) - 1.0));
    }
}

#[test]
fn variables_of_every_class() {
    let sheets = read("vectors.mat");
    let [sheet] = &sheets[..] else { panic!("one sheet") };
    assert_eq!((&*sheet.part, sheet.sample_time), ("", Some(0.5)));
    assert_eq!(names(sheet), ["t", "op", "pv", "n", "u8", "i64", "on"]);
    assert_eq!(numbers(sheet, "t"), each(|k| k / 86_400.0 + 738_000.0));
    assert_eq!(numbers(sheet, "op"), each(op));
    assert_eq!(numbers(sheet, "pv"), each(pv));
    assert_eq!(numbers(sheet, "n"), each(|k| k));
    assert_eq!(numbers(sheet, "u8"), each(|k| k));
    assert_eq!(numbers(sheet, "i64"), each(|k| -k));
    assert_eq!(numbers(sheet, "on"), each(|k| f64::from(k % 2.0 == 0.0)));
    assert_eq!(
        attributes(sheet),
        [
            ("datenum", "t"),
            ("title", "Füllstand"),
            ("note", "z is an array of complex numbers; left out"),
            ("note", "sparse is a sparse array; left out"),
        ]
    );
}

#[test]
fn columns_of_a_matrix() {
    let sheets = read("matrix.mat");
    assert_eq!(names(&sheets[0]), ["Time", "OP", "PV", "mode"]);
    assert_eq!(numbers(&sheets[0], "OP"), each(op));
    assert_eq!(sheets[0].columns[3].cells, Cells::Text(vec!["MAN".to_owned(); ROWS]));
    let wide = ("note", "wide is a matrix of 3 rows and 5 columns; left out");
    assert!(attributes(&sheets[0]).contains(&wide));
    let sheets = read("numbered.mat");
    assert_eq!((parts(&sheets), names(&sheets[0])), (vec!["run"], vec!["data(:,1)", "data(:,2)"]));
    assert_eq!(numbers(&sheets[0], "data(:,2)"), each(pv));
}

#[test]
fn arrays_of_structs_and_cells() {
    let sheets = read("array.mat");
    assert_eq!(parts(&sheets), ["loops(1)", "loops(2)", "loops(3)", "more{1}"]);
    assert_eq!(numbers(&sheets[2], "OP"), each(|k| op(k) + 2.0));
}

#[test]
fn version_7_3() {
    let sheets = read("isdb_v73.mat");
    assert_eq!(parts(&sheets), ["cdata.chemicals.loop1", "cdata.chemicals.loop2"]);
    assert_eq!(names(&sheets[0]), ["OP", "PV", "SP", "t"]);
    assert_eq!(numbers(&sheets[0], "PV"), each(pv));
    assert_eq!(numbers(&sheets[0], "SP"), vec![100.0; ROWS]);
    assert_eq!(sheets[0].sample_time, Some(2.5));
    assert_eq!(
        attributes(&sheets[0]),
        [("Kc", "0.5"), ("comments", "Flow loop, sticky"), ("type", "0")]
    );
    let sheets = read("references_v73.mat");
    assert_eq!(parts(&sheets), ["loops(1)", "loops(2)", "table"]);
    assert_eq!(numbers(&sheets[1], "OP"), each(|k| op(k) + 1.0));
    assert_eq!(names(&sheets[2]), ["Time", "OP"]);
    assert_eq!(numbers(&sheets[2], "OP"), each(op));
    let (key, note) = &sheets[0].attributes[0];
    assert!(key == "note" && note.starts_with("sheet is a timetable, which only MATLAB reads"));
}

#[test]
fn both_byte_orders() {
    let file = |big_endian| {
        let w = Writer { big_endian };
        let names = ["PV", "OP", "who", "tags", "Ts"];
        let tags = [w.text("", "Durchfluß"), w.text("", "Ventil")];
        let fields = [
            w.doubles("", &[1.5, -2.0, 1e300]),
            w.shorts("", &[-300, 7, 301]),
            w.text("", "Füllstand 𝄞"),
            w.cell("", &tags),
            w.doubles("", &[0.25]),
        ];
        w.file(&[w.structure("run", &names, &fields)])
    };
    let [little, big] =
        [false, true].map(|big| matlab_sheets(&file(big), "f.mat").expect("a well-formed file"));
    assert_eq!(little, big);
    let [sheet] = &big[..] else { panic!("one sheet") };
    assert_eq!((&*sheet.part, sheet.sample_time), ("run", Some(0.25)));
    assert_eq!(numbers(sheet, "PV"), [1.5, -2.0, 1e300]);
    assert_eq!(numbers(sheet, "OP"), [-300.0, 7.0, 301.0]);
    assert_eq!(attributes(sheet), [("who", "Füllstand 𝄞"), ("tags", "Durchfluß; Ventil")]);
}

/// A vector alone is a sheet only where there is no better one.
#[test]
fn single_vectors_count_where_there_are_no_others() {
    let w = Writer { big_endian: false };
    let single = w.structure("limits", &["range"], &[w.doubles("", &[0.0, 100.0])]);
    let sheets = matlab_sheets(&w.file(std::slice::from_ref(&single)), "f.mat").expect("read");
    assert_eq!(parts(&sheets), ["limits"]);
    let run = [w.doubles("", &[1.0, 2.0, 3.0]), w.doubles("", &[4.0, 5.0, 6.0])];
    let run = w.structure("run", &["PV", "OP"], &run);
    let sheets = matlab_sheets(&w.file(&[single, run]), "f.mat").expect("read");
    assert_eq!(parts(&sheets), ["run"]);
}
