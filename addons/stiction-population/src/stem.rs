//! The stem of a valve in a loop: its model, its lag and its actuator.

use std::iter::Peekable;
use std::vec::IntoIter;
use stiction_model::error::Result;
use stiction_model::valve::{AnyModel, Assembly, Start, StemLag, Valve};

/// A valve model, and the step from which it is in the loop.
#[derive(Debug, Clone)]
pub(super) struct Fitting {
    pub from: usize,
    pub model: AnyModel,
    /// Initial position; by default the stem's position.
    pub position: Option<f64>,
}

/// A valve with its lag and its actuator, and its replacements over time.
pub(super) struct Stem {
    fittings: Peekable<IntoIter<Fitting>>,
    valve: Assembly,
    lag: StemLag,
    /// Largest movement per step, percent.
    most: f64,
    stem: f64,
    vp: f64,
}

impl Stem {
    /// At rest, without friction until the first fitting.
    ///
    /// # Errors
    /// If the lag is invalid.
    pub fn new(fittings: &[Fitting], lag: f64, stroke: f64, step: f64, rest: f64) -> Result<Self> {
        let mut lag = StemLag::new(lag, step)?;
        lag.restart(rest);
        let mut valve =
            Assembly::new(stiction_model::valve::Model::Ideal.build(stiction_model::Bands::NONE)?);
        valve.restart(Start::at_rest(rest));
        let fittings = Vec::from(fittings).into_iter().peekable();
        Ok(Self { fittings, valve, lag, most: stroke * step, stem: rest, vp: rest })
    }

    /// Stem position of the model, and valve position, at step `k` with this OP; `before` was the last.
    ///
    /// # Errors
    /// If the limits are invalid.
    pub fn step(&mut self, k: usize, before: f64, op: f64) -> Result<(f64, f64)> {
        while let Some(next) = self.fittings.next_if(|next| next.from <= k) {
            let position = next.position.unwrap_or(self.stem);
            let start = Start { op: before, ..Start::at_rest(position) };
            self.valve = Assembly::new(next.model).with_limits(0.0, 100.0)?;
            self.valve.restart(start);
        }
        self.stem = self.valve.step(op);
        let wanted = self.lag.step(self.stem);
        self.vp += (wanted - self.vp).clamp(-self.most, self.most);
        Ok((self.stem, self.vp))
    }
}
