//! Lee, Ren and Huang's Hammerstein fit over a bounded region.
//!
//! # What it measures
//! S and J of He's valve, within the triangle that the OP allows, with which a process of low order and constrained
//! gain and poles explains the PV best.
//!
//! # Assumptions
//! An oscillating loop with one valve before a process of at most second order with dead time; its gain has the
//! sign that the controller assumes.
//!
//! # Equations
//! ```text
//! region:   0 <= J <= S <= span of the OP
//! process:  y(k) = c + a1 y(k-1) + a2 y(k-2) + b x(k-d) + e(k)
//!           stable: |a2| < 1, |a1| < 1 - a2;   b of the sign of -sum dOP dPV
//! gain = ln(SSE with S = 0 / SSE)
//! ```
//! A candidate whose least-squares fit violates a constraint is left out. If this happens with S = 0, the input counts
//! as explaining nothing (b = 0). Sticks if the gain exceeds `least`.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `least` | | 0.05 | ours |
//!
//! # Limits
//! The input enters at one sample only, so a slip between two samples is not fully explained. Disturbances with
//! corners look like slips. He's valve never forgets its initial position, which is assumed to be `x(0) = u(0)`.
//!
//! # Deviations from the paper
//! Recalled, not read. The paper minimises over S, J and the process by a constrained optimiser; ours searches a
//! grid of S and J, refined once, and keeps the candidates within the constraints. Ours: the delay from a model of
//! order five, then from neighbouring ones; the threshold; a period of at most 60 samples and at most 1,500
//! samples.
//!
//! # References
//! K. H. Lee, Z. Ren, B. Huang, Novel closed-loop stiction detection and quantification method via system
//! identification, Proc. ADCONIP, Jasper (2008); Stiction estimation using constrained optimisation and
//! contour map, in: Detection and Diagnosis of Stiction in Control Loops, Springer (2010) (recalled, not
//! read).

use super::armax::{Orders, armax, first, near};
use super::jelali::on_grid;
use super::published::{HammersteinFit, Window, behind, gain, profile};
use crate::Bands;
use crate::finding::Abstention;
use crate::valve::{He, Model};

/// Gain above which the valve sticks. Ours.
pub const LEAST: f64 = 0.05;
/// Orders of the process.
const ORDERS: Orders = Orders { past: 2, taps: 1, errors: 0 };
/// Judged points of each grid: the best before models of order five.
const JUDGED: usize = 8;
/// Steps of ln S and of J/S around the best.
const FINER: (f64, f64) = (0.09, 0.15);

/// Fits OP (percent) and PV of a loop that oscillates with `period` samples.
///
/// # Errors
/// If there is no period, too few samples, a signal that does not move, or no process within the constraints.
pub fn fit(
    op: &[f64],
    pv: &[f64],
    period: Option<f64>,
    least: f64,
) -> Result<HammersteinFit, Abstention> {
    let window = Window::of(op, pv, period)?;
    let from = first(window.delays().into_iter().max().unwrap_or(1), ORDERS);
    let (linear, coarse) = on_grid(&window)?;
    let none = || Abstention("no process within the constraints explains the PV".to_owned());
    let together: f64 = (window.op.windows(2).zip(window.pv.windows(2)))
        .map(|(u, y)| (u[1] - u[0]) * (y[1] - y[0]))
        .sum();
    let sign = if together > 0.0 { -1.0 } else { 1.0 };
    let judge = |bands: Bands, delay: usize| {
        let x = window.input(&window.positions(Model::He, bands).ok()?);
        let (delay, _) = near(&x, &window.pv, delay, from, ORDERS)?;
        let found = armax(&x, &window.pv, delay, from, ORDERS)?;
        let (a1, a2, b) = (found.coefficients[1], found.coefficients[2], found.coefficients[3]);
        let allowed = a2.abs() < 1.0 && a1.abs() < 1.0 - a2 && b * sign > 0.0;
        let mse = found.sse / found.residual.len() as f64;
        allowed.then_some(Judged { bands, delay, mse, residual: found.residual })
    };
    let follows = match judge(linear.bands, linear.delay) {
        Some(judged) => judged.mse,
        None => {
            let nothing = Orders { taps: 0, ..ORDERS };
            let found = armax(&window.pv, &window.pv, 1, from, nothing).ok_or_else(none)?;
            found.sse / found.residual.len() as f64
        }
    };
    let mut tried: Vec<Judged> =
        coarse.iter().take(JUDGED).filter_map(|c| judge(c.bands, c.delay)).collect();
    let summit = best(&tried).ok_or_else(none)?;
    let (s, ratio) = (summit.bands.s() / window.span, summit.bands.j() / summit.bands.s());
    let finer: Vec<Bands> = (0..16)
        .map(|l| {
            let (ds, dj) = (f64::from(l % 4) - 1.5, f64::from(l / 4) - 1.5);
            let s = (s * (ds * FINER.0).exp()).min(1.0);
            window.bands(s, (ratio + dj * FINER.1).clamp(0.0, 1.0))
        })
        .collect();
    let mut finer = window.try_all::<He>(&window.target()?, &finer);
    finer.sort_by(|a, b| a.sse.total_cmp(&b.sse));
    tried.extend(finer.iter().take(JUDGED).filter_map(|c| judge(c.bands, c.delay)));
    let Judged { bands, delay, mse, residual } = best(&tried).ok_or_else(none)?;

    let won = gain(follows, *mse);
    let predicted = window.pv[from..].iter().zip(residual).map(|(y, e)| y - e);
    Ok(HammersteinFit {
        model: Model::He,
        s: bands.s(),
        j: bands.j(),
        delay: *delay,
        gain: won,
        threshold: least,
        sticks: won > least,
        profile: profile(tried.iter().map(|t| (t.bands.s(), gain(follows, t.mse)))),
        fitted: behind(&window.pv, from, predicted),
        vp: window.positions(Model::He, *bands)?,
        factor: window.factor,
        from: window.from,
        op: window.op,
        pv: window.pv,
    })
}

/// Bands whose process is within the constraints.
struct Judged {
    bands: Bands,
    delay: usize,
    mse: f64,
    residual: Vec<f64>,
}

fn best(tried: &[Judged]) -> Option<&Judged> {
    tried.iter().min_by(|a, b| a.mse.total_cmp(&b.mse))
}

#[cfg(test)]
mod tests {
    use super::super::published::samples::recorded;
    use super::*;

    #[test]
    fn s_is_found_within_the_triangle() {
        for (s, j) in [(5.0, 3.0), (4.0, 2.0)] {
            let (op, pv, period) = recorded(Model::He, s, j, 0.02);
            let found = fit(&op, &pv, Some(period), LEAST).unwrap();
            assert!(found.sticks && (found.s / s - 1.0).abs() < 0.3, "{} {}", found.s, found.j);
            assert!(found.profile.iter().all(|(s, _)| *s > 0.0) && found.j <= found.s);
        }
    }

    #[test]
    fn a_valve_that_follows_is_not_accused() {
        let (op, pv, period) = recorded(Model::Ideal, 0.0, 0.0, 0.05);
        // Where no candidate meets the constraints, there is no fit.
        let found = fit(&op, &pv, Some(period), LEAST);
        assert!(found.as_ref().map_or(true, |fit| !fit.sticks), "{found:?}");
    }
}
