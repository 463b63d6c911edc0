//! A loop as an FMU, from a scenario.

use crate::Error;
use stiction_fmu::Fmu;
use stiction_io::Scenario;
use stiction_io::scenario::System;

/// Common settings of a scenario and of a loop inside an FMU: the key in the scenario, and the variable of the FMU.
const SHARED: [(&str, &str); 20] = [
    ("sample_time", "sample_time"),
    ("operating_point.op", "OP_rest"),
    ("operating_point.pv", "PV_rest"),
    ("set_point.value", "SP"),
    ("load.0.value", "load"),
    ("controller.kc", "Kc"),
    ("controller.ti", "Ti"),
    ("controller.td", "Td"),
    ("valve.S", "S"),
    ("valve.J", "J"),
    ("valve.K", "K"),
    ("valve.rest_tolerance", "rest_tolerance"),
    ("valve.lag", "stem_lag"),
    ("process.gain", "gain"),
    ("process.tau", "tau"),
    ("process.tau2", "tau2"),
    ("process.delay", "dead_time"),
    ("noise.sd", "noise_sd"),
    ("noise.tau", "noise_tau"),
    ("noise.seed", "seed"),
];

/// The loop of `scenario` with all its settings.
///
/// # Errors
/// If the scenario is not a closed loop, or has a setting that a loop inside an FMU cannot have. The message names the
/// setting.
pub fn of_scenario(scenario: &Scenario) -> Result<Fmu, Error> {
    let System::ClosedLoop(plant) = &scenario.system else {
        return Err(Error::Model(
            "only a closed loop can be exported from a scenario; for a valve alone, export the valve".to_owned(),
        ));
    };
    let (model, bands) = scenario.valve;
    let mut fmu = Fmu::new("loop", model.describe().name).map_err(Error::Model)?;
    let mut set = |name: &str, value: f64| -> Result<(), Error> {
        fmu = fmu.clone().with(name, value).map_err(Error::Model)?;
        Ok(())
    };
    // Settings that the scenario leaves out differ from those of the FMU's own loop.
    for (name, value) in [("dead_time", 0.0), ("SP", plant.pv_rest)] {
        set(name, value)?;
    }
    let settings = scenario.settings();
    if settings.iter().all(|(key, ..)| key != "controller.ti") {
        return Err(Error::Model(
            "a loop inside an FMU needs integral action; set controller.kc and controller.ti"
                .to_owned(),
        ));
    }
    set("S", bands.s())?;
    set("J", bands.j())?;
    for (key, value, _) in settings {
        if let Some((_, name)) = SHARED.iter().find(|(known, _)| *known == key) {
            let number = value.parse().map_err(|_| refused(&key, &value))?;
            set(name, number)?;
            continue;
        }
        match (key.as_str(), value.trim_matches('"')) {
            ("duration" | "valve.model" | "valve.fs" | "valve.fd", _)
            | ("process.type", "first-order" | "second-order")
            | ("process.dead_time", "exact")
            | ("set_point.signal" | "load.0.signal", "constant")
            | ("controller.form", "positional")
            | ("controller.anti_windup", "clamping")
            | ("controller.derivative_on", "pv")
            | ("controller.handover", "cold") => {}
            ("controller.handover", "bumpless") => set("bumpless", 1.0)?,
            ("resolution.op", _) => set("OP_quantum", number(&key, &value)?)?,
            ("resolution.pv", _) => set("PV_quantum", number(&key, &value)?)?,
            ("controller.limits", _) => {
                let (low, high) = pair(&key, &value)?;
                for (name, value) in [("OP_limited", 1.0), ("OP_low", low), ("OP_high", high)] {
                    set(name, value)?;
                }
            }
            ("valve.limits", _) => {
                let (low, high) = pair(&key, &value)?;
                for (name, value) in [("limited", 1.0), ("low", low), ("high", high)] {
                    set(name, value)?;
                }
            }
            _ => return Err(refused(&key, &value)),
        }
    }
    Ok(fmu)
}

fn number(key: &str, value: &str) -> Result<f64, Error> {
    value.parse().map_err(|_| refused(key, value))
}

fn pair(key: &str, value: &str) -> Result<(f64, f64), Error> {
    let inside = value.trim_matches(['[', ']']);
    let (low, high) = inside.split_once(',').ok_or_else(|| refused(key, value))?;
    Ok((number(key, low.trim())?, number(key, high.trim())?))
}

fn refused(key: &str, value: &str) -> Error {
    Error::Model(format!(
        "{key} = {value} is not possible in a loop inside an FMU, which is a positional PI or PID controller, a \
         valve and a process of first or second order. Set point and load are constants that the importer changes"
    ))
}
