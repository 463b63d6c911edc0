//! Generalized Maxwell-slip friction: bristles in parallel, each sticking or slipping.

use super::Classical;
use super::bristle::{BristleLaw, ELEMENTS, Gradient, Response};
use crate::error::{Error, Result, non_negative, positive, require};

/// One spring-and-damper element of [`Gms`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GmsElement {
    /// Stiffness `k_i`, N/m; above 0.
    pub stiffness_n_per_m: f64,
    /// Damping `nu_i`, N s/m; at least 0.
    pub damping_n_s_per_m: f64,
    /// Share `alpha_i` of the steady friction; above 0, and 1 in sum.
    pub share: f64,
}

/// The generalized Maxwell-slip law with one to three elements.
///
/// With `s(v) = Fc + (Fs - Fc) exp(-(v/vs)^2)`, element `i` carries `F_i = k_i z_i + nu_i z_i'`
/// and
///
/// * sticks with `z_i' = v` until `F_i sgn v > alpha_i s(v)`;
/// * slips with `z_i' = (C alpha_i / k_i) (sgn v - F_i / (alpha_i s(v)))` until the velocity changes
///   sign.
///
/// `F = sum F_i + Fv v`. Because `F_i` contains `z_i'`, the slipping rate is solved from the two equations
/// together. Two elements give the law called SGMS, one gives GMS1.
///
/// Reference: F. Al-Bender, V. Lampaert, J. Swevers, "The generalized Maxwell-slip model", IEEE
/// Trans. Automatic Control 50 (2005) 1883-1887; recalled, not verified. The damping inside each
/// element follows the public valve-estimation code of F. G. Marques.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gms {
    steady: Classical,
    attraction_n_per_s: f64,
    elements: [GmsElement; ELEMENTS],
    count: usize,
}

impl Gms {
    /// From the friction of steady motion, the attraction `C` in N/s (how fast a slipping element
    /// follows the steady level) and one to three elements.
    ///
    /// # Errors
    /// Unless there are one to three elements with `k_i > 0`, `nu_i >= 0`, `alpha_i > 0` whose
    /// shares sum to 1 within 1e-9, `C > 0`, and the steady friction has `Fc > 0` and `vs > 0`.
    pub fn new(
        steady: Classical,
        attraction_n_per_s: f64,
        elements: &[GmsElement],
    ) -> Result<Self> {
        positive("Coulomb friction", steady.coulomb_n())?;
        positive("Stribeck velocity", steady.stribeck_m_per_s())?;
        positive("attraction", attraction_n_per_s)?;
        let count = elements.len();
        if !(1..=ELEMENTS).contains(&count) {
            return Err(Error::Inconsistent(format!(
                "a GMS law has 1 to {ELEMENTS} elements, not {count}"
            )));
        }
        for element in elements {
            positive("element stiffness", element.stiffness_n_per_m)?;
            non_negative("element damping", element.damping_n_s_per_m)?;
            positive("element share", element.share)?;
        }
        let sum: f64 = elements.iter().map(|e| e.share).sum();
        require("sum of element shares", sum, (sum - 1.0).abs() <= 1e-9, "1 within 1e-9")?;
        let absent = GmsElement { stiffness_n_per_m: 1.0, damping_n_s_per_m: 0.0, share: 0.0 };
        let mut all = [absent; ELEMENTS];
        all[..count].copy_from_slice(elements);
        Ok(Self { steady, attraction_n_per_s, elements: all, count })
    }

    /// Friction of steady motion.
    pub fn steady(&self) -> &Classical {
        &self.steady
    }

    /// Attraction `C`, N/s.
    pub fn attraction_n_per_s(&self) -> f64 {
        self.attraction_n_per_s
    }

    /// The elements.
    pub fn elements(&self) -> &[GmsElement] {
        &self.elements[..self.count]
    }
}

/// A [`Gms`] law during simulation, with its slipping elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GmsInUse {
    law: Gms,
    slipping: [bool; ELEMENTS],
}

impl GmsInUse {
    pub(crate) fn new(law: Gms) -> Self {
        Self { law, slipping: [false; ELEMENTS] }
    }

    /// Rate of deflection of a slipping element, and its derivatives by deflection and by `s(v)`.
    fn slipping_rate(&self, e: &GmsElement, z: f64, level: f64, direction: f64) -> (f64, f64, f64) {
        let pull = self.law.attraction_n_per_s;
        let k = e.stiffness_n_per_m;
        let free = pull * e.share * direction / k - pull * z / level;
        let slowing = 1.0 + pull * e.damping_n_s_per_m / (k * level);
        let by_z = -pull / level / slowing;
        let by_level = (pull * z * slowing + free * pull * e.damping_n_s_per_m / k)
            / (level * level * slowing * slowing);
        (free / slowing, by_z, by_level)
    }
}

impl BristleLaw<5> for GmsInUse {
    fn response(&self, y: &[f64; 5], direction: f64) -> Response<5> {
        let v = y[1];
        let level = self.law.steady.sliding_n(v);
        let mut response =
            Response { force_n: self.law.steady.viscous_n_s_per_m() * v, rates: [0.0; 5] };
        for (i, e) in self.law.elements().iter().enumerate() {
            let z = y[2 + i];
            let rate =
                if self.slipping[i] { self.slipping_rate(e, z, level, direction).0 } else { v };
            response.force_n += e.stiffness_n_per_m * z + e.damping_n_s_per_m * rate;
            response.rates[2 + i] = rate;
        }
        response
    }

    fn gradient(&self, y: &[f64; 5], direction: f64) -> Gradient<5> {
        let v = y[1];
        let level = self.law.steady.sliding_n(v);
        let slope = self.law.steady.sliding_slope(v);
        let mut gradient = Gradient { force: [0.0; 5], rates: [[0.0; 5]; 5] };
        gradient.force[1] = self.law.steady.viscous_n_s_per_m();
        for (i, e) in self.law.elements().iter().enumerate() {
            let (by_v, by_z) = if self.slipping[i] {
                let (_, by_z, by_level) = self.slipping_rate(e, y[2 + i], level, direction);
                (by_level * slope, by_z)
            } else {
                (1.0, 0.0)
            };
            gradient.force[1] += e.damping_n_s_per_m * by_v;
            gradient.force[2 + i] = e.stiffness_n_per_m + e.damping_n_s_per_m * by_z;
            gradient.rates[2 + i][1] = by_v;
            gradient.rates[2 + i][2 + i] = by_z;
        }
        gradient
    }

    fn carrying(&self, force_n: f64) -> [f64; 5] {
        let limit = self.law.steady.static_n();
        let force_n = force_n.clamp(-limit, limit);
        let mut y = [0.0; 5];
        for (i, e) in self.law.elements().iter().enumerate() {
            y[2 + i] = e.share * force_n / e.stiffness_n_per_m;
        }
        y
    }

    fn deflection_scale(&self) -> [f64; 5] {
        let mut scale = [0.0, 0.0, 1.0, 1.0, 1.0];
        for (i, e) in self.law.elements().iter().enumerate() {
            scale[2 + i] = e.share * self.law.steady.coulomb_n() / e.stiffness_n_per_m;
        }
        scale
    }

    fn stick_margins(&self, y: &[f64; 5], direction: f64) -> [f64; ELEMENTS] {
        let v = y[1];
        let level = self.law.steady.sliding_n(v);
        let mut margins = [f64::INFINITY; ELEMENTS];
        for (i, e) in self.law.elements().iter().enumerate() {
            if !self.slipping[i] {
                let force_n = e.stiffness_n_per_m * y[2 + i] + e.damping_n_s_per_m * v;
                margins[i] = e.share * level - direction * force_n;
            }
        }
        margins
    }

    fn loosen(&mut self, element: usize) {
        self.slipping[element] = true;
    }

    fn slipping(&self) -> [bool; ELEMENTS] {
        self.slipping
    }

    fn stick_all(&mut self) {
        self.slipping = [false; ELEMENTS];
    }
}
