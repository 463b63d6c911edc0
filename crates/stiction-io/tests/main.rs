//! The tests of `stiction-io`, in one program: linking is what takes long.

mod corpus;
mod damaged;
mod docs;
mod level5;
mod matlab;
mod naming;
mod parquet;
mod reading;
mod real_recordings;
mod scenario;
mod table;
mod wide;
mod written;
