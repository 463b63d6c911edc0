//! The search for the valve and the lag that lead from OP to the recorded position.

use super::candidate::{Candidate, Fitted, Friction, Place};
use super::evaluate::{Piece, Target};
use crate::series::{max, median, median_absolute_deviation, min, quantile, span, std};

/// First lags to try, samples.
const LAGS: [f64; 11] = [0.0, 0.25, 0.5, 0.9, 1.5, 2.3, 3.5, 5.2, 8.0, 12.0, 18.0];
/// First fd over fs to try.
const RATIOS: [f64; 6] = [0.0, 0.25, 0.5, 0.75, 0.9, 1.0];
/// Second lags over first ones.
const SECOND: [f64; 4] = [0.0, 0.3, 0.6, 1.0];
/// First fs to try: from, up to, %, and the step in its logarithm.
const FS: (f64, f64, f64) = (0.03, 20.0, 0.25);
/// Shares of samples beyond the largest distance of OP and position, of which half is tried as fs, and what is added to the distance
/// of a moving stem to be tried as fd, in fs.
const BEYOND: [f64; 4] = [0.0, 0.001, 0.005, 0.02];
const MORE: [f64; 9] = [0.0, -0.01, -0.03, -0.1, 0.1, -0.2, 0.2, -0.4, 0.4];
/// Small bands that count as healthy, tried at the best lags, %.
const SMALL: [f64; 4] = [0.03, 0.06, 0.1, 0.14];
/// Limits of the gain: with a smaller one, a valve that follows would look like a play.
const GAIN: (f64, f64) = (0.85, 1.18);
/// Standard deviations of the residual up to which a loss is quadratic.
const HUBER: f64 = 2.5;
/// Largest number of basins to refine in each round, with the half widths of the search in ln fs, fd over fs and ln T,
/// and the number of fs in the search.
const ROUNDS: [(usize, f64, f64, f64, usize); 3] =
    [(12, 0.2, 0.15, 0.3, 7), (4, 0.07, 0.07, 0.12, 7), (2, 0.025, 0.03, 0.05, 5)];
/// Distance of the bands of two basins in a family, in ln fs: the grid is too coarse to rank them.
const APART: f64 = 0.2;
/// Number of samples that are simulated and not scored, and their largest share of a piece.
const BURN: (usize, usize) = (60, 8);
/// Number of samples above which a recording is cut into [`PIECES`] pieces, evenly spread, of this many samples
/// together.
pub(super) const MOST_SAMPLES: usize = 16_000;
/// Number of pieces.
const PIECES: usize = 8;

/// All candidates tried on equal terms.
pub(super) struct Search {
    pub all: Vec<Fitted>,
    pub best: usize,
    /// Standard deviation of VP less the best fit, robust, %.
    pub left: f64,
    /// Share of the variance of VP that the best candidate explains.
    pub explained: f64,
    /// Gain of the best linear fit with any gain from 0.
    pub free_gain: f64,
}

/// Searches; OP and VP in percent, of one length, finite, and moving.
pub(super) fn search(op: &[f64], vp: &[f64]) -> Search {
    let n = op.len();
    let (count, length) = if n > MOST_SAMPLES { (PIECES, MOST_SAMPLES / PIECES) } else { (1, n) };
    let parts: Vec<std::ops::Range<usize>> = (0..count)
        .map(|i| {
            let from = (n - length) * i / (count - 1).max(1);
            from..from + length
        })
        .collect();
    let (u, v) = (less_mean(op), less_mean(vp));
    let pieces = |gain: f64, level: Level| -> Vec<Piece<'_>> {
        let piece = |part: &std::ops::Range<usize>| {
            let (u, v) = (&u[part.clone()], &v[part.clone()]);
            let offset = match level {
                Level::Means => mean(v) - gain * mean(u),
                Level::Middles => middle(v) - gain * middle(u),
                Level::Zeros => mean(op) - mean(vp),
            };
            let burn = BURN.0.min(u.len() / BURN.1);
            Piece { u, v, start: (v[0] - offset) / gain, burn }
        };
        parts.iter().map(piece).collect()
    };
    let follows = [Candidate::ideal(Place::After, 0.0)];
    let unscaled = pieces(1.0, Level::Means);
    let free =
        Target::new(&unscaled, 0.0, f64::INFINITY, (0.0, f64::INFINITY)).fit(&follows, &LAGS);
    let gain = Target::new(&unscaled, 0.0, f64::INFINITY, GAIN).fit(&follows, &LAGS)[0].gain();

    // The bands to try.
    let most = span(op).min(FS.1).max(1.0);
    let steps = ((most / FS.0).ln() / FS.2).ceil() as usize;
    let fs: Vec<f64> = (0..steps).map(|i| FS.0 * (FS.2 * i as f64).exp()).collect();
    let look =
        |gain, level| first_look(pieces(gain, level), gain, &fs, seen(&u, &v, gain, &MORE[..2]));
    let looked = look(gain, Level::Means).better(look(gain, Level::Middles));
    // A valve that rests for long has another gain than one that follows.
    let Look { pieces, gain, rho, huber, .. } = looked.better(look(1.0, Level::Zeros));
    let target = Target::new(&pieces, rho, if huber > 0.0 { huber } else { f64::INFINITY }, GAIN);

    let mut all = target.fit(&healthy(&SECOND), &LAGS);
    all.extend(target.fit(&grid(&fs, &RATIOS, &FAMILIES), &LAGS));
    all.extend(target.fit(&seen(&u, &v, gain, &MORE), &LAGS));
    refine(&target, &mut all);
    add_healthy(&target, &mut all);
    let best = best(&all);
    let left: Vec<f64> = residual(&target, &all[best]).concat();
    let scored: Vec<f64> = pieces.iter().flat_map(|p| less_mean(&p.v[p.burn..])).collect();
    let share = std(&left) / std(&scored).max(f64::MIN_POSITIVE);
    Search {
        best,
        left: median_absolute_deviation(&left),
        explained: 1.0 - share * share,
        free_gain: free[0].gain(),
        all,
    }
}

/// How the levels of OP and VP, hence the position of the stem at the first sample, are related. A stem that rests for
/// long has a different mean from the OP. A stem that begins wrongly may miss the first reversals, or all.
#[derive(Clone, Copy)]
enum Level {
    /// Their means agree.
    Means,
    /// The middles of their ranges agree.
    Middles,
    /// Both have the same zero and span.
    Zeros,
}

/// A first look at the residual.
struct Look<'a> {
    pieces: Vec<Piece<'a>>,
    /// Percent of VP per percent of OP, for the first position.
    gain: f64,
    /// Sum of squares of the best of a few candidates.
    loss: f64,
    /// Correlation from sample to sample.
    rho: f64,
    /// The size from which its weight decreases.
    huber: f64,
}

impl Look<'_> {
    fn better(self, other: Self) -> Self {
        if other.loss < self.loss { other } else { self }
    }
}

/// `seen` are candidates by the distance of OP and position.
fn first_look<'a>(pieces: Vec<Piece<'a>>, gain: f64, fs: &[f64], seen: Vec<Candidate>) -> Look<'a> {
    let every_second = |x: &[f64]| -> Vec<f64> { x.iter().copied().step_by(2).collect() };
    let mut few = healthy(&SECOND);
    few.extend(seen);
    few.extend(grid(&every_second(fs), &[0.0, 0.5, 1.0], &FAMILIES));
    let plain = Target::new(&pieces, 0.0, f64::INFINITY, GAIN);
    let first = plain.fit(&few, &every_second(&LAGS));
    let first = &first[best(&first)];
    let left = residual(&plain, first);
    let (mut squares, mut products) = (0.0, 0.0);
    for left in &left {
        squares += left.iter().map(|x| x * x).sum::<f64>();
        products += left.windows(2).map(|x| x[0] * x[1]).sum::<f64>();
    }
    let rho = if squares > 0.0 { (products / squares).clamp(0.0, 0.95) } else { 0.0 };
    let white: Vec<f64> =
        left.iter().flat_map(|left| left.windows(2).map(|x| x[1] - rho * x[0])).collect();
    // `median_absolute_deviation` is scaled to the standard deviation of a normal distribution.
    let huber = HUBER * median_absolute_deviation(&white).max(0.3 * std(&white));
    let loss = first.loss;
    Look { pieces, gain, loss, rho, huber }
}

/// Candidates by the distance of OP and position, as if nothing lagged: at most fs at rest, and fd in motion. In a loop
/// the OP reverses as soon as the stem slips. Bands slightly larger than the true bands therefore miss all slips, and a
/// grid misses the true bands.
fn seen(u: &[f64], v: &[f64], gain: f64, more: &[f64]) -> Vec<Candidate> {
    let distance: Vec<f64> = u.iter().zip(v).map(|(u, v)| u - v / gain).collect();
    let ends = |share| (quantile(&distance, share), quantile(&distance, 1.0 - share));
    let (low, high) = ends(BEYOND[1]);
    let steps: Vec<f64> = v.windows(2).map(|v| (v[1] - v[0]).abs()).collect();
    let few = (10.0 / steps.len() as f64).min(0.01);
    let least = (0.5 * quantile(&steps, 1.0 - few)).max(f64::MIN_POSITIVE);
    let moving = steps.iter().zip(&distance[1..]).filter(|(step, _)| **step >= least);
    let moving: Vec<f64> = moving.map(|(_, d)| (d - 0.5 * (low + high)).abs()).collect();
    if moving.is_empty() {
        return vec![];
    }
    let fd = median(&moving);
    let halves = BEYOND.map(ends).map(|(low, high)| 0.5 * (high - low));
    let of = |fs: f64| {
        let ratios: Vec<f64> = more.iter().map(|more| (fd / fs + more).clamp(0.0, 1.0)).collect();
        grid(&[fs], &ratios, &FAMILIES)
    };
    halves.into_iter().filter(|fs| *fs >= FS.0).flat_map(of).collect()
}

/// A second, finer look around the best candidates.
fn refine(target: &Target<'_>, all: &mut Vec<Fitted>) {
    for (round, (basins, width_fs, width_ratio, width_lag, count)) in ROUNDS.into_iter().enumerate()
    {
        // Each basin around its own lag: at a wrong lag the right band is no better than a wrong one.
        for leader in leading(all, basins) {
            let (mut of, mut lag) = (all[leader].candidate, all[leader].lag);
            if round == 1 {
                let tried = target.fit(&SECOND.map(|second| Candidate { second, ..of }), &LAGS);
                let found = &tried[best(&tried)];
                if found.loss < all[leader].loss {
                    (of, lag) = (found.candidate, found.lag);
                }
                all.extend(tried);
            }
            let mut lags: Vec<f64> = match lag > 0.0 {
                true => spread(7).map(|x| lag * (width_lag * x).exp()).collect(),
                false => vec![0.1, 0.2, 0.3],
            };
            lags.extend(if round == 0 { &LAGS[..] } else { &LAGS[..1] });
            let mut ratios: Vec<f64> =
                spread(5).map(|x| (of.fd / of.fs + width_ratio * x).clamp(0.0, 1.0)).collect();
            ratios.dedup();
            let fs: Vec<f64> = spread(count).map(|x| of.fs * (width_fs * x).exp()).collect();
            let near = grid(&fs, &ratios, &[(of.place, of.friction)]);
            let second = of.second;
            let near: Vec<Candidate> =
                near.into_iter().map(|near| Candidate { second, ..near }).collect();
            all.extend(target.fit(&near, &lags));
        }
    }
}

/// Healthy valves with lags as fine, and small bands, so that they are not at a disadvantage.
fn add_healthy(target: &Target<'_>, all: &mut Vec<Fitted>) {
    let second = all[best(all)].candidate.second;
    let found = all[best(all)].lag;
    for behind in SECOND {
        let own = all.iter().filter(|f| f.candidate.is_ideal() && f.candidate.second == behind);
        let own = own.min_by(|a, b| a.loss.total_cmp(&b.loss)).map_or(found, |f| f.lag);
        let mut lags = LAGS.to_vec();
        lags.extend(spread(7).map(|x| own * (0.3 * x).exp()).filter(|lag| *lag > 0.0));
        lags.extend(spread(5).map(|x| found * (0.1 * x).exp()).filter(|lag| *lag > 0.0));
        let mut tried = healthy(&[behind]);
        if behind == 0.0 || behind == second {
            let small = grid(&SMALL, &[0.0, 0.5, 1.0], &FAMILIES);
            tried.extend(small.into_iter().map(|small| Candidate { second: behind, ..small }));
        }
        all.extend(target.fit(&tried, &lags));
    }
}

/// Every position of the lag with every friction.
const FAMILIES: [(Place, Friction); 4] = [
    (Place::After, Friction::TwoPhase),
    (Place::After, Friction::He),
    (Place::Before, Friction::TwoPhase),
    (Place::Before, Friction::HeBetween),
];

fn healthy(second: &[f64]) -> Vec<Candidate> {
    let of = |place| second.iter().map(move |second| Candidate::ideal(place, *second));
    [Place::After, Place::Before].into_iter().flat_map(of).collect()
}

fn grid(fs: &[f64], ratios: &[f64], families: &[(Place, Friction)]) -> Vec<Candidate> {
    let mut all = vec![];
    for &(place, friction) in families {
        for &fs in fs {
            // A play is the same for both kinds of slip.
            let plays = |ratio: &&f64| friction == Friction::TwoPhase || **ratio < 1.0;
            let of = |ratio: &f64| Candidate { place, friction, fs, fd: fs * ratio, second: 0.0 };
            all.extend(ratios.iter().filter(plays).map(of));
        }
    }
    all
}

/// The candidate with the smallest loss; the first of equals.
fn best(all: &[Fitted]) -> usize {
    let losses = all.iter().enumerate().map(|(i, fitted)| (i, fitted.loss));
    losses.reduce(|a, b| if b.1 < a.1 { b } else { a }).map_or(0, |(i, _)| i)
}

/// The best of each basin with a band, the best basins first.
fn leading(all: &[Fitted], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..all.len()).filter(|i| !all[*i].candidate.is_ideal()).collect();
    order.sort_by(|a, b| all[*a].loss.total_cmp(&all[*b].loss));
    let mut leading: Vec<usize> = vec![];
    let family = |i: usize| (all[i].candidate.place, all[i].candidate.friction);
    for i in order {
        let apart = |known: usize| {
            family(known) != family(i)
                || (all[known].candidate.fs / all[i].candidate.fs).ln().abs() > APART
        };
        if leading.iter().all(|known| apart(*known)) {
            leading.push(i);
        }
        if leading.len() == most {
            break;
        }
    }
    leading
}

/// The residual of VP in each piece, less its median.
fn residual(target: &Target<'_>, fitted: &Fitted) -> Vec<Vec<f64>> {
    let less_median = |left: Vec<f64>| {
        let middle = median(&left);
        left.iter().map(|x| x - middle).collect()
    };
    target.residual(fitted).into_iter().map(less_median).collect()
}

/// `count` numbers from -1 to 1.
fn spread(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| 2.0 * i as f64 / (count - 1) as f64 - 1.0)
}

fn middle(x: &[f64]) -> f64 {
    0.5 * (min(x) + max(x))
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn less_mean(x: &[f64]) -> Vec<f64> {
    let mean = mean(x);
    x.iter().map(|x| x - mean).collect()
}
