//! What is asked of a segment before its valve is judged: do OP and PV belong together, and does the PV respond?

use super::no_response::{self, Rest};
use super::relation::{Mismatch, Relation};
use super::verdict::Verdict;
use super::weighing::Weighing;
use crate::recording::Segment;
use crate::recording::fitness::Fitness;

/// The answers.
#[derive(Debug, Clone, Default)]
pub(super) struct Belonging<'a> {
    segment: Option<&'a Segment>,
    /// Whether a measured valve position is to be followed.
    measured: bool,
    /// Whether OP and PV belong together.
    pub relation: Option<Relation>,
    /// Where the PV rests while the OP travels.
    pub rest: Option<Rest>,
}

impl<'a> Belonging<'a> {
    /// Asks a segment; `measured` if a valve position is recorded that can be judged.
    pub fn of(segment: &'a Segment, measured: bool) -> Self {
        let relation = Relation::of(segment);
        let rest = Rest::of(segment).filter(|_| relation.mismatch.is_none());
        Self { segment: Some(segment), measured, relation: Some(relation), rest }
    }

    /// What the mistake is called, if the verdict is that the columns are mistaken.
    pub fn ends(&self) -> Option<&'static str> {
        self.segment.filter(|segment| segment.pv.is_some())?;
        self.relation.as_ref()?.ends(self.measured).map(Mismatch::name)
    }

    /// The verdict, where one of the answers ends the judgement. A PV that does not respond goes first only where the
    /// columns belong together; a stem that was seen to move is followed whatever the rest says.
    pub fn verdict(
        &self,
        weighing: Option<&Weighing>,
        fitness: &Fitness,
        preliminary: &Verdict,
    ) -> Option<Verdict> {
        let segment = self.segment.filter(|segment| segment.pv.is_some())?;
        if let Some(verdict) =
            self.relation.as_ref().and_then(|r| r.verdict(preliminary, self.measured))
        {
            return Some(verdict);
        }
        let (rest, step) = (self.rest.as_ref(), segment.sample_time);
        no_response::verdict(rest, step, weighing, fitness, preliminary)
    }
}
