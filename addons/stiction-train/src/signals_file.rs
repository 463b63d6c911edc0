//! The input of the net for simulated loops, as a file for its training.
//!
//! A record for each loop, in the order of the matrix, little endian: its number as u64, its samples as u32 (0
//! without input), zero as u32, the scalars as f32, then [`LENGTH`] samples of [`CHANNELS`] numbers as i16 in
//! [`UNITS`] per one, zero after the last sample.

use anyhow::{Context, Result, ensure};
use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::Path;
use stiction_diagnose::evidence::raw::{CHANNELS, Input, LENGTH, SCALARS};

/// Units per one.
pub const UNITS: f32 = 2000.0;

/// Bytes before the samples of a record, and of the whole record.
const HEAD: usize = 16 + 4 * SCALARS;
const RECORD: usize = HEAD + 2 * LENGTH * CHANNELS;

/// The input for a loop of that number, if there is any.
pub type Record = (u64, Option<Input>);

/// Reads records in batches, and passes all of them to `each`.
///
/// # Errors
/// If the file cannot be read, ends within a record, or `each` fails.
pub fn read(
    path: &Path,
    at_once: usize,
    mut each: impl FnMut(Vec<Record>) -> Result<()>,
) -> Result<()> {
    let mut file = File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
    loop {
        let mut bytes = vec![];
        Read::by_ref(&mut file).take((at_once * RECORD) as u64).read_to_end(&mut bytes)?;
        ensure!(bytes.len() % RECORD == 0, "{} ends within a record", path.display());
        if bytes.is_empty() {
            return Ok(());
        }
        each(bytes.chunks_exact(RECORD).map(record).collect())?;
    }
}

fn record(bytes: &[u8]) -> Record {
    let four = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let index =
        u64::from(u32::from_le_bytes(four(0))) | u64::from(u32::from_le_bytes(four(4))) << 32;
    let samples = u32::from_le_bytes(four(8)) as usize;
    let scalars = std::array::from_fn(|k| f32::from_le_bytes(four(16 + 4 * k)));
    let numbers = bytes[HEAD..].chunks_exact(2);
    let numbers: Vec<f32> =
        numbers.map(|two| f32::from(i16::from_le_bytes([two[0], two[1]])) / UNITS).collect();
    let rows = numbers.chunks_exact(CHANNELS).take(samples);
    let values: Vec<[f32; CHANNELS]> = rows.map(|row| std::array::from_fn(|c| row[c])).collect();
    (index, (samples > 0).then_some(Input { values, scalars }))
}

/// Writes records.
pub struct SignalsFile {
    out: BufWriter<File>,
}

impl SignalsFile {
    /// Creates the file.
    pub fn create(path: &Path) -> Result<Self> {
        let file =
            File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { out: BufWriter::with_capacity(1 << 20, file) })
    }

    /// Appends the input for a loop.
    pub fn add(&mut self, index: u64, heard: Option<&Input>) -> Result<()> {
        let samples = heard.map_or(0, |heard| heard.values.len());
        self.out.write_all(&index.to_le_bytes())?;
        self.out.write_all(&(samples as u32).to_le_bytes())?;
        self.out.write_all(&0u32.to_le_bytes())?;
        let scalars = heard.map_or_else(Default::default, |heard| heard.scalars);
        for value in scalars {
            self.out.write_all(&value.to_le_bytes())?;
        }
        let mut row = Vec::with_capacity(LENGTH * CHANNELS * 2);
        for value in heard.into_iter().flat_map(|heard| heard.values.iter().flatten()) {
            row.extend(((value * UNITS).round() as i16).to_le_bytes());
        }
        row.resize(LENGTH * CHANNELS * 2, 0);
        self.out.write_all(&row)?;
        Ok(())
    }

    /// Finishes the file.
    pub fn finish(mut self) -> Result<()> {
        Ok(self.out.flush()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let path = std::env::temp_dir().join(format!("signals-{}.bin", std::process::id()));
        let heard = Input {
            values: (0..70).map(|k| [k as f32 / 8.0 - 4.0; CHANNELS]).collect(),
            scalars: std::array::from_fn(|k| k as f32),
        };
        let mut file = SignalsFile::create(&path).unwrap();
        file.add(5, Some(&heard)).unwrap();
        file.add(1 << 40, None).unwrap();
        file.finish().unwrap();
        let mut all = vec![];
        read(&path, 1, |records| {
            all.extend(records);
            Ok(())
        })
        .unwrap();
        assert_eq!(all, vec![(5, Some(heard)), (1 << 40, None)]);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        assert!(read(&path, 4, |_| Ok(())).is_err());
        std::fs::remove_file(&path).unwrap();
    }
}
