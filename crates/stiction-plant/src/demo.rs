//! A plant with known truth, to try things on.
//!
//! Loops of the [population](stiction_population), recorded for days at their own sample times, as long Parquet of a day a
//! file. The first four have a story: one is repaired midway, one begins to stick midway, of one the PV is dead on the
//! last day, one is in manual every morning.

use crate::day;
use crate::error::{Error, Result, file, store};
use crate::plant_file;
use crate::propose::quoted;
use crate::store::write_whole;
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, TimestampMillisecondArray};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use stiction_population::{LoopKind, ProcessKind, Simulated};

/// The first day, days since 1970-01-01: Monday, 2026-03-02.
pub const FIRST_DAY: i64 = 20_514;
const DAY: f64 = 86_400.0;
/// Sample times of a historian, s.
const SAMPLE_TIMES: std::ops::RangeInclusive<f64> = 5.0..=60.0;
/// In manual from 06:00 to 09:00.
const MANUAL: std::ops::Range<f64> = 21_600.0..32_400.0;

/// What the loops without a story are, over and over.
const KINDS: [LoopKind; 8] = [
    LoopKind::Normal,
    LoopKind::Sticky,
    LoopKind::Sine,
    LoopKind::SetPoint,
    LoopKind::Sticky,
    LoopKind::AggressiveTuning,
    LoopKind::ExternalWave,
    LoopKind::StickingNeighbour,
];

/// What happens to a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Story {
    Repaired,
    Worsens,
    DeadPv,
    Manual,
    None,
}

impl Story {
    fn of(index: usize) -> Self {
        [Self::Repaired, Self::Worsens, Self::DeadPv, Self::Manual]
            .get(index)
            .copied()
            .unwrap_or(Self::None)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Repaired => "repaired midway",
            Self::Worsens => "begins to stick midway",
            Self::DeadPv => "PV dead on the last day",
            Self::Manual => "in manual 06:00 to 09:00",
            Self::None => "",
        }
    }
}

/// Writes a plant of `loops` loops and `days` days to `folder`: `plant.toml`, `data/`, `truth.csv`. `seen` hears of each loop.
///
/// # Errors
/// If a file cannot be written, or there is no loop or day.
pub fn write(
    folder: &Path,
    loops: usize,
    days: usize,
    seed: u64,
    mut seen: impl FnMut(),
) -> Result<()> {
    if loops == 0 || days == 0 {
        return Err(Error::Option("a plant has one loop and one day at least".to_owned()));
    }
    let mut writers = vec![];
    for k in 0..days {
        let path = folder.join("data").join(format!("{}.parquet", day::date(FIRST_DAY + k as i64)));
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by("stiction".to_owned())
            .build();
        let schema = batch(&[]).map_err(|e| store(&path, e))?.schema();
        let writer = ArrowWriter::try_new(vec![], schema, Some(properties));
        writers.push((writer.map_err(|e| store(&path, e))?, path));
    }
    let mut plant = String::from(
        "name = \"Demo\"\nzone = \"UTC\"\ndata = [\"data/*.parquet\"]\n\n[area.North]\nweight = 2\n\n[area.South]\n",
    );
    let mut truth =
        String::from("loop,kind,story,sticks_first_day,sticks_last_day,S,J,sample_time_s\n");
    for index in 0..loops {
        let story = Story::of(index);
        let (simulated, sticks) = simulated(index, story, days, seed)?;
        let facts = &simulated.truth.facts;
        let prefix = if facts.process == ProcessKind::Integrating { "LIC" } else { "FIC" };
        let name = format!("{prefix}{}", 1001 + index);
        for (k, (writer, path)) in writers.iter_mut().enumerate() {
            let rows = rows(&name, &simulated, story, k, days);
            // A row group a loop: who wants one loop can leave out the others.
            let written =
                batch(&rows).and_then(|rows| writer.write(&rows)).and_then(|()| writer.flush());
            written.map_err(|e| store(path, e))?;
        }
        let area = if index % 2 == 0 { "North" } else { "South" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            plant,
            "\n[loop.{}]\narea = {}\nweight = {}",
            quoted(&name),
            quoted(area),
            1 + index % 5
        );
        let t = &simulated.truth;
        let _ = writeln!(
            truth,
            "{name},{},{},{},{},{},{},{}",
            t.kind.name(),
            story.name(),
            sticks.0,
            sticks.1,
            t.s,
            t.j,
            facts.sample_time_s
        );
        seen();
    }
    for (writer, path) in writers {
        let bytes = writer.into_inner().map_err(|e| store(&path, e))?;
        write_whole(&path, &bytes)?;
    }
    std::fs::create_dir_all(folder).map_err(file(folder))?;
    write_whole(&folder.join("truth.csv"), truth.as_bytes())?;
    write_whole(&folder.join(plant_file::NAME), plant.as_bytes())
}

/// A loop for all days, and whether its valve is at fault on the first and on the last.
fn simulated(
    index: usize,
    story: Story,
    days: usize,
    seed: u64,
) -> Result<(Simulated, (bool, bool))> {
    let kind = match story {
        Story::Repaired | Story::Worsens => LoopKind::Sticky,
        Story::DeadPv | Story::Manual => LoopKind::Normal,
        Story::None => KINDS[index % KINDS.len()],
    };
    // The first draw that a historian would sample as slowly, and whose fault shows and does not come and go.
    let mut own = seed.wrapping_mul(1_000_003).wrapping_add(1000 * index as u64);
    let factor = loop {
        let drawn = kind.simulate(own)?;
        let facts = &drawn.truth.facts;
        let shows = !drawn.truth.sticks || (drawn.truth.visible && facts.faulty_share >= 1.0);
        if shows && SAMPLE_TIMES.contains(&facts.sample_time_s) {
            let samples = days as f64 * DAY / facts.sample_time_s;
            break (samples / drawn.recording.op.values.len() as f64 + 0.01).max(0.1);
        }
        own = own.wrapping_add(1);
    };
    let mut simulated = kind.simulate_for(own, factor)?;
    let sticks = simulated.truth.sticks;
    let (first, last) = match story {
        Story::Repaired => (true, false),
        Story::Worsens => (false, true),
        _ => (sticks, sticks),
    };
    if first != last {
        // The same loop with a healthy valve.
        let healthy = LoopKind::Normal.simulate_for(own, factor)?;
        let half = (days as f64 / 2.0).ceil() * DAY / simulated.truth.facts.sample_time_s;
        swap(&mut simulated, &healthy, half as usize, first);
    }
    Ok((simulated, (first, last)))
}

/// Takes the values of `other` from sample `half` on, or before it.
fn swap(one: &mut Simulated, other: &Simulated, half: usize, behind: bool) {
    let put = |own: &mut Vec<f64>, other: &[f64]| {
        let length = own.len().min(other.len());
        let half = half.min(length);
        let range = if behind { half..length } else { 0..half };
        own[range.clone()].copy_from_slice(&other[range]);
        own.truncate(length);
    };
    let (own, other) = (&mut one.recording, &other.recording);
    put(&mut own.op.values, &other.op.values);
    for (own, other) in [(&mut own.pv, &other.pv), (&mut own.sp, &other.sp)] {
        if let (Some(own), Some(other)) = (own, other) {
            put(&mut own.values, &other.values);
        }
    }
}

/// A sample: time, ms since 1970; tag; value.
type Row = (i64, String, f64);

/// The samples of a loop on day `k`, by tag and time.
fn rows(name: &str, simulated: &Simulated, story: Story, k: usize, days: usize) -> Vec<Row> {
    let recording = &simulated.recording;
    let step = simulated.truth.facts.sample_time_s;
    let begin = (FIRST_DAY + k as i64) * 86_400_000;
    let until = recording.op.values.len();
    let from = ((k as f64 * DAY / step).ceil() as usize).min(until);
    let to = (((k + 1) as f64 * DAY / step).ceil() as usize).min(until);
    let offset = |i: usize| i as f64 * step - k as f64 * DAY;
    let time = |i: usize| begin + (1000.0 * offset(i)).round() as i64;
    let is_manual = |i: usize| story == Story::Manual && MANUAL.contains(&offset(i));
    let mut rows: Vec<Row> = vec![];
    if story == Story::Manual {
        for (at, mode) in [(0.0, 1.0), (MANUAL.start, 0.0), (MANUAL.end, 1.0)] {
            rows.push((begin + (1000.0 * at) as i64, format!("{name}.MODE"), mode));
        }
    }
    let mut held = f64::NAN;
    for i in from..to {
        if !(is_manual(i) && held.is_finite()) {
            held = recording.op.values[i];
        }
        rows.push((time(i), format!("{name}.OP"), held));
    }
    if let Some(pv) = &recording.pv {
        let dead = story == Story::DeadPv && k + 1 == days;
        let value = |i: usize| if dead { pv.values[from] } else { pv.values[i] };
        rows.extend(
            (from..to.min(pv.values.len())).map(|i| (time(i), format!("{name}.PV"), value(i))),
        );
    }
    if let Some(sp) = &recording.sp {
        rows.extend(
            (from..to.min(sp.values.len())).map(|i| (time(i), format!("{name}.SP"), sp.values[i])),
        );
    }
    rows
}

fn batch(rows: &[Row]) -> std::result::Result<RecordBatch, parquet::errors::ParquetError> {
    let time = rows.iter().map(|(time, ..)| *time).collect::<Vec<_>>();
    let tag = rows.iter().map(|(_, tag, _)| &**tag).collect::<Vec<_>>();
    let value = rows.iter().map(|(.., value)| *value).collect::<Vec<_>>();
    let columns: [(&str, ArrayRef); 3] = [
        ("time", Arc::new(TimestampMillisecondArray::from(time).with_timezone("UTC"))),
        ("tag", Arc::new(StringArray::from(tag))),
        ("value", Arc::new(Float64Array::from(value))),
    ];
    Ok(RecordBatch::try_from_iter(columns)?)
}
