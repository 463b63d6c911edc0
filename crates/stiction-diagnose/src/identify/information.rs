//! The information of a recording about a sticking valve: how much better, by how many standard errors, and with
//! which power valves of a grid of S predict the PV than a valve that follows.
//!
//! # What it measures
//! For each S of a grid, the worst and the best case over some J and models: whether a valve with this S predicts
//! the PV better (z, gain), and whether it would have been seen (power). One S with a large z is evidence for
//! sticking. An S with a small power could not have been seen.
//!
//! # Assumptions
//! One valve before one linear process; its disturbance is white at the equation's input. The OP path is used as
//! recorded: the loop is not simulated.
//!
//! # Equations
//! The record is reduced to at most [`MOST_SAMPLES`] instants, q samples apart: `y(k)` is the PV at an instant,
//! `u(k)` the mean of the OP over the q samples strictly before it, `m(k)` the same mean of the PV.
//! ```text
//! y(k) = c + t k + sum_{i=1..5} a_i y(k-i) [+ sum_{i=1..4} d_i m(k-i)] + sum_j b_j x(k - j) + e(k),  j = 1 2 3 4 6 8 11 15
//! ```
//! with `x = u` for the valve that follows, and for a sticking valve the same means of its stem under the OP at full
//! rate. The means of the PV are needed if q > 1. Without them, the means of the OP show the PV between the instants
//! through the controller, and no stem can compete with that. If a valve slips less than [`SELDOM`] times, the initial
//! position of its stem matters; several positions are tried.
//! ```text
//! gain  = n/2 ln(SSE of x = u / SSE),  n independent samples: (1 - |r|) / (1 + |r|) of all, 500 at most
//! d(k)  = l(e) - l(e of x = u),        l(e) = -5/2 ln(1 + e^2 / (4 s^2)): Student's t with 4 degrees of freedom
//! z     = sum of d / (sqrt(b) sd of d over b blocks of 10 instants)                        (Vuong 1989)
//! power = n/2 ln(1 + Q / SSE) + n/2 ln(1 + R / SSE)
//! ```
//! with Q the part of the stem's effect that no OP explains and R the part of the OP's effect that no stem
//! explains, squared and summed. Errors of the model itself are allowed for: s and both SSE contain 5 % of the
//! residual of the PV after its own past.
//!
//! # Parameters
//! | name | value | unit | source |
//! |---|---|---|---|
//! | S | 9 values, 0.015 to 1.8 | range of the OP (0.5 to 99.5 %) | ours |
//! | J, model | 0.1, 0.5, 1 two-phase; 0.7 He | S | ours |
//! | around the best of them | 16 values, S 0.79 to 1.26, J/S 0.1 to 1 | S of the best | ours |
//!
//! # Limits
//! A load that jumps, or a process whose gain changes, is also predicted better by some valve. So z is evidence
//! against clearing a valve, and accuses none. Controllers that act between recorded samples leak information that
//! the record does not contain.
//!
//! # References
//! Q. H. Vuong, "Likelihood ratio tests for model selection and non-nested hypotheses", Econometrica 57
//! (1989) 307 (recalled, not read). The grid, the floor and the power are ours.

mod added_stem;
mod traces;

pub use added_stem::AddedStem;
pub use traces::{Traces, traces};

use crate::bands::Bands;
use crate::finding::Abstention;
use crate::series::{mean, median, quantile, std};
use crate::simd::{Kernel, LANES, Lane, Width};
use crate::valve::lanes::{LaneValve, TwoPhaseLanes};
use crate::valve::{Model, Start};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Number of values of S, from [`SMALLEST`] to [`LARGEST`] in equal ratios.
pub const STEPS: usize = 9;
/// The smallest S, share of the OP's range.
pub const SMALLEST: f64 = 0.015;
/// The largest S, share of the OP's range: a valve that never slips.
pub const LARGEST: f64 = 1.8;
/// Approximate largest number of predicted instants.
pub const MOST_SAMPLES: usize = 800;
/// Smallest number of instants for a result.
pub const FEWEST_SAMPLES: usize = 60;
/// A valve with fewer slips is tried from several positions.
pub const SELDOM: f64 = 4.0;

/// J over S, and the model.
const SHAPES: [(f64, Model); 4] =
    [(0.1, Model::TwoPhase), (0.5, Model::TwoPhase), (1.0, Model::TwoPhase), (0.7, Model::He)];
/// Initial positions of a stem that slips less often than this, stick bands from the OP, besides the OP itself.
const PLACES: [(f64, f64); 4] =
    [(SELDOM, -0.45), (SELDOM, 0.45), (SELDOM - 1.0, -0.9), (SELDOM - 1.0, 0.9)];
/// Around the valve of the largest gain: factors of its S, and J over S.
const NEARBY_S: [f64; 4] = [0.79, 0.91, 1.09, 1.26];
const NEARBY_J: [f64; 4] = [0.1, 0.35, 0.65, 1.0];
/// Smallest number of instants per period.
const SAMPLES_PER_PERIOD: usize = 40;
/// Instants that are always kept.
const KEPT: usize = 150;
/// Own past of the PV, and of its means.
const PAST: usize = 5;
const MEANS: usize = 4;
/// Lags of the valve, instants.
const LAGS: [usize; 8] = [1, 2, 3, 4, 6, 8, 11, 15];
const TAPS: usize = LAGS.len();
const LONGEST: usize = LAGS[TAPS - 1];
/// Share of the residual of the PV after its own past that may be the model's error.
const MODEL_ERROR: f64 = 0.05;
/// Most independent samples: no model is valid for more.
const MOST_INDEPENDENT: f64 = 500.0;
/// Instants of a block.
const BLOCK: usize = 10;
/// Positions that stay in the first-level cache during all products.
const TILE: usize = 32;

/// The grid of S, shares of the OP's range.
pub fn grid() -> [f64; STEPS] {
    let ratio = LARGEST / SMALLEST;
    std::array::from_fn(|k| SMALLEST * ratio.powf(k as f64 / (STEPS - 1) as f64))
}

/// The information about one S.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// S, share of the OP's range.
    pub s: f64,
    /// Standard errors by which the best of the valves with this S predicts the PV better than one that follows.
    pub z: f64,
    /// The largest gain of these valves in log-likelihood, nats.
    pub gain: f64,
    /// The smallest power to detect the stiction, nats.
    pub power: f64,
}

impl At {
    /// The combined information of two valves with this S.
    fn or(self, other: Self) -> Self {
        Self {
            s: self.s,
            z: self.z.max(other.z),
            gain: self.gain.max(other.gain),
            power: self.power.min(other.power),
        }
    }
}

/// The information of a recording about all S.
#[derive(Debug, Clone, PartialEq)]
pub struct Information {
    /// Range of the OP from its 0.5 to its 99.5 % quantile, percent of span.
    pub op_range: f64,
    /// Number of predicted instants.
    pub samples: usize,
    /// Recorded samples per instant.
    pub factor: usize,
    /// Number of independent samples among these.
    pub independent: f64,
    /// Correlation of neighbouring errors behind the valve that follows.
    pub autocorrelation: f64,
    /// Share of the PV, given its past, that the OP does not explain.
    pub unexplained: f64,
    /// For each S of [`grid`].
    pub profile: [At; STEPS],
    /// The valve with the largest gain, on the grid or near it: its gain, nats.
    pub refined: At,
    /// That valve: model, S as a share of the OP's range, J as a share of S, and slips.
    pub best: (Model, f64, f64, usize),
    /// The results for stems beside the OP.
    pub added_stem: AddedStem,
}

impl Information {
    /// Standard errors by which the best sticking valve predicts the PV better than one that follows the OP; negative
    /// if it predicts worse.
    pub fn z(&self) -> f64 {
        self.best_at().z
    }

    /// The S at which [`z`](Self::z) is largest.
    pub fn best_at(&self) -> &At {
        self.profile.iter().fold(&self.refined, |best, at| if at.z > best.z { at } else { best })
    }
}

/// The information in `op` (percent) and `pv` (any unit). `period` is the dominant period in samples, if the loop
/// oscillates.
///
/// # Errors
/// If the signals differ in length, are too short or not finite, or one is constant.
pub fn information(op: &[f64], pv: &[f64], period: Option<f64>) -> Result<Information, Abstention> {
    let n = op.len();
    if n != pv.len() || n < FEWEST_SAMPLES + LONGEST + 1 {
        return Err(Abstention(format!(
            "needs at least {} samples of both OP and PV; there are {n} and {}",
            FEWEST_SAMPLES + LONGEST + 1,
            pv.len()
        )));
    }
    if op.iter().chain(pv).any(|v| !v.is_finite()) {
        return Err(Abstention("a sample is not finite".to_owned()));
    }
    let still = || Abstention("the OP or the PV does not move".to_owned());
    let op_range = quantile(op, 0.995) - quantile(op, 0.005);
    if !(op_range > 0.0 && op_range.recip().is_finite() && std(pv) > 0.0) {
        return Err(still());
    }
    let factor = factor_of(pv, period);
    let problem = Problem::of(op, pv, op_range, factor).ok_or_else(still)?;
    Ok(problem.explored(op, pv))
}

/// Recorded samples per instant. The number of instants is limited, a period has at least 40, and a held PV has no more
/// samples than updates. At least [`KEPT`] instants remain.
fn factor_of(pv: &[f64], period: Option<f64>) -> usize {
    let n = pv.len();
    let updates = 1 + pv.windows(2).filter(|two| two[0] != two[1]).count();
    let of_period = period.map_or(0, |period| (period / SAMPLES_PER_PERIOD as f64) as usize);
    let of_updates = (n as f64 / updates as f64).round() as usize;
    n.div_ceil(MOST_SAMPLES).max(of_period).max(of_updates).min(n / KEPT).max(1)
}

/// The regression behind the valve that follows, with the parts that other valves share.
struct Problem {
    /// The OP around its mean, in ranges, at full rate.
    op: Vec<f64>,
    op_range: f64,
    factor: usize,
    instants: usize,
    /// Columns of all regressions, then the columns of the OP.
    columns: Vec<Vec<f64>>,
    /// Number of common columns.
    common: usize,
    target: Vec<f64>,
    /// The square root of each row's weight. Columns and target already contain this factor.
    weights: Vec<f64>,
    gram: DMatrix<f64>,
    products: DVector<f64>,
    power: f64,
    /// Sum of squares that is added to every SSE: the model's own error.
    floor: f64,
    follows: Fit,
    error: Vec<f64>,
    independent: f64,
    autocorrelation: f64,
    unexplained: f64,
    /// Scale of Student's t.
    scale: f64,
}

/// A solution of normal equations.
struct Fit {
    coefficients: DVector<f64>,
    sse: f64,
    factor: Cholesky<f64, Dyn>,
}

/// A valve to try.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// Share of the OP's range.
    s: f64,
    /// Share of S.
    j: f64,
    model: Model,
    /// Initial position, stick bands from the OP.
    place: f64,
}

impl Candidate {
    /// Valves of the same model with similar S and J.
    fn nearby(self) -> Vec<Self> {
        let with = |factor: f64| NEARBY_J.map(|j| Self { s: factor * self.s, j, ..self });
        NEARBY_S.into_iter().flat_map(with).collect()
    }
}

/// The movement of its stem.
struct Stem {
    candidate: Candidate,
    slips: f64,
    /// Products of the columns with the stem's taps.
    across: DMatrix<f64>,
    /// Products of the taps with each other.
    own: DMatrix<f64>,
    /// Products of the taps with the target.
    target: DVector<f64>,
    /// Means over blocks.
    path: Vec<f64>,
}

/// A stem instead of the OP.
struct Tried {
    stem: Stem,
    fit: Fit,
}

impl Problem {
    fn of(op: &[f64], pv: &[f64], op_range: f64, factor: usize) -> Option<Self> {
        Self::weighted(op, pv, op_range, factor, |samples| vec![1.0; samples])
    }

    fn weighted(
        op: &[f64],
        pv: &[f64],
        op_range: f64,
        factor: usize,
        weights: impl FnOnce(usize) -> Vec<f64>,
    ) -> Option<Self> {
        let instants = (op.len() - 1) / factor;
        let samples = instants.checked_sub(LONGEST).filter(|n| *n >= FEWEST_SAMPLES)?;
        let (level, deviation) = (mean(pv), std(pv));
        let pv: Vec<f64> = pv.iter().map(|v| (v - level) / deviation).collect();
        // The mean of the instants' means, so that the taps have a mean of zero.
        let level = mean(&op[..instants * factor]);
        let op: Vec<f64> = op.iter().map(|u| (u - level) / op_range).collect();
        let y: Vec<f64> = (0..instants).map(|k| pv[(k + 1) * factor]).collect();
        let shifted = |x: &[f64], by: usize| x[LONGEST - by..instants - by].to_vec();
        let place = |k: usize| 2.0 * k as f64 / (samples - 1) as f64 - 1.0;
        let mut columns = vec![vec![1.0; samples], (0..samples).map(place).collect()];
        columns.extend((1..=PAST).map(|lag| shifted(&y, lag)));
        if factor > 1 {
            // The mean over the samples before an instant ends right before the next one, so it has a lag of one.
            let means = block_means(&pv, factor, instants);
            columns.extend((1..=MEANS).map(|lag| shifted(&means, lag - 1)));
        }
        let common = columns.len();
        let means = block_means(&op, factor, instants);
        columns.extend(LAGS.iter().map(|lag| shifted(&means, lag - 1)));
        let mut target = y[LONGEST..].to_vec();
        let weights = weights(samples);
        for column in columns.iter_mut().chain([&mut target]) {
            column.iter_mut().zip(&weights).for_each(|(x, w)| *x *= w);
        }

        let all = columns.len();
        let mut gram = DMatrix::from_fn(all, all, |i, j| match i >= j {
            true => crate::numeric::least_squares::dot(&columns[i], &columns[j]),
            false => 0.0,
        });
        gram.fill_upper_triangle_with_lower_triangle();
        ridged(&mut gram);
        let products =
            DVector::from_fn(all, |i, _| crate::numeric::least_squares::dot(&columns[i], &target));
        let power = crate::numeric::least_squares::dot(&target, &target);
        let past = Fit::of(
            gram.view((0, 0), (common, common)).into(),
            &products.rows(0, common).into(),
            power,
        )?;
        let floor = MODEL_ERROR * past.sse + 1e-10 * power;
        let follows = Fit::of(gram.clone(), &products, power)?;
        let error = residual(&columns, &follows.coefficients, &target);
        let before: f64 = error.windows(2).map(|two| two[0] * two[1]).sum();
        let squares: f64 = error.iter().map(|e| e * e).sum();
        let autocorrelation =
            if squares > 0.0 { (before / squares).clamp(-0.9, 0.95) } else { 0.0 };
        let share = (1.0 - autocorrelation.abs()) / (1.0 + autocorrelation.abs());
        let sizes: Vec<f64> = error.iter().map(|e| e.abs()).collect();
        let scale = median(&sizes) / 0.6745 + (floor / samples as f64).sqrt();
        let unexplained = (follows.sse + floor) / past.sse.max(f64::MIN_POSITIVE);
        Some(Self {
            op,
            op_range,
            factor,
            instants,
            columns,
            common,
            target,
            weights,
            gram,
            products,
            power,
            floor,
            follows,
            error,
            independent: (samples as f64 * share).min(MOST_INDEPENDENT),
            autocorrelation,
            unexplained,
            scale,
        })
    }

    fn explored(&self, op: &[f64], pv: &[f64]) -> Information {
        let of_shape = |(j, model)| grid().map(|s| Candidate { s, j, model, place: 0.0 });
        let all: Vec<Candidate> = SHAPES.into_iter().flat_map(of_shape).collect();
        let mut best: Vec<Option<Tried>> = self.tried(&all);
        let slips: Vec<f64> =
            best.iter().map(|tried| tried.as_ref().map_or(0.0, |tried| tried.stem.slips)).collect();
        let which = placed(&slips, &PLACES);
        let asked: Vec<Candidate> =
            which.iter().map(|(k, place)| Candidate { place: *place, ..all[*k] }).collect();
        for ((k, _), tried) in which.iter().zip(self.tried(&asked)) {
            let sse = |of: &Option<Tried>| of.as_ref().map_or(f64::INFINITY, |t| t.fit.sse);
            if sse(&tried) < sse(&best[*k]) {
                best[*k] = tried;
            }
        }
        // Without a solved candidate nothing is known.
        let unknown = |s: f64| At { s, z: 0.0, gain: 0.0, power: 0.0 };
        let mut profile = grid().map(unknown);
        for (step, at) in profile.iter_mut().enumerate() {
            let of_step = best.iter().skip(step).step_by(STEPS).flatten().map(|t| self.at(t));
            *at = of_step.reduce(At::or).unwrap_or(unknown(at.s));
        }
        let winner = self.better(best.iter().flatten(), None);
        let nearby =
            winner.map_or(vec![], |(winner, _)| self.tried(&winner.stem.candidate.nearby()));
        let winner = self.better(nearby.iter().flatten(), winner);
        let refined = winner.map_or(unknown(SMALLEST), |(winner, _)| self.at(winner));
        let added_stem = self.added_stem(op, pv);
        let best = winner.map_or((Model::TwoPhase, SMALLEST, 0.0, 0), |(winner, _)| {
            let Candidate { s, j, model, .. } = winner.stem.candidate;
            (model, s, j, winner.stem.slips as usize)
        });
        Information {
            op_range: self.op_range,
            samples: self.target.len(),
            factor: self.factor,
            independent: self.independent,
            autocorrelation: self.autocorrelation,
            unexplained: self.unexplained,
            profile,
            refined,
            best,
            added_stem,
        }
    }

    /// The one with the largest gain, and the gain.
    fn better<'t>(
        &self,
        tried: impl Iterator<Item = &'t Tried>,
        than: Option<(&'t Tried, f64)>,
    ) -> Option<(&'t Tried, f64)> {
        tried.fold(than, |best, tried| {
            let gain = self.gain(tried);
            match best {
                Some((_, largest)) if largest >= gain => best,
                _ => Some((tried, gain)),
            }
        })
    }

    fn at(&self, tried: &Tried) -> At {
        let power = self.power_to_see(tried);
        At { s: tried.stem.candidate.s, z: self.z(tried), gain: self.gain(tried), power }
    }

    /// Stems instead of the OP, in the order of the candidates; `None` if the equations cannot be solved.
    fn tried(&self, asked: &[Candidate]) -> Vec<Option<Tried>> {
        self.stems(asked).into_iter().map(|stem| self.in_place(stem)).collect()
    }

    /// The movement of the candidates' stems under the OP, in their order.
    fn stems(&self, asked: &[Candidate]) -> Vec<Stem> {
        self.stems_under(asked, &self.op, false)
    }

    /// The movement of the stems under a different OP, which may be reversed in time.
    fn stems_under(&self, asked: &[Candidate], op: &[f64], turned: bool) -> Vec<Stem> {
        let width = Width::widest();
        let side_by_side = |block: &[Candidate]| -> Vec<Stem> {
            let lanes = std::array::from_fn(|l| block[l.min(block.len() - 1)]);
            let (factor, instants) = (self.factor, self.instants);
            let valves = starting(lanes, op[0]);
            let (mut means, slips) = width.run(Stems { valves, op, factor, instants });
            if turned {
                means.reverse();
            }
            let sums = self.sums(&means);
            let stem = |(l, candidate): (usize, &Candidate)| {
                self.stem(*candidate, slips[l], l, &sums, &means)
            };
            block.iter().enumerate().map(stem).collect()
        };
        asked.chunks(LANES).flat_map(side_by_side).collect()
    }

    fn sums(&self, paths: &[Lane]) -> Sums {
        Width::widest().run(Products {
            columns: &self.columns,
            target: &self.target,
            weights: &self.weights,
            stem: paths,
        })
    }

    /// The content of a lane.
    fn stem(
        &self,
        candidate: Candidate,
        slips: f64,
        l: usize,
        sums: &Sums,
        paths: &[Lane],
    ) -> Stem {
        let all = self.columns.len();
        let across = DMatrix::from_fn(all, TAPS, |c, t| sums.across[c * TAPS + t][l]);
        let mut own = DMatrix::from_fn(TAPS, TAPS, |i, j| match i >= j {
            true => sums.own[i * TAPS + j][l],
            false => 0.0,
        });
        own.fill_upper_triangle_with_lower_triangle();
        let target = DVector::from_fn(TAPS, |t, _| sums.across[all * TAPS + t][l]);
        let path = paths.iter().map(|lane| lane[l]).collect();
        Stem { candidate, slips, across, own, target, path }
    }

    fn in_place(&self, stem: Stem) -> Option<Tried> {
        let fit = self.fit_in_place(&stem)?;
        Some(Tried { stem, fit })
    }

    /// Sum of squares with a stem instead of the OP.
    fn sse_in_place(&self, stem: &Stem) -> Option<f64> {
        self.fit_in_place(stem).map(|fit| fit.sse)
    }

    fn fit_in_place(&self, stem: &Stem) -> Option<Fit> {
        let (all, common) = (self.columns.len(), self.common);
        let mut gram = self.gram.clone();
        let taps = (common, TAPS);
        gram.view_mut((common, common), (TAPS, TAPS)).copy_from(&stem.own);
        gram.view_mut((0, common), taps).copy_from(&stem.across.rows(0, common));
        gram.view_mut((common, 0), (TAPS, common))
            .copy_from(&stem.across.rows(0, common).transpose());
        for i in common..all {
            gram[(i, i)] *= 1.0 + RIDGE;
            gram[(i, i)] += 1e-10;
        }
        let mut products = self.products.clone();
        products.rows_mut(common, TAPS).copy_from(&stem.target);
        Fit::of(gram, &products, self.power)
    }

    fn gain(&self, tried: &Tried) -> f64 {
        0.5 * self.independent
            * ((self.follows.sse + self.floor) / (tried.fit.sse + self.floor)).ln()
    }

    /// The sum of two gains in nats: of a valve that sticks like this over one that follows, and the reverse. A stem
    /// that never moves has no effect, but the OP has an effect that the stem does not explain.
    fn power_to_see(&self, tried: &Tried) -> f64 {
        let common = self.common;
        let of_op: DVector<f64> = self.follows.coefficients.rows(common, TAPS).into();
        let of_stem: DVector<f64> = tried.fit.coefficients.rows(common, TAPS).into();
        let (here, there) = (self.follows.sse + self.floor, tried.fit.sse + self.floor);
        // The effect of the stem that no OP explains, with the process found behind the better of the two.
        let process = if there >= here { &of_op } else { &of_stem };
        let seen = &tried.stem.across * process;
        let outside =
            process.dot(&(&tried.stem.own * process)) - seen.dot(&self.follows.factor.solve(&seen));
        // The effect of the OP that no stem explains.
        let own = self.gram.view((common, common), (TAPS, TAPS));
        let mut seen = DVector::zeros(self.columns.len());
        seen.rows_mut(0, common).copy_from(&(self.gram.view((0, common), (common, TAPS)) * &of_op));
        let between = tried.stem.across.rows(common, TAPS).transpose();
        seen.rows_mut(common, TAPS).copy_from(&(between * &of_op));
        let back = of_op.dot(&(own * &of_op)) - seen.dot(&tried.fit.factor.solve(&seen));
        let nats = |squares: f64| {
            0.5 * self.independent * (squares.clamp(0.0, 1e9) / here.min(there)).ln_1p()
        };
        nats(outside) + nats(back)
    }

    fn z(&self, tried: &Tried) -> f64 {
        let common = self.common;
        let coefficients = &tried.fit.coefficients;
        let mut error = residual(&self.columns[..common], coefficients, &self.target);
        for (t, lag) in LAGS.iter().enumerate() {
            let b = coefficients[common + t];
            let taps = &tried.stem.path[LONGEST + 1 - lag..];
            let taps = taps.iter().zip(&self.weights);
            error.iter_mut().zip(taps).for_each(|(e, (v, w))| *e -= b * w * v);
        }
        let width = 4.0 * self.scale * self.scale;
        let blocks = self.target.len() / BLOCK;
        // One logarithm of a product for each block: its factors are moderate.
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
        total / ((blocks as f64).sqrt() * std(&sums) + 1e-9)
    }
}

/// Candidates that slip seldom, each with every place to try. All at once, for they fill the lanes better.
fn placed(slips: &[f64], places: &[(f64, f64)]) -> Vec<(usize, f64)> {
    let all = places.iter().flat_map(|place| slips.iter().enumerate().map(move |k| (k, place)));
    let seldom = all.filter(|((_, slips), (below, _))| *slips < below);
    seldom.map(|((k, _), (_, place))| (k, *place)).collect()
}

/// Relative ridge of normal equations.
const RIDGE: f64 = 1e-8;

fn ridged(gram: &mut DMatrix<f64>) {
    (0..gram.nrows()).for_each(|i| gram[(i, i)] *= 1.0 + RIDGE);
}

impl Fit {
    fn of(gram: DMatrix<f64>, products: &DVector<f64>, power: f64) -> Option<Self> {
        let factor = Cholesky::new(gram)?;
        let coefficients = factor.solve(products);
        let sse = (power - products.dot(&coefficients)).max(0.0);
        sse.is_finite().then_some(Self { coefficients, sse, factor })
    }
}

fn residual(columns: &[Vec<f64>], coefficients: &DVector<f64>, target: &[f64]) -> Vec<f64> {
    let mut error = target.to_vec();
    for (column, c) in columns.iter().zip(coefficients.iter()) {
        error.iter_mut().zip(column).for_each(|(e, v)| *e -= c * v);
    }
    error
}

/// Means over blocks of `factor` samples, in the requested number.
fn block_means(x: &[f64], factor: usize, blocks: usize) -> Vec<f64> {
    let mean = |block: &[f64]| block.iter().sum::<f64>() / factor as f64;
    x.chunks_exact(factor).take(blocks).map(mean).collect()
}

/// Valves of both models at rest at their initial positions under this OP, one per lane.
fn starting(valves: [Candidate; LANES], op: f64) -> TwoPhaseLanes {
    // All of them are valid.
    let bands = valves.map(|v| Bands::from_s_j(v.s, v.j * v.s).unwrap_or(Bands::NONE));
    let start = |l: usize| Start { op, ..Start::at_rest(op + valves[l].place * bands[l].fs()) };
    TwoPhaseLanes::starting(&bands, std::array::from_fn(start))
        .with_he(valves.map(|v| v.model == Model::He))
}

/// Stems under the OP: their means over blocks, and the number of slips.
struct Stems<'a> {
    valves: TwoPhaseLanes,
    op: &'a [f64],
    factor: usize,
    instants: usize,
}

impl Kernel for Stems<'_> {
    type Output = (Vec<Lane>, Lane);
    #[inline(always)]
    fn run(self) -> Self::Output {
        let mut valves = self.valves;
        let share = 1.0 / self.factor as f64;
        let mut means = Vec::with_capacity(self.instants);
        let mut slips: Lane = Lane::splat(0.0);
        let mut before: Lane = Lane::from_fn(|l| valves.step(l, self.op[0]));
        let mut rested: Lane = Lane::splat(1.0);
        for block in self.op.chunks_exact(self.factor).take(self.instants) {
            let mut sum: Lane = Lane::splat(0.0);
            for u in block {
                let x: Lane = Lane::from_fn(|l| valves.step(l, *u));
                for l in 0..LANES {
                    let moves = if x[l] == before[l] { 0.0 } else { 1.0 };
                    slips[l] += moves * rested[l];
                    rested[l] = 1.0 - moves;
                    sum[l] += x[l];
                }
                before = x;
            }
            means.push(Lane::from_fn(|l| share * sum[l]));
        }
        (means, slips)
    }
}

/// Sums of products of columns, target and the stem's taps, and of the taps with each other.
struct Products<'a> {
    columns: &'a [Vec<f64>],
    target: &'a [f64],
    weights: &'a [f64],
    stem: &'a [Lane],
}

struct Sums {
    /// Column by tap; the target is the last column.
    across: Vec<Lane>,
    /// Tap by tap, where the first is not the lower.
    own: [Lane; TAPS * TAPS],
}

/// Two sums at once, for each waits for its last addition.
#[inline(always)]
fn scaled([mut a, mut b]: [Lane; 2], [x, y]: [&[f64]; 2], stem: &[Lane]) -> [Lane; 2] {
    for ((x, y), v) in x.iter().zip(y).zip(stem) {
        a.add_scaled(v, *x);
        b.add_scaled(v, *y);
    }
    [a, b]
}

#[inline(always)]
fn multiplied([mut a, mut b]: [Lane; 2], [x, y]: [&[Lane]; 2], stem: &[Lane]) -> [Lane; 2] {
    for ((x, y), v) in x.iter().zip(y).zip(stem) {
        a.add_product(x, v);
        b.add_product(y, v);
    }
    [a, b]
}

impl Kernel for Products<'_> {
    type Output = Sums;
    #[inline(always)]
    fn run(self) -> Sums {
        let zero: Lane = Lane::splat(0.0);
        let columns: Vec<&[f64]> =
            self.columns.iter().map(Vec::as_slice).chain([self.target]).collect();
        let mut sums = Sums { across: vec![zero; columns.len() * TAPS], own: [zero; TAPS * TAPS] };
        let samples = self.target.len();
        let mut taps = [[zero; TILE]; TAPS];
        for from in (0..samples).step_by(TILE) {
            let to = (from + TILE).min(samples);
            let weights = &self.weights[from..to];
            for (taps, lag) in taps.iter_mut().zip(LAGS) {
                let stem = &self.stem[LONGEST + 1 - lag + from..LONGEST + 1 - lag + to];
                for ((tap, v), w) in taps.iter_mut().zip(stem).zip(weights) {
                    *tap = Lane::from_fn(|l| w * v[l]);
                }
            }
            for t in 0..TAPS {
                let of_t = &taps[t][..to - from];
                for c in (0..columns.len()).step_by(2) {
                    let two = [c, (c + 1).min(columns.len() - 1)];
                    let factors = two.map(|c| &columns[c][from..to]);
                    let added = scaled(two.map(|c| sums.across[c * TAPS + t]), factors, of_t);
                    two.into_iter().zip(added).for_each(|(c, sum)| sums.across[c * TAPS + t] = sum);
                }
                for other in (0..=t).step_by(2) {
                    let two = [other, (other + 1).min(t)];
                    let factors = two.map(|other| &taps[other][..to - from]);
                    let added = multiplied(two.map(|o| sums.own[t * TAPS + o]), factors, of_t);
                    two.into_iter().zip(added).for_each(|(o, sum)| sums.own[t * TAPS + o] = sum);
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;
    use crate::valve::{TwoPhase, Valve};

    /// A lag behind a valve under a wandering OP, and noise.
    fn recording(s: f64, j: f64, n: usize, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let mut draws = NormalStream::new(11);
        let (mut slow, mut y) = (0.0, 0.0);
        let op: Vec<f64> = (0..n)
            .map(|k| {
                slow = 0.99 * slow + 0.2 * draws.draw();
                50.0 + slow + 3.0 * (0.07 * k as f64).sin()
            })
            .collect();
        let mut valve = TwoPhase::new(Bands::from_s_j(s, j).unwrap());
        valve.restart(Start::at_rest(op[0]));
        let mut before = op[0];
        let pv = op
            .iter()
            .map(|u| {
                y = 0.5 * y + 0.5 * before;
                before = valve.step(*u);
                y + noise * draws.draw()
            })
            .collect();
        (op, pv)
    }

    #[test]
    fn a_sticking_valve_is_far_better_at_its_own_s_and_a_healthy_one_at_none() {
        for n in [700, 3000] {
            let (op, pv) = recording(3.0, 1.5, n, 0.02);
            let sticks = information(&op, &pv, None).unwrap();
            assert!(sticks.z() > 2.5, "{n}: {sticks:?}");
            let found = sticks.refined.s * sticks.op_range;
            assert!((found / 3.0).ln().abs() < 0.6, "{n}: {found}");
            let (op, pv) = recording(0.0, 0.0, n, 0.02);
            let follows = information(&op, &pv, None).unwrap();
            assert!(follows.z() < 2.0, "{n}: {follows:?}");
            // A valve that would rest for long would have been seen.
            assert!(follows.profile[6].z < -2.0 && follows.profile[6].power > 20.0, "{follows:?}");
        }
    }

    #[test]
    fn what_noise_hides_has_no_power() {
        let (op, pv) = recording(0.0, 0.0, 900, 20.0);
        let drowned = information(&op, &pv, None).unwrap();
        assert!(drowned.z() < 3.0);
        let (op, pv) = recording(0.0, 0.0, 900, 0.02);
        let clear = information(&op, &pv, None).unwrap();
        for (a, b) in drowned.profile.iter().zip(&clear.profile).skip(3) {
            assert!(a.power < 0.2 * b.power, "{a:?} {b:?}");
        }
    }

    #[test]
    fn units_and_direction_do_not_matter() {
        let (op, pv) = recording(2.0, 0.5, 800, 0.05);
        let base = information(&op, &pv, Some(90.0)).unwrap();
        let turned: Vec<f64> = pv.iter().map(|v| 300.0 - 17.0 * v).collect();
        let moved: Vec<f64> = op.iter().map(|v| 100.0 - v).collect();
        let other = information(&moved, &turned, Some(90.0)).unwrap();
        for (a, b) in base.profile.iter().zip(&other.profile) {
            assert!((a.z - b.z).abs() < 1e-3 && (a.gain - b.gain).abs() < 1e-2, "{a:?} {b:?}");
            assert!((a.power - b.power).abs() < 1e-2 * (1.0 + a.power));
        }
    }

    #[test]
    fn every_width_gives_the_same() {
        let (op, pv) = recording(2.0, 0.5, 800, 0.05);
        let range = quantile(&op, 0.995) - quantile(&op, 0.005);
        let problem = Problem::of(&op, &pv, range, 1).unwrap();
        let models = [Model::TwoPhase, Model::He];
        let valves =
            std::array::from_fn(|l| Candidate { s: 0.2, j: 0.5, model: models[l % 2], place: 0.0 });
        let all: Vec<(Vec<Lane>, Lane)> = Width::available()
            .map(|width| {
                width.run(Stems {
                    valves: starting(valves, 0.0),
                    op: &problem.op,
                    factor: 1,
                    instants: problem.instants,
                })
            })
            .collect();
        assert!(all.iter().all(|each| *each == all[0]) && all[0].1[0] > 3.0);
    }

    #[test]
    fn lanes_of_both_models_move_as_the_models() {
        let (op, _) = recording(2.0, 0.5, 800, 0.05);
        let models = [Model::TwoPhase, Model::He];
        let valves: [Candidate; LANES] = std::array::from_fn(|l| Candidate {
            s: 2.0,
            j: l as f64 / LANES as f64,
            model: models[l % 2],
            place: 0.0,
        });
        let mut lanes = starting(valves, op[0]);
        let mut alone = valves.map(|v| {
            let mut valve = v.model.build(Bands::from_s_j(v.s, v.j * v.s).unwrap()).unwrap();
            valve.restart(Start::at_rest(op[0]));
            valve
        });
        for u in op {
            for (l, valve) in alone.iter_mut().enumerate() {
                assert_eq!(lanes.step(l, u), valve.step(u), "{:?}", valves[l]);
            }
        }
    }

    #[test]
    fn invalid_requests_are_refused() {
        let (op, pv) = recording(2.0, 0.5, 800, 0.05);
        assert!(information(&op[..50], &pv[..50], None).is_err());
        assert!(information(&op, &pv[1..], None).is_err());
        assert!(information(&op, &vec![3.0; 800], None).is_err());
        assert!(information(&vec![3.0; 800], &pv, None).is_err());
        let mut broken = pv.clone();
        broken[7] = f64::NAN;
        assert!(information(&op, &broken, None).is_err());
        // A PV that hardly ever changes still leaves something to predict.
        let held: Vec<f64> = (0..800).map(|k| pv[k - k % 90]).collect();
        if let Ok(told) = information(&op, &held, None) {
            assert!(told.profile.iter().all(|at| at.z.is_finite() && at.power.is_finite()));
        }
    }
}
