//! The library as an importer has it: a file, loaded while the program runs, and functions found by name.
#![allow(unsafe_code, dead_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};

use stiction_fmu::fmi2::CallbackFunctions;

/// An instance.
pub type C = *mut c_void;
type Text = *const c_char;

pub struct Library(libloading::Library);

impl Library {
    /// The one that was built along with this program.
    pub fn own() -> Self {
        let mut path = std::env::current_exe().unwrap();
        path.set_file_name(libloading::library_filename("stiction_fmu"));
        Self::open(path)
    }

    pub fn open(path: PathBuf) -> Self {
        // SAFETY: our own library does nothing when it is loaded.
        Self(unsafe { libloading::Library::new(&path) }.unwrap_or_else(|e| panic!("{path:?}: {e}")))
    }

    pub fn has(&self, name: &str) -> bool {
        // SAFETY: the function is not called.
        unsafe { self.0.get::<*const ()>(name.as_bytes()) }.is_ok()
    }

    /// A function of the library.
    ///
    /// # Safety
    /// `F` is the type of the function, and the library is loaded for as long as it is called.
    pub unsafe fn function<F: Copy>(&self, name: &str) -> F {
        // SAFETY: by the contract of this function.
        *unsafe { self.0.get(name.as_bytes()) }.unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// What a function without arguments says.
    pub fn text(&self, name: &str) -> String {
        // SAFETY: such are of this type, and give a text that lasts.
        unsafe {
            let text = self.function::<unsafe extern "C" fn() -> Text>(name)();
            CStr::from_ptr(text).to_str().unwrap().to_owned()
        }
    }
}

/// What an importer does in co-simulation, with functions of either version. It must not outlive the
/// library.
pub trait Importer {
    /// An instance that has been initialised at time 0.
    fn start(&self, resources: &Path, token: &str) -> C;

    /// Sets OP, takes the step, and gets VP.
    fn step(&self, instance: C, time: f64, step: f64, op: f64) -> f64;

    fn free(&self, instance: C);
}

pub struct Two {
    pub instantiate:
        unsafe extern "C" fn(Text, c_int, Text, Text, *const CallbackFunctions, c_int, c_int) -> C,
    pub set_up: unsafe extern "C" fn(C, c_int, f64, f64, c_int, f64) -> c_int,
    pub enter: unsafe extern "C" fn(C) -> c_int,
    pub exit: unsafe extern "C" fn(C) -> c_int,
    pub set: unsafe extern "C" fn(C, *const u32, usize, *const f64) -> c_int,
    pub step: unsafe extern "C" fn(C, f64, f64, c_int) -> c_int,
    pub get: unsafe extern "C" fn(C, *const u32, usize, *mut f64) -> c_int,
    pub free: unsafe extern "C" fn(C),
}

impl Two {
    pub fn of(library: &Library) -> Self {
        // SAFETY: the functions have the types of the standard.
        unsafe {
            Self {
                instantiate: library.function("fmi2Instantiate"),
                set_up: library.function("fmi2SetupExperiment"),
                enter: library.function("fmi2EnterInitializationMode"),
                exit: library.function("fmi2ExitInitializationMode"),
                set: library.function("fmi2SetReal"),
                step: library.function("fmi2DoStep"),
                get: library.function("fmi2GetReal"),
                free: library.function("fmi2FreeInstance"),
            }
        }
    }
}

impl Importer for Two {
    fn start(&self, resources: &Path, token: &str) -> C {
        let path = resources.display().to_string().replace('\\', "/");
        let uri = format!("file:///{}", path.trim_start_matches('/'));
        let [uri, token] = [&*uri, token].map(|text| CString::new(text).unwrap());
        let functions = CallbackFunctions {
            logger: None,
            allocate_memory: null_mut(),
            free_memory: null_mut(),
            step_finished: null_mut(),
            environment: null_mut(),
        };
        let (name, token, uri) = (c"valve".as_ptr(), token.as_ptr(), uri.as_ptr());
        // SAFETY: texts are texts, and the instance is alive.
        unsafe {
            let c = (self.instantiate)(name, 1, token, uri, &functions, 0, 0);
            assert!(!c.is_null());
            assert_eq!((self.set_up)(c, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!((self.enter)(c) | (self.exit)(c), 0);
            c
        }
    }

    #[inline(always)]
    fn step(&self, instance: C, time: f64, step: f64, op: f64) -> f64 {
        let mut vp = f64::NAN;
        // SAFETY: the instance is alive, and arrays hold one value.
        let status = unsafe {
            (self.set)(instance, &1, 1, &op)
                | (self.step)(instance, time, step, 1)
                | (self.get)(instance, &2, 1, &mut vp)
        };
        assert_eq!(status, 0);
        vp
    }

    fn free(&self, instance: C) {
        // SAFETY: it is alive, and not used again.
        unsafe { (self.free)(instance) }
    }
}

pub struct Three {
    instantiate: unsafe extern "C" fn(
        Text,
        Text,
        Text,
        bool,
        bool,
        bool,
        bool,
        *const u32,
        usize,
        C,
        C,
        C,
    ) -> C,
    enter: unsafe extern "C" fn(C, bool, f64, f64, bool, f64) -> c_int,
    exit: unsafe extern "C" fn(C) -> c_int,
    set: unsafe extern "C" fn(C, *const u32, usize, *const f64, usize) -> c_int,
    #[allow(clippy::type_complexity)]
    step:
        unsafe extern "C" fn(C, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int,
    get: unsafe extern "C" fn(C, *const u32, usize, *mut f64, usize) -> c_int,
    free: unsafe extern "C" fn(C),
}

impl Three {
    pub fn of(library: &Library) -> Self {
        // SAFETY: the functions have the types of the standard.
        unsafe {
            Self {
                instantiate: library.function("fmi3InstantiateCoSimulation"),
                enter: library.function("fmi3EnterInitializationMode"),
                exit: library.function("fmi3ExitInitializationMode"),
                set: library.function("fmi3SetFloat64"),
                step: library.function("fmi3DoStep"),
                get: library.function("fmi3GetFloat64"),
                free: library.function("fmi3FreeInstance"),
            }
        }
    }
}

impl Importer for Three {
    fn start(&self, resources: &Path, token: &str) -> C {
        let path = resources.display().to_string();
        let [path, token] = [&*path, token].map(|text| CString::new(text).unwrap());
        let (name, token, path) = (c"valve".as_ptr(), token.as_ptr(), path.as_ptr());
        let (no, none) = (false, null_mut());
        // SAFETY: texts are texts, and the instance is alive.
        unsafe {
            let c =
                (self.instantiate)(name, token, path, no, no, no, no, null(), 0, none, none, none);
            assert!(!c.is_null());
            assert_eq!((self.enter)(c, no, 0.0, 0.0, no, 0.0) | (self.exit)(c), 0);
            c
        }
    }

    #[inline(always)]
    fn step(&self, instance: C, time: f64, step: f64, op: f64) -> f64 {
        let (mut vp, mut last) = (f64::NAN, f64::NAN);
        let [mut a, mut b, mut c] = [false; 3];
        // SAFETY: the instance is alive, and arrays hold one value.
        let status = unsafe {
            (self.set)(instance, &1, 1, &op, 1)
                | (self.step)(instance, time, step, true, &mut a, &mut b, &mut c, &mut last)
                | (self.get)(instance, &2, 1, &mut vp, 1)
        };
        assert_eq!((status, b, c), (0, false, false));
        vp
    }

    fn free(&self, instance: C) {
        // SAFETY: it is alive, and not used again.
        unsafe { (self.free)(instance) }
    }
}
