//! A number with its name and unit, as methods and actions report them.

/// A named number.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Number {
    /// Name, such as `delta tau`.
    pub name: &'static str,
    /// Value.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub value: f64,
    /// Unit; empty for a ratio or a count.
    pub unit: &'static str,
}

impl Number {
    /// A number with a unit; empty for none.
    pub fn new(name: &'static str, value: f64, unit: &'static str) -> Self {
        Self { name, value, unit }
    }
}
