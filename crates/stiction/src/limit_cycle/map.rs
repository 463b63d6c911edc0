//! The limit cycle over two parameters of a loop, where it ends, and what it depends on most.
//!
//! # What it computes
//! [`Map::of`]: the cycle in which the loop ends, at every point of a grid of two parameters. [`sensitivities`]:
//! by how many percent period and amplitudes change with a percent of each parameter.
//!
//! # Assumptions
//! Those of [exact](super::exact) cycles, or of [harmonic balance](super::harmonic_balance), whichever is asked for.
//!
//! # Equations
//! The sensitivity of a quantity `q` of the cycle to a parameter `p` is `d ln q / d ln p`, by central differences
//! of exact cycles at `p (1 ± 1e-4)`; their error is of the order 1e-7.
//!
//! # Limits
//! A map shows one cycle a point: the one in which the loop ends when it starts near its equilibrium. The
//! boundary of its existence is known to the spacing of the grid.

use super::{ContinuousLoop, Cycle, Method, Swing, attractor};
use crate::bands::Bands;
use crate::closed_loop::Process;
use crate::error::{Error, Result, finite, positive};
use rayon::prelude::*;

/// A parameter of a loop that a map can vary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// Stick band plus dead band, percent; J stays.
    S,
    /// Slip jump, percent; S stays.
    J,
    /// J over S; S stays.
    JOverS,
    /// Gain of the controller; its times stay.
    Kc,
    /// Integral time, s; gain and derivative time stay.
    Ti,
    /// Gain of the process, PV units per percent.
    ProcessGain,
    /// Dead time of the process, s.
    DeadTime,
    /// Dead time over the sum of the lags of the process; the lags stay.
    DeadTimeOverLag,
}

impl Parameter {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::S,
        Self::J,
        Self::JOverS,
        Self::Kc,
        Self::Ti,
        Self::ProcessGain,
        Self::DeadTime,
        Self::DeadTimeOverLag,
    ];

    /// Its name, as it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::S => "S",
            Self::J => "J",
            Self::JOverS => "J/S",
            Self::Kc => "Kc",
            Self::Ti => "Ti",
            Self::ProcessGain => "Kp",
            Self::DeadTime => "theta",
            Self::DeadTimeOverLag => "theta/tau",
        }
    }

    /// Its unit; empty of a number without one.
    pub fn unit(self) -> &'static str {
        match self {
            Self::S | Self::J => "%",
            Self::JOverS | Self::DeadTimeOverLag => "",
            Self::Kc => "%/PV unit",
            Self::Ti | Self::DeadTime => "s",
            Self::ProcessGain => "PV units/%",
        }
    }

    /// The parameter of that name, whatever its case.
    ///
    /// # Errors
    /// If there is none.
    pub fn by_name(name: &str) -> Result<Self> {
        let all = Self::ALL.into_iter();
        all.clone().find(|each| each.name().eq_ignore_ascii_case(name.trim())).ok_or_else(|| {
            Error::UnknownName {
                family: "parameter of a loop",
                name: name.to_owned(),
                known: all.map(Self::name).collect::<Vec<_>>().join(", "),
            }
        })
    }

    /// Its value in a loop; `None` where the loop has no such thing.
    pub fn of(self, l: &ContinuousLoop) -> Option<f64> {
        let (kp, ki, _) = l.controller.gains();
        let value = match self {
            Self::S => l.bands.s(),
            Self::J => l.bands.j(),
            Self::JOverS => l.bands.j() / l.bands.s(),
            Self::Kc => kp,
            Self::Ti => kp / ki,
            Self::ProcessGain => return process_gain(&l.process),
            Self::DeadTime => l.process.dead_time(),
            Self::DeadTimeOverLag => l.process.dead_time() / lag(&l.process)?,
        };
        value.is_finite().then_some(value)
    }

    /// The loop with another value of it.
    ///
    /// # Errors
    /// If the loop cannot have that value.
    pub fn set(self, l: &ContinuousLoop, value: f64) -> Result<ContinuousLoop> {
        let mut l = l.clone();
        let none = |what: &str| Error::Inconsistent(format!("the loop has no {what} to change"));
        let (kp, ki, kd) = l.controller.gains();
        let (num, den) = l.process.coefficients();
        match self {
            Self::S => l.bands = Bands::from_s_j(value, l.bands.j())?,
            Self::J => l.bands = Bands::from_s_j(l.bands.s(), value)?,
            Self::JOverS => l.bands = Bands::from_s_j(l.bands.s(), value * l.bands.s())?,
            Self::Kc => {
                let factor = finite("Kc", value)? / kp;
                if !factor.is_finite() {
                    return Err(none("proportional gain"));
                }
                l.controller = l.controller.with_gains(value, ki * factor, kd * factor)?;
            }
            Self::Ti => {
                l.controller = l.controller.with_gains(kp, kp / positive("Ti", value)?, kd)?;
            }
            Self::ProcessGain => {
                let factor = finite("process gain", value)?
                    / process_gain(&l.process).ok_or_else(|| none("process gain"))?;
                let num: Vec<f64> = num.iter().map(|c| c * factor).collect();
                l.process = Process::transfer_function(&num, &den, l.process.dead_time())?;
            }
            Self::DeadTime => l.process = Process::transfer_function(&num, &den, value)?,
            Self::DeadTimeOverLag => {
                let lag = lag(&l.process).ok_or_else(|| none("lag"))?;
                l.process = Process::transfer_function(&num, &den, value * lag)?;
            }
        }
        Ok(l)
    }
}

/// Gain at rest, or of the slope where a process integrates.
fn process_gain(process: &Process) -> Option<f64> {
    let (num, den) = process.coefficients();
    let lowest = den.iter().rev().find(|c| **c != 0.0)?;
    let gain = num.last()? / lowest;
    (gain.is_finite() && gain != 0.0).then_some(gain)
}

/// The sum of the lags: `(a1 - b1 / b0 a0) / a0` would count a lead too, which is no lag here.
fn lag(process: &Process) -> Option<f64> {
    let (_, den) = process.coefficients();
    let [.., a1, a0] = den[..] else { return None };
    let lag = a1 / a0;
    (lag.is_finite() && lag > 0.0).then_some(lag)
}

/// Values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// The parameter.
    pub parameter: Parameter,
    /// Its values.
    pub values: Vec<f64>,
}

impl Axis {
    /// `points` values at equal distances.
    ///
    /// # Errors
    /// If an end is not finite, or there are fewer than two points.
    pub fn even(parameter: Parameter, from: f64, to: f64, points: usize) -> Result<Self> {
        finite("first value of an axis", from)?;
        finite("last value of an axis", to)?;
        if points < 2 {
            return Err(Error::Parameter {
                name: "points of an axis",
                value: points as f64,
                allowed: "at least 2".to_owned(),
            });
        }
        let last = (points - 1) as f64;
        let at = |k: usize| from + (to - from) * (k as f64 / last);
        Ok(Self { parameter, values: (0..points).map(at).collect() })
    }
}

/// What a point of a map has.
#[derive(Debug, Clone, PartialEq)]
pub enum Point {
    /// The loop ends in a cycle.
    Cycle {
        /// Period, s.
        period_s: f64,
        /// Half of the peak-to-peak values.
        half_pp: Swing,
        /// How often the stem begins to move in a period.
        slips: usize,
    },
    /// It has none.
    NoCycle {
        /// Why.
        reason: String,
    },
    /// It is not known, or there is no such loop.
    Unknown {
        /// Why.
        reason: String,
    },
}

impl Point {
    /// The cycle in which a loop ends, found by this method.
    pub fn of(l: &ContinuousLoop, method: Method) -> Self {
        match attractor(l, method) {
            Ok(Ok(cycle)) => {
                Self::Cycle { period_s: cycle.period_s, half_pp: cycle.half_pp, slips: cycle.slips }
            }
            Ok(Err(reason)) => Self::NoCycle { reason },
            Err(error) => Self::Unknown { reason: error.to_string() },
        }
    }

    /// Period, s, and half peak-to-peak values, if the loop cycles.
    pub fn cycle(&self) -> Option<(f64, Swing)> {
        match self {
            Self::Cycle { period_s, half_pp, .. } => Some((*period_s, *half_pp)),
            _ => None,
        }
    }
}

/// The cycles in which a loop ends, over two of its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The parameter that changes along a row.
    pub x: Axis,
    /// The parameter that changes from row to row.
    pub y: Axis,
    /// How the cycles were found.
    pub method: Method,
    /// Row by row: that of the first value of `y` first.
    pub points: Vec<Point>,
}

impl Map {
    /// Computes a map; its points in parallel, the same on any number of threads.
    ///
    /// # Errors
    /// If both axes vary the same parameter, or one that the loop does not have.
    pub fn of(l: &ContinuousLoop, x: Axis, y: Axis, method: Method) -> Result<Self> {
        if x.parameter == y.parameter {
            return Err(Error::Inconsistent(format!(
                "both axes of the map are {}; a map needs two parameters",
                x.parameter.name()
            )));
        }
        for axis in [&x, &y] {
            let Some(first) = axis.values.first() else {
                return Err(Error::Inconsistent(format!(
                    "the axis {} has no values",
                    axis.parameter.name()
                )));
            };
            // A value may be out of range, but there must be something to vary.
            if axis.parameter.of(l).is_none() {
                axis.parameter.set(l, *first)?;
            }
        }
        let across = x.values.len();
        let point = |k: usize| {
            let with = y
                .parameter
                .set(l, y.values[k / across])
                .and_then(|l| x.parameter.set(&l, x.values[k % across]));
            match with {
                Ok(l) => Point::of(&l, method),
                Err(error) => Point::Unknown { reason: error.to_string() },
            }
        };
        let points = (0..across * y.values.len()).into_par_iter().map(point).collect();
        Ok(Self { x, y, method, points })
    }

    /// The point of the `column`-th value of `x` and the `row`-th of `y`.
    pub fn at(&self, column: usize, row: usize) -> Option<&Point> {
        let across = self.x.values.len();
        (column < across).then(|| self.points.get(row * across + column)).flatten()
    }

    /// Where cycling ends: for every row, the values of `x` halfway between two neighbours of which one has a
    /// cycle and the other has none, with the value of `y`.
    pub fn boundary(&self) -> Vec<(f64, f64)> {
        let mut boundary = vec![];
        for (row, y) in self.points.chunks_exact(self.x.values.len()).zip(&self.y.values) {
            for (pair, x) in row.windows(2).zip(self.x.values.windows(2)) {
                if let (Point::Cycle { .. }, Point::NoCycle { .. })
                | (Point::NoCycle { .. }, Point::Cycle { .. }) = (&pair[0], &pair[1])
                {
                    boundary.push((0.5 * (x[0] + x[1]), *y));
                }
            }
        }
        boundary
    }
}

/// How a cycle answers to a parameter: percent per percent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// The parameter.
    pub parameter: Parameter,
    /// Its value.
    pub value: f64,
    /// Of the period.
    pub period: f64,
    /// Of the half peak-to-peak values.
    pub half_pp: Swing,
}

/// The sensitivities of the exact cycle of a loop to every parameter that it has and that is not 0; those at
/// which the cycle ends or cannot be found are left out.
///
/// # Errors
/// If a loop beside this one cannot be computed.
pub fn sensitivities(l: &ContinuousLoop) -> Result<Vec<Sensitivity>> {
    /// Relative step to either side.
    const STEP: f64 = 1e-4;
    let mut found = vec![];
    for parameter in Parameter::ALL {
        let Some(value) = parameter.of(l).filter(|value| *value != 0.0) else { continue };
        let beside = |factor: f64| -> Option<Cycle> {
            let l = parameter.set(l, value * factor).ok()?;
            attractor(&l, Method::Exact).ok()?.ok()
        };
        let (Some(low), Some(high)) = (beside(1.0 - STEP), beside(1.0 + STEP)) else { continue };
        let slope = |quantity: fn(&Cycle) -> f64| {
            (quantity(&high) / quantity(&low)).ln() / ((1.0 + STEP) / (1.0 - STEP)).ln()
        };
        found.push(Sensitivity {
            parameter,
            value,
            period: slope(|c| c.period_s),
            half_pp: Swing {
                op: slope(|c| c.half_pp.op),
                vp: slope(|c| c.half_pp.vp),
                pv: slope(|c| c.half_pp.pv),
            },
        });
    }
    Ok(found)
}
