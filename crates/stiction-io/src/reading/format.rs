//! Detects the format of a file, and reads its sheets.

use crate::bytes;
use crate::csv::{self, Dialect};
use crate::error::{Error, Result};
use crate::sheet::Sheet;
use sha2::{Digest, Sha256};
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
    /// A workbook of Excel or OpenDocument.
    Workbook,
    /// A table in memory instead of a file.
    Memory,
}

impl Format {
    /// How the names of its files end, in lower case.
    const ENDS: [&str; 13] = [
        "csv", "tsv", "txt", "parquet", "pq", "mat", "h5", "xlsx", "xlsm", "xlsb", "xls", "ods",
        "gz",
    ];

    /// Whether the name at the end of a path looks like the name of a recording.
    pub fn is_named_like_one(path: &Path) -> bool {
        let end = path.extension().map(|end| end.to_string_lossy().to_lowercase());
        match end.as_deref() {
            Some("gz") => {
                path.file_stem().is_some_and(|stem| Self::is_named_like_one(stem.as_ref()))
            }
            end => end.is_some_and(|end| Self::ENDS.contains(&end)),
        }
    }

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv(_) => "CSV",
            Self::Parquet => "Parquet",
            Self::Matlab => "MATLAB",
            Self::Workbook => "workbook",
            Self::Memory => "table in memory",
        }
    }
}

/// The error for a format that this library was built without.
#[cfg(not(all(feature = "parquet", feature = "matlab", feature = "spreadsheet")))]
fn not_built_in(origin: &str, what: &str, feature: &str) -> Error {
    Error::Table {
        origin: origin.to_owned(),
        message: format!(
            "is {what}, which this program was built without (feature \"{feature}\"); save it as CSV"
        ),
    }
}

/// A file with its sheets.
pub struct File {
    pub format: Format,
    pub sheets: Vec<Sheet>,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

impl File {
    /// The file in `bytes`.
    ///
    /// # Errors
    /// As for [`sheets`].
    pub fn of(bytes: &[u8], origin: &str) -> Result<Self> {
        let (format, sheets, notes) = sheets(bytes, origin)?;
        Ok(Self { format, sheets, notes, sha256: format!("{:x}", Sha256::digest(bytes)) })
    }

    /// The file at `path`. A large text file is read in pieces.
    ///
    /// # Errors
    /// If the file cannot be read, or as for [`sheets`].
    pub fn open(path: &Path, origin: &str) -> Result<Self> {
        match csv::read_large(path, origin)? {
            Some((csv, sha256)) => {
                let (format, sheets) = (Format::Csv(csv.dialect), vec![csv.sheet]);
                Ok(Self { format, sheets, notes: csv.notes, sha256 })
            }
            None => Self::of(&bytes::read(path)?, origin),
        }
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
        || is_level_4(bytes)
    {
        #[cfg(feature = "matlab")]
        return Ok((Format::Matlab, crate::matlab::matlab_sheets(bytes, origin)?, vec![]));
        #[cfg(not(feature = "matlab"))]
        return Err(not_built_in(origin, "a MATLAB file", "matlab"));
    }
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"\xd0\xcf\x11\xe0") {
        #[cfg(feature = "spreadsheet")]
        {
            let (sheets, notes) = crate::workbook::workbook_sheets(bytes, origin)?;
            return Ok((Format::Workbook, sheets, notes));
        }
        #[cfg(not(feature = "spreadsheet"))]
        return Err(not_built_in(origin, "a spreadsheet or ZIP archive", "spreadsheet"));
    }
    if bytes.starts_with(b"\x1f\x8b") {
        #[cfg(any(feature = "matlab", feature = "parquet"))]
        return sheets(&unpacked(bytes, origin)?, origin);
        #[cfg(not(any(feature = "matlab", feature = "parquet")))]
        return Err(not_built_in(origin, "compressed with gzip", "parquet"));
    }
    let csv = csv::read(bytes, origin)?;
    Ok((Format::Csv(csv.dialect), vec![csv.sheet], csv.notes))
}

/// Whether a file is of MATLAB's version 4, which has no signature.
#[cfg(feature = "matlab")]
use crate::matlab::level4::is as is_level_4;

/// Without MATLAB, such a file is refused as no text.
#[cfg(not(feature = "matlab"))]
fn is_level_4(_: &[u8]) -> bool {
    false
}

/// The content of a file compressed with gzip.
#[cfg(any(feature = "matlab", feature = "parquet"))]
fn unpacked(bytes: &[u8], origin: &str) -> Result<Vec<u8>> {
    use std::io::Read;
    let wrong = |message: String| Error::Table { origin: origin.to_owned(), message };
    let mut budget = crate::budget::Budget::of(bytes.len());
    let mut content = vec![];
    flate2::read::MultiGzDecoder::new(bytes)
        .take(budget.left() as u64 + 1)
        .read_to_end(&mut content)
        .map_err(|e| wrong(format!("cannot be unpacked with gzip ({e}); copy it again")))?;
    budget.spend(content.len()).map_err(wrong)?;
    match content.starts_with(b"\x1f\x8b") {
        true => Err(wrong("is compressed with gzip twice; unpack it".to_owned())),
        false => Ok(content),
    }
}
