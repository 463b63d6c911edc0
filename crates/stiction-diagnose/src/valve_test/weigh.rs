//! How much the turns of a test speak for each valve.
//!
//! For each S of a grid the likelihood is the mean over J, the process and the place of the stem at first, at the best
//! gain. Before the test half of the valves follow, and of the others ln S is uniform.

use super::answer::{Answers, Process, Spell, answers};
use super::behind::apart;
use super::explain::{Problem, Seen};
use super::stems::{SHARES, Stem};

/// A time in manual.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Manual {
    /// The PV in it, sample by sample.
    pub pv: Vec<f64>,
    /// The OP before it, percent.
    pub before: f64,
    /// At which sample of the spell the OP was set, and to what, percent.
    pub turns: Vec<(usize, f64)>,
}

/// The largest S of a valve that follows, percent: what lies below is no fault, and hardly any test resolves it.
pub(super) const SMALL: f64 = 0.42;
/// Probabilities before the test: of valves that follow, that stick, and of nothing that answers.
const FOLLOWS: f64 = 0.47;
const STICKS: f64 = 0.48;
const SILENT: f64 = 0.05;
/// The probability of a dead band behind the process, over that of a valve that sticks.
const ELSEWHERE: f64 = 0.042;
/// Nats by which a sum of squares speaks for a dead band in the valve or behind the process: half of what independent
/// errors would give, for no process is quite what is fitted; and the most.
const NATS: f64 = 0.25;
const MOST_NATS: f64 = 30.0;
/// Samples that are looked at, at most; more are averaged.
const MOST_SAMPLES: usize = 1500;
/// Samples and turns that a time in manual has at least.
const FEWEST: (usize, usize) = (12, 2);
/// Processes that all valves are tried with, and by how many nats they may be less likely than the best.
const PROCESSES: usize = 4;
const NEAR: f64 = 12.0;
/// Valves and processes by which a dead band behind the process is told from one in the valve.
const STEMS: usize = 12;
const BEHIND: usize = 4;
/// The largest S that is tried is no smaller than this, percent: a turn that is shorter says nothing of it.
const MOST: f64 = 30.0;
/// The quantile of S that is told as its limit, and a factor for what lies between two S of the grid.
const LIMIT: (f64, f64) = (0.975, 1.1);

/// An S that was tried.
#[derive(Debug, Clone, PartialEq)]
struct Tried {
    s: f64,
    /// Logarithms of the likelihood by J over S; one, of a valve that follows.
    logs: Vec<f64>,
    /// The same over all J, with what is held likely before the test.
    weight: f64,
}

impl Tried {
    fn sticks(&self) -> bool {
        self.s > SMALL
    }

    /// Its valves, with the logarithms of their likelihood.
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

/// What a test says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Weighed {
    /// Probabilities: of a valve with S above [`SMALL`], of nothing that answers, of a dead band behind the process.
    pub sticks: f64,
    pub silent: f64,
    pub elsewhere: f64,
    /// S of a valve is below this with 95 % probability if ln S is anything at first.
    pub s_below: f64,
    /// How well the PV goes with the likeliest valve that sticks, and with one that follows.
    pub sticking_seen: Seen,
    pub following_seen: Seen,
    /// The PV changes by no more than this with a percent of the OP while a turn is held, its units.
    pub per_percent: f64,
    /// Valves by S, from 0 upwards.
    pub bands: Vec<Band>,
    /// Logarithm of the likelihood of the likeliest, but for a constant that the sign of the gain does not change.
    pub log: f64,
    /// How far the PV went with each turn: spell, turn, PV units at the end of its hold, standard deviation.
    pub turns: Vec<(usize, usize, f64, f64)>,
    /// Of the gain.
    pub sign: f64,
    /// The likeliest process, and how many samples one of its samples is.
    pub response: (Process, usize),
}

/// The times in manual that can be looked at: their numbers, their turns, and their samples.
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

    /// The longest time that a turn is held, samples.
    fn held(&self) -> usize {
        let turns = self.spells.iter().flat_map(|spell| spell.turns.windows(2));
        turns.map(|two| two[1] - two[0]).max().unwrap_or(1)
    }

    /// Whether the answers of a process go with the turns, not against them: a dead time of a turn and more would exchange
    /// those of turns up and down.
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

/// A spell with every `factor` samples averaged, and its turns that have at least one such sample to answer in.
fn averaged(spell: &Manual, factor: usize) -> (Manual, Spell) {
    let pv: Vec<f64> =
        spell.pv.chunks_exact(factor).map(|b| b.iter().sum::<f64>() / factor as f64).collect();
    let at = |turn: &(usize, f64)| turn.0.div_ceil(factor);
    let turns: Vec<(usize, f64)> =
        spell.turns.iter().copied().take_while(|turn| at(turn) < pv.len()).collect();
    let looked = Spell { pv, turns: turns.iter().map(at).collect() };
    (Manual { pv: vec![], before: spell.before, turns }, looked)
}

/// Weighs all valves; the gain has this sign, the dead time is no longer than so many samples, and errors have a standard
/// deviation of `floor` at least. A dead band may lie `elsewhere` than in the valve. `None` if there is not enough to look at.
pub(super) fn weigh(
    spells: &[Manual],
    sign: f64,
    longest_dead: usize,
    floor: f64,
    elsewhere: bool,
) -> Option<Weighed> {
    let looked = Looked::of(spells);
    if looked.spells.is_empty() {
        return None;
    }
    let longest_dead = longest_dead.div_ceil(looked.factor);
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
    let problem =
        |(of, log): &(&Answers, f64)| Problem::of(of, &looked.manual, sign, variance, *log);
    let problems: Vec<Problem<'_>> = near.iter().filter_map(problem).collect();
    let tried = tried(&problems, &looked);
    let silent = mean_over(&problems, |of| of.silence()) + SILENT.ln();

    let mut stems: Vec<(f64, Stem)> =
        tried.iter().filter(|one| one.sticks()).flat_map(Tried::stems).collect();
    stems.sort_by(|a, b| b.0.total_cmp(&a.0));
    let stems: Vec<Stem> = stems.into_iter().take(STEMS).map(|(_, stem)| stem).collect();
    let processes: Vec<Process> = near.iter().take(BEHIND).map(|(of, _)| of.process).collect();
    let (manual, seen) = (&looked.manual, &looked.spells);
    let noise = &near.first()?.0.noise;
    let further = elsewhere
        .then(|| apart(manual, seen, noise, &processes, longest_dead, looked.travel(), &stems))
        .flatten();
    // Where nothing tells them apart, a dead band behind the process is as likely as it is before the test.
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
        s_below: LIMIT.1 * quantile(&flat, LIMIT.0),
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

/// All S that are tried, from 0 upwards.
fn tried(problems: &[Problem<'_>], looked: &Looked) -> Vec<Tried> {
    let bands = Stem::bands((2.0 * looked.travel()).max(MOST));
    let many = bands.iter().filter(|s| **s > SMALL).count().max(1) as f64;
    let few = 1.0 + bands.len() as f64 - many;
    let with = |s: f64, logs: Vec<f64>| {
        let before = if s > SMALL { STICKS / many } else { FOLLOWS / few };
        Tried { s, weight: log_mean(&logs) + before.ln(), logs }
    };
    let follows = with(0.0, vec![mean_over(problems, |of| of.likelihood(None).0)]);
    let of = |s: &f64| {
        let stem = |share: f64| Stem { s: *s, j: share * s };
        let log = |share| mean_over(problems, |of| of.likelihood(Some(stem(share))).0);
        with(*s, SHARES.into_iter().map(log).collect())
    };
    std::iter::once(follows).chain(bands.iter().map(of)).collect()
}

/// Logarithm of the mean likelihood over the processes.
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

/// Logarithm of the mean of what these are the logarithms of.
pub(super) fn log_mean(logs: &[f64]) -> f64 {
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return most;
    }
    most + (logs.iter().map(|log| (log - most).exp()).sum::<f64>() / logs.len() as f64).ln()
}

impl Weighed {
    /// The S below which this share of the valves that stick lies.
    pub fn s_quantile(&self, share: f64) -> f64 {
        let of = self.bands.iter().filter(|band| band.s > SMALL);
        quantile(&of.map(|band| (band.s, band.weight)).collect::<Vec<_>>(), share)
    }

    /// The J over S below which this share of those that stick lies.
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

/// Quantile of weighted values that ascend; each stands for the span to half way to its neighbours.
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
