//! Possible actions on a recorded loop and their benefit, with intervals because the loop is known with intervals.
//!
//! # Method
//! Every action is simulated on loops drawn from all that agree with the recording ([`Draw`]). The noise is like the
//! recorded noise if the valve explains the swing. Otherwise it is everything that the drawn loop does not explain. All
//! actions use one protocol: undisturbed operation, a set-point step, a load step. An action is tuned once, for the
//! likeliest loop, because a user has only the recording. So the action is also tested on valves and processes for
//! which it was not tuned.
//!
//! # The actions
//! * *As it is*.
//! * *Valve repaired*: S of 0.4 % and J of 0.1 %, or the present values if they are smaller.
//! * *Retuned*, with the same valve, and *repaired and retuned*: Skogestad's PI rule (SIMC). The closed-loop time
//!   constant is the dead time or three executions of the controller, the longer of the two. `Ms` is reported. Left out
//!   if the ends of the gain's interval differ by more than a factor of [`WIDEST`].
//! * *Positioner*: proportional, with a gain of 10, on the present valve; see [`positioned`].
//! * *Compensated*: methods that an ordinary controller can carry out. An integral dead zone is always included. Pulses
//!   are included only if one lasts as long as a stem needs to follow it ([`STEM_SPEED`]).
//!
//! # The swing
//! The swing after an action is the recorded one times the simulated ratio to the present loop, draw by draw. The
//! accuracy of this prediction was measured on loops of the population before and after a repair, with different loads
//! after the repair. After a repair they are a third of the simulated ones in the median, because the parts of the
//! recording that the fitted process does not explain look like loads. They also scatter widely. The intervals include
//! both.
//!
//! # The ranking
//! By the upper end of the interval of the control error, relative to the present loop. So the program recommends no
//! action that may make things worse. Among equally good actions, the action with the least effort comes first. The
//! benefit of an action is *certain* if the PV swing falls by more than 20 % with a probability of at least 95 %, and
//! *probable* above 50 %.

use super::{CHANGED, Draw, Fit, Swing, without};
use crate::bands::Bands;
use crate::closed_loop::{AntiWindup, ClosedLoop, Controller, Handover, Signal};
use crate::compensate::{CompareOptions, Knowledge, Method, nominal};
use crate::fusion::Estimate;
use crate::identify::process::WIDEST;
use crate::limit_cycle::tuning::simc;
use crate::limit_cycle::{ContinuousLoop, FrequencyResponse};
use crate::oscillation::swing;
use crate::parallel::*;
use crate::series::detrended;
use crate::spoken::{LARGEST_FACTOR, rough, set};
use crate::valve::{Assembly, Model};
use crate::what_if::{WEARING, positioned};

/// Assumed speed of an unknown stem, percent per second: a stroke in ten seconds.
pub const STEM_SPEED: f64 = 10.0;
/// Number of draws to simulate.
const PLAYED: usize = 20;
/// Length of a part of the protocol in cycles, and its largest number of samples.
const CYCLES: f64 = 8.0;
const MOST_SAMPLES: f64 = 20_000.0;
/// Largest factor between the control error of a drawn loop without action and the recorded one.
const ALIKE: f64 = 2.0;
/// Standard deviation of the logarithm of an action's effect on the error from errors of every fitted loop: its process
/// is of first order, its stem has one S and J.
const NEVER_KNOWN: f64 = 0.25;
/// The normal distribution in ten points of equal weight.
const TENTHS: [f64; 10] =
    [-1.645, -1.036, -0.674, -0.385, -0.126, 0.126, 0.385, 0.674, 1.036, 1.645];
/// Actions are equally good if the upper ends of their error ratios differ by at most this factor.
const AS_GOOD: f64 = 1.15;
/// Largest swing, as a share of the present one, that counts as a benefit.
const LESS: f64 = 0.8;

/// A possible action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Remedy {
    /// Nothing.
    AsItIs,
    /// Repair the valve.
    Repair,
    /// Another tuning.
    Retune,
    /// Repair the valve, then change the tuning.
    RepairAndRetune,
    /// A positioner.
    Positioner,
    /// A compensator.
    Compensate(Method),
}

impl Remedy {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::AsItIs => "as it is",
            Self::Repair => "valve repaired",
            Self::Retune => "retuned",
            Self::RepairAndRetune => "repaired and retuned",
            Self::Positioner => "positioner",
            Self::Compensate(method) => method.describe().name,
        }
    }

    /// Effort, the least first: nothing, a setting, a block of the control system, a repair, a new part.
    fn effort(self) -> usize {
        match self {
            Self::AsItIs => 0,
            Self::Retune => 1,
            Self::Compensate(_) => 2,
            Self::Repair => 3,
            Self::RepairAndRetune => 4,
            Self::Positioner => 5,
        }
    }

    /// The action on a loop by its word: `nothing`, `repair`, `retune`, `repair-and-retune`, `positioner`, or the
    /// name of a compensator.
    ///
    /// # Errors
    /// If no action has this name. The message lists the known names.
    pub fn by_name(name: &str) -> crate::error::Result<Self> {
        let words = [
            ("nothing", Self::AsItIs),
            ("repair", Self::Repair),
            ("retune", Self::Retune),
            ("repair-and-retune", Self::RepairAndRetune),
            ("positioner", Self::Positioner),
        ];
        let methods = Method::ALL.map(|method| (method.describe().name, Self::Compensate(method)));
        let all = || words.iter().chain(&methods);
        let found = all().find(|(word, _)| word.eq_ignore_ascii_case(name.trim()));
        found.map(|(_, remedy)| *remedy).ok_or_else(|| crate::error::Error::UnknownName {
            family: "action",
            name: name.to_owned(),
            known: all().map(|(word, _)| *word).collect::<Vec<_>>().join(", "),
        })
    }
}

/// A proposed tuning.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Proposal {
    /// Gain, percent per PV unit.
    pub kc: f64,
    /// Integral time, s.
    pub ti: f64,
    /// Peak of the sensitivity function (Ms) with this tuning, over all drawn loops; a loop with 2 or less is robust.
    #[cfg_attr(feature = "serde", serde(rename = "Ms"))]
    pub ms: Estimate,
    /// The tuning rule.
    pub rule: &'static str,
}

/// The effect of an action. The ends of intervals are the 5 and 95 % points of the drawn loops.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Prospect {
    /// The action: `as it is`, `valve repaired`, `retuned`, `repaired and retuned`, `positioner`, or the name of a
    /// compensator.
    #[cfg_attr(feature = "serde", serde(serialize_with = "by_name"), schemars(with = "String"))]
    pub action: Remedy,
    /// Amplitude of the PV about the set point, in PV units, as defined for `Oscillation`.
    pub pv_swing: Estimate,
    /// Ratio of the PV swing to the PV swing of the present loop, for each drawn loop; larger ratios than 20 count as
    /// 20.
    pub pv_swing_ratio: Estimate,
    /// Mean absolute control error, in units of the PV.
    pub error: Estimate,
    /// Ratio of the control error to the control error of the present loop, for each drawn loop; larger ratios than 20
    /// count as 20.
    pub error_ratio: Estimate,
    /// Valve travel, percent of span per hour.
    pub travel: Estimate,
    /// Time to settle after a load step, s; `None` if half of the loops do not settle.
    pub settling_s: Option<Estimate>,
    /// Probability that the PV swing falls by more than 20 %. The benefit is called certain from 0.95 on, and probable
    /// above 0.5.
    pub sure: f64,
    /// The tuning of an action that retunes the controller; `None` for other actions.
    pub tuning: Option<Proposal>,
}

#[cfg(feature = "serde")]
fn by_name<S: serde::Serializer>(remedy: &Remedy, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(remedy.name())
}

impl Prospect {
    /// A quantity as a range, without an end where its ratio to the present loop has none.
    pub fn range(of: &Estimate, ratio: &Estimate) -> String {
        let more = if ratio.high >= LARGEST_FACTOR { " or more" } else { "" };
        format!("{} to {}{more}", rough(of.low), rough(of.high))
    }

    /// By how much the PV swing would fall, such as `36 to 85 %`.
    pub fn fall(&self) -> String {
        let share = |ratio: f64| rough(100.0 * (1.0 - ratio).max(0.0));
        format!("{} to {} %", share(self.pv_swing_ratio.high), share(self.pv_swing_ratio.low))
    }

    /// Whether the benefit is certain.
    pub fn certain(&self) -> bool {
        self.sure >= 0.95
    }

    /// Whether it is probable, and not certain.
    pub fn probable(&self) -> bool {
        self.sure > 0.5 && !self.certain()
    }

    /// How certain the benefit is: `certain`, `probable` or `not certain`; empty for the loop as it is.
    pub fn benefit(&self) -> &'static str {
        match self.action {
            Remedy::AsItIs => "",
            _ if self.certain() => "certain",
            _ if self.probable() => "probable",
            _ => "not certain",
        }
    }
}

/// Possible actions on a recorded loop, the best first.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Prospects {
    /// The actions, in ascending order of the upper end of the ratio of the control error, and then of effort.
    pub actions: Vec<Prospect>,
    /// Number of simulated loops.
    pub loops: usize,
    /// The advice, in sentences.
    pub advice: Vec<String>,
}

/// The logarithm of the recorded swing after an action over the simulated one: median and standard deviation.
///
/// They were measured on 238 sticky loops of the population (seeds from 1,000,000 on), with a repair and without. Other
/// actions were not measured. A loop whose valve still sticks is as uncertain as the present simulated loop. A loop
/// with a positioner is as uncertain as a repaired loop.
struct Unknown {
    median: f64,
    sd: f64,
}

impl Unknown {
    fn of(action: Remedy) -> Self {
        let (median, sd) = match action {
            Remedy::AsItIs => (0.0, 0.4),
            Remedy::Retune | Remedy::Compensate(_) => (0.0, 0.5),
            Remedy::Repair | Remedy::RepairAndRetune | Remedy::Positioner => (-1.1, 1.15),
        };
        Self { median, sd }
    }
}

/// An action on a drawn loop.
struct Played {
    swing: f64,
    error: f64,
    travel: f64,
    settling: Option<f64>,
}

impl Played {
    /// The effect beside the present loop. How far a loop runs away depends on the length of the simulation alone.
    fn limited_by(&self, present: &Self) -> Self {
        Self {
            swing: self.swing.min(LARGEST_FACTOR * present.swing),
            error: self.error.min(LARGEST_FACTOR * present.error),
            ..*self
        }
    }
}

/// Evaluates possible actions on the fitted loop.
///
/// # Errors
/// In words: why no prediction is possible.
pub fn prospects(fit: &Fit) -> Result<Prospects, String> {
    let missing = [fit.controller.why_not(), fit.process.why_not(), fit.valve.why_not()];
    if let Some(why) = missing.into_iter().flatten().next() {
        return Err(why.to_owned());
    }
    // Only loops that stick can improve by an action on the valve.
    let sticks = |draw: &&Draw| draw.model != Model::Ideal;
    let mut draws: Vec<&Draw> = fit.draws.iter().filter(sticks).collect();
    if 2 * draws.len() < fit.draws.len() || draws.is_empty() {
        return Err(format!(
            "in {} of {} possible loops the valve follows its OP, so the benefit of a repair is unknown; check \
             the loops upstream, and the tuning",
            fit.draws.len() - draws.len(),
            fit.draws.len()
        ));
    }
    let every = draws.len().div_ceil(PLAYED);
    let typical = middle(&draws);
    draws = draws.into_iter().step_by(every).collect();
    let execution = typical.execution_s;
    let rest = (3.0 * execution).max(typical.process.dead_time());
    // Kc is proportional to the inverse of the gain.
    let process = fit.process.known();
    let gain = process.map(|process| process.gain.unwrap_or(process.slope));
    let known =
        |of: Estimate| of.low * of.high > 0.0 && (of.high / of.low).ln().abs() < WIDEST.ln();
    let tuned = simc(&typical.process, rest).ok().filter(|_| gain.is_some_and(known));
    let mut remedies = vec![Remedy::AsItIs, Remedy::Repair, Remedy::Positioner];
    if tuned.is_some() {
        remedies.extend([Remedy::Retune, Remedy::RepairAndRetune]);
    }
    remedies.push(Remedy::Compensate(Method::IntegralDeadZone));
    // A pulse of the size of S must last as long as the stem needs for it.
    if execution * STEM_SPEED >= typical.bands.s() {
        remedies.extend([Method::ConstantReinforcement, Method::Knocker].map(Remedy::Compensate));
    }
    let protocol = protocol(fit, typical);
    let known = Knowledge {
        process: Some(typical.process.clone()),
        ..Knowledge::new(
            typical.bands.s(),
            Some(typical.bands.j()),
            typical.controller.clone(),
            execution,
        )
    };
    let recorded = fit.segment.deviation().map_or(0.0, |off| {
        let off = detrended(&off);
        off.iter().map(|v| v.abs()).sum::<f64>() / off.len() as f64
    });
    let alike = |error: f64| error < ALIKE * recorded && error > recorded / ALIKE;
    let play = |draw: &&Draw| -> Option<Vec<Option<Played>>> {
        let [.., end] = protocol.times();
        let disturbance = disturbance(fit, draw, end)?;
        let all: Vec<Option<Played>> = remedies
            .iter()
            .map(|remedy| {
                played(fit, draw, *remedy, tuned.as_ref(), &known, &protocol, &disturbance)
            })
            .collect();
        // A drawn loop that does not reproduce the recording gives no information.
        all[0].as_ref().is_some_and(|alone| alike(alone.error)).then_some(all)
    };
    let table: Vec<Vec<Option<Played>>> = draws.par_iter().filter_map(play).collect();
    if table.len() < 3 {
        return Err(
            "none of the possible loops reproduces the recording; record a set-point step to identify the process \
             better"
                .to_owned()
        );
    }
    // Nothing oscillates in some recordings.
    let before = recorded_cycle(fit).map_or_else(
        || spread(table.iter().filter_map(|row| Some(row[0].as_ref()?.swing))).value,
        |recorded| recorded.pv,
    );
    let mut actions: Vec<Prospect> = vec![];
    for (i, remedy) in remedies.iter().enumerate() {
        let pairs: Vec<(Played, &Played)> = table
            .iter()
            .filter_map(|row| Some((row[i].as_ref()?, row[0].as_ref()?)))
            .map(|(changed, present)| (changed.limited_by(present), present))
            .collect();
        if pairs.len() * 4 < table.len() * 3 {
            continue;
        }
        let of = |what: fn(&Played) -> f64| spread(pairs.iter().map(|(a, _)| what(a)));
        let ratio = |what: fn(&Played) -> f64, median: f64, sd: f64| -> Vec<f64> {
            let ratio = |(a, b): &(Played, &Played)| what(a) / what(b).max(f64::MIN_POSITIVE);
            let unknown = |ratio: f64| TENTHS.map(|z| ratio * (median + sd * z).exp());
            pairs.iter().map(ratio).flat_map(unknown).map(|r| r.min(LARGEST_FACTOR)).collect()
        };
        let as_it_is = *remedy == Remedy::AsItIs;
        let Unknown { median, sd } = Unknown::of(*remedy);
        let swings = ratio(|of| of.swing, median, sd);
        let less = swings.iter().filter(|ratio| **ratio < LESS).count();
        let settled: Vec<f64> = pairs.iter().filter_map(|(a, _)| a.settling).collect();
        let sound = matches!(remedy, Remedy::Retune | Remedy::RepairAndRetune);
        let tuning = tuned.as_ref().filter(|_| sound).and_then(|c| proposal(c, &draws));
        let present = Estimate { value: 1.0, low: 1.0, high: 1.0 };
        actions.push(Prospect {
            action: *remedy,
            pv_swing: spread(swings.iter().map(|ratio| ratio * before)),
            pv_swing_ratio: if as_it_is { present } else { spread(swings.iter().copied()) },
            error: of(|a| a.error),
            error_ratio: if as_it_is {
                present
            } else {
                spread(ratio(|of| of.error, 0.0, NEVER_KNOWN).into_iter())
            },
            travel: of(|a| a.travel),
            settling_s: (2 * settled.len() > pairs.len()).then(|| spread(settled.iter().copied())),
            sure: if as_it_is { 0.0 } else { less as f64 / swings.len() as f64 },
            tuning,
        });
    }
    ranked(&mut actions);
    let advice = advice(fit, &actions);
    Ok(Prospects { actions, loops: table.len(), advice })
}

/// Sorts actions by the upper end of the error's ratio, the smallest first. Actions as good as the best remaining one
/// are sorted by effort.
fn ranked(actions: &mut [Prospect]) {
    for from in 0..actions.len() {
        let rest = &mut actions[from..];
        let best = rest.iter().map(|row| row.error_ratio.high).fold(f64::INFINITY, f64::min);
        let as_good = |row: &&(usize, &Prospect)| row.1.error_ratio.high <= AS_GOOD * best;
        let next = rest.iter().enumerate().collect::<Vec<_>>();
        let least = next.iter().filter(as_good).min_by_key(|(_, row)| row.action.effort());
        if let Some(k) = least.map(|(k, _)| *k) {
            rest[..=k].rotate_right(1);
        }
    }
}

/// The draw whose S is the median.
fn middle<'a>(draws: &[&'a Draw]) -> &'a Draw {
    let mut sorted: Vec<&Draw> = draws.to_vec();
    sorted.sort_by(|a, b| a.bands.s().total_cmp(&b.bands.s()));
    sorted[sorted.len() / 2]
}

/// Median, 5 and 95 % points.
fn spread(values: impl Iterator<Item = f64>) -> Estimate {
    super::valve::quantiles(&mut values.map(|v| (v, 1.0)).collect::<Vec<_>>())
}

fn proposal(tuned: &Controller, draws: &[&Draw]) -> Option<Proposal> {
    let (kp, ki, _) = tuned.gains();
    let peaks = draws.iter().filter_map(|draw| {
        let continuous = ContinuousLoop { controller: tuned.clone(), ..draw.continuous() };
        Some(FrequencyResponse::of(&continuous).ok()?.margins().peak_sensitivity)
    });
    let ms = spread(peaks);
    Some(Proposal { kc: kp, ti: kp / ki, ms, rule: "SIMC (Skogestad)" })
}

/// The recorded oscillation, if there is one.
pub(super) fn recorded_cycle(fit: &Fit) -> Option<Swing> {
    fit.cycle.known().and_then(|cycle| cycle.recorded)
}

/// The parts of the protocol, as long as the loop needs.
fn protocol(fit: &Fit, typical: &Draw) -> CompareOptions {
    let recorded = recorded_cycle(fit);
    let process = fit.process.known();
    let settle =
        process.map_or(0.0, |p| 5.0 * (p.lag_s.map_or(0.0, |lag| lag.value) + p.dead_time_s.value));
    let period = recorded.map_or(0.0, |recorded| recorded.period_s);
    let part = (CYCLES * period.max(settle)).max(60.0 * typical.execution_s);
    let part = part.min(MOST_SAMPLES * typical.execution_s);
    let swing = recorded.map_or(1.0, |recorded| recorded.pv).max(f64::MIN_POSITIVE);
    CompareOptions {
        from_s: part,
        settle_s: part,
        window_s: part,
        step_s: part,
        set_point_step: 2.0 * swing,
        load_step: typical.bands.s().max(1.0),
        settling_band: swing,
        error: 0.0,
        noise_sd: 0.0,
        seed: 1,
    }
}

/// The effect of a remedy on a drawn loop; `None` if the remedy cannot be applied or the loop is unstable.
fn played(
    fit: &Fit,
    draw: &Draw,
    remedy: Remedy,
    tuned: Option<&Controller>,
    known: &Knowledge,
    protocol: &CompareOptions,
    disturbance: &Signal,
) -> Option<Played> {
    let healthy = Bands::from_s_j(draw.bands.s().min(0.4), draw.bands.j().min(0.1)).ok()?;
    let bands = match remedy {
        Remedy::Repair | Remedy::RepairAndRetune => healthy,
        Remedy::Positioner => positioned(draw.bands, 10.0).ok()?,
        _ => draw.bands,
    };
    let retuned = matches!(remedy, Remedy::Retune | Remedy::RepairAndRetune);
    let controller = if retuned { tuned?.clone() } else { draw.controller.clone() };
    let found = fit.controller.known()?;
    let away = |limit: Option<f64>, usual: f64| limit.unwrap_or(usual) - fit.resting.op;
    let (low, high) = (away(found.low, 0.0), away(found.high, 100.0));
    let controller = controller
        .with_handover(Handover::Bumpless)
        .with_limits(low.min(-0.1), high.max(0.1), AntiWindup::Clamping)
        .ok()?;
    let valve = Assembly::new(draw.model.build(bands).ok()?);
    let mut plant = ClosedLoop::new(controller, valve, draw.process.clone());
    plant.sample_time = draw.execution_s;
    // One push, because a loop that starts at rest within its stick band stays there.
    let push = protocol.set_point_step;
    plant.set_point = Signal::Steps(vec![(0.0, push), (0.3 * protocol.from_s, 0.0)]);
    plant.measurement = vec![disturbance.clone()];
    let method = match remedy {
        Remedy::Compensate(method) => Some(method),
        _ => None,
    };
    let (outcome, found) = nominal(&plant, known, method, protocol).ok()?;
    let m = &outcome.measures;
    // Sampled as the recording.
    let every = ((fit.sample_time_s / draw.execution_s).round() as usize).max(1);
    let [from, to, ..] = protocol.times().map(|time_s| (time_s / draw.execution_s) as usize);
    let pv: Vec<f64> = found.run.pv.get(from..to)?.iter().step_by(every).copied().collect();
    let period_s = recorded_cycle(fit).map_or(protocol.window_s / CYCLES, |found| found.period_s);
    let period = period_s / (every as f64 * draw.execution_s);
    let swing = swing(&pv, period.min(pv.len() as f64))?;
    m.iae_per_s.is_finite().then_some(Played {
        swing,
        error: m.iae_per_s,
        travel: 3600.0 * m.vp_travel_per_s,
        settling: outcome.load_settling_s,
    })
}

/// The disturbance of the PV of a drawn loop. If the valve explains the swing, it is noise with the deviation and
/// memory of the fit's residual, because a residual at the period of the swing is the fit's own error. Otherwise it
/// is everything in the recording that the drawn loop does not explain, forwards and backwards.
fn disturbance(fit: &Fit, draw: &Draw, seconds: f64) -> Option<Signal> {
    if fit.cycle.known().is_some_and(|cycle| cycle.explained == Some(true)) {
        let process = fit.process.known()?;
        let (sd, innovation) = (process.disturbance_sd, process.innovation_sd);
        let share = innovation / sd.max(f64::MIN_POSITIVE);
        let keep = (1.0 - share * share).clamp(0.0, 0.999).sqrt();
        let tau_s = if keep > 0.05 { -fit.sample_time_s / keep.ln() } else { 0.0 };
        // Slower movement is a load, which the controller rejects.
        let tau_s = tau_s.min(20.0 * fit.sample_time_s);
        return Some(Signal::Noise { sd: innovation.max(0.3 * sd), tau_s, seed: 7 });
    }
    let recorded = without::disturbance(draw, &fit.segment)?;
    let last = recorded.len() - 1;
    let samples = (seconds / draw.execution_s).ceil() as usize + 1;
    let at = |k: usize| {
        let place = (k as f64 * draw.execution_s / fit.sample_time_s * (1.0 + 1e-12)) as usize;
        let turn = place % (2 * last).max(1);
        recorded[turn.min(2 * last - turn)]
    };
    Some(Signal::Samples((0..samples).map(at).collect()))
}

/// What comes before a repair.
const FIRST: &str = "First do a valve test, unless a test has already shown that the valve sticks.";

fn advice(fit: &Fit, actions: &[Prospect]) -> Vec<String> {
    let find = |remedy: Remedy| actions.iter().find(|row| row.action == remedy);
    let mut all: Vec<String> = vec![];
    all.extend(fit.changed.then(|| CHANGED.to_owned()));
    if let Some(cycle) = fit.cycle.known()
        && cycle.explained == Some(false)
    {
        all.push(
            "The fitted valve does not explain the swing. First look upstream for the cause, before any work on the valve."
                .to_owned(),
        );
    }
    match find(Remedy::Repair) {
        Some(repair) if repair.certain() => {
            all.push(format!("Repair the valve: PV swing would fall by {}.", repair.fall()))
        }
        Some(repair) if repair.probable() => all.push(format!(
            "Repairing the valve would probably help: PV swing would fall by {}. {FIRST}",
            repair.fall()
        )),
        Some(_) => {
            all.push(format!("This recording does not show whether a repair would help. {FIRST}"))
        }
        None => {}
    }
    // A setting whose benefit is not expected stands in the table only.
    if let Some(retune) = find(Remedy::Retune).filter(|row| row.certain() || row.probable())
        && let Some(tuning) = &retune.tuning
    {
        let benefit = match retune.certain() {
            true => format!("PV swing would fall by {}", retune.fall()),
            false => "PV swing would probably fall".to_owned(),
        };
        all.push(format!(
            "Retune to Kc {} and Ti {} s ({}, Ms {} to {}): {benefit}.",
            set(tuning.kc),
            set(tuning.ti),
            tuning.rule,
            rough(tuning.ms.low),
            rough(tuning.ms.high)
        ));
    }
    // Never a positioner: one slower than a slip leaves J, and may hunt.
    let present = find(Remedy::AsItIs).map_or(f64::INFINITY, |row| row.travel.value);
    let spares = |row: &&Prospect| row.certain() && row.travel.value <= WEARING * present;
    let interim = actions.iter().filter(spares).find_map(|row| match row.action {
        Remedy::Compensate(method) => Some((row, method.describe().name)),
        _ => None,
    });
    if let Some((row, name)) = interim {
        all.push(format!(
            "Meanwhile, the compensator {name} would cut PV swing by {}.",
            row.fall()
        ));
    }
    all
}
