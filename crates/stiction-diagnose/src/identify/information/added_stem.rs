//! Evidence of a sticking valve's stem about the PV beside the OP.
//!
//! # What it measures
//! The nats by which the PV becomes likelier if the stem of a sticking valve is added to the regression beside the
//! OP, not instead of it. The OP stays because it contains the PV through the controller: at moments that the
//! record lacks, and from long ago through the integral. If the stem replaces the OP, a true stem often loses.
//!
//! # Equations
//! With the columns of [`super`] for a valve that follows, and the taps V of a stem:
//! ```text
//! gain     = n/2 ln((SSE + f) / (SSE - r' Q^-1 r + f)),   Q = V'V - V'X (X'X)^-1 X'V,  r = V'e
//! robust   = n/N sum of l(e with V) - l(e),               l of Student's t with 4 degrees of freedom
//! lacks    = n/2 ln((SSE of V without the OP + f) / (SSE of both + f))
//! evidence = ln of the mean of exp(gain) over all valves of the grid: the prior is uniform in ln S and in J
//! placebo  = the largest gain of the same valves under the OP reversed in time, and turned back
//! curve    = gain of the squared OP, as of a process whose gain changes
//! ```
//! Rows have a smaller weight where the errors of a valve that follows are large. Their weight is reduced again if
//! their own error is far larger than their neighbours' by Student's t, because bursts and outliers must not choose the
//! stem. The best valves of the grid are refined round by round, including the initial positions of their stems, which
//! determine everything until the first slips. The posterior of S and J is the share of `exp(gain)` in bins of ln S and
//! of J/S, over all tried valves, each bin by its best.
//!
//! # Parameters
//! | name | value | unit | source |
//! |---|---|---|---|
//! | S | 17 values, 0.015 to 1.8 | range of the OP (0.5 to 99.5 %) | ours |
//! | J, model | 0.1, 0.5, 1 two-phase; 0.3, 0.7 He | S | ours |
//! | initial position of a stem that slips less than 12 (6) times | 0, -0.7, 0.7 (and -0.35, 0.35) | stick forces from the OP | ours |
//!
//! # Limits
//! A load that jumps is also explained by some stem, and equally by a placebo. If controllers act between recorded
//! samples, or the OP is rounded or compressed, the stem of the recorded OP differs from the real one.

use super::{
    BLOCK, Candidate, LAGS, LONGEST, Lane, Problem, STEPS, Stem, TAPS, block_means, placed,
    residual,
};
use crate::series::{median, std};
use crate::valve::Model;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Rows to either side that give the noise around one.
const AROUND: usize = 12;
/// Degrees of freedom of Student's t, which limits the weight of a single large error.
const FREEDOM: f64 = 4.0;
/// Number of values of S: the values of the grid, and one value between each two.
const FINE_STEPS: usize = 2 * STEPS - 1;
/// J over S, and the model.
const SHAPES: [(f64, Model); 5] = [
    (0.1, Model::TwoPhase),
    (0.5, Model::TwoPhase),
    (1.0, Model::TwoPhase),
    (0.3, Model::He),
    (0.7, Model::He),
];
/// Initial positions of a stem that slips less often than this, stick forces from the OP, besides the OP itself.
const PLACES: [(f64, f64); 4] = [(12.0, -0.7), (12.0, 0.7), (6.0, -0.35), (6.0, 0.35)];
/// Valves around which finer ones are tried, round by round, and their distances: ln S, J/S, initial position.
const ROUNDS: [(usize, [f64; 3]); 5] = [
    (4, [0.16, 0.25, 0.3]),
    (3, [0.08, 0.14, 0.15]),
    (2, [0.04, 0.08, 0.08]),
    (1, [0.02, 0.04, 0.04]),
    (1, [0.01, 0.02, 0.02]),
];
/// Steps of a round, relative to its range: spread over a cube.
const SPREAD: [[f64; 3]; 16] = [
    [-1.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [-0.5, 0.0, 0.0],
    [0.5, 0.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0],
    [0.0, 0.0, 1.0],
    [-1.0, -1.0, -0.5],
    [-1.0, 1.0, 0.5],
    [1.0, -1.0, 0.5],
    [1.0, 1.0, -0.5],
    [-0.5, -0.5, 0.5],
    [-0.5, 0.5, -0.5],
    [0.5, -0.5, -0.5],
    [0.5, 0.5, 0.5],
];
/// Bins of the posterior: of ln S from the smallest S to the largest, and of J/S.
const BINS_OF_S: usize = 60;
const BINS_OF_J: usize = 10;

/// An item and its gain, nats.
type WithGain<T> = (T, f64);

/// Results for stems beside the OP.
#[derive(Debug, Clone, PartialEq)]
pub struct AddedStem {
    /// Nats that the best stem gains.
    pub gain: f64,
    /// The gain by a likelihood that limits outliers.
    pub robust: f64,
    /// Standard errors of that, over blocks of instants.
    pub z: f64,
    /// The valve of that stem: model, S as a share of the OP's range, J as a share of S, slips.
    pub best: (Model, f64, f64, usize),
    /// Initial position of that stem, stick forces from the OP.
    pub place: f64,
    /// Share of the PV's response to a lasting change that comes from the stem; 1 if the OP adds nothing to it.
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
    /// Gain of the OP beside the best stem, nats: small if the valve sticks like this.
    pub lacks: f64,
    /// The smallest gain of the OP beside any stem of each S of the grid, nats: a large gain refutes that S.
    pub refuted: [f64; STEPS],
    /// Posterior of ln S, S as a share of the OP's range: mean and standard deviation.
    pub ln_s: [f64; 2],
    /// Posterior of J/S.
    pub j_over_s: [f64; 2],
    /// The smaller of the robust gains in the two halves of the record, nats.
    pub least_half: f64,
}

/// Taps beside the columns: their coefficients, and their reduction of the sum of squares.
pub(super) struct Added {
    pub(super) coefficients: DVector<f64>,
    drop: f64,
}

impl Problem {
    /// The results of the grid's valves, and finer ones around the best, beside the OP.
    pub(super) fn added_stem(&self, op: &[f64], pv: &[f64]) -> AddedStem {
        let weights = self.reliability();
        match Self::weighted(op, pv, self.op_range, self.factor, |_| weights) {
            Some(problem) => problem.searched(),
            None => self.searched(),
        }
    }

    /// The square root of each row's weight, by the error of a valve that follows: smaller where errors are large
    /// for a while, and where one is far larger than its neighbours.
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

    /// The valves of the grid, those that slip seldom with their best initial position, and all tried valves.
    fn on_grid(&self) -> (Vec<WithGain<Stem>>, Vec<WithGain<Candidate>>) {
        let with_gain = |stem: Stem| {
            let gain = self.added_gain(&stem);
            (stem, gain)
        };
        let mut best: Vec<WithGain<Stem>> =
            self.stems(&grid_at(0.0)).into_iter().map(with_gain).collect();
        let mut tried: Vec<WithGain<Candidate>> =
            best.iter().map(|(stem, gain)| (stem.candidate, *gain)).collect();
        let slips: Vec<f64> = best.iter().map(|(stem, _)| stem.slips).collect();
        let which = placed(&slips, &PLACES);
        let asked: Vec<Candidate> =
            which.iter().map(|(k, place)| Candidate { place: *place, ..tried[*k].0 }).collect();
        for ((k, _), stem) in which.iter().zip(self.stems(&asked)) {
            let (stem, gain) = with_gain(stem);
            tried.push((stem.candidate, gain));
            if gain > best[*k].1 {
                best[*k] = (stem, gain);
            }
        }
        (best, tried)
    }

    /// The best stem of the grid, or a better one from a finer search around it, with its gain. Appends the valves
    /// tried.
    fn refined(
        &self,
        on_grid: Vec<WithGain<Stem>>,
        tried: &mut Vec<WithGain<Candidate>>,
    ) -> Option<WithGain<Stem>> {
        let mut best: Vec<WithGain<Candidate>> =
            on_grid.iter().map(|(stem, gain)| (stem.candidate, *gain)).collect();
        let mut winner = on_grid.into_iter().fold(None, better);
        for (kept, reach) in ROUNDS {
            best.sort_by(|a, b| b.1.total_cmp(&a.1));
            best.truncate(kept);
            let asked: Vec<Candidate> =
                best.iter().flat_map(|(about, _)| self.finer(*about, reach)).collect();
            for stem in self.stems(&asked) {
                let gain = self.added_gain(&stem);
                best.push((stem.candidate, gain));
                tried.push((stem.candidate, gain));
                winner = better(winner, (stem, gain));
            }
        }
        winner
    }

    /// Valves around one. The steps have no mirror image, so they follow the skewness of the OP. A valve that closes on
    /// a rising OP gets the same steps as a valve that opens.
    fn finer(&self, about: Candidate, reach: [f64; 3]) -> [Candidate; SPREAD.len()] {
        let skew: f64 = self.op.iter().map(|u| u.powi(3)).sum();
        let direction = if skew < 0.0 { -1.0 } else { 1.0 };
        SPREAD.map(|step| Candidate {
            s: about.s * (step[0] * reach[0]).exp(),
            j: (about.j + step[1] * reach[1]).clamp(0.0, 1.0),
            place: (about.place + direction * step[2] * reach[2]).clamp(-0.99, 0.99),
            ..about
        })
    }

    fn searched(&self) -> AddedStem {
        let (on_grid, mut tried) = self.on_grid();
        let (mut profile, mut refuted) = ([0.0; STEPS], [f64::INFINITY; STEPS]);
        for (k, (_, gain)) in on_grid.iter().enumerate() {
            // Those between two values of the coarse grid count for the lower one.
            let step = k % FINE_STEPS / 2;
            profile[step] = gain.max(profile[step]);
        }
        let most = on_grid.iter().map(|(_, gain)| *gain).fold(0.0, f64::max);
        let sum: f64 = on_grid.iter().map(|(_, gain)| (gain - most).exp()).sum();
        let evidence = most + (sum / on_grid.len().max(1) as f64).ln();
        for (k, (stem, _)) in
            on_grid.iter().enumerate().filter(|(k, _)| (k % FINE_STEPS).is_multiple_of(2))
        {
            let step = k % FINE_STEPS / 2;
            refuted[step] = self.lacks(stem).min(refuted[step]);
        }
        let winner = self.refined(on_grid, &mut tried);
        let found = winner.as_ref().map(|(stem, _)| stem);
        let (curve, beyond_curve) = self.curve(found);
        let Borne { robust, z, share, least_half } =
            found.map_or(Borne::default(), |stem| self.borne_out(stem));
        let best = found.map_or((Model::TwoPhase, super::SMALLEST, 0.0, 0), |stem| {
            let Candidate { s, j, model, .. } = stem.candidate;
            (model, s, j, stem.slips as usize)
        });
        let (smallest, largest) = (super::SMALLEST.ln() - 0.3, super::LARGEST.ln() + 0.3);
        let of_s = tried.iter().map(|(candidate, gain)| (candidate.s.ln(), *gain));
        let of_j = tried.iter().map(|(candidate, gain)| (candidate.j, *gain));
        AddedStem {
            gain: winner.as_ref().map_or(0.0, |(_, gain)| *gain),
            robust,
            z,
            best,
            place: found.map_or(0.0, |stem| stem.candidate.place),
            share,
            evidence,
            placebo: self.placebo(found.map(|stem| stem.candidate)),
            curve,
            beyond_curve,
            profile,
            lacks: found.map_or(0.0, |stem| self.lacks(stem)),
            refuted,
            ln_s: posterior::<BINS_OF_S>(of_s, smallest, largest),
            j_over_s: posterior::<BINS_OF_J>(of_j, 0.0, 1.0),
            least_half,
        }
    }

    /// Gain of the OP beside a stem, nats.
    fn lacks(&self, stem: &Stem) -> f64 {
        let Some(sse) = self.sse_in_place(stem) else { return 0.0 };
        let both = self.follows.sse - self.added(stem).map_or(0.0, |added| added.drop);
        self.nats(sse, sse - both)
    }

    /// A stem's taps beside the columns; `None` if the equations cannot be solved.
    pub(super) fn added(&self, stem: &Stem) -> Option<Added> {
        self.added_taps(&stem.across, &stem.own, &stem.target)
    }

    fn added_taps(
        &self,
        across: &DMatrix<f64>,
        own: &DMatrix<f64>,
        target: &DVector<f64>,
    ) -> Option<Added> {
        // With the factor L, L L' = X'X, the part of V'V that the columns explain is (L^-1 X'V)' (L^-1 X'V).
        let mut explained = across.clone();
        self.follows.factor.l_dirty().solve_lower_triangular_mut(&mut explained);
        let mut left = own.clone();
        left.gemm_tr(-1.0, &explained, &explained, 1.0);
        for i in 0..left.nrows() {
            left[(i, i)] += 1e-6 * own[(i, i)] + 1e-10;
        }
        let mut products = target.clone();
        products.gemv_tr(-1.0, across, &self.follows.coefficients, 1.0);
        let coefficients = Cholesky::new(left)?.solve(&products);
        let drop = products.dot(&coefficients);
        Some(Added { coefficients, drop })
    }

    fn added_gain(&self, stem: &Stem) -> f64 {
        self.added(stem).map_or(0.0, |added| self.nats(self.follows.sse, added.drop))
    }

    fn nats(&self, sse: f64, drop: f64) -> f64 {
        let left = (sse - drop).max(0.0);
        let nats = 0.5 * self.independent * ((sse + self.floor) / (left + self.floor)).ln();
        // Stems that move alike gain the same except for rounding, which must not decide their order.
        if nats.is_finite() { (nats.max(0.0) * 1e6).round() / 1e6 } else { 0.0 }
    }

    /// The errors of the columns with a stem beside them, row by row.
    pub(super) fn errors_with(&self, stem: &Stem, added: &Added) -> Vec<f64> {
        let kept = self.kept(stem, added);
        let mut error = residual(&self.columns, &kept, &self.target);
        for (b, lag) in added.coefficients.iter().zip(LAGS) {
            let taps = &stem.path[LONGEST + 1 - lag..];
            let taps = taps.iter().zip(&self.weights);
            error.iter_mut().zip(taps).for_each(|(e, (v, w))| *e -= b * w * v);
        }
        error
    }

    /// The coefficients of the columns with a stem beside them.
    fn kept(&self, stem: &Stem, added: &Added) -> DVector<f64> {
        &self.follows.coefficients
            - self.follows.factor.solve(&(&stem.across * &added.coefficients))
    }

    /// The likelihood of a stem with limited outliers.
    fn borne_out(&self, stem: &Stem) -> Borne {
        let Some(added) = self.added(stem) else { return Borne::default() };
        let kept = self.kept(stem, &added);
        let error = self.errors_with(stem, &added);
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
        let gain_sign = if of_stem + of_op < 0.0 { -1.0 } else { 1.0 };
        let share = gain_sign * of_stem / (of_stem.abs() + of_op.abs()).max(1e-12);
        let independent = self.independent / self.target.len() as f64;
        let half: f64 = sums[..blocks / 2].iter().sum();
        let least_half = half.min(total - half) * independent;
        Borne { robust: total * independent, z, share, least_half }
    }

    /// Nats that the squared OP gains, and the best stem beside both.
    fn curve(&self, winner: Option<&Stem>) -> (f64, f64) {
        let means = block_means(&self.op, self.factor, self.instants);
        let squares: Vec<Lane> = means.iter().map(|u| Lane::splat(u * u)).collect();
        let none = Candidate { s: 0.0, j: 0.0, model: Model::TwoPhase, place: 0.0 };
        let square = self.stem(none, 0.0, 0, &self.sums(&squares), &squares);
        let Some(curved) = self.added(&square) else { return (0.0, 0.0) };
        let curve = self.nats(self.follows.sse, curved.drop);
        let Some(stem) = winner else { return (curve, 0.0) };
        // Both at once: sixteen taps.
        let between = DMatrix::from_fn(TAPS, TAPS, |i, j| {
            let a = &square.path[LONGEST + 1 - LAGS[i]..];
            let b = &stem.path[LONGEST + 1 - LAGS[j]..];
            let samples = self.target.len();
            let products = a[..samples].iter().zip(&b[..samples]).zip(&self.weights);
            products.map(|((a, b), w)| a * b * w * w).sum()
        });
        let columns = self.columns.len();
        let across = DMatrix::from_fn(columns, 2 * TAPS, |c, t| match t < TAPS {
            true => square.across[(c, t)],
            false => stem.across[(c, t - TAPS)],
        });
        let own = DMatrix::from_fn(2 * TAPS, 2 * TAPS, |i, j| match (i < TAPS, j < TAPS) {
            (true, true) => square.own[(i, j)],
            (true, false) => between[(i, j - TAPS)],
            (false, true) => between[(j, i - TAPS)],
            (false, false) => stem.own[(i - TAPS, j - TAPS)],
        });
        let target = DVector::from_fn(2 * TAPS, |t, _| match t < TAPS {
            true => square.target[t],
            false => stem.target[t - TAPS],
        });
        let both = self.added_taps(&across, &own, &target);
        let beyond = both.map_or(0.0, |both| {
            let sse = (self.follows.sse - curved.drop).max(0.0);
            self.nats(sse, both.drop - curved.drop)
        });
        (curve, beyond)
    }

    /// The largest gain of stems that moved in reversed time.
    fn placebo(&self, about: Option<Candidate>) -> f64 {
        let mut asked: Vec<Candidate> = grid_at(0.0).into_iter().step_by(2).collect();
        asked.extend(about.into_iter().flat_map(|about| self.finer(about, ROUNDS[0].1)));
        let mut turned = self.op.clone();
        // The remainder at the end stays there.
        turned[..self.instants * self.factor].reverse();
        let backwards = self.stems_under(&asked, &turned, true);
        backwards.iter().map(|stem| self.added_gain(stem)).fold(0.0, f64::max)
    }
}

/// The likelihood of a stem with limited outliers.
#[derive(Default)]
struct Borne {
    robust: f64,
    z: f64,
    share: f64,
    least_half: f64,
}

/// The first valves to try, with their stems at this distance from the OP; S changes fastest.
fn grid_at(place: f64) -> Vec<Candidate> {
    let coarse = super::grid();
    let s = |k: usize| match k % 2 {
        0 => coarse[k / 2],
        _ => (coarse[k / 2] * coarse[k / 2 + 1]).sqrt(),
    };
    let of = |(j, model)| (0..FINE_STEPS).map(move |k| Candidate { s: s(k), j, model, place });
    SHAPES.into_iter().flat_map(of).collect()
}

fn better(best: Option<WithGain<Stem>>, other: WithGain<Stem>) -> Option<WithGain<Stem>> {
    match best {
        Some(best) if best.1 >= other.1 => Some(best),
        _ => Some(other),
    }
}

/// Posterior mean and standard deviation of some values, each with its gain in nats. A bin counts as much as its best
/// value.
fn posterior<const BINS: usize>(
    tried: impl Iterator<Item = (f64, f64)>,
    from: f64,
    to: f64,
) -> [f64; 2] {
    let mut bins = [(0.0, f64::NEG_INFINITY); BINS];
    for (value, gain) in tried {
        let place = ((value - from) / (to - from) * BINS as f64) as usize;
        let bin = &mut bins[place.min(BINS - 1)];
        if gain > bin.1 {
            *bin = (value, gain);
        }
    }
    let most = bins.iter().map(|(_, gain)| *gain).fold(f64::NEG_INFINITY, f64::max);
    let weights = bins.map(|(value, gain)| (value, (gain - most).exp()));
    let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
    let of = |f: &dyn Fn(f64) -> f64| weights.iter().map(|(v, w)| f(*v) * w).sum::<f64>() / total;
    let middle = of(&|v| v);
    [middle, of(&|v| (v - middle).powi(2)).max(0.0).sqrt()]
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
            let stem = &told.added_stem;
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
        let stem = information(&op, &pv, Some(90.0)).unwrap().added_stem;
        assert!(stem.gain < 25.0 && stem.z < 3.0, "{stem:?}");
        assert!(stem.refuted[6] > 100.0 && stem.refuted[6] > stem.refuted[1], "{stem:?}");
    }
}
