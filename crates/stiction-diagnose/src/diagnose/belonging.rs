//! Checks of a segment before its valve is judged: do OP and PV belong together, and does the PV respond?

use super::no_response::Rest;
use super::relation::{Mismatch, Relation};
use crate::recording::Segment;

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

    /// The mistake in the columns that ends the judgement, with its words. With a measured valve position it has to be one
    /// of the OP.
    pub fn mistake(&self) -> Option<(Mismatch, &str)> {
        self.segment.filter(|segment| segment.pv.is_some())?;
        let relation = self.relation.as_ref()?;
        Some((relation.ends(self.measured)?, &relation.because))
    }

    /// Whether OP and PV seem to belong together.
    pub fn belong(&self) -> bool {
        self.relation.as_ref().is_none_or(|relation| relation.mismatch.is_none())
    }
}
