//! The boundary to C: pointers become slices, panics and refusals become a status and a log entry.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::NonNull;

use crate::instance::{Instance, Result, State};
use crate::variables::VariableKind;

/// `OK`, in either version.
pub(crate) const OK: c_int = 0;
/// `Discard`, in either version.
pub(crate) const DISCARD: c_int = 2;
/// `Error`, in either version.
pub(crate) const ERROR: c_int = 3;

/// Larger than any array of an importer.
const MOST: usize = 1 << 24;

/// `fmi2CallbackLogger`.
pub(crate) type Logger2 =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);
/// `fmi3LogMessageCallback`.
pub(crate) type Logger3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// The importer's logger.
#[derive(Clone, Copy)]
pub(crate) enum Log {
    V2(Option<Logger2>, *mut c_void, *const c_char),
    V3(Option<Logger3>, *mut c_void),
}

impl Log {
    /// Reports an error to the importer.
    pub(crate) fn error(self, message: &str) {
        let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
        let (category, format) = (c"logStatusError".as_ptr(), c"%s".as_ptr());
        // SAFETY: the importer gave these functions for this purpose. All texts end with 0 and outlive the call;
        // the name belongs to the importer's call or to the instance.
        unsafe {
            match self {
                Self::V2(Some(logger), environment, name) => {
                    logger(environment, name, ERROR, category, format, message.as_ptr());
                }
                Self::V3(Some(logger), environment) => {
                    logger(environment, ERROR, category, message.as_ptr());
                }
                _ => {}
            }
        }
    }
}

/// Target of an importer's pointer to an instance.
#[repr(C)]
struct Handle {
    instance: Instance,
    log: Log,
    /// Name in `log`.
    _name: CString,
}

/// Makes an instance, or logs the reason and returns null.
///
/// # Safety
/// `name` is null or a text, `log` is from the importer's same call.
pub(crate) unsafe fn instantiate(
    name: *const c_char,
    log: impl Fn(*const c_char) -> Log,
    make: impl FnOnce() -> Result<Instance>,
) -> *mut c_void {
    let given = if name.is_null() { c"".as_ptr() } else { name };
    let made = catch_unwind(AssertUnwindSafe(make))
        .unwrap_or_else(|_| Err("a defect of the library stopped the instantiation".to_owned()));
    match made {
        Ok(instance) => {
            // SAFETY: it is not null, and a text by the contract of this function.
            let name = unsafe { CStr::from_ptr(given) }.to_owned();
            let log = log(name.as_ptr());
            Box::into_raw(Box::new(Handle { log, _name: name, instance })).cast()
        }
        Err(why) => {
            log(given).error(&why);
            std::ptr::null_mut()
        }
    }
}

/// Frees the result of [`instantiate`]; null is ignored.
///
/// # Safety
/// `instance` is null or comes from [`instantiate`] and has not been freed.
pub(crate) unsafe fn free(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: by the contract of this function it is a box of this type that nobody else has.
        let handle = unsafe { Box::from_raw(instance.cast::<Handle>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(handle)));
    }
}

/// The valid content of an importer's pointer to an instance.
#[inline(always)]
fn handle(instance: *mut c_void) -> Option<NonNull<Handle>> {
    NonNull::new(instance.cast::<Handle>()).filter(|handle| handle.is_aligned())
}

/// Does `work` with an instance. A refusal is logged and becomes an error; a panic ends the instance.
///
/// # Safety
/// `instance` is null or comes from [`instantiate`] and has not been freed. No other call uses it at the same time.
#[inline]
pub(crate) unsafe fn call(
    instance: *mut c_void,
    work: impl FnOnce(&mut Instance) -> Result<()>,
) -> c_int {
    // SAFETY: the same contract.
    unsafe { call_or(instance, ERROR, work) }
}

/// As [`call`], with a different status for a refusal, or a different type for its message.
///
/// # Safety
/// As for [`call`].
#[inline]
pub(crate) unsafe fn call_or<E: ToString>(
    instance: *mut c_void,
    refusal: c_int,
    work: impl FnOnce(&mut Instance) -> std::result::Result<(), E>,
) -> c_int {
    let Some(handle) = handle(instance) else { return ERROR };
    let handle = handle.as_ptr();
    // SAFETY: by the contract it points to a handle, and nobody else uses it during the call. The reference ends
    // before the importer's logger is called, which may call us again.
    let done = catch_unwind(AssertUnwindSafe(|| work(unsafe { &mut (*handle).instance })));
    match done {
        Ok(Ok(())) => return OK,
        // SAFETY: as above.
        Ok(Err(why)) => unsafe { log_refusal(handle, why) },
        Err(_) => unsafe { broken(handle) },
    }
    refusal
}

/// Logs why a call was refused.
///
/// # Safety
/// As for [`call`].
#[cold]
#[inline(never)]
unsafe fn log_refusal(handle: *mut Handle, why: impl ToString) {
    // SAFETY: by the contract; the log is copied.
    let log = unsafe { (*handle).log };
    log.error(&why.to_string());
}

/// Ends an instance after a panic in a call.
///
/// # Safety
/// As for [`call`].
#[cold]
#[inline(never)]
unsafe fn broken(handle: *mut Handle) {
    let why = "a defect of the library stopped this call; the instance can only be reset or freed";
    // SAFETY: by the contract.
    unsafe {
        (*handle).instance.fail();
        log_refusal(handle, why);
    }
}

/// Writes the values of variables of one kind to an importer; a single available number without delay.
///
/// # Safety
/// As for [`call`], [`values`] and [`room`].
#[inline(always)]
pub(crate) unsafe fn get<T>(
    instance: *mut c_void,
    name: &str,
    kind: VariableKind,
    references: *const u32,
    count: usize,
    value: *mut T,
    to: impl Fn(f64) -> T,
) -> c_int {
    #[inline(never)]
    unsafe fn several<T>(
        instance: *mut c_void,
        name: &str,
        kind: VariableKind,
        references: *const u32,
        count: usize,
        value: *mut T,
        to: impl Fn(f64) -> T,
    ) -> c_int {
        let get = |i: &mut Instance| {
            // SAFETY: by the contract.
            let (references, room) = unsafe { (values(references, count)?, room(value, count)?) };
            i.get(name, kind, references, |k, value| {
                room[k].write(to(value));
            })
        };
        // SAFETY: by the contract.
        unsafe { call(instance, get) }
    }
    // SAFETY: by the contract.
    unsafe {
        if count == 1
            && !references.is_null()
            && !value.is_null()
            && kind == VariableKind::Float64
            && let Some(handle) = handle(instance)
            && let Some(one) = handle.as_ref().instance.number(references.read_unaligned())
        {
            value.write_unaligned(to(one));
            return OK;
        }
        several(instance, name, kind, references, count, value, to)
    }
}

/// Reads the values of variables of one kind from an importer; a single number for the next step without delay.
///
/// # Safety
/// As for [`call`] and [`values`].
#[inline(always)]
pub(crate) unsafe fn set<T: Copy>(
    instance: *mut c_void,
    name: &str,
    kind: VariableKind,
    references: *const u32,
    count: usize,
    value: *const T,
    from: impl Fn(T) -> f64,
) -> c_int {
    #[inline(never)]
    unsafe fn several<T: Copy>(
        instance: *mut c_void,
        name: &str,
        kind: VariableKind,
        references: *const u32,
        count: usize,
        value: *const T,
        from: impl Fn(T) -> f64,
    ) -> c_int {
        let set = |i: &mut Instance| {
            // SAFETY: by the contract.
            let (references, value) =
                unsafe { (values(references, count)?, values(value, count)?) };
            i.set(name, kind, references, |k| from(value[k]))
        };
        // SAFETY: by the contract.
        unsafe { call(instance, set) }
    }
    // SAFETY: by the contract.
    unsafe {
        if count == 1
            && !references.is_null()
            && !value.is_null()
            && kind == VariableKind::Float64
            && let Some(mut handle) = handle(instance)
            && handle
                .as_mut()
                .instance
                .hold(references.read_unaligned(), from(value.read_unaligned()))
        {
            return OK;
        }
        several(instance, name, kind, references, count, value, from)
    }
}

/// The content of an importer's array.
///
/// # Safety
/// If `count` is not 0 and `array` not null, it contains this many values during `'a`.
#[inline]
pub(crate) unsafe fn values<'a, T>(array: *const T, count: usize) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    if array.is_null() || !array.is_aligned() || count > MOST {
        return Err(none("an array of", count));
    }
    // SAFETY: not null, aligned, and as long as the contract requires.
    Ok(unsafe { std::slice::from_raw_parts(array, count) })
}

#[cold]
fn none(what: &str, count: usize) -> String {
    format!("{what} {count} values was announced, but is null, misaligned or too long")
}

/// An importer's array to fill; its content is not read.
///
/// # Safety
/// If `count` is not 0 and `array` not null, there is room for this many values during `'a`, which nobody else
/// uses.
#[inline]
pub(crate) unsafe fn room<'a, T>(array: *mut T, count: usize) -> Result<&'a mut [MaybeUninit<T>]> {
    if count == 0 {
        return Ok(&mut []);
    }
    if array.is_null() || !array.is_aligned() || count > MOST {
        return Err(none("room for", count));
    }
    // SAFETY: not null, aligned, and as long as the contract requires; its content is not read.
    Ok(unsafe { std::slice::from_raw_parts_mut(array.cast(), count) })
}

/// Writes one value for an importer, if the importer passed an address for it.
///
/// # Safety
/// `place` is null or points to room for the value.
#[inline]
pub(crate) unsafe fn tell<T>(place: *mut T, value: T) {
    if !place.is_null() && place.is_aligned() {
        // SAFETY: not null, aligned, and room for it by the contract.
        unsafe { place.write(value) }
    }
}

/// An importer's text.
///
/// # Safety
/// `text` is null or ends with 0.
pub(crate) unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str> {
    if text.is_null() {
        return Err(format!("{what} is missing"));
    }
    // SAFETY: not null, and ended by the contract.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| format!("{what} is not in UTF-8"))
}

/// Copies the state of an instance to `place`: into the existing state, or a new one for null.
///
/// # Safety
/// `place` is null or points to null or to a state from here that has not been freed.
pub(crate) unsafe fn get_state(
    call: &str,
    instance: &Instance,
    place: *mut *mut c_void,
) -> Result<()> {
    if place.is_null() || !place.is_aligned() {
        return Err(format!("{call}: no room for the state was given"));
    }
    // SAFETY: by the contract.
    unsafe {
        match (*place).cast::<State>().as_mut() {
            Some(state) => *state = instance.state(),
            None => *place = boxed(instance.state()),
        }
    }
    Ok(())
}

/// A state in the hands of an importer.
pub(crate) fn boxed(state: State) -> *mut c_void {
    Box::into_raw(Box::new(state)).cast()
}

/// The importer's state.
///
/// # Safety
/// `state` is null or a state from here that has not been freed during `'a`.
pub(crate) unsafe fn state<'a>(call: &str, state: *mut c_void) -> Result<&'a State> {
    // SAFETY: by the contract.
    unsafe { state.cast::<State>().as_ref() }.ok_or_else(|| format!("{call}: the state is missing"))
}

/// Frees a state.
///
/// # Safety
/// As for [`get_state`].
pub(crate) unsafe fn free_state(place: *mut *mut c_void) {
    if place.is_null() || !place.is_aligned() {
        return;
    }
    // SAFETY: by the contract it points to null or to such a box.
    unsafe {
        if !(*place).is_null() {
            drop(Box::from_raw((*place).cast::<State>()));
            *place = std::ptr::null_mut();
        }
    }
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

/// Makes a state from an importer's bytes.
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
        return Err(format!("{name}: no room for the state was given"));
    }
    // SAFETY: by the contract of an importer.
    unsafe {
        let made = instance.deserialised(name, values(bytes, size)?)?;
        free_state(place);
        tell(place, boxed(made));
    }
    Ok(())
}

/// Refuses all of these variables, because none has the type.
///
/// # Safety
/// As for [`call`] and [`values`].
pub(crate) unsafe fn none_of(
    instance: *mut c_void,
    name: &str,
    references: *const u32,
    n: usize,
) -> c_int {
    let refuse = |i: &mut Instance| {
        // SAFETY: by the contract of an importer.
        match unsafe { values(references, n)? }.first() {
            Some(reference) => Err(i.foreign(name, *reference)),
            None => Ok(()),
        }
    };
    // SAFETY: by the contract of an importer.
    unsafe { call(instance, refuse) }
}

/// Defines functions that do one thing with an instance, and are exported under their own names.
macro_rules! calls {
    ($($name:ident($($arg:ident: $type:ty),*) |$i:pat_param, $called:pat_param| $work:expr;)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void, $($arg: $type),*) -> c_int {
            let $called = stringify!($name);
            // SAFETY: by the contract of an importer, also for the work.
            unsafe { $crate::boundary::call(instance, |$i: &mut Instance| $work) }
        }
    )*};
}
pub(crate) use calls;

/// Defines functions for variables of types that no variable has.
macro_rules! none_of_type {
    ($($name:ident($($arg:ident: $type:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: *mut c_void,
            references: *const u32,
            count: usize,
            $($arg: $type),*
        ) -> c_int {
            // SAFETY: by the contract of an importer.
            unsafe { $crate::boundary::none_of(instance, stringify!($name), references, count) }
        }
    )*};
}
pub(crate) use none_of_type;

/// Defines functions for missing features.
macro_rules! refused {
    ($($name:ident($($arg:ident: $type:ty),*): $why:literal;)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void, $($arg: $type),*) -> c_int {
            let why = concat!(stringify!($name), ": ", $why);
            // SAFETY: by the contract of an importer.
            unsafe { $crate::boundary::call(instance, |_| Err(why.to_owned())) }
        }
    )*};
}
pub(crate) use refused;

/// Defines a function that returns numbers of the equations.
macro_rules! told {
    ($name:ident, $of:ident) => {
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: *mut c_void, numbers: *mut f64, count: usize) -> c_int {
            let get = |i: &mut Instance| {
                // SAFETY: by the contract of an importer.
                let room = unsafe { $crate::boundary::room(numbers, count)? };
                for (place, number) in room.iter_mut().zip(i.$of(stringify!($name), count)?) {
                    place.write(number);
                }
                Ok(())
            };
            // SAFETY: by the contract of an importer.
            unsafe { $crate::boundary::call(c, get) }
        }
    };
}
pub(crate) use told;
