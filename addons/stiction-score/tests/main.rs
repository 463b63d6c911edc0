//! The tests of `stiction-score`, in one program: linking is what takes long.

mod fit;
#[path = "../../../crates/stiction-report/tests/html/mod.rs"]
mod html;
mod scoreboard;
