//! Numbers in every notation, ranges of the OP, qualities and modes.

use crate::said;
use proptest::prelude::*;
use stiction_io::number::DecimalMark;
use stiction_io::reading::{self, Reading};
use stiction_io::{Error, ReadOptions, mode, quality};
use stiction_recording::recording::{Doubt, Mode, Quality, RangeSource, Recording};

fn parsed(text: &str, options: &ReadOptions) -> Result<Reading, Error> {
    reading::parse(text.as_bytes(), "file.csv", options)
}

fn read(text: &str) -> Recording {
    parsed(text, &ReadOptions::default()).expect("a readable file").recordings.remove(0)
}

fn refused(text: &str) -> String {
    parsed(text, &ReadOptions::default()).expect_err("a refusal").to_string()
}

fn with_mark(text: &str, mark: DecimalMark) -> Recording {
    let options = ReadOptions { decimal_mark: Some(mark), ..ReadOptions::default() };
    parsed(text, &options).expect("a readable file").recordings.remove(0)
}

fn pv(recording: &Recording) -> &[f64] {
    &recording.pv.as_ref().expect("a PV").values
}

/// A table of times, one cell of a PV and one of an OP in each row.
fn table(header: &str, rows: &[&str]) -> String {
    let rows = rows.iter().enumerate().map(|(k, row)| format!("2023-03-04 08:00:{k:02};{row}\n"));
    format!("Zeit;{header}\n{}", rows.collect::<String>())
}

#[test]
fn thousands_across_1000_are_decided_by_the_whole_column() {
    for (header, rows, expected) in [
        (
            "F.PV;F.SP;F.OP",
            &["1.001;1.000;45", "999;1.000;46", "1.002;1.000;45"][..],
            [1001.0, 999.0, 1002.0],
        ),
        (
            "F.PV;F.SP;F.OP",
            &["-998;-1,000;45", "-1,003;-1,000;46", "-999;-1,000;45"],
            [-998.0, -1003.0, -999.0],
        ),
        ("F.PV;F.OP", &["999;45", "Bad;46", "1.002;45"], [999.0, f64::NAN, 1002.0]),
        ("F.PV;F.OP", &["1.234,5;45", "999;46,25", "1.001;45"], [1234.5, 999.0, 1001.0]),
        ("F.PV;F.OP", &["1,234.5;45", "999.5;46", "1,001.0;45"], [1234.5, 999.5, 1001.0]),
        ("F.PV;F.OP", &["1\u{a0}234,5;45", "999,5;46", "1\u{202f}001;45"], [1234.5, 999.5, 1001.0]),
        ("F.PV;F.OP", &["1'234.5;45", "999.5;46", "1'001;45"], [1234.5, 999.5, 1001.0]),
        (
            "F.PV;F.OP",
            &["1.234.567;45", "999.999;46", "1.000.001;45"],
            [1_234_567.0, 999_999.0, 1_000_001.0],
        ),
    ] {
        let recording = read(&table(header, rows));
        for (read, expected) in pv(&recording).iter().zip(expected) {
            assert!(*read == expected || read.is_nan() && expected.is_nan(), "{rows:?}: {read}");
        }
        if let Some(sp) = &recording.sp {
            assert_eq!(sp.values[0].abs(), 1000.0);
        }
    }
}

#[test]
fn a_clock_that_passes_1000_has_thousands_too() {
    let rows: String = (990..1010)
        .map(|k| match k {
            1000.. => format!("1.{:03};50;{}\n", k - 1000, 40 + k % 7),
            _ => format!("{k};50;{}\n", 40 + k % 7),
        })
        .collect();
    let recording = read(&format!("t;PV;OP\n{rows}"));
    assert_eq!(recording.op.time.last(), Some(&1009.0));
}

#[test]
fn tags_in_rows_are_judged_one_by_one() {
    let rows: String = (0..20)
        .flat_map(|k| {
            let time = format!("2023-03-04 08:00:{k:02}");
            let level = 990 + k;
            let level =
                if level < 1000 { level.to_string() } else { format!("1.{:03}", level - 1000) };
            [format!("{time};F.PV;{level}\n"), format!("{time};F.OP;{}\n", 40 + k % 5)]
        })
        .collect();
    let recording = read(&format!("Timestamp;Tag;Value\n{rows}"));
    assert_eq!((pv(&recording)[0], pv(&recording)[19]), (990.0, 1009.0));
}

#[test]
fn ordinary_decimals_stay_without_a_question() {
    for (rows, expected) in [
        (&["60.060;44.970", "60.120;45.000"][..], 60.06),
        (&["60,060;44,970", "60,120;45,000"], 60.06),
        (&["1;45", "1.001;45.5"], 1.0),
        (&["1;45", "1.001;45"], 1.0),
        (&["0.999;45", "1.001;45"], 0.999),
        (&["45;45", "45.125;46", "45.250;45"], 45.0),
    ] {
        let recording = read(&table("F.PV;F.OP", rows));
        assert_eq!(pv(&recording)[0], expected, "{rows:?}");
        assert!(pv(&recording)[1] < 100.0, "{rows:?}");
    }
}

#[test]
fn two_readings_are_a_question_and_either_answer_works() {
    for rows in [
        &["30;45", "1.000;46", "33;45"][..],
        &["999;45", "1.001;46", "1;45", "1.002;44"],
        &["1.001;45", "1,002;46"],
    ] {
        let text = table("F.PV;F.OP", rows);
        let message = refused(&text);
        for said in ["column \"F.PV\"", "two readings", "decimal_mark point", "decimal_mark comma"]
        {
            assert!(message.contains(said), "{said}: {message}");
        }
        let (point, comma) =
            (with_mark(&text, DecimalMark::Point), with_mark(&text, DecimalMark::Comma));
        assert_ne!(pv(&point), pv(&comma), "{rows:?}");
    }
}

#[test]
fn a_column_that_contradicts_the_rest_of_the_file_is_refused() {
    for (rows, remedy) in [
        // The point is the decimal mark of the OP, and the PV jumps with it.
        (&["999;45.5", "1.001;46.5"][..], "give decimal_mark point"),
        // Decimals with a comma beside decimals with a point.
        (&["60,060;45.5", "60,120;46.5"], "give decimal_mark point"),
        (&["60.060;45,5", "60.120;46,5"], "give decimal_mark comma"),
    ] {
        let text = table("F.PV;F.OP", rows);
        let message = refused(&text);
        assert!(message.contains("row 2") || message.contains("row 3"), "{message}");
        assert!(message.contains(remedy), "{message}");
        let mark = if remedy.ends_with("point") { DecimalMark::Point } else { DecimalMark::Comma };
        with_mark(&text, mark);
    }
}

#[derive(Debug, Clone, Copy)]
struct Notation {
    mark: char,
    group: Option<char>,
    decimals: usize,
    trims: bool,
}

impl Notation {
    fn write(self, value: f64) -> String {
        let fixed = format!("{:.*}", self.decimals, value.abs());
        let (whole, decimals) = fixed.split_once('.').unwrap_or((&fixed, ""));
        let decimals = if self.trims { decimals.trim_end_matches('0') } else { decimals };
        let mut grouped = String::new();
        for (k, digit) in whole.chars().enumerate() {
            if k > 0 && (whole.len() - k).is_multiple_of(3) {
                grouped.extend(self.group);
            }
            grouped.push(digit);
        }
        let sign = if value < 0.0 { "-" } else { "" };
        let mark = if decimals.is_empty() { String::new() } else { self.mark.to_string() };
        format!("{sign}{grouped}{mark}{decimals}")
    }
}

fn notations() -> impl Strategy<Value = Notation> {
    let marks = prop_oneof![Just(('.', ',')), Just((',', '.'))];
    let group = prop_oneof![
        Just(None),
        Just(Some('o')),
        Just(Some(' ')),
        Just(Some('\u{a0}')),
        Just(Some('\u{202f}')),
        Just(Some('\''))
    ];
    (marks, group, 0usize..4, any::<bool>()).prop_map(|((mark, other), group, decimals, trims)| {
        let group = group.map(|group| if group == 'o' { other } else { group });
        Notation { mark, group, decimals, trims }
    })
}

proptest! {
    /// A PV that passes 1000 in small steps.
    #[test]
    fn numbers_read_back_the_same_or_are_refused(
        notation in notations(),
        start in 200.0..900.0f64,
        steps in proptest::collection::vec(0.7..1.6f64, 8..40),
        sign in prop_oneof![Just(1.0), Just(-1.0)],
    ) {
        let mut value = start;
        let mut values = vec![start];
        for step in steps {
            value = (value * step).clamp(50.0, 90_000.0);
            values.push(value);
        }
        values.push(400.0);
        let unit = 10f64.powi(notation.decimals as i32);
        let mut values: Vec<f64> =
            values.iter().map(|v| sign * (v * unit).round() / unit).collect();
        // Historians write these for "no value".
        let is_code = |v: &&mut f64| [999.0, 9_999.0, 32_767.0].contains(&v.abs());
        values.iter_mut().filter(is_code).for_each(|v| *v += 1.0);
        let rows: Vec<String> =
            values.iter().map(|v| format!("{};{}", notation.write(*v), 45)).collect();
        let rows: Vec<&str> = rows.iter().map(|row| &**row).collect();
        match parsed(&table("F.PV;F.OP", &rows), &ReadOptions::default()) {
            Ok(reading) => {
                for (read, written) in pv(&reading.recordings[0]).iter().zip(&values) {
                    prop_assert!((read - written).abs() < 1e-6, "{notation:?}: {read} for {written}");
                }
            }
            Err(refusal) => prop_assert!(refusal.to_string().contains("two readings"), "{refusal}"),
        }
    }
}

/// The OP of a table whose OP has this unit and moves between these values.
fn op(unit: &str, low: f64, high: f64) -> Recording {
    let rows: String = (0..40)
        .map(|k| format!("{k},50,{}\n", low + (high - low) * f64::from(k % 8) / 7.0))
        .collect();
    let units = if unit.is_empty() { String::new() } else { format!("s,m3/h,{unit}\n") };
    read(&format!("t,PV,OP\n{units}{rows}"))
}

#[test]
fn a_stated_unit_gives_the_range() {
    for (unit, low, high, range, source) in [
        ("psi", 8.0, 9.0, (3.0, 15.0), RangeSource::Assumed),
        ("psig", 14.0, 24.0, (6.0, 30.0), RangeSource::Assumed),
        ("bar", 0.45, 0.62, (0.2, 1.0), RangeSource::Assumed),
        ("kPa", 55.0, 62.0, (20.0, 100.0), RangeSource::Assumed),
        ("kg/cm2", 0.5, 0.6, (0.2, 1.0), RangeSource::Assumed),
        ("mA", 11.0, 12.5, (4.0, 20.0), RangeSource::Metadata),
        ("mA", 0.5, 12.5, (0.0, 20.0), RangeSource::Assumed),
        ("V", 2.2, 3.1, (1.0, 5.0), RangeSource::Assumed),
        ("V", 2.2, 7.1, (0.0, 10.0), RangeSource::Assumed),
        ("counts", 12_400.0, 13_000.0, (0.0, 27_648.0), RangeSource::Estimated),
        ("%", 45.0, 55.0, (0.0, 100.0), RangeSource::Metadata),
        ("‰", 450.0, 550.0, (0.0, 1000.0), RangeSource::Metadata),
        ("m3/h", 45.0, 55.0, (0.0, 60.0), RangeSource::Estimated),
    ] {
        let found = op(unit, low, high).op.range.unwrap_or_else(|| panic!("{unit}"));
        assert_eq!((found.low, found.high, found.source), (range.0, range.1, source), "{unit}");
    }
    let named = read("t,PV,OP (3-15 psi)\n0,50,8\n1,50,9\n");
    let range = named.op.range.unwrap();
    assert_eq!((range.low, range.high, range.source), (3.0, 15.0, RangeSource::Metadata));
}

#[test]
fn without_a_unit_the_doubt_holds_every_range_that_fits() {
    // The values, the true range, and the percent of the read range that are 4 % of the true one.
    for (low, high, truth) in [
        (12_433.0, 13_100.0, (0.0, 27_648.0)),
        (450.0, 500.0, (0.0, 1000.0)),
        (2_000.0, 2_200.0, (0.0, 4_095.0)),
        (2_000.0, 2_200.0, (0.0, 4_000.0)),
        (4_800.0, 5_200.0, (0.0, 10_000.0)),
        (15_000.0, 16_500.0, (0.0, 32_767.0)),
        (40_000.0, 41_000.0, (0.0, 65_535.0)),
        (6_000.0, 6_300.0, (0.0, 27_648.0)),
        (9_800.0, 10_900.0, (3_277.0, 16_384.0)),
        (11.9, 12.5, (4.0, 20.0)),
        (8.4, 9.1, (3.0, 15.0)),
        (2.8, 3.1, (1.0, 5.0)),
        (4.8, 5.6, (0.0, 10.0)),
        (-20.0, 31.0, (-100.0, 100.0)),
        (-9_000.0, 12_000.0, (-27_648.0, 27_648.0)),
    ] {
        let recording = op("", low, high);
        let range = recording.op.range.unwrap_or_else(|| panic!("{low} to {high}: no range"));
        assert_eq!(range.source, RangeSource::Estimated, "{low} to {high}");
        let doubt = Doubt::of(Some(range));
        let factor = (range.high - range.low) / (truth.1 - truth.0);
        assert!(
            doubt.least <= factor + 1e-9 && factor <= doubt.most + 1e-9,
            "{low} to {high}: {factor} is not within {doubt:?}"
        );
        assert!(
            recording.notes.iter().any(|note| note.contains("op_range")),
            "{:?}",
            recording.notes
        );
    }
}

#[test]
fn ordinary_percent_are_certain() {
    for (low, high) in [(40.0, 60.0), (0.0, 100.0), (15.0, 35.0), (100.0, 20.0)] {
        let recording = op("", low, high);
        assert_eq!(recording.op.range, None, "{low} to {high}");
    }
    let fraction = op("", 0.4, 0.6).op.range.unwrap();
    assert_eq!((fraction.low, fraction.high, fraction.spans), (0.0, 1.0, [1.0, 1.0]));
}

#[test]
fn percent_between_0_and_1_are_rather_fractions() {
    let recording = op("%", 0.43, 0.48);
    let range = recording.op.range.unwrap();
    assert_eq!((range.low, range.high, range.source), (0.0, 1.0, RangeSource::Estimated));
    assert_eq!(range.spans, [1.0, 100.0]);
    let is_noted = |recording: &Recording| {
        recording.notes.iter().any(|note| {
            note.contains("OP is in %, but is between 0 and 1")
                && note.contains("op_range 0,1 ")
                && note.ends_with("op_range 0,100")
        })
    };
    assert!(is_noted(&recording), "{:?}", recording.notes);
    let column = read("t,PV,OP [%]\n0,50,0.43\n1,51,0.44\n2,52,0.45\n");
    assert!(is_noted(&column), "{:?}", column.notes);
    // A valve at rest, mostly shut, or beyond 1 %.
    for (low, high) in [(0.0, 0.0), (0.4, 0.4), (0.4, 1.1), (-0.4, 0.4)] {
        let percent = op("%", low, high);
        assert_eq!(percent.op.range.unwrap().high, 100.0, "{low} to {high}");
        assert!(!is_noted(&percent), "{low} to {high}");
    }
    let shut = read("t,PV,OP [%]\n0,50,0\n1,51,0\n2,52,0.45\n");
    assert_eq!(shut.op.range.unwrap().high, 100.0);
    // A stated range wins.
    let mut given = ReadOptions::default();
    given.all.op_range = Some((0.0, 100.0));
    let text = "t,PV,OP [%]\n0,50,0.43\n1,51,0.44\n2,52,0.45\n";
    let given = parsed(text, &given).unwrap().recordings.remove(0);
    assert_eq!(given.op.range.unwrap().source, RangeSource::Given);
    assert!(!is_noted(&given));
}

#[test]
fn different_values_at_one_time_are_noted() {
    let noted = |second: &str| {
        let rows: String = (0..40).map(|k| format!("{k},50.{},45.5\n", k % 7)).collect();
        let rows = rows.replace("\n20,", &format!("\n{second}\n20,"));
        let recording = read(&format!("t,PV,OP\n{rows}"));
        recording.notes.into_iter().find(|note| note.contains("have the same time"))
    };
    let note = noted("19,51,45.5").unwrap();
    assert!(note.contains("(1 of \"PV\" from row 22 on)"), "{note}");
    let note = noted("19,51,46\n3,52,45.5").unwrap();
    assert!(note.contains("1 of \"OP\" from row 22 on, 2 of \"PV\" from row 23 on"), "{note}");
    for equal in ["19,50.5,45.5", "19,,45.5", "19.5,51,45.5"] {
        assert_eq!(noted(equal), None, "{equal}");
    }
}

#[test]
fn an_op_that_changes_its_scale_is_noted() {
    let noted = |of: &dyn Fn(usize) -> f64| {
        let rows: String = (0..300).map(|k| format!("{k},50,{}\n", of(k))).collect();
        let notes = read(&format!("t,PV,OP\n{rows}")).notes;
        notes.into_iter().find(|note| note.contains("its scale probably changes"))
    };
    let wave = |k: usize| 45.0 + 5.0 * (k as f64 * 0.1).sin();
    let falls = noted(&|k| if k < 200 { wave(k) } else { wave(k) / 100.0 }).unwrap();
    assert!(falls.contains("\"OP\" is between 0 and 1 on one side of row 202 and in percent"));
    let rises = noted(&|k| if k < 100 { wave(k) / 100.0 } else { wave(k) }).unwrap();
    assert!(rises.contains("\"OP\" is between 0 and 1 on one side of row 102 and in percent"));
    // A valve that is shut: at once, with noise near its seat, and along a ramp. A few samples decide nothing.
    assert_eq!(noted(&|k| if k < 200 { wave(k) } else { 0.0 }), None);
    assert_eq!(noted(&|k| if k < 200 { wave(k) } else { 0.1 + 0.01 * (k % 5) as f64 }), None);
    assert_eq!(
        noted(&|k| if k < 200 { 100.0 - 0.497 * k as f64 } else { 1.0 - 0.01 * (k - 200) as f64 }),
        None
    );
    assert_eq!(noted(&|k| if k < 260 { wave(k) } else { wave(k) / 100.0 }), None);
}

#[test]
fn an_sp_far_from_the_pv_in_a_different_unit_is_left_out() {
    let read = |header: &str, sp: f64| {
        let rows = (0..20).map(|k| format!("{k},{},{sp},45.5\n", 60 + k % 3));
        read(&format!("t,{header}\n{}", rows.collect::<String>()))
    };
    let apart = read("F.PV (m3/h),F.SP (l/min),F.OP", 1000.0);
    let wanted = "the SP is in l/min, the PV in m3/h, and they are far apart";
    let note = apart.notes.iter().find(|note| note.contains(wanted));
    assert!(note.is_some_and(|note| note.contains("map ignore=F.SP")), "{:?}", apart.notes);
    assert_eq!(apart.sp, None);
    for (header, sp) in [
        ("F.PV (m3/h),F.SP (l/min),F.OP", 61.0),
        ("F.PV (m3/h),F.SP (m³/h),F.OP", 1000.0),
        ("F.PV (°C),F.SP (degC),F.OP", 1000.0),
        ("F.PV (bar),F.SP (barg),F.OP", 1000.0),
        ("F.PV (m3/h),F.SP,F.OP", 1000.0),
    ] {
        assert!(read(header, sp).sp.is_some(), "{header}");
    }
    assert_eq!(read("F.PV (°C),F.SP (°F),F.OP", 140.0).sp, None);
}

/// A long table with these columns of qualities.
fn long(header: &str, cells: &[&str]) -> String {
    let rows: String = (0..12)
        .flat_map(|k| {
            let quality = cells[k % cells.len()];
            let time = format!("2023-03-04 08:00:{k:02}");
            [("F.PV", 60.5), ("F.OP", 45.25)]
                .map(|(tag, value)| format!("{time};{tag};{};{quality}\n", value + k as f64))
        })
        .collect();
    format!("Timestamp;Tag;Value;{header}\n{rows}")
}

#[test]
fn qualities_as_systems_write_them() {
    let first = |text: &str| read(text).op.quality[..2].to_vec();
    use Quality::{Bad, Good};
    for (header, cells, expected) in [
        ("Status", &["StatusCode(Good)"][..], [Good, Good]),
        ("Status", &["0x00000000 (Good)", "0x80050000 (BadCommunicationError)"], [Good, Bad]),
        ("Status", &["192 (Good)", "Bad (Comm Fail)"], [Good, Bad]),
        ("StatusCode", &["0", "3145728"], [Good, Good]),
        ("Validity", &["1", "0"], [Good, Bad]),
        ("Conf", &["100", "0"], [Good, Bad]),
        ("Quality;QualityDetail;OPCQuality", &["0;192;192", "1;24;24"], [Good, Bad]),
    ] {
        assert_eq!(first(&long(header, cells)), expected, "{header}: {cells:?}");
    }
}

#[test]
fn an_unknown_quality_is_accused_in_its_row_and_the_remedy_works() {
    let text = long("Quality", &["192", "192", "777"]);
    let message = refused(&text);
    assert!(message.contains("row 7, column \"Quality\": 777"), "{message}");
    assert!(message.contains("quality 777=good or bad"), "{message}");
    let options = ReadOptions {
        qualities: vec![quality::of_option("777=good").unwrap()],
        ..ReadOptions::default()
    };
    assert_eq!(parsed(&text, &options).unwrap().recordings[0].op.quality[2], Quality::Good);
    assert!(refused(&long("Quality", &["0"])).contains("quality 0=good or bad"));
    // Wonderware, by whose codes OPC DA would make every sample bad.
    let text = long("Quality", &["0", "0", "133"]);
    let message = refused(&text);
    assert!(message.contains("0 is an ambiguous quality code, like 133"), "{message}");
    let given = ["0=good", "133=bad"].map(|text| quality::of_option(text).unwrap()).to_vec();
    let read = parsed(&text, &ReadOptions { qualities: given, ..ReadOptions::default() }).unwrap();
    assert_eq!(read.recordings[0].op.quality[1..3], [Quality::Good, Quality::Bad]);
}

#[test]
fn a_status_of_modes_is_offered_as_the_mode() {
    let text = "t,PV,OP,Status\n0,1,50,AUTO\n1,2,51,MAN\n";
    let message = refused(text);
    assert!(
        message.contains("if the column holds modes, give map mode=Status; otherwise"),
        "{message}"
    );
    let options =
        ReadOptions { map: vec!["mode=Status".parse().unwrap()], ..ReadOptions::default() };
    let read = parsed(text, &options).unwrap();
    assert_eq!(read.recordings[0].mode.as_ref().unwrap().modes, [Mode::Automatic, Mode::Manual]);
}

#[test]
fn percent_signs_and_question_marks_behind_numbers() {
    let recording = read("t;PV;OP\n0;1,5;44,97%\n1;2,5;Bad\n2;3,5;45 %\n");
    assert_eq!(recording.op.values[0], 44.97);
    assert_eq!((recording.op.values[2], recording.op.unit.as_deref()), (45.0, Some("%")));
    // Not where some numbers lack it.
    let message = refused("t,PV,OP\n0,1,44.97%\n1,2,0.45\n");
    assert!(message.contains("row 2, column \"OP\": \"44.97%\""), "{message}");
    let recording = read("t,PV,OP\n0,1,44.97\n1,2,45.67?\n");
    assert_eq!(recording.op.values[1], 45.67);
    assert_eq!(recording.op.quality, [Quality::Good, Quality::Uncertain]);
    assert!(refused("t,PV,OP\n0,1,44\n1,2,4x?\n").contains("\"4x?\""));
}

#[test]
fn signs_of_spreadsheets_and_accounts_are_read() {
    let text = table("F.PV;F.OP", &["\u{2212}0.04;'44.97", "(0.04);45", "1;46", "\u{2013}2;47"]);
    let recording = read(&text);
    assert_eq!(pv(&recording), [-0.04, -0.04, 1.0, -2.0]);
    assert_eq!(recording.op.values[0], 44.97);
}

#[test]
fn a_flag_beside_a_number_is_asked_for() {
    for (cell, flag) in
        [("60.08 *", "*"), ("*60.08", "*"), ("60.08 S", "S"), ("60.08 kg/h", "kg/h")]
    {
        let text = format!("t,PV,OP\n0,1,44\n1,{cell},45\n2,1,46\n");
        let message = refused(&text);
        let expected = format!(
            "row 3, column \"PV\": \"{cell}\" is not a finite number, but 60.08 with \"{flag}\""
        );
        assert!(message.contains(&expected) && !message.contains("bad_text"), "{message}");
        assert!(message.ends_with(&format!("quality {flag}=good or bad")), "{message}");
        for (word, expected) in [("uncertain", Quality::Uncertain), ("bad", Quality::Bad)] {
            let qualities = vec![quality::of_option(&format!("{flag}={word}")).unwrap()];
            let given = ReadOptions { qualities, ..ReadOptions::default() };
            let recording = parsed(&text, &given).unwrap().recordings.remove(0);
            let pv = recording.pv.unwrap();
            assert_eq!(pv.quality[1], expected, "{cell}");
            assert!(expected == Quality::Bad || pv.values[1] == 60.08, "{cell}");
        }
    }
    // A quality in words needs no question.
    for (cell, expected) in [
        ("60.08 (Bad)", Quality::Bad),
        ("60.08 (Good)", Quality::Good),
        ("60.08 Questionable", Quality::Uncertain),
        ("? 60.08", Quality::Uncertain),
    ] {
        let recording = read(&format!("t,PV,OP\n0,1,44\n1,{cell},45\n"));
        assert_eq!(recording.pv.unwrap().quality[1], expected, "{cell}");
    }
}

#[test]
fn all_unknown_words_are_in_one_message() {
    let text =
        "t,PV,OP\n0,1,44\n1,Kaputt,45\n2,Bad,Digital State 254\n3,kaputt,60.08 *\n4,Wartung,46\n";
    let message = refused(text);
    let expected = "row 4, column \"OP\": \"Digital State 254\" is neither a number nor a known word for a bad or \
                    missing value, like \"Kaputt\", \"Wartung\" in other rows; if they are such words, give bad_text \
                    Digital State 254 and Kaputt and Wartung";
    assert!(message.ends_with(expected), "{message}");
    let words = ["Kaputt", "Digital State 254", "Wartung"].map(str::to_owned).to_vec();
    let given = ReadOptions { bad_text: words, ..ReadOptions::default() };
    let message = parsed(text, &given).unwrap_err().to_string();
    assert!(message.contains("\"60.08 *\""), "{message}");
    let rows = (0..40).map(|k| format!("{k},word {k}x,50\n")).collect::<String>();
    let message = refused(&format!("t,PV,OP\n99,1,44\n{rows}"));
    assert!(
        message.contains("bad_text word 0x and") && message.ends_with("and word 9x"),
        "{message}"
    );
}

#[test]
fn an_sp_in_percent_beside_a_pv_in_units_is_noted() {
    let note = |header: &str, sp: f64, pv: f64| {
        let rows = (0..20).map(|k| format!("{k},{},{sp},45.5\n", pv + f64::from(k % 3)));
        let reading = read(&format!("t,{header}\n{}", rows.collect::<String>()));
        reading
            .notes
            .iter()
            .any(|note| note.contains("in percent") && note.contains("map ignore=F.SP"))
    };
    assert!(note("F.PV,F.SP,F.OP", 60.0, 117.0));
    assert!(note("F.PV (m3/h),F.SP (%),F.OP", 60.0, 45.0));
    for (header, sp, pv) in [
        ("F.PV,F.SP,F.OP", 118.0, 117.0),
        ("F.PV,F.SP,F.OP", 60.0, 40.0),
        ("F.PV,F.SP,F.OP", 98.0, 102.0),
        ("F.PV (m3/h),F.SP (m3/h),F.OP", 60.0, 117.0),
        ("F.PV (%),F.SP (%),F.OP", 60.0, 45.0),
    ] {
        assert!(!note(header, sp, pv), "{header} {sp} {pv}");
    }
}

#[test]
fn modes_of_delta_v_and_other_languages() {
    let modes = |name: &str, codes: [&str; 2]| {
        let rows: String = (0..10).map(|k| format!("{k},50,45.5,{}\n", codes[k % 2])).collect();
        let text = format!("t,FIC/PID1/PV.CV,FIC/PID1/OUT.CV,{name}\n{rows}");
        parsed(&text, &ReadOptions::default())
            .map(|mut read| read.recordings.remove(0).mode.map(|modes| modes.modes[..2].to_vec()))
    };
    for (codes, expected) in [
        (["8", "16"], [Mode::Manual, Mode::Automatic]),
        (["16", "32"], [Mode::Automatic, Mode::Cascade]),
        (["Hand", "Automatik"], [Mode::Manual, Mode::Automatic]),
        (["Manuel", "Cascade"], [Mode::Manual, Mode::Cascade]),
        (["0", "1"], [Mode::Manual, Mode::Automatic]),
    ] {
        let found = modes("FIC/PID1/MODE.ACTUAL", codes).unwrap();
        assert_eq!(found, Some(expected.to_vec()), "{codes:?}");
    }
    let message = modes("FIC/PID1/MODE", ["8", "16"]).unwrap_err().to_string();
    assert!(message.contains("mode 8=auto or manual"), "{message}");
    let options = ReadOptions {
        modes: ["8=manual", "16=auto"].map(|text| mode::of_option(text).unwrap()).to_vec(),
        ..ReadOptions::default()
    };
    let text = "t,F.PV,F.OP,F.MODE\n0,50,45.5,8\n1,50,46.5,16\n";
    let read = parsed(text, &options).unwrap();
    let found = read.recordings[0].mode.as_ref().unwrap();
    assert_eq!(found.modes, [Mode::Manual, Mode::Automatic]);
}

/// The quality of the PV of the second of three samples, and what is said.
fn quality_of_pv(text: &str) -> (Option<Quality>, String) {
    let reading = parsed(text, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let pv = reading.recordings[0].pv.as_ref();
    (pv.map(|pv| pv.quality[1]), said(&reading))
}

#[test]
fn flags_of_quality_are_known_by_their_names() {
    for (name, marks) in [
        ("FIC1.PV.IsGood", ["True", "False"]),
        ("FIC1.PV.Good", ["1", "0"]),
        ("FIC1.PV_BAD", ["FALSE", "TRUE"]),
        ("FIC1.BADPVFL", ["0", "1"]),
        ("FIC1.PVQ", ["GOOD", "BAD"]),
        ("FIC1.PVSTS", ["NORMAL", "BAD"]),
        ("FIC1.PVQuality", ["192", "0"]),
        ("FIC1.PV.Flags", ["Good", "Bad"]),
        ("PV_Valid", ["1", "0"]),
    ] {
        let [good, bad] = marks;
        let text =
            format!("t,FIC1.PV,FIC1.OP,{name}\n0,1,50,{good}\n1,2,51,{bad}\n2,3,52,{good}\n");
        assert_eq!(quality_of_pv(&text).0, Some(Quality::Bad), "{name}");
    }
    let long = |columns: &str, marks: [&str; 2]| {
        let row = |k: usize, mark: &str| format!("FIC1.OP,{k},50,{mark}\nFIC1.PV,{k},{k},{mark}\n");
        let [good, bad] = marks;
        format!("Name,Timestamp,Value,{columns}\n{}{}{}", row(0, good), row(1, bad), row(2, good))
    };
    for (name, marks) in [
        ("Good", ["True", "False"]),
        ("IsGood", ["Good", "Bad"]),
        ("DataQuality", ["Good", "Bad"]),
        ("Q", ["192", "0"]),
        ("Flags", ["Good", "Bad"]),
        ("Questionable,Good", ["False,True", "False,False"]),
    ] {
        let (quality, said) = quality_of_pv(&long(name, marks));
        assert_eq!(quality, Some(Quality::Bad), "{name}");
        assert!(!said.contains("not used"), "{name}: {said}");
    }
    let (_, note) = quality_of_pv(&long("Good", ["True", "False"]));
    assert!(note.contains("in \"Good\" are interpreted as 1 or true for good"), "{note}");
    // In a table with a column per signal, Q may be a flow.
    let (quality, note) = quality_of_pv("t,Q,FIC1.PV,FIC1.OP\n0,7,1,50\n1,8,2,51\n2,9,3,52\n");
    assert_eq!(quality, Some(Quality::Good));
    assert!(note.contains("\"Q\" holds numbers and is not used"), "{note}");
}

#[test]
fn unused_words_of_quality_are_named() {
    let wide = |name: &str, marks: [&str; 2]| {
        let [a, b] = marks;
        format!("t,FIC1.PV,FIC1.OP,{name}\n0,1,50,{a}\n1,2,51,{b}\n2,3,52,{a}\n")
    };
    for (name, marks) in [
        ("FIC1.Trust", ["True", "False"]),
        ("FIC1.Trust", ["False", "False"]),
        ("Remark", ["Good", "Bad"]),
    ] {
        let (quality, note) = quality_of_pv(&wide(name, marks));
        assert_eq!(quality, Some(Quality::Good), "{name}");
        let expected =
            format!("\"{name}\" holds words of qualities, or true and false, and is not");
        assert!(note.contains(&expected), "{name}: {note}");
        assert!(note.contains(&format!("map pv_quality={name}")), "{name}: {note}");
    }
    // What is all good changes nothing, and shifts and pumps are no qualities.
    for marks in [["Good", "Good"], ["A", "B"], ["on", "off"], ["", ""]] {
        let (_, note) = quality_of_pv(&wide("Remark", marks));
        assert!(!note.contains("qualities"), "{marks:?}: {note}");
    }
    let long = |mark: &str| {
        format!(
            "Name,Timestamp,Value,Good,Questionable,Annotated\n\
             A.OP,0,50,True,False,False\nA.PV,0,1,True,False,False\n\
             A.OP,1,51,True,{mark},False\nA.PV,1,2,True,{mark},False\n"
        )
    };
    let (_, note) = quality_of_pv(&long("True"));
    assert!(note.contains("\"Questionable\" holds") && note.contains("map quality=Q"), "{note}");
    let (_, note) = quality_of_pv(&long("False"));
    assert!(!note.contains("not used"), "{note}");
    let tagged = "tag,time,value\nA.OP,0,50\nA.PV,0,1\nA.PV.Status,0,192\n\
                  A.OP,1,51\nA.PV,1,2\nA.PV.Status,1,0\n";
    let (quality, note) = quality_of_pv(tagged);
    assert_eq!(quality, Some(Quality::Good));
    assert!(note.contains("\"A.PV.Status\" is not used, because a table with one row"), "{note}");
}
