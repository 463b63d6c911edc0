//! Loops with a recorded valve position and known truth, as reported by a positioner's transmitter.
//!
//! Loops come from two sources. [`observed`] uses a loop of the population and also records the position of its stem.
//! [`positioned`] is a separate generator for cases outside the population: a stem that lags by 0 to 15 samples, OP
//! noise of 0.05 to 4 %, a controller that acts once, twice or four times a sample.
//!
//! ```text
//! error ─> PI ─> OP ─> dead time ─> (lag) ─> valve ─> (lag) ─> stem ─> dead time, lag ─> + load, noise ─> PV
//!                 │                                     └─> lag, gain, offset, noise, steps ─> VP
//!                 └─> recorded at the beginning of each sample; VP a part of a sample later
//! ```

use super::Simulated;
use super::draw::Draw;
use stiction_diagnose::diagnose::HARMLESS;
use stiction_diagnose::recording::{Channel, Recording};
use stiction_diagnose::series::span;
use stiction_model::bands::Bands;
use stiction_model::closed_loop::NormalStream;
use stiction_model::error::Result;
use stiction_model::valve::{AnyModel, Direction, Model, Start, Valve};

/// The position transmitter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmitter {
    /// First-order lag, samples.
    pub lag: f64,
    /// Percent of VP per percent of position.
    pub gain: f64,
    /// VP at position 0, percent.
    pub offset: f64,
    /// Standard deviation of white noise, percent.
    pub noise: f64,
    /// Resolution, percent.
    pub quantum: f64,
}

impl Transmitter {
    /// Without a lag: gain 0.9 to 1.1, offset within 3 %, noise 0.01 to 0.3 %, steps of 0.01 to 0.5 %.
    fn draw(draw: &mut Draw) -> Self {
        Self {
            lag: 0.0,
            gain: draw.uniform(0.9, 1.1),
            offset: draw.uniform(-3.0, 3.0),
            noise: draw.log(0.01, 0.3),
            quantum: draw.log(0.01, 0.5),
        }
    }

    fn read(&self, position: &[f64], seed: u64) -> Vec<f64> {
        let mut noise = NormalStream::new(seed);
        let left = lag(self.lag);
        let mut seen = position.first().copied().unwrap_or(0.0);
        let read = |x: &f64| {
            seen = x + left * (seen - x);
            let value = self.offset + self.gain * seen + self.noise * noise.draw();
            rounded(value, self.quantum)
        };
        position.iter().map(read).collect()
    }
}

/// A loop of the population with its position recorded, behind an additional lag of 0 to 15 samples (none in three
/// of ten). It depends only on the loop and `seed`.
///
/// # Errors
/// If the position does not have one number per sample of the OP. Loops of the population always do.
pub fn observed(simulated: &Simulated, seed: u64) -> Result<Recording> {
    let mut draw = Draw::of(&[seed, 1]);
    let mut transmitter = Transmitter::draw(&mut draw);
    if draw.chance(0.7) {
        transmitter.lag = draw.log(0.2, 15.0);
    }
    let mut recording = simulated.recording.clone();
    let vp = transmitter.read(&simulated.truth.vp, draw.seed());
    let time = recording.op.time.clone();
    recording.vp = Some(Channel::new("VP", time, vp)?);
    Ok(recording)
}

/// The truth about a loop of [`positioned`].
#[derive(Debug, Clone, PartialEq)]
pub struct PositionTruth {
    /// Whether the valve sticks, with an S of at least 0.3 %.
    pub sticks: bool,
    /// Model.
    pub model: Model,
    /// Stick band plus dead band, percent; at most 0.25 for a healthy valve.
    pub s: f64,
    /// Slip jump, percent.
    pub j: f64,
    /// Lag of the stem, samples.
    pub lag: f64,
    /// Whether the lag lies before the friction.
    pub before: bool,
    /// Executions of the controller per sample.
    pub acts: usize,
    /// Standard deviation of the noise on the OP, percent.
    pub op_noise: f64,
    /// Dead time between OP and valve, samples.
    pub dead_time: f64,
    /// Number of slips of the stem.
    pub slips: usize,
    /// The transmitter.
    pub transmitter: Transmitter,
    /// Position of the stem at the recorded times, percent.
    pub vp: Vec<f64>,
}

/// A recording of [`positioned`], with its truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Positioned {
    /// OP, PV, SP and VP.
    pub recording: Recording,
    /// Truth.
    pub truth: PositionTruth,
}

/// Number of steps of the simulation in a sample.
const STEPS: usize = 8;
/// Level of OP, PV and SP, percent.
const LEVEL: f64 = 50.0;

/// Loop number `index` of `seed`: a PI controller on a first-order process with dead time, 500 to 5,000 samples.
/// Three of five valves stick: S 0.3 to 8, any J. The others follow, or have a dead band up to 0.25 or a resolution
/// of 0.1.
///
/// # Errors
/// None is known.
pub fn positioned(seed: u64, index: u64) -> Result<Positioned> {
    let mut draw = Draw::of(&[seed, index, 2]);
    loop {
        let design = Design::draw(&mut draw);
        let played = design.play(&mut draw)?;
        let fits = played.op.iter().all(|u| u.abs() < LEVEL) && span(&played.op) > 0.0;
        if fits {
            return design.record(played, index, &mut draw);
        }
    }
}

/// A loop with its tapes.
struct Design {
    samples: usize,
    acts: usize,
    model: Model,
    sticks: bool,
    s: f64,
    j: f64,
    lag: f64,
    before: bool,
    dead_time: f64,
    /// Time within a sample at which the position is read, as a share.
    phase: f64,
    kc: f64,
    ti: f64,
    tau: f64,
    process_dead_time: f64,
    op_noise: f64,
    /// Share of the filter's output that remains after an execution.
    filter: f64,
    load: Vec<f64>,
    sp: Vec<f64>,
}

/// Result; OP, PV less [`LEVEL`].
struct Played {
    op: Vec<f64>,
    pv: Vec<f64>,
    position: Vec<f64>,
    slips: usize,
}

impl Design {
    fn draw(draw: &mut Draw) -> Self {
        let samples = draw.log(500.0, 5_000.0) as usize;
        let acts = draw.one_of([1, 1, 1, 2, 4]);
        let lag = if draw.chance(0.15) { 0.0 } else { draw.log(0.2, 15.0) };
        let phase = draw.one_of([0.0, 0.0, 0.5, 0.9]);
        let dead_time = if draw.chance(2.0 / 3.0) { 0.0 } else { draw.uniform(0.0, 2.0) };
        let before = draw.chance(0.2);
        let sticks = draw.chance(0.6);
        let (model, s, j) = if sticks {
            let s = draw.log(0.3, 8.0);
            let j = s * draw.unit();
            let kinds = [Model::TwoPhase, Model::TwoPhase, Model::He, Model::Stenman, Model::Play];
            match draw.one_of(kinds) {
                Model::Stenman => (Model::Stenman, s, s),
                Model::Play => (Model::Play, s, 0.0),
                model => (model, s, j),
            }
        } else {
            match draw.count(0, 3) {
                0 | 1 => (Model::Ideal, 0.0, 0.0),
                2 => (Model::Play, draw.uniform(0.0, HARMLESS), 0.0),
                _ => (Model::Stenman, 0.1, 0.1),
            }
        };
        // Times in samples.
        let tau = draw.log(3.0, 60.0);
        let process_dead_time = 0.5 + tau * draw.uniform(0.0, 0.3);
        let slow = tau + 0.5 * lag;
        let behind = process_dead_time + dead_time + 0.5 * lag + 0.5;
        let kc = slow / (behind + draw.uniform(0.5, 3.0) * (behind + 0.2 * slow));
        let ti = slow.min(5.0 * behind) * draw.uniform(0.6, 1.3);
        let op_noise = draw.log(0.05, 4.0);
        let filter = draw.one_of([0.0, 0.0, 0.6]);
        let (load, sp) = tapes(samples, draw);
        Self {
            samples,
            acts,
            model,
            sticks,
            s,
            j,
            lag,
            before,
            dead_time,
            phase,
            kc,
            ti,
            tau,
            process_dead_time,
            op_noise,
            filter,
            load,
            sp,
        }
    }

    fn play(&self, draw: &mut Draw) -> Result<Played> {
        let per_act = STEPS / self.acts;
        let noise = self.op_noise / self.kc / ((1.0 - self.filter) / (1.0 + self.filter)).sqrt();
        let mut stream = NormalStream::new(draw.seed());
        let mut valve: AnyModel = self.model.build(Bands::from_s_j(self.s, self.j)?)?;
        valve.restart(Start { position: 0.0, op: 0.0, direction: Direction::Up, moving: false });
        let stem_left = lag(self.lag * STEPS as f64);
        let process_left = lag(self.tau * STEPS as f64);
        let mut to_valve = Delay::new(self.dead_time);
        let mut to_process = Delay::new(self.process_dead_time);
        let (mut pressure, mut friction, mut stem) = (0.0, 0.0, 0.0);
        let (mut output, mut integral, mut filtered, mut op) = (0.0, 0.0, 0.0, 0.0);
        let (mut slips, mut rested) = (0, true);
        let mut played =
            Played { op: vec![], pv: vec![], position: Vec::with_capacity(self.samples), slips: 0 };
        let read_at = (self.phase * STEPS as f64) as usize;
        for k in 0..self.samples {
            let before = friction;
            for step in 0..STEPS {
                if step % per_act == 0 {
                    let pv = output + self.load[k] + noise * stream.draw();
                    filtered = self.filter * filtered + (1.0 - self.filter) * pv;
                    let error = self.sp[k] - filtered;
                    integral += self.kc / self.ti * error / self.acts as f64;
                    op = self.kc * error + integral;
                    if step == 0 {
                        played.op.push(op);
                        played.pv.push(pv);
                    }
                }
                let told = to_valve.through(op);
                if self.before {
                    pressure = told + stem_left * (pressure - told);
                    friction = valve.step(pressure);
                    stem = friction;
                } else {
                    // An element that acts only once a step would be a different valve for other steps.
                    if step % per_act == 0 || self.dead_time > 0.0 {
                        friction = valve.step(told);
                    }
                    stem = friction + stem_left * (stem - friction);
                }
                if step == read_at {
                    played.position.push(stem);
                }
                let flow = to_process.through(stem);
                output = flow + process_left * (output - flow);
            }
            let rests = friction == before;
            slips += usize::from(rested && !rests);
            rested = rests;
        }
        Ok(Played { slips, ..played })
    }

    fn record(self, played: Played, index: u64, draw: &mut Draw) -> Result<Positioned> {
        let transmitter = Transmitter::draw(draw);
        let sample_time = draw.one_of([0.5, 1.0, 2.0, 5.0, 10.0]);
        let (op_quantum, pv_quantum) =
            (draw.one_of([0.0, 0.01, 0.1]), draw.one_of([0.0, 0.01, 0.02, 0.05]));
        let position: Vec<f64> = played.position.iter().map(|x| LEVEL + x).collect();
        let vp = transmitter.read(&position, draw.seed());
        let recorded = |x: &[f64], quantum: f64| -> Vec<f64> {
            x.iter().map(|x| rounded(LEVEL + x, quantum)).collect()
        };
        let (op, pv) = (recorded(&played.op, op_quantum), recorded(&played.pv, pv_quantum));
        let sp = recorded(&self.sp, 0.0);
        let name = format!("position {index}");
        let mut recording = Recording::regular(name, sample_time, &op, Some(&pv), Some(&sp))?;
        recording.vp = Some(Channel::new("VP", recording.op.time.clone(), vp)?);
        let truth = PositionTruth {
            sticks: self.sticks,
            model: self.model,
            s: self.s,
            j: self.j,
            lag: self.lag,
            before: self.before,
            acts: self.acts,
            op_noise: self.op_noise,
            dead_time: self.dead_time,
            slips: if self.sticks { played.slips } else { 0 },
            transmitter,
            vp: position,
        };
        Ok(Positioned { recording, truth })
    }
}

/// Load and set point: a wave or a wandering load, or a set point with a few steps.
fn tapes(n: usize, draw: &mut Draw) -> (Vec<f64>, Vec<f64>) {
    let (mut load, mut sp) = (vec![0.0; n], vec![0.0; n]);
    let kind = draw.count(0, 2);
    let size = if kind == 0 { draw.uniform(4.0, 12.0) } else { draw.uniform(0.5, 3.0) };
    if kind == 2 {
        let size = draw.uniform(1.0, 8.0);
        let rest = n as f64 / draw.count(3, 11) as f64;
        let mut k = 0;
        while k < n {
            sp[k..].fill(draw.uniform(-size, size));
            k += 1 + (-rest * (1.0 - draw.unit()).ln()) as usize;
        }
    } else if draw.chance(1.0 / 3.0) {
        let (period, phase) = (draw.uniform(40.0, 400.0), draw.uniform(0.0, 6.0));
        let wave = |k| size * (std::f64::consts::TAU * k as f64 / period + phase).sin();
        load = (0..n).map(wave).collect();
    } else {
        let left = lag(draw.uniform(20.0, 200.0));
        let mut stream = NormalStream::new(draw.seed());
        let mut value = 0.0;
        for load in &mut load {
            value = left * value + size * (1.0 - left * left).sqrt() * stream.draw();
            *load = value;
        }
    }
    (load, sp)
}

/// Output after a delay of this many samples.
struct Delay {
    held: Vec<f64>,
    at: usize,
}

impl Delay {
    fn new(samples: f64) -> Self {
        Self { held: vec![0.0; (samples * STEPS as f64).round() as usize + 1], at: 0 }
    }

    fn through(&mut self, x: f64) -> f64 {
        self.held[self.at] = x;
        self.at = (self.at + 1) % self.held.len();
        self.held[self.at]
    }
}

/// Share that remains after a step of a first-order lag of this many steps.
fn lag(steps: f64) -> f64 {
    if steps > 0.0 { (-1.0 / steps).exp() } else { 0.0 }
}

fn rounded(x: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (x / quantum).round() * quantum } else { x }
}
