//! Sticking control valves.
#![deny(unsafe_code)]

pub mod bands;
mod error;
pub mod stem;
pub mod valve;

pub use bands::Bands;
pub use error::{Error, Result};
