//! The roles of a sheet's columns, recognised or given by the user.

pub mod layout;
mod mapping;
pub mod options;
pub mod role;
mod settings;
