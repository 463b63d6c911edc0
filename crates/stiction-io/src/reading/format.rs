//! Detects the format of a file, and reads its sheets.

use crate::csv::{self, Dialect};
use crate::error::{Error, Result};
use crate::sheet::Sheet;
use std::path::Path;

/// The format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text with a delimiter.
    Csv(Dialect),
    /// Apache Parquet.
    Parquet,
    /// MATLAB, in any of its versions.
    Matlab,
    /// A table in memory instead of a file.
    Memory,
}

impl Format {
    /// How the names of its files end, in lower case.
    const ENDS: [&str; 7] = ["csv", "tsv", "txt", "parquet", "pq", "mat", "h5"];

    /// Whether the name at the end of a path is like that of a recording.
    pub fn is_named_like_one(path: &Path) -> bool {
        let end = path.extension().map(|end| end.to_string_lossy().to_lowercase());
        end.is_some_and(|end| Self::ENDS.contains(&&*end))
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv(_) => "CSV",
            Self::Parquet => "Parquet",
            Self::Matlab => "MATLAB",
            Self::Memory => "table in memory",
        }
    }
}

/// The error for a format that this library was built without.
#[cfg(not(all(feature = "parquet", feature = "matlab")))]
fn not_built_in(origin: &str, what: &str, feature: &str) -> Error {
    Error::Table {
        origin: origin.to_owned(),
        message: format!(
            "is {what}, which this program was built without (feature \"{feature}\"); save it as CSV"
        ),
    }
}

/// The sheets in `bytes`, by the signature at their beginning. Bytes without a signature are text.
pub fn sheets(bytes: &[u8], origin: &str) -> Result<(Format, Vec<Sheet>, Vec<String>)> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    if bytes.starts_with(b"PAR1") {
        #[cfg(feature = "parquet")]
        return Ok((Format::Parquet, crate::parquet::parquet_sheets(bytes, origin)?, vec![]));
        #[cfg(not(feature = "parquet"))]
        return Err(not_built_in(origin, "a Parquet file", "parquet"));
    }
    if bytes.starts_with(b"MATLAB 5.0")
        || bytes.starts_with(b"MATLAB 7.3")
        || bytes.starts_with(HDF5)
    {
        #[cfg(feature = "matlab")]
        return Ok((Format::Matlab, crate::matlab::matlab_sheets(bytes, origin)?, vec![]));
        #[cfg(not(feature = "matlab"))]
        return Err(not_built_in(origin, "a MATLAB file", "matlab"));
    }
    for (signature, message) in [
        (&b"PK\x03\x04"[..], "is a spreadsheet or ZIP archive; save the sheet as CSV"),
        (b"\xd0\xcf\x11\xe0", "is an old Excel or Office file; save the sheet as CSV"),
        (b"\x1f\x8b", "is compressed with gzip; unpack it"),
    ] {
        if bytes.starts_with(signature) {
            return Err(Error::Table { origin: origin.to_owned(), message: message.to_owned() });
        }
    }
    let csv = csv::read(bytes, origin)?;
    Ok((Format::Csv(csv.dialect), vec![csv.sheet], csv.notes))
}
