//! What a window of a recording says about its valve, as numbers that do not depend on units, offsets,
//! directions or the time scale.

pub mod model;

use crate::detect::Abstention;
use crate::recording::Stretch;

/// A number that evidence consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Feature {
    /// Its name, such as `arx_gain`.
    pub name: &'static str,
    /// What it is, a short sentence.
    pub meaning: &'static str,
    /// What it looks at.
    pub line: Line,
    /// 1 if more of it can only speak for stiction, -1 if only against, 0 if either.
    pub monotone: i8,
}

/// The independent lines of evidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Line {
    /// How much better a sticking valve explains the PV than one that follows.
    Model,
    /// Samples in which OP and PV move differently.
    Patterns,
    /// The shape of the OP's wave; needs no PV.
    OpShape,
    /// The shape of the PV's or error's wave.
    PvShape,
    /// Whether the PV answers the OP at all.
    Response,
    /// What else happens in the loop: set point, limits, resolution, record length.
    Circumstances,
}

/// All features, in the order of [`Evidence::values`].
pub const FEATURES: &[Feature] = &[];

/// What a window says.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// One value for each of [`FEATURES`]; NaN where it cannot be measured.
    pub values: Vec<f64>,
    /// Span of the OP without its slow part, percent of span: the scale of S.
    pub op_span: f64,
    /// Dominant period, s.
    pub period_s: f64,
}

impl Evidence {
    /// The evidence in a stretch, or a window of one.
    ///
    /// # Errors
    /// If there is nothing to measure, as with an OP that never moves.
    pub fn of(_stretch: &Stretch) -> Result<Self, Abstention> {
        Err(Abstention("not measured".to_owned()))
    }
}
