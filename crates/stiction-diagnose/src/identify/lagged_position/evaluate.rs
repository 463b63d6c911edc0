//! Distance of each candidate valve with its lag from the recorded position: sixteen candidates at a time.
//!
//! The first pass gathers sums along a candidate's path, whitened like the position. From them gain and delay of
//! each lag follow in closed form. The second pass gives the residual of the best lag.
//!
//! ```text
//! y(k) = a y(k-1) + b x(k),   a = e^(-1/T), b = 1 - a
//! P = sum x(k) y(k-1),   C3 = sum v(k) y(k-3),   Xj = sum v(k) x(k-j)
//! s0 = sum y^2 = (b^2 sum x^2 + 2 a b P + a^2 D) / (1 - a^2),   D = y(first - 1)^2 - y(last)^2
//! s1 = sum y(k) y(k-1) = a (s0 + D) + b P
//! Cj = sum v(k) y(k-j) = a C(j+1) + b Xj
//! ```
//! so that a lag costs one recursion and two products a sample. A second lag behind the first is the same with `y`
//! for `x`.

use super::between::HeBetweenLanes;
use super::candidate::{BLOCKS, Candidate, Fitted, Friction, Place};
use crate::bands::Bands;
use crate::parallel::*;
use crate::simd::{Kernel, LANES, Width};
use crate::valve::lanes::{LaneValve, Laned};
use crate::valve::{Direction, He, Start, TwoPhase};

type Lane = crate::simd::Lane;

/// Delays to try, samples. Each candidate has one tap at the delay and one a sample later.
const DELAYS: usize = 3;
/// Taps in all.
pub(super) const TAPS: usize = DELAYS + 1;
/// Samples stepped at a time: few enough that the path stays in the first-level cache.
const CHUNK: usize = 96;

/// A continuous part of the simulation.
pub(super) struct Piece<'a> {
    /// OP less its mean.
    pub u: &'a [f64],
    /// VP less its mean.
    pub v: &'a [f64],
    /// Stem position at the first sample, on the scale of `u`.
    pub start: f64,
    /// Samples that are simulated and not scored.
    pub burn: usize,
}

impl Piece<'_> {
    pub fn scored(&self) -> usize {
        self.u.len() - self.burn
    }
}

/// The reference for candidates, and the comparison.
pub(super) struct Target<'a> {
    pieces: &'a [Piece<'a>],
    /// VP less `rho` times the sample before, less its mean over the scored samples. It is 0 where VP is not scored,
    /// and in [`TAPS`] further samples.
    whitened: Vec<Vec<f64>>,
    rho: f64,
    /// Residual from which the loss is linear; infinite for squares.
    huber: f64,
    scored: usize,
    /// Limits of the gain.
    gain: (f64, f64),
}

impl<'a> Target<'a> {
    pub fn new(pieces: &'a [Piece<'a>], rho: f64, huber: f64, gain: (f64, f64)) -> Self {
        let whitened = pieces.iter().map(|piece| {
            let mut white = vec![0.0; piece.v.len() + TAPS];
            for k in piece.burn..piece.v.len() {
                white[k] = piece.v[k] - rho * piece.v[k - 1];
            }
            let mean = white.iter().sum::<f64>() / piece.scored() as f64;
            white[piece.burn..piece.v.len()].iter_mut().for_each(|v| *v -= mean);
            white
        });
        let scored = pieces.iter().map(Piece::scored).sum();
        Self { pieces, whitened: whitened.collect(), rho, huber, scored, gain }
    }

    /// Fits each candidate at its best lag among `lags`, samples, and keeps the order. Runs on all threads of the
    /// current rayon pool; the result does not depend on their number.
    pub fn fit(&self, candidates: &[Candidate], lags: &[f64]) -> Vec<Fitted> {
        let width = Width::widest();
        // Lanes share their friction and the position of their lag.
        let mut order: Vec<usize> = (0..candidates.len()).collect();
        order.sort_by_key(|i| (candidates[*i].place, candidates[*i].friction));
        let groups = order.chunk_by(|a, b| {
            let (a, b) = (&candidates[*a], &candidates[*b]);
            (a.place, a.friction) == (b.place, b.friction)
        });
        let jobs: Vec<&[usize]> = groups.flat_map(|group| group.chunks(LANES)).collect();
        let done: Vec<Vec<(usize, Fitted)>> = jobs
            .into_par_iter()
            .map(|job| {
                let of: Vec<Candidate> = job.iter().map(|i| candidates[*i]).collect();
                let fitted = match of[0].friction {
                    Friction::TwoPhase => {
                        self.lanes::<<TwoPhase as Laned>::Lanes>(&of, lags, width)
                    }
                    Friction::He => self.lanes::<<He as Laned>::Lanes>(&of, lags, width),
                    Friction::HeBetween => self.lanes::<HeBetweenLanes>(&of, lags, width),
                };
                job.iter().copied().zip(fitted).collect()
            })
            .collect();
        let mut done: Vec<(usize, Fitted)> = done.into_iter().flatten().collect();
        done.sort_by_key(|(i, _)| *i);
        done.into_iter().map(|(_, fitted)| fitted).collect()
    }

    /// The scored residual of one candidate, not whitened. The caller subtracts the median of each piece.
    pub fn residual(&self, fitted: &Fitted) -> Vec<Vec<f64>> {
        let raw = Self {
            whitened: Target::new(self.pieces, 0.0, f64::INFINITY, self.gain).whitened,
            rho: 0.0,
            huber: f64::INFINITY,
            ..*self
        };
        let one = std::slice::from_ref(fitted);
        let width = Width::widest();
        let pieces = 0..self.pieces.len();
        let lane = |piece: usize| {
            let left = match fitted.candidate.friction {
                Friction::TwoPhase => raw.left::<<TwoPhase as Laned>::Lanes>(one, piece, width),
                Friction::He => raw.left::<<He as Laned>::Lanes>(one, piece, width),
                Friction::HeBetween => raw.left::<HeBetweenLanes>(one, piece, width),
            };
            left.iter().map(|left| left[0]).collect()
        };
        pieces.map(lane).collect()
    }

    fn lanes<L: LaneValve>(&self, of: &[Candidate], lags: &[f64], width: Width) -> Vec<Fitted> {
        let mut best = [Choice::NONE; LANES];
        match of[0].place {
            Place::After => {
                let stages: Vec<Stages> = lags.iter().map(|t| Stages::after(of, *t)).collect();
                let sums = self.sums::<L>(of, 0.0, &stages, width);
                for (lag, sums) in lags.iter().zip(&sums) {
                    self.choose(&mut best, *lag, sums);
                }
            }
            Place::Before => {
                for lag in lags {
                    let stages = [Stages::before(of, *lag)];
                    let sums = self.sums::<L>(of, *lag, &stages, width);
                    self.choose(&mut best, *lag, &sums[0]);
                }
            }
        }
        let mut fitted: Vec<Fitted> = of
            .iter()
            .zip(&best)
            .map(|(candidate, best)| Fitted {
                candidate: *candidate,
                lag: best.lag,
                delay: best.delay,
                taps: best.taps,
                loss: 0.0,
                blocks: [0.0; BLOCKS],
            })
            .collect();
        self.score::<L>(&mut fitted, width);
        fitted
    }

    /// The sums of each of `stages` over all pieces. Each piece is taken about its mean.
    fn sums<L: LaneValve>(
        &self,
        of: &[Candidate],
        before: f64,
        stages: &[Stages],
        width: Width,
    ) -> Vec<Sums> {
        let mut all = vec![Sums::default(); stages.len()];
        for (piece, white) in self.pieces.iter().zip(&self.whitened) {
            let mut walk = Walk::<L>::new(of, piece, Lane::splat(decay(before)), self.rho);
            let mut runs: Vec<Run> = stages
                .iter()
                .map(|stages| Run::new(stages, piece.start * (1.0 - self.rho)))
                .collect();
            let n = piece.u.len();
            // The scored samples, relative to the last tap.
            let (first, last) = (piece.burn - DELAYS, n - DELAYS);
            let mut path = [Lane::splat(0.0); CHUNK];
            let mut edges = vec![0];
            edges.extend(first..=first + DELAYS);
            edges.extend(last..=n);
            for edge in edges.windows(2) {
                let (from, to) = (edge[0], edge[1]);
                let counted = (first..last).contains(&from);
                let mut at = from;
                while at < to {
                    let end = (at + CHUNK).min(to);
                    let path = &mut path[..end - at];
                    let (u, v) = (&piece.u[at..end], &white[at..end + DELAYS]);
                    walk = width.run(Step { walk, u, v, path, counted });
                    for (run, stages) in runs.iter_mut().zip(stages) {
                        let v = &v[DELAYS..];
                        *run = match stages.second {
                            Some(_) => {
                                width.run(Lag::<true> { run: *run, stages, path, v, counted })
                            }
                            None => width.run(Lag::<false> { run: *run, stages, path, v, counted }),
                        };
                    }
                    at = end;
                }
                if let Some(i) = (to + 1).checked_sub(first + 1).filter(|i| *i <= DELAYS) {
                    runs.iter_mut().for_each(|run| run.heads[i] = run.outputs());
                }
                if let Some(i) = to.checked_sub(last) {
                    runs.iter_mut().for_each(|run| run.tails[i] = run.outputs());
                }
            }
            for ((sums, run), stages) in all.iter_mut().zip(&runs).zip(stages) {
                sums.add(&walk.sums, run, stages, (last - first) as f64);
            }
        }
        all
    }

    /// Puts the candidate with the smallest loss in `best`.
    fn choose(&self, best: &mut [Choice; LANES], lag: f64, sums: &Sums) {
        for (l, best) in best.iter_mut().enumerate() {
            for delay in 0..DELAYS {
                let both = [delay, delay + 1];
                let squares = both.map(|j| sums.squares[j][l]);
                let answers = both.map(|j| sums.c[j][l]);
                let (taps, explained) = solve(squares, sums.products[delay][l], answers, self.gain);
                if explained > best.explained {
                    *best = Choice { explained, lag, delay, taps };
                }
            }
        }
    }

    /// The second pass: losses by block.
    fn score<L: LaneValve>(&self, of: &mut [Fitted], width: Width) {
        let mut done = 0;
        let mut blocks = [Lane::splat(0.0); BLOCKS];
        for (piece, held) in self.pieces.iter().enumerate() {
            let left = self.left::<L>(of, piece, width);
            // Sample g of all scored ones is in block g BLOCKS / scored.
            for (b, block) in blocks.iter_mut().enumerate() {
                let edge =
                    |b: usize| (b * self.scored).div_ceil(BLOCKS).max(done).min(done + left.len());
                let part = &left[edge(b) - done..edge(b + 1) - done];
                *block = width.run(Loss { left: part, huber: self.huber, sum: *block });
            }
            done += held.scored();
        }
        for (l, fitted) in of.iter_mut().enumerate() {
            fitted.blocks = std::array::from_fn(|b| blocks[b][l]);
            fitted.loss = fitted.blocks.iter().sum();
        }
    }

    /// The scored residuals in one piece, less their mean. At most sixteen fits are allowed, all with the same
    /// friction.
    fn left<L: LaneValve>(&self, of: &[Fitted], piece: usize, width: Width) -> Vec<Lane> {
        let (held, white) = (&self.pieces[piece], &self.whitened[piece]);
        let candidates: Vec<Candidate> = of.iter().map(|fitted| fitted.candidate).collect();
        let lane = |f: &dyn Fn(&Fitted) -> f64| Lane::from_fn(|l| f(&of[l.min(of.len() - 1)]));
        let before = lane(&|f| match f.candidate.place {
            Place::Before => decay(f.lag),
            Place::After => 0.0,
        });
        let stages = Stages {
            first: lane(&|f| match f.candidate.place {
                Place::Before => decay(f.lag * f.candidate.second),
                Place::After => decay(f.lag),
            }),
            second: Some(lane(&|f| match f.candidate.place {
                Place::Before => 0.0,
                Place::After => decay(f.lag * f.candidate.second),
            })),
        };
        let taps: [Lane; TAPS] = std::array::from_fn(|j| {
            lane(&|f| match j.checked_sub(f.delay) {
                Some(tap @ (0 | 1)) => f.taps[tap],
                _ => 0.0,
            })
        });
        let walk = Walk::<L>::new(&candidates, held, before, self.rho);
        let mut left = vec![Lane::splat(0.0); held.u.len()];
        let start = held.start * (1.0 - self.rho);
        width.run(Residuals { walk, stages, taps, u: held.u, v: white, start, left: &mut left });
        left.drain(..held.burn);
        let mut mean = Lane::splat(0.0);
        left.iter().for_each(|x| mean.add_scaled(x, 1.0));
        let share = 1.0 / left.len() as f64;
        left.iter_mut().for_each(|x| x.add_scaled(&mean, -share));
        left
    }
}

/// `e^(-1/T)`; 0 for no lag.
fn decay(lag: f64) -> f64 {
    if lag > 0.0 { (-1.0 / lag).exp() } else { 0.0 }
}

/// The lags and taps that explain most.
#[derive(Clone, Copy)]
struct Choice {
    explained: f64,
    lag: f64,
    delay: usize,
    taps: [f64; 2],
}

impl Choice {
    const NONE: Self = Self { explained: f64::NEG_INFINITY, lag: 0.0, delay: 0, taps: [1.0, 0.0] };
}

/// Gains of two neighbouring taps, neither negative, with their sum within limits, and the sum of squares that they
/// explain.
fn solve(
    [s00, s11]: [f64; 2],
    s01: f64,
    [c0, c1]: [f64; 2],
    (least, most): (f64, f64),
) -> ([f64; 2], f64) {
    let (mut g0, mut g1) = (0.0, 0.0);
    if s00 > 0.0 && s11 > 0.0 {
        let det = s00 * s11 - s01 * s01;
        if det > 1e-9 * s00 * s11 {
            (g0, g1) = ((s11 * c0 - s01 * c1) / det, (s00 * c1 - s01 * c0) / det);
        } else {
            g0 = c0 / s00;
        }
        if g0 < 0.0 {
            (g0, g1) = (0.0, c1 / s11);
        }
        if g1 < 0.0 {
            (g0, g1) = (c0 / s00, 0.0);
        }
    }
    let gain = g0 + g1;
    if gain <= 0.0 {
        (g0, g1) = (least, 0.0);
    } else {
        let scale = gain.clamp(least, most) / gain;
        (g0, g1) = (g0 * scale, g1 * scale);
    }
    let explained = 2.0 * (g0 * c0 + g1 * c1) - g0 * g0 * s00 - g1 * g1 * s11 - 2.0 * g0 * g1 * s01;
    ([g0, g1], explained)
}

/// The lags behind a path, one a lane, by the share of the output that remains after a sample.
struct Stages {
    first: Lane,
    /// `None` where no lane has one.
    second: Option<Lane>,
}

impl Stages {
    fn after(of: &[Candidate], lag: f64) -> Self {
        let second = of.iter().any(|c| c.second > 0.0);
        let each = |l: usize| decay(lag * of[l.min(of.len() - 1)].second);
        Self { first: Lane::splat(decay(lag)), second: second.then(|| Lane::from_fn(each)) }
    }

    /// Behind friction that comes after the first lag.
    fn before(of: &[Candidate], lag: f64) -> Self {
        Self { first: Lane::from_fn(|l| decay(lag * of[l.min(of.len() - 1)].second)), second: None }
    }
}

/// Sixteen simulated valves, and the sums of their whitened paths x.
#[derive(Clone, Copy)]
struct Walk<L> {
    valves: L,
    before: Lane,
    input: Lane,
    x: Lane,
    rho: f64,
    sums: PathSums,
}

/// Sums over the scored samples: of `v(k) x(k-j)`, x and x².
#[derive(Clone, Copy)]
struct PathSums {
    vx: [Lane; TAPS],
    x: Lane,
    xx: Lane,
}

impl<L: LaneValve> Walk<L> {
    fn new(of: &[Candidate], piece: &Piece<'_>, before: Lane, rho: f64) -> Self {
        let bands = std::array::from_fn(|l| of[l.min(of.len() - 1)].bands());
        let (position, op) = (piece.start, piece.u[0]);
        let start = Start { position, op, direction: Direction::Up, moving: false };
        let none = Lane::splat(0.0);
        Self {
            valves: L::starting(&bands, [start; LANES]),
            before,
            input: Lane::splat(op),
            x: Lane::splat(position),
            rho,
            sums: PathSums { vx: [none; TAPS], x: none, xx: none },
        }
    }

    /// The whitened path, one sample further.
    #[inline(always)]
    fn step(&mut self, u: f64) -> Lane {
        let (before, mut input) = (self.before, self.input);
        for l in 0..LANES {
            input[l] = u + before[l] * (input[l] - u);
        }
        self.input = input;
        let x = Lane::from_fn(|l| self.valves.step(l, input[l]));
        let white = Lane::from_fn(|l| x[l] - self.rho * self.x[l]);
        self.x = x;
        white
    }
}

struct Step<'a, L> {
    walk: Walk<L>,
    u: &'a [f64],
    /// Whitened VP from the first sample on, and [`DELAYS`] samples more.
    v: &'a [f64],
    path: &'a mut [Lane],
    counted: bool,
}

impl<L: LaneValve> Kernel for Step<'_, L> {
    type Output = Walk<L>;
    #[inline(always)]
    fn run(self) -> Walk<L> {
        let mut walk = self.walk;
        for (u, x) in self.u.iter().zip(self.path.iter_mut()) {
            *x = walk.step(*u);
        }
        for (j, sum) in walk.sums.vx.iter_mut().enumerate() {
            let mut s = *sum;
            for (x, v) in self.path.iter().zip(&self.v[j..]) {
                s.add_scaled(x, *v);
            }
            *sum = s;
        }
        if self.counted {
            let (mut s, mut ss) = (walk.sums.x, walk.sums.xx);
            for x in self.path.iter() {
                s.add_scaled(x, 1.0);
                ss.add_product(x, x);
            }
            (walk.sums.x, walk.sums.xx) = (s, ss);
        }
        walk
    }
}

/// One simulated lag, with its output and two sums.
#[derive(Clone, Copy)]
struct Filter {
    y: Lane,
    /// Sum of `x(k) y(k-1)`.
    p: Lane,
    /// Sum of `v(k) y(k-3)`.
    c: Lane,
}

/// One or two simulated lags.
#[derive(Clone, Copy)]
struct Run {
    filters: [Filter; 2],
    /// Outputs of both before, at and after the first sample that the last tap scores. The other taps start as many
    /// samples later.
    heads: [[Lane; 2]; TAPS],
    /// Outputs at the end of the record.
    tails: [[Lane; 2]; TAPS],
}

impl Run {
    fn new(_: &Stages, start: f64) -> Self {
        let (y, none) = (Lane::splat(start), Lane::splat(0.0));
        let ends = [[none; 2]; TAPS];
        Self { filters: [Filter { y, p: none, c: none }; 2], heads: ends, tails: ends }
    }

    fn outputs(&self) -> [Lane; 2] {
        self.filters.map(|filter| filter.y)
    }
}

struct Lag<'a, const SECOND: bool> {
    run: Run,
    stages: &'a Stages,
    path: &'a [Lane],
    v: &'a [f64],
    counted: bool,
}

impl<const SECOND: bool> Kernel for Lag<'_, SECOND> {
    type Output = Run;
    #[inline(always)]
    fn run(self) -> Run {
        let [mut one, mut two] = self.run.filters;
        let a = self.stages.first;
        let b = Lane::from_fn(|l| 1.0 - a[l]);
        let a2 = self.stages.second.unwrap_or(Lane::splat(0.0));
        let b2 = Lane::from_fn(|l| 1.0 - a2[l]);
        let next =
            |x: &Lane, y: &Lane, a: &Lane, b: &Lane| Lane::from_fn(|l| a[l] * y[l] + b[l] * x[l]);
        if !self.counted {
            for x in self.path {
                one.y = next(x, &one.y, &a, &b);
                if SECOND {
                    two.y = next(&one.y, &two.y, &a2, &b2);
                }
            }
            return Run { filters: [one, two], ..self.run };
        }
        for (x, v) in self.path.iter().zip(self.v) {
            one.p.add_product(x, &one.y);
            one.y = next(x, &one.y, &a, &b);
            one.c.add_scaled(&one.y, *v);
            if SECOND {
                two.p.add_product(&one.y, &two.y);
                two.y = next(&one.y, &two.y, &a2, &b2);
                two.c.add_scaled(&two.y, *v);
            }
        }
        Run { filters: [one, two], ..self.run }
    }
}

/// The sums around means that give gain and delay: of `y(k-j)^2`, of `y(k-j) y(k-j-1)` and of `v(k) y(k-j)`.
#[derive(Clone, Copy)]
struct Sums {
    squares: [Lane; TAPS],
    products: [Lane; DELAYS],
    c: [Lane; TAPS],
}

impl Default for Sums {
    fn default() -> Self {
        let none = Lane::splat(0.0);
        Self { squares: [none; TAPS], products: [none; DELAYS], c: [none; TAPS] }
    }
}

impl Sums {
    /// Adds the sums of one piece of `count` samples, around its mean.
    fn add(&mut self, path: &PathSums, run: &Run, stages: &Stages, count: f64) {
        let lags = [Some(stages.first), stages.second];
        for l in 0..LANES {
            let (mut sum, mut s0, mut s1) = (path.x[l], path.xx[l], 0.0);
            let mut c: [f64; TAPS] = std::array::from_fn(|j| path.vx[j][l]);
            let mut output = 0;
            for (stage, (a, filter)) in lags.iter().zip(&run.filters).enumerate() {
                let Some(a) = a.map(|a| a[l]) else { continue };
                let (b, p) = (1.0 - a, filter.p[l]);
                let (first, last) = (run.heads[0][stage][l], run.tails[0][stage][l]);
                let ends = first * first - last * last;
                s0 = (b * b * s0 + 2.0 * a * b * p + a * a * ends) / (1.0 - a * a);
                s1 = a * (s0 + ends) + b * p;
                sum += a / b * (first - last);
                let behind = filter.c[l];
                c[TAPS - 1] = behind;
                for j in (0..TAPS - 1).rev() {
                    c[j] = a * c[j + 1] + b * c[j];
                }
                output = stage;
            }
            // Taps before the last see the output some samples later, which differs for slow swings.
            let at = |ends: &[[Lane; 2]; TAPS], i: usize| ends[i][output][l];
            let mut sums = [sum; TAPS];
            let (mut squares, mut products) = ([s0; TAPS], [s1; TAPS]);
            for j in (0..DELAYS).rev() {
                let i = DELAYS - j;
                let (from, to) = (at(&run.heads, i), at(&run.tails, i));
                let (before, last) = (at(&run.heads, i - 1), at(&run.tails, i - 1));
                sums[j] = sums[j + 1] + to - from;
                squares[j] = squares[j + 1] + to * to - from * from;
                products[j] = products[j + 1] + to * last - from * before;
            }
            for j in 0..TAPS {
                self.squares[j][l] += squares[j] - sums[j] * sums[j] / count;
                self.c[j][l] += c[j];
            }
            for j in 0..DELAYS {
                self.products[j][l] += products[j] - sums[j] * sums[j + 1] / count;
            }
        }
    }
}

struct Residuals<'a, L> {
    walk: Walk<L>,
    stages: Stages,
    taps: [Lane; TAPS],
    u: &'a [f64],
    v: &'a [f64],
    start: f64,
    left: &'a mut [Lane],
}

impl<L: LaneValve> Kernel for Residuals<'_, L> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut walk = self.walk;
        let (a, a2) = (self.stages.first, self.stages.second.unwrap_or(Lane::splat(0.0)));
        let mut one = Lane::splat(self.start);
        let mut y = [one; TAPS];
        for ((u, v), left) in self.u.iter().zip(self.v).zip(self.left) {
            let x = walk.step(*u);
            one = Lane::from_fn(|l| x[l] + a[l] * (one[l] - x[l]));
            let two = Lane::from_fn(|l| one[l] + a2[l] * (y[0][l] - one[l]));
            y = [two, y[0], y[1], y[2]];
            *left = Lane::from_fn(|l| {
                let mut sum = *v;
                for j in 0..TAPS {
                    sum -= self.taps[j][l] * y[j][l];
                }
                sum
            });
        }
    }
}

/// Adds the losses of residuals: squares up to `huber`, linear beyond.
struct Loss<'a> {
    left: &'a [Lane],
    huber: f64,
    sum: Lane,
}

impl Kernel for Loss<'_> {
    type Output = Lane;
    #[inline(always)]
    fn run(self) -> Lane {
        let mut sum = self.sum;
        for left in self.left {
            for l in 0..LANES {
                let size = left[l].abs();
                let inside = if size < self.huber { size } else { self.huber };
                sum[l] += inside * (2.0 * size - inside);
            }
        }
        sum
    }
}

impl Candidate {
    fn bands(&self) -> Bands {
        Bands::from_fs_fd(self.fs, self.fd).unwrap_or(Bands::NONE)
    }
}
