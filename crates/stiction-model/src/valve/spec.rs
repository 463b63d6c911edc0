//! The specification of a valve.

use super::published::needed_by;
use super::{Assembly, Model, StemLag};
use crate::bands::Bands;
use crate::error::{Error, Result};

/// All settings of a data-driven valve, as in a scenario, a command, an FMU or a script.
///
/// ```
/// use stiction_model::{Bands, Error, valve::{Model, Valve, ValveSpec}};
///
/// let bands = Model::HeWang.bands(Some(5.0), Some(2.0))?;
/// let spec = ValveSpec { overshoot: Some(1.5), ..ValveSpec::new(Model::HeWang, bands) };
/// assert_eq!(spec.build(None)?.step(6.0), 6.75);
/// let other = ValveSpec { model: Model::Kano, ..spec };
/// assert!(matches!(other.build(None), Err(Error::NotOfModel { name: "K", .. })));
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValveSpec {
    /// The model.
    pub model: Model,
    /// Friction bands, percent of span.
    pub bands: Bands,
    /// Overshoot `K` of a slip, for models that [use one](super::Description::uses_k): 1 (none) to 2 (no damping);
    /// by default [typical](super::HeWang::TYPICAL_OVERSHOOT).
    pub overshoot: Option<f64>,
    /// Speed of the OP that counts as a pause, percent of span per second, for models that [use
    /// one](super::Description::uses_rest_tolerance); by default 0.
    pub rest_tolerance: Option<f64>,
    /// Lowest and highest OP and VP, percent of span; by default none.
    pub limits: Option<(f64, f64)>,
    /// Time constant of a first-order lag of the stem, s; 0 for none.
    pub lag_s: f64,
}

impl ValveSpec {
    /// The bare model with these bands.
    pub fn new(model: Model, bands: Bands) -> Self {
        Self { model, bands, overshoot: None, rest_tolerance: None, limits: None, lag_s: 0.0 }
    }

    /// The valve, stuck at 0, sampled every `sample_time` seconds: needed for a lag and a rest tolerance only.
    ///
    /// # Errors
    /// [`Error::NotOfModel`] for a setting that the model does not have, [`Error::Missing`] if the sample time is
    /// needed; otherwise if the model does not allow these bands, or a value is out of its range.
    pub fn build(&self, sample_time: Option<f64>) -> Result<Assembly> {
        let uses = self.model.describe();
        let refused = |name, role, used: fn(Model) -> bool| {
            let models = Model::ALL.into_iter().filter(|model| used(*model));
            let models = models.map(|model| model.describe().name).collect::<Vec<_>>().join(", ");
            Err(Error::NotOfModel { name, role, models })
        };
        if self.overshoot.is_some() && !uses.uses_k {
            return refused("K", "the overshoot", |model| model.describe().uses_k);
        }
        if self.rest_tolerance.is_some() && !uses.uses_rest_tolerance {
            return refused("rest tolerance", "an option", |m| m.describe().uses_rest_tolerance);
        }
        let mut valve = Assembly::new(self.model.build_as(self, sample_time)?);
        if let Some((low, high)) = self.limits {
            valve = valve.with_limits(low, high)?;
        }
        if self.lag_s != 0.0 {
            let sample_time = needed_by("stem lag", sample_time)?;
            valve = valve.with_lag(StemLag::new(self.lag_s, sample_time)?);
        }
        Ok(valve)
    }
}
