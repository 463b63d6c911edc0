//! A valve and its loop: scenarios, their cycles, and maps of them.

use crate::calls::{Answer, Wrong};
use crate::lab::Lab;
use crate::turns::Wanted;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiction_io::scenario::{self, Scenario, System};
use stiction_io::table;
use stiction_model::closed_loop::ClosedLoop;
use stiction_model::compensate;
use stiction_model::error::Error;
use stiction_model::limit_cycle::map::{Axis, Map, Parameter};
use stiction_model::limit_cycle::{ContinuousLoop, Cycle, Found, Method};
use stiction_model::valve::Model;

/// A loop, in the words of the command: `stiction simulate SCENARIO --set KEY=VALUE ...`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoopRequest {
    /// The name of a built-in scenario.
    scenario: String,
    /// Changed settings, such as `valve.S=4`.
    #[serde(default)]
    set: Vec<String>,
}

impl LoopRequest {
    /// This scenario, with changes.
    pub(crate) fn new(scenario: &str, set: impl Into<Vec<String>>) -> Self {
        Self { scenario: scenario.to_owned(), set: set.into() }
    }

    /// More changes. They replace earlier changes of the same keys.
    pub(crate) fn with(mut self, set: &[&str]) -> Self {
        self.set.extend(set.iter().map(|each| (*each).to_owned()));
        self
    }

    /// These changes, applied to a different scenario.
    pub(crate) fn of(self, scenario: &str) -> Self {
        Self::new(scenario, self.set)
    }

    /// The state of the room that shows it, for an address. Settings are keys and numbers, which need no escapes.
    pub(crate) fn state(&self) -> String {
        let set: String = self.set.iter().map(|each| format!("&set={each}")).collect();
        format!("scenario={}{set}", self.scenario)
    }

    /// The last part of its name.
    pub(crate) fn name(&self) -> &str {
        self.scenario.rsplit('/').next().unwrap_or_default()
    }
}

/// The most samples of a loop.
const SAMPLES: usize = 500_000;
/// Points of a map.
const POINTS: usize = 10_000;

/// The requested scenario. Files are not read.
pub(crate) fn scenario(asked: &LoopRequest) -> Answer<Scenario> {
    let name = &*asked.scenario;
    let text = scenario::built_in_text(name)
        .ok_or_else(|| Wrong::gone(format!("there is no built-in scenario \"{name}\"")))?;
    Ok(Scenario::parse_with(text, name, None, &asked.set)?)
}

/// The requested system, of a bounded length.
pub(crate) fn system(asked: &LoopRequest) -> Answer<System> {
    let system = scenario(asked)?.system;
    let samples = match &system {
        System::ClosedLoop(plant) => plant.samples,
        System::OpenLoop(valve) => valve.samples,
        System::Cascade(cascade) => cascade.slave.samples,
    };
    if samples > SAMPLES {
        return Err(Wrong::request(format!("more than {SAMPLES} samples; shorten the run")));
    }
    Ok(system)
}

/// The requested loop.
pub(crate) fn closed_loop(asked: &LoopRequest) -> Answer<ClosedLoop> {
    match system(asked)? {
        System::ClosedLoop(plant) => Ok(*plant),
        System::OpenLoop(_) => Err(Wrong::request(
            "a control loop is needed here, but the scenario is a valve on a test signal",
        )),
        System::Cascade(_) => {
            Err(Wrong::request("a single loop is needed, but the scenario is a cascade"))
        }
    }
}

pub(crate) fn continuous(asked: &LoopRequest) -> Answer<ContinuousLoop> {
    let (model, bands) = scenario(asked)?.valve;
    Ok(ContinuousLoop::of(&closed_loop(asked)?, model, bands)?)
}

/// Nothing.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Nothing {}

/// All choices.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Choices {
    /// The program, with its version.
    tool: String,
    /// Scenarios of single loops, and of valves on a test signal.
    scenarios: Vec<Choice>,
    /// Models of valves.
    models: Vec<Choice>,
    /// Compensators.
    compensators: Vec<Choice>,
}

/// A choice.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Choice {
    /// Name.
    name: String,
    /// Summary in one line.
    summary: String,
    /// Whether it is a loop, and not a valve on a test signal.
    is_loop: bool,
    /// Settings; of scenarios only.
    settings: Vec<Setting>,
}

/// A setting of a scenario.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Setting {
    /// Key, such as `valve.S`.
    key: String,
    /// Value, as TOML.
    value: String,
    /// Unit; empty for a value without a unit.
    unit: String,
}

impl Choice {
    fn new(name: impl Into<String>, summary: impl Into<String>) -> Self {
        Self { name: name.into(), summary: summary.into(), is_loop: true, settings: vec![] }
    }
}

fn settings(scenario: &Scenario) -> Vec<Setting> {
    let one =
        |(key, value, unit): (String, String, &str)| Setting { key, value, unit: unit.to_owned() };
    scenario.settings().into_iter().map(one).collect()
}

/// All choices.
///
/// # Errors
/// Never.
pub fn scenarios(lab: &Lab, _: Nothing) -> Answer<Choices> {
    let single = |(name, title): (&str, String)| {
        let asked = LoopRequest { scenario: name.to_owned(), set: vec![] };
        let is_loop = match system(&asked).ok()? {
            System::ClosedLoop(_) => true,
            System::OpenLoop(_) => false,
            System::Cascade(_) => return None,
        };
        let scenario = scenario(&asked).ok()?;
        Some(Choice { is_loop, settings: settings(&scenario), ..Choice::new(name, title) })
    };
    let model = |model: Model| Choice::new(model.describe().name, model.describe().summary);
    let method = |of: compensate::Method| Choice::new(of.describe().name, of.describe().summary);
    Ok(Choices {
        tool: lab.tool.clone(),
        scenarios: scenario::built_in().filter_map(single).collect(),
        models: Model::ALL.into_iter().map(model).collect(),
        compensators: compensate::Method::ALL.into_iter().map(method).collect(),
    })
}

/// The cycles of a loop, and its settings.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Cycles {
    /// The cycles from all methods.
    cycles: Vec<Cycle>,
    /// The result of each method.
    methods: Vec<Found>,
    /// Stick band plus dead band, percent of span.
    #[serde(rename = "S")]
    s: f64,
    /// Slip jump, percent of span.
    #[serde(rename = "J")]
    j: f64,
    /// The scenario with all its settings, as TOML.
    toml: String,
    /// The settings of the scenario, key by key.
    settings: Vec<Setting>,
    /// Settings without effect.
    notes: Vec<String>,
}

/// The predicted cycle of a loop.
///
/// # Errors
/// If there is no such loop.
pub fn cycle(_: &Lab, asked: LoopRequest) -> Answer<Cycles> {
    let l = continuous(&asked)?;
    let of = |method| {
        Found::of(&l, method, false).unwrap_or_else(|e| Found::refused(method, e.to_string()))
    };
    let scenario = scenario(&asked)?;
    let methods = [Method::Exact, Method::DescribingFunction].map(of);
    Ok(Cycles {
        cycles: methods.iter().flat_map(|found| &found.cycles).cloned().collect(),
        methods: methods.into(),
        s: scenario.valve.1.s(),
        j: scenario.valve.1.j(),
        settings: settings(&scenario),
        toml: scenario.text,
        notes: scenario.notes,
    })
}

/// The requested map.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapRequest {
    /// The loop.
    #[serde(rename = "loop")]
    plant: LoopRequest,
    /// The parameter along a row.
    x: AxisRequest,
    /// The parameter from row to row.
    y: AxisRequest,
}

/// Values of a parameter, at equal distances.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisRequest {
    /// The parameter: S, J, J/S, Kc, Ti, Kp, theta, tau or theta/tau.
    parameter: String,
    /// The first value.
    from: f64,
    /// The last.
    to: f64,
    /// Number of values.
    points: usize,
}

impl AxisRequest {
    fn axis(&self) -> Answer<Axis> {
        let parameter = Parameter::by_name(&self.parameter)?;
        Ok(Axis::even(parameter, self.from, self.to, self.points.min(POINTS + 1))?)
    }
}

/// The cycles of a loop over two of its parameters, by the exact method.
///
/// # Errors
/// If there is no such loop or parameter.
pub fn map(_: &Lab, asked: MapRequest, wanted: &Wanted) -> Answer<Map> {
    let (x, y) = (asked.x.axis()?, asked.y.axis()?);
    if x.values.len() * y.values.len() > POINTS {
        return Err(Wrong::request(format!("a map of the lab has at most {POINTS} points")));
    }
    let l = continuous(&asked.plant)?;
    // On threads of its own: on those of all calls it would run before their work.
    let threads = rayon::ThreadPoolBuilder::new().build()?;
    let map = || Map::of_with_progress(&l, x, y, Method::Exact, || wanted.goes_on());
    threads.install(map).map_err(|e| match e {
        Error::Cancelled => wanted.over(),
        other => other.into(),
    })
}

/// What a plant records of a loop, as the CSV that `stiction simulate --columns t,sp,pv,op` writes.
pub(crate) fn recorded(sample_time: f64, sp: &[f64], pv: &[f64], op: &[f64]) -> String {
    let times = table::times(sample_time, op.len());
    table::write(&[("t", Some(&times)), ("sp", Some(sp)), ("pv", Some(pv)), ("op", Some(op))])
}
