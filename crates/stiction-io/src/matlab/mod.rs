//! Sheets from MATLAB files.
//!
//! A file is first read into a tree of values, level 4 (`-v4`) by `level4`, level 5 (`-v6`, `-v7`) by `level5` and
//! version 7.3, which is HDF5, by `hdf5`. Then `sheets` finds the sheets in the tree, and the sheets of Simulink with
//! `simulink`.

#[cfg(feature = "matlab73")]
mod hdf5;
pub(crate) mod level4;
mod level5;
#[cfg(feature = "matlab73")]
mod links;
mod sheets;
mod simulink;
mod value;

use crate::error::{Error, Result};
use crate::sheet::Sheet;
use value::{Fields, Message};

/// The first bytes of every HDF5 file, or the bytes after a block of 512 bytes that MATLAB writes.
const HDF5_SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
const HDF5_OFFSETS: [usize; 3] = [0, 512, 1024];

/// The sheets in a MATLAB file. `origin` is the name of the file in errors.
///
/// Every struct, at any depth, with vectors of equal length is a sheet. Its `part` is the path to the struct, such as
/// `cdata.chemicals.loop2`. Vectors that are variables form a sheet without a part. Vectors, rows of text and cell
/// arrays of text become columns. A matrix of at most 64 columns becomes `data(:,1)`, `data(:,2)`, ..., or has the
/// names in `colheaders`, `names` or `tags` beside it. A number `Ts`, `dt` or similar is the sampling time. Other
/// numbers and text are attributes. A set point `SP` that is a single number is both an attribute and a constant
/// column. Vectors of unusual length, and other data that make no column, are `left_out` with the reason. If no
/// vectors have equal length, single vectors count.
///
/// A struct that Simulink logs ("Structure With Time" or "Structure") is a sheet, whose columns are named by the labels
/// of its signals, or else by their blocks. If several columns have one name, a number follows it, as in `PV(2)`.
///
/// MATLAB dates (days since the year 0) are left unchanged. The attribute `datenum` names the column that looks like
/// such dates.
///
/// # Errors
/// If the file is cut short, damaged, or has no vectors. If it is of version 7.3 and this library was
/// built without the feature `matlab73`.
///
/// # Limits
/// Sparse and complex arrays, function handles and objects, including tables and timetables, are left out. Links to
/// other files are also left out and never followed. In files of version 7.3 fields come in the order of their names.
pub fn matlab_sheets(bytes: &[u8], origin: &str) -> Result<Vec<Sheet>> {
    variables(bytes)
        .and_then(|variables| sheets::find(&variables, origin))
        .map_err(|message| Error::Table { origin: origin.to_owned(), message })
}

/// The variables of a file of any version.
fn variables(bytes: &[u8]) -> std::result::Result<Fields, Message> {
    let is_hdf5 = |at: usize| bytes.get(at..).is_some_and(|b| b.starts_with(HDF5_SIGNATURE));
    if HDF5_OFFSETS.into_iter().any(is_hdf5) {
        #[cfg(feature = "matlab73")]
        return hdf5::variables(bytes);
        #[cfg(not(feature = "matlab73"))]
        return Err("is of MATLAB's version 7.3, which this program was built without (feature \"matlab73\"); save it \
            with save(..., '-v7')"
            .to_owned());
    }
    if level4::is(bytes) {
        return level4::variables(bytes);
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
