//! Loops that run while the user changes their settings.
//!
//! A loop lives on the server after [`begin`]. The page asks it for some samples at a time ([`go`]), with the present
//! settings. Without a change it gives the samples of `stiction simulate`, to the last bit. If an answer was lost on the
//! way, the same question gets it again.

use crate::calls::{Answer, Wrong};
use crate::judgement::Judgement;
use crate::lab::{Lab, locked};
use crate::loops::{self, LoopRequest};
use crate::turns::Wanted;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use stiction_diagnose::diagnose::DiagnoseOptions;
use stiction_io::options::ReadOptions;
use stiction_io::reading;
use stiction_io::scenario::System;
use stiction_model::closed_loop::{
    Between, ClosedLoop, IntegralAction, OpenLoop, Player, Sent, Signal, SignalSource,
};
use stiction_model::compensate::{At, Compensator, Knowledge, Method};
use stiction_model::stem::{ParameterSet, StemValve};
use stiction_model::valve::{Assembly, Start, Valve};

/// Number of loops that run at a time. With more, the least recently used one is dropped.
const LOOPS: usize = 32;
/// Number of samples of one answer.
const SAMPLES: usize = 20_000;
/// Number of samples of a verdict at most, so that it takes seconds.
const JUDGED: usize = 150_000;

/// The loops that run.
#[derive(Debug, Default)]
pub(crate) struct Room {
    lives: Mutex<Lives>,
}

#[derive(Debug, Default)]
struct Lives {
    count: u64,
    /// With the time of its last use.
    by_id: HashMap<u64, (u64, Arc<Mutex<Live>>)>,
}

impl Room {
    fn add(&self, live: Live) -> u64 {
        let mut lives = locked(&self.lives);
        lives.count += 1;
        let id = lives.count;
        lives.by_id.insert(id, (id, Arc::new(Mutex::new(live))));
        while lives.by_id.len() > LOOPS {
            let oldest = lives.by_id.iter().min_by_key(|(_, (asked, _))| *asked).map(|(id, _)| *id);
            oldest.map(|id| lives.by_id.remove(&id));
        }
        id
    }

    fn of(&self, id: u64) -> Option<Arc<Mutex<Live>>> {
        let mut lives = locked(&self.lives);
        lives.count += 1;
        let now = lives.count;
        let (asked, live) = lives.by_id.get_mut(&id)?;
        *asked = now;
        Some(Arc::clone(live))
    }
}

/// The settings of a loop at a moment.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Knobs {
    /// The loop.
    #[serde(rename = "loop")]
    plant: LoopRequest,
    /// Use the physical stem with the same S and J instead of the data-driven model.
    #[serde(default)]
    stem: bool,
    /// Name of the compensator between controller and valve; none without a compensator.
    #[serde(default)]
    compensator: Option<String>,
    /// The signal to the valve in manual mode, percent of span; null in automatic.
    #[serde(default)]
    manual: Option<f64>,
}

/// A loop that runs from now on.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Begun {
    /// Number, for later calls.
    id: u64,
    /// Time between samples, s.
    sample_time_s: f64,
}

/// A question to a running loop.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Go {
    /// The number of the loop.
    id: u64,
    /// The number of the sample that comes next.
    from: u64,
    /// How many samples.
    samples: usize,
    /// The settings of the moment.
    knobs: Knobs,
}

/// Some samples of a loop.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct Samples {
    /// The number of the first.
    from: u64,
    /// Set point; none of a valve on a test signal.
    pub(crate) sp: Vec<f64>,
    /// Process value; none of a valve on a test signal.
    pub(crate) pv: Vec<f64>,
    /// Output of the controller, percent of span.
    pub(crate) op: Vec<f64>,
    /// The signal to the valve: the OP, or the signal from a compensator or by hand.
    signal: Vec<f64>,
    /// Valve position, percent of span.
    pub(crate) vp: Vec<f64>,
    /// Whether process and loop continued from their state with the present settings; otherwise they began at rest again.
    went_on: bool,
}

impl Samples {
    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.op.len()
    }

    /// Those that follow.
    pub(crate) fn append(&mut self, mut next: Self) {
        self.sp.append(&mut next.sp);
        self.pv.append(&mut next.pv);
        self.op.append(&mut next.op);
        self.signal.append(&mut next.signal);
        self.vp.append(&mut next.vp);
    }
}

/// Starts a loop at rest.
///
/// # Errors
/// If there is no such loop.
pub fn begin(lab: &Lab, knobs: Knobs) -> Answer<Begun> {
    let live = Live::new(knobs)?;
    let sample_time_s = live.runs.sample_time();
    Ok(Begun { id: lab.lives.add(live), sample_time_s })
}

/// Continues a loop.
///
/// # Errors
/// If the loop has ended or is at a different sample, or the settings make no loop.
pub fn go(lab: &Lab, asked: Go) -> Answer<Samples> {
    let live =
        lab.lives.of(asked.id).ok_or_else(|| Wrong::gone("this loop has ended; restart it"))?;
    let mut live = locked(&live);
    if asked.samples == 0 || asked.samples > SAMPLES {
        return Err(Wrong::request(format!("the request must be for 1 to {SAMPLES} samples")));
    }
    let again = live.last.from == asked.from && asked.from < live.at;
    if again && live.last.op.len() == asked.samples {
        return Ok(live.last.clone());
    }
    if live.at != asked.from {
        return Err(Wrong::gone(format!("this loop is at sample {}, not {}", live.at, asked.from)));
    }
    let went_on = live.turn(asked.knobs)?;
    let samples = live.go(asked.samples)?;
    live.last = Samples { went_on, ..samples };
    Ok(live.last.clone())
}

/// The verdict on SP, PV and OP of a loop, simulated from rest for the duration of its scenario.
///
/// # Errors
/// If no such loop exists, or the simulation diverges.
pub fn verdict(_: &Lab, knobs: Knobs, wanted: &Wanted) -> Answer<Judgement> {
    let name = format!("{}.csv", knobs.plant.name());
    let mut live = Live::new(Knobs { manual: None, ..knobs })?;
    let Runs::Loop(of) = &live.runs else {
        return Err(Wrong::request(
            "the verdict needs a control loop, but the scenario is a valve on a test signal",
        ));
    };
    let samples = of.plant.samples;
    if samples > JUDGED {
        return Err(Wrong::request(format!(
            "the lab judges at most {JUDGED} samples of a loop, and this one has {samples}; choose a shorter duration"
        )));
    }
    let mut run = Samples::default();
    while run.len() < samples {
        wanted.check()?;
        run.append(live.go(SAMPLES.min(samples - run.len()))?);
    }
    wanted.check()?;
    // Through CSV, so that the result equals that of `stiction diagnose` on the file.
    let csv = loops::recorded(live.runs.sample_time(), &run.sp, &run.pv, &run.op);
    let read = reading::parse(csv.as_bytes(), &name, &ReadOptions::default())?;
    let recording = read
        .recordings
        .first()
        .ok_or_else(|| Wrong::own("internal error: the simulated recording cannot be read"))?;
    Ok(Judgement::new(wanted.diagnose(recording, &DiagnoseOptions::default())?))
}

/// The valve of a loop.
#[derive(Debug, Clone)]
enum Fitted {
    Model(Box<Assembly>),
    Stem(Box<StemValve>),
}

impl Fitted {
    /// The valve of the settings: the scenario's valve, or a stem.
    fn of(knobs: &Knobs, valve: &Assembly, sample_time: f64) -> Answer<Self> {
        if !knobs.stem {
            return Ok(Self::Model(Box::new(valve.clone())));
        }
        let bands = loops::scenario(&knobs.plant)?.valve.1;
        let set = ParameterSet::named("cts")?;
        let force = |percent: f64| percent / 100.0 * set.stem.spring_n_per_m * set.stem.stroke_m;
        let changes = [("static_n", force(bands.fs())), ("coulomb_n", force(bands.fd()))];
        let stem = set.stem_with(Some("classical"), &changes)?;
        Ok(Self::Stem(Box::new(StemValve::new(stem, sample_time)?)))
    }

    /// Goes on from where another valve is.
    fn take_over(&mut self, other: &Self, op: f64) {
        match (self, other) {
            (Self::Model(own), Self::Model(other))
                if std::mem::discriminant(own.model()) == std::mem::discriminant(other.model()) =>
            {
                own.recall(&other.memory());
            }
            (Self::Stem(own), Self::Stem(other)) if own.stem() == other.stem() => {
                *own = other.clone();
            }
            (own, other) => {
                own.restart(Start { op, ..Start::at_rest(other.position()) });
            }
        }
    }
}

impl Valve for Fitted {
    fn step(&mut self, op: f64) -> f64 {
        match self {
            Self::Model(valve) => valve.step(op),
            Self::Stem(valve) => valve.step(op),
        }
    }

    fn position(&self) -> f64 {
        match self {
            Self::Model(valve) => valve.position(),
            Self::Stem(valve) => valve.position(),
        }
    }

    fn restart(&mut self, start: Start) {
        match self {
            Self::Model(valve) => valve.restart(start),
            Self::Stem(valve) => valve.restart(start),
        }
    }
}

/// Sample time, s, and number of samples that a signal is made for.
type Clock = (f64, usize);

/// A sum of signals, sample by sample.
#[derive(Debug, Clone)]
struct Sum {
    signals: Vec<Signal>,
    sources: Vec<SignalSource>,
}

impl Sum {
    /// These signals from sample `at` on.
    fn of(signals: &[Signal], (sample_time, samples): Clock, at: u64) -> Answer<Self> {
        let source = |signal: &Signal| -> Answer<SignalSource> {
            let mut source = signal.source(sample_time, samples)?;
            (0..at).for_each(|_| {
                source.draw();
            });
            Ok(source)
        };
        let sources = signals.iter().map(source).collect::<Answer<_>>()?;
        Ok(Self { signals: signals.to_vec(), sources })
    }

    /// Replaces the signals if they differ.
    fn turn(&mut self, signals: &[Signal], clock: Clock, at: u64) -> Answer<()> {
        if self.signals != signals {
            *self = Self::of(signals, clock, at)?;
        }
        Ok(())
    }

    fn draw(&mut self) -> f64 {
        // Constant parts first, as the simulation adds them.
        let mut sum = 0.0;
        for (signal, source) in self.signals.iter().zip(&mut self.sources) {
            if matches!(signal, Signal::Constant(_)) {
                sum += source.draw();
            }
        }
        for (signal, source) in self.signals.iter().zip(&mut self.sources) {
            if !matches!(signal, Signal::Constant(_)) {
                sum += source.draw();
            }
        }
        sum
    }
}

/// A running loop with its last answer.
#[derive(Debug)]
pub(crate) struct Live {
    knobs: Knobs,
    runs: Runs,
    /// The number of the sample that comes next.
    at: u64,
    last: Samples,
}

/// What runs.
#[derive(Debug)]
enum Runs {
    Loop(Box<Loop>),
    Valve(Box<OnSignal>),
}

/// A control loop.
#[derive(Debug)]
struct Loop {
    plant: ClosedLoop,
    player: Player<Fitted>,
    sp: Sum,
    load: Sum,
    measurement: Sum,
    compensator: Option<Box<dyn Compensator>>,
}

/// A valve on a test signal.
#[derive(Debug)]
struct OnSignal {
    system: OpenLoop,
    valve: Fitted,
    input: Sum,
}

impl Runs {
    fn new(knobs: &Knobs) -> Answer<Self> {
        Ok(match loops::system(&knobs.plant)? {
            System::ClosedLoop(plant) => Self::Loop(Box::new(Loop::new(knobs, *plant)?)),
            System::OpenLoop(system) => Self::Valve(Box::new(OnSignal::new(knobs, system)?)),
            System::Cascade(_) => {
                return Err(Wrong::request("the lab cannot run a cascade; choose a single loop"));
            }
        })
    }

    fn sample_time(&self) -> f64 {
        match self {
            Self::Loop(of) => of.plant.sample_time,
            Self::Valve(of) => of.system.sample_time,
        }
    }
}

impl Live {
    /// A loop without changes, at rest.
    pub(crate) fn of(plant: LoopRequest) -> Answer<Self> {
        Self::new(Knobs { plant, stem: false, compensator: None, manual: None })
    }

    /// Time between samples, s.
    pub(crate) fn sample_time(&self) -> f64 {
        self.runs.sample_time()
    }

    /// Manual mode with this OP from the next sample on, or automatic.
    pub(crate) fn by_hand(&mut self, op: Option<f64>) {
        self.knobs.manual = op;
    }

    fn new(knobs: Knobs) -> Answer<Self> {
        Ok(Self { runs: Runs::new(&knobs)?, knobs, at: 0, last: Samples::default() })
    }

    /// Changes the settings; returns whether the loop continues from its state.
    fn turn(&mut self, knobs: Knobs) -> Answer<bool> {
        if knobs == self.knobs {
            return Ok(true);
        }
        let signal = self.last.signal.last().copied();
        let (next, went_on) = match (&mut self.runs, Runs::new(&knobs)?) {
            (now, next) if now.sample_time() != next.sample_time() => {
                return Err(Wrong::request(
                    "the sample time cannot change while the loop runs; restart the loop",
                ));
            }
            (Runs::Loop(now), Runs::Loop(mut next)) => {
                let went_on = next.take_over(now, self.at, signal)?;
                let same_loop = (&knobs.plant, knobs.stem) == (&self.knobs.plant, self.knobs.stem);
                if same_loop && knobs.compensator == self.knobs.compensator {
                    next.compensator = now.compensator.take();
                }
                (Runs::Loop(next), went_on)
            }
            (Runs::Valve(now), Runs::Valve(mut next)) => {
                next.valve.take_over(&now.valve, signal.unwrap_or(0.0));
                next.input = Sum::of(&next.input.signals, next.clock(), self.at)?;
                (Runs::Valve(next), true)
            }
            (_, next) => (next, false),
        };
        (self.runs, self.knobs) = (next, knobs);
        Ok(went_on)
    }

    /// Goes on for some samples.
    pub(crate) fn go(&mut self, samples: usize) -> Answer<Samples> {
        let mut done = Samples { from: self.at, ..Samples::default() };
        for _ in 0..samples {
            match &mut self.runs {
                Runs::Loop(of) => of.step(self.at, self.knobs.manual, &mut done)?,
                Runs::Valve(of) => of.step(self.knobs.manual, &mut done),
            }
            self.at += 1;
        }
        Ok(done)
    }
}

impl Loop {
    fn new(knobs: &Knobs, plant: ClosedLoop) -> Answer<Self> {
        let clock = (plant.sample_time, plant.samples);
        let valve = Fitted::of(knobs, &plant.valve, plant.sample_time)?;
        Ok(Self {
            player: plant.player_of(valve)?,
            sp: Sum::of(std::slice::from_ref(&plant.set_point), clock, 0)?,
            load: Sum::of(&plant.load, clock, 0)?,
            measurement: Sum::of(&plant.measurement, clock, 0)?,
            compensator: compensator(knobs, &plant)?,
            plant,
        })
    }

    /// Continues from the state of another loop with this last signal to the valve; returns whether it could.
    fn take_over(&mut self, other: &mut Self, at: u64, signal: Option<f64>) -> Answer<bool> {
        let clock = (self.plant.sample_time, self.plant.samples);
        for (own, of) in [
            (&mut self.sp, &mut other.sp),
            (&mut self.load, &mut other.load),
            (&mut self.measurement, &mut other.measurement),
        ] {
            let wanted = std::mem::take(&mut own.signals);
            std::mem::swap(own, of);
            own.turn(&wanted, clock, at)?;
        }
        let rests = |of: &ClosedLoop| (of.op_rest, of.pv_rest);
        let went_on =
            rests(&self.plant) == rests(&other.plant) && self.player.take_over(&other.player);
        if went_on {
            let op = signal.unwrap_or(self.plant.op_rest);
            self.player.valve_mut().take_over(other.player.valve(), op);
        }
        Ok(went_on)
    }

    fn step(&mut self, at: u64, manual: Option<f64>, done: &mut Samples) -> Answer<()> {
        let (sp, load) = (self.sp.draw(), self.load.draw());
        let measurement = self.measurement.draw();
        let mut middle = Middle {
            manual,
            compensator: self.compensator.as_mut(),
            time_s: at as f64 * self.plant.sample_time,
            signal: f64::NAN,
        };
        let played = self.player.step_between(sp, load, measurement, &mut middle)?;
        let signal = middle.signal;
        if [played.pv, played.op, played.vp].iter().any(|value| !value.is_finite()) {
            return Err(Wrong::request(
                "the loop is unstable and has left all limits; lower the controller gain, and restart",
            ));
        }
        done.sp.push(sp);
        done.pv.push(played.pv);
        done.op.push(manual.unwrap_or(played.op));
        done.signal.push(signal);
        done.vp.push(played.vp);
        Ok(())
    }
}

impl OnSignal {
    fn new(knobs: &Knobs, system: OpenLoop) -> Answer<Self> {
        let mut valve = Fitted::of(knobs, &system.valve, system.sample_time)?;
        let signals = std::slice::from_ref(&system.input);
        let input = Sum::of(signals, (system.sample_time, system.samples), 0)?;
        let start = system.start.unwrap_or_else(|| input.clone().draw());
        valve.restart(Start::at_rest(start));
        Ok(Self { valve, input, system })
    }

    fn clock(&self) -> Clock {
        (self.system.sample_time, self.system.samples)
    }

    /// The signal represents the output of a controller, and the PV is missing.
    fn step(&mut self, manual: Option<f64>, done: &mut Samples) {
        let op = self.input.draw();
        let signal = manual.unwrap_or(op);
        done.op.push(signal);
        done.signal.push(signal);
        done.vp.push(self.valve.step(signal));
    }
}

/// The compensator of the settings, with parameters from the true loop.
fn compensator(knobs: &Knobs, plant: &ClosedLoop) -> Answer<Option<Box<dyn Compensator>>> {
    let Some(name) = &knobs.compensator else { return Ok(None) };
    let bands = loops::scenario(&knobs.plant)?.valve.1;
    let known = Knowledge {
        process: Some(plant.process.clone()),
        noise_sd: plant.noise_sd(),
        ..Knowledge::new(bands.s(), Some(bands.j()), plant.controller.clone(), plant.sample_time)
    };
    Ok(Some(Method::by_name(name)?.automatic(&known)?))
}

/// Between controller and valve: manual operation, a compensator, or nothing.
struct Middle<'a> {
    manual: Option<f64>,
    compensator: Option<&'a mut Box<dyn Compensator>>,
    time_s: f64,
    /// What was sent.
    signal: f64,
}

impl Between for Middle<'_> {
    fn integral(&mut self, sp: f64, pv: f64) -> IntegralAction {
        match &mut self.compensator {
            Some(compensator) if self.manual.is_none() => {
                At { compensator: compensator.as_mut(), time_s: self.time_s }.integral(sp, pv)
            }
            _ => IntegralAction::Acts,
        }
    }

    fn send(&mut self, sp: f64, pv: f64, op: f64) -> Sent {
        let sent = match (self.manual, &mut self.compensator) {
            (Some(by_hand), _) => Sent::held(by_hand),
            (None, Some(compensator)) => {
                At { compensator: compensator.as_mut(), time_s: self.time_s }.send(sp, pv, op)
            }
            (None, None) => Sent::added(op),
        };
        self.signal = sent.signal;
        sent
    }
}
