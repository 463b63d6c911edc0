//! Conversion between S and J and the static and dynamic friction bands: the only place for it.

use crate::error::{Error, Result, non_negative};

/// Stiction of a valve, in percent of span.
///
/// Two equivalent pairs describe it:
///
/// * `S`, stick band plus dead band, and `J`, the slip jump (equal to the stick band);
/// * `fs`, the static friction band, and `fd`, the dynamic friction band,
///
/// with `fs = (S + J) / 2`, `fd = (S - J) / 2`, `S = fs + fd`, `J = fs - fd`.
/// A stem at rest breaks away when the net spring force `u - x` exceeds `fs`; a moving stem trails
/// the input by `fd`. The dead band alone is `S - J = 2 fd`.
///
/// `J > S` (a slip that overshoots the input) gives a negative `fd`. The pair is valid here. A model that does not
/// allow it reports an error when it is built.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Bands {
    /// Stick band plus dead band `S`, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "S"))]
    s: f64,
    /// Slip jump `J`, percent of span.
    #[cfg_attr(feature = "serde", serde(rename = "J"))]
    j: f64,
    #[cfg_attr(feature = "serde", serde(skip))]
    fs: f64,
    #[cfg_attr(feature = "serde", serde(skip))]
    fd: f64,
}

impl Bands {
    /// No friction at all: `S = J = 0`.
    pub const NONE: Self = Self { s: 0.0, j: 0.0, fs: 0.0, fd: 0.0 };

    /// From `S` and `J`, both in percent of span.
    ///
    /// # Errors
    /// If either is negative, NaN or infinite.
    pub fn from_s_j(s: f64, j: f64) -> Result<Self> {
        non_negative("S", s)?;
        non_negative("J", j)?;
        Ok(Self { s, j, fs: (s + j) / 2.0, fd: (s - j) / 2.0 })
    }

    /// From the static band `fs` and the dynamic band `fd`, both in percent of span.
    ///
    /// # Errors
    /// If `fs` is negative or `|fd| > fs` (then `S` or `J` would be negative), or either is NaN or
    /// infinite.
    pub fn from_fs_fd(fs: f64, fd: f64) -> Result<Self> {
        non_negative("fs", fs)?;
        if !(fd.abs() <= fs) {
            let allowed = format!("between {} and fs = {fs}", -fs);
            return Err(Error::Parameter { name: "fd", value: fd, allowed });
        }
        Ok(Self { s: fs + fd, j: fs - fd, fs, fd })
    }

    /// Stick band plus dead band `S`, percent of span.
    pub fn s(&self) -> f64 {
        self.s
    }

    /// Slip jump `J`, percent of span.
    pub fn j(&self) -> f64 {
        self.j
    }

    /// Static friction band `fs = (S + J) / 2`, percent of span.
    pub fn fs(&self) -> f64 {
        self.fs
    }

    /// Dynamic friction band `fd = (S - J) / 2`, percent of span; negative when `J > S`.
    pub fn fd(&self) -> f64 {
        self.fd
    }

    /// Whether a stem at rest breaks away under the net spring force `e = u - x`: `|e| > fs`.
    ///
    /// Every model uses this one condition. The published models write it in algebraically equal forms. Exactly at
    /// the threshold these differ by rounding.
    #[inline(always)]
    pub(crate) fn breaks(&self, e: f64) -> bool {
        e.abs() > self.fs
    }

    /// These bands, if `J <= S`: for models in which a slip cannot overshoot the input.
    pub(crate) fn without_overshoot(self) -> Result<Self> {
        if self.j <= self.s {
            Ok(self)
        } else {
            let allowed = format!("at most S = {} for this model", self.s);
            Err(Error::Parameter { name: "J", value: self.j, allowed })
        }
    }
}
