//! Checks of a segment before its valve is judged: do OP and PV belong together, and does the PV respond?

use super::no_response::{self, Rest};
use super::relation::{Mismatch, Relation};
use super::verdict::Verdict;
use super::weighing::Weighing;
use crate::recording::Segment;
use crate::recording::fitness::Fitness;

/// The results of the checks.
#[derive(Debug, Clone, Default)]
pub(super) struct Belonging<'a> {
    segment: Option<&'a Segment>,
    /// Whether a measured valve position decides.
    measured: bool,
    /// Whether OP and PV belong together.
    pub relation: Option<Relation>,
    /// Where the PV rests while the OP travels.
    pub rest: Option<Rest>,
}

impl<'a> Belonging<'a> {
    /// Checks a segment; `measured` if a valve position is recorded that can be judged.
    pub fn of(segment: &'a Segment, measured: bool) -> Self {
        let relation = Relation::of(segment);
        let rest = Rest::of(segment).filter(|_| relation.mismatch.is_none());
        Self { segment: Some(segment), measured, relation: Some(relation), rest }
    }

    /// Name of the mistake, if the verdict is that the columns are mistaken.
    pub fn ends(&self) -> Option<&'static str> {
        self.segment.filter(|segment| segment.pv.is_some())?;
        self.relation.as_ref()?.ends(self.measured).map(Mismatch::name)
    }

    /// The verdict, if a check ends the judgement. A PV that does not respond goes first only if the columns belong
    /// together. A stem that moved decides before both checks.
    pub fn verdict(
        &self,
        weighing: Option<&Weighing>,
        fitness: &Fitness,
        not_weighed: &Verdict,
    ) -> Option<Verdict> {
        let segment = self.segment.filter(|segment| segment.pv.is_some())?;
        if let Some(verdict) =
            self.relation.as_ref().and_then(|r| r.verdict(not_weighed, self.measured))
        {
            return Some(verdict);
        }
        let (rest, step) = (self.rest.as_ref(), segment.sample_time);
        no_response::verdict(rest, step, weighing, fitness, not_weighed)
    }
}
