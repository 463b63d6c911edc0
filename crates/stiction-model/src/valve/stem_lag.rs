//! First-order stem dynamics behind any model.

use crate::error::{Result, non_negative, positive};

/// A first-order lag, `tau x' = input - x`, sampled exactly with the input held over each sample.
///
/// The data-driven models move the stem at once. This lag follows them where the stem's own dynamics matter, as in
/// the paper's step responses.
///
/// `x(k) = a x(k-1) + (1 - a) input(k-1)` with `a = exp(-Ts/tau)`. The lag is strictly proper: the position at a
/// sample does not depend on that sample's input yet. `tau = 0` passes the input through without delay.
#[derive(Debug, Clone, PartialEq)]
pub struct StemLag {
    /// `exp(-Ts/tau)`, or `None` for no lag.
    decay: Option<f64>,
    input: f64,
    position: f64,
}

impl StemLag {
    /// A lag of `tau` seconds sampled every `sample_time` seconds, at rest at 0.
    ///
    /// # Errors
    /// If `tau` is negative or `sample_time` not positive, or either is not finite.
    pub fn new(tau: f64, sample_time: f64) -> Result<Self> {
        let ratio = positive("sample time", sample_time)? / non_negative("stem lag", tau)?;
        let decay = ratio.is_finite().then(|| (-ratio).exp());
        Ok(Self { decay, input: 0.0, position: 0.0 })
    }

    /// The position once the input has become `input`.
    #[inline]
    pub fn step(&mut self, input: f64) -> f64 {
        match self.decay {
            Some(a) => self.position = a * self.position + (1.0 - a) * self.input,
            None => self.position = input,
        }
        self.input = input;
        self.position
    }

    /// The present position.
    pub fn position(&self) -> f64 {
        self.position
    }

    /// Rests at `position`.
    pub fn restart(&mut self, position: f64) {
        self.input = position;
        self.position = position;
    }

    /// Input and position of the last sample.
    pub(super) fn memory(&self) -> [f64; 2] {
        [self.input, self.position]
    }

    /// Continues from there.
    pub(super) fn recall(&mut self, [input, position]: [f64; 2]) {
        (self.input, self.position) = (input, position);
    }
}
