//! The health of the data of a loop.

use crate::store::window::WindowRow;
use stiction_diagnose::diagnose::Silence;
use stiction_model::{always_written_by_name, named};

/// A service factor below which a loop counts as always in manual, percent.
pub const MANUAL_BELOW: f64 = 5.0;

named! {
    /// The health of the data of a loop over a week, the worst first.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    pub enum Health {
        /// No file contains a sample of the tag.
        NoData = "no data",
        /// All windows have an error.
        Errors = "errors",
        /// The PV does not move in the last window, or is frozen while the OP travels.
        Frozen = "dead or frozen",
        /// The controller was hardly ever in automatic.
        Manual = "always in manual",
        /// No window is fit for a verdict.
        Unfit = "not fit",
        /// Windows can be judged.
        #[default]
        Good = "good",
    }
}

always_written_by_name!(Health);

impl Health {
    /// From the windows of a week, in order of time.
    pub fn of(windows: &[&WindowRow]) -> Self {
        let Some(last) = windows.last() else { return Self::NoData };
        let all = |is: fn(&WindowRow) -> bool| windows.iter().all(|row| is(row));
        let frozen = Some(Silence::Frozen.name());
        match () {
            () if all(|row| row.error.is_some()) => Self::Errors,
            () if last.pv_moves == Some(false) || last.no_response.as_deref() == frozen => {
                Self::Frozen
            }
            () if all(|row| {
                row.error.is_some() || row.auto_share.is_some_and(|share| share < MANUAL_BELOW)
            }) =>
            {
                Self::Manual
            }
            () if !windows.iter().any(|row| row.is_judged() && row.probability.is_some()) => {
                Self::Unfit
            }
            () => Self::Good,
        }
    }
}
