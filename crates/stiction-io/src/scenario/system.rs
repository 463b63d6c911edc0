//! What a scenario simulates.

use stiction_model::closed_loop::{Cascade, ClosedLoop, OpenLoop};

/// What a scenario simulates.
#[derive(Debug, Clone, PartialEq)]
pub enum System {
    /// A valve on a test signal.
    OpenLoop(OpenLoop),
    /// A control loop.
    ClosedLoop(Box<ClosedLoop>),
    /// A slave loop under a master.
    Cascade(Box<Cascade>),
}

impl System {
    /// Refuses what concerns several of its settings at once.
    pub(super) fn check(&self) -> stiction_model::Result<()> {
        match self {
            Self::OpenLoop(system) => {
                system.input.source(system.sample_time, system.samples).map(|_| ())
            }
            Self::ClosedLoop(system) => system.check(),
            Self::Cascade(system) => system.check(),
        }
    }
}
