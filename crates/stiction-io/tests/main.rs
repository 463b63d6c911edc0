//! The tests of `stiction-io`, in one program: linking is what takes long.

mod corpus;
mod damaged;
mod docs;
mod layouts;
mod level5;
mod matlab;
mod naming;
mod numbers;
mod parquet;
mod reading;
mod real_recordings;
mod scenario;
mod table;
mod times;
mod wide;
#[cfg(feature = "spreadsheet")]
mod workbook;
mod written;
