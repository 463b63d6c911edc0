//! Whether a dead band is in the valve or downstream of the process, as in a transmitter or its linkage.
//!
//! With a fast process both look alike. With a slow process they differ. A dead band in the valve makes each response
//! smaller, and a dead band downstream of the process delays it.
//!
//! ```text
//! in the valve:        y = K sum_i m_i h(k - k_i) + c + b k + n
//! behind the process:  y = K play_w(sum_i t_i h(k - k_i)) + c + b k + n
//! ```
//! m_i is the stem travel and t_i the OP travel of turn i. Both models are fitted to the whitened PV.

use super::answer::{Noise, Process, Spell};
use super::stems::{PLACES, SLID, Stem};
use super::weigh::Manual;
use crate::numeric::least_squares::dot;
use crate::valve::{Play, Start, Valve};
use nalgebra::{Matrix2, Vector2};

/// First lags and dead times to try for a dead band downstream of the process, samples, and its widths as a share of
/// the largest turn.
const TAU: [f64; 8] = [0.0, 1.0, 2.5, 6.0, 15.0, 40.0, 120.0, f64::INFINITY];
const DEAD: [usize; 6] = [0, 1, 3, 6, 12, 25];
const WIDTHS: [f64; 9] = [0.08, 0.12, 0.17, 0.25, 0.35, 0.48, 0.62, 0.78, 0.92];

/// The residual sum of squares with a dead band downstream of the process, minus that with a sticking valve. `None` if
/// one of them cannot be fitted.
pub(super) fn apart(
    kept: &[Manual],
    spells: &[Spell],
    noise: &Noise,
    processes: &[Process],
    longest_dead: usize,
    travel: f64,
    stems: &[Stem],
) -> Option<f64> {
    let longest = spells.iter().map(|spell| spell.pv.len()).max()?;
    let white: Vec<White> =
        spells.iter().map(|spell| White::of(&spell.pv, noise)).collect::<Option<_>>()?;
    let left = |paths: &[Vec<f64>]| -> Option<f64> { left_with(paths, &white, noise) };
    let paths_of = |moves: &[Vec<f64>], step: &[f64]| -> Vec<Vec<f64>> {
        let each = moves.iter().zip(spells);
        each.map(|(moves, spell)| {
            let mut path = vec![0.0; spell.pv.len()];
            for (at, m) in spell.turns.iter().zip(moves) {
                path[*at..].iter_mut().zip(step).for_each(|(y, h)| *y += m * h);
            }
            path
        })
        .collect()
    };
    let own = processes.iter().copied();
    let others = TAU.iter().flat_map(|tau| DEAD.map(|dead| Process { tau: *tau, tau2: 0.0, dead }));
    let all: Vec<Process> =
        own.chain(others.filter(|process| process.dead <= longest_dead.max(2))).collect();
    let moves_of = |(stem, place): (&Stem, &f64)| -> Option<Vec<Vec<f64>>> {
        let of_spell = |spell: &Manual| {
            let op: Vec<f64> = spell.turns.iter().map(|(_, op)| *op).collect();
            stem.moves(spell.before, &op, *place)
        };
        kept.iter().map(of_spell).collect()
    };
    let places = || PLACES[..3].iter().chain(&SLID);
    let stems = stems.iter().flat_map(|stem| places().map(move |place| (stem, place)));
    let mut moves = stems.map(moves_of).collect::<Option<Vec<_>>>()?;
    moves.dedup();
    let mut valve = f64::INFINITY;
    for process in &all {
        let step = process.step(longest);
        for moves in &moves {
            if let Some(sum) = left(&paths_of(moves, &step)) {
                valve = valve.min(sum);
            }
        }
    }
    let mut behind = f64::INFINITY;
    let travels = |spell: &Manual| -> Vec<f64> {
        let op = std::iter::once(spell.before).chain(spell.turns.iter().map(|(_, op)| *op));
        let op: Vec<f64> = op.collect();
        op.windows(2).map(|two| two[1] - two[0]).collect()
    };
    let travels: Vec<Vec<f64>> = kept.iter().map(travels).collect();
    for process in all {
        let step = process.step(longest);
        let paths = paths_of(&travels, &step);
        let swing = |path: &Vec<f64>| crate::series::span(path);
        let widest = paths.iter().map(swing).fold(0.0, f64::max);
        for width in WIDTHS {
            let width = if process.tau.is_finite() { width * travel } else { width * widest };
            let paths =
                paths.iter().map(|path| behind_play(path, width)).collect::<Option<Vec<_>>>()?;
            if let Some(sum) = left(&paths) {
                behind = behind.min(sum);
            }
        }
    }
    (valve.is_finite() && behind.is_finite()).then_some(behind - valve)
}

/// The output of a play of this width that starts at its centre; `None` if the width is invalid.
fn behind_play(input: &[f64], width: f64) -> Option<Vec<f64>> {
    let mut play = Play::new(width).ok()?;
    play.restart(Start::at_rest(input.first().copied().unwrap_or(0.0)));
    Some(input.iter().map(|x| play.step(*x)).collect())
}

/// The whitened PV of a spell, beside a level and a slope.
struct White {
    pv: Vec<f64>,
    level: Vec<f64>,
    slope: Vec<f64>,
    /// Inverse of the products of level and slope with each other.
    inverse: Matrix2<f64>,
    /// Their products with the PV, and its own.
    of_pv: Vector2<f64>,
    square: f64,
}

impl White {
    /// `None` if level and slope are the same, as in a very short spell.
    fn of(pv: &[f64], noise: &Noise) -> Option<Self> {
        let (n, from) = (pv.len(), noise.order());
        let pv = noise.whitened(pv);
        let level = noise.whitened(&vec![1.0; n]);
        let slope = noise.whitened(&(0..n).map(|k| k as f64 / n as f64).collect::<Vec<_>>());
        let [y, c, b] = [&pv, &level, &slope].map(|x| &x[from.min(n)..]);
        let gram = Matrix2::new(dot(c, c), dot(c, b), dot(c, b), dot(b, b));
        let (of_pv, square) = (Vector2::new(dot(c, y), dot(b, y)), dot(y, y));
        let inverse = gram.try_inverse()?;
        Some(Self { pv, level, slope, inverse, of_pv, square })
    }
}

/// The residual sum of squares of the PV with a level and slope for each spell and one gain for all.
fn left_with(paths: &[Vec<f64>], white: &[White], noise: &Noise) -> Option<f64> {
    let (mut square, mut across, mut nothing) = (0.0, 0.0, 0.0);
    for (path, white) in paths.iter().zip(white) {
        let path = noise.whitened(path);
        let path = &path[noise.order().min(path.len())..];
        let of = |other: &[f64]| dot(path, &other[other.len() - path.len()..]);
        // Level and slope are eliminated.
        let (beside, v) = (Vector2::new(of(&white.level), of(&white.slope)), white.of_pv);
        square += dot(path, path) - beside.dot(&(white.inverse * beside));
        across += of(&white.pv) - beside.dot(&(white.inverse * v));
        nothing += white.square - v.dot(&(white.inverse * v));
    }
    (square > 0.0).then(|| nothing - across * across / square)
}
