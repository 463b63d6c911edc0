//! What can go wrong, in sentences.

/// Why the library refused to compute.
///
/// Every variant carries the numbers a user needs to mend the input.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter lies outside the range its model allows.
    #[error("{name} is {value}, but must be {allowed}")]
    Parameter {
        /// Name of the parameter, as a user writes it.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// The allowed range, in words.
        allowed: String,
    },
    /// A sample of an input signal is NaN or infinite.
    #[error("sample {index} of {signal} is {value}, but every sample must be a finite number")]
    NonFinite {
        /// Name of the signal.
        signal: &'static str,
        /// Index of the first offending sample, from 0.
        index: usize,
        /// The value found there.
        value: f64,
    },
    /// Two slices that belong together differ in length.
    #[error("{name} has {found} samples, but {expected} are needed")]
    Length {
        /// Name of the slice.
        name: &'static str,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// A name that no item of its family bears.
    #[error("there is no {family} named \"{name}\"; known are {known}")]
    UnknownName {
        /// The family that was searched, such as "valve model".
        family: &'static str,
        /// The name that was asked for.
        name: String,
        /// The names there are, separated by commas.
        known: String,
    },
    /// A setting was not given, but something needs it.
    #[error("{needed_by} needs {name}")]
    Missing {
        /// Name of the setting; several with commas between.
        name: String,
        /// What needs it: a model, a law, or another setting.
        needed_by: &'static str,
    },
    /// A setting was given to a valve of another model.
    #[error("{name} is {role} of model {models} only")]
    NotOfModel {
        /// Name of the setting.
        name: &'static str,
        /// What it is, such as "the overshoot".
        role: &'static str,
        /// Names of the models that have it, separated by commas.
        models: String,
    },
    /// Two settings exclude each other, or one needs another.
    #[error("{0}")]
    Inconsistent(String),
    /// One of many loops was refused.
    #[error("loop {index}: {source}")]
    InLoop {
        /// Its index, from 0.
        index: usize,
        /// Why.
        source: Box<Error>,
    },
    /// A frozen model cannot be used.
    #[error("the model of the verdict cannot be used: {0}")]
    Bundle(String),
    /// The progress callback asked to stop.
    #[error("the computation was cancelled")]
    Cancelled,
    /// A numerical method could not go on.
    #[error("the {method} stopped at t = {time_s} s: {reason}")]
    Solver {
        /// Name of the method.
        method: &'static str,
        /// Simulated time at which it stopped, s.
        time_s: f64,
        /// Why, in words.
        reason: String,
    },
}

/// The library's result type.
pub type Result<T> = std::result::Result<T, Error>;

/// Accepts `value` if it is finite and `ok`, else says what `allowed` is.
pub fn require(name: &'static str, value: f64, ok: bool, allowed: &str) -> Result<f64> {
    if value.is_finite() && ok {
        Ok(value)
    } else {
        Err(Error::Parameter { name, value, allowed: allowed.to_owned() })
    }
}

/// Accepts a finite `value` of at least zero.
pub fn non_negative(name: &'static str, value: f64) -> Result<f64> {
    require(name, value, value >= 0.0, "a finite number of at least 0")
}

/// Accepts a finite `value` above zero.
pub fn positive(name: &'static str, value: f64) -> Result<f64> {
    require(name, value, value > 0.0, "a finite number above 0")
}

/// Accepts any finite `value`.
pub fn finite(name: &'static str, value: f64) -> Result<f64> {
    require(name, value, true, "a finite number")
}

/// Accepts `samples` if all are finite, else points at the first that is not.
pub fn all_finite(signal: &'static str, samples: &[f64]) -> Result<()> {
    // By blocks, each looked at to its end: that compiles to wide instructions.
    let sound = |block: &[f64]| block.iter().fold(true, |all, v| all & v.is_finite());
    if samples.chunks(256).all(sound) {
        return Ok(());
    }
    match samples.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Error::NonFinite { signal, index, value: samples[index] }),
    }
}
