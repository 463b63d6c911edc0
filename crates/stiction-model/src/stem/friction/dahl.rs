//! Dahl friction: a spring that yields to a Coulomb level.

use super::bristle::{BristleLaw, Gradient, Response};
use crate::error::{Result, non_negative, positive};

/// Dahl's law: `z' = v - s0 |v| z / Fc`, `F = s0 z + Fv v`.
///
/// The bristle deflection `z` (m) makes friction a hysteresis of the displacement. There is no static friction
/// above the Coulomb level, hence no stick-slip. Dahl's own law has no viscous part; with `Fv = 0` nothing damps
/// small vibrations around a rest position.
///
/// Reference: P. R. Dahl, "A solid friction model", Aerospace Corporation TOR-0158(3107-18)-1
/// (1968); recalled, not verified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dahl {
    coulomb_n: f64,
    stiffness_n_per_m: f64,
    viscous_n_s_per_m: f64,
}

impl Dahl {
    /// From the Coulomb level `Fc` in N, the bristle stiffness `s0` in N/m and the viscous
    /// friction `Fv` in N s/m.
    ///
    /// # Errors
    /// Unless `Fc > 0`, `s0 > 0`, `Fv >= 0`, all finite.
    pub fn new(coulomb_n: f64, stiffness_n_per_m: f64, viscous_n_s_per_m: f64) -> Result<Self> {
        positive("Coulomb friction", coulomb_n)?;
        positive("bristle stiffness", stiffness_n_per_m)?;
        non_negative("viscous friction", viscous_n_s_per_m)?;
        Ok(Self { coulomb_n, stiffness_n_per_m, viscous_n_s_per_m })
    }

    /// Coulomb level `Fc`, N.
    pub fn coulomb_n(&self) -> f64 {
        self.coulomb_n
    }

    /// Bristle stiffness `s0`, N/m.
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.stiffness_n_per_m
    }

    /// Viscous friction `Fv`, N s/m.
    pub fn viscous_n_s_per_m(&self) -> f64 {
        self.viscous_n_s_per_m
    }
}

impl BristleLaw<3> for Dahl {
    fn response(&self, y: &[f64; 3], direction: f64) -> Response<3> {
        let [_, v, z] = *y;
        let yielded = direction * z * self.stiffness_n_per_m / self.coulomb_n;
        Response {
            force_n: self.stiffness_n_per_m * z + self.viscous_n_s_per_m * v,
            rates: [0.0, 0.0, v * (1.0 - yielded)],
        }
    }

    fn gradient(&self, y: &[f64; 3], direction: f64) -> Gradient<3> {
        let [_, v, z] = *y;
        let yielding = direction * self.stiffness_n_per_m / self.coulomb_n;
        Gradient {
            force: [0.0, self.viscous_n_s_per_m, self.stiffness_n_per_m],
            rates: [[0.0; 3], [0.0; 3], [0.0, 1.0 - yielding * z, -yielding * v]],
        }
    }

    fn carrying(&self, force_n: f64) -> [f64; 3] {
        let z = force_n.clamp(-self.coulomb_n, self.coulomb_n) / self.stiffness_n_per_m;
        [0.0, 0.0, z]
    }

    fn deflection_scale(&self) -> [f64; 3] {
        [0.0, 0.0, self.coulomb_n / self.stiffness_n_per_m]
    }
}
