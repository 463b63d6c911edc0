//! Regular times that were written with too few digits, so that their steps alternate between two lengths.

use super::context::{Context, Times};
use crate::sheet::Column;
use stiction_recording::series;

/// Units in which times are written, s. The last digit of a written time is one of their decimal fractions.
const UNITS: [f64; 4] = [1.0, 60.0, 3600.0, 86_400.0];

/// The largest distance between a regular time and the written one, in resolutions, with some jitter of the clock.
const OFF: f64 = 1.2;

/// The fewest steps of the rarer length that show rounding. A few longer steps are lost samples.
const FEWEST: usize = 10;

/// The regular times from which the written times were rounded.
pub struct Regular {
    /// The difference between the two lengths of the steps, s.
    resolution: f64,
    /// The time between rows, s.
    pub step: f64,
    /// Whether all written times differ.
    pub differ: bool,
    times: Vec<f64>,
}

impl Regular {
    /// The regular times from which ascending times were rounded. `None` unless rounding explains every time. Steps at
    /// random, or of samples stored on change, do not stay this close to a regular clock. Its step has as few decimals
    /// as possible.
    pub fn of(written: &[f64]) -> Option<Self> {
        let steps = || written.windows(2).map(|pair| pair[1] - pair[0]);
        let short = steps().reduce(f64::min).filter(|step| *step >= 0.0)?;
        let long = steps().filter(|step| *step > 1.05 * short).reduce(f64::min)?;
        let resolution = long - short;
        let is_digit = |unit: &f64| {
            let digits = (unit / resolution).log10();
            digits > -0.5 && (digits - digits.round()).abs() < 1e-4
        };
        let units = short / resolution;
        if !UNITS.iter().any(is_digit) || (units - units.round()).abs() > 0.01 {
            return None;
        }
        let count =
            |length: f64| steps().filter(|s| (s - length).abs() < 0.01 * resolution).count();
        let rarer = count(short).min(count(long));
        // A step of twice the usual length may also be a lost sample.
        let is_loss = short > 0.0 && long > 1.9 * short && 10 * rarer < written.len();
        let runs = || written.chunk_by(|a, b| b - a < long + 0.5 * resolution);
        if rarer < FEWEST || is_loss || 20 * runs().count() > written.len() {
            return None;
        }
        let longest = runs().max_by_key(|run| run.len())?;
        let places: Vec<f64> = (0..longest.len()).map(|k| k as f64).collect();
        let slope = series::line(&places, longest).slope;
        // The first time of a run, and the distance of the others from a regular clock.
        let start = |run: &[f64], step: f64| {
            let all: Vec<f64> =
                run.iter().enumerate().map(|(k, at)| at - k as f64 * step).collect();
            (0.5 * (series::min(&all) + series::max(&all)), series::span(&all))
        };
        let fits = |step: &f64| runs().all(|run| start(run, *step).1 <= OFF * resolution);
        let rounded =
            (0..7).map(|digits| (slope * 10f64.powi(digits)).round() / 10f64.powi(digits));
        let step = rounded.chain([slope]).find(fits).filter(|step| *step > 0.0)?;
        let (mut times, mut from) =
            (Vec::with_capacity(written.len()), start(runs().next()?, step).0);
        let shift = written[0] - from;
        for run in runs() {
            // After a gap the clock goes on, if the written times allow.
            let (own, _) = start(run, step);
            let next = from + ((own - from) / step).round() * step;
            from = if (next - own).abs() <= 0.5 * resolution { next } else { own };
            times.extend((0..run.len()).map(|k| from + shift + k as f64 * step));
        }
        Some(Self { resolution, step, differ: short > 0.0, times })
    }
}

/// Replaces rounded times by the regular times from which they were rounded, with a note.
pub fn restore(times: &mut Times, column: &Column, context: &Context<'_>) {
    let mut found = None;
    for mut rows in context.rows_of_series() {
        if rows.first().zip(rows.last()).is_some_and(|(a, b)| times.seconds[*a] > times.seconds[*b])
        {
            rows.reverse();
        }
        let written: Vec<f64> = rows.iter().map(|row| times.seconds[*row]).collect();
        let Some(regular) = Regular::of(&written).filter(|regular| regular.differ) else {
            continue;
        };
        rows.iter().zip(&regular.times).for_each(|(row, at)| times.seconds[*row] = *at);
        found.get_or_insert(regular);
    }
    times.notes.extend(found.map(|Regular { resolution, step, .. }| {
        let short = |seconds: f64| (seconds * 1e6).round() / 1e6;
        format!(
            "the times in \"{}\" are rounded to {} s, so their steps alternate; the sample time is the mean step, {} s",
            column.name,
            short(resolution),
            short(step)
        )
    }));
}
