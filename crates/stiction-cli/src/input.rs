//! Reads the files that arguments name, standard input for `-`, and the databases of addresses.

use crate::files::In;
use crate::watch;
use std::process::{ExitCode, Stdio};
use stiction_io::{Error, ReadOptions, Reading, Result, Table, bytes, reading};

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
    match file.to_str().filter(|source| watch::is_address(source)) {
        Some(address) => last_day(address),
        None => bytes::read(file),
    }
}

/// The last day of a table in a database, as Parquet. The collector writes its own messages to standard error.
fn last_day(address: &str) -> Result<Vec<u8>> {
    let refused = |message: String| Error::Table { origin: address.to_owned(), message };
    let name = format!("stiction-{}.parquet", std::process::id());
    let path = std::env::temp_dir().join(name);
    let fetched = watch::collector("fetch").and_then(|mut collector| {
        watch::ended(collector.arg(address).arg("--output").arg(&path).stdout(Stdio::null()))
    });
    let read = match fetched {
        Ok(code) if code == ExitCode::SUCCESS => bytes::read(&path),
        Ok(_) => Err(refused("the table was not read".to_owned())),
        Err(error) => Err(refused(format!("{error:#}"))),
    };
    // A failed removal leaves a file in the folder of temporary files, and changes no result.
    let _ = std::fs::remove_file(&path);
    read
}
