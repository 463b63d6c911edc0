//! The tests of `stiction-figure`, in one program: linking is what takes long.

mod figure;
mod page;
