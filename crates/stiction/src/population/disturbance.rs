//! What happens to a loop from outside, step by step: load, noise, set point, and the cause a kind is
//! named after.

use super::Kind;
use super::design::{Design, NoiseKind, SetPointKind};
use super::draw::Draw;
use crate::closed_loop::{NormalStream, Signal, Wave};
use crate::error::Result;

/// What drives a loop, one value a step.
pub(super) struct Tapes {
    /// Adds to the valve position before the process, percent.
    pub load: Vec<f64>,
    /// Adds to the PV before the transmitter, percent of span.
    pub output: Vec<f64>,
    /// Adds to the PV in the transmitter, percent of span.
    pub noise: Vec<f64>,
    /// Set point, or the part of it that does not come from a controller above; percent of span.
    pub set_point: Vec<f64>,
}

impl Tapes {
    /// All that happens to a loop of this kind.
    ///
    /// # Errors
    /// If a signal refuses its settings.
    pub fn draw(kind: Kind, design: &Design, draw: &mut Draw) -> Result<Self> {
        let mut cause = draw.fork();
        let n = design.all_steps();
        let mut tapes = Self {
            load: vec![0.0; n],
            output: vec![0.0; n],
            noise: noise(design, draw)?,
            set_point: set_point(kind, design, draw)?,
        };
        tapes.everyday(design, draw)?;
        match kind {
            Kind::Sine => tapes.oscillation(design, &mut cause, sine)?,
            Kind::Irregular => tapes.oscillation(design, &mut cause, narrow_band)?,
            Kind::ExternalWave => tapes.oscillation(design, &mut cause, slip_wave)?,
            Kind::ProcessNonlinearity => {
                let regular = cause.chance(0.5);
                let wave =
                    oscillation(design, &mut cause, if regular { sine } else { narrow_band })?;
                let size = design.activity * cause.uniform(1.0, 3.5);
                add(&mut tapes.load, &wave, size);
            }
            Kind::Saturation => tapes.too_much(design, &mut cause)?,
            _ => {}
        }
        Ok(tapes)
    }

    /// What happens to every loop.
    fn everyday(&mut self, design: &Design, draw: &mut Draw) -> Result<()> {
        let (a, step) = (design.activity, design.step());
        let duration = self.load.len() as f64 * step;
        let load = &mut self.load;
        // A valve at rest at the set point would rest for ever.
        let offset = a * draw.sign() * draw.uniform(0.3, 1.5);
        load.iter_mut().for_each(|v| *v = offset);
        if draw.chance(0.6) {
            let sd_per_sqrt_s = a * draw.log(0.05, 1.5) / duration.sqrt();
            play(load, step, &Signal::RandomWalk { sd_per_sqrt_s, seed: draw.seed() })?;
        }
        if draw.chance(0.3) {
            for _ in 0..draw.count(1, 5) {
                let size = a * draw.sign() * draw.uniform(0.3, 2.0);
                let at = draw.uniform(0.0, duration);
                play(load, step, &Signal::step(0.0, size, at))?;
            }
        }
        if draw.chance(0.2) {
            let from = draw.uniform(-0.2, 0.8) * duration;
            let length = draw.uniform(0.1, 0.8) * duration;
            ramp(load, from / step, length / step, a * draw.sign() * draw.uniform(0.5, 3.0));
        }
        if draw.chance(0.12) {
            for _ in 0..draw.count(1, 4) {
                let size = a * draw.sign() * draw.uniform(0.5, 2.0);
                let from = draw.uniform(0.0, duration);
                let until = from + duration * draw.uniform(0.02, 0.15);
                let pulse = Signal::Steps(vec![(f64::MIN, 0.0), (from, size), (until, 0.0)]);
                play(load, step, &pulse)?;
            }
        }
        if draw.chance(0.1) {
            let wave = oscillation(design, draw, sine)?;
            add(load, &wave, a * draw.log(0.05, 0.5));
        }
        if draw.chance(0.12) {
            for _ in 0..draw.count(1, 4) {
                let mut size = design.gain * a * draw.sign() * draw.uniform(0.5, 3.0);
                let from = draw.uniform(0.0, self.output.len() as f64) as usize;
                let keep = (-step / (design.pace * draw.log(1.0, 10.0))).exp();
                for v in &mut self.output[from..] {
                    *v += size;
                    size *= keep;
                }
            }
        }
        Ok(())
    }

    /// An oscillation from outside, of half to three times the activity, at the load or at the PV.
    fn oscillation(&mut self, design: &Design, draw: &mut Draw, shape: Shape) -> Result<()> {
        let wave = oscillation(design, draw, shape)?;
        let size = design.activity * draw.uniform(0.5, 3.0);
        if draw.chance(0.65) {
            add(&mut self.load, &wave, size);
        } else {
            add(&mut self.output, &wave, size * design.gain);
        }
        Ok(())
    }

    /// A load beyond what the OP can make good: a slow sine, or pulses.
    fn too_much(&mut self, design: &Design, draw: &mut Draw) -> Result<()> {
        let step = design.step();
        let duration = self.load.len() as f64 * step;
        let (below, above) = (design.op_rest - design.limits.0, design.limits.1 - design.op_rest);
        if draw.chance(0.5) {
            let amplitude = below.min(above) * draw.uniform(1.15, 2.0);
            let shortest = (12.0 * design.response_time()).min(duration / 3.0);
            let shortest = shortest.max(8.0 * design.pace);
            let wave = Signal::Periodic {
                wave: Wave::Sine,
                mean: 0.0,
                amplitude,
                period_s: draw.log(shortest, (duration / 2.0).max(2.0 * shortest)),
                phase: draw.unit(),
            };
            return play(&mut self.load, step, &wave);
        }
        let warm_up = design.warm_up as f64 * step;
        for _ in 0..draw.count(1, 3) {
            let size = match draw.chance(0.5) {
                true => below * draw.uniform(1.1, 1.6),
                false => -above * draw.uniform(1.1, 1.6),
            };
            let from = draw.uniform(0.7 * warm_up, 0.85 * duration);
            let until = from + (duration - warm_up) * draw.uniform(0.1, 0.3);
            let pulse = Signal::Steps(vec![(f64::MIN, 0.0), (from, size), (until, 0.0)]);
            play(&mut self.load, step, &pulse)?;
        }
        Ok(())
    }
}

/// Adds a signal to a tape.
fn play(tape: &mut [f64], step: f64, signal: &Signal) -> Result<()> {
    let mut source = signal.source(step, tape.len())?;
    tape.iter_mut().for_each(|v| *v += source.draw());
    Ok(())
}

/// Adds `size` times `wave` to a tape.
fn add(tape: &mut [f64], wave: &[f64], size: f64) {
    tape.iter_mut().zip(wave).for_each(|(v, w)| *v += size * w);
}

/// Adds a ramp to a tape: from 0 at step `from` to `size` after `length` steps.
fn ramp(tape: &mut [f64], from: f64, length: f64, size: f64) {
    for (k, v) in tape.iter_mut().enumerate() {
        *v += size * ((k as f64 - from) / length).clamp(0.0, 1.0);
    }
}

/// A shape of oscillation: `n` steps of `step` s with the given period, s, between about -1 and 1.
type Shape = fn(n: usize, step: f64, period: f64, draw: &mut Draw) -> Result<Vec<f64>>;

/// An oscillation of a period between 8 samples of an ordinary historian and a third of the record.
fn oscillation(design: &Design, draw: &mut Draw, shape: Shape) -> Result<Vec<f64>> {
    let duration = design.samples as f64 * design.sample_time;
    let period = draw.log(8.0 * design.pace, duration / 3.0);
    shape(design.all_steps(), design.step(), period, draw)
}

fn sine(n: usize, step: f64, period_s: f64, draw: &mut Draw) -> Result<Vec<f64>> {
    let wave = Signal::Periodic {
        wave: Wave::Sine,
        mean: 0.0,
        amplitude: 1.0,
        period_s,
        phase: draw.unit(),
    };
    wave.sample(step, n)
}

/// White noise through a resonance of damping lu(0.02, 0.25), scaled to the mean square of a sine.
fn narrow_band(n: usize, step: f64, period: f64, draw: &mut Draw) -> Result<Vec<f64>> {
    let w = std::f64::consts::TAU * step / period;
    let radius = (-w * draw.log(0.02, 0.25)).exp();
    let (first, second) = (2.0 * radius * w.cos(), -radius * radius);
    let mut stream = NormalStream::new(draw.seed());
    let (mut last, mut before) = (0.0, 0.0);
    // It starts in its stationary state, but for what is left after a few memories.
    let memory = ((3.0 / (1.0 - radius)) as usize).min(n);
    let mut wave = Vec::with_capacity(n);
    for k in 0..memory + n {
        let now = first * last + second * before + stream.draw();
        (before, last) = (last, now);
        if k >= memory {
            wave.push(now);
        }
    }
    let variance = (1.0 - second) / ((1.0 + second) * ((1.0 - second).powi(2) - first * first));
    let scale = (0.5 / variance).sqrt();
    wave.iter_mut().for_each(|v| *v *= scale);
    Ok(wave)
}

/// What another sticking valve sends: square, triangle, relaxation (an exponential approach that turns
/// at each end), or a slow ramp that slips back; every half period of its own length, and behind a lag of
/// lu(0.02, 0.5) periods.
fn slip_wave(n: usize, step: f64, period: f64, draw: &mut Draw) -> Result<Vec<f64>> {
    #[derive(Clone, Copy)]
    enum Form {
        Square,
        Triangle,
        Relaxation,
        Slip,
    }
    let form = draw.one_of([Form::Square, Form::Triangle, Form::Relaxation, Form::Slip]);
    let duty = draw.uniform(0.35, 0.65);
    let jitter = if draw.chance(0.5) { draw.uniform(0.02, 0.2) } else { 0.0 };
    // How far a relaxation gets, or which part of its swing is a slip.
    let bend = draw.uniform(1.0, 4.0);
    let slip = draw.uniform(0.2, 0.8);
    let keep = (-step / (period * draw.log(0.02, 0.5))).exp();
    let mut wave = Vec::with_capacity(n);
    let mut rising = draw.chance(0.5);
    let (mut gone, mut length, mut behind) = (draw.unit() * 0.5 * period, 0.5 * period, 0.0);
    for _ in 0..n {
        if gone >= length {
            gone = 0.0;
            rising = !rising;
            let share = if rising { duty } else { 1.0 - duty };
            length = period * share * (1.0 + jitter * draw.uniform(-1.0, 1.0));
        }
        let place = (gone / length).min(1.0);
        let up = match form {
            Form::Square => 1.0,
            Form::Triangle => 2.0 * place - 1.0,
            Form::Relaxation => 2.0 * (-bend * place).exp_m1() / (-bend).exp_m1() - 1.0,
            Form::Slip => -1.0 + 2.0 * (slip + (1.0 - slip) * place),
        };
        behind = keep * behind + (1.0 - keep) * if rising { up } else { -up };
        wave.push(behind);
        gone += step;
    }
    Ok(wave)
}

/// The noise of the transmitter.
fn noise(design: &Design, draw: &mut Draw) -> Result<Vec<f64>> {
    let n = design.all_steps();
    let sd = design.noise_ratio * design.activity * design.gain.abs();
    let tau_s = match design.noise {
        NoiseKind::Correlated => design.sample_time * draw.log(0.5, 10.0),
        _ => 0.0,
    };
    let mut noise = match design.noise {
        NoiseKind::HeavyTailed => {
            let freedom = draw.uniform(2.5, 5.0);
            // To the standard deviation of the others.
            let scale = sd * ((freedom - 2.0) / freedom).sqrt();
            draw.student(freedom, n).map(|t| scale * t).collect()
        }
        _ => Signal::Noise { sd, tau_s, seed: draw.seed() }.sample(design.step(), n)?,
    };
    match design.noise {
        NoiseKind::Bursts => {
            for _ in 0..draw.count(1, 8) {
                let factor = draw.uniform(3.0, 10.0);
                let from = draw.count(0, n - 1);
                let length = (n as f64 * draw.log(0.005, 0.06)) as usize;
                noise[from..(from + length).min(n)].iter_mut().for_each(|v| *v *= factor);
            }
        }
        NoiseKind::Spikes => {
            // By the sample, whatever the rate of the controller.
            let many = draw.log(0.0005, 0.01) * design.samples as f64;
            for _ in 0..(many.ceil() as usize) {
                let from = draw.count(0, n - 1);
                let size = sd * draw.sign() * draw.uniform(4.0, 15.0);
                let length = draw.count(1, design.steps);
                noise[from..(from + length).min(n)].iter_mut().for_each(|v| *v += size);
            }
        }
        _ => {}
    }
    if design.non_stationary {
        let (from, to) = (draw.log(0.3, 3.0), draw.log(0.3, 3.0));
        let sudden = draw.chance(0.5);
        let at = draw.uniform(0.2, 0.9);
        for (k, v) in noise.iter_mut().enumerate() {
            let place = k as f64 / n as f64;
            let place = if sudden { f64::from(u8::from(place > at)) } else { place };
            *v *= from + place * (to - from);
        }
    }
    Ok(noise)
}

/// The set point, but for what a controller above adds.
fn set_point(kind: Kind, design: &Design, draw: &mut Draw) -> Result<Vec<f64>> {
    let (n, step) = (design.all_steps(), design.step());
    let duration = n as f64 * step;
    let scale = (design.gain * design.activity).abs();
    // Where the set point is the cause, it moves more.
    let (most, size) = if kind == Kind::SetPoint { (16, 1.5) } else { (8, 1.0) };
    let change = |draw: &mut Draw| size * scale * draw.sign() * draw.log(0.3, 3.0);
    let mut tape = vec![design.pv_rest; n];
    match design.set_point {
        SetPointKind::Constant | SetPointKind::Cascade => {}
        SetPointKind::Steps => {
            for _ in 0..draw.count(1, most) {
                let (by, at) = (change(draw), draw.uniform(0.0, duration));
                play(&mut tape, step, &Signal::step(0.0, by, at))?;
            }
        }
        SetPointKind::Ramps => {
            for _ in 0..draw.count(1, most / 2) {
                let (by, from) = (change(draw), draw.uniform(-0.1, 0.95) * n as f64);
                ramp(&mut tape, from, draw.uniform(0.02, 0.4) * n as f64, by);
            }
        }
        SetPointKind::Wandering => {
            let tau_s = design.pace * draw.log(10.0, 200.0);
            let sd = change(draw).abs() * 0.5;
            play(&mut tape, step, &Signal::Noise { sd, tau_s, seed: draw.seed() })?;
        }
    }
    tape.iter_mut().for_each(|v| *v = v.clamp(3.0, 97.0));
    Ok(tape)
}
