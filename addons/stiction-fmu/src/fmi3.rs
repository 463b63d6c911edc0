//! Functions of the FMI 3.0 standard, which documents them. Co-simulation and model exchange; everything else is
//! refused.
//!
//! # Safety
//! As for [`fmi2`](crate::fmi2).
#![allow(unsafe_code, non_snake_case, missing_docs)]
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

use crate::boundary::{
    ERROR, Log, Logger3, call, call_or, calls, deserialise, free, free_state, get, get_state,
    instantiate, none_of_type, refused, serialise, set, state, tell, text, told, values,
};
use crate::instance::{Instance, Modes, Result};
use crate::resources;
use crate::variables::VariableKind;

/// `fmi3Boolean`, a `bool` of C: received as a byte, because not every byte is a valid one.
type Boolean = u8;
const FALSE: Boolean = 0;

#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// `fmi3LogMessageCallback`, or null.
pub type LogMessage =
    Option<unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char)>;

/// Refuses to make an instance, with the reason.
fn not_made(environment: *mut c_void, log: LogMessage, why: &str) -> *mut c_void {
    Log::V3(log, environment).error(why);
    std::ptr::null_mut()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: *const c_char,
    token: *const c_char,
    resource_path: *const c_char,
    _visible: Boolean,
    _logging_on: Boolean,
    environment: *mut c_void,
    log: LogMessage,
) -> *mut c_void {
    // SAFETY: by the contract of an importer.
    unsafe { made(name, token, resource_path, environment, log, true, || Ok(())) }
}

/// An instance, unless `checked` refuses it.
unsafe fn made(
    name: *const c_char,
    token: *const c_char,
    resource_path: *const c_char,
    environment: *mut c_void,
    log: LogMessage,
    exchange: bool,
    checked: impl Fn() -> Result<()>,
) -> *mut c_void {
    let logger: Option<Logger3> = log;
    // SAFETY: by the contract of an importer.
    unsafe {
        instantiate(
            name,
            |_| Log::V3(logger, environment),
            || {
                let token = text(token, "the instantiation token")?;
                let path = text(resource_path, "the path of the resources")?;
                checked()?;
                Instance::new(resources::read(Path::new(path))?, token, exchange)
            },
        )
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: Boolean,
    _logging_on: Boolean,
    environment: *mut c_void,
    log: LogMessage,
    _clock_update: *mut c_void,
    _lock: *mut c_void,
    _unlock: *mut c_void,
) -> *mut c_void {
    not_made(
        environment,
        log,
        "only co-simulation and model exchange are supported, not scheduled execution",
    )
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    name: *const c_char,
    token: *const c_char,
    resource_path: *const c_char,
    _visible: Boolean,
    _logging_on: Boolean,
    event_mode_used: Boolean,
    _early_return_allowed: Boolean,
    _intermediate: *const u32,
    intermediate_count: usize,
    environment: *mut c_void,
    log: LogMessage,
    _intermediate_update: *mut c_void,
) -> *mut c_void {
    let checked = || {
        if event_mode_used != FALSE {
            return Err("co-simulation has no event mode".to_owned());
        }
        if intermediate_count > 0 {
            return Err("a step has no intermediate values".to_owned());
        }
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { made(name, token, resource_path, environment, log, false, checked) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    // SAFETY: by the contract of an importer.
    unsafe { free(instance) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _tolerance_defined: Boolean,
    _tolerance: f64,
    start: f64,
    stop_defined: Boolean,
    stop: f64,
) -> c_int {
    const NAME: &str = "fmi3EnterInitializationMode";
    let stop = (stop_defined != FALSE).then_some(stop);
    let enter = |i: &mut Instance| {
        i.set_up(NAME, start, stop)?;
        i.enter_initialization(NAME)
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(instance, enter) }
}

calls! {
    fmi3SetDebugLogging(_logging_on: Boolean, count: usize, categories: *const *const c_char) |_, _| {
        values(categories, count).map(drop)
    };
    fmi3ExitInitializationMode() |i, name| i.exit_initialization(name);
    fmi3Terminate() |i, name| i.terminate(name);
    fmi3Reset() |i, _| {
        i.reset();
        Ok(())
    };
}

/// Refuses arrays of unequal lengths: each variable has one value.
#[cold]
unsafe fn unequal(instance: *mut c_void, name: &str, references: usize, values: usize) -> c_int {
    let why =
        format!("{name}: {values} values for {references} variables, but each variable has one");
    // SAFETY: by the contract of an importer.
    unsafe { call(instance, |_| Err(why)) }
}

/// Defines the functions that get and set variables of one type.
macro_rules! typed {
    ($get:ident, $set:ident, $kind:expr, $type:ty, $to:expr, $from:expr) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: *mut c_void,
            references: *const u32,
            reference_count: usize,
            value: *mut $type,
            count: usize,
        ) -> c_int {
            // SAFETY: by the contract of an importer.
            if reference_count != count {
                return unsafe { unequal(instance, stringify!($get), reference_count, count) };
            }
            // SAFETY: by the contract of an importer.
            unsafe { get(instance, stringify!($get), $kind, references, count, value, $to) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: *mut c_void,
            references: *const u32,
            reference_count: usize,
            value: *const $type,
            count: usize,
        ) -> c_int {
            // SAFETY: by the contract of an importer.
            if reference_count != count {
                return unsafe { unequal(instance, stringify!($set), reference_count, count) };
            }
            // SAFETY: by the contract of an importer.
            unsafe { set(instance, stringify!($set), $kind, references, count, value, $from) }
        }
    };
}

typed!(fmi3GetFloat64, fmi3SetFloat64, VariableKind::Float64, f64, |v: f64| v, |v: f64| v);
typed!(fmi3GetInt32, fmi3SetInt32, VariableKind::Int32, i32, |v: f64| v as i32, f64::from);
typed!(
    fmi3GetBoolean,
    fmi3SetBoolean,
    VariableKind::Boolean,
    Boolean,
    |v: f64| v as Boolean,
    |v: Boolean| f64::from(u8::from(v != FALSE))
);

none_of_type! {
    fmi3GetFloat32(_v: *mut f32, _n: usize);
    fmi3GetInt8(_v: *mut i8, _n: usize);
    fmi3GetUInt8(_v: *mut u8, _n: usize);
    fmi3GetInt16(_v: *mut i16, _n: usize);
    fmi3GetUInt16(_v: *mut u16, _n: usize);
    fmi3GetUInt32(_v: *mut u32, _n: usize);
    fmi3GetInt64(_v: *mut i64, _n: usize);
    fmi3GetUInt64(_v: *mut u64, _n: usize);
    fmi3GetString(_v: *mut *const c_char, _n: usize);
    fmi3GetBinary(_sizes: *mut usize, _v: *mut *const u8, _n: usize);
    fmi3GetClock(_v: *mut Boolean);
    fmi3SetFloat32(_v: *const f32, _n: usize);
    fmi3SetInt8(_v: *const i8, _n: usize);
    fmi3SetUInt8(_v: *const u8, _n: usize);
    fmi3SetInt16(_v: *const i16, _n: usize);
    fmi3SetUInt16(_v: *const u16, _n: usize);
    fmi3SetUInt32(_v: *const u32, _n: usize);
    fmi3SetInt64(_v: *const i64, _n: usize);
    fmi3SetUInt64(_v: *const u64, _n: usize);
    fmi3SetString(_v: *const *const c_char, _n: usize);
    fmi3SetBinary(_sizes: *const usize, _v: *const *const u8, _n: usize);
    fmi3SetClock(_v: *const Boolean);
    fmi3GetIntervalDecimal(_v: *mut f64, _q: *mut c_int);
    fmi3GetIntervalFraction(_counters: *mut u64, _resolutions: *mut u64, _q: *mut c_int);
    fmi3GetShiftDecimal(_v: *mut f64);
    fmi3GetShiftFraction(_counters: *mut u64, _resolutions: *mut u64);
    fmi3SetIntervalDecimal(_v: *const f64);
    fmi3SetIntervalFraction(_counters: *const u64, _resolutions: *const u64);
    fmi3SetShiftDecimal(_v: *const f64);
    fmi3SetShiftFraction(_counters: *const u64, _resolutions: *const u64);
    fmi3GetOutputDerivatives(_orders: *const i32, _v: *mut f64, _n: usize);
}

calls! {
    fmi3GetFMUState(place: *mut *mut c_void) |i, name| get_state(name, i, place);
    fmi3SetFMUState(from: *mut c_void) |i, name| i.set_state(name, state(name, from)?);
    fmi3FreeFMUState(place: *mut *mut c_void) |_, _| {
        free_state(place);
        Ok(())
    };
    fmi3SerializedFMUStateSize(from: *mut c_void, size: *mut usize) |_, name| {
        tell(size, state(name, from)?.serialised().len());
        Ok(())
    };
    fmi3SerializeFMUState(from: *mut c_void, bytes: *mut u8, size: usize) |_, name| {
        serialise(name, from, bytes, size)
    };
    fmi3DeserializeFMUState(bytes: *const u8, size: usize, place: *mut *mut c_void) |i, name| {
        deserialise(name, i, bytes, size, place)
    };
}

refused! {
    fmi3GetNumberOfVariableDependencies(_of: u32, _n: *mut usize):
        "dependencies are in the description, not available at run time";
    fmi3GetVariableDependencies(
        _of: u32,
        _elements: *mut usize,
        _on: *mut u32,
        _on_elements: *mut usize,
        _kinds: *mut c_int,
        _n: usize
    ): "dependencies are in the description, not available at run time";
    fmi3GetDirectionalDerivative(
        _unknowns: *const u32,
        _n_unknowns: usize,
        _knowns: *const u32,
        _n_knowns: usize,
        _seed: *const f64,
        _n_seed: usize,
        _sensitivity: *mut f64,
        _n_sensitivity: usize
    ): "directional derivatives are not provided";
    fmi3GetAdjointDerivative(
        _unknowns: *const u32,
        _n_unknowns: usize,
        _knowns: *const u32,
        _n_knowns: usize,
        _seed: *const f64,
        _n_seed: usize,
        _sensitivity: *mut f64,
        _n_sensitivity: usize
    ): "adjoint derivatives are not provided";
    fmi3EnterConfigurationMode(): "there are no structural parameters to configure";
    fmi3ExitConfigurationMode(): "there are no structural parameters to configure";
    fmi3EnterStepMode(): "co-simulation has no event mode to leave";
    fmi3ActivateModelPartition(_clock: u32, _time: f64): "scheduled execution is not supported";
}

// Model exchange.

calls! {
    fmi3EnterEventMode() |i, name| i.switch(name, Modes::CONTINUOUS.or(Modes::EVENT), Modes::EVENT);
    // Discrete variables depend on inputs only through events, so there is nothing to evaluate before these.
    fmi3EvaluateDiscreteStates() |i, name| i.switch(name, Modes::EVENT, Modes::EVENT);
    fmi3EnterContinuousTimeMode() |i, name| i.switch(name, Modes::EVENT, Modes::CONTINUOUS);
    fmi3CompletedIntegratorStep(
        _no_set_state: Boolean,
        enter_event_mode: *mut Boolean,
        terminate_simulation: *mut Boolean
    ) |i, name| {
        i.switch(name, Modes::CONTINUOUS, Modes::CONTINUOUS)?;
        tell(enter_event_mode, FALSE);
        tell(terminate_simulation, FALSE);
        Ok(())
    };
    fmi3SetTime(time: f64) |i, name| i.set_time(name, time);
    fmi3SetContinuousStates(states: *const f64, count: usize) |i, name| {
        i.set_states(name, values(states, count)?)
    };
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: *mut c_void,
    needed: *mut Boolean,
    terminate_simulation: *mut Boolean,
    nominals_changed: *mut Boolean,
    values_changed: *mut Boolean,
    next_event_time_defined: *mut Boolean,
    next_event_time: *mut f64,
) -> c_int {
    let update = |i: &mut Instance| {
        let passed = i.update_discrete_states("fmi3UpdateDiscreteStates")?;
        // SAFETY: by the contract of an importer.
        unsafe {
            // Immediately following events have passed too: one call is enough.
            tell(needed, FALSE);
            tell(terminate_simulation, FALSE);
            tell(nominals_changed, FALSE);
            tell(values_changed, Boolean::from(passed));
            tell(next_event_time_defined, FALSE);
            tell(next_event_time, 0.0);
        }
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(instance, update) }
}

told!(fmi3GetContinuousStateDerivatives, rates);
told!(fmi3GetEventIndicators, indicators);
told!(fmi3GetContinuousStates, states);
told!(fmi3GetNominalsOfContinuousStates, nominals);

calls! {
    fmi3GetNumberOfEventIndicators(count: *mut usize) |i, name| {
        tell(count, i.count_indicators(name)?);
        Ok(())
    };
    fmi3GetNumberOfContinuousStates(count: *mut usize) |i, name| {
        tell(count, i.count_states(name)?);
        Ok(())
    };
}

// Co-simulation.

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    time: f64,
    step: f64,
    _no_set_state: Boolean,
    event_handling_needed: *mut Boolean,
    terminate_simulation: *mut Boolean,
    early_return: *mut Boolean,
    last_successful_time: *mut f64,
) -> c_int {
    let go = |i: &mut Instance| {
        let done = i.do_step("fmi3DoStep", time, step);
        // SAFETY: by the contract of an importer.
        unsafe {
            tell(event_handling_needed, FALSE);
            tell(terminate_simulation, FALSE);
            tell(early_return, FALSE);
            tell(last_successful_time, i.time());
        }
        done
    };
    // SAFETY: by the contract of an importer.
    unsafe { call_or(instance, ERROR, go) }
}
