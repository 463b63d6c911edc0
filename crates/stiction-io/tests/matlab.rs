//! MATLAB files are read as what they mean, whatever their version and byte order.

use crate::{fixture, level5};

use level5::Writer;
use stiction_io::matlab::matlab_sheets;
use stiction_io::options::{Mapped, ReadOptions};
use stiction_io::reading::{self, Reading};
use stiction_io::sheet::{Cells, Sheet};

/// The fixtures' loop, as `fixtures/make_fixtures.py` writes it.
const ROWS: usize = 40;

fn read(name: &str) -> Vec<Sheet> {
    matlab_sheets(&fixture(name), name).expect("a well-formed file")
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

/// What is left out, with its reason.
fn left_out(sheet: &Sheet) -> Vec<(&str, &str)> {
    sheet.left_out.iter().map(|each| (&*each.name, &*each.why)).collect()
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
        assert_eq!(attributes(second), [("type", "1"), ("SP", "100")]);
        assert_eq!(second.notes, ["SP is a single number, used for the whole recording"]);
        let expected = [
            ("raw", "has 7 values where most have 40"),
            ("limits", "has 2 values where most have 40"),
        ];
        assert_eq!(left_out(second), expected);
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
    assert_eq!(attributes(sheet), [("datenum", "t"), ("title", "Füllstand")]);
    let expected = [("z", "is an array of complex numbers"), ("sparse", "is a sparse array")];
    assert_eq!(left_out(sheet)[..2], expected);
}

#[test]
fn columns_of_a_matrix() {
    let sheets = read("matrix.mat");
    assert_eq!(names(&sheets[0]), ["Time", "OP", "PV", "mode"]);
    assert_eq!(numbers(&sheets[0], "OP"), each(op));
    assert_eq!(sheets[0].columns[3].cells, Cells::Text(["MAN"; ROWS].into_iter().collect()));
    assert!(
        left_out(&sheets[0])
            .contains(&("wide", "is a matrix of 3 rows and 5 columns, not a vector"))
    );
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
    let [note] = &sheets[0].notes[..] else { panic!("one note") };
    assert!(note.starts_with("sheet is a timetable, which only MATLAB reads"), "{note}");
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

const LITTLE: Writer = Writer { big_endian: false };

/// Times and OP of ten samples beside other variables.
fn workspace(others: &[Vec<u8>]) -> Vec<u8> {
    let ramp: Vec<f64> = (0..10).map(f64::from).collect();
    let own = [LITTLE.doubles("t", &ramp), LITTLE.doubles("op", &ramp)];
    LITTLE.file(&[&own[..], others].concat())
}

fn parsed(bytes: &[u8], ignored: &[&str]) -> stiction_io::Result<Reading> {
    let map: Vec<Mapped> =
        ignored.iter().map(|name| format!("ignore={name}").parse().expect("a mapping")).collect();
    reading::parse(bytes, "f.mat", &ReadOptions { map, ..ReadOptions::default() })
}

/// Signals that cannot be used, with the reason: another length, complex, sparse, three-dimensional.
fn unusable(name: &str) -> [(Vec<u8>, &'static str); 4] {
    let w = LITTLE;
    let numbers = |count: u32| w.element(9, &vec![0; 8 * count as usize]);
    [
        (w.doubles(name, &[1.0; 9]), "it has 9 values where most have 10"),
        (
            w.array(6 | 0x0800, &[1, 10], name, &[numbers(10), numbers(10)]),
            "it is an array of complex numbers",
        ),
        (w.array(5, &[10, 1], name, &[numbers(2)]), "it is a sparse array"),
        (w.array(6, &[2, 3, 10], name, &[numbers(60)]), "it is a matrix of 2 rows and 30 columns"),
    ]
}

/// A loop is not judged on its OP alone because its PV cannot be used; who leaves it out knows.
#[test]
fn a_signal_that_cannot_be_used_is_not_passed_over() {
    for (pv, why) in unusable("pv") {
        let message =
            parsed(&workspace(std::slice::from_ref(&pv)), &[]).expect_err(why).to_string();
        assert!(
            message.contains("f.mat: has \"pv\", which is the PV by its name, but"),
            "{message}"
        );
        assert!(message.contains(why) && message.contains("map ignore=pv"), "{message}");
        let reading = parsed(&workspace(&[pv]), &["pv"]).expect("it is left out");
        let [recording] = &reading.recordings[..] else { panic!("one loop") };
        assert!(recording.pv.is_none() && recording.op.values.len() == 10);
    }
    // The OP of that loop is no less a signal.
    let w = LITTLE;
    let ramp: Vec<f64> = (0..10).map(f64::from).collect();
    let odd = w.doubles("op", &[1.0; 9]);
    let file = w.file(&[w.doubles("t", &ramp), w.doubles("pv", &ramp), odd]);
    let message = parsed(&file, &[]).expect_err("it has no OP").to_string();
    assert!(
        message.contains("\"op\", which is the OP by its name, but it has 9 values"),
        "{message}"
    );
}

/// What is no signal, or holds nothing, is named among the columns and in a note, and the loop is read.
#[test]
fn everything_that_is_left_out_is_named() {
    let empty = (LITTLE.array(6, &[0, 0], "pv", &[LITTLE.element(9, &[])]), "it is empty");
    let single = (LITTLE.doubles("vp", &[50.0]), "it is a single number");
    for (variable, why) in unusable("extra").into_iter().chain([empty, single]) {
        let reading = parsed(&workspace(&[variable]), &[]).expect(why);
        let column = reading.recognised.last().expect("columns");
        assert!(column.why.starts_with(why), "{}", column.why);
        let note = format!("\"{}\" {}", column.column, &why["it ".len()..]);
        assert!(reading.notes.iter().any(|each| each.starts_with(&note)), "{:?}", reading.notes);
        assert_eq!(reading.recordings.len(), 1);
    }
}

/// One loop of several that cannot be read costs no other.
#[test]
fn a_loop_that_cannot_be_read_is_listed() {
    let w = LITTLE;
    let of = |count: usize| {
        let ramp: Vec<f64> = (0..10).map(f64::from).collect();
        [w.doubles("", &ramp), w.doubles("", &ramp), w.doubles("", &ramp[..count])]
    };
    let names = ["t", "op", "pv"];
    let file = w.file(&[w.structure("a", &names, &of(10)), w.structure("b", &names, &of(9))]);
    let reading = parsed(&file, &[]).expect("one of them is read");
    assert_eq!(reading.recordings.iter().map(|read| &*read.name).collect::<Vec<_>>(), ["a"]);
    let [missing] = &reading.missing[..] else { panic!("one is missing") };
    assert!(missing.name == "b" && missing.is_partly_here, "{missing:?}");
    assert!(missing.reason.contains("it has 9 values where most have 10"), "{}", missing.reason);
}

/// A link to another file is not followed, and not passed over.
#[test]
fn a_link_to_another_file_is_named() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/link_v73.mat");
    let bytes = std::fs::read(path).expect("a fixture");
    let message = parsed(&bytes, &[]).expect_err("its PV is elsewhere").to_string();
    assert!(message.contains("\"PV\"") && message.contains("a link to another file"), "{message}");
    assert!(parsed(&bytes, &["PV"]).is_ok());
}

/// A struct that Simulink logs: its times, and for each signal dimensions and values, its label, and its block.
fn simulink(w: Writer, times: &[f64], signals: &[(&[u32], &[f64], &str, &str)]) -> Vec<u8> {
    let each = |(dims, values, label, block): &(&[u32], &[f64], &str, &str)| {
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let values = w.array(6, dims, "", &[w.element(9, &data)]);
        [values, w.text("", label), w.text("", block)].concat()
    };
    let fields: Vec<Vec<u8>> = signals.iter().map(each).collect();
    let signals = w.structures("", &["values", "label", "blockName"], &fields);
    let names = ["time", "signals", "blockName"];
    w.structure("ScopeData", &names, &[w.doubles("", times), signals, w.text("", "model/Scope")])
}

fn ramp(from: f64) -> Vec<f64> {
    (0..10).map(|k| from + f64::from(k)).collect()
}

#[test]
fn simulink_names_its_signals_by_labels_or_blocks() {
    let w = LITTLE;
    let both: Vec<f64> = (0..10).flat_map(|k| [f64::from(k), 100.0 - f64::from(k)]).collect();
    let file = simulink(
        w,
        &ramp(0.0),
        &[
            (&[10, 1], &ramp(50.0), "<OP>", "model/Controller"),
            (&[1, 1, 10], &ramp(1.0), "", "model/Flow\nPV"),
            // Time is the last dimension.
            (&[2, 1, 10], &both, "x", ""),
            (&[10, 1], &ramp(2.0), "x(:,1)", ""),
            (&[3, 1], &[1.0, 2.0, 3.0], "short", ""),
        ],
    );
    let sheets = matlab_sheets(&w.file(&[file]), "f.mat").expect("a log");
    let [sheet] = &sheets[..] else { panic!("one sheet") };
    assert_eq!(names(sheet), ["time", "OP", "Flow PV", "x(:,1)", "x(:,2)", "x(:,1)(2)"]);
    assert_eq!(numbers(sheet, "Flow PV"), ramp(1.0));
    assert_eq!(numbers(sheet, "x(:,2)")[..2], [100.0, 99.0]);
    assert_eq!(numbers(sheet, "x(:,1)(2)"), ramp(2.0));
    assert_eq!(left_out(sheet), [("short", "has 3 values for 10 times")]);
}

/// The format "Structure" has no times of its own.
#[test]
fn simulink_without_times_uses_those_of_the_simulation() {
    let w = LITTLE;
    let log =
        simulink(w, &[], &[(&[10, 1], &ramp(50.0), "OP", ""), (&[10, 1], &ramp(1.0), "PV", "")]);
    let sheets = matlab_sheets(&w.file(std::slice::from_ref(&log)), "f.mat").expect("a log");
    assert_eq!(names(&sheets[0]), ["OP", "PV"]);
    let sheets =
        matlab_sheets(&w.file(&[w.doubles("tout", &ramp(5.0)), log]), "f.mat").expect("a log");
    let log = sheets.iter().find(|sheet| sheet.part == "ScopeData").expect("the log");
    assert_eq!((names(log), numbers(log, "tout")), (vec!["tout", "OP", "PV"], &ramp(5.0)[..]));
}

#[test]
fn objects_of_simulink_are_refused_with_the_command_that_converts_them() {
    for (class, expected) in [
        ("timeseries", "t = x.Time; pv = x.Data; save(..., 't', 'pv', '-v7')"),
        ("Simulink.SimulationData.Dataset", "\"Structure With Time\""),
        ("Simulink.SimulationOutput", "x{1}.Values.Data"),
    ] {
        let file = LITTLE.file(&[LITTLE.object("logsout", class)]);
        let message = matlab_sheets(&file, "f.mat").unwrap_err().to_string();
        assert!(message.contains(class) && message.contains(expected), "{message}");
    }
}

#[test]
fn a_refused_file_of_many_variables_has_a_short_message() {
    let all: Vec<Vec<u8>> =
        (0..34).map(|k| LITTLE.object(&format!("loop_{k}"), "timetable")).collect();
    let message = matlab_sheets(&LITTLE.file(&all), "f.mat").unwrap_err().to_string();
    assert!(message.len() < 600, "{} characters: {message}", message.len());
    assert!(
        message.contains("\"loop_4\" and 29 more: is a timetable, which only MATLAB reads"),
        "{message}"
    );
}

/// A column of one part is found there, even if another part has none of that name.
#[test]
fn a_named_column_may_be_in_one_part_only() {
    let w = LITTLE;
    let of = |names: [&str; 2]| {
        let fields = names.map(|_| w.doubles("", &ramp(50.0)));
        w.structure(names[1], &names, &fields)
    };
    let file = w.file(&[of(["t", "y"]), of(["t", "z"])]);
    let map: Vec<Mapped> = vec!["op=z".parse().unwrap()];
    let options = ReadOptions { map, ..ReadOptions::default() };
    let reading = reading::parse(&file, "f.mat", &options).expect("z is there");
    assert_eq!(reading.recordings[0].op.values, ramp(50.0));
    assert!(
        reading.notes.iter().any(|note| note.starts_with("y is not read: ")),
        "{:?}",
        reading.notes
    );
}

/// A matrix of version 4: the type, then rows, columns, whether complex, the name, the bytes.
fn version_4(kind: u32, (rows, cols): (u32, u32), name: &str, big: bool, data: &[u8]) -> Vec<u8> {
    let words = [kind, rows, cols, 0, name.len() as u32 + 1];
    let word = |word: &u32| if big { word.to_be_bytes() } else { word.to_le_bytes() };
    [&words.iter().flat_map(word).collect::<Vec<u8>>(), name.as_bytes(), &[0], data].concat()
}

#[test]
fn version_4_in_either_byte_order_and_precision() {
    let op: Vec<u8> = ramp(50.0).iter().flat_map(|v| v.to_le_bytes()).collect();
    let pv: Vec<u8> = (0..10i16).flat_map(|v| (v - 3).to_le_bytes()).collect();
    let little = [
        version_4(0, (10, 1), "op", false, &op),
        version_4(30, (1, 10), "pv", false, &pv),
        version_4(51, (1, 3), "tag", false, b"FC7"),
    ];
    let reading = parsed(
        &[little.concat(), version_4(0, (1, 1), "Ts", false, &2f64.to_le_bytes())].concat(),
        &[],
    );
    let recording = &reading.expect("a workspace").recordings[0];
    assert_eq!((&*recording.name, recording.op.time[9]), ("FC7", 18.0));
    assert_eq!(recording.op.values, ramp(50.0));
    assert_eq!(recording.pv.as_ref().unwrap().values, ramp(-3.0));
    let single: Vec<u8> = ramp(50.0).iter().flat_map(|v| (*v as f32).to_be_bytes()).collect();
    let sheets = matlab_sheets(&version_4(1010, (10, 1), "op", true, &single), "f.mat").unwrap();
    assert_eq!(numbers(&sheets[0], "op"), ramp(50.0));
    let sparse = matlab_sheets(&version_4(2, (10, 1), "op", false, &op), "f.mat").unwrap_err();
    assert!(sparse.to_string().contains("a sparse array"), "{sparse}");
    let huge = version_4(0, (u32::MAX, u32::MAX), "op", false, &op);
    assert!(matlab_sheets(&huge, "f.mat").unwrap_err().to_string().contains("cut short"));
    for cut in 1..little[0].len() {
        assert!(parsed(&little[0][..cut], &[]).is_err(), "{cut}");
    }
}
