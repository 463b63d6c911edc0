//! The limit cycle over two parameters of a loop, its boundary, and its sensitivities.
//!
//! # What it computes
//! * [`Map::of`]: the final cycle of the loop at every point of a grid of two parameters.
//! * [`sensitivities`]: the change in percent of period and amplitudes with a percent of each parameter.
//!
//! # Assumptions
//! As for [exact](super::exact) cycles, or for [harmonic balance](super::harmonic_balance()), as requested.
//!
//! # Equations
//! The sensitivity of a quantity `q` of the cycle to a parameter `p` is `d ln q / d ln p`, by central differences of
//! exact cycles at `p (1 ± 1e-4)`; their error is of the order 1e-7. The loop has no units other than the units of the
//! OP, the PV and the time, so sums of sensitivities are known. To S and J together the amplitudes have 1 and the
//! period 0. To `Ti`, the lags and the dead time together, under PI, the period has 1 and the amplitudes 0.
//!
//! # Limits
//! * A map shows one cycle a point: the final one of a loop that starts near its equilibrium.
//! * The boundary is known to the spacing of the grid.
//! * A sensitivity is meaningless if the cycle changes its kind within a ten-thousandth of the parameter.

use super::{ContinuousLoop, Cycle, Method, State, Swing, attractor};
use crate::bands::Bands;
use crate::closed_loop::Process;
use crate::error::{Error, Result, finite, positive};
use crate::parallel::*;

crate::named! {
    /// A parameter of a loop that a map can vary.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Parameter {
        /// Stick band plus dead band, percent; J stays constant.
        S = "S",
        /// Slip jump, percent; S stays constant.
        J = "J",
        /// J over S; S stays constant.
        JOverS = "J/S",
        /// Gain of the controller; its times stay constant.
        Kc = "Kc",
        /// Integral time, s; gain and derivative time stay constant.
        Ti = "Ti",
        /// Gain of the process, PV units per percent.
        ProcessGain = "Kp",
        /// Dead time of the process, s.
        DeadTime = "theta",
        /// Sum of the lags of the process, s; their ratios, the leads and the dead time stay constant.
        Lag = "tau",
        /// Dead time over the sum of the lags of the process; the lags stay constant.
        DeadTimeOverLag = "theta/tau",
    }
}

crate::written_by_name!(Parameter);

impl Parameter {
    /// Unit; empty for a number without one.
    pub fn unit(self) -> &'static str {
        match self {
            Self::S | Self::J => "%",
            Self::JOverS | Self::DeadTimeOverLag => "",
            Self::Kc => "%/PV unit",
            Self::Ti | Self::DeadTime | Self::Lag => "s",
            Self::ProcessGain => "PV units/%",
        }
    }

    /// The parameter of that name, whatever its case.
    ///
    /// # Errors
    /// If no parameter has this name.
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

    /// Value in a loop; `None` if the loop does not have it.
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
            Self::Lag => return lag(&l.process),
            Self::DeadTimeOverLag => l.process.dead_time() / lag(&l.process)?,
        };
        value.is_finite().then_some(value)
    }

    /// The loop with this value of the parameter.
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
            Self::Lag => {
                let lag = lag(&l.process).ok_or_else(|| none("lag"))?;
                let factor = positive("sum of lags", value)? / lag;
                // Each power of s adds the factor once more.
                let mut power = 1.0;
                let mut den: Vec<f64> = den.into_iter().rev().collect();
                for c in &mut den {
                    *c *= power;
                    power *= factor;
                }
                den.reverse();
                l.process = Process::transfer_function(&num, &den, l.process.dead_time())?;
            }
            Self::DeadTimeOverLag => {
                let lag = lag(&l.process).ok_or_else(|| none("lag"))?;
                l.process = Process::transfer_function(&num, &den, value * lag)?;
            }
        }
        Ok(l)
    }

    /// The reference of a ratio; the parameter itself if the parameter is no ratio.
    fn base(self) -> Self {
        match self {
            Self::JOverS => Self::J,
            Self::DeadTimeOverLag => Self::DeadTime,
            other => other,
        }
    }

    /// Name and unit, such as `J (%)`.
    pub fn label(self) -> String {
        match self.unit() {
            "" => self.name().to_owned(),
            unit => format!("{} ({unit})", self.name()),
        }
    }
}

/// Static gain, or slope of an integrating process.
fn process_gain(process: &Process) -> Option<f64> {
    let (num, den) = process.coefficients();
    let lowest = den.iter().rev().find(|c| **c != 0.0)?;
    let gain = num.last()? / lowest;
    (gain.is_finite() && gain != 0.0).then_some(gain)
}

/// The sum of the lags; `None` for an integrating process.
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
    /// Values.
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

    /// Halfway between neighbours, and equally far beyond the first and the last.
    fn sides(&self) -> Vec<f64> {
        let v = &self.values;
        let Some(last) = v.len().checked_sub(1) else { return vec![] };
        let half = |k: usize| v.get(k + 1).zip(v.get(k)).map_or(0.5, |(b, a)| 0.5 * (b - a));
        (0..=v.len())
            .map(|k| match k {
                0 => v[0] - half(0),
                k if k > last => v[last] + half(last.saturating_sub(1)),
                k => v[k] - half(k - 1),
            })
            .collect()
    }
}

/// A point of a map.
#[derive(Debug, Clone, PartialEq)]
pub enum Point {
    /// The loop ends in a cycle.
    Cycle {
        /// Period, s.
        period_s: f64,
        /// Half of the peak-to-peak values.
        half_pp: Swing,
        /// Slips of the stem in a period.
        slips: usize,
    },
    /// It has none.
    NoCycle {
        /// The reason.
        reason: String,
    },
    /// It is not known, or the loop is invalid.
    Unknown {
        /// The reason.
        reason: String,
    },
}

impl Point {
    /// The final cycle of a loop, found by this method.
    pub fn of(l: &ContinuousLoop, method: Method) -> Self {
        match attractor(l, method) {
            Ok(Ok(cycle)) => {
                Self::Cycle { period_s: cycle.period_s, half_pp: cycle.half_pp, slips: cycle.slips }
            }
            Ok(Err(reason)) => Self::NoCycle { reason },
            Err(error) => Self::Unknown { reason: error.to_string() },
        }
    }

    /// Whether there is a cycle.
    pub fn state(&self) -> State {
        match self {
            Self::Cycle { .. } => State::Cycle,
            Self::NoCycle { .. } => State::NoCycle,
            Self::Unknown { .. } => State::Unknown,
        }
    }

    /// Why no cycle exists, or why this is unknown; empty for a cycle.
    pub fn reason(&self) -> &str {
        match self {
            Self::Cycle { .. } => "",
            Self::NoCycle { reason } | Self::Unknown { reason } => reason,
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

/// The final cycles of a loop, over two of its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The parameter that changes along a row.
    pub x: Axis,
    /// The parameter that changes from row to row.
    pub y: Axis,
    /// The method of the cycles.
    pub method: Method,
    /// Row by row, beginning with the first value of `y`.
    pub points: Vec<Point>,
}

/// A number for each point of a [`Map`] and signal of the loop.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Swings {
    /// Of the OP, percent of span.
    pub op: Vec<Option<f64>>,
    /// Of the VP, percent of span.
    pub vp: Vec<Option<f64>>,
    /// Of the PV, in its units.
    pub pv: Vec<Option<f64>>,
}

/// A [`Map`] in a document, column by column.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
struct MapDocument {
    /// The parameter that changes along a row.
    x: AxisDocument,
    /// The parameter that changes from row to row.
    y: AxisDocument,
    /// The method of the cycles.
    method: Method,
    /// Order of the points in the lists below.
    order: &'static str,
    /// Whether there is a cycle.
    state: Vec<State>,
    /// Periods, s.
    period_s: Vec<Option<f64>>,
    /// Half of the peak-to-peak values.
    half_pp: Swings,
    /// The boundary of cycling: sides of points, from corner to corner.
    boundary: Vec<[[f64; 2]; 2]>,
}

#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
struct AxisDocument {
    parameter: Parameter,
    unit: &'static str,
    values: Vec<f64>,
}

#[cfg(feature = "serde")]
crate::written_as!(Map, MapDocument);

#[cfg(feature = "serde")]
impl From<&Map> for MapDocument {
    fn from(map: &Map) -> Self {
        let axis = |axis: &Axis| AxisDocument {
            parameter: axis.parameter,
            unit: axis.parameter.unit(),
            values: axis.values.clone(),
        };
        Self {
            x: axis(&map.x),
            y: axis(&map.y),
            method: map.method,
            order: "row by row, beginning with the first y",
            state: map.points.iter().map(Point::state).collect(),
            period_s: map.periods(),
            half_pp: map.swings(),
            boundary: map.boundary().iter().map(|side| side.map(|(x, y)| [x, y])).collect(),
        }
    }
}

impl Map {
    /// Computes a map. Its points are computed in parallel, and are the same on any number of threads.
    ///
    /// # Errors
    /// If both axes vary the same parameter, also as a ratio, or an axis varies a parameter that the loop does not
    /// have.
    pub fn of(l: &ContinuousLoop, x: Axis, y: Axis, method: Method) -> Result<Self> {
        Self::of_with_progress(l, x, y, method, || true)
    }

    /// [`Map::of`], watched: `goes_on` is asked before every point, and ends the computation by `false`.
    ///
    /// # Errors
    /// As [`Map::of`]; and [`Error::Cancelled`].
    pub fn of_with_progress(
        l: &ContinuousLoop,
        x: Axis,
        y: Axis,
        method: Method,
        goes_on: impl Fn() -> bool + Sync,
    ) -> Result<Self> {
        if x.parameter.base() == y.parameter.base() {
            return Err(Error::Inconsistent(format!(
                "the axes of the map are {} and {}, which vary the same quantity; a map needs two parameters",
                x.parameter.name(),
                y.parameter.name()
            )));
        }
        for axis in [&x, &y] {
            let Some(first) = axis.values.first() else {
                return Err(Error::Inconsistent(format!(
                    "the axis {} has no values",
                    axis.parameter.name()
                )));
            };
            // A value may be out of range, but the parameter must exist.
            if axis.parameter.of(l).is_none() {
                axis.parameter.set(l, *first)?;
            }
        }
        let across = x.values.len();
        // A ratio is set last, relative to its reference.
        let place = |axis: &Axis| Parameter::ALL.iter().position(|p| *p == axis.parameter);
        let x_first = place(&x) < place(&y);
        let point = |k: usize| {
            if !goes_on() {
                return Err(Error::Cancelled);
            }
            let (x, y) = ((&x, x.values[k % across]), (&y, y.values[k / across]));
            let (first, last) = if x_first { (x, y) } else { (y, x) };
            let with =
                first.0.parameter.set(l, first.1).and_then(|l| last.0.parameter.set(&l, last.1));
            Ok(match with {
                Ok(l) => Point::of(&l, method),
                Err(error) => Point::Unknown { reason: error.to_string() },
            })
        };
        let points =
            (0..across * y.values.len()).into_par_iter().map(point).collect::<Result<_>>()?;
        Ok(Self { x, y, method, points })
    }

    /// The point of the `column`-th value of `x` and the `row`-th of `y`.
    pub fn at(&self, column: usize, row: usize) -> Option<&Point> {
        let across = self.x.values.len();
        (column < across).then(|| self.points.get(row * across + column)).flatten()
    }

    /// The period at each point, s; `None` without a cycle.
    pub fn periods(&self) -> Vec<Option<f64>> {
        self.points.iter().map(|point| Some(point.cycle()?.0)).collect()
    }

    /// Half of the peak-to-peak values at each point; `None` without a cycle.
    pub fn swings(&self) -> Swings {
        let column = |of: fn(Swing) -> f64| {
            self.points.iter().map(|point| Some(of(point.cycle()?.1))).collect()
        };
        Swings { op: column(|s| s.op), vp: column(|s| s.vp), pv: column(|s| s.pv) }
    }

    /// The boundary of cycling: the sides between two adjacent points, one with a cycle and one known to have no cycle.
    /// A point extends halfway to its neighbours. Each side goes from one corner, `(x, y)`, to the other.
    pub fn boundary(&self) -> Vec<[(f64, f64); 2]> {
        let ends = |a: Option<&Point>, b: Option<&Point>| {
            matches!(
                (a, b),
                (Some(Point::Cycle { .. }), Some(Point::NoCycle { .. }))
                    | (Some(Point::NoCycle { .. }), Some(Point::Cycle { .. }))
            )
        };
        let (x, y) = (self.x.sides(), self.y.sides());
        let mut boundary = vec![];
        for row in 0..self.y.values.len() {
            for column in 0..self.x.values.len() {
                let here = self.at(column, row);
                let (right, above) = (x[column + 1], y[row + 1]);
                if ends(here, self.at(column + 1, row)) {
                    boundary.push([(right, y[row]), (right, above)]);
                }
                if ends(here, self.at(column, row + 1)) {
                    boundary.push([(x[column], above), (right, above)]);
                }
            }
        }
        boundary
    }
}

/// Sensitivity of a cycle to a parameter: percent per percent.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Sensitivity {
    /// The parameter.
    pub parameter: Parameter,
    /// Unit; empty for a number without one.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// Sensitivity of the period.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub period: f64,
    /// Sensitivity of the half peak-to-peak values.
    pub half_pp: Swing,
}

/// The sensitivities of the exact cycle of a loop to every parameter that it has and that is not 0. Ratios, which add
/// nothing, and parameters at which the cycle ends or cannot be found are left out. The result is empty without a
/// cycle.
///
/// # Errors
/// If the loop cannot be computed exactly.
pub fn sensitivities(l: &ContinuousLoop) -> Result<Vec<Sensitivity>> {
    /// Relative step to either side.
    const STEP: f64 = 1e-4;
    let mut found = vec![];
    if attractor(l, Method::Exact)?.is_err() {
        return Ok(found);
    }
    for parameter in Parameter::ALL.into_iter().filter(|each| each.base() == *each) {
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
            unit: parameter.unit(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::Controller;
    use crate::limit_cycle::CancelledLoop;
    use crate::valve::Model;

    fn looped(controller: (f64, f64), process: Process, s: f64, j: f64) -> ContinuousLoop {
        let controller = Controller::pi(controller.0, controller.1).unwrap();
        ContinuousLoop::new(controller, process, Model::TwoPhase, Bands::from_s_j(s, j).unwrap())
    }

    fn paper() -> ContinuousLoop {
        looped((1.1, 2.5), Process::first_order(1.5, 5.93, 1.07).unwrap(), 5.0, 3.0)
    }

    fn axis(parameter: Parameter, from: f64, to: f64, points: usize) -> Axis {
        Axis::even(parameter, from, to, points).unwrap()
    }

    fn of(l: &ContinuousLoop, parameter: Parameter) -> Sensitivity {
        let all = sensitivities(l).unwrap();
        all.into_iter().find(|each| each.parameter == parameter).unwrap()
    }

    #[test]
    fn a_parameter_that_was_set_is_there_and_nothing_else_has_changed() {
        let second = Process::second_order(2.0, 8.0, 4.0, 3.0).unwrap();
        for l in [paper(), looped((0.5, 9.0), second, 4.0, 1.0)] {
            for parameter in Parameter::ALL {
                let before = parameter.of(&l).unwrap();
                let with = parameter.set(&l, 1.25 * before).unwrap();
                assert!((parameter.of(&with).unwrap() / before - 1.25).abs() < 1e-12);
                for other in Parameter::ALL {
                    let ratio = other.of(&with).unwrap() / other.of(&l).unwrap();
                    let expected = match (parameter, other) {
                        _ if other.base() == parameter.base() => 1.25,
                        (Parameter::S, Parameter::JOverS)
                        | (Parameter::Lag, Parameter::DeadTimeOverLag) => 0.8,
                        _ => 1.0,
                    };
                    assert!((ratio - expected).abs() < 1e-12, "{parameter:?}, {other:?}: {ratio}");
                }
                assert_eq!(Parameter::by_name(parameter.name()).unwrap(), parameter);
            }
        }
        let message = Parameter::by_name("K").unwrap_err().to_string();
        assert!(message.contains("theta/tau"), "{message}");
    }

    #[test]
    fn what_a_loop_lacks_is_not_there() {
        let integrator = looped((0.4, 2.0), Process::integrator(1.0, 0.0).unwrap(), 5.0, 2.0);
        assert_eq!(Parameter::Lag.of(&integrator), None);
        assert!(Parameter::Lag.set(&integrator, 2.0).is_err());
        assert_eq!(Parameter::ProcessGain.of(&integrator), Some(1.0));
        let p = ContinuousLoop { controller: Controller::p(2.0).unwrap(), ..paper() };
        assert_eq!(Parameter::Ti.of(&p), None);
        assert_eq!(Parameter::Ti.of(&Parameter::Ti.set(&p, 4.0).unwrap()), Some(4.0));
        assert!(Parameter::Ti.set(&p, 0.0).is_err() && Parameter::S.set(&p, f64::NAN).is_err());
    }

    #[test]
    fn sensitivities_are_the_slopes_of_the_closed_form() {
        let process = Process::first_order(3.0, 10.0, 10.0).unwrap();
        let l = looped((0.2, 10.0), process, 5.0, 2.0);
        let closed = |s: f64, j: f64, kc: f64, kp: f64| {
            let known = CancelledLoop {
                process_gain: kp,
                controller_gain: kc,
                time_constant_s: 10.0,
                dead_time_s: 10.0,
            };
            known.cycle(Bands::from_s_j(s, j).unwrap()).unwrap()
        };
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        };
        // By hand, with q = 0.6: a = J / (2 - q), T = 4 theta + 2 (S / a - q (1 - q) - q^2 / 2) / kappa.
        let (s, j, q, kappa) = (5.0, 2.0, 0.6, 0.06);
        let (a, cycle) = (j / (2.0 - q), closed(s, j, 0.2, 3.0));
        let by_s = of(&l, Parameter::S);
        near(by_s.period, 2.0 * s / (kappa * a * cycle.period_s));
        near(by_s.half_pp.vp, 0.0);
        near(by_s.half_pp.op, 0.5 * s / cycle.op);
        let by_j = of(&l, Parameter::J);
        near(by_j.period, -2.0 * s / (kappa * a * cycle.period_s));
        near(by_j.half_pp.vp, 1.0);
        near(by_j.half_pp.op, (a - 0.5 * j) / cycle.op);
        // Kc leaves the closed form valid, as Ti stays.
        let slope = |of: fn(&crate::limit_cycle::CancelledCycle) -> f64| {
            let (low, high) = (closed(s, j, 0.2 * 0.9999, 3.0), closed(s, j, 0.2 * 1.0001, 3.0));
            (of(&high) / of(&low)).ln() / (1.0001_f64 / 0.9999).ln()
        };
        let by_kc = of(&l, Parameter::Kc);
        near(by_kc.period, slope(|c| c.period_s));
        near(by_kc.half_pp.op, slope(|c| c.op));
        near(by_kc.half_pp.vp, slope(|c| c.vp));
        near(by_kc.half_pp.vp, q / (2.0 - q));
    }

    #[test]
    fn sensitivities_know_the_units_of_the_loop() {
        let second = Process::second_order(2.0, 8.0, 4.0, 3.0).unwrap();
        for l in [paper(), looped((0.5, 9.0), second, 4.0, 3.0)] {
            let by = |parameter| of(&l, parameter);
            let zero = |value: f64| assert!(value.abs() < 2e-6, "{value}");
            let (s, j) = (by(Parameter::S), by(Parameter::J));
            zero(s.period + j.period);
            zero(s.half_pp.op + j.half_pp.op - 1.0);
            zero(s.half_pp.vp + j.half_pp.vp - 1.0);
            zero(s.half_pp.pv + j.half_pp.pv - 1.0);
            let times = [Parameter::Ti, Parameter::DeadTime, Parameter::Lag].map(by);
            zero(times.iter().map(|t| t.period).sum::<f64>() - 1.0);
            zero(times.iter().map(|t| t.half_pp.op).sum());
            zero(times.iter().map(|t| t.half_pp.pv).sum());
            // OP and VP know the product of the gains alone.
            let (kc, kp) = (by(Parameter::Kc), by(Parameter::ProcessGain));
            zero(kc.period - kp.period);
            zero(kc.half_pp.op - kp.half_pp.op);
            zero(kp.half_pp.pv - kc.half_pp.pv - 1.0);
        }
    }

    #[test]
    fn a_loop_that_comes_to_rest_has_no_sensitivities() {
        let quiet = ContinuousLoop { bands: Bands::from_s_j(5.0, 0.0).unwrap(), ..paper() };
        assert_eq!(sensitivities(&quiet).unwrap(), []);
        let chen = ContinuousLoop { model: Model::Chen, ..paper() };
        assert!(sensitivities(&chen).is_err());
    }

    #[test]
    fn a_map_is_the_cycles_of_its_loops() {
        let (s, ratio) = (axis(Parameter::S, 2.0, 8.0, 4), axis(Parameter::JOverS, 0.2, 1.0, 3));
        let map = Map::of(&paper(), s.clone(), ratio.clone(), Method::Exact).unwrap();
        let turned = Map::of(&paper(), ratio, s, Method::Exact).unwrap();
        for row in 0..3 {
            let (period, first) = map.at(0, row).unwrap().cycle().unwrap();
            for column in 0..4 {
                let point = map.at(column, row).unwrap();
                assert_eq!(Some(point), turned.at(row, column));
                let (s, j) = (map.x.values[column], map.x.values[column] * map.y.values[row]);
                let l = ContinuousLoop { bands: Bands::from_s_j(s, j).unwrap(), ..paper() };
                assert_eq!(*point, Point::of(&l, Method::Exact));
                // With J / S the period stays, and the PV grows with S.
                let (t, half_pp) = point.cycle().unwrap();
                assert!((t / period - 1.0).abs() < 1e-9);
                assert!((half_pp.pv / s / (first.pv / 2.0) - 1.0).abs() < 1e-9);
            }
        }
        assert_eq!((map.at(4, 0), map.at(0, 3)), (None, None));
    }

    #[test]
    fn the_boundary_is_between_cycles_and_none() {
        // Without a slip jump this loop comes to rest.
        let (s, j) = (axis(Parameter::S, 1.0, 5.0, 5), axis(Parameter::J, 0.0, 4.0, 5));
        let map = Map::of(&paper(), s.clone(), j.clone(), Method::Exact).unwrap();
        let side = |s: &f64| [(s - 0.5, 0.5), (s + 0.5, 0.5)];
        let expected: Vec<_> = map.x.values.iter().map(side).collect();
        assert_eq!(map.boundary(), expected);
        let turned = Map::of(&paper(), j, s, Method::Exact).unwrap();
        let mirrored: Vec<_> = expected.iter().map(|side| side.map(|(s, j)| (j, s))).collect();
        assert_eq!(turned.boundary(), mirrored);
        assert!(matches!(map.at(0, 0), Some(Point::NoCycle { reason }) if !reason.is_empty()));
    }

    #[test]
    fn what_is_not_known_is_reported() {
        let kc = axis(Parameter::Kc, -1.0, 1.0, 3);
        let ti = axis(Parameter::Ti, -1.0, 1.0, 3);
        let map = Map::of(&paper(), kc, ti, Method::Exact).unwrap();
        for (column, row) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 2)] {
            let point = map.at(column, row).unwrap();
            assert!(
                matches!(point, Point::Unknown { reason } if !reason.is_empty())
                    || matches!(point, Point::NoCycle { .. }) && column == 0,
                "{column}, {row}: {point:?}"
            );
        }
        let chen = ContinuousLoop { model: Model::Chen, ..paper() };
        let (s, j) = (axis(Parameter::S, 1.0, 5.0, 2), axis(Parameter::J, 0.0, 4.0, 2));
        let map = Map::of(&chen, s, j, Method::Exact).unwrap();
        assert!(map.points.iter().all(|point| matches!(point, Point::Unknown { .. })));
        assert!(map.boundary().is_empty());
    }

    #[test]
    fn maps_are_the_same_on_any_number_of_threads() {
        let of = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (kc, ti) = (axis(Parameter::Kc, 0.2, 6.0, 9), axis(Parameter::Ti, 0.5, 20.0, 7));
            pool.install(|| Map::of(&paper(), kc, ti, Method::Exact).unwrap())
        };
        let one = of(1);
        assert_eq!(one, of(2));
        assert_eq!(one, of(3));
        assert!(one.points.iter().any(|point| point.cycle().is_some()));
    }

    #[test]
    fn a_map_that_nobody_waits_for_ends_between_two_points() {
        let (s, j) = (axis(Parameter::S, 1.0, 5.0, 40), axis(Parameter::J, 0.0, 4.0, 40));
        let asked = std::sync::atomic::AtomicUsize::new(0);
        let goes_on = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 10;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let map = pool
            .install(|| Map::of_with_progress(&paper(), s, j, Method::Exact, goes_on).unwrap_err());
        assert_eq!(map, Error::Cancelled);
        // Each thread may ask once more.
        assert!((11..=12).contains(&asked.into_inner()));
    }

    #[test]
    fn axes_that_make_no_map_are_refused() {
        let of = |x, y| Map::of(&paper(), x, y, Method::Exact);
        let even = |parameter| axis(parameter, 0.5, 1.0, 2);
        assert!(of(even(Parameter::S), even(Parameter::S)).is_err());
        assert!(of(even(Parameter::JOverS), even(Parameter::J)).is_err());
        assert!(of(even(Parameter::DeadTime), even(Parameter::DeadTimeOverLag)).is_err());
        let none = Axis { parameter: Parameter::S, values: vec![] };
        assert!(of(none, even(Parameter::J)).is_err());
        assert!(Axis::even(Parameter::S, 0.0, 1.0, 1).is_err());
        assert!(Axis::even(Parameter::S, 0.0, f64::NAN, 3).is_err());
        let integrator = looped((0.4, 2.0), Process::integrator(1.0, 0.0).unwrap(), 5.0, 2.0);
        let lag = even(Parameter::DeadTimeOverLag);
        assert!(Map::of(&integrator, lag, even(Parameter::S), Method::Exact).is_err());
    }
}
