//! Rows of a long table, sorted into files on disk by who will read them.
//!
//! Where the row groups of a file mix all tags, to read some loops would be to decode all. Then it is decoded once, and
//! what each batch of loops needs is kept in a file of its own until the batch is judged.

use crate::error::{Result, file, store};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, UInt32Type};
use arrow_array::{ArrayRef, DictionaryArray, Float64Array, RecordBatch, StringArray, UInt32Array};
use arrow_ipc::CompressionType;
use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::{IpcWriteOptions, StreamWriter};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction_io::sheet::{Cells, Column, Sheet};

/// Rows that a file collects before they are written.
const ROWS: usize = 8192;

/// Files for so many readers, that are being filled.
pub struct Spill {
    folder: PathBuf,
    parts: Vec<Part>,
}

#[derive(Default)]
struct Part {
    waiting: Option<Sheet>,
    writer: Option<StreamWriter<BufWriter<File>>>,
}

impl Spill {
    /// Begins files in `folder`, which is made.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn begin(folder: &Path, readers: usize) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(file(folder))?;
        let parts = (0..readers).map(|_| Part::default()).collect();
        Ok(Self { folder: folder.to_owned(), parts })
    }

    /// Adds the rows of `sheet`, each for the reader that `of` tells of its index, if any.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn add(&mut self, sheet: &Sheet, of: impl Fn(usize) -> Option<usize>) -> Result<()> {
        let mut rows: HashMap<usize, Vec<usize>> = HashMap::new();
        for row in 0..sheet.len() {
            if let Some(reader) = of(row) {
                rows.entry(reader).or_default().push(row);
            }
        }
        for (reader, rows) in rows {
            let Some(part) = self.parts.get_mut(reader) else { continue };
            match &mut part.waiting {
                None => part.waiting = Some(sheet.rows_at(&rows)),
                Some(waiting) => waiting.append(sheet.rows_at(&rows)),
            }
            if part.waiting.as_ref().is_some_and(|waiting| waiting.len() >= ROWS) {
                part.write(&path(&self.folder, reader))?;
            }
        }
        Ok(())
    }

    /// Ends all files.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn end(mut self) -> Result<()> {
        for (reader, part) in self.parts.iter_mut().enumerate() {
            let path = path(&self.folder, reader);
            part.write(&path)?;
            if let Some(mut writer) = part.writer.take() {
                writer.finish().map_err(|e| store(&path, e))?;
            }
        }
        Ok(())
    }
}

impl Part {
    fn write(&mut self, path: &Path) -> Result<()> {
        let Some(sheet) = self.waiting.take() else { return Ok(()) };
        let wrong = |e: ArrowError| store(path, e);
        let batch = batch(&sheet).map_err(wrong)?;
        if self.writer.is_none() {
            let out = BufWriter::new(File::create(path).map_err(file(path))?);
            let options = IpcWriteOptions::default()
                .try_with_compression(Some(CompressionType::LZ4_FRAME))
                .map_err(wrong)?;
            let writer = StreamWriter::try_new_with_options(out, &batch.schema(), options);
            self.writer = Some(writer.map_err(wrong)?);
        }
        match &mut self.writer {
            Some(writer) => writer.write(&batch).map_err(wrong),
            None => Ok(()),
        }
    }
}

fn path(folder: &Path, reader: usize) -> PathBuf {
    folder.join(format!("{reader:05}.arrow"))
}

/// What was kept in `folder` for a reader, as a sheet like `like`, which has no rows; `None` if there is nothing.
///
/// # Errors
/// If the file cannot be read.
pub fn read(folder: &Path, reader: usize, like: &Sheet) -> Result<Option<Sheet>> {
    let path = path(folder, reader);
    if !path.exists() {
        return Ok(None);
    }
    let wrong = |e: ArrowError| store(&path, e);
    let input = BufReader::new(File::open(&path).map_err(file(&path))?);
    let mut sheet = like.clone();
    let mut words: HashMap<String, Arc<str>> = HashMap::new();
    for batch in StreamReader::try_new(input, None).map_err(wrong)? {
        let batch = batch.map_err(wrong)?;
        let (rows, columns) = batch.columns().split_at(1);
        sheet
            .rows
            .extend(rows[0].as_primitive::<UInt32Type>().values().iter().map(|row| *row as usize));
        for (column, array) in sheet.columns.iter_mut().zip(columns) {
            match &mut column.cells {
                Cells::Numbers(cells) | Cells::Times { seconds: cells, .. } => {
                    cells.extend(array.as_primitive::<Float64Type>().values());
                }
                Cells::Text(cells) => {
                    let array = array.as_dictionary::<Int32Type>();
                    let known = array.values().as_string::<i32>();
                    let mut word = |text: &str| match words.get(text) {
                        Some(word) => Arc::clone(word),
                        None => {
                            let word: Arc<str> = text.into();
                            words.insert(text.to_owned(), Arc::clone(&word));
                            word
                        }
                    };
                    let known: Vec<Arc<str>> =
                        known.iter().map(|text| word(text.unwrap_or(""))).collect();
                    let keys = array.keys().values().iter();
                    cells.extend(keys.map(|key| Arc::clone(&known[*key as usize])));
                }
            }
        }
    }
    Ok(Some(sheet))
}

fn batch(sheet: &Sheet) -> std::result::Result<RecordBatch, ArrowError> {
    let rows: UInt32Array =
        (0..sheet.len()).map(|row| u32::try_from(sheet.row(row)).ok()).collect();
    let mut fields = vec![Field::new("row", DataType::UInt32, true)];
    let mut arrays: Vec<ArrayRef> = vec![Arc::new(rows)];
    for Column { name, cells, .. } in &sheet.columns {
        let array: ArrayRef = match cells {
            Cells::Numbers(cells) | Cells::Times { seconds: cells, .. } => {
                Arc::new(Float64Array::from(cells.clone()))
            }
            Cells::Text(cells) => {
                let mut keys: HashMap<&str, i32> = HashMap::new();
                let mut known: Vec<&str> = vec![];
                // Words that follow each other are mostly one and the same.
                let mut last: Option<(&Arc<str>, i32)> = None;
                let mut key = |cell| match last {
                    Some((known, key)) if Arc::ptr_eq(known, cell) => key,
                    _ => {
                        let key = *keys.entry(&**cell).or_insert_with(|| {
                            known.push(cell);
                            known.len() as i32 - 1
                        });
                        last = Some((cell, key));
                        key
                    }
                };
                let keys: Vec<i32> = cells.iter().map(&mut key).collect();
                let words = Arc::new(StringArray::from(known));
                Arc::new(DictionaryArray::<Int32Type>::try_new(keys.into(), words)?)
            }
        };
        fields.push(Field::new(name, array.data_type().clone(), true));
        arrays.push(array);
    }
    RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_to_whom_they_belong() {
        let folder = std::env::temp_dir().join(format!("stiction-spill-{}", std::process::id()));
        let tags = ["A", "B", "A", "C"];
        let column = |name: &str, cells| Column { name: name.to_owned(), unit: None, cells };
        let sheet = Sheet {
            columns: vec![
                column("time", Cells::Times { seconds: vec![1.0, 2.0, 3.0, 4.0], utc: true }),
                column("tag", Cells::Text(tags.iter().map(|tag| (*tag).into()).collect())),
                column("value", Cells::Numbers(vec![0.5, f64::NAN, 1.5, 2.5])),
            ],
            ..Sheet::default()
        };
        let mut spill = Spill::begin(&folder, 3).unwrap();
        for _ in 0..ROWS {
            spill.add(&sheet, |row| ["A", "B"].iter().position(|tag| *tag == tags[row])).unwrap();
        }
        spill.end().unwrap();
        let like = sheet.rows_at(&[]);
        let a = read(&folder, 0, &like).unwrap().unwrap();
        assert_eq!((a.len(), a.rows[..2].to_vec()), (2 * ROWS, vec![1, 3]));
        assert_eq!(a.rows_at(&[2, 3]).columns, sheet.rows_at(&[0, 2]).columns);
        let Cells::Numbers(b) = &read(&folder, 1, &like).unwrap().unwrap().columns[2].cells.clone()
        else {
            panic!("numbers")
        };
        assert!(b.len() == ROWS && b.iter().all(|value| value.is_nan()));
        assert_eq!(read(&folder, 2, &like).unwrap(), None);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
