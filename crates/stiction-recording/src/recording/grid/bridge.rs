//! Values of bridged samples.

use stiction_model::numeric::least_squares::least_squares;

/// So many neighbours on either side take part in the estimate.
const REACH: usize = 2;

/// The fewest known samples for each coefficient.
const SAMPLES_PER_COEFFICIENT: usize = 8;

/// The most known samples that are used. More do not change the coefficients.
const MOST_SAMPLES: usize = 2000;

/// Each pass uses the estimates of the previous pass for neighbours that are also missing.
const PASSES: usize = 3;

/// Estimates the missing samples of a signal by a regression on [`REACH`] neighbours in this signal and in other
/// signals. Where most samples repeat the last one, the estimate is set to the value of a neighbour. Where the signal
/// has coarse steps, it is set to a step. A held value or a straight line stays in place where it estimates the known
/// samples as well, or too few samples are known.
pub(super) fn estimate(signal: &mut [f64], missing: &[bool], others: &[&[f64]], holds: bool) {
    let places: Vec<usize> = (0..signal.len()).filter(|&k| missing[k]).collect();
    if places.is_empty() || signal.len() <= 2 * REACH {
        return;
    }
    let inner = REACH..signal.len() - REACH;
    let stride = inner.len().div_ceil(MOST_SAMPLES);
    let known: Vec<usize> = inner
        .clone()
        .filter(|&k| !missing[k - REACH..=k + REACH].contains(&true))
        .step_by(stride)
        .collect();
    let Some(regression) = Regression::of(signal, others, &known) else { return };
    let simple = |k: usize| {
        if holds { signal[k - 1] } else { 0.5 * (signal[k - 1] + signal[k + 1]) }
    };
    let error: f64 = known.iter().map(|&k| (signal[k] - simple(k)).abs()).sum();
    if regression.error >= error {
        return;
    }
    let still = known.iter().filter(|&&k| signal[k] == signal[k - 1]).count();
    let mut shown: Vec<f64> =
        (0..signal.len()).filter(|&k| !missing[k]).map(|k| signal[k]).collect();
    let measured = shown.len();
    shown.sort_by(f64::total_cmp);
    shown.dedup();
    let nearest = |estimate: f64, candidates: [f64; 2]| {
        let [a, b] = candidates;
        if (b - estimate).abs() < (a - estimate).abs() { b } else { a }
    };
    // The first estimate is a straight line.
    for &k in places.iter().filter(|k| inner.contains(k)) {
        if let Some(next) = (k + 1..signal.len()).find(|&j| !missing[j]) {
            signal[k] = signal[k - 1] + (signal[next] - signal[k - 1]) / (next - k + 1) as f64;
        }
    }
    for _ in 0..PASSES {
        for &k in places.iter().filter(|k| inner.contains(k)) {
            let estimate = regression.at(signal, others, k);
            signal[k] = if 2 * still > known.len() {
                nearest(estimate, [signal[k - 1], signal[k + 1]])
            } else if 2 * shown.len() < measured {
                let above = shown.partition_point(|value| *value < estimate);
                nearest(
                    estimate,
                    [above.saturating_sub(1), above.min(shown.len() - 1)].map(|at| shown[at]),
                )
            } else {
                estimate
            };
        }
    }
}

/// A signal's value as a combination of its neighbours.
struct Regression {
    /// Mean of the signal, and factor and mean of each neighbour.
    mean: f64,
    neighbours: Vec<(f64, f64)>,
    /// Sum of the absolute errors in the known samples.
    error: f64,
}

impl Regression {
    /// `None` if too few samples are known.
    fn of(signal: &[f64], others: &[&[f64]], known: &[usize]) -> Option<Self> {
        let count = 2 * REACH + others.len() * (2 * REACH + 1);
        if known.len() < SAMPLES_PER_COEFFICIENT * count {
            return None;
        }
        let standard = |mut column: Vec<f64>| {
            let n = column.len() as f64;
            let mean = column.iter().sum::<f64>() / n;
            column.iter_mut().for_each(|value| *value -= mean);
            let size = (column.iter().map(|value| value * value).sum::<f64>() / n).sqrt();
            let factor = if size > 0.0 { 1.0 / size } else { 0.0 };
            column.iter_mut().for_each(|value| *value *= factor);
            (column, mean, factor)
        };
        let rows: Vec<Vec<f64>> =
            known.iter().map(|&k| neighbours(signal, others, k).collect()).collect();
        let columns: Vec<_> =
            (0..count).map(|i| standard(rows.iter().map(|row| row[i]).collect())).collect();
        let (target, mean, factor) = standard(known.iter().map(|&k| signal[k]).collect());
        if factor == 0.0 {
            return None;
        }
        let views: Vec<&[f64]> = columns.iter().map(|column| &column.0[..]).collect();
        let solution = least_squares(&views, &target)?;
        let scaled = solution.coefficients.iter().zip(&columns);
        Some(Self {
            mean,
            neighbours: scaled.map(|(c, (_, mean, own))| (c * own / factor, *mean)).collect(),
            error: solution.residual.iter().map(|residual| (residual / factor).abs()).sum(),
        })
    }

    fn at(&self, signal: &[f64], others: &[&[f64]], k: usize) -> f64 {
        let parts = neighbours(signal, others, k).zip(&self.neighbours);
        self.mean + parts.map(|(value, (factor, mean))| factor * (value - mean)).sum::<f64>()
    }
}

/// The neighbours of a sample in its signal, and the neighbours at the same time in the other signals.
fn neighbours<'a>(
    signal: &'a [f64],
    others: &'a [&[f64]],
    k: usize,
) -> impl Iterator<Item = f64> + 'a {
    let around = k - REACH..=k + REACH;
    let own = around.clone().filter(move |j| *j != k).map(|j| signal[j]);
    own.chain(others.iter().flat_map(move |other| around.clone().map(|j| other[j])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A set point that steps, a process that lags behind the output, and a PI controller.
    fn cycle(n: usize) -> [Vec<f64>; 3] {
        let (mut op, mut pv, mut sp) = (vec![50.0; n], vec![50.0; n], vec![50.0; n]);
        for k in 1..n {
            sp[k] = if k / 60 % 2 == 0 { 50.0 } else { 54.0 };
            pv[k] = 0.9 * pv[k - 1] + 0.1 * op[k - 1];
            op[k] =
                op[k - 1] + 1.5 * (sp[k] - pv[k] - sp[k - 1] + pv[k - 1]) + 0.2 * (sp[k] - pv[k]);
        }
        [op, pv, sp]
    }

    #[test]
    fn the_law_of_the_controller_and_the_lag_of_the_process_fill_gaps() {
        let [op, pv, sp] = cycle(600);
        let missing: Vec<bool> = (0..600).map(|k| k % 50 == 20 || k % 150 == 61).collect();
        for (truth, others, holds) in [(&op, [&pv[..], &sp], true), (&pv, [&op[..], &sp], false)] {
            let mut filled = truth.clone();
            for k in (0..600).filter(|&k| missing[k]) {
                filled[k] = filled[k - 1];
            }
            let held = filled.clone();
            estimate(&mut filled, &missing, &others, holds);
            let error =
                |found: &[f64]| (0..600).map(|k| (found[k] - truth[k]).abs()).fold(0.0, f64::max);
            assert!(
                error(&filled) < 0.02 && error(&held) > 0.2,
                "{} {}",
                error(&filled),
                error(&held)
            );
        }
    }

    #[test]
    fn a_signal_that_holds_takes_the_value_of_a_neighbour() {
        let [mut op, pv, sp] = cycle(600);
        for k in 0..600 {
            op[k] = op[k / 10 * 10];
        }
        let missing: Vec<bool> = (0..600).map(|k| k % 37 == 20).collect();
        let mut filled = op.clone();
        estimate(&mut filled, &missing, &[&pv, &sp], true);
        for k in (0..600).filter(|&k| missing[k]) {
            assert!([filled[k - 1], filled[k + 1]].contains(&filled[k]), "{k}");
        }
    }

    #[test]
    fn what_is_too_short_or_constant_stays() {
        for n in [0, 3, 40, 600] {
            let mut constant = vec![7.0; n];
            let missing: Vec<bool> = (0..n).map(|k| k % 9 == 4).collect();
            estimate(&mut constant, &missing, &[&vec![1.0; n]], true);
            assert_eq!(constant, vec![7.0; n]);
        }
    }
}
