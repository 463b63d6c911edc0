//! The source of a file's bytes.

use super::footer::MAGIC;
use crate::error::{Error, Result};
use bytes::Bytes;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::PathBuf;

/// Bytes read from the end at once. Most footers are shorter.
const LIKELY_FOOTER: usize = 64 << 10;

/// The source of a file's bytes.
#[derive(Debug)]
pub enum Source {
    Memory(Bytes),
    Disk(PathBuf),
}

impl Source {
    /// The first bytes, the last bytes, and the total number.
    pub fn ends(&self, origin: &str) -> Result<(Bytes, Bytes, usize)> {
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

    pub fn bytes(&self, start: u64, size: usize, origin: &str) -> Result<Bytes> {
        match self {
            // Chunks were already compared with the size of the file.
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
