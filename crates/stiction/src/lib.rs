//! Sticking control valves: models with known truth, and the loops around them.
#![deny(unsafe_code)]

pub mod bands;
pub mod closed_loop;
mod error;
mod simd;
pub mod stem;
pub mod valve;

pub use bands::Bands;
pub use error::{Error, Result};
