//! External signals of a loop, step by step: load, noise, set point, and the cause that gives a kind its name.

use super::LoopKind;
use super::design::Design;
use super::draw::Draw;
use super::families::{DisturbanceKind, NoiseKind, ProcessKind, SetPointKind, Situation};
use super::switched::Switched;
use stiction_model::closed_loop::{NormalStream, Signal, Wave};
use stiction_model::error::Result;

/// The external signals of a loop, one value a step.
pub(super) struct Tapes {
    /// Adds to the valve position before the process, percent.
    pub load: Vec<f64>,
    /// Adds to the PV before the transmitter, percent of span.
    pub output: Vec<f64>,
    /// Adds to the PV in the transmitter, percent of span.
    pub noise: Vec<f64>,
    /// Set point, or the part of it that does not come from a controller above; percent of span.
    pub set_point: Vec<f64>,
    /// Adds to the OP, percent; empty for nothing.
    pub op: Vec<f64>,
    /// Output of a selector instead of the OP.
    pub selected: Option<Selected>,
    /// Times in which an operator has the OP.
    pub spells: Vec<Spell>,
    /// A neighbour that is switched.
    pub switched: Option<Switched>,
    /// The loads and other events, without the cause.
    pub kinds: Vec<DisturbanceKind>,
}

/// Another controller's OP at a selector.
pub(super) struct Selected {
    op: Vec<f64>,
    /// Whether the selector picks the lower or the higher of both.
    low: bool,
}

impl Selected {
    /// The other controller's OP.
    pub fn of(&self, k: usize, op: f64) -> f64 {
        if self.low { op.min(self.op[k]) } else { op.max(self.op[k]) }
    }
}

/// A time in which an operator has the OP.
#[derive(Clone)]
pub(super) struct Spell {
    pub from: usize,
    pub until: usize,
    /// Sample numbers of the OP movements, with their sizes, percent.
    moves: Vec<(usize, f64)>,
}

impl Spell {
    /// The OP at step `k`.
    pub fn op(&self, k: usize, last: f64) -> f64 {
        last + self.moves.iter().filter(|(at, _)| *at == k).map(|(_, by)| by).sum::<f64>()
    }
}

impl Tapes {
    /// All external signals of a loop of this kind.
    ///
    /// # Errors
    /// If the settings of a signal are invalid.
    pub fn draw(kind: LoopKind, design: &Design, draw: &mut Draw) -> Result<Self> {
        let mut cause = draw.fork();
        let mut tapes = Self::length(kind, design, draw)?;
        let mut later = cause.branch();
        while tapes.load.len() < design.all_steps() {
            tapes.go_on(Self::length(kind, design, &mut later)?);
        }
        let Self { load, output, noise, set_point, op, .. } = &mut tapes;
        for tape in [load, output, noise, set_point, op] {
            tape.truncate(design.all_steps());
        }
        match kind {
            LoopKind::Sine => tapes.oscillation(design, &mut cause, sine)?,
            LoopKind::Irregular => tapes.oscillation(design, &mut cause, narrow_band)?,
            LoopKind::ExternalWave => tapes.oscillation(design, &mut cause, slip_wave)?,
            LoopKind::RampAndReset => tapes.resets(design, &mut cause)?,
            LoopKind::SwitchedNeighbour => {
                tapes.switched = Some(Switched::draw(design, &mut cause))
            }
            LoopKind::LongMemory => {
                let wave = long_memory(design.all_steps(), design.drawn_steps, &mut cause);
                add(&mut tapes.load, &wave, design.activity * cause.log(0.7, 3.0));
            }
            LoopKind::OneWay => {
                let size = design.activity * cause.sign() * cause.uniform(3.0, 9.0);
                let size = size.clamp(-50.0, 50.0);
                let n = design.drawn_steps as f64;
                ramp(
                    &mut tapes.load,
                    cause.uniform(-0.3, 0.1) * n,
                    n * cause.uniform(0.9, 1.3),
                    size,
                );
            }
            LoopKind::ProcessNonlinearity => {
                let regular = cause.chance(0.5);
                let shape: Shape = if regular { sine } else { narrow_band };
                let size = design.activity * cause.uniform(1.0, 3.5);
                let wave = oscillation(design, &mut cause, design.all_steps(), shape)?;
                add(&mut tapes.load, &wave, size);
            }
            LoopKind::Saturation => tapes.too_much(design, &mut cause)?,
            _ => {}
        }
        Ok(tapes)
    }

    /// The events during the drawn record, without the cause.
    fn length(kind: LoopKind, design: &Design, draw: &mut Draw) -> Result<Self> {
        let n = design.drawn_steps;
        let mut tapes = Self {
            load: vec![0.0; n],
            output: vec![0.0; n],
            noise: noise(design, draw)?,
            set_point: set_point(kind, design, draw)?,
            op: vec![],
            selected: None,
            spells: vec![],
            switched: None,
            kinds: vec![],
        };
        let mut special = draw.fork();
        tapes.everyday(design, draw)?;
        tapes.situation(design, &mut special)?;
        Ok(tapes)
    }

    /// Appends the next events. Loads move from their last value to the new values within a tenth of the new length.
    fn go_on(&mut self, next: Self) {
        let over = next.load.len() as f64 / 10.0;
        for (tape, next) in [(&mut self.load, next.load), (&mut self.output, next.output)] {
            let apart = tape.last().copied().unwrap_or(0.0) - next[0];
            let come = |k: usize| apart * (1.0 - k as f64 / over).max(0.0);
            tape.extend(next.iter().enumerate().map(|(k, v)| v + come(k)));
        }
        let before = self.noise.len();
        let later = |spell: &Spell| Spell {
            from: spell.from + before,
            until: spell.until + before,
            moves: spell.moves.iter().map(|(at, by)| (at + before, *by)).collect(),
        };
        self.spells.extend(next.spells.iter().map(later));
        if let (Some(selected), Some(next)) = (&mut self.selected, next.selected) {
            selected.op.extend(next.op);
        }
        self.op.extend(next.op);
        self.noise.extend(next.noise);
        self.set_point.extend(next.set_point);
    }

    /// The events of every loop.
    fn everyday(&mut self, design: &Design, draw: &mut Draw) -> Result<()> {
        let (a, step) = (design.activity * design.happens, design.step());
        let duration = self.load.len() as f64 * step;
        let load = &mut self.load;
        // Otherwise a valve at rest at the set point would rest for ever.
        let offset = a * draw.sign() * draw.uniform(0.3, 1.5);
        load.iter_mut().for_each(|v| *v = offset);
        if draw.chance(0.6) {
            self.kinds.push(DisturbanceKind::Drift);
            let sd_per_sqrt_s = a * draw.log(0.05, 1.5) / duration.sqrt();
            play(load, step, &Signal::RandomWalk { sd_per_sqrt_s, seed: draw.seed() })?;
        }
        if draw.chance(0.3) {
            self.kinds.push(DisturbanceKind::Steps);
            for _ in 0..draw.count(1, 5) {
                let size = a * draw.sign() * draw.uniform(0.3, 2.0);
                let at = draw.uniform(0.0, duration);
                play(load, step, &Signal::step(0.0, size, at))?;
            }
        }
        if draw.chance(0.2) {
            self.kinds.push(DisturbanceKind::Ramp);
            let from = draw.uniform(-0.2, 0.8) * duration;
            let length = draw.uniform(0.1, 0.8) * duration;
            ramp(load, from / step, length / step, a * draw.sign() * draw.uniform(0.5, 3.0));
        }
        if draw.chance(0.12) {
            self.kinds.push(DisturbanceKind::Pulses);
            for _ in 0..draw.count(1, 4) {
                let size = a * draw.sign() * draw.uniform(0.5, 2.0);
                let from = draw.uniform(0.0, duration);
                let until = from + duration * draw.uniform(0.02, 0.15);
                let pulse = Signal::Steps(vec![(f64::MIN, 0.0), (from, size), (until, 0.0)]);
                play(load, step, &pulse)?;
            }
        }
        if draw.chance(0.1) {
            self.kinds.push(DisturbanceKind::Oscillation);
            let wave = oscillation(design, draw, load.len(), sine)?;
            add(load, &wave, a * draw.log(0.05, 0.5));
        }
        if draw.chance(0.12) {
            self.kinds.push(DisturbanceKind::Isolated);
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
        self.rarer(design, draw)
    }

    /// The events of some loops.
    fn rarer(&mut self, design: &Design, draw: &mut Draw) -> Result<()> {
        let (a, n) = (design.activity * design.happens, self.load.len());
        if draw.chance(0.1) {
            self.kinds.push(DisturbanceKind::LongMemory);
            let wave = long_memory(n, n, draw);
            add(&mut self.load, &wave, a * draw.log(0.1, 1.5));
        }
        if draw.chance(0.08) {
            self.kinds.push(DisturbanceKind::RampAndReset);
            let wave = ramps_and_resets(design, n, draw);
            add(&mut self.load, &wave, a * draw.log(0.1, 2.0));
        }
        if draw.chance(0.06) {
            self.kinds.push(DisturbanceKind::OneWay);
            let size = (a * draw.sign() * draw.uniform(1.0, 6.0)).clamp(-50.0, 50.0);
            ramp(&mut self.load, draw.uniform(-0.3, 0.1) * n as f64, n as f64, size);
        }
        if draw.chance(0.1) {
            self.kinds.push(DisturbanceKind::OnOff);
            let on = design.pace * draw.log(5.0, 200.0);
            let off = on * draw.log(0.3, 3.0);
            let vary = draw.uniform(0.0, 0.8);
            let (size, keep) = (a * draw.log(0.1, 1.5), 1.0 - 1.0 / draw.log(1.0, 20.0));
            let (mut is_on, mut left, mut value) = (draw.chance(0.5), 0.0, 0.0);
            for v in &mut self.load {
                if left <= 0.0 {
                    is_on = !is_on;
                    left = if is_on { on } else { off } * (1.0 + vary * draw.uniform(-1.0, 1.0));
                }
                left -= design.step();
                value = keep * value + (1.0 - keep) * f64::from(u8::from(is_on));
                *v += size * value;
            }
        }
        Ok(())
    }

    /// The events of the situation.
    fn situation(&mut self, design: &Design, draw: &mut Draw) -> Result<()> {
        let (a, n, step) = (design.activity, self.load.len(), design.step());
        if design.own_noise > 0.0 {
            let noise = Signal::Noise { sd: design.own_noise, tau_s: 0.0, seed: draw.seed() };
            self.op = noise.sample(step, n)?;
        }
        match design.situation {
            Situation::Feedforward => {
                let tau_s = design.pace * draw.log(5.0, 200.0);
                let sd = a * draw.log(0.2, 2.0);
                let measured = Signal::Noise { sd, tau_s, seed: draw.seed() }.sample(step, n)?;
                let late = (design.dead_time / step * draw.uniform(0.0, 2.0)) as usize;
                let right = draw.log(0.5, 2.0);
                for (k, load) in self.load.iter_mut().enumerate() {
                    *load -= right * measured[k.saturating_sub(late)];
                }
                match self.op.is_empty() {
                    true => self.op = measured,
                    false => add(&mut self.op, &measured, 1.0),
                }
            }
            Situation::Override => {
                let low = draw.chance(0.5);
                let away = a * draw.uniform(0.3, 2.0) * if low { 1.0 } else { -1.0 };
                let tau_s = n as f64 * step * draw.log(0.01, 0.1);
                let sd = a * draw.log(0.3, 2.0);
                let mut op = Signal::Noise { sd, tau_s, seed: draw.seed() }.sample(step, n)?;
                let offset = design.op_rest - self.load[0] + away;
                op.iter_mut().for_each(|v| *v += offset);
                self.selected = Some(Selected { op, low });
            }
            Situation::ManualSpells => self.by_hand(design, draw),
            _ => {}
        }
        Ok(())
    }

    /// Times in which the OP rests, or is moved manually once or twice.
    fn by_hand(&mut self, design: &Design, draw: &mut Draw) {
        let n = self.load.len();
        let long = if design.process == ProcessKind::Integrating { 0.06 } else { 0.2 };
        let mut from = (draw.uniform(0.05, 0.4) * n as f64) as usize;
        for _ in 0..draw.count(1, 3) {
            let until = from + (draw.log(0.02, long) * n as f64) as usize;
            let moves = (0..draw.count(0, 3))
                .map(|_| {
                    let by = design.activity * draw.sign() * draw.log(0.2, 1.5);
                    (draw.count(from, until.max(from + 1) - 1), by)
                })
                .collect();
            self.spells.push(Spell { from, until: until.min(n), moves });
            from = until + 1 + (draw.uniform(0.05, 0.4) * n as f64) as usize;
        }
        self.spells.retain(|spell| spell.from < n);
    }

    /// A disturbance that ramps and resets. It acts at the load or, rarely, at the PV.
    fn resets(&mut self, design: &Design, draw: &mut Draw) -> Result<()> {
        let size = design.activity * draw.uniform(0.8, 5.0);
        let at_load = draw.chance(0.85);
        let wave = ramps_and_resets(design, self.load.len(), draw);
        self.enters(&wave, size, at_load, design.gain);
        Ok(())
    }

    /// An oscillation from outside, half to three times the activity, at the load or at the PV.
    fn oscillation(&mut self, design: &Design, draw: &mut Draw, shape: Shape) -> Result<()> {
        let size = design.activity * draw.uniform(0.5, 3.0);
        let at_load = draw.chance(0.65);
        let wave = oscillation(design, draw, self.load.len(), shape)?;
        self.enters(&wave, size, at_load, design.gain);
        Ok(())
    }

    /// Adds a wave at the load, or at the PV.
    fn enters(&mut self, wave: &[f64], size: f64, at_load: bool, gain: f64) {
        match at_load {
            true => add(&mut self.load, wave, size),
            false => add(&mut self.output, wave, size * gain),
        }
    }

    /// A load beyond the range of the OP: a slow sine, or pulses.
    fn too_much(&mut self, design: &Design, draw: &mut Draw) -> Result<()> {
        let step = design.step();
        let duration = design.drawn_steps as f64 * step;
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
        let drawn = duration - warm_up;
        // Equally often in every further length of the record.
        for length in
            0..(self.load.len() - design.warm_up).div_ceil(design.drawn_steps - design.warm_up)
        {
            let later = length as f64 * drawn;
            for _ in 0..draw.count(1, 3) {
                let size = match draw.chance(0.5) {
                    true => below * draw.uniform(1.1, 1.6),
                    false => -above * draw.uniform(1.1, 1.6),
                };
                let first = if length == 0 { 0.7 * warm_up } else { warm_up };
                let from = later + draw.uniform(first, 0.85 * duration);
                let until = from + drawn * draw.uniform(0.1, 0.3);
                let pulse = Signal::Steps(vec![(f64::MIN, 0.0), (from, size), (until, 0.0)]);
                play(&mut self.load, step, &pulse)?;
            }
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

/// `n` steps of an oscillation of a period between 8 samples of an ordinary historian and a third of the record.
fn oscillation(design: &Design, draw: &mut Draw, n: usize, shape: Shape) -> Result<Vec<f64>> {
    let duration = (design.drawn_steps - design.warm_up) as f64 * design.step();
    let period = draw.log(8.0 * design.pace, duration / 3.0);
    shape(n, design.step(), period, draw)
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
    // It starts in its stationary state, except for the rest after a few memories.
    let memory = ((3.0 / (1.0 - radius)) as usize).min(100_000);
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

/// The wave of another sticking valve: square, triangle, relaxation (an exponential approach that turns at each
/// end), or a slow ramp that slips back. Every half period has its own length, behind a lag of lu(0.02, 0.5)
/// periods.
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
    // Extent of a relaxation, or the part of its swing that is a slip.
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

/// `n` steps from 0 to 1 over a period and back, repeatedly. They are straight or bent, upwards or downwards, of one
/// length or of many, with a reset of up to a twentieth of the period.
fn ramps_and_resets(design: &Design, n: usize, draw: &mut Draw) -> Vec<f64> {
    let duration = (design.drawn_steps - design.warm_up) as f64 * design.step();
    let longest = (duration / 4.0).max(40.0 * design.pace);
    let period = draw.log(30.0 * design.pace, longest);
    let down = draw.chance(0.5);
    let bend = if draw.chance(0.5) { 1.0 } else { draw.log(0.5, 2.0) };
    let vary = if draw.chance(0.5) { draw.uniform(0.02, 0.4) } else { 0.0 };
    let reset = draw.uniform(0.0, 0.05);
    let (mut gone, mut length) = (draw.unit() * period, period);
    let mut wave = Vec::with_capacity(n);
    for _ in 0..n {
        if gone >= length {
            gone = 0.0;
            length = period * (1.0 + vary * draw.uniform(-1.0, 1.0));
        }
        let place = gone / length;
        let up = match place > 1.0 - reset {
            true => (1.0 - place) / reset,
            false => (place / (1.0 - reset)).powf(bend),
        };
        wave.push(if down { 1.0 - up } else { up });
        gone += design.step();
    }
    wave
}

/// `n` steps of noise whose power falls with the frequency to the power of u(0.6, 1.7), down to periods of `longest`
/// steps. It is a sum of octaves of noise, with straight lines between their knots. The standard deviation is about
/// one.
fn long_memory(n: usize, longest: usize, draw: &mut Draw) -> Vec<f64> {
    let exponent = draw.uniform(0.6, 1.7);
    let seed = draw.seed();
    let mut wave = vec![0.0; n];
    let (mut every, mut power) = (longest.max(2), 0.0);
    while every >= 2 && power < 20.0 {
        // Each octave has the power of its frequencies.
        let part = (every as f64 / longest as f64).powf((exponent - 1.0) / 2.0);
        power += part * part * 2.0 / 3.0;
        let mut stream = NormalStream::new(seed ^ every as u64);
        let (mut from, mut to) = (stream.draw(), stream.draw());
        for (k, v) in wave.iter_mut().enumerate() {
            let place = (k % every) as f64 / every as f64;
            if k > 0 && k % every == 0 {
                (from, to) = (to, stream.draw());
            }
            *v += part * (from + place * (to - from));
        }
        every /= 2;
    }
    let scale = 1.0 / power.sqrt();
    wave.iter_mut().for_each(|v| *v *= scale);
    wave
}

/// The noise of the transmitter.
fn noise(design: &Design, draw: &mut Draw) -> Result<Vec<f64>> {
    let n = design.drawn_steps;
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
            // Once a sample, at any rate of the controller.
            let samples = (design.drawn_steps - design.warm_up) / design.steps;
            let many = draw.log(0.0005, 0.01) * samples as f64;
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

/// The set point, without the part from a controller above.
fn set_point(kind: LoopKind, design: &Design, draw: &mut Draw) -> Result<Vec<f64>> {
    let (n, step) = (design.drawn_steps, design.step());
    let duration = n as f64 * step;
    let scale = (design.gain * design.activity).abs();
    // If the set point is the cause, it moves more.
    let (most, size) = if kind == LoopKind::SetPoint { (16, 1.5) } else { (8, design.happens) };
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
