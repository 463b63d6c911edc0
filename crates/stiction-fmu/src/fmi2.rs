//! FMI 2.0: the functions of its standard, which documents them.
//!
//! # Safety
//! An importer keeps the contract of the standard: an instance or a state is null or one that was given
//! here and has not been freed, arrays are as long as announced, texts end with 0, and there is one call
//! at a time in an instance. Whatever else it does wrong is refused and logged.
#![allow(unsafe_code, non_snake_case, missing_docs)]
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use std::ffi::{c_char, c_int, c_uint, c_void};

use crate::boundary::told;
use crate::boundary::{
    DISCARD, ERROR, Log, Logger2, boxed, call, call_or, free, free_state, get, get_state,
    instantiate, room, set, state, tell, text, values,
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
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: *mut c_void,
    _logging_on: c_int,
    count: usize,
    categories: *const *const c_char,
) -> c_int {
    // SAFETY: by the contract of an importer; so is all that is unsafe below.
    unsafe { call(c, |_| values(categories, count).map(drop)) }
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
                            "{kind} is no type of FMU; 0 is model exchange, 1 co-simulation"
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

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: *mut c_void) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.enter_initialization("fmi2EnterInitializationMode")) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: *mut c_void) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.exit_initialization("fmi2ExitInitializationMode")) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: *mut c_void) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.terminate("fmi2Terminate")) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: *mut c_void) -> c_int {
    let reset = |i: &mut Instance| {
        i.reset();
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(c, reset) }
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
    // All but 0 is true in C.
    |v: c_int| f64::from(u8::from(v != 0))
);

/// Refuses all of these variables: none is a text.
unsafe fn no_texts(c: *mut c_void, name: &str, references: *const c_uint, count: usize) -> c_int {
    let refuse = |i: &mut Instance| {
        // SAFETY: by the contract of an importer.
        match unsafe { values(references, count)? }.first() {
            Some(reference) => Err(i.foreign(name, *reference)),
            None => Ok(()),
        }
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(c, refuse) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: *mut c_void,
    references: *const c_uint,
    count: usize,
    _value: *mut *const c_char,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { no_texts(c, "fmi2GetString", references, count) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: *mut c_void,
    references: *const c_uint,
    count: usize,
    _value: *const *const c_char,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { no_texts(c, "fmi2SetString", references, count) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, place: *mut *mut c_void) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| get_state("fmi2GetFMUstate", i, place)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, from: *mut c_void) -> c_int {
    const NAME: &str = "fmi2SetFMUstate";
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.set_state(NAME, state(NAME, from)?)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: *mut c_void, place: *mut *mut c_void) -> c_int {
    let release = |_: &mut Instance| {
        // SAFETY: by the contract of an importer.
        unsafe { free_state(place) };
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(c, release) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: *mut c_void,
    from: *mut c_void,
    size: *mut usize,
) -> c_int {
    let measure = |_: &mut Instance| {
        // SAFETY: by the contract of an importer.
        unsafe { tell(size, state("fmi2SerializedFMUstateSize", from)?.serialised().len()) };
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(c, measure) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: *mut c_void,
    from: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |_| serialise("fmi2SerializeFMUstate", from, bytes, size)) }
}

/// Writes the bytes of a state to an importer's array.
///
/// # Safety
/// By the contract of an importer.
pub(crate) unsafe fn serialise(
    name: &str,
    from: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Result<()> {
    // SAFETY: by the contract of an importer.
    let (serialised, room) = unsafe { (state(name, from)?.serialised(), room(bytes, size)?) };
    if room.len() < serialised.len() {
        return Err(format!(
            "{name}: the state takes {} bytes, but there is room for {size}",
            serialised.len()
        ));
    }
    for (place, byte) in room.iter_mut().zip(serialised) {
        place.write(byte);
    }
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: *mut c_void,
    bytes: *const u8,
    size: usize,
    place: *mut *mut c_void,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| deserialise("fmi2DeSerializeFMUstate", i, bytes, size, place)) }
}

/// Makes a state of an importer's bytes.
///
/// # Safety
/// By the contract of an importer.
pub(crate) unsafe fn deserialise(
    name: &str,
    instance: &Instance,
    bytes: *const u8,
    size: usize,
    place: *mut *mut c_void,
) -> Result<()> {
    if place.is_null() {
        return Err(format!("{name}: there is no place for the state"));
    }
    // SAFETY: by the contract of an importer.
    unsafe {
        let made = instance.deserialised(name, values(bytes, size)?)?;
        free_state(place);
        tell(place, boxed(made));
    }
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: *mut c_void,
    _unknowns: *const c_uint,
    _unknown_count: usize,
    _knowns: *const c_uint,
    _known_count: usize,
    _seed: *const f64,
    _sensitivity: *mut f64,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { refuse(c, "fmi2GetDirectionalDerivative: directional derivatives are not provided") }
}

/// Refuses whatever was asked.
unsafe fn refuse(c: *mut c_void, why: &str) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |_| Err(why.to_owned())) }
}

// Model exchange.

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: *mut c_void) -> c_int {
    let from = Modes::CONTINUOUS.or(Modes::EVENT);
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.switch("fmi2EnterEventMode", from, Modes::EVENT)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: *mut c_void, info: *mut EventInfo) -> c_int {
    let update = |i: &mut Instance| {
        let passed = i.update_discrete_states("fmi2NewDiscreteStates")?;
        // Events that follow at once have passed too: one call is enough.
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

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: *mut c_void) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.switch("fmi2EnterContinuousTimeMode", Modes::EVENT, Modes::CONTINUOUS)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: *mut c_void,
    _no_set_state: c_int,
    enter_event_mode: *mut c_int,
    terminate_simulation: *mut c_int,
) -> c_int {
    let complete = |i: &mut Instance| {
        i.switch("fmi2CompletedIntegratorStep", Modes::CONTINUOUS, Modes::CONTINUOUS)?;
        // SAFETY: by the contract of an importer.
        unsafe {
            tell(enter_event_mode, 0);
            tell(terminate_simulation, 0);
        }
        Ok(())
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(c, complete) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: *mut c_void, time: f64) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.set_time("fmi2SetTime", time)) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    c: *mut c_void,
    states: *const f64,
    count: usize,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { call(c, |i| i.set_states("fmi2SetContinuousStates", values(states, count)?)) }
}

told!(fmi2GetDerivatives, rates);
told!(fmi2GetEventIndicators, indicators);
told!(fmi2GetContinuousStates, states);
told!(fmi2GetNominalsOfContinuousStates, nominals);

// Co-simulation.

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: *mut c_void,
    _references: *const c_uint,
    _count: usize,
    _order: *const c_int,
    _value: *const f64,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe {
        refuse(c, "fmi2SetRealInputDerivatives: inputs are held over a step, not interpolated")
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: *mut c_void,
    _references: *const c_uint,
    _count: usize,
    _order: *const c_int,
    _value: *mut f64,
) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { refuse(c, "fmi2GetRealOutputDerivatives: derivatives of outputs are not provided") }
}

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

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: *mut c_void) -> c_int {
    // SAFETY: by the contract of an importer.
    unsafe { refuse(c, "fmi2CancelStep: steps are not asynchronous, so there is none to cancel") }
}

/// Tells a status that is known, and discards the question otherwise.
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
