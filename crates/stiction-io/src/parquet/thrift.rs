//! Thrift's compact protocol, in which Parquet writes its footer and page headers.
//!
//! Every length is checked against the remaining bytes, so the result is never larger than a fixed multiple of the
//! file.

/// How deep structs and lists may nest; Parquet needs six levels.
const MAX_DEPTH: usize = 24;

/// A value.
#[derive(Debug)]
pub(super) enum Value {
    Bool(bool),
    Int(i64),
    /// Text or a fractional number, which is not needed here.
    Other,
    List(Vec<Value>),
    Struct(Fields),
}

/// The fields of a struct by their numbers.
#[derive(Debug)]
pub(super) struct Fields(Vec<(i16, Value)>);

impl Fields {
    /// Reads a struct from the beginning of `bytes`, and returns its length in bytes.
    pub(super) fn read(bytes: &[u8]) -> Option<(Self, usize)> {
        let mut input = Input { bytes, at: 0 };
        let fields = input.fields(0)?;
        Some((fields, input.at))
    }

    /// The values of every field with this number. A well-formed struct has at most one.
    pub(super) fn all(&self, number: i16) -> impl Iterator<Item = &Value> {
        self.0.iter().filter(move |(n, _)| *n == number).map(|(_, value)| value)
    }

    fn get(&self, number: i16) -> Option<&Value> {
        self.all(number).next()
    }

    pub(super) fn int(&self, number: i16) -> Option<i64> {
        match self.get(number)? {
            Value::Int(value) => Some(*value),
            _ => None,
        }
    }

    /// A size or count: an integer that is not negative.
    pub(super) fn size(&self, number: i16) -> Option<usize> {
        self.int(number)?.try_into().ok()
    }

    pub(super) fn bool(&self, number: i16) -> Option<bool> {
        match self.get(number)? {
            Value::Bool(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn fields(&self, number: i16) -> Option<&Fields> {
        self.get(number)?.as_fields()
    }
}

impl Value {
    pub(super) fn as_fields(&self) -> Option<&Fields> {
        match self {
            Value::Struct(fields) => Some(fields),
            _ => None,
        }
    }

    pub(super) fn as_list(&self) -> &[Value] {
        match self {
            Value::List(items) => items,
            _ => &[],
        }
    }
}

struct Input<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl Input<'_> {
    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn skip(&mut self, count: usize) -> Option<Value> {
        self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(Value::Other)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn zigzag(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    fn fields(&mut self, depth: usize) -> Option<Fields> {
        let (mut fields, mut number) = (vec![], 0i16);
        loop {
            let header = self.byte()?;
            if header == 0 {
                return Some(Fields(fields));
            }
            number = match header >> 4 {
                0 => self.zigzag()?.try_into().ok()?,
                step => number.checked_add(step.into())?,
            };
            let value = match header & 0x0f {
                1 => Value::Bool(true),
                2 => Value::Bool(false),
                kind => self.value(kind, depth)?,
            };
            fields.push((number, value));
        }
    }

    fn value(&mut self, kind: u8, depth: usize) -> Option<Value> {
        if depth > MAX_DEPTH {
            return None;
        }
        Some(match kind {
            1 | 2 => Value::Bool(self.byte()? == 1),
            3 => Value::Int(i64::from(self.byte()? as i8)),
            4..=6 => Value::Int(self.zigzag()?),
            7 => self.skip(8)?,
            8 => {
                let length = self.varint()?.try_into().ok()?;
                self.skip(length)?
            }
            9 | 10 => {
                let header = self.byte()?;
                let count = match header >> 4 {
                    15 => self.varint()?,
                    count => count.into(),
                };
                // An element takes at least one byte.
                if count > (self.bytes.len() - self.at) as u64 {
                    return None;
                }
                let items = (0..count).map(|_| self.value(header & 0x0f, depth + 1));
                Value::List(items.collect::<Option<_>>()?)
            }
            12 => Value::Struct(self.fields(depth + 1)?),
            _ => return None,
        })
    }
}
