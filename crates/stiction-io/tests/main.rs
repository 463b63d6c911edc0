//! The tests of `stiction-io`, in one program: linking is what takes long.

mod corpus;
mod damaged;
mod docs;
mod layouts;
mod level5;
mod matlab;
mod naming;
mod numbers;
mod parquet;
mod reading;
mod real_recordings;
mod scenario;
mod table;
mod times;
mod wide;
#[cfg(feature = "spreadsheet")]
mod workbook;
mod written;

use stiction_io::Reading;

/// The bytes of a file of the folder `fixtures`.
fn fixture(name: &str) -> Vec<u8> {
    let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(path).expect("a fixture")
}

/// Everything that is said beside what is read.
fn said(reading: &Reading) -> String {
    let own = reading.recordings.iter().flat_map(|recording| &recording.notes);
    reading.notes.iter().chain(own).cloned().collect::<Vec<_>>().join("\n")
}
