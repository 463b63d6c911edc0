//! OP, PV, SP, VP and mode of a loop over time, as recorded by a plant, and their processing.
//!
//! * [`Recording`]: the exported signals, each with its own times and qualities;
//! * [`Masked`]: values that are no measurements, such as -9999;
//! * [`ByHand`]: times in which an operator set the OP;
//! * [`Grid`]: its automatic segments on a regular grid, with all repairs;
//! * [`restart`]: runs of a clock that begins again;
//! * [`fitness`]: whether the data suffice for a diagnosis;
//! * [`Understood`]: how a file was interpreted, as a small table.

mod by_hand;
mod channel;
mod doubt;
pub mod fitness;
pub mod grid;
mod loop_type;
mod masked;
mod plant_time;
pub mod restart;
pub mod rhythm;
mod split;
pub mod understood;

pub use by_hand::{ByHand, FEWEST_TURNS, KnownBy, Set};
pub use channel::{Channel, Quality, Range, RangeSource};
pub use doubt::Doubt;
pub use fitness::Fitness;
pub use grid::{Grid, GridOptions, GridRepair, Interpolation, RepairKind, Segment};
pub use loop_type::{Dynamics, LoopType};
pub use masked::{Masked, MaskedKind, MaskedSample};
pub use plant_time::PlantTime;
pub use restart::{Repeated, Restart, Rows, Runs};
pub use understood::Understood;

use crate::error::{Error, Result};

/// The controller's mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// It controls to a set point of the operator.
    Automatic,
    /// It controls to a set point that another controller writes.
    Cascade,
    /// The operator sets the OP.
    Manual,
    /// Not recorded, not understood, or something else, such as initialising or tracking.
    Other,
}

impl Mode {
    /// Whether the controller was in command of the valve.
    pub fn is_closed(self) -> bool {
        matches!(self, Self::Automatic | Self::Cascade)
    }
}

/// The mode over time; each holds until the next.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Modes {
    /// Time, s on the recording's clock.
    pub time: Vec<f64>,
    /// The mode from then on.
    pub modes: Vec<Mode>,
}

/// The columns of a file from which a recording was read; nothing is known of one in memory.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Columns {
    /// Name of the column of times.
    pub time: Option<String>,
    /// The notation of its times, in words.
    pub time_format: String,
    /// Their zone, in words.
    pub zone: String,
    /// Name of the column or tag of the OP.
    pub op: Option<String>,
    /// That of the PV.
    pub pv: Option<String>,
    /// That of the SP.
    pub sp: Option<String>,
    /// That of the VP.
    pub vp: Option<String>,
    /// That of the mode.
    pub mode: Option<String>,
}

/// A loop recorded by a plant.
///
/// Every channel has its own times, because historians that store only changes give each tag its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Tag of the loop.
    pub name: String,
    /// The controlled quantity.
    pub loop_type: LoopType,
    /// Time zero of the clock as seconds since 1970-01-01 UTC, if it is known.
    pub start: Option<f64>,
    /// The clock in which its times are shown.
    pub plant_time: PlantTime,
    /// The columns from which it was read.
    pub columns: Columns,
    /// Controller output, percent unless its range says otherwise.
    pub op: Channel,
    /// Process value, in its own units.
    pub pv: Option<Channel>,
    /// Set point, in the units of the PV.
    pub sp: Option<Channel>,
    /// Measured valve position, percent unless its range says otherwise.
    pub vp: Option<Channel>,
    /// The controller's mode; without it the loop counts as always in automatic.
    pub mode: Option<Modes>,
    /// Remarks of the file's reader to the user.
    pub notes: Vec<String>,
}

impl Recording {
    /// A recording at a fixed sample time, in s, that starts at time zero.
    ///
    /// Samples that are NaN count as missing. An infinite sample is an error, as is a sample time
    /// that is not above 0, and a channel with no sample.
    pub fn regular(
        name: impl Into<String>,
        sample_time: f64,
        op: &[f64],
        pv: Option<&[f64]>,
        sp: Option<&[f64]>,
    ) -> Result<Self> {
        crate::error::positive("the sample time", sample_time)?;
        let channel = |signal: &'static str, values: &[f64]| {
            if values.len() != op.len() {
                return Err(Error::Length {
                    name: signal,
                    found: values.len(),
                    expected: op.len(),
                });
            }
            let time = (0..values.len()).map(|k| k as f64 * sample_time).collect();
            Channel::new(signal, time, values.to_vec())
        };
        Ok(Self {
            name: name.into(),
            loop_type: LoopType::Unknown,
            start: None,
            plant_time: PlantTime::default(),
            columns: Columns::default(),
            op: channel("OP", op)?,
            pv: pv.map(|pv| channel("PV", pv)).transpose()?,
            sp: sp.map(|sp| channel("SP", sp)).transpose()?,
            vp: None,
            mode: None,
            notes: vec![],
        })
    }
}
