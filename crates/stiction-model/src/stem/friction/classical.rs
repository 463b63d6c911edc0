//! Classical friction: Coulomb, viscous, and the Stribeck fall between rest and motion.

use crate::error::{Result, non_negative, require};

/// Static, Coulomb, Stribeck and viscous friction as a function of velocity alone.
///
/// Moving: `F(v) = [Fc + (Fs - Fc) exp(-(v/vs)^2)] sgn v + Fv v`.
/// At rest friction equals the net applied force, up to `Fs`; beyond that the stem breaks away.
///
/// `vs = 0` means that `Fs` acts only at rest: a moving stem meets `Fc sgn v + Fv v`, and the
/// stem's motion is then advanced by its exact flow.
///
/// This is the usual Stribeck form. Equation (6) of the paper, as printed, lacks the Coulomb level
/// and the velocity in the viscous term, and grows without bound for negative velocities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Classical {
    static_n: f64,
    coulomb_n: f64,
    viscous_n_s_per_m: f64,
    stribeck_m_per_s: f64,
}

impl Classical {
    /// From static friction `Fs` and Coulomb friction `Fc` in N, viscous friction `Fv` in N s/m
    /// and Stribeck velocity `vs` in m/s.
    ///
    /// # Errors
    /// Unless `0 <= Fc <= Fs`, `Fv >= 0`, `vs >= 0`, all finite.
    pub fn new(
        static_n: f64,
        coulomb_n: f64,
        viscous_n_s_per_m: f64,
        stribeck_m_per_s: f64,
    ) -> Result<Self> {
        non_negative("static friction", static_n)?;
        let between = (0.0..=static_n).contains(&coulomb_n);
        let allowed = format!("between 0 and the static friction, {static_n} N");
        require("Coulomb friction", coulomb_n, between, &allowed)?;
        non_negative("viscous friction", viscous_n_s_per_m)?;
        non_negative("Stribeck velocity", stribeck_m_per_s)?;
        Ok(Self { static_n, coulomb_n, viscous_n_s_per_m, stribeck_m_per_s })
    }

    /// Static friction `Fs`, N.
    pub fn static_n(&self) -> f64 {
        self.static_n
    }

    /// Coulomb friction `Fc`, N.
    pub fn coulomb_n(&self) -> f64 {
        self.coulomb_n
    }

    /// Viscous friction `Fv`, N s/m.
    pub fn viscous_n_s_per_m(&self) -> f64 {
        self.viscous_n_s_per_m
    }

    /// Stribeck velocity `vs`, m/s; 0 if static friction acts only at rest.
    pub fn stribeck_m_per_s(&self) -> f64 {
        self.stribeck_m_per_s
    }

    /// Friction on a moving stem without its viscous part, N; never negative, even in `velocity`.
    pub fn sliding_n(&self, velocity: f64) -> f64 {
        if self.stribeck_m_per_s == 0.0 {
            return self.coulomb_n;
        }
        let ratio = velocity / self.stribeck_m_per_s;
        self.coulomb_n + (self.static_n - self.coulomb_n) * (-ratio * ratio).exp()
    }

    /// Derivative of [`Self::sliding_n`] with respect to velocity, N s/m.
    pub(crate) fn sliding_slope(&self, velocity: f64) -> f64 {
        if self.stribeck_m_per_s == 0.0 {
            return 0.0;
        }
        let ratio = velocity / self.stribeck_m_per_s;
        -2.0 * ratio / self.stribeck_m_per_s
            * (self.static_n - self.coulomb_n)
            * (-ratio * ratio).exp()
    }

    /// Friction on a moving stem, N, with the sign of `velocity`; 0 at rest, where friction depends
    /// on the applied force instead.
    pub fn moving_n(&self, velocity: f64) -> f64 {
        if velocity == 0.0 {
            return 0.0;
        }
        self.sliding_n(velocity) * velocity.signum() + self.viscous_n_s_per_m * velocity
    }
}
