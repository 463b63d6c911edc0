//! The integral dead zone.

use super::{Compensator, Instant, IntegralAction, Method, Sent};
use crate::Number;
use crate::error::{Result, non_negative};

/// Integral action that is frozen while the control error is small: an option of many industrial controllers.
///
/// # What it does
/// In a stiction cycle the integral pushes the stem away. If the integral is frozen while the PV is near its set point,
/// a stem that stops there by chance stays there.
///
/// # Equations
/// ```text
/// |sp - pv| <= zone:   the integral is frozen
/// otherwise:           it acts
/// signal = op
/// ```
///
/// # Assumptions
/// Some possible rest position of the stem holds the PV within the zone: the zone must be wider than the process
/// gain times half a slip.
///
/// # Limits
/// A control error up to the zone stays. An integrating process drifts across the zone as long as stem and load do
/// not balance, so its cycle continues, but slower.
///
/// # Deviations from the paper
/// It is common practice without a paper; the choice of the zone in [`Method::automatic`] is ours.
///
/// # References
/// None.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegralDeadZone {
    /// Half-width of the zone, in PV units.
    pub zone: f64,
}

impl Default for IntegralDeadZone {
    /// 1 PV unit.
    fn default() -> Self {
        Self { zone: 1.0 }
    }
}

impl IntegralDeadZone {
    /// An integral dead zone with this parameter.
    ///
    /// # Errors
    /// If the zone is negative or not finite.
    pub fn start(self) -> Result<Box<dyn Compensator>> {
        non_negative("integral dead zone", self.zone)?;
        Ok(Box::new(Resting { settings: self }))
    }
}

#[derive(Debug)]
struct Resting {
    settings: IntegralDeadZone,
}

impl Compensator for Resting {
    fn method(&self) -> Method {
        Method::IntegralDeadZone
    }

    fn parameters(&self) -> Vec<Number> {
        vec![Number::new("zone", self.settings.zone, "PV")]
    }

    fn reset(&mut self) {}

    fn integral(&mut self, error: f64) -> IntegralAction {
        if error.abs() <= self.settings.zone { IntegralAction::Stops } else { IntegralAction::Acts }
    }

    fn step(&mut self, now: &Instant) -> Sent {
        Sent::added(now.op)
    }
}
