//! How well each valve explains the answers of the PV to the turns of a test.
//!
//! # Equations
//! A valve moves the stem by m_i and the PV by K m_i with turn i. The [estimated answers](super::answer) then follow
//!
//! ```text
//! a ~ t(K m, s^2 F^-1 + diag (e K m_i)^2),     e = 0.15: no gain is the same everywhere
//! ```

use super::answer::{Answers, Process, Spell};
use super::stems::{PLACES, SLID, Stem};
use super::weigh::{Manual, log_mean};
use crate::series::max;
use nalgebra::{Cholesky, DMatrix, DVector};
use stiction_model::simd::{Kernel, Lane, Width};

/// Relative change of the gain from turn to turn, of a process and of a recorded position.
pub(super) const UNEVEN: f64 = 0.15;
pub(super) const UNEVEN_POSITION: f64 = 0.015;
/// Gains to try, relative to the best constant gain.
const GAINS: [f64; 5] = [1.6, 1.26, 1.0, 0.8, 0.5];
/// Degrees of freedom of Student's t for the answers of a piece.
const FREEDOM: f64 = 6.0;
/// Largest number of turns in a piece.
const PIECE: usize = 24;
/// Smallest standard deviation of an answer, as a share of that change of the largest answer, because no process is
/// exactly linear.
const AT_BEST: f64 = 0.2;

/// How well the PV agrees with a valve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    /// Number of turns with a clear answer of about the expected size.
    pub clear: usize,
    /// Correlation of estimated and expected answers, each in standard deviations.
    pub fits: f64,
    /// Length of the vector of expected answers, in standard deviations.
    pub strength: f64,
}

/// The answers of one spell, without its first turn, because the stem position before it is unknown.
struct Answered(Vec<Piece>);

/// Consecutive turns. Errors of one piece hardly affect the next.
struct Piece {
    /// Index of its first turn; the first turn of the spell is not counted.
    from: usize,
    /// PV units by turn.
    found: DVector<f64>,
    covariance: DMatrix<f64>,
    information: DMatrix<f64>,
    /// Relative change of the gain from turn to turn.
    uneven: f64,
}

/// The answers for one process, which valves have to explain.
pub(super) struct Problem<'a> {
    spells: &'a [Manual],
    answered: Vec<Answered>,
    /// Sign of the gain.
    sign: f64,
    pub process: Process,
    /// Log-likelihood of the process itself.
    log: f64,
}

impl<'a> Problem<'a> {
    /// The problem for one process, with the sign of its gain, the log-likelihood of the process and how uneven the gain
    /// is.
    pub fn of(
        of: &Answers,
        spells: &'a [Manual],
        sign: f64,
        variance: f64,
        log: f64,
        uneven: f64,
    ) -> Option<Self> {
        let mut all = vec![];
        let mut furthest: f64 = 0.0;
        for (found, information) in &of.spells {
            let covariance = Cholesky::new(information.clone())?.inverse() * variance;
            let n = found.len() - 1;
            let found = found.rows(1, n).into_owned();
            let covariance = covariance.view((1, 1), (n, n)).into_owned();
            for (i, answer) in found.iter().enumerate() {
                furthest = furthest.max(answer.abs() - 3.0 * covariance[(i, i)].sqrt());
            }
            all.push((found, covariance));
        }
        let floor = (AT_BEST * uneven * furthest).powi(2);
        let piece = |found: &DVector<f64>, covariance: &DMatrix<f64>, from: usize| {
            let n = (found.len() - from).min(PIECE);
            let mut covariance = covariance.view((from, from), (n, n)).into_owned();
            (0..n).for_each(|i| covariance[(i, i)] += floor);
            let information = Cholesky::new(covariance.clone())?.inverse();
            let found = found.rows(from, n).into_owned();
            Some(Piece { from, found, covariance, information, uneven })
        };
        let answered = |(found, covariance): &(DVector<f64>, DMatrix<f64>)| {
            let pieces = (0..found.len()).step_by(PIECE);
            pieces.map(|from| piece(found, covariance, from)).collect::<Option<_>>().map(Answered)
        };
        let answered = all.iter().map(answered).collect::<Option<_>>()?;
        Some(Self { spells, answered, sign, process: of.process, log })
    }

    /// The stem travel of each turn, for each possible position at the start.
    fn moves(&self, spell: &Manual, stem: Option<Stem>, places: &[f64]) -> Vec<Vec<f64>> {
        let op: Vec<f64> = spell.turns.iter().map(|(_, op)| *op).collect();
        let Some(stem) = stem else {
            let from = std::iter::once(&spell.before).chain(&op);
            return vec![from.zip(&op).map(|(a, b)| b - a).collect()];
        };
        let of = |place: &f64| stem.moves(spell.before, &op, *place);
        let mut all: Vec<Vec<f64>> = places.iter().filter_map(of).collect();
        // Once the first turn has moved the stem, its start position no longer matters.
        all.dedup_by(|a, b| a[1..] == b[1..]);
        all
    }

    /// Log-likelihood of a valve at its best gain, and this gain. Without a stem, the valve follows the OP.
    pub fn likelihood(&self, stem: Option<Stem>) -> (f64, f64) {
        self.placed_at(stem, &PLACES, log_mean)
    }

    /// Log-likelihood of a stem that slid before the test.
    pub fn slid(&self, stem: Stem) -> f64 {
        self.placed_at(Some(stem), &SLID, max).0
    }

    /// Log-likelihood of a stem from some start positions. `over` combines their log-likelihoods.
    fn placed_at(&self, stem: Option<Stem>, places: &[f64], over: fn(&[f64]) -> f64) -> (f64, f64) {
        let moves: Vec<Vec<Vec<f64>>> =
            self.spells.iter().map(|spell| self.moves(spell, stem, places)).collect();
        let better = |best: (f64, f64), gains: &[f64]| {
            let mut logs = vec![0.0; gains.len()];
            for (answered, moves) in self.answered.iter().zip(&moves) {
                let of_gain =
                    |gain: &f64| moves.iter().map(|m| (&m[..], *gain)).collect::<Vec<_>>();
                let all = answered.densities(&gains.iter().flat_map(of_gain).collect::<Vec<_>>());
                let places = moves.len();
                for (k, log) in logs.iter_mut().enumerate() {
                    *log += over(&all[k * places..(k + 1) * places]);
                }
            }
            let each = gains.iter().copied().zip(logs);
            each.fold(best, |a, b| if b.1 > a.1 { b } else { a })
        };
        // The best constant gain and multiples of it. Small gains are needed if the PV does not answer.
        let gain = self.gain(&moves);
        let mut best = better((0.0, f64::NEG_INFINITY), &GAINS.map(|by| gain * by));
        for by in [1.12, 1.06] {
            best = better(best, &[best.0 / by, best.0 * by]);
        }
        (self.log + best.1, best.0)
    }

    /// The least-squares gain for the stem from the first start position from which it moves. It has the given sign and
    /// is not below 0.3 of its standard deviation.
    fn gain(&self, moves: &[Vec<Vec<f64>>]) -> f64 {
        for place in 0..PLACES.len() {
            let (mut own, mut across) = (0.0, 0.0);
            for (answered, moves) in self.answered.iter().zip(moves) {
                let Some(m) = moves.get(place).or(moves.last()) else { continue };
                for piece in &answered.0 {
                    let m = DVector::from_row_slice(piece.of(m));
                    own += m.dot(&(&piece.information * &m));
                    across += m.dot(&(&piece.information * &piece.found));
                }
            }
            if own > 0.0 {
                return self.sign * (self.sign * across / own).max(0.3 / own.sqrt());
            }
        }
        0.0
    }

    /// How well the PV agrees with a valve from its likeliest start positions.
    pub fn seen(&self, stem: Option<Stem>) -> Seen {
        let (_, gain) = self.likelihood(stem);
        let (mut clear, mut together, mut own, mut other) = (0, 0.0, 0.0, 0.0);
        for (answered, spell) in self.answered.iter().zip(self.spells) {
            let moves = self.moves(spell, stem, &PLACES);
            let logs =
                answered.densities(&moves.iter().map(|m| (&m[..], gain)).collect::<Vec<_>>());
            let best = moves.iter().zip(logs).max_by(|a, b| a.1.total_cmp(&b.1));
            for (i, m) in best.iter().flat_map(|(m, _)| &m[1..]).enumerate() {
                let (expected, (found, sd)) = (gain * m, answered.turn(i));
                let ratio = found / expected;
                let far = expected.abs() > 2.5 * sd && found.abs() > 2.5 * sd;
                clear += usize::from(far && (0.4..2.5).contains(&ratio));
                together += found * expected / (sd * sd);
                own += (found / sd).powi(2);
                other += (expected / sd).powi(2);
            }
        }
        let fits = if own * other > 0.0 { together / (own * other).sqrt() } else { 0.0 };
        Seen { clear, fits, strength: other.sqrt() }
    }

    /// The PV change of each turn until the next, or until the process has responded if the next follows sooner. The first turn of
    /// a spell is left out.
    pub fn turns(
        &self,
        of: &Answers,
        looked: &[Spell],
        indices: &[usize],
    ) -> Vec<(usize, usize, f64, f64)> {
        let longest = looked.iter().map(|spell| spell.pv.len()).max().unwrap_or(0);
        let step = self.process.step(longest);
        let Process { tau, tau2, dead } = self.process;
        let responded = dead + 1 + (if tau.is_finite() { tau } else { 0.0 } + tau2).ceil() as usize;
        let mut all = vec![];
        for (s, ((found, _), answered)) in of.spells.iter().zip(&self.answered).enumerate() {
            let spell = &looked[s];
            for i in 1..spell.turns.len() {
                let until = spell.turns.get(i + 1).copied().unwrap_or(spell.pv.len());
                let held = until.saturating_sub(spell.turns[i] + 1).max(responded);
                let scale = step.get(held).or(step.last()).copied().unwrap_or(0.0);
                let (_, sd) = answered.turn(i - 1);
                all.push((indices[s], i, found[i] * scale, sd * scale));
            }
        }
        all
    }

    /// Upper limit of the PV change per percent of OP, from the answers.
    pub fn upper(&self) -> f64 {
        let (mut square, mut across) = (0.0, 0.0);
        for (answered, spell) in self.answered.iter().zip(self.spells) {
            for (i, two) in spell.turns.windows(2).enumerate() {
                let (travel, (found, sd)) = (two[1].1 - two[0].1, answered.turn(i));
                square += (travel / sd).powi(2);
                across += travel * found / (sd * sd);
            }
        }
        if square > 0.0 { (across / square).abs() + 2.0 / square.sqrt() } else { f64::INFINITY }
    }

    /// Log-likelihood without any answer.
    pub fn silence(&self) -> f64 {
        let still = |answered: &Answered| {
            let turns: usize = answered.0.iter().map(|piece| piece.found.len()).sum();
            answered.densities(&[(&vec![0.0; turns + 1], 0.0)])[0]
        };
        self.log + self.answered.iter().map(still).sum::<f64>()
    }
}

impl Answered {
    /// The PV change of turn `i`, without counting the first of the spell, and its standard deviation.
    fn turn(&self, i: usize) -> (f64, f64) {
        let piece = &self.0[i / PIECE];
        let i = i - piece.from;
        (piece.found[i], piece.covariance[(i, i)].sqrt())
    }

    /// Log-density of the answers for each case: moves of the stem, which include the first turn, and a gain.
    fn densities(&self, cases: &[(&[f64], f64)]) -> Vec<f64> {
        let mut all = vec![0.0; cases.len()];
        for piece in &self.0 {
            for (logs, cases) in all.chunks_mut(CASES).zip(cases.chunks(CASES)) {
                let of = Width::widest().run(Densities { piece, cases });
                logs.iter_mut().zip(of).for_each(|(log, of)| *log += of);
            }
        }
        all
    }
}

impl Piece {
    /// Its part of the moves of a spell, whose first turn is not counted.
    fn of<'a>(&self, moves: &'a [f64]) -> &'a [f64] {
        &moves[1 + self.from..1 + self.from + self.found.len()]
    }
}

/// Number of cases whose densities are computed together.
const CASES: usize = 8;

/// The log-densities of the answers of a piece for some cases, up to a constant: a multivariate Student's t.
struct Densities<'a> {
    piece: &'a Piece,
    /// At most [`CASES`].
    cases: &'a [(&'a [f64], f64)],
}

impl Kernel for Densities<'_> {
    type Output = [f64; CASES];

    #[inline(always)]
    fn run(self) -> [f64; CASES] {
        type Lanes = Lane<CASES>;
        let Self { piece, cases } = self;
        let n = piece.found.len();
        // The rows of the Cholesky factor L, each up to its diagonal, and the deviations d, of which L^-1 d is computed.
        let mut rows = [Lanes::splat(0.0); PIECE * (PIECE + 1) / 2];
        let mut apart = [Lanes::splat(0.0); PIECE];
        for i in 0..n {
            let row = &mut rows[i * (i + 1) / 2..][..=i];
            for (j, each) in row.iter_mut().enumerate() {
                *each = Lanes::splat(piece.covariance[(i, j)]);
            }
            apart[i] = Lanes::splat(piece.found[i]);
            for (l, (moves, gain)) in cases.iter().enumerate() {
                let expected = gain * piece.of(moves)[i];
                apart[i][l] -= expected;
                row[i][l] += (piece.uneven * expected).powi(2);
            }
        }
        // The diagonal is divided by this, so that its product has no unit.
        let unit = piece.covariance[(0, 0)].sqrt();
        let (mut product, mut squares) = (Lanes::splat(1.0), Lanes::splat(0.0));
        for i in 0..n {
            let (above, below) = rows.split_at_mut(i * (i + 1) / 2);
            let row = &mut below[..=i];
            for j in 0..i {
                let other = &above[j * (j + 1) / 2..][..=j];
                let mut sum = row[j];
                for k in 0..j {
                    sum.subtract_product(&row[k], &other[k]);
                }
                row[j] = Lanes::from_fn(|l| sum[l] / other[j][l]);
            }
            let (mut square, mut deviation) = (row[i], apart[i]);
            for k in 0..i {
                square.subtract_product(&row[k], &row[k]);
                deviation.subtract_product(&row[k], &apart[k]);
            }
            // Not a number where the covariance is not positive definite.
            row[i] = Lanes::from_fn(|l| square[l].sqrt());
            apart[i] = Lanes::from_fn(|l| deviation[l] / row[i][l]);
            product = Lanes::from_fn(|l| product[l] * (row[i][l] / unit));
            let own = apart[i];
            squares.add_product(&own, &own);
        }
        let freedom = 0.5 * (FREEDOM + n as f64);
        std::array::from_fn(|l| {
            let log =
                -product[l].ln() - n as f64 * unit.ln() - freedom * (squares[l] / FREEDOM).ln_1p();
            if log.is_finite() { log } else { f64::NEG_INFINITY }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::NormalStream;

    #[test]
    fn densities_are_those_of_a_cholesky_factor_for_each_case() {
        let mut draw = NormalStream::new(3);
        for n in [1, 5, PIECE] {
            let root = DMatrix::from_fn(n, n, |_, _| draw.draw());
            let covariance = &root * root.transpose() + DMatrix::identity(n, n);
            let found = DVector::from_fn(n, |_, _| 3.0 * draw.draw());
            let information = Cholesky::new(covariance.clone()).unwrap().inverse();
            let uneven = UNEVEN;
            let piece = Piece { from: 0, found, covariance, information, uneven };
            let answered = Answered(vec![piece]);
            // More cases than share lanes, and not a multiple of them.
            let moves: Vec<Vec<f64>> =
                (0..11).map(|_| (0..=n).map(|_| 2.0 * draw.draw()).collect()).collect();
            let gain = |case: usize| 0.3 * case as f64 - 1.0;
            let cases: Vec<(&[f64], f64)> =
                moves.iter().enumerate().map(|(case, m)| (&m[..], gain(case))).collect();
            let piece = &answered.0[0];
            for ((moves, gain), log) in cases.iter().zip(answered.densities(&cases)) {
                let (mut apart, mut spread) = (piece.found.clone(), piece.covariance.clone());
                for (i, m) in moves[1..].iter().enumerate() {
                    apart[i] -= gain * m;
                    spread[(i, i)] += (UNEVEN * gain * m).powi(2);
                }
                let factor = Cholesky::new(spread).unwrap();
                let q = apart.dot(&factor.solve(&apart));
                let expected = -0.5 * factor.determinant().ln()
                    - 0.5 * (FREEDOM + n as f64) * (q / FREEDOM).ln_1p();
                assert!((log - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{log} {expected}");
            }
        }
    }

    #[test]
    fn a_covariance_that_is_none_has_no_density() {
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        let (found, information) = (DVector::zeros(2), DMatrix::identity(2, 2));
        let piece = Piece { from: 0, found, covariance, information, uneven: UNEVEN };
        let still = Answered(vec![piece]).densities(&[(&[0.0, 0.0, 0.0], 1.0)]);
        assert_eq!(still, [f64::NEG_INFINITY]);
    }
}
