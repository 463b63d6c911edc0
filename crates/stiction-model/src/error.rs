//! Errors, in sentences.

/// Reason of a failed computation.
///
/// Every variant has the numbers that a user needs to correct the input.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter outside the range of its model.
    #[error("{name} is {value}, but must be {allowed}")]
    Parameter {
        /// Name of the parameter, as a user writes it.
        name: &'static str,
        /// The given value.
        value: f64,
        /// The allowed range, in words.
        allowed: String,
    },
    /// A sample of an input signal is NaN or infinite.
    #[error("sample {index} of {signal} is {value}, but every sample must be a finite number")]
    NonFinite {
        /// Name of the signal.
        signal: &'static str,
        /// Index of the first invalid sample, from 0.
        index: usize,
        /// Value.
        value: f64,
    },
    /// Two slices that belong together with different lengths.
    #[error("{name} has {found} samples, but {expected} are needed")]
    Length {
        /// Name of the slice.
        name: &'static str,
        /// Length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// An unknown name in a family.
    #[error("there is no {family} named \"{name}\"; known are {known}")]
    UnknownName {
        /// The family that was searched, such as "valve model".
        family: &'static str,
        /// The given name.
        name: String,
        /// The known names, separated by commas.
        known: String,
    },
    /// A missing setting.
    #[error("{needed_by} needs {name}")]
    Missing {
        /// Name of the setting; several with commas between.
        name: String,
        /// The part that needs it: a model, a law, or another setting.
        needed_by: &'static str,
    },
    /// A setting of a different valve model.
    #[error("{name} is {role} of model {models} only")]
    NotOfModel {
        /// Name of the setting.
        name: &'static str,
        /// Meaning of the setting, such as "the overshoot".
        role: &'static str,
        /// Names of the models that have it, separated by commas.
        models: String,
    },
    /// Settings that exclude each other, or a setting that needs another setting.
    #[error("{0}")]
    Inconsistent(String),
    /// An invalid loop among many.
    #[error("loop {index}: {source}")]
    InLoop {
        /// Index, from 0.
        index: usize,
        /// The reason.
        source: Box<Error>,
    },
    /// An unusable frozen model.
    #[error("the model of the verdict cannot be used: {0}")]
    Bundle(String),
    /// The progress callback asked to stop.
    #[error("the computation was cancelled")]
    Cancelled,
    /// A numerical method that could not continue.
    #[error("the {method} stopped at t = {time_s} s: {reason}")]
    Solver {
        /// Name of the method.
        method: &'static str,
        /// Simulated time at which it stopped, s.
        time_s: f64,
        /// The reason, in words.
        reason: String,
    },
}

/// The library's result type.
pub type Result<T> = std::result::Result<T, Error>;

/// Accepts `value` if it is finite and `ok`, else reports `allowed`.
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

/// Accepts `samples` if all are finite, else reports the first invalid one.
pub fn all_finite(signal: &'static str, samples: &[f64]) -> Result<()> {
    // In blocks, each checked to its end: that compiles to wide instructions.
    let sound = |block: &[f64]| block.iter().fold(true, |all, v| all & v.is_finite());
    if samples.chunks(256).all(sound) {
        return Ok(());
    }
    match samples.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Error::NonFinite { signal, index, value: samples[index] }),
    }
}
