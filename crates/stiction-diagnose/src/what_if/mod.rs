//! The effects of actions on a loop whose valve sticks: none, repair, retuning, a compensator, a positioner.
//!
//! # What it computes
//! Every [`Action`] is simulated with the same protocol ([`compensate::CompareOptions`]): a window without changes, a
//! set-point step, and a load step. The cases are nominal, with wrong S and J, and with noise. The exact limit cycle of
//! the loop after the action is calculated if possible. The actions are ranked. The recommendation lists what to do,
//! the assumptions, and the test that confirms stiction first.
//!
//! # Assumptions
//! The controller, the process, the valve model, S and J are taken from the given loop. "S and J wrong" means that a
//! compensator or a tuning was chosen for bands different from the valve's bands. Repair and positioner do not depend
//! on S and J.
//!
//! * *As it is*: the loop without changes.
//! * *Repaired*: a valve of the same model with the bands [`WhatIfOptions::repaired`].
//! * *Retuned*: the PI controller whose exact limit cycle has the smallest PV swing, with `Ms` up to
//!   [`WhatIfOptions::most_sensitive`] ([`least_swing`]).
//! * *Positioner*: see [`positioned`].
//! * *Compensated*: each of [`WhatIfOptions::methods`], with its parameters chosen automatically.
//!
//! # Equations
//! **The measure** that ranks the actions is the mean absolute control error (the IAE per second) in the window, in the
//! worst case without noise. It includes offset and swing, in PV units. The standard deviation of the PV is reported
//! too, but it ignores an offset. So it would favour a method that stops the valve at a wrong position.
//!
//! **The evidence against an action**, compared with the present loop, is any of:
//! ```text
//! worst error > present error / 1.25              it gains too little if S and J are wrong
//! error with noise > present / 1.25               or with noise
//! window and load step together, worst > present / 1.25    a load step costs what is gained before it
//! a step does not settle in every case            it lets go of the set point
//! stem travel, worst > 3 times the present        it wears the valve
//! a throw of more than 50 % a second              no pneumatic stem follows it
//! its cycle is longer than a third of the window  what was measured is not its error
//! the loop is unstable without friction           no compensator helps that
//! ```
//! An action may respond to loads more slowly than the present loop and still pay. The recommendation then gives the
//! shortest time between loads. The mean errors are `e` in the window and `l` after a load step, with index 0 at
//! present and 1 in the worst case. A step lasts `h`. It costs `((l1 - e1) - (l0 - e0)) h` more, and between steps the
//! action gains `e0 - e1` per second.
//!
//! # Limits
//! * Stem travel represents wear, because the wear rate of the packing is unknown. The factor 3 ([`WEARING`]) is ours.
//! * The exact cycle is for the loop in continuous time, within the limits of the OP, at a constant set point and load,
//!   without noise, stem lag or quantisation. The simulations include these if the given loop has them.
//! * The valves of He, of He and Wang and of Stenman have a family of cycles. The start of the loop decides between
//!   them.
//! * Costs and the time until a repair are not considered.

mod advice;
#[cfg(feature = "serde")]
mod document;

use crate::bands::Bands;
use crate::closed_loop::{ClosedLoop, Controller};
use crate::compensate::{
    self, CompensatorOutcome, Figures, Knowledge, Method, compare_with_progress,
};
use crate::diagnose::Estimate;
use crate::error::{Error, Result, non_negative};
use crate::finding::{Abstention, Number};
use crate::limit_cycle::tuning::{Retuning, TuningGrid, least_swing};
use crate::limit_cycle::{self, ContinuousLoop, Cycle, FrequencyResponse, Stability, exact};
use crate::recording::Segment;
use crate::valve::Model;
use crate::valve_test::{KnownLoop, PERIODS, PlanOptions, TestPlan, size};
use std::sync::atomic::{AtomicBool, Ordering};

/// An action with more than this multiple of the present stem travel is not recommended.
pub const WEARING: f64 = 3.0;

/// The highest speed of a pneumatic stem, percent of stroke per second. An action that requires more is not
/// recommended. A full stroke in two seconds is fast for an actuator without a booster. The figure is ours.
pub const STEM_SPEED: f64 = 50.0;

/// The smallest ratio of the present control error to the new one that makes an action worthwhile.
pub const WORTH: f64 = 1.25;

/// An action.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Nothing.
    AsItIs,
    /// Repair the valve.
    Repair,
    /// Another tuning.
    Retune(Controller),
    /// A positioner of this gain.
    Positioner(f64),
    /// A compensator.
    Compensate(Method),
}

impl Action {
    /// Name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::AsItIs => "as it is",
            Self::Repair => "valve repaired",
            Self::Retune(_) => "retuned",
            Self::Positioner(_) => "positioner",
            Self::Compensate(method) => method.describe().name,
        }
    }
}

/// Settings of the actions.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIfOptions {
    /// The protocol of the simulations.
    pub protocol: compensate::CompareOptions,
    /// Bands of a repaired valve.
    pub repaired: Bands,
    /// Gain of a positioner.
    pub positioner_gain: f64,
    /// Bound on `Ms` for a retuned loop.
    pub most_sensitive: f64,
    /// Largest factor between the gain and integral time of a retuned loop and the present ones.
    pub retuned_within: f64,
    /// Compensators to try.
    pub methods: Vec<Method>,
}

impl WhatIfOptions {
    /// Suitable settings for a loop around a valve of this model with these bands.
    ///
    /// Every part of the protocol lasts ten cycles or ten settling times of the process, whichever is longer. The scale
    /// is the PV swing of the cycle, but at least the PV change for a tenth of S. The set-point step is twice the
    /// scale, the settling band half of it, and the noise a twentieth. The load step is S, at least 1 %. A repaired
    /// valve has `S = 0.4 %` and `J = 0.1 %`, or its present bands if they are smaller. The positioner has a gain of
    /// 10. A retuned loop has `Ms` up to 2, and its gain and integral time are within a factor of 3.
    ///
    /// # Errors
    /// If a setting of the loop is out of range.
    pub fn suiting(plant: &ClosedLoop, model: Model, bands: Bands) -> Result<Self> {
        sensible(plant)?;
        let bands = model.effective(bands)?;
        let figures = Figures::of(&knowledge(plant, bands))?;
        let continuous = left_alone(plant, model, bands);
        let cycle = [limit_cycle::Method::Exact, limit_cycle::Method::DescribingFunction]
            .into_iter()
            .find_map(|method| limit_cycle::attractor(&continuous, method).ok()?.ok());
        let period = cycle.as_ref().map_or(0.0, |cycle| cycle.period_s);
        let swing = cycle.as_ref().map_or(0.0, |cycle| cycle.half_pp.pv);
        let part = 10.0 * period.max(figures.settle_s);
        let scale = swing.max(0.1 * figures.gain.abs() * bands.s().max(1.0));
        Ok(Self {
            protocol: compensate::CompareOptions {
                from_s: part,
                settle_s: part,
                window_s: part,
                step_s: part,
                set_point_step: 2.0 * scale,
                load_step: bands.s().max(1.0),
                settling_band: 0.5 * scale,
                noise_sd: 0.05 * scale,
                ..compensate::CompareOptions::default()
            },
            repaired: Bands::from_s_j(bands.s().min(0.4), bands.j().min(0.1))?,
            positioner_gain: 10.0,
            most_sensitive: 2.0,
            retuned_within: 3.0,
            methods: Method::ALL.to_vec(),
        })
    }
}

/// Refuses a loop with a time constant far outside its sample time, because the exact cycle would take hours.
fn sensible(plant: &ClosedLoop) -> Result<()> {
    // In sample times. Beyond these limits the calculation takes minutes, or the time is unrealistic.
    const SHORTEST: f64 = 1e-4;
    const SHORTEST_DEAD: f64 = 0.05;
    const LONGEST: f64 = 1e9;
    let (_, den) = plant.process.coefficients();
    // A bound on the fastest pole, within a factor of two. For a first-order process it is the pole itself.
    let powers = den.iter().skip(1).zip(1..);
    let fastest = powers
        .map(|(a, power)| (a / den[0]).abs().powf(1.0 / f64::from(power)))
        .fold(0.0, f64::max);
    let (kp, ki, _) = plant.controller.gains();
    for (name, time, shortest) in [
        ("shortest time constant of the process", 1.0 / fastest, SHORTEST),
        ("dead time", plant.process.dead_time(), SHORTEST_DEAD),
        ("integral time", (kp / ki).abs(), SHORTEST),
    ] {
        let samples = time / plant.sample_time;
        // A time of 0 is allowed.
        if time > 0.0 && time.is_finite() && !(shortest..=LONGEST).contains(&samples) {
            return Err(Error::Inconsistent(format!(
                "the {name} is {time:e} s, {samples:.0e} times the sample time of {} s, but must be between \
                 {shortest} and {LONGEST:e} times; change one of the two times, or leave out the {name}",
                plant.sample_time
            )));
        }
    }
    Ok(())
}

/// The exact cycle of the loop after an action.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub enum Prediction {
    /// The loop does not cycle, with the reason.
    #[cfg_attr(feature = "serde", serde(rename = "none"))]
    NoCycle(String),
    /// The cycle is unknown, with the reason.
    #[cfg_attr(feature = "serde", serde(rename = "unknown"))]
    Unknown(String),
    /// The cycle of the loop.
    #[cfg_attr(feature = "serde", serde(untagged))]
    Cycle(Box<Cycle>),
}

impl Prediction {
    /// The exact cycle of a loop.
    pub fn of(l: &ContinuousLoop) -> Self {
        match exact::cycle(l) {
            Ok(exact::CycleOutcome::Cycles { cycles, .. }) => {
                match cycles.into_iter().find(|cycle| cycle.stable) {
                    Some(cycle) => Self::Cycle(Box::new(cycle)),
                    None => Self::Unknown("no stable limit cycle was found".to_owned()),
                }
            }
            Ok(exact::CycleOutcome::None { reasons }) => {
                let reasons: Vec<String> = reasons.iter().map(ToString::to_string).collect();
                Self::NoCycle(reasons.join("; "))
            }
            Ok(exact::CycleOutcome::NotFound { reason }) => Self::Unknown(reason),
            Err(error) => Self::Unknown(error.to_string()),
        }
    }

    /// The cycle, if the result is a cycle.
    pub fn cycle(&self) -> Option<&Cycle> {
        match self {
            Self::Cycle(cycle) => Some(cycle),
            _ => None,
        }
    }
}

/// What becomes of the loop by an action.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The action.
    pub action: Action,
    /// Parameters and simulations. An action that does not depend on S and J has the same outcome for any wrong S and
    /// J.
    pub played: compensate::Row,
    /// The exact cycle of the loop that it leaves.
    pub cycle: Prediction,
    /// Evidence against the action, each in a few words; empty for the unchanged loop.
    pub against: Vec<String>,
}

impl Row {
    fn new(action: Action, played: compensate::Row, cycle: Prediction) -> Self {
        Self { action, played, cycle, against: vec![] }
    }

    /// The nominal simulation.
    pub fn nominal(&self) -> &CompensatorOutcome {
        self.played.nominal()
    }

    /// Mean absolute control error in the window of the nominal case, in PV units.
    pub fn error(&self) -> f64 {
        self.nominal().measures.iae_per_s
    }

    /// This error in the worst case of wrong S and J, which ranks the actions.
    pub fn worst_error(&self) -> f64 {
        self.played.worst_iae_per_s()
    }
}

/// All actions, the best first.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIf {
    /// The actions, the smallest [`Row::worst_error`] first.
    pub rows: Vec<Row>,
    /// Effects and cost of retuning. If no other tuning exists, `Err` gives the reason.
    pub retuning: std::result::Result<Retuning, String>,
    /// The recommendation, in sentences.
    pub recommendation: Vec<String>,
    /// The assumptions, in sentences.
    pub assumptions: Vec<String>,
    /// The test in manual that confirms stiction before an action; `None` for a valve without friction, or if no test
    /// is possible.
    pub confirm: Option<TestPlan>,
}

#[cfg(feature = "serde")]
stiction_model::written_as!(WhatIf, document::WhatIfDocument);

impl WhatIf {
    /// The loop as it is.
    pub fn as_it_is(&self) -> Option<&Row> {
        self.rows.iter().find(|row| row.action == Action::AsItIs)
    }

    /// The recommended action until the valve is repaired, if there is one.
    pub fn interim(&self) -> Option<&Row> {
        advice::interim(&self.rows)
    }
}

/// Knowledge of a loop around a valve with these bands, with the noise of its PV.
pub fn knowledge(plant: &ClosedLoop, bands: Bands) -> Knowledge {
    Knowledge {
        process: Some(plant.process.clone()),
        noise_sd: plant.noise_sd(),
        ..Knowledge::new(bands.s(), Some(bands.j()), plant.controller.clone(), plant.sample_time)
    }
}

/// The bands of a two-phase valve behind a proportional positioner of gain `g`: `S / (1 + g)` and `J / (1 + g)`.
///
/// # Equations
/// The actuator receives `p = op + g (op - vp)`, so that `p - vp = (1 + g)(op - vp)`. A stuck stem breaks away at `|p -
/// vp| > fs`, which is `|op - vp| > fs / (1 + g)`. For a moving stem, `vp = p - d fd` becomes `vp = op - d fd / (1 +
/// g)`, and `p` moves in the direction of the OP. So the valve as seen from the OP is a two-phase valve with `fs` and
/// `fd` divided by `1 + g`.
///
/// # Limits
/// This is the best possible result of a proportional positioner, because `p` must follow the stem **while it slips**.
/// If the positioner is slower than a slip, the stem makes its whole jump J first. Then dead band and breakaway are
/// divided, but the jump is not. If `g J > S`, the stem overshoots to the opposite side, and positioner and stem hunt.
/// Real positioners are slower than a slip, so a high gain or integral action makes many of them cycle.
///
/// # Errors
/// If the gain is negative or not finite.
pub fn positioned(bands: Bands, gain: f64) -> Result<Bands> {
    let share = 1.0 / (1.0 + non_negative("gain of the positioner", gain)?);
    Bands::from_s_j(share * bands.s(), share * bands.j())
}

/// The loop in continuous time, without its set point and loads. They affect only the mean of a cycle.
fn left_alone(plant: &ClosedLoop, model: Model, bands: Bands) -> ContinuousLoop {
    ContinuousLoop::new(plant.controller.clone(), plant.process.clone(), model, bands)
}

/// A changed loop and its predicted cycle.
struct Changed {
    plant: ClosedLoop,
    cycle: Prediction,
}

/// Compares the actions for a loop around a valve of this model with these bands.
///
/// ```
/// use stiction_model::closed_loop::{ClosedLoop, Controller, Process};
/// use stiction_diagnose::what_if::{Action, WhatIfOptions, what_if};
/// use stiction_model::{Bands, valve::{Assembly, Model}};
///
/// let bands = Bands::from_s_j(5.0, 3.0)?;
/// let mut sticky = ClosedLoop::new(
///     Controller::pi(1.1, 2.5)?,
///     Assembly::new(Model::TwoPhase.build(bands)?),
///     Process::first_order(1.5, 5.93, 1.07)?,
/// );
/// sticky.set_point = 5.0.into();
/// let options = WhatIfOptions { methods: vec![], ..WhatIfOptions::suiting(&sticky, Model::TwoPhase, bands)? };
/// let found = what_if(&sticky, Model::TwoPhase, bands, &options)?;
/// let repaired = found.rows.iter().find(|row| row.action == Action::Repair).unwrap();
/// assert!(10.0 * repaired.error() < found.as_it_is().unwrap().error());
/// assert!(found.recommendation[1].starts_with("Repair the valve"));
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If the loop or an option is out of range, or if the loop grows without bound even with a repaired valve.
pub fn what_if(
    plant: &ClosedLoop,
    model: Model,
    bands: Bands,
    options: &WhatIfOptions,
) -> Result<WhatIf> {
    what_if_with_progress(plant, model, bands, options, || true)
}

/// [`what_if`] with progress. It calls `done` after every simulation and tuning. If `done` returns `false`, it stops.
///
/// # Errors
/// As [`what_if`]; and [`Error::Cancelled`].
pub fn what_if_with_progress(
    plant: &ClosedLoop,
    model: Model,
    bands: Bands,
    options: &WhatIfOptions,
    done: impl Fn() -> bool + Sync,
) -> Result<WhatIf> {
    sensible(plant)?;
    let protocol = &options.protocol;
    let given = bands;
    let bands = model.effective(bands)?;
    let known = knowledge(plant, bands);
    let continuous = left_alone(plant, model, bands);
    let stability = FrequencyResponse::of(&continuous)?.stability();
    let bench = Bench { plant, model, bands, known, continuous, options, done: &done };
    let bands_of =
        |bands: Bands| vec![Number::new("S", bands.s(), "%"), Number::new("J", bands.j(), "%")];

    let mut rows = vec![];
    let as_described = bench.with_bands(given)?;
    // Model and bands do not describe an overshoot or a tolerance of the valve.
    let plain = as_described.plant.valve == plant.valve;
    let present = if plain {
        as_described.cycle
    } else {
        Prediction::Unknown(
            "the valve has settings that the exact cycle does not include".to_owned(),
        )
    };
    rows.push(Row::new(Action::AsItIs, bench.play(plant, bands_of(bands))?, present));
    for (action, bands) in [
        (Action::Repair, options.repaired),
        (Action::Positioner(options.positioner_gain), positioned(bands, options.positioner_gain)?),
    ] {
        let changed = bench.with_bands(bands)?;
        rows.push(Row::new(action, bench.play(&changed.plant, bands_of(bands))?, changed.cycle));
    }
    if rows[..2].iter().any(|row| !row.error().is_finite()) {
        return Err(Error::Inconsistent(
            "the loop grows without bound; lower the gain of its controller, or limit its output"
                .to_owned(),
        ));
    }

    let retuning = match &rows[0].cycle {
        Prediction::NoCycle(reason) if stability == Stability::Stable => {
            Err(format!("there is no limit cycle to remove by tuning, because {reason}"))
        }
        _ => retuned(&bench.continuous, options, &done),
    };
    if let Ok(best) = &retuning {
        rows.push(bench.retune(best)?);
    }
    for played in
        compare_with_progress(plant, &bench.known, &options.methods, protocol, &done)?.rows
    {
        if let Some(method) = played.method {
            let reason = "the exact cycle does not include a compensator".to_owned();
            rows.push(Row::new(Action::Compensate(method), played, Prediction::Unknown(reason)));
        }
    }
    let unstable = stability != Stability::Stable;
    advice::object(&mut rows, protocol.window_s, unstable);
    rows.sort_by(|a, b| a.worst_error().total_cmp(&b.worst_error()));
    let period = rows.iter().find(|row| row.action == Action::AsItIs);
    let period = period.and_then(|row| row.cycle.cycle()).map(|cycle| cycle.period_s);
    let confirm = confirm(plant, bands, protocol, period)?.transpose();
    let recommendation = advice::recommendation(&rows, &retuning, options, bands, unstable);
    let mut assumptions = advice::assumptions(plant, model, bands, options, plain);
    let confirm = confirm.unwrap_or_else(|Abstention(why)| {
        assumptions.push(format!("No test of the valve can be planned, because {why}."));
        None
    });
    Ok(WhatIf { rows, retuning, recommendation, assumptions, confirm })
}

/// Simulates every action on the present loop.
struct Bench<'a, F> {
    plant: &'a ClosedLoop,
    model: Model,
    bands: Bands,
    known: Knowledge,
    continuous: ContinuousLoop,
    options: &'a WhatIfOptions,
    done: &'a F,
}

impl<F: Fn() -> bool + Sync> Bench<'_, F> {
    fn play(&self, plant: &ClosedLoop, parameters: Vec<Number>) -> Result<compensate::Row> {
        let protocol = &self.options.protocol;
        let mut compared = compare_with_progress(plant, &self.known, &[], protocol, self.done)?;
        Ok(compensate::Row { parameters, ..compared.rows.swap_remove(0) })
    }

    fn with_bands(&self, bands: Bands) -> Result<Changed> {
        let valve = self.plant.valve.clone().with_model(self.model.build(bands)?);
        let continuous = ContinuousLoop { bands, ..self.continuous.clone() };
        let plant = ClosedLoop { valve, ..self.plant.clone() };
        Ok(Changed { plant, cycle: Prediction::of(&continuous) })
    }

    fn with_tuning(&self, tuning: &Controller) -> Result<Changed> {
        // Limits, form and anti-windup of the controller do not change.
        let (kp, ki, kd) = tuning.gains();
        let controller = self.plant.controller.clone().with_gains(kp, ki, kd)?;
        let cycle = Prediction::of(&ContinuousLoop {
            controller: controller.clone(),
            ..self.continuous.clone()
        });
        Ok(Changed { plant: ClosedLoop { controller, ..self.plant.clone() }, cycle })
    }

    /// The loop with its best tuning. Cases with a different ratio of the bands have a tuning of their own.
    fn retune(&self, best: &Retuning) -> Result<Row> {
        let changed = self.with_tuning(&best.best.controller)?;
        let (kp, ki, _) = changed.plant.controller.gains();
        let parameters = vec![Number::new("Kc", kp, "%/PV unit"), Number::new("Ti", kp / ki, "s")];
        let mut played = self.play(&changed.plant, parameters)?;
        for outcome in &mut played.outcomes {
            let (s, j) = (outcome.case.s_factor, outcome.case.j_factor);
            // The best tuning depends only on J over S, because amplitudes scale with the bands.
            if s == j {
                continue;
            }
            let assumed =
                assumed(self.model, Bands::from_s_j(s * self.bands.s(), j * self.bands.j())?);
            let continuous = ContinuousLoop { bands: assumed, ..self.continuous.clone() };
            let other = retuned(&continuous, self.options, self.done);
            if let Ok(other) = other {
                let wrong = self.with_tuning(&other.best.controller)?;
                let case = outcome.case;
                *outcome =
                    CompensatorOutcome { case, ..*self.play(&wrong.plant, vec![])?.nominal() };
            }
        }
        let action = Action::Retune(changed.plant.controller);
        Ok(Row::new(action, played, changed.cycle))
    }
}

/// The tuning with the smallest PV swing.
fn retuned(
    continuous: &ContinuousLoop,
    options: &WhatIfOptions,
    done: impl Fn() -> bool + Sync,
) -> std::result::Result<Retuning, String> {
    let cancelled = AtomicBool::new(false);
    let cycle = |l: &ContinuousLoop| {
        if cancelled.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        let prediction = Prediction::of(l);
        cancelled.fetch_or(!done(), Ordering::Relaxed);
        match prediction {
            Prediction::Cycle(cycle) => Ok(Some(*cycle)),
            Prediction::NoCycle(_) => Ok(None),
            Prediction::Unknown(reason) => Err(Error::Inconsistent(reason)),
        }
    };
    TuningGrid::about(&continuous.controller, options.retuned_within, 15)
        .and_then(|grid| least_swing(continuous, &grid, options.most_sensitive, cycle))
        .map_err(|error| error.to_string())
}

/// These bands, or the nearest ones that the model allows.
fn assumed(model: Model, bands: Bands) -> Bands {
    let capped = Bands::from_s_j(bands.s(), bands.j().min(bands.s()));
    if model.build(bands).is_ok() { bands } else { capped.unwrap_or(bands) }
}

/// The test in manual, sized from S and from OP and PV in the window; none if the loop is at rest or too slow.
fn confirm(
    plant: &ClosedLoop,
    bands: Bands,
    protocol: &compensate::CompareOptions,
    period_s: Option<f64>,
) -> Result<Option<std::result::Result<TestPlan, Abstention>>> {
    if bands.s() == 0.0 {
        return Ok(None);
    }
    let sample_time = plant.sample_time;
    let [from, to, ..] = protocol.times();
    let index = |time_s: f64| (time_s / sample_time).round() as usize;
    let mut plant = plant.clone();
    plant.samples = index(to);
    let run = plant.run()?;
    let window = |x: &[f64]| x.get(index(from)..).unwrap_or(x).to_vec();
    let (op, pv) = (window(&run.op), Some(window(&run.pv)));
    let segment = Segment { from: 0.0, sample_time, op, pv, sp: None, vp: None, bridged: 0 };
    // Each turn is held until the process has settled.
    let settle_s = Figures::of(&knowledge(&plant, bands))?.settle_s;
    let known = KnownLoop {
        name: "loop",
        pv_unit: None,
        segment: &segment,
        s: None,
        likely_s: Some(Estimate { value: bands.s(), low: bands.s(), high: bands.s() }),
        period_s: Some(period_s.unwrap_or(0.0).max(settle_s / PERIODS)),
    };
    let rises = Some(plant.process.step_response(settle_s)? > 0.0);
    Ok(Some(size(&known, &PlanOptions { rises, ..PlanOptions::default() })))
}
