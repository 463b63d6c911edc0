//! Valve models fitted to a recorded valve position.
//!
//! # What it measures
//! Which of the data-driven models follows the recorded position (VP) best, with which S and J, and how certain these
//! are.
//!
//! # Assumptions
//! OP and VP are sampled at the same times, densely enough to see the stem rest and slip. The valve does
//! not change within the recording.
//!
//! # Equations
//! ```text
//! x = model(u; S, J),    VP(k) = g x(k - d) + o + e(k),    d from 0 to 3 samples
//! explained = 1 - sum e^2 / sum (VP - mean VP)^2
//! information = m ln(mean e^2) + p ln m            over m samples (Schwarz)
//! ```
//! p is 2 for models with S and J, 1 for models with one of them, and 0 for the valve that follows. The model with the
//! lowest information ranks first. Least squares gives gain g and offset o, so VP may have another scale than OP. S and
//! J are in percent of OP. The search uses a grid of fs and fd, then finer ones around its best point.
//!
//! A model that is at rest after every sample (He, He and Wang, Stenman) never forgets its initial position, and
//! accumulates small errors from slip to slip. It is restarted in each of [`BLOCKS`] parts of the recording, at VP,
//! with the g and o of the two-phase model; each start counts as a parameter.
//!
//! The intervals come from a bootstrap of moving blocks. The recording is cut into blocks, which are drawn with
//! replacement [`DRAWS`] times. Each time the result is the candidate around the best with the smallest error in the
//! drawn blocks. The interval contains the middle 90 % of the results. It is widened by half of the OP movement in a
//! sample, because no slip can be timed better.
//!
//! # Parameters
//! None. Constants: [`DRAWS`], [`BLOCKS`], [`MOST_SAMPLES`]; ours.
//!
//! # Limits
//! J is at most S: slips that overshoot the input are not among the candidates, except in He and Wang's model.
//! Kano's and Choudhury's models are equal to the two-phase model there, and are not fitted again. A stem that lags
//! by more than a few samples makes J small. Of a recording longer than [`MOST_SAMPLES`] only the beginning is
//! fitted.
//!
//! # Deviations from the paper
//! None; everything is ours.
//!
//! # References
//! The models: see [`crate::valve`]. H. R. Künsch, The jackknife and the bootstrap for general stationary
//! observations, Annals of Statistics 17 (1989) 1217-1241 (recalled, not read).

use super::slips::Motion;
use crate::Bands;
use crate::finding::Abstention;
use crate::parallel::*;
use crate::series::{quantile, span};
use crate::valve::lanes::{self, Laned};
use crate::valve::{self, Description, Direction, He, Model, Start, TwoPhase, Valve};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Smallest number of samples for a fit.
pub const FEWEST_SAMPLES: usize = 50;
/// Number of samples above which only the beginning is fitted.
pub const MOST_SAMPLES: usize = 10_000;
/// Number of draws of blocks.
pub const DRAWS: usize = 200;
/// Number of blocks of the recording.
pub const BLOCKS: usize = 20;
/// Delays of the recorded position, samples.
const DELAYS: usize = 4;
/// Largest and smallest fs to try, spans of the OP.
const LARGEST: f64 = 1.0;
const SMALLEST: f64 = 0.003;
/// Number of values of fs and of fd over fs in the first grid.
const COARSE: (usize, usize) = (40, 6);
/// These values for models that are at rest after every sample, whose errors accumulate from slip to slip.
const COARSE_STAIRCASE: (usize, usize) = (16, 64);
/// Position of fs in that grid, shares of half the range of the distance between OP and position.
const ABOUT: [f64; 2] = [0.7, 1.1];
/// Quantiles that limit that range.
const RANGE: [f64; 2] = [0.003, 0.997];
/// Number of values of fs and of fd over fs in a finer grid.
const FINE: usize = 8;
/// Finer grids at each delay, further ones at the best delay, and how much narrower each is.
const ROUNDS_AT_EACH: usize = 3;
const ROUNDS: usize = 6;
const NARROWER: f64 = 0.55;
/// Explained share of the variance at which only rounding remains.
const FLOOR: f64 = 1e-12;

/// A number with the interval of the bootstrap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The value of the fit.
    pub value: f64,
    /// Lower end; never negative.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A valve model fitted to a recorded position.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionFit {
    /// The model.
    pub model: Model,
    /// S and J, percent of span of the OP.
    pub bands: Bands,
    /// Percent of VP per percent of the model's position.
    pub gain: f64,
    /// VP where the model's position is 0, percent.
    pub offset: f64,
    /// Samples by which VP lags the model.
    pub delay: usize,
    /// Root mean square error, percent of VP.
    pub rmse: f64,
    /// Share of the variance of VP that is explained.
    pub explained: f64,
    /// Schwarz's information; only differences are meaningful.
    pub information: f64,
    /// Number of slips of the model.
    pub slips: usize,
    /// VP of the model, percent.
    pub vp: Vec<f64>,
}

/// All models fitted to a recorded position.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionFits {
    /// The fits, the best first.
    pub ranked: Vec<PositionFit>,
    /// S of the best, percent of span of the OP.
    pub s: Interval,
    /// J of the best, percent of span of the OP.
    pub j: Interval,
}

impl PositionFits {
    /// The best fit.
    pub fn best(&self) -> &PositionFit {
        &self.ranked[0]
    }
}

/// The models that differ from each other for J up to S. Models with the fewest parameters come first, so of two
/// equally good fits the simpler is the better.
fn models() -> Vec<Model> {
    let mut models: Vec<_> =
        Model::ALL.into_iter().filter(|model| model.describe().same_as.is_none()).collect();
    models.sort_by_key(|model| (parameters(*model), model.describe().uses_j));
    models
}

/// Number of bands of a model.
fn parameters(model: Model) -> usize {
    let Description { uses_s, uses_j, .. } = model.describe();
    usize::from(uses_s) + usize::from(uses_j)
}

/// Fits every model to a recorded position; both in percent of span.
///
/// ```
/// use stiction_model::{Bands, valve::{Model, Valve}};
/// use stiction_diagnose::identify::position;
/// let op: Vec<f64> = (0..1500).map(|k| 50.0 + 8.0 * (0.02 * k as f64).sin()).collect();
/// let mut valve = Model::TwoPhase.build(Bands::from_s_j(5.0, 2.0)?)?;
/// let mut vp = vec![0.0; op.len()];
/// valve.run(&op, &mut vp)?;
/// let fits = position::fit(&op, &vp).expect("it moves");
/// assert_eq!(fits.best().model, Model::TwoPhase);
/// // Accurate to about a step of the OP, because a slip cannot be located better.
/// assert!((fits.s.value - 5.0).abs() < 0.25 && (fits.j.value - 2.0).abs() < 0.25);
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If the signals have fewer than [`FEWEST_SAMPLES`] samples or differ in length, a sample is not finite or beyond 1e9
/// percent, or a signal is constant.
pub fn fit(op: &[f64], vp: &[f64]) -> Result<PositionFits, Abstention> {
    if op.len() != vp.len() || op.len() < FEWEST_SAMPLES {
        return Err(Abstention(format!(
            "a valve model needs at least {FEWEST_SAMPLES} samples of both OP and valve position; there are {} and \
             {}",
            op.len(),
            vp.len()
        )));
    }
    let n = op.len().min(MOST_SAMPLES);
    let (op, vp) = (&op[..n], &vp[..n]);
    if !op.iter().chain(vp).all(|v| v.abs() < 1e9) {
        return Err(Abstention("a sample of OP or valve position is not a percentage".to_owned()));
    }
    if !(span(op) > 1e-9 && span(vp) > 1e-9) {
        return Err(Abstention("the OP or the valve position does not move".to_owned()));
    }
    let record = Record::of(op, vp);
    // The two-phase model, which is robust, gives zero and full scale of VP.
    let known = record
        .search(Model::TwoPhase, &record.unscaled())
        .and_then(|found| record.scaled(&found.line))
        .unwrap_or_else(|| record.unscaled());
    let mut ranked: Vec<PositionFit> = models()
        .into_iter()
        .filter_map(|model| record.fit(model, parameters(model), &known))
        .collect();
    ranked.sort_by(|a, b| a.information.total_cmp(&b.information));
    let Some(best) = ranked.first() else {
        return Err(Abstention("no valve model can be fitted to the valve position".to_owned()));
    };
    let (s, j) = record.intervals(best, &known);
    Ok(PositionFits { s, j, ranked })
}

/// The tried bands. In fs and fd/fs the errors have no ridge: fs determines when the stem slips, and fd/fs how far.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    fs: f64,
    /// fd over fs: 0 for S = J, 1 for J = 0.
    ratio: f64,
    line: Line,
}

/// `VP = gain x + offset` at the best delay, and the unexplained share of the variance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub gain: f64,
    pub offset: f64,
    pub delay: usize,
    pub left: f64,
}

impl Line {
    /// VP of a model at the positions `x`.
    pub fn vp(&self, x: &[f64]) -> Vec<f64> {
        let at = |k: usize| self.gain * x[k.saturating_sub(self.delay)] + self.offset;
        (0..x.len()).map(at).collect()
    }
}

/// The recorded position.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// At the first sample of each block, percent of OP.
    positions: [f64; BLOCKS],
    /// Half the range of its distance from the OP, percent: about fs.
    reach: f64,
}

/// Sums over samples of a model's position, and of its products with VP at each delay. A level is subtracted from both
/// signals.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    x: f64,
    xx: f64,
    xy: [f64; DELAYS],
}

/// The data for the fit of models.
pub(super) struct Record<'a> {
    op: &'a [f64],
    vp: &'a [f64],
    /// Compared samples of the model: after each, VP is known at all delays.
    pub compared: usize,
    /// VP less its mean.
    y: Vec<f64>,
    level: f64,
    /// Middle of the OP, subtracted from positions before they are squared.
    middle: f64,
    /// Sum, and sum of squares around the mean, of VP at each delay.
    target: [(f64, f64); DELAYS],
}

impl<'a> Record<'a> {
    pub fn of(op: &'a [f64], vp: &'a [f64]) -> Self {
        let compared = op.len() + 1 - DELAYS;
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let (level, middle) = (mean(vp), mean(op));
        let y: Vec<f64> = vp.iter().map(|v| v - level).collect();
        let target = std::array::from_fn(|d| {
            let seen = &y[d..d + compared];
            let sum: f64 = seen.iter().sum();
            let squares: f64 = seen.iter().map(|v| v * v).sum();
            (sum, squares - sum * sum / compared as f64)
        });
        Self { op, vp, compared, y, level, middle, target }
    }

    /// The recorded position, if VP has the scale of the OP except for an offset.
    fn unscaled(&self) -> Scale {
        self.scale(1.0, 0.0, 0)
    }

    /// The recorded position if `line` leads from position to VP, else `None`.
    fn scaled(&self, line: &Line) -> Option<Scale> {
        (line.gain != 0.0).then(|| self.scale(line.gain, line.offset, line.delay))
    }

    fn scale(&self, gain: f64, offset: f64, delay: usize) -> Scale {
        let position = |v: f64| (v - offset) / gain;
        let pairs = self.op.iter().zip(&self.vp[delay..]);
        let distances: Vec<f64> = pairs.map(|(u, v)| u - position(*v)).collect();
        let [low, high] = RANGE.map(|p| quantile(&distances, p));
        let middle = 0.5 * (low + high);
        let at = |block: usize| position(self.vp[self.begin(block) + delay]) + middle;
        Scale { positions: std::array::from_fn(at), reach: 0.5 * (high - low) }
    }

    /// The first sample of a block.
    fn begin(&self, block: usize) -> usize {
        block * self.compared / BLOCKS
    }

    /// The pieces of the recording for `model`, each with its first sample and start.
    fn pieces(&self, model: Model, known: &Scale) -> Vec<(usize, &'a [f64], Start)> {
        let blocks = if staircase(model) { BLOCKS } else { 1 };
        let piece = |block: usize| {
            let from = self.begin(block);
            let to = if block + 1 < blocks { self.begin(block + 1) } else { self.op.len() };
            let (position, op) = (known.positions[block], self.op[from]);
            let start = Start { position, op, direction: Direction::Up, moving: false };
            (from, &self.op[from..to], start)
        };
        (0..blocks).map(piece).collect()
    }

    /// The best line through `sums`, at each delay.
    pub fn lines(&self, sums: &Sums) -> [Line; DELAYS] {
        let m = self.compared as f64;
        let xx = sums.xx - sums.x * sums.x / m;
        std::array::from_fn(|delay| {
            let (sum, total) = self.target[delay];
            let xy = sums.xy[delay] - sums.x * sum / m;
            let left = 1.0 - xy * xy / (xx * total);
            if left < 1.0 {
                let gain = xy / xx;
                let offset = self.level + (sum - gain * sums.x) / m - gain * self.middle;
                Line { gain, offset, delay, left: left.max(0.0) }
            } else {
                // The position or its record does not move.
                Line { gain: 0.0, offset: self.level, delay, left: 1.0 }
            }
        })
    }

    pub fn gather(&self, sums: &mut Sums, at: usize, x: f64) {
        if at < self.compared {
            let x = x - self.middle;
            sums.x += x;
            sums.xx += x * x;
            for (d, product) in sums.xy.iter_mut().enumerate() {
                *product += x * self.y[at + d];
            }
        }
    }

    /// Tries pairs of fs and fd over fs, and returns the best at each delay.
    fn try_all(
        &self,
        model: Model,
        pairs: &[(f64, f64)],
        known: &Scale,
    ) -> Option<[Candidate; DELAYS]> {
        let bands: Vec<Bands> = pairs.iter().map(|&(fs, ratio)| bands(fs, ratio)).collect();
        let mut sums = vec![Sums::default(); pairs.len()];
        for (from, op, start) in self.pieces(model, known) {
            match model {
                Model::TwoPhase => self.lanes::<TwoPhase>(&mut sums, &bands, from, op, start),
                // At S = J this is Stenman's model.
                Model::He | Model::Stenman => {
                    self.lanes::<He>(&mut sums, &bands, from, op, start);
                }
                // Any other: a valve for each pair.
                _ => sums.par_iter_mut().zip(&bands).for_each(|(sums, bands)| {
                    if let Ok(mut valve) = model.build(*bands) {
                        valve.restart(start);
                        for (k, u) in op.iter().enumerate() {
                            self.gather(sums, from + k, valve.step(*u));
                        }
                    }
                }),
            }
        }
        let candidates = pairs
            .iter()
            .zip(&sums)
            .map(|(&(fs, ratio), sums)| self.lines(sums).map(|line| Candidate { fs, ratio, line }));
        candidates.reduce(|a, b| std::array::from_fn(|d| better(a[d], b[d])))
    }

    fn lanes<M: Laned>(
        &self,
        sums: &mut [Sums],
        bands: &[Bands],
        from: usize,
        op: &[f64],
        start: Start,
    ) {
        let gathered = lanes::run::<M, _>(
            bands,
            start,
            op,
            |first| {
                let mut lanes = [Sums::default(); lanes::LANES];
                for (lane, sums) in lanes.iter_mut().zip(&sums[first..]) {
                    *lane = *sums;
                }
                lanes
            },
            |lanes, at, vp| {
                for (k, x) in vp.iter().enumerate() {
                    for (l, sums) in lanes.iter_mut().enumerate() {
                        self.gather(sums, from + at + k, x[l]);
                    }
                }
            },
        );
        // The recording was checked, so this cannot fail.
        for (sums, lane) in sums.iter_mut().zip(gathered.unwrap_or_default().concat()) {
            *sums = lane;
        }
    }

    /// The best S and J of a model that has `parameters`, and its fit to the recording.
    fn fit(&self, model: Model, parameters: usize, known: &Scale) -> Option<PositionFit> {
        let best = self.search(model, known)?;
        let Line { gain, offset, delay, left } = best.line;
        let bands = bands(best.fs, best.ratio);
        let x = self.positions(model, bands, known)?;
        let parameters = parameters + if staircase(model) { BLOCKS } else { 0 };
        Some(PositionFit {
            model,
            bands,
            gain,
            offset,
            delay,
            rmse: self.rmse(&best.line),
            explained: 1.0 - left,
            information: self.information(&best.line, parameters),
            slips: Motion::of(&x).slips.len(),
            vp: best.line.vp(&x),
        })
    }

    /// Root mean square error of `line`, percent of VP.
    pub fn rmse(&self, line: &Line) -> f64 {
        (line.left * self.target[line.delay].1 / self.compared as f64).sqrt()
    }

    /// Schwarz's information of a model whose VP is given by `line`.
    pub fn information(&self, line: &Line, parameters: usize) -> f64 {
        let m = self.compared as f64;
        let variance = self.target[line.delay].1 / m;
        m * ((line.left + FLOOR) * variance).ln() + parameters as f64 * m.ln()
    }

    fn positions(&self, model: Model, bands: Bands, known: &Scale) -> Option<Vec<f64>> {
        let mut valve = model.build(bands).ok()?;
        let mut x = vec![0.0; self.op.len()];
        for (from, op, start) in self.pieces(model, known) {
            valve.restart(start);
            valve.run(op, &mut x[from..from + op.len()]).ok()?;
        }
        Some(x)
    }

    fn search(&self, model: Model, known: &Scale) -> Option<Candidate> {
        let range = span(self.op);
        let Description { motion, uses_s, uses_j, .. } = model.describe();
        if motion == valve::Motion::Follows {
            return self.try_all(model, &[(0.0, 0.0)], known)?.into_iter().reduce(better);
        }
        let ratios = |count: usize, low: f64, high: f64| match (uses_s, uses_j) {
            (true, true) => spaced(count, low, high),
            (true, false) => vec![1.0],
            (false, _) => vec![0.0],
        };
        let grid = |fs: Vec<f64>, ratios: Vec<f64>| -> Vec<(f64, f64)> {
            ratios.iter().flat_map(|ratio| fs.iter().map(|fs| (fs.exp(), *ratio))).collect()
        };
        let (count, count_ratios) = if staircase(model) { COARSE_STAIRCASE } else { COARSE };
        let [low, high] = if staircase(model) && known.reach > 0.0 {
            ABOUT.map(|share| (share * known.reach).ln())
        } else {
            [SMALLEST, LARGEST].map(|share| (share * range).ln())
        };
        let coarse = grid(spaced(count, low, high), ratios(count_ratios, 0.0, 1.0));
        // A delay and a dead band can replace each other, with a ridge between: both sides are searched.
        let half_ratio = 1.5 / count_ratios as f64;
        let finer = |mut best: Candidate, rounds: std::ops::Range<usize>, any_delay: bool| {
            for round in rounds {
                let narrower = NARROWER.powi(round as i32);
                let half = 1.5 * (high - low) / count as f64 * narrower;
                let fs = spaced(FINE, best.fs.ln() - half, best.fs.ln() + half);
                let (less, more) =
                    (best.ratio - half_ratio * narrower, best.ratio + half_ratio * narrower);
                let about = ratios(FINE, less.max(0.0), more.min(1.0));
                for found in self.try_all(model, &grid(fs, about), known)? {
                    if any_delay || found.line.delay == best.line.delay {
                        best = better(best, found);
                    }
                }
            }
            Some(best)
        };
        let coarse = self.try_all(model, &coarse, known)?;
        let at_each = coarse.into_iter().filter_map(|best| finer(best, 0..ROUNDS_AT_EACH, false));
        finer(at_each.reduce(better)?, ROUNDS_AT_EACH..ROUNDS_AT_EACH + ROUNDS, true)
    }

    /// Intervals of S and J of the best fit. For the valve that follows, these are the intervals of a play that would
    /// look like it.
    fn intervals(&self, fit: &PositionFit, known: &Scale) -> (Interval, Interval) {
        let range = span(self.op);
        let Description { motion, uses_s, uses_j, .. } = fit.model.describe();
        let ideal = motion == valve::Motion::Follows;
        let model = if ideal { Model::Play } else { fit.model };
        let (s, j) = (fit.bands.s(), fit.bands.j());
        let (mut low, mut high) = ((s, j), (s, j));
        let (mut reach_s, mut reach_j) =
            if ideal { (0.05 * range, 0.0) } else { (0.3 * s, 0.3 * s) };
        if !(uses_s && uses_j) {
            reach_j = 0.0;
        }
        for _ in 0..3 {
            let count_j = if reach_j > 0.0 { 2 * FINE } else { 1 };
            let mut pairs = vec![(s, j)];
            for s in spaced(2 * FINE, (s - reach_s).max(0.0), s + reach_s) {
                for j in spaced(count_j, (j - reach_j).max(0.0), j + reach_j) {
                    let j = if uses_j && !uses_s { s } else { j.min(s) };
                    pairs.push((s, j));
                }
            }
            let errors: Vec<[f64; BLOCKS]> =
                pairs.par_iter().map(|&(s, j)| self.errors(model, s, j, known)).collect();
            let (mut drawn_s, mut drawn_j) = (vec![], vec![]);
            let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
            for _ in 0..DRAWS {
                let mut weights = [0.0; BLOCKS];
                for _ in 0..BLOCKS {
                    weights[random.random_range(0..BLOCKS)] += 1.0;
                }
                let left = |errors: &[f64; BLOCKS]| -> f64 {
                    errors.iter().zip(&weights).map(|(e, w)| e * w).sum()
                };
                let left = errors.iter().map(left).enumerate();
                if let Some((at, _)) = left.min_by(|a, b| a.1.total_cmp(&b.1)) {
                    drawn_s.push(pairs[at].0);
                    drawn_j.push(pairs[at].1);
                }
            }
            let ends = |x: &[f64]| (quantile(x, 0.05), quantile(x, 0.95));
            let ((s_low, s_high), (j_low, j_high)) = (ends(&drawn_s), ends(&drawn_j));
            (low, high) = ((s_low, j_low), (s_high, j_high));
            // A finer search, but not finer than the best result extends.
            let step = |reach: f64| reach / FINE as f64;
            let closer = |reach: f64, value: f64, low: f64, high: f64| {
                reach.min((high - value).max(value - low) + step(reach))
            };
            reach_s = closer(reach_s, s, s_low, s_high);
            reach_j = closer(reach_j, j, j_low, j_high);
        }
        let moves: Vec<f64> = self.op.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
        let moves: Vec<f64> = moves.into_iter().filter(|v| *v > 0.0).collect();
        let resolution = 0.5 * moves.iter().sum::<f64>() / moves.len().max(1) as f64;
        let interval = |value: f64, low: f64, high: f64, exact: bool| {
            let wider = if exact { 0.0 } else { resolution };
            let (low, high) = (low.min(value) - wider, high.max(value) + wider);
            Interval { value, low: low.max(0.0), high }
        };
        (interval(s, low.0, high.0, false), interval(j, low.1, high.1, !uses_j))
    }

    /// Sum of squared errors in each block for a candidate with its own best line.
    fn errors(&self, model: Model, s: f64, j: f64, known: &Scale) -> [f64; BLOCKS] {
        let mut blocks = [0.0; BLOCKS];
        let bands = Bands::from_s_j(s, j.min(s)).unwrap_or(Bands::NONE);
        let Some(x) = self.positions(model, bands, known) else {
            return [f64::INFINITY; BLOCKS];
        };
        let mut sums = Sums::default();
        for (k, x) in x.iter().enumerate() {
            self.gather(&mut sums, k, *x);
        }
        let [first, others @ ..] = self.lines(&sums);
        let line = others.into_iter().fold(first, |a, b| if b.left < a.left { b } else { a });
        for (k, x) in x[..self.compared].iter().enumerate() {
            let error = self.vp[k + line.delay] - line.gain * x - line.offset;
            blocks[k * BLOCKS / self.compared] += error * error;
        }
        blocks
    }
}

/// Whether a model is at rest after every sample.
fn staircase(model: Model) -> bool {
    model.describe().motion == valve::Motion::Staircase
}

fn bands(fs: f64, ratio: f64) -> Bands {
    Bands::from_fs_fd(fs, ratio * fs).unwrap_or(Bands::NONE)
}

/// `count` evenly spaced numbers between two numbers; for a count of one, their middle.
pub(super) fn spaced(count: usize, low: f64, high: f64) -> Vec<f64> {
    if count < 2 {
        return vec![0.5 * (low + high)];
    }
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

/// The candidate with the smaller error; the first of equals.
fn better(a: Candidate, b: Candidate) -> Candidate {
    if b.line.left < a.line.left { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    /// An OP that swings by 16 %, unevenly.
    fn op(n: usize) -> Vec<f64> {
        let wave = |k: f64| 50.0 + 8.0 * (0.021 * k).sin() + 3.0 * (0.0057 * k).sin();
        (0..n).map(|k| wave(k as f64)).collect()
    }

    fn driven(model: Model, s: f64, j: f64, op: &[f64]) -> Vec<f64> {
        let mut valve = model.build(Bands::from_s_j(s, j).unwrap()).unwrap();
        valve.restart(Start::at_rest(50.0));
        let mut vp = vec![0.0; op.len()];
        valve.run(op, &mut vp).unwrap();
        vp
    }

    #[test]
    fn every_model_is_recovered_from_what_it_does() {
        let op = op(2000);
        for (model, s, j) in [
            (Model::TwoPhase, 5.0, 2.0),
            (Model::He, 4.0, 1.5),
            (Model::HeWang, 5.0, 1.5),
            (Model::Chen, 5.0, 3.0),
            (Model::Stenman, 3.0, 3.0),
            (Model::Play, 3.0, 0.0),
        ] {
            let fits = fit(&op, &driven(model, s, j, &op)).unwrap();
            let of_model = fits.ranked.iter().find(|f| f.model == model).unwrap();
            let (found_s, found_j) = (of_model.bands.s(), of_model.bands.j());
            let close = (found_s - s).abs() < 0.15 && (found_j - j).abs() < 0.15;
            assert!(close, "{model:?}: S {found_s:.3} J {found_j:.3}");
            assert!(of_model.explained > 0.98, "{model:?}: {}", of_model.explained);
            assert!(of_model.slips > 10, "{model:?}: {}", of_model.slips);
        }
    }

    #[test]
    fn noise_quantum_scale_and_delay_are_seen_through() {
        let op = op(2000);
        for (seed, s, j) in [(1, 5.0, 2.0), (2, 2.0, 1.0), (3, 8.0, 4.0), (4, 6.0, 0.5)] {
            let x = driven(Model::TwoPhase, s, j, &op);
            let mut noise = NormalStream::new(seed);
            let vp: Vec<f64> = (0..x.len())
                .map(|k| {
                    let seen = 3.0 + 0.9 * x[k.saturating_sub(2)] + 0.1 * noise.draw();
                    (seen / 0.25).round() * 0.25
                })
                .collect();
            let fits = fit(&op, &vp).unwrap();
            let best = fits.best();
            assert_eq!(best.model, Model::TwoPhase);
            assert!((best.gain - 0.9).abs() < 0.01 && (best.offset - 3.0).abs() < 0.6);
            // On slow ramps a delay is hardly told from a dead band: 0.17 % a sample each way.
            assert!(best.delay.abs_diff(2) <= 1, "{}", best.delay);
            assert!((fits.s.value - s).abs() < 0.35 && (fits.j.value - j).abs() < 0.35);
            assert!(fits.s.low <= s && s <= fits.s.high, "{:?}", fits.s);
            assert!(fits.j.low <= j && j <= fits.j.high, "{:?}", fits.j);
        }
    }

    #[test]
    fn a_healthy_valve_has_none() {
        let op = op(2000);
        let mut noise = NormalStream::new(5);
        let vp: Vec<f64> = op.iter().map(|u| u + 0.1 * noise.draw()).collect();
        let fits = fit(&op, &vp).unwrap();
        assert_eq!(fits.best().model, Model::Ideal, "{:?}", fits.best().bands);
        assert_eq!((fits.s.value, fits.j.value), (0.0, 0.0));
        assert!(fits.s.high < 0.3, "{:?}", fits.s);
    }

    #[test]
    fn scale_and_direction_do_not_matter() {
        let op = op(1500);
        let vp = driven(Model::TwoPhase, 5.0, 2.0, &op);
        let fits = fit(&op, &vp).unwrap();
        let doubled = |x: &[f64]| x.iter().map(|v| 2.0 * v).collect::<Vec<_>>();
        let twice = fit(&doubled(&op), &doubled(&vp)).unwrap();
        assert!((twice.s.value - 2.0 * fits.s.value).abs() < 1e-9);
        let mirror = |x: &[f64]| x.iter().map(|v| 100.0 - v).collect::<Vec<_>>();
        let mirrored = fit(&mirror(&op), &mirror(&vp)).unwrap();
        assert!((mirrored.s.value - fits.s.value).abs() < 1e-6);
        assert_eq!(fits, fit(&op, &vp).unwrap());
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let op = op(100);
        assert!(fit(&op, &op[..99]).is_err());
        assert!(fit(&op, &[1.0; 100]).is_err());
        assert!(fit(&op[..20], &op[..20]).is_err());
        assert!(fit(&op, &vec![f64::NAN; 100]).is_err());
        let wild: Vec<f64> = op.iter().map(|u| u * 1e-8).collect();
        assert!(fit(&op, &wild).is_ok());
    }
}
