//! Reads the files that arguments name, standard input for `-`, and the databases of addresses.

use crate::files::In;
use crate::watch;
use std::process::{ExitCode, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use stiction::recording::Recording;
use stiction_io::timestamp::Clock;
use stiction_io::{Error, ReadOptions, Reading, Result, Table, bytes, reading};

/// The recordings in a file of any format.
pub fn recordings(file: &In, options: &ReadOptions) -> Result<Reading> {
    match is_on_disk(file) {
        true => reading::read(file, options),
        false => reading::parse(&all(file)?, &file.origin(), options),
    }
}

/// Passes the recordings in a file of any format to `visit`, one after the other, each with the clock of the file.
pub fn visit(
    file: &In,
    options: &ReadOptions,
    visit: &mut dyn FnMut(Recording, &Clock),
) -> Result<Reading> {
    if is_on_disk(file) {
        return reading::visit(file, options, visit);
    }
    let mut reading = recordings(file, options)?;
    for recording in std::mem::take(&mut reading.recordings) {
        visit(recording, &reading.time.clock);
    }
    Ok(reading)
}

/// Whether an argument names a file, and neither standard input nor a database.
fn is_on_disk(file: &In) -> bool {
    !file.is_standard() && !file.to_str().is_some_and(watch::is_address)
}

/// The recordings in a file, and the mapping file by which they are read again.
pub fn with_mapping(file: &In, options: &ReadOptions) -> Result<(Reading, String)> {
    let (bytes, origin) = (all(file)?, file.origin());
    let mapping = reading::mapping_of(&bytes, &origin, options)?;
    Ok((reading::parse(&bytes, &origin, options)?, mapping))
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
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let origin = watch::without_secrets(address);
    let refused = |message: String| Error::Table { origin: origin.clone(), message };
    // Files are read side by side, so each address has a folder of its own. One that exists is not ours.
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("stiction-{}-{count}", std::process::id()));
    std::fs::create_dir(&folder).map_err(|e| refused(format!("{}: {e}", folder.display())))?;
    let path = folder.join("day.parquet");
    let fetched = watch::collector("fetch").and_then(|mut collector| {
        watch::ended(collector.arg(address).arg("--output").arg(&path).stdout(Stdio::null()))
    });
    let read = match fetched {
        Ok(code) if code == ExitCode::SUCCESS => bytes::read(&path),
        Ok(_) => Err(refused("the table was not read".to_owned())),
        Err(error) => Err(refused(format!("{error:#}"))),
    };
    // A failed removal leaves a file in the folder of temporary files, and changes no result.
    let _ = std::fs::remove_dir_all(&folder);
    read
}
