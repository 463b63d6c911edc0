//! How far each turn of the OP moved the PV, without a valve model. The fit has a linear process of unknown lag and
//! dead time, a wandering load and sensor noise.
//!
//! # Equations
//! ```text
//! y(k) = c + b k + sum_i a_i h(k - k_i) + n(k),    n(k) = p1 n(k-1) + ... + pm n(k-m) + e(k),   m = 1, 2, 4
//! h = L_T2 L_T1 step, d samples late,    L_T: z(k) = z(k-1) + (1 - e^(-1/T)) (x(k) - z(k-1))
//! ```
//! Each time in manual has its own c and b. An integrating process has a sum instead of the first lag. Both sides are
//! filtered until the noise is white. Then least squares gives the a_i and their covariance. A valve changes only the
//! a_i, so they hold all information of the test about the valve.

use crate::numeric::least_squares::dot;
use nalgebra::{Cholesky, DMatrix, DVector};

/// A time in manual: its PV, and the samples at which the OP was turned.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spell {
    pub pv: Vec<f64>,
    pub turns: Vec<usize>,
}

/// A linear process without its gain. Times are in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Process {
    /// The first lag; infinite for an integrating process.
    pub tau: f64,
    /// The second lag.
    pub tau2: f64,
    pub dead: usize,
}

/// First lags to try, samples.
const TAU: [f64; 14] =
    [0.0, 0.6, 1.2, 2.0, 3.2, 5.0, 8.0, 13.0, 20.0, 32.0, 50.0, 80.0, 150.0, f64::INFINITY];
/// Second lags as a share of the first; for an integrating process, samples.
const TAU2: [f64; 3] = [0.0, 0.3, 1.0];
const TAU2_OF_INTEGRATOR: [f64; 4] = [0.0, 2.0, 6.0, 20.0];
/// Dead times, samples.
const DEAD: [usize; 14] = [0, 1, 2, 3, 4, 5, 7, 9, 12, 16, 22, 30, 40, 55];
/// Orders of the noise model to try.
const ORDERS: [usize; 3] = [1, 2, 4];
const LONGEST_PAST: usize = ORDERS[ORDERS.len() - 1];
/// Number of columns of a spell besides its turns: level and slope.
const BESIDE: usize = 2;

impl Process {
    /// The step response of the PV, sample by sample. That of an integrator rises by 1 per sample.
    pub fn step(&self, samples: usize) -> Vec<f64> {
        let mut answer: Vec<f64> =
            (0..samples).map(|k| f64::from(u8::from(k >= self.dead))).collect();
        match self.tau {
            tau if tau.is_infinite() => {
                let mut sum = 0.0;
                for x in &mut answer {
                    sum += *x;
                    *x = sum;
                }
            }
            tau => first_order(&mut answer, tau),
        }
        first_order(&mut answer, self.tau2);
        answer
    }

    /// All processes to try, with dead times up to `longest` samples.
    fn grid(longest: usize) -> Vec<Place> {
        let lags = |tau: f64| match () {
            () if tau.is_infinite() => TAU2_OF_INTEGRATOR.to_vec(),
            () if tau == 0.0 => vec![0.0],
            () => TAU2.map(|part| part * tau).to_vec(),
        };
        let dead = || DEAD.into_iter().filter(|d| *d <= longest.max(2)).enumerate();
        let mut all = vec![];
        for (i, tau) in TAU.into_iter().enumerate() {
            for (j, tau2) in lags(tau).into_iter().enumerate() {
                let of = |(k, dead)| Place { at: [i, j, k], process: Self { tau, tau2, dead } };
                all.extend(dead().map(of));
            }
        }
        all
    }
}

/// A process and its place in the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    at: [usize; 3],
    process: Process,
}

impl Place {
    /// Whether it is in the coarse grid that is tried first.
    fn is_first(&self) -> bool {
        let [tau, tau2, dead] = self.at;
        (tau % 2 == 1 || tau == 0) && tau2 % 2 == 0 && dead % 2 == 0
    }

    fn is_adjacent(&self, other: &Self) -> bool {
        self.at.iter().zip(&other.at).all(|(a, b)| a.abs_diff(*b) <= 1)
    }
}

fn first_order(x: &mut [f64], tau: f64) {
    if tau > 0.0 {
        let share = 1.0 - (-1.0 / tau).exp();
        let mut z = 0.0;
        for x in x {
            z += share * (*x - z);
            *x = z;
        }
    }
}

/// An autoregressive model of the disturbance: its coefficients.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Noise(Vec<f64>);

impl Noise {
    /// Number of past samples in the model.
    pub fn order(&self) -> usize {
        self.0.len()
    }

    /// The signal minus its prediction from the past. The signal is 0 before its first sample.
    pub fn whitened(&self, x: &[f64]) -> Vec<f64> {
        let past = |k: usize| -> f64 {
            let latest = &x[k.saturating_sub(self.0.len())..k];
            self.0.iter().zip(latest.iter().rev()).map(|(a, x)| a * x).sum()
        };
        (0..x.len()).map(|k| x[k] - past(k)).collect()
    }

    /// The model that predicts these series best, by the information criterion of Schwarz.
    fn of(series: &[Vec<f64>]) -> Self {
        let mut gram = DMatrix::<f64>::zeros(LONGEST_PAST + 1, LONGEST_PAST + 1);
        let mut samples = 0.0;
        for x in series.iter().filter(|x| x.len() > LONGEST_PAST) {
            let n = x.len();
            samples += (n - LONGEST_PAST) as f64;
            for i in 0..=LONGEST_PAST {
                for j in i..=LONGEST_PAST {
                    let (a, b) = (&x[LONGEST_PAST - i..n - i], &x[LONGEST_PAST - j..n - j]);
                    gram[(i, j)] += a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                }
            }
        }
        let floor = 1e-9 * gram[(0, 0)].max(f64::MIN_POSITIVE);
        let mut best = (f64::INFINITY, vec![]);
        for order in ORDERS {
            let own = DMatrix::from_fn(order, order, |i, j| {
                let (i, j) = (i.min(j) + 1, i.max(j) + 1);
                gram[(i, j)] + if i == j { floor } else { 0.0 }
            });
            let with = DVector::from_fn(order, |i, _| gram[(0, i + 1)]);
            let Some(factor) = Cholesky::new(own) else { continue };
            let past = factor.solve(&with);
            let left = (gram[(0, 0)] - past.dot(&with)).max(floor);
            let criterion = samples * left.ln() + order as f64 * samples.max(2.0).ln();
            if criterion < best.0 {
                best = (criterion, past.iter().copied().collect());
            }
        }
        Self(best.1)
    }
}

/// How far each turn moved the PV, given one process.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Answers {
    pub process: Process,
    /// For each spell, the answers by turn in PV units (per sample for an integrator), and the inverse of their
    /// covariance without the error variance.
    pub spells: Vec<(DVector<f64>, DMatrix<f64>)>,
    /// Residual sum of squares.
    pub left: f64,
    pub noise: Noise,
}

impl Answers {
    /// The answers of the spells, given a process and a noise model, with which they are whitened.
    fn of(spells: &[White<'_>], process: Process, noise: &Noise) -> Option<Self> {
        let longest = spells.iter().map(|white| white.pv.len()).max()?;
        let step = noise.whitened(&process.step(longest));
        let mut all = vec![];
        let mut left = 0.0;
        for white in spells {
            let (gram, products, square) = white.normal(&step);
            let of_turns = white.turns.len();
            let factor = Cholesky::new(gram.clone())?;
            let found = factor.solve(&products);
            left += (square - found.dot(&products)).max(0.0);
            // Information on the turns with unknown level and slope.
            let (a, b) = (
                gram.view((0, 0), (of_turns, of_turns)),
                gram.view((0, of_turns), (of_turns, BESIDE)),
            );
            let d = gram.view((of_turns, of_turns), (BESIDE, BESIDE)).into_owned();
            let information = a - b * Cholesky::new(d)?.solve(&b.transpose());
            all.push((found.rows(0, of_turns).into_owned(), information));
        }
        Some(Self { process, spells: all, left, noise: noise.clone() })
    }

    /// The PV of each spell minus its answers.
    fn residual(&self, spells: &[Spell]) -> Vec<Vec<f64>> {
        let longest = spells.iter().map(|spell| spell.pv.len()).max().unwrap_or(0);
        let step = self.process.step(longest);
        let of = |(spell, (answers, _)): (&Spell, &(DVector<f64>, DMatrix<f64>))| {
            let mut left = spell.pv.clone();
            for (at, answer) in spell.turns.iter().zip(answers.iter()) {
                left[*at..].iter_mut().zip(&step).for_each(|(y, h)| *y -= answer * h);
            }
            crate::series::detrended(&left)
        };
        spells.iter().zip(&self.spells).map(of).collect()
    }
}

/// A spell, whitened by a noise model, with the quantities that do not depend on the process.
struct White<'a> {
    turns: &'a [usize],
    pv: Vec<f64>,
    /// First sample that is predicted.
    from: usize,
    /// Level and slope, whitened, by sample.
    level: f64,
    slope: Vec<f64>,
    /// Pairs of turns, sorted: samples between them, the first sample after the later one that counts, their number, and the
    /// indices of the earlier and the later one.
    pairs: Vec<(usize, usize, usize, usize, usize)>,
}

impl<'a> White<'a> {
    fn of(spell: &'a Spell, noise: &Noise) -> Self {
        let (n, from) = (spell.pv.len(), noise.0.len());
        let level = 1.0 - noise.0.iter().sum::<f64>();
        let slip: f64 = (1..).zip(&noise.0).map(|(lag, a)| f64::from(lag) * a).sum();
        let slope = (0..n).map(|k| (level * (k as f64 - 0.5 * n as f64) + slip) / n as f64);
        let mut pairs = vec![];
        for (j, later) in spell.turns.iter().enumerate() {
            for (i, at) in spell.turns[..=j].iter().enumerate() {
                pairs.push((later - at, from.saturating_sub(*later), n - later, i, j));
            }
        }
        pairs.sort_unstable();
        let (pv, slope) = (noise.whitened(&spell.pv), slope.collect());
        Self { turns: &spell.turns, pv, from, level, slope, pairs }
    }

    /// The normal equations for a whitened step response, with a column for each turn, then level and slope; and the sum of
    /// squares of the PV.
    fn normal(&self, step: &[f64]) -> (DMatrix<f64>, DVector<f64>, f64) {
        let (n, turns, level) = (self.pv.len(), self.turns.len(), self.level);
        let columns = turns + BESIDE;
        let mut gram = DMatrix::zeros(columns, columns);
        let mut products = DVector::zeros(columns);
        for (i, at) in self.turns.iter().enumerate() {
            let first = self.from.max(*at).min(n);
            let step = &step[first - at.min(&first)..][..n - first];
            products[i] = dot(step, &self.pv[first..]);
            gram[(i, turns)] = level * step.iter().sum::<f64>();
            gram[(i, turns + 1)] = dot(step, &self.slope[first..]);
        }
        // All turns have the same response, so the product of two is a sum that depends only on the time between them. Of
        // pairs with the same time, the earlier one needs more of the same sum.
        for same in self.pairs.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (lag, mut since, mut sum) = (same[0].0, same[0].1, 0.0);
            for (_, _, until, i, j) in same {
                if since < *until {
                    sum += dot(&step[since + lag..until + lag], &step[since..*until]);
                    since = *until;
                }
                gram[(*i, *j)] = sum;
            }
        }
        let from = self.from.min(n);
        let (pv, slope) = (&self.pv[from..], &self.slope[from..]);
        products[turns] = level * pv.iter().sum::<f64>();
        products[turns + 1] = dot(slope, pv);
        gram[(turns, turns)] = level * level * pv.len() as f64;
        gram[(turns, turns + 1)] = level * slope.iter().sum::<f64>();
        gram[(turns + 1, turns + 1)] = dot(slope, slope);
        for i in 0..columns {
            for j in 0..i {
                gram[(i, j)] = gram[(j, i)];
            }
            // A small ridge keeps the matrix regular if a column is 0.
            gram[(i, i)] += 1e-9 * gram[(i, i)] + 1e-12;
        }
        (gram, products, dot(pv, pv))
    }
}

/// Number of best processes whose neighbours are tried.
const BEST: usize = 4;

/// The answers for all processes tried, the likeliest first, and the standard deviation of the prediction error.
pub(super) fn answers(spells: &[Spell], longest_dead: usize) -> Option<(Vec<Answers>, f64)> {
    let grid = Process::grid(longest_dead);
    let (first, others): (Vec<Place>, Vec<Place>) = grid.into_iter().partition(Place::is_first);
    let start: Vec<Vec<f64>> =
        spells.iter().map(|spell| crate::series::detrended(&spell.pv)).collect();
    let mut noise = Noise::of(&start);
    let mut all: Vec<(Place, Answers)> = vec![];
    let tried = |places: &[Place], noise: &Noise| -> Vec<(Place, Answers)> {
        let white: Vec<White<'_>> = spells.iter().map(|spell| White::of(spell, noise)).collect();
        let of = |place: &Place| Some((*place, Answers::of(&white, place.process, noise)?));
        places.iter().filter_map(of).collect()
    };
    let sort = |all: &mut Vec<(Place, Answers)>| {
        all.sort_by(|a, b| a.1.left.total_cmp(&b.1.left));
    };
    for _ in 0..3 {
        all = tried(&first, &noise);
        sort(&mut all);
        noise = Noise::of(&all.first()?.1.residual(spells));
    }
    // Neighbours of the best processes, until none is left.
    let mut others = others;
    loop {
        let best: Vec<Place> = all.iter().take(BEST).map(|(place, _)| *place).collect();
        let (near, far): (Vec<Place>, Vec<Place>) =
            others.into_iter().partition(|place| best.iter().any(|b| b.is_adjacent(place)));
        if near.is_empty() {
            break;
        }
        all.extend(tried(&near, &all[0].1.noise.clone()));
        sort(&mut all);
        others = far;
    }
    let all: Vec<Answers> = all.into_iter().map(|(_, answers)| answers).collect();
    let columns: usize = spells.iter().map(|spell| spell.turns.len() + BESIDE).sum();
    let samples: usize =
        spells.iter().map(|spell| spell.pv.len().saturating_sub(LONGEST_PAST)).sum();
    let freedom = (samples as f64 - columns as f64 - 3.0).max(1.0);
    let error = (all.first()?.left / freedom).sqrt();
    Some((all, error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    #[test]
    fn normal_equations_are_those_of_a_column_for_each_turn() {
        let mut draw = NormalStream::new(5);
        let pv: Vec<f64> = (0..90).map(|_| draw.draw()).collect();
        let process = Process { tau: 3.2, tau2: 1.0, dead: 1 };
        for (turns, noise) in [(vec![0, 2, 9, 16, 23, 23, 40, 61], 4), (vec![0, 30, 60], 1)] {
            let noise = Noise((1..=noise).map(|lag| 0.5 / f64::from(lag)).collect());
            let step = noise.whitened(&process.step(100));
            let spell = Spell { pv: pv.clone(), turns };
            let (gram, products, square) = White::of(&spell, &noise).normal(&step);
            let whole = |x: Vec<f64>| noise.whitened(&x)[noise.order()..].to_vec();
            let n = pv.len();
            let mut columns: Vec<Vec<f64>> = spell
                .turns
                .iter()
                .map(|at| {
                    let late = std::iter::repeat_n(0.0, *at).chain(process.step(n));
                    whole(late.take(n).collect())
                })
                .collect();
            columns.push(whole(vec![1.0; n]));
            columns.push(whole((0..n).map(|k| k as f64 / n as f64 - 0.5).collect()));
            let y = whole(pv.clone());
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let close = |a: f64, b: f64| (a - b).abs() < 1e-6 * (1.0 + b.abs());
            assert!(close(square, dot(&y, &y)));
            for (i, a) in columns.iter().enumerate() {
                assert!(close(products[i], dot(a, &y)), "{i}");
                for (j, b) in columns.iter().enumerate() {
                    assert!(
                        close(gram[(i, j)], dot(a, b)),
                        "{i} {j}: {} {}",
                        gram[(i, j)],
                        dot(a, b)
                    );
                }
            }
        }
    }
}
