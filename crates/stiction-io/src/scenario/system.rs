//! The simulated system of a scenario.

use stiction_model::closed_loop::{Cascade, ClosedLoop, OpenLoop};

/// The simulated system.
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
    /// Refuses settings that do not fit together.
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
