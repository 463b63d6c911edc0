//! Probabilities and intervals that hold on loops left out of training.

use stiction_diagnose::fusion::{COVERAGE, Calibration, sigmoid, softplus};

/// Number of classes of predicted width, each with its own shift.
const WIDTH_CLASSES: usize = 8;

/// The fewest loops in such a class.
const FEWEST_IN_CLASS: usize = 50;

/// The better of beta calibration and isotonic regression, and its log loss. Each is judged on the half of the loops
/// that was not used to fit it.
pub fn calibration(margins: &[f64], truth: &[bool]) -> (Calibration, f64) {
    let half = |odd: usize| -> (Vec<f64>, Vec<bool>) {
        let part = margins.iter().zip(truth).skip(odd).step_by(2);
        part.map(|(margin, truth)| (*margin, *truth)).unzip()
    };
    let (even, odd) = (half(0), half(1));
    let crossed = |fit: fn(&[f64], &[bool]) -> Calibration| {
        let one = log_loss(&fit(&even.0, &even.1), &odd.0, &odd.1);
        let other = log_loss(&fit(&odd.0, &odd.1), &even.0, &even.1);
        0.5 * (one + other)
    };
    let (smooth, free) = (crossed(beta), crossed(isotonic));
    if free < smooth { (isotonic(margins, truth), free) } else { (beta(margins, truth), smooth) }
}

fn log_loss(map: &Calibration, margins: &[f64], truth: &[bool]) -> f64 {
    let loss = |(margin, truth): (&f64, &bool)| {
        let p = map.probability(*margin).clamp(1e-9, 1.0 - 1e-9);
        if *truth { -p.ln() } else { -(1.0 - p).ln() }
    };
    margins.iter().zip(truth).map(loss).sum::<f64>() / margins.len().max(1) as f64
}

/// Beta calibration by Newton's method on the log loss, with slopes of at least 0: a negative slope is set to 0 and
/// the rest fitted again.
pub fn beta(margins: &[f64], truth: &[bool]) -> Calibration {
    let row = |margin: &f64| [-softplus(-margin), softplus(*margin), 1.0];
    let rows: Vec<[f64; 3]> = margins.iter().map(row).collect();
    let mut free = [true; 3];
    loop {
        let at = logistic(&rows, truth, [1.0, 1.0, 0.0], free);
        match (0..2).filter(|k| at[*k] < 0.0).min_by(|j, k| at[*j].total_cmp(&at[*k])) {
            Some(k) => free[k] = false,
            None => return Calibration::Beta { a: at[0], b: at[1], c: at[2] },
        }
    }
}

/// Logistic regression of the truth on rows of three, by Newton's method. A coefficient that is not free is 0. A small
/// regularisation to `aim` keeps free coefficients finite if a class is missing.
pub fn logistic(rows: &[[f64; 3]], truth: &[bool], aim: [f64; 3], free: [bool; 3]) -> [f64; 3] {
    const PULL: f64 = 1e-3;
    let mut at = [0, 1, 2].map(|k| if free[k] { aim[k] } else { 0.0 });
    for _ in 0..50 {
        let mut g = [0.0; 3];
        let mut h = [[0.0; 3]; 3];
        for k in 0..3 {
            g[k] = PULL * (at[k] - aim[k]);
            h[k][k] = PULL;
        }
        for (x, truth) in rows.iter().zip(truth) {
            let p = sigmoid((0..3).map(|k| at[k] * x[k]).sum());
            for j in 0..3 {
                g[j] += (p - f64::from(*truth)) * x[j];
                for k in 0..3 {
                    h[j][k] += p * (1.0 - p) * x[j] * x[k];
                }
            }
        }
        for k in (0..3).filter(|k| !free[*k]) {
            g[k] = 0.0;
            h[k] = [0.0; 3];
            h.iter_mut().for_each(|row| row[k] = 0.0);
            h[k][k] = 1.0;
        }
        let step = solve(h, g);
        (0..3).for_each(|k| at[k] -= step[k].clamp(-2.0, 2.0));
        if step.iter().all(|s| s.abs() < 1e-10) {
            break;
        }
    }
    at
}

/// Solves a positive definite system of three by elimination.
fn solve(mut h: [[f64; 3]; 3], mut g: [f64; 3]) -> [f64; 3] {
    for k in 0..3 {
        for j in k + 1..3 {
            let factor = h[j][k] / h[k][k];
            (0..3).for_each(|i| h[j][i] -= factor * h[k][i]);
            g[j] -= factor * g[k];
        }
    }
    for k in (0..3).rev() {
        let known: f64 = (k + 1..3).map(|i| h[k][i] * g[i]).sum();
        g[k] = (g[k] - known) / h[k][k];
    }
    g
}

/// Isotonic regression by pooling adjacent violators. Each pool is a point at its mean margin. Half a loop of either
/// class is added to each pool, so that no probability is certain.
///
/// Source: M. Ayer, H. D. Brunk, G. M. Ewing, W. T. Reid, E. Silverman, "An empirical distribution
/// function for sampling with incomplete information", Ann. Math. Stat. 26 (1955) 641-647 (recalled,
/// not read).
pub fn isotonic(margins: &[f64], truth: &[bool]) -> Calibration {
    /// Number of loops, sum of their margins, and number of true ones.
    struct Pool {
        n: f64,
        margins: f64,
        hits: f64,
    }
    let share = |pool: &Pool| pool.hits / pool.n;
    let mut sorted: Vec<(f64, bool)> = margins.iter().copied().zip(truth.iter().copied()).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pools: Vec<Pool> = vec![];
    for (margin, hit) in sorted {
        let mut pool = Pool { n: 1.0, margins: margin, hits: f64::from(hit) };
        // Loops of one margin are one pool, for either truth.
        while let Some(last) = pools.last()
            && (share(last) >= share(&pool) || last.margins / last.n >= pool.margins / pool.n)
        {
            pool.n += last.n;
            pool.margins += last.margins;
            pool.hits += last.hits;
            pools.pop();
        }
        pools.push(pool);
    }
    let mut points: Vec<(f64, f64)> = pools
        .iter()
        .map(|pool| (pool.margins / pool.n, (pool.hits + 0.5) / (pool.n + 1.0)))
        .collect();
    // Half a loop weighs more in a small pool and can reverse the order of two.
    for k in 1..points.len() {
        points[k].1 = points[k].1.max(points[k - 1].1);
    }
    points.dedup_by(|next, point| next.0 <= point.0);
    Calibration::Isotonic(if points.is_empty() { vec![(0.0, 0.5)] } else { points })
}

/// The shifts of conformalised quantile regression, for classes of predicted width with about equally many loops.
/// From `(low, high, truth)` on loops left out of training, each is the smallest c such that `[low - c, high + c]`
/// covers [`COVERAGE`] of the class and one loop more.
pub fn shifts(predicted: &[(f64, f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = predicted
        .iter()
        .map(|(low, high, truth)| (high - low, (low - truth).max(truth - high)))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let classes = (sorted.len() / FEWEST_IN_CLASS).clamp(1, WIDTH_CLASSES);
    let mut shifts: Vec<(f64, f64)> = vec![];
    for class in 0..classes {
        let end = |class: usize| class * sorted.len() / classes;
        let misses = sorted[end(class)..end(class + 1)].iter().map(|(_, miss)| *miss);
        let shift = upper(misses.collect(), COVERAGE);
        let width = match sorted.get(end(class + 1)) {
            Some((next, _)) if class + 1 < classes => *next,
            _ => f64::INFINITY,
        };
        if shifts.last().is_none_or(|(last, _)| *last < width) {
            shifts.push((width, shift));
        }
    }
    shifts
}

/// Upper quantile of some values with the correction for a finite sample: `share` of these values and of one more value
/// do not exceed it. It is 0 without values.
pub fn upper(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let wanted = ((values.len() + 1) as f64 * share).ceil() as usize;
    values.get(wanted.min(values.len()).saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    /// Margins, and truths of probability `p(margin)`.
    fn drawn(n: usize, p: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<bool>) {
        let mut stream = Stream::new(4, 2);
        let margins = (0..n).map(|_| 8.0 * stream.unit() - 4.0).collect::<Vec<_>>();
        let truth = margins.iter().map(|margin| stream.unit() < p(*margin)).collect();
        (margins, truth)
    }

    #[test]
    fn beta_recovers_a_logistic() {
        let (margins, truth) = drawn(40_000, |m| sigmoid(0.5 * m + 0.7));
        let map = beta(&margins, &truth);
        for m in [-3.0, -1.0, 0.0, 1.0, 3.0] {
            let (found, expected) = (map.probability(m), sigmoid(0.5 * m + 0.7));
            assert!((found - expected).abs() < 0.015, "{m}: {found} {expected}");
        }
    }

    #[test]
    fn a_slope_never_falls_below_nought() {
        let (margins, truth) = drawn(2000, |m| sigmoid(-m));
        let Calibration::Beta { a, b, .. } = beta(&margins, &truth) else { panic!() };
        assert_eq!((a, b), (0.0, 0.0));
        let one_class = beta(&[0.0, 1.0, 2.0], &[true; 3]);
        assert!(one_class.checked().is_ok());
    }

    #[test]
    fn isotonic_pools_violators() {
        let truth = [false, true, false, true, true];
        let Calibration::Isotonic(points) = isotonic(&[0.0, 1.0, 2.0, 3.0, 3.0], &truth) else {
            panic!()
        };
        assert_eq!(points, vec![(0.0, 0.25), (1.5, 0.5), (3.0, 2.5 / 3.0)]);
    }

    #[test]
    fn isotonic_fits_what_beta_cannot() {
        let stairs = |m: f64| {
            if m < -2.0 {
                0.1
            } else if m < 2.0 {
                0.5
            } else {
                0.9
            }
        };
        let (margins, truth) = drawn(20_000, stairs);
        let (map, _) = calibration(&margins, &truth);
        assert!(matches!(map, Calibration::Isotonic(_)));
        let map = map.checked().unwrap();
        for m in [-3.0, -1.0, 1.0, 3.0] {
            assert!((map.probability(m) - stairs(m)).abs() < 0.04, "{m}");
        }
        let (margins, truth) = drawn(2000, sigmoid);
        assert!(matches!(calibration(&margins, &truth).0, Calibration::Beta { .. }));
    }

    #[test]
    fn shifted_intervals_cover_in_every_class() {
        // Half-widths that are right for narrow intervals and half of what they should be for wide ones.
        let mut stream = Stream::new(9, 1);
        let mut drawn = |n: usize| -> Vec<(f64, f64, f64)> {
            (0..n)
                .map(|_| {
                    let half = 0.2 + stream.unit();
                    let needed = if half < 0.7 { half } else { 2.0 * half };
                    (-half, half, needed / 0.9 * (2.0 * stream.unit() - 1.0))
                })
                .collect()
        };
        let shifts = shifts(&drawn(8000));
        assert_eq!(shifts.len(), WIDTH_CLASSES);
        let fresh = drawn(20_000);
        for part in [0.2..0.7, 0.7..1.2] {
            let part: Vec<_> = fresh.iter().filter(|(_, high, _)| part.contains(high)).collect();
            let covered = part.iter().filter(|(low, high, truth)| {
                let class = shifts.iter().find(|(width, _)| high - low <= *width).unwrap();
                (low - class.1..=high + class.1).contains(truth)
            });
            let share = covered.count() as f64 / part.len() as f64;
            assert!((share - COVERAGE).abs() < 0.02, "{share}");
        }
    }

    #[test]
    fn an_upper_quantile_counts_one_more() {
        let values: Vec<f64> = (1..=99).rev().map(f64::from).collect();
        assert_eq!((upper(values.clone(), 0.95), upper(values, 0.999)), (95.0, 99.0));
        assert_eq!((upper(vec![2.0], 0.5), upper(vec![], 0.5)), (2.0, 0.0));
    }

    #[test]
    fn few_loops_make_one_class() {
        assert_eq!(shifts(&[(-1.0, 1.0, 3.0)]), vec![(f64::INFINITY, 2.0)]);
        assert_eq!(shifts(&[]), vec![(f64::INFINITY, 0.0)]);
    }
}
