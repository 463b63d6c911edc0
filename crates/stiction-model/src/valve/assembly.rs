//! A model with input limits before it and stem dynamics after it.

use super::{AnyModel, Start, StemLag, Valve, follow};
use crate::error::{Error, Result};

/// Input limits, then a model, then stem dynamics. Limits and dynamics are optional.
///
/// With limits, the OP is clipped before the model, as a positioner or an actuator at the end of its air supply would
/// do. The position is kept within the same range, as by end stops. A model that trails its input by `fd` then only
/// reaches `high - fd` and `low + fd`.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembly {
    limits: Option<(f64, f64)>,
    model: AnyModel,
    lag: Option<StemLag>,
}

impl Assembly {
    /// The bare model.
    pub fn new(model: AnyModel) -> Self {
        Self { limits: None, model, lag: None }
    }

    /// A different model with the same limits and lag.
    pub fn with_model(mut self, model: AnyModel) -> Self {
        self.model = model;
        self
    }

    /// Limits OP and position to `low..=high`, percent of span; 0 and 100 are usual.
    ///
    /// # Errors
    /// If `low` is not below `high`, or either is NaN.
    pub fn with_limits(mut self, low: f64, high: f64) -> Result<Self> {
        if !(low < high) {
            return Err(Error::Inconsistent(format!(
                "the lower limit of the valve is {low}, but must be below the upper limit, {high}"
            )));
        }
        self.limits = Some((low, high));
        Ok(self)
    }

    /// Follows the model with a first-order stem lag.
    pub fn with_lag(mut self, lag: StemLag) -> Self {
        self.lag = Some(lag);
        self
    }

    /// The model inside.
    pub fn model(&self) -> &AnyModel {
        &self.model
    }

    /// Memory between samples, as plain numbers: to store it, or to continue from it with other parameters.
    ///
    /// ```
    /// use stiction_model::Bands;
    /// use stiction_model::valve::{Assembly, Model, Valve};
    ///
    /// let mut valve = Assembly::new(Model::TwoPhase.build(Bands::from_s_j(2.0, 1.0)?)?);
    /// valve.step(10.0);
    /// let mut worse = Assembly::new(Model::TwoPhase.build(Bands::from_s_j(5.0, 2.0)?)?);
    /// worse.recall(&valve.memory());
    /// assert_eq!(worse.position(), 9.5);
    /// assert_eq!(worse.step(9.0), 9.5); // stuck
    /// # Ok::<(), stiction_model::Error>(())
    /// ```
    pub fn memory(&self) -> [f64; 7] {
        let [a, b, c, d, e] = self.model.memory();
        let [f, g] = self.lag.as_ref().map_or([0.0; 2], StemLag::memory);
        [a, b, c, d, e, f, g]
    }

    /// Continues from the memory of a valve of the same model with the same limits and lag.
    pub fn recall(&mut self, memory: &[f64; 7]) {
        let [a, b, c, d, e, f, g] = *memory;
        self.model.recall(&[a, b, c, d, e]);
        if let Some(lag) = &mut self.lag {
            lag.recall([f, g]);
        }
    }

    /// The bare model, if it has neither limits nor lag.
    pub fn bare_model(&self) -> Option<&AnyModel> {
        (self.limits.is_none() && self.lag.is_none()).then_some(&self.model)
    }

    /// The state from which [`Valve::restart`] continues the present motion; `None` if the memory is larger, as with a
    /// lag and for Kano's and Choudhury's models.
    ///
    /// ```
    /// use stiction_model::valve::{Assembly, Model, Valve};
    /// let build = || Model::TwoPhase.build(stiction_model::Bands::from_s_j(5.0, 2.0)?).map(Assembly::new);
    /// let (mut valve, mut resumed) = (build()?, build()?);
    /// valve.step(4.0);
    /// resumed.restart(valve.state().expect("a two-phase valve has one"));
    /// assert_eq!(resumed.step(5.0), valve.step(5.0));
    /// # Ok::<(), stiction_model::Error>(())
    /// ```
    pub fn state(&self) -> Option<Start> {
        self.bare_model()?.state()
    }

    /// The bare model, if it has neither limits nor lag; otherwise the unchanged assembly.
    pub(crate) fn into_bare_model(self) -> std::result::Result<AnyModel, Box<Self>> {
        if self.bare_model().is_some() { Ok(self.model) } else { Err(Box::new(self)) }
    }
}

impl From<AnyModel> for Assembly {
    fn from(model: AnyModel) -> Self {
        Self::new(model)
    }
}

impl Valve for Assembly {
    #[inline]
    fn step(&mut self, op: f64) -> f64 {
        let mut x = match self.limits {
            Some((low, high)) => self.model.step(op.max(low).min(high)).max(low).min(high),
            None => self.model.step(op),
        };
        if let Some(lag) = &mut self.lag {
            x = lag.step(x);
        }
        x
    }

    // Limits, lag and model are checked once, not at every sample.
    fn run(&mut self, op: &[f64], vp: &mut [f64]) -> Result<()> {
        if self.bare_model().is_some() { self.model.run(op, vp) } else { follow(self, op, vp) }
    }

    fn position(&self) -> f64 {
        let limited = |x: f64| match self.limits {
            Some((low, high)) => x.max(low).min(high),
            None => x,
        };
        self.lag.as_ref().map_or_else(|| limited(self.model.position()), StemLag::position)
    }

    fn restart(&mut self, start: Start) {
        self.model.restart(start);
        if let Some(lag) = &mut self.lag {
            lag.restart(start.position);
        }
    }
}
