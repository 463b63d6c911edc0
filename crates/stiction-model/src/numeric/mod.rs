//! Numerical methods of small, fixed size: the same bits on every machine, and errors that report where they fail.

pub mod golden;
pub mod least_squares;
pub mod nelder_mead;
pub(crate) mod polynomial;
pub(crate) mod radau;
pub mod roots;
pub mod summary;
