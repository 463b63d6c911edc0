//! Jelali's two-parameter Hammerstein fit by direct search.
//!
//! # What it measures
//! S and J of He's valve with which a linear model with coloured errors explains the PV best, and its gain over a
//! valve that follows.
//!
//! # Assumptions
//! An oscillating loop with one valve before one linear process.
//!
//! # Equations
//! ```text
//! outside: S and J with the smallest SSE, by a pattern search from the best points of a grid
//! inside:  y(k) = c + sum_{i=1..2} a_i y(k-i) + sum_{j=0..1} b_j x(k-d-j) + sum_{l=1..2} c_l e(k-l) + e(k)
//! gain = ln(SSE with S = 0 / SSE)
//! ```
//! The pattern search (Hooke and Jeeves) moves ln S and J/S in turn by a step. The step is halved if neither move
//! lowers SSE. Sticks if the gain exceeds `least`.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `least` | | 0.1 | ours |
//!
//! # Limits
//! The errors have several minima along S; the grid has 31 points. J is less certain than S. He's valve never
//! forgets its initial position, which is assumed to be `x(0) = u(0)`.
//!
//! # Deviations from the paper
//! Recalled, not read. Ours: a grid and pattern searches from its two best points, instead of a genetic algorithm
//! before the pattern search, so that the same data always give the same result. The delay comes from a model of
//! order five on the grid, the moving average from two steps of least squares. Also ours: the threshold, and a
//! period of at most 60 samples and at most 1,500 samples.
//!
//! # References
//! M. Jelali, Estimation of valve stiction in control loops using separable least-squares and global
//! search algorithms, Journal of Process Control 18 (2008) 632-642 (recalled, not read).

use super::armax::{Orders, armax, first, near};
use super::published::{Candidate, HammersteinFit, Window, behind, gain, profile};
use crate::finding::Abstention;
use crate::identify::arx::TAPS;
use crate::valve::{He, Model};

/// Gain above which the valve sticks. Ours.
pub const LEAST: f64 = 0.1;
/// Orders of the linear model.
const ORDERS: Orders = Orders { past: 2, taps: 2, errors: 2 };
/// The grid: S in shares of the span, J in shares of S.
pub(super) const GRID_S: [f64; 10] = [0.05, 0.1, 0.16, 0.24, 0.33, 0.44, 0.56, 0.7, 0.84, 1.0];
pub(super) const GRID_J: [f64; 3] = [0.1, 0.45, 1.0];
/// Smallest distance in ln S between starting points of the search.
const APART: f64 = 0.5;
/// First steps of ln S and J/S, and the number of halvings.
const STEPS: (f64, f64) = (0.12, 0.16);
const HALVINGS: i32 = 3;
/// Points per search.
const TRIALS: usize = 10;

/// Fits OP (percent) and PV of a loop that oscillates with `period` samples.
///
/// # Errors
/// If there is no period, too few samples, or a signal that does not move.
pub fn fit(
    op: &[f64],
    pv: &[f64],
    period: Option<f64>,
    least: f64,
) -> Result<HammersteinFit, Abstention> {
    let window = Window::of(op, pv, period)?;
    let (linear, coarse) = on_grid(&window)?;
    let longest = window.delays().into_iter().max().unwrap_or(1);
    let from = first(longest, ORDERS);
    let mse = |place: Place, delay: usize| -> Option<f64> {
        let vp = window.positions(Model::He, window.bands(place.s.exp(), place.ratio)).ok()?;
        let found = armax(&window.input(&vp), &window.pv, delay, from, ORDERS)?;
        Some(found.sse / found.residual.len() as f64)
    };
    let none = || Abstention("no linear model can be fitted".to_owned());
    let input = window.input(&window.op);
    let follows = (linear.delay..linear.delay + TAPS)
        .filter_map(|delay| armax(&input, &window.pv, delay, from, ORDERS))
        .map(|found| found.sse / found.residual.len() as f64)
        .reduce(f64::min)
        .ok_or_else(none)?;

    let start = |candidate: &Candidate| {
        let s = candidate.bands.s();
        let vp = window.positions(Model::He, candidate.bands).ok()?;
        let (delay, _) = near(&window.input(&vp), &window.pv, candidate.delay, from, ORDERS)?;
        Some((Place { s: (s / window.span).ln(), ratio: candidate.bands.j() / s }, delay))
    };
    let summit = start(&coarse[0]);
    let apart = |c: &&Candidate| (c.bands.s() / coarse[0].bands.s()).ln().abs() > APART;
    let elsewhere = coarse.iter().find(apart).and_then(start);
    let mut tried = vec![];
    for (place, delay) in [summit, elsewhere].into_iter().flatten() {
        search(place, |place| mse(place, delay), |place, mse| tried.push((place, delay, mse)));
    }
    let &(place, delay, best) = tried.iter().min_by(|a, b| a.2.total_cmp(&b.2)).ok_or_else(none)?;
    let won = gain(follows, best);
    let bands = window.bands(place.s.exp(), place.ratio);
    let vp = window.positions(Model::He, bands)?;
    let found = armax(&window.input(&vp), &window.pv, delay, from, ORDERS).ok_or_else(none)?;
    let predicted = window.pv[from..].iter().zip(&found.residual).map(|(y, e)| y - e);
    Ok(HammersteinFit {
        model: Model::He,
        s: bands.s(),
        j: bands.j(),
        delay,
        gain: won,
        threshold: least,
        sticks: won > least,
        profile: profile(
            tried.iter().map(|(place, _, mse)| (place.s.exp() * window.span, gain(follows, *mse))),
        ),
        fitted: behind(&window.pv, from, predicted),
        factor: window.factor,
        from: window.from,
        op: window.op,
        pv: window.pv,
        vp,
    })
}

/// The valve that follows, and He's valves over the grid, the best first, before linear models of order
/// five.
pub(super) fn on_grid(window: &Window) -> Result<(Candidate, Vec<Candidate>), Abstention> {
    let mut bands = vec![window.bands(0.0, 0.0)];
    bands.extend(GRID_J.iter().flat_map(|j| GRID_S.iter().map(|s| window.bands(*s, *j))));
    let mut tried = window.try_all::<He>(&window.target()?, &bands);
    let linear = tried.remove(0);
    tried.retain(|candidate| candidate.sse.is_finite());
    tried.sort_by(|a, b| a.sse.total_cmp(&b.sse));
    if tried.is_empty() || !linear.sse.is_finite() {
        return Err(Abstention("no linear model can be fitted".to_owned()));
    }
    Ok((linear, tried))
}

/// Logarithm of S over the span, and J over S.
#[derive(Clone, Copy)]
struct Place {
    s: f64,
    ratio: f64,
}

/// Searches downhill from `place` and reports the tried points.
fn search(mut place: Place, value: impl Fn(Place) -> Option<f64>, mut say: impl FnMut(Place, f64)) {
    let mut trials = 0;
    let mut look = |place: Place| {
        trials += 1;
        let found = value(place)?;
        say(place, found);
        Some((found, trials))
    };
    let Some((mut best, _)) = look(place) else { return };
    let mut halved = 0;
    while halved < HALVINGS {
        let scale = 0.5f64.powi(halved);
        let moved = |ds: f64, dj: f64| Place {
            s: place.s + scale * STEPS.0 * ds,
            ratio: (place.ratio + scale * STEPS.1 * dj).clamp(0.0, 1.0),
        };
        let mut downhill = None;
        for next in [moved(1.0, 0.0), moved(-1.0, 0.0), moved(0.0, 1.0), moved(0.0, -1.0)] {
            let Some((found, trials)) = look(next) else { continue };
            if found < best {
                (best, downhill) = (found, Some(next));
                break;
            }
            if trials >= TRIALS {
                return;
            }
        }
        match downhill {
            Some(next) => place = next,
            None => halved += 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::published::samples::recorded;
    use super::*;

    #[test]
    fn s_and_j_are_found() {
        for (s, j) in [(5.0, 3.0), (4.0, 1.5)] {
            let (op, pv, period) = recorded(Model::He, s, j, 0.02);
            let found = fit(&op, &pv, Some(period), LEAST).unwrap();
            assert!(found.sticks && (found.s / s - 1.0).abs() < 0.25, "{} {}", found.s, found.j);
        }
    }

    #[test]
    fn a_valve_that_follows_is_not_accused() {
        let (op, pv, period) = recorded(Model::Ideal, 0.0, 0.0, 0.05);
        let found = fit(&op, &pv, Some(period), LEAST).unwrap();
        assert!(!found.sticks, "{} {}", found.gain, found.s);
    }

    #[test]
    fn a_bowl_is_descended() {
        let bowl = |p: Place| Some((p.s + 0.2).powi(2) + (p.ratio - 0.5).powi(2));
        let mut least = f64::INFINITY;
        search(Place { s: -0.4, ratio: 0.4 }, bowl, |_, value| least = least.min(value));
        assert!(least < 0.01, "{least}");
    }
}
