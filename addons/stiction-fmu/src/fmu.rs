//! One FMU: a model, and the start values of its variables.

use std::ops::{Deref, DerefMut};

use stiction_model::stem::friction::LAWS;
use stiction_model::stem::{ParameterSet, SETS};
use stiction_model::valve::Model as Law;

use crate::json::{self, Value};
use crate::model::{self, FmuModel};
use crate::stem::{self, StemModel};
use crate::sticky_loop::{self, LoopModel};
use crate::valve::{self, ValveModel};
use crate::variables::{Numbers, Values, Variable, VariableKind};

/// A model that can be exported as an FMU.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct ModelEntry {
    /// The kind of the model: `valve`, `stem` or `loop`.
    pub model: &'static str,
    /// The valve model, or the friction law or parameter set of the stem.
    pub law: &'static str,
    /// Description, in one line.
    pub summary: &'static str,
}

/// Every model, with each of its laws.
pub fn models() -> Vec<ModelEntry> {
    let valves = |model: &'static str| {
        Law::ALL.into_iter().map(move |law| {
            let description = law.describe();
            ModelEntry { model, law: description.name, summary: description.summary }
        })
    };
    let sets = SETS.iter().filter_map(|name| {
        let set = ParameterSet::named(name).ok()?;
        Some(ModelEntry { model: "stem", law: set.name, summary: set.summary })
    });
    let laws = LAWS.iter().map(|l| ModelEntry { model: "stem", law: l.name, summary: l.summary });
    valves("valve").chain(laws).chain(sets).chain(valves("loop")).collect()
}

/// A functional mock-up unit: its model and start values.
#[derive(Debug, Clone, PartialEq)]
pub struct Fmu {
    model: &'static str,
    law: &'static str,
    table: Vec<Variable>,
}

/// The models, for messages.
const MODELS: &str = "valve, stem, loop";

impl Fmu {
    /// A `valve` or a `loop` with a data-driven law, or a `stem` with a friction law or one of the
    /// parameter sets of [`stiction_model::stem`], with its usual start values.
    ///
    /// # Errors
    /// If no model or law has this name. The sentence lists the known names.
    pub fn new(model: &str, law: &str) -> Result<Self, String> {
        match model {
            "valve" | "loop" => {
                let described = Law::by_name(law).map_err(|e| e.to_string())?.describe();
                Ok(if model == "valve" {
                    Self { model: "valve", law: described.name, table: valve::variables() }
                } else {
                    Self { model: "loop", law: described.name, table: sticky_loop::variables() }
                })
            }
            "stem" => {
                let unknown = || {
                    format!(
                        "there is no friction law or parameter set named \"{law}\"; known are {}, {}",
                        LAWS.map(|law| law.name).join(", "),
                        SETS.join(", ")
                    )
                };
                let (stem, friction) = stem::preset(law).ok_or_else(unknown)??;
                let table = stem::variables(&stem, &friction);
                Ok(Self { model: "stem", law: friction.name(), table })
            }
            _ => Err(format!("there is no model named \"{model}\"; known are {MODELS}")),
        }
    }

    /// The FMU with a different start value. Boolean values are 1 and 0.
    ///
    /// # Errors
    /// If no variable has this name, the variable is computed and cannot be set, or the value has the wrong type.
    /// [`Fmu::check`] checks combinations of values.
    pub fn with(mut self, name: &str, value: f64) -> Result<Self, String> {
        let Some(variable) = self.table.iter_mut().find(|v| v.name == name) else {
            let known: Vec<_> = self.settings().map(|v| v.name).collect();
            return Err(format!(
                "{name} is not a parameter of the model {} {}; known are {}",
                self.model,
                self.law,
                known.join(", ")
            ));
        };
        if !variable.is_set() {
            return Err(format!("{name} is computed, and has no start value of its own"));
        }
        accept(variable, value)?;
        let before = variable.start.replace(value);
        if self.model == "stem" {
            stem::adapt(&mut self.table, name, before);
        }
        Ok(self)
    }

    /// Reads the output of [`Fmu::json`]. Missing parameters have their usual values.
    ///
    /// # Errors
    /// If the text is not a flat JSON object, a key is unknown or occurs twice, or a value has the wrong type.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let pairs = json::read(text)?;
        let word = |key: &str, allowed: &str| match pairs.iter().find(|(k, _)| k == key) {
            Some((_, Value::Text(text))) => Ok(text.as_str()),
            Some(_) => Err(format!("\"{key}\" must be a text, one of {allowed}")),
            None => Err(format!("\"{key}\" is missing; it must be one of {allowed}")),
        };
        let model = word("model", MODELS)?;
        let law = word("law", "the laws of the model, such as \"two-phase\" or \"lugre\"")?;
        let mut fmu = Self::new(model, law)?;
        // The supply last, because it follows the range of pressures until it is given.
        let (supply, others): (Vec<_>, Vec<_>) = pairs.iter().partition(|(key, _)| key == "supply");
        for (key, value) in others.into_iter().chain(supply) {
            if key == "model" || key == "law" {
                continue;
            }
            let boolean = fmu
                .variables()
                .iter()
                .any(|v| v.name == key.as_str() && v.kind == VariableKind::Boolean);
            let value = match value {
                Value::Number(value) if !boolean => *value,
                Value::Boolean(value) if boolean => f64::from(u8::from(*value)),
                _ if boolean => return Err(format!("\"{key}\" must be true or false")),
                _ => return Err(format!("\"{key}\" must be a number")),
            };
            fmu = fmu.with(key, value)?;
        }
        Ok(fmu)
    }

    /// The text of `resources/stiction.json`: model, law, and the start value of every settable variable.
    pub fn json(&self) -> String {
        let mut text = format!("{{\n  \"model\": \"{}\",\n  \"law\": \"{}\"", self.model, self.law);
        for variable in self.settings() {
            let start = variable.start.unwrap_or(0.0);
            let value = if variable.kind == VariableKind::Boolean {
                (start != 0.0).to_string()
            } else {
                start.to_string()
            };
            text += &format!(",\n  \"{}\": {value}", variable.name);
        }
        text + "\n}\n"
    }

    /// Whether the start values are consistent.
    ///
    /// # Errors
    /// If not; the sentence names the parameter.
    pub fn check(&self) -> Result<(), String> {
        self.build().restart(&mut self.starts(), 0.0)
    }

    /// Result in co-simulation: the variables called `names` after each step of `step_s`, s. The first input (OP, or SP
    /// of a loop) is held over it at a value of `input`.
    ///
    /// # Errors
    /// If there is no such variable, or the model cannot continue.
    pub fn follow(
        &self,
        step_s: f64,
        input: &[f64],
        names: &[&str],
    ) -> Result<Vec<Vec<f64>>, String> {
        const INPUT: usize = 1;
        let places = names.iter().map(|name| {
            let place = self.table.iter().position(|v| v.name == *name);
            place.ok_or_else(|| format!("there is no variable named {name}"))
        });
        let places = places.collect::<Result<Vec<usize>, String>>()?;
        let (mut model, mut values) = (self.build(), self.starts());
        values[INPUT] = input.first().copied().unwrap_or(values[INPUT]);
        model.restart(&mut values, 0.0)?;
        let mut signals = vec![Vec::with_capacity(input.len()); names.len()];
        for (k, held) in input.iter().enumerate() {
            values[INPUT] = *held;
            model.step(&mut values, k as f64 * step_s, step_s)?;
            for (signal, place) in signals.iter_mut().zip(&places) {
                signal.push(values[*place]);
            }
        }
        Ok(signals)
    }

    /// `valve`, `stem` or `loop`.
    pub fn model(&self) -> &'static str {
        self.model
    }

    /// The law of the valve, or the friction law of the stem.
    pub fn law(&self) -> &'static str {
        self.law
    }

    /// All variables. The value reference of a variable is its index.
    pub fn variables(&self) -> &[Variable] {
        &self.table
    }

    /// The variables that an importer sets.
    pub fn settings(&self) -> impl Iterator<Item = &Variable> {
        self.table.iter().filter(|v| v.is_set())
    }

    /// Whether an external solver can compute it: model exchange.
    pub fn is_continuous(&self) -> bool {
        self.model == "stem" && stem::is_continuous(self.law)
    }

    /// The token that ties a description to this library. It is the same for the same model, law and variables, with
    /// any start values.
    pub fn token(&self) -> String {
        let mut text = format!("{} {}", self.model, self.law);
        for (i, v) in self.table.iter().enumerate() {
            text += &format!(
                "\n{i} {} {} {:?} {:?} {:?} {:?}",
                v.name, v.unit, v.kind, v.causality, v.variability, v.rate_of
            );
        }
        let (a, b) = (hash(text.bytes()), hash(text.bytes().rev()));
        format!(
            "{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}",
            a >> 32,
            (a >> 16) & 0xffff,
            a & 0xffff,
            b >> 48,
            b & 0xffff_ffff_ffff
        )
    }

    /// The values of all variables before the start.
    pub(crate) fn starts(&self) -> Values {
        self.table.iter().map(|v| v.start.unwrap_or(0.0)).collect()
    }

    /// The model, not yet started.
    pub(crate) fn build(&self) -> AnyFmuModel {
        let law = || Law::by_name(self.law).unwrap_or(Law::Ideal);
        match self.model {
            "valve" => AnyFmuModel::Valve(ValveModel::new(law())),
            "loop" => AnyFmuModel::Other(Box::new(LoopModel::new(law()))),
            _ => match stem::preset(self.law) {
                Some(Ok((stem, friction))) => {
                    AnyFmuModel::Other(Box::new(StemModel::new(stem, &friction)))
                }
                _ => unreachable!("a chosen parameter set exists"),
            },
        }
    }
}

/// A model. A step of a valve needs hardly any computation, so valves are stored in place. Other models are boxed.
pub(crate) enum AnyFmuModel {
    Valve(ValveModel),
    Other(Box<dyn FmuModel>),
}

impl AnyFmuModel {
    /// As [`FmuModel::step`].
    #[inline(always)]
    pub(crate) fn step(&mut self, values: &mut Numbers, time: f64, step: f64) -> model::Result<()> {
        match self {
            Self::Valve(valve) => valve.step(values, time, step),
            Self::Other(model) => model.step(values, time, step),
        }
    }
}

impl Deref for AnyFmuModel {
    type Target = dyn FmuModel;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Valve(valve) => valve,
            Self::Other(model) => &**model,
        }
    }
}

impl DerefMut for AnyFmuModel {
    fn deref_mut(&mut self) -> &mut Self::Target {
        match self {
            Self::Valve(valve) => valve,
            Self::Other(model) => &mut **model,
        }
    }
}

impl Clone for AnyFmuModel {
    fn clone(&self) -> Self {
        match self {
            Self::Valve(valve) => Self::Valve(valve.clone()),
            Self::Other(model) => Self::Other(model.copy()),
        }
    }
}

/// Accepts a value of the variable's type.
pub(crate) fn accept(variable: &Variable, value: f64) -> Result<(), String> {
    let (ok, allowed) = match variable.kind {
        VariableKind::Float64 => (value.is_finite(), "a finite number"),
        VariableKind::Boolean => (value == 0.0 || value == 1.0, "1 (true) or 0 (false)"),
        VariableKind::Int32 => (value == f64::from(value as i32), "a whole number of 32 bits"),
    };
    if ok { Ok(()) } else { Err(format!("{} is {value}, but must be {allowed}", variable.name)) }
}

/// FNV-1a, 64 bits.
pub(crate) fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
