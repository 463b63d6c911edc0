//! The row of a window, from the recordings of its loop.
//!
//! A scan of files, a table and a distributed engine all use this one way from samples to a row.

use crate::day;
use crate::plant_file::{self, LoopFacts, Plant};
use crate::store::trace::{Trace, TraceSignal};
use crate::store::window::{ENGINE_VERSION, WindowRow, model_version};
use sha2::{Digest, Sha256};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc;
use std::time::Duration;
use stiction_diagnose::diagnose::{Detectors, DiagnoseOptions, Diagnosis, FINE_UP_TO, diagnose};
use stiction_diagnose::recording::{Channel, Modes, Recording};
use stiction_io::join;

/// The fewest periods of a window, within [`MOST_DAYS`].
pub const PERIODS: f64 = 10.0;
/// The most days of a window.
pub const MOST_DAYS: i64 = 7;

/// The longest time for a window by default, s. Most take less than a second.
pub const TIME_LIMIT_S: u32 = 300;

/// The recordings of a loop, each with the name of its file, or the reason why they could not be read.
pub type Parts<'a> = Result<&'a [(&'a str, Recording)], &'a str>;

/// One loop of a plant, to be judged.
#[derive(Debug, Clone)]
pub struct Judge<'a> {
    plant: &'a Plant,
    facts: Option<&'a LoopFacts>,
    name: &'a str,
    /// SHA-256 of the settings in the plant's file that affect its verdict.
    pub settings: String,
    /// The longest time for a window, s.
    limit_s: u32,
}

/// Beginning of the error of a window that reached the time limit.
pub const TOO_LONG: &str = "took longer than the time limit";

/// The result of a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Row; none without a sample of the OP.
    pub row: Option<WindowRow>,
    /// Trace, if it could be judged.
    pub trace: Option<Trace>,
    /// The number of days that the window should have: the duration of ten periods.
    pub days: i64,
}

impl<'a> Judge<'a> {
    /// Of the loop called `name`.
    pub fn of(plant: &'a Plant, name: &'a str) -> Self {
        let limit_s = plant.file.time_limit_s.unwrap_or(TIME_LIMIT_S);
        Self { plant, facts: plant.facts(name), name, settings: plant.settings_hash(name), limit_s }
    }

    /// With this limit of time for a window, s, instead of the limit in the plant's file.
    #[must_use]
    pub fn within(self, limit_s: Option<u32>) -> Self {
        Self { limit_s: limit_s.unwrap_or(self.limit_s), ..self }
    }

    /// The settings of a row that reached the time limit. A scan with another limit judges it again.
    pub fn limited_settings(&self) -> String {
        plant_file::hash(&format!("{} {}", self.settings, self.limit_s))
    }

    /// Judges the window of `count` days from `day` on, with the samples of its days and of the day before.
    pub fn window(&self, parts: Parts<'_>, day: i64, count: i64) -> Judged {
        let fine_up_to = self.plant.file.fine_up_to.unwrap_or(FINE_UP_TO);
        let options = DiagnoseOptions {
            detectors: Detectors::None,
            plan: false,
            fine_up_to,
            ..DiagnoseOptions::default()
        };
        let recording =
            match parts.map_err(str::to_owned).and_then(|p| self.recording(p, day, count)) {
                Ok(Some(recording)) => recording,
                Ok(None) => return Judged { row: None, trace: None, days: 1 },
                Err(error) => return self.refused(day, count, error),
            };
        let identity = WindowRow {
            samples_fingerprint: Some(fingerprint(&recording)),
            ..self.identity(day, count)
        };
        let (start, window_s) = (identity.window_start, identity.window_s);
        let found = within(self.limit_s, move || {
            let found = judged(&recording, &options)?;
            let trace = Trace::of(&recording, start, window_s, TraceSignal::of(&found));
            Ok((found, trace))
        });
        let Some(found) = found else {
            let error = format!(
                "{TOO_LONG} of {} s on this computer; stiction plant scan judges it again with a longer --time-limit",
                self.limit_s
            );
            let settings_hash = self.limited_settings();
            let row = WindowRow { error: Some(error), settings_hash, ..identity };
            return Judged { row: Some(row), trace: None, days: 1 };
        };
        match found {
            Ok((found, trace)) => {
                let period =
                    found.oscillation().filter(|(_, o)| o.found).and_then(|(_, o)| o.period_s);
                let days = period.map_or(1, |p| (PERIODS * p / 86_400.0).ceil() as i64);
                let row = identity.judged(&found);
                Judged {
                    trace,
                    row: Some(match &found.test {
                        Some(test) => row.tested(test),
                        None => row,
                    }),
                    days: days.clamp(1, MOST_DAYS),
                }
            }
            Err(error) => {
                let row = WindowRow { error: Some(error), ..identity };
                Judged { row: Some(row), trace: None, days: 1 }
            }
        }
    }

    /// The row of a window that cannot be judged.
    pub fn refused(&self, day: i64, count: i64, error: String) -> Judged {
        let row = WindowRow { error: Some(error), ..self.identity(day, count) };
        Judged { row: Some(row), trace: None, days: 1 }
    }

    /// The part of a row that is known before the window is judged.
    fn identity(&self, day: i64, count: i64) -> WindowRow {
        let zone = &self.plant.zone;
        let (start, end) = (day::begin(day, zone), day::begin(day + count, zone));
        let facts = self.facts;
        WindowRow {
            name: self.name.to_owned(),
            area: facts.and_then(|facts| facts.area.clone()),
            unit: facts.and_then(|facts| facts.unit.clone()),
            loop_type: facts.and_then(|f| f.loop_type.clone()).unwrap_or("unknown".to_owned()),
            window_start: start as i64,
            window_s: (end - start) as i64,
            engine_version: ENGINE_VERSION.to_owned(),
            model_version: model_version(),
            settings_hash: self.settings.clone(),
            ..WindowRow::default()
        }
    }

    /// The recording of a window, from all its parts; none without a sample of the OP.
    ///
    /// # Errors
    /// If parts contradict each other, a sentence.
    pub fn recording(
        &self,
        parts: &[(&str, Recording)],
        day: i64,
        count: i64,
    ) -> Result<Option<Recording>, String> {
        let begin = |day: i64| day::begin(day, &self.plant.zone);
        let (before, from, to) = (begin(day - 1), begin(day), begin(day + count));
        let joined = |from: f64| {
            let parts: Vec<(&str, Recording)> = parts
                .iter()
                .filter_map(|(path, part)| Some((*path, day::slice(part, from, to)?)))
                .collect();
            join::join(&parts.iter().map(|(path, part)| (*path, part)).collect::<Vec<_>>())
        };
        // If the day before does not fit, the window is judged without it.
        if !parts.iter().any(|(_, part)| day::slice(part, from, to).is_some()) {
            return Ok(None);
        }
        let whole = joined(before).or_else(|_| joined(from)).map_err(|e| e.to_string())?;
        Ok(day::cut(&in_order(whole), from, to))
    }
}

/// The samples of each channel in order of time, and of equal times by value.
fn in_order(mut recording: Recording) -> Recording {
    let channels = [
        Some(&mut recording.op),
        recording.pv.as_mut(),
        recording.sp.as_mut(),
        recording.vp.as_mut(),
    ];
    for channel in channels.into_iter().flatten() {
        let order = |a: &usize, b: &usize| {
            let key = |k: usize| (channel.time[k], channel.values[k], channel.quality[k] as u8);
            let ((t, v, q), (u, w, r)) = (key(*a), key(*b));
            t.total_cmp(&u).then(v.total_cmp(&w)).then(q.cmp(&r))
        };
        let mut places: Vec<usize> = (0..channel.time.len()).collect();
        if places.is_sorted_by(|a, b| order(a, b).is_le()) {
            continue;
        }
        places.sort_by(order);
        *channel = Channel {
            time: places.iter().map(|k| channel.time[*k]).collect(),
            values: places.iter().map(|k| channel.values[*k]).collect(),
            quality: places.iter().map(|k| channel.quality[*k]).collect(),
            ..channel.clone()
        };
    }
    if let Some(Modes { time, modes }) = &mut recording.mode {
        let mut all: Vec<_> = time.iter().copied().zip(modes.iter().copied()).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1 as u8).cmp(&(b.1 as u8))));
        (*time, *modes) = all.into_iter().unzip();
    }
    recording
}

/// SHA-256 of the samples of a recording. It does not depend on where they were stored.
pub(crate) fn fingerprint(recording: &Recording) -> String {
    let mut bytes: Vec<u8> = vec![];
    let number = |bytes: &mut Vec<u8>, value: f64| {
        let value = if value.is_nan() { f64::NAN } else { value };
        bytes.extend(value.to_le_bytes());
    };
    let channels =
        [Some(&recording.op), recording.pv.as_ref(), recording.sp.as_ref(), recording.vp.as_ref()];
    for channel in channels {
        let Some(channel) = channel else {
            bytes.push(0);
            continue;
        };
        bytes.push(1);
        bytes.extend((channel.time.len() as u64).to_le_bytes());
        for k in 0..channel.time.len() {
            number(&mut bytes, channel.time[k]);
            number(&mut bytes, channel.values[k]);
            bytes.push(channel.quality[k] as u8);
        }
        for end in channel.range.iter().flat_map(|range| [range.low, range.high]) {
            number(&mut bytes, end);
        }
    }
    if let Some(modes) = &recording.mode {
        for (time, mode) in modes.time.iter().zip(&modes.modes) {
            number(&mut bytes, *time);
            bytes.push(*mode as u8);
        }
    }
    format!("{:x}", Sha256::digest(bytes))
}

/// What is computed, or `None` if it takes longer than `limit_s`. Its thread then runs until the program ends.
fn within<T: Send + 'static>(
    limit_s: u32,
    compute: impl FnOnce() -> Result<T, String> + Send + 'static,
) -> Option<Result<T, String>> {
    let (send, receive) = mpsc::sync_channel(1);
    // In a pool of its own, a loop computes in one thread.
    let pool = match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool,
        Err(e) => return Some(Err(format!("no thread could be started: {e}"))),
    };
    pool.spawn(move || {
        let found = catch_unwind(AssertUnwindSafe(compute)).unwrap_or_else(|_| Err(failed()));
        // Nobody waits for it after the limit.
        let _ = send.send(found);
    });
    receive.recv_timeout(Duration::from_secs(limit_s.into())).ok()
}

/// A diagnosis. A fault of the program ends this diagnosis only.
fn judged(recording: &Recording, options: &DiagnoseOptions) -> Result<Diagnosis, String> {
    diagnose(recording, options).map_err(|e| e.to_string())
}

/// The error of a window in which a fault of the program ends the diagnosis only.
fn failed() -> String {
    "the program failed on this window; please report the fault with the data".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_diagnose::recording::Mode;

    #[test]
    fn the_order_of_samples_changes_no_row() {
        let plant = Plant::parse("name = \"N\"", "plant.toml").unwrap();
        let mut recording = stiction_population::LoopKind::Sticky.simulate(7).unwrap().recording;
        recording.start = Some(0.0);
        let half = recording.op.time[recording.op.time.len() / 2];
        recording.mode = Some(Modes {
            time: vec![0.0, half, half + 60.0],
            modes: vec![Mode::Automatic, Mode::Manual, Mode::Automatic],
        });
        let judge = Judge::of(&plant, "A");
        let row = |recording: Recording| judge.window(Ok(&[("a", recording)]), 0, 1).row.unwrap();
        let expected = row(recording.clone());
        assert!(expected.error.is_none() && expected.auto_share < Some(100.0), "{expected:?}");
        let mut turned = recording.clone();
        for channel in [Some(&mut turned.op), turned.pv.as_mut()].into_iter().flatten() {
            channel.time.reverse();
            channel.values.reverse();
            channel.quality.reverse();
        }
        if let Some(modes) = &mut turned.mode {
            modes.time.reverse();
            modes.modes.reverse();
        }
        assert_eq!(row(turned), expected);
        recording.op.values[10] += 1e-9;
        assert_ne!(row(recording).samples_fingerprint, expected.samples_fingerprint);
    }
}
