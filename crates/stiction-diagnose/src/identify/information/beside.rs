//! What the stem of a sticking valve says of the PV beside the OP.
//!
//! # What it measures
//! By how many nats the PV becomes likelier if the stem of a valve that sticks stands in the regression beside the OP,
//! not in its place. The OP stays because it holds the PV through the controller: of moments that the record lacks,
//! and by the integral of long ago. In its place a true stem often loses.
//!
//! # Equations
//! With the columns of [`super`] for a valve that follows, and the taps V of a stem:
//! ```text
//! gain     = n/2 ln((SSE + f) / (SSE - r' Q^-1 r + f)),   Q = V'V - V'X (X'X)^-1 X'V,  r = V'e
//! robust   = n/N sum of l(e with V) - l(e),               l of Student's t with 4 degrees of freedom
//! lacks    = n/2 ln((SSE of V in the OP's place + f) / (SSE of both + f))
//! evidence = ln of the mean of exp(gain) over all valves of the grid: the prior is uniform in ln S and in J
//! placebo  = the largest gain of the same valves under the OP reversed in time, and turned back
//! curve    = gain of the squared OP, as of a process whose gain changes
//! ```
//! A row counts the less the larger the errors of a valve that follows are around it, and the less again if its own is far
//! larger than those, as by Student's t: bursts and outliers must not choose the stem. The best valve of the grid is refined in three rounds about the [`KEPT_BEST`] best of it.
//!
//! # Limits
//! A load that jumps is explained by some stem, too, and by as many of a placebo.

use super::{
    BLOCK, Candidate, LAGS, LONGEST, Lane, Problem, Products, STEPS, TAPS, Tried, Width,
    block_means, residual,
};
use crate::series::{median, std};
use crate::valve::Model;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Rows to either side that tell how noisy it is about one.
const AROUND: usize = 12;
/// Degrees of freedom of Student's t, by which a single large error counts less.
const FREEDOM: f64 = 4.0;
/// Valves of the grid about which finer ones are tried.
const KEPT_BEST: usize = 3;
/// Where a stem that slips seldom may stand at first, stick bands from the OP, beside at it.
const OTHER_PLACES: [f64; 2] = [-0.7, 0.7];
/// Factors of S and steps of J/S about them, round by round.
const ROUNDS: [([f64; 4], [f64; 4], usize); 3] = [
    ([0.76, 0.88, 1.14, 1.32], [-0.3, -0.1, 0.1, 0.3], KEPT_BEST),
    ([0.92, 0.97, 1.03, 1.08], [-0.15, -0.05, 0.05, 0.15], 2),
    ([0.975, 0.99, 1.01, 1.025], [-0.06, -0.02, 0.02, 0.06], 1),
];

/// What stems say of the PV beside the OP.
#[derive(Debug, Clone, PartialEq)]
pub struct Beside {
    /// Nats that the best stem gains.
    pub gain: f64,
    /// The same by a likelihood that forgives outliers.
    pub robust: f64,
    /// Standard errors of that, over blocks of instants.
    pub z: f64,
    /// The valve of that stem: model, S as a share of the OP's range, J as a share of S, slips.
    pub best: (Model, f64, f64, usize),
    /// Share of the PV's answer to a lasting change that comes from the stem; 1 if the OP adds nothing to it.
    pub share: f64,
    /// Log marginal likelihood of a valve of the grid, against one that follows, nats.
    pub evidence: f64,
    /// Nats that the best stem gains under the OP reversed in time.
    pub placebo: f64,
    /// Nats that the squared OP gains.
    pub curve: f64,
    /// Nats that the best stem gains beside the OP and the squared OP.
    pub beyond_curve: f64,
    /// The largest gain for each S of the grid, nats.
    pub profile: [f64; STEPS],
    /// What the OP gains beside the best stem, nats: little if the valve sticks so.
    pub lacks: f64,
    /// The least that the OP gains beside any stem of each S of the grid, nats: much refutes that S.
    pub refuted: [f64; STEPS],
}

/// Taps beside the columns: their products, once those of the columns are taken out.
struct Added {
    coefficients: DVector<f64>,
    drop: f64,
}

impl Problem {
    /// What the valves of the grid, and finer ones about the best, say beside the OP.
    pub(super) fn beside(&self, op: &[f64], pv: &[f64]) -> Beside {
        let weights = self.reliability();
        match Self::weighted(op, pv, self.op_range, self.factor, |_| weights) {
            Some(problem) => problem.searched(),
            None => self.searched(),
        }
    }

    /// The square root of how much each row counts, by the error of a valve that follows: less where errors are
    /// large for a while, and where one is far larger than those around it.
    fn reliability(&self) -> Vec<f64> {
        let sizes: Vec<f64> = self.error.iter().map(|e| e.abs()).collect();
        let typical = median(&sizes).max(1e-12);
        let n = sizes.len();
        (0..n)
            .map(|k| {
                let around = &sizes[k.saturating_sub(AROUND)..(k + AROUND + 1).min(n)];
                let scale = (0.5 * typical + 0.5 * median(around)) / 0.6745;
                let outlying = 1.0 + (sizes[k] / scale).powi(2) / FREEDOM;
                (typical / 0.6745) / (scale * outlying.sqrt())
            })
            .collect()
    }

    fn grid_of(&self, place: f64) -> Vec<Candidate> {
        let of = |(j, model)| super::grid().map(|s| Candidate { s, j, model, place });
        super::SHAPES.into_iter().flat_map(of).collect()
    }

    /// The valves of the grid; those that slip seldom with the stem where it fits best at first.
    fn on_grid(&self) -> Vec<Option<Tried>> {
        let all = self.grid_of(0.0);
        let mut on_grid = self.tried(&all);
        let seldom: Vec<usize> = (0..all.len())
            .filter(|k| on_grid[*k].as_ref().is_some_and(|t| t.slips < super::SELDOM))
            .collect();
        for place in OTHER_PLACES {
            let asked: Vec<Candidate> =
                seldom.iter().map(|k| Candidate { place, ..all[*k] }).collect();
            for (k, tried) in seldom.iter().zip(self.tried(&asked)) {
                let gain = |of: &Option<Tried>| of.as_ref().map_or(-1.0, |t| self.gain_beside(t));
                if gain(&tried) > gain(&on_grid[*k]) {
                    on_grid[*k] = tried;
                }
            }
        }
        on_grid
    }

    /// The best stem of the grid, or a finer one about the best of it, and its gain.
    fn refined(&self, mut on_grid: Vec<Option<Tried>>, gains: &[f64]) -> Option<(Tried, f64)> {
        let mut order: Vec<usize> = (0..gains.len()).filter(|k| on_grid[*k].is_some()).collect();
        order.sort_by(|a, b| gains[*b].total_cmp(&gains[*a]));
        let known = |k: &usize| Some((on_grid[*k].as_ref()?.candidate, gains[*k]));
        let mut best: Vec<(Candidate, f64)> =
            order.iter().take(KEPT_BEST).filter_map(known).collect();
        let mut winner: Option<(Tried, f64)> = None;
        for (factors, steps, kept) in ROUNDS {
            best.truncate(kept);
            let asked: Vec<Candidate> =
                best.iter().flat_map(|(about, _)| finer(*about, factors, steps)).collect();
            for tried in self.tried(&asked).into_iter().flatten() {
                let gain = self.gain_beside(&tried);
                best.push((tried.candidate, gain));
                if gain > winner.as_ref().map_or(0.0, |(_, largest)| *largest) {
                    winner = Some((tried, gain));
                }
            }
            best.sort_by(|a, b| b.1.total_cmp(&a.1));
        }
        let first = *order.first()?;
        match winner {
            Some((_, largest)) if largest >= gains[first] => winner,
            _ => on_grid[first].take().map(|tried| (tried, gains[first])),
        }
    }

    fn searched(&self) -> Beside {
        let on_grid = self.on_grid();
        let of = |tried: &Option<Tried>, f: fn(&Self, &Tried) -> f64| {
            tried.as_ref().map_or(0.0, |tried| f(self, tried))
        };
        let gains: Vec<f64> = on_grid.iter().map(|t| of(t, Self::gain_beside)).collect();
        let (mut profile, mut refuted) = ([0.0; STEPS], [f64::INFINITY; STEPS]);
        for (k, tried) in on_grid.iter().enumerate() {
            profile[k % STEPS] = gains[k].max(profile[k % STEPS]);
            refuted[k % STEPS] = of(tried, Self::lacks).min(refuted[k % STEPS]);
        }
        let most = gains.iter().copied().fold(0.0, f64::max);
        let sum: f64 = gains.iter().map(|gain| (gain - most).exp()).sum();
        let winner = self.refined(on_grid, &gains);
        let found = winner.as_ref().map(|(tried, _)| tried);
        let (curve, beyond_curve) = self.curve(found);
        let (robust, z, share) = found.map_or((0.0, 0.0, 0.0), |t| self.borne_out(t));
        let best = found.map_or((Model::TwoPhase, super::SMALLEST, 0.0, 0), |t| {
            let Candidate { s, j, model, .. } = t.candidate;
            (model, s, j, t.slips as usize)
        });
        Beside {
            gain: winner.as_ref().map_or(0.0, |(_, gain)| *gain),
            robust,
            z,
            best,
            share,
            evidence: most + (sum / gains.len().max(1) as f64).ln(),
            placebo: self.placebo(found.map(|t| t.candidate)),
            curve,
            beyond_curve,
            profile,
            lacks: found.map_or(0.0, |t| self.lacks(t)),
            refuted,
        }
    }

    /// What the OP gains beside a stem, nats.
    fn lacks(&self, tried: &Tried) -> f64 {
        let added = self.added(&tried.across, &tried.own, &tried.target);
        let both = self.follows.sse - added.map_or(0.0, |added| added.drop);
        self.nats(tried.fit.sse, tried.fit.sse - both)
    }

    fn added(
        &self,
        across: &DMatrix<f64>,
        own: &DMatrix<f64>,
        target: &DVector<f64>,
    ) -> Option<Added> {
        let mut left = own - across.transpose() * self.follows.factor.solve(across);
        for i in 0..left.nrows() {
            left[(i, i)] += 1e-6 * own[(i, i)] + 1e-10;
        }
        let products = target - across.transpose() * &self.follows.coefficients;
        let coefficients = Cholesky::new(left)?.solve(&products);
        let drop = products.dot(&coefficients);
        Some(Added { coefficients, drop })
    }

    fn gain_beside(&self, tried: &Tried) -> f64 {
        let added = self.added(&tried.across, &tried.own, &tried.target);
        added.map_or(0.0, |added| self.nats(self.follows.sse, added.drop))
    }

    fn nats(&self, sse: f64, drop: f64) -> f64 {
        let left = (sse - drop).max(0.0);
        let nats = 0.5 * self.independent * ((sse + self.floor) / (left + self.floor)).ln();
        // Stems that move alike gain the same but for rounding; which of them is first must not rest on that.
        if nats.is_finite() { (nats.max(0.0) * 1e6).round() / 1e6 } else { 0.0 }
    }

    /// Robust gain, its standard errors, and the stem's share of the lasting answer.
    fn borne_out(&self, tried: &Tried) -> (f64, f64, f64) {
        let Some(added) = self.added(&tried.across, &tried.own, &tried.target) else {
            return (0.0, 0.0, 0.0);
        };
        let moved = self.follows.factor.solve(&(&tried.across * &added.coefficients));
        let kept = &self.follows.coefficients - moved;
        let mut error = residual(&self.columns, &kept, &self.target);
        for (b, lag) in added.coefficients.iter().zip(LAGS) {
            let taps = &tried.stem[LONGEST + 1 - lag..];
            let taps = taps.iter().zip(&self.weights);
            error.iter_mut().zip(taps).for_each(|(e, (v, w))| *e -= b * w * v);
        }
        let width = 4.0 * self.scale * self.scale;
        let blocks = self.target.len() / BLOCK;
        let sums: Vec<f64> = (0..blocks)
            .map(|b| {
                let of = |e: &[f64]| -> f64 {
                    let block = &e[b * BLOCK..(b + 1) * BLOCK];
                    block.iter().map(|e| 1.0 + e * e / width).product::<f64>().ln()
                };
                2.5 * (of(&self.error) - of(&error))
            })
            .collect();
        let total: f64 = sums.iter().sum();
        let z = total / ((blocks as f64).sqrt() * std(&sums) + 1e-9);
        let of_stem: f64 = added.coefficients.iter().sum();
        let of_op: f64 = kept.iter().skip(self.common).take(TAPS).sum();
        let share = of_stem / (of_stem.abs() + of_op.abs()).max(1e-12);
        (total * self.independent / self.target.len() as f64, z, share)
    }

    /// Nats that the squared OP gains, and the best stem beside both.
    fn curve(&self, winner: Option<&Tried>) -> (f64, f64) {
        let means = block_means(&self.op, self.factor, self.instants);
        let squares: Vec<Lane> = means.iter().map(|u| Lane::splat(u * u)).collect();
        let sums = Width::widest().run(Products {
            columns: &self.columns,
            target: &self.target,
            weights: &self.weights,
            stem: &squares,
        });
        let Some(square) = self.solved(
            Candidate { s: 0.0, j: 0.0, model: Model::TwoPhase, place: 0.0 },
            0.0,
            0,
            &sums,
            &squares,
        ) else {
            return (0.0, 0.0);
        };
        let Some(curved) = self.added(&square.across, &square.own, &square.target) else {
            return (0.0, 0.0);
        };
        let curve = self.nats(self.follows.sse, curved.drop);
        let Some(tried) = winner else { return (curve, 0.0) };
        // Both at once: sixteen taps.
        let between = DMatrix::from_fn(TAPS, TAPS, |i, j| {
            let a = &square.stem[LONGEST + 1 - LAGS[i]..];
            let b = &tried.stem[LONGEST + 1 - LAGS[j]..];
            let samples = self.target.len();
            let products = a[..samples].iter().zip(&b[..samples]).zip(&self.weights);
            products.map(|((a, b), w)| a * b * w * w).sum()
        });
        let columns = self.columns.len();
        let across = DMatrix::from_fn(columns, 2 * TAPS, |c, t| match t < TAPS {
            true => square.across[(c, t)],
            false => tried.across[(c, t - TAPS)],
        });
        let own = DMatrix::from_fn(2 * TAPS, 2 * TAPS, |i, j| match (i < TAPS, j < TAPS) {
            (true, true) => square.own[(i, j)],
            (true, false) => between[(i, j - TAPS)],
            (false, true) => between[(j, i - TAPS)],
            (false, false) => tried.own[(i - TAPS, j - TAPS)],
        });
        let target = DVector::from_fn(2 * TAPS, |t, _| match t < TAPS {
            true => square.target[t],
            false => tried.target[t - TAPS],
        });
        let both = self.added(&across, &own, &target);
        let beyond = both.map_or(0.0, |both| {
            let sse = (self.follows.sse - curved.drop).max(0.0);
            self.nats(sse, both.drop - curved.drop)
        });
        (curve, beyond)
    }

    /// The largest gain of stems that moved in reversed time.
    fn placebo(&self, about: Option<Candidate>) -> f64 {
        let mut asked = self.grid_of(0.0);
        asked.extend(about.into_iter().flat_map(|about| finer(about, ROUNDS[0].0, ROUNDS[0].1)));
        let mut turned = self.op.clone();
        // What is left over at the end stays there.
        turned[..self.instants * self.factor].reverse();
        let backwards = self.tried_under(&asked, &turned, true);
        backwards.iter().flatten().map(|t| self.gain_beside(t)).fold(0.0, f64::max)
    }
}

fn finer(about: Candidate, factors: [f64; 4], steps: [f64; 4]) -> Vec<Candidate> {
    let with = |factor: f64| {
        steps.map(|step| Candidate {
            s: factor * about.s,
            j: (about.j + step).clamp(0.0, 1.0),
            ..about
        })
    };
    factors.into_iter().flat_map(with).collect()
}

#[cfg(test)]
mod tests {
    use super::super::information;
    use crate::bands::Bands;
    use crate::closed_loop::NormalStream;
    use crate::valve::{Start, TwoPhase, Valve};

    /// A lag behind a valve under a wandering OP, and noise, some of it in bursts.
    fn recording(s: f64, j: f64, bursts: bool) -> (Vec<f64>, Vec<f64>) {
        let mut draws = NormalStream::new(7);
        let (mut slow, mut y) = (0.0, 0.0);
        let op: Vec<f64> = (0..1500)
            .map(|k| {
                slow = 0.99 * slow + 0.2 * draws.draw();
                50.0 + slow + 3.0 * (0.07 * k as f64).sin()
            })
            .collect();
        let mut valve = TwoPhase::new(Bands::from_s_j(s, j).unwrap());
        valve.restart(Start::at_rest(op[0]));
        let mut before = op[0];
        let pv = op.iter().enumerate().map(|(k, u)| {
            y = 0.7 * y + 0.3 * before;
            before = valve.step(*u);
            let noise = if bursts && k % 300 < 40 { 0.6 } else { 0.03 };
            y + noise * draws.draw()
        });
        let pv = pv.collect();
        (op, pv)
    }

    #[test]
    fn a_true_stem_is_found_and_leaves_the_op_nothing_to_add() {
        for bursts in [false, true] {
            let (op, pv) = recording(1.0, 0.5, bursts);
            let told = information(&op, &pv, Some(90.0)).unwrap();
            let stem = &told.beside;
            assert!(stem.gain > 60.0 && stem.z > 3.0, "{stem:?}");
            assert!(stem.gain > 2.0 * stem.placebo && stem.gain > 2.0 * stem.lacks, "{stem:?}");
            assert!(stem.beyond_curve > 0.5 * stem.gain && stem.share > 0.5, "{stem:?}");
            let found = stem.best.1 * told.op_range;
            assert!((found / 1.0).ln().abs() < 0.15, "{found}");
            assert!(stem.gain + 1e-6 >= stem.profile.iter().copied().fold(0.0, f64::max));
        }
    }

    #[test]
    fn behind_a_valve_that_follows_large_bands_are_refuted() {
        let (op, pv) = recording(0.0, 0.0, false);
        let stem = information(&op, &pv, Some(90.0)).unwrap().beside;
        assert!(stem.gain < 25.0 && stem.z < 3.0, "{stem:?}");
        assert!(stem.refuted[6] > 100.0 && stem.refuted[6] > stem.refuted[1], "{stem:?}");
    }
}
