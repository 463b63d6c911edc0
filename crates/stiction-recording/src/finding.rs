//! The finding of a method and the method's description: the basis of methods, fits and verdict.

use std::any::Any;
use std::fmt;
use std::sync::Arc;
use stiction_model::named;

pub use stiction_model::Number;

named! {
    /// The decision of a detector.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Decision {
        /// The valve sticks.
        Sticks = "sticks",
        /// The valve does not stick.
        DoesNotStick = "does not stick",
        /// Something in the loop is not linear.
        Nonlinear = "nonlinear",
        /// No evidence against a linear loop.
        Linear = "linear",
        /// The method applies, and its statistic lies between its thresholds.
        Undecided = "undecided",
        /// The method does not apply, or the data do not suffice.
        Abstains = "abstains",
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Why a method does not judge: a sentence, with the remedy where there is one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Abstention(pub String);

impl fmt::Display for Abstention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Abstention {}

/// The description of a method, independent of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Method {
    /// Name in commands and files, such as `horch`.
    pub name: &'static str,
    /// Title, such as `Horch's cross-correlation`.
    pub title: &'static str,
    /// Authors, year, journal; and whether its formulas were read or recalled.
    #[cfg_attr(feature = "serde", serde(rename = "reference"))]
    pub source: &'static str,
    /// Name of the statistic, with its unit, if any. For every method of the registry, a larger value is stronger
    /// evidence for a positive decision.
    #[cfg_attr(feature = "serde", serde(rename = "statistic_name"))]
    pub statistic: &'static str,
    /// The decision rule, a sentence with the thresholds.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub rule: &'static str,
    /// The loops it was made for.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub applies: Applies,
    /// Meaning of a positive decision.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "votes", serialize_with = "votes"),
        schemars(with = "bool")
    )]
    pub decides: Decides,
    /// The signals it needs.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub needs: Needs,
    /// Kind of evidence.
    pub family: Family,
    /// Whether it explains an oscillation that was found before; see `stiction_diagnose::methods::judge`.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub explains_oscillation: bool,
}

/// Whether the decision of a method is counted in the vote of its family.
#[cfg(feature = "serde")]
fn votes<S: serde::Serializer>(decides: &Decides, to: S) -> std::result::Result<S::Ok, S::Error> {
    to.serialize_bool(*decides == Decides::Stiction)
}

named! {
    /// The kind of evidence of a method. Methods of one family use the same evidence, so they share one vote.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Family {
        /// The measured valve position.
        Measured = "measured position",
        /// The correlation of OP and PV.
        Correlation = "correlation",
        /// The shape of the waves of one signal.
        Shape = "wave shape",
        /// Samples in which one signal moves and the other rests.
        Patterns = "patterns",
        /// The trajectory of the loop in the plane of OP and PV.
        PhasePlot = "phase plot",
        /// Short windows in which OP and PV move differently.
        Windows = "windows",
        /// Models of valve and process fitted to OP and PV.
        Model = "model fits",
        /// Spectra of higher order and surrogate data.
        HigherOrder = "higher order",
    }
}

/// The loops a method was made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Applies {
    /// Any.
    AnyLoop,
    /// Loops with a self-regulating process.
    SelfRegulating,
    /// Loops with an integrating process.
    Integrating,
}

/// Meaning of a method's positive decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decides {
    /// That the valve sticks; such methods vote.
    Stiction,
    /// That something in the loop is not linear, of any cause; such methods do not vote.
    Nonlinearity,
}

/// The signals that a method needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// OP alone.
    Op,
    /// OP and PV.
    OpAndPv,
    /// The control error, from PV and, where it is recorded, SP.
    Error,
    /// OP and a measured valve position.
    OpAndVp,
}

/// The result of a detector for one segment.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Finding {
    /// The method.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub method: &'static Method,
    /// Decision.
    pub decision: Decision,
    /// The number the decision rests on.
    pub statistic: Option<f64>,
    /// The value of the statistic from which the decision is positive.
    pub threshold: Option<f64>,
    /// A sentence: the meaning of the numbers, or why the method abstains.
    pub reason: String,
    /// All numbers of the method.
    pub numbers: Vec<Number>,
    /// Cautions for the reader, such as an assumption that could not be checked.
    pub caveats: Vec<String>,
    /// The settings of the method.
    pub parameters: Vec<Number>,
    /// The typed result, from which the method's figure is drawn. It contains whole signals, so
    /// `stiction_diagnose::diagnose` keeps it only if `DiagnoseOptions::evidence` requests it.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub looked_at: Option<LookedAt>,
}

impl Finding {
    /// A finding of a method that judged.
    pub fn new(
        method: &'static Method,
        decision: Decision,
        statistic: f64,
        threshold: f64,
        reason: String,
        numbers: Vec<Number>,
    ) -> Self {
        Self {
            method,
            decision,
            statistic: Some(statistic),
            threshold: Some(threshold),
            reason,
            numbers,
            caveats: vec![],
            parameters: vec![],
            looked_at: None,
        }
    }

    /// A finding of a method that does not judge.
    pub fn abstains(method: &'static Method, why: Abstention) -> Self {
        Self {
            method,
            decision: Decision::Abstains,
            statistic: None,
            threshold: None,
            reason: why.0,
            numbers: vec![],
            caveats: vec![],
            parameters: vec![],
            looked_at: None,
        }
    }

    /// The typed result; `None` if it was not kept or is of another type.
    pub fn looked_at<T: Any>(&self) -> Option<&T> {
        self.looked_at.as_ref()?.get()
    }
}

/// The typed result of a finding's method.
#[derive(Debug, Clone)]
pub struct LookedAt(Arc<dyn Seen>);

trait Seen: Any + fmt::Debug + Send + Sync {
    fn equals(&self, other: &dyn Any) -> bool;
}

impl<T: Any + fmt::Debug + PartialEq + Send + Sync> Seen for T {
    fn equals(&self, other: &dyn Any) -> bool {
        other.downcast_ref() == Some(self)
    }
}

impl LookedAt {
    /// Holds the result of a method.
    pub fn new(result: impl Any + fmt::Debug + PartialEq + Send + Sync) -> Self {
        Self(Arc::new(result))
    }

    /// The result; `None` if it is of another type.
    pub fn get<T: Any>(&self) -> Option<&T> {
        let result: &dyn Any = &*self.0;
        result.downcast_ref()
    }
}

impl PartialEq for LookedAt {
    fn eq(&self, other: &Self) -> bool {
        self.0.equals(&*other.0)
    }
}
