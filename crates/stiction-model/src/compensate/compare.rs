//! All methods on one loop, side by side.

use super::{CompensatedRun, Knowledge, Measures, Method, run, settling_s};
use crate::Number;
use crate::closed_loop::{ClosedLoop, Signal};
use crate::error::{Error, Result, finite, non_negative, positive};
use crate::parallel::*;

/// The longest run, samples: several of this length together take gigabytes.
const MOST_SAMPLES: f64 = 1e7;

/// The protocol for every method.
///
/// ```text
/// 0         from_s        from_s + settle_s   + window_s          + step_s        + step_s
/// | OP unchanged  | compensated, settling |  measured  | set-point step | load step |
/// ```
/// Set point and loads are taken from the loop, plus the steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct CompareOptions {
    /// When the compensator is switched on, s.
    #[cfg_attr(feature = "serde", serde(rename = "on_s"))]
    pub from_s: f64,
    /// Time between switching on and the measurement, s.
    pub settle_s: f64,
    /// Length of the measurement window, s.
    pub window_s: f64,
    /// Time after each step, s.
    pub step_s: f64,
    /// Height of the set-point step, in PV units.
    pub set_point_step: f64,
    /// Height of the load step, percent.
    pub load_step: f64,
    /// Control error within which the loop has settled, in PV units.
    pub settling_band: f64,
    /// Relative error in the assumed S and J, both ways.
    #[cfg_attr(feature = "serde", serde(rename = "error_of_s_and_j"))]
    pub error: f64,
    /// Standard deviation of the white noise added to the PV in the case with noise, in its units.
    pub noise_sd: f64,
    /// Seed of that noise.
    pub seed: u64,
}

impl Default for CompareOptions {
    /// On at 200 s, undisturbed for 200 s, measured for 200 s. Steps of 2 PV units and 2 %, each with 200 s to
    /// settle within 0.5 PV units. S and J wrong by 50 %, noise of 0.1.
    fn default() -> Self {
        Self {
            from_s: 200.0,
            settle_s: 200.0,
            window_s: 200.0,
            step_s: 200.0,
            set_point_step: 2.0,
            load_step: 2.0,
            settling_band: 0.5,
            error: 0.5,
            noise_sd: 0.1,
            seed: 1,
        }
    }
}

impl CompareOptions {
    fn check(&self) -> Result<()> {
        for (name, time) in [
            ("time to settle", self.settle_s),
            ("time before the compensator is on", self.from_s),
            ("settling band", self.settling_band),
            ("standard deviation of the noise", self.noise_sd),
        ] {
            non_negative(name, time)?;
        }
        positive("length of the window", self.window_s)?;
        positive("time after a step", self.step_s)?;
        finite("set-point step", self.set_point_step)?;
        finite("load step", self.load_step)?;
        if !(0.0..1.0).contains(&self.error) {
            return Err(Error::Parameter {
                name: "relative error of S and J",
                value: self.error,
                allowed: "at least 0 and below 1".to_owned(),
            });
        }
        Ok(())
    }

    /// Start times of the window, the set-point step and the load step, and the end of the run, s.
    pub fn times(&self) -> [f64; 4] {
        let window = self.from_s + self.settle_s;
        let set_point = window + self.window_s;
        let load = set_point + self.step_s;
        [window, set_point, load, load + self.step_s]
    }
}

/// One run of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Case {
    /// Factor on the assumed S.
    pub s_factor: f64,
    /// Factor on the assumed J.
    pub j_factor: f64,
    /// Whether noise was added.
    pub noise: bool,
}

impl Case {
    /// Correct S and J, without noise.
    pub const NOMINAL: Self = Self { s_factor: 1.0, j_factor: 1.0, noise: false };

    /// The cases of a comparison.
    fn all(options: &CompareOptions) -> [Self; 6] {
        let (less, more) = (1.0 - options.error, 1.0 + options.error);
        let wrong = |s_factor, j_factor| Self { s_factor, j_factor, noise: false };
        [
            Self::NOMINAL,
            wrong(less, less),
            wrong(less, more),
            wrong(more, less),
            wrong(more, more),
            Self { noise: true, ..Self::NOMINAL },
        ]
    }
}

/// The result of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct CompensatorOutcome {
    /// The case.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub case: Case,
    /// Measures in the window.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub measures: Measures,
    /// Mean absolute control error during the time after the set-point step, in PV units.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub set_point_iae_per_s: f64,
    /// Mean absolute control error during the time after the load step, in PV units.
    #[cfg_attr(feature = "serde", serde(with = "crate::finite::Finite"))]
    pub load_iae_per_s: f64,
    /// Time to settle after the set-point step, s; `None` if it did not.
    pub set_point_settling_s: Option<f64>,
    /// Time to settle after the load step, s; `None` if it did not.
    pub load_settling_s: Option<f64>,
}

/// A row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The method; `None` for the uncompensated loop.
    pub method: Option<Method>,
    /// Parameters in the nominal case.
    pub parameters: Vec<Number>,
    /// The nominal case first, then S and J below and above their estimates by the relative error (below, below),
    /// (below, above), (above, below), (above, above), then with noise.
    pub outcomes: Vec<CompensatorOutcome>,
}

/// A [`Row`] in a document, beside its action.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, schemars::JsonSchema)]
struct RowDocument {
    /// The parameters of the action, in the nominal case.
    parameters: Vec<Number>,
    /// The largest mean control error of the cases without noise, in PV units.
    #[serde(with = "crate::finite::Finite")]
    worst_iae_per_s: f64,
    /// The largest standard deviation of the PV in the cases without noise.
    #[serde(with = "crate::finite::Finite")]
    worst_pv_std: f64,
    /// Nominal, with S and J wrong, and with noise.
    cases: Vec<CompensatorOutcome>,
}

#[cfg(feature = "serde")]
crate::written_as!(Row, RowDocument);

#[cfg(feature = "serde")]
impl From<&Row> for RowDocument {
    fn from(row: &Row) -> Self {
        Self {
            worst_iae_per_s: row.worst_iae_per_s(),
            worst_pv_std: row.worst_pv_std(),
            parameters: row.parameters.clone(),
            cases: row.outcomes.clone(),
        }
    }
}

impl Row {
    /// The nominal case.
    pub fn nominal(&self) -> &CompensatorOutcome {
        &self.outcomes[0]
    }

    /// The largest value of a quantity in the cases without noise: the cost of wrong S and J. Infinite if the quantity
    /// overflows in one of them.
    pub fn worst(&self, quantity: impl Fn(&CompensatorOutcome) -> f64) -> f64 {
        let values = self.quiet().map(quantity);
        values.map(|value| if value.is_nan() { f64::INFINITY } else { value }).fold(0.0, f64::max)
    }

    /// The largest mean control error of the cases without noise, by which actions are ranked.
    pub fn worst_iae_per_s(&self) -> f64 {
        self.worst(|outcome| outcome.measures.iae_per_s)
    }

    /// The largest PV standard deviation of the cases without noise.
    pub fn worst_pv_std(&self) -> f64 {
        self.worst(|outcome| outcome.measures.pv_std)
    }

    /// The cases without noise.
    pub fn quiet(&self) -> impl Iterator<Item = &CompensatorOutcome> {
        self.outcomes.iter().filter(|outcome| !outcome.case.noise)
    }

    /// The case with noise, otherwise nominal.
    pub fn noisy(&self) -> Option<&CompensatorOutcome> {
        self.outcomes.iter().find(|outcome| outcome.case.noise)
    }
}

/// A table of methods.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The uncompensated loop first, then the methods in the given order.
    pub rows: Vec<Row>,
}

impl Comparison {
    /// Factor by which `row` lowers the PV standard deviation of the uncompensated loop; infinite if it becomes
    /// zero.
    pub fn reduction(&self, row: &Row) -> f64 {
        self.rows[0].nominal().measures.pv_std / row.nominal().measures.pv_std
    }
}

/// Runs `methods` on `plant`, with parameters from `known`, nominally, with wrong S and J, and with noise. The number
/// of samples comes from the options. Controller and sample time are taken from `plant`, not from `known`.
///
/// ```
/// use stiction_model::closed_loop::{ClosedLoop, Controller, Process};
/// use stiction_model::compensate::{Knowledge, Method, CompareOptions, compare};
/// use stiction_model::{Bands, valve::{Assembly, Model}};
///
/// let controller = Controller::pi(1.1, 2.5)?;
/// let mut sticky = ClosedLoop::new(
///     controller.clone(),
///     Assembly::new(Model::TwoPhase.build(Bands::from_s_j(5.0, 3.0)?)?),
///     Process::first_order(1.5, 5.93, 1.07)?,
/// );
/// sticky.set_point = 5.0.into();
/// let known = Knowledge::new(4.0, None, controller, 0.1);
/// let table = compare(&sticky, &known, &[Method::ModifiedTwoMove], &CompareOptions::default())?;
/// assert!(table.reduction(&table.rows[1]) > 6.0);
/// # Ok::<(), stiction_model::Error>(())
/// ```
///
/// # Errors
/// If the loop, `known`, or an option is out of range. The message names it.
pub fn compare(
    plant: &ClosedLoop,
    known: &Knowledge,
    methods: &[Method],
    options: &CompareOptions,
) -> Result<Comparison> {
    compare_with_progress(plant, known, methods, options, || true)
}

/// [`compare`] with progress: `done` is called after every simulation, and `false` cancels the rest. There are six
/// for each method, and two for the uncompensated loop.
///
/// # Errors
/// As [`compare`]; and [`Error::Cancelled`].
pub fn compare_with_progress(
    plant: &ClosedLoop,
    known: &Knowledge,
    methods: &[Method],
    options: &CompareOptions,
    done: impl Fn() -> bool + Sync,
) -> Result<Comparison> {
    let plant = set_up(plant, options)?;
    let mut noisy = plant.clone();
    noisy.measurement.push(Signal::Noise { sd: options.noise_sd, tau_s: 0.0, seed: options.seed });

    let cases = Case::all(options);
    let rows: Vec<Option<Method>> =
        std::iter::once(None).chain(methods.iter().copied().map(Some)).collect();
    // The estimates do not affect the uncompensated loop, so it runs once without noise.
    let jobs: Vec<(Option<Method>, Case)> = rows
        .iter()
        .flat_map(|method| cases.map(|case| (*method, case)))
        .filter(|(method, case)| method.is_some() || case.noise || *case == Case::NOMINAL)
        .collect();
    let results: Vec<(Vec<Number>, CompensatorOutcome)> = jobs
        .par_iter()
        .map(|(method, case)| {
            let plant = if case.noise { &noisy } else { &plant };
            let (parameters, run) = played(plant, known, *method, *case, options)?;
            let outcome = measured(&run, *case, options)?;
            if done() { Ok((parameters, outcome)) } else { Err(Error::Cancelled) }
        })
        .collect::<Result<_>>()?;
    let row = |method: Option<Method>| {
        let of = |case: Case| {
            let same = |job: &(Option<Method>, Case)| job.0 == method && job.1 == case;
            jobs.iter().position(same).map(|k| &results[k])
        };
        let nominal = of(Case::NOMINAL)?;
        let outcomes =
            cases.map(|case| CompensatorOutcome { case, ..of(case).unwrap_or(nominal).1 });
        Some(Row { method, parameters: nominal.0.clone(), outcomes: outcomes.to_vec() })
    };
    Ok(Comparison { rows: rows.into_iter().filter_map(row).collect() })
}

/// The nominal case of [`compare`] alone, of one method or of the uncompensated loop, and its run.
///
/// # Errors
/// As [`compare`].
pub fn nominal(
    plant: &ClosedLoop,
    known: &Knowledge,
    method: Option<Method>,
    options: &CompareOptions,
) -> Result<(CompensatorOutcome, CompensatedRun)> {
    let plant = set_up(plant, options)?;
    let (_, run) = played(&plant, known, method, Case::NOMINAL, options)?;
    Ok((measured(&run, Case::NOMINAL, options)?, run))
}

/// The loop with the steps of the protocol, for its length.
fn set_up(plant: &ClosedLoop, options: &CompareOptions) -> Result<ClosedLoop> {
    options.check()?;
    let [_, set_point_at, load_at, end] = options.times();
    let mut plant = plant.clone();
    // All of the last part, including rounding.
    let samples = (end / plant.sample_time - 1e-9).ceil();
    if !(samples <= MOST_SAMPLES) {
        return Err(Error::Inconsistent(format!(
            "a run of {end} s has {samples:e} samples, more than {MOST_SAMPLES:e}; shorten the parts of the run, \
             or increase the sample time"
        )));
    }
    plant.samples = samples as usize;
    let stepped = Signal::step(0.0, options.set_point_step, set_point_at);
    let total: Vec<f64> = {
        let own = plant.set_point.sample(plant.sample_time, plant.samples)?;
        let step = stepped.sample(plant.sample_time, plant.samples)?;
        own.iter().zip(step).map(|(own, step)| own + step).collect()
    };
    plant.set_point = Signal::Samples(total);
    plant.load.push(Signal::step(0.0, options.load_step, load_at));
    Ok(plant)
}

/// Runs one case with the parameters of the method.
fn played(
    plant: &ClosedLoop,
    known: &Knowledge,
    method: Option<Method>,
    case: Case,
    options: &CompareOptions,
) -> Result<(Vec<Number>, CompensatedRun)> {
    let assumed = Knowledge {
        s: known.s * case.s_factor,
        j: known.j.map(|j| j * case.j_factor),
        noise_sd: known.noise_sd.hypot(if case.noise { options.noise_sd } else { 0.0 }),
        ..known.clone()
    };
    // Without being switched on, any method leaves the loop unchanged.
    let mut compensator = method.unwrap_or(Method::Knocker).automatic(&assumed)?;
    let parameters = method.map_or_else(Vec::new, |_| compensator.parameters());
    let from_s = if method.is_some() { options.from_s } else { f64::INFINITY };
    Ok((parameters, run(plant, compensator.as_mut(), from_s)?))
}

/// The measures of a run.
fn measured(
    run: &CompensatedRun,
    case: Case,
    options: &CompareOptions,
) -> Result<CompensatorOutcome> {
    let [window, set_point_at, load_at, end] = options.times();
    let settling = |from, to| settling_s(run, from, to, options.settling_band);
    let iae_per_s = |from, to| Measures::of(run, from, to).map(|measures| measures.iae_per_s);
    Ok(CompensatorOutcome {
        case,
        measures: Measures::of(run, window, set_point_at)?,
        set_point_iae_per_s: iae_per_s(set_point_at, load_at)?,
        load_iae_per_s: iae_per_s(load_at, end)?,
        set_point_settling_s: settling(set_point_at, load_at)?,
        load_settling_s: settling(load_at, end)?,
    })
}
