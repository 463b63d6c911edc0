//! A whole loop, PI or PID controller, sticking valve and process, as a source of test signals.

use stiction_model::closed_loop::{
    AntiWindup, ClosedLoop, Controller, Player, Process, Signal, SignalSource,
};
use stiction_model::valve::{Model as Law, Valve};

use crate::model::{FmuModel, Moves, Result};
use crate::valve;
use crate::variables::{MOVES, Numbers, Variable};

/// Value references.
const SP: usize = 1;
const LOAD: usize = 2;
const PV: usize = 3;
const OP: usize = 4;
const VP: usize = 5;
const MOVED: std::ops::Range<usize> = 6..8;
const VALVE: usize = 8;
const REST: usize = VALVE + valve::SETTINGS;
/// Number of references after those of the valve.
const OTHERS: usize = 19;

/// Most samples in one step.
const MOST: f64 = 1e7;

/// The table of a loop.
pub(crate) fn variables() -> Vec<Variable> {
    let p = Variable::parameter;
    let mut table = vec![
        Variable::TIME,
        Variable::input("SP", "%", 5.0, "Set point"),
        Variable::input("load", "%", 0.0, "Load disturbance, added to the valve position"),
        Variable::output("PV", "%", "Measured process value, percent of its span")
            .sampled()
            .depends_on(&[]),
        Variable::output("OP", "%", "Controller output").sampled().depends_on(&[]),
        Variable::output("VP", "%", "Valve position").sampled().depends_on(&[]),
    ];
    table.extend(MOVES);
    table.extend(valve::settings());
    table.extend([
        p("sample_time", "s", 0.1, "Time between samples of the loop"),
        p("Kc", "1", 1.1, "Controller gain, % of the OP per % of the PV"),
        p("Ti", "s", 2.5, "Integral time"),
        p("Td", "s", 0.0, "Derivative time; 0 for a PI controller"),
        p("OP_limited", "", 0.0, "Whether the controller limits its output and its integral")
            .boolean(),
        p("OP_low", "%", 0.0, "Lower limit of the controller output, if it is limited"),
        p("OP_high", "%", 100.0, "Upper limit of the controller output, if it is limited"),
        p("gain", "1", 1.5, "Process gain, % of the PV per % of the VP"),
        p("tau", "s", 5.93, "Process time constant"),
        p("tau2", "s", 0.0, "Second process time constant; 0 for a process of the first order"),
        p("dead_time", "s", 1.07, "Dead time of the process"),
        p("OP_rest", "%", 0.0, "OP and VP at the operating point, where the loop starts at rest"),
        p("PV_rest", "%", 0.0, "PV at the operating point"),
        p("noise_sd", "%", 0.0, "Standard deviation of the measurement noise"),
        p("noise_tau", "s", 0.0, "Correlation time of the measurement noise; 0 for white noise"),
        p("seed", "", 1.0, "Seed of the measurement noise, from 0").integer(),
        p("OP_quantum", "%", 0.0, "Resolution of the controller output; 0 for none"),
        p("PV_quantum", "%", 0.0, "Resolution of the measured PV; 0 for none"),
    ]);
    table.push(p("bumpless", "", 0.0, "Whether the loop is closed without a bump").boolean());
    table
}

/// A loop and its external signals, built from its parameters.
#[derive(Debug, Clone)]
struct Built {
    player: Player,
    noise: Option<SignalSource>,
}

fn build(law: Law, values: &[f64]) -> stiction_model::Result<Built> {
    let [
        sample_time,
        kc,
        ti,
        td,
        limited,
        low,
        high,
        gain,
        tau,
        tau2,
        dead_time,
        op_rest,
        pv_rest,
        sd,
        noise_tau,
        seed,
        op_quantum,
        pv_quantum,
        bumpless,
    ] = *values[REST..].first_chunk::<OTHERS>().expect("the table has them");
    let valve = valve::build(law, &values[VALVE..REST], sample_time)?;
    let mut controller = Controller::pid(kc, ti, td)?;
    if limited != 0.0 {
        controller = controller.with_limits(low, high, AntiWindup::Clamping)?;
    }
    if bumpless != 0.0 {
        controller = controller.with_handover(stiction_model::closed_loop::Handover::Bumpless);
    }
    let process = if tau2 == 0.0 {
        Process::first_order(gain, tau, dead_time)?
    } else {
        Process::second_order(gain, tau, tau2, dead_time)?
    };
    let player = ClosedLoop {
        sample_time,
        samples: 0,
        op_rest,
        pv_rest,
        op_quantum,
        pv_quantum,
        set_point: Signal::Constant(values[SP]),
        ..ClosedLoop::new(controller, valve, process)
    }
    .player()?;
    if !(seed >= 0.0) {
        return Err(stiction_model::Error::Parameter {
            name: "seed",
            value: seed,
            allowed: "at least 0".to_owned(),
        });
    }
    let noise = Signal::Noise { sd, tau_s: noise_tau, seed: seed as u64 }.source(sample_time, 0)?;
    Ok(Built { player, noise: (sd > 0.0).then_some(noise) })
}

#[derive(Debug, Clone)]
pub(crate) struct LoopModel {
    law: Law,
    built: Option<Built>,
    /// Time of the first sample, s.
    start_s: f64,
    /// Number of samples.
    played: u64,
    moves: Moves,
}

impl LoopModel {
    pub(crate) fn new(law: Law) -> Self {
        Self { law, built: None, start_s: 0.0, played: 0, moves: Moves::default() }
    }
}

impl FmuModel for LoopModel {
    fn restart(&mut self, values: &mut Numbers, time: f64) -> Result<()> {
        let built = build(self.law, values).map_err(|e| e.to_string())?;
        values[OP] = values[REST + 11];
        values[VP] = built.player.valve().position();
        values[PV] = values[REST + 12];
        self.built = Some(built);
        self.start_s = time;
        self.played = 0;
        self.moves = Moves::begin(&mut values[MOVED]);
        Ok(())
    }

    fn tune(&mut self, values: &Numbers) -> Result<()> {
        let Some(built) = &mut self.built else { return Ok(()) };
        let sample_time = values[REST];
        let mut valve =
            valve::build(self.law, &values[VALVE..REST], sample_time).map_err(|e| e.to_string())?;
        valve.recall(&built.player.valve().memory());
        *built.player.valve_mut() = valve;
        Ok(())
    }

    fn step(&mut self, values: &mut Numbers, time: f64, step: f64) -> Result<()> {
        let Some(built) = &mut self.built else { return Ok(()) };
        // A sample at the end of the step, up to rounding, belongs to the next.
        let due = ((time - self.start_s + step) / values[REST] - 1e-6).ceil();
        if !(due - self.played as f64 <= MOST) {
            return Err(format!(
                "a step of {step} s has more than {MOST} samples of {} s",
                values[REST]
            ));
        }
        while (self.played as f64) < due {
            let noise = built.noise.as_mut().map_or(0.0, SignalSource::draw);
            let before = built.player.valve().model().position();
            let now =
                built.player.step(values[SP], values[LOAD], noise).map_err(|e| e.to_string())?;
            if !(now.pv.is_finite() && now.op.is_finite() && now.vp.is_finite()) {
                return Err(
                    "the loop is unstable, and its signals are too large to compute".to_owned()
                );
            }
            let after = built.player.valve().model().position();
            self.moves.note(before, after, &mut values[MOVED]);
            (values[PV], values[OP], values[VP]) = (now.pv, now.op, now.vp);
            self.played += 1;
        }
        Ok(())
    }

    fn memory(&self) -> Vec<f64> {
        let mut memory = vec![self.start_s, self.played as f64, self.moves.direction];
        if let Some(built) = &self.built {
            memory.extend(built.player.memory());
        }
        memory
    }

    fn recall(&mut self, _values: &Numbers, memory: &[f64]) -> Result<()> {
        /// Largest plausible number of noise samples.
        const MOST_DRAWS: f64 = 1e9;
        let foreign = || "this is not the state of a loop".to_owned();
        let (Some(built), [start_s, played, direction, loops @ ..]) = (&mut self.built, memory)
        else {
            return Err(foreign());
        };
        if !(0.0..=MOST_DRAWS).contains(played) {
            return Err(foreign());
        }
        built.player.recall(loops).map_err(|e| e.to_string())?;
        if let Some(noise) = &mut built.noise {
            // The stream depends only on its seed, so the used numbers are drawn again.
            for _ in 0..*played as u64 {
                noise.draw();
            }
        }
        (self.start_s, self.played) = (*start_s, *played as u64);
        self.moves.direction = *direction;
        Ok(())
    }

    fn copy(&self) -> Box<dyn FmuModel> {
        Box::new(self.clone())
    }
}
