//! The sample time.

use crate::series::mean;
use std::collections::BTreeMap;

/// Times this close, in sample times, are the same.
pub(super) const SAME: f64 = 1e-6;

/// The most frequent time between samples in order of time, and its share of the steps.
///
/// Steps are sorted into classes 5 % wide. The result is the mean of the largest class and its neighbours, or the mean
/// step if all times agree with it. It is rounded to nine digits, the precision of written times, or to three if that
/// is within a thousandth and the times are not regular anyway.
pub(in crate::recording) fn commonest_step(time: &[f64]) -> Option<(f64, f64)> {
    let class = |step: f64| (20.0 * step.ln()).round() as i64;
    let steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).filter(|d| *d > 0.0).collect();
    let first = *steps.first()?;
    let near = |step: f64, to: f64| (step - to).abs() <= SAME * to;
    let tolerance = 1e-15 * time.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    if steps.iter().all(|d| near(*d, first) || (d - first).abs() < tolerance) {
        return Some((exact_step(time, first), 1.0));
    }
    let mut classes: BTreeMap<i64, usize> = BTreeMap::new();
    // Most neighbours are of one class, so the logarithm is only needed when the step changes.
    let (mut last, mut key) = (first, class(first));
    for &step in &steps {
        if step != last {
            (last, key) = (step, class(step));
        }
        *classes.entry(key).or_default() += 1;
    }
    // Of equal counts the shorter step: it loses no sample.
    let (&fullest, _) = classes.iter().rev().max_by_key(|(_, count)| **count)?;
    let near_to = |middle: f64| -> Vec<f64> {
        steps.iter().copied().filter(|d| (0.93..1.07).contains(&(d / middle))).collect()
    };
    let like = near_to(mean(&near_to((fullest as f64 / 20.0).exp())));
    let share = like.len() as f64 / steps.len() as f64;
    // The mean, because errors of single times cancel in it.
    let typical = mean(&like);
    let regular = like.iter().all(|d| near(*d, typical) || (d - typical).abs() < tolerance);
    let step = if regular { exact_step(time, typical) } else { rounded(typical, 2, 1e-3) };
    Some((step, share))
}

/// The step of times that are regular except for gaps, to more digits than any single difference has.
fn exact_step(time: &[f64], typical: f64) -> f64 {
    // The longest run without a gap.
    let (mut from, mut best) = (0, 0..1);
    for i in 1..=time.len() {
        if i == time.len() || (time[i] - time[i - 1] - typical).abs() > 0.01 * typical {
            if i - from > best.len() {
                best = from..i;
            }
            from = i;
        }
    }
    if best.len() < 2 {
        return rounded(typical, 8, 1e-6);
    }
    let steps = (best.len() - 1) as f64;
    let mean = (time[best.end - 1] - time[best.start]) / steps;
    rounded(mean, 8, 0.1 * SAME / steps)
}

/// The value rounded to this many digits after the first, unless rounding changes it by more than a share of itself.
fn rounded(value: f64, digits: usize, share: f64) -> f64 {
    let round = format!("{value:.digits$e}").parse().unwrap_or(value);
    if (round - value).abs() <= share.max(2e-15) * value { round } else { value }
}

/// Largest distance of a time from its point of the grid.
pub(super) fn tolerance(step: f64, from: f64, to: f64) -> f64 {
    (SAME * step).max(4.0 * f64::EPSILON * from.abs().max(to.abs())).min(0.25 * step)
}
