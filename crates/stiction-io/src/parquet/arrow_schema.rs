//! Arrow's metadata in a Parquet file, with units and the columns of durations.
//!
//! The key `ARROW:schema` holds a schema in Arrow's format for messages, a FlatBuffer in base64. Unreadable parts
//! count as absent, because the columns do not depend on them.

use std::collections::HashMap;

/// The schema's information on a column.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Field {
    pub(super) unit: Option<String>,
    /// Number of units per second, if the column holds durations.
    pub(super) durations_per_second: Option<i64>,
}

/// Numbers of Arrow's unions and enumerations.
const HEADER_SCHEMA: u8 = 1;
const TYPE_DURATION: u8 = 18;
/// A damaged schema may repeat the same field and pair endlessly, so only this many are read.
const MAX_FIELDS: usize = 4096;
const MAX_PAIRS: usize = 64;

const PER_SECOND: [i64; 4] = [1, 1_000, 1_000_000, 1_000_000_000];

/// The columns by name; empty if the schema cannot be read.
pub(super) fn fields(base64: &str) -> HashMap<String, Field> {
    decode(base64).and_then(|bytes| message(&bytes)).unwrap_or_default()
}

fn message(bytes: &[u8]) -> Option<HashMap<String, Field>> {
    // A continuation mark, missing in old files, and the length of the rest.
    let start = if bytes.starts_with(&[0xff; 4]) { 8 } else { 4 };
    let buffer = Buffer(bytes.get(start..)?);
    let message = buffer.root()?;
    if message.byte(1)? != HEADER_SCHEMA {
        return None;
    }
    let schema = message.table(2)?;
    let mut fields = HashMap::new();
    for field in schema.tables(1, MAX_FIELDS)? {
        let mut known = Field::default();
        if field.byte(2) == Some(TYPE_DURATION) {
            // If absent, it is milliseconds.
            let unit = field.table(3).and_then(|kind| kind.byte(0)).unwrap_or(1);
            known.durations_per_second = PER_SECOND.get(usize::from(unit)).copied();
        }
        for pair in field.tables(6, MAX_PAIRS).unwrap_or_default() {
            let is_unit = pair.text(0).is_some_and(|key| {
                key.eq_ignore_ascii_case("unit") || key.eq_ignore_ascii_case("units")
            });
            let unit = pair.text(1).map(str::trim).filter(|unit| is_unit && !unit.is_empty());
            known.unit = known.unit.or(unit.map(str::to_owned));
        }
        if let Some(name) = field.text(0) {
            fields.insert(name.to_owned(), known);
        }
    }
    Some(fields)
}

/// The bytes of a FlatBuffer.
#[derive(Clone, Copy)]
struct Buffer<'b>(&'b [u8]);

/// A table in a buffer, at its position.
#[derive(Clone, Copy)]
struct Table<'b>(Buffer<'b>, usize);

impl<'b> Buffer<'b> {
    fn bytes<const N: usize>(self, at: usize) -> Option<[u8; N]> {
        self.0.get(at..at.checked_add(N)?)?.try_into().ok()
    }

    fn u32(self, at: usize) -> Option<usize> {
        Some(u32::from_le_bytes(self.bytes(at)?) as usize)
    }

    /// The position that the offset at `at` points to.
    fn follow(self, at: usize) -> Option<usize> {
        at.checked_add(self.u32(at)?)
    }

    fn root(self) -> Option<Table<'b>> {
        Some(Table(self, self.follow(0)?))
    }
}

impl<'b> Table<'b> {
    /// The position of the field with this number, if the table has it.
    fn field(self, number: usize) -> Option<usize> {
        let Table(buffer, at) = self;
        let back = i64::from(i32::from_le_bytes(buffer.bytes(at)?));
        let index = usize::try_from(at as i64 - back).ok()?;
        let entry = 4 + 2 * number;
        if entry >= usize::from(u16::from_le_bytes(buffer.bytes(index)?)) {
            return None;
        }
        match u16::from_le_bytes(buffer.bytes(index + entry)?) {
            0 => None,
            offset => Some(at + usize::from(offset)),
        }
    }

    fn byte(self, number: usize) -> Option<u8> {
        self.0.bytes(self.field(number)?).map(|[byte]| byte)
    }

    fn table(self, number: usize) -> Option<Table<'b>> {
        Some(Table(self.0, self.0.follow(self.field(number)?)?))
    }

    /// The position of the first element of a vector, and the number of elements.
    fn vector(self, number: usize) -> Option<(usize, usize)> {
        let at = self.0.follow(self.field(number)?)?;
        Some((at + 4, self.0.u32(at)?))
    }

    fn text(self, number: usize) -> Option<&'b str> {
        let (at, length) = self.vector(number)?;
        std::str::from_utf8(self.0.0.get(at..at.checked_add(length)?)?).ok()
    }

    /// The first `most` tables of a vector, up to one that lies outside the buffer.
    fn tables(self, number: usize, most: usize) -> Option<Vec<Table<'b>>> {
        let (at, count) = self.vector(number)?;
        let table = |i: usize| Some(Table(self.0, self.0.follow(at + 4 * i)?));
        Some((0..count.min(most)).map_while(table).collect())
    }
}

/// Decodes the valid part of base64.
fn decode(text: &str) -> Option<Vec<u8>> {
    let digit = |c: u8| {
        Some(match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        })
    };
    let (mut bytes, mut bits, mut count) = (Vec::with_capacity(text.len() / 4 * 3), 0u32, 0);
    for c in text.trim_end_matches('=').bytes() {
        bits = bits << 6 | u32::from(digit(c)?);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    Some(bytes)
}
