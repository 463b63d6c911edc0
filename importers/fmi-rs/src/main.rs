//! Imports every FMU of a folder with the `fmi` crate and simulates it: `importer FOLDER`.
//!
//! A file is `NAME-2.fmu` or `NAME-3.fmu`. Each is co-simulated over 1,000 steps with a sine as OP. The FMU of FMI 2.0
//! is also set up for model exchange if its description offers that. Both versions must give the same VP.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use fmi::EventFlags;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation as _, Common as _};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::{CoSimulation as _, Fmi3Model as _, GetSet as _};
use fmi::import::{from_path, peek_descr_path};
use fmi::schema::MajorVersion;
use fmi::schema::traits::FmiModelDescription;
use fmi::traits::{FmiImport, FmiInstance, FmiModelExchange};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const STEPS: usize = 1_000;
const STEP_S: f64 = 0.1;

/// Time and OP at the beginning of each step.
fn steps() -> impl Iterator<Item = (f64, f64)> {
    (0..STEPS).map(|k| k as f64 * STEP_S).map(|t| (t, 50.0 + 45.0 * (0.2 * t).sin()))
}

/// Goes through the initialisation.
fn begin(instance: &mut impl FmiInstance) -> Result<()> {
    instance.enter_initialization_mode(None, 0.0, None).map_err(|_| "initialisation is refused")?;
    instance.exit_initialization_mode().map_err(|_| "the end of initialisation is refused")?;
    Ok(())
}

fn end(instance: &mut impl FmiInstance) -> Result<()> {
    instance.terminate().map_err(|_| "the end is refused")?;
    Ok(())
}

/// VP after each step, in co-simulation by FMI 2.0.
fn two(path: &Path) -> Result<Vec<f64>> {
    let import: Fmi2Import = from_path(path)?;
    let description = import.model_description();
    let reference = |name: &str| {
        let variables = &description.model_variables.variables;
        variables.iter().find(|v| v.name == name).map(|v| v.value_reference)
    };
    let vp = reference("VP").ok_or("no VP")?;
    // The OP of a loop is computed.
    let op = if description.model_name.contains("loop") { None } else { reference("OP") };
    let mut instance = import.instantiate_cs("importer", false, true)?;
    begin(&mut instance)?;
    let mut answer = vec![];
    for (time, signal) in steps() {
        if let Some(op) = op {
            instance.set_real(&[op], &[signal])?;
        }
        instance.do_step(time, STEP_S, true)?;
        let mut value = [0.0];
        instance.get_real(&[vp], &mut value)?;
        answer.push(value[0]);
    }
    end(&mut instance)?;
    if description.model_exchange.is_some() {
        exchange(&import)?;
    }
    Ok(answer)
}

/// Sets up model exchange, and asks for all that a solver needs.
fn exchange(import: &Fmi2Import) -> Result<()> {
    let description = import.model_description();
    let mut instance = import.instantiate_me("importer", false, true)?;
    begin(&mut instance)?;
    let mut flags = EventFlags { discrete_states_need_update: true, ..EventFlags::default() };
    while flags.discrete_states_need_update {
        flags.reset();
        FmiModelExchange::update_discrete_states(&mut instance, &mut flags)?;
    }
    instance.enter_continuous_time_mode()?;
    let states = description.model_structure.derivatives.unknowns.len();
    let (mut values, mut rates) = (vec![0.0; states], vec![0.0; states]);
    instance.get_continuous_states(&mut values)?;
    instance.get_continuous_state_derivatives(&mut rates)?;
    let mut indicators = vec![0.0; description.number_of_event_indicators.unwrap_or(0) as usize];
    FmiModelExchange::get_event_indicators(&mut instance, &mut indicators)?;
    if states < 2 || !values.iter().chain(&rates).chain(&indicators).all(|v| v.is_finite()) {
        return Err(format!("states {values:?}, rates {rates:?}, indicators {indicators:?}").into());
    }
    end(&mut instance)
}

/// VP after each step, in co-simulation by FMI 3.0.
fn three(path: &Path) -> Result<Vec<f64>> {
    let import: Fmi3Import = from_path(path)?;
    let description = import.model_description();
    let reference = |name: &str| {
        description.model_variables.find_by_name(name).map(|v| v.value_reference())
    };
    let vp = reference("VP").ok_or("no VP")?;
    let op = if description.model_name.contains("loop") { None } else { reference("OP") };
    let mut instance = import.instantiate_cs("importer", false, true, false, false, &[])?;
    begin(&mut instance)?;
    let mut answer = vec![];
    for (time, signal) in steps() {
        if let Some(op) = op {
            instance.set_float64(&[op], &[signal])?;
        }
        let (mut event, mut end, mut early, mut last) = (false, false, false, 0.0);
        instance.do_step(time, STEP_S, true, &mut event, &mut end, &mut early, &mut last)?;
        let mut value = [0.0];
        instance.get_float64(&[vp], &mut value)?;
        answer.push(value[0]);
    }
    end(&mut instance)?;
    Ok(answer)
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).ok_or("which folder?")?;
    let mut answers: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let version = peek_descr_path(&path)?.major_version()?;
        let simulated = if version == MajorVersion::FMI2 { two(&path) } else { three(&path) };
        let answer = simulated.map_err(|e| format!("{name}: {e}"))?;
        let swing = answer.iter().fold(0.0, |most: f64, vp| most.max((vp - answer[0]).abs()));
        if !answer.iter().all(|vp| vp.is_finite()) || swing == 0.0 {
            return Err(format!("{name}: its VP does not move").into());
        }
        let model = name.trim_end_matches(['2', '3']).trim_end_matches('-').to_owned();
        answers.entry(model).or_default().push(answer);
    }
    for (model, answers) in &answers {
        if answers.len() != 2 || answers[0] != answers[1] {
            return Err(format!("{model}: FMI 2.0 and 3.0 do not agree").into());
        }
    }
    if answers.is_empty() {
        return Err("there is no FMU in that folder".into());
    }
    println!("{} models accepted and simulated, FMI 2.0 and 3.0 agree exactly", answers.len());
    Ok(())
}
