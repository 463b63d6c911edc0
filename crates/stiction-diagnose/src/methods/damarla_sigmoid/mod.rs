//! A sigmoid between the PV's increments and the OP (Damarla et al., AdCONIP 2022).
//!
//! # What it measures
//! Under stiction the PV climbs while the valve rests on one side and falls while it rests on the other. Plotted
//! against the increments of the PV, the OP has two levels with a steep transition between, which a sigmoid
//! describes.
//!
//! # Assumptions
//! Increments of the PV are larger than its noise; the two resting places of the valve show in their
//! sign, as behind a lag or an integrator.
//!
//! # Equations
//! `x(k) = PV(k) - PV(k-1)`, less its mean and over its standard deviation; `y(k)` the OP, from 0 at its
//! smallest to 1 at its largest. `f(x) = 1 / (1 + exp(-(a x + b)))` is fitted to `y` by least squares
//! (Levenberg and Marquardt, from `a = ±1` by the sign of the correlation, `b = 0`); `R` is the
//! correlation of `y` and `f(x)`, not below 0.
//!
//! # Parameters
//! | name | default | unit | source |
//! |---|---|---|---|
//! | threshold of R | 0.5 | | read in the public implementation |
//! | most pairs | 4,000 | | ours, for speed |
//!
//! # Limits
//! A sine that lags its cause by a quarter of a period has `R` near 1, for any cause. So the method alone cannot
//! distinguish stiction from other oscillations of a lagging process. Noise in the PV covers its increments. One
//! outlier of the OP compresses `y`.
//!
//! # Deviations from the paper
//! The paper was not read. Increments, scaling, function and threshold were taken from the public implementation below.
//! It adds a first increment of 0, begins at `a = 1`, and rounds `R` to two digits before the comparison. Its stored
//! `R` of seven recorded loops, from another fit, differ from ours by at most 0.06. Of more than 4,000 pairs, evenly
//! spaced ones are used.
//!
//! # References
//! Damarla, S. K. et al., AdCONIP 2022, 210-215 (not read); GitHub
//! nPoKhappy/control-valve-stiction-implementation, thesis_2 and final/data.py (read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{mean, min, span, standardised};

/// Correlation from which the valve sticks, as in the public implementation.
pub const THRESHOLD: f64 = 0.5;
/// Most fitted pairs; ours.
pub const MOST_PAIRS: usize = 4_000;

/// Smallest number of samples for a fit; ours.
const FEWEST_SAMPLES: usize = 50;
/// Largest number of steps of the fit; ours, it needs about ten.
const MOST_STEPS: usize = 30;

static METHOD: Method = Method {
    name: "damarla-sigmoid",
    title: "Damarla's sigmoid",
    source: "Damarla et al., AdCONIP (2022) 210-215; definition as read in a public \
             implementation, not in the paper",
    statistic: "R, correlation of the OP with the sigmoid",
    rule: "sticks if R reaches the threshold 0.5",
    applies: Applies::AnyLoop,
    decides: Decides::Stiction,
    needs: Needs::OpAndPv,
    family: Family::PhasePlot,
    explains_oscillation: false,
};

/// The method with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct DamarlaSigmoid {
    /// Correlation from which the valve sticks.
    pub threshold: f64,
    /// Most fitted pairs.
    pub most_pairs: usize,
}

impl Default for DamarlaSigmoid {
    fn default() -> Self {
        Self { threshold: THRESHOLD, most_pairs: MOST_PAIRS }
    }
}

/// The result of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct DamarlaSigmoidResult {
    /// The PV's increments, in standard deviations.
    pub increment: Vec<f64>,
    /// The OP, from 0 to 1.
    pub op: Vec<f64>,
    /// Steepness of the sigmoid.
    pub a: f64,
    /// Shift.
    pub b: f64,
    /// Correlation of the OP with the sigmoid, not below 0.
    pub r: f64,
    /// The decision.
    pub decision: Decision,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl DamarlaSigmoidResult {
    /// The sigmoid at an increment of `x` standard deviations.
    pub fn sigmoid(&self, x: f64) -> f64 {
        sigmoid(self.a * x + self.b)
    }
}

fn sigmoid(z: f64) -> f64 {
    1.0 / (1.0 + (-z).exp())
}

/// Sum of squares of a sigmoid's errors, with the gradient and the normal matrix of Gauss.
#[derive(Clone, Copy)]
struct Normal {
    squares: f64,
    gradient: [f64; 2],
    matrix: [f64; 3],
}

impl Normal {
    fn of(a: f64, b: f64, x: &[f64], y: &[f64]) -> Self {
        let mut n = Self { squares: 0.0, gradient: [0.0; 2], matrix: [0.0; 3] };
        for (x, y) in x.iter().zip(y) {
            let f = sigmoid(a * x + b);
            let (error, slope) = (y - f, f * (1.0 - f));
            n.squares += error * error;
            n.gradient[0] += error * slope * x;
            n.gradient[1] += error * slope;
            let weight = slope * slope;
            n.matrix[0] += weight * x * x;
            n.matrix[1] += weight * x;
            n.matrix[2] += weight;
        }
        n
    }

    /// The step of Levenberg and Marquardt with the damping `damping`.
    fn step(&self, damping: f64) -> Option<[f64; 2]> {
        let [xx, x, one] = self.matrix;
        let (xx, one) = (xx * (1.0 + damping), one * (1.0 + damping));
        let determinant = xx * one - x * x;
        let [ga, gb] = self.gradient;
        let step = [(one * ga - x * gb) / determinant, (xx * gb - x * ga) / determinant];
        step.iter().all(|v| v.is_finite()).then_some(step)
    }
}

/// The steepness and shift of the sigmoid that fits `y` best.
fn fit(x: &[f64], y: &[f64]) -> (f64, f64) {
    let together: f64 = x.iter().zip(y).map(|(x, y)| x * (y - 0.5)).sum();
    let (mut a, mut b) = (if together < 0.0 { -1.0 } else { 1.0 }, 0.0);
    let mut now = Normal::of(a, b, x, y);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let Some([da, db]) = now.step(damping) else { break };
        let next = Normal::of(a + da, b + db, x, y);
        if next.squares <= now.squares {
            let done = now.squares - next.squares <= 1e-10 * now.squares;
            (a, b, now) = (a + da, b + db, next);
            damping *= 0.1;
            if done {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    (a, b)
}

/// Correlation of two series, 0 if either is constant.
fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let (mx, my) = (mean(x), mean(y));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        let (x, y) = (x - mx, y - my);
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    let r = xy / (xx.sqrt() * yy.sqrt());
    if r.is_finite() { r } else { 0.0 }
}

impl DamarlaSigmoid {
    /// Runs the method.
    ///
    /// # Errors
    /// If the method does not apply, there are fewer than 50 samples, or the PV climbs evenly.
    pub fn run(&self, subject: &Subject<'_>) -> Result<DamarlaSigmoidResult, Abstention> {
        let caveats = subject.check(&METHOD)?;
        let Some(pv) = &subject.segment.pv else {
            return Err(Abstention("needs the PV, which is not recorded".to_owned()));
        };
        let op = &subject.segment.op;
        if op.len() < FEWEST_SAMPLES {
            return Err(Abstention(format!(
                "needs at least {FEWEST_SAMPLES} samples; there are {}",
                op.len()
            )));
        }
        let stride = (op.len() - 1).div_ceil(self.most_pairs.max(FEWEST_SAMPLES));
        let places = || (1..op.len()).step_by(stride);
        let increment: Vec<f64> = places().map(|k| pv[k] - pv[k - 1]).collect();
        let op: Vec<f64> = places().map(|k| op[k]).collect();
        let Some(increment) = standardised(&increment) else {
            return Err(Abstention("the PV never changes its slope".to_owned()));
        };
        let (low, range) = (min(&op), span(&op));
        let op: Vec<f64> = op.iter().map(|v| (v - low) / range).collect();
        if op.iter().chain(&increment).any(|v| !v.is_finite()) {
            return Err(Abstention("the signals cannot be brought to a common scale".to_owned()));
        }
        let (a, b) = fit(&increment, &op);
        let fitted: Vec<f64> = increment.iter().map(|x| sigmoid(a * x + b)).collect();
        let r = correlation(&op, &fitted).max(0.0);
        let decision = if r >= self.threshold { Decision::Sticks } else { Decision::DoesNotStick };
        Ok(DamarlaSigmoidResult { increment, op, a, b, r, decision, caveats })
    }
}

impl Detector for DamarlaSigmoid {
    fn method(&self) -> &'static Method {
        &METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![
            Number::new("threshold of R", self.threshold, ""),
            Number::new("most pairs", self.most_pairs as f64, ""),
        ]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let result = self.run(subject)?;
        let reason = format!(
            "the OP correlates with a sigmoid of the PV's increments by R = {:.3}; threshold {}",
            result.r, self.threshold
        );
        let numbers = vec![
            Number::new("R", result.r, ""),
            Number::new("a", result.a, ""),
            Number::new("b", result.b, ""),
        ];
        let finding =
            Finding::new(&METHOD, result.decision, result.r, self.threshold, reason, numbers);
        let caveats = result.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(result)), ..finding })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fit_finds_a_sigmoid_again() {
        let x: Vec<f64> = (0..200).map(|k| (0.7 * f64::from(k)).sin() * 2.0).collect();
        for (a, b) in [(3.0, 0.5), (-8.0, -1.0), (0.2, 0.0)] {
            let y: Vec<f64> = x.iter().map(|x| sigmoid(a * x + b)).collect();
            let (fa, fb) = fit(&x, &y);
            assert!((fa - a).abs() < 1e-5 && (fb - b).abs() < 1e-5, "{fa} {fb}");
        }
    }
}
