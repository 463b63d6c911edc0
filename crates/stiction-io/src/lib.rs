//! Reading and writing for [`stiction`]: scenarios in TOML, signals in CSV.
//!
//! Nothing read here is silently coerced, dropped or filled in: what cannot be understood is an
//! error that names the file, the line or row, the key or column, and what would be right.
#![forbid(unsafe_code)]

mod budget;
mod built_in;
mod error;
mod fields;
pub mod matlab_file;
pub mod parquet_file;
pub mod scenario;
pub mod sheet;
pub mod table;

pub use error::{Error, Result};
pub use scenario::Scenario;
pub use sheet::Sheet;
pub use table::Table;
