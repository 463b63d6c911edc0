//! Sheets from Parquet files.
//!
//! The `parquet` crate decodes the schema and the values. Sizes and counts that it would trust unchecked are checked
//! here first, in `footer` for the footer and in `pages` for pages.

mod arrow_schema;
mod cells;
mod footer;
mod group;
mod kind;
mod pages;
mod source;
mod thrift;

pub use group::Holds;

use crate::budget::{Budget, guarded};
use crate::columns::role;
use crate::error::{Error, Result};
use crate::sheet::{Column, Sheet};
use bytes::Bytes;
use cells::{CELL, read_column};
use footer::{MAGIC, TAIL, check_footer, footer_length};
use group::Group;
use kind::{Described, Kind};
use parquet::basic::Type;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaDataReader;
use source::Source;
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// Keys of a file with values for programs, not readers.
const PROGRAMS_KEYS: [&str; 2] = ["ARROW:schema", "pandas"];

/// The table in a Parquet file, as one sheet; `origin` is the name of the file in errors.
///
/// Numbers of all kinds, and true and false as 1 and 0, are numbers, except that qualities are the words true and false.
/// Durations and times of day are numbers in s. Dates and timestamps are times. Units come from the metadata of Arrow's
/// fields (`unit` or `units`), and attributes from the metadata of the file. Pages may be compressed with Snappy, GZIP, Brotli, Zstandard or LZ4 (raw).
///
/// # Errors
/// If the file is cut short, damaged or encrypted, has no columns, or a column is nested, binary or in an encoding
/// that is not read.
///
/// # Limits
/// A file that would take more than 64 MiB and 256 times its size, or more than 4 GiB, is refused because of the
/// sizes in its footer.
pub fn parquet_sheets(bytes: &[u8], origin: &str) -> Result<Vec<Sheet>> {
    let file = ParquetFile::of(Source::Memory(Bytes::copy_from_slice(bytes)), origin)?;
    let groups: Vec<usize> = (0..file.groups.len()).collect();
    let columns: Vec<usize> = (0..file.columns.len()).collect();
    Ok(vec![file.sheet(&columns, &groups)?])
}

/// A Parquet file with its footer read. Its columns and row groups can be read separately.
#[derive(Debug)]
pub struct ParquetFile {
    source: Source,
    origin: String,
    bytes: usize,
    columns: Vec<Described>,
    attributes: Vec<(String, String)>,
    groups: Vec<Group>,
}

impl ParquetFile {
    /// Whether the file at `path` begins like Parquet.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn is_one(path: &Path) -> Result<bool> {
        let mut head = vec![];
        let read = File::open(path).and_then(|file| file.take(4).read_to_end(&mut head));
        read.map_err(|source| Error::File { path: path.display().to_string(), source })?;
        Ok(head == MAGIC)
    }

    /// Reads the footer of the file at `path`.
    ///
    /// # Errors
    /// As for [`parquet_sheets`], as far as the footer shows.
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
    ) -> std::result::Result<Self, String> {
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
        // The footer gives the number of cells. Too many are refused before any is decoded.
        let rows = metadata.row_groups().iter().map(|group| group.num_rows().max(0) as usize);
        let width = metadata.file_metadata().schema_descr().num_columns();
        let most = rows.clone().max().unwrap_or(0).saturating_mul(width).saturating_mul(CELL);
        Budget::of(bytes).spend(most)?;
        let mut columns = vec![];
        for column in metadata.file_metadata().schema_descr().columns() {
            let name = column.path().string();
            if column.path().parts().len() > 1 || column.max_rep_level() > 0 {
                return Err(format!(
                    "column \"{name}\" is nested or a list; write the file without it, or with one number or text \
                     per row"
                ));
            }
            let field = fields.remove(&name).unwrap_or_default();
            // The number 1 as a quality would be ambiguous.
            let is_text = column.physical_type() == Type::BOOLEAN && role::is_of_quality(&name);
            let kind = if is_text { Ok(Kind::Text) } else { Kind::of(column, &field) };
            let kind = kind
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

    /// Number of rows of a row group; 0 if the group does not exist.
    pub fn rows(&self, group: usize) -> usize {
        self.groups.get(group).map_or(0, |group| group.rows)
    }

    /// The footer's information on the cells of a column in a row group.
    pub fn holds(&self, column: usize, group: usize) -> &Holds {
        let chunk = self.groups.get(group).and_then(|group| group.chunks.get(column));
        chunk.map_or(&Holds::Unknown, |chunk| &chunk.holds)
    }

    /// The stored bytes of a row group, column by column, to distinguish its content from another's.
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

/// Decodes with the parquet crate, and turns panics into errors.
fn decoded<T>(
    decode: impl FnOnce() -> parquet::errors::Result<T>,
) -> std::result::Result<T, String> {
    match guarded(decode) {
        Some(Ok(value)) => Ok(value),
        Some(Err(ParquetError::General(message))) => Err(message),
        Some(Err(other)) => Err(other.to_string()),
        None => Err("its contents are inconsistent; the file is damaged".to_owned()),
    }
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
