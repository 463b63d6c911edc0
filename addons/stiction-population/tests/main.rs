//! The tests of `stiction-population`, in one program: linking is what takes long.

mod diagnose;
mod few_slips;
mod grades;
mod invented_week;
mod long_records;
mod masked;
mod measured_position;
mod monotone;
mod relation;
mod textbook;
mod verdict;
