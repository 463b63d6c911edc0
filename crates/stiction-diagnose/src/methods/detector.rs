//! What every method of the registry can do.

use super::subject::Subject;
use crate::finding::{Abstention, Decision, Finding, Method, Number};

/// A method with its parameters.
pub trait Detector: Send + Sync {
    /// What it is.
    fn method(&self) -> &'static Method;
    /// Its parameters as they are set.
    fn parameters(&self) -> Vec<Number>;
    /// What it says of a segment and what it looked at; [`judge`](Self::judge) adds the parameters.
    ///
    /// # Errors
    /// If it does not apply, or the data do not suffice.
    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention>;
    /// What it says of a segment. It never fails: what it cannot judge, it abstains from.
    fn judge(&self, subject: &Subject<'_>) -> Finding {
        let found = self.look(subject);
        let finding = found.unwrap_or_else(|why| Finding::abstains(self.method(), why));
        Finding { parameters: self.parameters(), ..finding }
    }
}

/// What a detector says of a segment, the published precondition of its method included.
///
/// Methods that tell the cause of an oscillation are applied, in their publications, to loops in which
/// one was found before. Where none was found (the subject has no period) such a method abstains; the
/// statistic stays, for whoever wants to see it.
pub fn judge(detector: &dyn Detector, subject: &Subject<'_>) -> Finding {
    let mut finding = detector.judge(subject);
    let judged = finding.decision != Decision::Abstains;
    if judged && detector.method().explains_oscillation && subject.period.is_none() {
        finding.reason = format!(
            "tells the cause of an oscillation, and none was found (it would say: {})",
            finding.decision.name()
        );
        finding.decision = Decision::Abstains;
    }
    finding
}
