//! The library as an importer has it: a file, loaded while the program runs.
#![allow(unsafe_code, dead_code)]

use std::ffi::{CStr, c_char};
use std::path::PathBuf;

pub struct Library(libloading::Library);

impl Library {
    /// The one that was built along with this test.
    pub fn own() -> Self {
        let mut path = std::env::current_exe().unwrap();
        path.set_file_name(libloading::library_filename("stiction_fmu"));
        Self::open(path)
    }

    pub fn open(path: PathBuf) -> Self {
        // SAFETY: our own library does nothing when it is loaded.
        Self(unsafe { libloading::Library::new(&path) }.unwrap_or_else(|e| panic!("{path:?}: {e}")))
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
            let text = self.function::<unsafe extern "C" fn() -> *const c_char>(name)();
            CStr::from_ptr(text).to_str().unwrap().to_owned()
        }
    }
}
