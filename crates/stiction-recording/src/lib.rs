//! A control loop as a plant recorded it, and the data that every method needs.
//!
//! * [`recording`]: the signals, their grid, and whether the data are fit for a diagnosis.
//! * [`oscillation`]: whether a loop cycles, its regularity and period.
//! * [`finding`]: the description of a method and its result.
//! * [`series`]: moments, correlation, spectra, crossings.
//! * [`estimate`]: a number with an interval.
//! * [`spoken`]: numbers and times as text.
//!
//! Who reads a file needs this crate and no model of the verdict. It uses only [`stiction_model`]. It must not use
//! detectors, file formats or figures, which build on it. Like all of the library it only computes: no files, no clock,
//! no panics on bad input.
#![forbid(unsafe_code)]

pub mod estimate;
pub mod finding;
pub mod oscillation;
pub mod recording;
pub mod series;
pub mod spoken;

pub use stiction_model::Number;
stiction_model::written_by_name!(
    finding::Decision,
    finding::Family,
    oscillation::OscillationBasis,
    recording::KnownBy,
    recording::LoopType,
    recording::MaskedKind,
    recording::RangeSource,
    recording::fitness::Class,
    recording::fitness::MeasureId,
);
use stiction_model::error;
