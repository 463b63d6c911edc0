//! Functions of the FMI 2.0 standard, which documents them.
//!
//! # Safety
//! An importer keeps the contract of the standard: an instance or a state is null or one from here that has not
//! been freed, arrays have the announced length, texts end with 0, and there is one call at a time in an instance.
//! All other wrong use is refused and logged.
#![allow(unsafe_code, non_snake_case, missing_docs)]
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use std::ffi::{c_char, c_int, c_uint, c_void};

use crate::boundary::{
    DISCARD, ERROR, Log, Logger2, call, call_or, calls, deserialise, free, free_state, get,
    get_state, instantiate, none_of_type, refused, serialise, set, state, tell, text, told, values,
};
use crate::instance::{Instance, Modes, Result};
use crate::resources;
use crate::variables::VariableKind;

/// `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Debug)]
pub struct CallbackFunctions {
    /// `fmi2CallbackLogger`, or null.
    pub logger: Option<
        unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...),
    >,
    /// Not used.
    pub allocate_memory: *mut c_void,
    /// Not used.
    pub free_memory: *mut c_void,
    /// Not used: a step is finished when it returns.
    pub step_finished: *mut c_void,
    /// The first argument of the logger.
    pub environment: *mut c_void,
}

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Debug)]
pub struct EventInfo {
    pub new_discrete_states_needed: c_int,
    pub terminate_simulation: c_int,
    pub nominals_of_continuous_states_changed: c_int,
    pub values_of_continuous_states_changed: c_int,
    pub next_event_time_defined: c_int,
    pub next_event_time: f64,
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    location: *const c_char,
    functions: *const CallbackFunctions,
    _visible: c_int,
    _logging_on: c_int,
) -> *mut c_void {
    // SAFETY: by the contract of an importer.
    unsafe {
        let (logger, environment): (Option<Logger2>, _) =
            functions.as_ref().map_or((None, std::ptr::null_mut()), |f| (f.logger, f.environment));
        instantiate(
            name,
            |name| Log::V2(logger, environment, name),
            || {
                let token = text(guid, "the GUID")?;
                let uri = text(location, "the location of the resources")?;
                let exchange = match kind {
                    0 => true,
                    1 => false,
                    _ => {
                        return Err(format!(
                            "{kind} is not a type of FMU; 0 is model exchange, 1 co-simulation"
                        ));
                    }
                };
                Instance::new(resources::read(&resources::directory(uri)?)?, token, exchange)
            },
        )
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
    // SAFETY: by the contract of an importer.
    unsafe { free(c) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: *mut c_void,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    stop_defined: c_int,
    stop: f64,
) -> c_int {
    let stop = (stop_defined != 0).then_some(stop);
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.set_up("fmi2SetupExperiment", start, stop)) }
}

calls! {
    fmi2SetDebugLogging(_logging_on: c_int, count: usize, categories: *const *const c_char) |_, _| {
        values(categories, count).map(drop)
    };
    fmi2EnterInitializationMode() |i, name| i.enter_initialization(name);
    fmi2ExitInitializationMode() |i, name| i.exit_initialization(name);
    fmi2Terminate() |i, name| i.terminate(name);
    fmi2Reset() |i, _| {
        i.reset();
        Ok(())
    };
}

/// Defines the functions that get and set variables of one type.
macro_rules! typed {
    ($get:ident, $set:ident, $kind:expr, $type:ty, $to:expr, $from:expr) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            c: *mut c_void,
            references: *const c_uint,
            count: usize,
            value: *mut $type,
        ) -> c_int {
            // SAFETY: by the contract of an importer.
            unsafe { get(c, stringify!($get), $kind, references, count, value, $to) }
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            c: *mut c_void,
            references: *const c_uint,
            count: usize,
            value: *const $type,
        ) -> c_int {
            // SAFETY: by the contract of an importer.
            unsafe { set(c, stringify!($set), $kind, references, count, value, $from) }
        }
    };
}

typed!(fmi2GetReal, fmi2SetReal, VariableKind::Float64, f64, |v: f64| v, |v: f64| v);
typed!(fmi2GetInteger, fmi2SetInteger, VariableKind::Int32, c_int, |v: f64| v as c_int, f64::from);
typed!(
    fmi2GetBoolean,
    fmi2SetBoolean,
    VariableKind::Boolean,
    c_int,
    |v: f64| v as c_int,
    // In C everything except 0 is true.
    |v: c_int| f64::from(u8::from(v != 0))
);

none_of_type! {
    fmi2GetString(_v: *mut *const c_char);
    fmi2SetString(_v: *const *const c_char);
}

calls! {
    fmi2GetFMUstate(place: *mut *mut c_void) |i, name| get_state(name, i, place);
    fmi2SetFMUstate(from: *mut c_void) |i, name| i.set_state(name, state(name, from)?);
    fmi2FreeFMUstate(place: *mut *mut c_void) |_, _| {
        free_state(place);
        Ok(())
    };
    fmi2SerializedFMUstateSize(from: *mut c_void, size: *mut usize) |_, name| {
        tell(size, state(name, from)?.serialised().len());
        Ok(())
    };
    fmi2SerializeFMUstate(from: *mut c_void, bytes: *mut u8, size: usize) |_, name| {
        serialise(name, from, bytes, size)
    };
    fmi2DeSerializeFMUstate(bytes: *const u8, size: usize, place: *mut *mut c_void) |i, name| {
        deserialise(name, i, bytes, size, place)
    };
}

refused! {
    fmi2GetDirectionalDerivative(
        _unknowns: *const c_uint,
        _unknown_count: usize,
        _knowns: *const c_uint,
        _known_count: usize,
        _seed: *const f64,
        _sensitivity: *mut f64
    ): "directional derivatives are not provided";
    fmi2SetRealInputDerivatives(
        _references: *const c_uint,
        _count: usize,
        _order: *const c_int,
        _value: *const f64
    ): "inputs are held over a step, not interpolated";
    fmi2GetRealOutputDerivatives(
        _references: *const c_uint,
        _count: usize,
        _order: *const c_int,
        _value: *mut f64
    ): "derivatives of outputs are not provided";
    fmi2CancelStep(): "steps are not asynchronous, so there is no step to cancel";
}

// Model exchange.

calls! {
    fmi2EnterEventMode() |i, name| i.switch(name, Modes::CONTINUOUS.or(Modes::EVENT), Modes::EVENT);
    fmi2EnterContinuousTimeMode() |i, name| i.switch(name, Modes::EVENT, Modes::CONTINUOUS);
    fmi2CompletedIntegratorStep(
        _no_set_state: c_int,
        enter_event_mode: *mut c_int,
        terminate_simulation: *mut c_int
    ) |i, name| {
        i.switch(name, Modes::CONTINUOUS, Modes::CONTINUOUS)?;
        tell(enter_event_mode, 0);
        tell(terminate_simulation, 0);
        Ok(())
    };
    fmi2SetTime(time: f64) |i, name| i.set_time(name, time);
    fmi2SetContinuousStates(states: *const f64, count: usize) |i, name| {
        i.set_states(name, values(states, count)?)
    };
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: *mut c_void, info: *mut EventInfo) -> c_int {
    let update = |i: &mut Instance| {
        let passed = i.update_discrete_states("fmi2NewDiscreteStates")?;
        // Immediately following events have passed too: one call is enough.
        let info_now = EventInfo {
            new_discrete_states_needed: 0,
            terminate_simulation: 0,
            nominals_of_continuous_states_changed: 0,
            values_of_continuous_states_changed: c_int::from(passed),
            next_event_time_defined: 0,
            next_event_time: 0.0,
        };
        // SAFETY: by the contract of an importer.
        unsafe { tell(info, info_now) };
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(c, update) }
}

told!(fmi2GetDerivatives, rates);
told!(fmi2GetEventIndicators, indicators);
told!(fmi2GetContinuousStates, states);
told!(fmi2GetNominalsOfContinuousStates, nominals);

// Co-simulation.

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: *mut c_void,
    time: f64,
    step: f64,
    _no_set_state: c_int,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call_or(c, ERROR, |i| i.do_step("fmi2DoStep", time, step)) }
}

/// Returns a known status, and discards the call otherwise.
unsafe fn status<T>(
    c: *mut c_void,
    name: &str,
    value: *mut T,
    known: impl Fn(&Instance) -> Option<T>,
) -> c_int {
    let answer = |i: &mut Instance| -> Result<()> {
        i.permit_exchange(name, false)?;
        let status = known(i)
            .ok_or_else(|| format!("{name}: this status exists for asynchronous steps only"))?;
        // SAFETY: by the contract of an importer.
        unsafe { tell(value, status) };
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { call_or(c, DISCARD, answer) }
}

/// `fmi2LastSuccessfulTime` and `fmi2Terminated`.
const LAST_TIME: c_int = 2;
const TERMINATED: c_int = 3;

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: *mut c_void, _of: c_int, value: *mut c_int) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { status(c, "fmi2GetStatus", value, |_| None) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: *mut c_void, of: c_int, value: *mut f64) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { status(c, "fmi2GetRealStatus", value, |i| (of == LAST_TIME).then(|| i.time())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: *mut c_void,
    _of: c_int,
    value: *mut c_int,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { status(c, "fmi2GetIntegerStatus", value, |_| None) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: *mut c_void,
    of: c_int,
    value: *mut c_int,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { status(c, "fmi2GetBooleanStatus", value, |_| (of == TERMINATED).then_some(0)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: *mut c_void,
    _of: c_int,
    value: *mut *const c_char,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { status(c, "fmi2GetStringStatus", value, |_| None) }
}
