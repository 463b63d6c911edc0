//! The models of He and Wang: two parameters, and three with overshoot.

use super::published::Published;
use super::{Description, Motion, Start, Valve, ValveSpec};
use crate::bands::Bands;
use crate::error::{Result, require};

/// He, Wang, Pottmann and Qin's two-parameter model.
///
/// # Model
/// The stem comes to rest after every sample: it moves only in slips.
///
/// # Equations
/// With `e = u(k) - x(k-1)`:
/// ```text
/// |e| > fs:    x = u - sgn(e) fd
/// otherwise:   x stays
/// ```
/// (The published form accumulates `u_r = u - x`; the two are the same.)
///
/// # Parameters
/// [`Bands`] in percent of span; `J > S` is allowed.
///
/// # Limits
/// On a slow ramp it climbs a staircase of steps of about `J` where [`TwoPhase`](super::TwoPhase) slides, so the
/// same S and J give a different limit cycle. The sample at which a slow ramp crosses the threshold depends on the
/// sampling.
///
/// # References
/// Q. P. He, J. Wang, M. Pottmann, S. J. Qin, "A curve fitting method for detecting valve stiction
/// in oscillating control loops", Ind. Eng. Chem. Res. 46 (2007) 4549-4560, doi 10.1021/ie061219a.
#[derive(Debug, Clone, PartialEq)]
pub struct He {
    bands: Bands,
    position: f64,
}

impl He {
    /// A valve with these friction bands, at 0.
    pub fn new(bands: Bands) -> Self {
        Self { bands, position: 0.0 }
    }

    /// The friction bands.
    pub fn bands(&self) -> Bands {
        self.bands
    }
}

impl Valve for He {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let e = op - self.position;
        if self.bands.breaks(e) {
            self.position = op - 1f64.copysign(e) * self.bands.fd();
        }
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        self.position = start.position;
    }
}

/// He and Wang's three-parameter, semi-physical model.
///
/// # Equations
/// With `e = u(k) - x(k-1)`:
/// ```text
/// |e| > fs:    x = x(k-1) + K (e - sgn(e) fd)
/// otherwise:   x stays
/// ```
/// `K` is the overshoot of an inertial slip. For a mass, spring and damper with constant Coulomb
/// friction, `K = 1 + exp(-pi z / sqrt(1 - z^2))` with `z = Fv / (2 sqrt(k M))`, and `K = 1`, which
/// is [`He`], for `z >= 1`.
///
/// # Parameters
/// [`Bands`] in percent of span with `J <= S`; `K` from 1 to 2.
///
/// # References
/// Q. P. He, J. Wang, "Valve stiction modeling: first-principles vs data-driven approaches",
/// American Control Conference 2010; "Valve stiction quantification method based on a semiphysical
/// valve stiction model", Ind. Eng. Chem. Res. 53 (2014). The equation is recalled, not read in
/// either; the expression for `K` is derived and confirmed against a simulated stem.
#[derive(Debug, Clone, PartialEq)]
pub struct HeWang {
    bands: Bands,
    overshoot: f64,
    position: f64,
}

impl HeWang {
    /// The overshoot quoted for a typical valve (recalled, not verified). It assumes an almost undamped stem.
    pub const TYPICAL_OVERSHOOT: f64 = 1.99;

    /// A valve with these friction bands and overshoot factor `K`, at 0.
    ///
    /// # Errors
    /// If `J > S`, or `K` lies outside 1 to 2.
    pub fn new(bands: Bands, overshoot: f64) -> Result<Self> {
        let ok = (1.0..=2.0).contains(&overshoot);
        let overshoot = require("K", overshoot, ok, "between 1 (no overshoot) and 2 (no damping)")?;
        Ok(Self { bands: bands.without_overshoot()?, overshoot, position: 0.0 })
    }
}

impl Valve for HeWang {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let e = op - self.position;
        if self.bands.breaks(e) {
            self.position += self.overshoot * (e - 1f64.copysign(e) * self.bands.fd());
        }
        self.position
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn restart(&mut self, start: Start) {
        self.position = start.position;
    }
}

impl Published for He {
    const DESCRIPTION: Description = Description {
        name: "he",
        aliases: &[],
        summary: "at rest after every sample; climbs a slow ramp in steps of J",
        citation: "He, Wang, Pottmann, Qin, Ind. Eng. Chem. Res. 46 (2007) 4549-4560",
        motion: Motion::Staircase,
        uses_s: true,
        uses_j: true,
        uses_k: false,
        uses_rest_tolerance: false,
        same_as: None,
    };

    fn build(spec: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Ok(Self::new(spec.bands))
    }
}

impl Published for HeWang {
    const DESCRIPTION: Description = Description {
        name: "he-wang",
        aliases: &["hewang", "he_wang"],
        summary: "he with slips that overshoot by the factor K (equation recalled)",
        citation: "He, Wang, American Control Conference (2010)",
        motion: Motion::Staircase,
        uses_s: true,
        uses_j: true,
        uses_k: true,
        uses_rest_tolerance: false,
        same_as: None,
    };

    fn build(spec: &ValveSpec, _: Option<f64>) -> Result<Self> {
        Self::new(spec.bands, spec.overshoot.unwrap_or(Self::TYPICAL_OVERSHOOT))
    }
}
