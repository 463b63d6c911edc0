//! The same samples give the same verdict, in whatever form a historian writes them: a wide table, a long one, an outer
//! join with empty cells, signals side by side with a clock each, or changes only.
//!
//! `STICTION_FORMS=200` sets the number of loops.

use std::fmt::Write;
use stiction_diagnose::diagnose::{DiagnoseOptions, Grade, diagnose};
use stiction_diagnose::recording::{Grid, GridOptions, Recording};
use stiction_io::ReadOptions;
use stiction_io::reading;
use stiction_population::member;

/// Loops without another number.
const LOOPS: u64 = 12;

/// A signal: its tag, and its samples as times and values.
type Signal = (&'static str, Vec<(f64, f64)>);

/// A time as it is written: milliseconds since 1970.
fn time(seconds: f64) -> String {
    format!("{:.0}", 1e3 * (1_741_910_400.0 + seconds))
}

/// A number as it is written.
fn shown(value: f64) -> String {
    let text = format!("{value:.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn wide(signals: &[Signal]) -> String {
    let mut rows: Vec<f64> =
        signals.iter().flat_map(|(_, samples)| samples.iter().map(|(t, _)| *t)).collect();
    rows.sort_by(f64::total_cmp);
    rows.dedup();
    let mut text = "timestamp".to_owned();
    signals.iter().for_each(|(tag, _)| text += &format!(",{tag}"));
    let mut next = vec![0; signals.len()];
    for row in rows {
        let _ = write!(text, "\n{}", time(row));
        for ((_, samples), next) in signals.iter().zip(&mut next) {
            text += ",";
            if let Some((_, value)) = samples.get(*next).filter(|(t, _)| *t == row) {
                text += &shown(*value);
                *next += 1;
            }
        }
    }
    text + "\n"
}

fn long(signals: &[Signal]) -> String {
    let mut text = "tag,time,value\n".to_owned();
    for (tag, samples) in signals {
        for (t, value) in samples {
            let _ = writeln!(text, "{tag},{},{}", time(*t), shown(*value));
        }
    }
    text
}

fn side_by_side(signals: &[Signal]) -> String {
    let header: Vec<String> =
        signals.iter().enumerate().map(|(k, (tag, _))| format!("Time{};{tag}", k + 1)).collect();
    let mut text = header.join(";");
    let longest = signals.iter().map(|(_, samples)| samples.len()).max().unwrap_or(0);
    for row in 0..longest {
        let cells = signals.iter().map(|(_, samples)| match samples.get(row) {
            Some((t, value)) => format!("{};{}", time(*t), shown(*value)),
            None => ";".to_owned(),
        });
        text += "\n";
        text += &cells.collect::<Vec<_>>().join(";");
    }
    text + "\n"
}

/// The samples that differ from the one before.
fn changes(signals: &[Signal]) -> Vec<Signal> {
    let of = |(tag, samples): &Signal| {
        let mut last = f64::NAN;
        let differs = |(_, value): &&(f64, f64)| {
            let differs = *value != last;
            last = *value;
            differs
        };
        (*tag, samples.iter().filter(differs).copied().collect())
    };
    signals.iter().map(of).collect()
}

/// The signals of a loop of the population, at whole milliseconds, and rounded to steps.
fn signals(recording: &Recording, steps: f64) -> Vec<Signal> {
    let of = |tag: &'static str, time: &[f64], values: &[f64]| {
        let known = || values.iter().copied().filter(|v| v.is_finite());
        let span = known().fold(f64::MIN, f64::max) - known().fold(f64::MAX, f64::min);
        let step = if span > 0.0 { 10f64.powf((span / steps).log10().round()) } else { 1.0 };
        let sample = |(t, v): (&f64, &f64)| ((1e3 * t).round() / 1e3, (v / step).round() * step);
        (tag, time.iter().zip(values).filter(|(_, v)| v.is_finite()).map(sample).collect())
    };
    let pv = recording.pv.as_ref().map(|pv| of("FIC1.PV", &pv.time, &pv.values));
    let sp = recording.sp.as_ref().map(|sp| of("FIC1.SP", &sp.time, &sp.values));
    let op = of("FIC1.OP", &recording.op.time, &recording.op.values);
    [pv, sp, Some(op)].into_iter().flatten().collect()
}

fn read(text: &str) -> Recording {
    let mut reading = reading::parse(text.as_bytes(), "f.csv", &ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}: {}", &text[..200.min(text.len())]));
    assert_eq!(reading.recordings.len(), 1);
    reading.recordings.remove(0)
}

fn grade(recording: &Recording) -> Option<Grade> {
    diagnose(recording, &DiagnoseOptions::default()).ok().map(|diagnosis| diagnosis.verdict.grade)
}

/// Whether two recordings are the same on the grid, or else have the same grade. The second is whether only the latter.
fn alike(a: &Recording, b: &Recording) -> (bool, bool) {
    let grid = |recording: &Recording| {
        Grid::of(recording, &GridOptions::default()).ok().map(|grid| grid.segments)
    };
    if grid(a) == grid(b) {
        return (true, false);
    }
    let is_same = grade(a) == grade(b);
    (is_same, is_same)
}

#[test]
fn one_loop_in_any_form() {
    let loops = std::env::var("STICTION_FORMS").ok().and_then(|n| n.parse().ok()).unwrap_or(LOOPS);
    let mut counts: Vec<(&str, [u64; 2])> = vec![];
    let mut other = vec![];
    for index in 0..loops {
        let recording = member(48, index).expect("a loop").recording;
        let fine = signals(&recording, 1000.0);
        let coarse = signals(&recording, 50.0);
        let step = fine[0].1[1].0 - fine[0].1[0].0;
        // The OP is read a fifth of a sample later, and the SP every twentieth time.
        let mut apart = fine.clone();
        for (tag, samples) in &mut apart {
            match *tag {
                "FIC1.OP" => samples
                    .iter_mut()
                    .for_each(|(t, _)| *t = (1e3 * (*t + step / 5.0)).round() / 1e3),
                "FIC1.SP" => {
                    let kept = samples.iter().copied().step_by(20);
                    *samples = kept.collect();
                }
                _ => {}
            }
        }
        let [whole, joined, every] = [&fine, &apart, &coarse].map(|signals| read(&long(signals)));
        for (form, text, expected) in [
            ("wide", wide(&fine), &whole),
            ("side by side", side_by_side(&fine), &whole),
            ("outer join", wide(&apart), &joined),
            ("clocks", side_by_side(&apart), &joined),
            ("changes, long", long(&changes(&coarse)), &every),
            ("changes, wide", wide(&changes(&coarse)), &every),
            ("changes, side by side", side_by_side(&changes(&coarse)), &every),
        ] {
            let (is_alike, by_grade) = alike(&read(&text), expected);
            let place = counts.iter().position(|(known, _)| *known == form).unwrap_or_else(|| {
                counts.push((form, [0; 2]));
                counts.len() - 1
            });
            counts[place].1[0] += u64::from(is_alike);
            counts[place].1[1] += u64::from(by_grade);
            if !is_alike {
                other.push(format!(
                    "loop {index}, {form}: {:?} for {:?}",
                    grade(&read(&text)),
                    grade(expected)
                ));
            }
        }
    }
    for (form, [alike, by_grade]) in &counts {
        println!("{form}: {alike} of {loops} alike, {by_grade} of them only in their grade");
    }
    println!("{}", other.join("\n"));
    for (form, [alike, _]) in counts {
        // What is stored on change loses nothing but the end of a run without changes.
        let least = if form.starts_with("changes") { 0.95 } else { 1.0 };
        assert!(
            alike as f64 >= least * loops as f64,
            "{form}: {alike} of {loops}; {}",
            other.join("; ")
        );
    }
}
