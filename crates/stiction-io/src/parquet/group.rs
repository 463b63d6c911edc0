//! Row groups, as described in the footer.

use super::kind::{Described, Kind};
use parquet::basic::Compression;
use parquet::file::metadata::{ColumnChunkMetaData, RowGroupMetaData};
use parquet::file::statistics::Statistics;
use std::sync::Arc;

/// A row group, as described in the footer.
#[derive(Debug)]
pub struct Group {
    pub rows: usize,
    pub chunks: Vec<Chunk>,
}

/// The place of the pages of a column of a row group.
#[derive(Debug)]
pub struct Chunk {
    pub start: u64,
    pub size: usize,
    pub compression: Compression,
    pub holds: Holds,
}

/// The footer's information on the cells of a column of a row group.
#[derive(Debug, Clone, PartialEq)]
pub enum Holds {
    /// No information.
    Unknown,
    /// All cells are this word.
    Word(Arc<str>),
    /// All cells are times from the first to the second, s since 1970-01-01.
    Times(f64, f64),
}

impl Group {
    pub fn of(
        group: &RowGroupMetaData,
        columns: &[Described],
        bytes: usize,
    ) -> Result<Self, String> {
        let rows =
            usize::try_from(group.num_rows()).map_err(|_| "its number of rows is invalid")?;
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
            // A word shortened for the footer is increased as the maximum, so the two then differ.
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
