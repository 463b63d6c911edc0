//! The table of variables for description, getting, setting, and documentation.

/// The type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VariableKind {
    /// `Real` in FMI 2.0, `Float64` in FMI 3.0.
    Float64,
    /// `Integer` in FMI 2.0, `Int32` in FMI 3.0.
    Int32,
    /// `Boolean`.
    Boolean,
}

/// The purpose of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Time.
    Independent,
    /// An input.
    Input,
    /// An output.
    Output,
    /// Set before the simulation, or tuned in it.
    Parameter,
    /// Computed, for solvers.
    Local,
}

/// When a variable may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// At any time.
    Continuous,
    /// At samples and events.
    Discrete,
    /// Never, once the simulation has been initialised.
    Fixed,
    /// Between steps.
    Tunable,
}

/// The most variables of a model: one bit each in a [`Set`].
pub(crate) const MOST: usize = 64;

/// A set of variables, by value reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Set(u64);

impl Set {
    /// Whether the table contains the variable with this reference.
    #[inline]
    pub(crate) fn has(self, reference: u32) -> bool {
        reference < MOST as u32 && self.0 >> reference & 1 != 0
    }

    /// The same, or nothing.
    pub(crate) fn only_if(self, condition: bool) -> Self {
        if condition { self } else { Self(0) }
    }
}

impl std::ops::BitAnd for Set {
    type Output = Self;

    #[inline]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl std::ops::BitOr for Set {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl FromIterator<u32> for Set {
    fn from_iter<I: IntoIterator<Item = u32>>(references: I) -> Self {
        Self(references.into_iter().fold(0, |set, reference| set | 1 << reference))
    }
}

/// One number for each possible variable, in the order of the table.
pub(crate) type Numbers = [f64; MOST];

/// The values of all variables of a model.
#[derive(Debug, Clone)]
#[repr(C)]
pub(crate) struct Values {
    numbers: Numbers,
    len: usize,
}

impl Values {
    /// References of the model's variables.
    pub(crate) fn known(&self) -> &[f64] {
        &self.numbers[..self.len]
    }

    /// The same, mutable.
    pub(crate) fn known_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[..self.len]
    }
}

impl FromIterator<f64> for Values {
    /// Panics if they are more than [`MOST`].
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut all = Self { numbers: [0.0; MOST], len: 0 };
        for value in values {
            all.numbers[all.len] = value;
            all.len += 1;
        }
        all
    }
}

impl std::ops::Deref for Values {
    type Target = Numbers;

    #[inline]
    fn deref(&self) -> &Numbers {
        &self.numbers
    }
}

impl std::ops::DerefMut for Values {
    #[inline]
    fn deref_mut(&mut self) -> &mut Numbers {
        &mut self.numbers
    }
}

/// One variable. Its value reference is its index in the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    /// Name.
    pub name: &'static str,
    /// Unit; empty if there is none.
    pub unit: &'static str,
    /// Type.
    pub kind: VariableKind,
    /// Purpose.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// Value at the start; `None` if it is computed.
    pub start: Option<f64>,
    /// Description, in one line.
    pub description: &'static str,
    /// The value reference of the state whose rate this is.
    pub rate_of: Option<u32>,
    /// Whether a change of its sign is an event in model exchange.
    pub indicates: bool,
    /// The states that determine its value at an instant, if nothing else does. In particular it does not depend on
    /// any input, so there is no algebraic loop around the FMU. `None` if it may depend on anything.
    pub depends_on: Option<&'static [u32]>,
}

/// A variable of an FMU.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
struct VariableDocument {
    /// Name.
    name: &'static str,
    /// Purpose: `time`, `input`, `output`, `parameter`, `tunable` (a parameter that may be changed while the simulation
    /// runs) or `local`.
    role: &'static str,
    /// Value at the start; null if the value is computed.
    start: Option<Start>,
    /// Unit; empty for a variable without a unit.
    unit: &'static str,
    /// Description, in one line.
    description: &'static str,
}

#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
#[serde(untagged)]
enum Start {
    Boolean(bool),
    Int32(i32),
    Float64(f64),
}

#[cfg(feature = "serde")]
stiction_model::written_as!(Variable, VariableDocument);

#[cfg(feature = "serde")]
impl From<&Variable> for VariableDocument {
    fn from(variable: &Variable) -> Self {
        let start = variable.start.map(|start| match variable.kind {
            VariableKind::Boolean => Start::Boolean(start != 0.0),
            VariableKind::Int32 => Start::Int32(start as i32),
            VariableKind::Float64 => Start::Float64(start),
        });
        let Variable { name, unit, description, .. } = *variable;
        Self { name, role: variable.role(), start, unit, description }
    }
}

impl Variable {
    const fn real(
        causality: Causality,
        variability: Variability,
        name: &'static str,
        unit: &'static str,
        start: Option<f64>,
        description: &'static str,
    ) -> Self {
        let kind = VariableKind::Float64;
        let (rate_of, indicates, depends_on) = (None, false, None);
        Self {
            name,
            unit,
            kind,
            causality,
            variability,
            start,
            description,
            rate_of,
            indicates,
            depends_on,
        }
    }

    /// The time, always number 0.
    pub(crate) const TIME: Self =
        Self::real(Causality::Independent, Variability::Continuous, "time", "s", None, "Time");

    pub(crate) const fn input(
        name: &'static str,
        unit: &'static str,
        start: f64,
        description: &'static str,
    ) -> Self {
        Self::real(Causality::Input, Variability::Continuous, name, unit, Some(start), description)
    }

    pub(crate) const fn output(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
    ) -> Self {
        Self::real(Causality::Output, Variability::Continuous, name, unit, None, description)
    }

    pub(crate) const fn local(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
    ) -> Self {
        Self::real(Causality::Local, Variability::Continuous, name, unit, None, description)
    }

    pub(crate) const fn parameter(
        name: &'static str,
        unit: &'static str,
        start: f64,
        description: &'static str,
    ) -> Self {
        Self::real(Causality::Parameter, Variability::Fixed, name, unit, Some(start), description)
    }

    /// The variable, changing at samples only.
    pub(crate) const fn sampled(mut self) -> Self {
        self.variability = Variability::Discrete;
        self
    }

    /// The variable, tunable during the simulation.
    pub(crate) const fn tunable(mut self) -> Self {
        self.variability = Variability::Tunable;
        self
    }

    /// The variable as a Boolean.
    pub(crate) const fn boolean(mut self) -> Self {
        self.kind = VariableKind::Boolean;
        if matches!(self.causality, Causality::Output) {
            self.variability = Variability::Discrete;
        }
        self
    }

    /// The variable as an integer.
    pub(crate) const fn integer(mut self) -> Self {
        self.kind = VariableKind::Int32;
        if matches!(self.causality, Causality::Output) {
            self.variability = Variability::Discrete;
        }
        self
    }

    /// The variable as the rate of another variable.
    pub(crate) const fn rate_of(mut self, state: usize) -> Self {
        self.rate_of = Some(state as u32);
        self
    }

    /// The variable as an event indicator.
    pub(crate) const fn indicator(mut self) -> Self {
        self.indicates = true;
        self
    }

    /// The variable, depending at an instant only on these states.
    pub(crate) const fn depends_on(mut self, states: &'static [u32]) -> Self {
        self.depends_on = Some(states);
        self
    }

    /// Purpose in one word: time, input, output, parameter, tunable or local.
    pub fn role(&self) -> &'static str {
        match (self.causality, self.variability) {
            (Causality::Independent, _) => "time",
            (Causality::Input, _) => "input",
            (Causality::Output, _) => "output",
            (Causality::Parameter, Variability::Tunable) => "tunable",
            (Causality::Parameter, _) => "parameter",
            (Causality::Local, _) => "local",
        }
    }

    /// Start value as text; empty if it is computed.
    pub fn start_text(&self) -> String {
        match (self.kind, self.start) {
            (_, None) => String::new(),
            (VariableKind::Boolean, Some(value)) => (value != 0.0).to_string(),
            (_, Some(value)) => value.to_string(),
        }
    }

    /// Whether an importer sets it: start values of such variables are in `stiction.json`.
    pub fn is_set(&self) -> bool {
        matches!(self.causality, Causality::Input | Causality::Parameter)
    }
}

/// The outputs of all valves besides the VP: numbers are relative to the first.
pub(crate) const MOVES: [Variable; 2] = [
    Variable::output("stuck", "", "Whether the stem is stuck").boolean().depends_on(&[]),
    Variable::output("slips", "", "Number of slips: starts of motion and reversals of the stem")
        .integer()
        .depends_on(&[]),
];
