//! The repairs of a recording.

/// A kind of repair of the data, and how often it was necessary.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct GridRepair {
    /// The fault.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub kind: RepairKind,
    /// The repaired signal, such as `PV`, or `time` if all signals were repaired.
    pub signal: &'static str,
    /// Number of repaired samples, or of repaired steps of the clock.
    pub count: usize,
    /// Time of the first repair, s on the recording's clock.
    pub first_s: f64,
    /// The repair in a sentence.
    pub done: String,
}

/// A fault in the times or samples of a recording.
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
    /// Too many bad or missing samples to bridge; the recording is cut there.
    Gap,
    /// The loop was not in automatic; the recording is cut there.
    NotAutomatic,
}
