//! The tests of `stiction-fmu`, in one program: linking is what takes long.

mod common;
mod description;
mod exchange;
mod identity;
mod library;
mod sequences;
mod states;
mod wrong_use;
