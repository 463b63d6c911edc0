//! Sheets from MATLAB files.
//!
//! A file is read into a tree of values first, whichever version it is of: level 5 (`-v6`, `-v7`) by
//! `level5`, version 7.3, which is HDF5, by `hdf5`. Then `sheets` finds the sheets in the tree.

#[cfg(feature = "matlab73")]
mod hdf5;
mod level5;
#[cfg(feature = "matlab73")]
mod links;
mod sheets;
mod value;

use crate::error::{Error, Result};
use crate::sheet::Sheet;
use value::{Fields, Message};

/// What every HDF5 file has at its beginning, or after a block of 512 bytes that MATLAB writes.
const HDF5_SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
const HDF5_OFFSETS: [usize; 3] = [0, 512, 1024];

/// The sheets in a MATLAB file; `origin` names the file in errors.
///
/// Every struct, at any depth, with vectors of equal length is a sheet whose `part` is the path to it,
/// such as `cdata.chemicals.loop2`; vectors that are variables of their own form one without a part.
/// Vectors become columns, rows of text and cell arrays of text too, and a matrix of at most 64
/// columns `data(:,1)`, `data(:,2)`, ..., or what `colheaders`, `names` or `tags` beside it call them.
/// A number `Ts`, `dt` or the like is the sampling time, other numbers and text are attributes. A set
/// point `SP` that is a single number is both: an attribute, and a column that holds it. Vectors of
/// another length than most, and everything else that makes no column, are `left_out` with the reason.
/// Where there are no vectors of equal length, single vectors count.
///
/// Dates that are MATLAB's (days since the year 0) are left as they are; the attribute `datenum` names
/// the column that looks like that.
///
/// # Errors
/// If the file is cut short, damaged, of version 4, or has no vectors; if it is of version 7.3 and this was built
/// without the feature `matlab73`.
///
/// # Limits
/// Sparse and complex arrays, function handles and objects, among them tables and timetables, are left
/// out, and so are links to other files, which are never followed. In files of version 7.3 fields come in the order of their names.
pub fn matlab_sheets(bytes: &[u8], origin: &str) -> Result<Vec<Sheet>> {
    variables(bytes)
        .and_then(|variables| sheets::find(&variables, origin))
        .map_err(|message| Error::Table { origin: origin.to_owned(), message })
}

/// The variables of a file, whatever its version.
fn variables(bytes: &[u8]) -> std::result::Result<Fields, Message> {
    let is_hdf5 = |at: usize| bytes.get(at..).is_some_and(|b| b.starts_with(HDF5_SIGNATURE));
    if HDF5_OFFSETS.into_iter().any(is_hdf5) {
        #[cfg(feature = "matlab73")]
        return hdf5::variables(bytes);
        #[cfg(not(feature = "matlab73"))]
        return Err("is of MATLAB's version 7.3, which this was built without (feature \"matlab73\"); save it with \
                    save(..., '-v7')"
            .to_owned());
    }
    level5::variables(bytes)
}

#[cfg(all(test, not(feature = "matlab73")))]
#[test]
fn what_was_left_out_is_named() {
    let message = matlab_sheets(HDF5_SIGNATURE, "f.mat").unwrap_err().to_string();
    assert!(message.starts_with("f.mat: is of MATLAB's version 7.3"), "{message}");
    assert!(message.contains("(feature \"matlab73\")"), "{message}");
}
