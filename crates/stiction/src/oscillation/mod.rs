//! Whether a loop cycles, how regularly, with what period and amplitude, and when.

/// What is known about the oscillation of one signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Oscillation {
    /// Period of the dominant oscillation, s; `None` if none was found.
    pub period_s: Option<f64>,
    /// Half of the typical peak-to-peak value of that oscillation, in the signal's units.
    pub amplitude: Option<f64>,
    /// How many periods the signal spans.
    pub cycles: Option<f64>,
}
