//! What the columns of a sheet mean: which is which signal of which loop, and what the user says of them.

pub mod layout;
mod mapping;
pub mod options;
pub mod role;
