//! Reading and writing for stiction: scenarios in TOML, signals in CSV, recordings of plants as
//! historians export them.
//!
//! Nothing read here is silently coerced, dropped or filled in: what cannot be understood is an
//! error that names the file, the line or row, the key or column, and what would be right.
#![forbid(unsafe_code)]

mod budget;
mod built_in;
pub mod bytes;
mod content;
pub mod csv_sheet;
mod encoding;
mod error;
mod fields;
pub mod fitted;
mod instrument;
pub mod join;
pub mod layout;
mod leftover;
mod mapping;
#[cfg(feature = "matlab")]
pub mod matlab_file;
mod mode;
pub mod number;
pub mod options;
pub mod overrides;
#[cfg(feature = "parquet")]
pub mod parquet_file;
#[cfg(feature = "parquet")]
pub mod parted;
mod quality;
mod range;
pub mod reading;
mod remedy;
pub mod role;
pub mod scenario;
pub mod sheet;
pub mod summary;
pub mod table;
pub mod timestamp;
pub mod whole;

pub use error::{Error, Result};
pub use options::ReadOptions;
pub use overrides::Overrides;
pub use reading::Reading;
pub use remedy::{Remedy, Wording};
pub use scenario::Scenario;
pub use sheet::Sheet;
pub use summary::Summary;
pub use table::Table;
