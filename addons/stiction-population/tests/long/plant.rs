//! Loops of a plant that are recorded for weeks: loads that drift, day and night, calm spells, grades.

use stiction_diagnose::recording::Recording;
use stiction_model::Bands;
use stiction_model::closed_loop::{AntiWindup, ClosedLoop, Controller, Process, Signal};
use stiction_model::valve::{Assembly, Model};

const HOUR: f64 = 3600.0;

/// Pseudo-random numbers: SplitMix64.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }
}

/// A flow, a level or a temperature of a plant, sampled every `sample_time` s, that sticks or does not.
pub fn plant(seed: u64, sticks: bool, sample_time: f64, samples: usize) -> Recording {
    let draw = &mut Draw(seed.wrapping_mul(0x2545_F491_4F6C_DD1D) ^ 7);
    let dt = sample_time;
    let gain = draw.log(0.5, 2.0);
    let (process, controller, ti);
    match (3.0 * draw.unit()) as usize {
        0 => {
            let tau = dt * draw.log(0.5, 6.0);
            let dead = dt * draw.uniform(0.2, 2.0);
            let slow = draw.log(1.0, 4.0) * (dead + dt);
            ti = tau.max(dt);
            controller = Controller::pi(ti / (gain * (slow + dead + dt)), ti).unwrap();
            process = Process::first_order(gain, tau, dead).unwrap();
        }
        1 => {
            let fill = dt * draw.log(30.0, 300.0);
            let slow = fill * draw.log(0.1, 0.5);
            ti = 4.0 * slow;
            controller = Controller::pi(fill / (gain * slow), ti).unwrap();
            process = Process::integrator(gain / fill, dt * draw.uniform(0.5, 2.0)).unwrap();
        }
        _ => {
            let tau = dt * draw.log(10.0, 60.0);
            let dead = tau * draw.uniform(0.1, 0.4);
            let slow = draw.log(0.6, 2.0) * tau;
            ti = tau;
            controller = Controller::pi(tau / (gain * (slow + dead)), ti).unwrap();
            process =
                Process::second_order(gain, tau, tau * draw.uniform(0.05, 0.3), dead).unwrap();
        }
    }
    let s = draw.log(1.5, 9.0);
    let j = s * draw.uniform(0.05, 0.9);
    let model = if draw.chance(0.3) { Model::He } else { Model::TwoPhase };
    let healthy = Model::Play.build(Bands::from_s_j(draw.uniform(0.0, 0.2), 0.0).unwrap()).unwrap();
    let sticky = model.build(Bands::from_s_j(s, j).unwrap()).unwrap();
    let valve = Assembly::new(if sticks { sticky } else { healthy });
    let valve = valve.with_limits(0.0, 100.0).unwrap();
    let warm_up = ((40.0 * ti / dt) as usize).clamp(200, 20_000);
    let n = samples + warm_up;
    let load = load(draw, s, dt, n);
    let quiet = draw.chance(0.3);
    let noise = gain * s * if quiet { 0.002 } else { draw.log(0.01, 0.25) };
    let quantum = if quiet { gain * s * draw.uniform(0.05, 0.3) } else { 0.0 };
    let mut system = ClosedLoop::new(
        controller.with_limits(0.0, 100.0, AntiWindup::Clamping).unwrap(),
        valve,
        process,
    );
    system.sample_time = dt;
    system.samples = n;
    (system.op_rest, system.pv_rest) = (draw.uniform(35.0, 65.0), 50.0);
    system.set_point = set_point(draw, gain * s, dt, n);
    system.load = vec![Signal::Samples(load)];
    let tau_s = if draw.chance(0.5) { 0.0 } else { dt * draw.log(0.5, 5.0) };
    system.measurement = vec![Signal::Noise { sd: noise, tau_s, seed: draw.next() }];
    system.pv_quantum = quantum;
    system.op_quantum = 0.01;
    let run = system.run().unwrap();
    let tail = |x: &[f64]| x[warm_up..].to_vec();
    let (op, pv, sp) = (tail(&run.op), tail(&run.pv), tail(&run.sp));
    let sp = draw.chance(0.6).then_some(sp);
    Recording::regular("", dt, &op, Some(&pv), sp.as_deref()).unwrap()
}

/// A load that wanders about its mean, with day and night, steps, and calm spells in which it stands.
fn load(draw: &mut Draw, s: f64, dt: f64, n: usize) -> Vec<f64> {
    let tau = draw.log(0.3, 6.0) * HOUR;
    let sd = s * draw.log(0.2, 1.5);
    let drift = Signal::Noise { sd, tau_s: tau, seed: draw.next() }.sample(dt, n).unwrap();
    let day = s * if draw.chance(0.6) { draw.log(0.3, 3.0) } else { 0.0 };
    let phase = draw.unit();
    let calm_share = if draw.chance(0.5) { draw.uniform(0.1, 0.7) } else { 0.0 };
    let steps_an_hour = if draw.chance(0.5) { draw.log(0.05, 1.0) } else { 0.0 };
    let mut load = Vec::with_capacity(n);
    let (mut level, mut until, mut held) = (0.0, 0.0, None);
    for (k, drift) in drift.iter().enumerate() {
        let t = k as f64 * dt;
        if t >= until {
            until = t + draw.log(0.5, 8.0) * HOUR;
            held = draw.chance(calm_share).then(|| load.last().copied().unwrap_or(0.0));
        }
        if draw.chance(steps_an_hour * dt / HOUR) {
            level = s * draw.sign() * draw.uniform(0.3, 1.5);
        }
        let night = day * (std::f64::consts::TAU * (t / (24.0 * HOUR) + phase)).sin();
        load.push(held.unwrap_or(drift + night + level));
    }
    load
}

/// A set point that changes with the grade, some times a day, or not at all.
fn set_point(draw: &mut Draw, scale: f64, dt: f64, n: usize) -> Signal {
    let mut steps = vec![(f64::MIN, 50.0)];
    let every = if draw.chance(0.5) { draw.log(2.0, 24.0) * HOUR } else { f64::INFINITY };
    let mut t = every * draw.unit();
    while t < n as f64 * dt {
        steps.push((t, 50.0 + scale * draw.uniform(-2.0, 2.0)));
        t += every * draw.uniform(0.3, 1.7);
    }
    Signal::Steps(steps)
}
