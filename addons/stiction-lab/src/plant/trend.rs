//! The samples of a loop, read from the plant's files as the scan reads them, and the diagnosis of a window.

use crate::calls::{Answer, Wrong};
use crate::judgement::Judgement;
use crate::lab::Lab;
use crate::turns::Wanted;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;
use stiction_diagnose::diagnose::DiagnoseOptions;
use stiction_diagnose::recording::{Channel, Recording};
use stiction_plant::plant_file::Plant;
use stiction_plant::scan::{SEGMENT, recordings_of};
use stiction_plant::{WindowRow, day, log};
use stiction_report::words;

/// Points of a signal at most.
const POINTS: usize = 4000;

/// Days of a loop.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Window {
    /// The state of the plant at the request.
    stamp: String,
    name: String,
    /// The first day, and how many.
    day: i64,
    days: i64,
}

impl Window {
    /// The samples of these days, from the plant's files.
    pub fn read(&self, folder: &Path) -> Answer<Recording> {
        let plant = Plant::read(folder)?;
        let begin = |day: i64| day::begin(day, &plant.zone) as i64;
        let (from, to) = (begin(self.day), begin(self.day + self.days));
        let row = WindowRow {
            name: self.name.clone(),
            window_start: from,
            window_s: to - from,
            ..WindowRow::default()
        };
        let read = recordings_of(folder, &plant, &[&row]).pop();
        read.ok_or_else(|| Wrong::own("nothing was read"))?
            .map_err(|why| Wrong::gone(format!("{}: {why}", self.name)))
    }
}

/// Which days of a loop are asked for.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrendRequest {
    /// Tag.
    #[serde(rename = "loop")]
    name: String,
    /// The first day.
    day: String,
    /// How many days.
    days: i64,
    /// Beginning of the part to show, s after the beginning of the first day.
    #[serde(default)]
    from_s: Option<f64>,
    /// End, s.
    #[serde(default)]
    to_s: Option<f64>,
}

/// The samples of a loop.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Trend {
    /// Tag.
    #[serde(rename = "loop")]
    name: String,
    /// Begin of the first day, s since 1970-01-01 UTC.
    start: f64,
    /// Begin of the first day by the clock of the plant, s since 1970-01-01.
    clock: f64,
    /// Beginning of the part shown, s after that.
    from_s: f64,
    /// End.
    to_s: f64,
    /// Unit of PV and SP, where a file names it.
    pv_unit: Option<String>,
    /// Set point.
    sp: Option<Line>,
    /// Process value.
    pv: Option<Line>,
    /// Output of the controller.
    op: Option<Line>,
    /// Valve position.
    vp: Option<Line>,
}

/// A signal.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Line {
    /// Times, s from the begin of the first day on.
    t: Vec<f64>,
    /// Values; none where a value is unknown.
    value: Vec<Option<f64>>,
    /// Number of samples.
    samples: usize,
    /// Whether these are only minimum and maximum of each stretch of time.
    thinned: bool,
}

/// Six digits are more than a screen shows.
fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

impl Line {
    /// The part of a channel between two times; a `held` channel may be stored only when it changes.
    fn of(channel: &Channel, from: f64, to: f64, held: bool) -> Self {
        let each = channel.time.iter().zip(&channel.values).zip(&channel.quality);
        let each = each
            .map(|((t, value), q)| (*t, (value.is_finite() && q.is_usable()).then_some(*value)));
        let before = each.clone().filter(|(t, _)| *t < from).max_by(|a, b| a.0.total_cmp(&b.0));
        let mut known: Vec<(f64, Option<f64>)> =
            each.filter(|(t, _)| *t >= from && *t <= to).collect();
        let samples = known.len();
        if held {
            if let Some((_, value)) = before.filter(|_| known.first().is_none_or(|k| k.0 > from)) {
                known.insert(0, (from, value));
            }
            if let Some((_, value)) = known.last().copied().filter(|(t, _)| *t < to) {
                known.push((to, value));
            }
        }
        let thinned = samples > POINTS;
        let points = if thinned { least_and_most(&known, from, to) } else { known };
        let (t, value) = points
            .into_iter()
            .map(|(t, value)| ((t * 1000.0).round() / 1000.0, value.map(short)))
            .unzip();
        Self { t, value, samples, thinned }
    }
}

/// Minimum and maximum of each of many equal stretches of time, in their order, so no peak is lost.
fn least_and_most(known: &[(f64, Option<f64>)], from: f64, to: f64) -> Vec<(f64, Option<f64>)> {
    let stretches = POINTS / 2;
    let place = |t: f64| ((t - from) / (to - from) * stretches as f64) as usize;
    let mut points = vec![];
    for stretch in known.chunk_by(|a, b| place(a.0) == place(b.0)) {
        let by_value = |a: &&(f64, Option<f64>), b: &&(f64, Option<f64>)| {
            a.1.unwrap_or_default().total_cmp(&b.1.unwrap_or_default())
        };
        let all = || stretch.iter().filter(|(_, value)| value.is_some());
        match (all().min_by(by_value), all().max_by(by_value)) {
            (Some(least), Some(most)) if least.0 <= most.0 => points.extend([*least, *most]),
            (Some(least), Some(most)) => points.extend([*most, *least]),
            _ => points.extend(stretch.first()),
        }
    }
    points
}

impl Window {
    fn requested(lab: &Lab, name: &str, first: &str, days: i64) -> Answer<Self> {
        let day = day::parse(first).map_err(Wrong::request)?;
        if !(1..=SEGMENT).contains(&days) {
            return Err(Wrong::request(format!("the request must be for 1 to {SEGMENT} days")));
        }
        let week = lab.plant.week(None)?;
        let name = log::loop_named(&week.plant, week.known.names(), name).map_err(Wrong::gone)?;
        Ok(Self { stamp: week.stamp.clone(), name: name.to_owned(), day, days })
    }
}

/// The samples of some days of a loop, from the plant's files.
///
/// # Errors
/// If no such loop exists, or no file contains those days.
pub fn trend(lab: &Lab, asked: TrendRequest) -> Answer<Trend> {
    let window = Window::requested(lab, &asked.name, &asked.day, asked.days)?;
    let recording = lab.plant.recording(&window)?;
    let plant = Plant::read(lab.plant.folder()?)?;
    let begin = |day: i64| day::begin(day, &plant.zone);
    let (start, end) = (begin(window.day), begin(window.day + window.days));
    let within = |at: Option<f64>, else_at: f64| {
        at.filter(|at| at.is_finite()).unwrap_or(else_at).clamp(0.0, end - start)
    };
    let (from_s, to_s) = (within(asked.from_s, 0.0), within(asked.to_s, end - start));
    if from_s >= to_s {
        return Err(Wrong::request("from_s must be before to_s"));
    }
    let line = |channel: &Channel| Line::of(channel, from_s, to_s, false);
    let held = |channel: &Channel| Line::of(channel, from_s, to_s, true);
    let unit = |channel: &Option<Channel>| channel.as_ref().and_then(|of| of.unit.clone());
    Ok(Trend {
        name: window.name,
        start,
        clock: plant.zone.plant_time(start).shows(start),
        from_s,
        to_s,
        pv_unit: unit(&recording.pv).or_else(|| unit(&recording.sp)),
        sp: recording.sp.as_ref().map(held),
        pv: recording.pv.as_ref().map(line),
        op: Some(held(&recording.op)),
        vp: recording.vp.as_ref().map(line),
    })
}

/// Which window is asked for.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindowRequest {
    /// The loop, by its tag.
    #[serde(rename = "loop")]
    name: String,
    /// The first day.
    day: String,
    /// How many days.
    days: i64,
}

/// A window that was judged again for its evidence.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Explained {
    /// The diagnosis, with its words.
    judgement: Judgement,
    /// What would decide, if the verdict is open.
    answer: Option<String>,
}

/// The diagnosis of a window.
///
/// # Errors
/// If no such loop exists, no file contains those days, or the window cannot be judged.
pub fn diagnose_window(lab: &Lab, asked: WindowRequest, wanted: &Wanted) -> Answer<Explained> {
    let window = Window::requested(lab, &asked.name, &asked.day, asked.days)?;
    let recording = lab.plant.recording(&window)?;
    // Reading may have taken long.
    wanted.check()?;
    let diagnosis = wanted.diagnose(&recording, &DiagnoseOptions::default())?;
    let answer = words::what_would_answer(&diagnosis);
    Ok(Explained { judgement: Judgement::new(diagnosis), answer })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_sticks_out_is_not_thinned_away() {
        let time: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut values: Vec<f64> = time.iter().map(|t| (t / 500.0).sin()).collect();
        values[51_234] = 40.0;
        values[77_001] = -40.0;
        let channel = Channel::new("PV", time, values).unwrap();
        let line = Line::of(&channel, 0.0, 100_000.0, false);
        assert!(line.thinned && line.t.len() <= POINTS + 2 && line.samples == 100_000);
        assert!(line.t.is_sorted());
        assert!(line.value.contains(&Some(40.0)) && line.value.contains(&Some(-40.0)));
        let part = Line::of(&channel, 51_000.0, 52_000.0, false);
        assert!(!part.thinned && part.t.len() == 1001);
        let rare = Channel::new("SP", vec![0.0, 40.0], vec![5.0, 6.0]).unwrap();
        let held = Line::of(&rare, 20.0, 100.0, true);
        assert_eq!((held.t, held.samples), (vec![20.0, 40.0, 100.0], 1));
        assert_eq!(held.value, [Some(5.0), Some(6.0), Some(6.0)]);
    }
}
