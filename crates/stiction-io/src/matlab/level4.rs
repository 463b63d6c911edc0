//! MATLAB's level 4 files (`save` with `-v4`, and older programs), little and big endian.
//!
//! After "MAT-File Format", The MathWorks. Each matrix has a header of five words: type, rows, columns, whether it is
//! complex, length of the name. The type is four decimal digits: byte order, 0, precision, and kind of the matrix.

use super::value::{Fields, Message, Value};
use crate::budget::Budget;

const HEADER: usize = 20;

/// Limit for the length of a name with its final zero.
const MAX_NAME: usize = 64;

struct Header {
    precision: u32,
    kind: u32,
    rows: usize,
    cols: usize,
    is_complex: bool,
    name: usize,
    big_endian: bool,
}

impl Header {
    fn read(bytes: &[u8]) -> Option<Self> {
        let words = bytes.get(..HEADER)?.as_chunks::<4>().0;
        [false, true].into_iter().find_map(|big_endian| {
            let word = |k: usize| match big_endian {
                true => u32::from_be_bytes(words[k]),
                false => u32::from_le_bytes(words[k]),
            };
            let (kind, name) = (word(0), word(4) as usize);
            let digits = [kind / 1000, kind / 100 % 10, kind / 10 % 10, kind % 10];
            let is_one = digits[0] == u32::from(big_endian)
                && digits[1] == 0
                && digits[2] <= 5
                && digits[3] <= 2;
            (is_one && word(3) <= 1 && (1..=MAX_NAME).contains(&name)).then(|| Self {
                precision: digits[2],
                kind: digits[3],
                rows: word(1) as usize,
                cols: word(2) as usize,
                is_complex: word(3) == 1,
                name,
                big_endian,
            })
        })
    }
}

/// Whether a file begins with a header of level 4 and a name.
pub(crate) fn is(bytes: &[u8]) -> bool {
    let name = |header: Header| bytes.get(HEADER..HEADER + header.name);
    let is_name =
        |name: &[u8]| name.iter().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | 0));
    Header::read(bytes)
        .and_then(name)
        .is_some_and(|name| is_name(name) && name[0].is_ascii_alphabetic())
}

/// The variables of a file.
pub(super) fn variables(bytes: &[u8]) -> Result<Fields, Message> {
    let mut budget = Budget::of(bytes.len());
    let (mut rest, mut variables): (&[u8], Fields) = (bytes, vec![]);
    while !rest.is_empty() {
        let at = bytes.len() - rest.len();
        let wrong = |what: &str| format!("{what} at byte {at}; save it with save(..., '-v7')");
        let header = Header::read(rest)
            .ok_or_else(|| wrong("is of MATLAB's version 4 and has no matrix"))?;
        let short = || wrong("is of MATLAB's version 4 and is cut short in the matrix");
        let width = [8, 4, 4, 2, 2, 1][header.precision as usize];
        let count = header.rows.checked_mul(header.cols).ok_or_else(short)?;
        let size = count.checked_mul(width).ok_or_else(short)?;
        let parts = if header.is_complex { 2 } else { 1 };
        let start = HEADER + header.name;
        let name = rest.get(HEADER..start).ok_or_else(short)?;
        let data = rest.get(start..).and_then(|data| data.get(..size)).ok_or_else(short)?;
        rest =
            size.checked_mul(parts).and_then(|size| rest.get(start + size..)).ok_or_else(short)?;
        budget.spend(count.saturating_mul(size_of::<f64>()))?;
        let number = |bytes: &[u8]| {
            let mut word = [0; 8];
            word[..width].copy_from_slice(bytes);
            if header.big_endian {
                word[..width].reverse();
            }
            let [a, b, c, d, ..] = word;
            match header.precision {
                0 => f64::from_le_bytes(word),
                1 => f32::from_le_bytes([a, b, c, d]).into(),
                2 => i32::from_le_bytes([a, b, c, d]).into(),
                3 => i16::from_le_bytes([a, b]).into(),
                4 => u16::from_le_bytes([a, b]).into(),
                _ => a.into(),
            }
        };
        let numbers = data.chunks_exact(width).map(number);
        let value = match header.kind {
            _ if header.is_complex => Value::Other("an array of complex numbers".to_owned()),
            0 => Value::numbers(header.rows, numbers.collect()),
            1 => {
                let characters =
                    numbers.map(|code| char::from_u32(code as u32).unwrap_or('\u{fffd}'));
                Value::characters(header.rows, &characters.collect::<Vec<_>>())
            }
            _ => Value::Other("a sparse array".to_owned()),
        };
        let name = name.split(|byte| *byte == 0).next().unwrap_or(name);
        variables.push((String::from_utf8_lossy(name).into_owned(), value));
    }
    Ok(variables)
}
