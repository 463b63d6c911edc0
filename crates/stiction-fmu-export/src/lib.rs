//! Writes functional mock-up units (FMU): a zip of `modelDescription.xml`, `resources/stiction.json`, a page that
//! documents the variables, and the library, which is built along with this crate. Whoever uses the FMU needs
//! no compiler, and neither does whoever exports it.
//!
//! ```
//! use stiction_fmu::{Fmi, Fmu};
//! use stiction_fmu_export::{Library, write};
//!
//! let valve = Fmu::new("valve", "two-phase")?.with("S", 5.0)?.with("J", 3.0)?;
//! let bytes = write(&valve, Fmi::V2, &Library::built_in())?;  // valve.fmu
//! assert!(bytes.starts_with(b"PK"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod page;
mod scenario;

pub use scenario::of_scenario;

use std::borrow::Cow;
use std::io::{Cursor, Write};
use stiction_fmu::{Fmi, Fmu};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Why an FMU could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The parameters do not go together, or are not known.
    #[error("{0}")]
    Model(String),
    /// There is no name for a platform in FMI.
    #[error("FMI has no folder for a library of {arch} under {os}")]
    Platform {
        /// The processor.
        arch: String,
        /// The operating system.
        os: String,
    },
    /// Two libraries are of one platform.
    #[error("there are two libraries for {0}")]
    Twice(String),
    /// The zip could not be written.
    #[error(transparent)]
    Zip(#[from] zip::result::ZipError),
    /// The zip could not be written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// The library of one platform.
#[derive(Debug, Clone)]
pub struct Library {
    /// Processor, as Rust names it, such as `x86_64`.
    pub arch: String,
    /// Operating system, as Rust names it, such as `linux`.
    pub os: String,
    /// The file.
    pub bytes: Cow<'static, [u8]>,
}

impl Library {
    /// Those built along with this crate: of the platform it is for, and of those that the variable
    /// `STICTION_FMU_TARGETS` listed when it was built.
    pub fn built_in() -> Vec<Self> {
        let library = |&(arch, os, bytes): &(&str, &str, &'static [u8])| Self {
            arch: arch.to_owned(),
            os: os.to_owned(),
            bytes: Cow::Borrowed(bytes),
        };
        BUILT_IN.iter().map(library).collect()
    }

    /// Those built in and these, which come in place of those of the same platform.
    pub fn built_in_and(further: Vec<Self>) -> Vec<Self> {
        let mut all = Self::built_in();
        let alike = |a: &Self, b: &Self| a.arch == b.arch && a.os == b.os;
        all.retain(|known| !further.iter().any(|given| alike(known, given)));
        all.extend(further);
        all
    }
}

/// Processor, operating system and file.
const BUILT_IN: &[(&str, &str, &[u8])] = &include!(concat!(env!("OUT_DIR"), "/libraries.rs"));

/// The FMU as the bytes of its file, the same for the same model.
///
/// # Errors
/// If the start values do not go together, or FMI has no place for a library.
pub fn write(fmu: &Fmu, fmi: Fmi, libraries: &[Library]) -> Result<Vec<u8>, Error> {
    fmu.check().map_err(Error::Model)?;
    let mut files: Vec<(String, Cow<'_, [u8]>)> = vec![
        ("modelDescription.xml".to_owned(), fmu.xml(fmi).into_bytes().into()),
        ("resources/stiction.json".to_owned(), fmu.json().into_bytes().into()),
        ("documentation/index.html".to_owned(), page::page(fmu, fmi).into_bytes().into()),
    ];
    for library in libraries {
        let Some(name) = fmi.binary(&library.arch, &library.os) else {
            let (arch, os) = (library.arch.clone(), library.os.clone());
            return Err(Error::Platform { arch, os });
        };
        if files.iter().any(|(known, _)| *known == name) {
            return Err(Error::Twice(name));
        }
        files.push((name, Cow::Borrowed(&*library.bytes)));
    }
    // The zip's oldest time, so that the same model gives the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default());
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    for (name, bytes) in files {
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        zip.start_file(name, options.unix_permissions(mode))?;
        zip.write_all(&bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
