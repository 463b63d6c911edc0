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
use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType, FixedLenByteArray, Int96};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaDataReader, RowGroupMetaData};
use parquet::file::statistics::Statistics;
use parquet::schema::types::{ColumnDescPtr, ColumnDescriptor};
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const MAGIC: &[u8] = b"PAR1";
const MAGIC_ENCRYPTED: &[u8] = b"PARE";

/// The length of the footer and the mark, which end a file.
const TAIL: usize = 8;

/// Bytes that are read from the end at once: most footers are shorter.
const LIKELY_FOOTER: usize = 64 << 10;

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
    let file = ParquetFile::of(Source::Memory(Bytes::copy_from_slice(bytes)), origin)?;
    let groups: Vec<usize> = (0..file.groups.len()).collect();
    let columns: Vec<usize> = (0..file.columns.len()).collect();
    Ok(vec![file.sheet(&columns, &groups)?])
}

/// What is wrong, in a sentence.
type Message = String;

/// Where the bytes of a file are.
#[derive(Debug)]
enum Source {
    Memory(Bytes),
    Disk(PathBuf),
}

/// A Parquet file of which the footer was read: its columns and row groups can be read apart.
#[derive(Debug)]
pub struct ParquetFile {
    source: Source,
    origin: String,
    bytes: usize,
    columns: Vec<Described>,
    attributes: Vec<(String, String)>,
    groups: Vec<Group>,
}

/// A column, as the footer tells it.
#[derive(Debug)]
struct Described {
    name: String,
    unit: Option<String>,
    kind: Kind,
    descriptor: ColumnDescPtr,
}

/// A row group, as the footer tells it.
#[derive(Debug)]
struct Group {
    rows: usize,
    chunks: Vec<Chunk>,
}

/// Where the pages of a column of a row group are.
#[derive(Debug)]
struct Chunk {
    start: u64,
    size: usize,
    compression: Compression,
    holds: Holds,
}

/// What the footer tells of the cells of a column of a row group.
#[derive(Debug, Clone, PartialEq)]
pub enum Holds {
    /// Nothing.
    Unknown,
    /// All are this word.
    Word(Arc<str>),
    /// All are times from this one to that, s since 1970-01-01.
    Times(f64, f64),
}

impl ParquetFile {
    /// Whether the file at `path` begins as Parquet does.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn is_one(path: &Path) -> Result<bool> {
        let mut head = vec![];
        let read = File::open(path).and_then(|file| file.take(4).read_to_end(&mut head));
        read.map_err(|source| Error::File { path: path.display().to_string(), source })?;
        Ok(head == MAGIC)
    }

    /// Reads the footer of the file at `path`.
    ///
    /// # Errors
    /// As for [`parquet_sheets`], as far as the footer tells.
    pub fn open(path: &Path) -> Result<Self> {
        Self::of(Source::Disk(path.to_owned()), &path.display().to_string())
    }

    fn of(source: Source, origin: &str) -> Result<Self> {
        let refused = |message| Error::Table { origin: origin.to_owned(), message };
        let (head, tail, bytes) = source.ends(origin)?;
        let footer = match footer_length(&head, &tail, bytes).map_err(refused)? {
            length if length + TAIL <= tail.len() => tail.slice(tail.len() - TAIL - length..),
            length => source.bytes((bytes - TAIL - length) as u64, length + TAIL, origin)?,
        };
        Self::described(source, &footer[..footer.len() - TAIL], bytes, origin).map_err(refused)
    }

    fn described(
        source: Source,
        footer: &[u8],
        bytes: usize,
        origin: &str,
    ) -> std::result::Result<Self, Message> {
        check_footer(footer)?;
        let metadata = decoded(|| ParquetMetaDataReader::decode_metadata(footer))
            .map_err(|e| format!("its footer is damaged ({e}); write the file again"))?;
        let (mut attributes, mut fields) = (vec![], HashMap::new());
        for pair in metadata.file_metadata().key_value_metadata().into_iter().flatten() {
            let Some(value) = &pair.value else { continue };
            if pair.key == "ARROW:schema" {
                fields = arrow_schema::fields(value);
            }
            if !PROGRAMS_KEYS.contains(&pair.key.as_str()) {
                attributes.push((pair.key.clone(), value.clone()));
            }
        }
        // The footer says how many cells there are: what is too much is refused before any is decoded.
        let rows = metadata.row_groups().iter().map(|group| group.num_rows().max(0) as usize);
        let width = metadata.file_metadata().schema_descr().num_columns();
        let most = rows.clone().max().unwrap_or(0).saturating_mul(width).saturating_mul(CELL);
        Budget::of(bytes).spend(most)?;
        let mut columns = vec![];
        for column in metadata.file_metadata().schema_descr().columns() {
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
            let unit = match kind {
                Kind::Seconds { .. } => Some("s".to_owned()),
                _ => field.unit,
            };
            let descriptor = Arc::clone(column);
            columns.push(Described { name: name.trim().to_owned(), unit, kind, descriptor });
        }
        if columns.is_empty() {
            return Err("has no columns; write at least one".to_owned());
        }
        let groups = metadata.row_groups().iter().map(|group| Group::of(group, &columns, bytes));
        let groups = groups.collect::<std::result::Result<_, _>>()?;
        Ok(Self { source, origin: origin.to_owned(), bytes, columns, attributes, groups })
    }

    /// Names of the columns.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| &*column.name)
    }

    /// Whether a column holds times, and if so, whether these are UTC.
    pub fn is_utc(&self, column: usize) -> Option<bool> {
        match self.columns.get(column)?.kind {
            Kind::Time { utc, .. } => Some(utc),
            Kind::Date => Some(false),
            _ => None,
        }
    }

    /// Number of row groups.
    pub fn groups(&self) -> usize {
        self.groups.len()
    }

    /// Rows of a row group; 0 of one that is not there.
    pub fn rows(&self, group: usize) -> usize {
        self.groups.get(group).map_or(0, |group| group.rows)
    }

    /// What the footer tells of the cells of a column in a row group.
    pub fn holds(&self, column: usize, group: usize) -> &Holds {
        let chunk = self.groups.get(group).and_then(|group| group.chunks.get(column));
        chunk.map_or(&Holds::Unknown, |chunk| &chunk.holds)
    }

    /// The stored bytes of a row group, column by column, to tell its content apart from another's.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn stored(&self, group: usize) -> Result<Vec<Bytes>> {
        let chunks = self.groups.get(group).map_or(&[][..], |group| &group.chunks);
        chunks.iter().map(|c| self.source.bytes(c.start, c.size, &self.origin)).collect()
    }

    /// Some columns of some row groups, as a sheet. Its rows are numbered as in the file.
    ///
    /// # Errors
    /// As for [`parquet_sheets`].
    pub fn sheet(&self, columns: &[usize], groups: &[usize]) -> Result<Sheet> {
        let refused = |message| Error::Table { origin: self.origin.clone(), message };
        let mut budget = Budget::of(self.bytes);
        let rows: usize = groups.iter().map(|group| self.rows(*group)).sum();
        budget.spend(rows.saturating_mul(columns.len()).saturating_mul(CELL)).map_err(refused)?;
        let mut sheet = Sheet {
            origin: self.origin.clone(),
            attributes: self.attributes.clone(),
            ..Sheet::default()
        };
        for index in columns {
            let Some(column) = self.columns.get(*index) else { continue };
            let mut chunks = vec![];
            for group in groups.iter().filter_map(|group| self.groups.get(*group)) {
                let Some(chunk) = group.chunks.get(*index) else { continue };
                let bytes = match chunk.holds {
                    Holds::Word(_) => Bytes::new(),
                    _ => self.source.bytes(chunk.start, chunk.size, &self.origin)?,
                };
                chunks.push((group.rows, chunk, bytes));
            }
            let cells = decoded(|| read_column(column, chunks, &mut budget))
                .map_err(|e| refused(format!("column \"{}\" cannot be read: {e}", column.name)))?;
            sheet.columns.push(Column {
                name: column.name.clone(),
                unit: column.unit.clone(),
                cells,
            });
        }
        if groups.len() < self.groups.len() {
            let mut begins = vec![];
            let mut next = 1;
            for group in &self.groups {
                begins.push(next);
                next += group.rows;
            }
            let of = |group: &usize| begins[*group]..begins[*group] + self.rows(*group);
            sheet.rows =
                groups.iter().filter(|group| **group < begins.len()).flat_map(of).collect();
        }
        Ok(sheet)
    }
}

impl Source {
    /// The first bytes, the last, and how many there are.
    fn ends(&self, origin: &str) -> Result<(Bytes, Bytes, usize)> {
        let length = match self {
            Self::Memory(bytes) => bytes.len(),
            Self::Disk(path) => {
                let length = std::fs::metadata(path).map(|known| known.len());
                length.map_err(|source| Error::File { path: origin.to_owned(), source })? as usize
            }
        };
        let head = self.bytes(0, length.min(MAGIC.len()), origin)?;
        let tail = length.min(LIKELY_FOOTER);
        Ok((head, self.bytes((length - tail) as u64, tail, origin)?, length))
    }

    fn bytes(&self, start: u64, size: usize, origin: &str) -> Result<Bytes> {
        match self {
            // Chunks were compared with the size of the file.
            Self::Memory(bytes) => Ok(bytes.slice(start as usize..start as usize + size)),
            Self::Disk(path) => {
                let mut bytes = vec![0; size];
                let read = File::open(path).and_then(|mut file| {
                    file.seek(SeekFrom::Start(start))?;
                    file.read_exact(&mut bytes)
                });
                read.map_err(|source| Error::File { path: origin.to_owned(), source })?;
                Ok(bytes.into())
            }
        }
    }
}

impl Group {
    fn of(
        group: &RowGroupMetaData,
        columns: &[Described],
        bytes: usize,
    ) -> std::result::Result<Self, Message> {
        let rows = usize::try_from(group.num_rows()).map_err(|_| "its rows are no number")?;
        let broken = |column: &Described, what: &str| {
            Err(format!("column \"{}\" cannot be read: {what}", column.name))
        };
        let mut chunks = vec![];
        for (k, column) in columns.iter().enumerate() {
            let Some(chunk) = group.columns().get(k) else {
                return broken(column, "a part of the file does not have it");
            };
            if chunk.file_path().is_some() {
                return broken(column, "it is kept in another file");
            }
            let first = match chunk.dictionary_page_offset() {
                Some(offset) if offset > 0 => offset.min(chunk.data_page_offset()),
                _ => chunk.data_page_offset(),
            };
            let size = chunk.compressed_size();
            match (u64::try_from(first), usize::try_from(size)) {
                (Ok(start), Ok(size))
                    if (start as usize).checked_add(size).is_some_and(|end| end <= bytes) =>
                {
                    let compression = chunk.compression();
                    chunks.push(Chunk {
                        start,
                        size,
                        compression,
                        holds: Holds::of(chunk, &column.kind),
                    });
                }
                _ => {
                    return broken(column, "its pages lie outside the file; the file is cut short");
                }
            }
        }
        Ok(Self { rows, chunks })
    }
}

impl Holds {
    fn of(chunk: &ColumnChunkMetaData, kind: &Kind) -> Self {
        let Some(known) = chunk.statistics() else { return Self::Unknown };
        let is_full =
            chunk.column_descr().max_def_level() == 0 || known.null_count_opt() == Some(0);
        match (kind, known) {
            // A word that was cut short for the footer is made larger where it stands for the last: then they differ.
            (Kind::Text, Statistics::ByteArray(known)) if is_full => {
                match (known.min_opt(), known.max_opt()) {
                    (Some(min), Some(max)) if min == max => {
                        min.as_utf8().map_or(Self::Unknown, |word| Self::Word(word.into()))
                    }
                    _ => Self::Unknown,
                }
            }
            (Kind::Time { .. }, Statistics::Int64(known)) if is_full => {
                match (known.min_opt(), known.max_opt()) {
                    (Some(min), Some(max)) => Self::Times(kind.integer(*min), kind.integer(*max)),
                    _ => Self::Unknown,
                }
            }
            _ => Self::Unknown,
        }
    }
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

/// How long the footer is: schema, and where the pages are. `head` and `tail` are the ends of a file of so many bytes.
fn footer_length(head: &[u8], tail: &[u8], bytes: usize) -> std::result::Result<usize, Message> {
    if bytes == 0 {
        return Err("is empty; a Parquet file is needed".to_owned());
    }
    let encrypted = "is encrypted, which is not read; write it without encryption";
    if head.starts_with(MAGIC_ENCRYPTED) {
        return Err(encrypted.to_owned());
    }
    if !head.starts_with(MAGIC) {
        return Err("is not a Parquet file, which begins with \"PAR1\"".to_owned());
    }
    let short = "is cut short: a Parquet file ends with \"PAR1\"; copy or write it again";
    let body = match tail.strip_suffix(MAGIC) {
        Some(body) if bytes >= MAGIC.len() + TAIL => body,
        _ => return Err(short.to_owned()),
    };
    let Some((_, length)) = body.split_last_chunk() else { return Err(short.to_owned()) };
    let length = u32::from_le_bytes(*length) as usize;
    if length > bytes - TAIL - MAGIC.len() {
        return Err(format!(
            "says its footer has {length} bytes, which is more than it has; write it again"
        ));
    }
    Ok(length)
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
#[derive(Debug)]
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

/// The cells of a column, from its chunks with their numbers of rows.
fn read_column(
    column: &Described,
    chunks: Vec<(usize, &Chunk, Bytes)>,
    budget: &mut Budget,
) -> parquet::errors::Result<Cells> {
    let kind = &column.kind;
    let (mut numbers, mut text) = (vec![], vec![]);
    let mut words = Words::default();
    for (rows, chunk, bytes) in chunks {
        if let Holds::Word(word) = &chunk.holds {
            budget.spend(rows * (size_of::<Arc<str>>() - CELL)).map_err(ParquetError::General)?;
            text.resize(text.len() + rows, Arc::clone(word));
            continue;
        }
        let pages = Pages::new(bytes, &column.descriptor, chunk.compression, budget.most())?;
        let pages = Box::new(pages);
        let out = &mut numbers;
        match get_column_reader(Arc::clone(&column.descriptor), pages) {
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
                Kind::Text => read(reader, rows, |v: Option<&ByteArray>| {
                    let value = v.map_or(Ok(""), |v| v.as_utf8());
                    let value = value.map_err(|_| {
                        let what = "a cell is not UTF-8 text; write the file without the column";
                        ParquetError::General(what.to_owned())
                    })?;
                    text.push(words.word(value, budget).map_err(ParquetError::General)?);
                    Ok(())
                })?,
                _ => push(reader, rows, out, |v| kind.bytes(v.data()))?,
            },
        }
    }
    Ok(match kind {
        Kind::Text => Cells::Text(text),
        _ => kind.cells(numbers),
    })
}

/// Words of a column, each kept once as far as there are not too many.
#[derive(Default)]
struct Words {
    known: HashSet<Arc<str>>,
    last: Option<Arc<str>>,
}

impl Words {
    /// A column of more different words is one of texts that hardly come again.
    const MOST: usize = 1 << 16;

    fn word(&mut self, text: &str, budget: &mut Budget) -> std::result::Result<Arc<str>, Message> {
        budget.spend(size_of::<Arc<str>>() - CELL)?;
        if let Some(last) = self.last.as_ref().filter(|last| ***last == *text) {
            return Ok(Arc::clone(last));
        }
        let word = match self.known.get(text) {
            Some(word) => Arc::clone(word),
            None => {
                // Two counts stand before the text.
                budget.spend(text.len() + 2 * size_of::<usize>())?;
                let word: Arc<str> = text.into();
                if self.known.len() < Self::MOST {
                    self.known.insert(Arc::clone(&word));
                }
                word
            }
        };
        self.last = Some(Arc::clone(&word));
        Ok(word)
    }
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
        ColumnChunkMetaData, FileMetaData, ParquetMetaData, ParquetMetaDataWriter, RowGroupMetaData,
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
