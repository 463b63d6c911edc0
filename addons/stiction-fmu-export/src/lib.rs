//! Writes functional mock-up units (FMU): a zip of `modelDescription.xml`, `resources/stiction.json`, a page that
//! documents the model, its licences, an icon, and the library. Using the FMU needs no compiler. Neither does
//! exporting it with a release (profile `dist`), which contains the library. A lighter build compiles it at the
//! first export.
//!
//! ```
//! use stiction_fmu::{Fmi, Fmu};
//! use stiction_fmu_export::{Library, write};
//!
//! let valve = Fmu::new("valve", "two-phase")?.with("S", 5.0)?.with("J", 3.0)?;
//! let bytes = write(&valve, Fmi::V2, &Library::own()?, None)?;  // valve.fmu
//! assert!(bytes.starts_with(b"PK"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod compile;
mod equations;
mod library;
mod page;
mod picture;
mod scenario;

pub use library::{Library, PLATFORMS, Platform};
pub use scenario::of_scenario;

use std::borrow::Cow;
use std::io::{Cursor, Write};
use stiction_fmu::{Fmi, Fmu};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Why an FMU could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The parameters are inconsistent, or unknown.
    #[error("{0}")]
    Model(String),
    /// FMI has no name for a platform.
    #[error("FMI has no folder for a library of {arch} under {os}")]
    Platform {
        /// The processor.
        arch: String,
        /// The operating system.
        os: String,
    },
    /// Two libraries are of one platform.
    #[error("two libraries are given for {0}; give only one")]
    Twice(String),
    /// The library is not built in, and could not be compiled.
    #[error(
        "the library for FMUs is not part of this build and could not be compiled: {0}. Build with `--profile \
         dist`, which contains it"
    )]
    Compiler(String),
    /// The zip could not be written.
    #[error(transparent)]
    Zip(#[from] zip::result::ZipError),
    /// The zip could not be written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// The icon: `icon.svg` rasterised, 256 by 256 pixels.
const ICON: &[u8] = include_bytes!("icon.png");
const ICON_SVG: &[u8] = include_bytes!("icon.svg");

/// `terminalsAndIcons.xml` of FMI 3.0: the size of the icon.
const TERMINALS_AND_ICONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0">
  <GraphicalRepresentation>
    <CoordinateSystem x1="-100" y1="-100" x2="100" y2="100" suggestedScalingFactorTo_mm="0.1"/>
    <Icon x1="-100" y1="-100" x2="100" y2="100"/>
  </GraphicalRepresentation>
</fmiTerminalsAndIcons>
"#;

/// Licences, in `documentation/licenses`; `license.txt` is the entry point.
const LICENCES: [(&str, &str); 3] = [
    ("license.txt", include_str!("license.txt")),
    ("LICENSE-MIT.txt", include_str!("../../../LICENSE-MIT")),
    ("LICENSE-APACHE.txt", include_str!("../../../LICENSE-APACHE")),
];

/// The FMU as the bytes of its file, the same for the same model and time. `generated_s` is the time of generation in
/// the description, in seconds since 1970-01-01 UTC. With `None` the description has no time.
///
/// # Errors
/// If the start values are inconsistent, FMI has no folder for a given library, or it has a folder for none.
pub fn write(
    fmu: &Fmu,
    fmi: Fmi,
    libraries: &[Library],
    generated_s: Option<u64>,
) -> Result<Vec<u8>, Error> {
    fmu.check().map_err(Error::Model)?;
    let icon = match fmi {
        Fmi::V2 => "model.png",
        Fmi::V3 => "terminalsAndIcons/icon.png",
    };
    let page = page::page(fmu, fmi, &format!("../{icon}"))?;
    let mut files: Vec<(String, Cow<'_, [u8]>)> = vec![
        ("modelDescription.xml".to_owned(), fmu.xml(fmi, generated_s).into_bytes().into()),
        ("resources/stiction.json".to_owned(), fmu.json().into_bytes().into()),
        ("documentation/index.html".to_owned(), page.into_bytes().into()),
        (icon.to_owned(), ICON.into()),
    ];
    for (name, text) in LICENCES {
        files.push((format!("documentation/licenses/{name}"), text.as_bytes().into()));
    }
    if fmi == Fmi::V3 {
        files.push(("terminalsAndIcons/icon.svg".to_owned(), ICON_SVG.into()));
        let name = "terminalsAndIcons/terminalsAndIcons.xml";
        files.push((name.to_owned(), TERMINALS_AND_ICONS.as_bytes().into()));
    }
    let has_folder = |library: &Library| fmu.binary(fmi, &library.arch, &library.os).is_some();
    let others = libraries.iter().any(has_folder);
    for library in libraries {
        let Some(name) = fmu.binary(fmi, &library.arch, &library.os) else {
            // FMI 2.0 names no ARM, but an FMU with the other libraries serves elsewhere.
            if others && !library.given {
                continue;
            }
            let (arch, os) = (library.arch.clone(), library.os.clone());
            return Err(Error::Platform { arch, os });
        };
        if files.iter().any(|(known, _)| *known == name) {
            return Err(Error::Twice(name));
        }
        files.push((name, Cow::Borrowed(&*library.bytes)));
    }
    // The oldest time of a zip, so that the same model gives the same bytes.
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
