//! Tuning of a PI controller around a sticking valve: robust, and with the smallest swing of the PV.
//!
//! # What it computes
//! * The performance of a tuning without the valve: [`FrequencyResponse::margins`] for `Ms`, [`load_step_iae`].
//! * A starting point: [`simc`], [`lambda`].
//! * All tunings of a grid within a bound on `Ms`: [`robust`].
//! * The tuning among these whose limit cycle has the smallest swing of the PV, with its cost: [`least_swing`].
//!
//! # Assumptions
//! The process is known. The given function determines the cycle: by describing function ([`by_describing_function`])
//! or exactly.
//!
//! # Equations
//! ```text
//! IAE = integral of |sp - pv| dt after a step of the load by 1 percent, at rest before
//! SIMC, first order:   Kc = tau / (K (tc + theta)),   Ti = min(tau, 4 (tc + theta))
//! SIMC, integrator:    Kc = 1 / (K (tc + theta)),     Ti = 4 (tc + theta)
//! SIMC, second order:  as first order with tau1 + tau2 / 2 and theta + tau2 / 2   (tau2 <= tau1)
//! lambda:              Kc = tau / (K (lambda + theta)), Ti = tau
//! ```
//! If the error keeps its sign, `IAE = |Ti / Kc|`.
//!
//! # Limits
//! **Harmonic balance is unreliable where it finds no cycle.** With an integral time well above the sum of time
//! constant and dead time it finds none around a valve with slip jump, although simulation continues to cycle. For
//! a slow process under a tight controller it predicts a cycle with dead band alone, which simulation confirms only
//! for some. A tuning "without a cycle" needs the exact method, or a simulation.
//!
//! The IAE assumes a valve that follows the OP: under stiction a load step smaller than the bands may not move the
//! valve at all. PI only.
//!
//! # References
//! S. Skogestad, "Simple analytic rules for model reduction and PID controller tuning", J. Process Control 13 (2003)
//! 291-309 (recalled, not read). K. J. Åström, T. Hägglund, "Advanced PID Control", ISA, 2006. Mohammad and Huang
//! proposed to remove a limit cycle by such tuning (2012; recalled, not read).

use super::{ContinuousLoop, Cycle, FrequencyResponse, Stability, harmonic_balance};
use crate::bands::Bands;
use crate::closed_loop::{ClosedLoop, Controller, Process, Signal};
use crate::error::{Error, Result, non_negative, positive, require};
use crate::parallel::*;
use crate::valve::{Assembly, Model};

/// The default bound on `Ms`, close to [`simc`] with `tc = theta`.
pub const PEAK_SENSITIVITY: f64 = 1.7;

/// Skogestad's PI tuning for the closed-loop time constant `tc`, s; he recommends the dead time.
///
/// # Errors
/// If `tc + theta` is not positive, or the process is not of first order, of second order with real stable
/// poles and no zero, or an integrator.
pub fn simc(process: &Process, tc: f64) -> Result<Controller> {
    let closed = |theta: f64| positive("tc + theta", non_negative("tc", tc)? + theta);
    match Plain::of(process)? {
        Plain::FirstOrder { gain, tau, theta } => {
            let sum = closed(theta)?;
            Controller::pi(tau / (gain * sum), tau.min(4.0 * sum))
        }
        Plain::Integrator { gain, theta } => {
            let sum = closed(theta)?;
            Controller::pi(1.0 / (gain * sum), 4.0 * sum)
        }
    }
}

/// The PI tuning that cancels the pole and gives a closed loop of time constant `lambda`, s.
///
/// # Errors
/// If `lambda + theta` is not positive, or the process has no dominant time constant, see [`simc`].
pub fn lambda(process: &Process, lambda: f64) -> Result<Controller> {
    match Plain::of(process)? {
        Plain::FirstOrder { gain, tau, theta } => {
            let sum = positive("lambda + theta", non_negative("lambda", lambda)? + theta)?;
            Controller::pi(tau / (gain * sum), tau)
        }
        Plain::Integrator { .. } => Err(Error::Inconsistent(
            "an integrator has no time constant for the lambda rule to cancel; use the SIMC rule"
                .to_owned(),
        )),
    }
}

/// A process for the rules.
enum Plain {
    FirstOrder { gain: f64, tau: f64, theta: f64 },
    Integrator { gain: f64, theta: f64 },
}

impl Plain {
    fn of(process: &Process) -> Result<Self> {
        let (num, den) = process.coefficients();
        let theta = process.dead_time();
        let num = crate::numeric::polynomial::trimmed(&num);
        let found = match (num[..].as_ref(), &den[..]) {
            ([k], [a, b]) if *b == 0.0 => Some(Self::Integrator { gain: k / a, theta }),
            ([k], [a, b]) if a / b > 0.0 => {
                Some(Self::FirstOrder { gain: k / b, tau: a / b, theta })
            }
            ([k], [a, b, c]) => {
                let (sum, product) = (b / c, a / c);
                let root = 0.25 * sum * sum - product;
                // Two equal time constants may become complex by rounding.
                let apart = root.max(0.0).sqrt();
                let (long, short) = (0.5 * sum + apart, 0.5 * sum - apart);
                (root >= -1e-12 * sum * sum && short > 0.0).then(|| Self::FirstOrder {
                    gain: k / c,
                    tau: long + 0.5 * short,
                    theta: theta + 0.5 * short,
                })
            }
            _ => None,
        };
        found.ok_or_else(|| {
            Error::Inconsistent(
                "the tuning rules are for processes of first order, of second order with real stable poles and no \
                 zero, and integrators"
                    .to_owned(),
            )
        })
    }
}

/// Integral of the absolute error after a step of the load by 1 percent of span while the valve follows the
/// OP; PV units times s.
///
/// From two simulations, at a fine sample time and half of it, extrapolated to zero.
///
/// # Errors
/// If the loop is not stable, has no integral action (the error stays, and the integral is infinite), or does not
/// settle within 4 million samples.
pub fn load_step_iae(continuous: &ContinuousLoop) -> Result<f64> {
    /// Samples per radian at the highest relevant frequency.
    const FINE: f64 = 50.0;
    let response = FrequencyResponse::of(continuous)?;
    let (kp, ki, kd) = continuous.controller.gains();
    if response.stability() != Stability::Stable || ki == 0.0 {
        return Err(Error::Inconsistent(
            "the IAE of a load step needs a stable loop with integral action".to_owned(),
        ));
    }
    let fast = response.last_crossover(0.5).unwrap_or(response.lowest());
    let slow = response.where_gain_is(1.0).first().copied().unwrap_or(fast);
    let mut step = 1.0 / (FINE * fast);
    let dead_time = continuous.process.dead_time();
    if dead_time > 0.0 {
        step = dead_time / (dead_time / step).ceil();
    }
    let valve = Assembly::new(Model::Ideal.build(Bands::NONE)?);
    let controller =
        Controller::parallel(kp, ki, kd)?.with_filter(continuous.controller.filter_s())?;
    let mut plant = ClosedLoop::new(controller, valve, continuous.process.clone());
    plant.load = vec![Signal::Constant(1.0)];
    let coarse = settled_iae(&mut plant, step, 30.0 / slow)?;
    let fine = settled_iae(&mut plant, 0.5 * step, 30.0 / slow)?;
    Ok(2.0 * fine - coarse)
}

/// The IAE of a simulated loop, for as long as needed from `duration` on.
fn settled_iae(plant: &mut ClosedLoop, sample_time: f64, duration: f64) -> Result<f64> {
    const MOST_SAMPLES: f64 = 4e6;
    const TAIL: f64 = 1e-8;
    plant.sample_time = sample_time;
    let mut samples = duration / sample_time;
    while samples <= MOST_SAMPLES {
        plant.samples = samples.ceil() as usize;
        let run = plant.run()?;
        let area = |pv: &[f64]| pv.iter().map(|pv| pv.abs()).sum::<f64>() * sample_time;
        let (whole, tail) = (area(&run.pv), area(&run.pv[run.pv.len() / 2..]));
        if tail <= TAIL * whole {
            return Ok(whole);
        }
        samples *= 2.0;
    }
    Err(Error::Inconsistent(format!(
        "the loop has not settled after a load step within {MOST_SAMPLES} samples of {sample_time} s"
    )))
}

/// Gains and integral times to try, each with each.
#[derive(Debug, Clone, PartialEq)]
pub struct TuningGrid {
    /// Gains, percent per PV unit.
    pub kc: Vec<f64>,
    /// Integral times, s.
    pub ti: Vec<f64>,
}

impl TuningGrid {
    /// `points` gains and as many integral times, at equal ratios. They range from a `factor`-th to the `factor`-fold
    /// of the values of `controller`.
    ///
    /// # Errors
    /// If the controller lacks proportional or integral action, their signs differ, or `factor` is not above 1.
    pub fn about(controller: &Controller, factor: f64, points: usize) -> Result<Self> {
        require("factor", factor, factor > 1.0, "a finite number above 1")?;
        let (kp, ki, _) = controller.gains();
        if !(kp * ki > 0.0) {
            return Err(Error::Inconsistent(
                "a grid of PI tunings needs an initial controller with proportional and integral action of the \
                 same sign"
                    .to_owned(),
            ));
        }
        let spread = |value: f64| {
            let last = points.saturating_sub(1).max(1) as f64;
            (0..points).map(|k| value * factor.powf(2.0 * k as f64 / last - 1.0)).collect()
        };
        Ok(Self { kc: spread(kp), ti: spread(kp / ki) })
    }
}

/// A judged tuning.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The controller.
    pub controller: Controller,
    /// Its `Ms`.
    pub peak_sensitivity: f64,
}

/// Every PI controller of `grid` with which the loop is stable and `Ms` at most `bound`, gain by gain.
///
/// # Errors
/// If a number of the grid is not allowed, or `bound` is not above 1.
pub fn robust(
    continuous: &ContinuousLoop,
    grid: &TuningGrid,
    bound: f64,
) -> Result<Vec<Candidate>> {
    require("bound on Ms", bound, bound > 1.0, "a finite number above 1")?;
    let mut controllers = vec![];
    for kc in &grid.kc {
        for ti in &grid.ti {
            controllers.push(Controller::pi(*kc, *ti)?);
        }
    }
    let judged: Vec<Result<Option<Candidate>>> = controllers
        .into_par_iter()
        .map(|controller| {
            let response = FrequencyResponse::of(&tuned(continuous, &controller))?;
            if response.stability() != Stability::Stable {
                return Ok(None);
            }
            let (peak_sensitivity, _) = response.peak();
            Ok((peak_sensitivity <= bound).then_some(Candidate { controller, peak_sensitivity }))
        })
        .collect();
    judged.into_iter().filter_map(Result::transpose).collect()
}

/// The loop with a different controller.
fn tuned(continuous: &ContinuousLoop, controller: &Controller) -> ContinuousLoop {
    ContinuousLoop { controller: controller.clone(), ..continuous.clone() }
}

/// The final cycle of a loop, by describing function; `None` without a cycle.
///
/// # Errors
/// As [`harmonic_balance()`].
pub fn by_describing_function(continuous: &ContinuousLoop) -> Result<Option<Cycle>> {
    Ok(harmonic_balance(continuous)?.attracting().cloned())
}

/// The gain, integral time and derivative time of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Tuning {
    /// Gain, percent per PV unit.
    pub kc: f64,
    /// Integral time, s; `None` without integral action.
    pub ti: Option<f64>,
    /// Derivative time, s; 0 without derivative action.
    pub td: f64,
}

impl Tuning {
    /// Gain and times of `controller`.
    pub fn of(controller: &Controller) -> Self {
        let (kp, ki, kd) = controller.gains();
        let td = if kd == 0.0 { 0.0 } else { kd / kp };
        Self { kc: kp, ti: (ki != 0.0).then(|| kp / ki), td }
    }
}

/// The performance of a tuning.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Assessment {
    /// The controller.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub controller: Controller,
    /// Gain and times.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub tuning: Tuning,
    /// `Ms`; infinite if the loop is not stable without friction.
    #[cfg_attr(feature = "serde", serde(rename = "ms", with = "crate::finite::Finite"))]
    pub peak_sensitivity: f64,
    /// [`load_step_iae`]; `None` if the loop has none.
    pub load_iae: Option<f64>,
    /// The cycle with the sticking valve; `None` if the loop has none.
    pub cycle: Option<Cycle>,
}

impl Assessment {
    /// Half of the peak-to-peak value of the PV in the cycle; 0 without one.
    pub fn pv_swing(&self) -> f64 {
        self.cycle.as_ref().map_or(0.0, |cycle| cycle.half_pp.pv)
    }

    fn of(
        continuous: &ContinuousLoop,
        cycle: &impl Fn(&ContinuousLoop) -> Result<Option<Cycle>>,
    ) -> Result<Self> {
        let response = FrequencyResponse::of(continuous)?;
        let stable = response.stability() == Stability::Stable;
        Ok(Self {
            controller: continuous.controller.clone(),
            tuning: Tuning::of(&continuous.controller),
            peak_sensitivity: if stable { response.peak().0 } else { f64::INFINITY },
            load_iae: load_step_iae(continuous).ok(),
            cycle: cycle(continuous)?,
        })
    }
}

/// The tuning with the smallest swing of the PV beside the present one.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Retuning {
    /// The bound on `Ms`.
    pub ms_bound: f64,
    /// The given tuning.
    pub present: Assessment,
    /// The best of those within the bound.
    pub best: Assessment,
    /// Ratio of the PV swing to the PV swing with the present tuning; `None` if the latter is 0.
    pub pv_ratio: Option<f64>,
    /// Cost: the ratio of the IAE of a load step to the IAE with the present tuning; `None` if one of them has no IAE.
    pub iae_ratio: Option<f64>,
    /// Number of tunings within the bound.
    pub robust_tunings: usize,
    /// Number of skipped tunings, whose cycle could not be determined.
    pub unjudged_tunings: usize,
    /// Whether the best tuning lies at an end of the search range. A better tuning may then exist beyond it.
    pub at_edge: bool,
}

/// The PI tuning around `grid` with `Ms` at most `bound` whose cycle has the smallest swing of the PV. If several have
/// no cycle, it is the one with the smallest IAE of a load step.
///
/// `cycle` gives the final cycle of a loop, if any. [`by_describing_function`] does so approximately. After the grid,
/// the neighbourhood of the best is searched on two finer grids. If the best is at an end of the grid, a wider one may
/// contain a better tuning; [`Retuning::at_edge`] reports this.
///
/// # Errors
/// If a number is not allowed, no tuning of the grid is within the bound, or the cycle cannot be determined for the
/// present tuning or for any tuning of the grid.
pub fn least_swing(
    continuous: &ContinuousLoop,
    grid: &TuningGrid,
    bound: f64,
    cycle: impl Fn(&ContinuousLoop) -> Result<Option<Cycle>> + Sync,
) -> Result<Retuning> {
    const FINER: usize = 2;
    const POINTS: usize = 7;
    let whole = grid;
    let mut grid = whole.clone();
    let (mut robust_count, mut unjudged) = (0, 0);
    let mut best: Option<(f64, f64, Controller)> = None;
    for level in 0..=FINER {
        let candidates = robust(continuous, &grid, bound)?;
        robust_count += candidates.len();
        let swings: Vec<Result<(f64, f64)>> = candidates
            .par_iter()
            .map(|candidate| {
                let with = tuned(continuous, &candidate.controller);
                Ok(match cycle(&with)? {
                    Some(cycle) => (cycle.half_pp.pv, 0.0),
                    None => (0.0, load_step_iae(&with)?),
                })
            })
            .collect();
        for (candidate, swing) in candidates.into_iter().zip(swings) {
            let Ok((pv, iae)) = swing else {
                unjudged += 1;
                continue;
            };
            if best.as_ref().is_none_or(|old| (pv, iae) < (old.0, old.1)) {
                best = Some((pv, iae, candidate.controller));
            }
        }
        let Some((_, _, controller)) = &best else {
            return Err(Error::Inconsistent(if robust_count == 0 {
                format!("no tuning of the grid keeps Ms within {bound}")
            } else {
                format!("the cycle of none of {robust_count} robust tunings could be determined")
            }));
        };
        if level < FINER {
            let ratio = |values: &[f64]| match values {
                [first, second, ..] => second / first,
                _ => 1.0,
            };
            let step = ratio(&grid.kc).max(ratio(&grid.ti)).max(1.0 + 1e-6);
            grid = TuningGrid::about(controller, step, POINTS)?;
        }
    }
    let Some((_, _, controller)) = best else {
        return Err(Error::Inconsistent(format!("no tuning of the grid keeps Ms within {bound}")));
    };
    let present = Assessment::of(continuous, &cycle)?;
    let best = Assessment::of(&tuned(continuous, &controller), &cycle)?;
    let swing = present.pv_swing();
    Ok(Retuning {
        ms_bound: bound,
        pv_ratio: (swing > 0.0).then(|| best.pv_swing() / swing),
        iae_ratio: best.load_iae.zip(present.load_iae).map(|(best, present)| best / present),
        robust_tunings: robust_count,
        unjudged_tunings: unjudged,
        at_edge: at_edge(&controller, whole),
        present,
        best,
    })
}

/// Whether a controller's gain or integral time lies at or beyond an end of `grid`.
fn at_edge(controller: &Controller, grid: &TuningGrid) -> bool {
    let (kp, ki, _) = controller.gains();
    let outside = |value: f64, values: &[f64]| {
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v.abs()), h.max(v.abs())));
        !(value.abs() > low * (1.0 + 1e-9) && value.abs() < high * (1.0 - 1e-9))
    };
    outside(kp, &grid.kc) || outside(kp / ki, &grid.ti)
}
