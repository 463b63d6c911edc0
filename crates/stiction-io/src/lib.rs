//! Reading and writing for stiction: scenarios in TOML, signals in CSV, recordings of plants as historians export
//! them.
//!
//! Nothing is silently coerced, dropped or filled in. Unreadable content is an error with the file, the line or row,
//! the key or column, and the remedy.
#![forbid(unsafe_code)]

mod budget;
pub mod bytes;
mod cells;
mod columns;
pub mod csv;
mod error;
// Also for the overrides of a plant.
#[doc(hidden)]
pub mod fields;
#[cfg(feature = "matlab")]
pub mod matlab;
mod names;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod reading;
mod remedy;
pub mod scenario;
pub mod sheet;
pub mod table;
pub mod texts;
pub mod timestamp;
pub mod whole;
#[cfg(feature = "spreadsheet")]
pub mod workbook;

pub use cells::{mode, number, quality};
pub use columns::options::ReadOptions;
pub use columns::{layout, options, role};
pub use error::{Error, Result};
pub use reading::Reading;
#[cfg(feature = "parquet")]
pub use reading::parted;
pub use reading::summary::Summary;
pub use reading::{join, summary};
pub use remedy::{Remedy, Wording};
pub use scenario::Scenario;
pub use sheet::Sheet;
pub use table::Table;
pub use texts::Texts;
