//! A plant of control loops over time.
//!
//! ```text
//! plant.toml ──> inputs (files ──> loops and their days) ──> scan ──> store (a row and a trace per window)
//!                                                   day (cutting) ──┘        └──> groups
//! log.toml ──> ranking (a row per loop and week; change, action) ──> report (page, orders, tables)
//! ```
//!
//! The unit of everything is the [`window`]: one loop, one day of the plant. A [`store`] of Parquet files keeps the judged windows.
//! A [`scan()`] judges the windows that are not in it.
#![forbid(unsafe_code)]

pub mod day;
pub mod demo;
mod error;
pub mod groups;
pub mod log;
pub mod overrides;
pub mod plant_file;
pub mod propose;
pub mod report;
pub mod scan;
pub mod store;
pub mod summary;
pub mod trial;
pub mod unknown;
pub mod week;

pub use error::{Error, Result};
pub use plant_file::PlantFile;
// What others use is found by its own name, in whichever room it is.
pub use report::{action, health, orders, page, ranking, treemap};
pub use scan::take::take;
pub use scan::{ScanOptions, inputs, judge, samples, scan};
pub use store::window::WindowRow;
pub use store::{Store, parquet_file, table, trace, window};
