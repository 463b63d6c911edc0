//! Recordings: what must hold for every file.

use proptest::prelude::*;
use stiction_io::number::DecimalMark;
use stiction_io::reading::{self, Format, Reading};
use stiction_io::{ReadOptions, table};
use stiction_recording::recording::{Channel, Quality, Recording};

fn parse(text: &str) -> Reading {
    reading::parse(text.as_bytes(), "file.csv", &ReadOptions::default()).expect("a readable file")
}

/// The recordings by name: their order is that of the columns.
fn sorted(reading: Reading) -> Vec<Recording> {
    let mut recordings = reading.recordings;
    recordings.sort_by(|a, b| a.name.cmp(&b.name));
    recordings
}

/// Columns of a wide file: a name and cells.
fn columns() -> impl Strategy<Value = Vec<(String, Vec<String>)>> {
    let number = prop_oneof![
        8 => (-50.0..150.0f64).prop_map(|v| v.to_string()),
        1 => Just("Bad".to_owned()),
        1 => Just(String::new()),
    ];
    let mode = prop_oneof![Just("AUTO".to_owned()), Just("MAN".to_owned()), Just("CAS".to_owned())];
    let quality = prop_oneof![Just("Good".to_owned()), Just("Bad".to_owned())];
    (1usize..20, 1usize..4).prop_flat_map(move |(rows, loops)| {
        let cells = |cell: BoxedStrategy<String>| proptest::collection::vec(cell, rows);
        let mut columns: Vec<BoxedStrategy<(String, Vec<String>)>> =
            vec![Just(("time".to_owned(), (0..rows).map(|k| k.to_string()).collect())).boxed()];
        for each in 0..loops {
            for signal in ["PV", "SP", "OP", "VP", "MODE", "PV.Quality"] {
                let cell = match signal {
                    "MODE" => mode.clone().boxed(),
                    "PV.Quality" => quality.clone().boxed(),
                    _ => number.clone().boxed(),
                };
                let name = format!("FIC{each}.{signal}");
                columns.push(cells(cell).prop_map(move |cells| (name.clone(), cells)).boxed());
            }
        }
        columns
    })
}

fn text(columns: &[(String, Vec<String>)]) -> String {
    let rows = columns[0].1.len();
    let names = columns.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>().join(",");
    let row = |k: usize| columns.iter().map(|(_, cells)| &*cells[k]).collect::<Vec<_>>().join(",");
    std::iter::once(names).chain((0..rows).map(row)).collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn recordings_can_be_visited_one_after_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.csv");
    std::fs::write(&path, "t,A.OP,A.PV,B.OP\n0,50,1,60\n1,51,2,61\n2,52,3,60\n").unwrap();
    let options = ReadOptions::default();
    let whole = reading::read(&path, &options).unwrap();
    let mut recordings = vec![];
    let visited = reading::visit(&path, &options, &mut |recording, clock| {
        assert_eq!(*clock, whole.time.clock);
        recordings.push(recording);
    });
    assert_eq!(recordings.len(), 2);
    assert_eq!(Reading { recordings, ..visited.unwrap() }, whole);
}

proptest! {
    #[test]
    fn the_order_of_columns_does_not_matter(
        (before, after) in columns().prop_flat_map(|c| (Just(c.clone()), Just(c).prop_shuffle()))
    ) {
        let (before, after) = (sorted(parse(&text(&before))), sorted(parse(&text(&after))));
        prop_assert_eq!(before.len(), after.len());
        for (a, b) in before.iter().zip(&after) {
            // Missing values are NaN, which is not equal to itself.
            prop_assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
    }

    #[test]
    fn what_is_written_reads_back_the_same(
        // Values far outside the others are no measurements.
        samples in proptest::collection::vec((0.0f64..100.0, -1e6f64..1e6), 1..50),
        separator in prop_oneof![Just(","), Just(";"), Just("\t"), Just("|")],
        end in prop_oneof![Just("\n"), Just("\r\n"), Just("\r")],
        comma in any::<bool>(),
    ) {
        let (op, pv): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
        let time: Vec<f64> = (0..op.len()).map(|k| k as f64 * 0.5).collect();
        let columns = [("t", Some(&time[..])), ("op", Some(&op[..])), ("pv", Some(&pv[..]))];
        let mut written = table::write(&columns).replace(',', separator).replace('\n', end);
        let comma = comma && separator != ",";
        if comma {
            written = written.replace('.', ",");
        }
        let reading = parse(&written);
        let Format::Csv(dialect) = reading.format else { panic!("CSV") };
        prop_assert_eq!(dialect.delimiter.to_string(), separator);
        if written.contains(",5") && comma {
            prop_assert_eq!(dialect.decimal_mark, DecimalMark::Comma);
        }
        let recording = &reading.recordings[0];
        let same = |channel: &Channel, values: &[f64]| {
            channel.time == time
                && channel.values == values
                && channel.quality.iter().all(|quality| *quality == Quality::Good)
        };
        prop_assert!(same(&recording.op, &op));
        prop_assert!(recording.pv.as_ref().is_some_and(|channel| same(channel, &pv)));
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = reading::parse(&bytes, "file.csv", &ReadOptions::default());
    }

    #[test]
    fn any_text_of_a_table_is_read_or_refused(text in "(t|time|op|pv|tag|value|[0-9,;./: +-]|Bad|\n){0,60}") {
        let _ = reading::parse(text.as_bytes(), "file.csv", &ReadOptions::default());
        let _ = ReadOptions::parse(&text, "map.toml");
    }
}

#[test]
fn the_hash_is_that_of_the_bytes() {
    // As another implementation tells it.
    let hash = parse("t,op\n0,50\n1,51\n").sha256;
    assert_eq!(hash, "0ddb0708ea050d22d1ff14cd5db039ea0c723f800b7e8c7d61b8efa398b4c700");
}
