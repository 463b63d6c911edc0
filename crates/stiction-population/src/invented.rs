//! Loops of kinds that the verdict was not trained on: the examination that follows a training.
//!
//! They were devised when the population that trains the verdict was final, share none of its code but random
//! numbers and valve models, and are never trained on. A kind that is to enter the population leaves this file.
//! Each kind has healthy loops and loops that stick, with the same process, controller and disturbances.

use super::draw::Draw;
use super::visibility;
use std::f64::consts::TAU;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::series::{max, min, std};
use stiction_model::bands::Bands;
use stiction_model::closed_loop::NormalStream;
use stiction_model::error::Result;
use stiction_model::valve::{AnyModel, Model, Start, Valve};

/// What nobody had thought of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Invention {
    /// A positioner that rings: the stem follows with a resonance of damping 0.15 to 0.4.
    RingingPositioner,
    /// A predictive controller: a move every few samples, held between, chosen by a model that is off.
    PredictiveController,
    /// A second valve in the same line, moved by hand and by another loop; the gain changes with it.
    ValvesInSeries,
    /// A boiler or compressor that is switched on and off by the pressure that the loop controls.
    OnOffNeighbour,
    /// A valve that sticks near its seat only, under a loop that visits the seat.
    NearTheSeat,
    /// Pulsating flow, sampled a little slower or faster than it pulsates: a slow beat in the PV.
    Aliasing,
    /// A titration: the gain changes tenfold about the set point.
    Titration,
    /// A linkage with play and a soft spring behind the valve: the flow follows the stem late and softly.
    SoftLinkage,
}

impl Invention {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::RingingPositioner,
        Self::PredictiveController,
        Self::ValvesInSeries,
        Self::OnOffNeighbour,
        Self::NearTheSeat,
        Self::Aliasing,
        Self::Titration,
        Self::SoftLinkage,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::RingingPositioner => "ringing positioner",
            Self::PredictiveController => "predictive controller",
            Self::ValvesInSeries => "valves in series",
            Self::OnOffNeighbour => "on-off neighbour",
            Self::NearTheSeat => "near the seat",
            Self::Aliasing => "aliased pulsation",
            Self::Titration => "titration",
            Self::SoftLinkage => "soft linkage",
        }
    }

    /// The loop of this kind and seed, healthy or sticking.
    ///
    /// # Errors
    /// None is known.
    pub fn simulate(self, seed: u64, sticks: bool) -> Result<Invented> {
        // A draw whose OP rests or lies at an end shows nothing.
        let mut again = 0;
        loop {
            let mut draw = Draw::of(&[0x1a5e, self as u64, seed, again]);
            let found = Sketch::draw(self, &mut draw).play(sticks)?;
            again += 1;
            if again >= 60 || found.serves {
                return Ok(found);
            }
        }
    }
}

/// A loop of such a kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Invented {
    /// What a plant would have recorded.
    pub recording: Recording,
    /// Whether the valve sticks.
    pub sticks: bool,
    /// Whether the record can show it, as in [`Truth::visible`](super::Truth::visible).
    pub visible: bool,
    /// Stick band plus dead band, percent of span; 0 of a healthy valve.
    pub s: f64,
    /// Slip jump.
    pub j: f64,
    serves: bool,
}

/// A loop as it is drawn. One step is the controller's, unless it moves more seldom.
struct Sketch {
    what: Invention,
    samples: usize,
    /// Steps a recorded sample.
    steps: usize,
    sample_time: f64,
    s: f64,
    j: f64,
    model: Model,
    /// Process: two lags and a dead time, steps; percent per percent.
    gain: f64,
    lags: [f64; 2],
    dead: usize,
    /// The closed loop's time constant over the dead time and small lag.
    slowness: f64,
    proportional_only: bool,
    /// Every so many steps the predictive controller moves, and how wrong its model is.
    every: usize,
    wrong: f64,
    rest: f64,
    noise: f64,
    load: f64,
    load_keep: f64,
    steps_of_load: usize,
    /// What belongs to the kind: sizes, periods, shares.
    size: f64,
    period: f64,
    share: f64,
    unit: (f64, f64),
    seed: u64,
}

impl Sketch {
    fn draw(what: Invention, draw: &mut Draw) -> Self {
        let s = draw.log(0.5, 9.0);
        let steps = draw.one_of([1, 1, 1, 2, 4]);
        let slow = draw.log(2.0, 40.0);
        let period = match what {
            Invention::RingingPositioner => draw.log(5.0, 25.0),
            // Beats of 20 to 300 samples.
            Invention::Aliasing => 1.0 + draw.sign() / draw.log(20.0, 300.0),
            _ => draw.log(40.0, 400.0),
        };
        Self {
            what,
            samples: draw.log(500.0, 4000.0) as usize,
            steps,
            sample_time: draw.one_of([0.5, 1.0, 2.0, 5.0, 10.0, 30.0]),
            s,
            j: s * draw.uniform(0.05, 1.0),
            model: draw.weighted([(Model::TwoPhase, 0.6), (Model::He, 0.4)]),
            gain: draw.log(0.4, 2.5) * draw.sign(),
            lags: [slow, slow * draw.uniform(0.05, 0.6)],
            dead: draw.count(1, 1 + (0.7 * slow) as usize),
            slowness: draw.log(0.8, 5.0),
            proportional_only: draw.chance(0.1),
            every: draw.count(2, 10) * steps,
            wrong: draw.log(0.5, 2.0),
            rest: match what {
                Invention::NearTheSeat => draw.uniform(6.0, 14.0),
                _ => draw.uniform(30.0, 70.0),
            },
            noise: s * draw.log(0.01, 0.4),
            load: s * draw.log(0.1, 1.5),
            load_keep: 1.0 - 1.0 / (slow * draw.log(1.0, 30.0)),
            steps_of_load: draw.count(0, 4),
            size: s * draw.log(0.4, 3.0),
            period,
            share: draw.uniform(0.15, 0.4),
            unit: (draw.uniform(-50.0, 300.0), draw.log(0.05, 30.0)),
            seed: draw.seed(),
        }
    }

    fn play(&self, sticks: bool) -> Result<Invented> {
        let warm_up = 400 + 20 * self.lags[0] as usize;
        let n = warm_up + self.samples * self.steps;
        let mut draws = NormalStream::new(self.seed);
        let mut events = Draw::of(&[self.seed]);
        let jumps: Vec<(usize, f64)> = (0..self.steps_of_load)
            .map(|_| (events.count(warm_up, n - 1), events.sign() * events.uniform(0.3, 1.5)))
            .collect();
        let bands = Bands::from_s_j(self.s, self.j)?;
        let mut valve: AnyModel = self.model.build(bands)?;
        valve.restart(Start::at_rest(self.rest));
        let mut controller = Moves::of(self);
        let mut states = States::new(self);
        let [mut op, mut pv, mut stem] = [vec![], vec![], vec![]].map(|v: Vec<f64>| v);
        let (mut wander, mut y) = (0.0, 0.0);
        for k in 0..n {
            let measured = y + self.gain.abs() * self.noise * draws.draw() + self.beat(k);
            let u = controller.step(self, k, measured);
            let near = self.what != Invention::NearTheSeat || u.min(states.stem) < 15.0;
            let held = valve.step(u);
            let x = match sticks && near {
                true => held,
                false => {
                    valve.restart(Start { op: u, ..Start::at_rest(u) });
                    u
                }
            };
            states.stem = x;
            wander = self.load_keep * wander
                + (1.0 - self.load_keep.powi(2)).sqrt() * self.load * draws.draw();
            let jump: f64 =
                jumps.iter().filter(|(at, _)| *at <= k).map(|(_, by)| by * self.load).sum();
            y = states.step(self, k, x - self.rest, wander + jump, y);
            if k >= warm_up {
                op.push(u);
                pv.push(measured);
                stem.push(x);
            }
        }
        let last = |x: &[f64]| -> Vec<f64> {
            x.chunks_exact(self.steps).map(|sample| sample[self.steps - 1]).collect()
        };
        let (recorded_op, recorded) = (last(&op), last(&pv));
        let slips = stem.windows(3).filter(|x| x[0] == x[1] && x[1] != x[2]).count();
        let gain = visibility::Observed {
            recorded: &recorded,
            pv: &pv,
            op: &op,
            stem: &stem,
            steps: self.steps,
            dead_time: self.dead as f64,
        }
        .gain();
        let at_end = op.iter().filter(|u| **u <= 0.0 || **u >= 100.0).count();
        let serves = op.iter().chain(&pv).all(|v| v.is_finite())
            && max(&op) - min(&op) > 0.3 * self.s
            && at_end < op.len() / 20
            && std(&pv) > 0.0;
        let (offset, unit) = self.unit;
        let in_units: Vec<f64> = recorded.iter().map(|v| offset + unit * v).collect();
        let sp = vec![offset; recorded.len()];
        let recording =
            Recording::regular("", self.sample_time, &recorded_op, Some(&in_units), Some(&sp))?;
        let known = |v: f64| if sticks { v } else { 0.0 };
        let visible = sticks && slips > 0 && gain >= visibility::NATS;
        Ok(Invented { recording, sticks, visible, s: known(self.s), j: known(self.j), serves })
    }

    /// What pulsates at the transmitter.
    fn beat(&self, k: usize) -> f64 {
        match self.what {
            Invention::Aliasing => {
                let place = k as f64 / (self.steps as f64 * self.period);
                self.gain.abs() * self.size * 0.6 * (TAU * place).sin()
            }
            _ => 0.0,
        }
    }
}

/// The controller: PI by internal model control, or one that predicts.
struct Moves {
    kc: f64,
    ti: f64,
    integral: f64,
    before: f64,
    held: f64,
    predicted: f64,
}

impl Moves {
    fn of(sketch: &Sketch) -> Self {
        let [slow, fast] = sketch.lags;
        let waiting = sketch.dead as f64 + fast + 1.0;
        let wanted = sketch.slowness * waiting;
        // Where the gain grows, the tuning must know it.
        let steepest = match sketch.what {
            Invention::Titration => 3.0,
            Invention::RingingPositioner => 2.0,
            _ => 1.0,
        };
        let kc = slow / (sketch.gain * steepest * (wanted + waiting));
        let ti = slow.min(4.0 * (wanted + waiting));
        Self { kc, ti, integral: 0.0, before: 0.0, held: sketch.rest, predicted: 0.0 }
    }

    fn step(&mut self, sketch: &Sketch, k: usize, measured: f64) -> f64 {
        let error = -measured;
        if sketch.what == Invention::PredictiveController {
            // A model of gain and lag that is off tells where the PV would go; the move takes it back by a share.
            let lag = sketch.lags[0] * sketch.wrong;
            let gain = sketch.gain * sketch.wrong.sqrt();
            self.predicted += (gain * (self.held - sketch.rest) - self.predicted) / lag;
            if k.is_multiple_of(sketch.every) {
                let bias = measured - self.predicted;
                let wanted = sketch.rest - bias / gain;
                let most = 0.5 * sketch.s + 0.5;
                let share = 1.0 / (1.0 + sketch.slowness);
                self.held += (share * (wanted - self.held)).clamp(-most, most);
            }
            self.held = self.held.clamp(0.0, 100.0);
            return self.held;
        }
        if !sketch.proportional_only {
            self.integral = (self.integral + self.kc * error / self.ti).clamp(-60.0, 60.0);
        }
        self.before = error;
        (sketch.rest + self.kc * error + self.integral).clamp(0.0, 100.0)
    }
}

/// What lies between the stem and the PV.
struct States {
    stem: f64,
    line: Vec<f64>,
    lags: [f64; 2],
    ring: [f64; 2],
    second: f64,
    running: bool,
    soft: f64,
}

impl States {
    fn new(sketch: &Sketch) -> Self {
        Self {
            stem: sketch.rest,
            line: vec![0.0; sketch.dead],
            lags: [0.0; 2],
            ring: [0.0; 2],
            second: 0.0,
            running: false,
            soft: 0.0,
        }
    }

    /// The PV after one step, percent about its rest.
    fn step(&mut self, sketch: &Sketch, k: usize, stem: f64, load: f64, pv: f64) -> f64 {
        let place = TAU * k as f64 / sketch.period;
        let mut flow = stem;
        match sketch.what {
            Invention::RingingPositioner => {
                // Semi-implicit Euler keeps the resonance where it belongs.
                let w = TAU / sketch.period;
                let [x, v] = &mut self.ring;
                *v += w * w * (stem - *x) - 2.0 * sketch.share * w * *v;
                *x += *v;
                flow = *x;
            }
            Invention::ValvesInSeries => {
                // The other valve wanders by hand, in steps, and swings with its own loop.
                if k.is_multiple_of((7.3 * sketch.period) as usize + 1) {
                    self.second = sketch.share * (3.7 * place).sin();
                }
                let other = 1.0 + self.second + 0.2 * sketch.share * place.sin();
                flow = (stem + sketch.rest) * other - sketch.rest;
            }
            Invention::SoftLinkage => {
                let slack = (stem - self.soft).abs() - 0.08 * sketch.size;
                if slack > 0.0 {
                    self.soft += 0.5 * slack * (stem - self.soft).signum();
                }
                flow = self.soft;
            }
            _ => {}
        }
        let mut load = load;
        if sketch.what == Invention::OnOffNeighbour {
            let band = 0.4 * sketch.gain.abs() * sketch.size;
            // It comes on where the PV is low and goes off where it is high, if it raises it.
            if pv < -band {
                self.running = true;
            } else if pv > band {
                self.running = false;
            }
            let on = if self.running { 1.0 } else { -1.0 };
            load += on * sketch.gain.signum() * sketch.size;
        }
        self.line.push(sketch.gain * (flow + load));
        let mut through = self.line.remove(0);
        for (state, lag) in self.lags.iter_mut().zip(sketch.lags) {
            *state += (through - *state) * (1.0 - (-1.0 / lag).exp());
            through = *state;
        }
        match sketch.what {
            // Steep about the set point, flat away from it.
            Invention::Titration => {
                let width = 0.6 * sketch.gain.abs() * sketch.size;
                width * (3.0 * (through / width).tanh() + 0.3 * through / width)
            }
            _ => through,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_gives_loops_that_serve_and_depend_on_their_numbers_alone() {
        let mut seen = 0;
        for what in Invention::ALL {
            for seed in 0..20 {
                for sticks in [false, true] {
                    let made = what.simulate(seed, sticks).unwrap();
                    assert_eq!(made, what.simulate(seed, sticks).unwrap());
                    assert!(made.serves, "{} {seed} {sticks}", what.name());
                    assert!(made.sticks == sticks && (sticks || !made.visible && made.s == 0.0));
                    seen += usize::from(made.visible);
                }
            }
        }
        assert!(seen >= 20, "{seen} of 160 sticking loops are visible");
    }
}
