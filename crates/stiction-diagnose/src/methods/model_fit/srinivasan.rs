//! Srinivasan's one-parameter Hammerstein fit.
//!
//! # What it measures
//! The jump `d` of Stenman's valve with which a linear model explains the PV best, and the gain over a valve without a
//! jump.
//!
//! # Assumptions
//! An oscillating loop with one valve before one linear process. The valve model has no dead band without slips.
//!
//! # Equations
//! ```text
//! x(k) = x(k-1) if |u(k) - x(k-1)| <= d, else u(k)
//! y(k) = c + a1 y(k-1) + a2 y(k-2) + b1 x(k-t) + b2 x(k-t-1) + e(k),   t >= 1
//! AIC = m ln(SSE/m) + 2 p
//! gain = ln(SSE with d = 0 / SSE)
//! ```
//! Sticks if the gain exceeds `least` and AIC is lower than with d = 0, whose model has a parameter less.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `least` | | 0.05 | ours |
//!
//! # Limits
//! S and J both equal d here. For a valve with a dead band, d is between J and S. Corners by a disturbance are also
//! explained by d. Stenman's valve never forgets its initial position, so the method tries five. So d has an
//! uncertainty of at least a factor of 1.6, even on a clean simulated loop, and the profile is rough.
//!
//! # Deviations from the paper
//! Recalled, not read. Ours: d on a grid of shares of the OP's span and once more around its best. The delay is that of
//! the model with d = 0, and is found again for the best d. Also ours: five starts of the valve, no moving average, the
//! threshold, and a period of at most 60 samples and at most 1,500 samples.
//!
//! # References
//! R. Srinivasan, R. Rengaswamy, S. Narasimhan, R. Miller, Control loop performance assessment. 2.
//! Hammerstein model approach for stiction diagnosis, Industrial & Engineering Chemistry Research 44
//! (2005) 6719-6728 (recalled, not read).

use super::armax::{Orders, armax, first, near};
use super::published::{HammersteinFit, Window, behind, gain, profile};
use crate::finding::Abstention;
use crate::valve::{He, Model};

/// Gain above which the valve sticks. Ours.
pub const LEAST: f64 = 0.05;
/// Orders of the linear model.
const ORDERS: Orders = Orders { past: 2, taps: 2, errors: 0 };
/// Values of d in the grid.
const VALUES: i32 = 15;
/// Initial positions of the valve, shares of d from the OP. The valve never forgets them.
const STARTS: [f64; 5] = [0.0, -0.8, -0.4, 0.4, 0.8];

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
    let from = first(window.delays().into_iter().max().unwrap_or(1), ORDERS);
    let none = || Abstention("no linear model can be fitted".to_owned());
    let at = window.try_all::<He>(&window.target()?, &[window.bands(0.0, 0.0)])[0].delay;
    let (delay, mse) =
        near(&window.input(&window.op), &window.pv, at, from, ORDERS).ok_or_else(none)?;
    let linear = Judged { d: 0.0, start: 0.0, delay, mse };
    let judge = |d: f64, tried: &mut Vec<Judged>| {
        tried.extend(STARTS.iter().filter_map(|start| judged(&window, d, *start, delay, from)));
    };
    let least_of = |tried: &[Judged]| {
        tried.iter().copied().min_by(|a, b| a.mse.total_cmp(&b.mse)).ok_or_else(none)
    };
    let mut tried = vec![];
    (1..=VALUES).for_each(|i| judge(f64::from(i) / f64::from(VALUES), &mut tried));
    let summit = least_of(&tried)?.d;
    for i in [-3, -2, -1, 1, 2, 3] {
        let d = summit + f64::from(i) / f64::from(4 * VALUES);
        if d > 0.0 {
            judge(d, &mut tried);
        }
    }
    let mut best = least_of(&tried)?;
    let bands = window.bands(best.d, 1.0);
    let vp = window.positions_from(Model::Stenman, bands, begins(&window, best.d, best.start))?;
    if let Some((delay, mse)) = near(&window.input(&vp), &window.pv, at, from, ORDERS)
        && mse < best.mse
    {
        best = Judged { delay, mse, ..best };
    }

    let samples = (window.pv.len() - from) as f64;
    let won = gain(linear.mse, best.mse);
    let found = armax(&window.input(&vp), &window.pv, best.delay, from, ORDERS).ok_or_else(none)?;
    let predicted = window.pv[from..].iter().zip(&found.residual).map(|(y, e)| y - e);
    Ok(HammersteinFit {
        model: Model::Stenman,
        s: bands.s(),
        j: bands.j(),
        delay: best.delay,
        gain: won,
        threshold: least,
        sticks: won > least && samples * won > 2.0,
        profile: profile(tried.iter().map(|t| (t.d * window.span, gain(linear.mse, t.mse)))),
        fitted: behind(&window.pv, from, predicted),
        factor: window.factor,
        from: window.from,
        op: window.op,
        pv: window.pv,
        vp,
    })
}

/// A tried jump, share of the span, with the initial position of the valve, shares of d from the OP.
#[derive(Clone, Copy)]
struct Judged {
    d: f64,
    start: f64,
    delay: usize,
    mse: f64,
}

/// Initial position of the valve, percent.
fn begins(window: &Window, d: f64, start: f64) -> f64 {
    window.op[0] + start * d * window.span
}

fn judged(window: &Window, d: f64, start: f64, delay: usize, from: usize) -> Option<Judged> {
    let bands = window.bands(d, 1.0);
    let vp = window.positions_from(Model::Stenman, bands, begins(window, d, start)).ok()?;
    let found = armax(&window.input(&vp), &window.pv, delay, from, ORDERS)?;
    Some(Judged { d, start, delay, mse: found.sse / found.residual.len() as f64 })
}

#[cfg(test)]
mod tests {
    use super::super::published::samples::recorded;
    use super::*;

    #[test]
    fn the_jump_is_found() {
        for d in [2.0, 5.0] {
            let (op, pv, period) = recorded(Model::Stenman, d, d, 0.02);
            let found = fit(&op, &pv, Some(period), LEAST).unwrap();
            assert!(found.sticks, "{}", found.gain);
            assert!((found.j / d).ln().abs() < 0.5, "{d} {}", found.j);
        }
    }

    #[test]
    fn a_valve_that_follows_is_not_accused() {
        let (op, pv, period) = recorded(Model::Ideal, 0.0, 0.0, 0.05);
        let found = fit(&op, &pv, Some(period), LEAST).unwrap();
        assert!(!found.sticks, "{} {}", found.gain, found.j);
        assert!(fit(&op, &pv, None, LEAST).is_err());
        assert!(fit(&op, &vec![1.0; op.len()], Some(period), LEAST).is_err());
    }
}
