//! Workbooks of Excel and OpenDocument: their times, numbers, merged names, sheets, and damage.

use crate::fixture;
use std::io::Write;
use stiction_io::reading::{self, Reading};
use stiction_io::workbook::workbook_sheets;
use stiction_io::{ReadOptions, options::Mapped};
use stiction_recording::recording::{Quality, Recording};

/// 2025-03-14 23:59:40, the first time in all fixtures.
const START: f64 = 1_741_996_780.0;
const ROWS: usize = 60;

fn with(name: &str, options: &ReadOptions) -> Reading {
    reading::parse(&fixture(name), name, options).expect(name)
}

fn read(name: &str) -> Reading {
    with(name, &ReadOptions::default())
}

/// The samples of the loop from which the fixtures were made: SP, PV, OP.
fn samples() -> Vec<[f64; 3]> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/FIC101-sticky.csv");
    let text = std::fs::read_to_string(path).expect("the sample");
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        [cells[1], cells[2], cells[3]]
    };
    text.lines().skip(1).take(ROWS).map(row).collect()
}

fn names(reading: &Reading) -> Vec<&str> {
    reading.recordings.iter().map(|each| &*each.name).collect()
}

/// Checks start, step, and every usable value of OP and PV. The writer of the fixtures keeps 16 digits.
fn check(recording: &Recording, pv_of: impl Fn(f64) -> f64) {
    assert_eq!(recording.start, Some(START));
    let samples = samples();
    let pv = recording.pv.as_ref().expect("a PV");
    for (channel, value) in [(&recording.op, 2), (pv, 1)] {
        assert_eq!(channel.values.len(), ROWS);
        for k in 0..ROWS {
            assert_eq!(channel.time[k], k as f64, "row {k}");
            if channel.quality[k].is_usable() {
                let value = samples[k][value];
                let value = if std::ptr::eq(channel, pv) { pv_of(value) } else { value };
                assert!((channel.values[k] - value).abs() <= 1e-15 * value.abs(), "row {k}");
            }
        }
    }
}

#[test]
fn titles_a_merged_tag_units_errors_and_words() {
    let reading = read("trend.xlsx");
    assert_eq!(names(&reading), ["FIC101"]);
    let [recording] = &reading.recordings[..] else { panic!("one loop") };
    check(recording, |pv| pv);
    let pv = recording.pv.as_ref().unwrap();
    assert_eq!(pv.unit.as_deref(), Some("m3/h"));
    assert_eq!(pv.quality[10..13], [Quality::Missing, Quality::Bad, Quality::Good]);
    assert_eq!(recording.op.quality[12], Quality::Missing);
    assert!(reading.notes.iter().any(|note| note.contains("\"Info\"")), "{:?}", reading.notes);
}

#[test]
fn days_since_1904_and_two_loops_under_merged_tags() {
    let reading = read("two_loops_1904.xlsx");
    assert_eq!(names(&reading), ["FIC101", "LIC102"]);
    check(&reading.recordings[0], |pv| pv);
    check(&reading.recordings[1], |pv| pv / 2.0);
}

/// Whole numbers around 1000 beside numbers with three decimals are what the workbook says.
#[test]
fn elapsed_time_beyond_a_day_and_numbers_around_a_thousand() {
    let reading = read("elapsed.xlsx");
    let [recording] = &reading.recordings[..] else { panic!("one loop") };
    assert_eq!(recording.start, None);
    assert_eq!(recording.op.time[..3], [86_380.0, 86_381.0, 86_382.0]);
    assert_eq!(recording.op.time[ROWS - 1], 86_380.0 + 59.0);
    assert_eq!(recording.pv.as_ref().unwrap().values[..2], [1000.06, 1000.0]);
}

#[test]
fn several_sheets_are_named_or_chosen() {
    let reading = read("days.xlsx");
    assert_eq!(names(&reading), ["Monday.FIC101", "Tuesday.FIC101"]);
    assert!(
        reading.notes.iter().any(|note| note.contains("give part Monday")),
        "{:?}",
        reading.notes
    );
    let sheet = |name: &str| ReadOptions { part: Some(name.to_owned()), ..ReadOptions::default() };
    let reading = with("days.xlsx", &sheet("tuesday"));
    assert_eq!(names(&reading), ["FIC101"]);
    assert_eq!(reading.recordings[0].start, Some(START + 86_400.0));
    let refused = reading::parse(&fixture("days.xlsx"), "days.xlsx", &sheet("Friday"));
    let message = refused.unwrap_err().to_string();
    assert!(
        message.contains("no sheet \"Friday\"") && message.contains("\"Monday\", \"Tuesday\""),
        "{message}"
    );
    let refused = reading::parse(b"t,op\n0,50\n1,51\n", "f.csv", &sheet("Friday"));
    assert!(refused.unwrap_err().to_string().contains("has no sheets to choose from"));
}

#[test]
fn a_long_table_of_old_excel_with_merged_tags() {
    let reading = read("long.xls");
    assert_eq!(names(&reading), ["FIC101"]);
    check(&reading.recordings[0], |pv| pv);
    assert_eq!(reading.recordings[0].op.quality[5], Quality::Bad);
}

#[test]
fn a_day_and_a_time_of_day_of_opendocument() {
    let reading = read("date_and_time.ods");
    assert_eq!(names(&reading), ["FIC101"]);
    check(&reading.recordings[0], |pv| pv);
    assert_eq!(reading.recordings[0].op.quality[7], Quality::Missing);
}

#[test]
fn errors_name_sheet_row_and_column() {
    let map: Vec<Mapped> = vec!["sp=Timestamp".parse().unwrap(), "time=FIC101 SP".parse().unwrap()];
    let options = ReadOptions { map, ..ReadOptions::default() };
    let message =
        reading::parse(&fixture("trend.xlsx"), "trend.xlsx", &options).unwrap_err().to_string();
    assert!(message.contains("trend.xlsx, sheet \"Trend 1\", "), "{message}");
    let text =
        |cell: &str| ReadOptions { bad_text: vec![cell.to_owned()], ..ReadOptions::default() };
    assert!(reading::parse(&fixture("trend.xlsx"), "f.xlsx", &text("x")).is_ok());
}

/// An archive with these entries.
fn archive(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(vec![]));
    for (name, content) in entries {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn refusal(bytes: &[u8]) -> String {
    workbook_sheets(bytes, "f").expect_err("no workbook").to_string()
}

#[test]
fn other_archives_and_encrypted_workbooks_are_refused_with_a_remedy() {
    let message = refusal(&archive(&[("readme.txt", b"x")]));
    assert!(message.contains("a ZIP archive without a workbook; unpack it"), "{message}");
    let name: Vec<u8> = "EncryptedPackage".bytes().flat_map(|byte| [byte, 0]).collect();
    let message =
        refusal(&[&b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"[..], &[0; 900], &name, &[0; 900]].concat());
    assert!(message.contains("encrypted with a password; save it without a password"), "{message}");
    assert!(
        refusal(&archive(&[("word/document.xml", b"<x/>"), ("xl/workbook.xml", b"<x")]))
            .contains("save it as .xlsx")
    );
}

/// A sheet that no times make a recording is named, and the others are read.
#[test]
fn a_summary_beside_a_loop_is_left_out() {
    let sheet = |name: &str, rows: &[&[&str]]| {
        let cell = |cell: &&str| match cell.parse::<f64>() {
            Ok(_) => {
                format!("<table:table-cell office:value-type=\"float\" office:value=\"{cell}\"/>")
            }
            Err(_) => format!(
                "<table:table-cell office:value-type=\"string\"><text:p>{cell}</text:p></table:table-cell>"
            ),
        };
        let row = |row: &&[&str]| {
            let cells = row.iter().map(cell).collect::<String>();
            format!("<table:table-row>{cells}</table:table-row>")
        };
        let rows = rows.iter().map(row).collect::<String>();
        format!("<table:table table:name=\"{name}\">{rows}</table:table>")
    };
    let pivot = sheet("Pivot", &[&["Row Labels", "Average of OP"], &["6", "44.9"], &["7", "45.1"]]);
    let trend = sheet("Trend", &[&["t", "PV", "OP"], &["0", "1", "50"], &["1", "2", "51"]]);
    let book = |sheets: &str| {
        let content = format!(
            "<office:document-content><office:body><office:spreadsheet>{sheets}</office:spreadsheet></office:body>\
             </office:document-content>"
        );
        let bytes = archive(&[
            ("mimetype", b"application/vnd.oasis.opendocument.spreadsheet"),
            ("META-INF/manifest.xml", b"<manifest:manifest/>"),
            ("content.xml", content.as_bytes()),
        ]);
        reading::parse(&bytes, "f.ods", &ReadOptions::default())
    };
    let reading = book(&format!("{pivot}{trend}")).unwrap();
    assert_eq!(reading.recordings[0].op.values, [50.0, 51.0]);
    let note = "sheet \"Pivot\" has no column of times and is not read";
    assert!(reading.notes.iter().any(|said| said == note), "{:?}", reading.notes);
    assert!(book(&pivot).unwrap_err().to_string().contains("has no column of times"));
}

/// What is short in the file and long in memory is refused before it is decoded.
#[test]
fn bombs_are_refused() {
    let spaces = vec![b' '; 200 << 20];
    let message = refusal(&archive(&[("xl/workbook.xml", &spaces)]));
    assert!(message.contains("far more than a file of this size should take"), "{message}");
    let row = |cells: &str| {
        format!(
            "<table:table table:name=\"a\"><table:table-row table:number-rows-repeated=\"900000\">{cells}\
             </table:table-row></table:table>"
        )
    };
    let content = row(
        "<table:table-cell office:value-type=\"float\" office:value=\"1\" table:number-columns-repeated=\"100\"/>",
    );
    let message = refusal(&archive(&[
        ("mimetype", b"application/vnd.oasis.opendocument.spreadsheet"),
        ("content.xml", content.as_bytes()),
    ]));
    assert!(message.contains("would take more than"), "{message}");
}

#[test]
fn damage_is_refused_without_a_panic() {
    for name in ["trend.xlsx", "long.xls", "date_and_time.ods"] {
        let bytes = fixture(name);
        let mut refused = 0;
        for k in 0..120 {
            let cut = workbook_sheets(&bytes[..bytes.len() * k / 120], name);
            assert!(cut.is_err() || name == "long.xls", "{name} cut to {k} of 120");
            let mut damaged = bytes.clone();
            let at = (k * 7919 + 513) % bytes.len();
            for (offset, byte) in damaged[at..].iter_mut().take(1 + k % 4).enumerate() {
                *byte = byte.wrapping_add((37 + 11 * k + offset) as u8 | 1);
            }
            if let Err(error) = workbook_sheets(&damaged, name) {
                assert!(error.to_string().starts_with(name), "{error}");
                refused += 1;
            }
        }
        assert!(refused > 0, "{name}");
    }
}

#[test]
fn csv_compressed_with_gzip_is_read() {
    let text = b"t,pv,op\n0,1,50\n1,2,51\n2,3,52\n";
    let mut packed = flate2::write::GzEncoder::new(vec![], flate2::Compression::default());
    packed.write_all(text).unwrap();
    let packed = packed.finish().unwrap();
    let reading = reading::parse(&packed, "f.csv.gz", &ReadOptions::default()).unwrap();
    assert_eq!(reading.recordings[0].op.values, [50.0, 51.0, 52.0]);
    let cut = reading::parse(&packed[..packed.len() - 9], "f.csv.gz", &ReadOptions::default());
    assert!(cut.unwrap_err().to_string().contains("cannot be unpacked with gzip"));
}
