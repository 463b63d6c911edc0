//! Possible causes of a loop's behaviour.

/// A possible cause of a loop's behaviour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    /// The valve sticks.
    StickingValve,
    /// The output travels and the flow does not.
    NoResponse,
    /// The controller is tuned too tightly and the loop rings.
    AggressiveTuning,
    /// A regular oscillation comes in from outside.
    ExternalOscillation,
    /// A wave with corners comes in from outside, for example from another sticking valve.
    ExternalWave,
    /// A load ramps and resets, such as fouling with backwash, or batches.
    ResettingLoad,
    /// Play or a dead zone in the sensor or the controller.
    DeadZoneElsewhere,
    /// A transmitter or historian has a coarse resolution.
    Quantisation,
    /// The output works at its limits.
    Saturation,
    /// The set point moves.
    SetPointChanges,
    /// The process gain changes along the wave.
    ProcessNonlinearity,
    /// No fault: the loop rejects ordinary disturbances.
    NormalOperation,
}

impl Cause {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::StickingValve,
        Self::NoResponse,
        Self::AggressiveTuning,
        Self::ExternalOscillation,
        Self::ExternalWave,
        Self::ResettingLoad,
        Self::DeadZoneElsewhere,
        Self::Quantisation,
        Self::Saturation,
        Self::SetPointChanges,
        Self::ProcessNonlinearity,
        Self::NormalOperation,
    ];

    /// Its name, such as `aggressive tuning`.
    pub fn name(self) -> &'static str {
        match self {
            Self::StickingValve => "sticking valve",
            Self::NoResponse => "no response",
            Self::AggressiveTuning => "aggressive tuning",
            Self::ExternalOscillation => "external oscillation",
            Self::ExternalWave => "external wave with corners",
            Self::ResettingLoad => "load that ramps and resets",
            Self::DeadZoneElsewhere => "dead zone elsewhere",
            Self::Quantisation => "quantisation",
            Self::Saturation => "saturation",
            Self::SetPointChanges => "set-point changes",
            Self::ProcessNonlinearity => "process nonlinearity",
            Self::NormalOperation => "normal operation",
        }
    }

    /// Whether it is a fault of the valve.
    pub fn is_fault(self) -> bool {
        matches!(self, Self::StickingValve | Self::NoResponse)
    }
}
