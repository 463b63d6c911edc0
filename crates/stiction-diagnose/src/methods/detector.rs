//! The common functions of all methods in the registry.

use super::subject::Subject;
use crate::finding::{Abstention, Decision, Finding, Method, Number};

/// A method with its parameters.
pub trait Detector: Send + Sync {
    /// Description.
    fn method(&self) -> &'static Method;
    /// Present settings.
    fn parameters(&self) -> Vec<Number>;
    /// The finding for a segment, and the method's result; [`judge`](Self::judge) adds the parameters.
    ///
    /// # Errors
    /// If the method does not apply, or the data do not suffice.
    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention>;
    /// The finding for a segment. It never fails: without a judgement, it abstains.
    fn judge(&self, subject: &Subject<'_>) -> Finding {
        let found = self.look(subject);
        let finding = found.unwrap_or_else(|why| Finding::abstains(self.method(), why));
        Finding { parameters: self.parameters(), ..finding }
    }
}

/// The finding of a detector for a segment, including the published precondition of its method.
///
/// In their publications, methods that explain an oscillation are applied only to loops with a detected one. If
/// none was found (the subject has no period), such a method abstains; the statistic is kept.
pub fn judge(detector: &dyn Detector, subject: &Subject<'_>) -> Finding {
    let mut finding = detector.judge(subject);
    let judged = finding.decision != Decision::Abstains;
    if judged && detector.method().explains_oscillation && subject.period.is_none() {
        finding.reason = format!(
            "the method explains an oscillation, but none was found (without this condition: {})",
            finding.decision.name()
        );
        finding.decision = Decision::Abstains;
    }
    finding
}
