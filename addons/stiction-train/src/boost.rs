//! Gradient boosting of trees on binned columns.
//!
//! Every round adds a tree (one for each class of a softmax) that is grown on the gradients of the loss at a random
//! part of the rows and columns, shrunk by the learning rate. It stops when the loss on unseen rows no longer falls,
//! and drops the rounds after the best one. The same seed gives the same bits on any number of threads. Rows and
//! columns are processed in parallel, but each sum has one order.
//!
//! Sources: J. H. Friedman, "Greedy function approximation: a gradient boosting machine", Ann. Stat. 29
//! (2001) 1189-1232; G. Ke et al., "LightGBM", NeurIPS 30 (2017) (both recalled, not read).

use crate::bins::Bins;
use crate::grow::{Limits, Tree};
use crate::random::Stream;
use anyhow::{Result, ensure};
use rayon::prelude::*;
use stiction_diagnose::fusion::{Ensemble, Node, sigmoid, softplus};

/// Number of rows that are processed together.
const CHUNK: usize = 4096;

/// The kind of target, and its loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Loss {
    /// A probability of 0 or 1: logistic loss; the margin is the logit.
    Logistic,
    /// One of this many classes, counted from 0: softmax with one margin per class.
    Softmax(usize),
    /// The quantile of that share: pinball loss; the margin is the quantile.
    Pinball(f64),
}

/// The data for learning.
pub struct Task<'a> {
    pub loss: Loss,
    /// The target of every row.
    pub target: &'a [f64],
    /// The weight of every row.
    pub weight: &'a [f64],
    /// The rows for learning, ascending.
    pub train: &'a [u32],
    /// The rows for stopping, ascending; without any, all rounds are kept.
    pub stop: &'a [u32],
    /// The columns in use, ascending.
    pub columns: &'a [usize],
    /// For each column of all: 1 if the margin must not fall with it, -1 if not rise, 0 if free. Not for quantiles,
    /// whose leaves are computed again.
    pub monotone: &'a [i8],
}

/// Settings of the learning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoostOptions {
    /// The most rounds.
    pub rounds: usize,
    /// Learning rate.
    pub rate: f64,
    /// Limits of trees.
    pub limits: Limits,
    /// Share of the rows in a round.
    pub rows: f64,
    /// Share of the columns in a tree.
    pub columns: f64,
    /// Rounds without a lower loss after which it stops.
    pub patience: usize,
    pub seed: u64,
}

/// The result of learning.
#[derive(Debug, Clone, PartialEq)]
pub struct Boosted {
    /// A sum of trees for each margin.
    pub ensembles: Vec<Ensemble>,
    /// Total gain of the splits by each column.
    pub gains: Vec<f64>,
    /// Mean loss on the stopping rows, or on the training rows if no stopping rows are given.
    pub loss: f64,
    /// Number of kept rounds.
    pub rounds: usize,
}

/// Learns.
///
/// # Errors
/// If there is no data, or a target is not finite or invalid for the loss.
pub fn boost(bins: &Bins, task: &Task<'_>, options: &BoostOptions) -> Result<Boosted> {
    task.check(bins)?;
    let n = task.target.len();
    let outputs = task.loss.outputs();
    let bases = task.bases();
    // Margins of the rows for learning, then of those for stopping.
    let rows: Vec<u32> = task.train.iter().chain(task.stop).copied().collect();
    let mut margins: Vec<Vec<f64>> = bases.iter().map(|base| vec![*base; n]).collect();
    let judged = if task.stop.is_empty() { task.train } else { task.stop };
    let (mut best_loss, mut best_round) = (task.mean_loss(judged, &margins), 0);
    let mut gains: Vec<Vec<f64>> = vec![];
    let mut kept: Vec<Vec<Vec<Node>>> = vec![vec![]; outputs];
    for round in 0..options.rounds {
        let mut stream = Stream::new(options.seed, round as u64);
        let sample = stream.keep(task.train, options.rows);
        let mut gained = vec![0.0; bins.columns()];
        // All gradients first: the classes of a softmax change together.
        let gradients: Vec<Vec<(f32, f32)>> =
            (0..outputs).map(|output| task.gradients(output, &margins)).collect();
        for (output, gradients) in gradients.iter().enumerate() {
            let mut columns = stream.keep(task.columns, options.columns);
            if columns.is_empty() {
                columns = task.columns.to_vec();
            }
            let limits = &options.limits;
            let mut tree = Tree::grow(
                bins,
                gradients,
                sample.clone(),
                &columns,
                task.monotone,
                limits,
                &mut gained,
            );
            let now = &margins[output];
            tree.revalue(|rows, value| {
                let value = match task.loss {
                    Loss::Pinball(share) => task.residual_quantile(rows, now, share),
                    _ => f64::from(value),
                };
                (options.rate * value) as f32
            });
            add(&mut margins[output], &tree, bins, &rows);
            kept[output].push(tree.nodes(bins));
        }
        gains.push(gained);
        let loss = task.mean_loss(judged, &margins);
        if loss < best_loss {
            (best_loss, best_round) = (loss, round + 1);
        } else if !task.stop.is_empty() && round + 1 - best_round >= options.patience {
            break;
        }
    }
    let rounds = if task.stop.is_empty() { kept[0].len() } else { best_round };
    let ensembles: Vec<Ensemble> = bases
        .iter()
        .zip(&kept)
        .map(|(base, trees)| Ensemble::new(*base, &trees[..rounds]))
        .collect::<stiction_model::Result<_>>()?;
    let gains = (0..bins.columns())
        .map(|column| gains[..rounds].iter().map(|gained| gained[column]).sum())
        .collect();
    Ok(Boosted { ensembles, gains, loss: best_loss, rounds })
}

/// Adds the output of a tree to the margins of some rows.
fn add(margins: &mut [f64], tree: &Tree, bins: &Bins, rows: &[u32]) {
    let values: Vec<f32> =
        rows.par_iter().with_min_len(CHUNK).map(|row| tree.value(bins, *row)).collect();
    for (row, value) in rows.iter().zip(values) {
        margins[*row as usize] += f64::from(value);
    }
}

impl Loss {
    fn outputs(self) -> usize {
        match self {
            Self::Softmax(classes) => classes,
            _ => 1,
        }
    }
}

impl Task<'_> {
    fn check(&self, bins: &Bins) -> Result<()> {
        ensure!(!self.train.is_empty(), "there are no rows to learn from");
        ensure!(self.weight.len() == self.target.len(), "not every row has a weight");
        ensure!(self.monotone.len() == bins.columns(), "not every column has a direction");
        ensure!(!self.columns.is_empty(), "there are no columns to learn from");
        for row in self.train.iter().chain(self.stop) {
            let (y, w) = (self.target[*row as usize], self.weight[*row as usize]);
            let fits = match self.loss {
                Loss::Logistic => (0.0..=1.0).contains(&y),
                Loss::Softmax(classes) => y >= 0.0 && y.fract() == 0.0 && y < classes as f64,
                Loss::Pinball(_) => y.is_finite(),
            };
            ensure!(fits && w.is_finite() && w > 0.0, "row {row} has target {y} and weight {w}");
        }
        Ok(())
    }

    /// The initial margins, with the smallest loss of a model without columns.
    fn bases(&self) -> Vec<f64> {
        let total: f64 = self.train.iter().map(|row| self.weight[*row as usize]).sum();
        // A class that never occurs has a finite base.
        let share = |is: &dyn Fn(f64) -> f64| {
            let rows = self.train.iter().map(|row| *row as usize);
            let sum: f64 = rows.map(|row| self.weight[row] * is(self.target[row])).sum();
            (sum / total).clamp(1e-6, 1.0 - 1e-6)
        };
        match self.loss {
            Loss::Logistic => {
                let p = share(&|y| y);
                vec![(p / (1.0 - p)).ln()]
            }
            Loss::Softmax(classes) => {
                (0..classes).map(|class| share(&|y| f64::from(y == class as f64)).ln()).collect()
            }
            Loss::Pinball(tau) => {
                let none = vec![0.0; self.target.len()];
                vec![self.residual_quantile(self.train, &none, tau)]
            }
        }
    }

    /// The weighted quantile of the residual targets of some rows.
    fn residual_quantile(&self, rows: &[u32], margins: &[f64], share: f64) -> f64 {
        let mut residuals: Vec<(f64, f64)> = rows
            .iter()
            .map(|row| *row as usize)
            .map(|row| (self.target[row] - margins[row], self.weight[row]))
            .collect();
        residuals.sort_by(|a, b| a.0.total_cmp(&b.0));
        let wanted = share * residuals.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut below = 0.0;
        for (residual, weight) in &residuals {
            below += weight;
            if below >= wanted {
                return *residual;
            }
        }
        residuals.last().map_or(0.0, |(residual, _)| *residual)
    }

    /// First and second derivative of the loss by a margin, at every row for learning.
    fn gradients(&self, output: usize, margins: &[Vec<f64>]) -> Vec<(f32, f32)> {
        let of = |row: usize| {
            let (y, w) = (self.target[row], self.weight[row]);
            let (g, h) = match self.loss {
                Loss::Logistic => {
                    let p = sigmoid(margins[0][row]);
                    (p - y, p * (1.0 - p))
                }
                Loss::Softmax(classes) => {
                    let p = softmax(margins, row, output);
                    let hit = f64::from(y == output as f64);
                    // The other margins can compensate for one: K / (K - 1) of the plain curvature.
                    let k = classes as f64;
                    (p - hit, p * (1.0 - p) * k / (k - 1.0).max(1.0))
                }
                Loss::Pinball(tau) => (if y > margins[0][row] { -tau } else { 1.0 - tau }, 1.0),
            };
            ((w * g) as f32, (w * h) as f32)
        };
        let gradients: Vec<(f32, f32)> =
            self.train.par_iter().with_min_len(CHUNK).map(|row| of(*row as usize)).collect();
        let mut all = vec![(0.0, 0.0); self.target.len()];
        for (row, gradient) in self.train.iter().zip(gradients) {
            all[*row as usize] = gradient;
        }
        all
    }

    /// The weighted mean loss at some rows.
    fn mean_loss(&self, rows: &[u32], margins: &[Vec<f64>]) -> f64 {
        let of = |row: usize| {
            let y = self.target[row];
            match self.loss {
                Loss::Logistic => softplus(margins[0][row]) - y * margins[0][row],
                Loss::Softmax(_) => -softmax(margins, row, y as usize).max(1e-300).ln(),
                Loss::Pinball(tau) => {
                    let residual = y - margins[0][row];
                    if residual > 0.0 { tau * residual } else { (tau - 1.0) * residual }
                }
            }
        };
        let sums: Vec<(f64, f64)> = rows
            .par_chunks(CHUNK)
            .map(|rows| {
                rows.iter().map(|row| *row as usize).fold((0.0, 0.0), |(loss, weight), row| {
                    (loss + self.weight[row] * of(row), weight + self.weight[row])
                })
            })
            .collect();
        let (loss, weight) =
            sums.iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        loss / weight
    }
}

/// The probability of a class at a row.
fn softmax(margins: &[Vec<f64>], row: usize, class: usize) -> f64 {
    let largest = margins.iter().map(|each| each[row]).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = margins.iter().map(|each| (each[row] - largest).exp()).sum();
    (margins[class][row] - largest).exp() / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_diagnose::fusion::row;

    const OPTIONS: BoostOptions = BoostOptions {
        rounds: 200,
        rate: 0.1,
        limits: Limits { leaves: 8, least_weight: 5.0, l2: 1.0 },
        rows: 0.8,
        columns: 0.9,
        patience: 20,
        seed: 3,
    };

    /// Uniform columns and a target of them and of noise.
    struct Made {
        columns: Vec<Vec<f32>>,
        target: Vec<f64>,
        weight: Vec<f64>,
        monotone: Vec<i8>,
    }

    impl Made {
        fn new(rows: usize, columns: usize, target: impl Fn(&[f64], &mut Stream) -> f64) -> Self {
            let mut stream = Stream::new(11, 0);
            let mut made = Self {
                columns: vec![vec![]; columns],
                target: vec![],
                weight: vec![1.0; rows],
                monotone: vec![0; columns],
            };
            for _ in 0..rows {
                let x: Vec<f64> = (0..columns).map(|_| stream.unit()).collect();
                made.target.push(target(&x, &mut stream));
                made.columns.iter_mut().zip(x).for_each(|(column, x)| column.push(x as f32));
            }
            made
        }

        /// Learns from three of four rows; the rest is there to stop by.
        fn boost(&self, loss: Loss, options: &BoostOptions) -> Boosted {
            let rows: Vec<u32> = (0..self.target.len() as u32).collect();
            let (stop, train): (Vec<u32>, Vec<u32>) = rows.iter().partition(|row| *row % 4 == 0);
            let columns: Vec<usize> = (0..self.columns.len()).collect();
            let task = Task {
                loss,
                target: &self.target,
                weight: &self.weight,
                train: &train,
                stop: &stop,
                columns: &columns,
                monotone: &self.monotone,
            };
            boost(&Bins::new(&self.columns, &train), &task, options).unwrap()
        }
    }

    #[test]
    fn finds_a_step() {
        let made = Made::new(4000, 3, |x, _| if x[1] > 0.6 { 2.0 } else { -1.0 });
        let boosted = made.boost(Loss::Pinball(0.5), &OPTIONS);
        for (x, expected) in [(0.3, -1.0), (0.59, -1.0), (0.61, 2.0), (0.9, 2.0)] {
            let found = boosted.ensembles[0].margin(&row(&[0.5, x, 0.5]));
            assert!((found - expected).abs() < 0.01, "{x}: {found}");
        }
        // Before it is found there is something to gain, from one column.
        let early =
            made.boost(Loss::Pinball(0.5), &BoostOptions { rounds: 5, columns: 1.0, ..OPTIONS });
        assert!(early.gains[1] > 20.0 * (early.gains[0] + early.gains[2]), "{:?}", early.gains);
    }

    #[test]
    fn finds_a_sum_of_functions() {
        let logit = |x: &[f64]| 3.0 * (6.0 * x[0]).sin() + 4.0 * (x[1] - 0.5);
        let made = Made::new(20_000, 4, |x, stream| f64::from(stream.unit() < sigmoid(logit(x))));
        let boosted = made.boost(Loss::Logistic, &OPTIONS);
        let mut stream = Stream::new(1, 1);
        let errors = (0..500).map(|_| {
            let x: Vec<f64> = (0..4).map(|_| stream.unit()).collect();
            (sigmoid(boosted.ensembles[0].margin(&row(&x))) - sigmoid(logit(&x))).abs()
        });
        let mean = errors.sum::<f64>() / 500.0;
        assert!(mean < 0.04, "{mean}");
    }

    #[test]
    fn tells_classes_apart() {
        let made = Made::new(6000, 2, |x, _| (3.0 * x[0]).floor());
        let boosted = made.boost(Loss::Softmax(3), &OPTIONS);
        for (x, class) in [(0.1, 0), (0.5, 1), (0.9, 2)] {
            let margins = boosted.ensembles.iter().map(|trees| vec![trees.margin(&row(&[x, 0.5]))]);
            let p = softmax(&margins.collect::<Vec<_>>(), 0, class);
            assert!(p > 0.95, "{x}: {p}");
        }
    }

    #[test]
    fn what_is_monotone_never_falls() {
        // The truth falls; what is learned may not.
        let mut made = Made::new(6000, 3, |x, stream| {
            let logit = 4.0 * x[1] - 5.0 * (x[0] - 0.5).abs() + 2.0 * x[2] * x[0];
            f64::from(stream.unit() < sigmoid(logit))
        });
        for column in &mut made.columns {
            column.iter_mut().step_by(7).for_each(|x| *x = f32::NAN);
        }
        made.monotone = vec![1, -1, 0];
        let ensemble = &made.boost(Loss::Logistic, &OPTIONS).ensembles[0];
        let mut stream = Stream::new(5, 5);
        let mut moved = 0;
        for _ in 0..3000 {
            let mut x: Vec<f64> = (0..3).map(|_| stream.unit()).collect();
            x.iter_mut().for_each(|x| {
                if stream.unit() < 0.1 {
                    *x = f64::NAN
                }
            });
            let (from, to) = (stream.unit(), stream.unit());
            let at = |column: usize, value: f64| {
                let mut x = x.clone();
                x[column] = value;
                ensemble.margin(&row(&x))
            };
            let (low, high) = (from.min(to), from.max(to));
            assert!(at(0, low) <= at(0, high) + 1e-6, "{x:?} {low} {high}");
            assert!(at(1, low) >= at(1, high) - 1e-6, "{x:?} {low} {high}");
            moved += usize::from(at(0, low) < at(0, high));
        }
        assert!(moved > 300, "{moved}");
    }

    #[test]
    fn learns_where_missing_values_go() {
        for sticky_is_missing in [true, false] {
            let mut made = Made::new(4000, 2, |x, _| f64::from(x[0] > 0.7));
            // Where the truth is 1 (or 0), half of the values are missing.
            for k in (0..4000).step_by(2) {
                if (made.target[k] == 1.0) == sticky_is_missing {
                    made.columns[0][k] = f32::NAN;
                }
            }
            let trees = &made.boost(Loss::Logistic, &OPTIONS).ensembles[0];
            let margin = trees.margin(&row(&[f64::NAN, 0.5]));
            assert!(if sticky_is_missing { margin > 2.0 } else { margin < -2.0 }, "{margin}");
        }
    }

    #[test]
    fn missing_alone_is_enough() {
        let mut made = Made::new(4000, 1, |_, stream| stream.unit().round());
        for k in 0..4000 {
            if made.target[k] == 1.0 {
                made.columns[0][k] = f32::NAN;
            }
        }
        let trees = &made.boost(Loss::Logistic, &OPTIONS).ensembles[0];
        assert!(trees.margin(&row(&[f64::NAN])) > 2.0);
        assert!(trees.margin(&row(&[0.1])) < -2.0 && trees.margin(&row(&[0.9])) < -2.0);
    }

    #[test]
    fn quantiles_cover() {
        // Noise that grows: uniform, of half-width 0.2 to 1.2.
        let truth = |x: &[f64], stream: &mut Stream| {
            2.0 * x[0] + (0.2 + x[1]) * (2.0 * stream.unit() - 1.0)
        };
        let made = Made::new(12_000, 2, truth);
        let mut stream = Stream::new(8, 8);
        let fresh: Vec<(Vec<f64>, f64)> = (0..4000)
            .map(|_| {
                let x: Vec<f64> = (0..2).map(|_| stream.unit()).collect();
                let y = truth(&x, &mut stream);
                (x, y)
            })
            .collect();
        for tau in [0.05, 0.5, 0.95] {
            let trees = &made.boost(Loss::Pinball(tau), &OPTIONS).ensembles[0];
            let below = |part: &dyn Fn(&[f64]) -> bool| {
                let part: Vec<_> = fresh.iter().filter(|(x, _)| part(x)).collect();
                let below = part.iter().filter(|(x, y)| *y <= trees.margin(&row(x))).count();
                below as f64 / part.len() as f64
            };
            // Where noise is small as well as where it is large.
            for share in [below(&|x| x[1] < 0.5), below(&|x| x[1] >= 0.5)] {
                assert!((share - tau).abs() < 0.04, "{tau}: {share}");
            }
        }
    }

    #[test]
    fn threads_change_no_bit() {
        let made =
            Made::new(9000, 5, |x, stream| (3.0 * x[0] * x[1] + stream.unit()).floor().min(2.0));
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = BoostOptions { rounds: 20, ..OPTIONS };
            pool.install(|| made.boost(Loss::Softmax(3), &options))
        };
        assert_eq!(on(1), on(2));
        assert_eq!(on(1), on(5));
    }

    #[test]
    fn weights_count_as_repetitions() {
        let made = Made::new(3000, 2, |x, stream| f64::from(stream.unit() < x[0]));
        let rows: Vec<u32> = (0..3000).collect();
        let doubled: Vec<f64> = (0..3000).map(|k| if k % 3 == 0 { 2.0 } else { 1.0 }).collect();
        let twice: Vec<usize> =
            (0..3000).flat_map(|k| vec![k; if k % 3 == 0 { 2 } else { 1 }]).collect();
        let options = BoostOptions { rounds: 10, rows: 1.0, columns: 1.0, ..OPTIONS };
        let learn = |columns: &[Vec<f32>], target: &[f64], weight: &[f64]| {
            let train: Vec<u32> = (0..target.len() as u32).collect();
            let task = Task {
                loss: Loss::Logistic,
                target,
                weight,
                train: &train,
                stop: &[],
                columns: &[0, 1],
                monotone: &[0, 0],
            };
            let bins = Bins::new(columns, &rows);
            boost(&bins, &task, &options).unwrap().loss
        };
        let weighted = learn(&made.columns, &made.target, &doubled);
        let order = |x: &[f32]| twice.iter().map(|k| x[*k]).collect::<Vec<f32>>();
        let repeated_columns: Vec<Vec<f32>> = made.columns.iter().map(|c| order(c)).collect();
        let repeated_target: Vec<f64> = twice.iter().map(|k| made.target[*k]).collect();
        let repeated = learn(&repeated_columns, &repeated_target, &vec![1.0; twice.len()]);
        assert!((weighted - repeated).abs() < 0.005, "{weighted} {repeated}");
    }

    #[test]
    fn what_cannot_be_learned_from_is_refused() {
        let bins = Bins::new(&[vec![0.0, 1.0]], &[0, 1]);
        let ask = |target: &[f64], train: &[u32]| {
            let task = Task {
                loss: Loss::Logistic,
                target,
                weight: &[1.0, 1.0],
                train,
                stop: &[],
                columns: &[0],
                monotone: &[0],
            };
            boost(&bins, &task, &OPTIONS)
        };
        assert!(ask(&[0.0, 1.0], &[0, 1]).is_ok());
        assert!(ask(&[0.0, 1.0], &[]).is_err());
        assert!(ask(&[0.0, f64::NAN], &[0, 1]).is_err());
        assert!(ask(&[0.0, 2.0], &[0, 1]).is_err());
    }
}
