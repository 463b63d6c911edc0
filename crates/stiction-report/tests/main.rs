//! The tests of `stiction-report`, in one program: linking is what takes long.

mod contradictions;
mod diagnosis;
mod html;
mod report;
mod verdict;
