//! Air pressure: a piecewise-linear signal, and the first-order lag behind it.

use super::parameters::StemParameters;
use crate::error::{Error, Result, all_finite, finite, positive};

/// Demanded air pressure over time, linear between points.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureSignal {
    points: Vec<(f64, f64)>,
}

/// A segment of time over which the demanded pressure is linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    pub(super) start_s: f64,
    pub(super) end_s: f64,
    pub(super) pressure_pa: f64,
    pub(super) slope_pa_per_s: f64,
}

impl PressureSignal {
    /// Through `(time in s, pressure in Pa)`; two points at the same time make a jump.
    ///
    /// # Errors
    /// If fewer than two points are given, times decrease or do not advance at all, or a number is
    /// NaN or infinite.
    pub fn from_points(points: Vec<(f64, f64)>) -> Result<Self> {
        for (index, &(time, pressure)) in points.iter().enumerate() {
            if !time.is_finite() {
                return Err(Error::NonFinite { signal: "pressure times", index, value: time });
            }
            if !pressure.is_finite() {
                return Err(Error::NonFinite { signal: "pressure", index, value: pressure });
            }
        }
        let ordered = points.windows(2).all(|w| w[0].0 <= w[1].0);
        let advances = points.first().map(|p| p.0) < points.last().map(|p| p.0);
        if !(ordered && advances) {
            return Err(Error::Inconsistent(
                "a pressure signal needs at least two points in order of time, spanning some time"
                    .to_owned(),
            ));
        }
        Ok(Self { points })
    }

    /// From controller output in percent, each sample held for `sample_time_s`, from time 0 on.
    ///
    /// # Errors
    /// If the list is empty, a sample is NaN or infinite, or the sample time is not above 0.
    pub fn held_op(op: &[f64], sample_time_s: f64, stem: &StemParameters) -> Result<Self> {
        positive("sample time", sample_time_s)?;
        all_finite("op", op)?;
        let points = op.iter().enumerate().flat_map(|(i, op)| {
            let pressure = stem.pressure_pa(*op);
            let start = i as f64 * sample_time_s;
            let end = (i + 1) as f64 * sample_time_s;
            [(start, pressure), (end, pressure)]
        });
        Self::from_points(points.collect())
    }

    /// The first time of the signal, s.
    pub fn start_s(&self) -> f64 {
        self.points[0].0
    }

    /// The last time of the signal, s.
    pub fn end_s(&self) -> f64 {
        self.points[self.points.len() - 1].0
    }

    /// The first pressure of the signal, Pa.
    pub fn first_pa(&self) -> f64 {
        self.points[0].1
    }

    pub(super) fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        self.points.windows(2).filter(|w| w[0].0 < w[1].0).map(|w| {
            let ((start_s, from), (end_s, to)) = (w[0], w[1]);
            let slope_pa_per_s = (to - from) / (end_s - start_s);
            Segment { start_s, end_s, pressure_pa: from, slope_pa_per_s }
        })
    }
}

impl Segment {
    /// A pressure held from `start_s` to `end_s`.
    pub(super) fn held(start_s: f64, end_s: f64, pressure_pa: f64) -> Result<Self> {
        finite("air pressure", pressure_pa)?;
        Ok(Self { start_s, end_s, pressure_pa, slope_pa_per_s: 0.0 })
    }
}

/// The acting pressure from some point of a segment on, with its lag solved exactly.
///
/// With the demand `a + b s` and the lag `tau p' = a + b s - p`,
/// `p(s) - p(0) = b s + (p(0) - a + b tau) (exp(-s/tau) - 1)`; without a lag it is `b s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Drive {
    /// Acting pressure at `s = 0`, Pa.
    pub(super) pressure_pa: f64,
    /// Slope `b` of the demand, Pa/s.
    pub(super) slope: f64,
    /// The part that decays with the lag, `p(0) - a + b tau`, Pa.
    pub(super) decaying: f64,
    /// `-1/tau`, 1/s; 0 without a lag.
    pub(super) decay: f64,
}

impl Drive {
    /// The drive at the start of `segment`, with the lag at `acting_pa`.
    pub(super) fn new(segment: &Segment, lag_s: f64, acting_pa: f64) -> Self {
        let slope = segment.slope_pa_per_s;
        if lag_s == 0.0 {
            Self { pressure_pa: segment.pressure_pa, slope, decaying: 0.0, decay: 0.0 }
        } else {
            let decaying = acting_pa - segment.pressure_pa + slope * lag_s;
            Self { pressure_pa: acting_pa, slope, decaying, decay: -1.0 / lag_s }
        }
    }

    /// A constant pressure.
    pub(super) fn resting(pressure_pa: f64) -> Self {
        Self { pressure_pa, slope: 0.0, decaying: 0.0, decay: 0.0 }
    }

    /// Rise of the acting pressure since `s = 0`, Pa.
    pub(super) fn rise(&self, s: f64) -> f64 {
        self.slope * s + self.decaying * (self.decay * s).exp_m1()
    }

    /// Integral of [`Self::rise`] from 0 to `s`, Pa s.
    pub(super) fn rise_integral(&self, s: f64) -> f64 {
        let lag = if self.decay == 0.0 {
            0.0
        } else {
            self.decaying * ((self.decay * s).exp_m1() / self.decay - s)
        };
        0.5 * self.slope * s * s + lag
    }

    /// The time after `s = 0` at which the acting pressure turns, if any. The pressure is monotone on either side.
    pub(super) fn turning_point(&self) -> Option<f64> {
        let ratio = -self.slope / (self.decaying * self.decay);
        let s = ratio.ln() / self.decay;
        (s > 0.0 && s.is_finite()).then_some(s)
    }

    /// This drive, with time relative to `s`.
    pub(super) fn later(&self, s: f64) -> Self {
        Self {
            pressure_pa: self.pressure_pa + self.rise(s),
            decaying: self.decaying * (self.decay * s).exp(),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Drive, Segment};

    #[test]
    fn the_lag_obeys_its_equation() {
        let segment =
            Segment { start_s: 0.0, end_s: 9.0, pressure_pa: 100.0, slope_pa_per_s: -20.0 };
        let drive = Drive::new(&segment, 0.7, 30.0);
        let h = 1e-4;
        for s in [0.2, 1.0, 3.0] {
            let rate = (drive.rise(s + h) - drive.rise(s - h)) / (2.0 * h);
            let demand = 100.0 - 20.0 * s;
            assert!((0.7 * rate - (demand - 30.0 - drive.rise(s))).abs() < 1e-6);
            let area = (drive.rise_integral(s + h) - drive.rise_integral(s - h)) / (2.0 * h);
            assert!((area - drive.rise(s)).abs() < 1e-6);
            let tail = drive.later(s).rise(0.5);
            assert!((drive.rise(s + 0.5) - drive.rise(s) - tail).abs() < 1e-12);
        }
        let turn = drive.turning_point().unwrap();
        assert!((drive.rise(turn + h) - drive.rise(turn - h)).abs() < 1e-6);
        assert_eq!(Drive::new(&segment, 0.0, 30.0).turning_point(), None);
    }
}
