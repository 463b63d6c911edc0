//! Times: clocks that begin again, the choice of the column, times of day, and advice that works.

use proptest::prelude::*;
use stiction_io::reading::{self, Reading};
use stiction_io::{ReadOptions, timestamp::Zone};
use stiction_recording::recording::{Channel, Recording};

fn parse(text: &str, options: &ReadOptions) -> Result<Reading, String> {
    reading::parse(text.as_bytes(), "f.csv", options).map_err(|error| error.to_string())
}

fn read(text: &str) -> Reading {
    parse(text, &ReadOptions::default()).expect("a readable file")
}

/// A table of these columns.
fn table(names: &str, rows: impl IntoIterator<Item = String>) -> String {
    std::iter::once(names.to_owned()).chain(rows).collect::<Vec<_>>().join("\n") + "\n"
}

/// A slow wave, different in each run.
fn wave(run: usize, k: usize) -> f64 {
    let level = 50.0 + 9.0 * (run % 2) as f64;
    level
        + 7.0 * (k as f64 * 0.07 + run as f64 * 1.9).sin()
        + ((k * k + 31 * run) % 17) as f64 * 0.01
}

/// The rows of runs that begin at `starts`, with the time of each cell from `at`.
fn runs(starts: &[f64], rows: usize, step: f64) -> Vec<(f64, f64)> {
    let run = |(run, start): (usize, &f64)| {
        (0..rows).map(|k| (start + k as f64 * step, wave(run, k))).collect::<Vec<_>>()
    };
    starts.iter().enumerate().flat_map(run).collect()
}

fn text(rows: &[(f64, f64)]) -> String {
    table("t,pv,op", rows.iter().map(|(t, v)| format!("{t},{v},{}", 100.0 - v)))
}

/// All samples ascend in time, in the order of `values`.
fn in_order(channel: &Channel, values: &[f64]) -> bool {
    channel.values == values && channel.time.is_sorted_by(|a, b| a < b)
}

fn said<'r>(reading: &'r Reading, words: &str) -> Option<&'r String> {
    reading.recordings[0].notes.iter().chain(&reading.notes).find(|note| note.contains(words))
}

#[test]
fn runs_below_each_other_stay_in_order_and_the_note_names_each() {
    for (starts, step) in [
        (&[0.0, 0.0, 0.0][..], 1.0),
        (&[0.0, 0.4, 0.8], 1.0),
        (&[0.0, 0.5], 1.0),
        (&[100.0, 0.0, 100.0], 2.0),
        (&[0.0; 12], 0.5),
        (&[0.0, 0.1, 0.2, 0.3, 0.7, 0.6, 0.5, 0.4, 0.9, 0.8, 0.05, 0.15, 0.25], 1.0),
    ] {
        let rows = runs(starts, 200, step);
        let reading = read(&text(&rows));
        let pv = reading.recordings[0].pv.as_ref().unwrap();
        let values: Vec<f64> = rows.iter().map(|(_, v)| *v).collect();
        assert!(in_order(pv, &values), "{starts:?}");
        assert_eq!(reading.recordings[0].op.time, pv.time, "{starts:?}");
        let note = said(&reading, "the clock jumps back in row 202 (")
            .unwrap_or_else(|| panic!("{starts:?}"));
        assert!(starts.len() < 3 || note.contains("row 402 ("), "{note}");
        assert!(note.contains("do not continue there"), "{note}");
        // Longer than any bridge.
        assert!(pv.time[200] - pv.time[199] > 4.5 * step, "{starts:?}");
    }
}

#[test]
fn a_counter_that_overflows_continues() {
    for (samples, step, bits) in [(300u64, 1000u64, 16), (700, 250, 16), (400, 50_000_000, 32)] {
        let turn = 1u64 << bits;
        let row = |k: u64| {
            let v = wave(0, k as usize);
            format!("{},{v},{}", (k * step + 5_000) % turn, 100.0 - v)
        };
        let reading = read(&table("time_ms,pv,op", (0..samples).map(row)));
        let time = &reading.recordings[0].op.time;
        let step = step as f64 * 1e-3;
        assert!(
            time.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() < 1e-6 * step),
            "{step}"
        );
        assert!(
            said(&reading, "The signals continue or").is_some(),
            "{:?}",
            reading.recordings[0].notes
        );
    }
}

#[test]
fn a_local_clock_falls_back_once() {
    let row = |k: usize| {
        let minutes = if k < 90 { 90 + k } else { 30 + k };
        format!(
            "2024-10-27 {:02}:{:02}:00,{},{}",
            minutes / 60,
            minutes % 60,
            wave(0, k),
            100.0 - wave(0, k)
        )
    };
    // From 1:30 to 2:59, and again from 2:00 on.
    let reading = read(&table("Zeitpunkt,pv,op", (0..240).map(row)));
    let time = &reading.recordings[0].op.time;
    assert!(time.windows(2).all(|pair| pair[1] - pair[0] == 60.0), "{time:?}");
    assert!(said(&reading, "row 92 (2024-10-27T02:00:00 after 2024-10-27T02:59:00)").is_some());
    assert!(said(&reading, "looks like daylight saving").is_some());
}

#[test]
fn the_repeated_hour_sorted_by_its_local_time_is_explained() {
    let row = |(minute, k): (usize, usize)| {
        format!("2024-10-27 {:02}:{:02}:00,{},{}", minute / 60, minute % 60, wave(0, k), wave(1, k))
    };
    // From 1:00 to 4:59, with two rows for each minute from 2:00 to 2:59.
    let minutes = (60..300).flat_map(|m| if m / 60 == 2 { vec![m; 2] } else { vec![m] });
    let text = table("Time,pv,op", minutes.enumerate().map(|(k, minute)| row((minute, k))));
    let refused = |text: &str| parse(text, &ReadOptions::default()).unwrap_err().to_string();
    let message = refused(&text);
    assert!(message.contains("all in one hour, as at the end of summer time"), "{message}");
    // All the time it is a lack of digits.
    let text =
        table("Time,pv,op", (60..300).flat_map(|m| [m; 2]).enumerate().map(|(k, m)| row((m, k))));
    assert!(refused(&text).contains("too few digits"));
}

#[test]
fn hours_without_am_and_pm_are_noted() {
    let of = |hours: &dyn Fn(usize) -> usize| {
        let row = |k: usize| {
            format!("2025-01-20 {:02}:{:02}:00,{},50.5", hours(k / 60), k % 60, wave(0, k))
        };
        read(&table("Time,pv,op", (0..1200).map(row)))
    };
    let half = of(&|hour| (hour + 5) % 12 + 1);
    assert!(said(&half, "the times probably lack AM and PM").is_some());
    let again = of(&|hour| if hour < 10 { hour + 6 } else { hour - 4 });
    assert!(said(&again, "the times probably lack AM and PM").is_none());
}

#[test]
fn disorder_is_no_restart() {
    let rows = runs(&[0.0], 400, 1.0);
    let swapped: Vec<_> = rows[200..].iter().chain(&rows[..200]).copied().collect();
    let reversed: Vec<_> = rows.iter().rev().copied().collect();
    let twice: Vec<_> = rows.iter().chain(&rows[100..300]).copied().collect();
    let mut late = rows.clone();
    let moved = late.remove(100);
    late.insert(110, moved);
    let strided: Vec<_> = (0..400).map(|k| rows[k * 7 % 400]).collect();
    let shuffled: Vec<_> = (0..400).map(|k| rows[k * 171 % 400]).collect();
    for (name, rows) in [
        ("swapped", swapped),
        ("reversed", reversed),
        ("twice", twice),
        ("late", late),
        ("strided", strided),
        ("shuffled", shuffled),
    ] {
        let reading = read(&text(&rows));
        let time: Vec<f64> = rows.iter().map(|(t, _)| *t).collect();
        assert_eq!(reading.recordings[0].op.time, time, "{name}");
        assert!(said(&reading, "jumps back in").is_none(), "{name}");
    }
}

#[test]
fn tags_of_a_long_table_follow_together() {
    let tags = |run: usize, k: usize| {
        let v = wave(run, k);
        let mut rows = vec![format!("A.PV,{k},{v}"), format!("A.OP,{k},{}", 100.0 - v)];
        if k == 0 {
            rows.insert(run, format!("A.SP,{k},{}", 50 + run));
            rows.insert(run, format!("A.MODE,{k},{}", 1 + run));
        }
        rows
    };
    let by_run = (0..2).flat_map(|run| (0..100).flat_map(move |k| tags(run, k)));
    let mut by_tag: Vec<String> = by_run.clone().collect();
    by_tag.sort_by_key(|row| row.split(',').next().map(str::to_owned));
    for rows in [by_run.collect(), by_tag] {
        let recording = read(&table("tag,time,value", rows)).recordings.remove(0);
        let Recording { op, pv: Some(pv), sp: Some(sp), mode: Some(mode), .. } = recording else {
            panic!()
        };
        let values: Vec<f64> = (0..2).flat_map(|run| (0..100).map(move |k| wave(run, k))).collect();
        assert!(in_order(&pv, &values));
        assert_eq!(op.time, pv.time);
        assert_eq!((sp.time[0], sp.time[1]), (0.0, pv.time[100]));
        assert_eq!(mode.time, sp.time);
    }
}

#[test]
fn times_that_repeat_in_disorder_are_refused() {
    // 40 runs of three rows: too short to know that the clock begins again.
    let rows: Vec<(f64, f64)> = (0..120).map(|k| (f64::from(k % 3), wave(0, k as usize))).collect();
    let message = parse(&text(&rows), &ReadOptions::default()).unwrap_err();
    assert!(message.contains("has the time of another row but other values"), "{message}");
    let options = ReadOptions { sample_time: Some(1.0), ..ReadOptions::default() };
    assert_eq!(parse(&text(&rows), &options).unwrap().recordings[0].op.time.len(), 120);
}

proptest! {
    #[test]
    fn no_row_of_any_run_is_lost(
        runs in proptest::collection::vec((20usize..60, 0.0f64..8.0), 1..30),
        step in prop_oneof![Just(0.5), Just(1.0), Just(60.0)],
        wide in any::<bool>(),
    ) {
        let (mut rows, mut last) = (vec![], f64::INFINITY);
        for (run, (count, start)) in runs.iter().enumerate() {
            // Each begins before the end of the one before, as a clock that begins again does.
            let start = (start * step).min(last - 10.0 * step);
            let start = (start / step * 10.0).round() / 10.0 * step;
            rows.extend((0..*count).map(|k| (start + k as f64 * step, wave(run, k))));
            last = start + *count as f64 * step;
        }
        let text = match wide {
            true => text(&rows),
            false => {
                let long = rows.iter().flat_map(|(t, v)| [format!("A.PV,{t},{v}"), format!("A.OP,{t},{}", 100.0 - v)]);
                table("tag,time,value", long)
            }
        };
        let reading = read(&text);
        let values: Vec<f64> = rows.iter().map(|(_, v)| *v).collect();
        let recording = &reading.recordings[0];
        prop_assert!(in_order(recording.pv.as_ref().unwrap(), &values), "{:?}", recording.notes);
        prop_assert_eq!(&recording.op.time, &recording.pv.as_ref().unwrap().time);
    }
}

/// The column of times, and what the notes say.
fn chosen(text: &str) -> (String, Vec<String>) {
    let reading = read(text);
    let notes = reading.notes.iter().chain(&reading.recordings[0].notes).cloned().collect();
    (reading.time.column.unwrap_or_default(), notes)
}

#[test]
fn the_time_is_chosen_by_what_it_does_to_the_rows() {
    let date = |k: usize| format!("2025-03-14 06:{:02}:{:02}", k / 60, k % 60);
    let build = |names: &str, cells: &dyn Fn(usize) -> String| {
        table(&format!("{names},pv,op"), (0..200).map(|k| format!("{},{},50", cells(k), k % 7)))
    };
    type Case<'a> = (&'a str, &'a dyn Fn(usize) -> String, &'a str, &'a str);
    let cases: [Case<'_>; 10] = [
        // A constant, or one that repeats, loses against one that ascends.
        (
            "time,Stamp",
            &|k| format!("0,{}", date(k)),
            "Stamp",
            "\"Stamp\" is interpreted as the time",
        ),
        (
            "Timestamp,t",
            &|k| format!("2025-03-14 06:{:02}:00,{k}", k / 60),
            "t",
            "because \"Timestamp\" cannot be",
        ),
        // T is a temperature.
        (
            "T,Abtastung",
            &|k| format!("{},{}", 60.0 + wave(0, k * 13), date(k)),
            "Abtastung",
            "cannot be the time",
        ),
        // Several good ones.
        (
            "ServerTimestamp,SourceTimestamp",
            &|k| format!("{},{}", date(k + 1), date(k)),
            "SourceTimestamp",
            "; to use another column, give",
        ),
        ("LocalTime,UTC", &|k| format!("{},{}", date(k + 1), date(k)), "UTC", "map time=LocalTime"),
        ("t,timestamp", &|k| format!("{k},{}", date(k)), "timestamp", "map time=t"),
        // Unknown names.
        ("Wann", &|k| date(k), "Wann", "no column has a known name for times"),
        (
            "Sensor read",
            &|k| format!("{}", 1_741_932_000_000u64 + 1000 * k as u64),
            "Sensor read",
            "",
        ),
        ("Unnamed: 0", &|k| date(k), "Unnamed: 0", ""),
        ("level_0", &|k| format!("{}", k as f64 * 0.5), "level_0", ""),
    ];
    for (names, cells, expected, note) in cases {
        let (column, notes) = chosen(&build(names, cells));
        assert_eq!(column, expected, "{names}: {notes:?}");
        assert!(
            note.is_empty() || notes.iter().any(|each| each.contains(note)),
            "{names}: {notes:?}"
        );
    }
    // A count of rows is no time.
    let message =
        parse(&build("Unnamed: 0", &|k| k.to_string()), &ReadOptions::default()).unwrap_err();
    assert!(message.contains("has no column of times"), "{message}");
}

#[test]
fn names_of_times() {
    for name in [
        "Zeitpunkt",
        "Datum/Uhrzeit",
        "Horodatage",
        "Date/Heure",
        "Fecha/Hora",
        "Data/Ora",
        "Data e hora",
        "t_stamp",
        "SourceTimestamp",
        "Server Timestamp",
        "_time",
        "IP_TREND_TIME",
        "TimeString",
        "DateTime",
        "Date-Time",
        "Date Time",
        "EventTime",
        "LogTime",
        "TS",
        "Date & Time",
        "Timestamp (UTC)",
        "Record Time",
        "created_at",
    ] {
        let rows = (0..4).map(|k| format!("2025-03-14 06:00:0{k};5{k}"));
        assert_eq!(chosen(&table(&format!("{name};OP"), rows)).0, name);
    }
    for name in ["time_sec", "simTime", "tout", "Sim_Time", "SimulationTime", "Time_ms", "t [s]"] {
        let rows = (0..4).map(|k| format!("{};5{k}", 500 * k));
        let reading = read(&table(&format!("{name};OP"), rows));
        assert_eq!(reading.time.column.as_deref(), Some(name));
    }
}

#[test]
fn a_day_and_a_time_of_day_in_two_columns() {
    for (names, first, second, third) in [
        ("Date,Time", "3/14/2025,6:00:00 AM", "3/14/2025,6:00:01 AM", "3/14/2025,6:00:02 AM"),
        (
            "Datum,Uhrzeit",
            "14.03.2025,06:00:00.000",
            "14.03.2025,06:00:01.000",
            "14.03.2025,06:00:02.000",
        ),
        ("Date,Time", "2025-03-14,0.25", "2025-03-14,0.250011574", "2025-03-14,0.250023148"),
        (
            "Date,Time",
            "14/03/2025 00:00:00,06:00:00",
            "14/03/2025 00:00:00,06:00:01",
            "14/03/2025 00:00:00,06:00:02",
        ),
        (
            "Date,Time",
            "3/14/2025 12:00:00 AM,6:00:00 AM",
            "3/14/2025 12:00:00 AM,6:00:01 AM",
            "3/14/2025 12:00:00 AM,6:00:02 AM",
        ),
        ("Fecha,Hora", "20250314,060000", "20250314,060001", "20250314,060002"),
        ("Date,Time", "45730,0.25", "45730,0.250011574", "45730,0.250023148"),
        (
            "Date,Time",
            "2025-03-14,1899-12-30 06:00:00",
            "2025-03-14,1899-12-30 06:00:01",
            "2025-03-14,1899-12-30 06:00:02",
        ),
        ("Tagesdatum,Time", "2025-03-14,06:00:00", "2025-03-14,06:00:01", "2025-03-14,06:00:02"),
    ] {
        let rows = [first, second, third].map(|row| format!("{row},50"));
        let text = table(&format!("{names},op"), rows);
        let reading =
            parse(&text, &ReadOptions::default()).unwrap_or_else(|e| panic!("{first}: {e}"));
        let recording = &reading.recordings[0];
        assert_eq!(recording.start, Some(1_741_932_000.0), "{first}");
        let seconds: Vec<f64> = recording.op.time.iter().map(|t| (t * 1e3).round() / 1e3).collect();
        assert_eq!(seconds, [0.0, 1.0, 2.0], "{first}");
    }
}

#[test]
fn times_of_day_run_on_over_midnight() {
    let clock = |seconds: usize| {
        let s = seconds % 86_400;
        (s / 3600, s / 60 % 60, s % 60)
    };
    let text_of = |write: &dyn Fn(usize) -> String| {
        table("Uhrzeit;pv;op", (0..400).map(|k| format!("{};{};50", write(86_200 + k), k % 7)))
    };
    let written: [&dyn Fn(usize) -> String; 6] = [
        &|s| {
            let (h, m, s) = clock(s);
            format!("{h:02}:{m:02}:{s:02}")
        },
        &|s| {
            let (h, m, s) = clock(s);
            format!("{h}:{m:02}:{s:02}.000")
        },
        &|s| {
            let (h, m, s) = clock(s);
            format!("{}:{m:02}:{s:02} {}", (h + 11) % 12 + 1, if h < 12 { "AM" } else { "PM" })
        },
        &|s| {
            let (h, m, s) = clock(s);
            format!("{h:02}h{m:02}m{s:02}s")
        },
        &|s| {
            let (_, m, s) = clock(s);
            format!("{m:02}:{s:02}.0")
        },
        &|s| {
            let (h, m, s) = clock(s);
            format!("{}:{h:02}:{m:02}:{s:02}", 3 + usize::from(h < 12))
        },
    ];
    for write in written {
        let reading = read(&text_of(write));
        let time = &reading.recordings[0].op.time;
        let first = time[0];
        assert!(time.iter().enumerate().all(|(k, t)| *t - first == k as f64), "{}", write(86_200));
        assert!(said(&reading, "jumps back in").is_none(), "{}", write(86_200));
    }
    let text = text_of(&|s| {
        let (h, m, s) = clock(s);
        format!("{h:02}:{m:02}:{s:02}")
    });
    assert!(
        said(
            &read(&text),
            "no date and count from 23:56:40; they pass midnight once; for dates give date"
        )
        .is_some()
    );
    let day = ReadOptions { date: Some("2025-03-14".parse().unwrap()), ..ReadOptions::default() };
    assert_eq!(parse(&text, &day).unwrap().recordings[0].start, Some(1_741_910_400.0 + 86_200.0));
    // Newest first.
    let mut rows: Vec<&str> = text.lines().collect();
    rows[1..].reverse();
    let reversed = parse(&(rows.join("\n") + "\n"), &day).unwrap();
    assert_eq!(reversed.recordings[0].start, Some(1_741_910_400.0 + 86_200.0));
    assert!(reversed.recordings[0].op.time.windows(2).all(|pair| pair[1] - pair[0] == -1.0));
    // By a pattern.
    let format =
        ReadOptions { time_format: Some("%H:%M:%S".parse().unwrap()), ..ReadOptions::default() };
    assert_eq!(parse(&text, &format).unwrap().recordings[0].op.time[399], 399.0);
    // Hours and minutes, which turn at midnight.
    let minutes = table(
        "Time,op",
        (0..60)
            .map(|k| format!("{:02}:{:02},5{}", (23 + (30 + k) / 60) % 24, (30 + k) % 60, k % 7)),
    );
    assert_eq!(read(&minutes).recordings[0].op.time[59], 59.0 * 60.0);
    // Each tag of a long table on the same days.
    let long = (0..4)
        .flat_map(|k| [format!("A.OP,23:59:5{},5{k}", 6 + k), format!("A.OP,00:00:0{k},5{k}")]);
    let mut rows: Vec<String> = long.collect();
    rows.sort_by_key(|row| row.contains(",00:"));
    rows.push("A.SP,00:00:02,7".to_owned());
    let recording = read(&table("tag,time,value", rows)).recordings.remove(0);
    assert_eq!((recording.op.time[7], recording.sp.unwrap().time[0]), (7.0, 6.0));
}

#[test]
fn whole_columns_of_rare_dates() {
    for (options, cells, start) in [
        ("", ["2025-W11-5T06:00:00", "2025-W11-5T06:00:01"], 1_741_932_000.0),
        ("", ["2025-073T06:00:00", "2025-073T06:00:01"], 1_741_932_000.0),
        ("", ["2025-03-14T23:59:59", "2025-03-14T24:00:00"], 1_741_996_799.0),
        ("", ["2016-12-31T23:59:59Z", "2016-12-31T23:59:60Z"], 1_483_228_799.0),
        ("", ["Fri Mar 14 06:00:00 2025", "Fri Mar 14 06:00:01 2025"], 1_741_932_000.0),
        ("", ["14. März 2025 06:00:00", "14. März 2025 06:00:01"], 1_741_932_000.0),
        ("", ["2025-03-14-06.00.00.000000", "2025-03-14-06.00.01.000000"], 1_741_932_000.0),
        (
            "Europe/Berlin",
            ["14 Mar 2025 06:00:00 CET", "14 Mar 2025 06:00:01 CET"],
            1_741_928_400.0,
        ),
        ("Europe/Berlin", ["2025-03-14 06:00:00", "2025-03-14 05:00:01Z"], 1_741_928_400.0),
        ("", ["1741932000000000000", "1741932001000000000"], 1_741_932_000.0),
    ] {
        let zone = (!options.is_empty()).then(|| options.parse::<Zone>().unwrap());
        let options = ReadOptions { zone, ..ReadOptions::default() };
        let rows = cells.map(|cell| format!("{cell};50"));
        let reading =
            parse(&table("Time;op", rows), &options).unwrap_or_else(|e| panic!("{cells:?}: {e}"));
        let recording = &reading.recordings[0];
        assert_eq!(
            (recording.start, &*recording.op.time),
            (Some(start), &[0.0, 1.0][..]),
            "{cells:?}"
        );
    }
}

/// Every option that a message offers, alone: the values behind the names of options in it.
fn offers(message: &str, columns: &[&str]) -> Vec<ReadOptions> {
    let mut found = vec![];
    for name in ["time_format", "sample_time", "zone", "date", "map"] {
        for (at, _) in message.match_indices(&format!("{name} ")) {
            let rest = &message[at + name.len() + 1..];
            let end = rest.find([',', ';', '\n']).unwrap_or(rest.len());
            for value in rest[..end].split(" or ").map(str::trim) {
                let values = match value.strip_suffix("COLUMN") {
                    Some(role) => columns.iter().map(|column| format!("{role}{column}")).collect(),
                    None => vec![value.to_owned()],
                };
                for value in values {
                    let mut options = ReadOptions::default();
                    let is_one = match name {
                        "time_format" => {
                            value.parse().map(|format| options.time_format = Some(format)).is_ok()
                        }
                        "sample_time" => {
                            value.parse().map(|seconds| options.sample_time = Some(seconds)).is_ok()
                        }
                        "zone" => value.parse().map(|zone| options.zone = Some(zone)).is_ok(),
                        "date" => value.parse().map(|day| options.date = Some(day)).is_ok(),
                        _ => value.parse().map(|mapped| options.map.push(mapped)).is_ok(),
                    };
                    if is_one {
                        found.push(options);
                    }
                }
            }
        }
    }
    found
}

#[test]
fn every_advice_works_within_two_steps() {
    let two = |a: &str, b: &str| table("time,op", [format!("{a},50"), format!("{b},51")]);
    let mut read = 0;
    let many = |cell: &dyn Fn(usize) -> String| {
        table("time,op", (0..20).map(|k| format!("{},5{}", cell(k), k % 7)))
    };
    for (name, text, given) in [
        ("day or month", two("05/06/2024 00:00:00", "05/06/2024 00:00:01"), ""),
        ("no time", two("yesterday", "today"), ""),
        ("a time and none", two("2025-03-14 06:00:00", "later"), ""),
        ("empty", two("2025-03-14 06:00:00", ""), ""),
        ("hours or minutes", two("12:40", "12:41"), ""),
        ("times of day and none", two("06:00:00", "noon"), ""),
        ("parts", two("06:00:00", "06:01"), ""),
        ("offset and none", two("2025-03-14 06:00:00Z", "2025-03-14 06:00:01"), ""),
        ("abbreviation", two("14 Mar 2025 06:00:00 EST", "14 Mar 2025 06:00:01 EST"), ""),
        (
            "no such hour",
            two("2025-03-30 02:30:00", "2025-03-30 02:30:01"),
            "zone = \"Europe/Berlin\"",
        ),
        ("no such day", two("31/02/2025 06:00", "31/02/2025 06:01"), ""),
        (
            "not by this order",
            two("31/01/2025 06:00", "31/01/2025 06:01"),
            "time_format = \"month-first\"",
        ),
        ("other order", two("13/01/2025 06:00", "01/13/2025 06:01"), ""),
        ("not by the pattern", two("06h00", "later"), "time_format = \"%Hh%M\""),
        ("a number and none", two("1", "later"), ""),
        ("days or seconds", many(&|k| format!("{}", 45_730.0 + k as f64 / 86_400.0)), ""),
        (
            "ticks or ns",
            many(&|k| format!("{}", 638_775_288_000_000_000u64 + 10_000_000 * k as u64)),
            "",
        ),
        ("hours", many(&|k| format!("{:.7}", k as f64 / 24.0)), ""),
        ("too fast", many(&|k| format!("{}", k as f64 * 1e-5)), ""),
        ("numbers, not dates", many(&|k| k.to_string()), "time_format = \"day-first\""),
        ("beyond", two("1850-01-01 06:00:00", "1850-01-01 06:00:01"), ""),
        ("all the same", many(&|_| "2025-03-14 06:00:00".to_owned()), ""),
        ("too few digits", many(&|k| format!("2025-03-14 06:{:02}", k / 4)), ""),
        ("repeated", many(&|k| (k % 3).to_string()), ""),
        ("steps too far", two("0", "1e9"), ""),
        ("no column", table("x,op", (0..4).map(|k| format!("{k},5{k}"))), ""),
        (
            "two dates",
            table("date,datum,op", (0..4).map(|k| format!("2025-03-1{k},2025-04-1{k},5{k}"))),
            "",
        ),
        ("sample time", table("op", ["50".to_owned(), "51".to_owned()]), ""),
        ("sample time of the file", "sample_time: 1e9\nop,pv\n50,1\n51,2\n".to_owned(), ""),
    ] {
        let mapping = if given.is_empty() {
            ReadOptions::default()
        } else {
            ReadOptions::parse(given, "m").unwrap()
        };
        let names: Vec<&str> =
            ["x", "time", "date"].into_iter().filter(|each| text.contains(each)).collect();
        let Err(first) = parse(&text, &mapping) else {
            read += 1;
            continue;
        };
        let offered = offers(&first, &names);
        assert!(!offered.is_empty(), "{name}: {first}");
        for one in offered {
            // The advice is added to what was given.
            let zone = one.zone.clone().or_else(|| mapping.zone.clone());
            let one = ReadOptions { zone, ..one };
            let Err(second) = parse(&text, &one) else { continue };
            let more = offers(&second, &names);
            assert!(!more.is_empty(), "{name}: {first}\n{second}");
            let works = more.iter().any(|more| parse(&text, more).is_ok());
            assert!(works, "{name}: {first}\n{second}");
        }
    }
    // The others show that there is advice to follow.
    assert!(read <= 3, "{read} were read");
}

/// Times of `count` rows, one per `step` s, written with `digits` decimals of a unit of so many seconds.
fn written(name: &str, (unit, digits): (f64, usize), times: &[f64]) -> String {
    let row = |(k, at): (usize, &f64)| {
        let v = wave(0, k);
        format!("{:.digits$},{v},{}", at / unit, 100.0 - v)
    };
    table(&format!("{name},pv,op"), times.iter().enumerate().map(row))
}

proptest! {
    #[test]
    fn regular_times_with_few_digits_get_the_mean_step(
        step in prop_oneof![Just(1.0), Just(2.0), Just(5.0), Just(10.0), Just(2.5)],
        phase in 0.0f64..1.0,
        rows in 300usize..900,
        way in prop_oneof![
            Just(("Time (h)", (3600.0, 3))), Just(("Time (d)", (86_400.0, 5))), Just(("Time (min)", (60.0, 2))),
            Just(("Time (s)", (1.0, 0))),
        ],
        gap in any::<bool>(),
        is_turned in any::<bool>(),
    ) {
        let resolution = way.1.0 * 10f64.powi(-(way.1.1 as i32));
        let units = step / resolution;
        let rarer = units.fract().min(1.0 - units.fract());
        // Repeated times are refused, steps of one length are the sample time, and a few long ones are lost samples.
        prop_assume!(units > 1.0 && (units.fract() == 0.0 || units > 2.0 || rarer > 0.11));
        let lost = if gap { 40.0 } else { 0.0 };
        let mut times: Vec<f64> =
            (0..rows).map(|k| (k as f64 + phase + if k > 200 { lost } else { 0.0 }) * step).collect();
        if is_turned {
            times.reverse();
        }
        let reading = read(&written(way.0, way.1, &times));
        let found = &reading.recordings[0].op.time;
        let mut sorted = found.clone();
        sorted.sort_by(f64::total_cmp);
        for (k, pair) in sorted.windows(2).enumerate() {
            let expected = if k == 200 { (lost + 1.0) * step } else { step };
            let expected = if is_turned || k != 200 { pair[1] - pair[0] } else { expected };
            prop_assert!((pair[1] - pair[0] - expected).abs() < 1e-3 * step, "{k} {pair:?}");
        }
        let is_note = said(&reading, "the sample time is the mean step").is_some();
        prop_assert_eq!(is_note, rarer > 1e-6, "{} {:?}", units, reading.notes);
        if rarer > 1e-6 {
            let note = said(&reading, &format!("the mean step, {step} s"));
            prop_assert!(note.is_some(), "{:?}", reading.notes);
        }
    }

    #[test]
    fn steps_at_random_stay_as_they_are(
        steps in proptest::collection::vec(any::<bool>(), 60..400),
        (short, long) in prop_oneof![Just((1.0, 2.0)), Just((2.0, 3.0)), Just((5.0, 6.0))],
    ) {
        let mut at = 0.0;
        let times: Vec<f64> = steps.iter().map(|is_long| { at += if *is_long { long } else { short }; at }).collect();
        let reading = read(&written("t", (1.0, 0), &times));
        let first = reading.recordings[0].op.time[0];
        prop_assert!(reading.recordings[0].op.time.iter().zip(&times).all(|(a, b)| a - first == b - times[0]));
        prop_assert!(said(&reading, "mean step").is_none());
    }
}

#[test]
fn steps_that_truly_differ_are_not_rounded_ones() {
    let all = |of: &dyn Fn(usize) -> f64| (0..600).map(of).collect::<Vec<f64>>();
    for (name, times) in [
        ("one row in 60 is lost", all(&|k| (k + k / 59) as f64)),
        ("one row is lost", all(&|k| (k + k / 300) as f64)),
        ("one row in four is lost at 20 s", all(&|k| 20.0 * (k + k / 3) as f64)),
        ("jitter of 1 s", all(&|k| (10 * k + k * 7919 % 13 / 7) as f64)),
        ("stored on change", all(&|k| (k + (k * k / 3) % 5 + k / 2) as f64)),
        ("a slower second half", all(&|k| (k + k.saturating_sub(300)) as f64)),
        ("a clock in milliseconds", all(&|k| k as f64 + 0.001 * (k * 7919 % 13) as f64)),
    ] {
        let mut times = times;
        times.sort_by(f64::total_cmp);
        times.dedup();
        let reading = read(&written("Time (s)", (1.0, 3), &times));
        let own = &reading.recordings[0].op.time;
        assert!(own.iter().zip(&times).all(|(a, b)| (a - b).abs() < 1e-6), "{name}");
        assert!(said(&reading, "mean step").is_none(), "{name}");
    }
}

#[test]
fn each_tag_of_a_long_file_gets_the_mean_step() {
    let rows = ["FIC1.PV", "FIC1.OP"].into_iter().flat_map(|tag| {
        (0..300).map(move |k| format!("{tag},{:.5},{}", 45_740.0 + k as f64 / 43_200.0, wave(0, k)))
    });
    let reading = read(&table("Tag,Timestamp,Value", rows));
    let one = &reading.recordings[0];
    assert_eq!(one.op.time, one.pv.as_ref().unwrap().time);
    assert!(one.op.time.windows(2).all(|pair| (pair[1] - pair[0] - 2.0).abs() < 1e-9));
    let note = said(&reading, "are rounded to 0.864 s, so their steps alternate").unwrap();
    assert!(note.contains("\"Timestamp\"") && note.ends_with("the mean step, 2 s"), "{note}");
}

#[test]
fn the_proposed_sample_time_is_that_of_the_times() {
    let minutes = |k: usize| format!("23/04/2025 06:{:02}", k / 3);
    let rows = |end: &'static str| (0..90).map(move |k| format!("{}{end},5{}", minutes(k), k % 7));
    let text = table("time,op", rows(""));
    let message = parse(&text, &ReadOptions::default()).unwrap_err();
    assert!(message.contains("too few digits") && message.ends_with("sample_time 20"), "{message}");
    let given =
        |sample_time| ReadOptions { sample_time: Some(sample_time), ..ReadOptions::default() };
    let reading = parse(&text, &given(1.0)).unwrap();
    let note = said(&reading, "\"time\" is not used, because a sample time is given").unwrap();
    assert!(
        note.contains("its times are 20 s apart") && note.ends_with("sample_time 20"),
        "{note}"
    );
    // Neither is a contradiction, nor times that cannot be read.
    for (text, sample_time) in [
        (text, 20.0),
        (table("time,op", (0..90).map(|k| format!("{k}.0{},5{}", k % 3, k % 7))), 1.0),
        (table("time,op", (0..90).map(|k| format!("row {k},5{}", k % 7))), 1.0),
    ] {
        let reading = parse(&text, &given(sample_time)).unwrap();
        assert!(said(&reading, "apart on average").is_none(), "{:?}", reading.notes);
    }
    // A closing row is no sample.
    let text = table(
        "time,op",
        rows(":00").enumerate().map(|(k, row)| if k < 89 { row } else { ",50.5".to_owned() }),
    );
    let message = parse(&text, &ReadOptions::default()).unwrap_err();
    assert!(
        message.ends_with(
            "row 91, column \"time\": is empty; every row needs a time; give one or remove the row"
        ),
        "{message}"
    );
}
