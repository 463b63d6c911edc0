//! Whether the levels of an OP follow from PV and SP, as the levels of a slow controller do.
//!
//! # Equations
//! A PID controller moves its OP by the errors at its last three executions, and an operator by the last levels:
//!
//! ```text
//! u(k) - u(k-1) = a + b e(k) + c e(k-1) + d e(k-2),    e = SP - PV
//! u(k) - u(k-1) = a + b u(k-1) + c u(k-2) + d u(k-3)
//! ```
//! Both are fitted by least squares; the constant stands for an SP that is not recorded. A controller set the OP if the
//! errors explain its moves much better than the levels do. Where all holds are multiples of the shortest, as of a
//! controller, a smaller difference is enough. If the OP swings without noise, levels explain it too. It is then enough
//! that the errors leave no more than the resolution of the OP. `b` must oppose the response of the PV, because a fast
//! PV follows an operator as exactly.
//!
//! # Limits
//! The PV must be recorded as the controller sees it. Compression hides the law, and then the levels decide alone.
//! Eight levels are too few for both fits. Such a short test is recognised only by its mode or sheet, or by equal steps
//! up and down.

use super::Level;
use nalgebra::{Matrix3, Vector3};

/// Residual sum of squares with the errors, as a share of the sum with the levels. The first share is for levels held
/// for any time, the second for levels whose holds are multiples of the shortest.
const SHARE: f64 = 0.25;
const SHARE_OF_REGULAR: f64 = 0.7;
/// Standard deviation that two rounded levels leave, in steps of the OP: a little more than the root of 1/6.
const ROUNDED: f64 = 0.45;
/// Smallest number of moves away from the ends of the range. Turns to the ends are no test, because the valve cannot
/// follow.
const FEWEST: usize = 6;
/// Distance from an end of the range that counts as at the end, percent.
const NEAR: f64 = 0.05;

/// Whether a controller set these levels of `op`. Signals are times and values in order of time.
pub(super) fn is_obeyed(
    chain: &[Level],
    op: &[(f64, f64)],
    pv: &[(f64, f64)],
    sp: &[(f64, f64)],
) -> bool {
    if pv.is_empty() {
        return false;
    }
    let inside = |level: &Level| (NEAR..=100.0 - NEAR).contains(&level.op);
    let rows: Vec<usize> =
        (3..chain.len()).filter(|k| inside(&chain[*k]) && inside(&chain[k - 1])).collect();
    if rows.len() < FEWEST {
        return true;
    }
    let travel = |k: usize| chain[k].op - chain[k - 1].op;
    let moves: Vec<f64> = rows.iter().map(|k| travel(*k)).collect();
    let levels = |k: &usize| Vector3::new(chain[k - 1].op, chain[k - 2].op, chain[k - 3].op);
    let (by_levels, _) = fit(&moves, &rows.iter().map(levels).collect::<Vec<_>>());
    // Errors at the first sample of each level, or at the last sample before it.
    let [now, before] = [0, 1].map(|late| -> Vec<f64> {
        let times = chain.iter().map(|level| op[level.from.saturating_sub(late)].0);
        times.map(|time| held(sp, time) - held(pv, time)).collect()
    });
    let opposed: f64 = (1..chain.len() - 1).map(|k| travel(k) * (before[k] - before[k + 1])).sum();
    let by_errors = [now, before].map(|e| {
        let of = |k: &usize| Vector3::new(e[*k], e[k - 1], e[k - 2]);
        let (left, b) = fit(&moves, &rows.iter().map(of).collect::<Vec<_>>());
        if b * opposed > 0.0 { left } else { f64::INFINITY }
    });
    let by_errors = by_errors[0].min(by_errors[1]);
    if !is_regular(chain) {
        return by_errors < SHARE * by_levels;
    }
    let rounded = (by_errors / moves.len() as f64).sqrt() < ROUNDED * resolution(chain);
    by_errors < SHARE_OF_REGULAR * by_levels || rounded
}

/// The last value of a signal up to a time; 0 without a signal.
fn held(signal: &[(f64, f64)], time: f64) -> f64 {
    let after = signal.partition_point(|(t, _)| *t <= time);
    signal.get(after.saturating_sub(1)).map_or(0.0, |sample| sample.1)
}

/// The smallest distance between two levels.
fn resolution(chain: &[Level]) -> f64 {
    let mut levels: Vec<f64> = chain.iter().map(|level| level.op).collect();
    levels.sort_by(f64::total_cmp);
    let apart = levels.windows(2).map(|two| two[1] - two[0]);
    apart.filter(|apart| *apart > 1e-6).fold(f64::INFINITY, f64::min)
}

/// Whether all holds are multiples of the shortest, to one sample. The first may have begun before the recording.
fn is_regular(chain: &[Level]) -> bool {
    let first = usize::from(chain[0].from == 0);
    let holds = || chain[first..].windows(2).map(|two| two[1].from - two[0].from);
    let shortest = holds().min().unwrap_or(1).max(1);
    holds().all(|hold| (hold + 1) % shortest <= 2)
}

/// Least squares of `y` on `x` and a constant: the residual sum of squares, and the first coefficient.
fn fit(y: &[f64], x: &[Vector3<f64>]) -> (f64, f64) {
    let n = y.len() as f64;
    let (my, mx) = (y.iter().sum::<f64>() / n, x.iter().sum::<Vector3<f64>>() / n);
    let (mut gram, mut with) = (Matrix3::zeros(), Vector3::zeros());
    for (y, x) in y.iter().zip(x) {
        let x = x - mx;
        gram += x * x.transpose();
        with += x * (y - my);
    }
    // A small ridge keeps the matrix regular.
    gram += Matrix3::identity() * (1e-9 * gram.trace() + f64::MIN_POSITIVE);
    let found = gram.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * with);
    let left = y.iter().zip(x).map(|(y, x)| (y - my - found.dot(&(x - mx))).powi(2)).sum();
    (left, found[0])
}
