//! The interface of a model, for any version of FMI.
//!
//! The values of all variables are kept outside, in the order of the table. A model reads inputs and parameters there,
//! and writes its outputs there.

use crate::variables::Numbers;

/// The reason of a refusal, in a sentence.
pub(crate) type Result<T> = std::result::Result<T, String>;

/// A model with its state.
pub(crate) trait FmuModel: Send + Sync {
    /// Starts at `time` with the present parameters and inputs.
    fn restart(&mut self, values: &mut Numbers, time: f64) -> Result<()>;

    /// Applies tuned parameters and continues from the present state.
    fn tune(&mut self, values: &Numbers) -> Result<()>;

    /// Continues from `time` by `step`, both in s, with the inputs held. After an error it cannot continue.
    fn step(&mut self, values: &mut Numbers, time: f64, step: f64) -> Result<()>;

    /// State besides the values, as plain numbers.
    fn memory(&self) -> Vec<f64>;

    /// Restores the state, after a restart with the same parameters.
    fn recall(&mut self, values: &Numbers, memory: &[f64]) -> Result<()>;

    /// The model as differential equations, if an external solver can compute it.
    fn continuous(&mut self) -> Option<&mut dyn Continuous> {
        None
    }

    /// A copy with its state.
    fn copy(&self) -> Box<dyn FmuModel>;
}

/// A model as differential equations with events.
pub(crate) trait Continuous {
    /// The values of the continuous states.
    fn states(&self) -> Vec<f64>;

    /// Sizes of the states, by which a solver scales its tolerance.
    fn nominals(&self, values: &Numbers) -> Vec<f64>;

    /// Moves to the solver's time, with `states` if they have changed, and writes the outputs.
    fn place(&mut self, values: &mut Numbers, time: f64, states: Option<&[f64]>);

    /// The rates of the states.
    fn rates(&self, values: &Numbers) -> Vec<f64>;

    /// Numbers whose change of sign is an event; their number is constant.
    fn indicators(&self) -> Vec<f64>;

    /// Changes the mode after an event, and returns whether an event occurred.
    fn pass_events(&mut self, values: &mut Numbers) -> Result<bool>;
}

/// Counts the slips of a stem: starts of motion and reversals.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moves {
    /// Direction of the last motion: 1 up, -1 down, 0 at rest.
    pub(crate) direction: f64,
}

impl Moves {
    /// Records a sample in which the stem moved from `before` to `after`; `outputs` are
    /// [`MOVES`](crate::variables::MOVES).
    #[inline]
    pub(crate) fn note(&mut self, before: f64, after: f64, outputs: &mut [f64]) {
        if after == before {
            if self.direction != 0.0 {
                self.direction = 0.0;
                outputs[0] = 1.0;
            }
        } else {
            let direction = 1f64.copysign(after - before);
            if direction != self.direction {
                self.direction = direction;
                outputs[0] = 0.0;
                count(outputs);
            }
        }
    }

    /// A stem at rest that has not moved yet.
    pub(crate) fn begin(outputs: &mut [f64]) -> Self {
        outputs.copy_from_slice(&[1.0, 0.0]);
        Self::default()
    }
}

/// Counts one slip, up to 32 bits.
pub(crate) fn count(outputs: &mut [f64]) {
    outputs[1] = (outputs[1] + 1.0).min(f64::from(i32::MAX));
}
