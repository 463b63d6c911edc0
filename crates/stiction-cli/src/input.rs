//! Reads the files that arguments name, and standard input for `-`.

use crate::files::In;
use stiction_io::{ReadOptions, Reading, Result, Table, bytes, reading};

/// The recordings in a file of any format.
pub fn recordings(file: &In, options: &ReadOptions) -> Result<Reading> {
    reading::parse(&all(file)?, &file.origin(), options)
}

/// A table of signals or an index.
pub fn table(file: &In) -> Result<Table> {
    Table::parse(&all(file)?, &file.origin())
}

/// A mapping file.
pub fn mapping(file: &In) -> anyhow::Result<ReadOptions> {
    if file.is_standard() {
        anyhow::bail!("a mapping cannot be read from standard input; name a file");
    }
    Ok(ReadOptions::read(file)?)
}

fn all(file: &In) -> Result<Vec<u8>> {
    if file.is_standard() {
        return bytes::of_stream(std::io::stdin().lock(), &file.origin());
    }
    bytes::read(file)
}
