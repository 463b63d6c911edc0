//! Errors of this crate, in sentences.

/// A reason why a figure could not be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A figure without panels.
    #[error("the figure \"{figure}\" has no panels")]
    NoPanels {
        /// Title of the figure.
        figure: String,
    },
    /// A panel without series has no axes.
    #[error("panel {panel} has no series")]
    NoSeries {
        /// Index of the panel, from 0.
        panel: usize,
    },
    /// A series without samples.
    #[error("series \"{series}\" of panel {panel} has no samples")]
    NoSamples {
        /// Index of the panel, from 0.
        panel: usize,
        /// Label of the series.
        series: String,
    },
    /// The coordinates of a series differ in number.
    #[error("series \"{series}\" of panel {panel} has {x} x values, but {y} y values")]
    Length {
        /// Index of the panel, from 0.
        panel: usize,
        /// Label of the series.
        series: String,
        /// Number of x values.
        x: usize,
        /// Number of y values.
        y: usize,
    },
    /// A sample that cannot be drawn: NaN, infinite, beyond 1e300, or not above zero on a logarithmic axis.
    #[error(
        "{axis} value {index} of series \"{series}\" of panel {panel} is {value}, but must be \
         finite and at most 1e300 in magnitude, and above zero on a logarithmic axis"
    )]
    Sample {
        /// Index of the panel, from 0.
        panel: usize,
        /// Label of the series.
        series: String,
        /// `x` or `y`.
        axis: char,
        /// Index of the first offending sample, from 0.
        index: usize,
        /// The value found there.
        value: f64,
    },
    /// A map that cannot be drawn.
    #[error("the map of panel {panel} {problem}")]
    Heat {
        /// Index of the panel, from 0.
        panel: usize,
        /// The fault.
        problem: String,
    },
    /// An annotation that cannot be drawn.
    #[error(
        "annotation {index} of panel {panel} contains {value}, but its coordinates must be \
         finite and at most 1e300 in magnitude"
    )]
    Annotation {
        /// Index of the panel, from 0.
        panel: usize,
        /// Index of the annotation, from 0.
        index: usize,
        /// The offending coordinate.
        value: f64,
    },
    /// An axis range that is empty, reversed or not finite.
    #[error(
        "the {axis} range of panel {panel} is {from} to {to}, but must rise from one finite \
         number to a clearly larger one"
    )]
    Range {
        /// Index of the panel, from 0.
        panel: usize,
        /// `x` or `y`.
        axis: char,
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
    },
    /// A size or count of the figure out of range.
    #[error("{name} of the figure is {value}, but must be {allowed}")]
    Size {
        /// Name of the field.
        name: &'static str,
        /// The given value.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// The picture could not be turned into pixels.
    #[error("the picture could not be encoded as PNG: {0}")]
    Png(String),
}
