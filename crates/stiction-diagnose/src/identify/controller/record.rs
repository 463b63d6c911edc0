//! The signals for the fit of a controller: resolution of OP and PV, limits of the OP, and the regressors of every
//! structure.

use super::FEWEST_SAMPLES;
use crate::closed_loop::DerivativeOn;
use crate::finding::Abstention;
use crate::series::{max, mean, min, span};
use std::ops::Range;

/// Fewest consecutive samples off the limits in a run.
const RUN: usize = 12;

/// Updates of the OP if it changes only every few samples: the first such sample, and the number to the next.
pub(super) fn held(op: &[f64]) -> Option<(usize, usize)> {
    let changes: Vec<usize> = (1..op.len()).filter(|k| op[*k] != op[k - 1]).collect();
    if changes.len() < 20 || 2 * changes.len() > op.len() + 1 {
        return None;
    }
    let gaps: Vec<usize> = changes.windows(2).map(|two| two[1] - two[0]).collect();
    let every = *gaps.iter().min()?;
    let regular = gaps.iter().filter(|gap| **gap % every == 0).count();
    let enough = op.len() / every >= FEWEST_SAMPLES;
    (every > 1 && regular * 20 >= gaps.len() * 19 && enough).then(|| (changes[0] % every, every))
}

/// The resolution of a signal: the common divisor of all its changes; 0 if the changes have none.
fn quantum(x: &[f64]) -> f64 {
    let mut changes: Vec<f64> =
        x.windows(2).map(|two| (two[1] - two[0]).abs()).filter(|change| *change > 0.0).collect();
    changes.sort_unstable_by(f64::total_cmp);
    let Some(&least) = changes.get(changes.len() / 50) else { return 0.0 };
    let noise = 1e-6 * least + 1e-12 * span(x);
    let whole =
        |change: &&f64| (*change / least - (*change / least).round()).abs() * least <= noise;
    let multiples = changes.iter().filter(whole).count();
    if multiples * 100 >= changes.len() * 98 { least } else { 0.0 }
}

/// A limit of a signal: its extreme value, if the signal stays there and arrives in steps above its resolution.
fn limit(x: &[f64], extreme: f64, quantum: f64) -> Option<f64> {
    let at: Vec<bool> =
        x.iter().map(|v| (v - extreme).abs() <= 1e-9 * extreme.abs().max(1.0)).collect();
    let stays = at.windows(2).filter(|two| two[0] && two[1]).count();
    let mut arrivals: Vec<f64> =
        (1..x.len()).filter(|k| at[*k] != at[k - 1]).map(|k| (x[k] - x[k - 1]).abs()).collect();
    if stays < 3 || arrivals.is_empty() {
        return None;
    }
    arrivals.sort_unstable_by(f64::total_cmp);
    (arrivals[arrivals.len() / 2] > 1.5 * quantum).then_some(extreme)
}

/// The largest movement of the OP from sample to sample, if it is frequent.
fn rate_limit(op: &[f64], step: f64) -> Option<f64> {
    let moves: Vec<f64> = op.windows(2).map(|two| (two[1] - two[0]).abs()).collect();
    let most = max(&moves);
    let at = moves.iter().filter(|m| **m > 0.999 * most).count();
    let moving = moves.iter().filter(|m| **m > 0.0).count();
    let resolved = moves.iter().filter(|m| **m > 0.0 && **m < 0.3 * most).count();
    // Rounded outputs have few sizes of steps; the largest is no limit then.
    (at >= 8 && at * 12 >= moving && resolved * 4 >= moving).then_some(most / step)
}

/// A structure of controller to try.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape {
    pub integral: bool,
    /// Share of its last value that the derivative keeps.
    pub derivative: Option<(f64, DerivativeOn)>,
    pub gap: f64,
    /// Whether the set point has a gain of its own.
    pub weighted: bool,
    pub delay: usize,
}

/// The signals in use.
pub(super) struct Record<'a> {
    pub op: &'a [f64],
    pub pv: Vec<f64>,
    pub sp: Option<Vec<f64>>,
    pub step: f64,
    pub sp_moves: bool,
    pub runs: Vec<Range<usize>>,
    pub low: Option<f64>,
    pub high: Option<f64>,
    pub rate: Option<f64>,
    pub quantum: f64,
    pub pv_quantum: f64,
}

impl<'a> Record<'a> {
    pub(super) fn of(
        op: &'a [f64],
        pv: Vec<f64>,
        sp: Option<Vec<f64>>,
        step: f64,
    ) -> Result<Self, Abstention> {
        let quantum = quantum(op);
        let low = limit(op, min(op), quantum);
        let high = limit(op, max(op), quantum);
        let rate = rate_limit(op, step);
        let bound = |k: usize| {
            [low, high]
                .into_iter()
                .flatten()
                .any(|limit| (op[k] - limit).abs() < 1e-9 + 0.5 * quantum)
                || k > 0 && rate.is_some_and(|rate| (op[k] - op[k - 1]).abs() > 0.999 * rate * step)
        };
        let (mut runs, mut from) = (vec![], 0);
        for k in 0..=op.len() {
            if k == op.len() || bound(k) {
                if k >= from + RUN {
                    runs.push(from..k);
                }
                from = k + 1;
            }
        }
        let free: usize = runs.iter().map(|run| run.len()).sum();
        if free < FEWEST_SAMPLES {
            return Err(Abstention(format!(
                "the OP is off its limits for {free} samples in runs of at least {RUN}; {FEWEST_SAMPLES} are needed"
            )));
        }
        let moves = |sp: &Vec<f64>| {
            let inside = runs.iter().flat_map(|run| run.clone().skip(1));
            inside.filter(|k| sp[*k] != sp[k - 1]).count() > 0
        };
        let sp_moves = sp.as_ref().is_some_and(moves);
        let pv_quantum = self::quantum(&pv);
        Ok(Self { op, pv, sp, step, sp_moves, runs, low, high, rate, quantum, pv_quantum })
    }

    /// The regressors of a structure over the whole record: proportional, its set point if weighted, integral,
    /// slope if the set point is unknown, derivative.
    pub(super) fn columns(&self, shape: Shape) -> Vec<Vec<f64>> {
        let n = self.op.len();
        let late =
            |x: &[f64]| -> Vec<f64> { (0..n).map(|k| x[k.saturating_sub(shape.delay)]).collect() };
        let pv = late(&self.pv);
        let sp = self.sp.as_deref().map(late);
        let middle = mean(&pv);
        let error: Vec<f64> = match &sp {
            Some(sp) => (0..n).map(|k| sp[k] - pv[k]).collect(),
            None => pv.iter().map(|v| middle - v).collect(),
        };
        let beyond: Vec<f64> = error.iter().map(|e| e - e.clamp(-shape.gap, shape.gap)).collect();
        let mut columns = vec![];
        match &sp {
            Some(sp) if shape.weighted => {
                columns.push(pv.iter().map(|v| middle - v).collect());
                columns.push(sp.iter().map(|v| v - middle).collect());
            }
            _ => columns.push(beyond.clone()),
        }
        if shape.integral {
            let mut whole = vec![0.0; n];
            for run in &self.runs {
                let mut sum = 0.0;
                for k in run.clone() {
                    sum += beyond[k];
                    whole[k] = self.step * sum;
                }
            }
            columns.push(whole);
            if sp.is_none() {
                let mut slope = vec![0.0; n];
                for run in &self.runs {
                    run.clone().for_each(|k| slope[k] = (k - run.start) as f64 * self.step);
                }
                columns.push(slope);
            }
        }
        if let Some((keep, on)) = shape.derivative {
            let w: Vec<f64> = match on {
                DerivativeOn::Error => beyond,
                DerivativeOn::Pv => pv.iter().map(|v| -v).collect(),
            };
            let mut derived = vec![0.0; n];
            for run in &self.runs {
                for k in run.start + 1..run.end {
                    derived[k] =
                        keep * derived[k - 1] + (1.0 - keep) * (w[k] - w[k - 1]) / self.step;
                }
            }
            columns.push(derived);
        }
        columns
    }
}
