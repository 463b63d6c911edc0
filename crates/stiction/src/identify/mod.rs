//! Models identified from recorded loops: linear ones of the process, and of the valve before it.

mod arx;
pub mod fopdt;
pub mod hammerstein;
mod least_squares;
mod output_error;
pub mod position;
mod slips;
