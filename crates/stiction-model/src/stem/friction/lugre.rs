//! LuGre friction: bristles with a Stribeck level, stiffness and damping.

use super::Classical;
use super::bristle::{BristleLaw, Gradient, Response};
use crate::error::{Result, non_negative, positive};

/// The LuGre law: `z' = v - |v| z / g(v)`, `g = [Fc + (Fs - Fc) exp(-(v/vs)^2)] / s0`,
/// `F = s0 z + s1 z' + Fv v`.
///
/// In steady motion it equals [`Classical`]. Near rest it is a stiff spring with damping, so the stem creeps by some
/// micrometres instead of sticking.
///
/// Reference: C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control
/// of systems with friction", IEEE Trans. Automatic Control 40 (1995) 419-425; recalled, not
/// verified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuGre {
    steady: Classical,
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
}

impl LuGre {
    /// From the friction of steady motion, the bristle stiffness `s0` in N/m and the bristle
    /// damping `s1` in N s/m.
    ///
    /// # Errors
    /// Unless `s0 > 0`, `s1 >= 0`, and the steady friction has `Fc > 0` and `vs > 0`; all finite.
    pub fn new(steady: Classical, stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Result<Self> {
        positive("Coulomb friction", steady.coulomb_n())?;
        positive("Stribeck velocity", steady.stribeck_m_per_s())?;
        positive("bristle stiffness", stiffness_n_per_m)?;
        non_negative("bristle damping", damping_n_s_per_m)?;
        Ok(Self { steady, stiffness_n_per_m, damping_n_s_per_m })
    }

    /// The textbook example, for a mass of 1 kg: `s0 = 1e5 N/m`, `s1 = sqrt(1e5) N s/m`,
    /// `Fv = 0.4 N s/m`, `Fc = 1 N`, `Fs = 1.5 N`, `vs = 1 mm/s`; recalled, not verified.
    pub fn textbook() -> Self {
        let steady = Classical::new(1.5, 1.0, 0.4, 0.001).expect("constants are in range");
        Self { steady, stiffness_n_per_m: 1e5, damping_n_s_per_m: 1e5_f64.sqrt() }
    }

    /// Friction of steady motion.
    pub fn steady(&self) -> &Classical {
        &self.steady
    }

    /// Bristle stiffness `s0`, N/m.
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.stiffness_n_per_m
    }

    /// Bristle damping `s1`, N s/m.
    pub fn damping_n_s_per_m(&self) -> f64 {
        self.damping_n_s_per_m
    }
}

impl BristleLaw<3> for LuGre {
    fn response(&self, y: &[f64; 3], direction: f64) -> Response<3> {
        let [_, v, z] = *y;
        let spring_n = self.stiffness_n_per_m * z;
        let rate = v * (1.0 - direction * spring_n / self.steady.sliding_n(v));
        Response {
            force_n: spring_n + self.damping_n_s_per_m * rate + self.steady.viscous_n_s_per_m() * v,
            rates: [0.0, 0.0, rate],
        }
    }

    fn gradient(&self, y: &[f64; 3], direction: f64) -> Gradient<3> {
        let [_, v, z] = *y;
        let level = self.steady.sliding_n(v);
        let yielding = direction * self.stiffness_n_per_m / level;
        let by_v = 1.0 - yielding * z + yielding * v * z * self.steady.sliding_slope(v) / level;
        let by_z = -yielding * v;
        Gradient {
            force: [
                0.0,
                self.damping_n_s_per_m * by_v + self.steady.viscous_n_s_per_m(),
                self.stiffness_n_per_m + self.damping_n_s_per_m * by_z,
            ],
            rates: [[0.0; 3], [0.0; 3], [0.0, by_v, by_z]],
        }
    }

    fn carrying(&self, force_n: f64) -> [f64; 3] {
        let limit = self.steady.static_n();
        [0.0, 0.0, force_n.clamp(-limit, limit) / self.stiffness_n_per_m]
    }

    fn deflection_scale(&self) -> [f64; 3] {
        [0.0, 0.0, self.steady.coulomb_n() / self.stiffness_n_per_m]
    }
}
