//! The libraries in FMUs, one for each platform.

use crate::Error;
use crate::compile::Compiler;
use std::borrow::Cow;
use std::path::Path;

/// The library of one platform.
#[derive(Debug, Clone)]
pub struct Library {
    /// Processor, as Rust names it, such as `x86_64`.
    pub arch: String,
    /// Operating system, as Rust names it, such as `linux`.
    pub os: String,
    /// The file.
    pub bytes: Cow<'static, [u8]>,
    /// Whether a user requested the library. Otherwise the library belongs to this build. An FMU of an FMI version
    /// without a folder for the platform leaves it out.
    pub given: bool,
}

/// A platform for FMUs of this build.
#[derive(Debug)]
pub struct Platform {
    /// As Rust names it, such as `x86_64-unknown-linux-gnu`.
    target: &'static str,
    /// Processor, such as `x86_64`.
    pub arch: &'static str,
    /// Operating system, such as `linux`.
    pub os: &'static str,
    /// Library, in a release.
    library: Option<&'static [u8]>,
}

/// The platform of this build, and the platforms in the variable `STICTION_FMU_TARGETS` at build time.
pub const PLATFORMS: &[Platform] = &include!(concat!(env!("OUT_DIR"), "/platforms.rs"));

impl Platform {
    /// Whether its library may have to be compiled before an FMU can be written. That takes about a minute, once.
    pub fn is_compiled_at_export(&self) -> bool {
        self.library.is_none()
    }

    /// Library: the built-in one, or one compiled now from the sources of this build.
    fn library(&self) -> Result<Library, Error> {
        let bytes = match self.library {
            Some(bytes) => Cow::Borrowed(bytes),
            None => Cow::Owned(compiled(self).map_err(Error::Compiler)?),
        };
        Ok(Library { arch: self.arch.to_owned(), os: self.os.to_owned(), bytes, given: false })
    }
}

impl Library {
    /// Those of all [`PLATFORMS`].
    ///
    /// # Errors
    /// If a library is not built in and cannot be compiled, because its sources or `cargo` are missing.
    pub fn own() -> Result<Vec<Self>, Error> {
        Self::own_and(vec![])
    }

    /// The libraries of `given`, and built-in libraries for all other [`PLATFORMS`].
    ///
    /// # Errors
    /// As [`Library::own`].
    pub fn own_and(given: Vec<Self>) -> Result<Vec<Self>, Error> {
        let is_given = |own: &&Platform| given.iter().any(|g| g.arch == own.arch && g.os == own.os);
        let own = PLATFORMS.iter().filter(|own| !is_given(own)).map(Platform::library);
        let mut all = own.collect::<Result<Vec<Self>, Error>>()?;
        all.extend(given);
        Ok(all)
    }
}

/// The library of a platform, compiled from the sources of this build, or kept from an earlier compilation.
fn compiled(platform: &Platform) -> Result<Vec<u8>, String> {
    // A release has none of these, but all libraries.
    let root = Path::new(option_env!("STICTION_FMU_ROOT").unwrap_or_default());
    let folder = Path::new(option_env!("STICTION_FMU_FOLDER").unwrap_or_default());
    let sources = option_env!("STICTION_FMU_SOURCES").unwrap_or_default();
    let kept = folder.join(format!("{}-{sources}.bin", platform.target));
    if let Ok(bytes) = std::fs::read(&kept) {
        return Ok(bytes);
    }
    if !root.join("addons/stiction-fmu/Cargo.toml").is_file() {
        return Err(format!("its sources are no longer in {}", root.display()));
    }
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let compiler = Compiler {
        cargo: &cargo,
        rustc: &rustc,
        own: option_env!("STICTION_FMU_OWN").unwrap_or_default(),
        flags: option_env!("STICTION_FMU_FLAGS").unwrap_or_default(),
        root,
        folder,
    };
    let file = compiler.library(platform.target, platform.os)?;
    let bytes = std::fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    // If it cannot be kept, it is compiled again.
    let _ = stiction_io::whole::write(&kept, &bytes);
    Ok(bytes)
}
