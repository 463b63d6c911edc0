//! Families of simulated loops.

use super::swinging_door;
use crate::bands::Bands;
use crate::closed_loop::{AntiWindup, ClosedLoop, Controller, Process, Signal, Wave};
use crate::error::{Error, Result};
use crate::recording::{LoopType, Recording};
use crate::series::std;
use crate::valve::{Assembly, Model};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// How many samples a recording has.
const SAMPLES: usize = 2000;

/// A family of simulated flow loops: a first-order process with dead time under a PI controller, one
/// sample a second, 2,000 samples.
///
/// Drawn for every loop, u being uniform and lu uniform in the logarithm: gain lu(0.5, 2) of either
/// sign, time constant lu(2, 15) s, dead time u(0.2, 0.8) of it; Kc a sixth to a third of the
/// ultimate gain, Ti u(0.8, 1.5) time constants; OP at rest u(30, 70) %; noise of the PV
/// with a standard deviation of u(0.02, 0.3) PV units per percent of gain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Case {
    /// A valve that sticks: two-phase (7 of 10) or He, S lu(1, 8) %, J/S u(0.1, 1). A load step before the
    /// recording and a slow random walk keep it from resting at the set point.
    Sticky,
    /// A healthy valve, and a sinusoidal load of amplitude u(2, 6) %, period u(8, 40) time constants.
    Sine,
    /// A healthy valve, and a load that drifts as a random walk.
    Drift,
    /// A healthy valve, and a set point that steps up and down every 100 to 300 s.
    SetPointSteps,
    /// A healthy valve, and a sinusoidal load, of period u(30, 80) time constants, that is 1.4 to 2
    /// times larger than the OP can make good.
    Saturation,
    /// A healthy valve, and a controller with u(0.85, 0.95) of the ultimate gain, Ti six time
    /// constants.
    AggressiveTuning,
    /// A healthy valve under a load that wanders, and a coarse transmitter: a resolution of u(0.5, 1.5)
    /// standard deviations of the PV.
    QuantisedPv,
    /// A healthy valve under a wandering load, OP and PV compressed by a swinging door of half a
    /// standard deviation and interpolated.
    Compressed,
    /// A healthy valve, and nothing but noise.
    Noise,
}

/// What is true of a simulated loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Whether its valve sticks.
    pub sticks: bool,
    /// Stick band plus dead band, percent of span.
    pub s: f64,
    /// Slip jump, percent of span.
    pub j: f64,
}

/// A simulated recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// What a plant would have recorded: SP, PV and OP.
    pub recording: Recording,
    /// What is true of the loop.
    pub truth: Truth,
}

impl Case {
    /// All families, the sticky one first.
    pub const ALL: [Self; 9] = [
        Self::Sticky,
        Self::Sine,
        Self::Drift,
        Self::SetPointSteps,
        Self::Saturation,
        Self::AggressiveTuning,
        Self::QuantisedPv,
        Self::Compressed,
        Self::Noise,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sticky => "sticky valve",
            Self::Sine => "sine disturbance",
            Self::Drift => "drift",
            Self::SetPointSteps => "set-point steps",
            Self::Saturation => "saturation",
            Self::AggressiveTuning => "aggressive tuning",
            Self::QuantisedPv => "quantised PV",
            Self::Compressed => "compressed data",
            Self::Noise => "noise",
        }
    }

    /// The loop of that seed, simulated.
    ///
    /// # Errors
    /// None is known; those of the simulation are passed on.
    pub fn simulate(self, seed: u64) -> Result<Simulated> {
        let mut draw = Draw::new(self, seed);
        let gain = draw.log(0.5, 2.0) * draw.sign();
        let tau = draw.log(2.0, 15.0);
        let dead_time = tau * draw.uniform(0.2, 0.8);
        let (ti, share_of_ultimate) = match self {
            Self::AggressiveTuning => (6.0 * tau, draw.uniform(0.85, 0.95)),
            _ => (tau * draw.uniform(0.8, 1.5), draw.uniform(1.0 / 6.0, 1.0 / 3.0)),
        };
        let kc = ultimate_gain(tau, dead_time, ti) / gain * share_of_ultimate;
        let (valve, truth) = match self {
            Self::Sticky => {
                let model = if draw.uniform(0.0, 1.0) < 0.7 { Model::TwoPhase } else { Model::He };
                let s = draw.log(1.0, 8.0);
                let j = s * draw.uniform(0.1, 1.0);
                (model.build(Bands::from_s_j(s, j)?)?, Truth { sticks: true, s, j })
            }
            _ => (
                Model::Ideal.build(Bands::from_s_j(0.0, 0.0)?)?,
                Truth { sticks: false, s: 0.0, j: 0.0 },
            ),
        };
        let controller = Controller::pi(kc, ti)?;
        let mut system = ClosedLoop::new(
            controller.with_limits(0.0, 100.0, AntiWindup::Clamping)?,
            Assembly::new(valve),
            Process::first_order(gain, tau, dead_time)?,
        );
        system.sample_time = 1.0;
        // What comes before the loop has settled into its cycle is not recorded.
        let settling = 1000;
        system.samples = settling + SAMPLES;
        system.op_rest = draw.uniform(30.0, 70.0);
        system.pv_rest = draw.uniform(20.0, 80.0);
        system.set_point = system.pv_rest.into();
        let scale = gain.abs();
        let noise_sd = scale * draw.uniform(0.02, 0.3);
        system.measurement = vec![Signal::Noise { sd: noise_sd, tau_s: 0.0, seed: draw.next() }];
        let mut wander = |sd: f64| Signal::Noise { sd, tau_s: 20.0 * tau, seed: draw.next() };
        match self {
            Self::Sine | Self::Saturation => {
                let room = system.op_rest.min(100.0 - system.op_rest);
                let (amplitude, shortest, longest) = match self {
                    Self::Sine => (draw.uniform(2.0, 6.0), 8.0, 40.0),
                    // The OP must go as far as the load comes, and cannot.
                    _ => (room * draw.uniform(1.4, 2.0), 30.0, 80.0),
                };
                system.load.push(Signal::Periodic {
                    wave: Wave::Sine,
                    mean: 0.0,
                    amplitude,
                    period_s: tau * draw.uniform(shortest, longest),
                    phase: draw.uniform(0.0, 1.0),
                });
            }
            Self::Drift => system
                .load
                .push(Signal::RandomWalk { sd_per_sqrt_s: draw.log(0.05, 0.4), seed: draw.next() }),
            Self::SetPointSteps => {
                let mut steps = vec![(0.0, system.pv_rest)];
                let mut at = 0.0;
                while at < system.samples as f64 {
                    at += draw.uniform(100.0, 300.0);
                    let size = scale * draw.uniform(1.0, 8.0) * draw.sign();
                    steps.push((at, system.pv_rest + size));
                }
                system.set_point = Signal::Steps(steps);
            }
            Self::QuantisedPv | Self::Compressed => system.load.push(wander(3.0)),
            // A valve at rest at the set point would rest for ever.
            Self::Sticky => {
                let offset = draw.uniform(1.0, 5.0) * draw.sign();
                system.load = vec![
                    Signal::step(0.0, offset, 1.0),
                    Signal::RandomWalk { sd_per_sqrt_s: draw.log(0.002, 0.02), seed: draw.next() },
                ];
            }
            Self::AggressiveTuning | Self::Noise => {}
        }
        if self == Self::QuantisedPv {
            let pv = system.run()?.pv;
            system.pv_quantum = std(&pv[settling..]) * draw.uniform(0.5, 1.5);
        }
        let run = system.run()?;
        let recorded = |x: Vec<f64>| {
            let x = x[settling..].to_vec();
            if self == Self::Compressed { swinging_door(&x, 0.5 * std(&x)) } else { x }
        };
        let (op, pv) = (recorded(run.op), recorded(run.pv));
        let sp = &run.sp[settling..];
        if op.iter().chain(&pv).any(|v| !v.is_finite()) {
            return Err(Error::Inconsistent(format!("{} {seed} is unstable", self.name())));
        }
        let name = format!("{} {seed}", self.name());
        let mut recording = Recording::regular(name, 1.0, &op, Some(&pv), Some(sp))?;
        recording.loop_type = LoopType::Flow;
        Ok(Simulated { recording, truth })
    }
}

/// The gain of a PI controller with integral time `ti` at which its loop with
/// `exp(-theta s) / (tau s + 1)` cycles: that of the frequency at which
/// `w theta + atan(w tau) + atan(1 / (w ti)) = pi`.
fn ultimate_gain(tau: f64, theta: f64, ti: f64) -> f64 {
    // A sampled controller and its hold delay by half a sample more.
    let theta = theta + 0.5;
    let (mut low, mut high) = (0.5 / tau, std::f64::consts::PI / theta);
    for _ in 0..60 {
        let w = 0.5 * (low + high);
        let phase = w * theta + (w * tau).atan() + (1.0 / (w * ti)).atan();
        if phase < std::f64::consts::PI { low = w } else { high = w }
    }
    ((1.0 + (low * tau).powi(2)) / (1.0 + (low * ti).powi(-2))).sqrt()
}

/// The stream of numbers that a loop is drawn from.
struct Draw(Xoshiro256PlusPlus);

impl Draw {
    fn new(case: Case, seed: u64) -> Self {
        // Families do not share loops: each has its own part of the seeds.
        let family = Case::ALL.iter().position(|each| *each == case).unwrap_or(0) as u64;
        Self(Xoshiro256PlusPlus::seed_from_u64(seed ^ (family << 56)))
    }

    fn next(&mut self) -> u64 {
        self.0.next_u64()
    }

    fn uniform(&mut self, from: f64, to: f64) -> f64 {
        let unit = (self.next() >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
        from + unit * (to - from)
    }

    fn log(&mut self, from: f64, to: f64) -> f64 {
        self.uniform(from.ln(), to.ln()).exp()
    }

    fn sign(&mut self) -> f64 {
        if self.next() >> 63 == 0 { 1.0 } else { -1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::{max, mean, min};

    #[test]
    fn loops_are_finite_distinct_and_repeatable() {
        for case in Case::ALL {
            let loops: Vec<_> = (0..50).map(|seed| case.simulate(seed).unwrap()).collect();
            for (k, simulated) in loops.iter().enumerate() {
                assert_eq!(simulated, &case.simulate(k as u64).unwrap());
                assert_eq!(simulated.truth.sticks, case == Case::Sticky);
                assert_eq!(simulated.recording.op.values.len(), SAMPLES);
                assert!(k == 0 || simulated.recording.op != loops[k - 1].recording.op);
            }
        }
    }

    #[test]
    fn families_are_what_they_say() {
        for seed in 0..50 {
            let of = |case: Case| case.simulate(seed).unwrap().recording;
            let op = of(Case::Saturation).op.values;
            assert!(min(&op) == 0.0 || max(&op) == 100.0, "seed {seed} does not saturate");
            let pv = of(Case::QuantisedPv).pv.unwrap().values;
            let mut levels = pv.clone();
            levels.sort_by(f64::total_cmp);
            levels.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            assert!(levels.len() < 30, "seed {seed} has {} levels", levels.len());
            let op = of(Case::AggressiveTuning).op.values;
            assert!(std(&op) < 30.0 && (mean(&op) - 50.0).abs() < 30.0, "seed {seed} is unstable");
        }
    }
}
