//! The valve models by name.

use super::published::{Memory, Published};
use super::{Chen, Choudhury, He, HeWang, Ideal, Kano, Play, Start, Stenman, TwoPhase, Valve};
use super::{Description, ValveSpec};
use crate::bands::Bands;
use crate::error::{Error, Result};

/// Makes the registry of the models: their names, a valve of each, and their functions.
macro_rules! models {
    ($($model:ident),+ $(,)?) => {
        /// A published valve model, by name.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Model {
            $(#[doc = concat!("[`", stringify!($model), "`]")] $model,)+
        }

        impl Model {
            /// All models.
            pub const ALL: [Self; [$(Self::$model),+].len()] = [$(Self::$model),+];

            /// The description of this model.
            pub fn describe(self) -> Description {
                match self {
                    $(Self::$model => $model::DESCRIPTION,)+
                }
            }

            /// The bare model of `spec`.
            pub(super) fn build_as(self, spec: &ValveSpec, sample_time: Option<f64>) -> Result<AnyModel> {
                Ok(match self {
                    $(Self::$model => AnyModel::$model($model::build(spec, sample_time)?),)+
                })
            }
        }

        /// A valve of any model.
        #[derive(Debug, Clone, PartialEq)]
        #[allow(missing_docs)]
        pub enum AnyModel {
            $($model($model),)+
        }

        impl AnyModel {
            /// The state from which [`Valve::restart`] continues the present motion; `None` if the model's memory is
            /// larger.
            pub(crate) fn state(&self) -> Option<Start> {
                match self { $(Self::$model(valve) => valve.state(),)+ }
            }

            pub(super) fn memory(&self) -> Memory {
                match self { $(Self::$model(valve) => valve.memory(),)+ }
            }

            pub(super) fn recall(&mut self, memory: &Memory) {
                match self { $(Self::$model(valve) => valve.recall(memory),)+ }
            }
        }

        $(
            impl From<$model> for AnyModel {
                fn from(valve: $model) -> Self {
                    Self::$model(valve)
                }
            }
        )+

        impl Valve for AnyModel {
            #[inline]
            fn step(&mut self, op: f64) -> f64 {
                match self { $(Self::$model(valve) => valve.step(op),)+ }
            }

            fn position(&self) -> f64 {
                match self { $(Self::$model(valve) => valve.position(),)+ }
            }

            fn restart(&mut self, start: Start) {
                match self { $(Self::$model(valve) => valve.restart(start),)+ }
            }

            // One dispatch for the whole slice instead of one a sample.
            fn run(&mut self, op: &[f64], vp: &mut [f64]) -> Result<()> {
                match self { $(Self::$model(valve) => valve.run(op, vp),)+ }
            }
        }
    };
}

models![TwoPhase, Choudhury, Kano, He, HeWang, Stenman, Chen, Play, Ideal];

impl Model {
    /// The model called `name`, in any case.
    ///
    /// # Errors
    /// If no model has that name; the error lists the known ones.
    pub fn by_name(name: &str) -> Result<Self> {
        let wanted = name.to_ascii_lowercase();
        Self::ALL
            .into_iter()
            .find(|model| {
                let description = model.describe();
                description.name == wanted || description.aliases.contains(&wanted.as_str())
            })
            .ok_or_else(|| Error::UnknownName {
                family: "valve model",
                name: name.to_owned(),
                known: Self::ALL.map(|model| model.describe().name).join(", "),
            })
    }

    /// A valve of this model with these friction bands, stuck at 0; [`ValveSpec`] is one with all settings.
    ///
    /// [`HeWang`] gets an overshoot of 1.99, the value recalled for a typical valve; [`Stenman`] uses `J` as its
    /// band, [`Play`] uses `S` as its dead band.
    ///
    /// # Errors
    /// If the model does not allow these bands.
    pub fn build(self, bands: Bands) -> Result<AnyModel> {
        self.build_as(&ValveSpec::new(self, bands), None)
    }

    /// Friction bands from the given `S` and `J`, percent of span. Unused ones may be missing.
    ///
    /// # Errors
    /// [`Error::Missing`] if a required value is missing; an error if a value is out of range.
    pub fn bands(self, s: Option<f64>, j: Option<f64>) -> Result<Bands> {
        let Description { name: needed_by, uses_s, uses_j, .. } = self.describe();
        let need = |name: &str, value: Option<f64>, used: bool| match value {
            None if used => Err(Error::Missing { name: name.to_owned(), needed_by }),
            value => Ok(value.unwrap_or(0.0)),
        };
        Bands::from_s_j(need("S", s, uses_s)?, need("J", j, uses_j)?)
    }

    /// The given ones of `S` and `J` that this model does not use.
    pub fn unused(self, s: Option<f64>, j: Option<f64>) -> impl Iterator<Item = &'static str> {
        let Description { uses_s, uses_j, .. } = self.describe();
        [("S", s, uses_s), ("J", j, uses_j)]
            .into_iter()
            .filter_map(|(name, given, used)| (given.is_some() && !used).then_some(name))
    }

    /// The effective bands of a valve of this model with these bands, some of which it may not use.
    ///
    /// # Errors
    /// Only for invalid bands.
    pub fn effective(self, bands: Bands) -> Result<Bands> {
        let Description { uses_s, uses_j, .. } = self.describe();
        match (uses_s, uses_j) {
            (true, true) => Ok(bands),
            (true, false) => Bands::from_s_j(bands.s(), 0.0),
            (false, true) => Bands::from_s_j(bands.j(), bands.j()),
            (false, false) => Ok(Bands::NONE),
        }
    }
}
