//! A periodic motion of a loop, from either method.

use nalgebra::Complex;

crate::named! {
    /// The method that found a cycle.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Method {
        /// Harmonic balance with the describing function: OP and VP are treated as sines.
        DescribingFunction = "describing function",
        /// The exact flow of the loop from slip to slip.
        Exact = "exact",
    }
}

crate::written_by_name!(Method);

/// A number for each signal of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Swing {
    /// Of the OP, percent of span.
    pub op: f64,
    /// Of the VP, percent of span.
    pub vp: f64,
    /// Of the PV, in its units.
    pub pv: f64,
}

/// A limit cycle.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Cycle {
    /// The method that found the cycle.
    pub method: Method,
    /// Period, s.
    pub period_s: f64,
    /// Half of the peak-to-peak values.
    pub half_pp: Swing,
    /// The middle between the extremes.
    pub middle: Swing,
    /// Whether nearby motions approach the cycle. A member of a continuous family can only attract towards the family:
    /// then this is `true`, and [`Cycle::multipliers`] contain a 1.
    pub stable: bool,
    /// The Floquet multipliers, the largest first: the share of a small deviation that remains after one period.
    /// Empty if the method gives none.
    #[cfg_attr(feature = "serde", serde(serialize_with = "as_pairs"))]
    #[cfg_attr(feature = "serde", schemars(with = "Vec<[f64; 2]>"))]
    pub multipliers: Vec<Complex<f64>>,
    /// Slips of the stem in a period.
    pub slips: usize,
}

/// Complex numbers as pairs of real and imaginary part.
#[cfg(feature = "serde")]
fn as_pairs<S: serde::Serializer>(all: &[Complex<f64>], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(all.iter().map(|number| [number.re, number.im]))
}
