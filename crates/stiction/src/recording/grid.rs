//! From samples at any times to stretches on a regular grid.

/// How values between samples are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The last value holds: right for SP, mode and OP, which change in steps, and for whatever a
    /// historian stores on change.
    Hold,
    /// A straight line between neighbours: right for PV and VP.
    Linear,
}

/// How a recording is brought onto a grid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GridOptions {
    /// Time between the samples of the grid, s; by default the commonest one of the recording.
    pub sample_time: Option<f64>,
}

/// Something that had to be mended, and how often.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    /// What was wrong.
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
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

/// Part of a recording in which the controller was in command and every sample is known, on a
/// regular grid. All signals have one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Time of its first sample, s on the recording's clock.
    pub from: f64,
    /// Time between samples, s.
    pub sample_time: f64,
    /// Controller output, percent of its range.
    pub op: Vec<f64>,
    /// Process value in its units.
    pub pv: Option<Vec<f64>>,
    /// Set point in the units of the PV.
    pub sp: Option<Vec<f64>>,
    /// Measured valve position, percent of its range.
    pub vp: Option<Vec<f64>>,
    /// How many of its samples were bridged, in any signal.
    pub bridged: usize,
}

impl Stretch {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.op.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.op.is_empty()
    }

    /// How long it lasts, s, with the last sample held.
    pub fn duration(&self) -> f64 {
        self.len() as f64 * self.sample_time
    }

    /// The time of each sample, s on the recording's clock.
    pub fn times(&self) -> Vec<f64> {
        (0..self.len()).map(|k| self.from + k as f64 * self.sample_time).collect()
    }
}

/// A recording on a regular grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Time between samples, s.
    pub sample_time: f64,
    /// The stretches, in order of time. None if the loop never was in automatic, or had no samples.
    pub stretches: Vec<Stretch>,
    /// What was mended, in order of [`RepairKind`].
    pub repairs: Vec<Repair>,
    /// From the first sample to the last, s.
    pub duration: f64,
    /// Share of the duration in which the controller was in command.
    pub closed_share: f64,
}

impl Grid {
    /// The longest stretch, the first of several.
    pub fn longest(&self) -> Option<&Stretch> {
        self.stretches.iter().rev().max_by_key(|stretch| stretch.len())
    }
}
