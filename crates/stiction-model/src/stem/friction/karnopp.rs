//! Karnopp friction: classical friction with a band of velocities that count as zero.

use super::Classical;
use crate::error::{Result, non_negative};

/// Classical friction whose stem counts as standing still while `|v| < band`.
///
/// * A slip ends when the speed falls to the band; the velocity is then set to zero.
/// * A stuck stem gathers momentum `M v' = net - Fb sgn(net)` once `|net| > Fb`, without moving, and
///   slips when `|v|` has reached the band.
///
/// `Fb` is `Fs`, or sliding friction at the edge of the band if that is greater: otherwise a stem just outside the
/// band would fall back into it again and again.
///
/// With a band of 0 this is [`Classical`]. The band was introduced to keep fixed-step integrators from chattering.
/// Located events need none, so it is included for comparison with models identified with a band.
///
/// Reference: D. Karnopp, "Computer simulation of stick-slip friction in mechanical dynamic
/// systems", J. Dyn. Syst. Meas. Control 107 (1985) 100-103; recalled, not verified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Karnopp {
    steady: Classical,
    band_m_per_s: f64,
}

impl Karnopp {
    /// From the friction outside the band and the half width of the band, m/s.
    ///
    /// # Errors
    /// If the band is negative or not finite.
    pub fn new(steady: Classical, band_m_per_s: f64) -> Result<Self> {
        non_negative("zero-velocity band", band_m_per_s)?;
        Ok(Self { steady, band_m_per_s })
    }

    /// Friction outside the band.
    pub fn steady(&self) -> &Classical {
        &self.steady
    }

    /// Half width of the band, m/s.
    pub fn band_m_per_s(&self) -> f64 {
        self.band_m_per_s
    }

    /// Force `Fb` that must be exceeded to leave rest, N.
    pub fn breakaway_n(&self) -> f64 {
        self.steady.static_n().max(self.steady.moving_n(self.band_m_per_s))
    }
}
