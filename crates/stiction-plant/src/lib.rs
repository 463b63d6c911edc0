//! A plant of control loops over time.
//!
//! ```text
//! plant.toml ──> inputs (files ──> loops and their days) ──> scan ──> store (a row and a trace a window)
//!                                                   day (cutting) ──┘        └──> groups
//! log.toml ──> ranking (a row a loop of a week; change, action) ──> report (page, orders, tables)
//! ```
//!
//! The unit of everything is the [`window`]: one loop, one day of the plant. What was judged is kept in a
//! [`store`] of Parquet files; a [`scan()`] judges what is not there yet.
#![forbid(unsafe_code)]

pub mod action;
pub mod change;
pub mod day;
pub mod demo;
mod error;
mod files;
pub mod groups;
pub mod health;
pub mod inputs;
pub mod judge;
pub mod log;
pub mod orders;
pub mod page;
pub mod parquet_file;
pub mod plant_file;
pub mod propose;
pub mod ranking;
pub mod report;
pub mod samples;
pub mod scan;
mod spill;
pub mod store;
pub mod summary;
pub mod table;
pub mod take;
pub mod trace;
pub mod treemap;
pub mod trial;
pub mod week;
pub mod window;

pub use error::{Error, Result};
pub use plant_file::PlantFile;
pub use scan::{ScanOptions, scan};
pub use store::Store;
pub use take::take;
pub use window::WindowRow;
