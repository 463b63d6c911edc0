//! The linear part of a loop over frequency: margins, sensitivity, stability.
//!
//! # What it computes
//! `L(jw) = C(jw) G(jw)` of a [`ContinuousLoop`], the loop opened at the valve, with its unwrapped phase, gain and
//! phase margin, ultimate frequency and `Ms`; and whether the loop would be stable if the valve followed the OP.
//!
//! # Equations
//! ```text
//! C(s) = kp + ki / s + kd s / (Tf s + 1)        G(s) = num(s) / den(s) exp(-theta s)
//! L(s) = N(s) / D(s) exp(-theta s)              Ms = max |1 / (1 + L(jw))|
//! ```
//! The magnitude of L equals `g` at the roots of `|N|^2 - g^2 |D|^2`, a polynomial in `w^2` without dead time. So
//! gain crossovers are found exactly and completely.
//!
//! **Stability.** The poles of the closed loop are the zeros of `D(s) + N(s) exp(-theta s)`. Without dead time they are
//! counted as eigenvalues. As the dead time grows from 0 to theta, one pair crosses the imaginary axis at a gain
//! crossover `w` at each of the dead times `(arg(-N/D) + 2 pi k) / w`: to the right if `|D|^2 - |N|^2` rises with `w^2`
//! there, else to the left. The count is exact. It equals the count of Nyquist's criterion without following the curve.
//!
//! # Assumptions
//! Set-point weight, input of the derivative, limits and anti-windup do not matter here.
//!
//! # Limits
//! `Ms` and phase crossovers are found on a grid of 1 % in frequency (finer where dead time or a resonance turns
//! the phase faster) and refined: two crossovers within one step are missed.
//!
//! # References
//! K. J. Åström, T. Hägglund, "Advanced PID Control", ISA, 2006. K. Walton, J. E. Marshall, "Direct method
//! for TDS stability analysis", IEE Proc. D 134 (1987) 101-107 (recalled, not read).

use super::ContinuousLoop;
use crate::error::{Error, Result, positive};
use crate::numeric::golden::golden;
use crate::numeric::polynomial::{
    at_frequency, derivative, product, real, roots, sign_changes, squared_magnitude, sum, trimmed,
};
use crate::numeric::roots::bracketed;
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, PI};

/// Whether the loop would be stable if the valve followed the OP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stability {
    /// All poles of the closed loop lie in the left half plane.
    Stable,
    /// A pole lies on the imaginary axis to rounding.
    Marginal,
    /// A pole lies in the right half plane.
    Unstable,
}

/// Stability margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// Frequency with `|L| = 1` and the phase nearest to -180 degrees, rad/s; `None` if the gain never is 1.
    pub gain_crossover: Option<f64>,
    /// Distance of the phase from -180 degrees at that frequency, rad; negative for a larger lag.
    pub phase_margin: Option<f64>,
    /// Frequency of oscillation at the stability limit, after raising the gain (or lowering it, if the loop is
    /// unstable), rad/s; `None` if the phase never is -180 degrees.
    pub ultimate_frequency: Option<f64>,
    /// The factor of the gain at that limit (below 1: the gain must be lowered).
    pub gain_margin: Option<f64>,
    /// `Ms`, the largest sensitivity; infinite if `L` goes through -1.
    pub peak_sensitivity: f64,
    /// Frequency, rad/s.
    pub peak_frequency: f64,
}

/// The frequency response of a loop without its valve. Frequencies are in rad/s.
///
/// ```
/// use stiction_model::Bands;
/// use stiction_model::closed_loop::{Controller, Process};
/// use stiction_model::limit_cycle::{ContinuousLoop, FrequencyResponse, Stability};
/// use stiction_model::valve::Model;
///
/// let paper = ContinuousLoop::new(
///     Controller::pi(1.1, 2.5)?,
///     Process::first_order(1.5, 5.93, 1.07)?,
///     Model::Ideal,
///     Bands::NONE,
/// );
/// let response = FrequencyResponse::of(&paper)?;
/// let margins = response.margins();
/// assert!((margins.peak_sensitivity - 1.5692).abs() < 1e-4);
/// assert!(margins.gain_margin.is_some_and(|gain| (gain - 4.543).abs() < 1e-3));
/// assert_eq!(response.stability(), Stability::Stable);
/// # Ok::<(), stiction_model::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// Numerator and denominator of L without dead time.
    num: Vec<f64>,
    den: Vec<f64>,
    num_slope: Vec<f64>,
    den_slope: Vec<f64>,
    process: (Vec<f64>, Vec<f64>),
    zeros: Vec<Complex<f64>>,
    poles: Vec<Complex<f64>>,
    dead_time: f64,
}

impl FrequencyResponse {
    /// The response of the controller and the process of `continuous`.
    ///
    /// # Errors
    /// If the loop gain is zero, or its numerator is of higher degree than its denominator. An example of the second is
    /// a derivative without filter before a process with direct feedthrough.
    pub fn of(continuous: &ContinuousLoop) -> Result<Self> {
        let (kp, ki, kd) = continuous.controller.gains();
        let filter = trimmed(&[continuous.controller.filter_s(), 1.0]);
        let mut num = product(&[kp], &filter);
        let mut den = filter.clone();
        num = sum(&num, 1.0, &[kd, 0.0]);
        if ki != 0.0 {
            num = sum(&product(&num, &[1.0, 0.0]), ki, &filter);
            den = product(&den, &[1.0, 0.0]);
        }
        let process = continuous.process.coefficients();
        let (num, den) = (trimmed(&product(&num, &process.0)), product(&den, &process.1));
        if num.is_empty() {
            return Err(Error::Inconsistent(
                "the gain of the loop is 0, so it has neither a cycle nor margins".to_owned(),
            ));
        }
        if num.len() > den.len() {
            return Err(Error::Inconsistent(
                "the gain of the loop grows without bound with frequency; give the derivative a filter"
                    .to_owned(),
            ));
        }
        Ok(Self {
            num_slope: derivative(&num),
            den_slope: derivative(&den),
            zeros: roots(&num),
            poles: roots(&den),
            dead_time: continuous.process.dead_time(),
            process,
            num,
            den,
        })
    }

    fn delay(&self, w: f64) -> Complex<f64> {
        Complex::from_polar(1.0, -w * self.dead_time)
    }

    /// `L(jw)`: the response of process and controller to a VP of unit amplitude, with the sign that makes `L N =
    /// -1` the condition of a cycle.
    pub fn at(&self, w: f64) -> Complex<f64> {
        at_frequency(&self.num, w) / at_frequency(&self.den, w) * self.delay(w)
    }

    /// `G(jw)`: from VP to PV.
    pub fn process_at(&self, w: f64) -> Complex<f64> {
        at_frequency(&self.process.0, w) / at_frequency(&self.process.1, w) * self.delay(w)
    }

    /// The derivative of `ln L(jw)` with respect to `w`.
    pub(super) fn log_slope(&self, w: f64) -> Complex<f64> {
        let share = |slope: &[f64], of: &[f64]| at_frequency(slope, w) / at_frequency(of, w);
        Complex::new(0.0, 1.0)
            * (share(&self.num_slope, &self.num)
                - share(&self.den_slope, &self.den)
                - self.dead_time)
    }

    /// The phase of `L(jw)` for `w > 0` without jumps by a full turn, rad: near `w = 0` it is -90 degrees for each
    /// integrator (and -180 for a negative gain).
    pub fn phase(&self, w: f64) -> f64 {
        // Sums of angles of roots give the number of turns; the value itself gives the rest exactly.
        let angle = |root: &Complex<f64>| {
            if root.re > 0.0 {
                // A pair of complex roots contributes nothing at w = 0.
                let begin = if root.im < 0.0 { -PI } else { PI };
                begin - (w - root.im).atan2(root.re)
            } else if root.norm() == 0.0 {
                FRAC_PI_2
            } else {
                (w - root.im).atan2(-root.re)
            }
        };
        let of = |roots: &[Complex<f64>]| roots.iter().map(angle).sum::<f64>();
        // A real factor (s - r) with r > 0 has the sign of -1 at w = 0; that is part of the angle.
        let negative = self.num[0] * self.den[0] < 0.0;
        let sign = if negative { -PI } else { 0.0 };
        let rough = sign + of(&self.zeros) - of(&self.poles);
        let fine = (at_frequency(&self.num, w) / at_frequency(&self.den, w)).arg();
        fine + 2.0 * PI * ((rough - fine) / (2.0 * PI)).round() - w * self.dead_time
    }

    /// Frequencies at which `|L|` crosses `gain`, ascending.
    ///
    /// # Errors
    /// If `gain` is not positive.
    pub fn crossovers(&self, gain: f64) -> Result<Vec<f64>> {
        positive("gain", gain)?;
        Ok(self.where_gain_is(gain))
    }

    pub(super) fn where_gain_is(&self, gain: f64) -> Vec<f64> {
        sign_changes(&self.excess(gain)).into_iter().map(f64::sqrt).collect()
    }

    /// `gain^2 |D|^2 - |N|^2` as a polynomial in `w^2`.
    fn excess(&self, gain: f64) -> Vec<f64> {
        let den: Vec<f64> = squared_magnitude(&self.den).iter().map(|c| c * gain * gain).collect();
        sum(&den, -1.0, &squared_magnitude(&self.num))
    }

    /// Whether the loop would be stable if the valve followed the OP.
    pub fn stability(&self) -> Stability {
        /// Largest distance from the imaginary axis that counts as on it, as a share of the distance from 0.
        const ON_AXIS: f64 = 1e-9;
        let direct = (self.num.len() == self.den.len()).then(|| (self.num[0] / self.den[0]).abs());
        if self.dead_time > 0.0 && direct.is_some_and(|gain| gain >= 1.0) {
            // A difference equation that does not contract: infinitely many poles to the right.
            return Stability::Unstable;
        }
        let closed = sum(&self.den, 1.0, &self.num);
        let poles = roots(&closed);
        let size = closed.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
        let constant = self.num[self.num.len() - 1] + self.den[self.den.len() - 1];
        if poles.is_empty() {
            return if constant == 0.0 { Stability::Marginal } else { Stability::Stable };
        }
        if constant.abs() <= f64::EPSILON * size && poles.iter().any(|pole| pole.norm() == 0.0) {
            return Stability::Marginal;
        }
        let on_axis = |pole: &&Complex<f64>| pole.re.abs() <= ON_AXIS * pole.norm();
        let mut count: i64 =
            poles.iter().filter(|pole| pole.re > 0.0 && !on_axis(pole)).count() as i64;
        if self.dead_time == 0.0 {
            return match (count, poles.iter().any(|pole| on_axis(&pole))) {
                (0, false) => Stability::Stable,
                (0, true) => Stability::Marginal,
                _ => Stability::Unstable,
            };
        }
        let mut marginal = false;
        let excess = self.excess(1.0);
        let slope = derivative(&excess);
        for w in self.where_gain_is(1.0) {
            let to_the_right = real(&slope, w * w) > 0.0;
            let ratio = -at_frequency(&self.num, w) / at_frequency(&self.den, w);
            let angle = ratio.arg().rem_euclid(2.0 * PI);
            let at_once = angle.min(2.0 * PI - angle) <= ON_AXIS;
            // A pair on the axis without dead time was not counted; it leaves the axis at once.
            let first = if at_once { 0.0 } else { angle };
            let turns = (w * self.dead_time - first) / (2.0 * PI);
            marginal |= (turns - turns.round()).abs() <= ON_AXIS && turns.round() >= 0.0;
            let crossings = if turns <= 0.0 { 0 } else { turns.ceil() as i64 };
            let already = i64::from(at_once && !to_the_right && crossings > 0);
            count += 2 * (crossings - already) * if to_the_right { 1 } else { -1 };
        }
        match (count, marginal) {
            (0, false) => Stability::Stable,
            (0, true) => Stability::Marginal,
            _ if marginal => Stability::Marginal,
            _ => Stability::Unstable,
        }
    }

    /// The lowest frequency of a corner of L, or of gain 1, rad/s.
    pub(super) fn lowest(&self) -> f64 {
        let corners = self.zeros.iter().chain(&self.poles).map(|root| root.norm());
        let dead = (self.dead_time > 0.0).then(|| 1.0 / self.dead_time);
        let all = corners.chain(dead).chain(self.where_gain_is(1.0));
        let least = all.filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 1.0 }
    }

    /// Frequencies from `low` to `high`, close enough together that L is smooth between two.
    pub(super) fn grid(&self, low: f64, high: f64) -> Vec<f64> {
        const SHARE: f64 = 0.01;
        const TURN: f64 = 0.05;
        /// A dead time of thousands of lags turns too often to cover all of it.
        const MOST: f64 = 2e5;
        let turn = (TURN / self.dead_time).max((high - low) / MOST);
        let mut grid = vec![low];
        let mut w = low;
        while w < high {
            w = (w + (SHARE * w).min(turn)).min(high);
            grid.push(w);
        }
        // Around a resonance the phase turns within its width.
        for root in self.zeros.iter().chain(&self.poles) {
            let width = root.re.abs();
            if root.im > 0.0 && width < 0.3 * root.im && width > 0.0 {
                grid.extend((-20..=20).map(|k| root.im + width * (0.2 * f64::from(k)).sinh()));
            }
        }
        grid.retain(|w| (low..=high).contains(w));
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        grid
    }

    /// The largest frequency at which the gain is `gain`; `None` if it never is.
    pub(super) fn last_crossover(&self, gain: f64) -> Option<f64> {
        self.where_gain_is(gain).last().copied()
    }

    /// Margins and the largest sensitivity.
    pub fn margins(&self) -> Margins {
        /// Smallest gain with a margin.
        const FAINT: f64 = 1e-3;
        let (peak_sensitivity, peak_frequency) = self.peak();
        let from_180 = |w: f64| (-self.at(w)).arg();
        let nearest = self
            .where_gain_is(1.0)
            .into_iter()
            .min_by(|a, b| from_180(*a).abs().total_cmp(&from_180(*b).abs()));

        let low = 1e-3 * self.lowest();
        let limit = self.last_crossover(FAINT).unwrap_or(1e3 * self.lowest()).max(1e3 * low);
        // The first crossing beyond all frequencies of larger gain decides, so the search is in segments.
        let unstable = self.stability() == Stability::Unstable;
        let (mut begin, mut end) = (low, 10.0 * self.last_crossover(1.0).unwrap_or(self.lowest()));
        let mut ultimate: Option<f64> = None;
        loop {
            end = end.min(limit);
            for w in self.phase_crossovers(begin, end) {
                let gain = self.at(w).norm();
                let better = match ultimate {
                    _ if unstable != (gain >= 1.0) => false,
                    None => true,
                    Some(best) => !unstable && gain > self.at(best).norm(),
                };
                if better {
                    ultimate = Some(w);
                }
            }
            if end >= limit || ultimate.is_some() {
                break;
            }
            (begin, end) = (end, 4.0 * end);
        }
        Margins {
            gain_crossover: nearest,
            phase_margin: nearest.map(from_180),
            ultimate_frequency: ultimate,
            gain_margin: ultimate.map(|w| 1.0 / self.at(w).norm()),
            peak_sensitivity,
            peak_frequency,
        }
    }

    /// Where the phase crosses -180 degrees between two frequencies.
    fn phase_crossovers(&self, low: f64, high: f64) -> Vec<f64> {
        let grid = self.grid(low, high);
        let values: Vec<_> = grid.iter().map(|w| self.at(*w)).collect();
        let mut found = vec![];
        for k in 1..grid.len() {
            let (a, b) = (values[k - 1], values[k]);
            // The phase moves little in one step, so that a change of sign of Im L is a crossing of the axis.
            if (a.im > 0.0) != (b.im > 0.0) && a.re < 0.0 && b.re < 0.0 {
                found.push(bracketed(|w| self.at(w).im, grid[k - 1], grid[k]));
            }
        }
        found
    }

    /// The largest sensitivity and its frequency.
    pub(super) fn peak(&self) -> (f64, f64) {
        let sensitivity = |w: f64| 1.0 / (1.0 + self.at(w)).norm();
        let low = 1e-3 * self.lowest();
        let (mut best, mut at) = (sensitivity(low), low);
        let mut begin = low;
        // Beyond the last point with |L| = g no sensitivity exceeds 1 / (1 - g).
        let mut gain = 0.5;
        loop {
            let end = self.last_crossover(gain).unwrap_or(begin).max(begin);
            let grid = self.grid(begin, end);
            let values: Vec<f64> = grid.iter().map(|w| sensitivity(*w)).collect();
            for k in 0..grid.len() {
                let beside = |k: usize| values.get(k).copied().unwrap_or(0.0);
                let top = values[k] >= beside(k + 1) && (k == 0 || values[k] >= values[k - 1]);
                if !top || values[k] < 0.98 * best {
                    continue;
                }
                let (left, right) = (grid[k.saturating_sub(1)], grid[(k + 1).min(grid.len() - 1)]);
                let polished = golden(|w| -sensitivity(w), left, right);
                for w in [polished, grid[k]] {
                    if sensitivity(w) > best {
                        (best, at) = (sensitivity(w), w);
                    }
                }
            }
            if best * (1.0 - gain) >= 1.0 || gain < 1e-2 {
                return (best, at);
            }
            (begin, gain) = (end, 0.5 * gain);
        }
    }
}
