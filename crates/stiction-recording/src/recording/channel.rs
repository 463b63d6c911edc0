//! One signal of a recording.

use super::MaskedSample;
use crate::error::{Error, Result};
use stiction_model::named;

/// Quality of a sample, from the historian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quality {
    /// Good, or without a quality.
    Good,
    /// Doubtful; its value is used, and counted as doubtful.
    Uncertain,
    /// Bad; its value is not used.
    Bad,
    /// There is no value.
    Missing,
}

impl Quality {
    /// Whether the value of such a sample is used.
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Good | Self::Uncertain)
    }
}

named! {
    /// Source of a range.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum RangeSource {
        /// The user.
        Given = "given",
        /// The file.
        Metadata = "from the file",
        /// The unit in the file, which has a usual range.
        Assumed = "assumed from the unit",
        /// Guessed from the values.
        Estimated = "estimated",
    }
}

impl RangeSource {
    /// Whether neither the user nor the file states the range.
    pub fn is_guess(self) -> bool {
        matches!(self, Self::Assumed | Self::Estimated)
    }
}

/// The instrument range of a signal: the values at 0 % and 100 %.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", schemars(rename = "SignalRange"))]
pub struct Range {
    /// The value at 0 %.
    pub low: f64,
    /// The value at 100 %.
    pub high: f64,
    /// Source of the range.
    pub source: RangeSource,
    /// The narrowest and the widest plausible span, in the unit of the signal. If the range is known, both values equal
    /// the span of the range.
    pub spans: [f64; 2],
}

impl Range {
    /// A range; the ends are finite and `high` is above `low`.
    pub fn new(low: f64, high: f64, source: RangeSource) -> Result<Self> {
        crate::error::finite("the low end of the range", low)?;
        crate::error::require("the high end of the range", high, high > low, "above the low end")?;
        Ok(Self { low, high, source, spans: [high - low; 2] })
    }

    /// A range of which other spans are plausible, too, from the narrowest to the widest.
    ///
    /// # Errors
    /// As for [`Range::new`].
    pub fn among(low: f64, high: f64, source: RangeSource, spans: (f64, f64)) -> Result<Self> {
        let range = Self::new(low, high, source)?;
        let span = high - low;
        Ok(Self { spans: [spans.0.min(span), spans.1.max(span)], ..range })
    }

    /// A value as percent of the range.
    pub fn percent(&self, value: f64) -> f64 {
        // Values already in percent are returned bit for bit.
        if self.low == 0.0 && self.high == 100.0 {
            return value;
        }
        (value - self.low) / (self.high - self.low) * 100.0
    }
}

/// One signal: samples with times and qualities, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Times, s on the recording's clock; they need not ascend.
    pub time: Vec<f64>,
    /// Values; NaN where the quality is not usable.
    pub values: Vec<f64>,
    /// Their qualities.
    pub quality: Vec<Quality>,
    /// Unit, where the file names one.
    pub unit: Option<String>,
    /// Instrument range, where it is known.
    pub range: Option<Range>,
    /// The samples that are bad because their values are no measurements, in any order.
    pub masked: Vec<MaskedSample>,
}

impl Channel {
    /// A channel of good samples, those that are NaN missing. `signal` names it in errors.
    ///
    /// # Errors
    /// Without any sample, if times and values differ in number, if a time is not finite, or if a
    /// value is infinite.
    pub fn new(signal: &'static str, time: Vec<f64>, values: Vec<f64>) -> Result<Self> {
        let quality = values
            .iter()
            .map(|v| if v.is_nan() { Quality::Missing } else { Quality::Good })
            .collect();
        Self::with_quality(signal, time, values, quality)
    }

    /// A channel with samples of the given qualities; values of unusable samples are dropped.
    ///
    /// # Errors
    /// As for [`Channel::new`], and if a usable sample is not a number.
    pub fn with_quality(
        signal: &'static str,
        time: Vec<f64>,
        mut values: Vec<f64>,
        quality: Vec<Quality>,
    ) -> Result<Self> {
        for found in [time.len(), quality.len()] {
            if found != values.len() {
                return Err(Error::Length { name: signal, found, expected: values.len() });
            }
        }
        if values.is_empty() {
            return Err(Error::Length { name: signal, found: 0, expected: 1 });
        }
        crate::error::all_finite("the times", &time)?;
        for (index, (value, quality)) in values.iter_mut().zip(&quality).enumerate() {
            if !quality.is_usable() {
                *value = f64::NAN;
            } else if !value.is_finite() {
                return Err(Error::NonFinite { signal, index, value: *value });
            }
        }
        Ok(Self { time, values, quality, unit: None, range: None, masked: vec![] })
    }

    /// Share of the samples with a usable value.
    pub fn usable_share(&self) -> f64 {
        let usable = self.quality.iter().filter(|q| q.is_usable()).count();
        usable as f64 / self.quality.len() as f64
    }
}
