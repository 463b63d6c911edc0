//! Interprets cells once the role of their column is known.

pub mod mode;
pub mod number;
pub mod quality;
pub mod range;
