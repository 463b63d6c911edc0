//! From samples at any times to segments on a regular grid.
//!
//! * **Sample time**: given, or else the most frequent time between samples of the reference channel, which is
//!   PV's, else OP's. A grid coarser than the samples picks samples: nothing is averaged.
//! * **Order**: samples are sorted by time. If the clock begins again or goes back, the rows stay in the order of the
//!   file, and all later times are moved; see [`restart`](super::restart).
//! * **Duplicates**: of several samples at one time the last usable one in the file counts. A mean would be a value
//!   that was never measured.
//! * **Values between samples**: a straight line for PV and VP, the last value for OP, SP, mode and any channel
//!   that is stored on change. A sample within 1e-6 sample times of a point of the grid is kept bit for bit.
//! * **Missing samples**: up to [`LONGEST_BRIDGE`] consecutive samples are bridged, by a regression on their neighbours
//!   in OP, PV and SP where that estimates known samples best (`bridge`); where more of OP or PV are missing, the
//!   recording is cut. Two samples of a regular channel more than 1.5 of its steps apart have missing
//!   ones between them. A missing SP holds. VP is bridged if it is known in [`LEAST_KNOWN_VP`] of a segment, and
//!   left out of the segment otherwise.
//! * **Mode**: the recording is cut where the controller was not in command.

mod bridge;
mod clock;
mod log;
mod repair;
mod track;

pub use repair::{GridRepair, RepairKind};

use super::rhythm::is_multiple;
use super::{Channel, Modes, Quality, Range, Recording};
use crate::error::{Error, Result};
pub(super) use clock::commonest_step;

use clock::SAME;
use log::Log;
use track::{Resampled, Run, State, Track};

/// The most consecutive missing samples that are bridged. Three: a line over more of them shapes the wave of a loop
/// that cycles in a dozen samples.
pub const LONGEST_BRIDGE: usize = 3;

/// The share of a segment in which VP must be known to be kept.
pub const LEAST_KNOWN_VP: f64 = 0.95;

/// Interpolation between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The last value holds: right for SP, mode and OP, which change in steps, and for signals stored on change.
    Hold,
    /// A straight line between neighbours: right for PV and VP.
    Linear,
}

/// Settings of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GridOptions {
    /// Time between the samples of the grid, s; by default the most frequent one of the recording.
    pub sample_time: Option<f64>,
}

/// Part of a recording in which the controller was in command and every sample is known, on a regular grid. All
/// signals have one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Time of its first sample, s on the recording's clock.
    pub from: f64,
    /// Time between samples, s.
    pub sample_time: f64,
    /// Controller output, percent of its range.
    pub op: Vec<f64>,
    /// Process value in its units.
    pub pv: Option<Vec<f64>>,
    /// Set point in the units of the PV.
    pub sp: Option<Vec<f64>>,
    /// Measured valve position, percent of its range.
    pub vp: Option<Vec<f64>>,
    /// Number of bridged samples, in OP or PV.
    pub bridged: usize,
}

impl Segment {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.op.len()
    }

    /// Estimates its missing samples of OP and PV from their neighbours.
    fn bridge(&mut self, missing_op: &[bool], missing_pv: &[bool]) {
        let Self { op, pv, sp, .. } = self;
        let sp = sp.as_deref().filter(|sp| sp.iter().all(|value| value.is_finite()));
        let others: Vec<&[f64]> = pv.as_deref().into_iter().chain(sp).collect();
        bridge::estimate(op, missing_op, &others, true);
        if let Some(pv) = pv {
            let others: Vec<&[f64]> = [&op[..]].into_iter().chain(sp).collect();
            bridge::estimate(pv, missing_pv, &others, false);
        }
    }

    /// `length` samples of the channel from number `from` on, or fewer at its end. The number of bridged samples is
    /// unknown for a part.
    pub fn part(&self, from: usize, length: usize) -> Self {
        let from = from.min(self.len());
        let until = (from + length).min(self.len());
        let cut = |x: &[f64]| x[from..until].to_vec();
        Self {
            from: self.from + from as f64 * self.sample_time,
            sample_time: self.sample_time,
            op: cut(&self.op),
            pv: self.pv.as_deref().map(cut),
            sp: self.sp.as_deref().map(cut),
            vp: self.vp.as_deref().map(cut),
            bridged: 0,
        }
    }

    /// Whether it has no samples.
    pub fn is_empty(&self) -> bool {
        self.op.is_empty()
    }

    /// The PV less the set point, or the PV if there is none; `None` without a PV.
    pub fn deviation(&self) -> Option<Vec<f64>> {
        let pv = self.pv.as_ref()?;
        let sp = self.sp.as_ref().filter(|sp| sp.iter().all(|value| value.is_finite()));
        Some(match sp {
            Some(sp) => pv.iter().zip(sp).map(|(pv, sp)| pv - sp).collect(),
            None => pv.clone(),
        })
    }

    /// Duration, s, with the last sample held.
    pub fn duration(&self) -> f64 {
        self.len() as f64 * self.sample_time
    }

    /// The time of each sample, s on the recording's clock.
    pub fn times(&self) -> Vec<f64> {
        (0..self.len()).map(|k| self.from + k as f64 * self.sample_time).collect()
    }
}

/// A recording on a regular grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Time between samples, s.
    pub sample_time: f64,
    /// The segments, in order of time. None if the loop never was in automatic, or had no samples.
    pub segments: Vec<Segment>,
    /// The repairs, in order of [`RepairKind`]; within one kind PV, OP, VP, SP, all.
    pub repairs: Vec<GridRepair>,
    /// From the first sample to the last, s.
    pub duration: f64,
    /// Share of the duration in which the controller was in command.
    pub closed_share: f64,
}

impl Grid {
    /// The longest segment, the first of several.
    pub fn longest(&self) -> Option<&Segment> {
        self.segments.iter().rev().max_by_key(|segment| segment.len())
    }

    /// Brings a recording onto a grid; see the [module](self). Segments have two samples or more.
    ///
    /// # Errors
    /// If the given sample time is not above 0, no sample time is given and the reference channel has fewer than two
    /// usable samples at different times, or the grid would have more than twenty million points.
    pub fn of(recording: &Recording, options: &GridOptions) -> Result<Self> {
        let mut repairs = vec![];
        let separated = separated(recording, &mut repairs);
        let recording = separated.as_ref().unwrap_or(recording);
        let tracks = Tracks::of(recording, options, &mut repairs)?;
        let (step, (signal, reference)) = (tracks.step, tracks.reference());
        let (first, last) = (reference.first(), reference.last());
        // An OP that nobody moves holds for any time.
        let runs = reference.runs(step, tracks.pv.as_ref().map(|_| &tracks.op))?;
        // Between the runs the reference channel has a long gap.
        let mut log = Log::default();
        for pair in runs.windows(2) {
            log.gap(signal, pair[0].to, ((pair[1].from - pair[0].to) / step).round() as usize - 1);
        }
        let segments =
            runs.iter().flat_map(|run| tracks.segments(run, recording, &mut log)).collect();
        repairs.extend(log.repairs(recording));
        repairs.sort_by_key(|repair| (repair.kind, rank(repair.signal)));
        Ok(Self {
            sample_time: step,
            segments,
            repairs,
            duration: last - first,
            closed_share: closed_share(tracks.modes.as_ref(), first, last),
        })
    }
}

/// The signals of a recording on one clock, not yet on a grid.
struct Tracks {
    /// Time between the samples of the grid, s.
    step: f64,
    op: Track,
    pv: Option<Track>,
    vp: Option<Track>,
    sp: Option<Track>,
    /// Times in which the controller was in command.
    modes: Option<Vec<(f64, bool)>>,
}

impl Tracks {
    /// Puts the signals on the clock of the PV or, if it is unusable, of the OP.
    fn of(
        recording: &Recording,
        options: &GridOptions,
        repairs: &mut Vec<GridRepair>,
    ) -> Result<Self> {
        for (signal, channel) in [
            ("OP", Some(&recording.op)),
            ("PV", recording.pv.as_ref()),
            ("SP", recording.sp.as_ref()),
            ("VP", recording.vp.as_ref()),
        ] {
            channel.map_or(Ok(()), |channel| sound(signal, channel))?;
        }
        let usable_pv = recording.pv.as_ref().filter(|pv| pv.usable_share() > 0.0);
        let (reference, signal) = match usable_pv {
            Some(pv) => (pv, "PV"),
            None => (&recording.op, "OP"),
        };
        if recording.pv.is_some() && usable_pv.is_none() {
            repairs.push(GridRepair {
                kind: RepairKind::Gap,
                signal: "PV",
                count: recording.pv.as_ref().map_or(0, |pv| pv.values.len()),
                first_s: recording.op.time.first().copied().unwrap_or(0.0),
                done: "no sample of the PV is usable; only the OP is kept".to_owned(),
            });
        }
        let track = Track::of;
        let has_samples = reference.quality.iter().any(|quality| *quality != Quality::Missing);
        let reference = track(reference, signal, repairs);
        let step = match (options.sample_time, reference.step.filter(|_| has_samples)) {
            (Some(given), _) => crate::error::positive("the sample time", given)?,
            (None, Some(found)) => found,
            (None, None) => {
                let found = reference.time.len();
                return Err(Error::Length { name: signal, found, expected: found.max(1) + 1 });
            }
        };
        let (op, pv) = if signal == "PV" {
            (track(&recording.op, "OP", repairs), Some(reference))
        } else {
            (reference, None)
        };
        // Of a PV whose changes are rare, the OP may show the sample time.
        let step = match (&pv, op.step) {
            (Some(pv), Some(finer))
                if options.sample_time.is_none() && pv.on_change && is_multiple(step, finer) =>
            {
                finer
            }
            _ => step,
        };
        let mut optional = |channel: &Option<Channel>, signal| {
            let channel = channel.as_ref().filter(|channel| channel.usable_share() > 0.0)?;
            Some(track(channel, signal, repairs))
        };
        let (vp, sp) = (optional(&recording.vp, "VP"), optional(&recording.sp, "SP"));
        let modes = recording.mode.as_ref().map(ordered);

        Ok(Self { step, op, pv, vp, sp, modes })
    }

    /// The signal whose samples show where the recording is complete.
    fn reference(&self) -> (&'static str, &Track) {
        self.pv.as_ref().map_or(("OP", &self.op), |pv| ("PV", pv))
    }

    /// The segments of a run: its known parts in automatic.
    fn segments(&self, run: &Run, recording: &Recording, log: &mut Log) -> Vec<Segment> {
        let step = self.step;
        let on = |track: &Track, rule| track.resample(run, step, rule);
        let op = on(&self.op, Interpolation::Hold);
        let pv = self.pv.as_ref().map(|pv| on(pv, Interpolation::Linear));
        let vp = self.vp.as_ref().map(|vp| on(vp, Interpolation::Linear));
        let sp = self.sp.as_ref().map(|sp| sp.held(run, step));
        let closed = closed(self.modes.as_ref(), run, step);
        let known = |k: usize| {
            op.state[k] != State::Unknown
                && pv.as_ref().is_none_or(|pv| pv.state[k] != State::Unknown)
        };
        log.signal("PV", pv.as_ref(), run, step);
        log.signal("OP", Some(&op), run, step);
        log.signal("VP", vp.as_ref(), run, step);
        log.not_closed(&closed, run, step);
        let (mut segments, mut k) = (vec![], 0);
        while k < run.points {
            let from = k;
            while k < run.points && closed[k] && known(k) {
                k += 1;
            }
            if k >= from + 2 {
                let mut segment = Segment {
                    from: run.from + from as f64 * step,
                    sample_time: step,
                    op: percent(&op.values[from..k], recording.op.range),
                    pv: pv.as_ref().map(|pv| pv.values[from..k].to_vec()),
                    sp: sp.as_ref().map(|sp| sp[from..k].to_vec()),
                    vp: vp.as_ref().filter(|vp| vp.known_share(from..k) >= LEAST_KNOWN_VP).map(
                        |vp| {
                            let range = recording.vp.as_ref().and_then(|vp| vp.range);
                            percent(&vp.filled(from..k), range)
                        },
                    ),
                    bridged: 0,
                };
                let missing = |track: &Track, on_grid: &Resampled| -> Vec<bool> {
                    let is_bridged = |state: &State| *state == State::Bridged;
                    on_grid.state[from..k]
                        .iter()
                        .map(|s| is_bridged(s) && !track.on_change)
                        .collect()
                };
                segment.bridge(
                    &missing(&self.op, &op),
                    &self
                        .pv
                        .as_ref()
                        .zip(pv.as_ref())
                        .map_or(vec![], |(track, pv)| missing(track, pv)),
                );
                segment.bridged = (from..k)
                    .filter(|&k| {
                        op.state[k] == State::Bridged
                            || pv.as_ref().is_some_and(|pv| pv.state[k] == State::Bridged)
                    })
                    .count();
                segments.push(segment);
            }
            k = k.max(from + 1);
        }
        segments
    }
}

/// The recording with its runs separated, if its clock begins again. A reader of files has done that already.
fn separated(recording: &Recording, repairs: &mut Vec<GridRepair>) -> Option<Recording> {
    let channels = [Some(&recording.op), recording.pv.as_ref()].into_iter().flatten();
    let is_whole = |each: &Channel| each.time.len() == each.values.len();
    if !channels.clone().all(is_whole) || channels.clone().all(|each| each.time.is_sorted()) {
        return None;
    }
    let mut moved = recording.clone();
    let runs = moved.separate_runs(&[&[]; 5]);
    let (first, last) = (runs.restarts.first()?, runs.restarts.last()?);
    repairs.push(GridRepair {
        kind: RepairKind::ClockStep,
        signal: "time",
        count: runs.restarts.len(),
        first_s: first.after,
        done: format!(
            "the clock went back; rows stay in the order of the file, and later times are moved by up to {} s",
            last.moved
        ),
    });
    Some(moved)
}

/// When the controller was in command, in order of time.
fn ordered(modes: &Modes) -> Vec<(f64, bool)> {
    let closed = modes.modes.iter().map(|mode| mode.is_closed());
    let mut ordered: Vec<(f64, bool)> = modes.time.iter().copied().zip(closed).collect();
    ordered.sort_by(|a, b| a.0.total_cmp(&b.0));
    ordered
}

/// Channels have public fields, so the conditions of their constructors are checked again.
fn sound(signal: &'static str, channel: &Channel) -> Result<()> {
    let expected = channel.values.len();
    for found in [channel.time.len(), channel.quality.len()] {
        if found != expected {
            return Err(Error::Length { name: signal, found, expected });
        }
    }
    crate::error::all_finite("the times", &channel.time)?;
    let usable = channel.values.iter().zip(&channel.quality);
    match usable.into_iter().position(|(v, q)| q.is_usable() && !v.is_finite()) {
        Some(index) => Err(Error::NonFinite { signal, index, value: channel.values[index] }),
        None => Ok(()),
    }
}

/// Position of a signal in the list of repairs.
fn rank(signal: &str) -> usize {
    ["PV", "OP", "VP", "SP"].iter().position(|s| *s == signal).unwrap_or(4)
}

fn percent(values: &[f64], range: Option<Range>) -> Vec<f64> {
    match range {
        Some(range) => values.iter().map(|v| range.percent(*v)).collect(),
        None => values.to_vec(),
    }
}

/// Whether the controller was in command at each point.
fn closed(modes: Option<&Vec<(f64, bool)>>, run: &Run, step: f64) -> Vec<bool> {
    let Some((modes, &first)) = modes.and_then(|modes| Some((modes, modes.first()?))) else {
        return vec![true; run.points];
    };
    let (mut next, mut closed) = (0, first.1);
    let points = (0..run.points).map(|k| {
        let t = run.from + (k as f64 + SAME) * step;
        while next < modes.len() && modes[next].0 <= t {
            closed = modes[next].1;
            next += 1;
        }
        closed
    });
    points.collect()
}

/// Share of the time from `first` to `last` in which the controller was in command.
fn closed_share(modes: Option<&Vec<(f64, bool)>>, first: f64, last: f64) -> f64 {
    let Some((modes, start)) = modes.and_then(|modes| Some((modes, modes.first()?))) else {
        return 1.0;
    };
    if last <= first {
        return f64::from(u8::from(start.1));
    }
    // The time in other modes, so that none gives exactly 1.
    let (mut from, mut closed, mut open) = (first, start.1, 0.0);
    for &(t, next) in modes.iter().chain([&(last, false)]) {
        let t = t.clamp(first, last);
        if !closed {
            open += t - from;
        }
        (from, closed) = (t, next);
    }
    (1.0 - open / (last - first)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::{Columns, LoopType, Mode, Modes, PlantTime, RangeSource};
    use super::*;

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|k| 50.0 + 7.0 * (k as f64 * 0.1).sin() + (k * k % 17) as f64 * 0.013).collect()
    }

    fn recording(times: &[f64], op: &[f64], pv: &[f64]) -> Recording {
        Recording {
            name: "FIC1".to_owned(),
            loop_type: LoopType::Flow,
            start: None,
            plant_time: PlantTime::default(),
            columns: Columns::default(),
            op: Channel::new("OP", times.to_vec(), op.to_vec()).unwrap(),
            pv: Some(Channel::new("PV", times.to_vec(), pv.to_vec()).unwrap()),
            sp: None,
            vp: None,
            mode: None,
            notes: vec![],
        }
    }

    fn grid(recording: &Recording) -> Grid {
        Grid::of(recording, &GridOptions::default()).unwrap()
    }

    fn kinds(grid: &Grid) -> Vec<(RepairKind, &'static str, usize)> {
        grid.repairs.iter().map(|r| (r.kind, r.signal, r.count)).collect()
    }

    #[test]
    fn regular_samples_pass_to_the_bit() {
        let (op, pv) = (wave(3000), wave(3001)[1..].to_vec());
        for (step, origin) in
            [(1.0, 0.0), (0.1, 100.0), (1.0 / 3.0, -7.0), (0.1, 1.7e9), (60.0, 0.3)]
        {
            let times: Vec<f64> = (0..op.len()).map(|k| origin + k as f64 * step).collect();
            let grid = grid(&recording(&times, &op, &pv));
            assert!((grid.sample_time / step - 1.0).abs() < 1e-9, "{step} {}", grid.sample_time);
            assert_eq!(kinds(&grid), []);
            assert_eq!(grid.segments.len(), 1);
            assert_eq!(grid.segments[0].op, op);
            assert_eq!(grid.segments[0].pv.as_ref().unwrap(), &pv);
            assert_eq!((grid.closed_share, grid.segments[0].from), (1.0, origin));
        }
        // Written with few digits, the sample time is what was meant.
        let times: Vec<f64> = (0..op.len()).map(|k| 100.0 + k as f64 * 0.1).collect();
        assert_eq!(grid(&recording(&times, &op, &pv)).sample_time, 0.1);
    }

    #[test]
    fn shuffled_rows_give_the_same_grid() {
        let n = 500;
        let (op, pv) = (wave(n), wave(n + 3)[3..].to_vec());
        let times: Vec<f64> = (0..n).map(|k| 2.0 * k as f64).collect();
        let expected = grid(&recording(&times, &op, &pv));
        let orders: [Vec<usize>; 4] = [
            (0..n).rev().collect(),
            // 7 and 500 have no common factor.
            (0..n).map(|k| k * 7 % n).collect(),
            (250..n).chain(0..250).collect(),
            [1, 0].into_iter().chain(2..n).collect(),
        ];
        for order in orders {
            let pick = |x: &[f64]| order.iter().map(|&i| x[i]).collect::<Vec<_>>();
            let found = grid(&recording(&pick(&times), &pick(&op), &pick(&pv)));
            assert_eq!(found.segments, expected.segments);
            assert!(found.repairs.iter().all(|r| r.kind == RepairKind::OutOfOrder));
            assert_eq!(found.repairs.len(), 2);
        }
    }

    #[test]
    fn the_clock_goes_back_an_hour_and_nothing_is_lost() {
        let n = 4000;
        let (op, pv) = (wave(n), wave(n + 1)[1..].to_vec());
        let times: Vec<f64> =
            (0..n).map(|k| 10.0 * k as f64 - if k < 2000 { 0.0 } else { 3600.0 }).collect();
        let found = grid(&recording(&times, &op, &pv));
        assert_eq!(kinds(&found), [(RepairKind::ClockStep, "time", 1)]);
        assert!(found.repairs[0].done.contains("3600 s"), "{}", found.repairs[0].done);
        assert_eq!((found.segments.len(), &found.segments[0].op), (1, &op));
        // In spring there is an hour that never was: a gap.
        let times: Vec<f64> =
            (0..n).map(|k| 10.0 * k as f64 + if k < 2000 { 0.0 } else { 3600.0 }).collect();
        let found = grid(&recording(&times, &op, &pv));
        assert_eq!(kinds(&found), [(RepairKind::Gap, "PV", 360)]);
        assert_eq!(found.segments.iter().map(Segment::len).collect::<Vec<_>>(), [2000, 2000]);
    }

    #[test]
    fn duplicates_are_dropped_and_the_last_in_the_file_counts() {
        let (op, pv) = (wave(100), wave(100));
        let mut times: Vec<f64> = (0..100).map(f64::from).collect();
        let expected = grid(&recording(&times, &op, &pv));
        let (mut op2, mut pv2) = (op.clone(), pv.clone());
        for (at, value) in [(50, op[50]), (70, -1.0)] {
            times.insert(at, times[at]);
            op2.insert(at, value);
            pv2.insert(at, pv2[at]);
        }
        // The row at 70 was inserted before the one that is kept.
        let found = grid(&recording(&times, &op2, &pv2));
        assert_eq!(found.segments[0].pv, expected.segments[0].pv);
        assert!(found.repairs.iter().all(|r| r.kind == RepairKind::Duplicate));
        let told = kinds(&found);
        assert!(told.contains(&(RepairKind::Duplicate, "PV", 2)), "{told:?}");
        assert!(told.contains(&(RepairKind::Duplicate, "OP", 1)), "{told:?}");
    }

    #[test]
    fn short_gaps_are_bridged_and_long_ones_cut() {
        let n = 200;
        let times: Vec<f64> = (0..n).map(|k| k as f64).collect();
        let op: Vec<f64> = (0..n).map(|k| k as f64).collect();
        let mut with_holes = op.clone();
        with_holes[50..53].fill(f64::NAN);
        with_holes[100..104].fill(f64::NAN);
        let pv = wave(n);
        let found = grid(&recording(&times, &with_holes, &pv));
        assert_eq!(kinds(&found), [(RepairKind::Bridged, "OP", 3), (RepairKind::Gap, "OP", 4)]);
        assert_eq!(found.segments.len(), 2);
        // The ramp goes on in both.
        let errors = found.segments[0].op[49..54].iter().zip([49.0, 50.0, 51.0, 52.0, 53.0]);
        assert!(errors.map(|(found, right)| (found - right).abs()).fold(0.0, f64::max) < 0.01);
        assert_eq!((found.segments[0].bridged, found.segments[1].bridged), (3, 0));
        assert_eq!((found.segments[0].len(), found.segments[1].from), (100, 104.0));
        let found = grid(&recording(&times, &pv, &with_holes));
        assert_eq!(found.segments[0].pv.as_ref().unwrap()[49..54], [49.0, 50.0, 51.0, 52.0, 53.0]);
        // Rows that are not there are as missing as rows without a value.
        let keep: Vec<usize> = (0..n).filter(|k| with_holes[*k].is_finite()).collect();
        let pick = |x: &[f64]| keep.iter().map(|&i| x[i]).collect::<Vec<_>>();
        let absent = grid(&recording(&pick(&times), &pick(&pv), &pick(&op)));
        assert_eq!(absent.segments.len(), 2);
        assert_eq!(absent.segments[0].pv, found.segments[0].pv);
    }

    #[test]
    fn modes_cut_and_count() {
        let n = 100;
        let times: Vec<f64> = (0..n).map(|k| k as f64).collect();
        let mut r = recording(&times, &wave(n), &wave(n));
        r.mode = Some(Modes {
            time: vec![0.0, 30.0, 50.0, 80.0],
            modes: vec![Mode::Automatic, Mode::Manual, Mode::Cascade, Mode::Other],
        });
        let found = grid(&r);
        let places: Vec<(f64, usize)> = found.segments.iter().map(|s| (s.from, s.len())).collect();
        assert_eq!(places, [(0.0, 30), (50.0, 30)]);
        assert!((found.closed_share - 60.0 / 99.0).abs() < 1e-12);
        assert_eq!(kinds(&found), [(RepairKind::NotAutomatic, "time", 40)]);
        r.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Manual] });
        assert!(grid(&r).segments.is_empty() && grid(&r).closed_share == 0.0);
        r.mode = Some(Modes::default());
        assert_eq!(grid(&r).closed_share, 1.0);
    }

    #[test]
    fn stored_on_change_holds_and_jitter_is_interpolated() {
        let n = 300;
        let times: Vec<f64> = (0..n).map(|k| k as f64).collect();
        let mut r = recording(&times, &wave(n), &times);
        let changes = vec![0.0, 3.0, 17.0, 40.0, 140.0, 141.5];
        let values = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        r.op = Channel::new("OP", changes.clone(), values.clone()).unwrap();
        r.sp = Some(Channel::new("SP", changes[1..].to_vec(), values[1..].to_vec()).unwrap());
        let found = grid(&r);
        let segment = &found.segments[0];
        assert_eq!((found.segments.len(), segment.len()), (1, n));
        let at = |k: usize| segment.op[k];
        assert_eq!(
            (at(2), at(3), at(139), at(141), at(142), at(299)),
            (1.0, 2.0, 4.0, 5.0, 6.0, 6.0)
        );
        let sp = segment.sp.as_ref().unwrap();
        assert_eq!((sp[0], sp[3], sp[200]), (2.0, 2.0, 6.0));
        // A wide table with a value only in rows where the OP changed says the same.
        let mut sparse = vec![f64::NAN; n];
        for (t, v) in [(0, 1.0), (3, 2.0), (17, 3.0), (40, 4.0), (140, 5.0)] {
            sparse[t] = v;
        }
        r.op = Channel::new("OP", times.clone(), sparse).unwrap();
        assert_eq!(grid(&r).segments[0].op[..141], segment.op[..141]);

        let jitter: Vec<f64> =
            (0..n).map(|k| k as f64 * 5.0 + 0.3 * ((k * 37 % 11) as f64 / 11.0 - 0.5)).collect();
        let r = recording(&jitter, &wave(n), &jitter);
        let found = grid(&r);
        assert!(found.sample_time == 5.0, "{}", found.sample_time);
        assert_eq!(found.segments.len(), 1);
        // A PV that is its own time is interpolated to the times of the grid.
        let segment = &found.segments[0];
        let times = segment.times();
        assert!(segment.pv.as_ref().unwrap().iter().zip(&times).all(|(p, t)| (p - t).abs() < 1e-9));
        assert!(found.repairs.iter().all(|r| r.kind == RepairKind::Irregular));
    }

    #[test]
    fn channels_of_other_sample_times() {
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        let mut r = recording(&times, &wave(100), &wave(100));
        let slow: Vec<f64> = (0..11).map(|k| 10.0 * f64::from(k)).collect();
        r.op = Channel::new("OP", slow.clone(), slow.clone()).unwrap();
        r.vp = Some(Channel::new("VP", slow.clone(), slow).unwrap());
        let found = grid(&r);
        assert_eq!((found.sample_time, found.segments.len()), (1.0, 1));
        assert_eq!(found.segments[0].op[17], 10.0);
        assert_eq!(found.segments[0].vp.as_ref().unwrap()[17], 17.0);
        let coarse = Grid::of(&r, &GridOptions { sample_time: Some(4.0) }).unwrap();
        assert_eq!(coarse.segments[0].pv.as_ref().unwrap()[5], wave(100)[20]);
        assert_eq!(coarse.segments[0].len(), 25);
    }

    #[test]
    fn ranges_and_missing_channels() {
        let times: Vec<f64> = (0..50).map(f64::from).collect();
        let mut r = recording(&times, &wave(50), &[f64::NAN; 50]);
        r.op.range = Some(Range::new(40.0, 60.0, RangeSource::Given).unwrap());
        let found = grid(&r);
        assert_eq!(found.segments[0].pv, None);
        assert_eq!(kinds(&found), [(RepairKind::Gap, "PV", 50)]);
        assert_eq!(found.segments[0].op[3], (wave(50)[3] - 40.0) / 20.0 * 100.0);
        let mut half: Vec<f64> = wave(50);
        half[..30].fill(f64::NAN);
        let mut r = recording(&times, &wave(50), &half);
        r.vp = Some(Channel::new("VP", times.clone(), half).unwrap());
        let found = grid(&r);
        assert_eq!((found.segments[0].from, found.segments[0].len()), (30.0, 20));
        assert!(found.segments[0].vp.is_some());
        assert!(found.repairs[0].done.contains("only 40 %"), "{}", found.repairs[0].done);
    }

    #[test]
    fn a_valve_position_with_a_hole_stays_if_little_is_missing() {
        let times: Vec<f64> = (0..200).map(f64::from).collect();
        let mut r = recording(&times, &wave(200), &wave(200));
        for (missing, kept) in [(0, true), (8, true), (30, false)] {
            let mut vp = times.clone();
            vp[50..50 + missing].fill(f64::NAN);
            r.vp = Some(Channel::new("VP", times.clone(), vp).unwrap());
            let found = grid(&r);
            assert_eq!((found.segments.len(), found.segments[0].len()), (1, 200));
            // What is kept is filled by straight lines.
            assert_eq!(found.segments[0].vp, kept.then(|| times.clone()));
        }
    }

    #[test]
    fn what_cannot_be_is_refused_and_little_is_enough() {
        let r = recording(&[0.0, 1.0, 2.0], &[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]);
        assert_eq!(grid(&r).segments[0].len(), 3);
        for sample_time in [0.0, -1.0, f64::NAN, 1e-12] {
            assert!(Grid::of(&r, &GridOptions { sample_time: Some(sample_time) }).is_err());
        }
        let one = recording(&[4.0], &[1.0], &[1.0]);
        assert!(Grid::of(&one, &GridOptions::default()).is_err());
        let still = recording(&[4.0; 9], &[1.0; 9], &[1.0; 9]);
        assert!(Grid::of(&still, &GridOptions::default()).is_err());
        let none = recording(&[0.0, 1.0], &[f64::NAN; 2], &[f64::NAN; 2]);
        assert!(Grid::of(&none, &GridOptions::default()).is_err());
        let mut broken = r.clone();
        broken.op.time.clear();
        assert!(Grid::of(&broken, &GridOptions::default()).is_err());
        let wild = recording(&[0.0, 1.0, 1e300], &[1.0; 3], &[1.0; 3]);
        assert!(Grid::of(&wild, &GridOptions::default()).is_ok());
    }

    proptest::proptest! {
        /// Whatever the times and values, every segment is whole and nothing panics.
        #[test]
        fn any_recording_gives_whole_segments(
            rows in proptest::collection::vec((-50i32..200, -1e3f64..1e3, 0u8..8), 2..120),
            scale in 1e-3f64..1e4,
        ) {
            let times: Vec<f64> = rows.iter().map(|row| f64::from(row.0) * scale).collect();
            let with = |hole: u8| -> Vec<f64> {
                rows.iter().map(|row| if row.2 == hole { f64::NAN } else { row.1 }).collect()
            };
            let mut r = recording(&times, &with(0), &with(1));
            r.sp = Some(Channel::new("SP", times.clone(), with(2)).unwrap());
            r.vp = Some(Channel::new("VP", times.clone(), with(3)).unwrap());
            r.mode = Some(Modes {
                time: times[..2].to_vec(),
                modes: vec![Mode::Automatic, Mode::Cascade],
            });
            if let Ok(grid) = Grid::of(&r, &GridOptions::default()) {
                for segment in &grid.segments {
                    proptest::prop_assert!(segment.len() >= 2);
                    let others = [&segment.pv, &segment.sp, &segment.vp].into_iter().flatten();
                    for signal in others.chain([&segment.op]) {
                        proptest::prop_assert_eq!(signal.len(), segment.len());
                        proptest::prop_assert!(signal.iter().all(|v| v.abs() <= 1e3));
                    }
                }
                proptest::prop_assert!(grid.closed_share == 1.0);
            }
        }
    }
}
