//! How well valves explain what the turns of a test made of the PV.
//!
//! # Equations
//! A valve moves the stem by m_i with turn i, and the PV by K m_i; what was [found](super::answer) of it is
//!
//! ```text
//! a ~ t(K m, s^2 F^-1 + diag (e K m_i)^2),     e = 0.15: no gain is the same everywhere
//! ```

use super::answer::{Answers, Process, Spell};
use super::stems::{PLACES, Stem};
use super::weigh::{Manual, log_mean};
use nalgebra::{Cholesky, DMatrix, DVector};

/// By how much the gain may change from turn to turn, share.
const UNEVEN: f64 = 0.15;
/// Gains that are tried: from the largest that was seen down by this factor each.
const GAINS: usize = 9;
const GAIN_RATIO: f64 = 0.6;
/// Degrees of freedom of the answers.
const FREEDOM: f64 = 6.0;

/// How well the PV goes with a valve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    /// Turns that it follows, and that the PV clearly answers about as far as it should.
    pub clear: usize,
    /// Correlation of the answers with those that it gives, each in its standard deviations.
    pub fits: f64,
    /// Length of the answers that it gives, in standard deviations.
    pub strength: f64,
}

/// What one spell answered, but for its first turn: before it the stem may have been anywhere.
struct Answered {
    /// PV units by turn.
    found: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// The answers behind one process, to be explained by valves.
pub(super) struct Problem<'a> {
    spells: &'a [Manual],
    answered: Vec<Answered>,
    gains: Vec<f64>,
    pub process: Process,
    /// Likelihood of the process itself.
    log: f64,
}

impl<'a> Problem<'a> {
    /// What a process made of the spells; the gain has this sign, and the process this logarithm of its likelihood.
    pub fn of(
        of: &Answers,
        spells: &'a [Manual],
        sign: f64,
        variance: f64,
        log: f64,
    ) -> Option<Self> {
        let mut all = vec![];
        let mut largest: f64 = 0.0;
        for ((found, information), spell) in of.spells.iter().zip(spells) {
            let covariance = Cholesky::new(information.clone())?.inverse() * variance;
            let n = found.len() - 1;
            let found = found.rows(1, n).into_owned();
            let covariance = covariance.view((1, 1), (n, n)).into_owned();
            for (i, two) in spell.turns.windows(2).enumerate() {
                let travel = (two[1].1 - two[0].1).abs();
                let seen = found[i].abs() + covariance[(i, i)].sqrt();
                if travel > 0.0 {
                    largest = largest.max(seen / travel);
                }
            }
            all.push(Answered { found, covariance });
        }
        let gains = (0..GAINS).map(|k| sign * 1.5 * largest * GAIN_RATIO.powi(k as i32)).collect();
        Some(Self { spells, answered: all, gains, process: of.process, log })
    }

    /// How far the stem moves with each turn, from each place where it may be at first.
    fn moves(&self, spell: &Manual, stem: Option<Stem>) -> Vec<Vec<f64>> {
        let op: Vec<f64> = spell.turns.iter().map(|(_, op)| *op).collect();
        let Some(stem) = stem else {
            let from = std::iter::once(&spell.before).chain(&op);
            return vec![from.zip(&op).map(|(a, b)| b - a).collect()];
        };
        let of = |place: &f64| stem.moves(spell.before, &op, *place);
        let mut all: Vec<Vec<f64>> = PLACES.iter().filter_map(of).collect();
        all.dedup();
        all
    }

    /// Logarithm of the likelihood of a valve at its best gain, and that gain; of one that follows, without a stem.
    pub fn likelihood(&self, stem: Option<Stem>) -> (f64, f64) {
        let moves: Vec<Vec<Vec<f64>>> =
            self.spells.iter().map(|spell| self.moves(spell, stem)).collect();
        let of_gain = |gain: &f64| -> f64 {
            let each = self.answered.iter().zip(&moves);
            each.map(|(answered, moves)| {
                let logs: Vec<f64> = moves.iter().map(|m| answered.density(m, *gain)).collect();
                log_mean(&logs)
            })
            .sum()
        };
        // What does not answer at all answers with a small gain, too.
        let coarse = self.gains.iter().map(|gain| (*gain, of_gain(gain)));
        let mut best = coarse.fold((0.0, f64::NEG_INFINITY), |a, b| if b.1 > a.1 { b } else { a });
        for by in [1.26f64, 1.12] {
            for gain in [best.0 / by, best.0 * by] {
                let log = of_gain(&gain);
                if log > best.1 {
                    best = (gain, log);
                }
            }
        }
        (self.log + best.1, best.0)
    }

    /// How well the PV goes with a valve from its likeliest places.
    pub fn seen(&self, stem: Option<Stem>) -> Seen {
        let (_, gain) = self.likelihood(stem);
        let (mut clear, mut together, mut own, mut other) = (0, 0.0, 0.0, 0.0);
        for (answered, spell) in self.answered.iter().zip(self.spells) {
            let Answered { found, covariance } = answered;
            let best = self
                .moves(spell, stem)
                .into_iter()
                .max_by(|a, b| answered.density(a, gain).total_cmp(&answered.density(b, gain)));
            for (i, m) in best.iter().flat_map(|m| &m[1..]).enumerate() {
                let (expected, sd) = (gain * m, covariance[(i, i)].sqrt());
                let ratio = found[i] / expected;
                let far = expected.abs() > 2.5 * sd && found[i].abs() > 2.5 * sd;
                clear += usize::from(far && (0.4..2.5).contains(&ratio));
                together += found[i] * expected / (sd * sd);
                own += (found[i] / sd).powi(2);
                other += (expected / sd).powi(2);
            }
        }
        let fits = if own * other > 0.0 { together / (own * other).sqrt() } else { 0.0 };
        Seen { clear, fits, strength: other.sqrt() }
    }

    /// How far the PV went with each turn until the next; not with the first of a spell, which has begun before.
    pub fn turns(
        &self,
        of: &Answers,
        looked: &[Spell],
        indices: &[usize],
    ) -> Vec<(usize, usize, f64, f64)> {
        let longest = looked.iter().map(|spell| spell.pv.len()).max().unwrap_or(0);
        let step = self.process.step(longest);
        let mut all = vec![];
        for (s, ((found, _), answered)) in of.spells.iter().zip(&self.answered).enumerate() {
            let spell = &looked[s];
            for i in 1..spell.turns.len() {
                let until = spell.turns.get(i + 1).copied().unwrap_or(spell.pv.len());
                let held = until.saturating_sub(spell.turns[i] + 1);
                let scale = step.get(held).copied().unwrap_or(0.0);
                let sd = answered.covariance[(i - 1, i - 1)].sqrt();
                all.push((indices[s], i, found[i] * scale, sd * scale));
            }
        }
        all
    }

    /// The largest change of the PV with a percent of the OP that the answers leave possible.
    pub fn upper(&self) -> f64 {
        let (mut square, mut across) = (0.0, 0.0);
        for (Answered { found, covariance }, spell) in self.answered.iter().zip(self.spells) {
            for (i, two) in spell.turns.windows(2).enumerate() {
                let travel = two[1].1 - two[0].1;
                square += travel * travel / covariance[(i, i)];
                across += travel * found[i] / covariance[(i, i)];
            }
        }
        if square > 0.0 { (across / square).abs() + 2.0 / square.sqrt() } else { f64::INFINITY }
    }

    /// The same if nothing answers.
    pub fn silence(&self) -> f64 {
        let still =
            |answered: &Answered| answered.density(&vec![0.0; answered.found.len() + 1], 0.0);
        self.log + self.answered.iter().map(still).sum::<f64>()
    }
}

impl Answered {
    /// Logarithm of the density of the answers where the stem moves so, the first turn included, but for a constant:
    /// Student's t of many dimensions.
    fn density(&self, moves: &[f64], gain: f64) -> f64 {
        let (mut apart, mut spread) = (self.found.clone(), self.covariance.clone());
        for (i, m) in moves[1..].iter().enumerate() {
            apart[i] -= gain * m;
            spread[(i, i)] += (UNEVEN * gain * m).powi(2);
        }
        let Some(factor) = Cholesky::new(spread) else { return f64::NEG_INFINITY };
        let q = apart.dot(&factor.solve(&apart));
        let n = apart.len() as f64;
        -factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
            - 0.5 * (FREEDOM + n) * (q / FREEDOM).ln_1p()
    }
}
