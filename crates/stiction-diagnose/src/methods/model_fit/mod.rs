//! The published fits of a valve model before a linear process, as detectors.
//!
//! # What it measures
//! How much better a sticking valve before a linear process explains the PV than one that follows. Each method has
//! its own models and criterion, documented in its file: [`srinivasan`], [`lee`], [`jelali`], [`karra_karim`].
//!
//! # Assumptions
//! An oscillating loop with one valve before one linear process.
//!
//! # Equations
//! See the methods. The statistic of each is the gain, a logarithm of a ratio of errors or, for Karra and
//! Karim, a difference of information per sample.
//!
//! # Parameters
//! | name | unit | default | source |
//! |---|---|---|---|
//! | `least` | none | 0.1 for Jelali, else 0.05 | ours |
//!
//! # Limits
//! S and J depend on the model, so S and J of different models differ. Corners from other causes look like slips.
//!
//! # Deviations from the paper
//! See the methods; all are recalled, not read. The thresholds are ours.
//!
//! # References
//! See the methods.

mod armax;
pub mod earx;
#[cfg(feature = "figure")]
pub(super) mod figure;
pub mod jelali;
pub mod karra_karim;
pub mod lee;
pub mod published;
pub mod srinivasan;

use super::detector::Detector;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};
use karra_karim::KarraKarim;
use published::HammersteinFit;

/// The method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FittedBy {
    /// Srinivasan's, with one parameter.
    Srinivasan,
    /// Lee, Ren and Huang's.
    Lee,
    /// Jelali's.
    Jelali,
    /// Karra and Karim's.
    KarraKarim,
}

/// A fit with its threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelFit {
    /// The method.
    pub by: FittedBy,
    /// Gain above which the valve sticks.
    pub least: f64,
}

/// The result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFitResult {
    /// The gain.
    pub statistic: f64,
    /// Threshold of the statistic.
    pub threshold: f64,
    /// The verdict.
    pub decision: Decision,
    /// The fit.
    pub fit: HammersteinFit,
    /// For Karra and Karim's: the cause, and the share of the disturbance.
    pub cause: Option<(karra_karim::Cause, f64)>,
    /// Cautions.
    pub caveats: Vec<String>,
}

const fn method(
    name: &'static str,
    title: &'static str,
    source: &'static str,
    statistic: &'static str,
    rule: &'static str,
) -> Method {
    Method {
        name,
        title,
        source,
        statistic,
        rule,
        applies: Applies::AnyLoop,
        decides: Decides::Stiction,
        needs: Needs::OpAndPv,
        family: Family::Model,
        explains_oscillation: true,
    }
}

const SRINIVASAN: Method = method(
    "srinivasan",
    "Srinivasan's one-parameter fit",
    "Srinivasan, Rengaswamy, Narasimhan, Miller, Ind. Eng. Chem. Res. 44 (2005) 6719-6728; recalled, not \
     read",
    "gain, logarithm of a ratio of errors",
    "sticks if the gain exceeds 0.05 and Akaike's criterion agrees",
);
const LEE: Method = method(
    "lee",
    "Lee, Ren and Huang's fit",
    "Lee, Ren, Huang, Proc. ADCONIP (2008); recalled, not read",
    "gain, logarithm of a ratio of errors",
    "sticks if the gain exceeds 0.05",
);
const JELALI: Method = method(
    "jelali",
    "Jelali's fit by pattern search",
    "Jelali, J. Process Control 18 (2008) 632-642; recalled, not read",
    "gain, logarithm of a ratio of errors",
    "sticks if the gain exceeds 0.1",
);
const KARRA_KARIM: Method = method(
    "karra-karim",
    "Karra and Karim's diagnosis",
    "Karra, Karim, Control Eng. Practice 17 (2009) 939-956; recalled, not read",
    "gain of information per sample",
    "sticks if the gain exceeds 0.05",
);

impl ModelFit {
    /// A fit with our threshold.
    pub fn new(by: FittedBy) -> Self {
        let least = match by {
            FittedBy::Srinivasan => srinivasan::LEAST,
            FittedBy::Lee => lee::LEAST,
            FittedBy::Jelali => jelali::LEAST,
            FittedBy::KarraKarim => karra_karim::LEAST,
        };
        Self { by, least }
    }

    /// Fits OP and PV.
    ///
    /// # Errors
    /// If the method does not apply, or there are too few samples or periods.
    pub fn run(&self, subject: &Subject<'_>) -> Result<ModelFitResult, Abstention> {
        let caveats = subject.check(self.method())?;
        let (op, pv) = (&subject.segment.op, subject.segment.pv.as_deref().unwrap_or_default());
        let (period, least) = (subject.period, self.least);
        let (fit, cause) = match self.by {
            FittedBy::Srinivasan => (srinivasan::fit(op, pv, period, least)?, None),
            FittedBy::Lee => (lee::fit(op, pv, period, least)?, None),
            FittedBy::Jelali => (jelali::fit(op, pv, period, least)?, None),
            FittedBy::KarraKarim => {
                let KarraKarim { fit, cause, disturbance_share, .. } =
                    karra_karim::fit(op, pv, period, least)?;
                (fit, Some((cause, disturbance_share)))
            }
        };
        let decision = if fit.sticks { Decision::Sticks } else { Decision::DoesNotStick };
        Ok(ModelFitResult { statistic: fit.gain, threshold: least, decision, fit, cause, caveats })
    }
}

impl Detector for ModelFit {
    fn method(&self) -> &'static Method {
        match self.by {
            FittedBy::Srinivasan => &SRINIVASAN,
            FittedBy::Lee => &LEE,
            FittedBy::Jelali => &JELALI,
            FittedBy::KarraKarim => &KARRA_KARIM,
        }
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("least", self.least, "")]
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let r = self.run(subject)?;
        let fit = &r.fit;
        let how = if fit.sticks { "clearly better" } else { "not clearly better" };
        let cause = r.cause.map_or(String::new(), |(cause, _)| {
            format!("; the comparison of models gives {} as the cause", cause.name())
        });
        let reason = format!(
            "a sticking valve (S = {:.2} %, J = {:.2} %) before a linear process explains the PV {how} than a \
             valve that follows the OP: gain {:.3} (sticks above {:.2}){cause}",
            fit.s, fit.j, r.statistic, r.threshold
        );
        let mut numbers = vec![
            Number::new("gain", r.statistic, ""),
            Number::new("S", fit.s, "%"),
            Number::new("J", fit.j, "%"),
            Number::new("delay", (fit.delay * fit.factor) as f64, "samples"),
        ];
        if let Some((_, share)) = r.cause {
            numbers.push(Number::new("disturbance share", share, ""));
        }
        let finding =
            Finding::new(self.method(), r.decision, r.statistic, r.threshold, reason, numbers);
        let caveats = r.caveats.clone();
        Ok(Finding { caveats, looked_at: Some(LookedAt::new(r)), ..finding })
    }
}
