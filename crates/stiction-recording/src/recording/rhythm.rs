//! The rhythm of a channel: the times at which it is sampled, and whether only its changes are stored.
//!
//! Two facts decide, and neither needs another channel:
//!
//! * **Stored on change.** The steps between samples are mostly of different lengths. Or most steps have one length,
//!   but no small change is ever stored. In a signal that is sampled regularly, changes close to zero are at least as
//!   frequent as larger changes. If the smallest stored change is frequent, and smaller ones do not occur, the recorder
//!   left them out. The value between such samples is the last one.
//! * **Rows of other channels.** In a table with a column for each channel, a row may be a sample of some channels
//!   only. The cells of the other channels are then empty. If a channel has a longer step than the rows of the table,
//!   or is stored on change, its empty cells are not missing samples.

use super::grid::commonest_step;

/// Smallest share of steps with the most frequent length; with fewer, a channel counts as stored on change.
const REGULAR_SHARE: f64 = 0.5;

/// The fewest steps longer than one sample time by which storing on change can be seen.
const FEWEST_HOLDS: usize = 5;

/// The fewest smallest changes by which storing on change can be seen.
const FEWEST_SMALLEST: usize = 12;

/// The fewest samples that show a rhythm, if not most cells are empty.
const FEWEST_SAMPLES: usize = 8;

/// The shortest time without a sample that can be a gap in a channel stored on change, in sample times.
const SHORTEST_GAP: f64 = 30.0;

/// The rhythm of samples in order of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rhythm {
    /// The most frequent time between samples, s; of changes, the time of which the times between them are multiples.
    pub step: f64,
    /// Whether only changes are stored, so that the last value holds.
    pub on_change: bool,
    /// The longest time for which a stored value can hold, s. A longer one is a gap.
    pub longest_hold: f64,
}

impl Rhythm {
    /// The rhythm of samples at ascending times; a value that is not finite is not compared. `None` if there are not
    /// two different times.
    pub fn of(time: &[f64], values: &[f64]) -> Option<Self> {
        let (mut step, share) = commonest_step(time)?;
        let on_change = share < REGULAR_SHARE || leaves_out_small_changes(time, values, step);
        if on_change && let Some(shortest) = common_divisor(time) {
            // Changes that are rare follow each other at many multiples of the sample time.
            step = if shortest < 0.75 * step { shortest } else { step };
        }
        Some(Self { step, on_change, longest_hold: longest_hold(time, step) })
    }
}

/// Whether changes below a smallest one are left out, and longer steps do not bring larger changes.
fn leaves_out_small_changes(time: &[f64], values: &[f64], step: f64) -> bool {
    let (mut next, mut held) = (vec![], vec![]);
    for (t, v) in time.windows(2).zip(values.windows(2)) {
        let (steps, change) = ((t[1] - t[0]) / step, (v[1] - v[0]).abs());
        match steps {
            _ if !change.is_finite() => {}
            0.5..1.5 => next.push(change),
            1.5.. => held.push(change),
            _ => {}
        }
    }
    if held.len() < FEWEST_HOLDS || next.len() < FEWEST_SMALLEST {
        return false;
    }
    next.sort_by(f64::total_cmp);
    held.sort_by(f64::total_cmp);
    // A few samples may be stored for another reason.
    let smallest = next[next.len() / 50];
    let below = next.partition_point(|change| *change < 0.999 * smallest);
    let near = next.partition_point(|change| *change < 1.999 * smallest) - below;
    let median = |sorted: &[f64]| sorted[sorted.len() / 2];
    // Lost samples of a steady slope have no small changes either, but their changes are all alike, and larger where
    // samples are lost.
    let larger = next.len() - below - near;
    smallest > 0.0
        && near >= FEWEST_SMALLEST.max(5 * below)
        && (larger >= near || median(&held) <= 1.5 * median(&next))
}

/// The time of which nearly all steps are multiples, to nine digits; `None` if no such time exists.
fn common_divisor(time: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).filter(|step| *step > 0.0).collect();
    let shortest = steps.iter().copied().min_by(f64::total_cmp)?;
    let multiples: Vec<f64> =
        steps.iter().copied().filter(|step| is_multiple(*step, shortest)).collect();
    if (multiples.len() as f64) < 0.98 * steps.len() as f64 {
        return None;
    }
    // The mean over all steps, because a single one has few digits.
    let count: f64 = multiples.iter().map(|step| (step / shortest).round()).sum();
    format!("{:.8e}", multiples.iter().sum::<f64>() / count).parse().ok()
}

/// Whether a time is a multiple of a step, within a fiftieth of the step.
pub fn is_multiple(time: f64, step: f64) -> bool {
    let steps = time / step;
    steps > 0.5 && (steps - steps.round()).abs() < 0.02
}

/// The longest hold that is usual in a channel: three times the fifth longest hold, or ten times a hold that is longer
/// than 98 of 100.
fn longest_hold(time: &[f64], step: f64) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    steps.sort_by(|a, b| b.total_cmp(a));
    let longest = |place: usize| steps.get(place).or(steps.last()).copied().unwrap_or(0.0);
    (SHORTEST_GAP * step).max(3.0 * longest(4)).max(10.0 * longest(steps.len() / 50))
}

/// Whether the empty cells of a channel are no missing samples, but rows of other channels or without a change. All
/// rows of the table are given, in the order of the file.
pub fn are_other_rows(time: &[f64], values: &[f64], is_empty: &[bool]) -> bool {
    let empty = is_empty.iter().filter(|empty| **empty).count();
    let is_most = 2 * empty > time.len();
    if empty == 0 || empty == time.len() || (time.len() - empty < FEWEST_SAMPLES && !is_most) {
        return false;
    }
    let mut order: Vec<usize> = (0..time.len()).collect();
    if !time.is_sorted() {
        order.sort_by(|a, b| time[*a].total_cmp(&time[*b]));
    }
    let own: Vec<usize> = order.iter().copied().filter(|row| !is_empty[*row]).collect();
    let at = |rows: &[usize], x: &[f64]| rows.iter().map(|row| x[*row]).collect::<Vec<_>>();
    let times = at(&own, time);
    let Some(rhythm) = Rhythm::of(&times, &at(&own, values)) else {
        // A single sample among many rows holds.
        return is_most;
    };
    if rhythm.on_change {
        // Rows fill most of the time between the samples. Few empty cells would be lost samples.
        let points: f64 = times.windows(2).map(|t| (t[1] - t[0]) / rhythm.step - 1.0).sum();
        return empty as f64 >= 0.1 * points;
    }
    let rows = commonest_step(&at(&order, time));
    rows.is_some_and(|(step, _)| rhythm.step > 1.05 * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slow wave with a little noise, n samples.
    fn wave(n: usize) -> Vec<f64> {
        let noise = |k: usize| (k * 7919 % 1009) as f64 / 1009.0 - 0.5;
        (0..n).map(|k| 50.0 + 3.0 * (k as f64 * 0.12).sin() + 0.4 * noise(k)).collect()
    }

    fn changes(values: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut last = f64::NAN;
        let stored = values.iter().enumerate().filter(|(_, v)| {
            let differs = **v != last;
            last = **v;
            differs
        });
        stored.map(|(k, v)| (k as f64, *v)).unzip()
    }

    /// Values that differ by `band` from the last stored one.
    fn exceptions(values: &[f64], band: f64) -> (Vec<f64>, Vec<f64>) {
        let mut last = f64::INFINITY;
        let stored = values.iter().enumerate().filter(|(_, v)| {
            let differs = (**v - last).abs() > band;
            if differs {
                last = **v;
            }
            differs
        });
        stored.map(|(k, v)| (k as f64, *v)).unzip()
    }

    fn without(values: &[f64], is_lost: impl Fn(usize) -> bool) -> (Vec<f64>, Vec<f64>) {
        (0..values.len()).filter(|k| !is_lost(*k)).map(|k| (k as f64, values[k])).unzip()
    }

    fn on_change((time, values): &(Vec<f64>, Vec<f64>)) -> bool {
        Rhythm::of(time, values).unwrap().on_change
    }

    #[test]
    fn a_channel_without_small_changes_is_stored_on_change() {
        for step in [0.05, 0.1, 0.2, 0.5, 1.0] {
            let rounded: Vec<f64> = wave(900).iter().map(|v| (v / step).round() * step).collect();
            assert!(on_change(&changes(&rounded)), "steps of {step}");
            assert!(on_change(&exceptions(&wave(900), step)), "exceptions of {step}");
        }
    }

    #[test]
    fn lost_samples_are_not_a_storing_on_change() {
        let lost = |k: usize| k * 7919 % 13 < 4;
        let triangle: Vec<f64> = (0..900).map(|k| (k % 60).min(60 - k % 60) as f64 * 0.5).collect();
        let coarse: Vec<f64> = wave(900).iter().map(|v| (v / 0.1).round() * 0.1).collect();
        let sine: Vec<f64> = (0..900).map(|k| (k as f64 * 0.07).sin()).collect();
        for values in [wave(900), triangle, coarse, sine, vec![50.0; 900]] {
            assert!(!on_change(&without(&values, lost)));
            assert!(!on_change(&without(&values, |k| (300..400).contains(&k))));
        }
    }

    #[test]
    fn rare_changes_have_the_step_of_their_samples() {
        // Changes after one to seven samples.
        let mut k = 0;
        let time: Vec<f64> = (0..200)
            .map(|i| {
                k += 1 + i * 7919 % 7;
                f64::from(k) * 0.1
            })
            .collect();
        let values: Vec<f64> = (0..200).map(f64::from).collect();
        let rhythm = Rhythm::of(&time, &values).unwrap();
        assert!(rhythm.on_change && rhythm.step == 0.1, "{rhythm:?}");
    }

    #[test]
    fn a_long_silence_is_longer_than_any_hold() {
        let rounded: Vec<f64> = wave(900).iter().map(|v| (v / 0.1).round() * 0.1).collect();
        let (time, values) = changes(&rounded);
        let hold = Rhythm::of(&time, &values).unwrap().longest_hold;
        assert!((30.0..60.0).contains(&hold), "{hold}");
        // A valve that rests in every cycle holds its value as long in each.
        let rests: Vec<f64> = (0..900).map(|k| (k / 60) as f64 + (k % 60).min(9) as f64).collect();
        let (time, values) = changes(&rests);
        assert!(Rhythm::of(&time, &values).unwrap().longest_hold > 51.0);
    }

    #[test]
    fn empty_cells_in_rows_of_other_channels_are_no_samples() {
        let n = 300;
        let rows: Vec<f64> = (0..2 * n).map(|k| (k / 2) as f64 + 0.2 * (k % 2) as f64).collect();
        let values: Vec<f64> = wave(n).into_iter().flat_map(|v| [v, f64::NAN]).collect();
        let empty: Vec<bool> = values.iter().map(|v| v.is_nan()).collect();
        assert!(are_other_rows(&rows, &values, &empty));
        // Samples that a table with one clock lacks are missing.
        let time: Vec<f64> = (0..n).map(|k| k as f64).collect();
        for is_lost in [|k: usize| k % 11 == 3, |k: usize| (50..120).contains(&k)] {
            let mut values = wave(n);
            let empty: Vec<bool> = (0..n).map(is_lost).collect();
            (0..n).filter(|k| empty[*k]).for_each(|k| values[k] = f64::NAN);
            assert!(!are_other_rows(&time, &values, &empty));
        }
        // A slower channel, and one stored on change.
        let empty: Vec<bool> = (0..n).map(|k| k % 3 != 0).collect();
        assert!(are_other_rows(&time, &wave(n), &empty));
        let rounded: Vec<f64> = wave(n).iter().map(|v| (v / 0.2).round() * 0.2).collect();
        let empty: Vec<bool> = (0..n).map(|k| k > 0 && rounded[k] == rounded[k - 1]).collect();
        assert!(are_other_rows(&time, &rounded, &empty));
        assert!(!are_other_rows(&time, &wave(n), &vec![false; n]));
        assert!(!are_other_rows(&time, &wave(n), &vec![true; n]));
    }
}
