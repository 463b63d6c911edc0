//! Models identified from recorded loops: linear ones of the process, and of the valve before it.
//!
//! * [`arx`]: the PV by its past and the input.
//! * [`controller`]: which controller made the OP.
//! * [`fopdt`]: first order plus dead time.
//! * [`hammerstein`]: how much better a sticking valve explains the PV, with its controls.
//! * [`information`]: what a recording can tell of any S at all.
//! * [`lagged_position`]: whether a valve sticks, by a recorded position that lags.
//! * [`position`]: valve models fitted to a recorded valve position.
//! * [`process`]: first order or integrating, under disturbances with a memory.
//! * [`physical`]: a stem with friction fitted to a recorded valve position.
//! * [`cycle_closed_form`]: S and J from period and amplitude where the loop is known.
//!
//! The published fits of a valve before a process are among the methods.

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
