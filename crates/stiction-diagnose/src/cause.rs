//! Possible causes of a loop's behaviour.

use stiction_model::named;

named! {
    /// A possible cause of a loop's behaviour.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Cause {
        /// The valve sticks.
        StickingValve = "sticking valve",
        /// The output travels and the flow does not.
        NoResponse = "no response",
        /// The controller is tuned too tightly and the loop rings.
        AggressiveTuning = "aggressive tuning",
        /// A regular oscillation comes in from outside.
        ExternalOscillation = "external oscillation",
        /// A wave with corners comes in from outside, for example from another sticking valve.
        ExternalWave = "external wave with corners",
        /// A load ramps and resets, such as fouling with backwash, or batches.
        ResettingLoad = "load that ramps and resets",
        /// Play or a dead zone in the sensor or the controller.
        DeadZoneElsewhere = "dead zone elsewhere",
        /// A transmitter or historian has a coarse resolution.
        Quantisation = "quantisation",
        /// The output works at its limits.
        Saturation = "saturation",
        /// The set point moves.
        SetPointChanges = "set-point changes",
        /// The process gain changes along the wave.
        ProcessNonlinearity = "process nonlinearity",
        /// No fault: the loop rejects ordinary disturbances.
        NormalOperation = "normal operation",
    }
}

impl Cause {
    /// Whether it is a fault of the valve.
    pub fn is_fault(self) -> bool {
        matches!(self, Self::StickingValve | Self::NoResponse)
    }
}
