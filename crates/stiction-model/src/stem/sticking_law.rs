//! The laws that hold the stem still, during simulation: their resistance and their memory.

use std::collections::VecDeque;

use super::friction::{Armstrong, Karnopp};
use crate::numeric::radau::Step;

/// A friction law during simulation.
#[derive(Debug, Clone)]
pub(super) enum StickingLaw {
    /// Karnopp friction; classical if its band is 0.
    Classical(Karnopp),
    /// Armstrong's law with its memory.
    Armstrong { law: Armstrong, memory: Memory },
}

/// The memory of Armstrong's law.
#[derive(Debug, Clone)]
pub(super) struct Memory {
    /// Velocity over the last `memory_s` seconds; 0 without an entry.
    past: VecDeque<Past>,
    /// Static excess during a slip, or at the end of the last one, N.
    excess_n: f64,
    /// Time at which the stem came to rest, s; minus infinity if it has not moved yet.
    rest_since_s: f64,
    /// Position of the relaxed presliding spring, m.
    anchor_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Past {
    start_s: f64,
    step: Step<2>,
}

impl StickingLaw {
    /// Speed below which the stem counts as standing still, m/s.
    pub(super) fn band(&self) -> f64 {
        match self {
            Self::Classical(law) => law.band_m_per_s(),
            Self::Armstrong { .. } => 0.0,
        }
    }

    /// Armstrong's law for a stem that has never moved, its presliding spring carrying the net force as far as it
    /// can.
    pub(super) fn armstrong(law: Armstrong, position_m: f64, net_n: f64) -> Self {
        let most = law.coulomb_n + law.static_excess_n;
        let memory = Memory {
            past: VecDeque::new(),
            excess_n: law.static_excess_n,
            rest_since_s: f64::NEG_INFINITY,
            anchor_m: position_m - net_n.clamp(-most, most) / law.presliding_n_per_m,
        };
        Self::Armstrong { law, memory }
    }

    /// Friction that must be exceeded to leave rest, N.
    pub(super) fn static_n(&self, time_s: f64) -> f64 {
        match self {
            Self::Classical(law) => law.breakaway_n(),
            Self::Armstrong { law, memory } => {
                let dwell = time_s - memory.rest_since_s;
                law.coulomb_n + law.static_excess_after(memory.excess_n, dwell)
            }
        }
    }

    /// Friction while sliding in the direction `sign`, N.
    pub(super) fn sliding_n(&self, sign: f64, velocity: f64, remembered: f64) -> f64 {
        match self {
            Self::Classical(law) => {
                let steady = law.steady();
                sign * steady.sliding_n(velocity) + steady.viscous_n_s_per_m() * velocity
            }
            Self::Armstrong { law, memory } => {
                let excess = memory.excess_n * law.stribeck_factor(remembered);
                sign * (law.coulomb_n + excess) + law.viscous_n_s_per_m * velocity
            }
        }
    }

    /// Derivative of [`Self::sliding_n`] with respect to the present velocity, N s/m.
    pub(super) fn sliding_slope(&self, sign: f64, velocity: f64) -> f64 {
        match self {
            Self::Classical(law) => {
                let steady = law.steady();
                sign * steady.sliding_slope(velocity) + steady.viscous_n_s_per_m()
            }
            Self::Armstrong { law, memory } if law.memory_s == 0.0 => {
                sign * memory.excess_n * law.stribeck_slope(velocity) + law.viscous_n_s_per_m
            }
            Self::Armstrong { law, .. } => law.viscous_n_s_per_m,
        }
    }

    /// The velocity in the Stribeck part at `time_s`, when the stem moves at `velocity`.
    pub(super) fn remembered(&self, time_s: f64, velocity: f64) -> f64 {
        match self {
            Self::Classical(_) => velocity,
            Self::Armstrong { law, .. } if law.memory_s == 0.0 => velocity,
            Self::Armstrong { law, memory } => memory.velocity_at(time_s - law.memory_s),
        }
    }

    /// Friction on a stem at rest: the net force, up to the breakaway force. An end stop carries the rest.
    pub(super) fn held_n(&self, net_n: f64) -> f64 {
        let most = match self {
            Self::Classical(law) => law.breakaway_n(),
            Self::Armstrong { law, .. } => law.coulomb_n + law.static_excess_n,
        };
        net_n.clamp(-most, most)
    }

    /// Stiffness of the presliding spring, N/m; infinite if the stem does not yield at all.
    pub(super) fn presliding_n_per_m(&self) -> f64 {
        match self {
            Self::Classical(_) => f64::INFINITY,
            Self::Armstrong { law, .. } => law.presliding_n_per_m,
        }
    }

    /// Position of the relaxed presliding spring, m, if there is one.
    pub(super) fn anchor_m(&self) -> Option<f64> {
        match self {
            Self::Classical(_) => None,
            Self::Armstrong { memory, .. } => Some(memory.anchor_m),
        }
    }

    /// Age of the velocity in the Stribeck part, s; 0 for the present one.
    pub(super) fn memory_s(&self) -> f64 {
        match self {
            Self::Classical(_) => 0.0,
            Self::Armstrong { law, .. } => law.memory_s,
        }
    }

    /// Records the start of a slip.
    pub(super) fn break_loose(&mut self, time_s: f64) {
        if let Self::Armstrong { law, memory } = self {
            let dwell = time_s - memory.rest_since_s;
            memory.excess_n = law.static_excess_after(memory.excess_n, dwell);
        }
    }

    /// Records the motion in a step that began at `start_s`.
    pub(super) fn remember(&mut self, start_s: f64, step: &Step<2>) {
        if let Self::Armstrong { law, memory } = self {
            memory.past.push_back(Past { start_s, step: *step });
            let oldest_s = start_s - law.memory_s;
            while memory.past.front().is_some_and(|past| past.end_s() < oldest_s) {
                memory.past.pop_front();
            }
        }
    }

    /// Records the end of a slip with this net force.
    pub(super) fn come_to_rest(&mut self, time_s: f64, position_m: f64, net_n: f64) {
        let remembered = self.remembered(time_s, 0.0);
        if let Self::Armstrong { law, memory } = self {
            memory.excess_n *= law.stribeck_factor(remembered);
            memory.rest_since_s = time_s;
            memory.anchor_m = position_m - net_n / law.presliding_n_per_m;
        }
    }
}

impl StickingLaw {
    /// Appends the memory of the law, as plain numbers.
    pub(super) fn remember_all(&self, numbers: &mut Vec<f64>) {
        if let Self::Armstrong { memory, .. } = self {
            numbers.extend([memory.excess_n, memory.rest_since_s, memory.anchor_m]);
            numbers.push(memory.past.len() as f64);
            for past in &memory.past {
                numbers.push(past.start_s);
                past.step.remember(numbers);
            }
        }
    }

    /// Restores it.
    pub(super) fn recall(&mut self, numbers: &mut dyn Iterator<Item = f64>) -> Option<()> {
        if let Self::Armstrong { memory, .. } = self {
            memory.excess_n = numbers.next()?;
            memory.rest_since_s = numbers.next()?;
            memory.anchor_m = numbers.next()?;
            let count = numbers.next()? as usize;
            memory.past.clear();
            // Ends at the last of the numbers, even if the count is larger.
            for _ in 0..count {
                let (start_s, step) = (numbers.next()?, Step::recalled(numbers)?);
                memory.past.push_back(Past { start_s, step });
            }
        }
        Some(())
    }
}

impl Memory {
    /// Velocity at a past time; 0 where the stem was at rest.
    fn velocity_at(&self, time_s: f64) -> f64 {
        // Rounding may put the last known time slightly before it.
        let slack_s = 4.0 * f64::EPSILON * time_s.abs();
        let at = self.past.partition_point(|past| past.end_s() + slack_s < time_s);
        match self.past.get(at) {
            Some(past) if past.start_s <= time_s => {
                let into_s = (time_s - past.start_s).min(past.step.length);
                past.step.at(past.step.start + into_s)[1]
            }
            _ => 0.0,
        }
    }
}

impl Past {
    fn end_s(&self) -> f64 {
        self.start_s + self.step.length
    }
}
