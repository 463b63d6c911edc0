//! A scenario from its fields.

use super::clock::Clock;
use super::control::{controller, process};
use super::keys;
use super::signal::{Signals, noise};
use super::system::System;
use crate::fields::{Fields, Known, Wrong};
use stiction_model::Bands;
use stiction_model::closed_loop::{Cascade, ClosedLoop, Manual, OpenLoop, Signal};
use stiction_model::valve::{Assembly, Model, ValveSpec};

type Built<T> = std::result::Result<T, Wrong>;

/// Builds a scenario from its fields.
pub struct Builder<'p> {
    pub signals: Signals<'p>,
    /// The valve of the scenario.
    pub valve: (Model, Bands),
    pub notes: Vec<String>,
}

impl Builder<'_> {
    pub fn scenario(&mut self, top: Fields<'_, '_>) -> Built<(String, System)> {
        let title = top.text("title")?.unwrap_or_default();
        let clock = Clock::of(&top)?;
        let system = if let Some(input) = top.table("input", keys::SIGNAL)? {
            let start = top.number("start")?;
            let valve = self.valve(&top, clock)?;
            let input = self.signals.one(input, clock)?;
            System::OpenLoop(OpenLoop {
                valve,
                input,
                start,
                sample_time: clock.sample_time,
                samples: clock.samples,
            })
        } else {
            let slave = self.closed_loop(&top, clock)?;
            match top.table("master", keys::MASTER)? {
                None => System::ClosedLoop(Box::new(slave)),
                Some(master) => System::Cascade(Box::new(self.cascade(master, slave, clock)?)),
            }
        };
        // Remaining refusals of the core concern several keys at once.
        system.check().map_err(|e| top.wrong_table(e))?;
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
        let controller = controller(section(top, "controller", keys::CONTROLLER)?)?;
        let (process, dead_time) = process(section(top, "process", keys::PROCESS)?)?;
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
        system.set_point = self.signal(top, "set_point", system.pv_rest, clock)?;
        system.measurement = self.measurement(top, clock)?;
        system.load = self.signals.all(top, "load", clock)?;
        let spells = top.tables("manual", keys::MANUAL)?.into_iter();
        system.manual = spells.map(|fields| self.manual(fields, clock)).collect::<Built<_>>()?;
        Ok(system)
    }

    /// A spell in manual, to the end of the run by default.
    fn manual(&self, fields: Fields<'_, '_>, clock: Clock) -> Built<Manual> {
        let from_s = fields.required_number("from")?;
        let until_s = fields.number("until")?.unwrap_or(f64::INFINITY);
        let change = self.signal(&fields, "change", 0.0, clock)?;
        fields.finish()?;
        Ok(Manual { from_s, until_s, change })
    }

    /// The signal in a table, or a constant if it is not given.
    fn signal(
        &self,
        of: &Fields<'_, '_>,
        key: &'static str,
        constant: f64,
        clock: Clock,
    ) -> Built<Signal> {
        let given = of.table(key, keys::SIGNAL)?;
        given.map_or(Ok(constant.into()), |fields| self.signals.one(fields, clock))
    }

    /// `[noise]` and `[[measurement]]`, which are added to a PV.
    fn measurement(&mut self, top: &Fields<'_, '_>, clock: Clock) -> Built<Vec<Signal>> {
        let mut signals = vec![];
        if let Some(fields) = top.table("noise", keys::NOISE)? {
            signals.push(noise(&fields)?);
            fields.finish()?;
        }
        signals.extend(self.signals.all(top, "measurement", clock)?);
        Ok(signals)
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
        let set_point = self.signal(&master, "set_point", pv_rest, clock)?;
        let (process, dead_time) = process(section(&master, "process", keys::PROCESS)?)?;
        if dead_time != slave.dead_time {
            return Err(
                master.wrong("process", "dead_time must be the dead time of the slave's process")
            );
        }
        let cascade = Cascade {
            slave,
            controller: controller(section(&master, "controller", keys::CONTROLLER)?)?,
            process,
            set_point,
            measurement: self.measurement(&master, clock)?,
            pv_rest,
            every: every as usize,
        };
        master.finish()?;
        Ok(cascade)
    }

    fn valve(&mut self, top: &Fields<'_, '_>, clock: Clock) -> Built<Assembly> {
        let fields = section(top, "valve", keys::VALVE)?;
        let model = fields.text("model")?.unwrap_or_else(|| "two-phase".to_owned());
        let model = Model::by_name(&model).map_err(|e| fields.wrong("model", e))?;
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
        let spec = ValveSpec {
            model,
            bands: bands.map_err(refused)?,
            overshoot: fields.number("K")?,
            rest_tolerance: fields.number("rest_tolerance")?,
            limits: fields.two("limits")?,
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
}

/// A table that is required.
fn section<'a, 'i>(top: &Fields<'a, 'i>, key: &'static str, known: Known) -> Built<Fields<'a, 'i>> {
    top.table(key, known)?.ok_or_else(|| top.wrong(key, format!("is missing; add a table [{key}]")))
}
