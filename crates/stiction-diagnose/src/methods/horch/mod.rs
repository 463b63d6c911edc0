//! Horch's cross-correlation of OP and PV.
//!
//! # What it measures
//! Whether the cross-correlation of OP and PV is odd or even around lag zero. A valve that sticks turns a
//! triangular OP into a square wave, a quarter of a period apart from the PV's response: odd. An oscillating
//! disturbance or set point leaves OP and PV in phase or in opposite phase: even.
//!
//! # Assumptions
//! An oscillating loop with a self-regulating process, a controller with proportional and integral action but no
//! derivative, and an incompressible medium.
//!
//! # Equations
//! With `u` the OP and `y` the PV, less their means, over `n` samples:
//! ```text
//! r(lag) = sum_k u(k) y(k + lag) / (n sd(u) sd(y)),   r0 = r(0)
//! tau_l, tau_r = distance from lag zero to the first crossing of zero, left and right
//! r_opt = the r between them of the sign of r0 that is farthest from zero
//! delta tau = |tau_l - tau_r| / (tau_l + tau_r),   delta rho = |r0 - r_opt| / |r0 + r_opt|
//! ```
//! Both above 2/3: sticks. Both below 1/3: does not stick. Otherwise undecided. The statistic is the smaller ratio, so
//! it exceeds its threshold if both ratios do.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `upper` | none | 2/3 | Horch 1999, recalled, not read |
//! | `lower` | none | 1/3 | Horch 1999, recalled, not read |
//!
//! # Limits
//! Often undecided, because the delays of process and filter turn the phase. Blind for integrating processes, where
//! stiction and disturbance give similar phases.
//!
//! # Deviations from the paper
//! None known; only the first page of the paper was read, the rest recalled. No public program with the two ratios
//! was found. Crossings are interpolated between lags, `r_opt` uses whole lags.
//!
//! # References
//! A. Horch, A simple method for detection of stiction in control valves, Control Engineering Practice
//! 7 (1999) 1221-1231.

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::shapes::presume_oscillation;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{CrossCorrelation, cross_correlation, fft_length};

/// Horch's cross-correlation with its thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horch {
    /// Above it, both ratios indicate stiction.
    pub upper: f64,
    /// Below it, both ratios indicate no stiction.
    pub lower: f64,
}

impl Default for Horch {
    fn default() -> Self {
        Self { upper: 2.0 / 3.0, lower: 1.0 / 3.0 }
    }
}

/// The result of Horch's cross-correlation.
#[derive(Debug, Clone, PartialEq)]
pub struct HorchResult {
    /// Asymmetry of the crossings of zero, 0 to 1.
    pub delta_tau: f64,
    /// Distance of the correlation at lag zero from the peak, 0 to 1.
    pub delta_rho: f64,
    /// The smaller of both.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// Distance from lag zero to the crossing on the left, samples.
    pub tau_left: f64,
    /// Distance from lag zero to the crossing on the right, samples.
    pub tau_right: f64,
    /// The correlation at lag zero.
    pub r0: f64,
    /// The peak between the crossings.
    pub r_opt: f64,
    /// Lag of the peak, samples.
    pub lag_opt: isize,
    /// The correlation around lag zero, to twice the larger distance.
    pub correlation: CrossCorrelation,
    /// Cautions.
    pub caveats: Vec<String>,
}

/// Distance from lag zero to the first crossing among `values`, which begin at lag zero.
fn first_crossing(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut before: Option<(usize, f64)> = None;
    for (k, value) in values.enumerate() {
        if let Some((j, b)) = before
            && b * value <= 0.0
        {
            return Some(j as f64 + if b == 0.0 { 0.0 } else { b / (b - value) });
        }
        before = Some((k, value));
    }
    None
}

impl Horch {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "horch",
        title: "Horch's cross-correlation",
        source: "Horch, Control Eng. Practice 7 (1999) 1221-1231; first page read, formulas recalled",
        statistic: "smaller of delta tau and delta rho",
        rule: "sticks if delta tau and delta rho exceed 2/3, does not stick if both are below 1/3",
        applies: Applies::SelfRegulating,
        decides: Decides::Stiction,
        needs: Needs::OpAndPv,
        family: Family::Correlation,
        explains_oscillation: true,
    };

    /// Correlates OP and PV.
    ///
    /// # Errors
    /// If the method does not apply, or the correlation never changes sign.
    pub fn run(&self, subject: &Subject<'_>) -> Result<HorchResult, Abstention> {
        let mut caveats = subject.check(&Self::METHOD)?;
        presume_oscillation(subject, &mut caveats);
        let (u, y) = (&subject.segment.op, subject.segment.pv.as_deref().unwrap_or_default());
        let n = u.len();
        let constant = || Abstention("no correlation, because OP or PV hardly moves".to_owned());
        let keeps = || {
            Abstention(
                "the correlation of OP and PV does not cross zero on both sides of lag zero"
                    .to_owned(),
            )
        };
        let full = n.saturating_sub(1);
        // Crossings are near, so the first attempt uses as many lags as a transform of half the length gives.
        let near = (fft_length(n) - n).saturating_sub(1).min(full);
        let crossings = |max_lag: usize| {
            let correlation = cross_correlation(u, y, max_lag).ok_or_else(constant)?;
            if correlation.values.iter().any(|r| !r.is_finite()) {
                return Err(constant());
            }
            let left = &correlation.values[..=correlation.max_lag];
            let right = &correlation.values[correlation.max_lag..];
            let tau_left = first_crossing(left.iter().rev().copied()).ok_or_else(keeps)?;
            let tau_right = first_crossing(right.iter().copied()).ok_or_else(keeps)?;
            Ok((correlation, tau_left, tau_right))
        };
        let (correlation, tau_left, tau_right) = crossings(near).or_else(|_| crossings(full))?;
        let max_lag = correlation.max_lag;

        let r0 = correlation.at(0);
        let sign = if r0 < 0.0 { -1.0 } else { 1.0 };
        let mut best = (0, r0);
        for lag in -(tau_left as isize)..=tau_right as isize {
            let r = correlation.at(lag);
            if r * sign > best.1 * sign {
                best = (lag, r);
            }
        }
        let (lag_opt, r_opt) = best;
        // Exactly zero at lag zero is perfectly odd.
        let odd_if_nan = |ratio: f64| if ratio.is_nan() { 1.0 } else { ratio };
        let delta_tau = odd_if_nan((tau_left - tau_right).abs() / (tau_left + tau_right));
        let delta_rho = odd_if_nan((r0 - r_opt).abs() / (r0 + r_opt).abs());
        let statistic = delta_tau.min(delta_rho);
        let decision = if statistic > self.upper {
            Decision::Sticks
        } else if delta_tau.max(delta_rho) < self.lower {
            Decision::DoesNotStick
        } else {
            Decision::Undecided
        };
        let shown = ((2.0 * tau_left.max(tau_right)).ceil() as usize).clamp(1, max_lag.max(1));
        let shown = shown.min(max_lag);
        let values = correlation.values[max_lag - shown..=max_lag + shown].to_vec();
        Ok(HorchResult {
            delta_tau,
            delta_rho,
            statistic,
            threshold: self.upper,
            decision,
            tau_left,
            tau_right,
            r0,
            r_opt,
            lag_opt,
            correlation: CrossCorrelation { values, max_lag: shown },
            caveats,
        })
    }
}

impl Detector for Horch {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("upper", self.upper, ""), Number::new("lower", self.lower, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let what = match r.decision {
            Decision::Sticks => "the correlation of OP and PV is odd, as with a sticking valve",
            Decision::DoesNotStick => "the correlation of OP and PV is even, as with a disturbance",
            _ => "the correlation of OP and PV is neither odd nor even",
        };
        let reason = format!(
            "{what}: delta tau is {:.3}, delta rho {:.3} (sticks if both are above {:.3}, does not stick if both \
             are below {:.3})",
            r.delta_tau, r.delta_rho, self.upper, self.lower
        );
        let numbers = vec![
            Number::new("delta tau", r.delta_tau, ""),
            Number::new("delta rho", r.delta_rho, ""),
            Number::new("tau left", r.tau_left * subject.segment.sample_time, "s"),
            Number::new("tau right", r.tau_right * subject.segment.sample_time, "s"),
            Number::new("r at lag zero", r.r0, ""),
            Number::new("r at its peak", r.r_opt, ""),
        ];
        let finding =
            Finding::new(&Self::METHOD, r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
