//! Tables as Parquet files.
//!
//! The text [`COLUMNS`] in the metadata of a file lists units and meanings of its columns.

use crate::store::table::{Cells, Column, Kind, MISSING, Row, Table};
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int32Type, Int64Type,
};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::{KeyValue, ParquetMetaData};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnDescriptor, ColumnPath, Type};
use std::fs::File;
use std::io::Write;
use std::sync::Arc;

/// Key of the metadata with the columns as JSON: name, unit, kind, whether cells may be empty, meaning.
pub const COLUMNS: &str = "stiction:columns";

/// The most rows that are written together.
const GROUP: usize = 1 << 20;

/// Number of rows that are read together.
const BATCH: usize = 1024;

/// Rows as Parquet; equal rows give equal bytes.
///
/// # Errors
/// None is known.
pub fn bytes<R: Row>(rows: &[R]) -> Result<Vec<u8>> {
    let mut writer = Writer::begin(vec![], R::columns())?;
    for rows in rows.chunks(GROUP) {
        writer.write(&R::table(rows))?;
    }
    writer.end()
}

/// A file that is being written.
pub struct Writer<W: Write + Send> {
    columns: Vec<Column>,
    writer: SerializedFileWriter<W>,
}

impl<W: Write + Send> Writer<W> {
    /// Begins a file of such columns.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin(to: W, columns: Vec<Column>) -> Result<Self> {
        let told = serde_json::to_string(&columns)
            .map_err(|e| ParquetError::General(format!("its columns cannot be described: {e}")))?;
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by("stiction".to_owned())
            .set_key_value_metadata(Some(vec![KeyValue::new(COLUMNS.to_owned(), told)]));
        for column in columns.iter().filter(|column| column.kind == Kind::Steps) {
            // Steps from one value to the next are small numbers; as whole ones they would take four bytes each.
            let path = [column.name, "list", "item"].map(str::to_owned).to_vec();
            properties = properties
                .set_column_dictionary_enabled(ColumnPath::from(path.clone()), false)
                .set_column_encoding(ColumnPath::from(path), Encoding::DELTA_BINARY_PACKED);
        }
        let fields = columns.iter().map(|column| Ok(Arc::new(field(column)?)));
        let fields = fields.collect::<Result<_>>()?;
        let schema = Type::group_type_builder("schema").with_fields(fields).build()?;
        let writer = SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties.build()))?;
        Ok(Self { columns, writer })
    }

    /// Writes a table of these columns, in their order, as a row group.
    ///
    /// # Errors
    /// If the table cannot be written, or has different columns.
    pub fn write(&mut self, table: &Table) -> Result<()> {
        let mut group = self.writer.next_row_group()?;
        for (column, (name, cells)) in self.columns.iter().zip(&table.columns) {
            match group.next_column()? {
                Some(mut writer) if name == column.name => {
                    write_column(&mut writer, column, cells)?;
                    writer.close()?;
                }
                _ => return Err(ParquetError::General(format!("it has no column \"{name}\""))),
            }
        }
        group.close()?;
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn end(self) -> Result<W> {
        self.writer.into_inner()
    }
}

/// A column as the schema of a file declares it.
fn field(column: &Column) -> Result<Type> {
    let (physical, logical) = match column.kind {
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Count => (Physical::INT64, None),
        Kind::Flag => (Physical::BOOLEAN, None),
        Kind::Time => (Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MILLIS))),
        Kind::Steps => return steps(column.name),
    };
    let repetition = if column.optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    Type::primitive_type_builder(column.name, physical)
        .with_logical_type(logical)
        .with_repetition(repetition)
        .build()
}

/// A column of lists, of three levels as the format has them.
fn steps(name: &str) -> Result<Type> {
    let item = Type::primitive_type_builder("item", Physical::INT32)
        .with_logical_type(Some(LogicalType::integer(16, true)))
        .with_repetition(Repetition::OPTIONAL)
        .build()?;
    let list = Type::group_type_builder("list")
        .with_repetition(Repetition::REPEATED)
        .with_fields(vec![Arc::new(item)])
        .build()?;
    Type::group_type_builder(name)
        .with_logical_type(Some(LogicalType::List))
        .with_repetition(Repetition::REQUIRED)
        .with_fields(vec![Arc::new(list)])
        .build()
}

fn write_column(
    writer: &mut SerializedColumnWriter<'_>,
    column: &Column,
    cells: &Cells,
) -> Result<()> {
    match (column.kind, cells) {
        (Kind::Text, Cells::Text(cells)) => {
            // Consecutive words are mostly equal.
            let mut last: Option<(&Arc<str>, ByteArray)> = None;
            write_cells::<ByteArrayType, _>(writer, column, cells, |cell| {
                let text = match &last {
                    Some((known, text)) if *known == cell => text.clone(),
                    _ => ByteArray::from(&**cell),
                };
                last = Some((cell, text.clone()));
                text
            })
        }
        (Kind::Number, Cells::Number(cells)) => {
            write_cells::<DoubleType, _>(writer, column, cells, |cell| *cell)
        }
        (Kind::Count | Kind::Time, Cells::Count(cells)) => {
            write_cells::<Int64Type, _>(writer, column, cells, |cell| *cell)
        }
        (Kind::Flag, Cells::Flag(cells)) => {
            write_cells::<BoolType, _>(writer, column, cells, |cell| *cell)
        }
        (Kind::Steps, Cells::Steps(lists)) => write_steps(writer, lists),
        (kind, _) => Err(ParquetError::General(format!(
            "column \"{}\" is not one of {}",
            column.name,
            kind.name()
        ))),
    }
}

fn write_cells<'a, T: DataType, C>(
    writer: &mut SerializedColumnWriter<'_>,
    column: &Column,
    cells: &'a [Option<C>],
    value: impl FnMut(&'a C) -> T::T,
) -> Result<()> {
    let values: Vec<T::T> = cells.iter().flatten().map(value).collect();
    if !column.optional && values.len() < cells.len() {
        return Err(ParquetError::General(format!("column \"{}\" lacks a cell", column.name)));
    }
    // Columns without empty cells have no levels.
    let levels: Option<Vec<i16>> =
        column.optional.then(|| cells.iter().map(|cell| i16::from(cell.is_some())).collect());
    writer.typed::<T>().write_batch(&values, levels.as_deref(), None)?;
    Ok(())
}

/// The levels of lists: an empty list, a missing step, an existing step.
const EMPTY: i16 = 0;
const GONE: i16 = 1;
const THERE: i16 = 2;

fn write_steps(writer: &mut SerializedColumnWriter<'_>, lists: &[Vec<i16>]) -> Result<()> {
    let (mut values, mut levels, mut again) = (vec![], vec![], vec![]);
    for list in lists {
        if list.is_empty() {
            levels.push(EMPTY);
            again.push(0);
        }
        for (k, step) in list.iter().enumerate() {
            again.push(i16::from(k > 0));
            match *step {
                MISSING => levels.push(GONE),
                step => {
                    levels.push(THERE);
                    values.push(i32::from(step));
                }
            }
        }
    }
    writer.typed::<Int32Type>().write_batch(&values, Some(&levels), Some(&again))?;
    Ok(())
}

/// Passes the tables of a file with a `wanted` footer to `take`, some rows each, with all columns or these.
///
/// # Errors
/// If the file cannot be read, or `take` fails.
pub fn read(
    file: File,
    columns: Option<&[&str]>,
    wanted: impl FnOnce(&ParquetMetaData) -> bool,
    mut take: impl FnMut(&Table) -> std::result::Result<(), String>,
) -> std::result::Result<(), String> {
    let wrong = |e: ParquetError| e.to_string();
    let reader = SerializedFileReader::new(file).map_err(wrong)?;
    if !wanted(reader.metadata()) {
        return Ok(());
    }
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    for k in 0..reader.num_row_groups() {
        let group = reader.get_row_group(k).map_err(wrong)?;
        let mut readers = vec![];
        for (k, column) in schema.columns().iter().enumerate() {
            let name = &column.path().parts()[0];
            if columns.is_none_or(|columns| columns.contains(&&**name)) {
                let reader = group.get_column_reader(k).map_err(wrong)?;
                readers.push((name, Some(reader).filter(|_| holds_cells(column))));
            }
        }
        let mut left = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        while left > 0 {
            let rows = left.min(BATCH);
            let mut table = Table::default();
            for (name, reader) in &mut readers {
                let cells =
                    reader.as_mut().map_or(Ok(Cells::Other(rows)), |r| read_column(r, rows));
                let cells = cells.map_err(|e| format!("column \"{name}\" cannot be read: {e}"))?;
                table.columns.push(((*name).clone(), cells));
            }
            take(&table)?;
            left -= rows;
        }
    }
    Ok(())
}

/// Whether the cells of a column are of a kind of [`Cells`].
fn holds_cells(column: &ColumnDescriptor) -> bool {
    match column.physical_type() {
        Physical::INT32 => (column.max_rep_level(), column.max_def_level()) == (1, THERE),
        _ => column.path().parts().len() == 1 && column.max_rep_level() == 0,
    }
}

/// The next cells of a column.
fn read_column(reader: &mut ColumnReader, rows: usize) -> Result<Cells> {
    Ok(match reader {
        ColumnReader::ByteArrayColumnReader(reader) => {
            let mut last: Option<(ByteArray, Arc<str>)> = None;
            Cells::Text(read_cells(reader, rows, |bytes: ByteArray| {
                if let Some((_, text)) = last.as_ref().filter(|(known, _)| *known == bytes) {
                    return Ok(Arc::clone(text));
                }
                let text: Arc<str> = bytes.as_utf8()?.into();
                last = Some((bytes, Arc::clone(&text)));
                Ok(text)
            })?)
        }
        ColumnReader::DoubleColumnReader(reader) => Cells::Number(read_cells(reader, rows, Ok)?),
        ColumnReader::Int64ColumnReader(reader) => Cells::Count(read_cells(reader, rows, Ok)?),
        ColumnReader::BoolColumnReader(reader) => Cells::Flag(read_cells(reader, rows, Ok)?),
        ColumnReader::Int32ColumnReader(reader) => read_steps(reader, rows)?,
        _ => Cells::Other(rows),
    })
}

fn read_cells<T: DataType, C>(
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
    mut cell: impl FnMut(T::T) -> Result<C>,
) -> Result<Vec<Option<C>>> {
    let (mut values, mut levels) = (vec![], vec![]);
    let (count, ..) = reader.read_records(rows, Some(&mut levels), None, &mut values)?;
    all_of(count, rows)?;
    let mut values = values.into_iter();
    let mut next = |k: usize| match levels.get(k).is_none_or(|level| *level > 0) {
        true => values.next().map(&mut cell).transpose(),
        false => Ok(None),
    };
    (0..rows).map(&mut next).collect()
}

fn read_steps(reader: &mut ColumnReaderImpl<Int32Type>, rows: usize) -> Result<Cells> {
    let (mut values, mut levels, mut again) = (vec![], vec![], vec![]);
    let (count, ..) =
        reader.read_records(rows, Some(&mut levels), Some(&mut again), &mut values)?;
    all_of(count, rows)?;
    let beyond = || ParquetError::General("a step does not fit into 16 bits".to_owned());
    let mut lists: Vec<Vec<i16>> = vec![];
    let mut values = values.into_iter();
    for (level, again) in levels.iter().zip(again) {
        if again == 0 {
            lists.push(vec![]);
        }
        let Some(list) = lists.last_mut().filter(|_| *level > EMPTY) else { continue };
        list.push(match *level {
            THERE => values.next().and_then(|step| i16::try_from(step).ok()).ok_or_else(beyond)?,
            _ => MISSING,
        });
    }
    Ok(Cells::Steps(lists))
}

fn all_of(count: usize, rows: usize) -> Result<()> {
    match count == rows {
        true => Ok(()),
        false => Err(ParquetError::General(format!(
            "it has {count} of {rows} cells; the file is incomplete"
        ))),
    }
}
