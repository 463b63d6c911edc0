//! Rows of a long table, sorted into files on disk by reader.
//!
//! If the row groups of a file mix all tags, reading some loops means decoding all rows. Then the file is decoded once.
//! The rows of each batch of loops are kept in a separate file until the batch is judged.

use crate::error::{Result, file, store};
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stiction_io::sheet::{Cells, Sheet};

/// Number of rows that a file collects before they are written.
const ROWS: usize = 8192;

/// Files for a number of readers, being filled.
pub struct Spill {
    folder: PathBuf,
    parts: Vec<Part>,
}

#[derive(Default)]
struct Part {
    waiting: Option<Sheet>,
    writer: Option<BufWriter<File>>,
}

impl Spill {
    /// Creates `folder` and begins its files.
    ///
    /// # Errors
    /// If the folder cannot be created.
    pub fn begin(folder: &Path, readers: usize) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(file(folder))?;
        let parts = (0..readers).map(|_| Part::default()).collect();
        Ok(Self { folder: folder.to_owned(), parts })
    }

    /// Adds the rows of `sheet`, each for the reader that `of` gives for its index, if any.
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
                writer.flush().map_err(file(&path))?;
            }
        }
        Ok(())
    }
}

impl Part {
    fn write(&mut self, path: &Path) -> Result<()> {
        let Some(sheet) = self.waiting.take() else { return Ok(()) };
        let writer = match &mut self.writer {
            Some(writer) => writer,
            writer => writer.insert(BufWriter::new(File::create(path).map_err(file(path))?)),
        };
        let block = lz4_flex::compress_prepend_size(&block(&sheet));
        let length = (block.len() as u32).to_le_bytes();
        let written = writer.write_all(&length).and_then(|()| writer.write_all(&block));
        written.map_err(file(path))
    }
}

fn path(folder: &Path, reader: usize) -> PathBuf {
    folder.join(format!("{reader:05}.rows"))
}

/// The rows in `folder` for a reader, as a sheet like the empty `like`; `None` if there are none.
///
/// # Errors
/// If the file cannot be read.
pub fn read(folder: &Path, reader: usize, like: &Sheet) -> Result<Option<Sheet>> {
    let path = path(folder, reader);
    if !path.exists() {
        return Ok(None);
    }
    let mut input = BufReader::new(File::open(&path).map_err(file(&path))?);
    let mut sheet = like.clone();
    let mut words: HashSet<Arc<str>> = HashSet::new();
    let damaged = || store(&path, "is damaged; scan again");
    let mut length = [0; 4];
    while !input.fill_buf().map_err(file(&path))?.is_empty() {
        input.read_exact(&mut length).map_err(file(&path))?;
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize];
        input.read_exact(&mut bytes).map_err(file(&path))?;
        let block = lz4_flex::decompress_size_prepended(&bytes).map_err(|_| damaged())?;
        take(&block, &mut sheet, &mut words).ok_or_else(damaged)?;
    }
    Ok(Some(sheet))
}

/// Rows, column by column. First come the number of rows and their row numbers. Then each column has its numbers, or
/// its words and an index of a word for each row. Counts and places take four bytes, numbers eight, little-endian.
fn block(sheet: &Sheet) -> Vec<u8> {
    let mut block = vec![];
    let count = |block: &mut Vec<u8>, n: usize| block.extend((n as u32).to_le_bytes());
    count(&mut block, sheet.len());
    (0..sheet.len()).for_each(|row| count(&mut block, sheet.row(row)));
    for column in &sheet.columns {
        match &column.cells {
            Cells::Numbers(cells) | Cells::Times { seconds: cells, .. } => {
                block.extend(cells.iter().flat_map(|cell| cell.to_le_bytes()));
            }
            Cells::Text(cells) => {
                let mut places: HashMap<&str, usize> = HashMap::new();
                let mut known: Vec<&str> = vec![];
                // Consecutive words are mostly equal.
                let mut last: Option<(&str, usize)> = None;
                let cells = cells.view();
                for cell in cells.iter() {
                    let place = match last {
                        Some((word, place)) if word == cell => place,
                        _ => *places.entry(cell).or_insert_with(|| {
                            known.push(cell);
                            known.len() - 1
                        }),
                    };
                    last = Some((cell, place));
                    count(&mut block, place);
                }
                count(&mut block, known.len());
                for word in known {
                    count(&mut block, word.len());
                    block.extend(word.as_bytes());
                }
            }
        }
    }
    block
}

/// Appends the rows of a block to a sheet; `None` if it is not a block.
fn take(mut block: &[u8], sheet: &mut Sheet, words: &mut HashSet<Arc<str>>) -> Option<()> {
    fn count(block: &mut &[u8]) -> Option<usize> {
        Some(u32::from_le_bytes(*block.split_off(..4)?.first_chunk()?) as usize)
    }
    let block = &mut block;
    let rows = count(block)?;
    for _ in 0..rows {
        sheet.rows.push(count(block)?);
    }
    for column in &mut sheet.columns {
        match &mut column.cells {
            Cells::Numbers(cells) | Cells::Times { seconds: cells, .. } => {
                let (numbers, _) = block.split_off(..8 * rows)?.as_chunks();
                cells.extend(numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)));
            }
            Cells::Text(cells) => {
                let (places, _) = block.split_off(..4 * rows)?.as_chunks();
                let mut known: Vec<Arc<str>> = vec![];
                for _ in 0..count(block)? {
                    let length = count(block)?;
                    let word = std::str::from_utf8(block.split_off(..length)?).ok()?;
                    let word = words.get(word).cloned().unwrap_or_else(|| word.into());
                    words.insert(Arc::clone(&word));
                    known.push(word);
                }
                for place in places {
                    cells.push(Arc::clone(known.get(u32::from_le_bytes(*place) as usize)?));
                }
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_io::sheet::Column;

    #[test]
    fn rows_come_back_to_whom_they_belong() {
        let folder = std::env::temp_dir().join(format!("stiction-spill-{}", std::process::id()));
        let tags = ["A", "B", "A", "C"];
        let column = |name: &str, cells| Column { name: name.to_owned(), unit: None, cells };
        let sheet = Sheet {
            columns: vec![
                column("time", Cells::Times { seconds: vec![1.0, 2.0, 3.0, 4.0], utc: true }),
                column("tag", Cells::Text(tags.iter().copied().collect())),
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
