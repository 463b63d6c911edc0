//! Any bytes are a Parquet file or an error.
#![no_main]

mod panics;

use libfuzzer_sys::fuzz_target;
use stiction_io::parquet::parquet_sheets;

fuzz_target!(init: panics::ignore_decoders(), |bytes: &[u8]| {
    let Ok(sheets) = parquet_sheets(bytes, "fuzz.parquet") else { return };
    for sheet in sheets {
        assert!(sheet.columns.iter().all(|column| column.cells.len() == sheet.len()));
    }
});
