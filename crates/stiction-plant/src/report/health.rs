//! The health of the data of a loop.

use crate::store::table::{named_cell, written_by_name};
use crate::store::window::WindowRow;
use stiction_diagnose::diagnose::Silence;

/// A service factor below which a loop counts as always in manual, percent.
pub const MANUAL_BELOW: f64 = 5.0;

/// The health of the data of a loop over a week.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Health {
    /// No file has a sample of it.
    NoData,
    /// All windows have an error.
    Errors,
    /// The PV does not move in the last window, or is frozen while the OP travels.
    Frozen,
    /// The controller was hardly ever in automatic.
    Manual,
    /// No window is fit for a verdict.
    Unfit,
    /// Windows can be judged.
    #[default]
    Good,
}

named_cell!(Health);
written_by_name!(Health);

impl Health {
    /// All of them, the worst first.
    pub const ALL: [Self; 6] =
        [Self::NoData, Self::Errors, Self::Frozen, Self::Manual, Self::Unfit, Self::Good];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoData => "no data",
            Self::Errors => "errors",
            Self::Frozen => "dead or frozen",
            Self::Manual => "always in manual",
            Self::Unfit => "not fit",
            Self::Good => "good",
        }
    }

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
