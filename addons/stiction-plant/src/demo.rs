//! A simulated plant with known truth.
//!
//! It has units of coupled loops of the [population](stiction_population::network), recorded for days at their own
//! sample times, as long Parquet with a file per day. Sticking valves make other loops swing. Of every fifty loops, the
//! first five have an event. The first is repaired midway, and the second begins to stick midway. The PV of the third
//! is dead on the last day, the fourth is in manual every morning, and S of the fifth grows from day to day.

use crate::day;
use crate::error::{Error, Result, file, store};
use crate::plant_file;
use crate::propose::quoted;
use crate::store::parquet_file::Writer;
use crate::store::table::{Cells, Column, Kind, Table};
use crate::store::write_whole;
use rayon::prelude::*;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use stiction_diagnose::recording::LoopType;
use stiction_diagnose::series::{mean, zero_crossings};
use stiction_population::LoopKind;
use stiction_population::network::{
    Cause, Course, LinkKind, Network, NetworkLoop, NetworkPlan, NetworkRun, NetworkTruth, Samples,
};

/// The first day, days since 1970-01-01: Monday, 2026-03-02.
pub const FIRST_DAY: i64 = 20_514;
const DAY: f64 = 86_400.0;
/// In manual from 06:00 to 09:00.
const MANUAL: (f64, f64) = (21_600.0, 32_400.0);
/// Number of loops of a unit, which act on each other.
const UNIT: usize = 20;
/// The first of this many loops have events.
const STORIES: usize = 50;
/// The sticking valves of a unit, without its loops that have an event.
const STICKING: [usize; 2] = [7, 13];
/// S of a valve that gets worse, on the last day over that on the first.
const WORSE: f64 = 2.5;
/// A unit is drawn this often at most, until its sticking valves cycle.
const DRAWS: u64 = 30;
/// Cycling valves cross their mean this often on a day, at least.
const CROSSINGS: usize = 24;
/// Units that are in memory at once, a day of each.
const AT_ONCE: usize = 8;

/// The story of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Story {
    Repaired,
    Begins,
    DeadPv,
    Manual,
    Worsens,
    Sticks,
    None,
}

impl Story {
    fn of(index: usize) -> Self {
        let stories = [Self::Repaired, Self::Begins, Self::DeadPv, Self::Manual, Self::Worsens];
        let sticks = STICKING.contains(&(index % UNIT));
        let rest = if sticks { Self::Sticks } else { Self::None };
        stories.get(index % STORIES).copied().unwrap_or(rest)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Repaired => "repaired midway",
            Self::Begins => "begins to stick midway",
            Self::DeadPv => "PV dead on the last day",
            Self::Manual => "in manual 06:00 to 09:00",
            Self::Worsens => "sticks more from day to day",
            Self::Sticks | Self::None => "",
        }
    }

    /// When the valve sticks, in a plant with this number of days.
    fn course(self, days: usize) -> Course {
        let at_s = (days as f64 / 2.0).ceil() * DAY;
        match self {
            Self::Repaired => Course::Repaired { at_s },
            Self::Begins => Course::Begins { at_s },
            Self::Worsens => Course::Grows { factor: WORSE, within_s: days as f64 * DAY },
            Self::Sticks => Course::Sticks,
            Self::DeadPv | Self::Manual | Self::None => Course::Healthy,
        }
    }
}

/// Loops that act on each other.
struct Unit {
    /// Number of its first loop in the plant.
    first: usize,
    network: Network,
    /// The loops that its valves reach on a day on which all of them stick.
    truth: NetworkTruth,
}

impl Unit {
    /// The loops from number `first` on, for this number of days.
    fn draw(first: usize, loops: usize, days: usize, seed: u64) -> Result<Self> {
        let stories = || (0..loops).map(|k| Story::of(first + k));
        let sticking: Vec<usize> = stories()
            .enumerate()
            .filter(|(_, story)| story.course(days).ever())
            .map(|(k, _)| k)
            .collect();
        let outside = usize::from(loops == UNIT && (first / UNIT) % 3 == 2);
        let plan = NetworkPlan { loops, sticking, outside, coupled: true };
        let own = seed.wrapping_mul(1_000_003).wrapping_add(1000 * first as u64);
        let mut best: Option<(usize, Network, Vec<Samples>)> = None;
        for again in 0..DRAWS {
            let network = Network::planned(own.wrapping_add(again), &plan)?;
            let samples = network.run(None)?.record(DAY)?;
            let cycle = plan.sticking.iter().filter(|k| cycles(&samples[**k])).count();
            if best.as_ref().is_none_or(|(most, ..)| cycle > *most) {
                best = Some((cycle, network, samples));
            }
            if best.as_ref().is_some_and(|(most, ..)| *most == plan.sticking.len()) {
                break;
            }
        }
        let (_, mut network, samples) =
            best.ok_or_else(|| Error::Option("a unit could not be drawn".to_owned()))?;
        let truth = network.truth(&samples)?;
        for (each, story) in network.loops.iter_mut().zip(stories()) {
            each.course = story.course(days);
            each.manual = (story == Story::Manual).then_some(MANUAL);
        }
        Ok(Self { first, network, truth })
    }

    /// The tag of its loop `k`.
    fn name(&self, k: usize) -> String {
        let prefix = match self.network.loops[k].loop_type {
            LoopType::Level => "LIC",
            LoopType::Temperature => "TIC",
            LoopType::Pressure => "PIC",
            _ => "FIC",
        };
        format!("{prefix}{}", 1001 + self.first + k)
    }

    /// The causes that make loop `k` swing: other loops whose valves stick, and waves from outside, such as `wave-1`.
    fn reached_by(&self, k: usize) -> Vec<String> {
        let each = self.truth.causes.iter().filter(|reach| reach.swings[k]);
        let causes = each.filter_map(|reach| match reach.cause {
            Cause::Valve(source) => (source != k).then(|| self.name(source)),
            Cause::Outside(wave) => Some(format!("wave-{}", wave + 1)),
        });
        causes.collect()
    }

    /// The loops whose material comes to loop `k`.
    fn upstream(&self, k: usize) -> Vec<String> {
        let links = &self.network.links;
        let to = links.iter().filter(|link| link.to == k && link.kind == LinkKind::MassBalance);
        to.map(|link| self.name(link.from)).collect()
    }

    /// The heading and lines of loop `k` in `plant.toml`, and its row of `truth.csv`.
    fn written(&self, k: usize, days: usize) -> (String, String) {
        let (index, name) = (self.first + k, self.name(k));
        let each = &self.network.loops[k];
        let area = if index % 2 == 0 { "North" } else { "South" };
        let unit = format!("U-{}", 1 + self.first / UNIT);
        let mut plant = format!(
            "\n[loop.{}]\narea = {}\nunit = {}\nweight = {}\n",
            quoted(&name),
            quoted(area),
            quoted(&unit),
            1 + index % 5
        );
        let upstream = self.upstream(k);
        // It is written down for every other loop.
        if index % 2 == 0 && !upstream.is_empty() {
            let names: Vec<String> = upstream.iter().map(|name| quoted(name)).collect();
            // Writing to a string cannot fail.
            let _ = writeln!(plant, "upstream = [{}]", names.join(", "));
        }
        let reached_by = self.reached_by(k);
        let ever = each.course.ever();
        let kind = match (ever, reached_by.first()) {
            (true, _) => LoopKind::Sticky,
            (false, None) => LoopKind::Normal,
            // Valves come first.
            (false, Some(cause)) if cause.starts_with("wave-") => LoopKind::ExternalWave,
            (false, Some(_)) => LoopKind::StickingNeighbour,
        };
        let [s, j] = [each.s, each.j].map(|band| if ever { band } else { 0.0 });
        let grown = if matches!(each.course, Course::Grows { .. }) { WORSE } else { 1.0 };
        let last = (days as f64 - 0.5) * DAY;
        let truth = format!(
            "{name},{},{},{},{},{s},{j},{},{},{unit},{},{}\n",
            kind.name(),
            Story::of(index).name(),
            each.course.sticks(0.0),
            each.course.sticks(last),
            s * grown,
            each.sample_time_s,
            reached_by.join(" "),
            upstream.join(" ")
        );
        (plant, truth)
    }
}

/// Whether a valve cycles.
fn cycles(samples: &Samples) -> bool {
    let about = mean(&samples.vp);
    let away: Vec<f64> = samples.vp.iter().map(|v| v - about).collect();
    zero_crossings(&away).len() >= CROSSINGS
}

/// Writes a plant of `loops` loops and `days` days to `folder`: `plant.toml`, `data/`, `truth.csv`. `seen` is called for each loop.
/// Memory holds some units for a day, and the file of a day.
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
        return Err(Error::Option("a plant needs at least one loop and one day".to_owned()));
    }
    let firsts: Vec<usize> = (0..loops).step_by(UNIT).collect();
    let units: Vec<Unit> = firsts
        .par_iter()
        .map(|first| Unit::draw(*first, UNIT.min(loops - first), days, seed))
        .collect::<Result<_>>()?;
    let mut runs: Vec<NetworkRun<'_>> =
        units.iter().map(|unit| Ok(unit.network.run(None)?)).collect::<Result<_>>()?;
    for k in 0..days {
        let path = folder.join("data").join(format!("{}.parquet", day::date(FIRST_DAY + k as i64)));
        let mut writer = Writer::begin(vec![], columns()).map_err(|e| store(&path, e))?;
        for (units, runs) in units.chunks(AT_ONCE).zip(runs.chunks_mut(AT_ONCE)) {
            let recorded: Vec<Vec<Samples>> =
                runs.par_iter_mut().map(|run| Ok(run.record(DAY)?)).collect::<Result<_>>()?;
            for (unit, recorded) in units.iter().zip(recorded) {
                for (own, (number, each)) in
                    recorded.iter().zip(unit.network.loops.iter().enumerate())
                {
                    let dead = Story::of(unit.first + number) == Story::DeadPv && k + 1 == days;
                    let tags = tags(&unit.name(number), each, own, k, dead);
                    // A row group per loop, so that readers of one loop can skip the others.
                    writer.write(&table(&tags)).map_err(|e| store(&path, e))?;
                }
            }
        }
        let bytes = writer.end().map_err(|e| store(&path, e))?;
        write_whole(&path, &bytes)?;
        // Loops are done day by day, all together.
        (loops * k / days..loops * (k + 1) / days).for_each(|_| seen());
    }
    let mut plant = String::from(
        "name = \"Demo\"\nzone = \"UTC\"\ndata = [\"data/*.parquet\"]\n\n[area.North]\nweight = 2\n\n[area.South]\n",
    );
    let mut truth = String::from(
        "loop,kind,story,sticks_first_day,sticks_last_day,S,J,S_last_day,sample_time_s,unit,reached_by,upstream\n",
    );
    for unit in &units {
        for k in 0..unit.network.loops.len() {
            let (of_plant, of_truth) = unit.written(k, days);
            plant += &of_plant;
            truth += &of_truth;
        }
    }
    std::fs::create_dir_all(folder).map_err(file(folder))?;
    write_whole(&folder.join("truth.csv"), truth.as_bytes())?;
    write_whole(&folder.join(plant_file::NAME), plant.as_bytes())
}

/// A tag of a day: its name, the times of its samples, ms since 1970, and their values.
type Tag = (String, Vec<i64>, Vec<f64>);

/// The recording of a loop on day `k`, by tag and time.
fn tags(name: &str, each: &NetworkLoop, own: &Samples, k: usize, dead: bool) -> Vec<Tag> {
    let begin = FIRST_DAY * 86_400_000;
    let time = |i: usize| begin + (1000.0 * (own.from_s + i as f64 * own.step_s)).round() as i64;
    let times: Vec<i64> = (0..own.op.len()).map(time).collect();
    let mut tags = vec![];
    if let Some((from, to)) = each.manual {
        let midnight = begin + k as i64 * 86_400_000;
        let at = [0.0, from, to].map(|at| midnight + (1000.0 * at) as i64);
        tags.push((format!("{name}.MODE"), at.to_vec(), vec![1.0, 0.0, 1.0]));
    }
    let pv = match own.pv.first() {
        Some(first) if dead => vec![*first; own.pv.len()],
        _ => own.pv.clone(),
    };
    for (signal, values) in [("OP", own.op.clone()), ("PV", pv), ("SP", own.sp.clone())] {
        tags.push((format!("{name}.{signal}"), times.clone(), values));
    }
    tags
}

/// The columns of the recording.
fn columns() -> Vec<Column> {
    let column = |name, kind, meaning: &str| Column {
        name,
        unit: "",
        kind,
        optional: false,
        meaning: meaning.to_owned(),
    };
    vec![
        column("time", Kind::Time, "Time of the sample."),
        column("tag", Kind::Text, "Tag of the loop, and the signal."),
        column("value", Kind::Number, "Value in percent of span; for a mode, 1 is automatic."),
    ]
}

fn table(tags: &[Tag]) -> Table {
    let times = tags.iter().flat_map(|(_, times, _)| times).copied().map(Some);
    let names = tags.iter().flat_map(|(tag, times, _)| {
        let tag: Arc<str> = tag.as_str().into();
        times.iter().map(move |_| Some(Arc::clone(&tag)))
    });
    let values = tags.iter().flat_map(|(.., values)| values).copied().map(Some);
    let columns = [
        ("time", Cells::Count(times.collect())),
        ("tag", Cells::Text(names.collect())),
        ("value", Cells::Number(values.collect())),
    ];
    Table { columns: columns.map(|(name, cells)| (name.to_owned(), cells)).to_vec() }
}
