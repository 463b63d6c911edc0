//! Karra and Karim's diagnosis with an extended ARMAX model.
//!
//! # What it measures
//! Whether a sticking valve, a disturbance from outside or an aggressive controller causes the oscillation. The
//! answer is the model, with or without each of them, that explains the PV best.
//!
//! # Assumptions
//! An oscillating loop with one valve before one linear process of low order, and one cause.
//!
//! # Equations
//! ```text
//! models: the EARMAX model of `earx`, with x = u or with x = He's valve of S and J, and with each walk of
//!         0, 0.01 and 0.3
//! BIC = -2 ln L + p ln m
//! gain = (BIC of the best with x = u less BIC of the best with a valve) / m
//! ```
//! Sticks if the gain exceeds `least`. Otherwise the oscillation comes from outside if a walk above 0 is best and
//! the disturbance is more than half of the variance of the two parts of the PV; else the controller is aggressive.
//! p is 5, plus 2 with S and J, plus 1 with a walk.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `least` | | 0.05 | ours |
//!
//! # Limits
//! A disturbance with corners looks like a sticking valve. An aggressive controller is only the remaining cause if
//! nothing else is found.
//!
//! # Deviations from the paper
//! Recalled, not read. Ours: the grid of S and J and its refinement by models of order five, the walks, the
//! estimation (see `earx`), the numeric rules, and a period of at most 60 samples and at most 1,500 samples.
//!
//! # References
//! S. Karra, M. N. Karim, Comprehensive methodology for detection and diagnosis of oscillatory control
//! loops, Control Engineering Practice 17 (2009) 939-956 (recalled, not read).

use super::armax::{Orders, first, near};
use super::earx::{self, Earx};
use super::jelali::on_grid;
use super::published::{HammersteinFit, Window, profile};
use crate::Bands;
use crate::finding::Abstention;
use crate::series::variance;
use crate::valve::{He, Model};

/// Gain above which the valve sticks. Ours.
pub const LEAST: f64 = 0.05;
/// Tried walks of the disturbance. Ours.
const WALKS: [f64; 3] = [0.0, 0.01, 0.3];
/// Fitted numbers: coefficients, S and J, walk.
const COEFFICIENTS: f64 = 5.0;
const BANDS: f64 = 2.0;
/// Share of the disturbance above which it is the cause. Ours.
const OUTSIDE: f64 = 0.5;
/// Steps of ln S and J/S around the best.
const FINER: (f64, f64) = (0.09, 0.15);

/// The cause of an oscillation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// The valve sticks.
    Stiction,
    /// A disturbance from outside.
    Disturbance,
    /// The controller is aggressive.
    Tuning,
}

impl Cause {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stiction => "a sticking valve",
            Self::Disturbance => "a disturbance from outside",
            Self::Tuning => "an aggressive controller",
        }
    }
}

/// The best model of each kind, and the resulting cause.
#[derive(Debug, Clone, PartialEq)]
pub struct KarraKarim {
    /// The fit with a valve; its gain is per sample.
    pub fit: HammersteinFit,
    /// The cause of the oscillation.
    pub cause: Cause,
    /// Share of the disturbance in the variance of both parts of the PV, by the best model.
    pub disturbance_share: f64,
    /// The part of the disturbance in the PV, standard deviations of PV.
    pub disturbance: Vec<f64>,
}

/// Fits OP (percent) and PV of a loop that oscillates with `period` samples.
///
/// # Errors
/// If there is no period, too few samples, or a signal that does not move.
pub fn fit(
    op: &[f64],
    pv: &[f64],
    period: Option<f64>,
    least: f64,
) -> Result<KarraKarim, Abstention> {
    let window = Window::of(op, pv, period)?;
    let (linear, mut tried) = on_grid(&window)?;
    let summit = tried[0].bands;
    let finer: Vec<Bands> = (0..16)
        .map(|l| {
            let (ds, dj) = (f64::from(l % 4) - 1.5, f64::from(l / 4) - 1.5);
            let s = summit.s() / window.span * (ds * FINER.0).exp();
            window.bands(s, (summit.j() / summit.s() + dj * FINER.1).clamp(0.0, 1.0))
        })
        .collect();
    tried.extend(window.try_all::<He>(&window.target()?, &finer));
    let none = || Abstention("no linear model can be fitted".to_owned());
    let best = tried.iter().min_by(|a, b| a.sse.total_cmp(&b.sse)).copied().ok_or_else(none)?;
    let vp = window.positions(Model::He, best.bands)?;
    let follows =
        weighed(&window.input(&window.op), &window.pv, linear.delay, 0.0).ok_or_else(none)?;
    let sticky = weighed(&window.input(&vp), &window.pv, best.delay, BANDS).ok_or_else(none)?;

    let won = (follows.bic - sticky.bic) / follows.model.samples as f64;
    let sticks = won > least;
    let chosen = if sticks { &sticky } else { &follows };
    let [outside, inside] =
        [&chosen.model.disturbance, &chosen.model.process].map(|part| variance(part));
    let share = outside / (outside + inside).max(f64::MIN_POSITIVE);
    let cause = if sticks {
        Cause::Stiction
    } else if follows.walk > 0.0 && share > OUTSIDE {
        Cause::Disturbance
    } else {
        Cause::Tuning
    };
    let profile =
        profile(tried.iter().map(|c| (c.bands.s(), super::published::gain(linear.sse, c.sse))));
    Ok(KarraKarim {
        cause,
        disturbance_share: share,
        disturbance: chosen.model.disturbance.clone(),
        fit: HammersteinFit {
            model: Model::He,
            s: best.bands.s(),
            j: best.bands.j(),
            delay: best.delay,
            gain: won,
            threshold: least,
            sticks,
            profile,
            fitted: sticky.model.predicted,
            factor: window.factor,
            from: window.from,
            op: window.op,
            pv: window.pv,
            vp,
        },
    })
}

/// A model with its walk and its information.
struct Weighed {
    model: Earx,
    walk: f64,
    bic: f64,
}

/// The best of all walks behind one input.
fn weighed(x: &[f64], y: &[f64], delay: usize, more: f64) -> Option<Weighed> {
    let orders = Orders { past: 2, taps: 2, errors: 0 };
    let (delay, _) = near(x, y, delay, first(delay, orders), orders)?;
    let of = |walk: f64| {
        let model = earx::fit(x, y, delay, walk)?;
        let parameters = COEFFICIENTS + more + if walk > 0.0 { 1.0 } else { 0.0 };
        let bic = parameters * (model.samples as f64).ln() - 2.0 * model.log_likelihood;
        Some(Weighed { model, walk, bic })
    };
    WALKS.into_iter().filter_map(of).min_by(|a, b| a.bic.total_cmp(&b.bic))
}

#[cfg(test)]
mod tests {
    use super::super::published::samples::recorded;
    use super::*;

    #[test]
    fn a_sticking_valve_is_distinguished_from_a_wave_from_outside() {
        let (op, pv, period) = recorded(Model::He, 5.0, 3.0, 0.02);
        let found = fit(&op, &pv, Some(period), LEAST).unwrap();
        assert_eq!(found.cause, Cause::Stiction, "{}", found.fit.gain);
        assert!((found.fit.s / 5.0 - 1.0).abs() < 0.25, "{}", found.fit.s);

        let (op, pv, period) = recorded(Model::Ideal, 0.0, 0.0, 0.05);
        let found = fit(&op, &pv, Some(period), LEAST).unwrap();
        assert_ne!(found.cause, Cause::Stiction, "{}", found.fit.gain);
    }
}
