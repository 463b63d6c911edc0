//! What had to be mended.

/// Something that had to be mended, and how often.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct GridRepair {
    /// What was wrong.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub kind: RepairKind,
    /// The signal, such as `PV`; or `time` for all.
    pub signal: &'static str,
    /// How many samples, or steps of the clock.
    pub count: usize,
    /// The first place, s on the recording's clock.
    pub first_s: f64,
    /// What was done, a sentence.
    pub done: String,
}

/// What can be wrong with the times or samples of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RepairKind {
    /// Several samples at one time.
    Duplicate,
    /// The clock went back.
    ClockStep,
    /// Samples in another order than their times.
    OutOfOrder,
    /// Samples that are not at multiples of the sample time.
    Irregular,
    /// A few bad or missing samples that were bridged.
    Bridged,
    /// Bad or missing samples too many to bridge; the recording is cut there.
    Gap,
    /// The loop was not in automatic; the recording is cut there.
    NotAutomatic,
}
