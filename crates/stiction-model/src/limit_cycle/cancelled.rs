//! The cycle in closed form, if the controller cancels the process.
//!
//! # What it computes
//! Period and amplitudes of the limit cycle of a two-phase valve before a process of first order with dead time under a
//! PI controller whose integral time is the time constant.
//!
//! # Equations
//! The zero of the controller cancels the pole of the process. Once the cancelled mode has decayed, with `kappa = Kp Kc
//! / tau`, `q = kappa theta`, and positions relative to the position that holds the PV at its set point,
//! ```text
//! du/dt = -kappa x(t - theta)
//! ```
//! Let the stem be stuck at `-a`, for longer than theta. The OP rises at the rate `kappa a` until `u = fs - a`. The
//! stem jumps to `J - a` and follows. The process still receives `-a`, so the OP and the stem rise at the same rate for
//! a different theta, by `q a`. Then the jump reaches the process. If `J - a > 0`, which the fixed point below
//! satisfies for `q < 1`, the OP turns at once, and the stem sticks at `J - (1 - q) a`. From stroke to stroke
//! ```text
//! a(n+1) = J - (1 - q) a(n)
//! ```
//! which contracts to `a = J / (2 - q)` if `0 < q < 1`; a period is two strokes, so its multiplier is
//! `(1 - q)^2`. Now the OP falls. During the first theta the process sees the stem moving from
//! `J - a` to `a`: it falls by `q (J - a) + q^2 a / 2`. After that it falls at the rate `kappa a`,
//! until it has come back by `S`, from `fd` ahead of the stem to `fs` behind. Hence
//! ```text
//! VP  a,    OP  a + (S - J) / 2,    T = 4 theta + 2 (S - q (J - a) - q^2 a / 2) / (kappa a)
//! ```
//!
//! # Limits
//! For `q >= 1` strokes alternate or grow, and only the flow gives the result. The PV has no form as short: between
//! slips it is a sum of exponentials.
//!
//! # References
//! None; derived for this project and confirmed by simulation and by the flow of
//! [`exact`](super::exact).

use super::ContinuousLoop;
use crate::bands::Bands;

/// The loop, with integral time equal to the time constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CancelledLoop {
    /// Gain of the process, units of PV per percent.
    pub process_gain: f64,
    /// Gain of the controller, percent per unit of PV.
    pub controller_gain: f64,
    /// Time constant of the process and integral time of the controller, s.
    pub time_constant_s: f64,
    /// Dead time, s.
    pub dead_time_s: f64,
}

/// Period and amplitudes of a cycle in closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CancelledCycle {
    /// Period, s.
    pub period_s: f64,
    /// Half of the peak-to-peak value of the OP, percent.
    pub op: f64,
    /// Half of the peak-to-peak value of the VP, percent.
    pub vp: f64,
}

impl CancelledLoop {
    /// `l`, if it is such a loop to the last digits.
    pub fn of(l: &ContinuousLoop) -> Option<Self> {
        let (num, den) = l.process.coefficients();
        let ([gain], [tau, one]) = (&num[..], &den[..]) else { return None };
        let (kp, ki, kd) = l.controller.gains();
        let cancels = kd == 0.0 && (kp - ki * tau).abs() <= 1e-14 * kp.abs();
        (cancels && *one == 1.0).then(|| Self {
            process_gain: *gain,
            controller_gain: kp,
            time_constant_s: *tau,
            dead_time_s: l.process.dead_time(),
        })
    }

    /// `kappa = Kp Kc / tau`, 1/s, and `q = kappa theta`.
    pub fn rate(&self) -> (f64, f64) {
        let kappa = self.process_gain * self.controller_gain / self.time_constant_s;
        (kappa, kappa * self.dead_time_s)
    }

    /// The cycle of a two-phase valve; `None` unless `0 < q < 1` and `J > 0`.
    ///
    /// ```
    /// use stiction_model::Bands;
    /// use stiction_model::limit_cycle::CancelledLoop;
    /// let known = CancelledLoop {
    ///     process_gain: 3.0,
    ///     controller_gain: 0.2,
    ///     time_constant_s: 10.0,
    ///     dead_time_s: 10.0,
    /// };
    /// let cycle = known.cycle(Bands::from_s_j(5.0, 5.0)?).expect("it cycles");
    /// assert!((cycle.period_s - 218.0 / 3.0).abs() < 1e-12);
    /// assert!((cycle.op - 25.0 / 7.0).abs() < 1e-12);
    /// # Ok::<(), stiction_model::Error>(())
    /// ```
    pub fn cycle(&self, bands: Bands) -> Option<CancelledCycle> {
        let (kappa, q) = self.rate();
        let (s, j) = (bands.s(), bands.j());
        let vp = j / (2.0 - q);
        let falls = s - q * (j - vp) - 0.5 * q * q * vp;
        (q > 0.0 && q < 1.0 && j > 0.0 && falls > 0.0).then(|| CancelledCycle {
            period_s: 4.0 * self.dead_time_s + 2.0 * falls / (kappa * vp),
            op: vp + bands.fd(),
            vp,
        })
    }

    /// `S` and `J` from period and OP amplitude: the inverse of [`cycle`](Self::cycle). With
    /// `S = 2 A - 2 a + J` and `J = (2 - q) a` the period is linear in `1 / a`.
    pub fn s_j(&self, period_s: f64, op: f64) -> (f64, f64) {
        let (kappa, q) = self.rate();
        let vp =
            2.0 * op / (0.5 * kappa * (period_s - 4.0 * self.dead_time_s) + q * (2.0 - 0.5 * q));
        let j = (2.0 - q) * vp;
        (2.0 * (op - vp) + j, j)
    }
}
