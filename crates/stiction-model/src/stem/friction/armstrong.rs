//! Armstrong's seven-parameter friction: presliding spring, frictional memory, rising static
//! friction.

use crate::error::{Result, non_negative, positive};

/// The seven-parameter law.
///
/// * Presliding: a spring of stiffness `kt`, `F = kt (x - x_anchor)`.
/// * Sliding: `F = (Fc + Fv |v| + Fs(t2) / (1 + (v(t - tL)/vs)^2)) sgn v`. The Stribeck part depends on the
///   velocity `tL` seconds ago.
/// * Breakaway when the presliding force exceeds `Fc + Fs(t2)` after a dwell of `t2` seconds, where `Fs(t2) = Fs,a
///   + (Fs,inf - Fs,a) t2 / (t2 + gamma)` rises from the Stribeck part `Fs,a` at the end of the last slip.
///
/// A stem that has not yet moved starts from `Fs,inf`. Presliding is quasi-static here: its force
/// balance holds without inertia, because the law gives the spring no damping. At an end stop
/// presliding is neglected.
///
/// Reference: B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis
/// tools and compensation methods for the control of machines with friction", Automatica 30 (1994)
/// 1083-1138; recalled, not verified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Armstrong {
    /// Presliding stiffness `kt`, N/m; above 0.
    pub presliding_n_per_m: f64,
    /// Coulomb friction `Fc`, N; at least 0.
    pub coulomb_n: f64,
    /// Viscous friction `Fv`, N s/m; at least 0.
    pub viscous_n_s_per_m: f64,
    /// Static friction above Coulomb after a long dwell, `Fs,inf`, N; at least 0.
    pub static_excess_n: f64,
    /// Stribeck velocity `vs`, m/s; above 0.
    pub stribeck_m_per_s: f64,
    /// Frictional memory `tL`, s; at least 0.
    pub memory_s: f64,
    /// Rise time of static friction `gamma`, s; at least 0.
    pub rise_s: f64,
}

impl Armstrong {
    /// Returns these parameters if each is finite and in range.
    ///
    /// # Errors
    /// If a parameter is not finite or out of range.
    pub fn checked(self) -> Result<Self> {
        positive("presliding stiffness", self.presliding_n_per_m)?;
        non_negative("Coulomb friction", self.coulomb_n)?;
        non_negative("viscous friction", self.viscous_n_s_per_m)?;
        non_negative("static excess", self.static_excess_n)?;
        positive("Stribeck velocity", self.stribeck_m_per_s)?;
        non_negative("frictional memory", self.memory_s)?;
        non_negative("rise time of static friction", self.rise_s)?;
        Ok(self)
    }

    /// Static friction above Coulomb after `dwell_s` at rest, N, if it was `last_n` at the end of the last slip.
    pub fn static_excess_after(&self, last_n: f64, dwell_s: f64) -> f64 {
        // t2 / (t2 + gamma), written so that an endless dwell gives 1.
        let risen = if self.rise_s == 0.0 { 1.0 } else { 1.0 / (1.0 + self.rise_s / dwell_s) };
        last_n + (self.static_excess_n - last_n) * risen
    }

    /// The factor by which motion lowers the static excess, at the remembered velocity.
    pub(crate) fn stribeck_factor(&self, remembered: f64) -> f64 {
        let ratio = remembered / self.stribeck_m_per_s;
        1.0 / (1.0 + ratio * ratio)
    }

    /// Derivative of [`Self::stribeck_factor`], s/m.
    pub(crate) fn stribeck_slope(&self, remembered: f64) -> f64 {
        let factor = self.stribeck_factor(remembered);
        -2.0 * remembered / (self.stribeck_m_per_s * self.stribeck_m_per_s) * factor * factor
    }
}
