//! The loops that a cause reaches.
//!
//! The network is simulated again with the same noise and loads, but without the cause: the valve is healthy, or the
//! wave is absent. The part of a loop's swing at the cause's period that disappears is due to the cause.

use super::{Course, Network, STEP_S, Samples};
use std::collections::BTreeSet;
use stiction_diagnose::series::{Periodogram, periodogram};
use stiction_model::error::Result;

/// A cause reaches a loop if at least this share of the power at the cause's period disappears without the cause.
pub const REACHED: f64 = 0.5;
/// A loop swings if the power at the period is at least this share of its variance.
pub const SWINGS: f64 = 0.1;
/// The band around a period: frequencies from its own over this factor to its own times it.
const BAND: f64 = 1.25;
/// Signals are compared in means of this length, s, or in samples if these are longer.
const MEAN_S: f64 = 20.0;
/// Range of periods, s.
const PERIODS_S: (f64, f64) = (60.0, 14_400.0);

/// A cause of swinging loops in a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    /// The valve of this loop sticks.
    Valve(usize),
    /// This wave comes from outside.
    Outside(usize),
}

/// The truth about a network over some time.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkTruth {
    /// The effect of each cause.
    pub causes: Vec<Reach>,
    /// The possible sources for each loop: the numbers of loops, including itself, and then the numbers of waves.
    origins: Vec<BTreeSet<usize>>,
}

/// The effect of a cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// The cause.
    pub cause: Cause,
    /// Period, s. For a valve, the period of the strongest swing of its position.
    pub period_s: f64,
    /// For each loop, the share of the power at the period that disappears without the cause, of the error or of
    /// the OP.
    pub vanishes: Vec<f64>,
    /// For each loop, whether it is reached and swings.
    pub swings: Vec<bool>,
}

impl NetworkTruth {
    /// Whether no event can reach both loops. That is the case if no loop and no wave acts on both, directly or through
    /// other loops.
    pub fn apart(&self, a: usize, b: usize) -> bool {
        self.origins[a].is_disjoint(&self.origins[b])
    }
}

impl Network {
    /// The causes: valves that ever stick, then waves.
    pub fn causes(&self) -> Vec<Cause> {
        let sticks = |k: &usize| self.loops[*k].course != Course::Healthy;
        let valves = (0..self.loops.len()).filter(sticks).map(Cause::Valve);
        valves.chain((0..self.outside.len()).map(Cause::Outside)).collect()
    }

    /// The loops that each cause reaches, given the simulation with all causes from the first step of its record
    /// on.
    ///
    /// # Errors
    /// If the settings of a part are invalid. No such case is known.
    pub fn truth(&self, samples: &[Samples]) -> Result<NetworkTruth> {
        let steps = samples.iter().map(|own| own.op.len() as f64 * own.step_s).fold(0.0, f64::max);
        let whole: Vec<[Power; 2]> = samples.iter().map(Power::both).collect();
        let mut causes = vec![];
        for cause in self.causes() {
            let without = self.run(Some(cause))?.record(steps.max(STEP_S))?;
            let period_s = match cause {
                Cause::Valve(k) => swing(&samples[k], &without[k]),
                Cause::Outside(k) => self.outside[k].period_s,
            };
            let mut reach = Reach { cause, period_s, vanishes: vec![], swings: vec![] };
            for (with, without) in whole.iter().zip(&without) {
                let without = Power::both(without);
                let each = with.iter().zip(&without).map(|(with, without)| {
                    let (there, all) = (with.about(period_s), with.all());
                    let vanishes = 1.0 - without.about(period_s) / there.max(f64::MIN_POSITIVE);
                    (vanishes, vanishes >= REACHED && there >= SWINGS * all)
                });
                let (mut most, mut swings) = (f64::NEG_INFINITY, false);
                for (vanishes, is_swing) in each {
                    most = most.max(vanishes);
                    swings |= is_swing;
                }
                reach.vanishes.push(most);
                reach.swings.push(swings);
            }
            causes.push(reach);
        }
        Ok(NetworkTruth { causes, origins: self.origins() })
    }

    fn origins(&self) -> Vec<BTreeSet<usize>> {
        let n = self.loops.len();
        let mut origins: Vec<BTreeSet<usize>> = (0..n).map(|k| BTreeSet::from([k])).collect();
        for (k, wave) in self.outside.iter().enumerate() {
            for (to, _) in &wave.into {
                origins[*to].insert(n + k);
            }
        }
        let cascades = self.loops.iter().enumerate().filter_map(|(k, own)| Some((k, own.below?)));
        let ways: Vec<(usize, usize)> = (self.links.iter().map(|link| (link.from, link.to)))
            .chain(cascades.flat_map(|(above, below)| [(above, below), (below, above)]))
            .collect();
        // A circular path is complete after as many turns as there are loops.
        for _ in 0..n {
            for (from, to) in &ways {
                let more = origins[*from].clone();
                origins[*to].extend(more);
            }
        }
        origins
    }
}

/// Power over frequency, of means of this many seconds.
struct Power {
    of: Periodogram,
    step_s: f64,
}

impl Power {
    fn of(x: &[f64], step_s: f64) -> Self {
        let many = ((MEAN_S / step_s) as usize).max(1);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / many as f64;
        let means: Vec<f64> = x.chunks_exact(many).map(mean).collect();
        Self { of: periodogram(&means), step_s: many as f64 * step_s }
    }

    /// Of the error and of the OP.
    fn both(samples: &Samples) -> [Self; 2] {
        let error: Vec<f64> = samples.pv.iter().zip(&samples.sp).map(|(pv, sp)| pv - sp).collect();
        [&error, &samples.op].map(|x| Self::of(x, samples.step_s))
    }

    fn all(&self) -> f64 {
        self.of.power.iter().sum()
    }

    /// In the band around a period.
    fn about(&self, period_s: f64) -> f64 {
        let at = self.step_s / period_s;
        let from = self.of.frequency.partition_point(|f| *f < at / BAND);
        let until = self.of.frequency.partition_point(|f| *f <= at * BAND);
        self.of.power[from..until].iter().sum()
    }
}

/// The period of the strongest swing of a valve beyond its healthy movement, s.
fn swing(samples: &Samples, healthy: &Samples) -> f64 {
    let power = Power::of(&samples.vp, samples.step_s);
    let without = Power::of(&healthy.vp, healthy.step_s);
    let (shortest, longest) = (PERIODS_S.0.max(2.5 * power.step_s), PERIODS_S.1);
    let (mut best, mut most) = (shortest, 0.0);
    let mut period = shortest;
    while period <= longest {
        let there = power.about(period) - without.about(period);
        if there > most {
            (best, most) = (period, there);
        }
        period *= 1.03;
    }
    best
}
