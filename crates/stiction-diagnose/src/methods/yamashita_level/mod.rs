//! Yamashita's excess kurtosis, for level loops.
//!
//! # What it measures
//! Whether the second derivative of the PV has heavy tails. Behind a sticking valve the level is a triangle wave:
//! its second derivative is zero except at the corners. That of a sinusoid is a sinusoid, whose distribution has no
//! tails.
//!
//! # Assumptions
//! An oscillating loop with an integrating process; noise that is about Gaussian.
//!
//! # Equations
//! ```text
//! z(k) = p(k - m) - 2 p(k) + p(k + m),  p = PV averaged over m samples,  m = period / 12
//! kurtosis = mean (z - mean z)^4 / var(z)^2 - 3
//! ```
//! It is -1.5 for a sinusoid, 0 for Gaussian noise and negative for any sinusoid in Gaussian noise. For a triangle
//! wave it is 2.4 without the averaging (derived here) and about 1.6 with it (simulated). Above 0: sticks. Below
//! -0.75: does not stick.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `upper` | none | 0 | ours: no sinusoid in Gaussian noise exceeds it |
//! | `lower` | none | -0.75 | ours: half way between sinusoid and noise |
//!
//! # Limits
//! Abstains without an oscillation. Steps of the set point or of the load are also corners. Noise alone gives 0,
//! plus or minus `sqrt(24/count)` of independent values.
//!
//! # Deviations from the paper
//! Only the idea was recalled, not read: excess kurtosis of the twice differenced PV. Lag, averaging and thresholds
//! are ours; differences from sample to sample would show only noise.
//!
//! # References
//! Y. Yamashita, a method for level control loops, 2006 (recalled; the title is not verified).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::detector::Detector;
use super::shared::curvature::curvature;
use super::shared::shapes::representable;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use crate::series::{centred, excess_kurtosis};

/// The excess kurtosis with its thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YamashitaLevel {
    /// Above it, the kurtosis indicates stiction.
    pub upper: f64,
    /// Below it, the kurtosis indicates no stiction.
    pub lower: f64,
}

impl Default for YamashitaLevel {
    fn default() -> Self {
        Self { upper: 0.0, lower: -0.75 }
    }
}

/// The result of the excess kurtosis.
#[derive(Debug, Clone, PartialEq)]
pub struct YamashitaLevelResult {
    /// The excess kurtosis.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// Second differences of the averaged PV.
    pub curvature: Vec<f64>,
    /// Their lag, samples.
    pub lag: usize,
    /// Cautions.
    pub caveats: Vec<String>,
}

impl YamashitaLevel {
    /// The description of this method.
    pub const METHOD: Method = Method {
        name: "yamashita-level",
        title: "Yamashita's excess kurtosis for levels",
        source: "Yamashita 2006; idea recalled, not read; lag and thresholds ours",
        statistic: "excess kurtosis of the PV's second difference",
        rule: "sticks if the excess kurtosis exceeds 0, does not stick if it is below -0.75",
        applies: Applies::Integrating,
        decides: Decides::Stiction,
        needs: Needs::OpAndPv,
        family: Family::Shape,
        explains_oscillation: true,
    };

    /// Differences the PV twice.
    ///
    /// # Errors
    /// If the method does not apply, the subject has no period, or the PV spans less than two periods.
    pub fn run(&self, subject: &Subject<'_>) -> Result<YamashitaLevelResult, Abstention> {
        let caveats = subject.check(&Self::METHOD)?;
        let pv = centred(subject.segment.pv.as_deref().unwrap_or_default());
        let found = curvature(subject, &pv)?;
        let statistic = representable(excess_kurtosis(&found.values))?;
        let decision = if statistic > self.upper {
            Decision::Sticks
        } else if statistic < self.lower {
            Decision::DoesNotStick
        } else {
            Decision::Undecided
        };
        Ok(YamashitaLevelResult {
            statistic,
            threshold: self.upper,
            decision,
            curvature: found.values,
            lag: found.lag,
            caveats,
        })
    }
}

impl Detector for YamashitaLevel {
    fn method(&self) -> &'static Method {
        &Self::METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("upper", self.upper, ""), Number::new("lower", self.lower, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let what = match r.decision {
            Decision::Sticks => "is straight between corners, as with a sticking valve",
            Decision::DoesNotStick => "bends like a sinusoid",
            _ => "bends neither like a sinusoid nor in corners",
        };
        let reason = format!(
            "the PV {what}: the excess kurtosis of its second difference is {:.2} (sticks above {:.2}, does not \
             below {:.2})",
            r.statistic, self.upper, self.lower
        );
        let numbers = vec![
            Number::new("excess kurtosis", r.statistic, ""),
            Number::new("lag", r.lag as f64 * subject.segment.sample_time, "s"),
        ];
        let finding =
            Finding::new(&Self::METHOD, r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
