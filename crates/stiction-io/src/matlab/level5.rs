//! MATLAB's level 5 files (`save` with `-v6` or `-v7`), little and big endian.
//!
//! After "MAT-File Format", The MathWorks. A header of 128 bytes precedes data elements, each with a tag for its type
//! and size. Variables may be compressed with zlib.

use super::value::{Fields, MAX_DEPTH, Message, Value, utf16};
use crate::budget::Budget;
use std::io::Read;

const HEADER: usize = 128;

/// Types of data elements.
const INT8: u32 = 1;
const UINT8: u32 = 2;
const INT16: u32 = 3;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const SINGLE: u32 = 7;
const DOUBLE: u32 = 9;
const INT64: u32 = 12;
const UINT64: u32 = 13;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const UTF8: u32 = 16;
const UTF16: u32 = 17;
const UTF32: u32 = 18;

/// A flag of an array.
const COMPLEX: u32 = 0x0800;

/// Depth to which messages name the fields that lead to an error.
const MAX_NAMED: usize = 4;

/// Limit for names of fields. MATLAB's have at most 63 characters.
const MAX_NAME: usize = 1024;

/// The variables of a file.
pub(super) fn variables(bytes: &[u8]) -> Result<Fields, Message> {
    if bytes.is_empty() {
        return Err("is empty; a MATLAB file is needed".to_owned());
    }
    let big_endian = match bytes.get(126..HEADER) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        None if bytes.starts_with(b"MATLAB") => {
            return Err("is cut short within its header; copy or save it again".to_owned());
        }
        _ => {
            return Err("is not a MATLAB file; save it in MATLAB with save(..., '-v7')".to_owned());
        }
    };
    let mut budget = Budget::of(bytes.len());
    let mut input = Input { bytes: &bytes[HEADER..], big_endian };
    let mut variables: Fields = vec![];
    while !input.bytes.is_empty() {
        let at = bytes.len() - input.bytes.len();
        let place = |message: Message| match variables.last() {
            Some((name, _)) => format!("{message} (at byte {at}, after the variable \"{name}\")"),
            None => format!("{message} (at byte {at}, in its first variable)"),
        };
        let variable = variable(&mut input, &mut budget).map_err(place)?;
        // MATLAB keeps its objects in a variable without a name.
        variables.extend(variable.filter(|(name, _)| !name.is_empty()));
    }
    Ok(variables)
}

/// The next variable, if the element is one.
fn variable(
    input: &mut Input<'_>,
    budget: &mut Budget,
) -> Result<Option<(String, Value)>, Message> {
    let element = input.element()?;
    match element.kind {
        MATRIX => matrix(element.data, 0, budget).map(Some),
        COMPRESSED => {
            let mut bytes = vec![];
            let most = budget.left() as u64 + 1;
            flate2::read::ZlibDecoder::new(element.data.bytes)
                .take(most)
                .read_to_end(&mut bytes)
                .map_err(|e| format!("a variable cannot be decompressed: {e}; save it again"))?;
            budget.spend(bytes.len())?;
            let big_endian = element.data.big_endian;
            let inner = Input { bytes: &bytes, big_endian }.element()?;
            match inner.kind {
                MATRIX => matrix(inner.data, 0, budget).map(Some),
                _ => Ok(None),
            }
        }
        _ => Ok(None),
    }
}

/// Bytes from which elements are read.
#[derive(Clone, Copy)]
struct Input<'b> {
    bytes: &'b [u8],
    big_endian: bool,
}

/// A data element.
struct Element<'b> {
    kind: u32,
    data: Input<'b>,
}

impl<'b> Input<'b> {
    fn u32(&mut self) -> Option<u32> {
        let (word, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(if self.big_endian { u32::from_be_bytes(*word) } else { u32::from_le_bytes(*word) })
    }

    /// The next element, which must exist.
    fn element(&mut self) -> Result<Element<'b>, Message> {
        let short = || "is cut short; copy or save it again".to_owned();
        let (word, before) = (self.u32().ok_or_else(short)?, self.bytes);
        // A small element has its size in the upper half of the word, and its data in the next.
        let (kind, size, padded) = match word >> 16 {
            0 => {
                let size = self.u32().ok_or_else(short)? as usize;
                // Compressed elements are followed at once by the next.
                let padded = if word == COMPRESSED { size } else { size.next_multiple_of(8) };
                (word, size, padded)
            }
            size if size <= 4 => (word & 0xffff, size as usize, 4),
            _ => {
                return Err(
                    "is damaged: an element is of an unknown kind; save it again".to_owned()
                );
            }
        };
        let data = self.bytes.get(..size).ok_or_else(|| {
            let left = before.len();
            format!("is cut short: {size} bytes should follow, but {left} are left; copy it again")
        })?;
        // Some files lack the padding of the last element.
        self.bytes = self.bytes.get(padded..).unwrap_or_default();
        Ok(Element { kind, data: Input { bytes: data, ..*self } })
    }

    fn words<const N: usize>(self) -> impl Iterator<Item = [u8; N]> {
        self.bytes.as_chunks::<N>().0.iter().map(move |word| {
            let mut word = *word;
            if self.big_endian {
                word.reverse();
            }
            word
        })
    }
}

impl Element<'_> {
    /// Numbers; none if the element contains no numbers.
    fn numbers(&self) -> Option<Vec<f64>> {
        let data = self.data;
        Some(match self.kind {
            INT8 => data.bytes.iter().map(|b| f64::from(*b as i8)).collect(),
            UINT8 => data.bytes.iter().map(|b| f64::from(*b)).collect(),
            INT16 => data.words().map(|w| i16::from_le_bytes(w).into()).collect(),
            UINT16 => data.words().map(|w| u16::from_le_bytes(w).into()).collect(),
            INT32 => data.words().map(|w| i32::from_le_bytes(w).into()).collect(),
            UINT32 => data.words().map(|w| u32::from_le_bytes(w).into()).collect(),
            INT64 => data.words().map(|w| i64::from_le_bytes(w) as f64).collect(),
            UINT64 => data.words().map(|w| u64::from_le_bytes(w) as f64).collect(),
            SINGLE => data.words().map(|w| f32::from_le_bytes(w).into()).collect(),
            DOUBLE => data.words().map(f64::from_le_bytes).collect(),
            _ => return None,
        })
    }

    /// Characters; none if the element contains no characters.
    fn characters(&self) -> Option<Vec<char>> {
        let data = self.data;
        Some(match self.kind {
            UTF8 => String::from_utf8_lossy(data.bytes).chars().collect(),
            INT8 | UINT8 => data.bytes.iter().map(|b| char::from(*b)).collect(),
            UINT16 | UTF16 => utf16(data.words().map(u16::from_le_bytes)),
            UTF32 => data
                .words()
                .map(|w| char::from_u32(u32::from_le_bytes(w)).unwrap_or('\u{fffd}'))
                .collect(),
            _ => return None,
        })
    }

    /// Bytes as a name.
    fn name(&self) -> String {
        let end = self.data.bytes.iter().position(|b| *b == 0).unwrap_or(self.data.bytes.len());
        String::from_utf8_lossy(&self.data.bytes[..end]).trim().to_owned()
    }
}

/// Name and value of an array.
fn matrix(
    mut input: Input<'_>,
    depth: usize,
    budget: &mut Budget,
) -> Result<(String, Value), Message> {
    if input.bytes.is_empty() {
        return Ok((String::new(), Value::empty()));
    }
    if depth > MAX_DEPTH {
        return Err(format!("has structs or cells nested deeper than {MAX_DEPTH}; flatten it"));
    }
    budget.spend(input.bytes.len())?;
    let flags =
        input.element()?.data.u32().ok_or("is damaged: a class is missing; save it again")?;
    let class = flags & 0xff;
    if class == 17 {
        // An opaque object has no dimensions, only its system and its class.
        let (name, _system, class) = (input.element()?, input.element()?, input.element()?);
        return Ok((name.name(), Value::object(&class.name())));
    }
    let dimensions = input.element()?.numbers().unwrap_or_default();
    let dimensions: Vec<usize> = dimensions.into_iter().map(|n| n.max(0.0) as usize).collect();
    let count = dimensions.iter().try_fold(1usize, |product, n| product.checked_mul(*n));
    let (rows, count) = match (dimensions.first(), count) {
        (Some(rows), Some(count)) => (*rows, count),
        _ => return Err("is damaged: an array has impossible dimensions; save it again".to_owned()),
    };
    let name = input.element()?.name();
    // Nested arrays have no names of their own, and are identified by their variable.
    let within = |message: Message| match depth {
        0 => format!("{message}, in \"{name}\""),
        _ => message,
    };
    let value = match class {
        1 => cells(input, count, depth, budget).map_err(within)?,
        2 => structs(input, count, depth, budget).map_err(within)?,
        3 => Value::object(&input.element()?.name()),
        4 => {
            let element = if count == 0 { None } else { Some(input.element()?) };
            let characters =
                element.map(|e| e.characters().ok_or("is damaged: a text is stored as numbers"));
            Value::characters(rows, &characters.transpose()?.unwrap_or_default())
        }
        5 => Value::Other("a sparse array".to_owned()),
        6..=15 if flags & COMPLEX != 0 => Value::Other("an array of complex numbers".to_owned()),
        6..=15 if count == 0 => Value::empty(),
        6..=15 => {
            let data = input.element()?;
            let data =
                data.numbers().ok_or("is damaged: an array has no numbers; save it again")?;
            if data.len() != count {
                let found = data.len();
                return Err(format!(
                    "is damaged: \"{name}\" has {found} of its {count} numbers; save it again"
                ));
            }
            budget.spend(count * size_of::<f64>())?;
            Value::numbers(rows, data)
        }
        16 => Value::Other("a function".to_owned()),
        _ => Value::Other("of an unknown class".to_owned()),
    };
    Ok((name, value))
}

/// The value of an array within an array.
fn nested(input: &mut Input<'_>, depth: usize, budget: &mut Budget) -> Result<Value, Message> {
    let element = input.element()?;
    match element.kind {
        MATRIX => matrix(element.data, depth + 1, budget).map(|(_, value)| value),
        _ => Err("is damaged: a cell or field is not an array; save it again".to_owned()),
    }
}

/// `count` or the number of elements that the bytes can hold, so that a loop ends soon.
fn backed(count: usize, bytes: &[u8]) -> Result<usize, Message> {
    if count <= bytes.len() / 8 {
        return Ok(count);
    }
    Err(format!("is damaged: {count} cells or structs do not fit into its bytes; save it again"))
}

fn cells(
    mut input: Input<'_>,
    count: usize,
    depth: usize,
    budget: &mut Budget,
) -> Result<Value, Message> {
    let count = backed(count, input.bytes)?;
    budget.spend(count * size_of::<Value>())?;
    let cells = (0..count).map(|_| nested(&mut input, depth, budget));
    Ok(Value::Cell(cells.collect::<Result<_, _>>()?))
}

fn structs(
    mut input: Input<'_>,
    count: usize,
    depth: usize,
    budget: &mut Budget,
) -> Result<Value, Message> {
    let width = input.element()?.data.u32().unwrap_or(0) as usize;
    let names = input.element()?;
    if !(1..=MAX_NAME).contains(&width) {
        if names.data.bytes.is_empty() {
            return Ok(Value::Structs(vec![]));
        }
        return Err("is damaged: a struct has fields without names; save it again".to_owned());
    }
    let name = |bytes| Element { kind: INT8, data: Input { bytes, ..names.data } }.name();
    let names: Vec<String> = names.data.bytes.chunks_exact(width).map(name).collect();
    if names.is_empty() {
        return Ok(Value::Structs(vec![]));
    }
    backed(count.saturating_mul(names.len()), input.bytes)?;
    let mut structs = vec![];
    for _ in 0..count {
        let mut fields = vec![];
        for name in &names {
            budget.spend(name.len() + size_of::<(String, Value)>())?;
            let value = nested(&mut input, depth, budget);
            let value = value.map_err(|message| match depth {
                0..MAX_NAMED => format!("{message}, in the field \"{name}\""),
                _ => message,
            })?;
            fields.push((name.clone(), value));
        }
        structs.push(fields);
    }
    Ok(Value::Structs(structs))
}
