//! Sheets from Parquet files.
//!
//! The `parquet` crate knows the schema and the encodings of values. What it would believe without
//! having seen it, sizes and counts, is checked here first: the footer in `check_footer`, pages in
//! `pages`.

mod arrow_schema;
mod pages;
mod thrift;

use crate::budget::{Budget, guarded};
use crate::error::{Error, Result};
use crate::sheet::{Cells, Column, Sheet};
use arrow_schema::Field;
use bytes::Bytes;
use pages::Pages;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType, FixedLenByteArray, Int96};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use parquet::schema::types::ColumnDescriptor;

const MAGIC: &[u8] = b"PAR1";
const MAGIC_ENCRYPTED: &[u8] = b"PARE";

/// Keys of a file whose values are for programs, not readers.
const PROGRAMS_KEYS: [&str; 2] = ["ARROW:schema", "pandas"];

/// Bytes that every cell takes, and a text at least.
const CELL: usize = size_of::<f64>();

/// Rows that are decoded at a time.
const BATCH: usize = 8192;

/// How deep columns may nest before the file is refused, which happens for the first level anyway.
const MAX_SCHEMA_DEPTH: usize = 32;

/// The table in a Parquet file, as one sheet; `origin` names the file in errors.
///
/// Numbers of all kinds, and true and false as 1 and 0, are numbers; durations and times of day are
/// numbers in s. Dates and timestamps are times. Units come from the metadata of Arrow's fields
/// (`unit` or `units`), attributes from that of the file. Pages may be compressed with Snappy, GZIP,
/// Brotli, Zstandard or LZ4 (raw).
///
/// # Errors
/// If the file is cut short, damaged or encrypted, has no columns, or a column is nested, binary or
/// in an encoding that is not read.
///
/// # Limits
/// A file that would take more than 64 MiB and 256 times its size, or more than 4 GiB, is refused by what its
/// footer announces.
pub fn parquet_sheets(bytes: &[u8], origin: &str) -> Result<Vec<Sheet>> {
    match sheet(bytes, origin) {
        Ok(sheet) => Ok(vec![sheet]),
        Err(message) => Err(Error::Table { origin: origin.to_owned(), message }),
    }
}

/// What is wrong, in a sentence.
type Message = String;

fn sheet(bytes: &[u8], origin: &str) -> std::result::Result<Sheet, Message> {
    let footer = footer(bytes)?;
    check_footer(footer)?;
    let metadata = decoded(|| ParquetMetaDataReader::decode_metadata(footer))
        .map_err(|e| format!("its footer is damaged ({e}); write the file again"))?;
    let mut sheet = Sheet { origin: origin.to_owned(), ..Sheet::default() };
    let mut fields = Default::default();
    for pair in metadata.file_metadata().key_value_metadata().into_iter().flatten() {
        let Some(value) = &pair.value else { continue };
        if pair.key == "ARROW:schema" {
            fields = arrow_schema::fields(value);
        }
        if !PROGRAMS_KEYS.contains(&pair.key.as_str()) {
            sheet.attributes.push((pair.key.clone(), value.clone()));
        }
    }
    let file = Bytes::copy_from_slice(bytes);
    let mut budget = Budget::of(bytes.len());
    // The footer says how many cells there are: what is too much is refused before any is decoded.
    budget.spend(cells(&metadata).saturating_mul(CELL))?;
    for (index, column) in metadata.file_metadata().schema_descr().columns().iter().enumerate() {
        let name = column.path().string();
        if column.path().parts().len() > 1 || column.max_rep_level() > 0 {
            return Err(format!(
                "column \"{name}\" is nested or a list; write the file without it, or with one \
                 number or text a row"
            ));
        }
        let field = fields.remove(&name).unwrap_or_default();
        let kind = Kind::of(column, &field)
            .map_err(|what| format!("column \"{name}\" {what}; write the file without it"))?;
        let cells = decoded(|| read_column(&file, &metadata, index, &kind, &mut budget));
        let cells = cells.map_err(|e| format!("column \"{name}\" cannot be read: {e}"))?;
        let unit = match kind {
            Kind::Seconds { .. } => Some("s".to_owned()),
            _ => field.unit,
        };
        sheet.columns.push(Column { name: name.trim().to_owned(), unit, cells });
    }
    if sheet.columns.is_empty() {
        return Err("has no columns; write at least one".to_owned());
    }
    Ok(sheet)
}

/// How many cells the footer announces.
fn cells(metadata: &ParquetMetaData) -> usize {
    let rows = metadata.row_groups().iter().map(|group| group.num_rows().max(0) as usize);
    let columns = metadata.file_metadata().schema_descr().num_columns();
    rows.fold(0usize, usize::saturating_add).saturating_mul(columns)
}

/// What the parquet crate makes of something.
fn decoded<T>(
    decode: impl FnOnce() -> parquet::errors::Result<T>,
) -> std::result::Result<T, Message> {
    match guarded(decode) {
        Some(Ok(value)) => Ok(value),
        Some(Err(ParquetError::General(message))) => Err(message),
        Some(Err(other)) => Err(other.to_string()),
        None => Err("its bytes contradict each other; the file is damaged".to_owned()),
    }
}

/// The bytes of the footer: schema, and where the pages are.
fn footer(bytes: &[u8]) -> std::result::Result<&[u8], Message> {
    if bytes.is_empty() {
        return Err("is empty; a Parquet file is needed".to_owned());
    }
    let encrypted = "is encrypted, which is not read; write it without encryption";
    if bytes.starts_with(MAGIC_ENCRYPTED) {
        return Err(encrypted.to_owned());
    }
    if !bytes.starts_with(MAGIC) {
        return Err("is not a Parquet file, which begins with \"PAR1\"".to_owned());
    }
    let short = "is cut short: a Parquet file ends with \"PAR1\"; copy or write it again";
    let body = match bytes.strip_suffix(MAGIC) {
        Some(body) if bytes.len() >= 12 => body,
        _ => return Err(short.to_owned()),
    };
    let Some((rest, length)) = body.split_last_chunk() else { return Err(short.to_owned()) };
    let length = u32::from_le_bytes(*length) as usize;
    rest.len()
        .checked_sub(length)
        .filter(|start| *start >= MAGIC.len())
        .map(|start| &rest[start..])
        .ok_or_else(|| {
            format!("says its footer has {length} bytes, which is more than it has; write it again")
        })
}

/// Refuses a footer that would make the parquet crate allocate what the file does not back, or
/// recurse without end.
fn check_footer(footer: &[u8]) -> std::result::Result<(), Message> {
    let damaged = || "its footer is damaged; write the file again".to_owned();
    let (fields, _) = thrift::Fields::read(footer).ok_or_else(damaged)?;
    if fields.fields(8).is_some() {
        return Err("is encrypted, which is not read; write it without encryption".to_owned());
    }
    for schema in fields.all(2) {
        let mut elements = schema.as_list().iter();
        // How many children are still to come, on every level.
        let mut open = vec![1usize];
        while let Some(level) = open.last_mut() {
            if *level == 0 {
                open.pop();
                continue;
            }
            *level -= 1;
            let element = elements.next().and_then(thrift::Value::as_fields).ok_or_else(damaged)?;
            // The crate takes the last of several fields of one number.
            let children = element.all(5).map(|value| match value {
                thrift::Value::Int(count) => usize::try_from(*count).unwrap_or(usize::MAX),
                _ => usize::MAX,
            });
            let children = children.max().unwrap_or(0);
            if children > elements.len() || open.len() > MAX_SCHEMA_DEPTH {
                return Err(damaged());
            }
            open.push(children);
        }
        if elements.next().is_some() {
            return Err(damaged());
        }
    }
    let chunks = fields.all(4).flat_map(|groups| groups.as_list());
    let chunks = chunks.filter_map(|group| group.as_fields()).flat_map(|group| group.all(1));
    for chunk in chunks.flat_map(|columns| columns.as_list()) {
        let encrypted = chunk.as_fields().is_some_and(|c| c.fields(8).is_some());
        if encrypted {
            return Err(
                "has encrypted columns, which are not read; write it without encryption".to_owned()
            );
        }
    }
    Ok(())
}

/// What the values of a column mean.
enum Kind {
    /// Numbers, to be divided by this power of ten.
    Number { digits: i32, unsigned: bool },
    /// A half-precision number in two bytes.
    Half,
    /// Durations or times of day, so many to the second.
    Seconds { per_second: i64 },
    /// Times since 1970, so many to the second.
    Time { per_second: i64, utc: bool },
    /// Days since 1970.
    Date,
    /// Text.
    Text,
}

impl Kind {
    fn of(column: &ColumnDescriptor, field: &Field) -> std::result::Result<Self, &'static str> {
        let number = Self::Number { digits: 0, unsigned: false };
        let per_second = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1_000,
            TimeUnit::MICROS => 1_000_000,
            TimeUnit::NANOS => 1_000_000_000,
        };
        if let Some(per_second) = field.durations_per_second
            && column.physical_type() == Type::INT64
        {
            return Ok(Self::Seconds { per_second });
        }
        Ok(match column.logical_type_ref() {
            Some(LogicalType::Integer(int)) => Self::Number { digits: 0, unsigned: !int.is_signed },
            Some(LogicalType::Decimal(decimal)) => {
                Self::Number { digits: decimal.scale, unsigned: false }
            }
            Some(LogicalType::Timestamp(time)) => {
                let utc = time.is_adjusted_to_u_t_c;
                Self::Time { per_second: per_second(&time.unit), utc }
            }
            Some(LogicalType::Time(time)) => Self::Seconds { per_second: per_second(&time.unit) },
            Some(LogicalType::Date) => Self::Date,
            Some(LogicalType::String | LogicalType::Enum | LogicalType::Json) => Self::Text,
            Some(LogicalType::Float16) => Self::Half,
            Some(LogicalType::Unknown) => number,
            Some(LogicalType::Uuid) => return Err("holds identifiers (UUID)"),
            Some(_) => return Err("is of a type that holds neither numbers, text nor times"),
            None => match column.converted_type() {
                ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64 => Self::Number { digits: 0, unsigned: true },
                ConvertedType::DECIMAL => {
                    Self::Number { digits: column.type_scale(), unsigned: false }
                }
                // Before it could be said otherwise, timestamps were UTC.
                ConvertedType::TIMESTAMP_MILLIS => Self::Time { per_second: 1_000, utc: true },
                ConvertedType::TIMESTAMP_MICROS => Self::Time { per_second: 1_000_000, utc: true },
                ConvertedType::TIME_MILLIS => Self::Seconds { per_second: 1_000 },
                ConvertedType::TIME_MICROS => Self::Seconds { per_second: 1_000_000 },
                ConvertedType::DATE => Self::Date,
                ConvertedType::INTERVAL => return Err("holds intervals of months and days"),
                _ => match column.physical_type() {
                    Type::INT96 => Self::Time { per_second: 1_000_000_000, utc: false },
                    Type::BYTE_ARRAY => Self::Text,
                    Type::FIXED_LEN_BYTE_ARRAY => return Err("is binary"),
                    _ => number,
                },
            },
        })
    }

    /// What an integer of the column means, once it is widened as its sign demands.
    fn integer(&self, value: i64) -> f64 {
        match *self {
            Self::Number { digits, unsigned: true } => value as u64 as f64 / 10f64.powi(digits),
            Self::Number { digits, .. } => value as f64 / 10f64.powi(digits),
            Self::Seconds { per_second } | Self::Time { per_second, .. } => {
                // Whole seconds apart: not all nanoseconds since 1970 fit into a number.
                let (whole, part) = (value.div_euclid(per_second), value.rem_euclid(per_second));
                whole as f64 + part as f64 / per_second as f64
            }
            Self::Date => value as f64 * 86_400.0,
            Self::Half | Self::Text => f64::NAN,
        }
    }

    fn is_unsigned(&self) -> bool {
        matches!(self, Self::Number { unsigned: true, .. })
    }

    /// What the bytes of a cell mean, if they are a number.
    fn bytes(&self, bytes: &[u8]) -> parquet::errors::Result<f64> {
        match (self, bytes) {
            (Self::Half, [low, high]) => Ok(half(u16::from_le_bytes([*low, *high]))),
            // Decimals are big-endian in two's complement.
            (Self::Number { digits, .. }, [first, rest @ ..]) => {
                let first = f64::from(*first as i8);
                let whole = rest.iter().fold(first, |sum, byte| sum * 256.0 + f64::from(*byte));
                Ok(whole / 10f64.powi(*digits))
            }
            _ => Err(ParquetError::General(format!("a number of {} bytes", bytes.len()))),
        }
    }

    /// Numbers of the column, as its cells.
    fn cells(&self, numbers: Vec<f64>) -> Cells {
        match *self {
            Self::Time { utc, .. } => Cells::Times { seconds: numbers, utc },
            Self::Date => Cells::Times { seconds: numbers, utc: false },
            _ => Cells::Numbers(numbers),
        }
    }
}

/// A half-precision number.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    match exponent {
        0 => sign * fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => sign * f64::INFINITY,
        31 => f64::NAN,
        _ => sign * (1.0 + fraction / 1024.0) * 2f64.powi(exponent - 15),
    }
}

/// The cells of the column at `index`.
fn read_column(
    file: &Bytes,
    metadata: &ParquetMetaData,
    index: usize,
    kind: &Kind,
    budget: &mut Budget,
) -> parquet::errors::Result<Cells> {
    let (mut numbers, mut text) = (vec![], vec![]);
    for group in metadata.row_groups() {
        let chunk = group.columns().get(index).ok_or_else(|| {
            ParquetError::General("a part of the file does not have it".to_owned())
        })?;
        if chunk.file_path().is_some() {
            return Err(ParquetError::General("it is kept in another file".to_owned()));
        }
        let rows = usize::try_from(group.num_rows()).ok();
        let rows =
            rows.ok_or_else(|| ParquetError::General("its rows are no number".to_owned()))?;
        let pages = Box::new(Pages::new(file, chunk, budget.most())?);
        let out = &mut numbers;
        match get_column_reader(chunk.column_descr_ptr(), pages) {
            ColumnReader::BoolColumnReader(reader) => {
                push(reader, rows, out, |v| Ok(f64::from(u8::from(*v))))?;
            }
            ColumnReader::Int32ColumnReader(reader) => push(reader, rows, out, |v| {
                let unsigned = kind.is_unsigned();
                Ok(kind.integer(if unsigned { (*v as u32).into() } else { (*v).into() }))
            })?,
            ColumnReader::Int64ColumnReader(reader) => {
                push(reader, rows, out, |v| Ok(kind.integer(*v)))?;
            }
            ColumnReader::Int96ColumnReader(reader) => {
                push(reader, rows, out, |v| Ok(int96(v)))?;
            }
            ColumnReader::FloatColumnReader(reader) => {
                push(reader, rows, out, |v| Ok(f64::from(*v)))?;
            }
            ColumnReader::DoubleColumnReader(reader) => {
                push(reader, rows, out, |v| Ok(*v))?;
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                push(reader, rows, out, |v: &FixedLenByteArray| kind.bytes(v.data()))?;
            }
            ColumnReader::ByteArrayColumnReader(reader) => match kind {
                Kind::Text => {
                    let cell = |v: Option<&ByteArray>| {
                        let value = v.map_or(Ok(""), |v| v.as_utf8());
                        let value = value.map_err(|_| {
                            let what =
                                "a cell is not UTF-8 text; write the file without the column";
                            ParquetError::General(what.to_owned())
                        })?;
                        let bytes = value.len() + size_of::<String>() - CELL;
                        budget.spend(bytes).map_err(ParquetError::General)?;
                        text.push(value.to_owned());
                        Ok(())
                    };
                    read(reader, rows, cell)?;
                }
                _ => push(reader, rows, out, |v| kind.bytes(v.data()))?,
            },
        }
    }
    Ok(match kind {
        Kind::Text => Cells::Text(text),
        _ => kind.cells(numbers),
    })
}

/// The time in an old timestamp: ns of the day, and the Julian day.
fn int96(value: &Int96) -> f64 {
    let &[low, high, day] = value.data() else { return f64::NAN };
    let nanoseconds = u64::from(high) << 32 | u64::from(low);
    (f64::from(day) - 2_440_588.0) * 86_400.0 + nanoseconds as f64 / 1e9
}

/// Appends the `rows` cells of `reader` to `out`, each as `number` sees it, NaN where there is none.
fn push<T: DataType>(
    reader: ColumnReaderImpl<T>,
    rows: usize,
    out: &mut Vec<f64>,
    number: impl Fn(&T::T) -> parquet::errors::Result<f64>,
) -> parquet::errors::Result<()> {
    read(reader, rows, |value| {
        out.push(value.map_or(Ok(f64::NAN), &number)?);
        Ok(())
    })
}

/// Hands the `rows` cells of `reader` to `cell`.
fn read<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    mut cell: impl FnMut(Option<&T::T>) -> parquet::errors::Result<()>,
) -> parquet::errors::Result<()> {
    let (mut values, mut levels) = (vec![], vec![]);
    let mut left = rows;
    while left > 0 {
        values.clear();
        levels.clear();
        let (count, ..) =
            reader.read_records(left.min(BATCH), Some(&mut levels), None, &mut values)?;
        if count == 0 {
            let found = rows - left;
            return Err(ParquetError::General(format!(
                "it has {found} of the {rows} cells it should have; the file is cut short"
            )));
        }
        left -= count;
        // Columns without nulls have no levels.
        let mut given = values.iter();
        for i in 0..count {
            let present = levels.get(i).is_none_or(|level| *level > 0);
            let value = if present { given.next() } else { None };
            cell(value)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::metadata::{
        ColumnChunkMetaData, FileMetaData, ParquetMetaDataWriter, RowGroupMetaData,
    };
    use parquet::schema::parser::parse_message_type;
    use parquet::schema::types::SchemaDescriptor;
    use std::sync::Arc;

    /// A file of some bytes that announces a billion rows, as one of nulls alone can.
    #[test]
    fn what_is_announced_and_too_much_is_not_decoded() {
        let schema = "message m { optional double t; optional double op; }";
        let schema = parse_message_type(schema).expect("a schema");
        let schema = Arc::new(SchemaDescriptor::new(Arc::new(schema)));
        let rows = 1_000_000_000;
        let column =
            |i| ColumnChunkMetaData::builder(schema.column(i)).set_num_values(rows).build();
        let group = RowGroupMetaData::builder(Arc::clone(&schema))
            .set_num_rows(rows)
            .set_column_metadata(vec![column(0).expect("a column"), column(1).expect("another")])
            .build()
            .expect("a group");
        let file = FileMetaData::new(2, rows, None, None, Arc::clone(&schema), None);
        let metadata = ParquetMetaData::new(file, vec![group]);
        let mut bytes = MAGIC.to_vec();
        ParquetMetaDataWriter::new(&mut bytes, &metadata).finish().expect("a footer");
        let message = parquet_sheets(&bytes, "f.parquet").unwrap_err().to_string();
        assert!(message.starts_with("f.parquet: would take more than 64 MiB"), "{message}");
    }
}
