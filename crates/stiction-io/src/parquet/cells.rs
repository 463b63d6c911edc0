//! The cells of a column.

use super::group::{Chunk, Holds};
use super::kind::{Described, Kind};
use super::pages::Pages;
use crate::budget::Budget;
use crate::sheet::Cells;
use bytes::Bytes;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType, FixedLenByteArray, Int96};
use parquet::errors::ParquetError;
use std::collections::HashSet;
use std::sync::Arc;

/// Number of bytes that every cell takes; texts take at least as many.
pub const CELL: usize = size_of::<f64>();

/// Number of rows that are decoded at a time.
const BATCH: usize = 8192;

/// The cells of a column, from its chunks with their numbers of rows.
pub fn read_column(
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
            ColumnReader::BoolColumnReader(reader) if matches!(kind, Kind::Text) => {
                read(reader, rows, |v: Option<&bool>| {
                    let value = v.map_or("", |v| if *v { "true" } else { "false" });
                    text.push(words.word(value, budget).map_err(ParquetError::General)?);
                    Ok(())
                })?;
            }
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
        Kind::Text => Cells::Text(text.into()),
        _ => kind.cells(numbers),
    })
}

/// Words of a column, each stored once unless there are too many.
#[derive(Default)]
struct Words {
    known: HashSet<Arc<str>>,
    last: Option<Arc<str>>,
}

impl Words {
    /// A column with more different words holds texts that are rarely repeated.
    const MOST: usize = 1 << 16;

    fn word(&mut self, text: &str, budget: &mut Budget) -> Result<Arc<str>, String> {
        budget.spend(size_of::<Arc<str>>() - CELL)?;
        if let Some(last) = self.last.as_ref().filter(|last| ***last == *text) {
            return Ok(Arc::clone(last));
        }
        let word = match self.known.get(text) {
            Some(word) => Arc::clone(word),
            None => {
                // Two counts precede the text.
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

/// The time in an old timestamp with ns of the day and the Julian day.
fn int96(value: &Int96) -> f64 {
    let &[low, high, day] = value.data() else { return f64::NAN };
    let nanoseconds = u64::from(high) << 32 | u64::from(low);
    (f64::from(day) - 2_440_588.0) * 86_400.0 + nanoseconds as f64 / 1e9
}

/// Appends the `rows` cells of `reader` to `out`, each converted by `number`, or NaN if there is none.
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

/// Passes the `rows` cells of `reader` to `cell`.
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
                "it has {found} of {rows} cells; the file is cut short"
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
