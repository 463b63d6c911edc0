//! From physical parameters to S, J and the resulting kind of motion.

use super::simulate::Stem;
use crate::bands::Bands;
use crate::error::Result;

crate::named! {
    /// Motion of a stem under a slow ramp after breakaway.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum SlidingKind {
        /// It continues to move: Kano's, Choudhury's and the two-phase model describe it.
        Smooth = "smooth",
        /// It continues to move, but its velocity oscillates around the ramp's velocity. Its position looks smooth.
        Rippling = "rippling",
        /// It stops again and again: He's model describes it.
        Staircase = "staircase",
    }
}

crate::written_by_name!(SlidingKind);

/// Parameters of the data-driven models for a stem.
///
/// For motion so slow that inertia and viscous friction do not matter, `fs = Fs/k` and `fd = Fc/k`,
/// so that `S = (Fs + Fc)/k` and `J = (Fs - Fc)/k`. Derived for this project and confirmed by
/// simulation; the bristles' own deflection is left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equivalent {
    /// Static friction band `Fs/k`, m.
    pub fs_m: f64,
    /// Dynamic friction band `Fc/k`, m.
    pub fd_m: f64,
    /// Stick band plus dead band `S`, m.
    pub s_m: f64,
    /// Slip jump `J`, m.
    pub j_m: f64,
    /// The bands in percent of stroke.
    pub bands: Bands,
    /// The bands in percent of the pressure signal; equal to the former if the spring's travel over
    /// the signal equals the stroke.
    pub signal_bands: Bands,
    /// Damping ratio `z = Fv / (2 sqrt(k M))`.
    pub damping_ratio: f64,
    /// Overshoot `K` of the first slip: it covers `K J`. `K = 1 + exp(-pi z / sqrt(1 - z^2))`, and 1 for `z >= 1`. It
    /// holds for friction that does not depend on velocity except for its viscous part, and for an input that hardly
    /// moves during the slip. On a rising ramp the stem moves further, and for `z >= 1` it does not stop.
    pub overshoot: f64,
    /// Viscous lag `Fv/k`, s.
    pub viscous_lag_s: f64,
    /// Motion under a slow ramp.
    ///
    /// If static friction acts only at rest (`vs = 0`): smooth for `z >= 1`, else a staircase.
    /// Otherwise, with the Stribeck curve,
    ///
    /// * smooth if friction rises with velocity everywhere, `Fv >= 0.8578 (Fs - Fc)/vs`;
    /// * rippling if it falls somewhere but never below `Fs`, `Fv >= 0.6382 (Fs - Fc)/vs`: where
    ///   the falling part ends, the velocity drops, but not to zero;
    /// * a staircase if it dips below `Fs`: then the velocity drops to zero.
    ///
    /// This applies to ramps at rates where friction falls with velocity. On a slower one the stem creeps, on a
    /// faster one it slides smoothly in any case. Derived for this project and confirmed by simulation; frictional
    /// memory and bristles are left out.
    pub sliding: SlidingKind,
}

/// An [`Equivalent`] in a document.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
struct EquivalentDocument {
    /// Stick band plus dead band, percent of stroke.
    #[serde(rename = "S_percent_of_stroke")]
    s_percent_of_stroke: f64,
    /// Slip jump, percent of stroke.
    #[serde(rename = "J_percent_of_stroke")]
    j_percent_of_stroke: f64,
    /// Stick band plus dead band, percent of the pressure signal.
    #[serde(rename = "S_percent_of_signal")]
    s_percent_of_signal: f64,
    /// Slip jump, percent of the pressure signal.
    #[serde(rename = "J_percent_of_signal")]
    j_percent_of_signal: f64,
    /// Overshoot of the first slip: it covers `K J`.
    #[serde(rename = "K")]
    overshoot: f64,
    /// Damping ratio.
    damping_ratio: f64,
    /// Motion under a slow ramp.
    sliding: SlidingKind,
}

#[cfg(feature = "serde")]
crate::written_as!(Equivalent, EquivalentDocument);

#[cfg(feature = "serde")]
impl From<&Equivalent> for EquivalentDocument {
    fn from(found: &Equivalent) -> Self {
        Self {
            s_percent_of_stroke: found.bands.s(),
            j_percent_of_stroke: found.bands.j(),
            s_percent_of_signal: found.signal_bands.s(),
            j_percent_of_signal: found.signal_bands.j(),
            overshoot: found.overshoot,
            damping_ratio: found.damping_ratio,
            sliding: found.sliding,
        }
    }
}

impl Equivalent {
    /// Lag of the stem behind a ramp of `rate_m_per_s` while moving, m: `fd + Fv rho / k`.
    pub fn trailing_m(&self, rate_m_per_s: f64) -> f64 {
        self.fd_m + self.viscous_lag_s * rate_m_per_s
    }
}

impl Stem {
    /// The parameters of the data-driven models for this stem.
    ///
    /// # Errors
    /// If the bands overflow.
    pub fn equivalent(&self) -> Result<Equivalent> {
        let parameters = self.parameters();
        let friction = self.friction();
        let (fs_n, fd_n) = (friction.static_n(), friction.coulomb_n());
        let viscous = friction.viscous_n_s_per_m();
        let k = parameters.spring_n_per_m;
        let damping_ratio = viscous / (2.0 * (k * parameters.mass_kg).sqrt());
        let stroke_n = k * parameters.stroke_m;
        let signal_n =
            parameters.area_m2 * (parameters.pressure_max_pa - parameters.pressure_min_pa);
        let bands = |span_n: f64| Bands::from_fs_fd(100.0 * fs_n / span_n, 100.0 * fd_n / span_n);
        let sliding = if friction.static_only_at_rest() {
            if damping_ratio >= 1.0 { SlidingKind::Smooth } else { SlidingKind::Staircase }
        } else if viscous >= friction.steepest_fall_n_s_per_m() {
            SlidingKind::Smooth
        } else if viscous >= friction.steepest_dip_n_s_per_m() {
            SlidingKind::Rippling
        } else {
            SlidingKind::Staircase
        };
        Ok(Equivalent {
            fs_m: fs_n / k,
            fd_m: fd_n / k,
            s_m: (fs_n + fd_n) / k,
            j_m: (fs_n - fd_n) / k,
            bands: bands(stroke_n)?,
            signal_bands: bands(signal_n)?,
            damping_ratio,
            overshoot: overshoot(damping_ratio),
            viscous_lag_s: viscous / k,
            sliding,
        })
    }
}

/// Overshoot of the slip of a mass on a spring: `1 + exp(-pi z / sqrt(1 - z^2))`, 1 for `z >= 1`.
fn overshoot(z: f64) -> f64 {
    if z >= 1.0 {
        return 1.0;
    }
    1.0 + (-std::f64::consts::PI * z / (1.0 - z * z).sqrt()).exp()
}
