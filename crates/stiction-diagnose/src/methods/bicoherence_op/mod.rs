//! Bicoherence of the OP alone (after Choudhury, Shah & Thornhill 2004).
//!
//! # What it measures
//! Whether the OP is nonlinear, by the bicoherence and the cubic coupling of [`bicoherence`](super::bicoherence).
//!
//! # Assumptions
//! A stationary record of some ten segments; disturbances are linear.
//!
//! # Equations
//! As for [`bicoherence`](super::bicoherence), for the OP instead of the control error.
//!
//! # Parameters
//! As for [`bicoherence`](super::bicoherence).
//!
//! # Limits
//! Any nonlinearity is attributed to the loop: it gives no information about the valve, and does not vote.
//!
//! # Deviations from the paper
//! The paper tests the control error; the test of the OP alone is ours.
//!
//! # References
//! Choudhury, Shah, Thornhill, Automatica 40 (2004) 1719-1728 (recalled, not read).

#[cfg(feature = "figure")]
pub(super) mod figure;

use super::bicoherence::{Bicoherence, BicoherencePlane, parameters};
use super::detector::Detector;
use super::subject::Subject;
use crate::finding::{
    Abstention, Applies, Decides, Decision, Family, Finding, LookedAt, Method, Needs, Number,
};

static METHOD: Method = Method {
    name: "bicoherence-op",
    title: "Bicoherence of the OP",
    source: "after Choudhury, Shah, Thornhill, Automatica 40 (2004) 1719-1728 (recalled, not read), \
             applied to the OP alone by us",
    statistic: "NLI",
    rule: "nonlinear if NGI is above the threshold 0.001 and NLI at least 0.01, or the cubic coupling \
           is significant",
    applies: Applies::AnyLoop,
    decides: Decides::Nonlinearity,
    needs: Needs::Op,
    family: Family::HigherOrder,
    explains_oscillation: false,
};

/// The same test of nonlinearity on the OP alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BicoherenceOp(
    /// Parameters. The parameter for the ellipse has no effect.
    pub Bicoherence,
);

impl BicoherenceOp {
    /// The bicoherence of the OP.
    ///
    /// # Errors
    /// If the OP does not move or the segment is too short.
    pub fn run(&self, subject: &Subject<'_>) -> Result<BicoherencePlane, Abstention> {
        subject.check(&METHOD)?;
        self.0.plane(&subject.segment.op, subject.period)
    }
}

impl Detector for BicoherenceOp {
    fn method(&self) -> &'static Method {
        &METHOD
    }

    fn parameters(&self) -> Vec<Number> {
        parameters(&self.0)
    }

    fn look(&self, subject: &Subject<'_>) -> Result<Finding, Abstention> {
        let plane = self.run(subject)?;
        let decision = if plane.nonlinear { Decision::Nonlinear } else { Decision::Linear };
        let (limit, says) = (self.0.nli_limit, plane.says(&self.0));
        let finding = Finding::new(&METHOD, decision, plane.nli, limit, says, plane.numbers());
        Ok(Finding { looked_at: Some(LookedAt::new(plane)), ..finding })
    }
}
