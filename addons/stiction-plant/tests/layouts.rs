//! The same values give the same rows, however they lie in files.

use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction_plant::plant_file::Plant;
use stiction_plant::{ScanOptions, Store, WindowRow, scan};
use stiction_population::LoopKind;

const STEP: i64 = 60;
const DAYS: i64 = 3;
/// Monday, 2026-03-02, ms since 1970.
const BEGIN: i64 = 20_514 * 86_400_000;

type Sample = (i64, String, f64);

/// Samples of eight loops, in order of tags.
fn samples() -> Vec<Sample> {
    let kinds = [LoopKind::Sticky, LoopKind::Normal, LoopKind::Sine, LoopKind::SetPoint];
    let mut samples = vec![];
    for k in 0..8 {
        let recording = kinds[k % 4].simulate(40 + k as u64).unwrap().recording;
        let (op, pv) = (recording.op.values, recording.pv.unwrap().values);
        for (signal, values) in [("OP", op), ("PV", pv)] {
            for i in 0..DAYS * 86_400 / STEP {
                let value = values[i as usize % values.len()];
                samples.push((BEGIN + 1000 * STEP * i, format!("FIC{k}.{signal}"), value));
            }
        }
    }
    samples
}

/// A column: times, ms since 1970-01-01 and whether UTC, words or numbers.
enum Column {
    Times(Vec<i64>, bool),
    Words(Vec<ByteArray>),
    Numbers(Vec<f64>),
}

type Table = Vec<(String, Column)>;

fn long(samples: &[Sample], utc: bool) -> Table {
    vec![
        ("time".to_owned(), Column::Times(samples.iter().map(|s| s.0).collect(), utc)),
        ("tag".to_owned(), Column::Words(samples.iter().map(|s| (&*s.1).into()).collect())),
        ("value".to_owned(), Column::Numbers(samples.iter().map(|s| s.2).collect())),
    ]
}

/// A column a tag; all tags have the same times.
fn wide(samples: &[Sample]) -> Table {
    let mut tags: Vec<&str> = samples.iter().map(|s| &*s.1).collect();
    tags.dedup();
    let of = |tag: &str| samples.iter().filter(|s| s.1 == tag).cloned().collect::<Vec<_>>();
    let times = of(tags[0]).iter().map(|s| s.0).collect();
    let mut columns = vec![("time".to_owned(), Column::Times(times, true))];
    for tag in tags {
        let values = of(tag).iter().map(|s| s.2).collect();
        columns.push((tag.to_owned(), Column::Numbers(values)));
    }
    columns
}

fn write(path: &Path, table: &Table, group: usize, statistics: EnabledStatistics) {
    let field = |(name, column): &(String, Column)| {
        let (physical, logical) = match column {
            Column::Times(_, utc) => {
                (Physical::INT64, Some(LogicalType::timestamp(*utc, TimeUnit::MILLIS)))
            }
            Column::Words(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Column::Numbers(_) => (Physical::DOUBLE, None),
        };
        let field = Type::primitive_type_builder(name, physical).with_logical_type(logical);
        Arc::new(field.with_repetition(Repetition::REQUIRED).build().unwrap())
    };
    let fields = table.iter().map(field).collect();
    let schema = Type::group_type_builder("schema").with_fields(fields).build().unwrap();
    let properties = WriterProperties::builder().set_statistics_enabled(statistics).build();
    let file = fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema.into(), properties.into()).unwrap();
    let Column::Times(times, _) = &table[0].1 else { panic!("times come first") };
    for begin in (0..times.len()).step_by(group) {
        let rows = begin..times.len().min(begin + group);
        let mut group = writer.next_row_group().unwrap();
        for (_, column) in table {
            let mut out = group.next_column().unwrap().unwrap();
            match column {
                Column::Times(all, _) => {
                    out.typed::<Int64Type>().write_batch(&all[rows.clone()], None, None)
                }
                Column::Words(all) => {
                    out.typed::<ByteArrayType>().write_batch(&all[rows.clone()], None, None)
                }
                Column::Numbers(all) => {
                    out.typed::<DoubleType>().write_batch(&all[rows.clone()], None, None)
                }
            }
            .unwrap();
            out.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
}

fn plant(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("layouts-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let text = "name = \"N\"\nzone = \"UTC\"\ndata = [\"*.parquet\", \"*.csv\"]\n";
    fs::write(folder.join("plant.toml"), text).unwrap();
    folder
}

fn rows(folder: &Path, options: &ScanOptions) -> Vec<WindowRow> {
    let plant = Plant::read(folder).unwrap();
    let done = scan(folder, &plant, options, |_| ControlFlow::Continue(())).unwrap();
    assert!(done.problems.is_empty() && !folder.join(".stiction/sorted").exists(), "{done:?}");
    let rows = Store::of(folder).rows().unwrap().into_iter();
    let rows = rows.map(|row| WindowRow { input_fingerprint: String::new(), ..row }).collect();
    fs::remove_dir_all(folder).unwrap();
    rows
}

#[test]
fn layouts_order_cuts_threads_and_memory_change_no_row() {
    let samples = samples();
    let per_tag = (DAYS * 86_400 / STEP) as usize;
    let all = EnabledStatistics::Chunk;
    let usual = ScanOptions::default();

    // A row group a tag.
    let folder = plant("tags");
    write(&folder.join("a.parquet"), &long(&samples, true), per_tag, all);
    let expected = rows(&folder, &usual);
    assert!(expected.len() > 20, "all but those of slow loops are of a day: {}", expected.len());
    assert!(expected.iter().all(|row| row.error.is_none() && row.samples > Some(1000)));

    // Row groups that end anywhere, without statistics, read in one thread and tiny batches.
    let folder = plant("anywhere");
    write(&folder.join("a.parquet"), &long(&samples, true), 1000, EnabledStatistics::None);
    let small = ScanOptions { threads: Some(1), memory: Some(1), ..ScanOptions::default() };
    assert_eq!(rows(&folder, &small), expected);

    // In order of time, a file a day; local times in the plant's zone.
    let mut ordered = samples.clone();
    ordered.sort_by(|a, b| (a.0, &b.1).cmp(&(b.0, &a.1)));
    for (name, utc) in [("utc", true), ("local", false)] {
        let folder = plant(name);
        for day in 0..DAYS {
            let of = BEGIN + day * 86_400_000..BEGIN + (day + 1) * 86_400_000;
            let own: Vec<Sample> = ordered.iter().filter(|s| of.contains(&s.0)).cloned().collect();
            write(&folder.join(format!("{day}.parquet")), &long(&own, utc), 4000, all);
        }
        // Memory for a loop or two: rows are sorted on disk.
        let small = ScanOptions { memory: Some(4_000_000), ..ScanOptions::default() };
        assert_eq!(rows(&folder, &small), expected, "{name}");
    }

    let folder = plant("wide");
    write(&folder.join("a.parquet"), &wide(&samples), 1500, all);
    assert_eq!(rows(&folder, &usual), expected);

    // Numbers are written so that they read back the same.
    let folder = plant("csv");
    let mut text = "time,tag,value\n".to_owned();
    for (time, tag, value) in &ordered {
        text += &format!("{},{tag},{value}\n", time / 1000);
    }
    fs::write(folder.join("a.csv"), text).unwrap();
    assert_eq!(rows(&folder, &usual), expected);
}

#[test]
fn what_is_corrected_of_one_loop_is_judged_again_and_no_other() {
    let folder = plant("corrected");
    let mut samples = samples();
    let per_tag = (DAYS * 86_400 / STEP) as usize;
    let path = folder.join("a.parquet");
    write(&path, &long(&samples, true), per_tag, EnabledStatistics::Chunk);
    let plant = Plant::read(&folder).unwrap();
    let go = || {
        scan(&folder, &plant, &ScanOptions::default(), |_| ControlFlow::Continue(()))
            .unwrap()
            .windows
    };
    let all_of_them = go();
    assert!(all_of_them > 20);
    assert_eq!(go(), 0);
    samples[10].2 += 0.25;
    write(&path, &long(&samples, true), per_tag, EnabledStatistics::Chunk);
    assert_eq!(go(), DAYS as usize, "all windows of the loop whose row groups have changed");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_bad_tag_or_a_damaged_part_is_rows_with_an_error_and_stops_no_other() {
    let samples = samples();
    let per_tag = (DAYS * 86_400 / STEP) as usize;
    let all = EnabledStatistics::Chunk;
    // A mode that nobody knows, of one loop; in order of tags, and in order of time, sorted on disk.
    let mut bad = samples.clone();
    bad.extend((0..60).map(|i| (BEGIN + 60_000 * i, "FIC3.MODE".to_owned(), 77.0)));
    let mut ordered = bad.clone();
    ordered.sort_by(|a, b| (a.0, &b.1).cmp(&(b.0, &a.1)));
    let small = ScanOptions { memory: Some(4_000_000), ..ScanOptions::default() };
    for (name, table, options) in
        [("bad-tag", &bad, ScanOptions::default()), ("bad-tag-sorted", &ordered, small)]
    {
        let folder = plant(name);
        write(&folder.join("a.parquet"), &long(table, true), per_tag, all);
        let rows = rows(&folder, &options);
        let wrong = |row: &&WindowRow| row.error.is_some();
        assert_eq!(rows.iter().filter(wrong).count(), DAYS as usize);
        assert!(rows.iter().all(|row| row.error.is_some() == (row.name == "FIC3")), "{name}");
        let why = rows.iter().find_map(|row| row.error.clone()).unwrap();
        assert!(why.contains("77"), "{why}");
        assert!(rows.iter().filter(|row| row.error.is_none()).count() > 17);
    }
    // Of one of three files the pages of one tag are damaged: one day of one loop is lost.
    let folder = plant("damaged");
    for day in 0..DAYS {
        let of = BEGIN + day * 86_400_000..BEGIN + (day + 1) * 86_400_000;
        let own: Vec<Sample> = samples.iter().filter(|s| of.contains(&s.0)).cloned().collect();
        let path = folder.join(format!("{day}.parquet"));
        write(&path, &long(&own, true), per_tag / DAYS as usize, all);
        if day == 1 {
            let file = SerializedFileReader::new(fs::File::open(&path).unwrap()).unwrap();
            let values = file.metadata().row_group(4).column(2).byte_range().0 as usize;
            let mut bytes = fs::read(&path).unwrap();
            bytes[values..values + 16].fill(0xff);
            fs::write(&path, bytes).unwrap();
        }
    }
    let rows = rows(&folder, &ScanOptions::default());
    let wrong: Vec<&WindowRow> = rows.iter().filter(|row| row.error.is_some()).collect();
    assert_eq!(wrong.len(), 1, "{:?}", wrong.iter().map(|row| &row.error).collect::<Vec<_>>());
    assert!(rows.iter().filter(|row| row.name == wrong[0].name).count() > 1);
}
