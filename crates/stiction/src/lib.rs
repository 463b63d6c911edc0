#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

#[cfg(feature = "csv")]
mod found;
#[cfg(feature = "csv")]
mod read;

/// Recipes that run, for the most frequent tasks.
#[cfg(all(feature = "csv", feature = "score"))]
#[doc = include_str!("../COOKBOOK.md")]
pub mod _cookbook {}

// The guide for Rust programmers is a page outside this crate. Its examples are tested here.
#[cfg(all(doctest, feature = "csv", feature = "report"))]
#[doc = include_str!("../../../docs/guides/rust.md")]
mod _guide {}

#[cfg(feature = "csv")]
pub use found::Found;
#[cfg(all(feature = "csv", feature = "report"))]
pub use found::Report;
#[cfg(feature = "csv")]
pub use read::{Recordings, read, read_with};

#[cfg(feature = "serde")]
pub use stiction_model::finite;
pub use stiction_model::{Bands, Error, Number, Result};
pub use stiction_model::{bands, closed_loop, compensate, limit_cycle, stem, valve};

#[cfg(feature = "diagnose")]
pub use stiction_diagnose::{
    diagnose, evidence, finding, fit, fusion, identify, methods, oscillation, recording, series,
    spoken, valve_test, what_if,
};

#[cfg(feature = "population")]
pub use stiction_population as population;

#[cfg(feature = "csv")]
pub use stiction_io as io;

#[cfg(feature = "figure")]
pub use stiction_figure as figure;
#[cfg(feature = "figure")]
pub use stiction_model::drawing;

#[cfg(feature = "report")]
pub use stiction_report::{document, report, words};

#[cfg(feature = "score")]
pub use stiction_score::{self as score, scoreboard, suite};
