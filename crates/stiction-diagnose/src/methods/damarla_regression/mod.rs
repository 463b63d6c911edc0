//! Ratio of slopes in short windows (Damarla et al. 2022).
//!
//! # What it measures
//! While a valve sticks, the OP moves and the PV rests. Straight lines are fitted to both in short windows; where
//! the OP's slope is many times the PV's, the valve sticks.
//!
//! # Assumptions
//! The PV responds to the valve within a window: a flow loop, or windows about as long as the process time
//! constant. Noise does not tilt a line of `window` samples.
//!
//! # Equations
//! In each window, lines of least squares with the slopes `m_OP`, `m_PV`; the window sticks if
//! `|m_OP| >= eta |m_PV|` and the OP moves. Stiction index: 100 times the share of sticky windows.
//! Quantification: `|OP(first) - OP(last)|` of each run of sticky windows, its largest being the
//! stiction band.
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | window | 6 | samples | read in the public implementation |
//! | eta | 15 | | the same |
//! | as recorded | no | | ours, see below |
//!
//! # Limits
//! The published rule, an index above zero, needs one window in a recording. The extremes of a smooth PV cause it,
//! so long recordings are always called sticky. Noise is not taken into account.
//!
//! # Deviations from the paper
//! The paper was not read. The definition was taken from the source of the public implementation below.
//! * Its ratio depends on the units of PV and OP. By default both signals are in standard deviations, so that no
//!   change of scale changes a decision. `as_recorded` uses the recorded units and reproduces its counts: 5 of 166
//!   windows on loop CHEM2 of the International Stiction Data Base, 2 of 166 on CHEM10, 0 of 250 on CHEM13.
//! * A PV that does not move under a moving OP counts as an infinite ratio, as in that program. If neither moves there
//!   is no ratio, and the window does not count as sticky.
//!
//! # References
//! Damarla, S. K. et al., Ind. Eng. Chem. Res. 61 (2022) 502-514 (not read); GitHub
//! nPoKhappy/control-valve-stiction-implementation, thesis_3 (read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::windows::{op_travel, percentile_95};
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{max, std};

/// Number of samples in a window, as in the public implementation.
pub const WINDOW: usize = 6;
/// Ratio of slopes from which a window sticks, as in the public implementation.
pub const ETA: f64 = 15.0;

/// Smallest number of windows for a share; ours.
const FEWEST_WINDOWS: usize = 10;

static METHOD: Method = Method {
    name: "damarla-regression",
    title: "Damarla's ratio of slopes",
    source: "Damarla et al., Ind. Eng. Chem. Res. 61 (2022) 502-514; definition as read in a public \
             implementation, not in the paper",
    statistic: "stiction index, % of windows",
    rule: "sticks if the stiction index, the share of windows in which the OP's slope is at least 15 \
           times the PV's, is above the threshold 0",
    applies: Applies::SelfRegulating,
    decides: Decides::Stiction,
    needs: Needs::OpAndPv,
    family: Family::Windows,
    explains_oscillation: false,
};

/// The method with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct DamarlaRegression {
    /// Samples in a window.
    pub window: usize,
    /// Ratio of slopes from which a window sticks.
    pub eta: f64,
    /// Whether the slopes are in recorded units, as published, instead of standard deviations.
    pub as_recorded: bool,
}

impl Default for DamarlaRegression {
    fn default() -> Self {
        Self { window: WINDOW, eta: ETA, as_recorded: false }
    }
}

/// The result of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct DamarlaRegressionResult {
    /// Smallest ratio of the OP's slope to the PV's.
    pub eta: f64,
    /// Samples in a window.
    pub window: usize,
    /// Ratio of slopes in each window; infinite if only the OP moves, NaN if neither does.
    pub ratio: Vec<f64>,
    /// Whether each window sticks.
    pub sticky: Vec<bool>,
    /// Number of sticky windows.
    pub count: usize,
    /// Share of sticky windows, %.
    pub index: f64,
    /// OP travel in each run of sticky windows, percent.
    pub bands: Vec<f64>,
    /// The largest of these, the published stiction band, percent.
    pub band: Option<f64>,
    /// Their 95th percentile, percent.
    pub eta_95: Option<f64>,
    /// The decision.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

/// Sum of `(k - mean k) x(k)`, the slope of `x` except for a factor common to all windows; exactly zero if all
/// samples are equal.
fn tilt(x: &[f64]) -> f64 {
    let middle = (x.len() - 1) as f64 / 2.0;
    x.iter().enumerate().map(|(k, v)| (k as f64 - middle) * (v - x[0])).sum()
}

impl DamarlaRegression {
    /// Runs the method.
    ///
    /// # Errors
    /// If the method does not apply or there are fewer than ten windows.
    pub fn run(&self, subject: &Subject<'_>) -> Result<DamarlaRegressionResult, Abstention> {
        let caveats = subject.check(&METHOD)?;
        let Some(pv) = &subject.segment.pv else {
            return Err(Abstention("needs the PV, which is not recorded".to_owned()));
        };
        let op = &subject.segment.op;
        let window = self.window.max(2);
        if op.len() < FEWEST_WINDOWS * window {
            return Err(Abstention(format!(
                "needs at least {FEWEST_WINDOWS} windows of {window} samples; there are {} samples",
                op.len()
            )));
        }
        // The ratio in standard deviations.
        let scale = if self.as_recorded { 1.0 } else { std(pv) / std(op) };
        let ratio: Vec<f64> = op
            .chunks_exact(window)
            .zip(pv.chunks_exact(window))
            .map(|(op, pv)| (tilt(op) * scale / tilt(pv)).abs())
            .collect();
        let sticky: Vec<bool> = ratio.iter().map(|ratio| *ratio >= self.eta).collect();
        let count = sticky.iter().filter(|s| **s).count();
        let bands = op_travel(op, &sticky, window);
        Ok(DamarlaRegressionResult {
            eta: self.eta,
            window,
            count,
            index: 100.0 * count as f64 / sticky.len() as f64,
            band: (!bands.is_empty()).then(|| max(&bands)),
            eta_95: percentile_95(&bands),
            bands,
            ratio,
            sticky,
            decision: if count > 0 { Decision::Sticks } else { Decision::DoesNotStick },
            caveats,
        })
    }
}

impl Detector for DamarlaRegression {
    fn method(&self) -> &'static Method {
        &METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("window", self.window as f64, "samples"),
            Number::new("eta", self.eta, ""),
            Number::new("as recorded", f64::from(u8::from(self.as_recorded)), ""),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let result = self.run(subject)?;
        let reason = format!(
            "in {} of {} windows the OP's slope is at least {} times the PV's, an index of {:.2} %",
            result.count,
            result.sticky.len(),
            self.eta,
            result.index
        );
        let mut numbers = vec![
            Number::new("stiction index", result.index, "%"),
            Number::new("sticky windows", result.count as f64, ""),
            Number::new("windows", result.sticky.len() as f64, ""),
        ];
        numbers.extend(result.band.map(|band| Number::new("stiction band", band, "%")));
        numbers.extend(result.eta_95.map(|eta| Number::new("eta 95", eta, "%")));
        let finding = Finding::new(&METHOD, result.decision, result.index, 0.0, reason, numbers);
        let caveats = result.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(result)), ..finding })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tilt_is_the_slope_but_for_a_factor() {
        let x = [1.0, 3.0, 2.0, 7.0];
        let slope = crate::series::line(&[0.0, 1.0, 2.0, 3.0], &x).slope;
        assert!((tilt(&x) / 5.0 - slope).abs() < 1e-15);
        assert_eq!(tilt(&[0.1; 6]), 0.0);
    }
}
