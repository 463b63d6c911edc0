//! An importer in a few lines, for either version, that keeps what is logged.
#![allow(unsafe_code, dead_code)]

pub mod calls;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use stiction_fmu::{Fmi, Fmu, fmi2, fmi3};

/// The resources of an FMU in a directory of their own, which goes when this goes.
pub struct Unpacked {
    pub directory: PathBuf,
    pub token: String,
}

impl Unpacked {
    pub fn new(fmu: &Fmu) -> Self {
        Self::with_text(&fmu.json(), fmu.token())
    }

    pub fn with_text(json: &str, token: String) -> Self {
        let unpacked = Self::empty(token);
        std::fs::write(unpacked.directory.join("stiction.json"), json).unwrap();
        unpacked
    }

    pub fn empty(token: String) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("stiction-fmu-{}-{count}", std::process::id());
        let directory = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&directory).unwrap();
        Self { directory, token }
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.directory);
    }
}

/// What was logged.
pub type Entries = Mutex<Vec<String>>;

unsafe fn keep(environment: *mut c_void, message: *const c_char) {
    // SAFETY: the environment is the importer's `Entries`, the message a text.
    unsafe {
        let entries = &*environment.cast::<Entries>();
        let text = CStr::from_ptr(message).to_string_lossy().into_owned();
        entries.lock().unwrap().push(text);
    }
}

unsafe extern "C" fn log3(
    environment: *mut c_void,
    _status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: as the callers of this function promise.
    unsafe { keep(environment, message) }
}

/// Stands in for a variadic function, which stable Rust cannot define: where variadic arguments travel
/// as others do (Linux and Windows on x86-64), it receives the one that the library passes.
unsafe extern "C" fn log2(
    environment: *mut c_void,
    _name: *const c_char,
    _status: c_int,
    _category: *const c_char,
    _format: *const c_char,
    message: *const c_char,
) {
    // SAFETY: as the callers of this function promise.
    unsafe { keep(environment, message) }
}

type Variadic =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// An instance in the hands of an importer.
pub struct Client {
    pub version: Fmi,
    pub instance: *mut c_void,
    log: Box<Entries>,
}

/// Calls what the version of an instance calls so: with the same arguments, or with its own.
macro_rules! by_version {
    ($client:ident, $v2:ident, $v3:ident($($given:expr),*)) => {
        by_version!($client, $v2($($given),*), $v3($($given),*))
    };
    ($client:ident, $v2:ident($($a:expr),*), $v3:ident($($b:expr),*)) => {
        // SAFETY: the instance is null or alive, a state comes from it, and arrays are as long as is said.
        unsafe {
            match $client.version {
                Fmi::V2 => fmi2::$v2($client.instance $(, $a)*),
                Fmi::V3 => fmi3::$v3($client.instance $(, $b)*),
            }
        }
    };
}

impl Client {
    /// An instance for co-simulation, or model exchange; null if it was refused.
    pub fn instantiate(version: Fmi, unpacked: &Unpacked, exchange: bool) -> Self {
        let path = unpacked.directory.display().to_string().replace('\\', "/");
        let uri = format!("file://{}{path}", if path.starts_with('/') { "" } else { "/" });
        Self::at(version, if version == Fmi::V2 { &uri } else { &path }, &unpacked.token, exchange)
    }

    pub fn at(version: Fmi, location: &str, token: &str, exchange: bool) -> Self {
        let log = Box::new(Entries::default());
        let environment = std::ptr::from_ref(&*log).cast_mut().cast();
        let [name, location, token] =
            ["valve", location, token].map(|text| CString::new(text).unwrap());
        // SAFETY: texts and callbacks outlive the calls, the log the instance; for `log2` see there.
        let instance = unsafe {
            match version {
                Fmi::V2 => {
                    let functions = fmi2::CallbackFunctions {
                        logger: Some(std::mem::transmute::<*const (), Variadic>(log2 as *const ())),
                        allocate_memory: std::ptr::null_mut(),
                        free_memory: std::ptr::null_mut(),
                        step_finished: std::ptr::null_mut(),
                        environment,
                    };
                    fmi2::fmi2Instantiate(
                        name.as_ptr(),
                        c_int::from(!exchange),
                        token.as_ptr(),
                        location.as_ptr(),
                        &functions,
                        0,
                        0,
                    )
                }
                Fmi::V3 if exchange => fmi3::fmi3InstantiateModelExchange(
                    name.as_ptr(),
                    token.as_ptr(),
                    location.as_ptr(),
                    0,
                    0,
                    environment,
                    Some(log3),
                ),
                Fmi::V3 => fmi3::fmi3InstantiateCoSimulation(
                    name.as_ptr(),
                    token.as_ptr(),
                    location.as_ptr(),
                    0,
                    0,
                    0,
                    0,
                    std::ptr::null(),
                    0,
                    environment,
                    Some(log3),
                    std::ptr::null_mut(),
                ),
            }
        };
        Self { version, instance, log }
    }

    /// What was logged since last asked.
    pub fn logged(&self) -> Vec<String> {
        std::mem::take(&mut self.log.lock().unwrap())
    }

    /// The same as `status`, which must be good.
    #[track_caller]
    pub fn good(&self, status: c_int) {
        assert_eq!(status, 0, "{:?}", self.logged());
    }

    /// Initialised at time 0.
    #[track_caller]
    pub fn start(&self) {
        self.good(self.enter());
        self.good(self.exit());
    }

    pub fn enter(&self) -> c_int {
        let c = self.instance;
        // SAFETY: as in all that follows, the instance is null or alive.
        unsafe {
            match self.version {
                Fmi::V2 => match fmi2::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) {
                    0 => fmi2::fmi2EnterInitializationMode(c),
                    refused => refused,
                },
                Fmi::V3 => fmi3::fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0),
            }
        }
    }

    pub fn exit(&self) -> c_int {
        by_version!(self, fmi2ExitInitializationMode, fmi3ExitInitializationMode())
    }

    pub fn set(&self, reference: u32, value: f64) -> c_int {
        by_version!(
            self,
            fmi2SetReal(&reference, 1, &value),
            fmi3SetFloat64(&reference, 1, &value, 1)
        )
    }

    pub fn get(&self, reference: u32) -> Result<f64, c_int> {
        let mut value = f64::NAN;
        let status = by_version!(
            self,
            fmi2GetReal(&reference, 1, &mut value),
            fmi3GetFloat64(&reference, 1, &mut value, 1)
        );
        if status == 0 { Ok(value) } else { Err(status) }
    }

    pub fn boolean(&self, reference: u32) -> bool {
        // SAFETY: see above.
        unsafe {
            match self.version {
                Fmi::V2 => {
                    let mut value = -1;
                    self.good(fmi2::fmi2GetBoolean(self.instance, &reference, 1, &mut value));
                    value != 0
                }
                Fmi::V3 => {
                    let mut value = 9;
                    self.good(fmi3::fmi3GetBoolean(self.instance, &reference, 1, &mut value, 1));
                    value != 0
                }
            }
        }
    }

    pub fn integer(&self, reference: u32) -> i32 {
        let mut value = -1;
        self.good(by_version!(
            self,
            fmi2GetInteger(&reference, 1, &mut value),
            fmi3GetInt32(&reference, 1, &mut value, 1)
        ));
        value
    }

    pub fn step(&self, time: f64, step: f64) -> c_int {
        let mut flags = [9u8; 3];
        let mut last = f64::NAN;
        let [a, b, c] = &mut flags;
        by_version!(self, fmi2DoStep(time, step, 1), fmi3DoStep(time, step, 1, a, b, c, &mut last))
    }

    pub fn enter_event_mode(&self) -> c_int {
        by_version!(self, fmi2EnterEventMode, fmi3EnterEventMode())
    }

    /// Lets events pass.
    pub fn update(&self) -> c_int {
        let mut info = std::mem::MaybeUninit::uninit();
        let (mut flags, mut next) = ([9u8; 5], f64::NAN);
        let [a, b, c, d, e] = &mut flags;
        by_version!(
            self,
            fmi2NewDiscreteStates(info.as_mut_ptr()),
            fmi3UpdateDiscreteStates(a, b, c, d, e, &mut next)
        )
    }

    pub fn enter_continuous_time_mode(&self) -> c_int {
        by_version!(self, fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode())
    }

    pub fn set_time(&self, time: f64) -> c_int {
        by_version!(self, fmi2SetTime, fmi3SetTime(time))
    }

    pub fn set_states(&self, x: &[f64]) -> c_int {
        let (at, n) = (x.as_ptr(), x.len());
        by_version!(self, fmi2SetContinuousStates, fmi3SetContinuousStates(at, n))
    }

    pub fn states(&self, x: &mut [f64]) -> c_int {
        let (at, n) = (x.as_mut_ptr(), x.len());
        by_version!(self, fmi2GetContinuousStates, fmi3GetContinuousStates(at, n))
    }

    pub fn nominals(&self, x: &mut [f64]) -> c_int {
        let (at, n) = (x.as_mut_ptr(), x.len());
        by_version!(
            self,
            fmi2GetNominalsOfContinuousStates,
            fmi3GetNominalsOfContinuousStates(at, n)
        )
    }

    pub fn rates(&self, x: &mut [f64]) -> c_int {
        let (at, n) = (x.as_mut_ptr(), x.len());
        by_version!(self, fmi2GetDerivatives, fmi3GetContinuousStateDerivatives(at, n))
    }

    pub fn indicators(&self, x: &mut [f64]) -> c_int {
        let (at, n) = (x.as_mut_ptr(), x.len());
        by_version!(self, fmi2GetEventIndicators, fmi3GetEventIndicators(at, n))
    }

    pub fn terminate(&self) -> c_int {
        by_version!(self, fmi2Terminate, fmi3Terminate())
    }

    pub fn reset(&self) -> c_int {
        by_version!(self, fmi2Reset, fmi3Reset())
    }

    pub fn state(&self) -> *mut c_void {
        let mut state = std::ptr::null_mut();
        self.good(by_version!(self, fmi2GetFMUstate, fmi3GetFMUState(&mut state)));
        state
    }

    pub fn set_state(&self, state: *mut c_void) -> c_int {
        by_version!(self, fmi2SetFMUstate, fmi3SetFMUState(state))
    }

    pub fn free_state(&self, mut state: *mut c_void) {
        self.good(by_version!(self, fmi2FreeFMUstate, fmi3FreeFMUState(&mut state)));
        assert!(state.is_null());
    }

    pub fn serialise(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = 0;
        self.good(by_version!(
            self,
            fmi2SerializedFMUstateSize,
            fmi3SerializedFMUStateSize(state, &mut size)
        ));
        let mut bytes = vec![0; size];
        let at = bytes.as_mut_ptr();
        self.good(by_version!(self, fmi2SerializeFMUstate, fmi3SerializeFMUState(state, at, size)));
        bytes
    }

    pub fn deserialise(&self, bytes: &[u8]) -> Result<*mut c_void, c_int> {
        let mut state = std::ptr::null_mut();
        let (at, size) = (bytes.as_ptr(), bytes.len());
        let status = by_version!(
            self,
            fmi2DeSerializeFMUstate,
            fmi3DeserializeFMUState(at, size, &mut state)
        );
        if status == 0 { Ok(state) } else { Err(status) }
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        by_version!(self, fmi2FreeInstance, fmi3FreeInstance())
    }
}

/// The value reference of a variable.
#[track_caller]
pub fn reference(fmu: &Fmu, name: &str) -> u32 {
    fmu.variables().iter().position(|v| v.name == name).expect("there is such a variable") as u32
}

/// An OP that wanders about 50 %, by a linear congruence.
pub fn wandering(n: usize, mut seed: u64) -> Vec<f64> {
    let mut op = 50.0;
    let mut slope = 0.0;
    (0..n)
        .map(|_| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let fresh = (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            // Now and then it holds still, as real ones do.
            if fresh > -0.4 {
                slope = 0.9 * slope + fresh - 0.01 * (op - 50.0);
                op += slope;
            }
            op
        })
        .collect()
}
