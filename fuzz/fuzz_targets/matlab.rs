//! Any bytes are a MATLAB file or an error.
#![no_main]

mod panics;

use libfuzzer_sys::fuzz_target;
use stiction_io::matlab::matlab_sheets;

fuzz_target!(init: panics::ignore_decoders(), |bytes: &[u8]| {
    let Ok(sheets) = matlab_sheets(bytes, "fuzz.mat") else { return };
    for sheet in sheets {
        assert!(sheet.columns.iter().all(|column| column.cells.len() == sheet.len()));
        assert!(!sheet.is_empty());
    }
});
