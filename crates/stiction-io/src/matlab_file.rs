//! Sheets from MATLAB files.
//!
//! A file is read into a tree of values first, whichever version it is of: level 5 (`-v6`, `-v7`) by
//! `level5`, version 7.3, which is HDF5, by `hdf5`. Then `sheets` finds the sheets in the tree.

mod hdf5;
mod level5;
mod links;
mod sheets;

use crate::error::{Error, Result};
use crate::sheet::Sheet;

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
/// If the file is cut short, damaged, of version 4, or has no vectors.
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
        return hdf5::variables(bytes);
    }
    level5::variables(bytes)
}

/// What is wrong, in a sentence.
type Message = String;

/// Names and what they stand for, in the order of the file.
type Fields = Vec<(String, Value)>;

/// How deep structs and cells may nest.
const MAX_DEPTH: usize = 48;

/// A value of MATLAB.
#[derive(Debug, Clone, PartialEq)]
enum Value {
    /// A matrix of numbers, column by column. Arrays of more dimensions have the product of all but
    /// the first as columns.
    Numbers { rows: usize, cols: usize, data: Vec<f64> },
    /// A row of characters.
    Text(String),
    /// A cell array, column by column; also the rows of a matrix of characters.
    Cell(Vec<Value>),
    /// An array of structs, most often one.
    Structs(Vec<Fields>),
    /// What is not read: what it is, with an article.
    Other(String),
}

impl Value {
    /// Nothing: `[]`.
    fn empty() -> Self {
        Self::Numbers { rows: 0, cols: 0, data: vec![] }
    }

    /// A matrix of `rows` rows, or nothing where `data` do not fill them.
    fn numbers(rows: usize, data: Vec<f64>) -> Self {
        if rows == 0 || !data.len().is_multiple_of(rows) {
            return Self::empty();
        }
        Self::Numbers { rows, cols: data.len() / rows, data }
    }

    /// A matrix of characters with `rows` rows, which is text if there is but one.
    fn characters(rows: usize, characters: &[char]) -> Self {
        if rows <= 1 || characters.is_empty() || !characters.len().is_multiple_of(rows) {
            return Self::Text(characters.iter().collect::<String>().trim_end().to_owned());
        }
        let row = |row: usize| {
            let text: String = characters.iter().skip(row).step_by(rows).collect();
            Self::Text(text.trim_end().to_owned())
        };
        Self::Cell((0..rows).map(row).collect())
    }

    /// An object of a class, which is never read.
    fn object(class: &str) -> Self {
        match class {
            "table" | "timetable" => Self::Other(format!(
                "a {class}, which only MATLAB reads (use writetable or writetimetable, or save \
                 table2struct(..., 'ToScalar', true))"
            )),
            "" => Self::Other("an object".to_owned()),
            _ => Self::Other(format!("an object of class {class}")),
        }
    }
}

/// The characters of UTF-16.
fn utf16(units: impl Iterator<Item = u16>) -> Vec<char> {
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}
