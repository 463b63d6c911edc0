//! Spells in manual: somebody moves the OP.

use super::between::{Between, IntegralAction, Sent};
use super::{ClosedLoop, Signal, SignalSource};
use crate::error::{Error, Result, finite};

/// A spell in manual. From [`from_s`](Self::from_s) on the OP is its value before, plus [`change`](Self::change). The
/// controller follows it, so that automatic continues without a bump.
///
/// A controller without integral action cannot follow, and the return to automatic bumps the OP.
#[derive(Debug, Clone, PartialEq)]
pub struct Manual {
    /// Time of the change to manual, s.
    pub from_s: f64,
    /// Time of the return to automatic, s. The first sample at or after this time is in automatic.
    pub until_s: f64,
    /// Change of the OP since the change to manual, percent of span.
    pub change: Signal,
}

impl ClosedLoop {
    /// Checks the spells in manual.
    pub(super) fn check_manual(&self) -> Result<()> {
        let mut end = 0.0;
        for spell in &self.manual {
            finite("begin of manual", spell.from_s)?;
            let (value, name) = (spell.from_s, "manual from");
            if spell.from_s < end {
                let allowed = format!("at least {end} s, where the period before it ends");
                return Err(Error::Parameter { name, value, allowed });
            }
            if spell.until_s <= spell.from_s || spell.until_s.is_nan() {
                let allowed = format!("above manual from, {value} s");
                return Err(Error::Parameter {
                    name: "manual until",
                    value: spell.until_s,
                    allowed,
                });
            }
            end = spell.until_s;
            spell.change.source(self.sample_time, self.samples)?;
        }
        Ok(())
    }

    /// Whether the sample `k` is in manual.
    pub fn in_manual(&self, k: usize) -> bool {
        self.manual.iter().any(|spell| spell.holds(k as f64 * self.sample_time))
    }
}

impl Manual {
    /// A change at a whole number of samples must not shift by rounding, as in [`Signal::Steps`].
    fn holds(&self, time_s: f64) -> bool {
        (self.from_s..self.until_s).contains(&(time_s * (1.0 + 1e-12)))
    }
}

/// The spells of a loop, sample by sample.
pub(super) struct ByHand<'a> {
    plant: &'a ClosedLoop,
    changes: Vec<SignalSource>,
    /// The OP that the valve received.
    pub op: Vec<f64>,
    /// The spell of the last sample, with the OP before it.
    now: Option<(usize, f64)>,
}

impl<'a> ByHand<'a> {
    pub fn new(plant: &'a ClosedLoop) -> Result<Self> {
        let changes = plant.manual.iter();
        let changes = changes.map(|spell| spell.change.source(plant.sample_time, plant.samples));
        let op = Vec::with_capacity(plant.samples);
        Ok(Self { plant, changes: changes.collect::<Result<_>>()?, op, now: None })
    }
}

impl Between for ByHand<'_> {
    fn integral(&mut self, _: f64, _: f64) -> IntegralAction {
        IntegralAction::Acts
    }

    fn send(&mut self, _: f64, _: f64, op: f64) -> Sent {
        let time_s = self.op.len() as f64 * self.plant.sample_time;
        let spell = self.plant.manual.iter().position(|spell| spell.holds(time_s));
        let mut change = 0.0;
        for (k, source) in self.changes.iter_mut().enumerate() {
            let drawn = source.draw();
            change = if spell == Some(k) { drawn } else { change };
        }
        let sent = match spell {
            None => {
                self.now = None;
                Sent::added(op)
            }
            Some(spell) => {
                let before = match self.now {
                    Some((last, before)) if last == spell => before,
                    _ => self.op.last().copied().unwrap_or(self.plant.op_rest),
                };
                self.now = Some((spell, before));
                let (low, high) = self.plant.controller.output_range();
                Sent::held((before + change).clamp(low, high))
            }
        };
        self.op.push(sent.signal);
        sent
    }
}
