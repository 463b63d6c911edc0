//! A clock that begins again or falls back inside a recording: runs below each other that each begin at 0, a counter
//! that overflows, the end of summer time without a zone.
//!
//! The rows between two restarts are a *run*. Runs stay in the order of the file, and later times are moved. Where the
//! signals continue, one sample time passes at the restart. One sample time also passes between runs of many cycles, if
//! the signals stay in their range. Otherwise a gap follows that no bridge spans, so that the grid cuts there.
//!
//! Rows in disorder are not moved. A row is in disorder if the earlier rows leave a place for it: it repeats an earlier
//! time, or lies in a gap between earlier rows or outside of them. A row belongs to a new run if earlier rows already
//! fill its time. Rows of another phase lie between the rows before in both cases. Then the values decide whether the
//! rows fit their neighbours in the file or their neighbours in time.

use super::grid::commonest_step;
use super::{Channel, Recording};
use crate::series::mean;
use std::collections::BTreeMap;
use std::ops::Range;

/// The file rows of the samples of OP, PV, SP, VP and mode, in the order of the samples. A list of another length than
/// its channel means that the rows are unknown.
pub type Rows<'r> = [&'r [usize]; 5];

/// A place where the clock begins again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restart {
    /// File row of the first sample of the new run or, if the rows are unknown, its place in its channel.
    pub row: usize,
    /// The last time of the run before, on the clock of the file, s.
    pub before: f64,
    /// The first time of the new run, on the clock of the file, s.
    pub after: f64,
    /// The shift of the clock from here on, s.
    pub moved: f64,
    /// Whether the signals continue, so that one sample time passes. Otherwise a long gap does.
    pub joined: bool,
}

/// Rows that repeat the time of another row of their run with different values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Repeated {
    /// Their number.
    pub count: usize,
    /// The first such row, as in [`Restart::row`].
    pub first: usize,
}

/// The result of separating the runs of a recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Runs {
    /// The restarts, in order.
    pub restarts: Vec<Restart>,
    /// The rows whose times repeat within a run. Only counted if some rows are not in order of time.
    pub repeated: Repeated,
}

/// With fewer rows on average between two steps back, rows are in disorder.
const FEWEST_ROWS: usize = 4;

/// From this many backward steps on, rows that together have one regular clock may be shuffled.
const SHUFFLED: usize = 8;

/// Such rows are shuffled unless successive values differ more in order of time than in the order of the file. The
/// balance of both ranges from -1 to 1, and above this value the rows are runs. In noise alone it is near 0.
const SMOOTHER: f64 = 0.1;

/// The fewest rows in occupied times that show a restart. Fewer may be late.
const FEWEST_OCCUPIED: usize = 3;

/// With fewer rows in occupied times, their values decide nothing.
const FEWEST_JUDGED: usize = 8;

/// The share of equal rows that makes a block the repetition of an earlier one.
const REPETITION: f64 = 0.8;

/// The length of the gap between two runs, in sample times of the slowest signal. Longer than any bridge.
const APART: f64 = 10.0;

/// Signals continue if they do not jump by more than this many times the quantile of the steps between neighbours.
const JUMP: f64 = 2.0;
const QUANTILE: f64 = 0.99;

/// The share of the range of a run by which a value may lie outside.
const MARGIN: f64 = 0.1;

/// The fewest cycles of two runs together that may be joined although the signals jump, within their range.
const FEWEST_CYCLES: usize = 8;

impl Recording {
    /// Moves all times behind each place where the clock begins again; see the [module](self). The reference is the
    /// PV, or the OP if no sample of the PV is usable. Other channels follow it by their file rows.
    pub fn separate_runs(&mut self, rows: &Rows<'_>) -> Runs {
        let usable = |channel: &&Channel| channel.usable_share() > 0.0;
        let (place, reference) = match self.pv.as_ref().filter(usable) {
            Some(pv) => (1, pv),
            None => (0, &self.op),
        };
        let Some(order) = Order::of(&reference.time) else { return Runs::default() };
        // Signals that are sampled in the same rows are compared together.
        let beside = (place == 1 && self.op.time == reference.time).then_some(&*self.op.values);
        let values: Vec<&[f64]> = std::iter::once(&*reference.values).chain(beside).collect();
        let starts = order.starts(&reference.time, &values);
        let own_rows = (rows[place].len() == reference.time.len()).then_some(rows[place]);
        let row = |k: usize| own_rows.map_or(order.index(k), |rows| rows[order.index(k)]);
        if starts.is_empty() {
            let repeated = repeated(&reference.time, &values, &row, &order);
            return Runs { restarts: vec![], repeated };
        }
        let runs = Assigned {
            order,
            time: reference.time.clone(),
            rows: own_rows,
            spans: spans(&order, &reference.time, &starts),
            step: order.step(&reference.time),
            starts,
        };
        let of = |time: &[f64], values: &[&[f64]], rows: &[usize]| runs.of(time, values, rows);
        let channel = |each: Option<&Channel>, rows: &[usize]| {
            each.map(|each| of(&each.time, &[&each.values], rows)).unwrap_or_default()
        };
        let assigned = [
            channel(Some(&self.op), rows[0]),
            channel(self.pv.as_ref(), rows[1]),
            channel(self.sp.as_ref(), rows[2]),
            channel(self.vp.as_ref(), rows[3]),
            self.mode.as_ref().map(|mode| of(&mode.time, &[], rows[4])).unwrap_or_default(),
        ];

        let step = runs.step;
        let slowest = [Some(&self.op), self.pv.as_ref(), self.vp.as_ref()]
            .into_iter()
            .flatten()
            .filter_map(|each| Order::of(&each.time).map(|order| order.step(&each.time)))
            .fold(step, f64::max);
        let gap = step * (APART * slowest / step).ceil();
        let count = runs.spans.len();
        let joints = [(Some(&self.op), &assigned[0]), (self.pv.as_ref(), &assigned[1])]
            .map(|(channel, runs)| channel.and_then(|channel| Joints::of(channel, runs, count)));
        let continues = |run: usize| {
            let known = joints.iter().flatten().filter_map(|joints| joints.continues(run));
            known.clone().count() > 0 && known.clone().all(|continues| continues)
        };
        let mut restarts: Vec<Restart> = vec![];
        for (k, start) in runs.starts.iter().enumerate() {
            let ((_, before), (after, _)) = (runs.spans[k], runs.spans[k + 1]);
            let joined = continues(k + 1);
            let moved = restarts.last().map_or(0.0, |last| last.moved);
            let passes = if joined { step } else { gap };
            restarts.push(Restart {
                row: row(*start),
                before,
                after,
                moved: moved + before - after + passes,
                joined,
            });
        }
        let shift = |time: &mut Vec<f64>, runs: &[usize]| {
            for (t, run) in time.iter_mut().zip(runs) {
                *t += run.checked_sub(1).map_or(0.0, |k| restarts[k].moved);
            }
        };
        let [of_op, of_pv, of_sp, of_vp, of_mode] = &assigned;
        shift(&mut self.op.time, of_op);
        for (channel, runs) in [(&mut self.pv, of_pv), (&mut self.sp, of_sp), (&mut self.vp, of_vp)]
        {
            if let Some(channel) = channel {
                shift(&mut channel.time, runs);
            }
        }
        if let Some(mode) = &mut self.mode {
            shift(&mut mode.time, of_mode);
        }
        let reference = self.pv.as_ref().filter(|_| place == 1).unwrap_or(&self.op);
        let beside = (place == 1 && self.op.time == reference.time).then_some(&*self.op.values);
        let values: Vec<&[f64]> = std::iter::once(&*reference.values).chain(beside).collect();
        let repeated = repeated(&reference.time, &values, &row, &runs.order);
        Runs { restarts, repeated }
    }
}

/// The direction of rows: as in the file, or reversed if most steps go back.
#[derive(Debug, Clone, Copy)]
struct Order {
    count: usize,
    is_reversed: bool,
    /// Number of steps back.
    falls: usize,
}

impl Order {
    /// `None` if all times ascend.
    fn of(time: &[f64]) -> Option<Self> {
        let falls = time.windows(2).filter(|pair| pair[1] < pair[0]).count();
        if falls == 0 {
            return None;
        }
        let is_reversed = 2 * falls > time.len();
        let rises = || time.windows(2).filter(|pair| pair[1] > pair[0]).count();
        let falls = if is_reversed { rises() } else { falls };
        Some(Self { count: time.len(), is_reversed, falls })
    }

    /// The sample in place `k`.
    fn index(&self, k: usize) -> usize {
        if self.is_reversed { self.count - 1 - k } else { k }
    }

    /// The most frequent step of the longest stretch without a step back.
    fn step(&self, time: &[f64]) -> f64 {
        let ordered: Vec<f64> = (0..self.count).map(|k| time[self.index(k)]).collect();
        let longest = stretches(&ordered).max_by_key(|stretch| stretch.len()).unwrap_or(0..0);
        commonest_step(&ordered[longest]).map_or(1.0, |(step, _)| step)
    }

    /// The places where a new run begins.
    fn starts(&self, time: &[f64], values: &[&[f64]]) -> Vec<usize> {
        if self.falls == 0 || self.falls * FEWEST_ROWS > self.count {
            return vec![];
        }
        let ordered: Vec<f64> = (0..self.count).map(|k| time[self.index(k)]).collect();
        let step = self.step(time);
        let value = |channel: &[f64], k: usize| channel[self.index(k)];
        if self.falls >= SHUFFLED && is_shuffled(&ordered, values, &value) {
            return vec![];
        }
        let mut starts = vec![];
        let mut known: BTreeMap<i64, usize> = BTreeMap::new();
        for stretch in stretches(&ordered) {
            if Overlap::of(&stretch, &known, &ordered, values, &value, step).is_new_run() {
                starts.push(stretch.start);
                known.clear();
            }
            known.extend(stretch.map(|k| (key(ordered[k]), k)));
        }
        starts
    }
}

/// Whether all times together form one regular clock, each time once, and the values do not contradict this.
fn is_shuffled(time: &[f64], values: &[&[f64]], value: &impl Fn(&[f64], usize) -> f64) -> bool {
    let mut sorted: Vec<usize> = (0..time.len()).collect();
    sorted.sort_by(|a, b| time[*a].total_cmp(&time[*b]));
    let (first, last) = (time[sorted[0]], time[sorted[sorted.len() - 1]]);
    let spacing = (last - first) / (sorted.len() - 1) as f64;
    let step = |pair: &[usize]| time[pair[1]] - time[pair[0]];
    if !sorted.windows(2).all(|pair| (step(pair) - spacing).abs() <= 1e-3 * spacing) {
        return false;
    }
    let in_file: Vec<usize> = (0..time.len()).collect();
    let balance = values.iter().map(|channel| {
        let differ = |order: &[usize]| -> f64 {
            let steps = order.windows(2).map(|k| value(channel, k[1]) - value(channel, k[0]));
            steps.filter(|step| step.is_finite()).map(f64::abs).sum()
        };
        let (in_time, in_file) = (differ(&sorted), differ(&in_file));
        if in_time + in_file > 0.0 { (in_time - in_file) / (in_time + in_file) } else { 0.0 }
    });
    mean(&balance.collect::<Vec<_>>()) <= SMOOTHER
}

/// The longest stretches of rows without a step back.
fn stretches(time: &[f64]) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut from = 0;
    std::iter::from_fn(move || {
        let begin = from;
        from = (begin + 1..time.len()).find(|k| time[*k] < time[*k - 1]).unwrap_or(time.len());
        (begin < time.len()).then_some(begin..from)
    })
}

/// A key with the order of the times.
fn key(time: f64) -> i64 {
    // 0 and -0 are the same time.
    let bits = (time + 0.0).to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

/// The rows of a stretch beside the earlier rows of its run.
#[derive(Default)]
struct Overlap {
    /// Rows equal to an earlier one.
    equal: usize,
    /// Rows with the time of an earlier one but other values.
    differ: usize,
    /// Rows between two earlier ones that are a sample time apart.
    between: usize,
    /// Steps from such rows to the next row, and steps of an ordinary length.
    steps: usize,
    ordinary: usize,
    /// The balance of values: above 0 if they fit their neighbours in the file better than their neighbours in time.
    fits: f64,
}

impl Overlap {
    fn of(
        stretch: &Range<usize>,
        known: &BTreeMap<i64, usize>,
        time: &[f64],
        values: &[&[f64]],
        value: &impl Fn(&[f64], usize) -> f64,
        step: f64,
    ) -> Self {
        let mut found = Self::default();
        let mut misfit = vec![(0.0, 0.0); values.len()];
        let near = |a: usize, b: usize| time[b] - time[a] < 1.5 * step;
        for k in stretch.clone() {
            let at = key(time[k]);
            let below = known.range(..=at).next_back().map(|(_, k)| *k);
            let above = known.range(at..).next().map(|(_, k)| *k);
            let (Some(a), Some(b)) = (below, above) else { continue };
            if time[a] == time[b] {
                let same = |channel: &&[f64]| {
                    let (old, new) = (value(channel, a), value(channel, k));
                    old == new || (old.is_nan() && new.is_nan())
                };
                if values.iter().all(same) {
                    found.equal += 1;
                } else {
                    found.differ += 1;
                }
            } else if near(a, b) {
                found.between += 1;
                let own = k.checked_sub(1).filter(|p| *p >= stretch.start).zip(Some(k + 1));
                if let Some((p, q)) = own.filter(|(_, q)| *q < stretch.end) {
                    for (channel, misfit) in values.iter().zip(&mut misfit) {
                        let off = |a: usize, b: usize| {
                            let (low, high) = (value(channel, a), value(channel, b));
                            let share = (time[k] - time[a]) / (time[b] - time[a]);
                            (value(channel, k) - low - share * (high - low)).abs()
                        };
                        let (in_file, in_time) = (off(p, q), off(a, b));
                        if in_file.is_finite() && in_time.is_finite() {
                            *misfit = (misfit.0 + in_file, misfit.1 + in_time);
                        }
                    }
                }
            } else {
                continue;
            }
            if k + 1 < stretch.end {
                found.steps += 1;
                found.ordinary += usize::from(near(k, k + 1));
            }
        }
        let balance =
            misfit.into_iter().filter(|(a, b)| a + b > 0.0).map(|(a, b)| (b - a) / (a + b));
        found.fits = balance.sum();
        found
    }

    fn is_new_run(&self) -> bool {
        let occupied = self.equal + self.differ + self.between;
        if occupied < FEWEST_OCCUPIED || self.equal as f64 >= REPETITION * occupied as f64 {
            return false;
        }
        if occupied < FEWEST_JUDGED || self.differ >= self.between {
            return 2 * self.ordinary > self.steps;
        }
        self.fits > 0.0
    }
}

/// The first and last time of each run.
fn spans(order: &Order, time: &[f64], starts: &[usize]) -> Vec<(f64, f64)> {
    let begins = std::iter::once(0).chain(starts.iter().copied());
    let ends = starts.iter().copied().chain([order.count]);
    let span = |(begin, end): (usize, usize)| {
        let times = (begin..end).map(|k| time[order.index(k)]);
        times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)))
    };
    begins.zip(ends).map(span).collect()
}

/// The runs of the reference channel, by which other channels find theirs.
struct Assigned<'r> {
    order: Order,
    time: Vec<f64>,
    rows: Option<&'r [usize]>,
    starts: Vec<usize>,
    spans: Vec<(f64, f64)>,
    step: f64,
}

impl Assigned<'_> {
    /// The run of each sample of a channel.
    fn of(&self, time: &[f64], values: &[&[f64]], rows: &[usize]) -> Vec<usize> {
        let count = time.len();
        let order = Order { count, is_reversed: self.order.is_reversed, falls: 0 };
        let starts = if time == self.time {
            self.starts.clone()
        } else {
            self.by_rows(time, rows, &order).unwrap_or_else(|| self.by_times(time, values, &order))
        };
        let mut runs = vec![0; count];
        let (mut run, mut next) = (0, starts.iter().peekable());
        for k in 0..count {
            while next.next_if(|start| **start <= k).is_some() {
                run += 1;
            }
            runs[order.index(k)] = run;
        }
        runs
    }

    /// The starts of the runs of a channel, for a channel whose rows lie between the rows of the reference.
    fn by_rows(&self, time: &[f64], rows: &[usize], order: &Order) -> Option<Vec<usize>> {
        /// Maximum distance, in rows, between several tags of one time.
        const NEAR: usize = 16;
        let of_reference = self.rows.filter(|_| rows.len() == time.len())?;
        let (first, last) = (of_reference.first()?, of_reference.last()?);
        if rows.last()? < first || last < rows.first()? {
            return None;
        }
        let row = |k: usize| rows[order.index(k)];
        let is_before = |row: usize, than: usize| {
            if order.is_reversed { row > than } else { row < than }
        };
        let starts = self.starts.iter().enumerate().map(|(run, start)| {
            let at = of_reference[self.order.index(*start)];
            let (before, after) = (self.spans[run].1, self.spans[run + 1].0);
            let time = |k: usize| time[order.index(k)];
            // The samples of several tags at the restart may follow each other in any order.
            let is_near = |k: usize, end: f64, other: f64| {
                let off = (time(k) - end).abs();
                row(k).abs_diff(at) <= NEAR
                    && off < (time(k) - other).abs()
                    && off <= NEAR as f64 * self.step
            };
            let mut k = (0..order.count).take_while(|k| is_before(row(*k), at)).count();
            while k > 0 && is_near(k - 1, after, before) {
                k -= 1;
            }
            while k < order.count && is_near(k, before, after) {
                k += 1;
            }
            k
        });
        Some(starts.collect())
    }

    /// The starts of the runs of a channel with unknown rows, or with its rows before or behind all of the reference.
    fn by_times(&self, time: &[f64], values: &[&[f64]], order: &Order) -> Vec<usize> {
        let own = Order::of(time).map(|own| own.starts(time, values)).unwrap_or_default();
        if own.len() == self.starts.len() {
            return own;
        }
        // A channel stored on change may have one sample in a run, at its first time.
        let at = |k: usize| time[order.index(k)];
        let not_later = (1..order.count).filter(|k| at(*k) <= at(*k - 1));
        not_later.take(self.starts.len()).collect()
    }
}

/// The usable values of a signal in each run, in order of time.
struct Joints {
    runs: Vec<Vec<f64>>,
    /// A large step between neighbours.
    step: f64,
}

impl Joints {
    fn of(channel: &Channel, runs: &[usize], count: usize) -> Option<Self> {
        let mut samples: Vec<Vec<(f64, f64)>> = vec![vec![]; count];
        for (k, run) in runs.iter().enumerate().filter(|(k, _)| channel.quality[*k].is_usable()) {
            samples[*run].push((channel.time[k], channel.values[k]));
        }
        let by_time = |mut run: Vec<(f64, f64)>| {
            run.sort_by(|a, b| a.0.total_cmp(&b.0));
            run.into_iter().map(|(_, value)| value).collect::<Vec<f64>>()
        };
        let runs: Vec<Vec<f64>> = samples.into_iter().map(by_time).collect();
        let pairs = runs.iter().flat_map(|run| run.windows(2));
        let mut steps: Vec<f64> = pairs.map(|pair| (pair[1] - pair[0]).abs()).collect();
        let place = ((steps.len() as f64 * QUANTILE) as usize).min(steps.len().checked_sub(1)?);
        let step = *steps.select_nth_unstable_by(place, f64::total_cmp).1;
        Some(Self { runs, step })
    }

    /// Whether the signal continues from the previous run to this one: without an unusual jump, or within its range if
    /// both runs have so many cycles that one jump matters little. `None` without a value in either.
    fn continues(&self, run: usize) -> Option<bool> {
        let (before, after) = (&self.runs[run - 1], &self.runs[run]);
        let (last, first) = (before.last()?, after.first()?);
        let is_within = |value: &f64, run: &[f64]| {
            let low = run.iter().copied().fold(f64::INFINITY, f64::min);
            let high = run.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let margin = MARGIN * (high - low);
            (low - margin..=high + margin).contains(value)
        };
        Some(
            (first - last).abs() <= JUMP * self.step
                || is_within(first, before)
                    && is_within(last, after)
                    && cycles(before) + cycles(after) >= FEWEST_CYCLES,
        )
    }
}

/// The number of cycles about the mean, apart from noise.
fn cycles(values: &[f64]) -> usize {
    let mean = mean(values);
    let spread =
        (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len() as f64).sqrt();
    let (mut side, mut turns) = (0.0, 0);
    for value in values.iter().filter(|value| (**value - mean).abs() > 0.5 * spread) {
        let now = (value - mean).signum();
        turns += usize::from(now != side);
        side = now;
    }
    turns / 2
}

/// The rows with the time of another row but other values.
fn repeated(
    time: &[f64],
    values: &[&[f64]],
    row: &impl Fn(usize) -> usize,
    order: &Order,
) -> Repeated {
    let at = |k: usize| time[order.index(k)];
    let mut places: Vec<usize> = (0..order.count).collect();
    places.sort_by(|a, b| at(*a).total_cmp(&at(*b)));
    let differ = |a: usize, b: usize| {
        let differ = |channel: &&[f64]| {
            let (a, b) = (channel[order.index(a)], channel[order.index(b)]);
            a != b && a.is_finite() && b.is_finite()
        };
        values.iter().any(differ)
    };
    let same = places.windows(2).filter(|pair| at(pair[0]) == at(pair[1]));
    let rows = same.filter(|pair| differ(pair[0], pair[1])).map(|pair| row(pair[1]));
    let (count, first) =
        rows.fold((0, usize::MAX), |(count, first), row| (count + 1, first.min(row)));
    Repeated { count, first: if count == 0 { 0 } else { first } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Mode, Modes};

    fn wave(run: usize, k: usize) -> f64 {
        50.0 + 9.0 * (run % 2) as f64 + 7.0 * (k as f64 * 0.07 + run as f64 * 1.9).sin()
    }

    /// Runs of 100 samples of 1 s that begin at these times.
    fn recording(starts: &[f64]) -> Recording {
        let rows = starts
            .iter()
            .enumerate()
            .flat_map(|(run, start)| (0..100).map(move |k| (start + k as f64, wave(run, k))));
        let (time, pv): (Vec<f64>, Vec<f64>) = rows.unzip();
        let op: Vec<f64> = pv.iter().map(|v| 100.0 - v).collect();
        let mut made = Recording::regular("A", 1.0, &op, Some(&pv), None).unwrap();
        made.op.time.clone_from(&time);
        made.pv.as_mut().unwrap().time = time;
        made
    }

    #[test]
    fn channels_with_other_times_follow_by_their_own_restarts() {
        let mut made = recording(&[0.0, 0.3, 0.6]);
        let modes = vec![Mode::Automatic, Mode::Manual, Mode::Automatic];
        made.mode = Some(Modes { time: vec![0.0, 0.0, 0.0], modes });
        let runs = made.separate_runs(&[&[]; 5]);
        let rows: Vec<usize> = runs.restarts.iter().map(|each| each.row).collect();
        assert_eq!(rows, [100, 200]);
        assert_eq!(runs.repeated, Repeated::default());
        assert!(made.op.time.is_sorted_by(|a, b| a < b));
        let begins = |run: usize| made.op.time[100 * run];
        let mode = &made.mode.as_ref().unwrap().time;
        assert!((mode[1] - begins(1)).abs() < 1.0 && (mode[2] - begins(2)).abs() < 1.0, "{mode:?}");
    }

    /// Together their times are those of one regular clock, as of shuffled rows.
    #[test]
    fn runs_whose_phases_are_evenly_spaced_are_separated() {
        let starts: Vec<f64> = (0..10).map(|run| 0.1 * f64::from(run)).collect();
        let mut moved = recording(&starts);
        let values = moved.op.values.clone();
        assert_eq!(moved.separate_runs(&[&[]; 5]).restarts.len(), 9);
        assert!(moved.op.time.is_sorted() && moved.op.values == values);
    }

    #[test]
    fn signals_that_continue_are_joined() {
        let mut made = recording(&[0.0]);
        for channel in [Some(&mut made.op), made.pv.as_mut()].into_iter().flatten() {
            channel.time.iter_mut().skip(60).for_each(|t| *t -= 40.0);
        }
        let runs = made.separate_runs(&[&[]; 5]);
        let expected = Restart { row: 60, before: 59.0, after: 20.0, moved: 40.0, joined: true };
        assert_eq!(runs.restarts, [expected]);
        assert_eq!(made.op.time, (0..100).map(f64::from).collect::<Vec<_>>());
    }

    #[test]
    fn times_that_repeat_are_counted() {
        let mut made = recording(&[0.0, 0.0]);
        for channel in [Some(&mut made.op), made.pv.as_mut()].into_iter().flatten() {
            for (k, t) in channel.time.iter_mut().enumerate() {
                *t = f64::from(k as u32 % 2);
            }
        }
        let runs = made.separate_runs(&[&[]; 5]);
        assert!(runs.restarts.is_empty());
        assert!(runs.repeated.count > 100, "{:?}", runs.repeated);
    }
}
