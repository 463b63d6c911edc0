//! Models identified from recorded loops: linear process models, and models of the valve before the process.
//!
//! * [`arx`]: the PV from its past and the input.
//! * [`controller`]: the controller of the OP.
//! * [`fopdt`]: first order plus dead time.
//! * [`hammerstein`]: how much better a sticking valve explains the PV, with its controls.
//! * [`information`]: the information of a recording about S.
//! * [`lagged_position`]: whether a valve sticks, from a recorded position that lags.
//! * [`position`]: valve models fitted to a recorded valve position.
//! * [`process`]: first order or integrating, under correlated disturbances.
//! * [`physical`]: a stem with friction fitted to a recorded valve position.
//! * [`cycle_closed_form`]: S and J from period and amplitude for a known loop.
//!
//! The published fits of a valve before a process are in the methods.

pub mod arx;
pub mod controller;
pub mod cycle_closed_form;
pub mod fopdt;
pub mod hammerstein;
pub mod information;
pub mod lagged_position;
mod output_error;
pub mod physical;
pub mod position;
pub mod process;
pub(crate) mod slips;
