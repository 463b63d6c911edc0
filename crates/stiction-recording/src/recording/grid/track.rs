//! One channel in order of time, and its values between samples.

use super::clock::tolerance;
use super::repair::{GridRepair, RepairKind};
use super::{Interpolation, LONGEST_BRIDGE};
use crate::error::{Error, Result};
use crate::recording::rhythm::{Rhythm, are_other_rows};
use crate::recording::{Channel, Quality};

/// The most points of a grid, so that one wrong time stamp does not fill the memory.
const MOST_POINTS: f64 = 2e7;

/// Part of the grid without a long gap in the reference channel; it begins at a sample.
pub(super) struct Run {
    pub from: f64,
    pub to: f64,
    pub points: usize,
}

/// One channel, in order of time.
pub(super) struct Track {
    pub time: Vec<f64>,
    value: Vec<f64>,
    usable: Vec<bool>,
    /// Most frequent step of the channel.
    pub step: Option<f64>,
    pub on_change: bool,
    /// The longest time for which a stored value holds, s.
    longest_hold: f64,
}

impl Track {
    pub(super) fn of(
        channel: &Channel,
        signal: &'static str,
        repairs: &mut Vec<GridRepair>,
    ) -> Self {
        let time = &channel.time;
        let mut repair = |kind, count, first_s, done: &str| {
            if count > 0 {
                repairs.push(GridRepair { kind, signal, count, first_s, done: done.to_owned() });
            }
        };
        let is_empty = |i: usize| channel.quality[i] == Quality::Missing;
        let empty: Vec<bool> = (0..time.len()).map(is_empty).collect();
        let are_other_rows = are_other_rows(time, &channel.values, &empty);
        let mut order: Vec<usize> =
            (0..time.len()).filter(|&i| !(are_other_rows && is_empty(i))).collect();
        let mut back = (1..time.len()).filter(|&i| time[i] < time[i - 1]);
        if let Some(first) = back.next() {
            let count = 1 + back.count();
            repair(RepairKind::OutOfOrder, count, time[first], "sorted by time");
            order.sort_by(|a, b| time[*a].total_cmp(&time[*b]));
        }
        let mut track = Self {
            time: Vec::with_capacity(order.len()),
            value: Vec::with_capacity(order.len()),
            usable: Vec::with_capacity(order.len()),
            step: None,
            // A single sample holds.
            on_change: true,
            longest_hold: f64::INFINITY,
        };
        let (mut equal, mut different, mut first_equal, mut first_different) = (0, 0, 0.0, 0.0);
        for i in order {
            let (t, v, usable) = (time[i], channel.values[i], channel.quality[i].is_usable());
            let last = track.time.len().wrapping_sub(1);
            if track.time.last() != Some(&t) {
                track.time.push(t);
                track.value.push(v);
                track.usable.push(usable);
                continue;
            }
            if usable && track.usable[last] && track.value[last] != v {
                if different == 0 {
                    first_different = t;
                }
                different += 1;
            } else {
                if equal == 0 {
                    first_equal = t;
                }
                equal += 1;
            }
            if usable {
                (track.value[last], track.usable[last]) = (v, true);
            }
        }
        repair(RepairKind::Duplicate, equal, first_equal, "repeated samples were dropped");
        repair(
            RepairKind::Duplicate,
            different,
            first_different,
            "where values at the same time differ, the last value in the file was used",
        );
        if let Some(rhythm) = Rhythm::of(&track.time, &track.value) {
            (track.step, track.on_change) = (Some(rhythm.step), rhythm.on_change);
            track.longest_hold = rhythm.longest_hold;
        }
        track
    }

    pub(super) fn first(&self) -> f64 {
        self.time.first().copied().unwrap_or(0.0)
    }

    pub(super) fn last(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// The longest distance of two samples that can be bridged.
    fn bridge(&self) -> f64 {
        (LONGEST_BRIDGE as f64 + 1.5) * self.step.unwrap_or(f64::INFINITY)
    }

    /// Whether it has samples between two times.
    fn has_between(&self, from: f64, to: f64) -> bool {
        let next = self.time.partition_point(|t| *t <= from);
        self.time.get(next).is_some_and(|t| *t < to)
    }

    /// The parts without a long gap. While `other` continues, a value of a channel stored on change is held.
    pub(super) fn runs(&self, step: f64, other: Option<&Self>) -> Result<Vec<Run>> {
        let bridge = self.bridge();
        let (mut runs, mut from, mut points) = (vec![], 0, 0.0);
        for i in 1..=self.time.len() {
            let is_gap = |from: f64, to: f64| match (self.on_change, other) {
                (false, _) => to - from >= bridge,
                (true, Some(other)) => {
                    to - from >= self.longest_hold && !other.has_between(from, to)
                }
                (true, None) => false,
            };
            let ends = i == self.time.len() || is_gap(self.time[i - 1], self.time[i]);
            if !ends {
                continue;
            }
            let (begin, end) = (self.time[from], self.time[i - 1]);
            let steps = ((end - begin + tolerance(step, begin, end)) / step).floor();
            points += steps + 1.0;
            if points > MOST_POINTS {
                return Err(Error::Inconsistent(format!(
                    "a grid of {step} s from {} s to {} s has more than {MOST_POINTS} points; use a longer sample \
                     time, or correct the time stamps",
                    self.first(),
                    self.last()
                )));
            }
            runs.push(Run { from: begin, to: end, points: steps as usize + 1 });
            from = i;
        }
        Ok(runs)
    }

    pub(super) fn resample(&self, run: &Run, step: f64, rule: Interpolation) -> Resampled {
        let n = run.points;
        let mut out = Resampled { values: vec![0.0; n], state: vec![State::Unknown; n] };
        let tolerance = tolerance(step, run.from, run.to);
        let (own, bridge) = (self.step.unwrap_or(f64::INFINITY), self.bridge());
        let rule = if self.on_change { Interpolation::Hold } else { rule };
        // The next sample beyond the point, and the last usable one up to it.
        let mut next = self.usable_up_to(run.from + tolerance);
        let mut before: Option<usize> = None;
        // The usable sample from `next` on.
        let mut after = next;
        for k in 0..n {
            let t = run.from + k as f64 * step;
            let mut newest = None;
            while next < self.time.len() && self.time[next] <= t + tolerance {
                newest = Some(next);
                if self.usable[next] {
                    before = Some(next);
                }
                next += 1;
            }
            let Some(p) = before else { continue };
            if newest == Some(p) && (self.time[p] - t).abs() <= tolerance {
                (out.values[k], out.state[k]) = (self.value[p], State::Sample);
                continue;
            }
            let was_bad = next > p + 1;
            if self.on_change && !was_bad {
                (out.values[k], out.state[k]) = (self.value[p], State::Between);
                continue;
            }
            after = after.max(next);
            while after < self.time.len() && !self.usable[after] {
                after += 1;
            }
            let q = (after < self.time.len()).then_some(after);
            let gap = q.map_or(f64::INFINITY, |q| self.time[q] - self.time[p]);
            let limit = if rule == Interpolation::Hold && q.is_none() {
                // After the last sample, a held value is valid for one step.
                t - self.time[p]
            } else {
                gap
            };
            out.state[k] = if limit <= 1.5 * own {
                State::Between
            } else if limit < bridge {
                State::Bridged
            } else {
                continue;
            };
            out.values[k] = match (rule, q) {
                (Interpolation::Linear, Some(q)) => {
                    let share = (t - self.time[p]) / gap;
                    self.value[p] + share * (self.value[q] - self.value[p])
                }
                _ => self.value[p],
            };
        }
        out
    }

    /// The last usable sample up to a time, or the first of all.
    fn usable_up_to(&self, time: f64) -> usize {
        let end = self.time.partition_point(|t| *t <= time);
        (0..end).rev().find(|&i| self.usable[i]).unwrap_or(0)
    }

    /// Every point, with the last usable sample held over missing ones. The first usable sample also counts before its
    /// time.
    pub(super) fn held(&self, run: &Run, step: f64) -> Vec<f64> {
        let tolerance = tolerance(step, run.from, run.to);
        let usable = |i: &usize| self.usable[*i];
        let Some(first) = (0..self.time.len()).find(usable) else {
            return vec![f64::NAN; run.points];
        };
        let (mut value, mut next) = (self.value[first], self.usable_up_to(run.from + tolerance));
        let points = (0..run.points).map(|k| {
            let t = run.from + k as f64 * step + tolerance;
            while next < self.time.len() && self.time[next] <= t {
                if self.usable[next] {
                    value = self.value[next];
                }
                next += 1;
            }
            value
        });
        points.collect()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// At a sample.
    Sample,
    /// Between two consecutive samples.
    Between,
    /// Within a few missing samples.
    Bridged,
    /// Unknown.
    Unknown,
}

pub(super) struct Resampled {
    pub values: Vec<f64>,
    pub state: Vec<State>,
}

impl Resampled {
    pub(super) fn known_share(&self, points: std::ops::Range<usize>) -> f64 {
        let known = self.state[points.clone()].iter().filter(|s| **s != State::Unknown).count();
        known as f64 / points.len().max(1) as f64
    }

    /// The values, with straight lines over unknown ones and held ends.
    pub(super) fn filled(&self, points: std::ops::Range<usize>) -> Vec<f64> {
        let mut values = self.values[points.clone()].to_vec();
        let known: Vec<usize> =
            (0..values.len()).filter(|k| self.state[points.start + k] != State::Unknown).collect();
        let (Some(&first), Some(&last)) = (known.first(), known.last()) else { return values };
        for pair in known.windows(2) {
            let (p, q) = (pair[0], pair[1]);
            for k in p + 1..q {
                let share = (k - p) as f64 / (q - p) as f64;
                values[k] = values[p] + share * (values[q] - values[p]);
            }
        }
        let (low, high) = (values[first], values[last]);
        values[..first].fill(low);
        values[last..].fill(high);
        values
    }
}
