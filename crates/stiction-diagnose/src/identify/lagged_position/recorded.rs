//! Whether a record contains every move of the controller.

use crate::numeric::least_squares::least_squares;
use crate::series::{max, mean, min, std};

/// Whether the controller may have acted between two samples of the record. If so, the stem has followed unrecorded
/// moves of the OP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moves {
    /// The record contains every move.
    Recorded,
    /// The controller may have acted between two samples.
    MayBeMissed,
}

/// Share of the effect of missed moves on the law up to which none is missed.
const LEAST: f64 = 0.3;
/// Share of the variance of the OP's changes that is rounding in any case.
const ROUNDING: f64 = 1e-9;
/// Smallest number of samples off the limits of the OP for the law, and the number in use.
const FEWEST: usize = 100;
const ENOUGH: usize = 4_000;

/// Looks for the law of a PI controller with a filter in the record:
///
/// ```text
/// du(k) = c + b0 e(k) + b1 e(k-1) + b2 e(k-2) + a1 du(k-1) + a2 du(k-2) + r(k),   e = SP - PV
/// rounding = (b0^2 + b1^2 + b2^2) qPV^2 / 12 + (1 + (1+a1)^2 + (a2-a1)^2 + a2^2) qOP^2 / 12
/// missed   = 1/4 (i sigma)^2,   i = (b0 + b1 + b2) / (1 - a1 - a2)
/// recorded:  var r - rounding <= 0.3 missed,  rounding <= 3 missed
/// ```
/// with q the resolutions of the recorded signals, i the gain of the integral and sigma the standard deviation of the
/// noise of e. A controller that acts twice a sample integrates an unrecorded error: that alone leaves at least
/// `missed`. A controller whose record was averaged or compressed, or that has a different law, leaves an error, too.
/// Moves then count as missed.
pub fn moves(op: &[f64], pv: Option<&[f64]>, sp: Option<&[f64]>) -> Moves {
    match pv {
        Some(pv) if keeps_law(op, pv, sp) => Moves::Recorded,
        _ => Moves::MayBeMissed,
    }
}

fn keeps_law(op: &[f64], pv: &[f64], sp: Option<&[f64]>) -> bool {
    let n = op.len().min(pv.len()).min(ENOUGH);
    let (op, pv) = (&op[..n], &pv[..n]);
    let error: Vec<f64> = match sp {
        Some(sp) => sp.iter().zip(pv).map(|(sp, pv)| sp - pv).collect(),
        None => pv.iter().map(|pv| -pv).collect(),
    };
    let (low, high) = (min(op), max(op));
    let inside = |k: usize| op[k] > low && op[k] < high;
    // The law does not hold at a limit.
    let at: Vec<usize> = (3..n.min(error.len())).filter(|&k| (k - 3..=k).all(inside)).collect();
    if at.len() < FEWEST {
        return false;
    }
    let change = |k: usize| op[k] - op[k - 1];
    let column = |f: &dyn Fn(usize) -> f64| {
        let x: Vec<f64> = at.iter().map(|k| f(*k)).collect();
        let (middle, scale) = (mean(&x), std(&x).max(f64::MIN_POSITIVE));
        (x.iter().map(|x| (x - middle) / scale).collect::<Vec<f64>>(), scale)
    };
    let (target, of_target) = column(&change);
    // Differences of the error, so that the columns are not nearly alike.
    let columns = [
        column(&|k| error[k]),
        column(&|k| error[k] - error[k - 1]),
        column(&|k| error[k - 1] - error[k - 2]),
        column(&|k| change(k - 1)),
        column(&|k| change(k - 2)),
    ];
    let views: Vec<&[f64]> = columns.iter().map(|(x, _)| &x[..]).collect();
    let Some(found) = least_squares(&views, &target) else { return false };
    let factors = found.coefficients.iter().zip(&columns);
    let factors: Vec<f64> = factors.map(|(c, (_, scale))| c * of_target / scale).collect();
    let [i, p, d, a1, a2] = [factors[0], factors[1], factors[2], factors[3], factors[4]];
    let squares = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let rounding = (squares(&[i + p, d - p, d]) * quantum(pv).powi(2)
        + squares(&[1.0, 1.0 + a1, a2 - a1, a2]) * quantum(op).powi(2))
        / 12.0;
    let seconds: Vec<f64> = error.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
    let noise = squares(&seconds) / (6 * seconds.len()) as f64;
    let integral = i / (1.0 - a1 - a2);
    let missed = 0.25 * integral * integral * noise;
    let left = found.sse / at.len() as f64 - ROUNDING;
    left * of_target * of_target - rounding <= LEAST * missed && rounding <= missed / LEAST
}

/// Delays of a copy, samples; share of its samples that are equal; and fewest levels that cannot be equal by chance.
const COPIED: (usize, f64, usize) = (3, 0.99, 20);

/// The delay, in samples, of a position that only repeats the OP. No measured stem does so, not even an ideal stem,
/// because its transmitter rounds separately.
pub(super) fn copied(op: &[f64], vp: &[f64]) -> Option<usize> {
    let (delays, share, fewest) = COPIED;
    let equal = |delay: usize| {
        let pairs = op.iter().zip(&vp[delay..]);
        pairs.filter(|(op, vp)| (**op - **vp).abs() <= 1e-6).count()
    };
    let is_copy = |delay: &usize| equal(*delay) as f64 >= share * (op.len() - delay) as f64;
    (0..delays).find(is_copy).filter(|_| levels(op).len() >= fewest)
}

/// The different values, ascending.
fn levels(x: &[f64]) -> Vec<f64> {
    let mut levels = x.to_vec();
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|a, b| (*a - *b).abs() <= 1e-6);
    levels
}

/// The least distance between two different values, if there are at least four samples a value; else 0.
pub(super) fn quantum(x: &[f64]) -> f64 {
    let levels = levels(x);
    if levels.len() < 2 || levels.len() * 4 > x.len() {
        return 0.0;
    }
    levels.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min)
}

/// Standard deviation of the noise of a position, %. It is the noise in second differences in the quietest tenth of
/// windows, and at least the noise of the resolution.
pub(super) fn noise(vp: &[f64]) -> f64 {
    /// Number of second differences in a window.
    const WINDOW: usize = 8;
    /// Ratio of the quietest tenth of windows of eight to all.
    const QUIET: f64 = 0.6;
    let seconds: Vec<f64> = vp.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
    let windows = seconds.chunks_exact(WINDOW);
    let each: Vec<f64> = windows
        .map(|w| (w.iter().map(|d| d * d).sum::<f64>() / (6 * WINDOW) as f64).sqrt())
        .collect();
    let quiet = crate::series::quantile(&each, 0.1) / QUIET;
    quiet.max(quantum(vp) / 12f64.sqrt()).max(1e-6)
}
