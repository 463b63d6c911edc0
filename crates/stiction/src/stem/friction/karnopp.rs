//! Karnopp friction: classical friction with a band of velocities that count as zero.

use super::Classical;
use crate::error::{Result, non_negative, require};

/// Classical friction whose stem counts as standing still while `|v| < band`.
///
/// * A slip ends when the speed falls to the band; the velocity is then set to zero.
/// * A stuck stem gathers momentum `M v' = net - Fs sgn(net)` once `|net| > Fs`, without moving,
///   and slips when `|v|` has reached the band.
///
/// With a band of 0 this is [`Classical`]. The band was introduced to keep fixed-step integrators
/// from chattering; located events need none, so it is here for comparison with models identified
/// with one.
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
    /// If the band is negative or not finite, or so wide that sliding friction at its edge exceeds
    /// `Fs`: a stem breaking away would then stop again at once, over and over.
    pub fn new(steady: Classical, band_m_per_s: f64) -> Result<Self> {
        non_negative("zero-velocity band", band_m_per_s)?;
        let edge_n = steady.sliding_n(band_m_per_s) + steady.viscous_n_s_per_m() * band_m_per_s;
        let allowed = format!(
            "so narrow that sliding friction at its edge ({edge_n} N) stays within static friction \
             ({} N)",
            steady.static_n()
        );
        let narrow = band_m_per_s == 0.0 || edge_n <= steady.static_n();
        require("zero-velocity band", band_m_per_s, narrow, &allowed)?;
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
}
