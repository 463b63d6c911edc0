//! The evidence of a test for each valve.
//!
//! For each S of a grid, the likelihood is the mean over J, the process and the start position of the stem, at the best
//! gain. The prior has half of the valves without stiction, and a uniform ln S for the other half.

use super::answer::{Answers, Process, Spell, answers};
use super::behind::apart;
use super::curve::Curve;
use super::explain::{Problem, Seen, UNEVEN, UNEVEN_POSITION};
use super::stems::{SHARES, Stem};
use crate::series::span;

/// A time in manual.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Manual {
    /// PV, sample by sample.
    pub pv: Vec<f64>,
    /// The OP before the turn, percent.
    pub before: f64,
    /// The sample of each OP setting, and the OP, percent.
    pub turns: Vec<(usize, f64)>,
}

/// The largest S of a valve that does not stick, percent. A smaller S is no fault, and hardly any test resolves it.
pub(super) const SMALL: f64 = 0.42;
/// Prior probabilities of a valve that follows, a valve that sticks, and a valve without a response.
const FOLLOWS: f64 = 0.47;
const STICKS: f64 = 0.48;
const SILENT: f64 = 0.05;
/// Prior probability of a dead band downstream of the process, relative to a sticking valve.
const ELSEWHERE: f64 = 0.042;
/// Evidence in nats from a difference of the sums of squares, for a dead band in the valve or downstream of the
/// process. It is half of the evidence from independent errors, because no process is exactly linear. The second value
/// is its limit.
const NATS: f64 = 0.25;
const MOST_NATS: f64 = 30.0;
/// Less evidence, nats, and shorter lags, samples, distinguish nothing.
const ALIKE: f64 = 1.0;
const FAST: f64 = 2.5;
/// Largest number of samples that are used. More are averaged.
const MOST_SAMPLES: usize = 1500;
/// Fewest samples and turns of a time in manual.
const FEWEST: (usize, usize) = (12, 2);
/// Number of processes that are tried with all valves, and how much less likely than the best they may be, nats.
const PROCESSES: usize = 4;
const NEAR: f64 = 12.0;
/// Number of valves and processes to distinguish a dead band downstream of the process from one in the valve.
const STEMS: usize = 12;
const BEHIND: usize = 4;
/// Lower bound of the largest S tried, percent, and this bound as a share of the range of the OP. Beyond it, different
/// S have the same effect.
const MOST: f64 = 30.0;
const BEYOND: f64 = 1.5;
/// The quantile of S that is reported as its limit, and a factor for the distance of the S in the grid.
const LIMIT: (f64, f64) = (0.975, 1.1);
/// A stem that slid before the test and did not return is excluded if it is less likely than the likeliest stem by
/// this, nats. A limit of S requires that, and that a stem that never moved is excluded.
const LESS: f64 = 3.0;

/// An S of the grid.
#[derive(Debug, Clone, PartialEq)]
struct Tried {
    s: f64,
    /// Log-likelihood by J over S; a single value for a valve that follows.
    logs: Vec<f64>,
    /// Log-likelihood over all J, including the prior.
    weight: f64,
}

impl Tried {
    fn sticks(&self) -> bool {
        self.s > SMALL
    }

    /// Valves, with their log-likelihood.
    fn stems(&self) -> impl Iterator<Item = (f64, Stem)> {
        let s = self.s;
        self.logs.iter().zip(SHARES).map(move |(log, share)| (*log, Stem { s, j: share * s }))
    }
}

/// One S with its share of the probability.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Band {
    pub s: f64,
    pub weight: f64,
    /// Weights of J over S.
    pub shares: Vec<f64>,
}

/// The evidence of a test.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Weighed {
    /// Probabilities of a valve with S above [`SMALL`], of no answer, and of a dead band downstream of the process.
    pub sticks: f64,
    pub silent: f64,
    pub elsewhere: f64,
    /// Whether the answers do not distinguish such a dead band from one in the valve.
    pub alike: bool,
    /// S is below this with 95 % confidence, with a flat prior for ln S; `None` if the test excludes no large S.
    pub s_below: Option<f64>,
    /// Whether S may be larger than any S tried.
    pub open: bool,
    /// How well the PV agrees with the likeliest sticking valve, and with a valve that follows.
    pub sticking_seen: Seen,
    pub following_seen: Seen,
    /// Upper limit of the PV change per percent of OP during a hold, PV units.
    pub per_percent: f64,
    /// Valves by S, from 0 upwards.
    pub bands: Vec<Band>,
    /// Log-likelihood of the likeliest valve, up to a constant that does not depend on the sign of the gain.
    pub log: f64,
    /// The PV change of each turn: spell, turn, PV units at the end of its hold or of a longer response, standard deviation.
    pub turns: Vec<(usize, usize, f64, f64)>,
    /// Sign of the gain.
    pub sign: f64,
    /// The likeliest process, and the number of recorded samples in one of its samples.
    pub response: (Process, usize),
}

/// The usable times in manual: their numbers, turns and samples.
struct Looked {
    indices: Vec<usize>,
    manual: Vec<Manual>,
    spells: Vec<Spell>,
    factor: usize,
}

impl Looked {
    fn of(spells: &[Manual]) -> Self {
        let samples: usize = spells.iter().map(|spell| spell.pv.len()).sum();
        let factor = samples.div_ceil(MOST_SAMPLES).max(1);
        let mut looked = Self { indices: vec![], manual: vec![], spells: vec![], factor };
        for (k, spell) in spells.iter().enumerate() {
            let (manual, spell) = averaged(spell, factor);
            if spell.pv.len() >= FEWEST.0 && spell.turns.len() >= FEWEST.1 {
                looked.indices.push(k);
                looked.manual.push(manual);
                looked.spells.push(spell);
            }
        }
        looked
    }

    /// The longest turn, percent.
    fn travel(&self) -> f64 {
        let turns = self.manual.iter().flat_map(|spell| spell.turns.windows(2));
        turns.map(|two| (two[1].1 - two[0].1).abs()).fold(0.0, f64::max)
    }

    /// The range of the OP, percent.
    fn reach(&self) -> f64 {
        let turns = self.manual.iter().flat_map(|spell| &spell.turns);
        span(&turns.map(|(_, op)| *op).collect::<Vec<_>>())
    }

    /// The longest hold, samples.
    fn held(&self) -> usize {
        let turns = self.spells.iter().flat_map(|spell| spell.turns.windows(2));
        turns.map(|two| two[1] - two[0]).max().unwrap_or(1)
    }

    /// Whether the answers of a process have the sign of the turns. A dead time of a turn or more would exchange the
    /// answers of turns up and down.
    fn goes(&self, of: &Answers, sign: f64) -> bool {
        let mut sum = 0.0;
        for (spell, (found, information)) in self.manual.iter().zip(&of.spells) {
            for (i, two) in spell.turns.windows(2).enumerate() {
                sum += (two[1].1 - two[0].1) * found[i + 1] * information[(i + 1, i + 1)];
            }
        }
        sign * sum >= 0.0
    }
}

/// A spell with every `factor` samples averaged, and its turns with at least one averaged sample.
fn averaged(spell: &Manual, factor: usize) -> (Manual, Spell) {
    let pv: Vec<f64> =
        spell.pv.chunks_exact(factor).map(|b| b.iter().sum::<f64>() / factor as f64).collect();
    let at = |turn: &(usize, f64)| turn.0.div_ceil(factor);
    let turns: Vec<(usize, f64)> =
        spell.turns.iter().copied().take_while(|turn| at(turn) < pv.len()).collect();
    let looked = Spell { pv, turns: turns.iter().map(at).collect() };
    (Manual { pv: vec![], before: spell.before, turns }, looked)
}

/// Weighs all valves, with the sign of the gain, the longest dead time in samples and `floor` as the smallest standard
/// deviation of the errors. `elsewhere` allows a dead band outside the valve. A `curve` adds the evidence of settled
/// values. `None` if the data are too few.
pub(super) fn weigh(
    spells: &[Manual],
    sign: f64,
    longest_dead: usize,
    floor: f64,
    elsewhere: bool,
    curve: Option<&Curve>,
) -> Option<Weighed> {
    let looked = Looked::of(spells);
    if looked.spells.is_empty() {
        return None;
    }
    let longest_dead = longest_dead / looked.factor;
    let (found, error) = answers(&looked.spells, longest_dead)?;
    let variance = (error * error + floor * floor).max(f64::MIN_POSITIVE);
    let right: Vec<&Answers> = found.iter().filter(|of| looked.goes(of, sign)).collect();
    let right = if right.is_empty() { found.iter().collect() } else { right };
    let least = right.first()?.left;
    let near: Vec<(&Answers, f64)> = right
        .into_iter()
        .map(|of| (of, -0.5 * (of.left - least) / variance))
        .take_while(|(_, log)| *log > -NEAR)
        .take(PROCESSES)
        .collect();
    // The position of a stem has a gain of 1 everywhere.
    let uneven = if elsewhere { UNEVEN } else { UNEVEN_POSITION };
    let problem =
        |(of, log): &(&Answers, f64)| Problem::of(of, &looked.manual, sign, variance, *log, uneven);
    let problems: Vec<Problem<'_>> = near.iter().filter_map(problem).collect();
    let settled = |stem| curve.map_or(0.0, |curve| curve.likelihood(&looked.manual, stem));
    let tried = tried(&problems, &looked, &settled);
    // A PV with a characteristic answers.
    let silence = match curve {
        Some(_) => f64::NEG_INFINITY,
        None => mean_over(&problems, |of| of.silence()),
    };
    let silent = silence + SILENT.ln();

    let mut stems: Vec<(f64, Stem)> =
        tried.iter().filter(|one| one.sticks()).flat_map(Tried::stems).collect();
    stems.sort_by(|a, b| b.0.total_cmp(&a.0));
    let likeliest = stems.first()?.0;
    let stems: Vec<Stem> = stems.into_iter().take(STEMS).map(|(_, stem)| stem).collect();
    let processes: Vec<Process> = near.iter().take(BEHIND).map(|(of, _)| of.process).collect();
    let (manual, seen) = (&looked.manual, &looked.spells);
    let noise = &near.first()?.0.noise;
    let further = elsewhere
        .then(|| apart(manual, seen, noise, &processes, longest_dead, looked.travel(), &stems))
        .flatten();
    // If the data do not distinguish them, a dead band downstream of the process keeps its prior probability.
    let against = further.map_or(0.0, |f| (-NATS * f / variance).clamp(-MOST_NATS, MOST_NATS));
    let behind = match elsewhere {
        true => 1.0 / (1.0 + (-(ELSEWHERE.ln() + against)).exp()),
        false => 0.0,
    };

    let most = tried.iter().map(|one| one.weight).fold(silent, f64::max);
    if !most.is_finite() {
        return None;
    }
    let whole: f64 =
        tried.iter().map(|one| (one.weight - most).exp()).sum::<f64>() + (silent - most).exp();
    let bands: Vec<Band> = tried.iter().map(|one| band(one, most, whole)).collect();
    let sticks: f64 = bands.iter().filter(|band| band.s > SMALL).map(|band| band.weight).sum();
    let flat: Vec<(f64, f64)> =
        tried.iter().map(|one| (one.s, (log_mean(&one.logs) - most).exp())).collect();

    let following = log_mean(&tried.first()?.logs);
    let furthest = Stem { s: tried.last()?.s, j: 0.0 };
    let slid = mean_over(&problems, |of| of.slid(furthest)) + settled(Some(furthest));
    let excludes = slid.max(silence) < following - LESS;

    let sticking = stems.first().copied();
    let best = |of: &Problem<'_>| {
        let sticking = sticking.map_or(f64::NEG_INFINITY, |stem| of.likelihood(Some(stem)).0);
        of.likelihood(None).0.max(sticking)
    };
    let first = problems.iter().max_by(|a, b| best(a).total_cmp(&best(b)))?;
    let of_first = near.iter().find(|(of, _)| of.process == first.process)?.0;
    let held = first.process.step(looked.held() + 1).last().copied().unwrap_or(1.0);
    Some(Weighed {
        sticks: (1.0 - behind) * sticks,
        silent: (silent - most).exp() / whole,
        elsewhere: behind * sticks,
        alike: elsewhere
            && (against.abs() < ALIKE || first.process.tau + first.process.tau2 < FAST),
        s_below: excludes.then(|| LIMIT.1 * quantile(&flat, LIMIT.0)),
        open: slid > likeliest - LESS,
        sticking_seen: sticking.map_or(Seen::default(), |stem| first.seen(Some(stem))),
        following_seen: first.seen(None),
        per_percent: first.upper() * held,
        bands,
        log: most - 0.5 * least / variance,
        turns: first.turns(of_first, &looked.spells, &looked.indices),
        sign,
        response: (first.process, looked.factor),
    })
}

/// All S of the grid, in ascending order from 0.
fn tried(
    problems: &[Problem<'_>],
    looked: &Looked,
    settled: &dyn Fn(Option<Stem>) -> f64,
) -> Vec<Tried> {
    let bands = Stem::bands((2.0 * looked.travel()).max(BEYOND * looked.reach()).max(MOST));
    let many = bands.iter().filter(|s| **s > SMALL).count().max(1) as f64;
    let few = 1.0 + bands.len() as f64 - many;
    let with = |s: f64, logs: Vec<f64>| {
        let before = if s > SMALL { STICKS / many } else { FOLLOWS / few };
        Tried { s, weight: log_mean(&logs) + before.ln(), logs }
    };
    let of_valve = |stem| mean_over(problems, |of| of.likelihood(stem).0) + settled(stem);
    let follows = with(0.0, vec![of_valve(None)]);
    let of = |s: &f64| {
        let log = |share: f64| of_valve(Some(Stem { s: *s, j: share * s }));
        with(*s, SHARES.into_iter().map(log).collect())
    };
    std::iter::once(follows).chain(bands.iter().map(of)).collect()
}

/// Logarithm of the mean likelihood of the processes.
fn mean_over(problems: &[Problem<'_>], log: impl Fn(&Problem<'_>) -> f64) -> f64 {
    log_mean(&problems.iter().map(log).collect::<Vec<_>>())
}

fn band(of: &Tried, most: f64, whole: f64) -> Band {
    let weight = (of.weight - most).exp() / whole;
    let top = of.logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let likely: Vec<f64> = of.logs.iter().map(|log| (log - top).exp()).collect();
    let sum: f64 = likely.iter().sum();
    Band { s: of.s, weight, shares: likely.iter().map(|l| weight * l / sum).collect() }
}

/// Logarithm of the mean, from the logarithms of the values.
pub(super) fn log_mean(logs: &[f64]) -> f64 {
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return most;
    }
    most + (logs.iter().map(|log| (log - most).exp()).sum::<f64>() / logs.len() as f64).ln()
}

impl Weighed {
    /// The quantile of S among the valves that stick.
    pub fn s_quantile(&self, share: f64) -> f64 {
        let of = self.bands.iter().filter(|band| band.s > SMALL);
        quantile(&of.map(|band| (band.s, band.weight)).collect::<Vec<_>>(), share)
    }

    /// The quantile of J over S among the valves that stick.
    pub fn share_quantile(&self, share: f64) -> f64 {
        let sums: Vec<(f64, f64)> = SHARES
            .iter()
            .enumerate()
            .map(|(i, j)| {
                let of = self.bands.iter().filter(|band| band.s > SMALL);
                (*j, of.map(|band| band.shares[i]).sum())
            })
            .collect();
        let whole: f64 = sums.iter().map(|(_, w)| w).sum();
        let mut sum = 0.0;
        for (value, weight) in &sums {
            sum += weight;
            if sum >= share * whole {
                return *value;
            }
        }
        1.0
    }
}

/// Quantile of ascending weighted values. Each represents the range to half-way to its neighbours.
fn quantile(of: &[(f64, f64)], share: f64) -> f64 {
    let wanted = share * of.iter().map(|(_, w)| w).sum::<f64>();
    let mut sum = 0.0;
    for (k, (value, weight)) in of.iter().enumerate() {
        if sum + weight >= wanted && *weight > 0.0 {
            let within = ((wanted - sum) / weight).clamp(0.0, 1.0);
            let below = if k > 0 { (of[k - 1].0 * value).sqrt() } else { *value };
            let above = of.get(k + 1).map_or(*value, |(next, _)| (next * value).sqrt());
            return below + within * (above - below);
        }
        sum += weight;
    }
    of.last().map_or(0.0, |(value, _)| *value)
}
