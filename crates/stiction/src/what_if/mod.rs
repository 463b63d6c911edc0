//! What would become of a loop whose valve sticks: left alone, repaired, retuned, compensated, positioned.
//!
//! # What it computes
//! Every [`Action`] is simulated through the same protocol ([`compensate::Options`]): a window without
//! changes, a set-point step, a load step; nominally, with S and J wrong, and with noise. Beside it stands the
//! exact limit cycle of the loop that the action leaves, where it can be computed.
//!
//! # Assumptions
//! The controller, the process, S and J are those of the loop that is given. A *repaired* valve has the
//! bands in [`Options::repaired`]. A *positioner* is a proportional inner loop of gain `g` about the stem: the
//! actuator receives `p = op + g (op - vp)`. Then `p - vp = (1 + g)(op - vp)`, so a two-phase valve behind it
//! is again a two-phase valve, with `S / (1 + g)` and `J / (1 + g)`: it breaks away when
//! `|op - vp| > fs / (1 + g)` and moves at `op - fd / (1 + g)`. A real positioner also has a lag, integral
//! action and a supply that limits it.
//! *Retuned* is the PI controller with the least swing of the PV in the exact cycle among those with `Ms` within
//! [`Options::most_sensitive`].
//!
//! # Limits
//! A compensator is chosen knowing S, J and the process; how much a wrong S and J costs stands in
//! [`Row::worst_pv_std`]. A stem moved more often wears sooner; by how much is not known here, so
//! travel is told, not judged, beyond [`WEARING`].

use crate::bands::Bands;
use crate::closed_loop::{ClosedLoop, Controller, Run};
use crate::compensate::{self, Knowledge, Measures, Method, compare};
use crate::detect::{Number, Subject};
use crate::diagnose::{ConfirmingTest, confirming_test};
use crate::error::{Error, Result, non_negative};
use crate::limit_cycle::map::Parameter;
use crate::limit_cycle::tuning::{Grid, Retuning, least_swing};
use crate::limit_cycle::{self, ContinuousLoop, Cycle, attractor};
use crate::recording::{LoopType, Stretch};
use crate::valve::Model;

/// Stem travel, as a multiple of that of the loop as it is, above which an action is not recommended.
pub const WEARING: f64 = 3.0;

/// What could be done.
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
    /// Its name.
    pub fn name(&self) -> String {
        match self {
            Self::AsItIs => "as it is".to_owned(),
            Self::Repair => "valve repaired".to_owned(),
            Self::Retune(_) => "retuned".to_owned(),
            Self::Positioner(_) => "positioner".to_owned(),
            Self::Compensate(method) => method.describe().name.to_owned(),
        }
    }
}

/// What is assumed of the actions.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The protocol of the simulations.
    pub protocol: compensate::Options,
    /// Bands of a valve that comes back from the workshop.
    pub repaired: Bands,
    /// Gain of a positioner.
    pub positioner_gain: f64,
    /// Bound on `Ms` for a retuned loop.
    pub most_sensitive: f64,
    /// By which factor gain and integral time of a retuned loop may differ from the present ones.
    pub retuned_within: f64,
    /// Compensators to be tried.
    pub methods: Vec<Method>,
}

impl Options {
    /// Times and steps that suit a loop: every part of the protocol lasts ten cycles, or ten times its lags where
    /// it does not cycle, and the steps are of the size of its stick band.
    ///
    /// A repaired valve keeps `S = 0.4 %` and `J = 0.1 %`; the positioner has a gain of 10; `Ms` stays within 2;
    /// a tuning within a factor of 10.
    ///
    /// # Errors
    /// If the loop has a setting out of its range.
    pub fn suiting(plant: &ClosedLoop, continuous: &ContinuousLoop) -> Result<Self> {
        let (kp, ki, _) = continuous.controller.gains();
        let reset = if ki == 0.0 { 0.0 } else { (kp / ki).abs() };
        let lag =
            Parameter::DeadTimeOverLag.of(continuous).map_or(reset, |ratio| match ratio > 0.0 {
                true => continuous.process.dead_time() / ratio,
                false => reset,
            });
        let waiting = continuous.process.dead_time() + lag.max(reset);
        let cycle =
            attractor(continuous, limit_cycle::Method::Exact).ok().and_then(|found| found.ok());
        let period = cycle.as_ref().map_or(waiting, |cycle| cycle.period_s);
        let part = 10.0 * period.max(waiting).max(10.0 * plant.sample_time);
        let swing = cycle.as_ref().map_or(0.0, |cycle| cycle.half_pp.pv);
        let gain = Parameter::ProcessGain.of(continuous).unwrap_or(1.0).abs();
        let scale = swing.max(0.1 * gain * continuous.bands.s()).max(1e-9 * gain);
        Ok(Self {
            protocol: compensate::Options {
                from_s: part,
                settle_s: part,
                window_s: part,
                step_s: part,
                set_point_step: 2.0 * scale,
                load_step: continuous.bands.s().max(1.0),
                settling_band: 0.5 * scale,
                noise_sd: 0.05 * scale,
                ..compensate::Options::default()
            },
            repaired: Bands::from_s_j(0.4, 0.1)?,
            positioner_gain: 10.0,
            most_sensitive: 2.0,
            retuned_within: 10.0,
            methods: Method::ALL.to_vec(),
        })
    }
}

/// What becomes of the loop by an action.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The action.
    pub action: Action,
    /// What it was given: parameters of a compensator, a tuning, bands.
    pub parameters: Vec<Number>,
    /// The simulation, nominally.
    pub outcome: compensate::Outcome,
    /// The largest standard deviation of the PV if S and J are wrong, in its units.
    pub worst_pv_std: f64,
    /// The same nominally, with noise.
    pub noisy_pv_std: f64,
    /// The exact cycle that is left; `Err` tells why there is none, `None` that it cannot be computed.
    pub cycle: Option<std::result::Result<Cycle, String>>,
}

/// Everything that could be done, the best first.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIf {
    /// The actions, the least standard deviation of the PV with wrong S and J first.
    pub rows: Vec<Row>,
    /// What retuning costs; `Err` tells why there is no better tuning.
    pub retuning: std::result::Result<Retuning, String>,
    /// What to do, in sentences.
    pub recommendation: Vec<String>,
    /// What this rests on, in sentences.
    pub assumptions: Vec<String>,
    /// The test in manual that confirms it before anything is done.
    pub confirm: Option<ConfirmingTest>,
}

impl WhatIf {
    /// The loop as it is.
    pub fn as_it_is(&self) -> Option<&Row> {
        self.rows.iter().find(|row| row.action == Action::AsItIs)
    }
}

/// Asks what would become of a loop with this valve.
///
/// # Errors
/// If the loop or an option is out of its range, or the loop grows without bound.
pub fn what_if(
    plant: &ClosedLoop,
    model: Model,
    bands: Bands,
    options: &Options,
) -> Result<WhatIf> {
    non_negative("gain of the positioner", options.positioner_gain)?;
    let continuous = ContinuousLoop::of(plant, model, bands)?;
    let known = Knowledge {
        process: Some(plant.process.clone()),
        ..Knowledge::new(bands.s(), Some(bands.j()), plant.controller.clone(), plant.sample_time)
    };
    let with_bands = |bands: Bands| -> Result<(ClosedLoop, ContinuousLoop)> {
        let valve = plant.valve.clone().with_model(model.build(bands)?);
        let plant = ClosedLoop { valve, ..plant.clone() };
        Ok((plant, ContinuousLoop { bands, ..continuous.clone() }))
    };
    let bands_of =
        |bands: Bands| vec![Number::new("S", bands.s(), "%"), Number::new("J", bands.j(), "%")];
    let changed = |action: Action,
                   (plant, continuous): (ClosedLoop, ContinuousLoop),
                   parameters: Vec<Number>|
     -> Result<Row> {
        let row = compare(&plant, &known, &[], &options.protocol)?.rows.swap_remove(0);
        let cycle = attractor(&continuous, limit_cycle::Method::Exact).ok();
        Ok(Row::of(action, parameters, &row, cycle))
    };

    let mut rows = vec![changed(Action::AsItIs, with_bands(bands)?, bands_of(bands))?];
    let repaired = options.repaired;
    rows.push(changed(Action::Repair, with_bands(repaired)?, bands_of(repaired))?);
    let share = 1.0 / (1.0 + options.positioner_gain);
    let held = Bands::from_s_j(share * bands.s(), share * bands.j())?;
    let positioner = Action::Positioner(options.positioner_gain);
    rows.push(changed(positioner, with_bands(held)?, bands_of(held))?);

    let exact = |l: &ContinuousLoop| -> Result<Option<Cycle>> {
        Ok(attractor(l, limit_cycle::Method::Exact)?.ok())
    };
    let retuning = Grid::about(&plant.controller, options.retuned_within, 15)
        .and_then(|grid| least_swing(&continuous, &grid, options.most_sensitive, exact))
        .map_err(|error| error.to_string());
    if let Ok(retuning) = &retuning {
        let (kp, ki, kd) = retuning.best.controller.gains();
        // What else the controller does stays: limits, form, anti-windup.
        let controller = plant.controller.clone().with_gains(kp, ki, kd)?;
        let retuned = (
            ClosedLoop { controller: controller.clone(), ..plant.clone() },
            ContinuousLoop { controller: controller.clone(), ..continuous.clone() },
        );
        let parameters = vec![Number::new("Kc", kp, "%/PV unit"), Number::new("Ti", kp / ki, "s")];
        rows.push(changed(Action::Retune(controller), retuned, parameters)?);
    }
    let compared = compare(plant, &known, &options.methods, &options.protocol)?;
    for row in &compared.rows {
        if let Some(method) = row.method {
            rows.push(Row::of(Action::Compensate(method), row.parameters.clone(), row, None));
        }
    }
    if rows.iter().any(|row| !row.outcome.measures.pv_std.is_finite()) {
        return Err(Error::Inconsistent(
            "a loop grows without bound; lower the gain of its controller, or limit its output"
                .to_owned(),
        ));
    }
    rows.sort_by(|a, b| a.worst_pv_std.total_cmp(&b.worst_pv_std));
    let recommendation = recommend(&rows, &retuning);
    let confirm = confirm(plant, bands)?;
    let assumptions = assumptions(options, bands, model);
    Ok(WhatIf { rows, retuning, recommendation, assumptions, confirm })
}

impl Row {
    fn of(
        action: Action,
        parameters: Vec<Number>,
        row: &compensate::Row,
        cycle: Option<std::result::Result<Cycle, String>>,
    ) -> Self {
        let noisy = row.outcomes.iter().find(|outcome| outcome.case.noise);
        Self {
            action,
            parameters,
            outcome: *row.nominal(),
            worst_pv_std: row.worst_pv_std(),
            noisy_pv_std: noisy.map_or(f64::NAN, |outcome| outcome.measures.pv_std),
            cycle,
        }
    }

    fn measures(&self) -> &Measures {
        &self.outcome.measures
    }
}

/// The test in manual, sized by the simulated loop as it is.
fn confirm(plant: &ClosedLoop, bands: Bands) -> Result<Option<ConfirmingTest>> {
    let Run { op, pv, sample_time, .. } = plant.run()?;
    let from = op.len() / 2;
    let period = crate::closed_loop::period(&op[from..], sample_time, 0.0)?;
    let stretch = Stretch {
        from: 0.0,
        sample_time,
        op: op[from..].to_vec(),
        pv: Some(pv[from..].to_vec()),
        sp: None,
        vp: None,
        bridged: 0,
    };
    let subject =
        Subject::new(&stretch, LoopType::Unknown, period.map(|period| period / sample_time));
    Ok(confirming_test(&subject, (bands.s() > 0.0).then_some(bands.s())))
}

fn recommend(rows: &[Row], retuning: &std::result::Result<Retuning, String>) -> Vec<String> {
    let find = |action: &Action| rows.iter().find(|row| row.action == *action);
    let Some(present) = find(&Action::AsItIs) else { return vec![] };
    let now = present.measures().pv_std;
    let times = |row: &Row| now / row.worst_pv_std;
    let mut said = vec![];
    match &present.cycle {
        Some(Err(reason)) => said.push(format!(
            "The loop does not cycle as it is ({reason}); repair is no matter of stability, but its valve \
             still follows small changes late."
        )),
        Some(Ok(cycle)) => said.push(format!(
            "As it is, the loop cycles every {} s; the PV swings by {} to either side.",
            short(cycle.period_s),
            short(cycle.half_pp.pv)
        )),
        None => {}
    }
    let better = |row: &&Row| times(row) >= 1.25;
    if let Some(repair) = find(&Action::Repair).filter(better) {
        said.push(format!(
            "Repair the valve: that removes the cause, and divides the standard deviation of the PV by {}.",
            factor(times(repair))
        ));
    }
    let travel = |row: &Row| {
        row.measures().vp_travel_per_s / present.measures().vp_travel_per_s.max(f64::MIN_POSITIVE)
    };
    let interim = rows.iter().find(|row| {
        matches!(row.action, Action::Compensate(_) | Action::Retune(_))
            && times(row) >= 1.25
            && travel(row) <= WEARING
    });
    match interim {
        Some(row) => {
            let how = match &row.action {
                Action::Retune(_) => {
                    let numbers = row.parameters.iter();
                    let tuning: Vec<String> =
                        numbers.map(|n| format!("{} = {} {}", n.name, short(n.value), n.unit)).collect();
                    format!("retune it ({})", tuning.join(", "))
                }
                action => format!("compensate it ({})", action.name()),
            };
            said.push(format!(
                "Until then, {how}: the standard deviation is divided by at least {}, even if S and J are \
                 wrong by what was allowed, at {} times the stem's travel.",
                factor(times(row)),
                factor(travel(row))
            ));
        }
        None => said.push(format!(
            "Nothing but a repair is worth it: no tuning and no compensator helps with wrong S and J at less \
             than {WEARING} times the stem's travel."
        )),
    }
    if let Ok(retuning) = retuning
        && let (Some(swing), Some(iae)) = (retuning.swing_ratio(), retuning.iae_ratio())
    {
        said.push(format!(
            "Retuning alone leaves {} of the swing of the PV, and a load step costs {} times the integral \
             of the error that it costs now.",
            if swing > 0.0 { format!("{:.0} %", 100.0 * swing) } else { "nothing".to_owned() },
            factor(iae)
        ));
    }
    said
}

fn assumptions(options: &Options, bands: Bands, model: Model) -> Vec<String> {
    let repaired = options.repaired;
    vec![
        format!(
            "The valve is {} with S = {} % and J = {} %; process and controller are those given.",
            model.describe().name,
            short(bands.s()),
            short(bands.j())
        ),
        format!(
            "A repaired valve keeps S = {} % and J = {} %.",
            short(repaired.s()),
            short(repaired.j())
        ),
        format!(
            "The positioner is proportional with a gain of {}, without lag.",
            short(options.positioner_gain)
        ),
        format!(
            "S and J were also taken {:.0} % too small and too large; noise had a standard deviation of {}.",
            100.0 * options.protocol.error,
            short(options.protocol.noise_sd)
        ),
        format!("A retuned loop keeps Ms within {}.", short(options.most_sensitive)),
    ]
}

/// Three significant digits.
fn short(x: f64) -> String {
    let decimals = (2.0 - x.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{x:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// A ratio; one beyond all measure is told as such.
fn factor(x: f64) -> String {
    if x > 999.0 { "more than 1000".to_owned() } else { short(x) }
}
