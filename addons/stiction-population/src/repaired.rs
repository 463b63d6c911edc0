//! A sticking loop of the population, recorded before and after the repair of its valve.

use super::LoopKind;
use super::draw::Draw;
use super::member::{self, Scene, fitted};
use super::truth::{Simulated, Truth};
use stiction_diagnose::recording::Recording;
use stiction_model::bands::Bands;
use stiction_model::error::{Error, Result};
use stiction_model::valve::Model;

/// Largest S and J of a repaired valve, percent.
const REPAIRED: (f64, f64) = (0.4, 0.1);

/// A loop before and after the repair of its valve.
#[derive(Debug, Clone, PartialEq)]
pub struct Repaired {
    /// The truth about the loop, over both times.
    pub truth: Truth,
    /// The recording before the repair.
    pub before: Recording,
    /// The recording after the repair, of the same length. Its loads are different, from the same distributions.
    pub after: Recording,
    /// The recording of the same time if the valve had not been repaired.
    pub unrepaired: Recording,
}

impl Repaired {
    /// The sticky loop of this seed, recorded before and after the repair. S and J of the repaired valve are drawn, up to
    /// 0.4 and 0.1 %. `None` without a sample in one of the recordings.
    ///
    /// # Errors
    /// As [`LoopKind::simulate_for`].
    pub fn simulate(seed: u64) -> Result<Option<Self>> {
        Self::simulate_for(seed, 2.0)
    }

    /// Simulates a loop with `factor` times as many samples as usual, half of them before the repair.
    ///
    /// # Errors
    /// As [`LoopKind::simulate_for`].
    pub fn simulate_for(seed: u64, factor: f64) -> Result<Option<Self>> {
        for redrawn in 0..100 {
            let draw = &mut Draw::of(&[seed, redrawn]);
            let mut found = None;
            let mut then = |scene: &Scene<'_>, simulated: &Simulated| -> Result<()> {
                let design = scene.design;
                let at_s = (design.samples / 2) as f64 * design.sample_time;
                let mut of_valve = Draw::of(&[seed, redrawn, 78]);
                let (s, j) = (of_valve.uniform(0.0, REPAIRED.0), of_valve.uniform(0.0, REPAIRED.1));
                let bands = Bands::from_s_j(s, j.min(s))?;
                let played = scene.plant.play(&[fitted(0, Model::TwoPhase.build(bands)?)])?;
                let repaired = member::recorded(design, &design.historian, &played)?;
                let recording = &simulated.recording;
                let later = |of: &Recording| of.part(at_s, f64::INFINITY, 0.0);
                let all = (recording.part(0.0, at_s, 0.0), later(&repaired), later(recording));
                if let (Some(before), Some(after), Some(unrepaired)) = all {
                    found =
                        Some(Self { truth: simulated.truth.clone(), before, after, unrepaired });
                }
                Ok(())
            };
            if member::simulate(LoopKind::Sticky, draw, factor, None, &mut then)?.is_some() {
                return Ok(found);
            }
        }
        Err(Error::Inconsistent(format!("sticky valve {seed}: no draw is valid")))
    }
}
