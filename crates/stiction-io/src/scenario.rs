//! Scenarios: what to simulate, in TOML.
//!
//! ```toml
//! title = "The paper's loop"
//! sample_time = 0.01          # s
//! duration = 600              # s
//! [set_point]
//! value = 5
//! [controller]
//! kc = 1.1
//! ti = 2.5                    # s
//! [valve]
//! model = "two-phase"
//! S = 5                       # percent of span
//! J = 3
//! [process]
//! gain = 1.5
//! tau = 5.93                  # s
//! delay = 1.07                # s
//! ```
//! With `[controller]` and `[process]` it is a closed loop, with `[master]` besides a cascade; with
//! `[input]` in their place it is a valve on a test signal. Every key of every table is listed in
//! the project's `docs/scenarios.md`.

use crate::built_in::SCENARIOS;
use crate::bytes;
use crate::error::{Error, Result};
use crate::fields::{Fields, Wrong, line_of};
use crate::table::Table;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use stiction_model::Bands;
use stiction_model::closed_loop::{
    AntiWindup, Cascade, ClosedLoop, Controller, DeadTime, DerivativeOn, Form, Handover, OpenLoop,
    Process, Signal, Wave,
};
use stiction_model::valve::{Assembly, Model, ValveSpec};
use toml::de::DeTable;

/// What a scenario simulates.
#[derive(Debug, Clone, PartialEq)]
pub enum System {
    /// A valve on a test signal.
    OpenLoop(OpenLoop),
    /// A control loop.
    ClosedLoop(Box<ClosedLoop>),
    /// A slave loop under a master.
    Cascade(Box<Cascade>),
}

/// A scenario as read.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// What it shows, in one line.
    pub title: String,
    /// What it simulates.
    pub system: System,
    /// The valve's model and bands.
    pub valve: (Model, Bands),
    /// The TOML text, with all settings in it.
    pub text: String,
    /// What was given but has no effect, in sentences.
    pub notes: Vec<String>,
    /// The files that its signals were read from.
    pub files: Vec<PathBuf>,
}

/// Names and titles of the built-in scenarios.
pub fn built_in() -> impl Iterator<Item = (&'static str, String)> {
    SCENARIOS.iter().map(|(name, text)| {
        let title = Scenario::parse(text, name, None).map(|scenario| scenario.title);
        (*name, title.unwrap_or_default())
    })
}

/// The TOML text of a built-in scenario, if there is one of that name.
pub fn built_in_text(name: &str) -> Option<&'static str> {
    SCENARIOS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

impl Scenario {
    /// The built-in scenario `name`, or else the one in the file of that path, with `settings` such
    /// as `valve.S=4` applied.
    ///
    /// # Errors
    /// If there is no such scenario, it is not well formed, or a setting does not fit it.
    pub fn open(name: &str, settings: &[String]) -> Result<Self> {
        let (text, folder) = match built_in_text(name) {
            Some(text) => (text.to_owned(), None),
            None => {
                let path = Path::new(name);
                let text = bytes::read(path).map_err(|error| match error {
                    Error::File { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                        let known: Vec<_> = SCENARIOS.iter().map(|(name, _)| *name).collect();
                        Error::UnknownScenario { name: name.to_owned(), known: known.join(", ") }
                    }
                    other => other,
                })?;
                let text = String::from_utf8(text).map_err(|e| Error::Scenario {
                    origin: name.to_owned(),
                    line: line_of(e.as_bytes(), e.utf8_error().valid_up_to()),
                    message: "is not UTF-8 text; save the file in UTF-8".to_owned(),
                })?;
                (text, Some(path.parent().unwrap_or(Path::new("."))))
            }
        };
        Self::parse_with(&text, name, folder, settings)
    }

    /// As [`parse`](Self::parse), with `settings` such as `valve.S=4` applied.
    ///
    /// # Errors
    /// If it is not well formed, or a setting does not fit it.
    pub fn parse_with(
        text: &str,
        origin: &str,
        folder: Option<&Path>,
        settings: &[String],
    ) -> Result<Self> {
        let plain = Self::parse(text, origin, folder)?;
        if settings.is_empty() {
            return Ok(plain);
        }
        let changed = apply(text, settings)?;
        // The text was well formed before, so what is wrong now came with the settings.
        Self::parse(&changed, origin, folder).map_err(|e| match e {
            Error::Scenario { message, .. } => {
                Error::Setting { settings: settings.to_vec(), message }
            }
            other => other,
        })
    }

    /// Reads a scenario from `text`. `origin` names it in errors; signals are read from files in
    /// `folder`, or refused without one.
    ///
    /// # Errors
    /// If it is not well formed; the error tells the line.
    pub fn parse(text: &str, origin: &str, folder: Option<&Path>) -> Result<Self> {
        let at = |wrong: Wrong| Error::Scenario {
            origin: origin.to_owned(),
            line: line_of(text.as_bytes(), wrong.span.start),
            message: wrong.message,
        };
        let document = DeTable::parse(text).map_err(|e| {
            at(Wrong { span: e.span().unwrap_or_default(), message: e.message().to_owned() })
        })?;
        let mut builder = Builder {
            folder,
            valve: (Model::Ideal, Bands::NONE),
            notes: vec![],
            files: RefCell::default(),
        };
        let (title, system) = Fields::document(&document, keys::SCENARIO)
            .and_then(|top| builder.scenario(top))
            .map_err(at)?;
        let Builder { valve, notes, files, .. } = builder;
        Ok(Self { title, system, valve, text: text.to_owned(), notes, files: files.into_inner() })
    }
}

impl Scenario {
    /// Every setting: its dotted key, its value as TOML, and its unit where it has one.
    pub fn settings(&self) -> Vec<(String, String, &'static str)> {
        let mut settings = vec![];
        if let Ok(document) = self.text.parse::<toml_edit::DocumentMut>() {
            collect(document.as_table(), "", &mut settings);
        }
        settings.retain(|(key, ..)| key != "title");
        settings
    }

    /// Keys of settings that have no part in a limit cycle as it is predicted, in continuous time, without
    /// noise and far from the limits.
    pub fn no_part_in_cycles(&self) -> Vec<String> {
        const KEYS: [&str; 5] =
            ["valve.K", "valve.lag", "valve.limits", "valve.rest_tolerance", "controller.limits"];
        const TABLES: [&str; 3] = ["noise", "measurement", "resolution"];
        let keys = self.settings().into_iter().map(|(key, ..)| key);
        keys.filter(|key| {
            let table = key.split('.').next().unwrap_or_default();
            KEYS.contains(&key.as_str()) || TABLES.contains(&table)
        })
        .collect()
    }
}

fn collect(
    table: &dyn toml_edit::TableLike,
    path: &str,
    into: &mut Vec<(String, String, &'static str)>,
) {
    for (key, item) in table.iter() {
        let path = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        if let Some(list) = item.as_array_of_tables() {
            for (i, table) in list.iter().enumerate() {
                collect(table, &format!("{path}.{i}"), into);
            }
        } else if let Some(table) = item.as_table_like() {
            collect(table, &path, into);
        } else if let Some(value) = item.as_value() {
            let value = value.clone().decorated("", "").to_string();
            into.push((path, value, unit(key)));
        }
    }
}

/// Unit of the setting called `key`, where it has the same in every table.
fn unit(key: &str) -> &'static str {
    match key {
        "sample_time" | "duration" | "period" | "tau" | "tau2" | "delay" | "ti" | "td" | "lag"
        | "filter" | "tracking_time" | "dwell" => "s",
        "S" | "J" | "fs" | "fd" => "% of span",
        "op" => "%",
        "rest_tolerance" => "%/s",
        _ => "",
    }
}

/// `text` with each `key=value` of `settings` put in.
fn apply(text: &str, settings: &[String]) -> Result<String> {
    let error = |setting: &str, message: String| Error::Setting {
        settings: vec![setting.to_owned()],
        message,
    };
    let mut document: toml_edit::DocumentMut = text
        .parse()
        .map_err(|e: toml_edit::TomlError| error(&settings.join(" "), e.message().to_owned()))?;
    for setting in settings {
        let (path, value) = setting.split_once('=').ok_or_else(|| {
            error(setting, "is not of the form key=value, such as valve.S=4".to_owned())
        })?;
        // A bare word is a text: no one wants to quote quotes on a command line.
        let value = value.trim();
        let value = value.parse().unwrap_or_else(|_| toml_edit::Value::from(value));
        let keys: Vec<&str> = path.trim().split('.').collect();
        put(document.as_table_mut(), &keys, value).map_err(|message| error(setting, message))?;
    }
    Ok(document.to_string())
}

/// Puts `value` at the path `keys` below `table`. A number in the path counts the tables of an
/// array, from 0.
fn put(
    table: &mut dyn toml_edit::TableLike,
    keys: &[&str],
    value: toml_edit::Value,
) -> std::result::Result<(), String> {
    let Some((first, rest)) = keys.split_first().filter(|(first, _)| !first.is_empty()) else {
        return Err("the key is incomplete; write, for instance, valve.S=4".to_owned());
    };
    if rest.is_empty() {
        let mut value = value;
        if let Some(old) = table.get(first).and_then(toml_edit::Item::as_value) {
            // With the comment behind it, which tells its unit.
            *value.decor_mut() = old.decor().clone();
        }
        table.insert(first, toml_edit::Item::Value(value));
        return Ok(());
    }
    let index = rest[0].parse::<usize>().ok();
    let item = table.entry(first).or_insert_with(|| match index {
        Some(_) => toml_edit::array(),
        None => toml_edit::table(),
    });
    // `load = [{ value = 1 }]` is as good as `[[load]]`.
    let inline = item.as_array().is_some_and(|list| list.iter().all(|v| v.is_inline_table()));
    if inline && index.is_some() {
        let list = std::mem::take(item).into_array_of_tables();
        *item = list.map_or_else(|item| item, toml_edit::Item::ArrayOfTables);
    }
    if let Some(list) = item.as_array_of_tables_mut() {
        let count = list.len();
        if index == Some(count) {
            list.push(toml_edit::Table::new());
        }
        let table = index.and_then(|index| list.get_mut(index)).ok_or_else(|| {
            format!(
                "\"{first}\" has {count} tables; count them from {first}.0, and write \
                 {first}.{count} to add one"
            )
        })?;
        return put(table, &rest[1..], value);
    }
    match item.as_table_like_mut() {
        Some(table) => put(table, rest, value),
        None => Err(format!("\"{first}\" is a value, not a table")),
    }
}

type Built<T> = std::result::Result<T, Wrong>;

/// Takes a scenario from its fields.
struct Builder<'p> {
    folder: Option<&'p Path>,
    /// Of the valve that was read.
    valve: (Model, Bands),
    notes: Vec<String>,
    /// What signals were read from.
    files: RefCell<Vec<PathBuf>>,
}

/// Time base of a scenario.
#[derive(Clone, Copy)]
struct Clock {
    sample_time: f64,
    samples: usize,
}

/// All keys of each table, whatever its kind.
mod keys {
    type Keys = &'static [&'static str];

    pub const SCENARIO: Keys = &[
        "title",
        "sample_time",
        "duration",
        "input",
        "start",
        "valve",
        "controller",
        "process",
        "operating_point",
        "resolution",
        "set_point",
        "noise",
        "measurement",
        "load",
        "master",
    ];
    pub const VALVE: Keys =
        &["model", "S", "J", "fs", "fd", "K", "rest_tolerance", "limits", "lag"];
    pub const CONTROLLER: Keys = &[
        "kc",
        "ti",
        "td",
        "kp",
        "ki",
        "kd",
        "filter",
        "set_point_weight",
        "derivative_on",
        "form",
        "handover",
        "limits",
        "anti_windup",
        "tracking_time",
    ];
    pub const PROCESS: Keys = &["type", "gain", "tau", "tau2", "num", "den", "delay", "dead_time"];
    pub const OPERATING_POINT: Keys = &["op", "pv"];
    pub const RESOLUTION: Keys = &["op", "pv"];
    pub const SIGNAL: Keys = &[
        "signal",
        "value",
        "mean",
        "amplitude",
        "period",
        "phase",
        "steps",
        "start",
        "slope",
        "from",
        "step",
        "dwell",
        "stairs",
        "sd",
        "tau",
        "seed",
        "file",
        "column",
    ];
    pub const NOISE: Keys = &["sd", "tau", "seed"];
    pub const MASTER: Keys =
        &["every", "operating_point", "set_point", "controller", "process", "noise", "measurement"];
}

/// The longest run a scenario may ask for. One of this length takes gigabytes.
const MAX_SAMPLES: f64 = 1e8;

impl Builder<'_> {
    fn scenario(&mut self, top: Fields<'_, '_>) -> Built<(String, System)> {
        let title = top.text("title")?.unwrap_or("").to_owned();
        let sample_time = top.required_number("sample_time")?;
        if !(sample_time > 0.0) {
            return Err(top.wrong("sample_time", format!("is {sample_time} s, must be above 0")));
        }
        let duration = top.required_number("duration")?;
        let samples = (duration / sample_time).round();
        if !(2.0..=MAX_SAMPLES).contains(&samples) {
            return Err(top.wrong(
                "duration",
                format!("gives {samples} samples, but must give between 2 and {MAX_SAMPLES}"),
            ));
        }
        let clock = Clock { sample_time, samples: samples as usize };
        let system = if let Some(input) = top.table("input", keys::SIGNAL)? {
            let start = top.number("start")?;
            let valve = self.valve(&top, clock)?;
            let input = self.signal(input, clock)?;
            System::OpenLoop(OpenLoop { valve, input, start, sample_time, samples: clock.samples })
        } else {
            let slave = self.closed_loop(&top, clock)?;
            match top.table("master", keys::MASTER)? {
                None => System::ClosedLoop(Box::new(slave)),
                Some(master) => System::Cascade(Box::new(self.cascade(master, slave, clock)?)),
            }
        };
        // What the core still refuses concerns several keys at once.
        let checked = match &system {
            System::OpenLoop(system) => system.input.source(sample_time, clock.samples).map(|_| ()),
            System::ClosedLoop(system) => system.check(),
            System::Cascade(system) => system.check(),
        };
        checked.map_err(|e| top.wrong_table(e))?;
        top.finish()?;
        Ok((title, system))
    }

    fn closed_loop(&mut self, top: &Fields<'_, '_>, clock: Clock) -> Built<ClosedLoop> {
        if !["controller", "process"].iter().any(|key| top.has(key)) {
            return Err(top.wrong_table(
                "simulates nothing; add [controller] and [process] for a control loop, or [input] \
                 for a valve on a test signal",
            ));
        }
        let controller = self.controller(section(top, "controller", keys::CONTROLLER)?)?;
        let (process, dead_time) = self.process(section(top, "process", keys::PROCESS)?)?;
        let mut system = ClosedLoop::new(controller, self.valve(top, clock)?, process);
        system.dead_time = dead_time;
        system.sample_time = clock.sample_time;
        system.samples = clock.samples;
        if let Some(rest) = top.table("operating_point", keys::OPERATING_POINT)? {
            system.op_rest = rest.number_or("op", 0.0)?;
            system.pv_rest = rest.number_or("pv", 0.0)?;
            rest.finish()?;
        }
        if let Some(quantum) = top.table("resolution", keys::RESOLUTION)? {
            let step = |key| match quantum.number_or(key, 0.0)? {
                step if step < 0.0 => {
                    Err(quantum.wrong(key, format!("is {step}, but must be at least 0")))
                }
                step => Ok(step),
            };
            (system.op_quantum, system.pv_quantum) = (step("op")?, step("pv")?);
            quantum.finish()?;
        }
        system.set_point = match top.table("set_point", keys::SIGNAL)? {
            Some(fields) => self.signal(fields, clock)?,
            None => system.pv_rest.into(),
        };
        system.measurement = self.measurement(top, clock)?;
        system.load = self.signals(top, "load", clock)?;
        Ok(system)
    }

    /// `[noise]` and `[[measurement]]`: what adds to a PV.
    fn measurement(&mut self, top: &Fields<'_, '_>, clock: Clock) -> Built<Vec<Signal>> {
        let mut signals = vec![];
        if let Some(fields) = top.table("noise", keys::NOISE)? {
            signals.push(noise(&fields)?);
            fields.finish()?;
        }
        signals.extend(self.signals(top, "measurement", clock)?);
        Ok(signals)
    }

    fn signals(
        &mut self,
        top: &Fields<'_, '_>,
        key: &'static str,
        clock: Clock,
    ) -> Built<Vec<Signal>> {
        top.tables(key, keys::SIGNAL)?
            .into_iter()
            .map(|fields| self.signal(fields, clock))
            .collect()
    }

    fn cascade(
        &mut self,
        master: Fields<'_, '_>,
        slave: ClosedLoop,
        clock: Clock,
    ) -> Built<Cascade> {
        let every = master.count("every")?.unwrap_or(1);
        if every == 0 {
            return Err(master.wrong("every", "is 0 samples, but must be at least 1"));
        }
        let pv_rest = master.number_or("operating_point", 0.0)?;
        let set_point = match master.table("set_point", keys::SIGNAL)? {
            Some(fields) => self.signal(fields, clock)?,
            None => pv_rest.into(),
        };
        let (process, dead_time) = self.process(section(&master, "process", keys::PROCESS)?)?;
        if dead_time != slave.dead_time {
            return Err(master.wrong("process", "dead_time must be that of the slave's process"));
        }
        let cascade = Cascade {
            slave,
            controller: self.controller(section(&master, "controller", keys::CONTROLLER)?)?,
            process,
            set_point,
            measurement: self.measurement(&master, clock)?,
            pv_rest,
            every: every as usize,
        };
        master.finish()?;
        Ok(cascade)
    }

    fn controller(&self, fields: Fields<'_, '_>) -> Built<Controller> {
        let parallel = ["kp", "ki", "kd"].iter().any(|key| fields.has(key));
        let (kc, ti) = (fields.number("kc")?, fields.number("ti")?);
        let (td, filter) = (fields.number("td")?, fields.number("filter")?);
        let gains = (fields.number("kp")?, fields.number("ki")?, fields.number("kd")?);
        let refused = |e: stiction_model::Error| fields.refused(e);
        let mut controller = if parallel {
            if kc.or(ti).or(td).is_some() {
                return Err(fields.wrong_table(
                    "give either kc, ti, td (ISA form) or kp, ki, kd (parallel form), not both",
                ));
            }
            let (kp, ki, kd) = gains;
            Controller::parallel(kp.unwrap_or(0.0), ki.unwrap_or(0.0), kd.unwrap_or(0.0))
        } else {
            let kc = kc.ok_or_else(|| fields.wrong("kc", "is missing; give the gain"))?;
            match (ti, td) {
                (None, None) => Controller::p(kc),
                (None, Some(_)) => {
                    return Err(fields.wrong("ti", "is missing, but td is given"));
                }
                (Some(ti), td) => Controller::pid(kc, ti, td.unwrap_or(0.0)),
            }
        }
        .map_err(refused)?;
        if let Some(filter) = filter {
            controller = controller.with_filter(filter).map_err(refused)?;
        }
        if let Some(weight) = fields.number("set_point_weight")? {
            controller = controller.with_set_point_weight(weight).map_err(refused)?;
        }
        let derivative_on = fields
            .choice("derivative_on", &[("pv", DerivativeOn::Pv), ("error", DerivativeOn::Error)])?;
        let form = fields
            .choice("form", &[("positional", Form::Positional), ("velocity", Form::Velocity)])?;
        let handover = fields
            .choice("handover", &[("cold", Handover::Cold), ("bumpless", Handover::Bumpless)])?;
        controller =
            controller.with_derivative_on(derivative_on).with_form(form).with_handover(handover);
        let limits = fields.numbers("limits")?;
        let tracking = fields.number("tracking_time")?;
        let anti_windup = match fields.choice(
            "anti_windup",
            &[("clamping", "clamping"), ("back-calculation", "back-calculation"), ("none", "none")],
        )? {
            "clamping" => AntiWindup::Clamping,
            "none" => AntiWindup::None,
            _ => AntiWindup::BackCalculation(tracking.ok_or_else(|| {
                fields.wrong("tracking_time", "is missing, but back-calculation needs it")
            })?),
        };
        if let Some(limits) = limits {
            let [low, high] = limits[..] else {
                return Err(fields.wrong("limits", "must be two numbers, such as [0, 100]"));
            };
            controller = controller.with_limits(low, high, anti_windup).map_err(refused)?;
        } else if fields.has("anti_windup") || fields.has("tracking_time") {
            return Err(fields.wrong("limits", "is missing; without limits nothing winds up"));
        }
        fields.finish()?;
        Ok(controller)
    }

    fn process(&self, fields: Fields<'_, '_>) -> Built<(Process, DeadTime)> {
        let kind = fields.choice(
            "type",
            &[
                ("first-order", "first-order"),
                ("second-order", "second-order"),
                ("integrator", "integrator"),
                ("transfer-function", "transfer-function"),
            ],
        )?;
        let delay = fields.number_or("delay", 0.0)?;
        let dead_time = fields
            .choice("dead_time", &[("exact", DeadTime::Exact), ("nearest", DeadTime::Nearest)])?;
        let process = match kind {
            "first-order" => {
                let (gain, tau) = (fields.required_number("gain")?, fields.required_number("tau")?);
                Process::first_order(gain, tau, delay)
            }
            "second-order" => {
                let (gain, tau) = (fields.required_number("gain")?, fields.required_number("tau")?);
                Process::second_order(gain, tau, fields.required_number("tau2")?, delay)
            }
            "integrator" => Process::integrator(fields.required_number("gain")?, delay),
            _ => {
                let list = |key| {
                    let missing = || {
                        fields.wrong(key, "is missing; list coefficients, highest power of s first")
                    };
                    fields.numbers(key)?.ok_or_else(missing)
                };
                Process::transfer_function(&list("num")?, &list("den")?, delay)
            }
        }
        .map_err(|e| fields.refused(e))?;
        fields.finish()?;
        Ok((process, dead_time))
    }

    fn valve(&mut self, top: &Fields<'_, '_>, clock: Clock) -> Built<Assembly> {
        let fields = section(top, "valve", keys::VALVE)?;
        let model = fields.text("model")?.unwrap_or("two-phase");
        let model = Model::by_name(model).map_err(|e| fields.wrong("model", e))?;
        let (s, j) = (fields.number("S")?, fields.number("J")?);
        let bands = match (s, j, fields.number("fs")?, fields.number("fd")?) {
            (None, None, Some(fs), Some(fd)) => Bands::from_fs_fd(fs, fd),
            (s, j, None, None) => model.bands(s, j),
            _ => return Err(fields.wrong_table("give either S and J, or fs and fd")),
        };
        let refused = |error| match error {
            stiction_model::Error::Missing { name, .. } => {
                fields.wrong(&name, "is missing; give percent of span")
            }
            stiction_model::Error::NotOfModel { name, role, models } => fields
                .wrong(&name.replace(' ', "_"), format!("is {role} of model \"{models}\" only")),
            error => fields.refused(error),
        };
        let limits = match fields.numbers("limits")?.as_deref() {
            None => None,
            Some(&[low, high]) => Some((low, high)),
            Some(_) => return Err(fields.wrong("limits", "must be two numbers, such as [0, 100]")),
        };
        let spec = ValveSpec {
            model,
            bands: bands.map_err(refused)?,
            overshoot: fields.number("K")?,
            rest_tolerance: fields.number("rest_tolerance")?,
            limits,
            lag_s: fields.number_or("lag", 0.0)?,
        };
        let name = model.describe().name;
        let unused = model.unused(s, j);
        self.notes
            .extend(unused.map(|key| format!("valve.{key} has no effect: {name} does not use it")));
        self.valve = (model, spec.bands);
        let valve = spec.build(Some(clock.sample_time)).map_err(refused)?;
        fields.finish()?;
        Ok(valve)
    }

    fn signal(&self, fields: Fields<'_, '_>, clock: Clock) -> Built<Signal> {
        let wave = |wave| -> Built<Signal> {
            Ok(Signal::Periodic {
                wave,
                mean: fields.number_or("mean", 0.0)?,
                amplitude: fields.required_number("amplitude")?,
                period_s: fields.required_number("period")?,
                phase: fields.number_or("phase", 0.0)?,
            })
        };
        let signal = match fields.choice("signal", SIGNALS)? {
            Kind::Constant => Signal::Constant(fields.required_number("value")?),
            Kind::Wave(shape) => wave(shape)?,
            Kind::Steps => {
                let missing = || fields.wrong("steps", "is missing; list [time, value] pairs");
                Signal::Steps(fields.pairs("steps")?.ok_or_else(missing)?)
            }
            Kind::Line => Signal::Line {
                start: fields.number_or("start", 0.0)?,
                slope_per_s: fields.required_number("slope")?,
                from_s: fields.number_or("from", 0.0)?,
            },
            Kind::Staircase => Signal::Staircase {
                start: fields.number_or("start", 0.0)?,
                step: fields.required_number("step")?,
                dwell_s: fields.required_number("dwell")?,
                steps: u32::try_from(fields.count("stairs")?.unwrap_or(10))
                    .map_err(|_| fields.wrong("stairs", "is too large"))?,
            },
            Kind::Noise => noise(&fields)?,
            Kind::RandomWalk => Signal::RandomWalk {
                sd_per_sqrt_s: fields.required_number("sd")?,
                seed: fields.count("seed")?.unwrap_or(1),
            },
            Kind::File => Signal::Samples(self.file(&fields)?),
        };
        signal.source(clock.sample_time, clock.samples).map_err(|e| fields.refused(e))?;
        fields.finish()?;
        Ok(signal)
    }

    /// The column of a CSV file, one value a sample.
    fn file(&self, fields: &Fields<'_, '_>) -> Built<Vec<f64>> {
        let path = fields.text("file")?;
        let path = path.ok_or_else(|| fields.wrong("file", "is missing; name a CSV file"))?;
        let column = fields.text("column")?;
        let column = column.ok_or_else(|| fields.wrong("column", "is missing; name a column"))?;
        let Some(folder) = self.folder else {
            return Err(fields.wrong("file", "signals can be read by scenarios in files only"));
        };
        let path = folder.join(path);
        self.files.borrow_mut().push(path.clone());
        Table::read(&path)
            .and_then(|table| table.column(column))
            .map_err(|e| fields.wrong("file", e))
    }
}

/// Kinds of signal, by the name a scenario gives them.
#[derive(Clone, Copy)]
enum Kind {
    Constant,
    Wave(Wave),
    Steps,
    Line,
    Staircase,
    Noise,
    RandomWalk,
    File,
}

const SIGNALS: &[(&str, Kind)] = &[
    ("constant", Kind::Constant),
    ("sine", Kind::Wave(Wave::Sine)),
    ("ramp", Kind::Wave(Wave::Ramp)),
    ("square", Kind::Wave(Wave::Square)),
    ("steps", Kind::Steps),
    ("line", Kind::Line),
    ("staircase", Kind::Staircase),
    ("noise", Kind::Noise),
    ("random-walk", Kind::RandomWalk),
    ("file", Kind::File),
];

/// A table that must be there.
fn section<'a, 'i>(
    top: &Fields<'a, 'i>,
    key: &'static str,
    known: &'static [&'static str],
) -> Built<Fields<'a, 'i>> {
    top.table(key, known)?.ok_or_else(|| top.wrong(key, format!("is missing; add a table [{key}]")))
}

fn noise(fields: &Fields<'_, '_>) -> Built<Signal> {
    Ok(Signal::Noise {
        sd: fields.required_number("sd")?,
        tau_s: fields.number_or("tau", 0.0)?,
        seed: fields.count("seed")?.unwrap_or(1),
    })
}
